//! The same scenes, meshes and tolerances solved by FreeFEM's scripts in `freefem/` and by this
//! library, side by side.
//!
//! ```text
//! cargo run --release --example freefem_compare -- --export-only meshes
//! ```
//!
//! Meshes go to `FOLDER/SCENE/SIZE/BODY.msh` in the plane and `.mesh` in space. FreeFEM's vertices are
//! numbered as the nodes here; boundaries have the numbers of their names in alphabetical order.
#![allow(non_snake_case)] // the symbols of the field

#[path = "support/beams.rs"]
#[allow(dead_code)] // another example uses more of it
mod beams;
#[path = "support/discs.rs"]
#[allow(dead_code)] // another example uses more of it
mod discs;
#[path = "support/freefem/mod.rs"]
mod freefem;
#[path = "support/hertz.rs"]
#[allow(dead_code)] // tests use more of it
mod hertz;
mod support;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use freefem::cases::{CASES, Case, Size};
use support::Failure;
use support::run::exit;

/// FreeFEM and this library on the same scenes
#[derive(Parser, Debug)]
struct Arguments {
    /// Only this scene; may be repeated
    #[arg(long, value_name = "NAME")]
    scene: Vec<String>,
    /// Only this size; may be repeated
    #[arg(long, value_enum)]
    size: Vec<Size>,
    /// Write the meshes for FreeFEM to this folder, and nothing else
    #[arg(long, value_name = "DIR")]
    export_only: Option<PathBuf>,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let folder = arguments.export_only.clone().unwrap_or("meshes".into());
    for case in arguments.cases()? {
        for size in arguments.sizes() {
            let folder = folder.join(case.name).join(size.name());
            std::fs::create_dir_all(&folder)?;
            let built = (case.build)(size)?;
            built.export(case.bodies, &folder)?;
            println!("{}: {} cells", folder.display(), built.cells());
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn cases(&self) -> Result<Vec<&'static Case>, Failure> {
        for name in &self.scene {
            if CASES.iter().all(|case| case.name != name) {
                let known: Vec<&str> = CASES.iter().map(|case| case.name).collect();
                let known = known.join(", ");
                return Err(format!("there is no scene `{name}`; there are {known}").into());
            }
        }
        let asked =
            |case: &&Case| self.scene.is_empty() || self.scene.iter().any(|name| name == case.name);
        Ok(CASES.iter().filter(asked).collect())
    }

    fn sizes(&self) -> Vec<Size> {
        match self.size.is_empty() {
            true => vec![Size::Tiny, Size::Small, Size::Medium, Size::Large],
            false => self.size.clone(),
        }
    }
}
