//! A state with the rows at it.

use std::time::Instant;

use super::super::condensed::halt::Halt;
use super::super::{StepContext, rows_of_both_roles};
use super::slips::{Slips, is_of_slips};
use super::tangent::Tangent;
use crate::{ContactProblem, Cost, LinearGaps, RowKey, State};

/// u and its multipliers, with the rows at u.
#[derive(Clone)]
pub(super) struct Point {
    pub(super) state: State,
    /// The rows of contact, and then those of slips, with the multipliers of both.
    pub(super) gaps: LinearGaps,
    pub(super) slips: Slips,
    pub(super) lambda: Vec<f64>,
}

impl Point {
    /// The largest displacement, at least `least` (UL).
    pub(super) fn size(&self, least: f64) -> f64 {
        self.state.u.iter().fold(least, |size, u| size.max(u.abs()))
    }

    /// Takes the rows at u, each with its multiplier.
    pub(super) fn project(
        &mut self,
        problem: &dyn ContactProblem,
        context: &StepContext<'_>,
    ) -> Result<(), Halt> {
        let u = &self.state.u;
        let mut gaps = rows_of_both_roles(problem, u, context.stop)?;
        let slips = Slips::appended(problem, u, &mut gaps, context)?;
        // both or none, whatever stops the search for slips
        (self.gaps, self.slips) = (gaps, slips);
        let keys = self.gaps.keys().iter();
        let known = keys.map(|&key| self.state.multipliers.of(key));
        self.lambda = known.map(|l| if l.is_finite() { l } else { 0.0 }).collect();
        self.slips.cut(&mut self.lambda);
        Ok(())
    }

    /// Whether nothing holds the row with this key, see [`Slips::lets_go`].
    pub(super) fn lets_go(&self, key: RowKey) -> bool {
        if !is_of_slips(key) {
            return self.state.multipliers.of(key) <= 0.0;
        }
        let row = self.gaps.keys().iter().position(|own| *own == key);
        row.is_none_or(|row| self.slips.lets_go(row, &self.lambda))
    }

    /// How far what is left of the forces would move the unknowns at u itself, as a share of the displacements; `None` unless
    /// that is an equilibrium: the share is at most `bound`, no row overlaps by more than a share `gaps`, and none with a force is further open.
    pub(super) fn equilibrium(
        &self,
        problem: &dyn ContactProblem,
        tangent: &mut Tangent,
        ([bound, gaps], unit, least): ([f64; 2], f64, f64),
        cost: &mut Cost,
    ) -> Result<Option<f64>, Halt> {
        let size = self.size(least);
        let (bound, gaps) = (bound * size, gaps * size);
        let mut c = vec![0.0; self.gaps.len()];
        self.gaps.value(&self.state.u, &mut c);
        let matrix = self.gaps.matrix();
        let immovable = (0..c.len()).filter(|&i| matrix.row(i).all(|(_, a)| a == 0.0));
        Halt::if_immovable(unit, &self.gaps, immovable, &c)?;
        let is_wrong = |i: usize| {
            let (c, lambda) = (c[i], self.lambda[i]);
            if let Some(law) = self.slips.law(i) {
                return self.slips.violates(law, c, &self.lambda, gaps);
            }
            let is_movable = matrix.row(i).any(|(_, a)| a != 0.0);
            is_movable && (c < -gaps || (lambda > 0.0 && c > gaps))
        };
        if (0..c.len()).any(is_wrong) {
            return Ok(None);
        }
        let mut left = vec![0.0; self.state.u.len()];
        let clock = Instant::now();
        problem.energy().gradient(&self.state.u, &mut left);
        cost.callbacks += clock.elapsed().as_secs_f64();
        cost.gradients += 1;
        let pushed: Vec<f64> = self.lambda.iter().map(|l| -l).collect();
        self.gaps.add_forces(&pushed, &mut left);
        tangent.solve(&mut left)?;
        let is_small = left.iter().all(|x| x.abs() <= bound);
        let largest = || left.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        Ok(is_small.then(|| largest() / size))
    }
}
