//! Problems of the collection made degenerate, infeasible or unbounded, and one of a single variable.

use std::f64::consts::LN_2;

use contact_core::ipopt::{Options, Status};
use problems::assert_close;

use crate::{
    collection::problem,
    hyper_dual::HyperDual,
    kkt::Residuals,
    problem::{DEFAULT, INF, POSITIVE, Problem, X, ZERO},
    solutions::{Hessian, solve, wrong_conditions},
};

const HESSIANS: [Hessian; 2] = [Hessian::Exact, Hessian::LimitedMemory];

/// Solves with either Hessian, to the optimum and to one of the minimisers.
#[track_caller]
fn assert_solved(problem: Problem) {
    for hessian in HESSIANS {
        let solution = solve(problem, hessian, &Options::new());
        assert_eq!(solution.status, Status::Solved, "{hessian:?}");
        assert_close(&[solution.objective], &[problem.optimum], problem.precision);
        let near = |x: &&[f64]| {
            let mut pairs = x.iter().zip(&solution.x);
            pairs.all(|(a, b)| (a - b).abs() <= problem.x_precision)
        };
        let x = &solution.x;
        assert!(problem.minimisers.iter().any(near), "{hessian:?}: {x:?}");
        assert_eq!(wrong_conditions(problem, &solution), None, "{hessian:?}");
    }
}

/// The collection begins with two variables. min x − ln x with x ≥ ½: x* = 1, f* = 1. With x² ≥ 4 too, x* = 2 and
/// 1 − 1/x + λ 2 x = 0 has λ = −1/8.
#[test]
fn one_variable() {
    let free = Problem {
        name: "one variable",
        start: &[3.0],
        bounds: &[(0.5, INF)],
        f: |x| x[1] - x[1].ln(),
        optimum: 1.0,
        minimisers: &[&[1.0]],
        ..DEFAULT
    };
    assert_solved(free);
    let constrained = Problem {
        g: |x| vec![x[1].powi(2)],
        g_bounds: &[(4.0, INF)],
        optimum: 2.0 - LN_2,
        minimisers: &[&[2.0]],
        ..free
    };
    assert_solved(constrained);
    let solution = solve(constrained, Hessian::Exact, &Options::new());
    assert_close(&solution.multipliers.unwrap().constraints, &[-0.125], 1e-7);
}

/// HS071 has x₁* = 1; fixing x₁ there does not move the others. HS035 with x₂ = ½ has f* = ¼ where its constraint is
/// active with the multiplier 0, hence the root of the tolerance in x.
#[test]
fn fixed_variables() {
    assert_solved(Problem {
        bounds: &[(1.0, 1.0), (1.0, 5.0), (1.0, 5.0), (1.0, 5.0)],
        ..problem("HS071")
    });
    assert_solved(Problem {
        bounds: &[POSITIVE, (0.5, 0.5), POSITIVE],
        optimum: 0.25,
        minimisers: &[&[1.5, 0.5, 0.5]],
        x_precision: 1e-4,
        ..problem("HS035")
    });
    let all = Problem {
        bounds: &[(1.0, 1.0), (2.0, 2.0), (3.0, 3.0), (4.0, 4.0), (5.0, 5.0)],
        ..problem("HS045")
    };
    for hessian in HESSIANS {
        let solution = solve(all, hessian, &Options::new());
        assert_eq!(solution.status, Status::Solved);
        assert_close(&solution.x, all.minimisers[0], 0.0);
        assert_close(&[solution.objective], &[1.0], 1e-15);
        // Up to 3.13 Ipopt has none; since 3.14 it has −∂f/∂xᵢ = 1/i.
        if let Some(multipliers) = solution.multipliers {
            assert_close(&multipliers.lower, &[0.0; 5], 0.0);
            assert_close(&multipliers.upper, &[1.0, 0.5, 1.0 / 3.0, 0.25, 0.2], 1e-15);
        }
    }
}

/// HS013, a cusp: at x* = (1, 0) both ∇g = (0, −1) and ∇x₂ = (0, 1) are vertical, ∇f = (−2, 0) is not, and no
/// multipliers exist. Ipopt follows multipliers that grow without bound and ends as solved when its error, divided by
/// their size, is small enough, close to x* but not to the tolerance: g = −1e-12 is as good as 0, and that is (1 − x₁)³
/// at x₁ = 1 + 1e-4, where f is too low by 2e-4. Tolerances are those of an acceptable end: g = 1e-6 for x₁ = 1 ± 1e-2.
#[test]
fn a_cusp_has_no_multipliers() {
    let cusp = Problem {
        name: "HS013",
        start: &[-2.0, -2.0],
        bounds: &[POSITIVE; 2],
        f: |x| (x[1] - 2.0).powi(2) + x[2].powi(2),
        g: |x| vec![(1.0 - x[1]).powi(3) - x[2]],
        g_bounds: &[POSITIVE],
        optimum: 1.0,
        minimisers: &[&[1.0, 0.0]],
        ..DEFAULT
    };
    for hessian in HESSIANS {
        let solution = solve(cusp, hessian, &Options::new());
        assert!(solution.status.is_acceptable(), "{}", solution.status);
        assert_close(&solution.x, &[1.0, 0.0], 1e-2);
        assert_close(&[solution.objective], &[1.0], 2e-2);
        let multipliers = solution.multipliers.unwrap();
        let found = Residuals::at(cusp, &solution.x, &multipliers);
        // Where a slack vanishes, Ipopt moves its bound by 2e-12, and since 3.14 x may end there.
        assert!(
            found.violation <= 1e-6 && found.outside <= 2e-12,
            "{found:?}"
        );
        let lambda = multipliers.constraints[0];
        assert!(lambda < -1e4, "{hessian:?}: λ = {lambda}");
    }
}

/// HS012 with its constraint twice: λ = −½ in all, and how it is shared out is open. The barrier shares it evenly.
#[test]
fn an_inequality_twice() {
    let twice = Problem {
        g: |x| (problem("HS012").g)(x).repeat(2),
        g_bounds: &[POSITIVE; 2],
        ..problem("HS012")
    };
    assert_solved(twice);
    let solution = solve(twice, Hessian::Exact, &Options::new());
    let lambda = solution.multipliers.unwrap().constraints;
    assert_close(&lambda, &[-0.25, -0.25], 1e-6);
}

/// Equalities that depend on each other leave the multipliers open, here by any multiple of (1, …, −1). Where the
/// linear solver does not notice, round-off decides, and they become as large as 1e17. Ipopt, which divides ∇L by their
/// size and beyond that asks for ∇L ≤ 1 only (`dual_inf_tol`), may then call a point solved that is none: HS079 with f
/// too high by 2e-4, HS028 with an approximated Hessian by 0.7. Large multipliers tell; with a smaller
/// `dual_inf_tol`, what is called solved is (by 3.11 all four, by 3.14 one of them is acceptable only, and no better).
#[test]
fn an_equality_twice() {
    let twice = [
        Problem {
            g: |x| (problem("HS028").g)(x).repeat(2),
            g_bounds: &[ZERO; 2],
            ..problem("HS028")
        },
        Problem {
            g: |x| {
                let mut g = (problem("HS079").g)(x);
                g.push(g[0]);
                g
            },
            g_bounds: &[ZERO; 4],
            ..problem("HS079")
        },
    ];
    for (problem, hessian) in twice.iter().flat_map(|p| HESSIANS.map(|h| (*p, h))) {
        let solution = solve(problem, hessian, &Options::new());
        // Solved, or acceptable, to the acceptable tolerance 1e-6: round-off decides.
        assert!(solution.status.is_acceptable(), "{}", problem.name);
        let multipliers = solution.multipliers.unwrap();
        let found = Residuals::at(problem, &solution.x, &multipliers);
        assert!(found.violation <= 1e-6, "{}: {found:?}", problem.name);
        let largest = multipliers
            .constraints
            .iter()
            .fold(0.0, |a: f64, l| a.max(l.abs()));
        let off = (solution.objective - problem.optimum).abs();
        assert!(
            off <= 1e-6 || largest >= 1e6,
            "{}: {off:e}, {largest:e}",
            problem.name
        );

        let strict = Options::new().with("dual_inf_tol", 1e-6);
        let solution = solve(problem, hessian, &strict);
        assert!(solution.status.is_acceptable(), "{}", problem.name);
        if solution.status.is_solved() {
            assert_close(&[solution.objective], &[problem.optimum], 1e-6);
            assert_close(&solution.x, problem.minimisers[0], 1e-5);
            let found = Residuals::at(problem, &solution.x, &solution.multipliers.unwrap());
            assert!(found.stationarity <= 1e-6, "{}: {found:?}", problem.name);
        }
    }
}

/// HS055 with its five independent equations is no longer taken for square: a solve ends at the published minimum or at
/// a local one, f = 20/3.
#[test]
fn a_square_problem_that_is_none() {
    fn five(x: X<'_>) -> Vec<HyperDual> {
        let mut g = (problem("HS055").g)(x);
        g.truncate(5);
        g
    }
    let five = Problem {
        g: five,
        g_bounds: &[ZERO; 5],
        ..problem("HS055")
    };
    let local: &[f64] = &[1.0, 5.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 5.0 / 3.0];
    for hessian in HESSIANS {
        let solution = solve(five, hessian, &Options::new());
        assert_eq!(solution.status, Status::Solved);
        let (optimum, x) = match solution.objective < 6.5 {
            true => (five.optimum, five.minimisers[0]),
            false => (20.0 / 3.0, local),
        };
        assert_close(&[solution.objective], &[optimum], 1e-6);
        assert_close(&solution.x, x, 1e-6);
        assert_eq!(wrong_conditions(five, &solution), None);
    }
}

/// Infeasible versions of three problems, whose least sum of violations is known in closed form. Ipopt's restoration
/// minimises that sum and ends there, without multipliers of the problem itself.
#[test]
fn infeasible() {
    // x₁² + x₂² = 25 and x₁ x₂ = 13 > 25/2: ½ at x₁ = x₂.
    let circle = Problem {
        g: |x| vec![x.squares() - 25.0, x[1] * x[2] - 13.0],
        ..problem("HS008")
    };
    // The line x₁ − 2 x₂ + 5 = 0 misses the ellipse: 2 at (−2, 1).
    let ellipse = Problem {
        g: |x| {
            vec![
                1.0 - 0.25 * x[1].powi(2) - x[2].powi(2),
                x[1] - 2.0 * x[2] + 5.0,
            ]
        },
        ..problem("HS014")
    };
    // x₁² ≤ x₂ ≤ −2 − x₁: 2 + x₁ + x₁², hence 7/4 at x₁ = −½.
    let parabola = Problem {
        g: |x| vec![-2.0 - x[1] - x[2], x[2] - x[1].powi(2)],
        ..problem("HS022")
    };
    for (problem, least) in [(circle, 0.5), (ellipse, 2.0), (parabola, 1.75)] {
        for hessian in HESSIANS {
            let solution = solve(problem, hessian, &Options::new());
            assert_eq!(solution.status, Status::Infeasible, "{}", problem.name);
            let ranges = problem.g_bounds.iter().zip(&solution.g);
            let violation: f64 = ranges.map(|((l, u), g)| (l - g).max(g - u).max(0.0)).sum();
            assert_close(&[violation], &[least], 1e-6);
            assert_eq!(solution.multipliers, None, "{}", problem.name);
        }
    }
}

/// Without their constraints, HS010, HS029 and HS036 have no minimum, and f falls far below the constrained one. Ipopt
/// notices once x exceeds 1e20, unless the linear systems fail before, where f is −1e59, or the iteration limit comes
/// first: for the linear objective of HS010 the limited-memory approximation has no curvature to learn, and its steps
/// stay 1 long. Round-off decides which.
#[test]
fn unbounded() {
    let free = |name, bounds| Problem {
        bounds,
        g: |_| vec![],
        g_bounds: &[],
        ..problem(name)
    };
    let options = Options::new().with("max_iter", 200);
    for (name, bounds) in [
        ("HS010", problem("HS010").bounds),
        ("HS029", problem("HS029").bounds),
        ("HS036", &[POSITIVE; 3] as &[_]),
    ] {
        for hessian in HESSIANS {
            let solution = solve(free(name, bounds), hessian, &options);
            let (status, f) = (solution.status, solution.objective);
            assert!(!status.is_acceptable(), "{name}, {hessian:?}: {status}");
            let far_below = 100.0 * problem(name).optimum;
            assert!(f < far_below, "{name}, {hessian:?}: f = {f}");
        }
    }
}
