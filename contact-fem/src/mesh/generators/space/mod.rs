//! Generators of tetrahedron meshes.

mod ball;
#[cfg(test)]
mod battery;
mod cuboid;
mod extrusion;

pub use ball::{eighth_sphere, hemisphere, sphere};
pub use cuboid::{cuboid, cuboid_graded};
pub use extrusion::{cylinder, extrude};

use crate::error::Error;
use crate::mesh::Mesh;
use crate::tensor::{Matrix, determinant};

/// The mesh of these tetrahedra, whose corners may be in any order.
fn tetrahedra(nodes: Vec<[f64; 3]>, mut cells: Vec<usize>) -> Result<Mesh<3>, Error> {
    for cell in cells.chunks_exact_mut(4) {
        let edges = Matrix::<3>::from_fn(|i, j| nodes[cell[j + 1]][i] - nodes[cell[0]][i]);
        if determinant(&edges) < 0.0 {
            cell.swap(2, 3);
        }
    }
    Mesh::new(nodes, cells)
}
