//! What supports and loads do to bodies, to be compared with the energy that these store.

use super::courses::Origin;
use super::{BodyId, Geometry, Obstacle, ObstacleId, Problem, Side};
use crate::program::Pose;
use crate::tensor::{Matrix, Vector};

/// What does work on bodies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WorkSource {
    /// The supports that name a boundary. Those of nodes, or of a whole body, have names of their own.
    Support(Side),
    /// The elastic foundations of a boundary, whose springs store the work that they take.
    Foundation(Side),
    /// The tractions on a boundary.
    Traction(Side),
    /// The pressures on a boundary.
    Pressure(Side),
    /// The body forces on a body.
    BodyForce(BodyId),
    /// The forces on nodes of a body.
    NodalForce(BodyId),
    /// An obstacle that moves.
    Obstacle(ObstacleId),
    /// A tie whose sides are moved against each other, by its first side.
    Tie(Side),
}

impl WorkSource {
    /// What users call it: `support`, `foundation`, `traction`, `pressure`, `body force`, `nodal force`, `obstacle` or `tie`.
    pub fn kind(&self) -> &'static str {
        match self {
            WorkSource::Support(_) => "support",
            WorkSource::Foundation(_) => "foundation",
            WorkSource::Traction(_) => "traction",
            WorkSource::Pressure(_) => "pressure",
            WorkSource::BodyForce(_) => "body force",
            WorkSource::NodalForce(_) => "nodal force",
            WorkSource::Obstacle(_) => "obstacle",
            WorkSource::Tie(_) => "tie",
        }
    }

    fn of(body: BodyId, origin: &Origin) -> Self {
        match origin {
            Origin::Traction(boundary) => WorkSource::Traction(body.on(boundary)),
            Origin::Pressure(boundary) => WorkSource::Pressure(body.on(boundary)),
            Origin::BodyForce => WorkSource::BodyForce(body),
            Origin::NodalForce => WorkSource::NodalForce(body),
            Origin::Preload(boundary) => WorkSource::Tie(body.on(boundary)),
        }
    }
}

/// What one support, load or obstacle has done since the start.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkRecord {
    /// What did it.
    pub source: WorkSource,
    /// The work, by the trapezoidal rule over the load steps (UF·UL).
    pub work: f64,
}

/// Supports, loads and obstacles at one state.
#[derive(Clone, Debug)]
pub(crate) struct External<const D: usize> {
    /// The displacements of all dofs (UL).
    displacements: Vec<f64>,
    /// The forces of supports, of foundations, of dead loads, and of pressures that follow.
    supports: Vec<Force>,
    foundations: Vec<Force>,
    loads: Vec<Force>,
    pressures: Vec<Force>,
    /// The potential of these pressures and of supports that have let go (UF·UL).
    potential: f64,
    obstacles: Vec<Push<D>>,
    /// Of each tie that jumps: its number, the work conjugate of the factor (UF·UL), and the factor.
    ties: Vec<Jump>,
}

/// A tie that moves its sides against each other.
#[derive(Clone, Debug)]
struct Jump {
    source: WorkSource,
    /// The forces along the jump at the factor 1 (UF·UL), and the factor.
    along: f64,
    factor: f64,
}

/// Forces (UF) on some of the dofs of all bodies.
#[derive(Clone, Debug)]
struct Force {
    source: WorkSource,
    forces: Vec<(usize, f64)>,
}

impl Force {
    /// Σ f·way, with one way (UL) for each dof.
    fn along(&self, ways: &[f64]) -> f64 {
        self.forces.iter().map(|(dof, f)| f * ways[*dof]).sum()
    }
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
        let push = |obstacle: &Obstacle<D>| Push {
            pose: obstacle.pose(0.0),
            force: Vector::zeros(),
            moment: Matrix::zeros(),
        };
        let displacements = vec![0.0; D * problem.reference().len()];
        External {
            supports: forces_of_supports(problem, |_| 0.0, &displacements),
            foundations: forces_of_foundations(problem, &displacements),
            loads: forces_of_loads(problem, 0.0),
            pressures: forces_of_pressures(problem, 0.0, &displacements).0,
            potential: 0.0,
            displacements,
            obstacles: problem.scene().obstacles().iter().map(push).collect(),
            ties: problem.jumps(|_| 0.0, 0.0),
        }
    }

    /// At `u`, with the forces of contact on all nodes, and those of each obstacle (UF).
    pub fn new(
        problem: &Problem<D>,
        u: &[f64],
        (contact, of_obstacles): (&[Vector<D>], &[Vec<Vector<D>>]),
    ) -> Self {
        let residuals = problem.residuals(u);
        let residuals: Vec<&[f64]> = residuals.iter().map(Vec::as_slice).collect();
        let residuals = residuals.concat();
        let ties = problem.jumps(
            |dof| residuals[dof] - contact[dof / D][dof % D],
            problem.load(),
        );
        let contact = problem.with_tie_forces(u, contact);
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
        let displacements: Vec<f64> = problem.displacements(u).iter().flatten().copied().collect();
        let (pressures, potential) = forces_of_pressures(problem, problem.load(), &displacements);
        let reaction = |dof: usize| residuals[dof] - contact[dof / D][dof % D];
        External {
            supports: forces_of_supports(problem, reaction, &displacements),
            foundations: forces_of_foundations(problem, &displacements),
            loads: forces_of_loads(problem, problem.load()),
            obstacles: obstacles.map(push).collect(),
            ties,
            pressures,
            potential: potential + potential_of_fading(problem, &displacements),
            displacements,
        }
    }

    /// The energy that the bodies store (UF·UL) where E, which has that of springs and the potential of the loads, is `energy`.
    pub fn stored(&self, energy: f64) -> f64 {
        let along = |forces: &[Force]| -> f64 {
            let works = forces.iter().map(|own| own.along(&self.displacements));
            works.sum()
        };
        energy + along(&self.loads) + 0.5 * along(&self.foundations) - self.potential
    }

    /// The reaction of each boundary that supports or foundations name (UF).
    pub fn reactions(&self) -> Vec<(Side, Vector<D>)> {
        let mut reactions = Vec::<(Side, Vector<D>)>::new();
        for held in self.supports.iter().chain(&self.foundations) {
            let (WorkSource::Support(side) | WorkSource::Foundation(side)) = &held.source else {
                continue;
            };
            let known = reactions.iter().position(|(known, _)| known == side);
            let place = known.unwrap_or_else(|| {
                reactions.push((side.clone(), Vector::zeros()));
                reactions.len() - 1
            });
            let sum = &mut reactions[place].1;
            held.forces.iter().for_each(|(dof, f)| sum[dof % D] += f);
        }
        reactions
    }

    /// What acts on bodies, in an order that is always the same.
    fn on_bodies(&self) -> impl Iterator<Item = &Force> {
        let held = self.supports.iter().chain(&self.foundations);
        held.chain(&self.loads).chain(&self.pressures)
    }

    /// The work of each support, load and obstacle on the way from `before` (UF·UL), by the trapezoidal rule, in an order that is
    /// always the same.
    pub fn work_since(&self, before: &Self) -> Vec<WorkRecord> {
        let ways = self.displacements.iter().zip(&before.displacements);
        let ways: Vec<f64> = ways.map(|(now, then)| 0.5 * (now - then)).collect();
        let on_bodies = self.on_bodies().zip(before.on_bodies());
        let on_bodies = on_bodies.map(|(now, then)| WorkRecord {
            source: now.source.clone(),
            work: now.along(&ways) + then.along(&ways),
        });
        let obstacles = self.obstacles.iter().zip(&before.obstacles).enumerate();
        let of_obstacles = obstacles.map(|(k, (now, then))| WorkRecord {
            source: WorkSource::Obstacle(ObstacleId(k)),
            work: now.work_since(then),
        });
        let ties = self.ties.iter().zip(&before.ties);
        let of_ties = ties.map(|(now, then)| WorkRecord {
            source: now.source.clone(),
            work: 0.5 * (now.along + then.along) * (now.factor - then.factor),
        });
        on_bodies.chain(of_obstacles).chain(of_ties).collect()
    }
}

impl<const D: usize> Problem<D> {
    /// The ties that move their sides against each other, where `rest` tells ∂E/∂U − Cᵀλ of a dof.
    fn jumps(&self, rest: impl Fn(usize) -> f64, load: f64) -> Vec<Jump> {
        let all = self.ties.along_jumps(&self.scene, rest).into_iter();
        let jump = |(number, along): (usize, f64)| {
            let tie = &self.scene.ties()[number];
            Jump {
                source: WorkSource::Tie(tie.first.clone()),
                along,
                factor: tie.factor(load),
            }
        };
        all.map(jump).collect()
    }
}

/// The supports of all bodies by the boundary that they name, with their reaction (UF) at each dof, at the displacements U of all
/// dofs (UL).
fn forces_of_supports<const D: usize>(
    problem: &Problem<D>,
    reaction: impl Fn(usize) -> f64,
    U: &[f64],
) -> Vec<Force> {
    let mut supports = Vec::new();
    for (id, body) in problem.scene().ids().zip(problem.scene().bodies()) {
        let (names, of_dofs) = body.support_names();
        let own = supports.len();
        supports.extend(names.iter().map(|name| Force {
            source: WorkSource::Support(id.on(name)),
            forces: Vec::new(),
        }));
        let first = D * problem.nodes(id).start;
        for (dof, support) in of_dofs.iter().enumerate() {
            if let Some(support) = support.filter(|_| !body.has_shares(dof / D)) {
                let forces = &mut supports[own + support].forces;
                forces.push((first + dof, reaction(first + dof)));
            }
        }
        for share in body.shares_of_rollers() {
            let force = share.share * reaction(first + share.prescribed);
            supports[own + share.name]
                .forces
                .push((first + share.dof, force));
        }
        let displaced = &U[first..D * problem.nodes(id).end];
        for (dof, force, name) in body.fading(problem.load(), displaced) {
            supports[own + name].forces.push((first + dof, force));
        }
    }
    supports
}

/// The potential of supports that have let go (UF·UL) at the displacements U of all dofs (UL).
fn potential_of_fading<const D: usize>(problem: &Problem<D>, U: &[f64]) -> f64 {
    let bodies = problem.scene().ids().zip(problem.scene().bodies());
    let potentials = bodies.map(|(id, body)| {
        let own = D * problem.nodes(id).start..D * problem.nodes(id).end;
        body.potential_of_fading(problem.load(), &U[own])
    });
    potentials.sum()
}

/// The foundations of all bodies at the displacements U of all dofs (UL); those of one boundary together.
fn forces_of_foundations<const D: usize>(problem: &Problem<D>, U: &[f64]) -> Vec<Force> {
    let mut foundations = Vec::new();
    for (id, body) in problem.scene().ids().zip(problem.scene().bodies()) {
        let first = D * problem.nodes(id).start;
        let own = &U[first..D * problem.nodes(id).end];
        for foundation in body.foundations() {
            let mut forces = vec![0.0; own.len()];
            foundation.springs.add_forces(own, &mut forces);
            forces.iter_mut().for_each(|force| *force = -*force);
            let source = WorkSource::Foundation(id.on(&foundation.boundary));
            add(&mut foundations, source, (first, &forces));
        }
    }
    foundations
}

/// The pressures that follow boundaries at a load factor and the displacements U of all dofs (UL), likewise, and their
/// potential (UF·UL).
fn forces_of_pressures<const D: usize>(
    problem: &Problem<D>,
    factor: f64,
    U: &[f64],
) -> (Vec<Force>, f64) {
    let (mut pressures, mut potential) = (Vec::new(), 0.0);
    for (id, body) in problem.scene().ids().zip(problem.scene().bodies()) {
        let first = D * problem.nodes(id).start;
        let own = &U[first..D * problem.nodes(id).end];
        let is_free = |dof: usize| body.prescribed()[dof].is_none();
        for pressure in body.pressures() {
            let mut forces = vec![0.0; own.len()];
            potential += pressure.add_forces(factor, own, &mut forces, is_free);
            let source = WorkSource::Pressure(id.on(&pressure.boundary));
            add(&mut pressures, source, (first, &forces));
        }
    }
    (pressures, potential)
}

/// Adds the forces (UF) on dofs, of which the first has the number `first`, to those that have this source already.
fn add(all: &mut Vec<Force>, source: WorkSource, (first, forces): (usize, &[f64])) {
    let known = all.iter().position(|known| known.source == source);
    let place = known.unwrap_or_else(|| {
        all.push(Force {
            source,
            forces: Vec::new(),
        });
        all.len() - 1
    });
    let some = forces.iter().enumerate().filter(|(_, f)| **f != 0.0);
    all[place]
        .forces
        .extend(some.map(|(dof, f)| (first + dof, *f)));
}

/// The loads of all bodies at a load factor; those of one kind on one boundary together.
fn forces_of_loads<const D: usize>(problem: &Problem<D>, factor: f64) -> Vec<Force> {
    let mut loads = Vec::<Force>::new();
    for (id, body) in problem.scene().ids().zip(problem.scene().bodies()) {
        let first = D * problem.nodes(id).start;
        for (origin, forces) in body.loads_at(factor) {
            let source = WorkSource::of(id, origin);
            add(&mut loads, source, (first, &forces));
        }
    }
    loads
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
    use crate::tensor::Vector;
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
            if traction != 0.0 {
                bar.traction("right", [traction, 0.0]).expect("a traction");
            }
            let mut scene = Scene::new();
            scene.add("bar", bar);
            let mut problem = scene.problem().expect("a scene");
            let history = Simulation::with_increments(increments).run(&mut problem);
            let history = history.expect("a run");
            let last = history.last().expect("a step");
            let kinds: Vec<_> = last
                .works
                .iter()
                .map(|record| record.source.kind())
                .collect();
            let expected = ["support", "support", "traction"];
            assert_eq!(kinds, expected[..2 + usize::from(traction != 0.0)]);
            // the bottom does not move, and the bar gives way to the traction
            assert_eq!(last.works[0].work, 0.0);
            assert!(last.works[1..].iter().all(|record| record.work > 0.0));
            let own = last.support_reactions.iter().map(|(_, force)| force);
            let left = own.sum::<Vector<2>>() - last.reactions[0];
            assert!(left.norm() < 1e-12, "{left}");
            (last.stored_energy, last.work())
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
            (last.work() - last.stored_energy) / last.stored_energy
        };
        let [coarse, fine] = [left(8), left(16)];
        assert!(coarse.abs() < 1e-2, "{coarse}");
        assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}
