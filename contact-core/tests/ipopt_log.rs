//! The log: to the `log` crate, and nowhere else. Alone in its process, which has but one logger.
#![cfg(feature = "ipopt")]

use std::{
    env,
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    process::Command,
    sync::Mutex,
};

use contact_core::ipopt::{Options, Solver, Start, Status};
use problems::*;

struct Capture(Mutex<Vec<String>>);

static CAPTURE: Capture = Capture(Mutex::new(Vec::new()));

impl log::Log for Capture {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target() == "ipopt"
    }
    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            let line = record.args().to_string();
            assert!(!line.contains("MAKE THE LOGGER PANIC"));
            self.0.lock().unwrap().push(line);
        }
    }
    fn flush(&self) {}
}

fn logged(level: log::LevelFilter, print_level: i32) -> (Vec<String>, Option<usize>) {
    log::set_max_level(level);
    CAPTURE.0.lock().unwrap().clear();
    let options = Options::new()
        .with("print_level", print_level)
        .with("sb", "no");
    let solution = Solver::new(hs071_structure(), &options)
        .unwrap()
        .solve(&mut Hs071, &Start::at(&HS071_START))
        .unwrap();
    assert_eq!(solution.status, Status::Solved);
    (
        std::mem::take(&mut *CAPTURE.0.lock().unwrap()),
        solution.statistics.factorizations,
    )
}

#[test]
fn the_log_is_captured_and_counted() {
    log::set_logger(&CAPTURE).unwrap();
    let (lines, _) = logged(log::LevelFilter::Debug, 5);
    assert!(
        lines.iter().any(|line| line.starts_with("iter ")),
        "{lines:#?}"
    );
    assert!(
        lines
            .iter()
            .any(|line| line.starts_with("Number of Iterations....: 8")),
        "{lines:#?}"
    );
    assert!(
        lines.iter().all(|line| !line.contains('\n')),
        "one record a line"
    );
    let (few, _) = logged(log::LevelFilter::Debug, 0);
    assert!(
        few.len() < 20 && !few.iter().any(|line| line.starts_with("iter ")),
        "{few:#?}"
    );
    let (none, _) = logged(log::LevelFilter::Info, 5);
    assert_eq!(none, [""; 0], "not asked for");

    // The number of factorisations, counted independently in the log.
    let (all, factorizations) = logged(log::LevelFilter::Debug, 7);
    let calls = all
        .iter()
        .filter(|line| line.starts_with("Calling MUMPS-2"))
        .count();
    assert!(calls > 0);
    assert_eq!(factorizations, Some(calls));

    // A logger that panics is a callback that panics.
    let options = Options::new().with("print_level", 5);
    let mut solver = Solver::new(hs071_structure(), &options).unwrap();
    log::set_max_level(log::LevelFilter::Debug);
    let mut nlp = Watched::new(Hs071, |_| {
        log::debug!(target: "ipopt", "MAKE THE LOGGER PANIC");
        ControlFlow::Continue(())
    });
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        solver.solve(&mut nlp, &Start::at(&HS071_START))
    }));
    assert!(outcome.is_err());
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
}

/// Runs itself in a child to look at what the process prints.
#[test]
fn nothing_is_printed() {
    if env::var_os("IPOPT_LOG_CHILD").is_some() {
        let options = Options::new()
            .with("print_level", 12)
            .with("sb", "no")
            .with("print_timing_statistics", "yes")
            .with("derivative_test", "second-order");
        let mut solver = Solver::new(hs071_structure(), &options).unwrap();
        let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
        assert_eq!(solution.status, Status::Solved);
        assert!(Solver::new(hs071_structure(), &Options::new().with("tol", -1.0)).is_err());
        assert!(Solver::new(hs071_structure(), &Options::new().with("nonsense", 1)).is_err());
        return;
    }
    let output = Command::new(env::current_exe().unwrap())
        .args(["--exact", "nothing_is_printed", "--nocapture"])
        .env("IPOPT_LOG_CHILD", "1")
        .output()
        .unwrap();
    assert!(output.status.success());
    let printed = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    // What remains is the test harness's.
    assert!(printed.contains("1 passed"), "{printed}");
    for word in ["Ipopt", "ipopt", "iter", "option", "Number", "EXIT"] {
        assert!(!printed.contains(word), "{word:?} in:\n{printed}");
    }
}
