//! The compliance W = C M⁻¹ Cᵀ that the rows of the working set see.

use faer::Mat;

use super::halt::Halt;
use super::pruned::{gram, mirror};
use super::rows::Rows;
use super::stiffness::{Block, Stiffness};
use crate::linear::Factor;
use crate::{Stop, parallel};

/// W (UL/UF) of the rows of the working set, which only grows.
pub(super) struct Compliance {
    /// The distinct rows of the working set.
    rows: Vec<usize>,
    /// Whether each distinct row is among them.
    is_held: Vec<bool>,
    /// W, symmetric, in the order of the working set.
    W: Mat<f64>,
    /// The share of each block, and the places of its rows in the working set.
    shares: Vec<Share>,
}

/// The share of a block in W, for the rows in its unknowns.
struct Share {
    places: Vec<usize>,
    W: Mat<f64>,
}

/// So many rows more are solved with one by one, as right-hand sides of the whole block.
const FEW: usize = 32;

impl Compliance {
    /// Of no row yet.
    pub fn new(blocks: usize, rows: usize) -> Self {
        let none = || Share {
            places: Vec::new(),
            W: Mat::new(),
        };
        Compliance {
            rows: Vec::new(),
            is_held: vec![false; rows],
            W: Mat::new(),
            shares: std::iter::repeat_with(none).take(blocks).collect(),
        }
    }

    /// The rows of the working set.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Whether a distinct row is in the working set.
    pub fn holds(&self, row: usize) -> bool {
        self.is_held[row]
    }

    /// W.
    pub fn matrix(&self) -> &Mat<f64> {
        &self.W
    }

    /// Adds rows to the working set.
    pub fn extend(
        &mut self,
        more: &[usize],
        all: &Rows,
        stiffness: &mut Stiffness,
        stop: &Stop,
    ) -> Result<(), Halt> {
        let first = self.rows.len();
        Halt::if_too_many(first + more.len())?;
        self.rows.extend(more);
        more.iter().for_each(|&k| self.is_held[k] = true);
        let held = &self.rows;
        let shares = stiffness.blocks_mut().iter_mut().zip(&mut self.shares);
        parallel::try_map(shares, |(block, share)| {
            Halt::if_requested(stop)?;
            let touches = |&place: &usize| {
                let mut entries = all.row(held[place]).iter();
                entries.any(|entry| block.range.contains(&entry.0))
            };
            let known = share.places.len();
            share.places.extend((first..held.len()).filter(touches));
            let rows: Vec<usize> = share.places.iter().map(|&place| held[place]).collect();
            match rows.len() - known {
                0 => {}
                few if known > 0 && few <= FEW => share.append(known, &rows, all, block)?,
                _ => share.compute(&rows, all, block, stop)?,
            }
            Ok::<_, Halt>(())
        })?;
        let m = self.rows.len();
        self.W = Mat::zeros(m, m);
        for Share { places, W } in &self.shares {
            for (b, &j) in places.iter().enumerate() {
                let column = self.W.col_as_slice_mut(j);
                for (&i, w) in places.iter().zip(W.col(b).iter()) {
                    column[i] += w;
                }
            }
        }
        Ok(())
    }
}

impl Share {
    /// All of it anew, by pruned forward solves.
    fn compute(
        &mut self,
        rows: &[usize],
        all: &Rows,
        block: &Block,
        stop: &Stop,
    ) -> Result<(), Halt> {
        let own = |(place, &k): (usize, &usize)| {
            let entries = all
                .row(k)
                .iter()
                .filter(|entry| block.range.contains(&entry.0));
            let entries =
                entries.map(move |&(j, a)| (place, block.steps[j - block.range.start], a));
            entries.collect::<Vec<_>>()
        };
        let coefficients = rows.iter().enumerate().flat_map(own).collect();
        self.W = gram(&block.factor, rows.len(), coefficients, stop)?;
        Ok(())
    }

    /// The columns of the rows from `known` on, by solves with the whole block.
    fn append(
        &mut self,
        known: usize,
        rows: &[usize],
        all: &Rows,
        block: &mut Block,
    ) -> Result<(), Halt> {
        let (m, n, first) = (rows.len(), block.range.len(), block.range.start);
        let mut columns = vec![0.0; n * (m - known)];
        for (column, &k) in columns.chunks_mut(n).zip(&rows[known..]) {
            let own = all
                .row(k)
                .iter()
                .filter(|entry| block.range.contains(&entry.0));
            own.for_each(|&(j, a)| column[j - first] = a);
        }
        block.factor.solve(&mut columns)?;
        let mut W = Mat::zeros(m, m);
        W.submatrix_mut(0, 0, known, known).copy_from(&self.W);
        for (place, column) in (known..).zip(columns.chunks(n)) {
            for (i, &k) in rows.iter().enumerate().take(place + 1) {
                let own = all
                    .row(k)
                    .iter()
                    .filter(|entry| block.range.contains(&entry.0));
                W[(place, i)] = own.map(|&(j, a)| a * column[j - first]).sum::<f64>();
            }
        }
        mirror(&mut W);
        self.W = W;
        Ok(())
    }
}
