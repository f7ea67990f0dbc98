//! Section 6.1 of the paper: a disc is pushed down inside a hollow disc, through large strains.
//!
//! ```text
//! cargo run --release --example disc_in_disc
//! cargo run --release --example disc_in_disc -- --mesh 128 --increments 50 --ipopt print_level=5
//! ```
//!
//! The scene is defined in `scenes/src/disc_in_disc.rs`. All files are written to
//! `out/disc_in_disc`: the tables `disc_in_disc.csv` and `disc_in_disc_iterations.csv`, a series
//! for ParaView (`disc_in_disc.pvd`), the pictures `meshes.svg` and `force.svg`, and
//! `summary.json`.
//!
//! The exit code is 0 at full load, 1 if an increment does not converge, 2 on an error, 3 if a
//! certificate does not hold, and 130 on Ctrl-C; the files are then complete up to the last
//! converged step.

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use ipopt_contact::contact_fem::output::picture::{Curve, Curves};
use ipopt_contact::contact_fem::output::record::{Recorded, exit};
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::cli::{Options, positive};
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, PUSH, Roles};

/// A disc is pushed down inside a hollow disc (section 6.1 of the paper)
#[derive(Parser, Debug)]
struct Arguments {
    /// `reference`, or the number of segments around the hole
    #[arg(long, value_name = "reference|N", default_value = "reference", value_parser = fineness)]
    mesh: Fineness,
    /// The roles of the surfaces; the symmetric method needs no choice
    #[arg(long, value_enum, default_value_t = Slaves::Both)]
    passes: Slaves,
    /// Reverse the order of the bodies; the result does not depend on it
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

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Recorded<2>, Failure> {
    let roles = Roles {
        swapped: arguments.swap,
        passes: match arguments.passes {
            Slaves::Both => Passes::Both,
            Slaves::Hole => Passes::FirstIsSlave,
            Slaves::Disc => Passes::SecondIsSlave,
        },
    };
    let force = |record: &StepRecord<2>| record.reaction(roles.ring())[1];

    let scene = disc_in_disc::scene(arguments.mesh, roles)?;
    let mut problem = arguments.options.scene(scene).problem()?;
    let mut simulation = arguments.options.simulation(100)?;
    let mut recording = arguments.options.record(&mut simulation, "disc_in_disc");
    recording.plan.own_files = vec!["force.svg".into()];
    recording.plan.force_picture = String::new();
    let picture = recording.plan.folder.join("force.svg");
    let recorded = recording.force(force).run(&mut problem)?;

    let steps = recorded.history.steps.iter();
    let points = steps.map(|record| (PUSH * record.factor, force(record)));
    let curves = Curves {
        title: "Force that pushes the disc down".into(),
        x_label: "displacement (UL)".into(),
        y_label: "force (UF)".into(),
        curves: vec![Curve {
            name: "reaction".into(),
            points: std::iter::once((0.0, 0.0)).chain(points).collect(),
        }],
    };
    curves.save(picture)?;
    Ok(recorded)
}
