//! Runs that a budget or a request ends: what they keep, what they say, and how soon they end.

use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::disc_in_disc;
use contact_core::ipopt::{Options, Solver, Start};
use contact_core::nlp::{Bounds, Iterate, Nlp, Pattern, Structure};
use contact_core::{Budget, Ending, Equilibrium, Error, Interruption, LoadSteps, Outcome, Stop};
use contact_fem::element::Order;
use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::{Scene, Simulation};
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::cli::Solver as Choice;
use ipopt_contact_scenes::disc_in_disc::Roles;
use ipopt_contact_scenes::hertz::{Fineness, Hertz};
use ipopt_contact_scenes::{cantilevers, tight};

/// No run of these tests takes nearly as long.
const LONG: Duration = Duration::from_secs(120);

fn factorizations(limit: usize) -> Budget {
    Budget {
        factorizations: Some(limit),
        ..Budget::default()
    }
}

fn seconds(seconds: f64) -> Budget {
    Budget {
        seconds: Some(seconds),
        ..Budget::default()
    }
}

/// So many increments by a solver with its default settings, within a budget.
fn simulation(
    solver: Choice,
    increments: usize,
    budget: Budget,
) -> Simulation<Box<dyn Equilibrium>> {
    let mut simulation = Simulation::solved_by(solver.with_tolerance(None), increments);
    simulation.load_steps.budget = budget;
    simulation
}

fn discs() -> Problem<2> {
    disc_in_disc(16, Roles::default())
}

/// What a run of the discs leaves, and the displacements of its steps.
fn run_discs(solver: Choice, budget: Budget) -> (History<2>, Vec<Vec<f64>>) {
    let mut states = Vec::new();
    let mut simulation = simulation(solver, 8, budget);
    let history = simulation.run_observed(&mut discs(), |step| {
        states.push(step.solution.state.u.clone());
        ControlFlow::Continue(())
    });
    (history.expect("no misuse"), states)
}

/// Checks that a run has kept what has converged, and only that.
fn check_kept<const D: usize>(history: &History<D>, expected: Interruption) {
    let run = &history.run;
    let Ending::Interrupted { at, why } = run.ending else {
        panic!("{}", run.ending);
    };
    assert_eq!((at, why), (run.factor, expected));
    assert_eq!(at, history.last().map_or(0.0, |step| step.factor));
    assert_eq!(run.cuts(), 0);
    assert!(run.attempts.iter().all(|attempt| attempt.failed.is_empty()));
    match &run.solution {
        Some(solution) => {
            assert_eq!(solution.outcome, Outcome::Converged);
            assert_eq!(solution.state.u, run.state.u);
            let certificate = history.certificate().expect("steps");
            assert!(certificate.holds(&tight()), "{certificate}");
        }
        None => assert!(history.steps.is_empty() && run.state.u.iter().all(|u| *u == 0.0)),
    }
}

#[test]
fn the_factorisation_beyond_a_budget_is_not_begun() {
    for solver in [Choice::Newton, Choice::Ipopt, Choice::Automatic] {
        let (whole, states) = run_discs(solver, Budget::default());
        let all = whole.run.cost().factorizations;
        let (again, _) = run_discs(solver, factorizations(all));
        assert!(again.is_complete(), "{solver}: {}", again.run.ending);
        let limit = all / 2;
        for _ in 0..2 {
            let (history, kept) = run_discs(solver, factorizations(limit));
            check_kept(&history, Interruption::Factorizations { limit });
            assert_eq!(history.run.cost().factorizations, limit, "{solver}");
            assert!(!kept.is_empty() && kept[..] == states[..kept.len()]);
            let last = history.run.attempts.last().expect("an attempt");
            assert_eq!(last.outcome, Outcome::Interrupted);
            assert!(!last.iterations.is_empty());
        }
    }
}

#[test]
fn condensation_counts_its_factorisations_as_its_cost_does() {
    let run = |scene: Scene<3>, increments, limit| {
        let mut problem = scene.problem().expect("valid scene");
        let mut simulation = simulation(Choice::Condensed, increments, factorizations(limit));
        simulation.run(&mut problem).expect("no misuse")
    };
    let beams = || cantilevers::scene([4, 2, 2]).expect("a scene");
    let none = run(beams(), 4, 0);
    check_kept(&none, Interruption::Factorizations { limit: 0 });
    assert_eq!(none.run.cost().factorizations, 0);
    assert!(run(beams(), 4, 1).is_complete());

    let hertz = |limit| {
        let hertz = Hertz::new(Fineness::family(10), Order::Linear);
        let mut problem = hertz.scene().expect("a scene").problem().expect("valid");
        let mut simulation = simulation(Choice::Condensed, 1, factorizations(limit));
        simulation.run(&mut problem).expect("no misuse")
    };
    let stopped = hertz(1);
    check_kept(&stopped, Interruption::Factorizations { limit: 1 });
    assert_eq!(stopped.run.cost().factorizations, 1);
    assert!(hertz(2).is_complete());
}

/// The observer sleeps, so that the deadline comes during the run on any machine.
#[test]
fn a_deadline_keeps_what_has_converged() {
    fn check<const D: usize>(solver: Choice, mut problem: Problem<D>) {
        let stop = Stop::new();
        let (given, clock) = (0.3, Instant::now());
        let mut simulation = simulation(solver, 50, seconds(given));
        simulation.load_steps.stop = stop.clone();
        let history = simulation.run_observed(&mut problem, |_| {
            thread::sleep(Duration::from_millis(100));
            ControlFlow::Continue(())
        });
        let history = history.expect("no misuse");
        check_kept(&history, Interruption::Deadline { seconds: given });
        assert!(history.steps.len() <= 4 && clock.elapsed() < LONG);
        assert!(!stop.is_requested(), "a budget is the run's own");
    }
    check(Choice::Newton, discs());
    check(Choice::Ipopt, discs());
    let beams = cantilevers::scene([4, 2, 2]).expect("a scene");
    check(Choice::Condensed, beams.problem().expect("valid scene"));
}

#[test]
fn a_run_without_time_keeps_its_start() {
    for solver in [Choice::Newton, Choice::Ipopt, Choice::Automatic] {
        let (history, _) = run_discs(solver, seconds(0.0));
        check_kept(&history, Interruption::Deadline { seconds: 0.0 });
        assert!(history.run.attempts.is_empty());
    }
}

#[test]
fn budgets_that_are_no_time_are_refused() {
    for given in [f64::NAN, f64::INFINITY, -1.0] {
        let steps = LoadSteps {
            budget: seconds(given),
            ..LoadSteps::default()
        };
        let refused = steps.validate().expect_err("refused");
        let (told, value) = (refused.to_string(), format!("{given:?}"));
        assert!(matches!(refused, Error::Setting { .. }));
        assert!(told.contains(&value) && told.contains("None"), "{told}");
        let mut simulation = simulation(Choice::Newton, 1, seconds(given));
        assert!(simulation.run(&mut discs()).is_err());
    }
}

/// x², whose first iterate lasts until it is told to go on.
struct Held {
    begun: Sender<()>,
    go_on: Receiver<()>,
}

impl Nlp for Held {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x[0] * x[0]
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = 2.0 * x[0];
    }
    fn hessian(&mut self, _: &[f64], _: bool, factor: f64, _: &[f64], values: &mut [f64]) {
        values[0] = 2.0 * factor;
    }
    fn iterate(&mut self, _: &Iterate<'_>) -> ControlFlow<()> {
        self.begun.send(()).expect("the test waits");
        let _ = self.go_on.recv_timeout(LONG);
        ControlFlow::Break(())
    }
}

#[test]
fn a_deadline_is_seen_while_another_thread_solves() {
    let structure = Structure::new(
        Bounds::free(1),
        Bounds::default(),
        Pattern::empty(),
        Some(Pattern::diagonal(1)),
    );
    let mut solver = Solver::new(structure.expect("valid"), &Options::new()).expect("valid");
    let ((begun, has_begun), (release, go_on)) = (channel(), channel());
    thread::scope(|scope| {
        let other = scope.spawn(move || {
            let solution = solver.solve(&mut Held { begun, go_on }, &Start::at(&[1.0]));
            solution.map(|solution| solution.status.is_interrupted())
        });
        has_begun.recv().expect("it solves");
        let given = 0.2;
        let (history, _) = run_discs(Choice::Ipopt, seconds(given));
        assert!(!other.is_finished(), "it solves all the time");
        release.send(()).expect("it waits");
        assert!(other.join().expect("no panic").expect("no misuse"));
        check_kept(&history, Interruption::Deadline { seconds: given });
    });
}

/// Prints the delays between a request and the end of a run, in ten tries at even intervals over the run, or over its
/// first ten seconds. A star marks those that waited for the record of a converged step.
fn delays<const D: usize>(name: &str, solver: Choice, increments: usize, problem: &mut Problem<D>) {
    let clock = Instant::now();
    let first = simulation(solver, increments, seconds(10.0)).run(problem);
    let (length, first) = (clock.elapsed(), first.expect("no misuse"));
    let tries = (0..10).map(|k| {
        let mut simulation = simulation(solver, increments, Budget::default());
        let stop = simulation.load_steps.stop.clone();
        let requests = thread::spawn(move || {
            thread::sleep(length.mul_f64((f64::from(k) + 0.5) / 10.5));
            stop.request();
            Instant::now()
        });
        let history = simulation.run(problem).expect("no misuse");
        let ended = Instant::now();
        let delay = ended.saturating_duration_since(requests.join().expect("no panic"));
        let last = history.run.attempts.last();
        let is_recorded = last.is_none_or(|last| last.outcome == Outcome::Converged);
        let mark = if is_recorded { "*" } else { "" };
        match history.is_complete() {
            true => "none".into(),
            false => format!("{:.0}{mark}", 1e3 * delay.as_secs_f64()),
        }
    });
    let tries: Vec<String> = tries.collect();
    println!(
        "{name}, {solver}, {} unknowns, {length:.1?}, {}: {} ms",
        problem.dofs().free(),
        first.run.ending,
        tries.join(" ")
    );
}

/// `cargo test --test scenes -- --ignored how_soon --nocapture` makes the table of `docs/robustness.md`.
#[test]
#[ignore = "measures for minutes"]
fn how_soon_a_request_ends_a_run() {
    for solver in [Choice::Newton, Choice::Ipopt] {
        let name = "disc-in-disc, 228 segments";
        delays(name, solver, 20, &mut disc_in_disc(228, Roles::default()));
    }
    let beams = |across, law| {
        let beams = Beams::new(across, Order::Quadratic, law);
        beams.scene().expect("a scene").problem().expect("valid")
    };
    let (small, large) = (Law::SmallStrain, Law::NeoHookean);
    delays("beams", Choice::Newton, 10, &mut beams(3, large));
    delays("beams", Choice::Ipopt, 10, &mut beams(2, large));
    delays("beams", Choice::Condensed, 1, &mut beams(4, small));
}
