//! Detection of nodes that a load step has carried through a body.
//!
//! If a step is longer than a body is thick, nodes may end up beyond the body, and their end
//! positions alone do not show it. Their paths do: all nodes are assumed to move from one state to
//! the next on straight lines at constant velocity. A node has passed through a body if it leaves
//! the body through a facet whose side is opposite to the one where it entered. A node that leaves
//! on the side of its entry, as when it slides over facets and corners, has not.

use std::sync::Arc;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::normals;
use super::obstacle::Placed;
use super::projection::{Projection, along_normal, closest, interpolate};
use super::search::{Master, Seeker};
use super::surface::Surface;
use crate::program::Pose;
use crate::tensor::{Vector, facet_normal};

/// The positions of all scene nodes (UL) in two successive states.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, const D: usize> {
    /// The positions at the start.
    pub before: &'a [Vector<D>],
    /// The positions at the end.
    pub after: &'a [Vector<D>],
}

/// The intersection of a node's path with a facet.
struct Crossing<const D: usize> {
    /// Its time, in (0, 1].
    time: f64,
    /// Whether the node leaves the body: it comes from behind the facet.
    leaves: bool,
    /// The facet's normal at this time.
    normal: Vector<D>,
    /// The displacement of the node relative to the facet (UL).
    way: f64,
}

impl<const D: usize> Motion<'_, D> {
    /// The smallest depth of a passage, half-way through a body, as a share of the facet size. A
    /// shallower node has only slid along the surface: weak constraints allow such penetrations.
    const GRAZED: f64 = 0.01;
    /// The cosine of normals that are those of the two sides of a thin obstacle.
    const OPPOSITE: f64 = -0.5;
    /// The number of time intervals in which sign changes of a node's height over a facet are sought.
    /// The height is a polynomial of degree D in time, so that few intervals suffice.
    const INTERVALS: usize = 8;
    /// The number of bisections for the time of a crossing.
    const BISECTIONS: usize = 40;
    /// The largest number of strides in which a node's way is walked where an obstacle is near.
    const STRIDES: f64 = 4096.0;
    /// The extension of facets beyond their sides, in barycentric coordinates: no node passes between
    /// two neighbours.
    const SEAM: f64 = 1e-6;

    /// The position of a node at `time` between start (0) and end (1).
    fn at(&self, node: usize, time: f64) -> Vector<D> {
        self.before[node] * (1.0 - time) + self.after[node] * time
    }

    /// The largest displacement relative to `master` (UL) of the nodes of `slave` that pass through
    /// it; `None` if no node does.
    pub fn through(&self, slave: &Surface<D>, master: &Arc<Surface<D>>) -> Option<f64> {
        let tree = RTree::bulk_load(self.swept_facets(master));
        let ways = slave.nodes().iter().enumerate().map(|(k, &node)| {
            let path = AABB::from_corners(self.before[node].into(), self.after[node].into());
            let near = tree.locate_in_envelope_intersecting(path);
            let facets = near.map(|facet| self.corners(master, facet.data));
            let others = facets.filter(|corners| !corners.contains(&node));
            let crossings = others.filter_map(|corners| self.crossing(node, &corners));
            (k, crossings.collect::<Vec<_>>())
        });
        let leaving = ways.filter(|(_, crossings)| crossings.iter().any(|c| c.leaves));
        let leaving: Vec<_> = leaving.collect();
        if leaving.is_empty() {
            return None;
        }
        let before = Master::new(master, self.before, Projection::Closest);
        let normals = normals::averaged(slave, &slave.gather(self.before));
        let through = leaving.into_iter().filter_map(|(k, mut crossings)| {
            crossings.sort_by(|a, b| a.time.total_cmp(&b.time));
            let mut came = self.side(slave, k, normals[k], &before).map(|n| (0.0, n));
            for crossing in crossings {
                if !crossing.leaves {
                    came = Some((crossing.time, crossing.normal));
                } else if came.is_some_and(|(_, n)| n.dot(&crossing.normal) < 0.0) {
                    let since = came.map_or(0.0, |(time, _)| time);
                    let middle = 0.5 * (since + crossing.time);
                    let depth = self.distance(slave.nodes()[k], master, middle);
                    if depth > Self::GRAZED * master.facet_size() {
                        return Some(crossing.way);
                    }
                }
            }
            None
        });
        through.reduce(f64::max)
    }

    /// The largest way (UL) of the nodes of `slave` that pass through an obstacle: that come out of it on another side than
    /// they went in. Distances tell how far a node can go before it meets the obstacle, so that none is missed. The ways are
    /// those as the obstacle sees them, which has moved from `from` to where it is.
    pub(crate) fn through_obstacle(
        &self,
        slave: &Surface<D>,
        obstacle: &Placed<D>,
        from: &Pose<D>,
    ) -> Option<f64> {
        let least = Self::GRAZED * slave.facet_size();
        let way_through = |&node: &usize| {
            // where the obstacle is now, the node came from here
            let before = obstacle.pose().place(&from.back(&self.before[node]));
            let way = (self.after[node] - before).norm();
            let stride = least.max(way / Self::STRIDES);
            if !(way > 0.0 && way.is_finite()) {
                return None;
            }
            let (mut time, mut came, mut deepest) = (0.0, None, 0.0_f64);
            // whether the last stride was longer than to the obstacle, and may have gone through
            let mut is_blind = false;
            loop {
                let x = before * (1.0 - time) + self.after[node] * time;
                let distance = obstacle.distance(&x);
                if distance > 0.0 {
                    let n = obstacle.normal(&x);
                    let turn = came.map_or(1.0, |from: Vector<D>| from.dot(&n));
                    // a thin obstacle is not deep
                    let is_inside = is_blind || deepest > 0.0;
                    if turn < 0.0 && deepest > least || turn < Self::OPPOSITE && is_inside {
                        return Some(way);
                    }
                    (came, deepest) = (Some(n), 0.0);
                } else {
                    // a node that starts inside came from where it is nearest
                    let from = *came.get_or_insert_with(|| obstacle.normal(&x));
                    deepest = deepest.max(-distance);
                    // it ends where contact would push it out on the other side
                    if time >= 1.0 && from.dot(&obstacle.normal(&x)) < Self::OPPOSITE {
                        return Some(way);
                    }
                }
                if time >= 1.0 {
                    return None;
                }
                is_blind = distance.abs() < stride;
                time = (time + distance.abs().max(stride) / way).min(1.0);
            }
        };
        let ways = slave.nodes().iter().filter_map(way_through);
        ways.reduce(f64::max)
    }

    /// The normal of `master` at the point that the slave's k-th node faces at the start.
    fn side(
        &self,
        slave: &Surface<D>,
        k: usize,
        facing: Vector<D>,
        master: &Master<D>,
    ) -> Option<Vector<D>> {
        let seeker = Seeker {
            x: self.before[slave.nodes()[k]],
            facing,
            reach: f64::INFINITY,
            X: slave.reference_nodes()[k],
            N: slave.reference_normals()[k],
            facet_size: slave.facet_size(),
            own: None,
            reaches_beyond: false,
        };
        let same_body = slave.body() == master.surface().body();
        let found = if same_body {
            None
        } else {
            master.find(&seeker)
        };
        found.map(|p| p.normal)
    }

    /// The distance of a node from the surface at `time` (UL).
    fn distance(&self, node: usize, surface: &Surface<D>, time: f64) -> f64 {
        let x = self.at(node, time);
        let facets = (0..surface.facets().len()).map(|facet| self.corners(surface, facet));
        let distances = facets.map(|corners| {
            let corners = corners.map(|a| self.at(a, time));
            (x - interpolate(&closest(&x, &corners), &corners)).norm()
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The scene nodes at the corners of a facet.
    fn corners(&self, surface: &Surface<D>, facet: usize) -> [usize; D] {
        std::array::from_fn(|k| surface.nodes()[surface.facet(facet)[k]])
    }

    /// The boxes that contain the facets from start to end.
    fn swept_facets(&self, surface: &Surface<D>) -> Vec<GeomWithData<Rectangle<[f64; D]>, usize>> {
        let swept = |facet: usize| {
            let nodes = self.corners(surface, facet);
            let ends = nodes.map(|a| [self.before[a], self.after[a]]);
            let low = ends.as_flattened().iter().fold(ends[0][0], |m, x| m.inf(x));
            let high = ends.as_flattened().iter().fold(ends[0][0], |m, x| m.sup(x));
            GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), facet)
        };
        (0..surface.facets().len()).map(swept).collect()
    }

    /// The first intersection of a node's path with the facet that has these corners, if there is
    /// one.
    fn crossing(&self, node: usize, corners: &[usize; D]) -> Option<Crossing<D>> {
        let facet = |time: f64| corners.map(|a| self.at(a, time));
        let height = |time: f64| {
            let corners = facet(time);
            facet_normal(&corners).dot(&(self.at(node, time) - corners[0]))
        };
        (0..Self::INTERVALS).find_map(|k| {
            let [mut from, mut to] = [k, k + 1].map(|k| k as f64 / Self::INTERVALS as f64);
            let [start, end] = [height(from), height(to)];
            if start * end >= 0.0 && !(end == 0.0 && start != 0.0) {
                return None;
            }
            for _ in 0..Self::BISECTIONS {
                let middle = 0.5 * (from + to);
                match height(middle) * start > 0.0 {
                    true => from = middle,
                    false => to = middle,
                }
            }
            let corners_then = facet(to);
            let lambda = along_normal(&self.at(node, to), &corners_then);
            lambda.iter().all(|l| *l >= -Self::SEAM).then(|| {
                let moved = |a: usize| self.after[a] - self.before[a];
                let carried: Vector<D> = corners
                    .iter()
                    .zip(&lambda)
                    .map(|(&a, l)| moved(a) * *l)
                    .sum();
                Crossing {
                    time: to,
                    leaves: start < 0.0,
                    normal: facet_normal(&corners_then),
                    way: (moved(node) - carried).norm(),
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Obstacle;
    use crate::element::Order;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};

    /// Two bodies' surfaces, all around, and the positions of all nodes.
    struct Pair<const D: usize> {
        surfaces: [Arc<Surface<D>>; 2],
        X: Vec<Vector<D>>,
        first: usize,
    }

    impl<const D: usize> Pair<D> {
        fn new(meshes: [Mesh<D>; 2]) -> Self {
            let first = meshes[0].nodes().len();
            let X: Vec<_> = meshes
                .iter()
                .flat_map(|mesh| mesh.nodes())
                .copied()
                .collect();
            let surface = |body: usize| {
                let shift = |nodes: &[usize]| nodes.iter().map(|a| a + body * first).collect();
                let facets: Vec<Vec<usize>> = meshes[body].exterior().map(shift).collect();
                Surface::new(body, Order::Linear, facets.iter().map(Vec::as_slice), &X)
            };
            let surfaces = [surface(0), surface(1)].map(Arc::new);
            Pair { surfaces, X, first }
        }

        /// The displacement by which the second body passes through the first one when it moves
        /// from `from` to `to`: for its own nodes and for those of the first.
        fn through(&self, from: [f64; D], to: [f64; D]) -> [Option<f64>; 2] {
            let moved = |by: [f64; D]| -> Vec<Vector<D>> {
                let mut x = self.X.clone();
                x[self.first..]
                    .iter_mut()
                    .for_each(|x| *x += Vector::from(by));
                x
            };
            let motion = Motion {
                before: &moved(from),
                after: &moved(to),
            };
            let [first, second] = &self.surfaces;
            [motion.through(second, first), motion.through(first, second)]
        }
    }

    /// The coarse punch passes through a plate of thickness 0.1: nodes of the punch and of the
    /// plate detect it. Motion beside the plate, into it, around its corner, or along it with a
    /// small penetration is no passage.
    #[test]
    fn through_and_not_through_in_the_plane() {
        let grid = |x: [f64; 2], y: [f64; 2], n: usize| {
            let line = |[low, high]: [f64; 2], n| linspace(low, high, n);
            rectangle(&line(x, n), &line(y, 1), Diagonals::Rising).expect("mesh")
        };
        let plate = grid([0.0, 1.0], [0.0, 0.1], 9);
        let pair = Pair::new([plate, grid([0.3, 0.7], [0.2, 0.25], 2)]);
        let [by_punch, by_plate] = pair.through([0.0; 2], [0.05, -0.5]);
        let way = 0.5f64.hypot(0.05);
        assert!((by_punch.expect("through") - way).abs() < 1e-9);
        assert!((by_plate.expect("through") - way).abs() < 1e-9);
        // back up from below the plate
        assert!(
            pair.through([0.0, -0.5], [0.0; 2])
                .iter()
                .all(Option::is_some)
        );
        for (from, to) in [
            ([0.0, 0.0], [0.0, -0.12]),       // into it
            ([0.8, 0.0], [0.8, -0.5]),        // beside it
            ([0.0, -0.1001], [0.4, -0.1001]), // on it
            ([0.1, -0.1001], [0.9, -0.1001]), // and off its end
            ([0.69, -0.1001], [0.75, -0.2]),  // around its corner
            ([0.0, -0.1001], [0.0, 0.3]),     // away
        ] {
            assert_eq!(pair.through(from, to), [None, None], "{from:?} {to:?}");
        }
    }

    #[test]
    fn through_and_not_through_in_space() {
        let plate = cuboid([0.0; 3], [1.0, 1.0, 0.1], [5, 4, 1]).expect("mesh");
        let punch = cuboid([0.31, 0.29, 0.2], [0.3, 0.4, 0.05], [2, 2, 1]).expect("mesh");
        let pair = Pair::new([plate, punch]);
        let through = pair.through([0.0; 3], [0.02, 0.01, -0.5]);
        assert!(through.iter().all(Option::is_some), "{through:?}");
        for (from, to) in [
            ([0.0, 0.0, 0.0], [0.0, 0.0, -0.12]),
            ([0.9, 0.0, 0.0], [0.9, 0.0, -0.5]),
            ([0.0, 0.0, -0.1001], [0.3, -0.2, -0.1001]),
            ([0.1, 0.1, -0.1001], [0.9, 0.8, -0.1001]),
        ] {
            assert_eq!(pair.through(from, to), [None, None], "{from:?} {to:?}");
        }
    }

    /// Plates thinner than a facet, one of which lets a stride through, one of which is hardly deep, and one that would push out nodes
    /// on its far side. Motion beside a plate, a little into it, along it and around its end is no passage.
    #[test]
    fn through_thin_obstacles() {
        let line = |n| linspace(0.0, 1.0, n);
        let mesh = rectangle(&line(4), &line(4), Diagonals::Rising).expect("a mesh");
        let facets: Vec<Vec<usize>> = mesh.exterior().map(<[usize]>::to_vec).collect();
        let X = mesh.nodes().to_vec();
        let surface = Surface::new(0, Order::Linear, facets.iter().map(Vec::as_slice), &X);
        let through = |thick: f64, from: [f64; 2], to: [f64; 2]| {
            let plate = Obstacle::cuboid([-1.0, -thick], [2.0, 0.0]).expect("a plate");
            let plate = Placed::new(&plate, 0.25);
            let moved =
                |by: [f64; 2]| -> Vec<_> { X.iter().map(|X| X + Vector::from(by)).collect() };
            let motion = Motion {
                before: &moved(from),
                after: &moved(to),
            };
            motion.through_obstacle(&surface, &plate, plate.pose())
        };
        for thick in [1e-6, 1e-3, 1e-2, 0.05] {
            for from in [0.0, 1e-9, -1e-9, 0.02] {
                for to in [-thick, -thick + 1e-9, -thick - 1e-9, -0.15, -0.3] {
                    let found = through(thick, [0.0, from], [0.0, to]);
                    let way = from - to;
                    assert!(
                        found.is_some_and(|found| (found - way).abs() < 1e-12),
                        "{thick} {from} {to}: {found:?}"
                    );
                }
            }
            for (from, to) in [
                ([0.0, 0.0], [0.0, -0.4 * thick]), // a little into it
                ([0.0, 0.0], [0.5, 0.0]),          // on it
                ([0.0, 0.0], [2.5, 0.0]),          // and off its end
                ([3.0, 0.0], [3.0, -0.5]),         // beside it
                ([0.0, 0.0], [0.0, 0.3]),          // away
            ] {
                let found = through(thick, from, to);
                assert_eq!(found, None, "{thick} {from:?} {to:?}");
            }
        }
    }

    /// A node at rest and a segment from A to A + e with A = (−0.1, 2 t − 1) and e = (1 − 2 t, 1). The node's
    /// height has the sign of (1 − 2 t)² − 0.1, which is positive at both ends, and the node is on the
    /// segment where 1 − 2 t is the root of 0.1.
    #[test]
    fn crossings_between_equal_signs_are_found() {
        let at = |t: f64| {
            let a = Vector::<2>::new(-0.1, 2.0 * t - 1.0);
            vec![Vector::zeros(), a, a + Vector::<2>::new(1.0 - 2.0 * t, 1.0)]
        };
        let (before, after) = (at(0.0), at(1.0));
        let motion = Motion {
            before: &before,
            after: &after,
        };
        let time = 0.5 * (1.0 - 0.1f64.sqrt());
        let crossing = motion.crossing(0, &[1, 2]).expect("crosses");
        assert!((crossing.time - time).abs() < 1e-9, "{}", crossing.time);
    }

    /// A node that goes through the node between two segments crosses one of them.
    #[test]
    fn nothing_passes_between_neighbours() {
        let ends = [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.1]].map(Vector::<2>::from);
        let with = |y: f64| [&ends[..], &[Vector::<2>::new(0.0, y)]].concat();
        let (before, after) = (with(1.0), with(-1.0));
        let motion = Motion {
            before: &before,
            after: &after,
        };
        let crossings = [[0, 1], [1, 2]].map(|ends| motion.crossing(3, &ends).is_some());
        assert!(crossings.contains(&true));
    }

    /// The lower side of a punch goes through a plate of height 0.1. It starts above it, or just inside, as
    /// bodies in contact do: only where it faces tells that it came from above.
    #[test]
    fn sides_that_start_in_contact_pass_through() {
        let x = [
            [-1.0, 0.1],
            [1.0, 0.1],
            [1.0, 0.0],
            [-1.0, 0.0],
            [-0.2, 0.0],
            [0.3, 0.0],
        ];
        let at = |height: f64| {
            let mut x = x.map(Vector::<2>::from).to_vec();
            x[4..].iter_mut().for_each(|x| x[1] += height);
            x
        };
        let surface = |body: usize, facets: &[[usize; 2]]| {
            let facets = facets.iter().map(|f| &f[..]);
            Arc::new(Surface::new(body, Order::Linear, facets, &at(0.2)))
        };
        // outward normals are to the right of the way from the first to the second node
        let plate = surface(0, &[[1, 0], [2, 1], [3, 2], [0, 3]]);
        let punch = surface(1, &[[4, 5]]);
        for (from, to, passes) in [
            (0.2, -0.4, true),
            (0.0999, -0.4, true),
            (0.0999, 0.2, false),
            (0.2, 0.0999, false),
        ] {
            let motion = Motion {
                before: &at(from),
                after: &at(to),
            };
            let way = motion.through(&punch, &plate);
            assert_eq!(way.is_some(), passes, "{from} {to}: {way:?}");
            let right = way.is_none_or(|way| (way - (from - to)).abs() < 1e-9);
            assert!(right, "{from} {to}: {way:?}");
        }
    }
}
