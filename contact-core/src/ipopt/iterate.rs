//! The iterate of the solve under way, out of the shim.

use ipopt_sys as sys;

use crate::nlp::{IterateSource, IterationRecord, Multipliers, Phase, Structure};

pub(super) fn record(raw: &sys::ipopt_shim_iteration) -> IterationRecord {
    IterationRecord {
        iteration: usize::try_from(raw.iteration).unwrap_or(0),
        phase: if raw.restoration != 0 {
            Phase::Restoration
        } else {
            Phase::Regular
        },
        objective: raw.objective,
        primal_infeasibility: raw.primal_infeasibility,
        dual_infeasibility: raw.dual_infeasibility,
        mu: raw.mu,
        step_norm: raw.step_norm,
        regularization: raw.regularization,
        alpha_dual: raw.alpha_dual,
        alpha_primal: raw.alpha_primal,
        line_search_trials: usize::try_from(raw.line_search_trials).unwrap_or(0),
    }
}

/// The iterate of the solve under way; lives inside `intermediate` only.
pub(super) struct Source<'a> {
    pub(super) shim: *const sys::ipopt_shim,
    pub(super) structure: &'a Structure,
}

impl IterateSource for Source<'_> {
    fn x(&self) -> Option<Vec<f64>> {
        let mut x = vec![0.0; self.structure.variables()];
        // SAFETY: the shim is in its intermediate callback, and `x` has n values.
        (unsafe { sys::ipopt_shim_current_x(self.shim, x.as_mut_ptr()) } != 0).then_some(x)
    }

    fn constraints(&self) -> Option<Vec<f64>> {
        let mut g = vec![0.0; self.structure.constraints()];
        // SAFETY: as above, m values.
        (unsafe { sys::ipopt_shim_current_g(self.shim, g.as_mut_ptr()) } != 0).then_some(g)
    }

    fn multipliers(&self) -> Option<Multipliers> {
        let n = self.structure.variables();
        let mut multipliers = Multipliers {
            constraints: vec![0.0; self.structure.constraints()],
            lower: vec![0.0; n],
            upper: vec![0.0; n],
        };
        // SAFETY: as above, n, n and m values.
        let available = unsafe {
            sys::ipopt_shim_current_multipliers(
                self.shim,
                multipliers.lower.as_mut_ptr(),
                multipliers.upper.as_mut_ptr(),
                multipliers.constraints.as_mut_ptr(),
            )
        };
        (available != 0).then_some(multipliers)
    }
}
