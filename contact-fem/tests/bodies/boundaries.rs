//! Elastic foundations, and pressures that follow their boundary, against beam theory and integrated equations.
#![allow(non_snake_case)] // the symbols of the field

use std::f64::consts::{FRAC_PI_2, PI};

use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{InitialGaps, Integration, WorkSource};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Mesh, NeoHookean, Obstacle, Scene, Simulation};

use crate::common::{at, bore, ended};

fn grid(x: [f64; 2], y: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let (xs, ys) = (
        linspace(x[0], x[1], cells[0]),
        linspace(y[0], y[1], cells[1]),
    );
    rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
}

/// A beam between planes of symmetry on springs, under p (1 + cos qx): the mean sinks by p/k, and the wave is that of
/// Timoshenko's beam on Winkler's foundation.
#[test]
fn beam_on_an_elastic_foundation() {
    let (young, height, length, k, p) = (1e4, 0.2, 4.0, 2.5, 1e-3);
    let q = PI / length;
    let mesh = grid([0.0, length], [0.0, height], [40, 2]).quadratic();
    let mut beam = Body::new(mesh, LinearElastic::new(young, 0.0).expect("a law"));
    beam.symmetry("left").expect("held");
    beam.symmetry("right").expect("held");
    beam.normal_foundation("bottom", k).expect("springs");
    beam.traction_field("top", |X| [0.0, -p * (1.0 + (q * X[0]).cos())].into())
        .expect("a load");
    let mut scene = Scene::new();
    let beam = scene.add("beam", beam);
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 1);
    let last = history.last().expect("a step");
    let bending = young * height.powi(3) / 12.0 * q.powi(4);
    // shear: G of half E, on 5/6 of the section
    let bending = bending / (1.0 + height * height / 12.0 * q * q * 2.0 / (5.0 / 6.0));
    let u = &history.run.state.u;
    for x in [0.0, 1.0, 4.0] {
        let expected = -p / k - p / (k + bending) * (q * x).cos();
        let found = at(&problem, u, [x, 0.0])[1];
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} {expected} at {x}"
        );
    }
    // the foundation carries all of it
    assert!((last.reaction(beam)[1] / (p * length) - 1.0).abs() < 1e-9);
    let sides: Vec<_> = last
        .support_reactions
        .iter()
        .map(|(side, _)| side.boundary.as_str())
        .collect();
    assert_eq!(sides, ["left", "right", "bottom"]);
    assert!((last.support_reactions[2].1[1] / (p * length) - 1.0).abs() < 1e-9);
    // what the load does, the springs and the beam store
    let works = &last.works;
    let springs = works
        .iter()
        .find(|own| own.source == WorkSource::Foundation(beam.on("bottom")));
    let taken = springs.expect("springs").work;
    assert!(taken < 0.0 && (last.work() / last.stored_energy - 1.0).abs() < 1e-9);
    assert!((last.stored_energy - taken) / last.energy < -0.99);
}

/// Two columns and a layer of springs in a row, pressed by a prescribed displacement: E/h, E₂/h₂ and k in series.
#[test]
fn a_block_on_springs_in_contact() {
    let (k, by) = (30.0, 1e-3);
    let column = |low: f64, high: f64, cells, young| {
        let mesh = grid([0.0, 1.0], [low, high], [cells, cells]);
        Body::new(mesh, LinearElastic::new(young, 0.0).expect("a law"))
    };
    let (mut lower, mut upper) = (column(0.0, 2.0, 3, 100.0), column(2.0, 3.0, 4, 20.0));
    lower.foundation("bottom", k).expect("springs");
    upper
        .prescribe("top", [Some(0.0), Some(-by)])
        .expect("held");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower);
    let upper = scene.add("upper", upper);
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    // meshes that do not match, without error
    scene.integration = Some(Integration::Exact);
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 2);
    let last = history.last().expect("a step");
    let pressure = by / (2.0 / 100.0 + 1.0 / 20.0 + 1.0 / k);
    for (body, sign) in [(lower, 1.0), (upper, -1.0)] {
        let found = last.reaction(body)[1] * sign;
        assert!((found / pressure - 1.0).abs() < 1e-8, "{found} {pressure}");
    }
    assert!((last.work() / last.stored_energy - 1.0).abs() < 1e-8);
}

/// Springs of large strains, which alone hold a block that turns: the work is what bodies and springs store.
#[test]
fn a_soft_block_turns_on_its_springs() {
    let left = |increments: usize| {
        let mesh = grid([0.0, 1.0], [0.0, 1.0], [3, 3]);
        let mut block = Body::new(mesh, NeoHookean::new(50.0, 0.3).expect("a law"));
        block.foundation("bottom", 10.0).expect("springs");
        block.traction("top", [3.0, -1.0]).expect("a load");
        let mut scene = Scene::new();
        let block = scene.add("block", block);
        let mut problem = scene.problem().expect("held");
        let run = Simulation::with_increments(increments).run(&mut problem);
        let history = run.expect("a run");
        assert!(history.is_complete(), "{}", history.run.ending);
        let last = history.last().expect("a step");
        assert!(
            last.certificate.holds(&Limits::default()),
            "{:?}",
            last.certificate
        );
        let reaction = last.reaction(block) - Vector::<2>::new(-3.0, 1.0);
        assert!(reaction.norm() < 1e-6, "{reaction}");
        (last.work() - last.stored_energy) / last.stored_energy
    };
    let [coarse, fine] = [16, 32].map(left);
    assert!(coarse.abs() < 0.03, "{coarse}");
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// A body on normal springs alone slides, and says so; wrong stiffnesses and boundaries are refused.
#[test]
fn what_springs_do_not_hold() {
    let law = LinearElastic::new(1.0, 0.0).expect("a law");
    let mut block = Body::new(grid([0.0, 1.0], [0.0, 1.0], [2, 2]), law);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let told = block
            .foundation("bottom", wrong)
            .err()
            .expect("refused")
            .to_string();
        assert!(told.contains("stiffness of a foundation"), "{told}");
    }
    assert!(matches!(
        block.foundation("nowhere", 1.0),
        Err(Error::UnknownBoundary { .. })
    ));
    block.normal_foundation("bottom", 1.0).expect("springs");
    let mut scene = Scene::new();
    scene.add("block", block);
    let told = scene.problem().err().expect("it slides").to_string();
    assert!(
        told.contains("translation x") && !told.contains("rotation"),
        "{told}"
    );
}

/// A quarter of a tube of rubber, whose bore grows by nearly a half.
#[test]
fn inflation_of_a_tube() {
    let (young, nu, p) = (100.0, 0.3, 15.0);
    let lame = [
        young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        young / (2.0 * (1.0 + nu)),
    ];
    let polar = |X: &Vector<2>| Vector::<2>::new(X[0] * X[1].cos(), X[0] * X[1].sin());
    let mesh = grid([1.0, 2.0], [0.0, FRAC_PI_2], [6, 9])
        .quadratic()
        .mapped(polar);
    let law = NeoHookean::new(young, nu).expect("a law");
    let mut tube = Body::new(mesh.expect("a mesh"), law);
    tube.symmetry("bottom").expect("a plane");
    tube.symmetry("top").expect("a plane");
    tube.pressure("left", p).expect("a pressure");
    let mut scene = Scene::new();
    let tube = scene.add("tube", tube);
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 5);
    let last = history.last().expect("a step");
    let u = &history.run.state.u;
    let found = 1.0 + at(&problem, u, [1.0, 0.0])[0];
    let expected = bore(lame, p);
    assert!(
        expected > 1.4 && (found / expected - 1.0).abs() < 2e-4,
        "{found} {expected}"
    );
    // each plane of symmetry carries p times the width of the bore there
    let across = 1.0 + at(&problem, u, [0.0, 1.0])[1];
    let left = last.reaction(tube) + Vector::<2>::new(across, found) * p;
    assert!(left.norm() < 1e-6 * p, "{left} {found} {across}");
    let lost = (last.work() - last.stored_energy) / last.stored_energy;
    assert!(lost.abs() < 0.05, "{lost}");
    assert!(
        last.works
            .iter()
            .any(|own| own.source.kind() == "pressure" && own.work > 0.0)
    );
}

/// A block of rubber between planes of symmetry, which a pressure on its top presses on a ball: the ball carries p times the
/// width, however the top deforms.
#[test]
fn a_membrane_pressure_on_a_block_over_a_ball() {
    let (p, width) = (8.0, 1.5);
    let mesh = grid([0.0, width], [0.0, 1.0], [9, 6]);
    let mut block = Body::new(mesh, NeoHookean::new(20.0, 0.3).expect("a law"));
    block.symmetry("left").expect("a plane");
    block.symmetry("right").expect("a plane");
    block.pressure("top", p).expect("a pressure");
    let mut scene = Scene::new();
    let block = scene.add("block", block);
    let ball = Obstacle::ball([0.0, -2.0], 2.0).expect("a ball");
    let ball = scene
        .obstacle("ball", block.on("bottom"), ball)
        .expect("a side");
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 8);
    let last = history.last().expect("a step");
    let force = last.obstacle_force(ball)[1];
    assert!((force / (-p * width) - 1.0).abs() < 1e-6, "{force}");
    let u = &history.run.state.u;
    let sag = at(&problem, u, [width, 1.0])[1] - at(&problem, u, [0.0, 1.0])[1];
    assert!(sag.abs() > 0.02, "the top does not stay level: {sag}");
}

/// Under a law for small strains the pressure is that of the reference configuration: a bar shortens by p h (1 − ν²)/E.
#[test]
fn pressures_at_small_strains() {
    let (young, nu, p) = (200.0, 0.25, 3.0);
    let law = LinearElastic::new(young, nu).expect("a law");
    let mut bar = Body::new(grid([0.0, 1.0], [0.0, 2.0], [2, 4]), law);
    bar.symmetry("bottom").expect("held");
    bar.symmetry("left").expect("held");
    bar.pressure("top", p).expect("its rim may be free");
    let mut scene = Scene::new();
    let bar = scene.add("bar", bar);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(1)
        .run(&mut problem)
        .expect("a run");
    let last = history.last().expect("a step");
    let found = at(&problem, &history.run.state.u, [1.0, 2.0])[1];
    assert!(
        (found / (-p * 2.0 * (1.0 - nu * nu) / young) - 1.0).abs() < 1e-9,
        "{found}"
    );
    assert!((last.reaction(bar)[1] - p).abs() < 1e-9);
    assert!((last.work() / last.stored_energy - 1.0).abs() < 1e-9);
}

/// Pressures without a potential are refused with the place; planes of symmetry that part with each other keep it.
#[test]
fn free_rims() {
    let law = NeoHookean::new(10.0, 0.3).expect("a law");
    let block = || Body::new(cuboid([0.0; 3], [1.0; 3], [2, 2, 1]).expect("a mesh"), law);
    let refused = |body: Body<3>| {
        let mut scene = Scene::new();
        scene.add("block", body);
        scene.initial_gaps = InitialGaps::Refuse;
        scene.problem().err()
    };
    let mut free = block();
    free.prescribe("bottom", [Some(0.0); 3]).expect("held");
    free.pressure("top", 1.0).expect("supports may come later");
    match refused(free) {
        Some(Error::FreeRim { body, boundary, at }) => {
            assert_eq!(
                (body.as_str(), boundary.as_str(), at[2]),
                ("block", "top", 1.0)
            );
        }
        other => panic!("{other:?}"),
    }
    let mut sliding = block();
    sliding.prescribe("bottom", [Some(0.0); 3]).expect("held");
    sliding.pressure("top", 1.0).expect("a pressure");
    for side in ["left", "right"] {
        sliding.symmetry(side).expect("a plane");
    }
    assert!(
        matches!(refused(sliding), Some(Error::FreeRim { .. })),
        "two sides are free"
    );

    let mut sliding = block();
    sliding
        .prescribe("bottom", [None, None, Some(0.0)])
        .expect("held");
    sliding.pressure("top", 1.0).expect("a pressure");
    for side in ["left", "front", "back"] {
        sliding.symmetry(side).expect("a plane");
    }
    sliding
        .prescribe("right", [Some(0.3), None, None])
        .expect("it moves");
    assert!(refused(sliding).is_none());

    let mut turned = block();
    turned
        .prescribe("bottom", [None, None, Some(0.0)])
        .expect("held");
    turned.pressure("top", 1.0).expect("a pressure");
    for side in ["left", "front", "back"] {
        turned.symmetry(side).expect("a plane");
    }
    let course = |t: f64, X: &Vector<3>| Vector::<3>::new(0.3 * t * X[1], 0.0, 0.0);
    turned.prescribe_path("right", course).expect("all of it");
    assert!(
        refused(turned).is_none(),
        "all components of its rim are held"
    );
}
