//! The bindings: generated, or kept in the source.

use std::{fs, path::Path};

#[cfg(feature = "bindgen")]
use crate::locate::Ipopt;
use crate::version::Release;

/// Takes the bindings kept in the source.
pub fn keep(release: Release, out: &Path) -> Result<(), String> {
    let kept = match release {
        Release::Since3_11 => "src/bindings_3_11.rs",
        Release::Since3_14 => "src/bindings_3_14.rs",
    };
    let bindings = out.join("bindings.rs");
    fs::copy(kept, &bindings)
        .map(|_| ())
        .map_err(|e| format!("{kept} to {}: {e}", bindings.display()))
}

/// Makes them from the headers. Comments stay behind: they are Ipopt's.
#[cfg(feature = "bindgen")]
pub fn generate(ipopt: &Ipopt, out: &Path) -> Result<(), String> {
    use std::panic;

    let bindings = out.join("bindings.rs");
    let builder = bindgen::Builder::default()
        .header("wrapper.h")
        .clang_args(ipopt.library.include_paths.iter().map(|path| format!("-I{}", path.display())))
        .clang_args(ipopt.defines())
        .clang_arg("-Isrc")
        .allowlist_function("(Add|Create|Free|Get|Open|Set)Ipopt.*|IpoptSolve|SetIntermediateCallback")
        .allowlist_type("Bool|Index|Int|Number|ipindex|ipnumber|(Eval|Intermediate)_.*|.*ReturnStatus|AlgorithmMode")
        .allowlist_item("(ipopt_shim|IPOPT_SHIM).*")
        // Not in every 3.14; src/version.rs declares it where it is.
        .blocklist_function("GetIpoptVersion")
        .rust_target(bindgen::RustTarget::stable(85, 0).map_err(|e| e.to_string())?)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .generate_comments(false)
        .disable_header_comment()
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
             Install it (Debian, Ubuntu: `apt-get install libclang-dev`), set LIBCLANG_PATH, or do without: with the \
             feature `bindgen` off (`default-features = false`, here and in the crates that depend on this one) the \
             bindings kept for Ipopt 3.11 to 3.14 are used."
                .to_owned()
        })?
        .map_err(|e| format!("ipopt-sys could not read Ipopt's headers: {e}"))?
        .write_to_file(&bindings)
        .map_err(|e| format!("{}: {e}", bindings.display()))
}
