//! The way from one converged state to the next: phase by phase, step by step, with predictions, plans and cuts.

use std::ops::ControlFlow;
use std::time::Instant;

use super::pace::Pace;
use super::{Attempt, LoadStepped, LoadSteps, Passage, Phase, Step};
use crate::equilibrium::{Equilibrium, Solution, StepContext};
use crate::reduction;
use crate::{Cost, Ending, Energy, Error, Interruption, LOG, Outcome, State, Stop, check};

/// A converged state and its load factor.
#[derive(Clone)]
pub(super) struct Milestone {
    pub(super) factor: f64,
    pub(super) state: State,
}

/// The state of a run: the last two converged states and all attempts.
pub(super) struct Path<'a> {
    pub(super) settings: &'a LoadSteps,
    /// The request to stop, with this run's budget.
    pub(super) stop: Stop,
    pub(super) last: Milestone,
    pub(super) before: Option<Milestone>,
    /// The last state in the unknowns of its own phase, while the next phase has others and no step of it has converged.
    pub(super) other: Option<State>,
    pub(super) solution: Option<Solution>,
    pub(super) attempts: Vec<Attempt>,
}

/// The name of a phase before what is told of it.
fn named(phase: &Phase) -> String {
    match phase.name.is_empty() {
        true => String::new(),
        false => format!("phase `{}`, ", phase.name),
    }
}

impl Path<'_> {
    pub(super) fn walk<P: LoadStepped>(
        &mut self,
        problem: &mut P,
        solver: &mut dyn Equilibrium,
        observe: &mut impl FnMut(&Step<'_, P>) -> ControlFlow<()>,
    ) -> Result<Ending, Error> {
        let only = [Phase::new("", 1.0, self.settings.increments)];
        let phases = match self.settings.phases.is_empty() {
            true => &only[..],
            false => &self.settings.phases,
        };
        let (mut began, mut before) = (0.0, 0);
        for phase in phases {
            let mut pace = Pace::new(
                phase,
                problem.corners(),
                (began, before),
                [self.settings.max_halvings, self.settings.max_leaps],
            );
            log::info!(
                target: LOG,
                "{}from load factor {began} to {} in {} increments",
                named(phase), phase.until, phase.increments
            );
            // loads may change their course here
            self.before = None;
            self.begin(problem, phase.until)?;
            if let Some(ending) = self.walk_phase(problem, solver, (phase, &mut pace), observe)? {
                return Ok(ending);
            }
            began = phase.until;
            before = pace.increments();
        }
        Ok(Ending::Complete)
    }

    /// Begins a phase, in whose unknowns the last state then is.
    fn begin<P: LoadStepped>(&mut self, problem: &mut P, until: f64) -> Result<(), Error> {
        let span = [self.last.factor, until];
        let solution = self.solution.as_ref();
        if let Some(u) = problem.begin(span, &self.last.state.u, solution)? {
            let multipliers = self.last.state.multipliers.clone();
            let here = State { u, multipliers };
            let before = std::mem::replace(&mut self.last.state, here);
            self.other = self.solution.is_some().then_some(before);
        }
        Ok(())
    }

    /// Walks one phase; the ending of the run if it ends here, before the last phase does.
    fn walk_phase<P: LoadStepped>(
        &mut self,
        problem: &mut P,
        solver: &mut dyn Equilibrium,
        (phase, pace): (&Phase, &mut Pace<'_>),
        observe: &mut impl FnMut(&Step<'_, P>) -> ControlFlow<()>,
    ) -> Result<Option<Ending>, Error> {
        // what the present increment failed by
        let mut failed: Option<Solution> = None;
        while let Some(target) = pace.next(self.last.factor) {
            if self.stop.is_requested() {
                return Ok(Some(self.interrupted()));
            }
            let solution = match self.attempt(problem, solver, phase, target.factor) {
                Err(Error::Interrupted) if self.stop.is_requested() => {
                    return Ok(Some(self.interrupted()));
                }
                solution => solution?,
            };
            match solution.outcome {
                Outcome::Converged => pace.succeeded(target, solution.history.len()),
                Outcome::Interrupted => return Ok(Some(self.interrupted())),
                _ => {
                    let is_stuck = self.is_stuck();
                    if !pace.leaps() && !is_stuck && pace.cut(self.last.factor, target) {
                        continue;
                    }
                    let is_sought = solution.outcome.has_no_equilibrium();
                    let solution = failed.take().unwrap_or(solution);
                    if is_sought && pace.leap(self.last.factor) {
                        failed = Some(solution);
                        continue;
                    }
                    let stuck = is_stuck.then(|| "smaller steps do not reduce it".into());
                    let causes = stuck.into_iter().chain(problem.diagnose(&solution));
                    let slope = check::wrong_slope(problem.energy(), &solution.state.u);
                    let causes = causes.chain(slope.map(|[gradient, differences]| format!(
                        "along the gradient of the energy its slope is {gradient:.3e}, and {differences:.3e} by differences: \
                         compare the derivatives by `check::energy`"
                    )));
                    let before = solution.failed.iter().filter(|f| f.cause.is_some());
                    let causes = causes.chain(before.map(|failed| failed.to_string()));
                    let causes: Vec<String> = causes.collect();
                    return Ok(Some(Ending::NotConverged {
                        at: self.last.factor,
                        cause: (!causes.is_empty()).then(|| causes.join("; ")),
                        why: solution.outcome,
                    }));
                }
            }
            if failed.take().is_some() {
                log::warn!(
                    target: LOG,
                    "no equilibrium was found beyond load factor {}: the step to {} leapt over it",
                    self.last.factor,
                    target.factor
                );
            }
            let step = Step {
                problem: &*problem,
                factor: target.factor,
                increment: target.increment,
                solution: &solution,
                attempt: &self.attempts[self.attempts.len() - 1],
            };
            let flow = observe(&step);
            self.advance(target.factor, solution);
            if pace.is_corner(target.factor) {
                // loads change their course here
                self.before = None;
            }
            if flow.is_break() && self.last.factor < self.settings.end() - pace.close() {
                return Ok(Some(Ending::Interrupted {
                    at: target.factor,
                    why: Interruption::Observer,
                }));
            }
        }
        Ok(None)
    }

    /// Whether the last attempts, all from the last converged state, cycle or tunnel by as much as the one before them,
    /// although their steps were smaller.
    fn is_stuck(&self) -> bool {
        let of_failure = |attempt: &Attempt| match attempt.outcome {
            Outcome::Cycle { amplitude, .. } => Some(amplitude),
            Outcome::Tunnelled { depth, .. } => Some(depth),
            _ => None,
        };
        let from = self.last.factor;
        let attempts = self.attempts.iter().rev();
        let failed = attempts.take_while(|attempt| attempt.from == from);
        let left: Vec<Option<f64>> = failed
            .take(1 + LoadSteps::USELESS_CUTS)
            .map(of_failure)
            .collect();
        match left[..] {
            [Some(last), .., Some(first)] if left.len() > LoadSteps::USELESS_CUTS => {
                left.iter().all(Option::is_some) && last > LoadSteps::SHRINKS * first
            }
            _ => false,
        }
    }

    /// The ending at a request or a limit.
    fn interrupted(&self) -> Ending {
        Ending::Interrupted {
            at: self.last.factor,
            why: self.stop.reason().unwrap_or(Interruption::Solver),
        }
    }

    /// Solves at load factor `target` and records the attempt.
    fn attempt<P: LoadStepped>(
        &mut self,
        problem: &mut P,
        solver: &mut dyn Equilibrium,
        phase: &Phase,
        target: f64,
    ) -> Result<Solution, Error> {
        let clock = Instant::now();
        problem.set_load(target)?;
        let prediction = self.prediction(problem.energy(), target);
        let predicted = prediction.is_some();
        problem.watch(Some(&self.stop));
        let lifted = || self.lifted(&*problem);
        let is_lifted = predicted || !solver.lifts_starts(&*problem);
        let guess = self.settings.guess.as_ref();
        let guess = guess.filter(|_| self.attempts.is_empty());
        let is_lifted = is_lifted || guess.is_some();
        let start = match (guess, prediction, is_lifted) {
            (Some(guess), _, _) => guess.clone(),
            (None, Some(start), _) => start,
            (None, None, true) => lifted(),
            (None, None, false) => self.last.state.clone(),
        };
        let context = StepContext {
            last: &self.last.state,
            from: self.last.factor,
            to: target,
            is_end: target == phase.until,
            lifted: &lifted,
            is_lifted,
            stop: &self.stop,
        };
        let solved = self.planned(&*problem, solver, start, &context);
        problem.watch(None);
        let solution = solved?;
        let attempt = Attempt {
            phase: phase.name.clone(),
            from: self.last.factor,
            to: target,
            outcome: solution.outcome.clone(),
            predicted,
            energy: solution.energy,
            min_domain: domain(problem.energy(), &solution.state.u)
                .into_iter()
                .fold(f64::INFINITY, f64::min),
            failed: solution.failed.clone(),
            iterations: solution.history.clone(),
            cost: Cost {
                wall: clock.elapsed().as_secs_f64(),
                ..solution.cost()
            },
        };
        log::info!(
            target: LOG,
            "{}load factor {target}: {}, {} iterations, {} factorisations, {:.2} s",
            named(phase), attempt.outcome, attempt.iterations.len(), attempt.cost.factorizations, attempt.cost.wall
        );
        self.attempts.push(attempt);
        Ok(solution)
    }

    /// Solves at the present load, and again where a solution needs constraints that had been left out.
    fn planned<P: LoadStepped>(
        &self,
        problem: &P,
        solver: &mut dyn Equilibrium,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let mut refuted: Option<Solution> = None;
        let mut plans = 0;
        loop {
            plans += 1;
            let solution = reduction::solve(solver, problem, start.clone(), context)?.checked();
            let dofs = problem.energy().dofs();
            Error::check_length("the solver's u", &solution.state.u, dofs)?;
            let solution = match refuted.take() {
                None => solution,
                Some(first) => {
                    let last = first.history.last();
                    let name = last.map_or(solver.choice(problem).solver, |last| last.solver);
                    solution.after(first, name, None)
                }
            };
            let solution = Solution {
                outcome: self.examined(problem, &solution),
                ..solution
            };
            let is_unplanned = matches!(solution.outcome, Outcome::Unplanned(_));
            if !is_unplanned || plans >= LoadSteps::MOST_PLANS {
                return Ok(solution);
            }
            log::warn!(target: LOG, "{}: the load step is solved again", solution.outcome);
            refuted = Some(solution);
        }
    }

    /// The outcome of a solution, after the problem has looked at it.
    fn examined<P: LoadStepped>(&self, problem: &P, solution: &Solution) -> Outcome {
        if solution.outcome != Outcome::Converged {
            return solution.outcome.clone();
        }
        let (u, last) = (&solution.state.u, &self.last);
        if let Some(what) = problem.unplanned(u) {
            return Outcome::Unplanned(what);
        }
        match problem.tunnels(u, &last.state.u, last.factor) {
            Some(Passage { depth, place }) => Outcome::Tunnelled { depth, place },
            None => match problem.hold(solution) {
                Some(what) => Outcome::Unplanned(what),
                None => Outcome::Converged,
            },
        }
    }

    /// The linear extrapolation of the last two converged states, unless it takes a domain function
    /// below [`LoadSteps::GUARD`] of its value.
    fn prediction(&self, energy: &dyn Energy, target: f64) -> Option<State> {
        let before = self.before.as_ref().filter(|_| self.settings.predictor)?;
        let last = &self.last;
        let s = (target - last.factor) / (last.factor - before.factor);
        let line = last.state.u.iter().zip(&before.state.u);
        let u: Vec<f64> = line.map(|(a, b)| a + s * (a - b)).collect();
        let admissible = domain(energy, &u)
            .iter()
            .zip(domain(energy, &last.state.u))
            .all(|(&d, now)| d > LoadSteps::GUARD * now.max(0.0));
        let is_finite = || energy.is_quadratic() || energy.value(&u).is_finite();
        (admissible && is_finite()).then(|| State {
            u,
            multipliers: last
                .state
                .multipliers
                .extrapolated(&before.state.multipliers, s),
        })
    }

    /// The last state, with its free unknowns moved along with the prescribed ones if that is admissible.
    fn lifted<P: LoadStepped>(&self, problem: &P) -> State {
        let mut state = self.last.state.clone();
        let lifted = problem.lift(&state.u, self.last.factor);
        if problem.energy().value(&lifted).is_finite() {
            state.u = lifted;
        }
        state
    }

    fn advance(&mut self, factor: f64, solution: Solution) {
        let reached = Milestone {
            factor,
            state: solution.state.clone(),
        };
        self.before = Some(std::mem::replace(&mut self.last, reached));
        self.other = None;
        self.solution = Some(solution);
    }
}

/// The energy's domain functions at u.
fn domain(energy: &dyn Energy, u: &[f64]) -> Vec<f64> {
    let mut d = vec![0.0; energy.domain_len()];
    energy.domain(u, &mut d);
    d
}
