//! The conditions of Karush, Kuhn and Tucker, checked without the solver.

use contact_core::nlp::{Multipliers, Nlp};

use crate::problem::{Problem, Range};

/// How far a point and its multipliers are from satisfying each condition; max-norms, nothing scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals {
    /// ∇f + Jᵀλ − z_L + z_U, for variables that are not fixed.
    pub stationarity: f64,
    /// Violation of the constraints.
    pub violation: f64,
    /// Violation of the bounds.
    pub outside: f64,
    /// How far multipliers have the wrong sign: z_L, z_U < 0, any of them without its bound, λ > 0 without an upper
    /// bound or λ < 0 without a lower one.
    pub sign: f64,
    /// Multipliers times distances from their bounds, distances above 1 counting as 1.
    pub complementarity: f64,
}

fn outside(value: f64, (lower, upper): Range) -> f64 {
    (lower - value).max(value - upper).max(0.0)
}

/// How far `below` ≥ 0 of a lower bound and `above` ≥ 0 of an upper are from the right sign, and from complementarity.
fn multiplier(below: f64, above: f64, value: f64, (lower, upper): Range) -> (f64, f64) {
    let one = |z: f64, distance: f64| match distance.is_finite() {
        true => ((-z).max(0.0), (z * distance.min(1.0)).abs()),
        false => (z.abs(), 0.0),
    };
    let (low, up) = (one(below, value - lower), one(above, upper - value));
    (low.0.max(up.0), low.1.max(up.1))
}

/// Lagrange's gradient.
fn gradient(mut problem: Problem, x: &[f64], multipliers: &Multipliers) -> Vec<f64> {
    let (n, m) = (problem.n(), problem.m());
    let (mut gradient, mut jacobian) = (vec![0.0; n], vec![0.0; m * n]);
    problem.gradient(x, true, &mut gradient);
    problem.jacobian(x, true, &mut jacobian);
    for (row, lambda) in jacobian.chunks_exact(n).zip(&multipliers.constraints) {
        for (sum, derivative) in gradient.iter_mut().zip(row) {
            *sum += lambda * derivative;
        }
    }
    for (j, sum) in gradient.iter_mut().enumerate() {
        *sum += multipliers.upper[j] - multipliers.lower[j];
    }
    gradient
}

impl Residuals {
    /// Of `x` and `multipliers`, in the signs of [`contact_core::nlp`].
    pub fn at(mut problem: Problem, x: &[f64], multipliers: &Multipliers) -> Self {
        let mut g = vec![0.0; problem.m()];
        problem.constraints(x, true, &mut g);
        let mut residuals = Self {
            stationarity: 0.0,
            violation: 0.0,
            outside: 0.0,
            sign: 0.0,
            complementarity: 0.0,
        };
        for (j, derivative) in gradient(problem, x, multipliers).into_iter().enumerate() {
            let range = problem.bounds[j];
            residuals.outside = residuals.outside.max(outside(x[j], range));
            if range.0 < range.1 {
                residuals.stationarity = residuals.stationarity.max(derivative.abs());
                residuals.add(multipliers.lower[j], multipliers.upper[j], x[j], range);
            }
        }
        for (i, &value) in g.iter().enumerate() {
            let (lambda, range) = (multipliers.constraints[i], problem.g_bounds[i]);
            residuals.violation = residuals.violation.max(outside(value, range));
            // λ of an equality has either sign.
            if range.0 < range.1 {
                residuals.add((-lambda).max(0.0), lambda.max(0.0), value, range);
            }
        }
        residuals
    }

    fn add(&mut self, below: f64, above: f64, value: f64, range: Range) {
        let (sign, complementarity) = multiplier(below, above, value, range);
        self.sign = self.sign.max(sign);
        self.complementarity = self.complementarity.max(complementarity);
    }
}

/// What a solve to the tolerance τ = 1e-8 promises of the problem that is not scaled.
///
/// Ipopt scales f and each constraint down, to gradients of at most 100 at the start, and divides the residuals of
/// stationarity and complementarity by s ≥ 1, a mean of the scaled multipliers over 100, for which their maximum stands
/// here. So they are at most τ s/(scale of f), and the violation of a constraint at most τ/(its scale).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Promise {
    /// Of stationarity, signs and complementarity.
    pub dual: f64,
    /// Of the constraints.
    pub primal: f64,
}

impl Promise {
    const TOLERANCE: f64 = 1e-8;

    pub fn of(mut problem: Problem, multipliers: &Multipliers) -> Self {
        let (n, m) = (problem.n(), problem.m());
        let (mut gradient, mut jacobian) = (vec![0.0; n], vec![0.0; m * n]);
        let start = problem.start;
        problem.gradient(start, true, &mut gradient);
        problem.jacobian(start, true, &mut jacobian);
        let scale =
            |row: &[f64]| (100.0 / row.iter().fold(0.0, |a: f64, b| a.max(b.abs()))).min(1.0);
        let of_f = scale(&gradient);
        let of_g: Vec<_> = jacobian.chunks_exact(n).map(scale).collect();
        let bounds = multipliers.lower.iter().chain(&multipliers.upper).copied();
        let constraints = multipliers
            .constraints
            .iter()
            .zip(&of_g)
            .map(|(l, of_g)| l / of_g);
        let largest = bounds
            .chain(constraints)
            .fold(0.0, |a: f64, b| a.max(b.abs()))
            * of_f;
        Self {
            dual: Self::TOLERANCE * (largest / 100.0).max(1.0) / of_f,
            primal: Self::TOLERANCE / of_g.iter().copied().fold(1.0, f64::min),
        }
    }
}
