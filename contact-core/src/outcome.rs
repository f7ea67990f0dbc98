//! Status of a subproblem ([`Solved`]), a load step ([`Outcome`]) and a run ([`Ending`]).
//!
//! None of these is an error: a solve that does not converge still returns its history and the last converged state.

use std::fmt;

/// The status of a method on its subproblem.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solved {
    /// Solved to the requested tolerance.
    Optimal,
    /// Stopped on request or at a limit of time; the result is not a minimum.
    Interrupted,
    /// Not solved, with the reason as the solver states it; the result is not a minimum.
    Failed(String),
}

/// The status of the search for equilibrium at one load.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Outcome {
    /// The relative change fell below the tolerance, and every subproblem on the way was solved.
    Converged,
    /// The iterates are periodic.
    Cycle {
        /// The number of iterations in a period.
        period: usize,
        /// The relative change ‖U_n − U_{n−1}‖∞ / ‖U‖∞ within the cycle.
        amplitude: f64,
    },
    /// The iteration limit was reached.
    IterationLimit,
    /// The method did not solve its subproblem, with the reason as the solver states it.
    SubproblemFailed(String),
    /// Converged to a state in which bodies are deep inside each other or have passed through each other.
    Tunnelled {
        /// The depth of a point inside another body, or the distance by which it has passed through one (UL).
        depth: f64,
        /// The bodies and the place.
        place: String,
    },
    /// Converged to a state that needs constraints which had been left out, for the reason given; the load step was solved again with them.
    Unplanned(String),
    /// The energy is not finite at the start (J ≤ 0 somewhere, or a load that is no number), so that the iteration cannot
    /// start.
    InadmissibleStart,
    /// Stopped on request, or at a limit of time or factorisations.
    Interrupted,
}

impl Outcome {
    /// Whether an equilibrium was sought and not found, so that there may be none at this load.
    pub(crate) fn has_no_equilibrium(&self) -> bool {
        matches!(self, Outcome::Cycle { .. } | Outcome::IterationLimit)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Converged => write!(f, "converged"),
            Outcome::Cycle { period, amplitude } => write!(
                f,
                "cycles with period {period} at amplitude {amplitude:.2e}"
            ),
            Outcome::IterationLimit => write!(f, "iteration limit"),
            Outcome::SubproblemFailed(why) => write!(f, "subproblem not solved: {why}"),
            Outcome::Tunnelled { depth, place } => write!(
                f,
                "{place} by {depth:.2e}: take smaller steps or a longer reach, and declare every surface that may touch"
            ),
            Outcome::Unplanned(what) => {
                write!(f, "{what}; constraints that had been left out are added")
            }
            Outcome::InadmissibleStart => write!(
                f,
                "inadmissible start: the energy is not finite (J ≤ 0, or a load that is no number)"
            ),
            Outcome::Interrupted => write!(f, "interrupted"),
        }
    }
}

/// What stopped a run before its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Interruption {
    /// A request, see [`Stop`](crate::Stop).
    Requested,
    /// The time of its [`Budget`](crate::Budget).
    Deadline {
        /// That time (s).
        seconds: f64,
    },
    /// The factorisations of its [`Budget`](crate::Budget): one more was needed.
    Factorizations {
        /// Their number.
        limit: usize,
    },
    /// The closure that observes the run.
    Observer,
    /// The solver, at a limit of its own, such as Ipopt's `max_wall_time`.
    Solver,
}

impl fmt::Display for Interruption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Interruption::Requested => write!(f, "a stop was requested"),
            Interruption::Deadline { seconds } => {
                write!(f, "its budget of time ({seconds} s) is spent")
            }
            Interruption::Factorizations { limit } => {
                write!(f, "its budget of factorisations ({limit}) is spent")
            }
            Interruption::Observer => write!(f, "the run's observer stopped it"),
            Interruption::Solver => write!(f, "the solver reached a limit of its own"),
        }
    }
}

/// The status of a run over all load steps.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Ending {
    /// Every increment up to full load converged.
    Complete,
    /// The smallest step allowed did not converge.
    NotConverged {
        /// The last converged load factor.
        at: f64,
        /// The outcome of the last attempt.
        why: Outcome,
        /// The cause, where the state of the last attempt shows one.
        cause: Option<String>,
    },
    /// Stopped before its end. All that has converged is kept.
    Interrupted {
        /// The last converged load factor.
        at: f64,
        /// What stopped it.
        why: Interruption,
    },
    /// An error of the problem or the solver, after at least one converged step.
    Failed {
        /// The last converged load factor.
        at: f64,
        /// The error, which [`Run::error`](crate::load_steps::Run::error) has as a value.
        why: String,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ending::Complete => write!(f, "complete"),
            Ending::NotConverged { at, why, cause } => {
                write!(f, "not converged beyond load factor {at}: {why}")?;
                cause.iter().try_for_each(|cause| write!(f, "; {cause}"))
            }
            Ending::Interrupted { at, why } => write!(f, "interrupted at load factor {at}: {why}"),
            Ending::Failed { at, why } => write!(f, "failed beyond load factor {at}: {why}"),
        }
    }
}
