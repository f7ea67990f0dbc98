//! The energy of a body some of whose components follow others, as those of nodes that slide along a plane.

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;

use super::{BodyEnergy, CellError, CellState, Dof, DofMap};
use crate::mesh::Mesh;
use crate::tensor::Vector;

/// E(T v + w₀): the unknowns v are the free dofs without those that are tied, which follow by T and, with the load, by w₀.
///
/// ∇E = Tᵀ ∇E_w and ∇²E = Tᵀ ∇²E_w T, entry by entry of the body's own Hessian.
pub(crate) struct Tied<const D: usize> {
    /// Over the free dofs and those that are tied.
    body: Box<dyn BodyEnergy<D>>,
    dofs: DofMap,
    /// The dof of each of the body's unknowns.
    inner: Vec<usize>,
    /// T: the body's unknown, the own one and the coefficient.
    slopes: Vec<(usize, usize, f64)>,
    pattern: SymmetricPattern,
    /// What an entry of the body's Hessian adds to one of the own: both slots, and the factor.
    entries: Vec<(usize, usize, f64)>,
    /// All prescribed values at the present load, and those at load factor 1 (UL).
    prescribed: Vec<f64>,
    full: Vec<f64>,
}

impl<const D: usize> Tied<D> {
    /// `body` has the free dofs and the tied ones of `dofs` as unknowns; `full` are the values at load factor 1 of the prescribed
    /// ones (UL).
    pub fn new(body: Box<dyn BodyEnergy<D>>, dofs: DofMap, full: Vec<f64>) -> Self {
        let is_inner = |dof: &usize| match dofs.get(*dof) {
            Dof::Free(_) => true,
            Dof::Prescribed(_) => dofs.slopes(*dof).next().is_some(),
        };
        let inner: Vec<usize> = (0..dofs.len()).filter(is_inner).collect();
        let of = |j: usize| dofs.slopes(inner[j]);
        let (mut places, mut entries) = (Vec::new(), Vec::new());
        for (slot, (r, c)) in body.hessian_pattern().iter().enumerate() {
            for (i, a) in of(r) {
                for (j, b) in of(c).filter(|(j, _)| r != c || i >= *j) {
                    // both triangles of the body's Hessian meet on the own diagonal
                    let both = if r != c && i == j { 2.0 } else { 1.0 };
                    places.push((i, j));
                    entries.push((slot, both * a * b));
                }
            }
        }
        let (pattern, slots) = SymmetricPattern::from_entries(dofs.free(), &places)
            .expect("free dofs are numbered below their number");
        let entries = entries.into_iter().zip(slots);
        let entries = entries
            .map(|((from, factor), to)| (from, to, factor))
            .collect();
        let slopes = (0..inner.len()).flat_map(|k| of(k).map(move |(i, c)| (k, i, c)));
        Tied {
            slopes: slopes.collect(),
            pattern,
            entries,
            prescribed: vec![0.0; dofs.prescribed()],
            full,
            inner,
            body,
            dofs,
        }
    }

    /// The body's unknowns.
    fn inner(&self, u: &[f64]) -> Vec<f64> {
        let U = self.dofs.expand(u, &self.prescribed);
        self.inner.iter().map(|dof| U[*dof]).collect()
    }
}

impl<const D: usize> Energy for Tied<D> {
    fn dofs(&self) -> usize {
        self.dofs.free()
    }

    fn value(&self, u: &[f64]) -> f64 {
        self.body.value(&self.inner(u))
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        let mut forces = vec![0.0; self.inner.len()];
        self.body.gradient(&self.inner(u), &mut forces);
        g.fill(0.0);
        let slopes = self.slopes.iter();
        slopes.for_each(|(k, i, c)| g[*i] += c * forces[*k]);
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        let mut own = vec![0.0; self.body.hessian_pattern().len()];
        self.body.hessian(&self.inner(u), &mut own);
        values.fill(0.0);
        let entries = self.entries.iter();
        entries.for_each(|(from, to, factor)| values[*to] += factor * own[*from]);
    }

    fn is_quadratic(&self) -> bool {
        self.body.is_quadratic()
    }

    fn domain_len(&self) -> usize {
        self.body.domain_len()
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.body.domain(&self.inner(u), d);
    }
}

impl<const D: usize> BodyEnergy<D> for Tied<D> {
    fn set_load(&mut self, factor: f64) {
        self.prescribed = self.full.iter().map(|value| factor * value).collect();
        self.body.set_load(factor);
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        let mut is_tied = vec![false; prescribed.len()];
        let ties = self.dofs.ties().iter();
        ties.for_each(|tie| is_tied[tie.prescribed] = true);
        let others = prescribed.iter().zip(is_tied);
        let others = others.filter(|(_, is_tied)| !is_tied);
        let others = others.map(|(value, _)| *value).collect();
        self.body.set_external(others, forces);
        self.prescribed = prescribed;
    }

    fn set_pressures(&mut self, pressures: &[f64]) {
        self.body.set_pressures(pressures);
    }

    fn set_softening(&mut self, stiffness: f64) {
        self.body.set_softening(stiffness);
    }

    fn prescribed(&self) -> &[f64] {
        &self.prescribed
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        self.body.add_residual(&self.inner(u), forces)
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
