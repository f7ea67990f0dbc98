//! The judge of runs by several programs: forces of supports against what these must carry.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::exchange::Reaction;
use crate::Failure;
use crate::tables::Table;

/// What a run comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// The run is complete, and all values are within their tolerances.
    Right,
    /// The run is complete, and all values are within a hundredth.
    Near,
    /// The run is complete, and a value is wrong: a false claim.
    Wrong,
    /// The run is not complete, or its certificate does not hold.
    Told,
    /// The program has no way to say what the scene is.
    NotExpressed,
}

/// A run of a case by a program, as it is stored.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Foreign {
    /// The name of the case.
    pub case: String,
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// Its settings.
    pub setting: String,
    /// `complete`, `not converged`, `killed`, `crashed` or `not expressed`.
    pub outcome: String,
    /// What the program says, in short.
    pub reason: String,
    /// The forces of the supports on each body at full load (UF).
    pub reactions: Option<Vec<Vec<f64>>>,
    /// Whether a certificate of the program holds, where it has one.
    #[serde(default)]
    pub certificate: Option<bool>,
    /// The law that stands in for the scene's, if any.
    #[serde(default)]
    pub law: Option<String>,
    /// Processor time (s).
    pub seconds: Option<f64>,
}

impl Verdict {
    /// Of a run, by what supports must carry.
    fn of(run: &Foreign, truth: &[Reaction]) -> Self {
        let reactions = match (&run.reactions, run.outcome.as_str(), run.certificate) {
            (_, "not expressed", _) => return Verdict::NotExpressed,
            (Some(reactions), "complete", None | Some(true)) => reactions,
            _ => return Verdict::Told,
        };
        let holds = |tolerance: f64| {
            let mut all = truth.iter().map(|own| own.under(run.law.as_deref()));
            all.all(|own| {
                let tolerance = own.tolerance.max(tolerance);
                Reaction { tolerance, ..own }.check(reactions).holds()
            })
        };
        match (holds(0.0), holds(0.01)) {
            (true, _) => Verdict::Right,
            (_, true) => Verdict::Near,
            _ => Verdict::Wrong,
        }
    }
}

/// Programs with their settings, and how many runs of each class come to what.
type Tally<'a> = BTreeMap<(&'a str, &'a str), BTreeMap<&'a str, Vec<Verdict>>>;

/// The tables of runs by several programs: all settings in sum, and the best setting of each by class.
///
/// # Errors
/// If a run is of no case.
pub fn judged(runs: &[Foreign]) -> Result<String, Failure> {
    let cases = super::all();
    let mut truths: BTreeMap<&str, (&str, Vec<Reaction>)> = BTreeMap::new();
    let mut tally: Tally<'_> = BTreeMap::new();
    for run in runs {
        if !truths.contains_key(run.case.as_str()) {
            let case = cases.iter().find(|case| case.name == run.case);
            let case = case.ok_or_else(|| format!("there is no case `{}`", run.case))?;
            let truth = case.reactions();
            let truth = truth.ok_or_else(|| format!("`{}` has other truths", run.case))?;
            truths.insert(&run.case, (case.class, truth));
        }
        let (class, truth) = &truths[run.case.as_str()];
        let own = tally.entry((&run.program, &run.setting)).or_default();
        let verdicts = own.entry(class).or_default();
        verdicts.push(Verdict::of(run, truth));
    }
    Ok(settings(&tally).markdown() + "\n" + &classes(&tally).markdown())
}

fn count(verdicts: &[Verdict], is: &[Verdict]) -> usize {
    verdicts
        .iter()
        .filter(|verdict| is.contains(verdict))
        .count()
}

/// Within a hundredth.
const SOLVED: [Verdict; 2] = [Verdict::Right, Verdict::Near];

/// One row a setting.
fn settings(tally: &Tally<'_>) -> Table {
    let mut table = Table::new(
        "settings",
        [
            "program",
            "setting",
            "runs",
            "within the tolerance",
            "within 1 %",
            "complete but wrong",
            "not complete",
            "not expressed",
        ],
    );
    table.quiet = true;
    for ((program, setting), classes) in tally {
        let all: Vec<Verdict> = classes.values().flatten().copied().collect();
        let of = |is: &[Verdict]| count(&all, is).to_string();
        table.push(vec![
            program.to_string(),
            setting.to_string(),
            all.len().to_string(),
            of(&[Verdict::Right]),
            of(&SOLVED),
            of(&[Verdict::Wrong]),
            of(&[Verdict::Told]),
            of(&[Verdict::NotExpressed]),
        ]);
    }
    table
}

/// One row a class, with the setting of each program that solves most.
fn classes(tally: &Tally<'_>) -> Table {
    type Setting<'a, 'b> = (&'b (&'a str, &'a str), &'b BTreeMap<&'a str, Vec<Verdict>>);
    let solved = |own: &Setting<'_, '_>| {
        let all: Vec<Verdict> = own.1.values().flatten().copied().collect();
        (count(&all, &SOLVED), count(&all, &[Verdict::Right]))
    };
    let mut best: Vec<Setting<'_, '_>> = Vec::new();
    for own in tally {
        match best.last_mut().filter(|last| last.0.0 == own.0.0) {
            Some(last) if solved(&own) > solved(last) => *last = own,
            Some(_) => {}
            None => best.push(own),
        }
    }
    let titles = best
        .iter()
        .map(|((program, setting), _)| format!("{program}, {setting}"));
    let columns = ["class".to_string(), "cases".to_string()];
    let mut table = Table::new("classes", columns.into_iter().chain(titles));
    table.quiet = true;
    let names: BTreeSet<&str> = tally.values().flat_map(|own| own.keys().copied()).collect();
    for name in names {
        let none = Vec::new();
        let all: Vec<&Vec<Verdict>> = best
            .iter()
            .map(|own| own.1.get(name).unwrap_or(&none))
            .collect();
        let most = all.iter().map(|all| all.len()).max().unwrap_or(0);
        let cells = all.iter().map(|all| match count(all, &[Verdict::Wrong]) {
            0 => count(all, &SOLVED).to_string(),
            wrong => format!("{}, {wrong} wrong", count(all, &SOLVED)),
        });
        table.push(
            [name.to_string(), most.to_string()]
                .into_iter()
                .chain(cells)
                .collect(),
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::{Case, all};
    use super::*;

    fn run_of(case: &Case, reactions: Option<[f64; 2]>) -> Foreign {
        Foreign {
            case: case.name.clone(),
            program: "another".into(),
            version: "another 1".into(),
            setting: "its own".into(),
            outcome: if reactions.is_some() {
                "complete"
            } else {
                "not converged"
            }
            .into(),
            reason: String::new(),
            reactions: reactions.map(|forces| forces.map(|force| vec![0.0, force]).into()),
            certificate: None,
            law: None,
            seconds: None,
        }
    }

    /// Two equal blocks of E = 1000, ν = 0.3 pressed to 0.95 of their height, in the plane with free sides: P = μ (s − 1/s) + λ ln J / s,
    /// where the side t satisfies μ (t² − 1) + λ ln (s t) = 0.
    #[test]
    fn runs_are_held_to_the_closed_form() {
        let (mu, lambda) = (1e3 / 2.6, 300.0 / (1.3 * 0.4));
        let (s, mut t) = (0.95f64, 1.0f64);
        for _ in 0..50 {
            let residual = mu * (t * t - 1.0) + lambda * (s * t).ln();
            t -= residual / (2.0 * mu * t + lambda / t);
        }
        let force = -(mu * (s - 1.0 / s) + lambda * (s * t).ln() / s);
        let all = all();
        let case = all
            .iter()
            .find(|case| case.name == "stack")
            .expect("there is one");
        let truth = case.reactions().expect("its truth is forces");
        let of = |lower: f64, upper: f64| {
            let run = run_of(case, Some([lower * force, -upper * force]));
            Verdict::of(&run, &truth)
        };
        assert_eq!(of(1.0, 1.0), Verdict::Right);
        assert_eq!(of(1.0, 1.0003), Verdict::Near);
        assert_eq!(of(0.995, 0.995), Verdict::Near);
        assert_eq!(of(1.0, 0.98), Verdict::Wrong);
        assert_eq!(of(-1.0, 1.0), Verdict::Wrong);
        assert_eq!(of(f64::NAN, 1.0), Verdict::Wrong);
        let given_up = run_of(case, None);
        assert_eq!(Verdict::of(&given_up, &truth), Verdict::Told);
        let mut run = run_of(case, Some([force, -force]));
        run.certificate = Some(false);
        assert_eq!(Verdict::of(&run, &truth), Verdict::Told);
        // another law has another force: μ (t² − 1) + λ/2 ((s t)² − 1) = 0
        let t2 = (2.0 * mu + lambda) / (2.0 * mu + lambda * s * s);
        let ciarlet = -(mu * (s - 1.0 / s) + 0.5 * lambda * (s * s * t2 - 1.0) / s);
        let mut run = run_of(case, Some([ciarlet, -ciarlet]));
        assert_eq!(Verdict::of(&run, &truth), Verdict::Near);
        run.law = Some("ciarlet".into());
        assert_eq!(Verdict::of(&run, &truth), Verdict::Right);
    }

    /// The table in the documentation is that of the runs that are stored.
    #[test]
    fn the_documentation_has_the_stored_runs() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let runs = crate::files::read(root.join("report/peers/stability.json")).expect("stored");
        let runs: Vec<Foreign> = serde_json::from_str(&runs).expect("runs");
        let page = crate::files::read(root.join("docs/extremes.md")).expect("a page");
        let tables = judged(&runs).expect("cases that there are");
        for line in tables.lines() {
            assert!(page.contains(line), "docs/extremes.md lacks `{line}`");
        }
        // the first page has a row of each program
        let readme = crate::files::read(root.join("README.md")).expect("a page");
        for (program, setting, is_best, says) in [
            (
                "GetFEM",
                "r = E/h",
                true,
                "GetFEM solves {}, and {} of its runs end",
            ),
            ("GetFEM", "r = 10 E/h", false, "({} and {} with r = 10 E/h)"),
            (
                "CalculiX",
                "K = 1e6 E/h",
                true,
                "CalculiX solves {}, and {} end so",
            ),
            (
                "ipopt-contact",
                "default",
                true,
                "This library solves {}, and {} end so",
            ),
        ] {
            let rows = tables
                .lines()
                .map(|line| line.split('|').map(str::trim).collect());
            let is_it = |row: &Vec<&str>| row.len() > 6 && row[1..3] == [program, setting];
            let row = rows.into_iter().find(is_it).expect("a row");
            let says = says.replacen("{}", row[5], 1).replacen("{}", row[6], 1);
            assert!(readme.contains(&says), "README.md lacks `{says}`");
            let has_column = tables.contains(&format!("{program}, {setting} "));
            assert_eq!(
                has_column, is_best,
                "{program}, {setting}: the setting that solves most"
            );
        }
    }
}
