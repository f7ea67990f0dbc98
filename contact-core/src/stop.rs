//! A request to stop, shared between a run and the code that may end it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to stop. Clones share it: keep one in a signal handler or another thread and give one to a run, which
/// checks it in every iteration, before each factorisation and while it waits for the solve of another thread. A
/// request stays: a later run with the same token ends at once.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// A token without a request.
    pub fn new() -> Self {
        Stop::default()
    }

    /// Asks the run to stop. It ends at its next iteration, with all converged steps kept.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether a stop has been requested.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
