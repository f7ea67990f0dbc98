//! Errors of the recovered and of the consistent contact pressure against Hertz's and Lamé's, the ball's meshes for other programs, and
//! the work that is not stored.
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the symbols of the field

mod cylinder;
mod rows;
mod shells;
mod work;

use std::path::PathBuf;

use clap::Parser;
use contact_fem::MeshFile;
use contact_fem::element::Order;
use contact_fem::model::Problem;
use contact_fem::tensor::Vector;
use ipopt_contact_scenes::ball::{self, Ball};
use ipopt_contact_scenes::tables::Table;
use ipopt_contact_scenes::{Failure, files};
use serde::Serialize;

use rows::{COLUMNS, fields, order_name, profile, row, solved};

/// Errors of contact pressures against Hertz's and Lamé's, and work that is not stored
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
    files::make_folder(&arguments.out)?;
    let mut table = Table::new("ball", COLUMNS);
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
    cylinder::table(arguments.finest)?.save(&arguments.out)?;
    shells::table(arguments.finest)?.save(&arguments.out)?;
    work::table(arguments.finest < 4)?.save(&arguments.out)?;
    Ok(())
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
