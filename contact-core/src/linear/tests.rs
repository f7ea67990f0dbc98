//! Factors against dense factorisations and against inertias known by construction.

use nalgebra::DMatrix;

use super::*;

const KINDS: [Kind; 2] = [Kind::Llt, Kind::Ldlt];

fn orderings(n: usize) -> [Ordering; 5] {
    let scattered = (0..n).map(|k| (k * 7919 + 3) % n);
    let is_permutation = n % 7919 != 0;
    assert!(is_permutation || n == 0);
    [
        Ordering::Automatic,
        Ordering::Natural,
        Ordering::MinimumDegree,
        Ordering::NestedDissection,
        Ordering::Given(scattered.collect()),
    ]
}

/// A symmetric matrix by entries of its lower triangle, those at the same place added up.
struct Sparse {
    pattern: SymmetricPattern,
    values: Vec<f64>,
}

impl Sparse {
    fn new(n: usize, entries: &[(usize, usize, f64)]) -> Self {
        let (pattern, values) = SymmetricPattern::from_sums(n, entries).expect("in range");
        Sparse { pattern, values }
    }

    fn dense(&self) -> DMatrix<f64> {
        let n = self.pattern.dim();
        let mut dense = DMatrix::zeros(n, n);
        for ((i, j), &a) in self.pattern.iter().zip(&self.values) {
            (dense[(i, j)], dense[(j, i)]) = (a, a);
        }
        dense
    }

    fn analyse(&self, ordering: &Ordering) -> Analysis {
        Analysis::new(&self.pattern, ordering).expect("a fine pattern")
    }

    fn factor(&self, kind: Kind, ordering: &Ordering) -> Result<(Cholesky, Inertia), FactorError> {
        let mut factor = Cholesky::new(&self.analyse(ordering), kind).expect("memory");
        let inertia = factor.refactor(&self.values)?;
        Ok((factor, inertia))
    }
}

/// Numbers between −1 and 1 that look random.
fn noise(seed: usize) -> impl Iterator<Item = f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15u64 ^ (seed as u64).wrapping_mul(0xD134_2543_DE82_EF95);
    std::iter::repeat_with(move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    })
}

/// About `per_row` entries a row off the diagonal, which dominates.
fn random(n: usize, per_row: usize, seed: usize) -> Sparse {
    let mut noise = noise(seed);
    let mut next = || noise.next().expect("endless");
    let mut entries = Vec::new();
    for i in 0..n {
        entries.push((i, i, 1.0));
        for _ in 0..per_row {
            let (j, a) = (((next() + 1.0) * 0.5 * n as f64) as usize % n, next());
            if i != j {
                entries.extend([(i.max(j), i.min(j), a), (i, i, a.abs()), (j, j, a.abs())]);
            }
        }
    }
    Sparse::new(n, &entries)
}

/// The Laplacian − `shift` of a grid of `n` points each way in `dim` dimensions, zero outside the grid.
fn laplacian(n: usize, dim: u32, shift: f64) -> Sparse {
    let mut entries = Vec::new();
    for k in 0..n.pow(dim) {
        entries.push((k, k, 2.0 * f64::from(dim) - shift));
        for d in 0..dim {
            let step = n.pow(d);
            if k / step % n > 0 {
                entries.push((k, k - step, -1.0));
            }
        }
    }
    Sparse::new(n.pow(dim), &entries)
}

/// The eigenvalues of the unshifted one, Σ_d 2 − 2 cos(π k_d / (n + 1)).
fn eigenvalues(n: usize, dim: u32) -> Vec<f64> {
    let of_line = |k: usize| 2.0 - 2.0 * (std::f64::consts::PI * k as f64 / (n + 1) as f64).cos();
    let of = |k: usize| (0..dim).map(|d| of_line(k / n.pow(d) % n + 1)).sum();
    (0..n.pow(dim)).map(of).collect()
}

/// Solves with k right-hand sides and compares with LU of the dense matrix.
fn check_solution(factor: &mut Cholesky, matrix: &Sparse, k: usize) {
    let n = matrix.pattern.dim();
    let b: Vec<f64> = noise(k).take(n * k).collect();
    let lu = matrix.dense().lu();
    let expected = lu
        .solve(&DMatrix::from_column_slice(n, k, &b))
        .expect("regular");
    let mut x = b.clone();
    factor.solve(&mut x).expect("factored");
    let error = (DMatrix::from_column_slice(n, k, &x) - &expected).amax();
    assert!(
        error <= 1e-11 * expected.amax(),
        "n = {n}, k = {k}: {error:e}"
    );
}

#[test]
fn solutions_are_those_of_the_dense_matrix() {
    for (n, per_row) in [(1, 0), (2, 1), (5, 2), (30, 0), (40, 2), (150, 6)] {
        let matrix = random(n, per_row, n);
        for ordering in orderings(n) {
            for kind in KINDS {
                let (mut factor, inertia) = matrix.factor(kind, &ordering).expect("definite");
                assert_eq!((inertia.positive, inertia.negative), (n, 0));
                for k in [1, 3, 130] {
                    check_solution(&mut factor, &matrix, k);
                }
            }
        }
    }
}

#[test]
fn other_values_reuse_the_factor() {
    let first = laplacian(12, 2, 0.0);
    for ordering in orderings(144) {
        for kind in KINDS {
            let (mut factor, _) = first.factor(kind, &ordering).expect("definite");
            check_solution(&mut factor, &first, 2);
            let mut second = laplacian(12, 2, 0.0);
            let changes = second.values.iter_mut().zip(noise(1));
            changes.for_each(|(value, noise)| *value *= 1.0 + 0.01 * noise);
            for (slot, (i, j)) in second.pattern.iter().enumerate() {
                second.values[slot] += f64::from(u8::from(i == j));
            }
            factor.refactor(&second.values).expect("definite");
            check_solution(&mut factor, &second, 2);
            factor.refactor(&first.values).expect("definite");
            check_solution(&mut factor, &first, 2);
        }
    }
}

#[test]
fn both_kinds_of_storage_hold_the_factor() {
    // faer stores the factor by single columns where it is sparse, by blocks where it is dense
    for (matrix, has_blocks) in [(laplacian(8, 2, 0.0), false), (laplacian(10, 3, 0.0), true)] {
        let n = matrix.pattern.dim();
        for kind in KINDS {
            let (mut factor, _) = matrix.factor(kind, &Ordering::Natural).expect("definite");
            assert_eq!(factor.panels().any(|panel| panel.size > 1), has_blocks);
            check_solution(&mut factor, &matrix, 5);
            let (mut L, mut D) = (DMatrix::<f64>::zeros(n, n), DMatrix::<f64>::identity(n, n));
            for panel in factor.panels() {
                for j in 0..panel.size {
                    let step = panel.start + j;
                    panel.column(j).for_each(|(row, l)| L[(row, step)] = l);
                    if kind == Kind::Ldlt {
                        D[(step, step)] = std::mem::replace(&mut L[(step, step)], 1.0);
                    }
                }
            }
            let product = &L * D * L.transpose();
            let unknown: Vec<usize> = (0..n).map(|k| factor.analysis().unknown(k)).collect();
            let dense = matrix.dense();
            let permuted = DMatrix::from_fn(n, n, |i, j| dense[(unknown[i], unknown[j])]);
            assert!((product - permuted).amax() < 1e-13);
        }
    }
}

#[test]
fn numbering_does_not_matter() {
    let matrix = random(60, 3, 7);
    let new = |k: usize| (k * 7919 + 3) % 60;
    let entries = matrix.pattern.iter().zip(&matrix.values);
    let renumbered = entries.map(|((i, j), &a)| (new(i), new(j), a));
    let renumbered = Sparse::new(60, &renumbered.collect::<Vec<_>>());
    let b: Vec<f64> = noise(3).take(60).collect();
    let (mut x, mut y) = (b.clone(), vec![0.0; 60]);
    (0..60).for_each(|k| y[new(k)] = b[k]);
    let ordering = Ordering::Automatic;
    matrix
        .factor(Kind::Llt, &ordering)
        .expect("definite")
        .0
        .solve(&mut x)
        .expect("factored");
    renumbered
        .factor(Kind::Llt, &ordering)
        .expect("definite")
        .0
        .solve(&mut y)
        .expect("factored");
    assert!((0..60).all(|k| (y[new(k)] - x[k]).abs() < 1e-13));
}

#[test]
fn shifted_laplacians_have_as_many_negative_eigenvalues_as_lie_below_the_shift() {
    for (n, dim) in [(40, 1), (13, 2), (9, 3)] {
        let mut eigenvalues = eigenvalues(n, dim);
        eigenvalues.sort_by(f64::total_cmp);
        for share in [0.0, 0.02, 0.3, 0.77] {
            // in the widest gap from there on, away from the zero diagonal that its middle may be
            let from = (share * eigenvalues.len() as f64) as usize;
            let gaps = from..(from + eigenvalues.len() / 5).min(eigenvalues.len() - 1);
            let width = |k: &usize| eigenvalues[k + 1] - eigenvalues[*k];
            let k = gaps
                .max_by(|a, b| width(a).total_cmp(&width(b)))
                .expect("gaps");
            let matrix = laplacian(n, dim, 0.6 * eigenvalues[k] + 0.4 * eigenvalues[k + 1]);
            for ordering in [Ordering::MinimumDegree, Ordering::NestedDissection] {
                let (mut factor, inertia) = matrix.factor(Kind::Ldlt, &ordering).expect("regular");
                assert_eq!(inertia.negative, k + 1, "{n}^{dim}");
                assert_eq!(inertia.positive, eigenvalues.len() - k - 1);
                let b: Vec<f64> = noise(2).take(eigenvalues.len()).collect();
                let (mut x, mut r) = (b.clone(), b.clone());
                factor.solve(&mut x).expect("factored");
                matrix.pattern.product(&matrix.values, &x, &mut r);
                let residual = r
                    .iter()
                    .zip(&b)
                    .fold(0.0, |m: f64, (r, b)| m.max((r - b).abs()));
                let size = x.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
                assert!(residual < 1e-9 * size, "{n}^{dim}: {residual:e}");
                let refused = matrix.factor(Kind::Llt, &ordering).err();
                let expected = matches!(refused, Some(FactorError::NotPositiveDefinite { .. }));
                assert!(expected, "{refused:?}");
            }
        }
    }
}

/// [K Bᵀ; B −δ] with K n × n and m independent rows B.
fn saddle(delta: f64) -> (Sparse, usize, usize) {
    let K = laplacian(7, 2, 0.0);
    let (n, m) = (49, 7);
    let mut entries: Vec<_> = K
        .pattern
        .iter()
        .zip(&K.values)
        .map(|((i, j), &a)| (i, j, a))
        .collect();
    for k in 0..m {
        entries.extend([
            (n + k, 7 * k, 1.0),
            (n + k, 7 * k + 3, -0.5),
            (n + k, n + k, -delta),
        ]);
    }
    (Sparse::new(n + m, &entries), n, m)
}

#[test]
fn saddles_have_one_negative_eigenvalue_a_row() {
    // any order does for a quasi-definite matrix; constraints after their unknowns for a zero block
    let cases = [
        (0.1, Ordering::Automatic),
        (0.1, Ordering::Natural),
        (0.0, Ordering::Natural),
    ];
    for (delta, ordering) in cases {
        let (matrix, positive, negative) = saddle(delta);
        let (mut factor, inertia) = matrix.factor(Kind::Ldlt, &ordering).expect("regular");
        assert_eq!(inertia, Inertia { positive, negative });
        check_solution(&mut factor, &matrix, 2);
    }
}

#[test]
fn singular_matrices_are_errors_and_leave_no_factor() {
    // constants are in the kernel of the Laplacian without boundary conditions
    let floating = |n: usize, dim: u32| {
        let mut matrix = laplacian(n, dim, 0.0);
        let ones = vec![1.0; matrix.pattern.dim()];
        let mut sums = ones.clone();
        matrix.pattern.product(&matrix.values, &ones, &mut sums);
        for (k, sum) in sums.into_iter().enumerate() {
            let slot = matrix.pattern.slot(k, k).expect("a diagonal");
            matrix.values[slot] -= sum;
        }
        matrix
    };
    let nothing = Sparse::new(1, &[(0, 0, 0.0)]);
    let empty_row = Sparse::new(3, &[(0, 0, 1.0), (2, 2, 1.0), (2, 0, 0.5)]);
    let redundant = Sparse::new(
        3,
        &[
            (0, 0, 1.0),
            (1, 0, 0.3),
            (2, 0, 0.3),
            (1, 1, -1.0),
            (2, 1, -1.0),
            (2, 2, -1.0),
        ],
    );
    for matrix in [
        nothing,
        empty_row,
        redundant,
        floating(30, 1),
        floating(12, 2),
        floating(9, 3),
    ] {
        for ordering in [Ordering::Natural, Ordering::Automatic] {
            for kind in KINDS {
                let mut factor = Cholesky::new(&matrix.analyse(&ordering), kind).expect("memory");
                let error = factor.refactor(&matrix.values).expect_err("singular");
                let expected = match kind {
                    Kind::Llt => matches!(error, FactorError::NotPositiveDefinite { .. }),
                    Kind::Ldlt => matches!(error, FactorError::Singular { .. }),
                };
                assert!(expected, "{error}");
                let mut b = vec![1.0; matrix.pattern.dim()];
                assert_eq!(factor.solve(&mut b), Err(FactorError::NotFactored));
            }
        }
    }
    // firm ground, weak as it is, makes it regular
    let mut held = floating(9, 3);
    held.values[0] += 1e-6;
    for kind in KINDS {
        held.factor(kind, &Ordering::Automatic).expect("regular");
    }
}

#[test]
fn a_pivot_that_drowns_the_matrix_is_an_error() {
    let matrix = Sparse::new(2, &[(0, 0, 1e-20), (1, 0, 1.0), (1, 1, 1.0)]);
    let error = matrix.factor(Kind::Ldlt, &Ordering::Natural).err();
    assert_eq!(error, Some(FactorError::Singular { unknown: 1 }));
    let (mut factor, inertia) = matrix
        .factor(Kind::Ldlt, &Ordering::Given(vec![1, 0]))
        .expect("regular");
    assert_eq!((inertia.positive, inertia.negative), (1, 1));
    check_solution(&mut factor, &matrix, 1);
}

#[test]
fn unknowns_of_bad_pivots_are_named() {
    for n in [3, 9] {
        let mut matrix = laplacian(n, 3, 0.0);
        let unknown = n * n + 1;
        let slot = matrix.pattern.slot(unknown, unknown).expect("a diagonal");
        matrix.values[slot] = -1.0;
        // eliminated first, its pivot is its diagonal entry
        let mut order: Vec<usize> = (0..n * n * n).collect();
        order.swap(0, unknown);
        let error = matrix.factor(Kind::Llt, &Ordering::Given(order)).err();
        assert_eq!(error, Some(FactorError::NotPositiveDefinite { unknown }));
    }
}

#[test]
fn parts_without_connection_and_nothing_at_all() {
    let isolated = Sparse::new(4, &[(0, 0, 2.0), (1, 1, -4.0), (2, 2, 8.0), (3, 3, 0.5)]);
    let parts = Sparse::new(
        5,
        &[
            (0, 0, 2.0),
            (4, 0, 1.0),
            (4, 4, 2.0),
            (1, 1, 3.0),
            (2, 2, 2.0),
            (3, 2, -1.0),
            (3, 3, 2.0),
        ],
    );
    let none = Sparse::new(0, &[]);
    let one = Sparse::new(1, &[(0, 0, 4.0)]);
    for (matrix, negative) in [(isolated, 1), (parts, 0), (none, 0), (one, 0)] {
        let n = matrix.pattern.dim();
        for ordering in orderings(n) {
            let (mut factor, inertia) = matrix.factor(Kind::Ldlt, &ordering).expect("regular");
            assert_eq!(
                inertia,
                Inertia {
                    positive: n - negative,
                    negative
                }
            );
            match n {
                0 => assert_eq!(factor.solve(&mut []), Ok(())),
                _ => check_solution(&mut factor, &matrix, 2),
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_an_error() {
    let matrix = laplacian(3, 2, 0.0);
    let (mut factor, _) = matrix
        .factor(Kind::Llt, &Ordering::Automatic)
        .expect("definite");
    let length = |e: Result<_, FactorError>| matches!(e, Err(FactorError::Length { .. }));
    assert!(length(factor.solve(&mut [1.0; 10])));
    assert!(length(factor.refactor(&[1.0]).map(|_| ())));
    assert_eq!(factor.solve(&mut [1.0; 9]), Err(FactorError::NotFactored));
    for value in [f64::NAN, f64::INFINITY] {
        let mut values = matrix.values.clone();
        values[matrix.pattern.slot(5, 4).expect("neighbours")] = value;
        let error = factor.refactor(&values).expect_err("not finite");
        assert!(
            matches!(error, FactorError::NotFinite { row: 5, col: 4, .. }),
            "{error}"
        );
    }
    for order in [vec![0], vec![0; 9], (1..10).collect()] {
        let refused = Analysis::new(&matrix.pattern, &Ordering::Given(order)).err();
        assert_eq!(refused, Some(FactorError::Order { n: 9 }));
    }
}

/// Either order leaves far fewer entries than the natural one, and METIS' postordered.
#[test]
fn orderings_leave_fewer_entries() {
    let matrix = laplacian(60, 2, 0.0);
    let fill = |ordering: Ordering| matrix.analyse(&ordering).fill() as f64;
    let natural = fill(Ordering::Natural);
    assert!(fill(Ordering::MinimumDegree) < 0.6 * natural);
    assert!(fill(Ordering::NestedDissection) < 0.6 * natural);
}

/// With storage by columns and by dense blocks: what the rows see after the first half, and the solution after forces on
/// them have been added.
#[test]
fn halves_of_a_solve_within_reach_make_the_whole() {
    for (matrix, ordering) in [
        (laplacian(12, 2, 0.0), Ordering::Natural),
        (random(60, 2, 5), Ordering::MinimumDegree),
        (laplacian(10, 3, 0.0), Ordering::Natural),
    ] {
        let (factor, _) = matrix.factor(Kind::Llt, &ordering).expect("definite");
        let n = matrix.pattern.dim();
        let has_blocks = factor.panels().any(|panel| panel.size > 1);
        assert_eq!(has_blocks, n == 1000);
        let steps = factor.analysis().steps();
        let root = factor.analysis().unknown(n - 1);
        let ends = [1, n / 3, root];
        let whole = Reach::whole(&factor);
        let reach = Reach::of(&factor, ends.iter().map(|&j| steps[j]));
        let (b, f): (Vec<f64>, Vec<f64>) = (noise(1).take(n).collect(), noise(2).take(3).collect());
        let mut forced = b.clone();
        ends.iter().zip(&f).for_each(|(&j, f)| forced[j] += f);
        let dense = matrix.dense().cholesky().expect("definite");
        let solve = |b: &[f64]| dense.solve(&nalgebra::DVector::from_column_slice(b));
        let by_step = |b: &[f64]| {
            let mut x = vec![0.0; n];
            (0..n).for_each(|j| x[steps[j]] = b[j]);
            x
        };

        let mut half = by_step(&b);
        factor.forward(&whole, &mut half);
        let mut seen = half.clone();
        factor.backward(&reach, &mut seen);
        let free = solve(&b);
        for &j in &ends {
            let (x, known) = (seen[steps[j]], free[j]);
            assert!((x - known).abs() < 1e-12 * free.amax(), "{x} for {known}");
        }
        let mut pushed = vec![0.0; n];
        ends.iter()
            .zip(&f)
            .for_each(|(&j, f)| pushed[steps[j]] = *f);
        factor.forward(&reach, &mut pushed);
        half.iter_mut().zip(&pushed).for_each(|(x, p)| *x += p);
        factor.backward(&whole, &mut half);
        let known = solve(&forced);
        for j in 0..n {
            let (x, known_j) = (half[steps[j]], known[j]);
            assert!(
                (x - known_j).abs() < 1e-12 * known.amax(),
                "{x} for {known_j}"
            );
        }
    }
}
