//! The build script where libclang, Ipopt or both are not what it hopes for. It is run as cargo runs it, in
//! surroundings made up here.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use ipopt_sys::HEADER_VERSION;

/// A new, empty folder.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("build_script_{name}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// What the script prints for cargo, in the folder `out`.
fn run(out: &Path, surroundings: &[(&str, &Path)]) -> String {
    let output = Command::new(env!("IPOPT_SYS_BUILD_SCRIPT"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env_remove("BINDGEN_EXTRA_CLANG_ARGS")
        .env_remove("DOCS_RS")
        .env("OUT_DIR", out)
        .env("TARGET", env!("IPOPT_SYS_TARGET"))
        .env("HOST", env!("IPOPT_SYS_TARGET"))
        .env("OPT_LEVEL", "0")
        .env("DEBUG", "false")
        .envs(surroundings.iter().copied())
        .output()
        .unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{printed}");
    printed
}

/// The rest of the lines that begin so.
fn lines<'a>(printed: &'a str, start: &str) -> Vec<&'a str> {
    let rest = |line: &'a str| line.strip_prefix(start);
    printed.lines().filter_map(rest).collect()
}

fn kept(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

/// Succeeds with the bindings kept, and says so and why where it was to make its own.
fn assert_falls_back(name: &str, surroundings: &[(&str, &Path)], reason: &str) {
    let file = match HEADER_VERSION {
        (3, 11..=13, _) => "src/bindings_3_11.rs",
        (3, 14, _) => "src/bindings_3_14.rs",
        // None are kept, and none can be fallen back to.
        _ => return,
    };
    let out = folder(name);
    let printed = run(&out, surroundings);
    assert!(lines(&printed, "cargo::error=").is_empty(), "{printed}");
    let bindings = fs::read_to_string(out.join("bindings.rs")).unwrap();
    assert!(bindings == kept(file), "{name}: other bindings than {file}");
    let warnings = lines(&printed, "cargo::warning=");
    if cfg!(feature = "bindgen") {
        assert_eq!(warnings.len(), 1, "{printed}");
        for part in [reason, "kept", "libclang-dev"] {
            assert!(warnings[0].contains(part), "{part}: {}", warnings[0]);
        }
    } else {
        assert!(warnings.is_empty(), "{printed}");
    }
}

#[test]
fn without_libclang() {
    let empty = folder("no_libclang_path");
    assert_falls_back("no_libclang", &[("LIBCLANG_PATH", &empty)], "find libclang");
}

/// What is called libclang is none: Clang's C++ library by its neighbour's name, and a file of text.
#[test]
fn with_another_library_for_libclang() {
    let place = folder("false_libclang_path");
    fs::write(place.join("libclang-cpp.so.14"), "not this one either").unwrap();
    fs::write(place.join("libclang.so"), "no library").unwrap();
    assert_falls_back("false_libclang", &[("LIBCLANG_PATH", &place)], "libclang");
}

/// A libclang that comes without its own headers finds no `stddef.h`.
#[test]
fn with_a_libclang_that_cannot_read_the_headers() {
    let arguments = Path::new("-nostdinc");
    let surroundings = [("BINDGEN_EXTRA_CLANG_ARGS", arguments)];
    assert_falls_back("unreadable", &surroundings, "");
}

/// There are no bindings to fall back to: an error, which says what would help.
#[test]
fn without_libclang_for_an_ipopt_to_come() {
    let place = folder("future_ipopt");
    fs::write(
        place.join("IpoptConfig.h"),
        "#define IPOPT_VERSION_MAJOR 4\n#define IPOPT_VERSION_MINOR 1\n#define IPOPT_VERSION_RELEASE 2\n",
    )
    .unwrap();
    let package = format!(
        "Name: IPOPT\nDescription: a later one\nVersion: 4.1.2\nLibs: -lipopt\nCflags: -I{}\n",
        place.display()
    );
    fs::write(place.join("ipopt.pc"), package).unwrap();
    let empty = folder("future_libclang_path");
    let surroundings = [
        ("LIBCLANG_PATH", empty.as_path()),
        ("PKG_CONFIG_PATH", &place),
    ];
    let printed = run(&folder("future"), &surroundings);
    let errors = lines(&printed, "cargo::error=");
    assert_eq!(errors.len(), 1, "{printed}");
    for part in ["3.11 to 3.14", "4.1.2", "libclang-dev"] {
        assert!(errors[0].contains(part), "{part}: {}", errors[0]);
    }
}

/// Documentation takes neither Ipopt nor libclang.
#[test]
fn without_ipopt_for_documentation() {
    let empty = folder("no_ipopt");
    let out = folder("documentation");
    let surroundings = [
        ("DOCS_RS", Path::new("1")),
        ("LIBCLANG_PATH", &empty),
        ("PKG_CONFIG_LIBDIR", &empty),
        ("PKG_CONFIG_PATH", &empty),
    ];
    let printed = run(&out, &surroundings);
    assert!(lines(&printed, "cargo::error=").is_empty(), "{printed}");
    let bindings = fs::read_to_string(out.join("bindings.rs")).unwrap();
    assert!(bindings == kept("src/bindings_3_14.rs"));
    let elsewhere = run(&out, &surroundings[1..]);
    let errors = lines(&elsewhere, "cargo::error=");
    assert!(
        errors.len() == 1 && errors[0].contains("found no Ipopt"),
        "{errors:?}"
    );
}
