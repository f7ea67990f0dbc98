//! Dead loads as nodal forces: f(v) = ∫_Γ f·v ds + ∫_Ω b·v dX.

use crate::mesh::Mesh;
use crate::tensor::{Vector, facet_normal};

/// Adds the nodal forces (full dofs, UF) of a uniform traction (force per reference area) on
/// `facets`: linear facets give each corner an equal share.
pub fn add_traction<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[[usize; D]],
    traction: &Vector<D>,
    forces: &mut [f64],
) {
    for facet in facets {
        let measure = facet_normal(&facet.map(|a| mesh.nodes()[a])).norm();
        for &node in facet {
            for i in 0..D {
                forces[D * node + i] += traction[i] * measure / D as f64;
            }
        }
    }
}

/// Adds the nodal forces (full dofs, UF) of a uniform body force (force per reference volume).
pub fn add_body_force<const D: usize>(mesh: &Mesh<D>, force: &Vector<D>, forces: &mut [f64]) {
    for (k, cell) in mesh.cells().enumerate() {
        let share = mesh.volume(k) / cell.len() as f64;
        for &node in cell {
            for i in 0..D {
                forces[D * node + i] += force[i] * share;
            }
        }
    }
}
