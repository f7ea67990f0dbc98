//! What a solve gives back.

use super::{DerivativeCheck, LogError, Statistics, Status};
#[cfg(doc)]
use super::{Log, Options};
use crate::nlp::{IterationRecord, Multipliers};

/// How a solve ended, and where.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// How it ended. Look at it first.
    pub status: Status,
    /// x; the start if Ipopt ended without a final point.
    pub x: Vec<f64>,
    /// f(x), unscaled; NaN if Ipopt ended without it: without a final point, after an invalid number, a time limit (the
    /// last of `history` has it then) or an exception.
    pub objective: f64,
    /// g(x); NaN as above.
    pub g: Vec<f64>,
    /// The multipliers at x, `None` where Ipopt has none worth the name: after an invalid number, a time limit, in
    /// the restoration phase, where one is not finite, or with nothing to iterate because all variables are fixed.
    /// For fixed variables among others Ipopt has them since 3.14, and zeros before. Signs are those of
    /// [`nlp`](crate::nlp), reversed where f is [maximised](super::Scaling).
    pub multipliers: Option<Multipliers>,
    /// What it cost.
    pub statistics: Statistics,
    /// Every iteration, the starting point first.
    pub history: Vec<IterationRecord>,
    /// What the derivative checker found, if [`Options::derivative_test`] asked for it.
    pub derivative_check: Option<DerivativeCheck>,
    /// Why a [`Log::Writer`] has not got all of the log, if so.
    pub log_error: Option<LogError>,
}
