//! Plane stress: thin sheets of any law.

use super::{Deformation, Material};
use crate::tensor::{Matrix, Vector, unit_vector};

/// A law of space in plane stress: ψ(F) = min over F₃₃ > 0 of ψ(diag(F, F₃₃)), where P₃₃ = 0. For sheets that are free to change their
/// thickness; forces, energies and stresses P are per unit thickness of the undeformed sheet, and contact pressures of a sheet are on
/// its undeformed thickness.
///
/// The law must be isotropic, or have the sheet's plane as a plane of symmetry: shears out of the plane are zero. F₃₃ is found at each
/// point anew, in one step for quadratic laws and by a safeguarded Newton iteration for ln F₃₃ for others; the tangent is
/// condensed, A_iJkL − A_iJ33 A_33kL / A_3333. Where P₃₃ has no zero, as in a sheet of St. Venant and Kirchhoff's law that is drawn far, or at
/// ν < 0 in one that is pressed far, ψ is +∞. A nearly incompressible sheet does not lock.
///
/// ```
/// use contact_fem::material::{Deformation, Material, PlaneStress};
/// use contact_fem::LinearElastic;
/// use contact_fem::tensor::Matrix;
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let sheet = PlaneStress(LinearElastic::new(100.0, 0.3)?);
/// // drawn along x and free along y: σ = E ε
/// let at = Deformation::new(Matrix::<2>::new(1.01, 0.0, 0.0, 1.0 - 0.3 * 0.01));
/// let P = sheet.stress(&at);
/// assert!((P[(0, 0)] - 100.0 * 0.01).abs() < 1e-12 && P[(1, 1)].abs() < 1e-12);
/// assert!((sheet.thickness(&at) - (1.0 - 0.3 * 0.01)).abs() < 1e-15);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneStress<M>(pub M);

/// diag(F, F₃₃).
fn spatial(F: &Matrix<2>, thickness: f64) -> Matrix<3> {
    let mut whole = Matrix::<3>::identity() * thickness;
    whole.fixed_view_mut::<2, 2>(0, 0).copy_from(F);
    whole
}

fn in_plane(M: &Matrix<3>) -> Matrix<2> {
    M.fixed_view::<2, 2>(0, 0).into_owned()
}

impl<M: Material<3>> PlaneStress<M> {
    /// The deformation in space at which energy and stress are taken.
    fn deformation(F: &Matrix<2>, thickness: f64) -> Deformation<3> {
        match M::QUADRATIC {
            true => Deformation::of_quadratic_law(spatial(F, thickness)),
            false => Deformation::new(spatial(F, thickness)),
        }
    }

    /// A_3333.
    fn stiffness(&self, at: &Deformation<3>) -> f64 {
        let e = unit_vector(2);
        self.0.contraction(at)(&e, &e)[(2, 2)]
    }

    /// The F₃₃ at which P₃₃ = 0; NaN if there is none.
    fn free_thickness(&self, F: &Matrix<2>) -> f64 {
        match M::QUADRATIC {
            true => {
                let P = self.0.stress(&Self::deformation(F, 1.0));
                let rest = Deformation::new(Matrix::identity());
                1.0 - P[(2, 2)] / self.stiffness(&rest)
            }
            false => self.root(F).exp(),
        }
    }

    /// The zero l = ln F₃₃ of ∂ψ/∂l = F₃₃ P₃₃.
    fn root(&self, F: &Matrix<2>) -> f64 {
        /// Newton's steps are quadratic: after one of this length the next would be round-off.
        const LAST: f64 = 1e-9;
        /// The largest magnitude of l, where thicknesses change by 1e17.
        const FARTHEST: f64 = 40.0;
        let (mut l, mut low, mut high) = (0.0_f64, f64::NEG_INFINITY, f64::INFINITY);
        for _ in 0..200 {
            let thickness = l.exp();
            let at = Self::deformation(F, thickness);
            let force = thickness * self.0.stress(&at)[(2, 2)];
            let slope = thickness * thickness * self.stiffness(&at) + force;
            if force.is_nan() || l.abs() > FARTHEST {
                return f64::NAN;
            }
            match force > 0.0 {
                true => high = l,
                false => low = l,
            }
            let newton = -force / slope;
            let inside = slope > 0.0 && l + newton >= low && l + newton <= high;
            let step = match (inside, (high - low).is_finite()) {
                (true, _) => newton.clamp(-1.0, 1.0),
                (false, true) => 0.5 * (low + high) - l,
                (false, false) => -force.signum(),
            };
            l += step;
            if (inside && step.abs() <= LAST) || high - low <= f64::EPSILON {
                return l;
            }
        }
        f64::NAN
    }

    /// The deformation in space where the sheet is free.
    fn free(&self, F: &Matrix<2>) -> Deformation<3> {
        Self::deformation(F, self.free_thickness(F))
    }

    /// The condensed tangent, [J][L][(i, k)].
    fn tangent(&self, F: &Matrix<2>) -> [[Matrix<2>; 2]; 2] {
        let at = match M::QUADRATIC {
            true => Deformation::new(Matrix::identity()),
            false => self.free(F),
        };
        let A = self.0.contraction(&at);
        let [e_1, e_2, e_3] = [0, 1, 2].map(unit_vector::<3>);
        let across = A(&e_3, &e_3)[(2, 2)];
        // A_iJ33 for all i
        let [first, second] =
            [&e_1, &e_2].map(|e_J| A(e_J, &e_3).fixed_view::<2, 1>(0, 2).into_owned());
        let condensed = |(e_J, of_J): (&Vector<3>, &Vector<2>),
                         (e_L, of_L): (&Vector<3>, &Vector<2>)| {
            in_plane(&A(e_J, e_L)) - of_J * of_L.transpose() / across
        };
        let axes = [(&e_1, &first), (&e_2, &second)];
        axes.map(|J| axes.map(|L| condensed(J, L)))
    }
}

impl<M: Material<3>> Material<2> for PlaneStress<M> {
    const QUADRATIC: bool = M::QUADRATIC;
    const NEEDS_POSITIVE_J: bool = M::NEEDS_POSITIVE_J;

    fn energy_density(&self, at: &Deformation<2>) -> f64 {
        if M::NEEDS_POSITIVE_J && at.J <= 0.0 {
            return f64::INFINITY;
        }
        let energy = self.0.energy_density(&self.free(&at.F));
        if energy.is_nan() {
            f64::INFINITY
        } else {
            energy
        }
    }

    fn stress(&self, at: &Deformation<2>) -> Matrix<2> {
        in_plane(&self.0.stress(&self.free(&at.F)))
    }

    fn contraction(&self, at: &Deformation<2>) -> impl Fn(&Vector<2>, &Vector<2>) -> Matrix<2> {
        let A = self.tangent(&at.F);
        move |a, b| {
            (A[0][0] * b[0] + A[0][1] * b[1]) * a[0] + (A[1][0] * b[0] + A[1][1] * b[1]) * a[1]
        }
    }

    /// σ of the sheet as thick as it is, and σ_zz = 0.
    fn cauchy_stress(&self, at: &Deformation<2>) -> (Matrix<2>, f64) {
        let whole = Deformation::new(spatial(&at.F, self.free_thickness(&at.F)));
        (in_plane(&self.0.cauchy_stress(&whole).0), 0.0)
    }

    fn thickness(&self, at: &Deformation<2>) -> f64 {
        self.free_thickness(&at.F)
    }
}
