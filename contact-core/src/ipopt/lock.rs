//! One solve at a time: Ipopt's MUMPS ends the process when two threads are in it.
//!
//! Nothing else needs the lock. Each solver has an application of its own with its options, and the linear solver is
//! made and freed within a solve; what Ipopt 3.11 to 3.14 share besides is constant, or of a thread.

use std::{
    cell::Cell,
    sync::{Mutex, MutexGuard, PoisonError},
};

static IPOPT: Mutex<()> = Mutex::new(());

thread_local! {
    static HELD: Cell<bool> = const { Cell::new(false) };
}

/// A solve, for this thread alone.
pub(super) struct Exclusive {
    _guard: MutexGuard<'static, ()>,
}

impl Exclusive {
    /// Waits for the solves of other threads; `None` inside a callback, where this thread holds the lock already.
    pub(super) fn unless_held() -> Option<Self> {
        if HELD.get() {
            return None;
        }
        // The lock guards no data, so a panic under it spoils nothing.
        let guard = IPOPT.lock().unwrap_or_else(PoisonError::into_inner);
        HELD.set(true);
        Some(Self { _guard: guard })
    }
}

impl Drop for Exclusive {
    fn drop(&mut self) {
        HELD.set(false);
    }
}
