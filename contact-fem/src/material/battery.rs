//! The tests that every law passes.

use super::*;
use crate::tensor::{determinant, unit_vector};

/// Deformations of D dimensions: near the identity, stretched, sheared, compressed.
fn deformations<const D: usize>() -> Vec<Matrix<D>> {
    let shape = |s: f64| {
        Matrix::<D>::from_fn(|i, j| s * ((1 + 3 * i + 7 * j) as f64).sin())
            + Matrix::<D>::identity()
    };
    [0.01, 0.2, -0.3]
        .into_iter()
        .map(shape)
        .chain([0.6, 1.7].map(|s| Matrix::<D>::identity() * s))
        .filter(|F| determinant(F) > 0.05)
        .collect()
}

fn rotation<const D: usize>(angle: f64) -> Matrix<D> {
    let mut R = Matrix::<D>::identity();
    let (s, c) = angle.sin_cos();
    (R[(0, 0)], R[(0, 1)], R[(1, 0)], R[(1, 1)]) = (c, -s, s, c);
    R
}

fn derivatives<const D: usize>(law: &impl Material<D>, stiffness: f64) {
    let h = 1e-6;
    for F in deformations::<D>() {
        let P = law.stress(&F);
        let A = law.contraction(&F);
        for k in 0..D {
            for L in 0..D {
                let mut step = Matrix::<D>::zeros();
                step[(k, L)] = h;
                let slope =
                    (law.energy_density(&(F + step)) - law.energy_density(&(F - step))) / (2.0 * h);
                assert!((P[(k, L)] - slope).abs() < 1e-7 * stiffness, "P_{k}{L}");
                let dP = (law.stress(&(F + step)) - law.stress(&(F - step))) / (2.0 * h);
                for J in 0..D {
                    let M = A(&unit_vector(J), &unit_vector(L));
                    for i in 0..D {
                        assert!(
                            (M[(i, k)] - dP[(i, J)]).abs() < 1e-6 * stiffness,
                            "A_{i}{J}{k}{L}"
                        );
                    }
                }
            }
        }
    }
}

/// A_iJkL = A_kLiJ.
fn symmetry<const D: usize>(law: &impl Material<D>, stiffness: f64) {
    let a = Vector::<D>::from_fn(|i, _| 0.3 + i as f64);
    let b = Vector::<D>::from_fn(|i, _| 1.1 - 0.7 * i as f64);
    for F in deformations::<D>() {
        let A = law.contraction(&F);
        assert!((A(&a, &b) - A(&b, &a).transpose()).norm() < 1e-12 * stiffness);
    }
}

/// A : (a ⊗ b) of Hooke's tensor, written down a second time from the isotropic formula.
fn linearizes_to_hooke<const D: usize>(law: &impl Material<D>, E: f64, nu: f64) {
    let (lambda, mu) = (E * nu / (1.0 + nu) / (1.0 - 2.0 * nu), 0.5 * E / (1.0 + nu));
    let rest = Matrix::identity();
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
    assert!(law.energy_density(&Matrix::identity()).abs() < 1e-14 * E);
    assert!(law.stress(&Matrix::identity()).norm() < 1e-12 * (lambda + mu));
}

/// ψ(RF) = ψ(F), P(RF) = R P(F), and σ is symmetric.
fn objectivity<const D: usize>(law: &impl Material<D>, stiffness: f64) {
    let R = rotation::<D>(0.7);
    for F in deformations::<D>() {
        let change = law.energy_density(&(R * F)) - law.energy_density(&F);
        assert!(change.abs() < 1e-12 * stiffness);
        assert!((law.stress(&(R * F)) - R * law.stress(&F)).norm() < 1e-12 * stiffness);
        let (sigma, _) = law.cauchy_stress(&F);
        assert!((sigma - sigma.transpose()).norm() < 1e-12 * stiffness);
    }
}

/// In plane strain σ equals the in-plane part of the spatial law at diag(F, 1).
fn plane_strain<L: Material<2> + Material<3>>(law: &L, stiffness: f64) {
    for F in deformations::<2>() {
        let mut F3 = Matrix::<3>::identity();
        F3.fixed_view_mut::<2, 2>(0, 0).copy_from(&F);
        let ((sigma, zz), (sigma3, _)) = (law.cauchy_stress(&F), law.cauchy_stress(&F3));
        let in_plane = sigma3.fixed_view::<2, 2>(0, 0).into_owned();
        assert!((sigma - in_plane).norm() < 1e-12 * stiffness);
        assert!((zz - sigma3[(2, 2)]).abs() < 1e-12 * stiffness);
        assert!((law.energy_density(&F) - law.energy_density(&F3)).abs() < 1e-12 * stiffness);
    }
}

const CASES: [(f64, f64); 4] = [(1000.0, 0.0), (2.0, 0.3), (1e5, 0.4999), (7.0, -0.5)];

#[test]
fn neo_hookean() {
    for (E, nu) in CASES {
        let law = NeoHookean::new(E, nu).expect("valid");
        let lame = Lame::new(E, nu).expect("valid");
        let stiffness = 10.0 * (lame.lambda.abs() + lame.mu);
        derivatives::<2>(&law, stiffness);
        derivatives::<3>(&law, stiffness);
        symmetry::<2>(&law, stiffness);
        symmetry::<3>(&law, stiffness);
        linearizes_to_hooke::<2>(&law, E, nu);
        linearizes_to_hooke::<3>(&law, E, nu);
        objectivity::<2>(&law, stiffness);
        objectivity::<3>(&law, stiffness);
        plane_strain(&law, stiffness);
        let flipped = Matrix::<2>::from_diagonal(&Vector::<2>::new(-1.0, 1.0));
        assert_eq!(law.energy_density(&flipped), f64::INFINITY);
        assert_eq!(
            Material::<3>::energy_density(&law, &Matrix::zeros()),
            f64::INFINITY
        );
    }
}

#[test]
fn linear_elastic() {
    for (E, nu) in CASES {
        let law = LinearElastic::new(E, nu).expect("valid");
        let lame = Lame::new(E, nu).expect("valid");
        let stiffness = 10.0 * (lame.lambda.abs() + lame.mu);
        derivatives::<2>(&law, stiffness);
        derivatives::<3>(&law, stiffness);
        symmetry::<2>(&law, stiffness);
        symmetry::<3>(&law, stiffness);
        linearizes_to_hooke::<2>(&law, E, nu);
        linearizes_to_hooke::<3>(&law, E, nu);
        plane_strain(&law, stiffness);
    }
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
