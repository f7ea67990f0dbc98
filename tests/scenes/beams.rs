//! Section 6.2 of the paper against beam theory: three cantilevers share a load.

use crate::common::{relative, run};
use contact_fem::element::Order;
use contact_fem::output::Snapshot;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use ipopt_contact::prelude::Problem;
use ipopt_contact_scenes::beams::{
    Beams, LENGTH, LOAD, Law, SIDE, YOUNG, mid_span_pressure, slip, tip,
};

/// Each beam carries a third of q = LOAD · SIDE: bending and shear (shear coefficient 5/6, ν = 0).
fn theory() -> (f64, f64) {
    let q = LOAD * SIDE / 3.0;
    let bending = q * LENGTH.powi(4) / (8.0 * YOUNG * SIDE.powi(4) / 12.0);
    let shear = q * LENGTH.powi(2) / (2.0 * (5.0 / 6.0) * 0.5 * YOUNG * SIDE.powi(2));
    // the beams slide by the end's slope times the distance of their axes
    let slope = q * LENGTH.powi(3) / (6.0 * YOUNG * SIDE.powi(4) / 12.0);
    (bending + shear, slope * SIDE)
}

fn solved(beams: Beams, increments: usize) -> (Problem<3>, History<3>, Vec<Vector<3>>) {
    let scene = beams.scene().expect("a scene");
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, increments, 1e-6);
    assert!(history.is_complete(), "{}", history.run.ending);
    let u = problem.displacements(&history.run.state.u);
    (problem, history, u)
}

#[test]
fn quadratic_elements_agree_with_beam_theory() {
    let (deflection, slide) = theory();
    assert!((deflection - 25.9).abs() < 0.05 && (slide - 4.27).abs() < 0.01);
    let beams = Beams::new(3, Order::Quadratic, Law::SmallStrain);
    let (problem, history, u) = solved(beams, 1);
    let tips = [0, 1, 2].map(|k| -tip(&problem, &u, k)[2]);
    for t in tips {
        assert!(relative(t, deflection) < 0.01, "{tips:?}");
        assert!(relative(t, tips[0]) < 0.01, "{tips:?}");
    }
    for below in [0, 1] {
        assert!(relative(slip(&problem, &u, below), slide) < 0.02);
    }

    // all of the load arrives at the clamps, and what each beam passes on is what the next one gets
    let step = history.steps.last().expect("converged");
    let load = LOAD * LENGTH * SIDE;
    let up: f64 = step.reactions.iter().map(|r| r[2]).sum();
    assert!(relative(up, load) < 1e-10, "{up}");
    let forces: Vector<3> = step.contact_forces.iter().sum();
    assert!(forces.norm() < 1e-10 * load);
    assert_eq!(
        step.attempt.iterations.len(),
        1,
        "one solve, no fixed point"
    );

    let solution = history.run.solution.as_ref().expect("converged");
    let pressures = Snapshot::new(&problem, solution)
        .expect("recovered")
        .pressures;
    let third = LOAD / 3.0;
    for (below, exact) in [(0, third), (1, 2.0 * third)] {
        let p = mid_span_pressure(&problem, &pressures, below);
        assert!(relative(p, exact) < 0.03, "above beam {below}: {p}");
    }
}

/// Linear tetrahedra lock in bending: far too stiff on meshes on which quadratic ones have
/// converged, and softer with every refinement.
#[test]
fn linear_elements_lock() {
    let (deflection, _) = theory();
    let tip_of = |across, order| {
        let (problem, _, u) = solved(Beams::new(across, order, Law::SmallStrain), 1);
        -tip(&problem, &u, 1)[2]
    };
    let linear = [1, 2, 4].map(|across| tip_of(across, Order::Linear));
    let quadratic = tip_of(2, Order::Quadratic);
    println!(
        "P1 with 1, 2, 4 cells across: {linear:?}; P2 with 2: {quadratic}; theory {deflection}"
    );
    assert!(linear[0] < 0.2 * deflection, "{linear:?}");
    assert!(linear[0] < linear[1] && linear[1] < linear[2], "{linear:?}");
    assert!(linear[2] < 0.8 * deflection, "{linear:?}");
    assert!(relative(quadratic, deflection) < 0.01, "{quadratic}");
}

/// Large strains: the beams go down a little less than in theory, their ends turn and slide.
#[test]
fn neo_hookean_beams_slide() {
    let beams = Beams::new(2, Order::Quadratic, Law::NeoHookean);
    let (problem, history, u) = solved(beams, 5);
    let (deflection, slide) = theory();
    for k in [0, 1, 2] {
        let [x, _, z] = tip(&problem, &u, k);
        assert!(-z > 0.93 * deflection && -z < deflection, "tip {k}: {z}");
        // the end of an inextensible beam comes back by about 3/5 z²/L
        assert!(relative(-x, 0.6 * z * z / LENGTH) < 0.2, "tip {k}: {x}");
    }
    for below in [0, 1] {
        let s = slip(&problem, &u, below);
        assert!(relative(s, slide) < 0.06, "{s}");
    }
    let step = history.steps.last().expect("converged");
    let up: f64 = step.reactions.iter().map(|r| r[2]).sum();
    assert!(relative(up, LOAD * LENGTH * SIDE) < 1e-6, "{up}");

    // converged with the mesh: one with cells 1.5 times as fine changes less than 1 %
    let (finer, _, v) = solved(Beams::new(3, Order::Quadratic, Law::NeoHookean), 2);
    for k in [0, 1, 2] {
        let (coarse, fine) = (tip(&problem, &u, k)[2], tip(&finer, &v, k)[2]);
        assert!(relative(coarse, fine) < 0.01, "tip {k}: {coarse} {fine}");
    }
    for below in [0, 1] {
        let (coarse, fine) = (slip(&problem, &u, below), slip(&finer, &v, below));
        assert!(
            relative(coarse, fine) < 0.01,
            "slip {below}: {coarse} {fine}"
        );
    }
}
