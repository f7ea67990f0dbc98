//! Progress of Newton's method, and the way back where there is none.
//!
//! The merit is φ(u) = E(u) + ρ Σᵢ (−c_i(u))₊, with rows projected at u and ρ twice the largest multiplier so far. An
//! iteration is progress if it lowers φ below its value at the best state, or if Newton's step, unshortened, is at most half
//! as long as the shortest one before. The second condition is there since forces along averaged normals have no potential:
//! near an equilibrium φ may rise. A few iterations may pass without progress; then the method returns to the best state and
//! takes a shorter step from there (the watchdog technique of Chamberlain, Powell, Lemaréchal and Pedersen, 1982). The merit
//! costs nothing as long as that does not happen.

use super::Point;

/// So many iterations may pass without progress.
const PATIENCE: usize = 3;
/// The penalty ρ over the largest multiplier: above 1, φ is exact.
const PENALTY: f64 = 2.0;

/// What the iterations of one load step have reached.
pub(super) struct Watchdog {
    best: Best,
    /// Iterations since, and the share of its step that the first of them took.
    idle: usize,
    left_by: f64,
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
    /// E(u) (UF·UL).
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
        let lambda = point.lambda.iter();
        self.penalty = lambda.fold(self.penalty, |penalty, l| penalty.max(PENALTY * l));
        let merit = Merit::new(point, energy);
        let [now, then] = [&merit, &self.best.merit].map(|merit| merit.value(self.penalty));
        let is_first = self.shortest == f64::INFINITY;
        let is_shorter = length.is_some_and(|length| length <= 0.5 * self.shortest);
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
            self.left_by = share;
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
        Some(self.best.point.clone())
    }
}

impl Merit {
    fn new(point: &Point, energy: f64) -> Self {
        let mut c = vec![0.0; point.gaps.len()];
        point.gaps.value(&point.state.u, &mut c);
        let overlap = c.iter().map(|c| (-c).max(0.0)).sum();
        Merit { energy, overlap }
    }

    /// φ with this ρ.
    fn value(&self, penalty: f64) -> f64 {
        self.energy + penalty * self.overlap
    }
}
