//! Sparse LLᵀ and LDLᵀ by faer.

use std::ops::Range;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::ordering::{inverse, nested_dissection};
use super::{Factor, FactorError, Inertia, Ordering, SymmetricPattern};
use crate::{Error, MemoryError, memory, parallel};

/// The places of a factor's entries.
pub(super) type Structure = SymbolicCholesky<usize>;

/// What the factors of all matrices of one pattern share: the order of elimination and the places of their entries. A
/// clone shares it.
#[derive(Clone, Debug)]
pub struct Analysis {
    pattern: SymmetricPattern,
    symbolic: Arc<Structure>,
}

impl Analysis {
    /// Analyses the pattern.
    ///
    /// # Errors
    /// An order that is none, a pattern too large.
    pub fn new(pattern: &SymmetricPattern, ordering: &Ordering) -> Result<Self, FactorError> {
        let n = pattern.dim();
        let order = match ordering {
            Ordering::Automatic => return Self::automatic(pattern),
            Ordering::MinimumDegree => None,
            Ordering::NestedDissection => nested_dissection(pattern),
            // faer takes the lower triangle for the upper one where it is not to permute
            Ordering::Natural => Some((0..n).collect()),
            Ordering::Given(order) => Some(order.clone()),
        };
        Self::in_order(pattern, order.as_deref())
    }

    /// The analyses of diagonal blocks with these unknowns; blocks with the same pattern share one.
    ///
    /// # Errors
    /// As [`Analysis::new`], and blocks that are coupled.
    pub(crate) fn of_blocks(
        pattern: &SymmetricPattern,
        blocks: &[Range<usize>],
        ordering: &Ordering,
    ) -> Result<Vec<Self>, Error> {
        let mut distinct = Vec::<SymmetricPattern>::new();
        let mut numbers = Vec::with_capacity(blocks.len());
        for range in blocks {
            let own = pattern.block(range)?;
            let known = distinct.iter().position(|other| *other == own);
            numbers.push(known.unwrap_or(distinct.len()));
            if known.is_none() {
                distinct.push(own);
            }
        }
        let analyses = parallel::try_map(&distinct, |own| Self::new(own, ordering))?;
        Ok(numbers.into_iter().map(|k| analyses[k].clone()).collect())
    }

    fn automatic(pattern: &SymmetricPattern) -> Result<Self, FactorError> {
        let first = Self::in_order(pattern, None)?;
        if first.fill() <= DENSE * pattern.dim() {
            return Ok(first);
        }
        let Some(order) = nested_dissection(pattern) else {
            return Ok(first);
        };
        let second = Self::in_order(pattern, Some(&order))?;
        Ok(if second.fill() < first.fill() {
            second
        } else {
            first
        })
    }

    /// In the order given, or else by minimum degree, which is analysed once a pattern.
    fn in_order(pattern: &SymmetricPattern, order: Option<&[usize]>) -> Result<Self, FactorError> {
        let of = |symbolic| Analysis {
            symbolic,
            pattern: pattern.clone(),
        };
        let known = pattern.by_degree();
        match (order, known.get()) {
            (Some(_), _) => Ok(of(Arc::new(structure(pattern, order)?))),
            (None, Some(symbolic)) => Ok(of(symbolic.clone())),
            (None, None) => {
                let symbolic = Arc::new(structure(pattern, None)?);
                Ok(of(known.get_or_init(|| symbolic).clone()))
            }
        }
    }

    /// The pattern.
    pub fn pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    /// Entries of the factor L, with the zeros that its dense blocks hold.
    pub fn fill(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Bytes of a factor, and of the memory to compute it.
    pub fn bytes(&self) -> u64 {
        let scratch = scratch(self, Kind::Llt, 1).or(scratch(self, Kind::Ldlt, 1));
        let of_steps = size_of::<f64>() * (self.fill() + self.pattern.dim());
        (of_steps + scratch.unaligned_bytes_required()) as u64
    }

    /// The step that eliminates each unknown (n).
    pub fn steps(&self) -> Vec<usize> {
        let mut steps = vec![0; self.pattern.dim()];
        (0..steps.len()).for_each(|step| steps[self.unknown(step)] = step);
        steps
    }

    /// The unknown eliminated at step `k`.
    pub fn unknown(&self, k: usize) -> usize {
        self.symbolic.perm().map_or(k, |perm| perm.arrays().0[k])
    }
}

/// From so many entries of the factor an unknown on, METIS is asked for an order with fewer.
///
/// Its order takes one to three times as long as a factorisation. Measured, METIS over AMD, in entries of the factor
/// and in the time of LLᵀ:
///
/// | matrix, one body unless said | unknowns | entries by AMD an unknown | entries | time |
/// |---|---|---|---|---|
/// | ring, P1 | 20 000 | 56 | 0.98 | 1.0 |
/// | ring, P1 | 80 000 | 73 | 0.86 | 0.83 |
/// | beam 4 × 4 × 16, P2 (three: 23 000) | 7 800 | 212 | 1.10 | 1.17 |
/// | beam 6 × 6 × 20, P2 (three: 61 000) | 20 000 | 394 | 0.99 (0.95) | 0.94 (0.89) |
/// | beam 12 × 12 × 40, P1 | 20 000 | 475 | 0.70 | 0.58 |
/// | cube of 10 cells a side, P1 | 3 600 | 223 | 0.84 | 0.7 |
/// | cube of 16 cells a side, P1 | 14 000 | 596 | 0.58 | 0.39 |
/// | cube of 9 cells a side, P2 | 19 000 | 556 | 0.79 | 0.57 |
const DENSE: usize = 300;

fn too_large(pattern: &SymmetricPattern, reason: FaerError) -> FactorError {
    match reason {
        FaerError::OutOfMemory => exhausted(pattern),
        reason => FactorError::TooLarge {
            n: pattern.dim(),
            entries: pattern.len(),
            reason: format!("{reason:?}"),
        },
    }
}

fn exhausted(pattern: &SymmetricPattern) -> FactorError {
    FactorError::Memory(MemoryError::Exhausted {
        what: WHAT,
        unknowns: pattern.dim(),
    })
}

/// What takes the memory.
const WHAT: &str = "the factor of a linear system";
/// From so many bytes on, what the system has left is looked at before they are taken.
const MANY: u64 = 32 << 20;

fn structure(
    pattern: &SymmetricPattern,
    order: Option<&[usize]>,
) -> Result<Structure, FactorError> {
    let n = pattern.dim();
    let step = order.map(|order| match order.len() == n {
        true => inverse(order),
        false => Err(FactorError::Order { n }),
    });
    let step = step.transpose()?;
    let ordering = match (order, &step) {
        (Some(order), Some(step)) => {
            SymmetricOrdering::Custom(PermRef::new_checked(order, step, n))
        }
        _ => SymmetricOrdering::Amd,
    };
    let (lower, params) = (symbolic(pattern), CholeskySymbolicParams::default());
    let structure = factorize_symbolic_cholesky(lower, Side::Lower, ordering, params);
    structure.map_err(|e| too_large(pattern, e))
}

fn symbolic(pattern: &SymmetricPattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.dim();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows())
}

/// What is factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A = LLᵀ: positive definite matrices only, backward stable.
    Llt,
    /// A = LDLᵀ with a diagonal D, whose signs are the inertia, and no pivoting. Indefinite matrices may need
    /// pivoting; then there is an error, or a solution less accurate than its residual would have to be.
    Ldlt,
}

/// A Cholesky factor, with the memory to refactor it and to solve with it.
pub struct Cholesky {
    analysis: Analysis,
    kind: Kind,
    values: Vec<f64>,
    is_factored: bool,
    /// Σ_k l_ik² |d_k| of each row of L, by step.
    scales: Vec<f64>,
    memory: MemBuffer,
    /// How many right-hand sides at once `memory` suffices for.
    columns: usize,
}

/// Columns of L that share their entries below the diagonal block: `values` holds the diagonal block, `size` ×
/// `size`, and below it the rows `below`, column by column. For LDLᵀ the diagonal is that of D; above it is nothing
/// of meaning.
#[derive(Clone, Copy, Debug)]
pub struct Panel<'a> {
    /// The step that eliminates the first column.
    pub start: usize,
    /// Number of columns.
    pub size: usize,
    /// The steps of the rows below, ascending.
    pub below: &'a [usize],
    /// (size + below) × size.
    pub values: &'a [f64],
}

impl Panel<'_> {
    /// Row (step) and value of the entries of its column `j`, the diagonal one first.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> {
        let height = self.size + self.below.len();
        let steps = (self.start..self.start + self.size).chain(self.below.iter().copied());
        let values = &self.values[j * height..(j + 1) * height];
        steps.zip(values.iter().copied()).skip(j)
    }
}

/// So many right-hand sides are solved at once: enough for dense blocks, few enough for the caches.
const COLUMNS: usize = 64;

impl Cholesky {
    /// A factor of no matrix yet, with the memory that one needs.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(analysis: &Analysis, kind: Kind) -> Result<Self, FactorError> {
        let bytes = analysis.bytes();
        if bytes > MANY {
            memory::check(WHAT, bytes)?;
        }
        let mut values = Vec::new();
        let reserved = values.try_reserve_exact(analysis.fill());
        reserved.map_err(|_| exhausted(&analysis.pattern))?;
        values.resize(analysis.fill(), 0.0);
        Ok(Cholesky {
            kind,
            values,
            is_factored: false,
            scales: vec![0.0; analysis.pattern.dim()],
            memory: buffer(analysis, kind, 1)?,
            columns: 1,
            analysis: analysis.clone(),
        })
    }

    /// The analysis that it follows.
    pub fn analysis(&self) -> &Analysis {
        &self.analysis
    }

    /// The columns of L in the order of elimination; of no meaning where no matrix is factored.
    pub fn panels(&self) -> impl Iterator<Item = Panel<'_>> {
        (0..self.panel_count()).map(|s| self.panel(s))
    }

    pub(super) fn panel_count(&self) -> usize {
        match self.analysis.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(all) => all.ncols(),
            SymbolicCholeskyRaw::Supernodal(all) => all.n_supernodes(),
        }
    }

    /// Panel `s` of [`Cholesky::panels`].
    pub(super) fn panel(&self, s: usize) -> Panel<'_> {
        match self.analysis.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(all) => {
                let entries = all.col_ptr()[s]..all.col_ptr()[s + 1];
                Panel {
                    start: s,
                    size: 1,
                    below: &all.row_idx()[entries.start + 1..entries.end],
                    values: &self.values[entries],
                }
            }
            SymbolicCholeskyRaw::Supernodal(all) => {
                let (start, end) = (all.supernode_begin()[s], all.supernode_end()[s]);
                let below = all.col_ptr_for_row_idx()[s];
                let values = all.col_ptr_for_val()[s]..all.col_ptr_for_val()[s + 1];
                Panel {
                    start,
                    size: end - start,
                    below: &all.row_idx()[below..below + all.nnz_per_super()[s]],
                    values: &self.values[values],
                }
            }
        }
    }

    /// Computes L; at failure the step whose pivot is bad.
    fn factor(&mut self, values: &[f64]) -> Result<(), usize> {
        let lower = SparseColMatRef::new(symbolic(&self.analysis.pattern), values);
        let (symbolic, memory) = (&self.analysis.symbolic, MemStack::new(&mut self.memory));
        let (into, side, par) = (&mut self.values, Side::Lower, Par::Seq);
        let failed = match self.kind {
            Kind::Llt => {
                let (plain, params) = Default::default();
                let factor =
                    symbolic.factorize_numeric_llt(into, lower, side, plain, par, memory, params);
                factor
                    .err()
                    .map(|LltError::NonPositivePivot { index }| index)
            }
            Kind::Ldlt => {
                let (plain, params) = Default::default();
                let factor =
                    symbolic.factorize_numeric_ldlt(into, lower, side, plain, par, memory, params);
                factor.err().map(|LdltError::ZeroPivot { index }| index)
            }
        };
        match (failed, symbolic.raw()) {
            (None, _) => Ok(()),
            (Some(index), SymbolicCholeskyRaw::Simplicial(_)) => Err(index - 1), // counted from 1
            (Some(index), SymbolicCholeskyRaw::Supernodal(_)) => Err(index),
        }
    }

    /// L·Lᵀ has positive pivots only; at failure the first step whose pivot is zero to working precision.
    ///
    /// The pivot l_ii² = a_ii − Σ_k<i l_ik² carries the round-off of a_ii.
    fn inertia_of_llt(&self, values: &[f64]) -> Result<Inertia, usize> {
        let pattern = &self.analysis.pattern;
        let n = pattern.dim();
        let roundoff = n as f64 * f64::EPSILON;
        let is_sound = |step: usize, l: f64| {
            let unknown = self.analysis.unknown(step);
            let entries = pattern
                .column(unknown)
                .map(|slot| (pattern.rows()[slot], values[slot]));
            let diagonal = entries.take_while(|(row, _)| *row == unknown);
            l * l > roundoff * diagonal.map(|(_, a)| a).sum::<f64>()
        };
        for panel in self.panels() {
            let height = panel.size + panel.below.len();
            let diagonal = panel.values.iter().step_by(height + 1).take(panel.size);
            let mut steps = (panel.start..).zip(diagonal);
            if let Some((step, _)) = steps.find(|(step, l)| !is_sound(*step, **l)) {
                return Err(step);
            }
        }
        Ok(Inertia {
            positive: n,
            negative: 0,
        })
    }

    /// The signs of the pivots of L·D·Lᵀ; at failure the first step whose pivot is zero to working precision.
    ///
    /// The pivot d_i = a_ii − Σ_k<i l_ik² d_k carries the round-off of its terms. Where they are so large that the
    /// entries of A drown in it, the factor is of no use either.
    fn inertia_of_ldlt(&mut self, largest: f64) -> Result<Inertia, usize> {
        let n = self.scales.len();
        let mut inertia = Inertia {
            positive: 0,
            negative: 0,
        };
        let mut scales = std::mem::take(&mut self.scales);
        scales.fill(0.0);
        let (roundoff, growth) = (n as f64 * f64::EPSILON, largest / f64::EPSILON);
        let mut bad = None;
        for panel in self.panels() {
            for j in 0..panel.size {
                let mut column = panel.column(j);
                let (step, pivot) = column.next().unwrap_or_default();
                let scale = scales[step] + pivot.abs();
                let is_sound = pivot.abs() > roundoff * scale && scale < growth;
                bad = bad.or((!is_sound).then_some(step));
                column.for_each(|(row, l)| scales[row] += l * l * pivot.abs());
                match pivot > 0.0 {
                    true => inertia.positive += 1,
                    false => inertia.negative += 1,
                }
            }
        }
        self.scales = scales;
        bad.map_or(Ok(inertia), Err)
    }
}

/// What factoring and solving with `columns` right-hand sides need.
fn buffer(analysis: &Analysis, kind: Kind, columns: usize) -> Result<MemBuffer, FactorError> {
    let buffer = MemBuffer::try_new(scratch(analysis, kind, columns));
    buffer.map_err(|_| exhausted(&analysis.pattern))
}

fn scratch(analysis: &Analysis, kind: Kind, columns: usize) -> StackReq {
    let (symbolic, par) = (&analysis.symbolic, Par::Seq);
    let factor = match kind {
        Kind::Llt => symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default()),
        Kind::Ldlt => symbolic.factorize_numeric_ldlt_scratch::<f64>(par, Default::default()),
    };
    let solve = symbolic.solve_in_place_scratch::<f64>(columns, par);
    StackReq::or(factor, solve)
}

impl Factor for Cholesky {
    fn dim(&self) -> usize {
        self.analysis.pattern.dim()
    }

    fn refactor(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.is_factored = false;
        let pattern = &self.analysis.pattern;
        if values.len() != pattern.len() {
            return Err(FactorError::Length {
                what: "the matrix",
                found: values.len(),
                expected: pattern.len(),
            });
        }
        if let Some(slot) = values.iter().position(|v| !v.is_finite()) {
            let (row, col, value) = (pattern.rows()[slot], pattern.cols()[slot], values[slot]);
            return Err(FactorError::NotFinite { row, col, value });
        }
        let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let inertia = self.factor(values).and_then(|()| match self.kind {
            Kind::Llt => self.inertia_of_llt(values),
            Kind::Ldlt => self.inertia_of_ldlt(largest),
        });
        self.is_factored = inertia.is_ok();
        inertia.map_err(|step| {
            let unknown = self.analysis.unknown(step);
            match self.kind {
                Kind::Llt => FactorError::NotPositiveDefinite { unknown },
                Kind::Ldlt => FactorError::Singular { unknown },
            }
        })
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), FactorError> {
        let n = self.dim();
        if !self.is_factored {
            return Err(FactorError::NotFactored);
        }
        if n == 0 && b.is_empty() {
            return Ok(());
        }
        if n == 0 || b.len() % n != 0 {
            return Err(FactorError::Length {
                what: "the right-hand side",
                found: b.len(),
                expected: n,
            });
        }
        let columns = (b.len() / n).min(COLUMNS);
        if columns > self.columns {
            self.memory = buffer(&self.analysis, self.kind, columns)?;
            self.columns = columns;
        }
        let (symbolic, values) = (&*self.analysis.symbolic, &self.values[..]);
        for block in b.chunks_mut(n * COLUMNS) {
            let columns = block.len() / n;
            let block = MatMut::from_column_major_slice_mut(block, n, columns);
            let (par, memory) = (Par::Seq, MemStack::new(&mut self.memory));
            match self.kind {
                Kind::Llt => LltRef::new(symbolic, values).solve_in_place_with_conj(
                    Conj::No,
                    block,
                    par,
                    memory,
                ),
                Kind::Ldlt => LdltRef::new(symbolic, values).solve_in_place_with_conj(
                    Conj::No,
                    block,
                    par,
                    memory,
                ),
            }
        }
        Ok(())
    }
}
