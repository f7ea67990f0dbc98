//! Derivatives and constraints against finite differences and a second, slower definition.

use crate::common::disc_in_disc;
use contact_core::gaps::Sampling;
use contact_core::{ContactProblem, LoadStepped, check};
use contact_fem::mesh::generators::{Diagonals, annulus, linspace, rectangle};
use contact_fem::model::{Geometry, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Material, Mesh, NeoHookean};
use ipopt_contact_scenes::disc_in_disc::Roles;
use ipopt_contact_scenes::{alone, pair};

/// A body with a prescribed boundary, a traction and a body force, at 70 % load.
fn loaded<const D: usize>(mut body: Body<D>, support: &str, load: &str) -> Problem<D>
where
    contact_fem::element::P1: contact_fem::element::Element<D>,
{
    body.prescribe(support, [Some(0.02); D]).expect("support");
    body.traction(load, [0.3; D]).expect("load");
    body.body_force([-0.1; D]).expect("load");
    let mut problem = alone(body).problem().expect("valid scene");
    problem.set_load(0.7).expect("load");
    problem
}

fn wiggle(n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|k| size * ((3 * k + 1) as f64).sin()).collect()
}

fn assert_conforms<const D: usize>(problem: &Problem<D>) {
    let energy = problem.energy();
    let u = wiggle(energy.dofs(), 0.02);
    assert!(energy.value(&u).is_finite());
    let errors = check::energy(energy, &u, 1e-6);
    assert!(errors.gradient < 1e-7, "{errors:?}");
    assert!(errors.hessian < 1e-7, "{errors:?}");
    assert!(errors.outside_pattern < 1e-9, "{errors:?}");
}

fn plane(material: impl Material<2>) -> Problem<2> {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 4),
        &linspace(0.0, 1.0, 3),
        Diagonals::Alternating,
    );
    loaded(Body::new(mesh.expect("mesh"), material), "bottom", "right")
}

fn space(material: impl Material<3>) -> Problem<3> {
    // a cube of six tetrahedra around its diagonal
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f64);
    let cells = [
        [0, 1, 3, 7],
        [0, 3, 2, 7],
        [0, 2, 6, 7],
        [0, 6, 4, 7],
        [0, 4, 5, 7],
        [0, 5, 1, 7],
    ];
    let cells = cells.concat();
    let mut mesh = Mesh::<3>::new((0..8).map(corner).collect(), cells).expect("mesh");
    mesh.name_boundary("x0", |X| X[0] == 0.0);
    mesh.name_boundary("z1", |X| X[2] == 1.0);
    loaded(Body::new(mesh, material), "x0", "z1")
}

#[test]
fn energies_in_the_plane() {
    assert_conforms(&plane(NeoHookean::new(10.0, 0.3).expect("law")));
    assert_conforms(&plane(LinearElastic::new(10.0, 0.3).expect("law")));
}

#[test]
fn energies_in_space() {
    assert_conforms(&space(NeoHookean::new(10.0, 0.3).expect("law")));
    assert_conforms(&space(LinearElastic::new(10.0, 0.3).expect("law")));
}

/// The sum over bodies, one of them with nothing free, away from rest.
#[test]
fn energy_of_a_scene() {
    let mesh = annulus(&[0.7, 1.1, 2.0], 12, Diagonals::Alternating).expect("mesh");
    let mut ring = Body::new(mesh, NeoHookean::new(1000.0, 0.2).expect("law"));
    ring.prescribe("outer", [Some(0.1), None]).expect("support");
    let mesh = rectangle(
        &linspace(-0.2, 0.2, 2),
        &linspace(-0.2, 0.2, 2),
        Diagonals::Rising,
    );
    let mut block = Body::new(
        mesh.expect("mesh"),
        LinearElastic::new(50.0, 0.3).expect("law"),
    );
    block
        .prescribe("left", [Some(0.0), Some(0.0)])
        .expect("support");
    let mut scene = pair((ring, "inner"), (block, "right")).expect("surfaces");
    scene.geometry = Some(Geometry::Current);
    let mut problem = scene.problem().expect("valid scene");
    problem.set_load(1.0).expect("load");
    assert_conforms(&problem);
}

/// c(u) of the rows at the point where they were linearised, against a second definition of the
/// weak gap: brute force over all master facets, no tree, no rows.
#[test]
fn gaps_against_brute_force() {
    let mut problem = disc_in_disc(16, Roles::default());
    problem.set_load(0.13).expect("load");
    let u = wiggle(problem.energy().dofs(), 0.004);
    let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
    assert!(!gaps.is_exact() && gaps.len() > 16, "{} rows", gaps.len());
    let mut c = vec![0.0; gaps.len()];
    gaps.value(&u, &mut c);
    let x = problem.positions(&u);
    let mut negative = 0;
    for (key, c) in gaps.keys().iter().zip(&c) {
        let pass = problem.passes()[key.pass as usize];
        let brute = weak_gap(&problem, pass.slave, pass.master, key.node as usize, &x);
        assert!((c - brute).abs() < 1e-12, "{key:?}: {c} against {brute}");
        negative += usize::from(*c < 0.0);
    }
    assert!(negative > 0, "some rows are violated at this point");
}

/// 1/a_i Σ w φ_i (x − x̄)·n by brute force, the four-point Gauss rule written out.
fn weak_gap(problem: &Problem<2>, slave: usize, master: usize, i: usize, x: &[Vector<2>]) -> f64 {
    let (r, s) = (3.0 / 7.0, 2.0 / 7.0 * 1.2f64.sqrt());
    let (inner, outer) = ((r - s).sqrt(), (r + s).sqrt());
    let weight = |sign: f64| (18.0 + sign * 30f64.sqrt()) / 72.0;
    let points = [
        (weight(1.0), inner),
        (weight(1.0), -inner),
        (weight(-1.0), outer),
        (weight(-1.0), -outer),
    ];
    let X = problem.reference();
    let (mut sum, mut area) = (0.0, 0.0);
    for facet in facets(problem, slave) {
        let Some(local) = facet.iter().position(|&a| a == i) else {
            continue;
        };
        let length = (X[facet[1]] - X[facet[0]]).norm();
        for (w, xi) in points {
            let t = 0.5 * (1.0 + xi);
            let phi = if local == 0 { 1.0 - t } else { t };
            let point = x[facet[0]] * (1.0 - t) + x[facet[1]] * t;
            let (foot, normal) = foot_by_brute_force(problem, master, &point, x);
            sum += w * length * phi * (point - foot).dot(&normal);
            area += w * length * phi;
        }
    }
    sum / area
}

/// Facets as pairs of scene nodes.
fn facets(problem: &Problem<2>, surface: usize) -> Vec<[usize; 2]> {
    let surface = &problem.surfaces()[surface];
    let scene = |f: &[usize]| [surface.nodes()[f[0]], surface.nodes()[f[1]]];
    surface.facets().map(scene).collect()
}

fn outward(x: &[Vector<2>], facet: &[usize; 2]) -> Vector<2> {
    let edge = x[facet[1]] - x[facet[0]];
    Vector::<2>::new(edge[1], -edge[0]).normalize()
}

fn foot_by_brute_force(
    problem: &Problem<2>,
    master: usize,
    point: &Vector<2>,
    x: &[Vector<2>],
) -> (Vector<2>, Vector<2>) {
    let facets = facets(problem, master);
    let at_node = |node: usize| -> Vector<2> {
        let around = facets.iter().filter(|facet| facet.contains(&node));
        around
            .map(|facet| outward(x, facet))
            .sum::<Vector<2>>()
            .normalize()
    };
    let feet = facets.iter().map(|&[a, b]| {
        let edge = x[b] - x[a];
        let t = ((point - x[a]).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        let foot = x[a] + edge * t;
        ((point - foot).norm(), foot, t, [a, b])
    });
    let (_, foot, t, [a, b]) = feet.min_by(|p, q| p.0.total_cmp(&q.0)).expect("facets");
    (foot, (at_node(a) * (1.0 - t) + at_node(b) * t).normalize())
}

/// The columns of C against differences of c: rows are linear, so any step will do, and the rows
/// must not depend on the order of terms in which they were summed.
#[test]
fn constraint_jacobian_against_differences() {
    let mut problem = disc_in_disc(16, Roles::default());
    problem.set_load(0.13).expect("load");
    let n = problem.energy().dofs();
    let u = wiggle(n, 0.004);
    let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
    let mut dense = vec![vec![0.0; n]; gaps.len()];
    gaps.entries().for_each(|(i, j, a)| dense[i][j] += a);
    let (mut up, mut down) = (vec![0.0; gaps.len()], vec![0.0; gaps.len()]);
    for j in 0..n {
        let mut v = u.clone();
        v[j] = u[j] + 0.25;
        gaps.value(&v, &mut up);
        v[j] = u[j] - 0.25;
        gaps.value(&v, &mut down);
        for (i, row) in dense.iter().enumerate() {
            assert!((row[j] - (up[i] - down[i]) / 0.5).abs() < 1e-12);
        }
    }
}

/// Forces that act between bodies are in balance, row by row: rigid translations change no gap.
#[test]
fn action_equals_reaction() {
    let mut problem = disc_in_disc(16, Roles::default());
    problem.set_load(0.13).expect("load");
    let u = wiggle(problem.energy().dofs(), 0.004);
    let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
    for row in 0..gaps.len() {
        let mut lambda = vec![0.0; gaps.len()];
        lambda[row] = 1.0;
        let total: Vector<2> = problem.contact_forces(&gaps, &lambda).iter().sum();
        assert!(total.norm() < 1e-13, "row {row}: {total}");
    }
}
