//! Newton's method on the energy, with contact condensed onto its rows.
//!
//! | file | role |
//! |---|---|
//! | `anchored` | springs to an anchor that follows, where the iteration does not end without |
//! | `groups` | bodies that do not act on each other, solved by themselves |
//! | `linearization` | E and the gaps at u, to second order |
//! | `step` | Newton's step, the solution of the linearised contact problem |
//! | `tangent` | the matrix that is factored |
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
mod linearization;
mod stability;
mod step;
mod tangent;
#[cfg(test)]
mod tests;
mod watchdog;

use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

use self::groups::Found;
use self::linearization::Linearization;
use self::stability::{Softest, dot};
use self::step::{Accuracy, Step};
use self::tangent::Tangent;
use self::watchdog::Watchdog;
use super::condensed::halt::Halt;
use super::{
    Choice, Equilibrium, Iteration, Solution, StepContext, check_settings, check_unbounded,
    least_displacement, relative_change, rows_of_both_roles,
};
use crate::cost::FactorSize;
use crate::{
    ContactProblem, Cost, Energy, Error, LinearGaps, MemoryNeed, Multipliers, Outcome, RowKey,
    Scale, State, Stop,
};

/// Equilibrium by Newton's method on the energy, with contact condensed onto its rows and re-projected in every
/// iteration: the equilibria of Algorithm 2, without an inner optimiser.
///
/// The matrix of a step is factored, the rows that may act see its dense compliance, and their multipliers solve a linear
/// complementarity problem. The step takes into account that projections and normals move, see
/// [`ContactProblem::vary_gaps`]. It is accurate to a tenth at first, and to a thousandth where steps become rapidly shorter.
///
/// A step is shortened where it would take a domain function ([`Energy::domain`]) below a tenth of its value. Where neither
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
    /// Bound on the relative change of u in the last iteration, see [`relative_change`]. Rows are closed, and forces in
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
/// A step may not take a domain function below this share of its value.
const GUARD: f64 = 0.1;
/// A small step with a larger shift of the diagonal, relative to K's, does not show convergence.
const SHIFT: f64 = 1e-5;
/// Rows are closed to this share of the displacements, whatever the tolerance: steps leave so much.
const CLOSED: f64 = 1e-10;
/// Corrections of a step below this share of the displacements are not needed, nor those below a tenth of the tolerance.
const NEGLIGIBLE: f64 = 1e-11;
/// The iteration also ends after a step of up to so many tolerances, relative to the displacements, if the state after the step is an
/// equilibrium to this share of the tolerance.
const NEARLY: f64 = 1e2;
const CLEARLY: f64 = 1e-2;
/// Equilibria are examined where the sum of the multipliers has grown by this factor.
const GROWN: f64 = 2.0;
/// They are examined, too, where the curvature along the softest motion is below this share of what it was.
const FLATTER: f64 = 0.7;
/// An unstable equilibrium is left by this share of the displacements, and then by so many steps with frozen rows: they
/// lead away from it, where Newton's lead back.
const PUSH: f64 = 0.05;
const FROZEN: usize = 8;
/// So many are left at one load.
const LEAVES: usize = 3;
/// A step is halved at most so often.
const HALVINGS: usize = 20;
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

/// u and its multipliers, with the rows at u.
#[derive(Clone)]
struct Point {
    state: State,
    gaps: LinearGaps,
    lambda: Vec<f64>,
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
        let found = match problem.separable() {
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
            lambda: Vec::new(),
            state: start,
        };
        let mut history = Vec::new();
        let energy = problem.energy().value(&at.state.u);
        let ended = match energy.is_finite() {
            true => self.iterate(problem, bodies, &mut at, energy, &mut history, context)?,
            false => Ended::with(Outcome::InadmissibleStart),
        };
        let solution = Solution {
            outcome: ended.outcome,
            curvature: ended.curvature,
            flickering: ended.flickering,
            energy: problem.energy().value(&at.state.u),
            state: at.state,
            gaps: at.gaps,
            lambda: at.lambda,
            history,
            failed: Vec::new(),
            held: Vec::new(),
            softest: None,
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
        if let Err(halt) = at.project(problem, context.stop) {
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
            unstable: None,
            left: 0,
            beside: None,
            frozen: 0,
            watchdog: Watchdog::new(at, start),
            problem,
            at,
            least: least_displacement(problem, unit),
            unit,
            tolerance: self.tolerance,
            length: None,
            stop: context.stop,
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
            history.push(Iteration {
                solver: NAME,
                error: moved.as_ref().map_or(f64::INFINITY, |moved| moved.error),
                rows: iterate.at.gaps.len(),
                cost,
            });
            match moved {
                Ok(moved) if moved.is_over => break Ok(Outcome::Converged),
                Ok(_) if iterate.left > before => left = self.max_iterations,
                Ok(_) => {}
                Err(halt) => break Err(halt),
            }
        };
        *examined = iterate.examined;
        *watched = iterate.watched.take();
        let (outcome, curvature) = match (outcome, iterate.unstable) {
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
            _ => iterate.at.state.multipliers.switched(&iterate.before),
        };
        Ok(Ended {
            outcome,
            curvature,
            flickering,
        })
    }
}

/// The iteration at one load.
struct Iterate<'a> {
    problem: &'a dyn ContactProblem,
    at: &'a mut Point,
    watchdog: Watchdog,
    /// Lower bound on the size of the displacements (UL), and bound on their relative change.
    least: f64,
    tolerance: f64,
    /// The unit of lengths (UL).
    unit: f64,
    /// The length of the last step, unshortened (UL).
    length: Option<f64>,
    /// The multipliers of the iterate before.
    before: Multipliers,
    /// The sum of the multipliers of the last equilibrium that was examined (UF), and its curvature in this load step.
    examined: f64,
    curvature: Option<f64>,
    /// See [`Kept::watched`].
    watched: Option<(Vec<f64>, f64)>,
    /// The softest motion, as examined in the last steps towards an equilibrium; `None` if the steps are longer.
    softest: Option<Softest>,
    /// Whether a phase begins or ends with this load step.
    is_end: bool,
    /// Whether supports alone do not hold some body.
    floats: bool,
    /// The stiffness of springs (n, UF/UL); empty without.
    springs: &'a [f64],
    /// The unstable equilibrium that was left last, with its curvature.
    unstable: Option<(Point, f64)>,
    /// How many were left.
    left: usize,
    /// Where it was left for.
    beside: Option<State>,
    /// The number of steps with frozen rows to come.
    frozen: usize,
    stop: &'a Stop,
}

/// How an iteration went.
struct Moved {
    /// The relative change of u.
    error: f64,
    /// Whether the iteration has converged.
    is_over: bool,
}

impl Moved {
    fn on(error: f64) -> Self {
        Moved {
            error,
            is_over: false,
        }
    }
}

impl Iterate<'_> {
    /// Moves by one step of Newton's method, or back to the best state.
    fn moved(&mut self, tangent: &mut Tangent, cost: &mut Cost) -> Result<Moved, Halt> {
        let trial = match self.trial(tangent, cost) {
            // away from the best state, what fails may be the state
            Err(Halt::Failed(why)) => match self.watchdog.retreat() {
                Some(best) => {
                    self.go_back_to(best, tangent);
                    return Ok(Moved::on(f64::INFINITY));
                }
                None => return Err(Halt::Failed(why)),
            },
            trial => trial?,
        };
        let error = relative_change(&trial.u, &self.at.state.u, self.least);
        let now = State {
            multipliers: Multipliers::new(&self.at.gaps, &trial.lambda),
            u: trial.u,
        };
        self.before = std::mem::replace(&mut self.at.state, now).multipliers;
        let clock = Instant::now();
        self.at.project(self.problem, self.stop)?;
        cost.projection += clock.elapsed().as_secs_f64();
        // a shortened step makes small changes far from a solution
        let whole = error / trial.share;
        if whole < NEARLY * self.tolerance && trial.varies {
            let is_small = whole < self.tolerance;
            // too stiff an S underestimates how far the forces that are left would move a row
            let holds_an_open_row = tangent.holds_an_open_row(&self.at.state.multipliers);
            let bound = match is_small && !holds_an_open_row {
                true => self.tolerance.max(CLOSED),
                false => CLEARLY * self.tolerance / tangent.ratio().max(1.0),
            };
            let measures = (bound, self.unit, self.least);
            if let Some(left) = self.at.equilibrium(self.problem, tangent, measures, cost)? {
                let can_leave = self.left < LEAVES && self.springs.is_empty();
                let softest = self.softest.take().filter(Softest::is_unstable);
                if let Some(softest) = softest.filter(|_| can_leave) {
                    self.leave(&softest, tangent)?;
                    return Ok(Moved::on(error));
                }
                // so does a shifted diagonal
                if tangent.shift() <= SHIFT {
                    return Ok(Moved {
                        error: if is_small { error } else { left },
                        is_over: true,
                    });
                }
            } else if is_small && holds_an_open_row {
                tangent.forget();
            }
        }
        let whole = match tangent.shift() > 0.0 {
            true => None,
            false => Some(whole),
        };
        if let Some(best) = self
            .watchdog
            .judge(self.at, trial.energy, trial.share, whole)
        {
            self.go_back_to(best, tangent);
        }
        Ok(Moved::on(error))
    }

    /// Leaves an unstable equilibrium along its softest motion.
    fn leave(&mut self, softest: &Softest, tangent: &mut Tangent) -> Result<(), Halt> {
        self.unstable = Some((self.at.clone(), softest.curvature));
        self.left += 1;
        let energy = self.problem.energy();
        let from = self.at.state.u.clone();
        let mut length = PUSH * self.at.size(self.least);
        let mut value = f64::INFINITY;
        for _ in 0..HALVINGS {
            let moved = from.iter().zip(&softest.motion);
            self.at.state.u = moved.map(|(u, v)| u + length * v).collect();
            value = energy.value(&self.at.state.u);
            if value.is_finite() {
                break;
            }
            length *= 0.5;
        }
        self.beside = Some(self.at.state.clone());
        self.at.project(self.problem, self.stop)?;
        self.watchdog = Watchdog::new(self.at, value);
        self.length = None;
        self.frozen = FROZEN;
        tangent.stiffen();
        Ok(())
    }

    fn go_back_to(&mut self, best: Point, tangent: &mut Tangent) {
        *self.at = best;
        self.length = None;
        tangent.forget();
    }

    /// The end of Newton's step from here, shortened as far as it must be.
    fn trial(&mut self, tangent: &mut Tangent, cost: &mut Cost) -> Result<Trial, Halt> {
        let (state, size) = (&self.at.state, self.at.size(self.least));
        let varies = self.frozen == 0;
        let mut here =
            Linearization::new(self.problem, state, &self.at.gaps, varies, self.stop, cost)?;
        here.springs = self.springs;
        self.frozen = self.frozen.saturating_sub(1);
        let accuracy = Accuracy {
            before: self.length.take(),
            negligible: NEGLIGIBLE.min(0.1 * self.tolerance) * size,
        };
        let step = loop {
            match Step::new(&here, tangent, size, &accuracy, self.stop, cost) {
                Err(Halt::Failed(_)) if !tangent.is_fresh() => tangent.forget(),
                Ok(step) if !step.is_settled && !tangent.is_fresh() => tangent.forget(),
                Ok(step) if !step.is_settled && tangent.raise() => {}
                step => break step?,
            }
        };
        self.length = Some(step.length);
        let limit = self.watchdog.limit();
        let mut trial = Trial::new(self.problem.energy(), &here, state, &step, limit, cost)?;
        trial.varies = varies;
        let error = relative_change(&trial.u, &state.u, self.least);
        tangent.moved(error, step.corrections);
        let pushed: f64 = step.lambda.iter().sum();
        let is_last = error / trial.share < NEARLY * self.tolerance && varies;
        if !is_last {
            self.softest = None;
        }
        // a matrix that is not positive definite may show an unstable equilibrium, or a motion that nothing resists
        let is_flat = tangent.shift() > SHIFT;
        if is_last && (is_flat && !self.floats || !is_flat && self.is_due(&here, pushed)) {
            self.softest = Softest::new(&here, tangent, &step.condensed, &step.lambda, self.stop)?;
            self.curvature = self.softest.as_ref().map(|softest| softest.curvature);
            self.examined = pushed;
            self.watched = self.softest.as_ref().map(|softest| {
                let v = softest.motion.clone();
                let curvature = dot(&v, &here.curvature(&v));
                (v, curvature)
            });
        }
        Ok(trial)
    }

    /// Whether the equilibrium is to be examined, where the sum of the multipliers is `pushed`: at the ends of phases, where that sum has
    /// grown, and where the energy has become flatter along the motion that was the softest.
    fn is_due(&self, here: &Linearization<'_>, pushed: f64) -> bool {
        let flattens = |(v, then): &(Vec<f64>, f64)| !(dot(v, &here.curvature(v)) > FLATTER * then);
        let may_lose = pushed > 0.0 || !self.problem.energy().is_quadratic();
        let grows = !(pushed <= GROWN * self.examined);
        may_lose && (self.is_end || self.unstable.is_some() || grows)
            || self.watched.as_ref().is_some_and(flattens)
    }
}

impl Point {
    /// The largest displacement, at least `least` (UL).
    fn size(&self, least: f64) -> f64 {
        self.state.u.iter().fold(least, |size, u| size.max(u.abs()))
    }

    /// Takes the rows at u, each with its multiplier.
    fn project(&mut self, problem: &dyn ContactProblem, stop: &Stop) -> Result<(), Halt> {
        self.gaps = rows_of_both_roles(problem, &self.state.u, stop)?;
        let keys = self.gaps.keys().iter();
        let known = keys.map(|&key| self.state.multipliers.of(key));
        self.lambda = known
            .map(|l| if l.is_finite() { l.max(0.0) } else { 0.0 })
            .collect();
        Ok(())
    }

    /// How far what is left of the forces would move the unknowns at u itself, as a share of the displacements; `None` unless
    /// that is an equilibrium: the share is at most `bound`, no row overlaps by more, and none with a force is further open.
    fn equilibrium(
        &self,
        problem: &dyn ContactProblem,
        tangent: &mut Tangent,
        (bound, unit, least): (f64, f64, f64),
        cost: &mut Cost,
    ) -> Result<Option<f64>, Halt> {
        let size = self.size(least);
        let bound = bound * size;
        let mut c = vec![0.0; self.gaps.len()];
        self.gaps.value(&self.state.u, &mut c);
        let matrix = self.gaps.matrix();
        let immovable = (0..c.len()).filter(|&i| matrix.row(i).all(|(_, a)| a == 0.0));
        Halt::if_immovable(unit, &self.gaps, immovable, &c)?;
        let is_wrong = |i: usize| {
            let (c, lambda) = (c[i], self.lambda[i]);
            let is_movable = matrix.row(i).any(|(_, a)| a != 0.0);
            is_movable && (c < -bound || (lambda > 0.0 && c > bound))
        };
        if (0..c.len()).any(is_wrong) {
            return Ok(None);
        }
        let mut left = vec![0.0; self.state.u.len()];
        let clock = Instant::now();
        problem.energy().gradient(&self.state.u, &mut left);
        cost.callbacks += clock.elapsed().as_secs_f64();
        cost.gradients += 1;
        let pushed: Vec<f64> = self.lambda.iter().map(|l| -l).collect();
        self.gaps.add_forces(&pushed, &mut left);
        tangent.solve(&mut left)?;
        let is_small = left.iter().all(|x| x.abs() <= bound);
        let largest = || left.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        Ok(is_small.then(|| largest() / size))
    }
}

/// The end of a step.
struct Trial {
    /// u + t x.
    u: Vec<f64>,
    /// λ + t (μ − λ) of the rows at u (UF).
    lambda: Vec<f64>,
    /// t.
    share: f64,
    /// E(u + t x) (UF·UL).
    energy: f64,
    /// Whether the step took account of how rows vary.
    varies: bool,
}

impl Trial {
    /// t is the largest of `limit` times 1, ½, ¼ … at which the energy is finite and all domain functions are above [`GUARD`]
    /// times their values at u.
    fn new(
        energy: &dyn Energy,
        here: &Linearization<'_>,
        from: &State,
        step: &Step,
        limit: f64,
        cost: &mut Cost,
    ) -> Result<Self, Halt> {
        let clock = Instant::now();
        let domain = |u: &[f64]| {
            let mut d = vec![0.0; energy.domain_len()];
            energy.domain(u, &mut d);
            d
        };
        let now = domain(&from.u);
        let along = |share: f64, a: &[f64], x: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            a.iter().zip(x).map(|(a, x)| a + share * x).collect()
        };
        let mut share = limit;
        for _ in 0..HALVINGS {
            let u = along(share, &from.u, &mut step.x.iter().copied());
            let (inside, value) = (domain(&u), energy.value(&u));
            cost.values += 1;
            let is_inside = inside.iter().zip(&now).all(|(d, now)| *d > GUARD * now);
            if is_inside && value.is_finite() {
                cost.callbacks += clock.elapsed().as_secs_f64();
                let change = step.lambda.iter().zip(&here.lambda);
                let mut change = change.map(|(m, l)| m - l);
                return Ok(Trial {
                    u,
                    lambda: along(share, &here.lambda, &mut change),
                    share,
                    energy: value,
                    varies: true,
                });
            }
            share *= 0.5;
        }
        cost.callbacks += clock.elapsed().as_secs_f64();
        Err(Halt::Failed(
            "Newton's step leaves the domain of the energy, however short".into(),
        ))
    }
}
