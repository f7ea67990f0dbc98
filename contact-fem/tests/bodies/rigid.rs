//! Rigid bodies: tools under forces, on springs and in guides, against statics, theory and tools that are driven.
#![allow(non_snake_case)]

use std::f64::consts::PI;

use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, quarter_disc, rectangle};
use contact_fem::model::Geometry;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, Material, Mesh, Motion, NeoHookean, Obstacle, Scene,
    StepRecord,
};

use crate::common::ended;

fn block([x, y]: [f64; 2], [width, height]: [f64; 2], [nx, ny]: [usize; 2]) -> Mesh<2> {
    let xs = linspace(x, x + width, nx);
    rectangle(&xs, &linspace(y, y + height, ny), Diagonals::Alternating).expect("a mesh")
}

/// A block of 2 by 1 on a symmetry plane, and a plate of some width in a guide, `gap` above it.
fn pressed(
    law: impl Material<2>,
    load: impl Fn(&mut Body<2>),
    gap: f64,
    quadratic: bool,
) -> Scene<2> {
    let of_order = |mesh: Mesh<2>| if quadratic { mesh.quadratic() } else { mesh };
    let mut below = Body::new(of_order(block([0.0, 0.0], [2.0, 1.0], [12, 6])), law);
    below.symmetry("bottom").expect("a support");
    below.symmetry("left").expect("a support");
    let mut plate = Body::rigid(of_order(block([-0.1, 1.0 + gap], [2.5, 0.3], [7, 1])));
    load(&mut plate);
    let mut scene = Scene::new();
    let (below, plate) = (scene.add("below", below), scene.add("plate", plate));
    scene
        .contact(below.on("top"), plate.on("bottom"))
        .expect("a pair");
    scene
}

fn last(history: &History<2>) -> &StepRecord<2> {
    history.last().expect("a step")
}

/// A force takes a plate where, driven, it has this force as reaction; through a gap, at small and at large strains.
#[test]
fn a_force_does_what_its_displacement_does() {
    for (gap, quadratic) in [(0.0, false), (0.05, false), (0.02, true)] {
        for large in [false, true] {
            let run = |load: &dyn Fn(&mut Body<2>)| {
                let scene = match large {
                    true => pressed(
                        NeoHookean::new(100.0, 0.3).expect("a law"),
                        load,
                        gap,
                        quadratic,
                    ),
                    false => pressed(
                        LinearElastic::new(100.0, 0.3).expect("a law"),
                        load,
                        gap,
                        quadratic,
                    ),
                };
                ended(&mut scene.problem().expect("a problem"), 3)
            };
            let by_force = run(&|plate| {
                plate
                    .prescribe("right", [Some(0.0), None])
                    .expect("a guide");
                plate.traction("top", [0.0, -12.0]).expect("a load");
            });
            let record = last(&by_force);
            let [motion] = &record.rigid_motions[..] else {
                panic!("one rigid body")
            };
            let way = motion.displacement;
            assert!(way[0].abs() < 1e-14 && motion.rotation.is_empty());
            let by_way = run(&|plate| {
                plate
                    .prescribe_all([Some(0.0), Some(way[1])])
                    .expect("a support");
            });
            let reaction = last(&by_way).reactions[1];
            let force = 12.0 * 2.5;
            assert!(
                (reaction[1] + force).abs() < 1e-6 * force,
                "{large} {gap}: {reaction}"
            );
            let [own, other] = [&by_force, &by_way].map(|history| last(history).stored_energy);
            assert!(
                (own - other).abs() < 1e-6 * other,
                "{large} {gap}: {own} {other}"
            );
            if !large {
                // plane strain, σ_x = 0: σ = E' ε with E' = E/(1 − ν²)
                let exact = gap + force / 2.0 * 0.91 / 100.0;
                assert!((way[1] + exact).abs() < 1e-7, "{} {exact}", way[1]);
            }
            // the guide takes nothing, and the work of the force is stored
            assert!(record.reactions[1].norm() < 1e-8, "{}", record.reactions[1]);
            assert!((record.contact_forces[1][1] - force).abs() < 1e-8 * force);
        }
    }
}

/// A plate comes down on a block and then on a rigid stop, which takes the rest of the force; and two rigid plates, one on springs, press each other.
#[test]
fn rigid_bodies_meet_what_is_rigid() {
    for large in [false, true] {
        let guide = |plate: &mut Body<2>| {
            plate
                .prescribe("right", [Some(0.0), None])
                .expect("a guide");
            plate.traction("top", [0.0, -12.0]).expect("a load");
        };
        let mut scene = match large {
            true => pressed(
                NeoHookean::new(100.0, 0.0).expect("a law"),
                guide,
                0.0,
                false,
            ),
            false => pressed(
                LinearElastic::new(100.0, 0.0).expect("a law"),
                guide,
                0.0,
                false,
            ),
        };
        let plate = scene.ids().nth(1).expect("the plate");
        let stop = Obstacle::half_space([0.0, 0.99], [0.0, 1.0]).expect("a stop");
        let stop = scene
            .obstacle("stop", plate.on("bottom"), stop)
            .expect("held");
        let history = ended(&mut scene.problem().expect("a problem"), 2);
        let record = last(&history);
        let way = record.rigid_motions[0].displacement[1];
        assert!((way + 0.01).abs() < 1e-8, "{way}");
        let (on_block, on_stop) = (
            -record.contact_forces[0][1],
            -record.obstacle_force(stop)[1],
        );
        assert!(
            (on_block + on_stop - 30.0).abs() < 1e-6,
            "{on_block} {on_stop}"
        );
        // σ = E ε, and at large strains a little more
        assert!(
            (on_block - 2.0).abs() < if large { 0.05 } else { 1e-6 },
            "{on_block}"
        );
    }
    let law = LinearElastic::new(100.0, 0.0).expect("a law");
    let mut scene = pressed(
        law,
        |plate| {
            plate
                .prescribe("right", [Some(0.0), None])
                .expect("a guide");
        },
        0.0,
        false,
    );
    let plate = scene.ids().nth(1).expect("the plate");
    let mut weight = Body::rigid(block([0.5, 1.3], [1.0, 0.5], [3, 2]));
    weight
        .prescribe("right", [Some(0.0), None])
        .expect("a guide");
    weight.body_force([0.0, -8.0]).expect("a load");
    let weight = scene.add("weight", weight);
    scene
        .contact(plate.on("top"), weight.on("bottom"))
        .expect("a pair");
    let history = ended(&mut scene.problem().expect("a problem"), 1);
    let record = last(&history);
    for motion in &record.rigid_motions {
        assert!(
            (motion.displacement[1] + 4.0 / 200.0).abs() < 1e-8,
            "{motion:?}"
        );
    }
    assert!((record.contact_forces[2][1] - 4.0).abs() < 1e-8);
}

/// A path of one node is that of the whole body; one that turns is refused.
#[test]
fn a_motion_drives_the_whole_body() {
    let law = LinearElastic::new(100.0, 0.0).expect("a law");
    let scene = pressed(
        law,
        |plate| {
            let node = plate.mesh().nodes_at(&[[-0.1, 1.0]]).expect("a corner");
            let along = Motion::translation([0.0, -0.02]).expect("a way");
            let along = along.driven_by(Amplitude::of(|t| t * t));
            plate
                .prescribe_motion_of_nodes(&node, along)
                .expect("a path");
        },
        0.0,
        false,
    );
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 2);
    for (record, way) in history.steps.iter().zip([-0.005, -0.02]) {
        let moved = record.rigid_motions[0].displacement;
        assert!(
            (moved - Vector::<2>::new(0.0, way)).norm() < 1e-12,
            "{moved}"
        );
        assert!((record.reactions[1][1] - 200.0 * way).abs() < 1e-8);
    }
    let turn = Motion::<2>::rotation([0.0, 1.0], 0.1);
    let mut plate = Body::rigid(block([0.0, 1.0], [1.0, 0.3], [3, 1]));
    let told = turn.and_then(|turn| plate.prescribe_motion("top", turn).map(|_| ()));
    assert!(
        told.expect_err("refused")
            .to_string()
            .contains("turns or deforms")
    );
}

/// Springs behind a plate and the block in front of it carry a force in proportion to their stiffnesses; a weight is a force.
#[test]
fn springs_and_weights() {
    let law = || LinearElastic::new(100.0, 0.0).expect("a law");
    let scene = pressed(
        law(),
        |plate| {
            plate.prescribe("left", [Some(0.0), None]).expect("a guide");
            plate.normal_foundation("top", 30.0).expect("springs");
            plate.body_force([0.0, -8.0]).expect("a weight");
        },
        0.0,
        false,
    );
    let history = ended(&mut scene.problem().expect("a problem"), 1);
    let record = last(&history);
    let weight = 8.0 * 2.5 * 0.3;
    let stiffness = 100.0 * 2.0 + 30.0 * 2.5;
    let way = record.rigid_motions[0].displacement[1];
    assert!((way + weight / stiffness).abs() < 1e-10, "{way}");
    // the springs' force is the plate's reaction
    assert!((record.reactions[1][1] + 30.0 * 2.5 * way).abs() < 1e-9);
}

/// A plate in a guide is driven sideways and pressed: each direction by itself.
#[test]
fn a_guide_that_moves() {
    let law = LinearElastic::new(100.0, 0.0).expect("a law");
    let scene = pressed(
        law,
        |plate| {
            plate
                .prescribe("right", [Some(0.02), None])
                .expect("a guide");
            plate
                .traction_in_time(
                    "top",
                    [0.0, -4.0],
                    Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)]).expect("a table"),
                )
                .expect("a load");
        },
        0.0,
        false,
    );
    let history = ended(&mut scene.problem().expect("a problem"), 2);
    let moved = last(&history).rigid_motions[0].displacement;
    assert!(
        (moved - Vector::<2>::new(0.02, -0.05)).norm() < 1e-9,
        "{moved}"
    );
}

/// A beam rests on two blocks of different stiffness, and is loaded at a point between them: levers tell the forces, these the ways, and
/// the ways how it turns. In the plane and in space.
#[test]
fn a_beam_that_tilts() {
    let law = |young| LinearElastic::new(young, 0.0).expect("a law");
    let columns = [(0.0, 100.0), (3.0, 250.0)];
    let mut scene = Scene::<2>::new();
    let mut feet = Vec::new();
    for (k, (x, young)) in columns.into_iter().enumerate() {
        let mut column = Body::new(block([x, 0.0], [0.2, 1.0], [2, 5]).quadratic(), law(young));
        column
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        feet.push(scene.add(format!("column {k}"), column));
    }
    let mut beam = Body::rigid_turning(block([0.0, 1.0], [3.2, 0.2], [32, 1]));
    // held along x in the height of its lower face
    let corner = beam
        .mesh()
        .nodes()
        .iter()
        .position(|X| X[0] == 0.0 && X[1] == 1.0);
    beam.prescribe_nodes(&[corner.expect("a corner")], [Some(0.0), None])
        .expect("a support");
    let place = |X: &Vector<2>| (X[0] - 1.1).abs() < 1e-9 && X[1] > 1.1;
    let loaded = beam.mesh().nodes().iter().position(place).expect("a node");
    beam.nodal_force(&[loaded], [0.0, -0.3]).expect("a load");
    let beam = scene.add("beam", beam);
    for foot in feet {
        scene
            .contact(foot.on("top"), beam.on("bottom"))
            .expect("a pair");
    }
    let history = ended(&mut scene.problem().expect("a problem"), 1);
    let record = last(&history);
    let forces = [0, 1].map(|k| -record.contact_forces[k][1]);
    assert!((forces[0] + forces[1] - 0.3).abs() < 1e-10, "{forces:?}");
    // a column of height 1 whose head turns by θ, and is free to go aside, resists by a moment E I θ = E b³ θ/12
    let motion = &record.rigid_motions[0];
    assert_eq!(motion.body, beam);
    let turn = motion.rotation[0];
    let moments: f64 = columns
        .iter()
        .map(|(_, young)| young * 0.2_f64.powi(3) / 12.0 * turn)
        .sum();
    let lever = forces[1] * 3.0;
    assert!(
        (lever - 0.3 * (1.1 - 0.1) - moments).abs() < 2e-3 * lever,
        "{lever} {moments}"
    );
    // the way of the middle of each column's head, by its force
    let ways = [0, 1].map(|k| forces[k] / (columns[k].1 * 0.2));
    assert!(
        (turn + (ways[1] - ways[0]) / 3.0).abs() < 2e-3 * turn.abs(),
        "{turn} {ways:?}"
    );
    let middle = -motion.displacement[1];
    assert!(
        (middle - 0.5 * (ways[0] + ways[1])).abs() < 2e-3 * middle,
        "{middle} {ways:?}"
    );
}

/// A rigid table on a block in space, loaded beside its middle, so that its other side lifts: it tilts towards the load, and the contact's resultant
/// is where the load is.
#[test]
fn a_table_that_tilts_in_space() {
    let law = LinearElastic::new(100.0, 0.0).expect("a law");
    let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2]).expect("a mesh");
    let mut block = Body::new(mesh, law);
    block
        .prescribe("bottom", [Some(0.0); 3])
        .expect("a support");
    for (side, axis) in [("left", 0), ("right", 0), ("front", 1), ("back", 1)] {
        let held: [Option<f64>; 3] = std::array::from_fn(|i| (i == axis).then_some(0.0));
        block.prescribe(side, held).expect("a support");
    }
    let mesh = cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 0.25], [2, 4, 1]).expect("a mesh");
    let mut table = Body::rigid_turning(mesh);
    let at = |x: f64, y: f64| move |X: &Vector<3>| X[0] == x && X[1] == y && X[2] > 1.1;
    let node = |holds: &dyn Fn(&Vector<3>) -> bool| {
        table.mesh().nodes().iter().position(holds).expect("a node")
    };
    let (corner, side) = (node(&at(0.0, 0.0)), node(&at(1.0, 0.0)));
    let loaded = node(&at(0.5, 0.75));
    table
        .prescribe_nodes(&[corner], [Some(0.0), Some(0.0), None])
        .expect("a support");
    table
        .prescribe_nodes(&[side], [None, Some(0.0), None])
        .expect("a support");
    table
        .nodal_force(&[loaded], [0.0, 0.0, -0.4])
        .expect("a load");
    let mut scene = Scene::new();
    let (block, table) = (scene.add("block", block), scene.add("table", table));
    scene
        .contact(block.on("top"), table.on("bottom"))
        .expect("a pair");
    scene.geometry = Some(Geometry::Reference);
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 1);
    let record = history.last().expect("a step");
    let motion = &record.rigid_motions[0];
    assert_eq!(motion.body, table);
    assert_eq!(motion.rotation.len(), 3);
    // symmetric about x = ½: it turns about x alone, downwards where it is loaded
    assert!(motion.rotation[0] < -1e-4, "{:?}", motion.rotation);
    assert!(
        motion.rotation[1].abs() < 1e-3 * motion.rotation[0].abs(),
        "{:?}",
        motion.rotation
    );
    assert!(motion.rotation[2].abs() < 1e-9, "{:?}", motion.rotation);
    let force = record.contact_forces[0];
    assert!(
        (force + Vector::<3>::new(0.0, 0.0, 0.4)).norm() < 1e-7,
        "{force}"
    );
    // the force's line of action is that of the contact
    let centre = record.pairs[0].centre.expect("contact");
    assert!(
        (centre[0] - 0.5).abs() < 1e-6 && (centre[1] - 0.75).abs() < 1e-3,
        "{centre}"
    );
}

/// A torque and a force tilt a plate as the force alone does beside its middle.
#[test]
fn torques_are_forces_with_an_arm() {
    let run = |place: f64, torque: f64| {
        let law = LinearElastic::new(100.0, 0.3).expect("a law");
        let mut below = Body::new(block([0.0, 0.0], [2.0, 1.0], [12, 6]), law);
        below.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut plate = Body::rigid_turning(block([0.0, 1.0], [2.0, 0.3], [10, 1]));
        let held = plate.mesh().nodes_at(&[[0.0, 1.0]]).expect("a corner");
        plate
            .prescribe_nodes(&held, [Some(0.0), None])
            .expect("a guide");
        let loaded = plate.mesh().nodes_at(&[[place, 1.3]]).expect("a node");
        plate.nodal_force(&loaded, [0.0, -5.0]).expect("a load");
        // of whatever boundary
        plate.torque("right", &[torque]).expect("a load");
        let mut scene = Scene::new();
        let (below, plate) = (scene.add("below", below), scene.add("plate", plate));
        scene
            .contact(below.on("top"), plate.on("bottom"))
            .expect("a pair");
        let history = ended(&mut scene.problem().expect("a problem"), 1);
        let motion = last(&history).rigid_motions[0].clone();
        (motion.displacement, motion.rotation[0])
    };
    let (beside, twisted) = (run(1.4, 0.0), run(1.0, -2.0));
    assert!(beside.1 < -1e-3);
    assert!((beside.1 - twisted.1).abs() < 1e-10 * beside.1.abs().max(1e-3));
    assert!((beside.0 - twisted.0).norm() < 1e-10);
}

/// Two feet of one rigid body, without a cell in common, go down alike on blocks of different stiffness.
#[test]
fn a_group_moves_as_one() {
    let law = |young| LinearElastic::new(young, 0.0).expect("a law");
    let mut scene = Scene::<2>::new();
    let youngs = [100.0, 300.0];
    let ids = [0, 1].map(|k| {
        let mut column = Body::new(
            block([3.0 * k as f64, 0.0], [1.0, 1.0], [3, 3]),
            law(youngs[k]),
        );
        column.symmetry("bottom").expect("a support");
        column.symmetry("left").expect("a support");
        scene.add(format!("column {k}"), column)
    });
    let (mut nodes, mut cells) = (Vec::new(), Vec::new());
    for x in [0.0, 3.0] {
        let foot = block([x, 1.0], [1.0, 0.5], [2, 1]);
        let first = nodes.len();
        nodes.extend(foot.nodes().iter().map(|X| [X[0], X[1]]));
        cells.extend(foot.cells().flatten().map(|a| first + a));
    }
    let mut mesh = Mesh::new(nodes, cells).expect("a mesh");
    mesh.name_boundary("feet", |X| X[1] < 1.0 + 1e-9);
    mesh.name_boundary("top", |X| X[1] > 1.5 - 1e-9);
    let mut tool = Body::rigid(mesh);
    tool.prescribe("top", [Some(0.0), None]).expect("a guide");
    tool.nodal_force(&[0], [0.0, -8.0]).expect("a load");
    let tool = scene.add("tool", tool);
    for id in ids {
        scene
            .contact(id.on("top"), tool.on("feet"))
            .expect("a pair");
    }
    let history = ended(&mut scene.problem().expect("a problem"), 1);
    let record = last(&history);
    assert!((record.rigid_motions[0].displacement[1] + 8.0 / 400.0).abs() < 1e-9);
    for (k, young) in youngs.into_iter().enumerate() {
        let force = record.contact_forces[k][1];
        assert!((force + 8.0 * young / 400.0).abs() < 1e-7, "{force}");
    }
}

/// A rigid ball is pressed into a block of revolution by a force: Hertz' approach, δ³ = 9 F²/(16 R E*²).
#[test]
fn a_ball_under_a_force() {
    let (R, F, young, nu) = (1.0_f64, 2e-3_f64, 1.0_f64, 0.3_f64);
    let stiffness = young / (1.0 - nu * nu);
    let a = (3.0 * F * R / (4.0 * stiffness)).cbrt();
    let delta = a * a / R;
    // finer towards the contact
    let graded = |most: f64, n: usize| -> Vec<f64> {
        (0..=n)
            .map(|k| most * (k as f64 / n as f64).powi(3))
            .collect()
    };
    let size = 40.0 * a;
    let heights = graded(size, 26)
        .iter()
        .rev()
        .map(|h| -h)
        .collect::<Vec<_>>();
    let mesh = rectangle(&graded(size, 26), &heights, Diagonals::Rising).expect("a mesh");
    let law = LinearElastic::new(young, nu).expect("a law");
    let mut below = Body::of_revolution(mesh.quadratic(), law).expect("a body");
    below.symmetry("bottom").expect("a support");
    let angles: Vec<f64> = graded(0.5 * PI, 30)
        .iter()
        .map(|angle| 1.5 * PI + angle)
        .collect();
    let ball = quarter_disc(&linspace(0.0, R, 3), &angles, Diagonals::Rising).expect("a mesh");
    let ball = ball
        .quadratic()
        .curved("arc", |X| X * (R / X.norm()))
        .expect("a curve");
    let ball = ball.translated([0.0, R]).expect("moved");
    let mut ball = Body::rigid_of_revolution(ball).expect("a body");
    ball.body_force([0.0, -F / ball.volume()])
        .expect("a weight");
    let mut scene = Scene::new();
    let (below, ball) = (scene.add("below", below), scene.add("ball", ball));
    scene
        .contact(below.on("top"), ball.on("arc"))
        .expect("a pair");
    let history = ended(&mut scene.problem().expect("a problem"), 1);
    let record = last(&history);
    let way = -record.rigid_motions[0].displacement[1];
    // a block of 40 a instead of a half-space gives way less, by about a/size
    assert!((way / delta - 1.0).abs() < 0.04, "{way} {delta}");
    assert!((record.contact_forces[1][1] / F - 1.0).abs() < 1e-6);
}

#[test]
fn what_rigid_bodies_do_not_take() {
    let plate = || Body::rigid(block([0.0, 1.0], [1.0, 0.3], [3, 1]));
    let refused = |error: Option<Error>, says: &str| {
        let told = error.expect("refused").to_string();
        assert!(told.contains(says), "{told}");
    };
    let always = plate()
        .during(&[[0.0, 1.0]], |body| body.prescribe("top", [Some(0.0); 2]))
        .err();
    refused(always, "at all times");
    refused(
        plate().prescribe_along("top", [1.0, 1.0], 0.0).err(),
        "not an axis",
    );
    // two values for one component, at different nodes
    let mut twice = plate();
    twice
        .prescribe("left", [None, Some(0.1)])
        .expect("a support");
    refused(
        twice.prescribe("right", [None, Some(0.2)]).err(),
        "prescribed twice",
    );
    // which leaves it as it was, and the same again is fine
    twice
        .prescribe("right", [None, Some(0.1)])
        .expect("the same");
    // of a body that turns, they are a rotation
    let mut turned = Body::rigid_turning(block([0.0, 1.0], [1.0, 0.3], [3, 1]));
    turned
        .prescribe("left", [None, Some(0.1)])
        .expect("a support");
    turned
        .prescribe("right", [None, Some(0.2)])
        .expect("a rotation");
    refused(
        turned.prescribe("top", [None, Some(0.1)]).err(),
        "prescribed twice",
    );

    let mut scene = Scene::new();
    let alone = scene.add("plate", plate());
    let floor = Obstacle::half_space([0.0, 1.0], [0.0, 1.0]).expect("a floor");
    scene
        .obstacle("floor", alone.on("bottom"), floor)
        .expect("held");
    refused(scene.problem().err(), "no body deforms");

    let turning = |law: Body<2>| {
        let mut scene = Scene::new();
        let below = scene.add("below", law);
        let plate = Body::rigid_turning(block([0.0, 1.0], [1.0, 0.3], [3, 1]));
        let plate = scene.add("plate", plate);
        scene
            .contact(below.on("top"), plate.on("bottom"))
            .expect("a pair");
        scene
    };
    let held = |mut body: Body<2>| {
        body.prescribe("bottom", [Some(0.0); 2]).expect("a support");
        body
    };
    let mesh = || block([0.0, 0.0], [1.0, 1.0], [3, 3]);
    let large = held(Body::new(mesh(), NeoHookean::new(1.0, 0.3).expect("a law")));
    refused(turning(large).problem().err(), "turns by small angles");
    let small = || {
        held(Body::new(
            mesh(),
            LinearElastic::new(1.0, 0.3).expect("a law"),
        ))
    };
    assert!(turning(small()).problem().is_ok());
    let mut tied = Scene::new();
    let (below, plate) = (tied.add("below", small()), tied.add("plate", plate()));
    tied.tie(below.on("top"), plate.on("bottom"))
        .expect("declared");
    refused(tied.problem().err(), "rigid");
}
