//! Singular values of small matrices.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix};

/// Sweeps over the columns until they are orthogonal; most matrices take five.
const SWEEPS: usize = 40;

/// A matrix times an orthogonal one, so that its columns are orthogonal, and the latter: columns are turned in pairs by Jacobi's
/// rotations. The norms of the columns are the singular values, also where some vanish.
pub(crate) fn orthogonal_columns<R: Dim, C: Dim>(
    mut matrix: OMatrix<f64, R, C>,
) -> (OMatrix<f64, R, C>, OMatrix<f64, C, C>)
where
    DefaultAllocator: Allocator<R, C> + Allocator<C, C>,
{
    let columns = matrix.shape_generic().1;
    let mut turns = OMatrix::identity_generic(columns, columns);
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for (p, q) in (0..columns.value()).flat_map(|q| (0..q).map(move |p| (p, q))) {
            let [first, second] = [p, q].map(|k| matrix.column(k).norm_squared());
            let product = matrix.column(p).dot(&matrix.column(q));
            if !(product.abs() > f64::EPSILON * (first * second).sqrt()) {
                continue;
            }
            is_done = false;
            let cotangent = (second - first) / (2.0 * product); // of twice the angle
            let tangent = cotangent.signum() / (cotangent.abs() + cotangent.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            turn(&mut matrix, [p, q], cosine, tangent);
            turn(&mut turns, [p, q], cosine, tangent);
        }
        if is_done {
            break;
        }
    }
    (matrix, turns)
}

/// Turns two columns by an angle.
fn turn<R: Dim, C: Dim>(
    matrix: &mut OMatrix<f64, R, C>,
    [p, q]: [usize; 2],
    cosine: f64,
    tangent: f64,
) where
    DefaultAllocator: Allocator<R, C>,
{
    for row in 0..matrix.nrows() {
        let [a, b] = [p, q].map(|k| matrix[(row, k)] * cosine);
        matrix[(row, p)] = a - b * tangent;
        matrix[(row, q)] = b + a * tangent;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Matrix6};

    use super::*;

    /// The slope of an arc in the plane, of rank two but for round-off: the last three motions are those of space.
    #[test]
    fn the_columns_of_a_singular_matrix() {
        let arc = [
            [
                0.00035259826299284937,
                -0.01912127204859908,
                -0.017262485585249735,
            ],
            [-0.019125878104212, 1.3827315506320526, 0.38149782620613726],
            [
                -0.017263152132613764,
                0.3814978099654833,
                1.7358581933867565,
            ],
        ];
        let mut slope = Matrix6::zeros();
        (0..3).for_each(|i| (0..3).for_each(|j| slope[(i, j)] = arc[i][j]));
        let (turned, turns) = orthogonal_columns(slope);
        assert!((turned * turns.transpose() - slope).norm() < 1e-14);
        assert!((turns.transpose() * turns - Matrix6::identity()).norm() < 1e-14);
        let products = turned.transpose() * turned;
        assert!((products - Matrix6::from_diagonal(&products.diagonal())).norm() < 1e-14);
        // the roots of the lower right block's characteristic polynomial, up to the first row and column
        let [a, b, c] = [arc[1][1], arc[1][2], arc[2][2]];
        let root = (0.5 * (a - c)).hypot(b);
        let mut values: Vec<f64> = products.diagonal().iter().map(|p| p.sqrt()).collect();
        values.sort_by(f64::total_cmp);
        assert!(values[3] < 1e-4, "{values:?}");
        for (value, expected) in values[4..].iter().zip([-root, root]) {
            assert!(
                (value - 0.5 * (a + c) - expected).abs() < 1e-3,
                "{values:?}"
            );
        }
    }

    /// The null space of rows that a rank-two matrix has, whatever the height.
    #[test]
    fn what_all_rows_annul() {
        let rows = [
            [1.0, 2.0, 2.0, 0.0],
            [3.0, 6.0, 6.0, 0.0],
            [0.0, 0.0, 1e-3, 2e-3],
        ];
        let wide = DMatrix::from_fn(3, 4, |i, j| rows[i][j]);
        let tall = DMatrix::from_fn(7, 4, |i, j| rows[i % 3][j]);
        for matrix in [wide, tall] {
            let (turned, turns) = orthogonal_columns(matrix.clone());
            let free: Vec<usize> = (0..4)
                .filter(|k| turned.column(*k).norm() < 1e-12)
                .collect();
            assert_eq!(free.len(), 2);
            for k in free {
                assert!((&matrix * turns.column(k)).norm() < 1e-14);
                assert!((turns.column(k).norm() - 1.0).abs() < 1e-14);
            }
        }
    }
}
