//! Averaged normals at the nodes of a surface, with their derivatives.
//!
//! n_a = s_a/|s_a|, s_a = Σ_f θ_f c_f/|c_f| over the facets around node a: c is the normal of the
//! tangent facet at the node and a function of its corners y, of which each is linear in the nodes,
//! ∂y_j/∂x_b = ∂N_b/∂λ_j up to what is common to all j and moves the facet without turning it. In space
//! θ is the facet's angle at a corner, else 1. With edges e, e' from the corner, θ = atan2(2|c|, e·e').

use std::array::from_fn;

use super::surface::Surface;
use crate::element::{Facet, FacetShapes, facet_edge, facet_slopes};
use crate::tensor::{Matrix, Vector, facet_normal};

/// The outward unit normal at each node of `surface` for positions `x` of its own nodes: unit
/// normals of the adjacent facets summed, weighted in space by the facet's angle at the node, and
/// normalised. With plain facet normals the fixed-point iteration does not converge.
pub fn averaged<const D: usize>(surface: &Surface<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    sums(surface, x).into_iter().map(unit).collect()
}

/// As [`averaged`], without the normalisation.
pub(super) fn sums<const D: usize>(surface: &Surface<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    let mut sums = vec![Vector::zeros(); x.len()];
    for (nodes, facet) in surface.facets().zip(surface.facets_at(x)) {
        #[cfg(planted)]
        if contact_core::planted!("every fifth facet is left out of averages") && nodes[0] % 5 == 1
        {
            continue;
        }
        for (k, &node) in nodes.iter().enumerate() {
            let tangent = facet.tangent(&node_coordinates(k));
            sums[node] += unit(facet_normal(&tangent)) * node_weight(&tangent, k);
        }
    }
    if surface.is_of_revolution() {
        // with their mirror images beyond the axis
        let axis = (0..sums.len()).filter(|a| surface.is_on_axis(*a));
        axis.for_each(|a| sums[a][0] = 0.0);
    }
    sums
}

/// λ of a facet's k-th node.
fn node_coordinates<const D: usize>(k: usize) -> Vector<D> {
    let mut lambda = Vector::zeros();
    if k < D {
        lambda[k] = 1.0;
    } else {
        for corner in facet_edge::<D>(k - D) {
            lambda[corner] = 0.5;
        }
    }
    lambda
}

/// In space the facet's angle at corner `k`. In the plane 1; likewise at the middle of an edge,
/// where the adjacent facets have the same angle.
fn node_weight<const D: usize>(tangent: &[Vector<D>; D], k: usize) -> f64 {
    if D == 2 || k >= D {
        return 1.0;
    }
    let a = tangent[(k + 1) % D] - tangent[k];
    let b = tangent[(k + 2) % D] - tangent[k];
    a.angle(&b)
}

/// v / |v|, or zero if the contributions cancel.
pub(super) fn unit<const D: usize>(v: Vector<D>) -> Vector<D> {
    let norm = v.norm();
    if norm > 0.0 { v / norm } else { v }
}

/// The direction n = v/|v| of a vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction<const D: usize> {
    pub n: Vector<D>,
    pub length: f64,
}

impl<const D: usize> Direction<D> {
    pub fn of(v: Vector<D>) -> Self {
        Direction {
            n: unit(v),
            length: v.norm(),
        }
    }

    /// ∂n/∂v = (I − n nᵀ)/|v|; zero if v is zero.
    pub fn slope(&self) -> Matrix<D> {
        match self.length > 0.0 {
            true => (Matrix::identity() - self.n * self.n.transpose()) / self.length,
            false => Matrix::zeros(),
        }
    }

    /// ∂²(w·n)/∂v² = −(w nᵀ + n wᵀ + w·n (I − 3 n nᵀ))/|v|²; zero if v is zero.
    pub fn curvature(&self, w: &Vector<D>) -> Matrix<D> {
        if self.length == 0.0 {
            return Matrix::zeros();
        }
        let nn = self.n * self.n.transpose();
        let isotropic = (Matrix::identity() - nn * 3.0) * w.dot(&self.n);
        let wn = w * self.n.transpose();
        -(wn + wn.transpose() + isotropic) / self.length.powi(2)
    }
}

/// θ c/|c|, the contribution of one facet to the normal at its k-th node.
pub(super) struct Addend<const D: usize> {
    k: usize,
    /// ∂y_j/∂x_b.
    pub slopes: [FacetShapes; D],
    c: Direction<D>,
    /// ∂c/∂y_j.
    c_y: [Matrix<D>; D],
    angle: Angle<D>,
}

/// θ and its derivatives by s = 2|c| and d = e·e'.
struct Angle<const D: usize> {
    value: f64,
    by_s: f64,
    by_d: f64,
    by_ss: f64,
    by_sd: f64,
    /// ∂d/∂y_j.
    d_y: [Vector<D>; D],
}

impl<const D: usize> Addend<D> {
    pub fn new(facet: &Facet<D>, k: usize) -> Self {
        let lambda = node_coordinates(k);
        let y = facet.tangent(&lambda);
        let c = Direction::of(facet_normal(&y));
        Addend {
            k,
            slopes: facet_slopes(facet.order(), &lambda),
            angle: Angle::new(&y, k, 2.0 * c.length),
            c,
            c_y: normal_slopes(&y),
        }
    }

    /// The derivatives of the contribution by the y_j.
    pub fn jacobian(&self) -> [Matrix<D>; D] {
        let (n, angle) = (self.c.n, &self.angle);
        let by_c = self.c.slope() * angle.value + n * n.transpose() * (2.0 * angle.by_s);
        from_fn(|j| by_c * self.c_y[j] + n * angle.d_y[j].transpose() * angle.by_d)
    }

    /// The second derivatives of its product with `v`, by y_i and y_j: those of h(c, d) by the
    /// chain rule, with c bilinear and d quadratic in the y.
    pub fn hessian(&self, v: &Vector<D>) -> [[Matrix<D>; D]; D] {
        let (n, angle) = (self.c.n, &self.angle);
        let (slope, along) = (self.c.slope(), v.dot(&n));
        let across = slope * v;
        let by_c = n * (2.0 * angle.by_s * along) + across * angle.value;
        let by_d = angle.by_d * along;
        let nq = n * across.transpose();
        let by_cc = n * n.transpose() * (4.0 * angle.by_ss * along)
            + (slope * along + nq + nq.transpose()) * (2.0 * angle.by_s)
            + self.c.curvature(v) * angle.value;
        let by_cd = n * (2.0 * angle.by_sd * along) + across * angle.by_d;
        let by_dd = -angle.by_ss * along; // θ is harmonic in (s, d)
        let twist = normal_curvature(&by_c);
        let d_y = &angle.d_y;
        let by_c_y = |j: usize| by_cc * self.c_y[j] + by_cd * d_y[j].transpose();
        let by_d_y = |j: usize| self.c_y[j].tr_mul(&by_cd) + d_y[j] * by_dd;
        let (by_c_y, by_d_y): ([_; D], [_; D]) = (from_fn(by_c_y), from_fn(by_d_y));
        let mut hessian = [[Matrix::zeros(); D]; D];
        for (i, j) in (0..D).flat_map(|j| (0..=j).map(move |i| (i, j))) {
            let mut h = self.c_y[i].tr_mul(&by_c_y[j]) + d_y[i] * by_d_y[j].transpose();
            // the terms with second derivatives of c and d
            if i != j {
                h += if j == i + 1 { twist } else { -twist };
            }
            let d_yy = match (i == self.k, j == self.k) {
                (true, true) => 2.0,
                (false, false) if i == j => 0.0,
                (false, false) => 1.0,
                _ => -1.0,
            };
            h += Matrix::identity() * (d_yy * by_d);
            (hessian[i][j], hessian[j][i]) = (h, h.transpose());
        }
        hessian
    }
}

impl<const D: usize> Angle<D> {
    /// At corner `k`; 1 for the nodes where [`node_weight`] is constant.
    fn new(y: &[Vector<D>; D], k: usize, s: f64) -> Self {
        let mut angle = Angle {
            value: node_weight(y, k),
            by_s: 0.0,
            by_d: 0.0,
            by_ss: 0.0,
            by_sd: 0.0,
            d_y: [Vector::zeros(); D],
        };
        if D == 2 || k >= D {
            return angle;
        }
        let (first, second) = ((k + 1) % D, (k + 2) % D);
        let (a, b) = (y[first] - y[k], y[second] - y[k]);
        let d = a.dot(&b);
        let square = s * s + d * d;
        if square > 0.0 {
            angle.by_s = d / square;
            angle.by_d = -s / square;
            angle.by_ss = -2.0 * s * d / square.powi(2);
            angle.by_sd = (s * s - d * d) / square.powi(2);
        }
        (angle.d_y[first], angle.d_y[second], angle.d_y[k]) = (b, a, -(a + b));
        angle
    }
}

/// ∂c/∂y_j of c = [`facet_normal`]: in the plane a rotation by a right angle, in space ½ (y_{j+2} −
/// y_{j+1}) ×.
fn normal_slopes<const D: usize>(y: &[Vector<D>; D]) -> [Matrix<D>; D] {
    from_fn(|j| {
        if D == 3 {
            return cross(&((y[(j + 2) % D] - y[(j + 1) % D]) * 0.5));
        }
        let mut turn = Matrix::zeros();
        turn[(0, 1)] = if j == 0 { -1.0 } else { 1.0 };
        turn[(1, 0)] = -turn[(0, 1)];
        turn
    })
}

/// ∂²(q·c)/∂y_j∂y_{j+1} in space; in the plane c is linear.
fn normal_curvature<const D: usize>(q: &Vector<D>) -> Matrix<D> {
    if D == 3 {
        cross(&(q * -0.5))
    } else {
        Matrix::zeros()
    }
}

/// The matrix of the cross product a × in space.
fn cross<const D: usize>(a: &Vector<D>) -> Matrix<D> {
    let mut matrix = Matrix::zeros();
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (matrix[(k, j)], matrix[(j, k)]) = (a[i], -a[i]);
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    #[test]
    fn square_corner_bisects() {
        let x = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]].map(Vector::<2>::from);
        let facets = [[0, 1], [1, 2]];
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Linear, facets, &x);
        let normals = averaged(&surface, &x);
        let h = 0.5f64.sqrt();
        assert!((normals[0] - Vector::<2>::new(0.0, -1.0)).norm() < 1e-15);
        assert!((normals[1] - Vector::<2>::new(h, -h)).norm() < 1e-15);
    }

    /// A cube's corner: its three faces must have equal weights, although one of them is divided in
    /// two.
    #[test]
    fn cube_corner_is_independent_of_the_triangulation() {
        let x = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]
        .map(Vector::<3>::from);
        let facets = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [0, 4, 3]];
        let facets = facets.iter().map(|f| &f[..]);
        let normals = averaged(&Surface::new(0, Order::Linear, facets, &x), &x);
        let expected = -Vector::<3>::repeat((1.0f64 / 3.0).sqrt());
        assert!((normals[0] - expected).norm() < 1e-14);
    }

    /// On quadratic facets of a circle, middle nodes have the circle's normal.
    #[test]
    fn curved_facets() {
        let at = |angle: f64| Vector::<2>::new(angle.cos(), angle.sin());
        let x = [0.0, 0.2, 0.4, 0.1, 0.3].map(at);
        let facets = [[0, 1, 3], [1, 2, 4]];
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Quadratic, facets, &x);
        for (n, x) in averaged(&surface, &x).iter().zip(&x).skip(1) {
            assert!((n - x).norm() < 4e-3, "{n} at {x}");
        }
    }
}
