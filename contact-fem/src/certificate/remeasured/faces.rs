//! The facets of one side of a pair, from the mesh alone, and where they are.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::boxes::Sorted;
use crate::element::Order;
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector};

/// The largest number of nodes of a facet.
pub(super) const MOST: usize = 6;

/// The facets of a boundary, and their reference positions.
pub(super) struct Faces<const D: usize> {
    pub body: usize,
    order: Order,
    is_revolved: bool,
    /// The scene's numbers of the nodes, ascending.
    pub nodes: Vec<usize>,
    /// The nodes of all facets, by position in `nodes`.
    facets: Vec<usize>,
    X: Vec<Vector<D>>,
    N: Vec<Vector<D>>,
    /// For each facet and corner, whether the side opposite the corner has no other facet.
    rim: Vec<[bool; D]>,
    /// For each node, whether it is a corner at the end of the boundary.
    is_end: Vec<bool>,
    /// The length of each facet at X (UL).
    sizes: Vec<f64>,
    /// For each node the mean length of the facets around it (UL).
    lengths: Vec<f64>,
}

/// The nodes of one facet with a vector each, which are interpolated by own shape functions.
#[derive(Clone, Copy)]
pub(super) struct Patch<const D: usize> {
    order: Order,
    values: [Vector<D>; MOST],
}

/// N_a(λ) of a facet.
pub(super) fn shapes<const D: usize>(order: Order, lambda: &Vector<D>) -> [f64; MOST] {
    let mut N = [0.0; MOST];
    for k in 0..D {
        N[k] = match order {
            Order::Linear => lambda[k],
            Order::Quadratic => lambda[k] * (2.0 * lambda[k] - 1.0),
        };
    }
    if order == Order::Quadratic {
        for e in 0..D * (D - 1) / 2 {
            N[D + e] = 4.0 * lambda[e] * lambda[(e + 1) % D];
        }
    }
    N
}

/// The slopes of N_a along λ_k, while λ_0 falls.
pub(super) fn shape_slopes<const D: usize>(
    order: Order,
    lambda: &Vector<D>,
    k: usize,
) -> [f64; MOST] {
    let rate = |j: usize| match j {
        0 => -1.0,
        _ if j == k => 1.0,
        _ => 0.0,
    };
    let mut slopes = [0.0; MOST];
    for j in 0..D {
        slopes[j] = match order {
            Order::Linear => rate(j),
            Order::Quadratic => rate(j) * (4.0 * lambda[j] - 1.0),
        };
    }
    if order == Order::Quadratic {
        for e in 0..D * (D - 1) / 2 {
            let next = (e + 1) % D;
            slopes[D + e] = 4.0 * (rate(e) * lambda[next] + rate(next) * lambda[e]);
        }
    }
    slopes
}

impl<const D: usize> Patch<D> {
    /// The value at λ.
    pub fn at(&self, lambda: &Vector<D>) -> Vector<D> {
        match self.order {
            Order::Linear => self.sum(lambda.as_slice()),
            Order::Quadratic => self.sum(&shapes(self.order, lambda)),
        }
    }

    /// Its slope along λ_k, while λ_0 falls.
    pub fn slope(&self, lambda: &Vector<D>, k: usize) -> Vector<D> {
        match self.order {
            Order::Linear => self.values[k] - self.values[0],
            Order::Quadratic => self.sum(&shape_slopes(self.order, lambda, k)),
        }
    }

    /// The sum of the values of the first nodes with these weights.
    fn sum(&self, weights: &[f64]) -> Vector<D> {
        let mut sum = Vector::zeros();
        for (own, weight) in self.values.iter().zip(weights) {
            for i in 0..D {
                sum[i] += own[i] * weight;
            }
        }
        sum
    }

    /// The normal of positions at λ, as long as the facet's measure is large.
    pub fn normal(&self, lambda: &Vector<D>) -> Vector<D> {
        let first = self.slope(lambda, 1);
        let mut normal = Vector::zeros();
        if D == 2 {
            (normal[0], normal[1]) = (first[1], -first[0]);
            return normal;
        }
        let second = self.slope(lambda, 2);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            normal[i] = 0.5 * (first[j] * second[k] - first[k] * second[j]);
        }
        normal
    }

    /// The angle between the sides at corner `k`.
    fn angle(&self, lambda: &Vector<D>, k: usize) -> f64 {
        let toward = |other: usize| {
            let along = |j: usize| match j {
                0 => Vector::zeros(),
                _ => self.slope(lambda, j),
            };
            along(other) - along(k)
        };
        let (a, b) = (toward((k + 1) % D), toward((k + 2) % D));
        (2.0 * self.normal(lambda).norm()).atan2(a.dot(&b))
    }
}

/// λ of a facet's k-th node.
pub(super) fn place<const D: usize>(k: usize) -> Vector<D> {
    let mut lambda = Vector::zeros();
    match k < D {
        true => lambda[k] = 1.0,
        false => (lambda[k - D], lambda[(k - D + 1) % D]) = (0.5, 0.5),
    }
    lambda
}

/// The flat pieces between the nodes of a facet, by the numbers of their corners among these.
fn pieces<const D: usize>(order: Order) -> Vec<[usize; D]> {
    let all: &[[usize; 3]] = match (order, D) {
        (Order::Linear, _) => &[[0, 1, 2]],
        (Order::Quadratic, 2) => &[[0, 2, 0], [2, 1, 0]],
        _ => &[[0, 3, 5], [1, 4, 3], [2, 5, 4], [3, 4, 5]],
    };
    let own = |piece: &[usize; 3]| std::array::from_fn(|k| piece[k]);
    all.iter().map(own).collect()
}

/// λ in the middle of a facet.
pub(super) fn middle<const D: usize>() -> Vector<D> {
    Vector::repeat(1.0 / D as f64)
}

/// For each facet and corner, whether no other facet has the side opposite the corner. Sides on the axis of a body of revolution
/// go on beyond it.
fn rim<const D: usize>(facets: &[&[usize]], is_on_axis: impl Fn(usize) -> bool) -> Vec<[bool; D]> {
    let side = |facet: &[usize], k: usize| {
        let mut side: Vec<usize> = (0..D).filter(|&c| c != k).map(|c| facet[c]).collect();
        side.sort_unstable();
        side
    };
    let mut sharers: HashMap<Vec<usize>, usize> = HashMap::new();
    for facet in facets {
        (0..D).for_each(|k| *sharers.entry(side(facet, k)).or_default() += 1);
    }
    let is_rim = |facet: &[usize], k: usize| {
        let side = side(facet, k);
        sharers[&side] == 1 && !side.iter().all(|&a| is_on_axis(a))
    };
    let of_facet = |facet: &&[usize]| std::array::from_fn(|k| is_rim(facet, k));
    facets.iter().map(of_facet).collect()
}

impl<const D: usize> Faces<D> {
    /// A boundary of a body's mesh, whose nodes follow those of the bodies before; `None` if there is no such boundary.
    pub fn new(mesh: &Mesh<D>, (body, first): (usize, usize), boundary: &str) -> Option<Self> {
        let facets = mesh.boundary(boundary).ok()?;
        let mut own: Vec<usize> = facets
            .iter()
            .flat_map(|facet| facet.iter().copied())
            .collect();
        own.sort_unstable();
        own.dedup();
        let place_of = |a: &usize| own.binary_search(a).unwrap_or_default();
        let is_revolved = mesh.is_of_revolution();
        let is_on_axis = |a: usize| is_revolved && mesh.nodes()[a][0] == 0.0;
        let mut faces = Faces {
            body,
            order: mesh.order(),
            is_revolved,
            facets: facets
                .iter()
                .flat_map(|facet| facet.iter().map(place_of))
                .collect(),
            X: own.iter().map(|&a| mesh.nodes()[a]).collect(),
            N: Vec::new(),
            rim: rim(&facets, is_on_axis),
            nodes: own.iter().map(|a| a + first).collect(),
            is_end: vec![false; own.len()],
            sizes: Vec::new(),
            lengths: Vec::new(),
        };
        for f in 0..faces.len() {
            for k in (0..D).filter(|&k| faces.rim[f][k]) {
                let corners = (0..D).filter(|&c| c != k).map(|c| faces.facet(f)[c]);
                let corners: Vec<usize> = corners.collect();
                corners.into_iter().for_each(|a| faces.is_end[a] = true);
            }
        }
        faces.N = faces.averaged(&faces.X, |_| true);
        let measure = |f: usize| faces.patch(f, &faces.X).normal(&middle()).norm();
        let sizes = (0..faces.len()).map(|f| measure(f).powf(1.0 / (D as f64 - 1.0)));
        faces.sizes = sizes.collect();
        faces.lengths = faces.node_sizes();
        Some(faces)
    }

    pub fn len(&self) -> usize {
        self.rim.len()
    }

    pub fn order(&self) -> Order {
        self.order
    }

    /// The nodes of a facet, by position in `nodes`.
    pub fn facet(&self, f: usize) -> &[usize] {
        let count = self.order.facet_nodes::<D>();
        &self.facets[f * count..(f + 1) * count]
    }

    /// The nodes of a facet with a test function.
    pub fn tests(&self, f: usize) -> &[usize] {
        &self.facet(f)[..self.test_order().facet_nodes::<D>()]
    }

    fn test_order(&self) -> Order {
        match D == 2 && !self.is_revolved {
            true => self.order,
            false => Order::Linear,
        }
    }

    /// φ_i(λ) of the nodes [`Faces::tests`].
    pub fn test_values(&self, lambda: &Vector<D>) -> [f64; MOST] {
        shapes(self.test_order(), lambda)
    }

    /// Values of the nodes of a facet, from those of all nodes of the boundary.
    pub fn patch(&self, f: usize, of: &[Vector<D>]) -> Patch<D> {
        let mut values = [Vector::zeros(); MOST];
        let own = self.facet(f).iter();
        values
            .iter_mut()
            .zip(own)
            .for_each(|(value, &a)| *value = of[a]);
        Patch {
            order: self.order,
            values,
        }
    }

    /// The reference positions, and the averaged normals there, of a facet's nodes.
    pub fn reference(&self, f: usize) -> [Patch<D>; 2] {
        [self.patch(f, &self.X), self.patch(f, &self.N)]
    }

    /// The reference measure at λ (UL in the plane, UL² in space and of revolution), which quadrature weights multiply.
    pub fn measure(&self, f: usize, lambda: &Vector<D>) -> f64 {
        let patch = self.patch(f, &self.X);
        let ring = match self.is_revolved {
            true => TAU * patch.at(lambda)[0],
            false => 1.0,
        };
        ring * patch.normal(lambda).norm()
    }

    /// Whether the side opposite corner `k` is at the end of the boundary.
    pub fn is_rim(&self, f: usize, k: usize) -> bool {
        self.rim[f][k]
    }

    /// How far λ is inside the end of the boundary, as a share of a facet: linear between the corners of a facet, the middles of its
    /// sides and its centre, of which those at the end are 0 and the others 1.
    pub fn depth(&self, f: usize, lambda: &Vector<D>) -> f64 {
        let mut order: [usize; D] = std::array::from_fn(|k| k);
        order.sort_by(|&a, &b| lambda[b].total_cmp(&lambda[a]));
        let of = |is_end: bool| if is_end { 0.0 } else { 1.0 };
        let corner = of(self.is_end[self.facet(f)[order[0]]]);
        let sorted = order.map(|k| lambda[k]);
        match D {
            2 => (sorted[0] - sorted[1]) * corner + 2.0 * sorted[1],
            _ => {
                let side = of(self.rim[f][order[2]]);
                let (first, second) = (sorted[0] - sorted[1], sorted[1] - sorted[2]);
                first * corner + 2.0 * second * side + 3.0 * sorted[2]
            }
        }
    }

    /// The length of a facet (UL).
    pub fn length(&self, f: usize) -> f64 {
        self.sizes[f]
    }

    /// The length of the facets around λ (UL), linear between the corners of a facet.
    pub fn length_at(&self, f: usize, lambda: &Vector<D>) -> f64 {
        let corners = self.facet(f)[..D].iter().zip(lambda.iter());
        corners.map(|(&a, l)| l * self.lengths[a]).sum()
    }

    /// The mean length of the facets (UL).
    pub fn size(&self) -> f64 {
        self.sizes.iter().sum::<f64>() / self.len().max(1) as f64
    }

    /// For each node the mean length of the facets around it (UL).
    pub fn node_sizes(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.nodes.len()];
        for (f, size) in self.sizes.iter().enumerate() {
            for &a in self.facet(f) {
                sums[a] = (sums[a].0 + size, sums[a].1 + 1.0);
            }
        }
        sums.iter().map(|(sum, count)| sum / count).collect()
    }

    /// The averaged unit normals of the nodes that are needed, where the boundary's nodes are at `x`: directions of [`Faces::normal_sums`].
    /// Normals of other nodes are zero.
    fn averaged(&self, x: &[Vector<D>], is_needed: impl Fn(usize) -> bool) -> Vec<Vector<D>> {
        let sums = self.normal_sums(x, is_needed);
        let unit = |sum: Vector<D>| {
            let norm = sum.norm();
            sum / if norm > 0.0 { norm } else { 1.0 }
        };
        sums.into_iter().map(unit).collect()
    }

    /// The sum of the unit normals of the facets around each node that is needed, in space weighted by the facets' angles there.
    pub fn normal_sums(
        &self,
        x: &[Vector<D>],
        is_needed: impl Fn(usize) -> bool,
    ) -> Vec<Vector<D>> {
        let mut sums = vec![Vector::<D>::zeros(); x.len()];
        for f in 0..self.len() {
            let own = self.facet(f);
            if !own.iter().any(|&a| is_needed(a)) {
                continue;
            }
            let patch = self.patch(f, x);
            for (k, &a) in own.iter().enumerate().filter(|(_, a)| is_needed(**a)) {
                sums[a] += self.permitted(a, weighted_normal(&patch, k));
            }
        }
        sums
    }

    /// A normal of a facet as the averaged one at a node takes it: along the axis of a body of revolution if the node is there.
    fn permitted(&self, a: usize, mut normal: Vector<D>) -> Vector<D> {
        if self.is_revolved && self.X[a][0] == 0.0 {
            normal[0] = 0.0;
        }
        normal
    }

    /// The facets around each node.
    pub fn around(&self) -> Vec<Vec<usize>> {
        let mut around = vec![Vec::new(); self.nodes.len()];
        for f in 0..self.len() {
            self.facet(f).iter().for_each(|&a| around[a].push(f));
        }
        around
    }

    /// How the part of a facet in the sum of normals at its k-th node changes with component i of its j-th node, by differences over a step,
    /// for each j, i and k in this order (1/UL).
    pub fn normal_rates(&self, f: usize, x: &[Vector<D>], step: f64) -> Vec<Vector<D>> {
        let own = self.facet(f);
        let here = self.patch(f, x);
        let part = |patch: &Patch<D>, k: usize| self.permitted(own[k], weighted_normal(patch, k));
        let before: Vec<Vector<D>> = (0..own.len()).map(|k| part(&here, k)).collect();
        let mut rates = Vec::with_capacity(D * own.len() * own.len());
        for j in 0..own.len() {
            for i in 0..D {
                let mut moved = here;
                moved.values[j][i] += step;
                let change = |(k, before): (usize, &Vector<D>)| (part(&moved, k) - before) / step;
                rates.extend(before.iter().enumerate().map(change));
            }
        }
        rates
    }
}

/// The unit normal at a facet's k-th node, in space times the angle there.
fn weighted_normal<const D: usize>(patch: &Patch<D>, k: usize) -> Vector<D> {
    let lambda = place(k);
    let angle = match D == 3 && k < D {
        true => patch.angle(&lambda, k),
        false => 1.0,
    };
    let normal = patch.normal(&lambda);
    normal * (angle / normal.norm())
}

/// A boundary where its nodes are.
pub(super) struct Placed<'a, const D: usize> {
    pub faces: &'a Faces<D>,
    pub x: Vec<Vector<D>>,
    normals: Vec<Vector<D>>,
    /// The boxes of the flat pieces between the nodes of each facet.
    pub boxes: Sorted<D>,
    pieces: Vec<[usize; D]>,
    /// The boxes around the pieces of each facet.
    around_pieces: Vec<[Vector<D>; 2]>,
}

/// A flat piece between nodes of a facet.
pub(super) struct Piece<const D: usize> {
    /// The numbers of its corners among the facet's nodes.
    pub nodes: [usize; D],
    pub corners: [Vector<D>; D],
}

impl<'a, const D: usize> Placed<'a, D> {
    /// At positions `x` of all nodes of the scene, for searches.
    pub fn new(faces: &'a Faces<D>, x: &[Vector<D>]) -> Self {
        let mut placed = Self::unsorted(faces, x, |_| true);
        let x = &placed.x;
        let around = |f: usize| {
            let own = faces.facet(f);
            let low = own.iter().fold(x[own[0]], |low, &a| low.inf(&x[a]));
            let high = own.iter().fold(x[own[0]], |high, &a| high.sup(&x[a]));
            [low, high]
        };
        let boxes = Sorted::new((0..faces.len()).map(around));
        let pieces = pieces(faces.order);
        let of_facet = |f: usize| {
            let own = faces.facet(f);
            let corners = pieces.iter().map(move |piece| piece.map(|k| x[own[k]]));
            corners.map(|corners| {
                let others = corners[1..].iter();
                others.fold([corners[0]; 2], |[low, high], y| [low.inf(y), high.sup(y)])
            })
        };
        let around_pieces = (0..faces.len()).flat_map(of_facet).collect();
        (placed.boxes, placed.pieces, placed.around_pieces) = (boxes, pieces, around_pieces);
        placed
    }

    /// The flat pieces of a facet, each with the box around it.
    pub fn pieces(&self, f: usize) -> impl Iterator<Item = (&[Vector<D>; 2], Piece<D>)> {
        let count = self.pieces.len();
        let boxes = self.around_pieces[f * count..(f + 1) * count].iter();
        let own = self.faces.facet(f);
        let piece = move |&nodes: &[usize; D]| Piece {
            nodes,
            corners: nodes.map(|k| self.x[own[k]]),
        };
        boxes.zip(self.pieces.iter().map(piece))
    }

    /// The same without boxes, for points that know the facets of their feet, and with normals at the nodes that are needed alone.
    pub fn unsorted(
        faces: &'a Faces<D>,
        x: &[Vector<D>],
        is_needed: impl Fn(usize) -> bool,
    ) -> Self {
        let x: Vec<Vector<D>> = faces.nodes.iter().map(|&a| x[a]).collect();
        Placed {
            faces,
            normals: faces.averaged(&x, is_needed),
            x,
            boxes: Sorted::new(std::iter::empty()),
            pieces: Vec::new(),
            around_pieces: Vec::new(),
        }
    }

    /// Positions and normals of the nodes of a facet.
    pub fn patches(&self, f: usize) -> [Patch<D>; 2] {
        [
            self.faces.patch(f, &self.x),
            self.faces.patch(f, &self.normals),
        ]
    }
}

/// ∂(x̄ + s m)/∂(λ_1, …, s) at λ and s, as columns.
pub(super) fn swept<const D: usize>(
    [places, normals]: &[Patch<D>; 2],
    lambda: &Vector<D>,
    s: f64,
) -> Matrix<D> {
    let mut columns = Matrix::<D>::zeros();
    for k in 1..D {
        let column = match places.order {
            Order::Linear => places.slope(lambda, k) + normals.slope(lambda, k) * s,
            Order::Quadratic => {
                let weights = shape_slopes(places.order, lambda, k);
                places.sum(&weights) + normals.sum(&weights) * s
            }
        };
        columns.set_column(k - 1, &column);
    }
    columns.set_column(D - 1, &normals.at(lambda));
    columns
}
