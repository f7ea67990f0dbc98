//! 0 ≤ λ ⟂ W λ + q ≥ 0 for a dense, positive semidefinite W: a proximal method of multipliers with Newton's method
//! inside.
//!
//! λ minimises ½λᵀWλ + qᵀλ over λ ≥ 0. The proximal point of λ̄ also has ½ε|λ − λ̄|². It satisfies
//! ε λ = (ε λ̄ − c)₊ with c = W λ + q, which is the minimum over z of the convex, piecewise quadratic
//!
//! ψ(z) = ½ ε zᵀWz + ½ |(ε λ̄ − q − W z)₊|²,
//!
//! the augmented Lagrangian of the primal problem. Newton's method on the rows A with ε λ̄ > c solves
//! (W_AA + ε) z_A = ε λ̄ − q_A; an exact line search makes it end after finitely many steps. Rows that depend on each
//! other are harmless, since ε makes every W_AA definite. Repeating this from λ̄ = λ removes the error of ε.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat, Side};

use super::halt::Halt;
use super::line_search::exact_step;
use crate::Stop;

/// ε of the first round, relative to the diagonal of W, that of the last ones, and its ratio from one round to the next.
///
/// Each round finds most of the rows that act in the next one. From 1e-9 at once, Newton's method took up to a hundred
/// times as many steps. Below 1e-8 the round-off of W shows.
const FIRST: f64 = 0.1;
const LAST: f64 = 1e-8;
const RATIO: f64 = 0.1;
/// ε of the first round from multipliers that are known, relative to what is left of the condition over the largest λ.
const WARM: f64 = 0.1;
/// The round-off of the gaps, relative to the largest |q|.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;
/// The limits of rounds and of Newton's steps in one of them.
const ROUNDS: usize = 60;
const STEPS: usize = 200;

/// λ and what it cost.
#[derive(Debug)]
pub(super) struct Complementary {
    /// λ ≥ 0 (m).
    pub lambda: Vec<f64>,
    /// Steps of Newton's method.
    pub steps: usize,
}

/// Solves from the multipliers `start` until every |min(W_ii λᵢ, cᵢ)| is within `bound` (UL), or within round-off of q.
/// `W` (m × m, UL/UF) is symmetric, with both triangles.
pub(super) fn solve(
    W: &Mat<f64>,
    q: &[f64],
    start: &[f64],
    bound: f64,
    stop: &Stop,
) -> Result<Complementary, Halt> {
    let m = q.len();
    let units: Vec<f64> = (0..m).map(|i| 1.0 / W[(i, i)].sqrt()).collect();
    if let Some(i) = (0..m).find(|&i| !units[i].is_finite() || !q[i].is_finite()) {
        let (w, q) = (W[(i, i)], q[i]);
        return Err(Halt::Failed(format!(
            "row {i} of the condensed problem has compliance {w} and gap {q}: both must be finite"
        )));
    }
    let largest = q.iter().fold(0.0, |m: f64, q| m.max(q.abs()));
    let mut proximal = Proximal {
        bound: bound.max(ROUNDOFF * largest),
        lengths: units.iter().map(|unit| 1.0 / unit).collect(),
        W: Mat::from_fn(m, m, |i, j| W[(i, j)] * units[i] * units[j]),
        q: Col::from_fn(m, |i| q[i] * units[i]),
        center: Col::from_fn(m, |i| start[i].max(0.0) / units[i]),
        factor: None,
        steps: 0,
    };
    let lambda = proximal.solve(stop)?;
    Ok(Complementary {
        lambda: (0..m).map(|i| lambda[i] * units[i]).collect(),
        steps: proximal.steps,
    })
}

/// The problem with unit diagonal, and the method's state.
struct Proximal {
    /// √W_ii, the length that each row's gap is measured in, and the bound on |min(W_ii λᵢ, cᵢ)|.
    lengths: Vec<f64>,
    bound: f64,
    W: Mat<f64>,
    q: Col<f64>,
    /// λ̄.
    center: Col<f64>,
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
    fn solve(&mut self, stop: &Stop) -> Result<Col<f64>, Halt> {
        let mut epsilon = FIRST;
        let mut left = f64::INFINITY;
        for round in 0..ROUNDS {
            let gaps = &self.q + self.product(&self.center);
            left = self.residual(&self.center, &gaps);
            if left <= self.bound {
                return Ok(self.center.clone());
            }
            if round == 0 {
                let scaled = natural(&self.center, &gaps).fold(0.0, f64::max);
                let warm = WARM * scaled / self.center.norm_max();
                epsilon = warm.clamp(LAST, FIRST);
            }
            let z = self.proximal_point(epsilon, gaps, stop)?;
            self.center = positive_part(&z);
            epsilon = (RATIO * epsilon).max(LAST);
        }
        Err(Halt::Failed(format!(
            "gaps and forces of the condensed problem are not complementary after {ROUNDS} rounds: {:.1e} times the \
             bound is left",
            left / self.bound
        )))
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

    /// Newton's method from z = λ̄, where c is `gaps`, until the rows that act repeat, or z is a solution.
    fn proximal_point(
        &mut self,
        epsilon: f64,
        mut gaps: Col<f64>,
        stop: &Stop,
    ) -> Result<Col<f64>, Halt> {
        let mut z = self.center.clone();
        let mut last: Option<Vec<usize>> = None;
        for _ in 0..STEPS {
            if stop.is_requested() {
                return Err(Halt::Stopped);
            }
            let margin = epsilon * &self.center - &gaps;
            let active: Vec<usize> = (0..z.nrows()).filter(|&i| margin[i] > 0.0).collect();
            if last.as_ref() == Some(&active) {
                return Ok(z);
            }
            self.steps += 1;
            let goal = self.minimum_on(&active, epsilon)?;
            let direction = &goal - &z;
            let change = self.product(&direction);
            let work = epsilon * (change.transpose() * &z);
            let curvature = epsilon * (change.transpose() * &direction);
            let Some(step) = exact_step(work, curvature, &margin, &change) else {
                return Ok(goal);
            };
            z += step * &direction;
            gaps += step * &change;
            if z.iter().all(|z| *z >= 0.0) && self.residual(&z, &gaps) <= self.bound {
                return Ok(z);
            }
            last = (step > 1.0 - 1e-6).then_some(active);
        }
        Err(Halt::Failed(format!(
            "the rows that act are not found within {STEPS} steps of Newton's method"
        )))
    }

    /// z with (W_AA + ε) z_A = ε λ̄_A − q_A on the `active` rows A, and zero elsewhere.
    fn minimum_on(&mut self, active: &[usize], epsilon: f64) -> Result<Col<f64>, Halt> {
        let k = active.len();
        let known = self.factor.as_ref();
        if known.is_none_or(|factor| factor.epsilon != epsilon || factor.rows != active) {
            let mut W = Mat::zeros(k, k);
            for (b, &j) in active.iter().enumerate() {
                let (from, into) = (self.W.col_as_slice(j), W.col_as_slice_mut(b));
                let rows = active.iter().zip(into).skip(b);
                rows.for_each(|(&i, w)| *w = from[i]);
                W[(b, b)] += epsilon;
            }
            let llt = W.llt(Side::Lower).map_err(|_| {
                Halt::Failed(format!("the compliance of {k} rows is not positive semidefinite"))
            })?;
            self.factor = Some(Active {
                rows: active.to_vec(),
                epsilon,
                llt,
            });
        }
        let mut z = Col::zeros(self.q.nrows());
        if let Some(factor) = &self.factor {
            let mut x = Col::from_fn(k, |a| epsilon * self.center[active[a]] - self.q[active[a]]);
            factor.llt.solve_in_place(x.as_mat_mut());
            active.iter().zip(x.iter()).for_each(|(&i, x)| z[i] = *x);
        }
        Ok(z)
    }
}

/// |min(λᵢ, cᵢ)| of each row.
fn natural(lambda: &Col<f64>, gaps: &Col<f64>) -> impl Iterator<Item = f64> {
    let pairs = lambda.iter().zip(gaps.iter());
    pairs.map(|(l, c)| l.min(*c).abs())
}

fn positive_part(z: &Col<f64>) -> Col<f64> {
    Col::from_fn(z.nrows(), |i| z[i].max(0.0))
}
