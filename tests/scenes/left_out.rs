//! What a scene does not need is left out, and doing it all the same changes nothing.

use crate::common::{relative, run_with};
use crate::support::hairpin;
use contact_core::InteriorPoint;
use contact_core::load_steps::RunOutcome;
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, cuboid, disc, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LeftOut, LinearElastic, Material, Mesh, NeoHookean, Scene};

fn of_order<const D: usize>(mesh: Mesh<D>, order: Order) -> Mesh<D> {
    match order {
        Order::Linear => mesh,
        Order::Quadratic => mesh.quadratic(),
    }
}

/// A disc, whose inside cannot deform, on a block that is held below. The sides of the block are
/// part of its contact surface, though nothing comes near them.
fn disc_on_block<M: Material<2>>(law: M, order: Order) -> Scene<2> {
    let xs = linspace(-1.0, 1.0, 12);
    let mesh = rectangle(&xs, &linspace(-1.0, 0.0, 6), Diagonals::Alternating);
    let mut mesh = of_order(mesh.expect("mesh"), order);
    mesh.name_boundary("skin", |X| X[1] > -1.0 || X[0].abs() == 1.0);
    let mut block = Body::new(mesh, law.clone());
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let mesh = of_order(disc(0.3, 24, 3, 0.02).expect("mesh"), order);
    let mut disc = Body::new(mesh.translated([0.1, 0.3]).expect("moved"), law);
    disc.prescribe_all([Some(0.0), Some(-0.03)])
        .expect("support");

    let mut scene = Scene::new(vec![block, disc]);
    scene.reach = Some(0.25);
    scene.contact((0, "skin"), (1, "boundary")).expect("pair");
    scene
}

/// A cube of rigid motion pressed obliquely into a larger block, all of which may be touched.
fn cube_on_block<M: Material<3>>(law: M, order: Order) -> Scene<3> {
    let mesh = cuboid([0.0; 3], [1.0, 1.1, 0.6], [3, 3, 2]).expect("mesh");
    let mut mesh = of_order(mesh, order);
    mesh.name_boundary("skin", |_| true);
    let mut block = Body::new(mesh, law.clone());
    block.prescribe("bottom", [Some(0.0); 3]).expect("support");
    let mesh = cuboid([0.23, 0.31, 0.61], [0.4; 3], [2; 3]).expect("mesh");
    let mut cube = Body::new(of_order(mesh, order), law);
    cube.prescribe_all([Some(0.01), Some(0.005), Some(-0.04)])
        .expect("support");

    let mut scene = Scene::new(vec![block, cube]);
    scene.reach = Some(0.2);
    scene.contact((0, "skin"), (1, "bottom")).expect("pair");
    scene
}

/// The scene walked to full load; what can be left out, is, or is not.
fn solved<const D: usize>(
    mut scene: Scene<D>,
    keep_everything: bool,
    increments: usize,
) -> Outcome<D> {
    scene.keep_everything = keep_everything;
    let mut problem = scene.problem().expect("valid scene");
    // where rows are about to open, displacements follow the root of what is left of gap times force
    let mut method = InteriorPoint {
        complementarity: 1e-14,
        ..InteriorPoint::default()
    };
    let history = run_with(&mut method, &mut problem, increments, 1e-11);
    assert_eq!(history.run.outcome, RunOutcome::Complete);
    let step = history.steps.last().expect("converged");
    let solution = history.run.solution.as_ref().expect("converged");
    let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
    Outcome {
        displacements: problem.displacements(&history.run.state.u),
        energy: step.energy,
        reaction: step.reactions[0],
        contact: contact.iter().map(|force| force.norm()).sum(),
        rows: step.rows,
        left_out: LeftOut::new(&problem, &history),
    }
}

struct Outcome<const D: usize> {
    displacements: Vec<Vector<D>>,
    energy: f64,
    reaction: Vector<D>,
    /// Σ |Cᵀλ| over the nodes, which a body that touches itself has, too.
    contact: f64,
    rows: usize,
    left_out: LeftOut,
}

fn same<const D: usize>(a: &Outcome<D>, b: &Outcome<D>) {
    let all = a.displacements.iter();
    let largest = all.map(|u| u.amax()).fold(0.0, f64::max);
    for (u, v) in a.displacements.iter().zip(&b.displacements) {
        assert!((u - v).amax() < 1e-10 * largest, "{u} {v}");
    }
    assert!(relative(a.energy, b.energy) < 1e-10);
    assert!(relative(a.contact, b.contact) < 1e-10);
    // of one body alone nothing is left of it
    let error = (a.reaction - b.reaction).norm();
    let force = match a.reaction.norm() < 1e-10 * a.contact {
        true => a.contact,
        false => a.reaction.norm(),
    };
    assert!(error < 1e-10 * force, "{error}");
}

/// Both ways, with the same result.
fn lean_and_full<const D: usize>(
    scene: impl Fn() -> Scene<D>,
    increments: usize,
) -> [Outcome<D>; 2] {
    let both = [false, true].map(|keep| solved(scene(), keep, increments));
    same(&both[0], &both[1]);
    both
}

#[test]
fn a_small_strain_scene_leaves_out_most() {
    let law = LinearElastic::new(10.0, 0.3).expect("law");
    let [lean, full] = lean_and_full(|| disc_on_block(law, Order::Linear), 1);
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
    let [lean, full] = lean_and_full(|| disc_on_block(law, Order::Linear), 2);
    assert_eq!((lean.left_out.cells, full.left_out.cells), (120, 0));
    assert_eq!(lean.left_out.solves, 0);
}

#[test]
fn so_do_quadratic_elements() {
    let order = Order::Quadratic;
    let linear = LinearElastic::new(10.0, 0.3).expect("law");
    let large = NeoHookean::new(10.0, 0.3).expect("law");
    let scenes = [
        lean_and_full(|| disc_on_block(linear, order), 1),
        lean_and_full(|| disc_on_block(large, order), 2),
    ];
    for [lean, full] in scenes {
        assert_eq!((lean.left_out.cells, full.left_out.cells), (120, 0));
        assert!(lean.rows < full.rows);
    }
}

#[test]
fn so_do_scenes_in_space() {
    for order in [Order::Linear, Order::Quadratic] {
        let linear = LinearElastic::new(10.0, 0.3).expect("law");
        let large = NeoHookean::new(10.0, 0.3).expect("law");
        let scenes = [
            lean_and_full(|| cube_on_block(linear, order), 1),
            lean_and_full(|| cube_on_block(large, order), 2),
        ];
        for [lean, full] in scenes {
            assert_eq!((lean.left_out.cells, full.left_out.cells), (6 * 8, 0));
            assert!(lean.rows > 3 && full.reaction.norm() > 0.01);
        }
    }
}

/// A hairpin whose arms meet: out of reach is most of it, and itself behind its own material.
#[test]
fn so_does_a_body_that_touches_itself() {
    let [lean, full] = lean_and_full(|| hairpin::scene(2, true).expect("scene"), 8);
    assert!(lean.rows > 5 && lean.rows < full.rows, "{}", lean.rows);
    assert!(lean.left_out.dofs > 0 && full.left_out.dofs == 0);
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
