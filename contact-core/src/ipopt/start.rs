//! The starting point of a solve, and the arrays of its result.

use ipopt_sys as sys;

use crate::nlp::{Multipliers, NlpError, Structure};

/// The starting point of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<'a> {
    /// x, n finite values. Ipopt moves them inside their bounds.
    pub x: &'a [f64],
    /// With multipliers the solve is a warm start; see [`Options::warm_start`](super::Options::warm_start) for what else that needs.
    pub multipliers: Option<&'a Multipliers>,
}

impl<'a> Start<'a> {
    /// A cold start.
    pub fn at(x: &'a [f64]) -> Self {
        Self {
            x,
            multipliers: None,
        }
    }

    pub(super) fn validate(&self, structure: &Structure) -> Result<(), NlpError> {
        let (n, m) = (structure.variables(), structure.constraints());
        check_finite("the starting x", self.x, n)?;
        if let Some(multipliers) = self.multipliers {
            check_finite("the starting λ", &multipliers.constraints, m)?;
            check_finite("the starting z_L", &multipliers.lower, n)?;
            check_finite("the starting z_U", &multipliers.upper, n)?;
        }
        Ok(())
    }
}

/// The arrays that hold the start and then the result.
pub(super) struct Point {
    pub(super) x: Vec<f64>,
    pub(super) g: Vec<f64>,
    pub(super) multipliers: Multipliers,
}

impl Point {
    pub(super) fn new(structure: &Structure, start: &Start<'_>) -> Result<Self, NlpError> {
        start.validate(structure)?;
        let (n, m) = (structure.variables(), structure.constraints());
        let multipliers = start.multipliers.cloned().unwrap_or_else(|| Multipliers {
            constraints: vec![0.0; m],
            lower: vec![0.0; n],
            upper: vec![0.0; n],
        });
        Ok(Self {
            x: start.x.to_vec(),
            g: vec![f64::NAN; m],
            multipliers,
        })
    }

    pub(super) fn raw(&mut self, have_multipliers: bool) -> sys::ipopt_shim_point {
        sys::ipopt_shim_point {
            x: self.x.as_mut_ptr(),
            z_lower: self.multipliers.lower.as_mut_ptr(),
            z_upper: self.multipliers.upper.as_mut_ptr(),
            lambda: self.multipliers.constraints.as_mut_ptr(),
            g: self.g.as_mut_ptr(),
            objective: f64::NAN,
            have_multipliers: have_multipliers.into(),
            finalized: 0,
        }
    }
}

/// Whether another solve may start from them.
pub(super) fn are_finite(multipliers: &Multipliers) -> bool {
    let Multipliers {
        constraints,
        lower,
        upper,
    } = multipliers;
    [constraints, lower, upper]
        .iter()
        .all(|values| values.iter().all(|value| value.is_finite()))
}

pub(super) fn check_finite(
    what: &'static str,
    values: &[f64],
    expected: usize,
) -> Result<(), NlpError> {
    if values.len() != expected {
        return Err(NlpError::Length {
            what,
            found: values.len(),
            expected,
        });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(NlpError::Value {
            what,
            index,
            value: values[index],
            needed: "finite",
        }),
        None => Ok(()),
    }
}
