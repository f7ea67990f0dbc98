//! The types of elements of a deck.

use super::super::ElementKind;

/// The kind of the elements of a type, and whether they are shells: the letters before and behind tell what is computed, not what the
/// mesh is.
pub(super) fn kind(name: &str) -> Option<(ElementKind, bool)> {
    let name = name.to_ascii_uppercase();
    let begins = |all: &[&str]| {
        all.iter().any(|own| {
            let rest = name.strip_prefix(own);
            rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
        })
    };
    let solid = |kind| Some((kind, false));
    let shell = |kind| Some((kind, true));
    match () {
        () if begins(&["C3D4", "DC3D4"]) => solid(ElementKind::Tetrahedron),
        () if begins(&["C3D10", "DC3D10"]) => solid(ElementKind::Tetrahedron10),
        () if begins(&["CPS3", "CPE3", "CPEG3", "CAX3", "CGAX3"]) => solid(ElementKind::Triangle),
        () if begins(&["CPS6", "CPE6", "CPEG6", "CAX6", "CGAX6"]) => solid(ElementKind::Triangle6),
        () if begins(&["S3", "STRI3", "M3D3", "R3D3", "SFM3D3"]) => shell(ElementKind::Triangle),
        () if begins(&["S6", "STRI65", "M3D6", "SFM3D6"]) => shell(ElementKind::Triangle6),
        () if begins(&["T2D2", "T3D2", "B21", "B31", "R2D2", "RAX2", "SAX1"]) => {
            solid(ElementKind::Segment)
        }
        () if begins(&["T2D3", "T3D3", "B22", "B32", "SAX2"]) => solid(ElementKind::Segment3),
        () => None,
    }
}

/// The corners of the faces `S1`, `S2`, … of a plane or solid element.
pub(super) fn faces(kind: ElementKind) -> &'static [&'static [usize]] {
    match kind {
        ElementKind::Triangle | ElementKind::Triangle6 => &[&[0, 1], &[1, 2], &[2, 0]],
        ElementKind::Tetrahedron | ElementKind::Tetrahedron10 => {
            &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]]
        }
        _ => &[],
    }
}
