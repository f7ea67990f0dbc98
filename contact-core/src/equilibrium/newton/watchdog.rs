//! Progress of Newton's method, and the way back where there is none.
//!
//! The merit is φ(u) = E(u) + ρ Σᵢ (−c_i(u))₊, with rows projected at u and ρ twice the largest multiplier so far; with friction, it
//! has Σ τ |Δs|, too. An
//! iteration is progress if it lowers φ below its value at the best state, or if Newton's step, unshortened, is at most
//! 1 − s/2 times as long as the shortest one before, where s is the share of its step that the iteration before took: a half
//! after a whole step. The second condition is there since forces along averaged normals have no potential: near an
//! equilibrium φ may rise, along Newton's direction, too. It is the natural monotonicity of P. Deuflhard, *Newton Methods for
//! Nonlinear Problems*, 2004: the step that is left after the share s is 1 − s of it, to first order. A few iterations may
//! pass without progress; then the method returns to the best state and takes a shorter step from there (the watchdog
//! technique of Chamberlain, Powell, Lemaréchal and Pedersen, 1982), and lengths are compared with that of the step there. The
//! merit costs nothing as long as that does not happen.

use super::point::Point;

/// So many iterations may pass without progress.
const PATIENCE: usize = 3;
/// The penalty ρ over the largest multiplier: above 1, φ is exact.
const PENALTY: f64 = 2.0;

/// What the iterations of one load step have reached.
pub(super) struct Watchdog {
    best: Best,
    /// Iterations since, the share of its step that the first of them took, and the relative length of that step.
    idle: usize,
    left_by: f64,
    left_length: Option<f64>,
    /// The share of its step that the last iteration took.
    last: f64,
    /// The relative length of the shortest step that made progress; infinite before the first step.
    shortest: f64,
    /// The largest share of a step that may be taken.
    limit: f64,
    /// ρ (UF).
    penalty: f64,
}

/// The start, or the state of the last progress.
struct Best {
    point: Point,
    merit: Merit,
}

/// The terms of φ.
struct Merit {
    /// E(u), and the work of friction at its thresholds (UF·UL).
    energy: f64,
    /// Σᵢ (−c_i(u))₊ (UL).
    overlap: f64,
}

impl Watchdog {
    /// At the start, with energy E there.
    pub fn new(start: &Point, energy: f64) -> Self {
        Watchdog {
            best: Best {
                point: start.clone(),
                merit: Merit::new(start, energy),
            },
            idle: 0,
            left_by: 1.0,
            left_length: None,
            last: 1.0,
            shortest: f64::INFINITY,
            limit: 1.0,
            penalty: 0.0,
        }
    }

    /// The largest share of the next step that may be taken.
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Judges a step, this `share` of Newton's, that led to `point` with energy E. `length` is the relative length of Newton's
    /// step, if it tells. Returns the state to go back to, if it is time.
    pub fn judge(
        &mut self,
        point: &Point,
        energy: f64,
        share: f64,
        length: Option<f64>,
    ) -> Option<Point> {
        let lambda = point.lambda.iter().take(point.slips.contacts());
        self.penalty = lambda.fold(self.penalty, |penalty, l| penalty.max(PENALTY * l));
        let merit = Merit::new(point, energy);
        let [now, then] = [&merit, &self.best.merit].map(|merit| merit.value(self.penalty));
        let is_first = self.shortest == f64::INFINITY;
        let shorter = (1.0 - 0.5 * self.last) * self.shortest;
        let is_shorter = length.is_some_and(|length| length <= shorter);
        self.last = share;
        if is_first || is_shorter {
            self.shortest = length.unwrap_or(self.shortest);
        }
        if now < then || (is_shorter && !is_first) {
            self.best = Best {
                point: point.clone(),
                merit,
            };
            self.idle = 0;
            self.limit = (2.0 * self.limit).min(1.0);
            return None;
        }
        if self.idle == 0 {
            (self.left_by, self.left_length) = (share, length);
        }
        self.idle += 1;
        match self.idle > PATIENCE {
            true => self.retreat(),
            false => None,
        }
    }

    /// The best state, unless it is the present one; the next step is half as long at most as the one that left it.
    pub fn retreat(&mut self) -> Option<Point> {
        if self.idle == 0 {
            return None;
        }
        self.idle = 0;
        self.limit = 0.5 * self.left_by;
        self.shortest = self.left_length.unwrap_or(self.shortest);
        // its length is not compared with itself
        self.last = 1.0;
        Some(self.best.point.clone())
    }
}

impl Merit {
    fn new(point: &Point, energy: f64) -> Self {
        let mut c = vec![0.0; point.gaps.len()];
        point.gaps.value(&point.state.u, &mut c);
        let contacts = c.iter().take(point.slips.contacts());
        Merit {
            energy: energy + point.slips.work(&point.lambda, &c),
            overlap: contacts.map(|c| (-c).max(0.0)).sum(),
        }
    }

    /// φ with this ρ.
    fn value(&self, penalty: f64) -> f64 {
        self.energy + penalty * self.overlap
    }
}

#[cfg(test)]
mod tests {
    use super::super::slips::Slips;
    use super::*;
    use crate::{LinearGaps, State};

    fn point(u: f64) -> Point {
        Point {
            state: State {
                u: vec![u],
                ..State::default()
            },
            gaps: LinearGaps::new(false),
            slips: Slips::default(),
            lambda: Vec::new(),
        }
    }

    /// The states to which it returns, for iterations uphill with these shares and lengths of Newton's steps.
    fn returns(steps: &[(f64, f64)]) -> Vec<Option<f64>> {
        let mut watchdog = Watchdog::new(&point(0.0), 0.0);
        let mut at = 0.0;
        let judged = steps.iter().enumerate().map(|(k, &(share, length))| {
            at += share * length;
            let back = watchdog.judge(&point(at), 1.0 + k as f64, share, Some(length));
            let back = back.map(|best| best.state.u[0]);
            at = back.unwrap_or(at);
            back
        });
        judged.collect()
    }

    /// What is left of a step after a share of it is progress although the merit rises; a step that stays as long is none.
    #[test]
    fn shares_of_steps_are_progress_where_they_shorten_the_step() {
        let whole = [(1.0, 8.0), (1.0, 8.0), (1.0, 8.0), (1.0, 8.0)];
        assert_eq!(returns(&whole), [None, None, None, Some(0.0)]);
        // from the best state the same step again, an eighth of it, and from there on what is left
        let shares = [
            (0.125, 8.0),
            (0.125, 7.0),
            (0.125, 6.125),
            (0.125, 5.4),
            (0.125, 4.7),
            (0.125, 4.1),
        ];
        let after = returns(&[&whole[..], &shares].concat());
        assert!(after[4..].iter().all(Option::is_none), "{after:?}");
        let same = shares.map(|(share, _)| (share, 8.0));
        let after = returns(&[&whole[..], &same].concat());
        assert_eq!(after[4..], [None, None, None, Some(0.0), None, None]);
        // whole steps must be half as long
        let slowly = [(1.0, 8.0), (1.0, 5.0), (1.0, 4.5), (1.0, 4.1)];
        assert_eq!(returns(&slowly), [None, None, None, Some(0.0)]);
        let fast = [(1.0, 8.0), (1.0, 4.0), (1.0, 2.0), (1.0, 1.0), (1.0, 0.5)];
        assert!(returns(&fast).iter().all(Option::is_none));
    }
}
