//! Where surfaces are at rest: by how much two of them are apart, at least.

use crate::contact::Surface;
use crate::element::facet_edge;
use crate::tensor::Vector;

/// The box of a surface, curved facets included (UL).
#[derive(Clone, Copy)]
pub(super) struct Extent<const D: usize> {
    low: Vector<D>,
    high: Vector<D>,
    /// The longest diagonal of the box of a facet.
    facet: f64,
}

impl<const D: usize> Extent<D> {
    /// The extent of `surface` at positions `x` of all nodes (UL).
    pub fn of(surface: &Surface<D>, x: &[Vector<D>]) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY].map(Vector::<D>::repeat);
        let join = |[low, high]: [Vector<D>; 2], x: Vector<D>| [low.inf(&x), high.sup(&x)];
        let mut facet = 0.0_f64;
        let x: Vec<Vector<D>> = surface.nodes().iter().map(|&a| x[a]).collect();
        let boxes = surface.facets().map(|nodes| {
            let [low, high] = bezier_points(nodes, &x).fold(none, join);
            facet = facet.max((high - low).norm());
            [low, high]
        });
        let [low, high] = boxes.flatten().fold(none, join);
        Extent { low, high, facet }
    }

    /// The least distance of both boxes (UL).
    fn distance(&self, other: &Self) -> f64 {
        let between = (other.low - self.high).sup(&(self.low - other.high));
        between.sup(&Vector::zeros()).norm()
    }

    /// The same less the largest facet (UL): test functions that are not positive make averages over some facets less than the
    /// gaps there, by no more than these vary.
    pub fn apart(&self, other: &Self) -> f64 {
        self.distance(other) - self.facet.max(other.facet)
    }
}

/// The points of a facet's Bézier form, which has the facet in its convex hull.
fn bezier_points<const D: usize>(
    nodes: &[usize],
    x: &[Vector<D>],
) -> impl Iterator<Item = Vector<D>> {
    let (corners, middles) = nodes.split_at(D);
    let middles = middles.iter().enumerate().map(|(e, &middle)| {
        let [a, b] = facet_edge::<D>(e).map(|k| x[corners[k]]);
        2.0 * x[middle] - 0.5 * (a + b)
    });
    corners.iter().map(|&a| x[a]).chain(middles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// A parabola of height 1 over a length of 2, beside a straight facet of length 0.5: its Bézier point is at 2. Not all nodes
    /// are of a surface.
    #[test]
    fn curved_facets_are_within_their_boxes() {
        let x =
            [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [2.5, 0.0], [2.25, 0.0]].map(Vector::<2>::from);
        let curved = Surface::new(
            0,
            Order::Quadratic,
            [&[0, 1, 2][..], &[1, 3, 4]].into_iter(),
            &x,
        );
        let extent = Extent::of(&curved, &x);
        assert_eq!(
            (extent.low, extent.high),
            (x[0], Vector::<2>::new(2.5, 2.0))
        );
        assert_eq!(extent.facet, 8f64.sqrt());
        let y = [[9.0, -9.0], [0.0, 7.0], [1.0, 7.0]].map(Vector::<2>::from);
        let above = Extent::of(
            &Surface::new(1, Order::Linear, [&[2, 1][..]].into_iter(), &y),
            &y,
        );
        assert_eq!(extent.distance(&above), 5.0);
        assert_eq!(above.apart(&extent), 5.0 - 8f64.sqrt());
    }
}
