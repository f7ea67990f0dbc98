//! Compressible law of Ogden for large strains of rubber, in principal stretches.

use super::{Deformation, Lame, Material, Volumetric};
use crate::error::Error;
use crate::tensor::{Matrix, Vector, principal_axes};

/// ψ = Σ_p μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3 − α_p ln J) + λ/2 (ln J)², and +∞ for J ≤ 0, with the principal stretches λ₁, λ₂, λ₃; in
/// plane strain the third is 1. It linearises to Hooke's law with 2μ = Σ_p μ_p α_p, so that E = (1 + ν) Σ_p μ_p α_p. One term with
/// α = 2 is [`NeoHookean`](super::NeoHookean).
///
/// The stress is a function of one matrix, P = F s(C) + λ ln J F⁻ᵀ with s(c) = Σ_p μ_p (c^(α_p/2) − 1)/c, so that its derivative is
/// made of the divided differences of s. They are computed without cancellation; equal stretches are no special case.
#[derive(Clone, Debug, PartialEq)]
pub struct Ogden {
    /// μ_p and α_p.
    terms: Vec<[f64; 2]>,
    /// λ.
    k: f64,
}

impl Ogden {
    /// From the terms [μ_p (UF/UL²), α_p] and Poisson's ratio `nu` at small strain.
    ///
    /// # Errors
    /// If there is no term, a value is not finite, an α_p is zero, or Σ μ_p α_p is not positive; and for `nu` see [`Lame::new`].
    pub fn new(terms: &[[f64; 2]], nu: f64) -> Result<Self, Error> {
        Error::check_finite("term of Ogden's law", terms.iter().flatten())?;
        if let Some([_, alpha]) = terms.iter().find(|[_, alpha]| *alpha == 0.0) {
            return Err(Error::Setting {
                name: "exponent of Ogden's law",
                value: *alpha,
                remedy: "leave the term out, or choose another exponent",
            });
        }
        let twice_mu: f64 = terms.iter().map(|[mu, alpha]| mu * alpha).sum();
        if !(twice_mu > 0.0 && twice_mu.is_finite()) {
            return Err(Error::Setting {
                name: "twice the shear modulus, the sum of the terms' products of modulus and exponent",
                value: twice_mu,
                remedy: "give terms with a positive sum; one of modulus and exponent of equal signs adds to it",
            });
        }
        let Lame { lambda, mu } = Lame::new(1.0, nu)?;
        Ok(Ogden {
            terms: terms.to_vec(),
            k: lambda / mu * 0.5 * twice_mu,
        })
    }

    /// s at the stretch exp(l).
    fn factor(&self, l: f64) -> f64 {
        let terms = self.terms.iter();
        let sum: f64 = terms.map(|[mu, alpha]| mu * (alpha * l).exp_m1()).sum();
        sum * (-2.0 * l).exp()
    }

    /// (s(c_i) − s(c_j))/(c_i − c_j) at the stretches exp(l_i), exp(l_j), or s′ where they are equal.
    fn slope(&self, l_i: f64, l_j: f64) -> f64 {
        let of_power = |gamma: f64| power_slope(gamma, l_i, l_j);
        let inverse = of_power(-1.0);
        let terms = self.terms.iter();
        terms
            .map(|[mu, alpha]| mu * (of_power(0.5 * alpha - 1.0) - inverse))
            .sum()
    }
}

/// (c_i^γ − c_j^γ)/(c_i − c_j) with c = exp(2l): with m = exp(l_i + l_j) and t = l_i − l_j it is m^(γ−1) sinh(γt)/sinh t.
fn power_slope(gamma: f64, l_i: f64, l_j: f64) -> f64 {
    let t = l_i - l_j;
    // up to t² (γ² − 1)/6
    let ratio = match t.abs() < 1e-9 {
        true => gamma,
        false => (gamma * t).sinh() / t.sinh(),
    };
    ((gamma - 1.0) * (l_i + l_j)).exp() * ratio
}

/// eˣ − 1 − x, without cancellation where x is small.
fn exp_m1_m_x(x: f64) -> f64 {
    match x.abs() < 1e-2 {
        true => {
            let tail = 1.0 + x / 4.0 * (1.0 + x / 5.0 * (1.0 + x / 6.0 * (1.0 + x / 7.0)));
            0.5 * x * x * (1.0 + x / 3.0 * tail)
        }
        false => x.exp_m1() - x,
    }
}

/// The logarithms of the principal stretches in the plane or in space, and their axes in the reference configuration.
struct Stretches<const D: usize> {
    logs: Vector<D>,
    axes: Matrix<D>,
}

impl<const D: usize> Stretches<D> {
    fn of(F: &Matrix<D>) -> Self {
        // of C − I, which keeps the digits of small strains
        let H = F - Matrix::identity();
        let (strains, axes) = principal_axes(H + H.transpose() + H.transpose() * H);
        let log = |i: usize| match strains[i] > -0.5 {
            true => 0.5 * strains[i].ln_1p(),
            // and the length of the stretched axis that of small stretches
            false => (F * axes.column(i)).norm().ln(),
        };
        Stretches {
            logs: Vector::from_fn(|i, _| log(i)),
            axes,
        }
    }
}

impl<const D: usize> Material<D> for Ogden {
    const QUADRATIC: bool = false;
    const NEEDS_POSITIVE_J: bool = true;

    fn energy_density(&self, at: &Deformation<D>) -> f64 {
        if at.J <= 0.0 {
            return f64::INFINITY;
        }
        let logs = Stretches::of(&at.F).logs;
        let term = |[mu, alpha]: &[f64; 2]| {
            let sum: f64 = logs.iter().map(|l| exp_m1_m_x(alpha * l)).sum();
            mu / alpha * sum
        };
        self.terms.iter().map(term).sum::<f64>() + 0.5 * self.k * at.ln_J * at.ln_J
    }

    fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
        let Stretches { logs, axes } = Stretches::of(&at.F);
        let s = Matrix::from_diagonal(&logs.map(|l| self.factor(l)));
        at.F * axes * s * axes.transpose() + at.F_inv_T * (self.k * at.ln_J)
    }

    fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let Stretches { logs, axes } = Stretches::of(&at.F);
        let (s, slopes) = (
            logs.map(|l| self.factor(l)),
            Matrix::<D>::from_fn(|i, j| self.slope(logs[i], logs[j])),
        );
        let (k, pressure, F_inv_T, turned) = (self.k, self.k * at.ln_J, at.F_inv_T, at.F * axes);
        move |A, B| {
            let (a, b) = (axes.tr_mul(A), axes.tr_mul(B));
            // F ds a in the turned axes, where dC is that of F moved along b
            let products = a.component_mul(&b);
            let of_strain = slopes.component_mul(&(b * a.transpose()))
                + Matrix::from_diagonal(&(slopes * products));
            let (p, q) = (F_inv_T * A, F_inv_T * B);
            Matrix::identity() * s.dot(&products)
                + turned * of_strain * turned.transpose()
                + k * p * q.transpose()
                - pressure * q * p.transpose()
        }
    }

    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
        let sigma = self.stress(at) * at.F.transpose() / at.J;
        let out_of_plane = self.k * at.ln_J / at.J;
        (sigma, if D == 2 { out_of_plane } else { 0.0 })
    }
}

impl<const D: usize> Volumetric<D> for Ogden {
    fn split(&self) -> (Self, f64) {
        let terms = self.terms.clone();
        (Ogden { terms, k: 0.0 }, self.k)
    }
}
