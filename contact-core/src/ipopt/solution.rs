//! The result of a solve.

use super::start::Point;
use super::{Contradiction, DerivativeCheck, LogError, Statistics, Status};
#[cfg(doc)]
use super::{Log, Options};
use crate::nlp::{IterationRecord, Multipliers};

/// How a solve ended, and where.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// The status. Check it first.
    pub status: Status,
    /// x; the start if Ipopt ended without a final point.
    pub x: Vec<f64>,
    /// f(x), unscaled; NaN if Ipopt ended without it: without a final point, after an invalid number, a time limit (the
    /// last of `history` has it then) or an exception.
    pub objective: f64,
    /// g(x); NaN as above.
    pub g: Vec<f64>,
    /// The multipliers at x. `None` where Ipopt has no valid ones: after an invalid number, a time limit or an end in
    /// the restoration phase, where one is not finite, or where all variables are fixed so that nothing is iterated: the
    /// history is empty then, too.
    /// If some variables are fixed, Ipopt returns their multipliers since 3.14, and zeros before. Signs are those of
    /// [`nlp`](crate::nlp), reversed where f is [maximised](super::Scaling).
    pub multipliers: Option<Multipliers>,
    /// What contradicts the solution that Ipopt reports, where the status is [`Status::Contradicted`].
    pub contradiction: Option<Contradiction>,
    /// Its cost and accuracy.
    pub statistics: Statistics,
    /// Every iteration, the starting point first.
    pub history: Vec<IterationRecord>,
    /// What the derivative checker found, if [`Options::derivative_test`] asked for it.
    pub derivative_check: Option<DerivativeCheck>,
    /// The error that kept a [`Log::Writer`] from receiving the whole log, if any.
    pub log_error: Option<LogError>,
}

impl Solution {
    /// Of a solve that was stopped before it began.
    pub(super) fn not_begun(point: Point) -> Self {
        Self {
            status: Status::StoppedByUser,
            x: point.x,
            objective: f64::NAN,
            g: point.g,
            multipliers: None,
            contradiction: None,
            statistics: Statistics::unknown(),
            history: Vec::new(),
            derivative_check: None,
            log_error: None,
        }
    }
}
