//! Conformance checks: the derivatives of an [`Energy`] or an [`Nlp`](crate::nlp::Nlp) against finite differences.

mod derivatives;

pub use self::derivatives::{Derivative, Differences, Finding, nlp};
use crate::Energy;

/// Errors of an energy's derivatives against central differences of the derivatives one order lower,
/// relative to the largest entry. They are NaN or infinite where a value, a derivative or a
/// difference is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conformance {
    /// Gradient against differences of the value.
    pub gradient: f64,
    /// Hessian against differences of the gradient.
    pub hessian: f64,
    /// The largest difference at positions of the full Hessian that the pattern lacks.
    pub outside_pattern: f64,
}

/// The slope of E at `u` along its gradient, by the gradient and by central differences, where the two contradict each other:
/// differences of two steps agree within a tenth, and the gradient does not agree with them.
pub(crate) fn wrong_slope(energy: &dyn Energy, u: &[f64]) -> Option<[f64; 2]> {
    const APART: f64 = 0.1;
    if u.len() != energy.dofs() {
        return None;
    }
    let mut gradient = vec![0.0; u.len()];
    energy.gradient(u, &mut gradient);
    let slope = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    let size = u.iter().fold(0.0_f64, |size, u| size.max(u.abs()));
    if !(slope > 0.0 && slope.is_finite() && size.is_finite()) {
        return None;
    }
    let reach = if size > 0.0 { 1e-5 * size } else { 1e-5 };
    let largest = gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let difference = |reach: f64| {
        let h = reach * slope / largest;
        let at = |sign: f64| {
            let moved = u.iter().zip(&gradient);
            let moved: Vec<f64> = moved.map(|(u, g)| u + sign * h * g / slope).collect();
            energy.value(&moved)
        };
        (at(1.0) - at(-1.0)) / (2.0 * h)
    };
    let [wide, narrow] = [reach, 0.1 * reach].map(difference);
    let are_apart = |a: f64, b: f64| !((a - b).abs() <= APART * a.abs().max(b.abs()));
    let is_wrong = wide.is_finite() && !are_apart(wide, narrow) && are_apart(slope, wide);
    is_wrong.then_some([slope, wide])
}

/// Compares gradient and Hessian at `u` (n) with central differences of step `h` (UL) in every unknown, which takes
/// 4 n evaluations. With a step of 0, or one that is lost in the round-off of `u`, the errors are NaN.
///
/// # Panics
/// If `u` does not have [`Energy::dofs`] entries.
pub fn energy(energy: &dyn Energy, u: &[f64], h: f64) -> Conformance {
    let n = energy.dofs();
    assert_eq!(u.len(), n, "check::energy: u has one entry per unknown");
    let mut gradient = vec![0.0; n];
    energy.gradient(u, &mut gradient);
    let (difference, columns) = central_differences(energy, u, h);

    let pattern = energy.hessian_pattern();
    let mut values = vec![0.0; pattern.len()];
    energy.hessian(u, &mut values);
    let mut hessian = vec![vec![0.0; n]; n];
    let mut inside = vec![vec![false; n]; n];
    for ((&r, &c), v) in pattern.rows().iter().zip(pattern.cols()).zip(values) {
        hessian[c][r] = v;
        hessian[r][c] = v;
        inside[r][c] = true;
        inside[c][r] = true;
    }
    let size = |values: &[f64]| {
        values
            .iter()
            .fold(f64::MIN_POSITIVE, |m, v| larger(m, v.abs()))
    };
    let whole = columns.iter().map(|c| size(c)).fold(0.0, larger);
    let mut result = Conformance {
        gradient: distance(&gradient, &difference) / size(&difference),
        hessian: 0.0,
        outside_pattern: 0.0,
    };
    for (j, column) in columns.iter().enumerate() {
        for i in 0..n {
            let error = (hessian[j][i] - column[i]).abs() / whole;
            let worst = match inside[j][i] {
                true => &mut result.hessian,
                false => &mut result.outside_pattern,
            };
            *worst = larger(*worst, error);
        }
    }
    result
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |m, (a, b)| larger(m, (a - b).abs()))
}

/// The larger one, or NaN if one of them is.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// ∇E from differences of E, and the columns of ∇²E from differences of ∇E.
fn central_differences(energy: &dyn Energy, u: &[f64], h: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = u.len();
    let mut x = u.to_vec();
    let (mut up, mut down) = (vec![0.0; n], vec![0.0; n]);
    let mut gradient = Vec::with_capacity(n);
    let mut columns = Vec::with_capacity(n);
    for j in 0..n {
        x[j] = u[j] + h;
        let above = energy.value(&x);
        energy.gradient(&x, &mut up);
        x[j] = u[j] - h;
        let below = energy.value(&x);
        energy.gradient(&x, &mut down);
        x[j] = u[j];
        gradient.push((above - below) / (2.0 * h));
        columns.push(
            up.iter()
                .zip(&down)
                .map(|(a, b)| (a - b) / (2.0 * h))
                .collect(),
        );
    }
    (gradient, columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::SymmetricPattern;

    /// E = ½ u₀² + u₁⁴, with a gradient that is too large by a factor.
    struct Scaled(f64, SymmetricPattern);

    impl Energy for Scaled {
        fn dofs(&self) -> usize {
            2
        }
        fn value(&self, u: &[f64]) -> f64 {
            0.5 * u[0] * u[0] + u[1].powi(4)
        }
        fn gradient(&self, u: &[f64], g: &mut [f64]) {
            g.copy_from_slice(&[self.0 * u[0], self.0 * 4.0 * u[1].powi(3)]);
        }
        fn hessian_pattern(&self) -> &SymmetricPattern {
            &self.1
        }
        fn hessian(&self, u: &[f64], values: &mut [f64]) {
            values.copy_from_slice(&[1.0, 12.0 * u[1] * u[1]]);
        }
    }

    #[test]
    fn slopes_that_contradict_the_energy() {
        let pattern = || SymmetricPattern::diagonal(2);
        for u in [[1.0, -2.0], [1e-6, 3e-6], [1e8, 0.0]] {
            assert_eq!(wrong_slope(&Scaled(1.0, pattern()), &u), None, "{u:?}");
            for factor in [-1.0, 2.0, 0.5] {
                let energy = Scaled(factor, pattern());
                let [slope, differences] = wrong_slope(&energy, &u).expect("wrong");
                assert!((slope / differences / factor - 1.0).abs() < 1e-3, "{u:?}");
            }
        }
        // nothing is known where the gradient vanishes
        assert_eq!(wrong_slope(&Scaled(-1.0, pattern()), &[0.0; 2]), None);
    }
}
