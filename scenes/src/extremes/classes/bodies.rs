//! Bodies that contact alone holds, that rest by their weight, that slide over rims or cross each other.

use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::{Mesh, Scene};

use crate::Failure;
use crate::extremes::exchange::{Elastic, Law, Must, Reaction};
use crate::extremes::{Case, Check, Truth};
use crate::sliding_disc;

/// A law of Young's modulus 1000 and Poisson's ratio 0.3.
fn elastic(is_linear: bool) -> Elastic {
    Elastic {
        law: if is_linear {
            Law::Linear
        } else {
            Law::NeoHookean
        },
        young: 1e3,
        poisson: 0.3,
    }
}

pub(super) fn all() -> Vec<Case> {
    let mut cases = resting();
    cases.extend(resting_in_space());
    cases.extend(crossing());
    cases.extend(tips());
    cases.extend(slid());
    cases
}

fn block(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Result<Mesh<2>, Failure> {
    let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
    let mut mesh = rectangle(&line(0), &line(1), Diagonals::Alternating)?;
    mesh.name_boundary("all", |_| true);
    Ok(mesh)
}

/// Blocks that rest on a foundation, and on each other, by their weight: the foundation carries it.
fn resting() -> Vec<Case> {
    let mut cases = Vec::new();
    let name = |law: &str, high: usize, weight: f64| {
        format!("{high} {law} blocks at rest, weight {weight:e}")
    };
    for is_linear in [true, false] {
        let law = if is_linear { "linear" } else { "neo-hookean" };
        for (high, weight) in [(1, 1.0), (1, 1e-3), (3, 1.0), (10, 1.0)] {
            let scene = move || -> Result<Scene<2>, Failure> {
                let body = |mesh: Mesh<2>| elastic(is_linear).body(mesh);
                let mut scene = Scene::new();
                let mut foundation = body(block([-1.0, -1.0], [3.0, 1.0], [9, 3])?)?;
                foundation.prescribe("bottom", [Some(0.0); 2])?;
                let mut below = scene.add("foundation", foundation);
                for k in 0..high {
                    let mut upper = body(block([0.0, k as f64], [1.0, 1.0], [4 + k % 2, 4])?)?;
                    upper.body_force([0.0, -weight])?;
                    // nothing but this keeps it from sliding
                    upper.prescribe_nodes(&[0], [Some(0.0), None])?;
                    let upper = scene.add(format!("block {k}"), upper);
                    scene.contact(below.on("top"), upper.on("bottom"))?;
                    below = upper;
                }
                Ok(scene)
            };
            let carried = Must::Be(weight * high as f64);
            let truth = Truth::reactions(move || {
                vec![Reaction::new("weight carried", [0, 1], carried, 1e-5)]
            });
            let case = Case::plane(name(law, high, weight), "at rest", scene, truth)
                .with_laws(vec![elastic(is_linear); high + 1]);
            cases.push(case.twin(name(law, 1, 1.0)));
        }
    }
    cases
}

/// The same in space. Nothing but the shape of the blocks tells where they stay along the foundation: no motion along it costs
/// energy, and no force acts along it.
fn resting_in_space() -> Vec<Case> {
    let mut cases = Vec::new();
    let name = |law: &str, high: usize, held: &str| {
        format!("{high} {law} blocks at rest in space, {held} along the foundation")
    };
    for (is_linear, is_held) in [(true, true), (true, false), (false, true), (false, false)] {
        let law = if is_linear { "linear" } else { "neo-hookean" };
        let held = if is_held { "held" } else { "free" };
        for high in [1, 3, 10] {
            if !is_linear && !is_held && high > 3 {
                // one and three tell already that they do not solve
                continue;
            }
            let scene = move || -> Result<Scene<3>, Failure> {
                let body = |low: [f64; 3], size: [f64; 3], cells: [usize; 3]| {
                    let mut mesh = cuboid(low, size, cells)?;
                    mesh.name_boundary("lower", |x| x[2] == low[2]);
                    mesh.name_boundary("upper", |x| x[2] == low[2] + size[2]);
                    elastic(is_linear).body(mesh)
                };
                let mut scene = Scene::new();
                let mut foundation = body([-1.0, -1.0, -1.0], [3.0, 3.0, 1.0], [5, 5, 2])?;
                foundation.prescribe("lower", [Some(0.0); 3])?;
                let mut below = scene.add("foundation", foundation);
                for k in 0..high {
                    let across = 2 + k % 2;
                    let mut upper = body([0.0, 0.0, k as f64], [1.0; 3], [across, across, 2])?;
                    upper.body_force([0.0, 0.0, -1.0])?;
                    if is_held {
                        // the first node, and against rotation the next corner along x
                        upper.prescribe_nodes(&[0], [Some(0.0), Some(0.0), None])?;
                        upper.prescribe_nodes(&[across], [None, Some(0.0), None])?;
                    }
                    let upper = scene.add(format!("block {k}"), upper);
                    scene.contact(below.on("upper"), upper.on("lower"))?;
                    below = upper;
                }
                Ok(scene)
            };
            let carried = Must::Be(high as f64);
            let truth = Truth::reactions(move || {
                vec![Reaction::new("weight carried", [0, 2], carried, 1e-5)]
            });
            let case = Case::space(name(law, high, held), "at rest", scene, truth)
                .with_laws(vec![elastic(is_linear); high + 1]);
            let case = Case {
                most_factorisations: Some(30),
                ..case
            };
            let is_quick = high == 3 && (is_linear || is_held);
            let case = if is_quick { case.quick() } else { case };
            cases.push(case.twin(name(law, 1, "held")));
        }
    }
    cases
}

/// Bars that cross in space edge on edge and are pushed together: each carries the other, or the run tells that it cannot.
fn crossing() -> Vec<Case> {
    let mut cases = Vec::new();
    for along in [2, 3, 5, 8] {
        for increments in [1, 4, 20] {
            let scene = move || -> Result<Scene<3>, Failure> {
                let bar = |low: [f64; 3], size: [f64; 3], cells: [usize; 3]| {
                    let mut mesh = cuboid(low, size, cells)?;
                    mesh.name_boundary("all", |_| true);
                    let long = if size[0] > size[1] { 0 } else { 1 };
                    mesh.name_boundary("ends", |x| x[long].abs() == 2.0);
                    elastic(false).body(mesh)
                };
                let mut lower = bar([-2.0, -0.1, -0.2], [4.0, 0.2, 0.2], [along, 1, 1])?;
                let mut upper = bar([-0.1, -2.0, 0.05], [0.2, 4.0, 0.2], [1, along, 1])?;
                lower.prescribe("ends", [Some(0.0); 3])?;
                upper.prescribe("ends", [Some(0.0), Some(0.0), Some(-0.6)])?;
                Ok(crate::pair((lower, "all"), (upper, "all"))?)
            };
            // what the bars exert on each other, their supports carry
            let truth = Truth::reactions(move || {
                vec![
                    Reaction::new("upper bar held", [0, 2], Must::Exceed(1e-3), 0.0),
                    Reaction::new("force on the other", [0, 2], Must::Oppose(1), 1e-6),
                ]
            });
            let name = format!("bars of {along} cells cross, {increments} increments");
            let case = Case::space(name, "edge on edge", scene, truth).increments(increments);
            cases.push(case.with_laws(vec![elastic(false); 2]));
        }
    }
    cases
}

/// One triangle is pushed with its tip past the acute rim of another: held, or told.
fn tips() -> Vec<Case> {
    let mut cases = Vec::new();
    for increments in [1, 4, 20] {
        for x in [0.5, 0.8, 0.93] {
            let scene = move || -> Result<Scene<2>, Failure> {
                let wedge = |corners: [[f64; 2]; 3]| {
                    let mut mesh = Mesh::new(corners.to_vec(), vec![0, 1, 2])?;
                    mesh.name_boundary("all", |_| true);
                    elastic(false).body(mesh)
                };
                let mut lower = wedge([[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]])?;
                let mut tip = wedge([[x, 0.05], [x + 0.4, 1.0], [x - 0.4, 1.0]])?;
                lower.prescribe_nodes(&[0, 2], [Some(0.0); 2])?;
                tip.prescribe_nodes(&[1, 2], [Some(0.0), Some(-0.3)])?;
                Ok(crate::pair((lower, "all"), (tip, "all"))?)
            };
            let truth = Truth::reactions(move || {
                vec![
                    Reaction::new("tip held", [0, 1], Must::Exceed(1e-3), 0.0),
                    Reaction::new("force on the other", [0, 1], Must::Oppose(1), 1e-6),
                ]
            });
            let name = format!("tip at {x} of a rim, {increments} increments");
            let case = Case::plane(name, "rims", scene, truth).increments(increments);
            cases.push(case.with_laws(vec![elastic(false); 2]));
        }
    }
    cases
}

/// A soft disc is pressed on a block and moved along it: the floor carries what presses the disc, and beyond its end no
/// force is left.
fn slid() -> Vec<Case> {
    let mut cases = Vec::new();
    for (along, increments) in [(0.0, 10), (0.5, 10), (1.5, 10), (1.5, 40), (4.2, 40)] {
        let scene = move || Ok(sliding_disc::scene(6, along)?);
        let truth = match along > 4.0 {
            // it slides off the end of the floor: no force is left
            true => Truth::Values(Box::new(|_, history| {
                let force = history
                    .last()
                    .map_or(f64::NAN, |step: &contact_fem::StepRecord<2>| {
                        step.contact_force(1).norm()
                    });
                vec![Check {
                    what: "force beyond the end",
                    found: force,
                    expected: 0.0,
                    tolerance: 1e-9,
                }]
            })),
            false => Truth::Values(Box::new(|_, history| {
                let last = history.last();
                let force = last.map_or(f64::NAN, |step| step.contact_forces[1][1]);
                let below = last.map_or(f64::NAN, |step| step.reactions[0][1]);
                vec![
                    Check::relative("force below", below, force, 1e-6),
                    Check::that("disc pressed", force > 10.0),
                ]
            })),
        };
        let name = |along: f64, increments: usize| {
            format!("disc along a block by {along}, {increments} increments")
        };
        let case = Case::plane(name(along, increments), "sliding", scene, truth);
        cases.push(case.increments(increments).twin(name(0.0, 10)));
    }
    cases
}
