//! What a run prints at its end, and which forces it calls by their names.

use std::fs;

use crate::{fresh, program, results};

/// A block of area 1 between a floor and a lid that comes down by a tenth of its height: with ν = 0, the lid presses with E/10.
const PRESSED: &str = r#"
increments = 2

[[body]]
name = "block"
mesh = { rectangle = { x = { from = 0, to = 1, count = 4 }, y = { from = 0, to = 1, count = 4 } } }
law = "linear-elastic"
young = 100
poisson = 0
symmetry = ["left"]

[[obstacle]]
name = "floor"
half-space = { point = [0, 0], normal = [0, 1] }
on = [["block", "bottom"]]

[[obstacle]]
name = "lid"
half-space = { point = [0, 1], normal = [0, -1] }
motion = { translation = [0, -0.1] }
on = [["block", "top"]]
"#;

/// The exit code, the printed text and the force called `reaction`.
fn run(name: &str, text: &str, options: &[&str]) -> (Option<i32>, String, Option<f64>) {
    let folder = fresh(name);
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, text).expect("written");
    let words = [&["run"], options, &["--out"]].concat();
    let (code, told) = program(&words, &[&out, &path]);
    let force = match code {
        Some(2) => None,
        _ => results(&out)["reaction"].as_f64(),
    };
    (code, told, force)
}

#[test]
fn obstacles_have_reactions() {
    let near = |found: Option<f64>, expected: f64| {
        assert!(
            (found.expect("a force") - expected).abs() < 1e-9,
            "{found:?}"
        );
    };
    let (code, told, largest) = run("lid", PRESSED, &[]);
    assert_eq!(code, Some(0), "{told}");
    near(largest, 10.0);
    assert!(told.contains("reaction 10.00"), "{told}");
    for (of, along, expected) in [
        ("\"lid\"", "[0, 1]", -10.0),
        ("\"floor\"", "[0, 3]", 10.0),
        ("\"floor\"", "[0, 1e300]", 10.0),
        ("\"floor\"", "[0, 1e-300]", 10.0),
        ("\"floor\", \"lid\"", "[0, 1]", 0.0),
        ("\"floor\", \"block\"", "[1, 1]", 10.0 / 2.0_f64.sqrt()),
    ] {
        let asked = format!("{PRESSED}[output]\nreaction = {{ of = [{of}], along = {along} }}\n");
        near(run("lid_asked", &asked, &[]).2, expected);
    }
    for (wrong, why) in [
        (
            "of = [\"tool\"], along = [0, 1]",
            "there is no body or obstacle `tool`: there are the bodies [\"block\"] and the obstacles [\"floor\", \"lid\"]",
        ),
        (
            "of = [\"lid\", \"lid\"], along = [0, 1]",
            "names `lid` twice: leave one of them out",
        ),
        (
            "of = [\"lid\"], on = \"top\", along = [0, 1]",
            "obstacle `lid` has no supports on `top`: leave `on` or the obstacle out",
        ),
    ] {
        let asked = format!("{PRESSED}[output]\nreaction = {{ {wrong} }}\n");
        let (code, told, _) = run("lid_wrong", &asked, &[]);
        assert_eq!(code, Some(2), "{told}");
        assert!(told.contains(why), "{told}");
    }
}

/// One line for each result, and the rest on request.
#[test]
fn the_last_lines_have_the_results() {
    let (_, told, _) = run("last_lines", PRESSED, &[]);
    for line in [
        "forces on bodies   (0, -10) UF by obstacle `lid`",
        "(0, 10) UF by obstacle `floor`",
        "10 UF, largest pressure 10 UF/UL², area 1 UL²: `bottom` of body `block` and obstacle `floor`",
        "deepest overlap",
        "certificate        holds in all steps",
        "files",
    ] {
        assert!(told.contains(line), "{line}: {told}");
    }
    for left_out in ["stationarity  ", "left out", "inner iterations"] {
        assert!(!told.contains(left_out), "{left_out}: {told}");
    }
    let (_, verbose, _) = run("last_lines", PRESSED, &["--verbose"]);
    for line in [
        "stationarity  ",
        "left out",
        "inner iterations",
        "projection",
    ] {
        assert!(verbose.contains(line), "{line}: {verbose}");
    }
}

/// A polygon of 40 chords that is pressed by less than what its sides are away from the floor: rows of means over facets see nothing.
#[test]
fn a_contact_that_no_facet_resolves_is_told() {
    let text = |quadratic: bool, down: f64| {
        format!(
            r#"
[[body]]
name = "half"
mesh = {{ half-disc = {{ radii = {{ from = 0, to = 1, count = 10 }}, angles = {{ from = 3.141592653589793, to = 6.283185307179586, count = 40 }} }} }}
quadratic = {quadratic}
law = "linear-elastic"
young = 100
poisson = 0.3
supports = [{{ on = "base", x = 0, y = -{down} }}]

[body.boundaries]
base = {{ plane = {{ point = [0, 0], normal = [0, 1] }} }}

[[obstacle]]
name = "floor"
half-space = {{ point = [0, -1], normal = [0, 1] }}
on = [["half", "arc"]]
"#
        )
    };
    let (_, told, force) = run("shallow", &text(false, 5e-4), &[]);
    assert!(force.expect("a force").abs() < 1e-9, "{told}");
    assert!(told.contains("does not resolve the contact"), "{told}");
    assert!(
        told.contains("a node is 5.0e-4 UL inside, and no force acts"),
        "{told}"
    );
    for (quadratic, down) in [(false, 1e-3), (true, 2e-4), (true, 1e-3)] {
        let (_, told, _) = run("shallow", &text(quadratic, down), &[]);
        assert!(
            told.contains("does not resolve the contact"),
            "{quadratic} {down}: {told}"
        );
    }
    let (_, told, _) = run("apart", &text(false, -1e-3), &[]);
    assert!(!told.contains("does not resolve"), "{told}");
}
