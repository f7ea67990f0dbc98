//! Energies of a body's boundary: elastic foundations, pressures that follow it, and springs that supports leave which let go.

mod pressed;
mod springs;
#[cfg(test)]
mod tests;

pub(crate) use pressed::Pressed;
pub(crate) use springs::{Springs, Stretch};

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;

use super::{BodyEnergy, CellError, CellState, Dof, DofMap};
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// The energy of a body and of its boundary: E + Σ ½ UᵀS U + Σ p V + Σ ½ s |r| (U − U₀)².
///
/// The Hessian has the pattern of the body's: the nodes of a facet are nodes of a cell.
pub(crate) struct OnBoundary<const D: usize> {
    body: Box<dyn BodyEnergy<D>>,
    dofs: DofMap,
    springs: Vec<Springs>,
    /// What the springs add to the Hessian: slots and values (UF/UL).
    entries: Vec<(usize, f64)>,
    pressed: Vec<Pressed<D>>,
    /// For each of them the slots of its pairs; `None` where a dof is prescribed.
    slots: Vec<Vec<Option<usize>>>,
    /// The present pressures (UF/UL in the plane, UF/UL² in space).
    pressures: Vec<f64>,
    /// Dofs on springs, where these are fixed, U₀ (UL), and the reactions to which their stiffness is proportional (UF).
    softening: Vec<(usize, f64, f64)>,
    /// The places of their diagonal entries in the Hessian, and these reactions.
    diagonal: Vec<(usize, f64)>,
    /// The present stiffness s, for each unit of reaction (1/UL).
    stiffness: f64,
}

impl<const D: usize> OnBoundary<D> {
    /// Springs and pressed facets on the boundary of a body whose free dofs are those of `dofs`.
    pub fn new(
        body: Box<dyn BodyEnergy<D>>,
        dofs: DofMap,
        springs: Vec<Springs>,
        pressed: Vec<Pressed<D>>,
    ) -> Self {
        let pattern = body.hessian_pattern();
        let slot = |(r, c): (usize, usize)| match (dofs.get(r), dofs.get(c)) {
            (Dof::Free(r), Dof::Free(c)) => pattern.slot(r, c),
            _ => None,
        };
        let entries = springs.iter().flat_map(Springs::entries);
        let entries = entries.filter_map(|&(r, c, s)| Some((slot((r, c))?, s)));
        OnBoundary {
            entries: entries.collect(),
            slots: pressed
                .iter()
                .map(|own| own.pairs().map(slot).collect())
                .collect(),
            pressures: vec![0.0; pressed.len()],
            pressed,
            springs,
            softening: Vec::new(),
            diagonal: Vec::new(),
            stiffness: 0.0,
            dofs,
            body,
        }
    }

    /// Puts free dofs on springs that are fixed at the displacements U₀ (UL), of a stiffness proportional to reactions (UF).
    pub fn with_softening(mut self, softening: Vec<(usize, f64, f64)>) -> Self {
        let pattern = self.body.hessian_pattern();
        let slot = |&(dof, _, share): &(usize, f64, f64)| match self.dofs.get(dof) {
            Dof::Free(i) => Some((pattern.slot(i, i)?, share)),
            _ => None,
        };
        self.diagonal = softening.iter().filter_map(slot).collect();
        self.softening = softening;
        self
    }

    /// The displacements of all dofs (UL).
    fn expanded(&self, u: &[f64]) -> Vec<f64> {
        self.dofs.expand(u, self.body.prescribed())
    }

    /// Adds ∂E/∂U of the boundary at all dofs to `forces` (UF), and returns what the springs store (UF·UL).
    fn add_forces(&self, U: &[f64], forces: &mut [f64]) -> f64 {
        for (own, p) in self.pushed() {
            own.add_areas(U, *p, forces);
        }
        for &(dof, place, share) in &self.softening {
            forces[dof] += self.stiffness * share * (U[dof] - place);
        }
        let springs = self.springs.iter();
        let stored: f64 = springs.map(|own| own.add_forces(U, forces)).sum();
        stored + self.stored_in_softening(U)
    }

    /// Σ ½ s |r| (U − U₀)².
    fn stored_in_softening(&self, U: &[f64]) -> f64 {
        let own = self.softening.iter();
        let squares = own.map(|&(dof, place, share)| share * (U[dof] - place).powi(2));
        0.5 * self.stiffness * squares.sum::<f64>()
    }

    /// Σ p V.
    fn potential(&self, U: &[f64]) -> f64 {
        let is_free = |dof: usize| matches!(self.dofs.get(dof), Dof::Free(_));
        let all = self.pushed();
        all.map(|(own, p)| p * own.volume(U, is_free)).sum()
    }

    /// The boundaries with a pressure other than 0.
    fn pushed(&self) -> impl Iterator<Item = (&Pressed<D>, &f64)> {
        let all = self.pressed.iter().zip(&self.pressures);
        all.filter(|(_, p)| **p != 0.0)
    }
}

impl<const D: usize> Energy for OnBoundary<D> {
    fn dofs(&self) -> usize {
        self.body.dofs()
    }

    fn value(&self, u: &[f64]) -> f64 {
        let U = self.expanded(u);
        let stored: f64 = self.springs.iter().map(|own| own.energy(&U)).sum();
        self.body.value(u) + stored + self.stored_in_softening(&U) + self.potential(&U)
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.body.gradient(u, g);
        let U = self.expanded(u);
        let mut forces = vec![0.0; U.len()];
        self.add_forces(&U, &mut forces);
        for (dof, force) in forces.into_iter().enumerate() {
            if let Dof::Free(i) = self.dofs.get(dof) {
                g[i] += force;
            }
        }
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.body.hessian_pattern()
    }

    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        self.body.hessian(u, values);
        let entries = self.entries.iter();
        entries.for_each(|(slot, s)| values[*slot] += s);
        let diagonal = self.diagonal.iter();
        diagonal.for_each(|(slot, share)| values[*slot] += self.stiffness * share);
        let all = self.pressed.iter().zip(&self.pressures).zip(&self.slots);
        let mut pushed = all.filter(|((_, p), _)| **p != 0.0).peekable();
        if pushed.peek().is_none() {
            return;
        }
        let U = self.expanded(u);
        for ((own, p), slots) in pushed {
            let mut slots = slots.iter();
            own.slopes(&U, |slope| {
                if let Some(Some(slot)) = slots.next() {
                    values[*slot] += p * slope;
                }
            });
        }
    }

    fn is_quadratic(&self) -> bool {
        self.body.is_quadratic() && self.pressed.is_empty()
    }

    fn domain_len(&self) -> usize {
        self.body.domain_len()
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.body.domain(u, d);
    }
}

impl<const D: usize> BodyEnergy<D> for OnBoundary<D> {
    fn set_load(&mut self, factor: f64) {
        self.body.set_load(factor);
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        self.body.set_external(prescribed, forces);
    }

    fn set_pressures(&mut self, pressures: &[f64]) {
        let own = self.pressures.iter_mut().zip(pressures);
        own.for_each(|(own, p)| *own = *p);
    }

    fn set_softening(&mut self, stiffness: f64) {
        self.stiffness = stiffness;
    }

    fn prescribed(&self) -> &[f64] {
        self.body.prescribed()
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        let U = self.expanded(u);
        self.body.add_residual(u, forces) + self.add_forces(&U, forces) + self.potential(&U)
    }

    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        self.body.extend(supports, increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        self.body.cell_states(mesh, U)
    }

    fn nodal_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        self.body.nodal_states(mesh, U)
    }

    fn cell_errors(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError> {
        self.body.cell_errors(mesh, U)
    }

    fn assembled_cells(&self) -> usize {
        self.body.assembled_cells()
    }

    fn typical_stiffness(&self) -> f64 {
        self.body.typical_stiffness()
    }

    fn contact_modulus(&self) -> f64 {
        self.body.contact_modulus()
    }
}
