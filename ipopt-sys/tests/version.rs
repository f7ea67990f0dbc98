//! What is said about the version holds for the Ipopt at hand.
#![allow(unsafe_code)] // raw bindings

use std::{
    ffi::{CStr, c_char, c_int, c_void},
    io::{Write, stderr},
    ptr, slice,
};

use ipopt_sys::*;

/// A problem of one variable, freed in the end.
struct Shim(*mut ipopt_shim);

impl Shim {
    fn new() -> Self {
        let none = ptr::null();
        // SAFETY: one variable and no entries, so that no array is read.
        let shim = unsafe { ipopt_shim_create(1, 0, 0, none, none, 0, none, none) };
        assert!(!shim.is_null());
        Self(shim)
    }

    fn has(&self, option: &CStr) -> bool {
        // SAFETY: the shim is valid, and the name a C string.
        let kind = unsafe { ipopt_shim_option_type(self.0, option.as_ptr()) };
        kind.unsigned_abs() != IPOPT_SHIM_OPTION_UNKNOWN
    }

    fn takes(&self, option: &CStr, value: &CStr) -> bool {
        // SAFETY: the shim is valid, and both are C strings.
        unsafe { ipopt_shim_set_text(self.0, option.as_ptr(), value.as_ptr()) == 1 }
    }

    /// The status of a solve in which every function fails, and the log.
    fn fail(&self, lower: f64, upper: f64) -> (c_int, String) {
        unsafe extern "C" fn scalar(_: *mut c_void, _: *const f64, _: c_int, _: *mut f64) -> c_int {
            0
        }
        unsafe extern "C" fn hessian(
            _: *mut c_void,
            _: *const f64,
            _: c_int,
            _: f64,
            _: *const f64,
            _: c_int,
            _: *mut f64,
        ) -> c_int {
            0
        }
        unsafe extern "C" fn go_on(_: *mut c_void, _: *const ipopt_shim_iteration) -> c_int {
            1
        }
        unsafe extern "C" fn log(user: *mut c_void, text: *const c_char, length: usize) {
            // SAFETY: `user` is the log below, and the text has this length.
            let (log, text) = unsafe {
                (
                    &mut *user.cast::<Vec<u8>>(),
                    slice::from_raw_parts(text.cast(), length),
                )
            };
            log.extend_from_slice(text);
        }
        let mut written = Vec::new();
        let table = ipopt_shim_callbacks {
            user: (&raw mut written).cast(),
            log: Some(log),
            objective: Some(scalar),
            gradient: Some(scalar),
            constraints: Some(scalar),
            jacobian: Some(scalar),
            hessian: Some(hessian),
            intermediate: Some(go_on),
            ..Default::default()
        };
        let (mut x, mut z_lower, mut z_upper) = ([0.0], [0.0], [0.0]);
        let mut point = ipopt_shim_point {
            x: x.as_mut_ptr(),
            z_lower: z_lower.as_mut_ptr(),
            z_upper: z_upper.as_mut_ptr(),
            ..Default::default()
        };
        let mut statistics = ipopt_shim_statistics::default();
        // SAFETY: one value each, and a table of callbacks that reach nothing but the log.
        let status = unsafe {
            ipopt_shim_set_bounds(self.0, &lower, &upper, ptr::null(), ptr::null());
            ipopt_shim_solve(self.0, &table, &mut point, &mut statistics)
        };
        (status, String::from_utf8_lossy(&written).into_owned())
    }
}

impl Drop for Shim {
    fn drop(&mut self) {
        // SAFETY: nobody uses it afterwards.
        unsafe { ipopt_shim_free(self.0) };
    }
}

#[test]
fn options_are_there_since_when_they_are_said_to_be() {
    let shim = Shim::new();
    assert!(shim.has(c"max_cpu_time") && !shim.has(c"no_such_option"));
    assert_eq!(shim.has(c"max_wall_time"), HAS_WALL_TIME_LIMIT);
    assert_eq!(shim.has(c"mumps_print_level"), HAS_MUMPS_PRINT_LEVEL);
    assert_eq!(shim.has(c"grad_f_constant"), HAS_GRAD_F_CONSTANT);
    let treatment = c"fixed_variable_treatment";
    assert!(shim.takes(treatment, c"make_parameter"));
    assert_eq!(
        shim.takes(treatment, c"make_parameter_nodual"),
        HAS_MAKE_PARAMETER_NODUAL
    );
}

/// In one test, as what is known of the library depends on what ran before, and two solves at a time end the process.
#[test]
fn the_library_is_of_the_version_of_the_headers() {
    let shim = Shim::new();
    assert_eq!(library_version().is_some(), HAS_GET_IPOPT_VERSION);
    let invalid = if CROSSED_BOUNDS_ARE_INVALID_PROBLEM {
        ApplicationReturnStatus_Invalid_Problem_Definition
    } else {
        ApplicationReturnStatus_Unrecoverable_Exception
    };
    assert_eq!(shim.fail(1.0, -1.0).0, invalid);
    let (status, log) = shim.fail(-1.0, 1.0);
    assert_eq!(status, ApplicationReturnStatus_Invalid_Number_Detected);
    assert_eq!(library_version(), Some(HEADER_VERSION));

    // The library's own words, also to the terminal, where they say what was tested.
    let banner = log
        .lines()
        .find(|line| line.starts_with("This is Ipopt"))
        .expect("Ipopt announces itself");
    let (major, minor, release) = HEADER_VERSION;
    let version = format!("This is Ipopt version {major}.{minor}.{release}, ");
    assert!(banner.starts_with(&version), "{banner}");
    // A test must not fail for want of a terminal.
    let _ = stderr().write_all(format!("{banner}\n").as_bytes());
}

#[test]
fn constants_agree() {
    let (major, minor, release) = HEADER_VERSION;
    assert_eq!(BOOL_IS_ONE_BYTE, size_of::<Bool>() == 1);
    assert_eq!(HAS_WALL_TIME_LIMIT, (major, minor) >= (3, 14));
    assert_eq!(
        HAS_GET_IPOPT_VERSION,
        (major, minor, release) >= (3, 14, 18)
    );
    for (later, earlier) in [
        (HAS_GET_IPOPT_VERSION, HEEDS_STRUCTURE_FAILURE),
        (HEEDS_STRUCTURE_FAILURE, CURRENT_ITERATE_IS_SAFE),
        (CURRENT_ITERATE_IS_SAFE, HAS_GRAD_F_CONSTANT),
        (HAS_GRAD_F_CONSTANT, HAS_MUMPS_PRINT_LEVEL),
        (HAS_MUMPS_PRINT_LEVEL, HAS_WALL_TIME_LIMIT),
    ] {
        assert!(earlier || !later);
    }
}
