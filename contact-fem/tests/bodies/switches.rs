//! Pairs and obstacles that count in some phases alone.

use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::simulation::History;
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, Motion, NeoHookean, Obstacle, Phase, Scene, Simulation,
};

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2], small: bool) -> Body<2> {
    let [xs, ys] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
    let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
    match small {
        true => Body::new(mesh, LinearElastic::new(50.0, 0.3).expect("a law")),
        false => Body::new(mesh, NeoHookean::new(50.0, 0.3).expect("a law")),
    }
}

fn holds(history: &History<2>) {
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("a step");
    assert!(certificate.holds(&Limits::default()), "{certificate}");
}

/// A block is pressed into another, and its pair ends: both spring back to what they were, though the tool stays in the way.
fn spring_back(by: f64, small: bool) {
    let mut lower = block([0.0, 0.0], [2.0, 1.0], [6, 3], small);
    lower.prescribe("bottom", [Some(0.0); 2]).expect("held");
    let mut upper = block([0.5, 1.0], [1.0, 1.0], [4, 3], small);
    let course = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0)]).expect("a table");
    upper
        .prescribe_in_time("top", [Some(0.0), Some(-by)], course)
        .expect("held");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower);
    let upper = scene.add("upper", upper);
    let sides = [lower.on("top"), upper.on("bottom")];
    scene
        .contact(sides[0].clone(), sides[1].clone())
        .expect("a pair");
    scene
        .contact_during(&sides[1], &sides[0], &[[0.0, 1.0]])
        .expect("in any order");
    let mut problem = scene.problem().expect("a problem");
    let phases = [Phase::new("press", 1.0, 3), Phase::new("let go", 2.0, 2)];
    let history = Simulation::in_phases(phases)
        .run(&mut problem)
        .expect("a run");
    holds(&history);
    let [pressed, free] = [2, 3].map(|step| &history.steps[step]);
    assert!(pressed.reaction(lower)[1] > 5.0 * by && pressed.rows > 0);
    assert!(pressed.pairs[0].area > 0.9);
    assert_eq!((free.phase(), free.rows), ("let go", 0));
    assert_eq!(free.contact_force(lower).norm(), 0.0);
    assert_eq!((free.penetration, free.pairs[0].area), (0.0, 0.0));
    // the upper block is in the lower one, and neither is strained
    let moved = problem.displacements(&history.run.state.u);
    let down = |b: usize| problem.nodes(b).map(|a| moved[a]).collect::<Vec<_>>();
    assert!(down(0).iter().all(|u| u.norm() < 1e-9), "{:?}", down(0));
    let still = down(1)
        .iter()
        .all(|u| u[0].abs() < 1e-9 && (u[1] + by).abs() < 1e-9);
    assert!(still, "{:?}", down(1));
    assert!(free.stored_energy.abs() < 1e-9 * pressed.stored_energy);
}

#[test]
fn linear_blocks_spring_back() {
    spring_back(0.01, true);
}

#[test]
fn rubber_blocks_spring_back() {
    spring_back(0.15, false);
}

/// A tool goes down through a block while it does not count, and up against it while it does: as if it had been there at once.
#[test]
fn a_tool_that_comes_later() {
    let run = |passes_through: bool| {
        let mut beam = block([0.0, 0.0], [4.0, 0.5], [16, 2], false);
        beam.prescribe("left", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        let beam = scene.add("beam", beam);
        let ball = Obstacle::ball([3.0, 1.2], 0.5).expect("a ball");
        let way = Motion::translation([0.0, 1.0]).expect("a motion");
        // below the beam at time 1 and up by 0.8 later, or there from the start
        let down = Motion::translation([0.0, -2.3]).expect("a motion");
        let gone = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 1.5 / 2.3)]).expect("a table");
        let tool = match passes_through {
            true => ball.moving(down.driven_by(gone)),
            false => {
                let below = Obstacle::ball([3.0, -1.1], 0.5).expect("a ball");
                let rise = Amplitude::table(&[(1.0, 0.0), (2.0, 0.8)]).expect("a table");
                below.moving(way.driven_by(rise))
            }
        };
        let tool = scene
            .obstacle("tool", beam.on("bottom"), tool)
            .expect("a side");
        scene
            .contact_obstacle(beam.on("top"), tool)
            .expect("another side");
        if passes_through {
            scene
                .obstacle_during(tool, &[[1.0, f64::INFINITY]])
                .expect("an interval");
        }
        let mut problem = scene.problem().expect("a problem");
        let phases = [Phase::new("down", 1.0, 2), Phase::new("up", 2.0, 6)];
        let history = Simulation::in_phases(phases)
            .run(&mut problem)
            .expect("a run");
        holds(&history);
        (
            history.steps[1].energy,
            history.last().expect("a step").obstacle_force(tool)[1],
        )
    };
    let [(before, later), (_, always)] = [true, false].map(run);
    assert_eq!(before, 0.0);
    assert!(
        always < -1e-3 && (later / always - 1.0).abs() < 1e-6,
        "{later} {always}"
    );
}

/// What is not declared cannot be switched, and intervals have an end beyond their beginning.
#[test]
fn wrong_switches() {
    let mut scene = Scene::new();
    let lower = scene.add("lower", block([0.0, 0.0], [1.0, 1.0], [1, 1], true));
    let upper = scene.add("upper", block([0.0, 1.0], [1.0, 1.0], [1, 1], true));
    let (first, second) = (lower.on("top"), upper.on("bottom"));
    let refused = scene.contact_during(&first, &second, &[[0.0, 1.0]]);
    assert!(matches!(refused, Err(Error::NoPair { .. })));
    scene
        .contact(first.clone(), second.clone())
        .expect("a pair");
    for wrong in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::NAN]] {
        let refused = scene.contact_during(&first, &second, &[[0.0, 1.0], wrong]);
        let told = refused.expect_err("no interval").to_string();
        assert!(told.contains("end of the interval"), "{told}");
    }
    let floor = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a floor");
    let floor = scene
        .obstacle("floor", lower.on("bottom"), floor)
        .expect("a side");
    scene
        .obstacle_during(floor, &[[0.0, 1.0]])
        .expect("declared");
    assert!(
        Scene::<2>::new()
            .obstacle_during(floor, &[[0.0, 1.0]])
            .is_err()
    );
}

/// Pairs and obstacles are switched where phases end, and count in some phase.
#[test]
fn switches_meet_the_phases() {
    let told = |intervals: &[[f64; 2]], ends: &[f64]| {
        let mut scene = Scene::new();
        let mut body = block([0.0, 0.0], [1.0, 1.0], [1, 1], true);
        body.prescribe("top", [Some(0.0), Some(-0.01)])
            .expect("a support");
        let block = scene.add("block", body);
        let floor = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a floor");
        let floor = scene
            .obstacle("floor", block.on("bottom"), floor)
            .expect("a side");
        scene
            .obstacle_during(floor, intervals)
            .expect("an interval");
        let mut problem = scene.problem().expect("a problem");
        let phases: Vec<Phase> = ends.iter().map(|&end| Phase::new("", end, 1)).collect();
        let run = Simulation::in_phases(phases).run(&mut problem);
        run.err().map(|error| error.to_string())
    };
    assert_eq!(told(&[[0.0, 1.0]], &[1.0, 2.0]), None);
    assert_eq!(told(&[[1.0, 7.0]], &[1.0, 2.0]), None);
    for (interval, what) in [
        (
            [0.0, 0.5],
            "at load factor 0.5, within the phase from 0 to 1",
        ),
        (
            [1.25, 9.0],
            "at load factor 1.25, within the phase from 1 to 2",
        ),
        (
            [2.0, 3.0],
            "counts at no load factor of the run, which ends at 2",
        ),
        (
            [-3.0, 0.0],
            "counts at no load factor of the run, which ends at 2",
        ),
    ] {
        let told = told(&[interval], &[1.0, 2.0]).expect("refused");
        assert!(
            told.contains("obstacle `floor`") && told.contains(what),
            "{told}"
        );
    }
}
