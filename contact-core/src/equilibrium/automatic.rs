//! The solver that fits a problem, with the paper's fixed point where it fails.

use super::{Choice, Condensed, CondensedNewton, Equilibrium, Solution, StepContext};
#[cfg(feature = "ipopt")]
use super::{Retry, finite_bound, least_displacement, relative_change};
#[cfg(feature = "ipopt")]
use crate::method::InteriorPoint;
use crate::{ContactProblem, Error, MemoryNeed, State};
#[cfg(feature = "ipopt")]
use crate::{Outcome, Scale, memory};

/// The solver that fits the problem.
///
/// | problem | solver |
/// |---|---|
/// | some unknowns have bounds | `Retry<InteriorPoint>`, the paper's fixed point with Ipopt |
/// | quadratic energy and exact rows: small strains, contact in the reference geometry | [`Condensed`] |
/// | all others | [`CondensedNewton`] |
///
/// A load step that one of the last two does not solve is repeated by the fixed point from the same start. Where it was
/// Newton's method that failed, that method goes on from the state to which the fixed point has come, and examines whether the state is stable.
/// [`Solution::failed`] has what failed before. Without the feature `ipopt` there is no fixed point.
///
/// By default the tolerance is that of [`CondensedNewton`], for the fixed point, too.
#[derive(Clone, Debug)]
pub struct Automatic {
    /// For quadratic energies and exact rows.
    pub condensed: Condensed,
    /// For other problems.
    pub newton: CondensedNewton,
    /// For bounds on unknowns, and for load steps that the others do not solve.
    #[cfg(feature = "ipopt")]
    pub fixed_point: Retry<InteriorPoint>,
}

/// Equilibria that two solvers have found are the same if u differs by less than this share.
#[cfg(feature = "ipopt")]
const SAME: f64 = 1e-3;

/// A field of [`Automatic`].
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Condensed,
    Newton,
    #[cfg(feature = "ipopt")]
    FixedPoint,
}

impl Automatic {
    /// With this bound on the relative change of u for Newton's method and the fixed point, see [`relative_change`](super::relative_change).
    pub fn with_tolerance(tolerance: f64) -> Self {
        Automatic {
            condensed: Condensed::new(),
            newton: CondensedNewton::with_tolerance(tolerance),
            #[cfg(feature = "ipopt")]
            fixed_point: {
                let mut fixed_point = Retry::default();
                fixed_point.fixed_point.tolerance = tolerance;
                fixed_point
            },
        }
    }

    /// The first way for `problem`, and the reason.
    fn way(problem: &dyn ContactProblem) -> (Way, &'static str) {
        #[cfg(feature = "ipopt")]
        if finite_bound(problem.bounds()).is_some() {
            return (Way::FixedPoint, "unknowns have bounds");
        }
        let energy = problem.energy();
        match (energy.is_quadratic(), problem.has_exact_gaps()) {
            (true, true) => (Way::Condensed, "quadratic energy and exact rows"),
            (true, false) => (Way::Newton, "projections follow the bodies"),
            (false, _) => (Way::Newton, "the energy is not quadratic"),
        }
    }

    /// The equilibrium to which Newton's method comes from that of the fixed point, with the history of both. The fixed point's stays where Newton's
    /// method does not end, or ends elsewhere at no lower energy.
    #[cfg(feature = "ipopt")]
    fn examined(
        &mut self,
        problem: &dyn ContactProblem,
        found: Solution,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let own = self.newton.solve(problem, found.state.clone(), context)?;
        let least = least_displacement(problem, Scale::of(problem, &found.state.u)?.length);
        let is_same = relative_change(&own.state.u, &found.state.u, least) < SAME;
        let is_lower = own.energy < found.energy;
        if own.outcome != Outcome::Converged || !(is_same || is_lower) {
            let cause = "from the equilibrium that the fixed point has found";
            let solver = self.newton.choice(problem).solver;
            return Ok(found.after(own, solver, Some(cause.into())));
        }
        let mut history = found.history;
        history.extend(own.history);
        Ok(Solution {
            history,
            failed: found.failed,
            ..own
        })
    }

    /// The solver of a way.
    fn solver(&self, way: Way) -> &dyn Equilibrium {
        match way {
            Way::Condensed => &self.condensed,
            Way::Newton => &self.newton,
            #[cfg(feature = "ipopt")]
            Way::FixedPoint => &self.fixed_point,
        }
    }

    /// The same, to solve with.
    fn solver_mut(&mut self, way: Way) -> &mut dyn Equilibrium {
        match way {
            Way::Condensed => &mut self.condensed,
            Way::Newton => &mut self.newton,
            #[cfg(feature = "ipopt")]
            Way::FixedPoint => &mut self.fixed_point,
        }
    }
}

impl Default for Automatic {
    fn default() -> Self {
        Automatic::with_tolerance(CondensedNewton::default().tolerance)
    }
}

impl Equilibrium for Automatic {
    #[cfg(feature = "ipopt")]
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let (way, _) = Self::way(problem);
        if way == Way::FixedPoint {
            return self.fixed_point.solve(problem, start, context);
        }
        let first = self
            .solver_mut(way)
            .solve(problem, start.clone(), context)?;
        match first.outcome {
            Outcome::Converged | Outcome::Interrupted | Outcome::InadmissibleStart => Ok(first),
            _ => {
                memory::check_run(&self.fixed_point, problem, context.stop.memory())?;
                let start = match context.is_lifted {
                    true => start,
                    false => (context.lifted)(),
                };
                let mut second = self.fixed_point.solve(problem, start, context)?;
                let is_found = second.outcome == Outcome::Converged;
                // with friction, a lower energy does not tell the better state
                if way == Way::Newton && is_found && !problem.has_friction() {
                    second = self.examined(problem, second, context)?;
                }
                let cause = problem.diagnose(&first);
                Ok(second.after(first, self.choice(problem).solver, cause))
            }
        }
    }

    #[cfg(not(feature = "ipopt"))]
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let (way, _) = Self::way(problem);
        self.solver_mut(way).solve(problem, start, context)
    }

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        let (way, why) = Self::way(problem);
        Choice {
            why,
            ..self.solver(way).choice(problem)
        }
    }

    fn lifts_starts(&self, problem: &dyn ContactProblem) -> bool {
        self.solver(Self::way(problem).0).lifts_starts(problem)
    }

    fn validate(&self) -> Result<(), Error> {
        #[cfg(feature = "ipopt")]
        self.fixed_point.validate()?;
        self.newton.validate()
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        let (way, _) = Self::way(problem);
        self.solver(way).memory(problem)
    }
}
