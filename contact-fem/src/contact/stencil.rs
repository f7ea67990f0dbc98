//! One integration point of a pass.

use std::ops::Range;

use super::cut::{Integration, Points};
use super::moving::Moving;
use super::obstacle::Placed;
use super::search::{FootPoint, Master, Own, Seeker};
use super::surface::Surface;
use crate::element::{Facet, FacetRule, facet_shapes};
use crate::parallel;
use crate::tensor::Vector;

/// An integration point q of a slave that counts, and the point of the master that it must not penetrate; without the
/// two surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Projected<const D: usize> {
    pub(super) number: usize,
    pub(super) facet: usize,
    /// ξ: barycentric coordinates on the slave's facet.
    pub(super) lambda: Vector<D>,
    pub(super) weight: f64,
    pub(super) x: Vector<D>,
    pub(super) projection: FootPoint<D>,
    pub(super) kind: Kind,
}

/// How the weight of a point came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// By a rule on a whole facet.
    Whole,
    /// Likewise, less what it has lost near a rim: it counts in proportion to the length from there, or to the depth.
    Fading {
        /// Whether it is the length.
        by_length: bool,
    },
    /// By a rule on a piece of a facet.
    Piece,
    /// It is a corner.
    Corner,
}

/// What the points of a slave must not penetrate: a surface with nodes, or an obstacle without any.
#[derive(Clone, Copy, Debug)]
pub enum Against<'a, const D: usize> {
    /// Another surface, or the slave itself.
    Surface(&'a Moving<D>),
    /// A rigid obstacle.
    Obstacle(&'a Placed<D>),
    /// The slave itself, whose points do not count: a corner of an obstacle is in front of it.
    Corner(&'a Moving<D>),
}

impl<'a, const D: usize> From<&'a Master<D>> for Against<'a, D> {
    fn from(master: &'a Master<D>) -> Self {
        Against::Surface(master.moving())
    }
}

impl<'a, const D: usize> From<&'a Placed<D>> for Against<'a, D> {
    fn from(obstacle: &'a Placed<D>) -> Self {
        Against::Obstacle(obstacle)
    }
}

/// An integration point q of the slave that counts, and the point of the master that it must not
/// penetrate.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<'a, const D: usize> {
    slave: &'a Surface<D>,
    against: Against<'a, D>,
    point: Projected<D>,
}

impl<'a, const D: usize> Stencil<'a, D> {
    /// A point projected from `slave` to what it is `against`.
    pub fn new(
        slave: &'a Surface<D>,
        against: impl Into<Against<'a, D>>,
        point: Projected<D>,
    ) -> Self {
        Stencil {
            slave,
            against: against.into(),
            point,
        }
    }

    /// Its number among all integration points of the pass, including those that do not count.
    pub fn number(&self) -> usize {
        self.point.number
    }

    /// w_q: the quadrature weight times the reference measure (UL in the plane, UL² in space and of revolution), and times the
    /// share with which the point counts near the search radius, near a rim and at right angles.
    pub fn weight(&self) -> f64 {
        self.point.weight
    }

    /// How its weight came about.
    pub(super) fn kind(&self) -> Kind {
        self.point.kind
    }

    /// The slave.
    pub(super) fn slave(&self) -> &'a Surface<D> {
        self.slave
    }

    /// The slave's facet, and ξ.
    pub(super) fn place(&self) -> (usize, &Vector<D>) {
        (self.point.facet, &self.point.lambda)
    }

    /// x_q (UL).
    pub fn point(&self) -> Vector<D> {
        self.point.x
    }

    /// What the point must not penetrate.
    pub fn against(&self) -> Against<'a, D> {
        self.against
    }

    /// The projection of x_q on the master. On an obstacle, which has no facets, facet and coordinates have no meaning.
    pub fn projection(&self) -> &FootPoint<D> {
        &self.point.projection
    }

    /// φ_i(q) of the slave's nodes i, given by their positions in [`Surface::nodes`].
    pub fn test_functions(&self) -> impl Iterator<Item = (usize, f64)> + 'a {
        let nodes = self.slave.facet(self.point.facet).iter().copied();
        #[cfg(not(planted))]
        let lambda = self.point.lambda;
        #[cfg(planted)]
        let lambda = super::planted::tests(self.point.lambda);
        let tests = nodes.zip(self.slave.test_functions(&lambda));
        tests.take(self.slave.test_nodes())
    }

    /// N_a(ξ) of the slave facet's scene nodes a.
    pub(super) fn slave_shapes(&self) -> impl Iterator<Item = (usize, f64)> + Clone + 'a {
        let slave = self.slave;
        let nodes = match self.against {
            Against::Corner(_) => &[],
            _ => slave.facet(self.point.facet),
        };
        let nodes = nodes.iter().map(|&a| slave.nodes()[a]);
        #[cfg(planted)]
        if contact_core::planted!("the slave is in the middle of its facet") {
            let middle = Vector::<D>::repeat(1.0 / D as f64);
            return nodes.zip(facet_shapes(slave.order(), &middle));
        }
        nodes.zip(facet_shapes(slave.order(), &self.point.lambda))
    }

    /// ∇g with η* and n held, as (scene node, coefficient): N_a n at the nodes of the slave's
    /// facet, −N_b n at those of the master's. In self-contact a node may occur as both. g = Σ
    /// coefficient · x.
    pub fn frozen_gradient(&self) -> impl Iterator<Item = (usize, Vector<D>)> + Clone + 'a {
        let p = self.point.projection;
        let other = match self.against {
            Against::Surface(master) | Against::Corner(master) => Some(master.surface()),
            Against::Obstacle(_) => None,
        };
        let other = other.into_iter().flat_map(move |master| {
            let nodes = master.facet(p.facet).iter().map(|&b| master.nodes()[b]);
            nodes.zip(facet_shapes(master.order(), &p.lambda).map(|N| -N))
        });
        #[cfg(planted)]
        let other = {
            let mut share = 1.0;
            if contact_core::planted!("the master's part is halved") {
                share = 0.5;
            }
            if contact_core::planted!("the master's part is left out") {
                share = 0.0;
            }
            if contact_core::planted!("the master's part has the sign of the slave's") {
                share = -1.0;
            }
            other.map(move |(b, N)| (b, share * N))
        };
        let own = self.slave_shapes();
        own.chain(other).map(move |(a, N)| (a, p.normal * N))
    }

    /// What [`Stencil::frozen_gradient`] leaves out of the gap (UL): −x̄·n of a foot, or x·n of a point, that belongs to no nodes.
    pub fn frozen_constant(&self) -> f64 {
        match self.against {
            Against::Surface(_) => 0.0,
            Against::Obstacle(_) => {
                let p = &self.point.projection;
                -p.foot.dot(&p.normal)
            }
            Against::Corner(_) => self.point.x.dot(&self.point.projection.normal),
        }
    }
}

#[cfg(test)]
impl<'a, const D: usize> Stencil<'a, D> {
    /// The master's surface, of a point that has one.
    pub(super) fn master(&self) -> &'a Moving<D> {
        match self.against {
            Against::Surface(master) | Against::Corner(master) => master,
            Against::Obstacle(_) => unreachable!("a point on an obstacle"),
        }
    }

    /// The same slave point at other positions, with its foot at `lambda` on the same facet.
    pub(super) fn moved(&self, master: &'a Moving<D>, x: Vector<D>, lambda: Vector<D>) -> Self {
        let projection = FootPoint {
            lambda,
            ..self.point.projection
        };
        Stencil {
            against: Against::Surface(master),
            point: Projected {
                x,
                projection,
                ..self.point
            },
            ..*self
        }
    }
}

/// Projects every point of `integration` on `slave` to `master`, for positions `x` of all scene
/// nodes, and returns those that count within the search radius `reach` (UL).
pub fn projected<const D: usize>(
    slave: &Surface<D>,
    master: &Master<D>,
    x: &[Vector<D>],
    integration: Integration,
    reach: f64,
) -> Vec<Projected<D>> {
    // nothing stops it
    projected_unless(slave, master, x, (integration, reach), || false).unwrap_or_default()
}

/// As [`projected`]; `None` as soon as `stops` says so, which is asked before each facet.
pub(crate) fn projected_unless<const D: usize>(
    slave: &Surface<D>,
    master: &Master<D>,
    x: &[Vector<D>],
    (integration, reach): (Integration, f64),
    stops: impl Fn() -> bool + Sync,
) -> Option<Vec<Projected<D>>> {
    let positions = slave.gather(x);
    let on = |facets| {
        let rule = (integration, reach);
        on_facets(facets, slave, master, &positions, rule, &stops)
    };
    let parts = parallel::parts(slave.facets().len(), FACETS, on);
    let mut parts: Vec<_> = parts.into_iter().collect::<Option<_>>()?;
    if parts.len() == 1 {
        return Some(parts.swap_remove(0).0);
    }
    let mut projected = Vec::new();
    let mut first = 0;
    for (part, points) in parts {
        projected.extend(part.into_iter().map(|point| Projected {
            number: first + point.number,
            ..point
        }));
        first += points;
    }
    Some(projected)
}

/// The points of the Gauss rule on `slave`, for positions `x` of all scene nodes, that an obstacle may hold: they face it,
/// and are at most `reach` (UL) away from it. As deep inside as they may be, they count.
pub(crate) fn on_obstacle<const D: usize>(
    slave: &Surface<D>,
    obstacle: &Placed<D>,
    x: &[Vector<D>],
    points: usize,
    reach: f64,
) -> Vec<Projected<D>> {
    let positions = slave.gather(x);
    let rule = FacetRule::<D>::gauss(points);
    let mut projected = Vec::new();
    for (index, nodes) in slave.facets().enumerate() {
        let facet = Facet::gather(slave.order(), nodes, &positions);
        for (k, (weight, lambda)) in rule.points().iter().enumerate() {
            let x = facet.point(lambda);
            let gap = obstacle.distance(&x);
            // a gap that is no number is told, not left out
            if gap > reach {
                continue;
            }
            let normal = obstacle.normal(&x);
            if facet.normal(lambda).dot(&normal) >= 0.0 {
                continue;
            }
            projected.push(Projected {
                number: index * rule.points().len() + k,
                facet: index,
                lambda: *lambda,
                weight: slave.measure(index, lambda) * weight,
                x,
                projection: FootPoint::on_obstacle(&x, gap, normal),
                kind: Kind::Whole,
            });
        }
    }
    projected
}

/// The points of [`projected`] with their surfaces.
#[cfg(test)]
pub(super) fn stencils<'a, const D: usize>(
    slave: &'a Surface<D>,
    master: &'a Master<D>,
    x: &[Vector<D>],
    integration: Integration,
    reach: f64,
) -> Vec<Stencil<'a, D>> {
    let points = projected(slave, master, x, integration, reach).into_iter();
    points
        .map(|point| Stencil::new(slave, master, point))
        .collect()
}

/// So many facets are one thread's part: in the plane, where a facet takes a few µs, much more work than it is to hand
/// it over.
const FACETS: usize = 16;

/// As [`projected`], on some facets of `slave` alone, whose own nodes are at `positions`. The points are numbered from
/// zero; the second result is their number.
fn on_facets<const D: usize>(
    facets: Range<usize>,
    slave: &Surface<D>,
    master: &Master<D>,
    positions: &[Vector<D>],
    (integration, reach): (Integration, f64),
    stops: &impl Fn() -> bool,
) -> Option<(Vec<Projected<D>>, usize)> {
    let facet_size = slave.facet_size();
    let mut projected = Vec::new();
    let mut number = 0;
    let same_body = slave.body() == master.surface().body();
    let mut rule = Points::new(integration, slave, master);
    for index in facets {
        if stops() {
            return None;
        }
        let facet = Facet::gather(slave.order(), slave.facet(index), positions);
        let reference = &slave.reference()[index];
        let length = slave.length(index);
        let seeker = |lambda: &Vector<D>| Seeker {
            x: facet.point(lambda),
            facing: facet.normal(lambda),
            reach,
            X: reference.point(lambda),
            N: reference.normal(lambda),
            facet_size,
            own: same_body.then_some(Own {
                surface: slave,
                nodes: slave.facet(index),
            }),
            reaches_beyond: false,
        };
        rule.cut(&facet, master, &seeker);
        for place in rule.places() {
            let lambda = &place.lambda;
            let seeker = Seeker {
                reaches_beyond: place.is_covered,
                ..seeker(lambda)
            };
            let found = master.find(&seeker).map(|projection| {
                let (share, kind) = rule.share((place, length), &projection, master);
                let share = seeker.share(&projection) * share;
                Projected {
                    number,
                    facet: index,
                    lambda: *lambda,
                    weight: place.weight * slave.measure(index, lambda) * share,
                    x: seeker.x,
                    projection,
                    kind,
                }
            });
            #[cfg(planted)]
            let found = found.filter(|_| {
                let is_point =
                    contact_core::planted!("every fifth point is lost") && number % 5 == 0;
                let is_facet =
                    contact_core::planted!("every sixth facet is lost") && index % 6 == 0;
                let is_near = contact_core::planted!("points near corners are lost")
                    && place.lambda.max() > 0.9;
                !is_point && !is_facet && !is_near
            });
            #[cfg(planted)]
            let found = found.map(|mut point| {
                if contact_core::planted!("weights leave out the measure") {
                    point.weight = place.weight;
                }
                if contact_core::planted!("every third facet weighs twice") && index % 3 == 0 {
                    point.weight *= 2.0;
                }
                if contact_core::planted!("every twentieth point weighs twice") && number % 20 == 0
                {
                    point.weight *= 2.0;
                }
                if contact_core::planted!("every ninth point pushes the other way")
                    && number % 9 == 0
                {
                    point.projection.normal = -point.projection.normal;
                }
                point
            });
            projected.extend(found.filter(|point| point.weight > 0.0));
            number += 1;
        }
    }
    Some((projected, number))
}
