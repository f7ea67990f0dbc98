//! A check that a law satisfies the contract of [`Material`], for user-defined laws.
//!
//! Every property is measured at several deformations, and the worst value is reported. Differences
//! of stresses are divided by the largest entry of A at the deformation or at rest, whichever is
//! larger; differences of energies likewise. NaN always fails.

use std::fmt;

use super::{Deformation, Material};
use crate::tensor::{Matrix, Vector, determinant, unit_vector};

/// The properties that are checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Property {
    /// P against central differences of ψ.
    Stress,
    /// A against central differences of P.
    Tangent,
    /// A_iJkL = A_kLiJ.
    Symmetry,
    /// P = 0 at F = I.
    StressAtRest,
    /// ψ(RF) = ψ(F) and P(RF) = R P(F) for a rotation R; for a quadratic law P = 0 at F = I + W for
    /// a skew W.
    Objectivity,
    /// σ = σᵀ, and σ = P Fᵀ/(J F₃₃) unless the law is quadratic, with [`Material::thickness`] F₃₃.
    CauchyStress,
    /// A changes with F if and only if [`Material::QUADRATIC`] is not set; where it is, ψ and P use neither ln J nor F⁻ᵀ.
    QuadraticFlag,
    /// The share of states with J ≤ 0 at which ψ contradicts [`Material::NEEDS_POSITIVE_J`]: ψ must
    /// be +∞ there if the flag is set, and finite if it is not.
    PositiveJFlag,
}

/// The measurement of a property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding<const D: usize> {
    /// The property.
    pub property: Property,
    /// The worst value (dimensionless).
    pub measured: f64,
    /// The limit: an upper bound, except for the flag of a law that is not quadratic, where it is a
    /// lower bound.
    pub limit: f64,
    /// Whether the value keeps to the limit.
    pub holds: bool,
    /// The deformation with the worst value.
    pub F: Matrix<D>,
}

/// The report of [`check`]. Its `Display` is one line for each property.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Conformance<const D: usize> {
    /// All properties, whether they hold or not.
    pub findings: Vec<Finding<D>>,
}

impl<const D: usize> Conformance<D> {
    /// Whether all properties hold.
    pub fn holds(&self) -> bool {
        self.violations().next().is_none()
    }

    /// The properties that do not hold.
    pub fn violations(&self) -> impl Iterator<Item = &Finding<D>> {
        self.findings.iter().filter(|finding| !finding.holds)
    }
}

impl<const D: usize> fmt::Display for Conformance<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for finding in &self.findings {
            let Finding {
                property,
                measured,
                limit,
                holds,
                F,
            } = finding;
            let verdict = if *holds { "holds" } else { "FAILS" };
            write!(
                f,
                "{property:?} {verdict}: {measured:.1e} (limit {limit:.0e})"
            )?;
            match holds {
                true => writeln!(f)?,
                false => writeln!(f, " at F = {:?}", F.transpose().as_slice())?,
            }
        }
        Ok(())
    }
}

/// Checks a law near rest and at moderate strains, with stretches between 0.6 and 1.7.
pub fn check<const D: usize>(law: &impl Material<D>) -> Conformance<D> {
    check_at(law, &deformations())
}

/// The identity with a strain and a rotation of the size `s`.
fn mixed<const D: usize>(s: f64) -> Matrix<D> {
    Matrix::identity() + Matrix::from_fn(|i, j| s * ((1 + 3 * i + 7 * j) as f64).sin())
}

/// Deformation gradients near the identity, sheared, compressed and stretched.
pub(super) fn deformations<const D: usize>() -> Vec<Matrix<D>> {
    let I = Matrix::<D>::identity();
    let all = [mixed(0.01), mixed(0.2), mixed(-0.3), I * 0.6, I * 1.7];
    all.into_iter().filter(|F| determinant(F) > 0.05).collect()
}

/// The largest difference of P from the derivative of ψ, divided by the largest entry of P, and that of A from the derivative of P
/// likewise, at strains of about a hundredth.
pub(crate) fn slopes<const D: usize>(law: &impl Material<D>) -> [f64; 2] {
    let at = Deformation::new(mixed(0.01));
    let A = tangent(law, &at);
    let [stress, slope] = differences(law, &at, &A);
    [stress / law.stress(&at).amax(), slope / largest(&A)]
}

/// As [`check`], at deformation gradients chosen by the caller. The law must be smooth around them;
/// this serves laws that are infinite beyond some stretch.
pub fn check_at<const D: usize>(
    law: &impl Material<D>,
    deformations: &[Matrix<D>],
) -> Conformance<D> {
    let rest = Deformation::new(Matrix::identity());
    let A_rest = tangent(law, &rest);
    let mut stress = Worst::new();
    let mut slope = Worst::new();
    let mut symmetry = Worst::new();
    let mut objectivity = Worst::new();
    let mut cauchy = Worst::new();
    let mut change = Worst::new();
    for F in deformations {
        let at = Deformation::new(*F);
        let A = tangent(law, &at);
        let scale = largest(&A).max(largest(&A_rest));
        let see = |worst: &mut Worst<D>, error: f64| worst.see(error / scale, F);
        let [P_error, A_error] = differences(law, &at, &A);
        see(&mut stress, P_error);
        see(&mut slope, A_error);
        see(
            &mut symmetry,
            largest_of(D, |i, J, k, L| A[J][L][(i, k)] - A[L][J][(k, i)]),
        );
        see(&mut objectivity, spin(law, &at));
        see(&mut cauchy, cauchy_error(law, &at));
        see(
            &mut change,
            largest_of(D, |i, J, k, L| A[J][L][(i, k)] - A_rest[J][L][(i, k)]) + misuse(law, F),
        );
    }
    let mut at_rest = Worst::new();
    at_rest.see(law.stress(&rest).amax() / largest(&A_rest), &rest.F);
    let (tight, flag) = (1e-10, 1e-9);
    let quadratic = match law_is_quadratic(law) {
        true => change.at_most(Property::QuadraticFlag, flag),
        false => Finding {
            holds: change.value > flag,
            ..change.at_most(Property::QuadraticFlag, flag)
        },
    };
    Conformance {
        findings: vec![
            stress.at_most(Property::Stress, 1e-6),
            slope.at_most(Property::Tangent, 1e-6),
            symmetry.at_most(Property::Symmetry, tight),
            at_rest.at_most(Property::StressAtRest, tight),
            objectivity.at_most(Property::Objectivity, tight),
            cauchy.at_most(Property::CauchyStress, tight),
            quadratic,
            outside(law).at_most(Property::PositiveJFlag, 0.0),
        ],
    }
}

fn law_is_quadratic<const D: usize, M: Material<D>>(_: &M) -> bool {
    M::QUADRATIC
}

/// The largest value so far, with its deformation; NaN counts as larger than any number.
struct Worst<const D: usize> {
    value: f64,
    F: Matrix<D>,
}

impl<const D: usize> Worst<D> {
    /// Without any value there is no result.
    fn new() -> Self {
        Worst {
            value: f64::NEG_INFINITY,
            F: Matrix::identity(),
        }
    }

    fn see(&mut self, value: f64, F: &Matrix<D>) {
        if value.is_nan() || value > self.value {
            (self.value, self.F) = (value, *F);
        }
    }

    fn at_most(self, property: Property, limit: f64) -> Finding<D> {
        Finding {
            property,
            measured: self.value,
            limit,
            holds: self.value >= 0.0 && self.value <= limit,
            F: self.F,
        }
    }
}

/// A_iJkL as [J][L][(i, k)].
type Tangent<const D: usize> = [[Matrix<D>; D]; D];

fn tangent<const D: usize>(law: &impl Material<D>, at: &Deformation<D>) -> Tangent<D> {
    let A = law.contraction(at);
    let e = unit_vector::<D>;
    std::array::from_fn(|J| std::array::from_fn(|L| A(&e(J), &e(L))))
}

fn largest<const D: usize>(A: &Tangent<D>) -> f64 {
    largest_of(D, |i, J, k, L| A[J][L][(i, k)])
}

/// The largest magnitude over all iJkL; NaN if any entry is.
fn largest_of(D: usize, entry: impl Fn(usize, usize, usize, usize) -> f64) -> f64 {
    let all = (0..D.pow(4)).map(|n| entry(n % D, n / D % D, n / D.pow(2) % D, n / D.pow(3)));
    all.fold(0.0, |worst, x| nan_max(worst, x.abs()))
}

fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The differences of P and A from the central differences of ψ and P.
fn differences<const D: usize>(
    law: &impl Material<D>,
    at: &Deformation<D>,
    A: &Tangent<D>,
) -> [f64; 2] {
    /// The step of the central differences in F (no unit).
    const STEP: f64 = 1e-6;
    let P = law.stress(at);
    let mut errors = [0.0; 2];
    for k in 0..D {
        for L in 0..D {
            let mut step = Matrix::zeros();
            step[(k, L)] = STEP;
            let [ahead, behind] = [at.F + step, at.F - step].map(Deformation::new);
            let psi = law.energy_density(&ahead) - law.energy_density(&behind);
            let dP = (law.stress(&ahead) - law.stress(&behind)) / (2.0 * STEP);
            errors[0] = nan_max(errors[0], (P[(k, L)] - psi / (2.0 * STEP)).abs());
            let A_error = largest_of(D, |i, J, _, _| A[J][L][(i, k)] - dP[(i, J)]);
            errors[1] = nan_max(errors[1], A_error);
        }
    }
    errors
}

/// NaN if a quadratic law uses what such laws must not, ln J or F⁻ᵀ; else 0.
fn misuse<const D: usize, M: Material<D>>(law: &M, F: &Matrix<D>) -> f64 {
    if !M::QUADRATIC {
        return 0.0;
    }
    let at = Deformation::of_quadratic_law(*F);
    0.0 * (law.energy_density(&at) + law.stress(&at).sum())
}

/// The violation of objectivity.
fn spin<const D: usize, M: Material<D>>(law: &M, at: &Deformation<D>) -> f64 {
    let planes = (0..D).flat_map(|j| (0..j).map(move |i| (i, j)));
    let error = |(i, j): (usize, usize)| {
        if M::QUADRATIC {
            let mut F = Matrix::identity();
            (F[(i, j)], F[(j, i)]) = (0.1, -0.1);
            let stress = law.stress(&Deformation::new(F));
            return stress.iter().fold(0.0, |worst, x| nan_max(worst, x.abs()));
        }
        let mut R = Matrix::identity();
        let (s, c) = 0.7_f64.sin_cos();
        (R[(i, i)], R[(i, j)], R[(j, i)], R[(j, j)]) = (c, -s, s, c);
        let turned = Deformation::new(R * at.F);
        let energy = (law.energy_density(&turned) - law.energy_density(at)).abs();
        let stress = law.stress(&turned) - R * law.stress(at);
        stress
            .iter()
            .fold(energy, |worst, x| nan_max(worst, x.abs()))
    };
    planes.map(error).fold(0.0, nan_max)
}

/// The differences of σ from P Fᵀ/(J F₃₃) and from symmetry; NaN if σ_zz is not finite.
fn cauchy_error<const D: usize, M: Material<D>>(law: &M, at: &Deformation<D>) -> f64 {
    let (sigma, sigma_zz) = law.cauchy_stress(at);
    let expected = match M::QUADRATIC {
        true => sigma.transpose(),
        false => law.stress(at) * at.F.transpose() / (at.J * law.thickness(at)),
    };
    let errors = [sigma - expected, sigma - sigma.transpose()];
    let of_plane = if sigma_zz.is_finite() { 0.0 } else { f64::NAN };
    let entries = errors.iter().flat_map(|error| error.iter());
    entries.fold(of_plane, |worst, x| nan_max(worst, x.abs()))
}

/// The share of states with J ≤ 0 that contradict the flag, and one such state.
fn outside<const D: usize, M: Material<D>>(law: &M) -> Worst<D> {
    let flat = |last: f64| {
        let mut diagonal = Vector::repeat(1.0);
        diagonal[D - 1] = last;
        Matrix::from_diagonal(&diagonal)
    };
    let states = [flat(-1.0), flat(0.0), flat(-1e-3), Matrix::zeros()];
    let contradicts = |F: &&Matrix<D>| {
        let psi = law.energy_density(&Deformation::new(**F));
        match M::NEEDS_POSITIVE_J {
            true => psi != f64::INFINITY,
            false => !psi.is_finite(),
        }
    };
    let wrong: Vec<_> = states.iter().filter(contradicts).collect();
    Worst {
        value: wrong.len() as f64 / states.len() as f64,
        F: wrong.first().map_or(states[0], |F| **F),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LinearElastic, NeoHookean};
    use super::*;

    /// Faults of a law.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Fault {
        None,
        StressFactor,
        TangentFactor,
        TangentAsymmetric,
        TangentConstant,
        Fixed,
        Prestressed,
        CauchyTransposed,
        CauchyNaN,
        EnergyNaN,
        StressNaN,
        TangentNaN,
        FiniteOutside,
    }

    /// The neo-Hookean law with a fault and freely chosen flags.
    #[derive(Clone)]
    struct Planted<const Q: bool, const J: bool>(Fault);

    fn sound() -> NeoHookean {
        NeoHookean::new(1000.0, 0.3).expect("valid")
    }

    /// Springs of stiffness k between F₁₂ and its value at rest: not objective, but with consistent
    /// derivatives.
    const SPRING: f64 = 3.0;

    impl<const D: usize, const Q: bool, const J: bool> Material<D> for Planted<Q, J> {
        const QUADRATIC: bool = Q;
        const NEEDS_POSITIVE_J: bool = J;

        fn energy_density(&self, at: &Deformation<D>) -> f64 {
            let psi = sound().energy_density(at);
            match self.0 {
                Fault::Fixed => psi + 0.5 * SPRING * at.F[(0, 1)].powi(2),
                Fault::Prestressed => psi + SPRING * at.J,
                Fault::EnergyNaN if at.J > 1.5 => f64::NAN,
                Fault::FiniteOutside if at.J <= 0.0 => 1e9,
                _ => psi,
            }
        }
        fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
            let mut P = sound().stress(at);
            match self.0 {
                Fault::StressFactor => P *= 1.001,
                Fault::Fixed => P[(0, 1)] += SPRING * at.F[(0, 1)],
                Fault::Prestressed => P += SPRING * at.J * at.F_inv_T,
                Fault::StressNaN if at.J > 1.5 => P[(0, 0)] = f64::NAN,
                _ => {}
            }
            P
        }
        fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
            let (fault, at, rest) = (self.0, *at, Deformation::new(Matrix::identity()));
            move |a, b| {
                let law = sound();
                let mut M = law.contraction(&at)(a, b);
                let (x, y) = (at.F_inv_T * a, at.F_inv_T * b);
                match fault {
                    Fault::TangentFactor => M *= 1.0001,
                    Fault::TangentAsymmetric => M[(0, 1)] += a[0] * b[0],
                    Fault::TangentConstant => M = law.contraction(&rest)(a, b),
                    Fault::Fixed => M[(0, 0)] += SPRING * a[1] * b[1],
                    Fault::Prestressed => {
                        M += SPRING * at.J * (x * y.transpose() - y * x.transpose())
                    }
                    Fault::TangentNaN if at.J > 1.5 => M[(0, 0)] = f64::NAN,
                    _ => {}
                }
                M
            }
        }
        fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
            let P = self.stress(at);
            let sigma = P * at.F.transpose() / at.J;
            match self.0 {
                Fault::CauchyTransposed => (P.transpose() * at.F / at.J, 0.0),
                Fault::CauchyNaN => (sigma, f64::NAN),
                _ => (sigma, 0.0),
            }
        }
    }

    /// The linear law, whose stress has what a quadratic law must not use.
    #[derive(Clone)]
    struct Inverse(LinearElastic);

    impl<const D: usize> Material<D> for Inverse {
        const QUADRATIC: bool = true;
        const NEEDS_POSITIVE_J: bool = false;

        fn energy_density(&self, at: &Deformation<D>) -> f64 {
            self.0.energy_density(at)
        }
        fn stress(&self, at: &Deformation<D>) -> Matrix<D> {
            self.0.stress(at) + 0.0 * at.F_inv_T
        }
        fn contraction(&self, at: &Deformation<D>) -> impl Fn(&Vector<D>, &Vector<D>) -> Matrix<D> {
            self.0.contraction(at)
        }
        fn cauchy_stress(&self, at: &Deformation<D>) -> (Matrix<D>, f64) {
            self.0.cauchy_stress(at)
        }
    }

    #[test]
    fn a_quadratic_law_with_an_inverse_is_found() {
        let law = LinearElastic::new(1000.0, 0.3).expect("valid");
        let sound: Vec<Property> = violated::<3>(&law);
        let planted = violated::<3>(&Inverse(law));
        assert_eq!(sound, []);
        assert_eq!(planted, [Property::QuadraticFlag]);
    }

    fn violated<const D: usize>(law: &impl Material<D>) -> Vec<Property> {
        let report = check::<D>(law);
        let violated: Vec<_> = report
            .violations()
            .map(|finding| finding.property)
            .collect();
        assert_eq!(report.holds(), violated.is_empty());
        let text = report.to_string();
        assert_eq!(text.matches("FAILS").count(), violated.len(), "{text}");
        violated
    }

    /// Each fault is detected, and no other property fails.
    #[test]
    fn planted_faults_are_found() {
        use Property::*;
        let expected: [(Fault, &[Property]); 13] = [
            (Fault::None, &[]),
            (Fault::StressFactor, &[Stress, Tangent]),
            (Fault::TangentFactor, &[Tangent]),
            (Fault::TangentAsymmetric, &[Tangent, Symmetry]),
            (Fault::TangentConstant, &[Tangent, QuadraticFlag]),
            (Fault::Fixed, &[Objectivity, CauchyStress]),
            (Fault::Prestressed, &[StressAtRest]),
            (Fault::CauchyTransposed, &[CauchyStress]),
            (Fault::CauchyNaN, &[CauchyStress]),
            (Fault::EnergyNaN, &[Stress, Objectivity]),
            (
                Fault::StressNaN,
                &[Stress, Tangent, Objectivity, CauchyStress],
            ),
            (Fault::TangentNaN, &[Tangent, Symmetry, QuadraticFlag]),
            (Fault::FiniteOutside, &[PositiveJFlag]),
        ];
        for (fault, properties) in expected {
            let law = Planted::<false, true>(fault);
            assert_eq!(violated::<2>(&law), properties, "{fault:?}");
            assert_eq!(violated::<3>(&law), properties, "{fault:?}");
        }
    }

    #[test]
    fn wrong_flags_are_found() {
        let positive_j = Planted::<false, false>(Fault::None);
        assert_eq!(violated::<3>(&positive_j), [Property::PositiveJFlag]);
        let quadratic = Planted::<true, true>(Fault::None);
        assert!(violated::<2>(&quadratic).contains(&Property::QuadraticFlag));
    }

    #[test]
    fn nothing_checked_is_nothing_held() {
        let law = LinearElastic::new(1.0, 0.3).expect("valid");
        assert!(check::<2>(&law).holds() && !check_at::<2>(&law, &[]).holds());
    }
}
