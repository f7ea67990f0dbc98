//! Problems of a mesh file.

use std::fmt;

use super::ElementKind;
use crate::error::Error;

/// The position of a problem in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(line) => write!(f, ", line {line}"),
            Place::Byte(byte) => write!(f, ", byte {byte}"),
        }
    }
}

/// A problem of a mesh file: what was found, what was expected, and the remedy.
///
/// Vertices are counted from 0 in the order of the file; bodies and boundaries have the names of
/// their groups.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A file without contents other than white space.
    #[error("the file is empty")]
    Empty,
    /// A format other than the supported ones.
    #[error(
        "begins with `{start}`: this is no Gmsh MSH, Medit .mesh or .meshb, FreeFEM .msh, STL, VTK .vtu or .vtk, or Abaqus .inp file; \
         export one of these"
    )]
    UnknownFormat {
        /// The beginning of the file.
        start: String,
    },
    /// A known format that is not supported.
    #[error("this is {found}, which is not read: {remedy}")]
    Unsupported {
        /// The format and its version.
        found: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// An unexpected word or number.
    #[error("expected {expected}, found `{found}`")]
    Expected {
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A file that ends too early.
    #[error("the file ends where {expected} should be: it is incomplete, write it again")]
    Truncated {
        /// What was expected.
        expected: String,
    },
    /// An announced number of items for which the rest of the file is too small.
    #[error(
        "announces {count} {what}, but only {bytes} bytes are left: the file is incomplete or the \
         number wrong"
    )]
    Count {
        /// The items.
        what: &'static str,
        /// The announced number.
        count: u64,
        /// The number of bytes up to the end of the file.
        bytes: usize,
    },
    /// A section whose parts do not add up to the announced number.
    #[error("announces {announced} {what}, but the section has {found}: write the file again")]
    Total {
        /// The items.
        what: &'static str,
        /// The announced number.
        announced: u64,
        /// The number found.
        found: u64,
    },
    /// A missing section that every mesh needs.
    #[error("the file has no {section}: export the mesh, not the geometry alone")]
    Missing {
        /// The section.
        section: &'static str,
    },
    /// A section that is repeated or precedes one on which it depends.
    #[error("`{section}` is out of place: {remedy}")]
    Order {
        /// The section.
        section: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// Vertices that cannot be merged.
    #[error(
        "vertices at most {distance} apart cannot be made one: `merge-nodes` is a length that is not negative, and shorter than any side of a cell"
    )]
    Merge {
        /// The distance (UL).
        distance: f64,
    },
    /// A mesh that is divided into partitions.
    #[error("the mesh is partitioned: write it in one part (Gmsh: Mesh > Unpartition)")]
    Partitioned,
    /// Elements that are not simplices of order 1 or 2.
    #[error(
        "{kind} elements are not supported: mesh with segments, triangles and tetrahedra of order \
         1 or 2, without recombination"
    )]
    UnsupportedElement {
        /// Their name.
        kind: String,
    },
    /// Two nodes with the same number.
    #[error("node {number} is defined twice: renumber the mesh")]
    RepeatedNode {
        /// The number.
        number: u64,
    },
    /// An element with a node that does not exist in the file.
    #[error("an element names node {number}, which is not among the {nodes} nodes of the file")]
    UnknownNode {
        /// The number in the file.
        number: String,
        /// The number of nodes.
        nodes: usize,
    },
    /// Elements of a geometrical entity that the file does not list.
    #[error(
        "elements lie on entity {entity} of dimension {dimension}, which `$Entities` does not list"
    )]
    UnknownEntity {
        /// Its dimension.
        dimension: usize,
        /// Its number.
        entity: i64,
    },
    /// An entity in more groups than are accepted.
    #[error(
        "entity {entity} of dimension {dimension} is in more than {most} physical groups: put it \
         in fewer"
    )]
    Groups {
        /// Its dimension.
        dimension: usize,
        /// Its number.
        entity: i64,
        /// The largest accepted number.
        most: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("a coordinate of node {number} is {value}: it must be finite")]
    NotFinite {
        /// The number of the node in the file.
        number: u64,
        /// The coordinate.
        value: f64,
    },
    /// A name that is not UTF-8.
    #[error("the name `{name}` is not UTF-8: rename the group in plain letters")]
    NotUtf8 {
        /// The name, as far as it is printable.
        name: String,
    },
    /// A mesh whose dimension differs from the requested one.
    #[error("the file holds a mesh of dimension {found}, but {asked} was asked for")]
    Dimension {
        /// The requested dimension.
        asked: usize,
        /// The largest dimension of the elements.
        found: usize,
    },
    /// A mesh in the plane whose vertices have different z coordinates.
    #[error(
        "vertex {vertex} lies at z = {z}, others at z = {plane}: a mesh in the plane needs one z"
    )]
    NotPlane {
        /// Which vertex.
        vertex: usize,
        /// Its third coordinate (UL).
        z: f64,
        /// The third coordinate of the first vertex of the first cell (UL).
        plane: f64,
    },
    /// Cells without a group although other cells have one.
    #[error(
        "{cells} cells belong to no group while others do: put every cell in a group (a body), or \
         none"
    )]
    Ungrouped {
        /// The number of these cells.
        cells: usize,
    },
    /// A cell in two bodies.
    #[error(
        "the cell with vertices {vertices:?} belongs to `{first}` and to `{second}`: bodies cannot \
         share cells; take one at a time with `MeshFile::body`"
    )]
    SharedCell {
        /// The corners.
        vertices: Box<[usize]>,
        /// One body.
        first: String,
        /// The other.
        second: String,
    },
    /// A cell twice in a body.
    #[error("`{body}` has the cell with vertices {vertices:?} twice: remove one")]
    RepeatedCell {
        /// The corners.
        vertices: Box<[usize]>,
        /// The body.
        body: String,
    },
    /// A facet in a group that belongs to no body.
    #[error(
        "the facet at {at:?} with vertices {vertices:?} in `{boundary}` belongs to no cell of a \
         body: remove it from the group, or take bodies one at a time with `MeshFile::body`, which \
         leaves it out"
    )]
    LooseFacet {
        /// The corners.
        vertices: Box<[usize]>,
        /// The centroid (UL).
        at: [f64; 3],
        /// The group.
        boundary: String,
    },
    /// A body that does not exist in the file.
    #[error("no body is called `{name}`; this file has {known:?}")]
    UnknownBody {
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// Cells of two orders in one body.
    #[error("`{body}` has {kind} cells beside linear ones: mesh all of a body with one order")]
    CellOrder {
        /// The body.
        body: String,
        /// The kind of the quadratic cells.
        kind: ElementKind,
    },
    /// Cells that do not form a valid mesh.
    #[error("body `{body}`, its cells counted from 0 in the order of the file: {source}")]
    Body {
        /// The body.
        body: String,
        /// The error.
        source: Box<Error>,
    },
}

/// The `Display` message: `main` and `unwrap` print an error by `Debug`.
impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A problem with its position; the file's path is added later.
#[derive(Debug)]
pub(crate) struct Fault {
    pub place: Place,
    pub problem: Problem,
}

impl From<Problem> for Fault {
    fn from(problem: Problem) -> Self {
        let place = Place::File;
        Fault { place, problem }
    }
}

/// The beginning of `bytes` as printable text, for messages.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = &bytes[..bytes.len().min(LONGEST)];
    let text: String = shown.escape_ascii().map(char::from).collect();
    match bytes.len() > LONGEST {
        true => text + "…",
        false => text,
    }
}
