//! The run of a scene file: its solver and its load steps.

use std::hash::{DefaultHasher, Hasher};
use std::path::PathBuf;
use std::{fmt, fs};

use contact_core::equilibrium::{Departures, Resumable};
use contact_core::ipopt::{self, Options};
use contact_core::nlp::{Bounds, Pattern, Structure};
use contact_core::{
    Acceleration, Automatic, Condensed, CondensedNewton, Continuation, Equilibrium, InteriorPoint,
    Literal, LoadStepped, Method, PenalizedSlack, Penalty, Retry,
};
use contact_fem::Simulation;
use contact_fem::model::Problem;
use serde::Deserialize;

use super::keys::{Combine, Formulation, Keys, OptionKeys, OutputKeys};
use super::meshes::MeshKeys;
use super::{Error, SceneFile, hints};

/// How a load is solved.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Solver {
    /// The one that fits the scene, see [`Automatic`].
    Automatic,
    /// Algorithm 2 of the paper around Ipopt, accelerated, see [`Retry`].
    Ipopt,
    /// See [`CondensedNewton`].
    Newton,
    /// See [`Condensed`].
    Condensed,
    /// Algorithm 2 as a straightforward script has it, see [`Literal`].
    Literal,
}

/// As in a file.
impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Solver::Automatic => "automatic",
            Solver::Ipopt => "ipopt",
            Solver::Newton => "newton",
            Solver::Condensed => "condensed",
            Solver::Literal => "literal",
        })
    }
}

/// What the library does and [`Literal`] does not.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Departure {
    /// See [`Departures::acceleration`].
    Acceleration,
    /// See [`Departures::warm_starts`].
    WarmStarts,
    /// See [`Departures::units`].
    Units,
    /// See [`Departures::guard`].
    Guard,
    /// See [`Departures::lift`].
    Lift,
    /// Load steps start from the extrapolation of the last two, see
    /// [`LoadSteps::predictor`](contact_core::LoadSteps::predictor).
    Predictor,
}

/// As in a file.
impl fmt::Display for Departure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Departure::Acceleration => "acceleration",
            Departure::WarmStarts => "warm-starts",
            Departure::Units => "units",
            Departure::Guard => "guard",
            Departure::Lift => "lift",
            Departure::Predictor => "predictor",
        })
    }
}

/// Solvers with the same settings.
struct Solvers {
    make: Box<dyn Fn() -> Box<dyn Equilibrium>>,
    settings: String,
}

impl Solvers {
    fn of<E: Equilibrium + Clone + fmt::Debug + 'static>(solver: E) -> Self {
        Solvers {
            settings: format!("{solver:?}"),
            make: Box::new(move || Box::new(solver.clone())),
        }
    }
}

impl SceneFile {
    /// The run: increments, solver, tolerance.
    ///
    /// # Errors
    /// A tolerance for a solver that has none, keys of one solver for another one, options that Ipopt does not have, increments
    /// out of range.
    pub fn simulation(&self) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        self.simulation_by(self.keys.solver.unwrap_or(Solver::Automatic))
    }

    /// As [`SceneFile::simulation`], with this solver.
    ///
    /// # Errors
    /// As [`SceneFile::simulation`].
    pub fn simulation_by(&self, solver: Solver) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        let solvers = self.solvers(solver)?;
        self.run_by(solver, (solvers.make)())
    }

    /// As [`SceneFile::simulation_by`], with answers kept in a file: the run goes on where an earlier one with this file ended, see
    /// [`Resumable`]. It is refused where the scene, its files or its steps are others than those of the earlier run, or `given`, what else
    /// answers depend on, such as the options of a program.
    ///
    /// # Errors
    /// As [`SceneFile::simulation`], and a file of the scene that cannot be read.
    pub fn resumable(
        &self,
        solver: Option<Solver>,
        file: impl Into<PathBuf>,
        given: &str,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        let solver = solver.or(self.keys.solver).unwrap_or(Solver::Automatic);
        let Solvers { make, settings } = self.solvers(solver)?;
        let scene = Keys {
            output: OutputKeys::default(),
            ..self.keys.clone()
        };
        let mut hasher = DefaultHasher::new();
        for path in self.files() {
            let read = fs::read(&path).map_err(|source| Error::Read { path, source })?;
            hasher.write(&read);
        }
        let files = hasher.finish();
        let settings = format!("{settings} {scene:?} {files:x} {given}");
        let kept = Resumable::new(file, make).with_settings(settings);
        self.run_by(solver, Box::new(kept))
    }

    /// The files with meshes and surfaces.
    fn files(&self) -> Vec<PathBuf> {
        let meshes = self.keys.body.iter().map(|body| &body.mesh);
        let surfaces = self.keys.obstacle.iter();
        let surfaces = surfaces.filter_map(|keys| keys.surface.as_ref());
        let files = meshes.chain(surfaces).filter_map(MeshKeys::file);
        files.map(|path| self.folder.join(path)).collect()
    }

    /// What a run refuses before its first solve, with its place in the file; `simulation` is one of this file.
    ///
    /// # Errors
    /// A problem that the solver does not treat, supports and contacts that change within a phase, a phase in which something is loose, too
    /// little memory, values that overflow.
    pub fn check<const D: usize>(
        &self,
        simulation: &Simulation<Box<dyn Equilibrium>>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        let steps = &simulation.load_steps;
        let checked = steps.check(problem, &*simulation.solver);
        checked.map_err(|why| self.refused(why.into()))?;
        // loads and displacements where phases end, and at the first increment
        let first = match steps.phases.first() {
            Some(phase) => phase.until / phase.increments as f64,
            None => 1.0 / steps.increments as f64,
        };
        let ends = steps.phases.iter().map(|phase| phase.until);
        let times = ends.chain([steps.end(), first, 0.0]);
        let mut times = times.map(|time| problem.set_load(time));
        let loaded = times.try_for_each(|loaded| loaded);
        loaded.map_err(|why| self.refused(why.into()))
    }

    /// Refuses keys of one solver where another solves.
    fn check_keys(&self, solver: Solver) -> Result<(), Error> {
        let keys = &self.keys;
        let told = |value: Option<f64>| value.map(|value| value.to_string());
        let literal = [
            ("goes-on", keys.goes_on.map(|value| value.to_string())),
            (
                "max-iterations",
                keys.max_iterations.map(|value| value.to_string()),
            ),
            ("ipopt-tolerance", told(keys.ipopt_tolerance)),
        ];
        let of_ipopt = [
            ("method", keys.method.map(|method| method.to_string())),
            ("complementarity", told(keys.complementarity)),
            ("penetration", told(keys.penetration)),
            (
                "acceleration",
                keys.acceleration.map(|value| value.to_string()),
            ),
            ("depth", keys.depth.map(|depth| depth.to_string())),
            ("ipopt", keys.ipopt.keys().next().cloned()),
        ];
        let literal = literal
            .into_iter()
            .map(|(key, value)| (key, value, Solver::Literal));
        let of_ipopt = of_ipopt
            .into_iter()
            .map(|(key, value)| (key, value, Solver::Ipopt));
        for (key, value, needed) in literal.chain(of_ipopt) {
            if let (Some(value), true) = (value, solver != needed) {
                return Err(self.place().key(key).wrong(format!(
                    "`{key} = {value}` has no effect with the solver {solver}: leave it out, or take {needed}"
                )));
            }
        }
        if let (Some(leaps @ 1..), Solver::Literal) = (keys.max_leaps, solver) {
            return Err(self.place().key("max-leaps").wrong(format!(
                "`max-leaps = {leaps}` has no effect with the solver literal, which goes from increment to increment: leave it out"
            )));
        }
        let departures = self.keys.departures.as_deref().unwrap_or_default();
        if let (Some(first), true) = (departures.first(), solver != Solver::Literal) {
            return Err(self.place().key("departures").wrong(format!(
                "the departure {first} has no effect with the solver {solver}: leave `departures` out, or take literal"
            )));
        }
        Ok(())
    }

    /// The solvers that the keys ask for.
    fn solvers(&self, solver: Solver) -> Result<Solvers, Error> {
        self.check_keys(solver)?;
        let tolerance = self.keys.tolerance;
        Ok(match solver {
            Solver::Automatic => {
                Solvers::of(tolerance.map_or_else(Automatic::default, Automatic::with_tolerance))
            }
            Solver::Newton => Solvers::of(
                tolerance.map_or_else(CondensedNewton::default, CondensedNewton::with_tolerance),
            ),
            Solver::Ipopt => return self.by_ipopt(),
            Solver::Literal => Solvers::of(self.by_literal()),
            Solver::Condensed => match tolerance {
                None => Solvers::of(Condensed::new()),
                Some(tolerance) => {
                    return Err(self.place().key("tolerance").wrong(format!(
                        "`tolerance = {tolerance}` has no effect with the solver condensed, which is exact to round-off: \
                         leave it out"
                    )));
                }
            },
        })
    }

    fn by_literal(&self) -> Literal {
        let mut literal = Literal::default();
        literal.tolerance = self.keys.tolerance.unwrap_or(literal.tolerance);
        literal.goes_on = self.keys.goes_on.unwrap_or(literal.goes_on);
        literal.max_iterations = self.keys.max_iterations.unwrap_or(literal.max_iterations);
        literal.ipopt_tolerance = self.keys.ipopt_tolerance.unwrap_or(literal.ipopt_tolerance);
        let departures = self.keys.departures.as_deref().unwrap_or_default();
        let has = |departure| departures.contains(&departure);
        literal.departures = Departures {
            acceleration: has(Departure::Acceleration),
            warm_starts: has(Departure::WarmStarts),
            units: has(Departure::Units),
            guard: has(Departure::Guard),
            lift: has(Departure::Lift),
        };
        literal
    }

    /// The fixed point by one of the paper's formulations.
    fn by_ipopt(&self) -> Result<Solvers, Error> {
        let options = self.ipopt_options()?;
        let only = |key: &'static str, value: Option<f64>, of: &str| match value {
            None => Ok(()),
            Some(value) => Err(self.place().key(key).wrong(format!(
                "`{key} = {value}` is of the method {of}: leave it out"
            ))),
        };
        let mut continuation = Continuation::default();
        continuation.penetration = self.keys.penetration.unwrap_or(continuation.penetration);
        match self.keys.method {
            None | Some(Formulation::InteriorPoint) => {
                only(
                    "penetration",
                    self.keys.penetration,
                    "penalized-slack or penalty",
                )?;
                let mut method = InteriorPoint::default();
                method.complementarity =
                    self.keys.complementarity.unwrap_or(method.complementarity);
                method.options = options;
                self.around(method)
            }
            Some(Formulation::PenalizedSlack) => {
                only(
                    "complementarity",
                    self.keys.complementarity,
                    "interior-point",
                )?;
                let mut method = PenalizedSlack::with(continuation);
                method.penalization.options = options;
                self.around(method)
            }
            Some(Formulation::Penalty) => {
                only(
                    "complementarity",
                    self.keys.complementarity,
                    "interior-point",
                )?;
                let mut method = Penalty::with(continuation);
                method.penalization.options = options;
                self.around(method)
            }
        }
    }

    /// The fixed point around a method, accelerated as the keys ask for.
    fn around<M: Method + Clone + fmt::Debug + 'static>(
        &self,
        method: M,
    ) -> Result<Solvers, Error> {
        let mut retry = Retry::with(method);
        let fixed_point = &mut retry.fixed_point;
        fixed_point.tolerance = self.keys.tolerance.unwrap_or(fixed_point.tolerance);
        match (self.keys.acceleration, self.keys.depth) {
            (Some(Combine::Plain), Some(depth)) => {
                return Err(self.place().key("depth").wrong(format!(
                    "`depth = {depth}` has no effect with the plain iteration: leave it out"
                )));
            }
            (Some(Combine::Plain), None) => fixed_point.acceleration = Acceleration::Plain,
            (_, Some(0)) => {
                return Err(self.place().key("depth").wrong(
                    "`depth = 0` keeps no difference: give 1 or more, or take `acceleration = \"plain\"`",
                ));
            }
            (_, Some(depth)) => fixed_point.acceleration = Acceleration::Anderson(depth),
            (_, None) => {}
        }
        Ok(Solvers::of(retry))
    }

    /// Ipopt's options. One that this Ipopt does not have is found here, before a file is written.
    fn ipopt_options(&self) -> Result<Options, Error> {
        let mut options = Options::new();
        for (name, value) in &self.keys.ipopt {
            match value {
                OptionKeys::Integer(value) => options.set(name, *value),
                OptionKeys::Number(value) => options.set(name, *value),
                OptionKeys::Text(value) => options.set(name, value.as_str()),
            };
        }
        let hessian = Some(Pattern::diagonal(1));
        let any = Structure::new(
            Bounds::free(1),
            Bounds::default(),
            Pattern::empty(),
            hessian,
        );
        let made = any.map_err(|why| why.to_string());
        let made = made.and_then(|any| {
            let solver = ipopt::Solver::new(any, &options);
            let solver = solver.and_then(|_| ipopt::doctor::check_linear_solver(&options));
            solver.map_err(|why| why.to_string())
        });
        made.map_err(|why| {
            let at = self.place().key("ipopt");
            // the option that it names
            let own = self.keys.ipopt.keys();
            let own = own.filter(|name| why.contains(&format!("`{name}`"))).max();
            let Some(name) = own else {
                return at.wrong(why);
            };
            let elsewhere = hints::elsewhere(&self.text, name, &["ipopt".into()]);
            at.key(name.clone()).wrong(match elsewhere {
                Some(hint) if why.contains("has no option") => format!("{why}\n{hint}"),
                _ => why,
            })
        })?;
        Ok(options)
    }

    /// The run by a solver that was made for it.
    fn run_by(
        &self,
        name: Solver,
        solver: Box<dyn Equilibrium>,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        let mut simulation = Simulation::solved_by(solver, self.keys.increments.unwrap_or(1));
        simulation.load_steps.phases = self.phases()?;
        if let Some(leaps) = self.keys.max_leaps {
            simulation.load_steps.max_leaps = leaps;
        }
        if name == Solver::Literal {
            let departures = self.keys.departures.as_deref().unwrap_or_default();
            simulation.load_steps.predictor = departures.contains(&Departure::Predictor);
            simulation.load_steps.max_halvings = 0;
            simulation.load_steps.max_leaps = 0;
        }
        let checked = simulation.solver.validate();
        let checked = checked.and_then(|()| simulation.load_steps.validate());
        checked.map_err(|why| self.refused(why.into()))?;
        Ok(simulation)
    }
}
