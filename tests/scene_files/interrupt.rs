//! Ctrl-C in the middle of a run, or a budget that is spent there: the run ends cleanly, and all its files can be read.

use std::path::Path;
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio, Termination};
use std::time::{Duration, Instant};

use ipopt_contact::contact_core::Budget;
use ipopt_contact::prelude::*;
use ipopt_contact::scene_file::SceneFile;
use vtkio::model::{DataSet, Piece, Vtk};

const SCENE: &str = "examples/disc_in_disc.toml";
/// Far more increments than the run gets to do.
const INCREMENTS: usize = 5000;
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn an_interrupted_run_leaves_readable_files() {
    let folder = crate::fresh("interrupt");
    let mut run = Run::start(&folder);
    let steps = folder.join("disc_in_disc.csv");
    run.wait_until(|| lines(&steps) > 4);
    run.interrupt();
    assert_eq!(run.wait().code(), Some(130), "exit code");

    let finished = check_tables(&folder);
    assert!((4..INCREMENTS).contains(&finished), "{finished} increments");
    check_series(&folder, finished);
    check_summary(&folder, finished);
}

#[test]
fn a_run_that_has_spent_its_budget_ends_likewise() {
    let folder = crate::fresh("budget");
    let file = SceneFile::read(crate::root().join(SCENE)).expect("a scene");
    let mut simulation = Simulation::with_increments(20);
    simulation.load_steps.budget = Budget {
        factorizations: Some(5),
        ..Budget::default()
    };
    let mut problem = file.problem::<2>().expect("a problem");
    let mut recording = simulation.record(&folder);
    recording.plan.name = "disc_in_disc".into();
    recording.plan.quiet = true;
    let recorded = recording.run(&mut problem).expect("a run");
    assert!(!recorded.history.is_complete());
    assert_eq!(recorded.report(), ExitCode::from(130));
    let finished = check_tables(&folder);
    assert!((1..20).contains(&finished), "{finished} increments");
    check_series(&folder, finished);
    check_summary(&folder, finished);
}

/// The number of converged steps in the table.
fn check_tables(folder: &Path) -> usize {
    let (columns, steps) = table(&folder.join("disc_in_disc.csv"));
    let column = |name: &str| {
        let found = columns.iter().position(|column| column == name);
        found.unwrap_or_else(|| panic!("a column `{name}` in {columns:?}"))
    };
    let outcome = |line: &&Vec<String>| line[column("outcome")] == "converged";
    let converged: Vec<_> = steps.iter().filter(outcome).collect();
    for (k, line) in converged.iter().enumerate() {
        assert_eq!(line[column("increment")], (k + 1).to_string());
        for name in ["energy", "min_j", "reaction_ring_y", "seconds_total"] {
            let value: Result<f64, _> = line[column(name)].parse();
            assert!(value.is_ok(), "{name} of step {k}: {value:?}");
        }
    }
    let (_, iterations) = table(&folder.join("disc_in_disc_iterations.csv"));
    assert!(iterations.len() >= converged.len());
    converged.len()
}

/// The header and the lines; the reader checks that all have the same number of fields.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let words = |record: &csv::StringRecord| record.iter().map(str::to_string).collect();
    let header = words(reader.headers().expect("a header"));
    let lines = reader.records().map(|line| words(&line.expect("a line")));
    (header, lines.collect())
}

/// The state at rest and one file for each finished increment, all of them listed.
fn check_series(folder: &Path, finished: usize) {
    let listing = std::fs::read_to_string(folder.join("disc_in_disc.pvd")).expect("a .pvd file");
    assert!(listing.ends_with("</VTKFile>\n"));
    let files: Vec<&str> = listing
        .split("file=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    assert_eq!(files.len(), finished + 1);
    for file in files {
        let grid = Vtk::import(folder.join(file)).expect("a .vtu file");
        let DataSet::UnstructuredGrid { pieces, .. } = grid.data else {
            panic!("{file} is not an unstructured grid");
        };
        let Some(Piece::Inline(piece)) = pieces.first() else {
            panic!("{file} has no data");
        };
        assert_eq!(piece.num_points(), 885, "{file}");
        assert_eq!(piece.cells.num_cells(), 1588, "{file}");
    }
}

fn check_summary(folder: &Path, finished: usize) {
    let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(summary["converged"], false);
    assert_eq!(summary["steps"], finished);
    assert!(summary["energy"].is_number() && summary["findings"].is_array());
    assert_eq!(summary["status"], "stopped");
    let reason = summary["reason"].as_str().expect("a reason");
    assert!(reason.starts_with("interrupted"), "{reason}");
}

fn lines(path: &Path) -> usize {
    std::fs::read_to_string(path).map_or(0, |text| text.lines().count())
}

/// The program as a process of its own, killed if the test fails.
struct Run(Child);

impl Run {
    fn start(folder: &Path) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_ipopt-contact"))
            .args(["run", "--increments", &INCREMENTS.to_string(), "--out"])
            .arg(folder)
            .arg(crate::root().join(SCENE))
            .stdout(Stdio::null())
            .spawn();
        Run(child.expect("the program starts"))
    }

    fn wait_until(&mut self, mut is_so: impl FnMut() -> bool) {
        let clock = Instant::now();
        while !is_so() {
            let status = self.0.try_wait().expect("a status");
            assert!(status.is_none(), "it ended on its own: {status:?}");
            assert!(clock.elapsed() < PATIENCE, "nothing happens");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn interrupt(&self) {
        let pid = self.0.id().to_string();
        let sent = Command::new("kill").args(["-INT", &pid]).status();
        assert!(sent.expect("kill runs").success());
    }

    fn wait(&mut self) -> ExitStatus {
        let clock = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().expect("a status") {
                return status;
            }
            assert!(clock.elapsed() < PATIENCE, "it does not stop");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // both fail if it has ended, as it should have
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
