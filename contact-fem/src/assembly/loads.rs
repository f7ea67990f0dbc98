//! Dead loads as nodal forces: f(v) = ∫_Γ f·v ds + ∫_Ω b·v dX.

use crate::element::cell_rule::degree_5;
use crate::element::{Element, Facet, FacetRule, facet_shapes};
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// Adds the nodal forces (all dofs, UF) of a traction f(X) (force per reference area) on facets,
/// given by their nodes. Those of a body of revolution are for the whole circumference.
///
/// On flat facets the quadrature is exact for tractions up to degree 3 in the plane and 2 in space,
/// for linear and quadratic elements. For other tractions the quadrature error does not reduce the
/// order of convergence.
pub fn add_traction<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[&[usize]],
    traction: impl Fn(&Vector<D>) -> Vector<D>,
    forces: &mut [f64],
) {
    let rule = FacetRule::<D>::gauss(3);
    for nodes in facets {
        let facet = Facet::gather(mesh.order(), nodes, mesh.nodes());
        for (weight, lambda) in rule.points() {
            let X = facet.point(lambda);
            let f = traction(&X) * (weight * facet.normal(lambda).norm() * mesh.ring(&X));
            for (&node, N) in nodes.iter().zip(facet_shapes(mesh.order(), lambda)) {
                for i in 0..D {
                    forces[D * node + i] += N * f[i];
                }
            }
        }
    }
}

/// Adds the nodal forces (all dofs, UF) of a body force b(X) (force per reference volume), of a body of revolution for the whole
/// circumference. The
/// quadrature is exact on straight cells if b times a shape function has degree 5 at most, and on
/// curved cells for a constant b.
pub fn add_body_force<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    force: impl Fn(&Vector<D>) -> Vector<D>,
    forces: &mut [f64],
) {
    for (k, cell) in mesh.cells().enumerate() {
        for (weight, xi) in degree_5::<D>() {
            let N = E::shapes(&xi);
            let shapes = || cell.iter().zip(N.as_ref());
            let X: Vector<D> = shapes().map(|(&node, N)| mesh.nodes()[node] * *N).sum();
            let b = force(&X) * (weight * mesh.jacobian(k, &xi) * mesh.ring(&X));
            for (&node, N) in shapes() {
                for i in 0..D {
                    forces[D * node + i] += N * b[i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{Order, P1, P2};
    use crate::mesh::generators::{Diagonals, cuboid_graded, rectangle};

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
        add_body_force::<D, P2>(&mesh, |_| Vector::repeat(3.0), &mut forces);
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

    /// The work of nodal forces on a displacement field.
    fn work<const D: usize>(
        mesh: &Mesh<D>,
        forces: &[f64],
        v: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> f64 {
        let pairs = forces.chunks_exact(D).zip(mesh.nodes());
        pairs
            .map(|(f, X)| v(X).dot(&Vector::from_column_slice(f)))
            .sum()
    }

    /// b = x y² in every component does work on v = x and, with quadratic elements, on v = x²; a
    /// traction on the side x = 1 does as well.
    fn fields_on_straight_cells<const D: usize>(mesh: Mesh<D>)
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let b = |X: &Vector<D>| Vector::<D>::repeat(X[0] * X[1] * X[1]);
        let mut forces = vec![0.0; D * mesh.nodes().len()];
        add_body_force::<D, P1>(&mesh, b, &mut forces);
        let linear = work(&mesh, &forces, |X| Vector::repeat(X[0]));
        assert!((linear - D as f64 / 9.0).abs() < 1e-14, "{linear}");
        let right = mesh.boundary("right").expect("a side");
        let mut forces = vec![0.0; D * mesh.nodes().len()];
        add_traction(&mesh, &right, |X| X * X[1], &mut forces);
        // on x = 1: ∫ (X·1) y = ∫ (1 + y + …) y
        let side = work(&mesh, &forces, |_| Vector::repeat(1.0));
        let exact = 0.5 + 1.0 / 3.0 + (D as f64 - 2.0) * 0.25;
        assert!((side - exact).abs() < 1e-14, "{side} {exact}");

        let mesh = mesh.quadratic();
        let mut forces = vec![0.0; D * mesh.nodes().len()];
        add_body_force::<D, P2>(&mesh, b, &mut forces);
        let quadratic = work(&mesh, &forces, |X| Vector::repeat(X[0] * X[0]));
        assert!((quadratic - D as f64 / 12.0).abs() < 1e-14, "{quadratic}");
        let right = mesh.boundary("right").expect("a side");
        let mut forces = vec![0.0; D * mesh.nodes().len()];
        add_traction(&mesh, &right, |X| Vector::repeat(X[1] * X[1]), &mut forces);
        let side = work(&mesh, &forces, |X| Vector::repeat(X[1] * X[1]));
        assert!((side - D as f64 / 5.0).abs() < 1e-14, "{side}");
    }

    #[test]
    fn loads_that_vary() {
        let unit = [0.0, 0.4, 1.0];
        fields_on_straight_cells(rectangle(&unit, &unit, Diagonals::Rising).expect("mesh"));
        fields_on_straight_cells(cuboid_graded(&unit, &unit, &unit).expect("mesh"));
    }

    #[test]
    fn body_forces_on_curved_cells() {
        exact_on_a_bent_cell([0.2, -0.3]);
        exact_on_a_bent_cell([0.2, -0.3, 0.25]);
    }
}
