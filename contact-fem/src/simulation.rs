//! Simulations: a scene is loaded in increments up to full load, with a record of every step.

use std::ops::ControlFlow;

use contact_core::equilibrium::Solution;
use contact_core::friction::Friction;
use contact_core::load_steps::{Attempt, LoadSteps, Phase, Run, Step};
use contact_core::{ContactProblem, Ending, Equilibrium, State};

use crate::audit::LeastVolume;
use crate::certificate::{Certificate, Condition};
use crate::error::Error;
use crate::instances::{Observe, instance};
use crate::model::work::External;
use crate::model::{
    BodyId, ObstacleId, PairRecord, Problem, RigidMotion, Side, TieRecord, WorkRecord,
};
use crate::tensor::Vector;

/// The record of one converged load step.
#[derive(Clone, Debug)]
pub struct StepRecord<const D: usize> {
    /// Load factor, or pseudo-time.
    pub factor: f64,
    /// The number of the increment that ends at this load, or `None` for an intermediate step of an
    /// increment that was cut.
    pub increment: Option<usize>,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The energy that the bodies store: E without the potential of the loads (UF·UL).
    pub stored_energy: f64,
    /// The work of each support, load and obstacle since the start.
    pub works: Vec<WorkRecord>,
    /// The work that friction has taken since the start, by the mean of what its forces may be at both ends of each load step (UF·UL).
    pub dissipated: f64,
    /// The reaction of the supports on each body (UF).
    pub reactions: Vec<Vector<D>>,
    /// The reactions of the supports (UF), by the boundary that they name; those of nodes are called after them, as
    /// `node 12` or `nodes 3, 8` ([`name_of_nodes`](crate::model::name_of_nodes)), those of a whole body `all nodes`. What two supports prescribe counts for the first, so that the reactions of a body's supports add up to its
    /// own.
    pub support_reactions: Vec<(Side, Vector<D>)>,
    /// The force of contact and friction on each body (UF).
    pub contact_forces: Vec<Vector<D>>,
    /// The force of contact and friction of the bodies on each obstacle (UF).
    pub obstacle_forces: Vec<Vector<D>>,
    /// Area, resultant, centre and largest pressure of each pair of surfaces, in the order of their declaration.
    pub pairs: Vec<PairRecord<D>>,
    /// What each tie transmits, in the order of declaration.
    pub ties: Vec<TieRecord<D>>,
    /// How far each rigid body has moved.
    pub rigid_motions: Vec<RigidMotion<D>>,
    /// The smallest and the largest contact pressure at the nodes of all contact surfaces (UF/UL²); zero without such
    /// surfaces.
    pub pressures: [f64; 2],
    /// The smallest volume ratio at the quadrature points of all assembled cells; `+∞` for small-strain laws.
    pub min_j: f64,
    /// A lower bound of the volume ratio everywhere in all cells, whatever their laws, and where it is; `None` without cells.
    pub least_volume: Option<LeastVolume<D>>,
    /// Rows of the weak non-penetration constraints.
    pub rows: usize,
    /// The largest depth of a contact node inside another surface (UL).
    pub penetration: f64,
    /// The most negative weak gap c_i, as a depth (UL).
    pub weak_penetration: f64,
    /// The certificate, evaluated independently of the solver.
    pub certificate: Certificate,
    /// The attempt at the load step: its solver, iterations and cost.
    pub attempt: Attempt,
}

/// A run and its records.
#[derive(Clone, Debug)]
pub struct History<const D: usize> {
    /// How the run ended, its last state, and every attempt at a load step.
    pub run: Run,
    /// One record for each converged step.
    pub steps: Vec<StepRecord<D>>,
}

impl<const D: usize> History<D> {
    /// Whether the run reached full load.
    pub fn is_complete(&self) -> bool {
        self.run.ending == Ending::Complete
    }

    /// The record of the last converged step; `None` if no step converged.
    pub fn last(&self) -> Option<&StepRecord<D>> {
        self.steps.last()
    }

    /// The worst value of each condition over the certificates of all steps; `None` if no step
    /// converged. [`Condition::Instability`] is `None` where the last state was not examined, unless an earlier one was unstable: zeros of earlier
    /// states say nothing about it.
    pub fn certificate(&self) -> Option<Certificate> {
        let steps = self.steps.iter().map(|step| step.certificate);
        let worst = steps.reduce(Certificate::or_worse)?;
        let last = self.last()?.certificate.left(Condition::Instability);
        Some(match worst.left(Condition::Instability) {
            Some(0.0) => worst.with(Condition::Instability, last),
            _ => worst,
        })
    }
}

/// A converged step, as an observer receives it during the run.
pub struct StepView<'a, const D: usize> {
    /// The problem at this load.
    pub problem: &'a Problem<D>,
    /// The solution: state, rows and multipliers.
    pub solution: &'a Solution,
    /// Its record.
    pub record: &'a StepRecord<D>,
}

/// The default solver of a simulation: it chooses the solver that fits the problem.
pub type DefaultSolver = contact_core::Automatic;

/// The solution procedure of a scene: load increments up to full load and the solver of each.
///
/// A bar of length 4 is drawn by σ = 2: it grows by σL/E, and stores half of the load's work.
/// ```
/// # fn main() -> Result<(), contact_fem::Error> {
/// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
/// use contact_fem::{Body, LinearElastic, Scene, Simulation};
///
/// let mesh = rectangle(&linspace(0.0, 4.0, 8), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
/// let end = mesh.boundary_nodes("right")?;
/// let mut bar = Body::new(mesh, LinearElastic::new(200.0, 0.0)?);
/// bar.prescribe("left", [Some(0.0), Some(0.0)])?;
/// bar.traction("right", [2.0, 0.0])?;
/// let mut scene = Scene::new();
/// scene.add("bar", bar);
/// let mut problem = scene.problem()?;
///
/// let history = Simulation::with_increments(2).run(&mut problem)?;
/// assert!(history.is_complete());
/// let growth = 2.0 * 4.0 / 200.0;
/// let u = problem.displacements(&history.run.state.u);
/// assert!(end.iter().all(|&node| (u[node][0] - growth).abs() < 1e-9));
/// // at full load strain stores F·δ/2, and the load has lost F·δ
/// assert!((history.steps[1].energy + 0.5 * 2.0 * growth).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Simulation<S = DefaultSolver> {
    /// Increments, predictor, step reduction, the stop request and the budget.
    pub load_steps: LoadSteps,
    /// The solver of the problem at each load.
    pub solver: S,
}

impl Simulation {
    /// These phases, one after the other; all other settings have their defaults. See
    /// [`Body::prescribe_in_time`](crate::Body::prescribe_in_time).
    pub fn in_phases(phases: impl IntoIterator<Item = Phase>) -> Self {
        let mut simulation = Simulation::with_increments(1);
        simulation.load_steps.phases = phases.into_iter().collect();
        simulation
    }

    /// `increments` equal increments; all other settings have their defaults.
    pub fn with_increments(increments: usize) -> Self {
        Simulation::solved_by(DefaultSolver::default(), increments)
    }
}

impl<S: Equilibrium> Simulation<S> {
    /// `increments` equal increments, each solved by `solver`.
    pub fn solved_by(solver: S, increments: usize) -> Self {
        let load_steps = LoadSteps {
            increments,
            ..LoadSteps::default()
        };
        Simulation { load_steps, solver }
    }

    /// Loads `problem` from rest to full load, or to the end of the last phase.
    ///
    /// # Errors
    /// If a setting is out of range or the solver fails with an error. A run that does not converge
    /// is no error: [`Run::ending`] tells the reason, and the history contains its converged steps.
    pub fn run<const D: usize>(&mut self, problem: &mut Problem<D>) -> Result<History<D>, Error> {
        self.run_observed(problem, |_| ControlFlow::Continue(()))
    }

    /// As [`Simulation::run`]; `observe` is called after every converged step and may stop the run.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub fn run_observed<const D: usize>(
        &mut self,
        problem: &mut Problem<D>,
        mut observe: impl FnMut(&StepView<'_, D>) -> ControlFlow<()>,
    ) -> Result<History<D>, Error> {
        instance().run(&self.load_steps, &mut self.solver, problem, &mut observe)
    }
}

/// [`Simulation::run_observed`].
pub(crate) fn run<const D: usize>(
    load_steps: &LoadSteps,
    solver: &mut dyn Equilibrium,
    problem: &mut Problem<D>,
    observe: Observe<'_, D>,
) -> Result<History<D>, Error> {
    problem.rest()?;
    let start = State {
        u: vec![0.0; problem.energy().dofs()],
        ..State::default()
    };
    let mut steps = Vec::new();
    let mut done = Done {
        external: External::at_rest(problem),
        works: Vec::new(),
        friction: None,
        dissipated: 0.0,
    };
    let ends: Vec<f64> = match &load_steps.phases[..] {
        [] => vec![1.0],
        phases => phases.iter().map(|phase| phase.until).collect(),
    };
    let run = load_steps.run(problem, solver, start, |step| {
        let is_end = |end: &f64| (step.factor - end).abs() <= 1e-9 * end.abs();
        let whole = ends.iter().any(is_end);
        let record = StepRecord::new(step, &mut done, whole);
        let flow = observe(&StepView {
            problem: step.problem,
            solution: step.solution,
            record: &record,
        });
        steps.push(record);
        flow
    })?;
    Ok(History { run, steps })
}

/// Supports, loads and friction at the last step, the work until there, and what friction took of it.
struct Done<const D: usize> {
    external: External<D>,
    works: Vec<WorkRecord>,
    friction: Option<Friction>,
    dissipated: f64,
}

impl<const D: usize> StepRecord<D> {
    /// The reaction of the supports on a body (UF).
    ///
    /// # Panics
    /// If the scene has no such body.
    pub fn reaction(&self, body: impl Into<BodyId>) -> Vector<D> {
        self.reactions[body.into().index()]
    }

    /// The bound of [`StepRecord::least_volume`]; `+∞` without cells.
    pub fn min_j_bound(&self) -> f64 {
        self.least_volume.map_or(f64::INFINITY, |least| least.bound)
    }

    /// The contact force on a body (UF).
    pub fn contact_force(&self, body: impl Into<BodyId>) -> Vector<D> {
        self.contact_forces[body.into().index()]
    }

    /// The name of the phase that the step belongs to; empty in a run without phases.
    pub fn phase(&self) -> &str {
        &self.attempt.phase
    }

    /// The contact force of the bodies on an obstacle (UF).
    pub fn obstacle_force(&self, obstacle: ObstacleId) -> Vector<D> {
        self.obstacle_forces[obstacle.index()]
    }

    /// The work of all supports, loads and moving obstacles since the start, by the trapezoidal rule over the load steps (UF·UL).
    /// What is neither stored nor taken by friction was lost on the way: in a snap, to the rule, to an interference fit, or since contact forces along
    /// averaged normals are not quite the gradient of the gaps.
    pub fn work(&self) -> f64 {
        self.works.iter().map(|record| record.work).sum()
    }

    /// The area in contact, over all pairs (UL in the plane, UL² in space).
    pub fn contact_area(&self) -> f64 {
        // a sum over no pair is −0
        self.pairs.iter().map(|pair| pair.area).sum::<f64>() + 0.0
    }

    /// `whole` tells whether all of the certificate is computed.
    fn new(step: &Step<'_, Problem<D>>, done: &mut Done<D>, whole: bool) -> Self {
        let (problem, solution) = (step.problem, step.solution);
        #[cfg(planted)]
        let solution = &spoiled(solution);
        let u = &solution.state.u;
        let forces = problem.surface_forces(solution);
        let mut c = vec![0.0; solution.gaps.len()];
        solution.gaps.value(u, &mut c);
        let bodies = 0..problem.scene().bodies().len();
        // a state that a step converged to is one
        let states = problem.pair_states(u, &solution.gaps, &solution.lambda);
        let states = states.unwrap_or_default();
        let surfaces = problem.surface_pressures(&states);
        let all = || surfaces.iter().flatten().copied();
        let range = match (all().next(), all().any(f64::is_nan)) {
            (None, _) => [0.0; 2],
            // a pressure that is no number is not hidden by others
            (_, true) => [f64::NAN; 2],
            _ => [
                all().fold(f64::INFINITY, f64::min),
                all().fold(f64::NEG_INFINITY, f64::max),
            ],
        };
        let of_obstacles = problem.surface_forces_of_obstacles(solution);
        let external = External::new(problem, u, (&forces, &of_obstacles));
        let mut works = external.work_since(&done.external);
        let until_there = works.iter_mut().zip(&done.works);
        until_there.for_each(|(now, then)| now.work += then.work);
        let friction = solution.friction.as_ref();
        let taken = friction.map_or(0.0, |own| own.dissipated(u, done.friction.as_ref()));
        let dissipated = done.dissipated + taken;
        let energy = Some(problem.energy_at(u)).filter(|energy| energy.is_finite());
        // a law that answers otherwise than it did to the solver has no energy here
        let energy = energy.unwrap_or(solution.energy);
        let stored_energy = external.stored(energy);
        let support_reactions = external.reactions();
        *done = Done {
            external,
            works: works.clone(),
            friction: friction.cloned(),
            dissipated,
        };
        StepRecord {
            factor: step.factor,
            increment: step.increment,
            energy,
            stored_energy,
            works,
            dissipated,
            reactions: problem.reactions(u, &forces),
            support_reactions,
            pairs: states
                .into_iter()
                .map(|state| state.record)
                .map(|record| problem.with_friction(record, solution.friction.as_ref()))
                .collect(),
            ties: problem.tie_records(u, &forces),
            rigid_motions: problem.rigid_motions(u),
            #[cfg(not(planted))]
            pressures: range,
            #[cfg(planted)]
            pressures: match contact_core::planted!("pressures are doubled") {
                true => range.map(|p| 2.0 * p),
                false => range,
            },
            contact_forces: bodies
                .map(|body| problem.nodes(body).map(|a| forces[a]).sum())
                .collect(),
            obstacle_forces: of_obstacles
                .iter()
                .map(|forces| -forces.iter().sum::<Vector<D>>())
                .collect(),
            min_j: step.attempt.min_domain,
            least_volume: problem.least_volume(u),
            rows: solution.gaps.len(),
            penetration: problem.penetration(u),
            weak_penetration: c.iter().fold(0.0, |depth: f64, c| depth.max(-c)),
            certificate: Certificate::of_step(problem, solution, whole),
            attempt: step.attempt.clone(),
        }
    }
}

/// What faults make of a solution.
#[cfg(planted)]
fn spoiled(solution: &Solution) -> Solution {
    let mut spoiled = solution.clone();
    if contact_core::planted!("every ninth multiplier is lost") {
        spoiled.lambda.iter_mut().step_by(9).for_each(|l| *l = 0.0);
    }
    if contact_core::planted!("multipliers are those of the next row") && !spoiled.lambda.is_empty()
    {
        spoiled.lambda.rotate_left(1);
    }
    let largest = spoiled.lambda.iter().copied().fold(0.0, f64::max);
    for l in &mut spoiled.lambda {
        if contact_core::planted!("the largest multiplier is a hundredth larger") && *l == largest {
            *l *= 1.01;
        }
        if contact_core::planted!("small multipliers are lost") && *l < 0.1 * largest {
            *l = 0.0;
        }
    }
    let u = &mut spoiled.state.u;
    if contact_core::planted!("the state is a thousandth off") {
        u.iter_mut().for_each(|u| *u *= 1.001);
    }
    let middle = u.len() / 2;
    if contact_core::planted!("one unknown is lost") && !u.is_empty() {
        u[middle] = 0.0;
    }
    if contact_core::planted!("the state is that of the next unknown") && !u.is_empty() {
        u.rotate_left(1);
    }
    spoiled
}

#[cfg(test)]
mod tests {
    use contact_core::equilibrium::StepContext;
    use contact_core::gaps::Sampling;
    use contact_core::{Multipliers, Outcome};

    use super::*;
    use crate::mesh::generators::{Diagonals, rectangle};
    use crate::model::Scene;
    use crate::{Body, LinearElastic};

    /// Says that a state is the solution: nothing moves, and every row carries twice its area.
    struct Claims;

    impl Equilibrium for Claims {
        fn solve(
            &mut self,
            problem: &dyn ContactProblem,
            start: State,
            _: &StepContext<'_>,
        ) -> Result<Solution, contact_core::Error> {
            let u = vec![0.0; start.u.len()];
            let gaps = problem.linearize_gaps(&u, Sampling::Nodes)?;
            let gaps = gaps.and(problem.linearize_reversed(&u, Sampling::Nodes)?);
            let lambda: Vec<f64> = gaps.weights().iter().map(|a| 2.0 * a).collect();
            Ok(Solution {
                outcome: Outcome::Converged,
                energy: -7.0,
                state: State {
                    u,
                    multipliers: Multipliers::new(&gaps, &lambda),
                },
                gaps,
                lambda,
                history: Vec::new(),
                failed: Vec::new(),
                curvature: None,
                flickering: Vec::new(),
                held: Vec::new(),
                softest: None,
                friction: None,
            })
        }
    }

    /// A square on another, which it is moved into by 0.02 as a whole. Both passes push with 2 each.
    #[test]
    fn records_of_a_state_that_is_claimed() {
        let square = |y: f64| {
            let mesh = rectangle(&[0.0, 0.5, 1.0], &[y, y + 0.5, y + 1.0], Diagonals::Rising);
            let law = LinearElastic::new(1.0, 0.0).expect("law");
            Body::new(mesh.expect("mesh"), law)
        };
        let (mut lower, mut upper) = (square(0.0), square(1.0));
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        upper
            .prescribe_all([Some(0.0), Some(-0.02)])
            .expect("motion");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", upper);
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("a pair");
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::solved_by(Claims, 2).run(&mut problem);
        let history = history.expect("no misuse");
        assert!(history.is_complete());
        for (step, depth) in history.steps.iter().zip([0.01, 0.02]) {
            assert!((step.penetration - depth).abs() < 1e-12);
            assert!((step.weak_penetration - depth).abs() < 1e-12);
            // that of the state, whatever the solver claims
            assert_eq!(step.rows, 6);
            assert!(step.energy.abs() < 1e-12, "{}", step.energy);
            // both surfaces are 1 wide
            for (body, force) in [(lower, -4.0), (upper, 4.0)] {
                let contact = step.contact_force(body);
                assert!(contact[0].abs() < 1e-12 && (contact[1] - force).abs() < 1e-12);
            }
            // both passes push with 2 a unit of area, over 1
            let [pair] = &step.pairs[..] else {
                panic!("{:?}", step.pairs);
            };
            assert!((pair.area - 1.0).abs() < 1e-12 && (step.contact_area() - 1.0).abs() < 1e-12);
            assert!(
                (pair.resultant[1] + 4.0).abs() < 1e-12,
                "{:?}",
                pair.resultant
            );
            // halfway between the surfaces
            let centre = pair.centre.expect("a force");
            let expected = Vector::<2>::new(0.5, 1.0 - 0.5 * depth);
            assert!((centre - expected).norm() < 1e-12, "{centre}");
            let pressures = [pair.pressure_max, step.pressures[0], step.pressures[1]];
            assert!(
                pressures.iter().all(|p| (p - 4.0).abs() < 1e-9),
                "{pressures:?}"
            );
            // the lower square is held at its bottom, and the upper one everywhere
            let of = |body: usize| {
                let own = step
                    .support_reactions
                    .iter()
                    .filter(|(side, _)| side.body == body.into());
                own.map(|(side, force)| (side.boundary.clone(), force[1]))
                    .collect::<Vec<_>>()
            };
            let [(name, force)] = &of(0)[..] else {
                panic!("{:?}", of(0));
            };
            assert!(name == "bottom" && force.abs() < 1e-12, "{name} {force}");
            let [(name, force)] = &of(1)[..] else {
                panic!("{:?}", of(1));
            };
            assert!(
                name == crate::model::ALL_NODES && (force + 4.0).abs() < 1e-12,
                "{name} {force}"
            );
            // the lower square's supports do not touch the upper one, which is held everywhere
            assert!(step.reaction(lower).norm() < 1e-12);
            assert!((step.reaction(upper)[1] + 4.0).abs() < 1e-12);
        }
    }
}
