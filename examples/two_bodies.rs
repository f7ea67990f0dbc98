//! Two blocks, one on the other, at small strains: the scene of `freefem/two_bodies.edp`, which shows how a script of
//! FreeFEM leaves a result to compare.
//!
//! ```text
//! cargo run --release --example two_bodies                 # linear elements, to out/two_bodies
//! cargo run --release --example two_bodies -- --quadratic
//! ```
//!
//! `ipopt-contact compare out/two_bodies FOLDER_OF_THE_SCRIPT` tells how the two differ.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::output::record::exit;
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::cli::Solver;

/// Two blocks, one on the other, as `freefem/two_bodies.edp` solves them
#[derive(Parser, Debug)]
struct Arguments {
    /// Quadratic elements instead of linear ones
    #[arg(long)]
    quadratic: bool,
    /// How the load is solved
    #[arg(long, value_enum, default_value_t = Solver::Automatic)]
    solver: Solver,
    /// The folder of all files
    #[arg(long, default_value = "out/two_bodies")]
    out: std::path::PathBuf,
}

fn main() -> ExitCode {
    let Arguments {
        quadratic,
        solver,
        out,
    } = Arguments::parse();
    let run = || {
        let mut problem = scene(quadratic)?.problem()?;
        let mut simulation = Simulation::solved_by(solver.with_tolerance(None), 1);
        simulation.record(out).run(&mut problem)
    };
    exit(run())
}

/// The lower block is twice as wide and half as stiff. It is held at its bottom, the upper one is moved at its top.
pub fn scene(quadratic: bool) -> Result<Scene<2>, Error> {
    let block = |x: [f64; 2], y: f64, cells: [usize; 2], young| {
        let (across, up) = (
            linspace(x[0], x[1], cells[0]),
            linspace(y, y + 1.0, cells[1]),
        );
        let mesh = rectangle(&across, &up, Diagonals::Rising)?;
        let mesh = if quadratic { mesh.quadratic() } else { mesh };
        Ok::<_, Error>(Body::new(mesh, LinearElastic::new(young, 0.3)?))
    };
    let mut lower = block([0.0, 2.0], 0.0, [8, 2], 100.0)?;
    lower.prescribe("bottom", [Some(0.0), Some(0.0)])?;
    let mut upper = block([0.5, 1.5], 1.0, [6, 3], 200.0)?;
    upper.prescribe("top", [Some(0.02), Some(-0.02)])?;

    let mut scene = Scene::new();
    let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    // the script's points; by default quadratic elements have more
    scene.integration = Some(Integration::Gauss(4));
    scene.contact(lower.on("top"), upper.on("bottom"))?;
    Ok(scene)
}
