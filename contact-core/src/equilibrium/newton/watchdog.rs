//! Progress of Newton's method, and the way back where there is none.
//!
//! The merit is φ(u) = E(u) + ρ Σᵢ (−c_i(u))₊, with rows projected at u and ρ twice the largest multiplier so far. An
//! iteration is progress if it lowers φ or halves the change of u. The second condition is there since forces along averaged
//! normals have no potential: near an equilibrium φ may rise. A few iterations may pass without progress; then the method
//! returns to the best state and takes a shorter step from there (the watchdog technique of Chamberlain, Powell, Lemaréchal
//! and Pedersen, 1982). The merit costs nothing as long as that does not happen.

use super::Point;

/// So many iterations may pass without progress.
const PATIENCE: usize = 3;
/// The penalty ρ over the largest multiplier: above 1, φ is exact.
const PENALTY: f64 = 2.0;

/// What the iterations of one load step have reached.
pub(super) struct Watchdog {
    best: Best,
    /// Iterations since.
    idle: usize,
    /// The largest share of a step that may be taken.
    limit: f64,
    /// ρ (UF).
    penalty: f64,
}

/// The start, or the state of the last progress.
struct Best {
    point: Point,
    merit: Merit,
    /// The relative change of u that led to it.
    change: f64,
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
                change: 1.0,
            },
            idle: 0,
            limit: 1.0,
            penalty: 0.0,
        }
    }

    /// The largest share of the next step that may be taken.
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Judges a relative change of u that led to `point`, with energy E there. Returns the state to go back to, if it is time.
    pub fn judge(&mut self, point: &Point, energy: f64, change: f64) -> Option<Point> {
        let lambda = point.lambda.iter();
        self.penalty = lambda.fold(self.penalty, |penalty, l| penalty.max(PENALTY * l));
        let merit = Merit::new(point, energy);
        let [now, then] = [&merit, &self.best.merit].map(|merit| merit.value(self.penalty));
        if now < then || change <= 0.5 * self.best.change {
            self.best = Best {
                point: point.clone(),
                merit,
                change,
            };
            self.idle = 0;
            self.limit = (2.0 * self.limit).min(1.0);
            return None;
        }
        self.idle += 1;
        if self.idle <= PATIENCE {
            return None;
        }
        self.idle = 0;
        self.limit *= 0.5;
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
