//! Averaged normals at the nodes of a surface.

use super::surface::Surface;
use crate::tensor::{Vector, facet_normal};

/// The outward unit normal at each node of `surface` (in the order of [`Surface::nodes`]) for
/// current positions `x` of all scene nodes: unit normals of the adjacent facets summed, weighted
/// in space by the facet's angle at the node, and normalised. With plain facet normals the fixed
/// point does not converge.
pub fn averaged<const D: usize>(surface: &Surface<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    let mut sums = vec![Vector::zeros(); surface.nodes().len()];
    for facet in surface.facets() {
        let corners = facet.map(|a| x[a]);
        let normal = unit(facet_normal(&corners));
        for (k, &node) in facet.iter().enumerate() {
            sums[surface.local(node)] += normal * corner_weight(&corners, k);
        }
    }
    sums.into_iter().map(unit).collect()
}

/// 1 in the plane, the angle at corner `k` in space.
fn corner_weight<const D: usize>(corners: &[Vector<D>; D], k: usize) -> f64 {
    if D == 2 {
        return 1.0;
    }
    let a = corners[(k + 1) % D] - corners[k];
    let b = corners[(k + 2) % D] - corners[k];
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

    #[test]
    fn square_corner_bisects() {
        let x = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]].map(Vector::<2>::from);
        let surface = Surface::new(0, vec![[0, 1], [1, 2]], &x);
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
        let facets = vec![[0, 2, 1], [0, 3, 2], [0, 1, 4], [0, 4, 3]];
        let normals = averaged(&Surface::new(0, facets, &x), &x);
        let expected = -Vector::<3>::repeat((1.0f64 / 3.0).sqrt());
        assert!((normals[0] - expected).norm() < 1e-14);
    }
}
