//! Sparsity patterns.

use std::sync::{Arc, OnceLock};

use super::NlpError;

/// The sparsity pattern of a matrix: row and column of each entry, counted from 0, in the order of the values.
///
/// Clones share the entries, the result of their check and their form for the solver: a pattern used by many problems
/// is checked and converted once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pattern(Arc<Entries>);

#[derive(Debug, Clone, Default)]
struct Entries {
    rows: Vec<usize>,
    cols: Vec<usize>,
    /// n, if the entries have been checked to be in the lower triangle of an n × n matrix without repetition.
    is_lower_of: OnceLock<usize>,
    /// Rows and columns in 32 bits.
    narrow: OnceLock<(Vec<i32>, Vec<i32>)>,
}

impl PartialEq for Entries {
    fn eq(&self, other: &Self) -> bool {
        self.rows == other.rows && self.cols == other.cols
    }
}

impl Eq for Entries {}

impl Entries {
    fn new(rows: Vec<usize>, cols: Vec<usize>) -> Self {
        Entries {
            rows,
            cols,
            ..Entries::default()
        }
    }
}

impl Pattern {
    /// The entries (`rows[k]`, `cols[k]`). [`Structure::new`](super::Structure::new) checks that both have the same length.
    pub fn new(rows: Vec<usize>, cols: Vec<usize>) -> Self {
        Self(Arc::new(Entries::new(rows, cols)))
    }

    /// No entries.
    pub fn empty() -> Self {
        Self::default()
    }

    /// Every entry of a matrix, row by row.
    pub fn dense(rows: usize, cols: usize) -> Self {
        (0..rows)
            .flat_map(|i| (0..cols).map(move |j| (i, j)))
            .collect()
    }

    /// Every entry of the lower triangle, row by row.
    pub fn dense_lower(n: usize) -> Self {
        (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).collect()
    }

    /// The diagonal.
    pub fn diagonal(n: usize) -> Self {
        (0..n).map(|i| (i, i)).collect()
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.0.rows.len()
    }

    /// Whether it has no entries.
    pub fn is_empty(&self) -> bool {
        self.0.rows.is_empty()
    }

    /// The row of each entry.
    pub fn rows(&self) -> &[usize] {
        &self.0.rows
    }

    /// The column of each entry.
    pub fn cols(&self) -> &[usize] {
        &self.0.cols
    }

    /// The entries in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (usize, usize)> + '_ {
        self.0.rows.iter().copied().zip(self.0.cols.iter().copied())
    }

    /// Adds one entry.
    pub fn push(&mut self, row: usize, col: usize) {
        let entries = Arc::make_mut(&mut self.0);
        entries.rows.push(row);
        entries.cols.push(col);
        entries.is_lower_of = OnceLock::new();
        entries.narrow = OnceLock::new();
    }

    /// Rows and columns as 32-bit integers, for a pattern whose indices fit.
    #[cfg(feature = "ipopt")]
    pub(crate) fn narrow(&self) -> &(Vec<i32>, Vec<i32>) {
        let narrow = |index: &usize| i32::try_from(*index).unwrap_or(i32::MAX);
        self.0.narrow.get_or_init(|| {
            let rows = self.rows().iter().map(narrow).collect();
            (rows, self.cols().iter().map(narrow).collect())
        })
    }

    pub(super) fn validate(
        &self,
        pattern: &'static str,
        rows: usize,
        cols: usize,
    ) -> Result<(), NlpError> {
        if self.0.cols.len() != self.0.rows.len() {
            return Err(NlpError::Length {
                what: "the columns of a pattern",
                found: self.0.cols.len(),
                expected: self.0.rows.len(),
            });
        }
        match self
            .iter()
            .position(|(row, col)| row >= rows || col >= cols)
        {
            Some(entry) => {
                let (row, col) = (self.0.rows[entry], self.0.cols[entry]);
                Err(NlpError::OutOfRange {
                    pattern,
                    entry,
                    row,
                    col,
                    rows,
                    cols,
                })
            }
            None => Ok(()),
        }
    }

    /// Checks that the entries are in the lower triangle of an n × n matrix and do not repeat.
    pub(super) fn validate_lower_once(&self, n: usize) -> Result<(), NlpError> {
        if self.0.is_lower_of.get() == Some(&n) {
            return Ok(());
        }
        self.validate("Hessian", n, n)?;
        if let Some((entry, (row, col))) = self.iter().enumerate().find(|(_, (row, col))| col > row)
        {
            return Err(NlpError::UpperTriangle { entry, row, col });
        }
        match self.repeated(n, n) {
            Some(entry) => Err(NlpError::Duplicate {
                entry,
                row: self.0.rows[entry],
                col: self.0.cols[entry],
            }),
            None => {
                // one n is remembered; a check for another n is repeated each time
                let _ = self.0.is_lower_of.set(n);
                Ok(())
            }
        }
    }

    /// An entry with the same row and column as an earlier one, if there is one. Indices must be in range.
    pub(super) fn repeated(&self, rows: usize, cols: usize) -> Option<usize> {
        // Entries sorted by row (counting), then one mark per column.
        let mut start = vec![0; rows + 1];
        for &row in &self.0.rows {
            start[row + 1] += 1;
        }
        for row in 0..rows {
            start[row + 1] += start[row];
        }
        let mut order = vec![0; self.len()];
        let mut next = start.clone();
        for (entry, &row) in self.0.rows.iter().enumerate() {
            order[next[row]] = entry;
            next[row] += 1;
        }
        let mut seen_in_row = vec![usize::MAX; cols];
        order.into_iter().find(|&entry| {
            let (row, col) = (self.0.rows[entry], self.0.cols[entry]);
            std::mem::replace(&mut seen_in_row[col], row) == row
        })
    }
}

impl FromIterator<(usize, usize)> for Pattern {
    fn from_iter<I: IntoIterator<Item = (usize, usize)>>(entries: I) -> Self {
        let (rows, cols) = entries.into_iter().unzip();
        Pattern::new(rows, cols)
    }
}
