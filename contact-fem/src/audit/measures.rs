//! The smallest volume ratio J of a state, between the nodes of quadratic cells, too, and the largest strains and rotations of
//! laws for small ones.

use super::Audit;
use super::topology::Quadratic;
use crate::element::Order;
use crate::element::volume::{CellNodes, LeastRatio, least_ratio};
use crate::tensor::{Matrix, Vector, determinant};

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

/// What one pass over all simplices and cells tells of a state: see [`Findings`](super::Findings).
#[derive(Clone, Copy)]
pub(super) struct Measures<const D: usize> {
    pub inverted: usize,
    pub least_volume: Option<LeastVolume<D>>,
    pub strain: f64,
    pub rotation: f64,
}

impl<const D: usize> Audit<D> {
    /// The measures at positions `x` of all nodes (UL).
    pub(super) fn measure(&self, x: &[Vector<D>]) -> Measures<D> {
        let mut inverted_simplices = 0;
        // the squares of |H + Hᵀ| and |H − Hᵀ|
        let (mut strain, mut rotation) = (0.0, 0.0);
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
            let F = self.deformation(k, x);
            let ratio = determinant(&F);
            // NaN is no volume either
            let ratio = if ratio.is_nan() {
                f64::NEG_INFINITY
            } else {
                ratio
            };
            let radius = |x: &[Vector<D>]| {
                let corners = cell.nodes[..=D].iter();
                corners.map(|&a| x[a][0]).sum::<f64>()
            };
            let is_beyond = self.is_revolved && {
                let mut corners = cell.nodes[..=D].iter();
                corners.any(|&a| x[a][0] < 0.0)
            };
            inverted_simplices += usize::from(ratio <= 0.0 || is_beyond);
            if self.is_linear[cell.body] {
                let H = F - Matrix::identity();
                let around = match self.is_revolved {
                    true => radius(x) / radius(&self.reference) - 1.0,
                    false => 0.0,
                };
                let own = (H + H.transpose()).norm_squared() + (2.0 * around).powi(2);
                strain = own.max(strain);
                rotation = (H - H.transpose()).norm_squared().max(rotation);
            }
            if ratio < goal && self.orders[cell.body] == Order::Linear {
                let corners = &cell.nodes[..=D];
                let centre = corners.iter().map(|&a| x[a]).sum::<Vector<D>>() / (D + 1) as f64;
                take(ratio, cell.body, cell.of, centre);
                goal = ratio;
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
        Measures {
            inverted: inverted.max(inverted_simplices),
            least_volume: least,
            strain: strain.sqrt() / 2.0,
            rotation: (rotation / 8.0).sqrt(),
        }
    }
}
