//! The log, to a writer of the caller's.
#![cfg(feature = "ipopt")]

use std::{
    env,
    io::{self, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    process::Command,
    sync::{Arc, Mutex},
};

use contact_core::ipopt::{Log, Options, Solution, Solver, Start, Status};
use problems::*;

/// Keeps what is written, and does something else at each write.
#[derive(Clone)]
struct Kept {
    text: Arc<Mutex<Vec<u8>>>,
    before: fn() -> io::Result<()>,
}

impl Kept {
    fn new(before: fn() -> io::Result<()>) -> Self {
        Self {
            text: Arc::default(),
            before,
        }
    }

    fn take(&self) -> String {
        String::from_utf8(std::mem::take(&mut *self.text.lock().unwrap())).unwrap()
    }
}

impl Write for Kept {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        (self.before)()?;
        // One byte at a time would be allowed too.
        let length = text.len().div_ceil(2);
        self.text.lock().unwrap().extend(&text[..length]);
        Ok(length)
    }
    fn flush(&mut self) -> io::Result<()> {
        (self.before)()
    }
}

fn solve(solver: &mut Solver) -> Solution {
    let solution = solver.solve(&mut Hs071, &Start::at(&HS071_START)).unwrap();
    assert_eq!(solution.status, Status::Solved);
    solution
}

/// The iterations in the table of the log.
fn rows(log: &str) -> Vec<usize> {
    log.lines()
        .filter_map(|line| line.split_whitespace().next()?.parse().ok())
        .collect()
}

#[test]
fn a_writer_gets_a_line_an_iteration_unless_told_otherwise() {
    let kept = Kept::new(|| Ok(()));
    let mut solver = hs071_solver!();
    solver.set_log(Log::writer(kept.clone()));
    let solution = solve(&mut solver);
    let log = kept.take();
    let iterations: Vec<usize> = (0..solution.history.len()).collect();
    assert_eq!(rows(&log), iterations, "{log}");
    assert!(
        log.contains("iter    objective") && log.contains("EXIT: Optimal"),
        "{log}"
    );
    assert_eq!(solution.log_error, None);

    solver.set_options(&Options::new().print_level(3)).unwrap();
    solve(&mut solver);
    let log = kept.take();
    assert!(
        rows(&log).is_empty() && log.contains("EXIT: Optimal"),
        "{log}"
    );

    solver.set_options(&Options::new()).unwrap();
    solve(&mut solver);
    assert_eq!(rows(&kept.take()), iterations, "5 again");
    solver.set_log(Log::Off);
    solve(&mut solver);
    assert_eq!(kept.take(), "");
}

#[test]
fn a_text_has_the_log_since_the_last_time() {
    let (log, text) = Log::text();
    let mut solver = hs071_solver!();
    solver.set_log(log);
    assert_eq!(text.take(), "");
    let solution = solve(&mut solver);
    let first = text.take();
    assert_eq!(rows(&first).len(), solution.history.len(), "{first}");
    assert_eq!(text.take(), "");
    solve(&mut solver);
    assert_eq!(rows(&text.clone().take()), rows(&first));
    drop(solver);
    assert_eq!(text.take(), "");
}

#[test]
fn a_writer_that_fails_is_reported_and_stops_nothing() {
    let kept = Kept::new(|| Err(io::Error::new(io::ErrorKind::StorageFull, "disk full")));
    let mut solver = hs071_solver!();
    solver.set_log(Log::writer(kept.clone()));
    let error = solve(&mut solver).log_error.unwrap();
    assert_eq!(error.kind, io::ErrorKind::StorageFull);
    assert!(error.to_string().contains("disk full"));
    assert_eq!(kept.take(), "");
    // The next solve tries again.
    solver.set_log(Log::writer(Kept::new(|| Ok(()))));
    assert_eq!(solve(&mut solver).log_error, None);
}

fn panicking() -> Log {
    Log::writer(Kept::new(|| panic!("from the writer")))
}

#[test]
fn a_writer_that_panics_is_a_callback_that_panics() {
    let mut solver = hs071_solver!();
    solver.set_log(panicking());
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        solver.solve(&mut Hs071, &Start::at(&HS071_START))
    }));
    let payload = outcome.unwrap_err();
    assert_eq!(payload.downcast_ref(), Some(&"from the writer"));
    let kept = Kept::new(|| Ok(()));
    solver.set_log(Log::writer(kept.clone()));
    solve(&mut solver);
    assert!(
        !rows(&kept.take()).is_empty(),
        "the solver is as good as new"
    );
}

/// Runs itself in a child to look at what the process prints.
#[test]
fn standard_output_stays_empty() {
    if env::var_os("IPOPT_WRITER_CHILD").is_some() {
        let mut solver = Solver::new(hs071_structure(), &Options::new().print_level(12)).unwrap();
        let kept = Kept::new(|| Ok(()));
        solver.set_log(Log::writer(kept.clone()));
        solve(&mut solver);
        assert!(kept.take().len() > 10_000, "level 12 is much");
        solver.set_log(panicking());
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            solver.solve(&mut Hs071, &Start::at(&HS071_START))
        }));
        assert!(outcome.is_err());
        return;
    }
    let output = Command::new(env::current_exe().unwrap())
        .args(["--exact", "standard_output_stays_empty", "--nocapture"])
        .env("IPOPT_WRITER_CHILD", "1")
        .output()
        .unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && printed.contains("1 passed"),
        "{printed}"
    );
    // What remains is the test harness's.
    for word in ["Ipopt", "iter", "EXIT", "objective", "MUMPS"] {
        assert!(!printed.contains(word), "{word:?} in:\n{printed}");
    }
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(
        errors.contains("from the writer") && !errors.contains("objective"),
        "{errors}"
    );
}
