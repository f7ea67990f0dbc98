//! Where Ipopt is, according to pkg-config.

use std::path::{Path, PathBuf};

/// Ipopt as pkg-config sees it.
pub struct Ipopt {
    pub library: pkg_config::Library,
    /// Where `libipopt` itself is, unless the linker looks there anyway.
    pub search_path: Option<PathBuf>,
}

pub fn find() -> Result<Ipopt, String> {
    let library = pkg_config::Config::new()
        .cargo_metadata(false)
        .env_metadata(true)
        .probe("ipopt")
        .map_err(|error| match error {
            pkg_config::Error::Command { .. } => "ipopt-contact-sys needs `pkg-config` to find Ipopt, and could not run it. \
                 Install it (Debian, Ubuntu: `apt-get install pkg-config`)."
                .to_owned(),
            _ => "ipopt-contact-sys found no Ipopt: `pkg-config ipopt` failed. \
                 Install its development files (Debian, Ubuntu: `apt-get install coinor-libipopt-dev`; \
                 macOS: `brew install ipopt`), or point PKG_CONFIG_PATH at the directory with ipopt.pc."
                .to_owned(),
        })?;
    let search_path = pkg_config::get_variable("ipopt", "libdir")
        .ok()
        .map(PathBuf::from)
        .filter(|path| path.is_absolute() && !is_standard(path));
    for path in &library.include_paths {
        // An upgrade in place changes it.
        println!(
            "cargo::rerun-if-changed={}",
            path.join("IpoptConfig.h").display()
        );
    }
    Ok(Ipopt {
        library,
        search_path,
    })
}

impl Ipopt {
    /// `-D` flags of the `.pc` file, such as HAVE_CSTDDEF, without which the C++ headers of 3.11 refuse to compile.
    pub fn defines(&self) -> impl Iterator<Item = String> + '_ {
        self.library
            .defines
            .iter()
            .map(|(name, value)| match value {
                Some(value) => format!("-D{name}={value}"),
                None => format!("-D{name}"),
            })
    }

    /// A C++ compiler that sees Ipopt's headers by their bare names, whether they live in coin/ or in coin-or/.
    pub fn compiler(&self) -> cc::Build {
        let mut build = cc::Build::new();
        build
            .cpp(true)
            .std("c++14")
            .include("src")
            .flag_if_supported("-Wno-deprecated-declarations");
        for path in &self.library.include_paths {
            // System headers, so that their warnings stay theirs.
            build.flag("-isystem").flag(path);
        }
        for define in self.defines() {
            build.flag(define);
        }
        build
    }
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
