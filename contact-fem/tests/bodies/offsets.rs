//! Pairs that keep a distance: coatings and sheets without a mesh.
#![allow(non_snake_case)]

use contact_fem::mesh::generators::{Diagonals, annulus, disc, linspace, rectangle};
use contact_fem::model::{InitialGaps, Passes};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Mesh, NeoHookean, Scene};

use crate::common::{at, ended};

/// A block above another one, with a narrower foot, pressed and pushed aside at large strains: `apart` at first, of which `offset` is kept.
fn pressed(apart: f64, offset: f64, passes: Passes, quadratic: bool) -> Scene<2> {
    let block = |x: [f64; 2], y: f64, n: [usize; 2]| {
        let mesh = rectangle(
            &linspace(x[0], x[1], n[0]),
            &linspace(y, y + 1.0, n[1]),
            Diagonals::Alternating,
        );
        let mesh = mesh.expect("a mesh");
        let mesh = if quadratic { mesh.quadratic() } else { mesh };
        Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("a law"))
    };
    let (mut below, mut above) = (
        block([0.0, 3.0], 0.0, [10, 4]),
        block([0.8, 1.9], 1.0 + apart, [4, 4]),
    );
    below
        .prescribe("bottom", [Some(0.0); 2])
        .expect("a support");
    above
        .prescribe("top", [Some(0.3), Some(-0.15)])
        .expect("a support");
    let mut scene = Scene::new();
    let sides = [
        scene.add("below", below).on("top"),
        scene.add("above", above).on("bottom"),
    ];
    scene
        .contact_in_passes(sides[0].clone(), sides[1].clone(), passes)
        .expect("a pair");
    if offset > 0.0 {
        scene
            .contact_offset(&sides[0], &sides[1], offset)
            .expect("an offset");
    }
    scene
}

/// One flat rigid face keeps the distance as if it were nearer by that: of a block on a rigid block.
#[test]
fn on_a_flat_side_it_is_a_translation() {
    let run = |apart: f64, offset: f64, quadratic: bool| {
        let block = |y: f64| {
            let mesh = rectangle(
                &linspace(0.0, 1.0, 4),
                &linspace(y, y + 1.0, 4),
                Diagonals::Rising,
            );
            let mesh = mesh.expect("a mesh");
            if quadratic { mesh.quadratic() } else { mesh }
        };
        let mut below = Body::rigid(block(0.0));
        below.prescribe_all([Some(0.0); 2]).expect("held");
        let mut above = Body::new(
            block(1.0 + apart),
            NeoHookean::new(100.0, 0.3).expect("a law"),
        );
        above
            .prescribe("top", [Some(0.02), Some(-0.15)])
            .expect("a support");
        let mut scene = Scene::new();
        let sides = [
            scene.add("below", below).on("top"),
            scene.add("above", above).on("bottom"),
        ];
        scene
            .contact(sides[0].clone(), sides[1].clone())
            .expect("a pair");
        scene
            .contact_offset(&sides[0], &sides[1], offset)
            .expect("an offset");
        let history = ended(&mut scene.problem().expect("a problem"), 3);
        let last = history.last().expect("a step");
        (last.stored_energy, last.reactions[1])
    };
    for quadratic in [false, true] {
        let ((energy, force), (other, by)) =
            (run(0.08, 0.05, quadratic), run(0.03, 0.0, quadratic));
        assert!(
            energy > 0.3 && (energy - other).abs() < 1e-7 * other,
            "{energy} {other}"
        );
        assert!((force - by).norm() < 1e-7 * by.norm(), "{force} {by}");
    }
}

/// Where both sides give way and the foot's corners dig in, a small distance changes what a translation would not by its square: normals turn.
#[test]
fn it_is_nearly_a_translation_elsewhere() {
    for (passes, quadratic) in [
        (Passes::Both, false),
        (Passes::FirstIsSlave, false),
        (Passes::Both, true),
    ] {
        let run = |apart, offset| {
            let scene = pressed(apart, offset, passes, quadratic);
            let history = ended(&mut scene.problem().expect("a problem"), 4);
            history.last().expect("a step").stored_energy
        };
        let (with, without) = (run(0.02, 0.02), run(0.0, 0.0));
        assert!((with / without - 1.0).abs() < 0.03, "{with} {without}");
    }
}

/// A coated disc in a ring: the interference is the coat less the gap. By Lamé's formulas, at small strains, with curved cells.
#[test]
fn a_coat_between_a_disc_and_a_ring() {
    let (inner, outer, gap, coat) = (1.0, 2.0, 0.002, 0.003);
    let (young, nu) = (100.0, 0.3);
    let law = || LinearElastic::new(young, nu).expect("a law");
    let round = |mesh: Mesh<2>, name: &str, R: f64| {
        mesh.quadratic()
            .curved(name, |X: &Vector<2>| X * (R / X.norm()))
            .expect("a curve")
    };
    let hub = annulus(&linspace(inner, outer, 6), 48, Diagonals::Rising).expect("a mesh");
    let mut hub = Body::new(round(hub, "inner", inner), law());
    // three nodes on lines of symmetry hold rigid motions
    let shaft = disc(inner - gap, 36, 8, 0.0).expect("a mesh");
    let mut shaft = Body::new(round(shaft, "boundary", inner - gap), law());
    for body in [&mut hub, &mut shaft] {
        let nodes = body.mesh().nodes().iter().enumerate();
        let (mut on_x, mut on_y) = (Vec::new(), Vec::new());
        for (a, X) in nodes {
            if X[1].abs() < 1e-9 {
                on_x.push(a);
            }
            if X[0].abs() < 1e-9 {
                on_y.push(a);
            }
        }
        body.prescribe_nodes(&on_x, [None, Some(0.0)])
            .expect("a support");
        body.prescribe_nodes(&on_y, [Some(0.0), None])
            .expect("a support");
    }
    let mut scene = Scene::new();
    let sides = [
        scene.add("hub", hub).on("inner"),
        scene.add("shaft", shaft).on("boundary"),
    ];
    scene
        .contact(sides[0].clone(), sides[1].clone())
        .expect("a pair");
    scene
        .contact_offset(&sides[0], &sides[1], coat)
        .expect("an offset");
    scene.initial_gaps = InitialGaps::Resolve;
    let mut problem = scene.problem().expect("a problem");
    let history = ended(&mut problem, 1);
    let last = history.last().expect("a step");
    // how far each side gives way under a pressure of 1: a disc, and a ring
    let shaft = (inner - gap) * (1.0 + nu) * (1.0 - 2.0 * nu) / young;
    let squares = [inner, outer].map(|r: f64| r * r);
    let ring = inner * (1.0 + nu) / young * ((1.0 - 2.0 * nu) * squares[0] + squares[1])
        / (squares[1] - squares[0]);
    let pressure = (coat - gap) / (shaft + ring);
    // the rim goes out by 2 p a² b (1 − ν²)/E/(b² − a²)
    let rim =
        2.0 * pressure * squares[0] * outer * (1.0 - nu * nu) / young / (squares[1] - squares[0]);
    let u = &history.run.solution.as_ref().expect("a solution").state.u;
    let moved = at(&problem, u, [outer, 0.0])[0];
    assert!((moved / rim - 1.0).abs() < 5e-3, "{moved} {rim}");
    // cells that do not match leave some ripple
    for found in last.pressures {
        assert!((found / pressure - 1.0).abs() < 0.08, "{found} {pressure}");
    }
}

#[test]
fn offsets_that_cannot_be() {
    let scene = |apart: f64| {
        let block = |y: f64| {
            rectangle(
                &linspace(0.0, 1.0, 4),
                &linspace(y, y + 1.0, 4),
                Diagonals::Rising,
            )
            .expect("a mesh")
        };
        let law = || LinearElastic::new(1.0, 0.3).expect("a law");
        let (mut below, mut above) = (
            Body::new(block(0.0), law()),
            Body::new(block(1.0 + apart), law()),
        );
        below
            .prescribe("bottom", [Some(0.0); 2])
            .expect("a support");
        above
            .prescribe("top", [Some(0.0), Some(-0.01)])
            .expect("a support");
        let mut scene = Scene::new();
        let sides = [
            scene.add("below", below).on("top"),
            scene.add("above", above).on("bottom"),
        ];
        scene
            .contact(sides[0].clone(), sides[1].clone())
            .expect("a pair");
        (scene, sides)
    };
    let (mut own, sides) = scene(0.1);
    for wrong in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = own.contact_offset(&sides[0], &sides[1], wrong);
        assert!(matches!(
            refused,
            Err(Error::Setting {
                name: "offset of a pair",
                ..
            })
        ));
    }
    assert!(matches!(
        own.contact_offset(&sides[0], &sides[0], 0.1),
        Err(Error::NoPair { .. })
    ));
    // they start closer than they keep
    own.contact_offset(&sides[0], &sides[1], 0.2)
        .expect("an offset");
    assert!(matches!(own.problem().err(), Some(Error::Overlap { .. })));
    let (mut own, sides) = scene(0.3);
    own.reach = Some(0.5);
    own.contact_offset(&sides[0], &sides[1], 0.2)
        .expect("an offset");
    let told = own.problem().err().expect("refused").to_string();
    assert!(told.contains("offset of a pair"), "{told}");
}
