//! How things end: a subproblem ([`Solved`]), a load step ([`Outcome`]), a run ([`Ending`]).
//!
//! None of these is an error: whoever stops short of a solution leaves its history and what was found before.

use std::fmt;

/// How a method ended on its subproblem.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solved {
    /// To the tolerance asked.
    Optimal,
    /// Stopped on request; the result is not a minimum.
    Interrupted,
    /// Not solved, with the solver's own word for the reason; the result is not a minimum.
    Failed(String),
}

/// How the search for equilibrium at one load ended.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// The relative change fell below the tolerance, and every subproblem on the way was solved.
    Converged,
    /// The iterates repeat themselves with this period; `amplitude` is the relative change at which they do.
    Cycle {
        /// The number of iterations in a round.
        period: usize,
        /// ‖U_n − U_{n−1}‖∞ over ‖U‖∞ within the cycle.
        amplitude: f64,
    },
    /// The iteration limit was reached.
    IterationLimit,
    /// The method did not solve its subproblem; the solver's own word.
    SubproblemFailed(String),
    /// Converged, but to a state in which bodies have gone through each other.
    Tunnelled {
        /// How deep a node is inside another body, or how far it has gone through one (UL).
        depth: f64,
    },
    /// The energy is infinite at the start (J ≤ 0 somewhere), so that no iteration can begin.
    InadmissibleStart,
    /// Stopped on request.
    Interrupted,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Converged => write!(f, "converged"),
            Outcome::Cycle { period, amplitude } => write!(
                f,
                "cycles with period {period} at amplitude {amplitude:.2e}"
            ),
            Outcome::IterationLimit => write!(f, "iteration limit of the fixed point"),
            Outcome::SubproblemFailed(why) => write!(f, "subproblem not solved: {why}"),
            Outcome::Tunnelled { depth } => write!(
                f,
                "bodies have gone {depth:.2e} into or through each other: smaller steps or a longer reach"
            ),
            Outcome::InadmissibleStart => write!(f, "inadmissible start (J ≤ 0)"),
            Outcome::Interrupted => write!(f, "interrupted"),
        }
    }
}

/// How a run over all load steps ended.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Ending {
    /// Full load, every increment converged.
    Complete,
    /// Stopped at this load factor, because the smallest step allowed did not converge either.
    NotConverged {
        /// The last converged load factor.
        at: f64,
        /// How the last attempt ended.
        why: Outcome,
    },
    /// Stopped on request at this load factor.
    Interrupted {
        /// The last converged load factor.
        at: f64,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ending::Complete => write!(f, "complete"),
            Ending::NotConverged { at, why } => {
                write!(f, "not converged beyond load factor {at}: {why}")
            }
            Ending::Interrupted { at } => write!(f, "interrupted at load factor {at}"),
        }
    }
}
