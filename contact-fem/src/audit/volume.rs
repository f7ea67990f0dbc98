//! The smallest volume ratio J of a state, between the nodes of quadratic cells, too.

use std::sync::PoisonError;

use super::Audit;
use super::topology::Quadratic;
use crate::element::Order;
use crate::element::volume::{CellNodes, LeastRatio, least_ratio};
use crate::tensor::{Vector, determinant};

/// The smallest volume ratio J = det F of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastVolume<const D: usize> {
    /// A lower bound of J in all cells (no unit). It is less than a hundredth of the smallest J below it, unless a cell is
    /// too distorted for that.
    pub bound: f64,
    /// The index of the body.
    pub body: usize,
    /// The number of the cell in the body's mesh.
    pub cell: usize,
    /// The place of the smallest J found in that cell (UL).
    pub at: Vector<D>,
}

impl<const D: usize> Audit<D> {
    /// The smallest volume ratio at positions `x` of all nodes (UL), and the number of quadratic cells in which it is not
    /// positive everywhere. They are kept.
    pub(crate) fn volumes(&self, x: &[Vector<D>]) -> (Option<LeastVolume<D>>, usize) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let volumes = &mut Self::state(&mut last, x).volumes;
        *volumes.get_or_insert_with(|| self.find_volumes(x))
    }

    fn find_volumes(&self, x: &[Vector<D>]) -> (Option<LeastVolume<D>>, usize) {
        let mut least: Option<LeastVolume<D>> = None;
        let mut take = |bound: f64, body: usize, cell: usize, at: Vector<D>| {
            // NaN is less than any number
            if least.is_none_or(|least| !(bound >= least.bound)) {
                least = Some(LeastVolume {
                    bound,
                    body,
                    cell,
                    at,
                });
            }
        };
        let mut goal = f64::INFINITY;
        for (k, cell) in self.topology.cells.iter().enumerate() {
            if self.orders[cell.body] == Order::Linear {
                let ratio = determinant(&self.deformation(k, x));
                let ratio = if ratio.is_nan() {
                    f64::NEG_INFINITY
                } else {
                    ratio
                };
                let corners = &cell.nodes[..=D];
                let centre = corners.iter().map(|&a| x[a]).sum::<Vector<D>>() / (D + 1) as f64;
                take(ratio, cell.body, cell.of, centre);
                goal = goal.min(ratio);
            }
        }
        let at_rest = |cell: &Quadratic| cell.nodes.map(|a| self.reference[a]);
        let now = |cell: &Quadratic| -> CellNodes<D> { cell.nodes.map(|a| x[a]) };
        // first the sign of all volumes, then the smallest of them
        let quadratic = &self.topology.quadratic;
        let signs = quadratic.iter();
        let signs =
            signs.map(|cell| least_ratio::<D>(&now(cell), &at_rest(cell), f64::NEG_INFINITY));
        let ratios: Vec<LeastRatio> = signs.collect();
        let inverted = ratios.iter().filter(|ratio| !(ratio.bound > 0.0)).count();
        goal = ratios
            .iter()
            .fold(goal, |goal, ratio| goal.min(ratio.found));
        for (cell, mut ratio) in quadratic.iter().zip(ratios) {
            let now = now(cell);
            if !ratio.is_over(goal) {
                ratio = least_ratio::<D>(&now, &at_rest(cell), goal);
                goal = goal.min(ratio.found);
            }
            take(ratio.bound, cell.body, cell.of, ratio.place(&now));
        }
        (least, inverted)
    }
}
