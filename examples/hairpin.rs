//! A body that touches itself: a band folded around is pressed together until its arms meet.
//!
//! ```text
//! cargo run --release --example hairpin
//! cargo run --release --example hairpin -- --without   # the arms pass through each other
//! ```
//!
//! The scene itself is in `support/hairpin.rs`. All files go to `out/hairpin`: the tables
//! `hairpin.csv` and `hairpin_iterations.csv`, a series for ParaView (`hairpin.pvd`), the picture
//! `hairpin.svg`, and `summary.json`.
//!
//! It ends with exit code 0 at full load, 1 if some increment does not converge, 2 on errors, 3 if
//! some certificate does not hold, and 130 on Ctrl-C, with everything written up to there.
#![allow(non_snake_case)] // the symbols of the field

#[path = "support/hairpin.rs"]
#[allow(dead_code)] // tests use more of it
mod hairpin;
mod support;

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::picture::{MeshPicture, Panel};
use ipopt_contact::prelude::*;
use support::Failure;
use support::options::{Options, positive};
use support::recorder::Recorder;
use support::run::{Run, exit};

/// The arms of a hairpin are pressed together until they meet
#[derive(Parser, Debug)]
struct Arguments {
    /// Cells through the band's thickness
    #[arg(long, default_value_t = 4, value_parser = fineness)]
    fine: usize,
    /// Leave out the self-contact
    #[arg(long)]
    without: bool,
    #[command(flatten)]
    options: Options,
}

/// `--fine`
fn fineness(text: &str) -> Result<usize, String> {
    match positive(text)? {
        fine if fine <= 100 => Ok(fine),
        fine => Err(format!(
            "{fine} is more than 100, which makes 560 000 triangles"
        )),
    }
}

fn main() -> ExitCode {
    exit(run(Arguments::parse()))
}

fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let scene = hairpin::scene(arguments.fine, !arguments.without)?;
    let run = Run {
        name: "hairpin",
        // of all supports together, the back and the two nodes pressed: 0 in balance
        reaction: &|record: &StepRecord<2>| record.reactions[0][1],
        message: &|step| {
            let record = step.record;
            let iterations = record.attempt.iterations.len();
            let (energy, rows) = (record.energy, record.rows);
            format!("energy {energy:.5}  rows {rows}  iterations {iterations}")
        },
        draw: &draw,
        report: &|_, _| String::new(),
    };
    run.go(scene.problem()?, &arguments.options.default_increments(16))
}

fn draw(problem: &Problem<2>, recorder: &Recorder<2>) -> Result<(), Failure> {
    let panels = recorder.stages.iter().map(|stage| Panel {
        title: stage.title.clone(),
        snapshot: &stage.snapshot,
    });
    let path = recorder.folder().join("hairpin.svg");
    Ok(MeshPicture::von_mises(panels.collect()).save(path, problem)?)
}
