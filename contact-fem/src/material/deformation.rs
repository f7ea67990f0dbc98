//! The deformation at a point, with the derived quantities that laws use.

use crate::tensor::{Matrix, cofactors, determinant};

/// F with its determinant and inverse transpose, computed once for all evaluations at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Deformation<const D: usize> {
    /// F = I + ∇u, the deformation gradient.
    pub F: Matrix<D>,
    /// J = det F.
    pub J: f64,
    /// ln J; not finite where J ≤ 0.
    pub ln_J: f64,
    /// F⁻ᵀ; not finite where J = 0.
    pub F_inv_T: Matrix<D>,
}

impl<const D: usize> Deformation<D> {
    /// The deformation with gradient F for a [quadratic](super::Material::QUADRATIC) law, which needs no logarithm and no inverse:
    /// they are not computed, and NaN.
    pub(crate) fn of_quadratic_law(F: Matrix<D>) -> Self {
        Deformation {
            F,
            J: determinant(&F),
            ln_J: f64::NAN,
            F_inv_T: Matrix::repeat(f64::NAN),
        }
    }

    /// The deformation with gradient F.
    pub fn new(F: Matrix<D>) -> Self {
        let J = determinant(&F);
        Deformation {
            F,
            J,
            ln_J: J.ln(),
            F_inv_T: cofactors(&F) / J,
        }
    }
}
