//! Loads, stiffnesses and steps far from ordinary.

use crate::common::{disc_in_disc, relative, run};
use contact_core::Ending;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Problem;
use contact_fem::{Body, LinearElastic, NeoHookean};
use ipopt_contact_scenes::disc_in_disc::{ENDS, Roles};
use ipopt_contact_scenes::pair;

fn square(y: f64, modulus: f64) -> Body<2> {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 4),
        &linspace(y, y + 1.0, 4),
        Diagonals::Rising,
    );
    Body::new(
        mesh.expect("mesh"),
        LinearElastic::new(modulus, 0.0).expect("law"),
    )
}

/// Two squares on top of each other, the lower one clamped below.
fn stack(mut top: Body<2>, modulus: f64) -> Problem<2> {
    let mut bottom = square(0.0, modulus);
    bottom.prescribe("bottom", [Some(0.0); 2]).expect("support");
    top.prescribe("left", [Some(0.0), None]).expect("support");
    let scene = pair((bottom, "top"), (top, "bottom")).expect("surfaces");
    scene.problem().expect("valid scene")
}

/// Linear problems scale with the load, down to strains of 1e-8: two bars of E = 1 and
/// height 1 under a pressure p shorten by 2 p.
#[test]
fn small_loads_give_small_displacements() {
    for pressure in [1e-2, 1e-4, 1e-6, 1e-8] {
        let mut top = square(1.0, 1.0);
        top.traction("top", [0.0, -pressure]).expect("load");
        let mut problem = stack(top, 1.0);
        let history = run(&mut problem, 1, 1e-6);
        assert_eq!(history.run.ending, Ending::Complete, "pressure {pressure}");
        let displacements = problem.displacements(&history.run.state.u);
        let lowest = displacements.iter().map(|u| u[1]).fold(0.0, f64::min);
        assert!(
            relative(lowest, -2.0 * pressure) < 1e-4,
            "{lowest} at pressure {pressure}"
        );
    }
}

/// A soft square pressed by 0.1 on a stiffer one: two springs in series.
#[test]
fn stiff_against_soft() {
    for ratio in [1e-3, 1.0, 1e3, 1e6] {
        let mut top = square(1.0, 1.0);
        top.prescribe("top", [Some(0.0), Some(-0.1)])
            .expect("support");
        let mut problem = stack(top, ratio);
        let history = run(&mut problem, 1, 1e-6);
        assert_eq!(history.run.ending, Ending::Complete, "ratio {ratio}");
        let force = history.steps[0].reactions[0][1];
        let expected = 0.1 / (1.0 + 1.0 / ratio);
        assert!(
            relative(force, expected) < 1e-3,
            "{force} for {expected} at ratio {ratio}"
        );
    }
}

/// The whole push in one increment would leave the disc beyond the wall. Whatever is accepted on
/// the way to full load, nothing is deeper in the wall than polygons of a circle are.
#[test]
fn nothing_tunnels() {
    let mut problem = disc_in_disc(64, Roles::default());
    let history = run(&mut problem, 1, 1e-6);
    for step in &history.steps {
        assert!(
            step.penetration < 0.01,
            "{} at {}",
            step.penetration,
            step.factor
        );
    }
    if history.run.ending == Ending::Complete {
        let energy = history.steps.last().expect("steps").energy;
        assert!(relative(energy, ENDS[0].1.energy) < 1e-4, "{energy}");
    } else {
        assert!(history.run.cuts() > 0 && history.run.factor < 1.0);
    }
}

/// A linear scene converges under any load: contact lives in the reference configuration, whatever
/// the displaced bodies look like. Twice the load, twice the displacements.
#[test]
fn small_strain_scenes_are_linear_in_the_load() {
    let solved = |load: f64| {
        let beam = |y: f64| {
            let mesh = rectangle(
                &linspace(0.0, 8.0, 16),
                &linspace(y, y + 1.0, 2),
                Diagonals::Alternating,
            );
            let law = LinearElastic::new(2e5, 0.0).expect("law");
            let mut beam = Body::new(mesh.expect("mesh").quadratic(), law);
            beam.prescribe("left", [Some(0.0); 2]).expect("support");
            beam
        };
        let (lower, mut upper) = (beam(0.0), beam(1.0));
        upper.traction("top", [0.0, -load]).expect("load");
        let scene = pair((lower, "top"), (upper, "bottom")).expect("surfaces");
        let mut problem = scene.problem().expect("valid scene");
        let history = run(&mut problem, 1, 1e-6);
        assert_eq!(history.run.ending, Ending::Complete, "load {load}");
        let step = history.steps.last().expect("converged");
        assert!(step.penetration < 1e-2 * load / 100.0);
        step.energy
    };
    let small = solved(100.0);
    for load in [1e3, 1e4] {
        let energy = solved(load);
        assert!(relative(energy, small * (load / 100.0).powi(2)) < 1e-5);
    }
}

/// Squares of one or eight triangles that are pushed together by more than the default reach, but
/// less than a facet, in a single increment: cut, and as if pushed in ten.
#[test]
fn coarse_facets_do_not_hide_a_tunnel() {
    for cells in [1, 2] {
        let energy = |increments: usize| {
            let body = |y: f64| {
                let mesh = rectangle(
                    &linspace(0.0, 1.0, cells),
                    &linspace(y, y + 1.0, cells),
                    Diagonals::Rising,
                );
                Body::new(mesh.expect("mesh"), NeoHookean::new(1e3, 0.3).expect("law"))
            };
            let (mut lower, mut upper) = (body(0.0), body(1.3));
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            let down = [Some(0.0), Some(-0.7)];
            upper.prescribe("top", down).expect("support");
            let scene = pair((lower, "top"), (upper, "bottom")).expect("surfaces");
            let mut problem = scene.problem().expect("valid scene");
            let history = run(&mut problem, increments, 1e-9);
            assert_eq!(history.run.ending, Ending::Complete);
            history.steps.last().expect("converged").energy
        };
        let (one, ten) = (energy(1), energy(10));
        assert!(ten > 10.0 && relative(one, ten) < 1e-4, "{one} {ten}");
    }
}

/// A block that would jump over a thin plate in one increment, all of whose sides may touch: where it
/// arrives no node is inside anything. It is caught, whichever body comes first, and what comes of it is
/// what small increments find.
#[test]
fn thin_bodies_are_not_jumped_over() {
    let energy = |increments: usize, block_first: bool| {
        let grid = |x: [f64; 2], y: [f64; 2], cells: [usize; 2]| {
            let line = |[low, high]: [f64; 2], n| linspace(low, high, n);
            let mut mesh =
                rectangle(&line(x, cells[0]), &line(y, cells[1]), Diagonals::Rising).expect("mesh");
            mesh.name_boundary("all", |_| true);
            mesh
        };
        let law = |young: f64| NeoHookean::new(young, 0.3).expect("law");
        let mut plate = Body::new(grid([0.0, 1.0], [0.0, 0.1], [20, 2]), law(1e3));
        plate.prescribe("left", [Some(0.0); 2]).expect("support");
        plate.prescribe("right", [Some(0.0); 2]).expect("support");
        let mut block = Body::new(grid([0.32, 0.68], [0.25, 0.35], [7, 2]), law(1e3));
        block
            .prescribe("top", [Some(0.0), Some(-0.4)])
            .expect("support");
        let (first, second) = match block_first {
            true => (block, plate),
            false => (plate, block),
        };
        let scene = pair((first, "all"), (second, "all")).expect("surfaces");
        let mut problem = scene.problem().expect("valid scene");
        let history = run(&mut problem, increments, 1e-8);
        assert_eq!(history.run.ending, Ending::Complete);
        let caught = history
            .run
            .attempts
            .iter()
            .any(|attempt| matches!(attempt.outcome, contact_core::Outcome::Tunnelled { .. }));
        assert_eq!(caught, increments == 1);
        history.steps.last().expect("converged").energy
    };
    let small_steps = energy(16, false);
    assert!(small_steps > 1.0);
    for block_first in [false, true] {
        let one = energy(1, block_first);
        assert!(relative(one, small_steps) < 1e-3, "{one} for {small_steps}");
    }
}
