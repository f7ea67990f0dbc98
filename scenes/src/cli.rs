//! The options common to all examples.

use std::path::PathBuf;
use std::process::Command;

use contact_core::ipopt::{self, OptionValue};
use contact_core::nlp::{Bounds, Pattern, Structure};
use contact_core::{
    Acceleration, Condensed, CondensedNewton, Equilibrium, FixedPoint, InteriorPoint, Method,
    PenalizedSlack, Penalty, Retry,
};
use contact_fem::Simulation;
use contact_fem::output::record::Recording;

use crate::Failure;

/// The options of the solver and of the output.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Load increments; every example has its own default
    #[arg(long, value_parser = positive)]
    pub increments: Option<usize>,
    /// How a load increment is solved
    #[arg(long, value_enum, default_value_t = Solver::Ipopt)]
    pub solver: Solver,
    /// Relative change of the displacement at which an increment has converged, in (0, 1)
    #[arg(long, default_value_t = FixedPoint::<InteriorPoint>::default().tolerance, value_parser = tolerance)]
    pub tolerance: f64,
    /// How Ipopt states every subproblem
    #[arg(long, value_enum, default_value_t = Formulation::InteriorPoint)]
    pub method: Formulation,
    /// How fixed-point iterates are combined
    #[arg(long, value_enum, default_value_t = Combine::Anderson)]
    pub acceleration: Combine,
    /// Number of earlier differences that Anderson acceleration uses
    #[arg(long, default_value_t = default_depth(), value_parser = positive)]
    pub depth: usize,
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
    /// Algorithm 2 of the paper: a fixed point of subproblems that Ipopt solves
    #[default]
    Ipopt,
    /// Newton's method, with contact condensed onto its rows
    Newton,
    /// One factorisation, for laws for small strains only
    Condensed,
}

impl Solver {
    /// The solver with this tolerance, where it has one.
    pub fn with_tolerance(self, tolerance: f64) -> Box<dyn Equilibrium> {
        match self {
            Solver::Ipopt => {
                let mut retry = Retry::<InteriorPoint>::default();
                retry.fixed_point.tolerance = tolerance;
                Box::new(retry)
            }
            Solver::Newton => Box::new(CondensedNewton::with_tolerance(tolerance)),
            Solver::Condensed => Box::new(Condensed::new()),
        }
    }
}

impl std::fmt::Display for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Solver::Ipopt => "ipopt",
            Solver::Newton => "newton",
            Solver::Condensed => "condensed",
        })
    }
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

impl Options {
    /// The load steps and the solver of the options; `increments` is the example's
    /// default number. An option that Ipopt does not have is detected here, before any file is
    /// written.
    pub fn simulation(
        &self,
        increments: usize,
    ) -> Result<Simulation<Box<dyn Equilibrium>>, Failure> {
        let increments = self.increments.unwrap_or(increments);
        let method = self.method()?;
        let solver: Box<dyn Equilibrium> = match self.solver {
            Solver::Ipopt => {
                let mut retry = Retry::with(method);
                retry.fixed_point.tolerance = self.tolerance;
                retry.fixed_point.acceleration = match self.acceleration {
                    Combine::Plain => Acceleration::Plain,
                    Combine::Anderson => Acceleration::Anderson(self.depth),
                };
                Box::new(retry)
            }
            other => other.with_tolerance(self.tolerance),
        };
        Ok(Simulation::solved_by(solver, increments))
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
        Ok(match self.method {
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
