//! FreeFEM's results kept in `freefem/reference`, for machines without it.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::cases::{Case, Size};
use super::outcome::{Outcome, difference};
use crate::{Failure, files};

/// The largest number of nodes of a body whose displacements are all stored; of more nodes only
/// every so many are.
const NODES: usize = 400;

/// A stored result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Reference {
    /// The script, in `freefem/`.
    pub script: String,
    /// The version of FreeFEM that ran it.
    pub freefem: String,
    /// The version of Ipopt that this library used on the same machine; FreeFEM's is the same if
    /// both are the system's.
    pub ipopt: String,
    /// The convergence tolerance of its fixed-point iterations: the relative change of the
    /// displacement.
    pub tolerance: f64,
    /// The script's `result.txt`.
    pub result: BTreeMap<String, f64>,
    /// The number of displacement components.
    pub dimension: usize,
    /// The distance of the node numbers in `displacements`.
    pub stride: usize,
    /// The displacements (UL) of nodes 0, stride, 2 stride, … of each body; components interleaved,
    /// with nine digits.
    pub displacements: BTreeMap<String, Vec<f64>>,
    /// The contact pressures (UF/UL²) of each body by node, with nine digits.
    pub pressures: BTreeMap<String, BTreeMap<usize, f64>>,
}

impl Reference {
    /// From the output files of a script.
    pub fn new(
        case: &Case,
        dimension: usize,
        outcome: &Outcome,
        script: &str,
        freefem: &str,
    ) -> Self {
        let nodes: usize = outcome.displacements.iter().map(Vec::len).sum::<usize>() / dimension;
        let stride = nodes.div_ceil(NODES).max(1);
        let kept = |all: &Vec<f64>| thinned(all, dimension, stride).map(rounded).collect();
        let pressures = |all: &BTreeMap<usize, f64>| -> BTreeMap<usize, f64> {
            all.iter().map(|(node, p)| (*node, rounded(*p))).collect()
        };
        let names = || case.bodies.iter().map(|name| name.to_string());
        Reference {
            script: script.into(),
            freefem: freefem.into(),
            ipopt: contact_core::ipopt::versions().ipopt.into(),
            tolerance: case.tolerance,
            result: outcome.values.clone(),
            dimension,
            stride,
            displacements: names()
                .zip(outcome.displacements.iter().map(kept))
                .collect(),
            pressures: names()
                .zip(outcome.pressures.iter().map(pressures))
                .collect(),
        }
    }

    /// The stored result of a case, if there is one.
    ///
    /// # Errors
    /// If the file does not contain a valid result of the case.
    pub fn read(case: &Case, size: Size) -> Result<Option<Self>, Failure> {
        let path = path(case, size);
        let wrong = |why: String| Failure::from(format!("{}: {why}", path.display()));
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(wrong(error.to_string())),
        };
        let read: Reference = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
        let has_all = |name: &&str| {
            read.displacements.contains_key(*name) && read.pressures.contains_key(*name)
        };
        if read.dimension == 0 || read.stride == 0 || !case.bodies.iter().all(has_all) {
            return Err(wrong("not a result of this scene".into()));
        }
        Ok(Some(read))
    }

    /// Stores the result and replaces an older one.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, case: &Case, size: Size) -> Result<(), Failure> {
        let path = path(case, size);
        if let Some(folder) = path.parent() {
            files::make_folder(folder)?;
        }
        files::write(path, serde_json::to_string(self)? + "\n")
    }

    /// The result as an outcome, without displacements.
    pub fn outcome(&self, case: &Case) -> Outcome {
        let pressures = case.bodies.iter().map(|name| self.pressures.get(*name));
        Outcome {
            values: self.result.clone(),
            pressures: pressures
                .map(|all| all.cloned().unwrap_or_default())
                .collect(),
            ..Outcome::default()
        }
    }

    /// The largest difference between the stored displacement components and those of `bodies` (in
    /// order, with components interleaved), relative to the largest stored one.
    pub fn displacement_difference(&self, case: &Case, bodies: &[Vec<f64>]) -> f64 {
        let (mut mine, mut theirs) = (Vec::new(), Vec::new());
        for (name, all) in case.bodies.iter().zip(bodies) {
            theirs.extend(thinned(all, self.dimension, self.stride));
            mine.extend(self.displacements.get(*name).into_iter().flatten());
        }
        difference(&theirs, &mine)
    }
}

/// The components of nodes 0, stride, 2 stride, ….
fn thinned(all: &[f64], dimension: usize, stride: usize) -> impl Iterator<Item = f64> + '_ {
    all.chunks(dimension).step_by(stride).flatten().copied()
}

/// Rounds to nine digits after the first one; NaN stays NaN.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(f64::NAN)
}

fn path(case: &Case, size: Size) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../freefem/reference");
    folder.join(format!("{}_{}.json", case.name, size.name()))
}
