//! The recovered contact pressure against analytic ones, and what it keeps of the forces.

use contact_core::LinearGaps;
use contact_core::equilibrium::Solution;
use contact_fem::contact::{Integration, Surface};
use contact_fem::element::Order;
use contact_fem::mesh::generators::{self, Diagonals, cuboid, linspace};
use contact_fem::model::{PairState, Passes, Problem};
use contact_fem::output::Snapshot;
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean, Obstacle, Scene, Simulation};
use ipopt_contact_scenes::ball::{Ball, CONTACT_RADIUS};
use ipopt_contact_scenes::hertz::{Fineness, Hertz};
use ipopt_contact_scenes::pressure::{error, integral};
use ipopt_contact_scenes::{disc_in_disc, pair};

use crate::common::relative;

/// A problem and a state of it.
struct Solved<const D: usize> {
    problem: Problem<D>,
    solution: Solution,
}

impl<const D: usize> Solved<D> {
    fn new(scene: Scene<D>) -> Self {
        Self::after(1, scene)
    }

    fn after(increments: usize, scene: Scene<D>) -> Self {
        let mut problem = scene.problem().expect("valid scene");
        let history = Simulation::with_increments(increments).run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete(), "{}", history.run.ending);
        let solution = history.run.solution.expect("converged");
        Solved { problem, solution }
    }

    fn state(&self) -> (&[f64], &LinearGaps, &[f64]) {
        let of = &self.solution;
        (&of.state.u, &of.gaps, &of.lambda)
    }

    fn pressures(&self) -> Vec<Vec<f64>> {
        self.pressures_of(&self.solution.lambda)
    }

    /// Those of other multipliers.
    fn pressures_of(&self, lambda: &[f64]) -> Vec<Vec<f64>> {
        let (u, gaps, _) = self.state();
        let fields = self.problem.pressures(u, gaps, lambda);
        fields.expect("pressures")
    }

    fn consistent_pressures(&self) -> Vec<Vec<f64>> {
        let (u, gaps, lambda) = self.state();
        let fields = self.problem.consistent_pressures(u, gaps, lambda);
        fields.expect("pressures")
    }

    fn pair_states(&self) -> Vec<PairState<D>> {
        let (u, gaps, lambda) = self.state();
        let states = self.problem.pair_states(u, gaps, lambda);
        states.expect("a state")
    }

    /// X of the nodes of a surface.
    fn X<'a>(&'a self, surface: &'a Surface<D>) -> impl Fn(usize) -> Vector<D> + 'a {
        move |a| self.problem.reference()[surface.nodes()[a]]
    }
}

fn of_order<const D: usize>(mesh: Mesh<D>, order: Order) -> Mesh<D> {
    match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    }
}

/// A rectangle with so many cells along its sides.
fn rectangle(x: [f64; 2], y: [f64; 2], cells: [usize; 2], order: Order) -> Mesh<2> {
    let [x, y] = [(x, cells[0]), (y, cells[1])].map(|([a, b], n)| linspace(a, b, n));
    let mesh = generators::rectangle(&x, &y, Diagonals::Rising);
    of_order(mesh.expect("mesh"), order)
}

/// Of Young's modulus 100.
fn elastic(mesh: Mesh<2>, nu: f64) -> Body<2> {
    Body::new(mesh, LinearElastic::new(100.0, nu).expect("law"))
}

/// The errors of the recovered and of the consistent field on the ball.
fn on_the_ball(in_contact: usize, order: Order) -> [f64; 2] {
    let solved = Solved::new(Ball { in_contact, order }.scene().expect("a scene"));
    let p0 = Ball::peak_pressure();
    let fields = [solved.pressures(), solved.consistent_pressures()];
    assert!(fields[0].iter().flatten().all(|p| *p >= 0.0), "it pulls");
    let ball = &solved.problem.surfaces()[0];
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
/// 1 %, and nowhere negative or more than 5 % above it. The consistent field pulls by 12 % with the finer mesh. Half of the load is on
/// the half cylinder; forces along the block's normals have a moment about its axis, which no pressure on it has.
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
            let solved = Solved::new(hertz.scene().expect("a scene"));
            let surfaces = solved.problem.surfaces().iter();
            for (surface, field) in surfaces.zip(solved.pressures()) {
                let X = solved.X(surface);
                let nodes = 0..field.len();
                let middle = nodes.min_by(|&a, &b| X(a)[0].abs().total_cmp(&X(b)[0].abs()));
                let middle = field[middle.expect("nodes")];
                assert!(relative(middle, p0) < 0.01, "{middle} for {p0}: {passes:?}");
                let force = integral(surface, &field, |w, p, _, n| w * p * n[1].abs());
                assert!(relative(force, 17.5) < 3.5e-3, "{passes:?}: {force}");
                let inside = field.iter().all(|p| (0.0..=1.05 * p0).contains(p));
                assert!(inside, "{passes:?} on a/{in_contact}: {field:?}");
            }
        }
    }
}

/// The cylinder on a rigid plane, at the published load with moduli and force in another unit.
fn on_a_plane(in_contact: usize, unit: f64) -> Hertz {
    let published = Hertz::new(Fineness::family(in_contact), Order::Quadratic);
    Hertz {
        young: [published.young[0] * unit, f64::INFINITY],
        force: published.force * unit,
        ..published
    }
}

/// The largest difference of two fields, the second one divided by `unit`.
fn apart(fields: &[Vec<f64>], others: &[Vec<f64>], unit: f64) -> f64 {
    let pairs = fields.iter().flatten().zip(others.iter().flatten());
    pairs
        .map(|(p, other)| (p - other / unit).abs())
        .fold(0.0, f64::max)
}

/// Moduli and forces in a unit a thousand times as small: what differs is round-off.
#[test]
fn pressures_do_not_depend_on_the_unit_of_force() {
    for in_contact in [8, 16, 32] {
        let [one, other] = [1.0, 1000.0].map(|unit| {
            let scene = on_a_plane(in_contact, unit).on_rigid(false);
            Solved::new(scene.expect("a scene")).pressures()
        });
        let off = apart(&one, &other, 1000.0) / on_a_plane(in_contact, 1.0).peak_pressure();
        assert!(off < 1e-6, "{off} on a/{in_contact}");
    }
}

/// Multipliers that differ by a billionth of the largest one, everywhere, change no pressure by more than a millionth of p₀.
#[test]
fn pressures_are_continuous_in_the_forces() {
    let check = |of: &str, solved: &Solved<2>, p0: f64| {
        let lambda = &solved.solution.lambda;
        let largest = lambda.iter().copied().fold(0.0, f64::max);
        let fields = solved.pressures();
        for seed in 0..8_u32 {
            // some that were zero pull, some press
            let noise = |k: u32| (f64::from((k + 31 * seed) % 17) - 8.0) / 8.0;
            let others = lambda.iter().zip(0..);
            let others = others.map(|(l, k)| l + 1e-9 * largest * noise(k));
            let others = solved.pressures_of(&others.collect::<Vec<_>>());
            let off = apart(&fields, &others, 1.0) / p0;
            assert!(off < 1e-6, "{off} on {of}, {seed}");
        }
    };
    for in_contact in [8, 11, 16, 32] {
        let hertz = on_a_plane(in_contact, 1.0);
        let solved = Solved::new(hertz.on_rigid(false).expect("a scene"));
        check("a plane", &solved, hertz.peak_pressure());
        for passes in [Passes::Both, Passes::FirstIsSlave, Passes::SecondIsSlave] {
            let hertz = Hertz {
                force: 35.0,
                passes,
                ..Hertz::new(Fineness::family(in_contact), Order::Quadratic)
            };
            let solved = Solved::new(hertz.scene().expect("a scene"));
            check("a block", &solved, hertz.peak_pressure());
        }
    }
}

/// Two rings of like polygons, of which nodes of one are above the middles of the other's facets: on both the pressure is Lamé's,
/// though all gaps between nodes and facets are as large as the facets are bent.
#[test]
fn polygons_bear_a_constant_pressure() {
    let pressure = |segments: [usize; 2]| -> [f64; 2] {
        let ring = |radii: [f64; 2], segments: usize| {
            let radii = linspace(radii[0], radii[1], segments / 12);
            let mesh = generators::annulus(&radii, segments, Diagonals::Rising);
            elastic(mesh.expect("mesh"), 0.3)
        };
        let (mut inner, mut outer) = (ring([1.0, 1.5], segments[0]), ring([1.5, 2.0], segments[1]));
        inner.pressure("inner", 1.0).expect("a load");
        let along = |body: &mut Body<2>, radius: f64| {
            let nodes = body.mesh().nodes().iter().enumerate();
            let axes = [0, 1].map(|i| {
                let on = nodes
                    .clone()
                    .filter(|(_, X)| X[i].abs() < 1e-9 && (X.norm() - radius).abs() < 1e-9);
                on.map(|(a, _)| a).collect::<Vec<_>>()
            });
            for (i, nodes) in axes.into_iter().enumerate() {
                let mut held = [None; 2];
                held[i] = Some(0.0);
                body.prescribe_nodes(&nodes, held).expect("held");
            }
        };
        along(&mut inner, 1.0);
        along(&mut outer, 2.0);
        let mut scene = pair((inner, "outer"), (outer, "inner")).expect("a pair");
        scene.initial_gaps = ipopt_contact::contact_fem::model::InitialGaps::Adjust;
        let solved = Solved::new(scene);
        // Lamé in plane strain, both rings of one material as if they were one: p (b²/c² − 1) a² / (b² (a²/c² − 1))
        let lame = (2.0_f64 * 2.0 / (1.5 * 1.5) - 1.0) / (2.0 * 2.0 - 1.0);
        [solved.pressures(), solved.consistent_pressures()].map(|fields| {
            let off = fields.iter().flatten().map(|p| relative(*p, lame));
            off.fold(0.0, f64::max)
        })
    };
    for segments in [[36, 24], [72, 48], [96, 72]] {
        let [chosen, consistent] = pressure(segments);
        println!("{segments:?}: {chosen:.4}, consistent {consistent:.4}");
        assert!(chosen < 0.05, "{segments:?}: {chosen}");
    }
}

/// A ring of linear cells around a rigid shaft, with a clearance that a pressure outside closes: its nodes stand off the shaft by more
/// than what the pressure is worth, and have Lamé's pressure.
#[test]
fn a_polygon_presses_a_round_shaft() {
    let (E, nu, a, b, load, facets) = (2.1e5, 0.3, 1.0002, 1.2, 100.0, 400);
    // nodes further out, so that the polygon has the mean radius a
    let facet = std::f64::consts::TAU * a / facets as f64;
    let radii = linspace(a + facet * facet / 12.0, b, 4);
    let mesh = generators::annulus(&radii, facets, Diagonals::Alternating).expect("mesh");
    let mut ring = Body::new(mesh, LinearElastic::new(E, nu).expect("a law"));
    for (point, held) in [([b, 0.0], [None, Some(0.0)]), ([0.0, b], [Some(0.0), None])] {
        let opposite = point.map(|x: f64| -x);
        let nodes = ring.mesh().nodes_at(&[point, opposite]).expect("nodes");
        ring.prescribe_nodes(&nodes, held).expect("held");
    }
    ring.pressure("outer", load).expect("a load");
    let mut scene = Scene::new();
    let ring = scene.add("ring", ring);
    let shaft = Obstacle::ball([0.0; 2], 1.0).expect("a shaft");
    scene
        .obstacle("shaft", ring.on("inner"), shaft)
        .expect("a pair");
    let solved = Solved::new(scene);
    // Lamé: u = (1 + ν)/E ((1 − 2ν) A r + B/r) is −0.0002 at r = a, which is linear in the pressure there
    let u = |p: f64| {
        let A = (p * a * a - load * b * b) / (b * b - a * a);
        let B = (p - load) * a * a * b * b / (b * b - a * a);
        (1.0 + nu) / E * ((1.0 - 2.0 * nu) * A * a + B / a)
    };
    let lame = (1.0 - a - u(0.0)) / (u(1.0) - u(0.0));
    for p in &solved.pressures()[0] {
        assert!(relative(*p, lame) < 0.02, "{p} for {lame}");
    }
}

/// Two blocks under a load that grows along their common face, of meshes that do not match: on each of them the field has
/// resultant and moment of the nodal forces.
#[test]
fn resultant_and_moment_are_those_of_the_forces() {
    for n in [1, 2] {
        let block = |y: f64, cells: usize| {
            let cells = [cells, 4 * n];
            elastic(
                rectangle([0.0, 2.0], [y, y + 1.0], cells, Order::Linear),
                0.3,
            )
        };
        let (mut lower, mut upper) = (block(-1.0, 8 * n), block(0.0, 6 * n));
        lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
        upper.prescribe("left", [Some(0.0), None]).expect("support");
        let load = |X: &Vector<2>| Vector::<2>::new(0.0, -1.0 - 0.25 * X[0]);
        upper.traction_field("top", load).expect("load");
        let scene = pair((lower, "top"), (upper, "bottom"));
        let solved = Solved::new(scene.expect("a pair"));
        let states = solved.pair_states();
        let [state] = &states[..] else {
            panic!("one pair");
        };
        // ∫ (1 + x/4) dx over 0 to 2; the upper one is on the lower one everywhere
        let force: f64 = state.record.resultant[1];
        assert!(relative(force, -2.5) < 1e-6, "{force}");
        assert!(relative(state.record.area, 2.0) < 1e-9);
        for side in &state.sides {
            let surface = &solved.problem.surfaces()[side.surface];
            let sum = integral(surface, &side.pressures, |w, p, _, n| -w * p * n[1]);
            // the moment is that of the forces ∫ N_a ds p_a on the nodes; with the facets' halves, N_a being linear
            let facets = surface.facets().zip(surface.reference());
            let halves = facets.flat_map(|(nodes, facet)| {
                let half = facet.normal(&Vector::<2>::repeat(0.5)) * 0.5;
                nodes.iter().map(move |&a| (a, half[1]))
            });
            let X = solved.X(surface);
            let moment = halves.map(|(a, n)| -n * side.pressures[a] * X(a)[0]);
            let moment: f64 = moment.sum();
            let forces = side.forces.iter().enumerate();
            let expected: f64 = side.forces.iter().map(|f| f[1]).sum();
            let of_forces: f64 = forces.map(|(a, f)| f[1] * X(a)[0]).sum();
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
            let law = LinearElastic::new(100.0, 0.0).expect("law");
            let mut body = Body::new(of_order(mesh, order), law);
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
        let scene = pair((lower, "top"), (upper, "bottom"));
        let solved = Solved::new(scene.expect("a pair"));
        for p in solved.pressures().iter().flatten() {
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
            elastic(rectangle(x, [y, y + 1.0], [cells, 2], order), 0.0)
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
        let solved = Solved::new(scene);
        // both columns are shortened by a hundredth
        for p in solved.pressures().iter().flatten() {
            assert!((p - 1.0).abs() < 1e-5, "{cells} {order:?}: {p}");
        }
        for state in solved.pair_states() {
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
        let mesh = rectangle([-1.0, 1.0], [0.0, 1.0], [11, 6], order);
        let mut block = elastic(mesh, 0.3);
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
        let centre = Solved::new(scene).pair_states()[0]
            .record
            .centre
            .expect("a force");
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
        let scene = Ball { in_contact, order }.scene();
        let states = Solved::new(scene.expect("a scene")).pair_states();
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
    let mesh = rectangle([0.0, 2.0], [0.0, 1.0], [4, 2], Order::Linear);
    let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("law"));
    block.prescribe("left", [Some(0.0), None]).expect("support");
    block.prescribe("top", [None, Some(-0.4)]).expect("support");
    let mut scene = Scene::new();
    let id = scene.add("block", block);
    let plane = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a plane");
    let plane = scene.obstacle("plane", id.on("bottom"), plane);
    plane.expect("a side");
    let solved = Solved::after(4, scene);
    let states = solved.pair_states();
    let force = states[0].record.resultant[1];
    let positions = solved.problem.positions(&solved.solution.state.u);
    let width = positions.iter().map(|x| x[0]).fold(0.0, f64::max);
    assert!(width > 2.2, "{width}");
    for p in &solved.pressures()[0] {
        assert!(relative(p * width, force) < 1e-6, "{p} {width} {force}");
    }
    assert!(relative(states[0].record.area, width) < 1e-6);
}

/// A block in a corner, pressed onto both walls: its corner has the pressure of one of them, not their sum.
#[test]
fn a_node_in_a_corner_has_one_pressure() {
    let mesh = rectangle([0.0, 1.0], [0.0, 1.0], [3, 3], Order::Linear);
    let mut block = elastic(mesh, 0.3);
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
    let Solved { problem, solution } = Solved::new(scene);
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
    let solved = Solved::after(10, scene);
    let Solved { problem, solution } = &solved;
    let now = problem.positions(&solution.state.u);
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
    let recovered = solved.pressures();
    // −∫ p n ds over the current lengths is the force on each, though forces are along normals of the other
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
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
    let consistent = solved.consistent_pressures();
    let (recovered, consistent) = (apart(&recovered, false), apart(&consistent, true));
    assert!(
        recovered < 0.15 && consistent > 0.5,
        "{recovered} {consistent}"
    );
}

/// The disc's centre is pushed below this depth.
const DISC_CENTRE: f64 = 1.2;
