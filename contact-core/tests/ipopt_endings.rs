//! Ends of solves that take a special problem, or a new Ipopt.
#![cfg(feature = "ipopt")]

use std::{ops::ControlFlow, thread, time::Duration};

use contact_core::{
    ipopt::{
        Error, OptionError, Options, Sequence, SequenceSettings, Solver, Start, Status, VERSION,
    },
    nlp::{Bounds, Nlp, Pattern, Structure},
};
use problems::*;

/// |x|² = 2 and x₀ = x₁, from next to a solution.
struct Square;

impl Nlp for Square {
    fn objective(&mut self, _: &[f64], _: bool) -> f64 {
        0.0
    }
    fn gradient(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g.copy_from_slice(&[x[0] * x[0] + x[1] * x[1], x[0] - x[1]]);
    }
    fn jacobian(&mut self, x: &[f64], _: bool, values: &mut [f64]) {
        values.copy_from_slice(&[2.0 * x[0], 2.0 * x[1], 1.0, -1.0]);
    }
    fn hessian(&mut self, _: &[f64], _: bool, _: f64, lambda: &[f64], values: &mut [f64]) {
        values.fill(2.0 * lambda[0]);
    }
}

#[test]
fn a_square_problem_may_be_solved_in_restoration() {
    let system = Bounds {
        lower: vec![2.0, 0.0],
        upper: vec![2.0, 0.0],
    };
    let hessian = Some(Pattern::diagonal(2));
    let structure = Structure::new(Bounds::free(2), system, Pattern::dense(2, 2), hessian).unwrap();
    let start = [1.00001, 1.0];
    let solve = |options: &Options| {
        let mut solver = Solver::new(structure.clone(), options).unwrap();
        let solution = solver.solve(&mut Square, &Start::at(&start)).unwrap();
        assert_close(&solution.x, &[1.0; 2], 1e-8);
        assert_close(&solution.g, &[2.0, 0.0], 1e-8);
        assert!(solution.status.is_acceptable());
        solution
    };
    assert_eq!(solve(&Options::new()).status, Status::Solved);
    let options = Options::new().with("start_with_resto", true);
    let restored = solve(&options);
    assert_eq!(restored.status, Status::FeasiblePointFound);
    assert_eq!((restored.objective, restored.multipliers), (0.0, None));
    let settings = SequenceSettings {
        options,
        ..SequenceSettings::default()
    };
    let mut sequence = Sequence::new(structure.clone(), settings, &start).unwrap();
    assert!(sequence.solve(&mut Square).unwrap().solved);
    assert!(sequence.start().x != start && sequence.start().multipliers.is_none());
}

/// Since 3.14: the functions sleep, which takes no processor time.
#[test]
fn a_limit_of_wall_time_is_a_status() {
    let options = Options::new().max_wall_time(0.05);
    let mut solver = match Solver::new(hs071_structure(), &options) {
        Ok(solver) => solver,
        Err(Error::Option(OptionError::Unknown { since, .. })) => {
            assert!(VERSION < (3, 14, 0) && since == Some("3.14.0"), "{since:?}");
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let mut slow = Watched::new(Hs071, |_| {
        thread::sleep(Duration::from_millis(10));
        ControlFlow::Continue(())
    });
    let solution = solver.solve(&mut slow, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::WallTimeLimit);
    assert_eq!(solution.status.code(), -5);
    assert_eq!(solution.multipliers, None);
    assert!(solution.objective.is_nan() && solution.g.iter().all(|g| g.is_nan()));
    let last = solution.history.last().expect("the start at least");
    assert!(last.objective > 0.0 && solution.history.len() < 8);
    assert!(solution.statistics.total.wall >= 0.05);
}
