//! Contact of bodies of revolution, against Hertz, Lamé and the patch test.
#![allow(non_snake_case)] // the symbols of the field

use std::f64::consts::{PI, TAU};

use contact_fem::element::{FacetRule, Order, facet_shapes};
use contact_fem::mesh::generators::{
    Diagonals, graded, linspace, onto_sphere, quarter_disc, rectangle,
};
use contact_fem::model::{FindingKind, InitialGaps, Integration, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean, Obstacle, Scene, StepRecord};

use crate::common::ended;

fn grid(r: [f64; 2], z: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let (rs, zs) = (
        linspace(r[0], r[1], cells[0]),
        linspace(z[0], z[1], cells[1]),
    );
    rectangle(&rs, &zs, Diagonals::Alternating).expect("a mesh")
}

/// Its end, which its certificate holds, and the pressures on all surfaces.
fn solved(
    scene: Scene<2>,
    increments: usize,
) -> (Problem<2>, Vec<f64>, StepRecord<2>, Vec<Vec<f64>>) {
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, increments);
    let last = history.last().expect("a step").clone();
    let end = history.run.solution.expect("a solution");
    let pressures = problem.pressures(&end.state.u, &end.gaps, &end.lambda);
    let u = end.state.u.clone();
    (problem, u, last, pressures.expect("pressures"))
}

/// ∫ f(p, r) n_z 2πr ds over the surface in the reference configuration, p interpolated.
fn along_the_axis(
    problem: &Problem<2>,
    surface: usize,
    p: &[f64],
    f: impl Fn(f64, f64) -> f64,
) -> f64 {
    let surface = &problem.surfaces()[surface];
    let rule = FacetRule::<2>::gauss(6);
    let facets = surface.facets().zip(surface.reference());
    let of_facet = |(nodes, facet): (&[usize], &contact_fem::element::Facet<2>)| -> f64 {
        let at = |(w, lambda): &(f64, Vector<2>)| {
            let N = facet_shapes(surface.order(), lambda);
            let p: f64 = nodes.iter().zip(N).map(|(&a, N)| N * p[a]).sum();
            let r = facet.point(lambda)[0];
            w * f(p, r) * facet.normal(lambda)[1] * TAU * r
        };
        rule.points().iter().map(at).sum()
    };
    facets.map(of_facet).sum()
}

const R: f64 = 8.0;
const MODULI: [f64; 2] = [200.0, 0.3];
const A: f64 = 0.4;

/// A half of a ball with facets of a/`in_contact` in the contact.
fn ball(in_contact: usize, order: Order) -> Body<2> {
    let h = A / in_contact as f64;
    let count = 8 * in_contact;
    let angles = graded(1.5 * PI, TAU, h / R, count).expect("angles");
    let depths = graded(0.0, R, h, count / 2).expect("radii");
    let radii: Vec<f64> = depths.iter().rev().map(|d| R - d).collect();
    let mut mesh = quarter_disc(&radii, &angles, Diagonals::Falling).expect("a mesh");
    if order == Order::Quadratic {
        mesh = mesh
            .quadratic()
            .curved("arc", onto_sphere(R))
            .expect("a mesh");
    }
    let mesh = mesh.translated([0.0, R]).expect("a mesh");
    let law = LinearElastic::new(MODULI[0], MODULI[1]).expect("a law");
    Body::of_revolution(mesh, law).expect("a body")
}

/// Hertz's errors: p₀, the L² error of the profile over the surface as a share of its norm, and the radius.
fn hertz_errors(
    problem: &Problem<2>,
    surface: usize,
    p: &[f64],
    area: f64,
    [p_0, a]: [f64; 2],
) -> [f64; 3] {
    let exact = |r: f64| p_0 * (1.0 - r * r / (a * a)).max(0.0).sqrt();
    let off = along_the_axis(problem, surface, p, |p, r| (p - exact(r)).powi(2));
    let all = along_the_axis(problem, surface, p, |_, r| exact(r).powi(2));
    let peak = p.iter().fold(0.0_f64, |m, p| m.max(*p));
    [
        (peak / p_0 - 1.0).abs(),
        (off / all).sqrt(),
        ((area / PI).sqrt() / a - 1.0).abs(),
    ]
}

/// A ball on a rigid plane.
#[test]
fn hertz_on_a_plane() {
    let modulus = MODULI[0] / (1.0 - MODULI[1] * MODULI[1]);
    let p_0 = 2.0 * modulus * A / (PI * R);
    for order in [Order::Linear, Order::Quadratic] {
        let fineness = match order {
            Order::Linear => [6, 12, 24],
            Order::Quadratic => [4, 8, 16],
        };
        let errors: Vec<[f64; 3]> = fineness
            .into_iter()
            .map(|in_contact| {
                let mut ball = ball(in_contact, order);
                let force = 4.0 * modulus * A.powi(3) / (3.0 * R);
                ball.traction("flat", [0.0, -force / (PI * R * R)])
                    .expect("a load");
                let mut scene = Scene::new();
                let ball = scene.add("ball", ball);
                let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
                let plane = scene
                    .obstacle("plane", ball.on("arc"), plane)
                    .expect("a side");
                let (problem, _, last, pressures) = solved(scene, 1);
                let pushed = last.obstacle_force(plane)[1];
                assert!((pushed / -force - 1.0).abs() < 1e-9, "{pushed} {force}");
                let resultant = along_the_axis(&problem, 0, &pressures[0], |p, _| -p);
                assert!(
                    (resultant / force - 1.0).abs() < 1e-9,
                    "{resultant} {force}"
                );
                hertz_errors(&problem, 0, &pressures[0], last.pairs[0].area, [p_0, A])
            })
            .collect();
        let least = match order {
            Order::Linear => [0.015, 0.03],
            Order::Quadratic => [0.01, 0.03],
        };
        assert!(
            errors[2][0] < least[0] && errors[2][1] < least[1],
            "{errors:?}"
        );
        // to one facet and a half
        assert!(
            errors[2][2] < 1.5 / fineness[2] as f64 && (errors[0][1] / errors[2][1]).log2() > 1.5,
            "{errors:?}"
        );
    }
}

/// A ball that is pushed onto a block of the same material; both carry the same pressure.
#[test]
fn hertz_on_a_block() {
    let modulus = 0.5 * MODULI[0] / (1.0 - MODULI[1] * MODULI[1]);
    for order in [Order::Linear, Order::Quadratic] {
        let in_contact = 12;
        let mut ball = ball(in_contact, order);
        ball.prescribe("flat", [None, Some(-0.02)]).expect("held");
        let h = 1.07 * A / in_contact as f64;
        let rs = graded(0.0, 2.0 * R, h, 100).expect("radii");
        let depths = graded(0.0, 2.0 * R, h, 50).expect("depths");
        let zs: Vec<f64> = depths.iter().rev().map(|d| -d).collect();
        let mut mesh = rectangle(&rs, &zs, Diagonals::Rising).expect("a mesh");
        if order == Order::Quadratic {
            mesh = mesh.quadratic();
        }
        let law = LinearElastic::new(MODULI[0], MODULI[1]).expect("a law");
        let mut block = Body::of_revolution(mesh, law).expect("a body");
        block.symmetry("bottom").expect("a plane");
        let mut scene = Scene::new();
        let ball = scene.add("ball", ball);
        let block = scene.add("block", block);
        scene
            .contact(ball.on("arc"), block.on("top"))
            .expect("a pair");
        let (problem, _, last, pressures) = solved(scene, 1);
        let force = last.contact_force(ball)[1];
        let a = (0.75 * force * R / modulus).cbrt();
        let p_0 = 1.5 * force / (PI * a * a);
        assert!((a / A - 1.0).abs() < 0.2, "{a}");
        let forces = [
            -last.reaction(ball)[1],
            -last.contact_force(block)[1],
            last.reaction(block)[1],
        ];
        for found in forces {
            assert!((found / force - 1.0).abs() < 1e-9, "{found} {force}");
        }
        for (surface, sign) in [(0, -1.0), (1, 1.0)] {
            let p = &pressures[surface];
            let resultant = along_the_axis(&problem, surface, p, |p, _| sign * p);
            assert!(
                (resultant / force - 1.0).abs() < 1e-9,
                "{resultant} {force}"
            );
            let errors = hertz_errors(&problem, surface, p, last.pairs[0].area, [p_0, a]);
            // facets of the other surface that the edge crosses push nodes beyond it, too
            assert!(
                errors[0] < 0.03 && errors[1] < 0.06 && errors[2] < 2.5 / 12.0,
                "{errors:?}"
            );
        }
    }
}

/// Two cylinders with meshes of their own on each other: one pressure everywhere, in each form of the constraints.
#[test]
fn a_patch_of_two_cylinders() {
    let (young, nu, p) = (100.0, 0.3, 2.0);
    for order in [Order::Linear, Order::Quadratic] {
        let cylinder = |z: f64, cells: [usize; 2]| {
            let mesh = grid([0.0, 1.0], [z, z + 1.0], cells);
            let mesh = match order {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            };
            Body::of_revolution(mesh, LinearElastic::new(young, nu).expect("a law"))
                .expect("a body")
        };
        let (mut lower, mut upper) = (cylinder(0.0, [3, 2]), cylinder(1.0, [4, 3]));
        lower.symmetry("bottom").expect("a plane");
        upper.traction("top", [0.0, -p]).expect("a load");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", upper);
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("a pair");
        scene.integration = Some(Integration::Exact);
        let findings = scene.preflight();
        let held = findings
            .iter()
            .find(|f| f.kind == FindingKind::HeldByContact);
        let held = &held.expect("a note").what;
        assert!(
            held.ends_with("body `upper`: translation along the axis"),
            "{held}"
        );
        let (problem, u, last, pressures) = solved(scene, 1);
        for (X, u) in problem.reference().iter().zip(problem.displacements(&u)) {
            let exact = Vector::<2>::new(nu * p / young * X[0], -p / young * X[1]);
            assert!((u - exact).norm() < 1e-10, "{u} {exact}");
        }
        assert!((last.contact_force(upper)[1] / (p * PI) - 1.0).abs() < 1e-10);
        assert!(
            (last.pairs[0].area / PI - 1.0).abs() < 1e-12,
            "{:?}",
            last.pairs
        );
        for pressure in pressures.iter().flatten() {
            assert!((pressure / p - 1.0).abs() < 1e-7, "{pressure}");
        }
    }
}

/// A hub shrunk onto a shaft, both as free along the axis as they like: Lamé's pressure everywhere.
#[test]
fn a_hub_on_a_shaft() {
    let (young, nu, b, delta) = (100.0, 0.3, 2.0_f64, 2e-3);
    for order in [Order::Quadratic, Order::Linear] {
        let part = |r: [f64; 2], cells: [usize; 2]| {
            let mesh = grid(r, [0.0, 0.5], cells);
            let mesh = match order {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            };
            let law = LinearElastic::new(young, nu).expect("a law");
            let mut body = Body::of_revolution(mesh, law).expect("a body");
            body.symmetry("bottom").expect("a plane");
            body
        };
        let shaft = part([0.0, 1.0 + delta], [12, 5]);
        let hub = part([1.0, b], [16, 6]);
        let mut scene = Scene::new();
        let shaft = scene.add("shaft", shaft);
        let hub = scene.add("hub", hub);
        scene
            .contact(shaft.on("right"), hub.on("left"))
            .expect("a pair");
        scene.initial_gaps = InitialGaps::Resolve;
        let (_, _, last, pressures) = solved(scene, 1);
        // plane stress: both are free along the axis
        let hub_gives = (b * b + 1.0) / (b * b - 1.0) + nu;
        let p = delta * young / (hub_gives + 1.0 - nu);
        let mean = |own: &[f64]| own.iter().sum::<f64>() / own.len() as f64;
        for own in &pressures {
            assert!((mean(own) / p - 1.0).abs() < 0.01, "{p} {own:?}");
        }
        assert!((last.pairs[0].area / (TAU * 0.5) - 1.0).abs() < 0.01);
    }
}

/// A tube around a mandrel that has grown by 0.2 %: the obstacle carries no force along the axis, and the tube Lamé's pressure.
#[test]
fn a_tube_on_a_mandrel() {
    let (young, nu, [a, b], by) = (100.0, 0.25, [1.0_f64, 2.0], 2e-3);
    let mesh = grid([a, b], [0.0, 0.5], [32, 8]).quadratic();
    let mut tube =
        Body::of_revolution(mesh, LinearElastic::new(young, nu).expect("a law")).expect("a body");
    tube.symmetry("bottom").expect("a plane");
    tube.symmetry("top").expect("a plane");
    let mut scene = Scene::new();
    let tube = scene.add("tube", tube);
    let mandrel = Obstacle::half_space([a + by, 0.0], [1.0, 0.0]).expect("a mandrel");
    scene
        .obstacle("mandrel", tube.on("left"), mandrel)
        .expect("a side");
    scene.initial_gaps = InitialGaps::Resolve;
    let (_, _, last, pressures) = solved(scene, 1);
    let grows = (1.0 + nu) / young * a * a / (b * b - a * a) * ((1.0 - 2.0 * nu) * a + b * b / a);
    let p = by / grows;
    for pressure in &pressures[0] {
        assert!((pressure / p - 1.0).abs() < 1e-4, "{pressure} {p}");
    }
    assert!((last.pairs[0].area / (TAU * a * 0.5) - 1.0).abs() < 1e-12);
}

/// A ball of rubber between a plane and a plate that comes down by a quarter of its radius: what the
/// plate does is stored.
#[test]
fn a_pressed_ball_of_rubber() {
    let radius = 1.0;
    for order in [Order::Linear, Order::Quadratic] {
        let cells = if order == Order::Linear { 12 } else { 6 };
        let radii = linspace(0.0, radius, cells);
        let angles = linspace(1.5 * PI, TAU, 2 * cells);
        let mut mesh = quarter_disc(&radii, &angles, Diagonals::Falling).expect("a mesh");
        if order == Order::Quadratic {
            mesh = mesh
                .quadratic()
                .curved("arc", onto_sphere(radius))
                .expect("a mesh");
        }
        let mut ball =
            Body::of_revolution(mesh, NeoHookean::new(10.0, 0.3).expect("a law")).expect("a body");
        ball.prescribe("flat", [None, Some(-0.25 * radius)])
            .expect("held");
        let mut block = Body::of_revolution(
            {
                let mesh = grid([0.0, 1.5], [-2.0, -1.0], [10, 6]);
                if order == Order::Quadratic {
                    mesh.quadratic()
                } else {
                    mesh
                }
            },
            NeoHookean::new(20.0, 0.3).expect("a law"),
        )
        .expect("a body");
        block
            .prescribe("bottom", [Some(0.0), Some(0.0)])
            .expect("held");
        let mut scene = Scene::new();
        let ball = scene.add("ball", ball);
        let block = scene.add("block", block);
        scene
            .contact(ball.on("arc"), block.on("top"))
            .expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        let history = ended(&mut problem, 10);
        let last = history.last().expect("a step");
        assert!((last.work() / last.stored_energy - 1.0).abs() < 0.02);
        assert!((last.contact_force(ball)[1] / last.reaction(ball)[1] + 1.0).abs() < 1e-6);
        assert!((last.contact_force(block)[1] + last.contact_force(ball)[1]).abs() < 1e-9);
    }
}
