//! Which point of a master surface is closest: a bounding-volume tree over its current facets.

use rstar::{AABB, PointDistance, RTree, RTreeObject};

use super::normals;
use super::projection::{closest, interpolate};
use super::surface::Surface;
use crate::tensor::{Vector, facet_normal};

/// A master surface at current positions, ready to be projected on.
pub struct Master<'a, const D: usize> {
    surface: &'a Surface<D>,
    tree: RTree<Facet<D>>,
    /// Averaged normals in the order of the surface's nodes.
    normals: Vec<Vector<D>>,
}

/// The closest point x̄ of a master surface.
#[derive(Clone, Copy, Debug)]
pub struct Projection<const D: usize> {
    /// Which facet.
    pub facet: usize,
    /// η*: barycentric coordinates on it.
    pub lambda: Vector<D>,
    /// The outward unit normal n at x̄, interpolated from averaged nodal normals.
    pub normal: Vector<D>,
    /// |x − x̄| (UL).
    pub distance: f64,
    /// (x − x̄)·n, positive = open (UL).
    pub gap: f64,
    /// Whether x̄ is on the rim of the surface and x beyond it.
    pub off_the_end: bool,
}

impl<'a, const D: usize> Master<'a, D> {
    /// A tangential offset beyond this share of the facet's size is off the end.
    const OFF_THE_END: f64 = 1e-9;

    /// Builds tree and normals for positions `x` of all scene nodes.
    pub fn new(surface: &'a Surface<D>, x: &[Vector<D>]) -> Self {
        let facets = surface.facets().iter().enumerate();
        let facets = facets.map(|(index, facet)| Facet {
            index,
            corners: facet.map(|a| x[a]),
        });
        Master {
            surface,
            tree: RTree::bulk_load(facets.collect()),
            normals: normals::averaged(surface, x),
        }
    }

    /// The surface it was made from.
    pub fn surface(&self) -> &Surface<D> {
        self.surface
    }

    /// The averaged normals in the order of the surface's nodes.
    pub fn normals(&self) -> &[Vector<D>] {
        &self.normals
    }

    /// The closest point to `x`, or `None` if the surface has no facet.
    pub fn project(&self, x: &Vector<D>) -> Option<Projection<D>> {
        let facet = self.tree.nearest_neighbor(&(*x).into())?;
        let lambda = closest(x, &facet.corners);
        let foot = interpolate(&lambda, &facet.corners);
        let nodes = self.surface.facets()[facet.index];
        let at_corners = nodes.map(|a| self.normals[self.surface.local(a)]);
        let normal = normals::unit(interpolate(&lambda, &at_corners));
        Some(Projection {
            facet: facet.index,
            lambda,
            normal,
            distance: (x - foot).norm(),
            gap: (x - foot).dot(&normal),
            off_the_end: self.is_off_the_end(facet, &lambda, &(x - foot)),
        })
    }

    fn is_off_the_end(&self, facet: &Facet<D>, lambda: &Vector<D>, offset: &Vector<D>) -> bool {
        let on_rim = (0..D).any(|k| lambda[k] == 0.0 && self.surface.is_rim(facet.index, k));
        if !on_rim {
            return false;
        }
        let normal = facet_normal(&facet.corners);
        let size = (facet.corners[1] - facet.corners[0]).norm();
        let n = normals::unit(normal);
        let tangential = offset - n * offset.dot(&n);
        tangential.norm() > Self::OFF_THE_END * size
    }
}

/// A facet of the tree.
struct Facet<const D: usize> {
    index: usize,
    corners: [Vector<D>; D],
}

impl<const D: usize> RTreeObject for Facet<D> {
    type Envelope = AABB<[f64; D]>;

    fn envelope(&self) -> Self::Envelope {
        let low = self.corners.iter().fold(self.corners[0], |m, x| m.inf(x));
        let high = self.corners.iter().fold(self.corners[0], |m, x| m.sup(x));
        AABB::from_corners(low.into(), high.into())
    }
}

impl<const D: usize> PointDistance for Facet<D> {
    fn distance_2(&self, point: &[f64; D]) -> f64 {
        let x = Vector::from(*point);
        let lambda = closest(&x, &self.corners);
        (x - interpolate(&lambda, &self.corners)).norm_squared()
    }
}
