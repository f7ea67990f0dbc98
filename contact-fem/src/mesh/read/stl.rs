//! STL files: triangles in space, text or binary, each with three points of its own.
//!
//! Points with the same coordinates become one vertex. The normals of the file are not used: the order of the points has them.

use std::collections::HashMap;

use super::ElementKind;
use super::contents::Contents;
use super::cursor::Cursor;
use super::problem::Fault;

/// The bytes before the triangles of a binary file: a comment, then their number.
const COMMENT: usize = 80;
/// The bytes of a binary triangle: a normal and three points in single precision, then two bytes without a meaning.
const TRIANGLE: usize = 50;

/// Whether the file is as long as its number of triangles says.
fn is_binary(bytes: &[u8]) -> bool {
    let number = bytes.get(COMMENT..).and_then(|rest| rest.first_chunk());
    let triangles = number.map(|number| u32::from_le_bytes(*number) as usize);
    triangles.is_some_and(|n| bytes.len() == COMMENT + 4 + TRIANGLE * n)
}

/// Whether the file is a text of triangles, or binary.
pub(super) fn recognised(bytes: &[u8]) -> bool {
    let mut file = Cursor::new(bytes, None);
    is_binary(bytes) || file.word() == Some(b"solid")
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut triangles = Triangles::default();
    match is_binary(bytes) {
        true => binary(bytes, &mut triangles)?,
        false => text(bytes, &mut triangles)?,
    }
    triangles.contents.check("vertex", "facet")?;
    Ok(triangles.contents)
}

#[derive(Default)]
struct Triangles {
    contents: Contents,
    /// Vertices by the bits of their coordinates.
    vertices: HashMap<[u64; 3], usize>,
}

impl Triangles {
    fn add(&mut self, file: &mut Cursor<'_>, before: Option<&str>) -> Result<(), Fault> {
        for _ in 0..3 {
            before.map_or(Ok(()), |word| file.expect(word))?;
            // −0 and 0 are the same
            let point = file.point()?.map(|x| x + 0.0);
            let next = self.contents.vertices.len();
            let vertex = *self.vertices.entry(point.map(f64::to_bits)).or_insert(next);
            if vertex == next {
                let added = self.contents.add_vertex(next as u64 + 1, point);
                added.map_err(|problem| file.fault(problem))?;
            }
            let nodes = self
                .contents
                .nodes_of(ElementKind::Triangle, 0, |_| Vec::new());
            nodes.push(vertex);
        }
        Ok(())
    }
}

fn binary(bytes: &[u8], triangles: &mut Triangles) -> Result<(), Fault> {
    let mut file = Cursor::new(bytes, None);
    file.binary = true;
    file.is_single = true;
    file.move_to((COMMENT + 4) as u64)?;
    while !file.rest().is_empty() {
        file.point()?;
        triangles.add(&mut file, None)?;
        file.take::<2>("the end of a triangle")?;
    }
    Ok(())
}

fn text(bytes: &[u8], triangles: &mut Triangles) -> Result<(), Fault> {
    let mut file = Cursor::new(bytes, None);
    while let Some(word) = file.word() {
        match word {
            // a name may follow, of any words
            b"solid" | b"endsolid" => {
                let line = file.rest().iter().position(|&byte| byte == b'\n');
                let end = line.unwrap_or(file.rest().len());
                file.move_to((file.position() + end) as u64)?;
            }
            b"facet" => {
                file.expect("normal")?;
                file.point()?;
                file.expect("outer")?;
                file.expect("loop")?;
                triangles.add(&mut file, Some("vertex"))?;
                file.expect("endloop")?;
                file.expect("endfacet")?;
            }
            other => return Err(file.unexpected("`facet`", Some(other))),
        }
    }
    Ok(())
}
