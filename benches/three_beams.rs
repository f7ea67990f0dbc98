//! The three beams of quadratic tetrahedra in contact, and beside them the same beams apart: the
//! floor, which no contact algorithm can go below.
//!
//! ```text
//! cargo bench --bench three_beams
//! cargo bench --bench three_beams -- --across 4 --along 16
//! ```
//!
//! No files are written. Every case runs in a process of its own, so that the peak of memory is its
//! own, too.

use std::error::Error;
use std::ops::ControlFlow;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use clap::Parser;
use contact_fem::element::Order;
use contact_fem::output::record::peak_memory;
use ipopt_contact::prelude::*;
use ipopt_contact::{contact_fem, versions};
use ipopt_contact_scenes::beams::{self, Beams, Law};

/// Times the three beams
#[derive(Parser, Debug)]
struct Arguments {
    /// Cells across a beam's side
    #[arg(long, default_value_t = 6)]
    across: usize,
    /// Cells along a beam
    #[arg(long, default_value_t = 20)]
    along: usize,
    /// Integrate exactly instead of at Gauss points
    #[arg(long)]
    exact: bool,
    /// Run one case in this process
    #[arg(long, hide = true)]
    case: Option<usize>,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

/// Name, law, whether the beams touch.
const CASES: [(&str, Law, bool); 4] = [
    ("small strain, apart", Law::SmallStrain, false),
    ("small strain, in contact", Law::SmallStrain, true),
    ("neo-Hookean, apart", Law::NeoHookean, false),
    ("neo-Hookean, in contact", Law::NeoHookean, true),
];

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if !(arguments.bench || arguments.case.is_some()) {
        (arguments.across, arguments.along) = (1, 3);
    }
    let result = match arguments.case {
        Some(case) => measure(&arguments, case),
        None => all(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs every case in a child.
fn all(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    println!("{}\n", versions());
    println!(
        "case                      free dofs  rows   wall s  set-up s  projection s  callbacks s  \
         optimizer s  fixed  Ipopt  factori-  peak    tip\n{:>105}{:>7}{:>10}{:>6}{:>7}",
        "point", "iter.", "sations", "MB", "UL"
    );
    for (case, (name, ..)) in CASES.iter().enumerate() {
        let status = Command::new(std::env::current_exe()?)
            .args(["--across", &arguments.across.to_string()])
            .args(["--along", &arguments.along.to_string()])
            .args(["--case", &case.to_string()])
            .args(arguments.exact.then_some("--exact"))
            .stdout(Stdio::inherit())
            .status()?;
        if !status.success() {
            return Err(format!("the case {name} failed").into());
        }
    }
    Ok(())
}

/// One load increment: all of the load at small strain, a tenth for the neo-Hookean beams.
fn measure(arguments: &Arguments, case: usize) -> Result<(), Box<dyn Error>> {
    let (name, law, contact) = CASES[case];
    let clock = Instant::now();
    let beams = Beams {
        along: arguments.along,
        contact,
        ..Beams::new(arguments.across, Order::Quadratic, law)
    };
    let mut scene = beams.scene()?;
    if arguments.exact {
        scene.integration = Some(Integration::Exact);
    }
    let mut problem = scene.problem()?;
    let set_up = clock.elapsed().as_secs_f64();
    let increments = if law == Law::NeoHookean { 10 } else { 1 };
    let mut tip = f64::NAN;
    let mut simulation = Simulation::with_increments(increments);
    let history = simulation.run_observed(&mut problem, |step| {
        let u = step.problem.displacements(&step.solution.state.u);
        tip = beams::tip(step.problem, &u, 0)[2];
        ControlFlow::Break(())
    })?;
    let cost = history.run.cost();
    let peak = peak_memory().map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6));
    println!(
        "{name:<25} {:>9} {:>5} {:>8.2} {set_up:>9.2} {:>13.2} {:>12.2} {:>12.2} {:>6} {:>6} {:>9} {peak:>5} {tip:>6.3}",
        problem.dofs().free(),
        history.steps.last().map_or(0, |step| step.rows),
        clock.elapsed().as_secs_f64(),
        cost.projection,
        cost.callbacks,
        cost.optimizer,
        cost.fixed_point,
        cost.iterations,
        cost.factorizations,
    );
    Ok(())
}
