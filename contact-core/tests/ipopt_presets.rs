//! The presets on problems they are meant for, and on some they are not.
#![cfg(feature = "ipopt")]

use contact_core::{
    ipopt::{
        DerivativeTest, Error, LimitedMemoryUpdate, OptionError, Options, Solution, Solver, Start,
        Status,
    },
    nlp::{Bounds, Nlp, Pattern, Structure},
};
use problems::*;

const POINTS: usize = 40;
const LOAD: f64 = 8.0;

/// A convex quadratic problem whose structure promises nothing.
fn string(options: &Options) -> Solution {
    let structure = Obstacle::structure(POINTS, -0.5)
        .with_constant_hessian(false)
        .with_constant_jacobian(false);
    let mut solver = Solver::new(structure, options).unwrap();
    let mut nlp = Obstacle {
        n: POINTS,
        load: LOAD,
    };
    solver.solve(&mut nlp, &Start::at(&[0.0; POINTS])).unwrap()
}

/// The points on the floor. A string under this load touches it between s and 1 − s, with s² load / 2 = ½.
fn assert_touches(solution: &Solution, tolerance: f64) {
    let s = (1.0 / LOAD).sqrt();
    for (i, u) in solution.x.iter().enumerate() {
        let at = (i + 1) as f64 / (POINTS + 1) as f64;
        let from_end = at.min(1.0 - at).min(s);
        let exact = 0.5 * LOAD * (s - from_end).powi(2) - 0.5;
        // Where contact begins is known to a point: h² load/8.
        assert!(
            (u - exact).abs() < tolerance,
            "point {i}: {u} is not {exact} to {tolerance}"
        );
    }
}

#[test]
fn a_convex_quadratic_problem_with_each_preset() {
    let h = 1.0 / (POINTS + 1) as f64;
    let newton = string(&Options::new().newton());
    let quadratic = string(&Options::new().quadratic());
    let mehrotra = string(&Options::new().quadratic().convex_quadratic());
    let bfgs = string(&Options::new().least_change(20, LimitedMemoryUpdate::Bfgs));
    for solution in [&newton, &quadratic, &mehrotra, &bfgs] {
        assert_eq!(solution.status, Status::Solved);
        assert_touches(solution, LOAD * h * h);
        assert_close(&solution.x, &newton.x, 1e-5);
    }
    let calls = |s: &Solution| (s.statistics.hessian.calls, s.statistics.jacobian.calls);
    assert!(calls(&newton).0 > 5 && calls(&newton).1 > 5);
    assert!(calls(&quadratic).0 == 1 && calls(&quadratic).1 <= 3);
    assert_eq!(calls(&bfgs).0, 0, "no Hessian is asked for");
    assert!(mehrotra.statistics.iterations <= quadratic.statistics.iterations);
}

/// 100 (x₁ − x₀²)² + (1 − x₀)²: a curved valley, indefinite where x₁ > x₀² + 1/200.
struct Rosenbrock;

impl Nlp for Rosenbrock {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        let valley = x[1] - x[0] * x[0];
        gradient[0] = -400.0 * x[0] * valley - 2.0 * (1.0 - x[0]);
        gradient[1] = 200.0 * valley;
    }
    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values[0] = sigma * (1200.0 * x[0] * x[0] - 400.0 * x[1] + 2.0);
        values[1] = -sigma * 400.0 * x[0];
        values[2] = sigma * 200.0;
    }
}

fn rosenbrock(options: &Options) -> Solution {
    let structure = Structure::new(
        Bounds::free(2),
        Bounds::default(),
        Pattern::empty(),
        Some(Pattern::dense_lower(2)),
    );
    let mut solver = Solver::new(structure.unwrap(), options).unwrap();
    solver
        .solve(&mut Rosenbrock, &Start::at(&[-1.2, 1.0]))
        .unwrap()
}

#[test]
fn a_curved_valley_with_and_without_its_hessian() {
    let newton = rosenbrock(&Options::new().newton());
    assert!(newton.statistics.hessian.calls > 0);
    let mut paths = vec![newton.statistics.iterations];
    for (history, update) in [
        (6, LimitedMemoryUpdate::Bfgs),
        (1, LimitedMemoryUpdate::Bfgs),
        (6, LimitedMemoryUpdate::Sr1),
    ] {
        let solution = rosenbrock(&Options::new().least_change(history, update));
        assert!(solution.status.is_acceptable(), "{history} {update:?}");
        assert_close(&solution.x, &[1.0, 1.0], 1e-4);
        assert_eq!(solution.statistics.hessian.calls, 0);
        paths.push(solution.statistics.iterations);
    }
    assert_eq!(newton.status, Status::Solved);
    assert_close(&newton.x, &[1.0, 1.0], 1e-6);
    assert!(
        paths[1..].iter().all(|n| *n > paths[0]),
        "second derivatives save iterations: {paths:?}"
    );
    assert!(
        paths[1] != paths[2] && paths[1] != paths[3],
        "history and update count: {paths:?}"
    );
}

#[test]
fn what_needs_a_hessian_is_refused_without_one() {
    let structure =
        Structure::new(Bounds::free(2), Bounds::default(), Pattern::empty(), None).unwrap();
    for (options, refused) in [
        (Options::new().newton(), "hessian_approximation"),
        (
            Options::new().derivative_test(DerivativeTest::SecondOrder),
            "derivative_test",
        ),
        (
            Options::new().derivative_test(DerivativeTest::OnlySecondOrder),
            "derivative_test",
        ),
    ] {
        let error = Solver::new(structure.clone(), &options).unwrap_err();
        assert!(
            matches!(&error, Error::Option(OptionError::Invalid { name, .. }) if name == refused),
            "{error}"
        );
    }
    // What remains does not ask for it.
    let options = Options::new()
        .quadratic()
        .least_change(6, LimitedMemoryUpdate::Bfgs)
        .derivative_test(DerivativeTest::FirstOrder);
    let mut solver = Solver::new(structure, &options).unwrap();
    let mut nlp = Separable::new(&[1.0, -2.0]);
    let solution = solver.solve(&mut nlp, &Start::at(&[0.0; 2])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[1.0, -2.0], 1e-6);
    assert!(solution.derivative_check.unwrap().is_clean());
}

/// min ½ (x − 3)² subject to arctan(x − 3) = 0: a nonconvex set to Ipopt, with full Newton steps that overshoot from
/// |x − 3| > 1.39 on.
struct Arctangent;

impl Nlp for Arctangent {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        0.5 * (x[0] - 3.0).powi(2)
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = x[0] - 3.0;
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = (x[0] - 3.0).atan();
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values[0] = 1.0 / (1.0 + (x[0] - 3.0).powi(2));
    }
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        let y = x[0] - 3.0;
        values[0] = sigma - 2.0 * lambda[0] * y / (1.0 + y * y).powi(2);
    }
}

#[test]
fn mehrotra_on_a_nonconvex_problem_fails_visibly() {
    let structure = Structure::new(
        Bounds::free(1),
        Bounds::zero(1),
        Pattern::dense(1, 1),
        Some(Pattern::diagonal(1)),
    )
    .unwrap();
    let solve = |options: &Options| {
        Solver::new(structure.clone(), options)
            .unwrap()
            .solve(&mut Arctangent, &Start::at(&[0.0]))
            .unwrap()
    };
    let options = Options::new().max_iter(100);
    let newton = solve(&options);
    assert_eq!(newton.status, Status::Solved);
    assert_close(&newton.x, &[3.0], 1e-6);
    let mehrotra = solve(&options.convex_quadratic());
    assert!(!mehrotra.status.is_acceptable(), "{mehrotra:?}");
    assert_ne!(mehrotra.status, Status::InvalidOption);
}

#[test]
fn presets_leave_what_is_set() {
    let options = Options::new()
        .max_iter(5)
        .limited_memory_max_history(3)
        .least_change(9, LimitedMemoryUpdate::Sr1)
        .newton();
    assert_eq!(options.get("limited_memory_max_history"), Some(&3.into()));
    assert_eq!(
        options.get("hessian_approximation"),
        Some(&"limited-memory".into())
    );
}
