//! Results compared: stored ones of `freefem/two_bodies.edp`, and runs of its twin `examples/two_bodies.rs`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ipopt_contact::contact_fem::output::compare::{
    Comparison, Error, Matching, Note, Quantity, Row, Side, Tolerances, compare,
};
use ipopt_contact::prelude::*;

#[allow(dead_code)]
#[path = "../../examples/two_bodies.rs"]
mod two_bodies;

/// What FreeFEM 4.9 wrote.
fn stored(elements: &str) -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/script_results");
    tests.join(elements)
}

/// An empty folder of a test.
fn fresh(name: &str) -> PathBuf {
    crate::fresh(&format!("compare/{name}"))
}

/// A copy of a stored result, one of whose files is changed.
fn changed(name: &str, file: &str, change: impl Fn(&str) -> String) -> PathBuf {
    let folder = fresh(name);
    for entry in fs::read_dir(stored("quadratic")).expect("a folder") {
        let path = entry.expect("a file").path();
        let copy = folder.join(path.file_name().expect("a name"));
        fs::copy(path, copy).expect("copied");
    }
    let path = folder.join(file);
    let text = fs::read_to_string(&path).expect("a text");
    fs::write(path, change(&text)).expect("written");
    folder
}

fn record<const D: usize>(folder: &Path, scene: Scene<D>, increments: usize) {
    let mut simulation = Simulation::with_increments(increments);
    let mut recording = simulation.record(folder);
    recording.plan.quiet = true;
    recording.plan.picture = String::new();
    let mut problem = scene.problem().expect("a problem");
    let recorded = recording.run(&mut problem).expect("a run");
    assert!(recorded.history.is_complete());
}

fn row(comparison: &Comparison, quantity: Quantity) -> &Row {
    let mut rows = comparison.rows.iter();
    rows.find(|row| row.quantity == quantity).expect("a row")
}

/// The exit code and the output of the program.
fn program(arguments: &[&Path]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ipopt-contact"));
    let output = command.arg("compare").args(arguments).output();
    let output = output.expect("the program");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&text).into())
}

/// Both codes solve the same quadratic problem; both are accurate to what their solvers leave.
#[test]
fn a_script_and_the_library_agree() {
    for (elements, matching) in [
        ("linear", Matching::ByNumber),
        ("quadratic", Matching::ByPlace),
    ] {
        let folder = fresh(&format!("agree_{elements}"));
        let scene = two_bodies::scene(elements == "quadratic").expect("a scene");
        record(&folder, scene, 1);
        let comparison = compare(&folder, &stored(elements)).expect("a comparison");
        println!("{comparison}");
        assert_eq!(comparison.matching, matching, "{elements}");
        assert_eq!(comparison.notes, []);
        let tolerances = Tolerances {
            displacement: 1e-8,
            force: 1e-6,
            ..Tolerances::all(1e-9)
        };
        assert_eq!(comparison.beyond(&tolerances), Vec::<&Row>::new());
        for quantity in [
            Quantity::Energy,
            Quantity::Reaction,
            Quantity::Displacement,
            Quantity::DisplacementL2,
            Quantity::ContactForce,
        ] {
            let row = row(&comparison, quantity);
            assert!(row.a > Some(0.0) && row.relative.is_some(), "{row}");
        }
        // the script gives no pressures
        let pressure = row(&comparison, Quantity::Pressure);
        assert_eq!((pressure.relative, pressure.b), (None, None));
    }
}

/// A mesh of FreeFEM's `cube(2, 1, 1)`, P2, the top moved; without contact.
#[test]
fn a_script_in_space_and_the_library_agree() {
    let file = MeshFile::read(stored("space").join("cube.mesh")).expect("a mesh");
    let mesh = file.body::<3>("0").expect("a body").quadratic();
    let mut cube = Body::new(mesh, LinearElastic::new(100.0, 0.3).expect("a law"));
    cube.prescribe("5", [Some(0.0); 3]).expect("held");
    let moved = [Some(0.1), Some(0.0), Some(-0.1)];
    cube.prescribe("6", moved).expect("moved");
    let mut scene = Scene::new();
    scene.add("cube", cube);
    let folder = fresh("space");
    record(&folder, scene, 1);
    let comparison = compare(&folder, &stored("space")).expect("a comparison");
    assert_eq!(comparison.matching, Matching::ByPlace);
    let beyond = comparison.beyond(&Tolerances::all(1e-12));
    assert!(beyond.is_empty(), "{comparison}");
    assert!(
        row(&comparison, Quantity::DisplacementL2)
            .relative
            .is_some()
    );
}

/// The L² norm is taken over the cells of either; a uniform displacement has a known one.
#[test]
fn the_norm_of_a_translation_is_known() {
    for quadratic in [false, true] {
        let sides = linspace(0.0, 3.0, 2);
        let mesh = rectangle(&sides, &sides, Diagonals::Rising).expect("a mesh");
        let mesh = if quadratic { mesh.quadratic() } else { mesh };
        let folders = [0.5, 0.25].map(|shift| {
            let law = LinearElastic::new(1.0, 0.3).expect("a law");
            let mut body = Body::new(mesh.clone(), law);
            body.prescribe("bottom", [Some(shift), Some(0.0)])
                .expect("held");
            let mut scene = Scene::new();
            scene.add("square", body);
            let folder = fresh(&format!("norm_{quadratic}_{shift}"));
            record(&folder, scene, 1);
            folder
        });
        let comparison = compare(&folders[0], &folders[1]).expect("a comparison");
        let norm = row(&comparison, Quantity::DisplacementL2);
        let near =
            |value: Option<f64>, exact: f64| value.is_some_and(|v| (v - exact).abs() < 1e-12);
        assert!(near(norm.a, 1.5) && near(norm.b, 0.75), "{norm}");
        assert!(
            near(norm.absolute, 0.75) && near(norm.relative, 0.5),
            "{norm}"
        );
    }
}

#[test]
fn recorded_runs_compare_with_each_other() {
    let folders = [1, 2].map(|increments| {
        let folder = fresh(&format!("recorded_{increments}"));
        record(
            &folder,
            two_bodies::scene(false).expect("a scene"),
            increments,
        );
        folder
    });
    let comparison = compare(&folders[0], &folders[1]).expect("a comparison");
    assert_eq!(comparison.matching, Matching::ByNumber);
    assert_eq!(comparison.notes, [Note::Increments { a: 1.0, b: 2.0 }]);
    assert!(
        comparison.beyond(&Tolerances::all(1e-9)).is_empty(),
        "{comparison}"
    );
    assert_eq!(row(&comparison, Quantity::Pressure).body, None);
    assert!(row(&comparison, Quantity::Pressure).relative.is_some());

    // an interval that does not divide the increments leaves the last state all the same, and only once where it does
    for (every, states) in [(3, ["0", "0.75", "1"]), (2, ["0", "0.5", "1"])] {
        let folder = fresh(&format!("every_{every}"));
        let mut simulation = Simulation::with_increments(4);
        let mut recording = simulation.record(&folder);
        (recording.plan.quiet, recording.plan.vtu_every) = (true, every);
        let mut problem = two_bodies::scene(false)
            .expect("a scene")
            .problem()
            .expect("a problem");
        recording.run(&mut problem).expect("a run");
        let comparison = compare(&folders[0], &folder).expect("a comparison");
        let off = comparison.beyond(&Tolerances::all(1e-9));
        assert!(off.is_empty(), "{comparison}");
        let listing = fs::read_to_string(folder.join(format!("every_{every}.pvd")));
        let listing = listing.expect("a listing");
        let times = listing.split("timestep=\"").skip(1);
        let times: Vec<&str> = times.filter_map(|rest| rest.split('"').next()).collect();
        assert_eq!(times, states);
    }

    // the series lacks the last state
    let listing = folders[1].join("recorded_2.pvd");
    let text = fs::read_to_string(&listing).expect("a listing");
    let last = text
        .lines()
        .rfind(|line| line.contains("<DataSet"))
        .expect("a state");
    fs::write(&listing, text.replace(last, "")).expect("written");
    let why = compare(&folders[0], &folders[1])
        .expect_err("a state is missing")
        .to_string();
    assert!(why.contains("do the run again"), "{why}");
}

/// What differs by more than the tolerance is named, and the exit code is 1.
#[test]
fn the_program_tells_what_is_beyond() {
    let stored = stored("quadratic");
    let copy = changed("copy", "result.txt", str::to_string);
    let (code, text) = program(&[&stored, &copy]);
    assert_eq!(code, Some(0), "{text}");
    let (code, text) = program(&[&stored, &stored]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("the same folder"), "{text}");
    let other = changed("beyond", "result.txt", |text| {
        text.replace("energy 0.0188", "energy 0.0189")
    });
    let (code, text) = program(&[&stored, &other]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("beyond the tolerance: energy\n"), "{text}");
    let loose = Path::new("--tolerance=energy=0.01");
    assert_eq!(program(&[&stored, &other, loose]).0, Some(0));
    let unfinished = changed("unfinished", "result.txt", |text| {
        let lines = text.lines().filter(|line| !line.starts_with("converged "));
        lines.map(|line| format!("{line}\n")).collect::<String>() + "converged 0\n"
    });
    let (code, text) = program(&[&stored, &unfinished]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("a result is not complete"), "{text}");
    let (code, text) = program(&[&stored, Path::new("nowhere")]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("nowhere has no result"), "{text}");
}

/// What a tolerance is given for must be in both results.
#[test]
fn what_is_asked_for_is_compared() {
    let stored = stored("quadratic");
    let without = changed("without", "result.txt", |text| {
        text.replace("energy", "enregy")
    });
    for body in ["lower", "upper"] {
        fs::remove_file(without.join(format!("force_{body}.txt"))).expect("removed");
    }
    let (code, text) = program(&[&stored, &without]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("note: B has keys that are not compared: enregy;"),
        "{text}"
    );
    assert!(
        text.contains("in one result only: energy; contact force, largest"),
        "{text}"
    );
    for (quantity, told) in [("energy", "energy"), ("force", "contact force, largest")] {
        let tolerance = format!("--tolerance={quantity}=1");
        let (code, text) = program(&[&stored, &without, Path::new(&tolerance)]);
        assert_eq!(code, Some(1), "{text}");
        let told = format!("not compared, although a tolerance is given: {told}\n");
        assert!(text.contains(&told), "{text}");
    }
}

/// Of a reaction the components that both have are compared.
#[test]
fn a_reaction_may_have_one_component() {
    let only_y = |name: &str, factor: f64| {
        changed(name, "result.txt", |text| {
            let line = |line: &str| match line.split_once(' ') {
                Some(("reaction_lower_x", _)) => String::new(),
                Some(("reaction_lower_y", y)) => {
                    let y: f64 = y.trim().parse().expect("a number");
                    format!("reaction_lower_y {}\n", factor * y)
                }
                _ => format!("{line}\n"),
            };
            text.lines().map(line).collect()
        })
    };
    let whole = stored("quadratic");
    let comparison = compare(&whole, &only_y("one", 1.0)).expect("a comparison");
    let reaction = row(&comparison, Quantity::Reaction);
    assert_eq!(reaction.body.as_deref(), Some("lower"));
    assert_eq!((reaction.relative, reaction.a), (Some(0.0), reaction.b));
    let comparison = compare(&only_y("double", 2.0), &whole).expect("a comparison");
    let off = row(&comparison, Quantity::Reaction).relative.expect("both");
    assert!((off - 0.5).abs() < 1e-12, "{off}");
}

#[test]
fn forces_of_the_other_sign_are_told() {
    let turn = |text: &str| -> String {
        let negative = |word: &str| (-word.parse::<f64>().expect("a number")).to_string();
        let words = |line: &str| line.split_whitespace().map(negative).collect::<Vec<_>>();
        text.lines()
            .map(|line| words(line).join(" ") + "\n")
            .collect()
    };
    let whole = stored("quadratic");
    let turned = changed("turned", "force_lower.txt", turn);
    let notes = compare(&whole, &turned).expect("a comparison").notes;
    assert_eq!(notes, [], "of one body only");
    let path = turned.join("force_upper.txt");
    let text = fs::read_to_string(&path).expect("a text");
    fs::write(&path, turn(&text)).expect("written");
    let notes = compare(&whole, &turned).expect("a comparison").notes;
    assert_eq!(notes, [Note::OppositeForces]);
}

#[test]
fn another_mesh_is_refused() {
    // of the same places, half of the nodes have no counterpart
    let refused = compare(&stored("linear"), &stored("quadratic"));
    let Err(Error::Unmatched {
        body,
        side,
        only_middles,
        ..
    }) = refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!(
        (body.as_str(), side, only_middles),
        ("lower", Side::B, false)
    );
}

#[test]
fn a_moved_node_is_named() {
    let moved = changed("moved", "nodes_lower.txt", |text| {
        text.replacen("2 1 \n", "2.001 1 \n", 1)
    });
    let refused = compare(&moved, &stored("quadratic"));
    let Err(Error::Unmatched {
        unmatched,
        place,
        distance,
        ..
    }) = refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!((unmatched, place), (1, vec![2.001, 1.0]));
    assert!((distance - 1e-3).abs() < 1e-12);
}

/// A side that one result has curved and the other straight.
#[test]
fn sides_that_are_curved_in_one_result_are_told() {
    let folder = fresh("curved");
    let mut scene = two_bodies::scene(true).expect("a scene");
    record(&folder, scene, 1);
    // the middle of the lower block's side at the right, which is between (2, 0.5) and (2, 1)
    let bent = changed("bent", "nodes_lower.txt", |text| {
        text.replacen("2 0.75 \n", "2.01 0.75 \n", 1)
    });
    let refused = compare(&folder, &bent);
    assert!(
        matches!(
            refused,
            Err(Error::Unmatched {
                only_middles: true,
                unmatched: 1,
                ..
            })
        ),
        "{refused:?}"
    );
    let corner = changed("corner", "nodes_lower.txt", |text| {
        text.replacen("2 1 \n", "2.01 1 \n", 1)
    });
    let refused = compare(&folder, &corner);
    assert!(
        matches!(
            refused,
            Err(Error::Unmatched {
                only_middles: false,
                ..
            })
        ),
        "{refused:?}"
    );
    // a recorded run is not one of a scene with other bodies
    scene = Scene::new();
    let law = LinearElastic::new(1.0, 0.3).expect("a law");
    let mesh = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("a mesh");
    let mut body = Body::new(mesh, law);
    body.prescribe("bottom", [Some(0.0); 2]).expect("held");
    scene.add("alone", body);
    let alone = fresh("alone");
    record(&alone, scene, 1);
    assert!(matches!(compare(&alone, &bent), Err(Error::Bodies { .. })));
}

#[test]
fn damaged_files_are_named() {
    type Change = fn(&str) -> String;
    let cases: [(&str, &str, Change, &str); 7] = [
        (
            "twice",
            "result.txt",
            |text| format!("{text}energy 5\n"),
            "`energy` is there twice",
        ),
        (
            "energy",
            "result.txt",
            |text| text.replace("energy ", "energy nan\nold "),
            "energy is NaN",
        ),
        (
            "word",
            "result.txt",
            |text| text.replace("energy ", "energy x\nold "),
            "is no number",
        ),
        (
            "nan",
            "displacement_lower.txt",
            |text| text.replacen("0 0", "-nan 0", 1),
            "a number in line",
        ),
        (
            "short",
            "force_lower.txt",
            |text| text[..text.len() / 2].into(),
            "the displacements have",
        ),
        (
            "fewer",
            "nodes_upper.txt",
            |text| text.lines().skip(1).map(|l| format!("{l}\n")).collect(),
            "the displacements have",
        ),
        (
            "column",
            "displacement_upper.txt",
            |text| text.replacen(" \n", " 0 0\n", 1),
            "give each node 2 in the plane",
        ),
    ];
    for (name, file, change, told) in cases {
        let folder = changed(name, file, change);
        let why = compare(&stored("quadratic"), &folder)
            .expect_err(name)
            .to_string();
        assert!(
            why.contains(file.split('.').next().unwrap_or(file)) && why.contains(told),
            "{name}: {why}"
        );
    }
    let missing = changed("missing", "result.txt", str::to_string);
    fs::remove_file(missing.join("displacement_lower.txt")).expect("removed");
    let refused = compare(&stored("quadratic"), &missing);
    assert!(matches!(refused, Err(Error::Bodies { .. })), "{refused:?}");
    fs::remove_file(missing.join("result.txt")).expect("removed");
    let refused = compare(&stored("quadratic"), &missing);
    assert!(
        matches!(refused, Err(Error::NoResult { .. })),
        "{refused:?}"
    );
}

/// Without places nodes are taken by their numbers, if there are as many.
#[test]
fn results_without_places_are_compared_by_number() {
    let numbered = changed("numbered", "result.txt", str::to_string);
    for body in ["lower", "upper"] {
        fs::remove_file(numbered.join(format!("nodes_{body}.txt"))).expect("removed");
    }
    let comparison = compare(&stored("quadratic"), &numbered).expect("a comparison");
    assert_eq!(comparison.matching, Matching::ByNumberUnchecked);
    assert!(
        comparison.beyond(&Tolerances::all(0.0)).is_empty(),
        "{comparison}"
    );
    let refused = compare(&stored("linear"), &numbered);
    assert!(
        matches!(refused, Err(Error::NodeCounts { .. })),
        "{refused:?}"
    );
}

/// A block of E = 100 and area 1 that is pressed on a floor by 0.1 and let go: what is left is round-off of E ε²/2 and E ε.
#[test]
fn a_run_that_ends_at_rest_is_scaled_by_its_peak() {
    let folder = fresh("relieved");
    let path = folder.join("scene.toml");
    let text = r#"
[[phase]]
name = "press"
until = 1
increments = 2
[[phase]]
name = "let go"
until = 2
increments = 2
[[body]]
name = "block"
mesh = { rectangle = { x = [0, 0.5, 1], y = [0, 0.5, 1] } }
law = "linear-elastic"
young = 100
poisson = 0
supports = [{ on = "top", x = 0, y = -0.1, amplitude = [[0, 0], [1, 1], [2, 0]] }]
[[obstacle]]
name = "floor"
half-space = { point = [0, 0], normal = [0, 1] }
on = [["block", "bottom"]]
"#;
    fs::write(&path, text).expect("written");
    let run = |solver: &str| {
        let out = folder.join(solver);
        let words = ["run", "--solver", solver, "--out"];
        let (code, told) = crate::program(&words, &[&out, &path]);
        assert_eq!(code, Some(0), "{told}");
        out
    };
    let comparison = compare(&run("condensed"), &run("ipopt")).expect("a comparison");
    let sides = [Side::A, Side::B].map(|side| Note::Relieved { side, factor: 1.0 });
    for note in sides {
        assert!(comparison.notes.contains(&note), "{comparison}");
    }
    for (quantity, scale) in [
        (Quantity::Energy, 0.5),
        (Quantity::Reaction, 10.0),
        (Quantity::Displacement, 0.1),
        // of the node in the middle
        (Quantity::ContactForce, 5.0),
        (Quantity::Pressure, 10.0),
    ] {
        let row = row(&comparison, quantity);
        assert!((row.scale / scale - 1.0).abs() < 1e-6, "{comparison}");
        // of the sizes at rest it would be 1
        assert!(row.relative < Some(1e-3), "{comparison}");
    }
    let told = comparison.to_string();
    let note = "note: B ends less strained than it was at time 1: relative differences are over the largest values of its run";
    assert!(told.contains(note), "{told}");
}
