//! Method (37): min E(u) + μ Σ η(s_i) subject to C u + c₀ − s = 0 and s ≥ −ε.

use super::penalized::{Penalization, Penalized};
use super::{Continuation, Method, Minimum, Subproblem};
use crate::{Error, State};

/// The penalised slack (37): slacks may be negative, at the price μ η of (38).
///
/// What is left of penetration falls like μ^(−1/2), since 3 μ s² is to balance a contact force; the
/// Hessian's entries grow like μ^(1/2) only. The bound −ε is far from what is left in the end; it
/// keeps a body that nothing but contact holds from falling through while μ is small.
#[derive(Clone, Debug)]
pub struct PenalizedSlack {
    /// How μ grows, and how every solve is done.
    pub penalization: Penalization,
    /// ε in units of [`Scale::length`](crate::Scale).
    pub bound: f64,
}

impl Default for PenalizedSlack {
    fn default() -> Self {
        PenalizedSlack {
            penalization: Penalization::default(),
            bound: 1.0,
        }
    }
}

impl PenalizedSlack {
    /// All by default but the continuation.
    pub fn with(continuation: Continuation) -> Self {
        let mut method = PenalizedSlack::default();
        method.penalization.continuation = continuation;
        method
    }
}

impl Method for PenalizedSlack {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let remedy = "a positive multiple of the scale of lengths, such as 1";
        Error::check_setting(self.bound > 0.0, "bound", self.bound, remedy)?;
        let problem = Penalized {
            subproblem,
            weights: vec![1.0; subproblem.gaps.len()],
            slack_bound: self.bound,
            move_limit: None,
        };
        self.penalization.minimize(&problem, start)
    }
}
