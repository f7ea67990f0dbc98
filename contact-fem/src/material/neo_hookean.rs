//! Compressible neo-Hookean law for large strains.

use super::{Deformation, Lame, Material, Volumetric};
use crate::error::Error;
use crate::tensor::{Matrix, Vector};

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

    fn energy_density(&self, at: &Deformation<D>) -> f64 {
        if at.J <= 0.0 {
            return f64::INFINITY;
        }
        // tr C − 3 = tr(FᵀF) − D in both dimensions
        0.5 * self.lame.mu * (at.F.norm_squared() - D as f64 - 2.0 * at.ln_J)
            + 0.5 * self.lame.lambda * at.ln_J * at.ln_J
    }

    fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
        let Lame { lambda, mu } = self.lame;
        mu * at.F + at.F_inv_T * (lambda * at.ln_J - mu)
    }

    fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let Lame { lambda, mu } = self.lame;
        let F_inv_T = at.F_inv_T;
        let softened = mu - lambda * at.ln_J;
        move |A, B| {
            // a = F⁻ᵀA and b = F⁻ᵀB: the reference gradients pushed forward
            let (a, b) = (F_inv_T * A, F_inv_T * B);
            Matrix::identity() * (mu * A.dot(B))
                + softened * b * a.transpose()
                + lambda * a * b.transpose()
        }
    }

    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
        let sigma = self.stress(at) * at.F.transpose() / at.J;
        let out_of_plane = self.lame.lambda * at.ln_J / at.J;
        (sigma, if D == 2 { out_of_plane } else { 0.0 })
    }
}

impl<const D: usize> Volumetric<D> for NeoHookean {
    fn split(&self) -> (Self, f64) {
        let Lame { lambda, mu } = self.lame;
        let lame = Lame { lambda: 0.0, mu };
        (NeoHookean { lame }, lambda)
    }
}
