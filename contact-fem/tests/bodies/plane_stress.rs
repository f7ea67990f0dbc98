//! Thin sheets against the theory of plane stress.
#![allow(non_snake_case)]

use contact_fem::material::PlaneStress;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{
    Body, LinearElastic, Material, Motion, NeoHookean, Obstacle, Scene, Simulation, StepRecord,
};

const E: f64 = 200.0;
const NU: f64 = 0.3;

/// A strip of length 4 and height 1, drawn at its right end by this displacement, as a quarter of a sheet.
fn drawn(law: impl Material<2>, by: f64) -> (StepRecord<2>, f64) {
    let mesh = rectangle(
        &linspace(0.0, 4.0, 3),
        &linspace(0.0, 1.0, 2),
        Diagonals::Alternating,
    );
    let mut strip = Body::new(mesh.expect("a mesh"), law);
    let held = strip.symmetry("left").and_then(|b| b.symmetry("bottom"));
    let held = held.and_then(|b| b.prescribe("right", [Some(by), None]));
    held.expect("named by the generator");
    let top = strip.mesh().boundary_nodes("top").expect("a side")[0];
    let mut scene = Scene::new();
    scene.add("strip", strip);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(2).run(&mut problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let narrowed = problem.displacements(&history.run.state.u)[top][1];
    (history.last().expect("a step").clone(), narrowed)
}

/// Drawn along one axis, a sheet has Young's modulus itself and narrows by Poisson's ratio.
#[test]
fn uniaxial_tension() {
    let law = PlaneStress(LinearElastic::new(E, NU).expect("a law"));
    let (last, narrowed) = drawn(law, 0.04);
    let energy = 0.5 * E * 0.01 * 0.01 * 4.0;
    assert!(
        (last.energy / energy - 1.0).abs() < 1e-10,
        "{}",
        last.energy
    );
    assert!((narrowed + NU * 0.01).abs() < 1e-12, "{narrowed}");
    let mut ends = last.support_reactions.iter();
    let right = ends.find(|(side, _)| side.boundary == "right");
    let (_, force) = right.expect("a support");
    assert!((force[0] - E * 0.01).abs() < 1e-9, "{force}");
}

/// A cantilever of length 8 and height 2 with a parabolic shear at its end and the exact displacement at its root, after Timoshenko and
/// Goodier. In plane strain the tip would come down by 9 % less.
#[test]
fn a_cantilever() {
    let (length, height, force) = (8.0, 2.0, 1.0);
    let inertia = height * height * height / 12.0;
    let exact = move |X: &Vector<2>| {
        let (x, y) = (X[0], X[1]);
        let along = (6.0 * length - 3.0 * x) * x + (2.0 + NU) * (y * y - 0.25 * height * height);
        let down = 3.0 * NU * y * y * (length - x)
            + (4.0 + 5.0 * NU) * height * height * x / 4.0
            + (3.0 * length - x) * x * x;
        Vector::<2>::new(force * y * along, -force * down) / (6.0 * E * inertia)
    };
    let shear = |X: &Vector<2>| {
        Vector::<2>::new(
            0.0,
            -force / (2.0 * inertia) * (0.25 * height * height - X[1] * X[1]),
        )
    };
    let mesh = rectangle(
        &linspace(0.0, length, 8),
        &linspace(-0.5 * height, 0.5 * height, 2),
        Diagonals::Alternating,
    );
    let law = PlaneStress(LinearElastic::new(E, NU).expect("a law"));
    let mut beam = Body::new(mesh.expect("a mesh").quadratic(), law);
    let held = beam.prescribe_path("left", move |t, X| exact(X) * t);
    let held = held.and_then(|beam| beam.traction_field("right", shear));
    held.expect("named by the generator");
    let nodes = beam.mesh().nodes().to_vec();
    let mut scene = Scene::new();
    scene.add("beam", beam);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(1).run(&mut problem);
    let history = history.expect("a run");
    let moved = problem.displacements(&history.run.state.u);
    let tip = exact(&Vector::<2>::new(length, 0.0)).norm();
    let apart = nodes.iter().zip(&moved).map(|(X, u)| (u - exact(X)).norm());
    let worst = apart.fold(0.0, f64::max) / tip;
    assert!(worst < 2e-3, "{worst:e}");
}

/// A neo-Hookean sheet, drawn to one and a half of its length: the force is that of the law alone, whose free stretches are zeros of
/// μ (t² − 1) + λ ln J.
#[test]
fn a_sheet_of_rubber() {
    let law = NeoHookean::new(2.6, 0.3).expect("a law");
    let (last, narrowed) = drawn(PlaneStress(law), 2.0);
    let (mu, lambda, s) = (1.0, 1.5, 1.5_f64);
    let (mut low, mut high) = (0.1, 1.0);
    for _ in 0..100 {
        let t = 0.5 * (low + high);
        match mu * (t * t - 1.0) + lambda * (s * t * t).ln() > 0.0 {
            true => high = t,
            false => low = t,
        }
    }
    assert!((narrowed - (low - 1.0)).abs() < 1e-9, "{narrowed}, {low}");
    let ln_J = (s * low * low).ln();
    let psi = 0.5 * mu * (s * s + 2.0 * low * low - 3.0 - 2.0 * ln_J) + 0.5 * lambda * ln_J * ln_J;
    assert!(
        (last.energy / (4.0 * psi) - 1.0).abs() < 1e-9,
        "{}",
        last.energy
    );
}

/// A sheet that is pressed on a floor along its edge: the pressure is that of uniaxial stress, and σ_zz is zero in all cells.
#[test]
fn a_sheet_on_a_floor() {
    let xs = linspace(0.0, 1.0, 3);
    let mesh = rectangle(&xs, &xs, Diagonals::Rising).expect("a mesh");
    let law = PlaneStress(LinearElastic::new(E, NU).expect("a law"));
    let mut sheet = Body::new(mesh, law);
    sheet.symmetry("left").expect("a side");
    sheet.prescribe("top", [None, Some(0.0)]).expect("a side");
    let mut scene = Scene::new();
    let sheet = scene.add("sheet", sheet);
    let floor = Obstacle::half_space([0.0, 0.0], [0.0, 1.0]).expect("a floor");
    let up = Motion::translation([0.0, 0.02]).expect("a motion");
    let floor = scene.obstacle("floor", sheet.on("bottom"), floor.moving(up));
    let floor = floor.expect("a surface");
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(1).run(&mut problem);
    let history = history.expect("a run");
    let last = history.last().expect("a step");
    let force = last.obstacle_force(floor)[1].abs();
    assert!((force - E * 0.02).abs() < 1e-7, "{force}");
    let energy = &problem.body_energies()[0];
    let U = problem.displacements(&history.run.state.u);
    for cell in energy.cell_states(problem.scene().bodies()[0].mesh(), &U) {
        assert_eq!(cell.sigma_zz, 0.0);
        assert!((cell.sigma[(1, 1)] + E * 0.02).abs() < 1e-7, "{cell:?}");
        assert!((cell.von_mises() - E * 0.02).abs() < 1e-7, "{cell:?}");
    }
}
