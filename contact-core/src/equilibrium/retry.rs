//! Further attempts where the fixed-point iteration cycles or reaches its limit, as it may near a kink of the
//! projections.

use super::{Acceleration, Choice, Equilibrium, FixedPoint, Solution, StepContext};
use crate::method::Method;
use crate::{ContactProblem, Error, MemoryNeed, Outcome, State};

/// A [`FixedPoint`] that is repeated where it cycles or reaches its iteration limit: first by the plain iteration from
/// the same start, then accelerated from a start that is not extrapolated. The history has the iterations of all
/// attempts.
///
/// If [`FixedPoint::acceleration`] is [`Acceleration::Plain`], there is only one attempt.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Retry<M> {
    /// The first attempt.
    pub fixed_point: FixedPoint<M>,
}

impl<M> Retry<M> {
    /// With the default [`FixedPoint`] and this method.
    pub fn with(method: M) -> Self {
        Retry {
            fixed_point: FixedPoint::with(method),
        }
    }
}

impl<M: Method> Equilibrium for Retry<M> {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let accelerated = self.fixed_point.acceleration;
        let mut solution = self.fixed_point.solve(problem, start.clone(), context)?;
        for acceleration in [Acceleration::Plain, accelerated] {
            if !wanders(&solution) || accelerated == Acceleration::Plain {
                break;
            }
            let start = match acceleration {
                Acceleration::Plain => start.clone(),
                Acceleration::Anderson(_) => (context.lifted)(),
            };
            self.fixed_point.acceleration = acceleration;
            let again = self.fixed_point.solve(problem, start, context);
            self.fixed_point.acceleration = accelerated;
            solution = again?.after(solution, self.fixed_point.method.name(), None);
        }
        Ok(solution)
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        self.fixed_point.check(problem)
    }

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        self.fixed_point.choice(problem)
    }

    fn validate(&self) -> Result<(), Error> {
        self.fixed_point.validate()
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        self.fixed_point.memory(problem)
    }
}

fn wanders(solution: &Solution) -> bool {
    matches!(
        solution.outcome,
        Outcome::IterationLimit | Outcome::Cycle { .. }
    )
}
