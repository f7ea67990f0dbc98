//! Where a surface ends.

use std::collections::HashMap;

use super::surface::Surface;
use crate::element::facet_edge;
use crate::tensor::Vector;

/// The rim of a surface: the sides of its facets, nodes in the plane and edges in space, that have no neighbour. Beyond an axis of
/// revolution, a surface goes on as its mirror image.
#[derive(Clone, Debug, Default)]
pub(super) struct Rim<const D: usize> {
    /// For each facet and corner, whether the side opposite the corner is on the rim.
    sides: Vec<[bool; D]>,
    /// For each node, whether it is a corner on the rim.
    corners: Vec<bool>,
    /// For each node, the mean length of the facets around it (UL).
    sizes: Vec<f64>,
}

impl<const D: usize> Rim<D> {
    /// Of a surface that knows its facets and its axis.
    pub fn of(surface: &Surface<D>) -> Self {
        let side = |facet: &[usize], omitted: usize| {
            let [a, b] = facet_edge::<D>((omitted + 1) % D);
            let (a, b) = if D == 2 { (a, a) } else { (a, b) };
            [facet[a].min(facet[b]), facet[a].max(facet[b])]
        };
        let mut sharers: HashMap<[usize; 2], usize> = HashMap::new();
        for facet in surface.facets() {
            for k in 0..D {
                *sharers.entry(side(facet, k)).or_insert(0) += 1;
            }
        }
        let is_axis = |side: [usize; 2]| side.iter().all(|&a| surface.is_on_axis(a));
        let ends = |side: [usize; 2]| sharers[&side] == 1 && !is_axis(side);
        let sides = surface
            .facets()
            .map(|facet| std::array::from_fn(|k| ends(side(facet, k))));
        let sides: Vec<[bool; D]> = sides.collect();
        let mut corners = vec![false; surface.nodes().len()];
        for (facet, sides) in surface.facets().zip(&sides) {
            for (k, _) in sides.iter().enumerate().filter(|(_, ends)| **ends) {
                side(facet, k).iter().for_each(|&a| corners[a] = true);
            }
        }
        let sizes = surface.node_sizes();
        Rim {
            sides,
            corners,
            sizes,
        }
    }

    /// Whether the point λ of a facet with these nodes is on the rim: on a side without a neighbour, or in a corner that is on the rim.
    pub fn has(&self, facet: usize, nodes: &[usize], lambda: &Vector<D>) -> bool {
        let on_side = |k: usize| lambda[k] == 0.0;
        let corner = (0..D).find(|&k| lambda[k] == 1.0);
        (0..D).any(|k| on_side(k) && self.sides[facet][k])
            || corner.is_some_and(|k| self.corners[nodes[k]])
    }

    /// Whether a node is a corner on the rim.
    pub fn is_corner(&self, node: usize) -> bool {
        self.corners[node]
    }

    /// How far the point λ of a facet with these nodes is from the rim, as a share of a facet: 0 on the rim, 1 in the centre of
    /// every facet, in the middles of inner sides and at inner corners, and linear between them. It is continuous over the surface.
    pub fn depth(&self, facet: usize, nodes: &[usize], lambda: &Vector<D>) -> f64 {
        self.depth_and_slope(facet, nodes, lambda).0
    }

    /// The same with its derivatives by the components of λ.
    pub fn depth_and_slope(
        &self,
        facet: usize,
        nodes: &[usize],
        lambda: &Vector<D>,
    ) -> (f64, Vector<D>) {
        if !nodes[..D].iter().any(|&a| self.corners[a]) {
            return (1.0, Vector::zeros());
        }
        let mut largest: [usize; D] = std::array::from_fn(|k| k);
        largest.sort_unstable_by(|&a, &b| lambda[b].total_cmp(&lambda[a]));
        // λ is between the corner of its largest coordinate, the middle of the side of its two largest ones, and the centre
        let is_inner = |k: usize| match k {
            _ if k + 1 == D => true,
            0 => !self.corners[nodes[largest[0]]],
            _ => !self.sides[facet][largest[2]],
        };
        let mut slope = Vector::<D>::zeros();
        for k in (0..D).filter(|k| is_inner(*k)) {
            let share = (k + 1) as f64;
            slope[largest[k]] += share;
            if let Some(&next) = largest.get(k + 1) {
                slope[next] -= share;
            }
        }
        (slope.dot(lambda), slope)
    }

    /// The length of the facets around the point λ of a facet with these nodes (UL), which is interpolated between its corners.
    pub fn size(&self, nodes: &[usize], lambda: &Vector<D>) -> f64 {
        self.sizes(nodes).dot(lambda)
    }

    fn sizes(&self, nodes: &[usize]) -> Vector<D> {
        Vector::from_fn(|k, _| self.sizes[nodes[k]])
    }

    /// The depth as a length (UL), depth by size, with its derivatives by the components of λ.
    pub fn length_and_slope(
        &self,
        facet: usize,
        nodes: &[usize],
        lambda: &Vector<D>,
    ) -> (f64, Vector<D>) {
        let (depth, slope) = self.depth_and_slope(facet, nodes, lambda);
        let size = self.size(nodes, lambda);
        (depth * size, slope * size + self.sizes(nodes) * depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::clip::tests::Random;
    use crate::element::{Facet, Order};
    use crate::mesh::generators::cuboid;

    /// The top of a block of three by three squares in space, and three segments in the plane.
    fn top() -> Surface<3> {
        let mesh = cuboid([0.0; 3], [3.0, 3.0, 1.0], [3, 3, 1]).expect("mesh");
        let facets = mesh.boundary("top").expect("named");
        Surface::new(0, Order::Linear, facets.into_iter(), mesh.nodes())
    }

    /// The length varies as differences of it do, on facets of unequal sizes. It is continuous between facets, and so is the depth.
    #[test]
    fn slopes_of_the_length() {
        let mesh = cuboid([0.0; 3], [3.0, 3.0, 1.0], [3, 3, 1]).expect("mesh");
        let uneven = |X: &Vector<3>| Vector::<3>::new(X[0] + X[0] * X[0], X[1].exp(), X[2]);
        let mesh = mesh.mapped(uneven).expect("mesh");
        let facets = mesh.boundary("top").expect("named");
        let surface = Surface::new(0, Order::Linear, facets.into_iter(), mesh.nodes());
        let mut random = Random(9);
        for (f, _) in surface.reference().iter().enumerate() {
            let nodes = surface.facet(f);
            let length = |lambda: &Vector<3>| surface.rim().length_and_slope(f, nodes, lambda);
            for _ in 0..200 {
                let lambda = Vector::<3>::from_fn(|_, _| -random.next().ln());
                let lambda = lambda / lambda.sum();
                let (here, slope) = length(&lambda);
                let depth = surface.rim().depth(f, nodes, &lambda);
                let size = surface.rim().size(nodes, &lambda);
                assert!((here - depth * size).abs() < 1e-14 * size);
                for k in 0..3 {
                    let way = Vector::<3>::from_fn(|i, _| if i == k { 1e-6 } else { -0.5e-6 });
                    let [there, back] = [way, -way].map(|way| length(&(lambda + way)).0);
                    let ahead = (there - here - slope.dot(&way)).abs();
                    let behind = (back - here + slope.dot(&way)).abs();
                    assert!(ahead.min(behind) < 1e-10 * size, "{lambda}: {slope}");
                }
                // on a side, both facets have the same
                let mut on_side = lambda;
                on_side[0] = 0.0;
                on_side /= on_side.sum();
                let [a, b] = [nodes[1], nodes[2]];
                let of = |g: usize, node: usize| surface.facet(g).iter().position(|&c| c == node);
                let across = (0..surface.len()).find_map(|g| {
                    let (p, q) = (of(g, a)?, of(g, b)?);
                    (g != f).then_some((g, p, q))
                });
                if let Some((g, p, q)) = across {
                    let mut same = Vector::<3>::zeros();
                    (same[p], same[q]) = (on_side[1], on_side[2]);
                    let there = surface.rim().length_and_slope(g, surface.facet(g), &same).0;
                    assert!((length(&on_side).0 - there).abs() < 1e-14 * size);
                }
            }
        }
    }

    /// The slope of the depth is that of differences.
    #[test]
    fn slopes_of_the_depth() {
        let surface = top();
        let mut random = Random(7);
        for (f, _) in surface.reference().iter().enumerate() {
            let nodes = surface.facet(f);
            for _ in 0..200 {
                let lambda = Vector::<3>::from_fn(|_, _| -random.next().ln());
                let lambda = lambda / lambda.sum();
                let (depth, slope) = surface.rim().depth_and_slope(f, nodes, &lambda);
                for k in 0..3 {
                    let way = Vector::<3>::from_fn(|i, _| if i == k { 1e-7 } else { -0.5e-7 });
                    let there = surface.rim().depth(f, nodes, &(lambda + way));
                    let back = surface.rim().depth(f, nodes, &(lambda - way));
                    // across a kink, the two sides differ
                    let ahead = (there - depth - slope.dot(&way)).abs();
                    let behind = (back - depth + slope.dot(&way)).abs();
                    assert!(ahead.min(behind) < 1e-14, "{lambda}: {slope}");
                }
            }
        }
    }

    /// At the centroid of every facet the depth is 1, on the sides of the square 0, elsewhere more than 0; points of neighbours that are
    /// near each other have nearly the same depth.
    #[test]
    fn the_depth_is_continuous_and_vanishes_on_the_rim_alone() {
        let surface = top();
        let mut random = Random(5);
        let mut known: Vec<(Vector<3>, f64)> = Vec::new();
        for (f, facet) in surface.reference().iter().enumerate() {
            let depth = |lambda: &Vector<3>| surface.rim().depth(f, surface.facet(f), lambda);
            assert!((depth(&Vector::repeat(1.0 / 3.0)) - 1.0).abs() < 1e-14);
            for k in 0..4000 {
                let mut lambda = Vector::<3>::from_fn(|_, _| -random.next().ln());
                if k % 2 == 0 {
                    lambda[k / 2 % 3] = 0.0;
                }
                lambda /= lambda.sum();
                let (x, depth) = (facet.point(&lambda), depth(&lambda));
                let from_rim = [x[0], x[1], 3.0 - x[0], 3.0 - x[1]]
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                // between a third of a square and its sixth-part triangles
                assert!(depth <= 6.0 * from_rim + 1e-14 && depth <= 1.0 + 1e-14);
                assert!(depth >= from_rim.min(0.5) - 1e-14, "{x:?}: {depth}");
                known.push((x, depth));
            }
        }
        let mut near = 0;
        for (k, (x, depth)) in known.iter().enumerate().step_by(7) {
            for (other, there) in &known[k + 1..] {
                let apart = (x - other).norm();
                if apart < 0.02 {
                    near += 1;
                    assert!((depth - there).abs() <= 6.0 * apart, "{x:?} {other:?}");
                }
            }
        }
        assert!(near > 1000, "{near}");
    }

    #[test]
    fn in_the_plane() {
        let x = [0.0, 1.0, 2.0, 3.0].map(|x| Vector::<2>::new(x, 0.0));
        let facets = [[1, 0], [2, 1], [3, 2]];
        let surface = Surface::new(0, Order::Linear, facets.iter().map(|f| &f[..]), &x);
        for k in 0..=30 {
            let at = 0.1 * f64::from(k);
            let f = (at as usize).min(2);
            let t = at - f as f64;
            let lambda = Vector::<2>::new(t, 1.0 - t);
            assert!(
                (Facet::gather(Order::Linear, &facets[f], &x).point(&lambda)[0] - at).abs() < 1e-14
            );
            let depth = surface.rim().depth(f, surface.facet(f), &lambda);
            assert!(
                (depth - (2.0 * at).min(2.0 * (3.0 - at)).min(1.0)).abs() < 1e-14,
                "{at}"
            );
        }
    }
}
