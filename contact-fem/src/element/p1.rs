//! Linear simplices: triangle and tetrahedron.

use super::{Element, Order};
use crate::tensor::{Vector, unit_vector};

/// The linear simplex: nodes at its D + 1 corners, N_0 = 1 − Σξ, N_a = ξ_a.
#[derive(Clone, Copy, Debug)]
pub struct P1;

macro_rules! linear_simplex {
    ($D:literal, $nodes:literal, $volume:expr) => {
        impl Element<$D> for P1 {
            type PerNode<T: Copy + Send + Sync> = [T; $nodes];
            const ORDER: Order = Order::Linear;
            const EDGES: &'static [[usize; 2]] = &[];
            const QUADRATURE: &'static [(f64, [f64; $D])] = &[($volume, [1.0 / $nodes as f64; $D])];

            fn per_node<T: Copy + Send + Sync>(value: T) -> [T; $nodes] {
                [value; $nodes]
            }

            fn shapes(xi: &Vector<$D>) -> [f64; $nodes] {
                let mut N = [1.0 - xi.sum(); $nodes];
                N[1..].copy_from_slice(xi.as_slice());
                N
            }

            fn shape_gradients(_xi: &Vector<$D>) -> [Vector<$D>; $nodes] {
                let mut dN = [Vector::repeat(-1.0); $nodes];
                for a in 0..$D {
                    dN[a + 1] = unit_vector(a);
                }
                dN
            }
        }
    };
}

linear_simplex!(2, 3, 0.5);
linear_simplex!(3, 4, 1.0 / 6.0);

#[cfg(test)]
mod tests {
    use super::super::battery::battery;
    use super::*;

    #[test]
    fn triangle() {
        battery::<2, P1>(1, 1);
    }

    #[test]
    fn tetrahedron() {
        battery::<3, P1>(1, 1);
    }
}
