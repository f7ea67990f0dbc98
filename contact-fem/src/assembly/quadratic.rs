//! The quadratic energy of a linear law, whose stiffness is assembled once.

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;

use super::kinematics::{Cartesian, Kinematics};
use super::{BodyEnergy, CellError, CellState, DofMap, StrainEnergy};
use crate::element::Element;
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// E(u) = E₀ + g₀·u + ½ uᵀK u over the free unknowns; E₀ and g₀ depend on the load, K does not.
pub struct QuadraticEnergy<const D: usize, E: Element<D>, M, K: Kinematics<D, E, M> = Cartesian> {
    elastic: StrainEnergy<D, E, M, K>,
    /// K (UF/UL), one value for each entry of the pattern.
    K: Vec<f64>,
    /// ∇E at u = 0, without load and what it grows by to full load: loads are proportional.
    g_still: Vec<f64>,
    g_loads: Vec<f64>,
    /// E at u = 0: the coefficients of 1, of the load factor and of its square.
    E_rest: [f64; 3],
    /// ∇E and E at u = 0 and the present load.
    g_0: Vec<f64>,
    E_0: f64,
}

impl<const D: usize, E: Element<D>, M, K> QuadraticEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    /// Assembles K.
    ///
    /// # Panics
    /// If the law is not linear: see [`Kinematics::QUADRATIC`].
    pub fn new(mut elastic: StrainEnergy<D, E, M, K>) -> Self {
        assert!(K::QUADRATIC, "a quadratic energy needs a linear law");
        let n = elastic.dofs();
        let rest = vec![0.0; n];
        let mut K = vec![0.0; elastic.hessian_pattern().len()];
        elastic.hessian(&rest, &mut K);
        let mut at = |factor: f64| {
            elastic.set_load(factor);
            let mut g = vec![0.0; n];
            elastic.gradient(&rest, &mut g);
            (elastic.value(&rest), g)
        };
        let [(E_down, _), (E_up, g_up), (E_0, g_0)] = [-1.0, 1.0, 0.0].map(&mut at);
        elastic.forget();
        QuadraticEnergy {
            K,
            g_loads: g_up
                .iter()
                .zip(&g_0)
                .map(|(up, still)| up - still)
                .collect(),
            E_rest: [E_0, 0.5 * (E_up - E_down), 0.5 * (E_up + E_down) - E_0],
            g_still: g_0.clone(),
            g_0,
            E_0,
            elastic,
        }
    }
}

impl<const D: usize, E: Element<D>, M, K> Energy for QuadraticEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    fn dofs(&self) -> usize {
        self.elastic.dofs()
    }

    // E₀ + g₀·u + ½ uᵀK u
    fn value(&self, u: &[f64]) -> f64 {
        let mut forces = vec![0.0; u.len()];
        self.elastic
            .hessian_pattern()
            .product(&self.K, u, &mut forces);
        let terms = forces.iter().zip(&self.g_0).zip(u);
        let work: f64 = terms.map(|((Ku, g), u)| (0.5 * Ku + g) * u).sum();
        self.E_0 + work
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        if u.iter().all(|u| *u == 0.0) {
            return g.copy_from_slice(&self.g_0);
        }
        self.elastic.hessian_pattern().product(&self.K, u, g);
        g.iter_mut().zip(&self.g_0).for_each(|(g, g_0)| *g += g_0);
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.elastic.hessian_pattern()
    }

    fn hessian(&self, _u: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&self.K);
    }

    fn is_quadratic(&self) -> bool {
        true
    }
}

impl<const D: usize, E: Element<D>, M, K> BodyEnergy<D> for QuadraticEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    fn set_load(&mut self, factor: f64) {
        self.elastic.set_load(factor);
        let [still, slope, curvature] = self.E_rest;
        self.E_0 = still + factor * (slope + factor * curvature);
        let parts = self.g_still.iter().zip(&self.g_loads);
        for (g_0, (still, loads)) in self.g_0.iter_mut().zip(parts) {
            *g_0 = still + factor * loads;
        }
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        self.elastic.set_external(prescribed, forces);
        let rest = vec![0.0; self.elastic.dofs()];
        self.elastic.gradient(&rest, &mut self.g_0);
        self.E_0 = self.elastic.value(&rest);
        self.elastic.forget();
    }

    fn prescribed(&self) -> &[f64] {
        self.elastic.prescribed()
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        self.elastic.add_quadratic_residual(u, forces)
    }

    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        self.elastic.extend(supports, increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        self.elastic.cell_states(mesh, U)
    }

    fn nodal_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        self.elastic.nodal_states(mesh, U)
    }

    fn cell_errors(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError> {
        self.elastic.cell_errors(mesh, U)
    }

    fn assembled_cells(&self) -> usize {
        self.elastic.assembled_cells()
    }

    fn contact_modulus(&self) -> f64 {
        self.elastic.contact_modulus()
    }

    fn typical_stiffness(&self) -> f64 {
        self.elastic.typical_stiffness()
    }
}
