//! One solve at a time: Ipopt's MUMPS ends the process when two threads are in it.

use std::{
    cell::Cell,
    sync::{Mutex, MutexGuard, PoisonError},
};

static IPOPT: Mutex<()> = Mutex::new(());

thread_local! {
    static HELD: Cell<bool> = const { Cell::new(false) };
}

/// Ipopt, for this thread alone.
pub(super) struct Exclusive {
    /// `None` inside a callback, where this thread holds the lock already.
    _guard: Option<MutexGuard<'static, ()>>,
    outermost: bool,
}

impl Exclusive {
    /// Waits for other threads. Inside a callback the lock is held already: creating and freeing are fine there.
    pub(super) fn wait() -> Self {
        Self::unless_held().unwrap_or(Self {
            _guard: None,
            outermost: false,
        })
    }

    /// Waits for other threads; `None` inside a callback.
    pub(super) fn unless_held() -> Option<Self> {
        if HELD.get() {
            return None;
        }
        // The lock guards no data, so a panic under it spoils nothing.
        let guard = IPOPT.lock().unwrap_or_else(PoisonError::into_inner);
        HELD.set(true);
        Some(Self {
            _guard: Some(guard),
            outermost: true,
        })
    }
}

impl Drop for Exclusive {
    fn drop(&mut self) {
        if self.outermost {
            HELD.set(false);
        }
    }
}
