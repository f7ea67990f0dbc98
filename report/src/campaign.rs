//! All runs one after another, each in a process of its own.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::Failure;
use crate::case::Case;
use crate::families::{self, Family, Scope};
use crate::record::{Measured, Record};
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
        let is_done = |case: &&Case| store.find(case, &self.revision).is_some();
        let done = cases.iter().filter(is_done).count();
        let progress = progress((cases.len() - done) as u64);
        let mut records = Vec::new();
        for case in cases {
            let record = match store.find(&case, &self.revision) {
                Some(record) => record.clone(),
                None => {
                    let record = self.measure(case, &progress)?;
                    store.push(record.clone())?;
                    record
                }
            };
            records.push(record);
        }
        progress.finish_and_clear();
        Ok(records)
    }

    fn measure(&self, case: Case, progress: &ProgressBar) -> Result<Record, Failure> {
        let name = format!("{}, {}, {}", case.family, case.setting(), case.level);
        progress.set_message(name.clone());
        let result = self.in_a_child(&case)?;
        progress.inc(1);
        if progress.is_hidden() {
            let left = progress.eta().as_secs();
            let wall = result.cost.wall;
            println!(
                "{name}: {wall:.2} s, {}; about {left} s left",
                result.status
            );
        }
        Ok(Record {
            case,
            revision: self.revision.clone(),
            result,
        })
    }

    /// Runs this program on one case; what it prints last is the result.
    fn in_a_child(&self, case: &Case) -> Result<Measured, Failure> {
        let kept = self.folder.join(format!("refined-{}.json", case.family));
        self.forget_other_revisions(&kept)?;
        let output = self.folder.join("run.txt");
        let mut child = Command::new(std::env::current_exe()?)
            .arg("--run")
            .args([serde_json::to_string(case)?.as_ref(), kept.as_os_str()])
            .envs(["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"].map(|name| (name, "1")))
            .stdin(Stdio::null())
            .stdout(File::create(&output)?)
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
        let text = fs::read_to_string(&output)?;
        fs::remove_file(&output)?;
        let last = text.lines().last().unwrap_or_default();
        match (status.success(), serde_json::from_str(last)) {
            (true, Ok(measured)) => Ok(measured),
            (true, Err(_)) => Ok(Measured::failed("ended without a result")),
            (false, _) => Ok(Measured::failed(format!("failed: {last}"))),
        }
    }

    /// A refined solution of another revision is computed anew.
    fn forget_other_revisions(&self, kept: &Path) -> Result<(), Failure> {
        let mark = kept.with_extension("revision");
        let same = mark.exists() && fs::read_to_string(&mark)? == self.revision;
        if !same {
            if kept.exists() {
                fs::remove_file(kept)?;
            }
            fs::write(&mark, &self.revision)?;
        }
        Ok(())
    }
}

/// The other side of [`Campaign::in_a_child`]: one run, and its result on standard output.
pub fn child(case: &str, kept: &Path) -> Result<ExitCode, Failure> {
    let case: Case = serde_json::from_str(case)?;
    let family = families::named(&case.family)?;
    match (family.run)(&case, kept) {
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

/// A bar in a terminal; hidden elsewhere, where there are lines.
fn progress(runs: u64) -> ProgressBar {
    let bar = ProgressBar::new(runs);
    let template = "{bar:20} {pos}/{len}, about {eta} left: {wide_msg}";
    let style = ProgressStyle::with_template(template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
