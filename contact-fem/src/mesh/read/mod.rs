//! Mesh files of Gmsh (MSH 4.1 and 2.2, text and binary), Medit (`.mesh`, and `.meshb` in binary;
//! FreeFEM writes both), FreeFEM (`.msh` in the plane), STL (triangles without cells, for
//! [obstacles](crate::Obstacle::read)), decks of Abaqus and CalculiX (`.inp`), and VTK (`.vtk`; `.vtu` with the feature `vtk`).
//!
//! A [`MeshFile`] has the contents of a file in any of these formats; [`MeshFile::bodies`] builds
//! meshes from it. Invalid contents are rejected as [`Error::MeshFile`] with the line and the
//! remedy. An announced size is checked against the size of the file, so that the memory used is
//! proportional to the file.
//! ```
//! use contact_fem::mesh::read::MeshFile;
//!
//! // two triangles in region 7; a bottom edge with label 1
//! let file = MeshFile::parse(b"4 2 1  0 0 0  1 0 0  1 1 0  0 1 0  1 2 3 7  1 3 4 7  1 2 1")?;
//! let bodies = file.bodies::<2>()?;
//! let (name, mesh) = &bodies[0];
//! assert_eq!((name.as_str(), mesh.len()), ("7", 2));
//! assert_eq!(mesh.boundary("1")?, [[0, 1]]);
//! # Ok::<(), contact_fem::Error>(())
//! ```

mod bodies;
mod contents;
mod cursor;
mod freefem;
mod gmsh;
mod grid;
mod inp;
mod kind;
mod medit;
mod merged;
mod parts;
mod problem;
mod stl;
mod vtk;
#[cfg(feature = "vtk")]
mod vtu;
#[cfg(feature = "vtk")]
pub(crate) mod vtu_arrays;
#[cfg(feature = "vtk")]
mod vtu_data;

use std::path::{Path, PathBuf};

use crate::error::Error;
use contents::Contents;
pub use kind::ElementKind;
use problem::{Fault, excerpt};
pub use problem::{Place, Problem};

/// The contents of a mesh file, in a form that is independent of its format.
#[derive(Clone, Debug)]
pub struct MeshFile {
    path: Option<PathBuf>,
    format: Format,
    vertices: Vec<[f64; 3]>,
    groups: Vec<Group>,
    elements: Vec<Elements>,
}

/// The supported formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Gmsh's MSH 4.1, text or binary.
    Gmsh41,
    /// Gmsh's MSH 2.2, text or binary.
    Gmsh22,
    /// Medit's `.mesh`, text, or `.meshb`, binary.
    Medit,
    /// FreeFEM's `.msh` in the plane.
    FreeFem,
    /// STL, text or binary.
    Stl,
    /// VTK's `.vtu`.
    Vtu,
    /// VTK's legacy `.vtk`, text or binary.
    Vtk,
    /// Input decks of Abaqus and CalculiX, `.inp`.
    Inp,
}

/// A group of elements: a physical group of Gmsh, or all elements with one label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The dimension of the elements.
    pub dimension: usize,
    /// The number of the physical group, or the label.
    pub number: i64,
    /// The name; the number in decimal digits if the file has no name.
    pub name: String,
}

/// Elements of one kind that belong to the same groups.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elements {
    /// The kind of the elements.
    pub kind: ElementKind,
    /// Indices into [`MeshFile::groups`], ascending; may be empty.
    pub groups: Vec<usize>,
    /// Indices into [`MeshFile::vertices`], flat, [`ElementKind::nodes`] for each element in the
    /// order that [`ElementKind`] defines.
    pub nodes: Vec<usize>,
}

impl Elements {
    /// The nodes of each element.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.nodes.chunks_exact(self.kind.nodes())
    }

    /// The number of elements.
    pub fn len(&self) -> usize {
        self.nodes.len() / self.kind.nodes()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}

impl MeshFile {
    /// Reads the file at `path`. Its format is determined from its contents, not from its name.
    ///
    /// # Errors
    /// [`Error::Read`] if the file cannot be read; [`Error::MeshFile`] if its contents are invalid,
    /// with the line or byte, what was found there and the remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|source| Error::Read {
            path: path.to_path_buf(),
            source,
        })?;
        Self::from_bytes(&bytes, Some(path.to_path_buf()))
    }

    /// Reads a file from memory.
    ///
    /// # Errors
    /// As [`MeshFile::read`].
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        Self::from_bytes(bytes, None)
    }

    fn from_bytes(bytes: &[u8], path: Option<PathBuf>) -> Result<Self, Error> {
        match contents(bytes) {
            Ok((format, contents)) => Ok(MeshFile {
                path,
                format,
                vertices: contents.vertices,
                groups: contents.groups,
                elements: contents.elements,
            }),
            Err(Fault { place, problem }) => Err(Error::MeshFile {
                path,
                place,
                problem,
            }),
        }
    }

    /// The format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Coordinates of all vertices (UL), including middle nodes of edges; the third is 0 if the
    /// file has two.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// All groups that the file names or uses.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// All elements, cells and facets alike.
    pub fn elements(&self) -> &[Elements] {
        &self.elements
    }
}

/// Determines the format from the beginning of the file, and reads the file.
fn contents(bytes: &[u8]) -> Result<(Format, Contents), Fault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = bytes.trim_ascii_start();
    if start.is_empty() {
        return Err(Problem::Empty.into());
    }
    if start.starts_with(b"$") {
        return gmsh::read(bytes);
    }
    if vtk::recognised(start) {
        return Ok((Format::Vtk, vtk::read(start)?));
    }
    if medit::recognised(start) {
        return Ok((Format::Medit, medit::read(bytes)?));
    }
    if medit::binary::recognised(bytes) {
        return Ok((Format::Medit, medit::binary::read(bytes)?));
    }
    if freefem::recognised(start) {
        return Ok((Format::FreeFem, freefem::read(bytes)?));
    }
    if start.starts_with(b"<?xml") || start.starts_with(b"<VTKFile") {
        #[cfg(feature = "vtk")]
        return Ok((Format::Vtu, vtu::read(start)?));
        #[cfg(not(feature = "vtk"))]
        return Err(Problem::Unsupported {
            found: "a VTK file".to_string(),
            remedy: "build contact-fem with the feature `vtk`",
        }
        .into());
    }
    if inp::recognised(start) {
        return Ok((Format::Inp, inp::read(bytes)?));
    }
    if stl::recognised(bytes) {
        return Ok((Format::Stl, stl::read(bytes)?));
    }
    let start = excerpt(start);
    Err(Problem::UnknownFormat { start }.into())
}
