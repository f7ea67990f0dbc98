//! Runs that keep the work that the library leaves out. Their results tell whether it may be left out, and their cost whether
//! that pays.

use std::ops::Range;

use contact_core::equilibrium::{Choice, Solution, StepContext};
use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::linear::SymmetricPattern;
use contact_core::nlp::Bounds;
use contact_core::{
    ContactProblem, Energy, Equilibrium, Error, GapVariation, MemoryNeed, Scale, Separable, State,
};
use contact_fem::model::Problem;
use contact_fem::simulation::{DefaultSolver, StepRecord};
use contact_fem::{Scene, Simulation};

/// Work that is left out by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// A harmonic extension wherever no start is extrapolated.
    pub starts: bool,
    /// Rows, depths and pressures of all passes, however far apart their surfaces are.
    pub rows: bool,
    /// All bodies as one group.
    pub groups: bool,
    /// The stiffness of all bodies as one matrix.
    pub blocks: bool,
    /// A new factorisation in each load step.
    pub factors: bool,
}

impl Keep {
    /// Everything is kept.
    pub const ALL: Keep = Keep {
        starts: true,
        rows: true,
        groups: true,
        blocks: true,
        factors: true,
    };

    /// What these names name, which are those of the fields, or `all`.
    ///
    /// # Errors
    /// The first other name.
    pub fn named(names: &[String]) -> Result<Keep, String> {
        let mut keep = Keep {
            starts: false,
            rows: false,
            groups: false,
            blocks: false,
            factors: false,
        };
        for name in names {
            match name.as_str() {
                "all" => keep = Keep::ALL,
                "starts" => keep.starts = true,
                "rows" => keep.rows = true,
                "groups" => keep.groups = true,
                "blocks" => keep.blocks = true,
                "factors" => keep.factors = true,
                other => {
                    return Err(format!(
                        "nothing to keep is called `{other}`: name `starts`, `rows`, `groups`, `blocks`, `factors` or `all`"
                    ));
                }
            }
        }
        Ok(keep)
    }

    /// The scene with the reach that this takes: an own one stays, and otherwise it is the diagonal of the scene's box, beyond
    /// which there is nothing.
    pub fn prepare<const D: usize>(self, scene: &mut Scene<D>) {
        if !self.rows || scene.reach.is_some() {
            return;
        }
        let bodies = scene.bodies().iter();
        let nodes = || bodies.clone().flat_map(|body| body.mesh().nodes());
        let Some(&first) = nodes().next() else { return };
        let low = nodes().fold(first, |low, X| low.inf(X));
        let high = nodes().fold(first, |high, X| high.sup(X));
        scene.reach = Some((high - low).norm());
    }

    /// A simulation with the default solver, which keeps this.
    pub fn simulation(self, increments: usize) -> Simulation<Keeping> {
        let solver = Keeping {
            keep: self,
            solver: DefaultSolver::default(),
        };
        Simulation::solved_by(solver, increments)
    }
}

/// The default solver, which gets problems that do not tell what may be left out.
#[derive(Clone, Debug)]
pub struct Keeping {
    keep: Keep,
    solver: DefaultSolver,
}

impl Equilibrium for Keeping {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        if self.keep.factors {
            self.solver = DefaultSolver::default();
        }
        let whole = Whole::new(problem, self.keep);
        self.solver.solve(&whole, start, context)
    }

    fn choice(&self, problem: &dyn ContactProblem) -> Choice {
        self.solver.choice(problem)
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        self.solver.memory(&Whole::new(problem, self.keep))
    }

    fn lifts_starts(&self, problem: &dyn ContactProblem) -> bool {
        !self.keep.starts && self.solver.lifts_starts(problem)
    }
}

/// A problem that does not tell what may be left out.
struct Whole<'a> {
    problem: &'a dyn ContactProblem,
    energy: One<'a>,
    keep: Keep,
}

impl<'a> Whole<'a> {
    fn new(problem: &'a dyn ContactProblem, keep: Keep) -> Self {
        let energy = One {
            energy: problem.energy(),
            is_one: keep.blocks,
        };
        Whole {
            problem,
            energy,
            keep,
        }
    }
}

impl ContactProblem for Whole<'_> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_gaps(u, sampling)
    }

    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_reversed(u, sampling)
    }

    fn linearize_near(&self, u: &[f64], moved: f64) -> Result<LinearGaps, Error> {
        let moved = if self.keep.rows { f64::INFINITY } else { moved };
        self.problem.linearize_near(u, moved)
    }

    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.problem.vary_gaps(u, gaps, lambda)
    }

    fn separable(&self) -> Option<&dyn Separable> {
        match self.keep.groups {
            true => None,
            false => self.problem.separable(),
        }
    }

    fn has_exact_gaps(&self) -> bool {
        self.problem.has_exact_gaps()
    }

    fn scale(&self) -> Option<Scale> {
        self.problem.scale()
    }

    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}

/// An energy whose Hessian may be one block.
struct One<'a> {
    energy: &'a dyn Energy,
    is_one: bool,
}

impl Energy for One<'_> {
    fn dofs(&self) -> usize {
        self.energy.dofs()
    }

    fn value(&self, u: &[f64]) -> f64 {
        self.energy.value(u)
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.energy.gradient(u, g)
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.energy.hessian_pattern()
    }

    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        self.energy.hessian(u, values)
    }

    fn blocks(&self) -> Vec<Range<usize>> {
        match self.is_one {
            true => std::iter::once(0..self.energy.dofs()).collect(),
            false => self.energy.blocks(),
        }
    }

    fn is_quadratic(&self) -> bool {
        self.energy.is_quadratic()
    }

    fn domain_len(&self) -> usize {
        self.energy.domain_len()
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.energy.domain(u, d)
    }
}

/// How far the energies and the reactions of two records of `problem` are apart, relative to the second. An energy counts as at
/// least 1e-6 of the problem's unit, and a reaction as at least its unit.
pub fn apart<const D: usize>(problem: &Problem<D>, [a, b]: [&StepRecord<D>; 2]) -> (f64, f64) {
    let scale = problem.scale();
    let energy = (a.energy - b.energy).abs() / b.energy.abs().max(1e-6 * scale.energy);
    let norms = b.reactions.iter().map(|r| r.norm());
    let size = norms.fold(scale.energy / scale.length, f64::max);
    let pairs = a.reactions.iter().zip(&b.reactions);
    let reactions = pairs.map(|(a, b)| (a - b).norm() / size);
    (energy, reactions.fold(0.0, f64::max))
}
