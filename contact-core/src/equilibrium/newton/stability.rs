//! Whether an equilibrium is stable.
//!
//! It is a strict minimum, as far as second derivatives tell, if K − sym D is positive on the motions v that the rows A with
//! a force permit, C_A v = 0. Relative to the matrix S that is factored, this curvature is 1 − θ with
//!
//! (S − K + sym D) v = θ S v + C_Aᵀ y,   C_A v = 0.
//!
//! Lanczos' method approximates the largest θ from below by a few solves with S. A value above 1 proves that the equilibrium
//! is unstable. A value below 1 is no proof that it is stable.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat, Side};

use super::super::condensed::halt::Halt;
use super::linearization::Linearization;
use super::step::Condensed;
use super::tangent::Tangent;
use crate::Stop;

/// The most steps of Lanczos' method, and the fewest.
const STEPS: usize = 12;
const FEWEST: usize = 3;
/// The method ends where the largest θ and its error together are below this.
const CLEAR: f64 = 0.7;
/// Curvatures above the negative of this count as none: motions that nothing determines have none.
const NEUTRAL: f64 = 1e-3;
/// What is added to the compliance of rows that depend on each other, relative to its largest diagonal entry.
const REDUNDANT: f64 = 1e-10;

/// A motion that the closed rows permit, and the curvature along it.
pub(super) struct Softest {
    /// The curvature relative to S: at most 1, and negative along a motion that releases energy.
    pub curvature: f64,
    /// The motion (n), its largest entry 1 or −1.
    pub motion: Vec<f64>,
}

impl Softest {
    /// Whether it proves that the equilibrium is unstable.
    pub fn is_unstable(&self) -> bool {
        self.curvature < -NEUTRAL
    }

    /// The softest motion found; `None` if the rows permit none. `lambda` has the multiplier of each row.
    pub fn new(
        here: &Linearization<'_>,
        tangent: &Tangent,
        condensed: &Condensed,
        lambda: &[f64],
        stop: &Stop,
    ) -> Result<Option<Self>, Halt> {
        let permitted = Permitted::new(here, tangent, condensed, lambda)?;
        let mut basis: Vec<Motion> = Vec::new();
        let mut projected = Mat::<f64>::zeros(STEPS, STEPS);
        let mut next = permitted.answer(&noise(here.load.len()))?;
        let size = next.norm();
        if !(size > 0.0) {
            return Ok(None);
        }
        next.scale(1.0 / size);
        loop {
            Halt::if_requested(stop)?;
            let k = basis.len();
            let mut pushed = here.curvature(&next.v);
            pushed
                .iter_mut()
                .zip(&next.Sv)
                .for_each(|(p, s)| *p = s - *p);
            basis.push(next);
            next = permitted.answer(&pushed)?;
            for (i, known) in basis.iter().enumerate() {
                // once more for round-off
                for _ in 0..2 {
                    let part = next.take_out(known);
                    projected[(i, k)] += part;
                }
                projected[(k, i)] = projected[(i, k)];
            }
            let rest = next.norm();
            let (theta, weights) = largest(&projected, k + 1)?;
            let error = rest * weights[k].abs();
            let is_clear = k + 1 >= FEWEST && theta + error < CLEAR;
            let is_over = is_clear || theta > 1.0 + NEUTRAL || k + 1 == STEPS;
            if is_over || !(rest > f64::EPSILON * theta.abs()) {
                return Ok(Some(Softest::combined(&basis, &weights, 1.0 - theta)));
            }
            next.scale(1.0 / rest);
        }
    }

    fn combined(basis: &[Motion], weights: &[f64], curvature: f64) -> Self {
        let mut motion = vec![0.0; basis[0].v.len()];
        for (part, weight) in basis.iter().zip(weights) {
            let entries = motion.iter_mut().zip(&part.v);
            entries.for_each(|(m, v)| *m += weight * v);
        }
        let largest = motion.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        motion.iter_mut().for_each(|v| *v /= largest);
        Softest { curvature, motion }
    }
}

/// A motion v and S v, but for forces on the rows A.
struct Motion {
    v: Vec<f64>,
    Sv: Vec<f64>,
}

impl Motion {
    /// √(vᵀS v).
    fn norm(&self) -> f64 {
        dot(&self.v, &self.Sv).max(0.0).sqrt()
    }

    fn scale(&mut self, factor: f64) {
        let entries = self.v.iter_mut().chain(&mut self.Sv);
        entries.for_each(|entry| *entry *= factor);
    }

    /// Takes out the part along another motion of norm 1, and returns it.
    fn take_out(&mut self, other: &Motion) -> f64 {
        let part = dot(&self.v, &other.Sv);
        let entries = self.v.iter_mut().zip(&other.v);
        entries.for_each(|(a, b)| *a -= part * b);
        let entries = self.Sv.iter_mut().zip(&other.Sv);
        entries.for_each(|(a, b)| *a -= part * b);
        part
    }
}

/// The motions that the rows with a force permit.
struct Permitted<'a> {
    here: &'a Linearization<'a>,
    tangent: &'a Tangent,
    condensed: &'a Condensed,
    rows: Vec<usize>,
    /// The factor of W_AA; `None` without rows.
    compliance: Option<Llt<f64>>,
}

impl<'a> Permitted<'a> {
    fn new(
        here: &'a Linearization<'a>,
        tangent: &'a Tangent,
        condensed: &'a Condensed,
        lambda: &[f64],
    ) -> Result<Self, Halt> {
        let places = condensed.rows.iter().enumerate();
        let places: Vec<(usize, usize)> = places
            .filter(|(_, row)| lambda[**row] > 0.0)
            .map(|(place, row)| (place, *row))
            .collect();
        let W = &condensed.W;
        let largest = places.iter().fold(0.0, |m: f64, &(p, _)| m.max(W[(p, p)]));
        let of = |a: usize, b: usize| W[(places[a].0, places[b].0)];
        let mut WAA = Mat::from_fn(places.len(), places.len(), of);
        (0..places.len()).for_each(|a| WAA[(a, a)] += REDUNDANT * largest);
        let compliance = match places.is_empty() {
            true => None,
            false => Some(WAA.llt(Side::Lower).map_err(|_| {
                Halt::Failed("the compliance of the closed rows is not positive".into())
            })?),
        };
        Ok(Permitted {
            here,
            tangent,
            condensed,
            rows: places.into_iter().map(|(_, row)| row).collect(),
            compliance,
        })
    }

    /// The motion that answers to `forces`, with the rows held.
    fn answer(&self, forces: &[f64]) -> Result<Motion, Halt> {
        let response = &self.condensed.response;
        let half = response.begun(self.tangent, forces)?;
        let mut held = vec![0.0; forces.len()];
        if let Some(compliance) = &self.compliance {
            let seen = response.seen(self.tangent, &half)?;
            let matrix = self.here.gaps.matrix();
            let mut y = Col::from_fn(self.rows.len(), |a| -matrix.times(self.rows[a], &seen));
            compliance.solve_in_place(y.as_mat_mut());
            let mut lambda = vec![0.0; self.here.gaps.len()];
            let rows = self.rows.iter().zip(y.iter());
            rows.for_each(|(&row, y)| lambda[row] = *y);
            self.here.gaps.add_forces(&lambda, &mut held);
        }
        let v = response.ended(self.tangent, half, &held)?;
        let Sv = held.iter().zip(forces).map(|(h, f)| h + f).collect();
        Ok(Motion { v, Sv })
    }
}

/// The largest eigenvalue of the leading `k` × `k` part, and its eigenvector.
fn largest(matrix: &Mat<f64>, k: usize) -> Result<(f64, Vec<f64>), Halt> {
    let part = Mat::from_fn(k, k, |i, j| matrix[(i, j)]);
    let eigen = part
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Halt::Failed("the curvature of the energy is not finite".into()))?;
    let values = eigen.S().column_vector();
    let last = (0..k).max_by(|&i, &j| values[i].total_cmp(&values[j]));
    let last = last.unwrap_or_default();
    let weights = (0..k).map(|i| eigen.U()[(i, last)]).collect();
    Ok((values[last], weights))
}

/// Entries between −1 and 1, the same in every run.
fn noise(n: usize) -> Vec<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15u64;
    let mut next = || {
        // xorshift64 (Marsaglia, J. Stat. Softw. 8 (2003))
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| next()).collect()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
