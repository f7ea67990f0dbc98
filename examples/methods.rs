//! The three methods for step 5 side by side: the interior point (7), the penalised slack (37) and
//! the penalty (39); and one pass against the other and against both.
//!
//! ```text
//! cargo run --release --example methods
//! cargo run --release --example methods -- --asymmetry
//! cargo run --release --example methods -- --quick     # coarse meshes, seconds
//! ```
//!
//! Tables go to the standard output and to `out/methods`, as Markdown and as comma-separated
//! values: `methods` and `orders`, or with `--asymmetry` `hertz_passes` and `discs_passes`. What
//! they say is in `docs/methods.md`.
//!
//! It ends with exit code 0 once all tables are written, 2 on errors. A run that does not converge
//! is a row without numbers.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::{exit, print};
use ipopt_contact_scenes::studies::{asymmetry, methods};
use ipopt_contact_scenes::{Failure, files};

/// The three methods for the constrained minimisation side by side
#[derive(Parser, Debug)]
struct Arguments {
    /// One pass against the other and against both, for moduli in all proportions
    #[arg(long)]
    asymmetry: bool,
    /// Coarse meshes and few cases
    #[arg(long)]
    quick: bool,
    /// Folder for all files
    #[arg(long, value_name = "DIR", default_value = "out/methods")]
    out: PathBuf,
    /// Only files, nothing on the standard output; rows still show on the standard error as they come
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
