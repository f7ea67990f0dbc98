//! Methods on one unknown, whose minima are known by hand.

use std::cell::Cell;

use super::*;
use crate::gaps::{Row, RowKey};
use crate::linear::SymmetricPattern;
use crate::{Multipliers, State};

/// E(u) = ½ k u² − f u + q u⁴/4, which may be no number at first.
struct Spring {
    k: f64,
    f: f64,
    q: f64,
    pattern: SymmetricPattern,
    /// So many gradients are no number, once there is one.
    spoilt: Cell<usize>,
}

impl Spring {
    fn new(k: f64, f: f64) -> Self {
        Spring {
            k,
            f,
            q: 0.0,
            pattern: SymmetricPattern::diagonal(1),
            spoilt: Cell::new(0),
        }
    }
}

impl Energy for Spring {
    fn dofs(&self) -> usize {
        1
    }
    fn value(&self, u: &[f64]) -> f64 {
        (0.5 * self.k * u[0] - self.f) * u[0] + 0.25 * self.q * u[0].powi(4)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g[0] = self.k * u[0] - self.f + self.q * u[0].powi(3);
        if self.spoilt.get() > 0 {
            self.spoilt.set(self.spoilt.get() - 1);
            g[0] = f64::NAN;
        }
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        values[0] = self.k + 3.0 * self.q * u[0] * u[0];
    }
    fn is_quadratic(&self) -> bool {
        self.q == 0.0
    }
}

/// 1 − u ≥ 0 in units of `length`, as a row of measure `weight`.
fn wall(length: f64, weight: f64) -> LinearGaps {
    let mut gaps = LinearGaps::new(true);
    let row = Row {
        free: vec![(0, -1.0)],
        constant: length,
        weight,
        ..Row::default()
    };
    gaps.push(RowKey { pass: 0, node: 0 }, &row);
    gaps
}

fn start(u: f64) -> State {
    State {
        u: vec![u],
        ..State::default()
    }
}

/// A problem without bounds in these units.
struct Posed {
    spring: Spring,
    bounds: Bounds,
    gaps: LinearGaps,
    scale: Scale,
    stop: Stop,
}

impl Posed {
    fn new(spring: Spring, gaps: LinearGaps) -> Self {
        Posed {
            spring,
            gaps,
            bounds: Bounds::default(),
            scale: Scale::default(),
            stop: Stop::new(),
        }
    }

    fn solve(&self, method: &mut dyn Method, start: &State) -> Minimum {
        let subproblem = Subproblem {
            energy: &self.spring,
            bounds: &self.bounds,
            gaps: &self.gaps,
            scale: self.scale,
            change: 1.0,
            accuracy: 0.0,
            stop: &self.stop,
        };
        method.minimize(&subproblem, start).expect("no misuse")
    }
}

/// A spring of stiffness 2 is drawn by 5 against a wall at 1, which carries 3; in any units.
#[test]
fn a_spring_against_a_wall_in_any_units() {
    for [length, force] in [[1.0, 1.0], [1e-3, 1.0], [1.0, 1e5], [1e4, 1e-4]] {
        let spring = Spring::new(2.0 * force / length, 5.0 * force);
        let posed = Posed {
            scale: Scale {
                length: 0.5 * length,
                resolution: 0.1 * length,
                energy: force * length,
                ..Scale::default()
            },
            ..Posed::new(spring, wall(length, 1.0))
        };
        for warm in [false, true] {
            let mut from = start(0.3 * length);
            if warm {
                from.multipliers = Multipliers::new(&posed.gaps, &[2.0 * force]);
            }
            let minimum = posed.solve(&mut InteriorPoint::default(), &from);
            assert_eq!(minimum.solved, Solved::Optimal);
            assert!((minimum.u[0] / length - 1.0).abs() < 1e-8, "{minimum:?}");
            assert!((minimum.lambda[0] / force - 3.0).abs() < 1e-8);
            let energy = minimum.energy / (force * length);
            assert!((energy + 4.0).abs() < 1e-7, "{energy}");
        }
    }
}

/// As bounds instead of a row, on either side.
#[test]
fn bounds_in_any_units() {
    for length in [1.0, 1e-3, 1e3] {
        for (f, at) in [(5.0, 1.0), (-7.0, -2.0), (1.0, 0.5)] {
            let posed = Posed {
                bounds: Bounds {
                    lower: vec![-2.0 * length],
                    upper: vec![length],
                },
                scale: Scale {
                    length: 0.1 * length,
                    energy: length,
                    ..Scale::default()
                },
                ..Posed::new(Spring::new(2.0 / length, f), LinearGaps::new(true))
            };
            for method in [
                &mut InteriorPoint::default() as &mut dyn Method,
                &mut PenalizedSlack::default(),
                &mut Penalty::default(),
            ] {
                let minimum = posed.solve(method, &start(0.1 * length));
                assert_eq!(minimum.solved, Solved::Optimal);
                let u = minimum.u[0] / length;
                assert!((u - at).abs() < 1e-6, "{u} instead of {at}");
            }
        }
    }
}

/// A first solve that meets no number is followed by another one.
#[test]
fn quadratic_programs_are_tried_twice() {
    let posed = Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0));
    posed.spring.spoilt.set(1);
    let minimum = posed.solve(&mut InteriorPoint::default(), &start(0.0));
    assert_eq!(posed.spring.spoilt.get(), 0);
    assert_eq!(minimum.solved, Solved::Optimal);
    assert!((minimum.u[0] - 1.0).abs() < 1e-8 && (minimum.lambda[0] - 3.0).abs() < 1e-7);
    assert_eq!(minimum.cost.solves, 2);
}

/// 5 = 2 u + u³ / 20 has its root at 2.04: below the wall at 3 the row has no force.
#[test]
fn energies_that_are_not_quadratic() {
    let mut spring = Spring::new(2.0, 5.0);
    spring.q = 0.05;
    let slope = |u: f64| 2.0 * u + 0.05 * u.powi(3) - 5.0;
    let [mut low, mut high] = [0.0, 3.0];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match slope(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    let minimum =
        Posed::new(spring, wall(3.0, 1.0)).solve(&mut InteriorPoint::default(), &start(0.0));
    assert_eq!(minimum.solved, Solved::Optimal);
    assert!((minimum.u[0] - low).abs() < 1e-8, "{minimum:?}");
    assert!((0.0..1e-6).contains(&minimum.lambda[0]));
}

/// λ at the wall of a penalty: with ½ 2 u² − 5 u + μ w |s|³, 3 μ w s² = 5 − 2 (1 + |s|). The energy is
/// that of the spring alone.
fn penalised(mu: f64) -> f64 {
    let [mut low, mut high] = [0.0, 1.5];
    for _ in 0..80 {
        let s = 0.5 * (low + high);
        match 3.0 * mu * s * s < 3.0 - 2.0 * s {
            true => low = s,
            false => high = s,
        }
    }
    low
}

#[test]
fn a_single_penalty_lets_through_what_balances_it() {
    let fixed = |mu: f64| Continuation::fixed(mu);
    for mu in [10.0, 1e4] {
        // the penalty's weight is a share of a facet: 0.2 of 0.5
        let area = 0.5;
        let cases = [
            (&mut PenalizedSlack::with(fixed(mu)) as &mut dyn Method, mu),
            (&mut Penalty::with(fixed(mu)), 0.4 * mu),
        ];
        for (method, of_row) in cases {
            let posed = Posed {
                scale: Scale {
                    area,
                    ..Scale::default()
                },
                ..Posed::new(Spring::new(2.0, 5.0), wall(1.0, 0.2))
            };
            let minimum = posed.solve(method, &start(0.5));
            assert_eq!(minimum.solved, Solved::Optimal);
            let s = penalised(of_row);
            assert!((minimum.u[0] - 1.0 - s).abs() < 1e-7, "{mu}: {minimum:?}");
            let force = 3.0 - 2.0 * s;
            assert!(
                (minimum.lambda[0] - force).abs() < 1e-6,
                "{mu}: {minimum:?}"
            );
            let energy = posed.spring.value(&[1.0 + s]);
            assert!((minimum.energy - energy).abs() < 1e-6, "{mu}: {minimum:?}");
        }
    }
}

/// The continuation ends where a thousandth of the resolution is let through, not of the length.
#[test]
fn continuations_end_within_their_penetration() {
    for resolution in [1.0, 1e-2] {
        let posed = Posed {
            scale: Scale {
                resolution,
                ..Scale::default()
            },
            ..Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0))
        };
        for method in [
            &mut PenalizedSlack::default() as &mut dyn Method,
            &mut Penalty::default(),
        ] {
            let minimum = posed.solve(method, &start(0.5));
            assert_eq!(minimum.solved, Solved::Optimal);
            let depth = minimum.u[0] - 1.0;
            assert!(0.0 < depth && depth <= 1e-3 * resolution, "{depth}");
            // and not much further: μ grows by 100 at a time, and the depth is as its root
            assert!(depth > 1e-5 * resolution, "{depth}");
        }
    }
}

/// A slack that its bound holds back is no solution: the penalty is so small that the spring would go
/// through by 1.5.
#[test]
fn a_slack_at_its_bound_is_a_failure() {
    let posed = Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0));
    for (bound, holds_back) in [(1.0, true), (3.0, false)] {
        let mut method = PenalizedSlack {
            bound,
            ..PenalizedSlack::with(Continuation::fixed(1e-6))
        };
        let minimum = posed.solve(&mut method, &start(0.5));
        let failed = matches!(minimum.solved, Solved::Failed(_));
        assert_eq!(failed, holds_back, "{minimum:?}");
    }
}

/// A move limit of a hundredth of the way does not change where the way ends.
#[test]
fn move_limits_grow_while_they_hold_back() {
    let posed = Posed::new(Spring::new(2.0, 200.0), LinearGaps::new(true));
    let mut method = Penalty {
        move_limit: Some(1.0),
        ..Penalty::default()
    };
    let minimum = posed.solve(&mut method, &start(0.0));
    assert_eq!(minimum.solved, Solved::Optimal);
    assert!((minimum.u[0] - 100.0).abs() < 1e-5, "{minimum:?}");
}

#[test]
fn a_request_to_stop_is_no_failure() {
    let posed = Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0));
    posed.stop.request();
    for method in [
        &mut InteriorPoint::default() as &mut dyn Method,
        &mut PenalizedSlack::default(),
        &mut Penalty::default(),
    ] {
        let minimum = posed.solve(method, &start(0.0));
        assert_eq!(minimum.solved, Solved::Interrupted);
    }
}

/// Settings that mean nothing are named, and the least that means something is taken.
#[test]
fn settings_that_mean_nothing_are_refused() {
    let posed = Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0));
    let subproblem = Subproblem {
        energy: &posed.spring,
        bounds: &posed.bounds,
        gaps: &posed.gaps,
        scale: posed.scale,
        change: 1.0,
        accuracy: 0.0,
        stop: &posed.stop,
    };
    let is_taken = |method: &mut dyn Method| method.minimize(&subproblem, &start(0.0)).is_ok();
    let slack = |bound: f64| PenalizedSlack {
        bound,
        ..PenalizedSlack::default()
    };
    assert!(is_taken(&mut slack(0.1)));
    assert!(
        ![0.0, -1.0, f64::NAN]
            .iter()
            .any(|bound| is_taken(&mut slack(*bound)))
    );
    let limited = |limit: f64| Penalty {
        move_limit: Some(limit),
        ..Penalty::default()
    };
    assert!(is_taken(&mut limited(1e-3)));
    for limit in [1e-9, 0.0, -1.0, f64::NAN] {
        assert!(!is_taken(&mut limited(limit)), "{limit}");
    }
}

/// μ goes on where the last solve ended, but not beyond a limit that has come down since, and begins
/// again where that fails.
#[test]
fn continuations_go_on_and_begin_again() {
    let posed = Posed::new(Spring::new(2.0, 5.0), wall(1.0, 1.0));
    let warm = |lambda: f64| State {
        multipliers: Multipliers::new(&posed.gaps, &[lambda]),
        ..start(1.0)
    };
    let mut method = PenalizedSlack::with(Continuation::fixed(1e6));
    posed.solve(&mut method, &start(0.5));
    method.penalization.continuation = Continuation::fixed(10.0);
    let minimum = posed.solve(&mut method, &warm(3.0));
    assert!(
        (minimum.u[0] - 1.0 - penalised(10.0)).abs() < 1e-7,
        "{minimum:?}"
    );

    let mut method = PenalizedSlack::default();
    let first = posed.solve(&mut method, &start(0.5));
    let second = posed.solve(&mut method, &warm(3.0));
    assert_eq!(second.solved, Solved::Optimal);
    assert!(second.cost.solves < first.cost.solves, "it goes on");
    // neither the warm solve nor its cold repetition meets a number
    posed.spring.spoilt.set(2);
    let third = posed.solve(&mut method, &warm(3.0));
    assert_eq!(
        (posed.spring.spoilt.get(), third.solved),
        (0, Solved::Optimal)
    );
    assert!((third.u[0] - first.u[0]).abs() < 1e-6);
}
