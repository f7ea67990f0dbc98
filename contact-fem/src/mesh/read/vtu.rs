//! VTK's `.vtu` files: unstructured grids with simplices of order 1 or 2, as FreeFEM's `savevtk`, meshio and ParaView write them, as
//! text or with binary data, which may be compressed. Cells and facets with the same number in the cell data that are [`LABELS`]
//! form a group.
//!
//! FreeFEM 4.9 writes coordinates in single precision, and leaves out the attribute `version`.

use super::contents::Contents;
use super::grid::{Grid, LABELS, chosen};
use super::problem::{Fault, Problem};
use super::vtu_arrays::{Piece, Section, pieces};

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let is_wanted = |section, name: &str| match section {
        Section::Points => true,
        Section::Cells => ["connectivity", "offsets", "types"].contains(&name),
        Section::CellData => LABELS.contains(&name),
        Section::PointData | Section::FieldData => false,
    };
    let mut contents = Contents::default();
    for piece in pieces(bytes, is_wanted)? {
        add(&piece, &mut contents).map_err(|problem| piece.fault(problem))?;
    }
    contents.check("`Points`", "`Cells`")?;
    Ok(contents)
}

/// Adds the points and elements of a piece.
fn add(piece: &Piece, contents: &mut Contents) -> Result<(), Problem> {
    let array = |section, name| piece.array(section, name).unwrap_or_default();
    let types = array(Section::Cells, "types");
    let labels = LABELS
        .iter()
        .filter_map(|name| piece.array(Section::CellData, name));
    let grid = Grid {
        points: array(Section::Points, ""),
        connectivity: array(Section::Cells, "connectivity"),
        offsets: array(Section::Cells, "offsets"),
        types,
        labels: chosen(labels, types.len()),
    };
    let found = [grid.points.len().div_ceil(3), grid.types.len()];
    for (k, what) in ["points", "cells"].into_iter().enumerate() {
        match piece.announced[k] {
            Some(announced) if announced != found[k] as u64 => {
                return Err(Problem::Total {
                    what,
                    announced,
                    found: found[k] as u64,
                });
            }
            _ => {}
        }
    }
    grid.add_to(contents)
}
