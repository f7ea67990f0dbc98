//! Quadratic simplices: triangle with six nodes, tetrahedron with ten.

use super::{Element, Order};
use crate::tensor::{Vector, unit_vector};

/// The quadratic simplex, in barycentric coordinates λ: N = λ_a (2 λ_a − 1) at corner a and
/// 4 λ_a λ_b at the middle of the edge from a to b. Nodes in the order of VTK's quadratic cells.
#[derive(Clone, Copy, Debug)]
pub struct P2;

/// The edges of a triangle (the first three) and of a tetrahedron, as pairs of corners.
pub(crate) const CELL_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// N_a(ξ) for all nodes of a cell in ℝᴰ.
pub(crate) fn shapes<const D: usize>(xi: &Vector<D>, N: &mut [f64]) {
    let lambda = barycentric(xi);
    let (corners, middles) = N.split_at_mut(D + 1);
    for (a, N) in corners.iter_mut().enumerate() {
        *N = lambda(a) * (2.0 * lambda(a) - 1.0);
    }
    for (N, [a, b]) in middles.iter_mut().zip(CELL_EDGES) {
        *N = 4.0 * lambda(a) * lambda(b);
    }
}

/// ∂N_a/∂ξ for all nodes of a cell in ℝᴰ.
pub(crate) fn shape_gradients<const D: usize>(xi: &Vector<D>, dN: &mut [Vector<D>]) {
    let lambda = barycentric(xi);
    let (corners, middles) = dN.split_at_mut(D + 1);
    for (a, dN) in corners.iter_mut().enumerate() {
        *dN = barycentric_gradient(a) * (4.0 * lambda(a) - 1.0);
    }
    for (dN, [a, b]) in middles.iter_mut().zip(CELL_EDGES) {
        *dN = barycentric_gradient(a) * (4.0 * lambda(b))
            + barycentric_gradient(b) * (4.0 * lambda(a));
    }
}

/// λ_0 = 1 − Σ ξ, λ_a = ξ_a.
fn barycentric<const D: usize>(xi: &Vector<D>) -> impl Fn(usize) -> f64 {
    let (first, xi) = (1.0 - xi.sum(), *xi);
    move |a| if a == 0 { first } else { xi[a - 1] }
}

/// ∂λ_a/∂ξ.
fn barycentric_gradient<const D: usize>(a: usize) -> Vector<D> {
    match a {
        0 => Vector::repeat(-1.0),
        _ => unit_vector(a - 1),
    }
}

macro_rules! quadratic_simplex {
    ($D:literal, $nodes:literal, $quadrature:expr) => {
        impl Element<$D> for P2 {
            type PerNode<T: Copy + Send + Sync> = [T; $nodes];
            const ORDER: Order = Order::Quadratic;
            const EDGES: &'static [[usize; 2]] = CELL_EDGES.split_at($nodes - $D - 1).0;
            const QUADRATURE: &'static [(f64, [f64; $D])] = &$quadrature;

            fn per_node<T: Copy + Send + Sync>(value: T) -> [T; $nodes] {
                [value; $nodes]
            }

            fn shapes(xi: &Vector<$D>) -> [f64; $nodes] {
                let mut N = [0.0; $nodes];
                shapes(xi, &mut N);
                N
            }

            fn shape_gradients(xi: &Vector<$D>) -> [Vector<$D>; $nodes] {
                let mut dN = [Vector::zeros(); $nodes];
                shape_gradients(xi, &mut dN);
                dN
            }
        }
    };
}

const SIXTH: f64 = 1.0 / 6.0;

// Exact for quadratics, such as the energy of a small strain on straight cells.
quadratic_simplex!(
    2,
    6,
    [
        (SIXTH, [SIXTH, SIXTH]),
        (SIXTH, [4.0 * SIXTH, SIXTH]),
        (SIXTH, [SIXTH, 4.0 * SIXTH]),
    ]
);

/// The two coordinates (5 − √5)/20 and (5 + 3√5)/20 of the tetrahedron's points.
const NEAR: f64 = 0.138_196_601_125_010_5;
const FAR: f64 = 0.585_410_196_624_968_5;

quadratic_simplex!(
    3,
    10,
    [
        (1.0 / 24.0, [NEAR, NEAR, NEAR]),
        (1.0 / 24.0, [FAR, NEAR, NEAR]),
        (1.0 / 24.0, [NEAR, FAR, NEAR]),
        (1.0 / 24.0, [NEAR, NEAR, FAR]),
    ]
);

#[cfg(test)]
mod tests {
    use super::super::battery::battery;
    use super::*;

    #[test]
    fn triangle() {
        battery::<2, P2>(2, 2);
    }

    #[test]
    fn tetrahedron() {
        battery::<3, P2>(2, 2);
    }
}
