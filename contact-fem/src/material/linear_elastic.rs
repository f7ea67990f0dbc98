//! Hooke's law for small strains.

use super::{Deformation, Lame, Material, Volumetric};
use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// ψ = μ ε:ε + λ/2 (tr ε)², ε = sym(F − I): linear elasticity, plane strain in 2D.
///
/// The law is not objective: it is meant for small rotations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElastic {
    lame: Lame,
}

impl LinearElastic {
    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu`.
    ///
    /// # Errors
    /// See [`Lame::new`].
    pub fn new(E: f64, nu: f64) -> Result<Self, Error> {
        Ok(LinearElastic {
            lame: Lame::new(E, nu)?,
        })
    }
}

fn strain<const D: usize>(F: &Matrix<D>) -> Matrix<D> {
    0.5 * (F + F.transpose()) - Matrix::identity()
}

impl<const D: usize> Material<D> for LinearElastic {
    const QUADRATIC: bool = true;
    const NEEDS_POSITIVE_J: bool = false;

    fn energy_density(&self, at: &Deformation<D>) -> f64 {
        let epsilon = strain(&at.F);
        self.lame.mu * epsilon.norm_squared() + 0.5 * self.lame.lambda * epsilon.trace().powi(2)
    }

    fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
        let epsilon = strain(&at.F);
        2.0 * self.lame.mu * epsilon + Matrix::identity() * (self.lame.lambda * epsilon.trace())
    }

    fn contraction(&self, _at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let Lame { lambda, mu } = self.lame;
        move |a, b| {
            Matrix::identity() * (mu * a.dot(b))
                + mu * b * a.transpose()
                + lambda * a * b.transpose()
        }
    }

    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
        let out_of_plane = self.lame.lambda * strain(&at.F).trace();
        (self.stress(at), if D == 2 { out_of_plane } else { 0.0 })
    }
}

impl<const D: usize> Volumetric<D> for LinearElastic {
    fn split(&self) -> (Self, f64) {
        let Lame { lambda, mu } = self.lame;
        let lame = Lame { lambda: 0.0, mu };
        (LinearElastic { lame }, lambda)
    }
}
