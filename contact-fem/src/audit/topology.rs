//! The bodies of a scene in simplices on their nodes.

use std::collections::BTreeSet;

use super::thickness;
use crate::element::{CELL_EDGES, Order, facet_edge};
use crate::mesh::Mesh;
use crate::model::Scene;
use crate::tensor::Vector;

/// A simplex of a body, by nodes of the scene; the first D + 1 count.
pub(super) struct Cell {
    pub nodes: [usize; 4],
    pub body: usize,
    /// The cell of the body's mesh that it is a part of, or all of.
    pub of: usize,
}

/// A quadratic cell of a body, by nodes of the scene; in the plane the first six count.
pub(super) struct Quadratic {
    pub nodes: [usize; 10],
    pub body: usize,
    /// Its number in the body's mesh.
    pub of: usize,
}

/// A flat piece of a body's exterior.
pub(super) struct Face<const D: usize> {
    pub nodes: [usize; D],
    pub body: usize,
    /// The longest edge in the reference configuration (UL).
    pub size: f64,
    /// The thickness of the material behind it in the reference configuration (UL); `+∞` if it is more than twice
    /// the largest face.
    pub thickness: f64,
    /// The face on the other side of that material.
    pub opposite: Option<usize>,
}

pub(super) struct Topology<const D: usize> {
    pub cells: Vec<Cell>,
    pub quadratic: Vec<Quadratic>,
    pub faces: Vec<Face<D>>,
    /// The edges of all faces, each once.
    pub edges: Vec<[usize; 2]>,
    pub exterior_nodes: Vec<usize>,
    pub body_of: Vec<usize>,
    /// Twice the largest face (UL): a larger thickness is not measured.
    pub thick: f64,
    /// For each node, where the cells around it start in the list after it.
    starts: Vec<usize>,
    cells_around: Vec<usize>,
    /// For each node, mean size of the faces around it and the least thickness there.
    around: Vec<(f64, f64)>,
}

impl<const D: usize> Topology<D> {
    pub fn new(scene: &Scene<D>, X: &[Vector<D>]) -> Self {
        let (mut cells, mut faces, mut body_of) = (Vec::new(), Vec::new(), Vec::new());
        let mut quadratic = Vec::new();
        for (body, mesh) in scene.bodies().iter().map(|body| body.mesh()).enumerate() {
            let first = body_of.len();
            body_of.resize(first + mesh.nodes().len(), body);
            for (of, cell) in mesh.cells().enumerate() {
                let simplices = cell_pieces::<D>(mesh.order());
                cells.extend(simplices.iter().map(|piece| Cell {
                    nodes: piece.map(|k| first + cell[k]),
                    body,
                    of,
                }));
                if mesh.order() == Order::Quadratic {
                    let node = |k: usize| first + cell.get(k).unwrap_or(&cell[0]);
                    let nodes = std::array::from_fn(node);
                    quadratic.push(Quadratic { nodes, body, of });
                }
            }
            for facet in mesh.exterior() {
                faces.extend(
                    facet_pieces::<D>(mesh, facet)
                        .into_iter()
                        .map(|nodes| Face {
                            nodes: nodes.map(|a| first + a),
                            body,
                            size: 0.0,
                            thickness: f64::INFINITY,
                            opposite: None,
                        }),
                );
            }
        }
        for face in &mut faces {
            let pairs = (0..D).flat_map(|i| (0..i).map(move |j| (i, j)));
            let lengths = pairs.map(|(i, j)| (X[face.nodes[i]] - X[face.nodes[j]]).norm());
            face.size = lengths.fold(0.0, f64::max);
        }
        thickness::measure(&mut faces, X);
        let (starts, cells_around) = cells_around::<D>(&cells, X.len());
        let mut around = vec![(0.0, f64::INFINITY, 0_usize); X.len()];
        let (mut exterior_nodes, mut edges) = (BTreeSet::new(), BTreeSet::new());
        for face in &faces {
            for (k, &a) in face.nodes.iter().enumerate() {
                let (size, thickness, count) = around[a];
                around[a] = (size + face.size, face.thickness.min(thickness), count + 1);
                exterior_nodes.insert(a);
                let b = face.nodes[(k + 1) % D];
                edges.insert([a.min(b), a.max(b)]);
            }
        }
        let mean =
            |(size, thickness, count): (f64, f64, usize)| (size / count.max(1) as f64, thickness);
        Topology {
            thick: thickness::far(&faces),
            cells,
            quadratic,
            faces,
            edges: edges.into_iter().collect(),
            exterior_nodes: exterior_nodes.into_iter().collect(),
            body_of,
            starts,
            cells_around,
            around: around.into_iter().map(mean).collect(),
        }
    }

    /// Whether a node is one of `nodes` or shares a cell with one of them.
    pub fn is_near(&self, node: usize, nodes: &[usize]) -> bool {
        let around = &self.cells_around[self.starts[node]..self.starts[node + 1]];
        let own = |cell: &usize| &self.cells[*cell].nodes[..=D];
        nodes.contains(&node)
            || around
                .iter()
                .map(own)
                .any(|own| own.iter().any(|a| nodes.contains(a)))
    }

    /// The mean size of the faces around an exterior node, and the least thickness behind them (UL).
    pub fn around(&self, node: usize) -> (f64, f64) {
        self.around[node]
    }

    /// The least thickness of a body, at most twice the largest face (UL).
    pub fn thinnest(&self) -> f64 {
        let thickness = self.faces.iter().map(|face| face.thickness);
        thickness.fold(self.thick, f64::min)
    }
}

/// For each node, where the cells around it start in the list after it.
fn cells_around<const D: usize>(cells: &[Cell], nodes: usize) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0; nodes + 1];
    let of = |cell: &Cell| cell.nodes.into_iter().take(D + 1);
    cells.iter().flat_map(of).for_each(|a| starts[a + 1] += 1);
    (0..nodes).for_each(|a| starts[a + 1] += starts[a]);
    let (mut next, mut around) = (starts.clone(), vec![0; starts[nodes]]);
    for (k, cell) in cells.iter().enumerate() {
        for a in of(cell) {
            around[next[a]] = k;
            next[a] += 1;
        }
    }
    (starts, around)
}

/// The simplices of a cell, by the cell's own nodes; in the plane the last entry repeats the first.
fn cell_pieces<const D: usize>(order: Order) -> Vec<[usize; 4]> {
    if order == Order::Linear {
        return vec![if D == 2 { [0, 1, 2, 0] } else { [0, 1, 2, 3] }];
    }
    let middle = |a: usize, b: usize| {
        let edge = CELL_EDGES.iter().position(|e| *e == [a, b] || *e == [b, a]);
        D + 1 + edge.unwrap_or_default()
    };
    let corner = |k: usize| {
        let of = |i: usize| if i == k { k } else { middle(k, i) };
        if D == 2 {
            [of(0), of(1), of(2), of(0)]
        } else {
            [of(0), of(1), of(2), of(3)]
        }
    };
    let mut pieces: Vec<_> = (0..=D).map(corner).collect();
    let [ab, bc, ca] = [middle(0, 1), middle(1, 2), middle(2, 0)];
    if D == 2 {
        pieces.push([ab, bc, ca, ab]);
        return pieces;
    }
    // the octahedron of the middles, around the diagonal from ab to cd
    let [ad, bd, cd] = [middle(0, 3), middle(1, 3), middle(2, 3)];
    let ring = [ca, ad, bd, bc];
    pieces.extend((0..4).map(|k| [ab, ring[k], ring[(k + 1) % 4], cd]));
    pieces
}

/// The flat pieces of a facet, by nodes of the mesh, with the facet's orientation.
fn facet_pieces<const D: usize>(mesh: &Mesh<D>, facet: &[usize]) -> Vec<[usize; D]> {
    let piece = |nodes: &[usize]| std::array::from_fn(|k| nodes[k]);
    if mesh.order() == Order::Linear {
        return vec![piece(facet)];
    }
    if D == 2 {
        return vec![piece(&[facet[0], facet[2]]), piece(&[facet[2], facet[1]])];
    }
    let middle = |a: usize, b: usize| {
        let is_it = |e: &usize| matches!(facet_edge::<D>(*e), [p, q] if [p, q] == [a, b] || [p, q] == [b, a]);
        facet[D + (0..3).find(is_it).unwrap_or_default()]
    };
    let [ab, bc, ca] = [middle(0, 1), middle(1, 2), middle(2, 0)];
    let nodes = [
        [facet[0], ab, ca],
        [ab, facet[1], bc],
        [ca, bc, facet[2]],
        [ab, bc, ca],
    ];
    nodes.iter().map(|nodes| piece(nodes)).collect()
}
