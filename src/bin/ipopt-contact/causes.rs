//! `ipopt-contact causes SCENE.toml RESULT`: why a scene and another program's result differ, by changing the scene.

use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::contact_fem::model::{Geometry, Passes};
use ipopt_contact::contact_fem::output::compare::{Comparison, Quantity, compare};
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::scene_file::{Change, SceneFile};

use crate::Words;

/// A change is a likely cause if it leaves less than this share of the difference.
const LEAVES: f64 = 0.1;

/// Everything that is tried.
const CHANGES: [Change; 15] = [
    Change::Points(2),
    Change::Points(3),
    Change::Points(4),
    Change::Points(5),
    Change::Points(6),
    Change::Points(8),
    Change::Points(12),
    Change::Passes(Passes::FirstIsSlave),
    Change::Passes(Passes::SecondIsSlave),
    Change::Passes(Passes::Both),
    Change::Geometry(Geometry::Reference),
    Change::Geometry(Geometry::Current),
    Change::Tolerance(1e-6),
    Change::Tolerance(1e-10),
    Change::Increments(20),
];

/// Prints a row a change, and the changes that bring the two together.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse(words, &["out"])?;
    let [scene, result] = &words.plain[..] else {
        return Err("causes needs a scene file and the folder of a result".into());
    };
    let out = Path::new(words.needed("out")?);
    let file = SceneFile::read(scene).map_err(|why| format!("{scene}: {why}"))?;
    let dimension = file.dimension().map_err(|why| format!("{scene}: {why}"))?;
    let differences = |file: &SceneFile, name: &str| match dimension {
        2 => differences::<2>(file, &out.join(name), Path::new(result)),
        _ => differences::<3>(file, &out.join(name), Path::new(result)),
    };
    let asked = differences(&file, "as_it_is")?;
    print(format!(
        "{:<28} {:>10} {:>12} {:>10}",
        "", "energy", "displacement", "force"
    ));
    print(row("as it is", &asked));
    let mut causes = Vec::new();
    for (k, change) in CHANGES.into_iter().enumerate() {
        let name = change.to_string();
        match differences(&file.changed(change), &format!("change_{k}")) {
            Ok(found) => {
                print(row(&name, &found));
                if largest(&found) < LEAVES * largest(&asked) {
                    causes.push((name, largest(&found)));
                }
            }
            Err(why) => print(format!("{name:<28} {why}")),
        }
    }
    causes.sort_by(|a, b| a.1.total_cmp(&b.1));
    let told = causes
        .iter()
        .map(|(name, left)| format!("{name}, which leaves {left:.1e}"));
    let told: Vec<String> = told.collect();
    print(match told[..] {
        [] => "\nno change brings them together: see the table of knobs in docs/freefem.md"
            .to_string(),
        _ => format!("\nlikely: {}", told.join("; ")),
    });
    Ok(ExitCode::SUCCESS)
}

/// The relative differences of energy, displacements and contact forces, where both have them.
type Differences = [Option<f64>; 3];

fn largest(differences: &Differences) -> f64 {
    differences.iter().flatten().fold(0.0, |a, b| a.max(*b))
}

fn row(name: &str, [energy, displacement, force]: &Differences) -> String {
    let short = |value: &Option<f64>| value.map_or("-".into(), |value| format!("{value:.2e}"));
    let (energy, displacement, force) = (short(energy), short(displacement), short(force));
    format!("{name:<28} {energy:>10} {displacement:>12} {force:>10}")
}

fn differences<const D: usize>(
    file: &SceneFile,
    folder: &Path,
    result: &Path,
) -> Result<Differences, String>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let scene = file.scene::<D>().map_err(|why| why.to_string())?;
    let mut problem = scene.problem().map_err(|why| why.to_string())?;
    let mut simulation = file.simulation().map_err(|why| why.to_string())?;
    let mut recording = simulation.record(folder);
    recording.plan.quiet = true;
    recording.plan.picture = String::new();
    let recorded = recording.run(&mut problem).map_err(|why| why.to_string())?;
    if !recorded.history.is_complete() {
        return Err(recorded.history.run.ending.to_string());
    }
    let comparison = compare(folder, result).map_err(|why| why.to_string())?;
    let of = |comparison: &Comparison, quantity| {
        let mut rows = comparison.rows.iter();
        rows.find(|row| row.quantity == quantity)?.relative
    };
    Ok([
        Quantity::Energy,
        Quantity::Displacement,
        Quantity::ContactForce,
    ]
    .map(|quantity| of(&comparison, quantity)))
}
