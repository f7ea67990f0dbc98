//! The contact pressure, recovered from nodal contact forces.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

use super::surface::Surface;
use crate::element::{FacetRule, facet_shapes};
use crate::error::Error;
use crate::tensor::Vector;

/// The nodal tractions t (reference area, UF/UL or UF/UL²) of a surface, in the order of its nodes,
/// from the nodal contact forces Cᵀλ at those nodes: Σ_b ∫ N_a N_b ds t_b = f_a.
///
/// The forces, unlike the multipliers, are unique when both passes constrain the same contact.
///
/// # Errors
/// If the surface mass matrix cannot be factorised, which a surface with facets of positive
/// measure does not meet.
pub fn tractions<const D: usize>(
    surface: &Surface<D>,
    forces: &[Vector<D>],
) -> Result<Vec<Vector<D>>, Error> {
    let n = surface.nodes().len();
    let rule = FacetRule::<D>::gauss(3);
    let mut mass = Vec::new();
    for (nodes, facet) in surface.facets().zip(surface.reference()) {
        for (w, lambda) in rule.points() {
            let w = w * facet.normal(lambda).norm();
            let N = facet_shapes(surface.order(), lambda);
            for (&row, N_a) in nodes.iter().zip(N) {
                for (&col, N_b) in nodes.iter().zip(N) {
                    mass.push(Triplet::new(row, col, w * N_a * N_b));
                }
            }
        }
    }
    let singular = |_| Error::Setting {
        name: "surface mass",
        value: 0.0,
        remedy: "the contact surface has facets without measure",
    };
    let mass = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &mass);
    let mass = mass.map_err(|_| singular(()))?;
    let factor = mass.sp_cholesky(Side::Lower).map_err(|_| singular(()))?;
    let rhs = Mat::from_fn(n, D, |a, i| forces[a][i]);
    let solution = factor.solve(&rhs);
    Ok((0..n)
        .map(|a| Vector::from_fn(|i, _| solution[(a, i)]))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// Forces that a linear traction makes on uneven facets give that traction back.
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
}
