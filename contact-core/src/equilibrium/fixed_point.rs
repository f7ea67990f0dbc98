//! Algorithm 2: the symmetric fixed-point iteration on projections and normals.

use super::journal::Journal;
use super::{Acceleration, Choice, Equilibrium, Solution, StepContext, check_settings};
use crate::friction::Thresholds;
use crate::gaps::Sampling;
use crate::method::Method;
use crate::{ContactProblem, Error, LinearGaps, MemoryNeed, State};

/// Algorithm 2 of the paper, with a [`Method`] for its step 5.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPoint<M> {
    /// The method of step 5.
    pub method: M,
    /// TOLER: bound on the relative change of U, see [`relative_change`].
    pub tolerance: f64,
    /// The iteration limit.
    pub max_iterations: usize,
    /// How the next iterate is formed: by the plain iteration of the paper, or by Anderson acceleration.
    pub acceleration: Acceleration,
}

impl<M> FixedPoint<M> {
    /// The default settings with this `method`.
    pub fn with(method: M) -> Self {
        FixedPoint {
            method,
            tolerance: 1e-6,
            max_iterations: 30,
            acceleration: Acceleration::default(),
        }
    }
}

impl<M: Default> Default for FixedPoint<M> {
    fn default() -> Self {
        FixedPoint::with(M::default())
    }
}

impl<M: Method> FixedPoint<M> {
    /// As [`Equilibrium::solve`], but iterates that come back do not end it.
    #[cfg(feature = "ipopt")]
    pub(super) fn solve_to_the_limit(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        self.validate()?;
        let mut journal = Journal::new(self, problem, start)?;
        journal.ignore_cycles();
        self.iterate(problem, journal, context)
    }

    fn iterate(
        &mut self,
        problem: &dyn ContactProblem,
        mut journal: Journal<'_>,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let sampling = self.method.sampling();
        while journal.goes_on(context.stop) {
            let before = journal.point.clone(); // U_{n−1}
            // 1, 2: projections and normals at U_{n−1}; with both held, every gap is linear in U
            let forward = match problem.linearize_gaps(&before.u, sampling) {
                Err(Error::Interrupted) if !journal.goes_on(context.stop) => break,
                rows => rows?,
            };
            if !journal.goes_on(context.stop) {
                break;
            }
            // 3: the roles of master and slave reversed
            let reversed = match problem.linearize_reversed(&before.u, sampling) {
                Err(Error::Interrupted) if !journal.goes_on(context.stop) => break,
                rows => rows?,
            };
            if !journal.goes_on(context.stop) {
                break;
            }
            // 4: the energy and the symmetric linear constraints
            let gaps = forward.and(reversed);
            // beyond the paper: friction, with the thresholds μλ of the last iterate
            let thresholds = match problem.has_friction() {
                true => Some(self.thresholds(problem, &gaps, &journal, context)?),
                false => None,
            };
            let subproblem = journal.subproblem(&gaps, context.stop);
            // 5: their minimum U_n
            let (minimum, friction) = match thresholds {
                None => (self.method.minimize(&subproblem, &before)?, None),
                Some(thresholds) => {
                    let known = journal.friction();
                    let (minimum, forces) =
                        thresholds.minimize(&mut self.method, &subproblem, &before, known)?;
                    (minimum, Some(thresholds.friction(forces, context)))
                }
            };
            Error::check_length("the method's u", &minimum.u, before.u.len())?;
            Error::check_length("the method's λ", &minimum.lambda, gaps.len())?;
            // 6: ‖U_n − U_{n−1}‖∞ / ‖U‖∞
            let error = relative_change(&minimum.u, &before.u, journal.least);
            journal.accept(gaps, minimum, friction, error);
        }
        Ok(journal.solution())
    }

    /// The thresholds of friction on `gaps`.
    fn thresholds(
        &self,
        problem: &dyn ContactProblem,
        gaps: &LinearGaps,
        journal: &Journal<'_>,
        context: &StepContext<'_>,
    ) -> Result<Thresholds, Error> {
        self.check(problem)?;
        let before = &journal.point;
        let rows = problem.slips(&before.u, gaps, &context.last.u, context.from)?;
        rows.check(before.u.len())?;
        Ok(journal.thresholds(rows, gaps))
    }
}

impl<M: Method> Equilibrium for FixedPoint<M> {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        self.validate()?;
        let journal = Journal::new(self, problem, start)?;
        self.iterate(problem, journal, context)
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        match problem.has_friction() && self.method.sampling() != Sampling::Nodes {
            true => Err(Error::Untreated {
                solver: "FixedPoint",
                what: "friction by rows of integration points",
                value: "true".into(),
                remedy: "take a method with one row for each contact node, such as `InteriorPoint`",
            }),
            false => Ok(()),
        }
    }

    fn choice(&self, _problem: &dyn ContactProblem) -> Choice {
        Choice {
            solver: self.method.name(),
            why: Choice::GIVEN,
        }
    }

    fn validate(&self) -> Result<(), Error> {
        let remedy = "choose a value between 0 and 1; the default is 1e-6";
        check_settings(self.tolerance, self.max_iterations, remedy)?;
        self.method.validate()
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        self.method.memory(problem.energy())
    }
}

/// Step 6: ‖U_n − U_{n−1}‖∞ / max(‖U_{n−1}‖∞, ‖U_n‖∞, `least`) over all unknowns, zero if nothing moved.
///
/// The denominator is at least `least`: the largest prescribed displacement, or 1e-6 of the length scale if that is
/// larger. Without this bound an iteration whose solution is U = 0 would not converge.
pub fn relative_change(u: &[f64], before: &[f64], least: f64) -> f64 {
    let change = max_norm(u.iter().zip(before).map(|(a, b)| a - b));
    let size = max_norm(u.iter().chain(before).copied()).max(least);
    if change == 0.0 { 0.0 } else { change / size }
}

pub(super) fn max_norm(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |norm, v| norm.max(v.abs()))
}

#[cfg(test)]
mod tests;
