//! The assembly of a body's energy: E, ∇E, ∇²E over its free unknowns.

mod averaged;
mod boundary;
mod dofs;
mod extension;
mod kinematics;
mod laws;
mod loads;
mod quadratic;
mod recovery;
mod rigid;
mod scatter;
mod strain_energy;
#[cfg(test)]
mod tests;
mod tied;
mod trial;

pub use averaged::AveragedVolume;
pub(crate) use boundary::{OnBoundary, Pressed, Springs, Stretch};
pub use dofs::{DependentDof, Dof, DofMap};
pub use kinematics::{Cartesian, Kinematics, Point, Revolution, RingPoint};
pub use laws::Laws;
pub use loads::{add_body_force, add_traction};
pub use quadratic::QuadraticEnergy;
pub use recovery::CellError;
pub(crate) use rigid::RigidEnergy;
pub use strain_energy::StrainEnergy;
pub(crate) use tied::Tied;

use contact_core::Energy;

use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector};

/// The energy of one body under loads that scale with one factor, or are given.
pub trait BodyEnergy<const D: usize>: Energy + Send + Sync {
    /// Sets dead loads and prescribed displacements to `factor` times their full value.
    fn set_load(&mut self, factor: f64);
    /// Sets the prescribed displacements (UL, in the order of [`DofMap`]) and the dead loads (all dofs, UF) themselves.
    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>);
    /// Sets the pressures that follow boundaries (UF/UL in the plane, UF/UL² in space), one for each; most bodies have none.
    fn set_pressures(&mut self, _pressures: &[f64]) {}
    /// Sets the stiffness of the springs that supports leave which let go, for each unit of reaction (1/UL); most bodies have none.
    fn set_softening(&mut self, _stiffness: f64) {}
    /// The prescribed unknowns at the present load (UL), in the order of [`DofMap`].
    fn prescribed(&self) -> &[f64];
    /// Adds ∂E/∂U, internal minus external forces, at all dofs, free and prescribed, to `forces` (UF), and returns E(u) (UF·UL)
    /// from the strains of the cells. [`Energy::value`] may take it from a stiffness, which costs less and loses the digits that
    /// a rigid motion has more than the strains.
    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64;
    /// The harmonic extension to all dofs of `increments` (UL) at the dofs that `supports`
    /// prescribe: Δv = 0 in the reference configuration, component by component.
    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64>;
    /// Stress and volume ratio at the centre of every cell, including those that are not assembled;
    /// `U` is the displacement of every node.
    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>>;
    /// The same at the nodes of every cell, cell by cell: of the linear function in the cell that is closest to what its quadrature
    /// points have. A linear cell has one point and one state.
    fn nodal_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>>;
    /// The error of every cell, estimated by recovery where the nodes are displaced by `U`.
    fn cell_errors(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError>;
    /// The number of assembled cells; those with all dofs prescribed are not assembled.
    fn assembled_cells(&self) -> usize;
    /// The median of the Hessian's diagonal (UF/UL) at zero displacement.
    fn typical_stiffness(&self) -> f64;
    /// E/(1 − ν²) of the law at zero strain (UF/UL²), from the stiffness to stretch and shear of its first two axes, the least of
    /// several laws; infinite if no cell is assembled.
    fn contact_modulus(&self) -> f64;
}

/// Stress and volume ratio in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellState<const D: usize> {
    /// J = det F; of a body in plane stress, too, where the volume changes by J F₃₃.
    pub J: f64,
    /// Cauchy stress σ (UF/UL²).
    pub sigma: Matrix<D>,
    /// σ_zz in plane strain (UF/UL²), and the stress around the axis of a body of revolution; zero in plane stress and in space.
    pub sigma_zz: f64,
}

impl<const D: usize> CellState<D> {
    /// Σ w s of weights and states.
    pub(crate) fn sum<'a>(weighted: impl Iterator<Item = (f64, &'a Self)>) -> Self {
        let zero = CellState {
            J: 0.0,
            sigma: Matrix::zeros(),
            sigma_zz: 0.0,
        };
        weighted.fold(zero, |sum, (w, state)| CellState {
            J: sum.J + w * state.J,
            sigma: sum.sigma + state.sigma * w,
            sigma_zz: sum.sigma_zz + w * state.sigma_zz,
        })
    }

    /// The von Mises stress √(3/2 s:s), including the out-of-plane stress (UF/UL²).
    pub fn von_mises(&self) -> f64 {
        let mean = (self.sigma.trace() + self.sigma_zz) / 3.0;
        let deviator = self.sigma - Matrix::identity() * mean;
        let out_of_plane = if D == 2 { self.sigma_zz - mean } else { 0.0 };
        (1.5 * (deviator.norm_squared() + out_of_plane * out_of_plane)).sqrt()
    }
}
