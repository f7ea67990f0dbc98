//! K by blocks: each is factored once, and kept until the values change.

use std::ops::Range;

use super::super::diagonal::diagonal;
use super::halt::Halt;
use crate::linear::{Analysis, Cholesky, Factor, FactorError, Kind, Ordering, SymmetricPattern};
use crate::{Cost, Energy, Stop, parallel};

/// n σ: a block of n unknowns that floats is factored as K + σ diag K, so that a motion without strain meets this many
/// entries of the diagonal as its stiffness, whatever n.
///
/// Smaller values take fewer rounds; larger ones leave more digits of the compliance. On Hertz's contact with 23 600
/// unknowns, σ = 1e-6, 1e-7, 1e-8, 1e-9 took 28, 8, 4, 3 rounds.
const SHIFT: f64 = 1e-4;

/// The stiffness K (UF/UL) of all bodies, with M = K on blocks that are positive definite and M = K + σ diag K on those
/// that float.
pub(super) struct Stiffness {
    pattern: SymmetricPattern,
    values: Vec<f64>,
    blocks: Vec<Block>,
}

/// A body: its unknowns and the factor of its block of M.
pub(super) struct Block {
    /// Its unknowns.
    pub range: Range<usize>,
    /// LLᵀ of its block.
    pub factor: Cholesky,
    /// The step that eliminates each of its unknowns.
    pub steps: Vec<usize>,
    /// Whether K alone is not positive definite.
    pub floats: bool,
}

impl Stiffness {
    /// Factors the Hessian `values` of `energy`: all blocks, then those that float once more.
    pub fn new(
        energy: &dyn Energy,
        values: Vec<f64>,
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<Self, Halt> {
        let pattern = energy.hessian_pattern().clone();
        let mut ranges = energy.blocks();
        ranges.retain(|range| !range.is_empty());
        Halt::if_requested(stop)?;
        let analyses = Analysis::of_blocks(&pattern, &ranges, &Ordering::Automatic)?;
        Halt::unless_may_factorize(stop)?;
        cost.factorizations += 1;
        let mut blocks =
            parallel::try_map(ranges.into_iter().zip(analyses), |(range, analysis)| {
                Block::new(&pattern, &values, range, &analysis, stop)
            })?;
        let fill = |block: &Block| block.factor.analysis().fill() as u64;
        cost.factor_entries += blocks.iter().map(fill).sum::<u64>();
        if blocks.iter().any(|block| block.floats) {
            Halt::unless_may_factorize(stop)?;
            cost.factorizations += 1;
            let floating = blocks.iter().filter(|block| block.floats);
            cost.factor_entries += floating.map(fill).sum::<u64>();
            let floating = blocks.iter_mut().filter(|block| block.floats);
            let diagonal = diagonal(&pattern, &values);
            let matrix = (&pattern, &values[..], &diagonal[..]);
            parallel::try_map(floating, |block| block.shift(matrix, stop))?;
        }
        Ok(Stiffness {
            pattern,
            values,
            blocks,
        })
    }

    /// Whether these are the Hessian of `energy`, and its blocks.
    pub fn is_of(&self, energy: &dyn Energy, values: &[f64]) -> bool {
        let mut ranges = energy.blocks();
        ranges.retain(|range| !range.is_empty());
        self.values == values
            && self.pattern == *energy.hessian_pattern()
            && self.blocks.iter().map(|block| &block.range).eq(&ranges)
    }

    /// The blocks in the order of their unknowns.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Whether any of them floats.
    pub fn floats(&self) -> bool {
        self.blocks.iter().any(|block| block.floats)
    }

    /// As [`Self::blocks`], to solve with them.
    pub fn blocks_mut(&mut self) -> &mut [Block] {
        &mut self.blocks
    }

    /// Entries of all factors.
    pub fn fill(&self) -> usize {
        let fills = self
            .blocks
            .iter()
            .map(|block| block.factor.analysis().fill());
        fills.sum()
    }

    /// Overwrites b (n, UF) with M⁻¹ b (n, UL).
    pub fn solve(&mut self, b: &mut [f64]) -> Result<(), Halt> {
        let mut parts = Vec::with_capacity(self.blocks.len());
        let (mut first, mut rest) = (0, b);
        for Block { range, factor, .. } in &mut self.blocks {
            let (own, after) = rest.split_at_mut(range.end - first);
            parts.push((factor, &mut own[range.start - first..]));
            (first, rest) = (range.end, after);
        }
        parallel::try_map(parts, |(factor, own)| factor.solve(own))?;
        Ok(())
    }

    /// K u into `forces` (n, UF), and Σ_j |K_ij u_j| into `sizes`, whose round-off `forces` carries.
    pub fn product(&self, u: &[f64], forces: &mut [f64], sizes: &mut [f64]) {
        forces.fill(0.0);
        sizes.fill(0.0);
        let rows = self.pattern.rows();
        for (j, u_j) in u.iter().enumerate() {
            let (mut sum, mut size) = (0.0, 0.0);
            let column = self.pattern.column(j);
            for (&i, k) in rows[column.clone()].iter().zip(&self.values[column]) {
                let force = k * u[i];
                sum += force;
                size += force.abs();
                if i != j {
                    let force = k * u_j;
                    forces[i] += force;
                    sizes[i] += force.abs();
                }
            }
            forces[j] += sum;
            sizes[j] += size;
        }
    }
}

impl Block {
    fn new(
        pattern: &SymmetricPattern,
        values: &[f64],
        range: Range<usize>,
        analysis: &Analysis,
        stop: &Stop,
    ) -> Result<Self, Halt> {
        let steps = analysis.steps();
        Halt::if_requested(stop)?;
        let mut factor = Cholesky::new(analysis, Kind::Llt)?;
        let values = &values[slots(pattern, &range)];
        let floats = match factor.refactor(values) {
            Ok(_) => false,
            Err(FactorError::NotPositiveDefinite { .. }) => true,
            Err(why) => return Err(why.into()),
        };
        Ok(Block {
            range,
            factor,
            steps,
            floats,
        })
    }

    /// Factors the block with its shift. K has a pattern, values and a diagonal.
    fn shift(
        &mut self,
        (pattern, values, diagonal): (&SymmetricPattern, &[f64], &[f64]),
        stop: &Stop,
    ) -> Result<(), Halt> {
        Halt::if_requested(stop)?;
        let own = &values[slots(pattern, &self.range)];
        let pattern = self.factor.analysis().pattern();
        let shifted = shifted(pattern, own, &diagonal[self.range.clone()]);
        match self.factor.refactor(&shifted) {
            Ok(_) => Ok(()),
            Err(why) => Err(indefinite(why, &self.range)),
        }
    }
}

/// The slots of a block.
fn slots(pattern: &SymmetricPattern, range: &Range<usize>) -> Range<usize> {
    pattern.column(range.start).start..pattern.column(range.end - 1).end
}

/// K + σ diag K.
fn shifted(pattern: &SymmetricPattern, values: &[f64], diagonal: &[f64]) -> Vec<f64> {
    let n = pattern.dim() as f64;
    let shifted = |((i, j), k): ((usize, usize), &f64)| match i == j {
        true => k + SHIFT / n * diagonal[j],
        false => *k,
    };
    pattern.iter().zip(values).map(shifted).collect()
}

fn indefinite(why: FactorError, range: &Range<usize>) -> Halt {
    match why {
        FactorError::NotPositiveDefinite { unknown } => Halt::Failed(format!(
            "the energy is not convex: the stiffness of unknowns {} to {} is not positive semidefinite (pivot at \
             unknown {})",
            range.start,
            range.end - 1,
            range.start + unknown
        )),
        why => why.into(),
    }
}
