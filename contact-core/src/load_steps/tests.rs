//! Load steps of a problem with one unknown, whose solver follows curves that are given.

use std::cell::{Cell, RefCell};

use super::*;
use crate::equilibrium::StepContext;
use crate::gaps::{Row, Sampling};
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{Energy, Interruption};
use crate::{LinearGaps, Multipliers, RowKey};

/// An energy that only knows where it is finite, with the distance from `floor` as its domain.
struct Line {
    load: f64,
    floor: f64,
    /// The energy is infinite from here on, whatever the domain.
    wall: f64,
    /// What a lifted start is moved by.
    lift: Cell<f64>,
    /// The longest step that does not tunnel, and the calls (u, last u, from).
    longest: f64,
    asked: RefCell<Vec<[f64; 3]>>,
    /// What was left out by plan, and acts at the load 1.
    left_out: RefCell<Vec<&'static str>>,
    /// Whether constraints have been added; `None` if there are none to add.
    holds: Cell<Option<bool>>,
    pattern: SymmetricPattern,
    bounds: Bounds,
}

impl Default for Line {
    fn default() -> Self {
        Line {
            load: 0.0,
            floor: -1e3,
            wall: f64::INFINITY,
            lift: Cell::new(0.0),
            longest: f64::INFINITY,
            asked: RefCell::default(),
            left_out: RefCell::default(),
            holds: Cell::new(None),
            pattern: SymmetricPattern::diagonal(1),
            bounds: Bounds::free(1),
        }
    }
}

impl Energy for Line {
    fn dofs(&self) -> usize {
        1
    }
    fn value(&self, u: &[f64]) -> f64 {
        match u[0] > self.floor && u[0] < self.wall {
            true => 0.0,
            false => f64::INFINITY,
        }
    }
    fn gradient(&self, _: &[f64], g: &mut [f64]) {
        g[0] = 0.0;
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values[0] = 1.0;
    }
    fn domain_len(&self) -> usize {
        1
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        d[0] = u[0] - self.floor;
    }
}

impl ContactProblem for Line {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(LinearGaps::new(true))
    }
}

impl LoadStepped for Line {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.load = factor;
        Ok(())
    }
    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<Passage> {
        self.asked.borrow_mut().push([u[0], last[0], from]);
        (self.load - from > self.longest).then(|| Passage {
            depth: 7.0,
            place: "here".into(),
        })
    }
    fn hold(&self, solution: &Solution) -> Option<String> {
        let adds = self.holds.get() == Some(false);
        adds.then(|| {
            self.holds.set(Some(true));
            format!("deep at {}", solution.state.u[0])
        })
    }
    fn unplanned(&self, _: &[f64]) -> Option<String> {
        let mut left_out = self.left_out.borrow_mut();
        let what = if self.load == 1.0 {
            left_out.pop()
        } else {
            None
        };
        what.map(String::from)
    }
    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        vec![u[0] + self.lift.get() * (self.load - from)]
    }
}

/// What a solver was asked: start, multipliers of its two rows, and load factors from and to.
type Asked = (f64, [f64; 2], [f64; 2]);

/// Returns u(t) and the multipliers λ(t) at load t, with the outcome for a step from one load to the
/// next.
struct Follows<F> {
    u: fn(f64) -> f64,
    lambda: fn(f64) -> [f64; 2],
    outcome: F,
    asked: Vec<Asked>,
}

impl<F: FnMut(f64, f64) -> Outcome> Follows<F> {
    fn new(u: fn(f64) -> f64, lambda: fn(f64) -> [f64; 2], outcome: F) -> Self {
        Follows {
            u,
            lambda,
            outcome,
            asked: Vec::new(),
        }
    }
}

fn keys() -> [RowKey; 2] {
    [3, 5].map(|node| RowKey { pass: 0, node })
}

impl<F: FnMut(f64, f64) -> Outcome> Equilibrium for Follows<F> {
    fn solve(
        &mut self,
        _: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let [from, to] = [context.from, context.to];
        let multipliers = keys().map(|key| start.multipliers.of(key));
        self.asked.push((start.u[0], multipliers, [from, to]));
        let mut gaps = LinearGaps::new(true);
        for key in keys() {
            gaps.push(key, &Row::default());
        }
        let lambda = (self.lambda)(to).to_vec();
        Ok(Solution {
            outcome: (self.outcome)(from, to),
            state: State {
                u: vec![(self.u)(to)],
                multipliers: Multipliers::new(&gaps, &lambda),
            },
            energy: 0.0,
            gaps,
            lambda,
            history: Vec::new(),
            failed: Vec::new(),
            curvature: None,
            flickering: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction: None,
        })
    }
}

fn start() -> State {
    State {
        u: vec![0.0],
        ..State::default()
    }
}

fn in_increments(increments: usize) -> LoadSteps {
    LoadSteps {
        increments,
        ..LoadSteps::default()
    }
}

fn failed() -> Outcome {
    Outcome::SubproblemFailed("too far".into())
}

/// Steps beyond this length fail.
fn at_most(longest: f64) -> impl FnMut(f64, f64) -> Outcome {
    move |from, to| match to - from > longest + 1e-9 {
        true => failed(),
        false => Outcome::Converged,
    }
}

fn run<F: FnMut(f64, f64) -> Outcome>(
    settings: &LoadSteps,
    problem: &mut Line,
    solver: &mut Follows<F>,
) -> Run {
    let observe = |_: &Step<'_, Line>| ControlFlow::Continue(());
    let run = settings.run(problem, solver, start(), observe);
    run.expect("no misuse")
}

/// The loads that are attempted, and whether they were reached.
fn attempts(run: &Run) -> Vec<(f64, f64, bool)> {
    let attempts = run.attempts.iter();
    let all = attempts.map(|a| (a.from, a.to, a.outcome == Outcome::Converged));
    all.collect()
}

/// u = t² and λ = (1 − t, t): after steps of a quarter, one of a half is predicted by twice the last
/// change, and a multiplier that would be negative is none.
#[test]
fn predictions_go_on_by_the_length_of_the_step() {
    let mut problem = Line::default();
    let mut solver = Follows::new(|t| t * t, |t| [1.0 - 1.5 * t, t], at_most(0.25));
    let run = run(&in_increments(2), &mut problem, &mut solver);
    assert_eq!(run.ending, Ending::Complete);
    assert_eq!(
        attempts(&run),
        [
            (0.0, 0.5, false),
            (0.0, 0.25, true),
            (0.25, 0.5, true),
            (0.5, 1.0, false),
            (0.5, 0.75, true),
            (0.75, 1.0, true),
        ]
    );
    let predicted: Vec<bool> = run.attempts.iter().map(|a| a.predicted).collect();
    assert_eq!(predicted, [false, false, true, true, true, true]);
    // along the lines from (0, 0) to (¼, 1/16), from there to (½, ¼), and to (¾, 9/16)
    let starts = [0.0, 0.0, 0.125, 0.625, 0.4375, 0.875];
    // λ goes by −0.375 a quarter from 0.625, by 0.25 from 0.25; what was not there is 0 before
    let multipliers = [
        [0.0, 0.0],
        [0.0, 0.0],
        [1.25, 0.5],
        [0.0, 1.0],
        [0.0, 0.75],
        [0.0, 1.0],
    ];
    for (k, (u, lambda, loads)) in solver.asked.iter().enumerate() {
        let (from, to, _) = attempts(&run)[k];
        assert!((u - starts[k]).abs() < 1e-14, "{k}: {u}");
        for (l, expected) in lambda.iter().zip(multipliers[k]) {
            assert!((l - expected).abs() < 1e-14, "{k}: {lambda:?}");
        }
        assert_eq!(*loads, [from, to]);
    }
}

#[test]
fn without_a_predictor_every_step_starts_from_the_last_state() {
    let mut problem = Line::default();
    let mut solver = Follows::new(|t| t * t, |t| [t, t], |_, _| Outcome::Converged);
    let settings = LoadSteps {
        predictor: false,
        ..in_increments(4)
    };
    let run = run(&settings, &mut problem, &mut solver);
    assert!(run.attempts.iter().all(|attempt| !attempt.predicted));
    let starts: Vec<f64> = solver.asked.iter().map(|asked| asked.0).collect();
    assert_eq!(starts, [0.0, 0.0625, 0.25, 0.5625]);
}

/// The domain goes from 1 at rest to `half` at half the load; the line takes it to 2 `half` − 1, which
/// must be a tenth of `half`.
#[test]
fn predictions_that_collapse_are_not_taken() {
    for (half, predicted) in [(0.6, true), (0.53, true), (0.52, false), (0.505, false)] {
        let mut problem = Line {
            floor: -half,
            lift: Cell::new(0.02),
            ..Line::default()
        };
        // d = u + half: from 1 at rest to half
        let settings = in_increments(2);
        let mut solver = Follows::new(|_| 0.0, |_| [0.0; 2], |_, _| Outcome::Converged);
        let start = State {
            u: vec![1.0 - half],
            ..State::default()
        };
        let run = settings
            .run(&mut problem, &mut solver, start, |_| {
                ControlFlow::Continue(())
            })
            .expect("no misuse");
        assert_eq!(run.attempts[1].predicted, predicted, "{half}");
        let start = match predicted {
            true => half - 1.0,
            false => 0.01, // lifted by half of the load
        };
        assert!((solver.asked[1].0 - start).abs() < 1e-14, "{half}");
        assert!((run.attempts[1].min_domain - half).abs() < 1e-14, "{half}");
    }
}

/// The line would end at 2, beyond a wall that the domain does not know.
#[test]
fn predictions_without_an_energy_are_not_taken() {
    for (wall, predicted) in [(1.9, false), (2.1, true)] {
        let mut problem = Line {
            wall,
            ..Line::default()
        };
        let mut solver = Follows::new(|t| 2.0 * t, |_| [0.0; 2], |_, _| Outcome::Converged);
        let run = run(&in_increments(2), &mut problem, &mut solver);
        assert_eq!(run.attempts[1].predicted, predicted, "{wall}");
    }
}

#[test]
fn starts_are_lifted_where_that_is_admissible() {
    for (lift, start) in [(3.0, 3.0), (-2e3, 0.0)] {
        let mut problem = Line {
            lift: Cell::new(lift),
            ..Line::default()
        };
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], |_, _| Outcome::Converged);
        run(&in_increments(1), &mut problem, &mut solver);
        assert_eq!(solver.asked[0].0, start, "{lift}");
    }
}

/// Steps of more than 0.3 tunnel: they are halved, and the passage is judged from the last state.
#[test]
fn steps_that_tunnel_are_cut() {
    let mut problem = Line {
        longest: 0.3,
        ..Line::default()
    };
    let mut solver = Follows::new(|t| 2.0 * t, |_| [0.0; 2], |_, _| Outcome::Converged);
    let run = run(&in_increments(2), &mut problem, &mut solver);
    assert_eq!(run.ending, Ending::Complete);
    let reached = [
        (0.0, 0.5, false),
        (0.0, 0.25, true),
        (0.25, 0.5, true),
        (0.5, 1.0, false),
        (0.5, 0.75, true),
        (0.75, 1.0, true),
    ];
    assert_eq!(attempts(&run), reached);
    let tunnelled = Outcome::Tunnelled {
        depth: 7.0,
        place: "here".into(),
    };
    assert_eq!(run.attempts[0].outcome, tunnelled);
    assert_eq!(run.cuts(), 2);
    let asked: Vec<_> = reached
        .map(|(from, to, _)| [2.0 * to, 2.0 * from, from])
        .into();
    assert_eq!(*problem.asked.borrow(), asked);
}

/// Adaptive steps double as long as they converge, and are halved where they are longer than 0.25.
#[test]
fn adaptive_steps() {
    let mut problem = Line::default();
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], at_most(0.25));
    let settings = LoadSteps {
        phases: vec![Phase::new("all", 1.0, 10).adaptive(0.01, 0.4)],
        max_halvings: 0,
        ..LoadSteps::default()
    };
    let all = run(&settings, &mut problem, &mut solver);
    assert_eq!(all.ending, Ending::Complete);
    let expected = [
        (0.0, 0.1, true),
        (0.1, 0.3, true),
        (0.3, 0.7, false),
        (0.3, 0.5, true),
        (0.5, 0.9, false),
        (0.5, 0.7, true),
        (0.7, 1.0, false),
        (0.7, 0.85, true),
        (0.85, 1.0, true),
    ];
    let found = attempts(&all);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found.0 - expected.0).abs() + (found.1 - expected.1).abs();
        assert!(off < 1e-12 && found.2 == expected.2, "{found:?}");
    }

    // none that may be tried converges
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], at_most(0.005));
    let none = run(&settings, &mut problem, &mut solver);
    assert!(matches!(none.ending, Ending::NotConverged { .. }));
    assert_eq!(none.attempts.len(), 5, "0.1, 0.05, 0.025, 0.0125, 0.01");

    for (least, largest, name) in [
        (0.0, 0.1, "phase least step"),
        (f64::NAN, 0.1, "phase least step"),
        (0.2, 0.1, "phase least step"),
        (0.1, f64::NAN, "phase least step"),
        (0.1, f64::INFINITY, "phase largest step"),
    ] {
        let settings = LoadSteps {
            phases: vec![Phase::new("all", 1.0, 10).adaptive(least, largest)],
            ..LoadSteps::default()
        };
        let refused = settings.validate().expect_err("a wrong step").to_string();
        assert!(refused.contains(name), "{refused}");
    }
}

/// Two assumptions do not hold, one after the other: the last step is solved three times from the same start.
#[test]
fn steps_with_a_wrong_plan_are_solved_again() {
    let mut problem = Line::default();
    problem.left_out.borrow_mut().extend(["one", "the other"]);
    let mut solver = Follows::new(|t| 2.0 * t, |_| [0.0; 2], |_, _| Outcome::Converged);
    let run = run(&in_increments(2), &mut problem, &mut solver);
    assert_eq!(run.ending, Ending::Complete);
    assert_eq!(attempts(&run), [(0.0, 0.5, true), (0.5, 1.0, true)]);
    let asked: Vec<_> = solver
        .asked
        .iter()
        .map(|(u, _, loads)| (*u, *loads))
        .collect();
    let last = (2.0, [0.5, 1.0]);
    assert_eq!(asked[1..], [last; 3]);
    assert!(run.attempts[0].failed.is_empty());
    let failed: Vec<_> = run.attempts[1]
        .failed
        .iter()
        .map(|f| f.outcome.clone())
        .collect();
    let unplanned = ["the other", "one"].map(|what| Outcome::Unplanned(what.into()));
    assert_eq!(failed, unplanned);
    // what acts is looked at before bodies that went through each other
    assert_eq!(problem.asked.borrow().len(), 2);
}

/// A step that tunnels is cut. The first step that converges is solved again from the same start with more constraints, and no later step is.
#[test]
fn constraints_are_added_once() {
    let mut problem = Line {
        longest: 0.3,
        holds: Cell::new(Some(false)),
        ..Line::default()
    };
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], |_, _| Outcome::Converged);
    let added = run(&in_increments(2), &mut problem, &mut solver);
    assert_eq!(added.ending, Ending::Complete);
    let failed = added.attempts.iter().map(|attempt| &attempt.failed);
    let failed: Vec<Vec<Outcome>> = failed
        .map(|failed| failed.iter().map(|f| f.outcome.clone()).collect())
        .collect();
    assert!(matches!(
        added.attempts[0].outcome,
        Outcome::Tunnelled { .. }
    ));
    assert_eq!(
        failed[..2],
        [vec![], vec![Outcome::Unplanned("deep at 0.25".into())]]
    );
    assert!(failed[2..].iter().all(Vec::is_empty));
    assert_eq!(solver.asked.len(), added.attempts.len() + 1);
    assert_eq!(solver.asked[1], solver.asked[2]);
}

/// A problem that always finds something left out: the step has failed, and its halves do as well.
#[test]
fn plans_that_never_hold_end() {
    let mut problem = Line::default();
    problem.left_out.borrow_mut().extend(["this"; 1000]);
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], |_, _| Outcome::Converged);
    let settings = LoadSteps {
        max_halvings: 0,
        ..in_increments(1)
    };
    let run = run(&settings, &mut problem, &mut solver);
    let why = Outcome::Unplanned("this".into());
    assert!(matches!(run.ending, Ending::NotConverged { why: found, .. } if found == why));
    assert_eq!(solver.asked.len(), 100);
}

/// Steps beyond half the load fail. The problem is left where it converged, and all halvings are
/// taken, but no more.
#[test]
fn a_run_that_gives_up_leaves_the_last_load() {
    for most in 0..4 {
        let mut problem = Line::default();
        let outcome = |_: f64, to: f64| {
            if to > 0.5 {
                failed()
            } else {
                Outcome::Converged
            }
        };
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], outcome);
        let settings = LoadSteps {
            max_halvings: most,
            ..in_increments(2)
        };
        let run = run(&settings, &mut problem, &mut solver);
        let Ending::NotConverged { at, why, .. } = &run.ending else {
            panic!("{:?}", run.ending)
        };
        assert_eq!((*at, why), (0.5, &failed()));
        assert_eq!((run.factor, problem.load), (0.5, 0.5));
        assert_eq!(run.state.u, [0.5]);
        assert_eq!(run.cuts(), most + 1);
        let shortest = run.attempts.last().map(|a| a.to - a.from);
        assert_eq!(shortest, Some(0.5 * 0.5f64.powi(most as i32)));
    }
}

/// Between two loads there is no equilibrium. A step goes beyond them, to the end of an increment, as far as it may; where it went is told. Where
/// none is found beyond, either, the run ends by what failed first.
#[test]
fn steps_leap_over_loads_without_an_equilibrium() {
    let between = |low: f64, high: f64| {
        move |_: f64, to: f64| match to > low && to < high {
            true => Outcome::Cycle {
                period: 2,
                amplitude: 1e-5,
            },
            false => Outcome::Converged,
        }
    };
    let with = |max_leaps: usize, [low, high]: [f64; 2]| {
        let settings = LoadSteps {
            max_leaps,
            ..in_increments(10)
        };
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], between(low, high));
        run(&settings, &mut Line::default(), &mut solver)
    };
    // from 0.4, half of the increment, its quarter and so on are stuck; so is the next increment
    let leapt = with(2, [0.4, 0.65]);
    assert_eq!(leapt.ending, Ending::Complete);
    let [[from, to]] = leapt.leaps()[..] else {
        panic!("{:?}", leapt.leaps())
    };
    assert!(
        (from - 0.4).abs() < 1e-12 && (to - 0.7).abs() < 1e-12,
        "{from} {to}"
    );
    for (most, gap) in [
        (1, [0.4, 0.65]),
        (0, [0.4, 0.65]),
        (2, [0.4, 0.75]),
        (2, [0.8, 2.0]),
    ] {
        let ended = with(most, gap);
        let Ending::NotConverged { at, why, .. } = &ended.ending else {
            panic!("{:?}", ended.ending)
        };
        assert!(
            (at - gap[0]).abs() < 1e-12 && matches!(why, Outcome::Cycle { .. }),
            "{at} {why}"
        );
        assert!(ended.leaps().is_empty());
    }
}

/// A stall that is as large after three cuts ends the run and says so; one that shrinks with the step, and failures without a
/// size, are cut to the end.
#[test]
fn cuts_end_where_they_do_not_help() {
    let stall = |step: f64, power: i32| Outcome::Cycle {
        period: 2,
        amplitude: 0.01 * step.powi(power),
    };
    let cases: [(&dyn Fn(f64) -> Outcome, usize); 3] = [
        (&|step| stall(step, 0), 4),
        (&|step| stall(step, 1), 7),
        (&|_| failed(), 7),
    ];
    for (failure, cuts) in cases {
        let mut problem = Line::default();
        let outcome = |from: f64, to: f64| match to > 0.5 {
            true => failure(to - from),
            false => Outcome::Converged,
        };
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], outcome);
        let settings = LoadSteps {
            max_halvings: 6,
            ..in_increments(2)
        };
        let run = run(&settings, &mut problem, &mut solver);
        let Ending::NotConverged { at, cause, .. } = &run.ending else {
            panic!("{:?}", run.ending)
        };
        assert_eq!((*at, run.cuts()), (0.5, cuts));
        let told = cause.as_deref().unwrap_or_default();
        let says_so = told.contains("smaller steps do not reduce it");
        assert_eq!(says_so, cuts == 4, "{told}");
    }
}

/// Of three steps that converge, each is twice as long as the one before, up to the end.
#[test]
fn steps_grow_back_by_one_halving_a_success() {
    let mut problem = Line::default();
    let mut tries = 0;
    let outcome = |_: f64, _: f64| {
        tries += 1;
        if tries <= 2 {
            failed()
        } else {
            Outcome::Converged
        }
    };
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], outcome);
    let run = run(&in_increments(1), &mut problem, &mut solver);
    let to: Vec<f64> = run.attempts.iter().map(|attempt| attempt.to).collect();
    assert_eq!(to, [1.0, 0.5, 0.25, 0.75, 1.0]);
}

/// Every increment ends at its own load, however that is rounded, and steps within are none.
#[test]
fn increments_are_counted() {
    for increments in 1..60 {
        let mut problem = Line::default();
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], |_, _| Outcome::Converged);
        let mut seen = Vec::new();
        let settings = in_increments(increments);
        let run = settings.run(&mut problem, &mut solver, start(), |step| {
            seen.push(step.increment);
            ControlFlow::Continue(())
        });
        assert_eq!(run.expect("no misuse").attempts.len(), increments);
        let all: Vec<_> = (1..=increments).map(Some).collect();
        assert_eq!(seen, all);
    }
    let mut problem = Line::default();
    let mut solver = Follows::new(|t| t, |_| [0.0; 2], at_most(0.25));
    let mut seen = Vec::new();
    let run = in_increments(2).run(&mut problem, &mut solver, start(), |step| {
        seen.push(step.increment);
        ControlFlow::Continue(())
    });
    assert_eq!(run.expect("no misuse").ending, Ending::Complete);
    assert_eq!(seen, [None, Some(1), None, Some(2)]);
}

/// An observer that has enough at full load has seen a complete run.
#[test]
fn observers_end_runs_before_their_end() {
    for (at, ending) in [
        (
            0.5,
            Ending::Interrupted {
                at: 0.5,
                why: Interruption::Observer,
            },
        ),
        (1.0, Ending::Complete),
    ] {
        let mut problem = Line::default();
        let mut solver = Follows::new(|t| t, |_| [0.0; 2], |_, _| Outcome::Converged);
        let run = in_increments(2).run(&mut problem, &mut solver, start(), |step| {
            match step.factor >= at {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
        assert_eq!(run.expect("no misuse").ending, ending);
    }
}

/// A request between two steps ends the run before the second, and one within it is no cut.
#[test]
fn requests_are_seen_between_steps() {
    let mut problem = Line::default();
    let settings = in_increments(4);
    let stop = settings.stop.clone();
    let mut solver = Follows::new(
        |t| t,
        |_| [0.0; 2],
        |_, to| match to > 0.6 {
            true => Outcome::Interrupted,
            false => Outcome::Converged,
        },
    );
    let observe = |step: &Step<'_, Line>| {
        if step.factor > 0.4 {
            stop.request();
        }
        ControlFlow::Continue(())
    };
    let run = settings.run(&mut problem, &mut solver, start(), observe);
    let run = run.expect("no misuse");
    let why = Interruption::Requested;
    assert_eq!(run.ending, Ending::Interrupted { at: 0.5, why });
    assert_eq!((run.attempts.len(), run.cuts()), (2, 0));

    let mut problem = Line::default();
    let interrupted = self::run(&in_increments(4), &mut problem, &mut solver);
    let why = Interruption::Solver;
    assert_eq!(interrupted.ending, Ending::Interrupted { at: 0.5, why });
    assert_eq!((interrupted.attempts.len(), interrupted.cuts()), (3, 0));
    assert_eq!(problem.load, 0.5);
}

/// Refuses to go on at the load where `errs` says so, and fails before.
struct Errs<F>(F);

impl<F: FnMut(f64) -> Option<Outcome>> Equilibrium for Errs<F> {
    fn solve(
        &mut self,
        _: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let outcome = (self.0)(context.to).ok_or_else(|| Error::problem(std::fmt::Error))?;
        Ok(Solution {
            outcome,
            state: start,
            energy: 0.0,
            gaps: LinearGaps::new(true),
            lambda: Vec::new(),
            history: Vec::new(),
            failed: Vec::new(),
            curvature: None,
            flickering: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction: None,
        })
    }
}

/// An error is one of the run as long as nothing has converged, attempts that failed or not; after that,
/// the run has failed, and keeps what converged.
#[test]
fn errors_before_and_after_the_first_state() {
    let run = |errs: &dyn Fn(f64) -> Option<Outcome>| {
        let mut problem = Line::default();
        let settings = in_increments(2);
        let observe = |_: &Step<'_, Line>| ControlFlow::Continue(());
        let run = settings.run(&mut problem, &mut Errs(errs), start(), observe);
        (run, problem.load)
    };
    let at_once = run(&|_| None);
    assert!(at_once.0.is_err());
    let after_a_cut = run(&|to| if to == 0.5 { Some(failed()) } else { None });
    assert!(after_a_cut.0.is_err());
    let after_a_step = run(&|to| {
        if to == 0.5 {
            Some(Outcome::Converged)
        } else {
            None
        }
    });
    let kept = after_a_step.0.expect("a run");
    assert!(matches!(kept.ending, Ending::Failed { at: 0.5, .. }));
    assert_eq!((kept.factor, after_a_step.1), (0.5, 0.5));
    assert!(kept.error.is_some() && kept.solution.is_some());
}

/// Two phases: attempts and increments tell where they are, and nothing is predicted across the end of the first.
#[test]
fn phases_follow_each_other() {
    let settings = LoadSteps {
        phases: vec![Phase::new("press", 0.5, 2), Phase::new("slide", 2.5, 4)],
        ..LoadSteps::default()
    };
    let (mut problem, mut seen) = (Line::default(), Vec::new());
    let mut solver = Follows::new(|t| t, |t| [t, t], at_most(0.25));
    let observe = |step: &Step<'_, Line>| {
        seen.extend(step.increment.map(|k| (k, step.factor)));
        ControlFlow::Continue(())
    };
    let run = settings.run(&mut problem, &mut solver, start(), observe);
    let run = run.expect("no misuse");
    assert_eq!((run.ending, run.factor), (Ending::Complete, 2.5));
    let goals = [0.25, 0.5, 1.0, 1.5, 2.0, 2.5];
    assert_eq!(seen, (1..=6).zip(goals).collect::<Vec<_>>());
    let told: Vec<_> = run
        .attempts
        .iter()
        .map(|a| (a.phase.as_str(), a.from, a.to, a.predicted))
        .take(5)
        .collect();
    let expected = [
        ("press", 0.0, 0.25, false),
        ("press", 0.25, 0.5, true),
        ("slide", 0.5, 1.0, false),
        ("slide", 0.5, 0.75, false),
        ("slide", 0.75, 1.0, true),
    ];
    assert_eq!(told, expected);
}

/// An observer that breaks at the end of a phase stops the run, unless it is the last one.
#[test]
fn observers_stop_runs_between_phases() {
    let phases = vec![Phase::new("first", 1.0, 1), Phase::new("second", 2.0, 1)];
    for (stop_at, complete) in [(1.0, false), (2.0, true)] {
        let settings = LoadSteps {
            phases: phases.clone(),
            ..LoadSteps::default()
        };
        let mut solver = Follows::new(|t| t, |t| [t, t], at_most(9.0));
        let observe = |step: &Step<'_, Line>| match step.factor == stop_at {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let run = settings.run(&mut Line::default(), &mut solver, start(), observe);
        let run = run.expect("no misuse");
        assert_eq!(run.ending == Ending::Complete, complete, "{}", run.ending);
        assert_eq!(run.factor, stop_at);
    }
}

#[test]
fn wrong_phases_are_refused() {
    let phase = |until: f64, increments: usize| Phase::new("phase", until, increments);
    for (phases, says) in [
        (vec![phase(0.0, 1)], "`phase until` = 0"),
        (vec![phase(1.0, 1), phase(1.0, 1)], "`phase until` = 1"),
        (vec![phase(f64::NAN, 1)], "`phase until` = NaN"),
        (vec![phase(f64::INFINITY, 1)], "`phase until` = inf"),
        (vec![phase(5e-324, 3)], "`phase until` = 0.000"),
        (
            vec![phase(1.0, 1), phase(1.0 + f64::EPSILON, 3)],
            "`phase until` = 1.000",
        ),
        (vec![phase(1.0, 0)], "`phase increments` = 0"),
        (vec![phase(1.0, usize::MAX), phase(2.0, 5)], "`increments`"),
    ] {
        let settings = LoadSteps {
            phases,
            ..LoadSteps::default()
        };
        let error = settings.validate().expect_err("wrong").to_string();
        assert!(error.contains(says), "{error}");
    }
}
