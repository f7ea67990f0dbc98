//! Ctrl-C, or a request to terminate, as one to stop cleanly.

use std::sync::{Mutex, OnceLock, PoisonError};

use contact_core::Stop;

/// The exit code of a program that a signal asked to end.
pub const INTERRUPTED: u8 = 130;

/// What the first Ctrl-C stops.
#[derive(Default)]
struct Running {
    interrupted: bool,
    stops: Vec<Stop>,
}

/// Has the first Ctrl-C request `stop`; the second one ends the process at once. After a Ctrl-C, later runs of the
/// process are stopped, too. A program that has set a handler of its own with `ctrlc` keeps that.
pub fn stop_on_ctrl_c(stop: &Stop) {
    static RUNNING: OnceLock<Mutex<Running>> = OnceLock::new();
    let running = RUNNING.get_or_init(|| {
        // an error: the program has a handler of its own
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
    eprintln!("stopping; press Ctrl-C again to give up at once");
}
