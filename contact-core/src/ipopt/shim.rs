//! The shim of a solver. Each thread keeps one that is idle: Ipopt takes a quarter of a millisecond to register its options.

use std::cell::Cell;
use std::ptr::NonNull;

use ipopt_sys as sys;

use crate::nlp::{Pattern, Structure};

thread_local! {
    static IDLE: Cell<Option<Idle>> = const { Cell::new(None) };
}

/// A shim with the structure of a problem; it becomes idle when it is dropped.
pub(super) struct Shim(NonNull<sys::ipopt_shim>);

/// A shim that nobody uses. Its structure is that of an earlier problem.
struct Idle(NonNull<sys::ipopt_shim>);

// SAFETY: a shim has no ties to a thread, and shares with others of its kind only the linear solver's global state,
// which solves alone touch, under the process-wide lock.
unsafe impl Send for Shim {}

impl Shim {
    /// An idle shim or a new one, for problems of this structure, without scaling; `None` if out of memory.
    pub fn new(structure: &Structure) -> Option<Self> {
        let (rows, cols) = structure.jacobian().narrow();
        let none = Pattern::empty();
        let (h_rows, h_cols) = structure.hessian().unwrap_or(&none).narrow();
        let (n, m) = (structure.variables(), structure.constraints());
        let [n, m, entries, h_entries] = [n, m, rows.len(), h_rows.len()].map(count);
        let (rows, cols) = (rows.as_ptr(), cols.as_ptr());
        let (h_rows, h_cols) = (h_rows.as_ptr(), h_cols.as_ptr());
        let Some(idle) = IDLE.try_with(Cell::take).ok().flatten() else {
            // SAFETY: the structure is valid: indices in range, counts within 32 bits.
            let shim = unsafe {
                sys::ipopt_shim_create(n, m, entries, rows, cols, h_entries, h_rows, h_cols)
            };
            return NonNull::new(shim).map(Shim);
        };
        // SAFETY: as above, and the shim is valid.
        let set = unsafe {
            let shim = idle.0.as_ptr();
            sys::ipopt_shim_set_structure(
                shim, n, m, entries, rows, cols, h_entries, h_rows, h_cols,
            )
        };
        (set != 0).then(|| idle.wake())
    }

    pub fn as_ptr(&self) -> *mut sys::ipopt_shim {
        self.0.as_ptr()
    }
}

impl Drop for Shim {
    fn drop(&mut self) {
        let idle = Idle(self.0);
        // at the end of the thread there is no place to keep it, and it is freed
        let _ = IDLE.try_with(|place| place.set(Some(idle)));
    }
}

impl Idle {
    fn wake(self) -> Shim {
        let shim = Shim(self.0);
        std::mem::forget(self);
        shim
    }
}

impl Drop for Idle {
    fn drop(&mut self) {
        // SAFETY: the shim is valid, and nobody uses it after this.
        unsafe { sys::ipopt_shim_free(self.0.as_ptr()) };
    }
}

/// A validated count: [`Structure::new`] lets none pass that does not fit.
fn count(value: usize) -> i32 {
    i32::try_from(value).unwrap_or(i32::MAX)
}
