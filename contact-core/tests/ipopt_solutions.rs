//! The driver against solutions known from elsewhere.
#![cfg(feature = "ipopt")]

use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

use contact_core::{
    ipopt::{FixedVariableTreatment, Options, Scaling, Solver, Start, Status},
    nlp::{Bounds, Nlp, Pattern, Structure},
};
use problems::*;

#[test]
fn hs071_has_the_published_solution() {
    let solution = hs071_solver!()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.objective - HS071_OBJECTIVE).abs() < 1e-6);
    assert_close(&solution.x, &HS071_X, 1e-6);
    assert_close(&solution.g, &[25.0, 40.0], 1e-6);
    let multipliers = solution.multipliers.unwrap();
    assert_close(&multipliers.constraints, &HS071_LAMBDA, 1e-6);
    assert_close(&multipliers.lower, &HS071_LOWER, 1e-6);
    assert_close(&multipliers.upper, &[0.0; 4], 1e-6);
}

#[test]
fn hs071_needs_no_hessian() {
    let s = hs071_structure();
    let structure = Structure::new(
        s.variable_bounds().clone(),
        s.constraint_bounds().clone(),
        s.jacobian().clone(),
        None,
    )
    .unwrap();
    let mut nlp = Watched::new(Hs071, |function| {
        assert_ne!(function, Function::Hessian);
        ControlFlow::Continue(())
    });
    let solution = Solver::new(structure.clone(), &Options::new())
        .unwrap()
        .solve(&mut nlp, &Start::at(&HS071_START))
        .unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &HS071_X, 1e-6);
    assert_eq!(solution.statistics.hessian.calls, 0);
    // Ipopt would take it for zero.
    assert!(
        Solver::new(
            structure,
            &Options::new().with("hessian_approximation", "exact")
        )
        .is_err()
    );
}

#[test]
fn user_scaling_changes_the_path_but_not_the_answer() {
    let options = Options::new().with("nlp_scaling_method", "user-scaling");
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let mut path = |objective: f64, x: f64, g: f64| {
        let scaling = Scaling {
            objective,
            variables: Some(vec![x; 4]),
            constraints: Some(vec![g, 1.0 / g]),
        };
        solver.set_scaling(&scaling).unwrap();
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert!((solution.objective - HS071_OBJECTIVE).abs() < 1e-5);
        assert_close(&solution.x, &HS071_X, 1e-5);
        assert_close(
            &solution.multipliers.unwrap().constraints,
            &HS071_LAMBDA,
            1e-4,
        );
        solution
            .history
            .iter()
            .map(|record| record.objective)
            .collect::<Vec<_>>()
    };
    assert_ne!(path(1.0, 1.0, 1.0), path(100.0, 3.0, 7.0));
}

#[test]
fn bounds_alone_clamp() {
    let mut nlp = Separable::new(&[-2.0, 0.25, 7.0]);
    let mut solver = Solver::new(
        Separable::structure(Bounds::uniform(3, 0.0, 1.0)),
        &Options::new(),
    )
    .unwrap();
    let solution = solver.solve(&mut nlp, &Start::at(&[0.5; 3])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[0.0, 0.25, 1.0], 1e-7);
    assert!(
        solution.x.iter().all(|x| (0.0..=1.0).contains(x)),
        "bounds are kept exactly: {:?}",
        solution.x
    );
    let multipliers = solution.multipliers.unwrap();
    assert_close(&multipliers.lower, &[2.0, 0.0, 0.0], 1e-6);
    assert_close(&multipliers.upper, &[0.0, 0.0, 6.0], 1e-6);
    assert!(multipliers.constraints.is_empty() && solution.g.is_empty());
    assert_eq!(
        solution.statistics.hessian.calls, 1,
        "a constant Hessian is evaluated once"
    );
}

#[test]
fn one_variable() {
    let mut nlp = Separable::new(&[3.0]);
    let mut solver = Solver::new(Separable::structure(Bounds::free(1)), &Options::new()).unwrap();
    let solution = solver.solve(&mut nlp, &Start::at(&[-1.0])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[3.0], 1e-8);
}

#[test]
fn a_fixed_variable_stays_and_so_do_all() {
    let mut nlp = Separable::new(&[1.0, 2.0, 3.0]);
    let bounds = Bounds {
        lower: vec![-9.0, 5.0, -9.0],
        upper: vec![9.0, 5.0, 9.0],
    };
    let mut solver = Solver::new(Separable::structure(bounds), &Options::new()).unwrap();
    let solution = solver.solve(&mut nlp, &Start::at(&[0.0; 3])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[1.0, 5.0, 3.0], 1e-7);

    let all = Bounds {
        lower: vec![4.0, 5.0, 6.0],
        upper: vec![4.0, 5.0, 6.0],
    };
    solver.set_bounds(all, Bounds::default()).unwrap();
    let solution = solver.solve(&mut nlp, &Start::at(&[0.0; 3])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_eq!(solution.x, [4.0, 5.0, 6.0]);
    assert_eq!(solution.objective, 13.5);
    assert_eq!(solution.multipliers, None);
}

/// x₀² + x₁² ≤ −1.
struct Infeasible;

impl Nlp for Infeasible {
    fn objective(&mut self, _: &[f64], _: bool) -> f64 {
        0.0
    }
    fn gradient(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = x[0] * x[0] + x[1] * x[1];
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values[0] = 2.0 * x[0];
        values[1] = 2.0 * x[1];
    }
    fn hessian(&mut self, _: &[f64], _: bool, _: f64, lambda: &[f64], values: &mut [f64]) {
        values.fill(2.0 * lambda[0]);
    }
}

#[test]
fn infeasible_is_a_status() {
    let structure = Structure::new(
        Bounds::free(2),
        Bounds::uniform(1, f64::NEG_INFINITY, -1.0),
        Pattern::dense(1, 2),
        Some(Pattern::diagonal(2)),
    );
    let mut solver = Solver::new(structure.unwrap(), &Options::new()).unwrap();
    let solution = solver
        .solve(&mut Infeasible, &Start::at(&[3.0, 4.0]))
        .unwrap();
    assert_eq!(solution.status, Status::Infeasible);
    assert!(!solution.status.is_solved() && !solution.status.is_acceptable());
    assert_eq!(solution.multipliers, None);
    assert_close(&solution.x, &[0.0, 0.0], 1e-2);
}

#[test]
fn unbounded_is_a_status() {
    let structure = Separable::structure(Bounds::free(1)).with_constant_hessian(false);
    let mut nlp = Separable {
        weights: vec![-1.0],
        centre: vec![0.0],
    };
    let solution = Solver::new(structure, &Options::new())
        .unwrap()
        .solve(&mut nlp, &Start::at(&[1.0]))
        .unwrap();
    assert_eq!(solution.status, Status::Diverging);
    assert!(solution.x[0].abs() > 1e10);
    assert_eq!(solution.multipliers, None);
}

#[test]
fn limits_and_stops_are_statuses() {
    let mut solver = Solver::new(hs071_structure(), &Options::new().with("max_iter", 3)).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::IterationLimit);
    assert_eq!(solution.statistics.iterations, 3);
    assert_eq!(solution.history.len(), 4);
    assert!(solution.multipliers.is_some());

    solver.set_options(&Options::new()).unwrap();
    let mut iterations = 0;
    let mut nlp = Watched::new(Hs071, |function| {
        iterations += usize::from(function == Function::Iterate);
        if iterations == 3 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let solution = solver.solve(&mut nlp, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::StoppedByUser);
    assert_eq!(solution.history.len(), 3);
    assert!(
        (solution.objective - HS071_OBJECTIVE).abs() > 1e-6,
        "it stopped before the solution"
    );

    // Processor time advances in steps of milliseconds.
    let mut slow = Watched::new(Hs071, |_| {
        let clock = Instant::now();
        while clock.elapsed() < Duration::from_millis(5) {}
        ControlFlow::Continue(())
    });
    solver
        .set_options(&Options::new().with("max_cpu_time", 1e-3))
        .unwrap();
    let solution = solver.solve(&mut slow, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::CpuTimeLimit);
    assert_eq!(
        solution.multipliers, None,
        "Ipopt's zeros are no multipliers"
    );
    assert!(solution.objective.is_nan() && solution.g.iter().all(|g| g.is_nan()));
    assert!(solution.history.last().unwrap().objective > 0.0);

    solver.set_options(&Options::new()).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
}

#[test]
fn more_equalities_than_variables_is_a_status() {
    let structure = Structure::new(
        Bounds::free(1),
        Bounds::zero(2),
        Pattern::dense(2, 1),
        Some(Pattern::diagonal(1)),
    );
    struct Two;
    impl Nlp for Two {
        fn objective(&mut self, _: &[f64], _: bool) -> f64 {
            0.0
        }
        fn gradient(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
        fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
            g.copy_from_slice(&[x[0], x[0] - 1.0]);
        }
        fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
            values.fill(1.0);
        }
        fn hessian(&mut self, _: &[f64], _: bool, _: f64, _: &[f64], _: &mut [f64]) {}
    }
    let mut solver = Solver::new(structure.unwrap(), &Options::new()).unwrap();
    let solution = solver.solve(&mut Two, &Start::at(&[0.25])).unwrap();
    assert_eq!(solution.status, Status::TooFewDegreesOfFreedom);
    assert_eq!(solution.x, [0.25], "the start");
    assert!(solution.objective.is_nan() && solution.g.iter().all(|g| g.is_nan()));
    assert_eq!(solution.multipliers, None);
    assert!(solution.statistics.constraint_violation.is_nan());
}

/// min ½ Σ (xᵢ − 2)² subject to x₀ + x₁ = 2 and x₀ = 1.
struct Pinned;

impl Nlp for Pinned {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        Separable::new(&[2.0; 2]).objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        Separable::new(&[2.0; 2]).gradient(x, new_x, gradient);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g.copy_from_slice(&[x[0] + x[1], x[0]]);
    }
    fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
        values.fill(1.0);
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values.fill(sigma);
    }
}

/// Two equalities, a free variable and a fixed one: Ipopt relaxes by itself, and asking for it changes nothing.
#[test]
fn fixed_variables_are_relaxed_where_the_free_ones_are_too_few() {
    let structure = Structure::new(
        Bounds {
            lower: vec![f64::NEG_INFINITY, 1.0],
            upper: vec![f64::INFINITY, 1.0],
        },
        Bounds {
            lower: vec![2.0, 1.0],
            upper: vec![2.0, 1.0],
        },
        [(0, 0), (0, 1), (1, 0)].into_iter().collect(),
        Some(Pattern::diagonal(2)),
    )
    .unwrap();
    let solve = |options: Options| {
        let mut solver = Solver::new(structure.clone(), &options).unwrap();
        solver.solve(&mut Pinned, &Start::at(&[0.3; 2])).unwrap()
    };
    let unasked = solve(Options::new());
    let asked = solve(Options::new().fixed_variable_treatment(FixedVariableTreatment::RelaxBounds));
    for solution in [&unasked, &asked] {
        assert_eq!(solution.status, Status::Solved);
        assert_close(&solution.x, &[1.0, 1.0], 1e-7);
    }
    assert_eq!(unasked.history, asked.history, "the same path");
    let constraints =
        Options::new().fixed_variable_treatment(FixedVariableTreatment::MakeConstraint);
    assert_eq!(solve(constraints).status, Status::TooFewDegreesOfFreedom);
}

/// min ½ Σ (xᵢ − 3)² with x₀ fixed at 5.
#[test]
fn relaxed_bounds_have_multipliers_with_a_meaningful_difference() {
    let bounds = Bounds {
        lower: vec![5.0, -9.0],
        upper: vec![5.0, 9.0],
    };
    for factor in [0.0, 1e-8] {
        let options = Options::new()
            .fixed_variable_treatment(FixedVariableTreatment::RelaxBounds)
            .bound_relax_factor(factor);
        let mut solver = Solver::new(Separable::structure(bounds.clone()), &options).unwrap();
        let solution = solver
            .solve(&mut Separable::new(&[3.0; 2]), &Start::at(&[0.0; 2]))
            .unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert_close(&solution.x, &[5.0, 3.0], 1e-6);
        let multipliers = solution.multipliers.unwrap();
        let difference = multipliers.lower[0] - multipliers.upper[0];
        assert!((difference - 2.0).abs() < 1e-5, "{factor}: {difference}");
    }
}

#[test]
fn an_obstacle_presses_with_minus_lambda() {
    let n = 63;
    let mut nlp = Obstacle { n, load: 8.0 };
    let mut solver = Solver::new(Obstacle::structure(n, -100.0), &Options::new()).unwrap();
    let free = solver.solve(&mut nlp, &Start::at(&vec![0.0; n])).unwrap();
    assert_eq!(free.status, Status::Solved);
    assert_close(&free.x, &nlp.free().collect::<Vec<_>>(), 1e-6);
    assert_eq!(free.statistics.hessian.calls, 1, "constant");
    assert!(
        free.statistics.jacobian.calls <= 3,
        "constant, and once more to find the scaling, and to check the solution"
    );

    // The floor at −½ carries what the string's ends do not: by equilibrium, the sum of −λ is the load minus the
    // two end forces u/h, known from the solution.
    solver
        .set_bounds(Bounds::free(n), Bounds::uniform(n, -0.5, f64::INFINITY))
        .unwrap();
    let contact = solver.solve(&mut nlp, &Start::at(&vec![0.0; n])).unwrap();
    assert_eq!(contact.status, Status::Solved);
    assert!(contact.x.iter().all(|u| *u >= -0.5 - 1e-9));
    let lambda = contact.multipliers.unwrap().constraints;
    assert!(
        lambda.iter().all(|l| *l <= 0.0),
        "active lower bounds have λ ≤ 0: {lambda:?}"
    );
    let pressure: f64 = lambda.iter().map(|l| -l).sum();
    let h = 1.0 / (n as f64 + 1.0);
    let ends = -(contact.x[0] + contact.x[n - 1]) / h;
    assert!(pressure > 1.0);
    assert!((pressure + ends - n as f64 * 8.0 * h).abs() < 1e-7);
}

#[test]
fn multipliers_of_a_neighbour_save_iterations() {
    let n = 200;
    let start = vec![0.0; n];
    let mut solver = Solver::new(Obstacle::structure(n, -0.5), &Options::new()).unwrap();
    let first = solver
        .solve(&mut Obstacle { n, load: 8.0 }, &Start::at(&start))
        .unwrap();
    let cold = solver
        .solve(&mut Obstacle { n, load: 8.4 }, &Start::at(&start))
        .unwrap();
    solver.set_options(&Options::new().warm_start()).unwrap();
    let from = Start {
        x: &first.x,
        multipliers: first.multipliers.as_ref(),
    };
    let warm = solver.solve(&mut Obstacle { n, load: 8.4 }, &from).unwrap();
    assert_eq!((cold.status, warm.status), (Status::Solved, Status::Solved));
    assert_close(&warm.x, &cold.x, 1e-6);
    let (cold, warm) = (cold.statistics.iterations, warm.statistics.iterations);
    assert!(warm < cold, "warm {warm}, cold {cold}");
    eprintln!("iterations: cold {cold}, warm {warm}");
}

#[test]
fn codes_survive() {
    for code in (-200..20).chain([i32::MIN, i32::MAX]) {
        let status = Status::from_code(code);
        assert_eq!(status.code(), code);
        assert_eq!(status.is_solved(), code == 0);
        assert_eq!(status.is_acceptable(), [0, 1, 6].contains(&code));
        assert!(!status.to_string().is_empty());
    }
    assert_eq!(Status::from_code(-77), Status::Other(-77));
    assert!(Status::Other(-77).to_string().contains("-77"));
}
