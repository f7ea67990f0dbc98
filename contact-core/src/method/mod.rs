//! Step 5 of Algorithm 2: ways to minimise E(u) subject to C u + c₀ ≥ 0, one file a method.

#[cfg(feature = "ipopt")]
mod continuation;
#[cfg(feature = "ipopt")]
mod interior_point;
#[cfg(feature = "ipopt")]
mod penalized;
#[cfg(feature = "ipopt")]
mod penalized_slack;
#[cfg(feature = "ipopt")]
mod penalty;
#[cfg(feature = "ipopt")]
mod scaled;

#[cfg(feature = "ipopt")]
pub use {
    continuation::Continuation,
    interior_point::InteriorPoint,
    penalized::{Penalization, eta},
    penalized_slack::PenalizedSlack,
    penalty::Penalty,
};

use crate::nlp::Bounds;
use crate::{ContactProblem, Energy, Error, LinearGaps, Scale, State};

/// What a method is to minimise: E(u) over `bounds` and `gaps`, all frozen.
#[derive(Clone, Copy)]
pub struct Subproblem<'a> {
    /// E.
    pub energy: &'a dyn Energy,
    /// Bounds on u.
    pub bounds: &'a Bounds,
    /// C u + c₀ ≥ 0.
    pub gaps: &'a LinearGaps,
    /// Units in which numbers are O(1).
    pub scale: Scale,
    /// The relative change of u to expect: the last one, 1 where nothing is known of the start.
    pub change: f64,
    /// The accuracy, relative to the scales, beyond which nothing is gained; 0 for all that the
    /// method is set to.
    pub accuracy: f64,
}

/// Step 5: any way to minimise E(u) subject to C u + c₀ ≥ 0.
pub trait Method {
    /// Steps 1–3: the rows that it wants at `u`; by default one a contact node.
    fn linearize(&self, problem: &dyn ContactProblem, u: &[f64]) -> Result<LinearGaps, Error> {
        problem.linearize_gaps(u)
    }

    /// Solves from `start`; a failure to converge is told by [`Minimum::solved`], not by `Err`.
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error>;
}

/// Whether a method did what it was asked.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solved {
    /// To the tolerance asked.
    Optimal,
    /// Someone pulled the brake; the result is not a minimum.
    Interrupted,
    /// Not solved, with the solver's own word for why; the result is not a minimum.
    Failed(String),
}

/// What a method found.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// λ ≥ 0, one a row of the gaps (m, UF).
    pub lambda: Vec<f64>,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// Whether u is a minimum at all.
    pub solved: Solved,
    /// What it took.
    pub effort: Effort,
}

/// What solves cost: counts, and seconds of wall time by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Solves, cold retries included.
    pub solves: usize,
    /// Solves that were repeated cold because the warm start led nowhere.
    pub cold_retries: usize,
    /// Iterations of the optimiser.
    pub iterations: usize,
    /// Numerical factorisations of its linear system.
    pub factorizations: usize,
    /// Evaluations of the energy's value.
    pub values: usize,
    /// Evaluations of its gradient.
    pub gradients: usize,
    /// Evaluations of its Hessian.
    pub hessians: usize,
    /// Seconds inside the energy and the gaps.
    pub callbacks: f64,
    /// Seconds inside the optimiser, callbacks excluded.
    pub optimizer: f64,
    /// The largest factor, where the linear solver tells.
    pub factor: Option<Factor>,
}

/// A factor of the optimiser's linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// The elimination order that the linear solver used.
    pub ordering: &'static str,
    /// The bytes it fills.
    pub bytes: u64,
    /// The bytes that were allocated by an estimate made before, where the system tells.
    pub workspace_bytes: Option<u64>,
    /// How often the estimate was too small, in all solves.
    pub reallocations: usize,
}

impl Factor {
    /// The larger one, with the reallocations of both.
    fn or_larger(self, other: Self) -> Self {
        let larger = if other.bytes > self.bytes {
            other
        } else {
            self
        };
        Factor {
            reallocations: self.reallocations + other.reallocations,
            ..larger
        }
    }
}

impl std::ops::AddAssign for Effort {
    fn add_assign(&mut self, other: Self) {
        self.solves += other.solves;
        self.cold_retries += other.cold_retries;
        self.iterations += other.iterations;
        self.factorizations += other.factorizations;
        self.values += other.values;
        self.gradients += other.gradients;
        self.hessians += other.hessians;
        self.callbacks += other.callbacks;
        self.optimizer += other.optimizer;
        self.factor = match (self.factor, other.factor) {
            (Some(a), Some(b)) => Some(a.or_larger(b)),
            (a, b) => a.or(b),
        };
    }
}
