//! Time and memory against the number of unknowns, by the default solver, up to a limit of time or memory.
//!
//! ```text
//! cargo bench --bench growth --features metis
//! cargo bench --bench growth --features metis -- --seconds 30 discs
//! ```
//!
//! Every size runs in a process of its own. The exponent of a column is the slope of its logarithm over that of the
//! unknowns, by least squares.

use std::process::{Command, ExitCode};
use std::time::Instant;

use clap::{Parser, ValueEnum};
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::record::{cpu_seconds, exit, peak_memory};
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};

/// Measures how time and memory grow
#[derive(Parser, Debug)]
struct Arguments {
    /// The families
    #[arg(value_enum)]
    families: Vec<Family>,
    /// No larger mesh after one that took so many seconds
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// No larger mesh after one that took so many megabytes
    #[arg(long, default_value_t = 6000.0)]
    megabytes: f64,
    /// Run one size in this process
    #[arg(long, hide = true)]
    only: Option<usize>,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

/// Scenes that differ in their meshes alone.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Family {
    /// The disc-in-disc in 5 increments, by segments around the hole
    Discs,
    /// The three beams of linear tetrahedra at small strains, by cells across
    BeamsP1,
    /// The same of quadratic tetrahedra
    BeamsP2,
    /// The same, neo-Hookean, to a tenth of the load
    NeoHookeanP2,
}

/// The columns of a run.
const COLUMNS: [&str; 9] = [
    "unknowns",
    "rows",
    "cpu s",
    "set-up s",
    "projection s",
    "energies s",
    "solver s",
    "factorisations",
    "MB",
];
/// Those that have an exponent.
const GROWING: [usize; 2] = [2, 8];

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if arguments.families.is_empty() {
        arguments.families = Family::value_variants().to_vec();
    }
    if !arguments.bench {
        (arguments.families, arguments.seconds) = (vec![Family::BeamsP1], 0.0);
    }
    exit(match arguments.only {
        Some(size) => arguments.families[0].measure(size),
        None => arguments
            .families
            .iter()
            .try_for_each(|family| family.grow(&arguments)),
    })
}

impl Family {
    fn sizes(self) -> &'static [usize] {
        match self {
            Family::Discs => &[32, 45, 64, 91, 128, 181, 256, 362, 512, 724],
            Family::BeamsP1 => &[2, 3, 4, 6, 8, 10, 12, 14, 17, 20, 24, 28],
            Family::BeamsP2 | Family::NeoHookeanP2 => &[1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16],
        }
    }

    /// Runs ever larger sizes in children.
    fn grow(self, arguments: &Arguments) -> Result<(), Failure> {
        let name = self.to_possible_value();
        let name = name.as_ref().map_or("", |name| name.get_name());
        println!("\n{name}");
        let header: Vec<String> = COLUMNS.iter().map(|title| format!("{title:>14}")).collect();
        println!("{:>5} {}", "size", header.concat());
        let mut runs: Vec<Vec<f64>> = Vec::new();
        for size in self.sizes() {
            let mut child = Command::new(std::env::current_exe()?);
            let output = child
                .args([name, "--only", &size.to_string(), "--bench"])
                .output()?;
            let text = String::from_utf8_lossy(&output.stdout);
            let values: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
            let values = match values {
                Ok(values) if output.status.success() && values.len() == COLUMNS.len() => values,
                _ => {
                    let why = String::from_utf8_lossy(&output.stderr);
                    println!("{size:>5}  ended without a result: {}", why.trim());
                    break;
                }
            };
            let cells: Vec<String> = values.iter().map(|v| format!("{v:>14.2}")).collect();
            println!("{size:>5} {}", cells.concat());
            let is_last = values[2] > arguments.seconds || values[8] > arguments.megabytes;
            runs.push(values);
            if is_last {
                break;
            }
        }
        for column in GROWING {
            let points = runs.iter().map(|run| (run[0].ln(), run[column].ln()));
            let points: Vec<_> = points.collect();
            let last = &points[points.len().saturating_sub(2)..];
            println!(
                "      {} grows as unknowns^{:.2} over all sizes, ^{:.2} between the last two",
                COLUMNS[column],
                slope(&points),
                slope(last)
            );
        }
        Ok(())
    }

    /// Runs one size and prints its columns.
    fn measure(self, size: usize) -> Result<(), Failure> {
        let beams = |order, law| {
            let beams = Beams {
                along: 4 * size,
                ..Beams::new(size, order, law)
            };
            beams.scene()
        };
        match self {
            Family::Discs => {
                let fineness = Fineness::scaled(size);
                solve(|| disc_in_disc::scene(fineness, Roles::default()), 5, 5)
            }
            Family::BeamsP1 => solve(|| beams(Order::Linear, Law::SmallStrain), 1, 1),
            Family::BeamsP2 => solve(|| beams(Order::Quadratic, Law::SmallStrain), 1, 1),
            Family::NeoHookeanP2 => solve(|| beams(Order::Quadratic, Law::NeoHookean), 10, 1),
        }
    }
}

/// Solves the first `steps` of so many increments and prints the columns.
fn solve<const D: usize>(
    scene: impl FnOnce() -> Result<Scene<D>, ipopt_contact::contact_fem::Error>,
    increments: usize,
    steps: usize,
) -> Result<(), Failure> {
    let clock = Instant::now();
    let mut problem = scene()?.problem()?;
    let set_up = clock.elapsed().as_secs_f64();
    let mut done = 0;
    let mut simulation = Simulation::with_increments(increments);
    let history = simulation.run_observed(&mut problem, |_| {
        done += 1;
        match done < steps {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    })?;
    let last = history.last().ok_or("no step converged")?;
    if done < steps {
        return Err(history.run.ending.to_string().into());
    }
    let cost = history.run.cost();
    let megabytes = peak_memory().map_or(f64::NAN, |bytes| bytes as f64 / 1e6);
    println!(
        "{} {} {} {set_up} {} {} {} {} {megabytes}",
        problem.dofs().free(),
        last.rows,
        cpu_seconds().unwrap_or(f64::NAN),
        cost.projection,
        cost.callbacks,
        cost.optimizer,
        cost.factorizations,
    );
    Ok(())
}

/// The slope of the line through points by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let over: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let under: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    over / under
}
