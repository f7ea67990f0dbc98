//! Which Ipopt this crate was built for, and what changed between versions.
//!
//! All of it comes from the headers, not from the `.pc` file, and is also handed to the build scripts of dependents:
//! a constant `NAME` as `DEP_IPOPT_NAME`, 1 or 0. Inside this crate the cfgs `ipopt_3_14`, `ipopt_3_14_8`,
//! `ipopt_3_14_10`, `ipopt_3_14_12`, `ipopt_3_14_13` and `ipopt_3_14_18` say the same.

use std::ffi::c_int;

/// Major, minor and release of the headers this crate was compiled with; `DEP_IPOPT_VERSION_MAJOR` and so on.
pub const HEADER_VERSION: (u32, u32, u32) = include!(concat!(env!("OUT_DIR"), "/version.rs"));

/// `Bool` is C's `bool` since 3.14.0, and was an `int` before.
pub const BOOL_IS_ONE_BYTE: bool = cfg!(ipopt_3_14);

/// Since 3.14.0 there are the option `max_wall_time` and the status −5, `Maximum_WallTime_Exceeded`.
pub const HAS_WALL_TIME_LIMIT: bool = cfg!(ipopt_3_14);

/// Since 3.14.0 `fixed_variable_treatment` can be `make_parameter_nodual`.
pub const HAS_MAKE_PARAMETER_NODUAL: bool = cfg!(ipopt_3_14);

/// Since 3.14.0 fixed variables have multipliers at the solution, at the price of a further gradient and Jacobian.
pub const HAS_MULTIPLIERS_OF_FIXED_VARIABLES: bool = cfg!(ipopt_3_14);

/// A lower bound above its upper bound is the status −11 since 3.14.0, and was −100 before.
pub const CROSSED_BOUNDS_ARE_INVALID_PROBLEM: bool = cfg!(ipopt_3_14);

/// `honor_original_bounds` is "no" by default since 3.14.0, and was "yes": a solution may exceed its bounds by
/// `bound_relax_factor`.
pub const RELAXES_ORIGINAL_BOUNDS: bool = cfg!(ipopt_3_14);

/// There is an option `mumps_print_level`, since 3.14.8.
pub const HAS_MUMPS_PRINT_LEVEL: bool = cfg!(ipopt_3_14_8);

/// There is an option `grad_f_constant`, since 3.14.10.
pub const HAS_GRAD_F_CONSTANT: bool = cfg!(ipopt_3_14_10);

/// `GetIpoptCurrentIterate` and `GetIpoptCurrentViolations` return false outside a solve since 3.14.12; in 3.14.0 to
/// 3.14.11 that is undefined behaviour, and before they do not exist. `ipopt_shim_current_*` is safe with all versions.
pub const CURRENT_ITERATE_IS_SAFE: bool = cfg!(ipopt_3_14_12);

/// A structure callback that fails ends the solve since 3.14.13; before, Ipopt went on with indices it never got. The
/// shim has no such callback.
pub const HEEDS_STRUCTURE_FAILURE: bool = cfg!(ipopt_3_14_13);

/// There is a function `GetIpoptVersion`, since 3.14.18.
pub const HAS_GET_IPOPT_VERSION: bool = cfg!(ipopt_3_14_18);

#[cfg(ipopt_3_14_18)]
unsafe extern "C" {
    /// Writes the version of the library in use; see [`library_version`] for a safe one.
    pub fn GetIpoptVersion(major: *mut c_int, minor: *mut c_int, release: *mut c_int);
}

/// The version of the library in use, which need not be that of the headers: another may be installed by the time the
/// program runs. From 3.14.18 on Ipopt tells at any time; earlier ones tell in their log, so that it is `None` until
/// the first `ipopt_shim_solve` of the process has come to iterate.
pub fn library_version() -> Option<(u32, u32, u32)> {
    let mut numbers: [c_int; 3] = [0; 3];
    // SAFETY: there is room for three numbers.
    let known = unsafe { crate::ipopt_shim_library_version(numbers.as_mut_ptr()) } != 0;
    let [major, minor, release] = numbers.map(c_int::unsigned_abs);
    known.then_some((major, minor, release))
}
