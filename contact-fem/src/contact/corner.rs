//! Sharp corners.
//!
//! A weak gap is a mean over facets, which a corner closes with a fifth of a facet and more inside. A sharp corner therefore has a row of its
//! own, which says that it is inside by no more than a share of the facet:
//!
//! c = g + h/20 + h (1/s − 1) ≥ 0,
//!
//! with the gap g of the corner, the length h of the facets and the share s with which a point counts. s is 1 but near the search
//! radius, near a rim and at right angles, where it falls to 0, so that no corner leaves its row with its force. A corner is a node of a
//! body or, the other way around, a corner of an obstacle in front of a body.

use super::edge::SharpEdge;
use super::moving::Moving;
use super::obstacle::Placed;
use super::search::{FootPoint, Master, Own, Seeker};
use super::stencil::{Against, Kind, Projected, Stencil};
use super::surface::Surface;
use crate::element::Facet;
use crate::mesh::Mesh;
use crate::tensor::{Vector, unit_vector};

/// When sharp corners, and sharp edges that cross in space, have rows of their own. Only scenes with contact at the current positions, feet along
/// normals and no overlaps at the start may have such rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Corners {
    /// From the first load step on that ends with bodies inside each other: by a fifth of a facet, or by a twentieth without a force between the bodies. This step is solved
    /// again.
    #[default]
    AsNeeded,
    /// From the start.
    Held,
    /// Never: corners dig in by a share of a facet.
    Weak,
}

/// By this share of a facet a corner may dig in; [`Overlap::LIMIT`](crate::audit::Overlap::LIMIT), beyond which a step is refused, is six times as much.
const DIGS: f64 = 0.05;
/// The cosine of the angle between facets, 40°, from which on their common corner is sharp: a circle of 12 facets turns by 30°.
pub(super) const SHARP: f64 = 0.766;
/// Corners with a smaller share have no row: they would have to be a thousand facets deep.
const LEAST: f64 = 1e-3;
/// The depth inside the rim, as a share of a facet, from which on corners count in full.
const INSIDE: f64 = 0.5;

/// What is added to the gap of a corner beside facets of this length (UL), or of two edges, by the share with which it counts; `None` if it has no row.
pub(super) fn slack(size: f64, share: f64) -> Option<f64> {
    (share > LEAST).then(|| size * (DIGS + 1.0 / share - 1.0))
}

/// A corner that counts.
#[derive(Clone, Copy, Debug)]
pub struct Corner<const D: usize> {
    point: Projected<D>,
    /// Whether it is one of an obstacle, in front of the slave's surface.
    is_of_obstacle: bool,
    /// What is added to its gap (UL).
    slack: f64,
}

impl<const D: usize> Corner<D> {
    fn new(point: Projected<D>, is_of_obstacle: bool, (size, share): (f64, f64)) -> Option<Self> {
        Some(Corner {
            point,
            is_of_obstacle,
            slack: slack(size, share)?,
        })
    }

    /// As a point of the slave, which is where `own` says, in front of what it is `against`.
    pub fn stencil<'a>(&self, own: &'a Moving<D>, against: Against<'a, D>) -> Stencil<'a, D> {
        let against = match self.is_of_obstacle {
            true => Against::Corner(own),
            false => against,
        };
        Stencil::new(own.surface(), against, self.point)
    }

    /// What is added to its gap (UL).
    pub fn slack(&self) -> f64 {
        self.slack
    }
}

/// The nodes of a mesh at which exterior facets meet in a sharp convex corner or edge, ascending.
pub fn sharp_nodes<const D: usize>(mesh: &Mesh<D>) -> Vec<usize> {
    let X = mesh.nodes();
    let is_axis =
        |nodes: &[usize]| mesh.is_of_revolution() && nodes.iter().all(|&a| X[a][0] == 0.0);
    let mut around: Vec<Vec<(Vector<D>, Vector<D>)>> = vec![Vec::new(); X.len()];
    for nodes in mesh.exterior().filter(|nodes| !is_axis(nodes)) {
        let facet = Facet::gather(mesh.order(), nodes, X);
        let centre = facet.point(&Vector::repeat(1.0 / D as f64));
        for (k, &a) in nodes[..D].iter().enumerate() {
            around[a].push((facet.normal(&unit_vector(k)).normalize(), centre));
        }
    }
    let nodes = around.iter().enumerate();
    let sharp = nodes.filter(|(a, facets)| {
        let pairs = facets
            .iter()
            .flat_map(|f| facets.iter().map(move |g| (f, g)));
        let mut pairs =
            pairs.map(|((n, _), (other, centre))| (n.dot(other), n.dot(&(centre - X[*a]))));
        pairs.any(|(turn, beyond)| turn < SHARP && beyond < 0.0)
    });
    sharp.map(|(a, _)| a).collect()
}

/// The sharp corners and edges of a scene.
pub struct SharpCorners<const D: usize> {
    /// Of each surface its nodes that are such, by their positions in [`Surface::nodes`].
    pub of_surfaces: Vec<Vec<usize>>,
    /// Of each surface its sharp edges in space.
    pub edges: Vec<Vec<SharpEdge>>,
    /// Of each obstacle, before it moves: the corners (UL) with the unit bisectors of their outward normals.
    pub of_obstacles: Vec<Vec<(Vector<D>, Vector<D>)>>,
}

impl<const D: usize> SharpCorners<D> {
    /// Whether a scene has neither corners nor edges.
    pub fn is_empty(&self) -> bool {
        let corners = self.of_surfaces.iter().all(Vec::is_empty);
        let edges = self.edges.iter().all(Vec::is_empty);
        corners && edges && self.of_obstacles.iter().all(Vec::is_empty)
    }
}

/// The corners among `nodes` of a slave that count against a master, for positions `x` of all scene nodes.
pub fn on_surface<const D: usize>(
    own: &Moving<D>,
    nodes: &[usize],
    master: &Master<D>,
    x: &[Vector<D>],
    reach: f64,
) -> Vec<Corner<D>> {
    let slave = own.surface();
    let same_body = slave.body() == master.surface().body();
    let facet_size = slave.facet_size();
    let foot = |k: &usize| {
        let seeker = Seeker {
            x: own.positions()[*k],
            facing: own.normals()[*k],
            reach,
            X: slave.reference_nodes()[*k],
            N: slave.reference_normals()[*k],
            facet_size,
            own: same_body.then_some(Own {
                surface: slave,
                nodes: std::slice::from_ref(k),
            }),
            reaches_beyond: false,
        };
        let projection = master.find(&seeker)?;
        let share = seeker.share(&projection) * inside(master.surface(), &projection);
        Some((projection, share))
    };
    of_nodes(own, nodes, x.len(), foot)
}

/// Likewise against an obstacle.
pub fn on_obstacle<const D: usize>(
    own: &Moving<D>,
    nodes: &[usize],
    obstacle: &Placed<D>,
    x: &[Vector<D>],
    reach: f64,
) -> Vec<Corner<D>> {
    let foot = |k: &usize| {
        let x = &own.positions()[*k];
        let (gap, normal) = (obstacle.distance(x), obstacle.normal(x));
        let share = Seeker::<D>::facing_share(-own.normals()[*k].dot(&normal));
        // as deep inside as it may be, it counts
        (gap <= reach).then(|| (FootPoint::on_obstacle(x, gap, normal), share))
    };
    of_nodes(own, nodes, x.len(), foot)
}

/// Nodes of a slave with their feet, and the shares with which they count; `names` is the number of the scene's nodes, whose names come first.
fn of_nodes<const D: usize>(
    own: &Moving<D>,
    nodes: &[usize],
    names: usize,
    foot: impl Fn(&usize) -> Option<(FootPoint<D>, f64)>,
) -> Vec<Corner<D>> {
    if nodes.is_empty() {
        return Vec::new();
    }
    let slave = own.surface();
    let sizes = slave.node_sizes();
    let found = nodes.iter().filter_map(|k| {
        let (projection, share) = foot(k)?;
        let (facet, corner) = slave.facets_around(*k).next()?;
        let lambda = unit_vector(corner);
        let point = Projected {
            number: names + k,
            facet,
            lambda,
            weight: weight(slave, facet, (&lambda, sizes[*k])),
            x: own.positions()[*k],
            projection,
            kind: Kind::Corner,
        };
        Corner::new(point, false, (sizes[*k], share))
    });
    found.collect()
}

/// The `tips` of an obstacle that count in front of a body's surface; `names` is the number of the scene's nodes, after which those of the surface
/// are named.
pub fn of_obstacle<const D: usize>(
    (obstacle, tips): (&Placed<D>, &[(Vector<D>, Vector<D>)]),
    slave: &Master<D>,
    reach: f64,
    names: usize,
) -> Vec<Corner<D>> {
    if tips.is_empty() {
        return Vec::new();
    }
    let surface = slave.surface();
    let (sizes, facet_size) = (surface.node_sizes(), surface.facet_size());
    let (began, now) = (obstacle.obstacle().pose(0.0), obstacle.pose());
    let found = tips.iter().enumerate().filter_map(|(k, (tip, bisector))| {
        let seeker = Seeker {
            x: now.place(tip),
            facing: now.R * bisector,
            reach,
            X: began.place(tip),
            N: began.R * bisector,
            facet_size,
            own: None,
            reaches_beyond: false,
        };
        let projection = slave.find(&seeker)?;
        let (facet, lambda) = (projection.facet, projection.lambda);
        let share = seeker.share(&projection) * inside(surface, &projection);
        let around = surface.facet(facet)[..D].iter().zip(&lambda);
        let size: f64 = around.map(|(&a, l)| l * sizes[a]).sum();
        let point = Projected {
            number: names + surface.nodes().len() + k,
            facet,
            lambda,
            weight: weight(surface, facet, (&lambda, size)),
            x: seeker.x,
            projection,
            kind: Kind::Corner,
        };
        Corner::new(point, true, (size, share))
    });
    found.collect()
}

/// The share with which a corner counts whose foot is near the rim of a surface.
fn inside<const D: usize>(surface: &Surface<D>, p: &FootPoint<D>) -> f64 {
    let nodes = surface.facet(p.facet);
    let depth = surface.rim().depth(p.facet, nodes, &p.lambda);
    (depth / INSIDE).clamp(0.0, 1.0)
}

/// The measure of so long a facet around a point (UL in the plane, UL² in space and of revolution).
fn weight<const D: usize>(
    surface: &Surface<D>,
    facet: usize,
    (lambda, size): (&Vector<D>, f64),
) -> f64 {
    let ring = surface.ring(&surface.reference()[facet], lambda);
    size.powi(D as i32 - 1) * ring
}
