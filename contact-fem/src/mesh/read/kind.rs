//! The kinds of elements in mesh files.

use std::fmt;

/// A simplex of order 1 or 2.
///
/// The corners come first. Middle nodes of edges follow in VTK's order: edges 01, 12, 20 of a
/// triangle; 01, 12, 20, 03, 13, 23 of a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ElementKind {
    /// One node.
    Point,
    /// 2 nodes.
    Segment,
    /// 3 nodes.
    Segment3,
    /// 3 nodes.
    Triangle,
    /// 6 nodes.
    Triangle6,
    /// 4 nodes.
    Tetrahedron,
    /// 10 nodes.
    Tetrahedron10,
}

impl ElementKind {
    /// The dimension: 0 for points to 3 for tetrahedra.
    pub fn dimension(self) -> usize {
        match self {
            ElementKind::Point => 0,
            ElementKind::Segment | ElementKind::Segment3 => 1,
            ElementKind::Triangle | ElementKind::Triangle6 => 2,
            ElementKind::Tetrahedron | ElementKind::Tetrahedron10 => 3,
        }
    }

    /// The number of corners: the dimension + 1.
    pub fn corners(self) -> usize {
        self.dimension() + 1
    }

    /// The number of nodes.
    pub fn nodes(self) -> usize {
        match self {
            ElementKind::Segment3 => 3,
            ElementKind::Triangle6 => 6,
            ElementKind::Tetrahedron10 => 10,
            linear => linear.corners(),
        }
    }

    /// The permutation of the nodes that reverses the orientation of the element.
    pub fn mirrored(self) -> &'static [usize] {
        match self {
            ElementKind::Point => &[0],
            ElementKind::Segment => &[1, 0],
            ElementKind::Segment3 => &[1, 0, 2],
            ElementKind::Triangle => &[0, 2, 1],
            ElementKind::Triangle6 => &[0, 2, 1, 5, 4, 3],
            ElementKind::Tetrahedron => &[0, 1, 3, 2],
            ElementKind::Tetrahedron10 => &[0, 1, 3, 2, 4, 8, 7, 6, 5, 9],
        }
    }
}

impl fmt::Display for ElementKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            ElementKind::Point => "point",
            ElementKind::Segment => "2-node segment",
            ElementKind::Segment3 => "3-node segment",
            ElementKind::Triangle => "3-node triangle",
            ElementKind::Triangle6 => "6-node triangle",
            ElementKind::Tetrahedron => "4-node tetrahedron",
            ElementKind::Tetrahedron10 => "10-node tetrahedron",
        })
    }
}
