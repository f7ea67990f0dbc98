//! The exterior facets of a mesh.

use crate::element::p2::CELL_EDGES;
use crate::element::{Order, facet_edge};
use crate::error::Error;

/// Nodes and cells of the exterior facets; a facet with two cells on the same side.
type Exterior<const D: usize> = (Vec<usize>, Vec<usize>, Option<[usize; D]>);

/// The exterior facets, which belong to one cell only: their nodes, oriented outward, in the order
/// of the cells, [`Order::facet_nodes`] each, flat; the cell of each; and the corners of a facet
/// with two cells on the same side, if there is one.
///
/// Facet k of a simplex is opposite corner k. The other corners in order give the outward
/// orientation for even k; for odd k two corners are swapped. Facet k of cell c has the number (D +
/// 1) c + k.
pub(super) fn exterior_facets<const D: usize>(
    order: Order,
    cells: &[usize],
) -> Result<Exterior<D>, Error> {
    let per_cell = order.cell_nodes::<D>();
    let corners = |facet: usize| {
        let cell = &cells[facet / (D + 1) * per_cell..];
        local_facet::<D>(facet % (D + 1)).map(|a| cell[a])
    };
    let sorted = |facet: usize| {
        let mut corners = corners(facet);
        corners.sort_unstable();
        corners
    };
    let (starts, mut by_corner) = by_smallest_corner(cells.len() / per_cell * (D + 1), &sorted);
    let mut is_exterior = vec![false; by_corner.len()];
    let mut folded = None;
    for range in starts.windows(2) {
        let facets = &mut by_corner[range[0]..range[1]];
        facets.sort_unstable_by_key(|&facet| sorted(facet));
        for same in facets.chunk_by(|&f, &g| sorted(f) == sorted(g)) {
            match *same {
                [facet] => is_exterior[facet] = true,
                // the cells on the two sides of a facet see it in opposite orientations
                [f, g] if is_even(&corners(f)) != is_even(&corners(g)) => {}
                [f, _] => folded = folded.or(Some(sorted(f))),
                _ => {
                    return Err(Error::NonManifoldFacet {
                        nodes: sorted(same[0]).to_vec(),
                        cells: same.len(),
                    });
                }
            }
        }
    }
    let (mut nodes, mut owners) = (Vec::new(), Vec::new());
    for facet in (0..is_exterior.len()).filter(|&facet| is_exterior[facet]) {
        let (owner, local) = (facet / (D + 1), local_facet::<D>(facet % (D + 1)));
        let cell = &cells[owner * per_cell..(owner + 1) * per_cell];
        owners.push(owner);
        nodes.extend(local.map(|a| cell[a]));
        for e in 0..order.facet_nodes::<D>() - D {
            let [a, b] = facet_edge::<D>(e).map(|k| local[k]);
            let edge = CELL_EDGES
                .iter()
                .position(|edge| [[a, b], [b, a]].contains(edge));
            nodes.extend(edge.map(|edge| cell[D + 1 + edge]));
        }
    }
    Ok((nodes, owners, folded))
}

/// The numbers of all `count` facets, sorted by the smallest of their corners, and the position at
/// which those of each node start. A node has few facets, so that sorting within a node is fast.
fn by_smallest_corner<const D: usize>(
    count: usize,
    sorted: &impl Fn(usize) -> [usize; D],
) -> (Vec<usize>, Vec<usize>) {
    let smallest: Vec<usize> = (0..count).map(|facet| sorted(facet)[0]).collect();
    let nodes = smallest.iter().max().map_or(0, |node| node + 1);
    let mut starts = vec![0; nodes + 1];
    smallest.iter().for_each(|&node| starts[node + 1] += 1);
    (0..nodes).for_each(|node| starts[node + 1] += starts[node]);
    let (mut next, mut facets) = (starts.clone(), vec![0; count]);
    for (facet, &node) in smallest.iter().enumerate() {
        facets[next[node]] = facet;
        next[node] += 1;
    }
    (starts, facets)
}

/// Whether sorting the corners is an even permutation.
fn is_even<const D: usize>(corners: &[usize; D]) -> bool {
    let pairs = (0..D).flat_map(|j| (0..j).map(move |i| (i, j)));
    pairs.filter(|&(i, j)| corners[i] > corners[j]).count() % 2 == 0
}

/// The corners, numbered within the cell, of the facet opposite one of them.
pub(super) fn local_facet<const D: usize>(omitted: usize) -> [usize; D] {
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
