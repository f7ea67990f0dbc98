//! The collection, by number of variables and kind of constraints.
//!
//! W. Hock, K. Schittkowski, *Test Examples for Nonlinear Programming Codes*, Springer, 1981 ("HS"), and
//! K. Schittkowski, *More Test Examples for Nonlinear Programming Codes*, Springer, 1987 ("S"). HS013 is among the variants.

mod bounded;
mod colville;
mod inequalities;
mod large;
mod linear_equalities;
mod mixed;
mod nonlinear_equalities;
mod planar;

use crate::problem::Problem;

/// All problems.
pub fn all() -> impl Iterator<Item = &'static Problem> {
    [
        bounded::PROBLEMS,
        planar::PROBLEMS,
        linear_equalities::PROBLEMS,
        nonlinear_equalities::PROBLEMS,
        inequalities::PROBLEMS,
        mixed::PROBLEMS,
        large::PROBLEMS,
        colville::PROBLEMS,
    ]
    .into_iter()
    .flatten()
}

/// One of them.
pub fn problem(name: &str) -> Problem {
    *all()
        .find(|problem| problem.name == name)
        .unwrap_or_else(|| panic!("{name} is not in the collection"))
}
