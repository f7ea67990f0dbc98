//! Load stepping: phases, increments, predictor, cut-back.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use crate::equilibrium::{Equilibrium, Failed, Iteration, Solution, StepContext};
use crate::reduction;
use crate::{
    Budget, ContactProblem, Cost, Ending, Energy, Error, Interruption, Outcome, State, Stop, check,
};
use pace::Pace;

mod pace;

/// A contact problem whose loads and prescribed displacements are functions of one factor, a pseudo-time.
pub trait LoadStepped: ContactProblem {
    /// Sets loads and prescribed displacements to those at `factor`; proportional ones to `factor` times their full value.
    fn set_load(&mut self, factor: f64) -> Result<(), Error>;

    /// Checks what changes from one phase to the next, before a run whose phases end at these load factors. The default accepts
    /// any.
    fn check_phases(&mut self, _ends: &[f64]) -> Result<(), Error> {
        Ok(())
    }

    /// Begins a phase from `span[0]` to `span[1]`, at the converged `u` and, behind the first phase, its solution. `Some` are the
    /// unknowns of the same state if others are free in the phase than before: their number, the energy and the rows
    /// have changed then. The default keeps all.
    fn begin(
        &mut self,
        _span: [f64; 2],
        _u: &[f64],
        _solution: Option<&Solution>,
    ) -> Result<Option<Vec<f64>>, Error> {
        Ok(None)
    }

    /// Takes back the last [`LoadStepped::begin`] that changed unknowns: no step of its phase has converged.
    fn take_back(&mut self) {}

    /// Where bodies penetrate or have passed through each other at `u`, or on the way there from
    /// `last`, converged at load factor `from`; `None` if they have not. Weak constraints leave a
    /// small penetration; a deeper one was missed by the contact search. A step that tunnels is
    /// rejected and cut back. The default does not check.
    fn tunnels(&self, _u: &[f64], _last: &[f64], _from: f64) -> Option<Passage> {
        None
    }

    /// What acts at `u` although solvers were told that it cannot, such as rows between bodies planned as out of reach; found
    /// without the plan. Nothing is left out for this reason any more then, and the load step is solved again from the same
    /// start: `Some` may come once for each assumption. The default leaves nothing out.
    fn unplanned(&self, _u: &[f64]) -> Option<String> {
        None
    }

    /// The start for the present load, from `u` converged at load factor `from`, with the free
    /// unknowns moved along with the prescribed ones. The default returns `u`.
    fn lift(&self, u: &[f64], _from: f64) -> Vec<f64> {
        u.to_vec()
    }
}

/// Bodies that penetrate or have passed through each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// The depth of a point inside another body, or the distance by which it has passed through one (UL).
    pub depth: f64,
    /// The bodies and the place.
    pub place: String,
}

/// A part of a run, in equal increments: loads and motions may change their course where it ends, and no start is
/// extrapolated across its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Its name, which records repeat.
    pub name: String,
    /// The load factor, or pseudo-time, at its end. The first phase begins at 0, each other one where the one before ends.
    pub until: f64,
    /// The number of equal increments; of adaptive steps the first one is as long.
    pub increments: usize,
    /// The bounds of steps whose lengths follow from what the last ones took; `None`, the default, for equal increments.
    pub adaptive: Option<Adaptive>,
}

/// Bounds of adaptive load steps. After a step of n iterations the next one is √(8/n) times as long, at least half and at most
/// twice as long. A step that fails is halved. Each step counts as an increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// The least step (load factor): a run that would need a shorter one ends as not converged.
    pub least: f64,
    /// The largest step.
    pub largest: f64,
}

impl Adaptive {
    /// The iterations that a step should take.
    const ITERATIONS: f64 = 8.0;
}

impl Phase {
    /// A phase to the load factor `until` in so many increments.
    pub fn new(name: impl Into<String>, until: f64, increments: usize) -> Self {
        Phase {
            name: name.into(),
            until,
            increments,
            adaptive: None,
        }
    }

    /// With steps between these two lengths (load factor), see [`Adaptive`].
    pub fn adaptive(self, least: f64, largest: f64) -> Self {
        Phase {
            adaptive: Some(Adaptive { least, largest }),
            ..self
        }
    }
}

/// Settings of the load stepping.
#[derive(Clone, Debug)]
pub struct LoadSteps {
    /// The number of equal increments from zero to full load; of no effect where there are phases.
    pub increments: usize,
    /// The phases of the run. If there are none, the default, the run is one phase to the load factor 1.
    pub phases: Vec<Phase>,
    /// How often an increment may be halved before the run ends as not converged; at most 16.
    pub max_halvings: usize,
    /// Whether each increment starts from the linear extrapolation of the last two converged
    /// states, where that is admissible.
    pub predictor: bool,
    /// Where the first load step is solved from, in place of the start: the result of another program, or of another run.
    /// It has the free unknowns at the end of that step; later attempts, and what is compared with the state before, start
    /// from rest as ever.
    pub guess: Option<State>,
    /// The request to stop, which later runs share.
    pub stop: Stop,
    /// What each run may take, counted from its start; no limit by default.
    pub budget: Budget,
}

impl Default for LoadSteps {
    fn default() -> Self {
        LoadSteps {
            increments: 1,
            phases: Vec::new(),
            max_halvings: 6,
            predictor: true,
            guess: None,
            stop: Stop::default(),
            budget: Budget::default(),
        }
    }
}

/// One attempt at a load step, converged or not.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The name of its phase; empty in a run without phases.
    pub phase: String,
    /// The load factor of the start.
    pub from: f64,
    /// The load factor to reach.
    pub to: f64,
    /// The outcome of the attempt.
    pub outcome: Outcome,
    /// Whether the start was extrapolated.
    pub predicted: bool,
    /// Energy at its end (UF·UL).
    pub energy: f64,
    /// The smallest domain function (volume ratio J) at its end; `+∞` where there is none.
    pub min_domain: f64,
    /// The solvers that failed at this load before the outcome.
    pub failed: Vec<Failed>,
    /// The iterations of the attempt.
    pub iterations: Vec<Iteration>,
    /// Their cost; `wall` is the time of the whole attempt.
    pub cost: Cost,
}

/// The ending and history of a run over all load steps.
#[derive(Clone, Debug)]
pub struct Run {
    /// How it ended.
    pub ending: Ending,
    /// The last converged load factor.
    pub factor: f64,
    /// The last converged state.
    pub state: State,
    /// The last converged solution with its rows and multipliers; `None` if no step converged.
    pub solution: Option<Solution>,
    /// Every attempt in order. One that did not converge is followed by a smaller step.
    pub attempts: Vec<Attempt>,
    /// The error that ended the run, if it is [`Ending::Failed`].
    pub error: Option<Arc<Error>>,
}

impl Attempt {
    /// The solver of the last iteration, see [`Choice::solver`](crate::equilibrium::Choice::solver); `None` if there is no
    /// iteration.
    pub fn solver(&self) -> Option<&'static str> {
        self.iterations.last().map(|iteration| iteration.solver)
    }
}

impl Run {
    /// The number of attempts that did not converge, those that were stopped left out.
    pub fn cuts(&self) -> usize {
        let failed = |attempt: &&Attempt| {
            !matches!(attempt.outcome, Outcome::Converged | Outcome::Interrupted)
        };
        self.attempts.iter().filter(failed).count()
    }

    /// The cost of all attempts.
    pub fn cost(&self) -> Cost {
        self.attempts.iter().map(|attempt| attempt.cost).sum()
    }
}

/// A converged step, as the observer of a run sees it.
pub struct Step<'a, P: ?Sized> {
    /// The problem at this load.
    pub problem: &'a P,
    /// The load factor.
    pub factor: f64,
    /// The increment that this step completes, counted from 1 over all phases; `None` within an increment that was cut.
    pub increment: Option<usize>,
    /// The converged solution.
    pub solution: &'a Solution,
    /// Its record.
    pub attempt: &'a Attempt,
}

/// A converged state and its load factor.
#[derive(Clone)]
struct Milestone {
    factor: f64,
    state: State,
}

impl LoadSteps {
    /// The predictor is rejected if it takes a domain function (J) below this share of its converged value.
    const GUARD: f64 = 0.1;
    /// Load factors that differ by less than this share of a phase are equal.
    const CLOSE: f64 = 1e-12;
    /// Cutting goes on only while it reduces what a failed attempt leaves to this share in so many cuts.
    const SHRINKS: f64 = 0.9;
    const USELESS_CUTS: usize = 3;
    /// The largest number of increments accepted.
    const MOST_INCREMENTS: usize = 1_000_000;
    /// The largest number of solves of a load step by plans that do not hold.
    const MOST_PLANS: usize = 100;
    /// The largest number of halvings accepted: smaller steps are lost in round-off.
    const MOST_HALVINGS: usize = 16;

    /// Checks the settings.
    pub fn validate(&self) -> Result<(), Error> {
        if self.increments == 0 {
            return Err(Error::Setting {
                name: "increments",
                value: "0".into(),
                remedy: "a run needs at least one increment",
            });
        }
        let increments = self.phases.iter().map(|phase| phase.increments);
        let increments = increments
            .fold(0, usize::saturating_add)
            .max(self.increments);
        if increments > Self::MOST_INCREMENTS {
            return Err(Error::Setting {
                name: "increments",
                value: increments.to_string(),
                remedy: "choose at most a million",
            });
        }
        let mut began = 0.0;
        for phase in &self.phases {
            if phase.increments == 0 {
                return Err(Error::Setting {
                    name: "phase increments",
                    value: "0".into(),
                    remedy: "a phase needs at least one increment",
                });
            }
            if !(phase.until > began && phase.until.is_finite()) {
                return Err(Error::Setting {
                    name: "phase until",
                    value: phase.until.to_string(),
                    remedy: "let each phase end at a finite load factor beyond the end of the one before; the first begins at 0",
                });
            }
            let length = phase.until - began;
            if !(began + length / phase.increments as f64 > began) {
                return Err(Error::Setting {
                    name: "phase until",
                    value: phase.until.to_string(),
                    remedy: "let its increments be numbers that add something to the load factor",
                });
            }
            if let Some(Adaptive { least, largest }) = phase.adaptive {
                let shortest = length / Self::MOST_INCREMENTS as f64;
                if !(least >= shortest && least <= largest) {
                    return Err(Error::Setting {
                        name: "phase least step",
                        value: least.to_string(),
                        remedy: "choose at least a millionth of the phase, and no more than the largest step",
                    });
                }
                if !largest.is_finite() {
                    return Err(Error::Setting {
                        name: "phase largest step",
                        value: largest.to_string(),
                        remedy: "choose a number, such as the length of the phase",
                    });
                }
            }
            began = phase.until;
        }
        if self.max_halvings > Self::MOST_HALVINGS {
            return Err(Error::Setting {
                name: "max_halvings",
                value: self.max_halvings.to_string(),
                remedy: "choose at most 16: smaller steps are lost in round-off",
            });
        }
        self.budget.validate()
    }

    /// The number of increments over all phases; with adaptive steps, how many there are as long as the first.
    pub fn all_increments(&self) -> usize {
        match self.phases.is_empty() {
            true => self.increments,
            false => self.phases.iter().map(|phase| phase.increments).sum(),
        }
    }

    /// The load factors at which phases end.
    fn ends(&self) -> Vec<f64> {
        match self.phases.is_empty() {
            true => vec![1.0],
            false => self.phases.iter().map(|phase| phase.until).collect(),
        }
    }

    /// The load factor at the end of the run.
    pub fn end(&self) -> f64 {
        self.phases.last().map_or(1.0, |phase| phase.until)
    }

    /// All that a run refuses before its first solve: settings out of range, a problem that the solver does not treat, what
    /// changes within a phase, and too little memory.
    ///
    /// # Errors
    /// As [`LoadSteps::run`] before its first solve.
    pub fn check<P: LoadStepped>(
        &self,
        problem: &mut P,
        solver: &dyn Equilibrium,
    ) -> Result<(), Error> {
        self.validate()?;
        solver.validate()?;
        solver.check(problem)?;
        problem.check_phases(&self.ends())?;
        #[cfg(feature = "linear")]
        crate::memory::check_run(solver, &*problem, self.budget.memory)?;
        Ok(())
    }

    /// Raises the load from zero, where `start` is converged, to full load, or to the end of the last phase. `solver` solves each step;
    /// `observe` sees every converged step and may stop the run.
    ///
    /// # Errors
    /// Settings out of range, [`Error::Memory`] where the run needs more than the system or the budget leaves by the estimate of
    /// [`Equilibrium::memory`], and errors of the problem or the solver before the first step has converged. A later
    /// error is [`Ending::Failed`], which keeps what has converged. Whether the run converged is told by
    /// [`Run::ending`].
    pub fn run<P: LoadStepped>(
        &self,
        problem: &mut P,
        solver: &mut dyn Equilibrium,
        start: State,
        mut observe: impl FnMut(&Step<'_, P>) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        self.check(problem, solver)?;
        Error::check_vector("start.u", &start.u, problem.energy().dofs())?;
        if let Some(guess) = &self.guess {
            Error::check_vector("guess.u", &guess.u, problem.energy().dofs())?;
        }
        let mut path = Path {
            settings: self,
            stop: self.stop.with_budget(self.budget)?,
            last: Milestone {
                factor: 0.0,
                state: start,
            },
            before: None,
            other: None,
            solution: None,
            attempts: Vec::new(),
        };
        let walked = path.walk(problem, solver, &mut observe);
        if let Some(state) = path.other.take() {
            problem.take_back();
            path.last.state = state;
        }
        let reset = problem.set_load(path.last.factor);
        let (ending, error) = match walked.and_then(|ending| reset.map(|()| ending)) {
            Ok(ending) => (ending, None),
            Err(error) if path.solution.is_none() => return Err(error),
            Err(error) => {
                let (at, why) = (path.last.factor, error.to_string());
                (Ending::Failed { at, why }, Some(Arc::new(error)))
            }
        };
        Ok(Run {
            ending,
            error,
            factor: path.last.factor,
            state: path.last.state,
            solution: path.solution,
            attempts: path.attempts,
        })
    }
}

/// The state of a run: the last two converged states and all attempts.
struct Path<'a> {
    settings: &'a LoadSteps,
    /// The request to stop, with this run's budget.
    stop: Stop,
    last: Milestone,
    before: Option<Milestone>,
    /// The last state in the unknowns of its own phase, while the next phase has others and no step of it has converged.
    other: Option<State>,
    solution: Option<Solution>,
    attempts: Vec<Attempt>,
}

impl Path<'_> {
    fn walk<P: LoadStepped>(
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
            let mut pace = Pace::new(phase, (began, before), self.settings.max_halvings);
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
                    if !is_stuck && pace.cut() {
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
            let step = Step {
                problem: &*problem,
                factor: target.factor,
                increment: target.increment,
                solution: &solution,
                attempt: &self.attempts[self.attempts.len() - 1],
            };
            let flow = observe(&step);
            self.advance(target.factor, solution);
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
        let mut solution = solved?;
        if solution.outcome == Outcome::Converged {
            let last = &self.last;
            if let Some(Passage { depth, place }) =
                problem.tunnels(&solution.state.u, &last.state.u, last.factor)
            {
                solution.outcome = Outcome::Tunnelled { depth, place };
            }
        }
        self.attempts.push(Attempt {
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
        });
        Ok(solution)
    }

    /// Solves at the present load, and again where something acts that was left out by plan.
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
            let what = match solution.outcome {
                Outcome::Converged => problem.unplanned(&solution.state.u),
                _ => None,
            };
            let Some(what) = what else {
                return Ok(solution);
            };
            let solution = Solution {
                outcome: Outcome::Unplanned(what.clone()),
                ..solution
            };
            if plans >= LoadSteps::MOST_PLANS {
                return Ok(solution);
            }
            log::warn!("{what}, which was left out by plan: the load step is solved again");
            refuted = Some(solution);
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

#[cfg(test)]
mod tests;
