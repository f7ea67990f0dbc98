//! Grids of boxes, each divided into six tetrahedra.

use super::tetrahedra;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::generators::{affordable, ascending, linspace, positive};

/// A cuboid from its corner `low` (UL) with edges of length `size` (UL) and uniform divisions.
/// Tetrahedra and boundaries are those of [`cuboid_graded`].
///
/// # Errors
/// As [`cuboid_graded`]; also if a size is not positive or a division is 0.
pub fn cuboid(low: [f64; 3], size: [f64; 3], divisions: [usize; 3]) -> Result<Mesh<3>, Error> {
    const SIZE: [&str; 3] = ["size[0]", "size[1]", "size[2]"];
    const DIVISIONS: [&str; 3] = ["divisions[0]", "divisions[1]", "divisions[2]"];
    Error::check_finite("low", &low)?;
    for i in 0..3 {
        positive(SIZE[i], Some(size[i]))?;
        positive(DIVISIONS[i], Some(divisions[i] as f64))?;
    }
    affordable(6.0 * divisions.iter().map(|&n| n as f64).product::<f64>())?;
    let [x, y, z] = [0, 1, 2].map(|i| linspace(low[i], low[i] + size[i], divisions[i]));
    cuboid_graded(&x, &y, &z)
}

/// A cuboid on the grid `x` × `y` × `z` (ascending, UL).
/// Boundaries: `left` and `right` (lowest and highest x), `front` and `back` (y), `bottom` and
/// `top` (z).
///
/// Each box of the grid is divided into Kuhn's six tetrahedra around a space diagonal, mirrored
/// along every axis in which the index of the box is odd. Boxes with a common face are then mirror
/// images in it and divide it in the same way. No direction is preferred, and with even divisions
/// of a symmetric grid the mesh has the three mirror planes of the cuboid, which a single diagonal
/// for all boxes would not give.
///
/// The nodes do not all have the same neighbourhood: inside, nodes with all indices even or all odd
/// belong to 48 tetrahedra, the others to 16. The pressures of linear elements oscillate between
/// them, as with [`Diagonals::Alternating`]. The top of an [`extruded`](super::extrude) rectangle
/// with [`Diagonals::Rising`] has nodes of one kind only.
///
/// [`Diagonals::Alternating`]: crate::mesh::generators::Diagonals::Alternating
/// [`Diagonals::Rising`]: crate::mesh::generators::Diagonals::Rising
///
/// # Errors
/// As [`Mesh::new`]; also if the values do not ascend or are fewer than two, or there are more than
/// 10⁸ tetrahedra.
pub fn cuboid_graded(x: &[f64], y: &[f64], z: &[f64]) -> Result<Mesh<3>, Error> {
    let grid = [x, y, z];
    for (name, values) in ["x", "y", "z"].into_iter().zip(grid) {
        ascending(name, values)?;
    }
    let boxes = grid.map(|values| values.len() - 1);
    affordable(6.0 * boxes.iter().map(|&n| n as f64).product::<f64>())?;
    let mut nodes = Vec::new();
    for &z in z {
        nodes.extend(y.iter().flat_map(|&y| x.iter().map(move |&x| [x, y, z])));
    }
    let node = |[i, j, k]: [usize; 3]| (k * y.len() + j) * x.len() + i;
    let mut cells = Vec::new();
    for k in 0..boxes[2] {
        for j in 0..boxes[1] {
            for i in 0..boxes[0] {
                cells.extend(kuhn([i, j, k]).map(node));
            }
        }
    }
    let mut mesh = tetrahedra(nodes, cells)?;
    let names = [["left", "right"], ["front", "back"], ["bottom", "top"]];
    for i in 0..3 {
        let ends = [grid[i][0], grid[i][boxes[i]]];
        for (name, end) in names[i].into_iter().zip(ends) {
            mesh.name_boundary(name, |X| X[i] == end);
        }
    }
    Ok(mesh)
}

/// Kuhn's six tetrahedra of the box with this index, four grid points each: the paths along the
/// edges of the box from the corner with even indices to the opposite one, whose indices are odd.
fn kuhn(index: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    let even = index.map(|i| i + i % 2);
    let odd = index.map(|i| i + (i + 1) % 2);
    ORDERS.into_iter().flat_map(move |order| {
        let mut corner = even;
        let mut path = [even; 4];
        for (next, axis) in path[1..].iter_mut().zip(order) {
            corner[axis] = odd[axis];
            *next = corner;
        }
        path
    })
}

#[cfg(test)]
mod tests {
    use super::super::battery::{check, dihedral_angles, is_mirrored};
    use super::*;
    use crate::mesh::generators::graded;

    #[test]
    fn cuboids_fill_their_boxes() {
        for divisions in [[1, 1, 1], [2, 1, 3], [3, 4, 2], [5, 5, 5]] {
            let mesh = cuboid([-1.0, 2.0, 0.5], [2.0, 3.0, 0.5], divisions).expect("mesh");
            let areas = [
                ("left", 1.5),
                ("right", 1.5),
                ("front", 1.0),
                ("back", 1.0),
                ("bottom", 6.0),
                ("top", 6.0),
            ];
            check(&mesh, 1, 3.0, &areas, 1e-13);
            let [nx, ny, nz] = divisions;
            assert_eq!(mesh.len(), 6 * nx * ny * nz);
            assert_eq!(mesh.nodes().len(), (nx + 1) * (ny + 1) * (nz + 1));
            for (name, count) in [("left", ny * nz), ("back", nx * nz), ("top", nx * ny)] {
                assert_eq!(mesh.boundary(name).expect("named").len(), 2 * count);
            }
        }
    }

    #[test]
    fn even_divisions_are_mirror_symmetric() {
        let mesh = cuboid([-1.0; 3], [2.0; 3], [4, 2, 6]).expect("mesh");
        let odd = cuboid([-1.0; 3], [2.0; 3], [4, 2, 5]).expect("mesh");
        assert!((0..3).all(|axis| is_mirrored(&mesh, axis)));
        assert_eq!(
            [0, 1, 2].map(|axis| is_mirrored(&odd, axis)),
            [true, true, false]
        );
    }

    #[test]
    fn inner_nodes_come_in_two_kinds() {
        let mesh = cuboid([0.0; 3], [5.0; 3], [5; 3]).expect("mesh");
        let mut touched = vec![0; mesh.nodes().len()];
        mesh.cells().flatten().for_each(|&a| touched[a] += 1);
        for (X, touched) in mesh.nodes().iter().zip(touched) {
            let index = [0, 1, 2].map(|i| X[i].round() as usize);
            if index.iter().all(|i| (1..5).contains(i)) {
                let alike = index.iter().all(|i| i % 2 == index[0] % 2);
                assert_eq!(touched, if alike { 48 } else { 16 });
            }
        }
    }

    #[test]
    fn cubes_have_the_angles_of_kuhn() {
        let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3]).expect("mesh");
        let (low, high) = dihedral_angles(&mesh);
        assert!((low - 45.0).abs() < 1e-9 && (high - 90.0).abs() < 1e-9);
    }

    #[test]
    fn grids_may_be_graded() {
        let z = graded(0.0, 2.0, 0.1, 5).expect("grading");
        let mesh = cuboid_graded(&[0.0, 0.1, 1.0], &[-3.0, -1.0], &z).expect("mesh");
        let areas = [
            ("left", 4.0),
            ("right", 4.0),
            ("front", 2.0),
            ("back", 2.0),
            ("bottom", 2.0),
            ("top", 2.0),
        ];
        check(&mesh, 1, 4.0, &areas, 1e-13);
    }

    #[test]
    fn bad_cuboids_are_refused() {
        let (o, one) = ([0.0; 3], [1.0; 3]);
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = cuboid(o, [1.0, size, 1.0], [1; 3]).expect_err("size");
            assert!(matches!(
                error,
                Error::Setting {
                    name: "size[1]",
                    ..
                }
            ));
        }
        let error = cuboid(o, one, [1, 1, 0]).expect_err("no division");
        assert!(matches!(
            error,
            Error::Setting {
                name: "divisions[2]",
                ..
            }
        ));
        for divisions in [[usize::MAX, 1, 1], [usize::MAX; 3], [1000, 1000, 20]] {
            let error = cuboid(o, one, divisions).expect_err("too many");
            assert!(matches!(error, Error::Setting { name: "cells", .. }));
        }
        let error = cuboid([0.0, f64::NAN, 0.0], one, [1; 3]).expect_err("NaN");
        assert!(matches!(error, Error::NotFinite { index: 1, .. }));
        let error = cuboid([1e20, 0.0, 0.0], one, [1; 3]).expect_err("lost in round-off");
        assert!(matches!(error, Error::Setting { name: "x", .. }));
        let xs = [0.0, 1.0];
        let bad: [&[f64]; 4] = [&[], &[1.0], &[0.0, 1.0, 1.0], &[0.0, 2.0, 1.0]];
        for z in bad {
            let error = cuboid_graded(&xs, &xs, z).expect_err("grid");
            assert!(matches!(error, Error::Setting { name: "z", .. }));
        }
        let error = cuboid_graded(&xs, &[0.0, f64::INFINITY], &xs).expect_err("infinite");
        assert!(matches!(error, Error::NotFinite { index: 1, .. }));
    }
}
