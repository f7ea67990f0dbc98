//! Runs that end at every step, files that end at every byte, and files of other runs, with a solver whose answers depend on how
//! often it was asked.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::rc::Rc;

use super::*;
use crate::friction::{Friction, SlipRow, SlipRows};
use crate::gaps::{Row, RowKey};
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{Cost, Energy, LoadStepped, LoadSteps, Multipliers, Phase, Stop};

/// E(u) = ½ k u² − t f u over a floor at −1.
#[derive(Clone)]
struct Spring {
    stiffness: f64,
    force: f64,
    floor: f64,
    /// The load at which the floor is lower.
    dip: f64,
    load: f64,
    pattern: SymmetricPattern,
    bounds: Bounds,
}

impl Spring {
    fn new() -> Self {
        Spring {
            stiffness: 3.0,
            force: 2.0,
            floor: 1.0,
            dip: f64::NAN,
            load: 0.0,
            pattern: SymmetricPattern::diagonal(1),
            bounds: Bounds::free(1),
        }
    }
}

impl Energy for Spring {
    fn dofs(&self) -> usize {
        1
    }
    fn value(&self, u: &[f64]) -> f64 {
        0.5 * self.stiffness * u[0] * u[0] - self.load * self.force * u[0]
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g[0] = self.stiffness * u[0] - self.load * self.force;
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values[0] = self.stiffness;
    }
}

impl ContactProblem for Spring {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        let mut gaps = LinearGaps::new(true);
        let row = Row {
            free: vec![(0, 1.0)],
            constant: self.floor + f64::from(u8::from(self.load == self.dip)),
            ..Row::default()
        };
        gaps.push(RowKey { pass: 0, node: 0 }, &row);
        Ok(gaps)
    }
}

impl LoadStepped for Spring {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.load = factor;
        Ok(())
    }
}

/// Its answers drift with each question since it was made; each third one fails.
struct Drifting {
    asked: usize,
    all: Rc<Cell<usize>>,
}

impl Equilibrium for Drifting {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        self.asked += 1;
        self.all.set(self.all.get() + 1);
        let drift = 1.0 + 1e-3 * self.asked as f64;
        let u = vec![context.to * drift + 0.1 * start.u[0]];
        let gaps = problem.linearize_gaps(&u, Sampling::Nodes)?;
        let lambda = vec![drift];
        let cost = Cost {
            outer_iterations: self.asked,
            ..Cost::default()
        };
        Ok(Solution {
            outcome: match self.asked % 3 {
                0 => Outcome::Cycle {
                    period: 2,
                    amplitude: f64::NAN,
                },
                _ => Outcome::Converged,
            },
            energy: problem.energy().value(&u),
            state: State {
                multipliers: Multipliers::new(&gaps, &lambda),
                u,
            },
            gaps,
            lambda,
            history: vec![super::super::Iteration {
                solver: "drifting",
                error: f64::INFINITY,
                rows: 1,
                cost,
            }],
            failed: Vec::new(),
            curvature: Some(-0.0),
            flickering: vec![RowKey { pass: 7, node: 9 }],
            held: vec![0.25, -0.5],
            softest: Some((vec![1.0, 0.5], -0.25)),
            friction: {
                let mut rows = SlipRows::default();
                let key = RowKey { pass: 7, node: 9 };
                rows.push(key, &SlipRow::default());
                Some(Friction {
                    rows,
                    thresholds: vec![0.5],
                    forces: vec![-0.25],
                    last: vec![0.0],
                    from: 0.1,
                })
            },
        })
    }
}

/// A file for a test, which is not there.
fn file(name: &str) -> PathBuf {
    let name = format!("resumable-{}-{name}", std::process::id());
    let path = std::env::temp_dir().join(name);
    let _ = std::fs::remove_file(&path);
    path
}

fn steps() -> LoadSteps {
    LoadSteps {
        phases: vec![Phase::new("there", 1.0, 5), Phase::new("on", 1.5, 4)],
        ..LoadSteps::default()
    }
}

/// The bits of all that a run gives, and how many questions the solver itself was asked.
fn run(
    path: &Path,
    every: usize,
    problem: &Spring,
    steps: &LoadSteps,
    until: usize,
) -> Result<(Vec<u64>, usize), Error> {
    let all = Rc::new(Cell::new(0));
    let make = || Drifting {
        asked: 0,
        all: Rc::clone(&all),
    };
    let mut solver = Resumable::new(path, make).every(every).with_settings("a");
    let start = State {
        u: vec![0.0],
        ..State::default()
    };
    let mut seen = 0;
    let run = steps.run(&mut problem.clone(), &mut solver, start, |_| {
        seen += 1;
        match seen == until {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    })?;
    if let Some(error) = run.error {
        return Err(foreign(path, &error.to_string()));
    }
    let mut bits = Vec::new();
    for attempt in &run.attempts {
        bits.extend([attempt.from, attempt.to, attempt.energy].map(f64::to_bits));
        bits.push(u64::from(attempt.outcome == Outcome::Converged));
        for iteration in &attempt.iterations {
            assert_eq!(iteration.solver, "drifting");
            bits.push(iteration.error.to_bits());
            bits.push(iteration.cost.outer_iterations as u64);
        }
    }
    if let Some(solution) = run.solution {
        let numbers = solution.state.u.iter().chain(&solution.lambda);
        bits.extend(numbers.map(|number| number.to_bits()));
        bits.extend(solution.gaps.constant().iter().map(|c| c.to_bits()));
        bits.push(solution.curvature.map_or(0, f64::to_bits));
        let friction = solution.friction.as_ref().expect("friction");
        let own = friction.rows.bounds().iter().chain(&friction.forces);
        bits.extend(own.chain(&friction.last).map(|number| number.to_bits()));
        assert_eq!(solution.flickering, [RowKey { pass: 7, node: 9 }]);
    }
    Ok((bits, all.get()))
}

#[test]
fn a_run_that_was_ended_anywhere_goes_on_alike() {
    let (problem, steps) = (Spring::new(), steps());
    for every in [1, 2, 4, 100] {
        let path = file("anywhere");
        let (whole, asked) = run(&path, every, &problem, &steps, 0).expect("a run");
        let (again, none) = run(&path, every, &problem, &steps, 0).expect("a run");
        assert_eq!((again, none), (whole.clone(), 0), "all of it is kept");
        for until in 1..9 {
            let path = file("anywhere");
            let (_, before) = run(&path, every, &problem, &steps, until).expect("a run");
            let (resumed, after) = run(&path, every, &problem, &steps, 0).expect("a run");
            assert_eq!(resumed, whole, "every {every}, ended after {until}");
            assert!((asked..asked + every).contains(&(before + after)));
        }
        std::fs::remove_file(&path).expect("a file");
    }
}

/// Cut at any byte, it lacks a group; with any byte changed, it is refused or does.
#[test]
fn files_that_are_damaged_change_no_result() {
    let (problem, steps) = (Spring::new(), steps());
    let path = file("damaged");
    let (whole, _) = run(&path, 2, &problem, &steps, 0).expect("a run");
    let sound = std::fs::read(&path).expect("a file");
    let mut refused = 0;
    for k in 0..sound.len() {
        std::fs::write(&path, &sound[..k]).expect("a file");
        let (resumed, _) = run(&path, 2, &problem, &steps, 0).expect("a run");
        assert_eq!(resumed, whole, "cut at {k}");
        assert_eq!(std::fs::read(&path).expect("a file"), sound);
        let mut damaged = sound.clone();
        damaged[k] ^= 1 << (k % 8);
        std::fs::write(&path, &damaged).expect("a file");
        match run(&path, 2, &problem, &steps, 0) {
            Ok((resumed, _)) => assert_eq!(resumed, whole, "byte {k}"),
            Err(_) => refused += 1,
        }
    }
    // what is no file of a run, or has a damaged beginning, is kept
    let length = usize::from(sound[MAGIC.len()]);
    assert_eq!(refused, MAGIC.len() + 12 + length);
    std::fs::remove_file(&path).expect("a file");
}

#[test]
fn files_of_other_runs_are_refused_and_kept() {
    let (problem, steps) = (Spring::new(), steps());
    let path = file("others");
    run(&path, 2, &problem, &steps, 0).expect("a run");
    let sound = std::fs::read(&path).expect("a file");
    let told = |problem: &Spring, steps: &LoadSteps, every: usize| {
        let error = run(&path, every, problem, steps, 0).expect_err("another run");
        assert_eq!(std::fs::read(&path).expect("a file"), sound);
        error.to_string()
    };
    let stiffer = Spring {
        stiffness: 3.0 + 1e-15,
        ..problem.clone()
    };
    assert!(told(&stiffer, &steps, 2).contains("another problem"));
    let loaded = Spring {
        force: 2.5,
        ..problem.clone()
    };
    assert!(told(&loaded, &steps, 2).contains("another problem"));
    let lower = Spring {
        floor: 1.1,
        ..problem.clone()
    };
    assert!(told(&lower, &steps, 2).contains("other contacts"));
    // in the midst of a group, which the energy does not know
    let dipping = Spring {
        dip: 0.2,
        ..problem.clone()
    };
    assert!(told(&dipping, &steps, 2).contains("other contacts"));
    let finer = LoadSteps {
        phases: vec![Phase::new("there", 1.0, 6)],
        ..steps.clone()
    };
    assert!(told(&problem, &finer, 2).contains("for other load steps"));
    assert!(told(&problem, &steps, 3).contains("another length"));
    let other = Resumable::new(&path, || Drifting {
        asked: 0,
        all: Rc::default(),
    });
    let start = State {
        u: vec![0.0],
        ..State::default()
    };
    let refused = other.every(2).solve_from(&problem, start.clone());
    let error = refused.expect_err("other settings").to_string();
    assert!(
        error.contains("other settings") && error.contains("remove it"),
        "{error}"
    );
    std::fs::write(&path, "a file of someone else").expect("a file");
    let error = run(&path, 2, &problem, &steps, 0).expect_err("another file");
    assert!(error.to_string().contains("no file of a run"), "{error}");
    std::fs::remove_file(&path).expect("a file");
    // as is a pipe, to open which would wait
    for other in [std::env::temp_dir(), "/dev/null".into()] {
        let error = run(&other, 2, &problem, &steps, 0).expect_err("no file");
        assert!(error.to_string().contains("no regular file"), "{error}");
    }
    let missing = std::env::temp_dir().join("no such folder").join("a");
    let error = run(&missing, 2, &problem, &steps, 0).expect_err("no folder");
    assert!(error.to_string().contains("cannot be used"), "{error}");
}

#[test]
fn a_request_to_stop_is_no_answer() {
    let path = file("stopped");
    let (problem, mut steps) = (Spring::new(), steps());
    let (whole, _) = run(&path, 2, &problem, &steps, 0).expect("a run");
    std::fs::remove_file(&path).expect("a file");
    steps.stop = Stop::new();
    steps.stop.request();
    let (stopped, _) = run(&path, 2, &problem, &steps, 0).expect("a run");
    assert!(stopped.is_empty());
    steps.stop = Stop::new();
    let (resumed, _) = run(&path, 2, &problem, &steps, 0).expect("a run");
    assert_eq!(resumed, whole);
    std::fs::remove_file(&path).expect("a file");
}

/// Answers that took many factorisations are a group each, and are in the file at once or with the next one.
#[test]
fn costly_answers_are_kept_one_by_one() {
    struct Costly(usize);
    impl Equilibrium for Costly {
        fn solve(
            &mut self,
            problem: &dyn ContactProblem,
            start: State,
            context: &StepContext<'_>,
        ) -> Result<Solution, Error> {
            let all = Rc::default();
            let mut solution = Drifting { asked: 0, all }.solve(problem, start, context)?;
            solution.history[0].cost.factorizations = self.0;
            Ok(solution)
        }
    }
    // 10 factorisations are worth a group: of 3 answers with 4 each, and of 1 with 12
    for (factorisations, expected) in [(0, 0), (4, 3), (12, 4)] {
        let path = file("costly");
        let mut solver = Resumable::new(&path, || Costly(factorisations)).every(100);
        let start = State {
            u: vec![0.0],
            ..State::default()
        };
        let mut seen = 0;
        let run = steps().run(&mut Spring::new(), &mut solver, start, |_| {
            seen += 1;
            match seen == 4 {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        run.expect("a run");
        drop(solver);
        let steps = kept(&path).expect("a file").map_or(0, |kept| kept.steps);
        assert_eq!(steps, expected, "{factorisations}");
        std::fs::remove_file(&path).expect("a file");
    }
}

/// What waits is written once writing takes little of the run.
#[test]
fn groups_wait_for_moments() {
    let path = file("waits");
    let header = Resumable::new(&path, || Drifting {
        asked: 0,
        all: Rc::default(),
    })
    .header(0);
    let mut journal = Journal::open(&path, &header).expect("a file");
    let length = || std::fs::metadata(&path).expect("a file").len();
    let at_first = length();
    let ago = |past: u64| Instant::now().checked_sub(Duration::from_secs(past));
    journal.written = Some((ago(19).expect("a time"), Duration::from_secs(1)));
    journal.complete(&path, false).expect("kept");
    assert_eq!(length(), at_first);
    journal.written = Some((ago(21).expect("a time"), Duration::from_secs(1)));
    journal.complete(&path, false).expect("kept");
    let written = length();
    // two groups without answers
    assert!(written > at_first && (written - at_first).is_multiple_of(2));
    journal.written = Some((ago(0).expect("a time"), Duration::from_secs(1)));
    journal.complete(&path, true).expect("kept");
    assert!(length() > written, "at the end of a phase");
    journal.written = Some((ago(0).expect("a time"), Duration::from_secs(1)));
    journal.complete(&path, false).expect("kept");
    let before = length();
    drop(journal);
    assert!(length() > before, "at the end of the run");
    std::fs::remove_file(&path).expect("a file");
}

/// The second of two runs by one value reads what the first has kept.
#[test]
fn a_value_serves_one_run_after_the_other() {
    let path = file("twice");
    let all = Rc::new(Cell::new(0));
    let make = || Drifting {
        asked: 0,
        all: Rc::clone(&all),
    };
    let mut solver = Resumable::new(&path, make).every(2);
    let mut energies = Vec::new();
    for _ in 0..2 {
        let start = State {
            u: vec![0.0],
            ..State::default()
        };
        let run = steps().run(&mut Spring::new(), &mut solver, start, |_| {
            ControlFlow::Continue(())
        });
        let run = run.expect("a run");
        assert!(run.error.is_none());
        energies.push(run.attempts.iter().map(|a| a.energy).collect::<Vec<_>>());
    }
    assert_eq!(energies[0], energies[1]);
    assert_eq!(all.get(), energies[0].len());
    std::fs::remove_file(&path).expect("a file");
}
