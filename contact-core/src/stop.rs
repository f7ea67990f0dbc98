//! A request to stop, shared between a run and whoever may end it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to stop. Clones share it: one is kept by a signal handler or another thread, one is given to a run, which
/// looks at it in every iteration of the optimiser.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Nothing requested yet.
    pub fn new() -> Self {
        Stop::default()
    }

    /// Asks the run to stop. It ends at its next iteration, with all converged steps kept.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
