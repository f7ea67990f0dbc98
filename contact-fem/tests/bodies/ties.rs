//! Bodies with meshes that do not match, tied to each other.
#![allow(non_snake_case)]

use contact_core::{CondensedNewton, Equilibrium};
use contact_fem::certificate::Limits;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{Tie, TieFault, TiedSlave};
use contact_fem::simulation::History;
use contact_fem::tensor::{Matrix, Vector};
use contact_fem::{
    Body, BodyId, Error, LinearElastic, Mesh, Motion, NeoHookean, Obstacle, Scene, Simulation,
};

/// Whether the cells of the two blocks are quadratic.
const ORDERS: [[bool; 2]; 4] = [[false, false], [true, true], [false, true], [true, false]];
const SLAVES: [TiedSlave; 2] = [TiedSlave::First, TiedSlave::Second];

/// Two blocks on each other, of height 1 each; the cells of their surfaces have no node in common but at the rim.
fn blocks<const D: usize>(are_quadratic: [bool; 2]) -> Vec<Mesh<D>>
where
    Blocks: Of<D>,
{
    let meshes = Blocks::linear().into_iter().zip(are_quadratic);
    let of_order = |(mesh, is_quadratic)| match is_quadratic {
        true => Blocks::quadratic(mesh),
        false => mesh,
    };
    meshes.map(of_order).collect()
}

struct Blocks;

trait Of<const D: usize> {
    fn linear() -> [Mesh<D>; 2];
    fn quadratic(mesh: Mesh<D>) -> Mesh<D>;
    /// Two layers with different numbers of cells along, and one piece.
    fn layers(cells: usize) -> Vec<Mesh<D>>;
    fn whole(cells: usize) -> Mesh<D>;
    fn body(mesh: Mesh<D>, law: LinearElastic) -> Body<D>;
    /// The names of the lower block's upper and the upper block's lower boundary.
    const SIDES: [&'static str; 2] = ["top", "bottom"];
}

impl Of<2> for Blocks {
    fn layers(cells: usize) -> Vec<Mesh<2>> {
        let layer = |y: f64, nx: usize| {
            let ys = linspace(y, y + 1.0, 2 * cells);
            rectangle(&linspace(0.0, 2.0, nx), &ys, Diagonals::Rising).expect("a mesh")
        };
        vec![layer(0.0, 3 * cells), layer(1.0, 4 * cells)]
    }

    fn whole(cells: usize) -> Mesh<2> {
        let [xs, ys] = [3, 4].map(|share| linspace(0.0, 2.0, share * cells));
        rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
    }

    fn quadratic(mesh: Mesh<2>) -> Mesh<2> {
        mesh.quadratic()
    }

    fn body(mesh: Mesh<2>, law: LinearElastic) -> Body<2> {
        Body::new(mesh, law)
    }

    fn linear() -> [Mesh<2>; 2] {
        let block = |xs: usize, y: f64, ys: usize| {
            let (xs, ys) = (linspace(0.0, 2.0, xs), linspace(y, y + 1.0, ys));
            rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
        };
        [block(3, 0.0, 2), block(4, 1.0, 2)]
    }
}

impl Of<3> for Blocks {
    fn layers(cells: usize) -> Vec<Mesh<3>> {
        let layer = |z: f64, [nx, ny]: [usize; 2]| {
            cuboid(
                [0.0, 0.0, z],
                [2.0, 1.0, 1.0],
                [nx, ny, 2].map(|n| n * cells),
            )
            .expect("a mesh")
        };
        vec![layer(0.0, [3, 2]), layer(1.0, [4, 3])]
    }

    fn whole(cells: usize) -> Mesh<3> {
        cuboid([0.0; 3], [2.0, 1.0, 2.0], [3, 2, 4].map(|n| n * cells)).expect("a mesh")
    }

    fn quadratic(mesh: Mesh<3>) -> Mesh<3> {
        mesh.quadratic()
    }

    fn body(mesh: Mesh<3>, law: LinearElastic) -> Body<3> {
        Body::new(mesh, law)
    }

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
    assert!(certificate.holds(&Limits::default()), "{certificate}");
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
    X.zip(&U)
        .map(|(X, u)| (u - A * X).amax())
        .fold(0.0, f64::max)
}

/// Blocks whose outside, but for the tied sides, is moved by u = A X: they take it on everywhere, whichever side follows.
/// Nodes on the rim of the tied sides are prescribed on both.
fn linear_fields<const D: usize>()
where
    Blocks: Of<D>,
{
    let A = Matrix::<D>::from_fn(|i, j| {
        1e-3 * (1.0 + 2.0 * i as f64 - 1.5 * (i * j) as f64 + j as f64)
    });
    for are_quadratic in ORDERS {
        for slave in SLAVES {
            let law = LinearElastic::new(200.0, 0.3).expect("a law");
            let mut scene = Scene::new();
            let sides = Blocks::SIDES;
            let ids: Vec<BodyId> = blocks::<D>(are_quadratic)
                .into_iter()
                .enumerate()
                .map(|(k, mesh)| {
                    let names: Vec<String> = mesh.boundary_names().map(str::to_string).collect();
                    let mut body = Blocks::body(mesh, law);
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
            let tie = Tie {
                slave,
                ..Tie::new(ids[0].on(sides[0]), ids[1].on(sides[1]))
            };
            scene.tie_as(tie).expect("a tie");
            let (problem, history) = solved(scene, Simulation::with_increments(1));
            let off = off(&problem, &history, &A);
            assert!(off < 1e-14, "{D} {are_quadratic:?} {slave:?}: {off:.1e}");
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
    for are_quadratic in ORDERS {
        for slave in SLAVES {
            let law = LinearElastic::new(E, nu).expect("a law");
            let mut scene = Scene::new();
            let ids: Vec<BodyId> = blocks::<D>(are_quadratic)
                .into_iter()
                .enumerate()
                .map(|(k, mesh)| {
                    let mut body = Blocks::body(mesh, law);
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
            let tie = Tie {
                slave,
                ..Tie::new(ids[0].on("top"), ids[1].on("bottom"))
            };
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
            assert!(off < 1e-11, "{D} {are_quadratic:?} {slave:?}: {off:.1e}");
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

/// A cantilever of length 8 and height 1, clamped on the left, of two halves with these numbers of cells over their heights; or
/// of one piece. The mean deflection of its right end under a shear load of resultant −1, and the energy.
fn cantilever(cells: &[usize], is_quadratic: bool) -> (f64, f64) {
    let law = LinearElastic::new(1e4, 0.0).expect("a law");
    let length = 8.0 / cells.len() as f64;
    let mut scene = Scene::new();
    let ids: Vec<BodyId> = cells
        .iter()
        .enumerate()
        .map(|(k, &ny)| {
            let x = length * k as f64;
            let along = (length * ny as f64).round() as usize;
            let (xs, ys) = (linspace(x, x + length, along), linspace(0.0, 1.0, ny));
            let mesh = rectangle(&xs, &ys, Diagonals::Alternating).expect("a mesh");
            let mut body = Body::new(if is_quadratic { mesh.quadratic() } else { mesh }, law);
            if k == 0 {
                body.prescribe("left", [Some(0.0); 2]).expect("a support");
            }
            if k + 1 == cells.len() {
                body.traction("right", [0.0, -1.0]).expect("a load");
            }
            scene.add(format!("part {k}"), body)
        })
        .collect();
    for pair in ids.windows(2) {
        scene
            .tie(pair[0].on("right"), pair[1].on("left"))
            .expect("a tie");
    }
    let (problem, history) = solved(scene, Simulation::with_increments(1));
    let step = history.last().expect("a step");
    for tie in &step.ties {
        // what the right half does to the left one is the load
        assert!(
            (tie.force - Vector::from([0.0, -1.0])).amax() < 1e-10,
            "{}",
            tie.force
        );
    }
    let last = *ids.last().expect("a part");
    let U = problem.displacements(&history.run.state.u);
    let mesh = problem.scene().bodies()[last.index()].mesh();
    let end = mesh.boundary_nodes("right").expect("a boundary");
    let first = problem.first_node(last);
    let tip = end.iter().map(|a| U[first + a][1]).sum::<f64>() / end.len() as f64;
    (tip, step.energy)
}

/// Two halves against Timoshenko's beam and against one piece.
#[test]
fn a_cantilever_of_two_halves() {
    // F L³/(3 E I) + F L/(κ G A) with κ = 5/6 at ν = 0
    let exact = -(512.0 * 12.0 / 3.0 + 8.0 * 2.0 * 6.0 / 5.0) / 1e4;
    let (tied, energy) = cantilever(&[4, 6], true);
    let (whole, reference) = cantilever(&[16], true);
    assert!((tied / exact - 1.0).abs() < 1e-3, "{tied} {exact}");
    assert!((tied / whole - 1.0).abs() < 1e-4, "{tied} {whole}");
    assert!(
        (energy / reference - 1.0).abs() < 2e-4,
        "{energy} {reference}"
    );
    // the clamp's corners are what both have in common
    println!("tied {tied}, one piece {whole}, Timoshenko {exact}, energies {energy} {reference}");
}

/// The largest error of nodal displacements, where the outside follows a field that is exact: u = (sin x sinh y, −cos x cosh y) has
/// div u = 0 and Δu = 0, in the last of the axes for y. Two tied layers whose cells do not match, or one piece.
fn error<const D: usize>(cells: usize, is_quadratic: bool, is_tied: bool) -> f64
where
    Blocks: Of<D>,
{
    let last = D - 1;
    let exact = |X: &Vector<D>| {
        let mut u = Vector::<D>::zeros();
        let (x, y) = (X[0], 0.5 * X[last]);
        let x = 0.5 * x;
        u[0] = 1e-2 * x.sin() * y.sinh();
        u[last] = -1e-2 * x.cos() * y.cosh();
        u
    };
    let law = LinearElastic::new(100.0, 0.3).expect("a law");
    let mut scene = Scene::new();
    let meshes = match is_tied {
        true => Blocks::layers(cells),
        false => vec![Blocks::whole(cells)],
    };
    let count = meshes.len();
    let mut ids = Vec::new();
    for (k, mesh) in meshes.into_iter().enumerate() {
        let mesh = if is_quadratic {
            Blocks::quadratic(mesh)
        } else {
            mesh
        };
        let names: Vec<String> = mesh.boundary_names().map(str::to_string).collect();
        let mut body = Blocks::body(mesh, law);
        let is_inner = |name: &str| is_tied && name == Blocks::SIDES[k];
        for name in names.iter().filter(|name| !is_inner(name)) {
            for node in body.mesh().boundary_nodes(name).expect("a boundary") {
                let u = exact(&body.mesh().nodes()[node]);
                let u: [Option<f64>; D] = std::array::from_fn(|i| Some(u[i]));
                body.prescribe_nodes(&[node], u).expect("a support");
            }
        }
        ids.push(scene.add(format!("layer {k}"), body));
    }
    if count == 2 {
        let [top, bottom] = Blocks::SIDES;
        scene.tie(ids[0].on(top), ids[1].on(bottom)).expect("a tie");
    }
    let (problem, history) = solved(scene, Simulation::with_increments(1));
    let U = problem.displacements(&history.run.state.u);
    let off = problem.reference().iter().zip(&U);
    off.map(|(X, u)| (u - exact(X)).amax()).fold(0.0, f64::max)
}

fn orders<const D: usize>(cells: [usize; 3])
where
    Blocks: Of<D>,
{
    for (is_quadratic, order) in [(false, 2.0), (true, 3.0)] {
        let errors = cells.map(|cells| error::<D>(cells, is_quadratic, true));
        let whole = cells.map(|cells| error::<D>(cells, is_quadratic, false));
        let order_of = |k: usize| {
            (errors[k] / errors[k + 1]).ln() / (cells[k + 1] as f64 / cells[k] as f64).ln()
        };
        let found = [0, 1].map(order_of);
        println!("{D} {is_quadratic}: {errors:?}, orders {found:?}, one piece {whole:?}");
        assert!(
            found[1] > order - 0.35,
            "{D} {is_quadratic}: {errors:?} {found:?}"
        );
    }
}

#[test]
fn orders_of_convergence_in_the_plane() {
    orders::<2>([2, 4, 8]);
}

#[test]
fn orders_of_convergence_in_space() {
    orders::<3>([1, 2, 3]);
}

/// A neo-Hookean bar of two tied halves drawn to twice its length: the stretch is uniform, and the force that of P(λ) with no
/// stress across.
#[test]
fn a_bar_at_large_strains() {
    let (E, nu) = (10.0, 0.3);
    let stretch = 2.0;
    for is_quadratic in [false, true] {
        let law = NeoHookean::new(E, nu).expect("a law");
        let half = |x: f64, nx: usize, ny: usize| {
            let mesh = rectangle(
                &linspace(x, x + 1.0, nx),
                &linspace(0.0, 1.0, ny),
                Diagonals::Rising,
            );
            let mesh = mesh.expect("a mesh");
            let mut body = Body::new(if is_quadratic { mesh.quadratic() } else { mesh }, law);
            body.symmetry("bottom").expect("a support");
            body
        };
        let (mut left, mut right) = (half(0.0, 2, 3), half(1.0, 3, 4));
        left.symmetry("left").expect("a support");
        right
            .prescribe("right", [Some(2.0 * (stretch - 1.0)), None])
            .expect("a support");
        let mut scene = Scene::new();
        let (left, right) = (scene.add("left", left), scene.add("right", right));
        scene
            .tie(left.on("right"), right.on("left"))
            .expect("a tie");
        let (problem, history) = solved(scene, Simulation::with_increments(4));
        // ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)²: P_i = μ (λ_i − 1/λ_i) + λ ln J/λ_i
        let (mu, lame) = (
            E / (2.0 * (1.0 + nu)),
            E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        );
        let across = |w: f64| mu * (w * w - 1.0) + lame * (stretch * w).ln();
        let (mut low, mut high) = (0.1, 1.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if across(middle) < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        let force = mu * (stretch - 1.0 / stretch) + lame * (stretch * low).ln() / stretch;
        let step = history.last().expect("a step");
        let found = step.ties[0].force;
        assert!(
            (found[0] / force - 1.0).abs() < 1e-8 && found[1].abs() < 1e-8,
            "{found} {force}"
        );
        let A = Matrix::<2>::new(stretch - 1.0, 0.0, 0.0, low - 1.0);
        let off = off(&problem, &history, &A);
        assert!(off < 1e-8, "{is_quadratic}: {off:.1e}");
    }
}

/// A strip of two tied halves is bent round by the end that turns, against one piece of the same fineness; and the tie turns with
/// it.
#[test]
fn a_strip_that_is_bent_round() {
    let moments = [true, false].map(|is_tied| {
        let law = NeoHookean::new(1e3, 0.0).expect("a law");
        let strip = |x: [f64; 2], nx: usize, ny: usize| {
            let mesh = rectangle(
                &linspace(x[0], x[1], nx),
                &linspace(-0.25, 0.25, ny),
                Diagonals::Alternating,
            );
            Body::new(mesh.expect("a mesh").quadratic(), law)
        };
        let end = |body: &mut Body<2>| {
            // a right angle about the point (5, 0), then moved to where the end of the bent middle line is
            let radius = 5.0 / std::f64::consts::FRAC_PI_2;
            for node in body.mesh().boundary_nodes("right").expect("a boundary") {
                let y = body.mesh().nodes()[node][1];
                let u = [radius - y - 5.0, radius - y];
                body.prescribe_nodes(&[node], u.map(Some))
                    .expect("a support");
            }
        };
        let mut scene = Scene::new();
        match is_tied {
            true => {
                let (mut left, mut right) = (strip([0.0, 2.5], 10, 2), strip([2.5, 5.0], 12, 3));
                left.prescribe("left", [Some(0.0); 2]).expect("a support");
                end(&mut right);
                let (left, right) = (scene.add("left", left), scene.add("right", right));
                scene
                    .tie(left.on("right"), right.on("left"))
                    .expect("a tie");
            }
            false => {
                let mut whole = strip([0.0, 5.0], 24, 3);
                whole.prescribe("left", [Some(0.0); 2]).expect("a support");
                end(&mut whole);
                scene.add("whole", whole);
            }
        }
        let (_, history) = solved(scene, Simulation::with_increments(10));
        history.last().expect("a step").energy
    });
    // E I κ²/2 times the length, for a thin strip
    let thin = 0.5 * 1e3 * 0.125 / 12.0 * (std::f64::consts::FRAC_PI_2 / 5.0).powi(2) * 5.0;
    println!("bent {moments:?}, thin {thin}");
    assert!((moments[0] / moments[1] - 1.0).abs() < 2e-3, "{moments:?}");
    assert!((moments[0] / thin - 1.0).abs() < 0.05, "{moments:?} {thin}");
}

/// Two layers whose meshes match, tied, under a rigid ball, against one body of two laws: the same rows, the same displacements.
#[test]
fn tied_layers_are_one_body_of_two_laws() {
    let xs = linspace(-1.0, 1.0, 8);
    let pressed = |scene: &mut Scene<2>, side| {
        let down = Motion::translation([0.0, -0.05]).expect("a motion");
        let ball = Obstacle::ball([0.0, 2.0], 1.0)
            .expect("a ball")
            .moving(down);
        scene.obstacle("ball", side, ball).expect("a pair");
    };
    for large in [false, true] {
        let solve = |scene: Scene<2>| {
            let (problem, history) = solved(scene, Simulation::with_increments(2));
            let U = problem.displacements(&history.run.state.u);
            let force = history.last().expect("a step").obstacle_forces[0];
            let field: Vec<_> = problem.reference().iter().copied().zip(U).collect();
            (field, force)
        };
        let (soft, stiff) = ((100.0, 0.3), (300.0, 0.2));
        let small = |(E, nu): (f64, f64)| LinearElastic::new(E, nu).expect("a law");
        let neo = |(E, nu): (f64, f64)| NeoHookean::new(E, nu).expect("a law");
        let layer = |y: [f64; 2], law| {
            let mesh = rectangle(&xs, &linspace(y[0], y[1], 2), Diagonals::Rising).expect("a mesh");
            if large {
                Body::new(mesh, neo(law))
            } else {
                Body::new(mesh, small(law))
            }
        };
        let mut scene = Scene::new();
        let mut lower = layer([0.0, 0.5], soft);
        lower
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        let (lower, upper) = (
            scene.add("lower", lower),
            scene.add("upper", layer([0.5, 1.0], stiff)),
        );
        scene
            .tie(lower.on("top"), upper.on("bottom"))
            .expect("a tie");
        pressed(&mut scene, upper.on("top"));
        let (tied, force) = solve(scene);

        let mut mesh = rectangle(&xs, &linspace(0.0, 1.0, 4), Diagonals::Rising).expect("a mesh");
        mesh.name_region("lower", |X| X[1] < 0.5);
        mesh.name_region("upper", |X| X[1] > 0.5);
        let mut body = match large {
            true => Body::with_laws(mesh, [("lower", neo(soft)), ("upper", neo(stiff))]),
            false => Body::with_laws(mesh, [("lower", small(soft)), ("upper", small(stiff))]),
        }
        .expect("laws");
        body.prescribe("bottom", [Some(0.0); 2]).expect("a support");
        let mut scene = Scene::new();
        let body = scene.add("both", body);
        pressed(&mut scene, body.on("top"));
        let (whole, reference) = solve(scene);
        assert!(reference[1].abs() > 1.0, "{reference}");
        assert!(
            (force - reference).amax() < 1e-9 * reference[1].abs(),
            "{force} {reference}"
        );
        for (X, u) in &tied {
            let other = whole
                .iter()
                .find(|(Y, _)| (X - Y).amax() < 1e-12)
                .expect("a node");
            assert!(
                (u - other.1).amax() < 1e-11,
                "{large}: {u} {} at {X}",
                other.1
            );
        }
    }
}

/// Layers that do not match, the upper one pressed by a block in contact: Newton's method, the condensed solver and Ipopt agree.
#[test]
fn solvers_agree() {
    let scene = |large: bool| {
        let block = |x: [f64; 2], y: [f64; 2], cells: [usize; 2]| {
            let xs = linspace(x[0], x[1], cells[0]);
            let mesh =
                rectangle(&xs, &linspace(y[0], y[1], cells[1]), Diagonals::Rising).expect("a mesh");
            match large {
                true => Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("a law")),
                false => Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law")),
            }
        };
        let mut lower = block([0.0, 2.0], [0.0, 0.5], [5, 2]);
        lower
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        let upper = block([0.0, 2.0], [0.5, 1.0], [7, 2]);
        let mut punch = block([0.5, 1.5], [1.0, 1.5], [4, 2]);
        punch
            .prescribe("top", [Some(0.0), Some(-0.05)])
            .expect("a support");
        let mut scene = Scene::new();
        // the punch is between the tied bodies in the order of the bodies
        let (lower, punch) = (scene.add("lower", lower), scene.add("punch", punch));
        let upper = scene.add("upper", upper);
        scene
            .tie(upper.on("bottom"), lower.on("top"))
            .expect("a tie");
        scene
            .contact(punch.on("bottom"), upper.on("top"))
            .expect("a pair");
        scene
    };
    for large in [false, true] {
        let (problem, automatic) = solved(scene(large), Simulation::with_increments(2));
        let (_, newton) = solved(
            scene(large),
            Simulation::solved_by(CondensedNewton::with_tolerance(1e-10), 2),
        );
        let U = problem.displacements(&automatic.run.state.u);
        let others = problem.displacements(&newton.run.state.u);
        let off = U
            .iter()
            .zip(&others)
            .map(|(u, v)| (u - v).amax())
            .fold(0.0, f64::max);
        assert!(off < 1e-9, "{large}: {off:.1e}");
        let step = automatic.last().expect("a step");
        // the lower body has what the punch pushes with
        let pushed = step.contact_forces[1][1];
        assert!(pushed > 0.5, "{pushed}");
        assert!(
            (step.ties[0].force[1] - pushed).abs() < 1e-9 * pushed,
            "{} {pushed}",
            step.ties[0].force
        );
        assert!((step.reactions[0][1] - pushed).abs() < 1e-9 * pushed);
        #[cfg(feature = "ipopt")]
        {
            let solver = contact_core::Retry::<contact_core::InteriorPoint>::default();
            let (_, ipopt) = solved(scene(large), Simulation::solved_by(solver, 2));
            let others = problem.displacements(&ipopt.run.state.u);
            let off = U
                .iter()
                .zip(&others)
                .map(|(u, v)| (u - v).amax())
                .fold(0.0, f64::max);
            assert!(off < 1e-6, "{large}: {off:.1e}");
        }
    }
}

/// A wall of four blocks whose ties meet in a point, under a constant stress.
#[test]
fn ties_that_meet() {
    let law = LinearElastic::new(200.0, 0.3).expect("a law");
    let mut scene = Scene::new();
    let cells = [[2, 3], [3, 2], [4, 3], [3, 4]];
    let ids: Vec<BodyId> = cells
        .iter()
        .enumerate()
        .map(|(k, [nx, ny])| {
            let [x, y] = [(k % 2) as f64, (k / 2) as f64];
            let mesh = rectangle(
                &linspace(x, x + 1.0, *nx),
                &linspace(y, y + 1.0, *ny),
                Diagonals::Rising,
            );
            let mut body = Body::new(mesh.expect("a mesh"), law);
            if k % 2 == 0 {
                body.symmetry("left").expect("a support");
            }
            match k / 2 {
                0 => body.symmetry("bottom").expect("a support"),
                _ => body.traction("top", [0.0, 1.0]).expect("a load"),
            };
            scene.add(format!("block {k}"), body)
        })
        .collect();
    for (a, b, sides) in [
        (0, 1, ["right", "left"]),
        (2, 3, ["right", "left"]),
        (0, 2, ["top", "bottom"]),
        (1, 3, ["top", "bottom"]),
    ] {
        scene
            .tie(ids[a].on(sides[0]), ids[b].on(sides[1]))
            .expect("a tie");
    }
    let (problem, history) = solved(scene, Simulation::with_increments(1));
    let A = Matrix::<2>::new(-0.3 * 1.3 / 200.0, 0.0, 0.0, (1.0 - 0.09) / 200.0);
    let off = off(&problem, &history, &A);
    assert!(off < 1e-13, "{off:.1e}");
    let forces: Vec<Vector<2>> = history
        .last()
        .expect("a step")
        .ties
        .iter()
        .map(|tie| tie.force)
        .collect();
    for (force, exact) in forces.iter().zip([0.0, 0.0, 1.0, 1.0]) {
        assert!(
            force[0].abs() < 1e-10 && (force[1] - exact).abs() < 1e-10,
            "{forces:?}"
        );
    }
}

/// What cannot be tied is told with a cause, before any solve.
#[test]
fn what_cannot_be_tied() {
    let law = LinearElastic::new(1.0, 0.0).expect("a law");
    let block = |x: [f64; 2], y: f64, nx: usize| {
        let mesh = rectangle(
            &linspace(x[0], x[1], nx),
            &linspace(y, y + 1.0, 2),
            Diagonals::Rising,
        );
        Body::new(mesh.expect("a mesh"), law)
    };
    let scene = |y: f64, x: [f64; 2], slave: TiedSlave| {
        let mut lower = block([0.0, 1.0], 0.0, 3);
        lower
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        let mut scene = Scene::new();
        let (lower, upper) = (
            scene.add("lower", lower),
            scene.add("upper", block(x, y, 4)),
        );
        let tie = Tie {
            slave,
            ..Tie::new(lower.on("top"), upper.on("bottom"))
        };
        scene.tie_as(tie).expect("a tie");
        (scene, lower, upper)
    };
    let fault = |scene: Scene<2>| {
        let findings = scene.preflight();
        assert!(
            findings.iter().any(|f| f.what.contains("cannot be tied")),
            "{findings:?}"
        );
        match scene.problem() {
            Err(Error::Tie { why, .. }) => why,
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("no error"),
        }
    };
    // held by the tie alone
    assert!(scene(1.0, [0.0, 1.0], TiedSlave::Finer).0.problem().is_ok());
    // the other side follows where the finer one reaches beyond it
    assert!(
        scene(1.0, [-1.0, 2.0], TiedSlave::Second)
            .0
            .problem()
            .is_err()
    );
    assert!(
        scene(1.0, [-1.0, 2.0], TiedSlave::First)
            .0
            .problem()
            .is_ok()
    );
    assert!(
        scene(1.0, [0.25, 0.5], TiedSlave::Finer)
            .0
            .problem()
            .is_ok()
    );
    assert!(
        matches!(fault(scene(1.1, [0.0, 1.0], TiedSlave::Finer).0), TieFault::Apart { distance, .. } if (distance - 0.1).abs() < 1e-12)
    );
    assert!(matches!(
        fault(scene(1.0, [0.5, 1.5], TiedSlave::Finer).0),
        TieFault::Uncovered { .. }
    ));
    let (mut both, lower, upper) = scene(1.0, [0.0, 1.0], TiedSlave::Finer);
    both.contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    assert_eq!(fault(both), TieFault::Contact);
    let (mut twice, lower, upper) = scene(1.0, [0.0, 1.0], TiedSlave::Finer);
    twice
        .tie(upper.on("bottom"), lower.on("top"))
        .expect("a tie");
    assert_eq!(fault(twice), TieFault::Twice);
    let (mut own, lower, _) = scene(1.0, [0.0, 1.0], TiedSlave::Finer);
    own.tie(lower.on("top"), lower.on("left")).expect("a tie");
    assert_eq!(fault(own), TieFault::OneBody);
    // all of the side that is to follow is prescribed
    let mut held = block([0.0, 1.0], 1.0, 4);
    held.prescribe("bottom", [Some(0.0), Some(0.1)])
        .expect("a support");
    let mut scene = Scene::new();
    let (lower, upper) = (
        scene.add("lower", block([0.0, 1.0], 0.0, 3)),
        scene.add("upper", held),
    );
    let tie = Tie {
        slave: TiedSlave::Second,
        ..Tie::new(lower.on("top"), upper.on("bottom"))
    };
    scene.tie_as(tie).expect("a tie");
    assert!(matches!(fault(scene), TieFault::Held { .. }));
    // bodies that neither is held
    let mut scene = Scene::new();
    let (lower, upper) = (
        scene.add("lower", block([0.0, 1.0], 0.0, 3)),
        scene.add("upper", block([0.0, 1.0], 1.0, 4)),
    );
    let mut third = block([5.0, 6.0], 0.0, 2);
    third
        .prescribe("bottom", [Some(0.0); 2])
        .expect("a support");
    scene.add("third", third);
    scene
        .tie(lower.on("top"), upper.on("bottom"))
        .expect("a tie");
    assert!(matches!(
        scene.problem(),
        Err(Error::Unsupported { free: 3, .. })
    ));
}

/// What eliminates displacements in ways of its own, and bodies of revolution.
#[test]
fn what_ties_do_not_know() {
    let law = LinearElastic::new(1.0, 0.0).expect("a law");
    let block = |y: f64, n: usize| {
        let (x, y) = (linspace(0.0, 1.0, n), linspace(y, y + 1.0, 2));
        rectangle(&x, &y, Diagonals::Rising).expect("a mesh")
    };
    let fault = |lower: Body<2>, upper: Body<2>| {
        let mut scene = Scene::new();
        let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
        scene
            .tie(lower.on("top"), upper.on("bottom"))
            .expect("a tie");
        match scene.problem() {
            Err(Error::Tie { why, .. }) => why,
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("no error"),
        }
    };
    let lower = || {
        let mut lower = Body::new(block(0.0, 3), law);
        lower
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        lower
    };
    let mut inclined = Body::new(block(1.0, 4), law);
    inclined
        .prescribe_along("top", [1.0, 1.0], 0.0)
        .expect("a support");
    assert_eq!(fault(lower(), inclined), TieFault::Inclined);
    let mut switched = Body::new(block(1.0, 4), law);
    switched
        .during(&[[0.0, 0.5]], |body| body.prescribe("top", [Some(0.0); 2]))
        .expect("a support");
    assert_eq!(fault(lower(), switched), TieFault::Switched);
    let ring = |y: f64, n: usize| Body::<2>::of_revolution(block(y, n), law).expect("a body");
    let mut held = ring(0.0, 3);
    held.prescribe("bottom", [None, Some(0.0)])
        .expect("a support");
    assert_eq!(fault(held, ring(1.0, 4)), TieFault::Revolution);
}

/// A thick pipe of two tied rings, quarters of which are modelled by curved quadratic cells that do not match, under inner
/// pressure: Lamé's displacement u = p a²/(b² − a²) ((1 + ν)/E) ((1 − 2ν) r + b²/r) in plane strain.
#[test]
fn a_pipe_of_two_rings() {
    let (E, nu, p) = (1e3, 0.3, 1.0);
    let (a, b) = (1.0_f64, 2.0_f64);
    let law = LinearElastic::new(E, nu).expect("a law");
    let error = |cells: usize| {
        let ring = |r: [f64; 2], radial: usize, angles: usize| {
            let angles = linspace(0.0, std::f64::consts::FRAC_PI_2, angles * cells);
            let radii = linspace(r[0], r[1], radial * cells);
            let mesh = rectangle(&radii, &angles, Diagonals::Rising).expect("a mesh");
            let bent = |X: &Vector<2>| Vector::from([X[0] * X[1].cos(), X[0] * X[1].sin()]);
            mesh.quadratic().mapped(bent).expect("a mesh")
        };
        let held = |mesh: Mesh<2>| {
            let mut body = Body::new(mesh, law);
            body.prescribe("bottom", [None, Some(0.0)])
                .expect("a support");
            body.prescribe("top", [Some(0.0), None]).expect("a support");
            body
        };
        let mut inner = held(ring([a, 1.4], 1, 3));
        inner.pressure("left", p).expect("a load");
        let outer = held(ring([1.4, b], 2, 4));
        let mut scene = Scene::new();
        let (inner, outer) = (scene.add("inner", inner), scene.add("outer", outer));
        scene
            .tie(inner.on("right"), outer.on("left"))
            .expect("a tie");
        let (problem, history) = solved(scene, Simulation::with_increments(1));
        let U = problem.displacements(&history.run.state.u);
        let exact = |r: f64| {
            p * a * a / (b * b - a * a) * (1.0 + nu) / E * ((1.0 - 2.0 * nu) * r + b * b / r)
        };
        let off = problem.reference().iter().zip(&U);
        let off = off.map(|(X, u)| (u - X / X.norm() * exact(X.norm())).amax());
        off.fold(0.0, f64::max) / exact(a)
    };
    let errors = [1, 2, 4].map(error);
    let order = (errors[1] / errors[2]).log2();
    println!("pipe {errors:?}, order {order}");
    assert!(errors[2] < 1e-4 && order > 2.5, "{errors:?} {order}");
}

/// A bar in two halves with meshes that do not match: a tie that draws one into the other strains the bar as a displacement of its end does.
#[test]
fn a_jump_draws_a_bar_as_its_end_would() {
    let delta = 0.1;
    let half = |x: usize, y: [f64; 2], cells: usize| {
        let (across, up) = (linspace(0.0, 1.0, x), linspace(y[0], y[1], cells));
        rectangle(&across, &up, Diagonals::Rising).expect("a mesh")
    };
    let law = || NeoHookean::new(100.0, 0.0).expect("a law");
    let held = |mesh, on: &str, by: f64| {
        let mut body = Body::new(mesh, law());
        body.symmetry("left").expect("held");
        body.prescribe(on, [None, Some(by)]).expect("held");
        body
    };
    for (slave, sign) in [
        (TiedSlave::First, 1.0),
        (TiedSlave::Second, 1.0),
        (TiedSlave::Finer, -1.0),
    ] {
        let mut scene = Scene::new();
        let lower = scene.add("lower", held(half(3, [0.0, 1.0], 4), "bottom", 0.0));
        let upper = scene.add("upper", held(half(4, [1.0, 2.0], 3), "top", 0.0));
        let tie = Tie {
            slave,
            jump: vec![0.0, -sign * delta],
            ..Tie::new(lower.on("top"), upper.on("bottom"))
        };
        scene.tie_as(tie).expect("a tie");
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(4)
            .run(&mut problem)
            .expect("a run");
        assert!(history.is_complete());
        let last = history.last().expect("a step");
        assert!(
            last.certificate.holds(&Limits::default()),
            "{}",
            last.certificate
        );
        // one body, drawn by as much
        let mut scene = Scene::new();
        let mut whole = held(half(3, [0.0, 2.0], 8), "bottom", 0.0);
        whole
            .prescribe("top", [None, Some(sign * delta)])
            .expect("drawn");
        let whole = scene.add("whole", whole);
        let mut problem = scene.problem().expect("a problem");
        let drawn = Simulation::with_increments(4)
            .run(&mut problem)
            .expect("a run");
        let drawn = drawn.last().expect("a step");
        let force = drawn.reaction(whole)[1];
        // the reactions of both ends cancel in the whole body: that of its top alone
        let top = drawn
            .support_reactions
            .iter()
            .find(|(side, _)| side.boundary == "top");
        let top = top.expect("held").1[1];
        assert!(force.abs() < 1e-9 && top * sign > 1.0);
        assert!(
            (last.ties[0].force[1] - top).abs() < 1e-7 * top.abs(),
            "{:?} {top}",
            last.ties
        );
        assert!((last.stored_energy - drawn.stored_energy).abs() < 1e-8 * drawn.stored_energy);
        assert!((last.work() - drawn.work()).abs() < 1e-7 * drawn.stored_energy);
    }
}

/// A bar between walls, cut in two, whose halves draw each other by a force: it is stretched as by that force, and its halves move into
/// each other by what both give way. Whatever else acts on the bar, the force in the cut stays.
#[test]
fn a_preload_is_the_force_in_the_cut() {
    let (young, force) = (200.0, 6.0);
    let half = |x: [f64; 2], nx: usize, ny: usize| {
        let mesh = rectangle(
            &linspace(x[0], x[1], nx),
            &linspace(0.0, 0.5, ny),
            Diagonals::Rising,
        );
        Body::new(
            mesh.expect("a mesh").quadratic(),
            LinearElastic::new(young, 0.0).expect("a law"),
        )
    };
    for slave in [TiedSlave::First, TiedSlave::Second, TiedSlave::Finer] {
        for pulled in [0.0, 2.0] {
            let (mut left, mut right) = (half([0.0, 1.0], 5, 3), half([1.0, 3.0], 7, 4));
            left.prescribe("left", [Some(0.0); 2]).expect("a wall");
            right.prescribe("right", [Some(0.0); 2]).expect("a wall");
            // in the middle of the right half
            right.body_force([pulled, 0.0]).expect("a load");
            let mut scene = Scene::new();
            let (left, right) = (scene.add("left", left), scene.add("right", right));
            let tie = Tie {
                slave,
                preload: vec![force, 0.0],
                ..Tie::new(left.on("right"), right.on("left"))
            };
            scene.tie_as(tie).expect("a tie");
            let mut problem = scene.problem().expect("a problem");
            let history = Simulation::with_increments(2)
                .run(&mut problem)
                .expect("a run");
            assert!(history.is_complete());
            let last = history.last().expect("a step");
            assert!(
                last.certificate.holds(&Limits::default()),
                "{}",
                last.certificate
            );
            let record = &last.ties[0];
            assert!(
                (record.force[0] - force).abs() < 1e-9 * force,
                "{}",
                record.force
            );
            assert!(record.force[1].abs() < 1e-9, "{}", record.force);
            // each half by itself: u = F l/(E A), and the pull p l²/2E at the free end of the right half
            let rigidity = young * 0.5;
            let jump = -force * 3.0 / rigidity + pulled * 0.5 * 2.0 * 2.0 / 2.0 / rigidity;
            assert!(
                (record.jump[0] - jump).abs() < 1e-9,
                "{} {jump}",
                record.jump
            );
            assert!((last.reaction(left)[0] + force).abs() < 1e-8);
            // what the preload and the pull do is stored
            assert!((last.work() - last.stored_energy).abs() < 1e-9 * last.stored_energy);
        }
    }
}

/// Under any direction of the preload, in the plane and in space, at small and at large strains: a given jump by what the preload has moved the sides transmits
/// the preload.
#[test]
fn a_preload_and_its_jump_are_the_same() {
    fn check<const D: usize>(body: impl Fn(usize) -> Body<D>, sides: [&str; 2], preload: [f64; D]) {
        let along = Vector::from(preload).normalize();
        let run = |preload: Vec<f64>, jump: Vec<f64>| {
            let mut scene = Scene::<D>::new();
            let bodies = [0, 1].map(|k| scene.add(format!("half {k}"), body(k)));
            let tie = Tie {
                preload,
                jump,
                ..Tie::new(bodies[0].on(sides[0]), bodies[1].on(sides[1]))
            };
            scene.tie_as(tie).expect("a tie");
            let mut problem = scene.problem().expect("a problem");
            let history = Simulation::with_increments(3)
                .run(&mut problem)
                .expect("a run");
            assert!(history.is_complete(), "{}", history.run.ending);
            let last = history.last().expect("a step");
            assert!(
                last.certificate.holds(&Limits::default()),
                "{}",
                last.certificate
            );
            (last.ties[0].clone(), last.stored_energy)
        };
        let (by_force, stored) = run(preload.to_vec(), Vec::new());
        assert!((by_force.force.dot(&along) - Vector::from(preload).norm()).abs() < 1e-7);
        assert!((by_force.jump - along * by_force.jump.dot(&along)).norm() < 1e-12);
        let (by_way, same) = run(Vec::new(), by_force.jump.iter().copied().collect());
        let apart = (by_force.force - by_way.force).norm();
        assert!(
            apart < 1e-6 * by_way.force.norm(),
            "{} {}",
            by_force.force,
            by_way.force
        );
        assert!((stored - same).abs() < 1e-6 * same, "{stored} {same}");
    }
    let plane = |k: usize| {
        let [nx, ny] = [[3, 4], [4, 5]][k];
        let y = k as f64;
        let mesh = rectangle(
            &linspace(0.0, 1.0, nx),
            &linspace(y, y + 1.0, ny),
            Diagonals::Rising,
        );
        let mesh = mesh.expect("a mesh");
        let held = ["bottom", "top"][k];
        (mesh, held)
    };
    let small = |k: usize| {
        let (mesh, held) = plane(k);
        let mut body = Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"));
        body.prescribe(held, [Some(0.0); 2]).expect("a wall");
        body
    };
    let large = |k: usize| {
        let (mesh, held) = plane(k);
        let mut body = Body::new(
            mesh.quadratic(),
            NeoHookean::new(100.0, 0.3).expect("a law"),
        );
        body.prescribe(held, [Some(0.0); 2]).expect("a wall");
        body
    };
    for preload in [[0.0, 7.0], [2.0, 5.0], [-3.0, 0.0]] {
        check(small, ["top", "bottom"], preload);
        check(large, ["top", "bottom"], preload);
    }
    let space = |k: usize| {
        let cells = [[2, 2, 2], [3, 2, 2]][k];
        let mesh = cuboid([0.0, 0.0, k as f64], [1.0; 3], cells).expect("a mesh");
        let mut body = Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"));
        let held = ["bottom", "top"][k];
        body.prescribe(held, [Some(0.0); 3]).expect("a wall");
        body
    };
    check(space, ["top", "bottom"], [1.0, -0.5, 4.0]);
}

#[test]
fn preloads_that_cannot_be() {
    let body = |x: f64| {
        let mesh = rectangle(
            &linspace(x, x + 1.0, 2),
            &linspace(0.0, 1.0, 2),
            Diagonals::Rising,
        );
        let mut body = Body::new(
            mesh.expect("a mesh"),
            LinearElastic::new(1.0, 0.3).expect("a law"),
        );
        body.prescribe("bottom", [Some(0.0); 2]).expect("a support");
        body
    };
    let refused = |preload: Vec<f64>, jump: Vec<f64>| {
        let mut scene = Scene::<2>::new();
        let bodies = [0.0, 1.0].map(|x| scene.add(format!("at {x}"), body(x)));
        let tie = Tie {
            preload,
            jump,
            ..Tie::new(bodies[0].on("right"), bodies[1].on("left"))
        };
        scene.tie_as(tie).expect_err("refused").to_string()
    };
    assert!(refused(vec![1.0], Vec::new()).contains("components of the preload"));
    assert!(refused(vec![f64::NAN, 0.0], Vec::new()).contains("preload of a tie"));
    assert!(refused(vec![1.0, 0.0], vec![0.1, 0.0]).contains("beside its jump"));
    // all of both sides is held along the preload
    let mut scene = Scene::<2>::new();
    let bodies = [0.0, 1.0].map(|x| {
        let mut body = body(x);
        let side = if x == 0.0 { "right" } else { "left" };
        body.prescribe(side, [Some(0.0), None]).expect("a support");
        scene.add(format!("at {x}"), body)
    });
    let tie = Tie {
        preload: vec![1.0, 0.0],
        ..Tie::new(bodies[0].on("right"), bodies[1].on("left"))
    };
    scene.tie_as(tie).expect("declared");
    let told = scene.problem().err().expect("refused").to_string();
    assert!(told.contains("prescribed"), "{told}");
}
