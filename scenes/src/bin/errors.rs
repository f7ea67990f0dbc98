//! Compares estimated errors with true ones, on uniformly refined meshes of several scenes.
//!
//! ```text
//! cargo run --release -p ipopt-contact-scenes --bin errors
//! ```
//!
//! Each mesh is a line, on the standard output and in `errors.csv`. The true error of the energy is that to the finest quadratic mesh
//! of the scene. Contact enters it as well as strain, so that it may be below zero on meshes that are coarse.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use contact_fem::element::Order;
use contact_fem::output::record::exit;
use contact_fem::{Error, Scene, Simulation};
use ipopt_contact_scenes::ball::Ball;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::disc_in_disc::{self, Roles};
use ipopt_contact_scenes::hertz::{self, Hertz};
use ipopt_contact_scenes::{Failure, files};
use serde::Serialize;

/// Estimated against true errors
#[derive(Parser, Debug)]
struct Arguments {
    /// The scenes, separated by commas [default: all]
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// The folder for the results
    #[arg(long, default_value = "out/errors")]
    out: PathBuf,
}

/// One mesh, as a line of `errors.csv`.
#[derive(Serialize, Clone)]
struct Line {
    scene: &'static str,
    order: &'static str,
    fineness: usize,
    unknowns: usize,
    /// The fewest facets in contact of a pair.
    facets: Option<usize>,
    energy: f64,
    /// Estimated errors: relative in the energy norm, and of the energy (UF·UL).
    relative: f64,
    estimated: f64,
    /// The true error of the energy (UF·UL), and the ratio of estimated and true errors in the energy norm.
    truth: f64,
    effectivity: f64,
    seconds: f64,
    /// Time of the estimate as a share of the run's.
    share: f64,
}

/// A scene on meshes of several finenesses, the finest of which is the reference.
struct Family<const D: usize> {
    name: &'static str,
    increments: usize,
    linear: &'static [usize],
    quadratic: &'static [usize],
    scene: fn(usize, Order) -> Result<Scene<D>, Error>,
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    files::make_folder(&arguments.out)?;
    let mut lines = Vec::new();
    let is_asked =
        |name: &str| arguments.scenes.is_empty() || arguments.scenes.iter().any(|s| s == name);
    let plane = [
        Family {
            name: "half-cylinder",
            increments: 1,
            linear: &[2, 4, 8, 16],
            quadratic: &[2, 4, 8, 24],
            scene: |fine, order| Hertz::new(hertz::Fineness::family(fine), order).scene(),
        },
        Family {
            name: "disc-in-disc",
            increments: 5,
            linear: &[24, 36, 48, 64, 100],
            quadratic: &[16, 24, 36, 48, 100],
            scene: |fine, order| {
                let fineness = disc_in_disc::Fineness::scaled(fine);
                match order {
                    Order::Linear => disc_in_disc::scene(fineness, Roles::default()),
                    Order::Quadratic => disc_in_disc::quadratic_scene(fineness, Roles::default()),
                }
            },
        },
    ];
    let space = [
        Family {
            name: "ball",
            increments: 1,
            linear: &[1, 2, 3, 4],
            quadratic: &[1, 2, 3, 5],
            scene: |in_contact, order| Ball { in_contact, order }.scene(),
        },
        Family {
            name: "beams",
            increments: 1,
            linear: &[2, 3, 4, 6],
            quadratic: &[1, 2, 3, 5],
            scene: |across, order| Beams::new(across, order, Law::SmallStrain).scene(),
        },
        Family {
            name: "finite beams",
            increments: 4,
            linear: &[2, 3, 4],
            quadratic: &[1, 2, 4],
            scene: |across, order| Beams::new(across, order, Law::NeoHookean).scene(),
        },
    ];
    for family in plane.iter().filter(|family| is_asked(family.name)) {
        lines.extend(family.lines()?);
    }
    for family in space.iter().filter(|family| is_asked(family.name)) {
        lines.extend(family.lines()?);
    }
    let mut writer = csv::Writer::from_path(arguments.out.join("errors.csv"))?;
    for line in &lines {
        writer.serialize(line)?;
    }
    writer.flush()?;
    Ok(ExitCode::SUCCESS)
}

impl<const D: usize> Family<D> {
    /// All meshes but the reference.
    fn lines(&self) -> Result<Vec<Line>, Failure> {
        let reference = *self.quadratic.last().ok_or("a reference is needed")?;
        let reference = self.solve(reference, Order::Quadratic)?;
        println!(
            "{}: reference energy {:.8} with {} unknowns, estimated error {:.2e}",
            self.name, reference.energy, reference.unknowns, reference.estimated
        );
        let coarse = &self.quadratic[..self.quadratic.len() - 1];
        let linear = self.linear.iter().map(|&fine| (fine, Order::Linear));
        let quadratic = coarse.iter().map(|&fine| (fine, Order::Quadratic));
        let mut lines = Vec::new();
        for (fineness, order) in linear.chain(quadratic) {
            let line = self.solve(fineness, order)?;
            let truth = line.energy - reference.energy;
            let line = Line {
                truth,
                effectivity: (line.estimated / truth).sqrt(),
                ..line
            };
            println!(
                "{} {} {}: {} unknowns, {} facets touch, estimated {:.2} %, energy {:.3e} of {:.3e}, effectivity {:.2}, {:.2} s, estimate {:.1} %",
                line.scene,
                line.order,
                line.fineness,
                line.unknowns,
                line.facets.map_or("-".into(), |count| count.to_string()),
                100.0 * line.relative,
                line.estimated,
                truth,
                line.effectivity,
                line.seconds,
                100.0 * line.share
            );
            lines.push(line);
        }
        Ok(lines)
    }

    fn solve(&self, fineness: usize, order: Order) -> Result<Line, Failure> {
        let clock = Instant::now();
        let mut problem = (self.scene)(fineness, order)?.problem()?;
        let history = Simulation::with_increments(self.increments).run(&mut problem)?;
        let seconds = clock.elapsed().as_secs_f64();
        let solution = history.run.solution.as_ref();
        let solution = solution.ok_or_else(|| history.run.ending.to_string())?;
        let clock = Instant::now();
        let estimate = problem.error_estimate(solution)?;
        let share = clock.elapsed().as_secs_f64() / seconds;
        let facets = estimate.contacts.iter().filter_map(|pair| pair.touching);
        Ok(Line {
            scene: self.name,
            order: match order {
                Order::Linear => "P1",
                Order::Quadratic => "P2",
            },
            fineness,
            unknowns: problem.dofs().free(),
            facets: facets.min(),
            energy: solution.energy,
            relative: estimate.relative,
            estimated: estimate.energy,
            truth: f64::NAN,
            effectivity: f64::NAN,
            seconds,
            share,
        })
    }
}
