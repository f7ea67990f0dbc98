//! What contact that carries nothing leaves.
#![allow(non_snake_case)]

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Geometry;
use contact_fem::output::Snapshot;
use contact_fem::{Body, LinearElastic, Obstacle, Scene};

use crate::common::ended;

/// A block without lateral strain between two walls, pressed on a floor: the walls touch it, and carry what rounding leaves.
#[test]
fn walls_that_carry_nothing_have_no_contact_area() {
    for order in [1, 2] {
        let sides = linspace(0.0, 1.0, 5);
        let mesh = rectangle(&sides, &sides, Diagonals::Rising).expect("a mesh");
        let mesh = if order == 2 { mesh.quadratic() } else { mesh };
        let mut block = Body::new(mesh, LinearElastic::new(100.0, 0.0).expect("a law"));
        block.prescribe("top", [None, Some(-0.1)]).expect("held");
        let mut scene = Scene::new();
        scene.geometry = Some(Geometry::Reference);
        let block = scene.add("block", block);
        for (side, point, normal) in [
            ("bottom", [0.0, 0.0], [0.0, 1.0]),
            ("left", [0.0, 0.0], [1.0, 0.0]),
            ("right", [1.0, 0.0], [-1.0, 0.0]),
        ] {
            let wall = Obstacle::half_space(point, normal).expect("a wall");
            scene.obstacle(side, block.on(side), wall).expect("a pair");
        }
        let mut problem = scene.problem().expect("a problem");
        let history = ended(&mut problem, 2);
        let areas: Vec<f64> = history.steps[1]
            .pairs
            .iter()
            .map(|pair| pair.area)
            .collect();
        assert!((areas[0] - 1.0).abs() < 1e-12, "{areas:?}");
        assert_eq!(areas[1..], [0.0; 2]);
        // E ε on the floor, along its whole length
        let solution = history.run.solution.as_ref().expect("converged");
        let pressures = Snapshot::new(&problem, solution)
            .expect("a snapshot")
            .pressures;
        for (X, p) in problem.reference().iter().zip(pressures) {
            let expected = if X[1] == 0.0 { 10.0 } else { 0.0 };
            assert!((p - expected).abs() < 1e-9, "{p} at {X}");
        }
    }
}
