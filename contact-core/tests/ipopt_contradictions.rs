//! What Ipopt calls a solution is compared with what the functions say at its point.
#![cfg(feature = "ipopt")]

use contact_core::{
    ipopt::{
        Contradiction, Options, Scaling, Sequence, SequenceSettings, Solution, Solver, Start,
        Status,
    },
    nlp::{Bounds, Nlp, Pattern, Structure},
};

/// min (x − 3)² subject to x² ≤ `4`; f and g may be other ones where they are asked for twice in a row at one x.
#[derive(Clone, Copy, Default)]
struct Drifting {
    /// What f loses then.
    f: f64,
    /// What g loses then.
    g: f64,
    last: [f64; 2],
}

impl Drifting {
    fn is_again(&mut self, function: usize, x: f64) -> f64 {
        let again = std::mem::replace(&mut self.last[function], x) == x;
        f64::from(u8::from(again))
    }
}

impl Nlp for Drifting {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (x[0] - 3.0).powi(2) - self.f * self.is_again(0, x[0])
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = 2.0 * (x[0] - 3.0);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = x[0] * x[0] - self.g * self.is_again(1, x[0]);
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values[0] = 2.0 * x[0];
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        values[0] = 2.0 * (sigma + lambda[0]);
    }
}

fn structure(most: f64) -> Structure {
    let constraints = Bounds::uniform(1, f64::NEG_INFINITY, most);
    let one = Pattern::diagonal(1);
    Structure::new(Bounds::free(1), constraints, one.clone(), Some(one)).expect("well formed")
}

fn solve(structure: Structure, mut nlp: Drifting) -> Solution {
    let mut solver = Solver::new(structure, &Options::new()).expect("the defaults are valid");
    solver
        .solve(&mut nlp, &Start::at(&[1.0]))
        .expect("no misuse")
}

fn contradiction(structure: Structure, nlp: Drifting) -> Contradiction {
    let solution = solve(structure, nlp);
    assert_eq!(solution.status, Status::Contradicted);
    assert!(!solution.status.is_acceptable() && solution.multipliers.is_none());
    assert!(!solution.history.is_empty() && solution.objective.is_finite());
    solution.contradiction.expect("it says why")
}

#[test]
fn a_solution_stays_one() {
    let solution = solve(structure(4.0), Drifting::default());
    assert_eq!(
        (solution.status, solution.contradiction),
        (Status::Solved, None)
    );
    assert!((solution.x[0] - 2.0).abs() < 1e-6);
}

#[test]
fn functions_that_depend_on_more_than_x() {
    let falls = Drifting {
        f: 1.0,
        ..Drifting::default()
    };
    match contradiction(structure(100.0), falls) {
        Contradiction::Objective { value, returned } => assert!(value < returned),
        other => panic!("{other}"),
    }
    let falls = Drifting {
        g: 1.0,
        ..Drifting::default()
    };
    match contradiction(structure(100.0), falls) {
        Contradiction::Constraint {
            index: 0,
            value,
            returned,
        } => assert!(value < returned),
        other => panic!("{other}"),
    }
}

/// The multiplier belongs to the derivative at the start, 2: ∂L/∂x is −2 + 1 · 4 at the solution.
#[test]
fn a_derivative_that_is_not_constant_as_promised() {
    let promised = structure(4.0).with_constant_jacobian(true);
    match contradiction(promised.clone(), Drifting::default()) {
        Contradiction::Lagrangian {
            index: 0,
            value,
            allowed,
        } => assert!((value - 2.0).abs() < 1e-3 && allowed == 1.0),
        other => panic!("{other}"),
    }
    let mut sequence = Sequence::new(promised, SequenceSettings::default(), &[1.0]).unwrap();
    let run = sequence.solve(&mut Drifting::default()).unwrap();
    assert!(!run.solved, "it does not count as solved");
    assert_eq!(run.solution.status, Status::Contradicted);
}

/// min (x − 1)² subject to 0 ≤ `slope` g ≤ `most`, where g is x or x²: at x = 1 no constraint acts.
struct Steep {
    slope: f64,
    power: i32,
}

impl Nlp for Steep {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (x[0] - 1.0).powi(2)
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = 2.0 * (x[0] - 1.0);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g[0] = self.slope * x[0].powi(self.power);
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values[0] = self.slope * f64::from(self.power) * x[0].powi(self.power - 1);
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        let of_g = if self.power == 2 {
            2.0 * self.slope
        } else {
            0.0
        };
        values[0] = 2.0 * sigma + lambda[0] * of_g;
    }
}

fn steep(most: f64) -> Structure {
    let (x, g) = (Bounds::uniform(1, -9.0, 9.0), Bounds::uniform(1, 0.0, most));
    let one = Pattern::diagonal(1);
    Structure::new(x, g, one.clone(), Some(one)).expect("well formed")
}

/// Where slopes of 1e30 lead Ipopt astray, its solution is not taken for one. Which wrong point it returns, if any, is its own.
#[test]
fn multipliers_of_bounds_that_are_far_off() {
    for slope in [1.0, 1e3, 1e30, 1e100, 1e153] {
        let nlp = Steep { slope, power: 1 };
        let mut solver = Solver::new(steep(2.0 * slope), &Options::new()).expect("valid");
        let mut nlp = nlp;
        let solution = solver.solve(&mut nlp, &Start::at(&[3.0]));
        let solution = solution.expect("no misuse");
        let is_right = (solution.x[0] - 1.0).abs() < 1e-6;
        assert!(
            is_right || !solution.status.is_acceptable(),
            "{slope}: {} {:?}",
            solution.x[0],
            solution.status
        );
        assert!(is_right || slope > 1e19, "{slope}: {}", solution.x[0]);
    }
}

/// Factors that take values to infinity end a solve; others that lead astray are found.
#[test]
fn factors_that_overflow() {
    let scaled = |g: f64, x: f64| {
        let mut solver = Solver::new(steep(4.0), &Options::new()).expect("valid");
        let scaling = Scaling {
            objective: 1.0,
            variables: Some(vec![x]),
            constraints: Some(vec![g]),
        };
        solver.set_scaling(&scaling).expect("finite and positive");
        let mut nlp = Steep {
            slope: 1.0,
            power: 2,
        };
        let solution = solver.solve(&mut nlp, &Start::at(&[3.0]));
        solution.expect("no misuse")
    };
    for (g, x) in [
        (1e308, 1.0),
        (1e200, 1.0),
        (1e154, 1e-154),
        (1e290, 1e-20),
        (1e110, 1e-200),
        (1.0, 1e-308),
    ] {
        let solution = scaled(g, x);
        let is_right = (solution.x[0] - 1.0).abs() < 1e-6;
        assert!(
            is_right || !solution.status.is_acceptable(),
            "{g} {x}: {} {:?}",
            solution.x[0],
            solution.status
        );
    }
    let sound = scaled(1e2, 1e-2);
    assert_eq!(sound.status, Status::Solved);
    assert!((sound.x[0] - 1.0).abs() < 1e-6);
}
