//! Many bodies, whose pairs are found, and bodies that touch themselves.

use crate::common::{relative, run, run_with};
use contact_core::Ending;
use contact_core::InteriorPoint;
use contact_fem::contact::projection::{closest, interpolate};
use contact_fem::element::{Element, P1, P2};
use contact_fem::mesh::Mesh;
use contact_fem::mesh::generators::{Diagonals, equilateral_disc, linspace, rectangle};
use contact_fem::model::{Integration, Overlaps};
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{Body, LinearElastic, Material, NeoHookean, Scene};
use ipopt_contact_scenes::hairpin;

const DISCS: usize = 4;

/// Four discs on each other between a floor and a lid that comes down; each disc is held on its
/// vertical diameter against rolling. All meshes are their own mirror images in x = 0, and that of
/// the stack is in its middle. `order` is the bodies' order: discs from below, floor, lid.
fn stack(order: &[usize]) -> (Scene<2>, Vec<usize>) {
    let law = NeoHookean::new(1e3, 0.3).expect("law");
    let disc = |k: usize| {
        let mesh = equilateral_disc(1.0, 8).expect("mesh");
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
    let mut scene = Scene::new();
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
        let body = scene.add(k.to_string(), body);
        scene.contact_surface(body.on(surface)).expect("declared");
    }
    let place = (0..DISCS + 2).map(|k| order.iter().position(|o| *o == k));
    (scene, place.map(|p| p.expect("all bodies")).collect())
}

/// The supports' force on each body and its nodes, as place and displacement, in the order discs
/// from below, floor, lid.
fn solved(order: &[usize]) -> (Vec<Vector<2>>, Vec<Vec<[Vector<2>; 2]>>) {
    let (scene, place) = stack(order);
    let mut problem = scene.problem().expect("valid scene");
    assert_eq!(problem.scene().pairs().len(), 15, "every two of six bodies");
    let history = run(&mut problem, 4, 1e-9);
    assert_eq!(history.run.cuts(), 0);
    let step = history.steps.last().expect("converged");
    let size = problem.surfaces()[0].facet_size();
    assert!(step.penetration < 0.1 * size, "{}", step.penetration);
    let U = problem.displacements(&history.run.state.u);
    let of = |&body: &usize| {
        let nodes = problem.nodes(body).map(|a| [problem.reference()[a], U[a]]);
        (step.reactions[body], nodes.collect())
    };
    place.iter().map(of).unzip()
}

/// The largest |u(X) − image(u(mirror(X)))| over the nodes X of a body and those of its mirror image.
fn asymmetry(
    body: &[[Vector<2>; 2]],
    other: &[[Vector<2>; 2]],
    mirror: impl Fn(&Vector<2>) -> Vector<2>,
    image: impl Fn(&Vector<2>) -> Vector<2>,
) -> f64 {
    let there = |X: &Vector<2>| {
        let found = other.iter().find(|[Y, _]| (Y - X).norm() < 1e-9);
        found.expect("a mirror image")[1]
    };
    let error = |[X, u]: &[Vector<2>; 2]| (u - image(&there(&mirror(X)))).amax();
    body.iter().map(error).fold(0.0, f64::max)
}

/// Every contact of the stack passes the same force on, both halves and both sides are squeezed
/// alike, and the order of the bodies does not matter.
#[test]
fn a_stack_of_discs() {
    let (reactions, bodies) = solved(&[0, 1, 2, 3, 4, 5]);
    let (floor, lid) = (reactions[DISCS], reactions[DISCS + 1]);
    assert!(floor[1] > 10.0);
    // nothing but floor and lid bears the load
    assert!(relative(-lid[1], floor[1]) < 1e-8, "{floor} {lid}");
    let all: Vector<2> = reactions.iter().sum();
    assert!(all.norm() < 1e-8 * floor[1], "{all}");
    for reaction in &reactions[..DISCS] {
        // the diameters only hold against rolling, for which nothing gives cause
        let sideways = reaction[0].abs();
        assert!(
            reaction[1] == 0.0 && sideways < 1e-7 * floor[1],
            "{reaction} {floor}"
        );
    }
    for k in 0..DISCS {
        let sides = asymmetry(
            &bodies[k],
            &bodies[k],
            |X| Vector::<2>::new(-X[0], X[1]),
            |u| Vector::<2>::new(-u[0], u[1]),
        );
        // as seen from the middle of the stack each end comes by half
        let height = 2.0 * DISCS as f64;
        let halves = asymmetry(
            &bodies[k],
            &bodies[DISCS - 1 - k],
            |X| Vector::<2>::new(X[0], height - X[1]),
            |u| Vector::<2>::new(u[0], -0.4 - u[1]),
        );
        let error = sides.max(halves);
        assert!(error < 1e-7 * 0.4, "disc {k}: {sides} {halves}");
    }

    let (others, same_bodies) = solved(&[3, 5, 0, 4, 2, 1]);
    assert!(relative(others[DISCS][1], floor[1]) < 1e-8);
    let pairs = bodies.iter().flatten().zip(same_bodies.iter().flatten());
    for ([X, u], [_, v]) in pairs {
        assert!((u - v).amax() < 1e-8, "{X} {u} {v}");
    }
}

/// The deepest that a node is inside a cell of another place of its own body: its distance from the
/// closest of all facets that it is not part of. Every node is held against every cell and facet.
fn deepest<const D: usize>(mesh: &Mesh<D>, x: &[Vector<D>]) -> f64 {
    let is_inside = |node: usize, cell: &[usize]| {
        let corner = x[cell[0]];
        let edges = Matrix::<D>::from_fn(|i, j| x[cell[j + 1]][i] - corner[i]);
        let inverse = contact_fem::tensor::inverse_transpose(&edges).transpose();
        let lambda = inverse * (x[node] - corner);
        lambda.iter().all(|l| *l > 0.0) && lambda.sum() < 1.0
    };
    let distance = |node: usize, facet: &[usize]| {
        let corners: [Vector<D>; D] = std::array::from_fn(|k| x[facet[k]]);
        let foot = interpolate(&closest(&x[node], &corners), &corners);
        (x[node] - foot).norm()
    };
    let mut exterior = mesh.exterior().flatten().copied().collect::<Vec<_>>();
    exterior.sort_unstable();
    exterior.dedup();
    let inside = exterior.into_iter().filter(|node| {
        let mut others = mesh.cells().filter(|cell| !cell.contains(node));
        others.any(|cell| is_inside(*node, cell))
    });
    let depth = |node: usize| {
        let others = mesh.exterior().filter(|facet| !facet.contains(&node));
        others
            .map(|facet| distance(node, facet))
            .fold(f64::INFINITY, f64::min)
    };
    inside.map(depth).fold(0.0, f64::max)
}

/// Thin slabs on each other, each of which may touch at its top and its bottom: none sees another
/// one's far side through it. With ν = 0 they are pressed like one slab.
#[test]
fn slabs_do_not_see_through_each_other() {
    const HEIGHT: f64 = 0.04;
    let slab = |k: usize| {
        let y = HEIGHT * k as f64;
        let (xs, ys) = (linspace(0.0, 1.0, 10 + k), linspace(y, y + HEIGHT, 1));
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
        Body::new(mesh, LinearElastic::new(100.0, 0.0).expect("law"))
    };
    let mut scene = Scene::new();
    for (k, side, held) in [
        (0, "bottom", [Some(0.0); 2]),
        (1, "left", [Some(0.0), None]),
        (2, "top", [Some(0.0), Some(-0.012)]),
    ] {
        let mut body = slab(k);
        body.prescribe(side, held).expect("support");
        let body = scene.add(k.to_string(), body);
        for side in ["top", "bottom"] {
            scene.contact_surface(body.on(side)).expect("declared");
        }
    }
    let mut problem = scene.problem().expect("no overlap");
    let history = run(&mut problem, 1, 1e-9);
    let step = history.steps.last().expect("converged");
    let (energy, rows) = (step.energy, step.rows);
    // a strain of 0.1 in a height of 0.12
    assert!(
        relative(energy, 0.5 * 100.0 * 0.01 * 0.12) < 1e-6,
        "{energy}"
    );
    // one row a node with a partner, and the outer slabs across the middle one
    assert_eq!(rows, 11 + 2 * 12 + 13 + 11 + 13);
}

/// The arms of a hairpin meet when they are pressed together, and close towards the fold.
/// Every node's place and displacement.
fn closes<const D: usize>(
    scene: Scene<D>,
    increments: usize,
    tolerance: f64,
) -> Vec<[Vector<D>; 2]> {
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, increments, tolerance);
    assert_eq!(history.run.ending, Ending::Complete);
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
    // nor does anything else of the band, by a search of its own
    let x = problem.positions(&history.run.state.u);
    let depth = deepest(problem.scene().bodies()[0].mesh(), &x);
    assert!(depth < 0.1 * size, "{depth} for facets of {size}");
    X.iter().zip(&U).map(|(X, u)| [*X, *u]).collect()
}

#[test]
fn a_hairpin_closes_on_itself() {
    let nodes = closes(hairpin::scene(3, true).expect("scene"), 8, 1e-9);
    // mesh, support and load are their own mirror images in y = 0
    let mirrored = |X: &Vector<2>| Vector::<2>::new(X[0], -X[1]);
    let error = asymmetry(&nodes, &nodes, mirrored, mirrored);
    assert!(error < 1e-6 * hairpin::PRESS, "{error}");
}

#[test]
fn so_does_one_in_space() {
    closes(hairpin::scene_in_space(2, 2).expect("scene"), 8, 1e-6);
}

/// The scene of one body that may touch itself, turned about the z axis. A node that is held in x or
/// y is held in both.
fn turned<const D: usize>(scene: &Scene<D>, turn: Matrix<D>) -> Scene<D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let plain = &scene.bodies()[0];
    let mesh = plain.mesh().clone().mapped(|X| turn * X).expect("turned");
    let mut body = Body::new(mesh, NeoHookean::new(1e3, 0.3).expect("law"));
    for (node, held) in plain.prescribed().chunks_exact(D).enumerate() {
        let in_plane = held[..2].iter().any(Option::is_some);
        let u = turn * Vector::<D>::from_fn(|i, _| held[i].unwrap_or(0.0));
        let all = std::array::from_fn(|i| (held[i].is_some() || i < 2 && in_plane).then_some(u[i]));
        body.prescribe_nodes(&[node], all).expect("support");
    }
    let mut scene = Scene::new();
    let body = scene.add("body", body);
    scene.self_contact(body.on("skin")).expect("surface");
    scene
}

/// What a body that touches itself does, does not depend on the frame.
fn frame_does_not_matter<const D: usize>(scene: &Scene<D>, increments: usize)
where
    P1: Element<D>,
    P2: Element<D>,
{
    let solved = |angle: f64| {
        let mut turn = Matrix::<D>::identity();
        let (sin, cos) = angle.sin_cos();
        (turn[(0, 0)], turn[(0, 1)], turn[(1, 0)], turn[(1, 1)]) = (cos, -sin, sin, cos);
        let mut problem = turned(scene, turn).problem().expect("valid scene");
        // as for bodies in space: rows that are about to open
        let mut method = InteriorPoint {
            complementarity: 1e-14,
            ..InteriorPoint::default()
        };
        let history = run_with(&mut method, &mut problem, increments, 2e-11);
        assert_eq!(history.run.ending, Ending::Complete);
        let step = history.steps.last().expect("converged");
        assert!(step.rows > 3);
        let U = problem.displacements(&history.run.state.u);
        let back: Vec<Vector<D>> = U.iter().map(|u| turn.transpose() * u).collect();
        (back, step.energy)
    };
    let (plain, energy) = solved(0.0);
    let (other, same_energy) = solved(0.83);
    for (u, v) in plain.iter().zip(&other) {
        assert!((u - v).amax() < 1e-10 * hairpin::PRESS, "{u} {v}");
    }
    assert!(relative(same_energy, energy) < 1e-10);
}

#[test]
fn a_turned_hairpin_closes_alike() {
    frame_does_not_matter(&hairpin::scene(2, true).expect("scene"), 8);
    frame_does_not_matter(&hairpin::scene_in_space(1, 1).expect("scene"), 8);
}

/// However far it looks, only the insides of the arms see each other: facets further along the fold
/// are nearer to a point than the other arm, but not nearest to it within their own surroundings.
#[test]
fn a_long_reach_adds_no_contact() {
    let energies = [0.3, 10.0].map(|reach| {
        let mut scene = hairpin::scene(3, true).expect("scene");
        scene.reach = Some(reach);
        let mut problem = scene.problem().expect("valid scene");
        let X = problem.reference();
        let arms = X
            .iter()
            .filter(|X| X[0] >= 0.0 && (X[1].abs() - 0.2).abs() < 1e-9);
        let arms = arms.count();
        let history = run(&mut problem, 8, 1e-6);
        assert_eq!(history.run.ending, Ending::Complete);
        let step = history.steps.last().expect("converged");
        assert!(
            step.rows <= arms + 12,
            "{} rows for {arms} nodes",
            step.rows
        );
        step.energy
    });
    assert!(relative(energies[0], energies[1]) < 1e-8, "{energies:?}");
}

/// With facets cut along the other arm's; their own neighbours cut nothing.
#[test]
fn hairpins_integrated_exactly() {
    let mut plane = hairpin::scene(3, true).expect("scene");
    plane.integration = Some(Integration::Exact);
    closes(plane, 8, 1e-6);
    let mut space = hairpin::scene_in_space(2, 2).expect("scene");
    space.integration = Some(Integration::Exact);
    closes(space, 8, 1e-6);
}

/// The same hairpin without its self-contact: the arms pass through each other where that is allowed, and no certificate
/// of it holds. By default the run ends before and names the body.
#[test]
fn without_self_contact_the_arms_cross() {
    let scene = || hairpin::scene(3, false).expect("scene");
    let mut refused = scene().problem().expect("valid scene");
    let history = run(&mut refused, 8, 1e-6);
    let ending = history.run.ending.to_string();
    let place = "body `hairpin` is inside body `hairpin`";
    assert!(!history.is_complete() && ending.contains(place), "{ending}");
    let mut allowed = scene();
    allowed.overlaps = Overlaps::Allowed;
    let mut problem = allowed.problem().expect("valid scene");
    let history = run(&mut problem, 8, 1e-6);
    assert_eq!(history.run.ending, Ending::Complete);
    let certificate = history.certificate().expect("steps");
    assert!(!certificate.holds(&Default::default()));
    let U = problem.displacements(&history.run.state.u);
    let X = problem.reference();
    let arm = (0..X.len()).filter(|&a| hairpin::is_inside_of_upper_arm(&X[a]));
    let lowest = arm.map(|a| X[a][1] + U[a][1]).fold(f64::INFINITY, f64::min);
    assert!(lowest < -0.05, "{lowest}");
    let x = problem.positions(&history.run.state.u);
    let depth = deepest(problem.scene().bodies()[0].mesh(), &x);
    assert!(
        depth > 0.02,
        "what the others are measured by sees it: {depth}"
    );
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
    let mut scene = Scene::new();
    let body = scene.add("body", body);
    scene.integration = Some(integration);
    scene.self_contact(body.on("slit")).expect("a surface");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, increments, 1e-9);
    assert_eq!(history.run.ending, Ending::Complete);
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
