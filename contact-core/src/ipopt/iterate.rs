//! The iterate of the solve under way, out of the shim.

use ipopt_sys as sys;

use crate::nlp::{
    Bounds, IterateSource, IterationRecord, Multipliers, Phase, Slacks, Structure, Violations,
};

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

    fn slacks(&self) -> Option<Slacks> {
        let (n, m) = (self.structure.variables(), self.structure.constraints());
        let mut slacks = Slacks {
            constraints: vec![0.0; m],
            lower: vec![0.0; n],
            upper: vec![0.0; n],
            constraint_lower: vec![0.0; m],
            constraint_upper: vec![0.0; m],
        };
        // SAFETY: as above, n, n, m, m and m values.
        let available = unsafe {
            sys::ipopt_shim_current_slacks(
                self.shim,
                slacks.lower.as_mut_ptr(),
                slacks.upper.as_mut_ptr(),
                slacks.constraints.as_mut_ptr(),
                slacks.constraint_lower.as_mut_ptr(),
                slacks.constraint_upper.as_mut_ptr(),
            )
        };
        (available != 0).then_some(slacks)
    }

    fn violations(&self) -> Option<Violations> {
        let (x, g) = (self.x()?, self.constraints()?);
        let (multipliers, slacks) = (self.multipliers()?, self.slacks()?);
        let (mut lagrangian, mut factor) = (vec![0.0; x.len()], 1.0);
        let (to, sign) = (lagrangian.as_mut_ptr(), &mut factor);
        // SAFETY: as above, n values and one.
        if unsafe { sys::ipopt_shim_current_lagrangian(self.shim, to, sign) } == 0 {
            return None;
        }
        let (below, above) = outside(self.structure.variable_bounds(), &x);
        let limits = self.structure.constraint_bounds();
        let (too_low, too_high) = outside(limits, &g);
        let worst = too_low.iter().zip(&too_high).map(|(a, b)| a.max(*b));
        let lambda = multipliers.constraints.iter().enumerate();
        let complementarity = lambda.map(|(i, &lambda)| {
            match (limits.lower[i], limits.upper[i]) {
                (lower, upper) if lower == upper => (lower - g[i]) * lambda,
                // A negative factor of f reverses the multipliers.
                (lower, _) if lambda * factor < 0.0 => product(-lambda, g[i] - lower),
                (_, upper) => product(lambda, upper - g[i]),
            }
        });
        Some(Violations {
            constraints: worst.collect(),
            lower: below,
            upper: above,
            lagrangian,
            complementarity_lower: products(&multipliers.lower, &slacks.lower),
            complementarity_upper: products(&multipliers.upper, &slacks.upper),
            complementarity_constraints: complementarity.collect(),
        })
    }
}

/// How far values are below and above their bounds.
fn outside(bounds: &Bounds, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let lower = bounds.lower.iter().zip(values);
    let upper = bounds.upper.iter().zip(values);
    (
        lower
            .map(|(bound, value)| (bound - value).max(0.0))
            .collect(),
        upper
            .map(|(bound, value)| (value - bound).max(0.0))
            .collect(),
    )
}

/// A multiplier times the distance it goes with, where there is such a bound.
fn product(multiplier: f64, distance: f64) -> f64 {
    match distance.is_finite() {
        true => multiplier * distance,
        false => 0.0,
    }
}

fn products(multipliers: &[f64], distances: &[f64]) -> Vec<f64> {
    let pairs = multipliers.iter().zip(distances);
    pairs.map(|(&z, &distance)| product(z, distance)).collect()
}
