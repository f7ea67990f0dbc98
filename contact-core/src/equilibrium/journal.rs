//! The state of a running fixed-point iteration: iterate, history, stopping criteria.

use std::time::Instant;

use super::accuracy::Accuracy;
use super::anderson::Anderson;
use super::cycles::CycleDetector;
use super::{Acceleration, FixedPoint, Iteration, Solution, check_independent, least_displacement};
use crate::friction::{Friction, Search, SlipRows, Thresholds};
use crate::method::{Method, Minimum, Subproblem, check_bounds};
use crate::{
    ContactProblem, Cost, Error, LinearGaps, Multipliers, Outcome, Scale, Solved, State, Stop,
};

/// The state of a running fixed-point iteration.
pub(super) struct Journal<'a> {
    /// U_{n−1} and its multipliers, from which the next iteration starts.
    pub point: State,
    /// Lower bound on the denominator of the relative change (UL).
    pub least: f64,
    problem: &'a dyn ContactProblem,
    /// The units of all subproblems.
    scale: Scale,
    /// The name of the method.
    solver: &'static str,
    tolerance: f64,
    max_iterations: usize,
    anderson: Anderson,
    accuracy: Accuracy,
    cycles: Option<CycleDetector>,
    /// The thresholds of friction.
    search: Search,
    solution: Solution,
    ended: Option<Outcome>,
    /// The start of this iteration, the time of its projections (s), and the accuracy asked of its subproblem.
    clock: Instant,
    projection: f64,
    asked: f64,
}

impl<'a> Journal<'a> {
    /// The relative change expected of the first iteration.
    const GUESS: f64 = 1.0;

    /// Before the first iteration.
    pub fn new<M: Method>(
        settings: &FixedPoint<M>,
        problem: &'a dyn ContactProblem,
        start: State,
    ) -> Result<Self, Error> {
        check_independent(problem, settings.method.name())?;
        let dofs = problem.energy().dofs();
        Error::check_vector("start.u", &start.u, dofs)?;
        check_bounds(problem.bounds(), dofs)?;
        let energy = problem.energy().value(&start.u);
        let scale = Scale::of(problem, &start.u)?;
        Ok(Journal {
            least: least_displacement(problem, scale.length),
            scale,
            problem,
            solver: settings.method.name(),
            tolerance: settings.tolerance,
            max_iterations: settings.max_iterations,
            anderson: Anderson::of(settings.acceleration),
            accuracy: Accuracy::new(settings.acceleration, settings.max_iterations),
            cycles: Some(CycleDetector::default()),
            search: Search::new(settings.acceleration == Acceleration::Plain),
            ended: (!energy.is_finite()).then_some(Outcome::InadmissibleStart),
            solution: Solution {
                outcome: Outcome::InadmissibleStart,
                energy,
                state: start.clone(),
                gaps: LinearGaps::new(false),
                lambda: Vec::new(),
                history: Vec::new(),
                failed: Vec::new(),
                curvature: None,
                flickering: Vec::new(),
                held: Vec::new(),
                softest: None,
                friction: None,
            },
            point: start,
            clock: Instant::now(),
            projection: 0.0,
            asked: 0.0,
        })
    }

    /// Lets iterates that come back go on to the limit.
    #[cfg(feature = "ipopt")]
    pub fn ignore_cycles(&mut self) {
        self.cycles = None;
    }

    /// Whether no stopping criterion has been met yet, and no stop requested.
    pub fn goes_on(&mut self, stop: &Stop) -> bool {
        if self.ended.is_none() && stop.is_requested() {
            self.ended = Some(Outcome::Interrupted);
        }
        self.ended.is_none()
    }

    /// The problem of step 5 with these rows.
    pub fn subproblem<'b>(&mut self, gaps: &'b LinearGaps, stop: &'b Stop) -> Subproblem<'b>
    where
        'a: 'b,
    {
        self.projection = self.clock.elapsed().as_secs_f64();
        let history = &self.solution.history;
        let change = history.last().map_or(Self::GUESS, |last| last.error);
        let is_exact = gaps.is_exact() && !self.problem.has_friction();
        self.asked = self.accuracy.of(history.len(), change, is_exact);
        Subproblem {
            energy: self.problem.energy(),
            bounds: self.problem.bounds(),
            gaps,
            scale: self.scale,
            change,
            accuracy: self.asked,
            stop,
        }
    }

    /// The thresholds of friction for these slips and the rows of their gaps.
    pub fn thresholds(&self, rows: SlipRows, gaps: &LinearGaps) -> Thresholds {
        let at = (&self.point, &self.scale);
        self.search.thresholds(rows, gaps, at)
    }

    /// The friction of the last iterate.
    pub fn friction(&self) -> Option<&Friction> {
        self.solution.friction.as_ref()
    }

    /// Records U_n, tests the stopping criteria and, unless one is met, forms the next iterate. Where there is `friction`, it has the
    /// thresholds that led to U_n and the forces there.
    pub fn accept(
        &mut self,
        gaps: LinearGaps,
        mut minimum: Minimum,
        friction: Option<Friction>,
        error: f64,
    ) {
        if minimum.solved == Solved::Optimal && !is_finite(&minimum) {
            minimum.solved =
                Solved::Failed("the method returned a value that is not finite".into());
        }
        if !has_finite_state(&minimum) {
            // a failed solve keeps the iterate it started from
            minimum.u.clone_from(&self.point.u);
            minimum.lambda.fill(0.0);
        }
        let error = match minimum.solved {
            Solved::Optimal => error,
            _ => f64::INFINITY,
        };
        let iteration = Iteration {
            solver: self.solver,
            error,
            rows: gaps.len(),
            cost: Cost {
                outer_iterations: 1,
                projection: self.projection,
                wall: self.clock.elapsed().as_secs_f64(),
                ..minimum.cost
            },
        };
        iteration.record(&mut self.solution.history);
        let multipliers = Multipliers::new(&gaps, &minimum.lambda);
        let is_exact = gaps.is_exact() && friction.is_none();
        let change = match &friction {
            Some(friction) => self.renew(friction, &multipliers, error),
            None => 0.0,
        };
        self.ended = self.verdict(&minimum, [error, change], is_exact);
        self.solution.friction = friction;
        self.solution.flickering = match self.ended {
            None | Some(Outcome::Converged) => Vec::new(),
            Some(_) => multipliers.switched(&self.solution.state.multipliers),
        };
        self.solution.state = State {
            multipliers,
            u: minimum.u,
        };
        self.solution.lambda = minimum.lambda;
        self.solution.energy = minimum.energy;
        self.solution.gaps = gaps;
        if self.ended.is_none() {
            self.advance();
        }
        self.clock = Instant::now();
    }

    /// Makes the thresholds of friction by the multipliers of an iterate, and returns their relative change. They are unknowns of the fixed point, too:
    /// where other rows have friction than before, or none had, the acceleration begins anew.
    fn renew(&mut self, friction: &Friction, multipliers: &Multipliers, error: f64) -> f64 {
        let keys = friction.rows.keys();
        let before = self.solution.friction.as_ref();
        if before.is_none_or(|before| before.rows.keys() != keys) {
            self.anderson.restart();
        }
        self.search.renew(friction, multipliers, error)
    }

    /// The next iterate: the accelerated one, or the plain one if that is inadmissible.
    fn advance(&mut self) {
        let mut image = self.solution.state.u.clone();
        let pairs = image.iter().zip(&self.point.u);
        let mut residual: Vec<f64> = pairs.map(|(now, then)| now - then).collect();
        // of forces (UL/UF)
        let unit = self.scale.length * self.scale.length / self.scale.energy;
        let has_friction = self.solution.friction.is_some();
        if has_friction {
            self.search.append(unit, &mut residual, &mut image);
        }
        let mut next = match has_friction && self.search.was_guessed() {
            true => image.clone(),
            false => self.anderson.next_by(residual, &image),
        };
        self.point.clone_from(&self.solution.state);
        let n = self.point.u.len();
        if !self.problem.energy().value(&next[..n]).is_finite() {
            self.anderson.restart();
            next = image;
        }
        if let Some(friction) = &self.solution.friction {
            let proposed = next[n..].iter().map(|threshold| threshold / unit);
            let at = (&self.solution.gaps, &self.point.u[..], &self.scale);
            if !self.search.take(proposed, friction, at) {
                self.anderson.restart();
            }
        }
        next.truncate(n);
        self.point.u = next;
    }

    /// The stopping criterion that is met, if any.
    fn verdict(
        &mut self,
        minimum: &Minimum,
        [error, change]: [f64; 2],
        is_exact: bool,
    ) -> Option<Outcome> {
        match &minimum.solved {
            Solved::Failed(why) => return Some(Outcome::SubproblemFailed(why.clone())),
            Solved::Interrupted => return Some(Outcome::Interrupted),
            Solved::Optimal => {}
        }
        let is_accurate = self.asked == 0.0;
        let is_lawful = change < self.tolerance.max(Search::LAWFUL);
        if is_accurate && (error < self.tolerance && is_lawful || is_exact) {
            return Some(Outcome::Converged);
        }
        let cycles = self.cycles.as_mut();
        let period = cycles.and_then(|cycles| cycles.period(&minimum.u, error));
        let made = self.solution.history.len();
        if self.problem.has_friction() {
            if period.is_some() || made >= Search::ACCELERATED {
                // where points change between stick and slip, averages settle what accelerated iterates do not
                self.search.is_plain = true;
                self.anderson = Anderson::of(Acceleration::Plain);
            }
            let is_last = made >= Search::LIMIT * self.max_iterations;
            return is_last.then_some(Outcome::IterationLimit);
        }
        if let Some(period) = period {
            return Some(Outcome::Cycle {
                period,
                amplitude: error,
            });
        }
        (made == self.max_iterations).then_some(Outcome::IterationLimit)
    }

    /// The last iterate, its outcome and the history. The energy is that of the problem, whatever the method says.
    pub fn solution(self) -> Solution {
        let solution = Solution {
            outcome: self.ended.unwrap_or(Outcome::IterationLimit),
            energy: self.problem.energy().value(&self.solution.state.u),
            ..self.solution
        };
        solution.checked()
    }
}

fn is_finite(minimum: &Minimum) -> bool {
    has_finite_state(minimum) && minimum.energy.is_finite()
}

fn has_finite_state(minimum: &Minimum) -> bool {
    let mut values = minimum.u.iter().chain(&minimum.lambda);
    values.all(|value| value.is_finite())
}
