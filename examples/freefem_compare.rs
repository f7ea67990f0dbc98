//! Solves the same scenes with the same meshes and tolerances by FreeFEM's scripts in `freefem/`
//! and by this library, and compares the results.
//!
//! ```text
//! cargo run --release --example freefem_compare
//! cargo run --release --example freefem_compare -- --scene disc_in_disc --size small --size medium
//! cargo run --release --example freefem_compare -- --export-only meshes
//! ```
//!
//! Every run is a separate process on one thread, so that CPU time and peak memory are its own.
//! Runs that take less than a minute are repeated `--runs` times, and the tables contain the
//! medians. The tables are printed on the standard output and written to `out/freefem_compare`:
//! `results` and `costs` as Markdown and comma-separated values, with `compare.json` and the
//! pictures `cpu.svg` and `memory.svg`. The files of each run are in the folder
//! `SCENE/SIZE/PROGRAM`. If FreeFEM is not installed, the stored results in `freefem/reference` are
//! used instead.
//!
//! Meshes are written as `BODY.msh` in the plane and `BODY.mesh` in space. The vertices have the
//! numbers of the nodes; boundaries have the numbers of their names in alphabetical order.
//!
//! The exit code is 0 if all tables were written, 2 on an error, and 130 on Ctrl-C, which also ends
//! the running program. The table marks runs that do not converge.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::exit;
use ipopt_contact_scenes::freefem::compare::Arguments;

fn main() -> ExitCode {
    exit(Arguments::parse().run())
}
