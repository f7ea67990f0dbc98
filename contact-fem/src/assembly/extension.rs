//! The harmonic extension of prescribed displacements into a body.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Col, Side};

use super::dofs::{Dof, DofMap};

/// An entry K_ab = ∫ ∇N_a·∇N_b dX of one cell's Laplacian, a and b being nodes.
pub(super) type LaplaceEntry = (usize, usize, f64);

/// Solves Δv = 0 for component `i` of `dim`, with `increments` on the prescribed dofs, and writes
/// the free ones into `free`. A component without prescribed dofs, or whose increments are all
/// zero, stays where it is; so does one whose matrix cannot be factorised, for the extension only
/// proposes a start.
pub(super) fn harmonic(
    entries: &[LaplaceEntry],
    dofs: &DofMap,
    (i, dim): (usize, usize),
    increments: &[f64],
    free: &mut [f64],
) {
    // unknowns of this component alone, numbered anew
    let mut number = vec![usize::MAX; dofs.free()];
    let mut unknowns = Vec::new();
    let mut matrix = Vec::new();
    let mut load: Vec<f64> = Vec::new();
    for &(a, b, k) in entries {
        let Dof::Free(row) = dofs.get(dim * a + i) else {
            continue;
        };
        if number[row] == usize::MAX {
            number[row] = unknowns.len();
            unknowns.push(row);
            load.push(0.0);
        }
        let row = number[row];
        match dofs.get(dim * b + i) {
            Dof::Free(col) => matrix.push((row, col, k)),
            Dof::Prescribed(p) => load[row] -= k * increments[p],
        }
    }
    if load.iter().all(|f| *f == 0.0) {
        return;
    }
    let n = unknowns.len();
    let triplets: Vec<_> = matrix
        .into_iter()
        .map(|(row, col, k)| Triplet::new(row, number[col], k))
        .collect();
    let Ok(matrix) = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets) else {
        return;
    };
    if let Ok(factor) = matrix.sp_cholesky(Side::Lower) {
        let solution = factor.solve(&Col::from_fn(n, |k| load[k]));
        for (k, &unknown) in unknowns.iter().enumerate() {
            free[unknown] = solution[k];
        }
    }
}
