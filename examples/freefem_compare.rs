//! The same scenes, meshes and tolerances solved by FreeFEM's scripts in `freefem/` and by this
//! library, side by side.
//!
//! ```text
//! cargo run --release --example freefem_compare
//! cargo run --release --example freefem_compare -- --scene disc_in_disc --size small --size medium
//! cargo run --release --example freefem_compare -- --export-only meshes
//! ```
//!
//! Every run is a process of its own on one thread, so that CPU time and peak memory are its own.
//! Of runs that take less than a minute there are `--runs`, and the table has medians. Tables go
//! to the standard output and to `out/freefem_compare`: `results` and `costs` as Markdown and
//! comma-separated values, `compare.json`, the pictures `cpu.svg` and `memory.svg`, and for every
//! run the folder
//! `SCENE/SIZE/PROGRAM` with what it left. Where FreeFEM is missing, stored results of
//! `freefem/reference` take its place.
//!
//! Meshes are written as `BODY.msh` in the plane and `BODY.mesh` in space. FreeFEM's vertices are
//! numbered as the nodes here; boundaries have the numbers of their names in alphabetical order.
//!
//! It ends with exit code 0 once all tables are written, 2 on errors, 130 on Ctrl-C, which ends the
//! program that runs, too. A run that does not converge
//! says so in the table.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::output::record::exit;
use ipopt_contact_scenes::freefem::compare::Arguments;

fn main() -> ExitCode {
    exit(Arguments::parse().run())
}
