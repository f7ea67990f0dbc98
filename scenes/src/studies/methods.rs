//! The three methods for step 5 on the same scenes: the interior point (7), the penalised slack (37) and the penalty (39).

use contact_core::Ending;
use contact_core::Retry;
use contact_core::equilibrium::Solution;
use contact_core::{Continuation, InteriorPoint, Method, PenalizedSlack, Penalty};
use contact_fem::Simulation;
use contact_fem::element::Order;
use contact_fem::model::Problem;

use super::condition::{Weighting, condition};
use super::pointwise::{Pointwise, order};
use crate::beams::{Beams, Law};
use crate::hertz::{self, Hertz};
use crate::tables::{Table, digits, number};
use crate::{Failure, disc_in_disc};

/// The penalty factors of all scenes; orders of convergence are fitted to the last three that were
/// solved.
const MUS: [f64; 5] = [1e4, 1e6, 1e8, 1e10, 1e12];

/// All methods on all scenes: errors, costs, and orders of convergence in μ.
pub fn tables(quick: bool) -> Result<Vec<Table>, Failure> {
    let mut study = Study::new();
    let pick = |coarse, fine| if quick { coarse } else { fine };

    let fineness = hertz::Fineness::family(pick(5, 10));
    let scene = Hertz::new(fineness, Order::Linear).scene()?;
    study.scene("Hertz", scene.problem()?, 1)?;

    let fineness = disc_in_disc::Fineness::scaled(pick(16, 32));
    let scene = disc_in_disc::scene(fineness, disc_in_disc::Roles::default())?;
    study.scene("disc-in-disc", scene.problem()?, pick(5, 20))?;

    for (name, order, across) in [
        ("beams, P1", Order::Linear, pick(1, 2)),
        ("beams, P2", Order::Quadratic, 1),
    ] {
        let scene = Beams::new(across, order, Law::SmallStrain).scene()?;
        study.scene(name, scene.problem()?, 1)?;
    }
    Ok(vec![study.rows, study.orders])
}

/// The tables, to which rows are added.
struct Study {
    rows: Table,
    orders: Table,
}

/// A method with its settings, and the term in addition to E in its Hessian.
struct Run {
    name: &'static str,
    mu: String,
    method: Box<dyn Method>,
    weighting: Option<Weighting>,
}

/// A converged run.
#[derive(Clone)]
struct Ended {
    solution: Solution,
    /// The largest nodal penetration, in facet sizes.
    penetration: f64,
    fixed_point: usize,
    ipopt: usize,
}

impl Study {
    fn new() -> Self {
        let columns =
            "scene | method | μ | energy to (7) | u to (7) | energy to own limit | max −c (UL) | \
            node inside (facets) | fixed point | Ipopt | condition"
                .split(" | ");
        Study {
            rows: Table::new("methods", columns),
            orders: Table::new("orders", &["scene", "method", "order in μ"]),
        }
    }

    /// Runs all methods on one scene.
    fn scene<const D: usize>(
        &mut self,
        name: &str,
        mut problem: Problem<D>,
        increments: usize,
    ) -> Result<(), Failure> {
        let [exact, points] = limits();
        let limits = [exact, points].map(|mut run| {
            let ended = ended(&mut problem, run.method.as_mut(), increments);
            (run, ended)
        });
        let [(exact_run, exact), (points_run, points)] = limits;
        let exact = exact?.ok_or("method (7) did not converge")?;
        let points = points?;
        self.row(&problem, name, &exact_run, Some(&exact), [Some(&exact); 2]);
        let of_points = [Some(&exact), points.as_ref()];
        self.row(&problem, name, &points_run, points.as_ref(), of_points);
        let families = [
            ("(37)", slacks(), Some(&exact)),
            ("(39)", penalties(), points.as_ref()),
        ];
        for (method, runs, limit) in families {
            let mut differences = Vec::new();
            for mut run in runs {
                let found = ended(&mut problem, run.method.as_mut(), increments)?;
                self.row(&problem, name, &run, found.as_ref(), [Some(&exact), limit]);
                if let (Some(found), Some(limit), Ok(mu)) = (found, limit, run.mu.parse()) {
                    differences.push((mu, energy_difference(&found, limit)));
                }
            }
            let last = &differences[differences.len().saturating_sub(3)..];
            let k = (last.len() == 3).then(|| format!("{:.3}", order(last)));
            let cells = [name.into(), method.into(), number(k)];
            self.orders.push(cells.to_vec());
        }
        Ok(())
    }

    /// Adds one row; `limits` are the result of method (7) and the limit of this method for μ → ∞.
    fn row<const D: usize>(
        &mut self,
        problem: &Problem<D>,
        scene: &str,
        run: &Run,
        found: Option<&Ended>,
        limits: [Option<&Ended>; 2],
    ) {
        let energies = limits.map(|limit| Some(energy_difference(found?, limit?)));
        let of_u = || {
            Some(distance(
                &found?.solution.state.u,
                &limits[0]?.solution.state.u,
            ))
        };
        let kappa = || condition(problem, &found?.solution, run.weighting?);
        self.rows.push(vec![
            scene.into(),
            run.name.into(),
            run.mu.clone(),
            digits(energies[0]),
            digits(of_u()),
            digits(energies[1]),
            digits(found.map(|found| deepest(&found.solution))),
            digits(found.map(|found| found.penetration)),
            number(found.map(|found| found.fixed_point)),
            number(found.map(|found| found.ipopt)),
            digits(kappa()),
        ]);
    }
}

/// Method (7), with constraints at nodes and with constraints at points.
fn limits() -> [Run; 2] {
    let run = |name, method| Run {
        name,
        mu: "-".into(),
        method,
        weighting: Some(Weighting::Confined),
    };
    [
        run("(7)", Box::<InteriorPoint>::default()),
        run("(7) at points", Box::<Pointwise>::default()),
    ]
}

/// Method (37), with its default continuation and with every μ.
fn slacks() -> Vec<Run> {
    let method = |continuation| Box::new(PenalizedSlack::with(continuation)) as Box<dyn Method>;
    family("(37)", Weighting::Rows, method)
}

/// As [`slacks`] for method (39).
fn penalties() -> Vec<Run> {
    let method = |continuation| Box::new(Penalty::with(continuation)) as Box<dyn Method>;
    family("(39)", Weighting::Surface, method)
}

fn family(
    name: &'static str,
    weighting: fn(f64) -> Weighting,
    method: fn(Continuation) -> Box<dyn Method>,
) -> Vec<Run> {
    let fixed = MUS.map(|mu| Run {
        name,
        mu: format!("{mu:e}"),
        method: method(Continuation::fixed(mu)),
        weighting: Some(weighting(mu)),
    });
    let default = Run {
        name,
        mu: "default".into(),
        method: method(Continuation::default()),
        weighting: None,
    };
    fixed.into_iter().chain([default]).collect()
}

/// A run to full load; `None` if it does not reach it.
fn ended<const D: usize>(
    problem: &mut Problem<D>,
    method: &mut dyn Method,
    increments: usize,
) -> Result<Option<Ended>, Failure> {
    let mut simulation = Simulation::solved_by(Retry::with(method), increments);
    simulation.solver.fixed_point.tolerance = 1e-7;
    simulation.load_steps.max_halvings = 2;
    let history = simulation.run(problem)?;
    if history.run.ending != Ending::Complete {
        return Ok(None);
    }
    let cost = history.run.cost();
    Ok(history.run.solution.map(|solution| Ended {
        penetration: problem.relative_penetration(&solution.state.u),
        fixed_point: cost.outer_iterations,
        ipopt: cost.inner_iterations,
        solution,
    }))
}

/// |E − E of the limit| divided by |E of the limit|.
fn energy_difference(found: &Ended, limit: &Ended) -> f64 {
    let (a, b) = (found.solution.energy, limit.solution.energy);
    (a - b).abs() / b.abs()
}

/// max |a − b| divided by max |b|.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest
}

/// max −c over the solver's rows (UL).
fn deepest(solution: &Solution) -> f64 {
    let mut c = vec![0.0; solution.gaps.len()];
    solution.gaps.value(&solution.state.u, &mut c);
    c.iter().fold(0.0, |depth: f64, c| depth.max(-c))
}
