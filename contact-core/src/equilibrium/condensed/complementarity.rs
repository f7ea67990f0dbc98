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

use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat, Side};

use super::halt::Halt;
use super::line_search::exact_step;
use crate::Stop;

/// ε of the first round, relative to the diagonal of W, that of the last ones, and its ratio from one round to the next.
///
/// Each round finds most of the rows that act in the next one. From 1e-9 at once, Newton's method took up to a hundred
/// times as many steps. From 0.1, most of the 3 600 rows of the linear beams act at first, and their factors cost a third of
/// the time. Below 1e-8 the round-off of W shows.
const FIRST: f64 = 0.01;
const LAST: f64 = 1e-8;
const RATIO: f64 = 0.1;
/// ε of the first round from multipliers that are known, relative to what is left of the condition over the largest λ.
const WARM: f64 = 0.01;
/// The round-off of the gaps, relative to the largest one of the start.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;
/// A step is full within this.
const FULL: f64 = 1e-6;
/// The limits of rounds and of Newton's steps in one of them.
const ROUNDS: usize = 60;
const STEPS: usize = 100;

/// λ and what it cost.
#[derive(Debug)]
pub(in crate::equilibrium) struct Complementary {
    /// λ ≥ 0 (m).
    pub lambda: Vec<f64>,
    /// Steps of Newton's method.
    pub steps: usize,
    /// The largest |min(W_ii λᵢ, cᵢ)|, relative to the bound; above 1 where the rounds did not suffice.
    pub left: f64,
}

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
    let m = gaps.len();
    let lengths: Vec<f64> = (0..m).map(|i| W[(i, i)].sqrt()).collect();
    let is_sound = |i: usize| lengths[i] > 0.0 && lengths[i].is_finite() && gaps[i].is_finite();
    if let Some(i) = (0..m).find(|&i| !is_sound(i)) {
        let (w, c) = (W[(i, i)], gaps[i]);
        return Err(Halt::Failed(format!(
            "row {i} of the condensed problem has compliance {w} and gap {c}: both must be finite, and the first positive"
        )));
    }
    let largest = gaps.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let mut proximal = Proximal {
        W: Mat::from_fn(m, m, |i, j| W[(i, j)] / (lengths[i] * lengths[j])),
        center: Col::from_fn(m, |i| start[i] * lengths[i]),
        gaps: Col::from_fn(m, |i| gaps[i] / lengths[i]),
        bound: bound.max(ROUNDOFF * largest),
        lengths,
        factor: None,
        steps: 0,
    };
    let left = proximal.solve(stop)?;
    if !left.is_finite() {
        return Err(Halt::Failed(
            "the multipliers of the condensed problem are not finite".into(),
        ));
    }
    let Proximal {
        center, lengths, ..
    } = &proximal;
    Ok(Complementary {
        lambda: (0..m).map(|i| center[i] / lengths[i]).collect(),
        steps: proximal.steps,
        left,
    })
}

/// The problem with unit diagonal, and the method's state.
struct Proximal {
    W: Mat<f64>,
    /// λ̄ and its gaps.
    center: Col<f64>,
    gaps: Col<f64>,
    /// √W_ii, the length that each row's gap is measured in, and the bound on |min(W_ii λᵢ, cᵢ)|.
    lengths: Vec<f64>,
    bound: f64,
    factor: Option<Active>,
    steps: usize,
}

/// Rows A and the factor of W_AA + ε.
struct Active {
    rows: Vec<usize>,
    epsilon: f64,
    llt: Llt<f64>,
}

impl Proximal {
    /// What is left, relative to the bound.
    fn solve(&mut self, stop: &Stop) -> Result<f64, Halt> {
        let scaled = natural(&self.center, &self.gaps).fold(0.0, f64::max);
        let mut epsilon = (WARM * scaled / self.center.norm_max()).clamp(LAST, FIRST);
        let mut left = self.residual(&self.center, &self.gaps) / self.bound;
        for _ in 0..ROUNDS {
            if left <= 1.0 {
                break;
            }
            let (z, gaps) = self.proximal_point(epsilon, stop)?;
            self.center = Col::from_fn(z.nrows(), |i| z[i].max(0.0));
            self.gaps = gaps + self.product(&(&self.center - z));
            left = self.residual(&self.center, &self.gaps) / self.bound;
            epsilon = (RATIO * epsilon).max(LAST);
        }
        Ok(left)
    }

    /// Newton's method from z = λ̄ until the rows that act repeat, or z is a solution; z and its gaps.
    fn proximal_point(&mut self, epsilon: f64, stop: &Stop) -> Result<(Col<f64>, Col<f64>), Halt> {
        let (mut z, mut gaps) = (self.center.clone(), self.gaps.clone());
        let mut last: Option<Vec<usize>> = None;
        for _ in 0..STEPS {
            Halt::if_requested(stop)?;
            let margin = epsilon * &self.center - &gaps;
            let active: Vec<usize> = (0..z.nrows()).filter(|&i| margin[i] > 0.0).collect();
            let is_settled = last.as_ref() == Some(&active);
            self.steps += usize::from(!is_settled);
            let (direction, change) = self.newton(&active, epsilon, &z, &margin)?;
            let work = epsilon * (change.transpose() * &z);
            let curvature = epsilon * (change.transpose() * &direction);
            // without descent W d is zero, and z + d the one of these z that is the proximal point
            let descent = exact_step(work, curvature, &margin, &change);
            let step = descent.filter(|_| !is_settled).unwrap_or(1.0);
            z += step * &direction;
            gaps += step * &change;
            let is_full = (step - 1.0).abs() < FULL;
            let is_solution = is_full && self.residual(&z, &gaps) <= self.bound;
            if is_settled || descent.is_none() || is_solution {
                break;
            }
            last = Some(active);
        }
        Ok((z, gaps))
    }

    /// The step d to the minimum with the `active` rows A, and W d: (W_AA + ε) d_A = (ε λ̄ − ε z − c − W d_I)_A, where
    /// d_I = −z_I on the other rows and `margin` is ε λ̄ − c.
    fn newton(
        &mut self,
        active: &[usize],
        epsilon: f64,
        z: &Col<f64>,
        margin: &Col<f64>,
    ) -> Result<(Col<f64>, Col<f64>), Halt> {
        let mut direction = -z;
        active.iter().for_each(|&i| direction[i] = 0.0);
        let mut change = self.product(&direction);
        if active.is_empty() {
            return Ok((direction, change));
        }
        let mut x = Col::from_fn(active.len(), |a| {
            let i = active[a];
            margin[i] - epsilon * z[i] - change[i]
        });
        self.factored(active, epsilon)?
            .solve_in_place(x.as_mat_mut());
        let mut goal = Col::zeros(z.nrows());
        active.iter().zip(x.iter()).for_each(|(&i, x)| goal[i] = *x);
        change += self.product(&goal);
        direction += goal;
        Ok((direction, change))
    }

    /// The factor of W_AA + ε, new where it is not the last one.
    fn factored(&mut self, active: &[usize], epsilon: f64) -> Result<&Llt<f64>, Halt> {
        let is_same = |known: &Active| known.epsilon == epsilon && known.rows == active;
        let known = match self.factor.take().filter(is_same) {
            Some(known) => known,
            None => {
                let k = active.len();
                let mut W = Mat::zeros(k, k);
                for (b, &j) in active.iter().enumerate() {
                    let (from, into) = (self.W.col_as_slice(j), W.col_as_slice_mut(b));
                    let rows = active.iter().zip(into).skip(b);
                    rows.for_each(|(&i, w)| *w = from[i]);
                    W[(b, b)] += epsilon;
                }
                let llt = W.llt(Side::Lower).map_err(|_| {
                    Halt::Failed(format!(
                        "the compliance of {k} rows is not positive semidefinite"
                    ))
                })?;
                Active {
                    rows: active.to_vec(),
                    epsilon,
                    llt,
                }
            }
        };
        Ok(&self.factor.insert(known).llt)
    }

    /// W x for an x with many zeros.
    fn product(&self, x: &Col<f64>) -> Col<f64> {
        let mut y = Col::zeros(x.nrows());
        for (j, x) in x.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            let column = self.W.col_as_slice(j);
            y.iter_mut().zip(column).for_each(|(y, w)| *y += w * x);
        }
        y
    }

    /// max |min(W_ii λᵢ, cᵢ)| (UL).
    fn residual(&self, lambda: &Col<f64>, gaps: &Col<f64>) -> f64 {
        let rows = natural(lambda, gaps).zip(&self.lengths);
        rows.fold(0.0, |worst, (left, length)| worst.max(left * length))
    }
}

/// |min(λᵢ, cᵢ)| of each row.
fn natural(lambda: &Col<f64>, gaps: &Col<f64>) -> impl Iterator<Item = f64> {
    let pairs = lambda.iter().zip(gaps.iter());
    pairs.map(|(l, c)| l.min(*c).abs())
}
