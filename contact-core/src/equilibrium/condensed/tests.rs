//! The dense problem against enumeration, W against the inverse, and small problems with known solutions.

use faer::Mat;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};

use super::*;
use crate::gaps::{Row, Sampling};
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{Energy, Error, RowKey, Scale};

/// E(u) = ½ uᵀK u − f·u under fixed rows.
struct Quadratic {
    pattern: SymmetricPattern,
    values: Vec<f64>,
    load: Vec<f64>,
    blocks: Vec<std::ops::Range<usize>>,
    is_quadratic: bool,
    bounds: Bounds,
    gaps: LinearGaps,
    /// Requested whenever the gradient is evaluated.
    stops: Option<Stop>,
}

impl Quadratic {
    fn new(K: &DMatrix<f64>, load: &[f64], rows: &[(Vec<f64>, f64)]) -> Self {
        let n = load.len();
        let places = (0..n).flat_map(|j| (j..n).map(move |i| (i, j)));
        let coupled = places.filter(|&(i, j)| i == j || K[(i, j)] != 0.0);
        let entries: Vec<_> = coupled.map(|(i, j)| (i, j, K[(i, j)])).collect();
        let (pattern, values) = SymmetricPattern::from_sums(n, &entries).expect("in range");
        let mut gaps = LinearGaps::new(true);
        for (k, (row, constant)) in rows.iter().enumerate() {
            let free = row.iter().copied().enumerate().filter(|(_, a)| *a != 0.0);
            let row = Row {
                free: free.collect(),
                constant: *constant,
                ..Row::default()
            };
            gaps.push(key(k), &row);
        }
        Quadratic {
            pattern,
            values,
            load: load.to_vec(),
            blocks: std::iter::once(0..n).collect(),
            is_quadratic: true,
            bounds: Bounds::default(),
            gaps,
            stops: None,
        }
    }

    fn start(&self) -> State {
        State {
            u: vec![0.0; self.load.len()],
            ..State::default()
        }
    }
}

fn key(k: usize) -> RowKey {
    RowKey {
        pass: 0,
        node: k as u32,
    }
}

impl Energy for Quadratic {
    fn dofs(&self) -> usize {
        self.load.len()
    }
    fn value(&self, u: &[f64]) -> f64 {
        let mut Ku = vec![0.0; u.len()];
        self.pattern.product(&self.values, u, &mut Ku);
        let terms = u.iter().zip(Ku.iter().zip(&self.load));
        terms.map(|(u, (Ku, f))| u * (0.5 * Ku - f)).sum()
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.stops.iter().for_each(Stop::request);
        self.pattern.product(&self.values, u, g);
        g.iter_mut().zip(&self.load).for_each(|(g, f)| *g -= f);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&self.values);
    }
    fn blocks(&self) -> Vec<std::ops::Range<usize>> {
        self.blocks.clone()
    }
    fn is_quadratic(&self) -> bool {
        self.is_quadratic
    }
}

impl ContactProblem for Quadratic {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(self.gaps.clone())
    }
    fn scale(&self) -> Option<Scale> {
        Some(Scale::default())
    }
}

fn solve(problem: &Quadratic) -> Solution {
    let solved = Condensed::new().solve_from(problem, problem.start());
    solved.expect("a quadratic problem")
}

/// A matrix of full rank, or of a lower one with rows that repeat.
fn factor_of_compliance(random: &mut Rng, m: usize) -> DMatrix<f64> {
    let rank = random.usize(1..=m);
    let mut C = DMatrix::from_fn(m, rank, |_, _| 2.0 * random.f64() - 1.0);
    for i in 1..m {
        if random.usize(0..3) == 0 {
            let same = C.row(random.usize(0..i)) * (0.5 + random.f64());
            C.set_row(i, &same);
        }
    }
    C
}

/// The multipliers of some active set that solves the problem, tried in all of them.
fn enumerated(W: &DMatrix<f64>, q: &DVector<f64>) -> Option<DVector<f64>> {
    let m = q.len();
    (0..1usize << m).find_map(|set| {
        let active: Vec<usize> = (0..m).filter(|i| set >> i & 1 == 1).collect();
        let k = active.len();
        let W_AA = DMatrix::from_fn(k, k, |a, b| W[(active[a], active[b])]);
        let q_A = DVector::from_fn(k, |a, _| -q[active[a]]);
        let x = match k {
            0 => q_A,
            _ => W_AA.lu().solve(&q_A)?,
        };
        let mut lambda = DVector::zeros(m);
        active
            .iter()
            .zip(x.iter())
            .for_each(|(&i, x)| lambda[i] = *x);
        let c = W * &lambda + q;
        let is_solution = lambda.min() >= -1e-9 && c.min() >= -1e-9;
        (is_solution && lambda.dot(&c).abs() < 1e-9).then_some(lambda)
    })
}

#[test]
fn dense_problems_have_the_gaps_of_the_active_set_that_enumeration_finds() {
    let mut random = Rng::with_seed(1);
    let mut found = 0;
    for case in 0..400 {
        let m = random.usize(1..9);
        let C = factor_of_compliance(&mut random, m);
        let W = &C * C.transpose();
        // q in the range of C is feasible; a part of it degenerate, with gaps and forces both zero
        let x = DVector::from_fn(C.ncols(), |_, _| 2.0 * random.f64() - 1.0);
        let open = DVector::from_fn(m, |_, _| if random.bool() { 0.0 } else { random.f64() });
        let q = &C * x + open;
        let Some(expected) = enumerated(&W, &q) else {
            continue;
        };
        found += 1;
        let dense = Mat::from_fn(m, m, |i, j| W[(i, j)]);
        let start: Vec<f64> = (0..m)
            .map(|_| random.f64() * f64::from(random.u8(0..2)))
            .collect();
        let gaps = &W * DVector::from_column_slice(&start) + &q;
        let solved = complementarity::solve(&dense, gaps.as_slice(), &start, 1e-12, &Stop::new())
            .expect("solvable");
        let lambda = DVector::from_vec(solved.lambda);
        let gaps = &W * &lambda + &q;
        assert!(lambda.min() >= 0.0 && gaps.min() >= -1e-9, "{case}: {gaps}");
        assert!(lambda.dot(&gaps).abs() < 1e-8, "{case}: {lambda} {gaps}");
        // λ is not unique, but the gaps are
        let exact = &W * expected + &q;
        assert!((gaps - exact).amax() < 1e-7, "{case}");
    }
    assert!(found > 200, "{found}");
}

/// Pairs of rows that differ by 1e-5 of what a body yields, beside a motion of the whole body that yields a hundred times more:
/// the compliance of their differences is 1e-10 of that of the rows.
#[test]
fn rows_that_nearly_depend_on_each_other_are_complementary_beside_a_soft_motion() {
    let mut random = Rng::with_seed(7);
    for case in 0..20 {
        let (pairs, m) = (20, 40);
        let mut C = DMatrix::from_fn(m, 1 + pairs, |_, j| match j {
            0 => 1.0,
            _ => 0.01 * (2.0 * random.f64() - 1.0),
        });
        for i in 0..pairs {
            let near = C.row(i).map(|a| a + 1e-5 * (2.0 * random.f64() - 1.0));
            C.set_row(pairs + i, &near);
        }
        let W = &C * C.transpose();
        // a solution: every second pair acts, and the others are open
        let acts = |i: usize| i % 2 == 0;
        let force = DVector::from_fn(m, |i, _| if acts(i) { 0.1 + random.f64() } else { 0.0 });
        let open = DVector::from_fn(m, |i, _| if acts(i) { 0.0 } else { 0.1 + random.f64() });
        let gaps = &open - &W * &force;
        let dense = Mat::from_fn(m, m, |i, j| W[(i, j)]);
        let start = vec![0.0; m];
        let solved = complementarity::solve(&dense, gaps.as_slice(), &start, 1e-13, &Stop::new())
            .expect("solvable");
        assert!(solved.left <= 1.0, "{case}: {:.1e}", solved.left);
        let lambda = DVector::from_vec(solved.lambda);
        // without the round-off of W times λ
        let gaps = &C * (C.transpose() * (&lambda - &force)) + &open;
        let left = lambda.zip_map(&gaps, |l, c| l.min(c).abs()).max();
        assert!(left < 1e-12, "{case}: {left:e}");
    }
}

/// Where more rows act than a body has motions, errors of W leave it indefinite, and no λ closes all gaps. Factors with a small ε fail
/// then; λ is what a larger one gives, with the errors of W in the gaps.
#[test]
fn a_compliance_that_errors_leave_indefinite_is_solved_up_to_these_errors() {
    const ERROR: f64 = 1e-10;
    let mut random = Rng::with_seed(8);
    for case in 0..40 {
        let (m, rank) = (30, 8);
        let C = DMatrix::from_fn(m, rank, |_, _| 2.0 * random.f64() - 1.0);
        let mut W = &C * C.transpose();
        for i in 0..m {
            for j in 0..=i {
                W[(i, j)] += ERROR * (2.0 * random.f64() - 1.0);
                W[(j, i)] = W[(i, j)];
            }
        }
        let acts = |i: usize| i % 2 == 0;
        let force = DVector::from_fn(m, |i, _| if acts(i) { 0.1 + random.f64() } else { 0.0 });
        let open = DVector::from_fn(m, |i, _| if acts(i) { 0.0 } else { 0.1 + random.f64() });
        let free = &open - &C * (C.transpose() * &force);
        let dense = Mat::from_fn(m, m, |i, j| W[(i, j)]);
        let start = vec![0.0; m];
        let solved = complementarity::solve(&dense, free.as_slice(), &start, 1e-13, &Stop::new())
            .expect("solvable but for the errors");
        let lambda = DVector::from_vec(solved.lambda);
        let gaps = &W * &lambda + &free;
        let left = lambda.zip_map(&gaps, |l, c| l.min(c).abs()).max();
        // an error of each coefficient, times forces of this size
        let bound = 10.0 * ERROR * force.sum();
        assert!(left < bound, "{case}: {left:e} of {bound:e}");
    }
}

/// A definite matrix that couples neighbours on a line, a grid or a cube, and its factor.
fn grid(n: usize, dim: u32) -> (crate::linear::Cholesky, DMatrix<f64>) {
    use crate::linear::{Analysis, Cholesky, Factor, Kind, Ordering};
    let mut entries = Vec::new();
    for k in 0..n.pow(dim) {
        entries.push((k, k, 2.1 * f64::from(dim)));
        let steps = (0..dim).map(|d| n.pow(d)).filter(|step| k / step % n > 0);
        entries.extend(steps.map(|step| (k, k - step, -1.0)));
    }
    let size = n.pow(dim);
    let (pattern, values) = SymmetricPattern::from_sums(size, &entries).expect("in range");
    let analysis = Analysis::new(&pattern, &Ordering::Automatic).expect("a pattern");
    let mut factor = Cholesky::new(&analysis, Kind::Llt).expect("memory");
    factor.refactor(&values).expect("definite");
    let mut dense = DMatrix::zeros(size, size);
    for ((i, j), a) in pattern.iter().zip(values) {
        (dense[(i, j)], dense[(j, i)]) = (a, a);
    }
    (factor, dense)
}

#[test]
fn pruned_solves_give_the_compliance_of_the_dense_inverse() {
    let mut random = Rng::with_seed(2);
    for (n, dim) in [(1, 1), (30, 1), (12, 2), (9, 3)] {
        let (factor, K) = grid(n, dim);
        let size = K.nrows();
        for m in [0, 1, 40] {
            let mut C: DMatrix<f64> = DMatrix::zeros(m, size);
            let mut coefficients = Vec::new();
            for i in 0..m {
                for _ in 0..4 {
                    let (step, a) = (random.usize(0..size), random.f64() - 0.5);
                    C[(i, factor.analysis().unknown(step))] += a;
                    coefficients.push((i, step, a));
                }
            }
            let found = pruned::gram(&factor, m, coefficients, &Stop::new());
            let found = found.expect("no request");
            let inverse = K.clone().try_inverse().expect("definite");
            let W: DMatrix<f64> = &C * inverse * C.transpose();
            for i in 0..m {
                for j in 0..=i {
                    let error = (found[(i, j)] - W[(i, j)]).abs();
                    assert!(error < 1e-12 * W.amax(), "{n}^{dim}: {error:e}");
                }
            }
        }
    }
}

/// Two springs of stiffness 1 and 3 that meet halfway: the first is pulled by 2 over a gap of 1.
fn springs(rows: &[(Vec<f64>, f64)]) -> Quadratic {
    let K = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 3.0]);
    let mut problem = Quadratic::new(&K, &[2.0, 0.0], rows);
    problem.blocks = vec![0..1, 1..2];
    problem
}

#[test]
fn springs_share_the_force() {
    // u₁ = 1 + u₂ and u₁ + 3 u₂ = 2
    let problem = springs(&[(vec![-1.0, 1.0], 1.0)]);
    let solution = solve(&problem);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!(
        (solution.state.u[0] - 1.25).abs() < 1e-12 && (solution.state.u[1] - 0.25).abs() < 1e-12
    );
    assert!((solution.lambda[0] - 0.75).abs() < 1e-12);
    let cost = solution.cost();
    assert_eq!(
        (cost.factorizations, cost.hessians, cost.gradients),
        (1, 1, 1)
    );
}

#[test]
fn parallel_rows_share_their_force_evenly() {
    let rows = [
        (vec![-1.0, 1.0], 1.0),
        (vec![-2.0, 2.0], 2.0),
        (vec![-1.0, 1.0], 1.5),
    ];
    let solution = solve(&springs(&rows));
    // a row twice as long acts twice as much
    let lambda = &solution.lambda;
    assert!((lambda[0] - 0.375).abs() < 1e-12 && (lambda[1] - 0.1875).abs() < 1e-12);
    assert_eq!(lambda[2], 0.0, "its gap is open");
    let multiplier = solution.state.multipliers.of(key(1));
    assert_eq!(multiplier, lambda[1]);
}

#[test]
fn problems_without_rows_are_linear() {
    let solution = solve(&springs(&[]));
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_eq!(solution.state.u, [2.0, 0.0]);
    assert!((solution.energy + 2.0).abs() < 1e-15);
}

/// Two unknowns tied by a spring of stiffness 1 and by nothing else, pushed by 1 towards a wall at distance 2.
fn floating(wall: bool) -> Quadratic {
    let K = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
    let rows = [(vec![0.0, -1.0], 2.0)];
    Quadratic::new(&K, &[1.0, 0.0], if wall { &rows } else { &[] })
}

#[test]
fn bodies_that_float_come_to_rest_on_a_wall() {
    let solution = solve(&floating(true));
    assert_eq!(solution.outcome, Outcome::Converged);
    let u = &solution.state.u;
    assert!(
        (u[0] - 3.0).abs() < 1e-8 && (u[1] - 2.0).abs() < 1e-8,
        "{u:?}"
    );
    assert!((solution.lambda[0] - 1.0).abs() < 1e-9);
    assert_eq!(solution.cost().factorizations, 2, "K, and K with its shift");
}

/// Two nodes with a spring of stiffness 1 between them are pushed to a wall, which is up to 1e10 times as far as the spring is pressed.
#[test]
fn bodies_that_float_come_to_rest_however_far_what_stops_them_is() {
    for (way, load) in [
        (2.0, 1e-3),
        (2.0, 1e-6),
        (2.0, 1e-10),
        (1e4, 1.0),
        (1e6, 1e-3),
    ] {
        let K = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
        let problem = Quadratic::new(&K, &[load, 0.0], &[(vec![0.0, -1.0], way)]);
        let solution = solve(&problem);
        assert_eq!(solution.outcome, Outcome::Converged, "{way} {load}");
        let u = &solution.state.u;
        let left = [u[0] - way - load, u[1] - way].map(f64::abs);
        assert!(left[0].max(left[1]) < 1e-9 * way, "{way} {load}: {u:?}");
        // the spring sees a difference of displacements
        let roundoff = 64.0 * f64::EPSILON * way / load;
        let error = (solution.lambda[0] / load - 1.0).abs();
        assert!(error < 1e-8 + roundoff, "{way} {load}: {error:e}");
    }
}

#[test]
fn bodies_that_nothing_holds_are_named() {
    let solution = solve(&floating(false));
    let Outcome::SubproblemFailed(why) = &solution.outcome else {
        panic!("{}", solution.outcome);
    };
    assert!(why.contains("unknowns 0 to 1"), "{why}");
    assert!(solution.history[0].error.is_infinite());
}

#[test]
fn undetermined_motions_stay_at_the_start() {
    let mut problem = floating(false);
    problem.load = vec![1.0, -1.0];
    let start = State {
        u: vec![7.0, 7.0],
        ..State::default()
    };
    let solution = Condensed::new()
        .solve_from(&problem, start)
        .expect("quadratic");
    assert_eq!(solution.outcome, Outcome::Converged);
    let u = &solution.state.u;
    assert!(
        (u[0] - 7.5).abs() < 1e-7 && (u[1] - 6.5).abs() < 1e-7,
        "{u:?}"
    );
}

#[test]
fn rows_that_contradict_each_other_are_a_failure() {
    let rows = [(vec![1.0, 0.0], -1.0), (vec![-1.0, 0.0], 0.5)];
    let solution = solve(&springs(&rows));
    assert!(
        matches!(solution.outcome, Outcome::SubproblemFailed(_)),
        "{}",
        solution.outcome
    );
    let overlap = solve(&springs(&[(vec![0.0, 0.0], -1.0)]));
    let Outcome::SubproblemFailed(why) = overlap.outcome else {
        panic!("{}", overlap.outcome);
    };
    assert!(why.contains("prescribed"), "{why}");
}

#[test]
fn energies_that_are_not_convex_are_a_failure() {
    let K = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
    let solution = solve(&Quadratic::new(&K, &[1.0, 0.0], &[]));
    let Outcome::SubproblemFailed(why) = solution.outcome else {
        panic!("{}", solution.outcome);
    };
    assert!(why.contains("not convex"), "{why}");
}

#[test]
fn what_is_not_treated_is_named() {
    let refused = |problem: &Quadratic| {
        let refused = Condensed::new().solve_from(problem, problem.start());
        refused.expect_err("not a problem of this kind").to_string()
    };
    let mut problem = springs(&[]);
    problem.is_quadratic = false;
    assert!(refused(&problem).contains("`Energy::is_quadratic` = false"));
    let mut problem = springs(&[]);
    problem.gaps = LinearGaps::new(false);
    assert!(refused(&problem).contains("`LinearGaps::is_exact` = false"));
    let mut problem = springs(&[]);
    problem.bounds = Bounds::free(2);
    assert_eq!(
        solve(&problem).outcome,
        Outcome::Converged,
        "infinite bounds are none"
    );
    problem.bounds.upper[1] = 0.5;
    assert!(refused(&problem).contains("0.5 on unknown 1"));
    let problem = springs(&[(vec![f64::NAN, 1.0], 0.0)]);
    assert!(refused(&problem).contains("not finite"));
    let mut problem = springs(&[]);
    problem.load[0] = f64::NAN;
    assert_eq!(solve(&problem).outcome, Outcome::InadmissibleStart);
}

#[test]
fn a_request_to_stop_ends_the_solve() {
    let problem = springs(&[(vec![-1.0, 1.0], 1.0)]);
    let (start, stop) = (problem.start(), Stop::new());
    stop.request();
    let lifted = || problem.start();
    let context = StepContext::single(&start, &lifted, &stop);
    let solution = Condensed::new().solve(&problem, problem.start(), &context);
    assert_eq!(solution.expect("quadratic").outcome, Outcome::Interrupted);
}

/// A stop between the factors and the compliance leaves nothing half done for the next solve.
#[test]
fn a_solver_that_was_stopped_solves_again() {
    let mut problem = springs(&[(vec![-1.0, 1.0], 1.0)]);
    problem.load[0] = 4.0;
    let stop = Stop::new();
    problem.stops = Some(stop.clone());
    let start = problem.start();
    let lifted = || start.clone();
    let mut solver = Condensed::new();
    let context = StepContext::single(&start, &lifted, &stop);
    let stopped = solver.solve(&problem, problem.start(), &context);
    assert_eq!(stopped.expect("quadratic").outcome, Outcome::Interrupted);
    problem.stops = None;
    let solution = solver.solve_from(&problem, problem.start());
    let solution = solution.expect("quadratic");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!((solution.state.u[0] - 1.75).abs() < 1e-11);
}

#[test]
fn factors_are_kept_until_the_stiffness_changes() {
    let mut problem = springs(&[(vec![-1.0, 1.0], 1.0)]);
    let mut solver = Condensed::new();
    let mut at = problem.start();
    let mut factorizations = 0;
    for k in 1..=100 {
        problem.load[0] = 0.04 * f64::from(k);
        let solution = solver.solve_from(&problem, at).expect("quadratic");
        assert_eq!(solution.outcome, Outcome::Converged);
        factorizations += solution.cost().factorizations;
        at = solution.state;
    }
    assert_eq!(factorizations, 1);
    assert!((at.u[0] - 1.75).abs() < 1e-12, "u₁ + 3 (u₁ − 1) = 4");
    let slot = problem.pattern.slot(1, 1).expect("a diagonal");
    problem.values[slot] = 6.0;
    let again = solver.solve_from(&problem, at).expect("quadratic");
    assert_eq!(again.cost().factorizations, 1);
    // a tenth of 1e-10 of the displacements is left of complementarity where the multipliers are known nearly
    assert!((again.state.u[0] - 10.0 / 7.0).abs() < 2e-11);
}

/// Random convex problems: the conditions of Karush, Kuhn and Tucker hold.
#[test]
fn random_problems_satisfy_the_conditions_of_a_minimum() {
    let mut random = Rng::with_seed(4);
    for case in 0..200 {
        let n = random.usize(1..12);
        let A = DMatrix::from_fn(n, n, |_, _| random.f64() - 0.5);
        let K = &A * A.transpose() + DMatrix::identity(n, n) * 0.1;
        let load: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        let m = random.usize(0..2 * n);
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for _ in 0..m {
            let row = match random.usize(0..4) {
                0 if !rows.is_empty() => rows[random.usize(0..rows.len())].0.clone(),
                _ => (0..n).map(|_| random.f64() - 0.5).collect(),
            };
            rows.push((row, 0.2 * random.f64()));
        }
        assert_minimum(&Quadratic::new(&K, &load, &rows), case);
    }
}

/// Bodies without a load that overlap at the start. More rows than unknowns act, and one displacement satisfies them all.
#[test]
fn interference_alone_moves_bodies() {
    let mut random = Rng::with_seed(8);
    for case in 0..200 {
        let n = random.usize(2..12);
        let A = DMatrix::from_fn(n, n, |_, _| random.f64() - 0.5);
        let K = &A * A.transpose() + DMatrix::identity(n, n) * 0.1;
        let common: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        let rows: Vec<(Vec<f64>, f64)> = (0..random.usize(n..3 * n))
            .map(|_| {
                let weights: Vec<f64> = (0..n).map(|_| random.f64()).collect();
                let product: f64 = weights.iter().zip(&common).map(|(a, u)| a * u.abs()).sum();
                (weights, -0.1 * product)
            })
            .collect();
        let solution = assert_minimum(&Quadratic::new(&K, &vec![0.0; n], &rows), case);
        assert!(solution.lambda.iter().any(|l| *l > 0.0), "{case}");
    }
}

/// Solves a problem; the solution satisfies the conditions of Karush, Kuhn and Tucker.
fn assert_minimum(problem: &Quadratic, case: usize) -> Solution {
    let solution = solve(problem);
    assert_eq!(solution.outcome, Outcome::Converged, "{case}");
    let mut g = vec![0.0; problem.dofs()];
    problem.gradient(&solution.state.u, &mut g);
    let mut forces = vec![0.0; problem.dofs()];
    solution.gaps.add_forces(&solution.lambda, &mut forces);
    let left = g.iter().zip(&forces).map(|(g, f)| (g - f).abs());
    assert!(left.fold(0.0, f64::max) < 1e-10, "{case}");
    let mut c = vec![0.0; solution.lambda.len()];
    solution.gaps.value(&solution.state.u, &mut c);
    for (c, l) in c.iter().zip(&solution.lambda) {
        assert!(
            *c > -1e-8 && *l >= 0.0 && (c * l).abs() < 1e-8,
            "{case}: {c:e} {l:e}"
        );
    }
    solution
}

/// Contact and Coulomb's law at the multipliers, from W and the gaps alone: the largest violation (UL).
fn violation(W: &Mat<f64>, q: &[f64], laws: &[coulomb::Law], multipliers: &[f64]) -> f64 {
    let m = q.len();
    let gap = |i: usize| q[i] + (0..m).map(|j| W[(i, j)] * multipliers[j]).sum::<f64>();
    let contacts = (0..m).filter(|i| laws.iter().all(|law| law.slip != *i));
    let of_contact = contacts.map(|i| {
        let (c, l) = (gap(i), multipliers[i] * W[(i, i)]);
        (-c).max(-l).max(c.abs().min(l.abs()))
    });
    let of_slips = laws.iter().map(|law: &coulomb::Law| {
        let i = law.slip;
        let (s, z) = (gap(i), multipliers[i]);
        let threshold = (law.factor * multipliers[law.contact]).min(law.bound);
        let [excess, lacks] =
            [z.abs() - threshold, threshold + z * s.signum()].map(|f| f * W[(i, i)]);
        excess.max(lacks.abs().min(s.abs()))
    });
    of_contact.chain(of_slips).fold(0.0, f64::max)
}

/// Nodes on random springs, whose slips are held back: rows of contact and of slips in turn, some of them twice.
#[test]
fn coulombs_law_holds_on_random_springs() {
    let mut random = Rng::with_seed(11);
    let (mut seen, mut unsolved) = ([0; 3], 0);
    for trial in 0..400 {
        let nodes = random.usize(1..7);
        let twice = trial % 2 == 0;
        let mut next = || 2.0 * random.f64() - 1.0;
        let (n, copies) = (2 * nodes, if twice { 2 } else { 1 });
        let F: DMatrix<f64> = DMatrix::from_fn(n, n, |_, _| next());
        let stiff: DMatrix<f64> = &F * F.transpose() + DMatrix::<f64>::identity(n, n) * 0.1;
        let inverse = stiff.try_inverse().expect("definite");
        // unknown 2k is the normal motion of node k, and 2k + 1 its tangential one
        let m = n * copies;
        let W = Mat::from_fn(m, m, |i, j| inverse[(i % n, j % n)]);
        let q: Vec<f64> = (0..n).map(|_| next()).collect();
        let q: Vec<f64> = (0..m).map(|i| q[i % n]).collect();
        let friction = [0.0, 0.1, 0.3, 0.5, 0.7][trial % 5];
        let laws = (0..m / 2).map(|k| coulomb::Law {
            slip: 2 * k + 1,
            contact: 2 * k,
            factor: friction,
            bound: [f64::INFINITY, f64::INFINITY, 0.0, 0.2][k % nodes % 4],
        });
        let laws: Vec<_> = laws.collect();
        let solved = coulomb::solve_coulomb(&W, &q, &vec![0.0; m], &laws, 1e-10, &Stop::default());
        let solved = solved.expect("sound");
        if solved.left > 1.0 {
            // where friction is strong, there may be no solution
            assert!(friction > 0.6, "{trial}: {solved:?}");
            unsolved += 1;
            continue;
        }
        let left = violation(&W, &q, &laws, &solved.lambda);
        assert!(left < 1e-9, "{trial}: {left:e}");
        for law in &laws {
            let threshold = (friction * solved.lambda[law.contact]).min(law.bound);
            let force = solved.lambda[law.slip].abs();
            let status = match threshold > 1e-9 {
                true if force < (1.0 - 1e-6) * threshold => 1,
                true => 2,
                false => 0,
            };
            seen[status] += 1;
        }
    }
    assert!(unsolved <= 4, "{unsolved} of 80 with a coefficient of 0.7");
    assert!(
        seen.iter().all(|count| *count > 100),
        "open, stick, slip: {seen:?}"
    );
}
