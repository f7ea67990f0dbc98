//! The iterates of a running solve.

use std::{cell::OnceCell, fmt};

/// Lagrange multipliers of a minimum of f, with the signs defined in the [module](super). All signs are reversed if a
/// negative scaling makes the solver maximise f.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Multipliers {
    /// λ, m of them: ≤ 0 where a constraint is at its lower bound, ≥ 0 at its upper.
    pub constraints: Vec<f64>,
    /// z_L ≥ 0, n of them.
    pub lower: Vec<f64>,
    /// z_U ≥ 0, n of them.
    pub upper: Vec<f64>,
}

/// The distances of an iterate from its bounds, in a solver that keeps it inside them: see [`Iterate::slacks`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slacks {
    /// s, m of them: the slack variables that an interior-point method keeps inside the bounds of the inequalities in
    /// place of g(x); g(x) − s is 0 at the solution only. For an equality, its right-hand side.
    pub constraints: Vec<f64>,
    /// x − x_L, n of them.
    pub lower: Vec<f64>,
    /// x_U − x, n of them.
    pub upper: Vec<f64>,
    /// s − g_L, m of them.
    pub constraint_lower: Vec<f64>,
    /// g_U − s, m of them.
    pub constraint_upper: Vec<f64>,
}

/// The residuals of the optimality conditions at an iterate, by variable and constraint in the numbering of the
/// problem: see [`Iterate::violations`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Violations {
    /// max(x_L − x, 0), n of them.
    pub lower: Vec<f64>,
    /// max(x − x_U, 0), n of them.
    pub upper: Vec<f64>,
    /// max(g_L − g(x), g(x) − g_U, 0), m of them.
    pub constraints: Vec<f64>,
    /// ∂L/∂x = ∇f + (∂g/∂x)ᵀ λ − z_L + z_U, n of them.
    pub lagrangian: Vec<f64>,
    /// z_L (x − x_L), n of them; 0 without the bound.
    pub complementarity_lower: Vec<f64>,
    /// z_U (x_U − x), n of them; 0 without the bound.
    pub complementarity_upper: Vec<f64>,
    /// (g(x) − g_L) λ⁻ + (g_U − g(x)) λ⁺, with the negative and the positive part of λ; −(g(x) − g_L) λ for an
    /// equality. m of them.
    pub complementarity_constraints: Vec<f64>,
}

/// The phase of the solver in an iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Minimising f.
    Regular,
    /// Reducing the infeasibility, because the line search found no acceptable step.
    Restoration,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Regular => "regular",
            Self::Restoration => "restoration",
        })
    }
}

/// One line of a solver's history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IterationRecord {
    /// Counted from 0, the starting point.
    pub iteration: usize,
    /// The phase. In the restoration phase, some of the values below belong to the restoration problem.
    pub phase: Phase,
    /// f, unscaled.
    pub objective: f64,
    /// Constraint violation, max-norm.
    pub primal_infeasibility: f64,
    /// ∇L, max-norm, of the scaled problem.
    pub dual_infeasibility: f64,
    /// Barrier parameter μ.
    pub mu: f64,
    /// Max-norm of the step that led here (0 at the start).
    pub step_norm: f64,
    /// Multiple of the identity added to the Hessian to obtain a descent direction; 0 for none.
    pub regularization: f64,
    /// Step length in the dual variables.
    pub alpha_dual: f64,
    /// Step length in the primal variables.
    pub alpha_primal: f64,
    /// Trial points of the line search; 0 at the start.
    pub line_search_trials: usize,
}

/// The source of an [`Iterate`]'s vectors, called on demand. `None` where the solver has no such vector.
pub trait IterateSource {
    /// x.
    fn x(&self) -> Option<Vec<f64>>;
    /// g(x).
    fn constraints(&self) -> Option<Vec<f64>>;
    /// λ, z_L, z_U.
    fn multipliers(&self) -> Option<Multipliers>;
    /// The distances from the bounds.
    fn slacks(&self) -> Option<Slacks> {
        None
    }
    /// The residuals of the optimality conditions.
    fn violations(&self) -> Option<Violations> {
        None
    }
}

/// The current iterate of a running solve: its [`IterationRecord`], and its vectors on demand.
///
/// A vector is copied at the first request only.
pub struct Iterate<'a> {
    record: IterationRecord,
    source: &'a dyn IterateSource,
    x: OnceCell<Option<Vec<f64>>>,
    constraints: OnceCell<Option<Vec<f64>>>,
    multipliers: OnceCell<Option<Multipliers>>,
    slacks: OnceCell<Option<Slacks>>,
    violations: OnceCell<Option<Violations>>,
}

impl<'a> Iterate<'a> {
    /// For solvers, and for tests of an [`Nlp`](super::Nlp).
    pub fn new(record: IterationRecord, source: &'a dyn IterateSource) -> Self {
        Self {
            record,
            source,
            x: OnceCell::new(),
            constraints: OnceCell::new(),
            multipliers: OnceCell::new(),
            slacks: OnceCell::new(),
            violations: OnceCell::new(),
        }
    }

    /// The solver's record of this iteration.
    pub fn record(&self) -> &IterationRecord {
        &self.record
    }

    /// x, fixed variables included; in the restoration phase, the x of its current iterate.
    pub fn x(&self) -> Option<&[f64]> {
        self.x.get_or_init(|| self.source.x()).as_deref()
    }

    /// g(x); `None` in the restoration phase.
    pub fn constraints(&self) -> Option<&[f64]> {
        self.constraints
            .get_or_init(|| self.source.constraints())
            .as_deref()
    }

    /// The multipliers, 0 for the bounds of fixed variables; `None` in the restoration phase, which solves another
    /// problem.
    pub fn multipliers(&self) -> Option<&Multipliers> {
        self.multipliers
            .get_or_init(|| self.source.multipliers())
            .as_ref()
    }

    /// The slack variables of inequalities and the distances from the bounds; `None` in the restoration phase.
    ///
    /// These are the solver's own values, unscaled: distances from the bounds it works with, which Ipopt's
    /// `bound_relax_factor` moves. They are +∞ where there is no bound, and 0 for equalities and fixed variables. Fixed
    /// variables have no bounds where `fixed_variable_treatment` turns them into equalities.
    pub fn slacks(&self) -> Option<&Slacks> {
        self.slacks.get_or_init(|| self.source.slacks()).as_ref()
    }

    /// Violations of bounds and constraints, the gradient of the Lagrangian, and complementarity, unscaled; `None` in
    /// the restoration phase.
    ///
    /// Violations refer to the bounds as given. For a fixed variable ∂L/∂x is 0, as the multipliers of its bounds would
    /// balance it; where `fixed_variable_treatment` turns it into an equality, the multiplier of that equality enters.
    pub fn violations(&self) -> Option<&Violations> {
        self.violations
            .get_or_init(|| self.source.violations())
            .as_ref()
    }
}

impl fmt::Debug for Iterate<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Iterate")
            .field("record", &self.record)
            .finish_non_exhaustive()
    }
}
