//! Stored results of FreeFEM, put on the same axes.
//!
//! `freefem/reference/SCENE_SIZE.json` is what the example `freefem_compare` keeps of a script's run on the mesh of
//! that scene: its energy, its supports' reactions and its seconds of processor time.

use std::fs;
use std::path::Path;

use ipopt_contact::contact_core::ContactProblem;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::element::{Element, Order, P1, P2};
use ipopt_contact::prelude::*;
use serde::Deserialize;

use crate::Failure;
use crate::families::Family;
use crate::record::{Cost, Measured, Numbers};
use crate::study::Axis;
use ipopt_contact_scenes::beams::{Beams, Law, SIDE};
use ipopt_contact_scenes::disc_in_disc::{self, Roles};
use ipopt_contact_scenes::hertz::{self, Hertz};

/// One result.
#[derive(Clone, Debug)]
pub struct Point {
    /// The name of its family.
    pub family: &'static str,
    /// Program and scene.
    pub label: String,
    measured: Measured,
}

impl Point {
    /// Where it is on an axis, if it tells.
    pub fn at(&self, axis: Axis) -> Option<f64> {
        axis.of(&self.measured)
    }

    /// Its error, if it has the value that it is an error of and is not about as fine as the refined run.
    pub fn error(&self, family: &Family, name: &str, refined: Option<&Measured>) -> Option<f64> {
        let value = family.quantity(name)?.refined?;
        let refined = refined.filter(|_| self.is_coarser(refined))?;
        Some((self.measured.values.get(value)? / refined.values.get(value)? - 1.0).abs())
    }

    /// Whether it has at most half of the refined run's unknowns: on the same mesh there would be no error at all.
    pub fn is_coarser(&self, refined: Option<&Measured>) -> bool {
        refined.is_some_and(|refined| 2 * self.measured.dofs <= refined.dofs)
    }
}

/// What is read of a file.
#[derive(Deserialize)]
struct Stored {
    freefem: String,
    result: Numbers,
}

/// A scene of `freefem_compare` that is one of a family, too.
struct Scenery {
    /// As in the file's name.
    name: &'static str,
    family: &'static str,
    /// Names of values of the family and of the result.
    values: &'static [(&'static str, &'static str)],
    /// The mesh size (UL) and free unknowns of the linear scene, by size.
    mesh: fn(usize) -> Result<(f64, usize), Error>,
}

/// As in the files' names, the coarsest first.
const SIZES: [&str; 4] = ["tiny", "small", "medium", "large"];

const SCENERIES: [Scenery; 3] = [
    Scenery {
        name: "hertz",
        family: "hertz-2d-published",
        values: &[("energy", "energy")],
        mesh: |size| {
            let fineness = hertz::Fineness::family([4, 8, 16, 32][size]);
            let hertz = Hertz::new(fineness, Order::Linear);
            Ok((hertz.facets()[0], dofs(hertz.scene()?)?))
        },
    },
    Scenery {
        name: "disc_in_disc",
        family: "disc-in-disc",
        values: &[("energy", "energy"), ("reaction", "reaction_y")],
        mesh: |size| {
            let hole = [24, 64, 114, 231][size];
            let scene =
                disc_in_disc::scene(disc_in_disc::Fineness::scaled(hole), Roles::default())?;
            Ok((std::f64::consts::TAU * 0.7 / hole as f64, dofs(scene)?))
        },
    },
    Scenery {
        name: "beams_small_strain",
        family: "three-beams",
        values: &[("energy", "energy"), ("force", "reaction_z_beam1")],
        mesh: |size| {
            let [across, along] = [[2, 8], [3, 24], [6, 48], [10, 80]][size];
            let beams = Beams {
                along,
                ..Beams::new(across, Order::Linear, Law::SmallStrain)
            };
            Ok((SIDE / across as f64, dofs(beams.scene()?)?))
        },
    },
];

fn dofs<const D: usize>(scene: Scene<D>) -> Result<usize, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    Ok(scene.problem()?.energy().dofs())
}

/// All points of a folder, and a sentence for every file that is not read.
pub fn load(folder: &Path) -> (Vec<Point>, Vec<String>) {
    let (mut points, mut remarks) = (Vec::new(), Vec::new());
    for scenery in &SCENERIES {
        for (size, name) in SIZES.iter().enumerate() {
            let file = format!("{}_{name}.json", scenery.name);
            let path = folder.join(&file);
            if !path.exists() {
                continue;
            }
            match point(scenery, size, &path) {
                Ok(point) => points.push(point),
                Err(why) => remarks.push(format!("{file} is no result of FreeFEM's: {why}.")),
            }
        }
    }
    (points, remarks)
}

fn point(scenery: &Scenery, size: usize, path: &Path) -> Result<Point, Failure> {
    let Stored { freefem, result } = serde_json::from_str(&fs::read_to_string(path)?)?;
    if result.get("converged") != Some(&1.0) {
        return Err("it did not converge".into());
    }
    let values = scenery.values.iter();
    let values =
        values.filter_map(|(ours, theirs)| Some((ours.to_string(), *result.get(*theirs)?)));
    let (h, dofs) = (scenery.mesh)(size)?;
    let measured = Measured {
        h,
        dofs,
        values: values.collect(),
        cost: Cost {
            cpu: result.get("seconds_total").copied(),
            ..Cost::default()
        },
        ..Measured::default()
    };
    let steps = result.get("increments");
    let steps = steps.map_or(String::new(), |n| format!(", {n} increments"));
    Ok(Point {
        family: scenery.family,
        label: format!(
            "{}, {}, P1, {dofs} dofs{steps}: {freefem}",
            scenery.name, SIZES[size]
        ),
        measured,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families;

    #[test]
    fn stored_results_are_read() {
        let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("../freefem/reference");
        let (points, remarks) = load(&stored);
        assert!(remarks.is_empty(), "{remarks:?}");
        for scenery in &SCENERIES {
            let mut own = points.iter().filter(|p| p.family == scenery.family);
            let point = own.next().expect("a stored result");
            assert_eq!(point.measured.values.len(), scenery.values.len());
            assert!(point.at(Axis::Cpu).is_some() && point.at(Axis::Dofs).is_some());
            assert_eq!(point.at(Axis::Wall), None);
            let family = families::named(scenery.family).expect("a family");
            let twice = point
                .measured
                .values
                .iter()
                .map(|(k, v)| (k.clone(), 2.0 * v));
            let mut refined = Measured {
                dofs: 4 * point.measured.dofs,
                values: twice.collect(),
                ..Measured::default()
            };
            let error = point.error(&family, "energy", Some(&refined));
            assert!((error.expect("a value") - 0.5).abs() < 1e-15);
            refined.dofs = point.measured.dofs;
            let error = point.error(&family, "energy", Some(&refined));
            assert_eq!(error, None, "on the same mesh");
            assert_eq!(point.error(&family, "energy", None), None);
        }
    }

    #[test]
    fn what_is_no_result_is_told() {
        let folder = std::env::temp_dir().join(format!("report-freefem-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("written");
        write("hertz_tiny.json", "{\"other\": 1}");
        let failed = r#"{"freefem": "4.9", "result": {"converged": 0, "energy": 1}}"#;
        write("hertz_small.json", failed);
        write("arch_tiny.json", "of no family");
        let (points, remarks) = load(&folder);
        fs::remove_dir_all(&folder).expect("removed");
        assert_eq!((points.len(), remarks.len()), (0, 2), "{remarks:?}");
        assert!(load(Path::new("/nowhere at all")).0.is_empty());
    }
}
