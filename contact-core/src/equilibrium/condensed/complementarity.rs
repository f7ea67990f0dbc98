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

/// ε, relative to the diagonal of W. A smaller one takes fewer rounds; round-off of W must stay below it.
const EPSILON: f64 = 1e-9;
/// Bound on min(λ, c), each row scaled by √W_ii, relative to the largest |q|.
const TOLERANCE: f64 = 1e-12;
/// The limits of rounds and of Newton's steps in all of them.
const ROUNDS: usize = 200;
const STEPS: usize = 500;

/// λ and what it cost.
#[derive(Debug)]
pub(super) struct Complementary {
    /// λ ≥ 0 (m).
    pub lambda: Vec<f64>,
    /// Steps of Newton's method.
    pub steps: usize,
}

/// Solves from the multipliers `start`. `W` (m × m) is symmetric, with both triangles.
pub(super) fn solve(
    W: &Mat<f64>,
    q: &[f64],
    start: &[f64],
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
    let mut proximal = Proximal {
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
    W: Mat<f64>,
    q: Col<f64>,
    /// λ̄.
    center: Col<f64>,
    /// The rows A with the factor of W_AA + ε.
    factor: Option<(Vec<usize>, Llt<f64>)>,
    steps: usize,
}

impl Proximal {
    fn solve(&mut self, stop: &Stop) -> Result<Col<f64>, Halt> {
        let size = self.q.norm_max();
        let mut residual = f64::INFINITY;
        for _ in 0..ROUNDS {
            let gaps = &self.q + &self.W * &self.center;
            let pairs = self.center.iter().zip(gaps.iter());
            residual = pairs.fold(0.0, |worst: f64, (l, c)| worst.max(l.min(*c).abs()));
            let roundoff = 16.0 * f64::EPSILON * (size + self.center.norm_max());
            if residual <= (TOLERANCE * size).max(roundoff) {
                return Ok(self.center.clone());
            }
            let z = self.proximal_point(gaps, stop)?;
            self.center = Col::from_fn(z.nrows(), |i| z[i].max(0.0));
        }
        Err(Halt::Failed(format!(
            "gaps and forces of the condensed problem are not complementary after {ROUNDS} rounds: {residual:.1e} is \
             left of {size:.1e}"
        )))
    }

    /// Newton's method from z = λ̄, where c is `gaps`.
    fn proximal_point(&mut self, mut gaps: Col<f64>, stop: &Stop) -> Result<Col<f64>, Halt> {
        let mut z = self.center.clone();
        let size = self.q.norm_max();
        loop {
            if stop.is_requested() {
                return Err(Halt::Stopped);
            }
            self.steps += 1;
            if self.steps > STEPS {
                return Err(Halt::Failed(format!(
                    "the active rows are not found within {STEPS} steps of Newton's method"
                )));
            }
            let margin = Col::from_fn(z.nrows(), |i| EPSILON * self.center[i] - gaps[i]);
            let active: Vec<usize> = (0..z.nrows()).filter(|&i| margin[i] > 0.0).collect();
            let goal = self.minimum_on(active)?;
            let direction = &goal - &z;
            let change = &self.W * &direction;
            let work = EPSILON * change.transpose() * &z;
            let curvature = EPSILON * change.transpose() * &direction;
            let Some(step) = exact_step(work, curvature, &margin, &change) else {
                return Ok(goal);
            };
            z += step * &direction;
            gaps = &self.q + &self.W * &z;
            let left = (0..z.nrows()).map(|i| {
                (EPSILON * z[i] - (EPSILON * self.center[i] - gaps[i]).max(0.0)).abs()
            });
            if left.fold(0.0, f64::max) <= 0.1 * TOLERANCE * size {
                return Ok(z);
            }
        }
    }

    /// z with (W_AA + ε) z_A = ε λ̄_A − q_A and zero elsewhere.
    fn minimum_on(&mut self, active: Vec<usize>) -> Result<Col<f64>, Halt> {
        let k = active.len();
        if self.factor.as_ref().is_none_or(|(rows, _)| *rows != active) {
            let W = Mat::from_fn(k, k, |a, b| {
                self.W[(active[a], active[b])] + if a == b { EPSILON } else { 0.0 }
            });
            let factor = W.llt(Side::Lower).map_err(|_| {
                Halt::Failed(format!("the compliance of {k} rows is not positive semidefinite"))
            })?;
            self.factor = Some((active, factor));
        }
        let mut z = Col::zeros(self.q.nrows());
        if let Some((rows, factor)) = &self.factor {
            let mut x = Col::from_fn(k, |a| EPSILON * self.center[rows[a]] - self.q[rows[a]]);
            factor.solve_in_place(x.as_mat_mut());
            rows.iter().zip(x.iter()).for_each(|(&i, x)| z[i] = *x);
        }
        Ok(z)
    }
}
