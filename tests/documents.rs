//! What the documents name exists, and the numbers that they state are the library's.

use std::fs;
use std::path::{Path, PathBuf};

use contact_core::Acceleration;
use ipopt_contact_scenes::disc_in_disc::{
    self, DEFAULT_END, ENDS, EXACT_END, Fineness, FullLoad, PUSH, Roles,
};

/// Crates and their sources. Documents may leave the latter out of a path.
const CRATES: [(&str, &str); 6] = [
    ("ipopt_contact", "src"),
    ("contact_core", "contact-core/src"),
    ("contact_fem", "contact-fem/src"),
    ("ipopt_sys", "ipopt-sys/src"),
    ("ipopt_contact_scenes", "scenes/src"),
    ("report", "report/src"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

/// All Rust files below a folder.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let is_rust = |path: &PathBuf| path.extension().is_some_and(|end| end == "rs");
    let below = entries(folder).into_iter().flat_map(|path| {
        if path.is_dir() {
            rust_files(&path)
        } else {
            vec![path]
        }
    });
    below.filter(is_rust).collect()
}

struct Document {
    name: String,
    text: String,
}

fn documents() -> Vec<Document> {
    let more = entries(&root().join("docs"))
        .into_iter()
        .filter_map(|path| {
            let name = path.strip_prefix(root()).ok()?.to_str()?.to_string();
            name.ends_with(".md").then_some(name)
        });
    let names = ["README.md", "ARCHITECTURE.md"].map(String::from);
    let document = |name: String| Document {
        text: read(&name),
        name,
    };
    names.into_iter().chain(more).map(document).collect()
}

impl Document {
    fn named(name: &str) -> Document {
        let mut all = documents().into_iter();
        all.find(|document| document.name == name)
            .expect("a document")
    }

    /// What stands in backticks, blocks of code apart.
    fn spans(&self) -> Vec<String> {
        let (mut prose, mut is_code) = (String::new(), false);
        for line in self.text.lines() {
            if line.trim_start().starts_with("```") {
                is_code = !is_code;
            } else if !is_code {
                prose += line;
                prose.push('\n');
            }
        }
        let parts: Vec<&str> = prose.split('`').collect();
        assert!(!is_code && parts.len() % 2 == 1, "{}", self.name);
        parts
            .iter()
            .skip(1)
            .step_by(2)
            .map(|s| s.to_string())
            .collect()
    }

    /// The text with every gap a single space.
    fn unwrapped(&self) -> String {
        self.text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The words that follow `before`.
    fn words_after(&self, before: &str) -> Vec<String> {
        let is_inside = |c: char| c.is_alphanumeric() || "_-".contains(c);
        let word = |rest: &str| rest.split(|c| !is_inside(c)).next().map(String::from);
        let text = self.unwrapped();
        text.split(before).skip(1).filter_map(word).collect()
    }
}

/// Whether a path exists, its last part perhaps with one `*`, from the root or from a crate's sources.
fn exists(path: &str) -> bool {
    let sources = CRATES.iter().map(|(_, folder)| *folder);
    let mut bases = sources.chain([""]).map(|base| root().join(base).join(path));
    bases.any(|path| {
        let last = path.file_name().and_then(|name| name.to_str());
        let Some((head, tail)) = last.and_then(|name| name.split_once('*')) else {
            return path.exists();
        };
        let siblings = path.parent().map(entries).unwrap_or_default();
        let names = siblings
            .iter()
            .filter_map(|path| path.file_name()?.to_str());
        names.into_iter().any(|name| {
            let rest = name.strip_prefix(head);
            rest.is_some_and(|rest| rest.ends_with(tail))
        })
    })
}

#[test]
fn paths_exist() {
    assert!(exists("contact/rows.rs") && exists("freefem/reference/*.json"));
    assert!(!exists("contact/columns.rs") && !exists("freefem/*.json"));
    let is_path = |span: &String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "/._-*".contains(c);
        span.contains('/') && !span.starts_with("out/") && span.chars().all(plain)
    };
    for document in documents() {
        for path in document.spans().into_iter().filter(is_path) {
            assert!(exists(&path), "{}: `{path}` does not exist", document.name);
        }
        let folder = root().join(&document.name);
        let folder = folder.parent().expect("a folder");
        for link in document.text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap_or_default();
            if !target.contains("://") {
                let found = folder.join(target).exists();
                assert!(found, "{}: link to {target}", document.name);
            }
        }
    }
}

#[test]
fn source_files_that_are_named_alone_exist() {
    let folders = CRATES.iter().map(|(_, sources)| *sources);
    let folders = folders.chain(["examples", "tests", "benches", "ipopt-sys/build"]);
    let files: Vec<PathBuf> = folders.flat_map(|f| rust_files(&root().join(f))).collect();
    let has = |name: &str| {
        files
            .iter()
            .any(|path| path.file_name().is_some_and(|n| n == name))
    };
    assert!(has("rows.rs") && !has("columns.rs"));
    for document in documents() {
        let spans = document.spans().into_iter();
        for name in spans.filter(|span| span.ends_with(".rs") && !span.contains('/')) {
            assert!(has(&name), "{}: `{name}` does not exist", document.name);
        }
    }
}

/// A crate's sources.
struct Sources {
    name: &'static str,
    folder: PathBuf,
    files: Vec<(PathBuf, String)>,
}

impl Sources {
    fn all() -> Vec<Sources> {
        let of = |(name, folder): (&'static str, &str)| {
            let folder = root().join(folder);
            let files = rust_files(&folder).into_iter();
            let files = files.map(|path| (path.clone(), read(path))).collect();
            Sources {
                name,
                folder,
                files,
            }
        };
        CRATES.map(of).into()
    }

    fn text(&self, path: &Path) -> Option<&str> {
        let mut files = self.files.iter();
        files
            .find(|(file, _)| file == path)
            .map(|(_, text)| text.as_str())
    }

    /// Whether a type or trait with these members is declared: each in a file with the type or an `impl` of it.
    fn has_type(&self, name: &str, members: &[&str]) -> bool {
        let mut files = self.files.iter();
        let owners: Vec<_> = self
            .files
            .iter()
            .filter(|(_, text)| owns(text, name))
            .collect();
        let has = |member: &&str| owners.iter().any(|(_, text)| declares(text, member));
        files.any(|(_, text)| declares(text, name)) && members.iter().all(has)
    }

    /// Whether a path from the crate's root leads through its modules to an item, and on to what the crate declares.
    fn has(&self, segments: &[&str]) -> bool {
        let (mut folder, mut module) =
            (self.folder.clone(), self.text(&self.folder.join("lib.rs")));
        for (k, segment) in segments.iter().enumerate() {
            let file = self.text(&folder.join(format!("{segment}.rs")));
            let file = file.or_else(|| self.text(&folder.join(segment).join("mod.rs")));
            if file.is_none() {
                let found = module.is_some_and(|text| declares(text, segment));
                let members = &segments[k + 1..];
                return found && (members.is_empty() || self.has_type(segment, members));
            }
            (folder, module) = (folder.join(segment), file);
        }
        true
    }
}

/// Whether a text has a declaration of a type, or an `impl` of or for it.
fn owns(text: &str, name: &str) -> bool {
    let starts = ["impl", "pub struct ", "pub enum ", "pub trait "];
    let mut heads = text
        .lines()
        .filter(|line| starts.iter().any(|s| line.starts_with(s)));
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    heads.any(|head| head.split(|c| !is_part(c)).any(|word| word == name))
}

/// Whether a text declares or re-exports something of this name.
fn declares(text: &str, word: &str) -> bool {
    let is_whole = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
    let starts = |code: &str| {
        let rest = code.trim_start().strip_prefix(word);
        rest.filter(|rest| is_whole(rest.chars().next()))
            .map(str::to_string)
    };
    let mut is_export = false;
    text.lines().any(|line| {
        let code = line.split("//").next().unwrap_or_default().trim();
        is_export |= code.starts_with("pub use ");
        if is_export {
            is_export = !code.ends_with(';');
            let mut names = code.split(|c: char| !c.is_alphanumeric() && c != '_');
            return names.any(|name| name == word);
        }
        let bare = code.strip_prefix("pub").map_or(code, |rest| {
            let inner = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
            inner.map_or(rest, |(_, rest)| rest).trim_start()
        });
        let keywords = ["fn", "struct", "enum", "trait", "type", "mod", "const"];
        let mut named = keywords
            .iter()
            .filter_map(|keyword| bare.strip_prefix(keyword));
        let is_named = named.any(|rest| rest.starts_with(' ') && starts(rest).is_some());
        // a variant, or a public field
        let is_part = starts(bare).is_some_and(|rest| match bare == code {
            true => rest == "," || rest.starts_with('(') || rest == " {",
            false => rest.starts_with(':'),
        });
        is_named || is_part
    })
}

/// Types and paths that the map of the house names.
#[test]
fn items_of_the_architecture_exist() {
    let sources = Sources::all();
    let found = |item: &str| {
        let segments: Vec<&str> = item.split("::").collect();
        let of_crate = sources.iter().find(|sources| sources.name == segments[0]);
        match of_crate {
            Some(sources) => sources.has(&segments[1..]),
            None => sources.iter().any(|sources| {
                let is_type = item.starts_with(char::is_uppercase);
                sources.has(&segments) || is_type && sources.has_type(segments[0], &segments[1..])
            }),
        }
    };
    for item in [
        "contact_core::gaps::LinearGaps",
        "model::Passes::Both",
        "Problem::lift",
    ] {
        assert!(found(item), "{item}");
    }
    for item in [
        "contact_core::fixed_point",
        "model::Passes::Neither",
        "Problem::drop",
    ] {
        assert!(!found(item), "{item}");
    }
    let mut named = 0;
    for span in Document::named("ARCHITECTURE.md").spans() {
        let item = span.split(['(', '<']).next().unwrap_or_default();
        let plain = |c: char| c.is_ascii_alphanumeric() || "_:".contains(c);
        let is_type = item.starts_with(char::is_uppercase) && item.contains(char::is_lowercase);
        if item.chars().all(plain) && (item.contains("::") || is_type) {
            assert!(found(item), "`{span}` does not exist");
            named += 1;
        }
    }
    assert!(named > 20, "{named} items in ARCHITECTURE.md");
}

/// README's table has every example and no other; whatever is run by name exists.
#[test]
fn examples_exist() {
    let name = |path: &PathBuf| Some(path.file_stem()?.to_str()?.to_string());
    let names = |folder: &str| {
        let mut names: Vec<String> = rust_files(&root().join(folder))
            .iter()
            .filter_map(name)
            .collect();
        names.sort();
        names
    };
    let examples = names("examples");
    let readme = Document::named("README.md");
    let table = readme.text.split("| example | what |\n").nth(1);
    let rows = table.expect("a table").lines().skip(1);
    let rows = rows.map_while(|line| line.strip_prefix("| `"));
    let mut listed: Vec<&str> = rows.filter_map(|row| row.split('`').next()).collect();
    listed.sort_unstable();
    assert_eq!(listed, examples);

    let known = [examples, names("contact-core/examples")].concat();
    for document in documents() {
        for name in document.words_after("--example ") {
            let is_known = name == "NAME" || known.contains(&name);
            assert!(is_known, "{}: example {name}", document.name);
        }
    }
}

#[test]
fn targets_of_make_exist() {
    let makefile = read("Makefile");
    let has = |target: &str| {
        makefile
            .lines()
            .any(|line| line.starts_with(&format!("{target}:")))
    };
    assert!(has("demo") && !has("make"));
    for document in documents() {
        for span in document.spans() {
            if let Some(target) = span.strip_prefix("make ") {
                assert!(has(target), "{}: `{span}`", document.name);
            }
        }
    }
}

/// "over 8 differences" wherever the memory of Anderson's acceleration is told.
#[test]
fn the_depth_of_the_acceleration_is_the_default() {
    let Acceleration::Anderson(depth) = Acceleration::default() else {
        panic!("not accelerated by default");
    };
    let mut told = 0;
    for document in documents() {
        let text = document.unwrapped();
        let before = text
            .split(" differences")
            .filter_map(|part| part.rsplit_once("over "));
        for number in before.filter_map(|(_, number)| number.parse::<usize>().ok()) {
            assert_eq!(number, depth, "{}", document.name);
            told += 1;
        }
    }
    assert!(told > 0, "no document tells the depth");
}

/// The disc-in-disc's results as README shows them are those that `tests/scenes/disc_in_disc.rs` asserts.
#[test]
fn results_of_the_disc_in_disc_are_those_asserted() {
    let readme = Document::named("README.md").unwrapped();
    for (passes, FullLoad { energy, force }) in ENDS {
        let row = format!("| {energy} | {force} |");
        assert!(readme.contains(&row), "{passes:?}: {row}");
    }
    let FullLoad { energy, force } = DEFAULT_END;
    let row = format!("| both sides, default settings | {energy} | {force} |");
    assert!(readme.contains(&row), "{row}");
    let FullLoad { energy, force } = EXACT_END;
    let exact = format!("an energy of {energy} and a force of {force},");
    let pushed = format!("pushed down by {PUSH} in 100 increments");
    let scene = disc_in_disc::scene(Fineness::REFERENCE, Roles::default()).expect("a scene");
    let cells = scene.bodies().iter().map(|body| body.mesh().cells().len());
    let triangles = format!("{} linear triangles", cells.sum::<usize>());
    for told in [exact, pushed, triangles] {
        assert!(readme.contains(&told), "{told}");
    }
}

/// What an include for scripts declares outside of functions: the line without its comment, and the names.
fn declared(text: &str) -> Vec<String> {
    let types = [
        "func", "real", "int", "matrix", "mesh", "mesh3", "string", "bool", "varf", "macro",
        "NewMacro", "fespace", "border",
    ];
    let (mut depth, mut names) = (0, Vec::new());
    for line in text.lines() {
        let code = line.split("//").next().unwrap_or_default();
        let opened = |begin: char, end: char| {
            code.matches(begin).count() as isize - code.matches(end).count() as isize
        };
        let words: Vec<&str> = code
            .split(|c: char| !c.is_alphanumeric())
            .filter(|word| !word.is_empty())
            .collect();
        let kind = words.first().copied().unwrap_or_default();
        if depth == 0 && types.contains(&kind) {
            let is_value = !["func", "macro", "NewMacro", "varf"].contains(&kind);
            let mut nested = 0;
            let outside = |c: char| {
                nested += isize::from("([{".contains(c)) - isize::from(")]}".contains(c));
                if nested == 0 { c } else { '.' }
            };
            let outer: String = code.chars().map(outside).collect();
            let parts = outer.split(',').take(if is_value { usize::MAX } else { 1 });
            for (k, part) in parts.enumerate() {
                let before = part.split(['=', ';', '(']).next().unwrap_or_default();
                let word = |c: char| !c.is_alphanumeric();
                let mut words = before.split(word).filter(|word| !word.is_empty());
                let name = match (k, is_value) {
                    (0, _) => words.rfind(|word| !types.contains(word)),
                    _ => words.next(),
                };
                names.extend(name.map(String::from));
            }
        }
        depth += opened('{', '}') + opened('(', ')');
        depth += isize::from(kind == "NewMacro") - isize::from(kind == "EndMacro");
    }
    names
}

/// A script may include any of these files beside its own names.
#[test]
fn names_of_includes_have_a_prefix() {
    let prefixes = [
        ("beams.idp", "beams", 40),
        ("beams_results.idp", "beams", 3),
        ("contact2d.idp", "contact", 10),
        ("contact3d.idp", "contact", 40),
        ("contact_result.idp", "contactresult", 8),
        ("discs.idp", "discs", 10),
        ("energies.idp", "energy", 10),
        ("neo_hookean2d.idp", "nh", 40),
        ("neo_hookean3d.idp", "nh", 40),
        ("run.idp", "run", 8),
    ];
    let files = entries(&root().join("freefem"));
    let is_include = |path: &&PathBuf| path.extension().is_some_and(|end| end == "idp");
    assert_eq!(files.iter().filter(is_include).count(), prefixes.len());
    for (file, prefix, least) in prefixes {
        let names = declared(&read(Path::new("freefem").join(file)));
        assert!(names.len() >= least, "{file}: {names:?}");
        for name in &names {
            assert!(name.to_lowercase().starts_with(prefix), "{file}: {name}");
        }
    }
    let text = "int a = 1, b[2] = [1, c];\nfunc real e(int f)\n{\n    int g;\n}\nreal[int] h(3); // int i\n";
    assert_eq!(declared(text), ["a", "b", "e", "h"]);
}

/// `name#E` in a macro with a parameter E would take the parameter's value.
#[test]
fn what_macros_declare_is_none_of_their_parameters() {
    let text = read("freefem/energies.idp");
    let mut macros = 0;
    for part in text.split("NewMacro ").skip(1) {
        let (head, body) = part.split_once(')').expect("parameters");
        let (name, parameters) = head.split_once('(').expect("parameters");
        let parameters: Vec<&str> = parameters.split(", ").collect();
        let body = body.split("EndMacro").next().unwrap_or_default();
        for suffix in body.split("name#").skip(1) {
            let suffix = suffix.split(|c: char| !c.is_alphanumeric()).next();
            let suffix = suffix.unwrap_or_default();
            assert!(!parameters.contains(&suffix), "{name}: name#{suffix}");
        }
        macros += 1;
    }
    assert!(macros >= 6, "{macros}");
}
