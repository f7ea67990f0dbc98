//! Simplicial meshes with named boundaries.

mod boundary;
pub mod generators;
pub mod read;

use std::collections::BTreeMap;

use crate::error::Error;
use crate::tensor::{Matrix, Vector, determinant, inverse_transpose};

/// A mesh of linear simplices in ℝᴰ, validated when it is made.
///
/// Cells have D + 1 nodes in positive orientation (counter-clockwise in the plane), facets D nodes
/// with the body on their left (plane) or behind their counter-clockwise side (space).
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize> {
    nodes: Vec<Vector<D>>,
    /// Flat, D + 1 a cell.
    cells: Vec<usize>,
    /// The exterior facets.
    facets: Vec<[usize; D]>,
    /// Named sets of exterior facets.
    boundaries: BTreeMap<String, Vec<usize>>,
}

impl<const D: usize> Mesh<D> {
    /// Nodes of a cell.
    pub const CELL_NODES: usize = D + 1;
    /// Cells below this share of their longest edge's D-th power are degenerate.
    const DEGENERATE: f64 = 1e-12;

    /// From node coordinates (UL) and cells, D + 1 node numbers each, flat.
    ///
    /// # Errors
    /// No cells, an incomplete cell, a node out of range or unused, a coordinate that is not
    /// finite, an inverted or degenerate cell, a facet of more than two cells.
    pub fn new(nodes: Vec<[f64; D]>, cells: Vec<usize>) -> Result<Self, Error> {
        if cells.is_empty() {
            return Err(Error::EmptyMesh);
        }
        if cells.len() % Self::CELL_NODES != 0 {
            return Err(Error::Setting {
                name: "cells.len()",
                value: cells.len() as f64,
                remedy: "give D + 1 node numbers for each cell",
            });
        }
        Error::check_finite("node coordinate", nodes.iter().flatten())?;
        let nodes: Vec<Vector<D>> = nodes.into_iter().map(Vector::from).collect();
        let mut used = vec![false; nodes.len()];
        for (k, &node) in cells.iter().enumerate() {
            *used.get_mut(node).ok_or(Error::NodeOutOfRange {
                cell: k / Self::CELL_NODES,
                node,
                nodes: nodes.len(),
            })? = true;
        }
        if let Some(node) = used.iter().position(|u| !u) {
            return Err(Error::OrphanNode { node });
        }
        let facets = boundary::exterior_facets::<D>(&cells)?;
        let mesh = Mesh {
            nodes,
            cells,
            facets,
            boundaries: BTreeMap::new(),
        };
        mesh.check_cells()?;
        Ok(mesh)
    }

    fn check_cells(&self) -> Result<(), Error> {
        for cell in 0..self.len() {
            let volume = self.volume(cell);
            let corners = self.cell(cell);
            let edges = corners.iter().enumerate().flat_map(|(k, &a)| {
                let others = corners[..k].iter();
                others.map(move |&b| (self.nodes[a] - self.nodes[b]).norm())
            });
            let size = edges.fold(0.0, f64::max);
            if !(volume.abs() > Self::DEGENERATE * size.powi(D as i32)) {
                return Err(Error::DegenerateCell { cell, volume, size });
            }
            if volume < 0.0 {
                return Err(Error::InvertedCell { cell, volume });
            }
        }
        Ok(())
    }

    /// Calls `name` those exterior facets whose corners all satisfy `contains`; adds to a boundary
    /// of that name. A name that catches nothing is kept, empty.
    pub fn name_boundary(&mut self, name: &str, contains: impl Fn(&Vector<D>) -> bool) {
        let inside = |facet: &[usize; D]| facet.iter().all(|&a| contains(&self.nodes[a]));
        let found: Vec<usize> = (0..self.facets.len())
            .filter(|&f| inside(&self.facets[f]))
            .collect();
        let named = self.boundaries.entry(name.to_string()).or_default();
        named.extend(found);
        named.sort_unstable();
        named.dedup();
    }

    /// Moves the whole mesh by `offset` (UL).
    ///
    /// # Errors
    /// An offset that is not finite, or so large that cells degenerate by round-off.
    pub fn translated(mut self, offset: [f64; D]) -> Result<Self, Error> {
        Error::check_finite("offset", &offset)?;
        let offset = Vector::from(offset);
        self.nodes.iter_mut().for_each(|X| *X += offset);
        self.check_cells()?;
        Ok(self)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.len() / Self::CELL_NODES
    }

    /// Never true: a mesh has cells.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Reference coordinates X of all nodes (UL).
    pub fn nodes(&self) -> &[Vector<D>] {
        &self.nodes
    }

    /// The nodes of a cell.
    pub fn cell(&self, k: usize) -> &[usize] {
        &self.cells[k * Self::CELL_NODES..(k + 1) * Self::CELL_NODES]
    }

    /// The cells' nodes in order.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.cells.chunks_exact(Self::CELL_NODES)
    }

    /// Area or volume of a cell (UL²/UL³), positive.
    pub fn volume(&self, cell: usize) -> f64 {
        let corners = self.cell(cell);
        let edges =
            Matrix::<D>::from_fn(|i, j| self.nodes[corners[j + 1]][i] - self.nodes[corners[0]][i]);
        determinant(&edges) / (1..=D).product::<usize>() as f64
    }

    /// Whether the point is inside or on some cell.
    pub fn contains(&self, point: &Vector<D>) -> bool {
        let inside = |cell: &[usize]| {
            let corner = self.nodes[cell[0]];
            let edges = Matrix::<D>::from_fn(|i, j| self.nodes[cell[j + 1]][i] - corner[i]);
            let lambda = inverse_transpose(&edges).transpose() * (point - corner);
            lambda.iter().all(|&l| l >= 0.0) && lambda.sum() <= 1.0
        };
        self.cells().any(inside)
    }

    /// All exterior facets.
    pub fn exterior(&self) -> &[[usize; D]] {
        &self.facets
    }

    /// The names of the boundaries.
    pub fn boundary_names(&self) -> impl Iterator<Item = &str> {
        self.boundaries.keys().map(String::as_str)
    }

    /// The facets of a named boundary.
    ///
    /// # Errors
    /// [`Error::UnknownBoundary`] lists the names there are.
    pub fn boundary(&self, name: &str) -> Result<Vec<[usize; D]>, Error> {
        let indices = self.boundaries.get(name);
        let indices = indices.ok_or_else(|| Error::UnknownBoundary {
            name: name.to_string(),
            known: self.boundaries.keys().cloned().collect(),
        })?;
        Ok(indices.iter().map(|&f| self.facets[f]).collect())
    }

    /// The nodes of a named boundary, each once, ascending.
    ///
    /// # Errors
    /// As [`Mesh::boundary`].
    pub fn boundary_nodes(&self, name: &str) -> Result<Vec<usize>, Error> {
        let mut nodes: Vec<usize> = self.boundary(name)?.into_iter().flatten().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// The nodes of each connected part, ascending; one part for most meshes.
    pub fn parts(&self) -> Vec<Vec<usize>> {
        // each node points to one with a smaller number of its part, or to itself
        let mut parent: Vec<usize> = (0..self.nodes.len()).collect();
        fn root(parent: &mut [usize], mut node: usize) -> usize {
            while parent[node] != node {
                parent[node] = parent[parent[node]];
                node = parent[node];
            }
            node
        }
        for cell in self.cells() {
            for pair in cell.windows(2) {
                let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for node in 0..self.nodes.len() {
            parts.entry(root(&mut parent, node)).or_default().push(node);
        }
        parts.into_values().collect()
    }

    /// The corners (low, high) of the smallest box around all nodes (UL).
    pub fn bounding_box(&self) -> (Vector<D>, Vector<D>) {
        let first = (self.nodes[0], self.nodes[0]);
        let grow = |(low, high): (Vector<D>, Vector<D>), X: &Vector<D>| (low.inf(X), high.sup(X));
        self.nodes.iter().fold(first, grow)
    }
}
