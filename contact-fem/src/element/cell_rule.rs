//! Quadrature on cells.

use crate::tensor::{Vector, unit_vector};

/// ξ at a corner of the unit simplex.
pub(crate) fn corner<const D: usize>(a: usize) -> Vector<D> {
    match a {
        0 => Vector::zeros(),
        _ => unit_vector(a - 1),
    }
}

/// Quadrature points (weight, ξ) of the rule with D + 1 points that is exact to degree 2: on the lines from the centre to the corners, at 1/√(D + 2) of
/// their length.
pub(crate) fn degree_2<const D: usize>() -> impl Iterator<Item = (f64, Vector<D>)> {
    let volume = if D == 2 { 1.0 / 2.0 } else { 1.0 / 6.0 };
    let centre = Vector::<D>::repeat(1.0 / (D + 1) as f64);
    let along = 1.0 / (D as f64 + 2.0).sqrt();
    (0..=D).map(move |a| {
        let xi = centre + (corner(a) - centre) * along;
        (volume / (D + 1) as f64, xi)
    })
}

/// Quadrature points (weight, ξ) of a rule that is exact to degree 5; the weights sum to the
/// simplex's volume 1/D!. The degree suffices for quadratic shape functions times the determinant
/// of a quadratic map.
///
/// Seven points in the plane (J. Radon, 1948), fifteen in space (A. H. Stroud, Approximate
/// Calculation of Multiple Integrals, 1971, T3: 5-1).
pub(crate) fn degree_5<const D: usize>() -> impl Iterator<Item = (f64, Vector<D>)> {
    const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
    let root = 15.0_f64.sqrt();
    let d = D as f64;
    let volume = if D == 2 { 1.0 / 2.0 } else { 1.0 / 6.0 };
    let (centre, edges) = if D == 2 {
        (9.0 / 40.0, 0.0)
    } else {
        (16.0 / 135.0, 10.0 / 189.0)
    };
    let corners = [-root, root].map(|root| match D {
        2 => ((6.0 + root) / 21.0, (155.0 + root) / 1200.0),
        _ => ((7.0 + root) / 34.0, (2665.0 - 14.0 * root) / 37800.0),
    });
    let middle = Vector::<D>::repeat(1.0 / (d + 1.0));
    let towards_corners = corners.into_iter().flat_map(move |(near, weight)| {
        let at = move |a: usize| Vector::repeat(near) + corner::<D>(a) * (1.0 - (d + 1.0) * near);
        (0..=D).map(move |a| (weight, at(a)))
    });
    let near = (10.0 - 2.0 * root) / 40.0;
    let towards_edges = (0..=D)
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .filter(|_| D == 3)
        .map(move |(a, b)| {
            let off = 0.5 - 2.0 * near;
            let at = Vector::repeat(near) + (corner::<D>(a) + corner(b)) * off;
            (edges, at)
        });
    std::iter::once((centre, middle))
        .chain(towards_corners)
        .chain(towards_edges)
        .map(move |(weight, xi)| (weight * volume, xi))
}

#[cfg(test)]
mod tests {
    use super::super::battery::integrates;
    use super::*;

    #[test]
    fn exact_to_degree_2() {
        integrates(&degree_2::<2>().collect::<Vec<_>>(), 2);
        integrates(&degree_2::<3>().collect::<Vec<_>>(), 2);
    }

    #[test]
    fn exact_to_degree_5() {
        integrates(&degree_5::<2>().collect::<Vec<_>>(), 5);
        integrates(&degree_5::<3>().collect::<Vec<_>>(), 5);
    }
}
