//! The search for the closest point of a master surface, with a bounding-volume tree over its
//! current facets, and the criteria by which that point counts.

use std::sync::{Arc, OnceLock};

use super::along_normals::{self, Foot};
use super::moving::Moving;
use super::normals;
use super::projection::Projection;
use super::surface::Surface;
use super::tree::{Closest, FacetTree};
use crate::element::{Facet, facet_shapes};
use crate::tensor::{Vector, facet_normal};

/// A master surface at current positions, on which points are projected.
pub struct Master<const D: usize> {
    moving: Moving<D>,
    /// The tree is built by the first search.
    tree: OnceLock<FacetTree<D>>,
    /// The mean length of the facets (UL).
    pub(super) facet_size: f64,
    projection: Projection,
    /// How deep bodies start inside its own, or its own inside them (UL).
    pub(super) fit: f64,
}

/// The projection of a point x: its foot x̄ on a master surface.
#[derive(Clone, Copy, Debug)]
pub struct FootPoint<const D: usize> {
    /// How it was found. Where a point has no foot along normals, this is [`Projection::Closest`].
    pub by: Projection,
    /// The index of the facet.
    pub facet: usize,
    /// η*: the barycentric coordinates of x̄ on the facet.
    pub lambda: Vector<D>,
    /// x̄ (UL).
    pub foot: Vector<D>,
    /// The outward unit normal n at x̄, interpolated from averaged nodal normals.
    pub normal: Vector<D>,
    /// |x − x̄| (UL).
    pub distance: f64,
    /// (x − x̄)·n, positive = open (UL).
    pub gap: f64,
    /// Whether x is beyond the rim of the surface. If x̄ is along normals, it is a little beyond the rim, too, where the facet goes on; else it
    /// is on the rim.
    pub off_the_end: bool,
    /// The share with which x counts by what lies between the two: 1 but where a body does.
    pub seen: f64,
}

impl<const D: usize> FootPoint<D> {
    /// Of a point at `x` whose foot is at λ on a facet of a surface.
    pub(super) fn on(
        surface: &Moving<D>,
        (facet, lambda): (usize, Vector<D>),
        x: &Vector<D>,
    ) -> Self {
        let nodes = surface.surface().facet(facet);
        let N = facet_shapes(surface.surface().order(), &lambda);
        let (mut foot, mut normal) = (Vector::<D>::zeros(), Vector::<D>::zeros());
        for (N, &a) in N.iter().zip(nodes) {
            foot.axpy(*N, &surface.positions()[a], 1.0);
            normal.axpy(*N, &surface.normals()[a], 1.0);
        }
        #[cfg(planted)]
        if contact_core::planted!("the normal is that of the nearest node") {
            normal = surface.normals()[nodes[lambda.imax()]];
        }
        let normal = normals::unit(normal);
        let offset = x - foot;
        FootPoint {
            by: Projection::Closest,
            facet,
            lambda,
            foot,
            normal,
            distance: offset.norm(),
            gap: offset.dot(&normal),
            off_the_end: false,
            seen: 1.0,
        }
    }

    /// Of a point at `x` on an obstacle, which has no facets, by its signed distance and its normal there.
    pub(super) fn on_obstacle(x: &Vector<D>, gap: f64, normal: Vector<D>) -> Self {
        FootPoint {
            by: Projection::Closest,
            facet: 0,
            lambda: Vector::zeros(),
            foot: x - normal * gap,
            normal,
            distance: gap.abs(),
            gap,
            off_the_end: false,
            seen: 1.0,
        }
    }
}

/// A point of a slave surface for which the closest point of a master surface is searched.
#[derive(Clone, Copy, Debug)]
pub struct Seeker<'a, const D: usize> {
    /// Its position (UL).
    pub x: Vector<D>,
    /// The outward normal of the slave there, of any length.
    pub facing: Vector<D>,
    /// The search radius (UL).
    pub reach: f64,
    /// Its reference position (UL).
    pub X: Vector<D>,
    /// The outward normal there in the reference configuration, of any length.
    pub N: Vector<D>,
    /// The length of the slave's facets (UL).
    pub facet_size: f64,
    /// Its place on its own body if the master belongs to the same body, else `None`.
    pub own: Option<Own<'a, D>>,
    /// Whether a foot that is a little beyond the rim of the master counts.
    pub reaches_beyond: bool,
}

/// The place of a slave point on its own body, for self-contact.
#[derive(Clone, Copy, Debug)]
pub struct Own<'a, const D: usize> {
    /// The slave surface.
    pub surface: &'a Surface<D>,
    /// The nodes (positions in [`Surface::nodes`]) whose facets are the point's neighbourhood.
    pub nodes: &'a [usize],
}

/// A point counts in full if the cosine between the slave's normal and the reversed normal of the master is at least this.
const FACING: f64 = 0.2;
/// The share of the search radius within which points lose their weight.
const FAR: f64 = 0.1;

/// The share with which what is so far away counts towards the search radius (UL).
pub(super) fn near_share(distance: f64, reach: f64) -> f64 {
    match reach.is_finite() {
        true => ((reach - distance) / (FAR * reach)).clamp(0.0, 1.0),
        false => 1.0,
    }
}

impl<const D: usize> Seeker<'_, D> {
    /// The share of its weight with which a point counts. It falls to zero towards the search radius, where slave and
    /// master are at right angles, and where the foot comes out of sight, so that no point leaves its row at once.
    pub(super) fn share(&self, p: &FootPoint<D>) -> f64 {
        #[cfg(planted)]
        if contact_core::planted!("shares of points are left out") {
            return 1.0;
        }
        let facing = -self.facing.dot(&p.normal) / self.facing.norm();
        Self::facing_share(facing) * near_share(p.distance, self.reach) * p.seen
    }

    /// The same by the cosine between the slave's normal and the reversed normal of the master.
    pub(super) fn facing_share(facing: f64) -> f64 {
        (facing / FACING).clamp(0.0, 1.0)
    }
}

impl<const D: usize> Master<D> {
    /// The tolerance of a projection beyond the rim, as a share of the facet size: a larger
    /// tangential offset is off the end.
    const OFF_THE_END: f64 = 1e-9;
    /// How far a facet goes on beyond the rim, in barycentric coordinates: much farther than the chord of a shadow is from the
    /// rim.
    const BEYOND: f64 = 0.2;
    /// The cosine between two normals above which surfaces face the same way: round a right-angled edge, averaged normals turn by 45°.
    const ALIKE: f64 = 0.75;
    /// Closer than this, as a share of the facet size, a projection counts as a local minimum of the distance.
    const CLOSED: f64 = 1e-6;

    /// At positions `x` of all scene nodes, with feet by `projection`.
    pub fn new(surface: &Arc<Surface<D>>, x: &[Vector<D>], projection: Projection) -> Self {
        Master {
            moving: Moving::new(surface, x),
            tree: OnceLock::new(),
            facet_size: surface.facet_size(),
            projection,
            fit: 0.0,
        }
    }

    /// The same, of a body that overlaps others by this depth (UL) in the reference configuration.
    pub fn fitted(self, fit: f64) -> Self {
        Master { fit, ..self }
    }

    /// How points find their feet.
    pub(super) fn by(&self) -> Projection {
        self.projection
    }

    /// The surface's positions and normals.
    pub fn moving(&self) -> &Moving<D> {
        &self.moving
    }

    /// The surface in the reference configuration.
    pub fn surface(&self) -> &Surface<D> {
        self.moving.surface()
    }

    /// The averaged normals, in the order of the surface's nodes.
    pub fn normals(&self) -> &[Vector<D>] {
        self.moving.normals()
    }

    pub(super) fn tree(&self) -> &FacetTree<D> {
        #[cfg(planted)]
        if contact_core::planted!("the tree is that at rest") {
            let X = self.surface().reference_nodes();
            let facets = || FacetTree::new(self.surface().facets_at(X));
            return self.tree.get_or_init(facets);
        }
        self.tree
            .get_or_init(|| FacetTree::new(self.surface().facets_at(self.moving.positions())))
    }

    /// The foot of `x` nearby its closest point, or `None` if the surface has no facets.
    pub fn project(&self, x: &Vector<D>) -> Option<FootPoint<D>> {
        let closest = self.tree().nearest(x)?;
        Some(self.foot(&closest, x))
    }

    /// The foot of the point that `seeker` must not penetrate, or `None`. It is the one nearby the closest point of the
    /// surface if that counts: it is within the search radius, not off the master's end, faces the
    /// seeker, and is not separated from it by material. If the seeker is inside a body beyond its
    /// middle, the closest point is on the far side: then it is the closest one that counts and is a
    /// local minimum of the distance. On the seeker's own body it is the closest
    /// of those points that count, are on no facet of the neighbourhood, and are local minima of
    /// the distance.
    pub fn find(&self, seeker: &Seeker<'_, D>) -> Option<FootPoint<D>> {
        if self.tree().is_beyond(&seeker.x, seeker.reach) {
            return None;
        }
        #[cfg(planted)]
        let seeker = &Seeker {
            reach: match contact_core::planted!("reach is a hundredth") {
                true => 0.01 * seeker.reach,
                false => seeker.reach,
            },
            ..*seeker
        };
        let counted = |p: FootPoint<D>| {
            #[cfg(planted)]
            if contact_core::planted!("every fourth facet is no master") && p.facet % 4 == 0
                || contact_core::planted!("every sixteenth facet is no master") && p.facet % 16 == 7
            {
                return None;
            }
            #[cfg(planted)]
            if contact_core::planted!("points of any side count") {
                return Some(p).filter(|p| p.distance <= seeker.reach && !p.off_the_end);
            }
            let is_near = p.distance <= seeker.reach && Self::is_above(&p, seeker);
            if !is_near || seeker.facing.dot(&p.normal) >= 0.0 {
                return None;
            }
            let seen = self.seen(&p, seeker);
            (seen > 0.0).then_some(FootPoint { seen, ..p })
        };
        if seeker.own.is_none() {
            let nearest = self.project(&seeker.x)?;
            let is_beyond_the_middle =
                nearest.gap < 0.0 && seeker.facing.dot(&nearest.normal) >= 0.0;
            if !is_beyond_the_middle || !Self::is_above(&nearest, seeker) {
                return counted(nearest);
            }
            let behind = self.tree().by_distance(&seeker.x, seeker.reach);
            return behind
                .filter(|closest| self.is_local_minimum(closest, &seeker.x))
                .map(|closest| self.foot(&closest, &seeker.x))
                .find_map(counted);
        }
        let nearest = self.tree().by_distance(&seeker.x, seeker.reach);
        nearest
            .filter(|closest| {
                !self.is_neighbour(seeker, closest.leaf.index) && !self.faces_alike(closest, seeker)
            })
            .filter(|closest| self.is_local_minimum(closest, &seeker.x))
            .map(|closest| self.foot(&closest, &seeker.x))
            .filter(|p| !self.is_neighbour(seeker, p.facet))
            .find_map(counted)
    }

    /// Whether a foot is on the surface, or as little beyond its rim as the seeker allows.
    fn is_above(p: &FootPoint<D>, seeker: &Seeker<'_, D>) -> bool {
        !p.off_the_end || seeker.reaches_beyond && p.by == Projection::AlongNormals
    }

    /// Whether a facet is in the seeker's neighbourhood on its own body: it has a node of the seeker's facet.
    fn is_neighbour(&self, seeker: &Seeker<'_, D>, facet: usize) -> bool {
        let mut nodes = self.surface().facet(facet).iter();
        nodes.any(|&b| self.is_own(seeker, b))
    }

    /// Whether node `b` of the surface is one of the seeker's.
    pub(super) fn is_own(&self, seeker: &Seeker<'_, D>, b: usize) -> bool {
        let node = self.surface().nodes()[b];
        let own = |own: Own<'_, D>| own.nodes.iter().any(|&a| own.surface.nodes()[a] == node);
        seeker.own.is_some_and(own)
    }

    /// Whether the surface faces the same way as the seeker at the closest point of a facet, so that a foot nearby does not count: the cheapest test of all.
    fn faces_alike(&self, closest: &Closest<'_, D>, seeker: &Seeker<'_, D>) -> bool {
        let nodes = self.surface().facet(closest.leaf.index);
        let N = facet_shapes(self.surface().order(), &closest.lambda);
        let normals = N.iter().zip(nodes).map(|(N, &a)| self.normals()[a] * *N);
        let n = normals::unit(normals.sum());
        seeker.facing.dot(&n) > Self::ALIKE * seeker.facing.norm()
    }

    /// Whether the closest point of a facet is a local minimum of the distance: no adjacent facet has a point
    /// closer to `x`.
    fn is_local_minimum(&self, closest: &Closest<'_, D>, x: &Vector<D>) -> bool {
        let Closest { leaf, lambda, .. } = closest;
        let inner = lambda.iter().all(|&l| l > 0.0);
        let foot = leaf.facet.point(lambda);
        let distance = (x - foot).norm();
        if inner || distance <= Self::CLOSED * self.facet_size {
            return true;
        }
        let nodes = self.surface().facet(leaf.index);
        let closer = distance * (1.0 - Self::OFF_THE_END);
        let mut others = self
            .tree()
            .at(&foot, Self::OFF_THE_END * self.facet_size)
            .filter(|other| {
                let others = self.surface().facet(other.index);
                other.index != leaf.index && others.iter().any(|a| nodes.contains(a))
            });
        !others.any(|other| other.distance(x) < closer)
    }

    /// The distance of `seeker` from the surface (UL). On its own body, the distance from the point
    /// that it must not penetrate, or the search radius if there is none.
    pub(super) fn distance(&self, seeker: &Seeker<'_, D>) -> f64 {
        let (found, unless) = match seeker.own {
            Some(_) => (self.find(seeker), seeker.reach),
            None => (self.project(&seeker.x), f64::INFINITY),
        };
        found.map_or(unless, |p| p.distance)
    }

    /// The facets with a point within `distance` of `x`, with their indices.
    pub(super) fn within(
        &self,
        x: &Vector<D>,
        distance: f64,
    ) -> impl Iterator<Item = (usize, &Facet<D>)> {
        let near = self.tree().within(x, distance);
        near.map(|leaf| (leaf.index, &leaf.facet))
    }

    /// The foot of `x` nearby the closest point of a facet.
    fn foot(&self, closest: &Closest<'_, D>, x: &Vector<D>) -> FootPoint<D> {
        let nearby = (closest.leaf.index, closest.lambda);
        let along_normals = match self.projection {
            Projection::AlongNormals => along_normals::foot(&self.moving, x, nearby),
            Projection::Closest => Foot::None,
        };
        #[cfg(planted)]
        let along_normals = super::planted::foot(self.surface(), along_normals);
        match along_normals {
            Foot::On(facet, lambda) => FootPoint {
                by: Projection::AlongNormals,
                ..FootPoint::on(&self.moving, (facet, lambda), x)
            },
            Foot::Beyond(facet, lambda) if lambda.min() > -Self::BEYOND => FootPoint {
                by: Projection::AlongNormals,
                off_the_end: true,
                ..FootPoint::on(&self.moving, (facet, lambda), x)
            },
            Foot::Beyond(..) => FootPoint {
                off_the_end: true,
                ..FootPoint::on(&self.moving, nearby, x)
            },
            Foot::None => FootPoint {
                #[cfg(not(planted))]
                off_the_end: self.is_off_the_end(closest, x),
                #[cfg(planted)]
                off_the_end: !contact_core::planted!("points beyond the end count")
                    && self.is_off_the_end(closest, x),
                ..FootPoint::on(&self.moving, nearby, x)
            },
        }
    }

    fn is_off_the_end(&self, closest: &Closest<'_, D>, x: &Vector<D>) -> bool {
        let Closest { leaf, lambda, .. } = closest;
        let nodes = self.surface().facet(leaf.index);
        if !self.surface().rim().has(leaf.index, nodes, lambda) {
            return false;
        }
        let offset = x - leaf.facet.point(lambda);
        let tangent = leaf.facet.tangent(lambda);
        let n = normals::unit(facet_normal(&tangent));
        let size = (tangent[1] - tangent[0]).norm();
        let tangential = offset - n * offset.dot(&n);
        tangential.norm() > Self::OFF_THE_END * size
    }
}

/// The nodes of `slave` inside `master` as (position in [`Surface::nodes`], gap < 0). They are
/// projected at positions `x`, those of `master`; the gaps are measured at positions `now`, which
/// differ from `x` in a frozen geometry. On its own body the search radius of a node is `reach`.
pub fn nodes_inside<const D: usize>(
    slave: &Surface<D>,
    slave_normals: &[Vector<D>],
    master: &Master<D>,
    x: &[Vector<D>],
    now: &[Vector<D>],
    reach: f64,
) -> Vec<(usize, f64)> {
    let gaps = nodal_gaps(slave, slave_normals, master, x, now, reach);
    let inside = gaps.into_iter().enumerate();
    let inside = inside.filter_map(|(k, gap)| Some((k, gap?.to_facet)));
    inside.filter(|(_, gap)| *gap < 0.0).collect()
}

/// The gap of a node (UL), positive = open.
#[derive(Clone, Copy, Debug)]
pub struct NodalGap {
    /// To the facet that it faces.
    pub to_facet: f64,
    /// How far the surface that has the averaged normals is outside that facet there.
    pub bulge: f64,
}

impl NodalGap {
    /// To the smooth surface.
    pub fn smooth(&self) -> f64 {
        self.to_facet - self.bulge
    }
}

/// Normals of a facet's corners that differ by less than the first tell how the surface is curved; those that differ by more than the
/// second are of an edge: a right-angled one makes them differ by 0.77.
const CURVED: [f64; 2] = [0.4, 0.6];

/// How far a smooth surface through the corners of a straight facet, with the averaged normals n there, is outside it (UL), at the
/// point with the barycentric coordinates λ: Σ ½ λ_i λ_j (x_j − x_i)·(n_j − n_i), on a circle the sagitta h²/8R in the middle. It is 0 of
/// quadratic facets, which are curved themselves.
fn bulge<const D: usize>(
    master: &Master<D>,
    facet: &[usize],
    now: &[Vector<D>],
    lambda: &Vector<D>,
) -> f64 {
    if facet.len() > D {
        return 0.0;
    }
    let x: [Vector<D>; D] = std::array::from_fn(|i| now[master.surface().nodes()[facet[i]]]);
    let normals: [Vector<D>; D] = std::array::from_fn(|i| master.normals()[facet[i]]);
    let [smooth, edge] = CURVED;
    let pairs = (0..D).flat_map(|j| (0..j).map(move |i| (i, j)));
    let bulges = pairs.map(|(i, j)| {
        let turn = normals[j] - normals[i];
        let share = ((edge - turn.norm()) / (edge - smooth)).clamp(0.0, 1.0);
        0.5 * share * lambda[i] * lambda[j] * (x[j] - x[i]).dot(&turn)
    });
    bulges.sum()
}

/// As [`nodes_inside`], the gaps of all nodes; `None` where no point of `master` counts.
pub fn nodal_gaps<const D: usize>(
    slave: &Surface<D>,
    slave_normals: &[Vector<D>],
    master: &Master<D>,
    x: &[Vector<D>],
    now: &[Vector<D>],
    reach: f64,
) -> Vec<Option<NodalGap>> {
    let same_body = slave.body() == master.surface().body();
    let numbers: Vec<usize> = (0..slave.nodes().len()).collect();
    let facet_size = slave.facet_size();
    let gap = |(k, facing): (usize, &Vector<D>)| {
        let node = slave.nodes()[k];
        let p = master.find(&Seeker {
            x: x[node],
            facing: *facing,
            reach: if same_body { reach } else { f64::INFINITY },
            X: slave.reference_nodes()[k],
            N: slave.reference_normals()[k],
            facet_size,
            own: same_body.then_some(Own {
                surface: slave,
                nodes: &numbers[k..=k],
            }),
            reaches_beyond: false,
        })?;
        let surface = master.surface();
        let facet = surface.facet(p.facet);
        let nodes = facet.iter().map(|&b| surface.nodes()[b]);
        let shapes = facet_shapes(surface.order(), &p.lambda);
        let foot: Vector<D> = nodes.zip(shapes).map(|(b, N)| now[b] * N).sum();
        Some(NodalGap {
            to_facet: (now[node] - foot).dot(&p.normal),
            bulge: bulge(master, facet, now, &p.lambda),
        })
    };
    slave_normals.iter().enumerate().map(gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{Diagonals, annulus, cylinder, rectangle};

    /// Every point beyond the rim of a disc is off its end, also where the closest point is a
    /// corner of facets without a side on the rim.
    #[test]
    fn corners_on_the_rim_are_on_the_rim() {
        let mesh = cylinder(1.0, 1.0, 3, 1).expect("mesh");
        let facets = mesh.boundary("top").expect("named");
        let top = Surface::new(0, Order::Linear, facets.iter().copied(), mesh.nodes());
        let master = Master::new(&Arc::new(top), mesh.nodes(), Projection::Closest);
        for k in 0..3600 {
            let angle = std::f64::consts::TAU * f64::from(k) / 3600.0;
            let x = Vector::<3>::new(1.1 * angle.cos(), 1.1 * angle.sin(), 1.01);
            let projection = master.project(&x).expect("a facet");
            assert!(projection.off_the_end, "{x}: {projection:?}");
        }
        let above = Vector::<3>::new(0.3, -0.4, 1.01);
        assert!(!master.project(&above).expect("a facet").off_the_end);
    }

    /// In the middle of a chord, a circle is outside it by the sagitta, the circle around a hole is inside by as much, and edges are none.
    #[test]
    fn facets_bulge_as_circles_do() {
        let in_the_middle = |mesh: &Mesh<2>, boundary: &str| -> Vec<f64> {
            let facets = mesh.boundary(boundary).expect("named");
            let surface = Surface::new(0, Order::Linear, facets.iter().copied(), mesh.nodes());
            let master = Master::new(&Arc::new(surface), mesh.nodes(), Projection::Closest);
            let middle = Vector::<2>::new(0.5, 0.5);
            let facets = master.surface().facets();
            let bulges = facets.map(|facet| bulge(&master, facet, mesh.nodes(), &middle));
            bulges.collect()
        };
        let segments = 48;
        let ring = annulus(&[1.0, 2.0], segments, Diagonals::Rising).expect("mesh");
        for (boundary, radius, sign) in [("outer", 2.0, 1.0), ("inner", 1.0, -1.0)] {
            let sagitta = radius * (1.0 - (std::f64::consts::PI / segments as f64).cos());
            for bulge in in_the_middle(&ring, boundary) {
                // the next term is (π/48)² smaller
                assert!(
                    (sign * bulge / sagitta - 1.0).abs() < 5e-3,
                    "{boundary}: {bulge}"
                );
            }
        }
        let mut halves = rectangle(&[0.0, 0.5, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("mesh");
        halves.name_boundary("all", |_| true);
        assert!(
            in_the_middle(&halves, "all")
                .iter()
                .all(|bulge| *bulge == 0.0),
            "edges"
        );
    }

    /// What a point at `x` that faces along `facing` finds, from any reach; it comes from far away.
    fn seeker(x: [f64; 2], facing: [f64; 2], reach: f64) -> Seeker<'static, 2> {
        Seeker {
            x: x.into(),
            facing: facing.into(),
            reach,
            X: Vector::<2>::new(x[0], 100.0),
            N: facing.into(),
            facet_size: 1.0,
            own: None,
            reaches_beyond: false,
        }
    }

    /// A point loses its weight over the last tenth of the search radius, and where the surfaces are nearly at right angles.
    #[test]
    fn points_count_in_part_where_they_are_about_to_leave() {
        let floor = polyline(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        let share = |height: f64, cosine: f64, reach: f64| {
            let sine = (1.0 - cosine * cosine).sqrt();
            let own = seeker([0.7, height], [sine, -cosine], reach);
            let foot = floor.project(&own.x).expect("a facet");
            own.share(&foot)
        };
        for (height, cosine, reach, expected) in [
            (0.2, 1.0, f64::INFINITY, 1.0),
            (0.2, 1.0, 0.5, 1.0),
            (0.48, 1.0, 0.5, 0.4),
            (0.5, 1.0, 0.5, 0.0),
            (0.2, 0.2, 0.5, 1.0),
            (0.2, 0.05, 0.5, 0.25),
            (0.48, 0.05, 0.5, 0.1),
            (0.2, -0.1, 0.5, 0.0),
        ] {
            let own = share(height, cosine, reach);
            assert!(
                (own - expected).abs() < 1e-12,
                "{height} {cosine} {reach}: {own}"
            );
        }
    }

    fn polyline(points: &[[f64; 2]]) -> Master<2> {
        let x: Vec<Vector<2>> = points.iter().copied().map(Vector::from).collect();
        let facets: Vec<[usize; 2]> = (1..x.len()).map(|k| [k, k - 1]).collect();
        let facets = facets.iter().map(|f| &f[..]);
        Master::new(
            &Arc::new(Surface::new(0, Order::Linear, facets, &x)),
            &x,
            Projection::Closest,
        )
    }

    /// Above a valley of depth 1, whose box reaches up to its ends: the middle is farther away than the
    /// reach, although the box is not.
    #[test]
    fn points_beyond_the_reach_are_not_found() {
        let valley = polyline(&[[-2.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [2.0, 1.0]]);
        let gap = |reach: f64| {
            let found = valley.find(&seeker([0.0, 0.5], [0.0, -1.0], reach));
            found.map(|p| p.gap)
        };
        assert_eq!(gap(0.49), None);
        assert_eq!(gap(0.51), Some(0.5));
        // seen from behind
        let behind = valley.find(&seeker([0.0, 0.5], [0.0, 1.0], 1.0));
        assert!(behind.is_none());
    }

    /// A point that reaches farther than the surface is away finds it, however far that is.
    #[test]
    fn points_within_a_long_reach_are_found() {
        let line = polyline(&[[-9.0, 0.0], [0.0, 0.0], [9.0, 0.0]]);
        for height in [0.2, 2.0, 5.0] {
            let found = line.find(&seeker([0.5, height], [0.0, -1.0], 1.5 * height));
            assert_eq!(found.map(|p| p.gap), Some(height));
        }
    }

    /// Beyond the end by a millionth is off the end; by round-off it is not.
    #[test]
    fn the_end_is_where_it_is() {
        let line = polyline(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        for (x, is_off) in [
            (2.0 + 1e-6, true),
            (2.0 + 1e-12, false),
            (2.0 - 1e-6, false),
        ] {
            let projection = line.project(&[x, 0.1].into()).expect("a facet");
            assert_eq!(projection.off_the_end, is_off, "{x}");
            let found = line.find(&seeker([x, 0.1], [0.0, -1.0], 1.0));
            assert_eq!(found.is_none(), is_off, "{x}");
        }
    }

    /// Deeper in a plate than half-way, the nearest side is the far one: the side that was entered is
    /// found nevertheless, if it is within reach.
    #[test]
    fn the_side_that_was_entered_is_found_beyond_the_middle() {
        // the middle facets of both sides do not end at a corner
        let below = [[3.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [-3.0, 0.0]];
        let above = [[-3.0, 1.0], [-1.0, 1.0], [1.0, 1.0], [3.0, 1.0]];
        let plate = polyline(&[below, above].concat());
        let gap = |reach: f64| {
            let found = plate.find(&seeker([0.0, 0.375], [0.0, -1.0], reach));
            found.map(|p| p.gap)
        };
        assert!(gap(1.0).is_some_and(|gap| (gap + 0.625).abs() < 1e-12));
        assert_eq!(gap(0.5), None);
    }

    /// From the upper side of a block, at its corner, to the side beside it, below: the way starts inside
    /// the block, though it ends along that side.
    #[test]
    fn ways_that_start_inside_a_body_are_through_it() {
        let around = [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]];
        let x: Vec<Vector<2>> = around.into_iter().map(Vector::from).collect();
        // right side, bottom, left side, and the top
        let facets = [[1, 0], [2, 1], [3, 2], [0, 3]];
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Arc::new(Surface::new(0, Order::Linear, facets, &x));
        let master = Master::new(&surface, &x, Projection::Closest);
        let own = Own {
            surface: &surface,
            nodes: &[3],
        };
        let found = master.find(&Seeker {
            x: Vector::<2>::new(0.7, 0.5),
            facing: Vector::<2>::new(-1.0, 0.0),
            reach: 0.4,
            X: x[0],
            N: Vector::<2>::new(0.0, 1.0),
            facet_size: 1.0,
            own: Some(own),
            reaches_beyond: false,
        });
        assert!(found.is_none(), "{found:?}");
    }

    /// The two sides of a wall of a tenth of a facet on one body: material lies between them, and
    /// neither may not penetrate the other. The sides of a closed slit have none between them.
    #[test]
    fn a_thin_wall_is_no_slit() {
        let x = [
            [0.0, 0.1],
            [1.0, 0.1],
            [2.0, 0.1],
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
        ];
        let x = x.map(Vector::<2>::from);
        // the normals of the first two point up or down, of the others the other way
        for is_wall in [true, false] {
            let facets = match is_wall {
                true => [[1, 0], [2, 1], [3, 4], [4, 5]],
                false => [[0, 1], [1, 2], [4, 3], [5, 4]],
            };
            let mut X = x;
            if !is_wall {
                X.iter_mut().for_each(|X| X[1] = 0.0);
            }
            let facets = facets.iter().map(|f| &f[..]);
            let surface = Arc::new(Surface::new(0, Order::Linear, facets, &X));
            // the sides of the slit are in each other
            let mut now = x;
            if !is_wall {
                now[..3].iter_mut().for_each(|x| x[1] = -0.01);
                now[3..].iter_mut().for_each(|x| x[1] = 0.0);
            }
            let master = Master::new(&surface, &now, Projection::Closest);
            let own = Own {
                surface: &surface,
                nodes: &[1],
            };
            let up = if is_wall { 1.0 } else { -1.0 };
            let found = master.find(&Seeker {
                x: now[1],
                facing: Vector::<2>::new(0.0, up),
                reach: 0.5,
                X: X[1],
                N: Vector::<2>::new(0.0, up),
                facet_size: 1.0,
                own: Some(own),
                reaches_beyond: false,
            });
            match is_wall {
                true => assert!(found.is_none(), "{found:?}"),
                false => {
                    let gap = found.expect("the other side").gap;
                    assert!((gap + 0.01).abs() < 1e-12, "{gap}");
                }
            }
        }
    }
}
