//! Bodies inside rigid obstacles, and obstacles inside bodies.

use crate::contact::Obstacle;
use crate::program::Pose;
use crate::tensor::{Matrix, Vector, inverse_transpose, unit_vector};

/// An obstacle, and the bodies that it may hold.
pub(super) struct Blocks<const D: usize> {
    pub obstacle: Obstacle<D>,
    /// Where it is.
    pub pose: Pose<D>,
    pub bodies: Vec<bool>,
}

impl<const D: usize> Blocks<D> {
    /// The deepest point of a flat face inside, with its depth (UL).
    pub fn deepest(&self, corners: [Vector<D>; D]) -> Option<(f64, Vector<D>)> {
        let corners = corners.map(|x| self.pose.back(&x));
        let (depth, at) = deepest(corners, &self.obstacle)?;
        Some((depth, self.pose.place(&at)))
    }

    /// A point of a flat cell, given by its first D + 1 corners, in the core of the obstacle, as [`core`], with its depth (UL).
    pub fn core(&self, corners: [Vector<D>; 4]) -> Option<(f64, Vector<D>)> {
        let corners = corners.map(|x| self.pose.back(&x));
        let (depth, at) = core(&corners[..=D], &self.obstacle)?;
        Some((depth, self.pose.place(&at)))
    }
}

/// The core of an obstacle are the points whose nearest point on its surface is not unique: the centre of a ball, the middle plane
/// of a plate. A half-space has none. Faces show how deep a body is in an obstacle as long as its core is not within the
/// body: along the way out of the body, the depth grows.
///
/// The result is a point of a cell near the core, with its depth (UL). It is looked for on the line from the cell's centroid to
/// the nearest point of the surface, and further; `None` if that line has left the cell before it meets the core, or
/// is outside the obstacle.
fn core<const D: usize>(corners: &[Vector<D>], obstacle: &Obstacle<D>) -> Option<(f64, Vector<D>)> {
    let from = corners.iter().sum::<Vector<D>>() / corners.len() as f64;
    let radius = corners.iter().map(|x| (x - from).norm());
    let radius = radius.fold(0.0, f64::max);
    let distance = obstacle.distance(&from);
    if !(distance < radius && radius.is_finite()) {
        return None; // at most as far as the cell reaches
    }
    let inside =
        |at: Vector<D>| Some((-obstacle.distance(&at), at)).filter(|(depth, _)| *depth > 0.0);
    let step = STEP * radius;
    let slope = Vector::<D>::from_fn(|i, _| {
        let to = unit_vector::<D>(i) * step;
        (obstacle.distance(&(from + to)) - obstacle.distance(&(from - to))) / (2.0 * step)
    });
    let Some(away) = slope.try_normalize(FLAT) else {
        return inside(from); // the slope is 1, except in the core
    };
    let way = leaving(corners, &from, &-away)?;
    // the distance falls by the way to the core, and rises by as much beyond it where the core is a point or a plane
    let excess = obstacle.distance(&(from - away * way)) - (distance - way);
    if !(excess > TURNS * radius) {
        return None;
    }
    let turn = (way - 0.5 * excess).max(0.0);
    let parts = (0..=PARTS).map(|k| way * f64::from(k) / f64::from(PARTS));
    let points = parts
        .chain([turn])
        .filter_map(|way| inside(from - away * way));
    points.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The step of differences of distances, as a share of the cell's size.
const STEP: f64 = 1e-5;
/// A slope as small as this is that of a place in the core.
const FLAT: f64 = 0.5;
/// How much more than by round-off and differences a distance differs from the way to the nearest point, as a share of the cell's
/// size, where the nearest point has changed.
const TURNS: f64 = 1e-6;
/// So many parts of a line are looked at where the core is neither a point nor a plane.
const PARTS: u32 = 8;

/// The way along a unit vector from the centroid of a simplex to where it leaves it (UL); `None` if it has no volume.
fn leaving<const D: usize>(
    corners: &[Vector<D>],
    from: &Vector<D>,
    along: &Vector<D>,
) -> Option<f64> {
    let columns: [_; D] = std::array::from_fn(|i| corners[i + 1] - corners[0]);
    let inverse = inverse_transpose(&Matrix::from_columns(&columns)).transpose();
    let [weights, change] = [inverse * (from - corners[0]), inverse * along];
    let first = (1.0 - weights.sum(), -change.sum());
    let all = weights
        .iter()
        .copied()
        .zip(change.iter().copied())
        .chain([first]);
    let falling = all.filter(|(_, change)| *change < 0.0);
    let way = falling.map(|(weight, change)| weight / -change);
    Some(way.fold(f64::INFINITY, f64::min)).filter(|way| way.is_finite())
}

/// The smallest depth that is found wherever it is on a face, as a share of the face's longest edge. At nodes all are.
const SEEN: f64 = 0.05;

/// The deepest point of a flat face inside an obstacle, with its depth (UL); `None` if it is outside. A point that is
/// r away from another is at most r deeper: where that cannot matter, the face is not divided further.
fn deepest<const D: usize>(
    corners: [Vector<D>; D],
    obstacle: &Obstacle<D>,
) -> Option<(f64, Vector<D>)> {
    let mut found: Option<(f64, Vector<D>)> = None;
    let mut see = |x: &Vector<D>| {
        let depth = -obstacle.distance(x);
        if depth > found.map_or(0.0, |(deepest, _)| deepest) {
            found = Some((depth, *x));
        }
        (depth, found.map_or(0.0, |(deepest, _)| deepest))
    };
    corners.iter().for_each(|x| {
        see(x);
    });
    let (_, size) = longest_edge(&corners);
    let mut open = vec![corners];
    while let Some(corners) = open.pop() {
        let middle = corners.iter().sum::<Vector<D>>() / D as f64;
        let radius = corners.iter().map(|x| (x - middle).norm());
        let radius = radius.fold(0.0, f64::max);
        let (depth, deepest) = see(&middle);
        // what is not finite is not divided
        let matters = radius > SEEN * size && depth + radius > deepest + SEEN * size;
        if !(matters && radius.is_finite()) {
            continue;
        }
        let ([i, j], _) = longest_edge(&corners);
        let half = (corners[i] + corners[j]) * 0.5;
        if half == corners[i] || half == corners[j] {
            continue; // there is no number between them
        }
        for end in [i, j] {
            let mut part = corners;
            part[end] = half;
            open.push(part);
        }
    }
    found
}

/// The ends of the longest edge of a face, and its length (UL).
fn longest_edge<const D: usize>(corners: &[Vector<D>; D]) -> ([usize; 2], f64) {
    let pairs = (0..D).flat_map(|i| (0..i).map(move |j| [i, j]));
    let lengths = pairs.map(|[i, j]| ([i, j], (corners[i] - corners[j]).norm()));
    lengths.fold(([0, 1], 0.0), |a, b| if b.1 > a.1 { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 0.3 just through the middle of a triangle with edges of 2, away from all its nodes; and beside it.
    #[test]
    fn a_ball_between_the_nodes_of_a_face() {
        let corners = [[-1.0, -0.6, 0.0], [1.0, -0.6, 0.0], [0.0, 1.1, 0.0]].map(Vector::<3>::from);
        let ball = |x: f64, z: f64| Obstacle::ball([x, 0.05, z], 0.3).expect("a ball");
        let (depth, at) = deepest(corners, &ball(0.1, 0.1)).expect("inside");
        assert!((0.1..=0.2).contains(&depth), "{depth} at {at}");
        assert!((ball(0.1, 0.1).distance(&at) + depth).abs() < 1e-15);
        assert_eq!(deepest(corners, &ball(0.1, 0.31)), None);
        assert_eq!(deepest(corners, &ball(1.2, 0.0)), None);
    }

    /// Balls of any size are found by their centres, wherever they are in a cell; a plate by its middle plane. What touches a
    /// cell, or is deep in it on one side, has no core there.
    #[test]
    fn cores_within_a_cell() {
        let cell = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]
        .map(Vector::<3>::from);
        let x = [0.1, 0.2, 0.15];
        for radius in [1e-3, 0.05, 0.3, 2.0] {
            let ball = Obstacle::ball(x, radius).expect("a ball");
            let (depth, at) = core(&cell, &ball).expect("within");
            assert!((depth - radius).abs() < 1e-8, "{radius}: {depth}");
            assert!((at - Vector::from(x)).norm() < 1e-8, "{radius}: {at}");
        }
        let plate = Obstacle::cuboid([-9.0, -9.0, 0.1], [9.0, 9.0, 0.14]).expect("a plate");
        let (depth, at) = core(&cell, &plate).expect("within");
        assert!(
            (depth - 0.02).abs() < 1e-9 && (at[2] - 0.12).abs() < 1e-9,
            "{depth} {at}"
        );
        let ball = |z: f64| Obstacle::ball([0.25, 0.25, z], 0.5).expect("a ball");
        let floor = Obstacle::half_space([0.0, 0.0, 0.2], [0.0, 0.0, 1.0]).expect("a half-space");
        for apart in [ball(-0.5), ball(-0.3), ball(9.0), floor] {
            assert_eq!(core(&cell, &apart), None, "{apart:?}");
        }
    }

    /// Positions whose sums and distances overflow end the division of a face.
    #[test]
    fn positions_beyond_all_bounds() {
        let far = [[1e308, 1e308], [1e308, 1e308]].map(Vector::<2>::from);
        let cavity = Obstacle::cavity([0.0; 2], 1.0).expect("a cavity");
        deepest(far, &cavity);
        let nan = [[f64::NAN, 0.0], [1.0, 0.0]].map(Vector::<2>::from);
        assert!(deepest(nan, &cavity).is_none_or(|(depth, _)| depth >= 0.0));
    }

    /// Where a face is as small as the distance of two numbers at its place, its middle is one of its ends.
    #[test]
    fn faces_as_small_as_round_off() {
        let x = 1e16; // the next number is x + 2
        let edge = [[x, 0.0], [x + 2.0, 0.0]].map(Vector::<2>::from);
        let beyond = Obstacle::half_space([x, 0.0], [0.0, 1.0]).expect("a half-space");
        assert_eq!(deepest(edge, &beyond), None);
        let triangle = [[x, 0.0, x], [x + 2.0, 0.0, x], [x, 0.0, x + 2.0]];
        let beyond = Obstacle::half_space([x, -0.5, x], [0.0, -1.0, 0.0]).expect("a half-space");
        let (depth, _) = deepest(triangle.map(Vector::<3>::from), &beyond).expect("inside");
        assert_eq!(depth, 0.5);
    }

    /// In a half-space, the deepest point is a node.
    #[test]
    fn nodes_are_exact() {
        let corners = [[0.0, 1.0], [1.0, -0.25]].map(Vector::<2>::from);
        let floor = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a half-space");
        assert_eq!(deepest(corners, &floor), Some((0.25, corners[1])));
    }
}
