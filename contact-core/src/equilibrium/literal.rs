//! Algorithm 2 as a straightforward script has it, to compare with one step by step.

use std::time::Instant;

use super::{
    Acceleration, Choice, Equilibrium, Failed, FixedPoint, Solution, StepContext,
    check_frictionless, check_independent,
};
use crate::gaps::Sampling;
use crate::ipopt::{Options, Sequence, SequenceSettings};
use crate::linear::SymmetricPattern;
use crate::method::interior_point::structure;
use crate::method::scaled::{Scaled, check_memory, check_tolerance};
use crate::method::{Method, Minimum, Subproblem};
use crate::nlp::Bounds;
use crate::{ContactProblem, Energy, Error, LinearGaps, MemoryNeed, Outcome, Scale, State};

/// Algorithm 2 of the paper without what this library adds: each subproblem is given to Ipopt in the user's units, with its own
/// default settings and a cold start; the iteration is plain; the start is the last state, with prescribed unknowns moved.
///
/// `freefem/disc_in_disc_literal.edp` is such a script, and numbers of iterations agree with it. Use it with
/// [`LoadSteps::predictor`](crate::LoadSteps::predictor) off.
#[derive(Clone, Debug, PartialEq)]
pub struct Literal {
    /// TOLER, as [`FixedPoint::tolerance`]; 1e-8 by default.
    pub tolerance: f64,
    /// The limit of the fixed point's iterations; 30 by default.
    pub max_iterations: usize,
    /// Ipopt's `tol`, `compl_inf_tol` and `constr_viol_tol`, in the user's units; 1e-10 by default.
    pub ipopt_tolerance: f64,
    /// Whether an increment that reaches the limit counts as converged and the run goes on with its last iterate, as such a
    /// script does; off by default. [`Solution::failed`] names it then.
    pub goes_on: bool,
    /// What is done otherwise all the same, to see what it changes; nothing by default.
    pub departures: Departures,
}

/// What the library's fixed point does and a straightforward script does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Departures {
    /// Anderson acceleration over as many differences as [`Acceleration::default`] has.
    pub acceleration: bool,
    /// Ipopt starts from the last multipliers.
    pub warm_starts: bool,
    /// Ipopt gets the problem in its [`Scale`], to which its tolerances are relative then.
    pub units: bool,
    /// Ipopt's steps keep volume ratios above a tenth of their last values.
    pub guard: bool,
    /// Free unknowns follow prescribed ones at the start of a load step.
    pub lift: bool,
}

impl Default for Literal {
    fn default() -> Self {
        Literal {
            tolerance: 1e-8,
            max_iterations: 30,
            ipopt_tolerance: 1e-10,
            goes_on: false,
            departures: Departures::default(),
        }
    }
}

impl Literal {
    fn fixed_point(&self) -> FixedPoint<Cold> {
        FixedPoint {
            method: Cold {
                tolerance: self.ipopt_tolerance,
                is_warm: self.departures.warm_starts,
            },
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            acceleration: match self.departures.acceleration {
                true => Acceleration::default(),
                false => Acceleration::Plain,
            },
        }
    }
}

impl Equilibrium for Literal {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        check_independent(problem, "Literal")?;
        check_frictionless(problem, "Literal")?;
        let plain = Plain {
            problem,
            energy: Unguarded(problem.energy()),
            departures: self.departures,
        };
        let mut fixed_point = self.fixed_point();
        let mut solution = fixed_point.solve_to_the_limit(&plain, start, context)?;
        if self.goes_on && solution.outcome == Outcome::IterationLimit {
            solution.failed.push(Failed {
                solver: "literal",
                outcome: Outcome::IterationLimit,
                cause: None,
            });
            solution.outcome = Outcome::Converged;
        }
        Ok(solution)
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        check_frictionless(problem, "Literal")
    }

    fn validate(&self) -> Result<(), Error> {
        self.fixed_point().validate()?;
        check_tolerance("ipopt_tolerance", self.ipopt_tolerance)
    }

    fn choice(&self, _problem: &dyn ContactProblem) -> Choice {
        Choice {
            solver: "literal",
            why: Choice::GIVEN,
        }
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        self.fixed_point().memory(problem)
    }

    /// Starts are taken as they are.
    fn lifts_starts(&self, _problem: &dyn ContactProblem) -> bool {
        !self.departures.lift
    }
}

/// Ipopt at this tolerance.
struct Cold {
    tolerance: f64,
    is_warm: bool,
}

impl Method for Cold {
    fn name(&self) -> &'static str {
        "literal"
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        crate::InteriorPoint::default().memory(energy)
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let clock = Instant::now();
        let mut scaled = Scaled::new(subproblem);
        let x = scaled.displacements(start);
        let options = Options::new()
            .with("tol", self.tolerance)
            .with("compl_inf_tol", self.tolerance)
            .with("constr_viol_tol", self.tolerance)
            .with("acceptable_iter", 0)
            .with("bound_relax_factor", 0.0)
            .with("nlp_scaling_method", "none")
            // ff-Ipopt's default, not Ipopt's
            .with("mu_strategy", "adaptive")
            .with("max_iter", 300);
        let settings = SequenceSettings {
            options,
            ..SequenceSettings::default()
        };
        let mut sequence = Sequence::new(structure(subproblem)?, settings, &x)?;
        if self.is_warm && !start.multipliers.is_empty() {
            sequence.restart(&x, Some(scaled.multipliers(start, x.len())))?;
        }
        let run = sequence.solve(&mut scaled)?;
        check_memory(&run, subproblem.energy)?;
        let wall = clock.elapsed().as_secs_f64();
        let cost = scaled.cost(sequence.totals(), &run, wall);
        Ok(scaled.minimum(run, cost))
    }
}

/// A problem in the user's units, whose steps no domain function limits.
struct Plain<'a> {
    problem: &'a dyn ContactProblem,
    energy: Unguarded<'a>,
    departures: Departures,
}

struct Unguarded<'a>(&'a dyn Energy);

impl Energy for Unguarded<'_> {
    fn dofs(&self) -> usize {
        self.0.dofs()
    }
    fn value(&self, u: &[f64]) -> f64 {
        self.0.value(u)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.0.gradient(u, g);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.0.hessian_pattern()
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        self.0.hessian(u, values);
    }
    fn is_quadratic(&self) -> bool {
        self.0.is_quadratic()
    }
}

impl ContactProblem for Plain<'_> {
    fn energy(&self) -> &dyn Energy {
        match self.departures.guard {
            true => self.problem.energy(),
            false => &self.energy,
        }
    }
    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_gaps(u, sampling)
    }
    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_reversed(u, sampling)
    }
    fn has_exact_gaps(&self) -> bool {
        self.problem.has_exact_gaps()
    }
    fn scale(&self) -> Option<Scale> {
        match self.departures.units {
            true => self.problem.scale(),
            false => Some(Scale::default()),
        }
    }
    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}
