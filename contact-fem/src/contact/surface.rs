//! A contact surface: facets of one body's boundary.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::normals::averaged;
use super::rim::Rim;
use crate::element::{Facet, FacetRule, FacetShapes, Order, facet_edge, facet_shapes};
use crate::tensor::Vector;

/// The facets of a body that may touch another surface; the surface's own nodes are numbered from
/// 0.
#[derive(Clone, Debug)]
pub struct Surface<const D: usize> {
    body: usize,
    order: Order,
    /// Scene node numbers, ascending.
    nodes: Vec<usize>,
    /// Nodes of the facets, flat, as positions in `nodes`.
    facets: Vec<usize>,
    /// (node, facet, the node's index in the facet), ascending.
    incidences: Vec<(usize, usize, usize)>,
    /// The facets in the reference configuration.
    reference: Vec<Facet<D>>,
    /// X of the nodes, and their averaged normals in the reference configuration.
    X: Vec<Vector<D>>,
    N: Vec<Vector<D>>,
    /// Whether its body is one of revolution about the axis r = 0, with r as the first coordinate.
    is_revolved: bool,
    rim: Rim<D>,
    /// A_i = ∫ φ_i of each node.
    test_areas: Vec<f64>,
}

impl<const D: usize> Surface<D> {
    /// The surface of facets of degree `order`, given by scene node numbers, and the reference
    /// positions `X` of all scene nodes.
    pub fn new<'a>(
        body: usize,
        order: Order,
        facets: impl Iterator<Item = &'a [usize]> + Clone,
        X: &[Vector<D>],
    ) -> Self {
        Self::of_body((body, false), order, facets, X)
    }

    /// The same of a body that may be one of revolution, as the flag tells.
    pub(crate) fn of_body<'a>(
        (body, is_revolved): (usize, bool),
        order: Order,
        facets: impl Iterator<Item = &'a [usize]> + Clone,
        X: &[Vector<D>],
    ) -> Self {
        let mut nodes: Vec<usize> = facets.clone().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number: HashMap<usize, usize> = nodes.iter().copied().zip(0..).collect();
        let mut surface = Surface {
            body,
            order,
            X: nodes.iter().map(|&node| X[node]).collect(),
            N: Vec::new(),
            is_revolved,
            rim: Rim::default(),
            reference: facets
                .clone()
                .map(|facet| Facet::gather(order, facet, X))
                .collect(),
            facets: facets.flatten().map(|node| number[node]).collect(),
            incidences: Vec::new(),
            test_areas: Vec::new(),
            nodes,
        };
        let per_facet = order.facet_nodes::<D>();
        let facets = surface.facets.iter().enumerate();
        let incidences = facets.map(|(i, &a)| (a, i / per_facet, i % per_facet));
        surface.incidences = incidences.collect();
        surface.incidences.sort_unstable();
        surface.rim = Rim::of(&surface);
        surface.N = averaged(&surface, &surface.X);
        surface.test_areas = surface.integrated_tests();
        surface
    }

    /// A_i by Gauss's rule, exact up to curved measures.
    fn integrated_tests(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        let rule = FacetRule::<D>::gauss(3);
        for (index, nodes) in self.facets().enumerate() {
            for (weight, lambda) in rule.points() {
                let w = weight * self.measure(index, lambda);
                let tests = nodes.iter().zip(self.test_functions(lambda));
                tests
                    .take(self.test_nodes())
                    .for_each(|(&a, phi)| areas[a] += w * phi);
            }
        }
        areas
    }

    /// The number of the surface's body.
    pub fn body(&self) -> usize {
        self.body
    }

    /// The degree of the facets.
    pub fn order(&self) -> Order {
        self.order
    }

    /// The number of facets.
    pub fn len(&self) -> usize {
        self.reference.len()
    }

    /// Whether the surface has no facets.
    pub fn is_empty(&self) -> bool {
        self.reference.is_empty()
    }

    /// The surface's nodes as scene node numbers, ascending.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The nodes of facet `f`, as positions in [`Surface::nodes`].
    pub fn facet(&self, f: usize) -> &[usize] {
        let per_facet = self.order.facet_nodes::<D>();
        &self.facets[f * per_facet..(f + 1) * per_facet]
    }

    /// The nodes of all facets, as positions in [`Surface::nodes`].
    pub fn facets(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.facets.chunks_exact(self.order.facet_nodes::<D>())
    }

    /// The facets around node `a`, a position in [`Surface::nodes`], ascending, and the node's
    /// index in each.
    pub fn facets_around(&self, a: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let first = self.incidences.partition_point(|&(node, ..)| node < a);
        let own = self.incidences[first..].iter();
        own.take_while(move |&&(node, ..)| node == a)
            .map(|&(_, facet, k)| (facet, k))
    }

    /// The facets in the reference configuration.
    pub fn reference(&self) -> &[Facet<D>] {
        &self.reference
    }

    /// The positions X of the surface's own nodes (UL).
    pub fn reference_nodes(&self) -> &[Vector<D>] {
        &self.X
    }

    /// The averaged unit normals at the surface's own nodes in the reference configuration.
    pub fn reference_normals(&self) -> &[Vector<D>] {
        &self.N
    }

    /// Selects the positions of the surface's own nodes from those of all scene nodes.
    pub fn gather(&self, x: &[Vector<D>]) -> Vec<Vector<D>> {
        self.nodes.iter().map(|&node| x[node]).collect()
    }

    /// The facets at `x`, the positions of the surface's own nodes.
    pub fn facets_at(&self, x: &[Vector<D>]) -> impl ExactSizeIterator<Item = Facet<D>> {
        self.facets()
            .map(|nodes| Facet::gather(self.order, nodes, x))
    }

    /// Where the surface ends.
    pub(super) fn rim(&self) -> &Rim<D> {
        &self.rim
    }

    /// Whether the surface is one of revolution.
    pub(crate) fn is_of_revolution(&self) -> bool {
        self.is_revolved
    }

    /// Whether node `a`, a position in [`Surface::nodes`], is on the axis of a body of revolution.
    pub(super) fn is_on_axis(&self, a: usize) -> bool {
        self.is_revolved && self.X[a][0] == 0.0
    }

    /// The reference measure of a facet at λ (UL in the plane, UL² in space and of revolution): quadrature weights are to be
    /// multiplied by it.
    pub(crate) fn measure(&self, facet: usize, lambda: &Vector<D>) -> f64 {
        let reference = &self.reference[facet];
        reference.normal(lambda).norm() * self.ring(reference, lambda)
    }

    /// 2πR at the point λ of a facet, which is anywhere, of a body of revolution (UL); else 1.
    pub(super) fn ring(&self, facet: &Facet<D>, lambda: &Vector<D>) -> f64 {
        match self.is_revolved {
            true => TAU * facet.point(lambda)[0],
            false => 1.0,
        }
    }

    /// φ_i(λ) for the nodes of a facet that have a test function: all nodes, or only the corners of
    /// a quadratic triangle, whose quadratic corner functions have mean zero, and of a quadratic segment of a body of revolution,
    /// where the one on the axis has mean zero.
    pub fn test_functions(&self, lambda: &Vector<D>) -> FacetShapes {
        facet_shapes(self.test_order(), lambda)
    }

    /// A_i = ∫ φ_i over the reference configuration (UL in the plane, UL² in space and of revolution); 0 without a test function.
    pub(super) fn test_areas(&self) -> &[f64] {
        &self.test_areas
    }

    /// The other nodes with a test function on the facets around node `a`, ascending.
    pub(super) fn test_neighbours(&self, a: usize) -> Vec<usize> {
        let facets = self.facets_around(a).map(|(f, _)| f);
        let nodes = facets.flat_map(|f| &self.facet(f)[..self.test_nodes()]);
        let mut others: Vec<usize> = nodes.copied().filter(|&b| b != a).collect();
        others.sort_unstable();
        others.dedup();
        others
    }

    /// The number of nodes with a test function.
    pub fn test_functions_len(&self) -> usize {
        let per_facet = self.test_nodes();
        let mut has_test = vec![false; self.nodes.len()];
        for facet in self.facets() {
            facet[..per_facet].iter().for_each(|&a| has_test[a] = true);
        }
        has_test.iter().filter(|has| **has).count()
    }

    /// The number of nodes of a facet with a test function; these nodes come first.
    pub fn test_nodes(&self) -> usize {
        self.test_order().facet_nodes::<D>()
    }

    /// The degree of the test functions.
    pub(super) fn test_order(&self) -> Order {
        match D == 2 && !self.is_revolved {
            true => self.order,
            false => Order::Linear,
        }
    }

    /// The typical length of a facet (UL): the (D−1)-th root of the mean measure.
    pub fn facet_size(&self) -> f64 {
        Self::root(self.measures().sum::<f64>() / self.len().max(1) as f64)
    }

    /// For each node, the mean length of the adjacent facets (UL).
    pub fn node_sizes(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.nodes.len()];
        for (f, facet) in self.facets().enumerate() {
            let size = self.length(f);
            for &a in facet {
                sums[a] = (sums[a].0 + size, sums[a].1 + 1.0);
            }
        }
        sums.iter().map(|(sum, count)| sum / count).collect()
    }

    /// For each node the mean distance to the next ones on its facets, where the surface's nodes are at `x` (UL).
    pub fn node_spacings(&self, x: &[Vector<D>]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.nodes.len()];
        for facet in self.facets() {
            for e in 0..D * (D - 1) / 2 {
                let [a, b] = facet_edge::<D>(e).map(|k| facet[k]);
                let apart = (x[a] - x[b]).norm() / self.order.degree() as f64;
                for node in [a, b].into_iter().chain(facet.get(D + e).copied()) {
                    sums[node] = (sums[node].0 + apart, sums[node].1 + 1.0);
                }
            }
        }
        sums.iter().map(|(sum, count)| sum / count).collect()
    }

    /// For each node the others of its facets, without repetition.
    pub fn neighbours(&self) -> Vec<Vec<usize>> {
        let mut neighbours = vec![Vec::new(); self.nodes.len()];
        for facet in self.facets() {
            for &a in facet {
                let others = facet.iter().copied().filter(|&b| b != a);
                let known: &mut Vec<usize> = &mut neighbours[a];
                known.extend(others);
            }
        }
        for own in &mut neighbours {
            own.sort_unstable();
            own.dedup();
        }
        neighbours
    }

    /// The connected parts of the nodes that are marked.
    pub fn zones(&self, marked: &[bool]) -> Vec<Vec<usize>> {
        let neighbours = self.neighbours();
        let mut is_left = marked.to_vec();
        let mut zones = Vec::new();
        for first in 0..marked.len() {
            if !std::mem::take(&mut is_left[first]) {
                continue;
            }
            let mut zone = vec![first];
            let mut next = 0;
            while let Some(&a) = zone.get(next) {
                next += 1;
                let others = neighbours[a].iter().copied();
                zone.extend(others.filter(|b| std::mem::take(&mut is_left[*b])));
            }
            zones.push(zone);
        }
        zones
    }

    /// For each node its share of the area (UL in the plane, UL² in space and of revolution), where the surface's nodes are at `x`
    /// (UL): of the halves of quadratic segments and the quarters of quadratic triangles, nodes share each equally.
    pub fn node_areas(&self, x: &[Vector<D>]) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        let rule = FacetRule::<D>::gauss(3);
        for (facet, nodes) in self.facets_at(x).zip(self.facets()) {
            let points = rule.points().iter();
            let measure: f64 = points.map(|(w, l)| w * facet.normal(l).norm()).sum();
            let is_quadratic_segment = nodes.len() > D && D == 2;
            for (k, &a) in nodes.iter().enumerate() {
                areas[a] += measure
                    * self.ring(&facet, &self.middle_of_share(k))
                    * match (is_quadratic_segment, k < D) {
                        (true, true) => 0.25,
                        (true, false) => 0.5,
                        _ if nodes.len() == D => 1.0 / D as f64,
                        // a quadratic triangle: of four parts, corners have a third of one each
                        (false, true) => 1.0 / 12.0,
                        (false, false) => 0.25,
                    };
            }
        }
        areas
    }

    /// λ in the middle of the share that the `k`-th node has of a facet in the plane.
    fn middle_of_share(&self, k: usize) -> Vector<D> {
        let own = match self.order {
            Order::Linear => 0.75,
            Order::Quadratic => 0.875,
        };
        let mut lambda = Vector::repeat(0.5);
        if k < D {
            lambda = Vector::repeat(1.0 - own);
            lambda[k] = own;
        }
        lambda
    }

    /// The length of facet `f` (UL): the (D−1)-th root of its measure.
    pub fn length(&self, f: usize) -> f64 {
        Self::root(self.measure_of(f))
    }

    /// The (D−1)-th root: a length from a measure.
    fn root(measure: f64) -> f64 {
        measure.powf(1.0 / (D as f64 - 1.0))
    }

    /// The length of the smallest facet (UL).
    pub fn smallest_facet(&self) -> f64 {
        Self::root(self.measures().fold(f64::INFINITY, f64::min))
    }

    /// The reference measures of the facets.
    fn measures(&self) -> impl Iterator<Item = f64> {
        (0..self.len()).map(|f| self.measure_of(f))
    }

    /// The reference measure of facet `f` (UL in the plane, UL² in space); of a curved facet up to terms of its curvature.
    fn measure_of(&self, f: usize) -> f64 {
        let centre = Vector::repeat(1.0 / D as f64);
        self.reference[f].normal(&centre).norm()
    }
}
