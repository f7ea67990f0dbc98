//! Are the problems stated as they were published, and are their derivatives those of their functions?

use contact_core::nlp::{Nlp, Pattern};
use problems::{HS071_LAMBDA, HS071_START, HS071_X, Hs071, assert_close};

use crate::{collection, problem::Problem};

/// Everything an [`Nlp`] says at a point: f, ∇f, g, ∂g/∂x, ∂²L/∂x².
#[derive(Debug)]
struct Values {
    f: f64,
    gradient: Vec<f64>,
    g: Vec<f64>,
    jacobian: Vec<f64>,
    hessian: Vec<f64>,
}

impl Values {
    fn at(nlp: &mut dyn Nlp, x: &[f64], sigma: f64, lambda: &[f64]) -> Self {
        let (n, m) = (x.len(), lambda.len());
        let mut values = Self {
            f: nlp.objective(x, true),
            gradient: vec![0.0; n],
            g: vec![0.0; m],
            jacobian: vec![0.0; m * n],
            hessian: vec![0.0; n * (n + 1) / 2],
        };
        nlp.gradient(x, false, &mut values.gradient);
        nlp.constraints(x, false, &mut values.g);
        nlp.jacobian(x, false, &mut values.jacobian);
        nlp.hessian(x, false, sigma, lambda, &mut values.hessian);
        values
    }

    /// σ ∇f + Jᵀ λ.
    fn lagrangian(&self, sigma: f64, lambda: &[f64]) -> Vec<f64> {
        let n = self.gradient.len();
        (0..n)
            .map(|j| {
                let rows = lambda.iter().zip(self.jacobian.chunks_exact(n));
                sigma * self.gradient[j] + rows.map(|(l, row)| l * row[j]).sum::<f64>()
            })
            .collect()
    }
}

#[test]
fn published_optima_belong_to_published_minimisers() {
    for &problem in collection::all() {
        assert_eq!(problem.bounds.len(), problem.n(), "{}", problem.name);
        assert!(!problem.minimisers.is_empty(), "{}", problem.name);
        for x in problem.minimisers {
            let found = Values::at(&mut { problem }, x, 1.0, &vec![0.0; problem.m()]);
            let error = (found.f - problem.optimum).abs();
            assert!(
                error <= problem.precision * problem.optimum.abs().max(1.0),
                "{}: f({x:?}) = {}, published is {}",
                problem.name,
                found.f,
                problem.optimum
            );
            assert_feasible(&problem, x, &found);
        }
    }
}

/// To what rounding the published x* to seven digits, relative to its largest, does to the constraints.
fn assert_feasible(problem: &Problem, x: &[f64], found: &Values) {
    let largest = x.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
    for (x, (lower, upper)) in x.iter().zip(problem.bounds) {
        assert!(
            (lower..=upper).contains(&x),
            "{}: {lower} ≤ {x} ≤ {upper}",
            problem.name
        );
    }
    for (i, (lower, upper)) in problem.g_bounds.iter().enumerate() {
        let row = &found.jacobian[i * x.len()..][..x.len()];
        let rounding = 1e-6 * largest * row.iter().map(|d| d.abs()).sum::<f64>();
        let violation = (lower - found.g[i]).max(found.g[i] - upper);
        assert!(
            violation <= rounding,
            "{}: constraint {i} is violated by {violation:e}",
            problem.name
        );
    }
}

#[test]
fn hyper_dual_derivatives_are_those_written_by_hand() {
    let mut problem = collection::problem("HS071");
    for x in [HS071_START, HS071_X, [1.5, 2.5, 3.5, 4.5]] {
        let by_hand = Values::at(&mut Hs071, &x, 0.7, &HS071_LAMBDA);
        let found = Values::at(&mut problem, &x, 0.7, &HS071_LAMBDA);
        assert!((found.f - by_hand.f).abs() <= 1e-13 * by_hand.f.abs());
        assert_close(&found.gradient, &by_hand.gradient, 1e-12);
        // The book subtracts the right-hand sides.
        let g: Vec<_> = found
            .g
            .iter()
            .zip([25.0, 40.0])
            .map(|(g, b)| g + b)
            .collect();
        assert_close(&g, &by_hand.g, 1e-12);
        assert_close(&found.jacobian, &by_hand.jacobian, 1e-12);
        assert_close(&found.hessian, &by_hand.hessian, 1e-12);
    }
}

#[test]
fn hyper_dual_derivatives_are_limits_of_differences() {
    for &problem in collection::all() {
        for x in [problem.start, problem.minimisers[0]] {
            compare_with_differences(problem, x);
        }
    }
}

/// Central differences of step h = 1e-5 |xⱼ|, or 1e-5 for xⱼ = 0. They are off by O(h²) = 1e-10 times third derivatives,
/// of which the largest are in the thousands, and by the round-off 1e-16 |f|/h.
fn compare_with_differences(mut problem: Problem, x: &[f64]) {
    const SIGMA: f64 = 0.7;
    let n = problem.n();
    let lambda: Vec<_> = (0..problem.m()).map(|i| 1.0 - 0.3 * i as f64).collect();
    let exact = Values::at(&mut problem, x, SIGMA, &lambda);
    let mut full = vec![0.0; n * n];
    for ((i, j), &value) in Pattern::dense_lower(n).iter().zip(&exact.hessian) {
        (full[i * n + j], full[j * n + i]) = (value, value);
    }
    let size = |values: &[f64]| values.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
    let (size_f, size_g) = (size(&exact.gradient), size(&exact.jacobian));
    // The Hessian belongs to differences of the gradient of the Lagrangian.
    let size_l = size(&full).max(size(&exact.lagrangian(SIGMA, &lambda)));
    let check = |what: &str, found: f64, difference: f64, size: f64| {
        assert!(
            (found - difference).abs() <= 1e-6 * size,
            "{}: {what} at {x:?}: {found} and by differences {difference}",
            problem.name
        );
    };
    for j in 0..n {
        let h = 1e-5 * if x[j] == 0.0 { 1.0 } else { x[j].abs() };
        let [up, down] = [h, -h].map(|h| {
            let mut x = x.to_vec();
            x[j] += h;
            Values::at(&mut { problem }, &x, SIGMA, &lambda)
        });
        let slope = |a: f64, b: f64| (a - b) / (2.0 * h);
        check("∇f", exact.gradient[j], slope(up.f, down.f), size_f);
        for i in 0..problem.m() {
            let difference = slope(up.g[i], down.g[i]);
            check("∂g/∂x", exact.jacobian[i * n + j], difference, size_g);
        }
        let (up, down) = (
            up.lagrangian(SIGMA, &lambda),
            down.lagrangian(SIGMA, &lambda),
        );
        for i in 0..n {
            check("∂²L/∂x²", full[i * n + j], slope(up[i], down[i]), size_l);
        }
    }
}
