//! St. Venant–Kirchhoff's law: Hooke's law between Green's strain and the second Piola–Kirchhoff stress.

use super::{Deformation, Lame, Material};
use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// ψ = λ/2 (tr E)² + μ E:E with E = ½ (FᵀF − I). For large rotations at small strains: it is invariant under rotations, but
/// softens where it is compressed, and does not keep a cell from being turned over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff {
    lame: Lame,
}

impl StVenantKirchhoff {
    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu` at small strain.
    ///
    /// # Errors
    /// See [`Lame::new`].
    pub fn new(E: f64, nu: f64) -> Result<Self, Error> {
        Ok(StVenantKirchhoff {
            lame: Lame::new(E, nu)?,
        })
    }

    /// The second Piola–Kirchhoff stress.
    fn second_stress<const D: usize>(&self, F: &Matrix<D>) -> Matrix<D> {
        let E = strain(F);
        Matrix::identity() * (self.lame.lambda * E.trace()) + 2.0 * self.lame.mu * E
    }
}

/// Green's strain.
fn strain<const D: usize>(F: &Matrix<D>) -> Matrix<D> {
    0.5 * (F.transpose() * F - Matrix::identity())
}

impl<const D: usize> Material<D> for StVenantKirchhoff {
    const QUADRATIC: bool = false;
    const NEEDS_POSITIVE_J: bool = false;

    fn energy_density(&self, at: &Deformation<D>) -> f64 {
        let E = strain(&at.F);
        0.5 * self.lame.lambda * E.trace().powi(2) + self.lame.mu * E.norm_squared()
    }

    fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
        at.F * self.second_stress(&at.F)
    }

    fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let (Lame { lambda, mu }, F, S) = (self.lame, at.F, self.second_stress(&at.F));
        let FFt = F * F.transpose();
        move |A, B| {
            let (a, b) = (F * A, F * B);
            Matrix::identity() * A.dot(&(S * B))
                + lambda * a * b.transpose()
                + mu * (b * a.transpose() + FFt * A.dot(B))
        }
    }

    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
        let out_of_plane = self.lame.lambda * strain(&at.F).trace() / at.J;
        let sigma = self.stress(at) * at.F.transpose() / at.J;
        (sigma, if D == 2 { out_of_plane } else { 0.0 })
    }
}
