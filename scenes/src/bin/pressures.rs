//! Errors of the recovered and of the consistent contact pressure against Hertz's, and the ball's meshes for other programs.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the symbols of the field

use std::path::PathBuf;

use clap::Parser;
use contact_core::equilibrium::Solution;
use contact_fem::element::Order;
use contact_fem::model::{Passes, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{MeshFile, Scene, Simulation};
use ipopt_contact_scenes::ball::{self, Ball};
use ipopt_contact_scenes::hertz::{FORCE, Fineness, Hertz};
use ipopt_contact_scenes::pressure::{amplitude, error};
use ipopt_contact_scenes::tables::Table;
use ipopt_contact_scenes::{Failure, files};
use serde::Serialize;

/// Errors of contact pressures against Hertz's
#[derive(Parser, Debug)]
struct Arguments {
    /// The folder for the results
    #[arg(long, default_value = "out/pressures")]
    out: PathBuf,
    /// Other meshes of the ball, as `scripts/ball.geo` makes them
    #[arg(long, num_args = 1..)]
    meshes: Vec<PathBuf>,
    /// Only meshes of at most so many facets in the contact's half-width
    #[arg(long, default_value_t = usize::MAX)]
    finest: usize,
}

/// A mesh of the ball as lists, for programs that solve the same scene.
#[derive(Serialize)]
struct Export {
    nodes: Vec<[f64; 3]>,
    cells: Vec<Vec<usize>>,
    /// The nodes of facets that may touch the plane z = 0, those held in x and in y, and the forces on nodes.
    below: Vec<Vec<usize>>,
    held_x: Vec<usize>,
    held_y: Vec<usize>,
    forces: Vec<f64>,
    young: f64,
    poisson: f64,
    contact_radius: f64,
    peak_pressure: f64,
    errors: [f64; 2],
    /// Nodes of the surface with the recovered and the consistent pressure.
    pressures: Vec<(usize, f64, f64)>,
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let order_name = |order| match order {
        Order::Linear => "P1",
        Order::Quadratic => "P2",
    };
    let columns = [
        "mesh",
        "order or body",
        "error, recovered",
        "error, consistent",
        "amplitude off, recovered",
        "amplitude off, consistent",
        "largest, recovered",
        "least, consistent",
    ];
    files::make_folder(&arguments.out)?;
    let mut table = Table::new("ball", columns);
    let linear = [2, 3, 4, 6].map(|n| (n, Order::Linear));
    let quadratic = [2, 3, 4].map(|n| (n, Order::Quadratic));
    let mut scenes = Vec::new();
    for (in_contact, order) in linear.into_iter().chain(quadratic) {
        if in_contact <= arguments.finest {
            let scene = Ball { in_contact, order }.scene()?;
            scenes.push((format!("a_{in_contact}"), order, scene));
        }
    }
    for path in &arguments.meshes {
        for order in [Order::Linear, Order::Quadratic] {
            let ball = Ball {
                in_contact: 4,
                order,
            };
            let stem = path.file_stem().map(|stem| stem.to_string_lossy());
            let mut bodies = MeshFile::read(path)?.bodies()?;
            let Some((_, mesh)) = bodies.pop().filter(|_| bodies.is_empty()) else {
                return Err(format!("{} has more than one body", path.display()).into());
            };
            let scene = ball.scene_of(mesh)?;
            scenes.push((stem.unwrap_or_default().into_owned(), order, scene));
        }
    }
    for (mesh, order, scene) in scenes {
        let (problem, solution) = solved(scene)?;
        let fields = fields(&problem, &solution)?;
        let shape = |X: &Vector<3>| profile(X.xy().norm() / ball::CONTACT_RADIUS);
        let is_inside = |X: &Vector<3>| X.xy().norm() < 0.6 * ball::CONTACT_RADIUS;
        let errors = row(
            &mut table,
            [mesh.clone(), order_name(order).into()],
            &problem,
            0,
            &fields,
            (Ball::peak_pressure(), &shape, &is_inside),
        );
        let export = export(&problem, errors, &fields);
        let name = format!("{}_{mesh}.json", order_name(order));
        files::write(arguments.out.join(name), serde_json::to_vec(&export)?)?;
    }
    table.save(&arguments.out)?;
    let mut table = Table::new("cylinder", columns);
    let all_passes = [
        ("both", Passes::Both),
        ("cylinder", Passes::FirstIsSlave),
        ("block", Passes::SecondIsSlave),
    ];
    for in_contact in [4, 8, 11, 16, 22, 32] {
        // the published load by both passes, and five times that by all
        let runs = all_passes.map(|passes| (5.0 * FORCE, passes));
        for (force, (slave, passes)) in [(FORCE, all_passes[0])].into_iter().chain(runs) {
            if in_contact > arguments.finest {
                continue;
            }
            let hertz = Hertz {
                force,
                passes,
                ..Hertz::new(Fineness::family(in_contact), Order::Quadratic)
            };
            let (problem, solution) = solved(hertz.scene()?)?;
            let fields = fields(&problem, &solution)?;
            let a = hertz.half_width();
            for (k, body) in ["cylinder", "block"].iter().enumerate() {
                let shape = |X: &Vector<2>| profile(X[0].abs() / a);
                let is_inside = |X: &Vector<2>| X[0] < 0.6 * a;
                let mesh = format!("a/{in_contact}, load {force}, slave {slave}");
                row(
                    &mut table,
                    [mesh, (*body).into()],
                    &problem,
                    k,
                    &fields,
                    (hertz.peak_pressure(), &shape, &is_inside),
                );
            }
        }
    }
    // the cylinder on a rigid plane
    for in_contact in [4, 8, 16, 32]
        .into_iter()
        .filter(|n| *n <= arguments.finest)
    {
        let published = Hertz::new(Fineness::family(in_contact), Order::Quadratic);
        let hertz = Hertz {
            young: [published.young[0], f64::INFINITY],
            ..published
        };
        let (problem, solution) = solved(hertz.on_rigid(false)?)?;
        let fields = fields(&problem, &solution)?;
        let a = hertz.half_width();
        let shape = |X: &Vector<2>| profile(X[0].abs() / a);
        let is_inside = |X: &Vector<2>| X[0] < 0.6 * a;
        row(
            &mut table,
            [
                format!("a/{in_contact}, on a rigid plane"),
                "cylinder".into(),
            ],
            &problem,
            0,
            &fields,
            (hertz.peak_pressure(), &shape, &is_inside),
        );
    }
    table.save(&arguments.out)?;
    Ok(())
}

/// Hertz's profile at a share of the half-width.
fn profile(r: f64) -> f64 {
    (1.0 - r * r).max(0.0).sqrt()
}

/// p₀, the profile, and where amplitudes are fitted.
type Exact<'a, const D: usize> = (
    f64,
    &'a dyn Fn(&Vector<D>) -> f64,
    &'a dyn Fn(&Vector<D>) -> bool,
);

/// Appends the errors of both fields on a surface.
fn row<const D: usize>(
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

fn solved<const D: usize>(scene: Scene<D>) -> Result<(Problem<D>, Solution), Failure> {
    let mut problem = scene.problem()?;
    let history = Simulation::with_increments(1).run(&mut problem)?;
    let ending = history.run.ending.to_string();
    let solution = history.run.solution.ok_or(ending)?;
    Ok((problem, solution))
}

/// The recovered and the consistent pressures on all surfaces.
fn fields<const D: usize>(
    problem: &Problem<D>,
    solution: &Solution,
) -> Result<[Vec<Vec<f64>>; 2], Failure> {
    let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
    Ok([
        problem.pressures(u, gaps, lambda)?,
        problem.consistent_pressures(u, gaps, lambda)?,
    ])
}

fn export(problem: &Problem<3>, errors: [f64; 2], fields: &[Vec<Vec<f64>>; 2]) -> Export {
    let body = &problem.scene().bodies()[0];
    let held = |axis: usize| {
        let dofs = body.prescribed().iter().skip(axis).step_by(3).enumerate();
        dofs.filter(|(_, value)| value.is_some())
            .map(|(node, _)| node)
            .collect()
    };
    let surface = &problem.surfaces()[0];
    let nodes = |facet: &[usize]| facet.iter().map(|&a| surface.nodes()[a]).collect();
    let [young, poisson] = ball::MODULI;
    Export {
        nodes: body.mesh().nodes().iter().map(|X| (*X).into()).collect(),
        cells: body.mesh().cells().map(<[usize]>::to_vec).collect(),
        below: surface.facets().map(nodes).collect(),
        held_x: held(0),
        held_y: held(1),
        forces: body.forces().to_vec(),
        young,
        poisson,
        contact_radius: ball::CONTACT_RADIUS,
        peak_pressure: Ball::peak_pressure(),
        errors,
        pressures: (surface.nodes().iter().enumerate())
            .map(|(a, &node)| (node, fields[0][0][a], fields[1][0][a]))
            .collect(),
    }
}
