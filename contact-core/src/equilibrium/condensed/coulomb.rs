//! Coulomb's law on condensed rows: the limits of friction follow the forces of contact.
//!
//! Beside contact, 0 ≤ λ ⟂ c ≥ 0, a row of slips has the gap s, its slip, and the multiplier z, the force of friction along it:
//!
//! |z| ≤ τ,   z = −τ where s > 0,   z = τ where s < 0,   τ = min(m λ_k, b),
//!
//! with the row k of contact that presses on it. For given τ that is a convex problem between limits, which
//! [`complementarity`] solves from any start. Coulomb's law is a fixed point of τ, and a system of equations that
//! are smooth by pieces: each row of contact is closed or open, and each row of slips sticks or slips to one of two sides.
//! Newton's method on them ends after a few steps, where its pieces are those of the solution. So the solution of the convex problem is
//! where Newton's method starts; where that does not end, the next thresholds are tried.

use faer::linalg::solvers::Solve;
use faer::{Col, Mat};

use super::complementarity::{
    Complementary, OF_CONTACT, clamped, lengths, natural, solve, solve_between,
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
}

/// The limits of thresholds and of Newton's steps after each.
const ROUNDS: usize = 60;
const STEPS: usize = 12;
/// From this round on, thresholds are the mean of the last ones and those by the multipliers of the convex problem.
const AVERAGES: usize = 8;
/// ε of Newton's method, relative to the diagonal of W: rows may depend on each other.
const EPSILON: f64 = 1e-9;
/// The round-off of the gaps, relative to the largest one of the start.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;

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
    let m = gaps.len();
    let lengths = lengths(W, gaps)?;
    let largest = gaps.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let mut law_of = vec![None; m];
    laws.iter().for_each(|law| law_of[law.slip] = Some(*law));
    let problem = Coulomb {
        W,
        gaps,
        start,
        law_of: &law_of,
        lengths,
        bound: bound.max(ROUNDOFF * largest),
    };
    problem.solve(stop)
}

/// The problem with its law for each row of slips.
struct Coulomb<'a> {
    W: &'a Mat<f64>,
    gaps: &'a [f64],
    start: &'a [f64],
    law_of: &'a [Option<Law>],
    /// √W_ii.
    lengths: Vec<f64>,
    bound: f64,
}

/// What a row does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    /// Its multiplier is zero.
    Free,
    /// Its gap, or its slip, is zero.
    Closed,
    /// Its multiplier is the threshold, with this sign.
    Slips(f64),
}

impl Coulomb<'_> {
    fn solve(&self, stop: &Stop) -> Result<Complementary, Halt> {
        let is_known =
            (0..self.gaps.len()).any(|i| self.law_of[i].is_none() && self.start[i] > 0.0);
        let first = |law: &Law| match is_known {
            true => law.threshold(self.start[law.contact]),
            false if self.gaps[law.contact] <= self.bound => f64::INFINITY,
            false => 0.0,
        };
        let mut thresholds: Vec<f64> = self.law_of.iter().flatten().map(first).collect();
        let mut best: Option<(Col<f64>, f64)> = None;
        let mut steps = 0;
        let mut lambda = Col::from_fn(self.start.len(), |i| self.start[i]);
        for round in 0..ROUNDS {
            let gaps = self.gaps_at(&lambda);
            let mut taus = thresholds.iter();
            let limits: Vec<[f64; 2]> = (self.law_of.iter())
                .map(|law| match law.is_some().then(|| taus.next()).flatten() {
                    Some(tau) => [-tau, *tau],
                    None => OF_CONTACT,
                })
                .collect();
            let lists = [&gaps, &lambda].map(|list| list.iter().copied().collect::<Vec<_>>());
            let [gaps, from] = &lists;
            let between = solve_between(self.W, gaps, from, |i| limits[i], self.bound, stop)?;
            steps += between.steps;
            lambda = Col::from_fn(from.len(), |i| between.lambda[i]);
            let mut found = (lambda.clone(), self.left(&lambda));
            if found.1 > 1.0 {
                let (refined, more) = self.newton(&lambda, stop)?;
                steps += more;
                if refined.1 < found.1 {
                    found = refined;
                }
            }
            if best.as_ref().is_none_or(|best| found.1 < best.1) {
                best = Some(found);
            }
            if best.as_ref().is_some_and(|best| best.1 <= 1.0) {
                break;
            }
            let laws = self.law_of.iter().flatten().zip(&mut thresholds);
            laws.for_each(|(law, tau)| {
                let next = law.threshold(lambda[law.contact]);
                *tau = match round >= AVERAGES {
                    true => 0.5 * (next + *tau),
                    false => next,
                };
            });
        }
        let (lambda, left) = best.ok_or_else(|| Halt::Failed("no thresholds were tried".into()))?;
        if !left.is_finite() {
            return Err(Halt::Failed(
                "the multipliers of the condensed problem are not finite".into(),
            ));
        }
        Ok(Complementary {
            lambda: lambda.iter().copied().collect(),
            steps,
            left,
        })
    }

    /// c at these multipliers (UL).
    fn gaps_at(&self, lambda: &Col<f64>) -> Col<f64> {
        let mut gaps = Col::from_fn(self.gaps.len(), |i| self.gaps[i]);
        for (j, (l, first)) in lambda.iter().zip(self.start).enumerate() {
            let change = l - first;
            if change != 0.0 {
                let column = self.W.col_as_slice(j);
                gaps.iter_mut()
                    .zip(column)
                    .for_each(|(c, w)| *c += w * change);
            }
        }
        gaps
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
    fn left(&self, lambda: &Col<f64>) -> f64 {
        let gaps = self.gaps_at(lambda);
        let mut worst = 0.0;
        for (i, length) in self.lengths.iter().enumerate() {
            let limits = self.limits(i, lambda).map(|limit| limit * length);
            let left = natural(lambda[i] * length, gaps[i] / length, limits) * length;
            // NaN counts
            if !(left <= worst) {
                worst = left;
            }
        }
        worst / self.bound
    }

    /// What each row does, by its multiplier and its gap.
    fn pieces(&self, lambda: &Col<f64>, gaps: &Col<f64>) -> Vec<Piece> {
        let at = |i: usize| lambda[i] - gaps[i] / (self.lengths[i] * self.lengths[i]);
        let piece = |i: usize| match &self.law_of[i] {
            None if at(i) > 0.0 => Piece::Closed,
            None => Piece::Free,
            Some(law) => {
                let pressed = at(law.contact);
                let tau = law.threshold(lambda[law.contact]);
                match at(i) {
                    _ if !(pressed > 0.0 && law.factor > 0.0) => Piece::Free,
                    above if above >= tau => Piece::Slips(1.0),
                    below if below <= -tau => Piece::Slips(-1.0),
                    _ => Piece::Closed,
                }
            }
        };
        (0..gaps.nrows()).map(piece).collect()
    }

    /// Newton's method from these multipliers until its pieces repeat: the best multipliers with what they leave, and the number of steps.
    fn newton(&self, from: &Col<f64>, stop: &Stop) -> Result<((Col<f64>, f64), usize), Halt> {
        let mut lambda = from.clone();
        let mut best = (lambda.clone(), self.left(&lambda));
        let mut last = Vec::new();
        for step in 0..STEPS {
            Halt::if_requested(stop)?;
            let gaps = self.gaps_at(&lambda);
            let pieces = self.pieces(&lambda, &gaps);
            let repeats = pieces == last;
            lambda = self.step(&lambda, &gaps, &pieces);
            let lawful = Col::from_fn(lambda.nrows(), |i| match &self.law_of[i] {
                None => lambda[i].max(0.0),
                Some(_) => clamped(lambda[i], self.limits(i, &lambda)),
            });
            let left = self.left(&lawful);
            let is_better = left < best.1;
            if is_better {
                best = (lawful, left);
            }
            if best.1 <= 1.0 || !left.is_finite() || repeats && !is_better {
                return Ok((best, step + 1));
            }
            last = pieces;
        }
        Ok((best, STEPS))
    }

    /// The multipliers at which closed rows have no gap, and the others what their pieces say.
    fn step(&self, lambda: &Col<f64>, gaps: &Col<f64>, pieces: &[Piece]) -> Col<f64> {
        let rows = 0..pieces.len();
        let closed: Vec<usize> = rows
            .clone()
            .filter(|&i| pieces[i] == Piece::Closed)
            .collect();
        // the change of the multipliers of the other rows, as far as it is known, and the closed row that it follows
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
        let mut left = gaps.clone();
        for (j, change) in change.iter().enumerate().filter(|(_, d)| **d != 0.0) {
            let column = self.W.col_as_slice(j);
            left.iter_mut()
                .zip(column)
                .for_each(|(c, w)| *c += w * change);
        }
        let k = closed.len();
        let scale = |a: usize| self.lengths[closed[a]];
        let mut H = Mat::from_fn(k, k, |a, b| self.W[(closed[a], closed[b])]);
        for &(i, b, factor) in &follows {
            closed
                .iter()
                .enumerate()
                .for_each(|(a, &row)| H[(a, b)] += self.W[(row, i)] * factor);
        }
        for a in 0..k {
            for b in 0..k {
                H[(a, b)] /= scale(a) * scale(b);
            }
            H[(a, a)] += EPSILON;
        }
        let mut x = Col::from_fn(k, |a| -left[closed[a]] / scale(a));
        if k > 0 {
            H.partial_piv_lu().solve_in_place(x.as_mat_mut());
        }
        for (a, &i) in closed.iter().enumerate() {
            change[i] = x[a] / scale(a);
        }
        follows
            .iter()
            .for_each(|&(i, b, factor)| change[i] += factor * change[closed[b]]);
        lambda + change
    }
}
