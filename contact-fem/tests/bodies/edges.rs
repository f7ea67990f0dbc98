//! Bodies in space that meet edge on edge.

use contact_core::Outcome;
use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::cuboid;
use contact_fem::model::{Corners, Problem};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Body, Mesh, NeoHookean, Scene, Simulation};

use crate::common::ended;

/// A square bar of length 4 and side ½. Its ridge is on top and along x, at a height, and has `cells` edges. The bar is turned about z, and turned upside down if
/// `is_above`.
fn ridge(cells: usize, (turn, height, is_above): (f64, f64, bool)) -> Mesh<3> {
    let mut mesh = cuboid([-2.0, 0.0, -0.5], [4.0, 0.5, 0.5], [cells, 2, 2]).expect("a mesh");
    mesh.name_boundary("all", |_| true);
    mesh.name_boundary("ends", |x| x[0].abs() == 2.0);
    let half = 0.5_f64.sqrt();
    let placed = move |x: &Vector<3>| {
        // the edge y = z = 0 of the box is the ridge
        let (mut y, mut z) = ((x[1] + x[2]) * half, (x[2] - x[1]) * half);
        if is_above {
            (y, z) = (-y, -z);
        }
        let (sin, cos) = turn.sin_cos();
        Vector::<3>::new(x[0] * cos - y * sin, x[0] * sin + y * cos, z + height)
    };
    mesh.mapped(placed).expect("a mesh")
}

/// How high the facets beside the ridge are over it.
const HEIGHT: f64 = 0.25;
/// How far ridges are apart at rest.
const GAP: f64 = 0.1;

fn bar(mesh: Mesh<3>, way: f64) -> Body<3> {
    let mut body = Body::new(mesh, NeoHookean::new(1e3, 0.3).expect("a law"));
    body.prescribe("ends", [Some(0.0), Some(0.0), Some(way)])
        .expect("a boundary");
    body
}

/// Two bars of so many cells that cross at an angle. The ends of the upper one are pushed down by `way`.
fn crossed(
    (cells, turn, way): ([usize; 2], f64, f64),
    is_quadratic: bool,
    corners: Corners,
) -> Problem<3> {
    let lower = ridge(cells[0], (0.3, 0.0, false));
    let upper = ridge(cells[1], (0.3 + turn, GAP, true));
    let mut scene = Scene::new();
    let [lower, upper] =
        [("lower", lower, 0.0), ("upper", upper, -way)].map(|(name, mesh, way)| {
            let mesh = if is_quadratic { mesh.quadratic() } else { mesh };
            scene.add(name, bar(mesh, way)).on("all")
        });
    scene.contact(lower, upper).expect("a pair");
    scene.corners = corners;
    scene.problem().expect("a problem")
}

/// The force on the upper bar at the end.
fn force(history: &History<3>) -> f64 {
    history.last().expect("a step").contact_forces[1][2]
}

/// Bars that cross in the middle are two springs in a row: each bends by half of the way that is left, with the force of a single bar whose ridge is
/// pushed down there at one node.
#[test]
fn ridges_that_cross_bend_as_two_springs() {
    let way = 0.16;
    let history = ended(&mut crossed(([4, 4], 1.2, way), false, Corners::Held), 8);
    let mesh = ridge(4, (0.0, 0.0, false));
    let is_middle = |x: &Vector<3>| x.norm() < 1e-12;
    let middle = mesh.nodes().iter().position(is_middle).expect("a node");
    let mut single = bar(mesh, 0.0);
    // by a fortieth of this height, which is less than the lengths of facets, edges may dig in
    let bent = 0.5 * (way - GAP - HEIGHT / 40.0);
    single
        .prescribe_nodes(&[middle], [None, None, Some(-bent)])
        .expect("a node");
    let mut scene = Scene::new();
    scene.add("bar", single);
    let ended = ended(&mut scene.problem().expect("a problem"), 8);
    let energy = |history: &History<3>| history.last().expect("a step").energy;
    let [two, one] = [energy(&history), energy(&ended)];
    println!("two bars store {two}, one bar {one}");
    assert!((two - 2.0 * one).abs() < 0.01 * two, "{two} {one}");
    assert!(force(&history) > 0.0);
}

/// Ridges that cross between nodes and at nodes: without rows of their edges they cut into each other, and the run ends or is not certified. By default the rows
/// are added, once, where that is found, and the end is the one with these rows from the start.
#[test]
fn rows_of_edges_are_added_where_they_are_needed() {
    for (cells, turn, is_quadratic) in [
        ([4, 4], 0.8, false),
        ([3, 5], 1.1, false),
        ([2, 3], -0.7, false),
        ([2, 2], 1.4, true),
    ] {
        let scene = (cells, turn, 0.26);
        let run = |corners| {
            let mut problem = crossed(scene, is_quadratic, corners);
            Simulation::with_increments(6)
                .run(&mut problem)
                .expect("no misuse")
        };
        let weak = run(Corners::Weak);
        let certificate = weak.certificate().expect("steps");
        assert!(
            !(weak.is_complete() && certificate.holds(&Limits::default())),
            "{cells:?}"
        );
        let held = ended(&mut crossed(scene, is_quadratic, Corners::Held), 6);
        let added = ended(&mut crossed(scene, is_quadratic, Corners::AsNeeded), 6);
        let failed = added
            .run
            .attempts
            .iter()
            .flat_map(|attempt| &attempt.failed);
        let is_added = |outcome: &Outcome| matches!(outcome, Outcome::Unplanned(what) if what.contains("edges"));
        assert_eq!(failed.filter(|failed| is_added(&failed.outcome)).count(), 1);
        let [held, added] =
            [&held, &added].map(|history| (force(history), history.last().expect("a step").energy));
        assert!(
            (held.0 - added.0).abs() < 1e-6 * held.0,
            "{held:?} {added:?}"
        );
        assert!(
            (held.1 - added.1).abs() < 1e-6 * held.1,
            "{held:?} {added:?}"
        );
    }
}
