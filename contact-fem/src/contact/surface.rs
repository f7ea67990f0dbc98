//! A contact surface: facets of one body's boundary in the scene's node numbering.

use std::collections::HashMap;

use crate::tensor::{Vector, facet_normal};

/// The facets of a body that may touch another surface.
#[derive(Clone, Debug)]
pub struct Surface<const D: usize> {
    body: usize,
    facets: Vec<[usize; D]>,
    /// Reference measure of each facet (UL, UL²).
    measures: Vec<f64>,
    /// For facet and corner: whether the facet's side opposite that corner is on the surface's rim.
    rim: Vec<[bool; D]>,
    nodes: Vec<usize>,
}

impl<const D: usize> Surface<D> {
    /// From facets with scene node numbers and the reference positions `X` of all nodes.
    pub fn new(body: usize, facets: Vec<[usize; D]>, X: &[Vector<D>]) -> Self {
        let side = |facet: &[usize; D], omitted: usize| {
            let kept = (0..D).filter(|&k| k != omitted).map(|k| facet[k]);
            let mut side: Vec<usize> = kept.collect();
            side.sort_unstable();
            side
        };
        let mut sharers: HashMap<Vec<usize>, usize> = HashMap::new();
        for facet in &facets {
            for k in 0..D {
                *sharers.entry(side(facet, k)).or_insert(0) += 1;
            }
        }
        let on_rim = |facet: &[usize; D]| std::array::from_fn(|k| sharers[&side(facet, k)] == 1);
        let mut nodes: Vec<usize> = facets.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Surface {
            body,
            rim: facets.iter().map(on_rim).collect(),
            measures: facets
                .iter()
                .map(|facet| facet_normal(&facet.map(|a| X[a])).norm())
                .collect(),
            facets,
            nodes,
        }
    }

    /// The body that it belongs to.
    pub fn body(&self) -> usize {
        self.body
    }

    /// Its facets, as scene node numbers.
    pub fn facets(&self) -> &[[usize; D]] {
        &self.facets
    }

    /// The facets' reference measures (UL in the plane, UL² in space).
    pub fn measures(&self) -> &[f64] {
        &self.measures
    }

    /// Whether the side opposite `corner` of `facet` has no neighbour on this surface.
    pub fn is_rim(&self, facet: usize, corner: usize) -> bool {
        self.rim[facet][corner]
    }

    /// Its nodes, ascending.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The position of a scene node among [`Surface::nodes`].
    ///
    /// # Panics
    /// If the node is not on this surface.
    pub fn local(&self, node: usize) -> usize {
        let found = self.nodes.binary_search(&node);
        found.expect("facets only name nodes of their own surface")
    }

    /// The length of a typical facet (UL): the mean measure's (D−1)-th root.
    pub fn facet_size(&self) -> f64 {
        let mean = self.measures.iter().sum::<f64>() / self.measures.len().max(1) as f64;
        mean.powf(1.0 / (D as f64 - 1.0))
    }

    /// The length of the smallest facet (UL).
    pub fn smallest_facet(&self) -> f64 {
        let smallest = self.measures.iter().copied().fold(f64::INFINITY, f64::min);
        smallest.powf(1.0 / (D as f64 - 1.0))
    }
}
