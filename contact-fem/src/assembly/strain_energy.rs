//! E(u) = ∫_Ω ψ(I + ∇u) dX − f(u) for any element and law.

use std::sync::{Mutex, MutexGuard, PoisonError};

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;
use nalgebra::DMatrix;

use super::dofs::{Dof, DofMap};
use super::extension::Extension;
use super::kinematics::{Cartesian, Kinematics, nodes_of};
use super::laws::Laws;
use super::recovery::errors_of_cells;
use super::scatter::{SlotMap, pattern_and_slots};
use super::trial::Trial;
use super::{BodyEnergy, CellError, CellState};
use crate::element::{Element, Order};
use crate::material::Material;
use crate::mesh::Mesh;
use crate::parallel;
use crate::tensor::{Matrix, Vector};

/// The total potential energy of one body (equation (2) of the paper).
///
/// `K` tells how displacements strain the law `M`.
pub struct StrainEnergy<const D: usize, E: Element<D>, M, K: Kinematics<D, E, M> = Cartesian> {
    laws: Laws<M>,
    dofs: DofMap,
    /// The nodes of the assembled cells, and their quadrature points cell by cell.
    cells: Vec<E::PerNode<usize>>,
    points: Vec<K::Point>,
    /// External forces on all dofs and prescribed displacements, both at full load.
    full_forces: Vec<f64>,
    full_prescribed: Vec<f64>,
    factor: f64,
    prescribed: Vec<f64>,
    pattern: SymmetricPattern,
    slots: SlotMap<D>,
    /// The harmonic extension of the prescribed displacements, built on first use.
    extension: Mutex<Option<Extension<D>>>,
    trial: Mutex<Trial<K::At>>,
    typical_stiffness: f64,
}

impl<const D: usize, E: Element<D>, M: Material<D>> StrainEnergy<D, E, M> {
    /// The energy of `mesh` under nodal `forces` (all dofs, UF) and `prescribed` displacements (one
    /// for each prescribed dof, UL), both at full load; the initial load factor is 0.
    pub fn new(
        mesh: &Mesh<D>,
        material: M,
        dofs: DofMap,
        prescribed: Vec<f64>,
        forces: Vec<f64>,
    ) -> Self {
        Self::with_laws(mesh, &material.into(), dofs, prescribed, forces)
    }

    /// As [`StrainEnergy::new`], with laws that differ from cell to cell or from point to point.
    pub fn with_laws(
        mesh: &Mesh<D>,
        laws: &Laws<M>,
        dofs: DofMap,
        prescribed: Vec<f64>,
        forces: Vec<f64>,
    ) -> Self {
        Self::with_kinematics(mesh, laws, dofs, prescribed, forces)
    }
}

impl<const D: usize, E: Element<D>, M, K> StrainEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    /// As [`StrainEnergy::with_laws`], with any kinematics.
    pub fn with_kinematics(
        mesh: &Mesh<D>,
        laws: &Laws<M>,
        dofs: DofMap,
        prescribed: Vec<f64>,
        forces: Vec<f64>,
    ) -> Self {
        let is_free =
            |&node: &usize| (0..D).any(|i| matches!(dofs.get(D * node + i), Dof::Free(_)));
        let assembled = (0..mesh.len()).filter(|&k| mesh.cell(k).iter().any(is_free));
        let assembled: Vec<usize> = assembled.collect();
        let cells = assembled.iter().map(|&k| nodes_of::<D, E>(mesh.cell(k)));
        let cells: Vec<E::PerNode<usize>> = cells.collect();
        let points = cells.iter().flat_map(|cell| K::points(mesh, cell));
        let points = points.collect();
        let (pattern, slots) = pattern_and_slots(&dofs, cells.iter().map(AsRef::as_ref));
        let mut energy = StrainEnergy {
            laws: laws.of_assembled(&assembled, E::QUADRATURE.len()),
            cells,
            points,
            full_forces: forces,
            prescribed: vec![0.0; prescribed.len()],
            full_prescribed: prescribed,
            factor: 0.0,
            pattern,
            slots,
            extension: Mutex::new(None),
            trial: Mutex::default(),
            dofs,
            typical_stiffness: 0.0,
        };
        energy.typical_stiffness = median_diagonal(&energy);
        energy
    }

    /// Whether some displacement of a node is free.
    fn is_free(&self, node: usize) -> bool {
        (0..D).any(|i| matches!(self.dofs.get(D * node + i), Dof::Free(_)))
    }

    /// Free, or prescribed.
    pub(super) fn dof(&self, dof: usize) -> Dof {
        self.dofs.get(dof)
    }

    /// The displacements of all nodes, component by component.
    pub(super) fn expanded(&self, u: &[f64]) -> Vec<f64> {
        self.dofs.expand(u, &self.prescribed)
    }

    /// The assembled cells with their quadrature points.
    fn assembled(&self) -> impl Iterator<Item = (&E::PerNode<usize>, &[K::Point])> {
        self.cells
            .iter()
            .zip(self.points.chunks_exact(E::QUADRATURE.len()))
    }

    /// The displacements of a cell's nodes.
    fn gather(&self, cell: &E::PerNode<usize>, u: &[f64]) -> E::PerNode<Vector<D>> {
        let mut local = E::per_node(Vector::zeros());
        for (v, &a) in local.as_mut().iter_mut().zip(cell.as_ref()) {
            for i in 0..D {
                v[i] = self.dofs.value(D * a + i, u, &self.prescribed);
            }
        }
        local
    }

    /// The entries ∫ ∇N_a·∇N_b dX of the Laplacian, by nodes and by cells, with b ≤ a within the
    /// cell.
    fn laplacian(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for (cell, points) in self.assembled() {
            let nodes = cell.as_ref();
            for (k, &a) in nodes.iter().enumerate() {
                for (l, &b) in nodes[..=k].iter().enumerate() {
                    let dN = |p: &K::Point| [k, l].map(|n| K::gradients(p).as_ref()[n]);
                    let products = points.iter().map(|p| (K::weight(p), dN(p)));
                    let sum = products.map(|(w, [dN_a, dN_b])| w * dN_a.dot(&dN_b)).sum();
                    entries.push((a, b, sum));
                }
            }
        }
        entries
    }

    /// Calls `evaluate` with the deformations at u, one for each quadrature point.
    fn evaluate(&self, u: &[f64], evaluate: impl FnOnce(&[K::At])) {
        // not under the lock: while a thread waits for others, rayon may give it work that comes here again
        let mut trial = std::mem::take(&mut *lock(&self.trial));
        evaluate(trial.at(u, |deformations| {
            deformations.resize(self.points.len(), K::rest());
            let size = E::QUADRATURE.len();
            parallel::fill(deformations, size, |k, deformations| {
                let local = self.gather(&self.cells[k], u);
                let points = &self.points[k * size..(k + 1) * size];
                for (at, point) in deformations.iter_mut().zip(points) {
                    *at = K::at(point, &local);
                }
            });
        }));
        *lock(&self.trial) = trial;
    }

    /// Releases the memory shared by evaluations at one u.
    pub(super) fn forget(&self) {
        *lock(&self.trial) = Trial::default();
    }

    /// [`BodyEnergy::add_residual`] of a quadratic law: cell by cell, and nothing is stored.
    pub(super) fn add_quadratic_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        self.add_loads(forces);
        let size = E::QUADRATURE.len();
        let U = self.dofs.expand(u, &self.prescribed);
        let shares = |k: usize| {
            let mut local = E::per_node(Vector::<D>::zeros());
            for (v, &a) in local.as_mut().iter_mut().zip(self.cells[k].as_ref()) {
                v.copy_from_slice(&U[D * a..D * (a + 1)]);
            }
            let (mut energy, mut forces) = (0.0, E::per_node(Vector::zeros()));
            for q in k * size..(k + 1) * size {
                let (point, law) = (&self.points[q], self.laws.at(q));
                let at = K::at_for_quadratic(point, &local);
                energy += K::weight(point) * K::energy_density(law, &at);
                let shares = K::forces(law, &at, point);
                let nodes = forces.as_mut().iter_mut().zip(shares.as_ref());
                nodes.for_each(|(force, share)| *force += share);
            }
            (energy, forces)
        };
        let mut sum = 0.0;
        parallel::in_order(self.cells.len(), shares, |k, (energy, own)| {
            sum += energy;
            for (&a, force) in self.cells[k].as_ref().iter().zip(own.as_ref()) {
                (0..D).for_each(|i| forces[D * a + i] += force[i]);
            }
        });
        self.with_potential(sum, u)
    }

    /// Adds the loads to a residual.
    fn add_loads(&self, forces: &mut [f64]) {
        for (r, f) in forces.iter_mut().zip(&self.full_forces) {
            *r -= self.factor * f;
        }
    }

    /// E of this strain energy, `+∞` if that is not finite.
    fn with_potential(&self, strain_energy: f64, u: &[f64]) -> f64 {
        if !strain_energy.is_finite() {
            return f64::INFINITY;
        }
        let forces = self.full_forces.iter().enumerate();
        let forces = forces.filter(|(_, f)| **f != 0.0);
        let work = forces.map(|(d, f)| f * self.dofs.value(d, u, &self.prescribed));
        strain_energy - self.factor * work.sum::<f64>()
    }

    /// Calls `add(dof, force)` with the internal forces ∫ P ∇N_a dX, cell by cell.
    fn internal_forces(&self, u: &[f64], mut add: impl FnMut(usize, f64) + Send) {
        self.evaluate(u, |at| {
            let forces = |q: usize| K::forces(self.laws.at(q), &at[q], &self.points[q]);
            parallel::in_order(at.len(), forces, |q, forces| {
                let cell = self.cells[q / E::QUADRATURE.len()];
                for (&a, force) in cell.as_ref().iter().zip(forces.as_ref()) {
                    #[cfg(planted)]
                    let force = &(match contact_core::planted!(
                        "forces are a hundredth larger than the energy's slope"
                    ) {
                        true => force * 1.01,
                        false => *force,
                    });
                    #[cfg(planted)]
                    let force = &{
                        let mut force = *force;
                        if contact_core::planted!(
                            "the first component of forces is a hundredth larger"
                        ) {
                            force[0] *= 1.01;
                        }
                        if contact_core::planted!("forces leave out every ninth cell")
                            && (q / E::QUADRATURE.len()) % 9 == 0
                        {
                            force *= 0.0;
                        }
                        force
                    };
                    (0..D).for_each(|i| add(D * a + i, force[i]));
                }
            });
        });
    }
}

/// The nodes of a cell, and their displacements (UL).
pub(super) fn gathered<const D: usize, E: Element<D>>(
    cell: &[usize],
    U: &[Vector<D>],
) -> (E::PerNode<usize>, E::PerNode<Vector<D>>) {
    let mut local = E::per_node(Vector::zeros());
    let displacements = local.as_mut().iter_mut().zip(cell);
    displacements.for_each(|(v, &a)| *v = U[a]);
    (nodes_of::<D, E>(cell), local)
}

/// For each node of a cell what each quadrature point weighs in the linear function that is closest to the values at the points.
fn extrapolation<const D: usize, E: Element<D>>() -> Vec<Vec<f64>> {
    let count = E::QUADRATURE.len();
    let barycentric = |q: usize, i: usize| {
        let xi = E::QUADRATURE[q].1;
        if i == 0 {
            1.0 - xi.iter().sum::<f64>()
        } else {
            xi[i - 1]
        }
    };
    let values = DMatrix::from_fn(count, D + 1, barycentric);
    // (BᵀB)⁻¹Bᵀ has the corners' weights; fewer points than corners have a mean alone
    let inverse = (values.transpose() * &values).try_inverse();
    let of_corners = match inverse.filter(|_| count > D) {
        Some(inverse) => inverse * values.transpose(),
        None => DMatrix::from_element(D + 1, count, 1.0 / count as f64),
    };
    let corner = |i: usize| of_corners.row(i);
    let corners = (0..=D).map(|i| corner(i).iter().copied().collect());
    let middles = E::EDGES
        .iter()
        .filter(|_| E::ORDER == Order::Quadratic)
        .map(|&[i, j]| ((corner(i) + corner(j)) * 0.5).iter().copied().collect());
    corners.chain(middles).collect()
}

/// The median of the Hessian's diagonal at u = 0 and the present load; 0 if there are no free dofs.
pub(super) fn median_diagonal(energy: &dyn Energy) -> f64 {
    let mut values = vec![0.0; energy.hessian_pattern().len()];
    energy.hessian(&vec![0.0; energy.dofs()], &mut values);
    let entries = energy.hessian_pattern().iter().zip(values);
    let mut diagonal: Vec<f64> = entries
        .filter_map(|((r, c), v)| (r == c).then_some(v))
        .collect();
    let middle = diagonal.len() / 2;
    if diagonal.is_empty() {
        return 0.0;
    }
    *diagonal.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The contents of the lock, also after a panic: the data are marked valid only once they are
/// complete.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<const D: usize, E: Element<D>, M, K> Energy for StrainEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    fn dofs(&self) -> usize {
        self.dofs.free()
    }

    // E = Σ_cells Σ_q w_q ψ(F_q) − f·U
    fn value(&self, u: &[f64]) -> f64 {
        let mut energy = 0.0;
        self.evaluate(u, |at| {
            let share =
                |q: usize| K::weight(&self.points[q]) * K::energy_density(self.laws.at(q), &at[q]);
            parallel::in_order(at.len(), share, |_, share| energy += share);
        });
        self.with_potential(energy, u)
    }

    // ∂E/∂u_a = Σ_q w_q P ∇N_a − f_a
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        for (dof, f) in self.full_forces.iter().enumerate() {
            if let Dof::Free(i) = self.dofs.get(dof) {
                g[i] = -self.factor * f;
            }
        }
        self.internal_forces(u, |dof, force| {
            if let Dof::Free(i) = self.dofs.get(dof) {
                g[i] += force;
            }
        });
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    // K_ab = Σ_q w_q A : (∇N_a ⊗ ∇N_b), lower triangle
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let size = E::QUADRATURE.len();
        self.evaluate(u, |at| {
            let blocks = |k: usize| {
                let mut blocks = E::per_node(E::per_node(Matrix::<D>::zeros()));
                let own = k * size..(k + 1) * size;
                let points = self.points[own.clone()].iter().zip(&at[own.clone()]);
                for (q, (point, at)) in own.zip(points) {
                    K::add_stiffness(self.laws.at(q), at, point, &mut blocks);
                }
                blocks
            };
            parallel::in_order(self.cells.len(), blocks, |k, blocks| {
                let nodes = self.cells[k].as_ref();
                for (a, row) in blocks.as_ref().iter().enumerate() {
                    for (b, block) in row.as_ref()[..=a].iter().enumerate() {
                        if nodes[a] >= nodes[b] {
                            self.slots.add(k, (a, b), |i, j| block[(i, j)], values);
                        } else {
                            self.slots.add(k, (a, b), |i, j| block[(j, i)], values);
                        }
                    }
                }
            });
        });
    }

    fn is_quadratic(&self) -> bool {
        K::QUADRATIC
    }

    fn domain_len(&self) -> usize {
        if K::NEEDS_POSITIVE_J {
            self.points.len()
        } else {
            0
        }
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        if !K::NEEDS_POSITIVE_J {
            return;
        }
        self.evaluate(u, |at| {
            at.iter()
                .zip(d)
                .for_each(|(at, d)| *d = K::volume_ratio(at));
        });
    }
}

impl<const D: usize, E: Element<D>, M, K> BodyEnergy<D> for StrainEnergy<D, E, M, K>
where
    M: Clone + Send + Sync + 'static,
    K: Kinematics<D, E, M>,
{
    fn set_load(&mut self, factor: f64) {
        self.factor = factor;
        let full = self.full_prescribed.iter();
        self.prescribed = full.map(|full| factor * full).collect();
        lock(&self.trial).invalidate();
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        (self.full_prescribed, self.full_forces) = (prescribed, forces);
        self.set_load(1.0);
    }

    fn prescribed(&self) -> &[f64] {
        &self.prescribed
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        self.add_loads(forces);
        self.internal_forces(u, |dof, force| forces[dof] += force);
        self.value(u)
    }

    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        let mut kept = self
            .extension
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let extension = match kept.take() {
            Some(extension) if extension.supports() == supports => extension,
            _ => Extension::new(supports.clone(), &self.laplacian()),
        };
        kept.insert(extension).extend(increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        let state = |(k, cell): (usize, &[usize])| {
            let (nodes, local) = gathered::<D, E>(cell, U);
            K::state(self.laws.at_centre(k), K::points(mesh, &nodes), &local)
        };
        mesh.cells().enumerate().map(state).collect()
    }

    fn nodal_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        let extrapolation = extrapolation::<D, E>();
        let of_cell = |(k, cell): (usize, &[usize])| {
            let (nodes, local) = gathered::<D, E>(cell, U);
            let law = self.laws.at_centre(k);
            let points = K::points(mesh, &nodes);
            let at_points: Vec<CellState<D>> = points
                .map(|point| K::state(law, std::iter::once(point), &local))
                .collect();
            let at_node =
                |weights: &Vec<f64>| CellState::sum(weights.iter().copied().zip(&at_points));
            extrapolation.iter().map(at_node).collect::<Vec<_>>()
        };
        mesh.cells().enumerate().flat_map(of_cell).collect()
    }

    fn cell_errors(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError> {
        let is_free = |&a: &usize| self.is_free(a);
        let law = |k: usize| {
            let is_assembled = mesh.cell(k).iter().any(is_free);
            is_assembled.then(|| (self.laws.at_centre(k), self.laws.part(k)))
        };
        errors_of_cells::<D, E, M, K>(mesh, U, law)
    }

    fn contact_modulus(&self) -> f64 {
        if self.cells.is_empty() {
            return f64::INFINITY;
        }
        self.laws
            .all()
            .iter()
            .map(K::contact_modulus)
            .fold(f64::INFINITY, f64::min)
    }

    fn assembled_cells(&self) -> usize {
        self.cells.len()
    }

    fn typical_stiffness(&self) -> f64 {
        self.typical_stiffness
    }
}
