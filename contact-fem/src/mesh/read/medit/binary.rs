//! Medit's `.meshb` files, versions 1 to 4; FreeFEM writes version 2 for meshes in space.
//!
//! A file begins with the number 1 and its version. Each section has the code of its keyword, the
//! position of the next section, or 0 in the last, and mostly a number of items and the items. Real
//! numbers have 4 bytes in version 1 and 8 in others; positions have 8 bytes from version 3 on,
//! numbers of items and integers in version 4, and 4 before.

use super::{elements, refuse, vertices};
use crate::mesh::read::ElementKind;
use crate::mesh::read::contents::Contents;
use crate::mesh::read::cursor::Cursor;
use crate::mesh::read::problem::{Fault, Problem};

const DIMENSION: i32 = 3;
const VERTICES: i32 = 4;
const END: i32 = 54;

/// Whether the file begins with the numbers of a binary file of either endianness: 1 and a version.
pub(in crate::mesh::read) fn recognised(start: &[u8]) -> bool {
    matches!(
        start,
        [1, 0, 0, 0, 1..=4, 0, 0, 0, ..] | [0, 0, 0, 1, 0, 0, 0, 1..=4, ..]
    )
}

/// Reads the whole file.
pub(in crate::mesh::read) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut file = Cursor::new(bytes, None);
    file.binary = true;
    if code(&mut file, "the number 1")? != 1 {
        return Err(file.fault(Problem::Unsupported {
            found: "a binary file of a big-endian machine".to_string(),
            remedy: "write it as text, with the ending .mesh instead of .meshb",
        }));
    }
    let version = code(&mut file, "the version")?;
    file.is_single = version == 1;
    file.is_wide = version == 4;
    let mut dimension = None;
    let mut contents = Contents::default();
    loop {
        let keyword = code(&mut file, "the code of a section, such as 54 for `End`")?;
        let what = "the position of the next section";
        let next = match version {
            1 | 2 => u32::from_le_bytes(file.take(what)?).into(),
            _ => file.size(what)?,
        };
        match keyword {
            END => break,
            DIMENSION => match code(&mut file, "the dimension")? {
                d @ 2..=3 => dimension = Some(d as usize),
                d => return Err(file.wrong("dimension 2 or 3", d)),
            },
            VERTICES => {
                vertices(&mut file, &mut contents, dimension, count)?;
                check_end(&file, next)?;
            }
            _ => match (kind(keyword), name(keyword)) {
                (Some(kind), Some(name)) => {
                    let count = count(&mut file)?;
                    elements(&mut file, &mut contents, kind, name, count)?;
                    check_end(&file, next)?;
                }
                (None, Some(name)) => {
                    let count = count(&mut file)?;
                    refuse(&file, name, count)?;
                }
                _ => {}
            },
        }
        if next == 0 {
            break;
        }
        file.move_to(next)?;
    }
    contents.check("`Vertices`", "`Triangles` or `Tetrahedra`")?;
    Ok(contents)
}

/// Reads a number that has four bytes in all versions.
fn code(file: &mut Cursor, what: &str) -> Result<i32, Fault> {
    file.take(what).map(i32::from_le_bytes)
}

/// Reads the number of items of a section.
fn count(file: &mut Cursor) -> Result<u64, Fault> {
    let what = "the number of items";
    let count = file.integer(what)?;
    u64::try_from(count).map_err(|_| file.wrong(what, count))
}

/// Checks that the items of a section end where the next one begins: otherwise they have other sizes.
fn check_end(file: &Cursor, next: u64) -> Result<(), Fault> {
    let end = file.position();
    match next == 0 || next == end as u64 {
        true => Ok(()),
        false => Err(file.wrong(&format!("the next section at byte {end}"), next)),
    }
}

/// The kinds of elements that are read.
fn kind(keyword: i32) -> Option<ElementKind> {
    Some(match keyword {
        5 => ElementKind::Segment,
        6 => ElementKind::Triangle,
        8 => ElementKind::Tetrahedron,
        24 => ElementKind::Triangle6,
        25 => ElementKind::Segment3,
        30 => ElementKind::Tetrahedron10,
        _ => return None,
    })
}

/// The keywords of elements without which the mesh would be incomplete or wrong.
fn name(keyword: i32) -> Option<&'static str> {
    Some(match keyword {
        5 => "Edges",
        6 => "Triangles",
        7 => "Quadrilaterals",
        8 => "Tetrahedra",
        9 => "Prisms",
        10 => "Hexahedra",
        24 => "TrianglesP2",
        25 => "EdgesP2",
        27 => "QuadrilateralsQ2",
        30 => "TetrahedraP2",
        33 => "HexahedraQ2",
        49 => "Pyramids",
        86 => "PrismsP2",
        87 => "PyramidsP2",
        88 => "QuadrilateralsQ3",
        89 => "QuadrilateralsQ4",
        90 => "TrianglesP3",
        91 => "TrianglesP4",
        92 => "EdgesP3",
        93 => "EdgesP4",
        96 => "TetrahedraP3",
        97 => "TetrahedraP4",
        98 => "HexahedraQ3",
        99 => "HexahedraQ4",
        100 => "PyramidsP3",
        101 => "PyramidsP4",
        102 => "PrismsP3",
        103 => "PrismsP4",
        _ => return None,
    })
}
