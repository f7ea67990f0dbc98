//! `ipopt-contact causes SCENE.toml RESULT`: why a scene and another program's result differ, by changing the scene.

use std::path::Path;
use std::process::ExitCode;

use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::contact_fem::model::{Geometry, Passes};
use ipopt_contact::contact_fem::output::compare::{Comparison, Note, Program, Quantity, compare};
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::scene_file::{Change, SceneFile};

use crate::{Words, help};

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

/// Results that differ by less than the first agree to round-off; below the second, `compare` calls them equal.
const EQUAL: [f64; 2] = [1e-11, 1e-6];

/// What the library has no switch for.
const NORMALS: &str =
    "not tried: normals of facets, since those of the library are averaged at the nodes";
/// What a script alone can change.
const TOLERANCE: &str = "not tried: the script's own tolerance of Ipopt, `tol` and `compl_inf_tol` of its option file; if it is the cause, a \
                         tenth of it leaves a tenth of the difference";

/// Prints a row a change, and the changes that bring the two together.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let words = Words::parse("causes", words, &["out"], &[])?;
    let [scene, result] = &words.plain[..] else {
        let see = help::see("causes");
        return Err(format!(
            "causes needs a scene file and the folder of a result: {see}"
        ));
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
    let asked = asked?;
    let name = match needs_straight {
        true => Change::Straight.to_string(),
        false => "as it is".into(),
    };
    print(row(&name, &asked.differences));
    let off = largest(&asked.differences);
    let mut causes = Vec::new();
    if off > EQUAL[0] {
        let straight = is_curved && !needs_straight;
        causes = found(&file, &tried, changes(&asked.notes, straight), off);
    }
    if needs_straight {
        causes.insert(0, (name, off));
    }
    print(NORMALS);
    if asked.is_of_script {
        print(TOLERANCE);
    }
    print(format!("\n{}", verdict(&causes, off)));
    Ok(ExitCode::SUCCESS)
}

/// The changes that leave less than a tenth of what is `off`, with what they leave, the least first.
fn found(
    file: &SceneFile,
    tried: &impl Fn(&SceneFile, &str) -> Result<Tried, String>,
    changes: impl Iterator<Item = Change>,
    off: f64,
) -> Vec<(String, f64)> {
    let mut causes = Vec::new();
    let mut one = |file: &SceneFile, name: String, folder: &str| match tried(file, folder) {
        Ok(Tried { differences, .. }) => {
            print(row(&name, &differences));
            let left = largest(&differences);
            if left < LEAVES * off {
                causes.push((name, left));
            }
        }
        Err(why) => print(format!("{name:<28} {why}")),
    };
    // scripts project to closest points: all other changes are tried with closest points
    let file = file.changed(Change::Closest);
    let closest = Change::Closest.to_string();
    one(&file, closest.clone(), "closest");
    print(format!("with {closest}, and"));
    for (k, change) in changes.enumerate() {
        let folder = format!("change_{k}");
        one(&file.changed(change), change.to_string(), &folder);
    }
    causes.sort_by(|a, b| a.1.total_cmp(&b.1));
    causes
}

/// The causes, or why there are none.
fn verdict(causes: &[(String, f64)], off: f64) -> String {
    let [round_off, tolerance] = EQUAL;
    let told = causes
        .iter()
        .map(|(name, left)| format!("{name}, which leaves {left:.1e}"));
    let told: Vec<String> = told.collect();
    match told[..] {
        [] if off <= round_off => {
            format!("the two agree to {off:.1e}, which is round-off: there is no cause to look for")
        }
        [] if off <= tolerance => format!(
            "the two agree to {off:.1e}, within the tolerance of `compare`, {tolerance:e}: no change leaves less than a tenth of that"
        ),
        [] => {
            "no change leaves less than a tenth of the difference: see the table of knobs in docs/freefem.md".into()
        }
        _ => format!("likely: {}", told.join("; ")),
    }
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

/// A run, compared with the result.
struct Tried {
    differences: Differences,
    /// What the two say of themselves.
    notes: Vec<Note>,
    is_of_script: bool,
}

/// The differences of a run from the result.
fn tried<const D: usize>(file: &SceneFile, folder: &Path, result: &Path) -> Result<Tried, String>
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
    Ok(Tried {
        differences,
        notes: comparison.notes,
        is_of_script: comparison.b.program == Program::Script,
    })
}
