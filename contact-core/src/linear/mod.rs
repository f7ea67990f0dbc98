//! Symmetric sparse matrices and their factors.
//!
//! A [`SymmetricPattern`] lists the entries of a matrix; a [`Factor`] factors it and solves with it. The feature
//! `linear` provides [`Cholesky`], based on the crate faer and an [`Analysis`] of the pattern. Without it, pattern and
//! trait remain for other implementations.
#![cfg_attr(not(feature = "linear"), allow(rustdoc::broken_intra_doc_links))]

#[cfg(feature = "linear")]
mod cholesky;
#[cfg(feature = "linear")]
mod ordering;
mod pattern;
#[cfg(all(test, feature = "linear"))]
mod tests;
#[cfg(feature = "linear")]
mod triangular;

#[cfg(feature = "linear")]
pub use self::cholesky::{Analysis, Cholesky, Kind, Panel};
#[cfg(feature = "linear")]
pub use self::ordering::{Ordering, postordered};
pub use self::pattern::SymmetricPattern;
#[cfg(feature = "linear")]
pub(crate) use self::triangular::Reach;

/// A factorisation for symmetric matrices of one pattern: refactored for new values, and used for any number of solves.
///
/// It owns its data and can be kept from one load step to the next.
pub trait Factor: Send + Sync {
    /// n, the number of unknowns.
    fn dim(&self) -> usize;

    /// Factors the matrix with `values` (one per slot), in place of the previous matrix.
    ///
    /// # Errors
    /// A wrong number of values, a value that is not finite, a matrix unsuitable for this kind of factor. After an
    /// error there is no factor to solve with.
    fn refactor(&mut self, values: &[f64]) -> Result<Inertia, FactorError>;

    /// Overwrites the right-hand sides `b` with the solutions of A x = b; `b` is n × k, column by column, for any k.
    ///
    /// # Errors
    /// The length is not a multiple of n, or no matrix has been factored.
    fn solve(&mut self, b: &mut [f64]) -> Result<(), FactorError>;
}

/// The numbers of positive and negative eigenvalues of a factored matrix. It has no zero eigenvalues: a matrix that is
/// singular to working precision is an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inertia {
    /// Eigenvalues above zero.
    pub positive: usize,
    /// Eigenvalues below zero.
    pub negative: usize,
}

/// The reason why a matrix was not factored or a system not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FactorError {
    /// A slice has the wrong length.
    #[error("{what} has {found} entries and needs {expected}")]
    Length {
        /// Which slice.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it needs, or a divisor of it.
        expected: usize,
    },
    /// A value of the matrix is NaN or infinite.
    #[error("entry ({row}, {col}) of the matrix is {value}: it must be finite")]
    NotFinite {
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// The value.
        value: f64,
    },
    /// LLᵀ met a pivot that is not positive, or zero to working precision.
    #[error(
        "the matrix is not positive definite to working precision (pivot at unknown {unknown}): \
         factor it as indefinite, or shift its diagonal"
    )]
    NotPositiveDefinite {
        /// The unknown at whose pivot that shows.
        unknown: usize,
    },
    /// LDLᵀ without pivoting met a pivot that is zero to working precision.
    #[error(
        "the matrix is singular to working precision, or needs pivoting, which this factorisation does not do \
         (the pivot at unknown {unknown} is smaller than its round-off)"
    )]
    Singular {
        /// The unknown at whose pivot that shows.
        unknown: usize,
    },
    /// No matrix has been factored, or the last factorisation failed.
    #[error("there is no factor to solve with: factor a matrix first")]
    NotFactored,
    /// The analysis needs larger indices than there are.
    #[error("a matrix of {n} unknowns and {entries} entries is too large to factor: {reason}")]
    TooLarge {
        /// Unknowns.
        n: usize,
        /// Entries of the lower triangle.
        entries: usize,
        /// The limit that was exceeded.
        reason: String,
    },
    /// There is too little memory.
    #[error(transparent)]
    Memory(#[from] crate::MemoryError),
    /// The elimination order is not a permutation.
    #[error("the elimination order does not name each of the {n} unknowns once")]
    Order {
        /// Unknowns.
        n: usize,
    },
}
