//! The integration points of a pass: Gauss points of the slave's facets, or of the pieces into
//! which the master's mesh cuts them.
//!
//! The integrand, test function × gap, is a polynomial while the projection stays on one facet of
//! the master; it has a kink where the projection passes to the next facet. [`Integration::Exact`]
//! divides the slave's facets there, as segment-based mortar methods do (M. A. Puso and T. A.
//! Laursen, *A mortar segment-to-segment contact method for large deformation solid mechanics*,
//! CMAME 193, 2004). The corners of the master's facets near a slave facet are projected on the plane of its
//! corners: along the master's averaged normals, as the points of the slave are, or, where points have their feet at the closest
//! points, all along the slave's normal. Neighbours stay neighbours. Facets that do not face it,
//! or are nearly perpendicular to it, are left out. In the plane the projected ends divide the
//! segment, also a curved one. In space the triangle is clipped (see `clip`), and the polygons are divided into
//! triangles. The parts that no facet covers are integrated, too: the projection of each of their
//! points decides whether it counts.
//!
//! # Rims
//!
//! No point leaves its row at once where the master ends. Pieces end there, so that their weights vanish. In space they end at
//! chords of the rim's shadow: points of a covered piece count although their feet may be a little beyond the rim, and the other points do not
//! count although their feet may be a little inside it. Gauss points, which are not cut, lose their weight as their feet come to the rim.

use super::clip::{Clipper, EMPTY, area, centroid, corners, fan, measure};
use super::projection::{Projection, along_normal, interpolate};
use super::search::{FootPoint, Master, Seeker};
use super::stencil::Kind;
use super::surface::Surface;
use crate::element::{Facet, FacetRule};
use crate::tensor::{Vector, facet_normal};

/// The quadrature of the weak gaps over the slave's facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integration {
    /// This number of Gauss points for each facet and direction, 1 to 64. The points do not resolve
    /// the edges of the master's facets. In flat contact of non-matching meshes with linear
    /// elements and 4 points, the error of the stress is about 0.1 % with both passes and several
    /// per cent with one; more points reduce it.
    Gauss(usize),
    /// Gauss points of the pieces into which the master's mesh cuts the facets. The quadrature is
    /// exact up to round-off on flat surfaces in contact whose quadratic elements have their middle
    /// nodes half-way along the edges. On other surfaces it is an approximation: in space the cuts follow
    /// chords of curved sides and of their shadows, and the number of points is that of flat pieces.
    Exact,
}

/// The integration points of one pass, facet by facet.
pub(super) enum Points<const D: usize> {
    /// The same on every facet, and the least of their barycentric coordinates.
    Same(Vec<Place<D>>, f64),
    Cut(Box<Cutter<D>>),
}

/// An integration point on a facet of the slave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<const D: usize> {
    /// The weights of a facet sum to 1 up to round-off.
    pub weight: f64,
    /// ξ: barycentric coordinates.
    pub lambda: Vector<D>,
    /// Whether it is in a piece that is opposite a facet of the master, so that it counts although its foot is beyond the rim.
    pub is_covered: bool,
}

impl<const D: usize> Place<D> {
    fn of((weight, lambda): &(f64, Vector<D>), is_covered: bool) -> Self {
        Place {
            weight: *weight,
            lambda: *lambda,
            is_covered,
        }
    }
}

impl<const D: usize> Points<D> {
    /// The points of `integration` on this slave opposite `master`.
    pub fn new(integration: Integration, slave: &Surface<D>, master: &Master<D>) -> Self {
        let (other, by) = (master.surface(), master.by());
        match integration {
            Integration::Gauss(points) => Points::uncut(points),
            Integration::Exact => {
                let shapes = slave.order().degree().max(other.order().degree());
                // 2πR of bodies of revolution
                let ring = match slave.is_of_revolution() {
                    true => slave.order().degree(),
                    false => 0,
                };
                // feet along normals that turn are no polynomial of the place
                let turning = match (D, by) {
                    (2, Projection::AlongNormals) => 2,
                    _ => 0,
                };
                Points::exact(slave.test_order().degree() + shapes + ring + turning)
            }
        }
    }

    /// Points of the pieces, exact for integrands of this degree on each.
    pub fn exact(degree: usize) -> Self {
        Points::Cut(Box::new(Cutter::new(degree)))
    }

    /// Gauss points.
    fn uncut(points: usize) -> Self {
        let rule = FacetRule::<D>::gauss(points);
        let places = rule.points().iter();
        let places: Vec<_> = places.map(|point| Place::of(point, false)).collect();
        let outermost = places
            .iter()
            .fold(1.0, |least: f64, place| least.min(place.lambda.min()));
        Points::Same(places, outermost)
    }

    /// Finds the points on `facet` of the slave. `seeker` returns the slave point with given coordinates.
    pub fn cut<'a>(
        &mut self,
        facet: &Facet<D>,
        master: &Master<D>,
        seeker: &impl Fn(&Vector<D>) -> Seeker<'a, D>,
    ) {
        if let Points::Cut(cutter) = self {
            cutter.points(facet, master, seeker);
        }
    }

    /// The points on the facet that was last cut.
    pub fn places(&self) -> &[Place<D>] {
        match self {
            Points::Same(places, _) => places,
            Points::Cut(cutter) => &cutter.points,
        }
    }

    /// The share of its weight with which a point counts whose foot is `p`, by what is known of the master's rim, and what kind of point it is. Its
    /// facet is as long as `length` (UL). Where the surfaces end together, the outermost points have their whole weight.
    pub fn share(
        &self,
        (place, length): (&Place<D>, f64),
        p: &FootPoint<D>,
        master: &Master<D>,
    ) -> (f64, Kind) {
        match self {
            Points::Same(..) if master.by() == Projection::Closest => (1.0, Kind::Whole),
            Points::Cut(_) if master.by() == Projection::Closest => (1.0, Kind::Piece),
            Points::Same(_, outermost) => {
                let surface = master.surface();
                let (rim, nodes) = (surface.rim(), surface.facet(p.facet));
                let depth = rim.depth(p.facet, nodes, &p.lambda);
                #[cfg(planted)]
                let depth = match contact_core::planted!("points near the rim weigh in full") {
                    true => 1.0,
                    false => depth,
                };
                // the depth rises by at least 2 from a side of the rim to the next one
                let full = 2.0 * outermost * length / rim.size(nodes, &p.lambda);
                let by_length = full < 1.0;
                let share = depth / full.min(1.0);
                match share < 1.0 {
                    true => (share, Kind::Fading { by_length }),
                    false => (1.0, Kind::Whole),
                }
            }
            // what is opposite this facet are other pieces
            Points::Cut(cutter) if !place.is_covered => {
                let share = f64::from(u8::from(cutter.used.binary_search(&p.facet).is_err()));
                (share, Kind::Piece)
            }
            Points::Cut(_) => (1.0, Kind::Piece),
        }
    }
}

/// The index of a facet of the master, and its corners projected on the slave's facet.
type Shadow<const D: usize> = (usize, [Vector<D>; D]);

/// Cuts one facet after the other; its buffers are allocated once.
pub(super) struct Cutter<const D: usize> {
    /// The quadrature rule of every piece.
    rule: FacetRule<D>,
    shadows: Vec<Shadow<D>>,
    breaks: Vec<f64>,
    /// The nodes of the master whose normals may meet a segment.
    ends: Vec<usize>,
    clipper: Clipper<D>,
    pieces: Vec<[Vector<D>; D]>,
    /// So many pieces are covered: the first ones.
    covered: usize,
    /// The facets whose shadows were used to cut where some part is not covered, ascending.
    used: Vec<usize>,
    points: Vec<Place<D>>,
}

/// The smallest measure of a shadow, as a share of its facet's. Facets with a smaller one are
/// nearly perpendicular to the slave's facet: they take no part in the contact, and would cut off
/// slivers at the ends of the contact surface, where the sides of the body begin.
const EDGE_ON: f64 = 0.1;
/// The accepted difference between the total measure of the shadows and that of the facet, as a
/// share of the latter. Up to it the shadows count as free of overlaps and gaps.
const TILED: f64 = 1e-11;

impl<const D: usize> Cutter<D> {
    /// For integrands of this degree on every piece.
    fn new(degree: usize) -> Self {
        Cutter {
            rule: FacetRule::of_degree(degree),
            shadows: Vec::new(),
            breaks: Vec::new(),
            ends: Vec::new(),
            clipper: Clipper::default(),
            pieces: Vec::new(),
            covered: 0,
            used: Vec::new(),
            points: Vec::new(),
        }
    }

    fn points<'a>(
        &mut self,
        facet: &Facet<D>,
        master: &Master<D>,
        seeker: &impl Fn(&Vector<D>) -> Seeker<'a, D>,
    ) {
        let middle = seeker(&Vector::repeat(1.0 / D as f64));
        self.pieces.clear();
        self.breaks.clear();
        self.covered = 0;
        self.used.clear();
        if D == 2 && master.by() == Projection::AlongNormals {
            self.cast_ends(facet, master, seeker);
            self.cut_segment();
        } else if D == 2 {
            self.cast(facet, master, &middle);
            let ends = self.shadows.iter().flat_map(|(_, shadow)| shadow);
            self.breaks.extend(ends.map(|end| end[1]));
            self.cut_segment();
        } else {
            self.cast(facet, master, &middle);
            self.cut_triangle(|lambda, index| {
                let seeker = Seeker {
                    reaches_beyond: true,
                    ..seeker(lambda)
                };
                let found = master.find(&seeker).map(|p| p.facet);
                found.is_some_and(|facet| {
                    let nodes = master.surface().facet(index);
                    let mut own = master.surface().facet(facet).iter();
                    own.any(|a| nodes.contains(a))
                })
            });
        }
        self.points.clear();
        for (k, piece) in self.pieces.iter().enumerate() {
            let share = measure(piece);
            let is_covered = k < self.covered;
            let points = self.rule.points().iter();
            self.points.extend(
                points.map(|(w, mu)| Place::of(&(w * share, interpolate(mu, piece)), is_covered)),
            );
        }
    }

    /// A bound of the distance between a point of `facet` and the master's points close to it, by the triangle inequality;
    /// `middle` is the centre of `facet`. `None` where all are out of reach.
    fn distance(facet: &Facet<D>, master: &Master<D>, middle: &Seeker<'_, D>) -> Option<f64> {
        let distances = facet.nodes().iter().map(|x| (x - middle.x).norm());
        let radius = distances.fold(0.0, f64::max);
        let distance = master.distance(middle);
        (distance <= middle.reach + radius).then_some(distance + 2.0 * radius)
    }

    /// Projects those facets of the master that can contain the foot of a point of `facet`.
    fn cast(&mut self, facet: &Facet<D>, master: &Master<D>, middle: &Seeker<'_, D>) {
        self.shadows.clear();
        let Some(distance) = Self::distance(facet, master, middle) else {
            return;
        };
        let corners = facet.corners();
        let own_measure = facet_normal(&corners).norm();
        let shadows = master
            .within(&middle.x, distance)
            .filter_map(|(index, other)| {
                let shadow = match master.by() {
                    Projection::AlongNormals => shadow_along_normals(index, master, &corners)?,
                    Projection::Closest => other.corners().map(|x| along_normal(&x, &corners)),
                };
                let least = EDGE_ON * facet_normal(&other.corners()).norm() / own_measure;
                faces(&shadow, least).then_some((index, shadow))
            });
        self.shadows.extend(shadows);
        // an order that does not depend on the bodies' positions
        self.shadows.sort_unstable_by_key(|(index, _)| *index);
    }

    /// Finds where a segment is met by the normals of the master's nodes that it faces: between such places, all feet are on one facet.
    /// On a body that touches itself, normals also meet segments through the body, where no foot is.
    fn cast_ends<'a>(
        &mut self,
        facet: &Facet<D>,
        master: &Master<D>,
        seeker: &impl Fn(&Vector<D>) -> Seeker<'a, D>,
    ) {
        let middle = seeker(&Vector::repeat(1.0 / D as f64));
        let Some(distance) = Self::distance(facet, master, &middle) else {
            return;
        };
        let lambda = |t: f64| Vector::from_fn(|i, _| if i == 0 { 1.0 - t } else { t });
        let at = |t: f64| facet.point(&lambda(t));
        let points = [0.0, 0.5, 1.0].map(at);
        let surface = master.moving();
        self.ends.clear();
        let near = master.within(&middle.x, distance);
        let near = near.flat_map(|(index, _)| &surface.surface().facet(index)[..D]);
        self.ends.extend(near);
        self.ends.sort_unstable();
        self.ends.dedup();
        for &b in &self.ends {
            let (x, n) = (surface.positions()[b], surface.normals()[b]);
            let beside = points.map(|y| (y[0] - x[0]) * n[1] - (y[1] - x[1]) * n[0]);
            let is_foot = |t: f64| {
                let found = master.find(&seeker(&lambda(t)));
                found.is_some_and(|p| surface.surface().facet(p.facet).contains(&b))
            };
            let is_met = |t: &f64| {
                let faces = facet.normal(&lambda(*t)).dot(&n) < 0.0;
                let is_near = faces && (at(*t) - x).norm() <= distance;
                is_near && (middle.own.is_none() || 0.0 < *t && *t < 1.0 && is_foot(*t))
            };
            self.breaks.extend(zeros(beside).filter(is_met));
        }
    }

    /// Divides a segment at the breaks.
    fn cut_segment(&mut self) {
        self.breaks.retain(|t| *t > 0.0 && *t < 1.0);
        self.breaks.push(1.0);
        self.breaks.sort_unstable_by(f64::total_cmp);
        let at = |t: f64| Vector::from_fn(|i, _| if i == 0 { 1.0 - t } else { t });
        let mut from = 0.0;
        for &to in self.breaks.iter().filter(|t| **t > EMPTY) {
            if to - from > EMPTY {
                let piece = std::array::from_fn(|k| at(if k == 0 { from } else { to }));
                self.pieces.push(piece);
                from = to;
            }
        }
    }

    /// Divides a triangle into its intersections with the shadows, and the remainder.
    fn cut_triangle(&mut self, is_opposite: impl Fn(&Vector<D>, usize) -> bool) {
        let whole = corners();
        let mut covered = 0.0;
        for (_, shadow) in &self.shadows {
            covered += fan(self.clipper.clip(&whole, shadow), &mut self.pieces);
        }
        if (covered - 1.0).abs() > TILED {
            self.pieces.clear();
            self.cut_untiled_triangle(is_opposite);
        } else {
            self.covered = self.pieces.len();
        }
    }

    /// As [`Cutter::cut_triangle`] where shadows leave gaps, as at the rim of the master, or
    /// overlap, as those of two facets one behind the other. An intersection is then used only if
    /// its centroid projects on the shadow's facet or on one beside it, since seams of facets may have curved shadows; `is_opposite` determines
    /// that. No part is used twice, and the remainder is added.
    fn cut_untiled_triangle(&mut self, is_opposite: impl Fn(&Vector<D>, usize) -> bool) {
        let whole = corners();
        self.clipper.rest.clear();
        self.clipper.rest.push(whole);
        for (index, shadow) in &self.shadows {
            let common = self.clipper.clip(&whole, shadow);
            let (common_area, middle) = (area(common), centroid(common));
            if common_area <= EMPTY || !is_opposite(&middle, *index) {
                continue;
            }
            self.used.push(*index);
            let before = self.pieces.len();
            let taken = self.clipper.take(shadow, &mut self.pieces);
            if common_area - taken <= TILED {
                // added as a whole: the number of parts in which it was taken can depend on
                // round-off
                self.pieces.truncate(before);
                fan(self.clipper.clip(&whole, shadow), &mut self.pieces);
            }
        }
        self.covered = self.pieces.len();
        self.pieces.append(&mut self.clipper.rest);
    }
}

/// The corners of a facet of the master where their averaged normals pass through the plane of `corners`; `None` where one
/// is nearly parallel to that plane.
fn shadow_along_normals<const D: usize>(
    index: usize,
    master: &Master<D>,
    corners: &[Vector<D>; D],
) -> Option<[Vector<D>; D]> {
    let plane = facet_normal(corners);
    let surface = master.moving();
    let mut shadow = [Vector::zeros(); D];
    for (own, &b) in shadow.iter_mut().zip(surface.surface().facet(index)) {
        let (x, n) = (surface.positions()[b], surface.normals()[b]);
        let towards = -n.dot(&plane);
        if !(towards > EDGE_ON * plane.norm()) {
            return None;
        }
        let away = (x - corners[0]).dot(&plane) / towards;
        *own = along_normal(&(x + n * away), corners);
    }
    Some(shadow)
}

/// The zeros of the parabola with these values at 0, ½ and 1.
pub(super) fn zeros([first, middle, last]: [f64; 3]) -> impl Iterator<Item = f64> {
    let bend = 2.0 * (first - 2.0 * middle + last);
    let slope = last - first - bend;
    let root = (slope * slope - 4.0 * bend * first).sqrt();
    // without cancellation; one of them is infinite on a line, and both are NaN where there is none
    let sum = -0.5 * (slope + root.copysign(slope));
    [sum / bend, first / sum].into_iter()
}

/// Whether a shadow belongs to a facet that faces the slave's, and is larger than `least`.
fn faces<const D: usize>(shadow: &[Vector<D>; D], least: f64) -> bool {
    measure(shadow) < -least.max(EMPTY)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::clip::tests::{Random, at, shared_area};
    use super::*;
    use crate::element::Order;
    use crate::mesh::Mesh;
    use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};

    /// For any overlaps and gaps of the shadows, the pieces cover the facet exactly once.
    #[test]
    fn nothing_is_lost_or_counted_twice() {
        let mut random = Random(3);
        let mut cutter = Cutter::<3>::new(4);
        let monomial = |x: &Vector<3>| x[1].powi(3) * x[2];
        // 2 · 3! 1! / 6!
        let exact = 1.0 / 60.0;
        for k in 0..20_000 {
            cutter.shadows.clear();
            cutter
                .shadows
                .extend((0..k % 7).map(|index| (index, random.shadow())));
            cutter.pieces.clear();
            cutter.cut_triangle(|x, index| x[1] < 0.6 && index == k % 5);
            let total: f64 = cutter.pieces.iter().map(measure).sum();
            assert!((total - 1.0).abs() < 1e-12, "{k}: {total}");
            cutter.pieces.clear();
            // each shadow in turn, as if the points projected on all of them
            cutter.clipper.rest.clear();
            cutter.clipper.rest.push(corners());
            for (_, shadow) in &cutter.shadows {
                let before = cutter.pieces.len();
                cutter.clipper.take(shadow, &mut cutter.pieces);
                for taken in &cutter.pieces[before..] {
                    assert!(
                        (shared_area(taken, shadow) - measure(taken)).abs() < 1e-12,
                        "{k}"
                    );
                }
                for left in &cutter.clipper.rest {
                    assert!(shared_area(left, shadow) < 1e-12, "{k}");
                }
            }
            cutter.pieces.append(&mut cutter.clipper.rest);
            let mut integral = 0.0;
            for piece in &cutter.pieces {
                for (w, mu) in cutter.rule.points() {
                    integral += w * measure(piece) * monomial(&interpolate(mu, piece));
                }
            }
            assert!((integral - exact).abs() < 1e-13, "{k}: {integral} {exact}");
        }
    }

    /// Shadows that are degenerate, or only touch the facet, cut nothing.
    #[test]
    fn degenerate_shadows() {
        let nan = Vector::<3>::repeat(f64::NAN);
        let touching = [at(0.0, 0.0), at(-1.0, 1.0), at(0.0, 1.0)];
        let at_a_corner = [at(1.0, 0.0), at(1.0, 1.0), at(2.0, 0.0)];
        let line = [at(-1.0, 0.2), at(0.5, 0.2), at(2.0, 0.2)];
        let point = [at(0.2, 0.2); 3];
        for shadow in [[nan; 3], line, point] {
            assert!(!faces(&shadow, 0.0), "{shadow:?}");
        }
        for shadow in [touching, at_a_corner] {
            assert!(faces(&shadow, 0.0));
            let mut cutter = Cutter::<3>::new(2);
            cutter.shadows.push((0, shadow));
            cutter.cut_triangle(|_, index| index == 0);
            let total: f64 = cutter.pieces.iter().map(measure).sum();
            assert!(
                (total - 1.0).abs() < 1e-14 && cutter.pieces.len() == 1,
                "{shadow:?}"
            );
        }
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]].map(Vector::<3>::from);
        assert!(
            measure(&flat.map(|x| along_normal(&x, &flat))).is_nan(),
            "no shadow on it"
        );
        let point = [Vector::<2>::zeros(); 2];
        assert!(measure(&point.map(|x| along_normal(&x, &point))).is_nan());
    }

    #[test]
    fn segments_are_divided_at_ends() {
        let mut cutter = Cutter::<2>::new(2);
        let shadow = |a: f64, b: f64| [a, b].map(|t| Vector::<2>::new(1.0 - t, t));
        cutter.shadows = vec![
            (0, shadow(0.3, -0.5)),
            (1, shadow(0.7, 0.3 + 1e-16)),
            (2, shadow(1.0 - 1e-16, 0.7)),
            (3, shadow(9.0, 1.0)),
            (4, shadow(f64::NAN, f64::NAN)),
        ];
        let ends = cutter.shadows.iter().flat_map(|(_, shadow)| shadow);
        cutter.breaks.extend(ends.map(|end| end[1]));
        cutter.cut_segment();
        let ends: Vec<[f64; 2]> = cutter.pieces.iter().map(|p| [p[0][1], p[1][1]]).collect();
        assert_eq!(ends.len(), 3, "{ends:?}");
        for (end, expected) in ends.iter().zip([[0.0, 0.3], [0.3, 0.7], [0.7, 1.0]]) {
            assert!((end[0] - expected[0]).abs() < 1e-15 && (end[1] - expected[1]).abs() < 1e-15);
        }
    }

    fn surface<const D: usize>(mesh: &Mesh<D>, name: &str) -> Surface<D> {
        let facets = mesh.boundary(name).expect("named");
        Surface::new(0, mesh.order(), facets.into_iter(), mesh.nodes())
    }

    /// The points on every facet of `slave`: their weights sum to 1, and the points of one piece
    /// project on one facet of `master`, which is `gap` below. Returns the number of pieces and of
    /// those whose points count.
    fn points_by_piece<const D: usize>(
        slave: (&Surface<D>, &[Vector<D>]),
        master: (&Surface<D>, &[Vector<D>]),
        gap: f64,
    ) -> (usize, usize) {
        let found = [Projection::Closest, Projection::AlongNormals]
            .map(|by| points_by_piece_found(slave, master, gap, by));
        assert_eq!(found[0], found[1], "on flat surfaces, feet are the same");
        found[0]
    }

    fn points_by_piece_found<const D: usize>(
        slave: (&Surface<D>, &[Vector<D>]),
        master: (&Surface<D>, &[Vector<D>]),
        gap: f64,
        by: Projection,
    ) -> (usize, usize) {
        let (slave, at) = slave;
        let master = Master::new(&Arc::new(master.0.clone()), master.1, by);
        let mut points = Points::new(Integration::Exact, slave, &master);
        let (mut all, mut counted) = (0, 0);
        for facet in slave.facets_at(&slave.gather(at)) {
            let seeker = |lambda: &Vector<D>| Seeker {
                x: facet.point(lambda),
                facing: facet.normal(lambda),
                reach: 1.0,
                X: facet.point(lambda),
                N: facet.normal(lambda),
                facet_size: 0.0,
                own: None,
                reaches_beyond: false,
            };
            points.cut(&facet, &master, &seeker);
            let on_facet = points.places().to_vec();
            let Points::Cut(cutter) = &points else {
                panic!("exact")
            };
            let total: f64 = on_facet.iter().map(|place| place.weight).sum();
            assert!((total - 1.0).abs() < 1e-12, "{total}");
            for piece in on_facet.chunks_exact(cutter.rule.points().len()) {
                let found = piece
                    .iter()
                    .map(|place| master.find(&seeker(&place.lambda)));
                let found: Vec<_> = found.collect();
                let facets: Vec<_> = found.iter().map(|p| p.map(|p| p.facet)).collect();
                assert!(facets.iter().all(|f| *f == facets[0]), "{facets:?}");
                let far = |p: f64| (p - gap).abs() > 1e-12;
                assert!(!found.iter().flatten().any(|p| far(p.distance)));
                counted += usize::from(found[0].is_some());
                all += 1;
            }
        }
        (all, counted)
    }

    #[test]
    fn flat_facets_in_the_plane() {
        let mesh = |n: usize, y: f64| {
            rectangle(
                &linspace(0.0, 1.0, n),
                &linspace(y, y + 1.0, 2),
                Diagonals::Rising,
            )
            .expect("mesh")
        };
        for quadratic in [false, true] {
            let of_order = |mesh: Mesh<2>| if quadratic { mesh.quadratic() } else { mesh };
            let (low, high) = (of_order(mesh(5, 0.0)), of_order(mesh(7, 1.1)));
            let slave = surface(&low, "top");
            let master = surface(&high, "bottom");
            let (all, counted) =
                points_by_piece((&slave, low.nodes()), (&master, high.nodes()), 0.1);
            assert_eq!((all, counted), (5 + 7 - 1, 5 + 7 - 1));
        }
    }

    /// Facets of any size ratio, also where only a part of the slave is covered, and where a second
    /// sheet of the master is behind the first.
    #[test]
    fn flat_facets_in_space() {
        let block = |low: [f64; 3], size: [f64; 3], n: usize, order| {
            let mesh = cuboid(low, size, [n, n, 1]).expect("mesh");
            match order {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            }
        };
        for order in [Order::Linear, Order::Quadratic] {
            for (n, m) in [(2, 3), (3, 2), (3, 3), (1, 7), (7, 1), (8, 31)] {
                let low = block([0.0; 3], [1.0; 3], n, order);
                let high = block([0.0, 0.0, 1.1], [1.0; 3], m, order);
                let (slave, master) = (surface(&low, "top"), surface(&high, "bottom"));
                let (all, counted) =
                    points_by_piece((&slave, low.nodes()), (&master, high.nodes()), 0.1);
                assert_eq!(all, counted, "{order:?} {n}:{m}");
                let small = block([0.21, 0.33, 1.1], [0.47, 0.52, 1.0], m, order);
                let part = surface(&small, "bottom");
                let (all, counted) =
                    points_by_piece((&slave, low.nodes()), (&part, small.nodes()), 0.1);
                assert!(counted > 0 && counted < all, "{order:?} {n}:{m}");
            }
        }
    }

    /// Two sheets of one master with different meshes; the nearer one counts.
    #[test]
    fn the_nearer_sheet_cuts() {
        let slave = cuboid([0.0; 3], [1.0; 3], [2, 2, 1]).expect("mesh");
        for far_first in [false, true] {
            let mut sheets = [(1.1, [3, 3, 1]), (1.3, [5, 4, 1])];
            if far_first {
                sheets.reverse();
            }
            let (mut nodes, mut facets) = (Vec::new(), Vec::new());
            for (height, divisions) in sheets {
                let mesh = cuboid([0.0, 0.0, height], [1.0, 1.0, 0.1], divisions).expect("mesh");
                let offset = nodes.len();
                for facet in mesh.boundary("bottom").expect("named") {
                    facets.push(facet.iter().map(|a| a + offset).collect::<Vec<_>>());
                }
                nodes.extend_from_slice(mesh.nodes());
            }
            let master = Surface::new(1, Order::Linear, facets.iter().map(Vec::as_slice), &nodes);
            let top = surface(&slave, "top");
            let (all, counted) = points_by_piece((&top, slave.nodes()), (&master, &nodes), 0.1);
            assert_eq!(all, counted);
        }
    }

    /// The ends, along x, of the pieces into which a polyline's facets cut the segment from x = −1 to 1 at
    /// height 0, which faces it.
    fn ends_on_a_segment(sheets: &[&[[f64; 2]]], reach: f64) -> Vec<f64> {
        let (mut nodes, mut facets) = (Vec::<Vector<2>>::new(), Vec::new());
        for sheet in sheets {
            let first = nodes.len();
            nodes.extend(sheet.iter().copied().map(Vector::from));
            facets.extend((first + 1..nodes.len()).map(|k| [k - 1, k]));
        }
        let facets = facets.iter().map(|f| &f[..]);
        let master = Surface::new(1, Order::Linear, facets, &nodes);
        let master = Master::new(&Arc::new(master), &nodes, Projection::Closest);
        let ends = [[1.0, 0.0], [-1.0, 0.0]].map(Vector::<2>::from);
        let facet = Facet::gather(Order::Linear, &[0, 1], &ends);
        let seeker = |lambda: &Vector<2>| Seeker {
            x: facet.point(lambda),
            facing: facet.normal(lambda),
            reach,
            X: facet.point(lambda),
            N: facet.normal(lambda),
            facet_size: 2.0,
            own: None,
            reaches_beyond: false,
        };
        let mut cutter = Cutter::<2>::new(2);
        cutter.points(&facet, &master, &seeker);
        let pieces = cutter.pieces.iter();
        let mut ends: Vec<f64> = pieces.map(|p| 1.0 - 2.0 * p[0][1]).collect();
        ends.sort_by(f64::total_cmp);
        ends
    }

    fn assert_ends(found: &[f64], expected: &[f64]) {
        let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        let same = found.len() == expected.len() && found.iter().zip(expected).all(close);
        assert!(same, "{found:?} instead of {expected:?}");
    }

    /// The side of a body, which is all but perpendicular to the segment, does not cut off a sliver; a
    /// facet that is inclined by 45° cuts.
    #[test]
    fn sides_of_a_body_do_not_cut() {
        let flat = [[-2.0, 0.1], [0.3, 0.1]];
        let with = |end: [f64; 2]| ends_on_a_segment(&[&[flat[0], flat[1], end]], 2.0);
        assert_ends(&with([0.301, 1.1]), &[0.3, 1.0]);
        assert_ends(&with([0.8, 0.6]), &[0.3, 0.8, 1.0]);
    }

    /// A facet near the middle does not hide those above the ends, which are farther away from the middle
    /// than the nearest one by more than half of the segment.
    #[test]
    fn facets_above_the_ends_cut() {
        let near = [[-0.1, 0.1], [0.05, 0.1]];
        let far = [[0.05, 0.9], [0.8, 0.9], [0.9, 0.9], [1.5, 0.9]];
        let found = ends_on_a_segment(&[&near, &far], 2.0);
        assert_ends(&found, &[-0.1, 0.05, 0.8, 0.9, 1.0]);
        // the end is within reach, though the middle is not
        let aside = [[0.8, 0.2], [0.9, 0.2], [1.5, 0.2]];
        assert_ends(&ends_on_a_segment(&[&aside], 0.5), &[0.8, 0.9, 1.0]);
    }
}
