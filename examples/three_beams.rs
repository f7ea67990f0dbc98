//! Section 6.2 of the paper: three cantilevers on top of each other share a load and slide.
//!
//! ```text
//! cargo run --release --example three_beams
//! cargo run --release --example three_beams -- --law neo-hookean --order p1 --across 4
//! ```
//!
//! The scene itself is in `support/beams.rs`. All files go to `out/three_beams`: the tables
//! `three_beams.csv` and `three_beams_iterations.csv`, a series for ParaView (`three_beams.pvd`),
//! the picture `beams.svg`, and `summary.json`. Beside what every example reports there are the
//! displacement of each beam's tip, how far the beams slide there, and the pressures between them
//! around mid-span.
//!
//! It ends with exit code 0 at full load, 1 if some increment does not converge, 2 on errors, 3 if
//! some certificate does not hold, and 130 on Ctrl-C, with everything written up to there.
#![allow(non_snake_case)] // the symbols of the field

#[path = "support/beams.rs"]
mod beams;
mod support;

use std::process::ExitCode;

use beams::{Beams, Law};
use clap::{Parser, ValueEnum};
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::picture::{MeshPicture, Panel};
use ipopt_contact::prelude::*;
use support::Failure;
use support::options::{Options, positive};
use support::recorder::Recorder;
use support::run::{Run, exit};

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
    exit(run(Arguments::parse()))
}

fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
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
    let scene = beams.scene()?;
    let run = Run {
        name: "three_beams",
        reaction: &|record| record.reactions.iter().map(|r| r[2]).sum(),
        message: &message,
        draw: &draw,
        report: &report,
    };
    run.go(
        scene.problem()?,
        &arguments.options.default_increments(increments),
    )
}

/// What is shown of a step.
fn message(step: &StepView<'_, 3>) -> String {
    let u = step.problem.displacements(&step.solution.state.u);
    let attempt = &step.record.attempt;
    format!(
        "tip {:.3}  iterations {} ({} of Ipopt)",
        beams::tip(step.problem, &u, 0)[2],
        attempt.iterations.len(),
        attempt.effort().iterations
    )
}

/// The beams before and after, as in the paper's Figure 2.
fn draw(problem: &Problem<3>, recorder: &Recorder<3>) -> Result<(), Failure> {
    let stages = [recorder.stages.first(), recorder.stages.last()];
    let panels = stages.into_iter().flatten().map(|stage| Panel {
        title: stage.title.clone(),
        snapshot: &stage.snapshot,
    });
    let path = recorder.folder().join("beams.svg");
    Ok(MeshPicture::von_mises(panels.collect()).save(path, problem)?)
}

/// Tips, slips and pressures of the last state.
fn report(problem: &Problem<3>, recorder: &Recorder<3>) -> String {
    let Some(stage) = recorder.stages.last() else {
        return String::new();
    };
    let u = &stage.snapshot.displacements;
    let count = problem.scene().bodies().len();
    let mut text = String::new();
    for k in 0..count {
        let [x, _, z] = beams::tip(problem, u, k);
        text += &format!("\n  tip {k}              {z:>10.4} UL down, {x:.4} UL along");
    }
    for k in 0..problem.scene().pairs().len() {
        let pressure = beams::mid_span_pressure(problem, &stage.snapshot.pressures, k);
        text += &format!(
            "\n  between {k} and {}    {:>10.4} UL slip at the tip, {pressure:.3} UF/UL² at mid-span",
            k + 1,
            beams::slip(problem, u, k)
        );
    }
    text
}
