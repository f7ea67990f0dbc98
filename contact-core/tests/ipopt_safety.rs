//! What a careless caller can do to Ipopt, and what comes of it.
#![cfg(feature = "ipopt")]

use std::{
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Barrier,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    thread,
    time::Duration,
};

use contact_core::{
    ipopt::{Error, OptionError, Options, Scaling, Solver, Start, Status, VERSION},
    nlp::{Bounds, Multipliers, Nlp, NlpError, Pattern, Structure},
};
use problems::*;

#[test]
fn eight_threads_at_once() {
    let (threads, rounds) = (8, 5);
    let barrier = Barrier::new(threads);
    let solved: usize = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|k| {
                let barrier = &barrier;
                scope.spawn(move || {
                    barrier.wait();
                    let mut solved = 0;
                    for round in 0..rounds {
                        let solution = hs071_solver!()
                            .solve(&mut Hs071, &Start::at(&HS071_START))
                            .unwrap();
                        assert_eq!(solution.status, Status::Solved);
                        assert_close(&solution.x, &HS071_X, 1e-6);
                        let centre = k as f64 - 0.5 * round as f64;
                        let mut own = Solver::new(
                            Separable::structure(Bounds::nonnegative(1)),
                            &Options::new(),
                        )
                        .unwrap();
                        let solution = own
                            .solve(&mut Separable::new(&[centre]), &Start::at(&[1.0]))
                            .unwrap();
                        assert_close(&solution.x, &[centre.max(0.0)], 1e-4);
                        solved += 2;
                    }
                    solved
                })
            })
            .collect();
        workers
            .into_iter()
            .map(|worker| worker.join().unwrap())
            .sum()
    });
    assert_eq!(solved, threads * rounds * 2);
}

/// Makes a solver, sets it, asks it and drops it, and one that is refused.
fn all_but_a_solve(tol: f64) {
    let mut solver = hs071_solver!();
    solver
        .set_options(&Options::new().tol(tol).max_iter(7))
        .unwrap();
    assert_eq!(solver.ipopt_default("tol"), Some(1e-8.into()));
    assert!(solver.set_options(&Options::new().tol(-tol)).is_err());
    let scaling = Scaling {
        objective: 2.0,
        variables: None,
        constraints: None,
    };
    solver.set_scaling(&scaling).unwrap();
    solver.clear_scaling().unwrap();
    assert!(Solver::new(hs071_structure(), &Options::new().with("toll", 1)).is_err());
}

#[test]
fn only_a_solve_waits_for_a_solve() {
    let (sender, done) = mpsc::channel();
    let mut solver = hs071_solver!();
    let mut moved = Some(hs071_solver!());
    let mut waited = 0;
    let solution = solver.solve_with(&mut Hs071, &Start::at(&HS071_START), |_| {
        let (sender, other) = (sender.clone(), moved.take());
        thread::spawn(move || {
            drop(other);
            all_but_a_solve(1e-7);
            sender.send(()).unwrap();
        });
        done.recv_timeout(Duration::from_secs(30))
            .expect("it does not wait for the end of this solve");
        waited += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Solved);
    assert!(waited > 5);
}

#[test]
fn solvers_come_and_go_while_another_solves() {
    let over = AtomicBool::new(false);
    let rounds: usize = thread::scope(|scope| {
        let workers: Vec<_> = (1..=8)
            .map(|k| {
                let over = &over;
                scope.spawn(move || {
                    let mut rounds = 0;
                    while rounds < 3 || (rounds < 500 && !over.load(Ordering::Relaxed)) {
                        all_but_a_solve(1e-9 * f64::from(k));
                        rounds += 1;
                    }
                    rounds
                })
            })
            .collect();
        for _ in 0..20 {
            let solution = hs071_solver!()
                .solve(&mut Hs071, &Start::at(&HS071_START))
                .unwrap();
            assert_eq!(solution.status, Status::Solved);
            assert_close(&solution.x, &HS071_X, 1e-6);
        }
        over.store(true, Ordering::Relaxed);
        workers
            .into_iter()
            .map(|worker| worker.join().unwrap())
            .sum()
    });
    assert!(rounds >= 24);
}

#[test]
fn a_solver_moves_between_threads() {
    let mut solver = hs071_solver!();
    solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    let mut solver = thread::spawn(move || {
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        assert_close(&solution.x, &HS071_X, 1e-6);
        solver
    })
    .join()
    .unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_close(&solution.x, &HS071_X, 1e-6);
}

/// The payload of the panic of one function, at its `nth` call, and how many callbacks ran after it.
fn panic_in(solver: &mut Solver, culprit: Function, nth: usize) -> (String, usize) {
    let (mut calls, mut later) = (0, 0);
    let mut nlp = Watched::new(Hs071, |function| {
        if calls == nth {
            later += 1;
        } else if function == culprit {
            calls += 1;
            if calls == nth {
                std::panic::panic_any(format!("{culprit:?} has had enough"));
            }
        }
        ControlFlow::Continue(())
    });
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        solver.solve(&mut nlp, &Start::at(&HS071_START))
    }));
    let payload = outcome.expect_err("the panic goes on");
    (
        payload
            .downcast_ref::<String>()
            .expect("the payload is kept")
            .clone(),
        later,
    )
}

#[test]
fn a_panic_in_any_callback_goes_on_and_the_solver_survives() {
    let mut solver = hs071_solver!();
    for culprit in FUNCTIONS {
        for nth in [1, 4] {
            let (message, later) = panic_in(&mut solver, culprit, nth);
            assert_eq!(message, format!("{culprit:?} has had enough"));
            assert_eq!(later, 0, "nothing is called after a panic");
            let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
            assert_eq!(solution.status, Status::Solved);
            assert_close(&solution.x, &HS071_X, 1e-6);
        }
    }
}

#[test]
fn nan_everywhere_is_an_invalid_number() {
    let mut solver = hs071_solver!();
    for spoil in FUNCTIONS
        .into_iter()
        .filter(|function| *function != Function::Iterate)
    {
        let mut nlp = Watched::new(Hs071, |_| ControlFlow::Continue(()));
        nlp.spoil = Some(spoil);
        let solution = solver.solve(&mut nlp, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.status, Status::InvalidNumber, "{spoil:?}");
        assert_eq!(solution.multipliers, None, "{spoil:?}");
        // Ipopt has zeros for what it has not evaluated.
        assert!(solution.objective.is_nan(), "{spoil:?}: {solution:?}");
        assert!(solution.g.iter().all(|g| g.is_nan()), "{spoil:?}");
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.status, Status::Solved);
    }
}

/// min x − ln x or, as a constraint, min ½(x − 2)² subject to ln x = 0; both are NaN for x ≤ 0, where the first step
/// from 3 leads, and both are solved by 1.
struct Logarithm {
    constrained: bool,
    inadmissible: usize,
}

impl Nlp for Logarithm {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        if self.constrained {
            return 0.5 * (x[0] - 2.0).powi(2);
        }
        self.inadmissible += usize::from(x[0] <= 0.0);
        x[0] - x[0].ln()
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = if self.constrained {
            x[0] - 2.0
        } else {
            1.0 - 1.0 / x[0]
        };
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        self.inadmissible += usize::from(x[0] <= 0.0);
        g[0] = x[0].ln();
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values[0] = 1.0 / x[0];
    }
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        values[0] = if self.constrained {
            sigma - lambda[0] / x[0].powi(2)
        } else {
            sigma / x[0].powi(2)
        };
    }
}

#[test]
fn an_inadmissible_trial_shortens_the_step() {
    for constrained in [false, true] {
        let m = usize::from(constrained);
        let structure = Structure::new(
            Bounds::free(1),
            Bounds::zero(m),
            Pattern::dense(m, 1),
            Some(Pattern::diagonal(1)),
        )
        .unwrap();
        let mut nlp = Logarithm {
            constrained,
            inadmissible: 0,
        };
        let mut solver = Solver::new(structure, &Options::new()).unwrap();
        let solution = solver.solve(&mut nlp, &Start::at(&[3.0])).unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert_close(&solution.x, &[1.0], 1e-7);
        assert!(nlp.inadmissible > 0, "the first step was to lead to x ≤ 0");
        assert!(
            solution
                .history
                .iter()
                .any(|record| record.line_search_trials > 1)
        );
    }
}

#[test]
fn a_solve_inside_a_callback_is_refused() {
    let mut inner = hs071_solver!();
    let mut refused = 0;
    let mut nlp = Watched::new(Hs071, |_| {
        match inner.solve(&mut Hs071, &Start::at(&HS071_START)) {
            Err(Error::Reentrant) => refused += 1,
            other => panic!("{other:?}"),
        }
        // Creating and dropping one is fine.
        drop(hs071_solver!());
        ControlFlow::Continue(())
    });
    let solution = hs071_solver!()
        .solve(&mut nlp, &Start::at(&HS071_START))
        .unwrap();
    assert_close(&solution.x, &HS071_X, 1e-6);
    assert!(refused > 10);
    let solution = inner.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_close(&solution.x, &HS071_X, 1e-6);
}

#[test]
fn drops_in_any_order() {
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let mut solvers: Vec<Option<Solver>> = (0..3).map(|_| Some(hs071_solver!())).collect();
        for &next in &order {
            for solver in solvers.iter_mut().flatten() {
                let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
                assert_close(&solution.x, &HS071_X, 1e-6);
            }
            solvers[next] = None;
        }
    }
    let mut solver = hs071_solver!();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    drop(solver);
    assert_close(&solution.x, &HS071_X, 1e-6);
}

fn structure(
    variables: Bounds,
    constraints: Bounds,
    jacobian: Pattern,
    hessian: Pattern,
) -> Result<Structure, NlpError> {
    Structure::new(variables, constraints, jacobian, Some(hessian))
}

#[test]
fn bad_structures_are_refused_by_name() {
    let one = || Bounds::free(1);
    let two = || Bounds::free(2);
    let none = Pattern::empty;
    let entries = |list: &[(usize, usize)]| list.iter().copied().collect::<Pattern>();

    let short = Bounds {
        lower: vec![0.0; 2],
        upper: vec![1.0],
    };
    assert!(matches!(
        structure(short, one(), none(), none()),
        Err(NlpError::Length {
            what: "x_U",
            found: 1,
            expected: 2
        })
    ));
    let ragged = Pattern::new(vec![0, 0], vec![0]);
    assert!(matches!(
        structure(two(), one(), ragged, none()),
        Err(NlpError::Length {
            found: 1,
            expected: 2,
            ..
        })
    ));

    let error = structure(two(), one(), entries(&[(0, 1), (0, 2)]), none()).unwrap_err();
    assert_eq!(
        error,
        NlpError::OutOfRange {
            pattern: "Jacobian",
            entry: 1,
            row: 0,
            col: 2,
            rows: 1,
            cols: 2
        }
    );
    assert!(structure(two(), one(), entries(&[(1, 0)]), none()).is_err());
    assert!(structure(two(), one(), entries(&[(usize::MAX, 0)]), none()).is_err());
    let error = structure(two(), one(), none(), entries(&[(0, 0), (2, 0)])).unwrap_err();
    assert_eq!(
        error,
        NlpError::OutOfRange {
            pattern: "Hessian",
            entry: 1,
            row: 2,
            col: 0,
            rows: 2,
            cols: 2
        }
    );
    let error = structure(two(), one(), none(), entries(&[(1, 0), (0, 1)])).unwrap_err();
    assert_eq!(
        error,
        NlpError::UpperTriangle {
            entry: 1,
            row: 0,
            col: 1
        }
    );
    assert!(error.to_string().contains("(1, 0)"), "the remedy: {error}");
    let error = structure(
        two(),
        one(),
        none(),
        entries(&[(1, 1), (0, 0), (1, 0), (1, 1)]),
    )
    .unwrap_err();
    assert_eq!(
        error,
        NlpError::Duplicate {
            entry: 3,
            row: 1,
            col: 1
        }
    );
    // In the Jacobian entries add up.
    assert!(structure(two(), one(), entries(&[(0, 1), (0, 1)]), none()).is_ok());
}

#[test]
fn bad_bounds_are_refused_by_index() {
    let with = |lower: f64, upper: f64| Bounds {
        lower: vec![0.0, lower],
        upper: vec![1.0, upper],
    };
    let refused = |bounds: Bounds| {
        structure(
            bounds,
            Bounds::default(),
            Pattern::empty(),
            Pattern::empty(),
        )
        .unwrap_err()
    };
    assert_eq!(
        refused(with(2.0, 1.0)),
        NlpError::CrossedBounds {
            what: "variable",
            index: 1,
            lower: 2.0,
            upper: 1.0
        }
    );
    for bounds in [
        with(f64::NAN, 1.0),
        with(0.0, f64::NAN),
        with(f64::INFINITY, f64::INFINITY),
        with(f64::NEG_INFINITY, f64::NEG_INFINITY),
    ] {
        assert!(matches!(refused(bounds), NlpError::Value { index: 1, .. }));
    }
    let constraints = structure(
        Bounds::free(1),
        with(2.0, 1.0),
        Pattern::empty(),
        Pattern::empty(),
    );
    assert!(matches!(
        constraints,
        Err(NlpError::CrossedBounds {
            what: "constraint",
            index: 1,
            ..
        })
    ));

    let mut solver = hs071_solver!();
    let g = solver.structure().constraint_bounds().clone();
    assert!(
        solver
            .set_bounds(Bounds::uniform(4, 5.0, 1.0), g.clone())
            .is_err()
    );
    assert!(solver.set_bounds(Bounds::free(3), g).is_err());
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_close(&solution.x, &HS071_X, 1e-6);
}

fn refused(name: &str, options: Options) -> OptionError {
    match Solver::new(hs071_structure(), &options) {
        Err(Error::Option(error)) => {
            assert!(error.to_string().contains(name), "{error}");
            error
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_options_are_refused_by_name() {
    let set = |name: &str| Options::new().with(name, 1);
    assert!(matches!(
        refused("no_such_option", set("no_such_option")),
        OptionError::Unknown { .. }
    ));
    assert!(matches!(
        refused("nul", set("nul\0")),
        OptionError::Unknown { .. }
    ));
    let slip = refused("maxiter", set("maxiter")).to_string();
    assert!(slip.ends_with("did you mean `max_iter`?"), "{slip}");
    let words = refused("mu_strategy", Options::new().with("mu_strategy", "perhaps"));
    assert!(matches!(&words, OptionError::Invalid { .. }));
    assert!(
        words.to_string().contains("monotone") && words.to_string().contains("adaptive"),
        "{words}"
    );
    let range = refused("tol", Options::new().with("tol", -1.0));
    assert!(matches!(&range, OptionError::Invalid { .. }));
    assert!(range.to_string().contains("> 0"), "{range}");
    assert!(matches!(
        refused("tol", Options::new().with("tol", f64::NAN)),
        OptionError::Invalid { .. }
    ));
    assert!(matches!(
        refused("tol", Options::new().with("tol", "small")),
        OptionError::WrongType { .. }
    ));
    assert!(matches!(
        refused("max_iter", Options::new().with("max_iter", 1.5)),
        OptionError::WrongType { .. }
    ));
    assert!(matches!(
        refused("max_iter", Options::new().with("max_iter", -1)),
        OptionError::Invalid { .. }
    ));
    assert!(matches!(
        refused(
            "linear_solver",
            Options::new().with("linear_solver", "a\0b")
        ),
        OptionError::Invalid { .. }
    ));
}

#[test]
fn an_integer_serves_as_a_number_and_the_last_value_counts() {
    let options = Options::new()
        .with("tol", 1)
        .with("max_iter", 2)
        .with("max_iter", 1usize);
    assert_eq!(options.iter().count(), 2);
    let solution = Solver::new(hs071_structure(), &options)
        .unwrap()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    assert!(solution.statistics.iterations <= 1);
}

/// One of them, MA97, makes Ipopt 3.11 end the process where HSL is not installed, and 3.14 crash.
#[test]
fn a_missing_linear_solver_is_a_status() {
    let mut missing = 0;
    for name in ["ma27", "ma57", "ma77", "ma86", "ma97", "pardiso", "wsmp"] {
        let solver = Solver::new(
            hs071_structure(),
            &Options::new().with("linear_solver", name),
        );
        let Ok(mut solver) = solver else { continue };
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        if solution.status != Status::Solved {
            assert_eq!(solution.status, Status::InvalidOption, "{name}");
            assert_eq!(solution.x, HS071_START);
            missing += 1;
        }
        assert_eq!(solution.statistics.factorizations, None);
    }
    // WSMP is part of no distribution's Ipopt.
    assert!(missing > 0);
}

/// Since 3.14 there is an option that names the library of HSL.
#[test]
fn a_library_that_is_not_hsl_is_a_status() {
    for library in ["", "no-such-library.so", "/no/such/library.so", "libm.so.6"] {
        let options = Options::new()
            .with("linear_solver", "ma97")
            .with("hsllib", library);
        let Ok(mut solver) = Solver::new(hs071_structure(), &options) else {
            assert!(VERSION < (3, 14, 0));
            continue;
        };
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        let linked = solution.status == Status::Solved;
        assert!(
            linked || solution.status == Status::InvalidOption,
            "{library}"
        );
    }
}

/// It takes MC19; Ipopt 3.11 ends the process where HSL is not installed.
#[test]
fn a_scaling_that_needs_hsl_is_a_status() {
    for method in ["equilibration-based", "Equilibration-Based"] {
        let options = Options::new().with("nlp_scaling_method", method);
        let mut solver = Solver::new(hs071_structure(), &options).unwrap();
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        if solution.status != Status::Solved {
            assert_eq!(solution.status, Status::InvalidOption);
            assert_eq!(solution.x, HS071_START);
        }
    }
}

#[test]
fn bad_starts_are_refused() {
    let mut solver = hs071_solver!();
    let mut solve = |start: &Start<'_>| solver.solve(&mut Hs071, start);
    assert!(matches!(
        solve(&Start::at(&[1.0; 3])),
        Err(Error::Nlp(NlpError::Length {
            found: 3,
            expected: 4,
            ..
        }))
    ));
    let nan = [1.0, f64::NAN, 1.0, 1.0];
    assert!(matches!(
        solve(&Start::at(&nan)),
        Err(Error::Nlp(NlpError::Value { index: 1, .. }))
    ));
    let multipliers = Multipliers {
        constraints: vec![0.0],
        lower: vec![0.0; 4],
        upper: vec![0.0; 4],
    };
    let start = Start {
        x: &HS071_START,
        multipliers: Some(&multipliers),
    };
    assert!(matches!(
        solve(&start),
        Err(Error::Nlp(NlpError::Length {
            found: 1,
            expected: 2,
            ..
        }))
    ));
    solver
        .set_options(&Options::new().with("warm_start_init_point", "yes"))
        .unwrap();
    assert_eq!(
        solver.solve(&mut Hs071, &Start::at(&HS071_START)),
        Err(Error::MissingMultipliers)
    );
    for bad in [
        Scaling {
            objective: f64::NAN,
            variables: None,
            constraints: None,
        },
        Scaling {
            objective: 1.0,
            variables: Some(vec![1.0; 3]),
            constraints: None,
        },
        Scaling {
            objective: 1.0,
            variables: None,
            constraints: Some(vec![1.0, 0.0]),
        },
    ] {
        assert!(
            matches!(solver.set_scaling(&bad), Err(Error::Nlp(_))),
            "{bad:?}"
        );
    }
}

/// [`Hs071`], which a flag stops; it may be raised as the solve begins.
struct Stoppable<'a>(&'a AtomicBool, bool);

impl Nlp for Stoppable<'_> {
    fn begin(&mut self, _: &[f64]) {
        self.0.store(self.1, Ordering::Relaxed);
    }
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        Hs071.objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        Hs071.gradient(x, new_x, gradient);
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        Hs071.constraints(x, new_x, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        Hs071.jacobian(x, new_x, values);
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, l: &[f64], values: &mut [f64]) {
        Hs071.hessian(x, new_x, sigma, l, values);
    }
    fn is_to_stop(&mut self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

#[test]
fn a_request_ends_a_solve_between_iterations() {
    let stop = AtomicBool::new(false);
    let mut solver = hs071_solver!();
    let start = Start::at(&HS071_START);
    let solution = solver.solve(&mut Stoppable(&stop, true), &start).unwrap();
    assert_eq!(solution.status, Status::StoppedByUser);
    assert_eq!(solution.statistics.factorizations, Some(0));
    stop.store(false, Ordering::Relaxed);
    let solution = solver.solve(&mut Stoppable(&stop, false), &start).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &HS071_X, 1e-6);
}

#[test]
fn a_request_is_seen_while_another_thread_solves() {
    let stop = AtomicBool::new(false);
    let (sender, ended) = mpsc::channel();
    thread::scope(|scope| {
        let mut asked = false;
        let solution = hs071_solver!().solve_with(&mut Hs071, &Start::at(&HS071_START), |_| {
            if !std::mem::replace(&mut asked, true) {
                let (sender, stop) = (sender.clone(), &stop);
                scope.spawn(move || {
                    let mut solver = hs071_solver!();
                    let solution =
                        solver.solve(&mut Stoppable(stop, false), &Start::at(&HS071_START));
                    sender.send(solution).unwrap();
                });
                assert!(
                    ended.recv_timeout(Duration::from_millis(50)).is_err(),
                    "it waits"
                );
                stop.store(true, Ordering::Relaxed);
                let waited = ended.recv_timeout(Duration::from_secs(30));
                let waited = waited.expect("it ends before this solve").unwrap();
                assert_eq!(waited.status, Status::StoppedByUser);
                assert_eq!((&waited.x[..], waited.history.len()), (&HS071_START[..], 0));
                assert!(waited.objective.is_nan() && waited.multipliers.is_none());
            }
            ControlFlow::Continue(())
        });
        assert_eq!(solution.unwrap().status, Status::Solved);
    });
}
