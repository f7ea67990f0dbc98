//! Closed surfaces of flat facets: the signed distance from a polygon or a polyhedron.
//!
//! The closest point is on a facet's interior, on an edge or at a corner. The normal there, the mean of the facets' around it
//! (weighted by their angles at a corner), tells the side: no other normal does that for every closed surface.

use std::collections::BTreeMap;

use super::corner;
use super::projection::interpolate;
use super::tree::FacetTree;
use crate::element::{Facet, Order};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::read::{ElementKind, MeshFile};
use crate::tensor::{Matrix, Vector, facet_normal, inverse_transpose};

/// A closed surface with its outside.
pub(super) struct ClosedSurface<const D: usize> {
    tree: FacetTree<D>,
    facets: Vec<[usize; D]>,
    nodes: Vec<Vector<D>>,
    /// The unit normals of facets and, averaged, of nodes.
    normals: Vec<Vector<D>>,
    corner_normals: Vec<Vector<D>>,
    /// In space the averaged unit normals of edges, by their nodes in ascending order.
    edge_normals: BTreeMap<[usize; 2], Vector<D>>,
    /// Below this length (UL), a way is round-off and has no direction.
    resolved: f64,
}

/// The closest point of a surface.
struct Foot<const D: usize> {
    /// The way from there (UL), and its signed length.
    way: Vector<D>,
    distance: f64,
    /// The averaged normal there.
    normal: Vector<D>,
    /// The part of the surface that it is on.
    part: Part<D>,
}

/// The part of a surface around a point of it.
enum Part<const D: usize> {
    Facet,
    /// With its unit direction.
    Edge(Vector<D>),
    Corner,
}

/// Why a surface has no inside.
fn refused<const D: usize>(what: impl Into<String>, x: &Vector<D>, remedy: &'static str) -> Error {
    Error::ObstacleSurface {
        what: what.into(),
        x: x.iter().copied().collect(),
        remedy,
    }
}

impl<const D: usize> ClosedSurface<D> {
    /// Ways shorter than this share of the surface's diagonal are round-off.
    const ROUND_OFF: f64 = 1e-12;
    /// Unit normals that differ by less than this are one.
    const FLAT: f64 = 1e-10;

    /// The surface of these facets, whose normals point outwards.
    ///
    /// # Errors
    /// Facets of nodes that there are not, without measure, with open edges, edges of more than two of them, neighbours that
    /// face different sides, and parts that are inside out or in each other.
    pub fn new(nodes: Vec<Vector<D>>, facets: Vec<[usize; D]>) -> Result<Self, Error> {
        Error::check_finite("the obstacle's point", nodes.iter().flat_map(|x| x.iter()))?;
        let normals = unit_normals(&nodes, &facets)?;
        check_closed(&nodes, &facets)?;
        let mut corner_normals = vec![Vector::zeros(); nodes.len()];
        let mut edge_normals = BTreeMap::new();
        for (facet, n) in facets.iter().zip(&normals) {
            for k in 0..D {
                corner_normals[facet[k]] += n * angle(facet.map(|a| nodes[a]), k);
                if D == 3 {
                    *edge_normals
                        .entry(edge(facet, k))
                        .or_insert(Vector::zeros()) += n;
                }
            }
        }
        let unit = |n: &mut Vector<D>| *n = n.try_normalize(0.0).unwrap_or(Vector::zeros());
        corner_normals.iter_mut().for_each(unit);
        edge_normals.values_mut().for_each(unit);
        let bounds = facets.iter().flatten().map(|&a| nodes[a]);
        let (low, high) = bounds.fold(
            (
                Vector::repeat(f64::INFINITY),
                Vector::repeat(-f64::INFINITY),
            ),
            |(low, high): (Vector<D>, Vector<D>), x| (low.inf(&x), high.sup(&x)),
        );
        let gathered = facets
            .iter()
            .map(|facet| Facet::gather(Order::Linear, facet, &nodes));
        let surface = ClosedSurface {
            tree: FacetTree::new(gathered),
            resolved: Self::ROUND_OFF * (high - low).norm(),
            facets,
            nodes,
            normals,
            corner_normals,
            edge_normals,
        };
        surface.check_crossings()?;
        surface.check_outside()?;
        Ok(surface)
    }

    /// The sharp corners that point outwards, with the unit bisectors of their outward normals.
    pub fn sharp_corners(&self) -> Vec<(Vector<D>, Vector<D>)> {
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        for (f, facet) in self.facets.iter().enumerate() {
            facet.iter().for_each(|&a| around[a].push(f));
        }
        let corners = around.iter().enumerate().filter(|(a, facets)| {
            let bisector = self.corner_normals[*a];
            let ways = facets.iter().flat_map(|&f| self.facets[f]);
            let ways = ways.map(|b| (self.nodes[b] - self.nodes[*a]).dot(&bisector));
            let turns = facets
                .iter()
                .flat_map(|f| facets.iter().map(move |g| (f, g)));
            let mut turns = turns.map(|(&f, &g)| self.normals[f].dot(&self.normals[g]));
            ways.fold(f64::NEG_INFINITY, f64::max) <= 0.0 && turns.any(|turn| turn < corner::SHARP)
        });
        corners
            .map(|(a, _)| (self.nodes[a], self.corner_normals[a]))
            .collect()
    }

    /// The boundary of a mesh. Quadratic facets become flat ones through their nodes.
    pub fn of_mesh(mesh: &Mesh<D>) -> Result<Self, Error> {
        let facets = mesh.exterior().flat_map(pieces);
        Self::new(mesh.nodes().to_vec(), facets.collect())
    }

    /// The facets of a file, or the boundary of its cells where it has some.
    pub fn of_file(file: &MeshFile) -> Result<Self, Error> {
        let dimension = |kind: ElementKind| kind.dimension();
        if file
            .elements()
            .iter()
            .any(|block| dimension(block.kind) == D)
        {
            let bodies = file.bodies::<D>()?;
            return match &bodies[..] {
                [(_, mesh)] => Self::of_mesh(mesh),
                _ => {
                    let names: Vec<&str> = bodies.iter().map(|(name, _)| name.as_str()).collect();
                    let what = format!(
                        "is the boundary of one of several bodies, {}",
                        names.join(", ")
                    );
                    let origin = Vector::<D>::zeros();
                    Err(refused(what, &origin, "write each to a file of its own"))
                }
            };
        }
        let nodes = file.vertices().iter();
        let nodes = nodes.map(|x| Vector::from_fn(|i, _| x[i])).collect();
        let blocks = file.elements().iter();
        let blocks = blocks.filter(|block| dimension(block.kind) + 1 == D);
        let facets = blocks.flat_map(|block| block.iter().flat_map(pieces));
        Self::new(nodes, facets.collect())
    }

    /// The corners of each facet.
    #[cfg(any(feature = "plot", feature = "vtk"))]
    pub fn facets(&self) -> impl Iterator<Item = [Vector<D>; D]> {
        let corners = |facet: &[usize; D]| facet.map(|a| self.nodes[a]);
        self.facets.iter().map(corners)
    }

    /// The number of facets.
    pub fn len(&self) -> usize {
        self.facets.len()
    }

    /// The signed distance of `x` (UL): negative inside.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        self.foot(x).map_or(f64::NAN, |foot| foot.distance)
    }

    /// The unit normal at `x`, the gradient of the distance where it has one.
    pub fn slope(&self, x: &Vector<D>) -> Vector<D> {
        self.foot(x)
            .map_or(Vector::zeros(), |foot| self.direction(&foot))
    }

    /// The derivative of the normal at `x` (1/UL).
    pub fn curvature(&self, x: &Vector<D>) -> Matrix<D> {
        let Some(foot) = self.foot(x) else {
            return Matrix::zeros();
        };
        let along = match foot.part {
            Part::Facet => return Matrix::zeros(),
            _ if foot.way.norm() <= self.resolved => return Matrix::zeros(),
            Part::Edge(t) => t * t.transpose(),
            Part::Corner => Matrix::zeros(),
        };
        let n = self.direction(&foot);
        (Matrix::identity() - n * n.transpose() - along) / foot.distance
    }

    fn direction(&self, foot: &Foot<D>) -> Vector<D> {
        match foot.part {
            Part::Facet => foot.normal,
            _ if foot.way.norm() <= self.resolved => foot.normal,
            _ => foot.way / foot.distance,
        }
    }

    /// The closest point to `x`; `None` where `x` is not finite.
    fn foot(&self, x: &Vector<D>) -> Option<Foot<D>> {
        let found = self.tree.nearest(x)?;
        let facet = &self.facets[found.leaf.index];
        let corners = facet.map(|a| self.nodes[a]);
        let way = x - interpolate(&found.lambda, &corners);
        let is_on = |k: usize| found.lambda[k % D] > 0.0;
        let count = (0..D).filter(|&k| is_on(k)).count();
        let of_facet = self.normals[found.leaf.index];
        let (normal, part) = match (0..D).find(|&k| is_on(k) && (count == 1 || is_on(k + 1)))? {
            _ if count == D => (of_facet, Part::Facet),
            k if count == 1 => (self.corner_normals[facet[k]], Part::Corner),
            k => {
                let direction = (corners[(k + 1) % D] - corners[k]).normalize();
                (self.edge_normals[&edge(facet, k)], Part::Edge(direction))
            }
        };
        // edges and corners within a plane are none
        let part = match (normal - of_facet).amax() < Self::FLAT {
            true => Part::Facet,
            false => part,
        };
        let distance = match part {
            Part::Facet => way.dot(&normal),
            _ => way.norm().copysign(way.dot(&normal)),
        };
        Some(Foot {
            way,
            distance,
            normal,
            part,
        })
    }

    /// How often the surface goes around `x`, 1 inside and 0 outside: the facets by which a ray leaves, less those by which it
    /// enters. Of a point of facet `on`, it is that in front of the facet. `None` if no ray keeps off the edges.
    fn winding(&self, x: &Vector<D>, on: Option<usize>) -> Option<i64> {
        /// Directions without a meaning, so that they do not run along what is drawn.
        const DIRECTIONS: [[f64; 3]; 6] = [
            [0.532, 0.317, 0.785],
            [-0.411, 0.863, 0.294],
            [0.228, -0.671, 0.705],
            [-0.743, -0.382, -0.549],
            [0.871, -0.201, -0.448],
            [-0.107, 0.479, -0.871],
        ];
        let mut directions = DIRECTIONS.iter();
        directions.find_map(|d| self.winding_along(x, on, &Vector::from_fn(|i, _| d[i])))
    }

    /// As [`ClosedSurface::winding`], by the ray in direction `d`; `None` if it meets an edge.
    fn winding_along(&self, x: &Vector<D>, on: Option<usize>, d: &Vector<D>) -> Option<i64> {
        let mut count = 0;
        for index in self.tree.on_ray(x, d) {
            let leaves = d.dot(&self.normals[index]) > 0.0;
            if Some(index) == on {
                count -= i64::from(!leaves);
                continue;
            }
            match self.meeting(index, x, d) {
                Meeting::Nowhere => {}
                Meeting::AtEdge(_) => return None,
                Meeting::After(_) if leaves => count += 1,
                Meeting::After(_) => count -= 1,
            }
        }
        Some(count)
    }

    /// Where the ray from `x` in direction `d` meets a facet.
    fn meeting(&self, index: usize, x: &Vector<D>, d: &Vector<D>) -> Meeting {
        /// How near to an edge a ray may be, in barycentric coordinates, and a point to the plane of a facet, as a share of its
        /// distance.
        const NEAR: f64 = 1e-9;
        let corners = self.facets[index].map(|a| self.nodes[a]);
        let n = &self.normals[index];
        let far = corners
            .iter()
            .fold(0.0, |far: f64, y| far.max((y - x).norm()));
        if (corners[0] - x).dot(n).abs() <= NEAR * far {
            // the ray sees the facet from the side, or leaves its plane at once
            return match d.dot(n).abs() <= NEAR * d.norm() {
                true => Meeting::AtEdge(f64::NAN),
                false => Meeting::Nowhere,
            };
        }
        // x + s d = Σ λ_k x_k with Σ λ_k = 1 and s > 0, where λ = s μ
        let arms = Matrix::<D>::from_fn(|i, k| corners[k][i] - x[i]);
        let mu = inverse_transpose(&arms).transpose() * d;
        match mu.min() / mu.abs().sum() {
            least if least.abs() <= NEAR => Meeting::AtEdge(1.0 / mu.sum()),
            least if least > 0.0 => Meeting::After(1.0 / mu.sum()),
            _ => Meeting::Nowhere,
        }
    }

    /// Checks that no edge, in the plane no segment, goes through a facet.
    fn check_crossings(&self) -> Result<(), Error> {
        /// A share of an edge, beyond which its end touches the facet.
        const BEFORE: f64 = 1.0 - 1e-9;
        for facet in &self.facets {
            for k in 0..if D == 2 { 1 } else { D } {
                let [a, b] = [facet[k], facet[(k + 1) % D]];
                if D == 3 && a > b {
                    continue;
                }
                let (x, d) = (self.nodes[a], self.nodes[b] - self.nodes[a]);
                for leaf in self.tree.at(&(x + d * 0.5), 0.5 * d.amax()) {
                    let is_neighbour = self.facets[leaf.index].iter().any(|c| [a, b].contains(c));
                    match self.meeting(leaf.index, &x, &d) {
                        Meeting::After(s) | Meeting::AtEdge(s) if s < BEFORE && !is_neighbour => {
                            return Err(crossing(&(x + d * s)));
                        }
                        _ => {}
                    }
                }
            }
        }
        Ok(())
    }

    /// Checks that the outside is in front of each facet.
    fn check_outside(&self) -> Result<(), Error> {
        for (index, facet) in self.facets.iter().enumerate() {
            let centre = facet.iter().map(|&a| self.nodes[a]).sum::<Vector<D>>() / D as f64;
            match self.winding(&centre, Some(index)) {
                Some(0) => {}
                Some(..0) => {
                    return Err(refused(
                        "is inside out",
                        &centre,
                        "reverse its facets: in the plane they go around the inside counter-clockwise, in space they do so seen \
                         from outside",
                    ));
                }
                _ => return Err(crossing(&centre)),
            }
        }
        Ok(())
    }
}

/// Where a ray meets a facet.
enum Meeting {
    Nowhere,
    /// After so many lengths of the ray's direction, so near to its edge that round-off decides; NaN if it is seen from its side.
    AtEdge(f64),
    /// After so many lengths of the ray's direction.
    After(f64),
}

fn crossing<const D: usize>(x: &Vector<D>) -> Error {
    refused(
        "crosses or touches itself, or has a part inside another",
        x,
        "leave out what is inside, and let every facet border on the outside",
    )
}

/// The ends of the edge between the corners `k` and `k + 1` of a triangle, in ascending order.
fn edge<const D: usize>(facet: &[usize; D], k: usize) -> [usize; 2] {
    let [a, b] = [facet[k], facet[(k + 1) % D]];
    [a.min(b), a.max(b)]
}

/// The angle of a triangle at corner `k`; 1 for a segment.
fn angle<const D: usize>(corners: [Vector<D>; D], k: usize) -> f64 {
    match D {
        2 => 1.0,
        _ => {
            let arms = [1, 2].map(|next| corners[(k + next) % D] - corners[k]);
            arms[0].angle(&arms[1])
        }
    }
}

/// The flat facets between the nodes of a facet, which may be quadratic.
fn pieces<const D: usize>(nodes: &[usize]) -> Vec<[usize; D]> {
    let at: &[[usize; 3]] = match (D, nodes.len()) {
        (2, 3) => &[[0, 2, 0], [2, 1, 0]],
        (3, 6) => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        _ => &[[0, 1, 2]],
    };
    at.iter()
        .map(|at| std::array::from_fn(|k| nodes[at[k]]))
        .collect()
}

fn unit_normals<const D: usize>(
    nodes: &[Vector<D>],
    facets: &[[usize; D]],
) -> Result<Vec<Vector<D>>, Error> {
    if facets.is_empty() {
        let remedy = "give it the facets of a closed surface";
        return Err(refused("has no facets", &Vector::<D>::zeros(), remedy));
    }
    let normal = |facet: &[usize; D]| {
        if let Some(&node) = facet.iter().find(|&&a| a >= nodes.len()) {
            return Err(Error::Setting {
                name: "obstacle's node",
                value: node as f64,
                remedy: "number the nodes of facets from 0 in the order of the points",
            });
        }
        let corners = facet.map(|a| nodes[a]);
        let n = facet_normal(&corners);
        let size = (1..D).map(|k| (corners[k] - corners[0]).norm());
        let size = size.fold(0.0, f64::max).powi(D as i32 - 1);
        n.try_normalize(1e-14 * size).ok_or_else(|| {
            let remedy = "leave it out, and merge the nodes that coincide";
            refused("has a facet without extent", &corners[0], remedy)
        })
    };
    facets.iter().map(normal).collect()
}

/// Checks that each edge (in the plane each node) belongs to two facets which run through it in opposite directions.
fn check_closed<const D: usize>(nodes: &[Vector<D>], facets: &[[usize; D]]) -> Result<(), Error> {
    // how often an edge is run through in either direction; a node is the beginning or the end of a segment
    let mut runs: BTreeMap<[usize; 2], [usize; 2]> = BTreeMap::new();
    for facet in facets {
        for k in 0..D {
            let (key, forwards) = match D {
                2 => ([facet[k]; 2], k == 0),
                _ => (edge(facet, k), facet[k] < facet[(k + 1) % D]),
            };
            runs.entry(key).or_default()[usize::from(forwards)] += 1;
        }
    }
    for ([a, b], runs) in runs {
        let x = (nodes[a] + nodes[b]) * 0.5;
        let (what, remedy) = match runs {
            [1, 1] => continue,
            [0, 1] | [1, 0] => (
                "is open",
                "close it: each facet needs a neighbour at each of its edges, with the same nodes",
            ),
            [0, 2] | [2, 0] => (
                "has neighbours that face different sides",
                "let all facets go around the inside in the same sense",
            ),
            _ => ("branches", "let no more than two facets meet"),
        };
        return Err(refused(what, &x, remedy));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Obstacle;
    use crate::mesh::generators::{Diagonals, annulus, cuboid, extrude, linspace, sphere};

    /// Points in a box of this half-width about the origin, without order.
    fn points<const D: usize>(count: usize, half: f64) -> Vec<Vector<D>> {
        let mut state = 1_u64;
        let mut chance = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let point = |_| Vector::from_fn(|_, _| half * (2.0 * chance() - 1.0));
        (0..count).map(point).collect()
    }

    fn of_mesh<const D: usize>(mesh: &Mesh<D>) -> ClosedSurface<D> {
        ClosedSurface::of_mesh(mesh).expect("a closed surface")
    }

    /// A box of facets is the box: distance, normal and its derivative, inside and outside.
    #[test]
    fn a_box_of_facets_is_a_box() {
        let mesh = cuboid([-1.0, -0.5, -0.25], [2.0, 1.0, 0.5], [3, 2, 2]).expect("a mesh");
        let surface = of_mesh(&mesh);
        assert_eq!(surface.len(), 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));
        let exact = Obstacle::cuboid([-1.0, -0.5, -0.25], [1.0, 0.5, 0.25]).expect("a box");
        let exact = crate::contact::obstacle::Placed::new(&exact, 0.1);
        let mut inside = 0;
        for x in points::<3>(4000, 1.6) {
            let distance = surface.distance(&x);
            inside += usize::from(distance < 0.0);
            assert!((distance - exact.distance(&x)).abs() < 1e-14, "{x}");
            assert!((surface.slope(&x) - exact.normal(&x)).amax() < 1e-12, "{x}");
            let turn = (surface.curvature(&x) - exact.curvature(&x)).amax();
            assert!(turn < 1e-11 * (1.0 + 1.0 / distance.abs()), "{x} {turn}");
        }
        assert!(inside > 40, "{inside}");
    }

    /// A ball of facets begins within the sagitta of its chords below the ball, which is a quarter with twice the shells.
    #[test]
    fn a_ball_of_facets_becomes_a_ball() {
        let ball = Obstacle::ball([0.0; 3], 1.0).expect("a ball");
        let off = |shells: usize| {
            let surface = of_mesh(&sphere(1.0, shells).expect("a mesh"));
            let outside = points::<3>(2000, 1.5)
                .into_iter()
                .filter(|x| x.norm() > 1.0);
            let off = outside.map(|x| surface.distance(&x) - ball.distance(&x));
            let (least, most) = off.fold((0.0, 0.0), |(a, b): (f64, f64), o| (a.min(o), b.max(o)));
            assert!(least > -1e-14, "{least}");
            most
        };
        let [coarse, fine] = [off(6), off(12)];
        assert!(
            coarse < 0.05 && coarse / fine > 3.0 && coarse / fine < 5.5,
            "{coarse} {fine}"
        );
    }

    /// Whether a point is inside, against the cells of the mesh and against the number of crossings.
    fn sides<const D: usize>(mesh: &Mesh<D>) {
        let surface = of_mesh(mesh);
        let mut inside = 0;
        for x in points::<D>(1500, 1.4) {
            let is_inside = surface.distance(&x) < 0.0;
            assert_eq!(is_inside, mesh.contains(&x), "{x}");
            assert_eq!(surface.winding(&x, None), Some(i64::from(is_inside)), "{x}");
            inside += usize::from(is_inside);
        }
        assert!(inside > 100, "{inside}");
    }

    /// Rings, which have an inner boundary, and a solid with a hole.
    #[test]
    fn inside_and_outside() {
        let ring = annulus(&[0.5, 0.9, 1.2], 14, Diagonals::Alternating).expect("a mesh");
        sides(&ring);
        sides(&ring.clone().quadratic());
        let tube = extrude(&ring, &linspace(-0.8, 0.7, 3), ["low", "high"]).expect("a mesh");
        sides(&tube);
    }

    /// The normal at a point of the surface itself is that of the facet or the mean of its neighbours'.
    #[test]
    fn normals_on_the_surface() {
        let surface = of_mesh(&cuboid([0.0; 3], [1.0; 3], [2; 3]).expect("a mesh"));
        let s = f64::sqrt;
        for (x, n) in [
            ([0.3, 0.4, 1.0], [0.0, 0.0, 1.0]),
            ([0.3, 1.0, 1.0], [0.0, s(0.5), s(0.5)]),
            ([1.0, 1.0, 1.0], [1.0 / s(3.0); 3]),
        ] {
            let x = Vector::from(x);
            assert_eq!(surface.distance(&x).abs(), 0.0);
            assert!((surface.slope(&x) - Vector::from(n)).amax() < 1e-15);
            assert_eq!(surface.curvature(&x), Matrix::<3>::zeros());
        }
        assert!(surface.distance(&Vector::repeat(f64::NAN)).is_nan());
    }

    #[test]
    fn surfaces_without_an_inside_are_refused() {
        let cube = cuboid([0.0; 3], [1.0; 3], [1; 3]).expect("a mesh");
        let corners = cube.nodes().to_vec();
        let facets: Vec<[usize; 3]> = cube.exterior().flat_map(pieces).collect();
        let says = |nodes: &[Vector<3>], facets: &[[usize; 3]], told: &str| {
            let why = ClosedSurface::new(nodes.to_vec(), facets.to_vec()).err();
            let why = why.expect("refused").to_string();
            assert!(why.contains(told), "{why}");
        };
        says(&corners, &facets[1..], "is open");
        says(&corners, &[], "has no facets");
        let turned: Vec<[usize; 3]> = facets.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        says(&corners, &turned, "is inside out");
        says(
            &corners,
            &[&turned[..1], &facets[1..]].concat(),
            "face different sides",
        );
        says(&corners, &[&facets[..], &facets[..1]].concat(), "branches");
        says(
            &corners,
            &[&facets[..], &[[0, 1, 8]]].concat(),
            "`obstacle's node` = 8",
        );
        says(
            &corners,
            &[&facets[..], &[[0, 0, 1]]].concat(),
            "without extent",
        );
        let mut nan = corners.clone();
        nan[3][1] = f64::NAN;
        says(&nan, &facets, "NaN");

        // a second cube: apart, across the first, within it, and within it as a hollow
        let with = |scale: f64, offset: f64, second: &[[usize; 3]]| {
            let moved = corners.iter().map(|x| x * scale + Vector::repeat(offset));
            let nodes: Vec<Vector<3>> = corners.iter().copied().chain(moved).collect();
            let second = second.iter().map(|facet| facet.map(|a| a + 8));
            (
                nodes,
                facets.iter().copied().chain(second).collect::<Vec<_>>(),
            )
        };
        let (nodes, both) = with(1.0, 0.51, &facets);
        says(
            &nodes,
            &both,
            "crosses or touches itself, or has a part inside another",
        );
        let (nodes, both) = with(0.5, 0.2, &facets);
        says(
            &nodes,
            &both,
            "crosses or touches itself, or has a part inside another",
        );
        let (nodes, both) = with(1.0, 1.5, &facets);
        let apart = ClosedSurface::new(nodes, both).expect("two cubes");
        assert!((apart.distance(&Vector::repeat(1.25)) - s3(0.25)).abs() < 1e-15);
        let (nodes, both) = with(0.5, 0.25, &turned);
        let hollow = ClosedSurface::new(nodes, both).expect("a hollow cube");
        assert!((hollow.distance(&Vector::repeat(0.5)) - 0.25).abs() < 1e-15);
        assert!((hollow.distance(&Vector::from([0.5, 0.5, 0.1])) + 0.1).abs() < 1e-15);
    }

    /// The length of a vector of three equal components.
    fn s3(component: f64) -> f64 {
        component * 3f64.sqrt()
    }

    /// A triangle that opens, crosses itself as an eight, and is inside out.
    #[test]
    fn polygons_without_an_inside_are_refused() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for (facets, told) in [
            (vec![[0, 1], [1, 2], [2, 3]], "is open"),
            (vec![[0, 1], [1, 2], [3, 2], [3, 0]], "face different sides"),
            (vec![[1, 0], [2, 1], [3, 2], [0, 3]], "is inside out"),
            (vec![[0, 1], [1, 3], [3, 2], [2, 0]], "inside"),
        ] {
            let why = Obstacle::surface(&square, &facets).err();
            let why = why.expect("refused").to_string();
            assert!(why.contains(told), "{facets:?}: {why}");
        }
    }

    /// Triangles of a text and of a binary STL file, whose points are merged, are the box that they were taken from.
    #[test]
    fn stl_files() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 0.5], [2; 3]).expect("a mesh");
        let expected = of_mesh(&mesh);
        let mut text = "solid a box of facets\n".to_string();
        let mut binary = vec![b'x'; 80];
        binary.extend((expected.len() as u32).to_le_bytes());
        for facet in mesh.exterior() {
            text += "facet normal 0 0 0\n outer loop\n";
            binary.extend([0; 12]);
            for x in facet.iter().map(|&a| mesh.nodes()[a]) {
                text += &format!("  vertex {:e} {:e} {:e}\n", x[0], x[1], x[2]);
                binary.extend(x.iter().flat_map(|x| (*x as f32).to_le_bytes()));
            }
            text += " endloop\nendfacet\n";
            binary.extend([0; 2]);
        }
        text += "endsolid a box of facets\n";
        for bytes in [text.as_bytes(), &binary] {
            let file = MeshFile::parse(bytes).expect("an STL file");
            assert_eq!(file.format(), crate::mesh::read::Format::Stl);
            let surface = ClosedSurface::<3>::of_file(&file).expect("closed");
            assert_eq!(surface.len(), expected.len());
            for x in points::<3>(300, 2.5) {
                assert_eq!(surface.distance(&x), expected.distance(&x));
            }
        }
        for (sound, damaged) in [("vertex", "vertx"), ("outer", "inner"), (" 5e-1", " half")] {
            let why = MeshFile::parse(text.replacen(sound, damaged, 1).as_bytes());
            let why = why.expect_err("damaged").to_string();
            assert!(why.contains("line "), "{why}");
        }
        assert!(MeshFile::parse(&binary[..binary.len() - 1]).is_err());
    }
}
