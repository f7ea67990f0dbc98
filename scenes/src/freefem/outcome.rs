//! The output files of a run, and the differences between two runs.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use super::cases::Case;
use crate::{Failure, files};

/// The contents of a run's output files.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// `result.txt`.
    pub values: BTreeMap<String, f64>,
    /// The displacements of each body's nodes (UL), components interleaved.
    pub displacements: Vec<Vec<f64>>,
    /// The contact pressures of each body by node, for bodies that have any.
    pub pressures: Vec<BTreeMap<usize, f64>>,
}

impl Outcome {
    /// Reads a run's folder.
    ///
    /// # Errors
    /// If a file is missing or contains something other than numbers; pressures may be missing.
    pub fn read(case: &Case, folder: &Path) -> Result<Self, Failure> {
        let mut values = BTreeMap::new();
        for line in files::read(folder.join("result.txt"))?.lines() {
            if let Some((key, value)) = line.split_once(' ') {
                values.insert(key.to_string(), number(value, "result.txt")?);
            }
        }
        let mut outcome = Outcome {
            values,
            ..Outcome::default()
        };
        for body in case.bodies {
            let name = format!("displacement_{body}.txt");
            let all = files::read(folder.join(&name))?;
            let numbers: Result<Vec<f64>, Failure> = all
                .split_whitespace()
                .map(|word| number(word, &name))
                .collect();
            outcome.displacements.push(numbers?);
            let name = format!("pressure_{body}.txt");
            let mut pressures = BTreeMap::new();
            for line in files::read(folder.join(&name)).unwrap_or_default().lines() {
                if let Some((node, pressure)) = line.trim().split_once(' ') {
                    pressures.insert(number(node, &name)?, number(pressure, &name)?);
                }
            }
            outcome.pressures.push(pressures);
        }
        Ok(outcome)
    }

    /// A value of `result.txt`; NaN if it is missing.
    pub fn value(&self, key: &str) -> f64 {
        self.values.get(key).copied().unwrap_or(f64::NAN)
    }

    /// Whether the run reports that all increments converged.
    pub fn converged(&self) -> bool {
        self.value("converged") == 1.0
    }

    /// The relative difference of the energies.
    pub fn energy_difference(&self, other: &Outcome) -> f64 {
        let (a, b) = (self.value("energy"), other.value("energy"));
        (a - b).abs() / b.abs()
    }

    /// The largest difference of the reaction's components, relative to the largest component.
    pub fn reaction_difference(&self, other: &Outcome) -> f64 {
        let keys = ["reaction_x", "reaction_y", "reaction_z"];
        let present = || keys.iter().filter(|key| other.values.contains_key(**key));
        let off = present().map(|key| (self.value(key) - other.value(key)).abs());
        let size = present().map(|key| other.value(key).abs());
        largest(off) / largest(size)
    }

    /// The largest difference of a displacement component, relative to the largest displacement.
    pub fn displacement_difference(&self, other: &Outcome) -> f64 {
        let (a, b) = (self.displacements.concat(), other.displacements.concat());
        difference(&a, &b)
    }

    /// The largest difference of a nodal pressure, relative to the largest pressure.
    pub fn pressure_difference(&self, other: &Outcome) -> f64 {
        let pairs = self.pressures.iter().zip(&other.pressures);
        let (a, b): (Vec<f64>, Vec<f64>) = pairs
            .flat_map(|(mine, theirs)| {
                mine.iter()
                    .filter_map(|(node, p)| Some((*p, *theirs.get(node)?)))
            })
            .unzip();
        difference(&a, &b)
    }
}

/// The largest |aᵢ − bᵢ| divided by the largest |bᵢ|; NaN if there are none or their numbers
/// differ.
pub fn difference(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() || a.is_empty() {
        return f64::NAN;
    }
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    largest(off) / largest(b.iter().map(|b| b.abs()))
}

/// The largest value; NaN if any value is.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    values.fold(0.0, larger)
}

fn number<T: FromStr>(word: &str, file: &str) -> Result<T, Failure> {
    let word = word.trim();
    word.parse()
        .map_err(|_| format!("{file}: `{word}` is no number").into())
}
