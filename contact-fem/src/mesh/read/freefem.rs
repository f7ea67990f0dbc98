//! FreeFEM's `.msh` files, which `savemesh` writes for meshes in the plane.
//!
//! A file contains the numbers of vertices, triangles and edges; then x, y and a label for each
//! vertex, three vertices and a region for each triangle, two vertices and a label for each edge.

use super::ElementKind;
use super::contents::{Contents, counted_from_one};
use super::cursor::Cursor;
use super::problem::Fault;

/// Whether the file begins with three numbers of items.
pub(super) fn recognised(start: &[u8]) -> bool {
    let is_number = |word: &[u8]| word.iter().all(u8::is_ascii_digit);
    let mut file = Cursor::new(start, None);
    (0..3).all(|_| file.word().is_some_and(is_number))
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut file = Cursor::new(bytes, None);
    let vertices = file.size("the number of vertices")?;
    let triangles = file.size("the number of triangles")?;
    let edges = file.size("the number of edges")?;
    let mut contents = Contents::default();
    for number in 1..=file.room("vertices", vertices, 3, 0)? {
        let (x, y) = (file.real("a coordinate")?, file.real("a coordinate")?);
        file.integer("the label of a vertex")?;
        let added = contents.add_vertex(number as u64, [x, y, 0.0]);
        added.map_err(|problem| file.fault(problem))?;
    }
    let triangles = file.room("triangles", triangles, 4, 0)?;
    labelled(&mut file, &mut contents, ElementKind::Triangle, triangles)?;
    let edges = file.room("edges", edges, 3, 0)?;
    labelled(&mut file, &mut contents, ElementKind::Segment, edges)?;
    contents.check("vertices", "triangles")?;
    match file.word() {
        None => Ok(contents),
        more => Err(file.unexpected("the end of the file", more)),
    }
}

/// Reads elements, each given by its vertices, counted from 1, and a label.
pub(super) fn labelled(
    file: &mut Cursor,
    contents: &mut Contents,
    kind: ElementKind,
    count: usize,
) -> Result<(), Fault> {
    let mut nodes = [0; 10];
    let nodes = &mut nodes[..kind.nodes()];
    for _ in 0..count {
        for node in nodes.iter_mut() {
            let number = file.integer("the number of a vertex")?;
            let vertex = counted_from_one(number, contents.vertices.len());
            *node = vertex.map_err(|problem| file.fault(problem))?;
        }
        let label = file.integer("a label")?;
        let group = |contents: &mut Contents| vec![contents.group(kind.dimension(), label)];
        contents.nodes_of(kind, label, group).extend(&*nodes);
    }
    Ok(())
}
