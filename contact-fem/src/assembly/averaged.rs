//! Linear cells whose changes of volume are averaged around the nodes, for laws that are nearly incompressible.

use contact_core::Energy;
use contact_core::linear::SymmetricPattern;

use super::kinematics::{Point, nodes_of, points_of};
use super::strain_energy::median_diagonal;
use super::{BodyEnergy, CellError, CellState, Dof, DofMap, StrainEnergy};
use crate::element::{Element, P1};
use crate::material::{Deformation, Material, Volumetric};
use crate::mesh::Mesh;
use crate::tensor::{Matrix, Vector};

/// E(u) = ∫ ψ₀(F) dX + Σ_a V_a k/2 θ(J̄_a)² − f(u), with the volume ratio averaged around each node a:
/// J̄_a = Σ_c V_c J_c / ((D + 1) V_a) over its cells, and V_a = Σ_c V_c / (D + 1). The law is ψ = ψ₀ + k/2 θ(J)², see
/// [`Volumetric`].
///
/// A plain mesh has more cells than nodes, and with a large k each of them holds its volume: too few motions are left. Here only one change of volume
/// a node is held. Where k is negative, at ν < 0, averaging makes a body stiffer. After J. Bonet and A. J.
/// Burton, A simple average nodal pressure tetrahedral element for incompressible and nearly incompressible dynamic
/// explicit applications, Commun. Numer. Meth. Engng 14 (1998) 437–449. Each node is coupled with the neighbours of its
/// neighbours.
pub struct AveragedVolume<const D: usize, M: Material<D>>
where
    P1: Element<D>,
{
    /// ψ₀, the loads and the supports.
    elastic: StrainEnergy<D, P1, M>,
    /// k (UF/UL²).
    modulus: f64,
    contact_modulus: f64,
    cells: Vec<Cell<D>>,
    /// V_a of each node (UL² or UL³).
    volumes: Vec<f64>,
    /// The cells of each node, and the nodes of these; none where all components of all of them are prescribed.
    patches: Vec<Patch>,
    pattern: SymmetricPattern,
    /// The slots of the entries of `elastic`.
    slots: Vec<usize>,
    typical_stiffness: f64,
}

/// A cell with its one quadrature point.
struct Cell<const D: usize>
where
    P1: Element<D>,
{
    nodes: <P1 as Element<D>>::PerNode<usize>,
    point: Point<D, P1>,
}

#[derive(Clone, Default)]
struct Patch {
    cells: Vec<usize>,
    nodes: Vec<usize>,
}

/// The changes of volume at one state.
struct Volumes<const D: usize> {
    /// v of each cell, J or tr ∇u, and F⁻ᵀ there, or I.
    cells: Vec<(f64, Matrix<D>)>,
    /// θ(v̄) of each node and its first two derivatives.
    nodes: Vec<[f64; 3]>,
}

impl<const D: usize, M: Volumetric<D>> AveragedVolume<D, M>
where
    P1: Element<D>,
{
    /// The energy of a linear `mesh`; the other arguments are those of [`StrainEnergy::new`].
    pub fn new(
        mesh: &Mesh<D>,
        material: &M,
        dofs: DofMap,
        prescribed: Vec<f64>,
        forces: Vec<f64>,
    ) -> Self {
        let whole = |law: M| {
            let (dofs, prescribed, forces) = (dofs.clone(), prescribed.clone(), forces.clone());
            StrainEnergy::<D, P1, M>::new(mesh, law, dofs, prescribed, forces)
        };
        let (rest, modulus) = material.split();
        let elastic = whole(rest);
        let cell = |nodes: &[usize]| {
            let nodes = nodes_of::<D, P1>(nodes);
            let mut points = points_of::<D, P1>(mesh, &nodes, P1::QUADRATURE);
            points.next().map(|point| Cell { nodes, point })
        };
        let cells: Vec<Cell<D>> = mesh.cells().filter_map(cell).collect();
        let mut volumes = vec![0.0; mesh.nodes().len()];
        let mut patches = vec![Patch::default(); mesh.nodes().len()];
        for (c, cell) in cells.iter().enumerate() {
            for &a in cell.nodes.as_ref() {
                volumes[a] += cell.point.weight / (D + 1) as f64;
                patches[a].cells.push(c);
                patches[a].nodes.extend_from_slice(cell.nodes.as_ref());
            }
        }
        let is_free = |a: &usize| (0..D).any(|i| matches!(dofs.get(D * a + i), Dof::Free(_)));
        for patch in &mut patches {
            patch.nodes.sort_unstable();
            patch.nodes.dedup();
            if !patch.nodes.iter().any(is_free) {
                *patch = Patch::default();
            }
        }
        let (pattern, slots) = pattern_of::<D>(&dofs, elastic.hessian_pattern(), &patches);
        let mut energy = AveragedVolume {
            contact_modulus: whole(material.clone()).contact_modulus(),
            elastic,
            modulus,
            cells,
            volumes,
            patches,
            pattern,
            slots,
            typical_stiffness: 0.0,
        };
        energy.typical_stiffness = median_diagonal(&energy);
        energy
    }
}

/// The pattern over the free dofs in which all nodes of a patch are coupled, and the slots of the entries of `elastic`.
fn pattern_of<const D: usize>(
    dofs: &DofMap,
    elastic: &SymmetricPattern,
    patches: &[Patch],
) -> (SymmetricPattern, Vec<usize>) {
    let of_patch = |patch: &Patch| -> Vec<(usize, usize)> {
        let rows = patch.nodes.iter().enumerate();
        rows.flat_map(|(k, &a)| patch.nodes[..=k].iter().map(move |&b| (a, b)))
            .collect()
    };
    let mut pairs: Vec<(usize, usize)> = patches.iter().flat_map(of_patch).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let free = |node: usize| {
        (0..D).filter_map(move |i| match dofs.get(D * node + i) {
            Dof::Free(k) => Some(k),
            Dof::Prescribed(_) => None,
        })
    };
    let mut entries: Vec<(usize, usize)> = elastic.iter().collect();
    let own = entries.len();
    for (a, b) in pairs {
        for row in free(a) {
            entries.extend(free(b).map(|column| (row, column)));
        }
    }
    let (pattern, mut slots) = SymmetricPattern::from_entries(dofs.free(), &entries)
        .expect("free dofs are numbered below their number");
    slots.truncate(own);
    (pattern, slots)
}

impl<const D: usize, M: Material<D>> AveragedVolume<D, M>
where
    P1: Element<D>,
{
    /// The displacements of all nodes.
    fn displacements(&self, u: &[f64]) -> Vec<Vector<D>> {
        let all = self.elastic.expanded(u);
        all.chunks_exact(D).map(Vector::from_column_slice).collect()
    }

    /// The changes of volume where the nodes are displaced by `U`.
    fn volumes(&self, U: &[Vector<D>]) -> Volumes<D> {
        let of_cell = |cell: &Cell<D>| {
            let F = cell.point.deformation(&self.gathered(cell, U));
            match M::QUADRATIC {
                true => ((F - Matrix::identity()).trace(), Matrix::identity()),
                false => {
                    let at = Deformation::new(F);
                    (at.J, at.F_inv_T)
                }
            }
        };
        let cells: Vec<(f64, Matrix<D>)> = self.cells.iter().map(of_cell).collect();
        let mut means = vec![0.0; self.volumes.len()];
        for (cell, (v, _)) in self.cells.iter().zip(&cells) {
            for &a in cell.nodes.as_ref() {
                means[a] += self.share(cell, a) * v;
            }
        }
        let theta = |v: f64| match M::QUADRATIC {
            true => [v, 1.0, 0.0],
            false => [v.ln(), 1.0 / v, -1.0 / (v * v)],
        };
        Volumes {
            cells,
            nodes: means.into_iter().map(theta).collect(),
        }
    }

    fn gathered(&self, cell: &Cell<D>, U: &[Vector<D>]) -> <P1 as Element<D>>::PerNode<Vector<D>> {
        let mut local = P1::per_node(Vector::zeros());
        let nodes = local.as_mut().iter_mut().zip(cell.nodes.as_ref());
        nodes.for_each(|(u, &a)| *u = U[a]);
        local
    }

    /// The share of a cell in the mean of one of its nodes.
    fn share(&self, cell: &Cell<D>, node: usize) -> f64 {
        cell.point.weight / ((D + 1) as f64 * self.volumes[node])
    }

    /// Σ_a V_a k/2 θ_a²
    fn energy(&self, at: &Volumes<D>) -> f64 {
        let terms = self.volumes.iter().zip(&at.nodes).zip(&self.patches);
        let terms = terms.filter(|(_, patch)| !patch.cells.is_empty());
        let sum: f64 = terms.map(|((V, [theta, ..]), _)| V * theta * theta).sum();
        0.5 * self.modulus * sum
    }

    /// ∂E/∂v_c of each cell: Σ_a k V_a θ_a θ_a′ ∂v̄_a/∂v_c (UF·UL), over the nodes that `counts`.
    fn pressures<'a>(
        &'a self,
        at: &'a Volumes<D>,
        counts: impl Fn(usize) -> bool + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        self.cells.iter().map(move |cell| {
            let of_node = |&a: &usize| {
                let [theta, slope, _] = at.nodes[a];
                self.modulus * self.volumes[a] * theta * slope * self.share(cell, a)
            };
            let nodes = cell.nodes.as_ref().iter().filter(|a| counts(**a));
            nodes.map(of_node).sum()
        })
    }

    /// Whether the change of volume around a node varies with the unknowns.
    fn is_assembled(&self, node: usize) -> bool {
        !self.patches[node].cells.is_empty()
    }

    /// Calls `add(dof, force)` with the forces of the changes of volume: ∂v_c/∂u_a = J F⁻ᵀ∇N_a, or ∇N_a.
    fn forces(&self, at: &Volumes<D>, mut add: impl FnMut(usize, f64)) {
        let pressures = self.pressures(at, |a| self.is_assembled(a));
        for (cell, (pressure, own)) in self.cells.iter().zip(pressures.zip(&at.cells)) {
            let gradients = cell.point.gradients.as_ref();
            for (&a, dN) in cell.nodes.as_ref().iter().zip(gradients) {
                let force = Self::slope(own, dN) * pressure;
                (0..D).for_each(|i| add(D * a + i, force[i]));
            }
        }
    }

    /// ∂v/∂u_a in a cell.
    fn slope((v, F_inv_T): &(f64, Matrix<D>), dN: &Vector<D>) -> Vector<D> {
        match M::QUADRATIC {
            true => *dN,
            false => F_inv_T * dN * *v,
        }
    }

    fn slot(&self, row: usize, column: usize) -> usize {
        let slots = self.pattern.column(column);
        let rows = &self.pattern.rows()[slots.clone()];
        slots.start + rows.partition_point(|&other| other < row)
    }

    /// Adds Σ_c p_c ∂²v_c/∂u² with ∂²J/∂u_a∂u_b = J (m_a ⊗ m_b − m_b ⊗ m_a), m = F⁻ᵀ∇N.
    fn add_curvature(&self, at: &Volumes<D>, values: &mut [f64]) {
        let pressures = self.pressures(at, |a| self.is_assembled(a));
        for (cell, (pressure, (J, F_inv_T))) in self.cells.iter().zip(pressures.zip(&at.cells)) {
            let nodes = cell.nodes.as_ref();
            let m = cell.point.gradients.as_ref().iter().map(|dN| F_inv_T * dN);
            let m: Vec<Vector<D>> = m.collect();
            for (a, b) in (0..=D).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let block = (m[a] * m[b].transpose() - m[b] * m[a].transpose()) * (pressure * J);
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let places = (self.dof(nodes[a], i), self.dof(nodes[b], j));
                    if let (Some(row), Some(column)) = places {
                        values[self.slot(row.max(column), row.min(column))] += block[(i, j)];
                    }
                }
            }
        }
    }

    /// Adds Σ_a k V_a (θ′² + θ θ″) ∂v̄_a ⊗ ∂v̄_a.
    fn add_products(&self, at: &Volumes<D>, values: &mut [f64]) {
        let mut entries: Vec<(usize, f64)> = Vec::new();
        for (a, patch) in self.patches.iter().enumerate() {
            let [theta, slope, curvature] = at.nodes[a];
            let factor = self.modulus * self.volumes[a] * (slope * slope + theta * curvature);
            let mut gradient = vec![Vector::<D>::zeros(); patch.nodes.len()];
            for &c in &patch.cells {
                let (cell, share) = (&self.cells[c], self.share(&self.cells[c], a));
                let gradients = cell.point.gradients.as_ref();
                for (node, dN) in cell.nodes.as_ref().iter().zip(gradients) {
                    let place = patch.nodes.partition_point(|other| other < node);
                    gradient[place] += Self::slope(&at.cells[c], dN) * share;
                }
            }
            entries.clear();
            for (&node, own) in patch.nodes.iter().zip(&gradient) {
                let free = (0..D).filter_map(|i| Some((self.dof(node, i)?, own[i])));
                entries.extend(free);
            }
            for (k, &(row, x)) in entries.iter().enumerate() {
                for &(column, y) in &entries[..=k] {
                    values[self.slot(row.max(column), row.min(column))] += factor * x * y;
                }
            }
        }
    }

    /// The free unknown of a node's component.
    fn dof(&self, node: usize, i: usize) -> Option<usize> {
        match self.elastic.dof(D * node + i) {
            Dof::Free(k) => Some(k),
            Dof::Prescribed(_) => None,
        }
    }
}

impl<const D: usize, M: Material<D>> Energy for AveragedVolume<D, M>
where
    P1: Element<D>,
{
    fn dofs(&self) -> usize {
        self.elastic.dofs()
    }

    fn value(&self, u: &[f64]) -> f64 {
        let elastic = self.elastic.value(u);
        if !elastic.is_finite() {
            return f64::INFINITY;
        }
        let sum = elastic + self.energy(&self.volumes(&self.displacements(u)));
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.elastic.gradient(u, g);
        let at = self.volumes(&self.displacements(u));
        self.forces(&at, |dof, force| {
            if let Dof::Free(k) = self.elastic.dof(dof) {
                g[k] += force;
            }
        });
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        let mut own = vec![0.0; self.slots.len()];
        self.elastic.hessian(u, &mut own);
        values.fill(0.0);
        for (&slot, value) in self.slots.iter().zip(own) {
            values[slot] += value;
        }
        let at = self.volumes(&self.displacements(u));
        if !M::QUADRATIC {
            self.add_curvature(&at, values);
        }
        self.add_products(&at, values);
    }

    fn is_quadratic(&self) -> bool {
        M::QUADRATIC
    }

    fn domain_len(&self) -> usize {
        self.elastic.domain_len()
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.elastic.domain(u, d);
    }
}

impl<const D: usize, M: Material<D>> BodyEnergy<D> for AveragedVolume<D, M>
where
    P1: Element<D>,
{
    fn set_load(&mut self, factor: f64) {
        self.elastic.set_load(factor);
    }

    fn set_external(&mut self, prescribed: Vec<f64>, forces: Vec<f64>) {
        self.elastic.set_external(prescribed, forces);
    }

    fn prescribed(&self) -> &[f64] {
        self.elastic.prescribed()
    }

    fn add_residual(&self, u: &[f64], forces: &mut [f64]) -> f64 {
        let elastic = match M::QUADRATIC {
            true => self.elastic.add_quadratic_residual(u, forces),
            false => self.elastic.add_residual(u, forces),
        };
        let at = self.volumes(&self.displacements(u));
        self.forces(&at, |dof, force| forces[dof] += force);
        elastic + self.energy(&at)
    }

    fn extend(&self, supports: &DofMap, increments: &[f64]) -> Vec<f64> {
        self.elastic.extend(supports, increments)
    }

    fn cell_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        let at = self.volumes(U);
        let mut states = self.elastic.cell_states(mesh, U);
        let own = self.cells.iter().zip(self.pressures(&at, |_| true));
        for (state, (cell, pressure)) in states.iter_mut().zip(own) {
            let mean = pressure / cell.point.weight;
            state.sigma += Matrix::identity() * mean;
            state.sigma_zz += if D == 2 { mean } else { 0.0 };
        }
        states
    }

    fn nodal_states(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellState<D>> {
        // linear cells have one state
        let states = self.cell_states(mesh, U).into_iter();
        states.flat_map(|state| vec![state; D + 1]).collect()
    }

    // of ψ₀ as of any law; of the rest ∫ (p − p̄)²/k, with p linear between the nodes and its mean p̄
    fn cell_errors(&self, mesh: &Mesh<D>, U: &[Vector<D>]) -> Vec<CellError> {
        let at = self.volumes(U);
        let mut errors = self.elastic.cell_errors(mesh, U);
        let d = (D + 1) as f64;
        for (error, cell) in errors.iter_mut().zip(&self.cells) {
            let nodes = cell.nodes.as_ref();
            if !nodes.iter().any(|&a| self.is_assembled(a)) {
                continue;
            }
            let of_nodes = nodes.iter().map(|&a| at.nodes[a]);
            let stored: f64 = of_nodes.clone().map(|[theta, ..]| theta * theta).sum();
            error.energy += 0.5 * self.modulus * cell.point.weight * stored / d;
            let pressures = of_nodes.map(|[theta, slope, _]| self.modulus * theta * slope);
            let mean = pressures.clone().sum::<f64>() / d;
            let apart: f64 = pressures.map(|p| (p - mean).powi(2)).sum();
            let square = cell.point.weight * apart / (d * (d + 1.0) * self.modulus);
            error.square = (error.square + square).max(0.0);
        }
        errors
    }

    fn assembled_cells(&self) -> usize {
        self.elastic.assembled_cells()
    }

    fn typical_stiffness(&self) -> f64 {
        self.typical_stiffness
    }

    fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }
}

#[cfg(test)]
mod tests;
