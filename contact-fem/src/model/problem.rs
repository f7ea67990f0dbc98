//! A checked scene as the optimiser sees it.

use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::nlp::Bounds;
use contact_core::{ContactProblem, DirectSum, Energy, Error, LoadStepped, Scale};

use super::{Body, BodyId, Geometry, Integration, Passes, Scene, Side};
use crate::assembly::{BodyEnergy, Dof, DofMap};
use crate::contact::motion::Motion;
use crate::contact::rows::{PassRows, Unknowns};
use crate::contact::search::nodes_inside;
use crate::contact::{Master, Pass, Surface, pressure};
use crate::tensor::Vector;

/// The contact problem of a scene at one load: energy over the free dofs of all bodies, and the
/// weak non-penetration constraints of all passes.
///
/// Nodes and dofs of the bodies follow each other in the order of the bodies.
pub struct Problem<const D: usize> {
    scene: Scene<D>,
    energy: DirectSum<Box<dyn BodyEnergy<D>>>,
    dofs: DofMap,
    prescribed: Vec<f64>,
    /// What the supports prescribe, eliminated or not, and the present load factor.
    supports: DofMap,
    factor: f64,
    /// X of all nodes, and where each body's nodes start.
    X: Vec<Vector<D>>,
    first_node: Vec<usize>,
    surfaces: Vec<Surface<D>>,
    passes: Vec<Pass>,
    /// For each pass, whether it is the reversed role of its pair.
    reversed: Vec<bool>,
    bounds: Bounds,
    reach: f64,
    scale: Scale,
    geometry: Geometry,
}

impl<const D: usize> Problem<D> {
    /// Default reach as a share of the scene's diagonal.
    const REACH: f64 = 0.1;
    /// Strains below this are round-off in F = I + ∇u.
    const NO_STRAIN: f64 = 1e-9;
    /// One solve in the reference geometry may well resolve gaps this much finer.
    const FINER: f64 = 0.03;

    pub(super) fn new(scene: Scene<D>, geometry: Geometry) -> Self {
        let energies: Vec<_> = {
            let keep = scene.keep_everything;
            scene
                .bodies()
                .iter()
                .map(|body| body.energy(keep))
                .collect()
        };
        let mut supports = DofMap::default();
        let (mut X, mut first_node) = (Vec::new(), vec![0]);
        for body in scene.bodies() {
            supports.extend(&body.is_prescribed());
            X.extend_from_slice(body.mesh().nodes());
            first_node.push(X.len());
        }
        let dofs = match scene.keep_everything {
            true => DofMap::new(&vec![false; supports.len()]),
            false => supports.clone(),
        };
        let (surfaces, passes, reversed) = surfaces_and_passes(&scene, &X, &first_node);
        let low = X.iter().fold(X[0], |m, x| m.inf(x));
        let high = X.iter().fold(X[0], |m, x| m.sup(x));
        let length = (high - low).norm();
        let small_strain = scene.bodies().iter().all(Body::is_small_strain);
        let frozen = geometry == Geometry::Reference;
        let facet = surfaces
            .iter()
            .map(Surface::smallest_facet)
            .fold(length, f64::min);
        let stiffness = softest(&energies);
        let strain = expected_strain(&scene, stiffness, length, facet);
        let strain = if small_strain {
            strain
        } else {
            strain.max(Self::NO_STRAIN)
        };
        Problem {
            geometry,
            prescribed: vec![0.0; dofs.prescribed()],
            supports,
            factor: 0.0,
            energy: DirectSum::new(energies),
            bounds: match scene.keep_everything {
                true => Bounds::free(dofs.free()),
                false => Bounds::default(),
            },
            reach: match scene.reach {
                _ if scene.keep_everything => f64::INFINITY,
                Some(reach) => reach,
                None if frozen => length,
                None => Self::REACH * length,
            },
            scale: Scale {
                length: strain * length,
                resolution: strain * facet * if frozen { Self::FINER } else { 1.0 },
                area: facet.powi(D as i32 - 1),
                roundoff: f64::EPSILON / strain, // strains are differences of F and I
                energy: stiffness * (strain * length).powi(2),
            },
            scene,
            dofs,
            X,
            first_node,
            surfaces,
            passes,
            reversed,
        }
    }

    /// How far a point looks for another surface (UL).
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The scene it was made from.
    pub fn scene(&self) -> &Scene<D> {
        &self.scene
    }

    /// Reference positions X of all nodes (UL).
    pub fn reference(&self) -> &[Vector<D>] {
        &self.X
    }

    /// The number of the first node of a body.
    pub fn first_node(&self, body: impl Into<BodyId>) -> usize {
        self.first_node[body.into().index()]
    }

    /// The nodes of a body.
    pub fn nodes(&self, body: impl Into<BodyId>) -> std::ops::Range<usize> {
        let body = body.into().index();
        self.first_node[body]..self.first_node[body + 1]
    }

    /// The contact surfaces.
    pub fn surfaces(&self) -> &[Surface<D>] {
        &self.surfaces
    }

    /// The passes: every pair once or in both roles.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// How many nodes of slave surfaces may have a row, over all passes.
    pub fn contact_nodes(&self) -> usize {
        let slaves = self.passes.iter().map(|pass| &self.surfaces[pass.slave]);
        slaves.map(Surface::test_functions_len).sum()
    }

    /// Whether the rows are linear by definition: one solve, no fixed point.
    pub fn is_exact(&self) -> bool {
        !self.scene.keep_everything
            && (self.geometry == Geometry::Reference || self.passes.is_empty())
    }

    /// Free and prescribed dofs of all bodies.
    pub fn dofs(&self) -> &DofMap {
        &self.dofs
    }

    /// The energies of the bodies.
    pub fn body_energies(&self) -> &[Box<dyn BodyEnergy<D>>] {
        self.energy.parts()
    }

    /// The displacements of all nodes (UL) from the free unknowns, at the present load.
    pub fn displacements(&self, u: &[f64]) -> Vec<Vector<D>> {
        self.expand(u, &self.prescribed)
    }

    /// One vector a node from the free components and the prescribed ones.
    fn expand(&self, free: &[f64], prescribed: &[f64]) -> Vec<Vector<D>> {
        let all = self.dofs.expand(free, prescribed);
        all.chunks_exact(D).map(Vector::from_column_slice).collect()
    }

    /// The positions x = X + u of all nodes (UL).
    pub fn positions(&self, u: &[f64]) -> Vec<Vector<D>> {
        let U = self.displacements(u);
        self.X.iter().zip(U).map(|(X, u)| X + u).collect()
    }

    /// As [`Problem::positions`], at another load factor.
    fn positions_at(&self, u: &[f64], factor: f64) -> Vec<Vector<D>> {
        let bodies = self.scene.bodies().iter();
        let prescribed = bodies.flat_map(|body| body.prescribed_values());
        let prescribed: Vec<f64> = prescribed.map(|value| factor * value).collect();
        let U = self.expand(u, &prescribed);
        self.X.iter().zip(U).map(|(X, u)| X + u).collect()
    }

    /// Where contact is looked for: at X or at the positions `now`.
    fn contact_positions<'a>(&'a self, now: &'a [Vector<D>]) -> &'a [Vector<D>] {
        match self.geometry {
            Geometry::Reference => &self.X,
            Geometry::Current => now,
        }
    }

    /// Every surface ready to be projected on, at positions `x`.
    pub fn masters(&self, x: &[Vector<D>]) -> Vec<Master<'_, D>> {
        self.surfaces.iter().map(|s| Master::new(s, x)).collect()
    }

    /// The contact forces Cᵀλ on all nodes (UF).
    pub fn contact_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vector<D>> {
        let mut free = vec![0.0; self.dofs.free()];
        let mut prescribed = vec![0.0; self.dofs.prescribed()];
        gaps.add_forces(lambda, &mut free);
        gaps.add_prescribed_forces(lambda, &mut prescribed);
        self.expand(&free, &prescribed)
    }

    /// The forces (UF) that the supports exert on each body: ∂E/∂U − Cᵀλ summed over its prescribed
    /// dofs.
    pub fn reactions(&self, u: &[f64], contact_forces: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut reactions = Vec::new();
        for body in 0..self.scene.bodies().len() {
            let nodes = self.nodes(body);
            let residual = self.residual(body, u);
            let mut sum = Vector::zeros();
            for (k, node) in nodes.enumerate() {
                for i in 0..D {
                    if self.scene.bodies()[body].prescribed()[D * k + i].is_some() {
                        sum[i] += residual[D * k + i] - contact_forces[node][i];
                    }
                }
            }
            reactions.push(sum);
        }
        reactions
    }

    /// The contact pressure at the nodes of each surface (UF/UL or UF/UL² of reference area,
    /// compression positive), recovered from the nodal forces of the passes that it takes part in; in
    /// [`Geometry::Reference`] along the normals there.
    ///
    /// # Errors
    /// See [`pressure::tractions`].
    pub fn pressures(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<Vec<Vec<f64>>, crate::Error> {
        let now = self.positions(u);
        let x = self.contact_positions(&now);
        let of_surface = |(index, surface): (usize, &Surface<D>)| {
            let takes_part = |pass: &Pass| pass.slave == index || pass.master == index;
            let own = gaps.keys().iter().zip(lambda);
            let own = own.map(
                |(key, &l)| match takes_part(&self.passes[key.pass as usize]) {
                    true => l,
                    false => 0.0,
                },
            );
            let all_forces = self.contact_forces(gaps, &own.collect::<Vec<_>>());
            let forces: Vec<_> = surface.nodes().iter().map(|&a| all_forces[a]).collect();
            let tractions = pressure::tractions(surface, &forces)?;
            let normals = crate::contact::normals::averaged(surface, &surface.gather(x));
            let pairs = tractions.iter().zip(&normals);
            Ok(pairs.map(|(t, n)| -t.dot(n)).collect())
        };
        self.surfaces.iter().enumerate().map(of_surface).collect()
    }

    /// The deepest that any contact node is inside another surface (UL, ≥ 0), over all passes; in
    /// [`Geometry::Reference`] along the normals there.
    pub fn penetration(&self, u: &[f64]) -> f64 {
        self.deepest(u, |surface| vec![1.0; surface.nodes().len()])
    }

    /// As [`Problem::penetration`], with every depth over the facet size around its node.
    pub fn relative_penetration(&self, u: &[f64]) -> f64 {
        self.deepest(u, Surface::node_sizes)
    }

    fn deepest(&self, u: &[f64], units: impl Fn(&Surface<D>) -> Vec<f64>) -> f64 {
        let now = self.positions(u);
        let x = self.contact_positions(&now);
        let masters = self.masters(x);
        let depth = |pass: &Pass| {
            let normals = masters[pass.slave].normals();
            let (slave, master) = (&self.surfaces[pass.slave], &masters[pass.master]);
            let inside = nodes_inside(slave, normals, master, x, &now, self.reach);
            let units = units(slave);
            let depths = inside.iter().map(|(k, gap)| -gap / units[*k]);
            depths.fold(0.0, f64::max)
        };
        self.passes.iter().map(depth).fold(0.0, f64::max)
    }

    /// The rows c(u) = C u + c₀ with projections and normals frozen at `u`.
    pub fn rows(&self, u: &[f64], sampling: Sampling) -> LinearGaps {
        self.rows_of(&self.passes, u, sampling)
    }

    /// As [`Problem::rows`], of any roles of its surfaces.
    pub fn rows_of(&self, passes: &[Pass], u: &[f64], sampling: Sampling) -> LinearGaps {
        let numbered: Vec<_> = passes.iter().copied().enumerate().collect();
        self.rows_of_numbered(&numbered, u, sampling)
    }

    /// The rows of the passes as they were declared, or of those in reversed roles.
    fn rows_in_role(&self, reversed: bool, u: &[f64], sampling: Sampling) -> LinearGaps {
        let passes = self.passes.iter().copied().enumerate();
        let in_role = passes.zip(&self.reversed);
        let in_role = in_role.filter_map(|(pass, role)| (*role == reversed).then_some(pass));
        self.rows_of_numbered(&in_role.collect::<Vec<_>>(), u, sampling)
    }

    fn rows_of_numbered(
        &self,
        passes: &[(usize, Pass)],
        u: &[f64],
        sampling: Sampling,
    ) -> LinearGaps {
        let mut gaps = LinearGaps::new(self.is_exact()).sampled_at(sampling);
        if passes.is_empty() {
            return gaps;
        }
        let now = self.positions(u);
        let x = self.contact_positions(&now);
        let masters = self.masters(x);
        let unknowns = Unknowns {
            dofs: &self.dofs,
            supports: &self.supports,
            prescribed: &self.prescribed,
        };
        for (k, pass) in passes {
            let (slave, master) = (&self.surfaces[pass.slave], &masters[pass.master]);
            let integration = self.scene.integration();
            let rows = PassRows::new(slave, master, x, integration, self.reach, sampling);
            rows.append(*k as u32, &self.X, &unknowns, &mut gaps);
        }
        gaps
    }

    /// Whether a row's name means the same in every iteration and load step, as numbers of points
    /// do not where facets are cut.
    pub fn has_lasting_names(&self, sampling: Sampling) -> bool {
        sampling == Sampling::Nodes || self.scene.integration() != Integration::Exact
    }

    /// The present load factor.
    pub fn load(&self) -> f64 {
        self.factor
    }

    /// ∂E/∂U of a body (UF) for all its dofs, whether prescribed or not.
    pub fn residual(&self, body: impl Into<BodyId>, u: &[f64]) -> Vec<f64> {
        let body = body.into().index();
        let energy = &self.energy.parts()[body];
        let mut residual = vec![0.0; D * self.nodes(body).len()];
        energy.add_residual(&u[self.energy.range(body)], &mut residual);
        residual
    }

    /// The smallest volume ratio of all assembled cells; infinite for small-strain laws.
    pub fn min_j(&self, u: &[f64]) -> f64 {
        let mut J = vec![0.0; self.energy.domain_len()];
        self.energy.domain(u, &mut J);
        J.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The typical stiffness (UF/UL) of the softest body that has free unknowns: a scale that suits a
/// stiffer one would let the softer one's forces drown in the tolerances.
fn softest<const D: usize>(energies: &[Box<dyn BodyEnergy<D>>]) -> f64 {
    let all = energies.iter().map(|e| e.typical_stiffness());
    let softest = all.filter(|k| *k > 0.0).fold(f64::INFINITY, f64::min);
    if softest.is_finite() { softest } else { 1.0 }
}

/// About how large displacements will be over the scene's `length`, at most 1: ten times what is
/// prescribed or what the loads would do to a bar of the given stiffness. Solutions of small-strain
/// scenes then scale with their loads, however small these are.
fn expected_strain<const D: usize>(
    scene: &Scene<D>,
    stiffness: f64,
    length: f64,
    facet: f64,
) -> f64 {
    const NONE: f64 = 1e-6;
    let magnitude =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, v| m + v.abs());
    let loads = |body: &super::Body<D>| magnitude(&mut body.forces().iter().copied());
    let force: f64 = scene.bodies().iter().map(loads).sum();
    let prescribed = scene
        .bodies()
        .iter()
        .flat_map(|body| body.prescribed().iter().flatten());
    let prescribed = prescribed.fold(0.0, |m: f64, v| m.max(v.abs()));
    let stretch = force / stiffness * (facet / length).powi(D as i32 - 2);
    match 10.0 * prescribed.max(stretch) / length {
        strain if strain > 0.0 => strain.min(1.0),
        _ => NONE,
    }
}

/// Each surface once, however many pairs name it; and the passes over them.
fn surfaces_and_passes<const D: usize>(
    scene: &Scene<D>,
    X: &[Vector<D>],
    first_node: &[usize],
) -> (Vec<Surface<D>>, Vec<Pass>, Vec<bool>) {
    let mut sides: Vec<&Side> = Vec::new();
    let mut passes = Vec::new();
    for pair in scene.pairs() {
        let [a, b] = [&pair.first, &pair.second].map(|side| {
            sides.iter().position(|s| *s == side).unwrap_or_else(|| {
                sides.push(side);
                sides.len() - 1
            })
        });
        let (forth, back) = (
            Pass {
                slave: a,
                master: b,
            },
            Pass {
                slave: b,
                master: a,
            },
        );
        match pair.passes {
            _ if a == b => passes.push((forth, false)),
            Passes::Both => passes.extend([(forth, false), (back, true)]),
            Passes::FirstIsSlave => passes.push((forth, false)),
            Passes::SecondIsSlave => passes.push((back, true)),
        }
    }
    let surface = |side: &&Side| {
        let body = side.body.index();
        let mesh = scene.bodies()[body].mesh();
        // the side was checked when the pair was declared
        let facets = mesh.boundary(&side.boundary).unwrap_or_default();
        let offset = first_node[body];
        let facet = |nodes: &[usize]| nodes.iter().map(|a| a + offset).collect();
        let facets: Vec<Vec<usize>> = facets.into_iter().map(facet).collect();
        Surface::new(body, mesh.order(), facets.iter().map(Vec::as_slice), X)
    };
    let (passes, reversed) = passes.into_iter().unzip();
    (sides.iter().map(surface).collect(), passes, reversed)
}

impl<const D: usize> ContactProblem for Problem<D> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn scale(&self) -> Scale {
        self.scale
    }

    fn prescribed_magnitude(&self) -> f64 {
        self.prescribed.iter().fold(0.0, |m, v| m.max(v.abs()))
    }

    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Error::check_vector("u", u, self.dofs.free())?;
        Ok(self.rows_in_role(false, u, sampling))
    }

    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        Error::check_vector("u", u, self.dofs.free())?;
        Ok(self.rows_in_role(true, u, sampling))
    }
}

impl<const D: usize> LoadStepped for Problem<D> {
    fn set_load(&mut self, factor: f64) -> Result<(), Error> {
        self.factor = factor;
        self.prescribed.clear();
        for energy in self.energy.parts_mut() {
            energy.set_load(factor);
            self.prescribed.extend_from_slice(energy.prescribed());
        }
        if self.scene.keep_everything {
            let values = self.scene.bodies().iter().flat_map(Body::prescribed);
            for (dof, value) in values.enumerate() {
                if let Some(value) = value {
                    self.bounds.lower[dof] = factor * value;
                    self.bounds.upper[dof] = factor * value;
                }
            }
        }
        Ok(())
    }

    fn tunnels(&self, u: &[f64], last: &[f64], from: f64) -> Option<f64> {
        let facet = self
            .surfaces
            .iter()
            .map(Surface::facet_size)
            .fold(0.0, f64::max);
        let depth = self.penetration(u);
        if depth > facet.min(self.reach) {
            return Some(depth);
        }
        if self.geometry == Geometry::Reference {
            return None;
        }
        let motion = Motion {
            before: &self.positions_at(last, from),
            after: &self.positions(u),
        };
        let through = |pass: &Pass| {
            let [slave, master] = [pass.slave, pass.master].map(|k| &self.surfaces[k]);
            motion.through(slave, master)
        };
        self.passes.iter().filter_map(through).reduce(f64::max)
    }

    fn lift(&self, u: &[f64], from: f64) -> Vec<f64> {
        let mut lifted = u.to_vec();
        for (body, energy) in self.energy.parts().iter().enumerate() {
            let owner = &self.scene.bodies()[body];
            let full = owner.prescribed_values().into_iter();
            let increments: Vec<f64> = full.map(|p| p * (self.factor - from)).collect();
            let extension = energy.extend(&DofMap::new(&owner.is_prescribed()), &increments);
            for (dof, increment) in (D * self.first_node[body]..).zip(extension) {
                if let Dof::Free(i) = self.dofs.get(dof) {
                    lifted[i] += increment;
                }
            }
        }
        lifted
    }
}
