//! Dead loads as nodal forces: f(v) = ∫_Γ f·v ds + ∫_Ω b·v dX.

use crate::element::{Element, Facet, FacetRule, facet_shapes};
use crate::mesh::Mesh;
use crate::tensor::Vector;

use super::strain_energy::{nodes_of, points_of};

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

/// Adds the nodal forces (full dofs, UF) of a uniform body force (force per reference volume).
pub fn add_body_force<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    force: &Vector<D>,
    forces: &mut [f64],
) {
    for cell in mesh.cells() {
        let nodes = nodes_of::<D, E>(cell);
        let points = points_of::<D, E>(mesh, &nodes);
        for (point, (_, xi)) in points.zip(E::QUADRATURE) {
            let N = E::shapes(&Vector::from(*xi));
            for (&node, N) in cell.iter().zip(N.as_ref()) {
                for i in 0..D {
                    forces[D * node + i] += point.weight * N * force[i];
                }
            }
        }
    }
}
