//! Slips of a newcomer: each gets a hint that says what is meant, and where it belongs.

use std::fs;

use ipopt_contact::contact_core::ipopt::doctor;
use ipopt_contact::scene_file::SceneFile;

use crate::{fresh, program};

/// A block on a floor.
const SCENE: &str = r#"[[body]]
name = "block"
mesh = { rectangle = { x = [0, 1, 2], y = [0, 1] } }
law = "linear-elastic"
young = 100
poisson = 0.3
supports = [{ on = "left", x = 0 }, { on = "top", y = -0.1 }]

[[obstacle]]
name = "floor"
half-space = { point = [0, 0], normal = [0, 1] }
on = [["block", "bottom"]]
"#;

/// What is changed, and the last line of the error.
const SLIPS: [(&str, &str, &str); 43] = [
    // keys of another table
    (
        "on = [[\"block\", \"bottom\"]]",
        "on = [[\"block\", \"bottom\"]]\nincrements = 5",
        "`increments` is a key of the file as a whole: move it above the first `[[…]]`, line 1",
    ),
    (
        "poisson = 0.3",
        "poisson = 0.3\nmax_iterations = 5",
        "`max-iterations` is a key of the file as a whole: move it above the first `[[…]]`, line 1",
    ),
    (
        "[[body]]",
        "[output]\nsolver = \"ipopt\"\n[[body]]",
        "`solver` is a key of the file as a whole: move it above the first `[…]`, line 1",
    ),
    (
        "name = \"floor\"",
        "name = \"floor\"\nyoung = 3",
        "`young` is a key of `[[body]]` or `laws`: move it there",
    ),
    (
        "poisson = 0.3",
        "poisson = 0.3\npasses = \"both\"",
        "`passes` is a key of `[[contact]]`: move it right below `[[contact]]`",
    ),
    (
        "poisson = 0.3",
        "poisson = 0.3\nvtu-every = 2",
        "`vtu-every` is a key of `[output]`: move it right below `[output]`",
    ),
    (
        "poisson = 0.3",
        "poisson = 0.3\nalong = [0, 1]",
        "`along` is a key of `supports`: move it there",
    ),
    (
        "name = \"floor\"",
        "name = \"floor\"\nradius = 3",
        "`radius` is a key of `ball` or `cylinder`: move it there",
    ),
    (
        "mesh = {",
        "rectangle = {",
        "`rectangle` is a key of `mesh`: move it there",
    ),
    (
        "[[obstacle]]",
        "[[body.contact]]\nfirst = [\"a\", 1]\n[[obstacle]]",
        "`contact` is a table of the file as a whole: write `[[contact]]`",
    ),
    (
        "[[obstacle]]",
        "[body.boundaries]\nfoot = [\"bottom\"]\nplane-stress = true\n[[obstacle]]",
        "`plane-stress` is a key of `[[body]]`: move it right below `[[body]]`",
    ),
    (
        "[[obstacle]]",
        "[body.boundaries]\nfoot = [\"bottom\"]\nreach = 0.5\n[[obstacle]]",
        "`reach` is a key of the file as a whole: move it above the first `[[…]]`, line 1",
    ),
    // decimal commas and other numbers and texts that TOML does not have
    (
        "y = -0.1",
        "y = -0,1",
        "`-0,1` has a decimal comma: write `-0.1`",
    ),
    (
        "poisson = 0.3",
        "poisson = 0,3",
        "`0,3` has a decimal comma: write `0.3`",
    ),
    (
        "y = -0.1",
        "y = -.1",
        "`-.1` has no digit before its point: write `-0.1`",
    ),
    (
        "young = 100",
        "young = 100.",
        "`100.` has no digit behind its point: write `100.0`",
    ),
    (
        "law = \"linear-elastic\"",
        "law = linear-elastic",
        "`linear-elastic` has no quotes: write `\"linear-elastic\"`",
    ),
    (
        "on = \"top\"",
        "on = top",
        "`top` has no quotes: write `\"top\"`",
    ),
    (
        "young = 100",
        "young: 100",
        "`:` is no sign of TOML: write `=` between a key and its value",
    ),
    // brackets
    (
        "[[obstacle]]",
        "[obstacle]",
        "`obstacle` is a list: write `[[obstacle]]`",
    ),
    ("[[body]]", "[body]", "`body` is a list: write `[[body]]`"),
    (
        "[[body]]",
        "[phase]\nname = \"a\"\n[[body]]",
        "`phase` is a list: write `[[phase]]`",
    ),
    (
        "[[body]]",
        "[contact]\n[[body]]",
        "`contact` is a list: write `[[contact]]`",
    ),
    (
        "[[body]]",
        "[tie]\n[[body]]",
        "`tie` is a list: write `[[tie]]`",
    ),
    (
        "[[obstacle]]",
        "[body.tractions]\n[[obstacle]]",
        "`body.tractions` is a list: write `[[body.tractions]]`",
    ),
    (
        "[[body]]",
        "[[output]]\nname = \"a\"\n[[body]]",
        "`output` is one table: write `[output]`",
    ),
    (
        "[[body]]",
        "[[ipopt]]\ntol = 1e-9\n[[body]]",
        "`ipopt` is one table: write `[ipopt]`",
    ),
    (
        "[[obstacle]]",
        "[[body.boundaries]]\nfoot = [\"bottom\"]\n[[obstacle]]",
        "`body.boundaries` is one table: write `[body.boundaries]`",
    ),
    (
        "[[obstacle]]",
        "[obstacle]\nname = \"a\"\n[[obstacle]]",
        "`obstacle` is a list: write `[[obstacle]]` for each entry",
    ),
    (
        "[[obstacle]]\nname = \"floor\"\nhalf-space = { point = [0, 0], normal = [0, 1] }\non = [[\"block\", \"bottom\"]]\n",
        "[obstacle.ball]\ncentre = [0, 0]\n",
        "`obstacle` is a list: write `[[obstacle]]` above `[obstacle.ball]`",
    ),
    (
        "[[body]]",
        "[output]\n[output]\n[[body]]",
        "`output` is there twice: put the two together",
    ),
    (
        "supports = [{ on = \"left\", x = 0 }, { on = \"top\", y = -0.1 }]",
        "supports = { on = \"top\", y = -0.1 }",
        "this is a list: put brackets around its entries, as `[{ … }]`",
    ),
    // names that are nearly right
    ("half-space", "half_space", "did you mean `half-space`?"),
    ("half-space", "halfspace", "did you mean `half-space`?"),
    ("young", "youngs", "did you mean `young`?"),
    ("young", "Young", "did you mean `young`?"),
    ("young", "youngs_modulus", "did you mean `young`?"),
    ("supports", "suports", "did you mean `supports`?"),
    (
        "linear-elastic",
        "linear_elastic",
        "did you mean `linear-elastic`?",
    ),
    ("[[body]]", "[[bodies]]", "did you mean `body`?"),
    // what moves bodies
    (
        "half-space",
        "force = [0, -10]\nhalf-space",
        "an obstacle goes where its `motion` takes it: a tool that a force or a spring moves is a body with `law = \"rigid\"`",
    ),
    (
        "half-space",
        "weight = 2\nhalf-space",
        "an obstacle goes where its `motion` takes it: a tool that a force or a spring moves is a body with `law = \"rigid\"`",
    ),
    (
        "half-space",
        "foundations = []\nhalf-space",
        "an obstacle goes where its `motion` takes it: a tool that a force or a spring moves is a body with `law = \"rigid\"`",
    ),
];

fn refused(text: &str) -> String {
    match SceneFile::parse(text, "") {
        Ok(_) => panic!("no error in {text}"),
        Err(why) => why.to_string(),
    }
}

#[test]
fn slips_get_a_hint() {
    for (from, to, hint) in SLIPS {
        assert!(SCENE.contains(from), "{from}");
        let told = refused(&SCENE.replacen(from, to, 1));
        assert_eq!(told.lines().last(), Some(hint), "{to}: {told}");
        assert!(told.starts_with("the scene file: line "), "{to}: {told}");
    }
}

/// What is far from every key gets none.
#[test]
fn other_names_get_no_hint() {
    let told = refused(&SCENE.replace("young = 100", "hue = 100"));
    let last = told.lines().last().unwrap_or_default();
    assert!(last.starts_with("there is no key `hue`"), "{told}");
    // what others call by another name is told by ours
    for (from, to, meant) in [
        ("young = 100", "modulus = 100", "did you mean `young`?"),
        ("half-space = {", "plane = {", "did you mean `half-space`?"),
    ] {
        let told = refused(&SCENE.replacen(from, to, 1));
        assert_eq!(told.lines().last(), Some(meant), "{told}");
    }
}

/// A decimal comma in a list makes two numbers of one.
#[test]
fn a_decimal_comma_in_a_list_is_told() {
    let scene = |text: &str| {
        let file = SceneFile::parse(text, "").expect("a scene file");
        file.scene::<2>().map(drop).map_err(|why| why.to_string())
    };
    let told = scene(&SCENE.replace("point = [0, 0]", "point = [0,5, 0]"));
    assert_eq!(
        told,
        Err("obstacle floor, line 11, `half-space.point`: has 3 components and needs 2: if `0,5` is one number, write `0.5`".into())
    );
    let told = scene(&SCENE.replace("point = [0, 0]", "point = [0, 0, 0]"));
    assert!(told.is_err_and(|why| why.ends_with("needs 2")));
}

/// A key of the file below `[ipopt]` is no option.
#[test]
fn a_key_among_options_of_ipopt_is_told() {
    let text = format!("solver = \"ipopt\"\n{SCENE}[ipopt]\nincrements = 5\n");
    let file = SceneFile::parse(&text, "").expect("a scene file");
    let told = file.simulation().err().expect("refused").to_string();
    let hint =
        "`increments` is a key of the file as a whole: move it above the first `[[…]]`, line 2";
    assert_eq!(told.lines().last(), Some(hint), "{told}");
}

/// A linear solver that is not there is told before a run, with those that are.
#[test]
fn a_missing_linear_solver_is_refused() {
    let there = doctor::inspect().expect("an Ipopt");
    let known = there.linear_solvers.iter();
    let Some(missing) = known.filter(|own| !own.works).map(|own| own.name).next() else {
        return;
    };
    let names: Vec<&str> = there.working_linear_solvers().collect();
    let folder = fresh("linear_solver");
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    let written = |solver: &str| {
        let text =
            format!("solver = \"ipopt\"\nipopt = {{ linear_solver = \"{solver}\" }}\n{SCENE}");
        fs::write(&path, text).expect("written");
    };
    written(missing);
    let expected = format!(
        "error: {}: the scene, line 2, `ipopt.linear_solver`: Ipopt's option `linear_solver` was set to \"{missing}\", and there is no \
         such solver here: take {}",
        path.display(),
        names.join(" or ")
    );
    // newer ones tell besides how to load a library that has it
    for told in [
        program(&["run", "--check"], &[&path]),
        program(&["run", "--out"], &[&out, &path]),
    ] {
        assert_eq!(told.0, Some(2), "{}", told.1);
        assert!(told.1.starts_with(&expected), "{}", told.1);
    }
    assert!(!out.exists());
    written(names[0]);
    let (code, told) = program(&["run", "--check"], &[&path]);
    assert_eq!(code, Some(0), "{told}");
}

/// A mesh of lines alone names the body and the file.
#[test]
fn a_mesh_of_lines_is_named() {
    let folder = fresh("lines");
    let mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 0 0\n$EndNodes\n$Elements\n1\n1 1 2 1 1 1 2\n$EndElements\n";
    fs::write(folder.join("lines.msh"), mesh).expect("written");
    let path = folder.join("scene.toml");
    let text = SCENE.replace(
        "mesh = { rectangle = { x = [0, 1, 2], y = [0, 1] } }",
        "mesh = \"lines.msh\"",
    );
    fs::write(&path, text).expect("written");
    let (code, told) = program(&["run", "--check"], &[&path]);
    let expected = "body block, line 3, `mesh`: `lines.msh` has no cells of a dimension above 1: give a mesh of triangles or tetrahedra\n";
    assert!(code == Some(2) && told.ends_with(expected), "{told}");
}

/// An error of usage is one line, which names the command that tells more; its help is of that command alone.
#[test]
fn errors_of_usage_are_one_line() {
    for (words, told) in [
        (
            &[][..],
            "error: a command is missing: take run, solve, compare, causes, fields or mesh; `ipopt-contact --help` tells more\n",
        ),
        (
            &["rum"],
            "error: there is no command rum: take run, solve, compare, causes, fields or mesh; `ipopt-contact --help` tells more\n",
        ),
        (
            &["run", "a.toml"],
            "error: --out is missing: see `ipopt-contact run --help`\n",
        ),
        (
            &["run", "--out", "a"],
            "error: run needs one scene file, and 0 are given: see `ipopt-contact run --help`\n",
        ),
        (
            &["solve", "--colour", "red"],
            "error: solve has no option --colour: see `ipopt-contact solve --help`\n",
        ),
        (
            &["compare", "a"],
            "error: compare needs two folders, and 1 are given: see `ipopt-contact compare --help`\n",
        ),
        (
            &["causes", "a"],
            "error: causes needs a scene file and the folder of a result: see `ipopt-contact causes --help`\n",
        ),
    ] {
        assert_eq!(program(words, &[]), (Some(2), told.into()), "{words:?}");
    }
    let commands = ["run", "solve", "compare", "causes", "fields", "mesh"];
    for own in commands {
        let (code, told) = program(&[own, "--help"], &[]);
        assert_eq!(code, Some(0), "{told}");
        for other in commands {
            let has = told.contains(&format!("  ipopt-contact {other} "));
            assert_eq!(has, own == other, "{own}: {told}");
        }
    }
    let (_, told) = program(&["--help"], &[]);
    for own in commands {
        assert!(told.contains(&format!("  ipopt-contact {own} ")), "{told}");
    }
}
