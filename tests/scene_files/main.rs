//! Scene files and the program that runs them: the twins of the examples, the checks of `--check`, the page that lists all keys, the gallery, runs
//! that are interrupted or killed, and results that are compared. One program, which shares what it compiles.

mod accuracy;
mod compare;
mod endings;
mod gallery;
mod hints;
#[cfg(unix)]
mod interrupt;
mod meshes;
mod page;
mod parts;
mod refused;
mod resume;
mod scripts;
mod tools;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ipopt_contact::contact_fem::element::{Element, Order, P1, P2};
use ipopt_contact::prelude::*;
use ipopt_contact::scene_file::SceneFile;
use ipopt_contact_scenes::beams::{Beams, Law};
use ipopt_contact_scenes::blocks::Blocks;
use ipopt_contact_scenes::disc_in_disc::{self, Fineness, Roles};
use ipopt_contact_scenes::hairpin;
use ipopt_contact_scenes::hertz::{self, Hertz};
use ipopt_contact_scenes::ironing::Ironing;
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

/// An empty folder of a test.
fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scene_files");
    let folder = folder.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("removed");
    }
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// The exit code and the output of the program.
fn program(words: &[&str], paths: &[&Path]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ipopt-contact"));
    let output = command.args(words).args(paths).output();
    let output = output.expect("the program");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&text).into())
}

/// A file with other words in place of some, each of which it has.
fn with(file: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(read(file), |text, (from, to)| {
        assert!(text.contains(from), "{file} has no `{from}`");
        text.replace(from, to)
    })
}

/// The scene of `freefem/two_bodies.edp`, with meshes of this library's beside it.
const TWO_BODIES: &str = r#"
points = 4

[[body]]
name = "lower"
mesh = "lower.msh"
quadratic = true
law = "linear-elastic"
young = 100
poisson = 0.3
supports = [{ on = 1, x = 0, y = 0 }]

[[body]]
name = "upper"
mesh = "upper.msh"
quadratic = true
law = "linear-elastic"
young = 200
poisson = 0.3
supports = [{ on = 4, x = 0.02, y = -0.02 }]

[[contact]]
first = ["lower", 4]
second = ["upper", 1]
"#;

/// A block of height 1 from `y` up.
fn block(x: [f64; 2], y: f64, cells: [usize; 2]) -> Mesh<2> {
    let (across, up) = (
        linspace(x[0], x[1], cells[0]),
        linspace(y, y + 1.0, cells[1]),
    );
    rectangle(&across, &up, Diagonals::Rising).expect("a mesh")
}

/// Writes the scene and its meshes.
fn written_bodies(folder: &Path, text: &str) -> PathBuf {
    // labels by name: 1 bottom, 2 left, 3 right, 4 top
    let [lower, upper] = [
        block([0.0, 2.0], 0.0, [8, 2]),
        block([0.5, 1.5], 1.0, [6, 3]),
    ];
    lower
        .save_freefem(folder.join("lower.msh"))
        .expect("written");
    upper
        .save_freefem(folder.join("upper.msh"))
        .expect("written");
    let path = folder.join("scene.toml");
    fs::write(&path, text).expect("written");
    path
}

#[test]
fn the_program_tells_its_version() {
    let expected = concat!("ipopt-contact ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(program(&["--version"], &[]), (Some(0), expected.into()));
}

type Solver = Box<dyn Equilibrium>;

fn automatic(increments: usize) -> Simulation<Solver> {
    Simulation::solved_by(Box::new(Automatic::default()) as Solver, increments)
}

/// The scene in a text and the same by hand end at the same state.
fn twins<const D: usize>(
    name: &str,
    text: &str,
    scene: Scene<D>,
    mut simulation: Simulation<Solver>,
) where
    P1: Element<D>,
    P2: Element<D>,
{
    let file = SceneFile::parse(text, root().join("examples"));
    let file = file.unwrap_or_else(|why| panic!("{name}: {why}"));
    assert_eq!(file.dimension().expect("a dimension"), D);
    let of_file = file.scene::<D>().expect("a scene");
    let mut of_file = of_file.problem().expect("sound");
    let ours = file.simulation().expect("settings").run(&mut of_file);
    let ours = ours.expect("a run");
    let theirs = simulation.run(&mut scene.problem().expect("sound"));
    let theirs = theirs.expect("a run");
    assert!(
        ours.is_complete() && theirs.is_complete(),
        "{name}: {}",
        ours.run.ending
    );
    assert_eq!(ours.steps.len(), theirs.steps.len(), "{name}");
    for (a, b) in ours.steps.iter().zip(&theirs.steps) {
        let off = (a.energy - b.energy).abs() / b.energy.abs();
        assert!(off < 1e-10, "{name}: {} {} {off:.1e}", a.energy, b.energy);
    }
    let (u, v) = (&ours.run.state.u, &theirs.run.state.u);
    assert_eq!(u.len(), v.len(), "{name}");
    let largest = v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let off = u
        .iter()
        .zip(v)
        .fold(0.0, |m: f64, (u, v)| m.max((u - v).abs()));
    assert!(off < 1e-10 * largest, "{name}: {off:.1e} of {largest:.1e}");
}

/// The scene of a file as it ships has the meshes, supports and loads of the example.
fn same_scene<const D: usize>(name: &str, scene: &Scene<D>)
where
    P1: Element<D>,
    P2: Element<D>,
{
    let file = SceneFile::read(root().join("examples").join(name).with_extension("toml"));
    let ours = file.expect("a file").scene::<D>().expect("a scene");
    assert_eq!(ours.names(), scene.names(), "{name}");
    assert_eq!(ours.pairs().len(), scene.pairs().len(), "{name}");
    for (a, b) in ours.bodies().iter().zip(scene.bodies()) {
        assert!(a.mesh().cells().eq(b.mesh().cells()), "{name}");
        let (low, high) = b.mesh().bounding_box();
        let nodes = a.mesh().nodes().iter().zip(b.mesh().nodes());
        let off = nodes.fold(0.0, |m: f64, (a, b)| m.max((a - b).amax()));
        assert!(off < 1e-14 * (high - low).norm(), "{name}: {off:.1e}");
        assert_eq!(a.prescribed(), b.prescribed(), "{name}");
        let forces = a.forces().iter().zip(b.forces());
        let off = forces.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        let largest = b.forces().iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        assert!(off <= 1e-13 * largest, "{name}: {off:.1e}");
    }
}

#[test]
fn every_example_has_its_twin() {
    let entries = fs::read_dir(root().join("examples")).expect("a folder");
    let names: BTreeSet<String> = entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into()
        })
        .collect();
    let examples = names.iter().filter_map(|name| name.strip_suffix(".rs"));
    // a comparison of programs, whose scenes are in freefem/, and one of projections
    let scenes = examples.filter(|name| !["freefem_compare", "continuity"].contains(name));
    let twins = names.iter().filter_map(|name| name.strip_suffix(".toml"));
    assert_eq!(scenes.collect::<Vec<_>>(), twins.collect::<Vec<_>>());
}

#[test]
fn two_bodies() {
    // as `examples/two_bodies.rs` has it
    let scene = |quadratic: bool| -> Result<Scene<2>, ipopt_contact::contact_fem::Error> {
        let block = |x: [f64; 2], y: f64, cells: [usize; 2], young| {
            let (across, up) = (
                linspace(x[0], x[1], cells[0]),
                linspace(y, y + 1.0, cells[1]),
            );
            let mesh = rectangle(&across, &up, Diagonals::Rising)?;
            let mesh = if quadratic { mesh.quadratic() } else { mesh };
            Ok::<_, ipopt_contact::contact_fem::Error>(Body::new(
                mesh,
                LinearElastic::new(young, 0.3)?,
            ))
        };
        let mut lower = block([0.0, 2.0], 0.0, [8, 2], 100.0)?;
        lower.prescribe("bottom", [Some(0.0), Some(0.0)])?;
        let mut upper = block([0.5, 1.5], 1.0, [6, 3], 200.0)?;
        upper.prescribe("top", [Some(0.02), Some(-0.02)])?;
        let mut scene = Scene::new();
        let (lower, upper) = (scene.add("lower", lower), scene.add("upper", upper));
        scene.integration = Some(Integration::Gauss(4));
        scene.contact(lower.on("top"), upper.on("bottom"))?;
        Ok(scene)
    };
    same_scene("two_bodies", &scene(false).expect("a scene"));
    let linear = read("examples/two_bodies.toml");
    twins(
        "two_bodies",
        &linear,
        scene(false).expect("a scene"),
        automatic(1),
    );
    let quadratic = linear.replace("law =", "quadratic = true\nlaw =");
    twins(
        "two_bodies",
        &quadratic,
        scene(true).expect("a scene"),
        automatic(1),
    );
}

/// The text of a mesh of 16 segments around the hole, in 8 increments.
fn coarse_discs() -> String {
    let Fineness { hole, layers, disc } = Fineness::scaled(16);
    let share = |k: usize| (k as f64 / layers as f64).powf(1.3);
    let radii: Vec<f64> = (0..=layers).map(|k| 0.7 + 1.3 * share(k)).collect();
    let text = with(
        "examples/disc_in_disc.toml",
        &[
            ("segments = 64", &format!("segments = {hole}")),
            ("segments = 52", &format!("segments = {disc}")),
            ("increments = 100", "increments = 8"),
        ],
    );
    let (before, rest) = text.split_once("radii = [").expect("radii");
    let (_, after) = rest.split_once("]\n").expect("an end");
    format!("{before}radii = {radii:?}\n{after}")
}

#[test]
fn disc_in_disc_from_a_file() {
    let scene = |fineness| disc_in_disc::scene(fineness, Roles::default()).expect("a scene");
    same_scene("disc_in_disc", &scene(Fineness::REFERENCE));
    twins(
        "disc_in_disc",
        &coarse_discs(),
        scene(Fineness::scaled(16)),
        automatic(8),
    );
}

#[test]
fn three_beams_from_a_file() {
    let beams = |order, law| Beams::new(2, order, law).scene().expect("a scene");
    same_scene("three_beams", &beams(Order::Quadratic, Law::SmallStrain));
    let linear = with("examples/three_beams.toml", &[("quadratic = true\n", "")]);
    twins(
        "three_beams",
        &linear,
        beams(Order::Linear, Law::SmallStrain),
        automatic(1),
    );
    let coarse = [
        ("linear-elastic", "neo-hookean"),
        ("increments = 1", "increments = 4"),
        ("[8, 2, 2]", "[4, 1, 1]"),
        ("[9, 2, 2]", "[5, 1, 1]"),
    ];
    let large = coarse
        .iter()
        .fold(linear, |text, (from, to)| text.replace(from, to));
    let scene = Beams::new(1, Order::Linear, Law::NeoHookean).scene();
    twins("three_beams", &large, scene.expect("a scene"), automatic(4));
}

/// A mesh in FreeFEM's format, with the labels 1 to 4 for bottom, left, right and top.
fn band(fine: usize) -> String {
    let scene = hairpin::scene(fine, true).expect("a scene");
    let mesh = scene.bodies()[0].mesh();
    let mut edges = String::new();
    let mut count = 0;
    for (k, name) in ["bottom", "left", "right", "top"].into_iter().enumerate() {
        for facet in mesh.boundary(name).expect("a boundary") {
            edges += &format!("{} {} {}\n", facet[0] + 1, facet[1] + 1, k + 1);
            count += 1;
        }
    }
    let mut text = format!("{} {} {count}\n", mesh.nodes().len(), mesh.len());
    for x in mesh.nodes() {
        text += &format!("{:?} {:?} 0\n", x[0], x[1]);
    }
    for cell in mesh.cells() {
        text += &format!("{} {} {} 0\n", cell[0] + 1, cell[1] + 1, cell[2] + 1);
    }
    text + &edges
}

/// The mesh beside the scene file is that of the example, and closes on itself likewise.
#[test]
fn hairpin_from_a_file() {
    let folder = fresh("hairpin");
    // to be copied where the example has changed
    let written = band(2);
    fs::write(folder.join("hairpin.msh"), &written).expect("written");
    let ships = read("examples/hairpin.msh");
    let numbers = |text: &str| -> Vec<f64> {
        let words = text.split_whitespace();
        words.map(|word| word.parse().expect("a number")).collect()
    };
    let (ours, theirs) = (numbers(&written), numbers(&ships));
    assert_eq!(ours.len(), theirs.len());
    // cosines may differ by round-off
    assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 1e-15));
    same_scene("hairpin", &hairpin::scene(2, true).expect("a scene"));

    // with one cell through the band, the example's `skin` has its ends, too
    let text = with(
        "examples/hairpin.toml",
        &[("increments = 16", "increments = 8")],
    );
    let scene = hairpin::scene(2, true).expect("a scene");
    twins("hairpin", &text, scene, automatic(8));
}

/// The die's mesh beside the scene file is that of the example.
#[test]
fn ironing_from_a_file() {
    let ironing = Ironing::new(Order::Linear, 36);
    let scene = || ironing.scene().expect("a scene");
    let file = SceneFile::read(root().join("examples/ironing.toml")).expect("a file");
    let ours = file.scene::<2>().expect("a scene");
    for (a, b) in ours.bodies().iter().zip(scene().bodies()) {
        assert!(a.mesh().cells().eq(b.mesh().cells()));
        let nodes = a.mesh().nodes().iter().zip(b.mesh().nodes());
        let off = nodes.fold(0.0, |m: f64, (a, b)| m.max((a - b).amax()));
        assert!(off < 1e-14, "{off:.1e}");
    }
    let text = with(
        "examples/ironing.toml",
        &[
            ("increments = 20", "increments = 3"),
            ("increments = 100", "increments = 5"),
            ("until = 2", "until = 1.25"),
        ],
    );
    let mut simulation = automatic(1);
    let phases = [Phase::new("press", 1.0, 3), Phase::new("slide", 1.25, 5)];
    simulation.load_steps.phases = phases.to_vec();
    twins("ironing", &text, scene(), simulation);
}

fn by_ipopt<M: Method + 'static>(method: M, tolerance: Option<f64>) -> Simulation<Solver> {
    let mut retry = Retry::with(method);
    if let Some(tolerance) = tolerance {
        retry.fixed_point.tolerance = tolerance;
    }
    Simulation::solved_by(Box::new(retry) as Solver, 1)
}

#[test]
fn patch_test_from_a_file() {
    let method = || InteriorPoint {
        complementarity: 1e-12,
        ..InteriorPoint::default()
    };
    let blocks = Blocks::new([4, 9], Order::Linear, Integration::Exact);
    same_scene("patch_test", &blocks.plane().expect("a scene"));
    let text = read("examples/patch_test.toml");
    let simulation = by_ipopt(method(), Some(1e-11));
    twins(
        "patch_test",
        &text,
        blocks.plane().expect("a scene"),
        simulation,
    );
    // one pass, quadratic, and accelerated by fewer differences
    let text = text
        .replace("law =", "quadratic = true\nlaw =")
        .replace("first = [", "passes = \"first-is-slave\"\nfirst = [")
        .replace("tolerance = 1e-11\n", "tolerance = 1e-11\ndepth = 3\n");
    let one = Blocks {
        passes: Passes::FirstIsSlave,
        ..Blocks::new([4, 9], Order::Quadratic, Integration::Exact)
    };
    let mut retry = Retry::with(method());
    retry.fixed_point.tolerance = 1e-11;
    retry.fixed_point.acceleration = Acceleration::Anderson(3);
    let simulation = Simulation::solved_by(Box::new(retry) as Solver, 1);
    twins(
        "patch_test",
        &text,
        one.plane().expect("a scene"),
        simulation,
    );
}

/// The paper's three formulations.
#[test]
fn methods_from_a_file() {
    let scene = || {
        let hertz = Hertz::new(hertz::Fineness::family(5), Order::Linear);
        hertz.scene().expect("a scene")
    };
    same_scene("methods", &scene());
    let text = read("examples/methods.toml");
    twins(
        "methods",
        &text,
        scene(),
        by_ipopt(InteriorPoint::default(), None),
    );
    let continuation = Continuation {
        penetration: 1e-4,
        ..Continuation::default()
    };
    let other = |name: &str| {
        let text = text.replace("# penetration", "penetration");
        text.replace("\"interior-point\"", &format!("\"{name}\""))
    };
    let slack = by_ipopt(PenalizedSlack::with(continuation), None);
    twins("(37)", &other("penalized-slack"), scene(), slack);
    let penalty = by_ipopt(Penalty::with(continuation), None);
    twins("(39)", &other("penalty"), scene(), penalty);
}

/// The parts of a summary that do not tell times, memory or the machine.
fn results(path: &Path) -> BTreeMap<String, Value> {
    let text = fs::read_to_string(path.join("summary.json")).expect("a summary");
    let machine = [
        "started",
        "process",
        "wall_seconds",
        "cpu_seconds",
        "seconds",
        "memory",
        "peak_memory_bytes",
    ];
    let mut summary: BTreeMap<String, Value> = serde_json::from_str(&text).expect("JSON");
    for key in machine {
        assert!(summary.remove(key).is_some(), "{key}");
    }
    summary
}

/// A run of a file records what the example records: the same keys and the same values.
#[test]
fn summaries_are_those_of_the_examples() {
    let folder = fresh("summary");
    let path = folder.join("scene.toml");
    fs::write(&path, coarse_discs()).expect("written");
    let (of_file, by_hand) = (folder.join("of_file"), folder.join("by_hand"));
    let (code, text) = program(&["run", "--out"], &[&of_file, &path]);
    assert_eq!(code, Some(0), "{text}");
    let scene = disc_in_disc::scene(Fineness::scaled(16), Roles::default()).expect("a scene");
    let mut problem = scene.problem().expect("sound");
    let mut simulation = automatic(8);
    let mut recording = simulation.record(&by_hand);
    recording.plan.name = "disc_in_disc".into();
    recording.plan.quiet = true;
    let recording = recording.force(|record| record.reaction(Roles::default().ring())[1]);
    recording.run(&mut problem).expect("a run");
    let (ours, theirs) = (results(&of_file), results(&by_hand));
    assert!(ours.keys().eq(theirs.keys()));
    assert!(ours.len() > 30 && ours["reaction"].as_f64().expect("a force") > 100.0);
    for (key, value) in &theirs {
        assert_eq!(&ours[key], value, "{key}");
    }
    assert!(of_file.join("disc_in_disc.pvd").exists());
}

/// The generators and what is done to their meshes, against the library's own.
#[test]
fn meshes_of_files_are_the_generators() {
    use ipopt_contact::contact_fem::mesh::generators as make;
    let parse = |text: &str| {
        let text = format!(
            "[[body]]\nname = \"a\"\nlaw = \"neo-hookean\"\nyoung = 1\npoisson = 0\nsupports = [{{ on = \"held\", x = 0 }}]\n{text}"
        );
        SceneFile::parse(&text, root().join("examples")).expect("a file")
    };
    fn same<const D: usize>(file: &SceneFile, mesh: &Mesh<D>)
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        assert_eq!(file.dimension().expect("a dimension"), D);
        let scene = file.scene::<D>().expect("a scene");
        let ours = scene.bodies()[0].mesh();
        assert_eq!(ours.nodes(), mesh.nodes());
        assert!(ours.cells().eq(mesh.cells()));
        assert!(scene.bodies()[0].prescribed().iter().any(Option::is_some));
    }
    let held = |of: &str| format!("boundaries = {{ held = [\"{of}\"] }}\n");
    let rising = Diagonals::Rising;
    let plane = |of: &str, mesh: &str, expected: Mesh<2>| {
        same(
            &parse(&format!("{}mesh = {{ {mesh} }}", held(of))),
            &expected,
        );
    };
    plane(
        "boundary",
        "equilateral-disc = { radius = 2, rings = 3 }",
        make::equilateral_disc(2.0, 3).expect("a mesh"),
    );
    let angles = linspace(std::f64::consts::PI, std::f64::consts::TAU, 6);
    let half = make::half_disc(&[0.0, 0.5, 1.0], &angles, rising).expect("a mesh");
    let keys = format!("half-disc = {{ radii = [0, 0.5, 1], angles = {angles:?} }}");
    plane("flat", &keys, half);
    let space = |of: &str, mesh: &str, expected: Mesh<3>| {
        same(
            &parse(&format!("{}mesh = {{ {mesh} }}", held(of))),
            &expected,
        );
    };
    space(
        "surface",
        "sphere = { radius = 2, shells = 2 }",
        make::sphere(2.0, 2).expect("a mesh"),
    );
    space(
        "flat",
        "hemisphere = { radius = 2, shells = 2 }",
        make::hemisphere(2.0, 2).expect("a mesh"),
    );
    space(
        "surface",
        "eighth-sphere = { radius = 2, shells = 2 }",
        make::eighth_sphere(2.0, 2).expect("a mesh"),
    );
    let graded = make::graded(0.0, 2.0, 0.1, 4).expect("a grid");
    let expected = make::cuboid_graded(&graded, &[0.0, 1.0], &[0.0, 1.0]).expect("a mesh");
    let keys = "cuboid-graded = { x = { from = 0, to = 2, count = 4, first = 0.1 }, y = [0, 1], z = [0, 1] }";
    space("left", keys, expected);
    let ring = annulus(&[1.0, 2.0], 8, rising).expect("a mesh");
    let tube = make::extrude(&ring, &[0.0, 1.0], ["low", "high"]).expect("a mesh");
    let keys = "extrude = { plane = { annulus = { radii = [1, 2], segments = 8 } }, z = [0, 1], caps = [\"low\", \"high\"] }";
    space("low", keys, tube);

    // quadratic, on the true cylinder, moved, with a boundary on a plane and one in a box
    let rod = make::cylinder(1.0, 2.0, 2, 2).expect("a mesh");
    let side = rod.boundary_names().find(|name| {
        let facets = rod.boundary(name).expect("a boundary");
        facets.iter().all(|facet| {
            facet
                .iter()
                .all(|&a| (rod.nodes()[a].xy().norm() - 1.0).abs() < 1e-12)
        })
    });
    let side = side.expect("a side").to_string();
    let text = format!(
        "mesh = {{ cylinder = {{ radius = 1, height = 2, rings = 2, layers = 2 }} }}\nquadratic = true\n\
         curved = [{{ on = \"{side}\", radius = 1, axis = [0, 0, 2] }}]\ntranslated = [1, 2, 3]\n\
         boundaries = {{ held = {{ plane = {{ point = [0, 0, 5], normal = [0, 0, 1] }} }}, \
         part = {{ box = {{ low = [0, 1, 3], high = [2, 3, 4] }} }} }}"
    );
    let low = rod.bounding_box().0[2];
    let text = text.replace("[0, 0, 5]", &format!("[0, 0, {:?}]", low + 3.0));
    let mesh = rod
        .quadratic()
        .curved(&side, make::onto_cylinder(1.0))
        .expect("curved");
    let mesh = mesh.translated([1.0, 2.0, 3.0]).expect("moved");
    let file = parse(&text);
    let scene = file.scene::<3>().expect("a scene");
    let ours = scene.bodies()[0].mesh();
    let off = ours
        .nodes()
        .iter()
        .zip(mesh.nodes())
        .map(|(a, b)| (a - b).amax());
    assert!(off.fold(0.0, f64::max) < 1e-15);
    let held = ours.boundary_nodes("held").expect("a boundary");
    assert!(
        held.len() > 6
            && held
                .iter()
                .all(|&a| (mesh.nodes()[a][2] - low - 3.0).abs() < 1e-12)
    );
    assert!(file.is_curved::<3>().expect("curved"));
}

/// An obstacle from a file of triangles, a mesh and a polygon.
#[test]
fn surfaces_of_obstacles() {
    let folder = fresh("surfaces");
    let cube = cuboid([-1.0, -1.0, -0.5], [2.0, 2.0, 0.5], [2, 2, 1]).expect("a mesh");
    let mut stl = "solid tool\n".to_string();
    for facet in cube.exterior() {
        stl += "facet normal 0 0 0\nouter loop\n";
        for &a in facet {
            let x = cube.nodes()[a];
            stl += &format!("vertex {} {} {}\n", x[0], x[1], x[2]);
        }
        stl += "endloop\nendfacet\n";
    }
    fs::write(folder.join("tool.stl"), stl + "endsolid\n").expect("written");
    let scene = |shape: &str, moved: &str| {
        format!(
            "[[body]]\nname = \"block\"\nmesh = {{ cuboid = {{ low = [-0.5, -0.5, 0], size = [1, 1, 1], divisions = [2, 2, 2] }} }}\n\
             law = \"linear-elastic\"\nyoung = 100\npoisson = 0\nsupports = [{{ on = \"top\", x = 0, y = 0, z = {moved} }}]\n\
             [[obstacle]]\nname = \"tool\"\n{shape}\non = [[\"block\", \"bottom\"]]\n"
        )
    };
    let energy = |text: &str| -> Result<f64, String> {
        let file = SceneFile::parse(text, &folder).map_err(|why| why.to_string())?;
        let scene = file.scene::<3>().map_err(|why| why.to_string())?;
        let mut problem = scene.problem().map_err(|why| why.to_string())?;
        let run = file.simulation().expect("settings").run(&mut problem);
        let run = run.map_err(|why| why.to_string())?;
        Ok(run.last().expect("a step").energy)
    };
    // ½·100·0.1², on an area of 1
    for shape in [
        "surface = \"tool.stl\"",
        "surface = { cuboid = { low = [-1, -1, -0.5], size = [2, 2, 0.5], divisions = [2, 2, 1] } }",
    ] {
        let energy = energy(&scene(shape, "-0.1")).expect("a run");
        assert!((energy - 0.5).abs() < 1e-9, "{shape}: {energy}");
    }
    // the tool rises by as much
    let rising = "surface = \"tool.stl\"\nmotion = [{ translation = [0, 0, 0.1] }]";
    let energy_of = energy(&scene(rising, "0")).expect("a run");
    assert!((energy_of - 0.5).abs() < 1e-9, "{energy_of}");
    for (shape, told) in [
        ("polygon = [[0, 0], [1, 0], [0, 1]]", "in the plane"),
        (
            "surface = { disc = { radius = 1, segments = 8, rings = 1 } }",
            "3 dimensions",
        ),
        ("surface = \"none.stl\"", "none.stl"),
    ] {
        let why = energy(&scene(shape, "-0.1")).expect_err("refused");
        assert!(
            why.contains("obstacle tool, line 10") && why.contains(told),
            "{why}"
        );
    }
    let whole = fs::read_to_string(folder.join("tool.stl")).expect("a file");
    let open = whole.replacen("facet normal", "solid", 1);
    let open = open.split_once("endfacet\n").expect("a facet").1;
    fs::write(folder.join("tool.stl"), format!("solid\n{open}")).expect("written");
    let why = energy(&scene("surface = \"tool.stl\"", "-0.1")).expect_err("open");
    assert!(
        why.contains("obstacle tool, line 10, `surface`") && why.contains("is open"),
        "{why}"
    );

    let plane = |corners: &str| {
        let text = format!(
            "[[body]]\nname = \"block\"\nmesh = {{ rectangle = {{ x = [0, 1, 2], y = [0, 1] }} }}\nlaw = \"linear-elastic\"\n\
             young = 100\npoisson = 0\nsupports = [{{ on = \"top\", x = 0, y = -0.1 }}]\n\
             [[obstacle]]\nname = \"tool\"\npolygon = {corners}\non = [[\"block\", \"bottom\"]]\n"
        );
        let file = SceneFile::parse(&text, &folder).expect("a file");
        let scene = file.scene::<2>().map_err(|why| why.to_string())?;
        let run = file
            .simulation()
            .expect("settings")
            .run(&mut scene.problem().expect("sound"));
        Ok::<_, String>(run.expect("a run").last().expect("a step").energy)
    };
    let energy = plane("[[-1, -1], [3, -1], [3, 0], [-1, 0]]").expect("a run");
    assert!((energy - 1.0).abs() < 1e-9, "{energy}");
    let why = plane("[[-1, 0], [3, 0], [3, -1], [-1, -1]]").expect_err("turned");
    assert!(why.contains("inside out"), "{why}");
}
