//! Meshes with smaller cells: conforming, with the boundaries and regions of the coarse mesh.

mod bisection;
mod pieces;

use std::collections::HashSet;

pub(super) use self::bisection::Marks;
use self::pieces::{Cutter, Piece, edge};
use super::Mesh;
use crate::element::p2::CELL_EDGES;
use crate::error::Error;
use crate::tensor::Vector;

/// A corner of a new cell: the number that the node has in a quadratic cell, a corner or the middle of an edge.
type Local = usize;

impl<const D: usize> Mesh<D> {
    /// The mesh with all edges halved: four cells for each in the plane, eight in space.
    ///
    /// Boundaries, regions and their names stay what they are. The middle of a straight edge is half way between its corners. The middle of a quadratic
    /// edge is where its cell's shape functions have it, so that curved sides keep their shape; [`Mesh::curved`] moves it onto a curve.
    ///
    /// In the plane the four cells are similar to the old one. In space four are; the octahedron between them is cut along its shortest
    /// diagonal.
    ///
    /// # Errors
    /// If a new cell of a curved one is folded.
    pub fn refined(&self) -> Result<Self, Error> {
        self.cut(|k| self.halved(k), &mut Vec::new())
    }

    /// The cells of one whose edges are all halved; the first D + 1 entries of each are its corners.
    fn halved(&self, k: usize) -> Vec<[Local; 4]> {
        if D == 2 {
            return vec![[0, 3, 5, 0], [3, 1, 4, 0], [5, 4, 2, 0], [3, 4, 5, 0]];
        }
        let corners = self.corners(k);
        let middle = |e: usize| {
            let [a, b] = CELL_EDGES[e].map(|a| self.nodes[corners[a]]);
            (a + b) * 0.5
        };
        // the middles of opposite edges, and the other four around the line between them
        let diagonals = [
            ([0, 5], [1, 2, 3, 4]),
            ([1, 3], [0, 2, 5, 4]),
            ([2, 4], [0, 1, 5, 3]),
        ];
        let length = |[a, b]: [usize; 2]| (middle(a) - middle(b)).norm();
        let shorter =
            |x: &&([usize; 2], _), y: &&([usize; 2], _)| length(x.0).total_cmp(&length(y.0));
        let mut cells = vec![[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];
        if let Some(([a, b], around)) = diagonals.iter().min_by(shorter) {
            let ring = (0..4).map(|i| [around[i], around[(i + 1) % 4]]);
            cells.extend(ring.map(|[c, d]| [4 + a, 4 + b, 4 + c, 4 + d]));
        }
        cells
    }

    /// The mesh of the cells into which each old one is cut. `field` has a value for each node, or none at all; the values of new nodes are added.
    fn cut(
        &self,
        cells: impl Fn(usize) -> Vec<[Local; 4]>,
        field: &mut Vec<Vector<D>>,
    ) -> Result<Self, Error> {
        let mut cutter = Cutter::new(self, field);
        let pieces = (0..self.len()).flat_map(|k| cutter.pieces(k, &cells(k)));
        let pieces: Vec<Piece<D>> = pieces.collect();
        cutter.mesh(&pieces)
    }

    /// The corners of the edge whose middle node is `local`, ascending.
    fn edge(&self, k: usize, local: Local) -> [usize; 2] {
        let [a, b] = CELL_EDGES[local - D - 1].map(|a| self.corners(k)[a]);
        edge(a, b)
    }

    /// The mesh in which the `marked` cells are smaller, and as few others as keep it conforming. Names, labels and curved sides are as with
    /// [`Mesh::refined`].
    ///
    /// In the plane all edges of marked cells are halved. Cells with a halved edge are cut along their longest edge first, after M.-C. Rivara, Algorithms
    /// for refining triangular grids suitable for adaptive and multigrid techniques, Int. J. Numer. Meth. Engng 20 (1984) 745–756: however often a
    /// mesh is refined, no angle becomes smaller than half the smallest one it had (I. G. Rosenberg and F. Stenger, SIAM J. Numer. Anal. 12 (1975) 390–395).
    ///
    /// In space marked cells are halved three times, after D. N. Arnold, A. Mukherjee and L. Pouly, Locally adapted tetrahedral meshes using bisection, SIAM J.
    /// Sci. Comput. 22 (2000) 431–448: however often a mesh is refined in this way, the cells that descend from one of its cells have no more than 72
    /// shapes.
    ///
    /// # Errors
    /// If there is not one mark for each cell; as [`Mesh::refined`].
    pub fn refined_where(&self, marked: &[bool]) -> Result<Self, Error> {
        self.cut_where(marked, &mut Vec::new())
    }

    /// As [`Mesh::refined_where`], with a `field` of the nodes, which has their values in the cells at the nodes of the new mesh afterwards.
    ///
    /// # Errors
    /// If there is not one value for each node; as [`Mesh::refined_where`].
    pub fn refined_with(&self, marked: &[bool], field: &mut Vec<Vector<D>>) -> Result<Self, Error> {
        contact_core::Error::check_length_of("field", field.len(), self.nodes.len())?;
        self.cut_where(marked, field)
    }

    fn cut_where(&self, marked: &[bool], field: &mut Vec<Vector<D>>) -> Result<Self, Error> {
        contact_core::Error::check_length_of("marks", marked.len(), self.len())?;
        if D == 3 {
            return self.bisected(marked, field);
        }
        let longest: Vec<Local> = (0..self.len()).map(|k| self.longest_edge(k)).collect();
        let mut halved: HashSet<[usize; 2]> = HashSet::new();
        for (k, _) in marked.iter().enumerate().filter(|(_, marked)| **marked) {
            halved.extend((3..6).map(|local| self.edge(k, local)));
        }
        loop {
            let before = halved.len();
            for (k, &longest) in longest.iter().enumerate() {
                if (3..6).any(|local| halved.contains(&self.edge(k, local))) {
                    halved.insert(self.edge(k, longest));
                }
            }
            if halved.len() == before {
                break;
            }
        }
        let is_halved = |k: usize, local: Local| halved.contains(&self.edge(k, local));
        let cells = |k: usize| pieces_of_triangle(longest[k], |local| is_halved(k, local));
        self.cut(cells, field)
    }

    /// The middle node of the longest edge; of edges that are equally long, of the one with the lowest corners.
    fn longest_edge(&self, k: usize) -> Local {
        let square = |local: Local| {
            let [a, b] = self.edge(k, local);
            (self.nodes[a] - self.nodes[b]).norm_squared()
        };
        let longest = (3..6).map(square).fold(0.0, f64::max);
        let candidates = (3..6).filter(|&local| square(local) > (1.0 - 1e-9) * longest);
        let lowest = candidates.min_by_key(|&local| self.edge(k, local));
        lowest.unwrap_or(3)
    }
}

/// The cells of a triangle some of whose edges are halved, the longest among them.
fn pieces_of_triangle(longest: Local, is_halved: impl Fn(Local) -> bool) -> Vec<[Local; 4]> {
    if !is_halved(longest) {
        return vec![[0, 1, 2, 0]];
    }
    // counter-clockwise from a, where the longest edge begins
    let a = longest - 3;
    let [b, c] = [(a + 1) % 3, (a + 2) % 3];
    let half = |[from, to]: [usize; 2], edge: Local, tip: Local| match is_halved(edge) {
        // the third corner of both is the middle of the longest edge
        true => vec![[from, edge, tip, 0], [edge, to, tip, 0]],
        false => vec![[from, to, tip, 0]],
    };
    let mut cells = half([b, c], 3 + b, longest);
    cells.extend(half([c, a], 3 + c, longest));
    cells
}

#[cfg(test)]
mod tests;
