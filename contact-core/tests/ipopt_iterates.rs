//! What a solve tells while it runs and when it is done.
#![cfg(feature = "ipopt")]

use std::{cell::RefCell, collections::HashMap, ops::ControlFlow};

use contact_core::{
    ipopt::{Options, Solution, Solver, Start, Status},
    nlp::{Bounds, Iterate, IterationRecord, Multipliers, Nlp, Phase, Structure},
};
use problems::*;

/// All that was seen of an iterate.
#[derive(Debug)]
struct Seen {
    record: IterationRecord,
    x: Option<Vec<f64>>,
    g: Option<Vec<f64>>,
    multipliers: Option<Multipliers>,
}

/// Another problem, its iterates written down.
struct Recorded<N> {
    nlp: N,
    seen: Vec<Seen>,
}

impl<N: Nlp> Nlp for Recorded<N> {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        self.nlp.objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        self.nlp.gradient(x, new_x, gradient);
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        self.nlp.constraints(x, new_x, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        self.nlp.jacobian(x, new_x, values);
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        self.nlp.hessian(x, new_x, sigma, lambda, values);
    }
    fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
        self.seen.push(Seen {
            record: *iterate.record(),
            x: iterate.x().map(<[f64]>::to_vec),
            g: iterate.constraints().map(<[f64]>::to_vec),
            multipliers: iterate.multipliers().cloned(),
        });
        ControlFlow::Continue(())
    }
}

/// Solves, and checks that every regular iterate is what its record says and the last one is the solution.
fn watch<N: Nlp>(
    structure: Structure,
    nlp: N,
    start: &[f64],
    options: &Options,
) -> (Solution, Vec<Seen>) {
    let mut solver = Solver::new(structure.clone(), options).unwrap();
    let mut nlp = Recorded {
        nlp,
        seen: Vec::new(),
    };
    let solution = solver.solve(&mut nlp, &Start::at(start)).unwrap();
    let Recorded { mut nlp, seen } = nlp;
    assert_eq!(seen.len(), solution.history.len());
    let (m, bounds) = (structure.constraints(), structure.variable_bounds());
    for Seen { record, x, g, .. } in &seen {
        let x = x.as_ref().expect("there always is an x");
        // With make_constraint, a fixed variable is on its way until the end.
        let parameters = options.get("fixed_variable_treatment") != Some(&"make_constraint".into());
        for (i, x) in x.iter().enumerate() {
            if parameters && bounds.lower[i] == bounds.upper[i] {
                assert_eq!(*x, bounds.lower[i], "fixed variables are in their places");
            }
        }
        if record.phase == Phase::Regular {
            let f = nlp.objective(x, true);
            assert!(
                (f - record.objective).abs() <= 1e-12 * f.abs().max(1.0),
                "{f} and {record:?}"
            );
            let mut expected = vec![0.0; m];
            if m > 0 {
                nlp.constraints(x, true, &mut expected);
            }
            assert_close(g.as_ref().expect("there is a g"), &expected, 1e-12 * 40.0);
        }
    }
    let last = seen.last().expect("there is an iterate");
    if last.record.phase == Phase::Regular {
        assert_eq!(last.x.as_deref(), Some(&solution.x[..]));
    }
    (solution, seen)
}

fn assert_same_multipliers(seen: &Seen, solution: &Solution, free: &[usize]) {
    let (a, b) = (
        seen.multipliers.as_ref().unwrap(),
        solution.multipliers.as_ref().unwrap(),
    );
    assert_close(&a.constraints, &b.constraints, 1e-12);
    for &i in free {
        assert_close(&[a.lower[i], a.upper[i]], &[b.lower[i], b.upper[i]], 1e-12);
    }
}

#[test]
fn iterates_with_equality_inequality_and_bounds() {
    for method in ["none", "gradient-based"] {
        // A scaling of a tenth at most: values and multipliers must come back unscaled.
        let options = Options::new()
            .with("nlp_scaling_method", method)
            .with("nlp_scaling_max_gradient", 1.0);
        let (solution, seen) = watch(hs071_structure(), Hs071, &HS071_START, &options);
        assert_eq!(solution.status, Status::Solved);
        assert_same_multipliers(seen.last().unwrap(), &solution, &[0, 1, 2, 3]);
        assert_close(
            &seen
                .last()
                .unwrap()
                .multipliers
                .as_ref()
                .unwrap()
                .constraints,
            &HS071_LAMBDA,
            1e-6,
        );
        let start = &seen[0].record;
        assert_eq!(
            (start.iteration, start.phase, start.line_search_trials),
            (0, Phase::Regular, 0)
        );
    }
}

#[test]
fn iterates_with_fixed_variables() {
    // HS071 with x₁ fixed at its solution, so that all else stays as published.
    let base = hs071_structure();
    for treatment in ["make_parameter", "make_constraint"] {
        let mut structure = base.clone();
        let mut x = base.variable_bounds().clone();
        (x.lower[1], x.upper[1]) = (HS071_X[1], HS071_X[1]);
        structure
            .set_bounds(x, base.constraint_bounds().clone())
            .unwrap();
        let options = Options::new().with("fixed_variable_treatment", treatment);
        let (solution, seen) = watch(structure, Hs071, &HS071_START, &options);
        assert_eq!(solution.status, Status::Solved, "{treatment}");
        assert_close(&solution.x, &HS071_X, 1e-5);
        let last = seen.last().unwrap().multipliers.as_ref().unwrap();
        assert_same_multipliers(seen.last().unwrap(), &solution, &[0, 2, 3]);
        assert!(
            (last.lower[0] - HS071_LOWER[0]).abs() < 1e-3,
            "z_L belongs to x₀: {last:?}"
        );
    }
}

#[test]
fn iterates_without_constraints() {
    let bounds = Bounds {
        lower: vec![0.0, 0.0, 2.0, f64::NEG_INFINITY],
        upper: vec![1.0, 1.0, 2.0, -1.0],
    };
    let nlp = Separable {
        weights: vec![1.0, 1e4, 1.0, 3.0],
        centre: vec![-2.0, 0.25, 7.0, 1.0],
    };
    let (solution, seen) = watch(
        Separable::structure(bounds),
        nlp,
        &[0.5; 4],
        &Options::new(),
    );
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[0.0, 0.25, 2.0, -1.0], 1e-6);
    // Of the fixed variable, which is none to Ipopt, only the solution has multipliers, and since 3.14 only.
    assert_same_multipliers(seen.last().unwrap(), &solution, &[0, 1, 3]);
    let last = seen.last().unwrap().multipliers.as_ref().unwrap();
    assert_close(&last.lower, &[2.0, 0.0, 0.0, 0.0], 1e-4);
    assert_close(&last.upper, &[0.0, 0.0, 0.0, 6.0], 1e-4);
}

/// Checks what is seen of the restoration phase; how the solve ended.
fn restore(start: &[f64; 4]) -> Solution {
    let structure = WaechterBiegler::structure();
    let (solution, seen) = watch(structure, WaechterBiegler, start, &Options::new());
    let restoring = seen
        .iter()
        .filter(|seen| seen.record.phase == Phase::Restoration);
    assert!(
        restoring.clone().count() > 0,
        "this problem needs the restoration phase"
    );
    for seen in restoring {
        assert!(
            seen.g.is_none() && seen.multipliers.is_none(),
            "those are another problem's"
        );
        // That x is the problem's own: its violation is the one Ipopt reports.
        let x = seen.x.as_ref().unwrap();
        let violation = (x[0] * x[0] - x[1] - 1.0)
            .abs()
            .max((x[0] - x[2] - 0.5).abs());
        let reported = seen.record.primal_infeasibility;
        assert!(
            (violation - reported).abs() <= 1e-9 * reported.max(1.0),
            "{violation} and {reported}"
        );
    }
    if solution.status.is_solved() {
        assert_same_multipliers(seen.last().unwrap(), &solution, &[0, 1, 2]);
    }
    solution
}

#[test]
fn iterates_in_restoration() {
    let solved = restore(&[-1.0, 3.0, 1.0, 7.0]);
    assert_eq!(solved.status, Status::Solved);
    assert_close(&solved.x, &[1.0, 0.0, 0.5, 7.0], 1e-6);

    // From here it ends where the violation is least: near (−1, 0, 0) nothing can be gained to first order.
    let stuck = restore(&WaechterBiegler::START);
    assert_eq!(stuck.status, Status::Infeasible);
    assert_close(&stuck.x, &[-1.0, 0.0, 0.0, 7.0], 1e-6);
    assert_eq!(stuck.multipliers, None);
}

#[test]
fn a_stop_in_restoration_leaves_no_multipliers() {
    let mut stop = |iterate: &Iterate<'_>| match iterate.record().phase {
        Phase::Regular => ControlFlow::Continue(()),
        Phase::Restoration => ControlFlow::Break(()),
    };
    struct Stop<'a, F>(WaechterBiegler, &'a mut F);
    impl<F: FnMut(&Iterate<'_>) -> ControlFlow<()>> Nlp for Stop<'_, F> {
        fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
            self.0.objective(x, new_x)
        }
        fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
            self.0.gradient(x, new_x, gradient);
        }
        fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
            self.0.constraints(x, new_x, g);
        }
        fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
            self.0.jacobian(x, new_x, values);
        }
        fn hessian(
            &mut self,
            x: &[f64],
            new_x: bool,
            sigma: f64,
            lambda: &[f64],
            values: &mut [f64],
        ) {
            self.0.hessian(x, new_x, sigma, lambda, values);
        }
        fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
            (self.1)(iterate)
        }
    }
    let mut solver = Solver::new(WaechterBiegler::structure(), &Options::new()).unwrap();
    let mut nlp = Stop(WaechterBiegler, &mut stop);
    let solution = solver
        .solve(&mut nlp, &Start::at(&WaechterBiegler::START))
        .unwrap();
    assert_eq!(solution.status, Status::StoppedByUser);
    assert_eq!(solution.multipliers, None);
}

#[test]
fn statistics_count_what_happened() {
    let calls = RefCell::new(HashMap::new());
    let mut nlp = Watched::new(Hs071, |function| {
        *calls
            .borrow_mut()
            .entry(format!("{function:?}"))
            .or_insert(0usize) += 1;
        ControlFlow::Continue(())
    });
    let mut solver = hs071_solver!();
    let solution = solver.solve(&mut nlp, &Start::at(&HS071_START)).unwrap();
    let statistics = &solution.statistics;
    let count = |name: &str| calls.borrow()[name];
    assert_eq!(statistics.objective.calls, count("Objective"));
    assert_eq!(statistics.gradient.calls, count("Gradient"));
    assert_eq!(statistics.constraints.calls, count("Constraints"));
    assert_eq!(statistics.jacobian.calls, count("Jacobian"));
    assert_eq!(statistics.hessian.calls, count("Hessian"));
    assert_eq!(solution.history.len(), count("Iterate"));

    let iterations = statistics.iterations;
    assert_eq!(iterations + 1, solution.history.len());
    assert_eq!(statistics.hessian.calls, iterations, "one for each step");
    let factorizations = statistics.factorizations.expect("MUMPS is counted");
    assert!(
        factorizations >= iterations && factorizations < 4 * iterations,
        "{statistics:?}"
    );
    assert!(statistics.back_solves.unwrap() >= iterations);
    assert!(statistics.factor_entries.unwrap() >= 10);
    assert!(statistics.constraint_violation < 1e-8 && statistics.complementarity < 1e-7);
    assert!(statistics.dual_infeasibility < 1e-7 && statistics.scaled_error < 1e-8);
    assert!(statistics.total.wall > 0.0 && statistics.total.wall < 10.0);
    let [symbolic, factorization, back_solve] = [
        statistics.symbolic_factorization,
        statistics.factorization,
        statistics.back_solve,
    ]
    .map(|time| time.unwrap().wall);
    assert!(
        symbolic > 0.0 && factorization > 0.0 && back_solve > 0.0,
        "{statistics:?}"
    );
    assert!(
        symbolic + factorization + back_solve < statistics.total.wall,
        "{statistics:?}"
    );
    assert!(statistics.evaluation_time().as_secs_f64() < statistics.total.wall);

    // The next solve counts afresh.
    let again = solver
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap()
        .statistics;
    assert_eq!(again.objective.calls, statistics.objective.calls);
    assert_eq!(again.factorizations, statistics.factorizations);
}

#[test]
fn regularisation_costs_factorisations() {
    let record = |nlp: &mut dyn Nlp, structure, start: &[f64]| {
        let solution = Solver::new(structure, &Options::new())
            .unwrap()
            .solve(nlp, &Start::at(start))
            .unwrap();
        let regularised = solution
            .history
            .iter()
            .filter(|record| record.regularization > 0.0)
            .count();
        let surplus = solution.statistics.factorizations.unwrap() - solution.statistics.iterations;
        (regularised, surplus)
    };
    let convex = record(
        &mut Separable::new(&[3.0, -3.0]),
        Separable::structure(Bounds::nonnegative(2)),
        &[1.0; 2],
    );
    // cos-like: −½x² within bounds has the wrong inertia until a multiple of the identity is added.
    let mut concave = Separable {
        weights: vec![-1.0, -1.0],
        centre: vec![0.1, 0.2],
    };
    let structure = Separable::structure(Bounds::uniform(2, -1.0, 1.0));
    let concave = record(&mut concave, structure, &[0.3, 0.3]);
    assert_eq!(convex.0, 0);
    assert!(concave.0 > 0, "it needs regularisation");
    assert!(
        concave.1 > convex.1,
        "surplus factorisations: convex {}, concave {}",
        convex.1,
        concave.1
    );
}
