//! Ctrl-C, or a request to terminate, as one to stop cleanly.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// The exit code of a program that a signal asked to end.
pub const INTERRUPTED: u8 = 130;

/// A flag that the first Ctrl-C raises, for this run and all later ones of the process; the second Ctrl-C ends the
/// process at once. A program that has set a handler of its own with `ctrlc` keeps that, and the flag stays down.
pub fn on_ctrl_c() -> Arc<AtomicBool> {
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    let flag = FLAG.get_or_init(|| {
        let flag = Arc::new(AtomicBool::new(false));
        let raised = flag.clone();
        let installed = ctrlc::set_handler(move || {
            if raised.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(INTERRUPTED));
            }
            eprintln!("stopping; press Ctrl-C again to give up at once");
        });
        // an error: the program has a handler of its own
        drop(installed);
        flag
    });
    flag.clone()
}
