//! Savings of a run: work that a scene makes unnecessary.

use std::fmt;

use contact_core::load_steps::Attempt;

use crate::certificate::Condition;
use crate::model::Problem;
use crate::simulation::{History, StepRecord};

/// Work that a scene made unnecessary and that was left out. The results do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Prescribed dofs, which are eliminated from the unknowns.
    pub dofs: usize,
    /// Cells all of whose dofs are prescribed, which are not assembled.
    pub cells: usize,
    /// Contact nodes without a row in the last step: each of their integration points is outside
    /// the search radius, beyond the rim of the other surface, or faces away from it.
    pub rows: usize,
    /// Passes whose surfaces are further apart than displacements brought any points: none of their points was projected.
    pub passes: usize,
    /// Solves that the fixed point would have needed to find that exact rows do not change: one for each attempt at a load
    /// step that took a single one.
    pub solves: usize,
    /// Attempts at load steps that were solved with factors of earlier ones.
    pub factorizations: usize,
    /// Iterations of the optimiser that reused a constant Hessian.
    pub hessians: usize,
}

impl LeftOut {
    /// The savings of a run of `problem`.
    pub fn new<const D: usize>(problem: &Problem<D>, history: &History<D>) -> Self {
        let bodies = problem.scene().bodies();
        let cells: usize = bodies.iter().map(|body| body.mesh().len()).sum();
        let energies = problem.body_energies().iter();
        let assembled: usize = energies.map(|energy| energy.assembled_cells()).sum();
        let last = history.steps.last();
        let cost = history.run.cost();
        LeftOut {
            dofs: problem.dofs().prescribed(),
            cells: cells - assembled,
            rows: last.map_or(0, dropped),
            passes: problem.unsearched_passes(),
            solves: match problem.is_exact() {
                true => history.run.attempts.iter().filter(is_single).count(),
                false => 0,
            },
            factorizations: history.run.attempts.iter().filter(has_kept).count(),
            hessians: cost.reused_hessians,
        }
    }
}

/// Whether the fixed point did with one solve what an iteration would have needed two for.
fn is_single(attempt: &&Attempt) -> bool {
    !is_condensed(attempt) && attempt.iterations.len() == 1
}

/// Whether an attempt took no factorisation.
fn has_kept(attempt: &&Attempt) -> bool {
    is_condensed(attempt) && attempt.cost.factorizations == 0
}

/// Whether it was solved with the library's own factors, which are kept.
fn is_condensed(attempt: &Attempt) -> bool {
    matches!(attempt.solver(), Some("condensed" | "newton"))
}

/// The contact nodes without a row, also where rows are integration points.
fn dropped<const D: usize>(step: &StepRecord<D>) -> usize {
    let dropped = step.certificate.left(Condition::Dropped);
    dropped.map_or(0, |count| count as usize) // NaN, of a state that is none, counts as 0
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} dofs, {} cells, {} rows, {} passes, {} solves, {} factorisations, {} Hessians",
            self.dofs,
            self.cells,
            self.rows,
            self.passes,
            self.solves,
            self.factorizations,
            self.hessians
        )
    }
}
