//! `ipopt-contact causes SCENE.toml RESULT`: why a scene and another program's result differ, by changing the scene.

use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::contact_fem::model::{Geometry, Passes};
use ipopt_contact::contact_fem::output::compare::{Comparison, Note, Quantity, compare};
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::scene_file::{Change, SceneFile};

use crate::Words;

/// A change is a likely cause if it leaves less than this share of the difference.
const LEAVES: f64 = 0.1;

/// What is tried in every scene.
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

/// What the library has no switch for.
const NOT_TRIED: &str =
    "not tried: normals of facets, since those of the library are averaged at the nodes";

/// Prints a row a change, and the changes that bring the two together.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse(words, &["out"], &[])?;
    let [scene, result] = &words.plain[..] else {
        return Err("causes needs a scene file and the folder of a result".into());
    };
    let out = Path::new(words.needed("out")?);
    let in_file = |why: ipopt_contact::scene_file::Error| format!("{scene}: {why}");
    let mut file = SceneFile::read(scene).map_err(in_file)?;
    let is_plane = file.dimension().map_err(in_file)? == 2;
    let tried = |file: &SceneFile, name: &str| match is_plane {
        true => tried::<2>(file, &out.join(name), Path::new(result)),
        false => tried::<3>(file, &out.join(name), Path::new(result)),
    };
    let is_curved = match is_plane {
        true => file.is_curved::<2>(),
        false => file.is_curved::<3>(),
    };
    let is_curved = is_curved.map_err(in_file)?;
    print(format!(
        "{:<28} {:>10} {:>12} {:>10}",
        "", "energy", "displacement", "force"
    ));
    let mut asked = tried(&file, "as_it_is");
    let mut needs_straight = false;
    if let (Err(why), true) = (&asked, is_curved) {
        print(format!("{:<28} {why}", "as it is"));
        // nodes in the middle of straight sides are elsewhere
        file = file.changed(Change::Straight);
        asked = tried(&file, "straight");
        needs_straight = asked.is_ok();
    }
    let (asked, notes) = asked?;
    let name = match needs_straight {
        true => Change::Straight.to_string(),
        false => "as it is".into(),
    };
    print(row(&name, &asked));
    let mut causes = Vec::new();
    // scripts project to closest points: all other changes are tried with closest points
    file = file.changed(Change::Closest);
    let closest = Change::Closest.to_string();
    match tried(&file, "closest") {
        Ok((found, _)) => {
            print(row(&closest, &found));
            if largest(&found) < LEAVES * largest(&asked) {
                causes.push((closest.clone(), largest(&found)));
            }
        }
        Err(why) => print(format!("{closest:<28} {why}")),
    }
    print(format!("with {closest}, and"));
    for (k, change) in changes(&notes, is_curved && !needs_straight).enumerate() {
        let name = change.to_string();
        match tried(&file.changed(change), &format!("change_{k}")) {
            Ok((found, _)) => {
                print(row(&name, &found));
                if largest(&found) < LEAVES * largest(&asked) {
                    causes.push((name, largest(&found)));
                }
            }
            Err(why) => print(format!("{name:<28} {why}")),
        }
    }
    causes.sort_by(|a, b| a.1.total_cmp(&b.1));
    if needs_straight {
        causes.insert(0, (name, largest(&asked)));
    }
    let told = causes
        .iter()
        .map(|(name, left)| format!("{name}, which leaves {left:.1e}"));
    let told: Vec<String> = told.collect();
    print(NOT_TRIED);
    print(match told[..] {
        [] => "\nno change leaves less than a tenth of the difference: see the table of knobs in docs/freefem.md"
            .to_string(),
        _ => format!("\nlikely: {}", told.join("; ")),
    });
    Ok(ExitCode::SUCCESS)
}

/// All that is tried: what the two results say of themselves first.
fn changes(notes: &[Note], is_curved: bool) -> impl Iterator<Item = Change> {
    let told = notes.iter().filter_map(|note| match *note {
        Note::Increments { b, .. } if b >= 1.0 && b.fract() == 0.0 => {
            Some(Change::Increments(b as usize))
        }
        Note::Tolerances { b, .. } => Some(Change::Tolerance(b)),
        _ => None,
    });
    let told: Vec<Change> = told.collect();
    let others: Vec<Change> = CHANGES
        .iter()
        .copied()
        .filter(|change| !told.contains(change))
        .collect();
    let straight = is_curved.then_some(Change::Straight);
    told.into_iter().chain(straight).chain(others)
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

/// The differences of a run from the result, and what the two say of themselves.
fn tried<const D: usize>(
    file: &SceneFile,
    folder: &Path,
    result: &Path,
) -> Result<(Differences, Vec<Note>), String>
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
    let differences = [
        Quantity::Energy,
        Quantity::Displacement,
        Quantity::ContactForce,
    ]
    .map(|quantity| of(&comparison, quantity));
    Ok((differences, comparison.notes))
}
