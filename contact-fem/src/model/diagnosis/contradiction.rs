//! Rows that no motion satisfies together.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

/// A row at an iterate: its coefficients by unknown, and its gap (UL).
pub(super) struct Row {
    pub coefficients: Vec<(usize, f64)>,
    pub gap: f64,
}

/// Motions longer than so many lengths do not count.
const FAR: f64 = 10.0;
/// The round-off of scaled products.
const ROUNDOFF: f64 = 1e-10;

/// The rows (by position) that contradict each other: no d shorter than ten times `length` (UL) has c + C d ≥ 0 for all of
/// them. Empty if there is such a d.
///
/// By Farkas' lemma either such a d exists, of whatever length, or multipliers λ ≥ 0 with Cᵀλ = 0 and cᵀλ = −1. The
/// multipliers that come closest to that, in the sense of least squares, give the shortest d too: what they leave is (r, ρ)
/// with |r|² = |ρ| − ρ², and d = r / ρ (Lawson and Hanson, *Solving Least Squares Problems*, chapter 23, whose algorithm
/// this is).
pub(super) fn contradictory(rows: &[Row], length: f64) -> Vec<usize> {
    let (m, places) = (rows.len(), places(rows));
    let n = places.len();
    let mut A = DMatrix::zeros(n + 1, m);
    for (k, row) in rows.iter().enumerate() {
        let norm = row.coefficients.iter().map(|(_, a)| a * a).sum::<f64>();
        let norm = norm.sqrt();
        // a row that nothing moves is as long as one with a coefficient of 1
        let norm = if norm > 0.0 { norm } else { 1.0 };
        for (j, a) in &row.coefficients {
            A[(places[j], k)] += a / norm;
        }
        A[(n, k)] = row.gap / (norm * length);
    }
    let mut goal = DVector::zeros(n + 1);
    goal[n] = -1.0;
    let Some(lambda) = nonnegative_least_squares(&A, &goal) else {
        return Vec::new();
    };
    let rho = (&goal - &A * &lambda)[n].abs();
    match rho < 1.0 / (1.0 + FAR * FAR) {
        true => {
            let largest = lambda.max();
            let matters = |k: &usize| lambda[*k] > 1e-6 * largest;
            (0..m).filter(matters).collect()
        }
        false => Vec::new(),
    }
}

/// The unknowns of all rows, counted.
fn places(rows: &[Row]) -> BTreeMap<usize, usize> {
    let unknowns = rows.iter().flat_map(|row| &row.coefficients);
    let mut places: BTreeMap<usize, usize> = unknowns.map(|(j, _)| (*j, 0)).collect();
    let counted = places.values_mut().enumerate();
    counted.for_each(|(k, place)| *place = k);
    places
}

/// The x ≥ 0 with the least |A x − b|; `None` where rounds do not suffice.
fn nonnegative_least_squares(A: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let (gram, right) = (A.transpose() * A, A.transpose() * b);
    let m = right.len();
    let mut x = DVector::zeros(m);
    let mut is_free = vec![false; m];
    for _ in 0..3 * m + 1 {
        let slope = &right - &gram * &x;
        let held = (0..m).filter(|&k| !is_free[k]);
        let steepest = held.max_by(|&i, &j| slope[i].total_cmp(&slope[j]));
        let Some(next) = steepest.filter(|&k| slope[k] > ROUNDOFF) else {
            return Some(x);
        };
        is_free[next] = true;
        loop {
            let free: Vec<usize> = (0..m).filter(|&k| is_free[k]).collect();
            let z = solved(&gram, &right, &free)?;
            let crossing = free.iter().zip(z.iter()).filter(|(_, z)| **z <= 0.0);
            let share = crossing.map(|(&k, z)| (x[k] / (x[k] - z), k));
            let share = share.min_by(|a, b| a.0.total_cmp(&b.0));
            let step = share.map_or(1.0, |(share, _)| share);
            for (&k, z) in free.iter().zip(z.iter()) {
                x[k] += step * (z - x[k]);
            }
            match share {
                None => break,
                Some((_, first)) => {
                    // at least one leaves, so that this ends
                    x[first] = 0.0;
                    free.iter().for_each(|&k| is_free[k] &= x[k] > 0.0);
                }
            }
        }
    }
    None
}

/// The least squares solution on these columns.
fn solved(gram: &DMatrix<f64>, right: &DVector<f64>, free: &[usize]) -> Option<DVector<f64>> {
    let k = free.len();
    let mut part = DMatrix::from_fn(k, k, |i, j| gram[(free[i], free[j])]);
    // rows of both passes may be one
    (0..k).for_each(|i| part[(i, i)] += 1e-12 * (1.0 + part[(i, i)]));
    let right = DVector::from_fn(k, |i, _| right[free[i]]);
    part.cholesky().map(|factor| factor.solve(&right))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[(&[(usize, f64)], f64)]) -> Vec<Row> {
        let row = |(coefficients, gap): &(&[(usize, f64)], f64)| Row {
            coefficients: coefficients.to_vec(),
            gap: *gap,
        };
        rows.iter().map(row).collect()
    }

    #[test]
    fn walls_without_room_between_them() {
        // d ≥ 1 and d ≤ −1, and a third one that has nothing to do with it
        let walls = rows(&[
            (&[(3, 1.0)], -1.0),
            (&[(7, 2.0)], -1.0),
            (&[(3, -1.0)], -1.0),
        ]);
        assert_eq!(contradictory(&walls, 1.0), [0, 2]);
        assert!(contradictory(&walls[..2], 1.0).is_empty());
    }

    #[test]
    fn three_walls_that_leave_a_triangle_or_none() {
        let third = 3f64.sqrt() / 2.0;
        let normals: [[(usize, f64); 2]; 3] = [
            [(0, 0.0), (1, 1.0)],
            [(0, third), (1, -0.5)],
            [(0, -third), (1, -0.5)],
        ];
        let walls = |gap: f64| rows(&normals.each_ref().map(|n| (n.as_slice(), gap)));
        assert!(contradictory(&walls(0.1), 1.0).is_empty());
        assert_eq!(contradictory(&walls(-0.1), 1.0), [0, 1, 2]);
    }

    #[test]
    fn what_only_a_long_way_satisfies() {
        // nearly parallel: d = 1 / slope
        let wedge = |slope: f64| {
            let [up, down] = [[(0, slope), (1, 1.0)], [(0, slope), (1, -1.0)]];
            contradictory(&rows(&[(&up, -1.0), (&down, -1.0)]), 1.0)
        };
        assert!(wedge(0.2).is_empty());
        assert_eq!(wedge(0.02), [0, 1]);
    }

    #[test]
    fn a_row_that_nothing_moves() {
        assert_eq!(contradictory(&rows(&[(&[], -0.1)]), 1.0), [0]);
        assert!(contradictory(&rows(&[(&[], 0.1)]), 1.0).is_empty());
        assert!(contradictory(&[], 1.0).is_empty());
    }

    /// A point that satisfies all rows exists by construction.
    #[test]
    fn rows_around_a_point_do_not_contradict() {
        let mut state = 0.3f64;
        // the logistic map, which is chaotic
        let mut next = || {
            state = 3.99 * state * (1.0 - state);
            2.0 * state - 1.0
        };
        for k in 0..200 {
            let n = 1 + k % 5;
            let point: Vec<f64> = (0..n).map(|_| next()).collect();
            let rows = (0..4 * n).map(|_| {
                let coefficients: Vec<_> = (0..n).map(|j| (j, next())).collect();
                let there: f64 = coefficients.iter().map(|(j, a)| a * point[*j]).sum();
                let gap = next().abs() * 0.1 - there;
                Row { coefficients, gap }
            });
            let rows: Vec<Row> = rows.collect();
            assert!(contradictory(&rows, 1.0).is_empty());
        }
    }
}
