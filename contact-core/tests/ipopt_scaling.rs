//! Scaling by the caller's factors.
#![cfg(feature = "ipopt")]

use std::ops::ControlFlow;

use contact_core::{
    ipopt::{Error, NlpScalingMethod, Options, Scaling, Solver, Start, Status},
    nlp::{Bounds, Multipliers, Nlp, NlpError},
};
use problems::*;

const FACTORS: Scaling = Scaling {
    objective: 6.0,
    variables: None,
    constraints: None,
};

/// Solves min ½ (x − 3)² from −1; the gradient there is −4 before scaling. What the log's `inf_du` says of the start.
fn first_gradient(solver: &mut Solver) -> f64 {
    let mut nlp = Separable::new(&[3.0]);
    let solution = solver.solve(&mut nlp, &Start::at(&[-1.0])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[3.0], 1e-6);
    solution.history[0].dual_infeasibility
}

fn solver(options: &Options) -> Solver {
    Solver::new(Separable::structure(Bounds::free(1)), options).unwrap()
}

#[test]
fn a_scaling_is_used_whether_or_not_the_option_is_set() {
    for options in [
        Options::new(),
        Options::new().nlp_scaling_method(NlpScalingMethod::User),
    ] {
        let mut solver = solver(&options);
        assert_close(&[first_gradient(&mut solver)], &[4.0], 1e-12);
        solver.set_scaling(&FACTORS).unwrap();
        assert_close(&[first_gradient(&mut solver)], &[6.0 * 4.0], 1e-12);
        // x̃ = 2 x has the derivative ½ ∂/∂x.
        let both = Scaling {
            variables: Some(vec![2.0]),
            ..FACTORS
        };
        solver.set_scaling(&both).unwrap();
        assert_close(&[first_gradient(&mut solver)], &[6.0 * 4.0 / 2.0], 1e-12);
        // Other options do not undo it.
        solver.set_options(&options.clone().tol(1e-9)).unwrap();
        assert_close(&[first_gradient(&mut solver)], &[6.0 * 4.0 / 2.0], 1e-12);
        solver.clear_scaling().unwrap();
        assert_close(&[first_gradient(&mut solver)], &[4.0], 1e-12);
    }
}

#[test]
fn a_scaling_that_would_be_ignored_is_an_error() {
    let other = Options::new().nlp_scaling_method(NlpScalingMethod::None);
    let mut early = solver(&other);
    let error = early.set_scaling(&FACTORS).unwrap_err();
    let expected = Error::UnusedScaling {
        method: "none".into(),
    };
    assert_eq!(error, expected);
    assert!(error.to_string().contains("nlp_scaling_method"));
    assert_close(&[first_gradient(&mut early)], &[4.0], 1e-12);

    let mut late = solver(&Options::new());
    late.set_scaling(&FACTORS).unwrap();
    assert_eq!(late.set_options(&other), Err(expected));
    assert_close(&[first_gradient(&mut late)], &[24.0], 1e-12);
    assert!(late.set_options(&Options::new().tol(-1.0)).is_err());
    assert_close(&[first_gradient(&mut late)], &[24.0], 1e-12);
    late.clear_scaling().unwrap();
    late.set_options(&other).unwrap();
    assert_close(&[first_gradient(&mut late)], &[4.0], 1e-12);
}

#[test]
fn factors_are_checked() {
    let mut solver = hs071_solver!();
    let mut refused = |scaling: Scaling| match solver.set_scaling(&scaling) {
        Err(Error::Nlp(error)) => error,
        other => panic!("{scaling:?}: {other:?}"),
    };
    for objective in [0.0, f64::NAN, f64::INFINITY] {
        let error = refused(Scaling {
            objective,
            ..FACTORS
        });
        assert!(matches!(error, NlpError::Value { index: 0, .. }), "{error}");
    }
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(Scaling {
            variables: Some(vec![1.0, 1.0, wrong, 1.0]),
            ..FACTORS
        });
        assert!(matches!(error, NlpError::Value { index: 2, .. }), "{error}");
        let error = refused(Scaling {
            constraints: Some(vec![1.0, wrong]),
            ..FACTORS
        });
        assert!(matches!(error, NlpError::Value { index: 1, .. }), "{error}");
    }
    let error = refused(Scaling {
        variables: Some(vec![1.0; 3]),
        ..FACTORS
    });
    assert!(
        matches!(
            error,
            NlpError::Length {
                found: 3,
                expected: 4,
                ..
            }
        ),
        "{error}"
    );
}

/// ∇f + λᵀ∂g/∂x − z_L + z_U.
fn stationarity(x: &[f64], multipliers: &Multipliers) -> Vec<f64> {
    let mut residual = vec![0.0; 4];
    let mut jacobian = vec![0.0; 8];
    Hs071.gradient(x, true, &mut residual);
    Hs071.jacobian(x, true, &mut jacobian);
    for (i, value) in residual.iter_mut().enumerate() {
        *value += multipliers.constraints[0] * jacobian[i];
        *value += multipliers.constraints[1] * jacobian[4 + i];
        *value += multipliers.upper[i] - multipliers.lower[i];
    }
    residual
}

/// Maximised with x₀ ≤ 3.5 instead of 5, so that a bound is active, and with x₀x₁x₂x₃ ≥ 80.
#[test]
fn maximising_reverses_the_signs_of_multipliers() {
    let mut variables = Bounds::uniform(4, 1.0, 5.0);
    variables.upper[0] = 3.5;
    let constraints = Bounds {
        lower: vec![80.0, 40.0],
        upper: vec![f64::INFINITY, 40.0],
    };
    let maximise = Scaling {
        objective: -1.0,
        ..FACTORS
    };
    let option = Options::new().obj_scaling_factor(-1.0);
    for (options, scaling) in [(Options::new(), Some(maximise)), (option, None)] {
        let mut solver = Solver::new(hs071_structure(), &options).unwrap();
        solver
            .set_bounds(variables.clone(), constraints.clone())
            .unwrap();
        if let Some(scaling) = &scaling {
            solver.set_scaling(scaling).unwrap();
        }
        let mut last = None;
        let solution = solver
            .solve_with(&mut Hs071, &Start::at(&HS071_START), |iterate| {
                last = iterate.multipliers().cloned();
                ControlFlow::Continue(())
            })
            .unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert!(solution.objective > HS071_OBJECTIVE + 1.0);
        assert_close(&solution.g, &[80.0, 40.0], 1e-5);
        assert_close(&solution.x[..1], &[3.5], 1e-5);

        let multipliers = solution.multipliers.unwrap();
        assert_close(&stationarity(&solution.x, &multipliers), &[0.0; 4], 1e-5);
        assert!(multipliers.constraints[0] > 0.05, "{multipliers:?}");
        assert!(multipliers.upper[0] < -0.1, "{multipliers:?}");
        let z = multipliers.lower.iter().chain(&multipliers.upper);
        assert!(z.copied().all(|z| z <= 0.0), "{multipliers:?}");
        let last = last.unwrap();
        assert_close(&last.constraints, &multipliers.constraints, 1e-12);
        assert_close(&last.upper, &multipliers.upper, 1e-12);

        solver.set_options(&options.clone().warm_start()).unwrap();
        let again = Start {
            x: &solution.x,
            multipliers: Some(&multipliers),
        };
        let warm = solver.solve(&mut Hs071, &again).unwrap();
        assert_eq!(warm.status, Status::Solved);
        assert!(warm.statistics.iterations <= 3, "{:?}", warm.history);
    }
}
