//! Which facets are exterior.

use std::collections::HashMap;

use crate::error::Error;

/// The facets that belong to one cell only, oriented outward, in the order of their cells.
///
/// Facet k of a simplex leaves out corner k. Taking the other corners in order gives the outward
/// orientation for even k; for odd k two corners are swapped.
pub(super) fn exterior_facets<const D: usize>(cells: &[usize]) -> Result<Vec<[usize; D]>, Error> {
    let mut count: HashMap<[usize; D], usize> = HashMap::new();
    let facets = || {
        cells
            .chunks_exact(D + 1)
            .flat_map(|cell| (0..=D).map(|k| facet::<D>(cell, k)))
    };
    let sorted = |mut nodes: [usize; D]| {
        nodes.sort_unstable();
        nodes
    };
    for facet in facets() {
        *count.entry(sorted(facet)).or_insert(0) += 1;
    }
    if let Some((nodes, &cells)) = count.iter().filter(|(_, c)| **c > 2).min() {
        return Err(Error::NonManifoldFacet {
            nodes: nodes.to_vec(),
            cells,
        });
    }
    Ok(facets().filter(|&f| count[&sorted(f)] == 1).collect())
}

fn facet<const D: usize>(cell: &[usize], omitted: usize) -> [usize; D] {
    let mut nodes = [0; D];
    let kept = (0..=D).filter(|&a| a != omitted);
    for (node, a) in nodes.iter_mut().zip(kept) {
        *node = cell[a];
    }
    if omitted % 2 == 1 {
        nodes.swap(0, 1);
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::{Vector, facet_normal};

    fn outward<const D: usize>(corners: &[Vector<D>]) {
        let cell: Vec<usize> = (0..=D).collect();
        let centre = corners.iter().sum::<Vector<D>>() / (D + 1) as f64;
        let facets = exterior_facets::<D>(&cell).expect("one cell");
        assert_eq!(facets.len(), D + 1);
        for facet in facets {
            let x = facet.map(|a| corners[a]);
            assert!(facet_normal(&x).dot(&(x[0] - centre)) > 0.0, "{facet:?}");
        }
    }

    #[test]
    fn facets_of_one_cell_point_outward() {
        outward(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from));
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        outward(&corners.map(Vector::<3>::from));
    }

    #[test]
    fn shared_facets_are_interior() {
        let facets = exterior_facets::<2>(&[0, 1, 2, 0, 2, 3]).expect("two cells");
        assert_eq!(facets, [[1, 2], [0, 1], [2, 3], [3, 0]]);
    }

    #[test]
    fn three_cells_on_one_edge_are_refused() {
        let cells = [0, 1, 2, 0, 1, 3, 0, 1, 4];
        let error = exterior_facets::<2>(&cells).expect_err("non-manifold");
        assert!(matches!(error, Error::NonManifoldFacet { cells: 3, .. }));
    }
}
