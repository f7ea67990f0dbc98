//! Where the time goes on the disc-in-disc scene, at three sizes.
//!
//! ```text
//! cargo bench --bench disc_in_disc
//! cargo bench --bench disc_in_disc -- --increments 5 64 114
//! ```
//!
//! No files are written. Every size runs in a process of its own, so that the peak of memory is its
//! own, too. Own code is all but Ipopt with its linear solver.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::{exit, peak_memory};
use ipopt_contact::prelude::*;
use ipopt_contact::versions;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::{Failure, cli};

/// Times the disc-in-disc scene
#[derive(Parser, Debug)]
struct Arguments {
    /// Segments around the hole, one run for each: 1 588, 4 880 and 20 053 triangles
    #[arg(default_values_t = [64, 114, 231])]
    segments: Vec<usize>,
    /// Load increments
    #[arg(long, default_value_t = 100)]
    increments: usize,
    /// Relative change of the displacement at which a fixed point has converged
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
    /// Integrate exactly instead of at Gauss points
    #[arg(long)]
    exact: bool,
    /// Run one size in this process
    #[arg(long, hide = true)]
    only: Option<usize>,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

const HEADER: &str = "\
triangles free dofs   wall s  fixed  Ipopt factori- projection callbacks other optimizer  own  peak     energy  reaction
                              point  iter.  sations          %         %     %         % code %   MB      UF·UL        UF";

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if !arguments.bench {
        arguments.segments = vec![16];
        arguments.increments = 2;
    }
    exit(match arguments.only {
        Some(segments) => measure(&arguments, segments),
        None => all(&arguments),
    })
}

/// Runs every size in a child.
fn all(arguments: &Arguments) -> Result<(), Failure> {
    let (increments, tolerance) = (arguments.increments, arguments.tolerance);
    println!(
        "{}\n{increments} increments at tolerance {tolerance:e}\n\n{HEADER}",
        versions()
    );
    for segments in &arguments.segments {
        cli::again(&["--only", &segments.to_string()])?;
    }
    Ok(())
}

fn measure(arguments: &Arguments, segments: usize) -> Result<(), Failure> {
    let clock = Instant::now();
    let roles = Roles::default();
    let mut scene = disc_in_disc::scene(Fineness::scaled(segments), roles)?;
    if arguments.exact {
        scene.integration = Some(Integration::Exact);
    }
    let mut problem = scene.problem()?;
    let mut simulation = Simulation::with_increments(arguments.increments);
    simulation.solver.fixed_point.tolerance = arguments.tolerance;
    let history = simulation.run(&mut problem)?;
    let wall = clock.elapsed().as_secs_f64();
    let cost = history.run.cost();
    let bodies = problem.scene().bodies().iter();
    let last = history.last();
    let percent = |seconds: f64| 100.0 * seconds / wall;
    let own = wall - cost.optimizer;
    println!(
        "{:>9} {:>9} {wall:>8.2} {:>6} {:>6} {:>8} {:>10.1} {:>9.1} {:>5.1} {:>9.1} {:>6.1} {:>4} {:>10.4} {:>9.3}",
        bodies.map(|body| body.mesh().len()).sum::<usize>(),
        problem.dofs().free(),
        cost.fixed_point,
        cost.iterations,
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
