//! Nodes by their places.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::Mesh;
use crate::error::Error;

impl<const D: usize> Mesh<D> {
    /// The distance within which a node is at a point, as a share of the mesh's diagonal: above the digits that mesh
    /// files keep.
    const AT: f64 = 1e-9;

    /// The node at each of these points (UL), for fields of a program that numbers nodes in its own way.
    ///
    /// FreeFEM numbers the vertices of its `P1` as the file does, but not the nodes of its `P2`. After
    /// `fespace Vh(Th, [P2, P2]); Vh [X, Y] = [x, y];` the coordinates of node i are `X[][2*i]` and `X[][2*i + 1]`, and
    /// the components of a field at it `u[][2*i]` and `u[][2*i + 1]`. Its sides are straight, as those of
    /// [`Mesh::quadratic`].
    /// ```
    /// use contact_fem::MeshFile;
    ///
    /// let file = MeshFile::parse(b"3 1 0  0 0 0  1 0 0  0 1 0  1 2 3 7")?;
    /// let mesh = file.body::<2>("7")?.quadratic();
    /// assert_eq!(mesh.nodes_at(&[[0.0, 1.0], [0.5, 0.5]])?, [2, 4]);
    /// # Ok::<(), contact_fem::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NodeAt`] if there is no node at a point, or more than one, as on the sides of a crack.
    pub fn nodes_at(&self, points: &[[f64; D]]) -> Result<Vec<usize>, Error> {
        let leaves = self.nodes.iter().enumerate();
        let leaves = leaves.map(|(a, X)| GeomWithData::new(<[f64; D]>::from(*X), a));
        let tree = RTree::bulk_load(leaves.collect());
        let (low, high) = self.bounding_box();
        let within = Self::AT * (high - low).norm();
        let node = |point: &[f64; D]| {
            let mut near = tree.locate_within_distance(*point, within * within);
            match (near.next(), near.count()) {
                (Some(leaf), 0) => Ok(leaf.data),
                (first, others) => Err(Error::NodeAt {
                    point: point.to_vec(),
                    found: usize::from(first.is_some()) + others,
                    within,
                }),
            }
        };
        points.iter().map(node).collect()
    }
}
