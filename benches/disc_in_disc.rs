//! Where the time goes on the disc-in-disc scene, at three sizes.
//!
//! ```text
//! cargo bench --bench disc_in_disc
//! cargo bench --bench disc_in_disc -- --increments 5 64 114
//! ```
//!
//! No files are written. Every size runs in a process of its own, so that the peak of memory is its
//! own, too. Own code is all but Ipopt with its linear solver.

use std::error::Error;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use clap::Parser;
use contact_fem::output::record::peak_memory;
use ipopt_contact::prelude::*;
use ipopt_contact::{contact_fem, versions};
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use serde::{Deserialize, Serialize};

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
    /// Run one size in this process and print its line as JSON
    #[arg(long, hide = true)]
    child: bool,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

/// What one size took.
#[derive(Debug, Serialize, Deserialize)]
struct Line {
    triangles: usize,
    free_dofs: usize,
    status: String,
    wall: f64,
    fixed_point: usize,
    ipopt: usize,
    factorisations: usize,
    projection: f64,
    callbacks: f64,
    optimizer: f64,
    peak_memory: Option<u64>,
    energy: Option<f64>,
    reaction: Option<f64>,
}

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if !(arguments.bench || arguments.child) {
        arguments.segments = vec![16];
        arguments.increments = 2;
    }
    let result = match arguments.child {
        true => child(&arguments),
        false => parent(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs every size in a child and prints the table.
fn parent(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let Arguments {
        increments,
        tolerance,
        ..
    } = arguments;
    println!("{}", versions());
    println!("{increments} increments at tolerance {tolerance:e}\n");
    println!("{}", Line::HEADER);
    for segments in &arguments.segments {
        let output = Command::new(std::env::current_exe()?)
            .arg("--child")
            .args(["--increments", &increments.to_string()])
            .args(["--tolerance", &tolerance.to_string()])
            .args(arguments.exact.then_some("--exact"))
            .arg(segments.to_string())
            .stderr(Stdio::inherit())
            .output()?;
        if !output.status.success() {
            return Err(format!("the run with {segments} segments failed").into());
        }
        let line: Line = serde_json::from_slice(&output.stdout)?;
        println!("{}", line.text());
        if line.status != "Complete" {
            println!("  ended early: {}", line.status);
        }
    }
    Ok(())
}

fn child(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    for &segments in &arguments.segments {
        println!("{}", serde_json::to_string(&measure(arguments, segments)?)?);
    }
    Ok(())
}

fn measure(arguments: &Arguments, segments: usize) -> Result<Line, Box<dyn Error>> {
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
    let cost = history.run.cost();
    let bodies = problem.scene().bodies().iter();
    let last = history.steps.last();
    Ok(Line {
        triangles: bodies.map(|body| body.mesh().len()).sum(),
        free_dofs: problem.dofs().free(),
        status: format!("{:?}", history.run.ending),
        wall: clock.elapsed().as_secs_f64(),
        fixed_point: cost.fixed_point,
        ipopt: cost.iterations,
        factorisations: cost.factorizations,
        projection: cost.projection,
        callbacks: cost.callbacks,
        optimizer: cost.optimizer,
        peak_memory: peak_memory(),
        energy: last.map(|step| step.energy),
        reaction: last.map(|step| step.reaction(roles.ring())[1]),
    })
}

impl Line {
    const HEADER: &str = "\
triangles free dofs   wall s  fixed  Ipopt factori- projection callbacks other optimizer  own  peak     energy  reaction
                              point  iter.  sations          %         %     %         % code %   MB      UF·UL        UF";

    fn text(&self) -> String {
        let percent = |seconds: f64| 100.0 * seconds / self.wall;
        let own = self.wall - self.optimizer;
        let other = own - self.projection - self.callbacks;
        let peak = self
            .peak_memory
            .map_or("-".into(), |bytes| format!("{:.0}", bytes as f64 / 1e6));
        format!(
            "{:>9} {:>9} {:>8.2} {:>6} {:>6} {:>8} {:>10.1} {:>9.1} {:>5.1} {:>9.1} {:>6.1} {peak:>4} {:>10.4} {:>9.3}",
            self.triangles,
            self.free_dofs,
            self.wall,
            self.fixed_point,
            self.ipopt,
            self.factorisations,
            percent(self.projection),
            percent(self.callbacks),
            percent(other),
            percent(self.optimizer),
            percent(own),
            self.energy.unwrap_or(f64::NAN),
            self.reaction.unwrap_or(f64::NAN),
        )
    }
}
