//! The surfaces of obstacles as pieces to draw: segments in the plane, flat convex polygons in space.
//!
//! Straight shapes are cut exactly, so that their corners stay. Round ones are chords, fine enough for a picture, and the level
//! set of a user's own distance is found in the simplices of a grid.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::{Obstacle, Shape};
use crate::program::Pose;
use crate::tensor::{Vector, facet_normal, unit_vector};

/// A part of a surface: the corners of a segment, whose right side is outside, or of a polygon, counter-clockwise seen from
/// outside (UL).
pub(crate) type Piece<const D: usize> = Vec<Vector<D>>;

/// The box in which surfaces are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame<const D: usize> {
    pub low: Vector<D>,
    pub high: Vector<D>,
}

impl<const D: usize> Frame<D> {
    /// The room around bodies, as a share of their largest extent, in the plane and in space.
    const MARGINS: [f64; 2] = [0.08, 0.2];

    /// The box around points, a little larger; `None` if there are none that are finite.
    pub fn around(points: impl Iterator<Item = Vector<D>>) -> Option<Self> {
        let finite = points.filter(|x| x.iter().all(|value| value.is_finite()));
        let ends = finite.map(|x| (x, x));
        let (low, high) = ends.reduce(|(a, b), (c, d)| (a.inf(&c), b.sup(&d)))?;
        let margin = Vector::repeat(Self::MARGINS[D - 2] * (high - low).max());
        Some(Frame {
            low: low - margin,
            high: high + margin,
        })
    }

    /// The part of a piece within the frame.
    pub fn cut(&self, mut piece: Piece<D>) -> Option<Piece<D>> {
        for axis in 0..D {
            piece = part_where(&piece, |x| x[axis] - self.low[axis]);
            piece = part_where(&piece, |x| self.high[axis] - x[axis]);
        }
        piece.dedup();
        if D > 2 && piece.len() > 1 && piece[0] == piece[piece.len() - 1] {
            piece.pop();
        }
        (piece.len() >= D).then_some(piece)
    }
}

/// The part of a segment, or of a convex polygon, on which a linear function is not negative.
fn part_where<const D: usize>(piece: &[Vector<D>], of: impl Fn(&Vector<D>) -> f64) -> Piece<D> {
    let mut part = Vec::new();
    for (k, x) in piece.iter().enumerate() {
        let here = of(x);
        if here >= 0.0 {
            part.push(*x);
        }
        let Some(y) = piece.get(k + 1).or(piece.first().filter(|_| D > 2)) else {
            continue;
        };
        let there = of(y);
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            part.push(x + (y - x) * (here / (here - there)));
        }
    }
    part
}

/// The ball around a frame, in the obstacle's own coordinates.
struct Near<const D: usize> {
    centre: Vector<D>,
    radius: f64,
}

impl<const D: usize> Obstacle<D> {
    /// What of the surface is within a frame where `pose` has taken the obstacle.
    pub(crate) fn outline(&self, pose: &Pose<D>, frame: &Frame<D>) -> Vec<Piece<D>> {
        let near = Near {
            centre: pose.back(&((frame.low + frame.high) * 0.5)),
            radius: (frame.high - frame.low).norm() * 0.5,
        };
        if !(pose.is_finite() && near.radius.is_finite()) {
            return Vec::new();
        }
        let pieces = match &self.shape {
            Shape::HalfSpace { point, normal } => {
                let above = (near.centre - point).dot(normal);
                let arms = across(normal).map(|arm| arm * near.radius);
                vec![face(near.centre - normal * above, normal, &arms[..D - 1])]
            }
            Shape::Round {
                centre,
                axis,
                radius,
                sign,
            } => Round::new(centre, axis, *radius, &near).pieces(*sign),
            Shape::Cuboid { centre, half } => faces(centre, half),
            Shape::Surface(surface) => surface.facets().map(|facet| facet.to_vec()).collect(),
            Shape::Given(distance) => level_set(&**distance, &near),
        };
        let placed = |piece: Piece<D>| piece.iter().map(|x| pose.place(x)).collect();
        let placed = pieces.into_iter().map(placed);
        placed.filter_map(|piece| frame.cut(piece)).collect()
    }
}

/// Unit vectors across a unit vector, and each other; in the plane the first one alone counts.
fn across<const D: usize>(n: &Vector<D>) -> [Vector<D>; 2] {
    let mut corners = [Vector::<D>::zeros(); D];
    if D == 2 {
        let along = Vector::from_fn(|i, _| if i == 0 { -n[1] } else { n[0] });
        return [along, Vector::zeros()];
    }
    let axis = unit_vector::<D>(n.iamin());
    let first = (axis - n * n.dot(&axis)).normalize();
    corners[1] = *n;
    corners[2] = first;
    [first, facet_normal(&corners).normalize()]
}

/// The segment or the rectangle around `middle` with a normal, that reaches as far as `arms` to all sides.
fn face<const D: usize>(middle: Vector<D>, normal: &Vector<D>, arms: &[Vector<D>]) -> Piece<D> {
    let corners = match arms {
        [arm] => vec![middle - arm, middle + arm],
        [a, b, ..] => vec![
            middle - a - b,
            middle + a - b,
            middle + a + b,
            middle - a + b,
        ],
        [] => Vec::new(),
    };
    facing(corners, normal)
}

/// The piece in the order in which its normal is on the side of `normal`.
fn facing<const D: usize>(mut piece: Piece<D>, normal: &Vector<D>) -> Piece<D> {
    if outward(&piece).dot(normal) < 0.0 {
        piece.reverse();
    }
    piece
}

/// The outward normal of a piece; its length is the piece's measure (UL or UL²).
pub(crate) fn outward<const D: usize>(piece: &[Vector<D>]) -> Vector<D> {
    let Some(first) = piece.first() else {
        return Vector::zeros();
    };
    let fans = piece[1..].windows(D - 1);
    fans.map(|others| {
        facet_normal(&std::array::from_fn(|k| {
            if k == 0 { *first } else { others[k - 1] }
        }))
    })
    .sum()
}

/// The faces of a box.
fn faces<const D: usize>(centre: &Vector<D>, half: &Vector<D>) -> Vec<Piece<D>> {
    let axes = (0..D).flat_map(|i| [(i, 1.0), (i, -1.0)]);
    let of = |(i, sign): (usize, f64)| {
        let normal = unit_vector::<D>(i) * sign;
        let others = (1..D).map(|k| (i + k) % D);
        let arms: Vec<_> = others.map(|j| unit_vector::<D>(j) * half[j]).collect();
        face(centre + normal * half[i], &normal, &arms)
    };
    axes.map(of).collect()
}

/// A circle, a sphere or a cylinder by angles: longitude, and on a sphere latitude.
struct Round<'a, const D: usize> {
    centre: Vector<D>,
    /// Across the axis, two vectors; then the axis.
    axes: [Vector<D>; 3],
    is_cylinder: bool,
    radius: f64,
    /// No chord spans a larger angle.
    step: f64,
    near: &'a Near<D>,
}

impl<'a, const D: usize> Round<'a, D> {
    /// The largest angle of a chord, in the plane and in space.
    const STEPS: [f64; 2] = [TAU / 128.0, TAU / 64.0];
    /// How far chords may be from arcs, as a share of the frame's radius.
    const SAG: f64 = 2e-4;

    fn new(centre: &Vector<D>, axis: &Vector<D>, radius: f64, near: &'a Near<D>) -> Self {
        let is_cylinder = axis.norm() > 0.0;
        let axis = match is_cylinder {
            true => *axis,
            false => unit_vector(D - 1),
        };
        let [first, second] = match D {
            2 => [unit_vector(0), unit_vector(1)],
            _ => across(&axis),
        };
        // the cylinder is as long as what is near
        let along = (near.centre - centre).dot(&axis);
        let by_sag = (8.0 * Self::SAG * near.radius / radius).sqrt();
        Round {
            centre: match is_cylinder {
                true => centre + axis * along,
                false => *centre,
            },
            axes: [first, second, axis],
            is_cylinder,
            radius,
            // a finer one would be round-off
            step: Self::STEPS[D - 2].min(by_sag).max(1e-8),
            near,
        }
    }

    fn at(&self, longitude: f64, latitude: f64) -> Vector<D> {
        let [first, second, axis] = &self.axes;
        let (sin, cos) = longitude.sin_cos();
        let around = (first * cos + second * sin) * self.radius;
        self.centre
            + match (D, self.is_cylinder) {
                (2, _) => around,
                (_, true) => around + axis * (latitude / FRAC_PI_2 * self.near.radius),
                (_, false) => around * latitude.cos() + axis * (self.radius * latitude.sin()),
            }
    }

    /// The chords near the frame; with `sign` −1 those of a cavity.
    fn pieces(&self, sign: f64) -> Vec<Piece<D>> {
        let mut pieces = Vec::new();
        let latitudes = match D == 3 && !self.is_cylinder {
            true => vec![[-FRAC_PI_2, 0.0], [0.0, FRAC_PI_2]],
            false => vec![[-FRAC_PI_2, FRAC_PI_2]],
        };
        for quarter in 0..4 {
            let longitude = [0, 1].map(|k| f64::from(quarter + k) * 0.25 * TAU);
            for latitude in &latitudes {
                self.collect(longitude, *latitude, sign, &mut pieces);
            }
        }
        pieces
    }

    fn collect(
        &self,
        [west, east]: [f64; 2],
        [south, north]: [f64; 2],
        sign: f64,
        pieces: &mut Vec<Piece<D>>,
    ) {
        let middle = self.at(0.5 * (west + east), 0.5 * (south + north));
        let is_sphere = D == 3 && !self.is_cylinder;
        let arc = match is_sphere {
            true => (east - west) + (north - south),
            false => east - west,
        };
        let reach = self.near.radius + 0.5 * arc.min(TAU) * self.radius;
        let mut way = middle - self.near.centre;
        if self.is_cylinder {
            way -= self.axes[2] * self.axes[2].dot(&way);
        }
        if way.norm() > reach {
            return;
        }
        if east - west > self.step {
            let [half, height] = [0.5 * (west + east), 0.5 * (south + north)];
            let latitudes = match is_sphere {
                true => vec![[south, height], [height, north]],
                false => vec![[south, north]],
            };
            for longitude in [[west, half], [half, east]] {
                for latitude in &latitudes {
                    self.collect(longitude, *latitude, sign, pieces);
                }
            }
            return;
        }
        let mut piece = match D {
            2 => vec![self.at(west, 0.0), self.at(east, 0.0)],
            _ => vec![
                self.at(west, south),
                self.at(east, south),
                self.at(east, north),
                self.at(west, north),
            ],
        };
        piece.dedup();
        let mut out = middle - self.centre;
        if self.is_cylinder {
            out -= self.axes[2] * self.axes[2].dot(&out);
        }
        pieces.push(facing(piece, &(out * sign)));
    }
}

/// The zeros of a function in the simplices of a grid over what is near.
fn level_set<const D: usize>(of: &dyn Fn(&Vector<D>) -> f64, near: &Near<D>) -> Vec<Piece<D>> {
    /// Cells along an axis, in the plane and in space.
    const CELLS: [usize; 2] = [160, 28];
    let cells = CELLS[D - 2];
    let side = 2.0 * near.radius / cells as f64;
    let place = |node: [usize; D]| {
        let steps = Vector::<D>::from_fn(|i, _| node[i] as f64 - 0.5 * cells as f64);
        near.centre + steps * side
    };
    let digits = |mut number: usize, base: usize| {
        std::array::from_fn(|_| {
            let digit = number % base;
            number /= base;
            digit
        })
    };
    let count = |base: usize| base.pow(D as u32);
    let nodes: Vec<(Vector<D>, f64)> = (0..count(cells + 1))
        .map(|number| place(digits(number, cells + 1)))
        .map(|x| (x, of(&x)))
        .collect();
    let orders = orders::<D>();
    let mut pieces = Vec::new();
    for cell in 0..count(cells) {
        let low: [usize; D] = digits(cell, cells);
        for order in &orders {
            // a simplex goes from the lowest corner of the cell to the highest, along the axes in this order
            let mut node = low;
            let number =
                |node: &[usize; D]| node.iter().rev().fold(0, |sum, k| sum * (cells + 1) + k);
            let mut corners = vec![nodes[number(&node)]];
            for &axis in order {
                node[axis] += 1;
                corners.push(nodes[number(&node)]);
            }
            pieces.extend(zeros_of(of, &corners));
        }
    }
    pieces
}

/// All orders of the axes.
fn orders<const D: usize>() -> Vec<Vec<usize>> {
    (0..D).fold(vec![Vec::new()], |orders, _| {
        let longer = |order: Vec<usize>| {
            let others = (0..D)
                .filter(|axis| !order.contains(axis))
                .collect::<Vec<_>>();
            others
                .into_iter()
                .map(move |axis| [&order[..], &[axis]].concat())
        };
        orders.into_iter().flat_map(longer).collect()
    })
}

/// The zeros of a function in a simplex, on whose corners its values are known.
fn zeros_of<const D: usize>(
    of: &dyn Fn(&Vector<D>) -> f64,
    corners: &[(Vector<D>, f64)],
) -> Option<Piece<D>> {
    let (inside, outside): (Vec<_>, Vec<_>) = corners.iter().partition(|(_, d)| *d < 0.0);
    if inside.is_empty() || outside.is_empty() {
        return None;
    }
    let mut piece = Vec::new();
    for (k, a) in inside.iter().enumerate() {
        let mut own: Vec<_> = outside.iter().map(|b| zero_between(of, *a, *b)).collect();
        // around a quadrilateral
        if k % 2 == 1 {
            own.reverse();
        }
        piece.extend(own);
    }
    let mean =
        |of: &[(Vector<D>, f64)]| of.iter().map(|(x, _)| *x).sum::<Vector<D>>() / of.len() as f64;
    let piece = facing(piece, &(mean(&outside) - mean(&inside)));
    let is_finite = piece
        .iter()
        .all(|x| x.iter().all(|value| value.is_finite()));
    is_finite.then_some(piece)
}

/// The zero between two points, where the function is negative and where it is not: by false position, which is exact at once
/// where the function is linear.
fn zero_between<const D: usize>(
    of: &dyn Fn(&Vector<D>) -> f64,
    (mut a, mut at_a): (Vector<D>, f64),
    (mut b, mut at_b): (Vector<D>, f64),
) -> Vector<D> {
    let small = 1e-12 * (b - a).norm();
    let mut x = b;
    for _ in 0..40 {
        x = a + (b - a) * (at_a / (at_a - at_b));
        let here = of(&x);
        if !(here.abs() > small) {
            break;
        }
        // the value of an end that stays counts half, lest it stay for ever
        match here < 0.0 {
            true => (a, at_a, at_b) = (x, here, 0.5 * at_b),
            false => (b, at_b, at_a) = (x, here, 0.5 * at_a),
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::Motion;

    fn unit<const D: usize>() -> Frame<D> {
        Frame {
            low: Vector::repeat(-1.0),
            high: Vector::repeat(1.0),
        }
    }

    fn length(pieces: &[Piece<2>]) -> f64 {
        pieces
            .iter()
            .map(|piece| (piece[1] - piece[0]).norm())
            .sum()
    }

    fn area(pieces: &[Piece<3>]) -> f64 {
        pieces.iter().map(|piece| outward(piece).norm()).sum()
    }

    /// By hand: the line y = x/2 + 1/4 leaves the square at (−1, −1/4) and (1, 3/4), moved up by a half at (−1, 1/4) and (1/2, 1).
    #[test]
    fn a_half_space_crosses_the_frame() {
        let line = Obstacle::half_space([0.0, 0.25], [-1.0, 2.0]).expect("a half-space");
        let up = Motion::translation([0.0, 0.5]).expect("a motion").pose(1.0);
        for (pose, ends) in [
            (Pose::rest(), [[-1.0, -0.25], [1.0, 0.75]]),
            (up, [[-1.0, 0.25], [0.5, 1.0]]),
        ] {
            let outline = line.outline(&pose, &unit());
            let [piece] = &outline[..] else {
                panic!("{outline:?}");
            };
            // the outside is above, to the right of who goes left
            for (x, end) in piece.iter().zip([ends[1], ends[0]]) {
                assert!((x - Vector::from(end)).norm() < 1e-14, "{piece:?}");
            }
        }
        let far = Obstacle::half_space([0.0, 5.0], [0.0, 1.0]).expect("a half-space");
        assert!(far.outline(&Pose::rest(), &unit()).is_empty());
    }

    /// x + y + z ≤ 1 leaves an equilateral triangle's complement in the cube: the plane through (1, 1, −1) and its like has sides 2√2.
    #[test]
    fn a_half_space_crosses_the_box() {
        let plane = Obstacle::half_space([1.0, 0.0, 0.0], [1.0; 3]).expect("a half-space");
        let outline = plane.outline(&Pose::rest(), &unit());
        assert_eq!((outline.len(), outline[0].len()), (1, 3));
        assert!((area(&outline) - 2.0 * 3f64.sqrt()).abs() < 1e-12);
        assert!(outward(&outline[0]).dot(&Vector::repeat(1.0)) > 0.0);
    }

    /// Corners stay corners: a square of side 1 that is turned by an eighth of a turn has its corners √½ from its centre.
    #[test]
    fn corners_are_exact() {
        let square = Obstacle::cuboid([-0.5; 2], [0.5; 2]).expect("a box");
        let turn = Motion::<2>::rotation([0.0; 2], FRAC_PI_2 / 2.0).expect("a turn");
        let outline = square.outline(&turn.pose(1.0), &unit());
        assert_eq!(outline.len(), 4);
        for x in outline.iter().flatten() {
            let off = (x[0].abs() + x[1].abs() - 0.5f64.sqrt()).abs();
            assert!(off < 1e-15 && x[0].abs().min(x[1].abs()) < 1e-15, "{x}");
        }
        let cube = Obstacle::cuboid([-0.5; 3], [0.5; 3]).expect("a box");
        assert!((area(&cube.outline(&Pose::rest(), &unit())) - 6.0).abs() < 1e-14);
        // half of the box is beyond the frame
        let beyond = Obstacle::cuboid([0.5, -0.5, -0.5], [1.5, 0.5, 0.5]).expect("a box");
        assert!((area(&beyond.outline(&Pose::rest(), &unit())) - 3.0).abs() < 1e-14);
        let corners = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]];
        let wedge = Obstacle::surface(&corners, &[[0, 1], [1, 2], [2, 0]]).expect("a wedge");
        let outline = wedge.outline(&Pose::rest(), &unit());
        let expected = corners.map(Vector::from);
        let sides: Vec<Piece<2>> = (0..3)
            .map(|k| vec![expected[k], expected[(k + 1) % 3]])
            .collect();
        assert_eq!(outline, sides);
    }

    /// Lengths and areas of what is round, whole and in part, and its outside.
    #[test]
    fn round_shapes_have_their_size() {
        let ok = |shape: Result<Obstacle<2>, _>| shape.expect("a shape");
        for (shape, expected) in [
            (ok(Obstacle::ball([0.0; 2], 0.5)), PI),
            (ok(Obstacle::cavity([0.0; 2], 0.5)), PI),
            // a quarter of the circle is in the frame
            (ok(Obstacle::ball([1.0, 1.0], 0.5)), PI / 4.0),
            // a small one, and nearly a line: the chord between x = ±1 and its sag
            (ok(Obstacle::ball([0.3, 0.0], 1e-4)), TAU * 1e-4),
            (ok(Obstacle::ball([0.0, -1e6], 1e6)), 2.0),
        ] {
            let outline = shape.outline(&Pose::rest(), &unit());
            let error = (length(&outline) / expected - 1.0).abs();
            assert!(error < 1e-3, "{shape:?}: {error}");
            check(&shape, &outline, 1e-3);
        }
        let ok = |shape: Result<Obstacle<3>, _>| shape.expect("a shape");
        for (shape, expected) in [
            (ok(Obstacle::ball([0.0; 3], 0.5)), PI),
            (ok(Obstacle::cavity([0.0; 3], 0.5)), PI),
            (ok(Obstacle::cylinder([0.0; 3], [0.0, 2.0, 0.0], 0.5)), TAU),
            (
                ok(Obstacle::bore([0.0, 9.0, 0.0], [0.0, 1.0, 0.0], 0.5)),
                TAU,
            ),
        ] {
            let outline = shape.outline(&Pose::rest(), &unit());
            let error = (area(&outline) / expected - 1.0).abs();
            assert!(error < 3e-3, "{shape:?}: {error}");
            check(&shape, &outline, 2e-3);
        }
        let given = Obstacle::signed_distance(|x: &Vector<2>| 0.5 - x.norm());
        let outline = given.outline(&Pose::rest(), &unit());
        assert!((length(&outline) / PI - 1.0).abs() < 1e-3);
        check(&given, &outline, 1e-10);
        let given = Obstacle::signed_distance(|x: &Vector<3>| x.norm() - 0.5);
        let outline = given.outline(&Pose::rest(), &unit());
        assert!((area(&outline) / PI - 1.0).abs() < 2e-2);
        check(&given, &outline, 1e-10);
    }

    /// Points are at distance 0 from the obstacle, and normals point where the distance grows.
    fn check<const D: usize>(shape: &Obstacle<D>, outline: &[Piece<D>], off: f64) {
        assert!(!outline.is_empty());
        for piece in outline {
            let distance = |x: &Vector<D>| shape.distance(x);
            assert!(piece.iter().all(|x| distance(x).abs() < off), "{piece:?}");
            let middle = piece.iter().sum::<Vector<D>>() / piece.len() as f64;
            let n = outward(piece);
            // slivers have no normal
            if n.norm() > 1e-12 {
                let ahead = distance(&(middle + n.normalize() * 1e-5));
                assert!(ahead > distance(&middle), "{piece:?}");
            }
        }
    }

    #[test]
    fn distances_that_are_no_numbers_have_no_surface() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let odd = Obstacle::signed_distance(
                move |x: &Vector<2>| if x[0] < 0.0 { value } else { 1.0 },
            );
            let outline = odd.outline(&Pose::rest(), &unit());
            let mut places = outline.iter().flatten().flat_map(|x| x.iter());
            assert!(places.all(|value| value.is_finite()));
        }
    }
}
