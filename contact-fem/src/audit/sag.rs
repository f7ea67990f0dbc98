//! How far flat pieces are from the round surfaces that they stand for.

use std::collections::HashMap;

use super::simplex::distance;
use super::topology::Face;
use crate::tensor::{Vector, facet_normal};

/// Faces that meet at a larger angle (radians) meet at an edge of the body: a circle of eight chords is round.
const ROUND: f64 = 0.8;
/// Pieces whose normals differ by less (radians) are in one plane: the angle between vectors that are equal but for round-off is up to 1e-7.
const FLAT: f64 = 1e-6;

/// Sets the sag of each face (UL): the largest over its sides of h/2 tan(θ/4), with the way h from the side to the opposite node and the angle θ to the face beyond
/// the side, unless an edge of the body is there. A chord of length h that subtends the angle θ is so far from its arc. Pieces of a quadratic facet that is flat are
/// halves of its chord, and have the sag of the whole.
pub(super) fn measure<const D: usize>(faces: &mut [Face<D>], X: &[Vector<D>]) {
    let unit = |face: &Face<D>| facet_normal(&face.nodes.map(|a| X[a])).normalize();
    let normals: Vec<Vector<D>> = faces.iter().map(unit).collect();
    // for each side, the faces there and the way to the node opposite
    let mut sides: HashMap<Vec<usize>, Vec<(usize, f64)>> = HashMap::new();
    for (k, face) in faces.iter().enumerate() {
        for opposite in face.nodes {
            let side = face.nodes.iter().copied().filter(|a| *a != opposite);
            let mut side: Vec<usize> = side.collect();
            side.sort_unstable();
            let corners: Vec<Vector<D>> = side.iter().map(|&a| X[a]).collect();
            let way = distance(&X[opposite], &corners);
            sides.entry(side).or_default().push((k, way));
        }
    }
    let same = |k: usize, j: usize| angle(&normals[k], &normals[j]) < FLAT;
    let mut is_flat = Vec::with_capacity(faces.len());
    while let Some(face) = faces.get(is_flat.len()) {
        let (first, count) = (is_flat.len(), face.pieces);
        let flat = count > 1 && (first..first + count).all(|k| same(first, k));
        is_flat.resize(first + count, flat);
    }
    for around in sides.values() {
        for &(k, way) in around {
            let beyond = around.iter().filter(|(j, _)| *j != k);
            let angles = beyond.map(|&(j, _)| angle(&normals[k], &normals[j]));
            let chord = if is_flat[k] { 2.0 * way } else { way };
            for angle in angles.filter(|angle| *angle < ROUND) {
                faces[k].sag = faces[k].sag.max(0.5 * chord * (0.25 * angle).tan());
            }
        }
    }
    let mut rest = faces;
    while let Some(face) = rest.first() {
        let (own, others) = rest.split_at_mut(face.pieces);
        let largest = own.iter().map(|face| face.sag).fold(0.0, f64::max);
        own.iter_mut().for_each(|face| face.sag = largest);
        rest = others;
    }
}

/// The angle between two unit vectors (radians).
fn angle<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    a.dot(b).clamp(-1.0, 1.0).acos()
}
