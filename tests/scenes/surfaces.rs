//! Closed surfaces of facets as obstacles, against the shapes that they are made of and against rigid bodies.

use crate::common::relative;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle, sphere};
use contact_fem::model::Passes;
use contact_fem::simulation::History;
use contact_fem::{Body, Mesh, Motion, NeoHookean, Obstacle, Scene, Simulation};
use ipopt_contact_scenes::tight;

/// Full load in `increments`, under a tight certificate.
fn complete<const D: usize>(scene: Scene<D>, increments: usize) -> History<D> {
    let mut problem = scene.problem().expect("a sound scene");
    let history = Simulation::with_increments(increments).run(&mut problem);
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    history
}

/// The top of a block, at z = −1, to which a tool comes down by 0.03: the tool's force, from an obstacle, or from a rigid body of
/// this mesh.
fn pressed_by(tool: Result<Obstacle<3>, Mesh<3>>) -> f64 {
    let mesh = cuboid([-0.6, -0.6, -1.6], [1.2, 1.2, 0.6], [6, 6, 2]).expect("a mesh");
    let law = NeoHookean::new(100.0, 0.3).expect("a law");
    let mut block = Body::new(mesh, law);
    block.prescribe("bottom", [Some(0.0); 3]).expect("held");
    let mut scene = Scene::new();
    let top = scene.add("block", block).on("top");
    match tool {
        Ok(obstacle) => {
            let down = Motion::translation([0.0, 0.0, -0.03]).expect("a motion");
            let placed = scene.obstacle("tool", top, obstacle.moving(down));
            placed.expect("an obstacle");
            let history = complete(scene, 2);
            history.last().expect("a step").obstacle_forces[0][2]
        }
        Err(mesh) => {
            let side = mesh
                .boundary_names()
                .find(|name| ["surface", "bottom"].contains(name));
            let side = side.expect("a side").to_string();
            let mut body = Body::new(mesh, law);
            let down = [Some(0.0), Some(0.0), Some(-0.03)];
            body.prescribe_all(down).expect("moved");
            let side = scene.add("tool", body).on(side);
            let pair = scene.contact_in_passes(top, side, Passes::FirstIsSlave);
            pair.expect("a pair");
            let history = complete(scene, 2);
            history.last().expect("a step").contact_force(1)[2]
        }
    }
}

/// A box of facets is the box, and as a rigid body of the same mesh. A ball of facets becomes the ball as they become smaller, as
/// fast as their chords come closer to it, and the rigid body of the same mesh, whose normals are averaged, with it.
#[test]
fn surfaces_are_what_they_are_made_of() {
    let slab = cuboid([-1.0, -1.0, -1.0], [2.0, 2.0, 0.5], [3, 4, 1]).expect("a mesh");
    let exact = Obstacle::cuboid([-1.0, -1.0, -1.0], [1.0, 1.0, -0.5]).expect("a box");
    let of_mesh = Obstacle::of_mesh(&slab).expect("a surface");
    let [exact, found, meshed] = [Ok(exact), Ok(of_mesh), Err(slab)].map(pressed_by);
    assert!(relative(found, exact) < 1e-9, "{found} {exact}");
    assert!(relative(found, meshed) < 1e-7, "{found} {meshed}");

    let ball = pressed_by(Ok(Obstacle::ball([0.0; 3], 1.0).expect("a ball")));
    let pressed = |mesh: &Mesh<3>| pressed_by(Ok(Obstacle::of_mesh(mesh).expect("a surface")));
    let [coarse, fine] = [5, 10].map(|shells| sphere(1.0, shells).expect("a mesh"));
    let off = [&coarse, &fine].map(|mesh| relative(pressed(mesh), ball));
    assert!(off[0] < 0.6 && off[1] < 0.3 * off[0], "{off:?}");
    let [found, meshed] = [pressed(&coarse), pressed_by(Err(coarse))];
    assert!(relative(found, meshed) < 3e-3, "{found} {meshed}");
}

/// A polygon that rises and turns is the half-plane behind its side, which does so.
#[test]
fn polygons_move() {
    let half = 0.75;
    let corners = [[-half, -0.5], [half, -0.5], [half, 0.0], [-half, 0.0]];
    let polygon = Obstacle::surface(&corners, &[[0, 1], [1, 2], [2, 3], [3, 0]]);
    let polygon = polygon.expect("a polygon");
    let run = |obstacle: Obstacle<2>| {
        let mesh = rectangle(
            &linspace(-0.5, 0.5, 6),
            &linspace(0.0, 1.0, 6),
            Diagonals::Rising,
        );
        let law = NeoHookean::new(100.0, 0.3).expect("a law");
        let mut block = Body::new(mesh.expect("a mesh"), law);
        block
            .prescribe("top", [Some(0.0), Some(0.0)])
            .expect("held");
        let up = Motion::translation([0.0, 0.1]).expect("a motion");
        let turn = Motion::<2>::rotation([0.0, 0.0], 0.05).expect("a motion");
        let mut scene = Scene::new();
        let side = scene.add("block", block).on("bottom");
        let placed = scene.obstacle("table", side, obstacle.moving(up.then(turn)));
        placed.expect("an obstacle");
        complete(scene, 4)
    };
    let found = run(polygon);
    let exact = run(Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a line"));
    let (u, v) = (&found.run.state.u, &exact.run.state.u);
    let apart = u.iter().zip(v).map(|(u, v)| (u - v).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-10);
    let [a, b] = [&found, &exact].map(|history| history.last().expect("a step"));
    let [a, b] = [a, b].map(|step| step.obstacle_forces[0]);
    assert!(
        (a - b).norm() < 1e-8 * b.norm() && b.norm() > 1.0,
        "{a} {b}"
    );
}
