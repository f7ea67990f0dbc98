//! Compressible neo-Hookean law for large strains.

use super::{Lame, Material};
use crate::error::Error;
use crate::tensor::{Matrix, Vector, determinant, inverse_transpose};

/// ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)², and +∞ for J ≤ 0; in plane strain tr C counts the
/// out-of-plane 1. It linearises to Hooke's law at F = I.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    lame: Lame,
}

impl NeoHookean {
    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu` at small strain.
    ///
    /// # Errors
    /// See [`Lame::new`].
    pub fn new(E: f64, nu: f64) -> Result<Self, Error> {
        Ok(NeoHookean {
            lame: Lame::new(E, nu)?,
        })
    }
}

impl<const D: usize> Material<D> for NeoHookean {
    const QUADRATIC: bool = false;
    const NEEDS_POSITIVE_J: bool = true;

    fn energy_density(&self, F: &Matrix<D>) -> f64 {
        let J = determinant(F);
        if J <= 0.0 {
            return f64::INFINITY;
        }
        let ln_J = J.ln();
        // tr C − 3 = tr(FᵀF) − D in both dimensions
        0.5 * self.lame.mu * (F.norm_squared() - D as f64 - 2.0 * ln_J)
            + 0.5 * self.lame.lambda * ln_J * ln_J
    }

    fn stress(&self, F: &Matrix<D>) -> Matrix<D> {
        let Lame { lambda, mu } = self.lame;
        let J = determinant(F);
        mu * F + inverse_transpose(F) * (lambda * J.ln() - mu)
    }

    fn contraction(&self, F: &Matrix<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let Lame { lambda, mu } = self.lame;
        let F_inv_t = inverse_transpose(F);
        let softened = mu - lambda * determinant(F).ln();
        move |A, B| {
            // a = F⁻ᵀA and b = F⁻ᵀB: the reference gradients pushed forward
            let (a, b) = (F_inv_t * A, F_inv_t * B);
            Matrix::identity() * (mu * A.dot(B))
                + softened * b * a.transpose()
                + lambda * a * b.transpose()
        }
    }

    fn cauchy_stress(&self, F: &Matrix<D>) -> (Matrix<D>, f64) {
        let J = determinant(F);
        let sigma = self.stress(F) * F.transpose() / J;
        let out_of_plane = self.lame.lambda * J.ln() / J;
        (sigma, if D == 2 { out_of_plane } else { 0.0 })
    }
}
