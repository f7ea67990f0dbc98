//! Bodies that overlap in the reference configuration: interference fits and meshes that overlap.

use std::f64::consts::FRAC_PI_2;

use contact_core::gaps::Sampling;
use contact_core::{InteriorPoint, LoadStepped, Penalty, Retry};
use contact_fem::certificate::Certificate;
use contact_fem::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
use contact_fem::model::{
    Finding, FindingKind, Geometry, InitialGaps, Integration, Problem, Severity,
};
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, LinearElastic, Material, Mesh, NeoHookean, Scene, Simulation};
use ipopt_contact_scenes::tight;

use crate::common::{relative, run_with};

const OVERLAP: f64 = 0.01;
const PUSH: f64 = 0.1;

/// Two blocks of height 1 and modulus 1 that do not widen; the upper one starts `overlap` inside the lower one, and its
/// top is pushed down by [`PUSH`]. Their meshes do not match.
fn blocks(law: impl Material<2> + Copy, gaps: InitialGaps, overlap: f64) -> Scene<2> {
    let block = |y: f64, cells: usize, side: &str, push: f64| {
        let (x, y) = (linspace(0.0, 1.0, cells), linspace(y, y + 1.0, cells));
        let mesh = rectangle(&x, &y, Diagonals::Rising).expect("mesh");
        let mut body = Body::new(mesh, law);
        body.prescribe(side, [Some(0.0), Some(-push)])
            .expect("support");
        body
    };
    let mut scene = Scene::new();
    let lower = scene.add("lower", block(0.0, 4, "bottom", 0.0));
    let upper = scene.add("upper", block(1.0 - overlap, 3, "top", PUSH));
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    scene.initial_gaps = gaps;
    scene.integration = Some(Integration::Exact);
    scene
}

fn linear() -> LinearElastic {
    LinearElastic::new(1.0, 0.0).expect("law")
}

/// The force on the lower block at each of two increments, by the default solver and by the paper's method.
fn forces(scene: impl Fn() -> Scene<2>) -> [[f64; 2]; 2] {
    let by_default = Simulation::with_increments(2).run(&mut scene().problem().expect("valid"));
    let method = &mut InteriorPoint::default();
    let mut paper = Simulation::solved_by(Retry::with(method), 2);
    let by_paper = paper.run(&mut scene().problem().expect("valid"));
    [by_default, by_paper].map(|history| {
        let history = history.expect("no misuse");
        assert!(history.is_complete(), "{}", history.run.ending);
        let force = |k: usize| {
            let certificate = &history.steps[k].certificate;
            assert!(certificate.holds(&Default::default()), "{certificate}");
            history.steps[k].reactions[0][1]
        };
        [force(0), force(1)]
    })
}

/// At load factor t both blocks together are shorter by t times push and overlap if it is resolved, by t times the push
/// if it is left out.
#[test]
fn blocks_press_by_what_is_resolved() {
    for (gaps, shortened) in [
        (InitialGaps::Resolve, PUSH + OVERLAP),
        (InitialGaps::Adjust, PUSH),
    ] {
        for geometry in [Geometry::Reference, Geometry::Current] {
            let found = forces(|| {
                let mut scene = blocks(linear(), gaps, OVERLAP);
                scene.geometry = Some(geometry);
                scene
            });
            for (force, t) in found
                .iter()
                .flat_map(|forces| forces.iter().zip([0.5, 1.0]))
            {
                let expected = t * shortened / 2.0;
                assert!(
                    relative(*force, expected) < 1e-6,
                    "{gaps:?} {geometry:?}: {force} for {expected}"
                );
            }
        }
    }
}

/// The penalty of the paper on points.
#[test]
fn points_leave_out_what_nodes_do() {
    for (gaps, shortened) in [
        (InitialGaps::Resolve, PUSH + OVERLAP),
        (InitialGaps::Adjust, PUSH),
    ] {
        let mut scene = blocks(linear(), gaps, OVERLAP);
        scene.integration = Some(Integration::Gauss(4));
        let mut problem = scene.problem().expect("valid");
        let history = run_with(&mut Penalty::default(), &mut problem, 2, 1e-8);
        assert!(history.is_complete(), "{}", history.run.ending);
        for (step, t) in history.steps.iter().zip([0.5, 1.0]) {
            let (force, expected) = (step.reactions[0][1], t * shortened / 2.0);
            assert!(
                relative(force, expected) < 1e-2,
                "{gaps:?}: {force} for {expected}"
            );
        }
    }
}

/// Rows of nodes and of points vanish at load factor 0; at half load they have fallen by half of the overlap.
#[test]
fn rows_start_at_zero() {
    for sampling in [Sampling::Nodes, Sampling::Points] {
        let scene = blocks(linear(), InitialGaps::Resolve, OVERLAP);
        let mut problem = scene.problem().expect("valid");
        let rest = vec![0.0; problem.dofs().free()];
        for (load, expected) in [(0.0, 0.0), (0.5, -0.5 * OVERLAP)] {
            problem.set_load(load).expect("load");
            // the rows of the upper block's nodes, whose prescribed ones are on the other side
            let rows = problem.rows(&rest, sampling).expect("a state");
            let mut c = vec![0.0; rows.len()];
            rows.value(&rest, &mut c);
            assert!(!c.is_empty());
            assert!(
                c.iter().all(|c| (c - expected).abs() < 1e-15),
                "{sampling:?} {load}: {c:?}"
            );
        }
    }
}

/// Two blocks as before, but the lower face of the upper one is tilted: it starts inside the lower one by `depths` at its ends.
fn tilted(depths: [f64; 2], gaps: InitialGaps) -> Scene<2> {
    let mesh = |y: f64| {
        let (x, y) = (linspace(0.0, 1.0, 4), linspace(y, y + 1.0, 4));
        rectangle(&x, &y, Diagonals::Rising).expect("mesh")
    };
    let mut lower = Body::new(mesh(0.0), linear());
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let depth = |x: f64| depths[0] + (depths[1] - depths[0]) * x;
    let lowered = mesh(1.0).mapped(|x| *x - Vector::<2>::new(0.0, depth(x[0]) * (2.0 - x[1])));
    let mut upper = Body::new(lowered.expect("mesh"), linear());
    upper.prescribe("top", [Some(0.0); 2]).expect("support");
    let mut scene = Scene::new();
    let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    scene.initial_gaps = gaps;
    scene.integration = Some(Integration::Exact);
    scene
}

/// The row of a node has its own overlap: that at the node inside the face, at a third of the facet at its ends.
#[test]
fn rows_of_an_overlap_that_varies() {
    let depths = [0.005, 0.03];
    let mut problem = tilted(depths, InitialGaps::Resolve)
        .problem()
        .expect("valid");
    let rest = vec![0.0; problem.dofs().free()];
    for load in [0.0, 0.5, 1.0] {
        problem.set_load(load).expect("load");
        let rows = problem.rows(&rest, Sampling::Nodes).expect("a state");
        let mut c = vec![0.0; rows.len()];
        rows.value(&rest, &mut c);
        assert_eq!(c.len(), 10);
        for (key, c) in rows.keys().iter().zip(c) {
            let x = problem.reference()[key.node as usize][0];
            let x = x.clamp(0.25 / 3.0, 1.0 - 0.25 / 3.0);
            let expected = -load * (depths[0] + (depths[1] - depths[0]) * x);
            // along a normal that is tilted by 1/40
            assert!(
                (c - expected).abs() < 1e-3 * depths[1],
                "{load} {x}: {c} for {expected}"
            );
        }
    }
}

/// The deep end of a tilted face is pushed out, however many facets deep it is; beyond 0.4 of the thickness, which is 1, the scene is refused.
#[test]
fn the_deep_end_of_a_tilted_face_is_seen() {
    let facet = 0.25;
    for gaps in [InitialGaps::Resolve, InitialGaps::Adjust] {
        for deep in [0.14, 0.28, 0.6] {
            let scene = tilted([0.1 * facet, deep * facet], gaps);
            let mut problem = scene.problem().expect("valid");
            let history = Simulation::with_increments(1)
                .run(&mut problem)
                .expect("no misuse");
            assert!(history.is_complete(), "{gaps:?} {deep}");
            let u = &history.run.solution.as_ref().expect("a solution").state.u;
            let overlaps = problem.audit(u).expect("a state").overlaps;
            let deepest = overlaps.iter().map(|overlap| overlap.depth);
            let deepest = deepest.fold(0.0, f64::max) / facet;
            // what stays moves nothing; the end itself is on the side of the lower block, inside or not by round-off, the last node but one is inside
            let inside = 0.1 + 0.75 * (deep - 0.1);
            let moved = u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            let stays = (inside - 1e-9..deep + 1e-9).contains(&deepest) && moved < 1e-12;
            match gaps {
                InitialGaps::Resolve => assert!(deepest < 0.02, "{deep}: {deepest}"),
                _ => assert!(stays, "{deep}: {deepest}, moved by {moved}"),
            }
        }
        let refused = tilted([0.1 * facet, 0.6], gaps).problem();
        assert!(matches!(refused, Err(Error::Overlap { .. })), "{gaps:?}");
    }
}

/// A third body inside the lower one, without a pair, is not what the scene grants.
#[test]
fn overlaps_without_a_pair_are_not_granted() {
    for geometry in [Geometry::Reference, Geometry::Current] {
        let mut scene = blocks(linear(), InitialGaps::Adjust, OVERLAP);
        let (x, y) = (linspace(0.8, 1.8, 4), linspace(0.2, 0.7, 4));
        let mesh = rectangle(&x, &y, Diagonals::Rising).expect("mesh");
        let mut third = Body::new(mesh, linear());
        third.prescribe("right", [Some(0.0); 2]).expect("support");
        scene.add("third", third);
        scene.geometry = Some(geometry);
        let mut problem = scene.problem().expect("valid");
        let history = Simulation::with_increments(1)
            .run(&mut problem)
            .expect("no misuse");
        let holds = |c: Certificate| c.holds(&Default::default());
        assert!(!history.is_complete() || !history.certificate().is_some_and(holds));
        assert_eq!(
            history.is_complete(),
            geometry == Geometry::Reference,
            "{}",
            history.run.ending
        );
    }
}

/// A quarter of a ring, of quadratic elements, free to move in radial direction.
fn ring(radii: [f64; 2], segments: usize, law: impl Material<2>) -> Body<2> {
    let mesh = || -> Result<Mesh<2>, Error> {
        let (r, angle) = (
            linspace(radii[0], radii[1], 3),
            linspace(0.0, FRAC_PI_2, segments),
        );
        let mesh = rectangle(&r, &angle, Diagonals::Rising)?.quadratic();
        mesh.mapped(|x| Vector::<2>::new(x[0] * x[1].cos(), x[0] * x[1].sin()))
    };
    let mut ring = Body::new(mesh().expect("mesh"), law);
    ring.prescribe("bottom", [None, Some(0.0)])
        .expect("symmetry");
    ring.prescribe("top", [Some(0.0), None]).expect("symmetry");
    ring
}

/// Inner radius, common radius and outer radius.
const RADII: [f64; 3] = [1.0, 2.0, 3.0];
const POISSON: f64 = 0.3;
/// Of the two rings.
const SEGMENTS: [usize; 2] = [7, 9];

/// A ring pressed into another one of half its modulus, too large by `interference`.
fn press_fit<M: Material<2>>(
    law: impl Fn(f64) -> M,
    interference: f64,
    segments: [usize; 2],
) -> Problem<2> {
    let mut scene = Scene::new();
    let hub = ring(
        [RADII[0], RADII[1] + interference],
        segments[0],
        law(2000.0),
    );
    let hub = scene.add("hub", hub);
    let tyre = scene.add("tyre", ring([RADII[1], RADII[2]], segments[1], law(1000.0)));
    scene
        .contact(hub.on("right"), tyre.on("left"))
        .expect("a pair");
    scene.initial_gaps = InitialGaps::Resolve;
    scene.problem().expect("valid")
}

/// The pressure in the fit by Lamé's solution in plane strain.
fn pressure_by_lame(interference: f64) -> f64 {
    let [a, b, c] = RADII.map(|r| r * r);
    let [hub, tyre] = [2000.0, 1000.0].map(|young| young / (1.0 - POISSON * POISSON));
    let nu = POISSON / (1.0 - POISSON);
    let give = RADII[1] * (((b + a) / (b - a) - nu) / hub + ((c + b) / (c - b) + nu) / tyre);
    interference / give
}

/// The mean pressure at full load: the radial contact forces on the tyre over the area of the fit.
fn mean_pressure(problem: &Problem<2>, history: &History<2>) -> f64 {
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = history.certificate().expect("converged");
    assert!(certificate.holds(&tight()), "{certificate}");
    let solution = history.run.solution.as_ref().expect("converged");
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let radial = |a: usize| forces[a].dot(&problem.reference()[a].normalize());
    problem.nodes(1).map(radial).sum::<f64>() / (RADII[1] * FRAC_PI_2)
}

/// The chords of coarse rings differ by more than a small interference: the error falls with the meshes.
#[test]
fn a_press_fit_has_the_pressure_of_lame() {
    let law = |young| LinearElastic::new(young, POISSON).expect("law");
    let interference = 1e-3;
    let expected = pressure_by_lame(interference);
    let errors = [[7, 9], [14, 18], [28, 36]].map(|segments| {
        let mut problem = press_fit(law, interference, segments);
        let run = Simulation::with_increments(2).run(&mut problem);
        let history = run.expect("no misuse");
        // the energy grows with the square of what is resolved
        let half = history.steps[0].energy / history.steps[1].energy;
        assert!((half - 0.25).abs() < 0.02, "{half}");
        relative(mean_pressure(&problem, &history), expected)
    });
    assert!(
        errors[0] < 1e-2 && errors[2] < 0.5 * errors[0],
        "{errors:?}"
    );
    // the rest is of the order of interference over radius
    assert!(errors[2] < 1e-3, "{errors:?}");
}

/// The end does not depend on the increments, and large strains are close to small ones.
#[test]
fn a_press_fit_at_large_strains() {
    let law = |young| NeoHookean::new(young, POISSON).expect("law");
    let interference = 0.02;
    let pressures = [1, 4].map(|increments| {
        let mut problem = press_fit(law, interference, SEGMENTS);
        let history = Simulation::with_increments(increments)
            .run(&mut problem)
            .expect("no misuse");
        mean_pressure(&problem, &history)
    });
    assert!(relative(pressures[0], pressures[1]) < 1e-6, "{pressures:?}");
    let expected = pressure_by_lame(interference);
    assert!(
        relative(pressures[0], expected) < 0.03,
        "{pressures:?} for {expected}"
    );
}

/// A sleeve thinner than the facets, and too small by half of its thickness.
#[test]
fn a_thin_sleeve() {
    let law = NeoHookean::new(1000.0, POISSON).expect("law");
    let mut scene = Scene::new();
    let hub = scene.add("hub", ring([1.0, 2.0], 14, law));
    let sleeve = scene.add("sleeve", ring([1.99, 2.01], 14, law));
    scene
        .contact(hub.on("right"), sleeve.on("left"))
        .expect("a pair");
    scene.initial_gaps = InitialGaps::Resolve;
    let mut problem = scene.problem().expect("valid");
    let history = Simulation::with_increments(2)
        .run(&mut problem)
        .expect("no misuse");
    assert!(history.is_complete(), "{}", history.run.ending);
    for step in &history.steps {
        assert!(
            step.certificate.holds(&Default::default()),
            "{}",
            step.certificate
        );
    }
    // the sleeve is a bar in plane strain, stretched around a hub that hardly gives
    let (thickness, strain) = (0.02, 0.01 / 2.0);
    let hoop = 1000.0 / (1.0 - POISSON * POISSON);
    let expected = 0.5 * hoop * strain * strain * thickness * 2.0 * FRAC_PI_2;
    let found = history.last().expect("converged").energy;
    assert!(relative(found, expected) < 0.05, "{found} for {expected}");
}

/// In space, where the blocks' meshes do not match either.
#[test]
fn blocks_in_space() {
    let block = |z: f64, cells: usize, side: &str, push: f64| {
        let mesh = cuboid([0.0, 0.0, z], [1.0; 3], [cells; 3]).expect("mesh");
        let mut body = Body::new(mesh, linear());
        body.prescribe(side, [Some(0.0), Some(0.0), Some(-push)])
            .expect("support");
        body
    };
    let mut scene = Scene::new();
    let lower = scene.add("lower", block(0.0, 3, "bottom", 0.0));
    let upper = scene.add("upper", block(1.0 - OVERLAP, 2, "top", PUSH));
    scene
        .contact(lower.on("top"), upper.on("bottom"))
        .expect("a pair");
    scene.initial_gaps = InitialGaps::Resolve;
    scene.integration = Some(Integration::Exact);
    let mut problem = scene.problem().expect("valid");
    let history = Simulation::with_increments(1)
        .run(&mut problem)
        .expect("no misuse");
    let step = history.last().expect("converged");
    let expected = (PUSH + OVERLAP) / 2.0;
    assert!(
        relative(step.reactions[0][2], expected) < 1e-6,
        "{} for {expected}",
        step.reactions[0]
    );
}

#[test]
fn deep_overlaps_are_refused() {
    // of the coarser block's facets, and of the blocks' height
    let (facet, height) = (1.0 / 3.0, 1.0);
    for (gaps, largest) in [
        (InitialGaps::Refuse, 0.05 * facet),
        (InitialGaps::Resolve, 0.4 * height),
    ] {
        let refused = blocks(linear(), gaps, 1.1 * largest).problem();
        assert!(matches!(refused, Err(Error::Overlap { .. })));
        let accepted = blocks(linear(), gaps, 0.9 * largest)
            .problem()
            .expect("valid");
        let is_noted =
            |f: &Finding| (f.severity, f.kind) == (Severity::Note, FindingKind::Interference);
        assert!(accepted.findings().iter().any(is_noted));
    }
}

/// A block on rollers that nothing touches may go sideways; a held one may not.
#[test]
fn what_nothing_determines_is_told() {
    let scene = |sideways: Option<f64>| {
        let mut scene = tilted([0.01; 2], InitialGaps::Resolve);
        let mesh = rectangle(&[2.0, 3.0], &[0.0, 1.0], Diagonals::Rising).expect("mesh");
        let mut block = Body::new(mesh, linear());
        block
            .prescribe("bottom", [sideways, Some(0.0)])
            .expect("support");
        let block = scene.add("block", block);
        let lower = scene.ids().next().expect("a body");
        scene
            .contact(lower.on("right"), block.on("left"))
            .expect("a pair");
        scene
    };
    for (sideways, expected) in [(None, 1), (Some(0.0), 0)] {
        let mut problem = scene(sideways).problem().expect("valid");
        let history = Simulation::with_increments(1)
            .run(&mut problem)
            .expect("no misuse");
        let solution = history.run.solution.as_ref().expect("converged");
        let found = problem.undetermined(solution);
        assert_eq!(found.len(), expected, "{found:?}");
        for part in found {
            assert_eq!(
                (part.body.as_str(), &part.motions[..]),
                ("block", &["translation x".to_string()][..])
            );
        }
    }
}
