//! Motions along which the energy falls although the closed rows hold.

use contact_core::Energy;
use contact_core::equilibrium::Solution;
use contact_core::linear::{Analysis, Cholesky, Factor, Kind, Ordering, SymmetricPattern};

/// The stiffness that holds a closed row, over that of its unknowns.
const HELD: f64 = 1e3;
/// The first shift of the diagonal, relative to K's, its growth and its largest value.
const SHIFT: f64 = 1e-6;
const GROWTH: f64 = 10.0;
const LARGEST: f64 = 1e2;
/// Steps of inverse iteration.
const STEPS: usize = 20;

/// The free unknowns along the softest motion (n), if the Hessian of the energy is negative along it and the rows with a force
/// permit it; `None` if there is none, or none was found.
pub(super) fn falling(energy: &dyn Energy, solution: &Solution) -> Option<Vec<f64>> {
    let pattern = energy.hessian_pattern();
    let mut hessian = vec![0.0; pattern.len()];
    energy.hessian(&solution.state.u, &mut hessian);
    if hessian.iter().any(|k| !k.is_finite()) {
        return None;
    }
    let of_diagonal = |j: usize| pattern.slot(j, j).map_or(0.0, |slot| hessian[slot].abs());
    let diagonal: Vec<f64> = (0..pattern.dim()).map(of_diagonal).collect();
    let (held, mut values) = with_rows(pattern, &hessian, &diagonal, solution)?;
    let analysis = Analysis::new(&held, &Ordering::Automatic).ok()?;
    let mut factor = Cholesky::new(&analysis, Kind::Llt).ok()?;
    if factor.refactor(&values).is_ok() {
        return None;
    }
    let (mut shift, mut added) = (SHIFT, 0.0);
    while {
        for (j, d) in diagonal.iter().enumerate() {
            values[held.slot(j, j)?] += (shift - added) * d;
        }
        added = shift;
        factor.refactor(&values).is_err()
    } {
        shift *= GROWTH;
        if shift > LARGEST {
            return None;
        }
    }
    let mut random = 1u64;
    let mut motion: Vec<f64> = diagonal
        .iter()
        .map(|_| {
            // a linear congruence (Knuth's MMIX)
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        })
        .collect();
    for _ in 0..STEPS {
        motion.iter_mut().zip(&diagonal).for_each(|(v, d)| *v *= d);
        factor.solve(&mut motion).ok()?;
        let largest = motion.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        motion.iter_mut().for_each(|v| *v /= largest);
    }
    let mut forces = vec![0.0; motion.len()];
    pattern.product(&hessian, &motion, &mut forces);
    let work: f64 = forces.iter().zip(&motion).map(|(f, v)| f * v).sum();
    (work < 0.0).then_some(motion)
}

/// K with a stiffness on the rows that have a force, and its pattern.
fn with_rows(
    pattern: &SymmetricPattern,
    hessian: &[f64],
    diagonal: &[f64],
    solution: &Solution,
) -> Option<(SymmetricPattern, Vec<f64>)> {
    let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); solution.gaps.len()];
    for (row, j, a) in solution.gaps.entries() {
        if solution.lambda.get(row).is_some_and(|l| *l > 0.0) && a != 0.0 {
            rows[row].push((j, a));
        }
    }
    let mut places: Vec<(usize, usize)> = (0..diagonal.len()).map(|j| (j, j)).collect();
    let pairs = |row: &Vec<(usize, f64)>| {
        let row = row.clone();
        let pairs = row.clone().into_iter().flat_map(move |(i, a)| {
            let below = row.clone().into_iter().filter(move |(j, _)| *j <= i);
            below.map(move |(j, b)| (i, j, a * b))
        });
        pairs.collect::<Vec<_>>()
    };
    let of_rows: Vec<Vec<(usize, usize, f64)>> = rows.iter().map(pairs).collect();
    places.extend(of_rows.iter().flatten().map(|&(i, j, _)| (i, j)));
    let (held, slots) = pattern.with(&places).ok()?;
    let mut values = vec![0.0; held.len()];
    let known = slots.iter().zip(hessian);
    known.for_each(|(&slot, k)| values[slot] += k);
    for (row, pairs) in rows.iter().zip(&of_rows) {
        let compliance: f64 = row.iter().map(|(j, a)| a * a / diagonal[*j]).sum();
        for &(i, j, product) in pairs {
            values[held.slot(i, j)?] += HELD / compliance * product;
        }
    }
    Some((held, values))
}
