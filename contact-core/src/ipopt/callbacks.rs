//! From Ipopt's callbacks to an [`Nlp`]: finite values only, and no panic across.

use std::{
    any::Any,
    ffi::{c_char, c_int, c_void},
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    slice,
    time::Instant,
};

use ipopt_sys as sys;

use super::{
    derivatives::Reader,
    iterate::{Source, record},
    log::Sink,
    statistics::{CallbackStatistics, Statistics},
};
use crate::nlp::{Iterate, IterationRecord, Nlp, Structure};

/// What looks at every iterate beside the problem itself.
pub(super) type Watch<'a> = &'a mut (dyn FnMut(&Iterate<'_>) -> ControlFlow<()> + 'a);

/// What the callbacks of one solve share.
pub(super) struct Context<'a> {
    nlp: &'a mut dyn Nlp,
    structure: &'a Structure,
    shim: *const sys::ipopt_shim,
    watch: Option<Watch<'a>>,
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
            shim,
            watch,
            panic,
            history,
            statistics,
            log,
            derivatives,
        }
    }

    /// The table for the shim; valid as long as `self` stays where it is.
    pub(super) fn table(&mut self) -> sys::ipopt_shim_callbacks {
        type Text = unsafe extern "C" fn(*mut c_void, *const c_char, usize);
        sys::ipopt_shim_callbacks {
            user: std::ptr::from_mut(self).cast(),
            objective: Some(objective),
            gradient: Some(gradient),
            constraints: Some(constraints),
            jacobian: Some(jacobian),
            hessian: Some(hessian),
            intermediate: Some(intermediate),
            log: self.log.is_open().then_some(log as Text),
            derivative_check: self.derivatives.as_ref().map(|_| derivative_check as Text),
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

/// No early exit, so that it vectorises.
fn all_finite(values: &[f64]) -> bool {
    values
        .iter()
        .fold(true, |all, value| all & value.is_finite())
}

fn timed<T>(statistics: &mut CallbackStatistics, body: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    statistics.calls += 1;
    let value = body();
    statistics.time += start.elapsed();
    value
}

/// # Safety
/// `user` must come from [`Context::table`].
unsafe fn context<'a>(user: *mut c_void) -> &'a mut Context<'a> {
    // SAFETY: the solver keeps the context in place during the solve and touches it through the shim only.
    unsafe { &mut *user.cast::<Context<'a>>() }
}

/// # Safety
/// `data` must be valid for `len` values; it may be anything if there are none.
unsafe fn input<'a>(data: *const f64, len: usize) -> &'a [f64] {
    match len {
        0 => &[],
        // SAFETY: the caller's promise.
        _ => unsafe { slice::from_raw_parts(data, len) },
    }
}

/// # Safety
/// As [`input`], for writing.
unsafe fn output<'a>(data: *mut f64, len: usize) -> &'a mut [f64] {
    match len {
        0 => &mut [],
        // SAFETY: the caller's promise.
        _ => unsafe { slice::from_raw_parts_mut(data, len) },
    }
}

unsafe extern "C" fn objective(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    value: *mut f64,
) -> c_int {
    // SAFETY: the shim hands on `user` and arrays of the problem's sizes, here and in the functions below.
    unsafe { context(user) }.guarded(|this| {
        // SAFETY: as above.
        let x = unsafe { input(x, this.structure.variables()) };
        let f = timed(&mut this.statistics.objective, || {
            this.nlp.objective(x, new_x != 0)
        });
        // SAFETY: as above.
        unsafe { value.write(f) };
        f.is_finite()
    })
}

unsafe extern "C" fn gradient(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    gradient: *mut f64,
) -> c_int {
    // SAFETY: see `objective`.
    unsafe { context(user) }.guarded(|this| {
        let n = this.structure.variables();
        // SAFETY: see `objective`.
        let (x, gradient) = unsafe { (input(x, n), output(gradient, n)) };
        gradient.fill(0.0);
        timed(&mut this.statistics.gradient, || {
            this.nlp.gradient(x, new_x != 0, gradient)
        });
        all_finite(gradient)
    })
}

unsafe extern "C" fn constraints(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    g: *mut f64,
) -> c_int {
    // SAFETY: see `objective`.
    unsafe { context(user) }.guarded(|this| {
        // SAFETY: see `objective`.
        let (x, g) = unsafe {
            (
                input(x, this.structure.variables()),
                output(g, this.structure.constraints()),
            )
        };
        g.fill(0.0);
        timed(&mut this.statistics.constraints, || {
            this.nlp.constraints(x, new_x != 0, g)
        });
        all_finite(g)
    })
}

unsafe extern "C" fn jacobian(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    values: *mut f64,
) -> c_int {
    // SAFETY: see `objective`.
    unsafe { context(user) }.guarded(|this| {
        // SAFETY: see `objective`.
        let (x, values) = unsafe {
            (
                input(x, this.structure.variables()),
                output(values, this.structure.jacobian().len()),
            )
        };
        values.fill(0.0);
        timed(&mut this.statistics.jacobian, || {
            this.nlp.jacobian(x, new_x != 0, values)
        });
        all_finite(values)
    })
}

unsafe extern "C" fn hessian(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    objective_factor: f64,
    lambda: *const f64,
    _new_lambda: c_int,
    values: *mut f64,
) -> c_int {
    // SAFETY: see `objective`.
    unsafe { context(user) }.guarded(|this| {
        let (n, m) = (this.structure.variables(), this.structure.constraints());
        let entries = this.structure.hessian().map_or(0, |pattern| pattern.len());
        // SAFETY: see `objective`.
        let (x, lambda, values) =
            unsafe { (input(x, n), input(lambda, m), output(values, entries)) };
        if let Some(reader) = &mut this.derivatives {
            reader.hessian(objective_factor, lambda);
        }
        values.fill(0.0);
        timed(&mut this.statistics.hessian, || {
            this.nlp
                .hessian(x, new_x != 0, objective_factor, lambda, values)
        });
        all_finite(values)
    })
}

unsafe extern "C" fn intermediate(
    user: *mut c_void,
    raw: *const sys::ipopt_shim_iteration,
) -> c_int {
    // SAFETY: see `objective`; `raw` is valid during the call.
    let (this, raw) = unsafe { (context(user), &*raw) };
    this.guarded(|this| {
        let record = record(raw);
        this.history.push(record);
        let source = Source {
            shim: this.shim,
            structure: this.structure,
        };
        let iterate = Iterate::new(record, &source);
        let problem = this.nlp.iterate(&iterate);
        let watch = match &mut this.watch {
            Some(watch) => watch(&iterate),
            None => ControlFlow::Continue(()),
        };
        problem.is_continue() && watch.is_continue()
    })
}

unsafe extern "C" fn log(user: *mut c_void, text: *const c_char, length: usize) {
    // SAFETY: see `objective`; `text` has `length` bytes, here and below.
    let (this, text) = unsafe { (context(user), bytes(text, length)) };
    this.guarded(|this| {
        this.log.write(text);
        true
    });
}

unsafe extern "C" fn derivative_check(user: *mut c_void, text: *const c_char, length: usize) {
    // SAFETY: see `log`.
    let (this, text) = unsafe { (context(user), bytes(text, length)) };
    this.guarded(|this| {
        if let Some(reader) = &mut this.derivatives {
            reader.write(text);
        }
        true
    });
}

/// # Safety
/// `text` must be valid for `length` bytes.
unsafe fn bytes<'a>(text: *const c_char, length: usize) -> &'a [u8] {
    // SAFETY: the caller's promise.
    unsafe { slice::from_raw_parts(text.cast::<u8>(), length) }
}
