//! Scripts of FreeFEM and scene files of the same scenes: results, matrices and fields go from one to the other.

use std::fs;
use std::path::{Path, PathBuf};

use ipopt_contact::contact_fem::freefem::read_array;
use ipopt_contact::contact_fem::mesh::generators::onto_sphere;
use ipopt_contact::contact_fem::output::compare::{Quantity, Tolerances, compare};
use ipopt_contact::prelude::*;
use ipopt_contact::scene_file::SceneFile;

use super::{TWO_BODIES, fresh, program, written_bodies};

/// What FreeFEM 4.9 wrote.
fn stored() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/script_results/quadratic")
}

fn tolerances() -> Tolerances {
    Tolerances {
        displacement: 1e-8,
        force: 1e-6,
        ..Tolerances::all(1e-9)
    }
}

/// A scene from a file agrees with the script, from rest and from the script's result; its fields go back to the script's
/// order.
#[test]
fn a_scene_from_a_file_agrees_with_the_script() {
    let folder = fresh("scene");
    let scene = written_bodies(&folder, TWO_BODIES);
    let (out, again) = (folder.join("out"), folder.join("again"));
    let (code, text) = program(&["run", "--out"], &[&out, &scene]);
    assert_eq!(code, Some(0), "{text}");
    let comparison = compare(&out, &stored()).expect("a comparison");
    assert!(comparison.beyond(&tolerances()).is_empty(), "{comparison}");

    let (code, text) = program(
        &["run", "--solver", "ipopt", "--start"],
        &[&stored(), Path::new("--out"), &again, &scene],
    );
    assert_eq!(code, Some(0), "{text}");
    let comparison = compare(&out, &again).expect("a comparison");
    assert!(
        comparison.beyond(&Tolerances::all(1e-5)).is_empty(),
        "{comparison}"
    );

    let fields = folder.join("fields");
    let (code, text) = program(
        &["fields", "--nodes"],
        &[&stored(), Path::new("--out"), &fields, &out],
    );
    assert_eq!(code, Some(0), "{text}");
    for body in ["lower", "upper"] {
        let u = read_array(fields.join(format!("u_{body}.txt"))).expect("an array");
        let theirs = fs::read_to_string(stored().join(format!("displacement_{body}.txt")));
        let theirs = theirs.expect("a text");
        let theirs: Vec<f64> = theirs
            .split_whitespace()
            .map(|word| word.parse().expect("a number"))
            .collect();
        assert_eq!(u.len(), theirs.len());
        let off = u.iter().zip(&theirs).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9);
        let forces = read_array(fields.join(format!("f_{body}.txt"))).expect("an array");
        let up: f64 = forces.iter().skip(1).step_by(2).sum();
        assert!((up.abs() - 1.885796324).abs() < 1e-8, "{up}");
    }
}

/// The script has 4 points, and the scene the default of quadratic elements.
#[test]
fn points_are_found_to_be_the_cause() {
    let folder = fresh("causes");
    let scene = written_bodies(&folder, &TWO_BODIES.replace("points = 4", ""));
    let out = folder.join("out");
    let (code, text) = program(&["causes", "--out"], &[&out, &scene, &stored()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("\nlikely: points = 4, which leaves"),
        "{text}"
    );
    assert_eq!(text.matches("which leaves").count(), 1, "{text}");
    let own = "not tried: the script's own tolerance of Ipopt, `tol` and `compl_inf_tol`";
    assert!(text.contains(own), "{text}");
}

/// Where the two agree, there is no cause: to the last bit nothing is tried, and within the tolerance of `compare` that is told.
#[test]
fn results_that_agree_have_no_cause() {
    let folder = fresh("agree");
    let scene = written_bodies(&folder, TWO_BODIES);
    let (own, out) = (folder.join("own"), folder.join("out"));
    let (code, text) = program(&["run", "--out"], &[&own, &scene]);
    assert_eq!(code, Some(0), "{text}");
    let (code, text) = program(&["causes", "--out"], &[&out, &scene, &own]);
    assert_eq!(code, Some(0), "{text}");
    let verdict = "the two agree to 0.0e0, which is round-off: there is no cause to look for";
    assert_eq!(text.lines().last(), Some(verdict), "{text}");
    assert!(
        !text.contains("passes") && !text.contains("own tolerance"),
        "{text}"
    );
    let (code, text) = program(&["causes", "--out"], &[&out, &scene, &stored()]);
    assert_eq!(code, Some(0), "{text}");
    let verdict = text.lines().last().unwrap_or_default();
    assert!(
        verdict.starts_with("the two agree to ")
            && verdict.contains("within the tolerance of `compare`, 1e-6"),
        "{text}"
    );
    assert!(
        text.contains("passes") && text.contains("own tolerance"),
        "{text}"
    );
}

/// The paper's algorithm to the letter, and with each departure, ends where the others do.
#[test]
fn the_literal_solver_finds_the_same_equilibrium() {
    let folder = fresh("literal");
    let text = TWO_BODIES.replace("linear-elastic", "neo-hookean");
    let energy = |keys: &str| {
        let keys = format!("points = 4\ntolerance = 1e-8\n{keys}");
        let path = written_bodies(&folder, &text.replace("points = 4", &keys));
        let file = SceneFile::read(&path).expect("a scene file");
        let scene = file.scene::<2>().expect("a scene");
        let mut simulation = file.simulation().expect("a simulation");
        let history = simulation.run(&mut scene.problem().expect("a problem"));
        let history = history.expect("a run");
        assert!(history.is_complete(), "{keys}: {:?}", history.run.ending);
        history.steps[0].energy
    };
    let newton = energy("solver = \"newton\"");
    for departures in [
        "",
        "\"acceleration\"",
        "\"warm-starts\"",
        "\"units\"",
        "\"guard\"",
        "\"lift\", \"predictor\"",
    ] {
        let literal = energy(&format!(
            "solver = \"literal\"\ndepartures = [{departures}]"
        ));
        assert!(
            (literal / newton - 1.0).abs() < 1e-6,
            "{departures}: {literal} {newton}"
        );
    }
}

/// The flag is the solver with the points and the stopping rule of the script.
#[test]
fn the_literal_flag_is_the_literal_solver() {
    let folder = fresh("flag");
    let text = TWO_BODIES.replace("linear-elastic", "neo-hookean");
    let keys = "solver = \"literal\"\ngoes-on = true\npoints = 4\nprojection = \"closest\"";
    let (flag, file) = (folder.join("flag"), folder.join("file"));
    let path = written_bodies(&folder, &text.replace("points = 4", keys));
    let (code, told) = program(&["run", "--out"], &[&file, &path]);
    assert_eq!(code, Some(0), "{told}");
    let path = written_bodies(&folder, &text.replace("points = 4", ""));
    let (code, told) = program(&["run", "--literal", "--out"], &[&flag, &path]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("solver: literal"), "{told}");
    let comparison = compare(&flag, &file).expect("a comparison");
    for row in &comparison.rows {
        let is_cost = row.quantity == Quantity::Seconds;
        assert!(is_cost || row.absolute == Some(0.0), "{comparison}");
    }

    let (code, told) = program(
        &["run", "--literal", "--solver=newton", "--out"],
        &[&flag, &path],
    );
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("two solvers"), "{told}");
    let path = written_bodies(&folder, &text.replace("points = 4", "solver = \"newton\""));
    let (code, told) = program(&["run", "--literal", "--out"], &[&flag, &path]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("its `solver` is newton"), "{told}");
}

/// A disc on a line; the result has its sides straight, the scene curved.
#[test]
fn straight_sides_are_found_to_be_the_cause() {
    let folder = fresh("sides");
    let round = disc(1.0, 16, 4, 0.0).expect("a mesh").quadratic();
    let curved = round
        .clone()
        .curved("boundary", onto_sphere(1.0))
        .expect("curved");
    let write = |name: &str, mesh: &Mesh<2>| {
        let nodes = mesh.nodes().iter().enumerate();
        let nodes: String = nodes
            .map(|(k, node)| format!("{} {:e} {:e} 0\n", k + 1, node[0], node[1]))
            .collect();
        let line =
            |nodes: &[usize]| -> String { nodes.iter().map(|k| format!(" {}", k + 1)).collect() };
        let sides = mesh.boundary("boundary").expect("a boundary");
        let sides: Vec<String> = sides
            .iter()
            .map(|side| format!("8 2 1 1{}", line(side)))
            .collect();
        let cells = mesh.cells().map(|cell| format!("9 2 2 2{}", line(cell)));
        let all: Vec<String> = sides.into_iter().chain(cells).collect();
        let elements: String = all
            .iter()
            .enumerate()
            .map(|(k, text)| format!("{} {text}\n", k + 1))
            .collect();
        let text = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"rim\"\n2 2 \"disc\"\n$EndPhysicalNames\n\
             $Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{}\n{elements}$EndElements\n",
            mesh.nodes().len(),
            all.len()
        );
        fs::write(folder.join(name), text).expect("written");
    };
    write("straight.msh", &round);
    write("curved.msh", &curved);
    let scene = |mesh: &str| {
        let text = format!(
            r#"
[[body]]
name = "disc"
mesh = "{mesh}.msh"
law = "linear-elastic"
young = 100
poisson = 0.3
body-force = [0, -0.1]
supports = [{{ x = 0 }}]

[[obstacle]]
name = "floor"
half-space = {{ point = [0, -1], normal = [0, 1] }}
on = [["disc", "rim"]]
"#
        );
        let path = folder.join(format!("{mesh}.toml"));
        fs::write(&path, text).expect("written");
        path
    };
    let result = folder.join("result");
    let (code, text) = program(&["run", "--out"], &[&result, &scene("straight")]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("are straight, and turn by up to"), "{text}");
    let curved = scene("curved");
    let (code, text) = program(&["run", "--out"], &[&folder.join("own"), &curved]);
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("are straight"), "{text}");
    let out = folder.join("out");
    let (code, text) = program(&["causes", "--out"], &[&out, &curved, &result]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("only middles of edges are elsewhere"),
        "{text}"
    );
    let straight = text.lines().find(|line| line.starts_with("straight sides"));
    let words: Vec<f64> = straight
        .expect("a row")
        .split_whitespace()
        .skip(2)
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert!(words.iter().all(|off| *off < 1e-9), "{words:?}");
    assert!(
        text.contains("\nlikely: straight sides, which leaves"),
        "{text}"
    );
    assert!(text.contains("not tried: normals"), "{text}");
}

/// A start far off gives the same end.
#[test]
fn a_guess_is_where_the_first_step_starts() {
    let folder = fresh("guess");
    let path = written_bodies(
        &folder,
        &TWO_BODIES.replace("linear-elastic", "neo-hookean"),
    );
    let file = SceneFile::read(&path).expect("a scene file");
    let run = |guess: Option<Vec<f64>>| {
        let scene = file.scene::<2>().expect("a scene");
        let mut problem = scene.problem().expect("a problem");
        let mut simulation = file.simulation().expect("a simulation");
        simulation.load_steps.guess = guess.map(|u| ipopt_contact::contact_core::State {
            u,
            ..ipopt_contact::contact_core::State::default()
        });
        let history = simulation.run(&mut problem).expect("a run");
        assert!(history.is_complete());
        history
    };
    let from_rest = run(None);
    let end = from_rest.run.state.u.clone();
    let from_end = run(Some(end));
    let iterations = |history: &History<2>| history.run.cost().outer_iterations;
    assert!(iterations(&from_end) < iterations(&from_rest));
    let energy = |history: &History<2>| history.steps[0].energy;
    assert!((energy(&from_end) / energy(&from_rest) - 1.0).abs() < 1e-12);
}

/// Two nodes of a body on springs: the first is held, the second pulled down by 3 onto a stop at −1. All are known by hand.
#[test]
fn matrices_of_a_script_are_solved() {
    let folder = fresh("matrices");
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("written");
    let head = "#  HashMatrix Matrix (COO) 0x1\n#    n       m        nnz     half     fortran   state  \n";
    let stiffness = "4 4 6 0 0 0 0 \n 0 0 2\n 1 1 2\n 1 3 -2\n 3 1 -2\n 2 2 5\n 3 3 2\n";
    write("K.txt", &format!("{head}{stiffness}"));
    write("b.txt", "4\t\n\t0\t0\t-1\t3");
    write(
        "C.txt",
        &format!("{head}3 4 2 0 0 0 0 \n 0 3 0.5\n 2 3 1\n"),
    );
    write("c0.txt", "3 0.5 -1 0");
    // the row without an entry is free, and so is the last one
    write("clow.txt", "3 0 -1 -1e19");
    write("low.txt", "4 0 0 -1e19 -1e19");
    write("high.txt", "4 0 0 1e19 1e19");
    write("bodies.txt", "pair 2 4\n");
    write("nodes_pair.txt", "0 1\n0 0\n");
    let out = folder.join("out");
    let (code, text) = program(&["solve", "--out"], &[&out, &folder]);
    assert_eq!(code, Some(0), "{text}");
    let near = |found: Vec<f64>, known: &[f64]| {
        assert_eq!(found.len(), known.len());
        let off = found.iter().zip(known).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?} {known:?}");
    };
    // 5 u = 1; 2 v + 3 = λ/2 at v = −1
    near(
        read_array(out.join("u.txt")).expect("an array"),
        &[0.0, 0.0, 0.2, -1.0],
    );
    near(
        read_array(out.join("lambda.txt")).expect("an array"),
        &[2.0, 0.0, 0.0],
    );

    // the same as a script's result
    let script = folder.join("script");
    fs::create_dir_all(&script).expect("a folder");
    let write = |name: &str, text: &str| fs::write(script.join(name), text).expect("written");
    // ½·5·0.04 − 0.2 + ½·2·1 − 3; the support carries 2
    write(
        "result.txt",
        "energy -2.1\nreaction_pair_x 0\nreaction_pair_y 2\nconverged 1\n",
    );
    write("displacement_pair.txt", "0 0\n0.2 -1\n");
    write("force_pair.txt", "0 0\n0 1\n");
    write("nodes_pair.txt", "0 1\n0 0\n");
    let comparison = compare(&out, &script).expect("a comparison");
    let beyond = comparison.beyond(&Tolerances::all(1e-12));
    assert!(beyond.is_empty(), "{comparison}");
    let compared = comparison.rows.iter();
    let compared = compared.filter(|row| row.relative.is_some());
    let compared: Vec<Quantity> = compared.map(|row| row.quantity).collect();
    assert!(compared.contains(&Quantity::ContactForce), "{compared:?}");
}
