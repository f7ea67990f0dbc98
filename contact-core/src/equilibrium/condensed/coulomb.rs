//! Coulomb's law on condensed rows: the limits of friction follow the forces of contact.
//!
//! Beside contact, 0 ≤ λ ⟂ c ≥ 0, a row of slips has the gap s, its slip, and the multiplier z, the force of friction along it:
//!
//! |z| ≤ τ,   z = −τ where s > 0,   z = τ where s < 0,   τ = min(m λ_k, b),
//!
//! with the row k of contact that presses on it. For given τ that is a convex problem between limits, as
//! [`complementarity`](super::complementarity) solves. Coulomb's law is a system of equations that are smooth by pieces: each row of
//! contact is closed or open, and each row of slips sticks or slips to one of two sides.
//!
//! The rounds have an ε that shrinks, as the rounds of the convex problem have. The proximal point of λ̄ satisfies
//!
//! ε λ = (ε λ̄ − c)₊,   ε z = P(ε z̄ − s), the nearest value between −ε τ(λ) and ε τ(λ).
//!
//! Newton's method on these equations solves a system for the closed rows, which is not symmetric, since z = ±m λ_k where a node
//! slips. It ends where its pieces repeat. Where it does not end, the round takes the convex problem with the thresholds of λ̄.

use faer::linalg::solvers::Solve;
use faer::{Col, Mat};

use super::complementarity::{
    Complementary, FIRST, LAST, OF_CONTACT, Proximal, RATIO, clamped, natural, solve,
};
use super::halt::Halt;
use crate::Stop;

/// How strong the friction of a row of slips is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::equilibrium) struct Law {
    /// The row of slips, and the row of contact that presses on it.
    pub slip: usize,
    pub contact: usize,
    /// m: the threshold over the multiplier of contact.
    pub factor: f64,
    /// b: the largest threshold (UF).
    pub bound: f64,
}

impl Law {
    /// τ for this multiplier of contact (UF).
    pub fn threshold(&self, lambda: f64) -> f64 {
        (self.factor * lambda.max(0.0)).min(self.bound)
    }

    /// What the force z lacks to the threshold against a slip (UF): a node that slips lacks nothing.
    pub fn lacks(&self, z: f64, slip: f64, lambda: f64) -> f64 {
        self.threshold(lambda) + z * slip.signum()
    }

    /// The same law for rows at other places; nothing if one of them has none.
    pub fn placed(&self, place: impl Fn(usize) -> Option<usize>) -> Option<Law> {
        let (slip, contact) = (place(self.slip)?, place(self.contact)?);
        Some(Law {
            slip,
            contact,
            ..*self
        })
    }
}

/// The limits of sweeps, each of which begins with other thresholds, of rounds in a sweep, and of Newton's steps in a round.
const SWEEPS: usize = 20;
const ROUNDS: usize = 20;
const STEPS: usize = 20;

/// As [`solve`], for rows of which some have friction by these laws. Where no multiplier is known, rows that touch stick at first.
pub(in crate::equilibrium) fn solve_coulomb(
    W: &Mat<f64>,
    gaps: &[f64],
    start: &[f64],
    laws: &[Law],
    bound: f64,
    stop: &Stop,
) -> Result<Complementary, Halt> {
    if laws.is_empty() {
        return solve(W, gaps, start, bound, stop);
    }
    let proximal = Proximal::new(W, gaps, start, bound)?;
    let lengths = proximal.lengths();
    let mut law_of = vec![None; gaps.len()];
    for law in laws {
        let [slip, contact] = [law.slip, law.contact].map(|row| lengths[row]);
        law_of[law.slip] = Some(Law {
            factor: law.factor * slip / contact,
            bound: law.bound * slip,
            ..*law
        });
    }
    let mut coulomb = Coulomb { proximal, law_of };
    let left = coulomb.solve(stop)?;
    coulomb.proximal.finished(left)
}

/// The problem with unit diagonal, and the law of each row of slips.
struct Coulomb {
    proximal: Proximal,
    law_of: Vec<Option<Law>>,
}

/// What a row does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    /// Its multiplier is zero.
    Free,
    /// Its gap, or its slip, is zero, up to ε times the change of its multiplier.
    Closed,
    /// Its multiplier is the threshold, with this sign.
    Slips(f64),
}

impl Coulomb {
    /// What is left of contact and Coulomb's law, over the bound.
    fn solve(&mut self, stop: &Stop) -> Result<f64, Halt> {
        let at = &self.proximal;
        let mut best = (at.center.clone(), at.gaps.clone(), f64::INFINITY);
        let mut is_known = self.presses();
        for sweep in 0..SWEEPS {
            if sweep > 0 {
                // rounds that follow Coulomb's law at once come back, or do not end
                self.limit(true, true);
                self.proximal.solve(stop)?;
            }
            // from multipliers that are known, a smaller one took up to a thousand times as many steps
            let mut epsilon = FIRST;
            for _ in 0..ROUNDS {
                let at = &self.proximal;
                let left = self.left(&at.center, &at.gaps);
                if left < best.2 {
                    best = (at.center.clone(), at.gaps.clone(), left);
                }
                if left <= 1.0 {
                    self.settle();
                    let at = &self.proximal;
                    return Ok(self.left(&at.center, &at.gaps));
                }
                let point = match is_known {
                    true => self.newton(epsilon, stop)?,
                    false => None,
                };
                match point {
                    Some(z) => self.take(z),
                    None => {
                        self.limit(is_known, false);
                        self.proximal.round(epsilon, stop)?;
                    }
                }
                is_known = true;
                epsilon = (RATIO * epsilon).max(LAST);
            }
        }
        (self.proximal.center, self.proximal.gaps) = (best.0, best.1);
        Ok(best.2)
    }

    /// Whether some row of contact has a force.
    fn presses(&self) -> bool {
        let mut rows = self.law_of.iter().zip(self.proximal.center.iter());
        rows.any(|(law, l)| law.is_none() && *l > 0.0)
    }

    /// Sets the limits of friction by the forces of contact, or halfway there, or so that rows stick that touch.
    fn limit(&mut self, is_known: bool, averages: bool) {
        let at = &mut self.proximal;
        for (i, law) in self.law_of.iter().enumerate() {
            let Some(law) = law else { continue };
            let gap = at.gaps[law.contact] * at.lengths()[law.contact];
            let tau = match is_known {
                true if averages && at.limits[i][1].is_finite() => {
                    0.5 * (law.threshold(at.center[law.contact]) + at.limits[i][1])
                }
                true => law.threshold(at.center[law.contact]),
                false if gap <= at.bound => f64::INFINITY,
                false => 0.0,
            };
            at.limits[i] = [-tau, tau];
        }
    }

    /// The limits of a row at these multipliers.
    fn limits(&self, i: usize, lambda: &Col<f64>) -> [f64; 2] {
        match &self.law_of[i] {
            Some(law) => {
                let tau = law.threshold(lambda[law.contact]);
                [-tau, tau]
            }
            None => OF_CONTACT,
        }
    }

    /// What is left of contact and Coulomb's law, over the bound.
    fn left(&self, lambda: &Col<f64>, gaps: &Col<f64>) -> f64 {
        let mut worst = 0.0;
        for (i, length) in self.proximal.lengths().iter().enumerate() {
            let left = natural(lambda[i], gaps[i], self.limits(i, lambda)) * length;
            // NaN counts
            if !(left <= worst) {
                worst = left;
            }
        }
        worst / self.proximal.bound
    }

    /// λ̄ becomes what is lawful of z.
    fn take(&mut self, z: Col<f64>) {
        let mut lambda = Col::from_fn(z.nrows(), |i| z[i].max(0.0));
        for i in (0..z.nrows()).filter(|&i| self.law_of[i].is_some()) {
            lambda[i] = clamped(z[i], self.limits(i, &lambda));
        }
        let at = &mut self.proximal;
        at.gaps = &at.gaps + at.product(&(&lambda - &at.center));
        at.center = lambda;
    }

    /// Forces on gaps and slips beyond the bound become what the law says: what they lack moves rows by no more than the bound.
    fn settle(&mut self) {
        let at = &self.proximal;
        let mut lambda = at.center.clone();
        let beyond = |i: usize| at.gaps[i].abs() * at.lengths()[i] > at.bound;
        let rows = 0..lambda.nrows();
        for i in rows.clone().filter(|&i| self.law_of[i].is_none()) {
            if beyond(i) && at.gaps[i] > 0.0 {
                lambda[i] = 0.0;
            }
        }
        for i in rows.filter(|&i| self.law_of[i].is_some()) {
            let [low, high] = self.limits(i, &lambda);
            lambda[i] = match beyond(i) {
                true if at.gaps[i] > 0.0 => low,
                true => high,
                false => clamped(lambda[i], [low, high]),
            };
        }
        let at = &mut self.proximal;
        at.gaps = &at.gaps + at.product(&(&lambda - &at.center));
        at.center = lambda;
    }

    /// What each row does at the multipliers λ with the gaps c, on the way to the proximal point of λ̄.
    fn pieces(&self, epsilon: f64, lambda: &Col<f64>, gaps: &Col<f64>) -> Vec<Piece> {
        let center = &self.proximal.center;
        let at = |i: usize| center[i] - gaps[i] / epsilon;
        let piece = |i: usize| match &self.law_of[i] {
            None if at(i) > 0.0 => Piece::Closed,
            None => Piece::Free,
            Some(law) if !(at(law.contact) > 0.0 && law.factor > 0.0) => Piece::Free,
            Some(law) => {
                let tau = law.threshold(lambda[law.contact]);
                match at(i) {
                    above if above >= tau => Piece::Slips(1.0),
                    below if below <= -tau => Piece::Slips(-1.0),
                    _ => Piece::Closed,
                }
            }
        };
        (0..gaps.nrows()).map(piece).collect()
    }

    /// The proximal point of λ̄ by Newton's method; nothing where its pieces do not repeat.
    fn newton(&mut self, epsilon: f64, stop: &Stop) -> Result<Option<Col<f64>>, Halt> {
        let mut lambda = self.proximal.center.clone();
        let mut gaps = self.proximal.gaps.clone();
        let mut last = Vec::new();
        for _ in 0..STEPS {
            Halt::if_requested(stop)?;
            let pieces = self.pieces(epsilon, &lambda, &gaps);
            if pieces == last {
                return Ok(Some(lambda));
            }
            self.proximal.steps += 1;
            let (change, moved) = self.step(epsilon, &lambda, &gaps, &pieces);
            if !(change.is_all_finite() && moved.is_all_finite()) {
                return Ok(None);
            }
            (lambda, gaps) = (lambda + change, gaps + moved);
            last = pieces;
        }
        Ok(None)
    }

    /// The change of the multipliers at which closed rows have the gap ε (λ̄ − λ), and the others do what their pieces say; and that of the gaps.
    fn step(
        &self,
        epsilon: f64,
        lambda: &Col<f64>,
        gaps: &Col<f64>,
        pieces: &[Piece],
    ) -> (Col<f64>, Col<f64>) {
        let Proximal { W, center, .. } = &self.proximal;
        let rows = 0..pieces.len();
        let is_closed = |i: &usize| pieces[*i] == Piece::Closed;
        let closed: Vec<usize> = rows.clone().filter(is_closed).collect();
        // the change of the other multipliers, as far as it is known, and the closed row that it follows
        let mut change = Col::zeros(pieces.len());
        let mut follows: Vec<(usize, usize, f64)> = Vec::new();
        for i in rows {
            change[i] = match (pieces[i], &self.law_of[i]) {
                (Piece::Closed, _) => 0.0,
                (Piece::Slips(sign), Some(law)) => {
                    let pressed = law.factor * lambda[law.contact];
                    if pressed <= law.bound
                        && let Ok(k) = closed.binary_search(&law.contact)
                    {
                        follows.push((i, k, sign * law.factor));
                    }
                    sign * pressed.min(law.bound) - lambda[i]
                }
                _ => -lambda[i],
            };
        }
        let mut moved = self.proximal.product(&change);
        let k = closed.len();
        let mut H = Mat::from_fn(k, k, |a, b| W[(closed[a], closed[b])]);
        for &(i, b, factor) in &follows {
            for (a, &row) in closed.iter().enumerate() {
                H[(a, b)] += W[(row, i)] * factor;
            }
        }
        (0..k).for_each(|a| H[(a, a)] += epsilon);
        let left = |i: usize| gaps[i] + moved[i] + epsilon * (lambda[i] - center[i]);
        let mut x = Col::from_fn(k, |a| -left(closed[a]));
        if k > 0 {
            H.partial_piv_lu().solve_in_place(x.as_mat_mut());
        }
        let mut further = Col::zeros(pieces.len());
        (0..k).for_each(|a| further[closed[a]] = x[a]);
        let following = follows.iter();
        following.for_each(|&(i, b, factor)| further[i] = factor * x[b]);
        moved += self.proximal.product(&further);
        (change + further, moved)
    }
}
