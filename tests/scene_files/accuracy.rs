//! `--accuracy`: the estimate of the last mesh against the error that it has, and how runs end that do not reach it.

use super::*;

/// The levels of a run: unknowns, estimated error and energy.
fn levels(out: &Path) -> Vec<[f64; 3]> {
    let table = fs::read_to_string(out.join("error_against_time.csv")).expect("a table");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| names.iter().position(|own| *own == name).expect("a column");
    let columns = ["unknowns", "estimated_error", "energy"].map(column);
    let level = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        columns.map(|k| values[k].parse().expect("a number"))
    };
    lines.map(level).collect()
}

fn run(name: &str, scene: &str, options: &[&str]) -> (Option<i32>, String, PathBuf) {
    let folder = fresh(name);
    let (file, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&file, scene).expect("written");
    let words = [&["run"], options, &["--out"]].concat();
    let (code, text) = program(&words, &[&out, &file]);
    (code, text, out)
}

/// A column of height 2 and width 1, E = 1000, ν = 0, under the weight 3 a volume: its energy is −(3²·2³)/(6·1000) = −0.012, and the square of its error
/// in the energy norm is twice what the energy is above.
const COLUMN: &str = r#"
increments = 1

[[body]]
name = "column"
mesh = { rectangle = { x = [0, 1], y = [0, 1, 2] } }
law = "linear-elastic"
young = 1000
poisson = 0
supports = [{ on = "bottom", y = 0 }, { on = "left", x = 0 }]
body-force = [0, -3]
"#;

#[test]
fn the_error_is_at_most_what_was_asked_and_not_far_below() {
    let (code, text, out) = run("accuracy_column", COLUMN, &["--accuracy", "4%"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("accuracy 4 % reached"), "{text}");
    let levels = levels(&out);
    for (k, [_, estimated, energy]) in levels.iter().enumerate() {
        let truth = ((energy + 0.012) / 0.012).sqrt();
        // the first mesh has four cells
        let within = if k == 0 { 0.7..1.5 } else { 0.8..1.2 };
        assert!(
            within.contains(&(estimated / truth)),
            "{k}: {estimated} {truth}"
        );
        assert!(out.join(format!("level_{k}/summary.json")).exists());
    }
    let [.., before, last] = levels[..] else {
        panic!("more than one level is needed: {levels:?}");
    };
    assert!(last[1] <= 0.04 && before[1] > 0.04);
    let truth = ((last[2] + 0.012) / 0.012).sqrt();
    assert!((0.04 / 3.0..0.04).contains(&truth), "{truth}");
    let picture = fs::read_to_string(out.join("error_against_time.svg")).expect("a picture");
    assert!(picture.contains("<svg"));
}

/// A half-disc that is pressed on a plane, in cells of either order.
fn half_disc(quadratic: bool) -> String {
    let order = match quadratic {
        true => "quadratic = true\ncurved = [{ on = \"arc\", radius = 1 }]",
        false => "",
    };
    format!(
        r#"
increments = 1

[[body]]
name = "disc"
mesh = {{ half-disc = {{ radii = {{ from = 0, to = 1, count = 4 }}, angles = {{ from = 3.141592653589793, to = 6.283185307179586, count = 12 }} }} }}
{order}
translated = [0.25, 0.5]
law = "linear-elastic"
young = 1000
poisson = 0.3
supports = [{{ on = "flat", x = 0, y = -0.006 }}]

[[obstacle]]
name = "plane"
half-space = {{ point = [0, -0.5], normal = [0, 1] }}
on = [["disc", "arc"]]
"#
    )
}

/// Straight facets follow the circle as they become smaller: both orders have one limit. The coarsest mesh has facets of .26, and a zone of .11.
#[test]
fn both_orders_come_to_the_contact_of_the_circle() {
    let (code, text, out) = run("accuracy_p2", &half_disc(true), &["--accuracy", "0.01"]);
    assert_eq!(code, Some(0), "{text}");
    let quadratic = levels(&out);
    let (code, text, out) = run("accuracy_p1", &half_disc(false), &["--accuracy=8 %"]);
    assert_eq!(code, Some(0), "{text}");
    let linear = levels(&out);
    // its straight facets miss the contact at first
    assert_eq!((linear[0][1], linear[0][2].abs() < 1e-12), (0.0, true));
    let ends = [&quadratic, &linear].map(|levels| levels[levels.len() - 1]);
    let [[fine, _, energy], [_, estimated, above]] = ends;
    assert!(fine < 20_000.0, "{fine}");
    let truth = ((above - energy) / energy).sqrt();
    assert!(
        (0.5..1.6).contains(&(estimated / truth)),
        "{estimated} {truth}"
    );
    assert!(
        (quadratic[0][2] / energy - 1.0).abs() > 0.5,
        "the first is coarse"
    );
}

/// An eighth of a ball that is pressed on a rigid plane.
fn ball(shells: usize) -> String {
    format!(
        r#"
increments = 1

[[body]]
name = "ball"
mesh = {{ eighth-sphere = {{ radius = 50, shells = {shells} }} }}
quadratic = true
curved = [{{ on = "surface", radius = 50 }}]
translated = [0, 0, 50]
law = "linear-elastic"
young = 20000
poisson = 0.3
supports = [{{ on = "left", x = 0 }}, {{ on = "front", y = 0 }}, {{ on = "flat", z = -2 }}]

[[obstacle]]
name = "plane"
half-space = {{ point = [0, 0, 0], normal = [0, 0, 1] }}
on = [["ball", "surface"]]
"#
    )
}

/// In space cells are cut where the errors are: a mesh that is fine all over needs three times the unknowns, and has another partition.
#[test]
fn meshes_in_space_are_fine_where_the_contact_is() {
    let (code, text, out) = run("accuracy_ball", &ball(4), &["--accuracy", "10%"]);
    assert_eq!(code, Some(0), "{text}");
    let levels = levels(&out);
    let [unknowns, estimated, energy] = levels[levels.len() - 1];
    assert!(unknowns < 5000.0, "{unknowns}");
    let (code, text, out) = run("accuracy_ball_uniform", &ball(14), &[]);
    assert_eq!(code, Some(0), "{text}");
    let text = fs::read_to_string(out.join("summary.json")).expect("a summary");
    let uniform: Value = serde_json::from_str(&text).expect("JSON");
    let of = |name: &str| uniform[name].as_f64().expect("a number");
    let free = uniform["mesh"]["free_dofs"].as_f64().expect("a number");
    assert!(free > 3.0 * unknowns, "{free} {unknowns}");
    assert!(of("estimated_error") > 0.8 * estimated);
    // each is off by no more than what it is estimated to be off by
    let apart = (energy - of("energy")).abs();
    let told = (estimated.powi(2) + of("estimated_error").powi(2)) * energy;
    assert!(apart < told, "{apart} {told}");
}

/// A ball of flat facets that ends at planes of symmetry, beside which feet are beyond its end: the second measurement leaves them out, as rows do.
#[test]
fn balls_that_are_refined_beside_planes_of_symmetry_are_certified() {
    let scene = r#"
geometry = "current"
increments = 3

[[body]]
name = "block"
mesh = { cuboid = { low = [0, 0, -0.8], size = [1.2, 1.2, 0.8], divisions = [3, 5, 1] } }
law = "linear-elastic"
young = 25
poisson = 0.4
symmetry = ["left", "front"]
supports = [{ on = "bottom", x = 0, y = 0, z = 0 }]

[[body]]
name = "ball"
mesh = { eighth-sphere = { radius = 1, shells = 4 } }
law = "linear-elastic"
young = 1000
poisson = 0.45
symmetry = ["left", "front"]
translated = [0, 0, 1]
supports = [{ on = "flat", x = 0, y = 0, z = -0.018 }]

[[contact]]
first = ["block", "top"]
second = ["ball", "surface"]
"#;
    let (code, text, _) = run("accuracy_symmetry", scene, &["--accuracy", "30%"]);
    assert_eq!(code, Some(0), "{text}");
}

/// A cantilever whose tip comes down on a small disc. Its first meshes see the disc with hardly a point, while most of the error is where the beam is clamped. The
/// energy is that of a mesh whose end is fine from the beginning.
#[test]
fn contacts_that_facets_miss_are_found() {
    let beam = |x: &str| {
        format!(
            r#"
increments = 1

[[body]]
name = "beam"
mesh = {{ rectangle = {{ x = {x}, y = [0, 1] }} }}
quadratic = true
law = "linear-elastic"
young = 1000
poisson = 0.3
supports = [{{ on = "left", x = 0, y = 0 }}]
tractions = [{{ on = "top", force = [0, -0.02] }}]

[[obstacle]]
name = "post"
ball = {{ centre = [9.5, -0.3], radius = 0.3 }}
on = [["beam", "bottom"]]
"#
        )
    };
    let even = beam("{ from = 0, to = 10, count = 10 }");
    let graded = "[0, 0.5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9.25, 9.4, 9.45, 9.475, 9.5, 9.525, 9.55, 9.6, 9.75, 10]";
    let ends = [("even", even), ("graded", beam(graded))].map(|(name, scene)| {
        let name = format!("accuracy_post_{name}");
        let (code, text, out) = run(&name, &scene, &["--accuracy", "3%"]);
        assert_eq!(code, Some(0), "{text}");
        let levels = levels(&out);
        levels[levels.len() - 1][2]
    });
    // without the disc, the energy is ten times as large
    assert!((ends[0] / ends[1] - 1.0).abs() < 0.01, "{ends:?}");
}

/// Meshes that begin where the last one ended come to the states of whole paths.
#[test]
fn starts_on_finer_meshes_do_not_change_what_they_end_with() {
    let scene = half_disc(true)
        .replace("increments = 1", "increments = 4")
        .replace("linear-elastic", "neo-hookean")
        .replace("y = -0.006", "y = -0.06");
    let (code, text, out) = run("accuracy_nested", &scene, &["--accuracy", "3%"]);
    assert_eq!(code, Some(0), "{text}");
    let nested = levels(&out);
    let (code, text, out) = run("accuracy_path", &scene, &["--accuracy", "3%", "--path"]);
    assert_eq!(code, Some(0), "{text}");
    let whole = levels(&out);
    assert_eq!(nested.len(), whole.len());
    assert!(nested.len() > 2);
    for (a, b) in nested.iter().zip(&whole) {
        assert!((a[2] / b[2] - 1.0).abs() < 1e-8, "{a:?} {b:?}");
    }
    // one increment on finer meshes, and all four with `--path`
    for (name, steps) in [("accuracy_nested", 1), ("accuracy_path", 4)] {
        let summary = format!("{name}/out/level_1/summary.json");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scene_files");
        let text = fs::read_to_string(folder.join(summary)).expect("a summary");
        let summary: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(summary["steps"], steps, "{name}");
    }
}

/// A disc in a ring. From the end of the first mesh the second one takes more than ten factorisations, and fewer than its path: it gets there in one step, which is not
/// told to be long, and ends where its path ends.
#[test]
fn starts_that_take_their_time_are_quicker_than_paths() {
    let scene = r#"
increments = 5

[[body]]
name = "ring"
mesh = { annulus = { radii = { from = 0.7, to = 2, count = 5 }, segments = 20 } }
quadratic = true
curved = [{ on = "inner", radius = 0.7 }, { on = "outer", radius = 2 }]
law = "neo-hookean"
young = 1000
poisson = 0
supports = [{ on = "outer", x = 0, y = 0 }]

[[body]]
name = "disc"
mesh = { disc = { radius = 0.6, segments = 18, rings = 1, phase = 0.03 } }
quadratic = true
curved = [{ on = "boundary", radius = 0.6 }]
law = "neo-hookean"
young = 1000
poisson = 0
supports = [{ x = 0, y = -1.125 }]

[[contact]]
first = ["ring", "inner"]
second = ["disc", "boundary"]
"#;
    let last = |name: &str, options: &[&str]| {
        let (_, text, out) = run(name, scene, options);
        let summary = fs::read_to_string(out.join("level_1/summary.json"));
        let summary: Value = serde_json::from_str(&summary.expect(&text)).expect("JSON");
        let number = |name: &str| summary[name].as_f64().expect("a number");
        (
            number("steps"),
            number("factorisations"),
            number("energy"),
            summary["findings"].clone(),
        )
    };
    let start = last("accuracy_start", &["--accuracy", "8%"]);
    let path = last("accuracy_start_path", &["--accuracy", "8%", "--path"]);
    assert_eq!((start.0, path.0), (1.0, 5.0));
    assert!(start.1 < path.1, "{} {}", start.1, path.1);
    assert!(
        (start.2 / path.2 - 1.0).abs() < 1e-8,
        "{} {}",
        start.2,
        path.2
    );
    assert_eq!(start.3, Value::Array(Vec::new()));
}

#[test]
fn what_is_not_reached_is_told() {
    let (code, text, out) = run(
        "accuracy_limit",
        COLUMN,
        &["--accuracy", "0.001%", "--seconds", "0.001"],
    );
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("limit of seconds") && text.contains("level_0"),
        "{text}"
    );
    assert_eq!(levels(&out).len(), 1);
    let loose = COLUMN.replace("body-force = [0, -3]", "");
    let (code, text, _) = run("accuracy_loose", &loose, &["--accuracy", "1%"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("nothing is strained"), "{text}");
}

/// A force at a point: its displacement, and the energy, have no limit as cells become smaller, and each level lowers the energy by as much.
#[test]
fn a_force_at_a_point_does_not_seem_accurate() {
    let scene = COLUMN.replace(
        "body-force = [0, -3]",
        "quadratic = true\nforces = [{ at = [[1, 1]], force = [0, -3] }]",
    );
    let (code, text, out) = run(
        "accuracy_point",
        &scene,
        &["--accuracy", "5%", "--seconds", "60"],
    );
    let levels = levels(&out);
    let [first, .., last] = levels[..] else {
        panic!("{text}");
    };
    assert!(levels.len() > 6, "{text}");
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("errors raised by"), "{text}");
    // energies are below zero here, and go on falling
    assert!(last[2] < 1.3 * first[2], "{text}");
    assert!(last[1] > 0.1, "{text}");
}

#[test]
fn options_that_mean_nothing_are_refused() {
    for (options, told) in [
        (&["--accuracy", "much"][..], "such as 1%"),
        (&["--accuracy", "200%"], "between 0 and 1"),
        (&["--accuracy", "0"], "between 0 and 1"),
        (&["--accuracy", "1%", "--seconds", "-1"], "seconds"),
        (&["--seconds", "5"], "without --accuracy"),
        (&["--path"], "without --accuracy"),
        (&["--accuracy", "1%", "--resume"], "--resume"),
        (&["--accuracy", "1%", "--literal"], "--literal"),
        (&["--accuracy", "1%", "--solver", "literal"], "literal"),
    ] {
        let (code, text, out) = run("accuracy_refused", COLUMN, options);
        assert_eq!(code, Some(2), "{options:?}: {text}");
        assert!(text.contains(told), "{options:?}: {text}");
        assert!(!out.exists(), "{options:?}");
    }
}
