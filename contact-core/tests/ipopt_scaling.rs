//! Scaling by the caller's factors.
#![cfg(feature = "ipopt")]

mod common;

use common::*;
use contact_core::{
    ipopt::{Error, NlpScalingMethod, Options, Scaling, Solver, Start, Status},
    nlp::{Bounds, NlpError},
};

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
    late.clear_scaling().unwrap();
    late.set_options(&other).unwrap();
    assert!(late.set_options(&Options::new().tol(-1.0)).is_err());
    assert_close(&[first_gradient(&mut late)], &[24.0], 1e-12);
    assert_close(&[first_gradient(&mut late)], &[4.0], 1e-12);
}

#[test]
fn factors_are_checked() {
    let mut solver = hs071_solver();
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
    // A negative factor of f maximises: no error, and another solution.
    let maximise = Scaling {
        objective: -1.0,
        ..FACTORS
    };
    solver.set_scaling(&maximise).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert!(solution.status.is_acceptable());
    assert!(
        solution.objective > HS071_OBJECTIVE + 1.0,
        "{}",
        solution.objective
    );
}
