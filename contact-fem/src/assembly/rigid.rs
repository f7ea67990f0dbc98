//! The energy of a body that does not deform: that of its loads.

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;

use super::{BodyEnergy, CellError, CellState, Dof, DofMap};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector};

/// E = −f·U. That the nodes move as one is told by the ties of their dofs, see [`Tied`](super::Tied).
pub(crate) struct RigidEnergy {
    dofs: DofMap,
    /// The present load factor; prescribed displacements (UL) and nodal forces (all dofs, UF) at full load.
    factor: f64,
    full: Vec<f64>,
    forces: Vec<f64>,
    /// The prescribed displacements at the present load (UL).
    prescribed: Vec<f64>,
    /// Of the nodes of `coupled` facets, on which springs may act, and of each node.
    pattern: SymmetricPattern,
}

impl RigidEnergy {
    /// With `full` prescribed displacements (UL) and nodal `forces` (all dofs, UF) at full load; the initial load factor is 0.
    pub fn new<'a, const D: usize>(
        dofs: DofMap,
        full: Vec<f64>,
        forces: Vec<f64>,
        coupled: impl Iterator<Item = &'a [usize]>,
    ) -> Self {
        let free = |node: usize| {
            let own = (D * node..D * (node + 1)).map(|dof| dofs.get(dof));
            own.filter_map(|dof| match dof {
                Dof::Free(k) => Some(k),
                Dof::Prescribed(_) => None,
            })
        };
        let pairs = |nodes: &[usize]| -> Vec<(usize, usize)> {
            let own: Vec<usize> = nodes.iter().flat_map(|&a| free(a)).collect();
            let pair = |&i: &usize| own.iter().map(move |&j| (i.max(j), i.min(j)));
            own.iter().flat_map(pair).collect()
        };
        let nodes = (0..dofs.len() / D).flat_map(|a| pairs(&[a]));
        let places: Vec<_> = coupled.flat_map(pairs).chain(nodes).collect();
        let (pattern, _) = SymmetricPattern::from_entries(dofs.free(), &places)
            .expect("free dofs are numbered below their number");
        RigidEnergy {
            prescribed: vec![0.0; full.len()],
            factor: 0.0,
            dofs,
            full,
            forces,
            pattern,
        }
    }
}

impl Energy for RigidEnergy {
    fn dofs(&self) -> usize {
        self.dofs.free()
    }

    fn value(&self, u: &[f64]) -> f64 {
        let U = self.dofs.expand(u, &self.prescribed);
        let works = U.iter().zip(&self.forces).map(|(u, f)| u * f);
        -self.factor * works.sum::<f64>()
    }

    fn gradient(&self, _: &[f64], g: &mut [f64]) {
        for (dof, f) in self.forces.iter().enumerate() {
            if let Dof::Free(i) = self.dofs.get(dof) {
                g[i] = -self.factor * f;
            }
        }
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.fill(0.0);
    }

    fn is_quadratic(&self) -> bool {
        true
    }
}

impl<const D: usize> BodyEnergy<D> for RigidEnergy {
    fn set_load(&mut self, factor: f64) {
        self.factor = factor;
        self.prescribed = self.full.iter().map(|full| factor * full).collect();
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        (self.full, self.forces) = (prescribed, forces);
        BodyEnergy::<D>::set_load(self, 1.0);
    }

    fn prescribed(&self) -> &[f64] {
        &self.prescribed
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        let own = self.forces.iter().map(|f| self.factor * f);
        forces.iter_mut().zip(own).for_each(|(sum, f)| *sum -= f);
        self.value(u)
    }

    /// The increments themselves: free motions do not follow held ones.
    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        supports.expand(&vec![0.0; supports.free()], increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, _: &[Vector<D>]) -> Vec<CellState<D>> {
        vec![unstressed(); mesh.len()]
    }

    fn nodal_states(&self, mesh: &Mesh<D>, _: &[Vector<D>]) -> Vec<CellState<D>> {
        mesh.cells()
            .flat_map(|cell| cell.iter().map(|_| unstressed()))
            .collect()
    }

    fn cell_errors(&self, mesh: &Mesh<D>, _: &[Vector<D>]) -> Vec<CellError> {
        vec![CellError::default(); mesh.len()]
    }

    fn assembled_cells(&self) -> usize {
        0
    }

    fn typical_stiffness(&self) -> f64 {
        0.0
    }

    fn contact_modulus(&self) -> f64 {
        f64::INFINITY
    }
}

/// Without stress.
fn unstressed<const D: usize>() -> CellState<D> {
    CellState {
        J: 1.0,
        sigma: Matrix::zeros(),
        sigma_zz: 0.0,
    }
}
