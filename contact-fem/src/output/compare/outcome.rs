//! What the files of a result hold.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Error, Program, recorded, script};

/// A place or a vector; the third component is 0 in the plane.
pub(super) type Point = [f64; 3];

/// A result as its files hold it.
pub(super) struct Outcome {
    pub folder: PathBuf,
    pub program: Program,
    pub dimension: usize,
    /// The keys of a script's `result.txt`; those of a recorded run are translated.
    pub values: BTreeMap<String, f64>,
    /// How a recorded run ended, if not as it should.
    pub status: Option<String>,
    pub bodies: Vec<Fields>,
    /// The increment of a recorded run that strains the bodies most, if the last one strains them less.
    pub peak: Option<Peak>,
}

/// What a run went through before its end.
pub(super) struct Peak {
    /// The load factor at which the bodies are strained most.
    pub factor: f64,
    /// The largest |E| and the largest reaction on a body (UF·UL, UF), of all increments.
    pub energy: f64,
    pub reaction: f64,
    /// The fields of the increment.
    pub bodies: Vec<Fields>,
}

/// The fields of a body, by its nodes.
#[derive(Clone, Default)]
pub(super) struct Fields {
    pub name: String,
    /// Where the nodes are (UL), if the files say so.
    pub places: Option<Vec<Point>>,
    /// The nodes of each cell, if the files say so.
    pub cells: Vec<Vec<usize>>,
    pub displacements: Vec<Point>,
    /// Cᵀλ (UF).
    pub forces: Option<Vec<Point>>,
    /// Contact pressures by node.
    pub pressures: Option<BTreeMap<usize, f64>>,
}

impl Outcome {
    /// Reads the folder of a recorded run or of a script.
    pub(super) fn read(folder: &Path) -> Result<Self, Error> {
        let outcome = if folder.join(recorded::SUMMARY).exists() {
            recorded::read(folder)?
        } else if folder.join(script::RESULT).exists() {
            script::read(folder)?
        } else {
            let folder = folder.into();
            return Err(Error::NoResult { folder });
        };
        Ok(outcome)
    }

    pub(super) fn value(&self, key: &str) -> Option<f64> {
        self.values.get(key).copied()
    }

    /// The components under the keys `NAME_x`, `NAME_y` and `NAME_z`, as far as they are there.
    pub(super) fn vector(&self, name: &str) -> [Option<f64>; 3] {
        let mut vector = [None; 3];
        for (value, axis) in vector.iter_mut().zip(AXES).take(self.dimension) {
            *value = self.value(&format!("{name}_{axis}"));
        }
        vector
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.bodies.iter().map(|body| body.name.clone()).collect()
    }

    pub(super) fn body(&self, name: &str) -> Option<&Fields> {
        self.bodies.iter().find(|body| body.name == name)
    }
}

/// The last letters of the keys of a vector's components.
pub(super) const AXES: [char; 3] = ['x', 'y', 'z'];

pub(super) fn text(path: &Path) -> Result<String, Error> {
    std::fs::read_to_string(path).map_err(|source| Error::Unreadable {
        path: path.into(),
        source,
    })
}

pub(super) fn malformed(path: &Path, what: impl ToString) -> Error {
    Error::Malformed {
        path: path.into(),
        what: what.to_string(),
    }
}

/// The value, if it is finite.
pub(super) fn finite(path: &Path, what: impl Fn() -> String, value: f64) -> Result<f64, Error> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(Error::NotFinite {
            path: path.into(),
            what: what(),
            value,
        }),
    }
}
