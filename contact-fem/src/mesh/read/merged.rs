//! Vertices of a file that lie on each other.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{MeshFile, Place, Problem};
use crate::error::Error;

impl MeshFile {
    /// Makes one vertex of those that are at most `distance` apart (UL), as where every cell or every part was written with vertices of its
    /// own.
    ///
    /// ```
    /// use contact_fem::mesh::read::MeshFile;
    ///
    /// // two triangles side by side, each with corners of its own
    /// let file = MeshFile::parse(b"6 2 0  0 0 0  1 0 0  1 1 0  0 0 0  1 1 0  0 1 0  1 2 3 7  4 5 6 7")?;
    /// let (_, mesh) = file.merged(1e-9)?.bodies::<2>()?.swap_remove(0);
    /// assert_eq!(mesh.nodes().len(), 4);
    /// # Ok::<(), contact_fem::Error>(())
    /// ```
    ///
    /// # Errors
    /// A distance that is negative or not finite, or as long as two vertices of one element are apart.
    pub fn merged(mut self, distance: f64) -> Result<Self, Error> {
        if !(distance >= 0.0 && distance.is_finite()) {
            return Err(self.fault(Problem::Merge { distance }));
        }
        let leaves = self.vertices.iter().enumerate();
        let leaves = leaves.map(|(v, place)| GeomWithData::new(*place, v));
        let tree = RTree::bulk_load(leaves.collect());
        // each vertex leads to itself or to one with a smaller number
        let mut to: Vec<usize> = Vec::with_capacity(self.vertices.len());
        for (v, place) in self.vertices.iter().enumerate() {
            let near = tree.locate_within_distance(*place, distance * distance);
            let least = near.map(|leaf| leaf.data).min().unwrap_or(v);
            to.push(if least < v { to[least] } else { v });
        }
        for block in &mut self.elements {
            block.nodes.iter_mut().for_each(|v| *v = to[*v]);
        }
        let is_flat = |nodes: &[usize]| (1..nodes.len()).any(|k| nodes[..k].contains(&nodes[k]));
        let has_flat = self.elements.iter().any(|block| block.iter().any(is_flat));
        match has_flat {
            true => Err(self.fault(Problem::Merge { distance })),
            false => Ok(self),
        }
    }

    fn fault(&self, problem: Problem) -> Error {
        Error::MeshFile {
            path: self.path.clone(),
            place: Place::File,
            problem,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of vertices, each within the distance of the next, becomes one; a distance as long as a side is refused.
    #[test]
    fn chains_merge_and_cells_do_not_collapse() {
        let text = b"8 2 0  0 0 0  1 0 0  1 1 0  0.0005 0 0  1 1.0005 0  0 1 0  0.001 0 0  5 5 0  1 2 3 7  7 5 6 7";
        let file = MeshFile::parse(text).expect("a file");
        let merged = file.clone().merged(6e-4).expect("merged");
        let nodes: Vec<usize> = merged.elements()[0].nodes.clone();
        assert_eq!(nodes, [0, 1, 2, 0, 2, 5]);
        for distance in [1.1, -1.0, f64::NAN, f64::INFINITY] {
            let refused = file.clone().merged(distance).expect_err("refused");
            assert!(refused.to_string().contains("merge-nodes"), "{refused}");
        }
        assert_eq!(
            file.clone().merged(0.0).expect("as it is").elements(),
            file.elements()
        );
    }
}
