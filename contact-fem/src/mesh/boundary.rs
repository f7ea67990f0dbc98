//! Which facets are exterior.

use std::collections::HashMap;

use crate::element::p2::CELL_EDGES;
use crate::element::{Order, facet_edge};
use crate::error::Error;

/// Nodes and cells of the exterior facets, and a facet with two cells on one side.
type Exterior<const D: usize> = (Vec<usize>, Vec<usize>, Option<[usize; D]>);

/// The nodes of the facets that belong to one cell only, oriented outward, in the order of their
/// cells: [`Order::facet_nodes`] each, flat; the cell of each; and the corners of a facet that has two
/// cells on the same side, if there is one.
///
/// Facet k of a simplex leaves out corner k. Taking the other corners in order gives the outward
/// orientation for even k; for odd k two corners are swapped.
pub(super) fn exterior_facets<const D: usize>(
    order: Order,
    cells: &[usize],
) -> Result<Exterior<D>, Error> {
    // how many cells have a facet, and of those how many see it as an even permutation of its corners
    let mut count: HashMap<[usize; D], (usize, usize)> = HashMap::new();
    let facets = || {
        let cells = cells.chunks_exact(order.cell_nodes::<D>());
        let cells = cells.enumerate();
        cells.flat_map(|(owner, cell)| (0..=D).map(move |k| (owner, cell, local_facet::<D>(k))))
    };
    let sorted = |cell: &[usize], facet: [usize; D]| {
        let mut corners = facet.map(|a| cell[a]);
        corners.sort_unstable();
        corners
    };
    for (_, cell, facet) in facets() {
        let (cells, even) = count.entry(sorted(cell, facet)).or_insert((0, 0));
        *cells += 1;
        *even += usize::from(is_even(&facet.map(|a| cell[a])));
    }
    if let Some((nodes, &(cells, _))) = count.iter().filter(|(_, c)| c.0 > 2).min() {
        return Err(Error::NonManifoldFacet {
            nodes: nodes.to_vec(),
            cells,
        });
    }
    // two cells on different sides see a facet in opposite orientations
    let folded = count.iter().filter(|(_, c)| c.0 == 2 && c.1 != 1).min();
    let folded = folded.map(|(corners, _)| *corners);
    let (mut nodes, mut owners) = (Vec::new(), Vec::new());
    for (owner, cell, facet) in facets() {
        if count[&sorted(cell, facet)].0 > 1 {
            continue;
        }
        owners.push(owner);
        nodes.extend(facet.map(|a| cell[a]));
        for e in 0..order.facet_nodes::<D>() - D {
            let [a, b] = facet_edge::<D>(e).map(|k| facet[k]);
            let edge = CELL_EDGES
                .iter()
                .position(|edge| [[a, b], [b, a]].contains(edge));
            nodes.extend(edge.map(|edge| cell[D + 1 + edge]));
        }
    }
    Ok((nodes, owners, folded))
}

/// Whether sorting takes an even number of swaps.
fn is_even<const D: usize>(corners: &[usize; D]) -> bool {
    let pairs = (0..D).flat_map(|j| (0..j).map(move |i| (i, j)));
    pairs.filter(|&(i, j)| corners[i] > corners[j]).count() % 2 == 0
}

/// The corners, numbered within the cell, of the facet that leaves out one of them.
fn local_facet<const D: usize>(omitted: usize) -> [usize; D] {
    let mut corners = std::array::from_fn(|k| if k < omitted { k } else { k + 1 });
    if omitted % 2 == 1 {
        corners.swap(0, 1);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::{Vector, facet_normal};

    fn outward<const D: usize>(corners: &[Vector<D>]) {
        let cell: Vec<usize> = (0..=D).collect();
        let centre = corners.iter().sum::<Vector<D>>() / (D + 1) as f64;
        let (facets, ..) = exterior_facets::<D>(Order::Linear, &cell).expect("one cell");
        assert_eq!(facets.len(), D * (D + 1));
        for facet in facets.chunks_exact(D) {
            let x: [Vector<D>; D] = std::array::from_fn(|k| corners[facet[k]]);
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

    /// A quadratic facet's middle nodes are those of the cell's edges between its corners.
    #[test]
    fn middle_nodes_are_between_their_corners() {
        let middle = |a: usize, b: usize| {
            let edge = CELL_EDGES.iter().position(|&e| e == [a, b] || e == [b, a]);
            4 + edge.expect("an edge")
        };
        let cell: Vec<usize> = (0..10).collect();
        let (facets, ..) = exterior_facets::<3>(Order::Quadratic, &cell).expect("one cell");
        assert_eq!(facets.len(), 4 * 6);
        for facet in facets.chunks_exact(6) {
            let [a, b, c] = [facet[0], facet[1], facet[2]];
            assert_eq!(facet[3..], [middle(a, b), middle(b, c), middle(c, a)]);
        }
    }

    #[test]
    fn shared_facets_are_interior() {
        let facets = exterior_facets::<2>(Order::Linear, &[0, 1, 2, 0, 2, 3]).expect("two cells");
        assert_eq!(
            facets,
            ([1, 2, 0, 1, 2, 3, 3, 0].into(), [0, 0, 1, 1].into(), None)
        );
    }

    #[test]
    fn cells_on_the_same_side_are_found() {
        for cells in [[0, 1, 2, 3, 0, 1, 2, 3], [0, 1, 2, 3, 0, 1, 2, 4]] {
            let (.., folded) = exterior_facets::<3>(Order::Linear, &cells).expect("manifold");
            assert_eq!(folded, Some([0, 1, 2]));
        }
        let (.., folded) =
            exterior_facets::<2>(Order::Linear, &[0, 1, 2, 0, 1, 3]).expect("manifold");
        assert_eq!(folded, Some([0, 1]));
    }

    #[test]
    fn three_cells_on_one_edge_are_refused() {
        let cells = [0, 1, 2, 0, 1, 3, 0, 1, 4];
        let error = exterior_facets::<2>(Order::Linear, &cells).expect_err("non-manifold");
        assert!(matches!(error, Error::NonManifoldFacet { cells: 3, .. }));
    }
}
