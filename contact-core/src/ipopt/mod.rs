//! Ipopt, safely: an [`Nlp`](crate::nlp::Nlp) in, a [`Solution`] out.
//!
//! ```
//! use contact_core::ipopt::{Options, Solver, Start, Status};
//! use contact_core::nlp::{Bounds, Nlp, Pattern, Structure};
//!
//! /// min (x − 3)² subject to x ≤ 1.
//! struct Parabola;
//!
//! impl Nlp for Parabola {
//!     fn objective(&mut self, x: &[f64], _: bool) -> f64 {
//!         (x[0] - 3.0).powi(2)
//!     }
//!     fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
//!         gradient[0] = 2.0 * (x[0] - 3.0);
//!     }
//!     fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
//!     fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
//!     fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
//!         values[0] = 2.0 * sigma;
//!     }
//! }
//!
//! let structure = Structure::new(
//!     Bounds::uniform(1, f64::NEG_INFINITY, 1.0),
//!     Bounds::default(),
//!     Pattern::empty(),
//!     Some(Pattern::diagonal(1)),
//! )?;
//! let mut solver = Solver::new(structure, &Options::new())?;
//! let solution = solver.solve(&mut Parabola, &Start::at(&[0.0]))?;
//! assert_eq!(solution.status, Status::Solved);
//! assert!((solution.x[0] - 1.0).abs() < 1e-7);
//! // z_U = −f′(1) = 4
//! assert!((solution.multipliers.unwrap().upper[0] - 4.0).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What to expect
//! - **A status is not an error.** `Err` is misuse only. Whatever Ipopt ends with is [`Solution::status`].
//! - **One solve at a time in a process.** Ipopt's linear solvers are not reentrant, so solves of other threads wait.
//!   A solve from inside a callback is [`Error::Reentrant`]. A callback that waits for another thread's solve never
//!   returns.
//! - **Panics** in a callback stop the solve and then go on in the caller.
//! - **Silence.** Nothing is printed. The log goes to the `log` crate, target `ipopt`, level debug; the option
//!   `print_level` (0 here) says how much of it. A file `ipopt.opt` in the working directory is not read.
//! - **Signs**: see [`nlp`](crate::nlp). Bounds are kept exactly (`bound_relax_factor` 0).

mod callbacks;
mod derivatives;
mod iterate;
mod lock;
mod log;
mod options;
mod solver;
mod start;
mod statistics;
mod status;

use thiserror::Error;

pub use self::{
    derivatives::DerivativeCheck,
    log::{Log, LogError},
    options::*,
    solver::{Solution, Solver},
    start::{Scaling, Start},
    statistics::{CallbackStatistics, Statistics, Time},
    status::Status,
};
use crate::nlp::NlpError;

/// The version of Ipopt's headers that this was compiled with, such as (3, 11, 9).
pub const VERSION: (u32, u32, u32) = (
    ipopt_sys::IPOPT_VERSION_MAJOR,
    ipopt_sys::IPOPT_VERSION_MINOR,
    ipopt_sys::IPOPT_VERSION_RELEASE,
);

/// Misuse of the driver. How a solve went is a [`Status`].
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A structure, bounds, a starting point or multipliers that cannot be.
    #[error(transparent)]
    Nlp(#[from] NlpError),
    /// An option Ipopt does not have, or a value it refuses.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The option `warm_start_init_point` is "yes" and the start has no multipliers.
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
