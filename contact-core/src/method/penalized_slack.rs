//! Method (37): min E(u) + μ Σ η(s_i) subject to C u + c₀ − s = 0 and s ≥ −ε.

use super::penalized::{Penalization, Penalized};
use super::scaled::memory;
use super::{Continuation, Method, Minimum, Subproblem};
use crate::{Energy, Error, MemoryNeed, State};

/// The penalised slack (37): slacks may be negative and are penalised by μ η of (38).
///
/// The penetration falls like μ^(−1/2), since 3 μ s² balances a contact force; the Hessian's entries
/// grow like μ^(1/2) only. The bound −ε is not active at the end of the continuation: while μ is
/// small, it keeps a body that is held by contact alone from passing through the other one.
#[derive(Clone, Debug)]
pub struct PenalizedSlack {
    /// The continuation in μ and the settings of every solve.
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
    /// The default settings with this continuation.
    pub fn with(continuation: Continuation) -> Self {
        let mut method = PenalizedSlack::default();
        method.penalization.continuation = continuation;
        method
    }
}

impl PenalizedSlack {
    fn check_bound(&self) -> Result<(), Error> {
        let remedy = "choose a positive multiple of the length scale, such as 1";
        Error::check_setting(self.bound > 0.0, "bound", self.bound, remedy)
    }
}

impl Method for PenalizedSlack {
    fn name(&self) -> &'static str {
        "ipopt"
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        memory(energy, &self.penalization.options)
    }

    fn validate(&self) -> Result<(), Error> {
        self.check_bound()?;
        self.penalization.validate()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        self.check_bound()?;
        let problem = Penalized {
            subproblem,
            weights: vec![1.0; subproblem.gaps.len()],
            slack_bound: self.bound,
            move_limit: None,
        };
        self.penalization.minimize(&problem, start)
    }
}
