//! Passes [`Options`] to Ipopt.

use std::ffi::{CStr, CString};

use ipopt_sys as sys;

use super::{
    Available, KnownOption, OptionError, OptionValue, Options,
    check::{bare, fits, has_other_prefix, unusable},
    order, refused,
};
use crate::nlp::Structure;

/// The driver's defaults for a problem.
fn defaults(structure: &Structure) -> Options {
    let mut options = Options::new()
        .with("option_file_name", "")
        .with("print_level", 0)
        .with("sb", true)
        .with("resto.mehrotra_algorithm", false)
        .with("bound_relax_factor", 0.0)
        .with("honor_original_bounds", false)
        .with("mumps_mem_percent", Options::MEMORY_PERCENT)
        .with("timing_statistics", true)
        .with("hessian_constant", structure.hessian_constant())
        .with("jac_c_constant", structure.jacobian_constant())
        .with("jac_d_constant", structure.jacobian_constant());
    if structure.hessian().is_none() {
        options.set("hessian_approximation", "limited-memory");
        options.set("hessian_constant", false);
    }
    if let Some(order) = order::default_for(structure) {
        options.set("mumps_pivot_order", order.code());
    }
    options
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
        fits(structure, name, value)?;
    }
    Ok(())
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
        since: KnownOption::named(bare(name)).and_then(|option| option.since),
    };
    if has_other_prefix(name) {
        return Err(unknown());
    }
    let c_name = CString::new(name).map_err(|_| unknown())?;
    // SAFETY: `shim` is valid by the caller's promise, here and below, and `c_name` is a C string.
    let kind = match unsafe { sys::ipopt_shim_option_type(shim, c_name.as_ptr()) }.unsigned_abs() {
        sys::IPOPT_SHIM_OPTION_UNKNOWN => return Err(unknown()),
        kind => kind,
    };
    refused::check(name, value)?;
    // SAFETY: as above.
    let Err(refused) = (unsafe { set(shim, name, &c_name, kind, value) }) else {
        return Ok(());
    };
    // SAFETY: as above.
    let expected = unsafe { range_of(shim, &c_name) };
    let (name, value) = (name.to_owned(), value.clone());
    Err(match refused {
        Refused::Type => OptionError::WrongType {
            name,
            value,
            expected,
        },
        Refused::Value(but) => OptionError::Invalid {
            name,
            value,
            expected: expected + &but,
        },
    })
}

/// Why a known option is not set.
enum Refused {
    Type,
    /// With what is to be said after the values that Ipopt takes.
    Value(String),
}

/// # Safety
/// As [`apply`].
unsafe fn set(
    shim: *mut sys::ipopt_shim,
    name: &str,
    c_name: &CStr,
    kind: u32,
    value: &OptionValue,
) -> Result<(), Refused> {
    let c_name = c_name.as_ptr();
    let number = |number: f64| match unusable(name, number) {
        Some(but) => Err(Refused::Value(but)),
        // SAFETY: `shim` is valid by the caller's promise, and `c_name` is a C string, here and below.
        None => Ok(unsafe { sys::ipopt_shim_set_number(shim, c_name, number) }),
    };
    let set = match (kind, value) {
        (sys::IPOPT_SHIM_OPTION_TEXT, OptionValue::Text(text)) => match CString::new(text.as_str())
        {
            // SAFETY: as above.
            Ok(text) => unsafe { sys::ipopt_shim_set_text(shim, c_name, text.as_ptr()) },
            Err(_) => 0,
        },
        (sys::IPOPT_SHIM_OPTION_NUMBER, &OptionValue::Number(value)) => number(value)?,
        (sys::IPOPT_SHIM_OPTION_NUMBER, &OptionValue::Integer(value)) => number(value.into())?,
        (sys::IPOPT_SHIM_OPTION_INTEGER, &OptionValue::Integer(value)) => {
            // SAFETY: as above.
            unsafe { sys::ipopt_shim_set_integer(shim, c_name, value) }
        }
        _ => return Err(Refused::Type),
    };
    match set {
        0 => Err(Refused::Value(availability(name, value))),
        _ => Ok(()),
    }
}

/// A description of the values that an option takes.
///
/// # Safety
/// `shim` must be valid.
unsafe fn range_of(shim: *mut sys::ipopt_shim, name: &CStr) -> String {
    let mut text = [0; 2048];
    // SAFETY: the shim is valid by the caller's promise, `name` a C string, and `text` has the size given.
    unsafe { sys::ipopt_shim_option_range(shim, name.as_ptr(), text.as_mut_ptr(), text.len()) };
    // SAFETY: the shim ends what it writes with 0, and `text` was 0 before.
    unsafe { CStr::from_ptr(text.as_ptr()) }
        .to_string_lossy()
        .into_owned()
}

/// What a known word needs that this build of Ipopt refuses.
fn availability(name: &str, value: &OptionValue) -> String {
    let word = KnownOption::named(bare(name)).and_then(|option| {
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
    let name = CString::new(name)
        .ok()
        .filter(|_| !has_other_prefix(name))?;
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

/// The names of all options that this Ipopt has, in order.
///
/// # Safety
/// `shim` must be valid.
pub(in crate::ipopt) unsafe fn names(shim: *mut sys::ipopt_shim) -> Vec<String> {
    let mut text = [0; 256];
    let mut names = Vec::new();
    // SAFETY: the shim is valid by the caller's promise, and `text` has the size given.
    while unsafe {
        sys::ipopt_shim_option_name(shim, names.len(), text.as_mut_ptr(), text.len()) != 0
    } {
        // SAFETY: the shim ends what it writes with 0.
        let name = unsafe { CStr::from_ptr(text.as_ptr()) };
        names.push(name.to_string_lossy().into_owned());
    }
    names
}
