//! Scenes at the limits, each with its truth and, where there is one, its benign twin: stiffness ratios, incompressibility,
//! units, gaps, thin and distorted meshes, bodies held by contact alone, rims, scenes without a solution.
//!
//! A truth is independent of the solver: an analytic value, a balance, a symmetry, a scaling. `make extremes` runs them all.

mod classes;
mod exchange;
mod judge;
mod stack;

pub use exchange::{Must, Reaction};
pub use judge::{Foreign, judged};

use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::{Certificate, Scene, Simulation};
use serde::{Deserialize, Serialize};

use crate::Failure;
use crate::cli::Solver;

/// A scene at a limit.
pub struct Case {
    /// Its unique name.
    pub name: String,
    /// The class of its difficulty.
    pub class: &'static str,
    /// The name of the same scene without the difficulty.
    pub twin: Option<String>,
    /// Whether it is part of the quick selection.
    pub quick: bool,
    /// Whether its meshes are fine: its solution takes seconds.
    pub fine: bool,
    /// The number of load increments.
    increments: usize,
    /// Only where it is an aim: the most factorisations of a solver that does without an interior point method.
    most_factorisations: Option<usize>,
    /// The laws of all bodies, where other programs are to know them.
    laws: Vec<exchange::Elastic>,
    dimension: Dimension,
}

enum Dimension {
    Plane(Setting<2>),
    Space(Setting<3>),
}

/// A scene and what its solution is.
struct Setting<const D: usize> {
    scene: Make<D>,
    truth: Truth<D>,
}

type Make<const D: usize> = Box<dyn Fn() -> Result<Scene<D>, Failure>>;
type Measure<const D: usize> = Box<dyn Fn(&Problem<D>, &History<D>) -> Vec<Check>>;

/// What is right.
enum Truth<const D: usize> {
    /// Forces of supports at full load.
    Reactions(Box<dyn Fn() -> Vec<Reaction>>),
    /// Values at full load.
    Values(Measure<D>),
    /// There is no solution, or none that the scene can have; the reason that is given contains one of these words.
    Refused(&'static [&'static str]),
}

/// A value of a solution and what it must be.
#[derive(Clone, Debug)]
pub struct Check {
    /// The value's name.
    pub what: &'static str,
    /// The value found.
    pub found: f64,
    /// The independent value.
    pub expected: f64,
    /// The largest difference that counts as right, in the units of the value.
    pub tolerance: f64,
}

impl Check {
    /// Whether the value is right.
    pub fn holds(&self) -> bool {
        (self.found - self.expected).abs() <= self.tolerance
    }

    /// A statement that must be true.
    fn that(what: &'static str, is_true: bool) -> Self {
        Check {
            what,
            found: f64::from(u8::from(is_true)),
            expected: 1.0,
            tolerance: 0.0,
        }
    }

    /// A value with a relative tolerance.
    fn relative(what: &'static str, found: f64, expected: f64, tolerance: f64) -> Self {
        Check {
            what,
            found,
            expected,
            tolerance: tolerance * expected.abs(),
        }
    }
}

impl<const D: usize> Truth<D> {
    /// Forces of supports, which are found when they are asked for.
    fn reactions(all: impl Fn() -> Vec<Reaction> + 'static) -> Self {
        Truth::Reactions(Box::new(all))
    }
}

/// How a case went.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// The case's name.
    pub name: String,
    /// Its class.
    pub class: String,
    /// `complete`, `not converged`, `interrupted`, `refused` by a check of the input, or `killed` after the time limit.
    pub outcome: String,
    /// Whether every certificate on the way holds.
    pub certificate: bool,
    /// Whether the result is right: the values of a complete run, or the refusal of a scene without a solution.
    pub truth_ok: bool,
    /// The reason that the library gives for not completing, and the values that are wrong.
    pub reason: String,
    /// Factorisations of the linear system.
    pub factorisations: usize,
    /// Iterations of the fixed point.
    pub iterations: usize,
    /// The forces of the supports on each body at full load (UF), of a complete run.
    #[serde(default)]
    pub reactions: Vec<Vec<f64>>,
    /// The name of the benign twin.
    pub twin: Option<String>,
    /// Wall time (s).
    pub seconds: f64,
}

impl Entry {
    /// Whether the library claims a wrong result to be right.
    pub fn is_a_false_claim(&self) -> bool {
        self.outcome == "complete" && self.certificate && !self.truth_ok
    }
}

/// All cases.
pub fn all() -> Vec<Case> {
    classes::all()
}

impl Case {
    fn plane(
        name: String,
        class: &'static str,
        scene: impl Fn() -> Result<Scene<2>, Failure> + 'static,
        truth: Truth<2>,
    ) -> Self {
        let scene = Box::new(scene);
        Case::new(name, class, Dimension::Plane(Setting { scene, truth }))
    }

    fn space(
        name: String,
        class: &'static str,
        scene: impl Fn() -> Result<Scene<3>, Failure> + 'static,
        truth: Truth<3>,
    ) -> Self {
        let scene = Box::new(scene);
        Case::new(name, class, Dimension::Space(Setting { scene, truth }))
    }

    fn new(name: String, class: &'static str, dimension: Dimension) -> Self {
        Case {
            name,
            class,
            twin: None,
            quick: false,
            fine: false,
            increments: 1,
            most_factorisations: None,
            laws: Vec::new(),
            dimension,
        }
    }

    fn twin(self, name: impl Into<String>) -> Self {
        let twin = Some(name.into()).filter(|twin| *twin != self.name);
        Case { twin, ..self }
    }

    fn quick(self) -> Self {
        Case {
            quick: true,
            ..self
        }
    }

    fn increments(self, increments: usize) -> Self {
        Case { increments, ..self }
    }

    /// Solves the scene and compares.
    pub fn run(&self, solver: Solver) -> Entry {
        let clock = std::time::Instant::now();
        let mut entry = Entry {
            name: self.name.clone(),
            class: self.class.to_string(),
            outcome: "refused".to_string(),
            certificate: false,
            truth_ok: false,
            reason: String::new(),
            factorisations: 0,
            iterations: 0,
            reactions: Vec::new(),
            twin: self.twin.clone(),
            seconds: 0.0,
        };
        let run = match &self.dimension {
            Dimension::Plane(setting) => setting.run(solver, self, &mut entry),
            Dimension::Space(setting) => setting.run(solver, self, &mut entry),
        };
        if let Err(error) = run {
            entry.reason = error.to_string();
        }
        entry.seconds = clock.elapsed().as_secs_f64();
        entry
    }
}

impl<const D: usize> Setting<D> {
    fn run(&self, solver: Solver, case: &Case, entry: &mut Entry) -> Result<(), Failure> {
        let refusals = match self.truth {
            Truth::Reactions(_) | Truth::Values(_) => &[][..],
            Truth::Refused(words) => words,
        };
        let names_it = |reason: &str| refusals.iter().any(|word| reason.contains(word));
        let mut problem = match (self.scene)()?.problem() {
            Ok(problem) => problem,
            Err(error) => {
                entry.reason = error.to_string();
                entry.truth_ok = names_it(&entry.reason);
                return Ok(());
            }
        };
        let solver = solver.with_tolerance(Some(1e-8));
        let mut simulation = Simulation::solved_by(solver, case.increments);
        let history = simulation.run(&mut problem)?;
        let certificate = history.certificate();
        let holds = |c: Certificate| c.holds(&Default::default());
        let cost = history.run.cost();
        entry.certificate = certificate.is_some_and(holds);
        entry.factorisations = cost.factorizations;
        entry.iterations = cost.outer_iterations;
        let ending = history.run.ending.to_string();
        if !history.is_complete() {
            entry.outcome = "not converged".to_string();
            entry.truth_ok = names_it(&ending);
            entry.reason = ending;
            return Ok(());
        }
        entry.outcome = ending;
        let forces = history.last().map(|step| &step.reactions);
        let forces = forces.into_iter().flatten();
        entry.reactions = forces.map(|force| force.as_slice().to_vec()).collect();
        let mut reasons = Vec::new();
        let mut checks = match &self.truth {
            Truth::Reactions(all) => all().iter().map(|r| r.check(&entry.reactions)).collect(),
            Truth::Values(measure) => measure(&problem, &history),
            Truth::Refused(_) => Vec::new(),
        };
        if let Some(most) = case.most_factorisations {
            let iterations = history.run.attempts.iter().flat_map(|a| &a.iterations);
            let is_direct = iterations.into_iter().all(|i| i.solver != "ipopt");
            let few = !is_direct || cost.factorizations <= most;
            checks.push(Check::that("as few factorisations as asked", few));
        }
        if !matches!(self.truth, Truth::Refused(_)) {
            entry.truth_ok = !checks.is_empty() && checks.iter().all(Check::holds);
            let wrong = checks.iter().filter(|check| !check.holds());
            reasons.extend(wrong.map(|check| {
                format!(
                    "{} is {:.4e} for {:.4e}",
                    check.what, check.found, check.expected
                )
            }));
        }
        if let Some(certificate) = certificate.filter(|c| !holds(*c)) {
            let entries = certificate.entries(&Default::default());
            let failed = entries.filter(|entry| !entry.holds());
            let failed = failed.map(|e| format!("{} {:.1e}", e.name, e.value.unwrap_or(f64::NAN)));
            let failed: Vec<String> = failed.collect();
            reasons.push(format!("certificate: {}", failed.join(", ")));
            // a scene without a solution that is not certified
            entry.truth_ok |= refusals.contains(&"certificate");
        }
        entry.reason = reasons.join("; ");
        Ok(())
    }
}
