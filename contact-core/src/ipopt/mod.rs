//! A safe driver of Ipopt: it takes an [`Nlp`](crate::nlp::Nlp) and returns a [`Solution`].
//!
//! [Ipopt](https://coin-or.github.io/Ipopt/) finds local solutions of smooth nonlinear problems, including large sparse
//! ones, by a primal–dual interior-point method:
//!
//! min f(x) subject to x_L ≤ x ≤ x_U and g_L ≤ g(x) ≤ g_U.
//!
//! # What to install
//! Ipopt 3.11 or later with its headers, a C++ compiler, `pkg-config` and libclang; on Debian and Ubuntu
//! `apt-get install coinor-libipopt-dev g++ pkg-config libclang-dev`. The crate's feature `ipopt`, on by default,
//! enables this module.
//!
//! # From zero to a solution
//! 1. The **structure** ([`Structure`](crate::nlp::Structure)): bounds (equal bounds make a constraint an equality or
//!    fix a variable, infinite ones mean no bound) and the sparsity patterns of the Jacobian of g and of the lower
//!    triangle of the Hessian of L = σ f + λᵀ g. It is checked once, so that no invalid index can reach Ipopt.
//! 2. The **functions** ([`Nlp`](crate::nlp::Nlp)): f, ∇f, g and the values of those entries, in their order. Without
//!    a Hessian, Ipopt approximates it.
//! 3. A **solver** for that structure, with [`Options`].
//! 4. A **start**, and [`Solver::solve`].
//! 5. The **result**: check the [`Status`] first; then read x, f, g and the multipliers.
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
//! # Further topics
//! - **Wrong derivatives** are the most frequent cause of slow or failing solves. [`check::nlp`](crate::check::nlp)
//!   finds them, as does Ipopt's own checker: [`Options::derivative_test`] and [`Solution::derivative_check`].
//! - **Options** are typed and have Ipopt's own names. [`KNOWN_OPTIONS`] lists them with defaults and versions;
//!   [`Options`] lists the defaults that this driver changes. Presets: [`Options::newton`], [`Options::quadratic`],
//!   [`Options::convex_quadratic`], [`Options::least_change`], [`Options::warm_start`].
//! - **Status**: the table in [`Status`] explains each one and its remedy.
//! - **Runs of similar problems**: [`Sequence`] starts each problem from the solution of the previous one and repeats
//!   it from a cold start if the warm start fails.
//! - **Diagnosis**: [`diagnose`] reports which linear solvers work, which ordering MUMPS uses and whether the BLAS is
//!   the slow reference one: `cargo run --release -p contact-core --example doctor`.
//! - **Monitoring and stopping**: [`Solver::solve_with`], or [`Nlp::iterate`](crate::nlp::Nlp::iterate). An
//!   [`Iterate`](crate::nlp::Iterate) has x, g, multipliers, slacks and violations.
//! - **The log**: [`Solver::set_log`] sends it to a writer or, with [`Log::text`], to a string.
//! - **Scaling**: [`Solver::set_scaling`]. Ipopt's own scaling can only reduce gradients. Choose units so that x, f and
//!   g are about 1.
//!
//! # Behaviour
//! - **A status is not an error.** `Err` reports misuse only. The ending of a solve is [`Solution::status`].
//! - **One solve at a time per process.** Ipopt's linear solvers are not reentrant, so that solves of other threads
//!   wait, those of [`doctor::inspect`] and [`diagnose`] included. Solvers can be made, set and dropped meanwhile. A
//!   solve started inside a callback is [`Error::Reentrant`]. A callback that waits for another thread's solve
//!   deadlocks, unless [`Nlp::is_to_stop`](crate::nlp::Nlp::is_to_stop) ends that one. A [`Solver`] is [`Send`] but not [`Sync`]. Besides the lock, a process shares two facts: the version
//!   that its Ipopt reported in a log, and whether the warning about a version other than the headers' was given.
//! - **A solution is checked.** Where Ipopt reports one, the functions and their first derivatives are evaluated once
//!   more, at its x. If they contradict it, the status is [`Status::Contradicted`], and
//!   [`Solution::contradiction`] says what is wrong.
//! - **Dependent equalities** have multipliers that are not unique, and Ipopt divides its errors by their size. It may
//!   then report `Solved` too early, unless `dual_inf_tol` (1 by default, unscaled) is set to the accuracy needed.
//! - **Panics** in a callback, a watching closure or a log's writer stop the solve and are then resumed in the caller.
//! - **Output.** Nothing is printed: `print_level` is 0. With [`print_level(5)`](Options::print_level) the log goes to
//!   the `log` crate, target `ipopt`, level debug, or to the target of [`Solver::set_log`]. A file `ipopt.opt` in the
//!   working directory is not read; [`Options::read`] reads one.
//! - **What Ipopt crashes with** is kept away from it: values whose squares overflow count as infinite, problems without
//!   a free variable are answered without it, and some options are refused ([`OptionError::Refused`]).
//! - **Signs**: see [`nlp`](crate::nlp). Bounds are not relaxed (`bound_relax_factor` 0): x may
//!   leave them by round-off at most.
//! - **Versions**: 3.11 to 3.14. [`VERSION`] is that of the headers compiled with. An option it lacks gives an
//!   [`OptionError::Unknown`] that names the version that introduced it.

mod callbacks;
mod context;
mod derivatives;
pub mod doctor;
mod fixed;
mod iterate;
mod libraries;
mod library;
mod lock;
mod log;
mod options;
mod scaling;
mod sequence;
mod sequence_settings;
mod shim;
mod solution;
mod solver;
mod start;
mod statistics;
mod status;
mod totals;
mod verify;
mod versions;

use thiserror::Error;

pub(crate) use self::library::blas_bytes;
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
    verify::Contradiction,
    versions::{Versions, versions},
};
use crate::nlp::NlpError;

/// The version of the Ipopt headers that this crate was compiled with, such as (3, 11, 9).
pub const VERSION: (u32, u32, u32) = ipopt_sys::HEADER_VERSION;

/// Misuse of the driver. The ending of a solve is a [`Status`].
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// Invalid structure, bounds, starting point or multipliers.
    #[error(transparent)]
    Nlp(#[from] NlpError),
    /// An option that Ipopt does not have, or a value that it rejects.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The option `warm_start_init_point` is "yes", but the start has no multipliers, as in a cold solve.
    #[error(
        "`warm_start_init_point` is set to \"yes\", but the start has no multipliers: give it some, or leave the \
         option out (it is set to \"yes\" for a start with multipliers)"
    )]
    MissingMultipliers,
    /// A [`Scaling`] was given, but an option disables it.
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
    /// Ipopt could not be set up.
    #[error("Ipopt could not be set up: out of memory")]
    OutOfMemory,
    /// The BLAS has too little memory for its buffers.
    #[error(transparent)]
    Memory(#[from] crate::MemoryError),
}
