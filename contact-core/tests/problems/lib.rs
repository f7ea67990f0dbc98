//! Problems with solutions known from elsewhere, which the tests of the driver share.

use std::ops::ControlFlow;

use contact_core::nlp::{Bounds, Iterate, Nlp, Pattern, Structure};

/// The functions of an [`Nlp`], to name one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    Objective,
    Gradient,
    Constraints,
    Jacobian,
    Hessian,
    Iterate,
}

pub const FUNCTIONS: [Function; 6] = [
    Function::Objective,
    Function::Gradient,
    Function::Constraints,
    Function::Jacobian,
    Function::Hessian,
    Function::Iterate,
];

/// Hock and Schittkowski 71: min x₀x₃(x₀+x₁+x₂) + x₂ subject to x₀x₁x₂x₃ ≥ 25, Σxᵢ² = 40, 1 ≤ x ≤ 5.
#[derive(Debug, Default)]
pub struct Hs071;

pub const HS071_START: [f64; 4] = [1.0, 5.0, 5.0, 1.0];
pub const HS071_X: [f64; 4] = [1.0, 4.742_999_63, 3.821_149_98, 1.379_408_29];
pub const HS071_OBJECTIVE: f64 = 17.014_017_3;
pub const HS071_LAMBDA: [f64; 2] = [-0.552_293_66, 0.161_468_56];
pub const HS071_LOWER: [f64; 4] = [1.087_871_2, 0.0, 0.0, 0.0];

pub fn hs071_structure() -> Structure {
    Structure::new(
        Bounds::uniform(4, 1.0, 5.0),
        Bounds {
            lower: vec![25.0, 40.0],
            upper: vec![f64::INFINITY, 40.0],
        },
        Pattern::dense(2, 4),
        Some(Pattern::dense_lower(4)),
    )
    .expect("HS071 is well formed")
}

/// A solver for [`Hs071`] with the default options, a macro because this crate is built without Ipopt.
#[macro_export]
macro_rules! hs071_solver {
    () => {
        ::contact_core::ipopt::Solver::new(
            $crate::hs071_structure(),
            &::contact_core::ipopt::Options::new(),
        )
        .expect("the defaults are valid")
    };
}

impl Nlp for Hs071 {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2]
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = x[3] * (2.0 * x[0] + x[1] + x[2]);
        gradient[1] = x[0] * x[3];
        gradient[2] = x[0] * x[3] + 1.0;
        gradient[3] = x[0] * (x[0] + x[1] + x[2]);
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = x.iter().product();
        g[1] = x.iter().map(|x| x * x).sum();
    }

    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        for i in 0..4 {
            values[i] = (0..4).filter(|&j| j != i).map(|j| x[j]).product();
            values[4 + i] = 2.0 * x[i];
        }
    }

    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        let second = [
            [2.0 * x[3], x[3], x[3], 2.0 * x[0] + x[1] + x[2]],
            [0.0, 0.0, 0.0, x[0]],
            [0.0, 0.0, 0.0, x[0]],
            [0.0; 4],
        ];
        for (value, (i, j)) in values.iter_mut().zip(Pattern::dense_lower(4).iter()) {
            let product: f64 = (0..4).filter(|&k| k != i && k != j).map(|k| x[k]).product();
            let constraints = if i == j {
                2.0 * lambda[1]
            } else {
                lambda[0] * product
            };
            *value = sigma * second[j][i] + constraints;
        }
    }
}

/// min ½ Σ aᵢ (xᵢ − cᵢ)², bounds only: the solution is c, clamped.
#[derive(Debug, Clone)]
pub struct Separable {
    pub weights: Vec<f64>,
    pub centre: Vec<f64>,
}

impl Separable {
    pub fn new(centre: &[f64]) -> Self {
        Self {
            weights: vec![1.0; centre.len()],
            centre: centre.to_vec(),
        }
    }

    pub fn structure(bounds: Bounds) -> Structure {
        let n = bounds.len();
        Structure::new(
            bounds,
            Bounds::default(),
            Pattern::empty(),
            Some(Pattern::diagonal(n)),
        )
        .expect("well formed")
        .with_constant_hessian(true)
    }
}

impl Nlp for Separable {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x.iter()
            .zip(&self.centre)
            .zip(&self.weights)
            .map(|((x, c), a)| 0.5 * a * (x - c).powi(2))
            .sum()
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        for (i, value) in gradient.iter_mut().enumerate() {
            *value = self.weights[i] * (x[i] - self.centre[i]);
        }
    }

    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {
        panic!("there are no constraints");
    }

    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {
        panic!("there are no constraints");
    }

    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        for (value, a) in values.iter_mut().zip(&self.weights) {
            *value = sigma * a;
        }
    }
}

/// A string of n points between two ends, loaded downwards, above a floor: min ½ uᵀTu/h + h load Σ u subject to
/// u ≥ floor as constraints, with T the second difference and h = 1/(n + 1).
#[derive(Debug, Clone)]
pub struct Obstacle {
    pub n: usize,
    pub load: f64,
}

impl Obstacle {
    pub fn structure(n: usize, floor: f64) -> Structure {
        let hessian = (0..n)
            .flat_map(|i| [(i, i.saturating_sub(1)), (i, i)])
            .skip(1)
            .collect();
        Structure::new(
            Bounds::free(n),
            Bounds::uniform(n, floor, f64::INFINITY),
            Pattern::diagonal(n),
            Some(hessian),
        )
        .expect("well formed")
        .with_constant_hessian(true)
        .with_constant_jacobian(true)
    }

    /// Where the string has no floor: u(s) = −load s (1 − s) / 2, exactly at the points too.
    pub fn free(&self) -> impl Iterator<Item = f64> + '_ {
        let h = 1.0 / self.intervals();
        (1..=self.n)
            .map(move |i| i as f64 * h)
            .map(|s| -self.load * s * (1.0 - s) / 2.0)
    }

    fn intervals(&self) -> f64 {
        self.n as f64 + 1.0
    }

    fn residual(&self, x: &[f64], i: usize) -> f64 {
        let at = |i: Option<usize>| i.and_then(|i| x.get(i)).copied().unwrap_or(0.0);
        (2.0 * x[i] - at(i.checked_sub(1)) - at(Some(i + 1))) * self.intervals()
    }

    fn force(&self) -> f64 {
        self.load / self.intervals()
    }
}

impl Nlp for Obstacle {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (0..self.n)
            .map(|i| x[i] * (0.5 * self.residual(x, i) + self.force()))
            .sum()
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        for (i, value) in gradient.iter_mut().enumerate() {
            *value = self.residual(x, i) + self.force();
        }
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g.copy_from_slice(x);
    }

    fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
        values.fill(1.0);
    }

    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        for (i, value) in values.iter_mut().enumerate() {
            *value = sigma * self.intervals() * if i % 2 == 0 { 2.0 } else { -1.0 };
        }
    }
}

/// Wächter and Biegler's problem, on which a line search without restoration fails: min x₀ subject to
/// x₀² − x₁ − 1 = 0, x₀ − x₂ − ½ = 0, x₁, x₂ ≥ 0. The solution is (1, 0, ½).
#[derive(Debug)]
pub struct WaechterBiegler;

impl WaechterBiegler {
    pub const START: [f64; 4] = [-2.0, 3.0, 1.0, 7.0];

    /// With a fourth variable fixed at 7, so that the numberings differ, and the constants as right-hand sides.
    pub fn structure() -> Structure {
        Structure::new(
            Bounds {
                lower: vec![f64::NEG_INFINITY, 0.0, 0.0, 7.0],
                upper: vec![f64::INFINITY, f64::INFINITY, f64::INFINITY, 7.0],
            },
            Bounds {
                lower: vec![1.0, 0.5],
                upper: vec![1.0, 0.5],
            },
            [(0, 0), (0, 1), (1, 0), (1, 2)].into_iter().collect(),
            Some([(0, 0)].into_iter().collect()),
        )
        .expect("well formed")
    }
}

impl Nlp for WaechterBiegler {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x[0]
    }

    fn gradient(&mut self, _: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = 1.0;
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = x[0] * x[0] - x[1];
        g[1] = x[0] - x[2];
    }

    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values.copy_from_slice(&[2.0 * x[0], -1.0, 1.0, -1.0]);
    }

    fn hessian(&mut self, _: &[f64], _: bool, _: f64, lambda: &[f64], values: &mut [f64]) {
        values[0] = 2.0 * lambda[0];
    }
}

/// Another problem, with something done before each call.
pub struct Watched<N, F> {
    pub nlp: N,
    /// Called first; whatever it does to the outputs of the function is up to `spoil`.
    pub before: F,
    /// The function whose outputs become NaN.
    pub spoil: Option<Function>,
}

impl<N: Nlp, F: FnMut(Function) -> ControlFlow<()>> Watched<N, F> {
    pub fn new(nlp: N, before: F) -> Self {
        Self {
            nlp,
            before,
            spoil: None,
        }
    }

    fn finish(&self, function: Function, values: &mut [f64]) {
        if self.spoil == Some(function) {
            let last = values.len() - 1;
            values[last] = f64::NAN;
        }
    }
}

impl<N: Nlp, F: FnMut(Function) -> ControlFlow<()>> Nlp for Watched<N, F> {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        let _ = (self.before)(Function::Objective);
        let mut value = [self.nlp.objective(x, new_x)];
        self.finish(Function::Objective, &mut value);
        value[0]
    }

    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        let _ = (self.before)(Function::Gradient);
        self.nlp.gradient(x, new_x, gradient);
        self.finish(Function::Gradient, gradient);
    }

    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        let _ = (self.before)(Function::Constraints);
        self.nlp.constraints(x, new_x, g);
        self.finish(Function::Constraints, g);
    }

    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        let _ = (self.before)(Function::Jacobian);
        self.nlp.jacobian(x, new_x, values);
        self.finish(Function::Jacobian, values);
    }

    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        let _ = (self.before)(Function::Hessian);
        self.nlp.hessian(x, new_x, sigma, lambda, values);
        self.finish(Function::Hessian, values);
    }

    fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
        (self.before)(Function::Iterate)?;
        self.nlp.iterate(iterate)
    }
}

#[track_caller]
pub fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?} and {expected:?}");
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= tolerance,
            "[{i}]: {a} is not {b} to {tolerance:e}"
        );
    }
}
