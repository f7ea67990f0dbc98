//! The Hessian's pattern, found once, and where each cell writes into it.

use contact_core::nlp::Pattern;

use super::dofs::{Dof, DofMap};

/// For every cell and every entry of its local lower triangle, the position in the global pattern.
pub(super) struct SlotMap {
    slots: Vec<u32>,
    per_cell: usize,
}

/// Entries of rows or columns that are prescribed are written nowhere.
pub(super) const NOWHERE: u32 = u32::MAX;

impl SlotMap {
    /// The slots of one cell: local (r, c) with r ≥ c stands at r (r + 1)/2 + c.
    pub fn cell(&self, k: usize) -> &[u32] {
        &self.slots[k * self.per_cell..(k + 1) * self.per_cell]
    }
}

/// Finds the pattern of the lower triangle over the free dofs; `cells` yields each cell's dofs.
pub(super) fn pattern_and_slots(
    dofs: &DofMap,
    cells: impl Iterator<Item = Vec<usize>> + Clone,
) -> (Pattern, SlotMap) {
    let free = |dof: usize| match dofs.get(dof) {
        Dof::Free(i) => Some(i),
        Dof::Prescribed(_) => None,
    };
    let position = |r: usize, c: usize| {
        let (r, c) = (free(r)?, free(c)?);
        Some((r.max(c), r.min(c)))
    };
    let local = |cell: Vec<usize>| -> Vec<Option<(usize, usize)>> {
        let lower = (0..cell.len()).flat_map(|r| (0..=r).map(move |c| (r, c)));
        lower.map(|(r, c)| position(cell[r], cell[c])).collect()
    };
    let mut positions: Vec<(usize, usize)> = cells.clone().flat_map(local).flatten().collect();
    positions.sort_unstable();
    positions.dedup();

    let slot = |p: Option<(usize, usize)>| {
        let found = p.and_then(|p| positions.binary_search(&p).ok());
        found.map_or(NOWHERE, |k| k as u32)
    };
    let mut slots = Vec::new();
    let mut per_cell = 0;
    for cell in cells {
        let entries = local(cell);
        per_cell = entries.len();
        slots.extend(entries.into_iter().map(slot));
    }
    (positions.into_iter().collect(), SlotMap { slots, per_cell })
}
