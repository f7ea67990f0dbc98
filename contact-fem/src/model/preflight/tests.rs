//! Each rule finds its scene, and not the benign twin of it.

use super::{Finding, FindingKind, Severity};
use crate::mesh::generators::{Diagonals, disc, linspace, onto_sphere, rectangle};
use crate::model::{Geometry, Integration, Overlaps};
use crate::tensor::Vector;
use crate::{Body, Error, LinearElastic, Material, Mesh, Motion, NeoHookean, Obstacle, Scene};

/// A block with its lower left corner at `low`.
fn mesh(low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Mesh<2> {
    let line = |i: usize| linspace(low[i], low[i] + size[i], cells[i]);
    rectangle(&line(0), &line(1), Diagonals::Alternating).expect("mesh")
}

fn unit(y: f64) -> Mesh<2> {
    mesh([0.0, y], [1.0; 2], [4, 4])
}

fn linear() -> LinearElastic {
    LinearElastic::new(1e3, 0.3).expect("law")
}

fn large() -> NeoHookean {
    NeoHookean::new(1e3, 0.3).expect("law")
}

fn held(mesh: Mesh<2>, law: impl Material<2>) -> Body<2> {
    let mut body = Body::new(mesh, law);
    body.prescribe("bottom", [Some(0.0); 2]).expect("support");
    body
}

fn pushed(mesh: Mesh<2>, law: impl Material<2>, by: [f64; 2]) -> Body<2> {
    let mut body = Body::new(mesh, law);
    body.prescribe("top", by.map(Some)).expect("support");
    body
}

/// Two blocks, the second on top of the first.
fn stacked(lower: Body<2>, upper: Body<2>) -> Scene<2> {
    let mut scene = Scene::new();
    let lower = scene.add("lower", lower).on("top");
    let upper = scene.add("upper", upper).on("bottom");
    scene.contact(lower, upper).expect("a pair");
    scene
}

/// A linear block that is pressed on another one by 0.01.
fn pressed(law: impl Material<2>) -> Scene<2> {
    stacked(
        held(unit(0.0), law.clone()),
        pushed(unit(1.0), law, [0.0, -0.01]),
    )
}

fn alone(body: Body<2>) -> Scene<2> {
    let mut scene = Scene::new();
    scene.add("body", body);
    scene
}

/// The findings of a kind.
fn of(scene: &Scene<2>, kind: FindingKind) -> Vec<Finding> {
    let findings = scene.preflight().into_iter();
    findings.filter(|finding| finding.kind == kind).collect()
}

/// The one finding of a kind in the first scene, of which the second, sound one has none.
fn differ(scene: &Scene<2>, twin: &Scene<2>, kind: FindingKind) -> Finding {
    let loud = |f: &&Finding| f.severity > Severity::Note;
    let twins = twin.preflight();
    assert!(!twins.iter().any(|f| f.kind == kind), "{twins:?}");
    assert_eq!(twins.iter().find(loud), None);
    let mut found = of(scene, kind);
    assert_eq!(found.len(), 1, "{:?}", scene.preflight());
    let found = found.remove(0);
    assert!(
        !found.what.is_empty() && !found.remedy.is_empty(),
        "{found:?}"
    );
    found
}

#[test]
fn a_sound_scene() {
    for scene in [pressed(linear()), pressed(large())] {
        assert_eq!(scene.preflight(), []);
        assert_eq!(scene.problem().expect("sound").findings(), []);
    }
}

#[test]
fn input_that_is_not_valid() {
    for tolerance in [f64::INFINITY, f64::NAN, -0.1] {
        let mut scene = pressed(linear());
        scene.overlap_tolerance = tolerance;
        let found = differ(&scene, &pressed(linear()), FindingKind::Input);
        assert_eq!(found.severity, Severity::Error);
        assert!(found.remedy.contains("facet size"), "{found}");
        let error = scene.problem().err().expect("refused");
        assert!(matches!(
            error,
            Error::Setting {
                name: "overlap_tolerance",
                ..
            }
        ));
    }
    let mut scene = Scene::<2>::new();
    assert_eq!(of(&scene, FindingKind::Input)[0].severity, Severity::Error);
    let body = scene.add("", held(unit(0.0), linear()));
    scene.contact_surface(body.on("top")).expect("a surface");
    let errors = scene.preflight();
    let errors = errors.iter().filter(|f| f.severity == Severity::Error);
    assert_eq!(errors.count(), 2, "the name and the lone surface");
}

#[test]
fn empty_boundaries() {
    let mut empty = unit(0.0);
    empty.name_boundary("nowhere", |x| x[0] > 7.0);
    let named = |mesh: Mesh<2>| {
        stacked(
            held(mesh, linear()),
            pushed(unit(1.0), linear(), [0.0, -0.01]),
        )
    };
    let found = differ(
        &named(empty.clone()),
        &named(unit(0.0)),
        FindingKind::EmptyBoundary,
    );
    assert!(found.what.contains("nowhere") && found.bodies == ["lower"]);
    let mut body = held(empty, linear());
    let support = body
        .prescribe("nowhere", [Some(0.0); 2])
        .err()
        .expect("refused");
    let traction = body.traction("nowhere", [1.0, 0.0]).err().expect("refused");
    for error in [support, traction] {
        assert!(matches!(error, Error::EmptyBoundary { .. }), "{error}");
    }
}

#[test]
fn motions_that_are_free_or_held_by_contact() {
    let mut floating = Body::new(unit(1.0), linear());
    floating.body_force([0.0, -1.0]).expect("load");
    let by_contact = stacked(held(unit(0.0), linear()), floating);
    let found = differ(&by_contact, &pressed(linear()), FindingKind::HeldByContact);
    assert_eq!((found.severity, found.value), (Severity::Note, 2.0));
    assert!(
        found.what.ends_with("`upper`: translation y, rotation"),
        "{found}"
    );
    // without friction, it may slide
    let slides = &of(&by_contact, FindingKind::HeldByNothing)[0];
    assert_eq!((slides.severity, slides.value), (Severity::Note, 1.0));
    assert!(slides.what.ends_with("`upper`: translation x"), "{slides}");
    assert!(
        found
            .remedy
            .contains("prescribe displacements in place of forces"),
        "{found}"
    );
    // between two bodies whose displacements are prescribed
    let mut between = Scene::new();
    let lower = between.add("lower", held(unit(0.0), linear()));
    let middle = between.add("middle", Body::new(unit(1.0), linear()));
    let tool = between.add("tool", pushed(unit(2.0), linear(), [0.0, -0.01]));
    for (below, above) in [(&lower, &middle), (&middle, &tool)] {
        between
            .contact(below.on("top"), above.on("bottom"))
            .expect("a pair");
    }
    let found = of(&between, FindingKind::HeldByContact);
    assert_eq!(
        found[0].remedy,
        "leave it so if it stays in contact; otherwise support these motions, too"
    );

    let roller = |held_at: &[usize]| {
        let mut body = Body::new(unit(0.0), linear());
        body.prescribe("bottom", [None, Some(0.0)])
            .expect("support");
        if !held_at.is_empty() {
            body.prescribe_nodes(held_at, [Some(0.0), None])
                .expect("support");
        }
        body.traction("top", [0.0, -1.0]).expect("load");
        alone(body)
    };
    let found = differ(&roller(&[]), &roller(&[0]), FindingKind::FreeMotion);
    assert_eq!((found.severity, found.value), (Severity::Error, 1.0));
    assert!(found.what.contains("translation x"), "{found}");
    let error = roller(&[]).problem().err().expect("refused");
    assert!(error.to_string().contains("translation x"), "{error}");
}

/// Two triangles that share a node, or a side.
#[test]
fn a_hinge() {
    let scene = |cells: Vec<usize>, nodes: &[[f64; 2]], at_rest: &[usize]| {
        let mut body = Body::new(Mesh::new(nodes.to_vec(), cells).expect("mesh"), linear());
        body.prescribe_nodes(at_rest, [Some(0.0); 2])
            .expect("support");
        body.body_force([0.0, -1.0]).expect("load");
        alone(body)
    };
    let bow = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]];
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let hinge = scene(vec![0, 1, 2, 1, 3, 4], &bow, &[0, 2]);
    let found = differ(
        &hinge,
        &scene(vec![0, 1, 2, 0, 2, 3], &square, &[0, 1]),
        FindingKind::Mechanism,
    );
    assert_eq!((found.value, found.place), (1.0, Some(vec![1.0, 0.0])));
    let braced = scene(vec![0, 1, 2, 1, 3, 4], &bow, &[0, 2, 4]);
    assert!(of(&braced, FindingKind::Mechanism).is_empty());
}

#[test]
fn bodies_that_start_inside_each_other() {
    let at = |y: f64| {
        stacked(
            held(unit(0.0), large()),
            pushed(unit(y), large(), [0.0, -0.01]),
        )
    };
    let found = differ(&at(0.95), &at(1.0), FindingKind::Interference);
    assert_eq!(found.severity, Severity::Error);
    assert!((found.value - 0.05).abs() < 1e-12 && (found.limit - 0.0125).abs() < 1e-12);
    assert!(!found.remedy.contains("overlap_tolerance"), "{found}");
    let slight = of(&at(0.999), FindingKind::Interference);
    assert!(
        !slight.is_empty() && slight.iter().all(|f| f.severity == Severity::Note),
        "{slight:?}"
    );
    assert!((slight[0].value - 1e-3).abs() < 1e-12);

    // declared where they do not meet
    let elsewhere = |y: f64| {
        let mut scene = Scene::new();
        let lower = scene.add("lower", held(unit(0.0), large()));
        let upper = scene.add("upper", pushed(unit(y), large(), [0.0, -0.01]));
        scene.reach = Some(3.0);
        scene
            .contact(lower.on("bottom"), upper.on("top"))
            .expect("a pair");
        scene
    };
    let found = of(&elsewhere(0.6), FindingKind::Interference);
    assert_eq!((found.len(), found[0].severity), (1, Severity::Error));
    assert!(of(&elsewhere(1.0), FindingKind::Interference).is_empty());

    // no pair parts these
    let undeclared = |y: f64, overlaps: Overlaps| {
        let mut scene = Scene::new();
        scene.overlaps = overlaps;
        scene.add("lower", held(unit(0.0), large()));
        scene.add("upper", pushed(unit(y), large(), [0.0, -0.01]));
        scene
    };
    let inside = undeclared(0.6, Overlaps::Refused);
    let found = differ(
        &inside,
        &undeclared(1.02, Overlaps::Refused),
        FindingKind::Interference,
    );
    assert_eq!(found.severity, Severity::Warning);
    assert_eq!(undeclared(0.6, Overlaps::Allowed).preflight(), []);
    // in one place, no node is inside and no edge crosses a face
    let found = of(
        &undeclared(0.0, Overlaps::Refused),
        FindingKind::Interference,
    );
    assert_eq!((found.len(), found[0].severity), (1, Severity::Error));
    let allowed = undeclared(0.0, Overlaps::Allowed);
    assert!(of(&allowed, FindingKind::Interference).is_empty());
}

#[test]
fn surfaces_out_of_reach() {
    let at = |y: f64, by: f64, reach: Option<f64>| {
        let mut scene = stacked(
            held(unit(0.0), large()),
            pushed(unit(y), large(), [0.0, by]),
        );
        scene.reach = reach;
        scene
    };
    let found = differ(
        &at(3.0, -0.2, None),
        &at(1.1, -0.2, None),
        FindingKind::OutOfReach,
    );
    assert!((found.value - 2.0).abs() < 1e-12, "{found}");
    let prescribed = at(3.0, -2.01, None);
    assert!(
        of(&prescribed, FindingKind::OutOfReach).is_empty(),
        "it gets there"
    );
    assert!(of(&at(3.0, -0.2, Some(3.0)), FindingKind::OutOfReach).is_empty());
}

/// Tools that come down, are loaded, or slide after the load factor 1 are known as those that do so before.
#[test]
fn programs_that_go_further_than_full_load() {
    let table = |end: f64| {
        let pairs = [(0.5 * end, 0.0), (end, 1.0)];
        crate::Amplitude::table(&pairs).expect("a table")
    };
    let come = |low: f64, by: [f64; 2], end: f64, law: fn(Mesh<2>) -> Body<2>| {
        let mut tool = law(unit(low));
        tool.prescribe_in_time("top", by.map(Some), table(end))
            .expect("a support");
        stacked(held(unit(0.0), linear()), tool)
    };
    for end in [1.0, 2.0, 7.0] {
        let mut down = come(3.0, [0.0, -2.01], end, |mesh| Body::new(mesh, large()));
        down.geometry = Some(Geometry::Current);
        assert_eq!(of(&down, FindingKind::OutOfReach), [], "{end}");
        assert_eq!(of(&down, FindingKind::Unloaded), [], "{end}");
        let long = of(&down, FindingKind::LongStep);
        assert!((long[0].value - 2.01).abs() < 1e-12, "{end}: {long:?}");
        let slid = come(1.0, [0.4, -0.01], end, |mesh| Body::new(mesh, linear()));
        let found = of(&slid, FindingKind::BeyondFacet);
        let [found] = &found[..] else {
            panic!("{end}: {found:?}");
        };
        assert!((found.value - 0.4 / 0.25).abs() < 1e-9, "{end}: {found}");
        let way = Motion::<2>::translation([0.0, 0.5]).expect("a way");
        let moving = on(floor(-0.5, 1.0).moving(way.driven_by(table(end))));
        assert_eq!(of(&moving, FindingKind::OutOfReach), [], "{end}");
        let mut loaded = held(unit(0.0), linear());
        loaded
            .traction_in_time("top", [0.0, -1.0], table(end))
            .expect("a load");
        assert_eq!(of(&alone(loaded), FindingKind::Unloaded), [], "{end}");
    }
}

#[test]
fn surfaces_that_do_not_face_each_other() {
    let scene = |side: &str| {
        let mut scene = Scene::new();
        let lower = scene.add("lower", held(unit(0.0), large()));
        let upper = scene.add("upper", pushed(unit(1.0), large(), [0.0, -0.01]));
        scene
            .contact(lower.on("top"), upper.on(side))
            .expect("a pair");
        scene
    };
    let found = differ(&scene("top"), &scene("bottom"), FindingKind::FacingAway);
    assert!((found.value + 1.0).abs() < 1e-12, "{found}");
}

/// A body that touches itself at a node: a blunt piece below, a sharp one above. And a wedge alone.
#[test]
fn normals_where_a_body_touches_itself() {
    let scene = |nodes: &[[f64; 2]], cells: &[usize]| {
        let mut mesh = Mesh::new(nodes.to_vec(), cells.to_vec()).expect("mesh");
        mesh.name_boundary("all", |_| true);
        let mut body = Body::new(mesh, large());
        let held: Vec<usize> = (1..nodes.len()).collect();
        body.prescribe_nodes(&held, [Some(0.01), Some(0.0)])
            .expect("support");
        let mut scene = Scene::new();
        let body = scene.add("body", body);
        let block = scene.add("block", held_at(1.2));
        scene
            .contact(body.on("all"), block.on("left"))
            .expect("a pair");
        scene
    };
    let nodes = [
        [0.0, 0.0],
        [-1.0, -1.0],
        [1.0, -1.0],
        [0.3, 1.0],
        [-0.3, 1.0],
    ];
    let touching = scene(&nodes, &[0, 1, 2, 0, 3, 4]);
    let found = differ(
        &touching,
        &scene(&nodes[..3], &[0, 1, 2]),
        FindingKind::InwardNormal,
    );
    // minus the sine of half the upper angle
    assert!(
        (found.value + 0.3 / 1.0f64.hypot(0.3)).abs() < 1e-12,
        "{found}"
    );
    assert_eq!(found.place.as_deref(), Some(&[0.0, 0.0][..]));
}

/// A block at rest with its left side at `x`.
fn held_at(x: f64) -> Body<2> {
    held(mesh([x, -1.0], [1.0, 2.0], [2, 2]), large())
}

#[test]
fn cracks_that_are_open() {
    // two columns that meet at x = 1 in nodes of their own, or in one
    let columns = |apart: f64| {
        let (left, right) = (unit(0.0), mesh([1.0 + apart, 0.0], [1.0; 2], [4, 4]));
        let count = left.nodes().len();
        let nodes = left
            .nodes()
            .iter()
            .chain(right.nodes())
            .map(|x| [x[0], x[1]]);
        let cells = left.cells().flatten().copied();
        let cells = cells.chain(right.cells().flatten().map(|a| a + count));
        let mut mesh = Mesh::new(nodes.collect(), cells.collect()).expect("mesh");
        mesh.name_boundary("bottom", |x| x[1] == 0.0);
        mesh.name_boundary("seam", |x| (x[0] - 1.0).abs() < 0.01);
        let mut body = held(mesh, linear());
        body.body_force([1.0, 0.0]).expect("load");
        body
    };
    let found = differ(
        &alone(columns(0.0)),
        &alone(columns(0.1)),
        FindingKind::OpenSeam,
    );
    assert_eq!(found.value, 5.0);
    let mut declared = Scene::new();
    let body = declared.add("body", columns(0.0));
    declared.self_contact(body.on("seam")).expect("a pair");
    assert!(of(&declared, FindingKind::OpenSeam).is_empty());
}

#[test]
fn thin_bodies() {
    let scene = |plate: Mesh<2>, below: Mesh<2>, side: &str| {
        let mut plate = plate;
        plate.name_boundary("faces", |x| x[1] == 1.0 || x[1] == 1.01);
        let mut scene = Scene::new();
        let block = scene.add("block", held(below, large()));
        let plate = scene.add("plate", pushed(plate, large(), [0.0, -1e-3]));
        scene
            .contact(block.on("top"), plate.on(side))
            .expect("a pair");
        scene
    };
    let plate = |cells: usize| mesh([0.0, 1.0], [1.0, 0.01], [cells, 1]);
    let below = || mesh([0.0; 2], [1.0; 2], [10, 4]);
    let thin = scene(plate(10), below(), "faces");
    let found = differ(
        &thin,
        &scene(plate(50), below(), "faces"),
        FindingKind::ThinBody,
    );
    assert!(
        (found.value - 0.1).abs() < 1e-9 && found.bodies == ["plate"],
        "{found}"
    );
    // nothing can be taken for the near side where the far one may not touch
    assert_eq!(scene(plate(10), below(), "bottom").preflight(), []);
    // quadratic facets are as long
    let quadratic = scene(plate(10).quadratic(), below().quadratic(), "faces");
    let found = of(&quadratic, FindingKind::ThinBody);
    assert!((found[0].value - 0.1).abs() < 1e-9, "{found:?}");
}

#[test]
fn straight_facets_along_a_curve() {
    // a disc whose lower part is pressed on a block
    let scene = |disc: Mesh<2>| {
        let mut disc = disc.translated([0.5, 2.0]).expect("moved");
        disc.name_boundary("top", |x| x[1] > 2.8);
        disc.name_boundary("low", |x| x[1] < 2.1);
        let mut scene = Scene::new();
        let block = scene.add("block", held(unit(0.0).quadratic(), linear()));
        let disc = scene.add("disc", pushed(disc, linear(), [0.0, -0.01]));
        scene
            .contact(block.on("top"), disc.on("low"))
            .expect("a pair");
        scene
    };
    let straight = |segments: usize| disc(1.0, segments, 6, 0.0).expect("mesh").quadratic();
    let curved = |segments: usize| {
        let mesh = straight(segments).curved("boundary", onto_sphere(1.0));
        mesh.expect("curved")
    };
    for segments in [12, 36] {
        let found = differ(
            &scene(straight(segments)),
            &scene(curved(segments)),
            FindingKind::StraightFacets,
        );
        let angle = 360.0 / segments as f64;
        assert!((found.value - angle).abs() < 1e-9, "{found}");
        assert_eq!(found.bodies, ["disc"]);
    }
    let linear = disc(1.0, 36, 6, 0.0).expect("mesh");
    assert!(of(&scene(linear), FindingKind::StraightFacets).is_empty());
    // sides of two facets with bends of 20° are sides of a polygon
    let polygon = disc(1.0, 36, 6, 0.0).expect("mesh").mapped(|x| {
        let turn = std::f64::consts::TAU / 18.0;
        let from = x[1].atan2(x[0]).rem_euclid(turn) - turn / 2.0;
        x * ((turn / 2.0).cos() / from.cos())
    });
    let polygon = polygon.expect("mapped").quadratic();
    assert!(of(&scene(polygon), FindingKind::StraightFacets).is_empty());
}

#[test]
fn slivers() {
    let scene = |over: usize| {
        let mut body = held(mesh([0.0, 0.0], [1.0; 2], [1, over]), linear());
        body.traction("top", [0.0, -1.0]).expect("load");
        alone(body)
    };
    let found = differ(&scene(2000), &scene(200), FindingKind::Sliver);
    assert!((found.value / 2000.0 - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn meshes_of_different_fineness() {
    let scene = |cells: usize| {
        let upper = mesh([0.0, 1.0], [1.0; 2], [cells, cells]);
        stacked(
            held(mesh([0.0, 0.0], [1.0; 2], [2, 2]), large()),
            pushed(upper, large(), [0.0, -0.01]),
        )
    };
    let found = differ(&scene(40), &scene(10), FindingKind::MeshRatio);
    assert!((found.value - 20.0).abs() < 1e-9, "{found}");
    let mut exact = scene(40);
    exact.integration = Some(Integration::Exact);
    assert!(
        !of(&exact, FindingKind::MeshRatio).is_empty(),
        "the pressure is still linear"
    );
}

#[test]
fn linear_elements_that_lock() {
    let scene = |nu: f64, mesh: Mesh<2>| {
        let law = LinearElastic::new(1e3, nu).expect("law");
        let mut body = held(mesh, law);
        body.traction("top", [0.0, -1.0]).expect("load");
        alone(body)
    };
    let found = differ(
        &scene(0.49, unit(0.0)),
        &scene(0.45, unit(0.0)),
        FindingKind::Locking,
    );
    assert!((found.value - 0.49).abs() < 1e-9, "{found}");
    assert!(scene(0.49, unit(0.0).quadratic()).preflight().is_empty());
}

/// A block is moved 0.03 towards another one, 0.01 above it, without a pair: whatever the mesh, that is told. With a pair, a
/// gap of 0.05 between them or leave to pass, it is not.
#[test]
fn bodies_that_come_together_without_contact() {
    let scene = |gap: f64, cells: usize| {
        let upper = mesh([0.1, 1.0 + gap], [1.0; 2], [cells, cells]);
        let mut scene = Scene::new();
        scene.add("lower", held(unit(0.0), linear()));
        scene.add("upper", pushed(upper, linear(), [0.0, -0.03]));
        scene
    };
    for cells in [1, 3, 20] {
        let found = differ(
            &scene(0.01, cells),
            &scene(0.05, cells),
            FindingKind::Undeclared,
        );
        assert!((found.value - 0.02).abs() < 1e-9, "{found}");
        assert_eq!(found.bodies, ["lower", "upper"]);
        let mut allowed = scene(0.01, cells);
        allowed.overlaps = Overlaps::Allowed;
        assert!(of(&allowed, FindingKind::Undeclared).is_empty());
    }
    let stacked = pressed(linear());
    assert!(of(&stacked, FindingKind::Undeclared).is_empty());
}

#[test]
fn laws_for_small_strains() {
    let moved = |by: [f64; 2]| stacked(held(unit(0.0), linear()), pushed(unit(1.0), linear(), by));
    let found = differ(
        &moved([0.4, -0.01]),
        &moved([0.2, -0.01]),
        FindingKind::BeyondFacet,
    );
    assert!((found.value - 0.4 / 0.25).abs() < 1e-9, "{found}");
    let mut current = moved([0.4, -0.01]);
    current.geometry = Some(Geometry::Current);
    assert!(of(&current, FindingKind::BeyondFacet).is_empty());

    // a bar turned about its end
    let turned = |degrees: f64, law: Body<2>| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut body = law;
        let nodes = body.mesh().nodes().to_vec();
        for (a, x) in nodes
            .iter()
            .enumerate()
            .filter(|(_, x)| x[1] == 0.0 || x[1] == 1.0)
        {
            let now = Vector::<2>::new(cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]);
            let by: [f64; 2] = (now - x).into();
            body.prescribe_nodes(&[a], by.map(Some)).expect("support");
        }
        alone(body)
    };
    let body = || Body::new(unit(0.0), linear());
    let found = differ(
        &turned(8.0, body()),
        &turned(3.0, body()),
        FindingKind::Rotation,
    );
    assert!((found.value - 8.0).abs() < 1e-9, "{found}");
    for degrees in [45.0, 90.0, 135.0, 179.0] {
        let found = of(&turned(degrees, body()), FindingKind::Rotation);
        assert!((found[0].value - degrees).abs() < 1e-9, "{degrees}");
    }
    assert_eq!(turned(8.0, Body::new(unit(0.0), large())).preflight(), []);
}

#[test]
fn steps_beyond_the_reach() {
    let moved = |by: f64| {
        stacked(
            held(unit(0.0), large()),
            pushed(unit(1.0), large(), [by, -0.01]),
        )
    };
    let found = differ(&moved(0.9), &moved(0.2), FindingKind::LongStep);
    assert_eq!(found.severity, Severity::Note);
    assert!(found.remedy.contains("take 5 load increments"), "{found}");
    let problem = moved(0.9).problem().expect("sound");
    assert_eq!(problem.findings().len(), 1);
    assert_eq!(problem.findings_in(2)[0].severity, Severity::Warning);
    assert_eq!(problem.findings_in(5), []);
}

#[test]
fn loads_that_round_off_hides() {
    let moved = |law: Body<2>, by: f64| {
        let mut body = law;
        body.prescribe("top", [None, Some(-by)]).expect("support");
        alone(body)
    };
    let (small, of_F) = (|| held(unit(0.0), linear()), || held(unit(0.0), large()));
    let found = differ(
        &moved(small(), 1e-13),
        &moved(small(), 1e-10),
        FindingKind::RoundOff,
    );
    assert_eq!(found.severity, Severity::Error);
    let found = differ(
        &moved(of_F(), 1e-10),
        &moved(of_F(), 1e-7),
        FindingKind::RoundOff,
    );
    assert_eq!((found.severity, found.limit), (Severity::Error, 1e-9));
    let error = moved(of_F(), 1e-10).problem().err().expect("refused");
    assert!(matches!(error, Error::Negligible { .. }), "{error}");

    let loaded = |force: f64, by: f64| {
        let mut body = held(unit(0.0), linear());
        body.prescribe("top", [None, Some(-by)]).expect("support");
        body.traction("right", [force, 0.0]).expect("load");
        alone(body)
    };
    assert_eq!(
        of(&loaded(1e-14, 0.0), FindingKind::RoundOff)[0].severity,
        Severity::Error
    );
    let found = differ(
        &loaded(1e-14, 0.01),
        &loaded(1e-3, 0.01),
        FindingKind::RoundOff,
    );
    assert_eq!(found.severity, Severity::Warning);

    let far = |x: f64| {
        let at = |y: f64| mesh([x, y], [1.0; 2], [4, 4]);
        stacked(
            held(at(0.0), linear()),
            pushed(at(1.0), linear(), [0.0, -1e-6]),
        )
    };
    let found = differ(&far(1e7), &far(10.0), FindingKind::RoundOff);
    assert_eq!(found.severity, Severity::Warning);

    let still = of(&moved(small(), 0.0), FindingKind::Unloaded);
    assert_eq!(still[0].severity, Severity::Note);
}

#[test]
fn units_that_differ() {
    let scene = |modulus: f64| {
        let stiff = LinearElastic::new(modulus, 0.3).expect("law");
        stacked(
            held(unit(0.0), linear()),
            pushed(unit(1.0), stiff, [0.0, -0.01]),
        )
    };
    let found = differ(&scene(2e9), &scene(1e9), FindingKind::Units);
    assert_eq!(found.bodies, ["lower", "upper"]);
    let sizes = |size: f64| {
        let mut scene = Scene::new();
        scene.add("large", pushed(unit(0.0), linear(), [0.0, -0.01]));
        scene.add("small", held(mesh([5.0, 0.0], [size; 2], [2, 2]), linear()));
        scene
    };
    differ(&sizes(1e-7), &sizes(1e-5), FindingKind::Units);
}

/// Any scene of odd numbers is checked without a panic.
#[test]
fn odd_scenes() {
    for (size, by) in [
        (1e-90, 1e300),
        (1e90, 1e-300),
        (1.0, f64::MAX),
        (1e150, 0.0),
    ] {
        for law in [large(), NeoHookean::new(1e-100, 0.4999).expect("law")] {
            let at = |y: f64| mesh([0.0, y * size], [size, size], [1, 1]);
            let mut scene = stacked(held(at(0.0), law), pushed(at(1.0), law, [by, -by]));
            scene.reach = Some(f64::INFINITY);
            scene.preflight();
            scene.overlap_tolerance = f64::MAX;
            scene.preflight();
        }
    }
}

/// A frame around a hole and a square that fills both, in the same place. No node of the square's top is
/// inside the frame or the other way round, no edges cross, and the middles of the square's two
/// triangles are in the hole; those of the frame's are in the square.
#[test]
fn a_frame_in_a_square() {
    let nodes = vec![
        [0.0, 0.0],
        [9.0, 0.0],
        [9.0, 9.0],
        [0.0, 9.0],
        [2.5, 2.5],
        [6.5, 2.5],
        [6.5, 6.5],
        [2.5, 6.5],
    ];
    let sides = (0..4usize).flat_map(|k| {
        let next = (k + 1) % 4;
        [k, next, 4 + next, k, 4 + next, 4 + k]
    });
    let frame = || {
        let mut mesh = Mesh::new(nodes.clone(), sides.clone().collect()).expect("mesh");
        mesh.name_boundary("top", |x| x[1] > 8.5);
        mesh.name_boundary("bottom", |x| x[1] < 0.5);
        held(mesh, linear())
    };
    let square = || held(mesh([0.0; 2], [9.0; 2], [1, 1]), linear());
    for frame_first in [true, false] {
        let mut scene = Scene::new();
        scene.geometry = Some(crate::model::Geometry::Current);
        let (first, second) = match frame_first {
            true => (frame(), square()),
            false => (square(), frame()),
        };
        let first = scene.add("first", first).on("top");
        let second = scene.add("second", second).on("top");
        scene.contact(first, second).expect("a pair");
        let refused = scene.problem().err();
        let crossing = matches!(refused, Some(crate::Error::Crossing { .. }));
        assert!(crossing, "{frame_first}: {refused:?}");
    }
}

/// A block, not loaded, whose bottom may touch an obstacle.
fn on(obstacle: Obstacle<2>) -> Scene<2> {
    let body = pushed(unit(0.0), large(), [0.0, -0.01]);
    let mut scene = Scene::new();
    let side = scene.add("block", body).on("bottom");
    scene.obstacle("obstacle", side, obstacle).expect("a side");
    scene
}

fn floor(y: f64, up: f64) -> Obstacle<2> {
    Obstacle::half_space([0.0, y], [0.0, up]).expect("a half-plane")
}

/// The message with which a scene is refused.
fn refused(scene: Scene<2>) -> String {
    let Err(error) = scene.problem() else {
        panic!("accepted");
    };
    error.to_string()
}

#[test]
fn obstacles_that_are_out_of_reach() {
    let found = differ(
        &on(floor(-0.5, 1.0)),
        &on(floor(-0.05, 1.0)),
        FindingKind::OutOfReach,
    );
    assert_eq!(found.bodies, ["block", "obstacle"]);
    assert!((found.value - 0.5).abs() < 1e-12 && (found.limit - 0.1 * 2f64.sqrt()).abs() < 1e-12);
    // a motion that brings it there is none to tell of
    let down = Motion::<2>::translation([0.0, 0.5]).expect("a way");
    let moving = on(floor(-0.5, 1.0).moving(down));
    assert!(of(&moving, FindingKind::OutOfReach).is_empty());
}

#[test]
fn obstacles_that_a_boundary_faces_away_from() {
    // above the block, seen from below
    let found = differ(
        &on(floor(1.05, -1.0)),
        &on(floor(0.0, 1.0)),
        FindingKind::FacingAway,
    );
    assert_eq!(found.severity, Severity::Warning);
}

#[test]
fn bodies_that_start_in_obstacles() {
    // facets of 0.25, of which a 20th is granted
    for (y, limit) in [(0.012, None), (0.013, Some("1.300e-2 deep"))] {
        let scene = on(floor(y, 1.0));
        let notes = of(&scene, FindingKind::Interference);
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!((notes[0].value - y).abs() < 1e-12);
        match limit {
            None => assert_eq!(notes[0].severity, Severity::Note),
            Some(says) => {
                let error = refused(scene);
                assert!(
                    error.contains("`block` starts inside obstacle `obstacle`"),
                    "{error}"
                );
                assert!(error.contains(says), "{error}");
            }
        }
    }
    // the wrong side out
    assert!(refused(on(floor(0.0, -1.0))).contains("which side of the obstacle is its outside"));
    // between the nodes
    let needle = Obstacle::ball([0.125, 0.0], 0.06).expect("a needle");
    assert!(refused(on(needle)).contains("starts inside"));
}

#[test]
fn distances_that_are_none() {
    let twice = |x: &Vector<2>| 2.0 * x[1] + 0.1;
    let half = |x: &Vector<2>| 0.5 * (x[1] + 0.1);
    let hole = |x: &Vector<2>| if x[0] > 0.6 { f64::NAN } else { x[1] + 0.1 };
    for (distance, says) in [
        (Obstacle::signed_distance(twice), "slope of the distance"),
        (Obstacle::signed_distance(half), "slope of the distance"),
        (
            Obstacle::signed_distance(hole),
            "distance of obstacle `obstacle` is NaN at [0.75",
        ),
    ] {
        let error = refused(on(distance));
        assert!(
            error.contains(says) && error.contains("obstacle `obstacle`"),
            "{error}"
        );
    }
    // a kink, as of two walls, is none to refuse
    let corner = Obstacle::signed_distance(|x: &Vector<2>| (x[1] + 0.05).min(x[0] + 0.2));
    assert!(on(corner).problem().is_ok());
}

#[test]
fn names_of_obstacles() {
    let mut twice = on(floor(0.0, 1.0));
    let side = twice.obstructed()[0].0.clone();
    twice
        .obstacle("block", side, floor(0.0, 1.0))
        .expect("a side");
    assert!(refused(twice).contains("obstacle `block` has the name of a body"));
    let mut unnamed = on(floor(0.0, 1.0));
    let side = unnamed.obstructed()[0].0.clone();
    unnamed.obstacle("", side, floor(0.0, 1.0)).expect("a side");
    assert!(refused(unnamed).contains("obstacle number 2 from the first"));
}

/// Only the obstacle holds it, and there is nothing that is prescribed.
#[test]
fn a_body_that_an_obstacle_holds() {
    let mut body = Body::new(unit(0.0), large());
    body.body_force([0.0, -1.0]).expect("weight");
    let mut scene = Scene::new();
    let side = scene.add("block", body).on("bottom");
    let floor = scene.obstacle("floor", side.clone(), floor(0.0, 1.0));
    let floor = floor.expect("a side");
    let held = of(&scene, FindingKind::HeldByContact);
    assert_eq!((held.len(), held[0].value), (1, 2.0));
    // twice the same is once, and other scenes' obstacles are none
    scene
        .contact_obstacle(side.clone(), floor)
        .expect("the same");
    assert_eq!(scene.obstructed().len(), 1);
    let unknown = Scene::<2>::new().contact_obstacle(side, floor);
    assert!(unknown.is_err());
    assert!(scene.problem().is_ok());
}

#[test]
fn loads_on_what_is_held() {
    let loaded = |on: &str| {
        let mut upper = pushed(unit(1.0), linear(), [0.0, -0.01]);
        upper.traction(on, [0.0, -1.0]).expect("a boundary");
        stacked(held(unit(0.0), linear()), upper)
    };
    let found = differ(&loaded("top"), &loaded("left"), FindingKind::Unloaded);
    assert_eq!(found.severity, Severity::Warning);
    assert!(found.what.contains("traction on `top`"), "{found}");
}
