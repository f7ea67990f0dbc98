//! Elastic foundations: springs on a boundary.

use std::collections::BTreeMap;

use crate::element::{Facet, FacetRule, facet_shapes};
use crate::mesh::Mesh;
use crate::tensor::{Vector, unit_vector};

/// How springs are stretched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stretch {
    /// By u, in all directions.
    Any,
    /// By u·N alone, with the outward normal N in the reference configuration.
    Normal,
}

/// Springs on a boundary, fixed to the ground: the energy ½ ∫ k |u|² dA, or ½ ∫ k (u·N)² dA, over reference areas.
#[derive(Clone, Debug)]
pub(crate) struct Springs {
    /// For each quadrature point and direction: dofs with their shares in the stretch there (no unit).
    stretches: Vec<Vec<(usize, f64)>>,
    /// The stiffness S between dofs, of which the first has the larger number (UF/UL).
    entries: Vec<(usize, usize, f64)>,
}

impl Springs {
    /// Springs of a `stiffness` per area on facets, given by their nodes: UF/UL³ in space, UF/UL² in the plane.
    ///
    /// The quadrature is exact on flat facets.
    pub fn new<const D: usize>(
        mesh: &Mesh<D>,
        facets: &[&[usize]],
        stiffness: f64,
        stretch: Stretch,
    ) -> Self {
        let rule = FacetRule::<D>::gauss(3);
        let (mut stretches, mut entries) = (Vec::new(), BTreeMap::new());
        for nodes in facets {
            let facet = Facet::gather(mesh.order(), nodes, mesh.nodes());
            for (weight, lambda) in rule.points() {
                let normal = facet.normal(lambda);
                let area = normal.norm();
                let ring = mesh.ring(&facet.point(lambda));
                let directions: Vec<Vector<D>> = match stretch {
                    Stretch::Any => (0..D).map(unit_vector).collect(),
                    Stretch::Normal => vec![normal / area],
                };
                for direction in directions {
                    let shapes = nodes.iter().zip(facet_shapes(mesh.order(), lambda));
                    let shares = shapes.flat_map(|(node, N)| {
                        let dofs = (0..D).filter(|i| direction[*i] != 0.0);
                        dofs.map(move |i| (D * node + i, N * direction[i]))
                    });
                    let shares: Vec<(usize, f64)> = shares.collect();
                    for &(row, r) in &shares {
                        for &(col, c) in shares.iter().filter(|(col, _)| *col <= row) {
                            let entry = entries.entry((row, col)).or_insert(0.0);
                            *entry += stiffness * weight * area * ring * r * c;
                        }
                    }
                    stretches.push(shares);
                }
            }
        }
        Springs {
            stretches,
            entries: entries.into_iter().map(|((r, c), s)| (r, c, s)).collect(),
        }
    }

    /// What the springs oppose: for each a list of dofs and shares.
    pub fn stretches(&self) -> &[Vec<(usize, f64)>] {
        &self.stretches
    }

    /// The entries of the stiffness S at and below its diagonal (UF/UL).
    pub fn entries(&self) -> &[(usize, usize, f64)] {
        &self.entries
    }

    /// Adds S U, the forces on the ground (UF), to `forces` and returns ½ UᵀS U (UF·UL), with U of all dofs (UL).
    pub fn add_forces(&self, U: &[f64], forces: &mut [f64]) -> f64 {
        for &(r, c, s) in &self.entries {
            forces[r] += s * U[c];
            if r != c {
                forces[c] += s * U[r];
            }
        }
        self.energy(U)
    }

    /// ½ UᵀS U (UF·UL).
    pub fn energy(&self, U: &[f64]) -> f64 {
        let terms = self.entries.iter();
        let terms = terms.map(|&(r, c, s)| if r == c { 0.5 } else { 1.0 } * s * U[r] * U[c]);
        terms.sum()
    }
}
