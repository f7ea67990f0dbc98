//! The recovered contact pressure against analytic ones, and what it keeps of the forces.

use contact_core::equilibrium::Solution;
use contact_fem::contact::Integration;
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Passes, Problem};
use contact_fem::output::Snapshot;
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, NeoHookean, Obstacle, Scene, Simulation};
use ipopt_contact_scenes::ball::{Ball, CONTACT_RADIUS};
use ipopt_contact_scenes::disc_in_disc;
use ipopt_contact_scenes::hertz::{Fineness, Hertz};
use ipopt_contact_scenes::pressure::{error, integral};

use crate::common::relative;

fn solved<const D: usize>(scene: Scene<D>) -> (Problem<D>, Solution) {
    let mut problem = scene.problem().expect("valid scene");
    let history = Simulation::with_increments(1).run(&mut problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let solution = history.run.solution.expect("converged");
    (problem, solution)
}

/// The errors of the recovered and of the consistent field on the ball.
fn on_the_ball(in_contact: usize, order: Order) -> [f64; 2] {
    let scene = Ball { in_contact, order }.scene().expect("a scene");
    let (problem, solution) = solved(scene);
    let (u, p0) = (&solution.state.u, Ball::peak_pressure());
    let (gaps, lambda) = (&solution.gaps, &solution.lambda);
    let fields = [
        problem.pressures(u, gaps, lambda).expect("pressures"),
        problem
            .consistent_pressures(u, gaps, lambda)
            .expect("pressures"),
    ];
    assert!(fields[0].iter().flatten().all(|p| *p >= 0.0), "it pulls");
    let ball = &problem.surfaces()[0];
    let exact = |X: &Vector<3>| {
        let r = X.xy().norm() / CONTACT_RADIUS;
        p0 * (1.0 - r * r).max(0.0).sqrt()
    };
    // the resultant of the field, from its integral over the curved surface, and that of the quarter of the load
    let force = integral(ball, &fields[0][0], |w, p, _, n| -w * p * n[2]);
    assert!(relative(force, 0.25 * Ball::force()) < 2e-2, "{force}");
    fields.map(|field| error(ball, &field[0], exact))
}

/// The errors of P1 on facets of a half and a third of the contact radius are about half of those of the consistent field,
/// and smaller than those of GetFEM's augmented Lagrangian on these meshes with r = E (0.301 and 0.253).
#[test]
fn a_ball_of_linear_elements() {
    for (in_contact, limit) in [(2, 0.301), (3, 0.253)] {
        let [recovered, consistent] = on_the_ball(in_contact, Order::Linear);
        assert!(recovered < limit, "{recovered} with {in_contact}");
        assert!(recovered < 0.65 * consistent, "{recovered} {consistent}");
    }
}

/// Quadratic triangles have linear multipliers; the gaps of their middle nodes tell the rest. On these meshes GetFEM's augmented
/// Lagrangian with quadratic multipliers has errors of 0.137 and 0.109 with r = E/10, and 0.126 and 0.102 with r = E.
#[test]
fn a_ball_of_quadratic_elements() {
    for (in_contact, peer) in [(2, 0.126), (3, 0.102)] {
        let [recovered, consistent] = on_the_ball(in_contact, Order::Quadratic);
        assert!(recovered < peer, "{recovered}");
        assert!(recovered < 0.75 * consistent, "{recovered} {consistent}");
    }
}

/// A cylinder on a block with a/R = 0.12, by one pass or both: on both bodies, the pressure in the middle is Hertz's within
/// 1 %, and nowhere negative or more than 5 % above it. The consistent field pulls by 12 % with the finer mesh.
#[test]
fn the_middle_of_two_elastic_bodies() {
    for in_contact in [8, 11, 16, 22] {
        for passes in [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave] {
            let hertz = Hertz {
                force: 35.0,
                passes,
                ..Hertz::new(Fineness::family(in_contact), Order::Quadratic)
            };
            let p0 = hertz.peak_pressure();
            let (problem, solution) = solved(hertz.scene().expect("a scene"));
            let fields = problem.pressures(&solution.state.u, &solution.gaps, &solution.lambda);
            let fields = fields.expect("pressures");
            for (surface, field) in problem.surfaces().iter().zip(&fields) {
                let X = |a: usize| problem.reference()[surface.nodes()[a]];
                let nodes = 0..field.len();
                let middle = nodes.min_by(|&a, &b| X(a)[0].abs().total_cmp(&X(b)[0].abs()));
                let middle = field[middle.expect("nodes")];
                assert!(relative(middle, p0) < 0.01, "{middle} for {p0}: {passes:?}");
                let inside = field.iter().all(|p| (0.0..=1.05 * p0).contains(p));
                assert!(inside, "{passes:?} on a/{in_contact}: {field:?}");
            }
        }
    }
}

/// Two blocks under a load that grows along their common face, of meshes that do not match: on each of them the field has
/// resultant and moment of the nodal forces.
#[test]
fn resultant_and_moment_are_those_of_the_forces() {
    for n in [1, 2] {
        let block = |y: f64, cells: usize| {
            let x = linspace(0.0, 2.0, cells);
            let mesh = rectangle(&x, &linspace(y, y + 1.0, 4 * n), Diagonals::Rising);
            Body::new(
                mesh.expect("mesh"),
                LinearElastic::new(100.0, 0.3).expect("law"),
            )
        };
        let (mut lower, mut upper) = (block(-1.0, 8 * n), block(0.0, 6 * n));
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        upper.prescribe("left", [Some(0.0), None]).expect("support");
        let load = |X: &Vector<2>| Vector::<2>::new(0.0, -1.0 - 0.25 * X[0]);
        upper.traction_field("top", load).expect("load");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower).on("top");
        let upper = scene.add("upper", upper).on("bottom");
        scene.contact(lower, upper).expect("a pair");
        let (problem, solution) = solved(scene);
        let u = &solution.state.u;
        let states = problem.pair_states(u, &solution.gaps, &solution.lambda);
        let states = states.expect("a state");
        let [state] = &states[..] else {
            panic!("one pair");
        };
        // ∫ (1 + x/4) dx over 0 to 2; the upper one is on the lower one everywhere
        let force: f64 = state.record.resultant[1];
        assert!(relative(force, -2.5) < 1e-6, "{force}");
        assert!(relative(state.record.area, 2.0) < 1e-9);
        for side in &state.sides {
            let surface = &problem.surfaces()[side.surface];
            let sum = integral(surface, &side.pressures, |w, p, _, n| -w * p * n[1]);
            // the moment is that of the forces ∫ N_a ds p_a on the nodes; with the facets' halves, N_a being linear
            let facets = surface.facets().zip(surface.reference());
            let halves = facets.flat_map(|(nodes, facet)| {
                let half = facet.normal(&Vector::<2>::repeat(0.5)) * 0.5;
                nodes.iter().map(move |&a| (a, half[1]))
            });
            let X = |a: usize| problem.reference()[surface.nodes()[a]][0];
            let moment: f64 = halves.map(|(a, n)| -n * side.pressures[a] * X(a)).sum();
            let forces = side.forces.iter().zip(surface.nodes());
            let expected: f64 = side.forces.iter().map(|f| f[1]).sum();
            let of_forces: f64 = forces.map(|(f, &a)| f[1] * problem.reference()[a][0]).sum();
            assert!(relative(sum, expected) < 1e-9, "{sum} {expected}");
            assert!(relative(moment, of_forces) < 1e-9, "{moment} {of_forces}");
        }
    }
}

/// A constant pressure on a flat face of tetrahedra that do not match, P1 and P2: it is that one, up to what quadrature does to
/// the forces.
#[test]
fn a_constant_pressure_is_constant() {
    for (order, limit) in [(Order::Linear, 5e-3), (Order::Quadratic, 5e-3)] {
        let block = |z: f64, cells: usize| {
            let mesh = cuboid([0.0, 0.0, z], [1.0, 1.0, 0.5], [cells, cells, 1]).expect("mesh");
            let mesh = match order {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            };
            let mut body = Body::new(mesh, LinearElastic::new(100.0, 0.0).expect("law"));
            body.prescribe("left", [Some(0.0), None, None])
                .expect("support");
            body.prescribe("front", [None, Some(0.0), None])
                .expect("support");
            body
        };
        let (mut lower, mut upper) = (block(0.0, 3), block(0.5, 2));
        lower
            .prescribe("bottom", [None, None, Some(0.0)])
            .expect("support");
        upper.traction("top", [0.0, 0.0, -2.0]).expect("load");
        let mut scene = Scene::new();
        let lower = scene.add("lower", lower).on("top");
        let upper = scene.add("upper", upper).on("bottom");
        scene.contact(lower, upper).expect("a pair");
        let (problem, solution) = solved(scene);
        let fields = problem.pressures(&solution.state.u, &solution.gaps, &solution.lambda);
        for p in fields.expect("pressures").iter().flatten() {
            assert!(relative(*p, 2.0) < limit, "{p}");
        }
    }
}

/// Two punches side by side on one base, so that two pairs press on the facet below their common edge: the pressure is the same
/// constant everywhere, and each pair has half of the area.
#[test]
fn pairs_that_share_a_facet_share_its_pressure() {
    for (cells, order) in [
        (7, Order::Linear),
        (15, Order::Linear),
        (31, Order::Linear),
        (7, Order::Quadratic),
        (31, Order::Quadratic),
    ] {
        let block = |x: [f64; 2], y: f64, cells: usize| {
            let x = linspace(x[0], x[1], cells);
            let mesh = rectangle(&x, &linspace(y, y + 1.0, 2), Diagonals::Rising).expect("mesh");
            let mesh = match order {
                Order::Linear => mesh,
                Order::Quadratic => mesh.quadratic(),
            };
            Body::new(mesh, LinearElastic::new(100.0, 0.0).expect("law"))
        };
        let mut scene = Scene::new();
        let mut base = block([0.0, 2.0], 0.0, cells);
        base.prescribe("bottom", [Some(0.0); 2]).expect("support");
        let base = scene.add("base", base).on("top");
        for (name, x, cells) in [("left", [0.0, 1.0], 5), ("right", [1.0, 2.0], 4)] {
            let mut punch = block(x, 1.0, cells);
            let down = [Some(0.0), Some(-0.02)];
            punch.prescribe("top", down).expect("support");
            let punch = scene.add(name, punch).on("bottom");
            scene.contact(base.clone(), punch).expect("a pair");
        }
        scene.integration = Some(Integration::Exact);
        let (problem, solution) = solved(scene);
        let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
        let fields = problem.pressures(u, gaps, lambda).expect("pressures");
        // both columns are shortened by a hundredth
        for p in fields.iter().flatten() {
            assert!((p - 1.0).abs() < 1e-5, "{cells} {order:?}: {p}");
        }
        for state in problem.pair_states(u, gaps, lambda).expect("a state") {
            let record = state.record;
            assert!(
                (record.area - 1.0).abs() < 1e-5 && (record.pressure_max - 1.0).abs() < 1e-5,
                "{cells} {order:?}: {record:?}"
            );
        }
    }
}

/// A block that nothing guides rests on the edges of a box under a load that grows along it: it rests in balance, the centre of
/// pressure below that of the load, though some nodal forces of quadratic facets pull.
#[test]
fn the_centre_of_pressure_is_below_that_of_the_load() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = rectangle(
            &linspace(-1.0, 1.0, 11),
            &linspace(0.0, 1.0, 6),
            Diagonals::Rising,
        );
        let mesh = match order {
            Order::Linear => mesh.expect("mesh"),
            Order::Quadratic => mesh.expect("mesh").quadratic(),
        };
        let mut block = Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("law"));
        // the first node is the corner at (−1, 0)
        block
            .prescribe_nodes(&[0], [Some(0.0), None])
            .expect("support");
        block
            .traction_field("top", |X| Vector::<2>::new(0.0, -1e-2 * (1.0 + 0.2 * X[0])))
            .expect("load");
        let mut scene = Scene::new();
        let block = scene.add("block", block).on("bottom");
        let tool = Obstacle::cuboid([-0.51, -1.0], [0.57, 0.0]).expect("a box");
        scene.obstacle("tool", block, tool).expect("a side");
        let (problem, solution) = solved(scene);
        let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
        let states = problem.pair_states(u, gaps, lambda).expect("a state");
        let centre = states[0].record.centre.expect("a force");
        // ∫ x (1 + x/5) dx over ∫ (1 + x/5) dx; displacements are some 1e-4 of the width
        assert!((centre[0] - 1.0 / 15.0).abs() < 1e-4, "{order:?}: {centre}");
    }
}

/// The areas of contact of Hertz' ball on a plane are πa² within a facet all around.
#[test]
fn the_area_of_contact_is_that_of_hertz() {
    for (in_contact, order) in [
        (2, Order::Linear),
        (3, Order::Linear),
        (2, Order::Quadratic),
        (3, Order::Quadratic),
    ] {
        let (problem, solution) = solved(Ball { in_contact, order }.scene().expect("a scene"));
        let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
        let states = problem.pair_states(u, gaps, lambda).expect("a state");
        // of a quarter
        let radius = (4.0 * states[0].record.area / std::f64::consts::PI).sqrt();
        let facet = 1.0 / in_contact as f64;
        assert!(
            (radius / CONTACT_RADIUS - 1.0).abs() < facet,
            "{in_contact} {order:?}: {radius}"
        );
    }
}

/// Rubber is pressed flat between two planes that let it spread: pressure times the current width is the force, and the area is the
/// current width.
#[test]
fn pressures_are_those_of_the_deformed_surface() {
    let mesh = rectangle(
        &linspace(0.0, 2.0, 4),
        &linspace(0.0, 1.0, 2),
        Diagonals::Rising,
    );
    let mut block = Body::new(
        mesh.expect("mesh"),
        NeoHookean::new(100.0, 0.3).expect("law"),
    );
    block.prescribe("left", [Some(0.0), None]).expect("support");
    block.prescribe("top", [None, Some(-0.4)]).expect("support");
    let mut scene = Scene::new();
    let id = scene.add("block", block);
    let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
    let plane = scene
        .obstacle("plane", id.on("bottom"), plane)
        .expect("a side");
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(4)
        .run(&mut problem)
        .expect("a run");
    let force = history.last().expect("a step").obstacle_force(plane)[1].abs();
    let solution = history.run.solution.expect("converged");
    let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
    let positions = problem.positions(u);
    let width = positions.iter().map(|x| x[0]).fold(0.0, f64::max);
    assert!(width > 2.2, "{width}");
    for p in &problem.pressures(u, gaps, lambda).expect("pressures")[0] {
        assert!(relative(p * width, force) < 1e-6, "{p} {width} {force}");
    }
    let states = problem.pair_states(u, gaps, lambda).expect("a state");
    assert!(relative(states[0].record.area, width) < 1e-6);
}

/// A block in a corner, pressed onto both walls: its corner has the pressure of one of them, not their sum.
#[test]
fn a_node_in_a_corner_has_one_pressure() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 3),
        &linspace(0.0, 1.0, 3),
        Diagonals::Rising,
    );
    let mut block = Body::new(
        mesh.expect("mesh"),
        LinearElastic::new(100.0, 0.3).expect("law"),
    );
    block.traction("top", [0.0, -1.0]).expect("a load");
    block.traction("right", [-2.0, 0.0]).expect("a load");
    let mut scene = Scene::new();
    let id = scene.add("block", block);
    for (name, side, normal) in [
        ("floor", "bottom", [0.0, 1.0]),
        ("wall", "left", [1.0, 0.0]),
    ] {
        let plane = Obstacle::half_space([0.0; 2], normal).expect("a plane");
        scene.obstacle(name, id.on(side), plane).expect("a side");
    }
    let (problem, solution) = solved(scene);
    let snapshot = Snapshot::new(&problem, &solution).expect("finite");
    let corner = problem.reference().iter().position(|X| X.norm() == 0.0);
    let corner = corner.expect("a corner");
    assert!((snapshot.pressures[corner] - 2.0).abs() < 1e-9);
    assert!((snapshot.contact_normals[corner][0] + 1.0).abs() < 1e-12);
}

/// Disc and ring press on each other with the same force per current length. The stretched ring has half as many nodes there, and
/// every other node of the disc carries hardly any multiplier.
#[test]
fn a_finer_surface_has_the_pressure_of_the_coarser_one() {
    let roles = disc_in_disc::Roles::default();
    let scene = disc_in_disc::scene(disc_in_disc::Fineness::scaled(48), roles).expect("a scene");
    let mut problem = scene.problem().expect("valid scene");
    let history = Simulation::with_increments(10).run(&mut problem);
    let solution = history.expect("a run").run.solution.expect("converged");
    let (u, gaps, lambda) = (&solution.state.u, &solution.gaps, &solution.lambda);
    let now = problem.positions(u);
    // at x, by surface: between the nodes beside it, divided by the stretch if so asked
    let at = |field: &[f64], surface: usize, x: f64, is_undeformed: bool| {
        let of = &problem.surfaces()[surface];
        let nodes = of.nodes();
        let mut found = of.facets().filter_map(|facet| {
            let [a, b] = [facet[0], facet[1]].map(|k| now[nodes[k]]);
            let t = (x - a[0]) / (b[0] - a[0]);
            let is_below = a[1] < -DISC_CENTRE && (0.0..1.0).contains(&t);
            let [A, B] = [facet[0], facet[1]].map(|k| problem.reference()[nodes[k]]);
            let stretch = (b - a).norm() / (B - A).norm();
            let p = field[facet[0]] * (1.0 - t) + field[facet[1]] * t;
            is_below.then_some(p / if is_undeformed { stretch } else { 1.0 })
        });
        found.next().expect("a facet")
    };
    let apart = |fields: &[Vec<f64>], is_undeformed: bool| {
        let at_place = |k: i32| {
            let x = 0.05 * f64::from(k);
            let [a, b] = [0, 1].map(|surface| at(&fields[surface], surface, x, is_undeformed));
            (a - b).abs() / (0.5 * (a + b))
        };
        (-6..=6).map(at_place).fold(0.0, f64::max)
    };
    let recovered = problem.pressures(u, gaps, lambda).expect("pressures");
    // −∫ p n ds over the current lengths is the force on each, though forces are along normals of the other
    let forces = problem.contact_forces(gaps, lambda);
    for (surface, field) in problem.surfaces().iter().zip(&recovered) {
        let nodes = surface.nodes();
        let mut sum = 0.0;
        for facet in surface.facets() {
            let [a, b] = [facet[0], facet[1]].map(|k| now[nodes[k]]);
            // outward normals of segments are on their right
            sum -= (a - b)[0] * 0.5 * (field[facet[0]] + field[facet[1]]);
        }
        let force: f64 = nodes.iter().map(|&a| forces[a][1]).sum();
        assert!(relative(sum, force) < 1e-6, "{sum} for {force}");
    }
    let consistent = problem.consistent_pressures(u, gaps, lambda);
    let consistent = consistent.expect("pressures");
    let (recovered, consistent) = (apart(&recovered, false), apart(&consistent, true));
    assert!(
        recovered < 0.15 && consistent > 0.5,
        "{recovered} {consistent}"
    );
}

/// The disc's centre is pushed below this depth.
const DISC_CENTRE: f64 = 1.2;
