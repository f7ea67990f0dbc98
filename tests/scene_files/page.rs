//! The pages that list keys and show scenes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use ipopt_contact::contact_fem::model::Severity;
use ipopt_contact::contact_fem::output::compare::{Tolerances, compare};
use ipopt_contact::prelude::*;
use ipopt_contact::scene_file::SceneFile;

use serde_json::Value;

use crate::{fresh, program, read, results, root};

/// The keys of each table in the sources of the parser, by the name of its type.
fn keys_of_sources() -> BTreeMap<String, BTreeSet<String>> {
    let mut tables: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in ["keys.rs", "meshes.rs"] {
        let text = read(Path::new("src/scene_file").join(file));
        let (mut table, mut renamed) = (None, None);
        for line in text.lines() {
            if let Some(name) = line.strip_prefix("pub(super) struct ") {
                table = name.strip_suffix(" {").map(String::from);
            }
            if line == "}" {
                table = None;
            }
            let line = line.trim();
            if let Some(name) = line.strip_prefix("#[serde(rename = \"") {
                renamed = name.split('"').next().map(String::from);
            }
            let field = line
                .strip_prefix("pub(super) ")
                .and_then(|rest| rest.split_once(':'));
            if let (Some(table), Some((field, _))) = (&table, field) {
                let key = renamed.take().unwrap_or(field.replace('_', "-"));
                tables.entry(table.clone()).or_default().insert(key);
            }
        }
    }
    // a list of two, not a table
    tables.remove("SideKeys");
    tables
}

/// The keys that the page lists, by the table that it names above each list.
fn keys_of_page() -> BTreeMap<String, BTreeSet<String>> {
    let mut tables: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut table = None;
    for line in read("docs/scene_files.md").lines() {
        if let Some(name) = line
            .strip_prefix("<!-- ")
            .and_then(|rest| rest.strip_suffix(" -->"))
        {
            table = Some(name.to_string());
        }
        if line.starts_with('#') {
            table = None;
        }
        let key = line
            .strip_prefix("| `")
            .and_then(|rest| rest.split('`').next());
        if let (Some(table), Some(key)) = (&table, key) {
            let is_new = tables
                .entry(table.clone())
                .or_default()
                .insert(key.to_string());
            assert!(is_new, "{table}: `{key}` twice");
        }
    }
    tables
}

#[test]
fn the_page_lists_all_keys() {
    let (sources, page) = (keys_of_sources(), keys_of_page());
    assert!(sources.len() > 25 && sources["BodyKeys"].contains("body-force-amplitude"));
    assert!(sources["ContactKeys"].contains("self"));
    for (table, keys) in &sources {
        assert_eq!(page.get(table), Some(keys), "{table}");
    }
    assert!(page.keys().eq(sources.keys()));
}

/// The blocks of code of a page in one language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let text = read(page);
    let mut blocks = Vec::new();
    let mut open: Option<String> = None;
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(start)) if start == language => open = Some(String::new()),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => *block += &format!("{line}\n"),
            _ => {}
        }
    }
    blocks
}

/// What the page shows is taken: whole scenes are sound, and a part is what is to be added to one.
#[test]
fn scenes_of_the_page_are_sound() {
    let folder = fresh("page");
    let all = blocks("docs/scene_files.md", "toml");
    assert!(all.len() >= 6, "{}", all.len());
    let mesh = rectangle(
        &linspace(0.0, 1.0, 4),
        &linspace(0.0, 1.0, 4),
        Diagonals::Rising,
    );
    let mesh = mesh.expect("a mesh");
    mesh.save_freefem(folder.join("block.msh"))
        .expect("written");
    let tool = cuboid([-1.0, -1.0, -1.0], [3.0, 3.0, 1.0], [1; 3]).expect("a mesh");
    tool.save_freefem(folder.join("tool.mesh"))
        .expect("written");
    for text in all {
        let file = SceneFile::parse(&text, &folder).unwrap_or_else(|why| panic!("{text}\n{why}"));
        let worst = match file
            .dimension()
            .unwrap_or_else(|why| panic!("{text}\n{why}"))
        {
            2 => file.scene::<2>().map(|scene| scene.preflight()),
            _ => file.scene::<3>().map(|scene| scene.preflight()),
        };
        let findings = worst.unwrap_or_else(|why| panic!("{text}\n{why}"));
        file.simulation()
            .unwrap_or_else(|why| panic!("{text}\n{why}"));
        let errors = findings
            .iter()
            .filter(|finding| finding.severity == Severity::Error);
        let errors: Vec<String> = errors.map(ToString::to_string).collect();
        assert!(errors.is_empty(), "{text}\n{errors:?}");
    }
}

/// The recipes, in their order: each scene is sound and is solved, the script reads back what the first of them left, and the
/// three ways to one scene lead to one result.
#[test]
fn recipes_run() {
    let folder = fresh("cookbook");
    let mesh = root().join("docs/cookbook/pin.msh");
    fs::copy(mesh, folder.join("pin.msh")).expect("copied");
    // the mesh has the names of the geometry
    let geometry = blocks("docs/cookbook.md", "geo").concat();
    let file = MeshFile::read(folder.join("pin.msh")).expect("a mesh");
    for group in file.groups() {
        assert!(geometry.contains(&format!("(\"{}\", {})", group.name, group.number)));
    }
    let mut names = Vec::new();
    for text in blocks("docs/cookbook.md", "toml") {
        let name = text
            .strip_prefix("# ")
            .and_then(|rest| rest.split(".toml\n").next());
        let name = name.expect("a name").to_string();
        let path = folder.join(&name).with_extension("toml");
        fs::write(&path, &text).expect("written");
        let (code, told) = program(&["run", "--check"], &[&path]);
        assert_eq!(code, Some(0), "{name}: {told}");
        let out = folder.join("out").join(&name);
        let (code, told) = program(&["run", "--out"], &[&out, &path]);
        assert_eq!(code, Some(0), "{name}: {told}");
        names.push(name);
    }
    let expected = [
        "pin", "wedge", "punch", "slide", "weight", "unload", "quarter", "slope", "bolt", "sheet",
        "ball", "blocks",
    ];
    assert_eq!(names, expected);

    // what the page says of their results
    let result = |name: &str| results(&folder.join("out").join(name));
    let number = |value: &Value| value.as_f64().expect("a number");
    let is =
        |found: f64, expected: f64| assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    is(number(&result("weight")["obstacle_forces"][0][1]), -1.0);
    is(number(&result("unload")["stored_energy"]), 0.0);
    is(number(&result("unload")["obstacle_forces"][0][1]), 0.0);
    is(
        number(&result("quarter")["reaction"]),
        100.0 / (1.0 - 0.09) * 0.01,
    );
    is(
        number(&result("slope")["reaction"]),
        2.0 / 30.0_f64.to_radians().cos(),
    );

    // Hertz, of a rigid and an elastic body
    let hertz = (100.0 / (1.0 - 0.09) / std::f64::consts::PI).sqrt();
    let punch = number(&result("punch")["pressure_max"]);
    assert!((punch / hertz - 1.0).abs() < 0.01, "{punch} {hertz}");
    let way = &result("punch")["rigid_motions"][0]["displacement"];
    assert!(number(&way[0]) == 0.0 && number(&way[1]) < -0.01, "{way}");
    // the head bends by what a stiffness of 10⁴ times that of the others leaves
    let bolt = number(&result("bolt")["ties"][0]["force"][1]);
    assert!((bolt - 0.25).abs() < 1e-3, "{bolt}");

    is(number(&result("sheet")["pressure_max"]), 2.0);

    // what the script reads is there; the script itself runs where Python is
    let script = blocks("docs/cookbook.md", "python").concat();
    let pin = folder.join("out/pin");
    let table = fs::read_to_string(pin.join("pin.csv")).expect("a table");
    assert!(
        table
            .lines()
            .next()
            .expect("a head")
            .split(',')
            .any(|name| name == "energy")
    );
    let summary = results(&pin);
    for key in ["status", "energy", "bodies", "reactions"] {
        assert!(script.contains(&format!("summary[\"{key}\"]")) && !summary[key].is_null());
    }
    let path = folder.join("read.py");
    fs::write(&path, script).expect("written");
    match Command::new("python3").arg(&path).arg(&pin).output() {
        Ok(run) => {
            let told = String::from_utf8_lossy(&[run.stdout, run.stderr].concat()).to_string();
            assert!(
                run.status.success() && told.contains("complete with an energy"),
                "{told}"
            );
        }
        Err(why) => eprintln!("the script of the page does not run: {why}"),
    }

    let script = read("freefem/two_bodies.edp");
    assert!(script.contains(&blocks("docs/cookbook.md", "freefem").concat()));
    let stored = root().join("tests/script_results/quadratic");
    let comparison = compare(&folder.join("out/blocks"), &stored).expect("a comparison");
    let allowed = Tolerances {
        displacement: 1e-8,
        force: 1e-6,
        ..Tolerances::all(1e-9)
    };
    assert!(comparison.beyond(&allowed).is_empty(), "{comparison}");
}
