//! Quadrature on facets.

use crate::tensor::Vector;

/// Points in barycentric coordinates with weights that sum to 1; they are to be multiplied by the
/// facet's measure.
#[derive(Clone, Debug)]
pub struct FacetRule<const D: usize> {
    points: Vec<(f64, Vector<D>)>,
}

impl<const D: usize> FacetRule<D> {
    /// Gauss–Legendre with `n` points in each direction: `n` on a segment, exact to degree 2n − 1;
    /// n² on a triangle by a collapsed square, exact to degree 2n − 2.
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

    /// The rule with the fewest points that is exact for polynomials up to `degree` and has
    /// positive weights: Gauss–Legendre on a segment; on a triangle three points for degree 2, six
    /// for degree 4 (G. R. Cowper, *Gaussian quadrature formulas for triangles*, IJNME 7, 1973),
    /// and [`FacetRule::gauss`] for higher degrees.
    pub fn of_degree(degree: usize) -> Self {
        let (root, inner) = (10f64.sqrt(), (38.0 - 44.0 * 0.4f64.sqrt()).sqrt());
        let spread = (213_125.0 - 53_320.0 * root).sqrt();
        let orbit = |sign: f64| {
            let weight = (620.0 + sign * spread) / 3720.0;
            (weight, (8.0 - root + sign * inner) / 18.0)
        };
        let orbits = match (D, degree) {
            (2, _) => return Self::gauss(degree / 2 + 1),
            (_, 0..=2) => vec![(1.0 / 3.0, 1.0 / 6.0)],
            (_, 3..=4) => vec![orbit(1.0), orbit(-1.0)],
            _ => return Self::gauss(degree.div_ceil(2) + 1),
        };
        // one point near each corner or each side; its other two coordinates are equal
        let corner = |(weight, near): (f64, f64), k: usize| {
            let lambda = |i: usize, _| if i == k { 1.0 - 2.0 * near } else { near };
            (weight, Vector::from_fn(lambda))
        };
        let corners = orbits
            .iter()
            .flat_map(|&orbit| (0..D).map(move |k| corner(orbit, k)));
        FacetRule {
            points: corners.collect(),
        }
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
    fn triangle_monomials(rule: &FacetRule<3>, degree: i32) {
        let factorial = |k: i32| (1..=k).map(f64::from).product::<f64>();
        for p in 0..=degree {
            for q in 0..=degree - p {
                let points = rule.points().iter();
                let sum: f64 = points.map(|(w, l)| w * l[1].powi(p) * l[2].powi(q)).sum();
                let exact = 2.0 * factorial(p) * factorial(q) / factorial(p + q + 2);
                let points = rule.points().len();
                assert!((sum - exact).abs() < 1e-14, "{points} points, {p} {q}");
            }
        }
    }

    #[test]
    fn monomials_on_a_triangle() {
        for n in 1..=5 {
            triangle_monomials(&FacetRule::gauss(n), 2 * n as i32 - 2);
        }
    }

    #[test]
    fn rules_of_a_degree() {
        for degree in 0..=9 {
            let triangle = FacetRule::<3>::of_degree(degree);
            triangle_monomials(&triangle, degree as i32);
            let segment = FacetRule::<2>::of_degree(degree);
            for k in 0..=degree as i32 {
                let points = segment.points().iter();
                let sum: f64 = points.map(|(w, l)| w * l[1].powi(k)).sum();
                assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14);
            }
            assert!(
                triangle
                    .points()
                    .iter()
                    .all(|(w, l)| *w > 0.0 && l.min() > 0.0)
            );
        }
        assert_eq!(
            [2, 3, 4].map(|d| FacetRule::<3>::of_degree(d).points().len()),
            [3, 6, 6]
        );
        assert_eq!(
            [2, 3, 4].map(|d| FacetRule::<2>::of_degree(d).points().len()),
            [2, 2, 3]
        );
    }
}
