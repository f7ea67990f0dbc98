//! Patch tests: states that the elements contain exactly.

use crate::common::{relative, run, stress_error};
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::{Integration, Passes};
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean, Scene};
use ipopt_contact_scenes::alone;
use ipopt_contact_scenes::blocks::Blocks;

/// A square mesh with its interior nodes shaken off the grid.
fn distorted() -> Mesh<2> {
    let grid = rectangle(
        &linspace(0.0, 1.0, 6),
        &linspace(0.0, 1.0, 5),
        Diagonals::Alternating,
    )
    .expect("mesh");
    let inside = |v: f64| v > 0.0 && v < 1.0;
    let shake = |(k, X): (usize, &Vector<2>)| {
        let s = 0.03 * ((7 * k) as f64).sin();
        match inside(X[0]) && inside(X[1]) {
            true => [X[0] + s, X[1] - 0.8 * s],
            false => [X[0], X[1]],
        }
    };
    let nodes = grid.nodes().iter().enumerate().map(shake).collect();
    let mut mesh = Mesh::new(nodes, grid.cells().flatten().copied().collect()).expect("valid");
    mesh.name_boundary("all", |_| true);
    mesh
}

/// Prescribes u = (F − I) X on the whole boundary; the interior must follow exactly.
fn homogeneous(mut body: Body<2>, F: Matrix<2>, increments: usize, tolerance: f64) {
    let shift = F - Matrix::identity();
    for node in body.mesh().boundary_nodes("all").expect("named") {
        let u = shift * body.mesh().nodes()[node];
        body.prescribe_nodes(&[node], [Some(u[0]), Some(u[1])])
            .expect("support");
    }
    let mut problem = alone(body).problem().expect("valid scene");
    let history = run(&mut problem, increments, 1e-6);
    let u = problem.displacements(&history.run.state.u);
    for (u, X) in u.iter().zip(problem.reference()) {
        assert!((u - shift * X).amax() < tolerance, "{u} at {X}");
    }
}

#[test]
fn small_strain_without_contact() {
    let F = Matrix::<2>::new(1.02, 0.01, -0.03, 0.97);
    for nu in [-0.4, 0.0, 0.3, 0.4999] {
        let law = LinearElastic::new(2e5, nu).expect("law");
        homogeneous(Body::new(distorted(), law), F, 1, 1e-12);
    }
}

#[test]
fn large_strain_without_contact() {
    let F = Matrix::<2>::new(1.3, 0.4, -0.2, 0.8);
    for nu in [0.0, 0.3] {
        let law = NeoHookean::new(2e5, nu).expect("law");
        homogeneous(Body::new(distorted(), law), F, 4, 1e-12);
    }
}

/// Uniaxial tension of a neo-Hookean strip, free to contract, against the closed form: with ν = 0,
/// σ₂ = 0 leaves F₂₂ = 1 and P₁₁ = μ (F − 1/F).
#[test]
fn traction_gives_the_closed_form_stretch() {
    let mesh = rectangle(
        &linspace(0.0, 2.0, 4),
        &linspace(0.0, 1.0, 3),
        Diagonals::Rising,
    )
    .expect("mesh");
    let mut strip = Body::new(mesh, NeoHookean::new(2.0, 0.0).expect("law"));
    strip.prescribe("left", [Some(0.0), None]).expect("support");
    strip
        .prescribe("bottom", [None, Some(0.0)])
        .expect("support");
    strip.traction("right", [0.9, 0.0]).expect("load");
    let mut problem = alone(strip).problem().expect("valid scene");
    let history = run(&mut problem, 3, 1e-6);
    // μ = 1: F − 1/F = 0.9
    let stretch = 0.5 * (0.9 + (0.81f64 + 4.0).sqrt());
    let u = problem.displacements(&history.run.state.u);
    for (u, X) in u.iter().zip(problem.reference()) {
        assert!((u[0] - (stretch - 1.0) * X[0]).abs() < 1e-9 && u[1].abs() < 1e-9);
    }
}

/// The largest relative error of σ_yy in two blocks of ν = 0 with a flat interface and meshes of
/// `n_top` and `n_bottom` cells across, the top pressed by 0.1: exact are the pressure 1e5
/// everywhere and u_y = −0.05 on the interface.
fn pressed_blocks(n_top: usize, n_bottom: usize, gauss_points: usize, passes: Passes) -> f64 {
    let integration = Integration::Gauss(gauss_points);
    let blocks = Blocks {
        passes,
        ..Blocks::new([n_bottom, n_top], Order::Linear, integration)
    };
    let scene = blocks.plane().expect("a scene");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, 1, 1e-6);
    let step = history.steps.last().expect("converged");
    // total force and energy: pressure 1e5 over a unit width, half of it times 0.1
    assert!(relative(step.reactions[0][1], 1e5) < 1e-3);
    assert!(relative(step.energy, 0.5e4) < 1e-3);
    let U = problem.displacements(&history.run.state.u);
    for surface in problem.surfaces() {
        for &node in surface.nodes() {
            assert!(
                (U[node][1] + 0.05).abs() < 1e-3 * 0.05,
                "interface moves by half"
            );
        }
    }
    stress_error(&problem, &U, -1e5)
}

/// Gauss points do not integrate across the other mesh's kinks. An independent implementation
/// measured 4e-4, 1e-3 and 1e-5 for 2, 4 and 8 points on one pair of meshes.
#[test]
fn flat_contact_within_the_gauss_point_error() {
    for (points, allowed) in [(2, 4e-4), (4, 1e-3), (8, 1e-5)] {
        for (top, bottom) in [(5, 7), (7, 5), (10, 14)] {
            let error = pressed_blocks(top, bottom, points, Passes::Both);
            assert!(error < allowed, "{top}:{bottom}, {points} points: {error}");
        }
    }
}

/// The default of 4 points holds the same bound over mesh ratios from 1:1.2 to 1:7.
#[test]
fn four_gauss_points_on_many_mesh_ratios() {
    for (top, bottom) in [(6, 7), (4, 9), (9, 4), (3, 7), (8, 31), (2, 9), (10, 70)] {
        let error = pressed_blocks(top, bottom, 4, Passes::Both);
        assert!(error < 1e-3, "{top}:{bottom}: {error}");
    }
}

/// Matching meshes have no kinks within a facet, in whichever role.
#[test]
fn matching_meshes_pass_the_contact_patch_test() {
    for passes in [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave] {
        let error = pressed_blocks(6, 6, 4, passes);
        assert!(error < 1e-8, "{passes:?}: {error}");
    }
}

/// σ_yy = −10 in two blocks 0.5 × 1 that are pressed together by a load.
#[test]
fn pressure_driven_blocks() {
    let mesh = |n: usize, y: f64| {
        let ys = linspace(y, y + 1.0, 2 * n);
        rectangle(&linspace(0.0, 0.5, n), &ys, Diagonals::Rising).expect("mesh")
    };
    let law = LinearElastic::new(210.0, 0.0).expect("law");
    let mut bottom = Body::new(mesh(5, 0.0), law);
    bottom
        .prescribe("bottom", [Some(0.0), Some(0.0)])
        .expect("support");
    let mut top = Body::new(mesh(7, 1.0), law);
    top.prescribe("left", [Some(0.0), None]).expect("support");
    top.traction("top", [0.0, -10.0]).expect("load");
    let mut scene = Scene::new();
    let (bottom, top) = (scene.add("bottom", bottom), scene.add("top", top));
    scene
        .contact(top.on("bottom"), bottom.on("top"))
        .expect("surfaces");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, 1, 1e-6);
    let U = problem.displacements(&history.run.state.u);
    let error = stress_error(&problem, &U, -10.0);
    assert!(error < 1e-3, "{error}");
}

/// A fine neo-Hookean block pressed by half its height in one increment: the first row of cells
/// alone would have to take it all. The result is the homogeneous compression in closed form.
#[test]
fn one_large_increment_starts_admissible() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 10),
        &linspace(0.0, 1.0, 40),
        Diagonals::Rising,
    );
    let mut block = Body::new(mesh.expect("mesh"), NeoHookean::new(2.0, 0.0).expect("law"));
    block
        .prescribe("bottom", [Some(0.0), Some(0.0)])
        .expect("support");
    block
        .prescribe("top", [Some(0.0), Some(-0.5)])
        .expect("support");
    let mut problem = alone(block).problem().expect("valid scene");
    let history = run(&mut problem, 1, 1e-6);
    assert_eq!(history.run.cuts(), 0);
    // ψ = μ/2 (F² + 1 − 2 − 2 ln F) at F = 0.5, and P = μ (F − 1/F), with μ = 1
    let step = history.steps.last().expect("converged");
    assert!(relative(step.energy, 0.5 * (0.25 - 1.0) + 2f64.ln()) < 1e-9);
    assert!(
        relative(step.reactions[0][1].abs() + 1.0, 1.0) < 1e-6,
        "supports cancel"
    );
    assert!(relative(step.min_j, 0.5) < 1e-8);
}
