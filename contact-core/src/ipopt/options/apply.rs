//! From [`Options`] to Ipopt, one by one.

use std::ffi::{CStr, CString};

use ipopt_sys as sys;

use super::super::Ordering;
use super::{Available, KnownOption, OptionError, OptionValue, Options};
use crate::nlp::Structure;

/// Variables above which the driver chooses MUMPS' ordering.
const LARGE: usize = 10_000;

/// Entries of the Hessian's lower triangle a variable, from which a problem is taken for one in space: elasticity has
/// 7 on a mesh of triangles, 22 and more on one of tetrahedra.
const DENSE: usize = 15;

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
        options.set("mumps_pivot_order", ordering(structure).code());
    }
    options
}

/// PORD for what is dense like a problem in space, as minimum fill leads to far larger factors there. Minimum fill for
/// the others: its factors are as small, and it takes the least time to find them. MUMPS' own choice for both is
/// SCOTCH, if it has no METIS: its factors are no smaller, and it takes several times as long, in threads that wait.
fn ordering(structure: &Structure) -> Ordering {
    let entries = structure.hessian().map_or(0, |hessian| hessian.len());
    match entries / structure.variables() >= DENSE {
        true => Ordering::Pord,
        false => Ordering::Amf,
    }
}

/// Sets the defaults Ipopt knows, then `options`, from a clean slate.
///
/// # Safety
/// `shim` must be valid, and this thread's alone.
pub(in crate::ipopt) unsafe fn apply(
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
        if structure.hessian().is_none() {
            fits_without_hessian(name, value)?;
        }
    }
    Ok(())
}

/// Without a Hessian Ipopt would take it for zero, in the solve and in its derivative checker.
fn fits_without_hessian(name: &str, value: &OptionValue) -> Result<(), OptionError> {
    let fitting: &[&str] = match name {
        "hessian_approximation" => &["limited-memory"],
        "derivative_test" => &["none", "first-order"],
        _ => return Ok(()),
    };
    if fitting.iter().any(|&word| *value == word.into()) {
        return Ok(());
    }
    Err(OptionError::Invalid {
        name: name.to_owned(),
        value: value.clone(),
        expected: format!("{fitting:?}, as the structure has no Hessian"),
    })
}

/// # Safety
/// As [`apply`].
pub(in crate::ipopt) unsafe fn apply_one(
    shim: *mut sys::ipopt_shim,
    name: &str,
    value: &OptionValue,
) -> Result<(), OptionError> {
    let unknown = || OptionError::Unknown {
        name: name.to_owned(),
        value: value.clone(),
        since: KnownOption::named(name).and_then(|option| option.since),
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
            expected: expected() + &availability(name, value),
        });
    }
    Ok(())
}

/// What a known word needs that this build of Ipopt refuses.
fn availability(name: &str, value: &OptionValue) -> String {
    let word = KnownOption::named(name).and_then(|option| {
        option
            .words
            .iter()
            .find(|word| *value == OptionValue::from(word.text))
    });
    match word.map(|word| word.available) {
        Some(Available::Since(version)) => format!("; {value} exists since {version}"),
        Some(Available::With(library)) => format!("; {value} needs an Ipopt built with {library}"),
        Some(Available::Always) | None => String::new(),
    }
}

/// Ipopt's own default of an option; `None` if it has no such option.
///
/// # Safety
/// `shim` must be valid.
pub(in crate::ipopt) unsafe fn default_of(
    shim: *mut sys::ipopt_shim,
    name: &str,
) -> Option<OptionValue> {
    let name = CString::new(name).ok()?;
    let mut number = 0.0;
    let mut text = [0; 2048];
    // SAFETY: the shim is valid by the caller's promise, and `text` has the size given.
    let kind = unsafe {
        sys::ipopt_shim_option_default(
            shim,
            name.as_ptr(),
            &mut number,
            text.as_mut_ptr(),
            text.len(),
        )
    };
    match kind.unsigned_abs() {
        sys::IPOPT_SHIM_OPTION_NUMBER => Some(OptionValue::Number(number)),
        sys::IPOPT_SHIM_OPTION_INTEGER => Some(OptionValue::Integer(number as i32)),
        sys::IPOPT_SHIM_OPTION_TEXT => {
            // SAFETY: the shim ends what it writes with 0, and `text` was 0 before.
            let text = unsafe { CStr::from_ptr(text.as_ptr()) };
            Some(text.to_string_lossy().into_owned().into())
        }
        _ => None,
    }
}
