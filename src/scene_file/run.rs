//! The run of a scene file: its solver and its load steps.

use std::fmt;
use std::path::PathBuf;

use contact_core::equilibrium::{Departures, Resumable};
use contact_core::{
    Automatic, Condensed, CondensedNewton, Equilibrium, InteriorPoint, Literal, Retry,
};
use contact_fem::Simulation;
use serde::Deserialize;

use super::{Error, SceneFile};

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
    /// A tolerance for a solver that has none, keys of [`Solver::Literal`] for another one, increments out of range.
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
    /// [`Resumable`].
    ///
    /// # Errors
    /// As [`SceneFile::simulation`].
    pub fn resumable(
        &self,
        solver: Option<Solver>,
        file: impl Into<PathBuf>,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        let solver = solver.or(self.keys.solver).unwrap_or(Solver::Automatic);
        let Solvers { make, settings } = self.solvers(solver)?;
        let kept = Resumable::new(file, make).with_settings(settings);
        self.run_by(solver, Box::new(kept))
    }

    /// The solvers that the keys ask for.
    fn solvers(&self, solver: Solver) -> Result<Solvers, Error> {
        let tolerance = self.keys.tolerance;
        let only_literal = [
            self.keys.goes_on.map(|value| format!("goes-on = {value}")),
            self.keys
                .max_iterations
                .map(|value| format!("max-iterations = {value}")),
            self.keys
                .ipopt_tolerance
                .map(|value| format!("ipopt-tolerance = {value}")),
        ];
        if let (Some(key), true) = (
            only_literal.iter().flatten().next(),
            solver != Solver::Literal,
        ) {
            return Err(Error::Part {
                part: "the scene".into(),
                what: format!(
                    "`{key}` has no effect with the solver {solver}: leave it out, or take literal"
                ),
            });
        }
        let departures = self.keys.departures.as_deref().unwrap_or_default();
        if let (Some(first), true) = (departures.first(), solver != Solver::Literal) {
            return Err(Error::Part {
                part: "the scene".into(),
                what: format!(
                    "the departure {first:?} has no effect with the solver {solver}: leave `departures` out, or take literal"
                ),
            });
        }
        Ok(match solver {
            Solver::Automatic => {
                Solvers::of(tolerance.map_or_else(Automatic::default, Automatic::with_tolerance))
            }
            Solver::Newton => Solvers::of(
                tolerance.map_or_else(CondensedNewton::default, CondensedNewton::with_tolerance),
            ),
            Solver::Ipopt => {
                let mut retry = Retry::<InteriorPoint>::default();
                let own = retry.fixed_point.tolerance;
                retry.fixed_point.tolerance = tolerance.unwrap_or(own);
                Solvers::of(retry)
            }
            Solver::Literal => {
                let mut literal = Literal::default();
                literal.tolerance = tolerance.unwrap_or(literal.tolerance);
                literal.goes_on = self.keys.goes_on.unwrap_or(literal.goes_on);
                literal.max_iterations = self.keys.max_iterations.unwrap_or(literal.max_iterations);
                literal.ipopt_tolerance =
                    self.keys.ipopt_tolerance.unwrap_or(literal.ipopt_tolerance);
                let has = |departure| departures.contains(&departure);
                literal.departures = Departures {
                    acceleration: has(Departure::Acceleration),
                    warm_starts: has(Departure::WarmStarts),
                    units: has(Departure::Units),
                    guard: has(Departure::Guard),
                    lift: has(Departure::Lift),
                };
                Solvers::of(literal)
            }
            Solver::Condensed => match tolerance {
                None => Solvers::of(Condensed::new()),
                Some(tolerance) => {
                    return Err(Error::Part {
                        part: "the scene".into(),
                        what: format!(
                            "`tolerance = {tolerance}` has no effect with the solver condensed, which is exact to round-off: leave it out"
                        ),
                    });
                }
            },
        })
    }

    /// The run by a solver that was made for it.
    fn run_by(
        &self,
        name: Solver,
        solver: Box<dyn Equilibrium>,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Error> {
        let mut simulation = Simulation::solved_by(solver, self.keys.increments.unwrap_or(1));
        simulation.load_steps.phases = self.phases()?;
        if name == Solver::Literal {
            let departures = self.keys.departures.as_deref().unwrap_or_default();
            simulation.load_steps.predictor = departures.contains(&Departure::Predictor);
            simulation.load_steps.max_halvings = 0;
        }
        let checked = simulation.solver.validate();
        checked
            .and_then(|()| simulation.load_steps.validate())
            .map_err(|why| Error::Part {
                part: "the scene".into(),
                what: why.to_string(),
            })?;
        Ok(simulation)
    }
}
