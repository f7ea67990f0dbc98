//! A problem as the book states it, and the [`Nlp`] it is for the driver.

use std::ops::Index;

use contact_core::nlp::{Bounds, Nlp, Pattern, Structure};

use crate::hyper_dual::HyperDual;

/// Variables, counted from 1 as in the book: `x[1]` to `x[n]`.
#[derive(Debug, Clone, Copy)]
pub struct X<'a>(pub &'a [HyperDual]);

impl X<'_> {
    pub fn iter(self) -> impl DoubleEndedIterator<Item = HyperDual> {
        self.0.iter().copied()
    }

    pub fn sum(self) -> HyperDual {
        self.iter().sum()
    }

    pub fn squares(self) -> HyperDual {
        self.iter().map(|x| x.powi(2)).sum()
    }

    pub fn product(self) -> HyperDual {
        self.iter().fold(HyperDual::constant(1.0), |p, x| p * x)
    }
}

impl Index<usize> for X<'_> {
    type Output = HyperDual;
    fn index(&self, i: usize) -> &HyperDual {
        &self.0[i - 1]
    }
}

/// A lower and an upper bound.
pub type Range = (f64, f64);

pub const INF: f64 = f64::INFINITY;
/// · ≥ 0, the book's inequalities.
pub const POSITIVE: Range = (0.0, INF);
/// · = 0, its equalities.
pub const ZERO: Range = (0.0, 0.0);
pub const FREE: Range = (-INF, INF);

/// min f(x) subject to bounds of x and of g(x), with what the book says of it.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// "HS" and the number in the book of 1981, or "S" and that in the book of 1987.
    pub name: &'static str,
    /// The published start.
    pub start: &'static [f64],
    /// Bounds of the variables.
    pub bounds: &'static [Range],
    pub f: fn(X<'_>) -> HyperDual,
    pub g: fn(X<'_>) -> Vec<HyperDual>,
    /// Bounds of the constraints; their number is m.
    pub g_bounds: &'static [Range],
    /// f*, published.
    pub optimum: f64,
    /// To which f* is known, relative to max(1, |f*|): its published digits where they are few.
    pub precision: f64,
    /// x*, published; all of them if there are several.
    pub minimisers: &'static [&'static [f64]],
    /// To which x* is known and comes out, relative to max(1, |x*|∞); ∞ where minimisers are not isolated.
    pub x_precision: f64,
}

/// What a problem has unless it says otherwise: no constraints, and six digits.
pub const DEFAULT: Problem = Problem {
    name: "",
    start: &[],
    bounds: &[],
    f: |_| HyperDual::constant(0.0),
    g: |_| vec![],
    g_bounds: &[],
    optimum: f64::NAN,
    precision: 1e-6,
    minimisers: &[],
    x_precision: 1e-5,
};

fn bounds(ranges: &[Range]) -> Bounds {
    let (lower, upper) = ranges.iter().copied().unzip();
    Bounds { lower, upper }
}

impl Problem {
    pub fn n(&self) -> usize {
        self.start.len()
    }

    pub fn m(&self) -> usize {
        self.g_bounds.len()
    }

    /// All entries of ∂g/∂x, and all of the lower triangle of the Hessian unless it is to be approximated.
    pub fn structure(&self, with_hessian: bool) -> Structure {
        assert_eq!(self.bounds.len(), self.n(), "{}", self.name);
        Structure::new(
            bounds(self.bounds),
            bounds(self.g_bounds),
            Pattern::dense(self.m(), self.n()),
            with_hessian.then(|| Pattern::dense_lower(self.n())),
        )
        .expect("the collection is well formed")
    }

    /// Calls `body` with x as numbers whose directions are eᵢ and eⱼ.
    fn along<T>(x: &[f64], i: usize, j: usize, body: impl FnOnce(X<'_>) -> T) -> T {
        let mut x: Vec<_> = x.iter().copied().map(HyperDual::constant).collect();
        x[i].first = 1.0;
        x[j].second = 1.0;
        body(X(&x))
    }

    fn g_along(&self, x: &[f64], i: usize, j: usize) -> Vec<HyperDual> {
        let g = Self::along(x, i, j, self.g);
        assert_eq!(g.len(), self.m(), "{}", self.name);
        g
    }
}

impl Nlp for Problem {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        Self::along(x, 0, 0, self.f).value
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        for (i, value) in gradient.iter_mut().enumerate() {
            *value = Self::along(x, i, i, self.f).first;
        }
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        for (value, g) in g.iter_mut().zip(self.g_along(x, 0, 0)) {
            *value = g.value;
        }
    }

    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        for j in 0..self.n() {
            for (i, g) in self.g_along(x, j, j).into_iter().enumerate() {
                values[i * self.n() + j] = g.first;
            }
        }
    }

    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        for (value, (i, j)) in values.iter_mut().zip(Pattern::dense_lower(self.n()).iter()) {
            let f = sigma * Self::along(x, i, j, self.f).mixed;
            let g = self.g_along(x, i, j);
            *value = f + lambda.iter().zip(g).map(|(l, g)| l * g.mixed).sum::<f64>();
        }
    }
}
