//! Ipopt, safely: an [`Nlp`](crate::nlp::Nlp) in, a [`Solution`] out.
//!
//! [Ipopt](https://coin-or.github.io/Ipopt/) finds local solutions of smooth nonlinear problems, large and sparse ones
//! too, by a primal–dual interior-point method:
//!
//! min f(x) subject to x_L ≤ x ≤ x_U and g_L ≤ g(x) ≤ g_U.
//!
//! # What to install
//! Ipopt 3.11 or later with its headers, a C++ compiler, `pkg-config` and libclang; on Debian and Ubuntu
//! `apt-get install coinor-libipopt-dev g++ pkg-config libclang-dev`. The crate's feature `ipopt`, on by default,
//! switches this module on.
//!
//! # From zero to a solution
//! 1. The **structure** ([`Structure`](crate::nlp::Structure)): bounds (equal ones make an equality or fix a variable,
//!    infinite ones are none) and where the Jacobian of g and the lower triangle of the Hessian of
//!    L = σ f + λᵀ g have entries. It is checked once; no wrong index can reach Ipopt.
//! 2. The **functions** ([`Nlp`](crate::nlp::Nlp)): f, ∇f, g and the values of those entries, in their order. Without
//!    a Hessian, Ipopt approximates it.
//! 3. A **solver** for that structure, with [`Options`].
//! 4. A **start**, and [`Solver::solve`].
//! 5. The **[`Status`]**, before anything else; then x, f, g and the multipliers.
//!
//! Problem 71 of Hock and Schittkowski: min x₀ x₃ (x₀ + x₁ + x₂) + x₂ subject to x₀ x₁ x₂ x₃ ≥ 25, Σ xᵢ² = 40 and
//! 1 ≤ x ≤ 5.
//!
//! ```
//! use contact_core::ipopt::{Options, Solver, Start, Status};
//! use contact_core::nlp::{Bounds, Nlp, Pattern, Structure};
//!
//! struct Hs071;
//!
//! impl Nlp for Hs071 {
//!     fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
//!         x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2]
//!     }
//!     fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
//!         gradient[0] = x[3] * (2.0 * x[0] + x[1] + x[2]);
//!         gradient[1] = x[0] * x[3];
//!         gradient[2] = x[0] * x[3] + 1.0;
//!         gradient[3] = x[0] * (x[0] + x[1] + x[2]);
//!     }
//!     fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
//!         g[0] = x[0] * x[1] * x[2] * x[3];
//!         g[1] = x.iter().map(|x| x * x).sum();
//!     }
//!     // Dense, row by row.
//!     fn jacobian(&mut self, x: &[f64], _new_x: bool, values: &mut [f64]) {
//!         values.copy_from_slice(&[
//!             x[1] * x[2] * x[3], x[0] * x[2] * x[3], x[0] * x[1] * x[3], x[0] * x[1] * x[2],
//!             2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 2.0 * x[3],
//!         ]);
//!     }
//!     // The lower triangle, row by row.
//!     fn hessian(&mut self, x: &[f64], _new_x: bool, sigma: f64, l: &[f64], values: &mut [f64]) {
//!         values.copy_from_slice(&[
//!             sigma * 2.0 * x[3] + l[1] * 2.0,
//!             sigma * x[3] + l[0] * x[2] * x[3],
//!             l[1] * 2.0,
//!             sigma * x[3] + l[0] * x[1] * x[3],
//!             l[0] * x[0] * x[3],
//!             l[1] * 2.0,
//!             sigma * (2.0 * x[0] + x[1] + x[2]) + l[0] * x[1] * x[2],
//!             sigma * x[0] + l[0] * x[0] * x[2],
//!             sigma * x[0] + l[0] * x[0] * x[1],
//!             l[1] * 2.0,
//!         ]);
//!     }
//! }
//!
//! let structure = Structure::new(
//!     Bounds::uniform(4, 1.0, 5.0),
//!     Bounds { lower: vec![25.0, 40.0], upper: vec![f64::INFINITY, 40.0] },
//!     Pattern::dense(2, 4),
//!     Some(Pattern::dense_lower(4)),
//! )?;
//! let mut solver = Solver::new(structure, &Options::new().tol(1e-9))?;
//! let solution = solver.solve(&mut Hs071, &Start::at(&[1.0, 5.0, 5.0, 1.0]))?;
//!
//! assert_eq!(solution.status, Status::Solved);
//! assert!((solution.objective - 17.014_017_3).abs() < 1e-6);
//! let close = |found: &[f64], published: &[f64]| {
//!     found.iter().zip(published).all(|(a, b)| (a - b).abs() < 1e-6)
//! };
//! assert!(close(&solution.x, &[1.0, 4.742_999_63, 3.821_149_98, 1.379_408_29]));
//! // λ ≤ 0 where g is at its lower bound; z_L ≥ 0 where x is.
//! let multipliers = solution.multipliers.expect("it is solved");
//! assert!(close(&multipliers.constraints, &[-0.552_293_66, 0.161_468_56]));
//! assert!(close(&multipliers.lower, &[1.087_871_2, 0.0, 0.0, 0.0]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where to go on
//! - **Wrong derivatives** are the most frequent reason for a solve that crawls or fails. [`check::nlp`](crate::check::nlp)
//!   finds them, or Ipopt's own checker: [`Options::derivative_test`] and [`Solution::derivative_check`].
//! - **Options**: typed, by Ipopt's own names. [`KNOWN_OPTIONS`] has the table with defaults and versions; those that
//!   this driver changes are with [`Options`]. Presets: [`Options::newton`], [`Options::quadratic`],
//!   [`Options::convex_quadratic`], [`Options::least_change`], [`Options::warm_start`].
//! - **What a [`Status`] means**, and what to do about it, is the table there.
//! - **Runs of similar problems**: [`Sequence`] starts each from the solution of the one before and, where that leads
//!   nowhere, repeats it cold.
//! - **Which Ipopt is this?** [`diagnose`] says which linear solvers it really has, how MUMPS orders, whether the BLAS
//!   is a slow one: `cargo run --release -p contact-core --example doctor`.
//! - **Watching and stopping**: [`Solver::solve_with`], or [`Nlp::iterate`](crate::nlp::Nlp::iterate). An
//!   [`Iterate`](crate::nlp::Iterate) has x, g, multipliers, slacks and violations.
//! - **The log**: [`Solver::set_log`], to a writer or, by [`Log::text`], to a text.
//! - **Scaling**: [`Solver::set_scaling`]. Ipopt's own only makes gradients smaller. Choose units so that x, f and g
//!   are about 1.
//!
//! # What to expect
//! - **A status is not an error.** `Err` is misuse only. Whatever Ipopt ends with is [`Solution::status`].
//! - **One solve at a time in a process.** Ipopt's linear solvers are not reentrant, so solves of other threads wait,
//!   those of [`doctor::inspect`] and [`diagnose`] included. Nothing else does: solvers are made, set and dropped
//!   while another solves. A solve from inside a callback is [`Error::Reentrant`]. A callback that waits for another
//!   thread's solve never returns. A [`Solver`] is [`Send`] and not [`Sync`]. Beside the lock, a process shares the
//!   version that its Ipopt has told in a log, and that a warning of another than was compiled with has been given.
//! - **Dependent equalities** make multipliers that are not unique, and Ipopt divides its errors by their size: it may
//!   then call something solved that is not, unless `dual_inf_tol` (1 by default, unscaled) is set to what counts.
//! - **Panics** in a callback, a watching closure or a log's writer stop the solve and then go on in the caller.
//! - **Silence.** Nothing is printed, and `print_level` is 0. With [`print_level(5)`](Options::print_level) the log goes
//!   to the `log` crate, target `ipopt`, level debug, or to where [`Solver::set_log`] says. A file `ipopt.opt` in the
//!   working directory is not read.
//! - **Signs**: see [`nlp`](crate::nlp). Bounds are not relaxed (`bound_relax_factor` 0): x may
//!   leave them by round-off at most.
//! - **Versions**: 3.11 to 3.14. [`VERSION`] is the one compiled with; an option it lacks is an
//!   [`OptionError::Unknown`] that says since when there is one.

mod callbacks;
mod context;
mod derivatives;
pub mod doctor;
mod iterate;
mod libraries;
mod library;
mod lock;
mod log;
mod options;
mod scaling;
mod sequence;
mod sequence_settings;
mod solution;
mod solver;
mod start;
mod statistics;
mod status;
mod totals;
mod versions;

use thiserror::Error;

pub use self::{
    derivatives::DerivativeCheck,
    doctor::{Diagnosis, diagnose},
    libraries::{Blas, BlasKind, Libraries},
    log::{Log, LogError, LogText},
    options::*,
    scaling::Scaling,
    sequence::{Retried, Run, Sequence},
    sequence_settings::SequenceSettings,
    solution::Solution,
    solver::Solver,
    start::Start,
    statistics::{CallbackStatistics, MumpsUse, Ordering, Statistics, Time},
    status::Status,
    totals::Totals,
    versions::{Versions, versions},
};
use crate::nlp::NlpError;

/// The version of Ipopt's headers that this was compiled with, such as (3, 11, 9).
pub const VERSION: (u32, u32, u32) = ipopt_sys::HEADER_VERSION;

/// Misuse of the driver. How a solve went is a [`Status`].
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A structure, bounds, a starting point or multipliers that cannot be.
    #[error(transparent)]
    Nlp(#[from] NlpError),
    /// An option Ipopt does not have, or a value it refuses.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The option `warm_start_init_point` is "yes" and the start has no multipliers, as those of cold solves.
    #[error(
        "`warm_start_init_point` is set to \"yes\", but the start has no multipliers: give it some, or leave the \
         option out (it is set to \"yes\" for a start with multipliers)"
    )]
    MissingMultipliers,
    /// A [`Scaling`] was given, and an option says that it is not to be used.
    #[error(
        "a scaling was given, but the option `nlp_scaling_method` is set to {method}, which ignores it: leave the \
         option out (it is set to \"user-scaling\" for a solver with a scaling), or call `clear_scaling`"
    )]
    UnusedScaling {
        /// What the option is set to.
        method: OptionValue,
    },
    /// A callback tried to start a solve.
    #[error(
        "a solve was started inside a callback of another: Ipopt is not reentrant; collect what it needs and solve afterwards"
    )]
    Reentrant,
    /// Ipopt could not even be set up.
    #[error("Ipopt could not be set up: out of memory")]
    OutOfMemory,
}
