//! Errors in the input to a solve, or reported by the problem or the optimiser. Failure to converge is not an error:
//! it is a status with its history, see [`Outcome`](crate::Outcome).

/// Errors of the optimisation layer. Each names the offending quantity, its value and the remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A slice has the wrong length.
    #[error("{what} has length {found}, expected {expected}: pass one entry per unknown or row")]
    Length {
        /// Which argument.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length needed.
        expected: usize,
    },
    /// A number is NaN or infinite where a finite one is needed.
    #[error("{what}[{index}] = {value} is not finite: check the input it was computed from")]
    NotFinite {
        /// Which argument.
        what: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A setting is outside its range.
    #[error("setting `{name}` = {value} is out of range: {remedy}")]
    Setting {
        /// The field's name.
        name: &'static str,
        /// The value found.
        value: String,
        /// The values that are accepted.
        remedy: &'static str,
    },
    /// A solver does not treat problems of this kind.
    #[error("`{solver}` does not treat {what} = {value}: {remedy}")]
    Untreated {
        /// The solver.
        solver: &'static str,
        /// The quantity that it refuses.
        what: &'static str,
        /// The value found.
        value: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A stiffness that is not symmetric.
    #[error(
        "K[{row}, {column}] = {value} and K[{column}, {row}] = {transposed} differ: give both triangles of the Hessian of an energy"
    )]
    Asymmetric {
        /// The row of the entry, from 0.
        row: usize,
        /// Its column.
        column: usize,
        /// The entry.
        value: f64,
        /// The entry across the diagonal.
        transposed: f64,
    },
    /// A stiffness in which a penalty holds an unknown.
    #[error(
        "K[{unknown}, {unknown}] = {value:e} holds unknown {unknown} by a penalty: leave conditions such as `on` out of the \
         matrix, and give the unknown equal bounds"
    )]
    HeldByPenalty {
        /// The unknown, from 0.
        unknown: usize,
        /// Its diagonal entry.
        value: f64,
    },
    /// A gap that no unknown changes, and that is negative.
    #[error(
        "row {row} of C has no entry, and its gap is {constant}: no motion opens it; leave the row out"
    )]
    ImpossibleRow {
        /// The row, from 0.
        row: usize,
        /// Its c₀ (UL).
        constant: f64,
    },
    /// Invalid bounds or sparsity patterns.
    #[error(transparent)]
    Nlp(#[from] crate::nlp::NlpError),
    /// A matrix was not factored, or a system not solved.
    #[error(transparent)]
    Factor(#[from] crate::linear::FactorError),
    /// A run or a solve has too little memory.
    #[error(transparent)]
    Memory(#[from] crate::MemoryError),
    /// The file of a run that is to go on does not belong to it, or cannot be used, see
    /// [`Resumable`](crate::equilibrium::Resumable).
    #[cfg(feature = "resume")]
    #[error("the file {file} {why}")]
    Resume {
        /// The file.
        file: String,
        /// What is wrong with it, and the remedy.
        why: String,
    },
    /// A computation was left because a stop was requested, see [`ContactProblem::watch`](crate::ContactProblem::watch).
    #[error("a stop was requested, or the run's budget is spent")]
    Interrupted,
    /// The Ipopt driver refused the problem or an option.
    #[cfg(feature = "ipopt")]
    #[error(transparent)]
    Ipopt(#[from] crate::ipopt::Error),
    /// The contact problem itself reported an error.
    #[error(transparent)]
    Problem(Box<dyn std::error::Error + Send + Sync>),
}

/// `Debug` prints the message, because `main` and `unwrap` show errors by their `Debug` form.
macro_rules! debug_as_display {
    ($($error:ty),*) => {$(
        impl std::fmt::Debug for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(self, f)
            }
        }
    )*};
}
debug_as_display!(Error, crate::nlp::NlpError);
#[cfg(feature = "ipopt")]
debug_as_display!(
    crate::ipopt::Error,
    crate::ipopt::LogError,
    crate::ipopt::OptionError
);

impl Error {
    /// Too little memory, if that is the error.
    pub fn memory(&self) -> Option<&crate::MemoryError> {
        match self {
            Error::Memory(why) | Error::Factor(crate::linear::FactorError::Memory(why)) => {
                Some(why)
            }
            #[cfg(feature = "ipopt")]
            Error::Ipopt(crate::ipopt::Error::Memory(why)) => Some(why),
            _ => None,
        }
    }

    /// Wraps an error type that a [`ContactProblem`](crate::ContactProblem) defines itself.
    pub fn problem(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::Problem(Box::new(error))
    }

    /// [`Error::Setting`] unless the setting `is_valid`.
    pub(crate) fn check_setting(
        is_valid: bool,
        name: &'static str,
        value: f64,
        remedy: &'static str,
    ) -> Result<(), Self> {
        match is_valid {
            true => Ok(()),
            false => Err(Error::Setting {
                name,
                value: format!("{value:?}"),
                remedy,
            }),
        }
    }

    /// Checks that something has `expected` entries.
    pub fn check_length_of(what: &'static str, found: usize, expected: usize) -> Result<(), Self> {
        match found == expected {
            true => Ok(()),
            false => Err(Error::Length {
                what,
                found,
                expected,
            }),
        }
    }

    /// Checks that `slice` has `expected` entries.
    pub(crate) fn check_length(
        what: &'static str,
        slice: &[f64],
        expected: usize,
    ) -> Result<(), Self> {
        Self::check_length_of(what, slice.len(), expected)
    }

    /// Checks that `slice` has `expected` finite entries.
    pub fn check_vector(what: &'static str, slice: &[f64], expected: usize) -> Result<(), Self> {
        Self::check_length(what, slice, expected)?;
        match slice.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(Error::NotFinite {
                what,
                index,
                value: slice[index],
            }),
            None => Ok(()),
        }
    }
}
