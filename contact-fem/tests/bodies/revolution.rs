//! Bodies of revolution, against Lamé's tube and sphere, integrated equations and the same bodies in space.
#![allow(non_snake_case)] // the symbols of the field

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use contact_core::{Energy, LoadStepped};
use contact_fem::assembly::{DofMap, Revolution, StrainEnergy};
use contact_fem::element::{Element, Order, P1, RingP2};
use contact_fem::mesh::generators::{Diagonals, extrude, linspace, quarter_disc, rectangle};
use contact_fem::model::{FindingKind, Problem, Severity};
use contact_fem::tensor::Vector;
use contact_fem::{
    Body, Error, LinearElastic, Material, Mesh, MooneyRivlin, NeoHookean, Ogden, Scene, Simulation,
    StVenantKirchhoff, StepRecord,
};

use crate::common::{at, bore, ended};

fn grid(r: [f64; 2], z: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let (rs, zs) = (
        linspace(r[0], r[1], cells[0]),
        linspace(z[0], z[1], cells[1]),
    );
    rectangle(&rs, &zs, Diagonals::Alternating).expect("a mesh")
}

fn of_order(mesh: Mesh<2>, order: Order) -> Mesh<2> {
    match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    }
}

const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

/// The problem of one body at its end, which its certificate holds.
fn solved<const D: usize>(
    body: Body<D>,
    increments: usize,
) -> (Problem<D>, Vec<f64>, StepRecord<D>) {
    let mut scene = Scene::new();
    scene.add("body", body);
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, increments);
    let last = history.last().expect("a step").clone();
    (problem, history.run.state.u, last)
}

/// Gradient and Hessian against central differences of value and gradient, on a distorted mesh that touches the axis.
fn differences<E: Element<2>>(mesh: &Mesh<2>, law: impl Material<3>) {
    let held: Vec<bool> = (mesh.nodes().iter())
        .flat_map(|X| [X[0] == 0.0, X[1] == 0.0])
        .collect();
    let dofs = DofMap::new(&held);
    let forces: Vec<f64> = (0..held.len()).map(|k| (k as f64).cos()).collect();
    let prescribed = vec![0.0; dofs.prescribed()];
    let mut energy = StrainEnergy::<2, E, _, Revolution>::with_kinematics(
        mesh,
        &law.into(),
        dofs,
        prescribed,
        forces,
    );
    contact_fem::assembly::BodyEnergy::set_load(&mut energy, 1.0);
    check_differences(&energy);
}

fn check_differences(energy: &dyn Energy) {
    let n = energy.dofs();
    let u: Vec<f64> = (0..n).map(|k| 0.03 * (1.0 + k as f64).sin()).collect();
    let gradient = |u: &[f64]| {
        let mut g = vec![0.0; n];
        energy.gradient(u, &mut g);
        g
    };
    let (g, h) = (gradient(&u), 1e-5);
    let mut values = vec![0.0; energy.hessian_pattern().len()];
    energy.hessian(&u, &mut values);
    let largest = g.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let stiffest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for j in 0..n {
        let moved = |by: f64| {
            let mut u = u.clone();
            u[j] += by;
            u
        };
        let [up, down] = [moved(h), moved(-h)];
        let slope = (energy.value(&up) - energy.value(&down)) / (2.0 * h);
        assert!((slope - g[j]).abs() < 1e-7 * largest, "{slope} {}", g[j]);
        let (up, down) = (gradient(&up), gradient(&down));
        for (r, c, v) in (energy.hessian_pattern().iter().zip(&values)).map(|((r, c), v)| (r, c, v))
        {
            let row = match (r == j, c == j) {
                (true, _) => c,
                (_, true) => r,
                _ => continue,
            };
            let slope = (up[row] - down[row]) / (2.0 * h);
            assert!((slope - v).abs() < 1e-7 * stiffest, "{slope} {v}");
        }
    }
}

fn distorted(order: Order) -> Mesh<2> {
    let mesh = of_order(grid([0.0, 1.5], [0.0, 1.0], [2, 2]), order);
    let bent = |X: &Vector<2>| {
        let r = X[0] * (1.0 + 0.1 * X[1]);
        Vector::<2>::new(r, X[1] + 0.1 * X[0] * X[0])
    };
    mesh.mapped(bent).expect("a mesh")
}

#[test]
fn slopes_are_differences() {
    for order in ORDERS {
        let mesh = distorted(order);
        let check = |mesh: &Mesh<2>| match order {
            Order::Linear => {
                differences::<P1>(mesh, NeoHookean::new(7.0, 0.3).expect("a law"));
                differences::<P1>(mesh, Ogden::new(&[[3.0, 1.3]], 0.3).expect("a law"));
            }
            Order::Quadratic => {
                differences::<RingP2>(mesh, LinearElastic::new(7.0, 0.3).expect("a law"));
                differences::<RingP2>(mesh, MooneyRivlin::new(7.0, 0.3, 0.4).expect("a law"));
                differences::<RingP2>(mesh, StVenantKirchhoff::new(7.0, 0.3).expect("a law"));
            }
        };
        check(&mesh);
    }
}

/// The same with a pressure that follows a boundary that ends on the axis, and springs.
#[test]
fn slopes_on_boundaries_are_differences() {
    for order in ORDERS {
        let mut mesh = distorted(order);
        mesh.join_boundaries("outside", &["top", "right"])
            .expect("known");
        let mut body =
            Body::of_revolution(mesh, NeoHookean::new(7.0, 0.3).expect("a law")).expect("a body");
        body.prescribe("bottom", [Some(0.0), Some(0.0)])
            .expect("held");
        body.pressure("outside", 0.9).expect("a pressure");
        body.foundation("top", 0.7).expect("springs");
        body.normal_foundation("right", 0.4).expect("springs");
        let mut scene = Scene::new();
        scene.add("body", body);
        let mut problem = scene.problem().expect("a problem");
        problem.set_load(1.0).expect("a load");
        check_differences(&problem.body_energies()[0]);
    }
}

/// A cylinder under a pressure on its ends and another one around: all strains are constant, and any mesh has them.
#[test]
fn a_cylinder_is_strained_evenly() {
    let (young, nu, p, q, height) = (200.0, 0.3, 3.0, 1.0, 2.0);
    for order in ORDERS {
        let shift = |X: &Vector<2>| {
            let inner = X[0] * (1.0 - X[0]) * X[1] * (height - X[1]);
            Vector::<2>::new(X[0] + 0.2 * inner, X[1] - 0.3 * inner)
        };
        let mesh = grid([0.0, 1.0], [0.0, height], [3, 5]).mapped(shift);
        let mesh = of_order(mesh.expect("a mesh"), order);
        let law = LinearElastic::new(young, nu).expect("a law");
        let mut body = Body::of_revolution(mesh, law).expect("a body");
        assert!((body.volume() - PI * height).abs() < 1e-13);
        body.symmetry("bottom").expect("a plane");
        body.traction("top", [0.0, -p]).expect("a load");
        body.pressure("right", q).expect("a load");
        let (problem, u, last) = solved(body, 1);
        let (along, across) = ((-p + 2.0 * nu * q) / young, (-q + nu * (p + q)) / young);
        for (X, u) in problem.reference().iter().zip(problem.displacements(&u)) {
            let exact = Vector::<2>::new(across * X[0], along * X[1]);
            assert!((u - exact).norm() < 1e-13, "{u} {exact}");
        }
        let stored = 0.5 * PI * height * (-p * along - 2.0 * q * across);
        assert!((last.stored_energy / stored - 1.0).abs() < 1e-11);
        assert!((last.reactions[0][1] / (p * PI) - 1.0).abs() < 1e-11);
        let U = problem.displacements(&u);
        let mesh = problem.scene().bodies()[0].mesh();
        for state in problem.body_energies()[0].cell_states(mesh, &U) {
            let errors = [
                state.sigma[(0, 0)] + q,
                state.sigma_zz + q,
                state.sigma[(1, 1)] + p,
                state.sigma[(0, 1)],
            ];
            assert!(errors.iter().all(|e| e.abs() < 1e-11), "{state:?}");
            assert!((state.von_mises() - (p - q)).abs() < 1e-11);
        }
    }
}

/// Lamé's tube with ends that do not move: energy and stress converge at their orders.
#[test]
fn lame_tube() {
    let (young, nu, p, [a, b]) = (100.0, 0.25, 3.0, [1.0_f64, 2.0]);
    let A = p * a * a / (b * b - a * a);
    let exact = |r: f64| (1.0 + nu) / young * A * ((1.0 - 2.0 * nu) * r + b * b / r);
    let height = 0.5;
    // half of what the pressure does
    let stored = 0.5 * p * TAU * a * height * exact(a);
    for order in ORDERS {
        let errors: Vec<[f64; 3]> = [8, 16, 32]
            .into_iter()
            .map(|cells| {
                let mesh = of_order(grid([a, b], [0.0, height], [cells, cells / 2]), order);
                let law = LinearElastic::new(young, nu).expect("a law");
                let mut body = Body::of_revolution(mesh, law).expect("a body");
                body.symmetry("bottom").expect("a plane");
                body.symmetry("top").expect("a plane");
                body.pressure("left", p).expect("a load");
                let (problem, u, last) = solved(body, 1);
                let nodes = problem.reference().iter().zip(problem.displacements(&u));
                let off = nodes.map(|(X, u)| (u[0] - exact(X[0])).abs());
                let mesh = problem.scene().bodies()[0].mesh();
                let U = problem.displacements(&u);
                let states = problem.body_energies()[0].cell_states(mesh, &U);
                let around = mesh.cells().zip(states).map(|(cell, state)| {
                    let r = cell[..3].iter().map(|&a| mesh.nodes()[a][0]).sum::<f64>() / 3.0;
                    (state.sigma_zz - A * (1.0 + b * b / (r * r)))
                        .abs()
                        .max((state.sigma[(0, 0)] - A * (1.0 - b * b / (r * r))).abs())
                });
                [
                    (last.stored_energy / stored - 1.0).abs(),
                    off.fold(0.0, f64::max) / exact(a),
                    around.fold(0.0, f64::max) / p,
                ]
            })
            .collect();
        let rate = |k: usize| (errors[1][k] / errors[2][k]).log2();
        let rates = [0, 1, 2].map(rate);
        let (least, off, finest) = match order {
            Order::Linear => ([1.95, 1.9, 0.95], 3e-4, 1e-2),
            Order::Quadratic => ([3.85, 2.85, 1.85], 3e-6, 2e-4),
        };
        assert!((0..3).all(|k| rates[k] > least[k]), "{errors:?}");
        assert!(errors[2][1] < off && errors[2][2] < finest, "{errors:?}");
    }
}

/// A hollow sphere under a pressure inside, the half of it above a plane of symmetry.
#[test]
fn lame_sphere() {
    let (young, nu, p, [a, b]) = (100.0, 0.3, 2.0, [1.0_f64, 2.0]);
    let exact = |r: f64| {
        let ratio = p * a.powi(3) / (b.powi(3) - a.powi(3)) / young;
        ratio * ((1.0 - 2.0 * nu) * r + 0.5 * (1.0 + nu) * b.powi(3) / (r * r))
    };
    let errors: Vec<f64> = [6, 12, 24]
        .into_iter()
        .map(|cells| {
            let polar = |X: &Vector<2>| Vector::<2>::new(X[0] * X[1].cos(), X[0] * X[1].sin());
            let mesh = grid([a, b], [0.0, FRAC_PI_2], [cells, 2 * cells]).quadratic();
            let mesh = mesh.mapped(polar).expect("a mesh");
            let law = LinearElastic::new(young, nu).expect("a law");
            let mut body = Body::of_revolution(mesh, law).expect("a body");
            let volume = TAU / 3.0 * (b.powi(3) - a.powi(3));
            assert!((body.volume() / volume - 1.0).abs() < 1e-2 / (cells as f64).powi(3));
            body.symmetry("bottom").expect("a plane");
            body.pressure("left", p).expect("a load");
            let (problem, u, last) = solved(body, 1);
            // what holds the half is the pressure on its opening
            assert!((last.reactions[0][1] / (-p * PI * a * a) - 1.0).abs() < 1e-3);
            let nodes = problem.reference().iter().zip(problem.displacements(&u));
            let off = nodes.map(|(X, u)| (u - X * (exact(X.norm()) / X.norm())).norm());
            off.fold(0.0, f64::max) / exact(a)
        })
        .collect();
    assert!(
        errors[2] < 1e-4 && (errors[1] / errors[2]).log2() > 2.7,
        "{errors:?}"
    );
}

/// A tube of rubber whose bore grows by nearly a half under a pressure that follows it.
#[test]
fn inflation_of_a_tube() {
    let (young, nu, p) = (100.0, 0.3, 15.0);
    let lame = [
        young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        young / (2.0 * (1.0 + nu)),
    ];
    let mesh = grid([1.0, 2.0], [0.0, 0.2], [10, 2]).quadratic();
    let law = NeoHookean::new(young, nu).expect("a law");
    let mut tube = Body::of_revolution(mesh, law).expect("a body");
    tube.symmetry("bottom").expect("a plane");
    tube.symmetry("top").expect("a plane");
    tube.pressure("left", p).expect("a pressure");
    let (problem, u, last) = solved(tube, 5);
    let found = 1.0 + at(&problem, &u, [1.0, 0.0])[0];
    let expected = bore(lame, p);
    assert!(
        expected > 1.4 && (found / expected - 1.0).abs() < 1e-4,
        "{found} {expected}"
    );
    let lost = (last.work() - last.stored_energy) / last.stored_energy;
    assert!(lost.abs() < 0.05, "{lost}");
}

/// Loads of all kinds have the resultants of the whole circumference.
#[test]
fn resultants_are_those_of_the_circumference() {
    let law = || LinearElastic::new(50.0, 0.3).expect("a law");
    for order in ORDERS {
        let body = || {
            let mesh = of_order(grid([0.5, 1.5], [0.0, 2.0], [3, 4]), order);
            Body::of_revolution(mesh, law()).expect("a body")
        };
        let along = |body: &Body<2>, i: usize| body.forces().iter().skip(i).step_by(2).sum::<f64>();
        let mut own = body();
        own.traction("right", [4.0, 3.0]).expect("a load");
        assert!((along(&own, 1) / (3.0 * TAU * 1.5 * 2.0) - 1.0).abs() < 1e-13);
        assert!((along(&own, 0) / (4.0 * TAU * 1.5 * 2.0) - 1.0).abs() < 1e-13);
        let mut own = body();
        own.traction_field("top", |X| [0.0, X[0]].into())
            .expect("a load");
        let exact = TAU * (1.5_f64.powi(3) - 0.5_f64.powi(3)) / 3.0;
        assert!((along(&own, 1) / exact - 1.0).abs() < 1e-13);
        let mut own = body();
        own.body_force([0.0, -7.0]).expect("a load");
        let volume = PI * (1.5 * 1.5 - 0.5 * 0.5) * 2.0;
        assert!((along(&own, 1) / (-7.0 * volume) - 1.0).abs() < 1e-13);
        assert!((own.volume() / volume - 1.0).abs() < 1e-13);
        let mut own = body();
        own.nodal_force(&[2], [0.0, 5.0]).expect("a load");
        assert_eq!(along(&own, 1), 5.0);
        // springs below carry all of it
        let mut own = body();
        own.foundation("bottom", 20.0).expect("springs");
        own.traction("top", [0.0, -1.0]).expect("a load");
        let (_, _, last) = solved(own, 1);
        let pushed = PI * (1.5 * 1.5 - 0.5 * 0.5);
        assert!((last.reactions[0][1] / pushed - 1.0).abs() < 1e-9);
    }
}

/// A cylinder between plates that hold it everywhere, a tenth shorter: its quarter in space comes to the same force.
#[test]
fn a_pressed_cylinder_is_that_of_space() {
    let (height, by) = (1.0, 0.1);
    let law = || NeoHookean::new(10.0, 0.3).expect("a law");
    let of_revolution = |cells: usize| {
        let mesh = grid([0.0, 1.0], [0.0, height], [cells, cells]).quadratic();
        let mut body = Body::of_revolution(mesh, law()).expect("a body");
        body.prescribe("bottom", [Some(0.0), Some(0.0)])
            .expect("held");
        body.prescribe("top", [Some(0.0), Some(-by)]).expect("held");
        let (_, _, last) = solved(body, 2);
        last.stored_energy
    };
    let in_space = |cells: usize| {
        let radii = linspace(0.0, 1.0, cells);
        let angles = linspace(1.5 * PI, TAU, 2 * cells);
        let disc = quarter_disc(&radii, &angles, Diagonals::Rising).expect("a mesh");
        let mut mesh =
            extrude(&disc, &linspace(0.0, height, cells), ["bottom", "top"]).expect("a mesh");
        mesh.name_boundary("around", |X| (X.xy().norm() - 1.0).abs() < 1e-9);
        let onto = |X: &Vector<3>| {
            let length = X.xy().norm();
            Vector::<3>::new(X[0] / length, X[1] / length, X[2])
        };
        let mesh = mesh.quadratic().curved("around", onto).expect("a mesh");
        let mut body = Body::new(mesh, law());
        let nodes: Vec<(usize, Vector<3>)> =
            body.mesh().nodes().iter().copied().enumerate().collect();
        for (a, X) in nodes {
            let is_end = X[2] == 0.0 || X[2] == height;
            let plane = |i: usize| (is_end || X[i].abs() < 1e-12).then_some(0.0);
            let along = is_end.then_some(if X[2] == 0.0 { 0.0 } else { -by });
            let held = [plane(0), plane(1), along];
            if held.iter().any(Option::is_some) {
                body.prescribe_nodes(&[a], held).expect("held");
            }
        }
        let (_, _, last) = solved(body, 2);
        4.0 * last.stored_energy
    };
    let fine = of_revolution(16);
    let of_revolution = [of_revolution(4), of_revolution(8)].map(|E| (E / fine - 1.0).abs());
    let in_space = [in_space(2), in_space(4)].map(|E| (E / fine - 1.0).abs());
    assert!(of_revolution[1] < 2e-3, "{of_revolution:?}");
    assert!(
        in_space[1] < 1e-2 && in_space[1] < 0.5 * in_space[0],
        "{in_space:?}"
    );
}

#[test]
fn what_is_refused() {
    let law = || LinearElastic::new(50.0, 0.3).expect("a law");
    let across = Body::of_revolution(grid([-1.0, 1.0], [0.0, 1.0], [2, 2]), law());
    match across.err() {
        Some(Error::NegativeRadius { node: 0, radius }) => assert_eq!(radius, -1.0),
        other => panic!("{other:?}"),
    }
    // round-off is none
    let nearly = grid([0.0, 1.0], [0.0, 1.0], [2, 2]).translated([-1e-13, 0.0]);
    let nearly = Body::of_revolution(nearly.expect("a mesh"), law()).expect("a body");
    assert!(nearly.mesh().nodes()[0][0] == 0.0 && nearly.prescribed()[0] == Some(0.0));
    let mut nearly = nearly;
    let moved = nearly.prescribe("left", [Some(0.1), None]).err();
    assert!(matches!(moved, Some(Error::Conflict { component: 0, .. })));

    let ring = || Body::of_revolution(grid([0.0, 1.0], [0.0, 1.0], [2, 2]), law()).expect("a body");
    let mut scene = Scene::new();
    scene.add("ring", ring());
    scene.add(
        "sheet",
        Body::new(grid([3.0, 4.0], [0.0, 1.0], [2, 2]), law()),
    );
    let refused = scene.problem().err();
    match refused {
        Some(Error::MixedRevolution { revolved, plane }) => {
            assert_eq!((revolved.as_str(), plane.as_str()), ("ring", "sheet"));
        }
        other => panic!("{other:?}"),
    }
    // the axis holds nothing along itself, and a rim of a wall held across it is enough
    let mut scene = Scene::new();
    scene.add("ring", ring());
    assert!(matches!(scene.problem().err(), Some(Error::NoSupport)));
    let mut held = ring();
    held.prescribe("right", [Some(0.0), None]).expect("held");
    let mut free = Scene::new();
    free.add("held", {
        let mut own = ring();
        own.symmetry("bottom").expect("held");
        own
    });
    free.add("free", {
        let mesh = grid([2.0, 3.0], [0.0, 1.0], [2, 2]);
        let mut own = Body::of_revolution(mesh, law()).expect("a body");
        own.symmetry("right").expect("held");
        own
    });
    let findings = free.preflight();
    let found = findings
        .iter()
        .find(|f| f.kind == FindingKind::FreeMotion)
        .expect("a motion");
    assert_eq!(found.severity, Severity::Error);
    assert!(
        found.what.contains("translation along the axis"),
        "{}",
        found.what
    );

    // a pressure whose rim is free in both directions has no potential
    let mesh = grid([1.0, 2.0], [0.0, 1.0], [2, 2]);
    let mut own =
        Body::of_revolution(mesh, NeoHookean::new(1.0, 0.3).expect("a law")).expect("a body");
    own.symmetry("bottom").expect("held");
    own.pressure("left", 0.1).expect("a pressure");
    let mut scene = Scene::new();
    scene.add("tube", own);
    assert!(matches!(scene.problem().err(), Some(Error::FreeRim { .. })));
}

/// A ring that slides on a cone with its apex in the origin, under σ n on all other faces: u = a X, as it is for a body that is free,
/// with σ = E a/(1 − 2ν) and the energy 3 a σ/2 in each unit of volume.
#[test]
fn a_ring_on_a_cone() {
    let (young, nu, a, angle) = (100.0, 0.3, 1e-3, 0.3_f64);
    let stress = young * a / (1.0 - 2.0 * nu);
    for order in ORDERS {
        let (r, z) = (linspace(1.0, 2.0, 4), linspace(0.0, 1.0, 3));
        let mesh = rectangle(&r, &z, Diagonals::Alternating).expect("a mesh");
        let mesh = mesh.mapped(|X| Vector::<2>::new(X[0], X[1] + X[0] * angle.tan()));
        let mesh = of_order(mesh.expect("a mesh"), order);
        let law = LinearElastic::new(young, nu).expect("a law");
        let mut ring = Body::of_revolution(mesh, law).expect("a body");
        let up = [-angle.sin(), angle.cos()];
        ring.prescribe_along("bottom", up, 0.0).expect("a cone");
        for (face, n) in [("left", [-1.0, 0.0]), ("right", [1.0, 0.0]), ("top", up)] {
            ring.traction(face, n.map(|n| stress * n)).expect("a load");
        }
        let (problem, u, last) = solved(ring, 1);
        let nodes = problem.reference().iter().zip(problem.displacements(&u));
        let off = nodes.map(|(X, u)| (u - X * a).norm());
        let off = off.fold(0.0, f64::max) / (2.0 * a);
        assert!(off < 1e-10, "{order:?}: {off}");
        let energy = 1.5 * a * stress * PI * (4.0 - 1.0);
        assert!((last.stored_energy / energy - 1.0).abs() < 1e-10);
        // what the cone bears of the pull upwards on the top, 2π r dr of its section
        let pull = stress * PI * (4.0 - 1.0);
        assert!((last.reactions[0][1] / pull + 1.0).abs() < 1e-10);
    }
}

/// A cylinder is drawn, and its top let go: it goes back, and its axis has stayed.
#[test]
fn a_cylinder_that_is_let_go() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 3),
        &linspace(0.0, 2.0, 5),
        Diagonals::Rising,
    );
    let law = NeoHookean::new(100.0, 0.3).expect("a law");
    let mut body = Body::of_revolution(mesh.expect("a mesh"), law).expect("a body");
    body.prescribe("bottom", [None, Some(0.0)]).expect("held");
    body.during(&[[0.0, 1.0]], |body| {
        body.prescribe("top", [Some(0.0), Some(0.3)])
    })
    .expect("a support");
    let mut scene = Scene::new();
    scene.add("cylinder", body);
    let mut problem = scene.problem().expect("a problem");
    let phases = [
        contact_fem::Phase::new("draw", 1.0, 2),
        contact_fem::Phase::new("let go", 2.0, 2),
    ];
    let history = Simulation::in_phases(phases)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    assert!(history.steps[1].stored_energy > 1.0);
    let u = problem.displacements(&history.run.state.u);
    let largest = u.iter().map(|u| u.amax()).fold(0.0, f64::max);
    assert!(largest < 1e-9, "{largest}");
    let mut axis = problem
        .reference()
        .iter()
        .zip(&u)
        .filter(|(X, _)| X[0] == 0.0);
    assert!(axis.all(|(_, u)| u[0] == 0.0));
}
