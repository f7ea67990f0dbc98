//! Computational cost: one additive record for subproblems, load steps and runs.

use std::iter::Sum;
use std::ops::AddAssign;

/// Counts, and wall time by phase (s). Costs are additive: that of a load step is the sum over its subproblems, that of
/// a run the sum over its load steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Cost {
    /// Iterations of the fixed point or of Newton's method.
    pub outer_iterations: usize,
    /// Solves of a subproblem, cold retries included.
    pub solves: usize,
    /// Solves repeated from a cold start because the warm start failed.
    pub cold_retries: usize,
    /// Iterations within these solves: those of the optimiser, or steps towards the active rows.
    pub inner_iterations: usize,
    /// Numerical factorisations.
    pub factorizations: usize,
    /// The entries of all factors computed by the library's own linear layer.
    pub factor_entries: u64,
    /// Evaluations of the energy's value.
    pub values: usize,
    /// Evaluations of its gradient.
    pub gradients: usize,
    /// Evaluations of its Hessian.
    pub hessians: usize,
    /// Iterations of the optimiser that reused a constant Hessian.
    pub reused_hessians: usize,
    /// Seconds for projections, normals and rows (steps 1–4 of Algorithm 2).
    pub projection: f64,
    /// Seconds inside the energy and the gaps while the optimiser runs.
    pub callbacks: f64,
    /// Seconds inside the optimiser, callbacks excluded.
    pub optimizer: f64,
    /// Seconds in total.
    pub wall: f64,
    /// The largest factor, where the linear solver reports it.
    pub factor: Option<FactorSize>,
}

#[cfg(feature = "resume")]
impl Cost {
    /// The counts alone.
    pub(crate) fn without_times(self) -> Self {
        Cost {
            projection: 0.0,
            callbacks: 0.0,
            optimizer: 0.0,
            wall: 0.0,
            ..self
        }
    }
}

/// A name that programs have as a constant. Under its own name, serde does not ask for it to be borrowed from what is read.
pub(crate) type Name = &'static str;

/// The size of a factor of the optimiser's linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorSize {
    /// The elimination order that the linear solver used, or chose from.
    #[cfg_attr(
        feature = "resume",
        serde(deserialize_with = "crate::equilibrium::resumable::name")
    )]
    pub ordering: Name,
    /// The size of the factor (bytes).
    pub bytes: u64,
    /// The workspace that the linear solver allocated from its estimate (bytes), where the system reports it.
    pub workspace_bytes: Option<u64>,
    /// How often the estimate was too small, summed over all solves.
    pub reallocations: usize,
}

impl FactorSize {
    /// Of a factor with so many entries, by the library's own linear layer.
    #[cfg(feature = "linear")]
    pub(crate) fn of_entries(entries: usize) -> Self {
        FactorSize {
            ordering: match cfg!(feature = "metis") {
                true => "minimum degree or nested dissection",
                false => "minimum degree",
            },
            bytes: (entries * size_of::<f64>()) as u64,
            workspace_bytes: None,
            reallocations: 0,
        }
    }

    /// The larger of the two, with the reallocations of both added.
    fn or_larger(self, other: Self) -> Self {
        let larger = if other.bytes > self.bytes {
            other
        } else {
            self
        };
        FactorSize {
            reallocations: self.reallocations + other.reallocations,
            ..larger
        }
    }
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Self) {
        self.outer_iterations += other.outer_iterations;
        self.solves += other.solves;
        self.cold_retries += other.cold_retries;
        self.inner_iterations += other.inner_iterations;
        self.factorizations += other.factorizations;
        self.factor_entries += other.factor_entries;
        self.values += other.values;
        self.gradients += other.gradients;
        self.hessians += other.hessians;
        self.reused_hessians += other.reused_hessians;
        self.projection += other.projection;
        self.callbacks += other.callbacks;
        self.optimizer += other.optimizer;
        self.wall += other.wall;
        self.factor = match (self.factor, other.factor) {
            (Some(a), Some(b)) => Some(a.or_larger(b)),
            (a, b) => a.or(b),
        };
    }
}

impl Sum for Cost {
    fn sum<I: Iterator<Item = Self>>(costs: I) -> Self {
        costs.fold(Cost::default(), |mut sum, cost| {
            sum += cost;
            sum
        })
    }
}
