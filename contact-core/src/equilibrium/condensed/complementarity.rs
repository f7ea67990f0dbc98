//! 0 ≤ λ ⟂ c(λ) ≥ 0 for gaps c with a dense, positive semidefinite slope W: a proximal method of multipliers with
//! Newton's method inside.
//!
//! With c = W λ + q, λ minimises ½λᵀWλ + qᵀλ over λ ≥ 0. The proximal point of λ̄ also has ½ε|λ − λ̄|². It satisfies
//! ε λ = (ε λ̄ − c)₊, which is the minimum over z of the convex, piecewise quadratic
//!
//! ψ(z) = ½ ε zᵀWz + ½ |(ε λ̄ − c(z))₊|²,
//!
//! the augmented Lagrangian of the primal problem. Newton's method on the rows A with ε λ̄ > c moves to z_A with
//! c_A = ε (λ̄_A − z_A), the others being zero; an exact line search makes it end after finitely many steps. Rows that
//! depend on each other are harmless, since ε makes every W_AA definite. Repeating this from λ̄ = λ removes the error of
//! ε. All steps are increments: c is never the difference of large numbers.
//!
//! Friction with given thresholds has two limits, −τ ≤ λ ≤ τ, with c ≥ 0 at the lower one and c ≤ 0 at the upper one. The same holds with
//! these limits in place of 0 and ∞: (·)₊ becomes the nearest value between them, and a row of A is one strictly between them.

use std::cmp::Ordering;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::solvers::Solve;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Col, Mat, Par};

use super::halt::Halt;
use super::line_search::exact_step;
use crate::Stop;

/// ε of the first round, relative to the diagonal of W, that of the last ones, and its ratio from one round to the next.
///
/// Each round finds most of the rows that act in the next one. From 1e-9 at once, Newton's method took up to a hundred
/// times as many steps. From 0.1, most of the 3 600 rows of the linear beams act at first, and their factors cost a third of
/// the time.
pub(super) const FIRST: f64 = 0.01;
pub(super) const LAST: f64 = 1e-8;
pub(super) const RATIO: f64 = 0.1;
/// Where a round leaves more than the first share, ε shrinks further: rows that nearly depend on each other have compliances
/// below [`LAST`], beside that of a body that floats. What such an ε leaves counts if it is less than the second share of the best.
const SLOW: f64 = 0.1;
const STUCK: f64 = 0.9;
/// The least ε, relative to the largest sum of a column of W, whose round-off it is above.
const LEAST: f64 = 8.0 * f64::EPSILON;
/// ε of the first round from multipliers that are known, relative to what is left of the condition over the largest λ.
const WARM: f64 = 0.01;
/// The round-off of the gaps, relative to the largest one of the start.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;
/// A step is full within this.
const FULL: f64 = 1e-6;
/// A factor serves other rows, too, as long as no larger part of its rows than one in so many is new or gone: finding the
/// border then takes a fraction of another factor. Its solutions are kept where they are accurate to this.
const BORDER: usize = 16;
const ACCURACY: f64 = 1e-12;
/// The limits of rounds and of Newton's steps in one of them.
const ROUNDS: usize = 60;
const STEPS: usize = 100;

/// λ and what it cost.
#[derive(Debug)]
pub(in crate::equilibrium) struct Complementary {
    /// λ between its limits (m).
    pub lambda: Vec<f64>,
    /// Steps of Newton's method.
    pub steps: usize,
    /// What is left of the conditions, |min(W_ii λᵢ, cᵢ)| for contact: the largest of all rows, relative to the bound; above 1 where the rounds did not suffice.
    pub left: f64,
}

/// The limits of a multiplier of contact.
pub(super) const OF_CONTACT: [f64; 2] = [0.0, f64::INFINITY];

/// Solves from the multipliers `start` and their gaps c (m, UL) until every |min(W_ii λᵢ, cᵢ)| is within `bound` (UL), or
/// within round-off of the gaps, or until [`ROUNDS`] have passed: [`Complementary::left`] tells. `W` (m × m, UL/UF) is
/// symmetric, with both triangles.
pub(in crate::equilibrium) fn solve(
    W: &Mat<f64>,
    gaps: &[f64],
    start: &[f64],
    bound: f64,
    stop: &Stop,
) -> Result<Complementary, Halt> {
    let mut proximal = Proximal::new(W, gaps, start, bound)?;
    let left = proximal.solve(stop)?;
    proximal.finished(left)
}

/// √W_ii of each row, all of which must be positive, and the gaps finite.
fn lengths(W: &Mat<f64>, gaps: &[f64]) -> Result<Vec<f64>, Halt> {
    let lengths: Vec<f64> = (0..gaps.len()).map(|i| W[(i, i)].sqrt()).collect();
    let is_sound = |i: usize| lengths[i] > 0.0 && lengths[i].is_finite() && gaps[i].is_finite();
    match (0..gaps.len()).find(|&i| !is_sound(i)) {
        Some(i) => {
            let (w, c) = (W[(i, i)], gaps[i]);
            Err(Halt::Failed(format!(
                "row {i} of the condensed problem has compliance {w} and gap {c}: both must be finite, and the first positive"
            )))
        }
        None => Ok(lengths),
    }
}

/// The problem with unit diagonal, and the method's state.
pub(super) struct Proximal {
    pub(super) W: Mat<f64>,
    /// λ̄ and its gaps.
    pub(super) center: Col<f64>,
    pub(super) gaps: Col<f64>,
    /// The limits of each λ, the lower one not above the upper one; those of contact at first.
    pub(super) limits: Vec<[f64; 2]>,
    /// √W_ii, the length that each row's gap is measured in, and the bound on |min(W_ii λᵢ, cᵢ)|.
    lengths: Vec<f64>,
    pub(super) bound: f64,
    factor: Active,
    pub(super) steps: usize,
}

/// The Cholesky factor LLᵀ of H = W + ε on some rows.
struct Active {
    rows: Vec<usize>,
    epsilon: f64,
    /// L is the lower triangle of the leading part; the memory stays from one factor to the next.
    values: Mat<f64>,
    memory: MemBuffer,
}

impl Active {
    fn new() -> Self {
        let none = cholesky_in_place_scratch::<f64>(0, Par::Seq, Default::default());
        Active {
            rows: Vec::new(),
            epsilon: 0.0,
            values: Mat::new(),
            memory: MemBuffer::new(none),
        }
    }

    /// False if W + ε is not positive definite on these rows.
    fn factor(&mut self, W: &Mat<f64>, rows: &[usize], epsilon: f64) -> bool {
        let (k, par) = (rows.len(), Par::Seq);
        if self.values.nrows() < k {
            let room = (k + k / 8).min(W.nrows());
            self.values = Mat::zeros(room, room);
            let factor = cholesky_in_place_scratch::<f64>(room, par, Default::default());
            self.memory = MemBuffer::new(factor);
        }
        for (b, &j) in rows.iter().enumerate() {
            let (from, into) = (W.col_as_slice(j), self.values.col_as_slice_mut(b));
            let entries = rows.iter().zip(into).skip(b);
            entries.for_each(|(&i, w)| *w = from[i]);
            self.values[(b, b)] += epsilon;
        }
        let leading = self.values.submatrix_mut(0, 0, k, k);
        let (stack, plain) = (MemStack::new(&mut self.memory), Default::default());
        let factored = cholesky_in_place(leading, plain, par, stack, Default::default());
        // what is left of a factor that failed is of no rows
        self.rows.clear();
        if factored.is_ok() {
            self.rows.extend_from_slice(rows);
            self.epsilon = epsilon;
        }
        factored.is_ok()
    }

    /// H_AA x = b for rows A, in place; false, with b as it was, if too many differ from those of the factor.
    ///
    /// With the rows O of the factor, P those of A that are new, and R those that are not in A,
    ///
    /// H_OO x_O + H_OP x_P + y = b_O,   H_PO x_O + H_PP x_P = b_P,   x_R = 0,
    ///
    /// where y is zero but on R. Without x_O, that is a system for x_P and y_R.
    fn solve(&self, W: &Mat<f64>, active: &[usize], epsilon: f64, b: &mut [f64]) -> bool {
        let known = self.rows.len();
        if self.epsilon != epsilon || known == 0 {
            return false;
        }
        let (entering, leaving) = (beyond(active, &self.rows), beyond(&self.rows, active));
        let (new, k) = (entering.len(), entering.len() + leaving.len());
        if BORDER * k > known {
            return false;
        }
        let place = |row: usize| self.rows.binary_search(&row);
        let L = self.values.submatrix(0, 0, known, known);
        // the last column is b_O
        let mut Z = Mat::zeros(known, k + 1);
        for (c, &p) in entering.iter().enumerate() {
            let from = W.col_as_slice(p);
            let into = Z.col_as_slice_mut(c).iter_mut().zip(&self.rows);
            into.for_each(|(z, &i)| *z = from[i]);
        }
        let places = leaving.iter().filter_map(|&r| place(r).ok());
        places.enumerate().for_each(|(c, o)| Z[(o, new + c)] = 1.0);
        for (&i, b) in active.iter().zip(&*b) {
            if let Ok(o) = place(i) {
                Z[(o, k)] = *b;
            }
        }
        solve_lower_triangular_in_place(L, Z.as_mut(), Par::Seq);
        let (border, mut y) = (Z.subcols(0, k), Z.col(k).to_owned());
        let gram = border.transpose() * Z.as_ref();
        let H = |a: usize, c: usize| match a.max(c) < new {
            true => W[(entering[a], entering[c])] + if a == c { epsilon } else { 0.0 },
            false => 0.0,
        };
        let S = Mat::from_fn(k, k, |a, c| H(a, c) - gram[(a, c)]);
        let of = |a: usize| match entering.get(a).map(|p| active.binary_search(p)) {
            Some(Ok(place)) => b[place],
            _ => 0.0,
        };
        let mut x = Col::from_fn(k, |a| of(a) - gram[(a, k)]);
        if k > 0 {
            S.partial_piv_lu().solve_in_place(x.as_mat_mut());
        }
        y -= border * &x;
        solve_upper_triangular_in_place(L.transpose(), y.as_mat_mut(), Par::Seq);
        for (&i, b) in active.iter().zip(b) {
            *b = match (place(i), entering.binary_search(&i)) {
                (Ok(o), _) => y[o],
                (_, Ok(p)) => x[p],
                _ => 0.0,
            };
        }
        true
    }
}

/// The entries of the ascending `all` that the ascending `known` lacks.
fn beyond(all: &[usize], known: &[usize]) -> Vec<usize> {
    let new = all.iter().filter(|i| known.binary_search(i).is_err());
    new.copied().collect()
}

impl Proximal {
    /// At the multipliers `start` and their gaps.
    pub(super) fn new(W: &Mat<f64>, gaps: &[f64], start: &[f64], bound: f64) -> Result<Self, Halt> {
        let m = gaps.len();
        let lengths = lengths(W, gaps)?;
        let largest = gaps.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        Ok(Proximal {
            W: Mat::from_fn(m, m, |i, j| W[(i, j)] / (lengths[i] * lengths[j])),
            center: Col::from_fn(m, |i| start[i] * lengths[i]),
            gaps: Col::from_fn(m, |i| gaps[i] / lengths[i]),
            limits: vec![OF_CONTACT; m],
            bound: bound.max(ROUNDOFF * largest),
            lengths,
            factor: Active::new(),
            steps: 0,
        })
    }

    /// √W_ii of each row.
    pub(super) fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// The result, which leaves so much of the conditions, relative to the bound.
    pub(super) fn finished(self, left: f64) -> Result<Complementary, Halt> {
        if !left.is_finite() {
            return Err(Halt::Failed(
                "the multipliers of the condensed problem are not finite".into(),
            ));
        }
        let rows = self.center.iter().zip(&self.lengths);
        Ok(Complementary {
            lambda: rows.map(|(l, length)| l / length).collect(),
            steps: self.steps,
            left,
        })
    }

    /// What is left, relative to the bound.
    pub(super) fn solve(&mut self, stop: &Stop) -> Result<f64, Halt> {
        let scaled = self.natural(&self.center, &self.gaps).fold(0.0, f64::max);
        let mut epsilon = (WARM * scaled / self.center.norm_max()).clamp(LAST, FIRST);
        let mut left = self.residual(&self.center, &self.gaps) / self.bound;
        let mut best = (self.center.clone(), self.gaps.clone(), left);
        let sums = self.W.col_iter().map(|column| column.norm_l1());
        let mut least = LEAST * sums.fold(1.0, f64::max);
        for _ in 0..ROUNDS {
            if left <= 1.0 {
                break;
            }
            let before = left;
            left = match self.round(epsilon, stop) {
                // the round-off of W shows
                Err(Halt::Failed(_)) if epsilon < LAST => f64::INFINITY,
                left => left?,
            };
            // a smaller ε has to gain something: where no λ closes the gaps, λ becomes larger for nothing
            let gain = if epsilon < LAST { STUCK } else { 1.0 };
            if epsilon > LAST || left <= 1.0 || left <= gain * best.2 {
                best = (self.center.clone(), self.gaps.clone(), left);
            } else if epsilon < LAST && (epsilon <= least || left == f64::INFINITY) {
                (self.center, self.gaps, left) = best.clone();
                (least, epsilon) = (LAST, LAST);
                continue;
            }
            epsilon = match epsilon > LAST {
                true => (RATIO * epsilon).max(LAST),
                false if left > SLOW * before => (RATIO * epsilon).max(least),
                false => epsilon,
            };
        }
        (self.center, self.gaps, left) = best;
        Ok(left)
    }

    /// λ becomes the proximal point of λ̄; what is left then, relative to the bound.
    pub(super) fn round(&mut self, epsilon: f64, stop: &Stop) -> Result<f64, Halt> {
        let (z, gaps) = self.proximal_point(epsilon, stop)?;
        if !(z.is_all_finite() && gaps.is_all_finite()) {
            return Err(Halt::Failed(
                "the multipliers of the condensed problem are not finite".into(),
            ));
        }
        self.center = Col::from_fn(z.nrows(), |i| clamped(z[i], self.limits[i]));
        self.gaps = gaps + self.product(&(&self.center - z));
        Ok(self.residual(&self.center, &self.gaps) / self.bound)
    }

    /// Newton's method from z = λ̄ until the rows that act repeat, or z is a solution; z and its gaps.
    fn proximal_point(&mut self, epsilon: f64, stop: &Stop) -> Result<(Col<f64>, Col<f64>), Halt> {
        let (mut z, mut gaps) = (self.center.clone(), self.gaps.clone());
        let mut last: Option<Vec<Ordering>> = None;
        for _ in 0..STEPS {
            Halt::if_requested(stop)?;
            let margin = epsilon * &self.center - &gaps;
            // below, between or above its limits
            let place = |i: usize| match self.limits[i].map(|limit| epsilon * limit) {
                [low, _] if margin[i] <= low => Ordering::Less,
                [_, high] if margin[i] >= high => Ordering::Greater,
                _ => Ordering::Equal,
            };
            let places: Vec<Ordering> = (0..z.nrows()).map(place).collect();
            let is_between = |i: &usize| places[*i] == Ordering::Equal;
            let active: Vec<usize> = (0..z.nrows()).filter(is_between).collect();
            let is_settled = last.as_ref() == Some(&places);
            self.steps += usize::from(!is_settled);
            let (direction, change) = self.newton(&active, epsilon, &z, &margin)?;
            let limits = |i: usize| self.limits[i].map(|limit| epsilon * limit);
            let work = epsilon * (change.transpose() * &z);
            let curvature = epsilon * (change.transpose() * &direction);
            // without descent W d is zero, and z + d the one of these z that is the proximal point
            let descent = exact_step(work, curvature, &margin, &change, limits);
            let step = descent.filter(|_| !is_settled).unwrap_or(1.0);
            z += step * &direction;
            gaps += step * &change;
            let is_full = (step - 1.0).abs() < FULL;
            let is_solution = is_full && self.residual(&z, &gaps) <= self.bound;
            if is_settled || descent.is_none() || is_solution {
                break;
            }
            last = Some(places);
        }
        Ok((z, gaps))
    }

    /// The step d to the minimum with the `active` rows A, and W d: (W_AA + ε) d_A = (ε λ̄ − ε z − c − W d_I)_A, where
    /// d_I leads to the limits of the other rows, and `margin` is ε λ̄ − c.
    fn newton(
        &mut self,
        active: &[usize],
        epsilon: f64,
        z: &Col<f64>,
        margin: &Col<f64>,
    ) -> Result<(Col<f64>, Col<f64>), Halt> {
        let at_limit = |i: usize| clamped(margin[i] / epsilon, self.limits[i]) - z[i];
        let mut direction = Col::from_fn(z.nrows(), at_limit);
        active.iter().for_each(|&i| direction[i] = 0.0);
        let mut change = self.product(&direction);
        if active.is_empty() {
            return Ok((direction, change));
        }
        let forces: Vec<f64> = active
            .iter()
            .map(|&i| margin[i] - epsilon * z[i] - change[i])
            .collect();
        let is_accurate = |(x, answer): &(Col<f64>, Col<f64>)| {
            let left = |(&i, f): (&usize, &f64)| (f - answer[i] - epsilon * x[i]).abs();
            let left = active.iter().zip(&forces).map(left).fold(0.0, f64::max);
            let largest = forces.iter().fold(x.norm_max(), |m: f64, f| m.max(f.abs()));
            left <= ACCURACY * largest
        };
        let known = self.answer(active, epsilon, &forces).filter(is_accurate);
        let (goal, answer) = match known {
            Some(known) => known,
            None => {
                let is_definite = self.factor.factor(&self.W, active, epsilon);
                let answer = is_definite.then(|| self.answer(active, epsilon, &forces));
                answer.flatten().ok_or_else(|| {
                    let k = active.len();
                    Halt::Failed(format!(
                        "the compliance of {k} rows is not positive semidefinite"
                    ))
                })?
            }
        };
        change += answer;
        direction += goal;
        Ok((direction, change))
    }

    /// x with (W_AA + ε) x_A = `forces` and zero elsewhere, and W x, if the factor serves these rows.
    fn answer(
        &self,
        active: &[usize],
        epsilon: f64,
        forces: &[f64],
    ) -> Option<(Col<f64>, Col<f64>)> {
        let mut x = forces.to_vec();
        if !self.factor.solve(&self.W, active, epsilon, &mut x) {
            return None;
        }
        let mut all = Col::zeros(self.center.nrows());
        active.iter().zip(x).for_each(|(&i, x)| all[i] = x);
        let answer = self.product(&all);
        Some((all, answer))
    }

    /// W x for an x with many zeros.
    pub(super) fn product(&self, x: &Col<f64>) -> Col<f64> {
        let mut y = Col::zeros(x.nrows());
        for (j, x) in x.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            let column = self.W.col_as_slice(j);
            y.iter_mut().zip(column).for_each(|(y, w)| *y += w * x);
        }
        y
    }

    /// max W_ii |λᵢ − P(λᵢ − cᵢ/W_ii)| (UL), with the nearest value P between the limits: |min(W_ii λᵢ, cᵢ)| for contact.
    fn residual(&self, lambda: &Col<f64>, gaps: &Col<f64>) -> f64 {
        let rows = self.natural(lambda, gaps).zip(&self.lengths);
        rows.fold(0.0, |worst, (left, length)| worst.max(left * length))
    }

    /// The same of each row, with unit diagonal.
    fn natural(&self, lambda: &Col<f64>, gaps: &Col<f64>) -> impl Iterator<Item = f64> {
        let pairs = lambda.iter().zip(gaps.iter()).zip(&self.limits);
        pairs.map(|((l, c), limits)| natural(*l, *c, *limits))
    }
}

/// |λ − P(λ − c)| with the nearest value P between two limits.
pub(super) fn natural(lambda: f64, c: f64, [low, high]: [f64; 2]) -> f64 {
    // not as a difference of large numbers
    match lambda - c {
        below if below < low => (lambda - low).abs(),
        above if above > high => (lambda - high).abs(),
        _ => c.abs(),
    }
}

/// The nearest value between two limits.
pub(super) fn clamped(value: f64, [low, high]: [f64; 2]) -> f64 {
    value.max(low).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A factor of 48 rows solves for rows of which one or two are new and one or two are gone, and not for others.
    #[test]
    fn a_factor_serves_rows_that_are_nearly_its_own() {
        let (m, epsilon) = (60, 1e-3);
        let W = Mat::from_fn(m, m, |i, j| (-0.1 * (i.abs_diff(j) as f64)).exp());
        let own: Vec<usize> = (0..m).filter(|i| i % 5 != 0).collect();
        let mut factor = Active::new();
        assert!(factor.factor(&W, &own, epsilon));
        let cases: [(&[usize], &[usize]); 5] = [
            (&[], &[]),
            (&[10], &[]),
            (&[], &[7]),
            (&[0, 30], &[58]),
            (&[55], &[1, 31]),
        ];
        for (new, gone) in cases {
            let is_in = |i: &usize| new.contains(i) || (i % 5 != 0 && !gone.contains(i));
            let rows: Vec<usize> = (0..m).filter(is_in).collect();
            let b: Vec<f64> = rows.iter().map(|&i| (i as f64).sin()).collect();
            let mut x = b.clone();
            assert!(factor.solve(&W, &rows, epsilon, &mut x), "{new:?} {gone:?}");
            for (a, &i) in rows.iter().enumerate() {
                let terms = rows.iter().zip(&x).map(|(&j, x)| W[(i, j)] * x);
                let left = b[a] - terms.sum::<f64>() - epsilon * x[a];
                assert!(left.abs() < 1e-12, "{new:?} {gone:?}: row {i} {left:e}");
            }
        }
        let all: Vec<usize> = (0..m).collect();
        let mut b = vec![1.0; m];
        assert!(!factor.solve(&W, &all, epsilon, &mut b));
        assert!(!factor.solve(&W, &own, 2.0 * epsilon, &mut b[..own.len()]));
        assert_eq!(b, vec![1.0; m], "b stays as it was");
    }
}
