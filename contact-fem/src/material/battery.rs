//! The tests that every law passes: conformance, and agreement with Hooke's law.

use super::conformance::{check, deformations};
use super::*;
use crate::tensor::{determinant, unit_vector};

fn conforms<const D: usize>(law: &impl Material<D>) {
    let report = check(law);
    assert!(report.holds(), "{report}");
}

/// A : (a ⊗ b) of Hooke's tensor, written independently from the isotropic formula.
fn linearizes_to_hooke<const D: usize>(law: &impl Material<D>, E: f64, nu: f64) {
    let (lambda, mu) = (E * nu / (1.0 + nu) / (1.0 - 2.0 * nu), 0.5 * E / (1.0 + nu));
    linearizes_to(law, lambda, mu);
}

fn linearizes_to<const D: usize>(law: &impl Material<D>, lambda: f64, mu: f64) {
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
    assert!(law.energy_density(&rest).abs() < 1e-14 * mu);
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

/// Terms [μ_p, α_p] with 2μ = E/(1 + ν), of which each has a share.
fn ogden(E: f64, nu: f64, shares: &[[f64; 2]]) -> Result<Ogden, Error> {
    let terms = shares
        .iter()
        .map(|[share, alpha]| [share * E / (1.0 + nu) / alpha, *alpha]);
    Ogden::new(&terms.collect::<Vec<_>>(), nu)
}

#[test]
fn ogden_with_one_to_three_terms() {
    let three: &[[f64; 2]] = &[[0.9, 1.3], [0.06, 5.0], [0.04, -2.0]];
    for shares in [&[[1.0, 2.0]], &[[1.0, -3.0]], three] {
        passes(|E, nu| ogden(E, nu, shares));
    }
    let close = coincident();
    for alpha in [-4.0, -2.0, 0.5, 1.0, 2.0, 5.0] {
        let report =
            conformance::check_at(&ogden(2.0, 0.3, &[[1.0, alpha]]).expect("a law"), &close);
        assert!(report.holds(), "α = {alpha}: {report}");
    }
    for (terms, nu) in [
        (&[][..], 0.3),
        (&[[1.0, 0.0]], 0.3),
        (&[[-1.0, 2.0]], 0.3),
        (&[[1.0, f64::NAN]], 0.3),
        (&[[1.0, 2.0]], 0.5),
    ] {
        assert!(Ogden::new(terms, nu).is_err(), "{terms:?}, {nu}");
    }
}

/// Turned deformations of which two or three stretches are equal, or apart by 1e-15 … 1e-3.
fn coincident() -> Vec<Matrix<3>> {
    let turn = |angles: [f64; 3]| {
        let [x, y, z] = angles;
        nalgebra::Rotation3::from_euler_angles(x, y, z).into_inner()
    };
    let (R, Q) = (turn([0.4, -1.0, 2.2]), turn([1.3, 0.2, -0.7]));
    let apart = [0.0, 1e-15, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3];
    let stretches = apart.iter().flat_map(|d| {
        let three = [1.3, 1.3 + d, 1.3 - 2.0 * d];
        [three, [0.7, 1.4, 1.4 + d], [1.0, 1.0 + d, 1.0 - d]]
    });
    stretches
        .map(|l| R * Matrix::from_diagonal(&Vector::from(l)) * Q)
        .collect()
}

/// The largest difference of the tangents of two laws.
fn tangents_apart(first: &impl Material<3>, second: &impl Material<3>, F: &Matrix<3>) -> f64 {
    let at = Deformation::new(*F);
    let (A, B) = (first.contraction(&at), second.contraction(&at));
    let pairs = (0..9).map(|n| (unit_vector(n / 3), unit_vector(n % 3)));
    pairs
        .map(|(a, b)| (A(&a, &b) - B(&a, &b)).amax())
        .fold(0.0, f64::max)
}

/// α = 2 is the neo-Hookean law, and α = 4 has the closed form P = μ_p F C + (λ ln J − μ_p) F⁻ᵀ. No digit is lost where stretches
/// coincide, or almost do.
#[test]
fn ogden_where_stretches_coincide() {
    let (E, nu) = (2.6, 0.3);
    let (mu, lambda) = (1.0, 1.5);
    let twin = NeoHookean::new(E, nu).expect("a law");
    let two = ogden(E, nu, &[[1.0, 2.0]]).expect("a law");
    let four = Ogden::new(&[[0.5 * mu, 4.0]], nu).expect("a law");
    for F in coincident().into_iter().chain(deformations()) {
        let at = Deformation::new(F);
        let stress = (two.stress(&at) - twin.stress(&at)).amax();
        let tangent = tangents_apart(&two, &twin, &F);
        assert!(
            stress.max(tangent) < 5e-14,
            "{stress:e}, {tangent:e} at {F}"
        );

        let (C, mu_4) = (F.transpose() * F, 0.5 * mu);
        let pressure = lambda * at.ln_J - mu_4;
        let stress = four.stress(&at) - mu_4 * F * C - pressure * at.F_inv_T;
        let A = four.contraction(&at);
        let mut tangent = 0.0_f64;
        for (A_J, A_L) in (0..9).map(|n| (unit_vector(n / 3), unit_vector(n % 3))) {
            let (a, b, p, q) = (F * A_J, F * A_L, at.F_inv_T * A_J, at.F_inv_T * A_L);
            let exact = mu_4
                * (Matrix::identity() * A_J.dot(&(C * A_L))
                    + b * a.transpose()
                    + F * F.transpose() * A_J.dot(&A_L))
                + lambda * p * q.transpose()
                - pressure * q * p.transpose();
            tangent = tangent.max((A(&A_J, &A_L) - exact).amax());
        }
        assert!(
            stress.amax().max(tangent) < 1e-13,
            "{stress}, {tangent:e} at {F}"
        );
    }
}

/// At J = 1 the terms 2 and −2 have the deviator of Mooney–Rivlin's law.
#[test]
fn ogden_of_mooney_and_rivlin() {
    let law = ogden(3.0, 0.3, &[[0.7, 2.0], [0.3, -2.0]]).expect("a law");
    let twin = MooneyRivlin::new(3.0, 0.3, 0.3).expect("a law");
    for F in coincident().into_iter().chain(deformations()) {
        let at = Deformation::new(F / determinant(&F).cbrt());
        let (first, second) = (law.cauchy_stress(&at).0, twin.cauchy_stress(&at).0);
        let apart = first - second;
        let apart = apart - Matrix::identity() * (apart.trace() / 3.0);
        assert!(apart.norm() < 1e-13, "{apart}");
    }
}

/// σ_i = (Σ_p μ_p (λ_i^α_p − 1) + λ ln J)/J, also where one stretch is a ten-thousandth of another; and at small strains the energy
/// is Hooke's to the strain's own digits.
#[test]
fn ogden_at_large_and_at_small_strains() {
    let terms = [[0.4, 1.3], [0.01, 5.0], [-0.02, -2.0]];
    let law = Ogden::new(&terms, 0.3).expect("a law");
    let twice_mu: f64 = terms.iter().map(|[mu, alpha]| mu * alpha).sum();
    let lambda = 0.75 * twice_mu;
    let turn = *nalgebra::Rotation3::from_euler_angles(0.4, -1.0, 2.2).matrix();
    for stretches in [[1.5, 0.8, 1.1], [0.02, 7.0, 7.0], [2e-3, 20.0, 3.0]] {
        let F = turn * Matrix::from_diagonal(&Vector::from(stretches)) * turn.transpose();
        let J: f64 = stretches.iter().product();
        let (sigma, _) = law.cauchy_stress(&Deformation::new(F));
        let principal = turn.transpose() * sigma * turn;
        let by_hand = stretches.map(|l: f64| {
            let own = terms.iter().map(|[mu, alpha]| mu * (l.powf(*alpha) - 1.0));
            (own.sum::<f64>() + lambda * J.ln()) / J
        });
        let apart = principal - Matrix::from_diagonal(&Vector::from(by_hand));
        assert!(
            apart.amax() < 1e-10 * principal.amax(),
            "{apart} of {principal}"
        );
    }
    let strain = Matrix::<3>::new(3.0, 1.0, -2.0, 1.0, -1.0, 0.5, -2.0, 0.5, 2.0) * 1e-9;
    let hooke = 0.5 * lambda * strain.trace().powi(2) + 0.5 * twice_mu * strain.norm_squared();
    let energy = law.energy_density(&Deformation::new(Matrix::identity() + strain));
    assert!((energy / hooke - 1.0).abs() < 1e-6, "{energy:e}, {hooke:e}");
}

/// A sheet of a law: the battery, plane-stress Hooke's law at rest, and P₃₃ = 0 in space.
fn sheet<L: Material<3>>(law: L, E: f64, nu: f64) {
    let sheet = PlaneStress(law.clone());
    let report = conformance::check(&sheet);
    assert!(report.holds(), "{report}");
    linearizes_to(&sheet, E * nu / (1.0 - nu * nu), 0.5 * E / (1.0 + nu));
    for F in deformations::<2>() {
        let at = Deformation::new(F);
        let mut whole = Matrix::<3>::identity() * sheet.thickness(&at);
        whole.fixed_view_mut::<2, 2>(0, 0).copy_from(&F);
        let whole = Deformation::new(whole);
        let P = law.stress(&whole);
        let stiffness = law.contraction(&whole)(&unit_vector(2), &unit_vector(2)).amax();
        assert!(P[(2, 2)].abs() < 1e-13 * stiffness, "{P}");
        let apart = sheet.stress(&at) - P.fixed_view::<2, 2>(0, 0);
        assert!(apart.norm() < 1e-13 * stiffness, "{apart}");
        let (sigma, zz) = sheet.cauchy_stress(&at);
        let apart = sigma - law.cauchy_stress(&whole).0.fixed_view::<2, 2>(0, 0);
        assert!(apart.norm() < 1e-13 * stiffness && zz == 0.0, "{apart}");
    }
}

#[test]
fn plane_stress() {
    for (E, nu) in CASES {
        sheet(LinearElastic::new(E, nu).expect("valid"), E, nu);
        // where λ < 0, the energy of pressed sheets falls without end as they get thinner: there is no free thickness
        if nu >= 0.0 {
            let ogden = ogden(E, nu, &[[0.9, 1.3], [0.1, -2.0]]);
            sheet(NeoHookean::new(E, nu).expect("valid"), E, nu);
            sheet(MooneyRivlin::new(E, nu, 0.2).expect("valid"), E, nu);
            sheet(ogden.expect("valid"), E, nu);
        }
    }
    // St. Venant and Kirchhoff's: E₃₃ = −λ (E₁₁ + E₂₂)/(λ + 2μ), which leaves no thickness where a sheet is drawn too far
    let law = StVenantKirchhoff::new(1.0, 0.3).expect("valid");
    let moderate: Vec<_> = deformations::<2>()
        .into_iter()
        .filter(|F| F.norm() < 2.0)
        .collect();
    assert_eq!(moderate.len(), 4);
    let report = conformance::check_at(&PlaneStress(law), &moderate);
    assert!(report.holds(), "{report}");
    let at = |s: f64| Deformation::new(Matrix::<2>::identity() * s);
    let share = 1.5 / (1.5 + 2.0);
    let expected = (1.0 - 2.0 * share * (1.2 * 1.2 - 1.0_f64)).sqrt();
    assert!((PlaneStress(law).thickness(&at(1.2)) - expected).abs() < 1e-14);
    assert_eq!(PlaneStress(law).energy_density(&at(1.6)), f64::INFINITY);
}

/// A neo-Hookean sheet, drawn along one axis or both: where a direction is free, μ (s² − 1) + λ ln J = 0.
#[test]
fn plane_stress_of_a_neo_hookean_sheet() {
    let (E, nu) = (2.6, 0.3);
    let (mu, lambda) = (1.0, 1.5);
    let sheet = PlaneStress(NeoHookean::new(E, nu).expect("valid"));
    let zero = |f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (1e-3, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            match f(middle) > 0.0 {
                true => high = middle,
                false => low = middle,
            }
        }
        0.5 * (low + high)
    };
    for s in [0.2_f64, 0.7, 1.3, 3.0] {
        let both = zero(&|t: f64| mu * (t * t - 1.0) + lambda * (s * s * t).ln());
        let at = Deformation::new(Matrix::<2>::identity() * s);
        let P = sheet.stress(&at);
        let by_hand = mu * s + (lambda * (s * s * both).ln() - mu) / s;
        assert!((sheet.thickness(&at) / both - 1.0).abs() < 1e-13, "{s}");
        assert!(
            (P - Matrix::identity() * by_hand).amax() < 1e-12,
            "{s}: {P}"
        );

        let one = zero(&|t: f64| mu * (t * t - 1.0) + lambda * (s * t * t).ln());
        let P = sheet.stress(&Deformation::new(Matrix::<2>::new(s, 0.0, 0.0, one)));
        let by_hand = mu * s + (lambda * (s * one * one).ln() - mu) / s;
        assert!((P[(0, 0)] - by_hand).abs() < 1e-12, "{s}: {P}");
        assert!(P[(1, 1)].abs() < 1e-12, "{s}: {P}");
    }
    // nearly incompressible: σ = μ (s² − s⁻⁴) of the incompressible sheet
    let rubber = PlaneStress(NeoHookean::new(3.0, 0.4999).expect("valid"));
    let (sigma, _) = rubber.cauchy_stress(&Deformation::new(Matrix::<2>::identity() * 1.5));
    let incompressible = 1.5_f64.powi(2) - 1.5_f64.powi(-4);
    assert!(
        (sigma[(0, 0)] / incompressible - 1.0).abs() < 2e-3,
        "{sigma}"
    );
    for J in [0.0, -1e-12, -1.0] {
        let turned = Deformation::new(Matrix::<2>::new(1.0, 0.0, 0.0, J));
        assert_eq!(sheet.energy_density(&turned), f64::INFINITY);
    }
}

#[test]
fn linear_elastic() {
    passes(LinearElastic::new);
}

#[test]
fn constants_out_of_range_are_named() {
    for E in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e160, 1e-200] {
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
