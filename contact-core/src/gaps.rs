//! The linearised weak non-penetration constraints c(u) = C u + c₀ ≥ 0.

/// The part of a surface that a row of gaps stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub enum Sampling {
    /// A contact node: its mean gap, weighted with the node's test function.
    Nodes,
    /// An integration point: the gap there.
    Points,
}

/// Identifies a constraint. A key denotes the same contact node in the same role in every fixed-point
/// iteration and load step, so that multipliers can be carried over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct RowKey {
    /// The pass: one for each ordered pair (slave surface, master surface).
    pub pass: u32,
    /// The slave node, or the index of the integration point within the pass.
    pub node: u32,
}

/// One sparse row, to be appended to [`LinearGaps`] or copied from it: entries `(dof, coefficient)` of
/// the FREE and of the PRESCRIBED unknowns, and the constant.
#[derive(Clone, Debug)]
pub struct Row {
    /// Coefficients of free unknowns, at most one entry per unknown.
    pub free: Vec<(usize, f64)>,
    /// Coefficients of prescribed unknowns; `constant` already contains their contribution.
    pub prescribed: Vec<(usize, f64)>,
    /// c₀ of this row (UL).
    pub constant: f64,
    /// a_i, the reference measure of the surface that this row stands for (UL in the plane, UL² in
    /// space); 1 where there is no surface.
    pub weight: f64,
}

impl Default for Row {
    fn default() -> Self {
        Row {
            free: Vec::new(),
            prescribed: Vec::new(),
            constant: 0.0,
            weight: 1.0,
        }
    }
}

/// A sparse matrix in compressed rows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct SparseRows {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl SparseRows {
    /// A matrix without rows.
    pub fn new() -> Self {
        SparseRows {
            starts: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Appends a row of `(column, value)`. Entries of one column add up.
    pub fn push(&mut self, entries: &[(usize, f64)]) {
        self.columns.extend(entries.iter().map(|e| e.0));
        self.values.extend(entries.iter().map(|e| e.1));
        self.starts.push(self.columns.len());
    }

    /// Whether these are `m` rows.
    #[cfg(feature = "resume")]
    pub(crate) fn is_whole(&self, m: usize) -> bool {
        let entries = self.columns.len();
        let ends = [self.starts.first(), self.starts.last()];
        self.starts.len() == m + 1
            && ends == [Some(&0), Some(&entries)]
            && self.starts.is_sorted()
            && self.values.len() == entries
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of columns up to the last one that is used.
    pub fn columns(&self) -> usize {
        self.columns.iter().max().map_or(0, |last| last + 1)
    }

    /// The entries `(column, value)` of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        let values = self.values[range.clone()].iter().copied();
        self.columns[range].iter().copied().zip(values)
    }

    /// The same rows with the columns that `place` renumbers; entries in others are left out.
    #[cfg(feature = "linear")]
    pub(crate) fn renumbered(&self, place: impl Fn(usize) -> Option<usize>) -> Self {
        let mut rows = SparseRows::new();
        let mut entries = Vec::new();
        for i in 0..self.len() {
            entries.clear();
            entries.extend(self.row(i).filter_map(|(j, a)| Some((place(j)?, a))));
            rows.push(&entries);
        }
        rows
    }

    /// (A x)_i.
    pub fn times(&self, i: usize, x: &[f64]) -> f64 {
        self.row(i).map(|(j, a)| a * x[j]).sum()
    }

    /// Adds Aᵀλ to `out`.
    pub fn add_transpose(&self, lambda: &[f64], out: &mut [f64]) {
        for (i, &l) in lambda.iter().enumerate() {
            for (j, a) in self.row(i) {
                out[j] += a * l;
            }
        }
    }
}

impl Default for SparseRows {
    fn default() -> Self {
        SparseRows::new()
    }
}

/// c(u) = C u + c₀ ≥ 0, one row per contact node with support in reach (method (7) of the paper).
///
/// Each row is divided by its a_i, so c is a length (UL) and its multiplier a force (UF).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearGaps {
    keys: Vec<RowKey>,
    free: SparseRows,
    prescribed: SparseRows,
    constant: Vec<f64>,
    weights: Vec<f64>,
    exact: bool,
    sampling: Sampling,
}

impl LinearGaps {
    /// Constraints without rows. `exact` states that they are linear in u (small strain), so that
    /// one solve suffices.
    pub fn new(exact: bool) -> Self {
        LinearGaps {
            keys: Vec::new(),
            free: SparseRows::new(),
            prescribed: SparseRows::new(),
            constant: Vec::new(),
            weights: Vec::new(),
            exact,
            sampling: Sampling::Nodes,
        }
    }

    /// The union of these rows and `others`, merged pass by pass: step 4 of Algorithm 2, which joins the
    /// rows of both roles. Within a pass these rows precede `others`; either keep their order.
    pub fn and(self, others: LinearGaps) -> LinearGaps {
        let exact = self.exact && others.exact;
        if others.is_empty() {
            return LinearGaps { exact, ..self };
        }
        if self.is_empty() {
            return LinearGaps { exact, ..others };
        }
        let mut all = LinearGaps::new(exact).sampled_at(self.sampling);
        let mut left = (0..self.len()).peekable();
        let mut right = (0..others.len()).peekable();
        loop {
            let (rows, i) = match (left.peek(), right.peek()) {
                (Some(&i), Some(&j)) if self.keys[i].pass <= others.keys[j].pass => {
                    left.next();
                    (&self, i)
                }
                (_, Some(&j)) => {
                    right.next();
                    (&others, j)
                }
                (Some(&i), None) => {
                    left.next();
                    (&self, i)
                }
                (None, None) => return all,
            };
            all.push(rows.keys[i], &rows.row(i));
        }
    }

    /// These constraints with another [`Sampling`]; the default is [`Sampling::Nodes`].
    pub fn sampled_at(self, sampling: Sampling) -> Self {
        LinearGaps { sampling, ..self }
    }

    /// The same rows over the unknowns that `place` renumbers; no row may have entries in others.
    #[cfg(feature = "linear")]
    pub(crate) fn renumbered(self, place: impl Fn(usize) -> Option<usize>) -> Self {
        LinearGaps {
            free: self.free.renumbered(place),
            ..self
        }
    }

    /// Appends a row. Keys must be unique; they need not be sorted.
    pub fn push(&mut self, key: RowKey, row: &Row) {
        self.keys.push(key);
        self.free.push(&row.free);
        self.prescribed.push(&row.prescribed);
        self.constant.push(row.constant);
        self.weights.push(row.weight);
    }

    /// Whether these are rows over `dofs` free unknowns, as those that were pushed are.
    #[cfg(feature = "resume")]
    pub(crate) fn is_whole(&self, dofs: usize) -> bool {
        let m = self.keys.len();
        let lengths = [self.constant.len(), self.weights.len()];
        let matrices = [&self.free, &self.prescribed];
        lengths == [m; 2]
            && matrices.iter().all(|rows| rows.is_whole(m))
            && self.free.columns() <= dofs
    }

    /// m, the number of rows.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Whether the rows hold for every u, not only near the point of linearisation.
    pub fn is_exact(&self) -> bool {
        self.exact
    }

    /// The parts of the surface that the rows stand for.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// The key of each row (m).
    pub fn keys(&self) -> &[RowKey] {
        &self.keys
    }

    /// c₀ (m, UL).
    pub fn constant(&self) -> &[f64] {
        &self.constant
    }

    /// a_i (m), the reference measure of each row.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The numbers of free and of prescribed unknowns up to the last one that has a coefficient.
    pub fn columns(&self) -> [usize; 2] {
        [self.free.columns(), self.prescribed.columns()]
    }

    /// C (m × n).
    pub fn matrix(&self) -> &SparseRows {
        &self.free
    }

    /// The nonzeros of C, row by row, as `(row, free unknown, coefficient)`.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.len()).flat_map(|i| self.free.row(i).map(move |(j, a)| (i, j, a)))
    }

    /// A copy of row `i`, to be appended elsewhere.
    pub fn row(&self, i: usize) -> Row {
        Row {
            free: self.free.row(i).collect(),
            prescribed: self.prescribed.row(i).collect(),
            constant: self.constant[i],
            weight: self.weights[i],
        }
    }

    /// c(u) = C u + c₀ into `c` (m, UL).
    pub fn value(&self, u: &[f64], c: &mut [f64]) {
        for (i, c) in c.iter_mut().enumerate() {
            *c = self.constant[i] + self.free.times(i, u);
        }
    }

    /// Adds the contact forces Cᵀλ on the free unknowns to `forces` (n, UF).
    pub fn add_forces(&self, lambda: &[f64], forces: &mut [f64]) {
        self.free.add_transpose(lambda, forces);
    }

    /// Adds the contact forces on the prescribed unknowns to `forces` (UF).
    pub fn add_prescribed_forces(&self, lambda: &[f64], forces: &mut [f64]) {
        self.prescribed.add_transpose(lambda, forces);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces Cᵀλ do the work that λ does on gaps: λ·(c(u) − c₀) = (Cᵀλ)·u, exactly in these numbers.
    #[test]
    fn forces_do_the_work_of_their_gaps() {
        let mut gaps = LinearGaps::new(true);
        let rows = [
            (vec![(0, 2.0), (3, -1.0)], vec![(1, 4.0)], 0.5),
            (vec![(1, 0.25), (0, -8.0), (1, 0.25)], vec![], -3.0),
        ];
        for (node, (free, prescribed, constant)) in rows.into_iter().enumerate() {
            let key = RowKey {
                pass: 0,
                node: node as u32,
            };
            let row = Row {
                free,
                prescribed,
                constant,
                weight: 1.0,
            };
            gaps.push(key, &row);
        }
        let (u, lambda) = ([1.0, -2.0, 5.0, 0.5], [3.0, 7.0]);
        let mut c = [0.0; 2];
        gaps.value(&u, &mut c);
        assert_eq!(c, [0.5 + 2.0 - 0.5, -3.0 - 1.0 - 8.0]);
        let mut forces = [1.0; 4];
        gaps.add_forces(&lambda, &mut forces);
        assert_eq!(forces, [1.0 + 6.0 - 56.0, 1.0 + 3.5, 1.0, 1.0 - 3.0]);
        let mut held = [0.0; 2];
        gaps.add_prescribed_forces(&lambda, &mut held);
        assert_eq!(held, [0.0, 12.0]);
    }
}
