//! The recovered contact pressure against analytic ones, and what it keeps of the forces.

use contact_core::equilibrium::Solution;
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Passes, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Scene, Simulation};
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
    // at x, by surface: force per current length between the nodes beside it
    let at = |field: &[f64], surface: usize, x: f64| {
        let of = &problem.surfaces()[surface];
        let nodes = of.nodes();
        let mut found = of.facets().filter_map(|facet| {
            let [a, b] = [facet[0], facet[1]].map(|k| now[nodes[k]]);
            let t = (x - a[0]) / (b[0] - a[0]);
            let is_below = a[1] < -DISC_CENTRE && (0.0..1.0).contains(&t);
            let [A, B] = [facet[0], facet[1]].map(|k| problem.reference()[nodes[k]]);
            let stretch = (b - a).norm() / (B - A).norm();
            let p = field[facet[0]] * (1.0 - t) + field[facet[1]] * t;
            is_below.then_some(p / stretch)
        });
        found.next().expect("a facet")
    };
    let apart = |fields: &[Vec<f64>]| {
        let at_place = |k: i32| {
            let [a, b] = [0, 1].map(|surface| at(&fields[surface], surface, 0.05 * f64::from(k)));
            (a - b).abs() / (0.5 * (a + b))
        };
        (-6..=6).map(at_place).fold(0.0, f64::max)
    };
    let recovered = problem.pressures(u, gaps, lambda).expect("pressures");
    // −∫ p n ds over the undeformed lengths is the force on each, though forces are along normals of the other
    let forces = problem.contact_forces(gaps, lambda);
    for (surface, field) in problem.surfaces().iter().zip(&recovered) {
        let nodes = surface.nodes();
        let mut sum = 0.0;
        for facet in surface.facets() {
            let [a, b] = [facet[0], facet[1]].map(|k| now[nodes[k]]);
            let [A, B] = [facet[0], facet[1]].map(|k| problem.reference()[nodes[k]]);
            // outward normals of segments are on their right
            let upward = (a - b)[0] / (b - a).norm();
            sum -= upward * (B - A).norm() * 0.5 * (field[facet[0]] + field[facet[1]]);
        }
        let force: f64 = nodes.iter().map(|&a| forces[a][1]).sum();
        assert!(relative(sum, force) < 1e-6, "{sum} for {force}");
    }
    let consistent = problem.consistent_pressures(u, gaps, lambda);
    let (recovered, consistent) = (apart(&recovered), apart(&consistent.expect("pressures")));
    assert!(
        recovered < 0.15 && consistent > 0.5,
        "{recovered} {consistent}"
    );
}

/// The disc's centre is pushed below this depth.
const DISC_CENTRE: f64 = 1.2;
