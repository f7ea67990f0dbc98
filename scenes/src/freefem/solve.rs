//! This library's run of a case, which writes the same files as FreeFEM's scripts.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use contact_core::Ending;
use contact_fem::model::Problem;
use contact_fem::output::Snapshot;
use contact_fem::simulation::History;
use contact_fem::{Simulation, StepRecord};

use super::cases::{Built, Case, Size};
use crate::{Failure, cli::Solver, files};

/// Solves the case and writes `result.txt`, `history.txt`, `displacement_BODY.txt` and
/// `pressure_BODY.txt` to `folder`.
pub fn solve(case: &Case, size: Size, folder: &Path) -> Result<(), Failure> {
    let clock = Instant::now();
    match case.scene(size)? {
        Built::Plane(scene) => run(case, size, scene.problem()?, clock, folder),
        Built::Space(scene) => run(case, size, scene.problem()?, clock, folder),
    }
}

fn run<const D: usize>(
    case: &Case,
    size: Size,
    mut problem: Problem<D>,
    clock: Instant,
    folder: &Path,
) -> Result<(), Failure> {
    let increments = size.of(case.increments);
    let solver = Solver::Ipopt.with_tolerance(Some(case.tolerance));
    let mut simulation = Simulation::solved_by(solver, increments);
    let history = simulation.run(&mut problem)?;
    let seconds = clock.elapsed().as_secs_f64();
    files::write(folder.join("history.txt"), lines(case, &history))?;
    files::write(
        folder.join("result.txt"),
        result(case, &problem, &history, increments, seconds),
    )?;
    let Some(solution) = &history.run.solution else {
        return Ok(());
    };
    let state = Snapshot::new(&problem, solution)?;
    for (body, name) in case.bodies.iter().enumerate() {
        let mut text = String::new();
        for u in &state.displacements[problem.nodes(body)] {
            let line: Vec<String> = u.iter().map(|value| format!("{value:e}")).collect();
            text += &(line.join(" ") + "\n");
        }
        files::write(folder.join(format!("displacement_{name}.txt")), text)?;
        let mut text = String::new();
        for surface in problem.surfaces().iter().filter(|s| s.body() == body) {
            for &node in surface.nodes() {
                let number = node - problem.first_node(body);
                text += &format!("{number} {:e}\n", state.consistent_pressures[node]);
            }
        }
        files::write(folder.join(format!("pressure_{name}.txt")), text)?;
    }
    Ok(())
}

/// The scene's reaction (UF): the sum over the supports of the case.
pub fn reaction<const D: usize>(case: &Case, record: &StepRecord<D>) -> [f64; D] {
    let supports = case.supports.iter();
    let sum = |i: usize| {
        supports
            .clone()
            .map(|&body| record.reactions[body][i])
            .sum()
    };
    std::array::from_fn(sum)
}

fn lines<const D: usize>(case: &Case, history: &History<D>) -> String {
    let line = |record: &StepRecord<D>| {
        let iterations = record.attempt.iterations.len();
        let (energy, force) = (record.energy, reaction(case, record)[D - 1]);
        let seconds = record.attempt.cost.wall;
        format!(
            "{} {energy:e} {force:e} {iterations} {seconds}\n",
            record.factor
        )
    };
    history.steps.iter().map(line).collect()
}

fn result<const D: usize>(
    case: &Case,
    problem: &Problem<D>,
    history: &History<D>,
    increments: usize,
    seconds: f64,
) -> String {
    let cost = history.run.cost();
    let cells = problem.scene().bodies().iter().map(|b| b.mesh().len());
    let is_complete = history.run.ending == Ending::Complete;
    let mut values = vec![
        ("increments", increments as f64),
        ("fixed_point_iterations", cost.outer_iterations as f64),
        ("ipopt_iterations", cost.inner_iterations as f64),
        ("seconds_total", seconds),
        ("seconds_rows", cost.projection),
        ("seconds_ipopt", cost.optimizer),
        ("seconds_callbacks", cost.callbacks),
        ("converged", f64::from(u8::from(is_complete))),
        ("cuts", history.run.cuts() as f64),
        ("cells", cells.sum::<usize>() as f64),
        ("free_dofs", problem.dofs().free() as f64),
    ];
    if let Some(last) = history.steps.last() {
        values.push(("energy", last.energy));
        let names = ["reaction_x", "reaction_y", "reaction_z"];
        values.extend(names.into_iter().zip(reaction(case, last)));
    }
    let mut text = String::new();
    for (key, value) in values {
        // writing to a string cannot fail
        let _ = writeln!(text, "{key} {value:e}");
    }
    text
}
