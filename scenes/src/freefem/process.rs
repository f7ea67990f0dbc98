//! Runs programs and measures their cost.

use std::io;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use contact_fem::output::record::INTERRUPTED;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde::{Deserialize, Serialize};
use wait4::{ResUse, Wait4};

use crate::{Failure, files};

/// The cost of a process.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Usage {
    /// The wall time (s).
    pub wall: f64,
    /// The CPU time in user and system mode (s).
    pub cpu: f64,
    /// The peak resident memory (bytes).
    pub peak: u64,
}

impl Usage {
    /// The median of several runs, value by value.
    pub fn median(runs: &[Usage]) -> Usage {
        let of = |value: fn(&Usage) -> f64| median(runs.iter().map(value));
        Usage {
            wall: of(|usage| usage.wall),
            cpu: of(|usage| usage.cpu),
            peak: of(|usage| usage.peak as f64) as u64,
        }
    }
}

/// The median: the middle value, or the mean of the two middle ones; NaN if there are none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (n, half) if n % 2 == 1 => values[half],
        (_, half) => 0.5 * (values[half - 1] + values[half]),
    }
}

/// The process that is being measured.
static RUNNING: Mutex<Option<Pid>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Pid>> {
    // the process number is valid even if a thread panicked
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Installs a handler: Ctrl-C and termination requests end the measured process and this one.
pub fn stop_together() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        // held until the exit, so that no other process is started
        let running = running();
        if let Some(process) = *running {
            // the process may have ended already
            let _ = kill(process, Signal::SIGKILL);
        }
        std::process::exit(i32::from(INTERRUPTED));
    })?;
    Ok(())
}

/// Starts a command and waits until it ends.
fn wait(command: &mut Command) -> io::Result<ResUse> {
    let mut process = {
        let mut running = running();
        let process = command.spawn()?;
        *running = Some(Pid::from_raw(process.id() as i32));
        process
    };
    let ended = process.wait4();
    *running() = None;
    ended
}

/// Runs a command on one thread in `folder`; its output goes to `log.txt` there.
///
/// # Errors
/// If it cannot be started or fails; the error contains the path of the log.
pub fn measured(command: &mut Command, folder: &Path) -> Result<Usage, Failure> {
    let path = folder.join("log.txt");
    let log = std::fs::File::create(&path).map_err(|error| files::cannot("write", &path, error))?;
    let command = command
        .current_dir(folder)
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .stderr(log.try_clone()?)
        .stdout(log);
    let program = command.get_program().to_string_lossy().into_owned();
    let clock = Instant::now();
    let ended = wait(command).map_err(|error| files::cannot("run", Path::new(&program), error))?;
    let wall = clock.elapsed().as_secs_f64();
    if !ended.status.success() {
        let status = ended.status;
        return Err(format!("{program} failed ({status}): see {}", path.display()).into());
    }
    let used = ended.rusage;
    let cpu: Duration = used.utime + used.stime;
    Ok(Usage {
        wall,
        cpu: cpu.as_secs_f64(),
        peak: used.maxrss,
    })
}
