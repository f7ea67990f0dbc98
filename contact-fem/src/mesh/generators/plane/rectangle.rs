//! Grids of quadrilaterals, each divided into two triangles.

use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::generators::{affordable, ascending};

/// The diagonals along which the quadrilaterals of a grid are divided into triangles.
///
/// With parallel diagonals all interior nodes have the same neighbourhood, which keeps contact
/// pressures smooth. Alternating diagonals produce two kinds of nodes, between which the pressures
/// of linear triangles oscillate by a few per cent. In polar grids the radius takes the role of x
/// and the angle that of y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Diagonals {
    /// From the corner with the smallest x and y to the one with the largest.
    #[default]
    Rising,
    /// From the corner with the largest x and smallest y to the opposite one.
    Falling,
    /// Alternating like the fields of a chessboard.
    Alternating,
}

/// A rectangle on the grid `xs` × `ys` (both ascending, UL), each cell of the grid divided in two.
/// Boundaries: `bottom`, `right`, `top`, `left`.
///
/// # Errors
/// As [`Mesh::new`]; also if the values do not ascend or are fewer than two.
pub fn rectangle(xs: &[f64], ys: &[f64], diagonals: Diagonals) -> Result<Mesh<2>, Error> {
    ascending("xs", xs)?;
    ascending("ys", ys)?;
    affordable(2.0 * xs.len() as f64 * ys.len() as f64)?;
    let nodes = ys.iter().flat_map(|&y| xs.iter().map(move |&x| [x, y]));
    let mut cells = Vec::new();
    let columns = xs.len();
    for j in 0..ys.len() - 1 {
        for i in 0..columns - 1 {
            let a = j * columns + i;
            let corners = [a, a + 1, a + columns + 1, a + columns];
            split(&mut cells, corners, diagonals.first(i + j));
        }
    }
    let mut mesh = Mesh::new(nodes.collect(), cells)?;
    let (x0, x1, y0, y1) = (xs[0], xs[xs.len() - 1], ys[0], ys[ys.len() - 1]);
    mesh.name_boundary("bottom", |X| X[1] == y0);
    mesh.name_boundary("right", |X| X[0] == x1);
    mesh.name_boundary("top", |X| X[1] == y1);
    mesh.name_boundary("left", |X| X[0] == x0);
    Ok(mesh)
}

impl Diagonals {
    /// Whether the cell whose grid indices sum to `index` is divided along its first diagonal.
    pub(super) fn first(self, index: usize) -> bool {
        match self {
            Diagonals::Rising => true,
            Diagonals::Falling => false,
            Diagonals::Alternating => index % 2 == 0,
        }
    }
}

/// Divides a counter-clockwise quadrilateral along its first or second diagonal.
pub(super) fn split(cells: &mut Vec<usize>, [a, b, c, d]: [usize; 4], first: bool) {
    if first {
        cells.extend([a, b, c, a, c, d]);
    } else {
        cells.extend([a, b, d, b, c, d]);
    }
}
