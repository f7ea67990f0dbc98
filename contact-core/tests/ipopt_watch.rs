//! A closure that looks at every iterate, and may stop the solve.
#![cfg(feature = "ipopt")]

use std::{
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    thread,
};

use contact_core::{
    ipopt::{Error, Solver, Start, Status},
    nlp::{Multipliers, Phase},
};
use problems::*;

#[test]
fn every_iterate_is_seen_after_the_problem_has_seen_it() {
    let seen_by_problem = std::cell::Cell::new(0);
    let mut nlp = Watched::new(Hs071, |function| {
        if function == Function::Iterate {
            seen_by_problem.set(seen_by_problem.get() + 1);
        }
        ControlFlow::Continue(())
    });
    let mut records = Vec::new();
    let mut last = (Vec::new(), Vec::new(), Multipliers::default());
    let solution = hs071_solver!()
        .solve_with(&mut nlp, &Start::at(&HS071_START), |iterate| {
            records.push(*iterate.record());
            assert_eq!(seen_by_problem.get(), records.len());
            assert_eq!(iterate.record().phase, Phase::Regular);
            last = (
                iterate.x().unwrap().to_vec(),
                iterate.constraints().unwrap().to_vec(),
                iterate.multipliers().unwrap().clone(),
            );
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert_eq!(records, solution.history);
    assert_close(&last.0, &HS071_X, 1e-6);
    assert_close(&last.1, &[25.0, 40.0], 1e-6);
    assert_close(&last.2.constraints, &HS071_LAMBDA, 1e-5);
    assert_close(&last.2.lower, &HS071_LOWER, 1e-5);
}

#[test]
fn both_may_stop() {
    let stop_at = |ours: usize, its: usize| {
        let mut left = its;
        let mut nlp = Watched::new(Hs071, move |function| {
            left -= usize::from(function == Function::Iterate);
            match left {
                0 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        let mut calls = 0;
        let solution = hs071_solver!()
            .solve_with(&mut nlp, &Start::at(&HS071_START), |iterate| {
                calls += 1;
                match iterate.record().iteration {
                    i if i == ours => ControlFlow::Break(()),
                    _ => ControlFlow::Continue(()),
                }
            })
            .unwrap();
        assert_eq!(solution.status, Status::StoppedByUser);
        assert_eq!(solution.history.len(), calls);
        assert!(solution.multipliers.is_some());
        calls
    };
    assert_eq!(stop_at(4, 100), 5, "the closure, in iteration 4");
    assert_eq!(stop_at(100, 3), 3, "the problem, in its third call");
}

#[test]
fn a_panic_of_the_closure_goes_on_in_the_caller() {
    let mut solver: Solver = hs071_solver!();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        solver.solve_with(&mut Hs071, &Start::at(&HS071_START), |iterate| {
            assert!(iterate.record().iteration < 2, "that is enough");
            ControlFlow::Continue(())
        })
    }));
    let payload = outcome.unwrap_err();
    assert_eq!(payload.downcast_ref(), Some(&"that is enough"));
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
}

#[test]
fn a_solve_inside_the_closure_is_refused() {
    let mut refused = 0;
    hs071_solver!()
        .solve_with(&mut Hs071, &Start::at(&HS071_START), |_| {
            let inner = hs071_solver!().solve(&mut Hs071, &Start::at(&HS071_START));
            refused += usize::from(inner == Err(Error::Reentrant));
            ControlFlow::Break(())
        })
        .unwrap();
    assert_eq!(refused, 1);
}

/// Compiles for a type that is not `Sync` only, which a doctest that must not compile would not tell from any other
/// error: for others the second implementation makes the path ambiguous.
trait UnlessSync<A> {
    fn check() {}
}
impl<T: ?Sized> UnlessSync<()> for T {}
struct ItIs;
impl<T: ?Sized + Sync> UnlessSync<ItIs> for T {}

fn is_send<T: Send>(_: &T) {}

#[test]
fn a_solver_may_move_to_another_thread_and_is_not_shared() {
    <Solver as UnlessSync<_>>::check();
    let mut solver = hs071_solver!();
    is_send(&solver);
    let solution = thread::spawn(move || solver.solve(&mut Hs071, &Start::at(&HS071_START)))
        .join()
        .unwrap();
    assert_close(&solution.unwrap().x, &HS071_X, 1e-6);
}
