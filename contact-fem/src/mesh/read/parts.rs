//! The assignment of cells to bodies.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::{Elements, MeshFile, Problem};

/// The cells of a body.
pub(super) struct Part<'a> {
    pub name: &'a str,
    /// The number of its group; the smallest if several have the name.
    pub region: Option<i64>,
    /// The indices of the cells in the file's elements, ascending.
    pub blocks: Vec<usize>,
}

/// The corners of an element in ascending order, filled up with `usize::MAX`.
pub(super) type Corners = [usize; 4];

/// Sorts corners that may be in any order.
pub(super) fn sorted(corners: &[usize]) -> Corners {
    let mut sorted = [usize::MAX; 4];
    sorted[..corners.len()].copy_from_slice(corners);
    sorted.sort_unstable();
    sorted
}

impl MeshFile {
    /// The elements of the given dimension.
    pub(super) fn of_dimension(&self, dimension: usize) -> impl Iterator<Item = &Elements> {
        let belongs = move |block: &&Elements| block.kind.dimension() == dimension;
        self.elements.iter().filter(belongs)
    }

    /// The cells of each body. Cells in no group are left out if others are in one.
    pub(super) fn parts(&self, dimension: usize) -> Result<Vec<Part<'_>>, Problem> {
        let dimensions = self.elements.iter().map(|block| block.kind.dimension());
        let found = dimensions.max().unwrap_or(0);
        if found != dimension {
            let asked = dimension;
            return Err(Problem::Dimension { asked, found });
        }
        self.check_plane(dimension)?;
        let mut free = Vec::new();
        let mut by_group = vec![Vec::new(); self.groups.len()];
        for (b, block) in self.elements.iter().enumerate() {
            if block.kind.dimension() == dimension {
                block.groups.iter().for_each(|&g| by_group[g].push(b));
                free.extend(block.groups.is_empty().then_some(b));
            }
        }
        let mut used: Vec<usize> = (0..by_group.len()).collect();
        used.retain(|&g| !by_group[g].is_empty());
        used.sort_by_key(|&g| self.groups[g].number);
        if used.is_empty() {
            let (name, region, blocks) = ("body", None, free);
            return Ok(vec![Part {
                name,
                region,
                blocks,
            }]);
        }
        let mut parts: Vec<Part> = Vec::new();
        let mut by_name = HashMap::new();
        for g in used {
            let name = self.groups[g].name.as_str();
            let part = *by_name.entry(name).or_insert(parts.len());
            if part == parts.len() {
                parts.push(Part {
                    name,
                    region: Some(self.groups[g].number),
                    blocks: Vec::new(),
                });
            }
            parts[part].blocks.append(&mut by_group[g]);
        }
        for part in &mut parts {
            part.blocks.sort_unstable();
            part.blocks.dedup();
        }
        Ok(parts)
    }

    /// Checks that all cells are in groups, or none.
    pub(super) fn check_all_in_parts(&self, dimension: usize) -> Result<(), Problem> {
        let cells = self.of_dimension(dimension);
        let (free, grouped): (Vec<&Elements>, Vec<_>) = cells.partition(|b| b.groups.is_empty());
        match free.is_empty() || grouped.is_empty() {
            true => Ok(()),
            false => Err(Problem::Ungrouped {
                cells: free.into_iter().map(Elements::len).sum(),
            }),
        }
    }

    /// Checks that all vertices of a plane mesh have the same z, up to round-off.
    fn check_plane(&self, dimension: usize) -> Result<(), Problem> {
        const ROUND_OFF: f64 = 1e-9;
        let vertices = || self.of_dimension(dimension).flat_map(|block| &block.nodes);
        let (2, Some(&first)) = (dimension, vertices().next()) else {
            return Ok(());
        };
        let first = self.vertices[first];
        let reach = |&v: &usize| {
            let [x, y, _] = self.vertices[v];
            (x - first[0]).abs().max((y - first[1]).abs())
        };
        let size = vertices().map(reach).fold(0.0, f64::max);
        let off = |&&v: &&usize| (self.vertices[v][2] - first[2]).abs() > ROUND_OFF * size;
        match vertices().find(off) {
            None => Ok(()),
            Some(&vertex) => Err(Problem::NotPlane {
                vertex,
                z: self.vertices[vertex][2],
                plane: first[2],
            }),
        }
    }

    /// Checks that no cell is in two bodies, or twice in one.
    pub(super) fn check_cells_differ(&self, parts: &[Part]) -> Result<(), Problem> {
        let mut seen: HashMap<Corners, usize> = HashMap::new();
        for (p, part) in parts.iter().enumerate() {
            for block in part.blocks.iter().map(|&b| &self.elements[b]) {
                for cell in block.iter() {
                    let corners = &cell[..block.kind.corners()];
                    let before = match seen.entry(sorted(corners)) {
                        Entry::Vacant(new) => {
                            new.insert(p);
                            continue;
                        }
                        Entry::Occupied(old) => *old.get(),
                    };
                    let vertices = corners.into();
                    return Err(match before == p {
                        true => Problem::RepeatedCell {
                            vertices,
                            body: part.name.to_string(),
                        },
                        false => Problem::SharedCell {
                            vertices,
                            first: parts[before].name.to_string(),
                            second: part.name.to_string(),
                        },
                    });
                }
            }
        }
        Ok(())
    }
}
