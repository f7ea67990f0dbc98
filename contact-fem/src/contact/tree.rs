//! A bounding-volume tree over the facets of a surface at current positions.

use rstar::primitives::CachedEnvelope;
use rstar::{AABB, PointDistance, RTree, RTreeNode, RTreeObject};

use super::projection::{closest, closest_on, interpolate};
use crate::element::Facet;
use crate::tensor::Vector;

/// The facets, each with its index.
pub(super) struct FacetTree<const D: usize> {
    tree: RTree<Entry<D>>,
}

type Entry<const D: usize> = CachedEnvelope<Leaf<D>>;

/// A facet with its index.
pub(super) struct Leaf<const D: usize> {
    pub index: usize,
    pub facet: Facet<D>,
    /// [`Facet::bulge`] (UL).
    bulge: f64,
}

/// The point of a facet that is closest to some point x.
#[derive(Clone, Copy)]
pub(super) struct Closest<'a, const D: usize> {
    pub leaf: &'a Leaf<D>,
    /// Its barycentric coordinates.
    pub lambda: Vector<D>,
    /// |x − x̄|² (UL²).
    distance_2: f64,
}

impl<const D: usize> FacetTree<D> {
    pub fn new(facets: impl Iterator<Item = Facet<D>>) -> Self {
        let leaf = |(index, facet): (usize, Facet<D>)| {
            let bulge = facet.bulge();
            CachedEnvelope::new(Leaf {
                index,
                facet,
                bulge,
            })
        };
        FacetTree {
            tree: RTree::bulk_load(facets.enumerate().map(leaf).collect()),
        }
    }

    /// The closest point to `x`, on the first of those facets that are equally close up to round-off; `None` without
    /// facets that have a closest point.
    ///
    /// The nearest box is visited first, and none that is farther away than the closest point so far.
    /// rstar's own search takes every side of a box to be touched by what is in it. That is wrong for
    /// the boxes of curved facets.
    pub fn nearest(&self, x: &Vector<D>) -> Option<Closest<'_, D>> {
        let mut nearest: Option<Closest<'_, D>> = None;
        let mut open = Vec::with_capacity(32);
        push(&mut open, self.tree.root().children(), x);
        while let Some((at_least, node)) = open.pop() {
            let limit = nearest.map_or(f64::INFINITY, |n| n.distance_2);
            if at_least > limit {
                continue;
            }
            match node {
                RTreeNode::Parent(inner) => push(&mut open, inner.children(), x),
                RTreeNode::Leaf(leaf) => {
                    let found = leaf.closest_within(x, limit).filter(|found| {
                        nearest.is_none_or(|n| {
                            found.distance_2 < limit || found.leaf.index < n.leaf.index
                        })
                    });
                    nearest = found.or(nearest);
                }
            }
        }
        nearest
    }

    /// The closest points of all facets within `limit` (UL) of `x`, the closest first.
    pub fn by_distance(&self, x: &Vector<D>, limit: f64) -> impl Iterator<Item = Closest<'_, D>> {
        let facets = self.tree.nearest_neighbor_iter_with_distance_2((*x).into());
        let near = facets.take_while(move |(_, distance_2)| {
            *distance_2 <= limit * limit && distance_2.is_finite()
        });
        let x = *x;
        near.map(move |(leaf, _)| leaf.closest(&x))
    }

    /// The facets with a point within `distance` (UL) of `x`, in no particular order.
    pub fn within(&self, x: &Vector<D>, distance: f64) -> impl Iterator<Item = &Leaf<D>> {
        let near = self
            .tree
            .locate_within_distance((*x).into(), distance * distance);
        near.map(|entry| &**entry)
    }

    /// The facets whose boxes meet the cube of half-width `around` (UL) about `x`.
    pub fn at(&self, x: &Vector<D>, around: f64) -> impl Iterator<Item = &Leaf<D>> {
        let offset = Vector::repeat(around);
        let cube = AABB::from_corners((x - offset).into(), (x + offset).into());
        let met = self.tree.locate_in_envelope_intersecting(cube);
        met.map(|entry| &**entry)
    }

    /// The indices of the facets whose boxes the ray from `x` in direction `d` meets, in no particular order.
    pub fn on_ray(&self, x: &Vector<D>, d: &Vector<D>) -> Vec<usize> {
        let (mut open, mut found) = (Vec::from_iter(self.tree.root().children()), Vec::new());
        while let Some(node) = open.pop() {
            if !is_on_ray(&node.envelope(), x, d) {
                continue;
            }
            match node {
                RTreeNode::Parent(inner) => open.extend(inner.children()),
                RTreeNode::Leaf(leaf) => found.push(leaf.index),
            }
        }
        found
    }

    /// Whether all facets are farther away from `x` than `distance` (UL), by the box around them.
    pub fn is_beyond(&self, x: &Vector<D>, distance: f64) -> bool {
        self.tree.root().envelope().distance_2(&(*x).into()) > distance * distance
    }
}

/// Whether a ray meets a box, or passes it by round-off.
fn is_on_ray<const D: usize>(bounds: &AABB<[f64; D]>, x: &Vector<D>, d: &Vector<D>) -> bool {
    let (low, high) = (Vector::from(bounds.lower()), Vector::from(bounds.upper()));
    let slack = 1e-12 * (high - x).amax().max((low - x).amax());
    let (mut first, mut last) = (0.0, f64::INFINITY);
    for i in 0..D {
        let ends = [low[i] - slack - x[i], high[i] + slack - x[i]].map(|way| way / d[i]);
        first = ends[0].min(ends[1]).max(first);
        last = ends[0].max(ends[1]).min(last);
    }
    first <= last
}

/// Appends the nodes with the squared distances of their boxes from `x`, the nearest last.
fn push<'a, const D: usize>(
    open: &mut Vec<(f64, &'a RTreeNode<Entry<D>>)>,
    nodes: &'a [RTreeNode<Entry<D>>],
    x: &Vector<D>,
) {
    let (first, x) = (open.len(), (*x).into());
    open.extend(
        nodes
            .iter()
            .map(|node| (node.envelope().distance_2(&x), node)),
    );
    open[first..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
}

impl<const D: usize> Leaf<D> {
    /// The distance of `x` (UL).
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        self.closest(x).distance_2.sqrt()
    }

    fn closest(&self, x: &Vector<D>) -> Closest<'_, D> {
        let lambda = closest_on(x, &self.facet);
        Closest {
            leaf: self,
            lambda,
            distance_2: (x - self.facet.point(&lambda)).norm_squared(),
        }
    }

    /// As [`Leaf::closest`], unless its squared distance is larger than `limit`. A curved facet is at most
    /// its bulge closer than the flat facet between its corners.
    fn closest_within(&self, x: &Vector<D>, limit: f64) -> Option<Closest<'_, D>> {
        if self.bulge > 0.0 {
            let corners = self.facet.corners();
            let foot = interpolate(&closest(x, &corners), &corners);
            let at_least = ((x - foot).norm() - self.bulge).max(0.0);
            if at_least * at_least > limit {
                return None;
            }
        }
        let found = Some(self.closest(x)).filter(|found| found.distance_2 <= limit);
        found.filter(|found| found.distance_2.is_finite())
    }
}

impl<const D: usize> RTreeObject for Leaf<D> {
    type Envelope = AABB<[f64; D]>;

    fn envelope(&self) -> Self::Envelope {
        let (low, high) = self.facet.bounding_box();
        AABB::from_corners(low.into(), high.into())
    }
}

impl<const D: usize> PointDistance for Leaf<D> {
    fn distance_2(&self, x: &[f64; D]) -> f64 {
        let distance_2 = self.closest(&(*x).into()).distance_2;
        // rstar compares numbers; a facet without extent has no closest point
        if distance_2.is_nan() {
            f64::INFINITY
        } else {
            distance_2
        }
    }

    fn distance_2_if_less_or_equal(&self, x: &[f64; D], limit: f64) -> Option<f64> {
        let found = self.closest_within(&(*x).into(), limit);
        found.map(|found| found.distance_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Order, facet_edge};

    /// Numbers in [0, 1).
    fn chance(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A quadratic facet of size 1 in a box of size 3, whose middle nodes are off by `bent`.
    fn facet<const D: usize>(bent: f64, state: &mut u64) -> Facet<D> {
        let mut vector = |scale: f64| Vector::<D>::from_fn(|_, _| scale * chance(state));
        let about = vector(3.0);
        let mut nodes: Vec<_> = (0..D).map(|_| about + vector(1.0)).collect();
        for [a, b] in (0..D * (D - 1) / 2).map(facet_edge::<D>) {
            let middle = (nodes[a] + nodes[b]) * 0.5;
            nodes.push(middle + vector(bent) - Vector::repeat(0.5 * bent));
        }
        let numbers: Vec<usize> = (0..nodes.len()).collect();
        Facet::gather(Order::Quadratic, &numbers, &nodes)
    }

    fn nearest_of_all<const D: usize>(bent: f64) {
        let mut state = 1;
        for _ in 0..100 {
            let facets: Vec<Facet<D>> = (0..40).map(|_| facet(bent, &mut state)).collect();
            let tree = FacetTree::new(facets.iter().copied());
            for _ in 0..20 {
                let x = Vector::from_fn(|_, _| 8.0 * chance(&mut state) - 2.0);
                let away = |facet: &Facet<D>| (x - facet.point(&closest_on(&x, facet))).norm();
                let least = facets.iter().map(away).fold(f64::INFINITY, f64::min);
                let found = tree.nearest(&x).expect("facets");
                assert_eq!(found.leaf.distance(&x), least);
            }
        }
    }

    /// Also with facets so curved that their boxes are much larger than they are.
    #[test]
    fn the_nearest_of_all_facets() {
        for bent in [0.0, 0.1, 0.5, 1.5] {
            nearest_of_all::<2>(bent);
            nearest_of_all::<3>(bent);
        }
    }

    fn within_the_bulge<const D: usize>() {
        let mut state = 1;
        for _ in 0..1000 {
            let facet: Facet<D> = facet(1.0, &mut state);
            let weights = Vector::<D>::from_fn(|_, _| chance(&mut state));
            let lambda = weights / weights.sum();
            let flat = interpolate(&lambda, &facet.corners());
            assert!((facet.point(&lambda) - flat).norm() <= facet.bulge());
        }
    }

    #[test]
    fn facets_stay_within_their_bulge() {
        within_the_bulge::<2>();
        within_the_bulge::<3>();
    }

    #[test]
    fn first_of_equally_close_facets() {
        let nodes = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]].map(Vector::<2>::from);
        let segments = [[1, 2], [0, 1]].map(|ends| Facet::gather(Order::Linear, &ends, &nodes));
        let tree = FacetTree::new(segments.into_iter());
        let found = tree.nearest(&Vector::<2>::new(1.0, 0.5)).expect("facets");
        assert_eq!((found.leaf.index, found.lambda[0]), (0, 1.0));
        assert!(
            FacetTree::<2>::new(std::iter::empty())
                .nearest(&nodes[0])
                .is_none()
        );
    }
}
