//! Results derived from a solution: reactions, contact forces, pressures, penetrations.

use contact_core::equilibrium::Solution;
use contact_core::{Energy, LinearGaps};

use super::{BodyId, Problem, Undetermined};
use crate::Error;
use crate::audit::Findings;
use crate::contact::{Pass, Surface, pressure};
use crate::tensor::Vector;

impl<const D: usize> Problem<D> {
    /// The contact forces Cᵀλ on all nodes (UF).
    pub fn contact_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<Vector<D>> {
        self.kinematics.contact_forces(gaps, lambda)
    }

    /// ∂E/∂U of a body (UF) for all its dofs, free and prescribed.
    pub fn residual(&self, body: impl Into<BodyId>, u: &[f64]) -> Vec<f64> {
        let body = body.into().index();
        let mut residual = vec![0.0; D * self.kinematics.nodes(body).len()];
        self.energy.parts()[body].add_residual(&u[self.energy.range(body)], &mut residual);
        residual
    }

    /// The reactions (UF) of the supports on each body: ∂E/∂U − Cᵀλ summed over its prescribed
    /// dofs.
    pub fn reactions(&self, u: &[f64], contact_forces: &[Vector<D>]) -> Vec<Vector<D>> {
        let bodies = self.scene.ids().zip(self.scene.bodies());
        let reaction = |(id, body): (BodyId, &super::Body<D>)| {
            let residual = self.residual(id, u);
            let contact = contact_forces[self.nodes(id)].iter().flatten();
            let rest = residual.iter().zip(contact).zip(body.prescribed());
            let mut sum = Vector::zeros();
            for (dof, ((residual, contact), prescribed)) in rest.enumerate() {
                if prescribed.is_some() {
                    sum[dof % D] += residual - contact;
                }
            }
            sum
        };
        bodies.map(reaction).collect()
    }

    /// The contact pressure at the nodes of each surface (UF/UL or UF/UL² of reference area,
    /// compression positive). It is recovered from the nodal forces of all passes of the surface,
    /// and is their component along the normals, in [`Geometry::Reference`](super::Geometry) the
    /// reference normals.
    ///
    /// # Errors
    /// See [`pressure::tractions`].
    pub fn pressures(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let located = self.contact.located(&self.kinematics, u);
        let of_surface = |(index, surface): (usize, &std::sync::Arc<Surface<D>>)| {
            let takes_part = |pass: &Pass| pass.slave == index || pass.master == index;
            let own = gaps.keys().iter().zip(lambda);
            let own = own.map(
                |(key, &l)| match takes_part(&self.passes()[key.pass as usize]) {
                    true => l,
                    false => 0.0,
                },
            );
            let all_forces = self.contact_forces(gaps, &own.collect::<Vec<_>>());
            let forces: Vec<_> = surface.nodes().iter().map(|&a| all_forces[a]).collect();
            let tractions = pressure::tractions(surface, &forces)?;
            let pairs = tractions.iter().zip(located.masters[index].normals());
            Ok(pairs.map(|(t, n)| -t.dot(n)).collect())
        };
        self.surfaces().iter().enumerate().map(of_surface).collect()
    }

    /// The largest depth of a contact node inside another surface (UL, ≥ 0), over all passes, less what is left of an overlap
    /// that [`InitialGaps`](super::InitialGaps) takes; in
    /// [`Geometry::Reference`](super::Geometry) along the reference normals.
    pub fn penetration(&self, u: &[f64]) -> f64 {
        self.contact.penetration(&self.kinematics, u)
    }

    /// As [`Problem::penetration`], each depth divided by the mean size of the facets around its
    /// node.
    pub fn relative_penetration(&self, u: &[f64]) -> f64 {
        self.contact
            .deepest(&self.kinematics, u, Surface::node_sizes)
    }

    /// What the bodies do to each other and to themselves at `u`, found without the contact search.
    pub fn audit(&self, u: &[f64]) -> Findings<D> {
        self.audit.at(&self.positions(u))
    }

    /// The rigid motions, to first order, that neither supports nor contact forces of `solution` oppose, as where a block
    /// rests on a plane without friction. States that differ by them are solutions as well; the solvers stay close to the
    /// state that they start from. Empty if `solution` is not of this problem.
    pub fn undetermined(&self, solution: &Solution) -> Vec<Undetermined> {
        let u = &solution.state.u;
        match u.len() == self.dofs().free() && u.iter().all(|u| u.is_finite()) {
            true => super::diagnosis::undetermined(self, solution),
            false => Vec::new(),
        }
    }

    /// The number of quadrature points of the assembled cells where J > 0 does not hold; 0 for
    /// small-strain laws.
    pub fn inverted(&self, u: &[f64]) -> usize {
        let mut J = vec![0.0; self.energy.domain_len()];
        self.energy.domain(u, &mut J);
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
        let gaps = problem.rows(&u, Sampling::Nodes);
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

    /// A square touches one above it and one beside it; its sides share a corner. Only the one beside
    /// pushes, and the side on top does not feel it, not even in the corner.
    #[test]
    fn pressures_are_those_of_their_own_pairs() {
        let square = |x: f64, y: f64| {
            let mesh = rectangle(
                &[x, x + 0.5, x + 1.0],
                &[y, y + 0.5, y + 1.0],
                Diagonals::Rising,
            );
            Body::new(mesh.expect("mesh"), NeoHookean::new(1.0, 0.3).expect("law"))
        };
        let (mut middle, mut above, mut beside) =
            (square(0.0, 0.0), square(0.0, 1.0), square(1.0, 0.0));
        middle.prescribe("bottom", [Some(0.0); 2]).expect("support");
        above.prescribe("top", [Some(0.0); 2]).expect("support");
        beside.prescribe("right", [Some(0.0); 2]).expect("support");
        let mut scene = Scene::new();
        let middle = scene.add("middle", middle);
        let above = scene.add("above", above);
        let beside = scene.add("beside", beside);
        scene
            .contact(middle.on("top"), above.on("bottom"))
            .expect("a pair");
        scene
            .contact(middle.on("right"), beside.on("left"))
            .expect("a pair");
        let problem = scene.problem().expect("a problem");
        let u = vec![0.0; problem.dofs().free()];
        let gaps = problem.rows(&u, Sampling::Nodes);
        let of_pass = |pass: u32| {
            let rows = gaps.keys().iter().zip(gaps.weights());
            rows.map(move |(key, a)| if key.pass == pass { *a } else { 0.0 })
        };
        let (pass, _) = problem
            .passes()
            .iter()
            .enumerate()
            .find(|(_, pass)| problem.surfaces()[pass.master].body() == 2)
            .expect("a pass");
        let lambda: Vec<f64> = of_pass(pass as u32).collect();
        let pressures = problem.pressures(&u, &gaps, &lambda).expect("pressures");
        for (surface, pressures) in problem.surfaces().iter().zip(&pressures) {
            let x = problem.reference();
            let is_beside = surface.nodes().iter().all(|&a| x[a][0] == 1.0);
            for pressure in pressures {
                let expected = if is_beside { 1.0 } else { 0.0 };
                // the middle's row at the bottom corner is held, and beside none of it is missing
                let is_near = (pressure - expected).abs() < 1e-12 || is_beside;
                assert!(is_near, "{pressures:?}");
            }
        }
        let touched = pressures.iter().flatten().filter(|p| **p > 0.1);
        assert!(touched.count() >= 2);
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
        let gaps = problem.rows(&u, Sampling::Nodes);
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
