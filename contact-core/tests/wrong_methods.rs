//! Methods, problems and checks that get or return what is no number, or of another length.

use std::ops::ControlFlow;

use contact_core::check::{self, Differences};
use contact_core::equilibrium::{Equilibrium, StepContext};
use contact_core::gaps::Sampling;
use contact_core::linear::SymmetricPattern;
use contact_core::load_steps::Run;
use contact_core::method::Subproblem;
use contact_core::nlp::{Nlp, NlpError, Pattern, Structure};
use contact_core::{
    Bounds, ContactProblem, Cost, Ending, Energy, Error, FixedPoint, LinearGaps, LoadStepped,
    LoadSteps, Method, Minimum, Outcome, Solved, State, Stop,
};

/// E(u) = ½ |u|² − p Σ u, without contact; rows are never exact, so that iterations are mixed.
struct Springs {
    load: f64,
    bounds: Bounds,
    pattern: SymmetricPattern,
    /// What its gradient is multiplied by: 1 unless it is to be wrong.
    factor: f64,
    /// The load factor from which loads are refused.
    refuses: f64,
}

impl Springs {
    const DOFS: usize = 3;

    fn new() -> Self {
        Springs {
            load: 0.0,
            bounds: Bounds::free(Self::DOFS),
            pattern: SymmetricPattern::diagonal(Self::DOFS),
            factor: 1.0,
            refuses: f64::INFINITY,
        }
    }
}

impl Energy for Springs {
    fn dofs(&self) -> usize {
        Self::DOFS
    }
    fn value(&self, u: &[f64]) -> f64 {
        u.iter().map(|u| (0.5 * u - self.load) * u).sum()
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        let slopes = u.iter().map(|u| self.factor * (u - self.load));
        g.iter_mut().zip(slopes).for_each(|(g, slope)| *g = slope);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.fill(self.factor);
    }
}

impl ContactProblem for Springs {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(LinearGaps::new(false))
    }
}

impl LoadStepped for Springs {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        if factor >= self.refuses {
            return Err(Error::problem(std::fmt::Error));
        }
        self.load = factor;
        Ok(())
    }
}

/// Moves half the way to the minimum, and then lets `spoil` have the result.
struct Halfway<F>(F);

impl<F: FnMut(f64, &mut Minimum) -> Result<(), Error>> Method for Halfway<F> {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let mut gradient = vec![0.0; start.u.len()];
        subproblem.energy.gradient(&start.u, &mut gradient);
        // each unknown at a speed of its own, so that the residuals differ
        let speeds = [0.5, 0.7, 0.9];
        let moved = start.u.iter().zip(&gradient).zip(speeds);
        let u: Vec<f64> = moved.map(|((u, g), speed)| u - speed * g).collect();
        let mut minimum = Minimum {
            energy: subproblem.energy.value(&u),
            u,
            lambda: Vec::new(),
            solved: Solved::Optimal,
            cost: Cost::default(),
        };
        let load = start.u[0] + -gradient[0];
        (self.0)(load, &mut minimum)?;
        Ok(minimum)
    }
}

fn solve(
    problem: &Springs,
    spoil: impl FnMut(f64, &mut Minimum) -> Result<(), Error>,
) -> Result<(Outcome, Vec<f64>), Error> {
    let start = State {
        u: vec![0.0; Springs::DOFS],
        ..State::default()
    };
    let solution = FixedPoint::with(Halfway(spoil)).solve_from(problem, start)?;
    Ok((solution.outcome, solution.state.u))
}

fn loaded() -> Springs {
    Springs {
        load: 1.0,
        ..Springs::new()
    }
}

#[test]
fn a_method_that_returns_no_numbers_has_failed() {
    let (outcome, u) = solve(&loaded(), |_, _| Ok(())).unwrap();
    assert_eq!(outcome, Outcome::Converged);
    assert!(u.iter().all(|u| (u - 1.0).abs() < 1e-5), "{u:?}");
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for at in 0..4 {
            for of_energy in [false, true] {
                let mut calls = 0;
                let (outcome, u) = solve(&loaded(), |_, minimum| {
                    if calls == at {
                        *if of_energy {
                            &mut minimum.energy
                        } else {
                            &mut minimum.u[1]
                        } = bad;
                    }
                    calls += 1;
                    Ok(())
                })
                .unwrap();
                assert!(
                    matches!(outcome, Outcome::SubproblemFailed(_)),
                    "{outcome:?}"
                );
                assert!(u.iter().all(|u| u.is_finite()), "{u:?}");
            }
        }
    }
}

#[test]
fn a_method_that_returns_another_length_is_an_error() {
    for length in [0, Springs::DOFS - 1, Springs::DOFS + 1] {
        let found = solve(&loaded(), |_, minimum| {
            minimum.u.resize(length, 0.0);
            Ok(())
        });
        match found.map(|_| ()) {
            Err(Error::Length {
                found, expected, ..
            }) => {
                assert_eq!((found, expected), (length, Springs::DOFS));
            }
            other => panic!("{other:?}"),
        }
    }
    let found = solve(&loaded(), |_, minimum| {
        minimum.lambda.push(1.0);
        Ok(())
    });
    let error = found.expect_err("there are no rows").to_string();
    assert!(error.contains('λ') && error.contains("length 1"), "{error}");
}

#[test]
fn bounds_of_another_length_are_named() {
    let mut problem = loaded();
    problem.bounds = Bounds::free(2);
    let error = solve(&problem, |_, _| Ok(())).expect_err("two bounds, three unknowns");
    assert!(error.to_string().contains("bounds"), "{error}");
    problem.bounds = Bounds::default();
    solve(&problem, |_, _| Ok(())).expect("no bounds are none");
}

fn run(
    problem: &mut Springs,
    spoil: impl FnMut(f64, &mut Minimum) -> Result<(), Error>,
) -> Result<Run, Error> {
    let start = State {
        u: vec![0.0; Springs::DOFS],
        ..State::default()
    };
    let steps = LoadSteps {
        increments: 4,
        ..LoadSteps::default()
    };
    let mut solver = FixedPoint::with(Halfway(spoil));
    steps.run(problem, &mut solver, start, |_| ControlFlow::Continue(()))
}

#[test]
fn an_error_keeps_the_steps_that_have_converged() {
    let refuses = |most: f64| {
        move |load: f64, _: &mut Minimum| match load > most {
            true => Err(Error::problem(std::fmt::Error)),
            false => Ok(()),
        }
    };
    let mut problem = Springs::new();
    let broken = run(&mut problem, refuses(0.6)).expect("two steps have converged");
    let Ending::Failed { at, why } = &broken.ending else {
        panic!("{:?}", broken.ending);
    };
    assert_eq!((*at, broken.factor, broken.attempts.len()), (0.5, 0.5, 2));
    assert_eq!(
        problem.load, 0.5,
        "the problem is at its last converged load"
    );
    assert!(broken.state.u.iter().all(|u| (u - 0.5).abs() < 1e-5));
    let error = broken.error.as_deref().expect("it is there as a value");
    assert!(matches!(error, Error::Problem(_)) && error.to_string() == *why);
    // nothing is lost where no step has converged
    assert!(matches!(
        run(&mut problem, refuses(0.1)),
        Err(Error::Problem(_))
    ));

    problem.refuses = 0.7;
    let broken = run(&mut problem, refuses(2.0)).expect("two steps have converged");
    assert!(matches!(broken.ending, Ending::Failed { at: 0.5, .. }));
    let whole = run(&mut Springs::new(), refuses(2.0)).unwrap();
    assert!(whole.ending == Ending::Complete && whole.error.is_none());
}

/// A solver of loads that fails as it is asked for the second one.
#[test]
fn an_error_of_any_way_to_solve_a_load_keeps_them_too() {
    struct Once(usize);
    impl Equilibrium for Once {
        fn solve(
            &mut self,
            problem: &dyn ContactProblem,
            start: State,
            context: &StepContext<'_>,
        ) -> Result<contact_core::equilibrium::Solution, Error> {
            self.0 += 1;
            match self.0 {
                1 => FixedPoint::with(Halfway(|_, _: &mut Minimum| Ok(())))
                    .solve(problem, start, context),
                _ => Err(Error::problem(std::fmt::Error)),
            }
        }
    }
    let start = State {
        u: vec![0.0; Springs::DOFS],
        ..State::default()
    };
    let steps = LoadSteps {
        increments: 2,
        stop: Stop::new(),
        ..LoadSteps::default()
    };
    let run = steps.run(&mut Springs::new(), &mut Once(0), start, |_| {
        ControlFlow::Continue(())
    });
    assert!(matches!(
        run.unwrap().ending,
        Ending::Failed { at: 0.5, .. }
    ));
}

#[test]
fn a_check_of_an_energy_passes_no_wrong_gradient() {
    let u = [0.3, -0.2, 0.1];
    let good = check::energy(&loaded(), &u, 1e-4);
    assert!(good.gradient < 1e-6 && good.hessian < 1e-6, "{good:?}");
    let wrong = Springs {
        factor: -777.0,
        ..loaded()
    };
    for (energy, h) in [
        (&wrong, 0.0),
        (&wrong, 1e-4),
        (&wrong, f64::NAN),
        (&loaded(), 0.0),
    ] {
        let found = check::energy(energy, &u, h);
        assert!(!(found.gradient < 1e-3), "{h}: {found:?}");
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let energy = Springs {
            factor: bad,
            ..loaded()
        };
        let found = check::energy(&energy, &u, 1e-4);
        assert!(
            !found.gradient.is_finite() && found.hessian.is_nan(),
            "{found:?}"
        );
        let energy = Springs {
            load: bad,
            ..loaded()
        };
        assert!(!check::energy(&energy, &u, 1e-4).gradient.is_finite());
    }
}

#[test]
fn a_check_of_a_problem_refuses_settings_that_find_nothing() {
    struct Line;
    impl Nlp for Line {
        fn objective(&mut self, x: &[f64], _: bool) -> f64 {
            x[0]
        }
        fn gradient(&mut self, _: &[f64], _: bool, gradient: &mut [f64]) {
            gradient[0] = 1.0;
        }
    }
    let structure = Structure::new(Bounds::free(1), Bounds::default(), Pattern::empty(), None);
    let structure = structure.unwrap();
    let usual = Differences::default();
    let find = |x: f64, differences| check::nlp(&mut Line, &structure, &[x], differences);
    assert_eq!(find(1.0, usual), Ok(Vec::new()));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let step = Differences { step: bad, ..usual };
        let tolerance = Differences {
            tolerance: bad,
            ..usual
        };
        for differences in [step, tolerance] {
            let found = find(1.0, differences);
            assert!(matches!(found, Err(NlpError::Value { .. })), "{found:?}");
        }
    }
    assert!(matches!(
        find(f64::NAN, usual),
        Err(NlpError::Value { what: "x", .. })
    ));
}
