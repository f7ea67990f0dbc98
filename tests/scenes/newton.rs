//! Newton's method with condensed contact, against the paper's algorithm, exact values and the certificate.

use crate::common::{disc_in_disc, relative};
use contact_core::{CondensedNewton, InteriorPoint, Retry};
use contact_fem::certificate::Limits;
use contact_fem::element::Order;
use contact_fem::model::{Integration, Problem, Projection};
use contact_fem::simulation::History;
use contact_fem::{Scene, Simulation};
use ipopt_contact_scenes::beams::{Beams, LENGTH, LOAD, Law, SIDE};
use ipopt_contact_scenes::cli::Solver;
use ipopt_contact_scenes::die::Die;
use ipopt_contact_scenes::disc_in_disc::{
    self as discs, DEFAULT_END, ENDS, EXACT_END, Fineness, Roles,
};
use ipopt_contact_scenes::freefem::cases::{Case, Size};
use ipopt_contact_scenes::freefem::reference::Reference;
use ipopt_contact_scenes::{arch, extremes, hairpin, tight};

/// Full load in `increments` that are not cut, under a tight certificate.
fn newton<const D: usize>(problem: &mut Problem<D>, increments: usize) -> History<D> {
    let solver = CondensedNewton::default();
    let history = Simulation::solved_by(solver, increments).run(problem);
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    assert_eq!(history.run.cuts(), 0);
    assert_eq!(history.steps.len(), increments);
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    history
}

/// The paper's algorithm around Ipopt, to a tight tolerance.
fn reference<const D: usize>(scene: Scene<D>, increments: usize) -> History<D> {
    let method = InteriorPoint {
        complementarity: 1e-12,
        ..InteriorPoint::default()
    };
    let mut solver = Retry::with(method);
    solver.fixed_point.tolerance = 1e-9;
    let mut problem = scene.problem().expect("valid scene");
    let history = Simulation::solved_by(solver, increments).run(&mut problem);
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    history
}

fn energy<const D: usize>(history: &History<D>) -> f64 {
    history.last().expect("steps").energy
}

/// Newton's method finds the energy of the paper's algorithm, and its forces on every body.
fn compare<const D: usize>(
    scene: impl Fn() -> Scene<D>,
    increments: usize,
    of_reference: usize,
) -> History<D> {
    let found = newton(&mut scene().problem().expect("valid scene"), increments);
    let expected = reference(scene(), of_reference);
    let energies = [&found, &expected].map(energy);
    assert!(relative(energies[0], energies[1]) < 1e-7, "{energies:?}");
    let forces = [&found, &expected].map(|h| h.last().expect("steps").contact_forces.clone());
    for (a, b) in forces[0].iter().zip(&forces[1]) {
        assert!((a - b).norm() < 1e-5 * b.norm().max(1e-3), "{a} for {b}");
    }
    found
}

/// The end that FreeFEM's script reached in 100 increments, from few: it does not depend on their number.
#[test]
fn disc_in_disc_in_few_increments() {
    let case = Case::named("disc_in_disc").expect("a scene");
    let theirs = Reference::read(case, Size::Small)
        .expect("readable")
        .expect("stored")
        .outcome(case);
    let (expected_energy, expected_force) = (theirs.value("energy"), theirs.value("reaction_y"));
    for increments in [20, 5] {
        let roles = Roles::default();
        let history = newton(&mut disc_in_disc(64, roles), increments);
        let last = history.last().expect("steps");
        let force = last.reaction(roles.ring())[1];
        assert!(
            (last.energy - expected_energy).abs() < 1e-7,
            "{increments}: {}",
            last.energy
        );
        assert!(
            (force - expected_force).abs() < 1e-5,
            "{increments}: {force}"
        );
        let balance = last.reactions[0] + last.reactions[1];
        assert!(balance.norm() < 1e-7 * force, "{balance}");
    }
}

#[test]
fn disc_in_disc_with_either_pass_alone() {
    for (passes, end) in &ENDS[1..] {
        let roles = Roles {
            passes: *passes,
            ..Roles::default()
        };
        let history = newton(&mut disc_in_disc(64, roles), 20);
        let last = history.last().expect("steps");
        let force = last.reaction(roles.ring())[1];
        // to the last digit that is known: both have two decimals at least
        assert!(
            (last.energy - end.energy).abs() < 0.01,
            "{passes:?}: {}",
            last.energy
        );
        assert!((force - end.force).abs() < 0.01, "{passes:?}: {force}");
    }
}

#[test]
fn exact_integration() {
    let scene = |fineness| {
        let mut scene = discs::scene(fineness, Roles::default()).expect("a scene");
        scene.integration = Some(Integration::Exact);
        scene.projection = Projection::Closest;
        scene
    };
    compare(|| scene(Fineness::scaled(24)), 20, 20);
    let mut problem = scene(Fineness::REFERENCE).problem().expect("valid scene");
    let history = newton(&mut problem, 20);
    assert!((energy(&history) - EXACT_END.energy).abs() < 1e-4);
}

/// With default settings, whichever body comes first.
#[test]
fn disc_in_disc_with_default_settings() {
    let ends = [false, true].map(|swapped| {
        let roles = Roles {
            swapped,
            ..Roles::default()
        };
        let scene = discs::scene(Fineness::REFERENCE, roles).expect("a scene");
        let history = newton(&mut scene.problem().expect("valid scene"), 20);
        let last = history.last().expect("steps");
        let found = [last.energy, last.reaction(roles.ring())[1]];
        assert!((found[0] - DEFAULT_END.energy).abs() < 1e-4, "{found:?}");
        assert!((found[1] - DEFAULT_END.force).abs() < 1e-3, "{found:?}");
        found
    });
    let apart = (0..2).map(|k| relative(ends[0][k], ends[1][k]));
    assert!(apart.fold(0.0, f64::max) < 1e-12, "{ends:?}");
}

/// Exact rows along normals are solved as the paper's algorithm around Ipopt solves them.
#[test]
fn default_settings_as_the_fixed_point_has_them() {
    let scene = || discs::scene(Fineness::scaled(24), Roles::default()).expect("a scene");
    compare(scene, 20, 20);
}

/// Meshes of which each has a load without an equilibrium where feet are the closest points of Gauss points.
#[test]
fn meshes_on_which_closest_points_fail() {
    for segments in [28, 36, 38, 50] {
        let scene = discs::scene(Fineness::scaled(segments), Roles::default()).expect("a scene");
        let mut problem = scene.problem().expect("valid scene");
        let history = Simulation::with_increments(100).run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete(), "{segments}: {}", history.run.ending);
        assert_eq!(history.run.cuts(), 0, "{segments}");
        let certificate = history.certificate().expect("steps");
        assert!(
            certificate.holds(&Limits::default()),
            "{segments}: {certificate}"
        );
        let cost = history.run.cost();
        assert!(cost.outer_iterations <= 500, "{segments}: {cost:?}");
        assert!(cost.factorizations <= 600, "{segments}: {cost:?}");
    }
}

/// On fine meshes, an increment of a sixth of the hole's radius ends where rows of both bodies nearly depend on each other and steps leave
/// gaps. It is over before the iteration is given up, which is after thirty steps, and started anew.
#[test]
fn fine_discs_in_few_increments() {
    for segments in [178, 180] {
        let scene = discs::scene(Fineness::scaled(segments), Roles::default()).expect("a scene");
        let mut problem = scene.problem().expect("valid scene");
        let history = Simulation::solved_by(CondensedNewton::default(), 5).run(&mut problem);
        let history = history.expect("no misuse");
        assert!(history.is_complete(), "{}", history.run.ending);
        let certificate = history.certificate().expect("steps");
        assert!(certificate.holds(&Limits::default()), "{certificate}");
        for attempt in &history.run.attempts {
            let iterations = attempt.cost.outer_iterations;
            assert!(
                iterations < 30,
                "{segments} segments, at {}: {iterations}",
                attempt.to
            );
        }
    }
}

/// The side of the die lies flat on facets of the slab, so that rows of both nearly depend on each other, and its corners are in the middle of
/// facets, whose rows vary with what is opposite the die.
#[test]
fn a_sharp_die_on_a_slab() {
    for order in [Order::Linear, Order::Quadratic] {
        let die = Die {
            order,
            slab: [6, 3],
            die: [5, 2],
            from: 0.9,
            width: 1.2,
            young: 1000.0,
            press: 0.05,
            slide: 0.0,
        };
        compare(|| die.scene().expect("valid"), 2, 2);
    }
}

#[test]
fn a_hairpin_touches_itself() {
    let history = compare(|| hairpin::scene(2, true).expect("a scene"), 10, 10);
    let solution = history.run.solution.as_ref().expect("converged");
    let total: f64 = solution.lambda.iter().sum();
    assert!(total > 1e-3, "the arms press on each other: {total}");
}

#[test]
fn an_arch_on_a_foundation() {
    compare(|| arch::scene(2).expect("a scene"), 1, 1);
}

#[test]
fn beams_in_one_increment() {
    let beams = Beams::new(1, Order::Quadratic, Law::NeoHookean);
    let history = compare(|| beams.scene().expect("a scene"), 1, 10);
    let up: f64 = history
        .last()
        .expect("steps")
        .reactions
        .iter()
        .map(|r| r[2])
        .sum();
    assert!(relative(up, LOAD * LENGTH * SIDE) < 1e-8, "{up}");
}

#[test]
fn scenes_at_the_limits() {
    let cases = extremes::all();
    for name in [
        "elastic disc in a ring, E ratio 1e0, 40 segments, 20 increments",
        "1 neo-hookean blocks at rest, weight 1e0",
        "3 neo-hookean blocks at rest, weight 1e0",
        "1 linear blocks at rest, weight 1e-3",
        "stack compressed to 0.5, 1 increments",
        "stack compressed to 0.5, 10 increments",
    ] {
        let case = cases.iter().find(|case| case.name == name);
        let entry = case.expect(name).run(Solver::Newton);
        println!("{name}: {} s", entry.seconds);
        assert!(entry.truth_ok && entry.certificate, "{entry:?}");
    }
}

#[test]
fn two_runs_give_the_same_bits() {
    let run = || {
        let history = newton(&mut disc_in_disc(24, Roles::default()), 5);
        let solution = history.run.solution.as_ref().expect("converged");
        let values = solution.state.u.iter().chain(&solution.lambda);
        let bits: Vec<u64> = values.map(|v| v.to_bits()).collect();
        (bits, history.run.cost().outer_iterations)
    };
    assert_eq!(run(), run());
}
