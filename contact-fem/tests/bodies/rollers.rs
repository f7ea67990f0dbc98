//! Supports along directions that are no axes: scenes that are turned with all that holds and loads them, against those that are not.
#![allow(non_snake_case)]

use contact_core::{Energy, LoadStepped, check};
use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Geometry, Problem};
use contact_fem::simulation::{History, StepRecord};
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, NeoHookean, Obstacle, Phase, Scene, Simulation,
};

const E: f64 = 100.0;
const NU: f64 = 0.3;

fn turn(degrees: f64) -> Matrix<2> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Matrix::<2>::new(cos, -sin, sin, cos)
}

/// About (1, 1, 1) by 40°.
fn turn_in_space() -> Matrix<3> {
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    let n = Vector::<3>::repeat(1.0 / 3.0_f64.sqrt());
    Matrix::<3>::identity() * cos + n.cross_matrix() * sin + n * n.transpose() * (1.0 - cos)
}

fn run<const D: usize>(problem: &mut Problem<D>, increments: usize) -> History<D> {
    let history = Simulation::with_increments(increments).run(problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("a step");
    assert!(certificate.holds(&Limits::default()), "{certificate}");
    history
}

fn reaction<const D: usize>(record: &StepRecord<D>, body: usize, boundary: &str) -> Vector<D> {
    let mut own = record.support_reactions.iter();
    let own = own.find(|(side, _)| side.body.index() == body && side.boundary == boundary);
    own.expect("known").1
}

fn largest<const D: usize>(a: &[Vector<D>], b: impl Iterator<Item = Vector<D>>) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).norm());
    off.fold(0.0, f64::max)
}

/// A block of 1 by 1 on another of 2 by 1, both on rollers at their left and held apart at bottom and top: the upper one is pressed
/// down by `by` along its top and pushed aside there. All of it is turned by R; axes are the supports where R is 1.
fn pressed(R: &Matrix<2>, by: f64, small: bool) -> (Problem<2>, History<2>) {
    let block = |low: [f64; 2], size: [f64; 2], cells: [usize; 2]| {
        let [xs, ys] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh");
        let mesh = mesh.mapped(|X| R * X).expect("turned");
        match small {
            true => Body::new(mesh, LinearElastic::new(E, NU).expect("a law")),
            false => Body::new(mesh, NeoHookean::new(E, NU).expect("a law")),
        }
    };
    let [x, y] = [0, 1].map(|i| [R[(0, i)], R[(1, i)]]);
    let mut lower = block([0.0, 0.0], [2.0, 1.0], [6, 3]);
    lower.prescribe_along("bottom", y, 0.0).expect("rollers");
    lower.prescribe_along("left", x, 0.0).expect("rollers");
    let mut upper = block([0.0, 1.0], [1.0, 1.0], [4, 3]);
    upper.prescribe_along("top", y, -by).expect("pressed");
    upper.prescribe_along("left", x, 0.0).expect("rollers");
    let aside = R * Vector::<2>::new(0.2 * E * by, 0.0);
    upper
        .traction("right", [aside[0], aside[1]])
        .expect("loaded");
    let mut scene = Scene::new();
    let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    if !small {
        scene.geometry = Some(Geometry::Current);
    }
    let mut problem = scene.problem().expect("a problem");
    let history = run(&mut problem, 3);
    (problem, history)
}

#[test]
fn turned_contact_is_the_same() {
    for (small, by) in [(true, 0.01), (false, 0.2)] {
        let (straight, expected) = pressed(&Matrix::<2>::identity(), by, small);
        let of = |problem: &Problem<2>, history: &History<2>| {
            problem.displacements(&history.run.state.u)
        };
        let there = of(&straight, &expected);
        let last = expected.last().expect("a step");
        assert!(last.contact_force(1)[1] > 0.1 * E * by);
        let iterations = |history: &History<2>| -> Vec<usize> {
            let steps = history.steps.iter();
            steps.map(|step| step.attempt.iterations.len()).collect()
        };
        for degrees in [30.0, 45.0, 117.0, -80.0] {
            let R = turn(degrees);
            let (problem, history) = pressed(&R, by, small);
            assert_eq!(problem.dofs().free(), straight.dofs().free());
            let off = largest(&of(&problem, &history), there.iter().map(|u| R * u));
            println!("small {small}, {degrees}°: {:.1e}", off / by);
            assert!(off < 1e-10 * by, "{degrees}: {off:.1e}");
            // changes of components are compared with the tolerance, which differ where they are turned
            let mut counts = iterations(&history).into_iter().zip(iterations(&expected));
            assert!(
                counts.all(|(found, expected)| found <= expected + 1),
                "{degrees}"
            );
            let record = history.last().expect("a step");
            assert!((record.energy / last.energy - 1.0).abs() < 1e-9);
            assert!((record.stored_energy / last.stored_energy - 1.0).abs() < 1e-9);
            assert!((record.work() / last.work() - 1.0).abs() < 1e-9);
            for (body, side) in [(0, "bottom"), (0, "left"), (1, "top"), (1, "left")] {
                let [found, expected] = [record, last].map(|record| reaction(record, body, side));
                let off = (found - R * expected).norm();
                assert!(off < 1e-8 * E * by, "{degrees} {body} {side}: {off:.1e}");
            }
            for body in 0..2 {
                let off = record.reaction(body) - R * last.reaction(body);
                assert!(off.norm() < 1e-8 * E * by);
                let off = record.contact_force(body) - R * last.contact_force(body);
                assert!(off.norm() < 1e-8 * E * by);
            }
        }
    }
}

/// A wedge between two planes of rollers that meet in its edge is pressed on its back by p: u = −p (1 + ν) (1 − 2ν)/E x, and either plane
/// carries p times its length along its normal.
#[test]
fn a_wedge_shrinks_towards_its_edge() {
    let (p, alpha) = (2.0, 0.6_f64);
    let (sin, cos) = alpha.sin_cos();
    let mesh = rectangle(
        &linspace(0.0, 1.0, 4),
        &linspace(0.0, 1.0, 4),
        Diagonals::Rising,
    )
    .expect("a mesh")
    .mapped(|X| {
        let r = 1.0 + X[0];
        // between radii 1 and 2, on chords: a truncated wedge
        let mix = |a: f64, b: f64| (1.0 - X[1]) * a + X[1] * b;
        Vector::<2>::new(r * mix(1.0, cos), r * mix(0.0, sin))
    })
    .expect("a wedge");
    let mut wedge = Body::new(mesh, LinearElastic::new(E, NU).expect("a law"));
    wedge
        .prescribe("bottom", [None, Some(0.0)])
        .expect("rollers");
    wedge
        .prescribe_along("top", [-5.0 * sin, 5.0 * cos], 0.0)
        .expect("rollers");
    wedge
        .pressure("left", p)
        .expect("pressed")
        .pressure("right", p)
        .expect("pressed");
    let mut scene = Scene::new();
    scene.add("wedge", wedge);
    let mut problem = scene.problem().expect("a problem");
    let history = run(&mut problem, 1);
    let shrinks = p * (1.0 + NU) * (1.0 - 2.0 * NU) / E;
    let exact = problem.reference().iter().map(|X| -X * shrinks);
    let off = largest(&problem.displacements(&history.run.state.u), exact);
    assert!(off < 1e-14, "{off:.1e}");
    let last = history.last().expect("a step");
    let (lower, upper) = (reaction(last, 0, "bottom"), reaction(last, 0, "top"));
    assert!((lower - Vector::<2>::new(0.0, p)).norm() < 1e-12, "{lower}");
    assert!(
        (upper - Vector::<2>::new(sin, -cos) * p).norm() < 1e-12,
        "{upper}"
    );
}

/// A plane of symmetry that no axis is perpendicular to is found from its nodes.
#[test]
fn planes_of_symmetry_of_any_direction() {
    let alpha = 0.6_f64;
    let at = |phi: f64| Vector::<2>::new(phi.cos(), phi.sin());
    let wedge = |from: f64, to: f64, cells: usize| {
        let across = linspace(0.0, 1.0, cells);
        let mesh = rectangle(&linspace(1.0, 2.0, 4), &across, Diagonals::Rising).expect("a mesh");
        let mesh = mesh.mapped(|X| (at(from) * (1.0 - X[1]) + at(to) * X[1]) * X[0]);
        Body::new(
            mesh.expect("a wedge"),
            NeoHookean::new(E, NU).expect("a law"),
        )
    };
    let mut half = wedge(0.0, alpha, 3);
    half.symmetry("bottom")
        .expect("an axis")
        .symmetry("top")
        .expect("a plane");
    half.traction("right", (-20.0 * at(0.5 * alpha)).into())
        .expect("pushed");
    let mut other = wedge(0.0, alpha, 3);
    let (sin, cos) = alpha.sin_cos();
    other
        .prescribe("bottom", [None, Some(0.0)])
        .expect("rollers");
    other
        .prescribe_along("top", [-sin, cos], 0.0)
        .expect("rollers");
    other
        .traction("right", (-20.0 * at(0.5 * alpha)).into())
        .expect("pushed");
    let state = |body: Body<2>| {
        let mut scene = Scene::new();
        scene.add("wedge", body);
        let mut problem = scene.problem().expect("a problem");
        let history = run(&mut problem, 1);
        problem.displacements(&history.run.state.u)
    };
    let off = largest(&state(half), state(other).into_iter());
    assert!(off < 1e-13, "{off:.1e}");
    let mut bent = {
        let mesh = square()
            .mesh()
            .clone()
            .mapped(|X| Vector::<2>::new(X[0] + 0.1 * X[1] * X[1], X[1] + 0.3 * X[0]));
        Body::new(
            mesh.expect("bent"),
            LinearElastic::new(E, NU).expect("a law"),
        )
    };
    bent.symmetry("left").err().expect("it is curved");
}

/// An eighth of a block in space, pushed askew, with quadratic cells: three planes of rollers, two or three of which hold edges and
/// the corner.
#[test]
fn turned_blocks_in_space_are_the_same() {
    for small in [true, false] {
        let state = |R: &Matrix<3>| {
            let mesh = cuboid([0.0; 3], [1.0, 1.2, 0.8], [2, 2, 1]).expect("a mesh");
            let mesh = mesh.quadratic().mapped(|X| R * X).expect("turned");
            let mut block = match small {
                true => Body::new(mesh, LinearElastic::new(E, NU).expect("a law")),
                false => Body::new(mesh, NeoHookean::new(E, NU).expect("a law")),
            };
            let along = |i: usize| [0, 1, 2].map(|k| R[(k, i)]);
            for (side, i) in [("left", 0), ("front", 1), ("bottom", 2)] {
                block.prescribe_along(side, along(i), 0.0).expect("rollers");
            }
            let there = Amplitude::table(&[(0.0, 0.0), (1.0, -0.1)]).expect("a table");
            block
                .prescribe_along_in_time("top", along(2), 1.0, there)
                .expect("pressed");
            let push = R * Vector::<3>::new(5.0, -3.0, 0.0);
            block.traction("right", push.into()).expect("pushed");
            let mut scene = Scene::new();
            scene.add("block", block);
            let mut problem = scene.problem().expect("a problem");
            let history = run(&mut problem, 2);
            let last = history.last().expect("a step");
            let sides = ["left", "front", "bottom", "top"].map(|side| reaction(last, 0, side));
            (
                problem.displacements(&history.run.state.u),
                sides,
                last.work(),
            )
        };
        let R = turn_in_space();
        let (there, expected, work) = state(&Matrix::<3>::identity());
        let (turned, sides, turned_work) = state(&R);
        let off = largest(&turned, there.iter().map(|u| R * u));
        println!("small {small}: {off:.1e}");
        assert!(off < 1e-10, "{off:.1e}");
        for (i, (found, expected)) in [0, 1, 2, 2].iter().zip(sides.iter().zip(&expected)) {
            assert!((found - R * expected).norm() < 1e-8, "{found} {expected}");
            let n = R.column(*i);
            assert!(
                found.cross(&n).norm() < 1e-9 * found.norm().max(1.0),
                "along n"
            );
        }
        assert!((turned_work / work - 1.0).abs() < 1e-9);
    }
}

/// Derivatives of an energy whose unknowns follow others.
#[test]
fn derivatives_with_ties() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 2),
        &linspace(0.0, 1.0, 2),
        Diagonals::Alternating,
    );
    let mut block = Body::new(
        mesh.expect("a mesh"),
        NeoHookean::new(E, NU).expect("a law"),
    );
    block
        .prescribe_along("bottom", [1.0, 3.0], 0.1)
        .expect("rollers");
    block
        .prescribe_along("left", [3.0, -1.0], 0.0)
        .expect("rollers");
    block.foundation("right", 5.0).expect("springs");
    let mut scene = Scene::new();
    scene.add("block", block);
    let mut problem = scene.problem().expect("a problem");
    problem.set_load(0.7).expect("a load");
    let u: Vec<f64> = (0..problem.dofs().free())
        .map(|k| 0.02 * (k as f64).sin())
        .collect();
    let energy: &dyn Energy = &problem.body_energies()[0];
    let found = check::energy(energy, &u, 1e-5);
    println!("{found:?}");
    assert!(
        found.gradient < 1e-7 && found.hessian < 1e-6 && found.outside_pattern < 1e-6,
        "{found:?}"
    );
    // on both planes
    let moved = problem.displacements(&u);
    let mesh = problem.scene().bodies()[0].mesh();
    for (side, n, value) in [("bottom", [1.0, 3.0], 0.07), ("left", [3.0, -1.0], 0.0)] {
        let n = Vector::<2>::from(n).normalize();
        for node in mesh.boundary_nodes(side).expect("a side") {
            assert!((moved[node].dot(&n) - value).abs() < 1e-15, "{side} {node}");
        }
    }
}

fn square() -> Body<2> {
    let mesh = rectangle(
        &linspace(-1.0, 1.0, 2),
        &linspace(-1.0, 1.0, 2),
        Diagonals::Rising,
    );
    Body::new(
        mesh.expect("a mesh"),
        LinearElastic::new(E, NU).expect("a law"),
    )
}

fn refused(body: Body<2>) -> Option<String> {
    let mut scene = Scene::new();
    scene.add("square", body);
    scene.problem().err().map(|error| error.to_string())
}

/// Motions that rollers leave free are found, though as many components are prescribed as there are motions.
#[test]
fn what_rollers_leave_free() {
    let mut one = square();
    one.prescribe_along("bottom", [1.0, 1.0], 0.0)
        .expect("rollers");
    let told = refused(one).expect("it slides");
    assert!(told.contains("translation along (0.707, -0.707)"), "{told}");
    // nodes 0, 2 and 7 at (−1, −1), (1, −1) and (0, 1)
    let at = |directions: [[f64; 2]; 3]| {
        let mut body = square();
        for (node, direction) in [0, 2, 7].into_iter().zip(directions) {
            body.prescribe_nodes_along(&[node], direction, 0.0)
                .expect("a roller");
        }
        refused(body)
    };
    // towards (0, 0.4) and beside it
    let told = at([[1.0, 1.4], [-1.0, 1.4], [0.0, -0.6]]).expect("it turns");
    assert!(
        told.contains("1 of 3") && told.contains("rotation"),
        "{told}"
    );
    assert_eq!(at([[1.0, 1.4], [-1.0, 1.4], [0.3, -0.6]]), None);
}

/// Supports that contradict each other are refused, and leave the body as it was; those that repeat others are none.
#[test]
fn supports_that_meet() {
    let is_conflict = |error: Option<Error>| matches!(error, Some(Error::Conflict { .. }));
    let mut body = square();
    body.prescribe("left", [Some(0.1), Some(0.2)])
        .expect("held");
    assert!(is_conflict(
        body.prescribe_along("bottom", [3.0, 4.0], 0.5).err()
    ));
    assert_eq!(body.prescribed().iter().flatten().count(), 6);
    body.prescribe_along("bottom", [3.0, 4.0], 0.22)
        .expect("0.6 · 0.1 + 0.8 · 0.2");
    assert_eq!(body.prescribed().iter().flatten().count(), 6 + 2);
    // in the other order
    let mut body = square();
    body.prescribe_along("bottom", [3.0, 4.0], 0.5)
        .expect("rollers");
    let before = body.prescribed().to_vec();
    assert!(is_conflict(
        body.prescribe("left", [Some(0.1), Some(0.2)]).err()
    ));
    assert_eq!(body.prescribed(), before);
    body.prescribe("left", [Some(0.1), None]).expect("held");
    // the corner is where both hold it
    let corner = [body.prescribed()[0], body.prescribed()[1]].map(|u| u.expect("held"));
    assert!((0.6 * corner[0] + 0.8 * corner[1] - 0.5).abs() < 1e-15 && corner[0] == 0.1);

    for direction in [[0.0, 0.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
        assert!(
            square().prescribe_along("bottom", direction, 0.0).is_err(),
            "{direction:?}"
        );
    }
    assert!(
        square()
            .prescribe_along("bottom", [1.0, 1.0], f64::NAN)
            .is_err()
    );
    assert!(
        square()
            .prescribe_along("nowhere", [1.0, 1.0], 0.0)
            .is_err()
    );
    assert!(
        square()
            .prescribe_nodes_along(&[99], [1.0, 1.0], 0.0)
            .is_err()
    );
    assert!(
        square()
            .prescribe_nodes_along(&[], [1.0, 1.0], 0.0)
            .is_err()
    );
    let switched = |first: bool| -> Result<(), Error> {
        let mut body = square();
        let along =
            |body: &mut Body<2>| body.prescribe_along("bottom", [1.0, 1.0], 0.0).map(|_| ());
        if first {
            along(&mut body)?;
        }
        body.during(&[[0.0, 1.0]], |body| {
            body.prescribe("left", [Some(0.0), None])
        })?;
        along(&mut body)
    };
    for first in [true, false] {
        assert!(
            matches!(switched(first), Err(Error::NotSwitched { .. })),
            "{first}"
        );
    }
    // a support of an axis in other words
    let mut body = square();
    body.prescribe_along("bottom", [0.0, -2.0], 0.1)
        .expect("an axis");
    assert_eq!(body.prescribed()[1], Some(-0.1));
    let mut scene = Scene::new();
    body.prescribe("left", [Some(0.0), None]).expect("held");
    scene.add("square", body);
    assert!(scene.problem().expect("a problem").dofs().ties().is_empty());
}

/// A block goes down a slope on rollers onto a stop, and its rollers stay while another support lets go.
#[test]
fn rollers_stay_where_others_let_go() {
    let (sin, cos) = 0.5_f64.sin_cos();
    let n = [sin, cos];
    let mut block = square();
    block.prescribe_along("bottom", n, 0.0).expect("rollers");
    // away from the bottom
    let held: Vec<usize> = (6..9).collect();
    block
        .during(&[[0.0, 1.0]], |block| {
            block.prescribe_nodes(&held, [Some(0.0); 2])
        })
        .expect("switched");
    block.foundation("left", 20.0).expect("springs");
    block.body_force([0.0, -1.0]).expect("a weight");
    let mut scene = Scene::new();
    scene.add("block", block);
    let mut problem = scene.problem().expect("a problem");
    let phases = [Phase::new("hold", 1.0, 1), Phase::new("let go", 2.0, 2)];
    let history = Simulation::in_phases(phases)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete());
    assert!(
        history
            .certificate()
            .expect("steps")
            .holds(&Limits::default())
    );
    for record in &history.steps {
        let by = reaction(record, 0, "bottom");
        assert!((by[0] * cos - by[1] * sin).abs() < 1e-10, "along n");
        let weight = 4.0 * record.factor;
        assert!((record.reaction(0) - Vector::<2>::new(0.0, weight)).norm() < 1e-9);
        let left = record.work() - record.stored_energy;
        assert!(left.abs() < 1e-10 * record.stored_energy, "{left:.1e}");
    }
    assert_eq!(reaction(&history.steps[2], 0, "nodes 6, 7, 8").norm(), 0.0);
}

/// A turned punch: rollers guide a block onto a rigid half-space across them.
#[test]
fn guided_onto_an_obstacle() {
    let contact = |R: &Matrix<2>| {
        let mesh = rectangle(
            &linspace(0.0, 1.0, 3),
            &linspace(0.0, 1.0, 3),
            Diagonals::Rising,
        );
        let mesh = mesh.expect("a mesh").mapped(|X| R * X).expect("turned");
        let mut block = Body::new(mesh, NeoHookean::new(E, NU).expect("a law"));
        let [x, y] = [0, 1].map(|i| [R[(0, i)], R[(1, i)]]);
        block.prescribe_along("left", x, 0.0).expect("guided");
        let push = R * Vector::<2>::new(0.0, -20.0);
        block.traction("top", push.into()).expect("pushed");
        let mut scene = Scene::new();
        let block = scene.add("block", block);
        let point = R * Vector::<2>::new(0.0, 0.0);
        let floor = Obstacle::half_space(point.into(), y).expect("a floor");
        scene
            .obstacle("floor", block.on("bottom"), floor)
            .expect("a side");
        let mut problem = scene.problem().expect("a problem");
        let history = run(&mut problem, 2);
        problem.displacements(&history.run.state.u)
    };
    let there = contact(&Matrix::<2>::identity());
    let R = turn(33.0);
    let off = largest(&contact(&R), there.iter().map(|u| R * u));
    println!("{off:.1e}");
    assert!(off < 1e-10, "{off:.1e}");
}

/// The fixed point with Ipopt finds the same.
#[cfg(feature = "ipopt")]
#[test]
fn the_fixed_point_finds_the_same() {
    use contact_core::{FixedPoint, InteriorPoint};
    let build = || {
        let mesh = rectangle(
            &linspace(0.0, 1.0, 3),
            &linspace(0.0, 1.0, 3),
            Diagonals::Rising,
        );
        let R = turn(33.0);
        let mesh = mesh.expect("a mesh").mapped(|X| R * X).expect("turned");
        let mut block = Body::new(mesh, NeoHookean::new(E, NU).expect("a law"));
        block
            .prescribe_along("left", [R[(0, 0)], R[(1, 0)]], 0.0)
            .expect("guided");
        block
            .prescribe_along("top", [R[(0, 1)], R[(1, 1)]], -0.2)
            .expect("pushed");
        let mut scene = Scene::new();
        let block = scene.add("block", block);
        let ball = R * Vector::<2>::new(0.5, -1.0);
        let ball = Obstacle::ball(ball.into(), 1.0).expect("a ball");
        scene
            .obstacle("ball", block.on("bottom"), ball)
            .expect("a side");
        scene.problem().expect("a problem")
    };
    let mut problem = build();
    let newton = run(&mut problem, 2);
    let mut problem = build();
    let solver = FixedPoint::with(InteriorPoint::default());
    let history = Simulation::solved_by(solver, 2)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let u = problem.displacements(&newton.run.state.u);
    let off = largest(&u, problem.displacements(&history.run.state.u).into_iter());
    println!("{off:.1e}");
    assert!(off < 1e-7, "{off:.1e}");
}

/// Two supports along directions that are close move a node by what their values leave over the sine of the angle. Beyond 20 times the
/// values they are refused, with boundaries, place, angle and values at full load.
#[test]
fn supports_that_are_nearly_parallel() {
    let held = |by: f64, angle: f64| {
        let mut body = square();
        body.prescribe_along("left", [1.0, 0.0], 0.1)
            .expect("rollers");
        let (sin, cos) = angle.sin_cos();
        let held = body.prescribe_along("bottom", [cos, sin], by).err();
        (held, body)
    };
    for angle in [1e-3, 1e-7] {
        let (refused, body) = held(0.2, angle);
        let Some(Error::NearlyParallel {
            on,
            angle: found,
            first,
            second,
            displacement,
            at,
            ..
        }) = refused
        else {
            panic!("{refused:?}");
        };
        assert_eq!(*on, ["left", "bottom"].map(String::from));
        assert!((found.to_radians() / angle - 1.0).abs() < 1e-6, "{found}");
        assert_eq!([first, second, at], [0.1, 0.2, 1.0]);
        let (sin, cos) = angle.sin_cos();
        let exact = (0.2 - 0.1 * cos) / sin;
        assert!((displacement / exact - 1.0).abs() < 1e-6, "{displacement}");
        // it is left as it was
        assert_eq!(body.prescribed(), {
            let mut alone = square();
            let rollers = alone.prescribe_along("left", [1.0, 0.0], 0.1);
            rollers.expect("rollers").prescribed().to_vec()
        });
        // the displacement (0.1, 0.03) along both
        let (fits, body) = held(0.1 * cos + 0.03 * sin, angle);
        assert!(fits.is_none(), "{fits:?}");
        let corner = body.prescribed()[1].expect("held");
        // the sum loses what it has to beside 0.1
        assert!((corner - 0.03).abs() < 1e-15 / angle, "{corner}");
    }
    // at 30°, ten times the value is sound
    let (fits, _) = held(0.9, 30.0_f64.to_radians());
    assert!(fits.is_none(), "{fits:?}");
}

/// What is prescribed twice is told by boundaries, place and direction, at the load factor at which it differs.
#[test]
fn conflicts_name_supports() {
    let mut body = square();
    body.prescribe("left", [Some(0.1), None]).expect("held");
    let refused = body.prescribe_along("bottom", [-2.0, 0.0], 0.1).err();
    let told = refused.expect("a conflict").to_string();
    let expected = "along x of the node at [-1.0, -1.0] is prescribed twice, by the supports on `left` and on `bottom`: 0.1 and -0.1 at load \
                    factor 1;";
    assert!(told.contains(expected), "{told}");
    // both are 0 at the end
    let back = Amplitude::table(&[(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)]).expect("a table");
    let mut body = square();
    body.prescribe("left", [Some(0.0), Some(0.0)])
        .expect("held");
    let refused = body
        .prescribe_along_in_time("bottom", [3.0, 4.0], 0.5, back)
        .err();
    let told = refused.expect("a conflict").to_string();
    assert!(told.contains("along [0.6000, 0.8000]"), "{told}");
    // the last of the sixteenths
    assert!(
        told.contains(": 0 and 0.0625 at load factor 0.9375;"),
        "{told}"
    );
}
