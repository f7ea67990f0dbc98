//! Ipopt's options, by name and in order.

use std::{
    ffi::{CStr, CString},
    fmt,
};

use ipopt_sys as sys;
use thiserror::Error;

use crate::nlp::Structure;

/// Variables above which MUMPS is asked for a nested-dissection ordering; its own choice, minimum fill, takes twice
/// the operations on large meshes.
const LARGE: usize = 10_000;

/// A value of an option.
#[derive(Debug, Clone, PartialEq)]
pub enum OptionValue {
    /// One of a set of words, or a file name.
    Text(String),
    /// A real number.
    Number(f64),
    /// An integer; also taken where Ipopt wants a real number.
    Integer(i32),
}

impl From<&str> for OptionValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for OptionValue {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

/// "yes" or "no".
impl From<bool> for OptionValue {
    fn from(value: bool) -> Self {
        Self::from(if value { "yes" } else { "no" })
    }
}

impl From<f64> for OptionValue {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<i32> for OptionValue {
    fn from(value: i32) -> Self {
        Self::Integer(value)
    }
}

/// For limits and counts: whatever exceeds an `i32` is as good as its maximum.
impl From<usize> for OptionValue {
    fn from(value: usize) -> Self {
        Self::Integer(i32::try_from(value).unwrap_or(i32::MAX))
    }
}

impl fmt::Display for OptionValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(value) => write!(f, "{value:?}"),
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Integer(value) => write!(f, "{value}"),
        }
    }
}

/// An option Ipopt would not take.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OptionError {
    /// No such name.
    #[error(
        "Ipopt has no option `{name}` (set to {value}): its manual and version say which it has"
    )]
    Unknown {
        /// The name.
        name: String,
        /// The value it was to have.
        value: OptionValue,
    },
    /// A number for a word, or so.
    #[error("Ipopt's option `{name}` was set to {value} and takes {expected}")]
    WrongType {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// What it takes instead.
        expected: String,
    },
    /// Of the right type, but not allowed.
    #[error(
        "Ipopt's option `{name}` was set to {value}, which is not allowed: it takes {expected}"
    )]
    Invalid {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// What it takes instead.
        expected: String,
    },
}

/// Options to set, in order. Those not named keep the driver's defaults, then Ipopt's.
///
/// The driver's defaults, all of which can be set otherwise:
///
/// | option | value | why |
/// |---|---|---|
/// | `option_file_name` | `""` | an `ipopt.opt` in the working directory is nobody's intention |
/// | `print_level`, `sb` | 0, `yes` | the log is for those who ask |
/// | `bound_relax_factor` | 0 | Ipopt's 1e-8 would be a real penetration |
/// | `mumps_mem_percent` | 200 | 1000 (Ipopt's) estimates eleven times the workspace, 50 too little: factorisations are repeated |
/// | `mumps_pivot_order` | 5 above 10 000 variables | nested dissection: half the operations |
/// | `hessian_approximation` | `limited-memory` without a Hessian | |
/// | `hessian_constant`, `jac_c_constant`, `jac_d_constant` | as [`Structure`] promises | evaluated once |
/// | `warm_start_init_point` | `yes` for a start with multipliers | they would be ignored |
/// | `timing_statistics` | `yes` where there is one | [`Statistics`](super::Statistics) |
///
/// `check_derivatives_for_naninf` stays off: every value of every function is checked before Ipopt sees it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    entries: Vec<(String, OptionValue)>,
}

impl Options {
    /// None set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets one, in place of an earlier value. Names and values are checked by the solver.
    pub fn set(&mut self, name: &str, value: impl Into<OptionValue>) -> &mut Self {
        let value = value.into();
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.entries.push((name.to_owned(), value)),
        }
        self
    }

    /// Sets one, as [`Options::set`].
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<OptionValue>) -> Self {
        self.set(name, value);
        self
    }

    /// These, and on top of them `others`.
    #[must_use]
    pub fn and(mut self, others: &Options) -> Self {
        for (name, value) in others.iter() {
            self.set(name, value.clone());
        }
        self
    }

    /// What was set for `name`.
    pub fn get(&self, name: &str) -> Option<&OptionValue> {
        self.entries
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }

    /// All that were set, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &OptionValue)> {
        self.entries
            .iter()
            .map(|(name, value)| (name.as_str(), value))
    }

    /// For a start close to the solution, with its multipliers: adaptive μ, and pushes from the bounds small enough
    /// not to spoil it. Sets only what is not set yet.
    #[must_use]
    pub fn warm_start(mut self) -> Self {
        self.set_if_unset("mu_strategy", "adaptive");
        for name in [
            "warm_start_bound_push",
            "warm_start_bound_frac",
            "warm_start_slack_bound_push",
            "warm_start_slack_bound_frac",
            "warm_start_mult_bound_push",
        ] {
            self.set_if_unset(name, 1e-9);
        }
        self
    }

    /// For convex quadratic problems: Mehrotra's predictor–corrector. It has no safeguards: keep a fallback.
    #[must_use]
    pub fn convex_quadratic(mut self) -> Self {
        self.set_if_unset("mehrotra_algorithm", "yes");
        self
    }

    fn set_if_unset(&mut self, name: &str, value: impl Into<OptionValue>) {
        if self.get(name).is_none() {
            self.set(name, value);
        }
    }
}

/// The driver's defaults for a problem.
fn defaults(structure: &Structure) -> Options {
    let mut options = Options::new()
        .with("option_file_name", "")
        .with("print_level", 0)
        .with("sb", true)
        .with("bound_relax_factor", 0.0)
        .with("mumps_mem_percent", 200)
        .with("timing_statistics", true)
        .with("hessian_constant", structure.hessian_constant())
        .with("jac_c_constant", structure.jacobian_constant())
        .with("jac_d_constant", structure.jacobian_constant());
    if structure.hessian().is_none() {
        options.set("hessian_approximation", "limited-memory");
        options.set("hessian_constant", false);
    }
    if structure.variables() > LARGE {
        options.set("mumps_pivot_order", 5);
    }
    options
}

/// Sets the defaults Ipopt knows, then `options`, from a clean slate.
///
/// # Safety
/// `shim` must be valid, and Ipopt this thread's alone.
pub(super) unsafe fn apply(
    shim: *mut sys::ipopt_shim,
    structure: &Structure,
    options: &Options,
) -> Result<(), OptionError> {
    // SAFETY: the caller's promise, here and below.
    unsafe { sys::ipopt_shim_clear_options(shim) };
    for (name, value) in defaults(structure).iter() {
        // SAFETY: as above.
        match unsafe { apply_one(shim, name, value) } {
            // Not every version has every one of them.
            Ok(()) | Err(OptionError::Unknown { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    for (name, value) in options.iter() {
        // SAFETY: as above.
        unsafe { apply_one(shim, name, value) }?;
        if name == "hessian_approximation"
            && structure.hessian().is_none()
            && *value != "limited-memory".into()
        {
            // Ipopt would take the Hessian for zero.
            return Err(OptionError::Invalid {
                name: name.to_owned(),
                value: value.clone(),
                expected: "\"limited-memory\", as the structure has no Hessian".to_owned(),
            });
        }
    }
    Ok(())
}

/// # Safety
/// As [`apply`].
pub(super) unsafe fn apply_one(
    shim: *mut sys::ipopt_shim,
    name: &str,
    value: &OptionValue,
) -> Result<(), OptionError> {
    let unknown = || OptionError::Unknown {
        name: name.to_owned(),
        value: value.clone(),
    };
    let c_name = CString::new(name).map_err(|_| unknown())?;
    // SAFETY: `shim` is valid by the caller's promise, here and below, and `c_name` is a C string.
    let kind = match unsafe { sys::ipopt_shim_option_type(shim, c_name.as_ptr()) }.unsigned_abs() {
        sys::IPOPT_SHIM_OPTION_UNKNOWN => return Err(unknown()),
        kind => kind,
    };
    let expected = || {
        let mut text = [0; 2048];
        // SAFETY: `text` has the size given.
        unsafe {
            sys::ipopt_shim_option_range(shim, c_name.as_ptr(), text.as_mut_ptr(), text.len())
        };
        // SAFETY: the shim ends what it writes with 0, and `text` was 0 before.
        unsafe { CStr::from_ptr(text.as_ptr()) }
            .to_string_lossy()
            .into_owned()
    };
    let set = match (kind, value) {
        (sys::IPOPT_SHIM_OPTION_TEXT, OptionValue::Text(text)) => match CString::new(text.as_str())
        {
            // SAFETY: both are C strings.
            Ok(text) => unsafe { sys::ipopt_shim_set_text(shim, c_name.as_ptr(), text.as_ptr()) },
            Err(_) => 0,
        },
        (sys::IPOPT_SHIM_OPTION_NUMBER, OptionValue::Number(number)) if number.is_nan() => 0,
        (sys::IPOPT_SHIM_OPTION_NUMBER, OptionValue::Number(number)) => {
            // SAFETY: as above.
            unsafe { sys::ipopt_shim_set_number(shim, c_name.as_ptr(), *number) }
        }
        (sys::IPOPT_SHIM_OPTION_NUMBER, OptionValue::Integer(integer)) => {
            // SAFETY: as above.
            unsafe { sys::ipopt_shim_set_number(shim, c_name.as_ptr(), f64::from(*integer)) }
        }
        (sys::IPOPT_SHIM_OPTION_INTEGER, OptionValue::Integer(integer)) => {
            // SAFETY: as above.
            unsafe { sys::ipopt_shim_set_integer(shim, c_name.as_ptr(), *integer) }
        }
        _ => {
            return Err(OptionError::WrongType {
                name: name.to_owned(),
                value: value.clone(),
                expected: expected(),
            });
        }
    };
    if set == 0 {
        return Err(OptionError::Invalid {
            name: name.to_owned(),
            value: value.clone(),
            expected: expected(),
        });
    }
    Ok(())
}
