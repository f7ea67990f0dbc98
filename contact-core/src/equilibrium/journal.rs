//! The state of a running fixed-point iteration: iterate, history, stopping criteria.

use std::time::Instant;

use super::accuracy::Accuracy;
use super::anderson::Anderson;
use super::cycles::CycleDetector;
use super::{FixedPoint, Iteration, Solution, check_independent, least_displacement};
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
        self.asked = self.accuracy.of(history.len(), change, gaps.is_exact());
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

    /// Records U_n, tests the stopping criteria and, unless one is met, forms the next iterate.
    pub fn accept(&mut self, gaps: LinearGaps, mut minimum: Minimum, error: f64) {
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
        self.solution.history.push(Iteration {
            solver: self.solver,
            error,
            rows: gaps.len(),
            cost: Cost {
                outer_iterations: 1,
                projection: self.projection,
                wall: self.clock.elapsed().as_secs_f64(),
                ..minimum.cost
            },
        });
        self.ended = self.verdict(&minimum, error, gaps.is_exact());
        let multipliers = Multipliers::new(&gaps, &minimum.lambda);
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

    /// The next iterate: the accelerated one, or the plain one if that is inadmissible.
    fn advance(&mut self) {
        let next = self.anderson.next(&self.point.u, &self.solution.state.u);
        self.point.clone_from(&self.solution.state);
        if self.problem.energy().value(&next).is_finite() {
            self.point.u = next;
        } else {
            self.anderson.restart();
        }
    }

    /// The stopping criterion that is met, if any.
    fn verdict(&mut self, minimum: &Minimum, error: f64, is_exact: bool) -> Option<Outcome> {
        match &minimum.solved {
            Solved::Failed(why) => return Some(Outcome::SubproblemFailed(why.clone())),
            Solved::Interrupted => return Some(Outcome::Interrupted),
            Solved::Optimal => {}
        }
        let is_accurate = self.asked == 0.0;
        if is_accurate && (error < self.tolerance || is_exact) {
            return Some(Outcome::Converged);
        }
        let cycles = self.cycles.as_mut();
        if let Some(period) = cycles.and_then(|cycles| cycles.period(&minimum.u, error)) {
            return Some(Outcome::Cycle {
                period,
                amplitude: error,
            });
        }
        (self.solution.history.len() == self.max_iterations).then_some(Outcome::IterationLimit)
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
