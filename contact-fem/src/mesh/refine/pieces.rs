//! Cells that are cut into pieces, and the mesh of the pieces.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::{Local, Mesh};
use crate::element::Order;
use crate::element::cell_rule::corner;
use crate::element::p2::{self, CELL_EDGES};
use crate::error::Error;
use crate::mesh::boundary::local_facet;
use crate::tensor::{Matrix, Vector, determinant};

/// The ends of an edge, ascending.
pub(super) fn edge(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A part of an old cell, or the whole of it.
#[derive(Clone, Copy)]
pub(super) struct Piece<const D: usize> {
    /// The old cell.
    pub(super) cell: usize,
    /// Its corners, nodes of the new mesh; in the plane the last entry means nothing.
    pub(super) corners: [usize; 4],
    /// Where they are in the old cell. All are sums of powers of 1/2, and exact.
    xi: [Vector<D>; 4],
}

impl<const D: usize> Piece<D> {
    /// The side of the old cell, by the corner opposite, on which these corners are.
    fn side(&self, corners: impl Fn(usize) -> bool) -> Option<usize> {
        let is_on = |a: usize, side: usize| match side {
            0 => self.xi[a].sum() == 1.0,
            _ => self.xi[a][side - 1] == 0.0,
        };
        (0..=D).find(|&side| (0..=D).filter(|&a| corners(a)).all(|a| is_on(a, side)))
    }
}

/// Cuts the cells of a mesh.
pub(super) struct Cutter<'a, const D: usize> {
    old: &'a Mesh<D>,
    /// The old nodes and, after them, new ones.
    nodes: Vec<Vector<D>>,
    /// Values at the nodes; none at all if no field is carried.
    field: &'a mut Vec<Vector<D>>,
    /// The nodes in the middle of edges, by the ends of the edges.
    middles: HashMap<[usize; 2], usize>,
}

impl<'a, const D: usize> Cutter<'a, D> {
    pub(super) fn new(old: &'a Mesh<D>, field: &'a mut Vec<Vector<D>>) -> Self {
        let middles = old.cells().flat_map(|cell| {
            let own = cell[D + 1..].iter().zip(CELL_EDGES);
            own.map(|(&middle, [a, b])| (edge(cell[a], cell[b]), middle))
        });
        Cutter {
            old,
            nodes: old.nodes.clone(),
            middles: middles.collect(),
            field,
        }
    }

    /// The piece that is all of a cell.
    pub(super) fn whole(&self, cell: usize) -> Piece<D> {
        let own = self.old.corners(cell);
        Piece {
            cell,
            corners: std::array::from_fn(|a| own[a.min(D)]),
            xi: std::array::from_fn(|a| corner(a.min(D))),
        }
    }

    /// The pieces of a cell, by the numbers that their corners have in a quadratic cell. An inverted piece is turned.
    pub(super) fn pieces(&mut self, cell: usize, pieces: &[[Local; 4]]) -> Vec<Piece<D>> {
        let whole = self.whole(cell);
        let mut piece = |locals: &[Local; 4]| {
            let mut piece = whole;
            for (a, &local) in locals[..=D].iter().enumerate() {
                (piece.corners[a], piece.xi[a]) = match local > D {
                    true => self.half_way(&whole, CELL_EDGES[local - D - 1]),
                    false => (whole.corners[local], whole.xi[local]),
                };
            }
            let sides = Matrix::<D>::from_fn(|i, j| (piece.xi[j + 1] - piece.xi[0])[i]);
            if determinant(&sides) < 0.0 {
                piece.corners.swap(D - 1, D);
                piece.xi.swap(D - 1, D);
            }
            piece
        };
        pieces.iter().map(&mut piece).collect()
    }

    /// The halves of a piece on both sides of the middle of an edge. The middle is in place of the second end in the first half, and of the first end in the
    /// second half.
    pub(super) fn halves(&mut self, piece: &Piece<D>, [a, b]: [usize; 2]) -> [Piece<D>; 2] {
        let (node, xi) = self.half_way(piece, [a, b]);
        [b, a].map(|replaced| {
            let mut half = *piece;
            (half.corners[replaced], half.xi[replaced]) = (node, xi);
            half
        })
    }

    /// The node half way between two corners of a piece, which is new if there was none, and where it is in the old cell.
    fn half_way(&mut self, piece: &Piece<D>, [a, b]: [usize; 2]) -> (usize, Vector<D>) {
        let ends = [piece.corners[a], piece.corners[b]];
        let xi = (piece.xi[a] + piece.xi[b]) * 0.5;
        let node = *self
            .middles
            .entry(edge(ends[0], ends[1]))
            .or_insert_with(|| {
                let at = |values: &[Vector<D>]| match self.old.order {
                    Order::Linear => (values[ends[0]] + values[ends[1]]) * 0.5,
                    Order::Quadratic => {
                        let own = self.old.cell(piece.cell);
                        let mut shapes = [0.0; 10];
                        p2::shapes(&xi, &mut shapes[..own.len()]);
                        let terms = own.iter().zip(shapes);
                        terms.map(|(&node, N)| values[node] * N).sum()
                    }
                };
                self.nodes.push(at(&self.nodes));
                if !self.field.is_empty() {
                    self.field.push(at(self.field));
                }
                self.nodes.len() - 1
            });
        (node, xi)
    }

    /// The mesh of these pieces, with the names, the labels and whatever else holds for the old one.
    pub(super) fn mesh(mut self, pieces: &[Piece<D>]) -> Result<Mesh<D>, Error> {
        let order = self.old.order;
        let per_cell = order.cell_nodes::<D>();
        let mut cells = Vec::with_capacity(pieces.len() * per_cell);
        for piece in pieces {
            cells.extend_from_slice(&piece.corners[..=D]);
            for ends in &CELL_EDGES[..per_cell - D - 1] {
                cells.push(self.half_way(piece, *ends).0);
            }
        }
        let nodes = self.nodes.into_iter().map(Into::into).collect();
        let mut mesh = Mesh::of_order(order, nodes, cells)?;
        mesh.name_as(self.old, pieces);
        Ok(mesh)
    }
}

impl<const D: usize> Mesh<D> {
    /// Takes over from the mesh `of`, whose cells these pieces are.
    fn name_as(&mut self, of: &Self, pieces: &[Piece<D>]) {
        let mut facets: Vec<Vec<usize>> = vec![Vec::new(); of.owners.len()];
        let opposite = |facet: &[usize], k: usize| {
            let mut corners = of.corners(k).iter();
            corners.position(|a| !facet[..D].contains(a))
        };
        let old = of.exterior().zip(&of.owners).enumerate();
        let old: HashMap<(usize, Option<usize>), usize> = old
            .map(|(f, (facet, &k))| ((k, opposite(facet, k)), f))
            .collect();
        for (f, (facet, &owner)) in self.exterior().zip(&self.owners).enumerate() {
            let piece = &pieces[owner];
            let side = piece.side(|a| facet[..D].contains(&piece.corners[a]));
            if let Some(&parent) = old.get(&(piece.cell, side)) {
                facets[parent].push(f);
            }
        }
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); of.len()];
        let numbered = pieces.iter().enumerate();
        numbered.for_each(|(k, piece)| children[piece.cell].push(k));
        let renamed = |sets: &BTreeMap<String, Vec<usize>>, parts: &[Vec<usize>]| {
            let new = sets.iter().map(|(name, own)| {
                let mut new: Vec<usize> = own.iter().flat_map(|&k| &parts[k]).copied().collect();
                new.sort_unstable();
                (name.clone(), new)
            });
            new.collect()
        };
        self.boundaries = renamed(&of.boundaries, &facets);
        self.regions = renamed(&of.regions, &children);
        let inner = of.inner.iter();
        self.inner = inner
            .map(|(name, own)| (name.clone(), of.parts_of_inner(own, pieces)))
            .collect();
        (self.labels, self.region) = (of.labels.clone(), of.region);
        self.is_revolved = of.is_revolved;
    }

    /// The facets of pieces that are on one of these facets between cells, each once.
    fn parts_of_inner(&self, inner: &[[usize; D]], pieces: &[Piece<D>]) -> Vec<[usize; D]> {
        let sorted = |mut facet: [usize; D]| {
            facet.sort_unstable();
            facet
        };
        let opposite =
            |corners: &[usize], omitted: usize| local_facet::<D>(omitted).map(|k| corners[k]);
        let inner: HashSet<[usize; D]> = inner.iter().map(|facet| sorted(*facet)).collect();
        let (mut seen, mut parts) = (HashSet::new(), Vec::new());
        for piece in pieces {
            for omitted in 0..=D {
                let Some(side) = piece.side(|a| a != omitted) else {
                    continue;
                };
                let whole = sorted(opposite(self.corners(piece.cell), side));
                let part = opposite(&piece.corners, omitted);
                if inner.contains(&whole) && seen.insert(sorted(part)) {
                    parts.push(part);
                }
            }
        }
        parts
    }
}
