//! What can be wrong with a mesh file.

use std::fmt;

use super::ElementKind;
use crate::error::Error;

/// Where in a mesh file something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the file as a whole.
    File,
    /// In a line, counted from 1.
    Line(usize),
    /// At a byte of a binary file, counted from 0.
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

/// What is wrong with a mesh file: what was found, what was expected, and the remedy.
///
/// Vertices are counted from 0 in the order of the file, bodies and boundaries are called by the
/// names of their groups.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// No byte but white space.
    #[error("the file is empty")]
    Empty,
    /// None of the formats that are read.
    #[error(
        "begins with `{start}`: this is no Gmsh MSH, Medit .mesh or FreeFEM .msh file; export one \
         of these"
    )]
    UnknownFormat {
        /// How the file begins.
        start: String,
    },
    /// A format that is known but not read.
    #[error("this is {found}, which is not read: {remedy}")]
    Unsupported {
        /// The format and its version.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Something stands where something else should.
    #[error("expected {expected}, found `{found}`")]
    Expected {
        /// What should stand there.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// The file ends too early.
    #[error("the file ends where {expected} should be: it is incomplete, write it again")]
    Truncated {
        /// What should stand there.
        expected: String,
    },
    /// More things are announced than the file has room for.
    #[error(
        "announces {count} {what}, but only {bytes} bytes are left: the file is incomplete or the \
         number wrong"
    )]
    Count {
        /// Of what.
        what: &'static str,
        /// How many.
        count: u64,
        /// The bytes up to the end of the file.
        bytes: usize,
    },
    /// The parts of a section do not add up.
    #[error("announces {announced} {what}, but the section has {found}: write the file again")]
    Total {
        /// Of what.
        what: &'static str,
        /// How many there should be.
        announced: u64,
        /// How many there are.
        found: u64,
    },
    /// A part of the file that nothing can be made of a mesh without.
    #[error("the file has no {section}: export the mesh, not the geometry alone")]
    Missing {
        /// The section.
        section: &'static str,
    },
    /// A section that stands before the one it builds on, or twice.
    #[error("`{section}` is out of place: {remedy}")]
    Order {
        /// The section.
        section: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A mesh cut into partitions.
    #[error("the mesh is partitioned: write it in one part (Gmsh: Mesh > Unpartition)")]
    Partitioned,
    /// Elements that are no simplices of order 1 or 2.
    #[error(
        "{kind} elements are not supported: mesh with segments, triangles and tetrahedra of order \
         1 or 2, without recombination"
    )]
    UnsupportedElement {
        /// Their name.
        kind: String,
    },
    /// Two nodes of one number.
    #[error("node {number} is defined twice: renumber the mesh")]
    RepeatedNode {
        /// The number.
        number: u64,
    },
    /// An element names a node that the file does not have.
    #[error("an element names node {number}, which is not among the {nodes} nodes of the file")]
    UnknownNode {
        /// The number, as the file has it.
        number: String,
        /// How many nodes there are.
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
    /// Too many groups to be meant.
    #[error(
        "entity {entity} of dimension {dimension} is in more than {most} physical groups: put it \
         in fewer"
    )]
    Groups {
        /// Its dimension.
        dimension: usize,
        /// Its number.
        entity: i64,
        /// How many would be accepted.
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
    /// A name that is no text.
    #[error("the name `{name}` is not UTF-8: rename the group in plain letters")]
    NotUtf8 {
        /// The name, as far as it can be shown.
        name: String,
    },
    /// The mesh is not of the dimension asked for.
    #[error("the file holds a mesh of dimension {found}, but {asked} was asked for")]
    Dimension {
        /// The dimension asked for.
        asked: usize,
        /// The largest dimension of the elements.
        found: usize,
    },
    /// A plane mesh that is not plane.
    #[error(
        "vertex {vertex} lies at z = {z}, others at z = {plane}: a mesh in the plane needs one z"
    )]
    NotPlane {
        /// Which vertex.
        vertex: usize,
        /// Its third coordinate (UL).
        z: f64,
        /// That of the first vertex of the first cell (UL).
        plane: f64,
    },
    /// Cells in no group where others are in one.
    #[error(
        "{cells} cells belong to no group while others do: put every cell in a group (a body), or \
         none"
    )]
    Ungrouped {
        /// How many.
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
    /// A facet in a group that bounds no body.
    #[error(
        "the facet at {at:?} with vertices {vertices:?} in `{boundary}` is on the boundary of no \
         body: remove it from the group, or take bodies one at a time with `MeshFile::body`, which \
         leaves it out"
    )]
    LooseFacet {
        /// The corners.
        vertices: Box<[usize]>,
        /// The centre (UL).
        at: [f64; 3],
        /// The group.
        boundary: String,
    },
    /// A body that the file does not have.
    #[error("no body is called `{name}`; this file has {known:?}")]
    UnknownBody {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// Cells of two orders in one body.
    #[error("`{body}` has {kind} cells beside linear ones: mesh all of a body with one order")]
    CellOrder {
        /// The body.
        body: String,
        /// What the quadratic cells are.
        kind: ElementKind,
    },
    /// The cells of a body make no mesh.
    #[error("body `{body}`, its cells counted from 0 in the order of the file: {source}")]
    Body {
        /// The body.
        body: String,
        /// Why.
        source: Box<Error>,
    },
}

/// The message, since that is what `main` and `unwrap` show of an error.
impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A problem and its place, before the file's path is known.
#[derive(Debug)]
pub(super) struct Fault {
    pub place: Place,
    pub problem: Problem,
}

impl From<Problem> for Fault {
    fn from(problem: Problem) -> Self {
        let place = Place::File;
        Fault { place, problem }
    }
}

/// The beginning of `bytes` as text that can be shown in a message.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = &bytes[..bytes.len().min(LONGEST)];
    let text: String = shown.escape_ascii().map(char::from).collect();
    match bytes.len() > LONGEST {
        true => text + "…",
        false => text,
    }
}
