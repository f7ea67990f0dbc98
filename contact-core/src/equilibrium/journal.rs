//! The state of a running fixed-point iteration: iterate, history, stopping criteria.

use std::time::Instant;

use super::accuracy::Accuracy;
use super::anderson::Anderson;
use super::cycles::CycleDetector;
use super::{
    Acceleration, FixedPoint, Iteration, Solution, check_independent, least_displacement,
    relative_change,
};
use crate::friction::{Friction, SlipRows, Thresholds, touching};
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
    /// Whether nothing accelerates the iteration.
    is_plain: bool,
    /// Of friction: whether its thresholds are averaged, and those of the next iteration, by the keys of their rows.
    averages: bool,
    thresholds: Option<Multipliers>,
    /// Those by the multipliers of the last iterate (p, UF).
    renewed: Vec<f64>,
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
    /// The share of a force of friction that the next threshold allows at least where a row is closed, if the force is above the second share of the
    /// largest.
    const LETS_GO: f64 = 0.5;
    /// With friction, so many iterations are accelerated at most, and the limit of iterations is so many times as large.
    const ACCELERATED: usize = 15;
    const FRICTION: usize = 3;
    /// Thresholds are averaged in a plain iteration, and where u changes by less: multipliers of both passes are not unique, and may change
    /// without end while u does not.
    const SETTLED: f64 = 1e-6;
    /// The relative change of thresholds that is accepted, or the tolerance of u if that is larger.
    const LAWFUL: f64 = 1e-6;
    /// See [`Self::LETS_GO`].
    const HOLDS: f64 = 1e-2;

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
            is_plain: settings.acceleration == Acceleration::Plain,
            averages: false,
            thresholds: None,
            renewed: Vec::new(),
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
        match &self.thresholds {
            Some(known) => Thresholds::known(rows, known),
            None => Thresholds::first(rows, gaps, &self.point, &self.scale),
        }
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
        let multipliers = Multipliers::new(&gaps, &minimum.lambda);
        let is_exact = gaps.is_exact() && friction.is_none();
        let change = self.renew(friction.as_ref(), &multipliers);
        self.ended = self.verdict(&minimum, [error, change], is_exact);
        self.averages = self.is_plain || error < Self::SETTLED;
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

    /// Makes the thresholds by the multipliers of an iterate, and returns their relative change. They are unknowns of the fixed point,
    /// too: where other rows have friction than before, or none had, the acceleration begins anew.
    fn renew(&mut self, friction: Option<&Friction>, multipliers: &Multipliers) -> f64 {
        let keys = |friction: Option<&Friction>| friction.map(|own| own.rows.keys().to_vec());
        if keys(self.solution.friction.as_ref()) != keys(friction) {
            self.anderson.restart();
        }
        self.renewed = friction.map_or_else(Vec::new, |own| {
            own.rows.thresholds(|key| multipliers.of(key))
        });
        let Some(own) = friction else { return 0.0 };
        let n = self.point.u.len();
        let [now, then] = [&self.renewed, &own.thresholds].map(|all| own.rows.capacities(all, n));
        relative_change(&now, &then, 0.0)
    }

    /// The next iterate: the accelerated one, or the plain one if that is inadmissible.
    fn advance(&mut self) {
        let n = self.point.u.len();
        // forces in the unit of u
        let unit = self.scale.length * self.scale.length / self.scale.energy;
        let mut image = self.solution.state.u.clone();
        image.extend(self.renewed.iter().map(|threshold| threshold * unit));
        let mut residual: Vec<f64> = {
            let pairs = self.solution.state.u.iter().zip(&self.point.u);
            pairs.map(|(now, then)| now - then).collect()
        };
        if let Some(own) = &self.solution.friction {
            let [now, then] =
                [&self.renewed, &own.thresholds].map(|all| own.rows.capacities(all, n));
            residual.extend(now.iter().zip(&then).map(|(now, then)| (now - then) * unit));
        }
        // the first thresholds are a guess
        let is_guess = self.solution.friction.is_some() && self.thresholds.is_none();
        let mut next = match is_guess {
            true => image.clone(),
            false => self.anderson.next_by(residual, &image),
        };
        self.point.clone_from(&self.solution.state);
        if !self.problem.energy().value(&next[..n]).is_finite() {
            self.anderson.restart();
            next = image;
        }
        if let Some(own) = &self.solution.friction {
            let closed = touching(&self.solution.gaps, &self.solution.state.u, &self.scale);
            let rows = own.rows.keys().iter().zip(&own.forces).zip(&own.thresholds);
            let most = own
                .forces
                .iter()
                .fold(0.0_f64, |m, force| m.max(force.abs()));
            let mut is_bounded = false;
            let next = next[n..].iter().map(|threshold| threshold / unit);
            let next = next.zip(rows).map(|(next, ((&key, force), used))| {
                // at once, a smaller one could let go what another one would still hold
                let holds = force.abs() > Self::HOLDS * most && closed.binary_search(&key).is_ok();
                let least = if holds {
                    Self::LETS_GO * force.abs()
                } else {
                    0.0
                };
                let next = match self.averages {
                    true => 0.5 * (next + used),
                    false => next,
                };
                is_bounded |= next < least;
                (key, next.max(least))
            });
            self.thresholds = Some(next.collect());
            if is_bounded {
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
        let is_lawful = change < self.tolerance.max(Self::LAWFUL);
        if is_accurate && (error < self.tolerance && is_lawful || is_exact) {
            return Some(Outcome::Converged);
        }
        // of converged u, thresholds are left
        let cycles = self.cycles.as_mut().filter(|_| error >= self.tolerance);
        let period = cycles.and_then(|cycles| cycles.period(&minimum.u, error));
        let (made, has_friction) = (self.solution.history.len(), self.problem.has_friction());
        if has_friction && !self.is_plain && (period.is_some() || made >= Self::ACCELERATED) {
            // where points change between stick and slip, averages settle what accelerated iterates do not
            self.is_plain = true;
            self.anderson = Anderson::of(Acceleration::Plain);
            return None;
        }
        let limit = match has_friction {
            true => Self::FRICTION * self.max_iterations,
            false => self.max_iterations,
        };
        match period {
            Some(period) if !has_friction => Some(Outcome::Cycle {
                period,
                amplitude: error,
            }),
            _ => (made >= limit).then_some(Outcome::IterationLimit),
        }
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
