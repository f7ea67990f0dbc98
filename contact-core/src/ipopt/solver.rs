//! The driver.

use std::{fmt, ops::ControlFlow, panic::resume_unwind, time::Instant};

use ipopt_sys as sys;

use super::{
    Error, Log, OptionValue, Options, Solution, Start, Status,
    callbacks::Usable,
    context::{Context, Gate, Watch},
    derivatives::Reader,
    fixed, library,
    lock::{Exclusive, Refused},
    log::Sink,
    options,
    scaling::{USER_SCALING, scaling_is_used},
    shim::Shim,
    start::{Point, are_finite},
    verify,
};
use crate::nlp::{Bounds, Iterate, Nlp, Phase, Structure};

/// Ipopt for one [`Structure`] and any number of solves.
///
/// It may move between threads. The solves of a process run one after the other; nothing else waits for them. Between
/// solves it keeps the pattern and the options, but not the memory of the linear solver.
pub struct Solver {
    pub(super) shim: Shim,
    pub(super) structure: Structure,
    /// What the caller set.
    pub(super) options: Options,
    log: Log,
    /// How large values may be under the [`Scaling`](super::Scaling) that the shim has, if it has one.
    pub(super) scaled: Option<Usable>,
}

impl Solver {
    /// A solver for problems of this structure.
    ///
    /// # Errors
    /// [`Error::Option`] names the option Ipopt refuses.
    pub fn new(structure: Structure, options: &Options) -> Result<Self, Error> {
        let mut solver = Self {
            shim: Shim::new(&structure).ok_or(Error::OutOfMemory)?,
            structure,
            options: Options::new(),
            log: Log::default(),
            scaled: None,
        };
        solver.copy_bounds();
        solver.set_options(options)?;
        Ok(solver)
    }

    /// The structure of the problem.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// Replaces all options.
    ///
    /// # Errors
    /// [`Error::Option`] names the option Ipopt refuses. [`Error::UnusedScaling`] if the solver has a
    /// [`Scaling`](super::Scaling) and `nlp_scaling_method` is set to something else. The options then stay as they
    /// were.
    pub fn set_options(&mut self, options: &Options) -> Result<(), Error> {
        if self.scaled.is_some() {
            scaling_is_used(options)?;
        }
        if let Err(error) = self.apply(options) {
            self.apply(&self.options.clone())?;
            return Err(error);
        }
        self.options = options.clone();
        Ok(())
    }

    fn apply(&mut self, options: &Options) -> Result<(), Error> {
        // SAFETY: the shim is valid.
        unsafe { options::apply(self.shim.as_ptr(), &self.structure, options) }?;
        if self.scaled.is_some() {
            self.apply_one("nlp_scaling_method", &USER_SCALING.into())?;
        }
        Ok(())
    }

    /// Sets the target of Ipopt's log from the next solve on; the default is [`Log::Crate`].
    ///
    /// ```
    /// # use contact_core::ipopt::{Log, Options, Solver};
    /// # use contact_core::nlp::{Bounds, Pattern, Structure};
    /// # let structure = Structure::new(Bounds::free(1), Bounds::default(), Pattern::empty(), None)?;
    /// let mut solver = Solver::new(structure, &Options::new())?;
    /// solver.set_log(Log::writer(std::io::stderr()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_log(&mut self, log: Log) {
        self.log = log;
    }

    pub(super) fn take_log(&mut self) -> Log {
        std::mem::take(&mut self.log)
    }

    /// Ipopt's own default of an option; `None` if this version has no such option. The driver's defaults are listed
    /// in [`Options`].
    pub fn ipopt_default(&self, name: &str) -> Option<OptionValue> {
        // SAFETY: the shim is valid.
        unsafe { options::default_of(self.shim.as_ptr(), name) }
    }

    /// The names of all options that this version of Ipopt has, in alphabetical order.
    pub fn ipopt_options(&self) -> Vec<String> {
        // SAFETY: the shim is valid.
        unsafe { options::names(self.shim.as_ptr()) }
    }

    /// Replaces the bounds.
    ///
    /// # Errors
    /// As [`Structure::new`]; the bounds then stay as they were.
    pub fn set_bounds(&mut self, variables: Bounds, constraints: Bounds) -> Result<(), Error> {
        self.structure.set_bounds(variables, constraints)?;
        self.copy_bounds();
        Ok(())
    }

    /// Solves `nlp` from `start`.
    ///
    /// Where all variables are fixed, or there are none, Ipopt is not asked: f and g are evaluated at the only point
    /// there is.
    ///
    /// # Errors
    /// Misuse: a start of the wrong size or with values that are not finite, a warm start without multipliers, or a solve
    /// inside a callback; and [`Error::Memory`] where the BLAS would wait for memory without end. The ending of the solve is [`Solution::status`].
    ///
    /// # Panics
    /// Resumes a panic of a callback after Ipopt has returned.
    pub fn solve(&mut self, nlp: &mut dyn Nlp, start: &Start<'_>) -> Result<Solution, Error> {
        self.run(nlp, start, None)
    }

    /// Solves `nlp` from `start` and shows every iterate to `watch`, after [`Nlp::iterate`]. Either may stop the solve
    /// with [`ControlFlow::Break`], which is [`Status::StoppedByUser`].
    ///
    /// # Errors
    /// As [`Solver::solve`].
    ///
    /// # Panics
    /// As [`Solver::solve`]; panics of `watch` count as those of a callback.
    pub fn solve_with(
        &mut self,
        nlp: &mut dyn Nlp,
        start: &Start<'_>,
        mut watch: impl FnMut(&Iterate<'_>) -> ControlFlow<()>,
    ) -> Result<Solution, Error> {
        self.run(nlp, start, Some(&mut watch))
    }

    fn run(
        &mut self,
        nlp: &mut dyn Nlp,
        start: &Start<'_>,
        watch: Option<Watch<'_>>,
    ) -> Result<Solution, Error> {
        let mut point = Point::new(&self.structure, start)?;
        let exclusive = match Exclusive::wait(|| nlp.is_to_stop()) {
            Ok(exclusive) => exclusive,
            Err(Refused::Held) => return Err(Error::Reentrant),
            Err(Refused::Stopped) => return Ok(Solution::not_begun(point)),
        };
        self.prepare_warm_start(start)?;
        self.prepare_order()?;
        self.prepare_log()?;
        nlp.begin(start.x);
        if fixed::are_all_fixed(&self.structure) {
            if nlp.is_to_stop() {
                return Ok(Solution::not_begun(point));
            }
            let allowed = self.number("tol").min(self.number("constr_viol_tol"));
            return Ok(fixed::solution(nlp, &self.structure, allowed));
        }

        library::prepare_blas()?;
        let shim = self.shim.as_ptr();
        let sink = Sink::new(&mut self.log);
        let tested = self.options.get("derivative_test");
        let reader = tested
            .filter(|&test| *test != "none".into())
            .map(|_| Reader::default());
        let watch = watch.map(|watch| watch as Watch<'_>);
        let mut context = Context::new(nlp, &self.structure, shim, watch, sink, reader);
        context.usable = self.scaled.unwrap_or_default();
        let mut gate = Gate::new(context);
        let mut raw_point = point.raw(start.multipliers.is_some());
        let mut raw_statistics = sys::ipopt_shim_statistics::default();
        let clock = Instant::now();
        let table = gate.table();
        // SAFETY: the shim is valid and Ipopt locked; table, point and statistics outlive the call; the callbacks
        // reach nothing but the gate, and that is not touched meanwhile.
        let code =
            unsafe { sys::ipopt_shim_solve(shim, &table, &mut raw_point, &mut raw_statistics) };
        let wall = clock.elapsed();
        let mut context = gate.into_context();
        context.finish_log();
        library::warn_of_another();
        let Context {
            panic,
            history,
            mut statistics,
            log,
            derivatives,
            ..
        } = context;
        let log_error = log.error;
        if let Some(payload) = panic {
            resume_unwind(payload);
        }

        statistics.read(
            &raw_statistics,
            history.last().map_or(0, |last| last.iteration),
            wall,
        );
        let (finalized, objective) = (raw_point.finalized != 0, raw_point.objective);
        let status = Status::from_code(code);
        let regular = history
            .last()
            .is_some_and(|last| last.phase == Phase::Regular);
        let mut solution = Solution {
            status,
            x: point.x,
            objective: if finalized { objective } else { f64::NAN },
            g: point.g,
            multipliers: (finalized && regular && status.keeps_multipliers())
                .then_some(point.multipliers)
                .filter(are_finite),
            contradiction: None,
            statistics,
            history,
            derivative_check: derivatives.map(Reader::finish),
            log_error,
        };
        if status.is_acceptable() {
            solution.contradiction = verify::contradiction(self, nlp, &mut solution);
            if solution.contradiction.is_some() {
                solution.status = Status::Contradicted;
                solution.multipliers = None;
            }
        }
        drop(exclusive);
        Ok(solution)
    }

    pub(super) fn apply_one(&mut self, name: &str, value: &OptionValue) -> Result<(), Error> {
        // SAFETY: the shim is valid.
        Ok(unsafe { options::apply_one(self.shim.as_ptr(), name, value) }?)
    }

    /// The value of an option that is a number, set or Ipopt's own; NaN if there is no such number.
    pub(super) fn number(&self, name: &str) -> f64 {
        let default = || self.ipopt_default(name);
        match self.options.get(name).cloned().or_else(default) {
            Some(OptionValue::Number(value)) => value,
            Some(OptionValue::Integer(value)) => value.into(),
            Some(OptionValue::Text(_)) | None => f64::NAN,
        }
    }

    /// The factor by which bounds are relaxed, relative to their size: the driver's default is 0.
    pub(super) fn bound_relaxation(&self) -> f64 {
        match self.options.get("bound_relax_factor") {
            Some(_) => self.number("bound_relax_factor"),
            None => 0.0,
        }
    }

    /// A writer gets one line per iteration, unless `print_level` is set.
    fn prepare_log(&mut self) -> Result<(), Error> {
        if self.options.get("print_level").is_some() {
            return Ok(());
        }
        let level = if matches!(self.log, Log::Writer(_)) {
            5
        } else {
            0
        };
        self.apply_one("print_level", &level.into())
    }

    /// Bounds may have fixed other variables since the last solve.
    fn prepare_order(&mut self) -> Result<(), Error> {
        for (name, order) in options::orders(&self.structure, &self.options) {
            self.apply_one(name, &order)?;
        }
        Ok(())
    }

    fn prepare_warm_start(&mut self, start: &Start<'_>) -> Result<(), Error> {
        let warm = match self.options.get("warm_start_init_point") {
            Some(OptionValue::Text(text)) if text == "yes" && start.multipliers.is_none() => {
                return Err(Error::MissingMultipliers);
            }
            Some(value) => value.clone(),
            None => start.multipliers.is_some().into(),
        };
        self.apply_one("warm_start_init_point", &warm)
    }

    fn copy_bounds(&mut self) {
        let (x, g) = (
            self.structure.variable_bounds(),
            self.structure.constraint_bounds(),
        );
        // SAFETY: the shim is valid, and the bounds have n and m values.
        unsafe {
            sys::ipopt_shim_set_bounds(
                self.shim.as_ptr(),
                x.lower.as_ptr(),
                x.upper.as_ptr(),
                g.lower.as_ptr(),
                g.upper.as_ptr(),
            );
        }
    }
}

impl fmt::Debug for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Solver")
            .field("structure", &self.structure)
            .finish_non_exhaustive()
    }
}
