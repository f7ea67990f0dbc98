//! Problems without a free variable, which Ipopt is not asked about: there is one point, and it is feasible or not.

use std::time::Instant;

use super::{
    Solution, Status,
    callbacks::{Usable, are_usable, timed},
    statistics::Statistics,
};
use crate::nlp::{Bounds, Nlp, Structure};

/// Whether every variable has equal bounds, or there is none.
pub(super) fn are_all_fixed(structure: &Structure) -> bool {
    let Bounds { lower, upper } = structure.variable_bounds();
    lower.iter().zip(upper).all(|(lower, upper)| lower == upper)
}

/// f and g at the only point there is: [`Status::Solved`] if no g violates its bounds by more than is `allowed`,
/// [`Status::Infeasible`] if one does, [`Status::InvalidNumber`] if a value is not finite.
pub(super) fn solution(nlp: &mut dyn Nlp, structure: &Structure, allowed: f64) -> Solution {
    let clock = Instant::now();
    let x = structure.variable_bounds().lower.clone();
    let mut statistics = Statistics::unknown();
    let objective = timed(&mut statistics.objective, || nlp.objective(&x, true));
    let mut g = vec![0.0; structure.constraints()];
    if !g.is_empty() {
        timed(&mut statistics.constraints, || {
            nlp.constraints(&x, false, &mut g)
        });
    }
    let Bounds { lower, upper } = structure.constraint_bounds();
    let violations = (lower.iter().zip(upper).zip(&g)).map(|((l, u), g)| (l - g).max(g - u));
    let violation = violations.fold(0.0, f64::max);
    let most = Usable::default().objective;
    let status = if !(are_usable(&[objective], most) && are_usable(&g, most)) {
        Status::InvalidNumber
    } else if violation <= allowed {
        Status::Solved
    } else {
        Status::Infeasible
    };
    statistics.constraint_violation = violation;
    statistics.total.wall = clock.elapsed().as_secs_f64();
    let has_values = status != Status::InvalidNumber;
    Solution {
        status,
        x,
        objective: if has_values { objective } else { f64::NAN },
        g: if has_values {
            g
        } else {
            vec![f64::NAN; structure.constraints()]
        },
        multipliers: None,
        contradiction: None,
        statistics,
        history: Vec::new(),
        derivative_check: None,
        log_error: None,
    }
}
