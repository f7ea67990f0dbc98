//! Motions under small strains that contact at the reference positions does not follow.

use std::f64::consts::{PI, TAU};

use contact_fem::mesh::generators::{Diagonals, half_disc, linspace, rectangle};
use contact_fem::model::{Geometry, Passes};
use contact_fem::{Body, LinearElastic, Mesh, Motion, Obstacle, Scene, Simulation};

/// What is told of a pair: error and indentation.
type Told = Vec<[f64; 2]>;

fn elastic(mesh: Mesh<2>) -> Body<2> {
    Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"))
}

/// The force down on the body that stays, and what is told.
fn run(scene: Scene<2>, geometry: Geometry) -> (f64, Told) {
    let mut scene = scene;
    scene.geometry = Some(geometry);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(4).run(&mut problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let force = history.steps[3].pairs[0].resultant[1];
    let solution = history.run.solution.expect("a solution");
    let found = problem.geometric_errors(&solution);
    let told = found.iter().map(|found| [found.error, found.indentation]);
    (force, told.collect())
}

fn block(cells: usize) -> Body<2> {
    let (xs, ys) = (linspace(-1.0, 1.0, cells), linspace(-2.0, -1.0, 20));
    elastic(rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh"))
}

/// Half a disc of radius 1, whose lowest point is at (0, −1).
fn disc() -> Body<2> {
    let (radii, angles) = (linspace(0.0, 1.0, 20), linspace(PI, TAU, 80));
    elastic(half_disc(&radii, &angles, Diagonals::Rising).expect("a mesh"))
}

/// A tool is pressed on a block by 0.02. Both are moved sideways, by the first and the second of `ways`.
fn pressed(
    (mut tool, held, touching): (Body<2>, &str, &str),
    cells: usize,
    ways: [f64; 2],
    (geometry, passes): (Geometry, Passes),
) -> (f64, Told) {
    tool.prescribe(held, [Some(ways[0]), Some(-0.02)])
        .expect("held");
    let mut block = block(cells);
    block
        .prescribe("bottom", [Some(ways[1]), Some(0.0)])
        .expect("held");
    let mut scene = Scene::new();
    let tool = scene.add("tool", tool);
    let block = scene.add("block", block);
    scene
        .contact_in_passes(tool.on(touching), block.on("top"), passes)
        .expect("a pair");
    run(scene, geometry)
}

fn round(ways: [f64; 2], kind: (Geometry, Passes)) -> (f64, Told) {
    pressed((disc(), "flat", "arc"), 61, ways, kind)
}

const BOTH: (Geometry, Passes) = (Geometry::Reference, Passes::Both);

/// A disc that moves far over a block without being lifted keeps its force at the present positions, and has several times as much at the
/// reference positions: gaps differ by more than the half of the indentation.
#[test]
fn a_force_that_is_a_multiple_is_told() {
    let (present, _) = round([0.4, 0.0], (Geometry::Current, Passes::Both));
    let (force, told) = round([0.4, 0.0], BOTH);
    assert!(force > 2.0 * present, "{force} {present}");
    let [[error, indentation]] = told[..] else {
        panic!("{told:?}");
    };
    assert!(error > 0.5 * indentation, "{told:?}");
}

/// Both passes hold a disc where it was and where it is: the force is too large, by about twice the share that is told. With the flat block
/// as the only slave it is too large, too. With the disc as the only slave it is that of the disc that has not moved, and so is the place.
#[test]
fn a_disc_that_has_moved_is_told() {
    let (still, told) = round([0.0; 2], BOTH);
    assert!(still > 0.0 && told.is_empty(), "{told:?}");
    let (moved, told) = round([0.05, 0.0], BOTH);
    let [[error, indentation]] = told[..] else {
        panic!("{told:?}");
    };
    let (share, excess) = (error / indentation, moved / still - 1.0);
    assert!(excess > 0.03, "{excess}");
    assert!((share..3.0 * share).contains(&excess), "{share} {excess}");
    let (current, told) = round([0.05, 0.0], (Geometry::Current, Passes::Both));
    let change = current / still - 1.0;
    assert!(told.is_empty() && change.abs() < 0.02, "{change}");
    let (by_block, told) = round([0.1, 0.0], (Geometry::Reference, Passes::SecondIsSlave));
    let change = by_block / still - 1.0;
    assert!(told.len() == 1 && change > 0.1, "{change} {told:?}");
    let (by_disc, told) = round([0.1, 0.0], (Geometry::Reference, Passes::FirstIsSlave));
    let change = by_disc / still - 1.0;
    assert!(told.len() == 1 && change.abs() < 0.02, "{change} {told:?}");
}

/// Where rows of the coarse flat surface do not act, nothing is wrong.
#[test]
fn rows_that_do_not_act_do_not_count() {
    let coarse = |way: f64| pressed((disc(), "flat", "arc"), 3, [way, 0.0], BOTH);
    let ((still, _), (moved, told)) = (coarse(0.0), coarse(0.05));
    let change = moved / still - 1.0;
    assert!(change.abs() < 0.02 && told.is_empty(), "{change} {told:?}");
}

#[test]
fn bodies_that_move_together_are_not_told() {
    let ((still, _), (moved, told)) = (round([0.0; 2], BOTH), round([0.05; 2], BOTH));
    assert!(told.is_empty() && (moved / still - 1.0).abs() < 1e-9);
}

/// Flat surfaces keep their gaps. A tool of width 0.5 that has moved by a tenth of it presses on as much of the block that it has left.
#[test]
fn a_flat_tool_is_told_by_what_it_has_left() {
    let (xs, ys) = (linspace(-0.25, 0.25, 9), linspace(-1.0, 0.0, 10));
    let moved = |way: f64| {
        let tool = elastic(rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh"));
        // nodes of the block at multiples of 1/30
        pressed((tool, "top", "bottom"), 60, [way, 0.0], BOTH)
    };
    let (force, told) = moved(0.01);
    assert!(force > 0.0 && told.is_empty(), "{told:?}");
    let (_, told) = moved(0.05);
    let [[error, indentation]] = told[..] else {
        panic!("{told:?}");
    };
    let share = error / indentation;
    assert!((0.05..0.2).contains(&share), "{share}");
}

/// Two blocks of one width, pressed together uniformly: each becomes wider by ν(1 + ν)p/E of its width, the softer one more. What is beyond
/// the end of the other is this share of the surface, not the whole area of the last node.
#[test]
fn a_uniform_patch_that_becomes_wider_is_not_told() {
    for (cells, stiffness) in [([8, 9], 1.0), ([5, 5], 1.0), ([5, 7], 3.0)] {
        let block = |n: usize, low: f64, young: f64| {
            let (xs, ys) = (linspace(0.0, 1.0, n), linspace(low, low + 1.0, n));
            let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
            let mut block = Body::new(mesh, LinearElastic::new(young, 0.3).expect("a law"));
            block
                .prescribe("left", [Some(0.0), None])
                .expect("a support");
            block
        };
        let (mut lower, mut upper) = (
            block(cells[0], 0.0, 100.0),
            block(cells[1], 1.0, 100.0 * stiffness),
        );
        lower.prescribe("bottom", [None, Some(0.0)]).expect("held");
        upper.prescribe("top", [None, Some(-0.02)]).expect("held");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", upper);
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("a pair");
        let (force, told) = run(scene, Geometry::Reference);
        // plane strain, springs in series
        let expected = 100.0 / 0.91 * 0.02 / (1.0 + 1.0 / stiffness);
        assert!((force.abs() / expected - 1.0).abs() < 0.01, "{force}");
        assert!(told.is_empty(), "{cells:?}: {told:?}");
    }
}

/// The block ends at 1: most of the tool has slid beyond, and what it presses there in the reference is not opposite any more.
#[test]
fn a_flat_tool_that_slides_off_is_told() {
    let (xs, ys) = (linspace(0.4, 0.9, 9), linspace(-1.0, 0.0, 10));
    let tool = elastic(rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh"));
    let (force, told) = pressed((tool, "top", "bottom"), 61, [0.5, 0.0], BOTH);
    let [[error, indentation]] = told[..] else {
        panic!("{told:?}");
    };
    assert!(
        force > 0.0 && error > 0.3 * indentation,
        "{error} {indentation}"
    );
}

/// A disc on a fixed ball: moved sideways as a body it is told, and where the ball is moved as an obstacle it is followed.
#[test]
fn a_curved_obstacle_is_told_where_the_body_moves() {
    let on_ball = |body: f64, ball: f64| {
        let mut disc = disc();
        disc.prescribe("flat", [Some(body), Some(-0.02)])
            .expect("held");
        let mut scene = Scene::new();
        let disc = scene.add("disc", disc);
        let way = Motion::<2>::translation([ball, 0.0]).expect("a motion");
        let shape = Obstacle::ball([0.0, -2.0], 1.0).expect("a ball");
        scene
            .obstacle("ball", disc.on("arc"), shape.moving(way))
            .expect("an obstacle");
        let (force, told) = run(scene, Geometry::Reference);
        (force.abs(), told)
    };
    let (still, told) = on_ball(0.0, 0.0);
    assert!(told.is_empty(), "{told:?}");
    // both are apart by way²/4R more, and the force is less
    let (moved, told) = on_ball(0.1, 0.0);
    assert!(told.len() == 1 && moved > still, "{moved} {still} {told:?}");
    let (followed, told) = on_ball(0.0, -0.1);
    assert!(
        told.is_empty() && followed < 0.95 * still,
        "{followed} {told:?}"
    );
}

/// The ways of two feet of one tool cancel in the mean, and each zone is told by itself.
#[test]
fn zones_are_told_by_themselves() {
    let spread = |way: f64| {
        let (xs, ys) = (linspace(-0.7, 0.7, 80), linspace(-1.0, 0.0, 4));
        let plate = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
        // feet with radii of 0.5
        let feet = plate.mapped(|x| [x[0], x[1] - x[1] * (x[0].abs() - 0.35).powi(2)].into());
        let feet = feet.expect("feet");
        let right = |a: &usize| feet.nodes()[*a][0] >= 0.0;
        let (right, left): (Vec<_>, Vec<_>) = (0..feet.nodes().len()).partition(right);
        let mut tool = elastic(feet);
        for (nodes, way) in [(left, -way), (right, way)] {
            tool.prescribe_nodes(&nodes, [Some(way), Some(-0.02)])
                .expect("held");
        }
        let mut block = block(81);
        block.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        let tool = scene.add("tool", tool);
        let block = scene.add("block", block);
        scene
            .contact(tool.on("bottom"), block.on("top"))
            .expect("a pair");
        run(scene, Geometry::Reference)
    };
    let ((still, told), (moved, spread)) = (spread(0.0), spread(0.05));
    assert!(told.is_empty(), "{told:?}");
    let excess = moved / still - 1.0;
    assert!(excess > 0.03 && spread.len() == 1, "{excess} {spread:?}");
}
