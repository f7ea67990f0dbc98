//! The history of a run as tables: a line for each load step, for each iteration of the solver, for each pair of surfaces in
//! contact, for each support, and for everything that does work.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use contact_core::load_steps::Attempt;
use contact_core::{Cost, Outcome};

use super::file;
use crate::certificate::{Certificate, Condition, Limits};
use crate::error::Error;
use crate::model::{Opposite, PairRecord, Side, WorkRecord, WorkSource};
use crate::simulation::{History, StepRecord};
use crate::tensor::Vector;

/// `NAME.csv`, the load steps, and `NAME_iterations.csv`, the iterations of the solver within them. For each converged step
/// `NAME_pairs.csv` has a line for each pair of surfaces, `NAME_supports.csv` one for the reaction of each boundary that supports name, and `NAME_work.csv`
/// one for the work of each support, load and obstacle since the start.
///
/// After every converged step [`Tables::write`] saves the step to disk. Failed attempts are known
/// only at the end of the run: [`Tables::finish`] writes both files anew with all attempts in
/// order. The column `outcome` contains the ending of an attempt; columns that require a converged
/// state are empty for failed attempts. Columns with a body and an axis in their name, such as
/// `reaction_ring_x` of the body `ring`, exist for every body.
#[derive(Debug)]
pub struct Tables {
    steps: Table,
    iterations: Table,
    pairs: Table,
    supports: Table,
    works: Table,
    bodies: Vec<String>,
    obstacles: Vec<String>,
    rigid: usize,
}

impl Tables {
    /// Empty tables called `name` in `folder`, which is created if it does not exist, for a scene
    /// with these names of its bodies, its obstacles and those bodies that are rigid.
    ///
    /// # Errors
    /// [`Error::Write`] if the files cannot be created or the name has characters other than
    /// letters, digits, `_`, `-` and `.`.
    pub fn create<const D: usize>(
        folder: &Path,
        name: &str,
        (bodies, obstacles, rigid): (&[String], &[String], &[String]),
    ) -> Result<Self, Error> {
        file::check_name(folder, name)?;
        file::create_folder(folder)?;
        let [steps, iterations, pairs, supports, works] = Self::files(name);
        Ok(Tables {
            steps: Table::create(
                folder.join(steps),
                step_columns::<D>(bodies, obstacles, rigid),
            )?,
            iterations: Table::create(folder.join(iterations), strings(&ITERATION_COLUMNS))?,
            pairs: Table::create(folder.join(pairs), pair_columns::<D>())?,
            supports: Table::create(folder.join(supports), support_columns::<D>())?,
            works: Table::create(folder.join(works), strings(&WORK_COLUMNS))?,
            bodies: bodies.to_vec(),
            obstacles: obstacles.to_vec(),
            rigid: rigid.len(),
        })
    }

    /// The names of the tables' files.
    pub(super) fn files(name: &str) -> [String; 5] {
        ["", "_iterations", "_pairs", "_supports", "_work"].map(|what| format!("{name}{what}.csv"))
    }

    /// The path of the table of the load steps.
    pub fn path(&self) -> &Path {
        &self.steps.path
    }

    /// The number of vectors in a line: two for each body, one for each obstacle and each rigid body.
    fn vectors(&self) -> usize {
        2 * self.bodies.len() + self.obstacles.len() + self.rigid
    }

    /// Adds a converged step.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write<const D: usize>(&mut self, record: &StepRecord<D>) -> Result<(), Error> {
        let line = step_line(&record.attempt, Some(record), self.vectors());
        self.steps.append([line])?;
        self.pairs
            .append(pair_lines(record, (&self.bodies, &self.obstacles)))?;
        self.supports.append(support_lines(record, &self.bodies))?;
        self.works
            .append(work_lines(record, (&self.bodies, &self.obstacles)))?;
        let lines = iteration_lines(&record.attempt, record.increment);
        self.iterations.append(lines)
    }

    /// Writes the tables of steps and iterations anew with every attempt of the run, converged or not.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish<const D: usize>(&mut self, history: &History<D>) -> Result<(), Error> {
        let mut records = history.steps.iter();
        let (mut steps, mut iterations) = (Vec::new(), Vec::new());
        for attempt in &history.run.attempts {
            let record = match attempt.outcome {
                Outcome::Converged => records.next(),
                _ => None,
            };
            steps.push(step_line(attempt, record, self.vectors()));
            let increment = record.and_then(|record| record.increment);
            iterations.extend(iteration_lines(attempt, increment));
        }
        self.steps.replace(steps)?;
        self.iterations.replace(iterations)
    }
}

/// The cost of an attempt, converged or not: the last columns of a step.
const COST_COLUMNS: [&str; 13] = [
    "iterations",
    "inner_iterations",
    "factorisations",
    "solves",
    "cold_retries",
    "value_evaluations",
    "gradient_evaluations",
    "hessian_evaluations",
    "seconds_projection",
    "seconds_callbacks",
    "seconds_optimizer",
    "seconds_total",
    "predicted",
];

/// The certificate of a converged step, see [`Certificate`].
fn certificate_columns() -> impl Iterator<Item = String> {
    let names = Condition::all().map(Condition::name);
    let names = names.chain(["roundoff", "holds"]);
    names.map(|name| format!("certificate_{name}"))
}

const ITERATION_COLUMNS: [&str; 17] = [
    "increment",
    "from",
    "load_factor",
    "iteration",
    "solver",
    "error",
    "rows",
    "inner_iterations",
    "factorisations",
    "solves",
    "cold_retries",
    "value_evaluations",
    "gradient_evaluations",
    "hessian_evaluations",
    "seconds_projection",
    "seconds_callbacks",
    "seconds_optimizer",
];

/// The names of a vector's components.
fn components<const D: usize>(name: &str) -> impl Iterator<Item = String> {
    let axes = ["x", "y", "z"].into_iter().take(D);
    axes.map(move |axis| format!("{name}_{axis}"))
}

fn pair_columns<const D: usize>() -> Vec<String> {
    let mut columns = strings(&[
        "increment",
        "load_factor",
        "first_body",
        "first_boundary",
        "second_body",
        "second_boundary",
        "area",
    ]);
    columns.extend(components::<D>("resultant").chain(components::<D>("centre")));
    columns.push("pressure_max".into());
    columns
}

fn pair_lines<const D: usize>(
    record: &StepRecord<D>,
    (bodies, obstacles): (&[String], &[String]),
) -> Vec<Vec<String>> {
    let line = |pair: &PairRecord<D>| {
        let mut line = step_name(record);
        line.extend(side_name(&pair.first, bodies));
        line.extend(match &pair.second {
            Opposite::Side(side) => side_name(side, bodies),
            Opposite::Obstacle(id) => [
                obstacles.get(id.index()).cloned().unwrap_or_default(),
                String::new(),
            ],
        });
        line.push(number(pair.area));
        line.extend(pair.resultant.iter().copied().map(number));
        match pair.centre {
            Some(centre) => line.extend(centre.iter().copied().map(number)),
            None => line.extend(vec![String::new(); D]),
        }
        line.push(number(pair.pressure_max));
        line
    };
    record.pairs.iter().map(line).collect()
}

fn support_columns<const D: usize>() -> Vec<String> {
    let mut columns = strings(&["increment", "load_factor", "body", "boundary"]);
    columns.extend(components::<D>("reaction"));
    columns
}

fn support_lines<const D: usize>(record: &StepRecord<D>, bodies: &[String]) -> Vec<Vec<String>> {
    let line = |(side, reaction): &(Side, Vector<D>)| {
        let mut line = step_name(record);
        line.extend(side_name(side, bodies));
        line.extend(reaction.iter().copied().map(number));
        line
    };
    record.support_reactions.iter().map(line).collect()
}

const WORK_COLUMNS: [&str; 6] = ["increment", "load_factor", "kind", "of", "boundary", "work"];

fn work_lines<const D: usize>(
    record: &StepRecord<D>,
    (bodies, obstacles): (&[String], &[String]),
) -> Vec<Vec<String>> {
    let line = |own: &WorkRecord| {
        let mut line = step_name(record);
        line.push(own.source.kind().into());
        line.extend(source_name(&own.source, bodies, obstacles));
        line.push(number(own.work));
        line
    };
    record.works.iter().map(line).collect()
}

/// The body or obstacle of a source of work, and its boundary.
pub(super) fn source_name(
    source: &WorkSource,
    bodies: &[String],
    obstacles: &[String],
) -> [String; 2] {
    let name = |names: &[String], number: usize| names.get(number).cloned().unwrap_or_default();
    match source {
        WorkSource::Support(side)
        | WorkSource::Foundation(side)
        | WorkSource::Traction(side)
        | WorkSource::Pressure(side)
        | WorkSource::Tie(side) => side_name(side, bodies),
        WorkSource::BodyForce(body) | WorkSource::NodalForce(body) => {
            [name(bodies, body.index()), String::new()]
        }
        WorkSource::Obstacle(id) => [name(obstacles, id.index()), String::new()],
    }
}

/// The first columns of a line that belongs to a converged step.
fn step_name<const D: usize>(record: &StepRecord<D>) -> Vec<String> {
    let increment = record.increment.map(|k| k.to_string());
    vec![increment.unwrap_or_default(), number(record.factor)]
}

fn side_name(side: &Side, bodies: &[String]) -> [String; 2] {
    let body = bodies.get(side.body.index()).cloned();
    [body.unwrap_or_default(), side.boundary.clone()]
}

fn step_columns<const D: usize>(
    bodies: &[String],
    obstacles: &[String],
    rigid: &[String],
) -> Vec<String> {
    let mut columns = strings(&[
        "increment",
        "phase",
        "from",
        "load_factor",
        "outcome",
        "solver",
        "failed",
        "energy",
        "stored_energy",
        "work",
    ]);
    let on_bodies = ["reaction", "contact_force"].map(|quantity| (quantity, bodies));
    let others = [("contact_force", obstacles), ("displacement", rigid)];
    for (quantity, names) in on_bodies.into_iter().chain(others) {
        for name in names {
            let axes = ["x", "y", "z"].into_iter().take(D);
            columns.extend(axes.map(|axis| format!("{quantity}_{name}_{axis}")));
        }
    }
    columns.extend(strings(&[
        "min_j",
        "min_j_bound",
        "rows",
        "penetration",
        "weak_penetration",
    ]));
    columns.extend(strings(&COST_COLUMNS));
    columns.extend(certificate_columns());
    columns
}

fn step_line<const D: usize>(
    attempt: &Attempt,
    record: Option<&StepRecord<D>>,
    vectors: usize,
) -> Vec<String> {
    let increment = record.and_then(|record| record.increment);
    let failed: Vec<String> = attempt.failed.iter().map(ToString::to_string).collect();
    let mut line = vec![
        increment.map_or_else(String::new, |k| k.to_string()),
        attempt.phase.clone(),
        number(attempt.from),
        number(attempt.to),
        attempt.outcome.to_string(),
        attempt.solver().unwrap_or_default().to_owned(),
        failed.join("; "),
        number(attempt.energy),
    ];
    match record {
        Some(record) => {
            line.extend([record.stored_energy, record.work()].map(number));
            let on_bodies = record.reactions.iter().chain(&record.contact_forces);
            let vectors = on_bodies.chain(&record.obstacle_forces);
            let moved = record.rigid_motions.iter();
            let vectors = vectors.chain(moved.map(|motion| &motion.displacement));
            line.extend(vectors.flat_map(|v| v.iter().copied().map(number)));
            line.extend([record.min_j, record.min_j_bound()].map(number));
            line.push(record.rows.to_string());
            line.extend([record.penetration, record.weak_penetration].map(number));
        }
        None => {
            line.extend(vec![String::new(); 2 + vectors * D]);
            line.push(number(attempt.min_domain));
            line.extend(vec![String::new(); 4]);
        }
    }
    line.push(attempt.iterations.len().to_string());
    line.extend(counts(&attempt.cost));
    line.extend(seconds(&attempt.cost));
    line.push(number(attempt.cost.wall));
    line.push(attempt.predicted.to_string());
    match record {
        Some(record) => line.extend(certificate(&record.certificate)),
        None => line.extend(certificate_columns().map(|_| String::new())),
    }
    line
}

fn certificate(certificate: &Certificate) -> Vec<String> {
    let limits = Limits::default();
    let values = certificate.entries(&limits).map(|entry| entry.value);
    let mut line: Vec<String> = values.map(|v| v.map_or_else(String::new, number)).collect();
    line.push(number(certificate.roundoff()));
    line.push(certificate.holds(&limits).to_string());
    line
}

fn iteration_lines(attempt: &Attempt, increment: Option<usize>) -> Vec<Vec<String>> {
    let line = |(k, iteration): (usize, &contact_core::equilibrium::Iteration)| {
        let mut line = vec![
            increment.map_or_else(String::new, |k| k.to_string()),
            number(attempt.from),
            number(attempt.to),
            (k + 1).to_string(),
            iteration.solver.to_owned(),
            number(iteration.error),
            iteration.rows.to_string(),
        ];
        line.extend(counts(&iteration.cost));
        line.extend(seconds(&iteration.cost));
        line
    };
    attempt.iterations.iter().enumerate().map(line).collect()
}

fn counts(cost: &Cost) -> [String; 7] {
    [
        cost.inner_iterations,
        cost.factorizations,
        cost.solves,
        cost.cold_retries,
        cost.values,
        cost.gradients,
        cost.hessians,
    ]
    .map(|count| count.to_string())
}

fn seconds(cost: &Cost) -> [String; 3] {
    [cost.projection, cost.callbacks, cost.optimizer].map(number)
}

/// The shortest text that reads back as the same number; with an exponent if this is shorter.
fn number(value: f64) -> String {
    // no zero has a sign
    let value = value + 0.0;
    let plain = value == 0.0 || (1e-3..1e15).contains(&value.abs()) || !value.is_finite();
    if plain {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

fn strings(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

/// A file of comma-separated values to which whole lines are appended.
#[derive(Debug)]
struct Table {
    path: PathBuf,
    columns: Vec<String>,
    file: File,
    /// The length of the whole lines.
    length: u64,
}

impl Table {
    fn create(path: PathBuf, columns: Vec<String>) -> Result<Self, Error> {
        let (file, length) = create(&path, &columns, &[])?;
        Ok(Table {
            path,
            columns,
            file,
            length,
        })
    }

    /// Appends lines: all of them, or on an error none.
    fn append(&mut self, lines: impl IntoIterator<Item = Vec<String>>) -> Result<(), Error> {
        let bytes = text(&self.path, lines)?;
        self.file.write_all(&bytes).map_err(|source| {
            // the first error is the one to tell
            let _ = self.file.set_len(self.length);
            file::failed(&self.path, source)
        })?;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Replaces the file by the whole table at once.
    fn replace(&mut self, lines: Vec<Vec<String>>) -> Result<(), Error> {
        (self.file, self.length) = create(&self.path, &self.columns, &lines)?;
        Ok(())
    }
}

/// Replaces the file by a table; later lines are appended to it.
fn create(path: &Path, columns: &[String], lines: &[Vec<String>]) -> Result<(File, u64), Error> {
    let bytes = text(
        path,
        std::iter::once(columns).chain(lines.iter().map(Vec::as_slice)),
    )?;
    file::replace(path, &bytes)?;
    let appending = File::options().append(true).open(path);
    let file = appending.map_err(|source| file::failed(path, source))?;
    Ok((file, bytes.len() as u64))
}

/// The lines of a table as text.
fn text(
    path: &Path,
    lines: impl IntoIterator<Item = impl AsRef<[String]>>,
) -> Result<Vec<u8>, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in lines {
        let written = writer.write_record(line.as_ref());
        written.map_err(|source| file::failed(path, source))?;
    }
    let bytes = writer.into_inner();
    bytes.map_err(|error| file::failed(path, error.to_string()))
}

#[cfg(test)]
mod tests {
    use contact_core::equilibrium::Iteration;
    use contact_core::load_steps::Run;
    use contact_core::{Ending, State};

    use super::*;
    use crate::audit::LeastVolume;
    use crate::model::{BodyId, RigidMotion};

    fn attempt(to: f64, outcome: Outcome) -> Attempt {
        let iteration = Iteration {
            solver: "ipopt",
            error: 0.25,
            rows: 7,
            cost: Cost {
                inner_iterations: 11,
                projection: 0.5,
                ..Cost::default()
            },
        };
        Attempt {
            phase: "press".into(),
            from: 0.0,
            to,
            outcome,
            predicted: false,
            energy: 2.5,
            min_domain: 0.75,
            cost: Cost {
                wall: 4.0,
                ..[iteration.cost; 2].into_iter().sum()
            },
            failed: Vec::new(),
            iterations: vec![iteration; 2],
        }
    }

    fn record(to: f64) -> StepRecord<2> {
        StepRecord {
            factor: to,
            increment: Some(1),
            energy: 2.5,
            stored_energy: 3.5,
            dissipated: 0.0,
            works: vec![
                WorkRecord {
                    source: WorkSource::Traction(BodyId::from(0).on("rim")),
                    work: 3.5,
                },
                WorkRecord {
                    source: WorkSource::BodyForce(BodyId::from(0)),
                    work: 0.125,
                },
            ],
            reactions: vec![Vector::<2>::new(1e-7, -3.5)],
            contact_forces: vec![Vector::<2>::new(0.0, 4.5)],
            obstacle_forces: vec![Vector::<2>::new(0.25, -4.5)],
            min_j: 0.75,
            least_volume: Some(LeastVolume {
                bound: 0.5,
                body: 0,
                cell: 3,
                at: Vector::zeros(),
            }),
            rows: 7,
            penetration: 0.0,
            weak_penetration: 1e-12,
            certificate: Certificate::uniform(0.0, 0.0)
                .with(Condition::WeakPenetration, Some(0.5))
                .with(Condition::Stationarity, Some(1e-9))
                .with(Condition::Drift, None)
                .with(Condition::Dropped, Some(3.0)),
            support_reactions: vec![(BodyId::from(0).on("rim"), Vector::<2>::new(1.5, -2.0))],
            pairs: vec![PairRecord {
                first: BodyId::from(0).on("rim"),
                second: Opposite::Side(BodyId::from(1).on("edge")),
                area: 0.5,
                resultant: Vector::<2>::new(0.0, 4.5),
                friction: Vector::zeros(),
                centre: None,
                pressure_max: 9.0,
            }],
            ties: Vec::new(),
            rigid_motions: vec![RigidMotion {
                body: BodyId::from(0),
                displacement: Vector::<2>::new(0.0, -0.125),
                rotation: Vec::new(),
            }],
            pressures: [0.0, 9.0],
            attempt: attempt(to, Outcome::Converged),
        }
    }

    fn read(path: &Path) -> Vec<Vec<String>> {
        let reader = csv::Reader::from_path(path).expect("a table");
        let lines = reader.into_records().map(|line| line.expect("a line"));
        lines
            .map(|line| line.iter().map(str::to_string).collect())
            .collect()
    }

    #[test]
    fn converged_steps_at_once_and_failures_at_the_end() {
        let folder = std::env::temp_dir().join(format!("contact-fem-csv-{}", std::process::id()));
        let names = [["ring".to_string()], ["pin".to_string()]];
        let mut tables =
            Tables::create::<2>(&folder, "run", (&names[0], &names[1], &names[0])).expect("tables");
        tables.write(&record(1.0)).expect("written");
        let columns = step_columns::<2>(&names[0], &names[1], &names[0]);
        let at = |name: &str| columns.iter().position(|c| c == name).expect(name);
        let steps = read(tables.path());
        assert_eq!(steps.len(), 1);
        assert_eq!(steps[0][at("phase")], "press");
        assert_eq!(steps[0][at("reaction_ring_x")], "1e-7");
        assert_eq!(steps[0][at("contact_force_ring_y")], "4.5");
        assert_eq!(steps[0][at("contact_force_pin_x")], "0.25");
        assert_eq!(steps[0][at("displacement_ring_y")], "-0.125");
        assert_eq!(steps[0][at("stored_energy")], "3.5");
        assert_eq!(steps[0][at("work")], "3.625");
        assert_eq!(steps[0][at("rows")], "7");
        assert_eq!(steps[0][at("min_j_bound")], "0.5");
        assert_eq!(steps[0][at("penetration")], "0");
        assert_eq!(steps[0][at("weak_penetration")], "1e-12");
        assert_eq!(steps[0][at("inner_iterations")], "22");
        assert_eq!(steps[0][at("certificate_stationarity")], "1e-9");
        assert_eq!(steps[0][at("certificate_drift")], "");
        assert_eq!(steps[0][at("certificate_holds")], "false");

        let failed = attempt(2.0, Outcome::IterationLimit);
        let history = History {
            run: Run {
                ending: Ending::Complete,
                factor: 1.0,
                state: State::default(),
                solution: None,
                attempts: vec![failed, attempt(1.0, Outcome::Converged)],
                error: None,
            },
            steps: vec![record(1.0)],
        };
        tables.finish(&history).expect("written");
        let steps = read(tables.path());
        assert_eq!(steps.len(), 2);
        assert_eq!(steps[0][at("outcome")], "iteration limit");
        assert_eq!(steps[0][at("reaction_ring_y")], "");
        assert_eq!(steps[0][at("min_j")], "0.75");
        assert_eq!(steps[0][at("certificate_holds")], "");
        assert_eq!(steps[0][at("rows")], "");
        assert_eq!(steps[0][at("inner_iterations")], "22");
        assert_eq!(steps[1][at("increment")], "1");
        assert_eq!(read(&folder.join("run_iterations.csv")).len(), 4);
        // neither body nor centre of the second surface is known
        let pairs = read(&folder.join("run_pairs.csv"));
        let expected = [
            "1", "1", "ring", "rim", "", "edge", "0.5", "0", "4.5", "", "", "9",
        ];
        assert_eq!(pairs, [expected]);
        assert_eq!(pair_columns::<2>().len(), expected.len());
        let supports = read(&folder.join("run_supports.csv"));
        assert_eq!(supports, [["1", "1", "ring", "rim", "1.5", "-2"]]);
        let works = read(&folder.join("run_work.csv"));
        let expected = [
            ["1", "1", "traction", "ring", "rim", "3.5"],
            ["1", "1", "body force", "ring", "", "0.125"],
        ];
        assert_eq!(works, expected);
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        let folder = std::env::temp_dir().join(format!("contact-fem-name-{}", std::process::id()));
        for name in [
            "", ".", "..", "../evil", "a/b", "/evil", "a\\b", "a\nb", "a\0",
        ] {
            let refused = Tables::create::<2>(&folder, name, (&[], &[], &[]));
            assert!(matches!(refused, Err(Error::Write { .. })), "{name:?}");
        }
        assert!(!folder.exists());
    }

    #[test]
    fn numbers_read_back() {
        for value in [0.0, 1.0 / 3.0, -1e-9, 6.02e23, 1234.5] {
            assert_eq!(number(value).parse(), Ok(value));
        }
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!(number(-0.0), "0");
    }
}
