//! Checks of option names and values that Ipopt would accept but misread.

use super::{KnownOption, OptionError, OptionValue};
use crate::nlp::Structure;

/// The prefix of options for the restoration phase; Ipopt knows no other prefix.
const RESTORATION: &str = "resto.";

/// The largest magnitude accepted for a number: the largest default of any of Ipopt's options. Much larger values
/// overflow, and Ipopt may then iterate without end where it checks no limit.
const LARGEST: f64 = 1e30;

/// Options whose numbers may exceed [`LARGEST`], up to the value that stands for no limit or no bound.
const OPEN: [(&str, f64); 4] = [
    ("max_cpu_time", f64::INFINITY),
    ("max_wall_time", f64::INFINITY),
    ("nlp_lower_bound_inf", f64::NEG_INFINITY),
    ("nlp_upper_bound_inf", f64::INFINITY),
];

/// The name without the prefix of the restoration phase.
pub(super) fn bare(name: &str) -> &str {
    name.strip_prefix(RESTORATION).unwrap_or(name)
}

/// Whether Ipopt would take the option and look for it nowhere.
pub(super) fn has_other_prefix(name: &str) -> bool {
    bare(name).contains('.')
}

/// A known word in Ipopt's own spelling, as Ipopt does not mind the case.
pub(super) fn normalized(name: &str, value: OptionValue) -> OptionValue {
    let OptionValue::Text(text) = &value else {
        return value;
    };
    let words = KnownOption::named(bare(name)).map_or(&[][..], |option| option.words);
    match words
        .iter()
        .find(|word| word.text.eq_ignore_ascii_case(text))
    {
        Some(word) => word.text.into(),
        None => value,
    }
}

/// Why a number is refused that Ipopt might take, to follow on the range that Ipopt gives.
pub(super) fn unusable(name: &str, number: f64) -> Option<String> {
    let name = bare(name);
    let (lower, upper) = match OPEN.iter().find(|(open, _)| *open == name) {
        Some((_, end)) => (end.min(-LARGEST), end.max(LARGEST)),
        None => (-LARGEST, LARGEST),
    };
    if name == "obj_scaling_factor" && number == 0.0 {
        Some(", but not 0".to_owned())
    } else if (lower..=upper).contains(&number) {
        None
    } else {
        Some(format!(", from {lower:e} to {upper:e}"))
    }
}

/// Rejects values that conflict with the structure, which Ipopt would accept silently or crash with.
pub(super) fn fits(
    structure: &Structure,
    name: &str,
    value: &OptionValue,
) -> Result<(), OptionError> {
    let (fitting, reason): (&[&str], _) = match bare(name) {
        // Ipopt would take the Hessian for zero, in the solve and in its derivative checker.
        "hessian_approximation" if structure.hessian().is_none() => {
            (&["limited-memory"], "the structure has no Hessian")
        }
        "derivative_test" if structure.hessian().is_none() => {
            (&["none", "first-order"], "the structure has no Hessian")
        }
        _ => return Ok(()),
    };
    if fitting.iter().any(|&word| *value == word.into()) {
        return Ok(());
    }
    Err(OptionError::Invalid {
        name: name.to_owned(),
        value: value.clone(),
        expected: format!("{fitting:?}, as {reason}"),
    })
}
