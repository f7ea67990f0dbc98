//! Averaged normals at the nodes of a surface.

use super::surface::Surface;
use crate::element::facet_edge;
use crate::tensor::{Vector, facet_normal};

/// The outward unit normal at each node of `surface` for positions `x` of its own nodes: unit
/// normals of the adjacent facets summed, weighted in space by the facet's angle at the node, and
/// normalised. With plain facet normals the fixed point does not converge.
pub fn averaged<const D: usize>(surface: &Surface<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    sums(surface, x).into_iter().map(unit).collect()
}

/// As [`averaged`], not yet normalised.
pub(super) fn sums<const D: usize>(surface: &Surface<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    let mut sums = vec![Vector::zeros(); x.len()];
    for (nodes, facet) in surface.facets().zip(surface.facets_at(x)) {
        for (k, &node) in nodes.iter().enumerate() {
            let tangent = facet.tangent(&node_coordinates(k));
            sums[node] += unit(facet_normal(&tangent)) * node_weight(&tangent, k);
        }
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

/// In space the angle at corner `k`; 1 in the plane, and in the middle of an edge, where the facets
/// have the same angle.
fn node_weight<const D: usize>(tangent: &[Vector<D>; D], k: usize) -> f64 {
    if D == 2 || k >= D {
        return 1.0;
    }
    let a = tangent[(k + 1) % D] - tangent[k];
    let b = tangent[(k + 2) % D] - tangent[k];
    a.angle(&b)
}

/// v / |v|, or zero where facets cancel each other.
pub(super) fn unit<const D: usize>(v: Vector<D>) -> Vector<D> {
    let norm = v.norm();
    if norm > 0.0 { v / norm } else { v }
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

    /// A cube's corner: three faces, one of them cut in two, must weigh the same.
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
