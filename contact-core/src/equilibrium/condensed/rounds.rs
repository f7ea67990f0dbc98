//! The iteration on u and λ: contact on the condensed rows, then what is left of the forces.

use super::compliance::Compliance;
use super::coulomb::{Law, solve_coulomb};
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
/// A row whose gap shrinks by less than this share of a motion stays as it is.
const STAYS: f64 = 1e-10;
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
    /// The constant of each row (UL).
    pub constants: &'a [f64],
    /// The laws of the rows of slips.
    pub laws: &'a [Law],
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
        let mut last: Option<Vec<f64>> = None;
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
            if let Some(last) = last.take().filter(|_| is_slow(&ratios, 1)) {
                let moved: Vec<f64> = at.u.iter().zip(last).map(|(u, last)| u - last).collect();
                if let Some(times) = self.flight(&moved, &residual.forces, &gaps) {
                    let further = at.u.iter_mut().zip(moved);
                    further.for_each(|(u, d)| *u += times * d);
                    ratios.clear();
                    continue;
                }
            }
            self.check_progress(&ratios, &residual)?;
            last = self.stiffness.floats().then(|| at.u.clone());
            self.round(at, residual.forces)?;
        }
        Err(Halt::Failed(format!(
            "gaps or forces are not in equilibrium after {ROUNDS} rounds: {:.1e} times the bound on forces is left",
            ratios.last().copied().unwrap_or_default()
        )))
    }

    /// How many times the motion d of a round, along which forces work, can go on: to where the energy is least along it, or to where
    /// the next row closes. Nothing if that is nearer than one round more, or nowhere.
    ///
    /// A round moves a body that floats by its load over the small shift, which may be far less than the gaps around it.
    fn flight(&self, d: &[f64], forces: &[f64], gaps: &[f64]) -> Option<f64> {
        let (mut internal, mut sizes) = (vec![0.0; d.len()], vec![0.0; d.len()]);
        self.stiffness.product(d, &mut internal, &mut sizes);
        let dot = |a: &[f64]| a.iter().zip(d).map(|(a, d)| a * d).sum::<f64>();
        let roundoff: f64 = sizes.iter().zip(d).map(|(size, d)| size * d.abs()).sum();
        let (work, curvature) = (dot(forces), dot(&internal));
        let least = match curvature > ROUNDOFF * roundoff {
            true => work / curvature,
            false => f64::INFINITY,
        };
        let largest = d.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let closing = (0..self.rows.contacts()).filter_map(|k| {
            let rate = self.rows.product(k, d);
            (rate < -STAYS * largest).then(|| gaps[k].max(0.0) / -rate)
        });
        let times = closing.fold(least, f64::min);
        (work > 0.0 && times.is_finite() && times > 1.0).then_some(times)
    }

    /// One proximal step from the `residual` f + Cᵀλ − K u.
    fn round(&mut self, at: &mut Iterate, mut residual: Vec<f64>) -> Result<(), Halt> {
        self.stiffness.solve(&mut residual)?;
        at.u.iter_mut()
            .zip(&residual)
            .for_each(|(u, step)| *u += step);
        let mut gaps = self.gaps(&at.u);
        let acting = (0..self.rows.contacts()).filter(|&k| at.lambda[k] > 0.0);
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
        let rows = (0..self.rows.contacts()).filter(overlaps);
        let rows = rows.filter(|&k| self.rows.is_of_prescribed(k) == of_prescribed);
        let mut rows: Vec<usize> = rows.collect();
        if self.stiffness.floats() {
            rows.sort_by(|&a, &b| gaps[a].total_cmp(&gaps[b]));
            rows.truncate(self.compliance.rows().len().max(FIRST));
        }
        rows
    }

    /// Takes rows of the gaps into the working set, and the rows of slips that they press on.
    fn extend(&mut self, mut more: Vec<usize>) -> Result<(), Halt> {
        let pressed: Vec<usize> = more
            .iter()
            .flat_map(|&k| self.rows.pressed_by(k))
            .copied()
            .collect();
        more.extend(pressed);
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
        let solved = solve_coulomb(W, &gaps, &start, &self.laws_among(rows), bound, self.stop)?;
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

    /// The laws of the rows of slips among `rows`, by their places there.
    fn laws_among(&self, rows: &[usize]) -> Vec<Law> {
        if self.laws.is_empty() {
            return Vec::new();
        }
        let mut places = vec![None; self.rows.len()];
        rows.iter()
            .enumerate()
            .for_each(|(place, &k)| places[k] = Some(place));
        let placed = self.laws.iter().map(|law| law.placed(|row| places[row]));
        placed.flatten().collect()
    }

    /// C u + c₀ of the gaps, and T u + d of the slips.
    fn gaps(&self, u: &[f64]) -> Vec<f64> {
        let gap = |(k, c): (usize, &f64)| self.rows.product(k, u) + c;
        self.constants.iter().enumerate().map(gap).collect()
    }

    /// The bound on overlaps at u (UL). It is not below the round-off of the displacements of bodies in contact, which may be
    /// large where those at their rows are not, as those of a body at rest.
    fn bound(&self, u: &[f64]) -> f64 {
        let row = |k: usize| {
            let terms = self.rows.row(k).iter().map(|&(j, a)| (a * u[j]).abs());
            // slips are differences from the last state
            let last = if k < self.rows.contacts() {
                0.0
            } else {
                self.constants[k].abs()
            };
            terms.sum::<f64>() + last
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
    /// where rows are exactly closed or without a force. Slips count by the share that their force lacks to the threshold.
    fn openness(&self, gaps: &[f64], lambda: &[f64], bound: f64) -> f64 {
        let contacts = self.rows.contacts();
        let largest = lambda[..contacts].iter().fold(0.0, |m: f64, l| m.max(*l));
        let of_contact = gaps.iter().zip(lambda).take(contacts).map(|(&c, &l)| {
            let share = if l > 0.0 { l / largest } else { 0.0 };
            (-c).max(c.max(0.0) * share)
        });
        let of_slips = self.laws.iter().map(|law| {
            let tau = law.threshold(lambda[law.contact]);
            let slip = gaps[law.slip];
            let lacks = law.lacks(lambda[law.slip], slip, lambda[law.contact]);
            // of its own threshold, which may be far below the largest force
            let share = if lacks > 0.0 { 0.5 * lacks / tau } else { 0.0 };
            slip.abs() * share
        });
        let mut worst = 0.0;
        for open in of_contact.chain(of_slips) {
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
        if now <= 1.0 || !is_slow(ratios, PATIENCE) {
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

/// Whether the last of these ratios is more than half of the one so many rounds before it.
fn is_slow(ratios: &[f64], rounds: usize) -> bool {
    let before = ratios.len().checked_sub(1 + rounds).map(|k| ratios[k]);
    let now = ratios.last().copied();
    before
        .zip(now)
        .is_some_and(|(before, now)| now > 0.5 * before)
}
