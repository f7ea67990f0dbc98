//! Bisection of tetrahedra, after D. N. Arnold, A. Mukherjee and L. Pouly, Locally adapted tetrahedral meshes using bisection, SIAM J. Sci. Comput. 22
//! (2000) 431–448.
//!
//! Each facet has a marked edge, the same in the cells on both sides. A cell is halved across its refinement edge, which is the marked edge of the two
//! facets that meet there. The marks of the halves follow from those of the cell alone. Therefore no more than 72 shapes ever descend from one cell, and
//! neighbours that are halved across the same edge fit together.

use std::cmp::Reverse;
use std::collections::HashSet;

use super::pieces::{Cutter, Piece, edge};
use super::{Mesh, Vector};
use crate::element::p2::CELL_EDGES;
use crate::error::Error;

/// The marks of a tetrahedron. Edges are given by their ends, corners of the cell, ascending.
#[derive(Clone, Copy, Debug)]
pub(in crate::mesh) struct Marks {
    /// The refinement edge.
    edge: [usize; 2],
    /// The marked edge of the facet opposite each corner.
    facets: [[usize; 2]; 4],
    /// Whether this is half of a cell without this flag whose refinement edge and other two marked edges were in one plane. It decides how the facet between
    /// its own halves is marked.
    is_flagged: bool,
}

impl Marks {
    /// The marks of a cell that was never halved: longest edges, the same for both cells at a facet.
    fn of<const D: usize>(mesh: &Mesh<D>, cell: usize) -> Self {
        let nodes = mesh.corners(cell);
        let length = |[a, b]: [usize; 2]| {
            let square = (mesh.nodes[nodes[a]] - mesh.nodes[nodes[b]]).norm_squared();
            // without the last digits, which are round-off: node numbers decide between equal lengths
            square.to_bits() >> 24
        };
        let longest = |is_there: &dyn Fn([usize; 2]) -> bool| {
            let edges = CELL_EDGES.map(|[a, b]| edge(a, b)).into_iter();
            let candidates = edges.filter(|ends| is_there(*ends));
            let order =
                |ends: &[usize; 2]| (length(*ends), Reverse(edge(nodes[ends[0]], nodes[ends[1]])));
            candidates.max_by_key(order).unwrap_or([0, 1])
        };
        Marks {
            edge: longest(&|_| true),
            facets: std::array::from_fn(|opposite| longest(&|ends| !ends.contains(&opposite))),
            is_flagged: false,
        }
    }

    /// The marks of the halves, in which the new corner is in the place of the second and of the first end of the refinement edge.
    fn halves(&self) -> [Marks; 2] {
        let [a, b] = self.edge;
        let mut others = (0..4).filter(|corner| !self.edge.contains(corner));
        let [c, d] = std::array::from_fn(|_| others.next().unwrap_or(0));
        let is_common = |e: &usize| self.facets[b] == edge(a, *e) && self.facets[a] == edge(b, *e);
        // where the marked edges are in one plane, the corner that the refinement edge is not at
        let planar = [c, d].into_iter().find(is_common);
        [[a, b], [b, a]].map(|[kept, new]| {
            let mut facets = [[0; 2]; 4];
            facets[new] = self.facets[new];
            facets[c] = edge(kept, d);
            facets[d] = edge(kept, c);
            // the facet between the halves
            facets[kept] = match planar {
                Some(e) if self.is_flagged => edge(new, e),
                _ => edge(c, d),
            };
            Marks {
                edge: self.facets[new],
                facets,
                is_flagged: planar.is_some() && !self.is_flagged,
            }
        })
    }
}

/// A cell that bisection has come to.
struct Leaf<const D: usize> {
    piece: Piece<D>,
    marks: Marks,
    /// How often the old cell was halved on the way to this piece.
    generation: usize,
}

/// Halved three times, a tetrahedron becomes eight.
const GENERATIONS: usize = 3;

impl<const D: usize> Mesh<D> {
    /// The mesh in which marked tetrahedra are halved three times, and cells with a node in the middle of an edge as often as it takes.
    pub(super) fn bisected(
        &self,
        marked: &[bool],
        field: &mut Vec<Vector<D>>,
    ) -> Result<Self, Error> {
        let mut cutter = Cutter::new(self, field);
        let leaf = |cell: usize| Leaf {
            piece: cutter.whole(cell),
            marks: match self.marks.get(cell) {
                Some(marks) => *marks,
                None => Marks::of(self, cell),
            },
            generation: 0,
        };
        let mut leaves: Vec<Leaf<D>> = (0..self.len()).map(leaf).collect();
        let mut halved: HashSet<[usize; 2]> = HashSet::new();
        for generation in 1..=GENERATIONS {
            loop {
                let before = leaves.len();
                let mut next = Vec::with_capacity(before);
                for leaf in leaves {
                    let nodes = leaf.piece.corners;
                    let has_hanging = || {
                        let mut edges = CELL_EDGES.iter();
                        edges.any(|&[a, b]| halved.contains(&edge(nodes[a], nodes[b])))
                    };
                    let is_due = marked[leaf.piece.cell] && leaf.generation < generation;
                    if !is_due && !has_hanging() {
                        next.push(leaf);
                        continue;
                    }
                    let [a, b] = leaf.marks.edge;
                    halved.insert(edge(nodes[a], nodes[b]));
                    let halves = cutter.halves(&leaf.piece, [a, b]);
                    let halves = halves.into_iter().zip(leaf.marks.halves());
                    next.extend(halves.map(|(piece, marks)| Leaf {
                        piece,
                        marks,
                        generation: leaf.generation + 1,
                    }));
                }
                leaves = next;
                if leaves.len() == before {
                    break;
                }
            }
        }
        let pieces: Vec<Piece<D>> = leaves.iter().map(|leaf| leaf.piece).collect();
        let mut mesh = cutter.mesh(&pieces)?;
        mesh.marks = leaves.iter().map(|leaf| leaf.marks).collect();
        Ok(mesh)
    }
}
