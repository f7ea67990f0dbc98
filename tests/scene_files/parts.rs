//! What scene files state of bodies, loads and programs, against the same scenes in Rust and by hand.

use std::fs;
use std::path::Path;

use ipopt_contact::prelude::*;
use ipopt_contact::scene_file::SceneFile;

use super::{TWO_BODIES, fresh, program, results, written_bodies};

/// Press, then slide and turn, from a file and by hand: the same states to the last bit.
/// A cuboid of weight 1 on a cylinder, and the same pulled up into a bore: either carries the weight.
#[test]
fn cylinders_from_a_file() {
    let folder = fresh("cylinders");
    let text = r#"
        increments = 1

        [[body]]
        name = "block"
        mesh = "block.mesh"
        law = "linear-elastic"
        young = 100
        poisson = 0.3
        supports = [{ on = "left", x = 0 }, { on = "front", y = 0 }]
        body-force = [0, 0, -1]

        [[obstacle]]
        name = "roll"
        cylinder = { point = [0.5, 7, -1], axis = [0, 3, 0], radius = 1 }
        on = [["block", "bottom"]]

        [[obstacle]]
        name = "pipe"
        bore = { point = [0.5, 0, -2], axis = [0, 1, 0], radius = 3.05 }
        on = [["block", "top"]]
    "#;
    let mesh = cuboid([0.0; 3], [1.0; 3], [4, 2, 2]).expect("a mesh");
    let path = folder.join("scene.toml");
    mesh.save_freefem(folder.join("block.mesh"))
        .expect("written");
    let labels: Vec<&str> = mesh.boundary_names().collect();
    let label = |name: &str| 1 + labels.iter().position(|l| *l == name).expect("a name");
    let text = ["left", "front", "bottom", "top"]
        .iter()
        .fold(text.to_string(), |text, name| {
            text.replace(&format!("\"{name}\""), &label(name).to_string())
        });
    for (weight, expected) in [(-1.0, [-1.0, 0.0]), (1.0, [0.0, 1.0])] {
        let text = text.replace("[0, 0, -1]", &format!("[0, 0, {weight}]"));
        fs::write(&path, text).expect("written");
        let file = SceneFile::read(&path).expect("a file");
        let mut problem = file
            .scene::<3>()
            .expect("a scene")
            .problem()
            .expect("sound");
        let run = file.simulation().expect("settings").run(&mut problem);
        let run = run.expect("a run");
        assert!(run.is_complete(), "{}", run.run.ending);
        let last = run.last().expect("a step");
        for (force, expected) in last.obstacle_forces.iter().zip(expected) {
            assert!((force[2] - expected).abs() < 1e-9, "{force} {expected}");
        }
    }
}

/// Averaged changes of volume make linear cells softer; quadratic ones and a law without a part of the volume alone are refused.
#[test]
fn averaged_volumes_from_a_file() {
    let folder = fresh("averaged");
    let linear = TWO_BODIES.replace("quadratic = true\n", "");
    let averaged = TWO_BODIES.replace("quadratic = true", "averaged-volumes = true");
    let energy = |text: &str| -> Result<f64, String> {
        let path = written_bodies(&folder, text);
        let file = SceneFile::read(&path).map_err(|why| why.to_string())?;
        let scene = file.scene::<2>().map_err(|why| why.to_string())?;
        let mut problem = scene.problem().map_err(|why| why.to_string())?;
        let mut simulation = file.simulation().map_err(|why| why.to_string())?;
        let history = simulation.run(&mut problem).expect("a run");
        Ok(history.last().expect("a step").energy)
    };
    let [plain, averaged] = [linear, averaged.clone()].map(|text| energy(&text).expect("a run"));
    assert!(
        averaged < plain && averaged > 0.8 * plain,
        "{averaged} {plain}"
    );
    let both = TWO_BODIES.replace(
        "quadratic = true",
        "quadratic = true\naveraged-volumes = true",
    );
    let refused = energy(&both).expect_err("quadratic");
    assert!(
        refused.contains("body lower") && refused.contains("quadratic"),
        "{refused}"
    );
    let other = both
        .replace("quadratic = true\n", "")
        .replace("linear-elastic", "st-venant-kirchhoff");
    let refused = energy(&other).expect_err("a law without that part");
    assert!(refused.contains("averaged-volumes"), "{refused}");
}

/// Two layers of a file's mesh in series, as a plate in plane strain and as a sheet; and the same strip of Ogden's law, whose one term
/// is the neo-Hookean law. Constants that a law lacks or does not have are named.
#[test]
fn laws_from_a_file() {
    let folder = fresh("laws");
    // two squares side by side, of regions 7 and 3
    let mesh = "6 4 6  0 0 0  1 0 0  2 0 0  2 1 0  1 1 0  0 1 0  1 2 5 7  1 5 6 7  2 3 4 3  2 4 5 3 \
                1 2 1  2 3 1  3 4 2  4 5 3  5 6 3  6 1 4";
    fs::write(folder.join("strip.msh"), mesh).expect("written");
    let text = r#"
        increments = 1

        [[body]]
        name = "strip"
        mesh = "strip.msh"
        law = "linear-elastic"
        plane-stress = true
        laws = [
            { region = 3, young = 300, poisson = 0.3 },
            { region = 7, young = 100, poisson = 0.3 },
        ]
        symmetry = [1, 3, 4]
        tractions = [{ on = 2, force = [0.5, 0] }]
    "#;
    let energy = |text: &str| -> Result<f64, String> {
        let file = SceneFile::parse(text, &folder).map_err(|why| why.to_string())?;
        let scene = file.scene::<2>().map_err(|why| why.to_string())?;
        let mut problem = scene.problem().map_err(|why| why.to_string())?;
        let mut simulation = file.simulation().map_err(|why| why.to_string())?;
        let history = simulation.run(&mut problem).expect("a run");
        Ok(history.last().expect("a step").energy)
    };
    // held across: E/(1 − ν²) of a sheet, E (1 − ν)/((1 + ν)(1 − 2ν)) of a plate
    let stored = |of_one: f64| -0.5 * 0.5 * 0.5 * (1.0 / 100.0 + 1.0 / 300.0) / of_one;
    let sheet = energy(text).expect("a run");
    assert!((sheet / stored(1.0 / 0.91) - 1.0).abs() < 1e-10, "{sheet}");
    let plate = energy(&text.replace("plane-stress = true", "")).expect("a run");
    assert!(
        (plate / stored(0.7 / (1.3 * 0.4)) - 1.0).abs() < 1e-10,
        "{plate}"
    );

    let of_one = |law: &str| {
        let start = text.find("law =").expect("a law");
        let end = text.find("symmetry").expect("planes");
        format!("{}{law}\n{}", &text[..start], &text[end..])
            .replace("strip.msh\"", "strip.msh\"\nregion = 7")
            .replace("on = 2", "on = 3")
            .replace("[1, 3, 4]", "[1, 4]")
    };
    let twins = [
        "law = \"ogden\"\nterms = [[100, 2]]\npoisson = 0.25",
        "law = \"neo-hookean\"\nyoung = 250\npoisson = 0.25",
    ];
    let [ogden, neo_hookean] = twins.map(|law| energy(&of_one(law)).expect("a run"));
    assert!(
        (ogden / neo_hookean - 1.0).abs() < 1e-9,
        "{ogden} {neo_hookean}"
    );

    for (law, named) in [
        ("law = \"neo-hookean\"\npoisson = 0.3", "needs `young`"),
        ("law = \"ogden\"\npoisson = 0.3", "needs `terms`"),
        (
            "law = \"ogden\"\nterms = [[1, 2]]\nyoung = 2\npoisson = 0.3",
            "`young` is of laws other",
        ),
        (
            "law = \"neo-hookean\"\nyoung = 2\npoisson = 0.3\nterms = [[1, 2]]",
            "`terms` is of the law ogden",
        ),
        (
            "law = \"neo-hookean\"\nyoung = 2\npoisson = 0.3\nshare = 1",
            "`share` is of the law mooney",
        ),
        (
            "law = \"ogden\"\nterms = [[-1, 2]]\npoisson = 0.3",
            "shear modulus",
        ),
        (
            "law = \"neo-hookean\"\nlaws = [{ region = 7, young = 1, poisson = 0 }]",
            "leave `region` out",
        ),
    ] {
        let refused = energy(&of_one(law)).expect_err(law);
        assert!(refused.contains(named), "{law}: {refused}");
    }
    for (sound, wrong, named) in [
        ("region = 3", "region = 4", "no region is called `4`"),
        (
            "{ region = 3, young = 300, poisson = 0.3 },",
            "",
            "in none of the regions",
        ),
        ("laws = [", "young = 1\nlaws = [", "constants of its own"),
        (
            "laws = [",
            "averaged-volumes = true\nlaws = [",
            "`averaged-volumes` is not for `plane-stress`",
        ),
    ] {
        let refused = energy(&text.replace(sound, wrong)).expect_err(wrong);
        assert!(refused.contains(named), "{wrong}: {refused}");
    }
}

/// A tube of two layers of one law under a pressure inside is Lamé's; what does not go with `revolution` is named.
#[test]
fn bodies_of_revolution_from_a_file() {
    let folder = fresh("revolution");
    // two squares side by side, of regions 7 and 3, between the radii 1 and 3
    let mesh = "6 4 6  1 0 0  2 0 0  3 0 0  3 1 0  2 1 0  1 1 0  1 2 5 7  1 5 6 7  2 3 4 3  2 4 5 3 \
                1 2 1  2 3 1  3 4 2  4 5 3  5 6 3  6 1 4";
    fs::write(folder.join("strip.msh"), mesh).expect("written");
    let text = r#"
        [[body]]
        name = "tube"
        mesh = { rectangle = { x = { from = 1, to = 3, count = 20 }, y = [0, 0.2] } }
        quadratic = true
        revolution = true
        law = "linear-elastic"
        young = 100
        poisson = 0.25
        symmetry = ["bottom", "top"]
        pressures = [{ on = "left", pressure = 2 }]
    "#;
    let energy = |text: &str| -> Result<f64, String> {
        let file = SceneFile::parse(text, &folder).map_err(|why| why.to_string())?;
        let scene = file.scene::<2>().map_err(|why| why.to_string())?;
        let mut problem = scene.problem().map_err(|why| why.to_string())?;
        let mut simulation = file.simulation().map_err(|why| why.to_string())?;
        let history = simulation.run(&mut problem).expect("a run");
        Ok(history.last().expect("a step").stored_energy)
    };
    // ½ p 2πa h u(a), u(a) = (1 + ν)/E p a²/(b² − a²) ((1 − 2ν) a + b²/a)
    let lame = 0.5 * 2.0 * std::f64::consts::TAU * 0.2 * (1.25 / 100.0 * 2.0 / 8.0 * (0.5 + 9.0));
    let stored = energy(text).expect("a run");
    assert!((stored / lame - 1.0).abs() < 1e-5, "{stored} {lame}");

    let laws = text
        .replace(
            "{ rectangle = { x = { from = 1, to = 3, count = 20 }, y = [0, 0.2] } }",
            "\"strip.msh\"",
        )
        .replace("young = 100\n        poisson = 0.25", "laws = [{ region = 3, young = 100, poisson = 0.25 }, { region = 7, young = 100, poisson = 0.25 }]")
        .replace("[\"bottom\", \"top\"]", "[1, 3]")
        .replace("on = \"left\"", "on = 4");
    let coarse = energy(&laws).expect("a run");
    assert!((coarse / (5.0 * lame) - 1.0).abs() < 0.02, "{coarse}");

    for (sound, wrong, named) in [
        ("from = 1, to = 3", "from = -1, to = 3", "has the radius -1"),
        (
            "revolution = true",
            "revolution = true\nplane-stress = true",
            "no sheet",
        ),
        (
            "quadratic = true",
            "averaged-volumes = true",
            "`averaged-volumes` is not for `revolution`",
        ),
    ] {
        let refused = energy(&text.replace(sound, wrong)).expect_err(wrong);
        assert!(refused.contains(named), "{wrong}: {refused}");
    }
    let both = format!(
        "{text}\n[[body]]\nname = \"sheet\"\nmesh = {{ rectangle = {{ x = [5, 6], y = [0, 1] }} }}\nlaw = \
         \"linear-elastic\"\nyoung = 1\npoisson = 0\nsymmetry = [\"bottom\", \"left\"]"
    );
    let refused = energy(&both).expect_err("both kinds");
    assert!(
        refused.contains("`tube` is one of revolution, and body `sheet`"),
        "{refused}"
    );
    let solid = text.replace(
        "rectangle = { x = { from = 1, to = 3, count = 20 }, y = [0, 0.2] }",
        "cuboid = { low = [0, 0, 0], size = [1, 1, 1], divisions = [1, 1, 1] }",
    );
    let file = SceneFile::parse(&solid, &folder).expect("read");
    let refused = file
        .scene::<3>()
        .map(|_| ())
        .expect_err("a body of space")
        .to_string();
    assert!(refused.contains("meshes of the half-plane"), "{refused}");
}

/// Pressures and foundations of a file are those of the body; errors name their keys and entries.
#[test]
fn pressures_and_foundations_from_a_file() {
    let folder = fresh("boundaries");
    let text = r#"
        increments = 2

        [[body]]
        name = "upper"
        mesh = "upper.msh"
        law = "neo-hookean"
        young = 100
        poisson = 0.3
        symmetry = [2, 3]
        pressures = [{ on = 4, pressure = 4, amplitude = [[0, 0], [1, 2]] }]
        foundations = [{ on = 1, stiffness = 50, normal-only = true }]

        [[obstacle]]
        name = "tool"
        cuboid = { low = [-2, -9], high = [4, -8] }
        on = [["upper", 1]]
        during = [[0, 1]]
    "#;
    let path = written_bodies(&folder, text);
    let scene = |text: &str| SceneFile::parse(text, &folder).map(|file| file.scene::<2>());
    let file = SceneFile::read(&path).expect("a file");
    let mut problem = file
        .scene::<2>()
        .expect("a scene")
        .problem()
        .expect("sound");
    let history = file.simulation().expect("settings").run(&mut problem);
    let history = history.expect("a run");
    let last = history.last().expect("a step");
    // a pressure of 8 on all of its width
    let mesh = MeshFile::read(folder.join("upper.msh")).expect("a mesh");
    let mesh = mesh.bodies::<2>().expect("bodies").remove(0).1;
    let (low, high) = mesh.bounding_box();
    let carried = last
        .support_reactions
        .iter()
        .find(|(side, _)| side.boundary == "1");
    let carried = carried.expect("a foundation").1[1];
    assert!(
        (carried / (8.0 * (high[0] - low[0])) - 1.0).abs() < 1e-6,
        "{carried}"
    );
    for (good, bad, told) in [
        (
            "stiffness = 50",
            "stiffness = -50",
            "`foundations.stiffness`",
        ),
        ("stiffness = 50", "stifness = 50", "stifness"),
        (
            "pressure = 4",
            "pressure = nan",
            "`body.pressures.pressure`",
        ),
        ("on = 4", "on = 9", "`pressures`"),
        ("during = [[0, 1]]", "during = [[2, 1]]", "`during`"),
        ("during = [[0, 1]]", "during = [[0, 1], [3, 2]]", "`during`"),
    ] {
        let refused = match scene(&text.replace(good, bad)) {
            Ok(scene) => scene.err().map(|error| error.to_string()),
            Err(error) => Some(error.to_string()),
        };
        assert!(
            refused.as_ref().is_some_and(|e| e.contains(told)),
            "{refused:?} of {told}"
        );
    }
}

/// Supports of a file along a direction are those of the body; errors name their keys and entries.
#[test]
fn slopes_from_a_file() {
    let folder = fresh("slopes");
    let text = r#"
        increments = 1

        [[body]]
        name = "upper"
        mesh = "upper.msh"
        law = "linear-elastic"
        young = 100
        poisson = 0.3
        supports = [{ on = 1, along = [3, 4], by = 0.1, amplitude = 0.5 }, { on = 2, along = [4, -3] }]
        body-force = [0, -1]
    "#;
    let path = written_bodies(&folder, text);
    let file = SceneFile::read(&path).expect("a file");
    let scene = file.scene::<2>().expect("a scene");
    let mut problem = scene.problem().expect("sound");
    let history = file.simulation().expect("settings").run(&mut problem);
    let history = history.expect("a run");
    let moved = problem.displacements(&history.run.state.u);
    let mesh = problem.scene().bodies()[0].mesh();
    for node in mesh.boundary_nodes("1").expect("a side") {
        assert!((0.6 * moved[node][0] + 0.8 * moved[node][1] - 0.05).abs() < 1e-15);
    }
    let last = history.last().expect("a step");
    let (below, beside) = (last.support_reactions[0].1, last.support_reactions[1].1);
    assert!((0.8 * below[0] - 0.6 * below[1]).abs() < 1e-9, "{below}");
    assert!((0.6 * beside[0] + 0.8 * beside[1]).abs() < 1e-9, "{beside}");
    for (good, bad, told) in [
        ("along = [3, 4]", "along = [3, 4, 5]", "`supports.along`"),
        ("along = [3, 4]", "along = [0, 0]", "the length of `along`"),
        ("along = [3, 4]", "y = 1", "`by` without `along`"),
        (
            "along = [3, 4]",
            "y = 1, along = [3, 4]",
            "has components and `along`",
        ),
        ("on = 1, along", "along", "name its nodes"),
        (
            "along = [4, -3]",
            "along = [4, -3], during = [[0, 1]]",
            "along axes alone",
        ),
    ] {
        let scene = SceneFile::parse(&text.replace(good, bad), &folder).map(|f| f.scene::<2>());
        let refused = scene.expect("keys").err().expect(bad).to_string();
        assert!(refused.contains(told), "{refused} of {told}");
    }
}

/// One linear facet hands half of a traction to each of its nodes; a list of one may be without a list around it.
#[test]
fn forces_and_single_entries_from_a_file() {
    let folder = fresh("forces");
    let scene = |loads: &str, during: &str, motion: &str| {
        let text = format!(
            r#"
            [[body]]
            name = "block"
            mesh = {{ rectangle = {{ x = [0, 1], y = [0, 1] }} }}
            law = "linear-elastic"
            young = 100
            poisson = 0.3
            supports = [{{ on = "bottom", x = 0, y = 0, during = {during} }}]
            {loads}

            [[obstacle]]
            name = "tool"
            half-space = {{ point = [0, 1.5], normal = [0, -1] }}
            motion = {motion}
            on = [["block", "top"]]
            "#
        );
        let file = SceneFile::parse(&text, &folder).expect("a file");
        let mut problem = file.problem::<2>().expect("a problem");
        let history = file.simulation().expect("settings").run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete());
        history.run.state.u
    };
    let down = "{ translation = [0, -0.1] }";
    let by_traction = "tractions = [{ on = \"top\", force = [0.5, 3] }]";
    let by_nodes = "forces = [{ at = [[0, 1], [1, 1]], force = [0.25, 1.5] }]";
    let expected = scene(by_traction, "[[0, 1]]", &format!("[{down}]"));
    let found = scene(by_nodes, "[0, 1]", down);
    let largest = expected.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    assert!(largest > 0.01, "{largest}");
    for (u, other) in expected.iter().zip(&found) {
        assert!((u - other).abs() < 1e-12 * largest, "{u} {other}");
    }
}

/// What supports of nodes do in time is what those of a boundary with the same nodes do, and so it is with those of whole bodies.
#[test]
fn supports_of_nodes_in_time() {
    let folder = fresh("nodes");
    let scene = |supports: &str| {
        let text = format!(
            r#"
            phase = [{{ name = "press", until = 1, increments = 2 }}, {{ name = "slide", until = 2, increments = 2 }}]

            [[body]]
            name = "block"
            mesh = {{ rectangle = {{ x = [0, 1, 2], y = [0, 1] }} }}
            boundaries = {{ skin = ["bottom", "right", "top", "left"] }}
            law = "neo-hookean"
            young = 100
            poisson = 0.3
            supports = [{supports}]

            [[body]]
            name = "bar"
            mesh = {{ rectangle = {{ x = [0, 1, 2], y = [3, 4] }} }}
            law = "neo-hookean"
            young = 100
            poisson = 0.3
            supports = [{{ on = "bottom", x = 0, y = 0 }}]
            "#
        );
        let file = SceneFile::parse(&text, &folder).expect("a file");
        let mut problem = file.problem::<2>().expect("a problem");
        let history = file.simulation().expect("settings").run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete());
        let last = history.last().expect("a step");
        // of the block, of which one support is on the bottom where it is not on all nodes
        let own = last.support_reactions.iter();
        let own = own.filter(|(side, _)| side.body.index() == 0);
        let own: Vec<_> = own
            .map(|(side, force)| (side.boundary.clone(), *force))
            .collect();
        let u = problem.displacements(&history.run.state.u);
        (u, own)
    };
    let press = "amplitude = [[0, 0], [1, 1]]";
    let slide = "amplitude = [[1, 0], [2, 1]]";
    let moved = format!(
        "motion = [{{ translation = [0, -0.1], {press} }}, {{ rotation = 0.2, centre = [1, 1], {slide} }}]"
    );
    let components = format!("y = -0.1, {press} }}, {{ PLACE, x = 0.2, {slide}");
    let along = format!("along = [1, 2], by = -0.1, {press}");
    let at_top = "at = [[2, 1], [0, 1], [1, 1]]";
    let bottom = "{ on = \"bottom\", x = 0, y = 0 }, ";
    let cases = [
        (bottom, "on = \"top\"", at_top, &moved, "nodes 3, 4, 5"),
        (bottom, "on = \"top\"", at_top, &components, "nodes 3, 4, 5"),
        (bottom, "on = \"top\"", at_top, &along, "nodes 3, 4, 5"),
        ("", "on = \"skin\"", "", &components, "all nodes"),
    ];
    for (others, on, nodes, what, name) in cases {
        let [expected, found] = [on, nodes].map(|place| {
            let support = format!("{{ {place}, {what} }}").replace("PLACE", place);
            scene(&format!("{others}{}", support.replace("{ , ", "{ ")))
        });
        let largest = expected.0.iter().map(|u| u.norm()).fold(0.0, f64::max);
        assert!(largest > 0.09, "{largest}");
        for (u, other) in expected.0.iter().zip(&found.0) {
            assert!((u - other).norm() < 1e-12, "{what}: {u} {other}");
        }
        let ([.., of_boundary], [.., of_nodes]) = (&expected.1[..], &found.1[..]) else {
            panic!("no support");
        };
        assert_eq!(of_nodes.0, name);
        assert!((of_boundary.1 - of_nodes.1).norm() < 1e-9, "{what}");
    }
}

/// A block on two nodes: each has its reaction, by the law of the lever.
#[test]
fn each_support_of_nodes_has_its_reaction() {
    let folder = fresh("lever");
    let path = folder.join("scene.toml");
    let text = r#"
        [[body]]
        name = "block"
        mesh = { rectangle = { x = [0, 0.5, 2], y = [0, 1] } }
        law = "linear-elastic"
        young = 100
        poisson = 0.3
        supports = [{ at = [[0, 0]], x = 0, y = 0 }, { at = [[2, 0]], y = 0 }]
        forces = [{ at = [[0.5, 1]], force = [0, -4] }]
    "#;
    fs::write(&path, text).expect("written");
    let out = folder.join("out");
    let (code, told) = program(&["run", "--out"], &[&out, &path]);
    assert_eq!(code, Some(0), "{told}");
    let table = fs::read_to_string(out.join("out_supports.csv")).expect("a table");
    for (name, force) in [("node 0", 3.0), ("node 2", 1.0)] {
        let mut lines = table
            .lines()
            .map(|line| line.split(',').collect::<Vec<_>>());
        let line = lines.find(|line| line.contains(&name)).expect(name);
        let found: f64 = line[line.len() - 1].parse().expect("a number");
        assert!((found - force).abs() < 1e-10, "{name}: {found}");
    }
    // errors name the line of the one that is contradicted
    let text = text.replace(
        "{ at = [[2, 0]], y = 0 }]",
        "\n{ at = [[2, 0]], y = 0 },\n{ at = [[2, 0]], y = 0.1 }]",
    );
    let file = SceneFile::parse(&text, &folder).expect("keys");
    let refused = file.scene::<2>().err().expect("refused").to_string();
    assert!(
        refused.contains("line 10")
            && refused.contains("against line 9")
            && refused.contains("`node 2`"),
        "{refused}"
    );
    // and of what is switched within a phase
    let text = text.replace("y = 0.1 }", "x = 0.1, during = [0, 0.5] }");
    let file = SceneFile::parse(&text, &folder).expect("keys");
    let mut problem = file.problem::<2>().expect("a problem");
    let simulation = file.simulation().expect("settings");
    let refused = file.check(&simulation, &mut problem).expect_err("within");
    let refused = refused.to_string();
    assert!(
        refused.contains("line 10") && refused.contains("`node 2` of body `block`"),
        "{refused}"
    );
}

/// Supports of a file that are switched are those of the body; errors name their keys and entries.
#[test]
fn switched_supports_from_a_file() {
    let folder = fresh("switched");
    let text = r#"
        [[phase]]
        name = "draw"
        until = 1
        increments = 2

        [[phase]]
        name = "let go"
        until = 2
        increments = 2

        [[body]]
        name = "upper"
        mesh = "upper.msh"
        law = "neo-hookean"
        young = 100
        poisson = 0.3
        supports = [{ on = 1, x = 0, y = 0 }, { on = 4, y = 0.2, during = [[0, 1]] }]
    "#;
    let path = written_bodies(&folder, text);
    let file = SceneFile::read(&path).expect("a file");
    let scene = file.scene::<2>().expect("a scene");
    let mut problem = scene.problem().expect("sound");
    let history = file.simulation().expect("settings").run(&mut problem);
    let history = history.expect("a run");
    let [drawn, half, free] = [1, 2, 3].map(|step| history.steps[step].stored_energy);
    assert!(
        0.1 < drawn && 0.2 * drawn < half && half < 0.3 * drawn,
        "{half} of {drawn}"
    );
    assert!(free < 1e-12 * drawn, "{free}");
    for (good, bad, told) in [
        ("[[0, 1]]", "[[1, 0]]", "`supports.during`"),
        ("y = 0.2", "y = nan", "`body.supports.y`"),
        ("on = 4", "on = 9", "`supports.on`"),
    ] {
        let file = SceneFile::parse(&text.replace(good, bad), &folder);
        let scene = file.and_then(|file| file.scene::<2>());
        let refused = scene.err().expect(bad).to_string();
        assert!(refused.contains(told), "{refused} of {told}");
    }
    let text = text.replace("[[0, 1]]", "[[0, 1.5]]");
    let file = SceneFile::parse(&text, &folder).expect("keys");
    let mut problem = file
        .scene::<2>()
        .expect("a scene")
        .problem()
        .expect("sound");
    let refused = file.simulation().expect("settings").run(&mut problem);
    let refused = refused.expect_err("within a phase").to_string();
    let path = folder.join("within.toml");
    fs::write(&path, &text).expect("written");
    let (code, told) = program(&["run", "--check"], &[&path]);
    assert!(code == Some(2) && told.contains("1.5"), "{code:?}: {told}");
    assert!(
        refused.contains("`4` of body `upper`") && refused.contains("1.5"),
        "{refused}"
    );
}

/// Adaptive steps end where amplitudes have corners: a peak between two times is seen, and is that of a single step to it.
#[test]
fn adaptive_steps_end_at_corners_of_amplitudes() {
    let folder = fresh("corners");
    let run = |run: &str, amplitude: &str| {
        let text = format!(
            r#"
            {run}

            [[body]]
            name = "block"
            mesh = {{ rectangle = {{ x = [0, 1, 2], y = [0, 0.5, 1] }} }}
            law = "neo-hookean"
            young = 100
            poisson = 0.3
            supports = [{{ on = "bottom", x = 0, y = 0 }}, {{ on = "top", y = -0.4{amplitude} }}]
            "#
        );
        let file = SceneFile::parse(&text, &folder).expect("a file");
        let mut problem = file.problem::<2>().expect("a problem");
        let history = file.simulation().expect("settings").run(&mut problem);
        let history = history.expect("a run");
        assert!(history.is_complete());
        let steps = history.steps.iter();
        let energies = steps.map(|record| (record.factor, record.stored_energy));
        energies.collect::<Vec<_>>()
    };
    let phase = "phase = [{ name = \"a\", until = 1, increments = 3, least-step = 0.01, largest-step = 0.5 }]";
    let peak = ", amplitude = [[0, 0], [0.4, 0], [0.45, 1], [0.5, 0]]";
    let found = run(phase, peak);
    let at = |time: f64| {
        let mut own = found.iter();
        own.find(|(factor, _)| *factor == time).expect("a step").1
    };
    let [(_, expected)] = run("increments = 1", "")[..] else {
        panic!("one step");
    };
    assert!((at(0.45) / expected - 1.0).abs() < 1e-6, "{found:?}");
    assert!(at(0.4) < 1e-12 && at(0.5) < 1e-6 * expected, "{found:?}");
}

#[test]
fn a_program_from_a_file() {
    let folder = fresh("phases");
    let text = r#"
        [[phase]]
        name = "press"
        until = 1
        increments = 2

        [[phase]]
        name = "slide"
        until = 2
        increments = 4
        least-step = 0.05
        largest-step = 0.5

        [[body]]
        name = "upper"
        mesh = "upper.msh"
        law = "neo-hookean"
        young = 100
        poisson = 0.3
        supports = [
            { on = 4, y = -0.02, amplitude = [[0, 0], [1, 1]] },
            { on = 4, x = 0.3, amplitude = [[1, 0], [2, 1]] },
        ]
        tractions = [{ on = 3, force = [0.1, 0], amplitude = 1 }]
        body-force = [0, -0.2]
        body-force-amplitude = 1

        [[obstacle]]
        name = "tool"
        cuboid = { low = [-2, 0], high = [4, 1] }
        on = [["upper", 1]]
        motion = [
            { translation = [0, 0.01], amplitude = [[0, 0], [1, 1]] },
            { rotation = 0.01, centre = [1, 1], amplitude = [[1, 0], [2, 1]] },
        ]
    "#;
    let path = written_bodies(&folder, text);
    let file = SceneFile::read(&path).expect("a file");
    let mut problem = file
        .scene::<2>()
        .expect("a scene")
        .problem()
        .expect("sound");
    let mut simulation = file.simulation().expect("settings");
    let from_file = simulation.run(&mut problem).expect("a run");
    assert!(from_file.is_complete(), "{}", from_file.run.ending);

    let mesh = MeshFile::read(folder.join("upper.msh")).expect("a mesh");
    let mut bodies = mesh.bodies::<2>().expect("bodies");
    let law = NeoHookean::new(100.0, 0.3).expect("a law");
    let mut upper = Body::new(bodies.remove(0).1, law);
    let [first, then] = [[(0.0, 0.0), (1.0, 1.0)], [(1.0, 0.0), (2.0, 1.0)]]
        .map(|table| Amplitude::table(&table).expect("a table"));
    let held = upper.prescribe_in_time("4", [None, Some(-0.02)], first.clone());
    held.expect("a support");
    let held = upper.prescribe_in_time("4", [Some(0.3), None], then.clone());
    held.expect("a support");
    upper
        .traction_in_time("3", [0.1, 0.0], 1.0)
        .expect("a traction")
        .body_force_in_time([0.0, -0.2], 1.0)
        .expect("a weight");
    let up = Motion::translation([0.0, 0.01]).expect("a motion");
    let turn = Motion::<2>::rotation([1.0, 1.0], 0.01).expect("a motion");
    let motion = up.driven_by(first).then(turn.driven_by(then));
    let tool = Obstacle::cuboid([-2.0, 0.0], [4.0, 1.0]).expect("a tool");
    let mut scene = Scene::new();
    let upper = scene.add("upper", upper);
    let placed = scene.obstacle("tool", upper.on("1"), tool.moving(motion));
    placed.expect("an obstacle");
    let phases = [
        Phase::new("press", 1.0, 2),
        Phase::new("slide", 2.0, 4).adaptive(0.05, 0.5),
    ];
    let mut problem = scene.problem().expect("sound");
    let by_hand = Simulation::in_phases(phases).run(&mut problem);
    let by_hand = by_hand.expect("a run");
    let states = |history: &History<2>| -> Vec<(f64, String, f64)> {
        let steps = history.steps.iter();
        steps
            .map(|s| (s.factor, s.phase().to_string(), s.energy))
            .collect()
    };
    assert_eq!(states(&from_file), states(&by_hand));
    assert_eq!(from_file.run.state.u, by_hand.run.state.u);
    let last = from_file.last().expect("a step");
    assert!(last.factor == 2.0 && last.pairs[0].area > 0.5, "{last:?}");
    // the weight, and what presses
    let tool = last.contact_forces[0][1];
    assert!(tool > 0.2, "{tool}");

    let cases = [
        (
            "cuboid = { low = [-2, 0], high = [4, 1] }",
            "cylinder = { point = [0, 0], axis = [1, 0], radius = 1 }",
            "leave it out in the plane",
        ),
        (
            "name = \"press\"",
            "name = \"press\"\nleast-step = 0.1",
            "largest-step",
        ),
        ("until = 1\n", "until = 3\n", "phase slide, line 9, `until`"),
        (
            "[[phase]]\n        name = \"press\"",
            "increments = 2\n[[phase]]\nname = \"press\"",
            "no effect where there are phases",
        ),
        ("least-step = 0.05", "least-step = 0.6", "`least-step`"),
        (
            "amplitude = [[0, 0], [1, 1]] },\n            { on = 4, x",
            "amplitude = [[1, 0], [1, 1]] },\n            { on = 4, x",
            "ascend",
        ),
        (
            "body-force = [0, -0.2]\n",
            "",
            "no effect without `body-force`",
        ),
        ("centre = [1, 1], ", "", "turns about no point"),
        (
            "rotation = 0.01, centre = [1, 1]",
            "centre = [1, 1]",
            "is a `translation`, or a `rotation`",
        ),
        (
            "centre = [1, 1], ",
            "centre = [1, 1], axis = [0, 0, 1], ",
            "leave it out in the plane",
        ),
        (
            "low = [-2, 0]",
            "low = [-2]",
            "`cuboid.low`: has 1 components and needs 2",
        ),
        (
            "{ on = 4, x = 0.3, amp",
            "{ on = 4, x = 0.3, motion = [{ translation = [1, 0] }], amp",
            "give it one of them",
        ),
        (
            "{ on = 4, x = 0.3, amp",
            "{ on = 4, motion = [{ translation = [1, 0] }], amp",
            "has amplitudes of its own",
        ),
    ];
    for (sound, wrong, named) in cases {
        let text = text.replacen(sound, wrong, 1);
        let file = SceneFile::parse(&text, &folder).expect("TOML");
        let why = match (file.scene::<2>(), file.simulation()) {
            (Err(why), _) | (_, Err(why)) => why.to_string(),
            _ => panic!("{wrong} is taken"),
        };
        assert!(why.contains(named), "{wrong}: {why}");
    }
}

/// Nothing is read without end.
#[cfg(target_os = "linux")]
#[test]
fn a_device_is_no_scene() {
    let folder = fresh("device");
    let zeros = Path::new("/dev/zero");
    let (code, text) = program(&["run", "--out"], &[&folder, zeros]);
    assert_eq!(code, Some(2), "{text}");
    assert!(
        text.contains("/dev/zero") && text.contains("at most"),
        "{text}"
    );
}

#[test]
fn what_files_lack_is_named() {
    let folder = fresh("damaged");
    let out = folder.join("out");
    let cases = [
        ("mesh = \"lower.msh\"", "mesh = \"no.msh\"", "no.msh"),
        ("young = 100", "young = -100", "body lower"),
        ("young = 100", "yuong = 100", "yuong"),
        ("on = 1, x", "on = 9, x", "9"),
        (
            "first = [\"lower\"",
            "first = [\"over\"",
            "there is no body `over`",
        ),
        ("y = 0 }", "y = 0, z = 0 }", "no `z`"),
        ("points = 4", "points = 0", "0"),
        ("points = 4", "solver = \"magic\"", "magic"),
        (
            "points = 4",
            "solver = \"condensed\"\ntolerance = 1e-3",
            "leave it out",
        ),
        ("points = 4", "points = 4\nincrements = 0", "increment"),
        ("points = 4", "departures = [\"units\"]", "departure units"),
        (
            "points = 4",
            "goes-on = true",
            "leave it out, or take literal",
        ),
        (
            "points = 4",
            "solver = \"literal\"\nmax-leaps = 1",
            "from increment to increment: leave it out",
        ),
        ("points = 4", "projection = 3", "expected a word in quotes"),
        (
            "points = 4",
            "max-iterations = 9",
            "leave it out, or take literal",
        ),
        (
            "points = 4",
            "solver = \"literal\"\nmax-iterations = 0",
            "`max-iterations`",
        ),
        (
            "points = 4",
            "solver = \"literal\"\nipopt-tolerance = nan",
            "`ipopt-tolerance`",
        ),
        ("x = 0.02, y = -0.02", "", "holds nothing"),
        ("points = 4", "tolerance = -1e-8", "`tolerance`"),
        (
            "first = [\"lower\", 4]",
            "first = [\"lower\", 4, 3]",
            "a body and one boundary of it",
        ),
        (
            "first = [\"lower\", 4]",
            "first = [4, 4]",
            "a body and one boundary of it",
        ),
        ("name = \"upper\"", "name = \"../upper\"", "no `/`"),
        ("[[contact]]", "[[contact]", "scene.toml"),
        (
            "[[contact]]",
            "[[obstacle]]\nname = \"o\"\non = [[\"lower\", 4]]\n[[contact]]",
            "one shape",
        ),
        (
            "[[contact]]",
            "[[obstacle]]\nname = \"o\"\nball = { centre = [0, 0, 0], radius = 1 }\non = [[\"lower\", 4]]\n[[contact]]",
            "3 components",
        ),
    ];
    for (sound, damaged, told) in cases {
        let text = TWO_BODIES.replacen(sound, damaged, 1);
        assert_ne!(text, TWO_BODIES, "{sound}");
        let path = written_bodies(&folder, &text);
        let (code, text) = program(&["run", "--out"], &[&out, &path]);
        assert_eq!(code, Some(2), "{damaged}: {text}");
        assert!(text.contains(told), "{damaged}: {text}");
        assert!(!out.join("summary.json").exists(), "{damaged}");
    }
    let nowhere = folder.join("nowhere");
    for words in [
        &["run", "--out", "x"][..],
        &["solve", "--out", "x"],
        &["fields", "--out", "x", "--nodes", "y"],
    ] {
        let (code, text) = program(words, &[&nowhere]);
        assert_eq!(code, Some(2), "{text}");
        assert!(!Path::new("x").exists());
    }
    let (code, text) = program(&["solve", "--out"], &[&folder, &folder]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("would be overwritten"), "{text}");
    let (code, text) = program(&["dance"], &[]);
    assert_eq!(code, Some(2), "{text}");
}

/// A plate with a hole, whose facets a file does not name: each way of naming the hole finds the same facets.
#[test]
fn holes_are_named_by_their_shape() {
    let folder = fresh("holes");
    let path = folder.join("scene.toml");
    let ring = r#"
[[body]]
name = "ring"
mesh = { annulus = { radii = [1, 2], segments = 24 } }
law = "linear-elastic"
young = 100
poisson = 0.3
supports = [{ on = "outer", x = 0, y = 0 }]
pressures = [{ on = "hole", pressure = 1 }]
[body.boundaries]
hole = "#;
    let named = |boundary: &str| {
        fs::write(&path, format!("{ring}{boundary}\n")).expect("written");
        let file = SceneFile::read(&path).expect("a file");
        file.scene::<2>().map(|scene| {
            let mesh = scene.bodies()[0].mesh();
            let mut nodes = mesh.boundary_nodes("hole").expect("named");
            nodes.sort_unstable();
            (
                nodes,
                mesh.boundary_nodes("inner").expect("the generator's"),
            )
        })
    };
    for same in [
        "{ ball = { centre = [0, 0], radius = 1 } }",
        "{ cylinder = { point = [0, 0], radius = 1.0000001 } }",
        "{ smooth = { from = [1, 0], angle = 16 } }",
        "{ box = { low = [-1, -1], high = [1, 1] } }",
    ] {
        let (mut hole, mut inner) = named(same).expect(same);
        hole.sort_unstable();
        inner.sort_unstable();
        assert_eq!(hole, inner, "{same}");
    }
    // facets that look inwards at the right of the hole, and outwards at the left
    let (found, _) = named("{ normal = { direction = [-1, 0], within = 8 } }").expect("named");
    assert_eq!(found.len(), 2 * 3);
    for (wrong, why) in [
        ("{ ball = { centre = [0, 0], radius = 1.5 } }", "no facet"),
        (
            "{ cylinder = { point = [0, 0], axis = [0, 0, 1], radius = 1 } }",
            "leave it out",
        ),
        (
            "{ normal = { direction = [0, 0], within = 8 } }",
            "has no length",
        ),
        (
            "{ normal = { direction = [1, 0], within = 190 } }",
            "no angle from 0 to 180",
        ),
        (
            "{ smooth = { from = [1, 0], angle = -1 } }",
            "no angle from 0 to 180",
        ),
    ] {
        let refused = named(wrong).expect_err(wrong).to_string();
        assert!(refused.contains(why), "{wrong}: {refused}");
    }
}

/// Two triangles that were written with corners of their own.
#[test]
fn nodes_that_lie_on_each_other_are_told_and_merged() {
    let folder = fresh("soup");
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    let mesh = "6 2 2  0 0 0  1 0 0  1 1 0  0 0 0  1 1 0  0 1 0  1 2 3 7  4 5 6 7  1 2 1  5 6 2\n";
    fs::write(folder.join("soup.msh"), mesh).expect("written");
    let text = |merge: &str| {
        format!(
            "[[body]]\nname = \"soup\"\nmesh = \"soup.msh\"\n{merge}law = \"linear-elastic\"\nyoung = 100\npoisson = 0\n\
             supports = [{{ on = 1, x = 0, y = 0 }}, {{ on = 2, x = 0 }}]\ntractions = [{{ on = 2, force = [0, -10] }}]\n"
        )
    };
    let run = |merge: &str| {
        fs::write(&path, text(merge)).expect("written");
        program(&["run", "--out"], &[&out, &path])
    };
    let (code, told) = run("");
    assert_eq!(code, Some(2), "{told}");
    assert!(
        told.contains("2 nodes of body `soup` lie on others") && told.contains("merge-nodes"),
        "{told}"
    );
    let (code, told) = run("merge-nodes = 1e-9\n");
    assert_eq!(code, Some(0), "{told}");
    // E = 100 and ν = 0: a tenth
    let force = results(&out)["support_reactions"][0]["force"][1].as_f64();
    assert!((force.expect("a force") - 10.0).abs() < 1e-9, "{force:?}");
    let (code, told) = run("merge-nodes = 1.5\n");
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("`merge-nodes`"), "{told}");
}
