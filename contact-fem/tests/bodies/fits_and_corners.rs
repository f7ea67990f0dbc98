//! Bodies that start deep inside each other, and corners that dig in.

use std::f64::consts::TAU;

use contact_fem::mesh::generators::{Diagonals, annulus, linspace, rectangle};
use contact_fem::model::{Corners, InitialGaps, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{
    Body, Error, LinearElastic, Material, Motion, NeoHookean, Obstacle, Scene, Simulation,
};

use crate::common::ended;

/// A shaft from radius 1 to 2 + d/2 in a ring from 2 − d/2 to `outer`, free but for rigid motions.
fn fit<M: Material<2> + 'static>(
    d: f64,
    outer: f64,
    segments: usize,
    law: impl Fn() -> M,
) -> Scene<2> {
    let mut scene = Scene::new();
    let mut sides = Vec::new();
    for (name, [a, b], at) in [
        ("shaft", [1.0, 2.0 + d / 2.0], 1.0),
        ("ring", [2.0 - d / 2.0, outer], outer),
    ] {
        let mesh = annulus(
            &linspace(a, b, segments / 8),
            segments,
            Diagonals::Alternating,
        );
        let mesh = mesh.expect("a mesh");
        let node = |x: [f64; 2]| {
            let mut nodes = (0..mesh.nodes().len())
                .filter(|&k| (mesh.nodes()[k] - Vector::<2>::from(x)).norm() < 1e-9);
            nodes.next().expect("a node")
        };
        let on_x = [[at, 0.0], [-at, 0.0]].map(node);
        let on_y = [[0.0, at], [0.0, -at]].map(node);
        let mut body = Body::new(mesh, law());
        body.prescribe_nodes(&on_x, [None, Some(0.0)])
            .expect("nodes");
        body.prescribe_nodes(&on_y, [Some(0.0), None])
            .expect("nodes");
        sides.push(scene.add(name, body));
    }
    scene
        .contact(sides[0].on("outer"), sides[1].on("inner"))
        .expect("a pair");
    scene.initial_gaps = InitialGaps::Resolve;
    scene
}

/// Lamé's energy of such a fit, plane strain. The force on a sector is the same on both bodies, whose radii differ by the interference.
fn lame(d: f64, outer: f64, [young, nu]: [f64; 2]) -> f64 {
    let shear = young / (2.0 * (1.0 + nu));
    let [shaft, ring] = [2.0 + d / 2.0, 2.0 - d / 2.0];
    // u = (A (1 − 2ν) r + B/r)/2G for σ_r = A − B/r², by a force of 1 a radian
    let stress = -1.0 / shaft / (1.0 - 1.0 / (shaft * shaft));
    let shrinks = -(stress * (1.0 - 2.0 * nu) * shaft + stress / shaft) / (2.0 * shear);
    let (a2, b2) = (ring * ring, outer * outer);
    let stress = 1.0 / ring * a2 / (b2 - a2);
    let widens = (stress * (1.0 - 2.0 * nu) * ring + stress * b2 / ring) / (2.0 * shear);
    0.5 * TAU * d * d / (shrinks + widens)
}

fn energy(problem: &mut Problem<2>, increments: usize) -> f64 {
    let history = ended(problem, increments);
    history.last().expect("a step").energy
}

/// Interferences of .3 to 3 facets have Lamé's energy, to what the mesh is stiffer by; under large strains a little less.
#[test]
fn a_fit_deeper_than_its_facets() {
    let [young, nu] = [1000.0, 0.3];
    for (d, within) in [(0.03, 1.5e-3), (0.1, 1.5e-3), (0.3, 1.5e-3)] {
        let law = || LinearElastic::new(young, nu).expect("a law");
        let mut problem = fit(d, 3.0, 120, law).problem().expect("a problem");
        let (found, expected) = (energy(&mut problem, 1), lame(d, 3.0, [young, nu]));
        let apart = found / expected - 1.0;
        assert!((0.0..within).contains(&apart), "{d}: {found} {expected}");
    }
    let law = || NeoHookean::new(young, nu).expect("a law");
    let mut problem = fit(0.1, 3.0, 120, law).problem().expect("a problem");
    let (found, expected) = (energy(&mut problem, 4), lame(0.1, 3.0, [young, nu]));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

/// A fit of half the ring's thickness is refused, and the error tells what would do.
#[test]
fn a_fit_as_deep_as_a_body_is_refused() {
    let law = || LinearElastic::new(1000.0, 0.3).expect("a law");
    let Err(error) = fit(0.3, 2.45, 120, law).problem() else {
        panic!("a problem");
    };
    assert!(
        matches!(error, Error::Overlap { .. } | Error::Crossing { .. }),
        "{error}"
    );
    assert!(
        error.to_string().contains("0.4 of the thinner body"),
        "{error}"
    );
}

/// A wedge that a block of soft facets is pressed onto: how deep its tip is in the block at the end, as a share of the facets.
fn dug(corners: Corners) -> f64 {
    let cells = 6;
    let xs = linspace(0.0, 1.5, cells);
    let mesh = rectangle(&xs, &linspace(0.0, 1.0, 4), Diagonals::Alternating).expect("a mesh");
    let mut block = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("a law"));
    block
        .prescribe("bottom", [Some(0.0), Some(0.0)])
        .expect("a boundary");
    let mut scene = Scene::new();
    let block = scene.add("block", block);
    let tip = [0.6, 1.0];
    let wedge = [tip, [1.0, 2.0], [0.2, 2.0]];
    let wedge = Obstacle::surface(&wedge, &[[0, 1], [1, 2], [2, 0]]).expect("a wedge");
    let down = Motion::translation([0.0, -0.1]).expect("a motion");
    scene
        .obstacle("wedge", block.on("top"), wedge.moving(down))
        .expect("a side");
    scene.corners = corners;
    let mut problem = scene.problem().expect("a problem");
    let history = Simulation::with_increments(10)
        .run(&mut problem)
        .expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let u = &history.run.solution.as_ref().expect("a solution").state.u;
    let x = problem.positions(u);
    let surface = &problem.surfaces()[0];
    let depth = surface.facets().find_map(|facet| {
        let [a, b] = [0, 1].map(|k| x[surface.nodes()[facet[k]]]);
        let t = (tip[0] - a[0]) / (b[0] - a[0]);
        (0.0..=1.0)
            .contains(&t)
            .then(|| a[1] + t * (b[1] - a[1]) - (tip[1] - 0.1))
    });
    depth.expect("a facet below the tip") / 0.25
}

/// A sharp tip digs in by a twentieth of a facet at most; by what its row has not, it digs several times deeper.
#[test]
fn a_sharp_tip_is_held() {
    let (held, weak) = (dug(Corners::Held), dug(Corners::Weak));
    println!("a tip is {held} facets deep, without its row {weak}");
    assert!(held < 0.06 && weak > 2.0 * held, "{held} {weak}");
}
