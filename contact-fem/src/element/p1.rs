//! Linear simplices: triangle and tetrahedron.

use super::Element;
use crate::tensor::{Vector, unit_vector};

/// The linear simplex: nodes at its D + 1 corners, N_0 = 1 − Σξ, N_a = ξ_a.
#[derive(Clone, Copy, Debug)]
pub struct P1;

macro_rules! linear_simplex {
    ($D:literal, $nodes:literal, $volume:expr) => {
        impl Element<$D> for P1 {
            type PerNode<T: Copy + Send + Sync> = [T; $nodes];
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
    use super::*;

    fn battery<const D: usize, E: Element<D>>(corners: &[Vector<D>], volume: f64) {
        let weights: f64 = E::QUADRATURE.iter().map(|q| q.0).sum();
        assert!(
            (weights - volume).abs() < 1e-15,
            "weights sum to the volume"
        );
        for (a, corner) in corners.iter().enumerate() {
            for (b, &N) in E::shapes(corner).as_ref().iter().enumerate() {
                assert_eq!(N, f64::from(u8::from(a == b)), "nodal");
            }
        }
        let xi = Vector::<D>::from_fn(|i, _| 0.1 + 0.07 * i as f64);
        let h = 1e-6;
        assert!((E::shapes(&xi).as_ref().iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for i in 0..D {
            let step = unit_vector::<D>(i) * h;
            let (up, down) = (E::shapes(&(xi + step)), E::shapes(&(xi - step)));
            for (a, dN) in E::shape_gradients(&xi).as_ref().iter().enumerate() {
                let difference = (up.as_ref()[a] - down.as_ref()[a]) / (2.0 * h);
                assert!((dN[i] - difference).abs() < 1e-9, "gradient of node {a}");
            }
        }
    }

    #[test]
    fn triangle() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from);
        battery::<2, P1>(&corners, 0.5);
    }

    #[test]
    fn tetrahedron() {
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        battery::<3, P1>(&corners.map(Vector::<3>::from), 1.0 / 6.0);
    }
}
