//! Dead loads as nodal forces: f(v) = ∫_Γ f·v ds + ∫_Ω b·v dX.

use crate::element::cell_rule::degree_5;
use crate::element::{Element, Facet, FacetRule, facet_shapes};
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// Adds the nodal forces (full dofs, UF) of a uniform traction (force per reference area) on
/// facets, given by their nodes.
pub fn add_traction<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[&[usize]],
    traction: &Vector<D>,
    forces: &mut [f64],
) {
    let rule = FacetRule::<D>::gauss(3);
    for nodes in facets {
        let facet = Facet::gather(mesh.order(), nodes, mesh.nodes());
        for (weight, lambda) in rule.points() {
            let w = weight * facet.normal(lambda).norm();
            for (&node, N) in nodes.iter().zip(facet_shapes(mesh.order(), lambda)) {
                for i in 0..D {
                    forces[D * node + i] += w * N * traction[i];
                }
            }
        }
    }
}

/// Adds the nodal forces (full dofs, UF) of a uniform body force (force per reference volume), exact
/// on curved cells too.
pub fn add_body_force<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    force: &Vector<D>,
    forces: &mut [f64],
) {
    for (k, cell) in mesh.cells().enumerate() {
        for (weight, xi) in degree_5::<D>() {
            let w = weight * mesh.jacobian(k, &xi);
            for (&node, N) in cell.iter().zip(E::shapes(&xi).as_ref()) {
                for i in 0..D {
                    forces[D * node + i] += w * N * force[i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Order, P2};

    /// One quadratic cell under the map X_i = ξ_i (1 + a_i ξ_i), whose determinant is Π (1 + 2 a_i ξ_i).
    fn bent<const D: usize>(a: [f64; D]) -> Mesh<D>
    where
        P2: Element<D>,
    {
        let mut xi = vec![[0.0; D]];
        xi.extend((0..D).map(|k| std::array::from_fn(|i| f64::from(u8::from(i == k)))));
        let middle = |[k, l]: &[usize; 2]| std::array::from_fn(|i| 0.5 * (xi[*k][i] + xi[*l][i]));
        let middles: Vec<[f64; D]> = <P2 as Element<D>>::EDGES.iter().map(middle).collect();
        xi.extend(middles);
        let nodes = xi
            .iter()
            .map(|xi| std::array::from_fn(|i| xi[i] * (1.0 + a[i] * xi[i])));
        let cell = (0..xi.len()).collect();
        Mesh::of_order(Order::Quadratic, nodes.collect(), cell).expect("valid")
    }

    /// ∫ Σ_p c_p ξ₁ᵖ Π (1 + 2 a_i ξ_i) dξ, factor by factor: ∫ ξ^p = Π pᵢ! / (D + Σ pᵢ)!.
    fn integral<const D: usize>(c: &[f64], a: [f64; D]) -> f64 {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        let mut sum = 0.0;
        for (p, c) in (0..).zip(c) {
            for subset in 0..1 << D {
                let powers: [u32; D] =
                    std::array::from_fn(|i| (subset >> i & 1) + if i == 0 { p } else { 0 });
                let factors = (0..D).filter(|i| subset >> i & 1 == 1).map(|i| 2.0 * a[i]);
                let numerator: f64 = powers.iter().map(|&p| factorial(p)).product();
                let all = D as u32 + powers.iter().sum::<u32>();
                sum += c * factors.product::<f64>() * numerator / factorial(all);
            }
        }
        sum
    }

    fn exact_on_a_bent_cell<const D: usize>(a: [f64; D])
    where
        P2: Element<D>,
    {
        let mesh = bent(a);
        let volume = integral(&[1.0], a);
        assert!((mesh.volume(0) - volume).abs() < 1e-15, "{volume}");
        let mut forces = vec![0.0; D * mesh.nodes().len()];
        add_body_force::<D, P2>(&mesh, &Vector::repeat(3.0), &mut forces);
        for i in 0..D {
            // Σ N_a = 1 and Σ N_a X_a = X: resultant and moment
            let along = || forces.iter().skip(i).step_by(D);
            assert!((along().sum::<f64>() - 3.0 * volume).abs() < 1e-15);
            let arms = mesh.nodes().iter().map(|X| X[0]);
            let moment: f64 = along().zip(arms).map(|(f, arm)| f * arm).sum();
            let exact = 3.0 * integral(&[0.0, 1.0, a[0]], a);
            assert!((moment - exact).abs() < 1e-15, "{moment} {exact}");
        }
    }

    #[test]
    fn body_forces_on_curved_cells() {
        exact_on_a_bent_cell([0.2, -0.3]);
        exact_on_a_bent_cell([0.2, -0.3, 0.25]);
    }
}
