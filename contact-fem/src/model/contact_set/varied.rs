//! How gaps and contact forces vary, against differences of rows that are projected anew at every state.

use contact_core::{ContactProblem, GapVariation, LoadStepped};

use super::*;
use crate::element::{Element, P1, P2};
use crate::mesh::Mesh;
use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use crate::model::{Body, Obstacle, Problem};
use crate::{LinearElastic, Material, NeoHookean};

/// Central differences of fourth order: (coefficient, multiple of the step).
const DIFFERENCE: [(f64, f64); 4] = [
    (1.0 / 12.0, -2.0),
    (-2.0 / 3.0, -1.0),
    (2.0 / 3.0, 1.0),
    (-1.0 / 12.0, 2.0),
];
/// The step of the differences, for velocities of at most 1, and one to compare it with.
const STEP: f64 = 2e-4;
const SMALLER: f64 = 1e-4;
/// The agreement, relative to the largest slope. A foot on a curved facet is accurate to 1e-8, which the difference of
/// forces divides by the step.
const FLAT: f64 = 1e-8;
const CURVED: f64 = 2e-5;
/// Cuts move, and with them errors of quadrature.
const CUT: f64 = 5e-3;
/// Within a narrow turn slopes change fast, and the differences are less accurate.
const TURN: f64 = 1e-6;

/// A number between −`size` and `size` for each `k`.
fn bump(k: usize, size: f64) -> f64 {
    let bits = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    size * ((bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
}

/// A wavy change of shape.
fn wavy<const D: usize>(X: &Vector<D>) -> Vector<D> {
    let wave = |i: usize| 0.02 * (3.0 * X.sum() + 2.0 * X[(i + 1) % D] + i as f64).sin();
    X + Vector::from_fn(|i, _| wave(i))
}

/// Two blocks whose wavy faces lie on each other, with other meshes; the lower one comes first.
fn blocks<const D: usize>(
    bodies: [(Mesh<D>, impl Material<D>); 2],
    (passes, projection): (Passes, Projection),
    integration: Integration,
) -> Problem<D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let mut scene = Scene::new();
    let held = ["bottom", "top"];
    let mut sides = Vec::new();
    for (k, (mesh, law)) in bodies.into_iter().enumerate() {
        let mut body = Body::new(mesh.mapped(wavy).expect("a mesh"), law);
        let mut value = [Some(0.0); D];
        value[0] = Some(0.05 * k as f64);
        body.prescribe(held[k], value).expect("a boundary");
        sides.push(scene.add(held[k], body).on(held[1 - k]));
    }
    let [lower, upper] = [0, 1].map(|k| sides[k].clone());
    scene
        .contact_in_passes(lower, upper, passes)
        .expect("a pair");
    scene.integration = Some(integration);
    scene.projection = projection;
    scene.overlaps = crate::model::Overlaps::Allowed;
    let mut problem = scene.problem().expect("a problem");
    problem.set_load(1.0).expect("a load");
    problem
}

fn neo_hookean<const D: usize>(mesh: Mesh<D>) -> (Mesh<D>, NeoHookean) {
    (mesh, NeoHookean::new(1.0, 0.0).expect("a law"))
}

fn plane(is_quadratic: bool, passes: Passes, projection: Projection) -> Problem<2> {
    plane_with(is_quadratic, (passes, projection), Integration::Gauss(4))
}

fn plane_with(
    is_quadratic: bool,
    how: (Passes, Projection),
    integration: Integration,
) -> Problem<2> {
    let mesh = |y: f64, cells: usize| {
        let (xs, ys) = (linspace(0.0, 1.0, cells), linspace(y, y + 0.5, 2));
        let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
        if is_quadratic { mesh.quadratic() } else { mesh }
    };
    blocks(
        [mesh(0.0, 5), mesh(0.5, 7)].map(neo_hookean),
        how,
        integration,
    )
}

fn space(is_quadratic: bool, passes: Passes, projection: Projection) -> Problem<3> {
    let mesh = |z: f64, cells: usize| {
        let mesh = cuboid([0.0, 0.0, z], [1.0, 1.0, 0.5], [cells, cells, 1]).expect("a mesh");
        if is_quadratic { mesh.quadratic() } else { mesh }
    };
    // along normals, some rows have to be away from the rims
    let cells = match projection {
        Projection::Closest => [2, 3],
        Projection::AlongNormals => [4, 5],
    };
    blocks(
        [mesh(0.0, cells[0]), mesh(0.5, cells[1])].map(neo_hookean),
        (passes, projection),
        Integration::Gauss(2),
    )
}

/// A band folded to a U, whose arms nearly touch, under self-contact.
fn fold(projection: Projection) -> Problem<2> {
    let (xs, ys) = (linspace(-1.0, 1.0, 12), linspace(0.0, 1.0, 1));
    let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
    // the arms are straight, the turn is half a circle
    let folded = |X: &Vector<2>| {
        let (radius, turn) = (0.1 + 0.25 * X[1], 0.5);
        let angle = (X[0] / turn).clamp(-1.0, 1.0) * std::f64::consts::FRAC_PI_2;
        let arm = (X[0].abs() - turn).max(0.0);
        Vector::<2>::new(2.0 * arm - radius * angle.cos(), radius * angle.sin())
    };
    let mut mesh = mesh.mapped(folded).expect("a mesh");
    mesh.name_boundary("skin", |_| true);
    let mut body = Body::new(mesh, NeoHookean::new(1.0, 0.0).expect("a law"));
    body.prescribe_nodes(&[0], [Some(0.0); 2]).expect("a node");
    let mut scene = Scene::new();
    let band = scene.add("band", body);
    scene.self_contact(band.on("skin")).expect("a pair");
    scene.integration = Some(Integration::Gauss(3));
    scene.projection = projection;
    scene.reach = Some(0.4);
    scene.overlaps = crate::model::Overlaps::Allowed;
    scene.problem().expect("a problem")
}

/// The rows of both roles at u.
fn rows<const D: usize>(problem: &Problem<D>, u: &[f64]) -> LinearGaps {
    let forward = problem.linearize_gaps(u, Sampling::Nodes).expect("rows");
    let reversed = problem.linearize_reversed(u, Sampling::Nodes);
    forward.and(reversed.expect("rows"))
}

/// c and Cᵀλ at u, of the same rows as `keys`; `None` if there are others.
fn gaps_and_forces<const D: usize>(
    problem: &Problem<D>,
    u: &[f64],
    keys: &[RowKey],
    lambda: &[f64],
) -> Option<[Vec<f64>; 2]> {
    let rows = rows(problem, u);
    if rows.keys() != keys {
        return None;
    }
    let (mut c, mut forces) = (vec![0.0; rows.len()], vec![0.0; u.len()]);
    rows.value(u, &mut c);
    rows.add_forces(lambda, &mut forces);
    Some([c, forces])
}

/// The differences of c and of Cᵀλ along `v`.
fn differences<const D: usize>(
    problem: &Problem<D>,
    (u, v): (&[f64], &[f64]),
    keys: &[RowKey],
    lambda: &[f64],
    step: f64,
) -> Option<[Vec<f64>; 2]> {
    let mut sums = [vec![0.0; keys.len()], vec![0.0; u.len()]];
    for (coefficient, steps) in DIFFERENCE {
        let moved: Vec<f64> = u.iter().zip(v).map(|(u, v)| u + steps * step * v).collect();
        let values = gaps_and_forces(problem, &moved, keys, lambda)?;
        for (sums, values) in sums.iter_mut().zip(&values) {
            let terms = sums.iter_mut().zip(values);
            terms.for_each(|(sum, value)| *sum += coefficient / step * value);
        }
    }
    Some(sums)
}

fn apart<'a>(a: impl IntoIterator<Item = &'a f64>, b: impl IntoIterator<Item = &'a f64>) -> f64 {
    let differences = a.into_iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

/// Compares the variation with differences at `states` states, along random directions. Directions along which another
/// facet or another row comes into play within the step are left out, and are few.
fn assert_varies_as_differences<const D: usize>(problem: &Problem<D>, within: f64, what: &str) {
    assert_rows_vary_as_differences(problem, |_| true, within, what);
}

/// Likewise, of the rows alone whose nodes are at X for which `matters`.
fn assert_rows_vary_as_differences<const D: usize>(
    problem: &Problem<D>,
    matters: impl Fn(&Vector<D>) -> bool,
    within: f64,
    what: &str,
) {
    let at = |node: usize| problem.reference().get(node);
    assert_rows_of(problem, |node| at(node).is_none_or(&matters), within, what);
}

/// Likewise, of the rows alone whose names `matter`.
fn assert_rows_of<const D: usize>(
    problem: &Problem<D>,
    matters: impl Fn(usize) -> bool,
    within: f64,
    what: &str,
) {
    let (states, directions) = (3, 6);
    let n = problem.dofs().free();
    let (mut compared, mut errors) = (0, [0.0f64; 2]);
    for state in 0..states {
        let u: Vec<f64> = (0..n).map(|k| bump(k + 1000 * state, 0.02)).collect();
        let gaps = rows(problem, &u);
        assert!(gaps.len() > 3 && !gaps.is_exact(), "{what}: {}", gaps.len());
        // some rows act, some are asked for without a force, the others are not asked for
        let name = |i: usize| gaps.keys()[i].node as usize;
        let mut asked: Vec<Option<f64>> = vec![None; gaps.len()];
        let mattering = (0..gaps.len()).filter(|i| matters(name(*i)));
        for (k, i) in mattering.enumerate() {
            asked[i] = match k % 5 {
                4 => None,
                3 => Some(0.0),
                _ => Some(1.0 + bump(i + 7 * state, 0.9)),
            };
        }
        let lambda: Vec<f64> = asked.iter().map(|l| l.unwrap_or(0.0)).collect();
        let variation = problem.vary_gaps(&u, &gaps, &asked).expect("rows");
        let variation = variation.expect("rows that move");
        assert_stiffness(&variation, n, what);
        for direction in 0..directions {
            let v: Vec<f64> = (0..n)
                .map(|k| bump(k + 100_000 * (direction + 1) + 1000 * state, 1.0))
                .collect();
            let by = |step| {
                let mut found = differences(problem, (&u, &v), gaps.keys(), &lambda, step)?;
                let rows = found[0].iter_mut().enumerate();
                let others = rows.filter(|(i, _)| !matters(name(*i)));
                others.for_each(|(_, slope)| *slope = 0.0);
                Some(found)
            };
            let (Some(large), Some(small)) = (by(STEP), by(SMALLER)) else {
                continue;
            };
            let scales = [0, 1].map(|k| apart(&small[k], &vec![0.0; small[k].len()]));
            // errors are shares of the largest slopes, which must be no round-off
            assert!(
                scales.iter().all(|scale| *scale > 0.01),
                "{what}: {scales:?}"
            );
            if (0..2).any(|k| apart(&large[k], &small[k]) > within * scales[k]) {
                continue;
            }
            compared += 1;
            let y = variation.internal(&v);
            let mut forces = vec![0.0; n];
            variation.add_forces(&v, &y, &mut forces);
            errors[1] = errors[1].max(apart(&forces, &small[1]) / scales[1]);
            for (i, slope) in small[0].iter().enumerate() {
                let found = variation.gap(i, &v, &y);
                match asked[i] {
                    Some(_) => errors[0] = errors[0].max((found - slope).abs() / scales[0]),
                    None => assert_eq!(found, 0.0, "{what}: a row that was not asked for"),
                }
            }
        }
    }
    println!(
        "{what}: {compared} compared, gaps {:e}, forces {:e}",
        errors[0], errors[1]
    );
    assert!(
        3 * compared > 2 * states * directions,
        "{what}: {compared} compared"
    );
    assert!(errors.iter().all(|e| *e < within), "{what}: {errors:?}");
}

/// The entries of D summed to a matrix, against D and Dᵀ times the unit vectors.
fn assert_stiffness(variation: &GapVariation, n: usize, what: &str) {
    let mut dense = vec![0.0; n * n];
    let mut largest = 0.0f64;
    for (i, j, d) in variation.stiffness() {
        dense[i + n * j] += d;
        largest = largest.max(d.abs());
    }
    assert!(largest > 0.0, "{what}");
    for j in 0..n {
        let mut unit = vec![0.0; n];
        unit[j] = 1.0;
        let mut column = vec![0.0; n];
        variation.add_forces(&unit, &variation.internal(&unit), &mut column);
        let error = apart(&column, &dense[n * j..n * (j + 1)]);
        assert!(error < 1e-13 * largest, "{what}: column {j}, {error:e}");
        let mut row = vec![0.0; n];
        variation.add_transposed_forces(&unit, &mut row);
        let dense_row: Vec<f64> = (0..n).map(|k| dense[j + n * k]).collect();
        let error = apart(&row, &dense_row);
        assert!(error < 1e-13 * largest, "{what}: row {j}, {error:e}");
    }
}

/// Nodes that touch and slide along planes, of which some move.
#[test]
fn nodes_that_slide() {
    let mut scene = Scene::new();
    let mut sides = Vec::new();
    for (k, cells) in [8, 7].into_iter().enumerate() {
        let y = 0.5 * k as f64;
        let mesh = rectangle(&linspace(0.0, 1.0, cells), &[y, y + 0.5], Diagonals::Rising);
        let mesh = mesh.and_then(|mesh| mesh.mapped(wavy)).expect("a mesh");
        let mut body = Body::new(mesh, NeoHookean::new(1.0, 0.3).expect("a law"));
        let (held, touches) = [("bottom", "top"), ("top", "bottom")][k];
        body.prescribe(held, [Some(0.05 * k as f64); 2])
            .expect("a boundary");
        let mut nodes = body.mesh().boundary_nodes(touches).expect("a boundary");
        nodes.truncate(3);
        body.prescribe_nodes_along(&nodes, [1.0, -0.8], 0.01 * k as f64)
            .expect("rollers");
        sides.push(scene.add(held, body).on(touches));
    }
    scene
        .contact(sides[0].clone(), sides[1].clone())
        .expect("a pair");
    scene.integration = Some(Integration::Gauss(4));
    let mut problem = scene.problem().expect("a problem");
    problem.set_load(1.0).expect("a load");
    assert_eq!(problem.dofs().ties().len(), 6);
    let inner = is_inner(Projection::AlongNormals);
    assert_rows_vary_as_differences(&problem, inner, FLAT, "nodes that slide");
}

const PASSES: [Passes; 3] = [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave];
const PROJECTIONS: [Projection; 2] = [Projection::Closest, Projection::AlongNormals];

fn segments(is_quadratic: bool, within: f64) {
    for (passes, projection) in PASSES.iter().flat_map(|p| PROJECTIONS.map(|by| (*p, by))) {
        let what = format!("segments, {passes:?}, {projection:?}");
        let problem = plane(is_quadratic, passes, projection);
        assert_varies_as_differences(&problem, within, &what);
    }
}

/// Rows whose points are all away from the rims: along normals, the weights of points fade near them with kinks, between which differences in space
/// find no way.
fn is_inner<const D: usize>(projection: Projection) -> impl Fn(&Vector<D>) -> bool {
    move |X| {
        let inner = X.iter().take(D - 1).all(|x| (0.3..0.7).contains(x));
        projection == Projection::Closest || inner
    }
}

fn triangles(is_quadratic: bool, within: f64) {
    for (passes, projection) in PASSES.iter().flat_map(|p| PROJECTIONS.map(|by| (*p, by))) {
        let what = format!("triangles, {passes:?}, {projection:?}");
        let problem = space(is_quadratic, passes, projection);
        assert_rows_vary_as_differences(&problem, is_inner(projection), within, &what);
    }
}

/// Where facets are cut, rows vary by what they gain at the ends of the master, too. Left out are errors of quadrature, which move with the
/// cuts: of straight segments at an angle they are small.
#[test]
fn cut_segments() {
    for passes in PASSES {
        let what = format!("cut segments, {passes:?}");
        let how = (passes, Projection::AlongNormals);
        let problem = plane_with(false, how, Integration::Exact);
        assert_varies_as_differences(&problem, CUT, &what);
    }
}

#[test]
fn linear_segments() {
    segments(false, FLAT);
}

#[test]
fn quadratic_segments() {
    segments(true, CURVED);
}

#[test]
fn linear_triangles() {
    triangles(false, FLAT);
}

#[test]
fn quadratic_triangles() {
    triangles(true, CURVED);
}

#[test]
fn self_contact() {
    // in the turn and at the tips, surfaces are at right angles, and the weights of points vary, which is not a part of the variation
    let on_the_arms = |X: &Vector<2>| X[0] > 0.25 && X[0] < 0.9;
    for projection in [Projection::Closest, Projection::AlongNormals] {
        let what = format!("self-contact, {projection:?}");
        assert_rows_vary_as_differences(&fold(projection), on_the_arms, TURN, &what);
    }
}

/// A wavy block whose lower side is on an obstacle.
fn on_obstacle<const D: usize>(mesh: Mesh<D>, obstacle: Obstacle<D>) -> Problem<D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let (mesh, law) = neo_hookean(mesh.mapped(wavy).expect("a mesh"));
    let mut body = Body::new(mesh, law);
    body.prescribe("top", [Some(0.05); D]).expect("a boundary");
    let mut scene = Scene::new();
    let side = scene.add("block", body).on("bottom");
    scene.obstacle("obstacle", side, obstacle).expect("a side");
    scene.integration = Some(Integration::Gauss(3));
    scene.overlaps = crate::model::Overlaps::Allowed;
    scene.overlap_tolerance = 10.0;
    scene.reach = Some(10.0);
    let mut problem = scene.problem().expect("a problem");
    problem.set_load(1.0).expect("a load");
    problem
}

/// Curved obstacles, as shapes and as distances of one's own.
#[test]
fn obstacles() {
    let square = |is_quadratic: bool| {
        let (xs, ys) = (linspace(0.0, 1.0, 5), linspace(0.0, 0.5, 2));
        let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
        if is_quadratic { mesh.quadratic() } else { mesh }
    };
    let cube = |is_quadratic: bool| {
        let mesh = cuboid([0.0; 3], [1.0, 1.0, 0.5], [2, 2, 1]).expect("a mesh");
        if is_quadratic { mesh.quadratic() } else { mesh }
    };
    let disc = || Obstacle::ball([0.4, -0.7], 0.7).expect("a disc");
    let cylinder = || Obstacle::cylinder([0.0, 0.4, -0.7], [1.0, 0.2, 0.1], 0.7);
    for is_quadratic in [false, true] {
        let problem = on_obstacle(square(is_quadratic), disc());
        assert_varies_as_differences(&problem, FLAT, "a disc");
        let problem = on_obstacle(cube(is_quadratic), cylinder().expect("a cylinder"));
        assert_varies_as_differences(&problem, FLAT, "a cylinder");
    }
    let own = Obstacle::signed_distance(|x: &Vector<2>| (x[0] - 0.4).hypot(x[1] + 0.7) - 0.7);
    // curvatures are differences as well
    assert_varies_as_differences(&on_obstacle(square(false), own), TURN, "a distance");
}

/// Corners of a body on a larger one and on an obstacle, and those of a polygon in front of a body: with their rows alone.
#[test]
fn corners() {
    // facets of one size: by a twentieth of it, which varies with the foot of the tip, the tip may dig in
    let block = |x: [f64; 2], y: [f64; 2], cells: usize| {
        let (xs, ys) = (linspace(x[0], x[1], cells), linspace(y[0], y[1], 2));
        neo_hookean(rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh"))
    };
    let mut scene = Scene::new();
    let mut sides = Vec::new();
    let bodies = [
        block([0.0, 2.0], [0.0, 0.5], 7),
        block([0.6, 1.3], [0.5, 1.0], 3),
    ];
    for (k, (mesh, law)) in bodies.into_iter().enumerate() {
        let mut body = Body::new(mesh, law);
        let held = ["left", "top"][k];
        body.prescribe(held, [Some(0.0); 2]).expect("a boundary");
        sides.push(scene.add(["base", "block"][k], body));
    }
    let [base, block] = [0, 1].map(|k| sides[k]);
    scene
        .contact(base.on("top"), block.on("bottom"))
        .expect("a pair");
    let wedge = [[0.3, 0.02], [0.1, -0.4], [0.6, -0.4]];
    let wedge = Obstacle::surface(&wedge, &[[0, 1], [1, 2], [2, 0]]).expect("a wedge");
    scene
        .obstacle("wedge", base.on("bottom"), wedge)
        .expect("a side");
    let plane = Obstacle::half_space([2.02, 0.0], [-1.0, 0.1]).expect("a plane");
    scene
        .obstacle("plane", base.on("right"), plane)
        .expect("a side");
    scene.overlaps = crate::model::Overlaps::Allowed;
    scene.overlap_tolerance = 10.0;
    scene.corners = Corners::Held;
    let problem = scene.problem().expect("a problem");
    let nodes = problem.reference().len();
    let u = vec![0.0; problem.dofs().free()];
    let gaps = rows(&problem, &u);
    let is_corner = |name: usize| name >= nodes;
    let corners = gaps
        .keys()
        .iter()
        .filter(|key| is_corner(key.node as usize));
    // the block's corners on the base and on the plane, the wedge's tip
    assert!(corners.count() >= 4);
    assert_rows_of(&problem, is_corner, FLAT, "corners");
}

/// Bars that cross, with the rows of their edges alone: four edges of the upper one across two of the lower one.
#[test]
fn edges() {
    let bar = |low: [f64; 3], size: [f64; 3]| {
        let mut mesh = cuboid(low, size, [1; 3]).expect("a mesh");
        mesh.name_boundary("all", |_| true);
        neo_hookean(mesh)
    };
    let mut scene = Scene::new();
    let lower = bar([-1.5, -0.5, -1.0], [3.0, 1.0, 1.0]);
    let upper = bar([-0.5, -1.5, 0.1], [1.0, 3.0, 1.0]);
    let [lower, upper] =
        [("lower", lower, "bottom"), ("upper", upper, "top")].map(|(name, (mesh, law), held)| {
            let mut body = Body::new(mesh, law);
            body.prescribe(held, [Some(0.0); 3]).expect("a boundary");
            scene.add(name, body).on("all")
        });
    scene.contact(lower, upper).expect("a pair");
    scene.corners = Corners::Held;
    let problem = scene.problem().expect("a problem");
    let slave = problem.passes()[0].slave;
    let first = problem.reference().len() + problem.surfaces()[slave].nodes().len();
    let u = vec![0.0; problem.dofs().free()];
    let gaps = rows(&problem, &u);
    let of_edges = gaps.keys().iter().filter(|key| key.node as usize >= first);
    assert!(of_edges.count() >= 4);
    assert_rows_of(&problem, |name| name >= first, FLAT, "edges");
}

/// Rows on a distance of one's own are those on the shape that has it.
#[test]
fn a_shape_and_its_distance_have_the_same_rows() {
    let mesh = || {
        let mesh = rectangle(&linspace(0.0, 1.0, 5), &[0.0, 0.5], Diagonals::Rising);
        mesh.expect("a mesh")
    };
    let shape = Obstacle::cavity([0.4, 0.9], 1.2).expect("a cavity");
    let own = Obstacle::signed_distance(|x: &Vector<2>| 1.2 - (x[0] - 0.4).hypot(x[1] - 0.9));
    let [shape, own] = [shape, own].map(|obstacle| on_obstacle(mesh(), obstacle));
    let u: Vec<f64> = (0..shape.dofs().free()).map(|k| bump(k, 0.02)).collect();
    let [a, b] = [&shape, &own].map(|problem| rows(problem, &u));
    assert!(a.len() == 6 && a.keys() == b.keys());
    assert!(apart(a.constant(), b.constant()) < 1e-10);
    for ((i, j, c), (k, l, d)) in a.entries().zip(b.entries()) {
        assert!((i, j) == (k, l) && (c - d).abs() < 1e-10, "{c} {d}");
    }
}

/// Under small strains the rows do not move, and there is nothing to vary.
#[test]
fn rows_of_the_reference_do_not_vary() {
    let mesh = |y: f64| {
        let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 0.5], Diagonals::Rising);
        mesh.expect("a mesh")
    };
    let law = || LinearElastic::new(1.0, 0.0).expect("a law");
    let problem = blocks(
        [mesh(0.0), mesh(0.5)].map(|mesh| (mesh, law())),
        (Passes::Both, Projection::default()),
        Integration::Gauss(4),
    );
    let u = vec![0.0; problem.dofs().free()];
    let gaps = rows(&problem, &u);
    assert!(!gaps.is_empty());
    let asked = vec![Some(1.0); gaps.len()];
    let variation = problem.vary_gaps(&u, &gaps, &asked).expect("rows");
    assert!(variation.is_none());
}
