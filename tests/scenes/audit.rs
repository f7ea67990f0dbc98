//! States that the contact search takes for solutions and that are none: whatever is called complete with a certificate
//! that holds is right.

use crate::common::{relative, run};
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Geometry, Problem, Scene};
use contact_fem::simulation::History;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean};
use ipopt_contact_scenes::pair;

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
    let mesh = rectangle(&line(0), &line(1), Diagonals::Alternating);
    let mut mesh = mesh.expect("mesh");
    let top = low[1] + size[1];
    mesh.name_boundary("faces", |x| x[1] == low[1] || x[1] == top);
    mesh.name_boundary("all", |_| true);
    mesh
}

fn soft<const D: usize>(mesh: Mesh<D>) -> Body<D>
where
    contact_fem::element::P1: contact_fem::element::Element<D>,
    contact_fem::element::P2: contact_fem::element::Element<D>,
{
    Body::new(mesh, NeoHookean::new(1e3, 0.0).expect("law"))
}

/// A body of one triangle.
fn triangle(x: [[f64; 2]; 3]) -> Body<2> {
    let mut mesh = Mesh::new(x.to_vec(), vec![0, 1, 2]).expect("mesh");
    mesh.name_boundary("all", |_| true);
    soft(mesh)
}

/// Whether a run says that it is right: complete, and every certificate holds.
fn claims<const D: usize>(history: &History<D>) -> bool {
    let certificate = history.certificate();
    history.is_complete() && certificate.is_some_and(|c| c.holds(&Default::default()))
}

/// Slabs of thickness `t` on each other, each with both faces declared, pressed by 2 % of `t` a slab.
fn slabs(count: usize, t: f64, increments: usize) -> (Problem<2>, History<2>) {
    let mut scene = Scene::new();
    let mut ids = Vec::new();
    for k in 0..count {
        let mut slab = soft(block([0.0, k as f64 * t], [1.0, t], [10, 1]));
        let held = |move_by: f64| [Some(0.0), Some(move_by)];
        if k == 0 {
            slab.prescribe("bottom", held(0.0)).expect("support");
        }
        if k == count - 1 {
            let press = -0.02 * t * count as f64;
            slab.prescribe("top", held(press)).expect("support");
        }
        ids.push(scene.add(format!("slab {k}"), slab));
    }
    for &id in &ids {
        scene.contact_surface(id.on("faces")).expect("surface");
    }
    let mut problem = scene.problem().expect("a valid scene");
    let history = run(&mut problem, increments, 1e-8);
    (problem, history)
}

/// However thin slabs are against their facets: stress E·2 % to first order, in all of them.
#[test]
fn thin_slabs_carry_pressure() {
    for (count, t) in [(2, 0.04), (2, 0.004), (2, 0.002), (2, 5e-4), (3, 1e-3)] {
        let (_, history) = slabs(count, t, 1);
        assert!(claims(&history), "{count} of {t}: {}", history.run.ending);
        let force = history.last().expect("converged").reaction(0)[1];
        assert!(relative(force, 20.0) < 0.05, "{count} of {t}: {force}");
    }
}

/// Two bars cross, one above the other, and are pushed through each other edge on edge.
#[test]
fn bars_do_not_pass_through_each_other() {
    for (along, increments) in [(2, 1), (2, 4), (3, 1), (5, 1)] {
        let bar = |low: [f64; 3], size: [f64; 3], cells: [usize; 3]| {
            let mut mesh = cuboid(low, size, cells).expect("mesh");
            mesh.name_boundary("all", |_| true);
            mesh.name_boundary("ends", |x| {
                (0..2).any(|i| size[i] > 1.0 && (x[i] == low[i] || x[i] == low[i] + size[i]))
            });
            soft(mesh)
        };
        let mut lower = bar([-2.0, -0.1, -0.2], [4.0, 0.2, 0.2], [along, 1, 1]);
        let mut upper = bar([-0.1, -2.0, 0.05], [0.2, 4.0, 0.2], [1, along, 1]);
        lower.prescribe("ends", [Some(0.0); 3]).expect("support");
        let down = [Some(0.0), Some(0.0), Some(-0.6)];
        upper.prescribe("ends", down).expect("support");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower);
        let upper = scene.add("upper", upper);
        scene
            .contact(lower.on("all"), upper.on("all"))
            .expect("surfaces");
        let mut problem = scene.problem().expect("a valid scene");
        let history = run(&mut problem, increments, 1e-8);
        if claims(&history) {
            let force = history.last().expect("converged").contact_force(upper)[2];
            assert!(
                force > 1.0,
                "{along} cells, {increments} increments: {force}"
            );
        }
    }
}

/// One triangle is pushed with its tip past an acute rim, in one to twenty increments. The mean gap over facets as long
/// as the bodies may stay open while the tip is inside, so that no force acts: that is not certified.
#[test]
fn a_tip_past_an_acute_rim() {
    let past = |lower: [[f64; 2]; 3], tip: [[f64; 2]; 3], by: f64, increments: usize| {
        let (mut lower, mut tip) = (triangle(lower), triangle(tip));
        lower
            .prescribe_nodes(&[0, 2], [Some(0.0); 2])
            .expect("support");
        tip.prescribe_nodes(&[1, 2], [Some(0.0), Some(-by)])
            .expect("support");
        let scene = pair((lower, "all"), (tip, "all")).expect("surfaces");
        let mut problem = scene.problem().expect("a valid scene");
        let history = run(&mut problem, increments, 1e-8);
        let force = history.last().map_or(0.0, |step| step.contact_force(1)[1]);
        assert!(!claims(&history) || force > 1e-3, "{increments}: {force}");
    };
    for increments in [1, 4, 20] {
        let lower = [[0.0, -1.0], [1.0, 0.0], [0.0, -0.4]];
        past(
            lower,
            [[0.93, 0.05], [1.4, 1.0], [0.5, 1.0]],
            0.5,
            increments,
        );
        let lower = [[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]];
        for x in [0.8, 0.93] {
            past(
                lower,
                [[x, 0.05], [x + 0.4, 1.0], [x - 0.4, 1.0]],
                0.3,
                increments,
            );
        }
    }
}

/// Two triangles face each other across a gap and are pushed into each other in a single step longer than the reach.
#[test]
fn a_step_longer_than_the_reach() {
    let mut lower = triangle([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]);
    let mut upper = triangle([[0.5, 1.1], [1.0, 2.1], [0.0, 2.1]]);
    lower
        .prescribe_nodes(&[0, 1], [Some(0.0); 2])
        .expect("support");
    upper
        .prescribe_nodes(&[1, 2], [Some(0.0), Some(-0.5)])
        .expect("support");
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower);
    let upper = scene.add("upper", upper);
    scene
        .contact(lower.on("all"), upper.on("all"))
        .expect("surfaces");
    let mut problem = scene.problem().expect("a valid scene");
    let history = run(&mut problem, 1, 1e-8);
    let force = history
        .last()
        .map_or(0.0, |step| step.contact_force(upper)[1]);
    assert!(!claims(&history) || force > 0.0, "{force}");
}

/// A block is pushed sideways off the declared part of a floor and down onto the part that is not.
#[test]
fn surfaces_that_are_not_declared() {
    let mut mesh = block([0.0, -1.0], [4.0, 1.0], [8, 2]);
    mesh.name_boundary("left half", |x| x[1] == 0.0 && x[0] <= 2.0);
    let mut floor = soft(mesh);
    floor.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mut upper = soft(block([0.5, 0.02], [1.0, 1.0], [3, 3]));
    upper
        .prescribe("top", [Some(2.2), Some(-0.4)])
        .expect("support");
    let mut scene = Scene::new();
    let floor = scene.add("floor", floor);
    let upper = scene.add("upper", upper);
    scene
        .contact(floor.on("left half"), upper.on("bottom"))
        .expect("surfaces");
    let mut problem = scene.problem().expect("a valid scene");
    let history = run(&mut problem, 10, 1e-8);
    assert!(!claims(&history));
    let why = history.run.ending.to_string();
    assert!(why.contains("`floor`") && why.contains("declare"), "{why}");
}

/// One coarse body beside two fine ones that are pushed through each other.
#[test]
fn a_coarse_bystander_hides_nothing() {
    let mut lower = soft(block([0.0, 0.0], [1.0, 0.05], [10, 1]));
    lower.prescribe_all([Some(0.0); 2]).expect("support");
    let mut upper = soft(block([0.2, 0.1], [0.5, 0.05], [5, 1]));
    upper
        .prescribe_all([Some(0.0), Some(-0.3)])
        .expect("support");
    let mut coarse = soft(block([3.0, 0.0], [9.0, 9.0], [1, 1]));
    coarse.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mut scene = Scene::new();
    let ids = [("lower", lower), ("upper", upper), ("coarse", coarse)];
    let [lower, upper, coarse] = ids.map(|(name, body)| scene.add(name, body));
    for (a, b) in [(lower, upper), (upper, coarse)] {
        scene.contact(a.on("all"), b.on("all")).expect("surfaces");
    }
    let mut problem = scene.problem().expect("a valid scene");
    assert!(!claims(&run(&mut problem, 1, 1e-8)));
}

/// Linear laws where strains or rotations are not small, or bodies are carried into others.
#[test]
fn laws_for_small_strains_beyond_them() {
    let linear = |mesh| Body::new(mesh, LinearElastic::new(1e3, 0.3).expect("law"));
    let beam = |load: f64| {
        let mut beam = linear(block([0.0, 0.0], [8.0, 1.0], [16, 2]));
        beam.prescribe("left", [Some(0.0); 2]).expect("support");
        beam.traction("top", [0.0, -load]).expect("load");
        Scene::of(vec![beam])
    };
    let pressed = |by: f64| {
        let mut block = linear(block([0.0, 0.0], [1.0, 1.0], [4, 4]));
        block.prescribe("bottom", [Some(0.0); 2]).expect("support");
        block
            .prescribe("top", [Some(0.0), Some(-by)])
            .expect("support");
        Scene::of(vec![block])
    };
    let carried = |by: f64| {
        let mut wall = linear(block([3.0, 0.0], [1.0, 1.0], [4, 4]));
        wall.prescribe_all([Some(0.0); 2]).expect("support");
        let mut cart = linear(block([0.0, 0.0], [1.0, 1.0], [4, 4]));
        cart.prescribe_all([Some(by), Some(0.0)]).expect("support");
        let mut other = linear(block([0.0, 9.0], [1.0, 1.0], [1, 1]));
        other.prescribe("bottom", [Some(0.0); 2]).expect("support");
        Scene::of(vec![wall, cart, other])
    };
    for (scene, is_small) in [
        (beam(1e-3), true),
        (beam(10.0), false),
        (pressed(0.02), true),
        (pressed(1.5), false),
        (carried(1.0), true),
        (carried(2.5), false),
    ] {
        let mut problem = scene.problem().expect("a valid scene");
        assert_eq!(problem.geometry(), Geometry::Reference);
        let history = run(&mut problem, 1, 1e-8);
        assert!(history.is_complete());
        assert_eq!(
            claims(&history),
            is_small,
            "{}",
            history.certificate().expect("steps")
        );
    }
}

/// A block that a sideways load pushes along a floor without friction has no equilibrium: the ending names the motion that
/// nothing holds. The same block held by one node stays.
#[test]
fn a_body_that_slides_is_named() {
    let scene = |is_held: bool| {
        let mut floor = soft(block([-2.0, -1.0], [6.0, 1.0], [12, 2]));
        floor.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let mut sledge = soft(block([0.0, 0.0], [1.0, 1.0], [3, 3]));
        sledge.body_force([2.0, -10.0]).expect("load");
        if is_held {
            sledge
                .prescribe_nodes(&[0], [Some(0.0), None])
                .expect("support");
        }
        let mut scene = Scene::new();
        let floor = scene.add("floor", floor);
        let sledge = scene.add("sledge", sledge);
        scene
            .contact(floor.on("top"), sledge.on("bottom"))
            .expect("surfaces");
        scene.problem().expect("a valid scene")
    };
    let history = run(&mut scene(true), 1, 1e-8);
    assert!(history.is_complete(), "{}", history.run.ending);
    let history = run(&mut scene(false), 1, 1e-8);
    let ending = history.run.ending.to_string();
    assert!(!history.is_complete());
    assert!(
        ending.contains("hold body `sledge`: translation x"),
        "{ending}"
    );
}
