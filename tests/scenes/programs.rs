//! Load programs: amplitudes, paths, rigid motions, obstacles on the move, and phases.

use crate::common::relative;
use contact_core::{Automatic, CondensedNewton, Equilibrium, Phase};
use contact_fem::mesh::generators::{Diagonals, annulus, linspace, rectangle};
use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Amplitude, Body, Motion, NeoHookean, Obstacle, Scene, Simulation};
use ipopt_contact_scenes::tight;

/// All phases, none of whose steps is cut, under a tight certificate.
fn complete(scene: Scene<2>, phases: &[Phase]) -> (Problem<2>, History<2>) {
    complete_with(Automatic::default(), scene, phases)
}

fn complete_with<S: Equilibrium>(
    solver: S,
    scene: Scene<2>,
    phases: &[Phase],
) -> (Problem<2>, History<2>) {
    let mut problem = scene.problem().expect("a sound scene");
    let mut simulation = Simulation::solved_by(solver, 1);
    simulation.load_steps.phases = phases.to_vec();
    let history = simulation.run(&mut problem);
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    assert_eq!(history.run.cuts(), 0);
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    (problem, history)
}

/// A block from `low` to `high`, with cells of `size`.
fn block(low: [f64; 2], high: [f64; 2], size: f64) -> Body<2> {
    let line = |i: usize| {
        let cells = ((high[i] - low[i]) / size).round() as usize;
        linspace(low[i], high[i], cells)
    };
    let mesh = rectangle(&line(0), &line(1), Diagonals::Alternating).expect("mesh");
    Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("law"))
}

fn floor() -> Obstacle<2> {
    Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a half-plane")
}

fn table(pairs: &[(f64, f64)]) -> Amplitude {
    Amplitude::table(pairs).expect("a table")
}

/// A block is pressed on a floor that it does not touch at first, and pulled back: it is as before, and nothing is lost.
#[test]
fn load_and_unload_return_to_the_start() {
    let mut body = block([0.0, 0.05], [1.0, 1.05], 0.25);
    let there_and_back = table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]);
    body.prescribe_in_time("top", [Some(0.02), Some(-0.3)], there_and_back)
        .expect("support");
    let mut scene = Scene::new();
    let side = scene.add("block", body).on("bottom");
    let floor = scene.obstacle("floor", side, floor()).expect("a side");
    let phases = [Phase::new("press", 1.0, 6), Phase::new("pull back", 2.0, 6)];
    let (problem, history) = complete(scene, &phases);
    let [pressed, back] = [5, 11].map(|k| &history.steps[k]);
    assert_eq!((pressed.factor, back.factor), (1.0, 2.0));
    assert_eq!((pressed.phase(), back.phase()), ("press", "pull back"));
    assert!(pressed.obstacle_force(floor)[1] < -1.0);
    let U = problem.displacements(&history.run.state.u);
    let left = U.iter().fold(0.0, |m: f64, u| m.max(u.amax()));
    assert!(left < 1e-9, "{left:e}");
    assert!(back.stored_energy.abs() < 1e-9 * pressed.stored_energy);
    // the way back costs what the way there did
    assert!(
        back.work().abs() < 1e-9 * pressed.work(),
        "{} {}",
        back.work(),
        pressed.work()
    );
    // a start on the line through two states would go on down where the motion turns
    let turn = history.run.attempts.iter().find(|a| a.phase == "pull back");
    assert!(!turn.expect("an attempt").predicted);
}

/// A block is pressed on a floor and then slid along it: the normal force stays, there is none along, and no work is done.
#[test]
fn press_then_slide() {
    let mut body = block([0.0; 2], [1.0; 2], 0.125);
    body.prescribe_path("top", |t, _| {
        let (down, along) = (t.min(1.0), (t - 1.0).max(0.0));
        Vector::<2>::new(4.0 * along, -0.1 * down)
    })
    .expect("support");
    let mut scene = Scene::new();
    let block = scene.add("block", body);
    let floor = scene.obstacle("floor", block.on("bottom"), floor());
    let floor = floor.expect("a side");
    let phases = [Phase::new("press", 1.0, 2), Phase::new("slide", 2.0, 8)];
    let (problem, history) = complete(scene, &phases);
    let pressed = &history.steps[1];
    let force = pressed.obstacle_force(floor);
    assert!(force[1] < -0.9, "{force}");
    for step in &history.steps[2..] {
        let now = step.obstacle_force(floor);
        assert!(
            (now - force).norm() < 1e-9 * force.norm(),
            "{now} for {force}"
        );
        assert!((step.reaction(block) - force).norm() < 1e-9 * force.norm());
        assert!((step.work() - pressed.work()).abs() < 1e-9 * pressed.work());
    }
    let top = problem.displacements(&history.run.state.u)[problem.reference().len() - 1];
    assert_eq!([top[0], top[1]], [4.0, -0.1]);
}

/// The right edge of a bar is turned by 1 rad about the point that makes an arc of it: its nodes go along circles, exactly.
#[test]
fn an_edge_is_turned_by_one_radian() {
    let lines = [linspace(0.0, 4.0, 16), linspace(-0.25, 0.25, 2)];
    let mesh = rectangle(&lines[0], &lines[1], Diagonals::Alternating).expect("mesh");
    let mut bar = Body::new(mesh.quadratic(), NeoHookean::new(10.0, 0.3).expect("law"));
    let centre = [2.0, 4.0 - 2.0 / 0.5f64.tan()];
    bar.prescribe("left", [Some(0.0); 2]).expect("support");
    let turn = Motion::<2>::rotation(centre, 1.0).expect("a turn");
    bar.prescribe_motion("right", turn).expect("support");
    let edge = bar.mesh().boundary_nodes("right").expect("named");
    let mut scene = Scene::new();
    scene.add("bar", bar);
    let mut problem = scene.problem().expect("a scene");
    let mut checked = 0;
    let history = Simulation::with_increments(5).run_observed(&mut problem, |step| {
        let x = step.problem.positions(&step.solution.state.u);
        let (sin, cos) = step.record.factor.sin_cos();
        for &node in &edge {
            let X = step.problem.reference()[node] - Vector::<2>::from(centre);
            let turned = [cos * X[0] - sin * X[1], sin * X[0] + cos * X[1]];
            let turned = Vector::<2>::from(centre) + Vector::<2>::from(turned);
            assert!((x[node] - turned).norm() < 1e-14);
            checked += 1;
        }
        std::ops::ControlFlow::Continue(())
    });
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    assert_eq!(checked, 5 * edge.len());
    let last = history.last().expect("a step");
    assert!(last.min_j > 0.8, "{}", last.min_j);
    // pure bending: ½ EI/(1 − ν²) φ²/L
    let slender = 0.5 * 10.0 / 0.91 * 0.5f64.powi(3) / 12.0 / 4.0;
    let stored = last.stored_energy;
    assert!(relative(stored, slender) < 0.05, "{stored} for {slender}");
    // the work of the support is what the bar stores, to the order of the step
    let lost = |history: &History<2>| {
        let last = history.last().expect("a step");
        (last.work() - last.stored_energy) / last.stored_energy
    };
    let finer = Simulation::with_increments(10)
        .run(&mut problem)
        .expect("no misuse");
    let ratio = lost(&history) / lost(&finer);
    assert!((3.0..5.0).contains(&ratio), "{ratio}");
}

/// A block is pressed on a plane, and then both are turned by 2π about a point outside: the energy stays, and no work is
/// done, in steps of 22.5°.
#[test]
fn a_turn_with_an_obstacle_costs_nothing() {
    let full = std::f64::consts::TAU;
    let turn = || {
        let turn = Motion::<2>::rotation([3.0, -1.0], full).expect("a turn");
        turn.driven_by(table(&[(1.0, 0.0), (2.0, 1.0)]))
    };
    let press = Motion::<2>::translation([0.01, -0.1]).expect("a way");
    let press = press.driven_by(table(&[(0.0, 0.0), (1.0, 1.0)]));
    let mut body = block([0.0; 2], [1.0, 0.5], 0.125);
    body.prescribe_motion("top", press.then(turn()))
        .expect("support");
    let mut scene = Scene::new();
    let side = scene.add("block", body).on("bottom");
    // round, so that normals turn along the contact, too
    let drum = Obstacle::ball([0.5, -2.0], 2.0)
        .expect("a drum")
        .moving(turn());
    let drum = scene.obstacle("drum", side, drum).expect("a side");
    let phases = [Phase::new("press", 1.0, 2), Phase::new("turn", 2.0, 16)];
    let mut accurate = CondensedNewton::default();
    accurate.tolerance = 1e-10;
    let (problem, history) = complete_with(accurate, scene, &phases);
    let pressed = &history.steps[1];
    let force = pressed.obstacle_force(drum);
    assert!(force.norm() > 0.1, "{force}");
    for step in &history.steps[2..] {
        let change = (step.stored_energy - pressed.stored_energy) / pressed.stored_energy;
        assert!(change.abs() < 1e-8, "{change:e} at {}", step.factor);
        // what the solver leaves of the forces goes a long way
        let work = (step.work() - pressed.work()) / pressed.work();
        assert!(work.abs() < 1e-7, "{work:e} at {}", step.factor);
        let (sin, cos) = (full * (step.factor - 1.0)).sin_cos();
        let turned = [
            cos * force[0] - sin * force[1],
            sin * force[0] + cos * force[1],
        ];
        assert!(
            (step.obstacle_force(drum) - Vector::<2>::from(turned)).norm() < 1e-6 * force.norm()
        );
    }
    // back where it was
    let U = problem.displacements(&history.run.state.u);
    assert!(U.iter().all(|u| u.amax() < 0.5), "a full turn");
}

/// A wheel whose hub turns by 2π while its rim is pressed on a plane: the mesh is the same again after every other facet, and so
/// are energy and force. The rest of the way it is a mirror image, so that what a facet costs the next one gives back. Rolled
/// along the plane in place of turned, the wheel gets no force along it.
#[test]
fn a_wheel_turns_and_rolls_on_a_plane_for_nothing() {
    const FACETS: usize = 16;
    let full = std::f64::consts::TAU;
    let slide = |amplitude: f64| {
        let way = table(&[(1.0, 0.0), (2.0, amplitude)]);
        let press = Motion::<2>::translation([0.0, -0.1]).expect("a way");
        let press = press.driven_by(table(&[(0.0, 0.0), (1.0, 1.0)]));
        // clockwise, about the hub where the press has left it
        let turn = Motion::<2>::rotation([0.0, -0.1], -full).expect("a turn");
        let turn = turn.driven_by(table(&[(1.0, 0.0), (2.0, 1.0)]));
        let along = Motion::<2>::translation([full, 0.0]).expect("a way");
        let mesh = annulus(&[0.4, 0.6, 0.8, 1.0], FACETS, Diagonals::Alternating);
        let law = NeoHookean::new(10.0, 0.3).expect("law");
        let mut wheel = Body::new(mesh.expect("mesh"), law);
        wheel
            .prescribe_motion("inner", press.then(turn).then(along.driven_by(way)))
            .expect("support");
        let mut scene = Scene::new();
        let rim = scene.add("wheel", wheel).on("outer");
        let plane = Obstacle::half_space([0.0, -1.0], [0.0, 1.0]).expect("a half-plane");
        let plane = scene.obstacle("plane", rim, plane).expect("a side");
        // two steps a facet
        let phases = [
            Phase::new("press", 1.0, 2),
            Phase::new("turn", 2.0, 2 * FACETS),
        ];
        let mut accurate = CondensedNewton::default();
        accurate.tolerance = 1e-10;
        let (_, history) = complete_with(accurate, scene, &phases);
        let figures = history.steps[1..].iter().map(|step| {
            let force = step.obstacle_force(plane);
            assert!(force[0].abs() < 1e-12 && force[1] < -0.1, "{force}");
            [step.stored_energy, force[1], step.work()]
        });
        figures.collect::<Vec<_>>()
    };
    let [turned, rolled] = [0.0, 1.0].map(slide);
    let [energy, force, work] = turned[0];
    for (k, ([e, f, w], of_rolled)) in turned.iter().zip(&rolled).enumerate() {
        // the plane does not see whether the wheel moves along it
        assert!(
            relative(of_rolled[0], *e) < 1e-8 && relative(of_rolled[1], *f) < 1e-8,
            "{k}"
        );
        if k % 4 == 0 {
            assert!(relative(*e, energy) < 1e-8, "{k}: {e} for {energy}");
            assert!(relative(*f, force) < 1e-8, "{k}: {f} for {force}");
            assert!(relative(*w, work) < 1e-8, "{k}: {w} for {work}");
            assert!(
                relative(of_rolled[2], work) < 1e-8,
                "{k}: {} for {work}",
                of_rolled[2]
            );
        }
    }
    // in between, the wheel stands on a node or on a facet
    assert!(relative(turned[1][0], energy) > 1e-4, "{turned:?}");
}

/// A heavy block on the ground, and a rigid roll that is pressed into its top and moved along: the weight is there all the
/// time, and work is stored, to the order of the step.
#[test]
fn a_tool_moves_over_a_heavy_block() {
    let run = |steps: usize| {
        let mut body = block([0.0; 2], [3.0, 1.0], 0.125);
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let at_once = table(&[(0.0, 0.0), (1.0, 1.0)]);
        body.body_force_in_time([0.0, -0.3], at_once)
            .expect("weight");
        let mut scene = Scene::new();
        let block = scene.add("block", body);
        let down = Motion::<2>::translation([0.0, -0.15]).expect("a way");
        let along = Motion::<2>::translation([1.0, 0.0]).expect("a way");
        let way = down
            .driven_by(table(&[(1.0, 0.0), (2.0, 1.0)]))
            .then(along.driven_by(table(&[(2.0, 0.0), (3.0, 1.0)])));
        let roll = Obstacle::ball([1.0, 1.5], 0.5).expect("a roll").moving(way);
        let roll = scene
            .obstacle("roll", block.on("top"), roll)
            .expect("a side");
        let phases = [
            Phase::new("weight", 1.0, 2 * steps),
            Phase::new("press", 2.0, 4 * steps),
            Phase::new("move", 3.0, 8 * steps),
        ];
        let (_, history) = complete(scene, &phases);
        for step in &history.steps {
            // the ground carries the weight and what the roll presses
            let carried = step.reaction(block) - step.obstacle_force(roll);
            let weight = Vector::<2>::new(0.0, 0.9 * step.factor.min(1.0));
            assert!((carried - weight).norm() < 1e-7, "{carried} for {weight}");
        }
        let force = |step: usize| history.steps[step].obstacle_force(roll);
        assert_eq!(force(2 * steps - 1), Vector::<2>::zeros());
        let last = history.last().expect("a step");
        assert!(
            force(14 * steps - 1)[1] > 0.1,
            "what is done to the roll points up"
        );
        let pressed = &history.steps[6 * steps - 1];
        assert_eq!((pressed.factor, pressed.phase()), (2.0, "press"));
        [pressed, last].map(|step| (step.work() - step.stored_energy) / step.stored_energy)
    };
    let ([coarse, coarse_moved], [fine, fine_moved]) = (run(1), run(2));
    assert!(
        coarse.abs() < 0.02 && coarse_moved.abs() < 0.05,
        "{coarse} {coarse_moved}"
    );
    assert!(fine.abs() < 0.4 * coarse.abs(), "{coarse} {fine}");
    assert!(
        fine_moved.abs() < 0.6 * coarse_moved.abs(),
        "{coarse_moved} {fine_moved}"
    );
}

/// Paths of tractions and body forces are those of their sums in time; at small strains, too.
#[test]
fn forces_along_paths() {
    let law = contact_fem::LinearElastic::new(500.0, 0.2).expect("law");
    let end = |is_path: bool| {
        let mesh = rectangle(&linspace(0.0, 2.0, 4), &[0.0, 0.5, 1.0], Diagonals::Rising);
        let mut body = Body::new(mesh.expect("mesh"), law);
        body.prescribe("left", [Some(0.0); 2]).expect("support");
        body.traction("top", [0.1, 0.2]).expect("a traction");
        if is_path {
            body.traction_path("right", |t, _| Vector::<2>::new(t * t, 1.0))
                .expect("a traction");
            body.body_force_path(|t, X| Vector::<2>::new(0.0, t * X[0]))
                .expect("a force");
        } else {
            let square = Amplitude::of(|t| t * t);
            body.traction_in_time("right", [1.0, 0.0], square)
                .expect("a traction");
            body.traction_in_time("right", [0.0, 1.0], 1.0)
                .expect("a traction");
            body.body_force_field(|X| Vector::<2>::new(0.0, X[0]))
                .expect("a force");
        }
        let mut scene = Scene::new();
        scene.add("body", body);
        let phases = [Phase::new("all", 1.7, 3)];
        let (problem, history) = complete(scene, &phases);
        let last = history.last().expect("a step");
        let U = problem.displacements(&history.run.state.u);
        (
            U[problem.reference().len() - 1],
            last.energy,
            last.reaction(0),
        )
    };
    let [(u, energy, reaction), (v, expected, force)] = [true, false].map(end);
    assert!((u - v).norm() < 1e-12 * v.norm() && relative(energy, expected) < 1e-12);
    assert!((reaction - force).norm() < 1e-10);
    // 0.1 t · 2 + t² and 0.2 t · 2 + 1 + 2 t, at t = 1.7
    assert!((reaction[0] + 0.34 + 2.89).abs() < 1e-10, "{reaction}");
    assert!((reaction[1] + 0.68 + 1.0 + 3.4).abs() < 1e-10, "{reaction}");
}

/// What a program says is checked where a run comes to.
#[test]
fn wrong_programs() {
    let body = || block([0.0; 2], [1.0; 2], 0.5);
    let nan = body()
        .prescribe_path("top", |_, _| Vector::<2>::repeat(f64::NAN))
        .err();
    assert!(
        nan.expect("refused")
            .to_string()
            .contains("prescribed displacement [0] = NaN")
    );
    let nan = body()
        .traction_path("top", |t, _| Vector::<2>::repeat(1.0 / (t - 0.5)))
        .err();
    assert!(nan.expect("refused").to_string().contains("traction ["));
    let mut twice = body();
    let turn = |angle: f64| Motion::<2>::rotation([0.5, 0.5], angle).expect("a turn");
    twice.prescribe_motion("top", turn(0.3)).expect("support");
    twice
        .prescribe_motion("right", turn(0.3))
        .expect("the same corner");
    let conflict = twice.prescribe_motion("left", turn(0.4)).err();
    assert!(
        conflict
            .expect("refused")
            .to_string()
            .contains("prescribed twice")
    );

    let mut late = body();
    late.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let root = Amplitude::of(|t| (1.5 - t).sqrt());
    late.traction_in_time("top", [0.0, 0.1], root)
        .expect("a traction");
    let mut scene = Scene::new();
    scene.add("late", late);
    let mut problem = scene.problem().expect("a scene");
    let phases = [Phase::new("one", 1.0, 1), Phase::new("two", 2.0, 1)];
    let history = Simulation::in_phases(phases)
        .run(&mut problem)
        .expect("a first step");
    let ending = history.run.ending.to_string();
    assert_eq!(history.steps.len(), 1);
    assert!(
        ending.contains("forces of body `late` at load factor 2"),
        "{ending}"
    );
}
