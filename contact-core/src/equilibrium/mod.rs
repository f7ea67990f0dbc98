//! How one load is solved: [`FixedPoint`] is Algorithm 2 of the paper, [`Retry`] tries it again where it wanders.
//!
//! | file | role |
//! |---|---|
//! | `fixed_point` | the paper's box, steps 1 to 6 |
//! | `journal` | what the iteration has found so far, and whether it goes on |
//! | `accuracy` | how accurately the next subproblem is solved |
//! | `anderson` | where the next iterate is |
//! | `cycles` | iterates that come back |
//! | `retry` | the ladder of attempts around the fixed point |

mod accuracy;
pub mod anderson;
mod cycles;
pub mod fixed_point;
mod journal;
mod retry;

pub use anderson::Acceleration;
pub use fixed_point::{FixedPoint, relative_change};
pub use retry::Retry;

use crate::{ContactProblem, Cost, Error, LinearGaps, Outcome, State, Stop};

/// Any way to find equilibrium at one load.
pub trait Equilibrium {
    /// Solves `problem`, which is at the load to reach, from `start`.
    ///
    /// # Errors
    /// Settings out of range, a start of the wrong length or with a NaN, and whatever the problem or the method report.
    /// Not converging is an [`Outcome`].
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error>;

    /// Checks the settings, before a run does anything.
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
    /// The load factors of that state and of the load to reach.
    pub from: f64,
    /// See [`StepContext::from`].
    pub to: f64,
    /// A start that is not extrapolated: the last state, its free unknowns lifted after the prescribed ones.
    pub lifted: &'a dyn Fn() -> State,
    /// The request to stop.
    pub stop: &'a Stop,
}

impl<'a> StepContext<'a> {
    /// A single solve that belongs to no run: from `start` at load 0 to full load.
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
    /// Step 6, infinite if the subproblem was not solved.
    pub error: f64,
    /// The number of rows.
    pub rows: usize,
    /// What it cost.
    pub cost: Cost,
}

/// Where the search for equilibrium ended, and how it got there.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended; the rest is a solution only if it converged.
    pub outcome: Outcome,
    /// The last minimum and its multipliers by row name.
    pub state: State,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The rows of the last subproblem.
    pub gaps: LinearGaps,
    /// Their multipliers λ ≥ 0 (UF).
    pub lambda: Vec<f64>,
    /// One entry an iteration.
    pub history: Vec<Iteration>,
}

impl Solution {
    /// The sum over the history.
    pub fn cost(&self) -> Cost {
        self.history.iter().map(|iteration| iteration.cost).sum()
    }
}
