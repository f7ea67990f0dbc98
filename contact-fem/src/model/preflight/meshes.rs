//! The meshes of bodies: seams that are open, thin bodies, slivers.

use std::collections::BTreeSet;

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::limits::{COINCIDES, ROUNDED, SLIVER, THIN};
use super::{Finding, FindingKind, Report, Setup, Severity};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::model::{Pair, Side};
use crate::tensor::{Vector, facet_normal};

/// Finds seams, thin bodies and slivers.
pub(super) fn check<const D: usize>(setup: &Setup<'_, D>, report: &mut Report) {
    for body in 0..setup.scene.bodies().len() {
        seam(setup, body, report);
        thickness(setup, body, report);
        sliver(setup, body, report);
        far(setup, body, report);
    }
}

/// Compares the round-off of a body's coordinates with the smallest height of a cell.
fn far<const D: usize>(setup: &Setup<'_, D>, body: usize, report: &mut Report) {
    let (mesh, name) = (
        setup.scene.bodies()[body].mesh(),
        &setup.scene.names()[body],
    );
    let farthest = mesh.nodes().iter().map(|X| X.amax()).fold(0.0, f64::max);
    let heights = (0..mesh.len()).map(|cell| {
        let (longest, height) = extent(mesh, cell);
        height.min(longest)
    });
    let share = f64::EPSILON * farthest / heights.fold(f64::INFINITY, f64::min);
    if share > ROUNDED[1] {
        let body = name.clone();
        report.take::<()>(Err(Error::FarFromOrigin { body, share }));
    } else if share > ROUNDED[0] {
        let finding = Finding::new(Severity::Warning, FindingKind::FarFromOrigin, &[name]);
        report.add(finding.measured(share, ROUNDED[0]).says(
            format!(
                "coordinates of body `{name}` are rounded to {share:.1e} of the smallest height of a cell"
            ),
            "move all meshes towards the origin",
        ));
    }
}

/// The nodes of a side, numbered within its body.
fn nodes_of<const D: usize>(setup: &Setup<'_, D>, side: &Side) -> BTreeSet<usize> {
    let mesh = setup.scene.bodies()[side.body.index()].mesh();
    // the side was checked when the pair was declared
    let nodes = mesh.boundary_nodes(&side.boundary);
    nodes.into_iter().flatten().collect()
}

/// Pairs of exterior nodes that lie on each other, the smaller number first.
pub(super) fn coinciding<const D: usize>(mesh: &Mesh<D>) -> Vec<[usize; 2]> {
    // for each exterior node, the length of the shortest facet there
    let mut exterior = std::collections::BTreeMap::new();
    for facet in mesh.exterior() {
        let length = (mesh.nodes()[facet[0]] - mesh.nodes()[facet[1]]).norm();
        for &node in facet {
            let least = exterior.entry(node).or_insert(length);
            *least = length.min(*least);
        }
    }
    let leaves = exterior
        .keys()
        .map(|&a| GeomWithData::new(<[f64; D]>::from(mesh.nodes()[a]), a));
    let tree = RTree::bulk_load(leaves.collect());
    let others = |(&a, length): (&usize, &f64)| {
        let x = mesh.nodes()[a];
        let near = tree.locate_within_distance(x.into(), (COINCIDES * length).powi(2));
        let pairs = near.map(|leaf| [a, leaf.data]);
        pairs.filter(|[a, b]| b > a).collect::<Vec<_>>()
    };
    exterior.iter().flat_map(others).collect()
}

/// Finds exterior nodes of a body that lie on each other and are not declared for contact with each other.
fn seam<const D: usize>(setup: &Setup<'_, D>, body: usize, report: &mut Report) {
    let (mesh, name) = (
        setup.scene.bodies()[body].mesh(),
        &setup.scene.names()[body],
    );
    let of_body = |pair: &&Pair| {
        [&pair.first, &pair.second]
            .iter()
            .all(|s| s.body.index() == body)
    };
    let pairs = setup.pairs.iter().filter(of_body);
    let declared: Vec<_> = pairs
        .map(|pair| [nodes_of(setup, &pair.first), nodes_of(setup, &pair.second)])
        .collect();
    let is_declared = |a: usize, b: usize| {
        let has = |[first, second]: &[BTreeSet<usize>; 2]| {
            first.contains(&a) && second.contains(&b) || first.contains(&b) && second.contains(&a)
        };
        declared.iter().any(has)
    };
    let pairs = coinciding(mesh).into_iter();
    let open: Vec<[usize; 2]> = pairs.filter(|[a, b]| !is_declared(*a, *b)).collect();
    let count = open.len();
    if let Some([a, _]) = open.first() {
        let place = mesh.nodes()[*a];
        let finding = Finding::new(Severity::Warning, FindingKind::OpenSeam, &[name]);
        report.add(finding.at(&place).measured(count as f64, 0.0).says(
            format!(
                "body `{name}` has nodes that lie on each other and are not joined ({count}, the first at {:?}): \
                 it can open there",
                place.as_slice()
            ),
            "merge the nodes, or declare contact between the sides of the crack",
        ));
    }
}

/// Finds the contact facet with the least thickness between it and another contact facet, against its length.
fn thickness<const D: usize>(setup: &Setup<'_, D>, body: usize, report: &mut Report) {
    let name = &setup.scene.names()[body];
    let sides = setup
        .contact
        .surfaces
        .iter()
        .filter(|surface| surface.body() == body);
    let nodes: BTreeSet<usize> = sides
        .flat_map(|surface| surface.nodes().iter().copied())
        .collect();
    // flat pieces of quadratic facets are half as long as these
    let pieces = setup.scene.bodies()[body].mesh().order().degree() as f64;
    let is_contact = |face: &[usize]| face.iter().all(|a| nodes.contains(a));
    let faces = setup.audit.opposites();
    let faces = faces.filter(|(both, ..)| both.iter().all(|face| is_contact(face)));
    let relative = faces.map(|(both, size, thickness)| (thickness / (pieces * size), both[0]));
    let Some((share, nodes)) = relative.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return;
    };
    if share < THIN {
        let x = nodes
            .iter()
            .map(|&a| setup.kinematics.X[a])
            .sum::<Vector<D>>()
            / D as f64;
        let finding = Finding::new(Severity::Warning, FindingKind::ThinBody, &[name]);
        report.add(finding.at(&x).measured(share, THIN).says(
            format!(
                "body `{name}` is {share:.1e} facets thick at {:?}, with contact on both sides",
                x.as_slice()
            ),
            "refine its contact facets there until they are no longer than five times its thickness",
        ));
    }
}

/// Finds the cell with the largest ratio of longest edge to smallest height.
fn sliver<const D: usize>(setup: &Setup<'_, D>, body: usize, report: &mut Report) {
    let (mesh, name) = (
        setup.scene.bodies()[body].mesh(),
        &setup.scene.names()[body],
    );
    let ratios = (0..mesh.len()).map(|cell| (aspect(mesh, cell), cell));
    let Some((ratio, cell)) = ratios.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return;
    };
    if ratio > SLIVER {
        let x = mesh.centre(cell);
        let finding = Finding::new(Severity::Warning, FindingKind::Sliver, &[name]);
        report.add(finding.at(&x).measured(ratio, SLIVER).says(
            format!("cell {cell} of body `{name}` is a sliver: {ratio:.1e} times as long as high"),
            "mesh the body anew there, with cells of similar edges",
        ));
    }
}

/// The longest edge of a cell divided by its smallest height.
fn aspect<const D: usize>(mesh: &Mesh<D>, cell: usize) -> f64 {
    let (longest, height) = extent(mesh, cell);
    longest / height
}

/// The longest edge of a cell and its smallest height (UL).
fn extent<const D: usize>(mesh: &Mesh<D>, cell: usize) -> (f64, f64) {
    let x: Vec<Vector<D>> = mesh
        .corners(cell)
        .iter()
        .map(|&a| mesh.nodes()[a])
        .collect();
    let pairs = (0..=D).flat_map(|i| (0..i).map(move |j| (i, j)));
    let longest = pairs.map(|(i, j)| (x[i] - x[j]).norm()).fold(0.0, f64::max);
    let height = |k: usize| {
        let side: [_; D] = std::array::from_fn(|i| x[(k + 1 + i) % (D + 1)]);
        let normal = facet_normal(&side);
        (normal.dot(&(x[k] - side[0])) / normal.norm()).abs()
    };
    (longest, (0..=D).map(height).fold(f64::INFINITY, f64::min))
}
