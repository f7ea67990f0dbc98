//! Points and flat simplices: inside, distance, intersection.

use nalgebra::Matrix2;

use crate::tensor::{Matrix, Vector, inverse_transpose};

/// Whether a point is in the closed simplex of D + 1 nodes.
pub(super) fn holds<const D: usize>(nodes: &[usize], x: &[Vector<D>], point: &Vector<D>) -> bool {
    let columns: [_; D] = std::array::from_fn(|i| x[nodes[i + 1]] - x[nodes[0]]);
    let inverse = inverse_transpose(&Matrix::from_columns(&columns)).transpose();
    let weights = inverse * (point - x[nodes[0]]);
    weights.iter().all(|&w| w >= 0.0) && weights.sum() <= 1.0
}

/// The distance of a point from a simplex of one to three corners (UL).
pub(super) fn distance<const D: usize>(point: &Vector<D>, corners: &[Vector<D>]) -> f64 {
    match foot(point, corners) {
        Some(foot) => (point - foot).norm(),
        // the closest point is on a side
        None => (0..corners.len())
            .map(|k| distance(point, &without(corners, k)))
            .fold(f64::INFINITY, f64::min),
    }
}

fn without<const D: usize>(corners: &[Vector<D>], k: usize) -> Vec<Vector<D>> {
    let mut side = corners.to_vec();
    side.remove(k);
    side
}

/// The orthogonal projection of a point on the plane of a simplex, if it is inside the simplex.
fn foot<const D: usize>(point: &Vector<D>, corners: &[Vector<D>]) -> Option<Vector<D>> {
    let [origin, rest @ ..] = corners else {
        return None;
    };
    let offset = point - origin;
    let weights = match rest {
        [] => [0.0, 0.0],
        [a] => {
            let edge = a - origin;
            [edge.dot(&offset) / edge.norm_squared(), 0.0]
        }
        [a, b, ..] => {
            let (a, b) = (a - origin, b - origin);
            let gram = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let solved = gram
                .lu()
                .solve(&nalgebra::Vector2::new(a.dot(&offset), b.dot(&offset)))?;
            [solved[0], solved[1]]
        }
    };
    let is_inside = weights.iter().all(|&w| w >= 0.0) && weights.iter().sum::<f64>() <= 1.0;
    let foot = rest
        .iter()
        .zip(weights)
        .fold(*origin, |foot, (x, w)| foot + (x - origin) * w);
    is_inside.then_some(foot)
}

/// Where an edge passes through a facet, as a share of its length.
pub(super) fn pierced<const D: usize>(
    edge: &[Vector<D>; 2],
    facet: &[Vector<D>; D],
) -> Option<f64> {
    let normal = crate::tensor::facet_normal(facet);
    let [from, to] = edge.map(|x| normal.dot(&(x - facet[0])));
    if from * to >= 0.0 {
        return None;
    }
    let share = from / (from - to);
    foot(&(edge[0] + (edge[1] - edge[0]) * share), facet).map(|_| share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_triangle() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(Vector::<3>::from);
        for (x, expected) in [
            ([0.5, 0.5, 0.7], 0.7),
            ([-3.0, 0.5, 4.0], 5.0),
            ([-3.0, -4.0, 0.0], 5.0),
            ([2.0, 2.0, 0.0], 2f64.sqrt()),
            ([5.0, 0.0, 4.0], 5.0),
        ] {
            let found = distance(&Vector::<3>::from(x), &corners);
            assert!((found - expected).abs() < 1e-14, "{x:?}: {found}");
        }
    }

    #[test]
    fn an_edge_through_a_facet_and_past_it() {
        let facet = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Vector::<3>::from);
        let edge = |x: f64, y: f64| [[x, y, -3.0], [x, y, 2.0]].map(Vector::<3>::from);
        let share = pierced(&edge(1.5, 0.5), &facet).expect("through");
        assert!((share - 0.6).abs() < 1e-14);
        assert!(pierced(&edge(2.5, 2.5), &facet).is_none());
        let segment = [[0.0, 0.0], [4.0, 0.0]].map(Vector::<2>::from);
        let edge = |to: f64| [[1.0, -3.0], [1.0, to]].map(Vector::<2>::from);
        let share = pierced(&edge(1.0), &segment).expect("through");
        assert!((share - 0.75).abs() < 1e-14);
        assert!(pierced(&edge(-0.5), &segment).is_none());
    }
}
