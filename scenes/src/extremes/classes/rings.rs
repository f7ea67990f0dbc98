//! Discs in rings, pins in holes, and the paper's disc-in-disc in many steps.

use std::f64::consts::TAU;

use contact_fem::Scene;
use contact_fem::mesh::generators::{Diagonals, annulus, disc, linspace};

use crate::Failure;
use crate::disc_in_disc::{self, Fineness, Roles};
use crate::extremes::exchange::{Elastic, Law, Must, Reaction};
use crate::extremes::{Case, Check, Truth};

pub(super) fn all() -> Vec<Case> {
    let mut cases = increments();
    cases.extend(elastic_discs());
    cases.extend(pins());
    cases
}

/// The disc-in-disc on a coarse mesh in 5 to 100 increments: forces balance, and the work of the support, by the
/// trapezoidal rule over n increments, is the stored energy within a share of 1/n.
fn increments() -> Vec<Case> {
    let name = |count: usize| format!("disc-in-disc, {count} increments");
    let case = |count: usize| {
        let scene = || Ok(disc_in_disc::scene(Fineness::scaled(24), Roles::default())?);
        let truth = Truth::Values(Box::new(move |_, history| {
            let last = history.last();
            let [ring, pushed] = [0, 1].map(|k| last.map_or(f64::NAN, |step| step.reactions[k][1]));
            let (mut work, mut before) = (0.0, (0.0, 0.0));
            for step in &history.steps {
                let now = (step.factor, -step.reactions[1][1]);
                work += 0.5 * (before.1 + now.1) * (now.0 - before.0) * disc_in_disc::PUSH;
                before = now;
            }
            let energy = last.map_or(f64::NAN, |step| step.energy);
            vec![
                Check::relative("reaction of the ring", ring, -pushed, 1e-6),
                Check::relative("work of the support", work, energy, 1.0 / count as f64),
            ]
        }));
        Case::plane(name(count), "increments", scene, truth)
    };
    let counts = [100, 5, 10, 20, 50];
    counts
        .map(|count| case(count).increments(count).twin(name(100)))
        .into()
}

/// An elastic disc whose core is pushed in a ring: stiffness ratios to 1e±6.
fn elastic_discs() -> Vec<Case> {
    let mut cases = Vec::new();
    let name = |ratio: f64, segments: usize, increments: usize| {
        format!(
            "elastic disc in a ring, E ratio {ratio:e}, {segments} segments, {increments} increments"
        )
    };
    let ratios = [1.0, 1e-3, 1e3, 1e-6, 1e6];
    let all = ratios
        .map(|ratio| [40, 80, 160].map(|segments| [5, 10, 20, 100].map(|n| (ratio, segments, n))));
    for (ratio, segments, increments) in all.into_iter().flatten().flatten() {
        let elastic = |young: f64| Elastic {
            law: Law::NeoHookean,
            young,
            poisson: 0.3,
        };
        let laws = [1.0, ratio].map(|ratio| elastic(1e3 * ratio));
        let scene = move || -> Result<Scene<2>, Failure> {
            let rings = linspace(1.0, 1.5, segments / 8);
            let mut ring = laws[0].body(annulus(&rings, segments, Diagonals::Alternating)?)?;
            ring.prescribe("outer", [Some(0.0); 2])?;
            let mesh = disc(0.9, segments * 7 / 8, segments / 6, 0.05)?;
            let nodes = mesh.nodes().iter().enumerate();
            let core: Vec<usize> = nodes
                .filter(|(_, x)| x.norm() < 0.25)
                .map(|(a, _)| a)
                .collect();
            let mut inner = laws[1].body(mesh)?;
            inner.prescribe_nodes(&core, [Some(0.0), Some(-0.4)])?;
            Ok(crate::pair((ring, "inner"), (inner, "boundary"))?)
        };
        let balance = Reaction::new("reaction of the ring", [0, 1], Must::Oppose(1), 1e-5);
        // the softer one yields, and it touches
        let touches = Must::Exceed(10.0 * ratio.min(1.0));
        let carries = Reaction::new("force on the ring", [0, 1], touches, 0.0);
        let truth = Truth::reactions(move || vec![carries, balance]);
        let case = Case::plane(
            name(ratio, segments, increments),
            "elastic disc",
            scene,
            truth,
        );
        let case = case.increments(increments).twin(name(1.0, 40, 20));
        let case = case.with_laws(laws.into());
        cases.push(Case {
            fine: segments > 40,
            ..case
        });
    }
    cases
}

/// A pin in a hole, loaded by its weight and held against rotation by one node: the ring carries the load.
fn pins() -> Vec<Case> {
    let mut cases = Vec::new();
    for is_quadratic in [false, true] {
        let order = 1 + usize::from(is_quadratic);
        let name = |clearance: f64| format!("pin in a hole P{order}, clearance {clearance:e}");
        let elastic = Elastic {
            law: Law::Linear,
            young: 1e4,
            poisson: 0.3,
        };
        for clearance in [1e-1, 1e-2, 1e-3, 1e-4, 0.0] {
            let scene = move || -> Result<Scene<2>, Failure> {
                // nodes of both at the same angles, so that clearance is clearance everywhere
                let outer = annulus(&linspace(1.0, 2.0, 5), 40, Diagonals::Alternating)?;
                let pin = disc(1.0 - clearance, 40, 6, 0.0)?;
                let of =
                    |mesh: contact_fem::Mesh<2>| if is_quadratic { mesh.quadratic() } else { mesh };
                let mut plate = elastic.body(of(outer))?;
                plate.prescribe("outer", [Some(0.0); 2])?;
                let mut pin = elastic.body(of(pin))?;
                let nodes = pin.mesh().nodes().iter().enumerate();
                let axis: Vec<usize> = nodes
                    .filter(|(_, x)| x[0].abs() < 1e-12)
                    .map(|(a, _)| a)
                    .collect();
                pin.prescribe_nodes(&axis, [Some(0.0), None])?;
                pin.body_force([0.0, -1.0])?;
                Ok(crate::pair((plate, "inner"), (pin, "boundary"))?)
            };
            let area = 0.5 * 40.0 * (TAU / 40.0).sin() * (1.0 - clearance).powi(2);
            let carried = Reaction::new("weight carried", [0, 1], Must::Be(area), 1e-5);
            let truth = Truth::reactions(move || vec![carried]);
            let case = Case::plane(name(clearance), "pin in hole", scene, truth);
            cases.push(case.with_laws(vec![elastic; 2]).twin(name(1e-2)));
        }
    }
    cases
}
