//! How gaps of nodes are from the gaps of their rows.

use super::consistent::{shares, test_nodes};
use crate::contact::surface::Surface;
use crate::element::{FacetRule, facet_shapes};

/// A row whose test function has at least this share of its integral where there is a counterpart is whole; the rest is the error of
/// quadrature.
const WHOLE: f64 = 0.99;

/// At each node of `surface` by how much the gap of its row is above the mean that the `gaps` of nodes (UL), interpolated by the shape
/// functions, have with its test function (UL). A row has the gaps of straight facets, which change between nodes with the curvature of the
/// other surface. Where both surfaces touch all along, each node's gap is minus this.
///
/// `row` has the gap (UL) and the integral of the test function (UL or UL², reference) of the row of a node, if it has one. Nodes without a
/// test function have what those of their edge interpolate. It is 0 where a part of the test function has no counterpart.
pub fn row_offsets<const D: usize>(
    surface: &Surface<D>,
    gaps: &[Option<f64>],
    row: impl Fn(usize) -> Option<(f64, f64)>,
) -> Vec<f64> {
    let (tests, ends) = test_nodes(surface);
    let count = tests.iter().flatten().count();
    let [mut sums, mut sizes] = [0, 1].map(|_| vec![0.0; count]);
    let rule = FacetRule::<D>::gauss(3);
    for (f, nodes) in surface.facets().enumerate() {
        for (w, lambda) in rule.points() {
            let w = w * surface.measure(f, lambda);
            let shapes = nodes.iter().zip(facet_shapes(surface.order(), lambda));
            // without a counterpart of one of the nodes, there is no mean
            let gap: f64 = shapes.map(|(&a, N)| N * gaps[a].unwrap_or(f64::NAN)).sum();
            for (&a, phi) in nodes.iter().zip(surface.test_functions(lambda)) {
                if let Some(row) = tests[a] {
                    sums[row] += w * phi * gap;
                    sizes[row] += w * phi;
                }
            }
        }
    }
    let mut offsets = vec![0.0; count];
    for (a, test) in tests.iter().enumerate() {
        if let (Some(own), Some((gap, size))) = (*test, row(a)) {
            let offset = gap - sums[own] / sizes[own];
            let is_whole = size >= WHOLE * sizes[own];
            offsets[own] = if is_whole && offset.is_finite() {
                offset
            } else {
                0.0
            };
        }
    }
    let at_node = |a: usize| {
        shares(&tests, &ends, a)
            .map(|(row, share)| share * offsets[row])
            .sum()
    };
    (0..gaps.len()).map(at_node).collect()
}
