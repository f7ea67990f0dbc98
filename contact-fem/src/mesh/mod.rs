//! Simplicial meshes with named boundaries and regions.

mod boundary;
pub mod generators;
mod named;
mod places;
mod quadratic;
pub mod read;
mod refine;
mod revolution;
pub mod write;

use std::collections::BTreeMap;

use crate::element::Order;
use crate::element::cell_rule::degree_5;
use crate::error::Error;
use crate::tensor::{Matrix, Vector, determinant, inverse_transpose};

/// A mesh of simplices in ℝᴰ, linear or quadratic, validated on construction.
///
/// Cells have D + 1 corners in positive orientation (counter-clockwise in the plane). Exterior
/// facets have D corners, with the body to their left (plane) or behind the side from which they
/// run counter-clockwise (space). In a quadratic mesh the corners are followed by the middle nodes
/// of the edges in VTK's order: edges 01, 12, 20 and, of a tetrahedron, 03, 13, 23.
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize> {
    order: Order,
    nodes: Vec<Vector<D>>,
    /// The cells' nodes: flat, [`Order::cell_nodes`] each.
    cells: Vec<usize>,
    /// The exterior facets' nodes: flat, [`Order::facet_nodes`] each.
    facets: Vec<usize>,
    /// The cell of each exterior facet.
    owners: Vec<usize>,
    /// Named sets of exterior facets.
    boundaries: BTreeMap<String, Vec<usize>>,
    /// Named facets between two cells: their corners.
    inner: BTreeMap<String, Vec<[usize; D]>>,
    /// The labels that names have in the file that the mesh is from.
    labels: BTreeMap<String, i32>,
    /// The region in that file.
    region: Option<i32>,
    /// Named sets of cells.
    regions: BTreeMap<String, Vec<usize>>,
    /// Whether it is the half-plane section of a body of revolution.
    is_revolved: bool,
    /// Where the cells are bisected next; empty if none has been so far.
    marks: Vec<refine::Marks>,
}

impl<const D: usize> Mesh<D> {
    /// Whether cells and nodes are those of another mesh.
    pub(crate) fn has_cells_of(&self, other: &Mesh<D>) -> bool {
        self.order == other.order && self.cells == other.cells && self.nodes == other.nodes
    }

    /// The smallest volume of a cell, as a share of the D-th power of its longest edge: smaller
    /// cells are degenerate.
    const DEGENERATE: f64 = 1e-12;
    /// D!, the ratio of the volumes of the unit cube and the unit simplex.
    const FACTORIAL: f64 = if D == 2 { 2.0 } else { 6.0 };

    /// A linear mesh from node coordinates (UL) and cells, D + 1 node numbers each, flat.
    ///
    /// # Errors
    /// If there are no cells, a cell is incomplete, a node is out of range or unused, a coordinate
    /// is not finite, a cell is inverted or degenerate or its volume overflows, or a facet belongs
    /// to more than two cells or to two on the same side.
    pub fn new(nodes: Vec<[f64; D]>, cells: Vec<usize>) -> Result<Self, Error> {
        Self::of_order(Order::Linear, nodes, cells)
    }

    /// A mesh of either order from node coordinates (UL) and the cells' nodes,
    /// [`Order::cell_nodes`] each, flat.
    ///
    /// # Errors
    /// As [`Mesh::new`]; also if two cells do not share the node in the middle of an edge, or the
    /// middle nodes of a cell fold it.
    pub fn of_order(order: Order, nodes: Vec<[f64; D]>, cells: Vec<usize>) -> Result<Self, Error> {
        if cells.is_empty() {
            return Err(Error::EmptyMesh);
        }
        let per_cell = order.cell_nodes::<D>();
        if cells.len() % per_cell != 0 {
            return Err(Error::Setting {
                name: "cells.len()",
                value: cells.len() as f64,
                remedy: "give all nodes of each cell: D + 1 corners and, in a quadratic mesh, a \
                         node for each edge",
            });
        }
        Error::check_finite("node coordinate", nodes.iter().flatten())?;
        let nodes: Vec<Vector<D>> = nodes.into_iter().map(Vector::from).collect();
        let mut used = vec![false; nodes.len()];
        for (k, &node) in cells.iter().enumerate() {
            *used.get_mut(node).ok_or(Error::NodeOutOfRange {
                cell: k / per_cell,
                node,
                nodes: nodes.len(),
            })? = true;
        }
        if let Some(node) = used.iter().position(|u| !u) {
            return Err(Error::OrphanNode { node });
        }
        let (facets, owners, folded) = boundary::exterior_facets::<D>(order, &cells)?;
        let mesh = Mesh {
            order,
            nodes,
            cells,
            facets,
            owners,
            boundaries: BTreeMap::new(),
            inner: BTreeMap::new(),
            labels: BTreeMap::new(),
            region: None,
            regions: BTreeMap::new(),
            is_revolved: false,
            marks: Vec::new(),
        };
        mesh.check_edges()?;
        mesh.check_cells()?;
        if let Some(nodes) = folded {
            let nodes = nodes.to_vec();
            return Err(Error::FoldedCells { nodes });
        }
        Ok(mesh)
    }

    fn check_cells(&self) -> Result<(), Error> {
        for cell in 0..self.len() {
            let volume = self.straight_volume(cell);
            let corners = self.corners(cell);
            let edges = corners.iter().enumerate().flat_map(|(k, &a)| {
                let others = corners[..k].iter();
                others.map(move |&b| length(self.nodes[a] - self.nodes[b]))
            });
            let size = edges.fold(0.0, f64::max);
            let cube = size.powi(D as i32);
            if size > 0.0 && !cube.is_normal() {
                return Err(Error::CellSize { cell, size });
            }
            if !(volume.abs() > Self::DEGENERATE * cube) {
                return Err(Error::DegenerateCell { cell, volume, size });
            }
            if volume < 0.0 {
                return Err(Error::InvertedCell { cell, volume });
            }
            let share = self.least_share(cell);
            if !(share > 0.0) {
                let volume = share * volume;
                return Err(Error::CurvedCell { cell, volume });
            }
        }
        Ok(())
    }

    /// Gives the region `name` those cells whose centre, the mean of the corners, satisfies `contains`; an existing region is extended.
    /// Regions may overlap.
    pub fn name_region(&mut self, name: &str, contains: impl Fn(&Vector<D>) -> bool) {
        let found = (0..self.len()).filter(|&k| contains(&self.centre(k)));
        let found: Vec<usize> = found.collect();
        let named = self.regions.entry(name.to_string()).or_default();
        named.extend(found);
        named.sort_unstable();
        named.dedup();
    }

    /// Moves the whole mesh by `offset` (UL).
    ///
    /// # Errors
    /// If the offset is not finite, or so large that cells degenerate by round-off.
    pub fn translated(self, offset: [f64; D]) -> Result<Self, Error> {
        Error::check_finite("offset", &offset)?;
        let offset = Vector::from(offset);
        self.mapped(|X| X + offset)
    }

    /// Moves every node X to `map(X)` (UL); boundaries keep their names.
    ///
    /// # Errors
    /// [`Error::MappedCell`] if a cell degenerates or is inverted, as by a reflection; also if a
    /// mapped node is not finite.
    pub fn mapped(mut self, map: impl Fn(&Vector<D>) -> Vector<D>) -> Result<Self, Error> {
        self.nodes.iter_mut().for_each(|X| *X = map(X));
        Error::check_finite(
            "mapped coordinate",
            self.nodes.iter().flat_map(|X| X.iter()),
        )?;
        self.check_moved_cells()?;
        Ok(self)
    }

    /// Checks the cells after nodes have moved.
    fn check_moved_cells(&self) -> Result<(), Error> {
        self.check_cells().map_err(|error| match error {
            Error::InvertedCell { cell, volume }
            | Error::DegenerateCell { cell, volume, .. }
            | Error::CurvedCell { cell, volume } => Error::MappedCell { cell, volume },
            other => other,
        })
    }

    /// The order of the cells: linear or quadratic.
    pub fn order(&self) -> Order {
        self.order
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.cells.len() / self.order.cell_nodes::<D>()
    }

    /// Always false: a mesh has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Reference coordinates X of all nodes (UL).
    pub fn nodes(&self) -> &[Vector<D>] {
        &self.nodes
    }

    /// The nodes of a cell.
    pub fn cell(&self, k: usize) -> &[usize] {
        let per_cell = self.order.cell_nodes::<D>();
        &self.cells[k * per_cell..(k + 1) * per_cell]
    }

    /// The corners of a cell.
    pub fn corners(&self, k: usize) -> &[usize] {
        &self.cell(k)[..=D]
    }

    /// The mean of a cell's corners.
    pub(crate) fn centre(&self, k: usize) -> Vector<D> {
        let corners = self.corners(k).iter().map(|&a| self.nodes[a]);
        corners.sum::<Vector<D>>() / (D + 1) as f64
    }

    /// The nodes of each cell, in the order of the cells.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.cells.chunks_exact(self.order.cell_nodes::<D>())
    }

    /// The area or volume of a cell (UL²/UL³), positive; exact for curved cells, too. Of a body of revolution it is that of the
    /// section.
    pub fn volume(&self, cell: usize) -> f64 {
        match self.order {
            Order::Linear => self.straight_volume(cell),
            Order::Quadratic => degree_5::<D>()
                .map(|(weight, xi)| weight * self.jacobian(cell, &xi))
                .sum(),
        }
    }

    /// The signed volume of the simplex between a cell's corners.
    fn straight_volume(&self, cell: usize) -> f64 {
        let corners = self.corners(cell);
        let edges =
            Matrix::<D>::from_fn(|i, j| self.nodes[corners[j + 1]][i] - self.nodes[corners[0]][i]);
        determinant(&edges) / Self::FACTORIAL
    }

    /// Whether the point is in a cell or on its boundary; curved cells are treated as straight.
    pub fn contains(&self, point: &Vector<D>) -> bool {
        self.cells().any(|cell| {
            let lambda = self.barycentric(cell, point);
            lambda.iter().all(|&l| l >= 0.0) && lambda.sum() <= 1.0
        })
    }

    /// The barycentric coordinates λ₁ … λ_D of a point in the simplex of the cell's corners.
    pub(crate) fn barycentric(&self, cell: &[usize], point: &Vector<D>) -> Vector<D> {
        let corner = self.nodes[cell[0]];
        let edges = Matrix::<D>::from_fn(|i, j| self.nodes[cell[j + 1]][i] - corner[i]);
        inverse_transpose(&edges).transpose() * (point - corner)
    }

    /// The nodes of all exterior facets.
    pub fn exterior(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.facets.chunks_exact(self.order.facet_nodes::<D>())
    }

    /// The cell of each exterior facet.
    pub fn exterior_cells(&self) -> &[usize] {
        &self.owners
    }

    fn facet(&self, f: usize) -> &[usize] {
        let per_facet = self.order.facet_nodes::<D>();
        &self.facets[f * per_facet..(f + 1) * per_facet]
    }

    /// The names of the boundaries.
    pub fn boundary_names(&self) -> impl Iterator<Item = &str> {
        self.boundaries.keys().map(String::as_str)
    }

    /// The nodes of the facets of a named boundary.
    ///
    /// # Errors
    /// [`Error::UnknownBoundary`], which lists the existing names.
    pub fn boundary(&self, name: &str) -> Result<Vec<&[usize]>, Error> {
        let indices = self.boundaries.get(name);
        let indices = indices.ok_or_else(|| Error::UnknownBoundary {
            name: name.to_string(),
            known: self.boundaries.keys().cloned().collect(),
        })?;
        Ok(indices.iter().map(|&f| self.facet(f)).collect())
    }

    /// The names that a file gives to facets between two cells, with the corners of those facets, such as those
    /// of a line inside a region. Nothing acts on them.
    pub fn inner_facets(&self) -> impl Iterator<Item = (&str, &[[usize; D]])> {
        let inner = self.inner.iter();
        inner.map(|(name, facets)| (name.as_str(), facets.as_slice()))
    }

    /// The region that the mesh has in its file: a label of cells, or the number of a physical group.
    pub fn region(&self) -> Option<i32> {
        self.region
    }

    /// The names of the regions, which are sets of cells.
    pub fn region_names(&self) -> impl Iterator<Item = &str> {
        self.regions.keys().map(String::as_str)
    }

    /// The cells of a named region, ascending.
    ///
    /// # Errors
    /// [`Error::UnknownRegion`], which lists the existing names.
    pub fn region_cells(&self, name: &str) -> Result<&[usize], Error> {
        let cells = self.regions.get(name).map(Vec::as_slice);
        cells.ok_or_else(|| Error::UnknownRegion {
            name: name.to_string(),
            known: self.regions.keys().cloned().collect(),
        })
    }

    /// The nodes of a named boundary, each once, ascending.
    ///
    /// # Errors
    /// As [`Mesh::boundary`].
    pub fn boundary_nodes(&self, name: &str) -> Result<Vec<usize>, Error> {
        let mut nodes: Vec<usize> = self.boundary(name)?.concat();
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// The nodes of each connected part, ascending; most meshes have one part.
    pub fn parts(&self) -> Vec<Vec<usize>> {
        // each node points to itself or to a node of its part with a smaller number
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

/// |v| without overflow or underflow of the squares.
fn length<const D: usize>(v: Vector<D>) -> f64 {
    let largest = v.amax();
    match largest > 0.0 && largest.is_finite() {
        true => largest * (v / largest).norm(),
        false => largest,
    }
}
