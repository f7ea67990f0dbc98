//! `summary.json`: what a run was, how it ended, and what it took.

use std::collections::BTreeMap;
use std::path::Path;

use ipopt_contact::Blas;
use ipopt_contact::contact_core::cost::{Cost, FactorSize};
use ipopt_contact::contact_core::ipopt::doctor;
use ipopt_contact::contact_fem::certificate::{Certificate, Limits};
use ipopt_contact::prelude::*;
use serde::Serialize;

use super::recorder::Recorder;
use super::{Failure, files, machine};

/// The keys of `summary.json`. Energies are in UF·UL, forces in UF, lengths in UL; what only a
/// converged step has is null if there is none.
#[derive(Debug, Serialize)]
pub struct Summary {
    pub scene: String,
    pub mesh: MeshSize,
    pub increments: usize,
    pub converged: bool,
    pub status: String,
    pub load_factor: f64,
    pub steps: usize,
    pub cuts: usize,
    pub energy: Option<f64>,
    pub reaction: Option<f64>,
    pub reactions: Vec<Vec<f64>>,
    pub min_j: Option<f64>,
    pub penetration: Option<f64>,
    pub weak_penetration: Option<f64>,
    /// The worst of all steps.
    pub certificate: Option<CertificateValues>,
    pub fixed_point_iterations: usize,
    pub ipopt_iterations: usize,
    pub factorisations: usize,
    pub cold_retries: usize,
    /// What the scene did not need.
    pub left_out: Option<Unneeded>,
    pub wall_seconds: f64,
    pub seconds: Seconds,
    pub peak_memory_bytes: Option<u64>,
    pub factor: Option<LargestFactor>,
    pub versions: VersionNames,
}

/// How large the problem is.
#[derive(Debug, Serialize)]
pub struct MeshSize {
    pub nodes: usize,
    pub cells: usize,
    pub free_dofs: usize,
    /// Of each body.
    pub contact_facets: Vec<usize>,
}

/// What all steps are worth, see [`Certificate`]; what does not apply is null.
#[derive(Debug, Serialize)]
pub struct CertificateValues {
    pub holds: bool,
    pub dropped: usize,
    #[serde(flatten)]
    pub values: BTreeMap<&'static str, Option<f64>>,
    /// As a table for people.
    #[serde(skip)]
    table: String,
}

/// Work that was not done, see [`LeftOut`].
#[derive(Debug, Serialize)]
pub struct Unneeded {
    pub dofs: usize,
    pub cells: usize,
    pub rows: usize,
    pub solves: usize,
    pub hessians: usize,
}

/// Wall time by phase.
#[derive(Debug, Serialize)]
pub struct Seconds {
    pub projection: f64,
    pub callbacks: f64,
    pub optimizer: f64,
    pub output: f64,
    pub other: f64,
}

/// The largest factor of the linear solver.
#[derive(Debug, Serialize)]
pub struct LargestFactor {
    pub ordering: String,
    pub bytes: u64,
    pub workspace_bytes: Option<u64>,
    pub reallocations: usize,
}

/// What the program was built from.
#[derive(Debug, Serialize)]
pub struct VersionNames {
    pub ipopt_contact: String,
    pub ipopt: String,
    pub ipopt_libraries: Vec<String>,
    pub linear_solver: Option<String>,
    /// Those that Ipopt has.
    pub linear_solvers: Vec<String>,
    pub blas: Option<String>,
    pub rustc: String,
    pub profile: String,
}

/// How a run ended.
pub enum End<'a, const D: usize> {
    /// With a history, at full load or not.
    History(&'a History<D>),
    /// With an error.
    Failure(&'a dyn std::error::Error),
}

impl Summary {
    /// Of a run that `recorder` has seen. `reaction` picks the force that the scene is about.
    pub fn new<const D: usize>(
        scene: &str,
        problem: &Problem<D>,
        recorder: &Recorder<D>,
        increments: usize,
        ending: &End<'_, D>,
        wall_seconds: f64,
        reaction: impl Fn(&StepRecord<D>) -> f64,
    ) -> Self {
        let cost = total(recorder, ending);
        let last = recorder.records.last();
        let vectors = last.map_or(&[][..], |record| &record.reactions);
        Summary {
            scene: scene.into(),
            mesh: MeshSize::of(problem),
            increments,
            converged: ending.is_complete(),
            status: match worst(&recorder.records) {
                Some(found) if !found.holds(&Limits::default()) => {
                    format!("{}, but its certificate does not hold", ending.status())
                }
                _ => ending.status(),
            },
            load_factor: last.map_or(0.0, |record| record.factor),
            steps: recorder.records.len(),
            cuts: ending.cuts(),
            energy: last.map(|record| record.energy),
            reaction: last.map(reaction),
            reactions: vectors
                .iter()
                .map(|v| v.iter().copied().collect())
                .collect(),
            min_j: last.map(|record| record.min_j),
            penetration: last.map(|record| record.penetration),
            weak_penetration: last.map(|record| record.weak_penetration),
            certificate: worst(&recorder.records).map(CertificateValues::from),
            fixed_point_iterations: cost.fixed_point,
            ipopt_iterations: cost.iterations,
            factorisations: cost.factorizations,
            cold_retries: cost.cold_retries,
            left_out: ending.left_out(problem),
            wall_seconds,
            seconds: Seconds {
                projection: cost.projection,
                callbacks: cost.callbacks,
                optimizer: cost.optimizer,
                output: recorder.seconds,
                other: wall_seconds
                    - cost.projection
                    - cost.callbacks
                    - cost.optimizer
                    - recorder.seconds,
            },
            peak_memory_bytes: machine::peak_memory(),
            factor: cost.factor.map(LargestFactor::from),
            versions: VersionNames::of_this_program(),
        }
    }

    /// Writes `summary.json` into `folder`.
    pub fn save(&self, folder: &Path) -> Result<(), Failure> {
        let path = folder.join("summary.json");
        let text = serde_json::to_string_pretty(self)?;
        files::write(path, text + "\n")
    }

    /// A short table for people.
    pub fn table(&self) -> String {
        let number = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.4}"));
        let share = |name: &str, seconds: f64| {
            let percent = 100.0 * seconds / self.wall_seconds;
            format!("\n  {name:<18} {seconds:>10.2} s {percent:>5.1} %")
        };
        let times = &self.seconds;
        [
            format!("{}: {}", self.scene, self.status),
            format!("\n  energy             {:>10} UF·UL", number(self.energy)),
            format!("\n  reaction           {:>10} UF", number(self.reaction)),
            format!(
                "\n  fixed point        {:>10} iterations",
                self.fixed_point_iterations
            ),
            format!(
                "\n  Ipopt              {:>10} iterations",
                self.ipopt_iterations
            ),
            format!("\n  factorisations     {:>10}", self.factorisations),
            self.factor
                .as_ref()
                .map_or(String::new(), |f| format!("\n  factor             {f}")),
            self.certificate.as_ref().map_or(String::new(), |found| {
                format!("\n  certificate of all steps {}", found.table)
            }),
            self.left_out.as_ref().map_or(String::new(), |left| {
                format!(
                    "\n  left out           {:>10} dofs, {} cells, {} rows, {} solves, {} Hessians",
                    left.dofs, left.cells, left.rows, left.solves, left.hessians
                )
            }),
            format!("\n  wall time          {:>10.2} s", self.wall_seconds),
            share("  projection", times.projection),
            share("  callbacks", times.callbacks),
            share("  optimizer", times.optimizer),
            share("  output", times.output),
            share("  other", times.other),
            format!(
                "\n  run by             Ipopt {} with {}, {}",
                self.versions.ipopt,
                self.versions.linear_solver.as_deref().unwrap_or("unknown"),
                self.versions.blas.as_deref().unwrap_or("unknown BLAS")
            ),
            match Blas::loaded().is_some_and(|blas| blas.is_reference()) {
                true => {
                    "\n  slow: the reference BLAS is loaded, `apt-get install libopenblas0-serial` \
                         gives a fast one"
                        .into()
                }
                false => String::new(),
            },
        ]
        .concat()
    }
}

/// Value by value the worst certificate.
pub fn worst<const D: usize>(records: &[StepRecord<D>]) -> Option<Certificate> {
    let certificates = records.iter().map(|record| record.certificate);
    certificates.reduce(Certificate::or_worse)
}

impl From<Certificate> for CertificateValues {
    fn from(certificate: Certificate) -> Self {
        let limits = Limits::default();
        let entries = certificate.entries(&limits);
        CertificateValues {
            holds: certificate.holds(&limits),
            dropped: certificate.dropped,
            values: entries.iter().map(|e| (e.name, e.value)).collect(),
            table: certificate.to_string(),
        }
    }
}

/// What all attempts cost.
fn total<const D: usize>(recorder: &Recorder<D>, ending: &End<'_, D>) -> Cost {
    match ending {
        End::History(history) => history.run.cost(),
        End::Failure(_) => recorder.records.iter().map(|r| r.attempt.cost).sum(),
    }
}

impl<const D: usize> End<'_, D> {
    /// Full load, every increment converged.
    pub fn is_complete(&self) -> bool {
        matches!(self, End::History(h) if h.run.ending == Ending::Complete)
    }

    /// Ctrl-C.
    pub fn is_interrupted(&self) -> bool {
        matches!(self, End::History(h) if matches!(h.run.ending, Ending::Interrupted { .. }))
    }

    fn left_out(&self, problem: &Problem<D>) -> Option<Unneeded> {
        let End::History(history) = self else {
            return None;
        };
        let left_out = LeftOut::new(problem, history);
        Some(Unneeded {
            dofs: left_out.dofs,
            cells: left_out.cells,
            rows: left_out.rows,
            solves: left_out.solves,
            hessians: left_out.hessians,
        })
    }

    fn cuts(&self) -> usize {
        match self {
            End::History(history) => history.run.cuts(),
            End::Failure(_) => 0,
        }
    }

    /// In words.
    pub fn status(&self) -> String {
        match self {
            End::Failure(error) => format!("failed: {error}"),
            End::History(history) => history.run.ending.to_string(),
        }
    }
}

impl MeshSize {
    /// Of all bodies.
    pub fn of<const D: usize>(problem: &Problem<D>) -> Self {
        let bodies = problem.scene().bodies();
        let mut contact_facets = vec![0; bodies.len()];
        for surface in problem.surfaces() {
            contact_facets[surface.body()] += surface.len();
        }
        MeshSize {
            nodes: problem.reference().len(),
            cells: bodies.iter().map(|body| body.mesh().len()).sum(),
            free_dofs: problem.dofs().free(),
            contact_facets,
        }
    }
}

impl From<FactorSize> for LargestFactor {
    fn from(factor: FactorSize) -> Self {
        LargestFactor {
            ordering: factor.ordering.into(),
            bytes: factor.bytes,
            workspace_bytes: factor.workspace_bytes,
            reallocations: factor.reallocations,
        }
    }
}

impl std::fmt::Display for LargestFactor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        write!(f, "{:>10.2} MB", megabytes(self.bytes))?;
        if let Some(workspace) = self.workspace_bytes {
            write!(f, " of {:.2} MB allocated", megabytes(workspace))?;
        }
        write!(f, ", ordered by {}", self.ordering)?;
        match self.reallocations {
            0 => Ok(()),
            count => write!(f, ", allocated anew {count} times"),
        }
    }
}

impl VersionNames {
    fn of_this_program() -> Self {
        let versions = ipopt_contact::versions();
        VersionNames {
            ipopt_contact: versions.ipopt_contact.into(),
            ipopt: versions.ipopt.into(),
            ipopt_libraries: versions
                .ipopt_libraries
                .iter()
                .map(ToString::to_string)
                .collect(),
            linear_solver: versions.linear_solver,
            linear_solvers: doctor::inspect().map_or(Vec::new(), |found| {
                let names = found.working_linear_solvers();
                names.map(str::to_owned).collect()
            }),
            blas: versions.blas.map(|blas| blas.to_string()),
            rustc: versions.rustc.into(),
            profile: versions.profile.into(),
        }
    }
}
