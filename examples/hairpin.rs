//! Self-contact: a folded band is pressed together until its arms touch.
//!
//! ```text
//! cargo run --release --example hairpin
//! cargo run --release --example hairpin -- --without   # the arms pass through each other
//! ```
//!
//! The scene is defined in `scenes/src/hairpin.rs`. All files are written to `out/hairpin`: the
//! tables `hairpin.csv` and `hairpin_iterations.csv`, a series for ParaView (`hairpin.pvd`), the
//! picture `hairpin.svg`, and `summary.json`.
//!
//! The exit code is 0 at full load, 1 if an increment does not converge, 2 on an error, 3 if a
//! certificate does not hold, and 130 on Ctrl-C; the files are then complete up to the last
//! converged step.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::{Recorded, exit};
use ipopt_contact_scenes::cli::{Options, positive};
use ipopt_contact_scenes::{Failure, hairpin};

/// The arms of a hairpin are pressed together until they touch
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
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Recorded<2>, Failure> {
    let scene = hairpin::scene(arguments.fine, !arguments.without)?;
    let mut problem = arguments.options.scene(scene).problem()?;
    let mut simulation = arguments.options.simulation(16)?;
    let mut recording = arguments.options.record(&mut simulation, "hairpin");
    recording.plan.picture = "hairpin.svg".into();
    let recording = recording
        // the sum over all supports, the back and the two pressed nodes: 0 in equilibrium
        .force(|record| record.reactions[0][1])
        .message(|step| {
            let record = step.record;
            let iterations = record.attempt.iterations.len();
            let (energy, rows) = (record.energy, record.rows);
            format!("energy {energy:.5}  rows {rows}  iterations {iterations}")
        });
    Ok(recording.run(&mut problem)?)
}
