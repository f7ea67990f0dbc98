//! Rows that all tables have.

use contact_core::equilibrium::Solution;
use contact_fem::element::Order;
use contact_fem::model::Problem;
use contact_fem::tensor::Vector;
use contact_fem::{Scene, Simulation};
use ipopt_contact_scenes::Failure;
use ipopt_contact_scenes::pressure::{amplitude, error};
use ipopt_contact_scenes::tables::Table;

/// Their columns.
pub const COLUMNS: [&str; 8] = [
    "mesh",
    "order or body",
    "error, recovered",
    "error, consistent",
    "amplitude off, recovered",
    "amplitude off, consistent",
    "largest, recovered",
    "least, consistent",
];

/// What an order is called.
pub fn order_name(order: Order) -> &'static str {
    match order {
        Order::Linear => "P1",
        Order::Quadratic => "P2",
    }
}

/// Hertz's profile at a share of the half-width.
pub fn profile(r: f64) -> f64 {
    (1.0 - r * r).max(0.0).sqrt()
}

/// p₀, the profile, and where amplitudes are fitted.
pub type Exact<'a, const D: usize> = (
    f64,
    &'a dyn Fn(&Vector<D>) -> f64,
    &'a dyn Fn(&Vector<D>) -> bool,
);

/// Appends the errors of both fields on a surface.
pub fn row<const D: usize>(
    table: &mut Table,
    head: [String; 2],
    problem: &Problem<D>,
    surface: usize,
    fields: &[Vec<Vec<f64>>; 2],
    (p0, profile, is_inside): Exact<'_, D>,
) -> [f64; 2] {
    let side = &problem.surfaces()[surface];
    let errors = [0, 1].map(|k| error(side, &fields[k][surface], |X| p0 * profile(X)));
    let off = |k: usize| amplitude(side, &fields[k][surface], profile, is_inside) / p0 - 1.0;
    let least = fields[1][surface].iter().copied().fold(0.0, f64::min) / p0;
    let largest = fields[0][surface].iter().copied().fold(0.0, f64::max) / p0;
    let numbers = [errors[0], errors[1], off(0), off(1), largest, least];
    let cells = numbers.map(|value| format!("{value:.4}"));
    table.push(head.into_iter().chain(cells).collect());
    errors
}

pub fn solved<const D: usize>(scene: Scene<D>) -> Result<(Problem<D>, Solution), Failure> {
    let mut problem = scene.problem()?;
    let history = Simulation::with_increments(1).run(&mut problem)?;
    let ending = history.run.ending.to_string();
    let solution = history.run.solution.ok_or(ending)?;
    Ok((problem, solution))
}

/// The recovered and the consistent pressures on all surfaces.
pub fn fields<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
) -> Result<[Vec<Vec<f64>>; 2], Failure> {
    let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
    Ok([
        problem.pressures(u, gaps, lambda)?,
        problem.consistent_pressures(u, gaps, lambda)?,
    ])
}
