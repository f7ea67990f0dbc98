//! How far flat pieces are from the round surfaces that they stand for.

use std::collections::HashMap;

use super::simplex::distance;
use super::topology::Face;
use crate::tensor::{Vector, facet_normal};

/// Faces that meet at a larger angle (radians) meet at an edge of the body: a circle of eight chords is round.
const ROUND: f64 = 0.8;

/// Sets the sag of each face (UL): the largest over its sides of h/2 tan(θ/4), with the way h from the side to the opposite node and the angle θ to the face beyond
/// the side, unless an edge of the body is there. A chord of length h that subtends the angle θ is so far from its arc.
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
    for around in sides.values() {
        for &(k, way) in around {
            let beyond = around.iter().filter(|(j, _)| *j != k);
            let angles = beyond.map(|&(j, _)| normals[k].dot(&normals[j]).clamp(-1.0, 1.0).acos());
            for angle in angles.filter(|angle| *angle < ROUND) {
                faces[k].sag = faces[k].sag.max(0.5 * way * (0.25 * angle).tan());
            }
        }
    }
}
