//! Bodies that start inside each other, as those of a press fit.

use std::collections::BTreeMap;

use super::{Audit, thickness};

/// How deep two bodies, or a body and an obstacle, start inside each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fit {
    /// The largest depth (UL): the shortest way out, through any face.
    pub depth: f64,
    /// The thickness of the body that is thinner there (UL); `+∞` of endless ones.
    pub thickness: f64,
}

impl<const D: usize> Audit<D> {
    /// What each two different bodies that overlap in the reference configuration overlap by, the smaller index first. The thickness behind
    /// a face is measured through the whole body, however fine its mesh is.
    pub(crate) fn fits(&self) -> BTreeMap<[usize; 2], Fit> {
        let X = &self.reference;
        let overlaps = self.overlaps(X).into_iter();
        let mut overlaps = overlaps.filter(|o| o.bodies[0] != o.bodies[1]).peekable();
        let mut fits = BTreeMap::new();
        if overlaps.peek().is_none() {
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
            // an obstacle has no faces
            let sides = overlap
                .bodies
                .map(|body| self.nearest(X, &boxes, overlap.at, |face| face.body == body));
            let ways = sides.into_iter().flatten().map(|(_, face)| thickness(face));
            let thinner = ways.fold(f64::INFINITY, f64::min);
            let fit = fits.entry([a.min(b), a.max(b)]).or_insert(Fit {
                depth: 0.0,
                thickness: thinner,
            });
            fit.depth = fit.depth.max(overlap.depth);
            fit.thickness = fit.thickness.min(thinner);
        }
        fits
    }
}
