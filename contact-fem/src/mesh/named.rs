//! Boundaries that are given a name.

use std::collections::BTreeMap;

use super::Mesh;
use crate::error::Error;
use crate::tensor::{Vector, facet_normal};

impl<const D: usize> Mesh<D> {
    /// Gives the boundary `name` those exterior facets whose corners all satisfy `contains`; an
    /// existing boundary is extended. A boundary without facets is kept.
    pub fn name_boundary(&mut self, name: &str, contains: impl Fn(&Vector<D>) -> bool) {
        self.name_facets(name, |corners, _| corners.iter().all(&contains));
    }

    /// Gives the boundary `name` those exterior facets whose corners (UL) and outward unit normal satisfy `is_in`; an existing boundary is
    /// extended. A boundary without facets is kept.
    pub fn name_facets(&mut self, name: &str, is_in: impl Fn(&[Vector<D>; D], &Vector<D>) -> bool) {
        let found = (0..self.owners.len()).filter(|&f| {
            let corners = self.facet_corners(f);
            is_in(&corners, &facet_normal(&corners).normalize())
        });
        let found = found.collect();
        self.extend_boundary(name, found);
    }

    /// Gives the boundary `name` the exterior facet that is the closest to the place `from` (UL), and all that can be reached from it over
    /// facets whose normals are at most `angle` (degrees) apart from one to the next; an existing boundary is extended.
    ///
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, annulus};
    ///
    /// // the hole of a ring: twelve chords, which turn by 30° each
    /// let mut ring = annulus(&[1.0, 2.0], 12, Diagonals::Rising)?;
    /// ring.name_smooth("hole", &[1.0, 0.0].into(), 31.0);
    /// assert_eq!(ring.boundary("hole")?.len(), 12);
    /// ring.name_smooth("chord", &[1.0, 0.1].into(), 29.0);
    /// assert_eq!(ring.boundary("chord")?.len(), 1);
    /// # Ok::<(), contact_fem::Error>(())
    /// ```
    pub fn name_smooth(&mut self, name: &str, from: &Vector<D>, angle: f64) {
        let all: Vec<[Vector<D>; D]> = (0..self.owners.len())
            .map(|f| self.facet_corners(f))
            .collect();
        let normals: Vec<Vector<D>> = all.iter().map(|x| facet_normal(x).normalize()).collect();
        let distance = |f: &usize| {
            let centre = all[*f].iter().sum::<Vector<D>>() / D as f64;
            (centre - from).norm()
        };
        let facets = 0..all.len();
        let Some(first) = facets.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            return;
        };
        let around = self.facets_around_edges();
        let least = angle.to_radians().cos();
        let mut is_found = vec![false; all.len()];
        is_found[first] = true;
        let mut next = vec![first];
        while let Some(f) = next.pop() {
            for edge in self.edges_of_facet(f) {
                for &other in around.get(&edge).into_iter().flatten() {
                    if !is_found[other] && normals[f].dot(&normals[other]) >= least {
                        is_found[other] = true;
                        next.push(other);
                    }
                }
            }
        }
        let found = (0..all.len()).filter(|&f| is_found[f]).collect();
        self.extend_boundary(name, found);
    }

    /// Gives the boundary `name` all facets of the boundaries `of`; an existing boundary is extended.
    ///
    /// # Errors
    /// As [`Mesh::boundary`].
    pub fn join_boundaries(&mut self, name: &str, of: &[impl AsRef<str>]) -> Result<(), Error> {
        let mut joined = Vec::new();
        for other in of.iter().map(AsRef::as_ref) {
            self.boundary(other)?;
            joined.extend(self.boundaries.get(other).into_iter().flatten());
        }
        self.extend_boundary(name, joined);
        Ok(())
    }

    fn extend_boundary(&mut self, name: &str, facets: Vec<usize>) {
        let named = self.boundaries.entry(name.to_string()).or_default();
        named.extend(facets);
        named.sort_unstable();
        named.dedup();
    }

    fn facet_corners(&self, f: usize) -> [Vector<D>; D] {
        let nodes = self.facet(f);
        std::array::from_fn(|c| self.nodes[nodes[c]])
    }

    /// What a facet shares with the next: an end in the plane, a side in space; the numbers of its corners, ascending.
    fn edges_of_facet(&self, f: usize) -> Vec<Vec<usize>> {
        let corners = &self.facet(f)[..D];
        let without = |k: usize| {
            let others = corners.iter().enumerate().filter(|(c, _)| *c != k);
            let mut edge: Vec<usize> = others.map(|(_, node)| *node).collect();
            edge.sort_unstable();
            edge
        };
        (0..D).map(without).collect()
    }

    fn facets_around_edges(&self) -> BTreeMap<Vec<usize>, Vec<usize>> {
        let mut around = BTreeMap::<Vec<usize>, Vec<usize>>::new();
        for f in 0..self.owners.len() {
            for edge in self.edges_of_facet(f) {
                around.entry(edge).or_default().push(f);
            }
        }
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generators::{Diagonals, cuboid, cylinder, linspace, rectangle};

    /// The area of a boundary.
    fn area<const D: usize>(mesh: &Mesh<D>, name: &str) -> f64 {
        let facets = mesh.boundary(name).expect("named");
        let area = |nodes: &&[usize]| {
            let x: [Vector<D>; D] = std::array::from_fn(|c| mesh.nodes()[nodes[c]]);
            facet_normal(&x).norm()
        };
        facets.iter().map(area).sum()
    }

    #[test]
    fn facets_are_named_by_their_normals() {
        let mut block = cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 2]).expect("a block");
        let up = Vector::<3>::z();
        block.name_facets("up", |_, n| n.dot(&up) > 0.9);
        block.name_facets("sides", |_, n| n.dot(&up).abs() < 0.1);
        assert!((area(&block, "up") - 2.0).abs() < 1e-12);
        assert!((area(&block, "sides") - 18.0).abs() < 1e-12);
    }

    /// A side of a block ends at its edges; the mantle of a cylinder of 24 facets turns by 15° each, and its ends by 90°.
    #[test]
    fn smooth_boundaries_end_at_edges() {
        let mut block = cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 2]).expect("a block");
        block.name_smooth("low", &Vector::<3>::new(0.5, 1.0, 0.0), 45.0);
        assert!((area(&block, "low") - 2.0).abs() < 1e-12);
        block.name_smooth("all", &Vector::<3>::new(0.5, 1.0, 0.0), 91.0);
        assert!((area(&block, "all") - 22.0).abs() < 1e-12);
        let mut round = cylinder(1.0, 1.0, 4, 2).expect("a cylinder");
        round.name_smooth("mantle", &Vector::<3>::new(1.0, 0.0, 0.4), 20.0);
        assert_eq!(area(&round, "mantle"), area(&round, "side"));
        let x = linspace(0.0, 1.0, 3);
        let mut square = rectangle(&x, &x, Diagonals::Rising).expect("a mesh");
        square.name_smooth("here", &Vector::<2>::new(0.9, 1.2), 1.0);
        assert_eq!(square.boundary("here").expect("named").len(), 3);
        assert_eq!(area(&square, "here"), area(&square, "top"));
    }
}
