//! The library speaks to users of Rust and of scene files alike. Here its words become those of a file: keys in place of Rust's names.

use std::borrow::Cow;

/// What a scene file calls the names of Rust that texts of the library have. Longer texts come before those that they begin with.
const KEYS: [(&str, &str); 34] = [
    (
        "`Condensed` does not treat `Energy::is_quadratic` = false",
        "the solver condensed takes laws for small strains alone, without pressures that follow",
    ),
    (
        "`Condensed` does not treat `LinearGaps::is_exact` = false",
        "the solver condensed takes contact in the reference geometry alone",
    ),
    (
        "`Literal` does not treat contact with friction = true",
        "the solver literal takes contact without friction alone",
    ),
    (
        "`FixedPoint` does not treat friction by rows of integration points = true",
        "`method = \"penalty\"` takes contact without friction alone",
    ),
    (
        "such as `InteriorPoint`",
        "such as `method = \"interior-point\"`",
    ),
    ("solve by `CondensedNewton`", "take `solver = \"newton\"`"),
    ("solve by `FixedPoint`", "take `solver = \"ipopt\"`"),
    (
        "`Scene::geometry` to `Geometry::Reference` or `Geometry::Current`",
        "`geometry` to \"reference\" or \"current\"",
    ),
    ("`Geometry::Current`", "`geometry = \"current\"`"),
    ("`Geometry::Reference`", "`geometry = \"reference\"`"),
    (
        "set `Scene::integration` to `Integration::Exact`",
        "take `integration = \"exact\"`",
    ),
    ("`Scene::overlaps`", "`overlaps`"),
    ("`Scene::overlap_tolerance`", "`overlap-tolerance`"),
    ("`Scene::initial_gaps`", "`initial-gaps`"),
    ("`Scene::reach`", "`reach`"),
    ("`Scene::contact`", "`[[contact]]`"),
    ("`self_contact`", "`self`"),
    ("`Tie::tolerance`", "`tolerance`"),
    ("`of_revolution_with_laws`", "`laws`"),
    ("`Body::with_averaged_volumes`", "`averaged-volumes = true`"),
    ("`Body::new`", "a body without it"),
    ("`Body::symmetry`", "`symmetry`"),
    ("`Body::during`", "`during`"),
    ("`Amplitude::table`", "a list of times and values"),
    ("`Mesh::translated`", "`translated`"),
    ("`Mesh::join_boundaries`", "`boundaries`"),
    ("`Mesh::quadratic`", "`quadratic = true`"),
    ("make it `quadratic()` first", "give it `quadratic = true`"),
    ("`Mesh::curved`", "`curved`"),
    ("let it not turn (`Body::rigid`)", "take `law = \"rigid\"`"),
    ("`MeshFile::body`", "`region`"),
    (" (`merge-nodes`, `MeshFile::merged`)", " (`merge-nodes`)"),
    ("`NeoHookean`", "`neo-hookean`"),
    (", or None for the default", ", or leave the key out"),
];

/// What a scene file calls settings of the library.
const SETTINGS: [(&str, &str); 34] = [
    ("setting `", "`"),
    ("`phase until`", "`until`"),
    ("`phase increments`", "`increments`"),
    ("`phase least step`", "`least-step`"),
    ("`phase largest step`", "`largest-step`"),
    ("`max_iterations`", "`max-iterations`"),
    ("`ipopt_tolerance`", "`ipopt-tolerance`"),
    ("`integration` = ", "`points` = "),
    ("`overlap_tolerance`", "`overlap-tolerance`"),
    ("`contact_surface` = ", "the number of `surfaces` = "),
    ("`tie tolerance`", "`tolerance`"),
    ("`obstacle's radius`", "`radius`"),
    ("`obstacle's edge`", "`high` minus `low`"),
    ("`obstacle's normal`", "the length of `normal`"),
    (
        "`components of the obstacle's axis`",
        "the number of components of `axis`",
    ),
    ("`obstacle's axis`", "the length of `axis`"),
    (
        "`components of the rotation's axis`",
        "the number of components of `axis`",
    ),
    ("`rotation's axis`", "the length of `axis`"),
    (
        "`length of the direction of a support`",
        "the length of `along`",
    ),
    (
        "`end of the interval in which a support holds`",
        "a time of `during`",
    ),
    (
        "`end of the interval in which contact counts`",
        "a time of `during`",
    ),
    ("`stiffness of a foundation`", "`stiffness`"),
    ("`share of the second invariant`", "`share`"),
    ("`exponent of Ogden's law`", "an exponent of `terms`"),
    (
        "`twice the shear modulus, the sum of the terms' products of modulus and exponent`",
        "twice the shear modulus, the sum of the products of each pair of `terms`,",
    ),
    ("`cells` = ", "the number of cells = "),
    ("`plane.order()` = ", "the order of the mesh `plane` = "),
    ("`order` = ", "the order of the mesh = "),
    ("`radii[0]`", "the first of `radii`"),
    ("at load factor ", "at time "),
    ("load factors", "times"),
    ("load factor", "time"),
    ("load increments", "increments"),
    ("load step", "increment"),
];

/// What a user of TOML calls what the parser names.
const PARSER: [(&str, &str); 18] = [
    ("TOML parse error at line", "line"),
    ("expected usize", "expected a whole number from 0"),
    ("expected u64", "expected a whole number from 0"),
    ("expected i64", "expected a whole number"),
    ("expected i32", "expected a whole number"),
    ("expected f64", "expected a number"),
    (
        "wanted string or table",
        "expected a word in quotes, or a table",
    ),
    ("expected a boolean", "expected true or false"),
    ("expected a sequence", "expected a list"),
    ("expected a map", "expected a table"),
    ("expected a tuple of size 2", "expected a pair"),
    ("expected an array of length 2", "expected a pair"),
    ("expected an array of length 3", "expected a list of three"),
    ("invalid type: sequence", "this is a list"),
    ("invalid type: map", "this is a table"),
    ("unknown field", "there is no key"),
    ("unknown variant", "there is no value"),
    ("missing field", "a key is missing:"),
];

/// A text of the library in the words of a scene file: keys and values in place of Rust's names, and time for the load factor.
///
/// ```
/// use ipopt_contact::scene_file::in_keys;
///
/// assert_eq!(in_keys("set `Scene::reach`"), "set `reach`");
/// ```
pub fn in_keys(text: &str) -> Cow<'_, str> {
    let all = KEYS.iter().chain(&SETTINGS);
    replaced(text, all)
}

/// What the parser says, in the words of a scene file.
pub(super) fn of_keys(text: &str) -> Cow<'_, str> {
    let mut text = replaced(text, PARSER.iter());
    // a table is expected where a type of the sources is named
    for kind in ["expected struct ", "expected enum "] {
        while let Some(at) = text.find(kind) {
            let name = &text[at + kind.len()..];
            let length = name.find(|c: char| !c.is_alphanumeric());
            let end = at + kind.len() + length.unwrap_or(name.len());
            text.to_mut().replace_range(at..end, "expected a table");
        }
    }
    text
}

fn replaced<'a>(text: &'a str, all: impl Iterator<Item = &'a (&'a str, &'a str)>) -> Cow<'a, str> {
    all.fold(Cow::Borrowed(text), |text, (from, to)| {
        match text.contains(from) {
            true => Cow::Owned(text.replace(from, to)),
            false => text,
        }
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    /// What users of Rust alone meet, with solvers, drivers, laws and functions of their own; and texts that are in the table together
    /// with what is told around them.
    const OF_RUST: [&str; 13] = [
        "Problem::",
        "Solver::",
        "Options::",
        "Nlp::",
        "Equilibrium::",
        "LoadSteps::",
        "Obstacle::signed_distance",
        "material::conformance",
        "Energy::is_quadratic",
        "LinearGaps::is_exact",
        "check::energy",
        "Snapshot::",
        "crate::",
    ];

    /// The lines of code of the library, without those of tests; texts that go on in the next line are one.
    fn code() -> Vec<String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut folders = vec![root.join("contact-fem/src"), root.join("contact-core/src")];
        let mut lines = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|kind| kind == "rs")
                    && !path.ends_with("tests.rs")
                {
                    let text = fs::read_to_string(path).expect("a text");
                    let text = text.split("#[cfg(test)]\nmod tests {").next();
                    let mut whole = String::new();
                    for line in text.unwrap_or_default().lines() {
                        let line = line.trim();
                        match line.strip_suffix('\\') {
                            Some(part) => whole += part,
                            None => lines.push(std::mem::take(&mut whole) + line),
                        }
                    }
                }
            }
        }
        lines.retain(|line| !line.starts_with("//"));
        assert!(lines.len() > 10_000, "{}", lines.len());
        lines
    }

    /// Whatever path of Rust a text of the library has, a scene file has words for it.
    #[test]
    fn no_text_of_the_library_keeps_a_path_of_rust() {
        let mut met = 0;
        for line in code() {
            let texts = line.split('"').skip(1).step_by(2);
            for text in texts.filter(|text| text.contains("::")) {
                met += 1;
                let told = in_keys(text);
                let others = OF_RUST.iter().any(|own| told.contains(own));
                assert!(others || !told.contains("::"), "{told}");
            }
        }
        assert!(met > 15, "{met}");
    }

    /// No words are kept for what the library does not say any more.
    #[test]
    fn all_words_are_of_the_library() {
        let code = code();
        for (from, _) in KEYS.iter().chain(&SETTINGS) {
            let name = from.trim_matches(['`', ' ', '=']);
            let is_said =
                |line: &String| line.contains(from) || line.contains(&format!("\"{name}"));
            // said by two parts of a message
            let is_joined = from.contains("does not treat");
            assert!(is_joined || code.iter().any(is_said), "{from}");
        }
    }

    #[test]
    fn types_of_the_sources_are_called_tables() {
        let told = of_keys("invalid type: integer `3`, expected struct BodyKeys");
        assert_eq!(told, "invalid type: integer `3`, expected a table");
        assert_eq!(of_keys("expected f64"), "expected a number");
    }
}
