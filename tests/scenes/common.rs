//! Runs and comparisons that several tests share.

use contact_core::Retry;
use contact_core::{InteriorPoint, Method};
use contact_fem::Simulation;
use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};

/// The paper's disc-in-disc (section 6.1) with `segments` around the hole; 64 is the mesh that the
/// reference values belong to. Points are those of the paper.
pub fn disc_in_disc(segments: usize, roles: Roles) -> Problem<2> {
    let mut scene = disc_in_disc::scene(Fineness::scaled(segments), roles).expect("a scene");
    scene.points_as_in_the_paper();
    scene.problem().expect("valid scene")
}

/// Runs a scene to full load with default settings but for these.
pub fn run<const D: usize>(
    problem: &mut Problem<D>,
    increments: usize,
    tolerance: f64,
) -> History<D> {
    run_with(
        &mut InteriorPoint::default(),
        problem,
        increments,
        tolerance,
    )
}

/// Units of length and modulus: about those from mm and N to m and N, and to something stiff and large. As powers of two
/// they leave round-off as it is, which otherwise may decide on an iteration more or less.
pub const UNITS: [(f64, f64); 3] = [
    (1.0 / 1024.0, (1u64 << 20) as f64),
    (1024.0, (1u64 << 30) as f64),
    (1.0, 1.0 / (1u64 << 20) as f64),
];

/// As [`run`], by a method of one's own.
pub fn run_with<const D: usize>(
    method: &mut dyn Method,
    problem: &mut Problem<D>,
    increments: usize,
    tolerance: f64,
) -> History<D> {
    let mut simulation = Simulation::solved_by(Retry::with(method), increments);
    simulation.solver.fixed_point.tolerance = tolerance;
    simulation.run(problem).expect("no misuse")
}

/// The largest error of σ along the last axis in any cell, relative to `exact`.
pub fn stress_error<const D: usize>(problem: &Problem<D>, U: &[Vector<D>], exact: f64) -> f64 {
    let mut worst: f64 = 0.0;
    for (body, energy) in problem.body_energies().iter().enumerate() {
        let mesh = problem.scene().bodies()[body].mesh();
        for state in energy.cell_states(mesh, &U[problem.nodes(body)]) {
            worst = worst.max(relative(state.sigma[(D - 1, D - 1)], exact));
        }
    }
    worst
}

/// |a − b| / |b|.
pub fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}
