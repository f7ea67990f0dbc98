//! `summary.json`: the input of a run, its ending, results and cost.

use std::collections::BTreeMap;

use contact_core::cost::{Cost, FactorSize};
use contact_core::equilibrium::Choice;
use contact_core::ipopt::{Blas, doctor, versions};
use contact_core::{Ending, InteriorPoint, Method};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::folder::Heading;
use super::observer::Observer;
use super::{Memory, Plan, peak_memory};
use crate::audit::LeastVolume;
use crate::certificate::{Certificate, Limits};
use crate::error::Error;
use crate::left_out::LeftOut;
use crate::model::{
    BodyError, BodyId, ErrorEstimate, Finding, InitialGaps, Opposite, PairRecord, Problem, Scene,
    ScenePlan, Side, TieRecord, Undetermined, WorkRecord,
};
use crate::output::history::source_name;
use crate::simulation::{History, StepRecord};
use crate::tensor::Vector;

/// The share of the largest stored energy that work and stored energy may be apart without a warning.
const UNSTORED: f64 = 0.1;
/// What is round-off of energies, as a share of the scene's [`Scale::energy`](contact_core::Scale::energy).
const NEGLIGIBLE: f64 = 1e-13;

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
    /// What the work is more than the stored energy (UF·UL): see [`StepRecord::work`](crate::simulation::StepRecord::work).
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
    /// The summary as text.
    #[serde(skip)]
    table: String,
}

/// The discretisation error, where it is largest, and which contact zones it does not see.
fn estimated<const D: usize>(estimate: &ErrorEstimate<D>, problem: &Problem<D>) -> Vec<String> {
    let scene = problem.scene();
    let largest = |a: &&BodyError<D>, b: &&BodyError<D>| a.energy.total_cmp(&b.energy);
    let place = estimate.bodies.iter().max_by(largest).map(|of| {
        let at: Vec<String> = of.place.iter().map(|x| format!("{x:.3}")).collect();
        let name = &scene.names()[of.body.index()];
        format!(", most in body `{name}` near ({})", at.join(", "))
    });
    if estimate.relative == 0.0 {
        return vec!["estimated error    none: nothing is strained".into()];
    }
    let mut lines = vec![format!(
        "estimated error    {:.2} % in the energy norm, {:.1e} UF·UL of the energy{}",
        100.0 * estimate.relative,
        estimate.energy,
        place.unwrap_or_default()
    )];
    let unresolved = estimate
        .contacts
        .iter()
        .filter(|pair| pair.is_unresolved(D));
    lines.extend(unresolved.map(|pair| {
        let second = name_of(&pair.second, scene);
        format!(
            "warning            the mesh does not resolve the contact of {} with {second}: {} facets touch, and force and pressures may be wrong \
             by a tenth and more; take smaller facets there",
            scene.name_of_side(&pair.first),
            pair.touching.unwrap_or(0)
        )
    }));
    lines
}

/// Says so where work and stored energy are far apart. What an interference fit stores is no work of supports and loads.
fn unstored<const D: usize>(records: &[StepRecord<D>], problem: &Problem<D>) -> Option<String> {
    if problem.scene().initial_gaps == InitialGaps::Resolve {
        return None;
    }
    let energy = problem.scale().energy;
    let last = records.last()?;
    let apart = (last.work() - last.stored_energy).abs();
    let most = records.iter().map(|record| record.stored_energy);
    let most = most.fold(0.0, f64::max);
    let is_far = apart > UNSTORED * most && apart > NEGLIGIBLE * energy;
    is_far.then(|| {
        format!(
            "warning            work and stored energy are {:.0} % of the largest stored energy apart: take more increments; if that does \
             not help, a body has snapped from one equilibrium to another, or contact has begun or ended at once",
            100.0 * apart / most
        )
    })
}

impl Summary {
    /// The summary of a run that `observer` has followed, with what became of it and of its files, and with its total
    /// time and the processor's (s).
    pub(super) fn new<const D: usize>(
        plan: &Plan<'_, D>,
        problem: &Problem<D>,
        observer: &Observer<'_, D>,
        (result, unwritten): (&Result<History<D>, Error>, Option<&Error>),
        (choice, memory): (Choice, Memory),
        (wall, cpu): (f64, Option<f64>),
    ) -> Self {
        let (records, history) = (&observer.records, result.as_ref().ok());
        let last = records.last();
        let certificates = records.iter().map(|record| record.certificate);
        let certificate = certificates.reduce(Certificate::or_worse);
        let (status, told) = status(result, unwritten, certificate);
        let cost = match history {
            Some(history) => history.run.cost(),
            None => records.iter().map(|record| record.attempt.cost).sum(),
        };
        let steps_by_solver = steps_by_solver(records);
        let solution = history.and_then(|history| history.run.solution.as_ref());
        let undetermined = solution.map_or(Vec::new(), |solution| problem.undetermined(solution));
        let errors = solution.map_or(Vec::new(), |solution| problem.geometric_errors(solution));
        let estimate = solution.and_then(|solution| problem.error_estimate(solution).ok());
        let left_out = history.map(|history| LeftOut::new(problem, history));
        let inverted = inverted(records);
        let shares = shares(&cost, observer.seconds, wall);
        let lists = |vectors: &[crate::tensor::Vector<D>]| {
            let lists = vectors.iter().map(|v| v.iter().copied().collect());
            lists.collect::<Vec<Vec<f64>>>()
        };
        let reaction = last.map(|record| (plan.force)(record));
        let number = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.4}"));
        let mut table = vec![
            format!("{}: {told}", plan.name),
            format!("solver             {}", solvers(choice, &steps_by_solver)),
            format!(
                "energy             {:>10} UF·UL",
                number(last.map(|r| r.energy))
            ),
            format!("reaction           {:>10} UF", number(reaction)),
        ];
        table.extend(last.map(|record| {
            format!(
                "work               {:>10} UF·UL by the trapezoidal rule, {:.1e} UF·UL more than is stored",
                number(Some(record.work())),
                record.work() - record.stored_energy
            )
        }));
        table.extend(unstored(records, problem));
        table.extend(undetermined.iter().map(|Undetermined { body, motions }| {
            let motions = motions.join(", ");
            format!("undetermined       body `{body}`: {motions}")
        }));
        table.extend(errors.iter().map(|found| {
            let scene = problem.scene();
            let second = name_of(&found.second, scene);
            let first = scene.name_of_side(&found.first);
            format!(
                "warning            contact of {first} with {second} is taken at the reference positions, where gaps differ from the present ones \
                 by {:.3e}, {:.0} % of the indentation: it does not follow the bodies, and its places, areas and forces may be wrong; take contact at \
                 the current positions",
                found.error,
                100.0 * found.error / found.indentation
            )
        }));
        table.extend(
            estimate
                .iter()
                .flat_map(|estimate| estimated(estimate, problem)),
        );
        table.extend(inverted.map(|(factor, least)| {
            let at: Vec<String> = least.at.iter().map(|x| format!("{x:.3e}")).collect();
            format!(
                "inverted           cell {} of body `{}` at load {factor}: J from {:.3e} at ({})",
                least.cell,
                problem.scene().names()[least.body],
                least.bound,
                at.join(", ")
            )
        }));
        table.extend(cost_lines(&cost));
        table.extend(certificate.map(|found| format!("certificate of all steps {found}")));
        table.extend(left_out.map(|left| format!("left out                   {left}")));
        table.extend(time_lines(&shares, wall));
        if steps_by_solver.contains_key(InteriorPoint::default().name()) {
            table.extend(ipopt_lines());
        }
        Summary {
            heading: Heading {
                converged: history.is_some_and(|h| h.run.ending == Ending::Complete),
                status,
                reason: Some(told).filter(|told| told != status),
                ..observer.folder.heading.clone()
            },
            bodies: problem.scene().names().to_vec(),
            mesh: mesh(problem),
            findings: problem
                .findings_in(plan.increments)
                .iter()
                .map(finding)
                .collect(),
            plan: planned(&problem.plan(), problem.scene().names()),
            undetermined: undetermined
                .iter()
                .map(|Undetermined { body, motions }| json!({"body": body, "motions": motions}))
                .collect(),
            geometric_errors: errors
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
            estimated_error: estimate.as_ref().map(|estimate| estimate.relative),
            estimated_energy_error: estimate.as_ref().map(|estimate| estimate.energy),
            estimated_errors: estimate.iter().flat_map(|estimate| &estimate.bodies).map(|of| {
                json!({
                    "body": problem.scene().names()[of.body.index()],
                    "error": of.relative, "energy": of.energy,
                    "worst_cell": of.worst, "place": of.place.as_slice(),
                })
            }).collect(),
            contact_facets_touching: estimate.as_ref().and_then(|estimate| {
                estimate.contacts.iter().filter_map(|pair| pair.touching).min()
            }),
            load_factor: last.map_or(0.0, |record| record.factor),
            steps: records.len(),
            cuts: history.map_or(0, |history| history.run.cuts()),
            leaps: history.map_or(Vec::new(), |history| history.run.leaps()),
            steps_by_solver,
            repeated_attempts: history.map_or(0, repeated_attempts),
            energy: last.map(|record| record.energy),
            stored_energy: last.map(|record| record.stored_energy),
            work: last.map(StepRecord::work),
            unstored_work: last.map(|record| record.work() - record.stored_energy),
            works: last.map_or(Vec::new(), |record| {
                let scene = problem.scene();
                let value = |record| worked(record, scene.names(), scene.obstacle_names());
                record.works.iter().map(value).collect()
            }),
            reaction,
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
            min_j: last.map(|record| record.min_j),
            min_j_bound: last.map(|record| record.min_j_bound()),
            inverted: inverted.map(|(factor, least)| {
                json!({
                    "body": problem.scene().names()[least.body], "cell": least.cell, "bound": least.bound,
                    "place": least.at.as_slice(), "load_factor": factor,
                })
            }),
            penetration: last.map(|record| record.penetration),
            weak_penetration: last.map(|record| record.weak_penetration),
            certificate: certificate.map(values),
            iterations: cost.outer_iterations,
            inner_iterations: cost.inner_iterations,
            factorisations: cost.factorizations,
            cold_retries: cost.cold_retries,
            left_out: left_out.map(|left| {
                json!({
                    "dofs": left.dofs, "cells": left.cells, "rows": left.rows,
                    "passes": left.passes, "repeating": left.repeating, "solves": left.solves,
                    "factorisations": left.factorizations, "hessians": left.hessians,
                })
            }),
            wall_seconds: wall,
            cpu_seconds: cpu,
            seconds: shares
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
            table: table.join("\n  "),
        }
    }

    pub(super) fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// A short table as text.
    pub(super) fn table(&self) -> &str {
        &self.table
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
        "linear": names(&plan.linear), "prescribed": names(&plan.prescribed), "at_rest": names(&plan.at_rest),
        "apart": plan.apart.iter().map(apart).collect::<Vec<_>>(),
    })
}

fn worked(record: &WorkRecord, bodies: &[String], obstacles: &[String]) -> Value {
    let [of, boundary] = source_name(&record.source, bodies, obstacles);
    json!({"kind": record.source.kind(), "of": of, "boundary": boundary, "work": record.work})
}

fn pair<const D: usize>(pair: &PairRecord<D>, bodies: &[String], obstacles: &[String]) -> Value {
    let [first, second] = both(&pair.first, &pair.second, (bodies, obstacles));
    json!({
        "first": first, "second": second,
        "area": pair.area, "resultant": pair.resultant.as_slice(),
        "centre": pair.centre.as_ref().map(|centre| centre.as_slice()),
        "pressure_max": pair.pressure_max,
    })
}

fn name_of<const D: usize>(opposite: &Opposite, scene: &Scene<D>) -> String {
    match opposite {
        Opposite::Side(side) => scene.name_of_side(side),
        Opposite::Obstacle(id) => format!("obstacle `{}`", scene.obstacle_names()[id.index()]),
    }
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
    json!({"first": side(&tie.first), "second": side(&tie.second), "force": tie.force.as_slice()})
}

/// The smallest volume ratio of all steps and the load factor there, if J > 0 is not shown everywhere.
fn inverted<const D: usize>(records: &[StepRecord<D>]) -> Option<(f64, LeastVolume<D>)> {
    let least = records
        .iter()
        .filter_map(|record| Some((record.factor, record.least_volume?)));
    let inverted = least.filter(|(_, least)| !(least.bound > 0.0));
    inverted.min_by(|a, b| a.1.bound.total_cmp(&b.1.bound))
}

/// How many converged steps each solver solved.
fn steps_by_solver<const D: usize>(records: &[StepRecord<D>]) -> BTreeMap<&'static str, usize> {
    let mut steps = BTreeMap::new();
    for solver in records.iter().filter_map(|record| record.attempt.solver()) {
        *steps.entry(solver).or_default() += 1;
    }
    steps
}

/// The solver, why it was chosen, and what others solved.
fn solvers(choice: Choice, steps: &BTreeMap<&'static str, usize>) -> String {
    let all: usize = steps.values().sum();
    let others = steps.iter().filter(|(solver, _)| **solver != choice.solver);
    let others = others.map(|(solver, count)| format!(", {count} of {all} steps by {solver}"));
    format!("{choice}{}", others.collect::<String>())
}

fn repeated_attempts<const D: usize>(history: &History<D>) -> usize {
    let attempts = history.run.attempts.iter();
    attempts.map(|attempt| attempt.failed.len()).sum()
}

/// How the run ended, in one word and as a text.
fn status<const D: usize>(
    result: &Result<History<D>, Error>,
    unwritten: Option<&Error>,
    certificate: Option<Certificate>,
) -> (&'static str, String) {
    let (status, told) = match (result, unwritten) {
        (_, Some(error)) | (Err(error), None) => ("failed", format!("failed: {error}")),
        (Ok(history), None) => {
            let ending = &history.run.ending;
            let status = match ending {
                Ending::Complete => "complete",
                Ending::Interrupted { .. } => "stopped",
                _ => "failed",
            };
            (status, ending.to_string())
        }
    };
    let leaps = result
        .as_ref()
        .map_or(Vec::new(), |history| history.run.leaps());
    let leaps: Vec<String> = leaps
        .iter()
        .map(|[from, to]| format!("{from:.6} and {to:.6}"))
        .collect();
    let told = match leaps[..] {
        [] => told,
        _ => format!(
            "{told}; no equilibrium was found between the load factors {}",
            leaps.join(", ")
        ),
    };
    match certificate {
        Some(found) if !found.holds(&Limits::default()) => {
            let told = format!("{told}, but its certificate does not hold");
            (status, told)
        }
        _ => (status, told),
    }
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

/// Wall time by phase (s).
fn shares(cost: &Cost, output: f64, wall: f64) -> [(&'static str, f64); 5] {
    let known = cost.projection + cost.callbacks + cost.optimizer + output;
    [
        ("projection", cost.projection),
        ("callbacks", cost.callbacks),
        ("optimizer", cost.optimizer),
        ("output", output),
        ("other", wall - known),
    ]
}

fn cost_lines(cost: &Cost) -> Vec<String> {
    let mut lines = vec![
        format!("iterations         {:>10}", cost.outer_iterations),
        format!("inner iterations   {:>10}", cost.inner_iterations),
        format!("factorisations     {:>10}", cost.factorizations),
    ];
    lines.extend(cost.factor.map(|factor| {
        let megabytes = |bytes: u64| bytes as f64 / 1e6;
        let mut line = format!("factor             {:>10.2} MB", megabytes(factor.bytes));
        if let Some(workspace) = factor.workspace_bytes {
            line += &format!(" of {:.2} MB allocated", megabytes(workspace));
        }
        line += &format!(", ordered by {}", factor.ordering);
        match factor.reallocations {
            0 => line,
            count => line + &format!(", allocated anew {count} times"),
        }
    }));
    lines
}

fn time_lines(shares: &[(&str, f64)], wall: f64) -> Vec<String> {
    let share = |&(name, seconds): &(&str, f64)| {
        let percent = 100.0 * seconds / wall;
        format!("  {name:<16} {seconds:>10.2} s {percent:>5.1} %")
    };
    let mut lines = vec![format!("wall time          {wall:>10.2} s")];
    lines.extend(shares.iter().map(share));
    lines
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

/// The Ipopt that a run was solved by.
fn ipopt_lines() -> Vec<String> {
    let versions = versions();
    let blas = versions.blas.as_ref();
    let mut lines = vec![format!(
        "run by             Ipopt {} with {}, {}",
        versions.ipopt,
        versions.linear_solver.as_deref().unwrap_or("unknown"),
        blas.map_or("unknown BLAS".into(), ToString::to_string)
    )];
    if blas.is_some_and(Blas::is_reference) {
        let slow = "slow: the reference BLAS is loaded, `apt-get install libopenblas0-serial` gives a fast one";
        lines.push(slow.into());
    }
    lines
}
