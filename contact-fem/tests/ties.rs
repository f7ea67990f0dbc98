//! Bodies with meshes that do not match, tied to each other.
#![allow(non_snake_case)]

use contact_core::{CondensedNewton, Equilibrium};
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Tie, TieFault, TiedSlave};
use contact_fem::simulation::History;
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{
    Body, BodyId, Error, LinearElastic, Mesh, NeoHookean, Obstacle, Scene, Simulation,
};

const SLAVES: [TiedSlave; 2] = [TiedSlave::First, TiedSlave::Second];

/// Two blocks on each other, of height 1 each; the cells of their surfaces have no node in common but at the rim.
fn blocks<const D: usize>(is_quadratic: bool) -> [Mesh<D>; 2]
where
    Blocks: Of<D>,
{
    let [lower, upper] = Blocks::linear();
    match is_quadratic {
        true => [lower.quadratic(), upper.quadratic()],
        false => [lower, upper],
    }
}

struct Blocks;

trait Of<const D: usize> {
    fn linear() -> [Mesh<D>; 2];
    /// The names of the lower block's upper and the upper block's lower boundary.
    const SIDES: [&'static str; 2] = ["top", "bottom"];
}

impl Of<2> for Blocks {
    fn linear() -> [Mesh<2>; 2] {
        let block = |xs: usize, y: f64, ys: usize| {
            let (xs, ys) = (linspace(0.0, 2.0, xs), linspace(y, y + 1.0, ys));
            rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
        };
        [block(3, 0.0, 2), block(4, 1.0, 2)]
    }
}

impl Of<3> for Blocks {
    fn linear() -> [Mesh<3>; 2] {
        let block = |z: f64, cells: [usize; 3]| {
            cuboid([0.0, 0.0, z], [2.0, 1.0, 1.0], cells).expect("a mesh")
        };
        [block(0.0, [3, 2, 1]), block(1.0, [4, 3, 2])]
    }
}

fn solved<const D: usize, S: Equilibrium>(
    scene: Scene<D>,
    mut simulation: Simulation<S>,
) -> (contact_fem::model::Problem<D>, History<D>) {
    let mut problem = scene.problem().expect("a problem");
    let history = simulation.run(&mut problem).expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(), "{certificate}");
    (problem, history)
}

/// The largest |u − A X| over all nodes.
fn off<const D: usize>(
    problem: &contact_fem::model::Problem<D>,
    history: &History<D>,
    A: &Matrix<D>,
) -> f64 {
    let U = problem.displacements(&history.run.state.u);
    let X = problem.reference().iter();
    X.zip(&U).map(|(X, u)| (u - A * X).amax()).fold(0.0, f64::max)
}

/// Blocks whose outside, but for the tied sides, is moved by u = A X: they take it on everywhere, whichever side follows.
/// Nodes on the rim of the tied sides are prescribed on both.
fn linear_fields<const D: usize>()
where
    Blocks: Of<D>,
{
    let A = Matrix::<D>::from_fn(|i, j| 1e-3 * (1.0 + 2.0 * i as f64 - 1.5 * (i * j) as f64 + j as f64));
    for is_quadratic in [false, true] {
        for slave in SLAVES {
            let law = LinearElastic::new(200.0, 0.3).expect("a law");
            let mut scene = Scene::new();
            let sides = Blocks::SIDES;
            let ids: Vec<BodyId> = blocks::<D>(is_quadratic)
                .into_iter()
                .enumerate()
                .map(|(k, mesh)| {
                    let names: Vec<String> = mesh.boundary_names().map(str::to_string).collect();
                    let mut body = Body::new(mesh, law);
                    for name in names.iter().filter(|name| *name != sides[k]) {
                        for node in body.mesh().boundary_nodes(name).expect("a boundary") {
                            let u = A * body.mesh().nodes()[node];
                            let u: [Option<f64>; D] = std::array::from_fn(|i| Some(u[i]));
                            body.prescribe_nodes(&[node], u).expect("a support");
                        }
                    }
                    scene.add(if k == 0 { "lower" } else { "upper" }, body)
                })
                .collect();
            let tie = Tie { slave, ..Tie::new(ids[0].on(sides[0]), ids[1].on(sides[1])) };
            scene.tie_as(tie).expect("a tie");
            let (problem, history) = solved(scene, Simulation::with_increments(1));
            let off = off(&problem, &history, &A);
            assert!(off < 1e-14, "{D} {is_quadratic} {slave:?}: {off:.1e}");
        }
    }
}

#[test]
fn linear_fields_pass_in_the_plane() {
    linear_fields::<2>();
}

#[test]
fn linear_fields_pass_in_space() {
    linear_fields::<3>();
}

/// Blocks on rollers under a uniform pull: the stress is constant, and the tie transmits the load.
fn constant_stress<const D: usize>(width: f64)
where
    Blocks: Of<D>,
{
    let (E, nu, pull) = (200.0, 0.3, 0.5);
    let last = D - 1;
    for is_quadratic in [false, true] {
        for slave in SLAVES {
            let law = LinearElastic::new(E, nu).expect("a law");
            let mut scene = Scene::new();
            let ids: Vec<BodyId> = blocks::<D>(is_quadratic)
                .into_iter()
                .enumerate()
                .map(|(k, mesh)| {
                    let mut body = Body::new(mesh, law);
                    body.symmetry("left").expect("a support");
                    if D == 3 {
                        body.symmetry("front").expect("a support");
                    }
                    let mut load = [0.0; D];
                    load[last] = pull;
                    match k {
                        0 => body.symmetry("bottom").expect("a support"),
                        _ => body.traction("top", load).expect("a load"),
                    };
                    scene.add(if k == 0 { "lower" } else { "upper" }, body)
                })
                .collect();
            let tie = Tie { slave, ..Tie::new(ids[0].on("top"), ids[1].on("bottom")) };
            scene.tie_as(tie).expect("a tie");
            let (problem, history) = solved(scene, Simulation::with_increments(1));
            // plane strain in the plane
            let [along, across] = match D {
                2 => [(1.0 - nu * nu) / E, -nu * (1.0 + nu) / E],
                _ => [1.0 / E, -nu / E],
            };
            let mut A = Matrix::<D>::identity() * (across * pull);
            A[(last, last)] = along * pull;
            let off = off(&problem, &history, &A) / (2.0 * along * pull);
            assert!(off < 1e-11, "{D} {is_quadratic} {slave:?}: {off:.1e}");
            let step = history.last().expect("a step");
            let mut force = Vector::<D>::zeros();
            force[last] = pull * width;
            let transmitted = step.ties[0].force;
            assert!((transmitted - force).amax() < 1e-10 * pull, "{transmitted}");
            assert!((step.reaction(ids[0])[last] + pull * width).abs() < 1e-10 * pull);
        }
    }
}

#[test]
fn constant_stresses_pass_in_the_plane() {
    constant_stress::<2>(2.0);
}

#[test]
fn constant_stresses_pass_in_space() {
    constant_stress::<3>(2.0);
}
