//! `Condensed` against the floor of every linear solution, with or without contact: one analysis, one LLᵀ and one solve
//! of the stiffness.
//!
//! ```text
//! cargo bench --bench condensed --features metis
//! cargo bench --bench condensed --features metis -- --only Hertz
//! ```
//!
//! Seconds are those of one thread's processor. Bodies that float are factored with 1e-6 of their diagonal added.

use std::process::ExitCode;

use clap::Parser;
use ipopt_contact::contact_core::equilibrium::{Condensed, Solution};
use ipopt_contact::contact_core::linear::{
    Analysis, Cholesky, Factor, Kind, Ordering, SymmetricPattern,
};
use ipopt_contact::contact_core::{ContactProblem, Cost, Energy, LoadStepped, State};
use ipopt_contact::contact_fem::element::Order;
use ipopt_contact::contact_fem::output::record::exit;
use ipopt_contact::prelude::*;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::hertz::{Fineness, Hertz};
use ipopt_contact_scenes::{Failure, cantilevers, tight};

/// Times the static condensation
#[derive(Parser, Debug)]
struct Arguments {
    /// Only the scenes with this in their name
    #[arg(long, default_value = "")]
    only: String,
    /// What `cargo bench` passes; without it, as from `cargo test`, a tiny run shows that it works
    #[arg(long, hide = true)]
    bench: bool,
}

const HEADER: &str = "\
scene                        free dofs  rows  set-up s  floor s   solve s  ratio  rows' s  factor-  problems  Newton  certi-  energy
                                                                                            isations           steps  ficate";

fn main() -> ExitCode {
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    println!("{HEADER}");
    let wanted = |name: &str| name.contains(&arguments.only);
    if !arguments.bench {
        return measure("cantilevers 4×2×2", 2, || cantilevers::scene([4, 2, 2]));
    }
    for (name, across, along, order) in [
        ("beams P2 4×16", 4, 16, Order::Quadratic),
        ("beams P2 6×20", 6, 20, Order::Quadratic),
        ("beams P1 10×80", 10, 80, Order::Linear),
    ] {
        let beams = Beams {
            along,
            ..Beams::new(across, order, Law::SmallStrain)
        };
        if wanted(name) {
            measure(name, 1, || beams.scene())?;
        }
    }
    let hertz =
        |in_contact: f64, on_arc| Hertz::new(Fineness { in_contact, on_arc }, Order::Linear);
    if wanted("Hertz, 23 600 unknowns") {
        measure("Hertz, 23 600 unknowns", 1, || hertz(42.0, 95).scene())?;
    }
    for cells in [[10, 4, 4], [20, 8, 8], [27, 11, 11], [48, 16, 16]] {
        let name = format!("cantilevers {}×{}×{}", cells[0], cells[1], cells[2]);
        if wanted(&name) {
            measure(&name, 1, || cantilevers::scene(cells))?;
        }
    }
    if wanted("cantilevers, 100 steps") {
        measure("cantilevers, 100 steps", 100, || {
            cantilevers::scene([20, 8, 8])
        })?;
    }
    if wanted("Hertz, 100 steps") {
        measure("Hertz, 100 steps", 100, || hertz(60.0, 146).scene())?;
    }
    Ok(())
}

fn measure<const D: usize>(
    name: &str,
    increments: usize,
    scene: impl Fn() -> Result<Scene<D>, ipopt_contact::contact_fem::Error>,
) -> Result<(), Failure> {
    let clock = processor_seconds();
    let mut problem = scene()?.problem()?;
    let set_up = processor_seconds() - clock;
    problem.set_load(1.0)?;
    let floor = floor(problem.energy())?;
    let (mut cost, mut solution) = (Cost::default(), None::<Solution>);
    let prepare = || Ok(scene()?.problem()?);
    let seconds = mean(prepare, |problem| {
        let mut solver = Condensed::new();
        let mut at = State {
            u: vec![0.0; problem.energy().dofs()],
            ..State::default()
        };
        cost = Cost::default();
        for k in 1..=increments {
            problem.set_load(k as f64 / increments as f64)?;
            let step = solver.solve_from(problem, at)?;
            cost += step.cost();
            at = step.state.clone();
            let has_converged = step.outcome == Outcome::Converged;
            solution = Some(step);
            if !has_converged {
                break;
            }
        }
        Ok(())
    })?;
    let solution = solution.ok_or("no increment")?;
    if solution.outcome != Outcome::Converged {
        println!("{name:<27} {}", solution.outcome);
        return Ok(());
    }
    let certificate = Certificate::new(&problem, &solution);
    println!(
        "{name:<27} {:>10} {:>5} {set_up:>9.2} {floor:>8.3} {seconds:>9.3} {:>6.2} {:>8.3} {:>9} {:>9} {:>7} {:>7} {:.9e}",
        problem.dofs().free(),
        solution.gaps.len(),
        seconds / floor,
        cost.projection,
        cost.factorizations,
        cost.solves,
        cost.inner_iterations,
        match certificate.holds(&tight()) {
            true => "holds",
            false => "FAILS",
        },
        solution.energy,
    );
    for entry in certificate.entries(&tight()).filter(|entry| !entry.holds()) {
        println!(
            "    {} {:.1e} beyond {:.1e}",
            entry.name,
            entry.value.unwrap_or(f64::NAN),
            entry.limit
        );
    }
    Ok(())
}

/// Seconds for analysis, LLᵀ and one solve.
fn floor(energy: &dyn Energy) -> Result<f64, Failure> {
    let (n, pattern) = (energy.dofs(), energy.hessian_pattern());
    let mut values = vec![0.0; pattern.len()];
    energy.hessian(&vec![0.0; n], &mut values);
    let entries: Vec<_> = pattern.iter().collect();
    // a pattern keeps its analysis
    let fresh = || Ok(SymmetricPattern::from_entries(n, &entries)?.0);
    let once = |pattern: &SymmetricPattern, values: &[f64]| -> Result<(), Failure> {
        let analysis = Analysis::new(pattern, &Ordering::Automatic)?;
        let mut factor = Cholesky::new(&analysis, Kind::Llt)?;
        factor.refactor(values)?;
        Ok(factor.solve(&mut vec![1.0; n])?)
    };
    if once(&fresh()?, &values).is_err() {
        for (value, (i, j)) in values.iter_mut().zip(pattern.iter()) {
            *value *= if i == j { 1.0 + 1e-6 } else { 1.0 };
        }
    }
    mean(fresh, |pattern| once(pattern, &values))
}

/// The mean of the seconds that it takes with what was prepared, repeated until the clock's resolution is small beside
/// their sum.
fn mean<T>(
    prepare: impl Fn() -> Result<T, Failure>,
    mut run: impl FnMut(&mut T) -> Result<(), Failure>,
) -> Result<f64, Failure> {
    let mut sum = 0.0;
    for count in 1.. {
        let mut prepared = prepare()?;
        let clock = processor_seconds();
        run(&mut prepared)?;
        sum += processor_seconds() - clock;
        if !(sum < 0.2) {
            return Ok(sum / f64::from(count));
        }
    }
    Ok(f64::NAN)
}

/// What this thread has had of a processor (s).
fn processor_seconds() -> f64 {
    let times = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = times
        .split(' ')
        .next()
        .and_then(|time| time.parse::<f64>().ok());
    nanoseconds.map_or(f64::NAN, |time| 1e-9 * time)
}
