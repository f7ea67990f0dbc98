//! Meshes in FreeFEM's formats: `.msh` in the plane, Medit's `.mesh` in space.
//!
//! FreeFEM's meshes are straight. Of a quadratic mesh the corners are written, in the order of
//! their numbers; FreeFEM's `P2` adds the nodes in the middle of edges itself. A linear mesh keeps
//! its numbering: FreeFEM's scripts count from 0, its files from 1. Both formats denote boundaries
//! by whole numbers, see [`Mesh::boundary_labels`].
//! ```
//! use contact_fem::MeshFile;
//! use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
//!
//! let sides = linspace(0.0, 1.0, 3);
//! let mesh = rectangle(&sides, &sides, Diagonals::Rising)?;
//! let labels: Vec<(&str, usize)> = mesh.boundary_labels().collect();
//! assert_eq!(labels, [("bottom", 1), ("left", 2), ("right", 3), ("top", 4)]);
//!
//! let file = MeshFile::parse(mesh.to_freefem()?.as_bytes())?;
//! let read = file.body::<2>("1")?;
//! assert_eq!(read.boundary("4")?, mesh.boundary("top")?);
//! # Ok::<(), contact_fem::Error>(())
//! ```

use std::fmt::Write;
use std::path::Path;

use super::Mesh;
use crate::error::Error;

/// The label of all cells of a body.
const CELLS: usize = 1;
/// The label of facets on no named boundary.
const UNNAMED: usize = 0;

/// Elements with a label, as both formats list them.
type Labelled<'a> = Vec<(&'a [usize], usize)>;

impl<const D: usize> Mesh<D> {
    /// The names of the boundaries with their labels in FreeFEM's files: 1, 2, … in alphabetical
    /// order, or the names themselves if all of them are whole numbers from 1, as in a mesh from a
    /// file. Facets on no boundary have label 0.
    pub fn boundary_labels(&self) -> impl Iterator<Item = (&str, usize)> {
        let number = |name: &str| {
            let label = name.parse().ok().filter(|&label: &usize| label > 0);
            label.filter(|label| label.to_string() == name)
        };
        let are_labels = self.boundary_names().all(|name| number(name).is_some());
        let labels = self.boundary_names().zip(1..);
        labels.map(move |(name, k)| match number(name) {
            Some(label) if are_labels => (name, label),
            _ => (name, k),
        })
    }

    /// The mesh in FreeFEM's format: the text of a `.msh` file in the plane, of Medit's `.mesh` in
    /// space. Coordinates are written with all digits, so that they are read back exactly; all
    /// cells have label 1.
    ///
    /// # Errors
    /// [`Error::SharedFacet`] if a facet is on two boundaries: it can have only one label.
    pub fn to_freefem(&self) -> Result<String, Error> {
        let corners = self.used_corners();
        let cells: Labelled = self.cells().map(|cell| (&cell[..=D], CELLS)).collect();
        let labels = self.facet_labels()?;
        let facets = self.exterior().map(|facet| &facet[..D]);
        let facets: Labelled = facets.zip(labels).collect();
        let mut text = String::new();
        if D == 2 {
            let (cells, facets) = (cells.len(), facets.len());
            text += &format!("{} {cells} {facets}\n", corners.len());
        } else {
            text += &format!("MeshVersionFormatted 2\n\nDimension {D}\n\nVertices\n");
            text += &format!("{}\n", corners.len());
        }
        for &corner in &corners {
            for x in &self.nodes[corner] {
                // writing to a string cannot fail
                let _ = write!(text, "{x:e} ");
            }
            text += "0\n";
        }
        for (elements, keyword) in [(&cells, "Tetrahedra"), (&facets, "Triangles")] {
            if D == 3 {
                text += &format!("\n{keyword}\n{}\n", elements.len());
            }
            for (nodes, label) in elements {
                for node in *nodes {
                    let _ = write!(text, "{} ", 1 + corners.partition_point(|c| c < node));
                }
                text += &format!("{label}\n");
            }
        }
        if D == 3 {
            text += "\nEnd\n";
        }
        Ok(text)
    }

    /// Writes the text of [`Mesh::to_freefem`] to a file. Its name should end in `.msh` in the
    /// plane and in `.mesh` in space.
    ///
    /// # Errors
    /// As [`Mesh::to_freefem`], and [`Error::Write`].
    pub fn save_freefem(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        std::fs::write(path, self.to_freefem()?).map_err(|source| Error::Write {
            path: path.to_path_buf(),
            source: source.into(),
        })
    }

    /// The corners of all cells, ascending; all nodes of a linear mesh.
    fn used_corners(&self) -> Vec<usize> {
        let mut corners: Vec<usize> = self.cells().flat_map(|cell| &cell[..=D]).copied().collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The label of each exterior facet.
    fn facet_labels(&self) -> Result<Vec<usize>, Error> {
        let mut labels = vec![UNNAMED; self.exterior().len()];
        let names: Vec<&String> = self.boundaries.keys().collect();
        for (facets, label) in self.boundaries.values().zip(1..) {
            for &facet in facets {
                if labels[facet] != UNNAMED {
                    return Err(Error::SharedFacet {
                        nodes: self.facet(facet)[..D].to_vec(),
                        first: names[labels[facet] - 1].clone(),
                        second: names[label - 1].clone(),
                    });
                }
                labels[facet] = label;
            }
        }
        Ok(labels)
    }
}
