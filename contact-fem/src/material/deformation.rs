//! The deformation at a point, with what laws need of it.

use crate::tensor::{Matrix, cofactors, determinant};

/// F with its determinant and inverse, taken once for all that a law is asked at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Deformation<const D: usize> {
    /// F = I + ∇u, the deformation gradient.
    pub F: Matrix<D>,
    /// J = det F.
    pub J: f64,
    /// F⁻ᵀ; not finite where J = 0.
    pub F_inv_T: Matrix<D>,
}

impl<const D: usize> Deformation<D> {
    /// From F.
    pub fn new(F: Matrix<D>) -> Self {
        let J = determinant(&F);
        Deformation {
            F,
            J,
            F_inv_T: cofactors(&F) / J,
        }
    }
}
