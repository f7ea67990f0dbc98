//! What is wrong with a scene file, or may not be meant, is told before a solve: by `--check` and by a run alike, with line and key, and
//! in words that a file has.

use std::collections::BTreeMap;
use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::{fresh, program, read};

#[test]
fn checks_tell_errors_from_warnings() {
    let folder = fresh("check");
    let path = folder.join("scene.toml");
    let check = |text: &str| {
        fs::write(&path, text).expect("written");
        program(&["run", "--check"], &[&path])
    };
    let sound = read("examples/two_bodies.toml");
    let (code, text) = check(&sound);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("0 errors, 0 warnings") && text.contains("solver: condensed"),
        "{text}"
    );
    // linear triangles lock
    let (code, text) = check(&sound.replace("poisson = 0.3", "poisson = 0.495"));
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("warning") && text.contains("`lower`"),
        "{text}"
    );
    // the upper block flies away
    let free = sound.replace("supports = [{ on = \"top\", x = 0.02, y = -0.02 }]\n", "");
    let free = free
        .split("[[contact]]")
        .next()
        .expect("bodies")
        .to_string();
    let (code, text) = check(&free);
    assert_eq!(code, Some(2), "{text}");
    assert!(
        text.contains("1 error,") && text.contains("`upper`"),
        "{text}"
    );
    let (code, text) = check("body = 3");
    assert_eq!(code, Some(2), "{text}");
    let (code, text) = program(&["run", "--check", "--out", "x"], &[&path]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("--out has no effect with --check"), "{text}");
    // nothing is written
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
}

/// Each wrong file names the line and the key.
#[test]
fn errors_name_line_and_key() {
    let folder = fresh("wrong");
    let path = folder.join("scene.toml");
    // with a line a key, so that lines tell keys apart
    let sound = r#"increments = 2
points = 4
[[body]]
name = "block"
law = "linear-elastic"
young = 100
poisson = 0.3
[body.mesh.rectangle]
x = [0, 1, 2]
y = { from = 0, to = 1, count = 2 }
[[body.supports]]
on = "left"
x = 0
[[body.tractions]]
on = "top"
force = [0, -1]
[[obstacle]]
name = "floor"
on = [["block", "bottom"]]
[obstacle.half-space]
point = [0, 0]
normal = [0, 1]
"#;
    let check = |text: &str| {
        fs::write(&path, text).expect("written");
        program(&["run", "--check"], &[&path])
    };
    let (code, text) = check(sound);
    assert_eq!(code, Some(0), "{text}");
    let cases: [(&str, &str, usize, &str); 30] = [
        ("points = 4", "projection = 3", 2, "projection"),
        ("points = 4", "max-leaps = -1", 2, "max-leaps"),
        ("increments = 2", "increments = -2", 1, "increments"),
        ("points = 4", "points = 4.5", 2, "points"),
        ("points = 4", "point = 4", 2, "point"),
        (
            "points = 4",
            "points = 4\nintegration = \"exact\"",
            2,
            "points",
        ),
        ("points = 4", "integration = 4", 2, "integration"),
        ("points = 4", "integration = \"gauss\"", 2, "integration"),
        ("points = 4", "method = \"penalty\"", 2, "method"),
        ("points = 4", "depth = 3", 2, "depth"),
        (
            "points = 4",
            "solver = \"ipopt\"\npenetration = 1e-4",
            3,
            "penetration",
        ),
        (
            "points = 4",
            "solver = \"ipopt\"\nipopt = { max_itre = 3 }",
            3,
            "ipopt",
        ),
        (
            "points = 4",
            "output = { reaction = { of = [\"bloc\"], along = [0, 1] } }",
            2,
            "of",
        ),
        ("points = 4", "initial-gaps = \"ignore\"", 2, "initial-gaps"),
        ("young = 100", "young = -100", 6, "young"),
        ("poisson = 0.3", "poisson = 0.5", 7, "poisson"),
        (
            "poisson = 0.3\n",
            "poisson = 0.3\nshare = 0.5\n",
            8,
            "share",
        ),
        ("law = \"linear-elastic\"", "law = \"hooke\"", 5, "law"),
        ("law = \"linear-elastic\"\n", "", 3, "law"),
        (
            "[body.mesh.rectangle]",
            "[body.mesh.retcangle]",
            8,
            "retcangle",
        ),
        ("x = [0, 1, 2]", "x = [0, 2, 1]", 9, "`mesh.rectangle.x`"),
        ("count = 2 }", "cuont = 2 }", 10, "cuont"),
        ("on = \"left\"", "on = \"lfet\"", 12, "supports.on"),
        ("\nx = 0\n", "\nz = 0\n", 13, "z"),
        ("\nx = 0\n", "\n", 11, "supports"),
        ("force = [0, -1]", "force = [0, 0, -1]", 16, "force"),
        (
            "[[\"block\", \"bottom\"]]",
            "[[\"blok\", \"bottom\"]]",
            19,
            "on",
        ),
        ("on = [[\"block\", \"bottom\"]]", "on = []", 19, "on"),
        ("point = [0, 0]", "point = [0, 0, 0]", 21, "point"),
        ("normal = [0, 1]", "normal = [0, 0]", 20, "half-space"),
    ];
    for (from, to, line, key) in cases {
        let wrong = sound.replacen(from, to, 1);
        assert_ne!(wrong, sound, "{from}");
        let (code, text) = check(&wrong);
        assert_eq!(code, Some(2), "{to}: {text}");
        let is_told =
            text.contains(&format!("line {line},")) || text.contains(&format!("line {line}:"));
        assert!(is_told, "{to}, line {line}: {text}");
        assert!(text.contains(key), "{to}, key {key}: {text}");
    }
}

/// Two blocks, one on the other, with a line a key.
const BLOCKS: &str = r#"increments = 2
[[body]]
name = "lower"
law = "linear-elastic"
young = 100
poisson = 0.3
mesh = { rectangle = { x = [0, 1, 2], y = [0, 1] } }
[[body.supports]]
on = "bottom"
x = 0
y = 0
[[body]]
name = "upper"
law = "linear-elastic"
young = 100
poisson = 0.3
mesh = { rectangle = { x = [0, 1, 2], y = [1, 2] } }
[[body.supports]]
on = "top"
x = 0
y = -0.05
[[contact]]
first = ["lower", "top"]
second = ["upper", "bottom"]
"#;

/// A bar that is drawn in two phases, likewise.
const BAR: &str = r#"[[phase]]
name = "draw"
until = 1
increments = 1
[[phase]]
name = "hold"
until = 2
increments = 1
[[body]]
name = "bar"
law = "neo-hookean"
young = 100
poisson = 0.3
mesh = { rectangle = { x = [0, 1, 2], y = [0, 1] } }
[[body.supports]]
on = "left"
x = 0
y = 0
[[body.supports]]
on = "right"
x = 0.1
"#;

/// A wrong scene: what is changed, and the line, key and words by which it is told.
type Wrong = (
    &'static str,
    &'static str,
    usize,
    &'static str,
    &'static str,
);

/// What is wrong with the blocks.
const WRONG_BLOCKS: [Wrong; 27] = [
    (
        "increments = 2",
        "increments = \"two\"",
        1,
        "increments",
        "a whole number",
    ),
    (
        "increments = 2",
        "increments = 0",
        1,
        "`increments`",
        "at least one",
    ),
    (
        "increments = 2",
        "reach = -1",
        1,
        "`reach`",
        "leave the key out",
    ),
    ("increments = 2", "points = 100", 1, "`points`", "1 to 64"),
    (
        "increments = 2",
        "overlap-tolerance = -1",
        1,
        "`overlap-tolerance`",
        "= -1",
    ),
    (
        "increments = 2",
        "tolerance = 2",
        1,
        "`tolerance`",
        "between 0 and 1",
    ),
    (
        "increments = 2",
        "output = { name = \"a/b\" }",
        1,
        "`output.name`",
        "\"a/b\"",
    ),
    (
        "increments = 2",
        "output = { picture = \"a.png\" }",
        1,
        "`output.picture`",
        ".svg",
    ),
    (
        "increments = 2",
        "output = { reaction = { of = [\"upper\"], along = [0, 0] } }",
        1,
        "`output.reaction.along`",
        "no length",
    ),
    (
        "increments = 2",
        "output = { reaction = { of = [], along = [0, 1] } }",
        1,
        "`output.reaction.of`",
        "name the bodies",
    ),
    (
        "increments = 2",
        "output = { reaction = { of = [\"upper\"], on = \"left\", along = [0, 1] } }",
        1,
        "`output.reaction.on`",
        "`left`",
    ),
    ("young = 100", "young = \"soft\"", 5, "young", "a number"),
    (
        "young = 100",
        "young = inf",
        5,
        "`body.young`",
        "not finite",
    ),
    (
        "name = \"lower\"",
        "name = \"upper\"",
        13,
        "`name`",
        "two bodies",
    ),
    (
        "law = \"linear-elastic\"",
        "law = \"neo-hookean\"",
        4,
        "`law`",
        "set `geometry` to \"reference\" or \"current\"",
    ),
    (
        "y = [1, 2]",
        "y = [0.5, 2]",
        22,
        "contact 1",
        "`overlap-tolerance` or `initial-gaps`",
    ),
    ("y = -0.05", "y = 1e300", 18, "`supports`", "1e9"),
    (
        "second = [\"upper\", \"bottom\"]",
        "second = [\"lower\", \"top\"]",
        24,
        "`second`",
        "`self = [\"lower\", …]`",
    ),
    (
        "second = [\"upper\", \"bottom\"]",
        "second = [\"upper\", \"bottom\"]\n[[contact]]\nfirst = [\"upper\", \"bottom\"]\nsecond = [\"lower\", \"top\"]",
        25,
        "contact 2",
        "contact 1, line 22",
    ),
    (
        "second = [\"upper\", \"bottom\"]",
        "second = [\"upper\", \"botom\"]",
        24,
        "`second`",
        "`botom`",
    ),
    (
        "second = [\"upper\", \"bottom\"]",
        "second = [\"upper\"]",
        24,
        "second",
        "one boundary of it",
    ),
    (
        "[[contact]]",
        "[[tie]]\ntolerance = -1",
        23,
        "`tolerance`",
        "at least 0",
    ),
    (
        "[[contact]]\nfirst = [\"lower\", \"top\"]\nsecond",
        "[[tie]]\nfirst = [\"lower\", \"bottom\"]\nsecond",
        22,
        "tie 1",
        "counterpart",
    ),
    (
        "increments = 2",
        "solver = \"condensed\"\ngeometry = \"current\"",
        1,
        "`solver`",
        "`solver = \"newton\"`",
    ),
    (
        "x = [0, 1, 2], y = [1, 2]",
        "x = { from = 0, to = 2, count = 0 }, y = [1, 2]",
        17,
        "`mesh.rectangle.x.count`",
        "one step",
    ),
    (
        "x = [0, 1, 2], y = [1, 2]",
        "x = { from = 0, to = 2, count = 4000000000 }, y = [1, 2]",
        17,
        "`mesh.rectangle.x.count`",
        "`count` is 4000000000",
    ),
    (
        "{ rectangle = { x = [0, 1, 2], y = [1, 2] } }",
        "{ rectangle = { x = [0, 1, 2], y = [1, 2] }, disc = { radius = 1, segments = 9, rings = 2 } }",
        17,
        "one generator",
        "leave one of them out",
    ),
];

/// What is wrong with the bar.
const WRONG_BAR: [Wrong; 27] = [
    ("until = 2", "until = 0.5", 7, "`until`", "finite time"),
    (
        "until = 2",
        "until = 2\nleast-step = 3\nlargest-step = 1",
        8,
        "`least-step`",
        "millionth",
    ),
    (
        "until = 2",
        "until = 2\nleast-step = 0.1",
        8,
        "`least-step`",
        "`largest-step`",
    ),
    (
        "increments = 1\n[[body]]",
        "increments = 0\n[[body]]",
        8,
        "`increments`",
        "at least one",
    ),
    (
        "name = \"hold\"",
        "name = \"draw\"",
        6,
        "`name`",
        "another one",
    ),
    (
        "[[phase]]",
        "solver = \"condensed\"\n[[phase]]",
        1,
        "`solver`",
        "laws for small strains",
    ),
    (
        "[[phase]]",
        "solver = \"ipopt\"\ncomplementarity = -1\n[[phase]]",
        2,
        "`complementarity`",
        "between 0 and 1",
    ),
    (
        "[[phase]]",
        "solver = \"ipopt\"\nmethod = \"penalty\"\npenetration = -1\n[[phase]]",
        3,
        "`penetration`",
        "positive",
    ),
    (
        "[[phase]]",
        "solver = \"ipopt\"\ndepth = 0\n[[phase]]",
        2,
        "`depth`",
        "plain",
    ),
    (
        "[[phase]]",
        "solver = \"literal\"\nmax-iterations = 0\n[[phase]]",
        2,
        "`max-iterations`",
        "at least one",
    ),
    (
        "[[phase]]",
        "method = \"penalized-slack\"\n[[phase]]",
        1,
        "`method = penalized-slack`",
        "take ipopt",
    ),
    (
        "[[phase]]",
        "solver = \"ipopt\"\n[ipopt]\nmax_iter = 3\ntol = -1.0\n[[phase]]",
        4,
        "`ipopt.tol`",
        "> 0",
    ),
    (
        "y = 0\n[[body.supports]]",
        "y = 0\nduring = [[0, 0.5]]\n[[body.supports]]",
        19,
        "`supports.during`",
        "time 0.5",
    ),
    (
        "x = 0.1",
        "x = 0.1\nduring = [[3, 4]]",
        22,
        "`supports.during`",
        "no time",
    ),
    (
        "y = 0\n[[body.supports]]",
        "y = 0\nduring = [[1, 0]]\n[[body.supports]]",
        19,
        "`supports.during`",
        "pairs of times",
    ),
    (
        "y = 0\n[[body.supports]]",
        "y = 0\nduring = [[0, 1]]\n[[body.supports]]",
        15,
        "`supports`",
        "in the phase from time 1 to 2",
    ),
    (
        "x = 0.1",
        "x = 0.1\namplitude = 1\nduring = [[1, 2]]",
        21,
        "`supports.x`",
        "has no effect",
    ),
    (
        "x = 0.1",
        "motion = { translation = [0.1, 0], amplitude = 1 }\nduring = [1, 2]",
        21,
        "`supports.motion`",
        "has no effect",
    ),
    (
        "x = 0.1",
        "x = 0.1\nduring = [0, [1, 2]]",
        22,
        "during",
        "[[0, 1], [2, 3]]",
    ),
    (
        "x = 0.1",
        "x = 0.1\namplitude = \"up\"",
        22,
        "amplitude",
        "[[0, 0], [1, 1]]",
    ),
    (
        "x = 0.1",
        "x = 0.1\namplitude = [[0, 0], [1, 1e300]]\n[[body.supports]]\non = \"right\"\ny = 0",
        15,
        "`supports`",
        "1e9",
    ),
    (
        "x = 0.1",
        "x = 0.1\namplitude = [[0, 0], [1, 1], [2, 0]]\n[[body.supports]]\non = \"right\"\nx = 0.1\namplitude = [[0, 0], [1, 1], [2, 3]]",
        23,
        "`supports`",
        "at time 2",
    ),
    (
        "x = 0.1",
        "x = 0.1\namplitude = [[0, 0], [1, 1], [2, 0]]\n[[body.supports]]\nat = [[2, 0]]\nx = 0.1\namplitude = [[0, 0], [1, 1], [2, 3]]",
        23,
        "`supports`",
        "at time 2",
    ),
    (
        "on = \"right\"\nx = 0.1",
        "on = \"top\"\nx = 0.1",
        19,
        "against line 15",
        "0 and 0.1 at time",
    ),
    (
        "on = \"right\"\nx = 0.1",
        "on = \"left\"\nalong = [1, 1e-3]\nby = 0.2",
        21,
        "`supports.along`",
        "is prescribed twice",
    ),
    (
        "x = 0\ny = 0\n[[body.supports]]\non = \"right\"\nx = 0.1",
        "x = 0.1\n[[body.supports]]\non = \"left\"\nalong = [1, 1e-3]\nby = 0.2",
        20,
        "against line 15",
        "5.73e-2°",
    ),
    (
        "[[body.supports]]\non = \"left\"\nx = 0\ny = 0\n[[body.supports]]\non = \"right\"\nx = 0.1",
        "tractions = [{ on = \"top\", force = [0, 1] }]",
        9,
        "`supports`",
        "no displacement",
    ),
];

/// Words of Rust and of the library's insides.
const NOT_OF_A_FILE: [&str; 16] = [
    "::",
    "f64",
    "usize",
    "i64",
    "struct ",
    "enum ",
    "None",
    "Some(",
    "NeoHookean",
    "LinearElastic",
    "MooneyRivlin",
    "Condensed",
    "FixedPoint",
    "load factor",
    "phase until",
    "setting `",
];

fn of_the_corpus() -> impl Iterator<Item = (String, &'static Wrong)> {
    let changed = |sound: &'static str, wrong: &'static Wrong| {
        assert_eq!(sound.matches(wrong.0).count().min(1), 1, "{}", wrong.0);
        (sound.replacen(wrong.0, wrong.1, 1), wrong)
    };
    let blocks = WRONG_BLOCKS.iter().map(move |wrong| changed(BLOCKS, wrong));
    blocks.chain(WRONG_BAR.iter().map(move |wrong| changed(BAR, wrong)))
}

/// A run refuses whatever `--check` does, by the same words, and writes nothing.
#[test]
fn checks_and_runs_refuse_alike() {
    let folder = fresh("refused");
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    for sound in [BLOCKS, BAR] {
        fs::write(&path, sound).expect("written");
        let (code, told) = program(&["run", "--check"], &[&path]);
        assert_eq!(code, Some(0), "{told}");
    }
    for (text, &(_, to, line, key, says)) in of_the_corpus() {
        fs::write(&path, &text).expect("written");
        let (code, told) = program(&["run", "--check"], &[&path]);
        assert_eq!(code, Some(2), "{to}: {told}");
        for part in [key, says] {
            assert!(told.contains(part), "{to}: no `{part}` in {told}");
        }
        let place = format!("line {line}");
        let mut after = told.match_indices(&place);
        let is_told = after.any(|(at, _)| {
            let next = told[at + place.len()..].chars().next();
            !next.is_some_and(|c| c.is_ascii_digit())
        });
        assert!(is_told, "{to}, {place}: {told}");
        for word in NOT_OF_A_FILE {
            assert!(!told.contains(word), "{to}: `{word}` in {told}");
        }
        let (code, of_run) = program(&["run", "--out"], &[&out, &path]);
        assert_eq!(code, Some(2), "{to}: {of_run}");
        let first = of_run.lines().find(|line| line.starts_with("error: "));
        let first = first.unwrap_or_else(|| panic!("{to}: {of_run}"));
        assert!(
            told.lines().any(|line| line == first),
            "{to}: {first} not in {told}"
        );
        assert!(!out.exists(), "{to}");
    }
}

/// The lines that a check finds, after what it plans.
fn found(text: &str) -> (Option<i32>, Vec<String>) {
    // tests run side by side
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let folder = fresh(&format!("found_{}", COUNT.fetch_add(1, Ordering::Relaxed)));
    let path = folder.join("scene.toml");
    fs::write(&path, text).expect("written");
    let (code, told) = program(&["run", "--check"], &[&path]);
    for word in NOT_OF_A_FILE {
        assert!(!told.contains(word), "`{word}` in {told}");
    }
    let lines = told.lines();
    let found = lines.filter(|line| line.starts_with("warning: ") || line.starts_with("note: "));
    (code, found.map(String::from).collect())
}

/// Findings name their places, and what is no fault is none.
#[test]
fn findings_name_places() {
    // a load on nodes that are let go later moves them then
    let held = BAR.replace("x = 0.1", "x = 0.1\ny = 0");
    let loaded = |bar: &str| format!("{bar}[[body.tractions]]\non = \"right\"\nforce = [0, -1]\n");
    let (code, told) = found(&loaded(&held));
    assert_eq!((code, told.len()), (Some(1), 1), "{told:?}");
    assert!(
        told[0].starts_with("warning: body bar, line 23, `tractions`: the traction on `right`"),
        "{told:?}"
    );
    let (code, told) = found(&loaded(&format!("{held}during = [[0, 1]]\n")));
    assert_eq!((code, told.len()), (Some(0), 0), "{told:?}");

    // a value that grows while the support holds moves something; so does 0, which holds
    for more in [
        "during = [[1, 2]]",
        "amplitude = [[1, 0], [2, 1]]\nduring = [[1, 2]]",
        "amplitude = 1\nduring = [[0, 2]]",
    ] {
        let (code, told) = found(&format!("{BAR}{more}\n"));
        assert_eq!(code, Some(0), "{more}: {told:?}");
    }
    let (code, told) = found(&BAR.replace("x = 0.1", "x = 0\namplitude = 1\nduring = [[1, 2]]"));
    assert_eq!(code, Some(0), "{told:?}");

    // of a pair
    let far = BLOCKS.replace("increments = 2", "geometry = \"current\"\nreach = 0.01");
    let (code, told) = found(&far.replace("y = [1, 2]", "y = [1.1, 2]"));
    assert_eq!((code, told.len()), (Some(1), 2), "{told:?}");
    for line in &told {
        assert!(
            line.starts_with("warning: contact 1, line 23: ") && line.contains("`reach`"),
            "{line}"
        );
    }
    // linear cells that lock
    let (code, told) = found(&BLOCKS.replacen("poisson = 0.3", "poisson = 0.499", 1));
    assert_eq!((code, told.len()), (Some(1), 1), "{told:?}");
    assert!(
        told[0].starts_with("warning: body lower, line 4, `law`: "),
        "{told:?}"
    );
    assert!(told[0].contains("`averaged-volumes = true`"), "{told:?}");
}

/// Two supports along directions that are close hold a node if their values fit, as those of one motion do.
#[test]
fn nearly_parallel_supports_that_fit_are_sound() {
    let of = |by: f64| {
        BAR.replace("x = 0\ny = 0\n[[body.supports]]", &format!("x = 0.1\n[[body.supports]]\non = \"left\"\nalong = [1, 1e-3]\nby = {by}\n[[body.supports]]"))
    };
    // the displacement (0.1, 0.03) along both
    let length = 1e-3_f64.hypot(1.0);
    let (code, told) = found(&of((0.1 + 0.03 * 1e-3) / length));
    assert_eq!(code, Some(0), "{told:?}");
    let folder = fresh("parallel");
    let path = folder.join("scene.toml");
    fs::write(&path, of(0.2)).expect("written");
    let (code, told) = program(&["run", "--check"], &[&path]);
    // (0.2·|n| − 0.1)/1e-3 across
    assert!(
        code == Some(2) && told.contains("move it by 1.0e2"),
        "{told}"
    );
}

/// Around an axis, a ball beside it is a ring, and a motion along r is not rigid.
#[test]
fn what_is_no_ball_in_revolution_is_told() {
    let scene = |centre: f64, way: f64| {
        format!(
            "{}[[obstacle]]\nname = \"tool\"\nball = {{ centre = [{centre}, 1.5], radius = 0.5 }}\nmotion = [{{ translation = [{way}, -0.1] }}]\n\
             on = [[\"bar\", \"top\"]]\n",
            BAR.replace("law =", "revolution = true\nlaw =")
                .replace("on = \"right\"\nx = 0.1", "on = \"bottom\"\ny = 0")
        )
    };
    let notes = |centre, way| {
        let (code, told) = found(&scene(centre, way));
        assert_eq!(code, Some(0), "{told:?}");
        let own = told
            .into_iter()
            .filter(|line| line.contains("around the axis"));
        own.collect::<Vec<_>>()
    };
    assert_eq!(notes(0.0, 0.0).len(), 0);
    let ring = notes(1.0, 0.0);
    assert!(
        ring.len() == 1
            && ring[0].contains("obstacle tool, line 23")
            && ring[0].contains("r = 1.000e0"),
        "{ring:?}"
    );
    let wide = notes(0.0, 0.1);
    assert!(
        wide.len() == 1 && wide[0].contains("does not move along the axis alone"),
        "{wide:?}"
    );

    let moved = BAR.replace("law =", "revolution = true\nlaw =");
    let moved = moved.replace("x = 0.1", "motion = [{ translation = [0.1, 0] }]");
    let (_, told) = found(&moved);
    let own = told
        .iter()
        .filter(|line| line.contains("`supports.motion`"));
    assert_eq!(own.count(), 1, "{told:?}");
}

/// The force on one boundary of a bar that is drawn at both ends, whose supports push nothing in all.
#[test]
fn reactions_by_boundary() {
    let folder = fresh("reaction");
    let path = folder.join("scene.toml");
    let of = |on: &str| {
        let text = BAR.replace("x = 0\ny = 0", "x = -0.1\ny = 0");
        let text = text
            .replace("law = \"neo-hookean\"", "law = \"linear-elastic\"")
            .replace("poisson = 0.3", "poisson = 0");
        let text = format!("{text}[output]\nreaction = {{ of = [\"bar\"], {on}along = [2, 0] }}\n");
        fs::write(&path, text).expect("written");
        let out = folder.join("out");
        let (code, told) = program(&["run", "--out"], &[&out, &path]);
        assert_eq!(code, Some(0), "{told}");
        crate::results(&out)["reaction"].as_f64().expect("a force")
    };
    assert!(of("").abs() < 1e-10);
    // E·0.4/2 at time 2, on an area of 1
    assert!((of("on = \"right\", ") - 20.0).abs() < 1e-9);
    assert!((of("on = \"left\", ") + 20.0).abs() < 1e-9);
}

/// A resumed run says from where it goes on. With another solver, it leaves what is there.
#[test]
fn resumed_runs_say_so() {
    let folder = fresh("resumed");
    let path = folder.join("scene.toml");
    fs::write(&path, BAR).expect("written");
    let out = folder.join("out");
    let run = || program(&["run", "--resume", "--out"], &[&out, &path]);
    let (code, told) = run();
    assert!(
        code == Some(0) && told.contains("the run begins at time 0"),
        "{told}"
    );
    let (code, told) = run();
    assert!(
        code == Some(0) && told.contains("resume: 2 increments, up to time 2, are taken from"),
        "{told}"
    );
    let files = || {
        let entries = fs::read_dir(&out).expect("a folder");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let files = paths.map(|path| (path.clone(), fs::read(path).expect("a file")));
        files.collect::<BTreeMap<_, _>>()
    };
    let before = files();
    let refused = |words: &[&str]| {
        let (code, told) = program(words, &[&out, &path]);
        let says = "belongs to a run with another scene or other settings";
        assert!(code == Some(2) && told.contains(says), "{told}");
        assert!(before == files());
    };
    refused(&["run", "--resume", "--solver", "ipopt", "--out"]);
    let scene = fs::read_to_string(&path).expect("a file");
    let other = scene.replacen("young = 100", "young = 101", 1);
    assert_ne!(scene, other);
    fs::write(&path, other).expect("written");
    refused(&["run", "--resume", "--out"]);
}
