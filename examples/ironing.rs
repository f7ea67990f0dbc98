//! Ironing: a stiff die is pressed into a soft slab and slid along it.
//!
//! ```text
//! cargo run --release --example ironing
//! cargo run --release --example ironing -- --order p1 --cells 72 --increments 200 --integration exact
//! ```
//!
//! The scene is defined in `scenes/src/ironing.rs`. All files are written to `out/ironing`: the tables `ironing.csv` and
//! `ironing_iterations.csv`, a series for ParaView (`ironing.pvd`), the pictures `meshes.svg` and `force.svg`, and
//! `summary.json`. At the end it prints how even the slide was.
//!
//! The exit code is 0 at the end of the slide, 1 if an increment does not converge, 2 on an error, 3 if a
//! certificate does not hold, and 130 on Ctrl-C; the files are then complete up to the last
//! converged step.

use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::picture::{Curve, Curves};
use ipopt_contact::contact_fem::output::record::{Recorded, exit, print};
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::cli::{Options, positive};
use ipopt_contact_scenes::ironing::{self, Evenness, Ironing, SLIDE};

/// A stiff die is pressed into a soft slab and slid along it
#[derive(Parser, Debug)]
struct Arguments {
    /// Linear or quadratic triangles
    #[arg(long, value_enum, default_value_t = Elements::P2)]
    order: Elements,
    /// Cells along the slab, from 3; a third of it through its thickness
    #[arg(long, default_value_t = 36, value_parser = cells)]
    cells: usize,
    /// Radius of the die (UL)
    #[arg(long, value_name = "R", default_value_t = 3.0, value_parser = above_zero)]
    radius: f64,
    /// Young's modulus of the die (UF/UL²); the slab has 1
    #[arg(long, value_name = "E", default_value_t = 1000.0, value_parser = above_zero)]
    young: f64,
    #[command(flatten)]
    options: Options,
}

/// `--order`
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Elements {
    P1,
    P2,
}

/// `--cells`
fn cells(text: &str) -> Result<usize, String> {
    match positive(text) {
        Ok(cells) if cells >= 3 => Ok(cells),
        _ => Err("a whole number from 3 is needed".into()),
    }
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if number > 0.0 && f64::is_finite(number) => Ok(number),
        _ => Err("a number above 0 is needed".into()),
    }
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Recorded<2>, Failure> {
    let order = match arguments.order {
        Elements::P1 => Order::Linear,
        Elements::P2 => Order::Quadratic,
    };
    let ironing = Ironing {
        radius: arguments.radius,
        young: arguments.young,
        ..Ironing::new(order, arguments.cells)
    };
    let mut problem = arguments.options.scene(ironing.scene()?).problem()?;
    // the increments of the slide; the press has a fifth of them
    let slide = arguments.options.increments.unwrap_or(100);
    let mut simulation = arguments.options.simulation(slide)?;
    simulation.load_steps.phases = ironing::phases(slide.div_ceil(5), slide).to_vec();
    let mut recording = arguments.options.record(&mut simulation, "ironing");
    recording.plan.own_files = vec!["force.svg".into()];
    recording.plan.force_picture = String::new();
    let picture = recording.plan.folder.join("force.svg");
    let recorded = recording
        .force(|record| ironing::force(record).norm())
        .message(message)
        .run(&mut problem)?;
    force_picture(&recorded).save(picture)?;
    match Evenness::of(&recorded.history) {
        Some(evenness) if !arguments.options.quiet => print(evenness),
        _ => {}
    }
    Ok(recorded)
}

/// The progress text of a step.
fn message(step: &StepView<'_, 2>) -> String {
    let force = ironing::force(step.record);
    let attempt = &step.record.attempt;
    format!(
        "force {:.5} down, {:+.5} along  iterations {} ({} factorisations)",
        -force[1],
        force[0],
        attempt.iterations.len(),
        attempt.cost.factorizations
    )
}

/// The forces that move the die over its way along the slab.
fn force_picture(recorded: &Recorded<2>) -> Curves {
    let steps = recorded.history.steps.iter();
    let slide: Vec<_> = steps.filter(|step| step.factor >= 1.0).collect();
    let curve = |name: &str, of: fn(&StepRecord<2>) -> f64| Curve {
        name: name.into(),
        points: slide
            .iter()
            .map(|step| (SLIDE * (step.factor - 1.0), of(step)))
            .collect(),
    };
    Curves {
        title: "Forces that move the die".into(),
        x_label: "way along the slab (UL)".into(),
        y_label: "force (UF)".into(),
        curves: vec![
            curve("down", |step| -ironing::force(step)[1]),
            curve("along", |step| ironing::force(step)[0]),
        ],
    }
}
