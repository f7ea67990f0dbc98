//! The bodies of a scene in simplices on their nodes.

use std::collections::BTreeSet;

use super::{sag, thickness};
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
    /// How many pieces a facet has; those of a facet follow each other.
    pub pieces: usize,
    /// The longest edge in the reference configuration (UL).
    pub size: f64,
    /// How far it is from a round surface of which it and its neighbours are chords (UL).
    pub sag: f64,
    /// The thickness of the material behind it in the reference configuration (UL); `+∞` if it is more than twice
    /// the largest face.
    pub thickness: f64,
    /// The face on the other side of that material.
    pub opposite: Option<usize>,
}

/// Neighbouring simplices of a body.
pub(super) struct Block {
    /// Their nodes, each once.
    pub nodes: Vec<usize>,
    pub cells: Vec<usize>,
}

pub(super) struct Topology<const D: usize> {
    pub cells: Vec<Cell>,
    /// All of them again, by neighbourhood.
    pub blocks: Vec<Block>,
    pub quadratic: Vec<Quadratic>,
    pub faces: Vec<Face<D>>,
    /// The edges of all faces, each once.
    pub edges: Vec<[usize; 2]>,
    pub exterior_nodes: Vec<usize>,
    pub body_of: Vec<usize>,
    /// Twice the largest face (UL): a larger thickness is not measured.
    pub thick: f64,
    /// For each exterior node, it and those that share a cell with it.
    neighbours: Vec<Vec<usize>>,
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
            // inside, a body of revolution meets itself on the axis
            let is_axis = |facet: &&[usize]| {
                let mut nodes = facet.iter();
                mesh.is_of_revolution() && nodes.all(|&a| mesh.nodes()[a][0] == 0.0)
            };
            for facet in mesh.exterior().filter(|facet| !is_axis(facet)) {
                let pieces = facet_pieces::<D>(mesh, facet);
                let count = pieces.len();
                faces.extend(pieces.into_iter().map(|nodes| Face {
                    nodes: nodes.map(|a| first + a),
                    body,
                    pieces: count,
                    size: 0.0,
                    sag: 0.0,
                    thickness: f64::INFINITY,
                    opposite: None,
                }));
            }
        }
        for face in &mut faces {
            let pairs = (0..D).flat_map(|i| (0..i).map(move |j| (i, j)));
            let lengths = pairs.map(|(i, j)| (X[face.nodes[i]] - X[face.nodes[j]]).norm());
            face.size = lengths.fold(0.0, f64::max);
        }
        thickness::measure(&mut faces, X);
        sag::measure(&mut faces, X);
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
        let mut neighbours = vec![Vec::new(); X.len()];
        for cell in &cells {
            let nodes = &cell.nodes[..=D];
            let exterior = nodes.iter().filter(|a| around[**a].2 > 0);
            exterior.for_each(|&a| neighbours[a].extend(nodes));
        }
        for nodes in &mut neighbours {
            nodes.sort_unstable();
            nodes.dedup();
        }
        let mean =
            |(size, thickness, count): (f64, f64, usize)| (size / count.max(1) as f64, thickness);
        Topology {
            thick: thickness::far(&faces),
            blocks: blocks(&cells, X),
            cells,
            quadratic,
            neighbours,
            faces,
            edges: edges.into_iter().collect(),
            exterior_nodes: exterior_nodes.into_iter().collect(),
            body_of,
            around: around.into_iter().map(mean).collect(),
        }
    }

    /// Whether an exterior node is one of `nodes` or shares a cell with one of them.
    pub fn is_near(&self, node: usize, nodes: &[usize]) -> bool {
        let neighbours = &self.neighbours[node];
        nodes.iter().any(|a| neighbours.contains(a))
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

/// The simplices in blocks of [`BLOCK`] at most, body by body along a curve that stays near.
fn blocks<const D: usize>(cells: &[Cell], X: &[Vector<D>]) -> Vec<Block> {
    let endless = Vector::<D>::repeat(f64::INFINITY);
    let low = X.iter().fold(endless, |low, x| low.inf(x));
    let high = X.iter().fold(-endless, |high, x| high.sup(x));
    let side = (high - low).max();
    // Morton's curve: the bits of the coordinates in turn
    let place = |cell: &Cell| -> u64 {
        let x = (X[cell.nodes[0]] - low) * (f64::from(1 << BITS) / side);
        let bit = |b: u32| x.iter().fold(0, |bits, x| bits << 1 | (*x as u64 >> b & 1));
        (0..BITS).rev().fold(0, |place, b| place << D | bit(b))
    };
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by_cached_key(|&k| (cells[k].body, place(&cells[k])));
    let of_bodies = order.chunk_by(|&a, &b| cells[a].body == cells[b].body);
    let parts = of_bodies.flat_map(|own| own.chunks(BLOCK));
    let block = |own: &[usize]| {
        let nodes = own.iter().flat_map(|&k| &cells[k].nodes[..=D]);
        let mut nodes: Vec<usize> = nodes.copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let cells = own.to_vec();
        Block { nodes, cells }
    };
    parts.map(block).collect()
}

/// The largest number of simplices in a block.
const BLOCK: usize = 32;
/// The bits of each coordinate along Morton's curve.
const BITS: u32 = 16;

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
