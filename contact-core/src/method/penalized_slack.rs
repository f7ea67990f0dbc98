//! Method (37): min E(u) + μ Σ η(s_i) subject to C u + c₀ − s = 0 and s ≥ −ε.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::penalized::Penalized;
use super::{Continuation, Method, Minimum, Subproblem};
use crate::ipopt::Options;
use crate::{Error, State};

/// The penalised slack (37): slacks may be negative, at the price μ η of (38).
///
/// What is left of penetration falls like μ^(−1/2), since 3 μ s² is to balance a contact force; the
/// Hessian's entries grow like μ^(1/2) only. The bound −ε is far from what is left in the end; it
/// keeps a body that nothing but contact holds from falling through while μ is small.
#[derive(Clone, Debug)]
pub struct PenalizedSlack {
    /// How μ grows.
    pub continuation: Continuation,
    /// ε in units of [`Scale::length`](crate::Scale).
    pub bound: f64,
    /// Ipopt's `tol`, relative to the scales.
    pub tolerance: f64,
    /// Iterations before a solve is given up.
    pub max_iterations: usize,
    /// More options for Ipopt by name; they override everything set here.
    pub options: Options,
    /// Raising this flag stops a running solve at its next iteration.
    pub stop: Option<Arc<AtomicBool>>,
    /// μ at the last solution; a warm start goes on from there.
    reached: f64,
}

impl Default for PenalizedSlack {
    fn default() -> Self {
        PenalizedSlack {
            continuation: Continuation::default(),
            bound: 1.0,
            tolerance: 1e-12,
            max_iterations: 300,
            options: Options::new(),
            stop: None,
            reached: 0.0,
        }
    }
}

impl PenalizedSlack {
    /// All by default but the continuation.
    pub fn with(continuation: Continuation) -> Self {
        PenalizedSlack {
            continuation,
            ..PenalizedSlack::default()
        }
    }
}

impl Method for PenalizedSlack {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        if !(self.bound > 0.0) {
            return Err(Error::Setting {
                name: "bound",
                value: self.bound.to_string(),
                remedy: "a positive multiple of the scale of lengths, such as 1",
            });
        }
        Penalized {
            weights: vec![1.0; subproblem.gaps.len()],
            slack_bound: self.bound,
            move_limit: None,
            continuation: self.continuation,
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            options: &self.options,
            stop: self.stop.as_deref(),
        }
        .minimize(subproblem, start, &mut self.reached)
    }
}
