//! Newton's method on the energy, with contact condensed onto its rows.
//!
//! | file | role |
//! |---|---|
//! | `anchored` | springs to an anchor that follows, where the iteration does not end without |
//! | `groups` | bodies that do not act on each other, solved by themselves |
//! | `iterate` | the iteration at one load, and when it ends |
//! | `linearization` | E and the gaps at u, to second order |
//! | `point` | a state with the rows at it |
//! | `slips` | friction, as rows of slips after those of contact |
//! | `step` | Newton's step, the solution of the linearised contact problem |
//! | `tangent` | the matrix that is factored |
//! | `trial` | where a step ends that may not leave the domain of the energy |
//! | `watchdog` | progress, and the way back where there is none |
//! | `stability` | the curvature along the softest motion |
//!
//! An equilibrium of Algorithm 2 satisfies ∇E(u) = C(u)ᵀλ and 0 ≤ λ ⟂ c(u) ≥ 0, with projections and normals taken at u
//! itself. With K = ∇²E, G = ∂c/∂u and D = ∂(C(u)ᵀλ)/∂u at u, Newton's step x and the new multipliers μ solve
//!
//! (K − D) x + ∇E = Cᵀμ,   0 ≤ μ ⟂ c + G x ≥ 0.
//!
//! D is not symmetric, and G is not C: forces along averaged normals have no potential. The step is therefore found by
//! defect correction with a symmetric matrix S near K − D:
//!
//! S (x' − x) = Cᵀμ − ∇E − (K − D) x,   0 ≤ μ ⟂ c + G x + C (x' − x) ≥ 0,
//!
//! accelerated by Anderson's method. S is factored; the rows see its dense compliance W = C S⁻¹ Cᵀ, on which the
//! complementarity is solved exactly. S = K as long as K is positive definite. From the first K on that is not, S = K − sym D +
//! Σ s_i C_iᵀC_i over the rows that act, and the defect has the terms s_i C_iᵀ(c + G x)_i too. They vanish where these rows
//! stay closed. A row that opens leaves the defect in the next step, and S before the iteration ends, so that equilibria are the
//! same. S and its factor are kept for further steps as long as these are short and easily corrected.

mod anchored;
mod groups;
mod iterate;
mod linearization;
mod point;
mod slips;
mod stability;
mod step;
mod tangent;
#[cfg(test)]
mod tests;
mod trial;
mod watchdog;

use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

use self::groups::Found;
use self::iterate::Iterate;
use self::point::Point;
use self::slips::Slips;
use self::tangent::Tangent;
use self::watchdog::Watchdog;
use super::condensed::halt::Halt;
use super::{
    Choice, Equilibrium, Iteration, Solution, StepContext, check_settings, check_unbounded,
    least_displacement,
};
use crate::cost::FactorSize;
use crate::{
    ContactProblem, Cost, Error, LinearGaps, MemoryNeed, Multipliers, Outcome, RowKey, Scale, State,
};

/// Equilibrium by Newton's method on the energy, with contact condensed onto its rows and re-projected in every
/// iteration: the equilibria of Algorithm 2, without an inner optimiser.
///
/// The matrix of a step is factored, the rows that may act see its dense compliance, and their multipliers solve a linear
/// complementarity problem. The step takes into account that projections and normals move, see
/// [`ContactProblem::vary_gaps`]. It is accurate to a tenth at first, and to a thousandth where steps become rapidly shorter.
///
/// A step is shortened where it would take a domain function ([`Energy::domain`](crate::Energy::domain)) below a tenth of its value. Where neither
/// energy and overlap nor the change of u fall for a few iterations, the method returns to the best state and takes a shorter
/// step. A converged state is checked at u itself: rows, forces and what they would still move.
///
/// An equilibrium at the first load, at the end of a phase, where contact forces have doubled, and where the energy has become flatter along
/// the softest motion of the last one is examined for motions that the
/// closed rows permit and that release energy. Where there is one, the method moves along it and goes on; if it does not
/// come to another equilibrium, the unstable one is the solution, and [`Solution::curvature`] tells.
///
/// Where the iteration does not end, it is repeated with springs to an anchor that follows. Motions that nothing but these springs
/// resists are held where they are, if that takes a small share of the contact forces, and [`Solution::held`] tells.
///
/// The factor is kept for the next iteration and the next load step while steps are short and easily corrected, and that of
/// a body with a quadratic energy as long as no row adds stiffness to it. Clones start without it.
///
/// Where the problem is [`Separable`](crate::Separable), bodies on which no common row acts are solved by themselves. Rows
/// that turn out to act between them join them, and they are solved again from the start.
///
/// In [`Cost`], an outer iteration is a step of Newton's method, a solve is a linear complementarity problem, and an inner
/// iteration is a step towards its active rows. Iterations of several groups with the same number count as one, and so do
/// their factorisations; a budget counts those of each group.
pub struct CondensedNewton {
    /// Bound on the relative change of u in the last iteration, see [`relative_change`](super::relative_change). Rows are closed, and forces in
    /// equilibrium, to the same share of the displacements, but at most to 1e-10.
    pub tolerance: f64,
    /// The iteration limit.
    pub max_iterations: usize,
    /// What the next load step can use again, for each group of bodies; that of the whole has none.
    kept: BTreeMap<Vec<usize>, Kept>,
    search: Search,
}

/// How load steps are searched for an equilibrium: what the next one can use, and what holds during this one.
#[derive(Default)]
struct Search {
    /// The stiffness of the springs at the end of the last load step that needed some, and the smallest one that may be tried.
    springs: Option<(f64, f64)>,
    /// The number of load steps, one after the other, that were tried without springs in vain.
    failures: usize,
    /// Whether supports alone do not hold some body.
    floats: bool,
    /// The stiffness of the springs at present (n, UF/UL); empty without springs.
    weights: Vec<f64>,
    /// Whether an equilibrium is to be examined in any case.
    suspects: bool,
    /// Beside the unstable equilibrium that was found last, if no other one was.
    beside: Option<State>,
}

/// What the next load step can use again.
struct Kept {
    tangent: Tangent,
    /// The sum of the multipliers of the last equilibrium that was examined (UF).
    examined: f64,
    /// Its softest motion v, and the curvature of the energy along it, vᵀ(K − sym D)v (UF·UL).
    watched: Option<(Vec<f64>, f64)>,
}

impl Default for CondensedNewton {
    fn default() -> Self {
        CondensedNewton {
            tolerance: 1e-8,
            max_iterations: 30,
            kept: BTreeMap::new(),
            search: Search::default(),
        }
    }
}

impl Clone for CondensedNewton {
    fn clone(&self) -> Self {
        CondensedNewton {
            kept: BTreeMap::new(),
            search: Search::default(),
            ..*self
        }
    }
}

impl fmt::Debug for CondensedNewton {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CondensedNewton")
            .field("tolerance", &self.tolerance)
            .field("max_iterations", &self.max_iterations)
            .finish_non_exhaustive()
    }
}

/// The name in records.
const NAME: &str = "newton";
/// Rows are closed to this share of the displacements, whatever the tolerance: steps leave so much.
const CLOSED: f64 = 1e-10;
/// Where the iteration without springs was in vain at more load steps in a row, it is not tried any more.
const PATIENCE: usize = 1;
/// Bodies that contact holds are held by it after so many iterations, or they need springs.
const SETTLED: usize = 3;

impl Equilibrium for CondensedNewton {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        self.validate()?;
        check_unbounded(problem, &start, "CondensedNewton")?;
        let known = std::mem::take(&mut self.search);
        if context.from > 0.0 {
            (self.search.springs, self.search.failures) = (known.springs, known.failures);
        }
        self.search.floats = problem.separable().is_some_and(|bodies| {
            let mut all = bodies.bodies().into_iter().enumerate();
            all.any(|(b, energy)| energy.dofs() > 0 && !bodies.is_held(b))
        });
        let mut solution = match self.search.failures > PATIENCE {
            true => self.solve_anchored(problem, &start, false, context)?,
            false => self.solve_plainly(problem, start, context)?,
        };
        if let Some(beside) = self.search.beside.take() {
            let mut other = self.solve_anchored(problem, &beside, true, context)?;
            solution.history.append(&mut other.history);
            if other.outcome == Outcome::Converged && other.energy < solution.energy {
                solution = Solution {
                    history: solution.history,
                    ..other
                };
            }
        }
        Ok(solution.checked())
    }

    fn choice(&self, _problem: &dyn ContactProblem) -> Choice {
        Choice {
            solver: NAME,
            why: Choice::GIVEN,
        }
    }

    fn validate(&self) -> Result<(), Error> {
        let remedy = "choose a value between 0 and 1; the default is 1e-8";
        check_settings(self.tolerance, self.max_iterations, remedy)
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        MemoryNeed::of_energy(problem.energy()).ok()
    }
}

/// How the iteration at one load ended, see [`Solution`].
struct Ended {
    outcome: Outcome,
    curvature: Option<f64>,
    flickering: Vec<RowKey>,
}

impl Ended {
    fn with(outcome: Outcome) -> Self {
        Ended {
            outcome,
            curvature: None,
            flickering: Vec::new(),
        }
    }
}

impl CondensedNewton {
    /// With this bound on the relative change of u.
    pub fn with_tolerance(tolerance: f64) -> Self {
        CondensedNewton {
            tolerance,
            ..CondensedNewton::default()
        }
    }

    /// Solves without springs, group by group and as one, and with springs where that does not end.
    fn solve_plainly(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        // slips of a group have no rows of its own
        let separable = problem.separable().filter(|_| !problem.has_friction());
        let found = match separable {
            Some(bodies) => self.solve_by_groups(problem, bodies, &start, context)?,
            None => Found::Whole(Vec::new()),
        };
        // the unknowns of a group are no state of the whole
        let mut history = match (found, self.search.beside.take()) {
            (Found::Solution(solution), None) => return Ok(*solution),
            (Found::Solution(solution), Some(_)) => {
                self.search.suspects = true;
                solution.history
            }
            (Found::Whole(history), _) => history,
        };
        self.kept.retain(|members, _| members.is_empty());
        let mut solution = self.solve_whole(problem, start.clone(), &[], context)?;
        history.append(&mut solution.history);
        match solution.outcome {
            Outcome::Converged => self.search.failures = 0,
            Outcome::Interrupted | Outcome::InadmissibleStart => {}
            _ => {
                self.search.failures += 1;
                solution = self.solve_anchored(problem, &start, false, context)?;
                history.append(&mut solution.history);
            }
        }
        Ok(Solution {
            history,
            ..solution
        })
    }

    /// Solves a problem as one, with what is kept for these bodies.
    fn solve_whole(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        bodies: &[usize],
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let mut at = Point {
            gaps: LinearGaps::new(false),
            slips: Slips::default(),
            lambda: Vec::new(),
            state: start,
        };
        let mut history = Vec::new();
        let energy = problem.energy().value(&at.state.u);
        let ended = match energy.is_finite() {
            true => self.iterate(problem, bodies, &mut at, energy, &mut history, context)?,
            false => Ended::with(Outcome::InadmissibleStart),
        };
        let energy = problem.energy().value(&at.state.u);
        let Point {
            mut state,
            mut gaps,
            slips,
            mut lambda,
        } = at;
        let mut friction = None;
        if problem.has_friction() {
            gaps = slips.contact_rows(&gaps).into_owned();
            state.multipliers = Multipliers::new(&gaps, &lambda[..gaps.len()]);
            friction = slips.friction(&lambda, &state.multipliers, context);
            lambda.truncate(gaps.len());
        }
        let solution = Solution {
            outcome: ended.outcome,
            curvature: ended.curvature,
            flickering: ended.flickering,
            energy,
            state,
            gaps,
            lambda,
            history,
            failed: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction,
        };
        Ok(solution)
    }

    fn iterate(
        &mut self,
        problem: &dyn ContactProblem,
        bodies: &[usize],
        at: &mut Point,
        start: f64,
        history: &mut Vec<Iteration>,
        context: &StepContext<'_>,
    ) -> Result<Ended, Error> {
        let energy = problem.energy();
        let kept = self.kept.entry(bodies.to_vec()).or_insert_with(|| Kept {
            tangent: Tangent::new(energy),
            examined: 0.0,
            watched: None,
        });
        if !kept.tangent.is_of(energy) {
            kept.tangent = Tangent::new(energy);
        }
        let Kept {
            tangent,
            examined,
            watched,
        } = kept;
        if context.from == 0.0 {
            tangent.begin();
            *watched = None;
        }
        if let Err(halt) = at.project(problem, context) {
            return Ok(Ended::with(halt.outcome()?));
        }
        let unit = Scale::of(problem, &at.state.u)?.length;
        let is_end = context.from == 0.0 || context.is_end || self.search.suspects;
        let mut iterate = Iterate {
            before: at.state.multipliers.clone(),
            examined: *examined,
            // other unknowns may be free than at the last load
            watched: watched.take().filter(|(v, _)| v.len() == at.state.u.len()),
            is_end,
            floats: self.search.floats,
            springs: &self.search.weights,
            curvature: None,
            softest: None,
            stable: None,
            unstable: None,
            left: 0,
            beside: None,
            steps: 0,
            frozen: 0,
            watchdog: Watchdog::new(at, start),
            problem,
            at,
            least: least_displacement(problem, unit),
            unit,
            tolerance: self.tolerance,
            length: None,
            context,
        };
        let mut left = self.max_iterations;
        let outcome = loop {
            if context.stop.is_requested() {
                break Ok(Outcome::Interrupted);
            }
            if left == 0 {
                break Ok(Outcome::IterationLimit);
            }
            let needs_springs =
                iterate.floats && iterate.springs.is_empty() && tangent.shift() > 0.0;
            if needs_springs && history.len() >= SETTLED {
                break Ok(Outcome::IterationLimit);
            }
            left -= 1;
            let clock = Instant::now();
            let mut cost = Cost {
                outer_iterations: 1,
                // that of the start
                values: usize::from(history.is_empty()),
                ..Cost::default()
            };
            let before = iterate.left;
            let moved = iterate.moved(tangent, &mut cost);
            cost.wall = clock.elapsed().as_secs_f64();
            cost.optimizer = (cost.wall - cost.projection - cost.callbacks).max(0.0);
            cost.factor = Some(FactorSize::of_entries(tangent.fill()));
            let iteration = Iteration {
                solver: NAME,
                error: moved.as_ref().map_or(f64::INFINITY, |moved| moved.error),
                rows: iterate.at.slips.contacts(),
                cost,
            };
            iteration.record(history);
            match moved {
                Ok(moved) if moved.is_over => break Ok(Outcome::Converged),
                Ok(_) if iterate.left > before => left = self.max_iterations,
                Ok(_) => {}
                Err(halt) => break Err(halt),
            }
        };
        *examined = iterate.examined;
        *watched = iterate.watched.take();
        let (outcome, curvature) = match (outcome, iterate.unstable.take()) {
            (Ok(Outcome::IterationLimit) | Err(Halt::Failed(_)), Some((point, curvature))) => {
                self.search.beside = iterate.beside.take();
                *iterate.at = point;
                tangent.forget();
                (Outcome::Converged, Some(curvature))
            }
            (outcome, _) => (outcome.or_else(Halt::outcome)?, iterate.curvature),
        };
        let flickering = match outcome {
            Outcome::Converged => Vec::new(),
            _ => iterate.switched(),
        };
        Ok(Ended {
            outcome,
            curvature,
            flickering,
        })
    }
}
