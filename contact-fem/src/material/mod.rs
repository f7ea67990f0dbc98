//! Hyperelastic laws, one a file, all under one battery of tests.

#[cfg(test)]
mod battery;
mod linear_elastic;
mod neo_hookean;

pub use linear_elastic::LinearElastic;
pub use neo_hookean::NeoHookean;

use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// A hyperelastic law ψ(F); in the plane, plane strain.
///
/// Instead of the fourth-order tensor A = ∂²ψ/∂F², a law gives its contraction with two vectors,
/// which is what a pair of nodes needs: D² numbers, K_ab = ∫ A : (∇N_a ⊗ ∇N_b).
pub trait Material<const D: usize>: Clone + Send + Sync + 'static {
    /// ψ(F) (UF/UL²), `+∞` outside the law's domain.
    fn energy_density(&self, F: &Matrix<D>) -> f64;
    /// P = ∂ψ/∂F, first Piola–Kirchhoff stress (UF/UL²).
    fn stress(&self, F: &Matrix<D>) -> Matrix<D>;
    /// (a, b) ↦ M with M_ik = A_iJkL a_J b_L (UF/UL² times the units of a and b).
    fn contraction(&self, F: &Matrix<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D>;
    /// Whether ψ is quadratic in ∇u, so that A does not depend on F.
    const QUADRATIC: bool;
    /// Whether ψ = +∞ for J ≤ 0.
    const NEEDS_POSITIVE_J: bool;
    /// Cauchy stress σ at F (UF/UL²) with its out-of-plane component σ_zz in the plane; in space
    /// the second value is zero and meaningless.
    fn cauchy_stress(&self, F: &Matrix<D>) -> (Matrix<D>, f64);
}

/// Lamé's constants (UF/UL²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// λ = Eν / ((1 + ν)(1 − 2ν)).
    pub lambda: f64,
    /// μ = E / (2 (1 + ν)).
    pub mu: f64,
}

impl Lame {
    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu`.
    ///
    /// # Errors
    /// `E` not positive and finite; `nu` not strictly between −1 and 0.5.
    pub fn new(E: f64, nu: f64) -> Result<Self, Error> {
        if !(E > 0.0 && E.is_finite()) {
            return Err(Error::YoungsModulus { E });
        }
        if !(nu > -1.0 && nu < 0.5) {
            return Err(Error::PoissonsRatio { nu });
        }
        Ok(Lame {
            lambda: E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            mu: E / (2.0 * (1.0 + nu)),
        })
    }
}
