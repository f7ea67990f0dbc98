//! Slender bodies that bend far: rings crushed between plates, columns that buckle beside a wall, an arch that snaps through,
//! a hairpin that folds on itself.

use std::f64::consts::PI;

use contact_fem::mesh::generators::{Diagonals, annulus, disc, extrude, linspace, rectangle};
use contact_fem::model::Integration;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Body, Mesh, NeoHookean, Scene};

use crate::extremes::{Case, Check, Truth};
use crate::{Failure, hairpin};

pub(super) fn all() -> Vec<Case> {
    let mut cases = rings();
    cases.extend(columns());
    cases.extend(arches());
    cases.extend(hairpins());
    cases
}

const YOUNG: f64 = 1e3;
const NU: f64 = 0.3;

fn law() -> Result<NeoHookean, Failure> {
    Ok(NeoHookean::new(YOUNG, NU)?)
}

/// The bending stiffness of a strip of this thickness (UF·UL), without strain across it.
fn bending(thickness: f64) -> f64 {
    YOUNG / (1.0 - NU * NU) * thickness.powi(3) / 12.0
}

/// A block whose displacements are all prescribed.
fn rigid(low: [f64; 2], high: [f64; 2], way: [f64; 2]) -> Result<Body<2>, Failure> {
    let mesh = rectangle(
        &linspace(low[0], high[0], 8),
        &linspace(low[1], high[1], 1),
        Diagonals::Alternating,
    )?;
    let mut block = Body::new(mesh, law()?);
    block.prescribe_all(way.map(Some))?;
    Ok(block)
}

/// The work of the supports of a body, all of which move by `way` or rest, by the trapezoidal rule over the steps.
fn work<const D: usize>(history: &History<D>, body: usize, way: Vector<D>) -> f64 {
    let (mut work, mut factor, mut force) = (0.0, 0.0, 0.0);
    for step in &history.steps {
        let now = step.reactions[body].dot(&way);
        work += 0.5 * (force + now) * (step.factor - factor);
        (factor, force) = (step.factor, now);
    }
    work
}

/// How much of the energy the trapezoidal rule, and forces along averaged normals, may miss in so many increments.
fn missed(increments: usize) -> f64 {
    0.02 + 2.0 / (increments as f64).powi(2)
}

/// A ring or a piece of a tube between two rigid plates, one of which comes down: a little, as in the theory of thin rings, to
/// half its height, or until the inside touches itself.
fn rings() -> Vec<Case> {
    const THICKNESS: f64 = 0.1;
    let mesh = |segments: usize, across: usize, is_quadratic: bool| -> Result<Mesh<2>, Failure> {
        let radii = linspace(1.0 - THICKNESS, 1.0, across);
        let mesh = annulus(&radii, segments, Diagonals::Alternating)?.translated([0.0, 1.0])?;
        Ok(if is_quadratic { mesh.quadratic() } else { mesh })
    };
    let scene = |mesh: Mesh<2>, press: f64, is_exact: bool| -> Result<Scene<2>, Failure> {
        let middle = mesh.nodes().iter().enumerate();
        let middle: Vec<usize> = middle
            .filter(|(_, x)| x[0].abs() < 1e-12)
            .map(|(a, _)| a)
            .collect();
        let mut ring = Body::new(mesh, law()?);
        ring.prescribe_nodes(&middle, [Some(0.0), None])?;
        let mut scene = Scene::new();
        let ring = scene.add("ring", ring);
        let floor = scene.add("floor", rigid([-2.0, -0.5], [2.0, 0.0], [0.0; 2])?);
        let plate = scene.add("plate", rigid([-2.0, 2.0], [2.0, 2.5], [0.0, -press])?);
        scene.contact(ring.on("outer"), floor.on("top"))?;
        scene.contact(ring.on("outer"), plate.on("bottom"))?;
        scene.self_contact(ring.on("inner"))?;
        scene.integration = is_exact.then_some(Integration::Exact);
        Ok(scene)
    };
    let mut cases = Vec::new();
    let (press, radius) = (0.02, 1.0 - 0.5 * THICKNESS);
    let truth = Truth::Values(Box::new(move |_, history| {
        // the diameter of a thin ring shortens by (π/4 − 2/π) F R³ / EI; shear and tension along it add a percent
        let bent = (PI / 4.0 - 2.0 / PI) * radius.powi(3) / bending(THICKNESS);
        let sheared = PI / 4.0 * radius * (1.2 * 2.0 / (1.0 - NU) - 1.0);
        let stretched = sheared * (1.0 - NU * NU) / (YOUNG * THICKNESS);
        let force = press / (bent + stretched);
        let found = history
            .last()
            .map_or(f64::NAN, |step| -step.reactions[2][1]);
        vec![Check::relative("force", found, force, 0.04)]
    }));
    let benign = "ring P2 crushed by 0.02, 2 increments";
    let little = Case::plane(
        benign.into(),
        "crushed ring",
        move || scene(mesh(256, 2, true)?, press, false),
        truth,
    );
    cases.push(little.increments(2));
    for (is_quadratic, press, increments, is_exact) in [
        (false, 1.0, 20, false),
        (true, 1.0, 20, false),
        (true, 1.0, 20, true),
        (true, 1.0, 5, false),
        (false, 1.75, 40, false),
        (true, 1.75, 40, false),
    ] {
        let truth = Truth::Values(Box::new(move |_, history| {
            let last = history.last();
            let of = |body: usize| last.map_or(f64::NAN, |step| step.reactions[body][1]);
            let energy = last.map_or(f64::NAN, |step| step.energy);
            let work = work(history, 2, Vector::<2>::new(0.0, -press));
            vec![
                Check::relative("force below", of(1), -of(2), 1e-6),
                Check::relative("work of the plate", work, energy, missed(increments)),
            ]
        }));
        let order = 1 + usize::from(is_quadratic);
        let rule = if is_exact { ", exact rule" } else { "" };
        let name = format!("ring P{order} crushed by {press}, {increments} increments{rule}");
        let across = if is_quadratic { 1 } else { 3 };
        let make = move || scene(mesh(64, across, is_quadratic)?, press, is_exact);
        let case = Case::plane(name, "crushed ring", make, truth).increments(increments);
        cases.push(case.twin(benign));
    }
    cases.push(tube(1.0, 10).twin(benign));
    cases
}

/// A piece of a tube in space, without displacement along its axis.
fn tube(press: f64, increments: usize) -> Case {
    let scene = move || -> Result<Scene<3>, Failure> {
        let layers = [0.0, 0.1];
        let radii = linspace(0.8, 1.0, 1);
        let ring = annulus(&radii, 48, Diagonals::Alternating)?.translated([0.0, 1.0])?;
        let plate = |y: [f64; 2]| {
            let mesh = rectangle(&linspace(-2.0, 2.0, 4), &y, Diagonals::Alternating)?;
            extrude(&mesh, &layers, ["behind", "before"])
        };
        let mesh = extrude(&ring, &layers, ["behind", "before"])?.quadratic();
        let middle = mesh.nodes().iter().enumerate();
        let middle: Vec<usize> = middle
            .filter(|(_, x)| x[0].abs() < 1e-12)
            .map(|(a, _)| a)
            .collect();
        let all: Vec<usize> = (0..mesh.len()).collect();
        let mut tube = Body::new(mesh, law()?);
        tube.prescribe_nodes(&middle, [Some(0.0), None, None])?;
        tube.prescribe_nodes(&all, [None, None, Some(0.0)])?;
        let mut floor = Body::new(plate([-0.5, 0.0])?, law()?);
        floor.prescribe_all([Some(0.0); 3])?;
        let mut upper = Body::new(plate([2.0, 2.5])?, law()?);
        upper.prescribe_all([Some(0.0), Some(-press), Some(0.0)])?;
        let mut scene = Scene::new();
        let tube = scene.add("tube", tube);
        let floor = scene.add("floor", floor);
        let upper = scene.add("plate", upper);
        scene.contact(tube.on("outer"), floor.on("top"))?;
        scene.contact(tube.on("outer"), upper.on("bottom"))?;
        Ok(scene)
    };
    let truth = Truth::Values(Box::new(move |_, history| {
        let last = history.last();
        let of = |body: usize| last.map_or(f64::NAN, |step| step.reactions[body][1]);
        let energy = last.map_or(f64::NAN, |step| step.energy);
        let work = work(history, 2, Vector::<3>::new(0.0, -press, 0.0));
        vec![
            Check::relative("force below", of(1), -of(2), 1e-6),
            Check::relative("work of the plate", work, energy, missed(increments)),
        ]
    }));
    let name = format!("tube P2 crushed by {press}, {increments} increments");
    Case::space(name, "crushed ring", scene, truth).increments(increments)
}

/// A clamped column, bent a little to one side, buckles under Euler's load and comes to lie on a wall. Shortened by more than
/// 0.4, it snaps off the wall to the other side, where it is a column under Euler's load again.
fn columns() -> Vec<Case> {
    const LENGTH: f64 = 10.0;
    const THICKNESS: f64 = 0.5;
    const GAP: f64 = 0.5;
    const WALL: f64 = 0.5 * THICKNESS + GAP;
    /// An interior point method leaves so much of a force where there is none, as a share of Euler's load.
    const FREE: f64 = 1e-4;
    let mut cases = Vec::new();
    let name = |side: f64, press: f64, increments: usize| {
        let side = if side > 0.0 { "right" } else { "left" };
        format!("column to the {side}, shortened by {press}, {increments} increments")
    };
    for (side, press, increments) in [
        (1.0, 0.15, 15),
        (1.0, 0.3, 6),
        (-1.0, 0.3, 30),
        (1.0, 0.6, 12),
        (1.0, 0.6, 60),
        (1.0, 1.0, 40),
    ] {
        let scene = move || -> Result<Scene<2>, Failure> {
            let x = linspace(-0.5 * THICKNESS, 0.5 * THICKNESS, 2);
            let mesh = rectangle(&x, &linspace(0.0, LENGTH, 40), Diagonals::Alternating)?;
            let bent = move |x: &Vector<2>| {
                let along = (2.0 * PI * x[1] / LENGTH).cos();
                Vector::<2>::new(x[0] + 0.005 * side * (1.0 - along), x[1])
            };
            let mut column = Body::new(mesh.quadratic().mapped(bent)?, law()?);
            column.prescribe("bottom", [Some(0.0); 2])?;
            column.prescribe("top", [Some(0.0), Some(-press)])?;
            let ends = [side * WALL, side * (WALL + 0.5)];
            let low = ends[0].min(ends[1]);
            let wall = rigid([low, 0.0], [low + 0.5, LENGTH], [0.0; 2])?;
            let (of_column, of_wall) = match side > 0.0 {
                true => ("right", "left"),
                false => ("left", "right"),
            };
            let mut scene = Scene::new();
            let column = scene.add("column", column);
            let wall = scene.add("wall", wall);
            scene.contact(column.on(of_column), wall.on(of_wall))?;
            Ok(scene)
        };
        let truth = Truth::Values(Box::new(move |_, history| {
            let euler = 4.0 * PI * PI * bending(THICKNESS) / (LENGTH * LENGTH);
            let last = history.last();
            let of = |body: usize| last.map_or(f64::NAN, |step| step.contact_forces[body][0]);
            let held = last.map_or(f64::NAN, |step| step.reactions[0][0]);
            let [before, after] = loads(history, press, FREE * euler);
            let mut checks = vec![Check {
                // what pushes the column off the wall pulls at its ends
                what: "force on the ends",
                found: held,
                expected: of(1),
                tolerance: (1e-6 * of(1).abs()).max(1e-6 * euler),
            }];
            if press < 0.011 * increments as f64 {
                checks.push(Check::relative(
                    "load before it touches",
                    before,
                    euler,
                    0.08,
                ));
            }
            if press > 0.5 {
                checks.push(Check::relative(
                    "load after it has snapped",
                    after,
                    euler,
                    0.1,
                ));
                let is_free = of(1).abs() < FREE * euler;
                checks.push(Check::that("has left the wall", is_free));
            } else if press > 0.2 {
                // long steps may find the equilibrium on the other side, too
                let is_eulers = of(1).abs() < FREE * euler && (after / euler - 1.0).abs() < 0.1;
                checks.push(Check::that(
                    "lies on the wall, or is Euler's column on the other side",
                    side * of(1) > 0.1 * euler || is_eulers,
                ));
            }
            checks
        }));
        let case = Case::plane(name(side, press, increments), "buckling", scene, truth);
        cases.push(case.increments(increments).twin(name(1.0, 0.15, 15)));
    }
    cases
}

/// The largest load on a column before it touches the wall, and that at its end, from how its energy grows with its
/// shortening. A contact force up to `none` (UF) is none.
fn loads(history: &History<2>, press: f64, none: f64) -> [f64; 2] {
    let [mut free, mut last] = [0.0f64; 2];
    let (mut factor, mut energy, mut is_free) = (0.0, 0.0, true);
    for step in &history.steps {
        last = (step.energy - energy) / (press * (step.factor - factor));
        is_free &= step.contact_forces[1][0].abs() < none;
        if is_free {
            free = free.max(last);
        }
        (factor, energy) = (step.factor, step.energy);
    }
    [free, last]
}

/// A shallow clamped arch is pushed by a rigid disc until it has snapped through, and further. What it loses in a snap is
/// gone: the work is at least the energy.
fn arches() -> Vec<Case> {
    const RISE: f64 = 0.6;
    const THICKNESS: f64 = 0.2;
    const PUSH: f64 = 1.5;
    let mut cases = Vec::new();
    for increments in [30, 10, 60] {
        let scene = || -> Result<Scene<2>, Failure> {
            let y = linspace(-0.5 * THICKNESS, 0.5 * THICKNESS, 1);
            let flat = rectangle(&linspace(-5.0, 5.0, 60), &y, Diagonals::Alternating)?;
            let bent = |x: &Vector<2>| {
                let along = (PI * x[0] / 5.0).cos();
                Vector::<2>::new(x[0], x[1] + 0.5 * RISE * (1.0 + along))
            };
            let mut arch = Body::new(flat.quadratic().mapped(bent)?, law()?);
            arch.prescribe("left", [Some(0.0); 2])?;
            arch.prescribe("right", [Some(0.0); 2])?;
            let tool = disc(0.5, 24, 3, 0.0)?;
            let top = RISE + 0.5 * THICKNESS + 0.5;
            let mut tool = Body::new(tool.translated([0.0, top])?, law()?);
            tool.prescribe_all([Some(0.0), Some(-PUSH)])?;
            Ok(crate::pair((arch, "top"), (tool, "boundary"))?)
        };
        let truth = Truth::Values(Box::new(move |problem, history| {
            let last = history.last();
            let of = |body: usize| last.map_or(f64::NAN, |step| step.reactions[body][1]);
            let energy = last.map_or(f64::NAN, |step| step.energy);
            let work = work(history, 1, Vector::<2>::new(0.0, -PUSH));
            let now = problem.positions(&history.run.state.u);
            let highest = now[problem.nodes(0)].iter().map(|x| x[1]);
            vec![
                Check::relative("force on the ends", of(0), -of(1), 1e-6),
                Check::that("pushed", -of(1) > 0.0),
                Check::that(
                    "work is at least energy",
                    work > (1.0 - missed(increments)) * energy,
                ),
                Check::that(
                    "it has snapped",
                    highest.fold(f64::NEG_INFINITY, f64::max) < RISE,
                ),
            ]
        }));
        let name = |increments: usize| format!("arch pushed through, {increments} increments");
        let case = Case::plane(name(increments), "snap-through", scene, truth);
        cases.push(case.increments(increments).twin(name(30)));
    }
    cases
}

/// The arms of a hairpin are pressed together until they touch: by symmetry, where they do, they lie on the line between them.
fn hairpins() -> Vec<Case> {
    let mut cases = Vec::new();
    for (fine, increments, is_exact) in
        [(2, 10, false), (2, 2, false), (3, 10, false), (2, 10, true)]
    {
        let scene = move || -> Result<Scene<2>, Failure> {
            let mut scene = hairpin::scene(fine, true)?;
            scene.integration = is_exact.then_some(Integration::Exact);
            Ok(scene)
        };
        let truth = Truth::Values(Box::new(move |problem, history| {
            let now = problem.positions(&history.run.state.u);
            let inside = problem.reference().iter().zip(&now);
            let inside = inside.filter(|(X, _)| hairpin::is_inside_of_upper_arm(X));
            let lowest = inside.map(|(_, x)| x[1]).fold(f64::INFINITY, f64::min);
            // rows keep the mean gap of a facet open
            let facet = 0.1 / fine as f64;
            vec![Check {
                what: "height of the lowest node",
                found: lowest,
                expected: 0.0,
                tolerance: 0.05 * facet,
            }]
        }));
        let rule = if is_exact { ", exact rule" } else { "" };
        let name = |fine: usize, increments: usize, rule: &str| {
            format!("hairpin with {fine} cells across, {increments} increments{rule}")
        };
        let case = Case::plane(name(fine, increments, rule), "folds", scene, truth);
        cases.push(case.increments(increments).twin(name(2, 10, "")));
    }
    cases
}
