//! Surfaces, passes and depths of small scenes.

use contact_core::equilibrium::Solution;
use contact_core::{ContactProblem, LoadStepped, Outcome, State};

use super::*;
use crate::certificate::Certificate;
use crate::mesh::generators::{Diagonals, rectangle};
use crate::model::{Body, Problem};
use crate::output::Snapshot;
use crate::{LinearElastic, NeoHookean};

/// Two unit squares on each other, the lower one held, the upper one to be pushed by 0.1.
fn squares(geometry: Geometry, passes: Passes) -> Problem<2> {
    let body = |y: f64, side: &str, push: f64| {
        let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 1.0], Diagonals::Rising);
        let mesh = mesh.expect("mesh");
        let mut body = match geometry {
            Geometry::Reference => Body::new(mesh, LinearElastic::new(1.0, 0.0).expect("law")),
            Geometry::Current => Body::new(mesh, NeoHookean::new(1.0, 0.0).expect("law")),
        };
        let pushed = [Some(0.0), Some(-push)];
        body.prescribe(side, pushed).expect("support");
        body
    };
    let mut scene = Scene::new();
    let lower = scene.add("lower", body(0.0, "bottom", 0.0)).on("top");
    let upper = scene.add("upper", body(1.0, "top", 0.1)).on("bottom");
    scene
        .contact_in_passes(lower.clone(), upper.clone(), passes)
        .expect("a pair");
    scene
        .contact_in_passes(upper, lower, Passes::FirstIsSlave)
        .expect("a pair");
    scene.problem().expect("a problem")
}

#[test]
fn a_surface_that_two_pairs_name_is_there_once() {
    let roles = |passes| {
        let problem = squares(Geometry::Current, passes);
        assert_eq!(problem.surfaces().len(), 2);
        let roles = problem.passes().iter().map(|p| (p.slave, p.master));
        roles.collect::<Vec<_>>()
    };
    assert_eq!(roles(Passes::Both), [(0, 1), (1, 0), (1, 0)]);
    assert_eq!(roles(Passes::FirstIsSlave), [(0, 1), (1, 0)]);
    assert_eq!(roles(Passes::SecondIsSlave), [(1, 0), (1, 0)]);
}

/// The upper square pushed into the lower one by 0.1.
#[test]
fn depths_in_either_geometry() {
    for geometry in [Geometry::Reference, Geometry::Current] {
        let mut problem = squares(geometry, Passes::Both);
        problem.set_load(1.0).expect("load");
        let mut u = vec![0.0; problem.dofs().free()];
        let upper = problem.nodes(1);
        problem
            .kinematics
            .add_free(1, &[0.0, -0.1].repeat(upper.len()), &mut u);
        assert!((problem.penetration(&u) - 0.1).abs() < 1e-14);
        assert!((problem.relative_penetration(&u) - 0.2).abs() < 1e-14);
        assert_eq!(problem.tunnels(&u, &u, 1.0), None);
        // facets are 0.5 long
        problem
            .kinematics
            .add_free(1, &[0.0, -0.5].repeat(upper.len()), &mut u);
        let passage = problem.tunnels(&u, &u, 1.0).expect("through");
        assert!(passage.depth > 0.3, "{passage:?}");
    }
}

/// All queries of a converged state, with a query of another state before and after.
#[test]
fn one_set_of_trees_a_state() {
    for (geometry, sets) in [
        (Geometry::Reference, [1, 1, 1]),
        (Geometry::Current, [1, 2, 3]),
    ] {
        let mut problem = squares(geometry, Passes::FirstIsSlave);
        assert_eq!(problem.searches_built(), 1, "the check for overlap");
        let rest = vec![0.0; problem.dofs().free()];
        problem
            .linearize_gaps(&rest, Sampling::Nodes)
            .expect("rows");
        assert_eq!(
            problem.searches_built(),
            sets[0],
            "at rest all is where it was"
        );
        problem.set_load(1.0).expect("load");
        let gaps = problem.rows(&rest, Sampling::Nodes).expect("a state");
        assert_eq!(problem.searches_built(), sets[1]);
        let mut u = rest.clone();
        u[0] += 1e-3;
        let solution = Solution {
            failed: Vec::new(),
            curvature: None,
            flickering: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction: None,
            lambda: vec![1.0; gaps.len()],
            state: State {
                u,
                ..State::default()
            },
            gaps,
            outcome: Outcome::Converged,
            energy: 0.0,
            history: Vec::new(),
        };
        problem.tunnels(&solution.state.u, &rest, 0.0);
        problem.penetration(&solution.state.u);
        Certificate::new(&problem, &solution);
        Snapshot::new(&problem, &solution).expect("pressures");
        problem
            .rows(&solution.state.u, Sampling::Nodes)
            .expect("a state");
        assert_eq!(problem.searches_built(), sets[2]);
    }
}

/// Depths of nodes are told however short the reach of the constraints is.
#[test]
fn depths_beyond_the_reach() {
    for geometry in [Geometry::Reference, Geometry::Current] {
        let mut scene = squares(geometry, Passes::Both).scene;
        scene.reach = Some(0.01);
        let mut problem = scene.problem().expect("a problem");
        problem.set_load(1.0).expect("load");
        let mut u = vec![0.0; problem.dofs().free()];
        let moved = [0.0, -0.1].repeat(problem.nodes(1).len());
        problem.kinematics.add_free(1, &moved, &mut u);
        assert!(
            (problem.penetration(&u) - 0.1).abs() < 1e-14,
            "{geometry:?}"
        );
    }
}

/// Two squares whose surfaces are drawn to twice their length: the rows stand for what was there.
#[test]
fn rows_have_the_measure_of_the_reference() {
    let problem = squares(Geometry::Current, Passes::Both);
    let mut u = vec![0.0; problem.dofs().free()];
    for body in 0..2 {
        let nodes = problem.nodes(body);
        let drawn: Vec<f64> = nodes
            .flat_map(|a| [problem.reference()[a][0], 0.0])
            .collect();
        problem.kinematics.add_free(body, &drawn, &mut u);
    }
    for sampling in [Sampling::Nodes, Sampling::Points] {
        let rows = problem.rows(&u, sampling).expect("a state");
        let total: f64 = rows.weights().iter().sum();
        assert!(
            (total - 3.0).abs() < 1e-12,
            "three passes, {sampling:?}: {total}"
        );
    }
}

/// Half of a surface beside the other one: its points keep the numbers that they have on all of it.
#[test]
fn points_keep_their_numbers() {
    let numbers = |shift: f64| {
        let square = |x: f64, y: f64, side: &str| {
            let xs = [x, x + 0.5, x + 1.0];
            let mesh = rectangle(&xs, &[y, y + 1.0], Diagonals::Rising).expect("mesh");
            let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.0).expect("law"));
            body.prescribe(side, [Some(0.0); 2]).expect("support");
            body
        };
        let mut scene = Scene::new();
        let lower = scene.add("lower", square(0.0, 0.0, "bottom")).on("top");
        let upper = scene.add("upper", square(shift, 1.0, "top")).on("bottom");
        let passes = Passes::FirstIsSlave;
        scene
            .contact_in_passes(lower, upper, passes)
            .expect("a pair");
        scene.integration = Some(Integration::Gauss(4));
        let problem = scene.problem().expect("a problem");
        let rest = vec![0.0; problem.dofs().free()];
        let rows = problem.rows(&rest, Sampling::Points).expect("a state");
        let numbers = rows.keys().iter().map(|key| key.node);
        numbers.collect::<Vec<_>>()
    };
    let mut both = [numbers(0.5), numbers(-0.5)].concat();
    both.sort_unstable();
    // two facets of four points each
    assert_eq!(both, (0..8).collect::<Vec<_>>());
    assert_eq!(numbers(0.0), both);
}

/// No row is between nodes that are all held.
#[test]
fn rows_between_held_nodes_are_left_out() {
    let square = |y: f64, is_held: bool| {
        let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 1.0], Diagonals::Rising);
        let mut body = Body::new(
            mesh.expect("mesh"),
            LinearElastic::new(1.0, 0.0).expect("law"),
        );
        match is_held {
            true => body.prescribe_all([Some(0.0); 2]),
            false => body.prescribe("top", [Some(0.0); 2]),
        }
        .expect("support");
        body
    };
    for (is_held, rows) in [(true, 0), (false, 6)] {
        let mut scene = Scene::new();
        let lower = scene.add("lower", square(0.0, true)).on("top");
        let upper = scene.add("upper", square(1.0, is_held)).on("bottom");
        scene.contact(lower, upper).expect("a pair");
        // a body that is not held at all, so that there is something to solve for
        let mut third = square(5.0, false);
        third.traction("left", [1.0, 0.0]).expect("load");
        scene.add("third", third);
        let problem = scene.problem().expect("a problem");
        let u = vec![0.0; problem.dofs().free()];
        assert_eq!(
            problem.rows(&u, Sampling::Nodes).expect("a state").len(),
            rows
        );
    }
}

/// A linear surface below a quadratic one that is bent to y = a x²: the gap of a node's row is the mean
/// of a x² with the hat function of the node.
#[test]
fn gaps_to_a_surface_of_another_degree() {
    let square = |y: f64| {
        let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 1.0], Diagonals::Rising);
        mesh.expect("mesh")
    };
    let law = LinearElastic::new(1.0, 0.0).expect("law");
    let mut lower = Body::new(square(0.0), law);
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mut upper = Body::new(square(1.0).quadratic(), law);
    upper.prescribe("top", [Some(0.0); 2]).expect("support");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower).on("top");
    let upper = scene.add("upper", upper).on("bottom");
    let passes = Passes::FirstIsSlave;
    scene
        .contact_in_passes(lower, upper, passes)
        .expect("a pair");
    let problem = scene.problem().expect("a problem");
    let mut u = vec![0.0; problem.dofs().free()];
    let a = 0.01;
    let bent: Vec<f64> = problem
        .nodes(1)
        .flat_map(|k| [0.0, a * problem.reference()[k][0].powi(2)])
        .collect();
    problem.kinematics.add_free(1, &bent, &mut u);
    let rows = problem.rows(&u, Sampling::Nodes).expect("a state");
    let mut c = vec![0.0; rows.len()];
    rows.value(&u, &mut c);
    // ∫ x² φ / ∫ φ for hats on [0, ½], [0, 1] and [½, 1]
    let expected = [1.0 / 24.0, 7.0 / 24.0, 17.0 / 24.0];
    let mut found = rows.keys().iter().zip(&c).collect::<Vec<_>>();
    found.sort_by(|a, b| {
        let x = |key: &RowKey| problem.reference()[key.node as usize][0];
        x(a.0).total_cmp(&x(b.0))
    });
    for ((_, c), expected) in found.iter().zip(expected) {
        assert!((**c - a * expected).abs() < 1e-12, "{c} {}", a * expected);
    }
    assert_eq!(found.len(), 3);
}
