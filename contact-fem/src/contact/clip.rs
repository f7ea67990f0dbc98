//! Clipping of triangles to the pieces that two facets have in common (I. E. Sutherland and G. W.
//! Hodgman, *Reentrant polygon clipping*, CACM 17, 1974).
//!
//! Points in a facet's plane are given by their barycentric coordinates. A simplex with such
//! corners has the measure det [a b …] as a share of the facet's; it is negative if the simplex is
//! reversed. A convex polygon is a slice of corners. A *shadow* is the projection of a facet of the
//! other surface on the plane; since that facet faces this one, the shadow is reversed.

use crate::tensor::{Matrix, Vector, determinant, unit_vector};

/// The smallest area or length of a piece, as a share of the facet's: smaller ones are round-off
/// and dropped. All clipping depends on it.
pub(super) const EMPTY: f64 = 1e-14;

/// Clips triangles and stores the remainder of one.
#[derive(Default)]
pub(super) struct Clipper<const D: usize> {
    /// The parts of the triangle that no shadow has covered so far.
    pub rest: Vec<[Vector<D>; D]>,
    before: Vec<[Vector<D>; D]>,
    polygon: Vec<Vector<D>>,
    inside: Vec<Vector<D>>,
    outside: Vec<Vector<D>>,
}

impl<const D: usize> Clipper<D> {
    /// The intersection of a triangle and a shadow: a convex polygon, or empty.
    pub fn clip(&mut self, triangle: &[Vector<D>; D], shadow: &[Vector<D>; D]) -> &[Vector<D>] {
        self.polygon.clear();
        self.polygon.extend(triangle);
        for side in 0..D {
            self.split(shadow, side);
            std::mem::swap(&mut self.polygon, &mut self.inside);
        }
        &self.polygon
    }

    /// Moves the intersection of the remainder and a shadow to `pieces`; returns its area.
    pub fn take(&mut self, shadow: &[Vector<D>; D], pieces: &mut Vec<[Vector<D>; D]>) -> f64 {
        let mut taken = 0.0;
        std::mem::swap(&mut self.rest, &mut self.before);
        self.rest.clear();
        while let Some(triangle) = self.before.pop() {
            if area(self.clip(&triangle, shadow)) <= EMPTY {
                self.rest.push(triangle);
                continue;
            }
            self.polygon.clear();
            self.polygon.extend(&triangle);
            for side in 0..D {
                self.split(shadow, side);
                self.rest.extend(triangles(&self.outside).filter(is_full));
                std::mem::swap(&mut self.polygon, &mut self.inside);
            }
            let before = pieces.len();
            pieces.extend(triangles(&self.polygon).filter(is_full));
            taken += pieces[before..].iter().map(measure).sum::<f64>();
        }
        taken
    }

    /// Splits the polygon along the side of `shadow` opposite its corner `side`.
    fn split(&mut self, shadow: &[Vector<D>; D], side: usize) {
        let depth = |x: &Vector<D>| {
            let mut corners = *shadow;
            corners[side] = *x;
            -measure(&corners)
        };
        self.inside.clear();
        self.outside.clear();
        let Some(mut p) = self.polygon.last() else {
            return;
        };
        let mut at_p = depth(p);
        for q in &self.polygon {
            let at_q = depth(q);
            if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
                let between = p + (q - p) * (at_p / (at_p - at_q));
                self.inside.push(between);
                self.outside.push(between);
            }
            if at_q >= 0.0 {
                self.inside.push(*q);
            }
            if at_q <= 0.0 {
                self.outside.push(*q);
            }
            (p, at_p) = (q, at_q);
        }
    }
}

/// The corners of the whole facet.
pub(super) fn corners<const D: usize>() -> [Vector<D>; D] {
    std::array::from_fn(unit_vector)
}

/// The measure of a simplex, negative if it is reversed.
pub(super) fn measure<const D: usize>(corners: &[Vector<D>; D]) -> f64 {
    determinant(&Matrix::from_columns(corners))
}

/// Whether the area of a simplex exceeds round-off.
fn is_full<const D: usize>(corners: &[Vector<D>; D]) -> bool {
    measure(corners) > EMPTY
}

/// The triangles between a convex polygon's first corner and its sides.
fn triangles<const D: usize>(polygon: &[Vector<D>]) -> impl Iterator<Item = [Vector<D>; D]> {
    let sides = polygon.windows(2).skip(1);
    sides.map(|side| std::array::from_fn(|k| if k == 0 { polygon[0] } else { side[k - 1] }))
}

/// The area of a convex polygon.
pub(super) fn area<const D: usize>(polygon: &[Vector<D>]) -> f64 {
    triangles(polygon).map(|triangle| measure(&triangle)).sum()
}

/// The centroid of a convex polygon; NaN if it is empty.
pub(super) fn centroid<const D: usize>(polygon: &[Vector<D>]) -> Vector<D> {
    let moment = |t: [Vector<D>; D]| t.iter().sum::<Vector<D>>() * (measure(&t) / D as f64);
    triangles(polygon).map(moment).sum::<Vector<D>>() / area(polygon)
}

/// Divides a convex polygon into triangles that meet at its centroid, without empty ones; returns
/// their area. The quadrature then depends continuously on the polygon, also where a side vanishes
/// or a corner is repeated; the fixed-point iteration needs this to converge.
pub(super) fn fan<const D: usize>(polygon: &[Vector<D>], pieces: &mut Vec<[Vector<D>; D]>) -> f64 {
    if !(area(polygon) > EMPTY) {
        return 0.0;
    }
    let middle = centroid(polygon);
    let before = pieces.len();
    let next = polygon.iter().cycle().skip(1);
    let around = polygon.iter().zip(next);
    let corner = |k: usize, (a, b): (&Vector<D>, &Vector<D>)| [middle, *a, *b][k];
    let triangles = around.map(|side| std::array::from_fn(|k| corner(k, side)));
    pieces.extend(triangles.filter(is_full));
    pieces[before..].iter().map(measure).sum()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A reproducible sequence of numbers in [0, 1).
    pub(in super::super) struct Random(pub u64);

    impl Random {
        pub fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        /// A random shadow around the facet. Every second one is on a lattice, where corners and
        /// sides coincide.
        pub fn shadow(&mut self) -> [Vector<3>; 3] {
            let lattice = self.next() < 0.5;
            let mut coordinate = || {
                let c = 2.0 * self.next() - 0.5;
                if lattice { (4.0 * c).round() / 4.0 } else { c }
            };
            let mut corner = || at(coordinate(), coordinate());
            let [a, b, c] = [corner(), corner(), corner()];
            match measure(&[a, b, c]) {
                area if area < -EMPTY => [a, b, c],
                area if area > EMPTY => [a, c, b],
                _ => self.shadow(),
            }
        }
    }

    pub(in super::super) fn at(s: f64, t: f64) -> Vector<3> {
        Vector::<3>::new(1.0 - s - t, s, t)
    }

    /// The area of the intersection of two triangles, by integration over cross-sections: their
    /// width is linear between the abscissae of corners and of intersections of sides.
    pub(in super::super) fn shared_area(a: &[Vector<3>; 3], b: &[Vector<3>; 3]) -> f64 {
        let sides = |t: &[Vector<3>; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let height =
            |[p, q]: [Vector<3>; 2], s: f64| p[2] + (q[2] - p[2]) * (s - p[1]) / (q[1] - p[1]);
        let range = |t: &[Vector<3>; 3], s: f64| {
            let over = |side: &[Vector<3>; 2]| (side[0][1] - s) * (side[1][1] - s) < 0.0;
            let heights = sides(t)
                .into_iter()
                .filter(over)
                .map(|side| height(side, s));
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
                (low.min(h), high.max(h))
            })
        };
        let mut events: Vec<f64> = a.iter().chain(b).map(|x| x[1]).collect();
        for p in sides(a) {
            for q in sides(b) {
                let slope =
                    |side: [Vector<3>; 2]| (side[1][2] - side[0][2]) / (side[1][1] - side[0][1]);
                let s = p[0][1] + (height(q, p[0][1]) - p[0][2]) / (slope(p) - slope(q));
                if s.is_finite() {
                    events.push(s);
                }
            }
        }
        events.sort_by(f64::total_cmp);
        let strip = |pair: &[f64]| {
            let middle = 0.5 * (pair[0] + pair[1]);
            let ((low, high), (bottom, top)) = (range(a, middle), range(b, middle));
            (pair[1] - pair[0]) * (high.min(top) - low.max(bottom)).max(0.0)
        };
        // the facet's own area is 1/2 in these coordinates
        2.0 * events.windows(2).map(strip).sum::<f64>()
    }

    #[test]
    fn a_million_random_pairs() {
        let mut random = Random(7);
        let mut clipper = Clipper::<3>::default();
        let (mut pieces, mut empty) = (Vec::new(), 0);
        for k in 0..1_000_000 {
            let shadow = random.shadow();
            let clipped = area(clipper.clip(&corners(), &shadow));
            let expected = shared_area(&corners(), &shadow);
            assert!(
                (clipped - expected).abs() < 1e-12,
                "{k}: {clipped} {expected} {shadow:?}"
            );
            pieces.clear();
            let kept = fan(&clipper.polygon, &mut pieces);
            assert!((kept - expected).abs() < 1e-12 && pieces.iter().all(|p| measure(p) > 0.0));
            empty += usize::from(expected == 0.0);
        }
        assert!(empty > 50_000 && empty < 950_000, "{empty} empty");
    }
}
