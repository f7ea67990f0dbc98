//! What supports and loads do to bodies, to be compared with the energy that these store.

use super::{Geometry, Obstacle, Problem};
use crate::assembly::Dof;
use crate::program::Pose;
use crate::tensor::{Matrix, Vector};

/// Supports, loads and obstacles at one state.
#[derive(Clone, Debug, Default)]
pub(crate) struct External<const D: usize> {
    /// The dead loads on all dofs (UF), and the displacements (UL).
    loads: Vec<f64>,
    displacements: Vec<f64>,
    /// The reactions on all dofs (UF): 0 where nothing is prescribed.
    reactions: Vec<f64>,
    obstacles: Vec<Push<D>>,
}

/// What an obstacle does to the bodies.
#[derive(Clone, Debug)]
struct Push<const D: usize> {
    pose: Pose<D>,
    /// Σ f and Σ f xᵀ of its forces f at places x (UF, UF·UL).
    force: Vector<D>,
    moment: Matrix<D>,
}

impl<const D: usize> External<D> {
    /// Before the first step: nothing is displaced, and nothing pushes.
    pub fn at_rest(problem: &Problem<D>) -> Self {
        let none = vec![0.0; D * problem.reference().len()];
        let push = |obstacle: &Obstacle<D>| Push {
            pose: obstacle.pose(0.0),
            force: Vector::zeros(),
            moment: Matrix::zeros(),
        };
        External {
            loads: none.clone(),
            displacements: none.clone(),
            reactions: none,
            obstacles: problem.scene().obstacles().iter().map(push).collect(),
        }
    }

    /// At `u`, with the forces of contact on all nodes, and those of each obstacle (UF).
    pub fn new(
        problem: &Problem<D>,
        u: &[f64],
        (contact, of_obstacles): (&[Vector<D>], &[Vec<Vector<D>>]),
    ) -> Self {
        let displacements = problem.displacements(u);
        let residuals = problem.residuals(u);
        let (mut loads, mut reactions) = (Vec::new(), Vec::new());
        for (body, owner) in problem.scene().bodies().iter().enumerate() {
            let first = problem.nodes(body).start;
            loads.extend(owner.forces_at(problem.load()));
            for (dof, residual) in residuals[body].iter().enumerate() {
                let (node, axis) = (first + dof / D, dof % D);
                reactions.push(match problem.dofs().get(D * first + dof) {
                    Dof::Prescribed(_) => residual - contact[node][axis],
                    Dof::Free(_) => 0.0,
                });
            }
        }
        let places = match problem.geometry() {
            Geometry::Reference => problem.reference().to_vec(),
            Geometry::Current => problem.positions(u),
        };
        let obstacles = problem.scene().obstacles().iter().zip(of_obstacles);
        let push = |(obstacle, forces): (&Obstacle<D>, &Vec<Vector<D>>)| Push {
            pose: obstacle.pose(problem.load()),
            force: forces.iter().sum(),
            moment: forces
                .iter()
                .zip(&places)
                .map(|(f, x)| f * x.transpose())
                .sum(),
        };
        External {
            obstacles: obstacles.map(push).collect(),
            loads,
            displacements: displacements.iter().flatten().copied().collect(),
            reactions,
        }
    }

    /// The energy that the bodies store (UF·UL) where E, which has the potential of the loads, is `energy`.
    pub fn stored(&self, energy: f64) -> f64 {
        let potential = self.loads.iter().zip(&self.displacements);
        energy + potential.map(|(f, u)| f * u).sum::<f64>()
    }

    /// The work of supports, loads and obstacles on the way from `before` (UF·UL), by the trapezoidal rule.
    pub fn work_since(&self, before: &Self) -> f64 {
        let ways = self.displacements.iter().zip(&before.displacements);
        let forces = |of: &Self, dof: usize| of.loads[dof] + of.reactions[dof];
        let on_bodies = ways.enumerate().map(|(dof, (now, then))| {
            0.5 * (forces(self, dof) + forces(before, dof)) * (now - then)
        });
        let obstacles = self.obstacles.iter().zip(&before.obstacles);
        let of_obstacles = obstacles.map(|(now, then)| now.work_since(then));
        on_bodies.sum::<f64>() + of_obstacles.sum::<f64>()
    }
}

impl<const D: usize> Push<D> {
    /// By the trapezoidal rule: the forces at either end, along the way on which the obstacle takes their places to the other
    /// end. On it, x goes to R x + c.
    fn work_since(&self, before: &Self) -> f64 {
        let R = self.pose.R * before.pose.R.transpose();
        let c = self.pose.c - R * before.pose.c;
        let along = |push: &Self, R: &Matrix<D>, c: &Vector<D>| {
            (R - Matrix::identity()).dot(&push.moment) + push.force.dot(c)
        };
        let forward = along(before, &R, &c);
        let backward = along(self, &R.transpose(), &-R.tr_mul(&c));
        0.5 * (forward - backward)
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
