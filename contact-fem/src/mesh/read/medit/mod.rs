//! Medit's files, which FreeFEM, Gmsh, Mmg and others write: `.mesh` in text, `.meshb` in binary.
//!
//! A file consists of keywords, each followed by a number of items and, mostly, as many lines of
//! numbers. Other keywords are skipped. A file may end without the keyword `End`; each section has as many items as it announces.

pub(super) mod binary;

use super::ElementKind;
use super::contents::Contents;
use super::cursor::Cursor;
use super::freefem::labelled;
use super::problem::{Fault, Problem, excerpt};

const FIRST: &[u8] = b"MeshVersionFormatted";

/// Whether the file begins with Medit's keyword, possibly after comments.
pub(super) fn recognised(start: &[u8]) -> bool {
    let first = Cursor::new(start, Some(b'#')).word();
    first.is_some_and(|word| word == FIRST)
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut file = Cursor::new(bytes, Some(b'#'));
    file.word();
    let version = file.integer("the version")?;
    if !(0..=4).contains(&version) {
        let found = format!("Medit's format in version {version}");
        let remedy = "write version 1 to 4";
        return Err(file.fault(Problem::Unsupported { found, remedy }));
    }
    let mut dimension = None;
    let mut contents = Contents::default();
    // many programs leave `End` out
    while let Some(keyword) = file.word() {
        match keyword {
            b"End" => break,
            b"Dimension" => match file.integer("the dimension")? {
                d @ 2..=3 => dimension = Some(d as usize),
                d => return Err(file.wrong("dimension 2 or 3", d)),
            },
            b"Vertices" => vertices(&mut file, &mut contents, dimension, count)?,
            word if !is_keyword(word) => return Err(file.unexpected("a keyword", Some(word))),
            word => match kind(word) {
                Some(kind) => {
                    let of = count(&mut file)?;
                    elements(&mut file, &mut contents, kind, &excerpt(word), of)?;
                }
                None if names_elements(word) => {
                    let of = count(&mut file)?;
                    refuse(&file, &excerpt(word), of)?;
                }
                None => {
                    while file.peek().is_some_and(|w| !is_keyword(w)) {
                        file.word();
                    }
                }
            },
        }
    }
    contents.check("`Vertices`", "`Triangles` or `Tetrahedra`")?;
    Ok(contents)
}

/// The kinds of elements that are read.
fn kind(keyword: &[u8]) -> Option<ElementKind> {
    Some(match keyword {
        b"Edges" => ElementKind::Segment,
        b"EdgesP2" => ElementKind::Segment3,
        b"Triangles" => ElementKind::Triangle,
        b"TrianglesP2" => ElementKind::Triangle6,
        b"Tetrahedra" => ElementKind::Tetrahedron,
        b"TetrahedraP2" => ElementKind::Tetrahedron10,
        _ => return None,
    })
}

/// Whether the keyword denotes elements without which the mesh would be incomplete or wrong.
fn names_elements(keyword: &[u8]) -> bool {
    const NAMES: [&str; 8] = [
        "Edges",
        "Triangles",
        "Quadrilaterals",
        "Tetrahedra",
        "Pyramids",
        "Prisms",
        "Pentahedra",
        "Hexahedra",
    ];
    NAMES
        .iter()
        .any(|name| keyword.starts_with(name.as_bytes()))
}

/// Whether a word is a keyword: it begins with a letter, and is neither NaN nor infinity.
fn is_keyword(word: &[u8]) -> bool {
    let text = std::str::from_utf8(word).unwrap_or_default();
    word.first().is_some_and(u8::is_ascii_alphabetic) && text.parse::<f64>().is_err()
}

/// The number of items in text.
fn count(file: &mut Cursor) -> Result<u64, Fault> {
    file.size("the number of items")
}

/// Reads the vertices, whose number `count` reads.
fn vertices(
    file: &mut Cursor,
    contents: &mut Contents,
    dimension: Option<usize>,
    count: impl FnOnce(&mut Cursor) -> Result<u64, Fault>,
) -> Result<(), Fault> {
    let out_of_place = |remedy| Problem::Order {
        section: "Vertices".to_string(),
        remedy,
    };
    if !contents.vertices.is_empty() {
        return Err(file.fault(out_of_place("a file has this section once")));
    }
    let remedy = "`Dimension` has to come first";
    let dimension = dimension.ok_or_else(|| file.fault(out_of_place(remedy)))?;
    let count = count(file)?;
    let each = file.bytes_of(dimension, 1);
    for number in 1..=file.room("vertices", count, dimension + 1, each)? {
        let mut point = [0.0; 3];
        for x in &mut point[..dimension] {
            *x = file.real("a coordinate")?;
        }
        file.integer("the label of a vertex")?;
        let added = contents.add_vertex(number as u64, point);
        added.map_err(|problem| file.fault(problem))?;
    }
    Ok(())
}

/// Reads `count` elements.
fn elements(
    file: &mut Cursor,
    contents: &mut Contents,
    kind: ElementKind,
    keyword: &str,
    count: u64,
) -> Result<(), Fault> {
    if count > 0 && contents.vertices.is_empty() {
        return Err(file.fault(Problem::Order {
            section: keyword.to_string(),
            remedy: "`Vertices` have to come first",
        }));
    }
    let numbers = kind.nodes() + 1;
    let count = file.room("elements", count, numbers, file.bytes_of(0, numbers))?;
    labelled(file, contents, kind, count)
}

/// Rejects elements that are not supported, unless their number is 0.
fn refuse(file: &Cursor, keyword: &str, count: u64) -> Result<(), Fault> {
    match count {
        0 => Ok(()),
        _ => Err(file.fault(Problem::UnsupportedElement {
            kind: format!("`{keyword}`"),
        })),
    }
}
