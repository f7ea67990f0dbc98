//! Compressible Mooney–Rivlin law for large strains of rubber.

use super::{Deformation, Lame, Material, Volumetric};
use crate::error::Error;
use crate::tensor::{Matrix, Vector};

/// ψ = c₁ (I₁ − 3) + c₂ (I₂ − 3) − 2 (c₁ + 2 c₂) ln J + k/2 (ln J)², and +∞ for J ≤ 0, with the invariants of C = FᵀF in
/// space; in plane strain they count the out-of-plane 1. With k = λ − 4 c₂ and 2 (c₁ + c₂) = μ it linearises to Hooke's law
/// at F = I; with c₂ = 0 it is [`NeoHookean`](super::NeoHookean).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlin {
    c: [f64; 2],
    k: f64,
}

impl MooneyRivlin {
    /// From Young's modulus `E` (UF/UL²) and Poisson's ratio `nu` at small strain, and the share c₂/(c₁ + c₂) of the second
    /// invariant, 0 to 1.
    ///
    /// # Errors
    /// See [`Lame::new`]; and a share out of range.
    pub fn new(E: f64, nu: f64, share: f64) -> Result<Self, Error> {
        let Lame { lambda, mu } = Lame::new(E, nu)?;
        if !(0.0..=1.0).contains(&share) {
            return Err(Error::Setting {
                name: "share of the second invariant",
                value: share,
                remedy: "choose a number from 0, for a neo-Hookean law, to 1",
            });
        }
        let c_2 = 0.5 * mu * share;
        Ok(MooneyRivlin {
            c: [0.5 * mu - c_2, c_2],
            k: lambda - 4.0 * c_2,
        })
    }

    /// The factor of F⁻ᵀ in P.
    fn volumetric(&self, ln_J: f64) -> f64 {
        let [c_1, c_2] = self.c;
        self.k * ln_J - 2.0 * c_1 - 4.0 * c_2
    }
}

/// I₁ of C in space.
fn first_invariant<const D: usize>(F: &Matrix<D>) -> f64 {
    F.norm_squared() + (3 - D) as f64
}

impl<const D: usize> Material<D> for MooneyRivlin {
    const QUADRATIC: bool = false;
    const NEEDS_POSITIVE_J: bool = true;

    fn energy_density(&self, at: &Deformation<D>) -> f64 {
        if at.J <= 0.0 {
            return f64::INFINITY;
        }
        let [c_1, c_2] = self.c;
        // with C = I + B, so that nothing is lost where strains are small: I₁ − 3 = tr B, I₂ − 3 = 2 tr B + ½ ((tr B)² − B:B)
        let B = at.F.transpose() * at.F - Matrix::identity();
        let trace = B.trace();
        let second = 2.0 * trace + 0.5 * (trace * trace - B.norm_squared());
        c_1 * (trace - 2.0 * at.ln_J)
            + c_2 * (second - 4.0 * at.ln_J)
            + 0.5 * self.k * at.ln_J * at.ln_J
    }

    fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
        let ([c_1, c_2], F) = (self.c, &at.F);
        let C = F.transpose() * F;
        F * (2.0 * c_1 + 2.0 * c_2 * first_invariant(F)) - F * C * (2.0 * c_2)
            + at.F_inv_T * self.volumetric(at.ln_J)
    }

    fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
        let ([c_1, c_2], k) = (self.c, self.k);
        let (F, F_inv_T) = (at.F, at.F_inv_T);
        let (I_1, FFt, pressure) = (
            first_invariant(&F),
            F * F.transpose(),
            self.volumetric(at.ln_J),
        );
        move |A, B| {
            let ((a, b), AB) = ((F * A, F * B), A.dot(B));
            let of_second = Matrix::identity() * (I_1 * AB - a.dot(&b)) - FFt * AB
                + 2.0 * a * b.transpose()
                - b * a.transpose();
            let (p, q) = (F_inv_T * A, F_inv_T * B);
            Matrix::identity() * (2.0 * c_1 * AB) + of_second * (2.0 * c_2) + k * p * q.transpose()
                - pressure * q * p.transpose()
        }
    }

    fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
        let sigma = self.stress(at) * at.F.transpose() / at.J;
        let [c_1, c_2] = self.c;
        let out_of_plane =
            2.0 * c_1 + 2.0 * c_2 * (first_invariant(&at.F) - 1.0) + self.volumetric(at.ln_J);
        (sigma, if D == 2 { out_of_plane / at.J } else { 0.0 })
    }
}

impl<const D: usize> Volumetric<D> for MooneyRivlin {
    fn split(&self) -> (Self, f64) {
        (MooneyRivlin { k: 0.0, ..*self }, self.k)
    }
}
