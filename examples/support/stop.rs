//! Ctrl-C, or a request to terminate, as one to stop cleanly.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;

/// The exit code of a program that a signal asked to end.
pub const INTERRUPTED: u8 = 130;

/// A flag that the first Ctrl-C raises; the second one ends the program at once.
pub fn on_ctrl_c() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        eprintln!("stopping; press Ctrl-C again to give up at once");
    })?;
    Ok(flag)
}
