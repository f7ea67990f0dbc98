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
