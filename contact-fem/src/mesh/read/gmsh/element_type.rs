//! Gmsh's numbers of element types.

use super::ElementKind;
use crate::mesh::read::Problem;

/// The element type with Gmsh's `number`.
pub(super) fn kind(number: i64) -> Result<ElementKind, Problem> {
    Ok(match number {
        1 => ElementKind::Segment,
        2 => ElementKind::Triangle,
        4 => ElementKind::Tetrahedron,
        8 => ElementKind::Segment3,
        9 => ElementKind::Triangle6,
        11 => ElementKind::Tetrahedron10,
        15 => ElementKind::Point,
        other => {
            let kind = match name(other) {
                Some(name) => format!("{name} (Gmsh's type {other})"),
                None => format!("Gmsh's type {other}"),
            };
            return Err(Problem::UnsupportedElement { kind });
        }
    })
}

fn name(number: i64) -> Option<&'static str> {
    Some(match number {
        3 => "4-node quadrilateral",
        5 => "8-node hexahedron",
        6 => "6-node prism",
        7 => "5-node pyramid",
        10 => "9-node quadrilateral",
        12 => "27-node hexahedron",
        13 => "18-node prism",
        14 => "14-node pyramid",
        16 => "8-node quadrilateral",
        17 => "20-node hexahedron",
        18 => "15-node prism",
        19 => "13-node pyramid",
        20 => "9-node triangle",
        21 => "10-node triangle",
        22 => "12-node triangle",
        23 => "15-node triangle",
        24 => "15-node triangle of order 5",
        25 => "21-node triangle",
        26 => "4-node segment",
        27 => "5-node segment",
        28 => "6-node segment",
        29 => "20-node tetrahedron",
        30 => "35-node tetrahedron",
        31 => "56-node tetrahedron",
        92 => "64-node hexahedron",
        93 => "125-node hexahedron",
        _ => return None,
    })
}
