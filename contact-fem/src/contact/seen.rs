//! Whether a point of a slave sees its foot, and with what share it counts by that.
//!
//! A point that is behind its foot has penetrated the master there, or it looks at the surface from the other side, through a body: as the
//! bottom of a slab sees its top. Two signs tell: the way to the foot leads through a body in the reference configuration, or crosses the surface now.
//!
//! A point loses its weight gradually as one of these signs appears, so that its weight is continuous in the state.

use super::normals;
use super::search::{FootPoint, Master, Seeker};
use super::tree::Leaf;
use crate::element::facet_shapes;
use crate::tensor::{Matrix, Vector};

/// The largest distance of a point that has penetrated, as a share of the length of the reference path to the foot. Penetrations are much smaller, and material is not
/// compressed that far.
const MATERIAL: f64 = 0.2;
/// A reference path leads through a single body if it is deeper below the surface than this share of the facet size. The
/// sides of a closed slit are nearer to each other. From the second depth on, it does so beyond doubt.
const CLOSED: [f64; 2] = [1e-6, 0.05];
/// The same between two bodies, as a share of the larger facet size: bodies may overlap slightly in the reference configuration.
const OVERLAP: f64 = 0.2;
/// The same, as a share of the depth with which bodies are fitted into each other: that is the shortest way out, and a way along normals is
/// longer. The thickness of the bodies is more than twice the depth.
const FIT: f64 = 1.5;
/// The same, as a share of the path's length: where surfaces slide on each other, most of the path is along them.
const THROUGH: f64 = 0.5;
/// A point is out of sight at this multiple of these distances and depths, and in sight up to them.
const BEYOND: f64 = 1.25;
/// A way crosses a facet if both its ends are farther away from it than this share of the facet size, and beyond doubt if they are twice as far.
const SHALLOW: f64 = 0.05;
/// Barycentric coordinates from which on a place is well inside a facet: near a corner of the foot, and near the rim, a crossing tells nothing.
const INSIDE: f64 = 0.25;

/// 1 up to `from`, 0 beyond `to`.
pub(super) fn falling(value: f64, [from, to]: [f64; 2]) -> f64 {
    ((to - value) / (to - from)).clamp(0.0, 1.0)
}

impl<const D: usize> Master<D> {
    /// The share with which a point counts by what lies between it and its foot.
    pub(super) fn seen(&self, p: &FootPoint<D>, seeker: &Seeker<'_, D>) -> f64 {
        #[cfg(planted)]
        if contact_core::planted!("what is seen through material counts") {
            return 1.0;
        }
        if p.gap >= 0.0 {
            return 1.0;
        }
        let outside = self.outside(p, seeker);
        match outside > 0.0 && p.distance > 2.0 * SHALLOW * self.facet_size {
            true => outside.min(1.0 - self.crossed(p, seeker)),
            false => outside,
        }
    }

    /// The share by the path between point and foot in the reference configuration: 0 where it leads through a body and is not much longer than the way now.
    fn outside(&self, p: &FootPoint<D>, seeker: &Seeker<'_, D>) -> f64 {
        let surface = self.surface();
        let way = surface.reference()[p.facet].point(&p.lambda) - seeker.X;
        let N = facet_shapes(surface.order(), &p.lambda);
        let nodes = surface.facet(p.facet).iter().zip(N);
        let normal = nodes.map(|(&a, N)| surface.reference_normals()[a] * N);
        // the depth of the path below the surface at its start and at its end
        let starts = -way.dot(&normals::unit(seeker.N));
        let ends = way.dot(&normals::unit(normal.sum()));
        let length = way.norm();
        let limits = |least: f64| [least, BEYOND * least];
        let depths = match seeker.own {
            Some(_) => CLOSED.map(|share| share * self.facet_size),
            None => {
                let facet = self.facet_size.max(seeker.facet_size);
                let overlap = (OVERLAP * facet).max(FIT * self.fit);
                limits(overlap.max(THROUGH * length))
            }
        };
        let far = falling(p.distance, limits(MATERIAL * length));
        far.max(falling(starts.max(ends), depths))
    }

    /// How surely the way from a point to its foot crosses the surface, beyond the facets around the foot's and beside the point's own: from 0 to 1.
    fn crossed(&self, p: &FootPoint<D>, seeker: &Seeker<'_, D>) -> f64 {
        let x = &seeker.x;
        let middle = (x + p.foot) * 0.5;
        let surface = self.surface();
        let corners = surface.facet(p.facet).iter().zip(p.lambda.iter());
        let share_a_facet = |a: usize, b: usize| {
            let mut around = surface.facets_around(a);
            around.any(|(facet, _)| surface.facet(facet).contains(&b))
        };
        // nodes around a corner of the foot's facet are of its surroundings less and less, as the foot moves away from that corner
        let of_foot = |b: usize| {
            let own = corners.clone().filter(|(a, _)| share_a_facet(**a, b));
            let shares = own.map(|(_, lambda)| (lambda / INSIDE).clamp(0.0, 1.0));
            shares.fold(0.0, f64::max)
        };
        let of_point = |b: usize| if self.is_own(seeker, b) { 1.0 } else { 0.0 };
        let crossing = |leaf: &Leaf<D>| {
            let corners = leaf.facet.corners();
            // x + t (foot − x) is the first corner + Σ λ_k sides_k
            let mut sides = Matrix::<D>::zeros();
            for k in 1..D {
                sides.set_column(k - 1, &(corners[k] - corners[0]));
            }
            sides.set_column(D - 1, &(x - p.foot));
            let at = sides.try_inverse()? * (x - corners[0]);
            let t = at[D - 1];
            let mut lambda = Vector::<D>::from_fn(|k, _| if k == 0 { 1.0 } else { at[k - 1] });
            lambda[0] -= at.rows(0, D - 1).sum();
            if lambda.min() < 0.0 {
                return None;
            }
            let shallow = SHALLOW * self.facet_size;
            let clear = 1.0 - falling(t.min(1.0 - t) * p.distance, [shallow, 2.0 * shallow]);
            let nodes = surface.facet(leaf.index);
            let ends = nodes.iter().zip(lambda.iter());
            let ends = ends.map(|(&b, lambda)| lambda * of_foot(b).max(of_point(b)));
            let inside = surface.rim().depth(leaf.index, nodes, &lambda) / INSIDE;
            Some(clear * (1.0 - ends.sum::<f64>()).max(0.0) * inside.min(1.0))
        };
        let around = self.tree().at(&middle, 0.5 * p.distance);
        around.filter_map(crossing).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::clip::tests::Random;
    use super::super::projection::Projection;
    use super::super::search::Own;
    use super::super::surface::Surface;
    use super::*;
    use crate::element::Order;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{Diagonals, annulus, sphere};
    use crate::tensor::unit_vector;

    /// The outer boundary of a body, bent at random, with the facets in its reference configuration.
    fn bent<const D: usize>(mesh: &Mesh<D>, boundary: &str, random: &mut Random) -> Master<D> {
        let facets = mesh.boundary(boundary).expect("named");
        let facets = facets.iter().copied();
        let surface = Surface::new(0, Order::Linear, facets, mesh.nodes());
        let bend = |X: &Vector<D>| X * (1.0 + 0.3 * random.next());
        let x: Vec<_> = mesh.nodes().iter().map(bend).collect();
        Master::new(&Arc::new(surface), &x, Projection::Closest)
    }

    /// Follows a point and its foot along straight lines, the foot on two facets one after the other. Returns the largest change of the share between
    /// samples, the largest one that is left after the intervals of the three largest have been halved again and again, and the smallest and the largest share.
    fn jump<const D: usize>(
        master: &Master<D>,
        seeker: &Seeker<'_, D>,
        (first, second, shared): (usize, usize, [Vector<D>; 2]),
        (from, to): (Vector<D>, Vector<D>),
    ) -> (f64, f64, [f64; 2]) {
        let middle = Vector::<D>::repeat(1.0 / D as f64);
        let share = |s: f64| {
            let (facet, t, end) = match s < 0.5 {
                true => (first, 2.0 * s, shared[0]),
                false => (second, 2.0 - 2.0 * s, shared[1]),
            };
            let lambda = middle.lerp(&end, t);
            let x = from.lerp(&to, s);
            // any place of the surface is taken for a foot, and the point for one that has penetrated
            let p = FootPoint::on(master.moving(), (facet, lambda), &x);
            let gap = -p.distance;
            master.seen(&FootPoint { gap, ..p }, &Seeker { x, ..*seeker })
        };
        let steps = 1000;
        let at = |k: usize| k as f64 / steps as f64;
        let shares: Vec<f64> = (0..=steps).map(|k| share(at(k))).collect();
        let change = |k: usize| (shares[k + 1] - shares[k]).abs();
        let mut worst: Vec<usize> = (0..steps).collect();
        worst.sort_by(|&a, &b| change(b).total_cmp(&change(a)));
        let left = worst[..3].iter().map(|&k| {
            let (mut from, mut to) = ((at(k), shares[k]), (at(k + 1), shares[k + 1]));
            for _ in 0..25 {
                let s = 0.5 * (from.0 + to.0);
                let middle = (s, share(s));
                match (middle.1 - from.1).abs() > (to.1 - middle.1).abs() {
                    true => to = middle,
                    false => from = middle,
                }
            }
            (to.1 - from.1).abs()
        });
        let range = [f64::min, f64::max].map(|of| shares.iter().copied().reduce(of));
        (
            change(worst[0]),
            left.fold(0.0, f64::max),
            range.map(|end| end.expect("samples")),
        )
    }

    fn shares_are_continuous<const D: usize>(mesh: &Mesh<D>, boundary: &str, paths: usize) {
        let mut random = Random(11);
        let (mut partly, mut hidden, mut whole) = (0, 0, 0);
        for path in 0..paths {
            let master = bent(mesh, boundary, &mut random);
            let surface = master.surface();
            let mut any = |count: usize| (random.next() * count as f64) as usize;
            let first = any(surface.len());
            // the next facet around a corner, and the place that both have there
            let corner = any(D);
            let node = surface.facet(first)[corner];
            let around: Vec<_> = surface.facets_around(node).collect();
            let (second, there) = around[any(around.len())];
            let shared = [corner, there].map(unit_vector::<D>);
            let own = any(surface.len());
            let nodes = surface.facet(own);
            let middle = Vector::<D>::repeat(1.0 / D as f64);
            let mut place = || Vector::<D>::from_fn(|_, _| 2.0 * random.next() - 1.0);
            let (from, to) = (place(), place());
            let seeker = Seeker {
                x: from,
                facing: place(),
                reach: f64::INFINITY,
                X: surface.reference()[own].point(&middle),
                N: surface.reference()[own].normal(&middle),
                facet_size: surface.facet_size(),
                own: (path % 2 == 0).then_some(Own { surface, nodes }),
                reaches_beyond: false,
            };
            // two bodies far away from each other in the beginning: no reference path is short, and only crossings hide a foot
            let seeker = match path % 4 == 1 {
                true => Seeker {
                    X: seeker.X * 20.0,
                    ..seeker
                },
                false => seeker,
            };
            let facets = (first, second, shared);
            let (coarse, left, range) = jump(&master, &seeker, facets, (from, to));
            partly += usize::from(coarse > 0.0);
            hidden += usize::from(range[0] == 0.0);
            whole += usize::from(range[1] == 1.0);
            assert!(left < 1e-6, "path {path}: {coarse} {left}");
        }
        // the paths are such that some points come into sight, and some go out of it
        let least = paths / 8;
        assert!(partly > least && hidden > least && whole > least);
    }

    /// Feet that move from facet to facet, and points that move through the surface, never come into sight at once.
    #[test]
    fn shares_are_continuous_in_the_plane() {
        let ring = annulus(&[0.5, 1.0], 14, Diagonals::Rising).expect("mesh");
        shares_are_continuous(&ring, "outer", 400);
    }

    #[test]
    fn shares_are_continuous_in_space() {
        let ball = sphere(1.0, 2).expect("mesh");
        shares_are_continuous(&ball, "surface", 60);
    }

    /// The way to the top of a bulging facet crosses the straight line between the facet's ends, which is no facet of its own.
    #[test]
    fn a_facet_does_not_hide_itself() {
        let x = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.2]].map(Vector::<2>::from);
        let facets: [&[usize]; 1] = [&[1, 0, 2]];
        let surface = Surface::new(0, Order::Quadratic, facets.into_iter(), &x);
        let master = Master::new(&Arc::new(surface), &x, Projection::Closest);
        let below = Vector::<2>::new(0.5, -0.1);
        let p = FootPoint::on(master.moving(), (0, Vector::<2>::new(0.5, 0.5)), &below);
        assert!((p.gap + 0.3).abs() < 1e-12, "{p:?}");
        let seeker = Seeker {
            x: below,
            facing: Vector::<2>::new(0.0, -1.0),
            reach: f64::INFINITY,
            X: Vector::<2>::new(0.5, 100.0),
            N: Vector::<2>::new(0.0, -1.0),
            facet_size: 1.0,
            own: None,
            reaches_beyond: false,
        };
        assert_eq!(master.seen(&p, &seeker), 1.0);
    }
}
