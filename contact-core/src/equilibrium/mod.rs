//! Equilibrium at one load: [`FixedPoint`] is Algorithm 2 of the paper; [`Retry`] repeats it with other settings where
//! it does not converge.
//!
//! | file | role |
//! |---|---|
//! | `fixed_point` | the paper's box, steps 1 to 6 |
//! | `journal` | the iterate, the history and the stopping criteria |
//! | `accuracy` | the accuracy asked of the next subproblem |
//! | `anderson` | the next iterate |
//! | `cycles` | detection of periodic iterates |
//! | `retry` | further attempts where the fixed point does not converge |
//! | `newton` | Newton's method with contact condensed onto its rows, with the feature `linear` |
//! | `condensed` | convex quadratic programs condensed onto their rows, with the feature `linear` |

mod accuracy;
pub mod anderson;
#[cfg(feature = "linear")]
mod condensed;
mod cycles;
pub mod fixed_point;
mod journal;
#[cfg(feature = "linear")]
mod newton;
mod retry;

pub use anderson::Acceleration;
#[cfg(feature = "linear")]
pub use condensed::Condensed;
pub use fixed_point::{FixedPoint, relative_change};
#[cfg(feature = "linear")]
pub use newton::CondensedNewton;
pub use retry::Retry;

use crate::{ContactProblem, Cost, Error, LinearGaps, Outcome, State, Stop};

/// A solver for equilibrium at one load.
pub trait Equilibrium {
    /// Solves `problem`, whose load is already set to the target, from `start`.
    ///
    /// # Errors
    /// Settings out of range, a start of the wrong length or with values that are not finite, and errors of the problem
    /// or the method. Failure to converge is an [`Outcome`], not an error.
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error>;

    /// Checks the settings; called before a run starts.
    ///
    /// # Errors
    /// The first setting that is out of range.
    fn validate(&self) -> Result<(), Error> {
        Ok(())
    }
}

impl<E: Equilibrium + ?Sized> Equilibrium for &mut E {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        (**self).solve(problem, start, context)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }
}

impl<E: Equilibrium + ?Sized> Equilibrium for Box<E> {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        (**self).solve(problem, start, context)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }
}

/// The load step that a solve belongs to.
pub struct StepContext<'a> {
    /// The last converged state.
    pub last: &'a State,
    /// The load factor of that state.
    pub from: f64,
    /// The load factor to reach.
    pub to: f64,
    /// A start that is not extrapolated: the last state, with its free unknowns moved along with the prescribed ones.
    /// See [`LoadStepped::lift`](crate::LoadStepped::lift).
    pub lifted: &'a dyn Fn() -> State,
    /// The request to stop.
    pub stop: &'a Stop,
}

impl<'a> StepContext<'a> {
    /// The context of a single solve without load steps: from `start` at load 0 to full load.
    pub fn single(start: &'a State, lifted: &'a dyn Fn() -> State, stop: &'a Stop) -> Self {
        StepContext {
            last: start,
            from: 0.0,
            to: 1.0,
            lifted,
            stop,
        }
    }
}

/// One iteration of Algorithm 2.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    /// The relative change of step 6; infinite if the subproblem was not solved.
    pub error: f64,
    /// The number of rows.
    pub rows: usize,
    /// Its cost.
    pub cost: Cost,
}

/// The last iterate of the search for equilibrium, its outcome and the history.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The outcome. The other fields describe an equilibrium only if it is [`Outcome::Converged`].
    pub outcome: Outcome,
    /// The last minimum and its multipliers by row key.
    pub state: State,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The rows of the last subproblem.
    pub gaps: LinearGaps,
    /// Their multipliers λ ≥ 0 (UF).
    pub lambda: Vec<f64>,
    /// One entry per iteration.
    pub history: Vec<Iteration>,
}

impl Solution {
    /// The sum of the costs in the history.
    pub fn cost(&self) -> Cost {
        self.history.iter().map(|iteration| iteration.cost).sum()
    }
}
