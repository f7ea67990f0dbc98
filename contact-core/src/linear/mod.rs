//! Symmetric sparse matrices and their factors.
//!
//! A [`SymmetricPattern`] says where a matrix has entries; a [`Factor`] solves with it. The feature `linear` brings
//! [`Cholesky`], by the crate faer, over an [`Analysis`] of the pattern; without it, pattern and trait remain, for
//! factors of your own.
#![cfg_attr(not(feature = "linear"), allow(rustdoc::broken_intra_doc_links))]

#[cfg(feature = "linear")]
mod cholesky;
#[cfg(feature = "linear")]
mod ordering;
mod pattern;
#[cfg(all(test, feature = "linear"))]
mod tests;

#[cfg(feature = "linear")]
pub use self::cholesky::{Analysis, Cholesky, Kind, Panel};
#[cfg(feature = "linear")]
pub use self::ordering::{Ordering, postordered};
pub use self::pattern::SymmetricPattern;

/// A factorisation of symmetric matrices of one pattern: made once, refactored for other values, solved again and again.
///
/// It owns all that it needs, and so outlives the step that made it.
pub trait Factor: Send + Sync {
    /// n, the number of unknowns.
    fn dim(&self) -> usize;

    /// Factors the matrix with `values` (one a slot) in the place of the one before.
    ///
    /// # Errors
    /// A wrong number of values, a value that is not finite, a matrix that this kind of factor is not for. The factor
    /// is then of no matrix.
    fn refactor(&mut self, values: &[f64]) -> Result<Inertia, FactorError>;

    /// Overwrites right-hand sides with solutions of A x = b: `b` is n × k, column by column, for any k.
    ///
    /// # Errors
    /// A length that is no multiple of n; no matrix factored.
    fn solve(&mut self, b: &mut [f64]) -> Result<(), FactorError>;
}

/// How many eigenvalues of either sign a factored matrix has. It has no others: what is singular to working precision
/// is an error, for its factor solves nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inertia {
    /// Eigenvalues above zero.
    pub positive: usize,
    /// Eigenvalues below zero.
    pub negative: usize,
}

/// Why there is no factor or no solution.
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
        "the matrix is not positive definite to working precision, as its pivot at unknown {unknown} shows: \
         factor it as indefinite, or shift its diagonal"
    )]
    NotPositiveDefinite {
        /// The unknown at whose pivot that shows.
        unknown: usize,
    },
    /// LDLᵀ without pivoting met a pivot that is zero to working precision.
    #[error(
        "the matrix is singular to working precision, or needs pivoting, which this factorisation does not do: \
         its pivot at unknown {unknown} is the rest that larger terms leave"
    )]
    Singular {
        /// The unknown at whose pivot that shows.
        unknown: usize,
    },
    /// No matrix has been factored, or the last one could not be.
    #[error("there is no factor to solve with: factor a matrix first")]
    NotFactored,
    /// The analysis needs more memory or larger indices than there are.
    #[error("a matrix of {n} unknowns and {entries} entries is too large to factor: {reason}")]
    TooLarge {
        /// Unknowns.
        n: usize,
        /// Entries of the lower triangle.
        entries: usize,
        /// What there is too little of.
        reason: String,
    },
    /// An elimination order that is none.
    #[error("the elimination order does not name each of the {n} unknowns once")]
    Order {
        /// Unknowns.
        n: usize,
    },
}
