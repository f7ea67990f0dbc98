//! Raw bindings to [Ipopt](https://coin-or.github.io/Ipopt/), and a small C++ shim for what its C interface leaves out.
//!
//! Ipopt's own C interface is bound as it is, for instance [`CreateIpoptProblem`] and [`IpoptSolve`]. It gives no
//! statistics, no log and, before 3.14, no iterate. The `ipopt_shim_*` functions do: they drive Ipopt's C++ interface
//! through a table of callbacks ([`ipopt_shim_callbacks`]) and let no C++ exception through. `src/shim.h` documents
//! them.
//!
//! # Safety
//! Everything here is `unsafe` and unchecked. Ipopt with MUMPS is not reentrant: two solves at a time end the process.
//! An index out of range is undefined behaviour.
//!
//! # Building
//! `pkg-config` finds Ipopt 3.11 or later (Debian, Ubuntu: `apt-get install coinor-libipopt-dev libclang-dev`). A
//! dependent's build script reads `DEP_IPOPT_VERSION` and `DEP_IPOPT_LIBS`, the libraries Ipopt says it needs,
//! separated by commas.
//!
//! `Bool` is `int` up to 3.13 and `bool` since 3.14: use the alias. Indices must have 32 bits and numbers 64; a build
//! of Ipopt with others is refused at compile time.

#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    rustdoc::all,
    clippy::all,
    clippy::undocumented_unsafe_blocks
)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

pub use bindings::*;

#[cfg(ipopt_3_14)]
const _: () = assert!(size_of::<ipindex>() == 4 && size_of::<ipnumber>() == 8);
#[cfg(not(ipopt_3_14))]
const _: () = assert!(size_of::<Index>() == 4 && size_of::<Number>() == 8);
