//! `ipopt-contact run SCENE.toml`: a recorded run of a scene file.

use std::path::Path;
use std::process::{ExitCode, Termination};

use ipopt_contact::contact_core::equilibrium::{Kept, kept};
use ipopt_contact::contact_core::{Equilibrium, State};
use ipopt_contact::contact_fem::element::{Element, P1, P2};
use ipopt_contact::contact_fem::model::{Finding, Problem, Severity};
use ipopt_contact::contact_fem::nalgebra::SVector;
use ipopt_contact::contact_fem::output::compare::{Nodes, fields_at};
use ipopt_contact::contact_fem::output::record::print;
use ipopt_contact::scene_file::{SceneFile, Solver};

use crate::{Words, accuracy};

/// Solves the scene in a file and records the run.
pub fn command(words: &[String]) -> Result<ExitCode, String> {
    let known = [
        "out",
        "solver",
        "increments",
        "start",
        "accuracy",
        "seconds",
    ];
    let words = Words::parse(
        "run",
        words,
        &known,
        &["literal", "resume", "check", "path", "verbose"],
    )?;
    let path = words.only("one scene file")?;
    let given = known
        .iter()
        .chain(&["resume"])
        .filter(|name| **name != "solver");
    match words.option("check") {
        None => drop(words.needed("out")?),
        Some(_) => {
            if let Some(name) = given.clone().find(|name| words.option(name).is_some()) {
                return Err(format!(
                    "--{name} has no effect with --check, which writes nothing: leave one of them out"
                ));
            }
        }
    }
    let file = SceneFile::read(path).map_err(|why| match why {
        why @ ipopt_contact::scene_file::Error::Read { .. } => why.to_string(),
        why => format!("{path}: {why}"),
    })?;
    let file = match (words.option("literal"), words.option("solver")) {
        (Some(_), Some(solver)) => {
            return Err(format!(
                "--literal and --solver {solver} name two solvers: leave one out"
            ));
        }
        (Some(_), None) => file.literal().map_err(|why| format!("{path}: {why}"))?,
        (None, _) => file,
    };
    match file.dimension().map_err(|why| format!("{path}: {why}"))? {
        2 => run::<2>(path, &file, &words),
        _ => run::<3>(path, &file, &words),
    }
}

fn run<const D: usize>(path: &str, file: &SceneFile, words: &Words) -> Result<ExitCode, String>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let in_file = |why: &dyn std::fmt::Display| format!("{path}: {why}");
    let solver = words.option("solver").map(solver).transpose()?;
    if words.option("check").is_some() {
        return check::<D>(path, file, solver);
    }
    let out = words.needed("out")?;
    let simulation = || -> Result<_, String> {
        let simulation = match (words.option("resume"), solver) {
            (Some(_), solver) => {
                let given = [words.option("increments"), words.option("start")];
                let answers = Path::new(out).join("run.resume");
                file.resumable(solver, answers, &format!("{given:?}"))
            }
            (None, Some(solver)) => file.simulation_by(solver),
            (None, None) => file.simulation(),
        };
        let mut simulation = simulation.map_err(|why| in_file(&why))?;
        if let Some(text) = words.option("increments") {
            let number = text.parse().ok().filter(|number| *number > 0);
            let needed = || format!("--increments needs a whole number from 1, not `{text}`");
            if !simulation.load_steps.phases.is_empty() {
                let what = "its phases have increments of their own: leave --increments out";
                return Err(in_file(&what));
            }
            simulation.load_steps.increments = number.ok_or_else(needed)?;
        }
        Ok(simulation)
    };
    if let Some(accuracy) = accuracy::asked(words)? {
        if words.option("solver") == Some("literal") {
            return Err(
                "--solver literal does what a script does, on one mesh: leave it or --accuracy out"
                    .into(),
            );
        }
        if let Some(name) = ["resume", "start", "literal"]
            .iter()
            .find(|name| words.option(name).is_some())
        {
            return Err(format!(
                "--{name} is for one mesh, and --accuracy takes several: leave one of them out"
            ));
        }
        return accuracy::run::<D>(
            (path, file),
            (&accuracy, words.option("path").is_some()),
            Path::new(out),
            simulation,
        );
    }
    let mut simulation = simulation()?;
    let mut problem = file.problem::<D>().map_err(|why| in_file(&why))?;
    if let Some(folder) = words.option("start") {
        simulation.load_steps.guess = Some(guess(&problem, Path::new(folder))?);
    }
    // before a file is written
    let checked = file.check(&simulation, &mut problem);
    checked.map_err(|why| in_file(&why))?;
    let mut recording = file
        .record(&mut simulation, &problem, out)
        .map_err(|why| in_file(&why))?;
    recording.plan.verbose = words.option("verbose").is_some();
    if words.option("resume").is_some() {
        print(resumed(&Path::new(out).join("run.resume"))?);
    }
    let recorded = recording.run(&mut problem);
    let recorded = recorded.map_err(|why| in_file(&file.refused(why)))?;
    Ok(recorded.report())
}

/// Where a run that is to be resumed begins.
fn resumed(path: &Path) -> Result<String, String> {
    let kept = kept(path).map_err(|why| why.to_string())?;
    let file = path.display();
    Ok(match kept {
        Some(Kept { steps, until }) => format!(
            "resume: {steps} increments, up to time {until}, are taken from {file}; the run goes on from there"
        ),
        None => format!("resume: {file} has no increment yet; the run begins at time 0"),
    })
}

/// The exit code of a scene with warnings.
const WARNED: u8 = 1;
/// The exit code of a scene with errors, as of a file that cannot be read.
const REFUSED: u8 = 2;

/// Prints what the checks find, and solves nothing.
fn check<const D: usize>(
    path: &str,
    file: &SceneFile,
    solver: Option<Solver>,
) -> Result<ExitCode, String>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let in_file = |why: &dyn std::fmt::Display| format!("{path}: {why}");
    let simulation = match solver {
        Some(solver) => file.simulation_by(solver),
        None => file.simulation(),
    };
    let mut simulation = simulation.map_err(|why| in_file(&why))?;
    let scene = file.scene::<D>().map_err(|why| in_file(&why))?;
    let refused = file.errors(&scene);
    let findings: Vec<Finding> = match refused.is_empty() {
        false => {
            let findings = scene.preflight().into_iter();
            let others = findings.filter(|finding| finding.severity != Severity::Error);
            others.map(|finding| file.told(&finding)).collect()
        }
        true => {
            let mut problem = file.problem().map_err(|why| in_file(&why))?;
            let checked = file.check(&simulation, &mut problem);
            checked.map_err(|why| in_file(&why))?;
            let increments = simulation.load_steps.all_increments();
            let choice = simulation.solver.choice(&problem);
            file.record(&mut simulation, &problem, ".")
                .map_err(|why| in_file(&why))?;
            print(format!("plan: {}", problem.plan()));
            print(format!("solver: {choice}"));
            problem.findings_in(increments)
        }
    };
    refused
        .iter()
        .for_each(|why| print(format!("error: {path}: {why}")));
    findings.iter().for_each(print);
    let count = |severity| {
        findings
            .iter()
            .filter(|finding| finding.severity == severity)
            .count()
    };
    let (errors, warnings) = (refused.len(), count(Severity::Warning));
    let notes = count(Severity::Note);
    print(format!(
        "{path}: {}, {}, {}",
        counted(errors, "error"),
        counted(warnings, "warning"),
        counted(notes, "note")
    ));
    Ok(match (errors, warnings) {
        (0, 0) => ExitCode::SUCCESS,
        (0, _) => ExitCode::from(WARNED),
        _ => ExitCode::from(REFUSED),
    })
}

/// "1 error", "2 errors".
fn counted(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

fn solver(name: &str) -> Result<Solver, String> {
    match name {
        "automatic" => Ok(Solver::Automatic),
        "ipopt" => Ok(Solver::Ipopt),
        "newton" => Ok(Solver::Newton),
        "condensed" => Ok(Solver::Condensed),
        "literal" => Ok(Solver::Literal),
        _ => Err(format!(
            "there is no solver {name}: there are automatic, ipopt, newton, condensed and literal"
        )),
    }
}

/// The displacements of a result at the nodes of the problem.
fn guess<const D: usize>(problem: &Problem<D>, folder: &Path) -> Result<State, String> {
    let names = problem.scene().names().iter().enumerate();
    let of_body = |(body, name): (usize, &String)| Nodes {
        body: name.clone(),
        places: problem.reference()[problem.nodes(body)]
            .iter()
            .map(|place| std::array::from_fn(|i| if i < D { place[i] } else { 0.0 }))
            .collect(),
    };
    let nodes: Vec<Nodes> = names.map(of_body).collect();
    let fields = fields_at(folder, D, &nodes).map_err(|why| {
        let folder = folder.display();
        format!("{why} (A is the scene, B the result in {folder})")
    })?;
    let all = fields.iter().flat_map(|field| &field.displacements);
    let displacements: Vec<SVector<f64, D>> = all.map(|u| SVector::from_fn(|i, _| u[i])).collect();
    let u = problem.unknowns(&displacements);
    Ok(State {
        u: u.map_err(|why| why.to_string())?,
        ..State::default()
    })
}
