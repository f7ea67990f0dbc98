//! What one run is known by afterwards.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::case::Case;

/// Named numbers.
pub type Numbers = BTreeMap<String, f64>;

/// One run: settings, revision, result. A line of `runs.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its settings.
    pub case: Case,
    /// The revision of the source and the libraries that it ran with.
    pub revision: String,
    /// What came of it.
    pub result: Measured,
}

/// What a run found and what it cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// `converged`, or why there is no result.
    pub status: String,
    /// The size of the mesh (UL); what it is the size of is the family's.
    pub h: f64,
    /// Free unknowns.
    pub dofs: usize,
    /// Rows of the constraints in the last step.
    pub rows: usize,
    /// Errors, relative to what they are errors of.
    pub errors: Numbers,
    /// Values in the family's units, errors of which are taken against the refined solution.
    pub values: Numbers,
    /// What it cost.
    pub cost: Cost,
    /// Lines of the certificate that do not hold, with value and limit; nothing if all do.
    pub certificate: Vec<String>,
}

/// Time and counts from building the mesh to the last converged step, errors not included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Seconds by the clock.
    pub wall: f64,
    /// Seconds of processor time, where the system tells.
    pub cpu: Option<f64>,
    /// The most memory the process had (bytes), where the system tells.
    pub memory: Option<u64>,
    /// Load steps that converged, and those that were cut.
    pub steps: usize,
    /// Load steps that were cut.
    pub cuts: usize,
    /// Iterations of the fixed point.
    pub fixed_point: usize,
    /// Iterations of Ipopt.
    pub iterations: usize,
    /// Numerical factorisations.
    pub factorizations: usize,
    /// Where the wall time went.
    pub phases: Phases,
}

/// Seconds of wall time by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phases {
    /// Meshes, checks, sparsity.
    pub set_up: f64,
    /// Projections, normals, rows.
    pub projection: f64,
    /// E, ∇E, ∇²E and the gaps.
    pub callbacks: f64,
    /// Ipopt itself, which is mostly the linear solver.
    pub optimizer: f64,
    /// What is left: records, certificates, load steps.
    pub other: f64,
}

impl Phases {
    /// Names and seconds, in order.
    pub fn entries(&self) -> [(&'static str, f64); 5] {
        [
            ("set-up", self.set_up),
            ("projection and rows", self.projection),
            ("energy and derivatives", self.callbacks),
            ("Ipopt and linear solver", self.optimizer),
            ("other", self.other),
        ]
    }
}

impl Measured {
    /// The status of a run that has a result.
    pub const CONVERGED: &'static str = "converged";

    /// Of a run that ended without any word of its own.
    pub fn failed(why: impl Into<String>) -> Self {
        Measured {
            status: why.into(),
            ..Measured::default()
        }
    }

    /// Whether there is a result.
    pub fn converged(&self) -> bool {
        self.status == Self::CONVERGED
    }
}
