//! The bindings: generated, or kept in the source.

use std::{fs, path::Path};

use crate::locate::Ipopt;
use crate::version::{Release, Version};

/// Which ones a build has.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The headers found.
    Headers,
    /// This source.
    Source,
}

/// Writes bindings to `out`: from the headers, or where libclang cannot read them, or the feature `bindgen` is off,
/// those kept in the source, which exist for known releases.
pub fn write(ipopt: &Ipopt, version: Version, out: &Path) -> Result<Origin, String> {
    match generate(ipopt, out) {
        Some(Ok(())) => return Ok(Origin::Headers),
        Some(Err(reason)) => {
            let release = version.release().map_err(|e| format!("{e} {reason}"))?;
            keep(release, out)?;
            println!(
                "cargo::warning=Ipopt's headers were not read: {reason} The bindings kept for Ipopt {version} are used \
                 instead, and the C++ compiler checks them against the headers. To have them made from the headers, \
                 install libclang (Debian, Ubuntu: `apt-get install libclang-dev`) or set LIBCLANG_PATH; without the \
                 feature `bindgen` this is not tried."
            );
        }
        None => keep(version.release()?, out)?,
    }
    Ok(Origin::Source)
}

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

#[cfg(not(feature = "bindgen"))]
fn generate(_: &Ipopt, _: &Path) -> Option<Result<(), String>> {
    None
}

#[cfg(feature = "bindgen")]
fn generate(ipopt: &Ipopt, out: &Path) -> Option<Result<(), String>> {
    Some(run_bindgen(ipopt, out).map_err(|reason| {
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        format!("{}.", reason.trim_end_matches('.'))
    }))
}

/// Makes them from the headers. Comments stay behind: they are Ipopt's.
#[cfg(feature = "bindgen")]
fn run_bindgen(ipopt: &Ipopt, out: &Path) -> Result<(), String> {
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
        .map_err(|panic| match panic.downcast::<String>() {
            Ok(message) => *message,
            Err(_) => "libclang could not be loaded".to_owned(),
        })?
        .map_err(|e| e.to_string())?
        .write_to_file(&bindings)
        .map_err(|e| format!("{}: {e}", bindings.display()))
}
