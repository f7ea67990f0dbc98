//! What a state tells of motions that nothing determines, and of the cause for which a load step did not converge.

use std::collections::BTreeSet;

use contact_core::equilibrium::Solution;

use super::preflight::unheld_motions;
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

/// The causes that show at the last iterate, or `None`: bodies inside each other, and rigid motions
/// that neither supports nor closed contact hold.
pub(super) fn cause<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Option<String> {
    if !solution.state.u.iter().all(|u| u.is_finite()) {
        return None;
    }
    let mut causes = overlaps(problem, solution);
    causes.extend(undetermined(problem, solution).into_iter().map(|part| {
        let motions = part.motions.join(", ");
        format!(
            "neither supports nor contact hold body `{}`: {motions}",
            part.body
        )
    }));
    (!causes.is_empty()).then(|| causes.join("; "))
}

fn overlaps<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Vec<String> {
    let audit = problem.audit(&solution.state.u).unwrap_or_default();
    let overlaps = audit.overlaps.into_iter();
    let deep = overlaps.filter(|overlap| overlap.relative > Overlap::<D>::LIMIT);
    deep.map(|overlap| {
        let [first, second] = overlap.bodies.map(|body| &problem.scene().names()[body]);
        let depth = overlap.depth;
        format!(
            "at its end body `{first}` is inside body `{second}` by {depth:.2e}: declare every surface that may touch"
        )
    })
    .collect()
}

/// The rigid motions of all parts of bodies that neither supports nor rows with a force oppose.
pub(super) fn undetermined<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
) -> Vec<Undetermined> {
    let x = match problem.geometry() {
        Geometry::Reference => problem.reference().to_vec(),
        Geometry::Current => problem.positions(&solution.state.u),
    };
    // node and component of each free unknown
    let mut places = vec![(0, 0); problem.dofs().free()];
    for dof in 0..D * x.len() {
        if let Dof::Free(j) = problem.dofs().get(dof) {
            places[j] = (dof / D, dof % D);
        }
    }
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
    let mut found = Vec::new();
    for (id, body) in problem.scene().ids().zip(problem.scene().bodies()) {
        let first = problem.first_node(id);
        let held = body.prescribed().iter().enumerate();
        let held = held.filter(|(_, value)| value.is_some());
        let held: Vec<_> = held.map(|(dof, _)| (first + dof / D, dof % D)).collect();
        for part in body.mesh().parts() {
            let nodes: BTreeSet<usize> = part.iter().map(|a| first + a).collect();
            let supports = held.iter().filter(|(node, _)| nodes.contains(node));
            let supports = supports.map(|&(node, component)| vec![(node, component, 1.0)]);
            let of_part = |row: &Vec<(usize, usize, f64)>| {
                let own = row.iter().copied();
                own.filter(|(node, ..)| nodes.contains(node)).collect()
            };
            let contact = rows
                .iter()
                .map(of_part)
                .filter(|row: &Vec<_>| !row.is_empty());
            let place = |node: usize| -> Vector<D> { x[node] };
            let motions = unheld_motions(supports.chain(contact), &place, &nodes);
            if !motions.is_empty() {
                let body = problem.scene().names()[id.index()].clone();
                found.push(Undetermined { body, motions });
            }
        }
    }
    found
}
