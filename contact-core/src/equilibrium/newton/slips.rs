//! Friction in Newton's method: rows of slips after those of contact.
//!
//! At u itself, friction adds the forces Tᵀz to those of contact, −τ ≤ z ≤ τ, with τ = μ λ of the row of contact that presses
//! there. A step solves contact and friction of the linearised rows together, with the thresholds of its own multipliers. The forces Tᵀz vary with
//! u as Cᵀλ does. Slips are taken from rows that are held within a step, which loses nothing: a node that sticks has no slip, and of a
//! node that slips the sign alone counts.

use std::borrow::Cow;
use std::collections::HashMap;

use super::super::StepContext;
use super::super::condensed::coulomb::Law;
use super::super::condensed::halt::Halt;
use crate::friction::{Friction, SlipRows};
use crate::gaps::Row;
use crate::{ContactProblem, LinearGaps, Multipliers, RowKey};

/// Rows of slips have the pass of their rows of contact and this bit.
const SLIPS: u32 = 1 << 31;
/// A force that lacks no more than this share of its threshold has reached it.
const REACHED: f64 = 1e-9;

/// Whether a key is that of a row of slips.
pub(super) fn is_of_slips(key: RowKey) -> bool {
    key.pass & SLIPS != 0
}

/// The rows of slips among all rows, which are the last ones.
#[derive(Clone, Default)]
pub(super) struct Slips {
    /// As the problem states them; nothing without friction.
    rows: Option<SlipRows>,
    /// The place of each among all rows; nothing where no free unknown moves it.
    places: Vec<Option<usize>>,
    laws: Vec<Law>,
    /// The number of rows of contact.
    contacts: usize,
}

impl Slips {
    /// Appends the rows of slips to the rows of contact at u.
    pub fn appended(
        problem: &dyn ContactProblem,
        u: &[f64],
        gaps: &mut LinearGaps,
        context: &StepContext<'_>,
    ) -> Result<Self, Halt> {
        let mut own = Slips {
            contacts: gaps.len(),
            ..Slips::default()
        };
        if !problem.has_friction() {
            return Ok(own);
        }
        Halt::if_requested(context.stop)?;
        let rows = problem.slips(u, gaps, &context.last.u, context.from)?;
        rows.check(u.len())?;
        let keys = gaps.keys().iter().enumerate();
        let presses: HashMap<RowKey, usize> = keys.map(|(i, key)| (*key, i)).collect();
        for (i, key) in rows.keys().iter().enumerate() {
            let slip = rows.row(i);
            let moves = slip.free.iter().any(|(_, a)| *a != 0.0);
            let contact = presses.get(key).filter(|_| moves);
            own.places.push(contact.map(|_| gaps.len()));
            let Some(&contact) = contact else { continue };
            own.laws.push(Law {
                slip: gaps.len(),
                contact,
                factor: slip.coefficient,
                bound: slip.bound,
            });
            let row = Row {
                free: slip.free,
                prescribed: slip.prescribed,
                constant: slip.constant,
                ..Row::default()
            };
            let pass = key.pass | SLIPS;
            gaps.push(RowKey { pass, ..*key }, &row);
        }
        own.rows = Some(rows);
        Ok(own)
    }

    /// The number of rows of contact, which are the first.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// The laws of all rows of slips.
    pub fn laws(&self) -> &[Law] {
        &self.laws
    }

    /// The law of a row, if it is one of slips.
    pub fn law(&self, row: usize) -> Option<&Law> {
        row.checked_sub(self.contacts).map(|k| &self.laws[k])
    }

    /// Appends, to `rows` of contact, the rows of slips that they press on.
    pub fn append_pressed(&self, rows: &mut Vec<usize>) {
        let presses: Vec<usize> = rows.clone();
        let pressed = self
            .laws
            .iter()
            .filter(|law| presses.binary_search(&law.contact).is_ok());
        rows.extend(pressed.map(|law| law.slip));
    }

    /// The laws of the rows of slips among `rows`, which ascend, by their places there.
    pub fn laws_among(&self, rows: &[usize]) -> Vec<Law> {
        let place = |row: usize| rows.binary_search(&row).ok();
        let placed = self.laws.iter().map(|law| law.placed(place));
        placed.flatten().collect()
    }

    /// Multipliers of all rows: what is below zero of contact, and what is beyond a threshold of friction, is cut.
    pub fn cut(&self, lambda: &mut [f64]) {
        let (contact, slips) = lambda.split_at_mut(self.contacts);
        contact.iter_mut().for_each(|l| *l = l.max(0.0));
        for (z, law) in slips.iter_mut().zip(&self.laws) {
            let tau = law.threshold(contact[law.contact]);
            *z = z.clamp(-tau, tau);
        }
    }

    /// The same, where multipliers are no longer what they were `before`: a force that had reached its threshold reaches the new one.
    pub fn follow(&self, before: &[f64], lambda: &mut [f64]) {
        self.cut(lambda);
        for law in &self.laws {
            let reaches = self.lets_go(law.slip, before) && before[law.slip] != 0.0;
            if reaches {
                let tau = law.threshold(lambda[law.contact]);
                lambda[law.slip] = tau.copysign(before[law.slip]);
            }
        }
    }

    /// Whether a node slips by more than `bound` (UL), and its force is not at the threshold against it.
    pub fn violates(&self, law: &Law, slip: f64, lambda: &[f64], bound: f64) -> bool {
        let pressed = lambda[law.contact];
        let lacks = law.lacks(lambda[law.slip], slip, pressed);
        slip.abs() > bound && lacks > REACHED * law.threshold(pressed)
    }

    /// The multipliers, with a one for each node that sticks and zero for one that slips: rows with a positive number hold motions. A node that slips goes on
    /// with the same force.
    pub fn holding<'a>(&self, lambda: &'a [f64]) -> Cow<'a, [f64]> {
        if self.laws.is_empty() {
            return Cow::Borrowed(lambda);
        }
        let mut held = lambda.to_vec();
        for law in &self.laws {
            held[law.slip] = if self.lets_go(law.slip, lambda) {
                0.0
            } else {
                1.0
            };
        }
        Cow::Owned(held)
    }

    /// Whether nothing holds a row: contact without a force, or a force at its threshold.
    pub fn lets_go(&self, row: usize, lambda: &[f64]) -> bool {
        match self.law(row) {
            None => lambda[row] <= 0.0,
            Some(law) => {
                let tau = law.threshold(lambda[law.contact]);
                lambda[row].abs() >= (1.0 - REACHED) * tau
            }
        }
    }

    /// Σ τ |Δs| at these slips (UF·UL).
    pub fn work(&self, lambda: &[f64], slips: &[f64]) -> f64 {
        let work = |law: &Law| law.threshold(lambda[law.contact]) * slips[law.slip].abs();
        self.laws.iter().map(work).sum()
    }

    /// The rows of contact alone.
    pub fn contact_rows<'a>(&self, gaps: &'a LinearGaps) -> Cow<'a, LinearGaps> {
        if gaps.len() == self.contacts {
            return Cow::Borrowed(gaps);
        }
        let mut own = LinearGaps::new(gaps.is_exact()).sampled_at(gaps.sampling());
        (0..self.contacts).for_each(|i| own.push(gaps.keys()[i], &gaps.row(i)));
        Cow::Owned(own)
    }

    /// What a solution tells of friction, with the multipliers of all rows; nothing without.
    pub fn friction(
        self,
        lambda: &[f64],
        multipliers: &Multipliers,
        context: &StepContext<'_>,
    ) -> Option<Friction> {
        let force = |i: usize| self.places[i].map(|row| -lambda[row]);
        let rows = self.rows?;
        Some(Friction::at(rows, multipliers, force, context))
    }
}
