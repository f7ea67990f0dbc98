//! VTK's `.vtu` files: unstructured grids with simplices of order 1 or 2, as FreeFEM's `savevtk`, meshio and ParaView write them, as
//! text or with binary data, which may be compressed. Cells and facets with the same number in the integer cell data `Label` form a group.
//!
//! FreeFEM 4.9 writes coordinates in single precision, and leaves out the attribute `version`.

use super::ElementKind;
use super::contents::Contents;
use super::problem::{Fault, Problem};
use super::vtu_arrays::{Piece, Section, expected, pieces};

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let is_wanted = |section, name: &str| match section {
        Section::Points => true,
        Section::Cells => ["connectivity", "offsets", "types"].contains(&name),
        Section::CellData => name == "Label",
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
    let cells = |name| array(Section::Cells, name);
    let (connectivity, offsets, types) = (cells("connectivity"), cells("offsets"), cells("types"));
    let labels = piece.array(Section::CellData, "Label");
    let first = contents.vertices.len();
    for (number, x) in array(Section::Points, "").chunks(3).enumerate() {
        let three = "three coordinates of each point";
        let x = x.try_into().map_err(|_| expected(three, "fewer"))?;
        contents.add_vertex(number as u64, x)?;
    }
    let count = contents.vertices.len() - first;
    let has_labels = labels.is_none_or(|labels| labels.len() == types.len());
    if offsets.len() != types.len() || !has_labels {
        let one = "as many offsets and labels as types of cells";
        return Err(expected(one, "other numbers of them"));
    }
    let found = [count, types.len()].map(|count| count as u64);
    for (k, what) in ["points", "cells"].into_iter().enumerate() {
        match piece.announced[k] {
            Some(announced) if announced != found[k] => {
                return Err(Problem::Total {
                    what,
                    announced,
                    found: found[k],
                });
            }
            _ => {}
        }
    }
    let mut begin = 0;
    for (cell, (&kind, &end)) in types.iter().zip(offsets).enumerate() {
        let kind = element_kind(kind)?;
        let end = whole(end).and_then(|end| usize::try_from(end).ok());
        let nodes = end.and_then(|end| connectivity.get(begin..end));
        let nodes = nodes.filter(|nodes| nodes.len() == kind.nodes());
        let nodes =
            nodes.ok_or_else(|| expected(&format!("the nodes of a {kind}"), "other offsets"))?;
        begin += nodes.len();
        let mut found = [0; 10];
        for (found, &node) in found.iter_mut().zip(nodes) {
            let index = whole(node).and_then(|node| usize::try_from(node).ok());
            let index = index.filter(|&index| index < count);
            *found = first
                + index.ok_or_else(|| Problem::UnknownNode {
                    number: node.to_string(),
                    nodes: count,
                })?;
        }
        let label = match labels.map(|labels| labels[cell]) {
            Some(label) => {
                Some(whole(label).ok_or_else(|| expected("an integer label", &label.to_string()))?)
            }
            None => None,
        };
        let groups = |contents: &mut Contents| match label {
            Some(label) => vec![contents.group(kind.dimension(), label)],
            None => Vec::new(),
        };
        let all = contents.nodes_of(kind, label.unwrap_or(0), groups);
        all.extend(&found[..kind.nodes()]);
    }
    Ok(())
}

/// A number without a fraction.
fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
}

/// The kind with this number of VTK.
fn element_kind(number: f64) -> Result<ElementKind, Problem> {
    Ok(match whole(number) {
        Some(1) => ElementKind::Point,
        Some(3) => ElementKind::Segment,
        Some(5) => ElementKind::Triangle,
        Some(10) => ElementKind::Tetrahedron,
        Some(21) => ElementKind::Segment3,
        Some(22) => ElementKind::Triangle6,
        Some(24) => ElementKind::Tetrahedron10,
        _ => {
            let kind = format!("VTK's {number}");
            return Err(Problem::UnsupportedElement { kind });
        }
    })
}
