//! Where the time goes on the disc-in-disc scene, at three sizes.
//!
//! ```text
//! cargo bench --bench disc_in_disc
//! cargo bench --bench disc_in_disc -- --increments 5 --solver newton 64 114
//! ```
//!
//! No files are written. Every size and solver runs in a process of its own, so that the peak of memory is its own, too.
//! Own code is all but the optimiser with its linear algebra.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::{cpu_seconds, exit, peak_memory};
use ipopt_contact::prelude::*;
use ipopt_contact::versions;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::{
    Failure,
    cli::{self, Solver},
};

/// Times the disc-in-disc scene
#[derive(Parser, Debug)]
struct Arguments {
    /// Segments around the hole, one run for each: 1 588, 4 880 and 20 053 triangles
    #[arg(default_values_t = [64, 114, 231])]
    segments: Vec<usize>,
    /// Load increments
    #[arg(long, default_value_t = 100)]
    increments: usize,
    /// Relative change of the displacement at which an increment has converged [default: the solver's own]
    #[arg(long)]
    tolerance: Option<f64>,
    /// How a load increment is solved; may be repeated
    #[arg(long, value_enum, default_values_t = [Solver::Ipopt, Solver::Newton])]
    solver: Vec<Solver>,
    /// Integrate exactly instead of at Gauss points
    #[arg(long)]
    exact: bool,
    /// Run one size with one solver in this process: their places in the lists
    #[arg(long, hide = true, num_args = 2)]
    only: Option<Vec<usize>>,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

const HEADER: &str = "\
solver    triangles free dofs   wall s    cpu s outer  inner factori- projection callbacks other optimizer  own  peak       energy  reaction
                                                iter.  iter.  sations          %         %     %         % code %   MB        UF·UL        UF";

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if !arguments.bench {
        arguments.segments = vec![16];
        arguments.increments = 2;
    }
    exit(match arguments.only.as_deref() {
        Some(&[size, solver]) => measure(
            &arguments,
            arguments.segments[size],
            arguments.solver[solver],
        ),
        _ => all(&arguments),
    })
}

/// Runs every size with every solver in a child.
fn all(arguments: &Arguments) -> Result<(), Failure> {
    println!(
        "{}\n{} increments\n\n{HEADER}",
        versions(),
        arguments.increments
    );
    for size in 0..arguments.segments.len() {
        for solver in 0..arguments.solver.len() {
            cli::again(&["--only", &size.to_string(), &solver.to_string()])?;
        }
    }
    Ok(())
}

fn measure(arguments: &Arguments, segments: usize, solver: Solver) -> Result<(), Failure> {
    let clock = Instant::now();
    let roles = Roles::default();
    let mut scene = disc_in_disc::scene(Fineness::scaled(segments), roles)?;
    if arguments.exact {
        scene.integration = Some(Integration::Exact);
    }
    let mut problem = scene.problem()?;
    let equilibrium = solver.with_tolerance(arguments.tolerance);
    let mut simulation = Simulation::solved_by(equilibrium, arguments.increments);
    let history = simulation.run(&mut problem)?;
    let wall = clock.elapsed().as_secs_f64();
    let cost = history.run.cost();
    let bodies = problem.scene().bodies().iter();
    let last = history.last();
    let by = last.and_then(|step| step.attempt.solver());
    let percent = |seconds: f64| 100.0 * seconds / wall;
    let own = wall - cost.optimizer;
    println!(
        "{:<9} {:>9} {:>9} {wall:>8.2} {:>8.2} {:>5} {:>6} {:>8} {:>10.1} {:>9.1} {:>5.1} {:>9.1} {:>6.1} {:>4} {:>12.6} {:>9.3}",
        by.unwrap_or("none"),
        bodies.map(|body| body.mesh().len()).sum::<usize>(),
        problem.dofs().free(),
        cpu_seconds().unwrap_or(f64::NAN),
        cost.outer_iterations,
        cost.inner_iterations,
        cost.factorizations,
        percent(cost.projection),
        percent(cost.callbacks),
        percent(own - cost.projection - cost.callbacks),
        percent(cost.optimizer),
        percent(own),
        peak_memory().map_or("-".into(), |bytes| format!("{:.0}", bytes as f64 / 1e6)),
        last.map_or(f64::NAN, |step| step.energy),
        last.map_or(f64::NAN, |step| step.reaction(roles.ring())[1]),
    );
    if !history.is_complete() {
        println!("  ended early: {}", history.run.ending);
    }
    Ok(())
}
