//! Savings of a run: work that a scene makes unnecessary.

use std::fmt;

use contact_core::Energy;
use contact_core::load_steps::Attempt;

use crate::certificate::Condition;
use crate::contact::Pass;
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
    /// Passes with a prescribed slave none of whose rows carries a force in the last step, though the master's do: the other roles
    /// said all that they say. [`Condensed`](contact_core::Condensed) takes their rows into its compliance only where the others
    /// leave them overlapping.
    pub repeating: usize,
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
            repeating: repeating(problem, history),
            solves: match problem.is_exact() {
                true => history.run.attempts.iter().filter(is_single).count(),
                false => 0,
            },
            factorizations: history.run.attempts.iter().filter(has_kept).count(),
            hessians: cost.reused_hessians,
        }
    }
}

/// The passes with a prescribed slave without a force in the last step, while those with exchanged roles have one.
fn repeating<const D: usize>(problem: &Problem<D>, history: &History<D>) -> usize {
    let solution = history.run.solution.as_ref();
    let is_last_condensed = history.run.attempts.last().is_some_and(is_condensed);
    let Some(solution) = solution.filter(|_| is_last_condensed && problem.is_exact()) else {
        return 0;
    };
    let presses = |pass: Pass| {
        let number = problem.passes().iter().position(|own| *own == pass);
        let rows = solution.gaps.keys().iter().zip(&solution.lambda);
        let mut own = rows.filter(|(key, _)| Some(key.pass as usize) == number);
        own.any(|(_, lambda)| *lambda > 0.0)
    };
    let moves = |body: usize| {
        let energy = problem.body_energies().get(body);
        energy.is_some_and(|energy| energy.dofs() > 0)
    };
    let repeats = |pass: &&Pass| {
        let [slave, master] = problem.bodies_of(**pass);
        let turned = problem.turned(**pass);
        !moves(slave) && moves(master) && turned.is_some_and(presses) && !presses(**pass)
    };
    problem.passes().iter().filter(repeats).count()
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
            "{} dofs, {} cells, {} rows, {} passes, {} passes that repeat others, {} solves, {} factorisations, {} Hessians",
            self.dofs,
            self.cells,
            self.rows,
            self.passes,
            self.repeating,
            self.solves,
            self.factorizations,
            self.hessians
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certificate::Limits;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::model::Passes;
    use crate::simulation::Simulation;
    use crate::tensor::Vector;
    use crate::{Body, LinearElastic, Mesh, Scene};

    fn grid(x: [f64; 2], y: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
        let [xs, ys] =
            [(x, cells[0]), (y, cells[1])].map(|(ends, n)| linspace(ends[0], ends[1], n));
        rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
    }

    /// A linear block whose bottom is held, and a prescribed tool of this mesh above it that comes down by 0.1: energy, and passes that
    /// repeat others.
    fn pressed(cells: usize, tool: Mesh<2>, passes: Passes) -> (f64, usize) {
        let law = || LinearElastic::new(100.0, 0.3).expect("a law");
        let mut block = Body::new(grid([0.0, 2.0], [0.0, 1.0], [cells, 4]), law());
        block.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut tool = Body::new(tool, law());
        tool.prescribe_all([Some(0.0), Some(-0.1)]).expect("moved");
        let mut scene = Scene::new();
        let block = scene.add("block", block).on("top");
        let tool = scene.add("tool", tool).on("bottom");
        scene
            .contact_in_passes(block, tool, passes)
            .expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(1).run(&mut problem);
        let history = history.expect("no misuse");
        let last = history.last().expect("a step");
        assert!(
            last.certificate.holds(&Limits::default()),
            "{}",
            last.certificate
        );
        (last.energy, LeftOut::new(&problem, &history).repeating)
    }

    /// A flat tool, with coarser facets than the block's or finer ones, closes all gaps of the block: its own rows say nothing more.
    #[test]
    fn a_flat_prescribed_tool_repeats_what_the_block_says() {
        for cells in [1, 5, 37] {
            let tool = || grid([-1.0, 3.0], [1.0, 1.5], [cells, 1]);
            let (energy, repeating) = pressed(16, tool(), Passes::Both);
            let (alone, none) = pressed(16, tool(), Passes::FirstIsSlave);
            assert_eq!((repeating, none), (1, 0), "{cells} facets");
            assert!(energy > 0.1, "{energy}");
            assert!((energy / alone - 1.0).abs() < 1e-9, "{energy} {alone}");
        }
    }

    /// A tool with an edge that presses in the middle of a block's facet: the tool's rows hold the block between its nodes. To leave
    /// out the pass of a prescribed slave without a look at its rows would change the result.
    #[test]
    fn a_sharp_prescribed_tool_does_not() {
        let sharp = |X: &Vector<2>| Vector::<2>::new(X[0], X[1] + 0.2 * (X[0] - 0.75).abs());
        let tool = || {
            let tool = grid([0.0, 2.0], [1.0, 1.5], [40, 4]);
            tool.mapped(sharp).expect("a mesh")
        };
        let (energy, repeating) = pressed(4, tool(), Passes::Both);
        let (alone, _) = pressed(4, tool(), Passes::FirstIsSlave);
        assert_eq!(repeating, 0);
        assert!(energy > 1.01 * alone, "{energy} {alone}");
    }
}
