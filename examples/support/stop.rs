//! Ctrl-C, or a request to terminate, as one to stop cleanly.

use ipopt_contact::contact_core::Stop;

use super::Failure;

/// The exit code of a program that a signal asked to end.
pub const INTERRUPTED: u8 = 130;

/// The request to stop that the first Ctrl-C makes; the second one ends the program at once.
pub fn on_ctrl_c() -> Result<Stop, Failure> {
    let stop = Stop::new();
    let requested = stop.clone();
    ctrlc::set_handler(move || {
        if requested.is_requested() {
            std::process::exit(i32::from(INTERRUPTED));
        }
        requested.request();
        eprintln!("stopping; press Ctrl-C again to give up at once");
    })?;
    Ok(stop)
}
