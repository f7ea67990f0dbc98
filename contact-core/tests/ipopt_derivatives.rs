//! Planted errors in derivatives, found by Ipopt's checker and by the one that needs no Ipopt.
#![cfg(feature = "ipopt")]

use contact_core::{
    check::{self, Derivative, Differences, Finding},
    ipopt::{DerivativeCheck, DerivativeTest, Options, Solver, Start, Status},
    nlp::{Bounds, Nlp, Pattern, Structure},
};
use problems::*;

/// HS071 with something added to one derivative, or with the entry ∂g₀/∂x₂ left out of the Jacobian.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    Gradient,
    Jacobian,
    Pattern,
    ObjectiveHessian,
    ConstraintHessian,
}

const ADDED: f64 = 0.75;
const MISSING: (usize, usize) = (0, 2);

impl Planted {
    fn jacobian_pattern(self) -> Pattern {
        let entries = Pattern::dense(2, 4);
        let kept = entries
            .iter()
            .filter(|&entry| self != Self::Pattern || entry != MISSING);
        kept.collect()
    }

    fn structure(self) -> Structure {
        let right = hs071_structure();
        Structure::new(
            right.variable_bounds().clone(),
            right.constraint_bounds().clone(),
            self.jacobian_pattern(),
            right.hessian().cloned(),
        )
        .unwrap()
    }
}

impl Nlp for Planted {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        Hs071.objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        Hs071.gradient(x, new_x, gradient);
        if *self == Self::Gradient {
            gradient[2] += ADDED;
        }
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        Hs071.constraints(x, new_x, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        let mut all = [0.0; 8];
        Hs071.jacobian(x, new_x, &mut all);
        for ((row, col), value) in self.jacobian_pattern().iter().zip(values) {
            *value = all[4 * row + col];
            if *self == Self::Jacobian && (row, col) == (1, 3) {
                *value += ADDED;
            }
        }
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, lambda: &[f64], values: &mut [f64]) {
        Hs071.hessian(x, new_x, sigma, lambda, values);
        for ((row, col), value) in Pattern::dense_lower(4).iter().zip(values) {
            match self {
                Self::ObjectiveHessian if (row, col) == (3, 1) => *value += ADDED * sigma,
                Self::ConstraintHessian if (row, col) == (2, 2) => *value += ADDED * lambda[1],
                _ => {}
            }
        }
    }
}

/// At the start itself, in silence, without solving.
fn ipopt(mut problem: Planted, test: DerivativeTest) -> DerivativeCheck {
    let options = Options::new()
        .derivative_test(test)
        .point_perturbation_radius(0.0)
        .max_iter(0);
    let mut solver = Solver::new(problem.structure(), &options).unwrap();
    let start = Start::at(&HS071_START);
    let solution = solver.solve(&mut problem, &start).unwrap();
    let check = solution.derivative_check.unwrap();
    assert_eq!(check.announced, Some(check.findings.len()), "{check:?}");
    assert_eq!(check.unparsed, 0);
    check
}

fn own(mut problem: Planted) -> Vec<Finding> {
    let structure = problem.structure();
    check::nlp(
        &mut problem,
        &structure,
        &HS071_START,
        Differences::default(),
    )
    .unwrap()
}

/// What is wrong, what is given there and what is right; from the formulas of HS071 at (1, 5, 5, 1).
fn expected(planted: Planted) -> Vec<(Derivative, f64, f64)> {
    let objective = |row, col| Derivative::ObjectiveHessian {
        row,
        col,
        in_pattern: true,
    };
    match planted {
        Planted::Nothing => vec![],
        // ∂f/∂x₂ = x₀x₃ + 1
        Planted::Gradient => vec![(Derivative::Gradient(2), 2.0 + ADDED, 2.0)],
        Planted::Jacobian => {
            let which = Derivative::Jacobian {
                row: 1,
                col: 3,
                in_pattern: true,
            };
            vec![(which, 2.0 + ADDED, 2.0)]
        }
        // ∂g₀/∂x₂ = x₀x₁x₃
        Planted::Pattern => {
            let which = Derivative::Jacobian {
                row: 0,
                col: 2,
                in_pattern: false,
            };
            vec![(which, 0.0, 5.0)]
        }
        // ∂²f/∂x₁∂x₃ = x₀, twice
        Planted::ObjectiveHessian => vec![
            (objective(1, 3), 1.0 + ADDED, 1.0),
            (objective(3, 1), 1.0 + ADDED, 1.0),
        ],
        Planted::ConstraintHessian => {
            let which = Derivative::ConstraintHessian {
                constraint: 1,
                row: 2,
                col: 2,
                in_pattern: true,
            };
            vec![(which, 2.0 + ADDED, 2.0)]
        }
    }
}

#[track_caller]
fn assert_found(findings: &[Finding], expected: &[(Derivative, f64, f64)]) {
    assert_eq!(findings.len(), expected.len(), "{findings:?}");
    for (finding, &(which, given, right)) in findings.iter().zip(expected) {
        assert_eq!(finding.which, which);
        assert!((finding.given - given).abs() < 1e-12, "{finding:?}");
        assert!((finding.estimated - right).abs() < 1e-5, "{finding:?}");
        let error = (given - right).abs() / right.abs().max(1.0);
        assert!((finding.relative_error - error).abs() < 1e-3, "{finding:?}");
    }
}

#[test]
fn planted_errors_are_found_with_and_without_ipopt() {
    for planted in [
        Planted::Nothing,
        Planted::Gradient,
        Planted::Jacobian,
        Planted::ObjectiveHessian,
        Planted::ConstraintHessian,
    ] {
        let theirs = ipopt(planted, DerivativeTest::SecondOrder);
        assert_found(&theirs.findings, &expected(planted));
        assert_found(&own(planted), &expected(planted));
        assert_eq!(theirs.is_clean(), planted == Planted::Nothing);
    }
}

/// Without ∂g₀/∂x₂ the second derivatives of g₀ in x₂ cannot be estimated either: first the missing place, then those.
#[test]
fn a_place_missing_in_the_pattern_is_found_with_and_without_ipopt() {
    let first = ipopt(Planted::Pattern, DerivativeTest::FirstOrder);
    assert_found(&first.findings, &expected(Planted::Pattern));
    let theirs = ipopt(Planted::Pattern, DerivativeTest::SecondOrder).findings;
    let own = own(Planted::Pattern);
    assert_found(&own[..1], &expected(Planted::Pattern));
    let which = |findings: &[Finding]| findings.iter().map(|f| f.which).collect::<Vec<_>>();
    assert_eq!(which(&own), which(&theirs));
    assert!(own.len() > 1 && own[1..].iter().all(|f| f.estimated.abs() < 1e-5));
    assert!(own[0].to_string().contains("not in the pattern"));
}

#[test]
fn the_test_takes_place_near_the_start_and_the_solve_goes_on() {
    let options = Options::new().derivative_test(DerivativeTest::SecondOrder);
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.derivative_check.unwrap().is_clean());
    // Printing all of them makes no findings of the right ones.
    let all = options.derivative_test_print_all(true);
    solver.set_options(&all).unwrap();
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert!(solution.derivative_check.unwrap().is_clean());
    for options in [
        Options::new(),
        Options::new().derivative_test(DerivativeTest::None),
    ] {
        solver.set_options(&options).unwrap();
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.derivative_check, None);
    }
}

/// √(1 − x), which is nothing above 1.
struct Root;

impl Nlp for Root {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (1.0 - x[0]).sqrt()
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient[0] = -0.5 / (1.0 - x[0]).sqrt();
    }
    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values[0] = -0.25 * sigma * (1.0 - x[0]).powf(-1.5);
    }
}

#[test]
fn a_check_that_cannot_end_is_not_clean() {
    let structure = Separable::structure(Bounds::free(1));
    let at = [1.0 - 1e-9];
    let options = Options::new()
        .derivative_test(DerivativeTest::FirstOrder)
        .point_perturbation_radius(0.0)
        .max_iter(0);
    let mut solver = Solver::new(structure.clone(), &options).unwrap();
    let solution = solver.solve(&mut Root, &Start::at(&at)).unwrap();
    assert_eq!(solution.status, Status::UnrecoverableException);
    let check = solution.derivative_check.unwrap();
    assert_eq!(check.announced, None, "{check:?}");
    assert!(!check.is_clean());
    let findings = check::nlp(&mut Root, &structure, &at, Differences::default()).unwrap();
    assert!(findings[0].estimated.is_nan(), "{findings:?}");
    assert!(check::nlp(&mut Root, &structure, &[], Differences::default()).is_err());
}
