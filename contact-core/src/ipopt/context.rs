//! What the callbacks of a solve share, and how they get at it.

use std::{
    any::Any,
    cell::{Cell, UnsafeCell},
    ffi::{c_int, c_void},
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
};

use ipopt_sys as sys;

use super::{callbacks::Usable, derivatives::Reader, log::Sink, statistics::Statistics};
use crate::nlp::{Iterate, IterationRecord, Nlp, Structure};

/// What looks at every iterate beside the problem itself.
pub(super) type Watch<'a> = &'a mut (dyn FnMut(&Iterate<'_>) -> ControlFlow<()> + 'a);

/// Lets one callback of a solve in at a time: an iterate that is looked at inside the intermediate callback may make
/// Ipopt want a value, or log.
pub(super) struct Gate<'a> {
    busy: Cell<bool>,
    context: UnsafeCell<Context<'a>>,
}

impl<'a> Gate<'a> {
    pub(super) fn new(context: Context<'a>) -> Self {
        Self {
            busy: Cell::new(false),
            context: UnsafeCell::new(context),
        }
    }

    pub(super) fn context_mut(&mut self) -> &mut Context<'a> {
        self.context.get_mut()
    }

    pub(super) fn into_context(self) -> Context<'a> {
        self.context.into_inner()
    }
}

/// What the callbacks of one solve share.
pub(super) struct Context<'a> {
    pub(super) nlp: &'a mut dyn Nlp,
    pub(super) structure: &'a Structure,
    /// How large values may be.
    pub(super) usable: Usable,
    pub(super) shim: *const sys::ipopt_shim,
    pub(super) watch: Option<Watch<'a>>,
    /// The first panic; once there is one, every callback fails.
    pub(super) panic: Option<Box<dyn Any + Send>>,
    pub(super) history: Vec<IterationRecord>,
    /// Calls and times; the rest comes from Ipopt.
    pub(super) statistics: Statistics,
    pub(super) log: Sink<'a>,
    /// What the derivative checker says, if it was asked.
    pub(super) derivatives: Option<Reader>,
}

impl<'a> Context<'a> {
    pub(super) fn new(
        nlp: &'a mut dyn Nlp,
        structure: &'a Structure,
        shim: *const sys::ipopt_shim,
        watch: Option<Watch<'a>>,
        log: Sink<'a>,
        derivatives: Option<Reader>,
    ) -> Self {
        let (panic, history, statistics) = Default::default();
        Self {
            nlp,
            structure,
            usable: Usable::default(),
            shim,
            watch,
            panic,
            history,
            statistics,
            log,
            derivatives,
        }
    }

    /// Runs `body` unless a callback panicked before; false if it did, or does.
    fn guarded(&mut self, body: impl FnOnce(&mut Self) -> bool) -> c_int {
        if self.panic.is_some() {
            return 0;
        }
        match catch_unwind(AssertUnwindSafe(|| body(self))) {
            Ok(success) => c_int::from(success),
            Err(payload) => {
                self.panic = Some(payload);
                0
            }
        }
    }

    /// Logs what is left.
    pub(super) fn finish_log(&mut self) {
        self.guarded(|this| {
            this.log.finish();
            true
        });
    }
}

/// Runs `body` unless another callback is running, or one panicked before; 0 then, and if it fails or panics.
///
/// # Safety
/// `user` must come from [`Gate::table`].
pub(super) unsafe fn enter(
    user: *mut c_void,
    body: impl FnOnce(&mut Context<'_>) -> bool,
) -> c_int {
    // SAFETY: the solver keeps the gate in place during the solve and touches it through the shim only.
    let gate = unsafe { &*user.cast::<Gate<'_>>() };
    if gate.busy.replace(true) {
        return 0;
    }
    // SAFETY: `busy` says that nobody else has it.
    let result = unsafe { &mut *gate.context.get() }.guarded(body);
    gate.busy.set(false);
    result
}
