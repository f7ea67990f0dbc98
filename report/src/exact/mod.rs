//! Contact problems whose solution is known.

mod half_planes;
mod waves;
mod zone_end;

pub use half_planes::{HalfPlanes, Pair};
pub use waves::Waves;
pub use zone_end::ZoneEnd;

use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::material::{Deformation, Material};
use ipopt_contact::contact_fem::tensor::{Matrix, Vector};
use ipopt_contact::prelude::*;

use crate::norms::Jet;

/// Young's modulus (UF/UL²) and Poisson's ratio of the bodies of all fields.
const MODULI: [f64; 2] = [1000.0, 0.3];

/// A displacement of the body above the rigid plane X_D = 0 that satisfies Signorini's conditions there:
/// u_D ≥ 0, p = −σ_DD ≥ 0, u_D p = 0 and no shear.
pub trait Field<const D: usize>: Sync {
    /// u and ∇u at X.
    fn jet(&self, X: &Vector<D>) -> Jet<D>;
    /// b = −div σ at X (UF per volume).
    fn body_force(&self, X: &Vector<D>) -> Vector<D>;

    /// The body's law.
    fn law(&self) -> Result<LinearElastic, Error> {
        let [E, nu] = MODULI;
        LinearElastic::new(E, nu)
    }

    /// p = −σ_DD at X.
    fn pressure(&self, law: &LinearElastic, X: &Vector<D>) -> f64 {
        -self.stress(law, X)[(D - 1, D - 1)]
    }

    /// σ at X.
    fn stress(&self, law: &LinearElastic, X: &Vector<D>) -> Matrix<D> {
        Material::<D>::stress(law, &Deformation::new(Matrix::identity() + self.jet(X).1))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// At every point: ∇u against differences of u, b against differences of σ, and on the plane Signorini's
    /// conditions.
    pub fn battery<const D: usize>(field: &impl Field<D>, points: &[[f64; D]]) {
        const STEP: f64 = 1e-5;
        let law = field.law().expect("a law");
        let unit = |j: usize| Vector::<D>::from_fn(|i, _| if i == j { STEP } else { 0.0 });
        for X in points.iter().map(|&X| Vector::from(X)) {
            let (_, gradient) = field.jet(&X);
            let mut divergence = Vector::<D>::zeros();
            for j in 0..D {
                let (after, before) = (X + unit(j), X - unit(j));
                let slope = (field.jet(&after).0 - field.jet(&before).0) / (2.0 * STEP);
                let error = (slope - gradient.column(j)).norm();
                assert!(error < 1e-7 * gradient.norm(), "∇u at {X:?}: {error:e}");
                let change = field.stress(&law, &after) - field.stress(&law, &before);
                divergence += change.column(j) / (2.0 * STEP);
            }
            let error = (divergence + field.body_force(&X)).norm();
            let size = field.stress(&law, &X).norm() + divergence.norm();
            assert!(error < 1e-6 * size, "div σ + b at {X:?}: {error:e}");
            let mut foot = X;
            foot[D - 1] = 0.0;
            let (u, _) = field.jet(&foot);
            let sigma = field.stress(&law, &foot);
            let (gap, p, tiny) = (u[D - 1], -sigma[(D - 1, D - 1)], 1e-12 * sigma.norm());
            assert!(gap >= -1e-15 && p >= -tiny, "at {foot:?}: {gap} {p}");
            assert!(gap * p <= tiny, "complementary at {foot:?}: {gap} {p}");
            let shear = (0..D - 1)
                .map(|i| sigma[(i, D - 1)].abs())
                .fold(0.0, f64::max);
            assert!(shear <= tiny, "no shear at {foot:?}: {shear}");
        }
    }
}
