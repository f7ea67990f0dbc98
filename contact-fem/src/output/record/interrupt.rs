//! Signals: Ctrl-C and termination requests, which stop a run cleanly, and the limit of the size of files.

use std::sync::{Mutex, OnceLock, PoisonError};

use contact_core::Stop;

use super::complain;

/// The exit code of a program that was stopped by a signal.
pub const INTERRUPTED: u8 = 130;

/// The stop requests of the runs, and whether there was a Ctrl-C.
#[derive(Default)]
struct Running {
    interrupted: bool,
    stops: Vec<Stop>,
}

/// The first Ctrl-C requests `stop`; the second one ends the process at once. After a Ctrl-C, later
/// runs of the process are stopped, too. If the program has set its own handler with `ctrlc`, that
/// handler stays.
pub fn stop_on_ctrl_c(stop: &Stop) {
    static RUNNING: OnceLock<Mutex<Running>> = OnceLock::new();
    let running = RUNNING.get_or_init(|| {
        // an error: the program has its own handler
        let _ = ctrlc::set_handler(|| interrupt(RUNNING.get()));
        Mutex::default()
    });
    let mut running = running.lock().unwrap_or_else(PoisonError::into_inner);
    if running.interrupted {
        stop.request();
    }
    running.stops.push(stop.clone());
}

fn interrupt(running: Option<&Mutex<Running>>) {
    let Some(running) = running else { return };
    let mut running = running.lock().unwrap_or_else(PoisonError::into_inner);
    if running.interrupted {
        std::process::exit(i32::from(INTERRUPTED));
    }
    running.interrupted = true;
    running.stops.iter().for_each(Stop::request);
    complain("stopping; press Ctrl-C again to give up at once");
}

/// Lets writing beyond the limit of a file's size (`ulimit -f`) fail in this thread, where else a signal would end the
/// process.
pub(super) fn refuse_rather_than_end() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        // a signal that is blocked stays pending; it is never let through, since it would end the process then
        let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
    }
}
