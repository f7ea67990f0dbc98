//! VTK's unstructured grids, as its `.vtu` and its legacy files have them: points, nodes of cells, kinds of cells, labels.

use super::ElementKind;
use super::contents::Contents;
use super::problem::Problem;

/// The names of cell data that are labels, in the order of their preference: FreeFEM's; Gmsh's physical groups and Medit's references, as
/// meshio writes them; Gmsh's numbers of physical groups or, without any, of its geometry.
pub(super) const LABELS: [&str; 4] = ["Label", "gmsh:physical", "medit:ref", "CellEntityIds"];

/// The first of these arrays that has a whole number for each cell; the first one if none has.
pub(super) fn chosen<'a>(
    mut all: impl Iterator<Item = &'a [f64]>,
    cells: usize,
) -> Option<&'a [f64]> {
    let first = all.next()?;
    let are_labels =
        |of: &&[f64]| of.len() == cells && of.iter().all(|&label| whole(label).is_some());
    std::iter::once(first)
        .chain(all)
        .find(are_labels)
        .or(Some(first))
}

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
        let labels = self.labels.map_or(cells, <[f64]>::len);
        for (what, found) in [("offsets", self.offsets.len()), ("labels", labels)] {
            if found != cells {
                let one = format!("{cells} {what} of cells, one for each type of a cell");
                return Err(expected(&one, &found.to_string()));
            }
        }
        let mut begin = 0;
        for (cell, (&kind, &end)) in self.types.iter().zip(self.offsets).enumerate() {
            let kind = element_kind(kind)?;
            let end = whole(end).and_then(|end| usize::try_from(end).ok());
            let nodes = end.and_then(|end| self.connectivity.get(begin..end));
            let nodes = nodes.filter(|nodes| nodes.len() == kind.nodes());
            let nodes = nodes.ok_or_else(|| {
                let of = format!("the {} nodes of cell {cell}, a {kind}", kind.nodes());
                expected(&of, &format!("an end at {}", self.offsets[cell]))
            })?;
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
            let name = match whole(number) {
                Some(4) => "polyline",
                Some(7) => "polygon",
                Some(8 | 9 | 23 | 28) => "quadrilateral",
                Some(11 | 12 | 25 | 29) => "hexahedron",
                Some(13 | 26) => "wedge",
                Some(14 | 27) => "pyramid",
                _ => "other",
            };
            let kind = format!("VTK's {name} ({number})");
            return Err(Problem::UnsupportedElement { kind });
        }
    })
}
