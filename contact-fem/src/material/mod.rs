//! Hyperelastic laws, one in each file. All pass one battery of tests; its part for arbitrary laws
//! is [`conformance`].

#[cfg(test)]
mod battery;
pub mod conformance;
mod deformation;
mod linear_elastic;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod plane_stress;
mod st_venant_kirchhoff;

pub use deformation::Deformation;
pub use linear_elastic::LinearElastic;
pub use mooney_rivlin::MooneyRivlin;
pub use neo_hookean::NeoHookean;
pub use ogden::Ogden;
pub use plane_stress::PlaneStress;
pub use st_venant_kirchhoff::StVenantKirchhoff;

use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// A hyperelastic law ψ(F); in the plane, plane strain, or plane stress by [`PlaneStress`].
///
/// Instead of the fourth-order tensor A = ∂²ψ/∂F², a law provides its contraction with two vectors.
/// A pair of nodes needs only these D² numbers: K_ab = ∫ A : (∇N_a ⊗ ∇N_b). [`conformance::check`]
/// tests a user-defined law:
///
/// ```
/// use contact_fem::material::{Deformation, Lame, Material, conformance};
/// use contact_fem::tensor::{Matrix, Vector};
///
/// /// St. Venant–Kirchhoff: ψ = λ/2 (tr E)² + μ E:E with E = ½ (FᵀF − I).
/// #[derive(Clone)]
/// struct StVenantKirchhoff(Lame);
///
/// fn strain<const D: usize>(F: &Matrix<D>) -> Matrix<D> {
///     0.5 * (F.transpose() * F - Matrix::identity())
/// }
///
/// impl<const D: usize> Material<D> for StVenantKirchhoff {
///     const QUADRATIC: bool = false;
///     const NEEDS_POSITIVE_J: bool = false;
///
///     fn energy_density(&self, at: &Deformation<D>) -> f64 {
///         let E = strain(&at.F);
///         0.5 * self.0.lambda * E.trace().powi(2) + self.0.mu * E.norm_squared()
///     }
///     fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
///         let E = strain(&at.F);
///         at.F * (Matrix::identity() * (self.0.lambda * E.trace()) + 2.0 * self.0.mu * E)
///     }
///     fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
///         let (Lame { lambda, mu }, F) = (self.0, at.F);
///         let S = at.F_inv_T.transpose() * self.stress(at);
///         move |a, b| {
///             Matrix::identity() * a.dot(&(S * b))
///                 + lambda * (F * a) * (F * b).transpose()
///                 + mu * ((F * b) * (F * a).transpose() + F * F.transpose() * a.dot(b))
///         }
///     }
///     fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
///         let out_of_plane = self.0.lambda * strain(&at.F).trace() / at.J;
///         let sigma = self.stress(at) * at.F.transpose() / at.J;
///         (sigma, if D == 2 { out_of_plane } else { 0.0 })
///     }
/// }
///
/// let law = StVenantKirchhoff(Lame::new(210.0, 0.3)?);
/// let report = conformance::check::<3>(&law);
/// assert!(report.holds(), "{report}");
/// // stretched by s in one direction and held in the others: P₁₁ = s (λ + 2μ) (s² − 1) / 2
/// let (s, mut F) = (1.2, Matrix::<3>::identity());
/// F[(0, 0)] = s;
/// let by_hand = s * (law.0.lambda + 2.0 * law.0.mu) * (s * s - 1.0) / 2.0;
/// assert!((law.stress(&Deformation::new(F))[(0, 0)] - by_hand).abs() < 1e-12 * by_hand);
/// # Ok::<(), contact_fem::Error>(())
/// ```
pub trait Material<const D: usize>: Clone + Send + Sync + 'static {
    /// ψ(F) (UF/UL²), `+∞` outside the law's domain.
    fn energy_density(&self, at: &Deformation<D>) -> f64;
    /// P = ∂ψ/∂F, first Piola–Kirchhoff stress (UF/UL²).
    fn stress(&self, at: &Deformation<D>) -> Matrix<D>;
    /// The map (a, b) ↦ M with M_ik = A_iJkL a_J b_L (UF/UL² times the units of a and b).
    fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D>;
    /// Whether ψ is quadratic in ∇u, so that A does not depend on F. Such a law must not use [`Deformation::ln_J`] and
    /// [`Deformation::F_inv_T`] for its energy and stress, where they may be NaN.
    const QUADRATIC: bool;
    /// Whether ψ = +∞ for J ≤ 0.
    const NEEDS_POSITIVE_J: bool;
    /// Cauchy stress σ at F (UF/UL²), and in the plane its out-of-plane component σ_zz; in space
    /// the second value is zero and has no meaning.
    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64);
    /// F₃₃, by which a plane body's thickness changes: σ = P Fᵀ/(J F₃₃). It is 1 in plane strain, and in space.
    fn thickness(&self, _at: &Deformation<D>) -> f64 {
        1.0
    }
}

/// A law ψ = ψ₀ + k/2 θ² with a part that depends on the change of volume alone: θ = ln J, or tr ∇u if the law is quadratic.
pub trait Volumetric<const D: usize>: Material<D> {
    /// ψ₀, and k (UF/UL²).
    fn split(&self) -> (Self, f64);
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
    /// The largest ratio of the bulk modulus K and the shear modulus, either to the other: the stress of the stiffer one
    /// has a relative round-off of 2⁻⁵², which is 1e-6 of the softer one's stress at the same strain.
    pub const MOST_APART: f64 = 1e-6 / f64::EPSILON;

    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu`.
    ///
    /// # Errors
    /// If `E` is not between 1e-100 and 1e100, beyond which products of numbers of a scene overflow or vanish, or `nu` is not strictly between −1 and 0.5, or so close to one of them that the moduli are
    /// further apart than [`Lame::MOST_APART`].
    pub fn new(E: f64, nu: f64) -> Result<Self, Error> {
        if !(1e-100..=1e100).contains(&E) {
            return Err(Error::YoungsModulus { E });
        }
        if !(nu > -1.0 && nu < 0.5) {
            return Err(Error::PoissonsRatio { nu });
        }
        let ratio = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
        let ratio = ratio.max(ratio.recip());
        if ratio > Self::MOST_APART {
            return Err(Error::ModuliApart { nu, ratio });
        }
        Ok(Lame {
            lambda: E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            mu: E / (2.0 * (1.0 + nu)),
        })
    }
}
