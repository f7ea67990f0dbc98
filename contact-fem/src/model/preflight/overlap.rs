//! Checks that no bodies overlap in the reference configuration.

use std::sync::Arc;

use rstar::{
    AABB, Envelope, RTree, RTreeObject,
    primitives::{GeomWithData, Rectangle},
};

use super::Setup;
use crate::contact::projection::closest;
use crate::contact::{Master, Projection, Surface};
use crate::element::Facet;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::model::{InitialGaps, Scene};
use crate::tensor::{Vector, facet_normal};

/// Checks that no body starts inside another body of a contact pair that counts from the start; `inside` is the result of [`deepest`].
pub(super) fn check<const D: usize>(
    setup: &Setup<'_, D>,
    inside: &[(usize, usize, Inside<D>)],
) -> Result<(), Error> {
    nodes_inside(setup, inside)?;
    setup.pairs.iter().try_for_each(|pair| {
        let [first, second] = [&pair.first, &pair.second].map(|side| side.body.index());
        if setup.contact.lets_through([first, second], 0.0) {
            return Ok(());
        }
        crossing(setup, first, second)?;
        crossing(setup, second, first)?;
        coincident(setup, first, second)?;
        coincident(setup, second, first)
    })
}

/// Checks that no two bodies without a contact pair are in one place: the audit, which looks for nodes and edges in cells, does not
/// see bodies whose exteriors coincide.
pub(super) fn check_others<const D: usize>(setup: &Setup<'_, D>) -> Result<(), Error> {
    let bodies = setup.scene.bodies().iter();
    let boxes: Vec<_> = bodies.map(|body| body.mesh().bounding_box()).collect();
    let meet = |a: usize, b: usize| {
        (0..D).all(|i| boxes[a].0[i] < boxes[b].1[i] && boxes[b].0[i] < boxes[a].1[i])
    };
    for b in 0..boxes.len() {
        for a in (0..b).filter(|&a| meet(a, b) && !setup.contact.is_pair([a, b])) {
            coincident(setup, a, b)?;
            coincident(setup, b, a)?;
        }
    }
    Ok(())
}

/// A contact node that starts inside the other body of its pass.
pub(super) struct Inside<const D: usize> {
    /// The node, by its scene number, and its position (UL).
    node: usize,
    pub x: Vector<D>,
    /// Its depth, and the larger facet size of the two surfaces (UL).
    pub depth: f64,
    pub size: f64,
}

/// The largest overlap that is accepted, as a share of the facet size.
pub(super) fn accepted<const D: usize>(scene: &Scene<D>) -> f64 {
    match scene.initial_gaps {
        InitialGaps::Refuse => scene.overlap_tolerance,
        InitialGaps::Resolve | InitialGaps::Adjust => InitialGaps::LARGEST,
    }
}

/// The largest overlap of two bodies (UL) that is accepted between facets of this size.
pub(super) fn granted<const D: usize>(setup: &Setup<'_, D>, bodies: [usize; 2], size: f64) -> f64 {
    (accepted(setup.scene) * size).max(setup.contact.fit(bodies))
}

/// Checks that no contact node starts inside the other body by more than the tolerance.
fn nodes_inside<const D: usize>(
    setup: &Setup<'_, D>,
    inside: &[(usize, usize, Inside<D>)],
) -> Result<(), Error> {
    for &(slave, master, ref inside) in inside {
        let tolerance = granted(setup, [slave, master], inside.size);
        let is_later = setup.contact.lets_through([slave, master], 0.0);
        if inside.depth > tolerance && !is_later {
            return Err(Error::Overlap {
                slave: setup.scene.names()[slave].clone(),
                master: setup.scene.names()[master].clone(),
                node: inside.node - setup.kinematics.nodes(slave).start,
                x: inside.x.iter().copied().collect(),
                gap: -inside.depth,
                tolerance,
            });
        }
    }
    Ok(())
}

/// For each pass with contact nodes inside the other body: the bodies of slave and master, and the deepest node.
pub(super) fn deepest<const D: usize>(setup: &Setup<'_, D>) -> Vec<(usize, usize, Inside<D>)> {
    let x = &setup.kinematics.X[..];
    let located = setup.contact.located_at(x);
    let inside = setup.contact.inside(&setup.contact.passes, &located, x);
    let passes = setup.contact.passes.iter().zip(inside);
    let between = passes.filter(|(pass, _)| setup.contact.obstacle_of(**pass).is_none());
    let found = between.filter_map(|(pass, facing)| {
        let slave = &setup.contact.surfaces[pass.slave];
        let master = located.master(pass.master);
        let facing = facing.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let facing = facing.map(|(k, gap)| (slave.nodes()[k], gap));
        let other = master.surface().body();
        let swallowed = || match slave.body() == other {
            true => None,
            false => swallowed_node(setup, slave, other),
        };
        let found = match setup.scene.initial_gaps {
            InitialGaps::Refuse => facing.or_else(swallowed),
            // where the overlap is deep, nodes face nothing
            _ => {
                let found = facing.into_iter().chain(audited_node(setup, slave, other));
                found.min_by(|a, b| a.1.total_cmp(&b.1))
            }
        };
        let (node, gap) = found?;
        let inside = Inside {
            node,
            x: x[node],
            depth: -gap,
            size: slave.facet_size().max(master.surface().facet_size()),
        };
        Some((slave.body(), other, inside))
    });
    found.collect()
}

/// The deepest contact node of `slave` inside the master's body by the audit, which looks at all nodes. Returns (scene node,
/// minus its depth).
fn audited_node<const D: usize>(
    setup: &Setup<'_, D>,
    slave: &Surface<D>,
    body: usize,
) -> Option<(usize, f64)> {
    let x = &setup.kinematics.X[..];
    let overlaps = setup.audit.overlaps(x).into_iter();
    let own = overlaps.filter(|overlap| overlap.bodies == [slave.body(), body]);
    let at_nodes = own.filter_map(|overlap| {
        let node = slave.nodes().iter().find(|&&a| x[a] == overlap.at)?;
        Some((*node, -overlap.depth))
    });
    at_nodes.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The deepest contact node of `slave` in a cell of the master's body where no master facet faces
/// it, as when one body starts wholly inside another. Returns (scene node, minus its distance from
/// the boundary of the master's body).
fn swallowed_node<const D: usize>(
    setup: &Setup<'_, D>,
    slave: &Surface<D>,
    body: usize,
) -> Option<(usize, f64)> {
    let mesh = setup.scene.bodies()[body].mesh();
    let (low, high) = mesh.bounding_box();
    let x = &setup.kinematics.X[..];
    let in_box = |x: &Vector<D>| (0..D).all(|i| low[i] <= x[i] && x[i] <= high[i]);
    let inside = |&a: &usize| in_box(&x[a]) && mesh.contains(&x[a]);
    let inside: Vec<usize> = slave.nodes().iter().copied().filter(inside).collect();
    if inside.is_empty() {
        return None;
    }
    let first = setup.kinematics.nodes(body).start;
    let facet = |nodes: &[usize]| nodes.iter().map(|a| a + first).collect::<Vec<_>>();
    let facets: Vec<Vec<usize>> = mesh.exterior().map(facet).collect();
    let exterior = Surface::new(body, mesh.order(), facets.iter().map(Vec::as_slice), x);
    let boundary = Master::new(&Arc::new(exterior), x, Projection::Closest);
    // cells count as straight: between a chord and its curve, a point of a hollow is in front of the facet
    let depth = |&a: &usize| {
        let foot = boundary.project(&x[a])?;
        (foot.gap < 0.0).then_some((a, -foot.distance))
    };
    let depths = inside.iter().filter_map(depth);
    depths.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Checks that no exterior edge of body `a` intersects an exterior facet of body `b`, as where
/// slender bodies cross and no node is inside.
fn crossing<const D: usize>(setup: &Setup<'_, D>, a: usize, b: usize) -> Result<(), Error> {
    let [a_mesh, b_mesh] = [a, b].map(|body| setup.scene.bodies()[body].mesh());
    let facets = flat_facets(b_mesh);
    let tree = RTree::bulk_load(
        facets
            .map(|(nodes, x)| GeomWithData::new(Rectangle::from_aabb(bounding_box(&x)), (nodes, x)))
            .collect(),
    );
    let surfaces = || setup.contact.surfaces.iter();
    let is_declared = |body: usize, facet: &[usize]| {
        let first = setup.kinematics.nodes(body).start;
        let mut own = surfaces().filter(|surface| surface.body() == body);
        own.any(|s| {
            facet
                .iter()
                .all(|a| s.nodes().binary_search(&(a + first)).is_ok())
        })
    };
    // facets of one body meet at shared nodes
    let neighbours = |f: &[usize], g: &[usize]| a == b && f.iter().any(|node| g.contains(node));
    for (nodes, x) in flat_facets(a_mesh) {
        let edges = (0..D).flat_map(|j| (0..j).map(move |i| (i, j)));
        for (i, j) in edges {
            let edge = [x[i], x[j]];
            for other in tree.locate_in_envelope_intersecting(bounding_box(&edge)) {
                let (other_nodes, other) = &other.data;
                if neighbours(nodes, other_nodes) {
                    continue;
                }
                let size = (edge[1] - edge[0]).norm().max((other[1] - other[0]).norm());
                let tolerance = match is_declared(a, nodes) && is_declared(b, other_nodes) {
                    true => granted(setup, [a, b], size),
                    false => setup.scene.overlap_tolerance * size,
                };
                let crossed = pierce(&edge, other).filter(|(_, depth)| *depth > tolerance);
                if let Some((point, depth)) = crossed {
                    return Err(Error::Crossing {
                        first: setup.scene.names()[a].clone(),
                        second: setup.scene.names()[b].clone(),
                        x: point.iter().copied().collect(),
                        depth,
                        tolerance,
                    });
                }
            }
        }
    }
    Ok(())
}

/// Checks that no exterior cell of body `a` has its centroid in a cell of body `b`, as where one
/// body is a copy of the other, or a ring overlaps its own end: there no node is inside and no edge
/// intersects a facet.
fn coincident<const D: usize>(setup: &Setup<'_, D>, a: usize, b: usize) -> Result<(), Error> {
    let [mesh, other] = [a, b].map(|body| setup.scene.bodies()[body].mesh());
    let common = {
        let [(a_low, a_high), (b_low, b_high)] = [mesh, other].map(Mesh::bounding_box);
        AABB::from_corners(a_low.sup(&b_low).into(), a_high.inf(&b_high).into())
    };
    let corners = |mesh: &Mesh<D>, cell: &[usize]| -> Vec<Vector<D>> {
        cell[..=D].iter().map(|&node| mesh.nodes()[node]).collect()
    };
    let boxes = other.cells().map(|cell| {
        let rectangle = Rectangle::from_aabb(bounding_box(&corners(other, cell)));
        GeomWithData::new(rectangle, cell)
    });
    let tree = RTree::bulk_load(boxes.filter(|b| b.envelope().intersects(&common)).collect());
    let cells: Vec<&[usize]> = mesh.cells().collect();
    for &owner in mesh.exterior_cells() {
        let x = corners(mesh, cells[owner]);
        let centroid = x.iter().sum::<Vector<D>>() / (D + 1) as f64;
        let holds = |cell: &[usize]| {
            let lambda = other.barycentric(cell, &centroid);
            let neighbour = a == b && cell.iter().any(|node| cells[owner].contains(node));
            !neighbour && lambda.iter().all(|&l| l >= 0.0) && lambda.sum() <= 1.0
        };
        let mut near = tree.locate_all_at_point(centroid.into());
        let Some(found) = near.find(|cell| holds(cell.data)) else {
            continue;
        };
        // the depth of the centroid inside its own cell
        let distance = |k: usize| {
            let side: [_; D] = std::array::from_fn(|i| x[(k + 1 + i) % (D + 1)]);
            let normal = facet_normal(&side);
            (normal.dot(&(centroid - side[0])) / normal.norm()).abs()
        };
        let depth = (0..=D).map(distance).fold(f64::INFINITY, f64::min);
        let other_corners = corners(other, found.data);
        let edge = |corners: &[Vector<D>]| (corners[1] - corners[0]).norm();
        let size = edge(&x).max(edge(&other_corners));
        let tolerance = setup.scene.overlap_tolerance * size;
        if depth > tolerance.max(setup.contact.fit([a, b])) {
            return Err(Error::Crossing {
                first: setup.scene.names()[a].clone(),
                second: setup.scene.names()[b].clone(),
                x: centroid.iter().copied().collect(),
                depth,
                tolerance,
            });
        }
    }
    Ok(())
}

/// The corners of the flat pieces of all exterior facets, and the facets' nodes.
fn flat_facets<const D: usize>(mesh: &Mesh<D>) -> impl Iterator<Item = (&[usize], [Vector<D>; D])> {
    mesh.exterior().flat_map(|nodes| {
        let facet = Facet::gather(mesh.order(), nodes, mesh.nodes());
        let corner = move |lambda: &[f64; 3]| facet.point(&Vector::from_fn(|i, _| lambda[i]));
        let pieces = facet.pieces().iter();
        pieces.map(move |piece| (nodes, std::array::from_fn(|k| corner(&piece[k]))))
    })
}

fn bounding_box<const D: usize>(points: &[Vector<D>]) -> AABB<[f64; D]> {
    let low = points.iter().fold(points[0], |m, x| m.inf(x));
    let high = points.iter().fold(points[0], |m, x| m.sup(x));
    AABB::from_corners(low.into(), high.into())
}

/// The point at which an edge intersects a facet, if there is one, and the shortest displacement
/// that separates them: of an end of the edge to the facet's plane, or of the point to a side of
/// the facet.
fn pierce<const D: usize>(
    edge: &[Vector<D>; 2],
    facet: &[Vector<D>; D],
) -> Option<(Vector<D>, f64)> {
    let normal = facet_normal(facet);
    let normal = normal / normal.norm();
    let [before, after] = edge.map(|x| normal.dot(&(x - facet[0])));
    if before * after >= 0.0 {
        return None;
    }
    let point = edge[0] + (edge[1] - edge[0]) * (before / (before - after));
    let lambda = closest(&point, facet);
    // beyond a side of the facet, the closest point has a barycentric coordinate of 0
    let height = |k: usize| {
        let side = facet[(k + 1) % D];
        let along = facet[(k + D - 1) % D] - side;
        let arm = facet[k] - side;
        let length = along.norm_squared();
        let foot = if length > 0.0 {
            along * (arm.dot(&along) / length)
        } else {
            Vector::zeros()
        };
        (arm - foot).norm()
    };
    let inner = (0..D).map(|k| lambda[k] * height(k));
    let depth = inner.fold(before.abs().min(after.abs()), f64::min);
    (depth > 0.0).then_some((point, depth))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve curved chords around a disc of .98, whose nodes are beyond the straight chords, at .966: nothing overlaps. A disc of 1.02 does, and
    /// one in the middle of the ring, too.
    #[test]
    fn chords_of_a_hollow_are_no_walls() {
        use crate::mesh::generators::{Diagonals, annulus, disc, onto_sphere};
        use crate::{Body, LinearElastic, Scene};
        let errors = |radius: f64, centre: [f64; 2]| {
            let law = || LinearElastic::new(1.0, 0.3).expect("a law");
            let ring = annulus(&[1.0, 1.5, 2.0], 12, Diagonals::Rising).expect("a mesh");
            let ring = ring
                .quadratic()
                .curved("inner", onto_sphere(1.0))
                .expect("curved");
            let mut ring = Body::new(ring, law());
            ring.prescribe("outer", [Some(0.0); 2]).expect("held");
            let round = disc(radius, 12, 2, 0.2).expect("a mesh");
            let round = round.translated(centre).expect("moved");
            let mut scene = Scene::new();
            let ring = scene.add("ring", ring);
            let round = scene.add("disc", Body::new(round, law()));
            scene
                .contact(ring.on("inner"), round.on("boundary"))
                .expect("a pair");
            scene.errors()
        };
        assert!(
            errors(0.98, [0.0; 2]).is_empty(),
            "{:?}",
            errors(0.98, [0.0; 2])
        );
        for (radius, centre) in [(1.08, [0.0; 2]), (0.2, [1.5, 0.0])] {
            assert!(!errors(radius, centre).is_empty(), "{radius}");
        }
    }

    #[test]
    fn an_edge_through_a_facet() {
        let facet = [[0.0, 0.0], [4.0, 0.0]].map(Vector::<2>::from);
        let edge = |a: [f64; 2], b: [f64; 2]| [a, b].map(Vector::<2>::from);
        let (point, depth) = pierce(&edge([1.0, -3.0], [1.0, 2.0]), &facet).expect("crosses");
        assert!((point - Vector::<2>::new(1.0, 0.0)).norm() < 1e-15);
        assert!((depth - 1.0).abs() < 1e-15, "to the facet's end");
        let (_, depth) = pierce(&edge([2.0, -3.0], [2.0, 0.5]), &facet).expect("crosses");
        assert!((depth - 0.5).abs() < 1e-15, "to the edge's end");
        assert!(pierce(&edge([5.0, -3.0], [5.0, 2.0]), &facet).is_none());
        assert!(pierce(&edge([1.0, 1.0], [1.0, 2.0]), &facet).is_none());
        assert!(pierce(&edge([1.0, 0.0], [1.0, 2.0]), &facet).is_none());

        let facet = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Vector::<3>::from);
        let edge = |x: f64, y: f64| [[x, y, -3.0], [x, y, 2.0]].map(Vector::<3>::from);
        let (point, depth) = pierce(&edge(1.5, 0.5), &facet).expect("pierces");
        assert!((point - Vector::<3>::new(1.5, 0.5, 0.0)).norm() < 1e-15);
        assert!((depth - 0.5).abs() < 1e-15, "to the side below");
        assert!(pierce(&edge(2.5, 2.5), &facet).is_none());
    }
}
