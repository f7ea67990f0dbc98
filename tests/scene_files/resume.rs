//! Runs of the program that are killed and go on, against one that was not.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::block;

/// A die is pressed into a block, which yields more and more, and slid.
const SCENE: &str = r#"
[[body]]
name = "block"
mesh = "block.msh"
law = "neo-hookean"
young = 100
poisson = 0.3
supports = [{ on = 1, x = 0, y = 0 }]

[[body]]
name = "die"
mesh = "die.msh"
law = "neo-hookean"
young = 1000
poisson = 0.3
supports = [
    { on = 4, y = -0.15, amplitude = [[0, 0], [1, 1], [2, 1]] },
    { on = 4, x = 0.6, amplitude = [[0, 0], [1, 0], [2, 1]] },
]

[[contact]]
first = ["block", 4]
second = ["die", 1]

[[phase]]
name = "press"
until = 1.0
increments = 4

[[phase]]
name = "slide"
until = 2.0
increments = 14
"#;

/// As [`SCENE`]; the block is held at its left until the die slides, and at its right from then on.
fn switched() -> String {
    let held = "{ on = 2, x = 0, during = [[0, 1]] }, { on = 3, x = 0, during = [[1, 2]] }";
    let always = "{ on = 1, x = 0, y = 0 }";
    let text = SCENE.replace(always, &format!("{always}, {held}"));
    assert!(text.contains(held));
    text
}

/// The scene and its meshes in an empty folder.
fn scene(name: &str, text: &str) -> (PathBuf, PathBuf) {
    let folder = crate::fresh(&format!("resume/{name}"));
    for (name, mesh) in [
        ("block.msh", block([0.0, 3.0], 0.0, [12, 4])),
        ("die.msh", block([0.3, 1.1], 1.0, [5, 4])),
    ] {
        mesh.save_freefem(folder.join(name)).expect("written");
    }
    let path = folder.join("scene.toml");
    fs::write(&path, text).expect("written");
    (folder, path)
}

fn program(scene: &Path, out: &Path, solver: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ipopt-contact"));
    command
        .args(["run", "--resume", "--solver", solver, "--out"])
        .args([out, scene])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// The contents of all files of a run by name, without times, memory and the file of answers.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let names = names.map(|name| name.into_string().expect("a name"));
    let names = names.filter(|name| !["run.resume", "run.lock"].contains(&name.as_str()));
    let content = |name: &str| match name {
        "summary.json" => {
            let text = fs::read(folder.join(name)).expect("a file");
            let mut summary: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
            let keys = summary.as_object_mut().expect("an object");
            for key in [
                "started",
                "process",
                "wall_seconds",
                "cpu_seconds",
                "seconds",
                "memory",
                "peak_memory_bytes",
                "factor",
            ] {
                keys.remove(key);
            }
            summary.to_string().into_bytes()
        }
        name if name.ends_with(".csv") => without_times(&folder.join(name)),
        _ => fs::read(folder.join(name)).expect("a file"),
    };
    names.map(|name| (name.clone(), content(&name))).collect()
}

fn without_times(path: &Path) -> Vec<u8> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let header = table.headers().expect("a header").clone();
    let mut rows = vec![header.clone()];
    rows.extend(table.records().map(|row| row.expect("a row")));
    let kept = |row: &csv::StringRecord| -> Vec<String> {
        let named = header.iter().zip(row);
        let kept = named.filter(|(name, _)| !name.contains("seconds"));
        kept.map(|(_, value)| value.to_string()).collect()
    };
    let rows: Vec<String> = rows.iter().map(|row| kept(row).join(",")).collect();
    rows.join("\n").into_bytes()
}

/// Kills the run after each of these shares of its time, lets it go on, and compares all files.
fn killed((name, text): (&str, &str), solver: &str, shares: impl Iterator<Item = f64>) {
    let (folder, scene) = scene(name, text);
    let whole = folder.join("whole").join("run");
    let clock = Instant::now();
    let status = program(&scene, &whole, solver).status().expect("a run");
    let time = clock.elapsed();
    assert!(status.success(), "{status}");
    let expected = results(&whole);
    assert!(expected.len() > 20, "{:?}", expected.keys());

    let (mut ended, mut kept) = (0, 0);
    for (k, share) in shares.enumerate() {
        let out = folder.join(k.to_string()).join("run");
        let mut child = program(&scene, &out, solver).spawn().expect("a run");
        sleep(Duration::from_secs_f64(share * time.as_secs_f64()));
        child.kill().expect("a child");
        ended += usize::from(!child.wait().expect("a child").success());
        let answers = fs::metadata(out.join("run.resume")).map_or(0, |file| file.len());
        kept += usize::from(answers > 1000);
        let status = program(&scene, &out, solver).status().expect("a run");
        assert!(status.success(), "{solver}, killed at {share}: {status}");
        let found = results(&out);
        let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(&expected));
        for (name, content) in &expected {
            assert!(
                found[name] == *content,
                "{solver}, killed at {share}: {name}"
            );
        }
        fs::remove_dir_all(folder.join(k.to_string())).expect("removed");
    }
    println!("{solver}: {ended} were killed as they ran, and {kept} had answers to go on from");
    assert!(ended > 0 && kept > 0);
}

/// At 50 moments, spread over the run by the golden ratio.
#[test]
fn killed_at_any_moment_a_run_goes_on_bit_for_bit() {
    killed(
        ("automatic", SCENE),
        "automatic",
        (1..=50).map(|k| (0.618_034 * f64::from(k)).fract()),
    );
}

#[test]
fn so_it_does_with_ipopt() {
    killed(("ipopt", SCENE), "ipopt", [0.2, 0.5, 0.8].into_iter());
}

#[test]
fn so_it_does_where_supports_are_switched() {
    let shares = (1..=12).map(|k| (0.618_034 * f64::from(k)).fract());
    killed(("switched", &switched()), "automatic", shares);
}

/// The answers are not those of another scene, and what is there stays.
#[test]
fn answers_of_another_scene_are_refused() {
    let (folder, path) = scene("another", SCENE);
    let out = folder.join("run");
    let status = program(&path, &out, "automatic").status().expect("a run");
    assert!(status.success(), "{status}");
    let answers = fs::read(out.join("run.resume")).expect("a file");
    let before = results(&out);
    for (from, to) in [
        ("young = 1000", "young = 1001"),
        ("x = 0.6", "x = 0.5"),
        ("increments = 14", "increments = 15"),
        ("first = [\"block\", 4]", "first = [\"block\", 3]"),
    ] {
        fs::write(&path, SCENE.replace(from, to)).expect("written");
        let mut command = program(&path, &out, "automatic");
        let output = command
            .stderr(Stdio::piped())
            .stdout(Stdio::piped())
            .output();
        let output = output.expect("a run");
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert!(
            !output.status.success() && said.contains("run.resume"),
            "{to}: {said}"
        );
        assert_eq!(fs::read(out.join("run.resume")).expect("a file"), answers);
        assert!(results(&out) == before, "{to}");
    }
    // another mesh in the same file
    fs::write(&path, SCENE).expect("written");
    let other = block([0.3, 1.1], 1.0, [6, 4]);
    other.save_freefem(folder.join("die.msh")).expect("written");
    let status = program(&path, &out, "automatic").status().expect("a run");
    assert_eq!(status.code(), Some(2));
    assert!(results(&out) == before);
}
