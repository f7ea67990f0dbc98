//! Compares the three methods for step 5: the interior point (7), the penalised slack (37) and the
//! penalty (39); or each single pass with both.
//!
//! ```text
//! cargo run --release --example methods
//! cargo run --release --example methods -- --asymmetry
//! cargo run --release --example methods -- --quick     # coarse meshes, seconds
//! ```
//!
//! The tables are printed on the standard output and written to `out/methods` as Markdown and
//! comma-separated values: `methods` and `orders`, or with `--asymmetry` `hertz_passes` and
//! `discs_passes`. `docs/methods.md` discusses them.
//!
//! The exit code is 0 if all tables were written and 2 on an error. A run that does not converge is
//! a row without numbers.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::{exit, print};
use ipopt_contact_scenes::studies::{asymmetry, methods};
use ipopt_contact_scenes::{Failure, files};

/// The three methods for the constrained minimisation in comparison
#[derive(Parser, Debug)]
struct Arguments {
    /// Compare each single pass with both, for various ratios of the moduli
    #[arg(long)]
    asymmetry: bool,
    /// Use coarse meshes and few cases
    #[arg(long)]
    quick: bool,
    /// Folder for all files
    #[arg(long, value_name = "DIR", default_value = "out/methods")]
    out: PathBuf,
    /// Print nothing on the standard output; rows are still shown on the standard error
    #[arg(long)]
    quiet: bool,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    files::make_folder(&arguments.out)?;
    let tables = match arguments.asymmetry {
        true => asymmetry::tables(arguments.quick)?,
        false => methods::tables(arguments.quick)?,
    };
    for table in &tables {
        table.save(&arguments.out)?;
        if !arguments.quiet {
            print(table.markdown());
        }
    }
    Ok(())
}
