//! Finds Ipopt, binds its headers and compiles the shim.
//!
//! pkg-config is asked where Ipopt is, but not what to link: the `.pc` file of a distribution names the whole tool
//! chain of the machine that built it. The shared library brings its own dependencies.

mod bindings;
mod locate;
mod version;

use std::{env, path::PathBuf};

use bindings::Origin;
use locate::Ipopt;
use version::{Release, Version};

fn main() {
    version::declare_cfgs();
    for path in [
        "build",
        "wrapper.h",
        "src/version_probe.cpp",
        "src/shim.h",
        "src/shim.cpp",
        "src/c_interface_check.cpp",
        "src/bindings_3_11.rs",
        "src/bindings_3_14.rs",
    ] {
        println!("cargo::rerun-if-changed={path}");
    }
    for name in ["DOCS_RS", "LIBCLANG_PATH", "LLVM_CONFIG_PATH"] {
        println!("cargo::rerun-if-env-changed={name}");
    }

    // Cargo turns the one message into the error a reader sees; a panic would bury it under a backtrace.
    if let Err(message) = run() {
        println!("cargo::error={message}");
    }
}

fn run() -> Result<(), String> {
    let out =
        PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: run this through cargo")?);
    hand_to_tests()?;
    if env::var_os("DOCS_RS").is_some() {
        // There is no Ipopt: documentation is made from the newest of the bindings kept in the source.
        version::write(version::DOCUMENTED, &out)?;
        return bindings::keep(Release::Since3_14, &out);
    }
    let ipopt = locate::find()?;
    let version = version::of_headers(&ipopt)?;
    version::write(version, &out)?;
    let origin = bindings::write(&ipopt, version, &out)?;
    compile(&ipopt, version, origin)?;
    link(&ipopt);
    report(&ipopt, version);
    Ok(())
}

/// Where this program is and what it builds for: tests run it in other surroundings.
fn hand_to_tests() -> Result<(), String> {
    let program = env::current_exe().map_err(|e| format!("the path of the build script: {e}"))?;
    println!(
        "cargo::rustc-env=IPOPT_SYS_BUILD_SCRIPT={}",
        program.display()
    );
    let target = env::var("TARGET").map_err(|e| format!("TARGET: {e}"))?;
    println!("cargo::rustc-env=IPOPT_SYS_TARGET={target}");
    Ok(())
}

fn compile(ipopt: &Ipopt, version: Version, origin: Origin) -> Result<(), String> {
    let mut build = ipopt.compiler();
    build.file("src/shim.cpp");
    if origin == Origin::Source {
        // Bindings made from other headers than these: have the compiler compare the two.
        build.file("src/c_interface_check.cpp").define(
            "IPOPT_SYS_BOOL",
            if version >= Version(3, 14, 0) {
                "bool"
            } else {
                "int"
            },
        );
    }
    build.try_compile("ipopt_shim").map_err(|e| {
        let reason = e.to_string().replace('\n', " ");
        format!(
            "ipopt-contact-sys could not compile its C++ shim against Ipopt {version}: {reason}. \
             It needs a C++14 compiler (Debian, Ubuntu: `apt-get install g++`) and Ipopt's C++ headers, \
             with 32-bit indices and double precision."
        )
    })
}

fn link(ipopt: &Ipopt) {
    if let Some(path) = &ipopt.search_path {
        println!("cargo::rustc-link-search=native={}", path.display());
    }
    println!("cargo::rustc-link-lib=dylib=ipopt");
}

/// What a dependent's build script reads as DEP_IPOPT_VERSION, DEP_IPOPT_LIBS and so on; see the crate's documentation.
fn report(ipopt: &Ipopt, version: Version) {
    let mut libs: Vec<&str> = Vec::new();
    for lib in &ipopt.library.libs {
        if !libs.contains(&lib.as_str()) {
            libs.push(lib);
        }
    }
    println!("cargo::metadata=VERSION={version}");
    println!("cargo::metadata=LIBS={}", libs.join(","));
    version::report(version);
}
