//! Runs five scenes with faults that are planted in the library, one at a time, and tells which condition of the certificate sees which.
//!
//! ```text
//! make planted
//! ```
//!
//! The faults are compiled in for this command alone (`--cfg planted`). Without them, the program runs the sound scenes. A fault that
//! changes energy or reactions by more than [`MATTERS`] must be seen, and sound scenes must show nothing; else the exit code is 1. With
//! `--tests`, the unit tests of the library run with each fault, too.
#![forbid(unsafe_code)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use contact_core::Phase;
#[cfg(planted)]
use contact_fem::certificate::Condition;
use contact_fem::certificate::{Certificate, Limits};
use contact_fem::element::Order;
use contact_fem::model::Integration;
use contact_fem::output::record::exit;
use contact_fem::simulation::History;
use contact_fem::{Error, Scene, Simulation};
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::blocks::Blocks;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::hertz::{self, Hertz};
use ipopt_contact_scenes::ironing::{self, Ironing};

/// A fault that changes energy or reactions by a larger share must be seen.
#[cfg_attr(not(planted), allow(dead_code))]
const MATTERS: f64 = 1e-4;

/// Faults that are planted in the library, and what sees them
#[derive(Parser, Debug)]
struct Arguments {
    /// Only the faults whose names contain this
    #[arg(long, default_value = "")]
    filter: String,
    /// The cheapest faults alone
    #[arg(long)]
    quick: bool,
    /// Show all residuals of the sound scenes
    #[arg(long)]
    values: bool,
    /// Run the unit tests with each fault, too
    #[arg(long)]
    tests: bool,
}

/// What came of one run.
struct Found {
    energy: f64,
    /// The norms of the reactions of all bodies.
    #[cfg_attr(not(planted), allow(dead_code))]
    reactions: Vec<f64>,
    /// The conditions that do not hold, or how the run ended.
    seen: Vec<String>,
    seconds: f64,
}

impl Found {
    fn of<const D: usize>(history: &History<D>, seconds: f64, values: bool) -> Self {
        let mut seen = Vec::new();
        if !history.is_complete() {
            seen.push("not complete".to_string());
        }
        if let Some(certificate) = history.certificate() {
            if values {
                println!("{certificate}");
            }
            let broken = certificate.entries(&Limits::default());
            let broken = broken.filter(|entry| !entry.holds());
            seen.extend(broken.map(|entry| entry.name.to_string()));
        }
        let last = history.last();
        Found {
            energy: last.map_or(f64::NAN, |last| last.energy),
            reactions: last.map_or(Vec::new(), |last| {
                last.reactions.iter().map(|force| force.norm()).collect()
            }),
            seen,
            seconds,
        }
    }

    #[cfg(planted)]
    /// The largest change of energy and reactions, as a share of the sound ones.
    fn apart(&self, sound: &Found) -> f64 {
        let most = sound.reactions.iter().copied().fold(0.0, f64::max);
        let reactions = self.reactions.iter().zip(&sound.reactions);
        let reactions = reactions.map(|(a, b)| (a - b).abs() / most);
        let energy = (self.energy - sound.energy).abs() / sound.energy.abs();
        let apart = reactions.fold(energy, f64::max);
        if apart.is_nan() { f64::INFINITY } else { apart }
    }
}

/// A scene runs by its name.
struct Case {
    name: &'static str,
    run: fn(bool) -> Result<Found, Error>,
}

const CASES: [Case; 5] = [
    Case {
        name: "discs",
        run: |values| {
            let scene = disc_in_disc::scene(Fineness::scaled(40), Roles::default())?;
            solve(scene, 8, &[], values)
        },
    },
    Case {
        name: "hertz",
        run: |values| {
            let hertz = Hertz::new(hertz::Fineness::family(5), Order::Linear);
            solve(hertz.scene()?, 1, &[], values)
        },
    },
    Case {
        name: "blocks",
        run: |values| {
            let blocks = Blocks {
                large_strains: true,
                ..Blocks::new([4, 5], Order::Quadratic, Integration::Exact)
            };
            solve(blocks.plane()?, 2, &[], values)
        },
    },
    Case {
        name: "ironing",
        run: |values| {
            let ironing = Ironing::new(Order::Linear, 24);
            solve(ironing.scene()?, 8, &ironing::phases(2, 6), values)
        },
    },
    Case {
        name: "beams",
        run: |values| {
            let beams = Beams::new(2, Order::Linear, Law::NeoHookean);
            solve(beams.scene()?, 2, &[], values)
        },
    },
];

/// The scene of which the certificate takes the largest share. No fault is planted in it.
const DEAREST: Case = Case {
    name: "quadratic beams",
    run: |values| {
        let beams = Beams::new(2, Order::Quadratic, Law::SmallStrain);
        solve(beams.scene()?, 1, &[], values)
    },
};

fn solve<const D: usize>(
    scene: Scene<D>,
    increments: usize,
    phases: &[Phase],
    values: bool,
) -> Result<Found, Error> {
    let clock = Instant::now();
    let mut problem = scene.problem()?;
    let mut simulation = match phases {
        [] => Simulation::with_increments(increments),
        phases => Simulation::in_phases(phases.iter().cloned()),
    };
    simulation.load_steps.budget.seconds = Some(LONGEST);
    let history = simulation.run(&mut problem)?;
    if let Some(solution) = history.run.solution.as_ref().filter(|_| values) {
        let run = clock.elapsed().as_secs_f64();
        let certify = |_| {
            let clock = Instant::now();
            std::hint::black_box(Certificate::new(&problem, solution));
            clock.elapsed().as_secs_f64()
        };
        let least = (0..CERTIFIED).map(certify).fold(f64::INFINITY, f64::min);
        println!(
            "the whole certificate takes {:.3} of the run of {:.1} ms",
            least / run,
            1e3 * run
        );
    }
    Ok(Found::of(&history, clock.elapsed().as_secs_f64(), values))
}

/// The certificate is computed so often where its cost is shown, and the least time counts.
const CERTIFIED: usize = 20;
/// A run that a fault leads astray is stopped after so many seconds.
const LONGEST: f64 = 5.0;

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

/// A run, whatever comes of it.
fn ran(case: &Case, values: bool) -> Found {
    let failed = |how: String| Found {
        energy: f64::NAN,
        reactions: Vec::new(),
        seen: vec![how],
        seconds: 0.0,
    };
    match catch_unwind(AssertUnwindSafe(|| (case.run)(values))) {
        Ok(Ok(found)) => found,
        Ok(Err(error)) => failed(format!("error: {error}")),
        Err(_) => failed("panic".to_string()),
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let mut sound = Vec::new();
    for case in CASES.iter().chain(arguments.values.then_some(&DEAREST)) {
        if arguments.values {
            println!("{}", case.name);
        }
        let found = ran(case, arguments.values);
        let (energy, seconds) = (found.energy, found.seconds);
        println!(
            "{}: energy {energy:.8e}, {seconds:.2} s {}",
            case.name,
            found.seen.join(", ")
        );
        sound.push(found);
    }
    let is_sound = sound.iter().all(|found| found.seen.is_empty());
    let missed = faults(arguments, &sound)?;
    Ok(match is_sound && missed == 0 {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// Without faults there is nothing to see.
#[cfg(not(planted))]
fn faults(arguments: &Arguments, _: &[Found]) -> Result<usize, Failure> {
    match arguments.quick || !arguments.filter.is_empty() {
        true => Err("the faults are compiled in by `make planted`".into()),
        false => Ok(0),
    }
}

/// What sees one fault.
#[cfg(planted)]
#[derive(Default)]
struct Seen {
    /// In how many runs it matters, and in how many of these nothing sees it.
    runs: [usize; 2],
    /// The largest change.
    most: f64,
    /// How often each condition saw it in a run in which it matters.
    by: std::collections::BTreeMap<String, usize>,
}

#[cfg(planted)]
impl Seen {
    fn add(&mut self, apart: f64, found: &Found) {
        self.most = self.most.max(apart);
        if apart <= MATTERS {
            return;
        }
        self.runs[0] += 1;
        self.runs[1] += usize::from(found.seen.is_empty());
        for name in &found.seen {
            let name = name.split(':').next().unwrap_or(name);
            *self.by.entry(name.to_string()).or_default() += 1;
        }
    }

    /// The names that `is_own` selects, each with its count.
    fn of(&self, is_own: impl Fn(&str) -> bool) -> String {
        let own = self.by.iter().filter(|(name, _)| is_own(name));
        let own: Vec<_> = own.map(|(name, count)| format!("{name} {count}")).collect();
        own.join(", ")
    }
}

/// The conditions that the audit judges.
#[cfg(planted)]
const OF_AUDIT: [&str; 5] = [
    "inverted",
    "small_strain",
    "overlap",
    "unopposed",
    "undeclared",
];

/// Plants one fault after the other, and returns in how many runs one that matters was not seen.
#[cfg(planted)]
fn faults(arguments: &Arguments, sound: &[Found]) -> Result<usize, Failure> {
    use contact_core::planted::{FAULTS, plant};
    use ipopt_contact_scenes::tables::Table;

    std::panic::set_hook(Box::new(|_| {}));
    let columns = [
        "area",
        "fault",
        "largest change",
        "runs that change",
        "unseen",
        "certificate",
        "audit",
        "how runs end",
        "unit tests",
    ];
    let mut table = Table::new("planted", columns);
    table.quiet = true;
    if arguments.tests {
        let sound = unit_tests(None)?;
        if sound != Tested::Passed {
            return Err(format!("without faults, the unit tests {sound}").into());
        }
    }
    let (mut missed, mut mattered, mut last) = (0, 0, "");
    for (number, [area, name]) in FAULTS.iter().enumerate() {
        let is_first = std::mem::replace(&mut last, area) != *area;
        if !name.contains(&arguments.filter) || (arguments.quick && !is_first) {
            continue;
        }
        let mut all = Seen::default();
        for (case, sound) in CASES.iter().zip(sound) {
            if arguments.quick && !QUICK.contains(&case.name) {
                continue;
            }
            plant(Some(number));
            let found = ran(case, arguments.values);
            plant(None);
            let apart = found.apart(sound);
            all.add(apart, &found);
            let verdict = match (apart > MATTERS, found.seen.is_empty()) {
                (true, true) => "MISSED",
                (true, false) => "",
                _ => "below what matters",
            };
            let seen = found.seen.join(", ");
            println!(
                "{area}: {name}, {}: {apart:.1e}, {seen} {verdict}",
                case.name
            );
        }
        mattered += all.runs[0];
        missed += all.runs[1];
        let tested = match arguments.tests {
            true => unit_tests(Some(name))?.to_string(),
            false => String::new(),
        };
        if arguments.tests {
            println!("{area}: {name}, unit tests: {tested}");
        }
        let is_condition = |name: &str| Condition::all().any(|own| own.name() == name);
        let is_of_audit = |name: &str| OF_AUDIT.contains(&name);
        table.push(vec![
            area.to_string(),
            name.to_string(),
            format!("{:.1e}", all.most),
            all.runs[0].to_string(),
            all.runs[1].to_string(),
            all.of(|name| is_condition(name) && !is_of_audit(name)),
            all.of(is_of_audit),
            all.of(|name| !is_condition(name)),
            tested,
        ]);
    }
    println!("\n{}", table.markdown());
    println!("{mattered} runs changed by more than {MATTERS:.0e}, {missed} of them unseen");
    Ok(missed)
}

/// What came of the unit tests.
#[cfg(planted)]
#[derive(Debug, PartialEq)]
enum Tested {
    Passed,
    /// So many failed.
    Failed(usize),
    /// They did not end, or not by themselves.
    Stopped,
}

#[cfg(planted)]
impl std::fmt::Display for Tested {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Tested::Passed => write!(f, "pass"),
            Tested::Failed(count) => write!(f, "{count} fail"),
            Tested::Stopped => write!(f, "do not end"),
        }
    }
}

/// The unit tests of the library with this fault are stopped after so many seconds.
#[cfg(planted)]
const TESTED: u64 = 600;

/// Parts of the names of the four tests that take longest, 90 s of 118 s of processor time. They are left out; three of them run the same checks
/// on segments, which stay.
#[cfg(planted)]
const LEFT_OUT: [&str; 3] = [
    "quadratic_triangles",
    "battery::linear_triangles",
    "the_nearest_of_all_facets",
];

/// Runs the unit tests of contact-core and contact-fem with this fault, or none.
#[cfg(planted)]
fn unit_tests(fault: Option<&str>) -> Result<Tested, Failure> {
    use std::process::{Command, Stdio};

    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_string());
    let mut command = Command::new("timeout");
    // the tests are built before the first run's time counts
    let build = [
        "test",
        "--lib",
        "-pcontact-core",
        "-pcontact-fem",
        "--features=contact-fem/record",
    ];
    let built = Command::new(&cargo).args(build).arg("--no-run").status()?;
    if !built.success() {
        return Err("the unit tests do not build".into());
    }
    command.arg(TESTED.to_string()).arg(&cargo).args(build);
    command.args(["--no-fail-fast", "--"]);
    command.args(LEFT_OUT.iter().flat_map(|test| ["--skip", test]));
    command.stderr(Stdio::null());
    if let Some(name) = fault {
        command.env(contact_core::planted::VARIABLE, name);
    }
    let output = command.output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut failed = 0;
    let results = text.lines().filter(|line| line.starts_with("test result:"));
    let results: Vec<&str> = results.collect();
    for line in &results {
        let count = line
            .split(';')
            .find_map(|part| part.trim().strip_suffix(" failed"));
        failed += count.map_or(Ok(0), str::parse::<usize>)?;
    }
    Ok(match (output.status.success(), results.len() == CRATES) {
        (true, true) => Tested::Passed,
        (false, true) if failed > 0 => Tested::Failed(failed),
        _ => Tested::Stopped,
    })
}

/// The crates whose unit tests run.
#[cfg(planted)]
const CRATES: usize = 2;

/// The scenes of `--quick`.
#[cfg(planted)]
const QUICK: [&str; 2] = ["discs", "hertz"];
