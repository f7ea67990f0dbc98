//! Runs standard scenes on many meshes, and tells how many of them are complete and certified.
//!
//! ```text
//! cargo run --release -p ipopt-contact-scenes --bin meshes -- --scenes discs,ironing
//! ```
//!
//! Each run is a line, on the standard output and in `runs.csv`. A table by scene is the end. The exit code is 1 if less
//! than 99 % of a scene's runs are complete and certified.
#![forbid(unsafe_code)]

use std::ops::RangeInclusive;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};
use contact_core::{Ending, Outcome, Phase};
use contact_fem::certificate::{Certificate, Limits};
use contact_fem::element::Order;
use contact_fem::output::record::{exit, print};
use contact_fem::simulation::History;
use contact_fem::{Error, Scene, Simulation};
use ipopt_contact_scenes::arch::{self, Large};
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::cli::{Points, positive};
use ipopt_contact_scenes::die::Die;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::hairpin::{self, Hairpin};
use ipopt_contact_scenes::ironing::{self, Ironing};
use ipopt_contact_scenes::random::Random;
use ipopt_contact_scenes::tables::Table;
use ipopt_contact_scenes::wheel::{self, Wheel};
use ipopt_contact_scenes::{Failure, files};
use nix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// The share of a scene's runs that must be complete and certified.
const ENOUGH: f64 = 0.99;
/// By how much random variants differ from the middle of each parameter.
const SPREAD: f64 = 0.4;
/// The increments of random variants.
const INCREMENTS: usize = 10;
/// The share of these that presses the die.
const PRESS: usize = 2;
/// The increments in which the wheel rolls.
const ROLL: usize = 20;
/// The increments in which a sharp die slides.
const SLIDE: usize = 30;
/// The largest share by which cells of a slab are narrower in the middle, or wider.
const GRADED: f64 = 0.5;

/// Standard scenes on many meshes: how many are complete and certified
#[derive(Parser, Debug)]
struct Arguments {
    /// The scenes, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Kind::value_variants().to_vec())]
    scenes: Vec<Kind>,
    /// discs: the first and the last number of segments on the hole, of which the even ones are taken
    #[arg(long, value_name = "FROM..TO", default_value = "24..100", value_parser = range)]
    meshes: RangeInclusive<usize>,
    /// discs: numbers of increments, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "20,100", value_parser = positive)]
    increments: Vec<usize>,
    /// discs: both orders of the bodies
    #[arg(long)]
    swap: bool,
    /// Quadratic cells of discs, ironing, wheel and dies
    #[arg(long)]
    quadratic: bool,
    /// Random variants of each other scene
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..))]
    cases: u64,
    /// Only the variant of this number, to run it again
    #[arg(long, value_name = "N")]
    case: Option<u64>,
    /// The seed of the variants
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    points: Points,
    /// Seconds after which a run is stopped
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    seconds: f64,
    /// The folder for the results
    #[arg(long, default_value = "out/meshes")]
    out: PathBuf,
}

impl Arguments {
    fn order(&self) -> Order {
        match self.quadratic {
            true => Order::Quadratic,
            false => Order::Linear,
        }
    }
}

/// `--scenes`
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Discs,
    Ironing,
    Hairpin,
    Arch,
    Beams,
    Wheel,
    Dies,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.to_possible_value();
        f.pad(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// `--meshes`
fn range(text: &str) -> Result<RangeInclusive<usize>, String> {
    let parsed = text.split_once("..").and_then(|(from, to)| {
        let to = to.trim_start_matches('=');
        Some((from.parse().ok()?, to.parse().ok()?))
    });
    match parsed {
        Some((from, to)) if 4 <= from && from <= to => Ok(from..=to),
        _ => Err("FROM..TO with numbers from 4 is needed, such as 24..100".into()),
    }
}

/// One run, as a line of `runs.csv`.
#[derive(Serialize)]
struct Line {
    scene: String,
    parameters: String,
    status: &'static str,
    factor: f64,
    certified: bool,
    energy: f64,
    increments: usize,
    iterations: usize,
    factorisations: usize,
    /// The most of an increment, with all its cuts.
    most_iterations: usize,
    most_factorisations: usize,
    cuts: usize,
    seconds: f64,
    reason: String,
}

impl Line {
    /// Of a run that has not begun.
    fn failed(reason: String) -> Self {
        Line {
            scene: String::new(),
            parameters: String::new(),
            status: "failed",
            factor: 0.0,
            certified: false,
            energy: f64::NAN,
            increments: 0,
            iterations: 0,
            factorisations: 0,
            most_iterations: 0,
            most_factorisations: 0,
            cuts: 0,
            seconds: 0.0,
            reason,
        }
    }

    fn of<const D: usize>(history: &History<D>) -> Self {
        let (run, certificate) = (&history.run, history.certificate());
        let certified = certificate.is_some_and(|c| c.holds(&Limits::default()));
        let (status, mut reason) = match &run.ending {
            Ending::Complete => ("complete", String::new()),
            ending @ Ending::Interrupted { .. } => ("stopped", ending.to_string()),
            ending => ("failed", ending.to_string()),
        };
        if let Some(certificate) = certificate.filter(|_| !certified) {
            reason = format!("{reason} {}", not_held(&certificate));
        }
        let increments = increments(history);
        let most = |k: usize| increments.iter().map(|cost| cost[k]).max().unwrap_or(0);
        let sum = |k: usize| increments.iter().map(|cost| cost[k]).sum();
        Line {
            status,
            factor: run.factor,
            certified,
            energy: history.last().map_or(f64::NAN, |last| last.energy),
            increments: increments.len(),
            iterations: sum(0),
            factorisations: sum(1),
            most_iterations: most(0),
            most_factorisations: most(1),
            cuts: run.cuts(),
            ..Line::failed(reason.trim().to_string())
        }
    }

    fn is_good(&self) -> bool {
        self.status == "complete" && self.certified
    }
}

impl std::fmt::Display for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let certified = if self.certified { "yes" } else { "no" };
        let text = format!(
            "{} {}: {} at {:.4}, certified {certified}, energy {:.8e}, {} iterations, {} factorisations, {} cuts, {:.2} s  {}",
            self.scene,
            self.parameters,
            self.status,
            self.factor,
            self.energy,
            self.iterations,
            self.factorisations,
            self.cuts,
            self.seconds,
            self.reason
        );
        f.write_str(text.trim_end())
    }
}

/// Iterations and factorisations of each increment, its cuts included. The last increment may not have converged.
fn increments<const D: usize>(history: &History<D>) -> Vec<[usize; 2]> {
    let (mut all, mut now) = (Vec::new(), None);
    let mut steps = history.steps.iter();
    for attempt in &history.run.attempts {
        let [iterations, factorisations] = now.unwrap_or_default();
        let cost = attempt.cost;
        now = Some([
            iterations + cost.outer_iterations,
            factorisations + cost.factorizations,
        ]);
        let converged = attempt.outcome == Outcome::Converged;
        let step = if converged { steps.next() } else { None };
        if step.is_some_and(|step| step.increment.is_some()) {
            all.extend(now.take());
        }
    }
    all.extend(now);
    all
}

/// The conditions that do not hold.
fn not_held(certificate: &Certificate) -> String {
    let entries = certificate.entries(&Limits::default());
    let broken = entries.filter(|entry| !entry.holds());
    let broken = broken.map(|entry| {
        let value = entry.value.unwrap_or(f64::NAN);
        format!("{} {value:.1e} > {:.0e}", entry.name, entry.limit)
    });
    format!("certificate: {}", broken.collect::<Vec<_>>().join(", "))
}

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    files::make_folder(&arguments.out)?;
    std::panic::set_hook(Box::new(|_| {}));
    let mut sweep = Sweep {
        arguments,
        writer: csv::Writer::from_path(arguments.out.join("runs.csv"))?,
        lines: Vec::new(),
    };
    for kind in &arguments.scenes {
        match kind {
            Kind::Discs => sweep.discs()?,
            kind => sweep.variants(*kind)?,
        }
    }
    Ok(summary(arguments, &sweep.lines))
}

/// The runs so far.
struct Sweep<'a> {
    arguments: &'a Arguments,
    writer: csv::Writer<std::fs::File>,
    lines: Vec<(Kind, Line)>,
}

impl Sweep<'_> {
    fn discs(&mut self) -> Result<(), Failure> {
        let Arguments {
            swap, quadratic, ..
        } = *self.arguments;
        let orders: &[bool] = if swap { &[false, true] } else { &[false] };
        for n in self.arguments.meshes.clone().filter(|n| n % 2 == 0) {
            for &increments in &self.arguments.increments {
                for &swapped in orders {
                    let fineness = Fineness::scaled(n);
                    let roles = Roles {
                        swapped,
                        ..Roles::default()
                    };
                    let order = if quadratic { "quadratic" } else { "linear" };
                    let text = format!("n={n} increments={increments} {order} swapped={swapped}");
                    let scene = match quadratic {
                        true => disc_in_disc::quadratic_scene(fineness, roles),
                        false => disc_in_disc::scene(fineness, roles),
                    };
                    self.solve(Kind::Discs, text, scene, increments, &[])?;
                }
            }
        }
        Ok(())
    }

    fn variants(&mut self, kind: Kind) -> Result<(), Failure> {
        let Arguments { seed, cases, .. } = *self.arguments;
        let numbers = self.arguments.case.map_or(1..=cases, |case| case..=case);
        for number in numbers {
            self.variant(kind, number, &mut Random::of_case(seed, number))?;
        }
        Ok(())
    }

    fn variant(&mut self, kind: Kind, number: u64, random: &mut Random) -> Result<(), Failure> {
        match kind {
            Kind::Discs => Ok(()),
            Kind::Ironing => {
                let cells = around(random, 24);
                let order = self.arguments.order();
                let ironing = Ironing {
                    radius: near(random, 3.0),
                    young: near(random, 1000.0),
                    graded: random.between(-GRADED, GRADED),
                    ..Ironing::new(order, cells)
                };
                let text = format!(
                    "case={number} {order:?} cells={cells} radius={:.3} young={:.0} graded={:.3}",
                    ironing.radius, ironing.young, ironing.graded
                );
                let phases = ironing::phases(PRESS, INCREMENTS - PRESS);
                self.solve(kind, text, ironing.scene(), INCREMENTS, &phases)
            }
            Kind::Hairpin => {
                let hairpin = Hairpin {
                    arms: [[6, 14]; 2].map(|arm| arm.map(|cells| around(random, cells))),
                    fold: around(random, 8),
                    through: around(random, 2),
                    // beyond this the arms are flat on each other, and single nodes would be pressed into them
                    press: hairpin::PRESS * random.between(1.0 - SPREAD, 1.05),
                    poisson: near(random, hairpin::NU),
                };
                let text = format!(
                    "case={number} arms={:?} fold={} through={} press={:.3} nu={:.3}",
                    hairpin.arms, hairpin.fold, hairpin.through, hairpin.press, hairpin.poisson
                );
                self.solve(kind, text, hairpin.scene(), INCREMENTS, &[])
            }
            Kind::Arch => {
                let arch = Large {
                    along: around(random, 48),
                    across: around(random, 2),
                    push: near(random, arch::PUSH),
                    poisson: near(random, 0.3),
                };
                let text = format!(
                    "case={number} along={} across={} push={:.3} nu={:.3}",
                    arch.along, arch.across, arch.push, arch.poisson
                );
                self.solve(kind, text, arch.scene(), INCREMENTS, &[])
            }
            Kind::Beams => {
                let beams = Beams {
                    along: around(random, 8),
                    count: around(random, 3),
                    poisson: near(random, 0.2),
                    ..Beams::new(around(random, 2), Order::Linear, Law::NeoHookean)
                };
                let text = format!(
                    "case={number} along={} across={} count={} nu={:.3}",
                    beams.along, beams.across, beams.count, beams.poisson
                );
                self.solve(kind, text, beams.scene(), INCREMENTS, &[])
            }
            Kind::Wheel => {
                let wheel = Wheel {
                    around: 2 * around(random, 16),
                    layers: around(random, 4),
                    turned: random.between(0.0, 1.0),
                    cells: around(random, 30),
                    graded: random.between(-GRADED, GRADED),
                    quadratic: self.arguments.quadratic,
                };
                let text = format!(
                    "case={number} quadratic={} around={} layers={} turned={:.3} cells={} graded={:.3}",
                    wheel.quadratic,
                    wheel.around,
                    wheel.layers,
                    wheel.turned,
                    wheel.cells,
                    wheel.graded
                );
                let phases = wheel::phases(PRESS, ROLL);
                self.solve(kind, text, wheel.scene(), PRESS + ROLL, &phases)
            }
            Kind::Dies => {
                let (from, width) = (random.between(0.8, 1.4), random.between(0.8, 1.4));
                // half of them slide until half of the die is beyond the slab, the others until all of it is
                let end = if number % 2 == 0 {
                    3.3
                } else {
                    3.0 - 0.5 * width
                };
                let die = Die {
                    order: self.arguments.order(),
                    slab: [around(random, 12), around(random, 3)],
                    die: [around(random, 6), around(random, 3)],
                    from,
                    width,
                    // from twice to a hundred times as stiff as the slab
                    young: 20.0 * 50.0_f64.powf(random.between(0.0, 1.0)),
                    press: near(random, 0.07),
                    slide: end - from,
                };
                let text = format!(
                    "case={number} {:?} slab={:?} die={:?} from={from:.3} width={width:.3} young={:.0} press={:.3} slide={:.3}",
                    die.order, die.slab, die.die, die.young, die.press, die.slide
                );
                let phases = ironing::phases(PRESS, SLIDE);
                self.solve(kind, text, die.scene(), PRESS + SLIDE, &phases)
            }
        }
    }

    /// Runs a scene, and prints and writes its line.
    fn solve<const D: usize>(
        &mut self,
        kind: Kind,
        parameters: String,
        scene: Result<Scene<D>, Error>,
        increments: usize,
        phases: &[Phase],
    ) -> Result<(), Failure> {
        let clock = processor()?;
        let attempt = || self.history(scene, increments, phases);
        let line = match catch_unwind(AssertUnwindSafe(attempt)) {
            Ok(Ok(history)) => Line::of(&history),
            Ok(Err(error)) => Line::failed(error.to_string()),
            Err(_) => Line::failed("panic".into()),
        };
        let line = Line {
            scene: kind.to_string(),
            parameters,
            seconds: processor()? - clock,
            ..line
        };
        print(&line);
        self.writer.serialize(&line)?;
        self.writer.flush()?;
        self.lines.push((kind, line));
        Ok(())
    }

    fn history<const D: usize>(
        &self,
        scene: Result<Scene<D>, Error>,
        increments: usize,
        phases: &[Phase],
    ) -> Result<History<D>, Error> {
        let scene = self.arguments.points.of(scene?);
        let mut simulation = Simulation::with_increments(increments);
        simulation.load_steps.phases = phases.to_vec();
        simulation.load_steps.budget.seconds = Some(self.arguments.seconds);
        simulation.run(&mut scene.problem()?)
    }
}

/// A number near `middle`.
fn near(random: &mut Random, middle: f64) -> f64 {
    middle * random.between(1.0 - SPREAD, 1.0 + SPREAD)
}

/// A count near `middle`.
fn around(random: &mut Random, middle: usize) -> usize {
    near(random, middle as f64).round().max(1.0) as usize
}

/// Prints the table. The exit code tells whether enough runs of each scene are good.
fn summary(arguments: &Arguments, lines: &[(Kind, Line)]) -> ExitCode {
    let columns = [
        "scene",
        "runs",
        "complete",
        "certified",
        "both",
        "iterations / increment",
        "most",
        "factorisations / increment",
        "most",
        "cuts",
        "seconds",
    ];
    let mut table = Table::new("meshes", columns);
    table.quiet = true;
    let mut enough = true;
    for kind in &arguments.scenes {
        let lines = lines.iter().filter(|(of, _)| of == kind);
        let lines: Vec<&Line> = lines.map(|(_, line)| line).collect();
        let count = |is: &dyn Fn(&Line) -> bool| lines.iter().filter(|line| is(line)).count();
        let sum = |of: &dyn Fn(&Line) -> usize| lines.iter().map(|line| of(line)).sum::<usize>();
        let most = |of: &dyn Fn(&Line) -> usize| lines.iter().map(|line| of(line)).max();
        let increments = sum(&|line| line.increments) as f64;
        let mean = |of: &dyn Fn(&Line) -> usize| format!("{:.2}", sum(of) as f64 / increments);
        let good = count(&Line::is_good);
        enough &= good as f64 >= ENOUGH * lines.len() as f64;
        table.push(vec![
            kind.to_string(),
            lines.len().to_string(),
            count(&|line| line.status == "complete").to_string(),
            count(&|line| line.certified).to_string(),
            good.to_string(),
            mean(&|line| line.iterations),
            most(&|line| line.most_iterations).unwrap_or(0).to_string(),
            mean(&|line| line.factorisations),
            most(&|line| line.most_factorisations)
                .unwrap_or(0)
                .to_string(),
            sum(&|line| line.cuts).to_string(),
            format!("{:.1}", lines.iter().map(|line| line.seconds).sum::<f64>()),
        ]);
    }
    print(format_args!("\n{}", table.markdown().trim_end()));
    match enough {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

/// Seconds of the processor that this program has had.
fn processor() -> Result<f64, Failure> {
    let time = clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID)?;
    Ok(time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64)
}
