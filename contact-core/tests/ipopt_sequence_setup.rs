//! Sequences refuse at once what no solve could use, and keep log and scaling.
#![cfg(feature = "ipopt")]

use std::{
    io::{self, Write},
    ops::ControlFlow,
    sync::{Arc, Mutex},
};

use contact_core::{
    ipopt::{Error, Log, NlpScalingMethod, Options, Scaling, Sequence, SequenceSettings, Status},
    nlp::{Bounds, Multipliers, NlpError, Structure},
};

use problems::{HS071_START, HS071_X, Hs071, Separable, assert_close, hs071_structure};

fn hs071() -> Sequence {
    Sequence::new(hs071_structure(), SequenceSettings::default(), &HS071_START).unwrap()
}

fn zeros(n: usize, m: usize) -> Multipliers {
    Multipliers {
        constraints: vec![0.0; m],
        lower: vec![0.0; n],
        upper: vec![0.0; n],
    }
}

#[track_caller]
fn assert_nlp_error(outcome: Result<(), Error>) {
    assert!(matches!(outcome, Err(Error::Nlp(_))), "{outcome:?}");
}

#[test]
fn starts_that_cannot_be_are_refused_where_they_are_given() {
    let new =
        |x: &[f64]| Sequence::new(hs071_structure(), SequenceSettings::default(), x).map(|_| ());
    let nan = [1.0, f64::NAN, 1.0, 1.0];
    assert_nlp_error(new(&[1.0]));
    assert_nlp_error(new(&nan));

    let mut sequence = hs071();
    let solved = sequence.solve(&mut Hs071).unwrap().solution;
    assert_nlp_error(sequence.restart(&[1.0], None));
    assert_nlp_error(sequence.restart(&nan, None));
    assert_nlp_error(sequence.restart(&HS071_START, Some(zeros(4, 1))));
    let two = || Separable::structure(Bounds::free(2));
    assert_nlp_error(sequence.set_structure(two(), &HS071_START, None));
    assert_nlp_error(sequence.set_structure(two(), &[0.0; 2], Some(zeros(4, 2))));
    let infinite = Multipliers {
        lower: vec![f64::INFINITY; 2],
        ..zeros(2, 0)
    };
    assert_nlp_error(sequence.set_structure(two(), &[0.0; 2], Some(infinite)));

    // Nothing of it has stayed.
    assert_eq!(sequence.start().x, solved.x);
    let again = sequence.solve(&mut Hs071).unwrap();
    assert!(again.solved && again.warm && again.retried.is_none());
    assert_close(&again.solution.x, &HS071_X, 1e-6);
}

fn without_hessian() -> Structure {
    let s = hs071_structure();
    let bounds = (s.variable_bounds().clone(), s.constraint_bounds().clone());
    Structure::new(bounds.0, bounds.1, s.jacobian().clone(), None).unwrap()
}

#[test]
fn another_structure_must_suit_the_options_of_warm_solves_too() {
    let settings = SequenceSettings {
        warm: Options::new().with("hessian_approximation", "exact"),
        ..SequenceSettings::default()
    };
    let mut sequence = Sequence::new(hs071_structure(), settings, &HS071_START).unwrap();
    sequence.solve(&mut Hs071).unwrap();
    let error = sequence
        .set_structure(without_hessian(), &HS071_START, None)
        .unwrap_err();
    assert!(matches!(error, Error::Option(_)), "{error}");
    assert!(sequence.solve(&mut Hs071).unwrap().solved);
}

/// Only warm solves have multipliers, and they need not be told.
#[test]
fn cold_solves_have_no_multipliers_to_start_from() {
    let settings = SequenceSettings {
        options: Options::new().warm_start_init_point(true),
        ..SequenceSettings::default()
    };
    let new = Sequence::new(hs071_structure(), settings, &HS071_START);
    assert_eq!(new.err(), Some(Error::MissingMultipliers));
    let settings = SequenceSettings {
        warm: Options::new().warm_start().warm_start_init_point(true),
        ..SequenceSettings::default()
    };
    let mut sequence = Sequence::new(hs071_structure(), settings, &HS071_START).unwrap();
    for warm in [false, true] {
        let run = sequence.solve(&mut Hs071).unwrap();
        assert!(run.solved && run.warm == warm);
    }
}

#[test]
fn a_solve_that_is_refused_is_no_problem_solved_or_failed() {
    let mut inner = hs071();
    let mut sequence = hs071();
    let run = sequence.solve_with(&mut Hs071, |_| {
        assert_eq!(inner.solve(&mut Hs071), Err(Error::Reentrant));
        ControlFlow::Continue(())
    });
    assert!(run.unwrap().solved);
    let totals = *inner.totals();
    assert_eq!((totals.problems, totals.failures, totals.cold), (0, 0, 0));
    assert!(inner.solve(&mut Hs071).unwrap().solved);
    assert_eq!(inner.totals().problems, 1);
}

#[test]
fn iterates_are_shown_and_may_stop_a_solve() {
    let mut sequence = hs071();
    let mut seen = Vec::new();
    for _ in 0..2 {
        let run = sequence.solve_with(&mut Hs071, |iterate| {
            seen.push(iterate.record().iteration);
            ControlFlow::Continue(())
        });
        assert_eq!(
            seen.last(),
            Some(&run.unwrap().solution.statistics.iterations)
        );
    }
    assert_eq!(seen.iter().filter(|&&iteration| iteration == 0).count(), 2);
    let run = sequence
        .solve_with(&mut Hs071, |_| ControlFlow::Break(()))
        .unwrap();
    assert_eq!(run.solution.status, Status::StoppedByUser);
    assert!(!run.solved && run.retried.is_none());
}

#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

const SIX: Scaling = Scaling {
    objective: 6.0,
    variables: None,
    constraints: None,
};

/// |f′| of ½ (x − 3)² at −1, scaled.
fn first_gradient(sequence: &mut Sequence) -> f64 {
    sequence.restart(&[-1.0], None).unwrap();
    let run = sequence.solve(&mut Separable::new(&[3.0])).unwrap();
    assert_close(&run.solution.x, &[3.0], 1e-6);
    run.solution.history[0].dual_infeasibility
}

#[test]
fn log_and_scaling_stay_with_another_structure() {
    let text = Shared::default();
    let length = || text.0.lock().unwrap().len();
    let one = || Separable::structure(Bounds::free(1));
    let mut sequence = Sequence::new(one(), SequenceSettings::default(), &[-1.0]).unwrap();
    sequence.set_log(Log::writer(text.clone()));
    sequence.set_scaling(&SIX).unwrap();
    for _ in 0..2 {
        let before = length();
        assert_close(&[first_gradient(&mut sequence)], &[24.0], 1e-12);
        assert!(length() > before, "it is logged");
        sequence.set_structure(one(), &[0.0], None).unwrap();
    }
    // Factors of x are for problems of their size.
    let of_x = Scaling {
        variables: Some(vec![2.0]),
        ..SIX
    };
    sequence.set_scaling(&of_x).unwrap();
    let two = || Separable::structure(Bounds::free(2));
    assert!(matches!(
        sequence.set_structure(two(), &[0.0; 2], None),
        Err(Error::Nlp(NlpError::Length { .. }))
    ));
    assert_close(&[first_gradient(&mut sequence)], &[12.0], 1e-12);
    sequence.clear_scaling().unwrap();
    assert_close(&[first_gradient(&mut sequence)], &[4.0], 1e-12);
    let before = length();
    sequence.set_structure(two(), &[0.0; 2], None).unwrap();
    let run = sequence.solve(&mut Separable::new(&[1.0, 2.0])).unwrap();
    assert!(run.solved && length() > before);
}

/// Whichever of the two ignores it, and whichever was set last.
#[test]
fn a_scaling_that_some_solves_would_ignore_is_an_error() {
    let none = Options::new().nlp_scaling_method(NlpScalingMethod::None);
    for (options, warm) in [(none.clone(), Options::new()), (Options::new(), none)] {
        let settings = SequenceSettings {
            options,
            warm,
            ..SequenceSettings::default()
        };
        let mut sequence = Sequence::new(hs071_structure(), settings, &HS071_START).unwrap();
        for _ in 0..2 {
            let error = sequence.set_scaling(&SIX).unwrap_err();
            assert!(matches!(error, Error::UnusedScaling { .. }), "{error}");
            assert!(sequence.solve(&mut Hs071).unwrap().solved);
        }
    }
}
