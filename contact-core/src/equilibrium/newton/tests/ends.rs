//! How a solve ends where there is nothing to find, or where it is not asked to.

use super::super::super::StepContext;
use super::*;

/// E(u) = 2 u − ln u with its minimum at ½, +∞ below zero.
fn logarithm() -> Toy {
    let mut toy = Toy::quadratic(&DMatrix::identity(1, 1), &[0.0], &[]);
    toy.value = Box::new(|u| match u[0] > 0.0 {
        true => 2.0 * u[0] - u[0].ln(),
        false => f64::INFINITY,
    });
    toy.gradient = Box::new(|u| vec![2.0 - 1.0 / u[0]]);
    toy.hessian = Box::new(|u| DMatrix::from_element(1, 1, 1.0 / (u[0] * u[0])));
    toy.domain_len = 1;
    toy
}

#[test]
fn steps_that_would_leave_the_domain_are_shortened() {
    // a full step from 1.9 would end at −3.4, and one from 0.97 below a tenth of it
    for start in [1.9, 0.97, 5.0, 0.01] {
        let solution = logarithm().solve_from(&[start]);
        assert_eq!(solution.outcome, Outcome::Converged, "{start}");
        assert_near(&solution.state.u, &[0.5], 1e-12);
        assert!((solution.energy - 1.0 - 2f64.ln()).abs() < 1e-12);
    }
}

#[test]
fn a_start_of_infinite_energy_is_inadmissible() {
    for u in [-1.0, 0.0] {
        let solution = logarithm().solve_from(&[u]);
        assert_eq!(solution.outcome, Outcome::InadmissibleStart);
        assert_eq!(solution.state.u, [u]);
        assert!(solution.history.is_empty() && !solution.energy.is_finite());
    }
}

fn spring_at_a_wall() -> Toy {
    let wall = (vec![-1.0, 0.0], 0.5);
    Toy::quadratic(&DMatrix::identity(2, 2), &[1.0, 1.0], &[wall])
}

#[test]
fn settings_out_of_range_are_refused() {
    let toy = spring_at_a_wall();
    for tolerance in [0.0, 1.0, -1e-8, f64::NAN, f64::INFINITY] {
        let mut solver = CondensedNewton::with_tolerance(tolerance);
        assert!(solver.validate().is_err(), "{tolerance}");
        let refused = solver.solve_from(&toy, at(&[0.0; 2]));
        let why = refused.expect_err("out of range").to_string();
        assert!(why.contains("tolerance"), "{why}");
    }
    let mut solver = CondensedNewton {
        max_iterations: 0,
        ..CondensedNewton::default()
    };
    let refused = solver.solve_from(&toy, at(&[0.0; 2]));
    let why = refused.expect_err("out of range").to_string();
    assert!(why.contains("max_iterations"), "{why}");
    assert!(CondensedNewton::default().validate().is_ok());
}

#[test]
fn finite_bounds_are_refused_and_infinite_ones_are_none() {
    let mut toy = spring_at_a_wall();
    toy.bounds = Bounds::free(2);
    let solution = toy.solve_from(&[0.0; 2]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &[0.5, 1.0], 1e-12);
    for (is_upper, k) in [(false, 0), (true, 0), (true, 1)] {
        let mut toy = spring_at_a_wall();
        toy.bounds = Bounds::free(2);
        let side = match is_upper {
            true => &mut toy.bounds.upper,
            false => &mut toy.bounds.lower,
        };
        side[k] = 0.25;
        let refused = CondensedNewton::default().solve_from(&toy, at(&[0.0; 2]));
        let Err(Error::Untreated { solver, value, .. }) = refused else {
            panic!("{:?}", refused.map(|solution| solution.outcome));
        };
        assert_eq!(solver, "CondensedNewton");
        assert_eq!(value, format!("0.25 on unknown {k}"));
    }
}

#[test]
fn a_start_of_another_length_is_refused() {
    let toy = spring_at_a_wall();
    let refused = CondensedNewton::default().solve_from(&toy, at(&[0.0; 3]));
    let why = refused.expect_err("three unknowns").to_string();
    assert!(why.contains("start.u"), "{why}");
}

#[test]
fn a_stop_requested_beforehand_leaves_the_start() {
    let toy = spring_at_a_wall();
    let (start, stop) = (at(&[0.25, 0.0]), Stop::new());
    stop.request();
    let lifted = || at(&[0.25, 0.0]);
    let context = StepContext::single(&start, &lifted, &stop);
    let solved = CondensedNewton::default().solve(&toy, start.clone(), &context);
    let solution = solved.expect("a valid problem");
    assert_eq!(solution.outcome, Outcome::Interrupted);
    assert_eq!(solution.state.u, [0.25, 0.0]);
    assert!(solution.history.is_empty());
}

#[test]
fn the_iteration_limit_is_told() {
    let mut toy = logarithm();
    toy.domain_len = 0;
    let mut solver = CondensedNewton {
        max_iterations: 2,
        ..CondensedNewton::default()
    };
    let solution = toy.solve_with(&mut solver, &[0.01]);
    assert_eq!(solution.outcome, Outcome::IterationLimit);
    // two steps of Newton's method, by which u becomes 2 u (1 − u); then two in each round with springs
    assert_eq!(solution.history.len() % 2, 0);
    let mut u = 0.01;
    for iteration in &solution.history[..2] {
        let next = 2.0 * u * (1.0 - u);
        assert!(
            (iteration.error - (next - u) / next).abs() < 1e-12,
            "{iteration:?}"
        );
        u = next;
    }
}

/// The solve ends without a solution, and without a panic.
fn assert_fails(what: &str, toy: &Toy) {
    let solution = toy.solve_from(&[0.0; 2]);
    let is_told = matches!(
        solution.outcome,
        Outcome::SubproblemFailed(_) | Outcome::InadmissibleStart
    );
    assert!(is_told, "{what}: {}", solution.outcome);
    assert!(
        solution.state.u.iter().all(|u| u.is_finite()),
        "{what}: {:?}",
        solution.state.u
    );
}

#[test]
fn what_is_no_number_does_not_converge() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut toy = spring_at_a_wall();
        toy.value = Box::new(move |_| bad);
        assert_fails("energy", &toy);
        let mut toy = spring_at_a_wall();
        toy.value = Box::new(move |u| if u == [0.0; 2] { 0.0 } else { bad });
        assert_fails("energy away from the start", &toy);
        let mut toy = spring_at_a_wall();
        toy.gradient = Box::new(move |_| vec![0.0, bad]);
        assert_fails("gradient", &toy);
        let mut toy = spring_at_a_wall();
        toy.hessian = Box::new(move |_| DMatrix::from_element(2, 2, bad));
        assert_fails("Hessian", &toy);
        for (coefficient, constant) in [(bad, 0.5), (-1.0, bad)] {
            let mut toy = spring_at_a_wall();
            toy.rows = Box::new(move |_| {
                let mut gaps = LinearGaps::new(false);
                gaps.push(key(0), &row(&[coefficient, 0.0], constant));
                gaps
            });
            assert_fails("row", &toy);
        }
        for in_forces in [false, true] {
            let mut toy = spring_at_a_wall();
            toy.vary = Some(Box::new(move |_, gaps, _| {
                let mut variation = GapVariation::default();
                for _ in 0..gaps.len() {
                    let a = if in_forces { -1.0 } else { bad };
                    variation.gradients.push(&[(0, a)]);
                    variation.internal_gradients.push(&[]);
                }
                if in_forces {
                    variation.push_force(1, &[(0, bad)], &[]);
                }
                variation
            }));
            // the row acts from the start, so that its variation is asked for
            let start = with_multipliers(&toy, &[0.0; 2], &[1.0]);
            let solved = CondensedNewton::default().solve_from(&toy, start);
            let solution = solved.expect("a valid problem");
            assert_ne!(solution.outcome, Outcome::Converged, "{bad} in a variation");
        }
    }
}

/// Two walls that overlap, and a row that no unknown moves.
#[test]
fn rows_that_cannot_hold_are_a_failure() {
    let walls = [(vec![1.0, 0.0], -1.0), (vec![-1.0, 0.0], 0.5)];
    let K = DMatrix::identity(2, 2);
    assert_fails("overlap", &Toy::quadratic(&K, &[0.0; 2], &walls));
    let nothing = [(vec![0.0, 0.0], -1.0)];
    assert_fails("nothing", &Toy::quadratic(&K, &[0.0; 2], &nothing));
}

/// E = ½ u₁² − ½ u₂² falls for ever: there is no minimum, and none is claimed.
#[test]
fn an_energy_without_a_minimum_does_not_converge() {
    let K = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, -1.0]);
    let solution = Toy::quadratic(&K, &[0.0, 1.0], &[]).solve_from(&[0.0; 2]);
    assert_ne!(solution.outcome, Outcome::Converged, "{:?}", solution.state);
}

/// Steps close rows to 1e-10 of the displacements; a tighter tolerance on their change is met all the same.
#[test]
fn a_tolerance_below_what_steps_leave_is_met() {
    for tolerance in [1e-10, 1e-12, 1e-14] {
        let mut solver = CondensedNewton::with_tolerance(tolerance);
        let solution = spring_at_a_wall().solve_with(&mut solver, &[0.0; 2]);
        assert_eq!(solution.outcome, Outcome::Converged, "{tolerance}");
        assert_near(&solution.state.u, &[0.5, 1.0], 1e-10);
    }
}
