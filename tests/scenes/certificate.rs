//! The certificate of a step holds where it should, and finds faults that are planted.

use crate::support::hairpin;
use std::ops::ControlFlow;

use crate::common::{Order, disc_in_disc, run, run_with};
use contact_core::fixed_point::{Outcome, Solution};
use contact_core::gaps::{LinearGaps, Row};
use contact_core::load_steps::RunOutcome;
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, Energy, Error, FixedPoint, InteriorPoint, Method, PenalizedSlack, Penalty,
    Scale, State,
};
use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::scene::{Passes, Problem};
use contact_fem::{Body, Certificate, LinearElastic, Scene};

/// The names of what is beyond its limit.
fn failures(certificate: &Certificate) -> Vec<&'static str> {
    let entries = certificate.entries(&Limits::default());
    let failed = entries.iter().filter(|entry| !entry.holds());
    failed.map(|entry| entry.name).collect()
}

/// A coarse disc-in-disc at full load.
fn solved() -> (Problem<2>, Solution) {
    let mut problem = disc_in_disc(32, Passes::Both, Order::RingFirst);
    let history = run(&mut problem, 8, 1e-8);
    assert_eq!(history.run.outcome, RunOutcome::Complete);
    let solution = history.run.solution.expect("converged");
    (problem, solution)
}

#[test]
fn sound_runs_hold() {
    let disc = |method: &mut dyn Method| {
        let mut problem = disc_in_disc(32, Passes::Both, Order::RingFirst);
        run_with(method, &mut problem, 8, 1e-6).certificate()
    };
    let mut hairpin = hairpin::scene(3, true)
        .expect("scene")
        .problem()
        .expect("valid");
    for certificate in [
        disc(&mut InteriorPoint::default()),
        disc(&mut PenalizedSlack::default()),
        disc(&mut Penalty::default()),
        run(&mut hairpin, 8, 1e-6).certificate(),
    ] {
        let certificate = certificate.expect("steps");
        assert!(failures(&certificate).is_empty(), "{certificate}");
        assert!(certificate.to_string().starts_with("holds"));
    }
}

/// The certificate's numbers, each once more by hand.
#[test]
fn values_are_what_they_say() {
    let (problem, solution) = solved();
    let certificate = Certificate::new(&problem, &solution);
    let u = &solution.state.u;
    let mut gradient = vec![0.0; u.len()];
    problem.energy().gradient(u, &mut gradient);
    let mut forces = vec![0.0; u.len()];
    solution.gaps.add_forces(&solution.lambda, &mut forces);
    let rest = gradient.iter().zip(&forces).map(|(g, f)| (g - f).abs());
    let rest = rest.fold(0.0, f64::max);
    // the largest force on a node is a contact force or a reaction; it is 10 to 1000 here
    assert!(rest / 1000.0 <= certificate.stationarity && certificate.stationarity <= rest / 10.0);
    let J = contact_fem::output::Snapshot::new(&problem, &solution).expect("fields");
    let J = J
        .cells
        .iter()
        .map(|cell| cell.J)
        .fold(f64::INFINITY, f64::min);
    assert!(
        (certificate.min_j / J - 1.0).abs() < 1e-12,
        "one J a linear cell"
    );
    assert_eq!(
        certificate.dropped + solution.gaps.len(),
        problem.contact_nodes()
    );
}

/// The rows of `gaps` for which `keep` gives a sign, times that sign.
fn rows(gaps: &LinearGaps, keep: impl Fn(usize) -> Option<f64>) -> LinearGaps {
    let mut kept = LinearGaps::new(false);
    for (i, &key) in gaps.keys().iter().enumerate() {
        let Some(sign) = keep(i) else { continue };
        let mut unit = vec![0.0; gaps.len()];
        unit[i] = sign;
        let mut row = Row {
            constant: sign * gaps.constant()[i],
            weight: gaps.weights()[i],
            ..Row::default()
        };
        let free = gaps.entries().filter(|entry| entry.0 == i);
        row.free.extend(free.map(|(_, j, c)| (j, sign * c)));
        kept.push(key, &row);
    }
    kept
}

/// The most loaded row.
fn active(solution: &Solution) -> usize {
    let rows = 0..solution.lambda.len();
    let most = rows.max_by(|&i, &j| solution.lambda[i].total_cmp(&solution.lambda[j]));
    most.expect("rows")
}

#[test]
fn a_flipped_normal_is_found() {
    let (problem, mut solution) = solved();
    let flipped = active(&solution);
    solution.gaps = rows(&solution.gaps, |i| {
        Some(if i == flipped { -1.0 } else { 1.0 })
    });
    let found = failures(&Certificate::new(&problem, &solution));
    assert!(found.contains(&"drift"), "{found:?}");
}

/// Forces that pull instead of pushing: with λ and the rows of the other sign all is in balance.
#[test]
fn adhesion_is_found() {
    let (problem, mut solution) = solved();
    solution.lambda.iter_mut().for_each(|l| *l = -*l);
    let found = failures(&Certificate::new(&problem, &solution));
    assert!(found.contains(&"adhesion"), "{found:?}");
}

/// No entry holds of what is no number.
#[test]
fn nothing_is_certified_of_a_nan() {
    let (problem, solution) = solved();
    let [mut in_u, mut in_lambda, mut all] = [0; 3].map(|_| solution.clone());
    in_u.state.u[7] = f64::NAN;
    in_lambda.lambda[0] = f64::NAN;
    all.state.u.fill(f64::NAN);
    for solution in [in_u, in_lambda, all] {
        let found = failures(&Certificate::new(&problem, &solution));
        assert!(found.len() >= 9, "{found:?}");
    }
    let nan = vec![f64::NAN; problem.energy().dofs()];
    assert!(problem.linearize_gaps(&nan).is_err());
    assert!(problem.linearize_gaps(&[0.0]).is_err());
}

/// Linear scenes under next to no load: what round-off leaves of their forces is allowed for.
#[test]
fn next_to_no_load() {
    for load in [1.0, 1e-3, 1e-6, 1e-9] {
        let block = |y: f64, n: usize| {
            let (xs, ys) = (linspace(0.0, 1.0, n), linspace(y, y + 1.0, n));
            let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
            Body::new(mesh, LinearElastic::new(1e3, 0.3).expect("law"))
        };
        let (mut lower, mut upper) = (block(0.0, 4), block(1.0, 5));
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        upper.prescribe("left", [Some(0.0), None]).expect("support");
        upper.traction("top", [0.0, -load]).expect("load");
        let mut scene = Scene::new(vec![lower, upper]);
        scene.contact((0, "top"), (1, "bottom")).expect("surfaces");
        let mut problem = scene.problem().expect("valid scene");
        let certificate = run(&mut problem, 1, 1e-6).certificate().expect("a step");
        assert!(failures(&certificate).is_empty(), "{load}: {certificate}");
    }
}

#[test]
fn a_dropped_row_is_found() {
    let (problem, mut solution) = solved();
    let dropped = active(&solution);
    solution.gaps = rows(&solution.gaps, |i| (i != dropped).then_some(1.0));
    solution.lambda.remove(dropped);
    let certificate = Certificate::new(&problem, &solution);
    assert_eq!(certificate.closed, 1);
    let found = failures(&certificate);
    assert!(
        found.contains(&"closed") && found.contains(&"stationarity"),
        "{found:?}"
    );
}

#[test]
fn a_perturbed_displacement_is_found() {
    let (problem, solution) = solved();
    for dof in [0, 100, solution.state.u.len() - 1] {
        let mut moved = solution.clone();
        moved.state.u[dof] += 1e-5;
        let found = failures(&Certificate::new(&problem, &moved));
        assert!(found.contains(&"stationarity"), "dof {dof}: {found:?}");
    }
}

/// A problem whose rows are tampered with on the way to the optimiser.
struct Faulty<'a> {
    problem: &'a Problem<2>,
    tamper: &'a dyn Fn(LinearGaps) -> LinearGaps,
}

impl ContactProblem for Faulty<'_> {
    fn energy(&self) -> &dyn Energy {
        self.problem.energy()
    }
    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }
    fn linearize_gaps(&self, u: &[f64]) -> Result<LinearGaps, Error> {
        self.problem.linearize_gaps(u).map(self.tamper)
    }
    fn scale(&self) -> Scale {
        self.problem.scale()
    }
    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}

/// What the solver finds converged with such rows.
fn solved_with(
    problem: &Problem<2>,
    from: &State,
    tamper: &dyn Fn(LinearGaps) -> LinearGaps,
) -> Solution {
    let settings = FixedPoint {
        tolerance: 1e-8,
        ..FixedPoint::default()
    };
    let faulty = Faulty { problem, tamper };
    let mut method = InteriorPoint::default();
    let solution = settings.solve(&faulty, &mut method, from.clone());
    let solution = solution.expect("no misuse");
    assert_eq!(
        solution.outcome,
        Outcome::Converged,
        "the solver sees nothing"
    );
    solution
}

/// All is well to the optimiser where the disc's rows are forgotten, but not to the certificate.
#[test]
fn a_broken_symmetry_is_found() {
    let (problem, solution) = solved();
    let sound = solved_with(&problem, &solution.state, &|gaps| gaps);
    assert!(failures(&Certificate::new(&problem, &sound)).is_empty());
    let one_sided = |gaps: LinearGaps| {
        let passes: Vec<u32> = gaps.keys().iter().map(|key| key.pass).collect();
        rows(&gaps, |i| (passes[i] == 0).then_some(1.0))
    };
    let solution = solved_with(&problem, &solution.state, &one_sided);
    let certificate = Certificate::new(&problem, &solution);
    let found = failures(&certificate);
    assert!(found.contains(&"closed"), "{found:?}");
    assert!(found.contains(&"weak_penetration"), "{certificate}");
}

/// A row of the middle of the contact is forgotten in every iteration.
#[test]
fn a_forgotten_row_is_found() {
    let (problem, solution) = solved();
    let key = solution.gaps.keys()[active(&solution)];
    let forgotten = |gaps: LinearGaps| {
        let keys = gaps.keys().to_vec();
        rows(&gaps, |i| (keys[i] != key).then_some(1.0))
    };
    let solution = solved_with(&problem, &solution.state, &forgotten);
    let found = failures(&Certificate::new(&problem, &solution));
    assert!(found.contains(&"closed"), "{found:?}");
}

/// A run goes on for its observer's certificate only as long as that holds, if the user wants so.
#[test]
fn an_observer_may_stop_at_a_bad_certificate() {
    let mut problem = disc_in_disc(32, Passes::Both, Order::RingFirst);
    let strict = Limits {
        nodal_penetration: 0.0,
        ..Limits::default()
    };
    let mut simulation = contact_fem::Simulation::with_increments(8);
    simulation.load_steps.fixed_point.tolerance = 1e-6;
    let history = simulation.run(
        &mut problem,
        &mut InteriorPoint::default(),
        |step| match step.record.certificate.holds(&strict) {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        },
    );
    let history = history.expect("no misuse");
    assert!(matches!(
        history.run.outcome,
        RunOutcome::Interrupted { .. }
    ));
}
