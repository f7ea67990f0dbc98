//! What a state tells of motions that nothing determines, and of the cause for which a load step did not converge.

mod contradiction;
mod crease;
mod curvature;

use std::collections::{BTreeMap, BTreeSet};

use contact_core::equilibrium::Solution;
use contact_core::friction::Status;
use contact_core::{ContactProblem, Outcome, RowKey};

use self::contradiction::{Row, contradictory};
pub use self::crease::Crease;
pub(super) use self::crease::creases;
use self::curvature::falling;

use super::preflight::{clusters, held_rows, unheld_motions};
use super::{Geometry, Problem};
use crate::assembly::Dof;
use crate::audit::Overlap;
use crate::tensor::Vector;

/// A part of a body whose rigid motions are not all determined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undetermined {
    /// The name of the body.
    pub body: String,
    /// The names of independent motions, such as `translation x` or `rotation`.
    pub motions: Vec<String>,
}

/// The smallest contact force of a row that holds a body, as a share of the largest.
const HOLDS: f64 = 1e-6;

/// The relative depth of an overlap that is told where no contact surface is declared.
const SEEN: f64 = 0.01;
/// So many rows at most are asked whether they contradict each other, the deepest ones.
const MOST_ROWS: usize = 200;
/// A row that overlaps by more than this share of the scene asks for room.
const VISIBLE: f64 = 1e-9;

/// The causes that show at the last iterate, or `None`: bodies inside each other, rigid motions that neither supports nor
/// closed contact hold, rows that contradict each other, motions along which energy falls, rows that open and close, contact beside a crease.
pub(super) fn cause<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<String> {
    if !solution.state.u.iter().all(|u| u.is_finite()) {
        return None;
    }
    let mut causes = overlaps(problem, solution);
    let undetermined = undetermined(problem, solution);
    let is_held = undetermined.is_empty();
    causes.extend(undetermined.into_iter().map(|part| {
        let motions = part.motions.join(", ");
        format!(
            "neither supports nor contact hold body `{}`: {motions}",
            part.body
        )
    }));
    causes.extend(contradiction(problem, solution));
    // the energy over all unknowns has motions that ties do not permit
    if is_held && problem.ties.is_empty() {
        causes.extend(instability(problem, solution));
    }
    causes.extend(flicker(problem, solution));
    if let Some(friction) = &solution.friction
        && solution.outcome == Outcome::IterationLimit
    {
        let rubs = |key: &RowKey| problem.passes().get(key.pass as usize).copied();
        let mut passes = friction.rows.keys().iter().filter_map(rubs);
        let has_both = passes.any(|pass| {
            problem
                .turned(pass)
                .is_some_and(|own| problem.passes().contains(&own))
        });
        causes.push(match has_both {
            true => "thresholds of friction of both roles may change without end: give the pair one pass, with the finer side as slave, or take smaller steps".into(),
            false => "thresholds of friction may change without end: take smaller steps".into(),
        });
    }
    let creases = creases(problem, solution);
    causes.extend(creases.iter().map(Crease::to_string));
    (!causes.is_empty()).then(|| causes.join("; "))
}

/// A node's body and its position at the last iterate.
fn place<const D: usize>(problem: &Problem<D>, node: usize, x: &Vector<D>) -> String {
    let named = problem.scene().ids().zip(problem.scene().names());
    let mut of_node = named.filter(|(id, _)| problem.nodes(*id).contains(&node));
    let body = of_node.next().map_or("", |(_, name)| name);
    let at: Vec<String> = x.iter().map(|x| format!("{x:.3e}")).collect();
    format!("body `{body}` at ({})", at.join(", "))
}

/// Where the rows of these nodes are.
fn places<const D: usize>(problem: &Problem<D>, solution: &Solution, keys: &[RowKey]) -> String {
    let x = problem.positions(&solution.state.u);
    let mut nodes: Vec<usize> = keys.iter().map(|key| key.node as usize).collect();
    nodes.dedup();
    let named = nodes.iter().filter_map(|&node| Some((node, x.get(node)?)));
    let named: Vec<String> = named.take(2).map(|(a, x)| place(problem, a, x)).collect();
    named.join(" and ")
}

fn contradiction<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<String> {
    let gaps = &solution.gaps;
    let mut c = vec![0.0; gaps.len()];
    gaps.value(&solution.state.u, &mut c);
    let length = problem.kinematics.diagonal();
    let forces = |i: usize| solution.lambda.get(i).copied().unwrap_or(0.0);
    let presses = |i: &usize| c[*i] < -VISIBLE * length || forces(*i) > 0.0;
    let mut chosen: Vec<usize> = (0..gaps.len()).filter(presses).collect();
    if !chosen.iter().any(|&i| c[i] < -VISIBLE * length) {
        return None;
    }
    chosen.sort_by(|&i, &j| c[i].total_cmp(&c[j]));
    chosen.truncate(MOST_ROWS);
    let of_chosen = |&i: &usize| Row {
        coefficients: gaps.matrix().row(i).collect(),
        gap: c[i],
    };
    let rows: Vec<Row> = chosen.iter().map(of_chosen).collect();
    let found = contradictory(&rows, length);
    if found.is_empty() {
        return None;
    }
    let keys: Vec<RowKey> = found.iter().map(|&k| gaps.keys()[chosen[k]]).collect();
    Some(format!(
        "the gaps of {} nodes cannot all be open, such as those of {}: what is prescribed leaves no room between the bodies",
        keys.len(),
        places(problem, solution, &keys)
    ))
}

fn instability<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<String> {
    let motion = falling(problem.energy(), solution)?;
    let largest = motion.iter().map(|v| v.abs()).enumerate();
    let (unknown, _) = largest.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let x = problem.positions(&solution.state.u);
    let dofs = 0..D * x.len();
    let mut of_unknown = dofs.filter(|&dof| problem.dofs().get(dof) == Dof::Free(unknown));
    let node = of_unknown.next()? / D;
    Some(format!(
        "at its end the energy falls along a motion of {}, so that the body snaps or buckles near this load: take \
         smaller steps, or prescribe displacements in place of forces",
        place(problem, node, &x[node])
    ))
}

fn flicker<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<String> {
    let rows = &solution.flickering;
    (!rows.is_empty()).then(|| {
        format!(
            "{} of {} rows open or close from one iteration to the next, such as those of {}",
            rows.len(),
            solution.gaps.len(),
            places(problem, solution, rows)
        )
    })
}

/// Bodies inside each other: where no contact surface is declared, however little that is, and elsewhere beyond the limit.
fn overlaps<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Vec<String> {
    let x = problem.positions(&solution.state.u);
    let is_declared = |face: &[usize]| {
        let mut surfaces = problem.surfaces().iter();
        surfaces.any(|s| face.iter().all(|a| s.nodes().binary_search(a).is_ok()))
    };
    let mut worst: BTreeMap<([usize; 2], bool), Overlap<D>> = BTreeMap::new();
    for overlap in problem.audit.overlaps(&x) {
        let declared = is_declared(&overlap.face);
        let counts = if declared { Overlap::<D>::LIMIT } else { SEEN };
        let is_let = problem.contact.lets_through(overlap.bodies, problem.load());
        if overlap.relative > counts && !is_let {
            let mut pair = overlap.bodies;
            pair.sort_unstable();
            let kept = worst.entry((pair, declared)).or_insert(overlap);
            if overlap.depth > kept.depth {
                *kept = overlap;
            }
        }
    }
    let told = worst.into_iter().map(|((_, declared), overlap)| {
        let [first, second] = overlap.bodies.map(|body| problem.scene().called(body));
        let at: Vec<String> = overlap.at.iter().map(|x| format!("{x:.3e}")).collect();
        let remedy = match declared {
            true => "take smaller steps, or a finer mesh there",
            false => "declare the surface of the latter there for contact, too",
        };
        format!(
            "at its end {first} is inside {second} by {:.2e} at ({}): {remedy}",
            overlap.depth,
            at.join(", ")
        )
    });
    told.collect()
}

/// The node and the component of each free unknown.
fn place_of_unknowns<const D: usize>(problem: &Problem<D>) -> Vec<(usize, usize)> {
    let mut places = vec![(0, 0); problem.dofs().free()];
    for dof in 0..D * problem.reference().len() {
        if let Dof::Free(j) = problem.dofs().get(dof) {
            places[j] = (dof / D, dof % D);
        }
    }
    places
}

/// The rigid motions of all parts of bodies that neither supports nor springs nor rows with a force oppose.
pub(super) fn undetermined<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
) -> Vec<Undetermined> {
    let x = match problem.geometry() {
        Geometry::Reference => problem.reference().to_vec(),
        Geometry::Current => problem.positions(&solution.state.u),
    };
    let places = place_of_unknowns(problem);
    let forces = &solution.lambda;
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let mut rows = vec![Vec::new(); forces.len()];
    for (row, j, c) in solution.gaps.entries() {
        if forces
            .get(row)
            .is_some_and(|&force| force > HOLDS * largest)
        {
            let (node, component) = places[j];
            rows[row].push((node, component, c));
        }
    }
    if let Some(friction) = &solution.friction {
        let statuses = friction.statuses(&solution.state.u);
        let sticking = statuses.iter().enumerate();
        for (i, _) in sticking.filter(|(_, status)| **status == Status::Stick) {
            let entries = friction.rows.matrix().row(i);
            let entries = entries.map(|(j, c)| (places[j].0, places[j].1, c));
            rows.push(entries.collect());
        }
    }
    let mut found = Vec::new();
    for cluster in clusters(problem.scene()) {
        let first = |body: usize| problem.nodes(body).start;
        let own = cluster.parts.iter();
        let own = own.flat_map(|(body, part)| part.iter().map(move |a| first(*body) + a));
        let nodes: BTreeSet<usize> = own.collect();
        let supports = cluster.parts.iter().flat_map(|(body, part)| {
            held_rows(&problem.scene().bodies()[*body], first(*body), part)
        });
        let of_cluster = |row: &Vec<(usize, usize, f64)>| {
            let own = row.iter().copied();
            own.filter(|(node, ..)| nodes.contains(node)).collect()
        };
        let contact = rows
            .iter()
            .map(of_cluster)
            .filter(|row: &Vec<_>| !row.is_empty());
        let place = |node: usize| -> Vector<D> { x[node] };
        let first_body = &problem.scene().bodies()[cluster.parts[0].0];
        let is_revolved = first_body.mesh().is_of_revolution();
        let motions = unheld_motions(supports.chain(contact), &place, &nodes, is_revolved);
        if !motions.is_empty() {
            let body = problem.scene().names()[cluster.parts[0].0].clone();
            found.push(Undetermined { body, motions });
        }
    }
    found
}

#[cfg(test)]
pub(super) mod tests {
    use contact_core::gaps::Sampling;
    use contact_core::{LinearGaps, Outcome, State};

    use super::*;
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::{Body, Mesh, NeoHookean, Scene};

    fn law() -> NeoHookean {
        NeoHookean::new(1e3, 0.3).expect("law")
    }

    /// What an iteration that reached its limit at u leaves, with rows there and a force on each.
    pub fn ended(problem: &Problem<2>, u: Vec<f64>, force: f64) -> Solution {
        let forward = problem.linearize_gaps(&u, Sampling::Nodes).expect("rows");
        let reversed = problem
            .linearize_reversed(&u, Sampling::Nodes)
            .expect("rows");
        let gaps: LinearGaps = forward.and(reversed);
        Solution {
            outcome: Outcome::IterationLimit,
            energy: problem.energy().value(&u),
            lambda: vec![force; gaps.len()],
            state: State {
                u,
                ..State::default()
            },
            gaps,
            history: Vec::new(),
            failed: Vec::new(),
            curvature: None,
            flickering: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction: None,
        }
    }

    /// A strip of length 10 and thickness ½ between two clamped ends, shortened by this share of it, straight.
    fn strip(shortened: f64) -> (Problem<2>, Vec<f64>) {
        let mesh = rectangle(
            &linspace(-0.25, 0.25, 2),
            &linspace(0.0, 10.0, 40),
            Diagonals::Alternating,
        );
        let mut body = Body::new(mesh.expect("mesh").quadratic(), law());
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let way = [Some(0.0), Some(-10.0 * shortened)];
        body.prescribe("top", way).expect("support");
        let mut scene = Scene::new();
        scene.add("strip", body);
        let problem = scene.problem().expect("a scene");
        let mut u = vec![0.0; problem.energy().dofs()];
        for (node, X) in problem.reference().iter().enumerate() {
            if let Dof::Free(j) = problem.dofs().get(2 * node + 1) {
                u[j] = -shortened * X[1];
            }
        }
        (problem, u)
    }

    /// Euler's strain of the strip is 4π²h²/12L² = 0.0082.
    #[test]
    fn a_strip_beyond_eulers_load_buckles_and_below_it_does_not() {
        for (shortened, buckles) in [(0.004, false), (0.02, true)] {
            let (mut problem, u) = strip(shortened);
            contact_core::LoadStepped::set_load(&mut problem, 1.0).expect("a load");
            let cause = cause(&problem, &ended(&problem, u, 0.0));
            assert_eq!(cause.is_some(), buckles, "{shortened}: {cause:?}");
            let told = cause.unwrap_or_default();
            // largest in the middle
            let place = "buckles near this load";
            assert!(!buckles || told.contains(place), "{told}");
            assert!(!buckles || told.contains("body `strip`"), "{told}");
        }
    }

    /// The tip of a triangle is one node, between two plates that close upon it.
    #[test]
    fn a_node_between_two_plates_that_leave_no_room() {
        let triangle = Mesh::new(vec![[0.0, 0.0], [-1.0, 0.5], [-1.0, -0.5]], vec![0, 1, 2]);
        let mut triangle = triangle.expect("mesh");
        triangle.name_boundary("tip", |_| true);
        let mut tip = Body::new(triangle, law());
        tip.prescribe_nodes(&[1, 2], [Some(0.0); 2])
            .expect("support");
        let plate = |low: f64, way: f64| {
            let x = linspace(-0.2, 0.8, 1);
            let mesh = rectangle(&x, &linspace(low, low + 0.3, 1), Diagonals::Rising);
            let mut plate = Body::new(mesh.expect("mesh"), law());
            plate
                .prescribe_all([Some(0.0), Some(way)])
                .expect("support");
            plate
        };
        let mut scene = Scene::new();
        let tip = scene.add("tip", tip);
        let lower = scene.add("lower", plate(-0.5, 0.25));
        let upper = scene.add("upper", plate(0.2, -0.25));
        scene.contact(tip.on("tip"), lower.on("top")).expect("pair");
        scene
            .contact(tip.on("tip"), upper.on("bottom"))
            .expect("pair");
        let mut problem = scene.problem().expect("a scene");
        contact_core::LoadStepped::set_load(&mut problem, 0.5).expect("a load");
        let told =
            |problem: &Problem<2>| contradiction(problem, &ended(problem, vec![0.0; 2], 1.0));
        assert_eq!(told(&problem), None, "there is room at half the load");
        contact_core::LoadStepped::set_load(&mut problem, 1.0).expect("a load");
        let told = told(&problem).expect("no room");
        assert!(told.contains("leaves no room"), "{told}");
    }
}
