//! What the driver adds to Ipopt: one problem with trivial functions and 100 000 variables, solved through
//! [`contact_core::ipopt`], by a C program through `IpStdCInterface.h`, and by a C++ program through `TNLP`.
//!
//! ```text
//! cargo bench -p contact-core --bench overhead
//! cargo bench -p contact-core --bench overhead -- 15
//! ```
//!
//! The number is how often; 9 unless given. Every solve is a process of its own, the three take turns, and all get the
//! same options. Counted is processor time from the problem's data to its solution: set-up, solve and release. The
//! exit status is not 0 unless all three take as many iterations to the same objective, and the driver adds less than
//! 5 % to the fastest runs of its rivals.
#![allow(unsafe_code)] // raw bindings

use std::{
    env,
    error::Error,
    ffi::c_long,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use contact_core::{
    ipopt::{OptionValue, Options, Solver, Start},
    nlp::{Bounds, Nlp, Pattern, Structure},
};

const N: usize = 100_000;
const WIDTH: usize = 20;
const M: usize = N / WIDTH;

/// Those the driver sets by default, too, so that its rivals have them, as overhead.h reads them: kind, name, value.
/// The ordering is AMD (0), which every MUMPS has and which has no threads: those of SCOTCH wait in a loop, and how long
/// is chance.
const OPTIONS: [&str; 13] = [
    "s:option_file_name=",
    "i:print_level=0",
    "s:sb=yes",
    "s:linear_solver=mumps",
    "n:tol=1e-8",
    "n:bound_relax_factor=0",
    "i:mumps_mem_percent=200",
    "i:mumps_pivot_order=0",
    "s:hessian_approximation=exact",
    "s:hessian_constant=no",
    "s:jac_c_constant=no",
    "s:jac_d_constant=no",
    "s:warm_start_init_point=no",
];
/// The share of a rival's fastest run that the driver may add.
const MAY_ADD: f64 = 0.05;
/// Since 3.14.
const TIMING: &str = "s:timing_statistics=yes";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// min Σ (xᵢ − cᵢ)²/2 + xᵢ⁴/4 subject to sums of 20 neighbours ≤ 5 and 0 ≤ x ≤ 1; line for line as in overhead.h.
struct Trivial {
    c: Vec<f64>,
}

impl Nlp for Trivial {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let mut sum = 0.0;
        for (x, c) in x.iter().zip(&self.c) {
            let d = x - c;
            sum += 0.5 * d * d + 0.25 * x * x * x * x;
        }
        sum
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        for ((value, x), c) in gradient.iter_mut().zip(x).zip(&self.c) {
            *value = (x - c) + x * x * x;
        }
    }

    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        for (value, x) in g.iter_mut().zip(x.chunks_exact(WIDTH)) {
            *value = x.iter().fold(0.0, |sum, x| sum + x);
        }
    }

    fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
        values.fill(1.0);
    }

    fn hessian(&mut self, x: &[f64], _: bool, factor: f64, _: &[f64], values: &mut [f64]) {
        for (value, x) in values.iter_mut().zip(x) {
            *value = factor * (1.0 + 3.0 * x * x);
        }
    }
}

/// One solve, as a process tells of it.
#[derive(Clone, Copy)]
struct Run {
    seconds: f64,
    status: i32,
    iterations: i32,
    objective: f64,
}

impl Run {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        Some(Self {
            seconds: words.next()?.parse().ok()?,
            status: words.next()?.parse().ok()?,
            iterations: words.next()?.parse().ok()?,
            objective: words.next()?.parse().ok()?,
        })
    }

    fn of(program: &Path, arguments: &[&str]) -> Result<Self> {
        let output = Command::new(program).args(arguments).output()?;
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        let run = printed.lines().last().and_then(Self::parse);
        run.filter(|_| output.status.success()).ok_or_else(|| {
            let errors = String::from_utf8_lossy(&output.stderr);
            let program = program.display();
            format!("{program}: {}: {printed}{errors}", output.status).into()
        })
    }
}

/// Processor time of this process, as `clock` in the rivals.
fn cpu_seconds() -> f64 {
    unsafe extern "C" {
        safe fn clock() -> c_long;
    }
    // CLOCKS_PER_SEC is a million on every Unix.
    clock() as f64 / 1e6
}

fn options(arguments: &[String]) -> Result<Options> {
    let mut options = Options::new();
    for argument in arguments {
        let (kind, rest) = argument.split_once(':').ok_or("no kind")?;
        let (name, value) = rest.split_once('=').ok_or("no value")?;
        let value = match kind {
            "i" => OptionValue::Integer(value.parse()?),
            "n" => OptionValue::Number(value.parse()?),
            _ => OptionValue::Text(value.to_owned()),
        };
        options.set(name, value);
    }
    Ok(options)
}

/// What the child process does.
fn solve(arguments: &[String]) -> Result<Run> {
    let c = (0..N).map(|i| (i * 7919 % 1000) as f64 / 500.0 - 0.5);
    let mut nlp = Trivial { c: c.collect() };
    let x = vec![0.2; N];
    let (bounds, limits) = (
        Bounds::uniform(N, 0.0, 1.0),
        Bounds::uniform(M, f64::NEG_INFINITY, 5.0),
    );
    let start = cpu_seconds();
    let jacobian: Pattern = (0..N).map(|k| (k / WIDTH, k)).collect();
    let structure = Structure::new(bounds, limits, jacobian, Some(Pattern::diagonal(N)))?;
    let mut solver = Solver::new(structure, &options(arguments)?)?;
    let solution = solver.solve(&mut nlp, &Start::at(&x))?;
    drop(solver);
    Ok(Run {
        seconds: cpu_seconds() - start,
        status: solution.status.code(),
        iterations: i32::try_from(solution.statistics.iterations)?,
        objective: solution.objective,
    })
}

fn pkg_config(argument: &str) -> Result<String> {
    let output = Command::new("pkg-config")
        .args([argument, "ipopt"])
        .output()?;
    if !output.status.success() {
        return Err(format!("pkg-config {argument} ipopt: {}", output.status).into());
    }
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

/// Compiles a rival with the flags of the release profile.
fn compile(variable: &str, default: &str, source: &str, name: &str) -> Result<PathBuf> {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let program = directory.join(name);
    let library = pkg_config("--variable=libdir")?;
    let compiler = env::var(variable).unwrap_or_else(|_| default.to_owned());
    let status = Command::new(&compiler)
        .args(["-O3", "-DNDEBUG", "-w", "-o"])
        .arg(&program)
        .arg(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("benches")
                .join(source),
        )
        .args(pkg_config("--cflags")?.split_whitespace())
        .args([format!("-L{library}"), format!("-Wl,-rpath,{library}")])
        .args(["-lipopt", "-lm"])
        .status()?;
    if !status.success() {
        return Err(format!("{compiler} {source}: {status}").into());
    }
    Ok(program)
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() % 2 {
        0 => 0.5 * (sorted[half - 1] + sorted[half]),
        _ => sorted[half],
    }
}

/// Prints the median of the ratios of runs next to each other in time, with their range, and gives the ratio of the
/// fastest runs: what disturbs a run only makes it slower.
fn compare(name: &str, runs: &[Run], rival: &str, others: &[Run]) -> f64 {
    let ratios: Vec<f64> = runs
        .iter()
        .zip(others)
        .map(|(a, b)| a.seconds / b.seconds)
        .collect();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(0.0, f64::max);
    let fastest = |runs: &[Run]| {
        runs.iter()
            .map(|run| run.seconds)
            .fold(f64::INFINITY, f64::min)
    };
    let ratio = fastest(runs) / fastest(others);
    println!(
        "{name} / {rival}: {ratio:.3} of the fastest, median {:.3}, from {least:.3} to {most:.3}",
        median(&ratios)
    );
    ratio
}

fn bench(repetitions: usize) -> Result<ExitCode> {
    let names = ["Rust", "C", "C++"];
    let programs = [
        env::current_exe()?,
        compile("CC", "cc", "overhead.c", "overhead_c")?,
        compile("CXX", "c++", "overhead.cpp", "overhead_cpp")?,
    ];
    let version = pkg_config("--modversion")?;
    let mut arguments = OPTIONS.to_vec();
    let minor = version
        .split('.')
        .nth(1)
        .and_then(|minor| minor.parse().ok());
    if minor.is_some_and(|minor: u32| minor >= 14) {
        arguments.push(TIMING);
    }
    println!("Ipopt {version}, {N} variables, {M} constraints, {repetitions} solves each");

    let mut runs: [Vec<Run>; 3] = Default::default();
    for turn in 0..repetitions {
        for k in 0..3 {
            // None always comes first.
            let which = (turn + k) % 3;
            let mut own = arguments.clone();
            if which == 0 {
                own.insert(0, "solve");
            }
            runs[which].push(Run::of(&programs[which], &own)?);
        }
    }
    let first = runs[0][0];
    let mut agree = true;
    for (name, runs) in names.iter().zip(&runs) {
        let seconds: Vec<f64> = runs.iter().map(|run| run.seconds).collect();
        let last = runs[runs.len() - 1];
        println!(
            "{name:>4}: {:.3} s of processor time (median), status {}, {} iterations, objective {:.12e}",
            median(&seconds),
            last.status,
            last.iterations,
            last.objective
        );
        agree &= runs.iter().all(|run| {
            run.status == 0
                && run.iterations == first.iterations
                && (run.objective - first.objective).abs() <= 1e-12 * first.objective.abs()
        });
    }
    compare("C++", &runs[2], "C", &runs[1]);
    let overhead = [1, 2].map(|k| compare("Rust", &runs[0], names[k], &runs[k]) - 1.0);
    let most = overhead[0].max(overhead[1]);
    let below = most < MAY_ADD;
    println!(
        "The driver adds {:.1} % to the fastest runs ({} the {:.0} % it may)",
        100.0 * most,
        if below { "below" } else { "ABOVE" },
        100.0 * MAY_ADD
    );
    if !agree {
        eprintln!("error: status, iterations or objective differ");
    }
    if !below {
        eprintln!("error: the driver adds more than it may");
    }
    Ok(match agree && below {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

fn main() -> Result<ExitCode> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let Some((first, rest)) = arguments.split_first() {
        if first == "solve" {
            let run = solve(rest)?;
            println!(
                "{:.9} {} {} {:.17e}",
                run.seconds, run.status, run.iterations, run.objective
            );
            return Ok(ExitCode::SUCCESS);
        }
    }
    let repetitions = arguments.iter().find_map(|argument| argument.parse().ok());
    bench(repetitions.unwrap_or(9).max(1))
}
