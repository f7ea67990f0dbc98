//! What a scene does not need is left out, and doing it all the same changes nothing.

#![allow(non_snake_case)] // the symbols of the field

mod common;

use common::{relative, run_with};
use contact_core::InteriorPoint;
use contact_fem::mesh::generators::{Diagonals, disc, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LeftOut, LinearElastic, Material, NeoHookean, Scene};

/// A disc, whose inside cannot deform, on a block that is held below. The sides of the block are
/// part of its contact surface, though nothing comes near them.
fn disc_on_block<M: Material<2>>(law: M, keep_everything: bool, increments: usize) -> Outcome {
    let xs = linspace(-1.0, 1.0, 12);
    let mesh = rectangle(&xs, &linspace(-1.0, 0.0, 6), Diagonals::Alternating);
    let mut mesh = mesh.expect("mesh");
    mesh.name_boundary("skin", |X| X[1] > -1.0 || X[0].abs() == 1.0);
    let mut block = Body::new(mesh, law.clone());
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mesh = disc(0.3, 24, 3, 0.02).expect("mesh");
    let mut disc = Body::new(mesh.translated([0.1, 0.3]).expect("moved"), law);
    disc.prescribe_all([Some(0.0), Some(-0.03)])
        .expect("support");

    let mut scene = Scene::new(vec![block, disc]);
    scene.reach = Some(0.25);
    scene.keep_everything = keep_everything;
    scene.contact((0, "skin"), (1, "boundary")).expect("pair");
    let mut problem = scene.problem().expect("valid scene");
    // where rows are about to open, displacements follow the root of what is left of gap times force
    let mut method = InteriorPoint {
        complementarity: 1e-14,
        ..InteriorPoint::default()
    };
    let history = run_with(&mut method, &mut problem, increments, 1e-11);
    assert_eq!(history.steps.len(), increments, "{:?}", history.run.outcome);
    let step = history.steps.last().expect("converged");
    Outcome {
        displacements: problem.displacements(&history.run.state.u),
        energy: step.energy,
        reaction: step.reactions[0],
        left_out: LeftOut::new(&problem, &history),
    }
}

struct Outcome {
    displacements: Vec<Vector<2>>,
    energy: f64,
    reaction: Vector<2>,
    left_out: LeftOut,
}

fn same(a: &Outcome, b: &Outcome) {
    for (u, v) in a.displacements.iter().zip(&b.displacements) {
        assert!((u - v).amax() < 1e-10 * 0.03, "{u} {v}");
    }
    assert!(relative(a.energy, b.energy) < 1e-10);
    assert!((a.reaction - b.reaction).norm() < 1e-10 * a.reaction.norm());
}

#[test]
fn a_small_strain_scene_leaves_out_most() {
    let law = LinearElastic::new(10.0, 0.3).expect("law");
    let lean = disc_on_block(law, false, 1);
    let full = disc_on_block(law, true, 1);
    same(&lean, &full);
    let LeftOut {
        dofs,
        cells,
        rows,
        solves,
        hessians,
    } = lean.left_out;
    // 13 nodes below, and the disc's 1 + 3 · 24 nodes with its 24 · 5 cells
    assert_eq!((dofs, cells), (2 * (13 + 73), 120));
    assert_eq!(solves, 1);
    assert!(rows > 20 && hessians > 5, "{:?}", lean.left_out);
    // nothing that could be done is left, but rows of points that face away or are off an end
    let kept = full.left_out;
    assert_eq!((kept.dofs, kept.cells), (0, 0));
    assert_eq!((kept.solves, kept.hessians), (0, 0));
    assert!(kept.rows < rows);
}

#[test]
fn so_does_one_of_large_strains() {
    let law = NeoHookean::new(10.0, 0.3).expect("law");
    let lean = disc_on_block(law, false, 2);
    let full = disc_on_block(law, true, 2);
    same(&lean, &full);
    assert_eq!((lean.left_out.cells, full.left_out.cells), (120, 0));
    assert_eq!(lean.left_out.solves, 0);
}

#[test]
fn no_pair_no_rows() {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 3),
        &linspace(0.0, 1.0, 3),
        Diagonals::Rising,
    );
    let mut block = Body::new(
        mesh.expect("mesh"),
        NeoHookean::new(10.0, 0.3).expect("law"),
    );
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    block.traction("top", [0.0, -1.0]).expect("load");
    let mut problem = Scene::new(vec![block]).problem().expect("valid scene");
    assert_eq!(problem.contact_nodes(), 0);
    let history = run_with(&mut InteriorPoint::default(), &mut problem, 1, 1e-6);
    let step = history.steps.last().expect("converged");
    assert_eq!((step.rows, step.attempt.iterations.len()), (0, 1));
}
