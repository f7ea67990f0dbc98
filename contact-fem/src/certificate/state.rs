//! The certificate of a state, evaluated independently of the solver.

use std::collections::{BTreeMap, HashMap, HashSet};

use contact_core::equilibrium::Solution;
use contact_core::friction::Friction;
use contact_core::gaps::Sampling;
use contact_core::{ContactProblem, LinearGaps, Multipliers, RowKey};

use super::{Certificate, Condition, Limits, balance, remeasured, slope, worse};
use crate::audit::Overlap;
use crate::contact::Pass;
use crate::instances::instance;
use crate::model::{Body, Geometry, Problem};
use crate::tensor::{Matrix, Vector};

impl Certificate {
    /// The certificate of `solution`; `problem` must be at the load of the solution.
    pub fn new<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Self {
        instance().certificate(problem, solution)
    }

    /// The same, without what costs more than a load step may take for it unless the check is `whole`.
    pub(crate) fn of_step<const D: usize>(
        problem: &Problem<D>,
        solution: &Solution,
        whole: bool,
    ) -> Self {
        let u = &solution.state.u;
        let (gaps, lambda) = (&solution.gaps, &solution.lambda);
        let forces = problem.contact_forces(gaps, lambda);
        let friction = solution.friction.as_ref();
        let with_friction = friction.map(|_| problem.surface_forces(solution));
        let all_forces = with_friction.as_ref().unwrap_or(&forces);
        let holds = problem.held_forces(&solution.held);
        let of_passes = |key: &RowKey| (key.pass as usize) < problem.passes().len();
        let is_complete = all_forces
            .iter()
            .chain(holds.iter().flatten())
            .all(|force| force.iter().all(|f| f.is_finite()));
        let is_of_law = problem.has_friction() == friction.is_some();
        let mut slips = friction.iter().flat_map(|own| own.rows.keys());
        let is_of_law = is_of_law && slips.all(of_passes);
        let is_own = is_complete && is_of_law && gaps.keys().iter().all(of_passes);
        if !(problem.is_state(u) && is_own) {
            return Certificate::uniform(f64::NAN, 0.0);
        }
        let multipliers = Multipliers::new(gaps, lambda);
        let units = Units::new(problem);
        let passes = problem.passes();
        let rows = problem.rows_at(passes, u, Sampling::Nodes);
        let of_obstacles = problem.surface_forces_of_obstacles(solution).into_iter();
        let of_obstacles = of_obstacles.map(|forces| -forces.iter().sum::<Vector<D>>());
        let of_obstacles: Vec<_> = of_obstacles.collect();
        let residual = Residual::new(
            problem,
            u,
            (all_forces, &of_obstacles),
            holds.as_deref(),
            &units,
        );
        let force = |key: &RowKey| residual.forces[units.bodies[key.pass as usize]];
        let force_of = |body: usize| residual.forces[body];
        let any_force = residual.forces.iter().copied().fold(0.0, f64::max);

        let relative = units.relative(&rows, u, passes);
        // rows at the state, sampled as the solver's: one for each node, or one for each point
        let points;
        let (same, relative_same) = match gaps.sampling() {
            Sampling::Nodes => (&rows, relative.clone()),
            Sampling::Points => {
                points = problem.rows_at(passes, u, Sampling::Points);
                (&points, units.relative(&points, u, passes))
            }
        };
        let has_names = problem.has_lasting_names(gaps.sampling());
        let present = match gaps.sampling() {
            Sampling::Nodes => gaps.len(),
            Sampling::Points => rows.len(),
        };
        let pulls = gaps.keys().iter().zip(lambda);
        let pulls = pulls.map(|(key, l)| over(-l, force(key)));
        let complementarity = {
            let c = values(same, u);
            let products = same.keys().iter().zip(&c).map(|(key, c)| {
                let product = (multipliers.of(*key) * c).abs();
                over(product, force(key) * problem.scale().resolution)
            });
            products.fold(0.0, worse)
        };
        let drift = || {
            let lambda: Vec<f64> = same.keys().iter().map(|&k| multipliers.of(k)).collect();
            let now = problem.contact_forces(same, &lambda);
            let bodies = 0..problem.scene().bodies().len();
            let nodes = bodies.flat_map(|b| problem.nodes(b).map(move |a| (a, b)));
            let change = nodes.map(|(a, b)| over((forces[a] - now[a]).amax(), force_of(b)));
            change.fold(0.0, worse)
        };
        // an obstacle takes what it gives: only bodies are left to compare
        let mutual = mutual_forces(problem, gaps, lambda);
        let mutual = mutual.as_ref().unwrap_or(&forces);
        let action_reaction = {
            let all: Vector<D> = mutual.iter().sum();
            let magnitude: f64 = mutual.iter().map(Vector::norm).sum();
            over(all.norm(), magnitude.max(any_force))
        };
        let closed = match has_names {
            true => closed(same, &relative_same, gaps),
            false => {
                let solver = units.relative(gaps, u, passes);
                uncovered(passes.len(), (same, &relative_same), (gaps, &solver))
            }
        };
        let dropped = problem.contact_nodes().saturating_sub(present);
        let balance = over(residual.sum, residual.resultant.max(units.balanced));
        let Ok(audit) = problem.audit(u) else {
            return Certificate::uniform(f64::NAN, 0.0);
        };
        let pushed = pushed_pairs(problem, gaps, lambda, units.noticed);
        let is_unopposed = |[a, b]: [usize; 2]| {
            !pushed.contains(&[a, b]) && !pushed.contains(&[b, a]) && !problem.are_tied([a, b])
        };
        let has_small_strain = problem.scene().bodies().iter().any(Body::is_small_strain);
        let positions = match problem.geometry() {
            Geometry::Reference => problem.reference().to_vec(),
            Geometry::Current => problem.positions(u),
        };
        let again = whole.then(|| {
            let units = remeasured::Units {
                strain: units.strain,
                resolution: problem.scale().resolution,
                forces: &residual.forces,
                closed: Limits::default().of(Condition::RemeasuredPenetration),
                releases: (units.noticed, Limits::default().of(Condition::Inertia)),
            };
            remeasured::measure(problem, u, (gaps, lambda), friction, &units)
        });
        let slope = || {
            let beside = (&solution.held[..], friction);
            slope::apart(problem, u, (gaps, lambda), beside, &residual.forces)
        };
        let pairs = balance::of_pairs(problem, &positions, solution, any_force);
        let law = friction
            .map(|own| law_of_friction(problem, u, (&rows, &multipliers), own, &residual.forces));
        let left = |condition| match condition {
            Condition::NodalPenetration => Some(problem.relative_penetration(u)),
            Condition::WeakPenetration => Some(deepest(&relative)),
            Condition::Adhesion => Some(pulls.clone().fold(0.0, worse)),
            Condition::Complementarity => Some(complementarity),
            Condition::Stationarity => Some(residual.free),
            Condition::Drift => has_names.then(drift),
            Condition::ActionReaction => Some(action_reaction),
            Condition::Balance => Some(balance),
            Condition::Inverted => Some(problem.inverted(u).max(audit.inverted) as f64),
            Condition::Overlap => Some(deepest_of(problem, &audit.overlaps, &|_| true)),
            Condition::Unopposed => Some(deepest_of(problem, &audit.overlaps, &is_unopposed)),
            Condition::SmallStrain => has_small_strain.then(|| audit.strain.max(audit.rotation)),
            Condition::Moment => {
                (!problem.scene().is_of_revolution()).then(|| moment(&positions, mutual))
            }
            Condition::Closed => Some(closed as f64),
            Condition::OtherSide => units.other_side(problem, u),
            Condition::Dropped => Some(dropped as f64),
            Condition::Instability => instability(problem, solution),
            Condition::Held => holds.is_some().then_some(residual.held),
            Condition::RemeasuredPenetration => again.as_ref().map(|own| own.penetration),
            Condition::RemeasuredComplementarity => again.as_ref().map(|own| own.complementarity),
            Condition::RemeasuredClosed => again.as_ref().map(|own| own.missing as f64),
            Condition::RemeasuredAreas => again.as_ref().map(|own| own.areas),
            Condition::RemeasuredForces => again.as_ref().and_then(|own| own.forces),
            Condition::VirtualWork => again.as_ref().and_then(|own| own.work),
            Condition::EnergySlope => again.as_ref().and_then(|_| slope()),
            Condition::PairBalance => Some(pairs.sum),
            Condition::PairMoment => pairs.moment,
            Condition::Undeclared => Some(undeclared(problem, u, &audit.overlaps)),
            Condition::Inertia => again
                .as_ref()
                .and_then(|own| inertia(own.releases.as_ref()?)),
            Condition::FrictionLaw => law.map(|[excess, _]| excess),
            Condition::FrictionSlip => law.map(|[_, slip]| slip),
            Condition::RemeasuredFriction => again.as_ref().and_then(|own| own.friction),
        };
        let blank = Certificate::uniform(0.0, problem.scale().roundoff);
        Condition::all().fold(blank, |all, condition| all.with(condition, left(condition)))
    }
}

/// The smallest unit of forces, as a share of the scale of forces (energy over length). The conditions
/// on forces divide by at least this unit, since there are hardly any forces when bodies begin to touch.
const NOTICED: f64 = 1e-4;
/// The ratio of the moduli of stretching without lateral strain and of shear at a Poisson's ratio of 0.3: the unit of resultants is smaller
/// where it is larger.
const ORDINARY: f64 = 3.5;
/// The largest share of the closed area that the solver's points may miss.
const MISSING: f64 = 1e-4;

/// The units of lengths and forces.
struct Units {
    /// The body of the slave, pass by pass.
    bodies: Vec<usize>,
    /// For each surface the unit of gaps at each scene node, and the one at integration points (UL).
    lengths: Vec<(HashMap<usize, f64>, f64)>,
    /// The smallest unit of forces (UF).
    noticed: f64,
    /// The same, of resultants: stiff volumes, which make forces on nodes large, do not.
    balanced: f64,
    /// The expected displacement of a facet as a share of its length.
    strain: f64,
}

impl Units {
    fn new<const D: usize>(problem: &Problem<D>) -> Self {
        let scale = problem.scale();
        let dimension = if problem.scene().is_of_revolution() {
            3.0
        } else {
            D as f64
        };
        let strain = scale.resolution / scale.area.powf(1.0 / (dimension - 1.0));
        let surfaces = problem.surfaces().iter();
        let noticed = NOTICED * scale.energy / scale.length;
        let softer = |body: &Body<D>| {
            let (shear, longitudinal) = body.rest_moduli();
            let share = ORDINARY * shear / longitudinal;
            if share.is_finite() {
                share.min(1.0)
            } else {
                1.0
            }
        };
        Units {
            strain,
            bodies: {
                let slaves = problem.passes().iter().map(|pass| pass.slave);
                slaves.map(|s| problem.surfaces()[s].body()).collect()
            },
            lengths: surfaces
                .map(|surface| {
                    let sizes = surface.node_sizes().into_iter().map(|size| strain * size);
                    let by_node = surface.nodes().iter().copied().zip(sizes).collect();
                    (by_node, strain * surface.facet_size())
                })
                .collect(),
            noticed,
            balanced: problem
                .scene()
                .bodies()
                .iter()
                .map(softer)
                .fold(noticed, |unit, s| unit.min(noticed * s)),
        }
    }

    /// The gaps of the rows at `u`, each in its unit.
    fn relative(&self, rows: &LinearGaps, u: &[f64], passes: &[Pass]) -> Vec<f64> {
        let gaps = values(rows, u).into_iter().zip(rows.keys());
        let relative = gaps.map(|(c, key)| {
            let (by_node, anywhere) = &self.lengths[passes[key.pass as usize].slave];
            let unit = match rows.sampling() {
                Sampling::Nodes => by_node.get(&(key.node as usize)).unwrap_or(anywhere),
                Sampling::Points => anywhere,
            };
            c / unit
        });
        relative.collect()
    }

    /// The largest weak penetration of the passes with exchanged roles that the scene leaves out.
    fn other_side<const D: usize>(&self, problem: &Problem<D>, u: &[f64]) -> Option<f64> {
        let passes = problem.passes();
        let others = passes.iter().filter_map(|pass| problem.turned(*pass));
        let others: Vec<Pass> = others.filter(|pass| !passes.contains(pass)).collect();
        let rows = problem.rows_at(&others, u, Sampling::Nodes);
        (!others.is_empty()).then(|| deepest(&self.relative(&rows, u, &others)))
    }
}

/// The forces of the rows between bodies on all nodes (UF); `None` if there are no others.
fn mutual_forces<const D: usize>(
    problem: &Problem<D>,
    gaps: &LinearGaps,
    lambda: &[f64],
) -> Option<Vec<Vector<D>>> {
    if problem.scene().obstacles().is_empty() {
        return None;
    }
    let between = |pass: &Pass| problem.obstacle_of(*pass).is_none();
    let none = || vec![Vector::zeros(); problem.reference().len()];
    let forces = problem.forces_of((gaps, lambda), between);
    Some(forces.unwrap_or_else(none))
}

/// The bodies, slave and master, between which the contact forces add up to more than `noticed`.
fn pushed_pairs<const D: usize>(
    problem: &Problem<D>,
    gaps: &LinearGaps,
    lambda: &[f64],
    noticed: f64,
) -> HashSet<[usize; 2]> {
    let mut forces: HashMap<[usize; 2], f64> = HashMap::new();
    for (key, force) in gaps.keys().iter().zip(lambda) {
        let bodies = problem.bodies_of(problem.passes()[key.pass as usize]);
        *forces.entry(bodies).or_default() += force;
    }
    let pushed = forces.into_iter().filter(|(_, force)| *force > noticed);
    pushed.map(|(bodies, _)| bodies).collect()
}

/// By how much forces of friction exceed what contact allows, in units of the forces on bodies, and by how much their work falls short of the
/// largest that it allows, see [`Condition::FrictionSlip`]. Slips are those of `rows` at the state.
fn law_of_friction<const D: usize>(
    problem: &Problem<D>,
    u: &[f64],
    (rows, multipliers): (&LinearGaps, &Multipliers),
    friction: &Friction,
    forces: &[f64],
) -> [f64; 2] {
    let own = &friction.rows;
    let allowed = |key: &RowKey| problem.friction_of(key) * multipliers.of(*key).max(0.0);
    let limits: Vec<f64> = own.keys().iter().map(allowed).collect();
    let most = own.capacities(&limits, u.len());
    let mut along = vec![0.0; u.len()];
    own.add_forces(&friction.forces, &mut along);
    let mut excess = 0.0;
    let mut first = 0;
    for (energy, unit) in problem.body_energies().iter().zip(forces) {
        for j in first..first + energy.dofs() {
            excess = worse(excess, over((along[j].abs() - most[j]).max(0.0), *unit));
        }
        first += energy.dofs();
    }
    let Ok(slips) = problem.slips(u, rows, &friction.last, friction.from) else {
        return [excess, f64::NAN];
    };
    let pairs = slips.keys().iter().copied().zip(slips.slips(u));
    let slips: HashMap<RowKey, f64> = pairs.collect();
    // the largest work, the work, and the work of slips as small as displacements that do not matter
    let mut works = HashMap::<[usize; 2], [f64; 3]>::new();
    for ((key, r), limit) in own.keys().iter().zip(&friction.forces).zip(&limits) {
        // a row that there is not at the state has no force either, by other conditions
        let slip = slips.get(key).copied().unwrap_or(0.0);
        let Pass { slave, master } = problem.passes()[key.pass as usize];
        let pair = [slave.min(master), slave.max(master)];
        let work = works.entry(pair).or_default();
        work[0] += limit * slip.abs();
        work[1] += r * slip;
        work[2] += limit * problem.scale().resolution;
    }
    let lacks = works.into_values();
    let lacks = lacks.map(|[most, work, least]| over((most - work).abs(), most.max(least)));
    [excess, lacks.fold(0.0, worse)]
}

/// The largest relative depth of the overlaps of bodies that count, less what is left of initial ones.
fn deepest_of<const D: usize>(
    problem: &Problem<D>,
    overlaps: &[Overlap<D>],
    counts: &dyn Fn([usize; 2]) -> bool,
) -> f64 {
    let those = overlaps.iter().filter(|overlap| counts(overlap.bodies));
    let granted = |bodies| problem.granted(bodies, problem.load())[0];
    let depth = |overlap: &Overlap<D>| overlap.relative - granted(overlap.bodies);
    those.map(depth).fold(0.0, worse)
}

/// A motion is that of rigid bodies if it is farther from one by no more than this share of it.
const RIGID: f64 = 0.07;
/// Rigid motions that are held may release energy along a curvature of up to this share of the solver's matrix: soft floors make so much.
const WEAK: f64 = 0.2;

/// The negative curvature along the softest motion, relative to the solver's matrix. Where motions are held, springs are a part of that matrix:
/// along a motion that deforms bodies the curvature is then relative to their stiffness at rest, and along a rigid one it may be weak.
fn instability<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<f64> {
    // what is held may be unstable, and counts as such unless it was examined
    let Some(curvature) = solution.curvature else {
        return (!solution.held.is_empty()).then_some(f64::INFINITY);
    };
    let left = (-curvature).max(0.0);
    let Some((v, curvature)) = &solution.softest else {
        return Some(left);
    };
    if v.len() != problem.dofs().free() || !(*curvature < 0.0) {
        return Some(left);
    }
    if from_rigid(problem, &solution.state.u, v) <= RIGID {
        return Some(if left <= WEAK { 0.0 } else { left });
    }
    let energy = ContactProblem::energy(problem);
    let pattern = energy.hessian_pattern();
    let mut stiffness = vec![0.0; pattern.len()];
    energy.hessian(&vec![0.0; v.len()], &mut stiffness);
    let mut forces = vec![0.0; v.len()];
    pattern.product(&stiffness, v, &mut forces);
    let stored: f64 = forces.iter().zip(v).map(|(f, v)| f * v).sum();
    // at rest, prescribed displacements of the present load may turn cells inside out
    Some(match stored > 0.0 {
        true => over(-curvature, stored),
        false => left,
    })
}

/// The largest share of its unit by which a motion that deforms bodies releases energy; `None` where rigid motions hide whether there is one.
fn inertia(releases: &remeasured::Releases) -> Option<f64> {
    let deforms = releases.motions.iter().find(|release| release.deforms);
    match deforms {
        Some(release) => Some(release.share),
        None => releases.are_all.then_some(0.0),
    }
}

/// How far the motion v of free unknowns is from translations and rotations of the bodies, as a share of it, by root mean squares over nodes.
fn from_rigid<const D: usize>(problem: &Problem<D>, u: &[f64], v: &[f64]) -> f64 {
    let dofs = problem.dofs();
    let v = dofs.forces(v, &vec![0.0; dofs.prescribed()]);
    let v: Vec<Vector<D>> = v.chunks_exact(D).map(Vector::from_column_slice).collect();
    let x = problem.positions(u);
    let (mut rest, mut whole) = (0.0, 0.0);
    for body in 0..problem.scene().bodies().len() {
        let nodes = problem.nodes(body);
        let count = nodes.len().max(1) as f64;
        let mean = |of: &[Vector<D>]| nodes.clone().map(|a| of[a]).sum::<Vector<D>>() / count;
        let (centre, drift) = (mean(&x), mean(&v));
        let pairs: Vec<_> = nodes
            .clone()
            .map(|a| (x[a] - centre, v[a] - drift))
            .collect();
        // W r with a skew W, the best in the mean: one plane of rotation after the other
        let mut spin = Matrix::<D>::zeros();
        for _ in 0..ROUNDS {
            for i in 0..D {
                for j in 0..i {
                    let turned = |r: &Vector<D>| (r[j], -r[i]);
                    let (mut moment, mut inertia) = (0.0, 0.0);
                    for (r, v) in &pairs {
                        let left = v - spin * r;
                        let (a, b) = turned(r);
                        moment += left[i] * a + left[j] * b;
                        inertia += a * a + b * b;
                    }
                    let rate = over(moment, inertia);
                    spin[(i, j)] += rate;
                    spin[(j, i)] -= rate;
                }
            }
        }
        for (r, v) in &pairs {
            rest += (v - spin * r).norm_squared();
        }
        whole += nodes.map(|a| v[a].norm_squared()).sum::<f64>();
    }
    over(rest, whole).sqrt()
}

/// Rounds over the planes of rotation; one is exact in the plane.
const ROUNDS: usize = 20;

/// The largest depth of overlaps of bodies without a pair or a tie between them, beyond that at rest and beyond what chords of round surfaces leave, as a
/// share of the largest displacement or of the extent of the smaller body.
fn undeclared<const D: usize>(problem: &Problem<D>, u: &[f64], overlaps: &[Overlap<D>]) -> f64 {
    let bodies = problem.scene().bodies();
    let is_free = |[a, b]: [usize; 2]| {
        let has_bodies = a != b && b < bodies.len();
        has_bodies && !problem.is_pair([a, b]) && !problem.are_tied([a, b])
    };
    let moved = problem.displacements(u);
    let moved = moved.iter().map(Vector::norm).fold(0.0, f64::max);
    let extent = |body: usize| {
        let (low, high) = bodies[body].mesh().bounding_box();
        (high - low).min()
    };
    let share = |overlap: &Overlap<D>| {
        let [a, b] = overlap.bodies;
        let depth = overlap.depth - overlap.sag - problem.depth_at_rest(overlap.bodies);
        depth.max(0.0) / moved.min(extent(a)).min(extent(b))
    };
    let those = overlaps.iter().filter(|overlap| is_free(overlap.bodies));
    those.map(share).fold(0.0, worse)
}

/// |Σ x ∧ f| of the contact forces, divided by Σ |x − c| |f| with the centre c of all nodes.
fn moment<const D: usize>(x: &[Vector<D>], forces: &[Vector<D>]) -> f64 {
    let centre = x.iter().sum::<Vector<D>>() / x.len().max(1) as f64;
    moment_about(&centre, x, forces)
}

/// The same with another centre.
pub(super) fn moment_about<const D: usize>(
    centre: &Vector<D>,
    x: &[Vector<D>],
    forces: &[Vector<D>],
) -> f64 {
    let (mut sum, mut magnitude) = (Matrix::<D>::zeros(), 0.0);
    for (x, f) in x.iter().zip(forces) {
        let arm = x - centre;
        sum += arm * f.transpose() - f * arm.transpose();
        magnitude += arm.norm() * f.norm();
    }
    over(sum.norm() / std::f64::consts::SQRT_2, magnitude)
}

/// |f| of the components of a force.
fn norm(f: &[f64]) -> f64 {
    f.iter().map(|f| f * f).sum::<f64>().sqrt()
}

/// `value` / `unit`; 0 if the value is 0, for any unit.
pub(super) fn over(value: f64, unit: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / unit }
}

/// c(u) (UL).
fn values(rows: &LinearGaps, u: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; rows.len()];
    rows.value(u, &mut c);
    c
}

/// max(−c_i), at least 0.
fn deepest(gaps: &[f64]) -> f64 {
    gaps.iter().fold(0.0, |depth, c| worse(depth, -c))
}

/// The number of closed constraints present at the state but missing from the solver's rows. `relative`
/// are the gaps at the state in their units.
fn closed(rows: &LinearGaps, relative: &[f64], solver: &LinearGaps) -> usize {
    let named: HashSet<&RowKey> = solver.keys().iter().collect();
    let limit = Limits::default().of(Condition::WeakPenetration);
    let gaps = rows.keys().iter().zip(relative);
    gaps.filter(|(key, c)| **c < limit && !named.contains(key))
        .count()
}

/// The number of passes in which the closed points of the solver cover less of the surface than those
/// at the state. To exclude borderline points, the solver's points count up to twice the limit.
fn uncovered(passes: usize, state: (&LinearGaps, &[f64]), solver: (&LinearGaps, &[f64])) -> usize {
    let limit = Limits::default().of(Condition::WeakPenetration);
    let areas = |(rows, relative): (&LinearGaps, &[f64]), limit: f64| {
        let mut areas = vec![0.0; passes];
        let all = rows.keys().iter().zip(rows.weights()).zip(relative);
        for ((key, weight), _) in all.filter(|(_, c)| **c < limit) {
            areas[key.pass as usize] += weight;
        }
        areas
    };
    let (needed, found) = (areas(state, limit), areas(solver, 2.0 * limit));
    let pairs = needed.iter().zip(&found);
    pairs
        .filter(|(needed, found)| **found < (1.0 - MISSING) * **needed)
        .count()
}

/// The residual ∂E/∂U − Cᵀλ, and what holds motions that nothing resists.
struct Residual {
    /// The largest component at a free dof, divided by the largest force on its body.
    free: f64,
    /// For each body the largest force on a node, but at least the smallest unit of forces (UF).
    forces: Vec<f64>,
    /// |Σ reactions, those of foundations included, + Σ loads + Σ forces of obstacles| (UF), or, if that is larger, the difference of a body's
    /// reaction from the one that results tell.
    sum: f64,
    /// The largest of all resultants of reactions, loads and contact forces on a body (UF); around an axis, what points away from it
    /// is summed by its amount.
    resultant: f64,
    /// The largest ratio, of all bodies, of the forces that hold it to the contact forces on it, or to the loads of all bodies if they are less.
    held: f64,
}

impl Residual {
    fn new<const D: usize>(
        problem: &Problem<D>,
        u: &[f64],
        (contact, of_obstacles): (&[Vector<D>], &[Vector<D>]),
        holds: Option<&[Vector<D>]>,
        units: &Units,
    ) -> Self {
        let (mut free, mut forces) = (0.0, Vec::new());
        // what holds each body, the contact forces on it, and the loads of all
        let (mut held_of, mut load) = (Vec::new(), 0.0);
        // what the bodies do to obstacles, these do to the bodies
        let (mut sum, mut resultant) = (-of_obstacles.iter().sum::<Vector<D>>(), 0.0_f64);
        let (residuals, U) = (problem.residuals(u), problem.displacements(u));
        // what ties do to one body, and the opposite to the other, is a load like contact
        let reported = problem.reactions(u, contact);
        let contact = problem.with_tie_forces(u, contact);
        let mut told = 0.0;
        for (body, owner) in problem.scene().bodies().iter().enumerate() {
            let residual = &residuals[body];
            let (loads, springs) = on_boundary(problem, body, &U);
            let mut tied = BTreeMap::new();
            for (dof, others) in owner.ties() {
                let node = problem.first_node(body) + dof / D;
                let rest = residual[*dof] - contact[node][dof % D];
                for (other, c) in others {
                    *tied.entry(*other).or_insert(0.0) -= c * rest;
                }
            }
            let (mut rest_free, mut largest) = (0.0, units.noticed);
            // of reactions, loads and contact forces
            let mut resultants = [Vector::<D>::zeros(); 3];
            let mut supported = left_by_supports(problem, body);
            for (k, node) in problem.nodes(body).enumerate() {
                for i in 0..D {
                    let dof = D * k + i;
                    let rest: f64 = residual[dof] - contact[node][i];
                    let load = loads[dof];
                    let (hold, reaction) = match owner.prescribed()[dof] {
                        Some(_) => (0.0, rest),
                        None => {
                            let hold = holds.map_or(0.0, |holds| holds[node][i]);
                            (hold, tied.get(&dof).copied().unwrap_or(0.0))
                        }
                    };
                    let spring = springs.get(dof).copied().unwrap_or(0.0);
                    supported[i] += reaction + spring;
                    let reaction = reaction + hold;
                    rest_free = worse((rest - reaction).abs(), rest_free);
                    sum[i] += load + reaction + spring;
                    largest = spring.abs().max(largest);
                    let forces = [reaction + spring, load, contact[node][i]];
                    for (resultant, force) in resultants.iter_mut().zip(forces) {
                        resultant[i] += force;
                        largest = force.abs().max(largest);
                    }
                }
            }
            let norms = resultants.iter().map(|sum| sum.norm());
            resultant = norms.fold(resultant, f64::max);
            free = worse(over(rest_free, largest), free);
            told = worse(told, (supported - reported[body]).norm());
            forces.push(largest);
            load += loads.chunks_exact(D).map(norm).sum::<f64>();
            if let Some(holds) = holds {
                let sum = |forces: &[Vector<D>]| -> f64 {
                    problem.nodes(body).map(|node| forces[node].norm()).sum()
                };
                held_of.push([sum(holds), sum(&contact).max(units.balanced)]);
            }
        }
        if problem.scene().is_of_revolution() {
            // around the axis, what points away from it cancels
            sum[0] = 0.0;
        }
        Residual {
            free,
            forces,
            sum: worse(sum.norm(), told),
            resultant,
            held: held_of.into_iter().fold(0.0, |largest, [held, contact]| {
                // bodies between jaws may be pressed much more than they are loaded
                let unit = if load > 0.0 {
                    contact.min(load)
                } else {
                    contact
                };
                worse(over(held, unit), largest)
            }),
        }
    }
}

/// The sum of the forces that supports of a body left which let go (UF), where they count as loads.
fn left_by_supports<const D: usize>(problem: &Problem<D>, body: usize) -> Vector<D> {
    let owner = &problem.scene().bodies()[body];
    let mut sum = Vector::zeros();
    if !owner.softens() {
        // such forces do not depend on displacements
        let U = vec![0.0; owner.prescribed().len()];
        let fading = owner.fading(problem.load(), &U);
        fading.for_each(|(dof, force, _)| sum[dof % D] += force);
    }
    sum
}

/// The loads on a body, and the forces of its springs (UF), none if it has none, at the displacements U of all nodes.
fn on_boundary<const D: usize>(
    problem: &Problem<D>,
    body: usize,
    U: &[Vector<D>],
) -> (Vec<f64>, Vec<f64>) {
    let owner = &problem.scene().bodies()[body];
    let mut loads = owner.forces_at(problem.load());
    if !owner.acts_on_boundary() && !owner.softens() {
        return (loads, Vec::new());
    }
    let own = U[problem.nodes(body)].iter().flatten();
    let own: Vec<f64> = own.copied().collect();
    owner.add_pressures(problem.load(), &own, &mut loads);
    let mut springs = owner.foundation_forces(&own);
    if owner.softens() {
        let fading = owner.fading(problem.load(), &own);
        fading.for_each(|(dof, force, _)| springs[dof] += force);
    }
    (loads, springs)
}
