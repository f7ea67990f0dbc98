//! Section 6.1 of the paper: a disc is pushed down inside a hollow disc, through large strains.
//!
//! ```text
//! cargo run --release --example disc_in_disc
//! cargo run --release --example disc_in_disc -- --mesh 128 --increments 50 --ipopt print_level=5
//! ```
//!
//! The scene itself is in `support/discs.rs`. All files go to `out/disc_in_disc`: the tables
//! `disc_in_disc.csv` and `disc_in_disc_iterations.csv`, a series for ParaView
//! (`disc_in_disc.pvd`), the pictures `meshes.svg` and `force.svg`, and `summary.json`.
//!
//! It ends with exit code 0 at full load, 1 if some increment does not converge, 2 on errors, 3 if
//! some certificate does not hold, and 130 on Ctrl-C, with everything written up to there.

#[path = "support/discs.rs"]
mod discs;
mod support;

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use discs::{Fineness, Roles};
use ipopt_contact::contact_fem::output::picture::{Curve, Curves, MeshPicture, Panel};
use ipopt_contact::prelude::*;
use support::Failure;
use support::options::{Options, positive};
use support::recorder::Recorder;
use support::run::{Run, exit};

/// A disc is pushed down inside a hollow disc (section 6.1 of the paper)
#[derive(Parser, Debug)]
struct Arguments {
    /// `reference`, or the number of segments around the hole
    #[arg(long, value_name = "reference|N", default_value = "reference", value_parser = fineness)]
    mesh: Fineness,
    /// Which surface is slave; the symmetric method needs no choice
    #[arg(long, value_enum, default_value_t = Slaves::Both)]
    passes: Slaves,
    /// Give the bodies in the other order, which changes nothing
    #[arg(long)]
    swap: bool,
    #[command(flatten)]
    options: Options,
}

/// `--passes`
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Slaves {
    Both,
    Hole,
    Disc,
}

fn main() -> ExitCode {
    exit(run(Arguments::parse()))
}

fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let roles = arguments.roles();
    let problem = discs::scene(arguments.mesh, roles)?.problem()?;
    let force = |record: &StepRecord<2>| record.reactions[roles.ring()][1];
    let run = Run {
        name: "disc_in_disc",
        reaction: &force,
        message: &|step| message(step.record, force(step.record)),
        draw: &|problem, recorder| draw(problem, recorder, force),
        report: &|_, _| String::new(),
    };
    run.go(problem, &arguments.options.default_increments(100))
}

/// What is shown of a step.
fn message(record: &StepRecord<2>, force: f64) -> String {
    let fixed_point = record.attempt.iterations.len();
    let ipopt = record.attempt.cost.iterations;
    format!(
        "energy {:.4}  reaction {force:.2}  iterations {fixed_point} ({ipopt} of Ipopt)",
        record.energy
    )
}

/// The deformed discs as in the paper's Figure 1, and the force over the way.
fn draw(
    problem: &Problem<2>,
    recorder: &Recorder<2>,
    force: impl Fn(&StepRecord<2>) -> f64,
) -> Result<(), Failure> {
    let panels = recorder.stages.iter().map(|stage| Panel {
        title: stage.title.clone(),
        snapshot: &stage.snapshot,
    });
    let folder = recorder.folder();
    MeshPicture::von_mises(panels.collect()).save(folder.join("meshes.svg"), problem)?;

    let steps = recorder.records.iter();
    let points = steps.map(|record| (discs::PUSH * record.factor, force(record)));
    let curves = Curves {
        title: "Force that pushes the disc down".into(),
        x_label: "displacement (UL)".into(),
        y_label: "force (UF)".into(),
        curves: vec![Curve {
            name: "reaction".into(),
            points: std::iter::once((0.0, 0.0)).chain(points).collect(),
        }],
    };
    Ok(curves.save(folder.join("force.svg"))?)
}

impl Arguments {
    fn roles(&self) -> Roles {
        Roles {
            swapped: self.swap,
            passes: match self.passes {
                Slaves::Both => Passes::Both,
                Slaves::Hole => Passes::FirstIsSlave,
                Slaves::Disc => Passes::SecondIsSlave,
            },
        }
    }
}

/// `--mesh`
fn fineness(text: &str) -> Result<Fineness, String> {
    if text == "reference" {
        return Ok(Fineness::REFERENCE);
    }
    match positive(text) {
        Ok(segments) if segments >= 8 => Ok(Fineness::scaled(segments)),
        _ => Err("`reference` or a whole number from 8 is needed".into()),
    }
}
