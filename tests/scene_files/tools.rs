//! Rigid tools under forces, torques and springs, preloads and sheets without a mesh, as a scene file says them: what the last lines and
//! the summary tell, against statics.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use super::{fresh, program, results};

/// A block of E = 100 and ν = 0, 2 wide and 1 high, on which a plate stands; the block's sides are free.
const SCENE: &str = r#"
[[body]]
name = "block"
mesh = { rectangle = { x = { from = 0, to = 2, count = 8 }, y = { from = 0, to = 1, count = 4 } } }
law = "linear-elastic"
young = 100
poisson = 0
supports = [{ on = "bottom", y = 0 }, { at = [[0, 0]], x = 0 }]

[[body]]
name = "plate"
mesh = { rectangle = { x = { from = 0, to = 2, count = 8 }, y = [1, 1.5] } }
law = "rigid"
supports = [{ at = [[0, 1]], x = 0 }]
tractions = [{ on = "top", force = [0, -3] }]

[[contact]]
first = ["plate", "bottom"]
second = ["block", "top"]
"#;

/// The scene with some changes: its exit code, what it printed, and its summary.
fn run(name: &str, changes: &[(&str, &str)]) -> (Option<i32>, String, BTreeMap<String, Value>) {
    let folder = fresh(name);
    let text = changes.iter().fold(SCENE.to_string(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let path = folder.join("scene.toml");
    fs::write(&path, text).expect("written");
    let out = folder.join("out");
    let (code, told) = program(&["run", "--out"], &[&out, &path]);
    let found = match code {
        Some(2) => BTreeMap::new(),
        _ => results(&out),
    };
    (code, told, found)
}

fn close(found: &Value, expected: f64) {
    let found = found.as_f64().expect("a number");
    assert!((found - expected).abs() < 1e-8, "{found} {expected}");
}

#[test]
fn a_plate_under_a_force_a_weight_and_springs() {
    // pressed by 6, and by springs of 20 a length
    let (code, told, found) = run(
        "plate",
        &[(
            "tractions = [{ on = \"top\", force = [0, -3] }]",
            "tractions = [{ on = \"top\", force = [0, -2] }]\nbody-force = [0, -2]\nfoundations = [{ on = \"top\", stiffness = 20, normal-only = true }]",
        )],
    );
    assert_eq!(code, Some(0), "{told}");
    let way = 6.0 / (100.0 * 2.0 + 20.0 * 2.0);
    close(&found["rigid_motions"][0]["displacement"][1], -way);
    assert_eq!(found["rigid_motions"][0]["body"], "plate");
    assert!(
        told.contains("rigid motions      body `plate` by (0, -0.025) UL"),
        "{told}"
    );
    assert!(
        told.contains("1 with a law for small strains, 1 rigid"),
        "{told}"
    );
}

/// A torque tilts a plate as a force beside its middle does, and the table has the ways.
#[test]
fn a_plate_that_tilts() {
    let at = |force: &str, torque: &str| {
        let changes = [
            ("law = \"rigid\"", "law = \"rigid-turning\""),
            (
                "tractions = [{ on = \"top\", force = [0, -3] }]",
                &format!("forces = [{force}]\ntorques = [{torque}]"),
            ),
        ];
        let (code, told, found) = run("tilts", &changes);
        assert_eq!(code, Some(0), "{told}");
        let motion = found["rigid_motions"][0].clone();
        let number = |value: &Value| value.as_f64().expect("a number");
        (
            number(&motion["displacement"][1]),
            number(&motion["rotation"][0]),
        )
    };
    let beside = at("{ at = [[1.25, 1.5]], force = [0, -4] }", "");
    let twisted = at(
        "{ at = [[1, 1.5]], force = [0, -4] }",
        "{ on = \"bottom\", torque = -1 }",
    );
    assert!(beside.1 < -1e-3, "{beside:?}");
    assert!((beside.0 - twisted.0).abs() < 1e-10 && (beside.1 - twisted.1).abs() < 1e-10);
}

/// A sheet of 0.1 between block and plate, which starts 0.12 above: the force is that of a way less 0.02.
#[test]
fn a_sheet_without_a_mesh() {
    let changes = [
        ("y = [1, 1.5]", "y = [1.12, 1.5]"),
        (
            "{ at = [[0, 1]], x = 0 }",
            "{ on = \"top\", x = 0, y = -0.05 }",
        ),
        ("tractions = [{ on = \"top\", force = [0, -3] }]", ""),
        ("[[contact]]", "[[contact]]\noffset = 0.1"),
    ];
    let (code, told, found) = run("sheet", &changes);
    assert_eq!(code, Some(0), "{told}");
    close(
        &found["pairs"][0]["resultant"][1]
            .as_f64()
            .map(f64::abs)
            .into(),
        100.0 * 2.0 * 0.03,
    );
    // and one that starts closer than it keeps
    let (code, told, _) = run("thick", &[("[[contact]]", "[[contact]]\noffset = 0.1")]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("starts inside body"), "{told}");
}

#[test]
fn what_tools_do_not_take() {
    for (from, to, says) in [
        (
            "law = \"rigid\"",
            "law = \"rigid\"\nyoung = 1",
            "`young` is not of a rigid body",
        ),
        (
            "law = \"rigid\"",
            "law = \"rigid\"\nrevolution = true\nplane-stress = true",
            "`plane-stress` is not of",
        ),
        (
            "law = \"rigid\"",
            "law = \"rigid-turning\"\nrevolution = true",
            "does not turn",
        ),
        (
            "x = 0 }]\ntractions",
            "x = 0, during = [0, 1] }]\ntractions",
            "does not take a support that does not hold at all times",
        ),
        (
            "x = 0 }]\ntractions",
            "along = [1, 1], by = 0 }]\ntractions",
            "not an axis",
        ),
        (
            "law = \"linear-elastic\"",
            "law = \"rigid-turning\"\n#",
            "is not of a rigid body",
        ),
        (
            "tractions",
            "torques = [{ on = \"top\", torque = [0, 0, 1] }]\ntractions",
            "give one number in the plane",
        ),
        (
            "[[contact]]",
            "[[contact]]\noffset = -1",
            "`offset of a pair` = -1",
        ),
        (
            "first = [\"plate\", \"bottom\"]\nsecond = [\"block\", \"top\"]",
            "surfaces = [[\"plate\", \"bottom\"], [\"block\", \"top\"]]\noffset = 0.1",
            "`offset` is for `first` and `second`",
        ),
    ] {
        let (code, told, _) = run("refused_tools", &[(from, to)]);
        assert_eq!(code, Some(2), "{to}: {told}");
        assert!(told.contains(says), "{to}: {told}");
    }
}
