use super::topology::Topology;
use super::*;
use crate::element::{Element, P1, P2};
use crate::mesh::generators::{Diagonals, annulus, cuboid, extrude, linspace, rectangle, sphere};
use crate::model::{Body, Scene};
use crate::tensor::facet_normal;
use crate::{LinearElastic, Mesh, NeoHookean};

fn scene<const D: usize>(meshes: Vec<Mesh<D>>) -> (Scene<D>, Vec<Vector<D>>)
where
    P1: Element<D>,
    P2: Element<D>,
{
    let X = meshes.iter().flat_map(|mesh| mesh.nodes().to_vec());
    let X = X.collect();
    let law = || NeoHookean::new(1.0, 0.3).expect("law");
    let bodies = meshes.into_iter().map(|mesh| Body::new(mesh, law()));
    (Scene::of(bodies.collect()), X)
}

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let [x, y] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
    rectangle(&x, &y, Diagonals::Alternating).expect("mesh")
}

/// The worst overlap of bodies where they are meshed.
fn overlap<const D: usize>(meshes: Vec<Mesh<D>>) -> Option<Overlap<D>>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let (scene, X) = scene(meshes);
    let overlaps = Audit::new(&scene, &X).at(&X).overlaps.into_iter();
    overlaps.max_by(|a, b| a.relative.total_cmp(&b.relative))
}

/// Simplices and faces fill a body and its exterior, with positive volumes and outward normals.
fn fills<const D: usize>(mesh: Mesh<D>, volume: f64)
where
    P1: Element<D>,
    P2: Element<D>,
{
    let (scene, X) = scene(vec![mesh]);
    let Topology { cells, faces, .. } = Topology::new(&scene, &X);
    let factorial = if D == 2 { 2.0 } else { 6.0 };
    let volumes = cells.iter().map(|cell| {
        let columns: [_; D] = std::array::from_fn(|i| X[cell.nodes[i + 1]] - X[cell.nodes[0]]);
        crate::tensor::determinant(&Matrix::from_columns(&columns)) / factorial
    });
    let volumes: Vec<f64> = volumes.collect();
    assert!(volumes.iter().all(|&v| v > 0.0));
    assert!((volumes.iter().sum::<f64>() - volume).abs() < 1e-12 * volume);
    // ∫ x·n dA = D · volume over the same polyhedron
    let flux = faces.iter().map(|face| {
        let corners = face.nodes.map(|a| X[a]);
        corners
            .iter()
            .sum::<Vector<D>>()
            .dot(&facet_normal(&corners))
            / D as f64
    });
    let flux: f64 = flux.sum();
    assert!((flux - D as f64 * volume).abs() < 1e-12 * volume, "{flux}");
}

#[test]
fn simplices_fill_bodies() {
    fills(block([0.0; 2], [2.0, 3.0], [3, 2]), 6.0);
    fills(block([0.0; 2], [2.0, 3.0], [3, 2]).quadratic(), 6.0);
    let cube = || cuboid([0.5; 3], [1.0, 2.0, 3.0], [2, 1, 2]).expect("mesh");
    fills(cube(), 6.0);
    fills(cube().quadratic(), 6.0);
    let ball = sphere(1.0, 2).expect("mesh");
    let volume = (0..ball.len()).map(|k| ball.volume(k)).sum();
    fills(ball.quadratic(), volume);
}

#[test]
fn the_thickness_behind_a_face() {
    let (scene, X) = scene(vec![block([0.0; 2], [4.0, 0.01], [8, 1])]);
    let topology = Topology::new(&scene, &X);
    for face in &topology.faces {
        let thickness = if face.size > 0.1 { 0.01 } else { f64::INFINITY };
        assert!(face.thickness == thickness || (face.thickness - thickness).abs() < 1e-15);
    }
    assert!((topology.thinnest() - 0.01).abs() < 1e-15);
}

#[test]
fn bodies_that_touch_do_not_overlap() {
    let lower = || block([0.0; 2], [1.0, 1.0], [2, 2]);
    assert_eq!(overlap(vec![lower()]), None);
    let touching = block([0.3, 1.0], [1.0, 1.0], [3, 3]);
    assert_eq!(overlap(vec![lower(), touching]), None);
    let cubes = [0.0, 1.0].map(|z| cuboid([0.2 * z, 0.0, z], [1.0; 3], [2, 2, 2]).expect("mesh"));
    assert_eq!(overlap(cubes.to_vec()), None);
}

/// A node at depth d in a body with facets of length ½, and in one that is thinner.
#[test]
fn depths_are_shares_of_facets_or_of_the_thickness() {
    let lower = |thickness: f64| block([0.0, -thickness], [2.0, thickness], [4, 1]);
    let upper = |y: f64| block([0.6, y], [0.5, 0.5], [1, 1]);
    let found = overlap(vec![lower(1.0), upper(-0.1)]).expect("overlaps");
    assert!((found.depth - 0.1).abs() < 1e-14, "{found:?}");
    assert!((found.relative - 0.2).abs() < 1e-14, "{found:?}");
    let found = overlap(vec![lower(0.01), upper(-0.004)]).expect("overlaps");
    assert!((found.depth - 0.004).abs() < 1e-14, "{found:?}");
    assert!((found.relative - 0.4).abs() < 1e-13, "{found:?}");
}

/// Two bars cross edge on edge: no node of one is in the other.
#[test]
fn bars_that_cross() {
    let along = cuboid([-2.0, -0.1, -0.1], [4.0, 0.2, 0.2], [1, 1, 1]).expect("mesh");
    let across = cuboid([-0.1, -2.0, 0.0], [0.2, 4.0, 0.2], [1, 1, 1]).expect("mesh");
    let found = overlap(vec![along, across]).expect("overlaps");
    assert_ne!(found.bodies[0], found.bodies[1]);
    // the lower edges of the upper bar are at half the height of the lower one
    assert!((found.depth - 0.1).abs() < 1e-14, "{found:?}");
}

/// A strip whose right end is folded over onto, and into, its left end.
#[test]
fn a_body_in_itself() {
    let strip = block([0.0; 2], [8.0, 0.5], [16, 1]);
    let (scene, X) = scene(vec![strip]);
    let audit = Audit::new(&scene, &X);
    let fold = |gap: f64| -> Vec<Vector<2>> {
        let bent = |X: &Vector<2>| {
            // a half circle around (4, ½ + gap/2), with straight arms
            let (radius, from) = (0.5 + gap / 2.0 - X[1], 2.5);
            let turn = (X[0] - from) / 3.0 * std::f64::consts::PI;
            let centre = Vector::<2>::new(from, 0.5 + gap / 2.0);
            match turn {
                t if t <= 0.0 => *X,
                t if t < std::f64::consts::PI => {
                    centre + Vector::<2>::new(t.sin(), -t.cos()) * radius
                }
                _ => Vector::<2>::new(centre[0] - (X[0] - 5.5), 2.0 * centre[1] - X[1]),
            }
        };
        X.iter().map(bent).collect()
    };
    assert!(audit.at(&fold(1.0)).overlaps.is_empty());
    let found = audit.at(&fold(-0.1)).overlaps[0];
    assert_eq!(found.bodies, [0, 0]);
    assert!(found.depth > 0.04, "{found:?}");
}

/// A block that jumps over a thin one in a single step.
#[test]
fn a_passage_between_two_states() {
    let wall = block([0.0, -0.1], [2.0, 0.1], [4, 1]);
    let (scene, before) = scene(vec![wall, block([0.6, 0.1], [0.5, 0.5], [1, 1])]);
    let audit = Audit::new(&scene, &before);
    let moved = |by: f64| {
        let wall = |a: usize| a < scene.bodies()[0].mesh().nodes().len();
        let step = |a: usize| Vector::<2>::new(0.0, if wall(a) { 0.0 } else { by });
        let x = before.iter().enumerate().map(|(a, x)| x + step(a));
        x.collect::<Vec<_>>()
    };
    let below = moved(-1.0);
    assert!(
        audit.at(&below).overlaps.is_empty(),
        "the ends tell nothing"
    );
    assert!(audit.passage(&before, &below, |_| 0.0).is_some());
    assert_eq!(audit.passage(&before, &moved(3.0), |_| 0.0), None);
}

#[test]
fn strain_rotation_and_volume() {
    let mesh = block([0.0; 2], [1.0, 1.0], [2, 2]);
    let X = mesh.nodes().to_vec();
    let law = LinearElastic::new(1.0, 0.3).expect("law");
    let audit = Audit::new(&Scene::of(vec![Body::new(mesh, law)]), &X);
    let x: Vec<_> = X
        .iter()
        .map(|X| X + Vector::<2>::new(-1.2 * X[0] + 0.3 * X[1], 0.1 * X[0]))
        .collect();
    let found = audit.at(&x);
    // H = [−1.2 .3; .1 0]
    assert!((found.strain - (1.44f64 + 2.0 * 0.04).sqrt()).abs() < 1e-14);
    assert!((found.rotation - 0.1).abs() < 1e-14);
    let least = found.least_volume.expect("cells");
    assert!((least.bound + 0.2 + 0.03).abs() < 1e-14);
    assert_eq!(found.inverted, 8);
}

/// What an audit knows of earlier states changes nothing: a block comes down on another in steps of several lengths, passes into it
/// and goes back, and a bar is bent until its ends meet.
#[test]
fn earlier_states_do_not_matter() {
    let (two, X) = scene(vec![
        block([0.0, 0.0], [1.0, 1.0], [6, 6]),
        block([0.2, 1.3], [0.5, 0.5], [5, 5]),
    ]);
    let (bar, line) = scene(vec![block([0.0, 0.0], [6.0, 0.3], [60, 2])]);
    let down = |by: f64| -> Vec<Vector<2>> {
        let moved = |(a, X): (usize, &Vector<2>)| match two.bodies()[0].mesh().nodes().len() {
            lower if a < lower => *X,
            _ => X - Vector::<2>::new(0.0, by),
        };
        X.iter().enumerate().map(moved).collect()
    };
    let bent = |angle: f64| -> Vec<Vector<2>> {
        let curve = |X: &Vector<2>| {
            let (r, phi) = (6.0 / angle - X[1], angle * X[0] / 6.0);
            Vector::<2>::new(r * phi.sin(), -r * phi.cos())
        };
        line.iter().map(curve).collect()
    };
    let audits = [Audit::new(&two, &X), Audit::new(&bar, &line)];
    let mut counts = [0; 2];
    let mut check = |k: usize, x: Vec<Vector<2>>| {
        let scene = [&two, &bar][k];
        let fresh = Audit::new(scene, [&X, &line][k]);
        // of all cells, near an exterior edge or not
        let cells = fresh
            .topology
            .cells
            .iter()
            .map(|cell| aabb(&cell.nodes[..=2], &x));
        let faces = fresh
            .topology
            .faces
            .iter()
            .map(|face| aabb(&face.nodes, &x));
        let trees = Trees {
            cells: tree(cells.enumerate()),
            faces: tree(faces.enumerate()),
        };
        let found = audits[k].at(&x);
        let mut expected = fresh.nodes_inside(&x, &trees);
        expected.extend(fresh.edges_inside(&x, &trees));
        assert_eq!(audits[k].overlaps(&x), expected);
        assert_eq!(found.overlaps.is_empty(), expected.is_empty());
        counts[usize::from(expected.is_empty())] += 1;
    };
    let mut by = 0.0;
    for step in [1e-3, 7e-3, 0.03, 0.11, -0.02, -0.2] {
        for _ in 0..(0.4_f64 / f64::abs(step)).min(60.0) as usize {
            by = (by + step).max(0.0);
            check(0, down(by));
        }
    }
    for k in 1..=70 {
        check(1, bent(0.1 * f64::from(k)));
    }
    let [overlapping, clear] = counts;
    assert!(overlapping > 20 && clear > 80, "{overlapping} {clear}");
}

/// A shaft of chords that has turned by half a chord in a hub of the same is in it by R (1 − cos π/n), which is what the chords leave of circles, in the plane
/// and in space with facets that are long along the axis. A block has edges and no sag.
#[test]
fn chords_in_chords_overlap_by_their_sag() {
    for count in [12, 16, 23, 40] {
        let ring = |inside: f64, outside: f64| {
            annulus(&[inside, outside], count, Diagonals::Rising).expect("mesh")
        };
        let plane = vec![ring(1.0, 1.5), ring(0.5, 1.0)];
        let long = |mesh: &Mesh<2>| extrude(mesh, &[0.0, 3.0, 6.0], ["low", "high"]).expect("mesh");
        let space: Vec<Mesh<3>> = plane.iter().map(long).collect();
        // cells of straight sides
        turned_by_half_a_chord(plane.iter().cloned().map(Mesh::quadratic).collect(), count);
        turned_by_half_a_chord(space.iter().cloned().map(Mesh::quadratic).collect(), count);
        turned_by_half_a_chord(plane, count);
        turned_by_half_a_chord(space, count);
    }
    let blocks = [
        block([0.0, 0.0], [2.0, 1.0], [4, 2]),
        block([0.5, 0.9], [1.0, 1.0], [3, 3]),
    ];
    assert_eq!(overlap(blocks.into()).expect("an overlap").sag, 0.0);
}

fn turned_by_half_a_chord<const D: usize>(meshes: Vec<Mesh<D>>, count: usize)
where
    P1: Element<D>,
    P2: Element<D>,
{
    let first = meshes[0].nodes().len();
    let (scene, mut X) = scene(meshes);
    let audit = Audit::new(&scene, &X);
    let half = std::f64::consts::PI / count as f64;
    for x in &mut X[first..] {
        let (sin, cos) = half.sin_cos();
        (x[0], x[1]) = (cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]);
    }
    let found = audit.at(&X).overlaps;
    let deepest = found.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
    let deepest = deepest.expect("an overlap");
    let sag = 1.0 - half.cos();
    for own in [deepest.depth, deepest.sag] {
        assert!((own / sag - 1.0).abs() < 1e-9, "{count} in {D}D: {own}");
    }
}
