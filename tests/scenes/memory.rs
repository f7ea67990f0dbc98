//! Runs with too little memory: they say so before they begin, and neither hang nor end the process.

use std::env;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use contact_core::memory::{self, MemoryLimit};
use contact_core::{Budget, Ending, Error, MemoryError, MemoryNeed};
use contact_fem::element::Order;
use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::{Error as FemError, Simulation};
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::cli::Solver as Choice;
use ipopt_contact_scenes::disc_in_disc::Roles;

use crate::common::disc_in_disc;

/// In the processes that the test starts: the scene and the solver.
const ORDER: &str = "IPOPT_CONTACT_MEMORY_ORDER";
const SOLVERS: [Choice; 3] = [Choice::Newton, Choice::Ipopt, Choice::Condensed];

fn beams() -> Problem<3> {
    let beams = Beams::new(2, Order::Quadratic, Law::SmallStrain);
    beams.scene().expect("a scene").problem().expect("valid")
}

fn run<const D: usize>(
    solver: Choice,
    memory: Option<u64>,
    problem: &mut Problem<D>,
) -> Result<History<D>, FemError> {
    let mut simulation = Simulation::solved_by(solver.with_tolerance(None), 2);
    simulation.load_steps.budget = Budget {
        memory,
        ..Budget::default()
    };
    simulation.run(problem)
}

fn need<const D: usize>(solver: Choice, problem: &Problem<D>) -> MemoryNeed {
    let need = solver.with_tolerance(None).memory(problem);
    need.expect("an estimate")
}

/// The estimate is at least what the factor takes, and no more than a few times that and a kilobyte or two an unknown.
#[test]
fn estimates_are_of_the_size_of_the_factor() {
    for solver in SOLVERS {
        let estimate = need(solver, &beams());
        let history = run(solver, None, &mut beams()).expect("memory");
        assert_eq!(history.run.ending, Ending::Complete);
        let factor = history.run.cost().factor.expect("a factor");
        let taken = factor.workspace_bytes.unwrap_or(factor.bytes);
        let ratio = estimate.factor as f64 / taken as f64;
        assert!(
            (0.5..4.0).contains(&ratio),
            "{solver}: {estimate} {factor:?}"
        );
        assert!(estimate.bytes > estimate.factor, "{solver}: {estimate}");
    }
}

#[test]
fn a_run_beyond_its_budget_is_not_begun() {
    for solver in SOLVERS {
        let mut problem = beams();
        let needed = need(solver, &problem).bytes;
        let allowed = needed / 2;
        match run(solver, Some(allowed), &mut problem) {
            Err(FemError::Core(Error::Memory(MemoryError::TooLittle {
                what,
                needed: told,
                left,
                limit,
            }))) => {
                assert_eq!((left, limit), (allowed, MemoryLimit::Budget));
                assert!(told > allowed && told <= needed, "{told} {needed}");
                assert_eq!(what, solver.to_string());
            }
            other => panic!("{solver}: {other:?}"),
        }
    }
}

/// What the other processes run; without an order there is nothing to do.
#[test]
fn obey() {
    let Ok(order) = env::var(ORDER) else { return };
    let (scene, solver) = order.split_once(' ').expect("two words");
    let solver = SOLVERS.into_iter().find(|s| s.to_string() == solver);
    let solver = solver.expect("a solver");
    let ended = match scene {
        "discs" => {
            let mut problem = disc_in_disc(32, Roles::default());
            tell_size();
            run(solver, None, &mut problem).map(|history| history.run.ending)
        }
        _ => {
            let mut problem = beams();
            tell_size();
            run(solver, None, &mut problem).map(|history| history.run.ending)
        }
    };
    match ended {
        Ok(Ending::Complete) => println!("\nended: complete"),
        Err(FemError::Core(why)) if why.memory().is_some() => println!("\nended: memory: {why}"),
        Ok(Ending::Failed { at, why }) => println!("\nended: failed beyond {at}: {why}"),
        other => println!("\nended: otherwise: {other:?}"),
    }
}

/// The size of this process, for limits a little above it.
fn tell_size() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let size = status.lines().find(|line| line.starts_with("VmSize:"));
    println!("\n{}", size.unwrap_or("VmSize: 0 kB"));
}

/// What a process says that runs `order` within so many kilobytes; `None` if it does not end.
fn said(order: &str, kilobytes: Option<u64>) -> Option<String> {
    let limit = kilobytes.map_or("unlimited".to_string(), |k| k.to_string());
    let program = env::current_exe().expect("a test program");
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v $0 && exec \"$@\"", &limit])
        .arg(program)
        .args(["memory::obey", "--exact", "--nocapture", "--test-threads=1"])
        .env(ORDER, order)
        .env("OPENBLAS_NUM_THREADS", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let end = Instant::now() + Duration::from_secs(60);
    while child.try_wait().expect("a child").is_none() {
        if Instant::now() > end {
            child.kill().expect("a child");
            return None;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().expect("a child");
    let text = [output.stdout, output.stderr].concat();
    Some(String::from_utf8_lossy(&text).into_owned())
}

/// Ten limits of the address space above what the process has once its scene is there: a run completes, or says before its
/// first load step that memory is what it lacks.
#[test]
fn under_a_limit_a_run_completes_or_names_memory() {
    if memory::left().is_none() {
        return; // not Linux
    }
    let orders = [
        "discs newton",
        "discs ipopt",
        "beams condensed",
        "beams ipopt",
    ];
    for order in orders {
        let free = said(order, None).expect("it ends");
        assert!(free.contains("ended: complete"), "{order}: {free}");
        let size = free.lines().find_map(|line| line.strip_prefix("VmSize:"));
        let size = size.and_then(|size| size.trim().trim_end_matches("kB").trim().parse().ok());
        let size: u64 = size.expect("a size");
        let mut last = "";
        for more in [8, 16, 32, 64, 96, 128, 160, 256, 512, 1024] {
            let text = said(order, Some(size + 1024 * more));
            let text = text.unwrap_or_else(|| panic!("{order} with {more} MB hangs"));
            last = match text.lines().find_map(|line| line.strip_prefix("ended: ")) {
                Some(end) if end.starts_with("memory: ") => "memory",
                Some("complete") => "complete",
                _ => panic!("{order} with {more} MB: {text}"),
            };
        }
        assert_eq!(last, "complete", "{order} with a gigabyte");
    }
}
