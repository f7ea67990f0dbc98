//! Solves one scene and measures what that takes.

use std::time::Instant;

use ipopt_contact::contact_core::ContactProblem;
use ipopt_contact::contact_core::equilibrium::Solution;
use ipopt_contact::contact_fem::Error;
use ipopt_contact::contact_fem::certificate::{Entry, Limits};
use ipopt_contact::contact_fem::tensor::Vector;
use ipopt_contact::prelude::*;

use crate::Failure;
use crate::case::Case;
use crate::processor;
use crate::record::{Cost, Measured, Phases};
use ipopt_contact::contact_fem::output::record::peak_memory;

/// A scene at full load, or wherever it came to.
pub struct Solved<const D: usize> {
    /// The problem at its last load.
    pub problem: Problem<D>,
    /// How it came there.
    pub history: History<D>,
    cost: Cost,
}

impl<const D: usize> Solved<D> {
    /// Builds and solves the scene in so many increments.
    pub fn new(
        case: &Case,
        increments: usize,
        scene: impl FnOnce() -> Result<Scene<D>, Error>,
    ) -> Result<Self, Failure> {
        let (clock, cpu) = (Instant::now(), processor::seconds());
        let mut scene = scene()?;
        scene.integration = case.integration().or(scene.integration);
        let mut problem = scene.problem()?;
        let set_up = clock.elapsed().as_secs_f64();
        let history = case.simulation(increments).run(&mut problem)?;
        let wall = clock.elapsed().as_secs_f64();
        let cpu = processor::seconds().zip(cpu).map(|(now, then)| now - then);
        let cost = Cost {
            cpu,
            ..cost(&history, wall, set_up)
        };
        Ok(Solved {
            problem,
            history,
            cost,
        })
    }

    /// The solution at full load, if it came there.
    pub fn solution(&self) -> Option<&Solution> {
        let is_complete = self.history.run.ending == Ending::Complete;
        self.history.run.solution.as_ref().filter(|_| is_complete)
    }

    /// The displacement of every node in the last converged state (UL).
    pub fn displacements(&self) -> Vec<Vector<D>> {
        self.problem.displacements(&self.history.run.state.u)
    }

    /// The pressure at the nodes of every contact surface; nothing without a solution.
    pub fn pressures(&self) -> Result<Vec<Vec<f64>>, Failure> {
        let Some(solution) = self.solution() else {
            return Ok(Vec::new());
        };
        let (u, lambda) = (&self.history.run.state.u, &solution.lambda);
        Ok(self.problem.pressures(u, &solution.gaps, lambda)?)
    }

    /// The consistent pressure likewise: it scatters more, and its mean over several facets is more accurate.
    pub fn consistent_pressures(&self) -> Result<Vec<Vec<f64>>, Failure> {
        let Some(solution) = self.solution() else {
            return Ok(Vec::new());
        };
        let (u, lambda) = (&self.history.run.state.u, &solution.lambda);
        let pressures = self
            .problem
            .consistent_pressures(u, &solution.gaps, lambda)?;
        Ok(pressures)
    }

    /// All that is known without the errors, which are to be filled in; `h` is the mesh size (UL).
    pub fn measured(&self, h: f64) -> Measured {
        let status = match &self.history.run.ending {
            Ending::Complete => Measured::CONVERGED.to_string(),
            Ending::NotConverged { at, why, .. } => format!("stopped at load {at:.3}: {why}"),
            other => format!("{other:?}"),
        };
        Measured {
            status,
            h,
            dofs: self.problem.energy().dofs(),
            rows: self.history.steps.last().map_or(0, |step| step.rows),
            cost: self.cost,
            certificate: broken(&self.history),
            ..Measured::default()
        }
    }
}

/// The lines of the worst certificate that do not hold.
fn broken<const D: usize>(history: &History<D>) -> Vec<String> {
    let Some(certificate) = history.certificate() else {
        return Vec::new();
    };
    let entries = certificate.entries(&Limits::default());
    let broken = entries.filter(|entry| !entry.holds());
    let line = |entry: Entry| {
        let value = entry.value.unwrap_or(f64::NAN);
        format!("{} {value:.1e} of {:.1e}", entry.name, entry.limit)
    };
    broken.map(line).collect()
}

fn cost<const D: usize>(history: &History<D>, wall: f64, set_up: f64) -> Cost {
    let effort = history.run.cost();
    let known = set_up + effort.projection + effort.callbacks + effort.optimizer;
    Cost {
        wall,
        cpu: None,
        memory: peak_memory(),
        steps: history.steps.len(),
        cuts: history.run.cuts(),
        fixed_point: effort.outer_iterations,
        iterations: effort.inner_iterations,
        factorizations: effort.factorizations,
        phases: Phases {
            set_up,
            projection: effort.projection,
            callbacks: effort.callbacks,
            optimizer: effort.optimizer,
            other: (wall - known).max(0.0),
        },
    }
}
