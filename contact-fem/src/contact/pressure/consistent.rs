//! The consistent field, whose nodal forces are those of the contact.

use contact_core::linear::{
    Analysis, Cholesky, Factor, FactorError, Kind, Ordering, SymmetricPattern,
};

use crate::contact::surface::Surface;
use crate::element::{FacetRule, facet_edge};
use crate::error::Error;
use crate::tensor::Vector;

/// The nodal tractions t (reference area, UF/UL²) of a surface, in the order of its nodes,
/// from the nodal contact forces f = Cᵀλ at those nodes: Σ_j ∫ φ_i φ_j ds t_j = Σ_a φ_i(X_a) f_a
/// with the test functions φ of the constraints, which are in the span of the shape functions.
///
/// If both passes constrain the same contact, the multipliers are not unique; the forces are.
///
/// # Errors
/// If the surface mass matrix cannot be factorised, which requires a facet without measure.
pub fn tractions<const D: usize>(
    surface: &Surface<D>,
    forces: &[Vector<D>],
) -> Result<Vec<Vector<D>>, Error> {
    // nodes without a test function are in the middle of edges, which `ends` stores
    let (tests, ends) = test_nodes(surface);
    let n = tests.iter().flatten().count();
    let numbers = |facet: &[usize]| -> Vec<usize> {
        let facet = facet[..surface.test_nodes()].iter();
        facet.filter_map(|&a| tests[a]).collect()
    };
    let rule = FacetRule::<D>::gauss(3);
    let mut mass = Vec::new();
    for (f, facet) in surface.facets().enumerate() {
        let numbers = numbers(facet);
        for (w, lambda) in rule.points() {
            let w = w * surface.measure(f, lambda);
            let phi = surface.test_functions(lambda);
            for (k, &row) in numbers.iter().enumerate() {
                for (l, &col) in numbers[..=k].iter().enumerate() {
                    mass.push((row, col, w * phi[k] * phi[l]));
                }
            }
        }
    }
    let singular = |_| Error::Setting {
        name: "surface mass",
        value: 0.0,
        remedy: "remove the contact surface's facets of zero measure",
    };
    let mut t = vec![0.0; D * n]; // component by component
    for (a, force) in forces.iter().enumerate() {
        for (row, share) in shares(&tests, &ends, a) {
            (0..D).for_each(|i| t[n * i + row] += share * force[i]);
        }
    }
    solve_mass(n, &mass, &mut t).map_err(singular)?;
    let at_node = |a: usize| {
        let mut traction = Vector::zeros();
        for (row, share) in shares(&tests, &ends, a) {
            (0..D).for_each(|i| traction[i] += share * t[n * i + row]);
        }
        traction
    };
    Ok((0..forces.len()).map(at_node).collect())
}

/// Solves with the matrix of these entries for right-hand sides stored one after the other.
fn solve_mass(n: usize, mass: &[(usize, usize, f64)], b: &mut [f64]) -> Result<(), FactorError> {
    let (pattern, mass) = SymmetricPattern::from_sums(n, mass).expect("numbered so");
    let mut factor = Cholesky::new(&Analysis::new(&pattern, &Ordering::Automatic)?, Kind::Llt)?;
    factor.refactor(&mass)?;
    factor.solve(b)
}

/// For each node the number of its test function, if it has one; for the others the nodes at the
/// ends of their edge.
pub(super) fn test_nodes<const D: usize>(
    surface: &Surface<D>,
) -> (Vec<Option<usize>>, Vec<[usize; 2]>) {
    let mut has_test = vec![false; surface.nodes().len()];
    let mut ends = vec![[0; 2]; surface.nodes().len()];
    for facet in surface.facets() {
        let (with, without) = facet.split_at(surface.test_nodes());
        with.iter().for_each(|&a| has_test[a] = true);
        for (e, &a) in without.iter().enumerate() {
            ends[a] = facet_edge::<D>(e).map(|corner| facet[corner]);
        }
    }
    let mut count = 0..;
    let number = |has: bool| if has { count.next() } else { None };
    (has_test.into_iter().map(number).collect(), ends)
}

/// The non-zero test functions at node `a`, with their values there.
pub(super) fn shares(
    tests: &[Option<usize>],
    ends: &[[usize; 2]],
    a: usize,
) -> impl Iterator<Item = (usize, f64)> {
    let corners = match tests[a] {
        Some(own) => [Some((own, 1.0)), None],
        None => ends[a].map(|end| tests[end].map(|number| (number, 0.5))),
    };
    corners.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// The recovery returns a linear traction from its nodal forces on facets of unequal length.
    #[test]
    fn recovers_linear_tractions() {
        let x = [0.0, 0.3, 1.0, 1.2, 2.0].map(|x| Vector::<2>::new(x, 0.0));
        let facets: Vec<[usize; 2]> = (0..4).map(|k| [k, k + 1]).collect();
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Linear, facets, &x);
        let traction = |s: f64| Vector::<2>::new(0.2 - s, 3.0 + 2.0 * s);
        let mut forces = vec![Vector::<2>::zeros(); 5];
        for k in 0..4 {
            let (a, b) = (x[k][0], x[k + 1][0]);
            // ∫ N t over a segment of length h: h/6 (2 t_a + t_b), h/6 (t_a + 2 t_b)
            forces[k] += (2.0 * traction(a) + traction(b)) * ((b - a) / 6.0);
            forces[k + 1] += (traction(a) + 2.0 * traction(b)) * ((b - a) / 6.0);
        }
        for (t, x) in tractions(&surface, &forces)
            .expect("regular")
            .iter()
            .zip(&x)
        {
            assert!((t - traction(x[0])).norm() < 1e-13);
        }
    }

    /// A linear traction on one quadratic triangle, from its consistent nodal forces. The corner
    /// shape functions of a quadratic triangle have mean zero.
    #[test]
    fn quadratic_triangles_use_the_functions_of_the_corners() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::<3>::from);
        let middle = |a: usize, b: usize| (corners[a] + corners[b]) * 0.5;
        let mut x = corners.to_vec();
        x.extend([middle(0, 1), middle(1, 2), middle(2, 0)]);
        let facets = [[0, 1, 2, 3, 4, 5]];
        let facets = facets.iter().map(|f| &f[..]);
        let surface = Surface::new(0, Order::Quadratic, facets, &x);
        let traction = |X: &Vector<3>| Vector::<3>::new(0.0, 1.0 + X[0], 5.0 - X[0] + 2.0 * X[1]);
        let mut forces = vec![Vector::<3>::zeros(); 6];
        for (w, lambda) in FacetRule::<3>::gauss(4).points() {
            let X = surface.reference()[0].point(lambda);
            let N = crate::element::facet_shapes(Order::Quadratic, lambda);
            for (f, N) in forces.iter_mut().zip(N) {
                *f += traction(&X) * (w * N); // the triangle's area is 1
            }
        }
        for (t, X) in tractions(&surface, &forces)
            .expect("regular")
            .iter()
            .zip(&x)
        {
            assert!((t - traction(X)).norm() < 1e-13);
        }
    }
}
