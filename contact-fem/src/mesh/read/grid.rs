//! VTK's unstructured grids, as its `.vtu` and its legacy files have them: points, nodes of cells, kinds of cells, labels.

use super::ElementKind;
use super::contents::Contents;
use super::problem::Problem;

/// The integer cell data that are labels, the first of these that a file has: FreeFEM's, those of Gmsh's physical groups and of Medit's
/// references as meshio writes them, and those of Gmsh's geometry.
pub(super) const LABELS: [&str; 4] = ["Label", "gmsh:physical", "medit:ref", "CellEntityIds"];

/// The arrays of a grid.
pub(super) struct Grid<'a> {
    /// Three coordinates of each point (UL).
    pub points: &'a [f64],
    /// The nodes of all cells, one cell after the other, counted from 0.
    pub connectivity: &'a [f64],
    /// Where the nodes of each cell end.
    pub offsets: &'a [f64],
    /// VTK's number of the kind of each cell.
    pub types: &'a [f64],
    /// The label of each cell, if there are labels.
    pub labels: Option<&'a [f64]>,
}

impl Grid<'_> {
    /// Adds the points and elements.
    pub fn add_to(&self, contents: &mut Contents) -> Result<(), Problem> {
        let first = contents.vertices.len();
        for (number, x) in self.points.chunks(3).enumerate() {
            let three = "three coordinates of each point";
            let x = x.try_into().map_err(|_| expected(three, "fewer"))?;
            contents.add_vertex(number as u64, x)?;
        }
        let count = contents.vertices.len() - first;
        let cells = self.types.len();
        let has_labels = self.labels.is_none_or(|labels| labels.len() == cells);
        if self.offsets.len() != cells || !has_labels {
            let one = "as many offsets and labels as types of cells";
            return Err(expected(one, "other numbers of them"));
        }
        let mut begin = 0;
        for (cell, (&kind, &end)) in self.types.iter().zip(self.offsets).enumerate() {
            let kind = element_kind(kind)?;
            let end = whole(end).and_then(|end| usize::try_from(end).ok());
            let nodes = end.and_then(|end| self.connectivity.get(begin..end));
            let nodes = nodes.filter(|nodes| nodes.len() == kind.nodes());
            let nodes = nodes
                .ok_or_else(|| expected(&format!("the nodes of a {kind}"), "other offsets"))?;
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
            let label = match self.labels.map(|labels| labels[cell]) {
                Some(label) => {
                    let number = whole(label);
                    Some(number.ok_or_else(|| expected("an integer label", &label.to_string()))?)
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
}

pub(super) fn expected(what: &str, found: &str) -> Problem {
    Problem::Expected {
        expected: what.to_string(),
        found: found.to_string(),
    }
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
