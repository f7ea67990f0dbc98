//! What would end the process inside Ipopt: each in a process of its own, so that a crash or a hang is a failing test.
#![cfg(feature = "ipopt")]

use std::{
    env,
    io::Read,
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use contact_core::{
    ipopt::{
        Error, LimitedMemoryUpdate, OptionError, OptionValue, Options, Scaling, Solution, Solver,
        Start, Status,
    },
    nlp::{Bounds, IterationRecord, Nlp, Pattern, Phase, Structure},
};
use problems::*;

/// Set in the processes that the tests start.
const CHILD: &str = "CONTACT_CORE_TEST_CHILD";
/// No child takes longer, also under Valgrind beside other work.
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs the body of the test called `name` in a process of its own, and fails with what that process said if it ends in
/// any other way than well.
fn in_a_child(name: &str, body: impl FnOnce()) {
    if env::var_os(CHILD).is_some() {
        return body();
    }
    let program = env::current_exe().expect("a test program");
    let mut child = Command::new(program)
        .args([name, "--exact", "--nocapture", "--test-threads=1"])
        .env(CHILD, "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the test program again");
    let mut said = String::new();
    let (output, errors) = (child.stdout.take(), child.stderr.take());
    let status = ends(&mut child);
    output
        .expect("piped")
        .read_to_string(&mut said)
        .expect("text");
    errors
        .expect("piped")
        .read_to_string(&mut said)
        .expect("text");
    // a library that ends the process with status 0 does not get to this line
    let ended = said.contains("test result: ok. 1 passed");
    assert!(
        status.success() && ended,
        "{name} in its own process: {status}\n{said}"
    );
}

fn ends(child: &mut Child) -> ExitStatus {
    let clock = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("a child") {
            return status;
        }
        if clock.elapsed() > PATIENCE {
            child.kill().expect("a child");
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// f, g and their derivatives as functions, for problems that are written down in a few lines.
struct Formulas {
    f: fn(&[f64]) -> f64,
    gradient: fn(&[f64], &mut [f64]),
    g: fn(&[f64], &mut [f64]),
    jacobian: fn(&[f64], &mut [f64]),
    hessian: fn(&[f64], f64, &[f64], &mut [f64]),
}

impl Nlp for Formulas {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (self.f)(x)
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        (self.gradient)(x, gradient);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        (self.g)(x, g);
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        (self.jacobian)(x, values);
    }
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        (self.hessian)(x, sigma, lambda, values);
    }
}

/// min x² + y² subject to x ≥ 3 and x + 10⁻³ y² ≤ 2, which no point satisfies.
const CONFLICT: Formulas = Formulas {
    f: |x| x[0] * x[0] + x[1] * x[1],
    gradient: |x, to| to.copy_from_slice(&[2.0 * x[0], 2.0 * x[1]]),
    g: |x, to| to[0] = x[0] + 1e-3 * x[1] * x[1],
    jacobian: |x, to| to.copy_from_slice(&[1.0, 2e-3 * x[1]]),
    hessian: |_, sigma, lambda, to| {
        to.copy_from_slice(&[2.0 * sigma, 2.0 * sigma + 2e-3 * lambda[0]]);
    },
};

fn solve_conflict(options: &Options) -> Result<Solution, Error> {
    let variables = Bounds {
        lower: vec![3.0, f64::NEG_INFINITY],
        upper: vec![f64::INFINITY; 2],
    };
    let constraints = Bounds::uniform(1, f64::NEG_INFINITY, 2.0);
    let (jacobian, hessian) = (Pattern::dense(1, 2), Some(Pattern::diagonal(2)));
    let structure = Structure::new(variables, constraints, jacobian, hessian).expect("well formed");
    Solver::new(structure, options)?.solve(&mut { CONFLICT }, &Start::at(&[1.0, 1.0]))
}

/// min Σ xᵢ² subject to x = 2 and x ≥ 0 as a constraint.
const FIXED: Formulas = Formulas {
    f: |x| x.iter().map(|x| x * x).sum(),
    gradient: |x, to| to.iter_mut().zip(x).for_each(|(to, x)| *to = 2.0 * x),
    g: |x, to| to.copy_from_slice(x),
    jacobian: |_, to| to.fill(1.0),
    hessian: |_, sigma, _, to| to.fill(2.0 * sigma),
};

fn fixed_solver(n: usize, constraints: Bounds) -> Solver {
    let diagonal = Pattern::diagonal(n);
    let variables = Bounds::uniform(n, 2.0, 2.0);
    let structure = Structure::new(variables, constraints, diagonal.clone(), Some(diagonal));
    Solver::new(structure.expect("well formed"), &Options::new()).expect("the defaults are valid")
}

/// Is not to be solved any more.
struct Stopped;

impl Nlp for Stopped {
    fn objective(&mut self, _: &[f64], _: bool) -> f64 {
        unreachable!("a stop was requested")
    }
    fn gradient(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn hessian(&mut self, _: &[f64], _: bool, _: f64, _: &[f64], _: &mut [f64]) {}
    fn is_to_stop(&mut self) -> bool {
        true
    }
}

/// Ipopt crashes where a function fails and all variables are fixed.
#[test]
fn all_variables_are_fixed() {
    in_a_child("all_variables_are_fixed", || {
        let mut solver = fixed_solver(1, Bounds::nonnegative(1));
        let start = Start::at(&[7.0]);
        let solution = solver.solve(&mut { FIXED }, &start).unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert_eq!((&solution.x[..], solution.objective), (&[2.0][..], 4.0));
        assert_eq!((&solution.g[..], solution.multipliers), (&[2.0][..], None));
        assert_eq!(solution.statistics.constraint_violation, 0.0);

        let mut infeasible = fixed_solver(1, Bounds::uniform(1, 5.0, 9.0));
        let solution = infeasible.solve(&mut { FIXED }, &start).unwrap();
        assert_eq!(solution.status, Status::Infeasible);
        assert_eq!((&solution.g[..], solution.objective), (&[2.0][..], 4.0));
        assert_eq!(solution.statistics.constraint_violation, 3.0);

        let options = Options::new().tol(1e12);
        infeasible.set_options(&options).unwrap();
        let solution = infeasible.solve(&mut { FIXED }, &start).unwrap();
        assert_eq!(solution.status, Status::Infeasible, "whatever `tol` is");

        let mut stopped = Stopped;
        let solution = solver.solve(&mut stopped, &start).unwrap();
        assert_eq!(solution.status, Status::StoppedByUser);

        for spoil in [Function::Objective, Function::Constraints] {
            let mut nlp = Watched::new(FIXED, |_| ControlFlow::Continue(()));
            nlp.spoil = Some(spoil);
            let solution = solver.solve(&mut nlp, &start).unwrap();
            assert_eq!(solution.status, Status::InvalidNumber, "{spoil:?}");
            assert!(solution.objective.is_nan() && solution.g[0].is_nan());

            let mut nlp = Watched::new(FIXED, |function| {
                assert_ne!(function, spoil, "a panic in a function");
                ControlFlow::Continue(())
            });
            let ended = catch_unwind(AssertUnwindSafe(|| solver.solve(&mut nlp, &start)));
            assert!(ended.is_err(), "the panic goes on: {ended:?}");
        }
        let solution = solver.solve(&mut { FIXED }, &start).unwrap();
        assert_eq!(solution.status, Status::Solved, "after all that");
    });
}

#[test]
fn there_are_no_variables() {
    let mut solver = fixed_solver(0, Bounds::default());
    let solution = solver.solve(&mut { FIXED }, &Start::at(&[])).unwrap();
    assert_eq!((solution.status, solution.objective), (Status::Solved, 0.0));
    let constant = Structure::new(
        Bounds::default(),
        Bounds::uniform(1, 1.0, 1.0),
        Pattern::empty(),
        None,
    );
    let mut solver = Solver::new(constant.unwrap(), &Options::new()).unwrap();
    let mut nlp = Formulas {
        g: |_, to| to[0] = 3.0,
        ..FIXED
    };
    let solution = solver.solve(&mut nlp, &Start::at(&[])).unwrap();
    assert_eq!(
        (solution.status, solution.g),
        (Status::Infeasible, vec![3.0])
    );
}

/// Ipopt crashes in the restoration phase with a memory of 0, which is refused.
#[test]
fn limited_memory_in_restoration() {
    in_a_child("limited_memory_in_restoration", || {
        for update in [LimitedMemoryUpdate::Bfgs, LimitedMemoryUpdate::Sr1] {
            for history in [0, 1, 6] {
                let solution = solve_conflict(&Options::new().least_change(history, update));
                match solution {
                    Ok(solution) => assert!(history > 0 && !solution.status.is_acceptable()),
                    Err(why) => assert_eq!((history, refused(why)), (0, LIMITED_MEMORY.into())),
                }
            }
        }
        let options = Options::new().with("resto.limited_memory_max_history", 0);
        let why = solve_conflict(&options).expect_err("it is for the restoration phase");
        assert_eq!(refused(why), "resto.limited_memory_max_history");
    });
}

const LIMITED_MEMORY: &str = "limited_memory_max_history";

/// The option that is refused with a reason.
fn refused(error: Error) -> String {
    match error {
        Error::Option(OptionError::Refused {
            name, why, remedy, ..
        }) => {
            assert!(!why.is_empty() && !remedy.is_empty());
            name
        }
        other => panic!("{other}"),
    }
}

/// Ipopt crashes in the restoration phase with this algorithm, which the driver leaves out there.
#[test]
fn convex_quadratic_in_restoration() {
    in_a_child("convex_quadratic_in_restoration", || {
        let options = Options::new().convex_quadratic();
        let solution = solve_conflict(&options.with("start_with_resto", true)).unwrap();
        assert!(!solution.status.is_acceptable(), "{:?}", solution.status);
        assert_ne!(solution.status, Status::InvalidOption);
        let restored = |record: &IterationRecord| record.phase == Phase::Restoration;
        assert!(
            solution.history.iter().any(restored),
            "the phase is entered"
        );
        let options = Options::new().with("resto.mehrotra_algorithm", true);
        let why = solve_conflict(&options).expect_err("it is for the restoration phase");
        assert_eq!(refused(why), "resto.mehrotra_algorithm");
    });
}

/// Ipopt crashes where its own check finds a function that failed, hides the solution, and calls solved what violates
/// equalities.
#[test]
fn options_that_spoil_a_solve_are_refused() {
    for (name, value) in [
        ("check_derivatives_for_naninf", "yes"),
        ("check_derivatives_for_naninf", "YES"),
        ("skip_finalize_solution_call", "yes"),
        ("dependency_detector", "mumps"),
        ("option_file_name", "ipopt.opt"),
        ("resto.option_file_name", "ipopt.opt"),
        // wrong for the last of three variables where the second is in no constraint, and "solved"
        ("jacobian_approximation", "finite-difference-values"),
        ("nlp_scaling_constr_target_gradient", "1"),
        ("resto.line_search_method", "cg-penalty"),
        ("resto.hessian_approximation", "limited-memory"),
        ("warm_start_target_mu", "1"),
        ("bound_mult_init_method", "mu-based"),
    ] {
        let options = Options::new().with(name, value_of(value));
        let solver = Solver::new(hs071_structure(), &options);
        let why = solver.expect_err(name);
        assert_eq!(refused(why), name);
    }
    for (name, value) in [
        ("check_derivatives_for_naninf", "no"),
        ("skip_finalize_solution_call", "no"),
        ("dependency_detector", "none"),
        ("option_file_name", ""),
        ("jacobian_approximation", "exact"),
        ("limited_memory_max_history", "1"),
        ("nlp_scaling_constr_target_gradient", "0"),
        ("resto.line_search_method", "filter"),
        ("warm_start_target_mu", "0"),
        ("bound_mult_init_method", "constant"),
    ] {
        let options = Options::new().with(name, value_of(value));
        let solver = Solver::new(hs071_structure(), &options);
        assert!(solver.is_ok(), "{name}: {solver:?}");
    }
}

fn value_of(text: &str) -> OptionValue {
    let number = text.parse().map(OptionValue::Integer);
    number.unwrap_or_else(|_| text.into())
}

/// MUMPS crashes with entries that overflow where they are scaled.
#[test]
fn values_whose_squares_overflow_are_not_finite() {
    in_a_child("values_whose_squares_overflow_are_not_finite", || {
        for size in [1e308, -1e160] {
            for function in FUNCTIONS {
                let mut nlp = Large(Hs071, function, size);
                let mut solver = hs071_solver!();
                let scaling = Scaling {
                    objective: -100.0,
                    variables: Some(vec![1e-3; 4]),
                    constraints: None,
                };
                solver.set_scaling(&scaling).unwrap();
                let solution = solver.solve(&mut nlp, &Start::at(&HS071_START)).unwrap();
                let expected = function != Function::Iterate;
                assert_eq!(solution.status == Status::InvalidNumber, expected);
            }
        }
    });
}

/// One function of another problem is as large as this in its last value.
struct Large<N>(N, Function, f64);

impl<N> Large<N> {
    fn spoil(&self, function: Function, values: &mut [f64]) {
        if let (true, Some(last)) = (self.1 == function, values.last_mut()) {
            *last = self.2;
        }
    }
}

impl<N: Nlp> Nlp for Large<N> {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        let mut value = [self.0.objective(x, new_x)];
        self.spoil(Function::Objective, &mut value);
        value[0]
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        self.0.gradient(x, new_x, gradient);
        self.spoil(Function::Gradient, gradient);
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        self.0.constraints(x, new_x, g);
        self.spoil(Function::Constraints, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        self.0.jacobian(x, new_x, values);
        self.spoil(Function::Jacobian, values);
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        self.0.hessian(x, new_x, sigma, lambda, values);
        self.spoil(Function::Hessian, values);
    }
}

/// ½ Σ (xᵢ − 1)², with a Hessian of more entries than its diagonal.
struct Squares(Pattern);

impl Squares {
    /// Each of n variables is linked with the `band` before it.
    fn banded(n: usize, band: usize) -> Self {
        let row = |i: usize| (i.saturating_sub(band)..=i).map(move |j| (i, j));
        Self((0..n).flat_map(row).collect())
    }

    /// x where the driver and its options get to.
    fn solve(&mut self, variables: Bounds, options: &Options) -> Vec<f64> {
        let start = vec![0.0; variables.len()];
        let (none, hessian) = (Pattern::empty(), Some(self.0.clone()));
        let structure = Structure::new(variables, Bounds::default(), none, hessian);
        let mut solver = Solver::new(structure.unwrap(), options).unwrap();
        let solution = solver.solve(self, &Start::at(&start)).unwrap();
        assert_eq!(solution.status, Status::Solved);
        solution.x
    }
}

impl Nlp for Squares {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x.iter().map(|x| 0.5 * (x - 1.0).powi(2)).sum()
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        let values = gradient.iter_mut().zip(x);
        values.for_each(|(to, x)| *to = x - 1.0);
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        for (value, (row, col)) in values.iter_mut().zip(self.0.iter()) {
            *value = if row == col { sigma } else { 0.0 };
        }
    }
}

/// PORD ends the process, with a message of its own, where all unknowns of the linear system have the same neighbours.
#[test]
fn pord_is_not_asked_for_where_all_have_the_same_neighbours() {
    in_a_child(
        "pord_is_not_asked_for_where_all_have_the_same_neighbours",
        || {
            for name in ["mumps_pivot_order", "resto.mumps_pivot_order"] {
                let pord = Options::new().with(name, 4);
                for n in [1, 2, 3, 10, 1200] {
                    let x = Squares::banded(n, n).solve(Bounds::free(n), &pord);
                    assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-6), "{x:?}");
                }
            }
        },
    );
}

/// It is the driver's own choice for a problem of this size and density, whose variables are fixed but for a few.
#[test]
fn large_problems_with_few_free_variables() {
    in_a_child("large_problems_with_few_free_variables", || {
        let n = 10_500;
        let mut squares = Squares::banded(n, 16);
        for free in [1, 2, 5, 40] {
            let mut variables = Bounds::uniform(n, 2.0, 2.0);
            variables.lower[..free].fill(-9.0);
            let x = squares.solve(variables, &Options::new());
            assert!(x[..free].iter().all(|x| (x - 1.0).abs() < 1e-6));
            assert!(x[free..].iter().all(|&x| x == 2.0));
        }
    });
}

/// As before, where a later set of bounds leaves few free.
#[test]
fn bounds_that_leave_few_free_in_the_next_solve() {
    in_a_child("bounds_that_leave_few_free_in_the_next_solve", || {
        let n = 10_500;
        let mut squares = Squares::banded(n, 16);
        let (none, hessian) = (Pattern::empty(), Some(squares.0.clone()));
        let structure = Structure::new(Bounds::free(n), Bounds::default(), none, hessian);
        let mut solver = Solver::new(structure.unwrap(), &Options::new()).unwrap();
        let mut orders = Vec::new();
        for free in [n, 1, n] {
            let mut variables = Bounds::uniform(n, 2.0, 2.0);
            variables.lower[..free].fill(-9.0);
            solver.set_bounds(variables, Bounds::default()).unwrap();
            let start = vec![0.0; n];
            let solution = solver.solve(&mut squares, &Start::at(&start)).unwrap();
            assert_eq!(solution.status, Status::Solved);
            orders.push(solution.statistics.mumps.expect("factorised").ordering);
        }
        assert_eq!(orders[0], orders[2], "the choice for many is back");
    });
}

/// Ipopt factorises for ever where its regularisation hardly grows. The Hessian is −100.
#[test]
fn a_regularisation_without_effect_ends() {
    in_a_child("a_regularisation_without_effect_ends", || {
        let options = Options::new()
            .with("perturb_inc_fact_first", 1.00001)
            .with("perturb_inc_fact", 1.00001);
        let structure = Structure::new(
            Bounds::uniform(2, -1.0, 1.0),
            Bounds::default(),
            Pattern::empty(),
            Some(Pattern::diagonal(2)),
        );
        let mut nlp = Formulas {
            f: |x| -50.0 * (FIXED.f)(x),
            gradient: |x, to| to.iter_mut().zip(x).for_each(|(to, x)| *to = -100.0 * x),
            hessian: |_, sigma, _, to| to.fill(-100.0 * sigma),
            ..FIXED
        };
        let mut solver = Solver::new(structure.unwrap(), &options).unwrap();
        let solution = solver.solve(&mut nlp, &Start::at(&[0.1, 0.2])).unwrap();
        assert_eq!(solution.status, Status::StepComputationFailed);
        assert!(solution.statistics.iterations < 10);
        // the solver goes on to others
        solver.set_options(&Options::new()).unwrap();
        let solution = solver.solve(&mut nlp, &Start::at(&[0.1, 0.2])).unwrap();
        assert_eq!(solution.status, Status::Solved);
    });
}
