//! Many bodies, whose pairs are found, and bodies that touch themselves.

#![allow(non_snake_case)] // the symbols of the field

mod common;
#[path = "../examples/support/hairpin.rs"]
#[allow(dead_code)] // the example uses more of it
mod hairpin;

use common::{relative, run};
use contact_core::load_steps::RunOutcome;
use contact_fem::mesh::Mesh;
use contact_fem::mesh::generators::{Diagonals, disc, linspace, rectangle};
use contact_fem::scene::Integration;
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Material, NeoHookean, Scene};

const DISCS: usize = 4;

/// Four discs on each other between a floor and a lid that comes down; each disc is held on its
/// vertical diameter against rolling. `order` is the bodies' order: discs from below, floor, lid.
fn stack(order: &[usize]) -> (Scene<2>, Vec<usize>) {
    let law = NeoHookean::new(1e3, 0.3).expect("law");
    let disc = |k: usize| {
        let quarter = std::f64::consts::FRAC_PI_2;
        let mesh = disc(1.0, 48, 8, quarter).expect("mesh");
        let height = 1.0 + 2.0 * k as f64;
        let body = Body::new(mesh.translated([0.0, height]).expect("moved"), law);
        (body, "boundary", [Some(0.0), None])
    };
    let plate = |y: f64, push: f64, touching: &'static str| {
        let mesh = rectangle(
            &linspace(-1.0, 1.0, 10),
            &linspace(y, y + 0.2, 2),
            Diagonals::Alternating,
        );
        let body = Body::new(mesh.expect("mesh"), law);
        (body, touching, [Some(0.0), Some(push)])
    };
    let mut bodies = Vec::new();
    let mut surfaces = Vec::new();
    for &k in order {
        let (mut body, surface, held) = match k {
            DISCS => plate(-0.2, 0.0, "top"),
            k if k > DISCS => plate(2.0 * DISCS as f64, -0.4, "bottom"),
            k => disc(k),
        };
        if k < DISCS {
            let on_diameter = |X: &Vector<2>| X[0].abs() < 1e-12;
            let nodes = body.mesh().nodes().iter().enumerate();
            let nodes: Vec<usize> = nodes.filter(|n| on_diameter(n.1)).map(|n| n.0).collect();
            body.prescribe_nodes(&nodes, held).expect("support");
        } else {
            body.prescribe_all(held).expect("support");
        }
        bodies.push(body);
        surfaces.push(surface);
    }
    let mut scene = Scene::new(bodies);
    for (body, surface) in surfaces.into_iter().enumerate() {
        scene.contact_surface(body, surface).expect("declared");
    }
    let place = (0..DISCS + 2).map(|k| order.iter().position(|o| *o == k));
    (scene, place.map(|p| p.expect("all bodies")).collect())
}

/// The lid's force on each body from below (discs, floor, lid), and every node's displacement in
/// that order of the bodies.
fn solved(order: &[usize]) -> (Vec<Vector<2>>, Vec<Vector<2>>) {
    let (scene, place) = stack(order);
    let mut problem = scene.problem().expect("valid scene");
    assert_eq!(problem.scene().pairs().len(), 15, "every two of six bodies");
    let history = run(&mut problem, 4, 1e-9);
    assert_eq!(history.run.cuts(), 0);
    let step = history.steps.last().expect("converged");
    let size = problem.surfaces()[0].facet_size();
    assert!(step.penetration < 0.1 * size, "{}", step.penetration);
    let U = problem.displacements(&history.run.state.u);
    let nodes = place.iter().flat_map(|&body| problem.nodes(body));
    let reactions = place.iter().map(|&body| step.reactions[body]);
    (reactions.collect(), nodes.map(|a| U[a]).collect())
}

/// Every contact of the stack passes the same force on, the discs are squeezed alike, and the order
/// of the bodies does not matter.
#[test]
fn a_stack_of_discs() {
    let (reactions, U) = solved(&[0, 1, 2, 3, 4, 5]);
    let (floor, lid) = (reactions[DISCS], reactions[DISCS + 1]);
    assert!(floor[1] > 10.0);
    // nothing but floor and lid bears the load
    assert!(relative(-lid[1], floor[1]) < 1e-8, "{floor} {lid}");
    let all: Vector<2> = reactions.iter().sum();
    assert!(all.norm() < 1e-8 * floor[1], "{all}");
    for reaction in &reactions[..DISCS] {
        // the diameters only hold against rolling, for which an uneven mesh gives little cause
        assert!(
            reaction[1] == 0.0 && reaction[0].abs() < 0.03 * floor[1],
            "{reaction} {floor}"
        );
    }
    // by symmetry about the middle of the stack, u(x, y) and u(x, 8 − y) differ as if each end
    // moved by half; compare the discs' centres
    let per_disc = 1 + 8 * 48;
    let centre = |k: usize| {
        let nodes = &U[k * per_disc..(k + 1) * per_disc];
        nodes.iter().sum::<Vector<2>>() / per_disc as f64
    };
    for k in 0..DISCS {
        let mirrored = -0.4 - centre(DISCS - 1 - k)[1];
        let error = (centre(k)[1] - mirrored).abs();
        assert!(error < 1e-3 * 0.4, "disc {k}: {error}");
    }

    let (others, V) = solved(&[3, 5, 0, 4, 2, 1]);
    assert!(relative(others[DISCS][1], floor[1]) < 1e-8);
    for (u, v) in U.iter().zip(&V) {
        assert!((u - v).amax() < 1e-8, "{u} {v}");
    }
}

/// The arms of a hairpin meet when they are pressed together, and close towards the fold.
fn closes<const D: usize>(scene: Scene<D>, increments: usize) {
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, increments, 1e-6);
    assert_eq!(history.run.outcome, RunOutcome::Complete);
    let first = history.steps.iter().find(|s| s.rows > 0).expect("rows");
    assert!(first.factor > 0.2, "nothing of the band is near itself");
    let step = history.steps.last().expect("converged");
    let U = problem.displacements(&history.run.state.u);
    let X = problem.reference();

    // contact forces are internal to the one body: they cancel, and push its halves apart
    let solution = history.run.solution.as_ref().expect("converged");
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let upper: Vector<D> = (0..X.len())
        .filter(|&a| X[a][1] > 0.0)
        .map(|a| forces[a])
        .sum();
    let all: Vector<D> = forces.iter().sum();
    assert!(upper[1] > 0.01, "{upper}");
    assert!(all.norm() < 1e-9 * upper.norm(), "{all}");

    // the arms touch along some way and do not cross by more than a weak constraint leaves
    let size = problem.surfaces()[0].facet_size();
    let arm = (0..X.len()).filter(|&a| hairpin::is_inside_of_upper_arm(&X[a]));
    let heights: Vec<f64> = arm.map(|a| X[a][1] + U[a][1]).collect();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest > -0.1 * size, "{lowest} for facets of {size}");
    let touching = heights.iter().filter(|y| **y < 0.05 * size).count();
    assert!(touching > 3, "{heights:?}");
    assert!(step.penetration < 0.1 * size, "{}", step.penetration);
}

#[test]
fn a_hairpin_closes_on_itself() {
    closes(hairpin::scene(3, true).expect("scene"), 8);
}

#[test]
fn so_does_one_in_space() {
    closes(hairpin::scene_in_space(2, 2).expect("scene"), 8);
}

/// With facets cut along the other arm's; their own neighbours cut nothing.
#[test]
fn hairpins_integrated_exactly() {
    let mut plane = hairpin::scene(3, true).expect("scene");
    plane.integration = Integration::Exact;
    closes(plane, 8);
    let mut space = hairpin::scene_in_space(2, 2).expect("scene");
    space.integration = Integration::Exact;
    closes(space, 8);
}

/// The same hairpin without its self-contact: the arms pass through each other.
#[test]
fn without_self_contact_the_arms_cross() {
    let scene = hairpin::scene(3, false).expect("scene");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, 8, 1e-6);
    assert_eq!(history.run.outcome, RunOutcome::Complete);
    let U = problem.displacements(&history.run.state.u);
    let X = problem.reference();
    let arm = (0..X.len()).filter(|&a| hairpin::is_inside_of_upper_arm(&X[a]));
    let lowest = arm.map(|a| X[a][1] + U[a][1]).fold(f64::INFINITY, f64::min);
    assert!(lowest < -0.05, "{lowest}");
}

/// Two halves of a block that hang together at one end only: a slit, closed from the start or open
/// by a little, bears pressure like a whole block. ν = 0: E = ½ · 100 · 0.05² · 2 · 2 without gap.
fn slit(gap: f64, angle: f64, law: impl Material<2>, increments: usize) -> (f64, f64) {
    slit_integrated(Integration::Gauss(4), gap, angle, law, increments)
}

fn slit_integrated(
    integration: Integration,
    gap: f64,
    angle: f64,
    law: impl Material<2>,
    increments: usize,
) -> (f64, f64) {
    // the slit's lower side is of the lower half, its upper side of the upper one, whose nodes are
    // doubled but for x ≥ 1.5
    let half = |from: f64| {
        let ys = linspace(from, from + 1.0, 8);
        rectangle(&linspace(0.0, 2.0, 16), &ys, Diagonals::Rising).expect("mesh")
    };
    let (lower, upper) = (half(-1.0), half(0.0));
    let count = lower.nodes().len();
    let mut nodes: Vec<[f64; 2]> = lower.nodes().iter().map(|X| [X[0], X[1]]).collect();
    let mut numbers = Vec::new();
    for X in upper.nodes() {
        let shared = (X[1] == 0.0 && X[0] >= 1.5)
            .then(|| nodes[..count].iter().position(|Y| *Y == [X[0], X[1]]))
            .flatten();
        numbers.push(shared.unwrap_or_else(|| {
            let lift = if X[0] < 1.5 && X[1] == 0.0 { gap } else { 0.0 };
            nodes.push([X[0], X[1] + lift]);
            nodes.len() - 1
        }));
    }
    let mut cells: Vec<usize> = lower.cells().flatten().copied().collect();
    cells.extend(upper.cells().flatten().map(|&a| numbers[a]));
    let mut mesh = Mesh::new(nodes, cells).expect("valid");
    mesh.name_boundary("slit", |X| X[1] >= 0.0 && X[1] <= gap && X[0] <= 1.5);
    mesh.name_boundary("bottom", |X| X[1] == -1.0);
    mesh.name_boundary("top", |X| X[1] == 1.0);
    let (sin, cos) = angle.sin_cos();
    let turn = |X: &Vector<2>| Vector::<2>::new(cos * X[0] - sin * X[1], sin * X[0] + cos * X[1]);
    let mut body = Body::new(mesh.mapped(turn).expect("turned"), law);
    body.prescribe("bottom", [Some(0.0); 2]).expect("support");
    body.prescribe("top", [Some(0.1 * sin), Some(-0.1 * cos)])
        .expect("support");
    let mut scene = Scene::new(vec![body]);
    scene.integration = integration;
    scene.self_contact(0, "slit").expect("a surface");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, increments, 1e-9);
    assert_eq!(history.run.outcome, RunOutcome::Complete);
    let step = history.steps.last().expect("converged");
    assert!(step.penetration < 1e-3, "{}", step.penetration);
    (step.energy, step.reactions[0].norm())
}

#[test]
fn a_slit_bears_pressure() {
    let linear = LinearElastic::new(100.0, 0.0).expect("law");
    for angle in [0.0, 0.3, 1.1] {
        let (energy, _) = slit(0.0, angle, linear, 1);
        assert!(relative(energy, 0.5) < 1e-6, "turned by {angle}: {energy}");
        let (energy, _) = slit_integrated(Integration::Exact, 0.0, angle, linear, 1);
        assert!(relative(energy, 0.5) < 1e-6, "turned by {angle}: {energy}");
    }
    // neo-Hookean: ψ = μ/2 (F² − 1 − 2 ln F) with F = 0.95 and μ = 50, over an area of 4
    let exact = 4.0 * 25.0 * (0.95f64.powi(2) - 1.0 - 2.0 * 0.95f64.ln());
    let large = NeoHookean::new(100.0, 0.0).expect("law");
    for (angle, increments) in [(0.0, 4), (0.3, 4), (1.1, 1)] {
        let (energy, _) = slit(0.0, angle, large, increments);
        assert!(
            relative(energy, exact) < 1e-6,
            "turned by {angle}: {energy}"
        );
    }
    // a gap of 1e-3 or 1e-2 is closed first, in however many increments
    for (gap, tolerance) in [(1e-3, 0.03), (1e-2, 0.3)] {
        let [one, ten] = [1, 10].map(|increments| slit(gap, 0.3, large, increments).0);
        assert!(relative(one, ten) < 1e-6, "{one} {ten}");
        assert!(one < exact && relative(one, exact) < tolerance, "{one}");
    }
}
