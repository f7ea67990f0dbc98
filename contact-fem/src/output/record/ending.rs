//! What became of a run, and the lines that it prints at its end.

use std::collections::BTreeMap;

use contact_core::cost::Cost;
use contact_core::equilibrium::Choice;
use contact_core::ipopt::{Blas, versions};
use contact_core::{ContactProblem, Ending, InteriorPoint, Method};

use super::observer::Observer;
use super::{Memory, Plan, fixed};
use crate::audit::LeastVolume;
use crate::certificate::{Certificate, Limits};
use crate::error::Error;
use crate::left_out::LeftOut;
use crate::model::{
    BodyError, Crease, ErrorEstimate, GeometricError, InitialGaps, Opposite, PairRecord, Problem,
    Scene, Undetermined, negligible,
};
use crate::simulation::{History, StepRecord};
use crate::tensor::Vector;

/// The share of the largest stored energy that work and stored energy may be apart without a warning.
const UNSTORED: f64 = 0.1;
/// Forces below this share of the largest one of the run are printed as zero.
const PRINTED_AS_ZERO: f64 = 1e-10;
/// Forces whose resultant is below this share of the largest pressure times the area cancel.
const CANCELS: f64 = 1e-6;
/// How many forces, and how many contacts, are printed.
const PRINTED: usize = 6;
/// The significant digits of the largest value of a list; the others end at the same place.
const DIGITS: i32 = 6;

/// What became of a run.
pub(super) struct Ended<'a, const D: usize> {
    pub plan: &'a Plan<'a, D>,
    pub problem: &'a Problem<D>,
    pub records: &'a [StepRecord<D>],
    pub history: Option<&'a History<D>>,
    /// The ending in one word, and as a text.
    pub status: &'static str,
    pub told: String,
    pub choice: Choice,
    pub memory: Memory,
    /// The worst of each condition over all steps.
    pub certificate: Option<Certificate>,
    pub cost: Cost,
    /// Converged steps by solver.
    pub steps_by_solver: BTreeMap<&'static str, usize>,
    pub undetermined: Vec<Undetermined>,
    pub geometric_errors: Vec<GeometricError>,
    pub creases: Vec<Crease<D>>,
    pub estimate: Option<ErrorEstimate<D>>,
    pub left_out: Option<LeftOut>,
    /// The load factor and the smallest volume ratio there, if J > 0 is not shown everywhere.
    pub inverted: Option<(f64, LeastVolume<D>)>,
    /// Wall time by phase (s).
    pub shares: [(&'static str, f64); 5],
    /// Wall time and processor time (s).
    pub wall: f64,
    pub cpu: Option<f64>,
}

impl<'a, const D: usize> Ended<'a, D> {
    /// What became of a run that `observer` has followed, and of its files, with its total time and the processor's (s).
    pub(super) fn new(
        plan: &'a Plan<'a, D>,
        problem: &'a Problem<D>,
        observer: &'a Observer<'a, D>,
        (result, unwritten): (&'a Result<History<D>, Error>, Option<&Error>),
        (choice, memory): (Choice, Memory),
        (wall, cpu): (f64, Option<f64>),
    ) -> Self {
        let (records, history) = (&observer.records[..], result.as_ref().ok());
        let certificates = records.iter().map(|record| record.certificate);
        let certificate = certificates.reduce(Certificate::or_worse);
        let (status, told) = status(result, unwritten, certificate);
        let cost = match history {
            Some(history) => history.run.cost(),
            None => records.iter().map(|record| record.attempt.cost).sum(),
        };
        let solution = history.and_then(|history| history.run.solution.as_ref());
        Ended {
            plan,
            problem,
            records,
            history,
            status,
            told,
            choice,
            memory,
            certificate,
            cost,
            steps_by_solver: steps_by_solver(records),
            undetermined: solution.map_or(Vec::new(), |solution| problem.undetermined(solution)),
            geometric_errors: solution
                .map_or(Vec::new(), |solution| problem.geometric_errors(solution)),
            creases: solution.map_or(Vec::new(), |solution| problem.creases(solution)),
            estimate: solution.and_then(|solution| problem.error_estimate(solution).ok()),
            left_out: history.map(|history| LeftOut::new(problem, history)),
            inverted: inverted(records),
            shares: shares(&cost, observer.seconds, wall),
            wall,
            cpu,
        }
    }

    /// The force that the plan calls `reaction` (UF).
    pub(super) fn reaction(&self) -> Option<f64> {
        let last = self.records.last()?;
        Some(self.plan.force_of(last, self.problem))
    }

    /// A line for each result that matters, and in a [`verbose`](Plan::verbose) run all conditions of the certificate, what was left out,
    /// and what the run cost.
    pub(super) fn text(&self) -> String {
        let mut lines = vec![
            format!("{}: {}", self.plan.name, self.told),
            line("solver", self.solvers()),
        ];
        if let Some(last) = self.records.last() {
            lines.push(line("energy", format!("{} UF·UL", fixed(last.energy, 4))));
            let [work, stored] = [last.work(), last.stored_energy].map(|value| fixed(value, 4));
            lines.push(line(
                "work",
                format!("{work} UF·UL by the trapezoidal rule, of which {stored} UF·UL are stored"),
            ));
            if self.problem.has_friction() {
                let taken = fixed(last.dissipated, 4);
                lines.push(line("friction", format!("{taken} UF·UL of the work")));
            }
            lines.extend(
                self.reaction()
                    .map(|force| line("reaction", format!("{} UF", fixed(force, 4)))),
            );
            lines.extend(self.forces_on_bodies(last));
            lines.extend(contacts(last, self.problem.scene()));
            lines.extend(ties(last, self.problem.scene()));
            lines.extend(motions(last, self.problem.scene()));
            lines.push(line(
                "deepest overlap",
                format!("{:.1e} UL of a node in another surface", last.penetration),
            ));
        }
        lines.extend(
            self.estimate
                .iter()
                .flat_map(|of| estimated(of, self.problem)),
        );
        lines.extend(self.warnings());
        lines.extend(
            self.certificate
                .map(|found| certified(&found, self.plan.verbose)),
        );
        lines.extend(self.costs());
        lines.join("\n  ")
    }

    /// What to look at before the results are believed.
    fn warnings(&self) -> Vec<String> {
        let scene = self.problem.scene();
        let unstored = unstored(self.records, self.problem);
        let mut lines: Vec<String> = unstored.into_iter().collect();
        let undetermined = self.undetermined.iter();
        lines.extend(undetermined.map(|Undetermined { body, motions }| {
            line(
                "undetermined",
                format!("body `{body}`: {}", motions.join(", ")),
            )
        }));
        lines.extend(self.geometric_errors.iter().map(|found| {
            let second = name_of(&found.second, scene);
            let first = scene.name_of_side(&found.first);
            line("warning", format!(
                "contact of {first} with {second} is taken at the reference positions, where gaps differ from the present ones \
                 by {:.3e}, {:.0} % of the indentation: it does not follow the bodies, and its places, areas and forces may be wrong; take contact at \
                 the current positions",
                found.error,
                100.0 * found.error / found.indentation
            ))
        }));
        let creases = self.creases.iter();
        lines.extend(creases.map(|crease| line("warning", crease.to_string())));
        lines.extend(self.inverted.map(|(factor, least)| {
            let at: Vec<String> = least.at.iter().map(|x| format!("{x:.3e}")).collect();
            line(
                "inverted",
                format!(
                    "cell {} of body `{}` at load {factor}: J from {:.3e} at ({})",
                    least.cell,
                    scene.names()[least.body],
                    least.bound,
                    at.join(", ")
                ),
            )
        }));
        lines
    }

    /// The solver, why it was chosen, and what others solved.
    fn solvers(&self) -> String {
        let choice = self.choice;
        let all: usize = self.steps_by_solver.values().sum();
        let others = self
            .steps_by_solver
            .iter()
            .filter(|(solver, _)| **solver != choice.solver);
        let others = others.map(|(solver, count)| format!(", {count} of {all} steps by {solver}"));
        format!("{choice}{}", others.collect::<String>())
    }

    /// Iterations and seconds; in a verbose run what they were spent on.
    fn costs(&self) -> Vec<String> {
        let cost = &self.cost;
        let mut lines = vec![line(
            "cost",
            format!(
                "iterations {}, factorisations {}, {:.2} s",
                cost.outer_iterations, cost.factorizations, self.wall
            ),
        )];
        if self.plan.verbose {
            lines.push(line("inner iterations", cost.inner_iterations.to_string()));
            lines.extend(factor(cost));
            lines.extend(self.left_out.map(|left| line("left out", left.to_string())));
            lines.extend(self.shares.iter().map(|(name, seconds)| {
                let percent = 100.0 * seconds / self.wall;
                line(
                    &format!("  {name}"),
                    format!("{seconds:.2} s, {percent:.1} %"),
                )
            }));
        }
        if self
            .steps_by_solver
            .contains_key(InteriorPoint::default().name())
        {
            lines.extend(ipopt_lines());
        }
        lines
    }
}

/// A line of the text: what, and its value.
fn line(what: &str, value: impl std::fmt::Display) -> String {
    format!("{what:<18} {value}")
}

/// How large a force is (UF); of a scene of revolution its part along the axis, since sums around the axis have no resultant, or that sum where
/// nothing is along the axis.
pub(super) fn size<const D: usize>(force: &Vector<D>, scene: &Scene<D>) -> f64 {
    let (along, all) = (force[D - 1].abs(), force.norm());
    match scene.is_of_revolution() && along > CANCELS * all {
        true => along,
        false => all,
    }
}

impl<const D: usize> Ended<'_, D> {
    /// The forces of supports and obstacles on the bodies, the largest first. What is round-off beside the largest force of the run is zero.
    fn forces_on_bodies(&self, record: &StepRecord<D>) -> Vec<String> {
        let scene = self.problem.scene();
        let all = forces_by(record, scene);
        let of_run = self.records.iter().flat_map(|record| {
            let supports = record.support_reactions.iter().map(|(_, force)| force);
            supports.chain(&record.obstacle_forces)
        });
        let of_run = of_run.map(|force| force.amax()).fold(0.0, f64::max);
        let [_, roundoff, _] = negligible(&self.problem.scale());
        let least = roundoff.max(PRINTED_AS_ZERO * of_run);
        let largest = all
            .iter()
            .map(|(force, _)| force.amax())
            .fold(0.0, f64::max);
        let shown = |x: f64| match largest <= least {
            true => rounded(0.0, 0.0),
            false => rounded(x, largest),
        };
        let told = all
            .iter()
            .map(|(force, by)| match scene.is_of_revolution() {
                true => {
                    let [around, along] = [force[0], force[D - 1]].map(shown);
                    format!("{along} UF along the axis, {around} UF as a sum around it, by {by}")
                }
                false => {
                    let parts: Vec<String> = force.iter().map(|x| shown(*x)).collect();
                    format!("({}) UF by {by}", parts.join(", "))
                }
            });
        listed("forces on bodies", told.collect())
    }
}

/// How far each rigid body has moved.
fn motions<const D: usize>(record: &StepRecord<D>, scene: &Scene<D>) -> Vec<String> {
    let told = record.rigid_motions.iter().map(|motion| {
        let parts = |all: &[f64]| {
            let largest = all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let all: Vec<String> = all.iter().map(|x| rounded(*x, largest)).collect();
            all.join(", ")
        };
        let turned = match &motion.rotation[..] {
            [] => String::new(),
            all => format!(", turned by ({}) radians", parts(all)),
        };
        let moved = parts(motion.displacement.as_slice());
        let name = &scene.names()[motion.body.index()];
        format!("body `{name}` by ({moved}) UL{turned}")
    });
    listed("rigid motions", told.collect())
}

/// The force of each support and each obstacle on the bodies (UF), the largest first.
fn forces_by<const D: usize>(record: &StepRecord<D>, scene: &Scene<D>) -> Vec<(Vector<D>, String)> {
    let supports = record.support_reactions.iter();
    let supports = supports.map(|(side, force)| {
        let name = scene.name_of_side(side);
        (*force, format!("the supports at {name}"))
    });
    let obstacles = record.obstacle_forces.iter().zip(scene.obstacle_names());
    let obstacles = obstacles.map(|(force, name)| (-force, format!("obstacle `{name}`")));
    let mut all: Vec<(Vector<D>, String)> = supports.chain(obstacles).collect();
    all.sort_by(|a, b| size(&b.0, scene).total_cmp(&size(&a.0, scene)));
    all
}

/// Force, largest pressure and area of each contact, the largest force first.
fn contacts<const D: usize>(record: &StepRecord<D>, scene: &Scene<D>) -> Vec<String> {
    let force = |pair: &PairRecord<D>| size(&pair.resultant, scene);
    let mut pairs: Vec<_> = record.pairs.iter().collect();
    pairs.sort_by(|a, b| {
        let own = force(b).total_cmp(&force(a));
        own.then(b.pressure_max.total_cmp(&a.pressure_max))
    });
    let largest =
        |of: &dyn Fn(&PairRecord<D>) -> f64| record.pairs.iter().map(of).fold(0.0, f64::max);
    let all = [
        largest(&force),
        largest(&|pair| pair.pressure_max),
        largest(&|pair| pair.area),
    ];
    let told = pairs.into_iter().map(|pair| {
        // as around a pin, or where a body touches itself
        let cancel = force(pair) < CANCELS * pair.pressure_max * pair.area;
        let force = match cancel {
            true => "forces that cancel".into(),
            false => format!("{} UF", rounded(force(pair), all[0])),
        };
        let friction = match pair.friction.norm() {
            0.0 => String::new(),
            some => format!(", friction {} UF", rounded(some, all[0])),
        };
        format!(
            "{force}{friction}, largest pressure {} UF/UL², area {} UL²: {} and {}",
            rounded(pair.pressure_max, all[1]),
            rounded(pair.area, all[2]),
            scene.name_of_side(&pair.first),
            name_of(&pair.second, scene)
        )
    });
    listed("contact", told.collect())
}

/// What each tie transmits.
fn ties<const D: usize>(record: &StepRecord<D>, scene: &Scene<D>) -> Vec<String> {
    let largest = record
        .ties
        .iter()
        .map(|tie| tie.force.amax())
        .fold(0.0, f64::max);
    let told = record.ties.iter().map(|tie| {
        let parts = |all: &Vector<D>, largest: f64| {
            let parts: Vec<String> = all.iter().map(|x| rounded(*x, largest)).collect();
            parts.join(", ")
        };
        let force = parts(&tie.force, largest);
        let [first, second] = [&tie.first, &tie.second].map(|side| scene.name_of_side(side));
        let moved = match tie.jump.amax() {
            0.0 => String::new(),
            most => format!(", moved against it by ({}) UL", parts(&tie.jump, most)),
        };
        format!("({force}) UF on {first} by {second}{moved}")
    });
    listed("ties", told.collect())
}

/// The first entries, one a line, and how many there are besides.
fn listed(what: &str, mut entries: Vec<String>) -> Vec<String> {
    let others = entries.len().saturating_sub(PRINTED);
    if others > 1 {
        entries.truncate(PRINTED);
        entries.push(format!("and {others} others, in summary.json"));
    }
    let first = [what].into_iter().chain(std::iter::repeat(""));
    entries
        .into_iter()
        .zip(first)
        .map(|(entry, what)| line(what, entry))
        .collect()
}

/// A value rounded to the last significant digit of the largest of its list.
fn rounded(value: f64, largest: f64) -> String {
    if value == 0.0 || !(value.is_finite() && largest.is_finite()) {
        return format!("{}", value + 0.0);
    }
    let places = DIGITS - 1 - largest.log10().floor() as i32;
    let unit = 10f64.powi(places);
    let whole = (value * unit).round();
    // a sum of round-off is no −0
    let near = if whole == 0.0 { 0.0 } else { whole / unit };
    match (1e-4..1e7).contains(&largest) {
        true => {
            let text = format!("{near:.*}", places.max(0) as usize);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').into(),
                false => text,
            }
        }
        false => format!("{near:.*e}", DIGITS as usize - 1),
    }
}

/// Whether the certificate holds, and the conditions that do not, or all.
fn certified(certificate: &Certificate, verbose: bool) -> String {
    if verbose {
        return line("certificate", certificate);
    }
    let limits = Limits::default();
    let broken = certificate.entries(&limits).filter(|entry| !entry.holds());
    let broken: Vec<String> = broken
        .map(|entry| {
            let value = entry.value.unwrap_or(f64::NAN);
            format!("{} {value:.1e} of {:.1e}", entry.name, entry.limit)
        })
        .collect();
    match &broken[..] {
        [] => line(
            "certificate",
            format!("holds in all steps{}", closest(certificate, &limits)),
        ),
        _ => line(
            "certificate",
            format!("DOES NOT HOLD: {} (docs/certificate.md)", broken.join(", ")),
        ),
    }
}

/// The condition that is closest to its limit.
fn closest(certificate: &Certificate, limits: &Limits) -> String {
    let shares = certificate.entries(limits).filter_map(|entry| {
        let share = entry.value? / entry.limit;
        (share >= 0.005).then_some((share, entry.name))
    });
    let most = shares.max_by(|a, b| a.0.total_cmp(&b.0));
    most.map_or(String::new(), |(share, name)| {
        format!("; closest to its limit is {name}, at {:.2} of it", share)
    })
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
    let told = match estimate.relative {
        0.0 => "none: nothing is strained".into(),
        relative => format!(
            "{:.2} % in the energy norm, {:.1e} UF·UL of the energy{}",
            100.0 * relative,
            estimate.energy,
            place.unwrap_or_default()
        ),
    };
    let contacts = estimate.contacts.iter();
    let unresolved = contacts.filter(|pair| pair.is_unresolved(D));
    let warnings = unresolved.map(|pair| {
        let (first, second) = (scene.name_of_side(&pair.first), name_of(&pair.second, scene));
        line("warning", match pair.touching {
            Some(facets) => format!(
                "the mesh does not resolve the contact of {first} with {second}: {facets} facets touch, and force and pressures may be \
                 wrong by a tenth and more; take smaller facets there"
            ),
            None => format!(
                "the mesh does not resolve the contact of {first} with {second}: a node is {:.1e} UL inside, and no force acts: \
                 constraints are means over whole facets, whose other ends are apart; take smaller facets there",
                pair.unfelt
            ),
        })
    });
    [line("estimated error", told)]
        .into_iter()
        .chain(warnings)
        .collect()
}

/// Says so where work and stored energy are far apart. What an interference fit stores is no work of supports and loads.
fn unstored<const D: usize>(records: &[StepRecord<D>], problem: &Problem<D>) -> Option<String> {
    if problem.scene().initial_gaps == InitialGaps::Resolve {
        return None;
    }
    let [.., roundoff] = negligible(&problem.scale());
    let last = records.last()?;
    let apart = (last.work() - last.stored_energy - last.dissipated).abs();
    let most = records.iter().map(|record| record.stored_energy);
    let most = most.fold(last.dissipated, f64::max);
    // where nothing is strained, a rigid body has fallen freely
    let is_far = apart > UNSTORED * most && apart > roundoff && most > roundoff;
    is_far.then(|| {
        line("warning", format!(
            "work and stored energy{} are {:.0} % of the largest {} apart: take more increments; if that does \
             not help, a body has snapped from one equilibrium to another, or contact has begun or ended at once",
            if problem.has_friction() { " with the work of friction" } else { "" },
            100.0 * apart / most,
            if last.dissipated > 0.0 { "of these energies" } else { "stored energy" },
        ))
    })
}

/// The largest factor, in megabytes.
fn factor(cost: &Cost) -> Option<String> {
    let factor = cost.factor?;
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    let mut text = format!("{:.2} MB", megabytes(factor.bytes));
    if let Some(workspace) = factor.workspace_bytes {
        text += &format!(" of {:.2} MB allocated", megabytes(workspace));
    }
    text += &format!(", ordered by {}", factor.ordering);
    if factor.reallocations > 0 {
        text += &format!(", allocated anew {} times", factor.reallocations);
    }
    Some(line("factor", text))
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

pub(super) fn name_of<const D: usize>(opposite: &Opposite, scene: &Scene<D>) -> String {
    match opposite {
        Opposite::Side(side) => scene.name_of_side(side),
        Opposite::Obstacle(id) => format!("obstacle `{}`", scene.obstacle_names()[id.index()]),
    }
}

/// The Ipopt that a run was solved by.
fn ipopt_lines() -> Vec<String> {
    let versions = versions();
    let blas = versions.blas.as_ref();
    let mut lines = vec![line(
        "run by",
        format!(
            "Ipopt {} with {}, {}",
            versions.ipopt,
            versions.linear_solver.as_deref().unwrap_or("unknown"),
            blas.map_or("unknown BLAS".into(), ToString::to_string)
        ),
    )];
    if blas.is_some_and(Blas::is_reference) {
        let slow = "slow: the reference BLAS is loaded, `apt-get install libopenblas0-serial` gives a fast one";
        lines.push(slow.into());
    }
    lines
}
