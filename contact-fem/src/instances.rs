//! Instances of this crate's code for two and three dimensions.
//!
//! Rust compiles a generic function in the crate that fixes its parameters. A program with a `Scene<2>` would compile nearly all of this
//! crate again, by the settings of its own profile, and so would each of its tests and examples. The functions of an [`Instance`] are compiled here, once, for each
//! dimension. What programs call hands over to them. A program in the plane links nothing for space.

use std::any::Any;
use std::ops::ControlFlow;

use contact_core::Equilibrium;
use contact_core::equilibrium::Solution;
use contact_core::gaps::LinearGaps;
use contact_core::load_steps::LoadSteps;

use crate::certificate::Certificate;
use crate::error::Error;
use crate::model::{Answers, ErrorEstimate, PairState, Problem, Report, Scene};
#[cfg(feature = "record")]
use crate::output::record::{Plan, Recorded};
use crate::simulation::{self, History, StepView};

/// What is called after every converged step.
pub(crate) type Observe<'a, const D: usize> =
    &'a mut dyn FnMut(&StepView<'_, D>) -> ControlFlow<()>;

/// The code for one dimension.
pub(crate) trait Instance<const D: usize>: Sync {
    /// [`Scene::problem`].
    fn problem(&self, scene: Scene<D>) -> Result<Problem<D>, Error>;

    /// What [`Scene::preflight`] and [`Scene::errors`] tell.
    fn report(&self, scene: &Scene<D>) -> Report;

    /// What the problem answers to solvers.
    fn answers<'a>(&self, problem: &'a Problem<D>) -> &'a dyn Answers;

    /// The same, to change its load.
    fn answers_mut<'a>(&self, problem: &'a mut Problem<D>) -> &'a mut dyn Answers;

    /// [`Simulation::run_observed`](crate::Simulation::run_observed).
    fn run(
        &self,
        load_steps: &LoadSteps,
        solver: &mut dyn Equilibrium,
        problem: &mut Problem<D>,
        observe: Observe<'_, D>,
    ) -> Result<History<D>, Error>;

    /// [`Certificate::new`].
    fn certificate(&self, problem: &Problem<D>, solution: &Solution) -> Certificate;

    /// [`Problem::pair_states`].
    fn pair_states(
        &self,
        problem: &Problem<D>,
        u: &[f64],
        contact: (&LinearGaps, &[f64]),
    ) -> Result<Vec<PairState<D>>, Error>;

    /// [`Problem::error_estimate`].
    fn error_estimate(
        &self,
        problem: &Problem<D>,
        solution: &Solution,
    ) -> Result<ErrorEstimate<D>, Error>;

    /// [`Recording::run`](crate::output::record::Recording::run).
    #[cfg(feature = "record")]
    fn record(
        &self,
        plan: Plan<'_, D>,
        load_steps: &LoadSteps,
        solver: &mut dyn Equilibrium,
        problem: &mut Problem<D>,
    ) -> Result<Recorded<D>, Error>;
}

struct Compiled;

static PLANE: &dyn Instance<2> = &Compiled;
static SPACE: &dyn Instance<3> = &Compiled;

/// The code for `D` dimensions.
pub(crate) fn instance<const D: usize>() -> &'static dyn Instance<D> {
    let compiled: &dyn Any = match D {
        2 => &PLANE,
        3 => &SPACE,
        _ => unreachable!("meshes have two or three dimensions"),
    };
    *compiled.downcast_ref().expect("the code for D dimensions")
}

macro_rules! compile {
    ($D:literal) => {
        impl Instance<$D> for Compiled {
            fn problem(&self, scene: Scene<$D>) -> Result<Problem<$D>, Error> {
                scene.build()
            }

            fn report(&self, scene: &Scene<$D>) -> Report {
                scene.examine()
            }

            fn answers<'a>(&self, problem: &'a Problem<$D>) -> &'a dyn Answers {
                problem
            }

            fn answers_mut<'a>(&self, problem: &'a mut Problem<$D>) -> &'a mut dyn Answers {
                problem
            }

            fn run(
                &self,
                load_steps: &LoadSteps,
                solver: &mut dyn Equilibrium,
                problem: &mut Problem<$D>,
                observe: Observe<'_, $D>,
            ) -> Result<History<$D>, Error> {
                simulation::run(load_steps, solver, problem, observe)
            }

            fn certificate(&self, problem: &Problem<$D>, solution: &Solution) -> Certificate {
                Certificate::of_step(problem, solution, true)
            }

            fn pair_states(
                &self,
                problem: &Problem<$D>,
                u: &[f64],
                contact: (&LinearGaps, &[f64]),
            ) -> Result<Vec<PairState<$D>>, Error> {
                problem.states_of_pairs(u, contact)
            }

            fn error_estimate(
                &self,
                problem: &Problem<$D>,
                solution: &Solution,
            ) -> Result<ErrorEstimate<$D>, Error> {
                problem.estimate(solution)
            }

            #[cfg(feature = "record")]
            fn record(
                &self,
                plan: Plan<'_, $D>,
                load_steps: &LoadSteps,
                solver: &mut dyn Equilibrium,
                problem: &mut Problem<$D>,
            ) -> Result<Recorded<$D>, Error> {
                plan.run(load_steps, solver, problem)
            }
        }
    };
}

compile!(2);
compile!(3);
