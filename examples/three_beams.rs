//! Section 6.2 of the paper: three stacked cantilevers share a load and slide on each other.
//!
//! ```text
//! cargo run --release --example three_beams
//! cargo run --release --example three_beams -- --law neo-hookean --order p1 --across 4
//! ```
//!
//! The scene is defined in `scenes/src/beams.rs`. All files are written to `out/three_beams`: the
//! tables `three_beams.csv` and `three_beams_iterations.csv`, a series for ParaView
//! (`three_beams.pvd`), the picture `beams.svg`, and `summary.json`. The example also reports the
//! displacement of each beam's tip, the sliding of the beams there, and the pressures between them
//! around mid-span.
//!
//! The exit code is 0 at full load, 1 if an increment does not converge, 2 on an error, 3 if a
//! certificate does not hold, and 130 on Ctrl-C; the files are then complete up to the last
//! converged step.

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::Snapshot;
use ipopt_contact::contact_fem::output::record::{Recorded, exit, print};
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::beams::{self, Beams, Law};
use ipopt_contact_scenes::cli::{Options, positive};

/// Three beams share a load and slide on each other (section 6.2 of the paper)
#[derive(Parser, Debug)]
struct Arguments {
    /// Cells across a beam's side
    #[arg(long, default_value_t = 2, value_parser = positive)]
    across: usize,
    /// Linear or quadratic tetrahedra; linear ones are much too stiff in bending
    #[arg(long, value_enum, default_value_t = Elements::P2)]
    order: Elements,
    /// Small strains in one increment, or large ones in 10
    #[arg(long, value_enum, default_value_t = Laws::SmallStrain)]
    law: Laws,
    /// The beams do not touch, and each carries a third of the load
    #[arg(long)]
    apart: bool,
    #[command(flatten)]
    options: Options,
}

/// `--order`
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Elements {
    P1,
    P2,
}

/// `--law`
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Laws {
    SmallStrain,
    NeoHookean,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Recorded<3>, Failure> {
    let order = match arguments.order {
        Elements::P1 => Order::Linear,
        Elements::P2 => Order::Quadratic,
    };
    let (law, increments) = match arguments.law {
        Laws::SmallStrain => (Law::SmallStrain, 1),
        Laws::NeoHookean => (Law::NeoHookean, 10),
    };
    let beams = Beams {
        contact: !arguments.apart,
        ..Beams::new(arguments.across, order, law)
    };
    let mut problem = arguments.options.scene(beams.scene()?).problem()?;
    let mut simulation = arguments.options.simulation(increments)?;
    let mut recording = arguments.options.record(&mut simulation, "three_beams");
    // the undeformed and the deformed beams, as in the paper's Figure 2
    recording.plan.picture = "beams.svg".into();
    recording.plan.half_way = false;
    let recorded = recording
        .force(|record| record.reactions.iter().map(|r| r[2]).sum())
        .message(message)
        .run(&mut problem)?;
    if let (false, Some(last)) = (arguments.options.quiet, recorded.stages.last()) {
        print(report(&problem, &last.snapshot));
    }
    Ok(recorded)
}

/// The progress text of a step.
fn message(step: &StepView<'_, 3>) -> String {
    let u = step.problem.displacements(&step.solution.state.u);
    let attempt = &step.record.attempt;
    format!(
        "tip {:.3}  iterations {} ({} inner)",
        beams::tip(step.problem, &u, 0)[2],
        attempt.iterations.len(),
        attempt.cost.inner_iterations
    )
}

/// The tip displacements, slips and pressures of a state.
fn report(problem: &Problem<3>, state: &Snapshot<3>) -> String {
    let u = &state.displacements;
    let count = problem.scene().bodies().len();
    let mut lines = Vec::new();
    for k in 0..count {
        let [x, _, z] = beams::tip(problem, u, k);
        lines.push(format!(
            "  tip {k}              {z:>10.4} UL down, {x:.4} UL along"
        ));
    }
    for k in 0..problem.scene().pairs().len() {
        let pressure = beams::mid_span_pressure(problem, &state.pressures, k);
        lines.push(format!(
            "  between {k} and {}    {:>10.4} UL slip at the tip, {pressure:.3} UF/UL² at mid-span",
            k + 1,
            beams::slip(problem, u, k)
        ));
    }
    lines.join("\n")
}
