//! All runs one after another, each in a process of its own.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::Failure;
use crate::case::Case;
use crate::families::{self, Family, Scope};
use crate::record::{Measured, Record};
use crate::refined::Place;
use crate::revision::revision;
use crate::store::Store;

/// Where results are kept, and how much is run.
pub struct Campaign {
    folder: PathBuf,
    scope: Scope,
    limit: Duration,
    revision: String,
}

impl Campaign {
    /// With files in `folder`; runs are given up after `limit` seconds.
    pub fn new(folder: &Path, scope: Scope, limit: u64) -> Result<Self, Failure> {
        fs::create_dir_all(folder)?;
        Ok(Campaign {
            folder: folder.to_path_buf(),
            scope,
            limit: Duration::from_secs(limit),
            revision: revision()?,
        })
    }

    /// The revision that its runs belong to.
    pub fn revision(&self) -> &str {
        &self.revision
    }

    /// Does what is not done yet and returns the records of all cases, in order.
    pub fn run(&self, families: &[Family]) -> Result<Vec<Record>, Failure> {
        let mut store = Store::open(&self.folder.join("runs.jsonl"))?;
        let cases: Vec<Case> = families
            .iter()
            .flat_map(|family| family.all_cases(self.scope))
            .collect();
        let is_open = |case: &&Case| store.find(case, &self.revision).is_none();
        let mut open: Vec<Case> = cases.iter().filter(is_open).cloned().collect();
        let refined = families.iter().filter_map(|family| family.refined);
        let refined: Vec<Case> = refined.map(|case| case(self.scope)).collect();
        let (progress, clock) = (progress(open.len() as u64), Instant::now());
        open.reverse();
        while let Some(case) = open.pop() {
            let name = format!("{}, {}, {}", case.family, case.setting(), case.level);
            let left = left(&open, &store, clock.elapsed(), progress.position());
            progress.set_message(format!("about {left:.0} s left, {name}"));
            let result = self.in_a_child(&case, refined.contains(&case))?;
            progress.inc(1);
            if progress.is_hidden() {
                let (wall, status) = (result.cost.wall, &result.status);
                println!("{name}: {wall:.2} s, {status}; about {left:.0} s left");
            }
            store.push(Record {
                case,
                revision: self.revision.clone(),
                result,
            })?;
        }
        progress.finish_and_clear();
        let records = cases
            .iter()
            .filter_map(|case| store.find(case, &self.revision));
        Ok(records.cloned().collect())
    }

    /// Runs this program on one case; what it prints last is the result.
    fn in_a_child(&self, case: &Case, is_refined: bool) -> Result<Measured, Failure> {
        let place = Place {
            path: self.folder.join(format!("refined-{}.json", case.family)),
            revision: self.revision.clone(),
            is_refined,
        };
        let mut child = Command::new(std::env::current_exe()?)
            .arg("--run")
            .args([serde_json::to_string(case)?, serde_json::to_string(&place)?])
            .envs(["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"].map(|name| (name, "1")))
            .stdin(Stdio::null())
            .stdout(Stdio::piped()) // which holds all of what it prints
            .spawn()?;
        let clock = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if clock.elapsed() > self.limit {
                child.kill()?;
                child.wait()?;
                let seconds = self.limit.as_secs();
                return Ok(Measured::failed(format!("given up after {seconds} s")));
            }
            sleep(Duration::from_millis(5));
        };
        let mut text = String::new();
        if let Some(mut output) = child.stdout.take() {
            output.read_to_string(&mut text)?;
        }
        let last = text.lines().last().unwrap_or_default();
        match (status.success(), serde_json::from_str(last)) {
            (true, Ok(measured)) => Ok(measured),
            (true, Err(_)) => Ok(Measured::failed("ended without a result")),
            (false, _) if last.is_empty() => Ok(Measured::failed(format!("failed: {status}"))),
            (false, _) => Ok(Measured::failed(format!("failed: {last}"))),
        }
    }
}

/// The other side of [`Campaign::in_a_child`]: one run, and its result on standard output.
pub fn child(case: &str, place: &str) -> Result<ExitCode, Failure> {
    let case: Case = serde_json::from_str(case)?;
    let place: Place = serde_json::from_str(place)?;
    let family = families::named(&case.family)?;
    match (family.run)(&case, &place) {
        Ok(mut measured) => {
            let finite = |_: &String, value: &mut f64| value.is_finite();
            measured.errors.retain(finite);
            measured.values.retain(finite);
            println!("{}", serde_json::to_string(&measured)?);
            Ok(ExitCode::SUCCESS)
        }
        Err(error) => {
            println!("{error}");
            Ok(ExitCode::FAILURE)
        }
    }
}

/// Seconds that the `open` cases will take: what they took last time, or the mean of the `done` ones in `elapsed`.
fn left(open: &[Case], store: &Store, elapsed: Duration, done: u64) -> f64 {
    let mean = elapsed.as_secs_f64() / done.max(1) as f64;
    let walls = open.iter().map(|case| store.last_wall(case));
    walls.fold(0.0, |sum, wall| sum + wall.unwrap_or(mean))
}

/// A bar in a terminal; hidden elsewhere, where there are lines.
fn progress(runs: u64) -> ProgressBar {
    let bar = ProgressBar::new(runs);
    let template = "{bar:20} {pos}/{len}, {wide_msg}";
    let style = ProgressStyle::with_template(template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
