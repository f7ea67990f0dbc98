//! The Hessian's pattern, determined once, and the positions at which each cell adds to it.

use contact_core::linear::SymmetricPattern;

use super::dofs::{Dof, DofMap};

/// For each pair of nodes, the positions of its D × D block in the values of the pattern.
pub(super) struct SlotMap<const D: usize> {
    /// For every cell and every pair of its nodes (a, b ≤ a), the number of its block.
    pairs: Vec<u32>,
    per_cell: usize,
    /// Slots of the blocks: row of the node with the larger number, column of the other.
    blocks: Vec<[[u32; D]; D]>,
}

/// Marks entries that are not stored: those in prescribed rows or columns, and those above the
/// diagonal.
const NOWHERE: u32 = u32::MAX;

impl<const D: usize> SlotMap<D> {
    /// Adds the block of the nodes a and b ≤ a of cell `k`, numbered within the cell, to `values`.
    /// The row of `entry(i, j)` belongs to the node with the larger number in the mesh.
    #[inline]
    pub fn add(
        &self,
        k: usize,
        (a, b): (usize, usize),
        entry: impl Fn(usize, usize) -> f64,
        values: &mut [f64],
    ) {
        let block = self.pairs[k * self.per_cell + a * (a + 1) / 2 + b];
        for (i, row) in self.blocks[block as usize].iter().enumerate() {
            for (j, &slot) in row.iter().enumerate() {
                if slot != NOWHERE {
                    values[slot as usize] += entry(i, j);
                }
            }
        }
    }
}

/// Determines the Hessian's pattern over the free dofs; `cells` yields each cell's nodes.
pub(super) fn pattern_and_slots<'a, const D: usize>(
    dofs: &DofMap,
    cells: impl Iterator<Item = &'a [usize]> + Clone,
) -> (SymmetricPattern, SlotMap<D>) {
    let pairs_of = |cell: &'a [usize]| {
        let lower = (0..cell.len()).flat_map(|a| (0..=a).map(move |b| (a, b)));
        lower.map(move |(a, b)| (cell[a].max(cell[b]), cell[a].min(cell[b])))
    };
    let mut pairs: Vec<(usize, usize)> = cells.clone().flat_map(pairs_of).collect();
    pairs.sort_unstable();
    pairs.dedup();

    let free = |node: usize, i: usize| match dofs.get(D * node + i) {
        Dof::Free(k) => Some(k),
        Dof::Prescribed(_) => None,
    };
    let mut positions = Vec::new();
    let mut blocks = Vec::with_capacity(pairs.len());
    for &(p, q) in &pairs {
        let mut slots = [[NOWHERE; D]; D];
        for (i, row) in slots.iter_mut().enumerate() {
            for (j, slot) in row.iter_mut().enumerate() {
                let lower = p != q || i >= j;
                let entry = free(p, i).zip(free(q, j)).filter(|_| lower);
                if let Some(entry) = entry {
                    *slot = positions.len() as u32;
                    positions.push(entry);
                }
            }
        }
        blocks.push(slots);
    }
    let (pattern, place) = SymmetricPattern::from_entries(dofs.free(), &positions)
        .expect("free dofs are numbered below their number");
    for slot in blocks.iter_mut().flatten().flatten() {
        if *slot != NOWHERE {
            *slot = place[*slot as usize] as u32;
        }
    }
    let number = |pair| pairs.binary_search(&pair).map_or(u32::MAX, |k| k as u32);
    let per_cell = cells.clone().next().map_or(0, |cell| cell.len());
    let slots = SlotMap {
        pairs: cells.flat_map(pairs_of).map(number).collect(),
        per_cell: per_cell * (per_cell + 1) / 2,
        blocks,
    };
    (pattern, slots)
}
