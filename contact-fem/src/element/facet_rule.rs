//! Quadrature on facets.

use crate::tensor::Vector;

/// Points in barycentric coordinates with weights that sum to 1; multiply by the facet's measure.
#[derive(Clone, Debug)]
pub struct FacetRule<const D: usize> {
    points: Vec<(f64, Vector<D>)>,
}

impl<const D: usize> FacetRule<D> {
    /// Gauss–Legendre with `n` points a direction: `n` on a segment, exact to degree 2n − 1; n² on
    /// a triangle by a collapsed square, exact to degree 2n − 2.
    pub fn gauss(n: usize) -> Self {
        const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
        let line = gauss_legendre(n.max(1));
        let mut points = Vec::new();
        for &(w, t) in &line {
            if D == 2 {
                let mut lambda = Vector::zeros();
                (lambda[0], lambda[1]) = (1.0 - t, t);
                points.push((w, lambda));
                continue;
            }
            for &(v, s) in &line {
                let mut lambda = Vector::zeros();
                (lambda[0], lambda[1], lambda[2]) = (1.0 - t, t * (1.0 - s), t * s);
                points.push((2.0 * w * v * t, lambda));
            }
        }
        FacetRule { points }
    }

    /// (weight, barycentric coordinates).
    pub fn points(&self) -> &[(f64, Vector<D>)] {
        &self.points
    }
}

/// Weights (sum 1) and points of the n-point Gauss–Legendre rule on [0, 1], by Newton's method on
/// the Legendre polynomial.
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        (now, n as f64 * (x * now - before) / (x * x - 1.0))
    };
    let point = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..50 {
            let (p, dp) = legendre(x);
            x -= p / dp;
        }
        let (_, dp) = legendre(x);
        (1.0 / ((1.0 - x * x) * dp * dp), 0.5 * (1.0 - x))
    };
    (0..n).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_on_a_segment() {
        for n in 1..=8 {
            let rule = FacetRule::<2>::gauss(n);
            for k in 0..2 * n as i32 {
                let sum: f64 = rule.points().iter().map(|(w, l)| w * l[1].powi(k)).sum();
                assert!(
                    (sum - 1.0 / f64::from(k + 1)).abs() < 1e-14,
                    "n {n}, degree {k}"
                );
            }
            let k = 2 * n as i32;
            let sum: f64 = rule.points().iter().map(|(w, l)| w * l[1].powi(k)).sum();
            assert!(
                (sum - 1.0 / f64::from(k + 1)).abs() > 1e-12,
                "not exact beyond"
            );
        }
    }

    /// ∫ λ₁ᵖ λ₂^q over a triangle of measure 1 is 2 p! q! / (p + q + 2)!.
    #[test]
    fn monomials_on_a_triangle() {
        let factorial = |k: i32| (1..=k).map(f64::from).product::<f64>();
        for n in 1..=5 {
            let rule = FacetRule::<3>::gauss(n);
            for p in 0..=2 * n as i32 - 2 {
                for q in 0..=2 * n as i32 - 2 - p {
                    let points = rule.points().iter();
                    let sum: f64 = points.map(|(w, l)| w * l[1].powi(p) * l[2].powi(q)).sum();
                    let exact = 2.0 * factorial(p) * factorial(q) / factorial(p + q + 2);
                    assert!((sum - exact).abs() < 1e-14, "n {n}, degrees {p} {q}");
                }
            }
        }
    }
}
