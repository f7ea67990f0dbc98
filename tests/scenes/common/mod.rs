//! Scenes that several tests share.
#![allow(dead_code)] // each test binary uses its own part

use std::ops::ControlFlow;

use contact_core::{InteriorPoint, Method};
use contact_fem::mesh::generators::{Diagonals, annulus, disc};
use contact_fem::scene::{Passes, Problem};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Body, NeoHookean, Scene, Simulation};

/// Which of the two bodies comes first in the scene.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Order {
    RingFirst,
    DiscFirst,
}

/// The problem of [`disc_in_disc_scene`].
pub fn disc_in_disc(segments: usize, passes: Passes, order: Order) -> Problem<2> {
    let scene = disc_in_disc_scene(segments, passes, order);
    scene.problem().expect("valid scene")
}

/// The paper's disc-in-disc (section 6.1) with `segments` around the hole; 64 is the mesh that the
/// reference values belong to.
pub fn disc_in_disc_scene(segments: usize, passes: Passes, order: Order) -> Scene<2> {
    let layers = 12 * segments / 64;
    let radius = |k: usize| 0.7 + 1.3 * (k as f64 / layers as f64).powf(1.3);
    let radii: Vec<f64> = (0..=layers).map(radius).collect();
    let ring = annulus(&radii, segments, Diagonals::Alternating).expect("mesh");
    let inner = disc(0.6, 52 * segments / 64, 1, 0.03).expect("mesh");
    let mut ring = Body::new(ring, NeoHookean::new(1000.0, 0.0).expect("law"));
    ring.prescribe("outer", [Some(0.0); 2]).expect("support");
    let mut inner = Body::new(inner, NeoHookean::new(2000.0, 0.3).expect("law"));
    let down = [Some(0.0), Some(-1.125)];
    inner.prescribe_all(down).expect("support");
    let (bodies, hole, disc) = match order {
        Order::RingFirst => (vec![ring, inner], (0, "inner"), (1, "boundary")),
        Order::DiscFirst => (vec![inner, ring], (1, "inner"), (0, "boundary")),
    };
    let mut scene = Scene::new(bodies);
    match order {
        Order::RingFirst => scene.contact_in_passes(hole, disc, passes),
        Order::DiscFirst => scene.contact_in_passes(disc, hole, passes),
    }
    .expect("surfaces");
    scene
}

/// Units of length and modulus: about those from mm and N to m and N, and to something stiff and large. As powers of two
/// they leave round-off as it is, which otherwise may decide on an iteration more or less.
pub const UNITS: [(f64, f64); 3] = [
    (1.0 / 1024.0, (1u64 << 20) as f64),
    (1024.0, (1u64 << 30) as f64),
    (1.0, 1.0 / (1u64 << 20) as f64),
];

/// A coarse disc-in-disc with lengths times `length` and moduli times `modulus`.
pub fn scaled_discs(length: f64, modulus: f64) -> Problem<2> {
    let radii: Vec<f64> = [0.7, 0.8, 0.95, 1.2, 1.5, 2.0].map(|r| r * length).to_vec();
    let ring = annulus(&radii, 32, Diagonals::Alternating).expect("mesh");
    let mut ring = Body::new(ring, NeoHookean::new(1000.0 * modulus, 0.2).expect("law"));
    ring.prescribe("outer", [Some(0.0); 2]).expect("support");
    let inner = disc(0.6 * length, 26, 1, 0.03).expect("mesh");
    let mut inner = Body::new(inner, NeoHookean::new(2000.0 * modulus, 0.3).expect("law"));
    let down = [Some(0.0), Some(-0.6 * length)];
    inner.prescribe_all(down).expect("support");
    let mut scene = Scene::new(vec![ring, inner]);
    scene
        .contact((0, "inner"), (1, "boundary"))
        .expect("surfaces");
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

/// As [`run`], by a method of one's own.
pub fn run_with<const D: usize>(
    method: &mut dyn Method,
    problem: &mut Problem<D>,
    increments: usize,
    tolerance: f64,
) -> History<D> {
    let mut simulation = Simulation::with_increments(increments);
    simulation.load_steps.fixed_point.tolerance = tolerance;
    simulation
        .run(problem, method, |_| ControlFlow::Continue(()))
        .expect("no misuse")
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
