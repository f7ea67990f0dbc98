//! Vectors and second-order tensors of fixed dimension, with determinant and inverse transpose.
//! nalgebra's own require trait bounds that would appear in every signature.

use nalgebra::{SMatrix, SVector};

/// A point, displacement or normal in ℝᴰ.
pub type Vector<const D: usize> = SVector<f64, D>;
/// A second-order tensor in ℝᴰ.
pub type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// The i-th unit vector.
pub fn unit_vector<const D: usize>(i: usize) -> Vector<D> {
    let mut e = Vector::zeros();
    e[i] = 1.0;
    e
}

/// det A for D = 2 or 3; other dimensions do not compile.
pub fn determinant<const D: usize>(A: &Matrix<D>) -> f64 {
    const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
    if D == 2 {
        A[(0, 0)] * A[(1, 1)] - A[(0, 1)] * A[(1, 0)]
    } else {
        (0..3).map(|j| A[(0, j)] * cofactor3(A, 0, j)).sum()
    }
}

/// A⁻ᵀ = cof A / det A for D = 2 or 3. The caller ensures det A ≠ 0.
pub fn inverse_transpose<const D: usize>(A: &Matrix<D>) -> Matrix<D> {
    cofactors(A) / determinant(A)
}

/// cof A for D = 2 or 3.
pub fn cofactors<const D: usize>(A: &Matrix<D>) -> Matrix<D> {
    Matrix::from_fn(|i, j| {
        if D == 2 {
            let minor = A[(1 - i, 1 - j)];
            if i == j { minor } else { -minor }
        } else {
            cofactor3(A, i, j)
        }
    })
}

/// The (i, j) cofactor of a 3 × 3 matrix; cyclic indices carry the sign.
fn cofactor3<const D: usize>(A: &Matrix<D>, i: usize, j: usize) -> f64 {
    let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
    A[(i1, j1)] * A[(i2, j2)] - A[(i1, j2)] * A[(i2, j1)]
}

/// v turned by a right angle in the first two directions: in the plane, a tangent of a normal.
pub(crate) fn turned<const D: usize>(v: &Vector<D>) -> Vector<D> {
    Vector::from_fn(|i, _| match i {
        0 => -v[1],
        1 => v[0],
        _ => 0.0,
    })
}

/// The eigenvalues of a symmetric matrix, and its eigenvectors as columns, by Jacobi's rotations. The columns are orthonormal to
/// round-off, whatever eigenvalues coincide.
pub(crate) fn principal_axes<const D: usize>(mut A: Matrix<D>) -> (Vector<D>, Matrix<D>) {
    /// Convergence is quadratic; three to five sweeps are usual.
    const SWEEPS: usize = 12;
    let mut axes = Matrix::identity();
    for _ in 0..SWEEPS {
        let mut largest = 0.0_f64;
        for (p, q) in (0..D).flat_map(|q| (0..q).map(move |p| (p, q))) {
            let off = A[(p, q)];
            if off == 0.0 {
                continue;
            }
            largest = largest.max(off.abs());
            let cot = 0.5 * (A[(q, q)] - A[(p, p)]) / off;
            let tan = cot.signum() / (cot.abs() + cot.hypot(1.0));
            let cos = 1.0 / tan.hypot(1.0);
            let sin = tan * cos;
            let rotate = |M: &mut Matrix<D>| {
                for i in 0..D {
                    let (x, y) = (M[(i, p)], M[(i, q)]);
                    (M[(i, p)], M[(i, q)]) = (cos * x - sin * y, sin * x + cos * y);
                }
            };
            let diagonal = [A[(p, p)] - tan * off, A[(q, q)] + tan * off];
            rotate(&mut A);
            A.transpose_mut();
            rotate(&mut A);
            [A[(p, p)], A[(q, q)]] = diagonal;
            (A[(p, q)], A[(q, p)]) = (0.0, 0.0);
            rotate(&mut axes);
        }
        if largest <= f64::EPSILON * f64::EPSILON * A.amax() {
            break;
        }
    }
    (A.diagonal(), axes)
}

/// The outward normal of a facet with corners `x`; its length is the facet's measure (UL in the
/// plane, UL² in space). The order of the corners defines the side of the body: to their left in
/// the plane; in space, behind the side from which they run counter-clockwise.
pub fn facet_normal<const D: usize>(x: &[Vector<D>; D]) -> Vector<D> {
    const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
    let a = x[1] - x[0];
    let mut n = Vector::zeros();
    if D == 2 {
        n[0] = a[1];
        n[1] = -a[0];
    } else {
        let b = x[2] - x[0];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            n[i] = 0.5 * (a[j] * b[k] - a[k] * b[j]);
        }
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn determinant_and_inverse_match_nalgebra() {
        let A = Matrix::<3>::new(1.2, 0.3, -0.4, 0.1, 0.9, 0.2, -0.3, 0.5, 1.4);
        assert!((determinant(&A) - A.determinant()).abs() < 1e-14);
        let inverse = A.try_inverse().expect("invertible").transpose();
        assert!((inverse_transpose(&A) - inverse).norm() < 1e-14);
        let B = Matrix::<2>::new(1.2, 0.3, -0.4, 0.9);
        assert!((determinant(&B) - B.determinant()).abs() < 1e-14);
        let inverse = B.try_inverse().expect("invertible").transpose();
        assert!((inverse_transpose(&B) - inverse).norm() < 1e-14);
    }

    /// A = V diag(a) Vᵀ with VᵀV = I, also where eigenvalues coincide or almost do.
    #[test]
    fn principal_axes_of_close_and_distant_values() {
        let turned = |a: [f64; 3]| {
            let Q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
            let A = Q.matrix() * Matrix::from_diagonal(&Vector::from(a)) * Q.matrix().transpose();
            0.5 * (A + A.transpose())
        };
        for a in [
            [1.0, 2.0, -3.0],
            [5.0, 5.0, 5.0],
            [1.0, 1.0, 4.0],
            [1.0, 1.0 + 1e-14, 1.0 - 1e-9],
            [1e-9, 1.0, 1e6],
            [0.0; 3],
        ] {
            let (A, size) = (turned(a), Vector::from(a).amax());
            let (values, V) = principal_axes(A);
            assert!((V.transpose() * V - Matrix::identity()).norm() < 1e-14);
            let again = V * Matrix::from_diagonal(&values) * V.transpose();
            assert!((again - A).norm() <= 1e-14 * size, "{a:?}: {values}");
        }
        let (values, V) = principal_axes(Matrix::<2>::new(2.0, 1.0, 1.0, 2.0));
        assert!((values.min() - 1.0).abs() + (values.max() - 3.0).abs() < 1e-14);
        assert!((V[(0, 0)].abs() - 0.5_f64.sqrt()).abs() < 1e-15, "{V}");
    }

    #[test]
    fn normals_point_outward() {
        let bottom = [Vector::<2>::new(0.0, 0.0), Vector::<2>::new(2.0, 0.0)];
        assert_eq!(facet_normal(&bottom), Vector::<2>::new(0.0, -2.0));
        let top = [
            Vector::<3>::new(0.0, 0.0, 1.0),
            Vector::<3>::new(1.0, 0.0, 1.0),
            Vector::<3>::new(0.0, 1.0, 1.0),
        ];
        assert_eq!(facet_normal(&top), Vector::<3>::new(0.0, 0.0, 0.5));
    }
}
