//! The quadratic triangle for sections of bodies of revolution.

use super::{Element, Order, P2};
use crate::tensor::Vector;

/// [`P2`] in the plane with a quadrature that is exact to degree 4: weighted with the radius, energies have degree 3 on straight
/// cells, and terms in N²/R, which are no polynomials, next to the axis.
#[derive(Clone, Copy, Debug)]
pub struct RingP2;

/// Two orbits of three points (D. A. Dunavant, 1985): the coordinate that two corners have, and the weight.
const INNER: (f64, f64) = (0.445_948_490_915_964_9, 0.111_690_794_839_005_73);
const OUTER: (f64, f64) = (0.091_576_213_509_770_74, 0.054_975_871_827_660_93);

const fn orbit((near, weight): (f64, f64)) -> [(f64, [f64; 2]); 3] {
    let far = 1.0 - 2.0 * near;
    [
        (weight, [near, near]),
        (weight, [far, near]),
        (weight, [near, far]),
    ]
}

const POINTS: [(f64, [f64; 2]); 6] = {
    let ([a, b, c], [d, e, f]) = (orbit(INNER), orbit(OUTER));
    [a, b, c, d, e, f]
};

impl Element<2> for RingP2 {
    type PerNode<T: Copy + Send + Sync> = [T; 6];
    const ORDER: Order = Order::Quadratic;
    const EDGES: &'static [[usize; 2]] = <P2 as Element<2>>::EDGES;
    const QUADRATURE: &'static [(f64, [f64; 2])] = &POINTS;

    fn per_node<T: Copy + Send + Sync>(value: T) -> [T; 6] {
        [value; 6]
    }

    fn shapes(xi: &Vector<2>) -> [f64; 6] {
        P2::shapes(xi)
    }

    fn shape_gradients(xi: &Vector<2>) -> [Vector<2>; 6] {
        P2::shape_gradients(xi)
    }
}

#[cfg(test)]
mod tests {
    use super::super::battery::battery;
    use super::*;

    #[test]
    fn quadratic_with_degree_4() {
        battery::<2, RingP2>(2, 4);
    }
}
