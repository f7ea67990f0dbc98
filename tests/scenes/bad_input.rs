//! Bad input is refused before any solve, by a typed error that names it.

use contact_core::equilibrium::Solution;
use contact_core::gaps::Sampling;
use contact_core::{Automatic, ContactProblem, LoadStepped, Outcome, State};
use contact_fem::contact::Pass;
use contact_fem::mesh::generators::{
    Diagonals, annulus, cuboid, cuboid_graded, disc, linspace, rectangle,
};
use contact_fem::model::{FindingKind, Geometry, Integration, Passes, Severity};
use contact_fem::output::Snapshot;
use contact_fem::output::vtk::Series;
use contact_fem::tensor::Vector;
use contact_fem::{
    Body, BodyId, Certificate, Error, LinearElastic, Mesh, NeoHookean, Scene, Simulation,
};
use ipopt_contact_scenes::{alone, pair};

fn law() -> NeoHookean {
    NeoHookean::new(1.0, 0.3).expect("law")
}

/// A unit square with its lower left corner at (0, y).
fn square(y: f64) -> Body<2> {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 2),
        &linspace(y, y + 1.0, 2),
        Diagonals::Rising,
    );
    Body::new(mesh.expect("mesh"), law())
}

fn held(y: f64) -> Body<2> {
    let mut body = square(y);
    body.prescribe("bottom", [Some(0.0); 2]).expect("support");
    body
}

/// The error says what is wrong in words that contain all of these.
fn assert_says(error: &Error, words: &[&str]) {
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "`{word}` in `{message}`");
    }
}

#[test]
fn meshes() {
    let nodes = || vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let error = Mesh::<2>::new(nodes(), vec![0, 2, 1]).expect_err("inverted");
    assert!(matches!(error, Error::InvertedCell { cell: 0, .. }));
    assert_says(&error, &["cell 0", "counter-clockwise"]);
    for size in [1e-320, 1e-170, 1e170, 1e308] {
        let nodes = nodes().iter().map(|X| X.map(|x| size * x)).collect();
        let error = Mesh::<2>::new(nodes, vec![0, 1, 2]).expect_err("out of range");
        assert!(matches!(error, Error::CellSize { cell: 0, .. }), "{error}");
        assert_says(&error, &["unit of length"]);
    }
    let mesh = Mesh::<2>::new(nodes(), vec![0, 1, 2]).expect("valid");
    for mesh in [mesh.clone(), mesh.quadratic()] {
        let maps: [fn(&Vector<2>) -> Vector<2>; 3] = [
            |X| Vector::<2>::new(-X[0], X[1]),
            |X| Vector::<2>::new(X[0] + X[1], 0.0),
            |X| Vector::<2>::new(1e20 + X[0], X[1]),
        ];
        for map in maps {
            let error = mesh.clone().mapped(map).expect_err("no volume");
            assert!(matches!(error, Error::MappedCell { cell: 0, .. }));
            assert_says(&error, &["the map", "reflect"]);
        }
    }
    let flat = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 1e-17]];
    let error = Mesh::<2>::new(flat, vec![0, 1, 2]).expect_err("degenerate");
    assert!(matches!(error, Error::DegenerateCell { cell: 0, .. }));
    let error = Mesh::<2>::new(nodes(), vec![0, 1, 3]).expect_err("out of range");
    assert!(matches!(error, Error::NodeOutOfRange { node: 3, .. }));
    assert_says(&error, &["node 3", "3 nodes"]);
    let mut nan = nodes();
    nan[2][1] = f64::NAN;
    let error = Mesh::<2>::new(nan, vec![0, 1, 2]).expect_err("NaN");
    assert!(matches!(error, Error::NotFinite { index: 5, .. }));
}

#[test]
fn generators() {
    let refused = [
        rectangle(&[0.0, 1.0, 1.0], &[0.0, 1.0], Diagonals::Rising),
        rectangle(&[0.0, f64::NAN], &[0.0, 1.0], Diagonals::Rising),
        rectangle(&[0.0], &[0.0, 1.0], Diagonals::Rising),
        disc(-1.0, 8, 1, 0.0),
        disc(1.0, 2, 1, 0.0),
        disc(1.0, 8, 0, 0.0),
        disc(1.0, 8, 1, f64::INFINITY),
    ];
    for (k, mesh) in refused.into_iter().enumerate() {
        assert!(mesh.is_err(), "case {k}");
    }
}

#[test]
fn boundary_names() {
    let mut body = square(0.0);
    let error = body
        .prescribe("botom", [Some(0.0); 2])
        .err()
        .expect("unknown");
    assert!(matches!(error, Error::UnknownBoundary { .. }));
    assert_says(&error, &["botom", "bottom"]);
    assert!(body.traction("side", [0.0; 2]).is_err());
    let mut scene = Scene::new();
    let lower = scene.add("lower", held(0.0));
    let upper = scene.add("upper", held(1.0));
    let error = scene
        .contact(lower.on("tip"), upper.on("bottom"))
        .expect_err("unknown");
    assert!(matches!(error, Error::UnknownBoundary { .. }));
    let error = scene
        .contact(lower.on("top"), BodyId::from(2).on("bottom"))
        .expect_err("no body");
    assert!(matches!(error, Error::UnknownBody { body: 2, bodies: 2 }));
}

#[test]
fn body_names() {
    let named = |names: [&str; 3]| {
        let mut scene = Scene::new();
        for (name, y) in names.into_iter().zip([0.0, 2.0, 4.0]) {
            scene.add(name, held(y));
        }
        scene.problem().err()
    };
    assert!(named(["lower", "middle", "upper"]).is_none());
    let unnamed = named(["lower", "", "upper"]).expect("refused");
    assert!(matches!(unnamed, Error::UnnamedBody { body: 1 }));
    let twice = named(["block", "plate", "block"]).expect("refused");
    assert!(matches!(twice, Error::BodyExists { bodies: [0, 2], .. }));
    assert_says(&twice, &["`block`"]);
}

#[test]
fn numbers_that_are_none() {
    let mut body = square(0.0);
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(
            body.traction("top", [0.0, bad]),
            Err(Error::NotFinite { .. })
        ));
        assert!(matches!(
            body.body_force([bad, 0.0]),
            Err(Error::NotFinite { .. })
        ));
        let prescribed = body.prescribe("top", [Some(bad), None]);
        assert!(matches!(prescribed, Err(Error::NotFinite { .. })));
    }
    for _ in 0..8 {
        body.traction("top", [0.0, f64::MAX])
            .expect("finite itself");
    }
    let error = alone(body).problem().err().expect("overflow");
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
    assert!(matches!(
        LinearElastic::new(f64::NAN, 0.3),
        Err(Error::YoungsModulus { .. })
    ));
}

#[test]
fn material_constants() {
    for nu in [0.5, 0.6, -1.0, -1.5, f64::NAN] {
        let error = NeoHookean::new(1.0, nu).expect_err("refused");
        assert!(matches!(error, Error::PoissonsRatio { .. }));
        assert_says(&error, &[&nu.to_string()]);
    }
    for modulus in [0.0, -5.0, f64::INFINITY] {
        let error = NeoHookean::new(modulus, 0.3).expect_err("refused");
        assert!(matches!(error, Error::YoungsModulus { .. }));
    }
}

/// The scene of one body is refused for rigid motions that nothing holds: how many of them.
fn free_motions(body: Body<2>) -> usize {
    match alone(body).problem().err().expect("refused") {
        Error::Unsupported {
            body,
            free,
            modes: 3,
            ..
        } if body == "body" => free,
        other => panic!("{other}"),
    }
}

#[test]
fn supports() {
    let nothing_held = alone(square(0.0)).problem().err().expect("refused");
    assert!(matches!(nothing_held, Error::NoSupport));
    let mut scene = Scene::new();
    scene.add("lower", held(0.0));
    scene.add("upper", square(2.0));
    let floating = scene.problem().err().expect("refused");
    assert!(matches!(
        floating,
        Error::Unsupported { body, free: 3, .. } if body == "upper"
    ));
    // rollers below leave the body free to slide
    let mut sliding = square(0.0);
    sliding
        .prescribe("bottom", [None, Some(0.0)])
        .expect("support");
    assert_eq!(free_motions(sliding), 1);
    // one pinned node leaves it free to rotate
    let mut pinned = square(0.0);
    pinned
        .prescribe_nodes(&[0], [Some(0.0); 2])
        .expect("support");
    assert_eq!(free_motions(pinned), 1);
    // with a contact pair, a body may float
    let scene = pair((held(0.0), "top"), (square(1.0), "bottom")).expect("surfaces");
    assert!(scene.problem().is_ok());
    assert!(Scene::<2>::new().problem().is_err());
}

/// Two triangles that share no node, of which one is held, or one may touch another body.
#[test]
fn supports_of_bodies_in_parts() {
    let triangle = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x, 1.0]];
    let nodes = [triangle(0.0), triangle(5.0)].concat();
    let mut mesh = Mesh::<2>::new(nodes, (0..6).collect()).expect("mesh");
    mesh.name_boundary("left foot", |x| x[1] == 0.0 && x[0] < 3.0);
    mesh.name_boundary("right foot", |x| x[1] == 0.0 && x[0] > 3.0);
    assert_eq!(mesh.parts(), [[0, 1, 2], [3, 4, 5]]);
    let body = || {
        let mut body = Body::new(mesh.clone(), law());
        body.prescribe("left foot", [Some(0.0); 2])
            .expect("support");
        body
    };
    let error = alone(body()).problem().err().expect("refused");
    assert!(matches!(
        error,
        Error::Unsupported {
            node: 3,
            free: 3,
            ..
        }
    ));
    assert_says(&error, &["body `body`", "node 3"]);
    let scene = pair((body(), "left foot"), (held(-1.0), "top")).expect("surfaces");
    assert!(matches!(
        scene.problem(),
        Err(Error::Unsupported { node: 3, .. })
    ));
    let scene = pair((body(), "right foot"), (held(-1.0), "top")).expect("surfaces");
    assert!(scene.problem().is_ok());
}

/// Whether supports hold a part does not depend on where it is and how large, beside what.
#[test]
fn supports_of_parts_far_apart() {
    let far = 1e6;
    for size in [1e-3, 1.0, 1e3] {
        let block = |x: f64, size: f64| {
            let values = [0.0, 0.5, 1.0].map(|t| t * size);
            let mesh = rectangle(&values.map(|t| x + t), &values, Diagonals::Rising);
            mesh.expect("mesh")
        };
        let (near, other) = (block(0.0, 1.0), block(far, size));
        let count = near.nodes().len();
        let nodes = [near.nodes(), other.nodes()].concat();
        let cells = near.cells().flatten().copied();
        let cells = cells.chain(other.cells().flatten().map(|a| a + count));
        let nodes = nodes.iter().map(|X| [X[0], X[1]]).collect();
        let mut mesh = Mesh::<2>::new(nodes, cells.collect()).expect("mesh");
        mesh.name_boundary("near", |X| X[1] == 0.0 && X[0] < 0.5 * far);
        mesh.name_boundary("far", |X| X[1] == 0.0 && X[0] > 0.5 * far);
        let free = |held: [Option<f64>; 2]| {
            let mut body = Body::new(mesh.clone(), law());
            body.prescribe("near", [Some(0.0); 2]).expect("support");
            body.prescribe("far", held).expect("support");
            match alone(body).problem() {
                Ok(_) => 0,
                Err(Error::Unsupported { node, free, .. }) if node == count => free,
                Err(other) => panic!("{other}"),
            }
        };
        assert_eq!(free([Some(0.0); 2]), 0, "size {size}");
        // rollers on a line: what slides along it, and what is held at no distance from it
        assert_eq!(free([None, Some(0.0)]), 1, "size {size}");
        assert_eq!(free([Some(0.0), None]), 2, "size {size}");
        assert_eq!(free([None; 2]), 3, "size {size}");
    }
}

/// A slender bar held at both ends is held; on a line through them it may turn about that line.
#[test]
fn supports_of_slender_parts() {
    let (sin, cos) = 0.7_f64.sin_cos();
    let turned = |X: &Vector<3>| {
        let x = Vector::<3>::new(cos * X[0] - sin * X[1], sin * X[0] + cos * X[1], X[2]);
        Vector::<3>::new(x[0], cos * x[1] - sin * x[2], sin * x[1] + cos * x[2]) * 20.0
    };
    for thickness in [1e-2, 1e-4, 1e-6] {
        let section = [0.0, thickness];
        let bar = cuboid_graded(&linspace(0.0, 1.0, 100), &section, &section).expect("mesh");
        let ends = |X: &Vector<3>| X[0] == 0.0 || X[0] == 1.0;
        let line = |X: &Vector<3>| ends(X) && X[1] == 0.0 && X[2] == 0.0;
        let free = |is_held: &dyn Fn(&Vector<3>) -> bool| {
            let nodes = bar.nodes().iter().enumerate();
            let held: Vec<usize> = nodes.filter(|n| is_held(n.1)).map(|n| n.0).collect();
            let mesh = bar.clone().mapped(turned).expect("turned");
            let mut body = Body::new(mesh, law());
            body.prescribe_nodes(&held, [Some(0.0); 3])
                .expect("support");
            match alone(body).problem() {
                Ok(_) => 0,
                Err(Error::Unsupported { free, .. }) => free,
                Err(other) => panic!("{other}"),
            }
        };
        assert_eq!(free(&ends), 0, "thickness {thickness}");
        assert_eq!(free(&line), 1, "thickness {thickness}");
        assert_eq!(free(&|X| line(X) && X[0] == 0.0), 3);
    }
}

#[test]
fn conflicting_supports() {
    let mut body = held(0.0);
    let error = body
        .prescribe("left", [Some(0.1), None])
        .err()
        .expect("corner twice");
    assert!(matches!(error, Error::Conflict { component: 0, .. }));
    assert!(body.prescribe_nodes(&[99], [Some(0.0); 2]).is_err());
}

#[test]
fn overlap_at_the_start() {
    for depth in [0.1, 0.3] {
        let mut scene = Scene::new();
        let lower = scene.add("lower", held(0.0));
        let upper = scene.add("upper", square(1.0 - depth));
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("surfaces");
        let error = scene.problem().err().expect("overlap");
        let Error::Overlap { gap, .. } = error else {
            panic!("overlap, not {error}")
        };
        assert!((gap + depth).abs() < 1e-12, "gap {gap}");
        assert_says(
            &error,
            &["body `lower`", "body `upper`", "overlap_tolerance"],
        );
    }
}

/// A bar across another one: no node of either is inside the other.
#[test]
fn bodies_that_cross() {
    let bar = |xs: [f64; 2], ys: [f64; 2]| {
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
        let mut body = Body::new(mesh, law());
        body.prescribe("left", [Some(0.0); 2]).expect("support");
        body
    };
    let scene = |ys: [f64; 2]| {
        let scene = pair(
            (bar([-4.0, 4.0], [-0.5, 0.5]), "top"),
            (bar([-0.4, 0.7], ys), "top"),
        )
        .expect("surfaces");
        scene.problem()
    };
    let error = scene([-3.0, 3.0]).err().expect("crossing");
    let Error::Crossing { depth, .. } = error else {
        panic!("crossing, not {error}")
    };
    assert!((depth - 2.5).abs() < 1e-12, "depth {depth}");
    assert_says(
        &error,
        &["bodies `first` and `second`", "overlap_tolerance"],
    );
    assert!(scene([0.5, 3.0]).is_ok(), "touching is no crossing");
}

/// A body and its copy, in 2D and 3D; and a band that is wound once and a half around the same ring.
#[test]
fn bodies_that_coincide() {
    let scene = pair((held(0.0), "top"), (held(0.0), "top")).expect("surfaces");
    let error = scene.problem().err().expect("coincide");
    assert!(
        matches!(error, Error::Crossing { depth, .. } if depth > 0.1),
        "{error}"
    );

    let cube = || {
        let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2]).expect("mesh");
        let mut body = Body::new(mesh, law());
        body.prescribe("left", [Some(0.0); 3]).expect("support");
        body
    };
    let scene = pair((cube(), "top"), (cube(), "top")).expect("surfaces");
    let error = scene.problem().err().expect("coincide");
    assert!(matches!(error, Error::Crossing { .. }), "{error}");

    let band = |turns: f64| {
        let across = linspace(1.0, 1.3, 1);
        let along = linspace(0.0, turns, (24.0 * turns) as usize);
        let mesh = rectangle(&along, &across, Diagonals::Rising).expect("mesh");
        let wound = |x: &Vector<2>| {
            let angle = -std::f64::consts::TAU * x[0];
            Vector::<2>::new(angle.cos(), angle.sin()) * x[1]
        };
        let mut body = Body::new(mesh.mapped(wound).expect("mesh"), law());
        body.prescribe("left", [Some(0.0); 2]).expect("support");
        let mut scene = Scene::new();
        let body = scene.add("band", body);
        scene.self_contact(body.on("top")).expect("surface");
        scene.problem()
    };
    assert!(band(0.75).is_ok(), "open ring");
    let error = band(1.5).err().expect("coincides");
    assert!(
        matches!(&error, Error::Crossing { first, second, .. } if [first, second] == ["band"; 2]),
        "{error}"
    );
}

/// Meshes as different as 1 to 50 may overlap as far as the coarse one's facets allow, whichever
/// comes first, and are in contact; and so may a round hole of few segments around a finer disc.
#[test]
fn overlaps_within_the_tolerance() {
    let block = |n: usize, y: f64| {
        let (xs, ys) = (linspace(0.0, 1.0, n), linspace(y, y + 1.0, n));
        let mesh = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
        Body::new(mesh, LinearElastic::new(1e3, 0.0).expect("law"))
    };
    for passes in [Passes::FirstIsSlave, Passes::SecondIsSlave, Passes::Both] {
        for coarse_first in [true, false] {
            let (mut lower, mut upper) = (block(50, 0.0), block(1, 0.96));
            lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
            upper.prescribe("top", [Some(0.0); 2]).expect("support");
            let mut bodies = [("lower", lower, "top"), ("upper", upper, "bottom")];
            if coarse_first {
                bodies.reverse();
            }
            let mut scene = Scene::new();
            let [first, second] = bodies.map(|(name, body, side)| scene.add(name, body).on(side));
            scene.integration = Some(Integration::Exact);
            scene
                .contact_in_passes(first, second, passes)
                .expect("surfaces");
            let mut problem = scene.problem().expect("within the tolerance");
            let history = crate::common::run(&mut problem, 1, 1e-6);
            let step = history.steps.last().expect("converged");
            // two springs of 1000 in series, 0.04 too long
            let force = step.reactions[0][1].abs();
            assert!((force / 20.0 - 1.0).abs() < 1e-4, "{passes:?}: {force}");
        }
    }
    for disc_first in [true, false] {
        let law = || NeoHookean::new(1e3, 0.3).expect("law");
        let hollow = annulus(&[0.7, 1.0, 2.0], 20, Diagonals::Alternating).expect("mesh");
        let mut ring = Body::new(hollow, law());
        ring.prescribe("outer", [Some(0.0); 2]).expect("support");
        let inner = Body::new(disc(0.7, 200, 30, 0.03).expect("mesh"), law());
        let (ring, inner) = ((ring, "inner"), (inner, "boundary"));
        let scene = match disc_first {
            true => pair(inner, ring),
            false => pair(ring, inner),
        };
        let scene = scene.expect("surfaces");
        assert!(scene.problem().is_ok(), "disc first: {disc_first}");
    }
}

#[test]
fn empty_contact_surface() {
    let nodes = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let mut mesh = Mesh::<2>::new(nodes, vec![0, 1, 2]).expect("mesh");
    mesh.name_boundary("nowhere", |x| x[0] > 7.0);
    let mut body = Body::new(mesh, law());
    body.prescribe_all([Some(0.0); 2]).expect("support");
    let error = pair((body, "nowhere"), (held(3.0), "bottom"))
        .err()
        .expect("empty");
    assert!(matches!(error, Error::EmptySurface { .. }));
    assert_says(&error, &["body `first`", "nowhere"]);
}

#[test]
fn settings() {
    let run = |mut simulation: Simulation| {
        let mut problem = alone(held(0.0)).problem().expect("valid");
        simulation.run(&mut problem).err()
    };
    let error = run(Simulation::with_increments(0)).expect("refused");
    assert_says(&error, &["increments", "0"]);
    for tolerance in [0.0, -1.0, f64::NAN, 2.0] {
        for simulation in [
            Simulation::solved_by(Automatic::with_tolerance(tolerance), 1),
            {
                let mut simulation = Simulation::with_increments(1);
                simulation.solver.newton.tolerance = tolerance;
                simulation
            },
        ] {
            let error = run(simulation).expect("refused");
            assert_says(&error, &["tolerance", &tolerance.to_string()]);
        }
    }
    let mut simulation = Simulation::with_increments(1);
    simulation.solver.fixed_point.fixed_point.max_iterations = 0;
    assert!(run(simulation).is_some());
    for points in [0, 65] {
        let mut scene = alone(held(0.0));
        scene.integration = Some(Integration::Gauss(points));
        assert!(matches!(
            scene.problem(),
            Err(Error::Setting {
                name: "integration",
                ..
            })
        ));
    }
    for reach in [0.0, -1.0, f64::NAN] {
        let mut scene = alone(held(0.0));
        scene.reach = Some(reach);
        assert!(matches!(
            scene.problem(),
            Err(Error::Setting { name: "reach", .. })
        ));
    }
}

/// Laws of two kinds meet contact only by choice, which either kind of geometry is.
#[test]
fn two_kinds_of_laws() {
    let scene = |geometry| {
        let mut block = Body::new(
            rectangle(&[0.0, 1.0], &[1.0, 2.0], Diagonals::Rising).expect("mesh"),
            LinearElastic::new(10.0, 0.3).expect("law"),
        );
        block
            .prescribe("top", [Some(0.0), Some(-0.01)])
            .expect("support");
        let mut scene = Scene::new();
        scene.geometry = geometry;
        let (base, block) = (scene.add("base", held(0.0)), scene.add("block", block));
        (scene, base.on("top"), block.on("bottom"))
    };
    let (apart, ..) = scene(None);
    assert!(apart.problem().is_ok(), "nothing may touch");
    for (geometry, is_exact) in [(Geometry::Reference, true), (Geometry::Current, false)] {
        let (mut chosen, base, block) = scene(Some(geometry));
        chosen.contact(base, block).expect("surfaces");
        let problem = chosen.problem().expect("chosen");
        assert_eq!(problem.is_exact(), is_exact);
    }
    let (mut mixed, base, block) = scene(None);
    mixed.contact(base, block).expect("surfaces");
    let error = mixed.problem().err().expect("refused");
    assert!(matches!(error, Error::GeometryNotChosen { .. }), "{error}");
    assert_says(&error, &["`block`", "`base`", "Scene::geometry"]);
}

/// A small square wholly inside a large one, where no surface faces the other.
#[test]
fn a_body_inside_another() {
    let large = rectangle(
        &linspace(-2.0, 3.0, 5),
        &linspace(-2.0, 3.0, 5),
        Diagonals::Rising,
    );
    let mut large = Body::new(large.expect("mesh"), law());
    large.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let scene = pair((large, "top"), (held(0.1), "top")).expect("surfaces");
    assert!(matches!(scene.problem(), Err(Error::Overlap { .. })));
}

#[test]
fn scenes_that_are_none() {
    let mut fixed = square(0.0);
    fixed.prescribe_all([Some(0.0); 2]).expect("support");
    assert!(matches!(alone(fixed).problem(), Err(Error::NothingFree)));
    for offset in [f64::NAN, f64::INFINITY, 1e20] {
        let mesh = disc(1.0, 8, 1, 0.0).expect("mesh");
        assert!(mesh.translated([offset, 0.0]).is_err(), "{offset}");
    }
}

/// A recorded run writes what the checks found into its summary: a step that is too long is a warning.
#[test]
fn findings_of_a_recorded_run() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("findings");
    let mut upper = square(1.0);
    upper
        .prescribe("top", [Some(0.5), Some(-0.01)])
        .expect("support");
    let scene = pair((held(0.0), "top"), (upper, "bottom")).expect("surfaces");
    let mut problem = scene.problem().expect("sound");
    for (increments, expected) in [(1, vec!["warning"]), (4, vec![])] {
        let mut simulation = Simulation::with_increments(increments);
        let mut recording = simulation.record(&folder);
        (recording.plan.quiet, recording.plan.vtu_every) = (true, 0);
        recording.run(&mut problem).expect("a run");
        let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let findings = summary["findings"].as_array().expect("a list");
        let severities = findings.iter().map(|f| f["severity"].as_str());
        let severities: Vec<&str> = severities.map(|s| s.expect("a severity")).collect();
        assert_eq!(severities, expected, "{findings:?}");
        for finding in findings {
            assert_eq!(finding["kind"], "LongStep");
            assert!(finding["value"].as_f64() > finding["limit"].as_f64());
        }
    }
}

/// Whether the checks of a scene tell of overlaps or coincident nodes.
fn is_found(scene: &Scene<2>) -> bool {
    let kinds = [FindingKind::Interference, FindingKind::OpenSeam];
    let findings = scene.preflight();
    let mut found = findings.iter();
    found.any(|found| found.severity == Severity::Error || kinds.contains(&found.kind))
}

/// What the checks of a scene do not tell, no run certifies.
fn is_told(scene: Scene<2>) -> bool {
    let is_found = is_found(&scene);
    if let Ok(mut problem) = scene.problem() {
        let simulation = &mut Simulation::with_increments(1);
        let history = simulation.run(&mut problem).expect("a run");
        let certificate = history.certificate();
        let holds = certificate.is_some_and(|found| found.holds(&Default::default()));
        assert!(is_found || !(history.is_complete() && holds));
    }
    is_found
}

/// Two squares over each other in one mesh, with nodes of their own, without any contact declared.
#[test]
fn cells_over_each_other() {
    let twice = |offset: f64| {
        let square = rectangle(
            &linspace(0.0, 1.0, 3),
            &linspace(0.0, 1.0, 3),
            Diagonals::Rising,
        );
        let square = square.expect("mesh");
        let count = square.nodes().len();
        let nodes = square.nodes().iter().map(|X| [X[0], X[1]]);
        let moved = square.nodes().iter().map(|X| [X[0] + offset, X[1]]);
        let cells = square.cells().flatten().copied();
        let cells = cells.chain(square.cells().flatten().map(|a| a + count));
        let mut mesh = Mesh::<2>::new(nodes.chain(moved).collect(), cells.collect()).expect("mesh");
        mesh.name_boundary("bottom", |X| X[1] == 0.0);
        let mut body = Body::new(mesh, law());
        body.prescribe("bottom", [Some(0.0); 2]).expect("support");
        body.body_force([0.0, -0.01]).expect("load");
        alone(body)
    };
    assert!(!is_found(&twice(1.5)), "side by side");
    assert!(is_told(twice(0.0)) && is_told(twice(0.5)));
    is_told(twice(0.1));
}

/// Two squares in each other, with contact between the sides that look away.
#[test]
fn far_sides_of_bodies_that_overlap() {
    for depth in [0.05, 0.1, 0.3, 0.5, 0.9] {
        let mut upper = square(1.0 - depth);
        upper
            .prescribe("top", [Some(0.0), Some(-0.01)])
            .expect("support");
        is_told(pair((held(0.0), "bottom"), (upper, "top")).expect("surfaces"));
    }
}

/// Unknowns that are too few, too many, or no numbers; rows and multipliers of another problem: an error or no number, and
/// no panic.
#[test]
fn states_that_are_none() {
    let problem = |n: usize| {
        let mesh = rectangle(&linspace(0.0, 1.0, n), &[1.0, 2.0], Diagonals::Rising);
        let mut upper = Body::new(mesh.expect("mesh"), law());
        upper
            .prescribe("top", [Some(0.0), Some(-0.1)])
            .expect("support");
        let scene = pair((held(0.0), "top"), (upper, "bottom")).expect("surfaces");
        scene.problem().expect("sound")
    };
    let (mut problem, other) = (problem(1), problem(5));
    let n = problem.dofs().free();
    let mut no_number = vec![0.0; n];
    no_number[n / 2] = f64::NAN;
    let mut infinite = vec![0.0; n];
    infinite[0] = f64::INFINITY;
    let sound = problem
        .rows(&vec![0.0; n], Sampling::Nodes)
        .expect("a state");
    for u in [
        vec![],
        vec![0.0; n - 1],
        vec![0.0; n + 1],
        no_number,
        infinite,
    ] {
        assert!(!problem.is_state(&u));
        for sampling in [Sampling::Nodes, Sampling::Points] {
            let error = problem.rows(&u, sampling).expect_err("no state");
            assert!(error.to_string().contains('u'), "{error}");
            assert!(problem.linearize_gaps(&u, sampling).is_err());
            assert!(problem.linearize_reversed(&u, sampling).is_err());
        }
        assert!(problem.audit(&u).is_err());
        assert!(
            problem
                .vary_gaps(&u, &sound, &vec![None; sound.len()])
                .is_err()
        );
        let is_number = |v: &Vector<2>| v.iter().all(|x| x.is_finite());
        for all in [problem.positions(&u), problem.displacements(&u)] {
            assert_eq!(all.len(), problem.reference().len());
            assert!(!all.iter().all(is_number));
        }
        assert!(problem.penetration(&u).is_nan() && problem.relative_penetration(&u).is_nan());
        assert!(problem.inverted(&u) > 0);
        assert!(!(problem.least_volume(&u).expect("cells").bound > 0.0));
        assert!(!problem.residual(1, &u).iter().all(|f| f.is_finite()));
        let none = vec![Vector::<2>::zeros(); problem.reference().len()];
        assert!(!problem.reactions(&u, &none).iter().all(is_number));
        assert!(
            problem
                .pressures(&u, &sound, &vec![0.0; sound.len()])
                .is_err()
        );
        let solution = Solution {
            outcome: Outcome::Converged,
            state: State {
                u,
                ..State::default()
            },
            energy: 0.0,
            lambda: vec![0.0; sound.len()],
            gaps: sound.clone(),
            history: vec![],
            failed: vec![],
            curvature: None,
            flickering: vec![],
            held: vec![],
            softest: None,
            friction: None,
        };
        let certificate = Certificate::new(&problem, &solution);
        assert!(!certificate.holds(&Default::default()));
        assert!(problem.undetermined(&solution).is_empty());
        assert!(Snapshot::new(&problem, &solution).is_err());
    }
    let rest = vec![0.0; n];
    let foreign = other
        .rows(&vec![0.0; other.dofs().free()], Sampling::Nodes)
        .expect("a state");
    for (gaps, count) in [
        (&sound, 0),
        (&sound, sound.len() + 1),
        (&foreign, foreign.len()),
    ] {
        let forces = problem.contact_forces(gaps, &vec![1.0; count]);
        assert!(forces.iter().all(|f| f[0].is_nan()));
    }
    assert!(problem.reactions(&rest, &[]).iter().all(|f| f[0].is_nan()));
    let beyond = Pass {
        slave: 0,
        master: 9,
    };
    assert!(problem.rows_of(&[beyond], &rest, Sampling::Nodes).is_err());
    for factor in [f64::NAN, f64::INFINITY] {
        let error = problem.set_load(factor).expect_err("no load");
        assert!(error.to_string().contains("load factor"), "{error}");
    }
    assert_eq!(problem.load(), 0.0);

    // a snapshot of another problem, and one with a field cut short
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("foreign_snapshot");
    let mut series = Series::create(&folder, "state").expect("a folder");
    let mut short = Snapshot::at_rest(&problem).expect("a state");
    short.pressures.pop();
    for snapshot in [Snapshot::at_rest(&other).expect("a state"), short] {
        let error = series
            .write(0.0, &problem, &snapshot)
            .expect_err("of another problem");
        assert_says(&error, &["Snapshot::"]);
        assert!(series.is_empty() && !series.collection().exists());
    }
}
