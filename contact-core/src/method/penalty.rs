//! Method (39): min E(u) + μ ∫ η(g) ds over the surfaces of all bodies, subject to bounds on u.

use super::penalized::{Penalization, Penalized};
use super::scaled::memory;
use super::{Continuation, Method, Minimum, Subproblem};
use crate::gaps::Sampling;
use crate::{Energy, Error, MemoryNeed, State};

/// The penalty (39) on the gaps of all integration points, with η of (38) and without constraints.
///
/// The penetration falls like μ^(−1/2), since 3 μ g² balances a contact pressure.
///
/// The penalty is zero where bodies do not touch, so that it may not hold a body that only contact
/// supports. Displacements therefore need a bound, whose choice the paper calls not obvious. Here the
/// bound is a move limit on the change of each unknown within one solve. If it is active at the
/// solution, the solve is repeated around that solution with ten times the limit. The result
/// therefore does not depend on it.
#[derive(Clone, Debug, Default)]
pub struct Penalty {
    /// The continuation in μ and the settings of every solve.
    pub penalization: Penalization,
    /// The largest change of an unknown in one solve (UL). The default is the largest open gap in
    /// reach, so that it may close, or [`Scale::length`](crate::Scale) if that is larger, so that
    /// bodies already in contact may deform.
    pub move_limit: Option<f64>,
}

impl Penalty {
    /// The smallest move limit accepted, in units of [`Scale::length`](crate::Scale): the interior
    /// point method keeps a distance from bounds that would use up a smaller one.
    const LEAST_MOVE: f64 = 1e-6;

    /// The default settings with this continuation.
    pub fn with(continuation: Continuation) -> Self {
        let mut method = Penalty::default();
        method.penalization.continuation = continuation;
        method
    }

    /// The move limit for a start at which the gaps are those of `subproblem` at `u` (UL).
    fn limit(&self, subproblem: &Subproblem<'_>, u: &[f64]) -> Result<f64, Error> {
        if let Some(limit) = self.move_limit {
            let is_seen = limit >= Self::LEAST_MOVE * subproblem.scale.length;
            let remedy = "choose at least 1e-6 of the length scale, or None for the default";
            Error::check_setting(is_seen, "move_limit", limit, remedy)?;
            return Ok(limit);
        }
        let mut c = vec![0.0; subproblem.gaps.len()];
        subproblem.gaps.value(u, &mut c);
        Ok(c.into_iter().fold(subproblem.scale.length, f64::max))
    }
}

impl Method for Penalty {
    fn name(&self) -> &'static str {
        "ipopt"
    }

    fn sampling(&self) -> Sampling {
        Sampling::Points
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        memory(energy, &self.penalization.options)
    }

    fn validate(&self) -> Result<(), Error> {
        self.penalization.validate()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let area = subproblem.scale.area;
        let weights = subproblem.gaps.weights().iter();
        let problem = Penalized {
            subproblem,
            weights: weights.map(|weight| weight / area).collect(),
            slack_bound: f64::INFINITY,
            move_limit: Some(self.limit(subproblem, &start.u)?),
        };
        self.penalization.minimize(&problem, start)
    }
}
