//! Why a solve ends before its result.

use crate::nlp::NlpError;
use crate::{Error, Outcome};

/// What ends a solve before its result.
#[derive(Debug)]
pub(in crate::equilibrium) enum Halt {
    /// An error of the input or of the linear layer.
    Error(Error),
    /// No equilibrium was found, with the reason.
    Failed(String),
    /// A stop was requested.
    Stopped,
}

impl Halt {
    /// The outcome, where it is none of the errors.
    pub fn outcome(self) -> Result<Outcome, Error> {
        match self {
            Halt::Error(error) => Err(error),
            Halt::Failed(why) => Ok(Outcome::SubproblemFailed(why)),
            Halt::Stopped => Ok(Outcome::Interrupted),
        }
    }
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Halt::Error(error)
    }
}

impl From<NlpError> for Halt {
    fn from(error: NlpError) -> Self {
        Halt::Error(error.into())
    }
}
