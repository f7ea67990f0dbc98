//! How far the gaps of nodes are from those of their rows, equation (5) of the paper.

use super::consistent::{shares, test_nodes};
use crate::contact::surface::Surface;
use crate::element::{FacetRule, facet_shapes};

/// A row is whole if its points have at least this share of ∫ φ_i dS: quadrature may take the rest.
const WHOLE: f64 = 0.99;

/// c_i − Σ_a ∫ φ_i N_a dS g_a / ∫ φ_i dS at each node of `surface` (UL): the gap c_i of its row less the mean of the nodes' gaps g_a with its
/// test function φ_i, both over the reference surface. The two differ where the other surface is curved between the nodes. Where smooth
/// surfaces touch everywhere, c_i is zero and all g_a have one value, which is minus this.
///
/// `gaps` has g_a (UL). `row` has c_i (UL) and ∫ φ_i dS (UL in the plane, UL² in space and of revolution) over the points that have a
/// counterpart, for each node that has a row. Nodes without a test function have the mean of the two ends of their edge. The result is 0 at
/// nodes without a row, and where a part of the test function has no counterpart.
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
