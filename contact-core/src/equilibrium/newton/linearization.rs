//! The contact problem at one u, to the order that Newton's method needs.

use std::time::Instant;

use super::super::condensed::halt::Halt;
use super::super::diagonal::diagonal;
use super::point::Point;
use super::slips::Slips;
use crate::linear::SymmetricPattern;
use crate::{ContactProblem, Cost, GapVariation, LinearGaps, Stop};

/// E and the gaps at u.
pub(super) struct Linearization<'a> {
    /// The rows of contact and of slips.
    pub gaps: &'a LinearGaps,
    pub slips: &'a Slips,
    pub pattern: &'a SymmetricPattern,
    /// −∇E (n, UF).
    pub load: Vec<f64>,
    /// K, one value per slot.
    pub hessian: Vec<f64>,
    /// c (m, UL).
    pub c: Vec<f64>,
    /// K_jj (n, UF/UL), as [`diagonal`] has it.
    pub diagonal: Vec<f64>,
    /// s_i = (Σ_j C_ij²/K_jj)⁻¹ (UF/UL): the stiffness of row i if K were its diagonal.
    pub stiffness: Vec<f64>,
    /// Whether some unknown moves the row. The others take no part.
    moves: Vec<bool>,
    /// λ of the rows that act (m, UF), and of all rows of slips; zero for the others.
    pub lambda: Vec<f64>,
    /// Whether a row acts: λ_i > s_i c_i. A row of slips acts where it sticks.
    pub acts: Vec<bool>,
    /// Whether the row's variation is known: it acts, or overlaps.
    matters: Vec<bool>,
    variation: Option<GapVariation>,
    /// That of the forces along slips, of which the forces alone count.
    of_slips: Option<GapVariation>,
    /// What of K is the stiffness of springs, which do not count in the curvature (n, UF/UL); empty without springs.
    pub springs: &'a [f64],
    /// Whether the equilibrium nearby is known to be stable: a shift of the diagonal then helps to solve for a step, and does not shorten it.
    pub is_stable: bool,
}

impl<'a> Linearization<'a> {
    /// At a point with its rows, which are taken as frozen unless the linearisation `varies` them.
    pub fn new(
        problem: &'a dyn ContactProblem,
        at: &'a Point,
        varies: bool,
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<Self, Halt> {
        Halt::if_requested(stop)?;
        let Point {
            state, gaps, slips, ..
        } = at;
        let (energy, u, m) = (problem.energy(), &state.u, gaps.len());
        let pattern = energy.hessian_pattern();
        let (mut load, mut hessian) = (vec![0.0; energy.dofs()], vec![0.0; pattern.len()]);
        let clock = Instant::now();
        energy.gradient(u, &mut load);
        Halt::if_requested(stop)?;
        energy.hessian(u, &mut hessian);
        Halt::if_requested(stop)?;
        cost.callbacks += clock.elapsed().as_secs_f64();
        cost.gradients += 1;
        cost.hessians += 1;
        load.iter_mut().for_each(|g| *g = -*g);
        let mut c = vec![0.0; m];
        gaps.value(u, &mut c);
        let values = load.iter().chain(&hessian).chain(&c);
        if values.into_iter().any(|value| !value.is_finite()) {
            return Err(Halt::Failed(
                "a derivative of the energy or a gap is not finite".into(),
            ));
        }
        let entries = |i: usize| gaps.matrix().row(i).filter(|(_, a)| *a != 0.0);
        let moves: Vec<bool> = (0..m).map(|i| entries(i).next().is_some()).collect();
        let diagonal = diagonal(pattern, &hessian);
        let compliance = |i: usize| {
            entries(i)
                .map(|(j, a)| a * a / diagonal[j].abs())
                .sum::<f64>()
        };
        let stiffness = |i: usize| if moves[i] { 1.0 / compliance(i) } else { 0.0 };
        let stiffness: Vec<f64> = (0..m).map(stiffness).collect();
        let known = gaps
            .keys()
            .iter()
            .map(|&key| finite(state.multipliers.of(key)));
        let known: Vec<f64> = known.collect();
        let presses = |i: usize| moves[i] && known[i] > stiffness[i] * c[i];
        let acts = |i: usize| match slips.law(i) {
            None => presses(i),
            Some(law) => {
                let threshold = law.threshold(known[law.contact]);
                let sticks = (known[i] - stiffness[i] * c[i]).abs() < threshold;
                moves[i] && presses(law.contact) && sticks
            }
        };
        let acts: Vec<bool> = (0..m).map(acts).collect();
        let is_kept = |i: usize| slips.law(i).map_or(acts[i], |law| acts[law.contact]);
        let lambda = |i: usize| if is_kept(i) { known[i] } else { 0.0 };
        let mut lambda: Vec<f64> = (0..m).map(lambda).collect();
        slips.cut(&mut lambda);
        let matters = |i: usize| i < slips.contacts() && (acts[i] || c[i] < 0.0);
        let matters: Vec<bool> = (0..m).map(matters).collect();
        let clock = Instant::now();
        let contacts = slips.contacts();
        let asked = (0..contacts).map(|i| matters[i].then_some(lambda[i]));
        let asked: Vec<Option<f64>> = asked.collect();
        let of_contact = slips.contact_rows(gaps);
        let variation = match varies {
            true => problem.vary_gaps(u, &of_contact, &asked)?,
            false => None,
        };
        let of_slips = match varies && !slips.laws().is_empty() {
            true => {
                let mut forces = vec![None; contacts];
                for law in slips.laws() {
                    forces[law.contact] = Some(lambda[law.slip]).filter(|z| *z != 0.0);
                }
                problem.vary_slips(u, &of_contact, &forces)?
            }
            false => None,
        };
        for variation in variation.iter().chain(&of_slips) {
            variation.check(contacts, u.len())?;
        }
        cost.projection += clock.elapsed().as_secs_f64();
        Ok(Linearization {
            gaps,
            slips,
            pattern,
            load,
            hessian,
            c,
            diagonal,
            stiffness,
            moves,
            lambda,
            acts,
            matters,
            variation,
            of_slips,
            springs: &[],
            is_stable: false,
        })
    }

    /// Whether row i would overlap by more than `bound` (UL) at the gap `c`, and something can be done about it.
    pub fn overlaps(&self, i: usize, c: f64, bound: f64) -> bool {
        self.moves[i] && i < self.slips.contacts() && c < -bound
    }

    /// The entries of D.
    pub fn contact_stiffness(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        self.variations().flat_map(GapVariation::stiffness)
    }

    /// All that has a part in D.
    fn variations(&self) -> impl Iterator<Item = &GapVariation> {
        self.variation.iter().chain(&self.of_slips)
    }

    /// K v (n, UF), without springs.
    fn elastic_times(&self, v: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; v.len()];
        self.pattern.product(&self.hessian, v, &mut forces);
        let springs = self.springs.iter().zip(v);
        let pulls = forces.iter_mut().zip(springs);
        pulls.for_each(|(force, (w, v))| *force -= w * v);
        forces
    }

    /// (K − sym D) v (n, UF), without springs.
    pub fn curvature(&self, v: &[f64]) -> Vec<f64> {
        let mut forces = self.elastic_times(v);
        for variation in self.variations() {
            let half: Vec<f64> = v.iter().map(|v| -0.5 * v).collect();
            variation.add_forces(&half, &variation.internal(&half), &mut forces);
            variation.add_transposed_forces(&half, &mut forces);
        }
        forces
    }

    /// (K − D) v (n, UF), without springs.
    pub fn stiffness_times(&self, v: &[f64]) -> Vec<f64> {
        let mut forces = self.elastic_times(v);
        for variation in self.variations() {
            let back: Vec<f64> = v.iter().map(|v| -v).collect();
            variation.add_forces(&back, &variation.internal(&back), &mut forces);
        }
        forces
    }

    /// G v of some `rows` (UL).
    pub fn gap_changes(&self, rows: &[usize], v: &[f64]) -> Vec<f64> {
        let y = self.variation.as_ref().map(|own| own.internal(v));
        let change = |&i: &usize| self.gap_change(i, v, y.as_deref());
        rows.iter().map(change).collect()
    }

    /// Whether G = C and D = 0.
    pub fn is_frozen(&self) -> bool {
        self.variation.is_none()
    }

    /// −∇E − (K + `shift` diag K − D) x − Σ s_i C_iᵀ(c + G x)_i (n), with s the `added` stiffness, and c + G x (m).
    pub fn defect(&self, x: &[f64], added: &[f64], shift: f64) -> (Vec<f64>, Vec<f64>) {
        let mut forces = vec![0.0; x.len()];
        self.pattern.product(&self.hessian, x, &mut forces);
        for (j, force) in forces.iter_mut().enumerate() {
            *force = self.load[j] - *force - shift * self.diagonal[j].abs() * x[j];
        }
        let y = self.variation.as_ref().map(|own| own.internal(x));
        if let Some((variation, y)) = self.variation.as_ref().zip(y.as_deref()) {
            variation.add_forces(x, y, &mut forces);
        }
        if let Some(variation) = &self.of_slips {
            variation.add_forces(x, &variation.internal(x), &mut forces);
        }
        let gaps = self.gaps_after(x, y.as_deref());
        let pulled: Vec<f64> = added.iter().zip(&gaps).map(|(s, gap)| -s * gap).collect();
        self.gaps.add_forces(&pulled, &mut forces);
        (forces, gaps)
    }

    /// c + G x (m), with the internal variables `y` of x where rows vary.
    fn gaps_after(&self, x: &[f64], y: Option<&[f64]>) -> Vec<f64> {
        let all = self.c.iter().enumerate();
        all.map(|(i, c)| c + self.gap_change(i, x, y)).collect()
    }

    /// (G x)_i (UL), with the internal variables `y` of x where rows vary.
    fn gap_change(&self, i: usize, x: &[f64], y: Option<&[f64]>) -> f64 {
        let varied = self.variation.as_ref().zip(y);
        match varied.filter(|_| self.matters[i]) {
            Some((variation, y)) => variation.gap(i, x, y),
            None => self.gaps.matrix().times(i, x),
        }
    }

    /// The forces of rows with the multipliers μ after the step x (m, UF): a step may leave gaps of up to `bound` (UL), by which the `added` stiffness pulls.
    pub fn pushes(&self, x: &[f64], lambda: Vec<f64>, added: &[f64], bound: f64) -> Vec<f64> {
        if added.iter().all(|s| *s == 0.0) {
            return lambda;
        }
        let y = self.variation.as_ref().map(|own| own.internal(x));
        let gaps = self.gaps_after(x, y.as_deref());
        let push = |(i, l): (usize, f64)| l - added[i] * gaps[i].clamp(-bound, bound);
        let mut pushes: Vec<f64> = lambda.iter().copied().enumerate().map(push).collect();
        self.slips.follow(&lambda, &mut pushes);
        pushes
    }
}

/// A multiplier that is no number is none.
fn finite(lambda: f64) -> f64 {
    if lambda.is_finite() { lambda } else { 0.0 }
}
