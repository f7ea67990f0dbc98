//! `ipopt-contact run SCENE.toml --accuracy 1%`: finer and finer meshes, and the error against the time that they took.

use std::cell::Cell;
use std::error::Error;
use std::path::Path;
use std::process::{ExitCode, Termination};
use std::time::Instant;

use ipopt_contact::contact_core::{Ending, Equilibrium, Interruption};
use ipopt_contact::contact_fem::Simulation;
use ipopt_contact::contact_fem::accuracy::{Accuracy, Ended, Level, Refined, Refinement, Solved};
use ipopt_contact::contact_fem::certificate::Limits;
use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::contact_fem::model::FindingKind;
use ipopt_contact::contact_fem::output::picture::{Curve, Curves};
use ipopt_contact::contact_fem::output::record::{Recorded, print};
use ipopt_contact::scene_file::SceneFile;

use crate::Words;

/// The accuracy that is asked for, if one is.
pub fn asked(words: &Words) -> Result<Option<Accuracy>, String> {
    let Some(text) = words.option("accuracy") else {
        let mut given = ["seconds", "path"].into_iter();
        return match given.find(|name| words.option(name).is_some()) {
            Some(name) => Err(format!(
                "--{name} has no effect without --accuracy: leave it out"
            )),
            None => Ok(None),
        };
    };
    let share = match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse::<f64>().map(|value| 0.01 * value),
        None => text.parse(),
    };
    let share = share.map_err(|_| {
        format!("--accuracy needs a share of the energy norm such as 1% or 0.01, not `{text}`")
    })?;
    let mut accuracy = Accuracy::of(share);
    if let Some(text) = words.option("seconds") {
        let seconds = text.parse();
        accuracy.seconds =
            seconds.map_err(|_| format!("--seconds needs a number of seconds, not `{text}`"))?;
    }
    accuracy.validate().map_err(|why| why.to_string())?;
    Ok(Some(accuracy))
}

/// A run from the end of the last level may take as many factorisations as the path on the first mesh, and this number in any case. A mesh that needs more walks the whole
/// path. In 45 random scenes in space such runs took five at most, or came to no end; in the plane, discs in rings took up to 14, and paths 20 to 140.
const BEGINS: usize = 10;

/// Solves the scene on its own meshes and on finer ones, each recorded in a folder of its own.
pub fn run<const D: usize>(
    (path, file): (&str, &SceneFile),
    (accuracy, walks_paths): (&Accuracy, bool),
    out: &Path,
    simulation: impl Fn() -> Result<Simulation<Box<dyn Equilibrium>>, String>,
) -> Result<ExitCode, String>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let in_file = |why: &dyn std::fmt::Display| format!("{path}: {why}");
    let mut levels: Vec<Level> = Vec::new();
    let mut unwritten = None;
    let clock = Instant::now();
    // the factorisations of the path on the first mesh: beyond as many, a finer mesh is likely to be quicker by its path
    let walked = Cell::new(BEGINS);
    // the scene on the meshes of a level, from the end of the last one on or by its whole path
    let solve = |refinement: &Refinement, begins: bool| -> Result<Solved<D>, Box<dyn Error>> {
        let file = file.refined(refinement);
        let mut simulation = simulation()?;
        let mut problem = file.problem::<D>().map_err(|why| in_file(&why))?;
        let budget = &mut simulation.load_steps.budget;
        // the first level is needed in any case
        if refinement.level() > 0 {
            let left = (accuracy.seconds - clock.elapsed().as_secs_f64()).max(0.0);
            budget.seconds = Some(budget.seconds.map_or(left, |own| own.min(left)));
        }
        if let Some(start) = refinement.start(&problem)?.filter(|_| begins) {
            let own = budget.factorizations.unwrap_or(usize::MAX);
            budget.factorizations = Some(own.min(walked.get()));
            simulation.load_steps.guess = Some(start);
            simulation.load_steps.increments = 1;
            // bodies are where they belong already
            let findings = problem.findings_mut();
            findings.retain(|finding| finding.kind != FindingKind::LongStep);
        }
        let checked = file.check(&simulation, &mut problem);
        checked.map_err(|why| in_file(&why))?;
        let folder = out.join(format!("level_{}", refinement.level()));
        let recording = file.record(&mut simulation, &problem, folder);
        let mut recording = recording.map_err(|why| in_file(&why))?;
        recording.plan.quiet = true;
        let recorded = recording.run(&mut problem);
        let recorded = recorded.map_err(|why| in_file(&file.refused(why)))?;
        let history = recorded.history;
        if refinement.level() == 0 {
            walked.set(history.run.cost().factorizations.max(BEGINS));
        }
        Ok(Solved { problem, history })
    };
    let begins = !walks_paths && simulation()?.load_steps.phases.is_empty();
    let reached = accuracy.reach(
        |refinement| {
            let solved = solve(refinement, begins)?;
            let leads_nowhere = match solved.history.run.ending {
                Ending::NotConverged { .. } => true,
                Ending::Interrupted { why, .. } => matches!(
                    why,
                    Interruption::Factorizations { limit } if limit == walked.get()
                ),
                _ => false,
            };
            let began = begins && refinement.start(&solved.problem)?.is_some();
            match began && leads_nowhere {
                true => solve(refinement, false),
                false => Ok(solved),
            }
        },
        |level| {
            print(level);
            levels.push(*level);
            unwritten = unwritten.take().or(write(out, &levels).err());
        },
    );
    let reached = reached.map_err(|why| why.to_string())?;
    match unwritten {
        Some(why) => Err(why),
        None => Ok(ended(accuracy, reached, out)),
    }
}

/// Says how it ended, and with which exit code.
fn ended<const D: usize>(accuracy: &Accuracy, reached: Refined<D>, out: &Path) -> ExitCode {
    let asked = 100.0 * accuracy.asked;
    let best = reached
        .levels
        .last()
        .map_or("no level is complete".into(), |level| {
            format!(
                "{:.3} % with {} unknowns, results in {}",
                100.0 * level.estimated_error,
                level.unknowns,
                out.join(format!("level_{}", level.number)).display()
            )
        });
    let why = match &reached.ended {
        Ended::Reached => format!("accuracy {asked} % reached"),
        Ended::Incomplete(why) => {
            format!("accuracy {asked} % not reached: the next level is not complete, {why}")
        }
        Ended::Limit(limit) => format!(
            "accuracy {asked} % not reached: the next level would exceed the limit of {limit}"
        ),
        Ended::Stalled { body, place } => {
            let place: Vec<String> = place.iter().map(|x| format!("{x:.3}")).collect();
            format!(
                "accuracy {asked} % not reached: the estimate falls no more, and most of it is in body `{body}` near ({}); where a support \
                 or a force acts on a point, energies have no limit: let it act on a boundary",
                place.join(", ")
            )
        }
        Ended::Unstrained => format!(
            "accuracy {asked} % not reached: nothing is strained at the end of the run; bodies do not touch, or facets are so long that \
             they miss the contact"
        ),
        Ended::NoEstimate => {
            format!("accuracy {asked} % not reached: there is no estimate where a cell is inverted")
        }
    };
    print(format!(
        "{why}: {best}\nerror against time {}, {}",
        out.join(TABLE).display(),
        out.join(PICTURE).display()
    ));
    let next = out.join(format!("level_{}", reached.levels.len()));
    if !matches!(reached.ended, Ended::Incomplete(_)) && next.exists() {
        print(format!(
            "{} and what follows it are of an earlier run",
            next.display()
        ));
    }
    let Some(Solved { history, .. }) = reached.solved else {
        return ExitCode::FAILURE;
    };
    let certificate = history.certificate();
    let broken = certificate.filter(|found| !found.holds(&Limits::default()));
    if let Some(certificate) = broken {
        print(format!(
            "the certificate of its steps does not hold: {certificate}"
        ));
    }
    let stages = Vec::new();
    match reached.ended {
        Ended::Reached => Recorded { history, stages }.report(),
        _ => ExitCode::FAILURE,
    }
}

const TABLE: &str = "error_against_time.csv";
const PICTURE: &str = "error_against_time.svg";

/// Writes the curve of the levels so far, and where the next one is expected.
fn write(out: &Path, levels: &[Level]) -> Result<(), String> {
    let mut table = String::from(
        "level,cells,unknowns,seconds,seconds_so_far,estimated_error,estimated_energy_error,raised,energy,contact_facets_touching,unresolved_contacts\n",
    );
    for level in levels {
        let facets = level.contact_facets_touching;
        let facets = facets.map_or(String::new(), |count| count.to_string());
        table += &format!(
            "{},{},{},{:.4},{:.4},{:e},{:e},{:e},{:e},{facets},{}\n",
            level.number,
            level.cells,
            level.unknowns,
            level.seconds,
            level.seconds_so_far,
            level.estimated_error,
            level.estimated_energy_error,
            level.raised,
            level.energy,
            level.unresolved_contacts
        );
    }
    let path = out.join(TABLE);
    std::fs::write(&path, table)
        .map_err(|why| format!("cannot write {}: {why}", path.display()))?;
    let point = |of: &Level| (of.seconds_so_far.log10(), of.estimated_error.log10());
    let points: Vec<(f64, f64)> = levels.iter().map(point).collect();
    let mut curves = vec![Curve {
        name: "levels".into(),
        points: points.clone(),
    }];
    if let [.., before, last] = points[..] {
        curves.push(Curve {
            name: "the next one, if it goes on like this".into(),
            points: vec![last, (2.0 * last.0 - before.0, 2.0 * last.1 - before.1)],
        });
    }
    let picture = Curves {
        title: "Estimated error against run time".into(),
        x_label: "log₁₀ of the seconds so far".into(),
        y_label: "log₁₀ of the error in the energy norm".into(),
        curves,
    };
    picture
        .save(out.join(PICTURE))
        .map_err(|why| why.to_string())
}
