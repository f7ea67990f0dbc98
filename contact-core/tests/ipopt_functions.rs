//! What a problem has to implement, and what its functions find.
#![cfg(feature = "ipopt")]

use std::panic::{AssertUnwindSafe, catch_unwind};

use contact_core::{
    check,
    ipopt::{Options, Solver, Start, Status},
    nlp::{Bounds, Nlp, Pattern, Structure},
};

use problems::*;

/// min Σ (xᵢ − 1)², by its gradient alone.
struct Sphere;

impl Nlp for Sphere {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        x.iter().map(|x| (x - 1.0).powi(2)).sum()
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        let terms = gradient.iter_mut().zip(x);
        terms.for_each(|(value, x)| *value += 2.0 * (x - 1.0));
    }
}

fn free(constraints: usize, jacobian: Pattern, hessian: Option<Pattern>) -> Solver {
    let limits = Bounds::uniform(constraints, 0.0, 1.0);
    let structure = Structure::new(Bounds::free(3), limits, jacobian, hessian);
    Solver::new(structure.expect("well formed"), &Options::new()).expect("valid")
}

#[test]
fn objective_and_gradient_are_enough() {
    let mut solver = free(0, Pattern::empty(), None);
    let solution = solver.solve(&mut Sphere, &Start::at(&[4.0; 3])).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_close(&solution.x, &[1.0; 3], 1e-8);
    let structure = solver.structure().clone();
    let findings = check::nlp(
        &mut Sphere,
        &structure,
        &[4.0; 3],
        check::Differences::default(),
    );
    assert_eq!(findings, Ok(Vec::new()));
}

/// The message of the panic that a solve ends with.
fn missing(mut solver: Solver) -> String {
    let solve = AssertUnwindSafe(|| solver.solve(&mut Sphere, &Start::at(&[4.0; 3])));
    let payload = catch_unwind(solve).expect_err("a function is missing");
    payload.downcast_ref::<String>().expect("a text").clone()
}

#[test]
fn a_function_that_is_missing_is_named() {
    let message = missing(free(0, Pattern::empty(), Some(Pattern::diagonal(3))));
    assert!(
        message.contains("3 entries of the Hessian: implement `Nlp::hessian`"),
        "{message}"
    );
    assert!(message.contains("`None`"), "{message}");
    let message = missing(free(2, Pattern::empty(), None));
    assert!(
        message.contains("2 constraints: implement `Nlp::constraints`"),
        "{message}"
    );

    /// With constraints.
    struct Constrained;
    impl Nlp for Constrained {
        fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
            Sphere.objective(x, new_x)
        }
        fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
            Sphere.gradient(x, new_x, gradient);
        }
        fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
            g.copy_from_slice(&x[..2]);
        }
    }
    let mut solver = free(2, Pattern::dense(2, 3), None);
    let solve = AssertUnwindSafe(|| solver.solve(&mut Constrained, &Start::at(&[4.0; 3])));
    let payload = catch_unwind(solve).expect_err("the Jacobian is missing");
    let message = payload.downcast_ref::<String>().expect("a text");
    assert!(
        message.contains("6 entries of the Jacobian: implement `Nlp::jacobian`"),
        "{message}"
    );
}

/// HS071, whose functions want to find zeros, and leave none.
struct Zeros;

impl Zeros {
    fn check(values: &[f64]) {
        assert!(values.iter().all(|value| *value == 0.0), "{values:?}");
    }
}

impl Nlp for Zeros {
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64 {
        Hs071.objective(x, new_x)
    }
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]) {
        Self::check(gradient);
        Hs071.gradient(x, new_x, gradient);
    }
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        Self::check(g);
        Hs071.constraints(x, new_x, g);
    }
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        Self::check(values);
        Hs071.jacobian(x, new_x, values);
    }
    fn hessian(&mut self, x: &[f64], new_x: bool, sigma: f64, l: &[f64], values: &mut [f64]) {
        Self::check(values);
        Hs071.hessian(x, new_x, sigma, l, values);
    }
}

#[test]
fn outputs_arrive_filled_with_zeros() {
    let mut solver = hs071_solver!();
    for _ in 0..2 {
        let solution = solver.solve(&mut Zeros, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.status, Status::Solved);
    }
    let differences = check::Differences::default();
    let findings = check::nlp(&mut Zeros, &hs071_structure(), &[1.5; 4], differences);
    assert_eq!(findings, Ok(Vec::new()));
}
