//! The search for thresholds: unknowns of a fixed point, beside the displacements.

use super::{Friction, SlipRows, Thresholds, touching};
use crate::equilibrium::relative_change;
use crate::{LinearGaps, Multipliers, Scale, State};

/// The thresholds of the iterations at one load.
pub(crate) struct Search {
    /// Thresholds of the next iteration, by the keys of their rows; `None` before the first.
    next: Option<Multipliers>,
    /// Thresholds by the multipliers of the last iterate (p, UF), and how far the forces that friction can exert have changed with them (n, UF).
    renewed: Vec<f64>,
    change: Vec<f64>,
    /// Whether they are averaged.
    averages: bool,
    /// Whether nothing accelerates the iteration.
    pub is_plain: bool,
}

impl Search {
    /// So many iterations are accelerated at most, and the limit of iterations is so many times as large.
    pub const ACCELERATED: usize = 15;
    pub const LIMIT: usize = 3;
    /// The relative change of forces that is accepted, or the tolerance of u if that is larger.
    pub const LAWFUL: f64 = 1e-6;
    /// Thresholds are averaged in a plain iteration, and where u changes by less: multipliers of both passes are not unique, and may change
    /// without end while u does not.
    const SETTLED: f64 = 1e-6;
    /// The share of a force of friction that the next threshold allows at least where a row is closed, if the force is above the second share of the
    /// largest: a smaller one could let go at once what another one would still hold.
    const LETS_GO: f64 = 0.5;
    const HOLDS: f64 = 1e-2;

    /// Before the first iteration.
    pub fn new(is_plain: bool) -> Self {
        Search {
            next: None,
            renewed: Vec::new(),
            change: Vec::new(),
            averages: is_plain,
            is_plain,
        }
    }

    /// The thresholds for these slips and the rows of their gaps, made at `point`.
    pub fn thresholds(
        &self,
        rows: SlipRows,
        gaps: &LinearGaps,
        (point, scale): (&State, &Scale),
    ) -> Thresholds {
        match &self.next {
            Some(known) => Thresholds::known(rows, known),
            None => Thresholds::first(rows, gaps, point, scale),
        }
    }

    /// Whether the thresholds of the last iterate were a guess.
    pub fn was_guessed(&self) -> bool {
        self.next.is_none()
    }

    /// Makes the thresholds by the multipliers of an iterate, at which u has changed by the share `error`, and returns their own relative change.
    pub fn renew(&mut self, friction: &Friction, multipliers: &Multipliers, error: f64) -> f64 {
        self.averages = self.is_plain || error < Self::SETTLED;
        self.renewed = friction.rows.thresholds(|key| multipliers.of(key));
        let n = friction.last.len();
        let [now, then] = [&self.renewed, &friction.thresholds]
            .map(|thresholds| friction.rows.capacities(thresholds, n));
        let pairs = now.iter().zip(&then);
        self.change = pairs.map(|(now, then)| now - then).collect();
        relative_change(&now, &then, 0.0)
    }

    /// Appends residual and image of the thresholds to a residual and an image of u, in the unit of u: `unit` is its ratio to the unit of forces (UL/UF).
    pub fn append(&self, unit: f64, residual: &mut Vec<f64>, image: &mut Vec<f64>) {
        residual.extend(self.change.iter().map(|force| force * unit));
        image.extend(self.renewed.iter().map(|threshold| threshold * unit));
    }

    /// Takes the thresholds that are proposed (p, UF) after the last iterate, with its rows that are closed; false where some of them are taken larger.
    pub fn take(
        &mut self,
        proposed: impl Iterator<Item = f64>,
        friction: &Friction,
        (gaps, u, scale): (&LinearGaps, &[f64], &Scale),
    ) -> bool {
        let closed = touching(gaps, u, scale);
        let forces = friction.forces.iter().map(|force| force.abs());
        let largest = forces.clone().fold(0.0, f64::max);
        let mut is_free = true;
        let rows = friction.rows.keys().iter().zip(forces);
        let rows = rows.zip(&friction.thresholds).zip(proposed);
        let next = rows.map(|(((&key, force), used), proposed)| {
            let proposed = match self.averages {
                true => 0.5 * (proposed + used),
                false => proposed,
            };
            let holds = force > Self::HOLDS * largest && closed.binary_search(&key).is_ok();
            let least = if holds { Self::LETS_GO * force } else { 0.0 };
            is_free &= proposed >= least;
            (key, proposed.max(least))
        });
        self.next = Some(next.collect());
        is_free
    }
}
