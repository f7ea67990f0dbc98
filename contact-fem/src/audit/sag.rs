//! How far flat pieces are from the round surfaces that they stand for.

use std::collections::HashMap;

use super::topology::Face;
use crate::tensor::{Vector, facet_normal};

/// Faces that meet at a larger angle (radians) meet at an edge of the body: a circle of eight chords is round.
const ROUND: f64 = 0.8;

/// Sets the sag of each face: that of a chord of its length between neighbours at the largest angle θ to it that no edge of the body makes. A chord of
/// length h subtends θ, and is h/2 tan(θ/4) from its arc.
pub(super) fn measure<const D: usize>(faces: &mut [Face<D>], X: &[Vector<D>]) {
    let unit = |face: &Face<D>| facet_normal(&face.nodes.map(|a| X[a])).normalize();
    let normals: Vec<Vector<D>> = faces.iter().map(unit).collect();
    let mut sharers: HashMap<Vec<usize>, Vec<usize>> = HashMap::new();
    for (k, face) in faces.iter().enumerate() {
        for omitted in face.nodes {
            let side = face.nodes.iter().copied().filter(|a| *a != omitted);
            let mut side: Vec<usize> = side.collect();
            side.sort_unstable();
            sharers.entry(side).or_default().push(k);
        }
    }
    let mut largest = vec![0.0_f64; faces.len()];
    for around in sharers.values() {
        for &k in around {
            let angles = around.iter().filter(|j| **j != k);
            let angles = angles.map(|&j| normals[k].dot(&normals[j]).clamp(-1.0, 1.0).acos());
            let round = angles.filter(|angle| *angle < ROUND);
            largest[k] = round.fold(largest[k], f64::max);
        }
    }
    for (face, angle) in faces.iter_mut().zip(largest) {
        face.sag = 0.5 * face.size * (0.25 * angle).tan();
    }
}
