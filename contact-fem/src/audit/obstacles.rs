//! Bodies inside rigid obstacles.

use crate::contact::Obstacle;
use crate::program::Pose;
use crate::tensor::Vector;

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
