//! The tests that every law passes: conformance, and agreement with Hooke's law.

use super::conformance::{check, deformations};
use super::*;
use crate::tensor::unit_vector;

fn conforms<const D: usize>(law: &impl Material<D>) {
    let report = check(law);
    assert!(report.holds(), "{report}");
}

/// A : (a ⊗ b) of Hooke's tensor, written independently from the isotropic formula.
fn linearizes_to_hooke<const D: usize>(law: &impl Material<D>, E: f64, nu: f64) {
    let (lambda, mu) = (E * nu / (1.0 + nu) / (1.0 - 2.0 * nu), 0.5 * E / (1.0 + nu));
    let rest = Deformation::new(Matrix::identity());
    let A = law.contraction(&rest);
    for J in 0..D {
        for L in 0..D {
            let M = A(&unit_vector(J), &unit_vector(L));
            for i in 0..D {
                for k in 0..D {
                    let delta = |p: usize, q: usize| f64::from(u8::from(p == q));
                    let hooke = lambda * delta(i, J) * delta(k, L)
                        + mu * (delta(i, k) * delta(J, L) + delta(i, L) * delta(J, k));
                    assert!(
                        (M[(i, k)] - hooke).abs() < 1e-12 * (lambda + mu),
                        "{i}{J}{k}{L}"
                    );
                }
            }
        }
    }
    assert!(law.energy_density(&rest).abs() < 1e-14 * E);
    assert!(law.stress(&rest).norm() < 1e-12 * (lambda + mu));
}

/// In plane strain σ equals the in-plane part of the three-dimensional law's σ at diag(F, 1).
fn plane_strain<L: Material<2> + Material<3>>(law: &L, stiffness: f64) {
    for F in deformations::<2>() {
        let mut F3 = Matrix::<3>::identity();
        F3.fixed_view_mut::<2, 2>(0, 0).copy_from(&F);
        let (F, F3) = (Deformation::new(F), Deformation::new(F3));
        let ((sigma, zz), (sigma3, _)) = (law.cauchy_stress(&F), law.cauchy_stress(&F3));
        let in_plane = sigma3.fixed_view::<2, 2>(0, 0).into_owned();
        assert!((sigma - in_plane).norm() < 1e-12 * stiffness);
        assert!((zz - sigma3[(2, 2)]).abs() < 1e-12 * stiffness);
        assert!((law.energy_density(&F) - law.energy_density(&F3)).abs() < 1e-12 * stiffness);
    }
}

const CASES: [(f64, f64); 4] = [(1000.0, 0.0), (2.0, 0.3), (1e5, 0.4999), (7.0, -0.5)];

fn passes<L: Material<2> + Material<3>>(law: impl Fn(f64, f64) -> Result<L, Error>) {
    for (E, nu) in CASES {
        let law = law(E, nu).expect("valid");
        let lame = Lame::new(E, nu).expect("valid");
        conforms::<2>(&law);
        conforms::<3>(&law);
        linearizes_to_hooke::<2>(&law, E, nu);
        linearizes_to_hooke::<3>(&law, E, nu);
        plane_strain(&law, 10.0 * (lame.lambda.abs() + lame.mu));
    }
}

#[test]
fn neo_hookean() {
    passes(NeoHookean::new);
}

#[test]
fn st_venant_kirchhoff() {
    passes(StVenantKirchhoff::new);
}

#[test]
fn mooney_rivlin() {
    for share in [0.0, 0.3, 1.0] {
        passes(|E, nu| MooneyRivlin::new(E, nu, share));
    }
    // without the second invariant it is the neo-Hookean law
    let (law, twin) = (MooneyRivlin::new(3.0, 0.2, 0.0), NeoHookean::new(3.0, 0.2));
    let (law, twin) = (law.expect("valid"), twin.expect("valid"));
    for F in deformations::<3>() {
        let at = Deformation::new(F);
        assert!((law.stress(&at) - twin.stress(&at)).norm() < 1e-12);
    }
    for share in [-0.1, 1.1, f64::NAN] {
        assert!(MooneyRivlin::new(1.0, 0.3, share).is_err(), "{share}");
    }
}

/// Simple shear by γ: the first normal stress difference is 2 c₁ γ² + 2 c₂ γ² = μ γ², of any share, and the second one
/// −2 c₂ γ², which the neo-Hookean law lacks.
#[test]
fn the_second_normal_stress_difference() {
    let (gamma, mut F) = (0.4, Matrix::<3>::identity());
    F[(0, 1)] = gamma;
    for share in [0.0, 0.6] {
        let law = MooneyRivlin::new(2.0, 0.25, share).expect("valid");
        let (sigma, _) = law.cauchy_stress(&Deformation::new(F));
        let mu = 0.8;
        let differences = [sigma[(0, 0)] - sigma[(1, 1)], sigma[(1, 1)] - sigma[(2, 2)]];
        assert!((sigma[(0, 1)] - mu * gamma).abs() < 1e-14, "{sigma}");
        assert!(
            (differences[0] - mu * gamma * gamma).abs() < 1e-14,
            "{sigma}"
        );
        assert!(
            (differences[1] + share * mu * gamma * gamma).abs() < 1e-14,
            "{sigma}"
        );
    }
}

#[test]
fn linear_elastic() {
    passes(LinearElastic::new);
}

#[test]
fn constants_out_of_range_are_named() {
    for E in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            NeoHookean::new(E, 0.3),
            Err(Error::YoungsModulus { .. })
        ));
    }
    for nu in [0.5, 0.7, -1.0, -2.0, f64::NAN] {
        assert!(matches!(
            LinearElastic::new(1.0, nu),
            Err(Error::PoissonsRatio { .. })
        ));
    }
}

/// Volume ratios that round-off makes negative are as inadmissible as others.
#[test]
fn cells_turned_over_by_next_to_nothing_have_no_energy() {
    let law = NeoHookean::new(1.0, 0.3).expect("valid");
    for J in [0.0, -1e-300, -1e-12, -1e-9, -1.0] {
        let mut F = Matrix::<2>::identity();
        F[(1, 1)] = J;
        assert_eq!(
            law.energy_density(&Deformation::new(F)),
            f64::INFINITY,
            "{J}"
        );
    }
}

/// F⁻ᵀ Fᵀ = I, also of a mirrored cell, whose ln J is no number.
#[test]
fn the_inverse_of_a_mirrored_deformation() {
    let F = Matrix::<3>::new(0.3, 2.0, 0.1, 1.5, -0.2, 0.4, 0.7, 0.1, 1.1);
    let at = Deformation::new(F);
    assert!(at.J < 0.0 && at.ln_J.is_nan(), "{at:?}");
    assert!((at.F_inv_T * F.transpose() - Matrix::identity()).norm() < 1e-14);
}
