//! Whether an equilibrium is stable.
//!
//! It is a strict minimum, as far as second derivatives tell, if K − sym D is positive on the motions v that the rows A with
//! a force permit, C_A v = 0. Relative to the matrix S that is factored, this curvature is 1 − θ with
//!
//! (S − K + sym D) v = θ S v + C_Aᵀ y,   C_A v = 0.
//!
//! Lanczos' method approximates the largest θ from below by a few solves with S. A value below 1 is no proof that the equilibrium is stable.
//!
//! Nor does a value above 1 prove that it is unstable, where forces have no potential: D is not symmetric then, and what keeps the gaps closed is
//! G_A v = 0. Newton's matrix becomes singular where θ = 1 is an eigenvalue of
//!
//! (S − K + D) v = θ S v + C_Aᵀ y,   G_A v = 0.
//!
//! So an equilibrium that the symmetric part calls unstable is examined once more, by Arnoldi's method from the motion found. The largest θ of this
//! problem decides. In one state of a disc in a ring, under a pressure of twice the ring's modulus, it is 0.68, where the symmetric part has 1.016.

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
/// The most corrections of a motion that closed rows permit, and what they may leave of the gaps, as a share of the motion.
const CORRECTIONS: usize = 10;
const CLOSED: f64 = 1e-5;
/// By how much the last step of Arnoldi's method may change the curvature, as a share of it.
const SETTLED: f64 = 0.1;
/// What is added to the compliance of rows that depend on each other, relative to its largest diagonal entry.
const REDUNDANT: f64 = 1e-10;

/// A motion that the closed rows permit, and the curvature along it.
pub(super) struct Softest {
    /// The curvature relative to S: at most 1, and negative along a motion that releases energy.
    pub curvature: f64,
    /// Whether it is known well: θ and its error are small, or the problem that is not symmetric has decided.
    is_clear: bool,
    /// The motion (n), its largest entry 1 or −1.
    pub motion: Vec<f64>,
}

impl Softest {
    /// Whether it shows that the equilibrium is unstable.
    pub fn is_unstable(&self) -> bool {
        self.curvature < -NEUTRAL
    }

    /// The curvature, if it shows that the equilibrium is stable: it is positive, and known well. At most 1.
    pub fn stable(&self) -> Option<f64> {
        let is_stable = self.is_clear && self.curvature > 0.0;
        is_stable.then(|| self.curvature.min(1.0))
    }

    /// The softest motion found; `None` if the rows permit none. `lambda` has the multiplier of each row. Where bodies `float`, the symmetric
    /// problem alone decides: it is their motions that nothing resists which are held.
    pub fn new(
        here: &Linearization<'_>,
        tangent: &Tangent,
        (condensed, lambda): (&Condensed, &[f64]),
        floats: bool,
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
                let mut softest = Softest {
                    curvature: 1.0 - theta,
                    is_clear,
                    motion: combined(&basis, &weights),
                };
                if softest.is_unstable() && !floats && !here.is_frozen() {
                    if let Some(theta) = permitted.largest(&softest.motion, stop)? {
                        (softest.curvature, softest.is_clear) = (1.0 - theta, true);
                    }
                }
                return Ok(Some(softest));
            }
            next.scale(1.0 / rest);
        }
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
        let mut gaps = Vec::new();
        if !self.rows.is_empty() {
            let seen = response.seen(self.tangent, &half)?;
            let matrix = self.here.gaps.matrix();
            gaps.extend(self.rows.iter().map(|&row| matrix.times(row, &seen)));
        }
        let held = self.closing(&gaps, forces.len());
        let v = response.ended(self.tangent, half, &held)?;
        let Sv = held.iter().zip(forces).map(|(h, f)| h + f).collect();
        Ok(Motion { v, Sv })
    }

    /// The forces (n, UF) on the rows that take back changes of their gaps by `gaps`.
    fn closing(&self, gaps: &[f64], n: usize) -> Vec<f64> {
        let mut forces = vec![0.0; n];
        if let Some(compliance) = &self.compliance {
            let mut y = Col::from_fn(gaps.len(), |a| -gaps[a]);
            compliance.solve_in_place(y.as_mat_mut());
            let mut lambda = vec![0.0; self.here.gaps.len()];
            let rows = self.rows.iter().zip(y.iter());
            rows.for_each(|(&row, y)| lambda[row] = *y);
            self.here.gaps.add_forces(&lambda, &mut forces);
        }
        forces
    }

    /// The largest real part of a θ of the problem that is not symmetric, by Arnoldi's method from a motion; `None` where that finds none.
    fn largest(&self, from: &[f64], stop: &Stop) -> Result<Option<f64>, Halt> {
        let mut basis: Vec<Motion> = Vec::new();
        let mut projected = Mat::<f64>::zeros(STEPS + 1, STEPS);
        let mut next = Motion {
            v: from.to_vec(),
            Sv: self.tangent.times(from),
        };
        let size = next.norm();
        next.scale(1.0 / size);
        loop {
            Halt::if_requested(stop)?;
            let k = basis.len();
            let resisted = self.here.stiffness_times(&next.v);
            let pushed: Vec<f64> = next.Sv.iter().zip(&resisted).map(|(s, f)| s - f).collect();
            basis.push(next);
            let Some(answer) = self.answer_in_contact(&pushed)? else {
                return Ok(None);
            };
            next = answer;
            for (i, known) in basis.iter().enumerate() {
                // once more for round-off
                for _ in 0..2 {
                    projected[(i, k)] += next.take_out(known);
                }
            }
            let rest = next.norm();
            projected[(k + 1, k)] = rest;
            let is_exact = !(rest > f64::EPSILON);
            if k + 1 == STEPS || is_exact {
                let [last, before] = [k + 1, k].map(|k| largest_real_part(&projected, k));
                let is_settled = is_exact || (last - before).abs() <= SETTLED * (1.0 - last).abs();
                return Ok(Some(last).filter(|theta| is_settled && theta.is_finite()));
            }
            next.scale(1.0 / rest);
        }
    }

    /// As [`Permitted::answer`], of a motion that keeps the gaps of the rows themselves, G_A v = 0; `None` where corrections do not find it.
    fn answer_in_contact(&self, forces: &[f64]) -> Result<Option<Motion>, Halt> {
        let response = &self.condensed.response;
        let mut motion = self.answer(forces)?;
        let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        for _ in 0..CORRECTIONS {
            let gaps = self.here.gap_changes(&self.rows, &motion.v);
            if largest(&gaps) <= CLOSED * largest(&motion.v) {
                return Ok(Some(motion));
            }
            let held = self.closing(&gaps, forces.len());
            let half = response.begun(self.tangent, &held)?;
            let change = response.ended(self.tangent, half, &vec![0.0; forces.len()])?;
            let entries = motion.v.iter_mut().zip(&change);
            entries.for_each(|(v, c)| *v += c);
            let entries = motion.Sv.iter_mut().zip(&held);
            entries.for_each(|(s, h)| *s += h);
        }
        Ok(None)
    }
}

/// Σ weight · motion, with a largest entry of 1 or −1.
fn combined(basis: &[Motion], weights: &[f64]) -> Vec<f64> {
    let mut motion = vec![0.0; basis[0].v.len()];
    for (part, weight) in basis.iter().zip(weights) {
        let entries = motion.iter_mut().zip(&part.v);
        entries.for_each(|(m, v)| *m += weight * v);
    }
    let largest = motion.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    motion.iter_mut().for_each(|v| *v /= largest);
    motion
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

/// The largest real part of an eigenvalue of the leading `k` × `k` part; NaN if there is none.
fn largest_real_part(matrix: &Mat<f64>, k: usize) -> f64 {
    let part = Mat::from_fn(k, k, |i, j| matrix[(i, j)]);
    let values = part.eigenvalues().unwrap_or_default();
    let parts = values.into_iter().map(|theta| theta.re);
    parts.fold(f64::NAN, f64::max)
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
