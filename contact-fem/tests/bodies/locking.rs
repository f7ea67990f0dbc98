//! Bodies that are nearly incompressible: linear cells that lock, those with averaged changes of volume, and quadratic cells as the
//! reference.

use contact_fem::element::{Element, P1, P2};
use contact_fem::material::Volumetric;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Mesh, Motion, NeoHookean, Obstacle, Scene, Simulation};

/// Poisson's ratio.
const NU: f64 = 0.4999;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Cells {
    Linear,
    Averaged,
    Quadratic,
}

fn body<M: Volumetric<2>>(mesh: Mesh<2>, law: M, cells: Cells) -> Body<2>
where
    P1: Element<2>,
    P2: Element<2>,
{
    match cells {
        Cells::Linear => Body::new(mesh, law),
        Cells::Averaged => Body::with_averaged_volumes(mesh, law).expect("linear cells"),
        Cells::Quadratic => Body::new(mesh.quadratic(), law),
    }
}

/// The deflection of the upper corner of Cook's membrane: 48 long, 44 and 16 high, clamped on the left, sheared on the right.
fn cook<M: Volumetric<2>>(law: M, force: f64, cells: Cells, diagonals: Diagonals, n: usize) -> f64 {
    let xs = linspace(0.0, 1.0, n);
    let square = rectangle(&xs, &xs, diagonals).expect("a mesh");
    let mesh = square.mapped(|at| {
        let (low, high) = (44.0 * at[0], 44.0 + 16.0 * at[0]);
        Vector::<2>::new(48.0 * at[0], low + (high - low) * at[1])
    });
    let mut membrane = body(mesh.expect("a mesh"), law, cells);
    membrane.prescribe("left", [Some(0.0); 2]).expect("held");
    membrane
        .traction("right", [0.0, force / 16.0])
        .expect("a load");
    let corner = membrane
        .mesh()
        .nodes()
        .iter()
        .position(|x| (x - Vector::<2>::new(48.0, 60.0)).norm() < 1e-9);
    let mut scene = Scene::new();
    scene.add("membrane", membrane);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(4)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    problem.displacements(&history.run.state.u)[corner.expect("a corner")][1]
}

/// The force on a ball of radius 1 that is pressed by 0.1 into a block, 2 wide on either side and 2 high, held at its bottom.
fn indentation<M: Volumetric<2>>(law: M, cells: Cells, diagonals: Diagonals, n: usize) -> f64 {
    let xs = linspace(-1.0, 1.0, 2 * n);
    let ys = linspace(0.0, 1.0, n);
    let mesh = rectangle(&xs, &ys, diagonals).expect("a mesh");
    let mut block = body(mesh, law, cells);
    block.prescribe("bottom", [Some(0.0); 2]).expect("held");
    let mut scene = Scene::new();
    let block = scene.add("block", block);
    let ball = Obstacle::ball([0.0, 2.0], 1.0).expect("a ball");
    let down = Motion::translation([0.0, -0.1]).expect("a motion");
    let ball = scene
        .obstacle("ball", block.on("top"), ball.moving(down))
        .expect("a surface");
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(4)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    history.last().expect("a step").obstacle_force(ball)[1]
}

/// A ball pressed into a block: within 2 % of quadratic cells, where plain linear cells are several times as stiff.
#[test]
fn an_indentation_is_that_of_quadratic_cells() {
    let linear = LinearElastic::new(70.0, NU).expect("a law");
    let large = NeoHookean::new(240.0, NU).expect("a law");
    let of = |cells, n| {
        [
            indentation(linear, cells, Diagonals::Rising, n),
            indentation(large, cells, Diagonals::Rising, n),
        ]
    };
    let (reference, averaged) = (of(Cells::Quadratic, 16), of(Cells::Averaged, 14));
    let plain = of(Cells::Linear, 14);
    for k in 0..2 {
        let [averaged, plain] = [averaged, plain].map(|force| force[k] / reference[k] - 1.0);
        println!("averaged {averaged:+.4}, plain {plain:+.3}");
        assert!(averaged.abs() < 0.02, "{averaged}");
        assert!(plain > 0.5, "{plain}");
    }
}

/// Cook's membrane: within 2 % of quadratic cells.
#[test]
fn cooks_membrane_is_that_of_quadratic_cells() {
    let linear = LinearElastic::new(70.0, NU).expect("a law");
    let large = NeoHookean::new(240.0, NU).expect("a law");
    let of = |cells, n| {
        [
            cook(linear, 1.0, cells, Diagonals::Rising, n),
            cook(large, 100.0, cells, Diagonals::Rising, n),
        ]
    };
    let (reference, averaged) = (of(Cells::Quadratic, 32), of(Cells::Averaged, 64));
    let plain = of(Cells::Linear, 64);
    for k in 0..2 {
        let [averaged, plain] = [averaged, plain].map(|moved| moved[k] / reference[k] - 1.0);
        println!("averaged {averaged:+.4}, plain {plain:+.3}");
        assert!(averaged.abs() < 0.02, "{averaged}");
        assert!(plain < -0.5, "{plain}");
    }
}

/// A ball pressed into a block of tetrahedra that fills a box. These lock less than triangles, and half of what is left is the
/// coarse surface.
#[test]
fn tetrahedra_do_not_lock_either() {
    let law = NeoHookean::new(10.0, NU).expect("a law");
    let force = |cells, n: usize| {
        let mesh = cuboid([-1.0, -1.0, 0.0], [2.0, 2.0, 1.0], [2 * n, 2 * n, n]).expect("a mesh");
        let mut block = match cells {
            Cells::Linear => Body::new(mesh, law),
            Cells::Averaged => Body::with_averaged_volumes(mesh, law).expect("linear cells"),
            Cells::Quadratic => Body::new(mesh.quadratic(), law),
        };
        for side in ["bottom", "left", "right", "front", "back"] {
            block.prescribe(side, [Some(0.0); 3]).expect("held");
        }
        let mut scene = Scene::new();
        let block = scene.add("block", block);
        let ball = Obstacle::ball([0.0, 0.0, 3.0], 2.0).expect("a ball");
        let down = Motion::translation([0.0, 0.0, -0.1]).expect("a motion");
        let ball = scene.obstacle("ball", block.on("top"), ball.moving(down));
        let ball = ball.expect("a surface");
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(4).run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete(), "{cells:?} {}", history.run.ending);
        history.last().expect("a step").obstacle_force(ball)[2]
    };
    let reference = force(Cells::Quadratic, 4);
    let [averaged, plain] =
        [Cells::Averaged, Cells::Linear].map(|cells| force(cells, 8) / reference - 1.0);
    println!("averaged {averaged:+.3}, plain {plain:+.3}");
    assert!(averaged.abs() < 0.1, "{averaged}");
    assert!(plain > 1.5 * averaged.abs(), "{plain} {averaged}");
}

/// Quadratic cells need no averages.
#[test]
fn quadratic_cells_are_refused() {
    let mesh = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("a mesh");
    let law = LinearElastic::new(1.0, 0.3).expect("a law");
    let refused = Body::with_averaged_volumes(mesh.quadratic(), law);
    let why = refused.err().expect("quadratic").to_string();
    assert!(why.contains("Body::new"), "{why}");
}
