//! Bodies of several laws, and of laws that vary.
#![allow(non_snake_case)]

use contact_fem::material::Lame;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{
    Body, Error, LinearElastic, Mesh, MeshFile, NeoHookean, Obstacle, Scene, Simulation,
};

fn layers(length: f64, cells: usize) -> Mesh<2> {
    let xs = linspace(0.0, length, cells);
    let mut mesh = rectangle(&xs, &linspace(0.0, 1.0, 4), Diagonals::Rising).expect("a mesh");
    mesh.name_region("lower", |X| X[1] < 0.5);
    mesh.name_region("upper", |X| X[1] > 0.5);
    mesh
}

/// Displacements and the last energy of a body by itself.
fn solved<const D: usize>(body: Body<D>, increments: usize) -> (Vec<Vector<D>>, f64) {
    let mut scene = Scene::new();
    scene.add("body", body);
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(increments).run(&mut problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let moved = problem.displacements(&history.run.state.u);
    (moved, history.last().expect("a step").energy)
}

/// Two layers in series under one pressure, with lateral strain held: heights shrink by p h/(λ + 2μ) each, of both orders.
#[test]
fn layers_in_series() {
    let laws = [(100.0, 0.2), (400.0, 0.4)];
    let law = |k: usize| LinearElastic::new(laws[k].0, laws[k].1).expect("a law");
    let stiffness = laws.map(|(E, nu)| {
        let Lame { lambda, mu } = Lame::new(E, nu).expect("valid");
        lambda + 2.0 * mu
    });
    for is_quadratic in [false, true] {
        let mesh = layers(1.0, 3);
        let mesh = if is_quadratic { mesh.quadratic() } else { mesh };
        // in the order of the regions' names or not
        let mut body = Body::with_laws(mesh, [("upper", law(1)), ("lower", law(0))]).expect("laws");
        let held = body.symmetry("left").and_then(|b| b.symmetry("right"));
        let held = held.and_then(|b| b.symmetry("bottom"));
        held.and_then(|b| b.traction("top", [0.0, -2.0]))
            .expect("a load");
        let nodes = body.mesh().nodes().to_vec();
        let (moved, _) = solved(body, 1);
        for (X, u) in nodes.iter().zip(&moved) {
            let (low, high) = (X[1].min(0.5), (X[1] - 0.5).max(0.0));
            let exact = -2.0 * (low / stiffness[0] + high / stiffness[1]);
            assert!(
                (u[1] - exact).abs() < 1e-13 && u[0].abs() < 1e-13,
                "{u} at {X}"
            );
        }
    }
}

/// A laminate, drawn along its layers and free across (ν = 0): stresses E ε of each, in parallel, and it bends towards the stiff layer
/// if it may. The neutral axis is at Σ E y A/Σ E A.
#[test]
fn a_bonded_laminate() {
    let law = |E: f64| LinearElastic::new(E, 0.0).expect("a law");
    let laminate = || {
        let laws = [("lower", law(100.0)), ("upper", law(300.0))];
        Body::with_laws(layers(8.0, 32).quadratic(), laws).expect("laws")
    };
    let mut drawn = laminate();
    let held = drawn.symmetry("left").and_then(|b| b.symmetry("bottom"));
    held.and_then(|b| b.prescribe("right", [Some(0.08), None]))
        .expect("held");
    let (_, energy) = solved(drawn, 1);
    let exact = 0.5 * 0.01 * 0.01 * 8.0 * (0.5 * 100.0 + 0.5 * 300.0);
    assert!((energy / exact - 1.0).abs() < 1e-11, "{energy}");

    // pure bending by a linear displacement of the right end about the neutral axis
    let neutral = (100.0 * 0.25 + 300.0 * 0.75) / 400.0;
    let mut bent = laminate();
    bent.symmetry("left").expect("a side");
    let corner = bent.mesh().nodes().iter().position(|X| X.norm() < 1e-12);
    let corner = [corner.expect("a corner")];
    bent.prescribe_nodes(&corner, [None, Some(0.0)])
        .expect("a node");
    let curvature = 1e-3;
    let stresses = move |X: &Vector<2>| {
        let E = if X[1] < 0.5 { 100.0 } else { 300.0 };
        Vector::<2>::new(E * curvature * (X[1] - neutral), 0.0)
    };
    bent.traction_field("right", stresses).expect("a side");
    let nodes = bent.mesh().nodes().to_vec();
    let (moved, _) = solved(bent, 1);
    for (X, u) in nodes.iter().zip(&moved) {
        let exact = Vector::<2>::new(
            curvature * (X[1] - neutral) * X[0],
            -0.5 * curvature * X[0] * X[0],
        );
        assert!((u - exact).norm() < 1e-10, "{u} is not {exact} at {X}");
    }
}

/// A bar of E(x) = 100 (1 + x), ν = 0, drawn by a force: u = F ∫ dx/E = F/100 ln(1 + x).
#[test]
fn a_graded_bar() {
    let worst = |cells: usize| {
        let mesh = rectangle(
            &linspace(0.0, 2.0, cells),
            &linspace(0.0, 0.2, 1),
            Diagonals::Rising,
        );
        let law = |X: &Vector<2>| LinearElastic::new(100.0 * (1.0 + X[0]), 0.0);
        let mut bar = Body::graded(mesh.expect("a mesh").quadratic(), law).expect("laws");
        let held = bar.symmetry("left").and_then(|b| b.symmetry("bottom"));
        held.and_then(|b| b.traction("right", [3.0, 0.0]))
            .expect("held");
        let nodes = bar.mesh().nodes().to_vec();
        let (moved, _) = solved(bar, 1);
        let exact = |X: &Vector<2>| 0.03 * (1.0 + X[0]).ln();
        let apart = nodes
            .iter()
            .zip(&moved)
            .map(|(X, u)| (u[0] - exact(X)).abs());
        apart.fold(0.0, f64::max)
    };
    let errors = [worst(32), worst(64)];
    // quadratic elements: third order
    assert!(
        errors[0] < 2e-7 && errors[1] < errors[0] / 6.5,
        "{errors:?}"
    );
}

/// A block of two laws in large strains on a floor is the stack of two blocks of which the lower presses the upper: contact of regions
/// against a bonded body whose layers do not slide, as ν is 0.
#[test]
fn two_regions_are_two_blocks_in_contact() {
    let law = |E: f64| NeoHookean::new(E, 0.0).expect("a law");
    let block = |low: f64, high: f64, cells: usize| {
        cuboid([0.0, 0.0, low], [1.0, 1.0, high - low], [2, 2, cells]).expect("a mesh")
    };
    let sides = |body: &mut Body<3>| {
        for side in ["left", "front", "right", "back"] {
            body.symmetry(side).expect("a side");
        }
    };
    let reaction = |scene: Scene<3>| {
        let mut problem = scene.problem().expect("a problem");
        let history = Simulation::with_increments(2).run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete(), "{}", history.run.ending);
        history.last().expect("a step").obstacle_forces[0][2]
    };
    let floor = || Obstacle::half_space([0.0; 3], [0.0, 0.0, 1.0]).expect("a floor");

    let mut mesh = block(0.0, 1.0, 4);
    mesh.name_region("lower", |X| X[2] < 0.5);
    mesh.name_region("upper", |X| X[2] > 0.5);
    let mut whole =
        Body::with_laws(mesh, [("lower", law(10.0)), ("upper", law(30.0))]).expect("laws");
    sides(&mut whole);
    whole
        .prescribe("top", [None, None, Some(-0.2)])
        .expect("a side");
    let mut scene = Scene::new();
    let whole = scene.add("whole", whole);
    scene
        .obstacle("floor", whole.on("bottom"), floor())
        .expect("a surface");
    let bonded = reaction(scene);

    let (mut lower, mut upper) = (
        Body::new(block(0.0, 0.5, 2), law(10.0)),
        Body::new(block(0.5, 1.0, 2), law(30.0)),
    );
    sides(&mut lower);
    sides(&mut upper);
    upper
        .prescribe("top", [None, None, Some(-0.2)])
        .expect("a side");
    let mut scene = Scene::new();
    let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    scene
        .obstacle("floor", lower.on("bottom"), floor())
        .expect("a surface");
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    let stacked = reaction(scene);

    // held laterally with λ = 0: μ (s − 1/s) is the same in both layers, and heights s add up to 0.8
    let pressure = |s: f64, E: f64| 0.5 * E * (1.0 / s - s);
    let (mut low, mut high) = (0.1, 0.8);
    for _ in 0..100 {
        let s = 0.5 * (low + high);
        match pressure(s, 10.0) > pressure(1.6 - s, 30.0) {
            true => low = s,
            false => high = s,
        }
    }
    let exact = -pressure(low, 10.0);
    assert!((bonded / exact - 1.0).abs() < 1e-7, "{bonded}, {exact}");
    assert!((stacked / exact - 1.0).abs() < 1e-6, "{stacked}, {exact}");
}

/// Cells without a law, with two, regions that there are not, and laws that are none are named.
#[test]
fn wrong_regions_are_named() {
    let law = |E: f64| LinearElastic::new(E, 0.3).expect("a law");
    let refused = |laws: &[(&str, LinearElastic)]| {
        let mut mesh = layers(1.0, 2);
        mesh.name_region("all", |_| true);
        Body::with_laws(mesh, laws.iter().copied()).err()
    };
    let several = |laws: &[(&str, LinearElastic)]| match refused(laws) {
        Some(Error::LawsOfCell { several, .. }) => several,
        other => panic!("{other:?}"),
    };
    assert!(!several(&[("lower", law(1.0))]));
    assert!(!several(&[]));
    assert!(several(&[("lower", law(1.0)), ("all", law(2.0))]));
    assert!(refused(&[("lower", law(1.0)), ("upper", law(2.0))]).is_none());
    let unknown = refused(&[("middle", law(1.0))]).expect("there is none");
    let told = unknown.to_string();
    assert!(
        told.contains("`middle`") && told.contains("lower"),
        "{told}"
    );
    let graded = Body::graded(layers(1.0, 2), |X| NeoHookean::new(X[0] - 0.5, 0.3));
    assert!(matches!(graded, Err(Error::YoungsModulus { .. })));
}

/// Regions of a file are those of its labels; a labelled edge between them is none of the boundary.
#[test]
fn regions_of_a_file() {
    let text = "6 4 7  0 0 0  1 0 0  2 0 0  2 1 0  1 1 0  0 1 0 \
                1 2 5 7  1 5 6 7  2 3 4 3  2 4 5 3 \
                1 2 1  2 3 1  3 4 2  4 5 3  5 6 3  6 1 4  2 5 9";
    let file = MeshFile::parse(text.as_bytes()).expect("a mesh");
    let mesh = file.with_regions::<2>().expect("a body");
    assert_eq!(mesh.region_names().collect::<Vec<_>>(), ["3", "7"]);
    for (name, is_left) in [("7", true), ("3", false)] {
        let cells = mesh.region_cells(name).expect("a region");
        assert_eq!(cells.len(), 2);
        for &cell in cells {
            let corners = mesh.corners(cell).iter().map(|&a| mesh.nodes()[a][0]);
            assert_eq!(corners.sum::<f64>() / 3.0 < 1.0, is_left);
        }
    }
    assert_eq!(mesh.parts().len(), 1);
    assert_eq!(
        mesh.boundary_names().collect::<Vec<_>>(),
        ["1", "2", "3", "4"]
    );
    assert_eq!(
        mesh.inner_facets()
            .map(|(name, f)| (name, f.len()))
            .collect::<Vec<_>>(),
        [("9", 1)]
    );
    assert!(mesh.quadratic().region_cells("7").is_ok());
}
