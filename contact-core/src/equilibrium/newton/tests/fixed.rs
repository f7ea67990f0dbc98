//! Quadratic energies under fixed rows: K definite, indefinite, or replaced by another one.

use fastrand::Rng;

use super::*;

/// Two springs side by side, tied to each other: the first is pulled by 3 against a wall at 1, the wall of the second is
/// far away.
fn against_a_wall() -> Toy {
    let K = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 2.0]);
    let walls = [(vec![-1.0, 0.0], 1.0), (vec![0.0, -1.0], 10.0)];
    Toy::quadratic(&K, &[3.0, 0.0], &walls)
}

/// u₁ = 1 and 2 u₂ = u₁; the wall carries what is left of the 3.
fn assert_at_the_wall(solution: &Solution) {
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &[1.0, 0.5], 1e-12);
    assert_near(&solution.lambda, &[1.5, 0.0], 1e-12);
    assert!((solution.energy + 2.25).abs() < 1e-12);
}

#[test]
fn one_row_acts_and_the_other_does_not() {
    let toy = against_a_wall();
    let solution = toy.solve_from(&[0.0; 2]);
    assert_at_the_wall(&solution);
    assert_eq!(solution.gaps.len(), 2);
    let errors: Vec<f64> = solution.history.iter().map(|i| i.error).collect();
    assert!(
        errors.len() == 2 && errors[1] < 1e-14,
        "one step is all: {errors:?}"
    );
}

#[test]
fn the_start_does_not_matter() {
    let toy = against_a_wall();
    for (u, lambda) in [
        ([0.0, 0.0], [0.0, 7.0]),
        ([5.0, 30.0], [0.0, 0.0]),
        ([5.0, 30.0], [2.0, 3.0]),
        ([-9.0, 4.0], [100.0, 100.0]),
    ] {
        let start = with_multipliers(&toy, &u, &lambda);
        let solution = CondensedNewton::default().solve_from(&toy, start);
        assert_at_the_wall(&solution.expect("a valid problem"));
    }
}

#[test]
fn without_rows_it_is_newtons_method() {
    let K = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 2.0]);
    let solution = Toy::quadratic(&K, &[3.0, 0.0], &[]).solve_from(&[4.0, -4.0]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &[2.0, 1.0], 1e-12);
    assert!(solution.lambda.is_empty());
}

fn random_matrix(random: &mut Rng, n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |_, _| random.f64() - 0.5)
}

#[test]
fn random_convex_problems_satisfy_the_conditions_of_a_minimum() {
    let mut random = Rng::with_seed(5);
    let (mut acting, mut open) = (0, 0);
    for case in 0..200 {
        let n = random.usize(1..12);
        let A = random_matrix(&mut random, n);
        let K = &A * A.transpose() + DMatrix::identity(n, n) * 0.1;
        let load: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for _ in 0..random.usize(0..2 * n) {
            let row = match random.usize(0..4) {
                // some depend on others
                0 if !rows.is_empty() => rows[random.usize(0..rows.len())].0.clone(),
                _ => (0..n).map(|_| random.f64() - 0.5).collect(),
            };
            // zero is feasible
            rows.push((row, 0.2 * random.f64()));
        }
        let toy = Toy::quadratic(&K, &load, &rows);
        let u: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        let lambda: Vec<f64> = rows.iter().map(|_| random.f64() - 0.5).collect();
        let start = with_multipliers(&toy, &u, &lambda);
        let solved = CondensedNewton::default().solve_from(&toy, start);
        let solution = solved.expect("a valid problem");
        assert_eq!(solution.outcome, Outcome::Converged, "{case}");
        let left = toy.left(&solution);
        assert!(left[0] < 1e-9 && left[1] < 1e-9, "{case}: {left:?}");
        acting += solution.lambda.iter().filter(|l| **l > 0.0).count();
        open += solution.lambda.iter().filter(|l| **l == 0.0).count();
    }
    assert!(acting > 200 && open > 200, "{acting} {open}");
}

/// The second unknown runs away from zero until its wall at −1 stops it.
fn saddle() -> (Toy, [f64; 3], f64) {
    let K = DMatrix::from_row_slice(3, 3, &[2.0, 0.5, 0.0, 0.5, -1.0, 0.5, 0.0, 0.5, 3.0]);
    let toy = Toy::quadratic(&K, &[1.0, -2.0, 0.0], &[(vec![0.0, 1.0, 0.0], 1.0)]);
    // u₂ = −1 leaves 2 u₁ = 1 + ½ and 3 u₃ = ½; λ = ½ u₁ − u₂ + ½ u₃ + 2
    let u = [0.75, -1.0, 1.0 / 6.0];
    (toy, u, 0.375 + 1.0 + 1.0 / 12.0 + 2.0)
}

#[test]
fn an_indefinite_hessian_that_is_convex_on_the_acting_row() {
    let (toy, u, lambda) = saddle();
    for start in [[0.0, -1.5, 0.0], [3.0, -4.0, -2.0]] {
        let solution = toy.solve_from(&start);
        assert_eq!(solution.outcome, Outcome::Converged, "{start:?}");
        assert_near(&solution.state.u, &u, 1e-9);
        assert_near(&solution.lambda, &[lambda], 1e-9);
    }
    let start = with_multipliers(&toy, &[0.0; 3], &[5.0]);
    let solution = CondensedNewton::default().solve_from(&toy, start);
    assert_near(&solution.expect("a valid problem").state.u, &u, 1e-9);
}

/// A soft chain opens from its wall by δ, while another unknown needs stiffness added at its own wall. A factor that still
/// has stiffness at the chain's wall takes the force that is left for one that moves the chain by 1e-9, where it moves it by δ.
#[test]
fn stiffness_on_a_row_that_opens_hides_nothing() {
    for (k, delta) in [(1e5, 1e-3), (1e4, 1e-4), (1e3, 1e-5)] {
        let K = DMatrix::from_row_slice(3, 3, &[k + 1.0, -k, 0.0, -k, k, 0.0, 0.0, 0.0, -1.0]);
        let walls = [(vec![0.0, -1.0, 0.0], 1.0), (vec![0.0, 0.0, -1.0], 1.0)];
        let pull = (1.0 - delta) / (1.0 + 1.0 / k);
        let toy = Toy::quadratic(&K, &[0.0, pull, 1.0], &walls);
        let start = with_multipliers(&toy, &[k / (k + 1.0), 1.0, 1.0], &[0.1, 2.0]);
        let solution = CondensedNewton::default().solve_from(&toy, start);
        let solution = solution.expect("a valid problem");
        assert_eq!(solution.outcome, Outcome::Converged);
        assert_near(&solution.state.u, &[pull, 1.0 - delta, 1.0], 1e-8);
    }
}

/// A wall twice, and one that touches without a force: rows that act in one step and not in the next, but for round-off.
#[test]
fn rows_that_may_or_may_not_act_do_not_go_on_for_ever() {
    let (saddle, u, lambda) = saddle();
    let K = (saddle.hessian)(&u);
    let wall = (vec![0.0, 1.0, 0.0], 1.0);
    for touch in [0.0, 1e-17, -1e-17, 1e-16, -1e-16, 1e-12, -1e-12] {
        let beside = (vec![-1.0, 0.0, 0.0], 0.75 + touch);
        let slanted = (vec![0.3, 0.2, 0.7], 0.2 - 0.225 - 0.7 / 6.0 + touch);
        let walls = [wall.clone(), wall.clone(), beside, slanted];
        let toy = Toy::quadratic(&K, &[1.0, -2.0, 0.0], &walls);
        for start in [[0.0, -1.5, 0.0], [3.0, -4.0, -2.0], u] {
            let solution = toy.solve_from(&start);
            assert_eq!(solution.outcome, Outcome::Converged, "{touch} {start:?}");
            assert!(solution.history.len() < 12, "{}", solution.history.len());
            assert_near(&solution.state.u, &u, 1e-9);
            assert_near(&[solution.lambda.iter().take(2).sum()], &[lambda], 1e-9);
        }
    }
}

/// No row acts at the start: the diagonal is shifted until one does.
#[test]
fn an_indefinite_hessian_without_an_acting_row_at_the_start() {
    let (toy, u, lambda) = saddle();
    let solution = toy.solve_from(&[0.0, -0.5, 0.0]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &u, 1e-9);
    assert_near(&solution.lambda, &[lambda], 1e-9);
}

/// One solver, one pattern, and energies whose stiffness differs by `ratio`, either way.
fn one_after_the_other(ratio: f64) {
    let mut random = Rng::with_seed(6);
    for n in [2, 30] {
        let mut problem = |size: f64| {
            let A = random_matrix(&mut random, n);
            // a wide spectrum
            let own = DMatrix::from_fn(n, n, |i, j| if i == j { (1 + i * i) as f64 } else { 0.0 });
            let K = (&A * A.transpose() + own) * size;
            let load: Vec<f64> = (0..n).map(|_| size * (random.f64() + 0.1)).collect();
            let wall: Vec<f64> = (0..n).map(|k| if k == 0 { -1.0 } else { 0.0 }).collect();
            (Toy::quadratic(&K, &load, &[(wall, 0.01)]), size)
        };
        let problems = [problem(1.0), problem(ratio), problem(1.0)];
        let mut solver = CondensedNewton::default();
        for (toy, size) in &problems {
            let solution = toy.solve_with(&mut solver, &vec![0.0; n]);
            assert_eq!(solution.outcome, Outcome::Converged, "{ratio:e}, {n}");
            let [forces, rows] = toy.left(&solution);
            assert!(
                forces < 1e-7 * size && rows < 1e-9,
                "{ratio:e}, {n}: {forces:e} {rows:e}"
            );
            assert!(solution.lambda[0] > 0.0, "the row acts");
        }
    }
}

#[test]
fn a_kept_factor_does_not_spoil_another_energy() {
    for ratio in [1.0, 1e2, 1e-2, 1e4, 1e-4] {
        one_after_the_other(ratio);
    }
}

#[test]
fn a_kept_factor_does_not_spoil_a_far_stiffer_or_softer_energy() {
    for ratio in [1e7, 1e-7, 1e10, 1e-10] {
        one_after_the_other(ratio);
    }
}

#[test]
fn a_factor_is_kept_for_loads_nearby() {
    let mut solver = CondensedNewton::default();
    let K = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 2.0]);
    let (mut factorizations, mut u) = (0, vec![0.0; 2]);
    for k in 0..20 {
        let load = 1e-3 * f64::from(k);
        let wall = (vec![-1.0, 0.0], 1.0);
        let toy = Toy::quadratic(&K, &[3.0, load], &[wall]);
        let solution = toy.solve_with(&mut solver, &u);
        factorizations += solution.cost().factorizations;
        assert_near(&solution.state.u, &[1.0, 0.5 + 0.5 * load], 1e-12);
        u = solution.state.u;
    }
    assert!(factorizations < 10, "{factorizations} of about 40 steps");
    let other = Toy::quadratic(&DMatrix::identity(3, 3), &[1.0; 3], &[]);
    let solution = other.solve_with(&mut solver, &[0.0; 3]);
    assert_near(&solution.state.u, &[1.0; 3], 1e-12);
}

/// Newton's method on √(1 + u²) goes from u to −u³, away from the minimum at 0 where |u| > 1. Without the way back it would
/// never arrive.
#[test]
fn steps_that_lead_away_are_shortened() {
    let toy = Toy {
        value: Box::new(|u| (1.0 + u[0] * u[0]).sqrt()),
        gradient: Box::new(|u| vec![u[0] / (1.0 + u[0] * u[0]).sqrt()]),
        hessian: Box::new(|u| DMatrix::from_element(1, 1, (1.0 + u[0] * u[0]).powf(-1.5))),
        ..Toy::quadratic(&DMatrix::identity(1, 1), &[0.0], &[])
    };
    for start in [0.5, 1.5, 3.0] {
        let solution = toy.solve_from(&[start]);
        assert_eq!(solution.outcome, Outcome::Converged, "from {start}");
        assert_near(&solution.state.u, &[0.0], 1e-6);
    }
}
