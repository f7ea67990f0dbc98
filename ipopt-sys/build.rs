//! Finds Ipopt, binds its headers and compiles the shim.
//!
//! pkg-config is asked where Ipopt is, but not what to link: the `.pc` file of a distribution names the whole tool
//! chain of the machine that built it. The shared library brings its own dependencies.

use std::{
    env, fs, panic,
    path::{Path, PathBuf},
};

/// Ipopt as pkg-config sees it.
struct Ipopt {
    library: pkg_config::Library,
    /// Where `libipopt` itself is, unless the linker looks there anyway.
    search_path: Option<PathBuf>,
}

fn main() {
    println!("cargo::rustc-check-cfg=cfg(ipopt_3_14)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=wrapper.h");
    println!("cargo::rerun-if-changed=src/shim.h");
    println!("cargo::rerun-if-changed=src/shim.cpp");
    println!("cargo::rerun-if-env-changed=DOCS_RS");
    println!("cargo::rerun-if-env-changed=LIBCLANG_PATH");

    // Cargo turns the one message into the error a reader sees; a panic would bury it under a backtrace.
    if let Err(message) = run() {
        println!("cargo::error={message}");
    }
}

fn run() -> Result<(), String> {
    let out =
        PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: run this through cargo")?);
    let bindings = out.join("bindings.rs");
    if env::var_os("DOCS_RS").is_some() {
        // No Ipopt there: documentation is made from bindings kept in the source.
        fs::copy("src/bindings_3_11.rs", &bindings)
            .map_err(|e| format!("src/bindings_3_11.rs: {e}"))?;
        return Ok(());
    }
    let ipopt = find()?;
    bind(&ipopt, &bindings)?;
    compile(&ipopt)?;
    link(&ipopt);
    report(&ipopt);
    Ok(())
}

fn find() -> Result<Ipopt, String> {
    let library = pkg_config::Config::new()
        .cargo_metadata(false)
        .env_metadata(true)
        .probe("ipopt")
        .map_err(|error| match error {
            pkg_config::Error::Command { .. } => "ipopt-sys needs `pkg-config` to find Ipopt, and could not run it. \
                 Install it (Debian, Ubuntu: `apt-get install pkg-config`)."
                .to_owned(),
            _ => "ipopt-sys found no Ipopt: `pkg-config ipopt` failed. \
                 Install its development files (Debian, Ubuntu: `apt-get install coinor-libipopt-dev`; \
                 macOS: `brew install ipopt`), or point PKG_CONFIG_PATH at the directory with ipopt.pc."
                .to_owned(),
        })?;
    let search_path = pkg_config::get_variable("ipopt", "libdir")
        .ok()
        .map(PathBuf::from)
        .filter(|path| path.is_absolute() && !is_standard(path));
    Ok(Ipopt {
        library,
        search_path,
    })
}

/// Whether every linker looks in `path` unasked.
fn is_standard(path: &Path) -> bool {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut parts = path
        .strip_prefix("/usr")
        .unwrap_or(&path)
        .to_string_lossy()
        .into_owned();
    if let Some(rest) = parts.strip_prefix('/') {
        parts = rest.to_owned();
    }
    parts == "lib"
        || parts == "lib64"
        || (parts.starts_with("lib/") && parts.ends_with("-linux-gnu"))
}

/// `-D` flags of the `.pc` file, such as HAVE_CSTDDEF, without which the C++ headers of 3.11 refuse to compile.
fn defines(ipopt: &Ipopt) -> impl Iterator<Item = String> + '_ {
    ipopt
        .library
        .defines
        .iter()
        .map(|(name, value)| match value {
            Some(value) => format!("-D{name}={value}"),
            None => format!("-D{name}"),
        })
}

fn bind(ipopt: &Ipopt, bindings: &Path) -> Result<(), String> {
    let builder = bindgen::Builder::default()
        .header("wrapper.h")
        .clang_args(ipopt.library.include_paths.iter().map(|path| format!("-I{}", path.display())))
        .clang_args(defines(ipopt))
        .clang_arg("-Isrc")
        .allowlist_function("(Add|Create|Free|Get|Open|Set)Ipopt.*|IpoptSolve|SetIntermediateCallback")
        .allowlist_type("Bool|Index|Int|Number|ipindex|ipnumber|(Eval|Intermediate)_.*|.*ReturnStatus|AlgorithmMode")
        .allowlist_item("(ipopt_shim|IPOPT_SHIM|IPOPT_VERSION).*")
        .rust_target(bindgen::RustTarget::stable(85, 0).map_err(|e| e.to_string())?)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .merge_extern_blocks(true)
        .derive_default(true)
        .formatter(bindgen::Formatter::None)
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()));

    // bindgen panics where it cannot load libclang, and returns its other errors.
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let generated = panic::catch_unwind(panic::AssertUnwindSafe(move || builder.generate()));
    panic::set_hook(hook);
    generated
        .map_err(|_| {
            "ipopt-sys reads Ipopt's headers with libclang, and could not load it. \
             Install it (Debian, Ubuntu: `apt-get install libclang-dev`) or set LIBCLANG_PATH."
                .to_owned()
        })?
        .map_err(|e| format!("ipopt-sys could not read Ipopt's headers: {e}"))?
        .write_to_file(bindings)
        .map_err(|e| format!("{}: {e}", bindings.display()))
}

fn compile(ipopt: &Ipopt) -> Result<(), String> {
    let mut build = cc::Build::new();
    build
        .cpp(true)
        .std("c++14")
        .file("src/shim.cpp")
        .include("src")
        .flag_if_supported("-Wno-deprecated-declarations");
    for path in &ipopt.library.include_paths {
        // System headers, so that their warnings stay theirs.
        build.flag("-isystem").flag(path);
    }
    for define in defines(ipopt) {
        build.flag(define);
    }
    build.try_compile("ipopt_shim").map_err(|e| {
        let reason = e.to_string().replace('\n', " ");
        format!(
            "ipopt-sys could not compile its C++ shim against Ipopt {}: {reason}. \
             It needs a C++14 compiler (Debian, Ubuntu: `apt-get install g++`) and Ipopt's C++ headers, \
             with 32-bit indices and double precision.",
            ipopt.library.version
        )
    })
}

fn link(ipopt: &Ipopt) {
    if let Some(path) = &ipopt.search_path {
        println!("cargo::rustc-link-search=native={}", path.display());
    }
    println!("cargo::rustc-link-lib=dylib=ipopt");
}

/// What a dependent's build script reads as DEP_IPOPT_VERSION and DEP_IPOPT_LIBS.
fn report(ipopt: &Ipopt) {
    let version = &ipopt.library.version;
    let mut numbers = version.split('.').map(|part| part.parse().unwrap_or(0));
    let release: (u32, u32) = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
    if release >= (3, 14) {
        println!("cargo::rustc-cfg=ipopt_3_14");
    }
    let mut libs: Vec<&str> = Vec::new();
    for lib in &ipopt.library.libs {
        if !libs.contains(&lib.as_str()) {
            libs.push(lib);
        }
    }
    println!("cargo::metadata=VERSION={version}");
    println!("cargo::metadata=LIBS={}", libs.join(","));
}
