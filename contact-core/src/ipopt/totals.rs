//! The total cost of a sequence of problems.

use std::fmt;

#[cfg(doc)]
use super::Sequence;
use super::Statistics;

/// The total cost of all solves of a [`Sequence`]; its `Display` form is one line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Totals {
    /// Problems.
    pub problems: usize,
    /// Problems that were not solved.
    pub failures: usize,
    /// Solves that started warm.
    pub warm: usize,
    /// Solves that started cold, retries included.
    pub cold: usize,
    /// Warm solves that were repeated cold.
    pub cold_retries: usize,
    /// Iterations of all solves.
    pub iterations: usize,
    /// Calls of all functions.
    pub evaluations: usize,
    /// Factorisations; 0 where the linear solver does not report them.
    pub factorizations: usize,
    /// Wall seconds.
    pub seconds: f64,
}

impl Totals {
    pub(super) fn count(&mut self, statistics: &Statistics, warm: bool) {
        match warm {
            true => self.warm += 1,
            false => self.cold += 1,
        }
        self.iterations += statistics.iterations;
        self.factorizations += statistics.factorizations.unwrap_or(0);
        self.seconds += statistics.total.wall;
        self.evaluations += [
            &statistics.objective,
            &statistics.gradient,
            &statistics.constraints,
            &statistics.jacobian,
            &statistics.hessian,
        ]
        .iter()
        .map(|function| function.calls)
        .sum::<usize>();
    }
}

impl fmt::Display for Totals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} problems ({} not solved), {} warm and {} cold solves ({} of them retries), {} iterations, \
             {} factorisations, {:.3} s",
            self.problems,
            self.failures,
            self.warm,
            self.cold,
            self.cold_retries,
            self.iterations,
            self.factorizations,
            self.seconds
        )
    }
}
