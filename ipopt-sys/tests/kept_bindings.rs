//! The bindings kept in the source are those the headers give. With `UPDATE_BINDINGS=1` (`make bindings`) they are
//! written instead of compared.

use std::{
    env, fs,
    io::{Write, stderr},
    path::{Path, PathBuf},
    process::Command,
};

use ipopt_sys::HEADER_VERSION;

const KEPT: [&str; 2] = ["src/bindings_3_11.rs", "src/bindings_3_14.rs"];

/// The first line of a kept file, then the version of the headers it is of.
const TITLE: &str = "// Made by bindgen from the headers of Ipopt ";

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The kept file for the headers this was built with.
fn kept_for(version: (u32, u32, u32)) -> Option<PathBuf> {
    match version {
        (3, 11..=13, _) => Some(path(KEPT[0])),
        (3, 14, _) => Some(path(KEPT[1])),
        _ => None,
    }
}

/// Without what formatting changes: white space, line comments, commas at the end of lists.
fn normalised(code: &str) -> String {
    code.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(str::chars)
        .filter(|c| !c.is_whitespace() && *c != ',')
        .collect()
}

/// To the terminal even where the test passes.
fn say(text: &str) {
    let line = format!("kept bindings: {text}\n");
    // A test must not fail for want of a terminal.
    let _ = stderr().write_all(line.as_bytes());
}

fn update(kept: &Path, title: &str, generated: &str) {
    fs::write(kept, format!("{title}\n\n{generated}")).unwrap();
    let status = Command::new("rustfmt")
        .args(["--edition", "2024"])
        .arg(kept)
        .status();
    assert!(
        status.is_ok_and(|status| status.success()),
        "rustfmt failed"
    );
    say(&format!("wrote {}", kept.display()));
}

#[test]
fn are_what_the_headers_give() {
    let (major, minor, release) = HEADER_VERSION;
    let title = format!("{TITLE}{major}.{minor}.{release}; `make bindings` makes it anew.");
    let Some(kept) = kept_for(HEADER_VERSION) else {
        return say(&format!(
            "not compared, as none are kept for {major}.{minor}"
        ));
    };
    let generated = include_str!(concat!(env!("OUT_DIR"), "/bindings.rs"));
    let updating = env::var_os("UPDATE_BINDINGS").is_some();
    if generated.starts_with(TITLE) {
        assert!(
            !updating,
            "new bindings take the feature `bindgen` and libclang"
        );
        return say("not compared, as they are what this was built with");
    }
    if updating {
        update(&kept, &title, generated);
    }
    let text = fs::read_to_string(&kept).unwrap();
    let first = text.lines().next().unwrap_or_default();
    if first != title {
        return say(&format!(
            "not compared, as the headers are of {major}.{minor}.{release}, and {} says: {first}",
            kept.display()
        ));
    }
    assert!(
        normalised(&text) == normalised(generated),
        "{} differs from {}/bindings.rs: run `make bindings`",
        kept.display(),
        env!("OUT_DIR")
    );
    say(&format!("compared for Ipopt {major}.{minor}.{release}"));
}

/// Also those of the release that is not installed name what the shim offers.
#[test]
fn are_complete_and_free_of_comments() {
    let names: Vec<_> = include_str!("../src/shim.h")
        .split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .filter(|word| word.starts_with("ipopt_shim"))
        .collect();
    assert!(names.len() > 20);
    for file in KEPT {
        let kept = fs::read_to_string(path(file)).unwrap();
        assert!(kept.starts_with(TITLE), "{file}");
        for name in &names {
            assert!(
                kept.contains(name),
                "{file} lacks {name}: run `make bindings`"
            );
        }
        for layout in [
            "Size of ipopt_shim_callbacks",
            "Offset of field: ipopt_shim_point::finalized",
        ] {
            assert!(kept.contains(layout), "{file} does not assert: {layout}");
        }
        // Documentation of the headers is under Ipopt's licence.
        assert!(!kept.contains("#[doc") && !kept.contains("/*"), "{file}");
        assert_eq!(kept.matches("//").count(), 1, "{file}");
    }
}
