//! The certificate of a step holds where it should, and finds faults that are planted.

use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::hairpin;
use std::ops::ControlFlow;

use crate::common::{disc_in_disc, run, run_with};
use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, Continuation, Energy, Equilibrium, Error, FixedPoint, InteriorPoint, Method,
    PenalizedSlack, Penalty, Scale, State,
};
use contact_core::{Ending, Interruption};
use contact_core::{Outcome, equilibrium::Solution};
use contact_fem::certificate::{Condition, Limits};
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::{Integration, Passes, Problem};
use contact_fem::{Body, Certificate, LinearElastic, Mesh, NeoHookean, Scene};
use ipopt_contact_scenes::pair;

/// The names of what is beyond its limit.
fn failures(certificate: &Certificate) -> Vec<&'static str> {
    let entries = certificate.entries(&Limits::default());
    let failed = entries.filter(|entry| !entry.holds());
    failed.map(|entry| entry.name).collect()
}

/// A coarse disc-in-disc at full load.
fn solved() -> (Problem<2>, Solution) {
    let mut problem = disc_in_disc(32, Roles::default());
    let history = run(&mut problem, 8, 1e-8);
    assert_eq!(history.run.ending, Ending::Complete);
    let solution = history.run.solution.expect("converged");
    (problem, solution)
}

#[test]
fn sound_runs_hold() {
    let disc = |method: &mut dyn Method| {
        let mut problem = disc_in_disc(32, Roles::default());
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
    let left = |condition| certificate.left(condition).expect("a value");
    let stationarity = left(Condition::Stationarity);
    assert!(rest / 1000.0 <= stationarity && stationarity <= rest / 10.0);
    let fields = contact_fem::output::Snapshot::new(&problem, &solution).expect("fields");
    assert!(
        fields.cells.iter().all(|cell| cell.J > 0.0),
        "one J a linear cell"
    );
    assert_eq!(left(Condition::Inverted), 0.0);
    assert_eq!(
        left(Condition::Dropped) as usize + solution.gaps.len(),
        problem.contact_nodes()
    );
}

/// The rows of `gaps` for which `keep` gives a sign, times that sign.
fn rows(gaps: &LinearGaps, keep: impl Fn(usize) -> Option<f64>) -> LinearGaps {
    let mut kept = LinearGaps::new(false).sampled_at(gaps.sampling());
    for (i, &key) in gaps.keys().iter().enumerate() {
        let Some(sign) = keep(i) else { continue };
        let mut row = gaps.row(i);
        row.constant *= sign;
        let entries = row.free.iter_mut().chain(&mut row.prescribed);
        entries.for_each(|(_, c)| *c *= sign);
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
    let with = |sign: f64| {
        rows(&solution.gaps, |i| {
            Some(if i == flipped { sign } else { 1.0 })
        })
    };
    let (as_it_is, flipped) = (with(1.0), with(-1.0));
    solution.gaps = as_it_is;
    assert!(failures(&Certificate::new(&problem, &solution)).is_empty());
    solution.gaps = flipped;
    let found = failures(&Certificate::new(&problem, &solution));
    assert!(
        found.contains(&"drift") && found.contains(&"stationarity"),
        "{found:?}"
    );
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
    assert!(problem.linearize_gaps(&nan, Sampling::Nodes).is_err());
    assert!(problem.linearize_gaps(&[0.0], Sampling::Nodes).is_err());
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
        let scene = pair((lower, "top"), (upper, "bottom")).expect("surfaces");
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
    assert_eq!(certificate.left(Condition::Closed), Some(1.0));
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
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Ok((self.tamper)(self.problem.rows(u, sampling)?))
    }
    fn scale(&self) -> Option<Scale> {
        Some(self.problem.scale())
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
    let mut fixed_point = FixedPoint {
        tolerance: 1e-8,
        ..FixedPoint::with(InteriorPoint::default())
    };
    let faulty = Faulty { problem, tamper };
    let solution = fixed_point.solve_from(&faulty, from.clone());
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
    let mut problem = disc_in_disc(32, Roles::default());
    let strict = Limits::default().with(Condition::NodalPenetration, 0.0);
    let mut simulation = contact_fem::Simulation::with_increments(8);
    let history = simulation.run_observed(&mut problem, |step| {
        match step.record.certificate.holds(&strict) {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    });
    let history = history.expect("no misuse");
    let why = Interruption::Observer;
    assert!(matches!(history.run.ending, Ending::Interrupted { why: w, .. } if w == why));
}

/// The lower of two square blocks, held below, and the upper one.
fn blocks(cells: [usize; 2], x: [f64; 2], low: impl Fn(Mesh<2>) -> Body<2>) -> [Body<2>; 2] {
    let block = |[from, to]: [f64; 2], y: f64, n: usize| {
        let (xs, ys) = (linspace(from, to, n), linspace(y, y + 1.0, n));
        low(rectangle(&xs, &ys, Diagonals::Rising).expect("mesh"))
    };
    let (mut lower, upper) = (block([0.0, 1.0], 0.0, cells[0]), block(x, 1.0, cells[1]));
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    [lower, upper]
}

fn elastic(young: f64) -> impl Fn(Mesh<2>) -> Body<2> {
    move |mesh| Body::new(mesh, LinearElastic::new(young, 0.3).expect("law"))
}

fn touching(bodies: [Body<2>; 2], integration: Option<Integration>) -> Problem<2> {
    let [lower, upper] = bodies;
    let mut scene = pair((lower, "top"), (upper, "bottom")).expect("surfaces");
    scene.integration = integration;
    scene.problem().expect("valid scene")
}

fn methods() -> [Box<dyn Method>; 3] {
    [
        Box::new(InteriorPoint::default()),
        Box::new(PenalizedSlack::default()),
        Box::new(Penalty::default()),
    ]
}

/// Bodies so stiff that all of their displacements are a tiny part of a facet, which go through each
/// other for want of a penalty or by a planted shift.
#[test]
fn stiff_bodies_inside_each_other_are_found() {
    for pressed in [1e-3, 1e-5] {
        let stiff = || {
            let [lower, mut upper] = blocks([4, 5], [0.0, 1.0], elastic(2e5));
            let down = [Some(0.0), Some(-pressed)];
            upper.prescribe("top", down).expect("support");
            touching([lower, upper], None)
        };
        for mut method in methods() {
            let certificate = run_with(&mut *method, &mut stiff(), 1, 1e-6).certificate();
            let certificate = certificate.expect("a step");
            assert!(
                failures(&certificate).is_empty(),
                "{pressed}: {certificate}"
            );
        }
        let weak: [Box<dyn Method>; 2] = [
            Box::new(PenalizedSlack::with(Continuation::fixed(1.0))),
            Box::new(Penalty::with(Continuation::fixed(1.0))),
        ];
        for mut method in weak {
            let certificate = run_with(&mut *method, &mut stiff(), 1, 1e-6).certificate();
            let found = failures(&certificate.expect("a step"));
            assert!(found.contains(&"weak_penetration"), "{pressed}: {found:?}");
        }
        let mut problem = stiff();
        let mut solution = run(&mut problem, 1, 1e-6).run.solution.expect("converged");
        let upper = problem.dofs().free() / 2;
        let moved = solution.state.u[upper..].iter_mut().skip(1).step_by(2);
        moved.for_each(|u| *u -= 0.1 * pressed);
        let found = failures(&Certificate::new(&problem, &solution));
        assert!(found.contains(&"weak_penetration"), "{pressed}: {found:?}");
    }
}

/// A pair beside one that is 1e8 times stiffer is judged by its own forces.
#[test]
fn a_soft_pair_is_judged_by_its_own_forces() {
    let mut scene = Scene::new();
    for (young, x) in [(1.0, 0.0), (1e8, 5.0)] {
        let aside = |mesh: Mesh<2>| mesh.translated([x, 0.0]).expect("mesh");
        let law = |mesh| elastic(young)(aside(mesh));
        let [lower, mut upper] = blocks([3, 4], [0.0, 1.0], law);
        let down = [Some(0.0), Some(-0.01)];
        upper.prescribe("top", down).expect("support");
        let lower = scene.add(format!("lower of {young}"), lower);
        let upper = scene.add(format!("upper of {young}"), upper);
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("surfaces");
    }
    let mut problem = scene.problem().expect("valid scene");
    let solution = run(&mut problem, 1, 1e-6).run.solution.expect("converged");
    let sound = Certificate::new(&problem, &solution);
    assert!(failures(&sound).is_empty(), "{sound}");
    let mut without = solution.clone();
    for (lambda, key) in without.lambda.iter_mut().zip(solution.gaps.keys()) {
        if key.pass < 2 {
            *lambda = 0.0;
        }
    }
    let found = failures(&Certificate::new(&problem, &without));
    assert!(found.contains(&"stationarity"), "{found:?}");
}

/// Exact integration leaves slivers of facets where the other surface all but ends: what is left of
/// penetration there is no more than elsewhere.
#[test]
fn slivers_are_no_false_alarm() {
    for half in [0.2499999, 0.249, 0.251] {
        for mut method in methods() {
            let [lower, _] = blocks([4, 3], [0.0, 1.0], elastic(10.0));
            let x = [0.5 - half, 0.5 + half];
            let [_, mut punch] = blocks([4, 3], x, elastic(1e3));
            let down = [Some(0.0), Some(-0.05)];
            punch.prescribe("top", down).expect("support");
            let mut problem = touching([lower, punch], Some(Integration::Exact));
            let certificate = run_with(&mut *method, &mut problem, 1, 1e-6).certificate();
            let certificate = certificate.expect("a step");
            assert!(failures(&certificate).is_empty(), "{half}: {certificate}");
        }
    }
}

/// Bodies that touch and carry nothing stay where they are, and that is the solution.
#[test]
fn rest_is_certified() {
    let neo_hookean = |mesh| Body::new(mesh, NeoHookean::new(1e3, 0.3).expect("law"));
    let laws: [&dyn Fn(Mesh<2>) -> Body<2>; 2] = [&elastic(1e3), &neo_hookean];
    for law in laws {
        let [lower, mut upper] = blocks([3, 4], [0.0, 1.0], law);
        upper.prescribe("top", [Some(0.0); 2]).expect("support");
        let mut problem = touching([lower, upper], None);
        let history = run(&mut problem, 1, 1e-6);
        assert_eq!(history.run.ending, Ending::Complete);
        let certificate = history.certificate().expect("a step");
        assert!(failures(&certificate).is_empty(), "{certificate}");
    }
}

/// Points that method (39) forgets, and passes, with both kinds of integration.
#[test]
fn forgotten_points_are_found() {
    for integration in [Integration::Gauss(4), Integration::Exact] {
        let mut scene =
            disc_in_disc::scene(Fineness::scaled(32), Roles::default()).expect("a scene");
        scene.integration = Some(integration);
        let mut problem = scene.problem().expect("valid scene");
        let history = run_with(&mut Penalty::default(), &mut problem, 16, 1e-6);
        let certificate = history.certificate().expect("steps");
        assert!(
            failures(&certificate).is_empty(),
            "{integration:?}: {certificate}"
        );
        let sound = history.run.solution.expect("converged");
        let every_other = |i: usize| (i % 2 == 0).then_some(1.0);
        let second = |i: usize| (sound.gaps.keys()[i].pass == 1).then_some(1.0);
        let keeps: [&dyn Fn(usize) -> Option<f64>; 2] = [&every_other, &second];
        for keep in keeps {
            let mut solution = sound.clone();
            let kept = |i: &usize| keep(*i).is_some();
            solution.gaps = rows(&sound.gaps, keep);
            solution.lambda = (0..sound.lambda.len())
                .filter(kept)
                .map(|i| sound.lambda[i])
                .collect();
            let found = failures(&Certificate::new(&problem, &solution));
            assert!(found.contains(&"closed"), "{integration:?}: {found:?}");
        }
    }
}

/// With the hole alone as slave, the disc's nodes go through between its nodes; both passes have no
/// other side.
#[test]
fn the_other_side_of_a_single_pass_is_told() {
    let other_side = |passes: Passes| {
        let mut problem = disc_in_disc(
            32,
            Roles {
                passes,
                ..Roles::default()
            },
        );
        let history = run(&mut problem, 8, 1e-6);
        let certificate = history.certificate().expect("steps");
        assert!(failures(&certificate).is_empty(), "{certificate}");
        certificate.left(Condition::OtherSide)
    };
    assert_eq!(other_side(Passes::Both), None);
    let depth = other_side(Passes::FirstIsSlave).expect("another side");
    assert!(
        depth > 10.0 * Limits::default().of(Condition::WeakPenetration),
        "{depth}"
    );
}
