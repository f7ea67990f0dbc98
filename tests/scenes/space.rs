//! Contact in space, of linear and quadratic tetrahedra: patch test, and what must not matter.

use crate::common::{relative, run, run_with, stress_error};
use contact_core::Ending;
use contact_core::InteriorPoint;
use contact_fem::element::Order;
use contact_fem::mesh::generators::cuboid;
use contact_fem::model::{Integration, Problem};
use contact_fem::simulation::History;
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{Body, Mesh, NeoHookean, Scene};
use ipopt_contact_scenes::blocks::Blocks;
use ipopt_contact_scenes::pair;

fn block(order: Order, low: [f64; 3], size: [f64; 3], divisions: usize) -> Mesh<3> {
    let mesh = cuboid(low, size, [divisions; 3]).expect("mesh");
    match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    }
}

/// The largest relative error of σ_zz in two unit cubes of ν = 0 with `n_bottom` and `n_top` cells
/// an edge, the top pressed by 0.1: exact are σ_zz = −1e5 and u_z = −0.05 on the interface.
fn pressed_cubes(order: Order, n_bottom: usize, n_top: usize, gauss_points: usize) -> f64 {
    let integration = Integration::Gauss(gauss_points);
    let blocks = Blocks::new([n_bottom, n_top], order, integration);
    let scene = blocks.space().expect("a scene");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, 1, 1e-6);
    let step = history.steps.last().expect("converged");
    assert!(relative(step.reactions[0][2], 1e5) < 1e-3);
    assert!(relative(step.energy, 0.5e4) < 1e-3);
    let U = problem.displacements(&history.run.state.u);
    stress_error(&problem, &U, -1e5)
}

/// Gauss points do not integrate across the other mesh's kinks, which here run through facets in all
/// directions. Linear elements stay within the plane's error for 4 points a direction; in quadratic
/// ones, whose stress varies within the cells at the interface, it is larger, and as quickly gone
/// with more points.
#[test]
fn patch_test_within_the_gauss_point_error() {
    let linear = [(4, 1.2e-3), (8, 1e-7)];
    let quadratic = [(4, 1e-2), (8, 2e-3), (16, 5e-4)];
    for (order, allowed) in [
        (Order::Linear, &linear[..]),
        (Order::Quadratic, &quadratic[..]),
    ] {
        let error = pressed_cubes(order, 2, 2, 4);
        assert!(error < 1e-8, "matching, {order:?}: {error}");
        for (bottom, top) in [(2, 3), (3, 2), (3, 4)] {
            for &(points, allowed) in allowed {
                let error = pressed_cubes(order, bottom, top, points);
                let case = format!("{order:?} {bottom}:{top}, {points} points");
                assert!(error < allowed, "{case}: {error}");
            }
        }
    }
}

/// A small block is pressed obliquely into a larger one and tilts on it.
struct Oblique {
    order: Order,
    /// None for the default.
    integration: Option<Integration>,
    /// Applied to the reference configuration and to what is prescribed.
    rotation: Matrix<3>,
    /// The small block comes first.
    swapped: bool,
}

impl Oblique {
    fn solve(&self) -> (Problem<3>, History<3>) {
        let turned = |mesh: Mesh<3>| mesh.mapped(|X| self.rotation * X).expect("turned");
        let all = |u: [f64; 3]| {
            let u = self.rotation * Vector::from(u);
            [0, 1, 2].map(|i| Some(u[i]))
        };
        let large = block(self.order, [0.0; 3], [1.0, 1.1, 0.5], 2);
        let mut large = Body::new(turned(large), NeoHookean::new(1e3, 0.3).expect("law"));
        large.prescribe("bottom", all([0.0; 3])).expect("support");
        let small = block(self.order, [0.2, 0.15, 0.52], [0.57, 0.61, 0.4], 2);
        let mut small = Body::new(turned(small), NeoHookean::new(2e3, 0.2).expect("law"));
        small
            .prescribe("top", all([0.05, 0.02, -0.12]))
            .expect("support");
        let (large, small) = ((large, "top"), (small, "bottom"));
        let scene = match self.swapped {
            false => pair(large, small),
            true => pair(small, large),
        };
        let mut scene = scene.expect("surfaces");
        scene.integration = self.integration;
        let mut problem = scene.problem().expect("valid scene");
        // where rows are about to open, displacements follow the root of what is left of gap times
        // force: differences of 1e-10 ask for much less of it than results do
        let mut method = InteriorPoint {
            complementarity: 1e-14,
            ..InteriorPoint::default()
        };
        let history = run_with(&mut method, &mut problem, 3, 2e-11);
        assert_eq!(history.run.ending, Ending::Complete);
        (problem, history)
    }

    /// Displacements in the frame of the plain scene, the large block's first.
    fn displacements(&self) -> (Vec<Vector<3>>, f64) {
        let (problem, history) = self.solve();
        let step = history.steps.last().expect("converged");
        assert!(step.rows > 10 && step.contact_forces[0].norm() > 1.0);
        let U = problem.displacements(&history.run.state.u);
        let order = if self.swapped { [1, 0] } else { [0, 1] };
        let nodes = order.into_iter().flat_map(|body| problem.nodes(body));
        let back = self.rotation.transpose();
        (nodes.map(|a| back * U[a]).collect(), step.energy)
    }
}

fn same(a: &(Vec<Vector<3>>, f64), b: &(Vec<Vector<3>>, f64), tolerance: f64) {
    let largest = a.0.iter().map(|u| u.amax()).fold(0.0, f64::max);
    for (node, (u, v)) in a.0.iter().zip(&b.0).enumerate() {
        let error = (u - v).amax() / largest;
        assert!(error < tolerance, "node {node}: {error:e}");
    }
    assert!(relative(a.1, b.1) < tolerance, "energies {} {}", a.1, b.1);
}

#[test]
fn neither_order_nor_frame_matter() {
    // a turn by 0.83 about (1, 2, −0.5)
    let axis = Vector::<3>::new(1.0, 2.0, -0.5).normalize();
    let cross = Matrix::<3>::new(
        0.0, -axis[2], axis[1], axis[2], 0.0, -axis[0], -axis[1], axis[0], 0.0,
    );
    let angle: f64 = 0.83;
    let rotation = Matrix::identity() + cross * angle.sin() + cross * cross * (1.0 - angle.cos());
    for order in [Order::Linear, Order::Quadratic] {
        for integration in [None, Some(Integration::Exact)] {
            let scene = |rotation, swapped| Oblique {
                order,
                integration,
                rotation,
                swapped,
            };
            let plain = scene(Matrix::identity(), false).displacements();
            same(
                &plain,
                &scene(Matrix::identity(), true).displacements(),
                1e-10,
            );
            same(&plain, &scene(rotation, false).displacements(), 1e-10);
        }
    }
}

/// Three blocks on each other, the uppermost pressed obliquely; `order` is that of the bodies, which
/// are numbered from below. The displacements of the lowest block's nodes come first.
fn three_blocks(elements: Order, order: [usize; 3]) -> (Vec<Vector<3>>, f64) {
    let law = NeoHookean::new(1e3, 0.3).expect("law");
    let body = |k: usize| {
        let (low, size) = [
            ([0.0; 3], [1.0, 1.1, 0.5]),
            ([0.1, 0.05, 0.51], [0.8, 0.9, 0.4]),
            ([0.22, 0.17, 0.92], [0.55, 0.6, 0.3]),
        ][k];
        let mut body = Body::new(block(elements, low, size, 2), law);
        match k {
            0 => body.prescribe("bottom", [Some(0.0); 3]),
            // held against sliding only
            1 => body
                .prescribe("left", [Some(0.0), None, None])
                .and_then(|body| body.prescribe("front", [None, Some(0.0), None])),
            _ => body.prescribe("top", [Some(0.03), Some(0.02), Some(-0.1)]),
        }
        .expect("support");
        body
    };
    let place = [0, 1, 2].map(|k| order.iter().position(|o| *o == k).expect("all bodies"));
    let mut scene = Scene::new();
    let bodies = order.map(|k| scene.add(k.to_string(), body(k)));
    for (below, above) in [(place[0], place[1]), (place[1], place[2])] {
        let (lower, upper) = (bodies[below].on("top"), bodies[above].on("bottom"));
        let (first, second) = match below < above {
            true => (lower, upper),
            false => (upper, lower),
        };
        scene.contact(first, second).expect("surfaces");
    }
    let mut problem = scene.problem().expect("valid scene");
    let mut method = InteriorPoint {
        complementarity: 1e-14,
        ..InteriorPoint::default()
    };
    let history = run_with(&mut method, &mut problem, 2, 2e-11);
    assert_eq!(history.run.ending, Ending::Complete);
    let step = history.steps.last().expect("converged");
    assert!(step.contact_forces[place[0]][2] < -1.0 && step.contact_forces[place[2]][2] > 1.0);
    let U = problem.displacements(&history.run.state.u);
    let nodes = place.into_iter().flat_map(|body| problem.nodes(body));
    (nodes.map(|a| U[a]).collect(), step.energy)
}

#[test]
fn nor_does_the_order_of_three_bodies() {
    for elements in [Order::Linear, Order::Quadratic] {
        let plain = three_blocks(elements, [0, 1, 2]);
        for order in [[2, 0, 1], [1, 2, 0], [2, 1, 0]] {
            same(&plain, &three_blocks(elements, order), 1e-10);
        }
    }
}
