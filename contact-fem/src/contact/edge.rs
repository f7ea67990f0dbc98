//! Sharp edges that cross in space.
//!
//! Where two sharp edges cross, a node of neither body need be near the other, and a weak gap is a mean over facets that are apart nearly everywhere.
//! A pair of straight edges that cross therefore has a row of its own, as a sharp corner has (`corner.rs`):
//!
//! c = g + h/20 + h (1/s − 1) + f ≥ 0,  g = (x_a − x_b)·n,
//!
//! with the points x_a and x_b at which the lines through both edges are closest, and their common normal n from b to a. The length h is half of the least height of
//! the four facets over the edges, or half of the least length of the facets around the ends if that is smaller. Rows of nodes have the whole length, and their feet jump at
//! edges: so edges hold first. Beyond the end of an edge, f is how far the next edge falls below its line.
//!
//! The share s falls to 0 at the ends of edges, towards the search radius, where edges become parallel, where n leaves the directions between the normals of the two
//! facets of an edge, and where one edge is two heights beneath the other. Along quadratic facets, an edge is two chords. The paper has no such rows; they stand beside its equation (5).
//!
//! The distance of two lines is stationary at these points. So ∇g is n times the barycentric coordinates of the points at the four ends, and forces along it have a
//! potential. Newton's method has ∇g and ∇²g; it leaves out how s and f vary.

use std::collections::BTreeMap;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::corner::{SHARP, slack};
use super::moving::Moving;
use super::search::near_share;
use super::seen::falling;
use super::surface::Surface;
use crate::element::facet_edge;
use crate::tensor::{Matrix, Vector};

/// Where a next edge goes on, an edge counts beyond its end: in full up to the first share of the next edge's length, and no more from the second share on.
const BEYOND: [f64; 2] = [0.2, 0.5];
/// Where no edge goes on, an edge loses its share before its end, over this part of its length, or of its height if that is shorter.
const END: f64 = 0.25;
/// The sine of the angle between two edges up to which they are parallel and have no row, and from which on they count in full.
const PARALLEL: [f64; 2] = [0.1, 0.3];
/// The sine of the angle by which n leaves the directions between the normals of an edge's two facets, up to which the edge counts in full, and from which on it has no row.
const TURNED: [f64; 2] = [0.25, 0.6];
/// The depth, in heights, up to which edges count in full, and from which on they do not.
const DEEP: [f64; 2] = [1.0, 2.0];

/// A straight piece of a sharp convex edge, by nodes as positions in [`Surface::nodes`].
#[derive(Clone, Debug)]
pub struct SharpEdge {
    ends: [usize; 2],
    /// Of the two facets at the edge, the corners opposite it.
    wings: [usize; 2],
    /// Where the piece ends that goes on from each end.
    next: [Option<usize>; 2],
    /// The least height of the two facets over the edge in the reference configuration, or the least length of the facets around its ends if that is smaller (UL).
    height: f64,
}

/// A facet at an edge.
struct Side {
    facet: usize,
    /// The nodes along the edge, and the corner opposite it.
    along: Vec<usize>,
    opposite: usize,
}

/// The facets at each edge of a surface in space, by the edge's ends.
fn sides<const D: usize>(surface: &Surface<D>) -> BTreeMap<[usize; 2], Vec<Side>> {
    let mut sides: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for (facet, nodes) in surface.facets().enumerate() {
        for e in 0..D {
            let [i, j] = facet_edge::<D>(e);
            let [a, b] = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
            let along = [a].into_iter().chain(nodes.get(D + e).copied()).chain([b]);
            sides.entry([a, b]).or_default().push(Side {
                facet,
                along: along.collect(),
                opposite: nodes[D - i - j],
            });
        }
    }
    sides
}

/// The sharp convex edges between facets of a surface in space; none in the plane, where facets meet in corners.
pub fn sharp_edges<const D: usize>(surface: &Surface<D>) -> Vec<SharpEdge> {
    if D != 3 {
        return Vec::new();
    }
    let (X, sizes) = (surface.reference_nodes(), surface.node_sizes());
    let normal = |side: &Side| {
        let [o, p, q] = [0, 1, 2].map(|k| X[surface.facet(side.facet)[k]]);
        (p - o).cross(&(q - o)).normalize()
    };
    let mut edges = Vec::new();
    for ([a, b], sides) in &sides(surface) {
        let [first, second] = &sides[..] else {
            continue; // the end of the surface, or no surface
        };
        let [n, m] = [first, second].map(normal);
        let is_convex = n.dot(&(X[second.opposite] - X[*a])) < 0.0;
        if !(n.dot(&m) < SHARP && is_convex) {
            continue;
        }
        let e = (X[*b] - X[*a]).normalize();
        let wings = [first.opposite, second.opposite];
        let heights = wings.map(|w| across(&(X[w] - X[*a]), &e).norm());
        edges.extend(first.along.windows(2).map(|ends| {
            SharpEdge {
                ends: [ends[0], ends[1]],
                wings,
                next: [None; 2],
                height: [heights[0], heights[1], sizes[ends[0]], sizes[ends[1]]]
                    .into_iter()
                    .fold(f64::INFINITY, f64::min),
            }
        }));
    }
    let nexts = nexts(&edges, X);
    for (edge, next) in edges.iter_mut().zip(nexts) {
        edge.next = next;
    }
    edges
}

/// [`SharpEdge::next`] of all edges, for positions `X` of their nodes: an edge goes on where exactly one other does not turn by more than facets of a curve do.
fn nexts<const D: usize>(edges: &[SharpEdge], X: &[Vector<D>]) -> Vec<[Option<usize>; 2]> {
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, edge) in edges.iter().enumerate() {
        let ends = edge.ends.iter();
        ends.for_each(|&a| at.entry(a).or_default().push(k));
    }
    let other_end = |k: usize, a: usize| edges[k].ends[usize::from(edges[k].ends[0] == a)];
    let from = |k: usize, a: usize| (X[other_end(k, a)] - X[a]).normalize();
    let next = |(k, edge): (usize, &SharpEdge)| {
        edge.ends.map(|a| {
            let others = at[&a].iter().filter(|other| **other != k);
            let mut on = others.filter(|other| from(**other, a).dot(&from(k, a)) < -SHARP);
            match (on.next(), on.next()) {
                (Some(only), None) => Some(other_end(*only, a)),
                _ => None,
            }
        })
    };
    edges.iter().enumerate().map(next).collect()
}

/// Two edges that cross, as a row.
#[derive(Clone, Debug)]
pub struct Crossing<const D: usize> {
    /// The row's [`RowKey::node`](contact_core::gaps::RowKey::node).
    name: usize,
    /// The scene numbers of the ends of both edges, and what they weigh in x_a − x_b.
    nodes: [usize; 4],
    shares: [f64; 4],
    normal: Vector<D>,
    gap: f64,
    /// From the first to the second end of each edge (UL).
    edges: [Vector<D>; 2],
    /// Γ⁻¹, the inverse of [`Crossing::edges`]' Gram matrix (1/UL²).
    inverse: Matrix<2>,
    /// What is added to the gap (UL).
    slack: f64,
    /// The square of the least height (UL²).
    weight: f64,
}

impl<const D: usize> Crossing<D> {
    /// The row's name.
    pub fn name(&self) -> usize {
        self.name
    }

    /// What is added to its gap (UL).
    pub fn slack(&self) -> f64 {
        self.slack
    }

    /// The area that it stands for (UL²).
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// ∇g, as (scene node, coefficient). g = Σ coefficient · x.
    pub fn gradient(&self) -> impl Iterator<Item = (usize, Vector<D>)> + '_ {
        let nodes = self.nodes.iter().zip(&self.shares);
        nodes.map(|(a, share)| (*a, self.normal * *share))
    }

    /// ∇²g by two of its nodes, as (scene node, scene node, block) (1/UL). With q = n·δe and w = e·δ(x_a − x_b), points held, for both
    /// edges e, and their Gram matrix Γ,
    ///
    /// δ²g = −2 q·Γ⁻¹ w − g q·Γ⁻¹ q.
    pub fn hessian(&self) -> impl Iterator<Item = (usize, usize, Matrix<D>)> + '_ {
        // n·δe_k = ± n·δx of an end, and e_k·δ(x_a − x_b) = share e_k·δx
        let of_edge = |node: usize, k: usize| match node {
            _ if node / 2 != k => 0.0,
            _ if node % 2 == 0 => -1.0,
            _ => 1.0,
        };
        let block = move |i: usize, j: usize| {
            let mut sum = Matrix::<D>::zeros();
            for k in 0..2 {
                for l in 0..2 {
                    let c = self.inverse[(k, l)];
                    let (q_i, q_j) = (of_edge(i, k), of_edge(j, l));
                    let e = &self.edges;
                    sum -= self.normal * e[l].transpose() * (c * q_i * self.shares[j]);
                    sum -= e[k] * self.normal.transpose() * (c * self.shares[i] * q_j);
                    sum -= self.normal * self.normal.transpose() * (c * self.gap * q_i * q_j);
                }
            }
            sum
        };
        (0..4).flat_map(move |i| (0..4).map(move |j| (self.nodes[i], self.nodes[j], block(i, j))))
    }
}

/// The edges of two surfaces that cross within `reach` (UL). Rows are named after the scene's nodes, whose number is `names`, and after as many corners as the first surface has nodes.
pub fn crossings<const D: usize>(
    bodies: [&Moving<D>; 2],
    edges: [&[SharpEdge]; 2],
    reach: f64,
    names: usize,
) -> Vec<Crossing<D>> {
    if D != 3 || edges.iter().any(|own| own.is_empty()) {
        return Vec::new();
    }
    let first = names + bodies[0].surface().nodes().len();
    let boxed = |edge: &SharpEdge, body: &Moving<D>, margin: f64| {
        let ends = edge.ends.map(|a| body.positions()[a]);
        let next = edge
            .next
            .iter()
            .zip(ends)
            .map(|(next, end)| next.map_or(0.0, |a| (body.positions()[a] - end).norm()));
        let margin = Vector::repeat(margin + next.fold(0.0, f64::max));
        let (low, high) = (
            ends[0].inf(&ends[1]) - margin,
            ends[0].sup(&ends[1]) + margin,
        );
        AABB::from_corners(low.into(), high.into())
    };
    let leaf = |(k, edge): (usize, &SharpEdge)| {
        let around = boxed(edge, bodies[1], 0.0);
        GeomWithData::new(Rectangle::<[f64; D]>::from_aabb(around), k)
    };
    let tree = RTree::bulk_load(edges[1].iter().enumerate().map(leaf).collect());
    let mut found = Vec::new();
    for (a, edge) in edges[0].iter().enumerate() {
        let around = boxed(edge, bodies[0], reach.max(DEEP[1] * edge.height));
        let near = tree.locate_in_envelope_intersecting(around);
        let mut near: Vec<usize> = near.map(|leaf| leaf.data).collect();
        near.sort_unstable();
        found.extend(near.into_iter().filter_map(|b| {
            let name = first + a * edges[1].len() + b;
            crossing(bodies, [edge, &edges[1][b]], reach, name)
        }));
    }
    found
}

/// Two edges as a row, if they cross.
fn crossing<const D: usize>(
    bodies: [&Moving<D>; 2],
    edges: [&SharpEdge; 2],
    reach: f64,
    name: usize,
) -> Option<Crossing<D>> {
    let x = |k: usize, a: usize| bodies[k].positions()[a];
    let e = [0, 1].map(|k| x(k, edges[k].ends[1]) - x(k, edges[k].ends[0]));
    let lengths = e.map(|e| e.norm());
    let across = e[0].cross(&e[1]);
    let sine = across.norm() / (lengths[0] * lengths[1]);
    if !(sine > PARALLEL[0]) {
        return None;
    }
    let n = across / across.norm();
    // outward: away from the facets of the second edge, and into those of the first
    let inwards = |k: usize| {
        edges[k].wings.map(|w| {
            self::across(&(x(k, w) - x(k, edges[k].ends[0])), &(e[k] / lengths[k])).normalize()
        })
    };
    let [of_first, of_second] = [0, 1].map(inwards);
    let into = (of_first[0] + of_first[1]) - (of_second[0] + of_second[1]);
    let n = if n.dot(&into) < 0.0 { -n } else { n };
    let turned = of_first.map(|wing| -n.dot(&wing));
    let turned = turned.into_iter().chain(of_second.map(|wing| n.dot(&wing)));
    let turned = turned.fold(-1.0, f64::max);
    // (x_a − x_b)·e = 0 for both edges e, with x_a − x_b = apart + s e_a − t e_b
    let gram = Matrix::<2>::from_fn(|k, l| e[k].dot(&e[l]));
    let inverse = gram.try_inverse()?;
    let apart = x(0, edges[0].ends[0]) - x(1, edges[1].ends[0]);
    let along = -inverse * Vector::<2>::from_fn(|k, _| apart.dot(&e[k]));
    let (s, t) = (along[0], -along[1]);
    let gap = apart.dot(&n);
    let height = edges[0].height.min(edges[1].height);
    let share = (1.0 - falling(sine, PARALLEL))
        * falling(turned, TURNED)
        * falling(-gap / height, DEEP)
        * near_share(gap, reach);
    let ends = [
        End::of(s, (bodies[0], edges[0]), &-n),
        End::of(t, (bodies[1], edges[1]), &n),
    ];
    let share = share * ends[0].share * ends[1].share;
    let nodes = |k: usize| edges[k].ends.map(|a| bodies[k].surface().nodes()[a]);
    let [[a0, a1], [b0, b1]] = [nodes(0), nodes(1)];
    Some(Crossing {
        name,
        nodes: [a0, a1, b0, b1],
        shares: [1.0 - s, s, t - 1.0, -t],
        normal: n,
        gap,
        edges: e,
        inverse,
        slack: slack(0.5 * height, share)? + ends[0].falls + ends[1].falls,
        weight: height * height,
    })
}

/// What the end of an edge does to a row, by the place of its point along the edge.
struct End {
    share: f64,
    /// How far the edge that goes on falls below this one there (UL).
    falls: f64,
}

impl End {
    /// At `s` along an edge of a body: 0 is its first end, 1 the second. `outward` is the normal that points away from the body.
    ///
    /// Beyond a convex end, the row of an edge is the next edge's, since f is added to its gap. Beyond a concave end, it is inactive: the next edge is nearer to the other body.
    /// So the rows of both edges hold bodies that meet at the common node of the edges.
    fn of<const D: usize>(
        s: f64,
        (body, edge): (&Moving<D>, &SharpEdge),
        outward: &Vector<D>,
    ) -> Self {
        let x = |a: usize| body.positions()[a];
        let length = (x(edge.ends[1]) - x(edge.ends[0])).norm();
        let (k, inside) = if s < 0.5 { (0, s) } else { (1, 1.0 - s) };
        let Some(next) = edge.next[k] else {
            let fades = END * (edge.height / length).min(1.0);
            return End {
                share: 1.0 - falling(inside, [0.0, fades]),
                falls: 0.0,
            };
        };
        let way = x(next) - x(edge.ends[k]);
        let beyond = (-inside * length).max(0.0) / way.norm();
        End {
            share: falling(beyond, BEYOND),
            falls: (-way.dot(outward)).max(0.0) * beyond,
        }
    }
}

/// What of a vector is across a unit vector.
fn across<const D: usize>(v: &Vector<D>, e: &Vector<D>) -> Vector<D> {
    v - e * v.dot(e)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::generators::cuboid;

    type Vec3 = Vector<3>;

    /// The length of a triangle that is half a square of 1, less than its height over its edges.
    const SIZE: f64 = std::f64::consts::FRAC_1_SQRT_2;
    /// What bars of such facets may dig in.
    const LEAST: f64 = 0.5 * SIZE / 20.0;

    /// A square bar along x with a ridge at the height `z`, on top or below, turned about the ridge's middle by `turn` in the plane and tilted
    /// by `tilt` about the ridge; and moved by `aside` along itself.
    fn bar(
        z: f64,
        is_below: bool,
        (turn, tilt, aside): (f64, f64, f64),
        quadratic: bool,
    ) -> Moving<3> {
        let half = 0.5_f64.sqrt();
        let placed = |X: &Vec3| {
            // the square's corner y = z = ½ becomes the ridge
            let (y, up) = ((X[1] - X[2]) * half, (X[1] + X[2]) * half - half);
            let up = if is_below { -up } else { up };
            let (y, up) = (
                y * tilt.cos() - up * tilt.sin(),
                y * tilt.sin() + up * tilt.cos(),
            );
            let along = X[0] + aside;
            Vec3::new(
                along * turn.cos() - y * turn.sin(),
                along * turn.sin() + y * turn.cos(),
                z + up,
            )
        };
        let mesh = cuboid([-1.5, -0.5, -0.5], [3.0, 1.0, 1.0], [3, 1, 1]).expect("a mesh");
        let mesh = if quadratic { mesh.quadratic() } else { mesh };
        let X: Vec<Vec3> = mesh.nodes().iter().map(placed).collect();
        let turned = |mesh: &Mesh<3>| -> Vec<Vec<usize>> {
            // in a mirror image, the nodes of a facet go around it in the opposite direction
            let swap = |nodes: &[usize]| match (is_below, nodes) {
                (true, [a, b, c]) => vec![*a, *c, *b],
                (true, [a, b, c, ab, bc, ca]) => vec![*a, *c, *b, *ca, *bc, *ab],
                _ => nodes.to_vec(),
            };
            mesh.exterior().map(swap).collect()
        };
        let facets = turned(&mesh);
        let facets = facets.iter().map(Vec::as_slice);
        Moving::new(&Arc::new(Surface::new(0, mesh.order(), facets, &X)), &X)
    }

    /// The edges that cross, and count in full.
    fn found(bodies: [&Moving<3>; 2]) -> Vec<Crossing<3>> {
        let edges = bodies.map(|body| sharp_edges(body.surface()));
        let rows = crossings(bodies, [&edges[0], &edges[1]], 0.3, 1000).into_iter();
        rows.filter(|row| row.slack < LEAST + 1e-3).collect()
    }

    /// A bar of three by one by one cells has twelve edges, in 20 pieces. The edges along it go on from cell to cell.
    #[test]
    fn edges_of_a_bar() {
        for (quadratic, pieces) in [(false, 1), (true, 2)] {
            let edges = sharp_edges(bar(0.0, false, (0.0, 0.0, 0.0), quadratic).surface());
            assert_eq!(edges.len(), 20 * pieces);
            let on = edges.iter().flat_map(|edge| edge.next).flatten();
            assert_eq!(on.count(), 2 * (4 * 2 + 20 * (pieces - 1)));
            assert!(edges.iter().all(|edge| (edge.height - SIZE).abs() < 1e-12));
        }
    }

    /// Ridges at heights that differ by g, in the middle of both bars: rows with a vertical normal, at a gap and at an overlap, and
    /// whichever body is first. Its forces have no resultant and no moment.
    #[test]
    fn ridges_that_cross() {
        for g in [0.2, 0.0, -0.3] {
            for turn in [1.57, 0.6, -2.0] {
                let lower = bar(0.0, false, (0.3, 0.05, 0.1), false);
                let upper = bar(g, true, (0.3 + turn, -0.05, -0.2), false);
                let rows = [found([&lower, &upper]), found([&upper, &lower])];
                for (k, rows) in rows.iter().enumerate() {
                    let down = if k == 0 { -1.0 } else { 1.0 };
                    let bodies = if k == 0 {
                        [&lower, &upper]
                    } else {
                        [&upper, &lower]
                    };
                    assert!(!rows.is_empty());
                    for row in rows {
                        assert!((row.normal - Vec3::new(0.0, 0.0, down)).norm() < 1e-12);
                        assert!((row.gap - g).abs() < 1e-12, "{} {g}", row.gap);
                        assert!((row.slack - LEAST).abs() < 1e-12, "{}", row.slack);
                        assert!(row.gradient().map(|(_, n)| n).sum::<Vec3>().norm() < 1e-12);
                        let place = |(i, a): (usize, usize)| bodies[i / 2].positions()[a];
                        let moment = row.gradient().enumerate();
                        let moment: Vec3 = moment.map(|(i, (a, n))| place((i, a)).cross(&n)).sum();
                        assert!(moment.norm() < 1e-12, "{moment}");
                    }
                }
            }
        }
    }

    /// Parallel ridges have no row, nor has a ridge beyond the end of another ridge, one that looks the same way, and one out of reach.
    #[test]
    fn edges_that_have_no_row() {
        let lower = bar(0.0, false, (0.0, 0.0, 0.0), false);
        let none = |upper: Moving<3>| found([&lower, &upper]).is_empty();
        assert!(none(bar(0.1, true, (0.05, 0.0, 0.0), false)), "parallel");
        assert!(
            none(bar(0.1, true, (1.5, 0.0, 1.6), false)),
            "beyond its end"
        );
        // of ridges that look the same way none has a row, but the lower ridge of the upper bar has
        let rows = found([&lower, &bar(1.6, false, (1.5, 0.0, 0.0), false)]);
        assert!(!rows.is_empty());
        let is_lower = |row: &Crossing<3>| (row.gap - (1.6 - 2.0_f64.sqrt())).abs() < 1e-12;
        assert!(rows.iter().all(is_lower));
        assert!(none(bar(1.2, true, (1.5, 0.0, 0.0), false)), "out of reach");
    }

    /// First and second derivatives against differences of the distance of two lines.
    #[test]
    fn derivatives_of_the_distance() {
        // bent, so that n is along no axis
        let bend = |x: &Vec3| x + Vec3::new(0.1 * x[1] * x[0], 0.0, 0.3 * x[0] + 0.1 * x[1] * x[1]);
        let bent = |body: Moving<3>| {
            let x: Vec<Vec3> = body.positions().iter().map(bend).collect();
            Moving::new(&Arc::new(body.surface().clone()), &x)
        };
        let lower = bent(bar(0.0, false, (0.3, 0.05, 0.1), false));
        let upper = bent(bar(-0.2, true, (1.4, -0.05, -0.2), false));
        let rows = found([&lower, &upper]);
        let row = &rows[0];
        let bodies = [&lower, &lower, &upper, &upper];
        let x: [Vec3; 4] = std::array::from_fn(|i| bodies[i].positions()[row.nodes[i]]);
        let along =
            |k: usize| Vec3::new((k as f64).sin(), (2.0 * k as f64).cos(), (k as f64).cos());
        let ways: [Vec3; 4] = std::array::from_fn(|i| along(i + 1));
        // g of ends that have moved by h along their ways
        let gap = |h: f64| {
            let x: [Vec3; 4] = std::array::from_fn(|i| x[i] + ways[i] * h);
            let across = (x[1] - x[0]).cross(&(x[3] - x[2])).normalize();
            (x[0] - x[2]).dot(&across) * across.dot(&row.normal).signum()
        };
        assert!(
            (row.gap - gap(0.0)).abs() < 1e-12,
            "{} {}",
            row.gap,
            gap(0.0)
        );
        let slope: f64 = row
            .gradient()
            .zip(&ways)
            .map(|((_, c), way)| c.dot(way))
            .sum();
        let h = 1e-4;
        let differences = (gap(h) - gap(-h)) / (2.0 * h);
        assert!((slope - differences).abs() < 1e-7, "{slope} {differences}");
        // blocks come row by row
        let blocks = row.hessian().enumerate();
        let curvature: f64 = blocks
            .map(|(k, (.., H))| ways[k / 4].dot(&(H * ways[k % 4])))
            .sum();
        let differences = (gap(h) - 2.0 * gap(0.0) + gap(-h)) / (h * h);
        assert!(
            (curvature - differences).abs() < 1e-5,
            "{curvature} {differences}"
        );
    }
}
