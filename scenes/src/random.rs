//! Random small scenes, sound ones and wrong ones, and what must be true of their results.

use std::panic::{AssertUnwindSafe, catch_unwind};

use contact_core::{Budget, Phase};
use contact_fem::element::{Element, P1, P2};
use contact_fem::mesh::generators::{Diagonals, annulus, cuboid, disc, linspace, rectangle};
use contact_fem::model::{Geometry, InitialGaps, Integration, Passes, Problem, Side};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{
    Amplitude, Body, Error, LinearElastic, Mesh, MooneyRivlin, Motion, NeoHookean, Obstacle, Scene,
    Simulation, StVenantKirchhoff,
};

use crate::cli::Solver;

/// What a run may take.
const BUDGET: Budget = Budget {
    seconds: Some(2.0),
    factorizations: Some(80),
    memory: None,
};
/// The largest share of the largest force on a node that may be left of a body's balance for each of its nodes: ten times what the certificate
/// allows. Forces below a share of the body's stiffness are round-off, and those below a much smaller one of the stiffest body's.
const BALANCE: f64 = 1e-5;
const ROUNDOFF: f64 = 1e-9;
const ROUNDOFF_OF_ALL: f64 = 1e-12;

/// SplitMix64 (G. Steele, D. Lea, C. Flood, 2014).
pub struct Random(u64);

impl Random {
    /// The numbers of one case.
    pub fn of_case(seed: u64, number: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ number);
        random.bits();
        random
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// A number from `low` to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// A number that is usually between these.
    fn odd(&mut self, low: f64, high: f64) -> f64 {
        const ODD: [f64; 7] = [f64::NAN, f64::INFINITY, -1e300, 1e300, 1e-300, -0.0, 1e12];
        match self.one_in(60) {
            true => self.of(&ODD),
            false => self.between(low, high),
        }
    }
}

/// A mesh of a block, a disc or a ring around the origin, about 1 wide.
fn plane(random: &mut Random) -> Result<Mesh<2>, Error> {
    let count = |random: &mut Random| 1 + random.below(5);
    let mesh = match random.below(4) {
        0 => disc(
            0.5,
            3 + random.below(20),
            count(random),
            random.between(0.0, 1.0),
        ),
        1 => {
            let inner = random.between(0.2, 0.45);
            annulus(&[inner, 0.5], 3 + random.below(20), Diagonals::Alternating)
        }
        _ => {
            let (nx, ny) = (count(random), count(random));
            let side = |n| linspace(-0.5, 0.5, n);
            rectangle(
                &side(nx),
                &side(ny),
                random.of(&[Diagonals::Rising, Diagonals::Alternating]),
            )
        }
    }?;
    finished(random, mesh)
}

fn space(random: &mut Random) -> Result<Mesh<3>, Error> {
    let cells = [0; 3].map(|_| 1 + random.below(2));
    let mesh = cuboid([-0.5; 3], [1.0; 3], cells)?;
    finished(random, mesh)
}

/// Distorted, of either order, with a name for all of the boundary and one for none of it.
fn finished<const D: usize>(random: &mut Random, mesh: Mesh<D>) -> Result<Mesh<D>, Error> {
    let by = random.of(&[0.0, 0.0, 0.02, 0.1]);
    let shape: [f64; D] = std::array::from_fn(|_| random.of(&[1.0, 1.0, 0.3, 3.0, 0.01]));
    let phase = random.between(0.0, 6.0);
    let wave = |X: &Vector<D>, i: usize| (9.0 * X[(i + 1) % D] + phase + i as f64).sin();
    let mut mesh = mesh.mapped(|X| Vector::from_fn(|i, _| shape[i] * (X[i] + by * wave(X, i))))?;
    mesh.name_boundary("all", |_| true);
    mesh.name_boundary("low", |X| X[D - 1] < 0.0);
    mesh.name_boundary("high", |X| X[D - 1] > 0.0);
    mesh.name_boundary("nowhere", |_| false);
    Ok(match random.one_in(2) {
        true => mesh.quadratic(),
        false => mesh,
    })
}

const SIDES: [&str; 8] = [
    "low", "high", "low", "high", "low", "high", "all", "nowhere",
];

fn body<const D: usize>(random: &mut Random, mesh: Mesh<D>) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let nu = match random.below(30) {
        0 => 0.5 - 10f64.powf(random.between(-17.0, -2.0)),
        1 => random.odd(-1.1, 0.6),
        _ => random.of(&[0.0, 0.3, 0.3, 0.45, -0.4]),
    };
    let exponent = random.of(&[0.0, 0.0, 0.0, 3.0, -3.0, 9.0]);
    let young = random.odd(1.0, 2.0) * 10f64.powf(exponent);
    let mut body = match random.below(8) {
        0 => Body::new(mesh, StVenantKirchhoff::new(young, nu)?),
        1 => Body::new(mesh, MooneyRivlin::new(young, nu, random.odd(0.0, 1.0))?),
        2..5 => Body::new(mesh, NeoHookean::new(young, nu)?),
        _ => Body::new(mesh, LinearElastic::new(young, nu)?),
    };
    for _ in 0..random.below(3) {
        let side = random.of(&SIDES);
        match random.below(11) {
            0 => body.traction(side, std::array::from_fn(|_| young * random.odd(-0.1, 0.1)))?,
            1 => body.body_force(std::array::from_fn(|_| young * random.odd(-0.1, 0.1)))?,
            2 => body.prescribe_all([Some(random.odd(-0.3, 0.3)); D])?,
            3 => {
                let course = amplitude(random)?;
                body.prescribe_in_time(side, [Some(random.odd(-0.2, 0.2)); D], course)?
            }
            4 => body.prescribe_motion(side, motion(random)?)?,
            5 => {
                let count = body.mesh().nodes().len() + random.below(2);
                let nodes = [0; 2].map(|_| random.below(count));
                let force = std::array::from_fn(|_| young * random.odd(-0.01, 0.01));
                body.nodal_force_in_time(&nodes, force, amplitude(random)?)?
            }
            _ => {
                let moved = std::array::from_fn(|_| {
                    let value = random.of(&[0.0, 0.0, 1.0]) * random.odd(-0.2, 0.2);
                    (!random.one_in(4)).then_some(value)
                });
                body.prescribe(side, moved)?
            }
        };
    }
    Ok(body)
}

fn amplitude(random: &mut Random) -> Result<Amplitude, Error> {
    let (a, b) = (random.odd(-1.0, 2.0), random.odd(-1.0, 1.0));
    match random.below(4) {
        0 => Ok(Amplitude::constant(a)),
        1 => Amplitude::table(&[(0.0, 0.0), (random.odd(0.1, 1.1), a), (1.0, b)]),
        2 => Ok(Amplitude::of(move |t| (a * t).sin() + b * t * t)),
        _ => Ok(Amplitude::proportional()),
    }
}

fn motion<const D: usize>(random: &mut Random) -> Result<Motion<D>, Error> {
    let motion = Motion::translation(std::array::from_fn(|_| random.odd(-0.2, 0.2)))?;
    Ok(motion.driven_by(amplitude(random)?))
}

/// Below the first body, more or less.
fn obstacle<const D: usize>(random: &mut Random) -> Result<Obstacle<D>, Error> {
    let vector = |random: &mut Random, last: f64| -> [f64; D] {
        std::array::from_fn(|i| match i + 1 == D {
            true => last,
            false => random.odd(-0.2, 0.2),
        })
    };
    let depth = random.of(&[0.0, 0.0, -0.02, 0.01, 0.2]);
    let radius = random.odd(0.1, 2.0);
    let obstacle = match random.below(5) {
        0 => Obstacle::ball(vector(random, depth - radius), radius),
        1 => Obstacle::cavity(vector(random, depth + radius), radius),
        2 => Obstacle::cuboid(
            vector(random, depth - 1.0).map(|x| x - 0.6),
            vector(random, depth).map(|x| x + 0.6),
        ),
        3 => {
            let low = depth + 0.01 * random.odd(-1.0, 1.0);
            Ok(Obstacle::signed_distance(move |x| {
                x[D - 1] - low - 0.01 * (3.0 * x[0]).sin()
            }))
        }
        _ => Obstacle::half_space(vector(random, depth), vector(random, 1.0)),
    }?;
    Ok(match random.one_in(3) {
        true => obstacle.moving(motion(random)?),
        false => obstacle,
    })
}

/// Bodies on top of each other, more or less, with some pairs and obstacles.
fn scene<const D: usize>(
    random: &mut Random,
    mesh: impl Fn(&mut Random) -> Result<Mesh<D>, Error>,
) -> Result<Scene<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let mut scene = Scene::new();
    let (mut top, mut ids) = (0.0, Vec::new());
    for k in 0..1 + random.below(3) {
        let mesh = mesh(random)?;
        let (low, high) = mesh.bounding_box();
        let gap = random.of(&[0.0, 0.0, 0.01, 0.1, -0.02, -0.3]);
        let mut offset = [0.0; D];
        offset[0] = random.of(&[0.0, 0.0, 0.13, -0.4]);
        offset[D - 1] = top + gap - low[D - 1];
        top += gap + high[D - 1] - low[D - 1];
        let mesh = mesh.translated(offset)?;
        let mut body = body(random, mesh)?;
        if k == 0 && !random.one_in(5) {
            body.prescribe("low", [Some(0.0); D])?;
        }
        ids.push(scene.add(format!("body {k}"), body));
    }
    for k in 0..ids.len() {
        let side = |random: &mut Random, k: usize, usual: &'static str| -> Side {
            let name = if random.one_in(6) {
                random.of(&SIDES)
            } else {
                usual
            };
            ids[k].on(name)
        };
        let passes = random.of(&[Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave]);
        if k > 0 && !random.one_in(8) {
            let (first, second) = (side(random, k - 1, "high"), side(random, k, "low"));
            scene.contact_in_passes(first, second, passes)?;
        }
        if random.one_in(if k == 0 { 3 } else { 12 }) {
            let surface = side(random, k, "low");
            scene.obstacle(format!("obstacle {k}"), surface, obstacle(random)?)?;
        }
        if random.one_in(12) {
            let surface = side(random, k, "all");
            scene.self_contact(surface)?;
        }
    }
    scene.geometry = random.of(&[
        None,
        None,
        Some(Geometry::Current),
        Some(Geometry::Reference),
    ]);
    scene.integration = random.of(&[
        None,
        None,
        Some(Integration::Exact),
        Some(Integration::Gauss(2)),
        Some(Integration::Gauss(0)),
    ]);
    scene.initial_gaps = random.of(&[
        InitialGaps::Refuse,
        InitialGaps::Resolve,
        InitialGaps::Adjust,
    ]);
    if random.one_in(10) {
        scene.reach = Some(random.odd(0.0, 1.0));
        scene.overlap_tolerance = random.odd(0.0, 1.0);
    }
    Ok(scene)
}

/// Solves a scene, and tells how that ended or what is wrong with it.
fn solve<const D: usize>(
    random: &mut Random,
    scene: Result<Scene<D>, Error>,
) -> Result<String, String> {
    let outline = |error: &Error| {
        let name = format!("{error:?}");
        let name: String = name.chars().take_while(|c| c.is_alphanumeric()).collect();
        format!("refused: {name}")
    };
    let scene = match scene {
        Ok(scene) => scene,
        Err(error) => return Ok(outline(&error)),
    };
    let mut problem = match scene.problem() {
        Ok(problem) => problem,
        Err(error) => return Ok(outline(&error)),
    };
    let solvers = [
        Solver::Automatic,
        Solver::Automatic,
        Solver::Newton,
        Solver::Ipopt,
        Solver::Condensed,
    ];
    let solver = random.of(&solvers).with_tolerance(None);
    let mut simulation = Simulation::solved_by(solver, 1 + random.below(3));
    if random.one_in(6) {
        let turn = random.odd(0.2, 0.9);
        let phases = [("there", turn), ("back", random.of(&[0.0, 1.0, 1.5]))];
        let phases = phases.map(|(name, until)| Phase::new(name, until, 1 + random.below(2)));
        simulation.load_steps.phases = phases.to_vec();
    }
    simulation.load_steps.budget = BUDGET;
    simulation.load_steps.max_halvings = random.below(4);
    let history = match simulation.run(&mut problem) {
        Ok(history) => history,
        Err(error) => return Ok(format!("error of the run: {}", outline(&error))),
    };
    for step in &history.steps {
        let mut values = step.reactions.iter().chain(&step.contact_forces).flatten();
        if !(step.energy.is_finite() && values.all(|value| value.is_finite())) {
            return Err(format!("no number at load {}: {step:?}", step.factor));
        }
    }
    let last = history.last();
    let holds = last.is_some_and(|last| last.certificate.holds(&Default::default()));
    if holds {
        balance(&problem, &history)?;
    }
    let kind = match history.is_complete() {
        true => "complete".to_string(),
        false => {
            let ending = history.run.ending.to_string();
            let words: Vec<&str> = ending.split(' ').take(2).collect();
            words.join(" ")
        }
    };
    let certificate = match (last, holds) {
        (None, _) => "nothing to certify",
        (_, true) => "certificate holds",
        (_, false) => "certificate does not hold",
    };
    Ok(format!("{kind}, {certificate}"))
}

/// Whether the forces on each body add up to nothing.
fn balance<const D: usize>(problem: &Problem<D>, history: &History<D>) -> Result<(), String> {
    let Some(solution) = &history.run.solution else {
        return Ok(());
    };
    let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
    let scene = problem.scene();
    let bodies = scene.bodies().iter().zip(problem.body_energies());
    let forces = bodies.map(|(body, energy)| {
        let (low, high) = body.mesh().bounding_box();
        energy.typical_stiffness() * (high - low).norm()
    });
    let forces: Vec<f64> = forces.collect();
    let stiffest = forces.iter().copied().fold(0.0, f64::max);
    for (id, body) in scene.ids().zip(scene.bodies()) {
        let residual = problem.residual(id, &solution.state.u);
        let loads = body.forces_at(problem.load());
        let (mut sum, mut largest) = (Vector::<D>::zeros(), 0.0_f64);
        let nodes = problem.nodes(id);
        for (k, node) in nodes.clone().enumerate() {
            for i in 0..D {
                let dof = D * k + i;
                let load = loads[dof];
                let reaction = match body.prescribed()[dof] {
                    Some(_) => residual[dof] - contact[node][i],
                    None => 0.0,
                };
                sum[i] += load + reaction + contact[node][i];
                for force in [load, reaction, contact[node][i]] {
                    largest = largest.max(force.abs());
                }
            }
        }
        let roundoff = ROUNDOFF * forces[id.index()] + ROUNDOFF_OF_ALL * stiffest;
        let limit = BALANCE * largest * nodes.len() as f64 + roundoff;
        if !(sum.norm() <= limit) {
            let left = sum.norm();
            return Err(format!(
                "forces on {id:?} leave {left:.3e} of {largest:.3e} on a node"
            ));
        }
    }
    Ok(())
}

/// One case, whose number and seed say all of it: what became of it.
///
/// # Errors
/// What must not be: a panic, values that are no numbers, forces out of balance where the certificate holds.
pub fn case(seed: u64, number: u64) -> Result<String, String> {
    let mut random = Random::of_case(seed, number);
    let solved = catch_unwind(AssertUnwindSafe(|| match random.one_in(6) {
        true => {
            let scene = scene::<3>(&mut random, space);
            solve(&mut random, scene)
        }
        false => {
            let scene = scene::<2>(&mut random, plane);
            solve(&mut random, scene)
        }
    }));
    solved.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(format!("panic: {}", text.unwrap_or("without a text")))
    })
}
