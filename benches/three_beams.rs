//! The three beams of quadratic tetrahedra in contact, and beside them the same beams apart: the
//! floor, which no contact algorithm can go below.
//!
//! ```text
//! cargo bench --bench three_beams
//! cargo bench --bench three_beams -- --across 4 --along 16
//! ```
//!
//! No files are written. Every case runs in a process of its own, so that the peak of memory is its own, too.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::record::{cpu_seconds, exit, peak_memory};
use ipopt_contact::prelude::*;
use ipopt_contact::versions;
use ipopt_contact_scenes::beams::{self, Beams, Law};
use ipopt_contact_scenes::{
    Failure,
    cli::{self, Solver},
};

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
    /// How a load increment is solved; may be repeated
    #[arg(long, value_enum, default_values_t = [Solver::Ipopt, Solver::Automatic])]
    solver: Vec<Solver>,
    /// Run one case with one solver in this process: their places in the lists
    #[arg(long, hide = true, num_args = 2)]
    only: Option<Vec<usize>>,
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

const HEADER: &str = "\
case                      solver    free dofs  rows   wall s    cpu s  set-up s  projection s  callbacks s  optimizer s  outer  inner  factori-  peak    tip
                                                                                                                         iter.  iter.   sations    MB     UL";

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if !arguments.bench {
        (arguments.across, arguments.along) = (1, 3);
    }
    exit(match arguments.only.as_deref() {
        Some(&[case, solver]) => measure(&arguments, case, arguments.solver[solver]),
        _ => all(&arguments),
    })
}

/// Runs every case with every solver in a child.
fn all(arguments: &Arguments) -> Result<(), Failure> {
    println!("{}\n\n{HEADER}", versions());
    for case in 0..CASES.len() {
        for solver in 0..arguments.solver.len() {
            cli::again(&["--only", &case.to_string(), &solver.to_string()])?;
        }
    }
    Ok(())
}

/// One load increment: all of the load at small strain, a tenth for the neo-Hookean beams.
fn measure(arguments: &Arguments, case: usize, solver: Solver) -> Result<(), Failure> {
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
    let mut simulation = Simulation::solved_by(solver.with_tolerance(None), increments);
    let history = simulation.run_observed(&mut problem, |step| {
        let u = step.problem.displacements(&step.solution.state.u);
        tip = beams::tip(step.problem, &u, 0)[2];
        ControlFlow::Break(())
    })?;
    let cost = history.run.cost();
    let by = history.last().and_then(|step| step.attempt.solver());
    let peak = peak_memory().map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6));
    println!(
        "{name:<25} {:<9} {:>9} {:>5} {:>8.2} {:>8.2} {set_up:>9.2} {:>13.2} {:>12.2} {:>12.2} {:>6} {:>6} {:>9} {peak:>5} {tip:>6.3}",
        by.unwrap_or("none"),
        problem.dofs().free(),
        history.steps.last().map_or(0, |step| step.rows),
        clock.elapsed().as_secs_f64(),
        cpu_seconds().unwrap_or(f64::NAN),
        cost.projection,
        cost.callbacks,
        cost.optimizer,
        cost.outer_iterations,
        cost.inner_iterations,
        cost.factorizations,
    );
    Ok(())
}
