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
//! `pkg-config` finds Ipopt 3.11 or later (Debian, Ubuntu: `apt-get install coinor-libipopt-dev libclang-dev`), its
//! headers in `coin/` or in `coin-or/`. Their version counts ([`HEADER_VERSION`]); an `ipopt.pc` that names another is
//! an error. `Bool` is `int` up to 3.13 and `bool` since 3.14: use the alias. Indices must have 32 bits and numbers 64;
//! a build of Ipopt with others is refused at compile time.
//!
//! The feature `bindgen`, on by default, makes the bindings from the headers, which takes libclang. Where libclang cannot
//! be loaded or cannot read them, which is a warning, and with `default-features = false`, the bindings kept in the
//! source are used instead, for 3.11 to 3.13 or for 3.14; the C++ compiler checks the C interface of the headers against
//! them, and another version is an error. They are for Unix. Without the feature through the crates above:
//!
//! ```toml
//! contact-core = { version = "0.1", default-features = false, features = ["ipopt"] }
//! # or
//! ipopt-contact = { version = "0.1", default-features = false, features = ["vtk", "csv", "plot"] }
//! ```
//!
//! The package is called `ipopt-contact-sys`, as `ipopt-sys` is another one; this library keeps the short name. Both
//! bind the same Ipopt, which is not reentrant, and cargo lets only one of them into a program (`links = "ipopt"`).
//!
//! The build script of a crate that depends on this one directly reads
//!
//! | variable | what |
//! |---|---|
//! | `DEP_IPOPT_VERSION` | the version of the headers, such as `3.14.19` |
//! | `DEP_IPOPT_VERSION_MAJOR`, `_MINOR`, `_RELEASE` | its numbers |
//! | `DEP_IPOPT_LIBS` | the libraries Ipopt says it needs, separated by commas |
//! | `DEP_IPOPT_HAS_WALL_TIME_LIMIT` and so on | 1 or 0: each of the `bool` constants below, under its name |
#![allow(unsafe_code)] // raw bindings

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

mod version;

pub use bindings::*;
pub use version::*;

#[cfg(ipopt_3_14)]
const _: () = assert!(size_of::<ipindex>() == 4 && size_of::<ipnumber>() == 8);
#[cfg(not(ipopt_3_14))]
const _: () = assert!(size_of::<Index>() == 4 && size_of::<Number>() == 8);
