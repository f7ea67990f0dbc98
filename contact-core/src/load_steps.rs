//! Load stepping: phases, increments, predictor, cut-back.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::equilibrium::{Equilibrium, Failed, Iteration, Solution};
use crate::{Budget, ContactProblem, Cost, Ending, Error, LOG, Outcome, State, Stop};
use path::{Milestone, Path};

mod pace;
mod path;

/// A contact problem whose loads and prescribed displacements are functions of one factor, a pseudo-time.
pub trait LoadStepped: ContactProblem {
    /// Sets loads and prescribed displacements to those at `factor`; proportional ones to `factor` times their full value.
    fn set_load(&mut self, factor: f64) -> Result<(), Error>;

    /// Checks what changes from one phase to the next, before a run whose phases end at these load factors. The default accepts
    /// any.
    fn check_phases(&mut self, _ends: &[f64]) -> Result<(), Error> {
        Ok(())
    }

    /// The load factors at which loads or motions change their course, in any order: adaptive steps end there, so that none steps over a
    /// peak unseen, and no start is extrapolated across one. The default has none.
    fn corners(&self) -> Vec<f64> {
        Vec::new()
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

    /// Adds constraints that have been left out so far, if this solution needs them, and tells why. The solution has converged and does not tunnel, but bodies may
    /// be deeper inside each other than they should be. After `Some`, which comes once for each kind of constraints, the load step is solved again from the same start.
    /// The default adds none.
    fn hold(&self, _solution: &Solution) -> Option<String> {
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
    /// How many increments a step may go beyond one in which no equilibrium was found. There may be none: where a row jumps, or where a body
    /// leaves an edge. [`Run::leaps`] tells where that was done. 0 ends the run there.
    pub max_leaps: usize,
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
            max_leaps: 2,
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
    /// The load factors between which no equilibrium was found, although one was beyond: see [`LoadSteps::max_leaps`].
    pub fn leaps(&self) -> Vec<[f64; 2]> {
        let leapt = |pair: &[Attempt]| {
            let (before, now) = (&pair[0], &pair[1]);
            let is_farther = now.from == before.from && now.to > before.to;
            (is_farther && now.outcome == Outcome::Converged).then_some([now.from, now.to])
        };
        self.attempts.windows(2).filter_map(leapt).collect()
    }

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
        match ending {
            Ending::Complete => log::info!(target: LOG, "the run is complete"),
            _ => log::warn!(target: LOG, "the run ends: {ending}"),
        }
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

#[cfg(test)]
mod tests;
