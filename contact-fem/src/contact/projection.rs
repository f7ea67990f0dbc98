//! The closest point of one facet.

use crate::tensor::Vector;

/// Barycentric coordinates (D of them, ≥ 0, sum 1) of the point of the facet with these corners
/// that is closest to `x`.
///
/// A segment clamps one parameter; a triangle is decided region by region, as in C. Ericson,
/// Real-Time Collision Detection (2005), section 5.1.5.
pub fn closest<const D: usize>(x: &Vector<D>, corners: &[Vector<D>; D]) -> Vector<D> {
    const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
    let mut lambda = Vector::zeros();
    if D == 2 {
        let t = along(x, &corners[0], &corners[1]).clamp(0.0, 1.0);
        lambda[0] = 1.0 - t;
        lambda[1] = t;
        return lambda;
    }
    let (a, b, c) = (&corners[0], &corners[1], &corners[2]);
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(x - a)), ac.dot(&(x - a)));
    let (d3, d4) = (ab.dot(&(x - b)), ac.dot(&(x - b)));
    let (d5, d6) = (ab.dot(&(x - c)), ac.dot(&(x - c)));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let weights = if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        [1.0 - t, t, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        [1.0 - t, 0.0, t]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - t, t]
    } else {
        let whole = va + vb + vc;
        [va / whole, vb / whole, vc / whole]
    };
    lambda.copy_from_slice(&weights[..D]);
    lambda
}

/// The parameter of the foot of `x` on the line through `a` and `b`, unclamped.
fn along<const D: usize>(x: &Vector<D>, a: &Vector<D>, b: &Vector<D>) -> f64 {
    let edge = b - a;
    edge.dot(&(x - a)) / edge.norm_squared()
}

/// Σ λ_k x_k.
pub fn interpolate<const D: usize>(lambda: &Vector<D>, values: &[Vector<D>; D]) -> Vector<D> {
    let mut point = Vector::<D>::zeros();
    for (l, value) in lambda.iter().zip(values) {
        point.axpy(*l, value, 1.0);
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with a brute-force search over a fine lattice of the facet.
    fn against_lattice<const D: usize>(corners: [Vector<D>; D], lattice: &[Vector<D>]) {
        for k in 0..200 {
            let x = Vector::<D>::from_fn(|i, _| 2.5 * ((k * (i + 3) + i) as f64 * 0.77).sin());
            let lambda = closest(&x, &corners);
            assert!(lambda.iter().all(|&l| l >= 0.0));
            assert!((lambda.sum() - 1.0).abs() < 1e-14);
            let distance = (x - interpolate(&lambda, &corners)).norm();
            let brute = lattice
                .iter()
                .map(|l| (x - interpolate(l, &corners)).norm());
            let brute = brute.fold(f64::INFINITY, f64::min);
            assert!(distance <= brute + 1e-12, "{distance} against {brute}");
            assert!(brute - distance < 2e-3);
        }
    }

    #[test]
    fn segment() {
        let corners = [[-0.4, 0.3], [1.1, 0.8]].map(Vector::<2>::from);
        let lattice: Vec<_> = (0..=2000)
            .map(|i| Vector::<2>::new(1.0 - f64::from(i) / 2000.0, f64::from(i) / 2000.0))
            .collect();
        against_lattice(corners, &lattice);
    }

    #[test]
    fn triangle() {
        let corners = [[0.1, -0.2, 0.3], [1.2, 0.3, -0.1], [0.2, 0.9, 0.6]];
        let n = 400;
        let steps = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        let lattice: Vec<_> = steps
            .map(|(i, j)| Vector::<3>::new(f64::from(i), f64::from(j), f64::from(n - i - j)))
            .map(|v| v / f64::from(n))
            .collect();
        against_lattice(corners.map(Vector::<3>::from), &lattice);
    }
}
