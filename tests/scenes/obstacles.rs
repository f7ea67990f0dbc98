//! Rigid obstacles without a mesh, against meshed rigid bodies, analytic solutions and other solvers.

use crate::common::relative;
use crate::hertz::assert_profile;
use contact_core::{CondensedNewton, InteriorPoint, Retry};
use contact_fem::audit::Overlap;
use contact_fem::certificate::Condition;
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, cuboid, equilateral_disc, linspace, rectangle};
use contact_fem::model::{Corners, Integration, Opposite, Overlaps, Problem};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean, Obstacle, Scene, Simulation};
use ipopt_contact_scenes::hertz::{FORCE, Fineness, Hertz};
use ipopt_contact_scenes::{arch, tight};

/// Full load in `increments`, under a tight certificate.
fn complete<const D: usize>(scene: Scene<D>, increments: usize) -> (Problem<D>, History<D>) {
    let mut problem = scene.problem().expect("a sound scene");
    let history = Simulation::with_increments(increments).run(&mut problem);
    let history = history.expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    (problem, history)
}

/// The displacements of the first body in two runs, relative to the largest.
fn apart<const D: usize>(runs: [&(Problem<D>, History<D>); 2]) -> f64 {
    let [a, b] = runs.map(|(problem, history)| {
        let U = problem.displacements(&history.run.state.u);
        U[problem.nodes(0)].to_vec()
    });
    let largest = b.iter().fold(0.0, |m: f64, u| m.max(u.amax()));
    let apart = a.iter().zip(&b).map(|(a, b)| (a - b).amax());
    apart.fold(0.0, f64::max) / largest
}

/// A block pressed on a rigid plate does not come through, however thin that is: the energy is that on a thick one, or the run
/// does not complete.
#[test]
fn thin_plates() {
    let energy = |thickness: f64, increments: usize| {
        let line = || linspace(0.0, 1.0, 4);
        let mesh = rectangle(&line(), &line(), Diagonals::Rising).expect("a mesh");
        let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("a law"));
        block
            .prescribe("top", [Some(0.0), Some(-0.3)])
            .expect("a support");
        let mut scene = Scene::new();
        let block = scene.add("block", block);
        let plate = Obstacle::cuboid([-1.0, -thickness], [2.0, 0.0]).expect("a plate");
        let side = block.on("bottom");
        scene.obstacle("plate", side, plate).expect("a side");
        let mut problem = scene.problem().expect("a sound scene");
        let history = Simulation::with_increments(increments).run(&mut problem);
        let history = history.expect("no misuse");
        let last = history.last().filter(|_| history.is_complete());
        last.map(|last| last.energy)
    };
    let thick = energy(0.5, 2).expect("complete");
    assert!(thick > 1.0, "{thick}");
    for thickness in [0.1, 0.03, 0.01, 0.001] {
        for increments in [1, 2, 10] {
            let found = energy(thickness, increments);
            let is_right = found.is_none_or(|found| (found / thick - 1.0).abs() < 1e-8);
            assert!(is_right, "{thickness} {increments}: {found:?} for {thick}");
        }
    }
    assert!(energy(0.03, 2).is_some(), "steps are cut");
}

/// The arch on a half-space is the arch on a meshed foundation, with as many rows and fewer nodes.
#[test]
fn signorini_is_that_of_a_meshed_foundation() {
    let meshed = complete(arch::scene(3).expect("a scene"), 1);
    let found = complete(arch::on_obstacle(3).expect("a scene"), 1);
    assert!(apart([&found, &meshed]) < 1e-9);
    let [a, b] = [&found, &meshed].map(|(_, history)| history.last().expect("a step"));
    assert!(relative(a.energy, b.energy) < 1e-10);
    assert!(a.rows <= b.rows, "{} {}", a.rows, b.rows);
    assert!((a.obstacle_forces[0] - b.contact_force(1)).norm() < 1e-9 * b.contact_force(1).norm());
    assert!(a.attempt.cost.factorizations <= b.attempt.cost.factorizations);
    assert!(found.0.reference().len() < meshed.0.reference().len());
    assert_eq!(found.0.surfaces().len() + 1, meshed.0.surfaces().len());
}

/// Hertz's cylinder on a rigid plane: as on a mesh that does not move, and with the analytic pressure.
#[test]
fn hertz_on_a_half_plane() {
    let fineness = Fineness {
        in_contact: 10.0,
        on_arc: 34,
    };
    let hertz = Hertz {
        young: [210.0, f64::INFINITY],
        // on obstacles, there are Gauss points alone
        integration: Some(Integration::Gauss(12)),
        ..Hertz::new(fineness, Order::Quadratic)
    };
    let [meshed, found] = [true, false].map(|is_meshed| {
        let scene = hertz.on_rigid(is_meshed).expect("a scene");
        complete(scene, 1)
    });
    assert!(apart([&found, &meshed]) < 1e-9);
    let (problem, history) = &found;
    let step = history.last().expect("a step");
    let force = step.obstacle_forces[0][1];
    assert!(relative(force, -0.5 * FORCE) < 1e-9, "{force}");
    assert!(step.rows <= meshed.1.last().expect("a step").rows);
    let solution = history.run.solution.as_ref().expect("converged");
    let pressures = problem
        .pressures(&history.run.state.u, &solution.gaps, &solution.lambda)
        .expect("pressures");
    let (surface, pressure) = (&problem.surfaces()[0], &pressures[0]);
    let x = |k: usize| problem.reference()[surface.nodes()[k]][0];
    let p0 = hertz.peak_pressure();
    assert_profile(&hertz, (0..pressure.len()).map(|k| (x(k), pressure[k])));
    let centre = (0..pressure.len()).min_by(|&i, &j| x(i).abs().total_cmp(&x(j).abs()));
    let peak = pressure[centre.expect("nodes")];
    assert!(relative(peak, p0) < 0.02, "{peak} for {p0}");
}

fn plane() -> Obstacle<3> {
    Obstacle::half_space([0.0; 3], [0.0, 0.0, 1.0]).expect("a plane")
}

/// A free cube on a plane, by its weight: the plane carries all of it, and what nothing determines is told, and stays.
#[test]
fn a_block_rests_on_a_plane_by_its_weight() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3]).expect("mesh");
    let mut block = Body::new(mesh, LinearElastic::new(100.0, 0.0).expect("law"));
    block.body_force([0.0, 0.0, -0.3]).expect("weight");
    let mut scene = Scene::new();
    let side = scene.add("block", block).on("bottom");
    let plane = scene.obstacle("plane", side, plane()).expect("a side");
    let (problem, history) = complete(scene, 2);
    let step = history.last().expect("a step");
    let force = step.obstacle_force(plane);
    let weight = Vector::<3>::new(0.0, 0.0, -0.3);
    assert!((force - weight).norm() < 1e-10, "{force}");
    assert!((step.contact_force(0) + force).norm() < 1e-10);
    let [pair] = &step.pairs[..] else {
        panic!("{:?}", step.pairs);
    };
    assert_eq!(pair.second, Opposite::Obstacle(plane));
    assert!((pair.resultant + weight).norm() < 1e-10 && (pair.area - 1.0).abs() < 1e-12);
    // below the middle, but for what its nodes, which do not carry equal shares of the weight, move sideways
    let sideways = |x: &Vector<3>| x.xy().norm();
    let moved = problem.displacements(&history.run.state.u);
    let moved = moved.iter().map(sideways).fold(0.0, f64::max);
    let centre = pair.centre.expect("a force") - Vector::<3>::new(0.5, 0.5, 0.0);
    assert!(moved < 1e-4 && sideways(&centre) <= moved, "{centre}");
    // ρ L, as far as three linear cells show it
    assert!(
        step.pressures.iter().all(|p| relative(*p, 0.3) < 0.05),
        "{:?}",
        step.pressures
    );
    let solution = history.run.solution.as_ref().expect("converged");
    // one factorisation, although the rows' displacements are zero
    assert!(solution.failed.is_empty(), "{:?}", solution.failed);
    let undetermined = problem.undetermined(solution);
    assert_eq!(undetermined.len(), 1, "{undetermined:?}");
    let motions = ["translation x", "translation y", "rotation about z"];
    assert_eq!(undetermined[0].motions, motions);
    let U = problem.displacements(&history.run.state.u);
    let mean = U.iter().sum::<Vector<3>>() / U.len() as f64;
    assert!(mean[0].abs() < 1e-6 && mean[1].abs() < 1e-6, "{mean}");
}

/// A large-strain block on a plane, held aside: its top goes down by ρ L²/2E.
#[test]
fn a_heavy_block_is_shortened() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [1, 1, 2])
        .expect("mesh")
        .quadratic();
    let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.0).expect("law"));
    block.body_force([0.0, 0.0, -0.3]).expect("weight");
    for axis in 0..2 {
        let nodes = block.mesh().nodes().iter().enumerate();
        let aside: Vec<usize> = nodes
            .filter(|(_, X)| X[axis] == 0.0)
            .map(|(a, _)| a)
            .collect();
        let held = std::array::from_fn(|i| (i == axis).then_some(0.0));
        block.prescribe_nodes(&aside, held).expect("support");
    }
    let mut scene = Scene::new();
    let side = scene.add("block", block).on("bottom");
    scene.obstacle("plane", side, plane()).expect("a side");
    let (problem, history) = complete(scene, 1);
    let U = problem.displacements(&history.run.state.u);
    let nodes = problem.reference().iter().zip(&U);
    let mut top = nodes.filter(|(X, _)| X[2] == 1.0).map(|(_, u)| u[2]);
    assert!(top.all(|u| relative(u, -0.3 / 200.0) < 0.01));
}

fn disc() -> Mesh<2> {
    let disc = equilateral_disc(1.0, 8).expect("mesh");
    disc.quadratic()
        .curved("boundary", contact_fem::mesh::generators::onto_sphere(1.0))
        .expect("mesh")
}

/// A soft disc in a cavity that is little wider: contact spreads over a wide angle. Newton's method, on the derivatives of
/// the distance, finds in few iterations what the paper's algorithm finds around Ipopt.
#[test]
fn a_disc_in_a_cavity() {
    let scene = || {
        let mut body = Body::new(disc(), NeoHookean::new(10.0, 0.3).expect("law"));
        body.body_force([0.0, -1.0]).expect("weight");
        let middle = body.mesh().nodes().iter().enumerate();
        let middle: Vec<usize> = middle
            .filter(|(_, X)| X[0].abs() < 1e-12)
            .map(|(a, _)| a)
            .collect();
        body.prescribe_nodes(&middle, [Some(0.0), None])
            .expect("symmetry");
        let mut scene = Scene::new();
        let side = scene.add("disc", body).on("boundary");
        let cavity = Obstacle::cavity([0.0, 0.05], 1.05).expect("a cavity");
        scene.obstacle("cavity", side, cavity).expect("a side");
        scene
    };
    let mut problem = scene().problem().expect("a scene");
    let newton = Simulation::solved_by(CondensedNewton::default(), 2).run(&mut problem);
    let newton = newton.expect("no misuse");
    assert!(newton.is_complete(), "{}", newton.run.ending);
    assert_eq!(newton.run.cuts(), 0);
    let certificate = newton.certificate().expect("steps");
    assert!(certificate.holds(&tight()), "{certificate}");
    let iterations = newton
        .steps
        .iter()
        .map(|step| step.attempt.iterations.len());
    let iterations: Vec<usize> = iterations.collect();
    assert!(
        iterations.iter().all(|count| *count <= 10),
        "{iterations:?}"
    );

    let method = InteriorPoint {
        complementarity: 1e-12,
        ..InteriorPoint::default()
    };
    let mut solver = Retry::with(method);
    solver.fixed_point.tolerance = 1e-9;
    let mut problem = scene().problem().expect("a scene");
    let other = Simulation::solved_by(solver, 2).run(&mut problem);
    let other = other.expect("no misuse");
    assert!(other.is_complete(), "{}", other.run.ending);
    let [a, b] = [&newton, &other].map(|history| history.last().expect("a step"));
    assert!(
        relative(a.energy, b.energy) < 1e-8,
        "{} {}",
        a.energy,
        b.energy
    );
    let weight = a.obstacle_forces[0][1];
    assert!(relative(weight, -std::f64::consts::PI) < 1e-3, "{weight}");
    // contact over more than 20 degrees to either side
    let solution = newton.run.solution.as_ref().expect("converged");
    let x = problem.reference();
    let holds = solution.gaps.keys().iter().zip(&solution.lambda);
    let widest = holds
        .filter(|(_, l)| **l > 1e-6)
        .map(|(key, _)| x[key.node as usize][0]);
    assert!(widest.fold(0.0, f64::max) > 0.34);
}

/// A soft block is pressed on a rigid box that is narrower, by 8 facets to either side of the middle. On a meshed box, points
/// beyond its end do not count, and on the obstacle they are above its edge, which digs in by a share of a facet: by less where it is held.
#[test]
fn a_block_on_a_box() {
    let force = |cells: usize, is_meshed: bool, corners: Corners| {
        let lines = [(-1.0, cells), (0.0, cells / 2)].map(|(low, n)| linspace(low, 1.0, n));
        let mesh = rectangle(&lines[0], &lines[1], Diagonals::Alternating);
        let mut block = Body::new(
            mesh.expect("mesh"),
            NeoHookean::new(10.0, 0.3).expect("law"),
        );
        let down = [Some(0.0), Some(-0.1)];
        block.prescribe("top", down).expect("support");
        let mut scene = Scene::new();
        let side = scene.add("block", block).on("bottom");
        if is_meshed {
            let mesh = rectangle(&[-0.412, 0.412], &[-1.0, 0.0], Diagonals::Rising).expect("mesh");
            let mut punch = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("law"));
            punch.prescribe_all([Some(0.0); 2]).expect("support");
            let top = scene.add("box", punch).on("top");
            scene.contact(side, top).expect("a pair");
        } else {
            let punch = Obstacle::cuboid([-0.412, -1.0], [0.412, 0.0]).expect("a box");
            scene.obstacle("box", side, punch).expect("a side");
        }
        scene.corners = corners;
        let (_, history) = complete(scene, 4);
        let step = history.last().expect("a step");
        match is_meshed {
            true => step.contact_force(1),
            false => step.obstacle_forces[0],
        }
    };
    let [found, meshed] = [false, true].map(|is_meshed| force(40, is_meshed, Corners::Weak));
    let held = force(40, false, Corners::Held);
    println!("weak {found} held {held} meshed {meshed}");
    assert!(held[1].abs() > found[1].abs(), "{held} {found}");
    assert!(relative(held[1], meshed[1]) < 0.06, "{held} {meshed}");
    assert!(
        found[0].abs() < 1e-3 * found[1].abs(),
        "by symmetry: {found}"
    );
    assert!(found[1].abs() < meshed[1].abs(), "{found} {meshed}");
    assert!(relative(found[1], meshed[1]) < 0.06, "{found} {meshed}");
}

/// What the search cannot see the audit does: a side of the body that is not declared goes into the obstacle.
#[test]
fn the_audit_sees_the_sides_that_are_not_declared() {
    let scene = |overlaps: Overlaps| {
        let mesh = rectangle(
            &linspace(0.0, 1.0, 4),
            &linspace(0.0, 1.0, 4),
            Diagonals::Rising,
        );
        let mut block = Body::new(
            mesh.expect("mesh"),
            NeoHookean::new(10.0, 0.3).expect("law"),
        );
        block
            .prescribe("top", [Some(0.3), Some(0.0)])
            .expect("support");
        let mut scene = Scene::new();
        let side = scene.add("block", block).on("bottom");
        // beside the block
        let ball = Obstacle::ball([1.45, 0.7], 0.4).expect("a disc");
        scene.obstacle("ball", side, ball).expect("a side");
        scene.overlaps = overlaps;
        scene
    };
    let mut problem = scene(Overlaps::Allowed).problem().expect("a scene");
    let history = Simulation::with_increments(2)
        .run(&mut problem)
        .expect("no misuse");
    let certificate = history.certificate().expect("steps");
    let overlap = certificate.left(Condition::Overlap).expect("applies");
    assert!(overlap > Overlap::<2>::LIMIT, "{overlap}");
    assert!(certificate.left(Condition::Unopposed).expect("applies") > 0.3);
    let deepest = problem
        .audit(&history.run.state.u)
        .expect("a state")
        .overlaps;
    assert_eq!(deepest.len(), 1);
    assert_eq!(
        deepest[0].bodies,
        [0, 1],
        "obstacles are numbered after the bodies"
    );
    assert!(deepest[0].depth > 0.1, "{deepest:?}");

    let mut problem = scene(Overlaps::Refused).problem().expect("a scene");
    let history = Simulation::with_increments(2)
        .run(&mut problem)
        .expect("no misuse");
    assert!(!history.is_complete());
    let why = history.run.ending.to_string();
    assert!(
        why.contains("body `block`") && why.contains("obstacle `ball`"),
        "{why}"
    );
}

/// A plate is moved through a thin rod in one step. Its ends show nothing; the way does.
#[test]
fn a_body_does_not_go_through_an_obstacle() {
    for (way, passes) in [(-1.0, true), (-0.05, false)] {
        let mesh = rectangle(
            &linspace(0.0, 1.0, 10),
            &linspace(0.2, 0.3, 1),
            Diagonals::Rising,
        );
        let mut plate = Body::new(
            mesh.expect("mesh"),
            NeoHookean::new(10.0, 0.3).expect("law"),
        );
        plate
            .prescribe("left", [Some(0.0), Some(way)])
            .expect("support");
        plate
            .prescribe("right", [Some(0.0), Some(way)])
            .expect("support");
        let mut scene = Scene::new();
        let side = scene.add("plate", plate).on("bottom");
        let rod = Obstacle::ball([0.5, 0.0], 0.1).expect("a rod");
        scene.obstacle("rod", side, rod).expect("a side");
        let mut problem = scene.problem().expect("a scene");
        contact_core::LoadStepped::set_load(&mut problem, 1.0).expect("a load");
        let u = vec![0.0; problem.dofs().free()];
        let lifted = contact_core::LoadStepped::lift(&problem, &u, 0.0);
        let passage = contact_core::LoadStepped::tunnels(&problem, &lifted, &u, 0.0);
        assert_eq!(passage.is_some(), passes, "{passage:?}");
    }
}
