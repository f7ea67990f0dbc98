//! `summary.json`: the input of a run, its ending, results and cost.

use std::collections::BTreeMap;

use contact_core::cost::FactorSize;
use contact_core::ipopt::{doctor, versions};
use contact_core::{ContactProblem, Ending};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::ending::Ended;
use super::folder::Heading;
use super::peak_memory;
use crate::certificate::{Certificate, Limits};
use crate::model::{
    BodyId, Crease, Finding, Opposite, PairRecord, Problem, RigidMotion, ScenePlan, Side,
    TieRecord, Undetermined, WorkRecord,
};
use crate::output::history::source_name;
use crate::simulation::{History, StepRecord};
use crate::tensor::Vector;

/// The keys of `summary.json`. Energies are in UF·UL, forces in UF, lengths in UL. Values that
/// require a converged step are null if there is none, and so are values that do not apply.
#[derive(Serialize)]
pub(super) struct Summary {
    #[serde(flatten)]
    heading: Heading,
    /// The names of the bodies, in the order of the reactions.
    bodies: Vec<String>,
    mesh: Value,
    /// What the checks of the scene found, the worst first.
    findings: Vec<Value>,
    /// The names of the bodies in each part of [`ScenePlan`].
    plan: Value,
    /// The rigid motions of bodies that nothing determines in the last converged state.
    undetermined: Vec<Value>,
    /// Pairs whose contact at the reference positions is far from that at the present ones.
    geometric_errors: Vec<Value>,
    /// The bodies that touch themselves beside a crease.
    creases: Vec<Value>,
    /// The discretisation error of the last converged state: relative in the energy norm, and of the energy (UF·UL).
    estimated_error: Option<f64>,
    estimated_energy_error: Option<f64>,
    /// The share of each body, and its worst cell.
    estimated_errors: Vec<Value>,
    /// The fewest facets in contact of a pair with a force.
    contact_facets_touching: Option<usize>,
    load_factor: f64,
    steps: usize,
    cuts: usize,
    /// The load factors between which no equilibrium was found, although one was beyond.
    leaps: Vec<[f64; 2]>,
    /// Converged steps by solver.
    steps_by_solver: BTreeMap<&'static str, usize>,
    /// Attempts at a load step that failed and were repeated with another solver or setting.
    repeated_attempts: usize,
    energy: Option<f64>,
    stored_energy: Option<f64>,
    work: Option<f64>,
    /// The work that friction has taken (UF·UL), if there is friction.
    dissipated: Option<f64>,
    /// What the work is more than the stored energy and what friction has taken (UF·UL): see [`StepRecord::work`](crate::simulation::StepRecord::work).
    unstored_work: Option<f64>,
    /// The work of each support, load and obstacle.
    works: Vec<Value>,
    reaction: Option<f64>,
    reactions: Vec<Vec<f64>>,
    /// The names of the obstacles, and the contact force of the bodies on each.
    obstacles: Vec<String>,
    obstacle_forces: Vec<Vec<f64>>,
    /// The reactions of the supports by boundary.
    support_reactions: Vec<Value>,
    /// The smallest and the largest contact pressure at the nodes of all contact surfaces.
    pressure_min: Option<f64>,
    pressure_max: Option<f64>,
    /// The area in contact, over all pairs.
    contact_area: Option<f64>,
    /// Area, resultant, centre and largest pressure of each pair.
    pairs: Vec<Value>,
    /// What each tie transmits: the force of the second side's body on the first's.
    ties: Vec<Value>,
    /// How far each rigid body has moved (UL), and by what angles it has turned (radians).
    rigid_motions: Vec<Value>,
    min_j: Option<f64>,
    min_j_bound: Option<f64>,
    /// The cell with the smallest J of all steps, if it is not positive everywhere in it.
    inverted: Option<Value>,
    penetration: Option<f64>,
    weak_penetration: Option<f64>,
    /// The worst values of all steps.
    certificate: Option<Value>,
    /// Iterations of the fixed point or of Newton's method.
    iterations: usize,
    /// Iterations within them: those of Ipopt, or steps towards the active rows.
    inner_iterations: usize,
    factorisations: usize,
    cold_retries: usize,
    left_out: Option<Value>,
    wall_seconds: f64,
    /// Processor time of the run, over all its threads.
    cpu_seconds: Option<f64>,
    seconds: Value,
    /// The estimate before the run, what there was, and by which limit.
    memory: Value,
    peak_memory_bytes: Option<u64>,
    factor: Option<Value>,
    versions: Value,
}

impl Summary {
    /// The summary of what became of a run; `heading` is that of its folder.
    pub(super) fn new<const D: usize>(ended: &Ended<'_, D>, heading: &Heading) -> Self {
        let Ended {
            plan,
            problem,
            records,
            history,
            memory,
            ..
        } = *ended;
        let last = records.last();
        let lists = |vectors: &[Vector<D>]| {
            let lists = vectors.iter().map(|v| v.iter().copied().collect());
            lists.collect::<Vec<Vec<f64>>>()
        };
        let cost = &ended.cost;
        let estimate = ended.estimate.as_ref();
        Summary {
            heading: Heading {
                converged: history.is_some_and(|h| h.run.ending == Ending::Complete),
                status: ended.status,
                reason: Some(ended.told.clone()).filter(|told| told != ended.status),
                ..heading.clone()
            },
            bodies: problem.scene().names().to_vec(),
            mesh: mesh(problem),
            findings: problem
                .findings_in(plan.increments)
                .iter()
                .map(finding)
                .collect(),
            plan: planned(&problem.plan(), problem.scene().names()),
            undetermined: ended
                .undetermined
                .iter()
                .map(|Undetermined { body, motions }| json!({"body": body, "motions": motions}))
                .collect(),
            geometric_errors: ended
                .geometric_errors
                .iter()
                .map(|found| {
                    let scene = problem.scene();
                    let names = (scene.names(), scene.obstacle_names());
                    let [first, second] = both(&found.first, &found.second, names);
                    json!({
                        "first": first, "second": second,
                        "error": found.error, "indentation": found.indentation,
                    })
                })
                .collect(),
            creases: ended
                .creases
                .iter()
                .map(|Crease { body, place, share }| {
                    json!({"body": body, "place": place.as_slice(), "share": share})
                })
                .collect(),
            estimated_error: estimate.map(|estimate| estimate.relative),
            estimated_energy_error: estimate.map(|estimate| estimate.energy),
            estimated_errors: estimate.iter().flat_map(|estimate| &estimate.bodies).map(|of| {
                json!({
                    "body": problem.scene().names()[of.body.index()],
                    "error": of.relative, "energy": of.energy,
                    "worst_cell": of.worst, "place": of.place.as_slice(),
                })
            }).collect(),
            contact_facets_touching: estimate.and_then(|estimate| {
                estimate.contacts.iter().filter_map(|pair| pair.touching).min()
            }),
            load_factor: last.map_or(0.0, |record| record.factor),
            steps: records.len(),
            cuts: history.map_or(0, |history| history.run.cuts()),
            leaps: history.map_or(Vec::new(), |history| history.run.leaps()),
            steps_by_solver: ended.steps_by_solver.clone(),
            repeated_attempts: history.map_or(0, repeated_attempts),
            energy: last.map(|record| record.energy),
            stored_energy: last.map(|record| record.stored_energy),
            work: last.map(StepRecord::work),
            dissipated: last
                .filter(|_| problem.has_friction())
                .map(|record| record.dissipated),
            unstored_work: last
                .map(|record| record.work() - record.stored_energy - record.dissipated),
            works: last.map_or(Vec::new(), |record| {
                let scene = problem.scene();
                let value = |record| worked(record, scene.names(), scene.obstacle_names());
                record.works.iter().map(value).collect()
            }),
            reaction: ended.reaction(),
            reactions: last.map_or(Vec::new(), |record| lists(&record.reactions)),
            obstacles: problem.scene().obstacle_names().to_vec(),
            obstacle_forces: last.map_or(Vec::new(), |record| lists(&record.obstacle_forces)),
            support_reactions: last.map_or(Vec::new(), |record| {
                let reactions = record.support_reactions.iter();
                let value = |(side, force): &(Side, Vector<D>)| {
                    json!({
                        "body": problem.scene().names()[side.body.index()],
                        "boundary": side.boundary, "force": force.as_slice(),
                    })
                };
                reactions.map(value).collect()
            }),
            pressure_min: last.map(|record| record.pressures[0]),
            pressure_max: last.map(|record| record.pressures[1]),
            contact_area: last.map(StepRecord::contact_area),
            pairs: last.map_or(Vec::new(), |record| {
                let scene = problem.scene();
                let value = |of| pair(of, scene.names(), scene.obstacle_names());
                record.pairs.iter().map(value).collect()
            }),
            ties: last.map_or(Vec::new(), |record| {
                let names = problem.scene().names();
                record.ties.iter().map(|of| tie(of, names)).collect()
            }),
            rigid_motions: last.map_or(Vec::new(), |record| {
                let names = problem.scene().names();
                let value = |of: &RigidMotion<D>| {
                    let name = &names[of.body.index()];
                    json!({"body": name, "displacement": of.displacement.as_slice(), "rotation": of.rotation})
                };
                record.rigid_motions.iter().map(value).collect()
            }),
            min_j: last.map(|record| record.min_j),
            min_j_bound: last.map(|record| record.min_j_bound()),
            inverted: ended.inverted.map(|(factor, least)| {
                json!({
                    "body": problem.scene().names()[least.body], "cell": least.cell, "bound": least.bound,
                    "place": least.at.as_slice(), "load_factor": factor,
                })
            }),
            penetration: last.map(|record| record.penetration),
            weak_penetration: last.map(|record| record.weak_penetration),
            certificate: ended.certificate.map(values),
            iterations: cost.outer_iterations,
            inner_iterations: cost.inner_iterations,
            factorisations: cost.factorizations,
            cold_retries: cost.cold_retries,
            left_out: ended.left_out.map(|left| {
                json!({
                    "dofs": left.dofs, "cells": left.cells, "rows": left.rows,
                    "passes": left.passes, "repeating": left.repeating, "solves": left.solves,
                    "factorisations": left.factorizations, "hessians": left.hessians,
                })
            }),
            wall_seconds: ended.wall,
            cpu_seconds: ended.cpu,
            seconds: ended
                .shares
                .iter()
                .map(|&(name, seconds)| (name.to_string(), json!(seconds)))
                .collect(),
            memory: json!({
                "needed_bytes": memory.need.map(|need| need.bytes),
                "factor_bytes": memory.need.map(|need| need.factor),
                "left_bytes": memory.left.map(|left| left.bytes),
                "limit": memory.left.map(|left| left.limit.to_string()),
            }),
            peak_memory_bytes: peak_memory(),
            factor: cost.factor.map(factor),
            versions: program(),
        }
    }

    pub(super) fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

fn planned(plan: &ScenePlan, bodies: &[String]) -> Value {
    let names =
        |ids: &Vec<BodyId>| -> Vec<&String> { ids.iter().map(|id| &bodies[id.index()]).collect() };
    let apart = |(pair, below): &([BodyId; 2], f64)| -> Value {
        json!({"bodies": pair.map(|id| &bodies[id.index()]), "open_below": below})
    };
    json!({
        "groups": plan.groups.iter().map(names).collect::<Vec<_>>(), "held": names(&plan.held),
        "linear": names(&plan.linear), "rigid": names(&plan.rigid), "prescribed": names(&plan.prescribed), "at_rest": names(&plan.at_rest),
        "apart": plan.apart.iter().map(apart).collect::<Vec<_>>(),
    })
}

fn worked(record: &WorkRecord, bodies: &[String], obstacles: &[String]) -> Value {
    let [of, boundary] = source_name(&record.source, bodies, obstacles);
    json!({"kind": record.source.kind(), "of": of, "boundary": boundary, "work": record.work})
}

fn pair<const D: usize>(pair: &PairRecord<D>, bodies: &[String], obstacles: &[String]) -> Value {
    let [first, second] = both(&pair.first, &pair.second, (bodies, obstacles));
    let mut all = json!({
        "first": first, "second": second,
        "area": pair.area, "resultant": pair.resultant.as_slice(),
        "centre": pair.centre.as_ref().map(|centre| centre.as_slice()),
        "pressure_max": pair.pressure_max,
    });
    if pair.friction.norm() > 0.0 {
        all["friction"] = json!(pair.friction.as_slice());
    }
    all
}

/// The two sides of a pair, by the names of bodies and obstacles.
fn both(
    first: &Side,
    second: &Opposite,
    (bodies, obstacles): (&[String], &[String]),
) -> [Value; 2] {
    let side = |side: &Side| json!({"body": bodies[side.body.index()], "boundary": side.boundary});
    let second = match second {
        Opposite::Side(second) => side(second),
        Opposite::Obstacle(id) => json!({"obstacle": obstacles[id.index()]}),
    };
    [side(first), second]
}

fn tie<const D: usize>(tie: &TieRecord<D>, bodies: &[String]) -> Value {
    let side = |side: &Side| json!({"body": bodies[side.body.index()], "boundary": side.boundary});
    json!({
        "first": side(&tie.first), "second": side(&tie.second), "force": tie.force.as_slice(), "jump": tie.jump.as_slice(),
    })
}

fn repeated_attempts<const D: usize>(history: &History<D>) -> usize {
    let attempts = history.run.attempts.iter();
    attempts.map(|attempt| attempt.failed.len()).sum()
}

/// The size of the problem, over all bodies.
fn mesh<const D: usize>(problem: &Problem<D>) -> Value {
    let bodies = problem.scene().bodies();
    let mut contact_facets = vec![0; bodies.len()];
    for surface in problem.surfaces() {
        contact_facets[surface.body()] += surface.len();
    }
    json!({
        "nodes": problem.reference().len(),
        "cells": bodies.iter().map(|body| body.mesh().len()).sum::<usize>(),
        "free_dofs": problem.dofs().free(),
        "contact_facets": contact_facets,
    })
}

fn finding(finding: &Finding) -> Value {
    json!({
        "severity": finding.severity.to_string(),
        "kind": format!("{:?}", finding.kind),
        "bodies": finding.bodies,
        "place": finding.place,
        // null where there is none
        "value": finding.value,
        "limit": finding.limit,
        "what": finding.what,
        "remedy": finding.remedy,
    })
}

fn values(certificate: Certificate) -> Value {
    let limits = Limits::default();
    let entries = certificate.entries(&limits);
    let mut values: Map<String, Value> = entries
        .map(|e| (e.name.to_string(), json!(e.value)))
        .collect();
    values.insert("holds".into(), json!(certificate.holds(&limits)));
    Value::Object(values)
}

fn factor(factor: FactorSize) -> Value {
    json!({
        "ordering": factor.ordering,
        "bytes": factor.bytes,
        "workspace_bytes": factor.workspace_bytes,
        "reallocations": factor.reallocations,
    })
}

/// The version of the program, and the linear algebra that it has loaded.
fn program() -> Value {
    let versions = versions();
    let solvers = doctor::inspect().map_or(Vec::new(), |found| {
        let names = found.working_linear_solvers();
        names.map(str::to_owned).collect()
    });
    json!({
        "ipopt_contact": versions.ipopt_contact,
        "ipopt": versions.ipopt,
        "ipopt_libraries": versions.ipopt_libraries,
        "linear_solver": versions.linear_solver,
        "linear_solvers": solvers,
        "blas": versions.blas.map(|blas| blas.to_string()),
        "rustc": versions.rustc,
        "profile": versions.profile,
    })
}
