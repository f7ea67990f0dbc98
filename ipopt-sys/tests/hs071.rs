//! Hock and Schittkowski 71 through Ipopt's own C interface and through the shim: the published solution from both.
#![allow(unsafe_code)] // raw bindings

use std::{
    ffi::{CStr, c_int, c_void},
    ptr, slice,
    sync::Mutex,
};

use ipopt_sys::*;

/// Ipopt is not reentrant, and tests run in parallel.
static IPOPT: Mutex<()> = Mutex::new(());

const X: [f64; 4] = [1.0, 4.742_999_63, 3.821_149_98, 1.379_408_29];
const LAMBDA: [f64; 2] = [-0.552_293_66, 0.161_468_56];
const OBJECTIVE: f64 = 17.014_017_3;

fn objective(x: &[f64]) -> f64 {
    x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2]
}

fn gradient(x: &[f64]) -> [f64; 4] {
    let sum = x[0] + x[1] + x[2];
    [
        x[3] * (x[0] + sum),
        x[0] * x[3],
        x[0] * x[3] + 1.0,
        x[0] * sum,
    ]
}

fn constraints(x: &[f64]) -> [f64; 2] {
    [x.iter().product(), x.iter().map(|x| x * x).sum()]
}

/// Row by row.
fn jacobian(x: &[f64]) -> [f64; 8] {
    let mut values = [0.0; 8];
    for (k, value) in values.iter_mut().enumerate() {
        *value = if k < 4 {
            (0..4).filter(|&j| j != k).map(|j| x[j]).product()
        } else {
            2.0 * x[k - 4]
        };
    }
    values
}

fn dense() -> ([c_int; 8], [c_int; 8]) {
    ([0, 0, 0, 0, 1, 1, 1, 1], [0, 1, 2, 3, 0, 1, 2, 3])
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64]) {
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-6, "{found:?} is not {expected:?}");
    }
}

mod plain {
    use super::*;

    unsafe fn array<'a>(x: *mut f64, n: usize) -> &'a mut [f64] {
        // SAFETY: Ipopt hands over arrays of the problem's sizes.
        unsafe { slice::from_raw_parts_mut(x, n) }
    }

    unsafe extern "C" fn f(
        _: c_int,
        x: *mut f64,
        _: Bool,
        value: *mut f64,
        _: *mut c_void,
    ) -> Bool {
        // SAFETY: as in `array`, here and below.
        unsafe { *value = objective(array(x, 4)) };
        Bool::from(true)
    }

    unsafe extern "C" fn grad_f(
        _: c_int,
        x: *mut f64,
        _: Bool,
        values: *mut f64,
        _: *mut c_void,
    ) -> Bool {
        // SAFETY: see `f`.
        unsafe { array(values, 4).copy_from_slice(&gradient(array(x, 4))) };
        Bool::from(true)
    }

    unsafe extern "C" fn g(
        _: c_int,
        x: *mut f64,
        _: Bool,
        _: c_int,
        values: *mut f64,
        _: *mut c_void,
    ) -> Bool {
        // SAFETY: see `f`.
        unsafe { array(values, 2).copy_from_slice(&constraints(array(x, 4))) };
        Bool::from(true)
    }

    unsafe extern "C" fn jac_g(
        _: c_int,
        x: *mut f64,
        _: Bool,
        _: c_int,
        _: c_int,
        rows: *mut c_int,
        cols: *mut c_int,
        values: *mut f64,
        _: *mut c_void,
    ) -> Bool {
        // SAFETY: see `f`; either the indices or the values are null.
        unsafe {
            if values.is_null() {
                let (i, j) = dense();
                slice::from_raw_parts_mut(rows, 8).copy_from_slice(&i);
                slice::from_raw_parts_mut(cols, 8).copy_from_slice(&j);
            } else {
                array(values, 8).copy_from_slice(&jacobian(array(x, 4)));
            }
        }
        Bool::from(true)
    }

    /// Ipopt wants one even where it approximates the Hessian.
    unsafe extern "C" fn no_h(
        _: c_int,
        _: *mut f64,
        _: Bool,
        _: f64,
        _: c_int,
        _: *mut f64,
        _: Bool,
        _: c_int,
        _: *mut c_int,
        _: *mut c_int,
        _: *mut f64,
        _: *mut c_void,
    ) -> Bool {
        Bool::from(false)
    }

    #[test]
    fn solves() {
        let _guard = IPOPT.lock();
        let mut bounds = ([1.0; 4], [5.0; 4], [25.0, 40.0], [2e19, 40.0]);
        let mut x = [1.0, 5.0, 5.0, 1.0];
        let (mut lambda, mut value) = ([0.0; 2], 0.0);
        // Ipopt reads them only, whatever the types of its interface say.
        let text = |text: &'static CStr| text.as_ptr().cast_mut();
        // SAFETY: sizes fit, and the callbacks are those above; no Hessian is asked for.
        let status = unsafe {
            let problem = CreateIpoptProblem(
                4,
                bounds.0.as_mut_ptr(),
                bounds.1.as_mut_ptr(),
                2,
                bounds.2.as_mut_ptr(),
                bounds.3.as_mut_ptr(),
                8,
                0,
                0,
                Some(f),
                Some(g),
                Some(grad_f),
                Some(jac_g),
                Some(no_h),
            );
            assert!(!problem.is_null());
            AddIpoptStrOption(
                problem,
                text(c"hessian_approximation"),
                text(c"limited-memory"),
            );
            AddIpoptStrOption(problem, text(c"sb"), text(c"yes"));
            AddIpoptIntOption(problem, text(c"print_level"), 0);
            let null = ptr::null_mut();
            let status = IpoptSolve(
                problem,
                x.as_mut_ptr(),
                null,
                &mut value,
                lambda.as_mut_ptr(),
                null,
                null,
                null.cast(),
            );
            FreeIpoptProblem(problem);
            status
        };
        assert_eq!(status, ApplicationReturnStatus_Solve_Succeeded);
        assert!((value - OBJECTIVE).abs() < 1e-6);
        assert_close(&x, &X);
        assert_close(&lambda, &LAMBDA);
    }
}

mod shim {
    use super::*;

    #[derive(Default)]
    struct Calls {
        objective: c_int,
        gradient: c_int,
        constraints: c_int,
        jacobian: c_int,
        intermediate: c_int,
    }

    unsafe fn arrays<'a>(
        user: *mut c_void,
        x: *const f64,
        values: *mut f64,
        n: usize,
    ) -> (&'a mut Calls, &'a [f64], &'a mut [f64]) {
        // SAFETY: the shim hands over `user` and arrays of the problem's sizes.
        unsafe {
            (
                &mut *user.cast(),
                slice::from_raw_parts(x, 4),
                slice::from_raw_parts_mut(values, n),
            )
        }
    }

    unsafe extern "C" fn f(user: *mut c_void, x: *const f64, _: c_int, value: *mut f64) -> c_int {
        // SAFETY: as in `arrays`, here and below.
        let (calls, x, value) = unsafe { arrays(user, x, value, 1) };
        calls.objective += 1;
        value[0] = objective(x);
        1
    }

    unsafe extern "C" fn grad_f(
        user: *mut c_void,
        x: *const f64,
        _: c_int,
        values: *mut f64,
    ) -> c_int {
        // SAFETY: see `f`.
        let (calls, x, values) = unsafe { arrays(user, x, values, 4) };
        calls.gradient += 1;
        values.copy_from_slice(&gradient(x));
        1
    }

    unsafe extern "C" fn g(user: *mut c_void, x: *const f64, _: c_int, values: *mut f64) -> c_int {
        // SAFETY: see `f`.
        let (calls, x, values) = unsafe { arrays(user, x, values, 2) };
        calls.constraints += 1;
        values.copy_from_slice(&constraints(x));
        1
    }

    unsafe extern "C" fn jac_g(
        user: *mut c_void,
        x: *const f64,
        _: c_int,
        values: *mut f64,
    ) -> c_int {
        // SAFETY: see `f`.
        let (calls, x, values) = unsafe { arrays(user, x, values, 8) };
        calls.jacobian += 1;
        values.copy_from_slice(&jacobian(x));
        1
    }

    unsafe extern "C" fn intermediate(user: *mut c_void, _: *const ipopt_shim_iteration) -> c_int {
        // SAFETY: `user` is the one of the table.
        unsafe { &mut *user.cast::<Calls>() }.intermediate += 1;
        1
    }

    #[test]
    fn solves_and_counts() {
        let _guard = IPOPT.lock();
        let (rows, cols) = dense();
        let mut calls = Calls::default();
        let table = ipopt_shim_callbacks {
            user: (&raw mut calls).cast(),
            objective: Some(f),
            gradient: Some(grad_f),
            constraints: Some(g),
            jacobian: Some(jac_g),
            intermediate: Some(intermediate),
            ..Default::default()
        };
        let mut x = [1.0, 5.0, 5.0, 1.0];
        let (mut values, mut lambda, mut lower, mut upper) =
            ([0.0; 2], [0.0; 2], [0.0; 4], [0.0; 4]);
        let mut point = ipopt_shim_point {
            x: x.as_mut_ptr(),
            g: values.as_mut_ptr(),
            lambda: lambda.as_mut_ptr(),
            z_lower: lower.as_mut_ptr(),
            z_upper: upper.as_mut_ptr(),
            ..Default::default()
        };
        let mut statistics = ipopt_shim_statistics::default();
        // SAFETY: sizes fit, the callbacks are those above, and nothing is used after it is freed.
        let status = unsafe {
            let shim = ipopt_shim_create(
                4,
                2,
                8,
                rows.as_ptr(),
                cols.as_ptr(),
                0,
                ptr::null(),
                ptr::null(),
            );
            assert!(!shim.is_null());
            ipopt_shim_set_bounds(
                shim,
                [1.0; 4].as_ptr(),
                [5.0; 4].as_ptr(),
                [25.0, 40.0].as_ptr(),
                [f64::INFINITY, 40.0].as_ptr(),
            );
            assert_eq!(
                ipopt_shim_set_text(
                    shim,
                    c"hessian_approximation".as_ptr(),
                    c"limited-memory".as_ptr()
                ),
                1
            );
            assert_eq!(
                ipopt_shim_set_text(shim, c"hessian_approximation".as_ptr(), c"magic".as_ptr()),
                0
            );
            assert_eq!(
                ipopt_shim_set_number(shim, c"max_iter".as_ptr(), 7.0),
                0,
                "not a number option"
            );
            assert_eq!(
                ipopt_shim_set_integer(shim, c"no_such_option".as_ptr(), 7),
                0
            );
            assert_eq!(
                ipopt_shim_current_x(shim, x.as_mut_ptr()),
                0,
                "no solve, no iterate"
            );
            let status = ipopt_shim_solve(shim, &table, &mut point, &mut statistics);
            ipopt_shim_free(shim);
            status
        };
        assert_eq!(status, 0);
        assert_eq!((point.finalized, statistics.available), (1, 1));
        assert!((point.objective - OBJECTIVE).abs() < 1e-6);
        assert_close(&x, &X);
        assert_close(&lambda, &LAMBDA);
        assert_close(&values, &[25.0, 40.0]);

        assert_eq!(statistics.iterations + 1, calls.intermediate);
        // Ipopt does not count the derivatives it asks for to find its scaling.
        assert_eq!(statistics.objective_evaluations, calls.objective);
        assert_eq!(statistics.constraint_evaluations, calls.constraints);
        assert_eq!(statistics.gradient_evaluations + 1, calls.gradient);
        assert_eq!(statistics.jacobian_evaluations + 1, calls.jacobian);
        assert_eq!(statistics.hessian_evaluations, 0);
        assert!(statistics.factorizations >= i64::from(statistics.iterations));
        assert!(statistics.kkt_error < 1e-6 && statistics.constraint_violation < 1e-7);
    }
}
