//! Sideways motions under small strains, which contact at the reference positions does not follow.

use std::f64::consts::{PI, TAU};

use contact_fem::mesh::generators::{Diagonals, half_disc, linspace, rectangle};
use contact_fem::model::{Geometry, Passes};
use contact_fem::{Body, LinearElastic, Mesh, Scene, Simulation};

fn elastic(mesh: Mesh<2>) -> Body<2> {
    Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"))
}

/// A tool is pressed on a block by 0.02: half a disc, or a flat one. Both are moved sideways, by the first and the second of `ways`. Returns the force down, and the
/// ways and widths that are told.
fn pressed(
    tool: Mesh<2>,
    [held, touching]: [&str; 2],
    ways: [f64; 2],
    (geometry, passes): (Geometry, Passes),
) -> (f64, Vec<[f64; 2]>) {
    let mut tool = elastic(tool);
    tool.prescribe(held, [Some(ways[0]), Some(-0.02)])
        .expect("held");
    let ys = linspace(-2.0, -1.0, 20);
    let block = rectangle(&linspace(-1.0, 1.0, 41), &ys, Diagonals::Rising);
    let mut block = elastic(block.expect("a mesh"));
    block
        .prescribe("bottom", [Some(ways[1]), Some(0.0)])
        .expect("held");
    let mut scene = Scene::new();
    let tool = scene.add("tool", tool);
    let block = scene.add("block", block);
    scene
        .contact_in_passes(tool.on(touching), block.on("top"), passes)
        .expect("a pair");
    scene.geometry = Some(geometry);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(4).run(&mut problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let force = -history.steps[3].contact_force(block)[1];
    let solution = history.run.solution.expect("a solution");
    let found = problem.sideways(&solution);
    assert!(found.iter().all(|found| found.first.body == tool));
    (
        force,
        found.iter().map(|found| [found.way, found.width]).collect(),
    )
}

fn round(ways: [f64; 2], kind: (Geometry, Passes)) -> (f64, Vec<[f64; 2]>) {
    let disc = half_disc(
        &linspace(0.0, 1.0, 16),
        &linspace(PI, TAU, 64),
        Diagonals::Rising,
    )
    .expect("a mesh");
    pressed(disc, ["flat", "arc"], ways, kind)
}

/// Both passes hold a disc where it was and where it is: it is told, and the force is too large. One pass, or the current positions,
/// have the force of the disc that has not moved.
#[test]
fn a_disc_that_has_moved_is_told() {
    let both = (Geometry::Reference, Passes::Both);
    let (still, told) = round([0.0; 2], both);
    assert!(still > 0.0 && told.is_empty(), "{told:?}");
    let (moved, told) = round([0.05, 0.0], both);
    let [[way, width]] = told[..] else {
        panic!("{told:?}");
    };
    assert!(moved > 1.03 * still, "{moved} {still}");
    // the tool is moved as a whole, and drags nothing along; a is from 0.1 to 0.25
    assert!((way - 0.05).abs() < 0.01, "{way}");
    assert!((0.2..0.5).contains(&width), "{width}");
    let (current, told) = round([0.05, 0.0], (Geometry::Current, Passes::Both));
    assert!(
        told.is_empty() && (current / still - 1.0).abs() < 0.02,
        "{current} {still}"
    );
    let (once, told) = round([0.05, 0.0], (Geometry::Reference, Passes::FirstIsSlave));
    assert!(
        told.is_empty() && (once / still - 1.0).abs() < 0.02,
        "{once} {still}"
    );
}

/// Nothing is told of bodies that move together.
#[test]
fn bodies_that_move_together_are_not_told() {
    let both = (Geometry::Reference, Passes::Both);
    let ((still, _), (moved, told)) = (round([0.0; 2], both), round([0.05; 2], both));
    assert!(
        told.is_empty() && (moved / still - 1.0).abs() < 1e-9,
        "{told:?}"
    );
}

/// Flat surfaces slide on each other.
#[test]
fn a_flat_tool_that_has_moved_is_not_told() {
    let flat = rectangle(
        &linspace(-0.25, 0.25, 9),
        &linspace(-1.0, 0.0, 10),
        Diagonals::Rising,
    );
    let both = (Geometry::Reference, Passes::Both);
    let (force, told) = pressed(flat.expect("a mesh"), ["top", "bottom"], [0.05, 0.0], both);
    assert!(force > 0.0 && told.is_empty(), "{told:?}");
}
