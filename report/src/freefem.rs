//! Results of FreeFEM, put on the same axes.
//!
//! Every `.json` file in `freefem/reference` may hold one point or a list of them:
//!
//! ```json
//! { "family": "hertz-2d", "label": "FreeFEM, P1", "h": 0.17, "dofs": 9000, "wall": 3.1, "cpu": 3.0,
//!   "factorizations": 40, "errors": { "p0": 0.012 }, "values": {} }
//! ```
//!
//! Families and errors are those of this report; what is not known is left out. `values` are taken against the refined
//! solution, as those of this library are.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::families::Family;
use crate::record::{Cost, Measured, Numbers};
use crate::study::Axis;

/// One result.
#[derive(Clone, Debug, Deserialize)]
pub struct Point {
    /// The name of its family.
    pub family: String,
    /// Program and settings.
    pub label: String,
    h: Option<f64>,
    dofs: Option<usize>,
    wall: Option<f64>,
    cpu: Option<f64>,
    factorizations: Option<usize>,
    #[serde(default)]
    errors: Numbers,
    #[serde(default)]
    values: Numbers,
}

impl Point {
    /// Where it is on an axis, if it tells.
    pub fn at(&self, axis: Axis) -> Option<f64> {
        axis.of(&Measured {
            h: self.h.unwrap_or_default(),
            dofs: self.dofs.unwrap_or_default(),
            cost: Cost {
                wall: self.wall.unwrap_or_default(),
                cpu: self.cpu,
                factorizations: self.factorizations.unwrap_or_default(),
                ..Cost::default()
            },
            ..Measured::default()
        })
    }

    /// Its error, if it has that or the value that it is an error of.
    pub fn error(&self, family: &Family, name: &str, refined: Option<&Numbers>) -> Option<f64> {
        let from_values = || {
            let value = family.quantity(name)?.refined?;
            Some((self.values.get(value)? / refined?.get(value)? - 1.0).abs())
        };
        self.errors.get(name).copied().or_else(from_values)
    }
}

/// One or many, as a file has them.
#[derive(Deserialize)]
#[serde(untagged)]
enum File {
    One(Point),
    Many(Vec<Point>),
}

/// All points of a folder, and a sentence for every file that is not read.
pub fn load(folder: &Path) -> (Vec<Point>, Vec<String>) {
    let (mut points, mut remarks) = (Vec::new(), Vec::new());
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = files.map(|file| file.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "json"));
    paths.sort();
    for path in paths {
        let text = fs::read_to_string(&path).map_err(|e| e.to_string());
        let parsed = text.and_then(|t| serde_json::from_str(&t).map_err(|e| e.to_string()));
        match parsed {
            Ok(File::One(point)) => points.push(point),
            Ok(File::Many(many)) => points.extend(many),
            Err(why) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                remarks.push(format!("{name} has no points of this report: {why}."));
            }
        }
    }
    (points, remarks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families;

    #[test]
    fn points_are_read_and_others_are_told() {
        let folder = std::env::temp_dir().join(format!("report-freefem-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let point =
            r#"{"family": "three-beams", "label": "a", "dofs": 90, "values": {"tip": 20.0}}"#;
        fs::write(folder.join("a.json"), point).expect("written");
        fs::write(folder.join("b.json"), format!("[{point}, {point}]")).expect("written");
        fs::write(folder.join("c.json"), "{\"other\": 1}").expect("written");
        fs::write(folder.join("d.txt"), "no").expect("written");
        let (points, remarks) = load(&folder);
        fs::remove_dir_all(&folder).expect("removed");
        assert_eq!((points.len(), remarks.len()), (3, 1), "{remarks:?}");
        let family = families::named("three-beams").expect("a family");
        let refined: Numbers = [("tip".to_string(), 25.0)].into();
        let error = points[0].error(&family, "tip", Some(&refined));
        assert!((error.expect("a value") - 0.2).abs() < 1e-15);
        assert_eq!(points[0].error(&family, "force", Some(&refined)), None);
        assert_eq!(points[0].at(Axis::Dofs), Some(90.0));
        assert_eq!(points[0].at(Axis::Wall), None);
        assert!(load(Path::new("/nowhere at all")).0.is_empty());
    }
}
