//! Meshes in FreeFEM's formats: `.msh` in the plane, Medit's `.mesh` in space.
//!
//! FreeFEM's meshes are straight. Of a quadratic mesh the corners are written, in the order of
//! their numbers; FreeFEM's `P2` adds the nodes in the middle of edges itself. A linear mesh keeps
//! its numbering: FreeFEM's scripts count from 0, its files from 1. Both formats denote boundaries
//! and regions by whole numbers. Those of a mesh from a file are kept, see [`boundary_labels`] and
//! [`Mesh::region`].
//! ```
//! use contact_fem::MeshFile;
//! use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
//!
//! let sides = linspace(0.0, 1.0, 3);
//! let mesh = rectangle(&sides, &sides, Diagonals::Rising)?;
//! let labels: Vec<(&str, i32)> = mesh.boundary_labels().collect();
//! assert_eq!(labels, [("bottom", 1), ("left", 2), ("right", 3), ("top", 4)]);
//!
//! let file = MeshFile::parse(mesh.to_freefem()?.as_bytes())?;
//! let read = file.body::<2>("1")?;
//! assert_eq!(read.boundary("4")?, mesh.boundary("top")?);
//! # Ok::<(), contact_fem::Error>(())
//! ```

mod labels;
mod shared;

use std::fmt::Write;
use std::path::Path;

use super::Mesh;
use crate::error::Error;
pub use labels::boundary_labels;
use shared::{Label, Shared};

/// The label of facets on no named boundary.
const UNNAMED: i32 = 0;

/// A section of a file: its lines, of which each is an element with a label.
#[derive(Default)]
struct Section {
    lines: usize,
    text: String,
}

impl Section {
    fn add(&mut self, numbers: impl Iterator<Item = impl std::fmt::Display>, label: i32) {
        self.lines += 1;
        for number in numbers {
            // writing to a string cannot fail
            let _ = write!(self.text, "{number} ");
        }
        self.text += &format!("{label}\n");
    }
}

/// Bodies in one file of FreeFEM's format: the text of a `.msh` file in the plane, of Medit's `.mesh`
/// in space. Coordinates are written with all digits, so that they are read back exactly.
///
/// The vertices of a body follow those of the bodies before it. Bodies share vertices that coincide
/// exactly, as those of `Th1 + Th2` do, since FreeFEM reads no plane mesh with two vertices at a
/// point; write bodies that may open to files of their own. The label of a body's cells is its
/// [`Mesh::region`]; bodies without one get 1, 2, … but no region of another. Regions within a body, those of
/// [`Mesh::name_region`], are not written. Facets have the labels
/// that [`boundary_labels`] tells. Those on no boundary have label 0, and are left out if a boundary
/// has it or if they are between two bodies.
///
/// # Errors
/// [`Error::SharedFacet`] if a facet is on two boundaries: it can have only one label.
/// [`Error::EmptyMesh`] if there are no bodies.
pub fn to_freefem<const D: usize>(bodies: &[&Mesh<D>]) -> Result<String, Error> {
    if bodies.is_empty() {
        return Err(Error::EmptyMesh);
    }
    let labels = boundary_labels(bodies);
    let has_zero = labels.iter().any(|l| l.values().any(|&l| l == UNNAMED));
    let [mut vertices, mut cells, mut facets] = <[Section; 3]>::default();
    let mut shared = Shared::<D>::default();
    for ((mesh, labels), region) in bodies.iter().zip(labels).zip(labels::regions(bodies)) {
        let corners = mesh.used_corners();
        let points = corners.iter().map(|&corner| &mesh.nodes[corner]);
        let numbers = shared.number(points, |X| {
            vertices.add(X.iter().map(|x| format!("{x:e}")), UNNAMED);
            vertices.lines
        });
        let number = |node: &usize| numbers[corners.partition_point(|c| c < node)];
        for cell in mesh.cells() {
            cells.add(cell[..=D].iter().map(number), region);
        }
        for (facet, name) in mesh.named_facets()? {
            let label = name.and_then(|name| Some((name, *labels.get(name)?)));
            shared.label(std::array::from_fn(|k| number(&facet[k])), label)?;
        }
    }
    for (facet, label) in shared.facets {
        match label {
            Label::Named(_, label) => facets.add(facet.iter(), label),
            Label::Unnamed if !has_zero => facets.add(facet.iter(), UNNAMED),
            Label::Unnamed | Label::Between => {}
        }
    }
    Ok(file::<D>(&[vertices, cells, facets]))
}

/// Writes the text of [`to_freefem`] to a file. Its name should end in `.msh` in the plane and in
/// `.mesh` in space.
///
/// # Errors
/// As [`to_freefem`], and [`Error::Write`].
pub fn save_freefem<const D: usize>(
    path: impl AsRef<Path>,
    bodies: &[&Mesh<D>],
) -> Result<(), Error> {
    let path = path.as_ref();
    std::fs::write(path, to_freefem(bodies)?).map_err(|source| Error::Write {
        path: path.to_path_buf(),
        source: source.into(),
    })
}

/// The file of vertices, cells and facets.
fn file<const D: usize>(sections: &[Section; 3]) -> String {
    let [vertices, cells, facets] = sections;
    if D == 2 {
        let counts = format!("{} {} {}\n", vertices.lines, cells.lines, facets.lines);
        return counts + &vertices.text + &cells.text + &facets.text;
    }
    let mut text = format!("MeshVersionFormatted 2\n\nDimension {D}\n");
    for (section, keyword) in sections.iter().zip(["Vertices", "Tetrahedra", "Triangles"]) {
        text += &format!("\n{keyword}\n{}\n", section.lines);
        text += &section.text;
    }
    text + "\nEnd\n"
}

impl<const D: usize> Mesh<D> {
    /// The names of the boundaries and of [`Mesh::inner_facets`] with their labels in a file of this
    /// mesh alone, as [`boundary_labels`] tells them.
    pub fn boundary_labels(&self) -> impl Iterator<Item = (&str, i32)> {
        boundary_labels(&[self]).into_iter().flatten()
    }

    /// The mesh in FreeFEM's format, see [`to_freefem`].
    ///
    /// # Errors
    /// [`Error::SharedFacet`] if a facet is on two boundaries: it can have only one label.
    pub fn to_freefem(&self) -> Result<String, Error> {
        to_freefem(&[self])
    }

    /// Writes the text of [`Mesh::to_freefem`] to a file. Its name should end in `.msh` in the
    /// plane and in `.mesh` in space.
    ///
    /// # Errors
    /// As [`Mesh::to_freefem`], and [`Error::Write`].
    pub fn save_freefem(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        save_freefem(path, &[self])
    }

    /// The corners of all cells, ascending; all nodes of a linear mesh.
    fn used_corners(&self) -> Vec<usize> {
        let mut corners: Vec<usize> = self.cells().flat_map(|cell| &cell[..=D]).copied().collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The corners of the exterior facets, then of the inner ones, with their names.
    fn named_facets(&self) -> Result<impl Iterator<Item = (&[usize], Option<&str>)>, Error> {
        let mut names: Vec<Option<&str>> = vec![None; self.exterior().len()];
        for (name, facets) in &self.boundaries {
            for &facet in facets {
                if let Some(first) = names[facet].replace(name) {
                    return Err(Error::SharedFacet {
                        nodes: self.facet(facet)[..D].to_vec(),
                        first: first.to_string(),
                        second: name.clone(),
                    });
                }
            }
        }
        let exterior = self.exterior().map(|facet| &facet[..D]).zip(names);
        let inner = self.inner.iter().flat_map(|(name, facets)| {
            let facets = facets.iter().map(|facet| &facet[..]);
            facets.map(move |facet| (facet, Some(name.as_str())))
        });
        Ok(exterior.chain(inner))
    }
}
