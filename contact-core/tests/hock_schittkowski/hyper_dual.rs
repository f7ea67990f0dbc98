//! Hyper-dual numbers: a function evaluated once on them gives its value, two directional derivatives and the mixed
//! second one, all exact but for round-off.
//!
//! a + b ε₁ + c ε₂ + d ε₁ε₂ with ε₁² = ε₂² = 0. Then φ(a + …) = φ + φ′ b ε₁ + φ′ c ε₂ + (φ′ d + φ″ b c) ε₁ε₂, so that x
//! with the directions eᵢ and eⱼ has f(x), ∂f/∂xᵢ, ∂f/∂xⱼ and ∂²f/∂xᵢ∂xⱼ for its image.

use std::{
    iter::Sum,
    ops::{Add, Div, Mul, Neg, Sub},
};

/// a + b ε₁ + c ε₂ + d ε₁ε₂.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HyperDual {
    /// a, the value.
    pub value: f64,
    /// b, the derivative along the first direction.
    pub first: f64,
    /// c, the derivative along the second direction.
    pub second: f64,
    /// d, the second derivative along both.
    pub mixed: f64,
}

impl HyperDual {
    /// A number that depends on nothing.
    pub const fn constant(value: f64) -> Self {
        Self {
            value,
            first: 0.0,
            second: 0.0,
            mixed: 0.0,
        }
    }

    /// φ(self), from φ, φ′ and φ″ at its value.
    fn apply(self, phi: f64, derivative: f64, curvature: f64) -> Self {
        Self {
            value: phi,
            first: derivative * self.first,
            second: derivative * self.second,
            mixed: derivative * self.mixed + curvature * self.first * self.second,
        }
    }

    /// Integer powers, of negative numbers too.
    pub fn powi(self, n: i32) -> Self {
        let (a, k) = (self.value, f64::from(n));
        // Where the factor is 0, the power of a = 0 may be infinite.
        let term = |factor: f64, n| {
            if factor == 0.0 {
                0.0
            } else {
                factor * a.powi(n)
            }
        };
        self.apply(a.powi(n), term(k, n - 1), term(k * (k - 1.0), n - 2))
    }

    /// Real powers of positive numbers.
    pub fn powf(self, k: f64) -> Self {
        let a = self.value;
        self.apply(
            a.powf(k),
            k * a.powf(k - 1.0),
            k * (k - 1.0) * a.powf(k - 2.0),
        )
    }

    pub fn sqrt(self) -> Self {
        self.powf(0.5)
    }

    pub fn exp(self) -> Self {
        let e = self.value.exp();
        self.apply(e, e, e)
    }

    pub fn ln(self) -> Self {
        let a = self.value;
        self.apply(a.ln(), 1.0 / a, -1.0 / (a * a))
    }

    pub fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.apply(sin, cos, -sin)
    }

    pub fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.apply(cos, -sin, -cos)
    }
}

impl Add for HyperDual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
            mixed: self.mixed + other.mixed,
        }
    }
}

impl Mul for HyperDual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.value * other.first + self.first * other.value,
            second: self.value * other.second + self.second * other.value,
            mixed: self.value * other.mixed
                + self.first * other.second
                + self.second * other.first
                + self.mixed * other.value,
        }
    }
}

impl Neg for HyperDual {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Sub for HyperDual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Div for HyperDual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.powi(-1)
    }
}

/// With a constant on either side.
macro_rules! with_constants {
    ($($operator:ident $function:ident),*) => {$(
        impl $operator<f64> for HyperDual {
            type Output = Self;
            fn $function(self, other: f64) -> Self {
                self.$function(Self::constant(other))
            }
        }

        impl $operator<HyperDual> for f64 {
            type Output = HyperDual;
            fn $function(self, other: HyperDual) -> HyperDual {
                HyperDual::constant(self).$function(other)
            }
        }
    )*};
}
with_constants!(Add add, Sub sub, Mul mul, Div div);

impl Sum for HyperDual {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::constant(0.0), Add::add)
    }
}
