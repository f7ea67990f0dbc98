//! The default solver: which one it takes, and what it does where that one fails.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::{disc_in_disc, relative, run};
use contact_core::{Automatic, Ending, Equilibrium, Interruption, Outcome};
use contact_fem::certificate::Condition;
use contact_fem::model::{Geometry, Problem};
use contact_fem::{Simulation, StepRecord};
use ipopt_contact_scenes::disc_in_disc::Roles;
use ipopt_contact_scenes::{cantilevers, tight};

fn chosen<const D: usize>(problem: &Problem<D>) -> &'static str {
    Automatic::default().choice(problem).solver
}

#[test]
fn the_solver_fits_the_scene() {
    let scene = || cantilevers::scene([4, 2, 2]).expect("a scene");
    let mut small = scene().problem().expect("valid scene");
    assert_eq!(chosen(&small), "condensed");
    let history = Simulation::with_increments(1)
        .run(&mut small)
        .expect("no misuse");
    let step = history.last().expect("converged");
    assert_eq!(step.attempt.solver(), Some("condensed"));
    assert_eq!(step.attempt.cost.factorizations, 1);

    let mut scene = scene();
    scene.geometry = Some(Geometry::Current);
    let mut following = scene.problem().expect("valid scene");
    assert_eq!(chosen(&following), "newton");
    let history = Simulation::with_increments(1)
        .run(&mut following)
        .expect("no misuse");
    let certificate = history.certificate().expect("converged");
    assert!(certificate.holds(&tight()), "{certificate}");

    let large = disc_in_disc(16, Roles::default());
    assert_eq!(chosen(&large), "newton");
}

/// How the attempts of Newton's method failed at a load step.
fn of_newton<const D: usize>(step: &StepRecord<D>) -> Vec<&Outcome> {
    let failed = step.attempt.failed.iter();
    let own = failed.filter(|failed| failed.solver == "newton");
    own.map(|failed| &failed.outcome).collect()
}

/// Newton's method with too few iterations for its tolerance fails at every step, also from the fixed point's end; the fixed point solves them
/// all, and the record says so. What nothing has examined is not told to be stable.
#[test]
fn steps_that_newton_does_not_solve_are_solved_by_ipopt() {
    let increments = 4;
    let mut simulation = Simulation::with_increments(increments);
    simulation.solver.newton.max_iterations = 1;
    simulation.solver.newton.tolerance = 1e-16;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fallback");
    let mut recording = simulation.record(&folder);
    recording.plan.quiet = true;
    let recorded = recording.run(&mut disc_in_disc(24, Roles::default()));
    let history = recorded.expect("no misuse").history;
    assert!(history.is_complete(), "{}", history.run.ending);
    for step in &history.steps {
        assert_eq!(step.attempt.solver(), Some("ipopt"));
        // from the start and from the end
        assert_eq!(of_newton(step), [&Outcome::IterationLimit; 2]);
        assert_eq!(step.attempt.iterations[0].solver, "newton");
    }
    let direct = run(&mut disc_in_disc(24, Roles::default()), increments, 1e-8);
    let [found, expected] = [&history, &direct].map(|h| h.last().expect("steps").energy);
    assert!(relative(found, expected) < 1e-7, "{found} for {expected}");

    let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(summary["solver"], "newton");
    assert_eq!(summary["steps_by_solver"]["ipopt"], increments);
    assert!(summary["certificate"]["instability"].is_null());
    let failures = history.steps.iter().map(|step| step.attempt.failed.len());
    assert_eq!(summary["repeated_attempts"], failures.sum::<usize>());
    let number = |key: &str| summary[key].as_f64().unwrap_or(f64::NAN);
    assert!(number("cpu_seconds") > 0.0);
    // the certified run has them, too
    let last = history.last().expect("a step");
    assert_eq!(number("pressure_min"), 0.0);
    assert!(relative(number("pressure_max"), last.pairs[0].pressure_max) < 1e-12);
    let area = number("contact_area");
    assert!(
        relative(area, last.pairs[0].area) < 1e-12 && (0.5..3.77).contains(&area),
        "a part of the disc's 2π 0.6: {area}"
    );
    let (work, stored) = (number("work"), number("stored_energy"));
    assert!(relative(work, stored) < 0.05, "{work} {stored}");
    assert!((number("unstored_work") - (work - stored)).abs() < 1e-9 * work);
    let works = summary["works"].as_array().expect("a list");
    let sum: f64 = works
        .iter()
        .map(|own| own["work"].as_f64().unwrap_or(f64::NAN))
        .sum();
    assert!((sum - work).abs() < 1e-9 * work, "{works:?}");
    // 953.8 on quadratic meshes of 60 000 unknowns that were refined where it was needed
    let estimated = number("estimated_energy_error") / (number("energy") - 953.8);
    assert!((0.7..2.0).contains(&estimated), "{estimated}");
    let relative_error = (number("estimated_energy_error") / stored).sqrt();
    let shares = number("estimated_error") / relative_error;
    assert!((0.9..1.0).contains(&shares), "{shares}");
    let bodies = summary["estimated_errors"].as_array().expect("a list");
    assert_eq!(bodies[1]["error"], 0.0, "the disc is prescribed");
    assert!(bodies[0]["place"][1].as_f64().is_some_and(|y| y < -0.6));
    let touching = summary["contact_facets_touching"].as_u64();
    assert!(touching.is_some_and(|count| (4..24).contains(&count)));
}

/// Newton's method with too few iterations for an increment ends from where the fixed point has come, and examines that state: the disc is stable.
#[test]
fn what_ipopt_has_found_is_examined() {
    let mut simulation = Simulation::with_increments(2);
    simulation.solver.newton.max_iterations = 3;
    let run = simulation.run(&mut disc_in_disc(24, Roles::default()));
    let history = run.expect("no misuse");
    for step in &history.steps {
        let solvers = step.attempt.iterations.iter().map(|own| own.solver);
        let solvers: BTreeSet<_> = solvers.collect();
        assert_eq!(solvers, BTreeSet::from(["ipopt", "newton"]));
        // from the start alone
        assert_eq!(of_newton(step), [&Outcome::IterationLimit]);
    }
    let certificate = history.certificate().expect("steps");
    assert_eq!(certificate.left(Condition::Instability), Some(0.0));
    assert!(certificate.holds(&tight()), "{certificate}");
}

#[test]
fn a_stop_request_is_not_taken_for_a_failure() {
    let mut simulation = Simulation::with_increments(4);
    simulation.load_steps.stop.request();
    let history = simulation
        .run(&mut disc_in_disc(16, Roles::default()))
        .expect("no misuse");
    let why = Interruption::Requested;
    assert_eq!(history.run.ending, Ending::Interrupted { at: 0.0, why });
    assert!(
        history
            .run
            .attempts
            .iter()
            .all(|attempt| attempt.failed.is_empty())
    );
}
