//! The fixed point without any finite elements: whoever states a `ContactProblem` gets it.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;

use contact_core::equilibrium::StepContext;
use contact_core::gaps::{LinearGaps, Row, RowKey, Sampling};
use contact_core::linear::SymmetricPattern;
use contact_core::method::{Continuation, Method, Minimum, PenalizedSlack, Penalty, Subproblem};
use contact_core::nlp::Bounds;
use contact_core::{
    Acceleration, Automatic, ContactProblem, Ending, Energy, Equilibrium, Error, FixedPoint,
    InteriorPoint, LoadStepped, LoadSteps, Outcome, Retry, Scale, Solved, State, Stop,
};

/// E(u) = ½ k |u|² − t f·u with load factor t for one point in the plane, outside the unit disc around (0, −1).
struct Point {
    factor: f64,
    force: [f64; 2],
    stiffness: f64,
    pattern: SymmetricPattern,
    bounds: Bounds,
    linearizations: Cell<usize>,
}

impl Point {
    fn pulled(force: [f64; 2]) -> Self {
        Point {
            factor: 1.0,
            force,
            stiffness: 1.0,
            pattern: SymmetricPattern::diagonal(2),
            bounds: Bounds::free(2),
            linearizations: Cell::new(0),
        }
    }
}

const CENTRE: [f64; 2] = [0.0, -1.5];

impl Energy for Point {
    fn dofs(&self) -> usize {
        2
    }
    fn value(&self, u: &[f64]) -> f64 {
        0.5 * self.stiffness * (u[0] * u[0] + u[1] * u[1])
            - self.factor * (self.force[0] * u[0] + self.force[1] * u[1])
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        for i in 0..2 {
            g[i] = self.stiffness * u[i] - self.factor * self.force[i];
        }
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.fill(self.stiffness);
    }
    fn is_quadratic(&self) -> bool {
        true
    }
}

impl ContactProblem for Point {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    /// g(u) = (u − x̄)·n with x̄ the closest point of the circle, frozen.
    fn linearize_gaps(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        self.linearizations.set(self.linearizations.get() + 1);
        let d = [u[0] - CENTRE[0], u[1] - CENTRE[1]];
        let r = d[0].hypot(d[1]);
        let n = [d[0] / r, d[1] / r];
        let mut gaps = LinearGaps::new(false);
        gaps.push(
            RowKey { pass: 0, node: 0 },
            &Row {
                free: vec![(0, n[0]), (1, n[1])],
                prescribed: vec![],
                constant: -(CENTRE[0] * n[0] + CENTRE[1] * n[1]) - 1.0,
                weight: 1.0,
            },
        );
        Ok(gaps)
    }
    fn scale(&self) -> Option<Scale> {
        Some(Scale::default())
    }
}

impl LoadStepped for Point {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.factor = factor;
        Ok(())
    }
}

/// Pulled by f, the point ends where k u − f = λ n on the circle: on the ray from the centre
/// through f/k, at distance 1.
fn exact(force: [f64; 2]) -> ([f64; 2], f64) {
    let d = [force[0] - CENTRE[0], force[1] - CENTRE[1]];
    let r = d[0].hypot(d[1]);
    let u = [CENTRE[0] + d[0] / r, CENTRE[1] + d[1] / r];
    (u, 1.0 - r)
}

/// Newton's method does not treat bounds: the default solver gives such problems to Ipopt. The point ends where the circle
/// meets its bound.
#[test]
fn a_point_on_a_circle_with_a_bound() {
    let mut problem = Point::pulled([0.6, -1.3]);
    problem.bounds.upper[0] = 0.1;
    let mut solver = Automatic::with_tolerance(1e-9);
    assert_eq!(solver.choice(&problem).solver, "ipopt");
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let solution = solver.solve_from(&problem, start).expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!(
        solution
            .history
            .iter()
            .all(|iteration| iteration.solver == "ipopt")
    );
    let expected = [0.1, CENTRE[1] + (1.0_f64 - 0.01).sqrt()];
    for (u, expected) in solution.state.u.iter().zip(expected) {
        assert!((u - expected).abs() < 1e-7, "{u} for {expected}");
    }
}

#[test]
fn a_point_on_a_circle() {
    let force = [0.6, -1.3];
    for acceleration in [Acceleration::Plain, Acceleration::Anderson(3)] {
        let problem = Point::pulled(force);
        let mut fixed_point = FixedPoint {
            tolerance: 1e-9,
            acceleration,
            ..FixedPoint::with(InteriorPoint::default())
        };
        let start = State {
            u: vec![0.0; 2],
            ..State::default()
        };
        let solution = fixed_point.solve_from(&problem, start).expect("no misuse");
        assert_eq!(solution.outcome, Outcome::Converged, "{acceleration:?}");
        let (u, lambda) = exact(force);
        assert!(
            (solution.state.u[0] - u[0]).abs() < 1e-8,
            "{:?} {u:?}",
            solution.state.u
        );
        assert!((solution.state.u[1] - u[1]).abs() < 1e-8);
        assert!(
            (solution.lambda[0] - lambda).abs() < 1e-7,
            "λ {:?}",
            solution.lambda
        );
        assert_eq!(problem.linearizations.get(), solution.history.len());
    }
}

/// A method that notes what accuracy it is asked for.
#[derive(Default)]
struct Watched {
    method: InteriorPoint,
    asked: Vec<f64>,
}

impl Method for Watched {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        self.asked.push(subproblem.accuracy);
        self.method.minimize(subproblem, start)
    }
}

/// Two solves are rough, the second in proportion to the change that the first one made; the paper's
/// plain iteration has none, and none is the last, even of a point that is where it belongs from the
/// start on or where few iterations are allowed.
#[test]
fn the_last_solve_is_never_rough() {
    let force = [0.6, -1.3];
    let start = |u: [f64; 2]| State {
        u: u.to_vec(),
        ..State::default()
    };
    let asked = |acceleration, max_iterations, u| {
        let mut fixed_point = FixedPoint {
            method: Watched::default(),
            tolerance: 1e-9,
            acceleration,
            max_iterations,
        };
        let problem = Point::pulled(force);
        let solution = fixed_point.solve_from(&problem, start(u));
        let solution = solution.expect("no misuse");
        let asked = fixed_point.method.asked;
        assert_eq!(asked.len(), solution.history.len());
        (asked, solution)
    };
    let anderson = Acceleration::Anderson(3);
    let (end, _) = exact(force);

    let (accuracies, solution) = asked(anderson, 30, [0.0; 2]);
    let change = solution.history[0].error;
    assert!(accuracies[0] > 0.0 && accuracies[0] <= 1e-8);
    assert!(accuracies[1] > 0.0 && accuracies[1] <= 1e-6 * change);
    assert!(accuracies[2..].iter().all(|a| *a == 0.0) && accuracies.len() > 2);

    let (accuracies, _) = asked(Acceleration::Plain, 30, [0.0; 2]);
    assert!(accuracies.iter().all(|a| *a == 0.0));

    let (accuracies, solution) = asked(anderson, 30, end);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_eq!(accuracies.last(), Some(&0.0));

    for most in [1, 2] {
        let (accuracies, _) = asked(anderson, most, end);
        assert_eq!(accuracies.last(), Some(&0.0), "{most} allowed");
    }
}

/// With a penalty μ η(s) the point goes a depth t into the disc at which 3 μ t² = λ, on the same
/// ray: 3 μ t² + t = t₀ for a spring of stiffness 1 that would bring it t₀ deep.
#[test]
fn a_point_pressed_into_a_circle() {
    let force = [0.6, -1.3];
    let (_, lambda) = exact(force);
    for mu in [1.0, 1e3, 1e6, 1e9, 1e12] {
        let slack = PenalizedSlack::with(Continuation::fixed(mu));
        let penalty = Penalty::with(Continuation::fixed(mu));
        let methods: [Box<dyn Method>; 2] = [Box::new(slack), Box::new(penalty)];
        for method in methods {
            let mut fixed_point = FixedPoint {
                tolerance: 1e-10,
                ..FixedPoint::with(method)
            };
            let start = State {
                u: vec![0.0; 2],
                ..State::default()
            };
            let problem = Point::pulled(force);
            let solution = fixed_point.solve_from(&problem, start);
            let solution = solution.expect("no misuse");
            assert_eq!(solution.outcome, Outcome::Converged, "μ = {mu}");
            let depth = 2.0 * lambda / (1.0 + (1.0 + 12.0 * mu * lambda).sqrt());
            let d = [0, 1].map(|i| solution.state.u[i] - CENTRE[i]);
            let found = 1.0 - d[0].hypot(d[1]);
            assert!((found - depth).abs() < 1e-9, "μ = {mu}: {found} {depth}");
            let balance = 3.0 * mu * depth * depth;
            assert!((solution.lambda[0] - balance).abs() < 1e-8, "μ = {mu}");
            let u = &solution.state.u;
            assert!(
                (solution.energy - problem.value(u)).abs() < 1e-12,
                "without penalty"
            );
        }
    }
}

/// Continuation goes on until the penetration is small; where μ may not grow so far it says so.
#[test]
fn a_penalty_grows_until_it_holds() {
    let problem = Point::pulled([0.6, -1.3]);
    let solve = |continuation: Continuation| {
        let start = State {
            u: vec![0.0; 2],
            ..State::default()
        };
        FixedPoint::with(PenalizedSlack::with(continuation)).solve_from(&problem, start)
    };
    let solution = solve(Continuation::default()).expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Converged);
    let mut c = [0.0];
    solution.gaps.value(&solution.state.u, &mut c);
    assert!(c[0] < 0.0 && c[0] > -1e-3, "{c:?}");
    let weak = Continuation {
        limit: 10.0,
        ..Continuation::default()
    };
    let outcome = solve(weak).expect("no misuse").outcome;
    let Outcome::SubproblemFailed(why) = outcome else {
        panic!("{outcome}")
    };
    assert!(why.contains("penetration"), "{why}");
    for bad in [
        Continuation::fixed(0.0),
        Continuation::fixed(f64::NAN),
        Continuation {
            growth: 1.0,
            ..Continuation::default()
        },
        Continuation {
            penetration: -1.0,
            ..Continuation::default()
        },
    ] {
        assert!(solve(bad).is_err(), "{bad:?}");
    }
}

#[test]
fn an_open_gap_costs_nothing() {
    let problem = Point::pulled([0.1, 0.2]);
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let solution = FixedPoint::with(InteriorPoint::default())
        .solve_from(&problem, start)
        .expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!((solution.state.u[0] - 0.1).abs() < 1e-8 && (solution.state.u[1] - 0.2).abs() < 1e-8);
    assert!(solution.lambda[0].abs() < 1e-8);
}

/// A method that stands still and says that it failed: the error test alone would call it converged.
struct Stuck(Solved);

impl Method for Stuck {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        Ok(Minimum {
            u: start.u.clone(),
            lambda: vec![0.0; subproblem.gaps.len()],
            energy: subproblem.energy.value(&start.u),
            solved: self.0.clone(),
            cost: Default::default(),
        })
    }
}

#[test]
fn a_subproblem_that_was_not_solved_never_counts_as_converged() {
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let cases = [
        (
            Solved::Failed("restoration failed".into()),
            "restoration failed",
        ),
        (Solved::Interrupted, "interrupted"),
    ];
    for (solved, word) in cases {
        let problem = Point::pulled([0.6, -1.3]);
        let solution = FixedPoint::with(Stuck(solved))
            .solve_from(&problem, start.clone())
            .expect("no misuse");
        assert_ne!(solution.outcome, Outcome::Converged);
        assert!(solution.outcome.to_string().contains(word));
        assert_eq!(solution.history.len(), 1);
        assert_eq!(solution.history[0].error, f64::INFINITY);
    }
}

/// A method that calls anything a minimum.
struct Careless {
    u: f64,
    energy: f64,
}

impl Method for Careless {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, _: &State) -> Result<Minimum, Error> {
        Ok(Minimum {
            u: vec![self.u; 2],
            lambda: vec![0.0; subproblem.gaps.len()],
            energy: self.energy,
            solved: Solved::Optimal,
            cost: Default::default(),
        })
    }
}

/// Values that are not finite are no solution, and a NaN is no change of zero.
#[test]
fn a_minimum_that_is_not_finite_is_a_failure() {
    for (u, energy) in [(f64::NAN, 0.0), (0.5, f64::NAN), (f64::INFINITY, 0.0)] {
        let start = State {
            u: vec![0.0; 2],
            ..State::default()
        };
        let problem = Point::pulled([0.6, -1.3]);
        let solution = FixedPoint::with(Careless { u, energy }).solve_from(&problem, start);
        let outcome = solution.expect("no misuse").outcome;
        assert!(outcome.to_string().contains("not finite"), "{outcome}");
    }
}

/// A method that does not look at the request to stop is stopped after its solve.
#[test]
fn a_request_to_stop_ends_the_iteration() {
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let (stop, problem) = (Stop::new(), Point::pulled([0.6, -1.3]));
    let (again, lifted) = (start.clone(), || start.clone());
    let context = StepContext::single(&again, &lifted, &stop);
    for iterations in [1, 0] {
        let method = Flip(1e-3, stop.clone());
        let solution = FixedPoint::with(method).solve(&problem, start.clone(), &context);
        let solution = solution.expect("no misuse");
        assert_eq!(solution.outcome, Outcome::Interrupted);
        assert_eq!(solution.history.len(), iterations);
    }
}

/// A method that jumps between two points, and requests a stop.
struct Flip(f64, Stop);

impl Method for Flip {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, _: &State) -> Result<Minimum, Error> {
        self.0 = -self.0;
        self.1.request();
        Ok(Minimum {
            u: vec![1.0 + self.0, 0.0],
            lambda: vec![0.0; subproblem.gaps.len()],
            energy: 0.0,
            solved: Solved::Optimal,
            cost: Default::default(),
        })
    }
}

#[test]
fn cycles_are_recognised() {
    let mut fixed_point = FixedPoint {
        acceleration: Acceleration::Plain,
        ..FixedPoint::with(Flip(1e-3, Stop::new()))
    };
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let problem = Point::pulled([0.6, -1.3]);
    let solution = fixed_point.solve_from(&problem, start).expect("no misuse");
    let Outcome::Cycle {
        period: 2,
        amplitude,
    } = solution.outcome
    else {
        panic!("a 2-cycle, not {}", solution.outcome)
    };
    assert!((amplitude - 2e-3 / 1.001).abs() < 1e-12, "{amplitude}");
}

#[test]
fn starts_are_checked() {
    let problem = Point::pulled([0.6, -1.3]);
    for u in [vec![0.0; 3], vec![0.0, f64::NAN]] {
        let start = State {
            u,
            ..State::default()
        };
        let solution = FixedPoint::with(Stuck(Solved::Optimal)).solve_from(&problem, start);
        assert!(solution.is_err());
    }
}

/// The interior point method, but the first few calls fail.
struct Reluctant {
    failures: usize,
    method: InteriorPoint,
}

impl Method for Reluctant {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let mut minimum = self.method.minimize(subproblem, start)?;
        if self.failures > 0 {
            self.failures -= 1;
            minimum.solved = Solved::Failed("reluctant".into());
        }
        Ok(minimum)
    }
}

fn reluctant_run(failures: usize, max_halvings: usize) -> contact_core::load_steps::Run {
    let settings = LoadSteps {
        increments: 2,
        max_halvings,
        ..LoadSteps::default()
    };
    let start = State {
        u: vec![0.0; 2],
        ..State::default()
    };
    let mut solver = Retry::with(Reluctant {
        failures,
        method: InteriorPoint::default(),
    });
    let mut problem = Point::pulled([0.6, -1.3]);
    settings
        .run(&mut problem, &mut solver, start, |_| {
            ControlFlow::Continue(())
        })
        .expect("no misuse")
}

#[test]
fn steps_are_halved_and_grow_back() {
    let run = reluctant_run(2, 6);
    assert_eq!(run.ending, Ending::Complete);
    assert_eq!(run.cuts(), 2);
    let goals: Vec<f64> = run.attempts.iter().map(|attempt| attempt.to).collect();
    assert_eq!(goals, [0.5, 0.25, 0.125, 0.375, 0.5, 1.0]);
    let (u, _) = exact([0.6, -1.3]);
    assert!((run.state.u[0] - u[0]).abs() < 1e-6 && (run.state.u[1] - u[1]).abs() < 1e-6);
}

#[test]
fn a_run_that_gives_up_says_where_and_why() {
    let run = reluctant_run(usize::MAX, 3);
    let Ending::NotConverged { at, why, .. } = &run.ending else {
        panic!("not {:?}", run.ending)
    };
    assert_eq!(*at, 0.0);
    assert_eq!(*why, Outcome::SubproblemFailed("reluctant".into()));
    let goals: Vec<f64> = run.attempts.iter().map(|attempt| attempt.to).collect();
    assert_eq!(goals, [0.5, 0.25, 0.125, 0.0625]);
    assert!(run.solution.is_none());
}

/// E(u) = 1000 u − ln(1 + u) with domain 1 + u > 0, which remembers where its gradient was asked.
struct Cliff {
    pattern: SymmetricPattern,
    bounds: Bounds,
    accepted: RefCell<Vec<f64>>,
}

impl Energy for Cliff {
    fn dofs(&self) -> usize {
        1
    }
    fn value(&self, u: &[f64]) -> f64 {
        match u[0] > -1.0 {
            true => 1000.0 * u[0] - (1.0 + u[0]).ln(),
            false => f64::INFINITY,
        }
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.accepted.borrow_mut().push(1.0 + u[0]);
        g[0] = 1000.0 - 1.0 / (1.0 + u[0]);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        values[0] = (1.0 + u[0]).powi(-2);
    }
    fn domain_len(&self) -> usize {
        1
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        d[0] = 1.0 + u[0];
    }
}

impl ContactProblem for Cliff {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(LinearGaps::new(true))
    }
}

/// The J guard: no accepted step takes the domain function below a tenth of its last value.
#[test]
fn nothing_collapses_in_one_step() {
    let problem = Cliff {
        pattern: SymmetricPattern::diagonal(1),
        bounds: Bounds::free(1),
        accepted: RefCell::default(),
    };
    let start = State {
        u: vec![30.0],
        ..State::default()
    };
    let solution = FixedPoint::with(InteriorPoint::default())
        .solve_from(&problem, start)
        .expect("no misuse");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!(
        (solution.state.u[0] + 0.999).abs() < 1e-9,
        "{:?}",
        solution.state.u
    );
    let accepted = problem.accepted.borrow();
    assert!(accepted[0] > 30.0 && accepted.len() > 5, "{accepted:?}");
    for pair in accepted.windows(2) {
        assert!(pair[1] >= 0.1 * pair[0], "{accepted:?}");
    }
}
