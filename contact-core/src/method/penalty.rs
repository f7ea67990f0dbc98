//! Method (39): min E(u) + μ ∫ η(g) ds over the surfaces of all bodies, within bounds on u.

use super::penalized::{Penalization, Penalized};
use super::{Continuation, Method, Minimum, Subproblem};
use crate::gaps::Sampling;
use crate::{Error, State};

/// The penalty (39) on the gaps of all integration points, with η of (38); no constraints.
///
/// What is left of penetration falls like μ^(−1/2), since 3 μ g² is to balance a pressure.
///
/// Where nothing touches the penalty is zero and may hold nothing, so that displacements need a
/// bound, which the paper calls not obvious. Here it is a move limit: within one solve no unknown
/// leaves its start by more. If one gets there the solve is repeated around the new point with ten
/// times the limit, so that no result depends on it.
#[derive(Clone, Debug, Default)]
pub struct Penalty {
    /// How μ grows, and how every solve is done.
    pub penalization: Penalization,
    /// How far an unknown may move in one solve (UL). By default as far as the largest gap in reach
    /// is open, so that it may close, or [`Scale::length`](crate::Scale) if that is more, so that
    /// bodies that touch already may deform.
    pub move_limit: Option<f64>,
}

impl Penalty {
    /// Of [`Scale::length`](crate::Scale): the interior point method stays away from bounds by what
    /// would be all of a smaller move.
    const LEAST_MOVE: f64 = 1e-6;

    /// All by default but the continuation.
    pub fn with(continuation: Continuation) -> Self {
        let mut method = Penalty::default();
        method.penalization.continuation = continuation;
        method
    }

    /// The move limit for a start at which the gaps are those of `subproblem` at `u` (UL).
    fn limit(&self, subproblem: &Subproblem<'_>, u: &[f64]) -> Result<f64, Error> {
        if let Some(limit) = self.move_limit {
            let is_seen = limit >= Self::LEAST_MOVE * subproblem.scale.length;
            let remedy = "at least a millionth of the scale of lengths, or None for the default";
            Error::check_setting(is_seen, "move_limit", limit, remedy)?;
            return Ok(limit);
        }
        let mut c = vec![0.0; subproblem.gaps.len()];
        subproblem.gaps.value(u, &mut c);
        Ok(c.into_iter().fold(subproblem.scale.length, f64::max))
    }
}

impl Method for Penalty {
    fn sampling(&self) -> Sampling {
        Sampling::Points
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
