//! What supports and loads do to bodies, to be compared with the energy that these store.

use super::Problem;
use crate::assembly::Dof;
use crate::tensor::Vector;

/// Supports and loads at one state.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct External {
    /// The load factor.
    factor: f64,
    /// The reactions times the prescribed displacements at full load (UF·UL).
    supports: f64,
    /// The loads at full load times the displacements (UF·UL).
    loads: f64,
}

impl External {
    /// At `u`, with the forces of contact on all nodes (UF).
    pub fn new<const D: usize>(problem: &Problem<D>, u: &[f64], contact: &[Vector<D>]) -> Self {
        let displacements = problem.displacements(u);
        let [mut supports, mut loads] = [0.0; 2];
        for (body, owner) in problem.scene().bodies().iter().enumerate() {
            let first = problem.nodes(body).start;
            for (dof, residual) in problem.residual(body, u).into_iter().enumerate() {
                let (node, axis) = (first + dof / D, dof % D);
                loads += owner.forces()[dof] * displacements[node][axis];
                if let Dof::Prescribed(_) = problem.dofs().get(D * first + dof) {
                    let full = owner.prescribed()[dof].unwrap_or(0.0);
                    supports += (residual - contact[node][axis]) * full;
                }
            }
        }
        External {
            factor: problem.load(),
            supports,
            loads,
        }
    }

    /// The energy that the bodies store (UF·UL) where E, which has the potential of the loads, is `energy`.
    pub fn stored(&self, energy: f64) -> f64 {
        energy + self.factor * self.loads
    }

    /// The work of supports and loads on the way from `before` (UF·UL), by the trapezoidal rule.
    pub fn work_since(&self, before: &External) -> f64 {
        let supports = 0.5 * (self.supports + before.supports) * (self.factor - before.factor);
        let loads = 0.5 * (self.factor + before.factor) * (self.loads - before.loads);
        supports + loads
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::{Body, LinearElastic, NeoHookean, Scene, Simulation};

    /// A bar of 1 by 2, without lateral strain: 3 up on top, and pulled at its side by 5.
    #[test]
    fn a_linear_bar_stores_the_work_of_support_and_traction() {
        let stored_and_work = |traction: f64, increments: usize| {
            let (x, y) = (linspace(0.0, 1.0, 2), linspace(0.0, 2.0, 3));
            let mesh = rectangle(&x, &y, Diagonals::Rising).expect("mesh");
            let law = LinearElastic::new(8.0, 0.0).expect("law");
            let mut bar = Body::new(mesh, law);
            bar.prescribe("bottom", [Some(0.0); 2]).expect("support");
            bar.prescribe("top", [Some(0.0), Some(0.3)])
                .expect("support");
            bar.traction("right", [traction, 0.0]).expect("a traction");
            let mut scene = Scene::new();
            scene.add("bar", bar);
            let mut problem = scene.problem().expect("a scene");
            let history = Simulation::with_increments(increments).run(&mut problem);
            let history = history.expect("a run");
            let last = history.last().expect("a step");
            (last.stored_energy, last.work)
        };
        // ½ E ε² A L
        let expected = 0.5 * 8.0 * 0.15 * 0.15 * 2.0;
        let (stored, work) = stored_and_work(0.0, 3);
        assert!((stored - expected).abs() < 1e-12 && (work - expected).abs() < 1e-12);
        for increments in [1, 4] {
            let (stored, work) = stored_and_work(5.0, increments);
            assert!(stored > 1.5 * expected, "{stored}");
            assert!((work / stored - 1.0).abs() < 1e-10, "{work} for {stored}");
        }
    }

    /// Blocks that are pressed on each other: contact does no work, and what the trapezoidal rule leaves falls as the square of
    /// the increments.
    #[test]
    fn contact_of_blocks_loses_nothing() {
        let left = |increments: usize| {
            let block = |low: f64, cells: usize| {
                let x = linspace(0.0, 1.0, cells);
                let mesh = rectangle(&x, &linspace(low, low + 1.0, cells), Diagonals::Rising);
                let law = NeoHookean::new(100.0, 0.3).expect("law");
                Body::new(mesh.expect("mesh"), law)
            };
            let (mut lower, mut upper) = (block(0.0, 3), block(1.0, 4));
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            upper
                .prescribe("top", [Some(0.0), Some(-0.4)])
                .expect("support");
            let mut scene = Scene::new();
            let lower = scene.add("lower", lower);
            let upper = scene.add("upper", upper);
            scene
                .contact(lower.on("top"), upper.on("bottom"))
                .expect("a pair");
            let mut problem = scene.problem().expect("a scene");
            let history = Simulation::with_increments(increments).run(&mut problem);
            let history = history.expect("a run");
            assert!(history.is_complete());
            let last = history.last().expect("a step");
            (last.work - last.stored_energy) / last.stored_energy
        };
        let [coarse, fine] = [left(8), left(16)];
        assert!(coarse.abs() < 1e-2, "{coarse}");
        assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}
