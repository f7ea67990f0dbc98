//! Integration points of a slave's facets: those of the scene's Gauss rule, or of pieces that are cut where the foot comes to another facet.

use nalgebra::DMatrix;

use super::faces::{Faces, Patch, Placed};
use super::feet::{self, Foot, Point, Reach};
use crate::element::Order;
use crate::model::{Integration, Projection};
use crate::tensor::Vector;

/// An integration point that counts.
#[derive(Clone, Copy)]
pub(super) struct Held<const D: usize> {
    /// The slave's facet.
    pub facet: usize,
    pub lambda: Vector<D>,
    /// The reference measure times the share with which it counts (UL in the plane, UL² in space and of revolution).
    pub weight: f64,
    pub foot: Foot<D>,
}

/// The points of a slave, facet by facet.
#[derive(Default)]
pub(super) struct Points<const D: usize> {
    pub held: Vec<Held<D>>,
    /// Whether all points of the last facet have a foot and count in full.
    are_whole: bool,
}

/// The Gauss points of a piece of a segment with linear cells, and with quadratic ones: exact to degrees 7 and 9.
const ON_PIECES: [usize; 2] = [4, 5];
/// The rule of a triangle, exact to degree 4: weight, and the coordinate of a point that differs from the other two.
const TRIANGLE: [(f64, f64); 2] = [
    (0.223_381_589_678_011_47, 0.108_103_018_168_070_23),
    (0.109_951_743_655_321_87, 0.816_847_572_980_458_5),
];
/// A segment is looked at in so many parts first.
const PARTS: usize = 4;
/// How often a part is halved to find where a foot comes to the next facet, and where it leaves the boundary.
const HALVINGS: [usize; 2] = [9, 16];
/// How often a triangle is divided into four.
const DIVISIONS: usize = 2;

/// Where the points of a slave's facets are.
pub(super) enum Places<const D: usize> {
    /// At the points of the scene's Gauss rule, as (weight, λ). A point counts in part where its foot is nearer to the end of the master than
    /// the `outermost` point of the slave's facet is to that facet's sides.
    Gauss {
        points: Vec<(f64, Vector<D>)>,
        outermost: f64,
    },
    /// On pieces, by a rule of another degree than the solver's: in the plane that of these points, as (weight, λ).
    Pieces(Vec<(f64, Vector<D>)>),
}

impl<const D: usize> Places<D> {
    /// Those of a slave opposite a master. No point that looks for the closest one counts in part.
    pub fn new(
        integration: Integration,
        projection: Projection,
        slave: &Faces<D>,
        master: &Faces<D>,
    ) -> Self {
        let Integration::Gauss(count) = integration else {
            return Places::pieces(slave, master);
        };
        let points = gauss::<D>(count);
        let coordinates = points.iter().map(|(_, lambda)| lambda.min());
        let outermost = match projection {
            Projection::AlongNormals => coordinates.fold(1.0, f64::min),
            Projection::Closest => 0.0,
        };
        Places::Gauss { points, outermost }
    }

    /// Pieces between two boundaries.
    pub fn pieces(slave: &Faces<D>, master: &Faces<D>) -> Self {
        let is_linear = [slave, master].map(|own| own.order() == Order::Linear);
        let count = ON_PIECES[usize::from(is_linear != [true; 2])];
        Places::Pieces(gauss::<D>(count))
    }

    /// The share with which a point of a facet counts by the place of its foot.
    fn share(&self, (slave, facet): (&Faces<D>, usize), master: &Faces<D>, foot: &Foot<D>) -> f64 {
        match self {
            Places::Gauss { outermost, .. } if *outermost > 0.0 => {
                let ratio = slave.length(facet) / master.length_at(foot.facet, &foot.lambda);
                let full = (2.0 * outermost * ratio).min(1.0);
                (master.depth(foot.facet, &foot.lambda) / full).clamp(0.0, 1.0)
            }
            _ => 1.0,
        }
    }
}

/// The Gauss–Legendre rule of so many points, on a triangle that of a square collapsed at its first corner. Points and weights are
/// eigenvalues and eigenvectors of the recurrence of Legendre's polynomials (G. H. Golub and J. H. Welsch, *Calculation of
/// Gauss quadrature rules*, Math. Comp. 23, 1969).
fn gauss<const D: usize>(count: usize) -> Vec<(f64, Vector<D>)> {
    let recurrence = DMatrix::from_fn(count, count, |i, j| {
        let k = i.max(j) as f64;
        match i.abs_diff(j) {
            1 => k / (4.0 * k * k - 1.0).sqrt(),
            _ => 0.0,
        }
    })
    .symmetric_eigen();
    let line = (0..count).map(|k| {
        let first = recurrence.eigenvectors[(0, k)];
        (first * first, 0.5 * (1.0 + recurrence.eigenvalues[k]))
    });
    let line: Vec<(f64, f64)> = line.collect();
    let on_segment = |&(w, t): &(f64, f64)| {
        let lambda = Vector::from_fn(|i, _| if i == 0 { 1.0 - t } else { t });
        (w, lambda)
    };
    let on_triangle = |&(w, t): &(f64, f64)| {
        let at = move |s: f64| Vector::from_fn(|i, _| [1.0 - t, t * (1.0 - s), t * s][i]);
        line.iter().map(move |&(v, s)| (2.0 * w * v * t, at(s)))
    };
    match D {
        2 => line.iter().map(on_segment).collect(),
        _ => line.iter().flat_map(on_triangle).collect(),
    }
}

/// One facet of a slave whose points look for their feet.
pub(super) struct Slave<'a, const D: usize> {
    pub surfaces: (&'a Faces<D>, &'a Placed<'a, D>),
    pub facet: usize,
    /// The positions of its nodes.
    pub patch: Patch<D>,
    pub is_one_body: bool,
    pub reach: Reach,
    pub places: &'a Places<D>,
}

/// The cosine between normals at which a point counts in full, and the share of the search radius within which it loses its weight.
const FACING: f64 = 0.2;
const FAR: f64 = 0.1;

impl<const D: usize> Slave<'_, D> {
    fn point(&self, lambda: &Vector<D>) -> Point<D> {
        let [reference, _] = self.surfaces.0.reference(self.facet);
        Point {
            x: self.patch.at(lambda),
            facing: self.patch.normal(lambda),
            X: reference.at(lambda),
            N: reference.normal(lambda),
            own: self.is_one_body.then_some(self.facet),
        }
    }

    fn foot(&self, lambda: &Vector<D>) -> Option<Foot<D>> {
        feet::foot(self.surfaces, &self.point(lambda), self.reach)
    }

    /// The facet that the foot is on.
    fn opposite(&self, lambda: &Vector<D>) -> Option<usize> {
        self.foot(lambda).map(|foot| foot.facet)
    }

    /// The same between two places of which the feet are on these facets: they are tried first.
    fn opposite_between(&self, lambda: &Vector<D>, facets: [Option<usize>; 2]) -> Option<usize> {
        let point = self.point(lambda);
        let facets = facets.into_iter().flatten();
        let nearest = feet::nearest_of(self.surfaces.1, facets, &point, self.reach);
        let foot = nearest.or_else(|| feet::foot(self.surfaces, &point, self.reach));
        foot.map(|foot| foot.facet)
    }

    /// Adds the points of the facet, and tells whether all have a foot and count in full.
    pub fn add(&self, points: &mut Points<D>) -> bool {
        points.are_whole = true;
        match (self.places, D) {
            (Places::Gauss { points: rule, .. }, _) => {
                let rule = rule.iter();
                rule.for_each(|point| self.add_point(*point, None, points));
            }
            (Places::Pieces(rule), 2) => self.add_segment(rule, points),
            (Places::Pieces(_), _) => {
                let corners = std::array::from_fn(corner);
                let ends = corners.map(|lambda| self.opposite(&lambda));
                self.add_triangle(&corners, &ends, DIVISIONS, points);
            }
        }
        points.are_whole
    }

    /// Adds a point with a share of the facet. Where its foot is known to be on `facet`, no other is tried.
    fn add_point(
        &self,
        (share, lambda): (f64, Vector<D>),
        facet: Option<usize>,
        points: &mut Points<D>,
    ) {
        let known = facet.and_then(|facet| {
            let start = Vector::repeat(1.0 / D as f64);
            let x = self.patch.at(&lambda);
            feet::on(self.surfaces.1, facet, &x, (&start, 0.0))
        });
        let Some(foot) = known.or_else(|| self.foot(&lambda)) else {
            points.are_whole = false;
            return;
        };
        let facing = self.patch.normal(&lambda);
        let cosine = -facing.dot(&foot.normal) / facing.norm();
        let near = (self.reach.radius - foot.distance) / (FAR * self.reach.radius);
        let near = if near.is_nan() { 1.0 } else { near };
        let own = (self.surfaces.0, self.facet);
        let counts = (cosine / FACING).clamp(0.0, 1.0)
            * near.clamp(0.0, 1.0)
            * feet::seen(self.surfaces.1, &self.point(&lambda), &foot, self.reach)
            * self.places.share(own, self.surfaces.1.faces, &foot);
        let weight = share * counts * self.surfaces.0.measure(self.facet, &lambda);
        points.are_whole &= counts == 1.0;
        if weight > 0.0 {
            points.held.push(Held {
                facet: self.facet,
                lambda,
                weight,
                foot,
            });
        }
    }

    fn add_segment(&self, rule: &[(f64, Vector<D>)], points: &mut Points<D>) {
        let on = |t: f64| Vector::from_fn(|i, _| if i == 0 { 1.0 - t } else { t });
        let ends: [(f64, Option<usize>); PARTS + 1] = std::array::from_fn(|k| {
            let t = k as f64 / PARTS as f64;
            // a foot at a corner is on either side of it
            (t, self.opposite(&on(t.clamp(1e-7, 1.0 - 1e-7))))
        });
        let mut breaks = Vec::new();
        for part in ends.windows(2) {
            self.divide(&on, (part[0], part[1]), 0, &mut breaks);
        }
        breaks.push((1.0, ends[PARTS].1));
        let mut from = 0.0;
        for (to, facet) in breaks {
            for (weight, place) in rule {
                let there = on(from + place[1] * (to - from));
                self.add_point((weight * (to - from), there), facet, points);
            }
            from = to;
        }
    }

    /// Adds the places between two where the foot comes to another facet, each with the facet before it.
    fn divide(
        &self,
        on: &impl Fn(f64) -> Vector<D>,
        ((from, before), (to, after)): ((f64, Option<usize>), (f64, Option<usize>)),
        halved: usize,
        breaks: &mut Vec<(f64, Option<usize>)>,
    ) {
        if before == after {
            return;
        }
        let middle = 0.5 * (from + to);
        let is_end = before.is_none() || after.is_none();
        // the end of the boundary may be found to be none after halvings
        if halved >= HALVINGS[usize::from(is_end)] {
            breaks.push((middle, before));
            return;
        }
        let there = (middle, self.opposite_between(&on(middle), [before, after]));
        self.divide(on, ((from, before), there), halved + 1, breaks);
        self.divide(on, (there, (to, after)), halved + 1, breaks);
    }

    /// Adds the points of a part of a triangle, by λ of its corners and the facets opposite them. It is divided into four where these
    /// differ.
    fn add_triangle(
        &self,
        corners: &[Vector<D>; D],
        ends: &[Option<usize>; D],
        divisions: usize,
        points: &mut Points<D>,
    ) {
        let is_one = ends.iter().all(|end| *end == ends[0]);
        if is_one || divisions == 0 {
            let known = ends[0].filter(|_| is_one);
            let share = area(corners);
            for (weight, parts) in whole::<D>() {
                let mut lambda = Vector::<D>::zeros();
                let parts = parts.iter().zip(corners);
                parts.for_each(|(part, corner)| lambda += corner * *part);
                self.add_point((weight * share, lambda), known, points);
            }
            return;
        }
        let next = |k: usize| (k + 1) % D;
        let middles: [Vector<D>; D] =
            std::array::from_fn(|k| (corners[k] + corners[next(k)]) * 0.5);
        let between = middles.map(|lambda| self.opposite(&lambda));
        for k in 0..D {
            let last = (k + D - 1) % D;
            let part = std::array::from_fn(|j| match j {
                0 => corners[k],
                1 => middles[k],
                _ => middles[last],
            });
            let of_part = std::array::from_fn(|j| match j {
                0 => ends[k],
                1 => between[k],
                _ => between[last],
            });
            self.add_triangle(&part, &of_part, divisions - 1, points);
        }
        self.add_triangle(&middles, &between, divisions - 1, points);
    }
}

/// The points of a facet as a whole, as (weight, λ); the weights sum to 1.
pub(super) fn whole<const D: usize>() -> Vec<(f64, Vector<D>)> {
    let at =
        |k: usize, own: f64, other: f64| Vector::from_fn(|i, _| if i == k { own } else { other });
    match D {
        2 => gauss::<D>(ON_PIECES[1]),
        _ => {
            let all = TRIANGLE
                .iter()
                .flat_map(|rule| (0..D).map(move |k| (k, *rule)));
            all.map(|(k, (w, own))| (w, at(k, own, 0.5 * (1.0 - own))))
                .collect()
        }
    }
}

/// λ of a corner.
fn corner<const D: usize>(k: usize) -> Vector<D> {
    let mut lambda = Vector::zeros();
    lambda[k] = 1.0;
    lambda
}

/// The share of a facet that a part of it has, by λ of its corners.
fn area<const D: usize>(corners: &[Vector<D>; D]) -> f64 {
    let columns: [Vector<D>; D] = *corners;
    crate::tensor::determinant(&crate::tensor::Matrix::from_columns(&columns)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rules integrate what they claim, against integrals of monomials.
    #[test]
    fn rules_are_exact() {
        // ∫ λ_0^a λ_1^b = 2 a! b! / (a + b + 2)! of a triangle of measure 1
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let exact = |a: i32, b: i32| 2.0 * factorial(a) * factorial(b) / factorial(a + b + 2);
        let of_degree = |n: i32| (0..=n).flat_map(move |a| (0..=n - a).map(move |b| (a, b)));
        let sum = |points: &[(f64, Vector<3>)], a: i32, b: i32| -> f64 {
            let each = points.iter();
            each.map(|(w, at)| w * at[0].powi(a) * at[1].powi(b)).sum()
        };
        for (a, b) in of_degree(4) {
            let own = sum(&whole::<3>(), a, b);
            assert!((own - exact(a, b)).abs() < 1e-14, "{a} {b}: {own}");
        }
        for count in 1..=12 {
            let degree = 2 * count as i32 - 1;
            for (a, b) in of_degree(degree - 1) {
                let own = sum(&gauss::<3>(count), a, b);
                assert!((own - exact(a, b)).abs() < 1e-14, "{count}, {a} {b}: {own}");
            }
            for a in 0..=degree {
                let own = gauss::<2>(count).into_iter();
                let own: f64 = own.map(|(w, at)| w * at[1].powi(a)).sum();
                assert!((own - 1.0 / f64::from(a + 1)).abs() < 1e-14, "{count}, {a}");
            }
        }
    }
}
