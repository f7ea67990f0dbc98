//! The energy of a linear law: quadratic, its stiffness assembled once.

use contact_core::Energy;
use contact_core::nlp::Pattern;
use faer::sparse::{SparseColMat, Triplet};

use super::{BodyEnergy, CellState, DofMap, StrainEnergy};
use crate::element::Element;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// E(u) = E₀ + g₀·u + ½ uᵀK u over the free unknowns; E₀ and g₀ follow the load, K stays.
pub struct QuadraticEnergy<const D: usize, E: Element<D>, M: Material<D>> {
    elastic: StrainEnergy<D, E, M>,
    /// Both triangles of K (UF/UL), and the lower one at the positions of the pattern.
    K: SparseColMat<usize, f64>,
    values: Vec<f64>,
    /// ∇E and E at u = 0 and the present load.
    g_0: Vec<f64>,
    E_0: f64,
}

impl<const D: usize, E: Element<D>, M: Material<D>> QuadraticEnergy<D, E, M> {
    /// Assembles K.
    ///
    /// # Panics
    /// If the law is not linear: see [`Material::QUADRATIC`].
    pub fn new(elastic: StrainEnergy<D, E, M>) -> Self {
        assert!(M::QUADRATIC, "a quadratic energy needs a linear law");
        let n = elastic.dofs();
        let pattern = elastic.hessian_pattern();
        let mut values = vec![0.0; pattern.len()];
        elastic.hessian(&vec![0.0; n], &mut values);
        let entries = pattern.iter().zip(&values);
        let both = entries.flat_map(|((r, c), &k)| {
            let mirrored = (r != c).then(|| Triplet::new(c, r, k));
            [Some(Triplet::new(r, c, k)), mirrored]
                .into_iter()
                .flatten()
        });
        let both: Vec<_> = both.collect();
        let K = SparseColMat::try_new_from_triplets(n, n, &both);
        let mut energy = QuadraticEnergy {
            K: K.expect("the pattern's positions are within n × n"),
            values,
            g_0: vec![0.0; n],
            E_0: 0.0,
            elastic,
        };
        energy.set_load(0.0);
        energy
    }

    /// (K u)_j, by column j of the symmetric K.
    fn force(&self, j: usize, u: &[f64]) -> f64 {
        let rows = self.K.row_idx_of_col_raw(j);
        let values = self.K.val_of_col(j);
        rows.iter().zip(values).map(|(&i, k)| k * u[i]).sum()
    }
}

impl<const D: usize, E: Element<D>, M: Material<D>> Energy for QuadraticEnergy<D, E, M> {
    fn dofs(&self) -> usize {
        self.elastic.dofs()
    }

    fn value(&self, u: &[f64]) -> f64 {
        let terms = u.iter().enumerate();
        let work = terms.map(|(j, u_j)| u_j * (self.g_0[j] + 0.5 * self.force(j, u)));
        self.E_0 + work.sum::<f64>()
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        for (j, g) in g.iter_mut().enumerate() {
            *g = self.g_0[j] + self.force(j, u);
        }
    }

    fn hessian_pattern(&self) -> &Pattern {
        self.elastic.hessian_pattern()
    }

    fn hessian(&self, _u: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&self.values);
    }

    fn is_quadratic(&self) -> bool {
        true
    }
}

impl<const D: usize, E: Element<D>, M: Material<D>> BodyEnergy<D> for QuadraticEnergy<D, E, M> {
    fn set_load(&mut self, factor: f64) {
        self.elastic.set_load(factor);
        let rest = vec![0.0; self.dofs()];
        self.E_0 = self.elastic.value(&rest);
        self.elastic.gradient(&rest, &mut self.g_0);
    }

    fn prescribed(&self) -> &[f64] {
        self.elastic.prescribed()
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) {
        self.elastic.add_residual(u, forces);
    }

    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        self.elastic.extend(supports, increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        self.elastic.cell_states(mesh, U)
    }

    fn assembled_cells(&self) -> usize {
        self.elastic.assembled_cells()
    }

    fn typical_stiffness(&self) -> f64 {
        self.elastic.typical_stiffness()
    }

    fn is_small_strain(&self) -> bool {
        true
    }
}
