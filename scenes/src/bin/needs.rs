//! Runs the scenes of [`needs`], once more with the work that is left out, and their floors in turn, and compares their cost.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use contact_core::{ContactProblem, Equilibrium, LoadStepped};
use contact_fem::model::Problem;
use contact_fem::output::record::exit;
use contact_fem::simulation::{DefaultSolver, History};
use contact_fem::{Scene, Simulation};
use ipopt_contact_scenes::needs::floor::{self, Floor};
use ipopt_contact_scenes::needs::kept::{self, Keep};
use ipopt_contact_scenes::needs::{self, Build, Case, Way};
use ipopt_contact_scenes::{Failure, files};
use nix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// What runs cost beside the cheapest correct ways to their results
#[derive(Parser, Debug)]
struct Arguments {
    /// The folder for the results
    #[arg(long, default_value = "out/needs")]
    out: PathBuf,
    /// Only the cases with these names, separated by commas
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Runs of each scene, of which the medians count
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// Divides the cells in each direction
    #[arg(long, default_value_t = 1)]
    coarseness: usize,
    /// What the other run of each scene keeps: starts, rows, groups, blocks, factors, or all
    #[arg(long, value_delimiter = ',', default_value = "all")]
    keep: Vec<String>,
    /// Only one run by the library, for profiles
    #[arg(long)]
    no_floor: bool,
}

/// A case as it was measured.
#[derive(Serialize)]
struct Entry {
    name: String,
    what: String,
    unknowns: usize,
    rows: usize,
    seconds: f64,
    floor_seconds: f64,
    ratio: f64,
    must: f64,
    factorisations: usize,
    floor_factorisations: usize,
    solves: usize,
    projections: usize,
    energy: f64,
    floor_energy: f64,
    /// The same run with the work that is left out: its seconds, their ratio to `seconds`, its energy, and how far energies and
    /// reactions are apart, relative to it.
    kept_seconds: f64,
    kept_ratio: f64,
    kept_energy: f64,
    kept_energy_apart: f64,
    kept_reactions_apart: f64,
}

const HEADER: &str = "\
case   unknowns  rows  seconds    floor  ratio  must     kept  ratio  factor-  floor's  problems  projec-  energy              floor's             kept: energy, reactions
                                                      seconds        isations                     tions                                          apart";

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    println!("{HEADER}");
    let mut entries = Vec::new();
    let cases = needs::all(arguments.coarseness);
    let wanted = |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|n| n == name);
    for case in cases.iter().filter(|case| wanted(case.name)) {
        entries.extend(match &case.scene {
            Build::Plane(scene) => measure(case, scene, arguments)?,
            Build::Space(scene) => measure(case, scene, arguments)?,
        });
    }
    files::make_folder(&arguments.out)?;
    let text = serde_json::to_string_pretty(&entries)?;
    files::write(arguments.out.join("needs.json"), text)
}

fn measure<const D: usize>(
    case: &Case,
    scene: &dyn Fn() -> Result<Scene<D>, contact_fem::Error>,
    arguments: &Arguments,
) -> Result<Vec<Entry>, Failure> {
    let keep = Keep::named(&arguments.keep)?;
    let (mut seconds, mut floors, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    let (mut last, mut lowest, mut whole) = (None, None, None);
    let mut again = None;
    for _ in 0..arguments.runs.max(1) {
        let mut problem = scene()?.problem()?;
        let clock = processor()?;
        let history = Simulation::with_increments(case.increments).run(&mut problem)?;
        seconds.push(processor()? - clock);
        if !history.is_complete() {
            return Err(format!("{}: {}", case.name, history.run.ending).into());
        }
        if again.is_none() && ["1a", "2a", "9ll", "3m"].contains(&case.name) {
            again = Some(solved_again(&problem, &history)?);
        }
        last = Some((history, problem));
        if !arguments.no_floor {
            let mut problem = scene()?.problem()?;
            let (floor, lasted) = floor(case, &mut problem, arguments.coarseness)?;
            floors.push(lasted);
            lowest = Some(floor);
            let mut scene = scene()?;
            keep.prepare(&mut scene);
            let mut problem = scene.problem()?;
            let clock = processor()?;
            let history = keep.simulation(case.increments).run(&mut problem)?;
            kept.push(processor()? - clock);
            if !history.is_complete() {
                return Err(format!("{}, kept: {}", case.name, history.run.ending).into());
            }
            whole = history.steps.into_iter().last();
        }
    }
    let (history, problem) = last.ok_or("no run")?;
    let record = history.last().ok_or("no step")?;
    let cost = history.run.cost();
    let (seconds, floor_seconds, kept_seconds) = (median(seconds), median(floors), median(kept));
    let apart = whole
        .as_ref()
        .map(|whole| kept::apart(&problem, [record, whole]));
    let apart = apart.unwrap_or((f64::NAN, f64::NAN));
    let entry = Entry {
        name: case.name.into(),
        what: case.what.into(),
        unknowns: problem.energy().dofs(),
        rows: record.rows,
        seconds,
        floor_seconds,
        ratio: seconds / floor_seconds,
        must: case.must,
        factorisations: cost.factorizations,
        floor_factorisations: lowest.as_ref().map_or(0, |floor| floor.factorizations),
        solves: cost.solves,
        projections: problem.searches_built(),
        energy: record.energy,
        floor_energy: lowest.as_ref().map_or(f64::NAN, |floor| floor.energy),
        kept_seconds,
        kept_ratio: kept_seconds / seconds,
        kept_energy: whole.as_ref().map_or(f64::NAN, |whole| whole.energy),
        kept_energy_apart: apart.0,
        kept_reactions_apart: apart.1,
    };
    let mut entries = vec![entry];
    if let Some(((seconds, factorisations, solves, energy), start)) = again {
        let (name, what) = (
            format!("{} again", case.name),
            "solved again from its solution",
        );
        entries.push(Entry {
            name,
            what: what.into(),
            seconds,
            floor_seconds: start,
            ratio: seconds / start,
            must: f64::NAN,
            factorisations,
            floor_factorisations: 0,
            solves,
            energy,
            kept_seconds: f64::NAN,
            kept_ratio: f64::NAN,
            kept_energy: f64::NAN,
            kept_energy_apart: f64::NAN,
            kept_reactions_apart: f64::NAN,
            ..entries_like(&entries[0])
        });
    }
    entries.iter().for_each(print);
    Ok(entries)
}

fn entries_like(entry: &Entry) -> Entry {
    Entry {
        name: entry.name.clone(),
        what: entry.what.clone(),
        ..*entry
    }
}

fn print(entry: &Entry) {
    println!(
        "{:<9} {:>6} {:>5} {:>8.4} {:>8.4} {:>6.2} {:>5.1} {:>8.4} {:>6.2} {:>8} {:>8} {:>9} {:>8}  {:<18.12e}  {:<18.12e}  {:.1e}, {:.1e}",
        entry.name,
        entry.unknowns,
        entry.rows,
        entry.seconds,
        entry.floor_seconds,
        entry.ratio,
        entry.must,
        entry.kept_seconds,
        entry.kept_ratio,
        entry.factorisations,
        entry.floor_factorisations,
        entry.solves,
        entry.projections,
        entry.energy,
        entry.floor_energy,
        entry.kept_energy_apart,
        entry.kept_reactions_apart,
    );
}

/// The floor of a case, and its seconds.
fn floor<const D: usize>(
    case: &Case,
    problem: &mut Problem<D>,
    coarseness: usize,
) -> Result<(Floor, f64), Failure> {
    let mut alone = needs::blocks_alone(0..2, coarseness)?.problem()?;
    let clock = processor()?;
    let floor = match case.way {
        Way::Linear => floor::linear(problem, case.increments)?,
        Way::Newton => floor::newton(problem, case.increments)?,
        Way::Pair => {
            let pair = Simulation::with_increments(case.increments).run(&mut alone)?;
            let last = pair.last().ok_or("the pair alone has not converged")?;
            let mut floor = Floor {
                energy: last.energy,
                u: pair.run.state.u.clone(),
                gaps: contact_core::LinearGaps::new(true),
                lambda: Vec::new(),
                factorizations: pair.run.cost().factorizations,
            };
            problem.set_load(1.0)?;
            for energy in &problem.body_energies()[2..] {
                let mut newton = floor::Newton::default();
                newton.converge(energy)?;
                floor.energy += energy.value(&newton.u);
                floor.u.extend(newton.u);
            }
            floor
        }
    };
    Ok((floor, processor()? - clock))
}

/// Seconds, factorisations, problems and energy of another solve from the solution, by a new solver, and seconds of one
/// evaluation there of energy, forces and rows.
type Again = ((f64, usize, usize, f64), f64);

fn solved_again<const D: usize>(
    problem: &Problem<D>,
    history: &History<D>,
) -> Result<Again, Failure> {
    let clock = processor()?;
    let solution = DefaultSolver::default().solve_from(problem, history.run.state.clone())?;
    let seconds = processor()? - clock;
    let cost = solution.cost();
    let u = &history.run.state.u;
    let clock = processor()?;
    problem.energy().value(u);
    problem.energy().gradient(u, &mut vec![0.0; u.len()]);
    problem.rows(u, contact_core::gaps::Sampling::Nodes)?;
    let start = processor()? - clock;
    let counts = (seconds, cost.factorizations, cost.solves, solution.energy);
    Ok((counts, start))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.get(middle) {
        Some(upper) if values.len() % 2 == 0 => 0.5 * (upper + values[middle - 1]),
        Some(middle) => *middle,
        None => f64::NAN,
    }
}

/// Seconds of the processor that this thread has had.
fn processor() -> Result<f64, Failure> {
    let time = clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)?;
    Ok(time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64)
}
