//! C K⁻¹ Cᵀ of one factored block: forward solves that visit only what the elimination tree connects with each row.

use std::borrow::Cow;

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::halt::Halt;
use crate::Stop;
use crate::linear::{Cholesky, Panel};

/// A coefficient of a row: the row, the step that eliminates the unknown, and the value.
pub(in crate::equilibrium) type Coefficient = (usize, usize, f64);

/// C K⁻¹ Cᵀ (m × m) for the rows with these coefficients, K = LLᵀ being factored.
///
/// With V = L⁻¹Cᵀ it is VᵀV. A column of V is zero but on the paths from the row's unknowns to the root of the
/// elimination tree, and the panels of L are worked off from the leaves: each takes the columns that reach it, solves
/// with its diagonal block, adds its share of VᵀV and passes on what it subtracts further up. V itself is never held.
pub(in crate::equilibrium) fn gram(
    factor: &Cholesky,
    m: usize,
    mut coefficients: Vec<Coefficient>,
    stop: &Stop,
) -> Result<Mat<f64>, Halt> {
    let mut W = Mat::zeros(m, m);
    let panels: Vec<Panel<'_>> = factor.panels().collect();
    let fronts = fronts(&panels);
    let steps = panels.last().map_or(0, |last| last.start + last.size);
    let mut front_of = vec![0; steps];
    for (s, front) in fronts.iter().enumerate() {
        front_of[front.start..front.start + front.size].fill(s);
    }
    coefficients.sort_unstable_by_key(|entry| (entry.1, entry.0));
    let mut coefficients = &coefficients[..];
    let mut waiting: Vec<Vec<Update>> = fronts.iter().map(|_| Vec::new()).collect();
    let mut scratch = Scratch {
        place: vec![NOWHERE; m],
        row: vec![NOWHERE; steps],
    };
    for (s, front) in fronts.iter().enumerate() {
        let end = front.start + front.size;
        let own = coefficients.partition_point(|entry| entry.1 < end);
        let (own, rest) = coefficients.split_at(own);
        coefficients = rest;
        let below = std::mem::take(&mut waiting[s]);
        if own.is_empty() && below.is_empty() {
            continue;
        }
        Halt::if_requested(stop)?;
        let update = front.eliminate(own, below, &fronts, s, &mut scratch, W.as_mut());
        match front.below.first() {
            Some(&step) => waiting[front_of[step]].push(update),
            None => update.scatter(W.as_mut()),
        }
    }
    mirror(&mut W);
    Ok(W)
}

/// Copies the lower triangle to the upper one.
pub(super) fn mirror(W: &mut Mat<f64>) {
    for j in 0..W.ncols() {
        for i in 0..j {
            W[(i, j)] = W[(j, i)];
        }
    }
}

const NOWHERE: usize = usize::MAX;

/// Places of rows and steps in the front at hand.
struct Scratch {
    place: Vec<usize>,
    row: Vec<usize>,
}

/// Neighbouring columns of L with the same entries below, as one dense block.
struct Front<'a> {
    start: usize,
    size: usize,
    below: &'a [usize],
    values: Cow<'a, [f64]>,
}

/// What a front passes on: the columns that have reached it, what they subtract from the right-hand sides below it, and
/// the share of W that has not been added yet.
struct Update {
    front: usize,
    columns: Vec<usize>,
    values: Mat<f64>,
    share: Mat<f64>,
}

impl Update {
    fn scatter(&self, mut W: MatMut<'_, f64>) {
        for (b, &j) in self.columns.iter().enumerate() {
            for (a, &i) in self.columns.iter().enumerate().skip(b) {
                W[(i.max(j), i.min(j))] += self.share[(a, b)];
            }
        }
    }
}

/// The panels, with single columns merged where one continues the other.
fn fronts<'a>(panels: &[Panel<'a>]) -> Vec<Front<'a>> {
    let mut fronts = Vec::new();
    let mut k = 0;
    while k < panels.len() {
        let mut end = k + 1;
        while end < panels.len() && continues(&panels[end - 1], &panels[end]) {
            end += 1;
        }
        fronts.push(Front::merged(&panels[k..end]));
        k = end;
    }
    fronts
}

fn continues(last: &Panel<'_>, next: &Panel<'_>) -> bool {
    let are_single = last.size == 1 && next.size == 1;
    let is_parent = last.below.first() == Some(&next.start);
    are_single && is_parent && last.below.len() == next.below.len() + 1
}

impl<'a> Front<'a> {
    /// One panel, or single columns of which each continues the one before.
    fn merged(panels: &[Panel<'a>]) -> Self {
        let (first, last) = (panels[0], panels[panels.len() - 1]);
        let values = match panels {
            [panel] => Cow::Borrowed(panel.values),
            columns => {
                let height = columns.len() + last.below.len();
                let mut values = vec![0.0; height * columns.len()];
                for (j, column) in columns.iter().enumerate() {
                    values[j * height + j..(j + 1) * height].copy_from_slice(column.values);
                }
                Cow::Owned(values)
            }
        };
        Front {
            start: first.start,
            size: last.start + last.size - first.start,
            below: last.below,
            values,
        }
    }

    /// Solves with the columns of this front: those of its own coefficients and those that come from below it.
    fn eliminate(
        &self,
        own: &[Coefficient],
        mut from: Vec<Update>,
        fronts: &[Front<'_>],
        s: usize,
        scratch: &mut Scratch,
        mut W: MatMut<'_, f64>,
    ) -> Update {
        from.sort_by_key(|update| std::cmp::Reverse(update.columns.len()));
        let Scratch { place, row } = scratch;
        let mut columns: Vec<usize> = Vec::new();
        let arriving = from
            .iter()
            .flat_map(|update| update.columns.iter().copied());
        for i in arriving.chain(own.iter().map(|entry| entry.0)) {
            if place[i] == NOWHERE {
                place[i] = columns.len();
                columns.push(i);
            }
        }
        let height = self.size + self.below.len();
        let steps = (self.start..self.start + self.size).chain(self.below.iter().copied());
        steps.enumerate().for_each(|(k, step)| row[step] = k);

        let mut x = Mat::<f64>::zeros(height, columns.len());
        for &(i, step, a) in own {
            x[(row[step], place[i])] += a;
        }
        for update in &from {
            for (&i, values) in update.columns.iter().zip(update.values.col_iter()) {
                let column = x.col_as_slice_mut(place[i]);
                for (&step, value) in fronts[update.front].below.iter().zip(values.iter()) {
                    column[row[step]] += value;
                }
            }
        }
        columns.iter().for_each(|&i| place[i] = NOWHERE);

        let L = MatRef::from_column_major_slice(&self.values, height, self.size);
        let (diagonal, lower) = L.split_at_row(self.size);
        let (mut top, mut bottom) = x.as_mut().split_at_row_mut(self.size);
        solve_lower_triangular_in_place(diagonal, top.as_mut(), Par::Seq);
        let (add, seq) = (Accum::Add, Par::Seq);
        matmul(bottom.as_mut(), add, lower, top.as_ref(), -1.0, seq);

        let mut share = Mat::new();
        for mut update in from {
            match share.nrows() == 0 && update.columns == columns {
                true => share = std::mem::replace(&mut update.share, Mat::new()),
                false => update.scatter(W.as_mut()),
            }
        }
        if share.nrows() == 0 {
            share = Mat::zeros(columns.len(), columns.len());
        }
        let (full, half) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
        let top = top.as_ref();
        triangular::matmul(
            share.as_mut(),
            half,
            add,
            top.transpose(),
            full,
            top,
            full,
            1.0,
            seq,
        );
        Update {
            front: s,
            values: bottom.to_owned(),
            columns,
            share,
        }
    }
}
