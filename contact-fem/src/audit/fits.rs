//! Bodies that start inside each other, as those of a press fit.

use std::collections::BTreeMap;

use super::{Audit, Boxes, distance, thickness};
use crate::tensor::Vector;

/// How deep two bodies, or a body and an obstacle, start inside each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Fit {
    /// The largest depth (UL).
    pub depth: f64,
    /// The largest depth as a share of the thickness of the body that is thinner there (no unit).
    pub share: f64,
}

impl<const D: usize> Audit<D> {
    /// What each two different bodies that overlap in the reference configuration overlap by, the smaller index first. The thickness behind
    /// a face is measured through the whole body, however fine its mesh is.
    pub(crate) fn fits(&self) -> BTreeMap<[usize; 2], Fit> {
        let X = &self.reference;
        let overlaps = self.overlaps(X);
        let mut fits = BTreeMap::new();
        if overlaps.is_empty() {
            return fits;
        }
        let faces = &self.topology.faces;
        let boxes = thickness::boxes(faces, X);
        let (low, high) = X
            .iter()
            .fold((X[0], X[0]), |(low, high), x| (low.inf(x), high.sup(x)));
        let far = (high - low).norm();
        let mut measured: Vec<Option<f64>> = vec![None; faces.len()];
        let mut thickness = |face: usize| {
            let behind = || thickness::behind(faces, &boxes, X, &faces[face], far);
            *measured[face].get_or_insert_with(|| behind().map_or(f64::INFINITY, |(way, _)| way))
        };
        for overlap in overlaps {
            let [a, b] = overlap.bodies;
            if a == b {
                continue;
            }
            let sides = overlap
                .bodies
                .map(|body| self.nearest_face(&boxes, body, &overlap.at));
            let ways = sides.into_iter().flatten().map(&mut thickness);
            let thinner = ways.fold(f64::INFINITY, f64::min);
            let fit: &mut Fit = fits.entry([a.min(b), a.max(b)]).or_default();
            fit.depth = fit.depth.max(overlap.depth);
            fit.share = fit.share.max(overlap.depth / thinner);
        }
        fits
    }

    /// The face of a body nearest to a point; `None` of an obstacle.
    fn nearest_face(&self, boxes: &Boxes<D>, body: usize, at: &Vector<D>) -> Option<usize> {
        let mut nearest: Option<(f64, usize)> = None;
        // by the distance of their boxes, which is at most their own
        for (leaf, at_least_2) in boxes.nearest_neighbor_iter_with_distance_2((*at).into()) {
            if nearest.is_some_and(|(way, _)| at_least_2 > way * way) {
                break;
            }
            let face = &self.topology.faces[leaf.data];
            let way = || distance(at, &face.nodes.map(|a| self.reference[a]));
            if face.body == body && nearest.is_none_or(|(least, _)| way() < least) {
                nearest = Some((way(), leaf.data));
            }
        }
        nearest.map(|(_, face)| face)
    }
}
