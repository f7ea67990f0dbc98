//! How much is added to K until it is positive definite, and what the next S knows of it; when a step is the last.

use super::super::linearization::Linearization;
use super::super::tangent::Tangent;
use super::*;
use crate::Cost;

/// [[1, off], [off, 1]], with the eigenvalues 1 ± off.
fn coupled(off: f64) -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[1.0, off, off, 1.0])
}

/// Prepares an S at 0 where the rows, if there are any, have the force 1. Returns the number of factorisations.
fn prepare(tangent: &mut Tangent, toy: &Toy) -> usize {
    let forces = vec![1.0; (toy.rows)(&[0.0; 2]).len()];
    let start = with_multipliers(toy, &[0.0; 2], &forces);
    let (stop, mut cost) = (Stop::default(), Cost::default());
    let mut at = Point {
        gaps: LinearGaps::new(false),
        slips: Slips::default(),
        lambda: Vec::new(),
        state: start.clone(),
    };
    let lifted = || start.clone();
    let context = StepContext::single(&start, &lifted, &stop);
    at.project(toy, &context).expect("rows");
    let here = Linearization::new(toy, &at, true, &stop, &mut cost);
    let here = here.expect("finite derivatives");
    tangent.forget();
    tangent
        .prepare(&here, 0.0, &stop, &mut cost)
        .expect("a positive definite S");
    cost.factorizations
}

#[test]
fn a_shift_makes_s_positive_definite_and_is_remembered() {
    // 1 + shift must exceed the coupling: 24 does for 3, and .81 for 1.5
    let (strongly, weakly) = (
        Toy::quadratic(&coupled(3.0), &[0.0; 2], &[]),
        Toy::quadratic(&coupled(1.5), &[0.0; 2], &[]),
    );
    let mut tangent = Tangent::new(&strongly);
    // K, 1e-6, 3e-5, 9e-4, 2.7e-2, .81, 24
    assert_eq!(prepare(&mut tangent, &strongly), 7);
    assert!(tangent.shift() > 2.0);
    // K, .81, 24: the search goes on a level below the last one
    assert_eq!(prepare(&mut tangent, &strongly), 3);
    assert!(tangent.shift() > 2.0);
    // K, .81
    assert_eq!(prepare(&mut tangent, &weakly), 2);
    assert!(0.5 < tangent.shift() && tangent.shift() < 2.0);
    // K, 2.7e-2, .81, as long as the last one was needed
    for _ in 0..2 {
        assert_eq!(prepare(&mut tangent, &weakly), 3);
        assert!(0.5 < tangent.shift() && tangent.shift() < 2.0);
    }
    tangent.begin();
    assert_eq!(prepare(&mut tangent, &weakly), 6);
}

#[test]
fn a_matrix_that_is_positive_definite_gets_nothing_and_is_not_raised() {
    let toy = Toy::quadratic(&coupled(0.5), &[0.0; 2], &[(vec![1.0, 0.0], 0.0)]);
    let mut tangent = Tangent::new(&toy);
    assert_eq!(prepare(&mut tangent, &toy), 1);
    assert_eq!((tangent.ratio(), tangent.shift()), (0.0, 0.0));
    assert!(!tangent.raise());
    assert_eq!(tangent.added(), [0.0]);
}

#[test]
fn rows_that_act_stiffen_what_they_hold() {
    // −1 + s must be positive, where s is 1 times a ratio of 1, 10 or 100
    let K = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, 0.0, 1.0]);
    let toy = Toy::quadratic(&K, &[0.0; 2], &[(vec![1.0, 0.0], 0.0)]);
    let mut tangent = Tangent::new(&toy);
    assert_eq!(prepare(&mut tangent, &toy), 3);
    assert_eq!((tangent.ratio(), tangent.shift()), (10.0, 0.0));
    assert_eq!(tangent.added(), [10.0]);
    // what is asked for is where the search begins
    assert!(tangent.raise());
    assert_eq!(prepare(&mut tangent, &toy), 1);
    assert_eq!((tangent.ratio(), tangent.shift()), (100.0, 0.0));
    let mut x = [1.0, 1.0];
    tangent.solve(&mut x).expect("a factor");
    assert_near(&x, &[1.0 / 99.0, 1.0], 1e-15);
    // a matrix that is asked for twice is not raised twice
    assert!(tangent.raise());
    assert_eq!(prepare(&mut tangent, &toy), 1);
    assert!(tangent.shift() > 0.0);
}

/// E(u) = 2 u − ln u, of whose error δ Newton's step leaves 2 δ².
#[test]
fn a_step_that_leads_to_a_clear_equilibrium_is_the_last() {
    let mut toy = Toy::quadratic(&DMatrix::identity(1, 1), &[0.0], &[]);
    toy.value = Box::new(|u| 2.0 * u[0] - u[0].ln());
    toy.gradient = Box::new(|u| vec![2.0 - 1.0 / u[0]]);
    toy.hessian = Box::new(|u| DMatrix::from_element(1, 1, 1.0 / (u[0] * u[0])));
    // errors 1e-2, 2e-4, 8e-8, 1.3e-14: the third step is 1.6e-7 long, 16 tolerances, and nothing is left after it
    let solution = toy.solve_from(&[0.51]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_eq!(solution.history.len(), 3);
    assert_near(&solution.state.u, &[0.5], 1e-13);
    let told = solution.history[2].error;
    assert!(told < 1e-10, "{told:e}");
}

#[test]
fn a_step_that_leaves_a_third_of_the_way_is_not_the_last() {
    // E(u) = (u − 1)⁴/4: a step covers a third of the way, and the next one two thirds of that, so that states after
    // short steps are no clear equilibria
    let mut toy = Toy::quadratic(&DMatrix::identity(1, 1), &[0.0], &[]);
    toy.value = Box::new(|u| 0.25 * (u[0] - 1.0).powi(4));
    toy.gradient = Box::new(|u| vec![(u[0] - 1.0).powi(3)]);
    toy.hessian = Box::new(|u| DMatrix::from_element(1, 1, 3.0 * (u[0] - 1.0).powi(2)));
    let mut solver = CondensedNewton {
        tolerance: 1e-4,
        ..CondensedNewton::default()
    };
    let solution = toy.solve_with(&mut solver, &[1.5]);
    assert_eq!(solution.outcome, Outcome::Converged);
    let errors: Vec<f64> = solution.history.iter().map(|one| one.error).collect();
    let (last, others) = errors.split_last().expect("some iterations");
    assert!(*last <= 1e-4 && others.iter().all(|error| *error > 1e-4));
    // two thirds of the way are left of it after each step: .5 (2/3)^k
    let left = solution.state.u[0] - 1.0;
    assert!(0.0 < left && left < 3e-4, "{left:e}");
}
