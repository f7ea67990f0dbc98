//! From Ipopt's callbacks to an [`Nlp`]: finite values only, and no panic across.

use std::{
    ffi::{c_char, c_int, c_void},
    ops::ControlFlow,
    slice,
    time::Instant,
};

use ipopt_sys as sys;

use super::{
    Scaling,
    context::{Context, Gate, enter},
    iterate::{Source, record},
    statistics::CallbackStatistics,
};
use crate::nlp::Iterate;

impl Gate<'_> {
    /// The table for the shim; valid as long as `self` stays where it is.
    pub(super) fn table(&mut self) -> sys::ipopt_shim_callbacks {
        type Text = unsafe extern "C" fn(*mut c_void, *const c_char, usize);
        let context = self.context_mut();
        sys::ipopt_shim_callbacks {
            log: context.log.is_open().then_some(log as Text),
            derivative_check: context
                .derivatives
                .as_ref()
                .map(|_| derivative_check as Text),
            user: std::ptr::from_mut(self).cast(),
            objective: Some(objective),
            gradient: Some(gradient),
            constraints: Some(constraints),
            jacobian: Some(jacobian),
            hessian: Some(hessian),
            intermediate: Some(intermediate),
            stops: Some(stops),
        }
    }
}

/// The largest magnitudes of each function's values that Ipopt can calculate with: their squares are finite, too. With larger
/// ones, norms and products overflow; then MUMPS crashes, or Ipopt factorises for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Usable {
    pub objective: f64,
    pub gradient: f64,
    pub constraints: f64,
    pub jacobian: f64,
    pub hessian: f64,
    /// Whether the factor of f is negative.
    pub maximises: bool,
}

impl Usable {
    /// √(largest number).
    const LARGEST: f64 = 1.340_780_792_994_259_6e154;

    /// As Ipopt sees them, multiplied by the caller's factors.
    pub fn under(scaling: &Scaling) -> Self {
        let all = |factors: &Option<Vec<f64>>| factors.clone().unwrap_or_default().into_iter();
        let f = scaling.objective.abs();
        let g = all(&scaling.constraints).fold(1.0, f64::max);
        let x = all(&scaling.variables).fold(1.0, f64::min);
        // divisions one after the other: a product of factors may overflow
        let divided = |factors: &[f64]| {
            let largest = factors
                .iter()
                .fold(Self::LARGEST, |limit, factor| limit / factor);
            largest.min(Self::LARGEST)
        };
        Usable {
            objective: divided(&[f]),
            gradient: divided(&[f, 1.0 / x]),
            constraints: divided(&[g]),
            jacobian: divided(&[g, 1.0 / x]),
            hessian: divided(&[f.max(g), 1.0 / x, 1.0 / x]),
            maximises: scaling.objective < 0.0,
        }
    }
}

impl Default for Usable {
    fn default() -> Self {
        Usable {
            objective: Self::LARGEST,
            gradient: Self::LARGEST,
            constraints: Self::LARGEST,
            jacobian: Self::LARGEST,
            hessian: Self::LARGEST,
            maximises: false,
        }
    }
}

/// Whether no value is larger than `most`, or no number. No early exit, so that it vectorises.
pub(super) fn are_usable(values: &[f64], most: f64) -> bool {
    values
        .iter()
        .fold(true, |all, &value| all & (value.abs() <= most))
}

pub(super) fn timed<T>(statistics: &mut CallbackStatistics, body: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    statistics.calls += 1;
    let value = body();
    statistics.time += start.elapsed();
    value
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
    let body = |this: &mut Context<'_>| {
        // SAFETY: the shim hands on arrays of the problem's sizes, here and in the functions below.
        let x = unsafe { input(x, this.structure.variables()) };
        let f = timed(&mut this.statistics.objective, || {
            this.nlp.objective(x, new_x != 0)
        });
        // SAFETY: as above.
        unsafe { value.write(f) };
        are_usable(&[f], this.usable.objective)
    };
    // SAFETY: `user` is as the shim was given it.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn gradient(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    gradient: *mut f64,
) -> c_int {
    let body = |this: &mut Context<'_>| {
        let n = this.structure.variables();
        // SAFETY: see `objective`.
        let (x, gradient) = unsafe { (input(x, n), output(gradient, n)) };
        gradient.fill(0.0);
        timed(&mut this.statistics.gradient, || {
            this.nlp.gradient(x, new_x != 0, gradient)
        });
        are_usable(gradient, this.usable.gradient)
    };
    // SAFETY: `user` is as the shim was given it.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn constraints(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    g: *mut f64,
) -> c_int {
    let body = |this: &mut Context<'_>| {
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
        are_usable(g, this.usable.constraints)
    };
    // SAFETY: `user` is as the shim was given it.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn jacobian(
    user: *mut c_void,
    x: *const f64,
    new_x: c_int,
    values: *mut f64,
) -> c_int {
    let body = |this: &mut Context<'_>| {
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
        are_usable(values, this.usable.jacobian)
    };
    // SAFETY: `user` is as the shim was given it.
    unsafe { enter(user, body) }
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
    let body = |this: &mut Context<'_>| {
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
        are_usable(values, this.usable.hessian)
    };
    // SAFETY: `user` is as the shim was given it.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn intermediate(
    user: *mut c_void,
    raw: *const sys::ipopt_shim_iteration,
) -> c_int {
    // SAFETY: it is valid during the call.
    let raw = unsafe { &*raw };
    let body = |this: &mut Context<'_>| {
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
    };
    // SAFETY: see `objective`.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn stops(user: *mut c_void, factorizes: c_int) -> c_int {
    let body = |this: &mut Context<'_>| match factorizes {
        0 => this.nlp.is_to_stop(),
        _ => !this.nlp.may_factorize(),
    };
    // SAFETY: see `objective`.
    unsafe { enter(user, body) }
}

unsafe extern "C" fn log(user: *mut c_void, text: *const c_char, length: usize) {
    // SAFETY: it has `length` bytes, here and below.
    let text = unsafe { bytes(text, length) };
    let body = |this: &mut Context<'_>| {
        this.log.write(text);
        true
    };
    // SAFETY: see `objective`.
    unsafe { enter(user, body) };
}

unsafe extern "C" fn derivative_check(user: *mut c_void, text: *const c_char, length: usize) {
    // SAFETY: see `log`.
    let text = unsafe { bytes(text, length) };
    let body = |this: &mut Context<'_>| {
        if let Some(reader) = &mut this.derivatives {
            reader.write(text);
        }
        true
    };
    // SAFETY: see `objective`.
    unsafe { enter(user, body) };
}

/// # Safety
/// `text` must be valid for `length` bytes.
unsafe fn bytes<'a>(text: *const c_char, length: usize) -> &'a [u8] {
    // SAFETY: the caller's promise.
    unsafe { slice::from_raw_parts(text.cast::<u8>(), length) }
}

#[cfg(test)]
mod tests {
    use std::{cell::RefCell, ptr, rc::Rc};

    use super::*;
    use crate::{
        ipopt::{Log, log::Sink},
        nlp::{Bounds, Nlp, Pattern, Structure},
    };

    /// Calls all functions of the table while it looks at an iterate.
    struct Nested {
        table: Rc<RefCell<Option<sys::ipopt_shim_callbacks>>>,
        calls: usize,
    }

    impl Nlp for Nested {
        fn objective(&mut self, x: &[f64], _: bool) -> f64 {
            self.calls += 1;
            x[0]
        }
        fn gradient(&mut self, _: &[f64], _: bool, _: &mut [f64]) {
            self.calls += 1;
        }
        fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {
            self.calls += 1;
        }
        fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {
            self.calls += 1;
        }
        fn hessian(&mut self, _: &[f64], _: bool, _: f64, _: &[f64], _: &mut [f64]) {
            self.calls += 1;
        }
        fn iterate(&mut self, _: &Iterate<'_>) -> ControlFlow<()> {
            let table = self.table.borrow().expect("set before the call");
            assert_eq!(call_all(&table), [0; 5]);
            ControlFlow::Continue(())
        }
    }

    /// What the five functions of the problem return; logs a line, too.
    fn call_all(table: &sys::ipopt_shim_callbacks) -> [c_int; 5] {
        let (user, x, mut out) = (table.user, [1.0], [0.0]);
        let (x, out, text) = (x.as_ptr(), out.as_mut_ptr(), c"line\n");
        // SAFETY: all arrays have the one value that all of this problem's have, and the text five.
        unsafe {
            (table.log.expect("a writer"))(user, text.as_ptr(), 5);
            [
                (table.objective.expect("set"))(user, x, 1, out),
                (table.gradient.expect("set"))(user, x, 1, out),
                (table.constraints.expect("set"))(user, x, 1, out),
                (table.jacobian.expect("set"))(user, x, 1, out),
                (table.hessian.expect("set"))(user, x, 1, 1.0, x, 1, out),
            ]
        }
    }

    #[test]
    fn no_callback_while_another_runs() {
        let (one, diagonal) = (Bounds::free(1), Pattern::diagonal(1));
        let structure = Structure::new(one.clone(), one, diagonal.clone(), Some(diagonal)).unwrap();
        let (mut log, text) = Log::text();
        let shared = Rc::default();
        let mut nlp = Nested {
            table: Rc::clone(&shared),
            calls: 0,
        };
        let sink = Sink::new(&mut log);
        let context = Context::new(&mut nlp, &structure, ptr::null(), None, sink, None);
        let mut gate = Gate::new(context);
        let table = gate.table();
        shared.replace(Some(table));
        let iteration = sys::ipopt_shim_iteration::default();
        // SAFETY: the iteration is valid, and the gate stays where it is.
        let go_on = unsafe { (table.intermediate.expect("set"))(table.user, &iteration) };
        assert_eq!(go_on, 1, "the iterate was looked at");
        assert_eq!(text.take(), "", "nothing was logged");
        // Afterwards they are let in again.
        assert_eq!(call_all(&table), [1; 5]);
        assert_eq!(text.take(), "line\n");
        let context = gate.into_context();
        assert!(context.panic.is_none() && context.history.len() == 1);
        assert_eq!(nlp.calls, 5);
    }

    /// Writes what is no number, or too large to calculate with, from one of its functions.
    struct Spoils {
        function: usize,
        value: f64,
    }

    impl Spoils {
        fn write(&self, function: usize, values: &mut [f64]) {
            values[0] = if function == self.function {
                self.value
            } else {
                1.0
            };
        }
    }

    impl Nlp for Spoils {
        fn objective(&mut self, _: &[f64], _: bool) -> f64 {
            let mut value = [0.0];
            self.write(0, &mut value);
            value[0]
        }
        fn gradient(&mut self, _: &[f64], _: bool, gradient: &mut [f64]) {
            self.write(1, gradient);
        }
        fn constraints(&mut self, _: &[f64], _: bool, g: &mut [f64]) {
            self.write(2, g);
        }
        fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
            self.write(3, values);
        }
        fn hessian(&mut self, _: &[f64], _: bool, _: f64, _: &[f64], values: &mut [f64]) {
            self.write(4, values);
        }
    }

    /// Ipopt is told of every value that it cannot calculate with, and of no other.
    #[test]
    fn values_that_are_no_numbers_are_refused() {
        let (one, diagonal) = (Bounds::free(1), Pattern::diagonal(1));
        let structure = Structure::new(one.clone(), one, diagonal.clone(), Some(diagonal)).unwrap();
        for function in 0..5 {
            for (value, is_usable) in [
                (f64::NAN, 0),
                (f64::NEG_INFINITY, 0),
                (1e200, 0),
                (-1e100, 1),
            ] {
                let (mut log, _) = Log::text();
                let mut nlp = Spoils { function, value };
                let sink = Sink::new(&mut log);
                let context = Context::new(&mut nlp, &structure, ptr::null(), None, sink, None);
                let mut gate = Gate::new(context);
                let mut expected = [1; 5];
                expected[function] = is_usable;
                assert_eq!(call_all(&gate.table()), expected, "{value}");
            }
        }
    }
}
