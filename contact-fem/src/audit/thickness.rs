//! The thickness of bodies behind their faces.

use rstar::AABB;

use super::topology::Face;
use super::{Boxes, aabb, tree};
use crate::tensor::{Vector, facet_normal};

/// The largest thickness that is measured: twice the largest face (UL).
pub(super) fn far<const D: usize>(faces: &[Face<D>]) -> f64 {
    2.0 * faces.iter().map(|face| face.size).fold(0.0, f64::max)
}

/// Sets the thickness of each face: the way from its centroid along the inward normal to where it
/// leaves the body, if that is at most twice the largest face.
pub(super) fn measure<const D: usize>(faces: &mut [Face<D>], X: &[Vector<D>]) {
    let far = far(faces);
    let boxes = boxes(faces, X);
    let thickness = |face: &Face<D>| behind(faces, &boxes, X, face, far);
    let all: Vec<Option<(f64, usize)>> = faces.iter().map(thickness).collect();
    for (face, found) in faces.iter_mut().zip(all) {
        if let Some((way, opposite)) = found {
            (face.thickness, face.opposite) = (way, Some(opposite));
        }
    }
}

/// The boxes of all faces.
pub(super) fn boxes<const D: usize>(faces: &[Face<D>], X: &[Vector<D>]) -> Boxes<D> {
    tree(faces.iter().map(|face| aabb(&face.nodes, X)).enumerate())
}

/// The way from the centroid of a face along its inward normal to where it leaves the body (UL), if it does within `far` (UL), and the
/// face there.
pub(super) fn behind<const D: usize>(
    faces: &[Face<D>],
    boxes: &Boxes<D>,
    X: &[Vector<D>],
    face: &Face<D>,
    far: f64,
) -> Option<(f64, usize)> {
    let corners = face.nodes.map(|a| X[a]);
    let inward = -facet_normal(&corners).normalize();
    let from = corners.iter().sum::<Vector<D>>() / D as f64;
    let to = from + inward * far;
    let ray = AABB::from_corners(from.inf(&to).into(), from.sup(&to).into());
    let hits = boxes
        .locate_in_envelope_intersecting(ray)
        .filter_map(|leaf| {
            let other = &faces[leaf.data];
            if other.body != face.body {
                return None;
            }
            let corners = other.nodes.map(|a| X[a]);
            let way = leaving(&from, &inward, &corners);
            Some((way.filter(|&way| way > 1e-9 * face.size)?, leaf.data))
        });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(way, _)| *way <= far)
}

/// The way from a point along a unit vector to a facet through which it leaves the body.
fn leaving<const D: usize>(
    from: &Vector<D>,
    along: &Vector<D>,
    facet: &[Vector<D>; D],
) -> Option<f64> {
    let normal = facet_normal(facet);
    let speed = along.dot(&normal);
    if speed <= 0.0 {
        return None;
    }
    let way = (facet[0] - from).dot(&normal) / speed;
    let point = from + along * way;
    // seen from the point, every side of the facet has the facet's orientation
    let is_inside = (0..D).all(|k| {
        let mut part = *facet;
        part[k] = point;
        facet_normal(&part).dot(&normal) >= -1e-12 * normal.norm_squared()
    });
    (way > 0.0 && is_inside).then_some(way)
}
