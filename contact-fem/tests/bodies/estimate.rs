//! The estimated discretisation error against errors that formulas give.

use std::f64::consts::{PI, TAU};

use contact_core::equilibrium::Solution;
use contact_fem::mesh::generators::{Diagonals, cuboid, half_disc, linspace, rectangle};
use contact_fem::model::{ErrorEstimate, Problem};
use contact_fem::{Body, LinearElastic, Mesh, Obstacle, Scene};

use super::common::ended;

/// The solution in one increment, and its estimate.
fn run<const D: usize>(scene: Scene<D>) -> (Problem<D>, Solution, ErrorEstimate<D>) {
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 1);
    let solution = history.run.solution.expect("a solution");
    let estimate = problem.error_estimate(&solution).expect("an estimate");
    (problem, solution, estimate)
}

/// A column of height 2 and width or section 1, E = 1000, ν = 0, that stands under the weight 3 a volume: E u″ = 3, u(0) = u′(2) = 0,
/// and with the energy −(3²·2³)/(6·1000) = −0.012.
const ENERGY: f64 = -0.012;

fn column(cells: usize, quadratic: bool) -> Scene<2> {
    let (xs, ys) = (linspace(0.0, 1.0, cells), linspace(0.0, 2.0, 2 * cells));
    let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
    let mesh = if quadratic { mesh.quadratic() } else { mesh };
    let mut body = Body::new(mesh, LinearElastic::new(1000.0, 0.0).expect("a law"));
    body.prescribe("bottom", [None, Some(0.0)]).expect("held");
    body.prescribe("left", [Some(0.0), None]).expect("held");
    body.body_force([0.0, -3.0]).expect("a weight");
    let mut scene = Scene::new();
    scene.add("column", body);
    scene
}

#[test]
fn the_error_of_a_column_under_its_weight_is_known() {
    for cells in [2, 4, 8] {
        let (_, solution, estimate) = run(column(cells, false));
        let truth = solution.energy - ENERGY;
        let ratio = (estimate.energy / truth).sqrt();
        assert!((0.9..1.1).contains(&ratio), "{cells}: {ratio}");
        // 2 W of the exact solution is 0.024
        let relative = (truth / -ENERGY).sqrt();
        let ratio = estimate.relative / relative;
        assert!((0.9..1.1).contains(&ratio), "{cells}: {ratio}");
        let cells: f64 = estimate.cells.iter().map(|share| share * share).sum();
        assert!((cells.sqrt() / estimate.relative - 1.0).abs() < 1e-12);
        assert_eq!(estimate.bodies.len(), 1);
        assert!((estimate.bodies[0].energy / estimate.energy - 1.0).abs() < 1e-12);
    }
    // u is quadratic
    let (_, solution, estimate) = run(column(2, true));
    assert!((solution.energy - ENERGY).abs() < 1e-12 * -ENERGY);
    assert!(estimate.relative < 1e-9, "{:e}", estimate.relative);
}

#[test]
fn a_column_in_space_has_the_error_that_it_has() {
    let mesh = cuboid([0.0; 3], [1.0, 1.0, 2.0], [3, 3, 6]).expect("a mesh");
    let mut body = Body::new(mesh, LinearElastic::new(1000.0, 0.0).expect("a law"));
    body.prescribe("bottom", [None, None, Some(0.0)])
        .expect("held");
    body.prescribe("left", [Some(0.0), None, None])
        .expect("held");
    body.prescribe("front", [None, Some(0.0), None])
        .expect("held");
    body.body_force([0.0, 0.0, -3.0]).expect("a weight");
    let mut scene = Scene::new();
    scene.add("column", body);
    let (_, solution, estimate) = run(scene);
    let ratio = (estimate.energy / (solution.energy - ENERGY)).sqrt();
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
}

fn block(low: f64, cells: usize) -> Mesh<2> {
    let (xs, ys) = (linspace(0.0, 1.0, cells), linspace(low, low + 1.0, cells));
    rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
}

/// Two blocks that are squeezed have one stress, whatever their meshes.
#[test]
fn a_patch_has_no_error_and_needs_no_facets() {
    let law = |young| LinearElastic::new(young, 0.3).expect("a law");
    let mut lower = Body::new(block(0.0, 2), law(10.0));
    lower.prescribe("bottom", [None, Some(0.0)]).expect("held");
    lower.prescribe("left", [Some(0.0), None]).expect("held");
    let mut upper = Body::new(block(1.0, 3), law(20.0));
    upper
        .prescribe("top", [None, Some(-0.01)])
        .expect("pressed");
    upper.prescribe("left", [Some(0.0), None]).expect("held");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower);
    let upper = scene.add("upper", upper);
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    let (_, _, estimate) = run(scene);
    assert!(estimate.relative < 1e-8, "{:e}", estimate.relative);
    let contact = &estimate.contacts[0];
    assert_eq!((contact.touching, contact.is_inside), (Some(2), false));
    assert!(!contact.is_unresolved(2));
}

/// A half-disc on a plane, of few facets and of many.
#[test]
fn zones_of_few_facets_are_told() {
    let pressed = |around: usize| {
        let (radii, angles) = (linspace(0.0, 1.0, around / 4), linspace(PI, TAU, around));
        let mesh = half_disc(&radii, &angles, Diagonals::Rising).expect("a mesh");
        let mut disc = Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"));
        disc.prescribe("flat", [Some(0.0), Some(-0.01)])
            .expect("pressed");
        let mut scene = Scene::new();
        let arc = scene.add("disc", disc).on("arc");
        let plane = Obstacle::half_space([0.0, -1.0], [0.0, 1.0]).expect("a plane");
        scene.obstacle("plane", arc, plane).expect("an obstacle");
        run(scene).2
    };
    let (coarse, fine) = (pressed(16), pressed(160));
    // facets of .2 are wider than half the zone
    assert!(coarse.contacts[0].touching.is_some_and(|count| count < 4));
    assert!(coarse.contacts[0].is_inside && coarse.contacts[0].is_unresolved(2));
    // a = √(4 P R/(π E*)) with P of about 1: .11, which is 6 facets of .02 on either side
    let touching = fine.contacts[0].touching.expect("a force");
    assert!((6..=14).contains(&touching), "{touching}");
    assert!(!fine.contacts[0].is_unresolved(2));
    assert!(fine.relative < 0.5 * coarse.relative);
    let place = fine.bodies[0].place;
    assert!(place[1] < -0.9 || place[1] > -0.1, "{place:?}");
}

#[test]
fn solutions_of_other_problems_are_refused() {
    let (_, solution, _) = run(column(2, false));
    let other = column(3, false).problem().expect("a problem");
    let refused = other.error_estimate(&solution).expect_err("another one");
    assert!(refused.to_string().contains('u'), "{refused}");
}

/// Nothing is strained before the first load step.
#[test]
fn rest_has_no_error() {
    let mut scene = Scene::new();
    let mut body = Body::new(block(0.0, 2), LinearElastic::new(1.0, 0.3).expect("a law"));
    body.prescribe("bottom", [Some(0.0); 2]).expect("held");
    body.prescribe("top", [Some(0.0); 2]).expect("held");
    scene.add("block", body);
    let (_, _, estimate) = run(scene);
    assert_eq!((estimate.relative, estimate.energy), (0.0, 0.0));
    assert_eq!(estimate.contacts, []);
}
