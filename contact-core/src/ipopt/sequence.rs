//! Runs of similar problems, each started from the solution of the one before.

use std::ops::ControlFlow;

use super::{
    Error, Log, Scaling, SequenceSettings, Solution, Solver, Start, Status, Totals,
    scaling::scaling_is_used,
};
use crate::nlp::{Bounds, Iterate, Multipliers, Nlp, Structure};

/// Ipopt on a run of similar problems: load steps, parameters, a path.
///
/// Each solve starts from x and the multipliers of the last one that was solved. If this warm start fails, by its
/// status or by too many iterations, the solve is repeated from a cold start at the same x; [`Run::retried`] and
/// [`Totals::cold_retries`] report that. If both fail, the next solve starts from the same point again.
///
/// ```
/// # use contact_core::ipopt::{Sequence, SequenceSettings};
/// # use contact_core::nlp::{Bounds, Nlp, Pattern, Structure};
/// /// min (x − c)² subject to 0 ≤ x ≤ 1.
/// struct Follow(f64);
/// # impl Nlp for Follow {
/// #     fn objective(&mut self, x: &[f64], _: bool) -> f64 { (x[0] - self.0).powi(2) }
/// #     fn gradient(&mut self, x: &[f64], _: bool, g: &mut [f64]) { g[0] = 2.0 * (x[0] - self.0); }
/// #     fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
/// #     fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
/// #     fn hessian(&mut self, _: &[f64], _: bool, s: f64, _: &[f64], v: &mut [f64]) { v[0] = 2.0 * s; }
/// # }
/// # let structure = Structure::new(
/// #     Bounds::uniform(1, 0.0, 1.0), Bounds::default(), Pattern::empty(), Some(Pattern::diagonal(1)))?;
/// let mut sequence = Sequence::new(structure, SequenceSettings::default(), &[0.5])?;
/// for c in [1.1, 1.2, 1.3] {
///     let run = sequence.solve(&mut Follow(c))?;
///     assert!(run.solved && (run.solution.x[0] - 1.0).abs() < 1e-7);
/// }
/// assert_eq!(sequence.totals().warm, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sequence {
    settings: SequenceSettings,
    solver: Solver,
    scaling: Option<Scaling>,
    x: Vec<f64>,
    /// `None` where the last ones are not those of a problem with this structure.
    multipliers: Option<Multipliers>,
    /// Iterations of the last cold solve that solved a problem with this structure.
    cold_iterations: Option<usize>,
    totals: Totals,
}

/// One problem of a [`Sequence`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Run {
    /// The last solve's.
    pub solution: Solution,
    /// Whether that is a solution: [`Status::Solved`] or [`Status::FeasiblePointFound`], or as good as
    /// [`SequenceSettings::attainable_error`] allows.
    pub solved: bool,
    /// Whether it started warm.
    pub warm: bool,
    /// How the warm solve ended that it repeats, if it does.
    pub retried: Option<Retried>,
}

/// A warm solve that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Retried {
    /// Its status; [`Status::IterationLimit`] if it took too many iterations.
    pub status: Status,
    /// Its iterations.
    pub iterations: usize,
}

impl Sequence {
    /// A sequence of problems of this structure; the first is started cold at `x` (n).
    ///
    /// # Errors
    /// An option Ipopt refuses, for cold or for warm solves, or an x that is not finite or of another size.
    /// [`Error::MissingMultipliers`] if cold solves were to start from multipliers.
    pub fn new(structure: Structure, settings: SequenceSettings, x: &[f64]) -> Result<Self, Error> {
        Start::at(x).validate(&structure)?;
        let solver = settings.solver(structure)?;
        Ok(Self {
            settings,
            solver,
            scaling: None,
            x: x.to_vec(),
            multipliers: None,
            cold_iterations: None,
            totals: Totals::default(),
        })
    }

    /// Solves the next problem.
    ///
    /// # Errors
    /// As [`Solver::solve`]. The problem does not count then.
    ///
    /// # Panics
    /// As [`Solver::solve`]; the memory then is what it was before.
    pub fn solve(&mut self, nlp: &mut dyn Nlp) -> Result<Run, Error> {
        self.solve_with(nlp, |_| ControlFlow::Continue(()))
    }

    /// Solves the next problem and shows every iterate of each of its solves to `watch`, as [`Solver::solve_with`].
    /// One that is stopped, or ends at a limit of time, is not repeated.
    ///
    /// # Errors
    /// As [`Sequence::solve`].
    ///
    /// # Panics
    /// As [`Sequence::solve`].
    pub fn solve_with(
        &mut self,
        nlp: &mut dyn Nlp,
        mut watch: impl FnMut(&Iterate<'_>) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        let mut retried = None;
        if self.multipliers.is_some() {
            let solution = self.attempt(nlp, true, &mut watch)?;
            let solved = self.settings.is_solved(&solution);
            if solved || solution.status.is_final() {
                return Ok(self.remember(solution, solved, true, None));
            }
            self.totals.cold_retries += 1;
            retried = Some(Retried {
                status: solution.status,
                iterations: solution.statistics.iterations,
            });
        }
        let solution = self.attempt(nlp, false, &mut watch)?;
        let solved = self.settings.is_solved(&solution);
        if solved {
            self.cold_iterations = Some(solution.statistics.iterations);
        }
        Ok(self.remember(solution, solved, false, retried))
    }

    /// Says where Ipopt's log goes, as [`Solver::set_log`].
    pub fn set_log(&mut self, log: Log) {
        self.solver.set_log(log);
    }

    /// Scales the problems to come, as [`Solver::set_scaling`].
    ///
    /// # Errors
    /// As [`Solver::set_scaling`], whether the options of cold or of warm solves set something else.
    pub fn set_scaling(&mut self, scaling: &Scaling) -> Result<(), Error> {
        scaling_is_used(&self.settings.warm_options(None))?;
        scaling_is_used(&self.settings.options)?;
        self.solver.set_scaling(scaling)?;
        self.scaling = Some(scaling.clone());
        Ok(())
    }

    /// Scales no more, as [`Solver::clear_scaling`].
    ///
    /// # Errors
    /// As [`Solver::clear_scaling`].
    pub fn clear_scaling(&mut self) -> Result<(), Error> {
        self.scaling = None;
        self.solver.clear_scaling()
    }

    /// Other bounds for the problems to come; x and the multipliers stay.
    ///
    /// # Errors
    /// As [`Solver::set_bounds`].
    pub fn set_bounds(&mut self, variables: Bounds, constraints: Bounds) -> Result<(), Error> {
        self.solver.set_bounds(variables, constraints)
    }

    /// Replaces the structure: the next problem starts at `x`, warm if `multipliers` of the new structure are given,
    /// for instance where constraints come and go and the caller can match them. Log and scaling are kept. The limit
    /// on iterations of warm solves applies once a cold one has solved a problem of the new structure.
    ///
    /// # Errors
    /// As [`Sequence::new`] and [`Sequence::restart`]; also a scaling for other sizes, which is to be cleared before.
    /// Everything then stays as it was.
    pub fn set_structure(
        &mut self,
        structure: Structure,
        x: &[f64],
        multipliers: Option<Multipliers>,
    ) -> Result<(), Error> {
        let start = Start {
            x,
            multipliers: multipliers.as_ref(),
        };
        start.validate(&structure)?;
        let mut solver = self.settings.solver(structure)?;
        if let Some(scaling) = &self.scaling {
            solver.set_scaling(scaling)?;
        }
        solver.set_log(self.solver.take_log());
        self.solver = solver;
        self.cold_iterations = None;
        self.restart(x, multipliers)
    }

    /// Sets the start `x` of the next problem, warm if `multipliers` are given. The limit on iterations of warm solves
    /// does not change.
    ///
    /// # Errors
    /// Values that are not finite, or of another number; the start then stays as it was.
    pub fn restart(&mut self, x: &[f64], multipliers: Option<Multipliers>) -> Result<(), Error> {
        let start = Start {
            x,
            multipliers: multipliers.as_ref(),
        };
        start.validate(self.solver.structure())?;
        self.x = x.to_vec();
        self.multipliers = multipliers;
        Ok(())
    }

    /// Where the next problem starts.
    pub fn start(&self) -> Start<'_> {
        Start {
            x: &self.x,
            multipliers: self.multipliers.as_ref(),
        }
    }

    /// What all solves have cost so far.
    pub fn totals(&self) -> &Totals {
        &self.totals
    }

    fn attempt(
        &mut self,
        nlp: &mut dyn Nlp,
        warm: bool,
        watch: impl FnMut(&Iterate<'_>) -> ControlFlow<()>,
    ) -> Result<Solution, Error> {
        let options = match warm {
            true => self.settings.warm_options(self.cold_iterations),
            false => self.settings.options.clone(),
        };
        self.solver.set_options(&options)?;
        let start = Start {
            x: &self.x,
            multipliers: self.multipliers.as_ref().filter(|_| warm),
        };
        let solution = self.solver.solve_with(nlp, &start, watch)?;
        self.totals.count(&solution.statistics, warm);
        Ok(solution)
    }

    fn remember(
        &mut self,
        solution: Solution,
        solved: bool,
        warm: bool,
        retried: Option<Retried>,
    ) -> Run {
        self.totals.problems += 1;
        if solved {
            self.x.clone_from(&solution.x);
            self.multipliers.clone_from(&solution.multipliers);
        } else {
            self.totals.failures += 1;
        }
        Run {
            solution,
            solved,
            warm,
            retried,
        }
    }
}
