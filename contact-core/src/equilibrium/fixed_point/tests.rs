//! The iteration around a method whose results are given.

use std::collections::VecDeque;

use super::super::accuracy::Accuracy;
use super::super::anderson::Anderson;
use super::super::cycles::CycleDetector;
use super::super::{Retry, least_displacement};
use super::*;
use crate::gaps::{Row, Sampling};
use crate::linear::SymmetricPattern;
use crate::method::{Minimum, Subproblem};
use crate::nlp::Bounds;
use crate::{Cost, Energy, LinearGaps, Outcome, RowKey, Scale, Solved, Stop};

/// One unknown below a wall, beyond which the energy is infinite, with one row for each role.
struct Room {
    wall: f64,
    prescribed: f64,
    scale: Scale,
    pattern: SymmetricPattern,
    bounds: Bounds,
}

impl Room {
    fn below(wall: f64) -> Self {
        Room {
            wall,
            prescribed: 0.0,
            scale: Scale::default(),
            pattern: SymmetricPattern::diagonal(1),
            bounds: Bounds::free(1),
        }
    }

    fn row(&self, u: &[f64], role: u32) -> Result<LinearGaps, Error> {
        let mut gaps = LinearGaps::new(false);
        let row = Row {
            free: vec![(0, 1.0)],
            constant: u[0],
            ..Row::default()
        };
        let key = RowKey {
            pass: role,
            node: 0,
        };
        gaps.push(key, &row);
        Ok(gaps)
    }
}

impl Energy for Room {
    fn dofs(&self) -> usize {
        1
    }
    fn value(&self, u: &[f64]) -> f64 {
        if u[0] < self.wall { 0.0 } else { f64::INFINITY }
    }
    fn gradient(&self, _: &[f64], g: &mut [f64]) {
        g[0] = 0.0;
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values[0] = 1.0;
    }
}

impl ContactProblem for Room {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        self.row(u, 0)
    }
    fn linearize_reversed(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        self.row(u, 1)
    }
    fn scale(&self) -> Option<Scale> {
        Some(self.scale)
    }
    fn prescribed_magnitude(&self) -> f64 {
        self.prescribed
    }
}

/// Returns these u one after the other, the last one for ever, with λ = (10 u, 20 u); it remembers
/// its starts: u, the sum of the multipliers, and the constants of the rows.
struct Images {
    next: VecDeque<f64>,
    starts: Vec<(f64, f64, Vec<f64>)>,
    spoil: fn(&mut Minimum),
}

impl Images {
    fn of(images: &[f64]) -> Self {
        Images {
            next: images.iter().copied().collect(),
            starts: Vec::new(),
            spoil: |_| (),
        }
    }

    fn starts(&self) -> Vec<f64> {
        self.starts.iter().map(|start| start.0).collect()
    }
}

impl Method for Images {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let keys = subproblem.gaps.keys().iter();
        let multipliers = keys.map(|key| start.multipliers.of(*key)).sum();
        let rows = subproblem.gaps.constant().to_vec();
        self.starts.push((start.u[0], multipliers, rows));
        let u = match self.next.len() {
            1 => self.next[0],
            _ => self.next.pop_front().expect("images"),
        };
        let mut minimum = Minimum {
            u: vec![u],
            lambda: vec![10.0 * u, 20.0 * u],
            energy: 0.0,
            solved: Solved::Optimal,
            cost: Cost::default(),
        };
        (self.spoil)(&mut minimum);
        Ok(minimum)
    }
}

fn at(u: f64) -> State {
    State {
        u: vec![u],
        ..State::default()
    }
}

fn iterated(images: &[f64], max_iterations: usize) -> FixedPoint<Images> {
    FixedPoint {
        max_iterations,
        ..FixedPoint::with(Images::of(images))
    }
}

/// ‖u − u'‖ over the larger of both norms and the least one.
#[test]
fn changes_are_relative_to_the_largest() {
    for (u, before, least, expected) in [
        ([3.0, -4.0], [1.0, 0.0], 1.0, 1.0),
        ([3.0, -4.0], [1.0, 0.0], 8.0, 0.5),
        ([4.0, 0.0], [1.0, 0.0], 0.0, 0.75),
        ([1.0, 0.0], [4.0, 0.0], 0.0, 0.75),
        ([1e-9, 0.0], [0.0, 0.0], 1e-3, 1e-6),
        ([0.0, 0.0], [0.0, 0.0], 0.0, 0.0),
    ] {
        let change = relative_change(&u, &before, least);
        assert!((change - expected).abs() < 1e-15, "{u:?} {before:?}");
    }
}

/// The least norm is what is prescribed, or a millionth of the scale.
#[test]
fn displacements_below_a_millionth_of_the_scale_are_none() {
    for (prescribed, length, least) in [(0.0, 1.0, 1e-6), (0.3, 1.0, 0.3), (1e-7, 10.0, 1e-5)] {
        let room = Room {
            prescribed,
            scale: Scale {
                length,
                ..Scale::default()
            },
            ..Room::below(1.0)
        };
        assert!((least_displacement(&room, room.scale.length) / least - 1.0).abs() < 1e-12);
    }
}

/// Every iteration projects at the last iterate, in both roles, and starts from its multipliers.
#[test]
fn iterations_start_from_the_last_iterate() {
    let mut plain = FixedPoint {
        acceleration: Acceleration::Plain,
        ..iterated(&[1.0, 1.5, 1.75, 1.75], 30)
    };
    let solution = plain.solve_from(&Room::below(9.0), at(0.5)).expect("valid");
    assert_eq!(solution.outcome, Outcome::Converged);
    let expected: Vec<_> = [(0.5, 0.0), (1.0, 30.0), (1.5, 45.0), (1.75, 52.5)]
        .map(|(u, multipliers)| (u, multipliers, vec![u, u]))
        .into();
    assert_eq!(plain.method.starts, expected);
    assert_eq!(
        (solution.state.u[0], &solution.lambda[..]),
        (1.75, &[17.5, 35.0][..])
    );
}

/// With images 1 and 1.5 of 0 and 1, Anderson proposes 2: beyond the wall the image is taken, and the
/// memory is empty again, so that the next one is taken as well. Below the wall it goes on: from
/// differences −½ and −0.3 of residuals, and ½ and 0.7 of images, to 2.2 + 0.2 (0.25 + 0.21) / 0.34.
#[test]
fn proposals_beyond_the_domain_are_not_taken() {
    let images = [1.0, 1.5, 1.6, 1.65, 1.0];
    let mut fixed_point = iterated(&images, 5);
    let room = Room::below(1.9);
    let solution = fixed_point.solve_from(&room, at(0.0)).expect("valid");
    assert_eq!(solution.outcome, Outcome::IterationLimit);
    assert_eq!(fixed_point.method.starts()[..4], [0.0, 1.0, 1.5, 1.6]);

    let mut fixed_point = iterated(&[1.0, 1.5, 2.2, 1.0], 4);
    let room = Room::below(9.0);
    fixed_point.solve_from(&room, at(0.0)).expect("valid");
    let starts = fixed_point.method.starts();
    let expected = [0.0, 1.0, 2.0, 2.2 + 0.2 * (0.25 + 0.21) / 0.34];
    let close = |(a, b): (&f64, f64)| (a - b).abs() < 1e-12;
    assert!(starts.iter().zip(expected).all(close), "{starts:?}");
}

/// Of depth 1, the last difference alone counts: γ = f·Δf / |Δf|².
#[test]
fn memories_are_as_deep_as_they_are_told() {
    let mut anderson = Anderson::new(1);
    let points = [[0.0, 0.0], [1.0, -1.0], [0.5, 2.0], [3.0, 1.0]];
    let images = [[1.0, 3.0], [2.5, 0.5], [-1.0, 4.0], [2.0, 7.0]];
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let f = |k: usize| minus(images[k], points[k]);
    for k in 0..4 {
        let next = anderson.next(&points[k], &images[k]);
        let mut expected = images[k];
        if k > 0 {
            let (df, dg) = (minus(f(k), f(k - 1)), minus(images[k], images[k - 1]));
            let gamma = dot(f(k), df) / dot(df, df);
            expected = minus(expected, [gamma * dg[0], gamma * dg[1]]);
        }
        for i in 0..2 {
            assert!((next[i] - expected[i]).abs() < 1e-12, "{k}: {next:?}");
        }
    }
}

/// A start beyond the wall is no start: no method is called.
#[test]
fn nothing_is_solved_from_an_inadmissible_start() {
    let mut fixed_point = iterated(&[0.0], 3);
    let room = Room::below(1.0);
    let solution = fixed_point.solve_from(&room, at(2.0)).expect("valid");
    assert_eq!(solution.outcome, Outcome::InadmissibleStart);
    assert!(fixed_point.method.starts.is_empty());
}

/// What a failed solve leaves is the iterate that it started from, without forces.
#[test]
fn a_solve_without_numbers_leaves_its_start() {
    for spoil in [(|m| m.u[0] = f64::NAN) as fn(&mut Minimum), |m| {
        m.lambda[1] = f64::INFINITY
    }] {
        let mut fixed_point = iterated(&[1.0, 2.0], 5);
        fixed_point.method.spoil = spoil;
        let room = Room::below(9.0);
        let solution = fixed_point.solve_from(&room, at(0.25)).expect("valid");
        assert!(matches!(solution.outcome, Outcome::SubproblemFailed(_)));
        assert_eq!(
            (solution.state.u[0], &solution.lambda[..]),
            (0.25, &[0.0; 2][..])
        );
        assert_eq!(solution.history[0].error, f64::INFINITY);
    }
}

/// Neither is an energy that is no number a minimum.
#[test]
fn a_minimum_without_an_energy_is_none() {
    let mut fixed_point = iterated(&[1.0, 1.0, 1.0, 1.0], 5);
    fixed_point.method.spoil = |minimum| minimum.energy = f64::NAN;
    let room = Room::below(9.0);
    let solution = fixed_point.solve_from(&room, at(0.25)).expect("valid");
    assert!(matches!(solution.outcome, Outcome::SubproblemFailed(_)));
    assert_eq!(solution.history.len(), 1);
}

/// Rough solves do not count as converged, however little changes: there are two, unless the limit
/// leaves one or none.
#[test]
fn the_first_two_solves_do_not_converge() {
    for (limit, solves) in [(30, 3), (3, 3), (2, 2), (1, 1)] {
        let images = [1e-9, 3e-9, 4e-9, 4e-9].map(|change| 0.5 + change);
        let mut fixed_point = iterated(&images, limit);
        let solution = fixed_point.solve_from(&Room::below(9.0), at(0.5));
        let solution = solution.expect("valid");
        assert_eq!(solution.outcome, Outcome::Converged, "{limit}");
        assert_eq!(fixed_point.method.starts.len(), solves, "{limit}");
    }
}

/// As many iterations as are allowed, and no more.
#[test]
fn iterations_are_limited() {
    for limit in 1..5 {
        let images: Vec<f64> = (0..9).map(|k| f64::from(k).sqrt()).collect();
        let mut fixed_point = iterated(&images, limit);
        let solution = fixed_point.solve_from(&Room::below(99.0), at(0.5));
        let solution = solution.expect("valid");
        assert_eq!(solution.outcome, Outcome::IterationLimit);
        assert_eq!(solution.history.len(), limit);
        assert_eq!(fixed_point.method.starts.len(), limit);
    }
}

/// The accuracy asked of a rough solve is a millionth of the change, of at most a hundredth.
#[test]
fn rough_solves_agree_in_the_first_digits() {
    let accelerated = Accuracy::new(Acceleration::Anderson(8), 30);
    for (change, asked) in [(1.0, 1e-8), (1e-2, 1e-8), (1e-4, 1e-10)] {
        for solved in 0..2 {
            let accuracy = accelerated.of(solved, change, false);
            assert!((accuracy / asked - 1.0).abs() < 1e-12, "{accuracy}");
            assert_eq!(accelerated.of(solved, change, true), 0.0, "exact rows");
        }
        assert_eq!(accelerated.of(2, change, false), 0.0);
        let plain = Accuracy::new(Acceleration::Plain, 30);
        assert_eq!(plain.of(0, change, false), 0.0);
    }
}

/// The first iterate after which a cycle is seen, and its period. Iterates are those of `at`.
fn cycle(at: impl Fn(usize) -> f64) -> Option<(usize, usize)> {
    let mut detector = CycleDetector::default();
    (1..100).find_map(|k| {
        let (u, before) = (at(k), at(k - 1));
        let error = relative_change(&[u], &[before], 0.0);
        Some((k, detector.period(&[u], error)?))
    })
}

/// A period p is first seen when an iterate returns, which is p after the first one, and then for 3 p
/// iterations.
#[test]
fn cycles_are_seen_after_three_periods() {
    for period in 2..=4 {
        let seen = cycle(|k| 1.0 + (k % period) as f64);
        assert_eq!(seen, Some((4 * period, period)));
    }
    assert_eq!(cycle(|k| 1.0 + (k % 5) as f64), None, "too long");
}

/// Neither are iterates that come closer, from one side or from both, nor one that came back once.
#[test]
fn slow_convergence_is_no_cycle() {
    for ratio in [0.9f64, -0.9, 0.5, -0.5] {
        let seen = cycle(|k| 1.0 + ratio.powi(k as i32));
        assert_eq!(seen, None, "{ratio}");
    }
    let once = cycle(|k| if k == 3 { 1.0 } else { k as f64 });
    assert_eq!(once, None);
}

/// Iterates that never settle: the plain iteration is tried from the same start, then the accelerated
/// one from the lifted start. All of that is told, and the setting stays.
#[test]
fn wandering_is_tried_again_twice() {
    let images = [1.0, 5.0, 2.0, 7.0, 3.0, 8.0, 1.0, 6.0, 2.0];
    for (acceleration, first) in [
        (Acceleration::Anderson(2), vec![0.25, 0.25, 0.75]),
        (Acceleration::Plain, vec![0.25]),
    ] {
        let mut retry = Retry {
            fixed_point: FixedPoint {
                acceleration,
                ..iterated(&images, 3)
            },
        };
        let (start, lifted) = (at(0.25), || at(0.75));
        let stop = Stop::new();
        let context = StepContext::single(&start, &lifted, &stop);
        let solution = retry.solve(&Room::below(99.0), start.clone(), &context);
        let solution = solution.expect("valid");
        assert_eq!(solution.outcome, Outcome::IterationLimit);
        assert_eq!(solution.history.len(), 3 * first.len());
        let before: Vec<_> = solution.failed.iter().map(|f| f.outcome.clone()).collect();
        assert_eq!(before, vec![Outcome::IterationLimit; first.len() - 1]);
        let starts = retry.fixed_point.method.starts();
        let firsts: Vec<f64> = starts.iter().copied().step_by(3).collect();
        assert_eq!(firsts, first);
        // the second attempt is plain: its iterates are the images
        if first.len() == 3 {
            assert_eq!(starts[4..6], [7.0, 3.0]);
        }
        assert_eq!(retry.fixed_point.acceleration, acceleration);
    }
}

/// The plain iteration converges where the accelerated one goes astray: there is no third attempt.
#[test]
fn the_plain_iteration_may_settle_what_wanders() {
    let mut retry = Retry {
        fixed_point: iterated(&[1.0, 5.0, 2.0, 3.0, 3.0], 3),
    };
    let room = Room::below(99.0);
    let solution = retry.solve_from(&room, at(0.25)).expect("valid");
    assert_eq!(
        (solution.outcome, solution.state.u[0]),
        (Outcome::Converged, 3.0)
    );
    assert_eq!((solution.history.len(), solution.failed.len()), (5, 1));
    // the next load step is accelerated again
    assert_eq!(retry.fixed_point.acceleration, Acceleration::default());
}
