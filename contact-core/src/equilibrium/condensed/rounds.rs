//! The iteration on u and λ: contact on the condensed rows, then what is left of the forces.

use super::complementarity;
use super::compliance::Compliance;
use super::halt::Halt;
use super::rows::Rows;
use super::stiffness::Stiffness;
use crate::{Cost, Stop};

/// Bound on what is left of the forces on a block, relative to the largest force on one of its unknowns.
const STATIONARITY: f64 = 1e-11;
/// The same, in units of the round-off of K u. A backward stable solve leaves some ten of it.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;
/// The same, in units of the round-off of the round-off of the largest K u of all rounds: what is left where a body without a
/// load comes back to rest, two solves later. With a load it is far below the others.
const AT_REST: f64 = ROUNDOFF * ROUNDOFF;
/// Bound on overlaps, and on gaps where forces act, relative to the largest Σ_j |C_ij u_j| of a row.
const GAP: f64 = 1e-10;
/// The same, relative to the smallest displacement that matters at contact; the smaller of the two counts.
const RESOLUTION: f64 = 1e-10;
/// Where rounds no longer reach that bound, this many times it suffices: the compliance of a body that floats has the
/// round-off of its small shift.
const SUFFICES: f64 = 1e5;
/// The share of the bound left to the condensed problem.
const SHARE: f64 = 0.1;
/// While the working set grows, the condensed problem is solved this much less accurately.
const ROUGH: f64 = 1e4;
/// The limit of rounds. Blocks that do not float take two or three.
const ROUNDS: usize = 60;
/// Rounds after which what is left of the forces on blocks that float must have shrunk to a half.
const PATIENCE: usize = 6;
/// The first rows taken into the working set where a body floats.
const FIRST: usize = 64;

/// An iterate.
pub(super) struct Iterate {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// The multipliers of the distinct rows (UF).
    pub lambda: Vec<f64>,
}

/// What the rounds work with: K and its factors, the rows with their constants, the compliance, and the load.
pub(super) struct Rounds<'a> {
    pub stiffness: &'a mut Stiffness,
    pub compliance: &'a mut Compliance,
    pub rows: &'a Rows,
    /// The constant of each distinct row (UL).
    pub constants: &'a [f64],
    /// The smallest displacement that matters at contact (UL).
    pub resolution: f64,
    /// f = −∇E(0) (n, UF).
    pub load: &'a [f64],
    pub stop: &'a Stop,
    pub cost: &'a mut Cost,
}

/// What is left of the forces, and how it compares with the bound.
struct Residual {
    forces: Vec<f64>,
    /// The largest ratio of any block to its bound, and that block.
    ratio: f64,
    block: usize,
}

impl Rounds<'_> {
    /// Minimises ½uᵀKu − fᵀu subject to C u + c₀ ≥ 0 from `at`, which ends up as the last iterate.
    ///
    /// A round minimises E(v) + ½|v − u|² in the norm of M − K, which is zero but on blocks that float. Its minimum for
    /// given λ is u + M⁻¹(f + Cᵀλ − K u), and λ follows from the complementarity of the condensed rows. Where no block
    /// floats, the first round is the solution, and the next ones remove round-off.
    pub fn run(&mut self, at: &mut Iterate) -> Result<(), Halt> {
        let mut ratios = Vec::new();
        let mut before = f64::INFINITY;
        let mut sizes = vec![0.0; self.stiffness.blocks().len()];
        for _ in 0..ROUNDS {
            Halt::if_requested(self.stop)?;
            let residual = self.residual(at, &mut sizes);
            let gaps = self.gaps(&at.u);
            let bound = self.bound(&at.u);
            let open = self.openness(&gaps, &at.lambda, bound);
            let is_stuck = open <= SUFFICES && open > 0.5 * before;
            if residual.ratio <= 1.0 && (open <= 1.0 || is_stuck) {
                return Ok(());
            }
            before = open;
            if !(residual.ratio.is_finite() && bound.is_finite()) {
                return Err(Halt::Failed("the iterates are not finite".into()));
            }
            ratios.push(residual.ratio);
            self.check_progress(&ratios, &residual)?;
            self.round(at, residual.forces)?;
        }
        Err(Halt::Failed(format!(
            "gaps or forces are not in equilibrium after {ROUNDS} rounds: {:.1e} times the bound on forces is left",
            ratios.last().copied().unwrap_or_default()
        )))
    }

    /// One proximal step from the `residual` f + Cᵀλ − K u.
    fn round(&mut self, at: &mut Iterate, mut residual: Vec<f64>) -> Result<(), Halt> {
        self.stiffness.solve(&mut residual)?;
        at.u.iter_mut()
            .zip(&residual)
            .for_each(|(u, step)| *u += step);
        let mut gaps = self.gaps(&at.u);
        let acting = (0..self.rows.len()).filter(|&k| at.lambda[k] > 0.0);
        self.extend(acting.filter(|&k| !self.compliance.holds(k)).collect())?;
        let mut is_final = false;
        loop {
            let overlap = self.bound(&at.u);
            let mut more = self.overlapping(&gaps, overlap, false);
            if more.is_empty() && (is_final || self.compliance.rows().is_empty()) {
                // the others are closed accurately, and mostly close these, too
                more = self.overlapping(&gaps, overlap, true);
                if more.is_empty() {
                    return Ok(());
                }
            }
            is_final = more.is_empty();
            self.extend(more)?;
            // of this u, since contact alone may move bodies, as in an interference fit
            let bound = if is_final { SHARE } else { SHARE * ROUGH } * overlap;
            let change = self.complement(&gaps, bound, &mut at.lambda)?;
            let mut step = vec![0.0; at.u.len()];
            self.rows.add_forces(&change, &mut step);
            self.stiffness.solve(&mut step)?;
            at.u.iter_mut().zip(&step).for_each(|(u, step)| *u += step);
            gaps = self.gaps(&at.u);
        }
    }

    /// Rows without a place in the working set whose gaps are below −`overlap`, of passes whose slave is prescribed or of the other
    /// ones. Where a body floats, all of a surface may be: then the deepest ones, as many as the working set has.
    fn overlapping(&self, gaps: &[f64], overlap: f64, of_prescribed: bool) -> Vec<usize> {
        let overlaps = |&k: &usize| !self.compliance.holds(k) && gaps[k] < -overlap;
        let rows = (0..self.rows.len()).filter(overlaps);
        let rows = rows.filter(|&k| self.rows.is_of_prescribed(k) == of_prescribed);
        let mut rows: Vec<usize> = rows.collect();
        if self.stiffness.floats() {
            rows.sort_by(|&a, &b| gaps[a].total_cmp(&gaps[b]));
            rows.truncate(self.compliance.rows().len().max(FIRST));
        }
        rows
    }

    fn extend(&mut self, more: Vec<usize>) -> Result<(), Halt> {
        match more.is_empty() {
            true => Ok(()),
            false => self
                .compliance
                .extend(&more, self.rows, self.stiffness, self.stop),
        }
    }

    /// Changes λ of the working set, which has these `gaps`, to the solution of the condensed problem; the change.
    fn complement(
        &mut self,
        gaps: &[f64],
        bound: f64,
        lambda: &mut [f64],
    ) -> Result<Vec<f64>, Halt> {
        let rows = self.compliance.rows();
        let of = |values: &[f64]| rows.iter().map(|&k| values[k]).collect::<Vec<_>>();
        let (gaps, start) = (of(gaps), of(lambda));
        let W = self.compliance.matrix();
        let solved = complementarity::solve(W, &gaps, &start, bound, self.stop)?;
        if solved.left > SUFFICES / SHARE {
            return Err(Halt::Failed(format!(
                "gaps and forces of the condensed problem are not complementary: {:.1e} times the bound is left",
                solved.left
            )));
        }
        self.cost.solves += 1;
        self.cost.inner_iterations += solved.steps;
        let mut change = vec![0.0; lambda.len()];
        for (&k, l) in rows.iter().zip(&solved.lambda) {
            change[k] = l - lambda[k];
            lambda[k] = *l;
        }
        Ok(change)
    }

    /// C u + c₀ of the distinct rows.
    fn gaps(&self, u: &[f64]) -> Vec<f64> {
        let gap = |(k, c): (usize, &f64)| self.rows.product(k, u) + c;
        self.constants.iter().enumerate().map(gap).collect()
    }

    /// The bound on overlaps at u (UL). It is not below the round-off of the displacements of bodies in contact, which may be
    /// large where those at their rows are not, as those of a body at rest.
    fn bound(&self, u: &[f64]) -> f64 {
        let row = |k: usize| {
            let terms = self.rows.row(k).iter().map(|&(j, a)| (a * u[j]).abs());
            terms.sum::<f64>()
        };
        let size = (0..self.rows.len()).map(row).fold(0.0, f64::max);
        let displacements = self.stiffness.blocks().iter().map(|block| {
            let own = u[block.range.clone()].iter();
            own.fold(0.0, |most: f64, u| most.max(u.abs()))
        });
        let displacements: Vec<f64> = displacements.collect();
        let block_of = |j: usize| {
            let blocks = self.stiffness.blocks();
            blocks.partition_point(|block| block.range.end <= j)
        };
        let in_contact = (0..self.rows.len()).flat_map(|k| self.rows.row(k));
        let largest = in_contact
            .map(|&(j, _)| displacements[block_of(j)])
            .fold(0.0, f64::max);
        (GAP * size)
            .min(RESOLUTION * self.resolution)
            .max(ROUNDOFF * size.max(largest))
    }

    /// The largest overlap, and the largest gap times the share that its row has of the largest force, over the bound; zero
    /// where rows are exactly closed or without a force.
    fn openness(&self, gaps: &[f64], lambda: &[f64], bound: f64) -> f64 {
        let largest = lambda.iter().fold(0.0, |m: f64, l| m.max(*l));
        let mut worst = 0.0;
        for (&c, &l) in gaps.iter().zip(lambda) {
            let share = if l > 0.0 { l / largest } else { 0.0 };
            let open = (-c).max(c.max(0.0) * share);
            // NaN counts
            if !(open <= worst) {
                worst = open;
            }
        }
        match worst > 0.0 {
            true => worst / bound,
            false => worst,
        }
    }

    /// What is left at an iterate; `most` has the largest forces on each block so far (UF).
    fn residual(&self, at: &Iterate, most: &mut [f64]) -> Residual {
        let n = at.u.len();
        let mut forces = vec![0.0; n];
        self.rows.add_forces(&at.lambda, &mut forces);
        let (mut internal, mut sizes) = (vec![0.0; n], vec![0.0; n]);
        self.stiffness.product(&at.u, &mut internal, &mut sizes);
        let (mut ratio, mut worst) = (0.0, 0);
        for (b, block) in self.stiffness.blocks().iter().enumerate() {
            let (mut left, mut largest, mut size) = (0.0f64, 0.0f64, 0.0f64);
            for i in block.range.clone() {
                let (load, contact) = (self.load[i], forces[i]);
                largest = largest.max(load.abs()).max(contact.abs());
                size = size.max(sizes[i] + load.abs() + contact.abs());
                forces[i] = load + contact - internal[i];
                left = left.max(forces[i].abs());
            }
            most[b] = most[b].max(size);
            let bound = (STATIONARITY * largest)
                .max(ROUNDOFF * size)
                .max(AT_REST * most[b]);
            let block_ratio = if left > 0.0 { left / bound } else { left };
            if !(block_ratio <= ratio) {
                (ratio, worst) = (block_ratio, b);
            }
        }
        Residual {
            forces,
            ratio,
            block: worst,
        }
    }

    /// Ends the rounds where what is left of the forces no longer shrinks.
    fn check_progress(&self, ratios: &[f64], residual: &Residual) -> Result<(), Halt> {
        let now = residual.ratio;
        let block = &self.stiffness.blocks()[residual.block];
        let before = ratios.len().checked_sub(1 + PATIENCE).map(|k| ratios[k]);
        if now <= 1.0 || !before.is_some_and(|before| now > 0.5 * before) {
            return Ok(());
        }
        let (first, last) = (block.range.start, block.range.end - 1);
        Err(Halt::Failed(match block.floats {
            true => format!(
                "neither supports nor contact hold the body of unknowns {first} to {last} against its load: prescribe \
                 what keeps it in place, or check that it meets another body"
            ),
            false => format!(
                "the forces on unknowns {first} to {last} are not in equilibrium to round-off: {now:.1e} times the \
                 bound is left"
            ),
        }))
    }
}
