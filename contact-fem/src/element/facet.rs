//! Facets — segments and triangles, flat or curved — in barycentric coordinates λ ∈ ℝᴰ, Σλ = 1.

use crate::tensor::{Matrix, Vector, facet_normal};

/// The polynomial degree of an element's shape functions and geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Order {
    /// P1: nodes at the corners.
    #[default]
    Linear,
    /// P2: nodes also at the middles of the edges; cells and facets may be curved.
    Quadratic,
}

/// The largest number of nodes of a facet: that of a quadratic triangle.
pub const MAX_FACET_NODES: usize = 6;

/// One number for each node of a facet; unused entries are 0.
pub type FacetShapes = [f64; MAX_FACET_NODES];

impl Order {
    /// The degree as a number.
    pub const fn degree(self) -> usize {
        match self {
            Order::Linear => 1,
            Order::Quadratic => 2,
        }
    }

    /// The number of nodes of a facet in ℝᴰ.
    pub const fn facet_nodes<const D: usize>(self) -> usize {
        match self {
            Order::Linear => D,
            Order::Quadratic => D + D * (D - 1) / 2,
        }
    }

    /// The number of nodes of a cell in ℝᴰ.
    pub const fn cell_nodes<const D: usize>(self) -> usize {
        match self {
            Order::Linear => D + 1,
            Order::Quadratic => D + 1 + D * (D + 1) / 2,
        }
    }
}

/// The corners of a facet's edge `e`, in the order of the quadratic facet's middle nodes.
pub const fn facet_edge<const D: usize>(e: usize) -> [usize; 2] {
    [e, (e + 1) % D]
}

/// N_a(λ) of a facet.
pub fn facet_shapes<const D: usize>(order: Order, lambda: &Vector<D>) -> FacetShapes {
    let mut N = [0.0; MAX_FACET_NODES];
    match order {
        Order::Linear => N[..D].copy_from_slice(lambda.as_slice()),
        Order::Quadratic => {
            for a in 0..D {
                N[a] = lambda[a] * (2.0 * lambda[a] - 1.0);
            }
            for e in 0..D * (D - 1) / 2 {
                let [a, b] = facet_edge::<D>(e);
                N[D + e] = 4.0 * lambda[a] * lambda[b];
            }
        }
    }
    N
}

/// ∂N_a/∂λ_k of a facet for each k, with all λ independent.
pub fn facet_slopes<const D: usize>(order: Order, lambda: &Vector<D>) -> [FacetShapes; D] {
    let mut slopes = [[0.0; MAX_FACET_NODES]; D];
    for k in 0..D {
        slopes[k][k] = match order {
            Order::Linear => 1.0,
            Order::Quadratic => 4.0 * lambda[k] - 1.0,
        };
    }
    if order == Order::Quadratic {
        for e in 0..D * (D - 1) / 2 {
            let [a, b] = facet_edge::<D>(e);
            slopes[a][D + e] = 4.0 * lambda[b];
            slopes[b][D + e] = 4.0 * lambda[a];
        }
    }
    slopes
}

/// A facet with the positions of its nodes: the corners, then the middles of the edges.
#[derive(Clone, Copy, Debug)]
pub struct Facet<const D: usize> {
    order: Order,
    is_flat: bool,
    x: [Vector<D>; MAX_FACET_NODES],
}

impl<const D: usize> Facet<D> {
    /// The facet with these nodes, selected from the positions `x`.
    pub fn gather(order: Order, nodes: &[usize], x: &[Vector<D>]) -> Self {
        let mut facet = Facet {
            order,
            is_flat: true,
            x: [Vector::zeros(); MAX_FACET_NODES],
        };
        for (own, &a) in facet.x.iter_mut().zip(nodes) {
            *own = x[a];
        }
        facet.is_flat = facet.has_middles();
        facet
    }

    /// Whether the middle nodes are half-way between the corners, up to the round-off of their
    /// coordinates.
    fn has_middles(&self) -> bool {
        let (corners, middles) = self.nodes().split_at(D);
        let largest = corners.iter().fold(0.0, |m: f64, x| m.max(x.amax()));
        middles.iter().enumerate().all(|(e, middle)| {
            let [a, b] = facet_edge::<D>(e).map(|k| corners[k]);
            (middle - (a + b) * 0.5).amax() <= 4.0 * f64::EPSILON * largest
        })
    }

    /// Whether x(λ) is the linear interpolation of the corners: true for linear facets, and for
    /// quadratic ones with their middle nodes half-way between the corners.
    pub fn is_flat(&self) -> bool {
        self.is_flat
    }

    /// The degree.
    pub fn order(&self) -> Order {
        self.order
    }

    /// The positions of its nodes (UL).
    pub fn nodes(&self) -> &[Vector<D>] {
        &self.x[..self.order.facet_nodes::<D>()]
    }

    /// The positions of its corners (UL).
    pub fn corners(&self) -> [Vector<D>; D] {
        std::array::from_fn(|k| self.x[k])
    }

    /// x(λ) = Σ N_a(λ) x_a.
    pub fn point(&self, lambda: &Vector<D>) -> Vector<D> {
        let mut point = Vector::<D>::zeros();
        for (N, x) in facet_shapes(self.order, lambda).iter().zip(self.nodes()) {
            point.axpy(*N, x, 1.0);
        }
        point
    }

    /// The corners of the tangent facet at λ, the flat facet with the same point and derivatives
    /// there: x(λ) + Σ_j (δ_jk − λ_j) ∂x/∂λ_j. A linear facet is its own tangent facet.
    pub fn tangent(&self, lambda: &Vector<D>) -> [Vector<D>; D] {
        if self.order == Order::Linear {
            return self.corners();
        }
        let mut slopes: [Vector<D>; D] =
            std::array::from_fn(|a| self.x[a] * (4.0 * lambda[a] - 1.0));
        for e in 0..D * (D - 1) / 2 {
            let [a, b] = facet_edge::<D>(e);
            slopes[a].axpy(4.0 * lambda[b], &self.x[D + e], 1.0);
            slopes[b].axpy(4.0 * lambda[a], &self.x[D + e], 1.0);
        }
        let mut base = self.point(lambda);
        for (slope, l) in slopes.iter().zip(lambda.iter()) {
            base.axpy(-l, slope, 1.0);
        }
        slopes.map(|slope| base + slope)
    }

    /// r·∂²x/∂λ_i∂λ_j, constant over the facet.
    pub fn curvature(&self, r: &Vector<D>) -> Matrix<D> {
        let mut curvature = Matrix::zeros();
        if self.order == Order::Quadratic {
            for a in 0..D {
                curvature[(a, a)] = 4.0 * r.dot(&self.x[a]);
            }
            for e in 0..D * (D - 1) / 2 {
                let [a, b] = facet_edge::<D>(e);
                curvature[(a, b)] = 4.0 * r.dot(&self.x[D + e]);
                curvature[(b, a)] = curvature[(a, b)];
            }
        }
        curvature
    }

    /// The outward normal at λ; its length is the measure of the tangent facet, so that
    /// ∫ f ds = Σ w f |normal| with weights that sum to 1.
    pub fn normal(&self, lambda: &Vector<D>) -> Vector<D> {
        facet_normal(&self.tangent(lambda))
    }

    /// The corners (low, high) of a bounding box: that of the facet's Bézier points.
    pub fn bounding_box(&self) -> (Vector<D>, Vector<D>) {
        let mut points = self.x;
        if self.order == Order::Quadratic {
            for e in 0..D * (D - 1) / 2 {
                let [a, b] = facet_edge::<D>(e);
                points[D + e] = self.x[D + e] * 2.0 - (self.x[a] + self.x[b]) * 0.5;
            }
        }
        let points = &points[..self.nodes().len()];
        let grow = |(low, high): (Vector<D>, Vector<D>), x: &Vector<D>| (low.inf(x), high.sup(x));
        points.iter().fold((points[0], points[0]), grow)
    }

    /// A bound on |x(λ) − Σ λ_k x_k|, the distance from the flat facet between the corners (UL): the
    /// difference is Σ 4 λ_a λ_b d over the edges ab, d the offsets of their middle nodes, and
    /// Σ 4 λ_a λ_b is at most 1 on a segment and 4/3 on a triangle.
    pub fn bulge(&self) -> f64 {
        if self.is_flat {
            return 0.0;
        }
        let (corners, middles) = self.nodes().split_at(D);
        let offset = |(e, middle): (usize, &Vector<D>)| {
            let [a, b] = facet_edge::<D>(e).map(|k| corners[k]);
            (middle - (a + b) * 0.5).norm()
        };
        let largest = middles.iter().enumerate().map(offset).fold(0.0, f64::max);
        largest * if D == 2 { 1.0 } else { 4.0 / 3.0 }
    }

    /// The flat pieces between the nodes, each given by the λ of its corners: the facet itself, two
    /// segments, or four triangles.
    pub fn pieces(&self) -> &'static [[[f64; 3]; 3]] {
        const A: [f64; 3] = [1.0, 0.0, 0.0];
        const B: [f64; 3] = [0.0, 1.0, 0.0];
        const C: [f64; 3] = [0.0, 0.0, 1.0];
        const AB: [f64; 3] = [0.5, 0.5, 0.0];
        const BC: [f64; 3] = [0.0, 0.5, 0.5];
        const CA: [f64; 3] = [0.5, 0.0, 0.5];
        match (self.order, D) {
            (Order::Linear, _) => &[[A, B, C]],
            (Order::Quadratic, 2) => &[[A, AB, C], [AB, B, C]],
            (Order::Quadratic, _) => &[[A, AB, CA], [AB, B, BC], [CA, BC, C], [AB, BC, CA]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc() -> Facet<2> {
        let x = [[1.0, 0.0], [0.0, 1.0], [0.71, 0.71]].map(Vector::<2>::from);
        Facet::gather(Order::Quadratic, &[0, 1, 2], &x)
    }

    fn dome() -> Facet<3> {
        let x = [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.7, 0.7, 0.05],
            [0.0, 0.8, 0.7],
            [0.6, 0.0, 0.7],
        ]
        .map(Vector::<3>::from);
        Facet::gather(Order::Quadratic, &[0, 1, 2, 3, 4, 5], &x)
    }

    /// The tangent facet against central differences, which are exact for quadratics.
    fn tangent_touches<const D: usize>(facet: &Facet<D>) {
        let mut lambda = Vector::<D>::from_fn(|i, _| 0.2 + 0.1 * i as f64);
        lambda /= lambda.sum();
        let corners = facet.tangent(&lambda);
        let at = |l: &Vector<D>| {
            let mut x = Vector::zeros();
            corners.iter().zip(l.iter()).for_each(|(c, l)| x += c * *l);
            x
        };
        assert!((at(&lambda) - facet.point(&lambda)).norm() < 1e-15);
        for k in 1..D {
            let mut step = Vector::<D>::zeros();
            (step[0], step[k]) = (-1e-3, 1e-3);
            let flat = at(&(lambda + step)) - at(&(lambda - step));
            let curved = facet.point(&(lambda + step)) - facet.point(&(lambda - step));
            assert!((flat - curved).norm() < 1e-15);
            // and the curvature: x(λ + s) − 2 x(λ) + x(λ − s) = s·x''·s
            let r = Vector::<D>::from_fn(|i, _| 0.3 - 0.2 * i as f64);
            let second = facet.point(&(lambda + step)) + facet.point(&(lambda - step))
                - facet.point(&lambda) * 2.0;
            let curvature = facet.curvature(&r);
            let along: f64 = (0..D)
                .flat_map(|i| (0..D).map(move |j| (i, j)))
                .map(|(i, j)| step[i] * curvature[(i, j)] * step[j])
                .sum();
            assert!((along - r.dot(&second)).abs() < 1e-15);
        }
    }

    #[test]
    fn tangents_and_curvatures() {
        tangent_touches(&arc());
        tangent_touches(&dome());
    }

    #[test]
    fn shapes_are_nodal() {
        for (lambda, node) in [
            ([1.0, 0.0, 0.0], 0),
            ([0.0, 0.0, 1.0], 2),
            ([0.5, 0.5, 0.0], 3),
            ([0.0, 0.5, 0.5], 4),
            ([0.5, 0.0, 0.5], 5),
        ] {
            let N = facet_shapes(Order::Quadratic, &Vector::<3>::from(lambda));
            for (a, N) in N.iter().enumerate() {
                assert_eq!(*N, f64::from(u8::from(a == node)), "N_{a} at node {node}");
            }
        }
    }

    #[test]
    fn the_box_holds_the_facet() {
        let facet = dome();
        let (low, high) = facet.bounding_box();
        for i in 0..=10 {
            for j in 0..=10 - i {
                let lambda = Vector::<3>::new(f64::from(i), f64::from(j), f64::from(10 - i - j));
                let x = facet.point(&(lambda / 10.0));
                assert!((0..3).all(|k| low[k] - 1e-15 <= x[k] && x[k] <= high[k] + 1e-15));
            }
        }
    }
}
