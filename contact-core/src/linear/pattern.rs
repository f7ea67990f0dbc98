//! Sparsity patterns of symmetric matrices.

use std::ops::Range;
use std::sync::Arc;

use crate::nlp::{NlpError, Pattern};

/// The lower triangle of a symmetric n × n matrix in compressed columns, sorted by column, then by row, with no entry
/// repeated. Read as compressed rows, it is the upper triangle.
///
/// The index of an entry in this order is its slot; the values of a matrix are one slice with a value per slot. Clones
/// share the pattern.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SymmetricPattern(Arc<Columns>);

#[derive(Debug, Default)]
struct Columns {
    /// The first slot of each column, and the number of slots.
    starts: Vec<usize>,
    entries: Pattern,
    /// The blocks, where it is the direct sum of more than one.
    blocks: Vec<SymmetricPattern>,
    /// The structure of the factor in the order by minimum degree, once somebody has asked for it.
    #[cfg(feature = "linear")]
    by_degree: std::sync::OnceLock<Arc<super::cholesky::Structure>>,
}

impl PartialEq for Columns {
    fn eq(&self, other: &Self) -> bool {
        self.starts == other.starts && self.entries == other.entries
    }
}

impl Eq for Columns {}

impl SymmetricPattern {
    /// The pattern of `entries` (row, column) of a matrix of `n` unknowns, and the slot of each entry. An entry above
    /// the diagonal stands for its transpose; entries with the same row and column share a slot.
    ///
    /// # Errors
    /// An entry outside n × n.
    pub fn from_entries(
        n: usize,
        entries: &[(usize, usize)],
    ) -> Result<(Self, Vec<usize>), NlpError> {
        if let Some(entry) = entries.iter().position(|&(i, j)| i.max(j) >= n) {
            let (row, col) = entries[entry];
            return Err(NlpError::OutOfRange {
                pattern: "symmetric matrix",
                entry,
                row,
                col,
                rows: n,
                cols: n,
            });
        }
        let lower = |k: usize| {
            (
                entries[k].0.max(entries[k].1),
                entries[k].0.min(entries[k].1),
            )
        };
        // sorted by row, then, keeping that order within, by column
        let by_row = counting_sort(n, (0..entries.len()).collect(), |k| lower(k).0);
        let sorted = counting_sort(n, by_row, |k| lower(k).1);
        let mut slots = vec![0; entries.len()];
        let (mut rows, mut cols) = (Vec::new(), Vec::new());
        let mut last = None;
        for k in sorted {
            if last != Some(lower(k)) {
                let (row, col) = lower(k);
                rows.push(row);
                cols.push(col);
                last = Some((row, col));
            }
            slots[k] = rows.len() - 1;
        }
        let mut starts = vec![0; n + 1];
        cols.iter().for_each(|&col| starts[col + 1] += 1);
        (0..n).for_each(|col| starts[col + 1] += starts[col]);
        Ok((Self::of(starts, rows, cols), slots))
    }

    /// Every entry of an n × n matrix.
    pub fn dense(n: usize) -> Self {
        let entries = (0..n).flat_map(|j| (j..n).map(move |i| (i, j)));
        let (rows, cols) = entries.unzip();
        let starts = (0..=n).map(|j| j * (2 * n + 1 - j) / 2).collect();
        Self::of(starts, rows, cols)
    }

    /// The diagonal of an n × n matrix.
    pub fn diagonal(n: usize) -> Self {
        let all: Vec<usize> = (0..n).collect();
        Self::of((0..=n).collect(), all.clone(), all)
    }

    fn of(starts: Vec<usize>, rows: Vec<usize>, cols: Vec<usize>) -> Self {
        let entries = Pattern::new(rows, cols);
        SymmetricPattern(Arc::new(Columns {
            starts,
            entries,
            ..Columns::default()
        }))
    }

    /// Where the structure of the factor by minimum degree is kept, for all clones.
    #[cfg(feature = "linear")]
    pub(super) fn by_degree(&self) -> &std::sync::OnceLock<Arc<super::cholesky::Structure>> {
        &self.0.by_degree
    }

    /// The pattern of entries with values, as [`SymmetricPattern::from_entries`], and the sum of the values in each
    /// slot.
    ///
    /// # Errors
    /// An entry outside n × n.
    pub fn from_sums(
        n: usize,
        entries: &[(usize, usize, f64)],
    ) -> Result<(Self, Vec<f64>), NlpError> {
        let places: Vec<_> = entries.iter().map(|&(i, j, _)| (i, j)).collect();
        let (pattern, slots) = Self::from_entries(n, &places)?;
        let mut values = vec![0.0; pattern.len()];
        let entries = slots.into_iter().zip(entries);
        entries.for_each(|(slot, (_, _, a))| values[slot] += a);
        Ok((pattern, values))
    }

    /// The block diagonal pattern with these blocks; their slots are consecutive.
    pub fn direct_sum<'a>(blocks: impl IntoIterator<Item = &'a SymmetricPattern>) -> Self {
        let blocks: Vec<&SymmetricPattern> = blocks.into_iter().collect();
        if let [only] = blocks[..] {
            return only.clone();
        }
        let (mut starts, mut rows, mut cols) = (vec![0], Vec::new(), Vec::new());
        for block in &blocks {
            let (n, slots) = (starts.len() - 1, rows.len());
            starts.extend(block.starts()[1..].iter().map(|s| slots + s));
            rows.extend(block.rows().iter().map(|i| n + i));
            cols.extend(block.cols().iter().map(|j| n + j));
        }
        SymmetricPattern(Arc::new(Columns {
            starts,
            entries: Pattern::new(rows, cols),
            blocks: blocks.into_iter().cloned().collect(),
            ..Columns::default()
        }))
    }

    /// The pattern with `more` entries (row, column), in any order and as often as they come, and the new slot of each
    /// slot of this one. An entry above the diagonal stands for its transpose.
    ///
    /// # Errors
    /// An entry outside n × n.
    pub fn with(&self, more: &[(usize, usize)]) -> Result<(Self, Vec<usize>), NlpError> {
        let (more, _) = Self::from_entries(self.dim(), more)?;
        let (mut rows, mut cols) = (Vec::new(), Vec::new());
        let (mut starts, mut slots) = (vec![0], Vec::with_capacity(self.len()));
        for col in 0..self.dim() {
            let mut new = more.column(col).map(|slot| more.rows()[slot]).peekable();
            for slot in self.column(col) {
                let row = self.rows()[slot];
                while let Some(before) = new.next_if(|&other| other < row) {
                    rows.push(before);
                }
                new.next_if_eq(&row);
                slots.push(rows.len());
                rows.push(row);
            }
            rows.extend(new);
            cols.resize(rows.len(), col);
            starts.push(rows.len());
        }
        Ok((Self::of(starts, rows, cols), slots))
    }

    /// n, the number of unknowns.
    pub fn dim(&self) -> usize {
        self.0.starts.len().saturating_sub(1)
    }

    /// Number of slots.
    pub fn len(&self) -> usize {
        self.0.entries.len()
    }

    /// Whether it has no slots.
    pub fn is_empty(&self) -> bool {
        self.0.entries.is_empty()
    }

    /// The row of each slot, on or below the diagonal.
    pub fn rows(&self) -> &[usize] {
        self.0.entries.rows()
    }

    /// The column of each slot.
    pub fn cols(&self) -> &[usize] {
        self.0.entries.cols()
    }

    /// The first slot of each column and, last, the number of slots: n + 1 in all.
    pub fn starts(&self) -> &[usize] {
        match self.0.starts.is_empty() {
            true => &[0],
            false => &self.0.starts,
        }
    }

    /// The slots of a column.
    pub fn column(&self, col: usize) -> Range<usize> {
        self.0.starts[col]..self.0.starts[col + 1]
    }

    /// Row and column of each slot.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (usize, usize)> + '_ {
        self.0.entries.iter()
    }

    /// Row and column of each slot, as a list for an [`Nlp`](crate::nlp::Nlp).
    pub fn entries(&self) -> &Pattern {
        &self.0.entries
    }

    /// The block of these unknowns, whose slots are in the same order.
    ///
    /// # Errors
    /// An entry that couples them with unknowns after them.
    pub fn block(&self, range: &Range<usize>) -> Result<Self, NlpError> {
        if *range == (0..self.dim()) {
            return Ok(self.clone());
        }
        let mut start = 0;
        for block in &self.0.blocks {
            if *range == (start..start + block.dim()) {
                return Ok(block.clone());
            }
            start += block.dim();
        }
        let slots = self.starts()[range.start]..self.starts()[range.end];
        let own = |all: &[usize]| all[slots.clone()].iter().map(|k| k - range.start).collect();
        let (rows, cols): (Vec<usize>, Vec<usize>) = (own(self.rows()), own(self.cols()));
        if rows.iter().any(|&row| row >= range.len()) {
            let places: Vec<_> = rows.into_iter().zip(cols).collect();
            return Ok(Self::from_entries(range.len(), &places)?.0);
        }
        let starts = self.starts()[range.start..=range.end].iter();
        let starts = starts.map(|start| start - slots.start).collect();
        Ok(Self::of(starts, rows, cols))
    }

    /// The slot of the entry (i, j), which it shares with (j, i).
    pub fn slot(&self, i: usize, j: usize) -> Option<usize> {
        let slots = self.column(i.min(j));
        let rows = &self.rows()[slots.clone()];
        rows.binary_search(&i.max(j)).ok().map(|k| slots.start + k)
    }

    /// y = A x of the symmetric matrix A with these `values`.
    pub fn product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        let rows = self.rows();
        for j in 0..self.dim() {
            let mut sum = 0.0;
            let column = self.column(j);
            for (&i, a) in rows[column.clone()].iter().zip(&values[column]) {
                sum += a * x[i];
                if i != j {
                    y[i] += a * x[j];
                }
            }
            y[j] += sum;
        }
    }
}

/// `items` in ascending order of `key` < `n`; those with equal keys keep their order.
fn counting_sort(n: usize, items: Vec<usize>, key: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut next = vec![0; n + 1];
    items.iter().for_each(|&k| next[key(k) + 1] += 1);
    (0..n).for_each(|k| next[k + 1] += next[k]);
    let mut sorted = vec![0; items.len()];
    for k in items {
        sorted[next[key(k)]] = k;
        next[key(k)] += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_mirrored_sorted_and_merged() {
        let entries = [(2, 0), (1, 1), (0, 2), (0, 0), (3, 1), (2, 2), (1, 1)];
        let (pattern, slots) = SymmetricPattern::from_entries(4, &entries).expect("in range");
        let expected = [(0, 0), (2, 0), (1, 1), (3, 1), (2, 2)];
        assert!(pattern.iter().eq(expected));
        assert_eq!(slots, [1, 2, 1, 0, 3, 4, 2]);
        assert_eq!(pattern.starts(), [0, 2, 4, 5, 5]);
        for (slot, (i, j)) in expected.into_iter().enumerate() {
            assert_eq!(pattern.slot(i, j), Some(slot));
            assert_eq!(pattern.slot(j, i), Some(slot));
        }
        assert_eq!((pattern.slot(3, 3), pattern.slot(1, 0)), (None, None));
    }

    #[test]
    fn entries_out_of_range_are_named() {
        let error = SymmetricPattern::from_entries(2, &[(0, 0), (1, 2)]).expect_err("2 × 2");
        assert!(matches!(
            error,
            NlpError::OutOfRange {
                entry: 1,
                col: 2,
                ..
            }
        ));
    }

    #[test]
    fn nothing_is_a_pattern() {
        let (none, slots) = SymmetricPattern::from_entries(0, &[]).expect("nothing to refuse");
        assert_eq!((none.dim(), none.len(), slots.len()), (0, 0, 0));
        assert_eq!(none.starts(), [0]);
        assert_eq!(SymmetricPattern::default().starts(), [0]);
        none.product(&[], &[], &mut []);
    }

    #[test]
    fn a_sum_of_blocks_is_the_pattern_of_all_entries() {
        let first = [(0, 0), (1, 0), (1, 1)];
        let second = [(0, 0), (2, 1)];
        let shifted = second.map(|(i, j)| (i + 2, j + 2));
        let of = |n, entries: &[_]| SymmetricPattern::from_entries(n, entries).expect("fits").0;
        let (empty, blocks) = (of(0, &[]), [of(2, &first), of(3, &second)]);
        let sum = SymmetricPattern::direct_sum([&blocks[0], &empty, &blocks[1]]);
        assert_eq!(sum, of(5, &[&first[..], &shifted[..]].concat()));
    }

    #[test]
    fn full_and_diagonal_patterns() {
        let of = |n, entries: &[_]| SymmetricPattern::from_entries(n, entries).expect("fits").0;
        for n in 0..4 {
            let all: Vec<_> = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).collect();
            assert_eq!(SymmetricPattern::dense(n), of(n, &all));
            let diagonal: Vec<_> = (0..n).map(|i| (i, i)).collect();
            assert_eq!(SymmetricPattern::diagonal(n), of(n, &diagonal));
        }
    }

    /// Random patterns and places, some of them twice, mirrored or there already.
    #[test]
    fn a_pattern_with_more_entries_is_the_pattern_of_all_entries() {
        let mut random = fastrand::Rng::with_seed(3);
        let (mut old_slots, mut new_places) = (0, 0);
        for case in 0..300 {
            let n = random.usize(1..12);
            let mut entries = |most: usize| -> Vec<(usize, usize)> {
                let count = random.usize(0..=most);
                let place = |_| (random.usize(0..n), random.usize(0..n));
                (0..count).map(place).collect()
            };
            let (first, more) = (entries(3 * n), entries(2 * n));
            let (pattern, _) = SymmetricPattern::from_entries(n, &first).expect("in range");
            let (all, _) = SymmetricPattern::from_entries(n, &[first, more.clone()].concat())
                .expect("in range");
            let (with, slots) = pattern.with(&more).expect("in range");
            assert_eq!(with, all, "{case}");
            assert_eq!(slots.len(), pattern.len(), "{case}");
            for ((i, j), slot) in pattern.iter().zip(&slots) {
                assert_eq!(all.slot(i, j), Some(*slot), "{case}: ({i}, {j})");
            }
            old_slots += slots.len();
            new_places += all.len() - pattern.len();
        }
        assert!(
            old_slots > 1000 && new_places > 1000,
            "{old_slots} {new_places}"
        );
    }

    #[test]
    fn no_entry_more_changes_nothing_and_one_out_of_range_is_refused() {
        let pattern = SymmetricPattern::dense(3);
        for more in [&[][..], &[(0, 2), (2, 0), (1, 1)]] {
            let (with, slots) = pattern.with(more).expect("in range");
            assert_eq!(with, pattern);
            assert_eq!(slots, [0, 1, 2, 3, 4, 5]);
        }
        let (full, slots) = SymmetricPattern::diagonal(2)
            .with(&[(0, 1)])
            .expect("in range");
        assert_eq!((full, slots), (SymmetricPattern::dense(2), vec![0, 2]));
        assert!(matches!(
            pattern.with(&[(0, 0), (3, 1)]),
            Err(NlpError::OutOfRange {
                entry: 1,
                row: 3,
                ..
            })
        ));
        let (none, slots) = SymmetricPattern::default().with(&[]).expect("nothing");
        assert_eq!((none.dim(), none.len(), slots.len()), (0, 0, 0));
    }

    #[test]
    fn the_product_is_that_of_both_triangles() {
        let dense = [[2.0, -1.0, 0.5], [-1.0, 3.0, 0.0], [0.5, 0.0, 0.0]];
        let (pattern, _) =
            SymmetricPattern::from_entries(3, &[(0, 0), (1, 0), (2, 0), (1, 1)]).expect("fits");
        let values: Vec<f64> = pattern.iter().map(|(i, j)| dense[i][j]).collect();
        let x = [1.0, 2.0, -4.0];
        let mut y = [f64::NAN; 3];
        pattern.product(&values, &x, &mut y);
        assert_eq!(
            y,
            dense.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
        );
    }
}
