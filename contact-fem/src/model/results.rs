//! Results derived from a solution: reactions, contact forces, penetrations.

use std::sync::{Arc, PoisonError};

use contact_core::equilibrium::Solution;
use contact_core::friction::Friction;
use contact_core::{Energy, LinearGaps};

use super::problem::Residuals;
use super::{BodyId, Crease, Problem, Undetermined};
use crate::Error;
use crate::audit::{Findings, LeastVolume};
use crate::contact::{Pass, Surface};
use crate::tensor::Vector;

impl<const D: usize> Problem<D> {
    /// The contact forces Cᵀλ on all nodes (UF); NaN if `lambda` has not one value a row, or the rows are of another problem.
    pub fn contact_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vector<D>> {
        let [free, prescribed] = gaps.columns();
        let dofs = self.dofs();
        match lambda.len() == gaps.len() && free <= dofs.free() && prescribed <= dofs.prescribed() {
            true => self.kinematics.contact_forces(gaps, lambda),
            false => vec![Vector::repeat(f64::NAN); self.reference().len()],
        }
    }

    /// The forces of friction on all nodes (UF) of the passes that `counts`; `None` if there are none, and NaN if they are of another problem.
    pub(crate) fn forces_of_friction(
        &self,
        friction: Option<&Friction>,
        counts: impl Fn(&Pass) -> bool,
    ) -> Option<Vec<Vector<D>>> {
        let friction = friction?;
        let (rows, dofs) = (&friction.rows, self.dofs());
        let [free, prescribed] = rows.columns();
        let is_own = friction.forces.len() == rows.len()
            && free <= dofs.free()
            && prescribed <= dofs.prescribed();
        if !is_own {
            return Some(vec![Vector::repeat(f64::NAN); self.reference().len()]);
        }
        let own = rows.keys().iter().zip(&friction.forces).map(|(key, r)| {
            let pass = self.passes().get(key.pass as usize);
            if pass.is_some_and(&counts) { *r } else { 0.0 }
        });
        let own: Vec<f64> = own.collect();
        let (mut free, mut prescribed) = (vec![0.0; dofs.free()], vec![0.0; dofs.prescribed()]);
        rows.add_forces(&own, &mut free);
        rows.add_prescribed_forces(&own, &mut prescribed);
        let all = dofs.forces(&free, &prescribed);
        Some(all.chunks_exact(D).map(Vector::from_column_slice).collect())
    }

    /// The forces of contact and friction on all nodes (UF); [`Problem::contact_forces`] leaves friction out.
    pub fn surface_forces(&self, solution: &Solution) -> Vec<Vector<D>> {
        let mut forces = self.contact_forces(&solution.gaps, &solution.lambda);
        let friction = self.forces_of_friction(solution.friction.as_ref(), |_| true);
        for (force, friction) in forces.iter_mut().zip(friction.iter().flatten()) {
            *force += friction;
        }
        forces
    }

    /// The forces on all nodes (UF) that hold motions which nothing resists, see
    /// [`Solution::held`](contact_core::equilibrium::Solution::held); `None` if there are none, and NaN if their number is wrong.
    pub fn held_forces(&self, held: &[f64]) -> Option<Vec<Vector<D>>> {
        let dofs = self.dofs();
        let forces = match held.len() {
            0 => return None,
            n if n == dofs.free() => dofs.forces(held, &vec![0.0; dofs.prescribed()]),
            _ => vec![f64::NAN; D * self.reference().len()],
        };
        let nodes = forces.chunks_exact(D).map(Vector::from_column_slice);
        Some(nodes.collect())
    }

    /// The contact force of the bodies on each obstacle (UF), without friction, in the order of [`Scene::obstacles`](super::Scene::obstacles);
    /// NaN where [`Problem::contact_forces`] is.
    pub fn obstacle_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vector<D>> {
        let forces = self.forces_of_obstacles(gaps, lambda).into_iter();
        forces
            .map(|forces| -forces.iter().sum::<Vector<D>>())
            .collect()
    }

    /// The forces of each obstacle on all nodes (UF), without friction.
    fn forces_of_obstacles(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vec<Vector<D>>> {
        let of = |index: usize| {
            let own = self.forces_of((gaps, lambda), |pass| {
                self.obstacle_of(*pass) == Some(index)
            });
            own.unwrap_or_else(|| vec![Vector::zeros(); self.reference().len()])
        };
        (0..self.scene.obstacles().len()).map(of).collect()
    }

    /// The forces of each obstacle on all nodes (UF), with friction.
    pub(crate) fn surface_forces_of_obstacles(&self, solution: &Solution) -> Vec<Vec<Vector<D>>> {
        let mut all = self.forces_of_obstacles(&solution.gaps, &solution.lambda);
        for (index, forces) in all.iter_mut().enumerate() {
            let of_it = |pass: &Pass| self.obstacle_of(*pass) == Some(index);
            let friction = self.forces_of_friction(solution.friction.as_ref(), of_it);
            for (force, friction) in forces.iter_mut().zip(friction.iter().flatten()) {
                *force += friction;
            }
        }
        all
    }

    /// The contact forces on all nodes (UF) of the passes that `counts`; `None` if these push nowhere.
    pub(crate) fn forces_of(
        &self,
        (gaps, lambda): (&LinearGaps, &[f64]),
        counts: impl Fn(&Pass) -> bool,
    ) -> Option<Vec<Vector<D>>> {
        let own = gaps.keys().iter().zip(lambda).map(|(key, l)| {
            let pass = self.passes().get(key.pass as usize);
            if pass.is_some_and(&counts) { *l } else { 0.0 }
        });
        let own: Vec<f64> = own.collect();
        let is_none = own.len() == gaps.len() && own.iter().all(|l| *l == 0.0);
        (!is_none).then(|| self.contact_forces(gaps, &own))
    }

    /// E(u) (UF·UL) from the strains of the cells, see [`BodyEnergy::add_residual`](crate::assembly::BodyEnergy::add_residual);
    /// NaN where `u` is [no state](Problem::is_state).
    pub fn energy_at(&self, u: &[f64]) -> f64 {
        self.residuals_and_energy(u).1
    }

    /// ∂E/∂U of a body (UF) for all its dofs, free and prescribed; NaN where it depends on a `u` that is
    /// [no state](Problem::is_state).
    ///
    /// # Panics
    /// If the scene has no such body.
    pub fn residual(&self, body: impl Into<BodyId>, u: &[f64]) -> Vec<f64> {
        self.residuals(u)[body.into().index()].clone()
    }

    /// The same of all bodies, computed once for successive queries at one state.
    pub(crate) fn residuals(&self, u: &[f64]) -> Arc<Vec<Vec<f64>>> {
        self.residuals_and_energy(u).0
    }

    /// Forgets them, where energies have changed at a state and a load.
    pub(super) fn forget_residuals(&mut self) {
        *self
            .residuals
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn residuals_and_energy(&self, u: &[f64]) -> (Arc<Vec<Vec<f64>>>, f64) {
        let mut last = self
            .residuals
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last.as_ref().filter(|l| l.load == self.load() && l.u == u) {
            return (Arc::clone(&known.forces), known.energy);
        }
        let state = self.state(u);
        let bodies = self.energy.parts().iter().enumerate();
        let mut sum = 0.0;
        let forces = bodies.map(|(body, energy)| {
            let mut residual = vec![0.0; D * self.kinematics.nodes(body).len()];
            sum += energy.add_residual(&state[self.energy.range(body)], &mut residual);
            residual
        });
        let forces = Arc::new(forces.collect::<Vec<_>>());
        *last = Some(Residuals {
            load: self.load(),
            u: u.to_vec(),
            forces: Arc::clone(&forces),
            energy: sum,
        });
        (forces, sum)
    }

    /// The reactions (UF) of supports and foundations on each body: ∂E/∂U − Cᵀλ, less forces of ties, summed over its prescribed
    /// dofs, what is left of those of supports that have let go, and what its springs do. NaN if `contact_forces` has not one force a node,
    /// and where they depend on a `u` that is
    /// [no state](Problem::is_state).
    pub fn reactions(&self, u: &[f64], contact_forces: &[Vector<D>]) -> Vec<Vector<D>> {
        let bodies = self.scene.ids().zip(self.scene.bodies());
        if contact_forces.len() != self.reference().len() {
            return bodies.map(|_| Vector::repeat(f64::NAN)).collect();
        }
        let (residuals, U) = (self.residuals(u), self.displacements(u));
        let contact_forces = self.with_tie_forces(u, contact_forces);
        let reaction = |(id, body): (BodyId, &super::Body<D>)| {
            let residual = &residuals[id.index()];
            let contact = &contact_forces[self.nodes(id)];
            #[cfg(planted)]
            let contact = &contact
                .iter()
                .map(
                    |force| match contact_core::planted!("reactions leave out contact") {
                        true => Vector::zeros(),
                        false => *force,
                    },
                )
                .collect::<Vec<Vector<D>>>();
            let mut sum = Vector::zeros();
            let held = body.prescribed().iter().enumerate();
            for (dof, _) in held.filter(|(_, prescribed)| prescribed.is_some()) {
                sum[dof % D] += residual[dof] - contact[dof / D][dof % D];
            }
            for (dof, others) in body.ties() {
                let reaction = residual[*dof] - contact[dof / D][dof % D];
                others
                    .iter()
                    .for_each(|(other, c)| sum[other % D] -= c * reaction);
            }
            let own = U[self.nodes(id)].iter().flatten();
            let U: Vec<f64> = own.copied().collect();
            for (dof, force, _) in body.fading(self.load(), &U) {
                sum[dof % D] += force;
            }
            if !body.foundations().is_empty() {
                let springs = body.foundation_forces(&U).into_iter().enumerate();
                springs.for_each(|(dof, force)| sum[dof % D] += force);
            }
            #[cfg(planted)]
            if contact_core::planted!("reactions have the other sign") {
                sum = -sum;
            }
            #[cfg(planted)]
            if contact_core::planted!("reactions leave out a hundredth") {
                sum *= 0.99;
            }
            sum
        };
        bodies.map(reaction).collect()
    }

    /// The largest depth of a contact node inside another surface (UL, ≥ 0), over all passes, less what is left of an overlap
    /// that [`InitialGaps`](super::InitialGaps) takes; in
    /// [`Geometry::Reference`](super::Geometry) along the reference normals. NaN if `u` is [no state](Problem::is_state).
    pub fn penetration(&self, u: &[f64]) -> f64 {
        match self.is_state(u) {
            true => self.contact.penetration(&self.kinematics, u),
            false => f64::NAN,
        }
    }

    /// As [`Problem::penetration`], each depth divided by the mean size of the facets around its
    /// node.
    pub fn relative_penetration(&self, u: &[f64]) -> f64 {
        match self.is_state(u) {
            true => {
                let sizes = Surface::node_sizes;
                self.contact.deepest(&self.kinematics, u, sizes)
            }
            false => f64::NAN,
        }
    }

    /// What the bodies do to each other and to themselves at `u`, found without the contact search.
    ///
    /// # Errors
    /// A `u` of the wrong length or with values that are not finite.
    pub fn audit(&self, u: &[f64]) -> Result<Findings<D>, Error> {
        contact_core::Error::check_vector("u", u, self.dofs().free())?;
        Ok(self.audit.at(&self.positions(u)))
    }

    /// The smallest volume ratio J within all cells at `u`, bounded from below; `None` without cells. The bound is −∞ in cells whose
    /// nodes depend on a `u` that is [no state](Problem::is_state).
    pub fn least_volume(&self, u: &[f64]) -> Option<LeastVolume<D>> {
        self.audit.least_volume(&self.positions(u))
    }

    /// The rigid motions, to first order, that neither supports nor contact forces of `solution` oppose, as where a block
    /// rests on a plane without friction. States that differ by them are solutions as well; the solvers stay close to the
    /// state that they start from. Empty if `solution` is not of this problem.
    pub fn undetermined(&self, solution: &Solution) -> Vec<Undetermined> {
        let u = &solution.state.u;
        match self.is_state(u) {
            true => super::diagnosis::undetermined(self, solution),
            false => Vec::new(),
        }
    }

    /// The bodies that touch themselves beside a crease, as a notch that closes to its tip, in `solution`. Facets that have a node in common
    /// do not touch each other; so contact there is resolved no better than the facets are, and rows leave it with their forces where a point's
    /// foot comes to such a facet. A body is told if a hundredth of its forces on itself, or more, acts there. Empty if `solution` is not of this problem.
    pub fn creases(&self, solution: &Solution) -> Vec<Crease<D>> {
        match self.is_state(&solution.state.u) {
            true => super::diagnosis::creases(self, solution),
            false => Vec::new(),
        }
    }

    /// The number of quadrature points of the assembled cells where J > 0 does not hold; 0 for
    /// small-strain laws.
    pub fn inverted(&self, u: &[f64]) -> usize {
        let mut J = vec![0.0; self.energy.domain_len()];
        self.energy.domain(&self.state(u), &mut J);
        J.into_iter().filter(|J| J.is_nan() || *J <= 0.0).count()
    }
}

#[cfg(test)]
mod tests {
    use contact_core::LoadStepped;
    use contact_core::gaps::Sampling;

    use crate::mesh::generators::{Diagonals, rectangle};
    use crate::tensor::Vector;
    use crate::{Body, NeoHookean, Scene};

    /// A square of weight 5, hung up on top, on one that does not move at all.
    #[test]
    fn supports_carry_contact_and_weight() {
        let square = |y: f64| {
            let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 1.0], Diagonals::Rising);
            Body::new(mesh.expect("mesh"), NeoHookean::new(1.0, 0.3).expect("law"))
        };
        let (mut lower, mut upper) = (square(0.0), square(1.0));
        lower.prescribe_all([Some(0.0); 2]).expect("support");
        upper.prescribe("top", [Some(0.0); 2]).expect("support");
        upper.body_force([0.0, -5.0]).expect("load");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", upper);
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        problem.set_load(1.0).expect("load");
        let u = vec![0.0; problem.dofs().free()];
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        assert_eq!(gaps.len(), 6);

        // where nothing is strained, the residual is minus the load
        let residual = problem.residual(upper, &u);
        assert!((residual.iter().sum::<f64>() - 5.0).abs() < 1e-14);
        let forces = problem.contact_forces(&gaps, &[2.0; 6]);
        let reactions = problem.reactions(&u, &forces);
        let expected = [2.0 * 6.0, 5.0 / 2.0];
        for (reaction, force) in reactions.iter().zip(expected) {
            assert!(reaction[0].abs() < 1e-14 && (reaction[1] - force).abs() < 1e-14);
        }
        // both sides carry the same force on an area of 1, the middle node's share is the half
        for pressure in problem.pressures(&u, &gaps, &[2.0; 6]).expect("pressures") {
            let resultant = (pressure[0] + 2.0 * pressure[1] + pressure[2]) / 4.0;
            assert!((resultant - 12.0).abs() < 1e-12, "{pressure:?}");
        }
        assert_eq!(problem.inverted(&u), 0);
        assert_eq!(problem.penetration(&u), 0.0);
    }

    /// The two halves of a square's top are surfaces of their own, which share the node between them, each
    /// below a body of its own. Only the right one pushes, and the left half does not feel it, not even in
    /// that node.
    #[test]
    fn pressures_are_those_of_their_own_pairs() {
        let block = |xs: [f64; 3], y: f64| {
            let mesh = rectangle(&xs, &[y, y + 1.0], Diagonals::Rising).expect("mesh");
            Body::new(mesh, NeoHookean::new(1.0, 0.3).expect("law"))
        };
        let mut mesh = rectangle(&[0.0, 0.5, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("mesh");
        mesh.name_boundary("left half", |X| X[1] == 1.0 && X[0] < 0.6);
        mesh.name_boundary("right half", |X| X[1] == 1.0 && X[0] > 0.4);
        let mut lower = Body::new(mesh, NeoHookean::new(1.0, 0.3).expect("law"));
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let (mut left, mut right) = (block([-0.2, 0.1, 0.45], 1.0), block([0.5, 0.75, 1.0], 1.0));
        left.prescribe("top", [Some(0.0); 2]).expect("support");
        right.prescribe("top", [Some(0.0); 2]).expect("support");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let left = scene.add("left", left).on("bottom");
        let right = scene.add("right", right).on("bottom");
        for (half, above) in [("left half", left), ("right half", right)] {
            let passes = crate::model::Passes::FirstIsSlave;
            scene
                .contact_in_passes(lower.on(half), above, passes)
                .expect("a pair");
        }
        let problem = scene.problem().expect("a problem");
        let u = vec![0.0; problem.dofs().free()];
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let rows = gaps.keys().iter().zip(gaps.weights());
        let lambda: Vec<f64> = rows
            .map(|(key, a)| if key.pass == 1 { 3.0 * a } else { 0.0 })
            .collect();
        let pressures = problem.pressures(&u, &gaps, &lambda).expect("pressures");
        let surfaces = problem.surfaces().iter().zip(&pressures);
        // the mesh of the right one does not match
        for (surface, pressures) in surfaces.filter(|(surface, _)| surface.body() < 2) {
            let x = problem.reference();
            let is_pushed = surface.nodes().iter().all(|&a| x[a][0] > 0.46);
            let expected = if is_pushed { 3.0 } else { 0.0 };
            let close = |pressure: &f64| (pressure - expected).abs() < 1e-12;
            assert!(pressures.iter().all(close), "{expected}: {pressures:?}");
        }
    }

    /// Two squares turned by 0.3 on each other: forces a_i along the turned normal are a pressure of 1.
    #[test]
    fn pressures_are_along_the_turned_normals() {
        let (sin, cos) = 0.3f64.sin_cos();
        let turn = |X: &Vector<2>| {
            [
                cos * X[0] - sin * X[1] - X[0],
                sin * X[0] + cos * X[1] - X[1],
            ]
        };
        let square = |y: f64, side: &str| {
            let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 0.5, y + 1.0], Diagonals::Rising);
            let mut body = Body::new(mesh.expect("mesh"), NeoHookean::new(1.0, 0.3).expect("law"));
            for node in body.mesh().boundary_nodes(side).expect("named") {
                let value = turn(&body.mesh().nodes()[node]).map(Some);
                body.prescribe_nodes(&[node], value).expect("support");
            }
            body
        };
        let mut scene = Scene::new();
        let lower = scene.add("lower", square(0.0, "bottom")).on("top");
        let upper = scene.add("upper", square(1.0, "top")).on("bottom");
        scene.contact(lower, upper).expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        problem.set_load(1.0).expect("load");
        let mut u = vec![0.0; problem.dofs().free()];
        for (node, X) in problem.reference().iter().enumerate() {
            for (i, value) in turn(X).into_iter().enumerate() {
                if let crate::assembly::Dof::Free(k) = problem.dofs().get(2 * node + i) {
                    u[k] = value;
                }
            }
        }
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda: Vec<f64> = gaps.weights().iter().map(|a| 0.5 * a).collect();
        for pressure in problem
            .pressures(&u, &gaps, &lambda)
            .expect("pressures")
            .iter()
            .flatten()
        {
            assert!((pressure - 1.0).abs() < 1e-12, "{pressure}");
        }
        assert!(problem.penetration(&u) < 1e-12);
    }
}
