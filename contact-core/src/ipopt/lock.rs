//! One solve at a time: Ipopt's MUMPS ends the process when two threads are in it.
//!
//! Nothing else needs the lock. Each solver has an application of its own with its options, and the linear solver is
//! made and freed within a solve; what Ipopt 3.11 to 3.14 share besides is constant, or of a thread.

use std::{
    cell::Cell,
    sync::{Condvar, Mutex, PoisonError},
    time::Duration,
};

/// Whether a solve is under way.
static BUSY: Mutex<bool> = Mutex::new(false);
static ENDED: Condvar = Condvar::new();

/// How often a solve that waits asks whether it is still wanted.
const ASK: Duration = Duration::from_millis(20);

thread_local! {
    static HELD: Cell<bool> = const { Cell::new(false) };
}

/// A solve, for this thread alone.
pub(super) struct Exclusive(());

/// Why a thread may not solve.
pub(super) enum Refused {
    /// It solves already: this is a callback.
    Held,
    /// Its solve was stopped while it waited.
    Stopped,
}

impl Exclusive {
    /// Waits for the solves of other threads, until `stops` says that this one is not wanted any more.
    pub(super) fn wait(mut stops: impl FnMut() -> bool) -> Result<Self, Refused> {
        if HELD.get() {
            return Err(Refused::Held);
        }
        // The lock guards no data, so a panic under it spoils nothing; here and below.
        let mut busy = BUSY.lock().unwrap_or_else(PoisonError::into_inner);
        while *busy {
            let waited = ENDED.wait_timeout(busy, ASK);
            (busy, _) = waited.unwrap_or_else(PoisonError::into_inner);
            if *busy {
                // `stops` is the caller's, and may do anything
                drop(busy);
                if stops() {
                    return Err(Refused::Stopped);
                }
                busy = BUSY.lock().unwrap_or_else(PoisonError::into_inner);
            }
        }
        *busy = true;
        HELD.set(true);
        Ok(Self(()))
    }
}

impl Drop for Exclusive {
    fn drop(&mut self) {
        *BUSY.lock().unwrap_or_else(PoisonError::into_inner) = false;
        HELD.set(false);
        ENDED.notify_one();
    }
}
