//! The options common to all examples.

use std::path::PathBuf;
use std::process::Command;

use clap::ValueEnum;
use contact_core::ipopt::{self, OptionValue};
use contact_core::nlp::{Bounds, Pattern, Structure};
use contact_core::{
    Acceleration, Automatic, Budget, Condensed, CondensedNewton, Equilibrium, InteriorPoint,
    Literal, Method, PenalizedSlack, Penalty, Retry,
};
use contact_fem::model::{Integration, Projection};
use contact_fem::output::record::Recording;
use contact_fem::{Scene, Simulation};

use crate::Failure;

/// The options of the solver and of the output.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Load increments; every example has its own default
    #[arg(long, value_parser = positive)]
    pub increments: Option<usize>,
    /// How a load increment is solved [default: ipopt with an option that only Ipopt has, else automatic]
    #[arg(long, value_enum)]
    pub solver: Option<Solver>,
    /// Solve as the paper's script does, step by step: with its points, plain, with a cold Ipopt in the user's units, and on from
    /// increments that do not converge in 30 iterations
    #[arg(long)]
    pub literal: bool,
    /// The integration points
    #[command(flatten)]
    pub points: Points,
    /// Relative change of the displacement at which an increment has converged, in (0, 1); `condensed` has none
    /// [default: 1e-6 for ipopt, else 1e-8]
    #[arg(long, value_parser = tolerance)]
    pub tolerance: Option<f64>,
    /// How Ipopt states every subproblem [default: interior-point]
    #[arg(long, value_enum)]
    pub method: Option<Formulation>,
    /// How Ipopt's fixed-point iterates are combined; the paper's way is plain [default: anderson]
    #[arg(long, value_enum)]
    pub acceleration: Option<Combine>,
    /// Number of earlier differences that Anderson acceleration uses [default: the library's]
    #[arg(long, value_parser = positive)]
    pub depth: Option<usize>,
    /// Seconds after which a run is stopped, with its converged increments kept [default: no limit]
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Factorisations after which a run is stopped likewise [default: no limit]
    #[arg(long, value_name = "N")]
    pub factorizations: Option<usize>,
    /// Megabytes that a run may take by its estimate; one that needs more is not begun [default: what the system leaves]
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub memory: Option<u64>,
    /// Interval of .vtu files in increments, 0 for none
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub vtu_every: usize,
    /// An option for Ipopt; may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = ipopt_option)]
    pub ipopt: Vec<(String, OptionValue)>,
    /// Folder for all files [default: out/ and the example's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print neither progress nor a report
    #[arg(long)]
    pub quiet: bool,
}

/// `--solver`
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// The one that fits the scene, see `contact_core::Automatic`
    #[default]
    Automatic,
    /// Algorithm 2 of the paper: a fixed point of subproblems that Ipopt solves, accelerated unless --acceleration is plain
    Ipopt,
    /// Newton's method, with contact condensed onto its rows
    Newton,
    /// One factorisation, for laws for small strains with contact in the reference geometry only
    Condensed,
}

impl Solver {
    /// The solver with its own tolerance, or with this one where it has one.
    pub fn with_tolerance(self, tolerance: Option<f64>) -> Box<dyn Equilibrium> {
        match self {
            Solver::Automatic => {
                Box::new(tolerance.map_or_else(Automatic::default, Automatic::with_tolerance))
            }
            Solver::Ipopt => Box::new(fixed_point(InteriorPoint::default(), tolerance)),
            Solver::Newton => Box::new(
                tolerance.map_or_else(CondensedNewton::default, CondensedNewton::with_tolerance),
            ),
            Solver::Condensed => Box::new(Condensed::new()),
        }
    }
}

impl std::fmt::Display for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// The paper's fixed point with its own tolerance, or with this one.
fn fixed_point<M: Method>(method: M, tolerance: Option<f64>) -> Retry<M> {
    let mut retry = Retry::with(method);
    if let Some(tolerance) = tolerance {
        retry.fixed_point.tolerance = tolerance;
    }
    retry
}

/// `--method`
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
pub enum Formulation {
    /// (7) of the paper: Ipopt's barrier on the gaps
    InteriorPoint,
    /// (37): slacks may be negative at a penalty
    PenalizedSlack,
    /// (39): a penalty on the gap at every integration point
    Penalty,
}

/// `--acceleration`
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
pub enum Combine {
    /// None, as in the paper
    Plain,
    /// Anderson acceleration, see --depth
    Anderson,
}

/// The options of the integration points.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Points {
    /// How rows are integrated: exactly, or at this number of Gauss points a facet and direction [default: the scene's]
    #[arg(long, value_name = "exact|N", value_parser = integration)]
    pub integration: Option<Integration>,
    /// Where points have their feet; the paper's are the closest points [default: the scene's, or closest with --literal]
    #[arg(long, value_enum)]
    pub projection: Option<Feet>,
}

impl Points {
    /// The scene with these points.
    pub fn of<const D: usize>(&self, mut scene: Scene<D>) -> Scene<D> {
        scene.integration = self.integration.or(scene.integration);
        match self.projection {
            Some(Feet::AlongNormals) => scene.projection = Projection::AlongNormals,
            Some(Feet::Closest) => scene.projection = Projection::Closest,
            None => {}
        }
        scene
    }
}

/// `--projection`
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feet {
    /// Where the averaged normals pass through the points
    AlongNormals,
    /// At the closest points, as in the paper
    Closest,
}

/// `--integration`
fn integration(text: &str) -> Result<Integration, String> {
    if text == "exact" {
        return Ok(Integration::Exact);
    }
    match text.parse() {
        Ok(points @ 1..=64) => Ok(Integration::Gauss(points)),
        _ => Err("`exact`, or Gauss points from 1 to 64, are needed".into()),
    }
}

impl Options {
    /// The scene with the points of the options.
    pub fn scene<const D: usize>(&self, mut scene: Scene<D>) -> Scene<D> {
        if self.literal {
            scene.points_as_in_the_paper();
        }
        self.points.of(scene)
    }

    /// The load steps and the solver of the options; `increments` is the example's
    /// default number. An option that Ipopt does not have is detected here, before any file is
    /// written.
    pub fn simulation(
        &self,
        increments: usize,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Failure> {
        let increments = self.increments.unwrap_or(increments);
        if self.literal {
            return self.literal(increments);
        }
        let solver = match self.solver()? {
            Solver::Ipopt => {
                let mut retry = fixed_point(self.method()?, self.tolerance);
                let depth = self.depth.unwrap_or_else(default_depth);
                retry.fixed_point.acceleration = match self.acceleration {
                    Some(Combine::Plain) => Acceleration::Plain,
                    Some(Combine::Anderson) | None => Acceleration::Anderson(depth),
                };
                Box::new(retry)
            }
            other => other.with_tolerance(self.tolerance),
        };
        let mut simulation = Simulation::solved_by(solver, increments);
        simulation.load_steps.budget = self.budget();
        Ok(simulation)
    }

    /// The load steps of [`Literal`], which has none of the settings of other solvers but a tolerance.
    fn literal(&self, increments: usize) -> Result<Simulation<Box<dyn Equilibrium>>, Failure> {
        let settings = [
            ("--solver", self.solver.is_some()),
            ("--method", self.method.is_some()),
            ("--acceleration", self.acceleration.is_some()),
            ("--depth", self.depth.is_some()),
            ("--ipopt", !self.ipopt.is_empty()),
        ];
        if let Some((option, _)) = settings.iter().find(|(_, is_given)| *is_given) {
            return Err(
                format!("{option} has no effect with --literal: leave one of them out").into(),
            );
        }
        let own = Literal::default();
        let solver = Literal {
            tolerance: self.tolerance.unwrap_or(own.tolerance),
            goes_on: true,
            ..own
        };
        let solver: Box<dyn Equilibrium> = Box::new(solver);
        let mut simulation = Simulation::solved_by(solver, increments);
        simulation.load_steps.predictor = false;
        simulation.load_steps.max_halvings = 0;
        simulation.load_steps.max_leaps = 0;
        simulation.load_steps.budget = self.budget();
        Ok(simulation)
    }

    fn budget(&self) -> Budget {
        Budget {
            seconds: self.seconds,
            factorizations: self.factorizations,
            memory: self.memory.map(|megabytes| megabytes * 1_000_000),
        }
    }

    /// The chosen solver: the one given, else Ipopt if an option is given that only Ipopt has.
    fn solver(&self) -> Result<Solver, Failure> {
        let is_plain = matches!(self.acceleration, Some(Combine::Plain));
        if let (true, Some(depth)) = (is_plain, self.depth) {
            let text =
                format!("--depth {depth} has no effect with --acceleration plain: leave it out");
            return Err(text.into());
        }
        if let (Some(Solver::Condensed), Some(tolerance)) = (self.solver, self.tolerance) {
            return Err(format!(
                "--tolerance {tolerance} has no effect with --solver condensed, which is exact to round-off: leave it out"
            )
            .into());
        }
        let given = [
            ("--method", self.method.is_some()),
            ("--acceleration", self.acceleration.is_some()),
            ("--depth", self.depth.is_some()),
            ("--ipopt", !self.ipopt.is_empty()),
        ];
        let only = given.iter().find(|(_, is_given)| *is_given);
        match (self.solver, only) {
            (None | Some(Solver::Ipopt), Some(_)) => Ok(Solver::Ipopt),
            (Some(other), Some((option, _))) => Err(format!(
                "{option} has no effect with --solver {other}: take --solver ipopt, or leave {option} out"
            )
            .into()),
            (solver, None) => Ok(solver.unwrap_or_default()),
        }
    }

    /// The recording of an example called `name`.
    pub fn record<'a, const D: usize, S: Equilibrium>(
        &self,
        simulation: &'a mut Simulation<S>,
        name: &str,
    ) -> Recording<'a, D, S> {
        let mut recording = simulation.record(self.folder(name));
        let plan = &mut recording.plan;
        plan.name = name.into();
        plan.vtu_every = self.vtu_every;
        plan.quiet = self.quiet;
        recording
    }

    /// Ipopt with the chosen options.
    fn method(&self) -> Result<Box<dyn Method>, Failure> {
        let mut options = ipopt::Options::new();
        for (name, value) in &self.ipopt {
            options.set(name, value.clone());
        }
        let any = Structure::new(
            Bounds::free(1),
            Bounds::default(),
            Pattern::empty(),
            Some(Pattern::diagonal(1)),
        )?;
        ipopt::Solver::new(any, &options)?;
        Ok(match self.method.unwrap_or(Formulation::InteriorPoint) {
            Formulation::InteriorPoint => Box::new(InteriorPoint {
                options,
                ..InteriorPoint::default()
            }),
            Formulation::PenalizedSlack => {
                let mut method = PenalizedSlack::default();
                method.penalization.options = options;
                Box::new(method)
            }
            Formulation::Penalty => {
                let mut method = Penalty::default();
                method.penalization.options = options;
                Box::new(method)
            }
        })
    }

    /// The folder for all files of an example called `name`.
    pub fn folder(&self, name: &str) -> PathBuf {
        let default = || PathBuf::from("out").join(name);
        self.out.clone().unwrap_or_else(default)
    }
}

/// Runs this program again with its arguments and the given ones, in a separate process, whose peak
/// memory is then its own.
///
/// # Errors
/// If the process does not end with exit code 0.
pub fn again(arguments: &[&str]) -> Result<(), Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    let status = command
        .args(std::env::args_os().skip(1))
        .args(arguments)
        .status()?;
    match status.success() {
        true => Ok(()),
        false => Err(format!("the run with {} failed", arguments.join(" ")).into()),
    }
}

/// The default of the library's fixed-point iteration.
fn default_depth() -> usize {
    match Acceleration::default() {
        Acceleration::Anderson(depth) => depth,
        Acceleration::Plain => 0,
    }
}

/// Parses a whole number from 1.
pub fn positive(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err("a whole number from 1 is needed".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if f64::is_finite(number) && number >= 0.0 => Ok(number),
        _ => Err("a number of seconds from 0 is needed".into()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        _ => Err("a number between 0 and 1 is needed".into()),
    }
}

/// Parses `NAME=VALUE` and guesses the type of the value; Ipopt accepts whole numbers for reals.
fn ipopt_option(text: &str) -> Result<(String, OptionValue), String> {
    let (name, value) = text
        .split_once('=')
        .filter(|(name, value)| !name.is_empty() && !value.is_empty())
        .ok_or("NAME=VALUE is needed, such as max_iter=500")?;
    let whole = value.parse::<i32>().map(OptionValue::from);
    let value = whole
        .or_else(|_| value.parse::<f64>().map(OptionValue::from))
        .unwrap_or_else(|_| OptionValue::from(value));
    Ok((name.to_string(), value))
}
