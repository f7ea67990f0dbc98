//! Diagnosis of the installed Ipopt, for reports and for solves that are slow or do not start.

use std::fmt;

use ipopt_sys as sys;

pub use super::library::Version;
use super::library::{dotted, mismatch};
use super::{Error, Libraries, OptionError, Options, Ordering, Solver, Start, Status};
use crate::nlp::{Bounds, Nlp, Pattern, Structure};

/// The result of [`diagnose`]; its `Display` form is a readable report.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Diagnosis {
    /// The Ipopt this program was compiled for.
    pub headers: Version,
    /// The Ipopt it runs with.
    pub library: Option<Version>,
    /// The libraries it has loaded.
    pub libraries: Libraries,
    /// The linear solvers Ipopt knows, and whether it has them.
    pub linear_solvers: Vec<LinearSolverFound>,
    /// MUMPS at work in different orderings; empty without MUMPS, and if not asked for.
    pub trials: Vec<Trial>,
}

/// A linear solver, and whether Ipopt could solve a test problem with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinearSolverFound {
    /// Its name as a value of the option `linear_solver`.
    pub name: &'static str,
    /// Whether it works.
    pub works: bool,
}

/// One factorisation of the same matrix, with the pattern of elasticity in space.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Trial {
    /// The ordering asked for by `mumps_pivot_order`.
    pub asked: Ordering,
    /// The one MUMPS used.
    pub used: Ordering,
    /// Unknowns of the matrix.
    pub unknowns: usize,
    /// Bytes of the factor.
    pub factor_bytes: u64,
    /// Bytes allocated for it beforehand.
    pub workspace_bytes: Option<u64>,
    /// Wall seconds of analysis and of one factorisation.
    pub seconds: f64,
}

/// Every name that the option `linear_solver` has had, but "custom".
const LINEAR_SOLVERS: [&str; 10] = [
    "mumps",
    "ma27",
    "ma57",
    "ma77",
    "ma86",
    "ma97",
    "pardiso",
    "pardisomkl",
    "spral",
    "wsmp",
];

/// The options that tell which linear solver is taken, and where it is.
const CHOICE: [&str; 3] = ["linear_solver", "hsllib", "pardisolib"];

/// Points along an edge of the cube whose matrix is factorised in a [`Trial`]; three unknowns each.
const TRIAL_POINTS: usize = 16;

/// The ratio to the smallest factor in a [`Trial`] beyond which MUMPS' own choice of ordering gives a remark.
const MUCH: f64 = 1.3;

/// Finds the versions of Ipopt, its working linear solvers and its BLAS, in some milliseconds.
///
/// # Errors
/// [`Error::Reentrant`] inside a callback.
pub fn inspect() -> Result<Diagnosis, Error> {
    let mut linear_solvers = Vec::new();
    for name in LINEAR_SOLVERS {
        if let Some(works) = works(name)? {
            linear_solvers.push(LinearSolverFound { name, works });
        }
    }
    Ok(Diagnosis {
        headers: sys::HEADER_VERSION,
        library: sys::library_version(),
        libraries: Libraries::loaded(),
        linear_solvers,
        trials: Vec::new(),
    })
}

/// As [`inspect`], and tries the orderings of MUMPS, which takes a second or two.
///
/// # Errors
/// As [`inspect`].
pub fn diagnose() -> Result<Diagnosis, Error> {
    let mut diagnosis = inspect()?;
    if diagnosis.works("mumps") {
        let orderings = [
            Ordering::Automatic,
            Ordering::Metis,
            Ordering::Scotch,
            Ordering::Pord,
            Ordering::Amf,
        ];
        for asked in orderings {
            diagnosis.trials.extend(trial(asked)?);
        }
    }
    Ok(diagnosis)
}

/// Checks that Ipopt can solve with the linear solver that `options` name, if they name one: it solves a problem of one variable.
///
/// ```
/// use contact_core::ipopt::{Options, doctor};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// doctor::check_linear_solver(&Options::new())?;
/// let there = doctor::inspect()?;
/// let ma27 = Options::new().with("linear_solver", "ma27");
/// assert_eq!(doctor::check_linear_solver(&ma27).is_ok(), there.works("ma27"));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`OptionError::MissingSolver`] names those that are there; options that Ipopt refuses; [`Error::Reentrant`] inside a callback.
pub fn check_linear_solver(options: &Options) -> Result<(), Error> {
    let name = "linear_solver";
    let Some(value) = options.get(name) else {
        return Ok(());
    };
    let own = options.iter().filter(|(name, _)| CHOICE.contains(name));
    let own = own.fold(Options::new(), |own, (name, value)| {
        own.with(name, value.clone())
    });
    match solve(&Quadratic::spring(), &own)?.0 {
        Status::Solved => Ok(()),
        _ => Err(Error::Option(OptionError::MissingSolver {
            name: name.to_owned(),
            value: value.clone(),
            there: inspect()?.working_linear_solvers().collect(),
        })),
    }
}

impl Diagnosis {
    /// Whether Ipopt has the linear solver of this name.
    pub fn works(&self, linear_solver: &str) -> bool {
        self.working_linear_solvers()
            .any(|name| name == linear_solver)
    }

    /// The linear solvers Ipopt has.
    pub fn working_linear_solvers(&self) -> impl Iterator<Item = &'static str> + '_ {
        let works = |found: &&LinearSolverFound| found.works;
        self.linear_solvers
            .iter()
            .filter(works)
            .map(|found| found.name)
    }

    /// Problems found, each with its remedy; empty if there are none.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        remarks.extend(
            self.library
                .and_then(|library| mismatch(self.headers, library)),
        );
        if self.working_linear_solvers().next().is_none() {
            remarks.push(
                "no linear solver works: install one that Ipopt is linked to, such as MUMPS"
                    .to_owned(),
            );
        }
        if self
            .libraries
            .blas
            .as_ref()
            .is_some_and(|blas| blas.is_reference())
        {
            remarks.push(
                "the reference BLAS is loaded, several times slower than others: install a fast one \
                 (Debian, Ubuntu: `apt-get install libopenblas0-serial`)"
                    .to_owned(),
            );
        }
        remarks.extend(self.ordering_remark());
        remarks
    }

    /// A remark if the ordering that MUMPS chooses makes a much larger factor than the best one.
    fn ordering_remark(&self) -> Option<String> {
        let automatic = self
            .trials
            .iter()
            .find(|t| t.asked == Ordering::Automatic)?;
        let best = self.trials.iter().min_by_key(|t| t.factor_bytes)?;
        let ratio = automatic.factor_bytes as f64 / best.factor_bytes as f64;
        (ratio > MUCH).then(|| {
            format!(
                "left to itself, MUMPS orders by {}, and its factor is {ratio:.1} times as large as with {}: set \
                 `mumps_pivot_order` to {} for large problems in space",
                automatic.used,
                best.used,
                best.used.code()
            )
        })
    }
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Ipopt {}", dotted(self.headers))?;
        match self.library {
            Some(library) if library == self.headers => {}
            Some(library) => write!(f, ", running with {}", dotted(library))?,
            None => write!(f, " (headers; the library does not tell)")?,
        }
        if let Some(path) = &self.libraries.ipopt {
            write!(f, ", {}", path.display())?;
        }
        let names = |works: bool| {
            let found = self
                .linear_solvers
                .iter()
                .filter(|found| found.works == works);
            let names: Vec<_> = found.map(|found| found.name).collect();
            if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            }
        };
        write!(
            f,
            "\nlinear solvers: {} (missing: {})",
            names(true),
            names(false)
        )?;
        if let Some(path) = &self.libraries.linear_solver {
            write!(f, ", {}", path.display())?;
        }
        match &self.libraries.blas {
            Some(blas) => write!(f, "\nBLAS: {blas}")?,
            None => write!(f, "\nBLAS: unknown")?,
        }
        if let Some(first) = self.trials.first() {
            write!(
                f,
                "\nMUMPS on a matrix of elasticity in space, {} unknowns:",
                first.unknowns
            )?;
            write!(
                f,
                "\n  mumps_pivot_order  used        factor  workspace      time"
            )?;
        }
        for trial in &self.trials {
            let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
            let workspace = trial
                .workspace_bytes
                .map_or("unknown".to_owned(), megabytes);
            write!(
                f,
                "\n  {} {:<15}  {:<8} {:>9}  {workspace:>9} {:>6.0} ms",
                trial.asked.code(),
                format!("({})", trial.asked),
                trial.used,
                megabytes(trial.factor_bytes),
                1e3 * trial.seconds
            )?;
        }
        self.remarks()
            .iter()
            .try_for_each(|remark| write!(f, "\nremark: {remark}"))
    }
}

/// Whether a problem of one variable can be solved with it; `None` if this Ipopt does not know the name.
fn works(linear_solver: &'static str) -> Result<Option<bool>, Error> {
    let options = Options::new().with("linear_solver", linear_solver);
    match solve(&Quadratic::spring(), &options) {
        Ok((status, _)) => Ok(Some(status == Status::Solved)),
        Err(Error::Option(OptionError::Invalid { .. })) => Ok(None),
        Err(error) => Err(error),
    }
}

/// One factorisation; `None` if it came to none.
fn trial(asked: Ordering) -> Result<Option<Trial>, Error> {
    let block = Quadratic::block(TRIAL_POINTS);
    let options = Options::new()
        .with("linear_solver", "mumps")
        .with("mumps_pivot_order", asked.code());
    let (_, statistics) = solve(&block, &options)?;
    let seconds = |time: Option<super::Time>| time.map_or(0.0, |time| time.wall);
    let count = statistics.factorizations.unwrap_or(0).max(1) as f64;
    Ok(statistics.mumps.map(|mumps| Trial {
        asked,
        used: mumps.ordering,
        unknowns: block.diagonal.len(),
        factor_bytes: mumps.factor_bytes,
        workspace_bytes: mumps.workspace_bytes,
        seconds: seconds(statistics.symbolic_factorization)
            + seconds(statistics.factorization) / count,
    }))
}

fn solve(quadratic: &Quadratic, options: &Options) -> Result<(Status, super::Statistics), Error> {
    let n = quadratic.diagonal.len();
    let structure = Structure::new(
        Bounds::free(n),
        Bounds::default(),
        Pattern::empty(),
        Some(quadratic.pattern.clone()),
    )?
    .with_constant_hessian(true);
    let solution =
        Solver::new(structure, options)?.solve(&mut &*quadratic, &Start::at(&vec![0.0; n]))?;
    Ok((solution.status, solution.statistics))
}

/// ½ xᵀH x − Σxᵢ with −1 wherever H has an entry off its diagonal.
struct Quadratic {
    pattern: Pattern,
    /// Larger than the sum of its row's other entries, so that H is positive definite.
    diagonal: Vec<f64>,
}

impl Quadratic {
    /// One variable.
    fn spring() -> Self {
        Self {
            pattern: Pattern::diagonal(1),
            diagonal: vec![1.0],
        }
    }

    /// Displacements at the points of a cube, each coupled with its 26 neighbours.
    fn block(points: usize) -> Self {
        let number = |i: usize, j: usize, k: usize| (i * points + j) * points + k;
        let near = |i: usize| i.saturating_sub(1)..(i + 2).min(points);
        let mut pattern = Pattern::empty();
        let mut diagonal = vec![1.0; 3 * points.pow(3)];
        for i in 0..points {
            for j in 0..points {
                for k in 0..points {
                    let neighbours = near(i).flat_map(|i| near(j).map(move |j| (i, j)));
                    for (a, b) in neighbours {
                        for c in near(k) {
                            let dofs = |node: usize| 3 * node..3 * (node + 1);
                            for row in dofs(number(i, j, k)) {
                                for col in dofs(number(a, b, c)).filter(|&col| col <= row) {
                                    pattern.push(row, col);
                                    diagonal[row] += 1.0;
                                    diagonal[col] += 1.0;
                                }
                            }
                        }
                    }
                }
            }
        }
        Self { pattern, diagonal }
    }

    fn values(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        self.pattern.iter().map(|(row, col)| match row == col {
            true => (row, col, self.diagonal[row]),
            false => (row, col, -1.0),
        })
    }
}

impl Nlp for &Quadratic {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let energy = self.values().map(|(row, col, value)| {
            if row == col {
                0.5 * value * x[row] * x[row]
            } else {
                value * x[row] * x[col]
            }
        });
        energy.sum::<f64>() - x.iter().sum::<f64>()
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient.fill(-1.0);
        for (row, col, value) in self.values() {
            gradient[row] += value * x[col];
            if row != col {
                gradient[col] += value * x[row];
            }
        }
    }

    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}

    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}

    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        for (value, (_, _, entry)) in values.iter_mut().zip(self.values()) {
            *value = sigma * entry;
        }
    }
}
