//! The visible parts of a scene: the cells in the plane, the near side of the bodies in space.

use crate::model::Problem;
use crate::output::snapshot::{Snapshot, cells};
use crate::tensor::{Vector, facet_normal};

/// A patch with one colour.
pub(super) struct Patch {
    /// The scene nodes around the patch.
    pub nodes: Vec<usize>,
    /// The cell (in the order of [`Snapshot::cells`]) that determines the colour.
    pub cell: usize,
}

/// The directions towards the viewer, to the right and up, for scenes in space; the view is from
/// the front, the right and above.
pub(super) fn axes<const D: usize>() -> [Vector<D>; 3] {
    let axis = |x: [f64; 3]| Vector::<D>::from_fn(|i, _| x[i]).normalize();
    [
        axis([0.5, -0.8, 0.4]),
        axis([0.8, 0.5, 0.0]),
        axis([-0.2, 0.32, 0.89]),
    ]
}

/// The projection of `x` on the drawing plane (UL, y upwards).
pub(super) fn project<const D: usize>(x: &Vector<D>) -> [f64; 2] {
    let [_, right, up] = axes::<D>();
    match D {
        2 => [x[0], x[1]],
        _ => [x.dot(&right), x.dot(&up)],
    }
}

/// The place of `x` in the picture, and how near it is to the viewer (UL), in space.
pub(super) fn seen<const D: usize>(x: &Vector<D>) -> Vector<3> {
    let [towards, right, up] = axes::<D>();
    Vector::from([x.dot(&right), x.dot(&up), x.dot(&towards)])
}

/// The cells in the plane, the patches in space that face the viewer.
pub(super) fn patches<const D: usize>(problem: &Problem<D>, snapshot: &Snapshot<D>) -> Vec<Patch> {
    if D == 2 {
        let patch = |(cell, (_, nodes))| Patch {
            nodes: around(&Iterator::collect::<Vec<usize>>(nodes), 3),
            cell,
        };
        return cells(problem).enumerate().map(patch).collect();
    }
    let [towards, ..] = axes::<D>();
    let position = |a: usize| problem.reference()[a] + snapshot.displacements[a];
    let mut facing = Vec::new();
    let mut first_cell = 0;
    for (k, body) in problem.scene().bodies().iter().enumerate() {
        let (mesh, first) = (body.mesh(), problem.first_node(k));
        for (facet, cell) in mesh.exterior().zip(mesh.exterior_cells()) {
            let corners: [Vector<D>; D] = std::array::from_fn(|c| position(first + facet[c]));
            if facet_normal(&corners).dot(&towards) > 0.0 {
                let nodes: Vec<usize> = facet.iter().map(|a| first + a).collect();
                facing.push(Patch {
                    nodes: around(&nodes, D),
                    cell: first_cell + cell,
                });
            }
        }
        first_cell += mesh.len();
    }
    facing
}

/// Corners and middle nodes, if there are any, in the order around the patch: 0, 3, 1, 4, 2, 5 of a
/// triangle.
fn around(nodes: &[usize], corners: usize) -> Vec<usize> {
    let (corners, middles) = nodes.split_at(corners);
    let sides = corners.iter().enumerate();
    sides
        .flat_map(|(k, &corner)| [Some(corner), middles.get(k).copied()])
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::snapshot::tests::{squares, tetrahedron};

    #[test]
    fn the_axes_are_orthonormal() {
        let axes = axes::<3>();
        for (i, a) in axes.iter().enumerate() {
            for (j, b) in axes.iter().enumerate() {
                assert!(
                    (a.dot(b) - f64::from(u8::from(i == j))).abs() < 1e-15,
                    "{i} {j}"
                );
            }
        }
    }

    #[test]
    fn the_near_side_is_seen() {
        let problem = tetrahedron();
        let rest = Snapshot::at_rest(&problem).expect("a snapshot");
        // the faces y = 0 and x + y + z = 1 are visible, x = 0 and z = 0 are not
        let seen = patches(&problem, &rest);
        assert_eq!(seen.len(), 2);
        let problem = squares();
        let rest = Snapshot::at_rest(&problem).expect("a snapshot");
        assert_eq!(patches(&problem, &rest).len(), 4);
    }
}
