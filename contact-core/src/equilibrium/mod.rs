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
//! | `diagonal` | the diagonal in units of which shifts and springs are chosen, with the feature `linear` |
//! | `literal` | the fixed point as a straightforward script has it, with the feature `ipopt` |
//! | `automatic` | the solver that fits a problem, with the feature `linear` |
//! | `retry` | further attempts where the fixed point does not converge |
//! | `resumable` | answers kept in a file, so that a run goes on where it ended, with the feature `resume` |
//! | `newton` | Newton's method with contact condensed onto its rows, with the feature `linear` |
//! | `condensed` | convex quadratic programs condensed onto their rows, with the feature `linear` |

mod accuracy;
pub mod anderson;
#[cfg(feature = "linear")]
mod automatic;
#[cfg(feature = "linear")]
mod condensed;
mod cycles;
#[cfg(feature = "linear")]
mod diagonal;
pub mod fixed_point;
mod journal;
#[cfg(feature = "ipopt")]
mod literal;
#[cfg(feature = "linear")]
mod newton;
#[cfg(feature = "resume")]
pub(crate) mod resumable;
mod retry;

pub use anderson::Acceleration;
#[cfg(feature = "linear")]
pub use automatic::Automatic;
#[cfg(feature = "linear")]
pub use condensed::Condensed;
pub use fixed_point::{FixedPoint, relative_change};
#[cfg(feature = "ipopt")]
pub use literal::{Departures, Literal};
#[cfg(feature = "linear")]
pub use newton::CondensedNewton;
#[cfg(feature = "resume")]
pub use resumable::{Kept, Resumable, kept};
pub use retry::Retry;

use std::fmt;

#[cfg(feature = "linear")]
use self::condensed::halt::Halt;
use crate::LOG;
use crate::cost::Name;
use crate::friction::Friction;
use crate::reduction;
#[cfg(feature = "linear")]
use crate::{Bounds, gaps::Sampling, method::check_bounds};
use crate::{ContactProblem, Cost, Error, LinearGaps, MemoryNeed, Outcome, RowKey, State, Stop};

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

    /// Checks that the solver treats problems of this kind; called before a run starts. The default accepts any.
    ///
    /// # Errors
    /// What [`Equilibrium::solve`] would refuse in any state, such as an energy that is not quadratic.
    fn check(&self, _problem: &dyn ContactProblem) -> Result<(), Error> {
        Ok(())
    }

    /// The solver that `problem` gets first, for records.
    fn choice(&self, _problem: &dyn ContactProblem) -> Choice {
        Choice {
            solver: "custom",
            why: Choice::GIVEN,
        }
    }

    /// What a run on `problem` will take, by an estimate; `None` where there is none.
    fn memory(&self, _problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        None
    }

    /// Whether the solver lifts a start itself where its result depends on it, see [`StepContext::is_lifted`].
    fn lifts_starts(&self, _problem: &dyn ContactProblem) -> bool {
        false
    }

    /// Solves a single problem, without load steps.
    ///
    /// # Errors
    /// As [`Equilibrium::solve`].
    fn solve_from(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
    ) -> Result<Solution, Error> {
        let (again, stop) = (start.clone(), Stop::new());
        let lifted = || again.clone();
        let context = StepContext::single(&again, &lifted, &stop);
        reduction::solve(self, problem, start, &context)
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

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        (**self).choice(problem)
    }

    fn lifts_starts(&self, problem: &dyn ContactProblem) -> bool {
        (**self).lifts_starts(problem)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        (**self).check(problem)
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        (**self).memory(problem)
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

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        (**self).choice(problem)
    }

    fn lifts_starts(&self, problem: &dyn ContactProblem) -> bool {
        (**self).lifts_starts(problem)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        (**self).check(problem)
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        (**self).memory(problem)
    }
}

/// A solver and the reason why it was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Its name: `ipopt`, `newton`, `condensed`, or `custom` for solvers of other crates.
    pub solver: &'static str,
    /// The reason.
    pub why: &'static str,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.solver, self.why)
    }
}

impl Choice {
    /// The reason of a solver that does not look at the problem.
    pub const GIVEN: &str = "as asked for";
}

/// The load step that a solve belongs to.
pub struct StepContext<'a> {
    /// The last converged state.
    pub last: &'a State,
    /// The load factor of that state.
    pub from: f64,
    /// The load factor to reach.
    pub to: f64,
    /// Whether a phase of the run, or the run, ends there.
    pub is_end: bool,
    /// A start that is not extrapolated: the last state, with its free unknowns moved along with the prescribed ones.
    /// See [`LoadStepped::lift`](crate::LoadStepped::lift).
    pub lifted: &'a dyn Fn() -> State,
    /// Whether the start is the one to take: it is extrapolated, lifted or given. It is the last state as it is where the
    /// solver [lifts starts](Equilibrium::lifts_starts) and there is nothing to extrapolate from.
    pub is_lifted: bool,
    /// The request to stop, with the run's budget: see [`Stop::begin_factorization`].
    pub stop: &'a Stop,
}

impl<'a> StepContext<'a> {
    /// The context of a single solve without load steps: from `start` at load 0 to full load.
    pub fn single(start: &'a State, lifted: &'a dyn Fn() -> State, stop: &'a Stop) -> Self {
        StepContext {
            last: start,
            from: 0.0,
            to: 1.0,
            is_end: true,
            lifted,
            is_lifted: true,
            stop,
        }
    }
}

/// One iteration of the fixed point or of Newton's method.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Iteration {
    /// The solver, see [`Choice::solver`].
    #[cfg_attr(
        feature = "resume",
        serde(deserialize_with = "crate::equilibrium::resumable::name")
    )]
    pub solver: Name,
    /// The relative change of u, see [`relative_change`]; infinite if the subproblem was not solved.
    pub error: f64,
    /// The number of rows.
    pub rows: usize,
    /// Its cost.
    pub cost: Cost,
}

impl Iteration {
    /// Appends it to the history at its load, and tells the application's logger.
    pub(crate) fn record(self, history: &mut Vec<Iteration>) {
        log::debug!(
            target: LOG,
            "{}, iteration {}: u changes by {:.1e}, {} rows, {} factorisations, {:.3} s",
            self.solver, history.len() + 1, self.error, self.rows, self.cost.factorizations, self.cost.wall
        );
        history.push(self);
    }
}

/// The last iterate of the search for equilibrium, its outcome and the history.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Solution {
    /// The outcome. The other fields describe an equilibrium only if it is [`Outcome::Converged`].
    pub outcome: Outcome,
    /// The last minimum and its multipliers by row key.
    pub state: State,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The rows that `lambda` belongs to: those of the last subproblem, or those at u itself.
    pub gaps: LinearGaps,
    /// Their multipliers λ ≥ 0 (UF).
    pub lambda: Vec<f64>,
    /// One entry per iteration, those of failed attempts included.
    pub history: Vec<Iteration>,
    /// The attempts at this load that failed before, in order.
    pub failed: Vec<Failed>,
    /// The smallest curvature found along motions that the closed rows permit, relative to the solver's matrix: at most 1,
    /// and negative at an equilibrium that is unstable. `None` where it was not looked for.
    pub curvature: Option<f64>,
    /// Rows that opened or closed in the last iteration of a solve that did not converge.
    pub flickering: Vec<RowKey>,
    /// Forces (n, UF) on motions that neither supports nor closed rows resist, which keep them where they are: ∇E = Cᵀλ + them. Empty
    /// where nothing needs them.
    #[cfg_attr(feature = "resume", serde(default))]
    pub held: Vec<f64>,
    /// Where motions are held: the softest motion v (n) that the closed rows permit, and the curvature of the energy along it,
    /// vᵀ(K − sym D)v (UF·UL for v in UL), negative where it releases energy.
    #[cfg_attr(feature = "resume", serde(default))]
    pub softest: Option<(Vec<f64>, f64)>,
    /// The friction, whose forces belong to the equilibrium: ∇E = Cᵀλ − Tᵀr. `None` where the problem has none.
    #[cfg_attr(feature = "resume", serde(default))]
    pub friction: Option<Friction>,
}

/// An attempt at a load step after which another solver, or another setting, was tried.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Failed {
    /// The solver, see [`Choice::solver`].
    #[cfg_attr(
        feature = "resume",
        serde(deserialize_with = "crate::equilibrium::resumable::name")
    )]
    pub solver: Name,
    /// How it ended.
    pub outcome: Outcome,
    /// The cause that its last iterate shows, see [`ContactProblem::diagnose`].
    pub cause: Option<String>,
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.solver, self.outcome)?;
        match &self.cause {
            Some(cause) => write!(f, ", {cause}"),
            None => Ok(()),
        }
    }
}

impl Solution {
    /// The sum of the costs in the history.
    pub fn cost(&self) -> Cost {
        self.history.iter().map(|iteration| iteration.cost).sum()
    }

    /// The same, but failed where it claims to have converged to an energy or to unknowns that are no numbers.
    pub(crate) fn checked(mut self) -> Self {
        let mut values = self.state.u.iter().chain(&self.lambda);
        if self.outcome == Outcome::Converged && !self.energy.is_finite() {
            let why = format!("the energy of its result is {}", self.energy);
            self.outcome = Outcome::SubproblemFailed(why);
        } else if self.outcome == Outcome::Converged && !values.all(|value| value.is_finite()) {
            let why = "its result has values that are not finite".to_string();
            self.outcome = Outcome::SubproblemFailed(why);
        }
        self
    }

    /// This solution after `first` by `solver`, which failed for this cause.
    pub(crate) fn after(
        mut self,
        first: Solution,
        solver: &'static str,
        cause: Option<String>,
    ) -> Self {
        self.history.splice(..0, first.history);
        let own = Failed {
            solver,
            outcome: first.outcome,
            cause,
        };
        self.failed
            .splice(..0, first.failed.into_iter().chain([own]));
        self
    }
}

/// Displacements below this share of [`Scale::length`](crate::Scale) count as zero: bodies that carry no load.
const NONE: f64 = 1e-6;

/// The length (UL) that the denominator of [`relative_change`] is at least, with the unit of lengths.
fn least_displacement(problem: &dyn ContactProblem, length: f64) -> f64 {
    problem.prescribed_magnitude().max(NONE * length)
}

/// [`Error::Setting`] unless both are in range. `remedy` names the default of the tolerance.
fn check_settings(
    tolerance: f64,
    max_iterations: usize,
    remedy: &'static str,
) -> Result<(), Error> {
    let is_share = tolerance > 0.0 && tolerance < 1.0;
    Error::check_setting(is_share, "tolerance", tolerance, remedy)?;
    if max_iterations == 0 {
        return Err(Error::Setting {
            name: "max_iterations",
            value: "0".into(),
            remedy: "allow at least one iteration",
        });
    }
    Ok(())
}

/// The rows of both roles at u (steps 1 to 4 of Algorithm 2), one for each contact node.
#[cfg(feature = "linear")]
fn rows_of_both_roles(
    problem: &dyn ContactProblem,
    u: &[f64],
    stop: &Stop,
) -> Result<LinearGaps, Halt> {
    Halt::if_requested(stop)?;
    let forward = problem.linearize_gaps(u, Sampling::Nodes)?;
    Halt::if_requested(stop)?;
    Ok(forward.and(problem.linearize_reversed(u, Sampling::Nodes)?))
}

/// The end of a solve at its start, with energy E there.
#[cfg(feature = "linear")]
fn unchanged(start: State, energy: f64, outcome: Outcome) -> Solution {
    Solution {
        outcome,
        energy,
        state: start,
        gaps: LinearGaps::new(true),
        lambda: Vec::new(),
        history: Vec::new(),
        failed: Vec::new(),
        curvature: None,
        flickering: Vec::new(),
        held: Vec::new(),
        softest: None,
        friction: None,
    }
}

/// An unknown and its bound (UL), if there is one.
#[cfg(feature = "linear")]
fn finite_bound(bounds: &Bounds) -> Option<(usize, f64)> {
    let of = |bounds: &[f64]| {
        let mut all = bounds.iter().copied().enumerate();
        all.find(|(_, bound)| bound.is_finite())
    };
    of(&bounds.lower).or_else(|| of(&bounds.upper))
}

/// Checks that no unknown depends on others, which is left to those that call solvers.
fn check_independent(problem: &dyn ContactProblem, solver: &'static str) -> Result<(), Error> {
    match problem.reduction() {
        Some(reduction) if !reduction.map.dependents().is_empty() => Err(Error::Untreated {
            solver,
            what: "a number of dependent unknowns",
            value: reduction.map.dependents().len().to_string(),
            remedy: "call `Equilibrium::solve_from` or `LoadSteps::run` in place of `solve`",
        }),
        _ => Ok(()),
    }
}

/// Checks that no row has friction, which `solver` does not treat.
#[cfg(any(feature = "linear", feature = "ipopt"))]
fn check_frictionless(problem: &dyn ContactProblem, solver: &'static str) -> Result<(), Error> {
    match problem.has_friction() {
        true => Err(Error::Untreated {
            solver,
            what: "contact with friction",
            value: "true".into(),
            remedy: "solve by `FixedPoint`",
        }),
        false => Ok(()),
    }
}

/// Checks the start, and that no unknown has a finite bound, which `solver` does not treat.
#[cfg(feature = "linear")]
fn check_unbounded(
    problem: &dyn ContactProblem,
    start: &State,
    solver: &'static str,
) -> Result<(), Error> {
    check_independent(problem, solver)?;
    let (bounds, dofs) = (problem.bounds(), problem.energy().dofs());
    Error::check_vector("start.u", &start.u, dofs)?;
    check_bounds(bounds, dofs)?;
    match finite_bound(bounds) {
        Some((k, bound)) => Err(Error::Untreated {
            solver,
            what: "a bound on the unknowns",
            value: format!("{bound} on unknown {k}"),
            remedy: "state it as a row of the gaps, or solve by `FixedPoint`",
        }),
        None => Ok(()),
    }
}
