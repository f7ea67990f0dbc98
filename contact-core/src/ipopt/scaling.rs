//! Scaling by the caller's factors; it is an error if an option makes Ipopt ignore them.

use ipopt_sys as sys;

use super::{Error, Options, callbacks::Usable, solver::Solver, start::check_finite};
use crate::nlp::{NlpError, Structure};

/// Factors by which Ipopt multiplies f, x and g before it solves: see [`Solver::set_scaling`](super::Solver::set_scaling).
/// They change the iterates and the meaning of `tol`, not the problem: a [`Solution`](super::Solution) is unscaled. Choose them
/// so that the derivatives become about 1.
///
/// **A negative factor of f maximises, and reverses the signs of all [`Multipliers`](crate::nlp::Multipliers)**, those
/// of iterates and of warm starts included: ∇L = 0 with the L of [`nlp`](crate::nlp) as ever, but z_L, z_U ≤ 0, λ ≥ 0
/// where g is at its lower bound and λ ≤ 0 at its upper. Minimise −f to have them as usual.
///
/// ```
/// # use contact_core::ipopt::Scaling;
/// let scaling = Scaling {
///     objective: 1e3,                         // f is in kJ
///     variables: Some(vec![1.0, 1e3]),        // x is in m and mm
///     constraints: None,
/// };
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// Of f.
    pub objective: f64,
    /// Of x; `None` for 1.
    pub variables: Option<Vec<f64>>,
    /// Of g; `None` for 1.
    pub constraints: Option<Vec<f64>>,
}

impl Scaling {
    pub(super) fn validate(&self, structure: &Structure) -> Result<(), NlpError> {
        check_scaling("the scaling of f", &[self.objective], 1, f64::NEG_INFINITY)?;
        if let Some(x) = &self.variables {
            check_scaling("the scaling of x", x, structure.variables(), 0.0)?;
        }
        if let Some(g) = &self.constraints {
            check_scaling("the scaling of g", g, structure.constraints(), 0.0)?;
        }
        Ok(())
    }
}

impl Solver {
    /// Scales the problem by these factors, in every solve until [`Solver::clear_scaling`]: sets the option
    /// `nlp_scaling_method` to "user-scaling" unless it is set already.
    ///
    /// # Errors
    /// [`NlpError`](crate::nlp::NlpError) unless each factor is finite and positive (that of f may be negative, to
    /// maximise), and there are as many as variables or constraints. [`Error::UnusedScaling`] if `nlp_scaling_method`
    /// is set to something else. The factors then stay as they were.
    pub fn set_scaling(&mut self, scaling: &Scaling) -> Result<(), Error> {
        scaling.validate(&self.structure)?;
        scaling_is_used(&self.options)?;
        let (x, g) = (scaling.variables.as_deref(), scaling.constraints.as_deref());
        self.copy_scaling(scaling.objective, x, g)?;
        self.scaled = Some(Usable::under(scaling));
        self.apply_one("nlp_scaling_method", &USER_SCALING.into())
    }

    /// Removes the factors: scaling is again that of the option `nlp_scaling_method`, or Ipopt's default.
    ///
    /// # Errors
    /// As [`Solver::set_options`], but the options were taken before.
    pub fn clear_scaling(&mut self) -> Result<(), Error> {
        self.copy_scaling(1.0, None, None)?;
        self.scaled = None;
        self.set_options(&self.options.clone())
    }

    fn copy_scaling(
        &mut self,
        objective: f64,
        x: Option<&[f64]>,
        g: Option<&[f64]>,
    ) -> Result<(), Error> {
        let pointer = |values: Option<&[f64]>| values.map_or(std::ptr::null(), <[f64]>::as_ptr);
        let shim = self.shim.as_ptr();
        // SAFETY: the shim is valid, and the arrays have n and m values.
        match unsafe { sys::ipopt_shim_set_scaling(shim, objective, pointer(x), pointer(g)) } {
            0 => Err(Error::OutOfMemory),
            _ => Ok(()),
        }
    }
}

pub(super) const USER_SCALING: &str = "user-scaling";

pub(super) fn scaling_is_used(options: &Options) -> Result<(), Error> {
    match options.get("nlp_scaling_method") {
        Some(method) if *method != USER_SCALING.into() => Err(Error::UnusedScaling {
            method: method.clone(),
        }),
        _ => Ok(()),
    }
}

fn check_scaling(
    what: &'static str,
    values: &[f64],
    expected: usize,
    above: f64,
) -> Result<(), NlpError> {
    check_finite(what, values, expected)?;
    match values
        .iter()
        .position(|&value| value == 0.0 || value <= above)
    {
        Some(index) => Err(NlpError::Value {
            what,
            index,
            value: values[index],
            needed: "positive (f: not 0)",
        }),
        None => Ok(()),
    }
}
