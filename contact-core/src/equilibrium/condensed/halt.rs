//! Why a solve ends before its result.

use crate::linear::FactorError;
use crate::nlp::NlpError;
use crate::{Error, LinearGaps, Outcome, Stop, memory};

/// What ends a solve before its result.
#[derive(Debug)]
pub(in crate::equilibrium) enum Halt {
    /// An error of the input or of the linear layer.
    Error(Error),
    /// No equilibrium was found, with the reason.
    Failed(String),
    /// A stop was requested, or the budget is spent.
    Stopped,
}

/// The most rows that are condensed: their dense compliance has 8 rows² bytes, and its solution takes twice as much again.
const MOST_ROWS: usize = 20_000;
/// So many bytes for each entry, then; from `MANY` bytes on, what the system has left is looked at before they are taken.
const BYTES: usize = 24;
const MANY: u64 = 32 << 20;
/// Rows that no unknown moves may overlap by this share of the problem's length.
const IMMOVABLE: f64 = 1e-9;

impl Halt {
    /// [`Halt::Stopped`] if a stop was requested.
    pub fn if_requested(stop: &Stop) -> Result<(), Halt> {
        match stop.is_requested() {
            true => Err(Halt::Stopped),
            false => Ok(()),
        }
    }

    /// Counts a factorisation that is about to begin. [`Halt::Stopped`] if it must not.
    pub fn unless_may_factorize(stop: &Stop) -> Result<(), Halt> {
        match stop.begin_factorization() {
            true => Ok(()),
            false => Err(Halt::Stopped),
        }
    }

    /// [`Halt::Failed`] if the compliance of so many rows is too large, and an error if the memory left is.
    pub fn if_too_many(rows: usize) -> Result<(), Halt> {
        match rows > MOST_ROWS {
            true => Err(Halt::Failed(format!(
                "{rows} rows may act, and a dense compliance is kept for {MOST_ROWS} at most: solve by `FixedPoint`, which has none"
            ))),
            false => {
                let bytes = (BYTES * rows * rows) as u64;
                match bytes > MANY {
                    true => Ok(
                        memory::check("the compliance of the rows that may act", bytes)
                            .map_err(Error::from)?,
                    ),
                    false => Ok(()),
                }
            }
        }
    }

    /// [`Halt::Failed`] if one of the `immovable` rows, which no unknown moves, overlaps: c are their gaps, and `length` is the
    /// unit of lengths (UL).
    pub fn if_immovable(
        length: f64,
        gaps: &LinearGaps,
        immovable: impl Iterator<Item = usize>,
        c: &[f64],
    ) -> Result<(), Halt> {
        let deepest = immovable.min_by(|&i, &j| c[i].total_cmp(&c[j]));
        match deepest.filter(|&i| c[i] < -IMMOVABLE * length) {
            Some(i) => Err(Halt::Failed(format!(
                "node {} of pass {} overlaps by {:.2e}, and all that could open its gap is prescribed",
                gaps.keys()[i].node,
                gaps.keys()[i].pass,
                -c[i]
            ))),
            None => Ok(()),
        }
    }

    /// The outcome, where it is none of the errors.
    pub fn outcome(self) -> Result<Outcome, Error> {
        match self {
            // as too many rows are: another solver may do without the factor
            Halt::Error(Error::Factor(why @ FactorError::TooLarge { .. })) => {
                Ok(Outcome::SubproblemFailed(why.to_string()))
            }
            Halt::Error(error) => Err(error),
            Halt::Failed(why) => Ok(Outcome::SubproblemFailed(why)),
            Halt::Stopped => Ok(Outcome::Interrupted),
        }
    }
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        match error {
            Error::Interrupted => Halt::Stopped,
            error => Halt::Error(error),
        }
    }
}

impl From<NlpError> for Halt {
    fn from(error: NlpError) -> Self {
        Halt::Error(error.into())
    }
}

impl From<FactorError> for Halt {
    fn from(error: FactorError) -> Self {
        Halt::Error(error.into())
    }
}
