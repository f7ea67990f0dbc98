//! What this program was built from, and which linear algebra it runs on.

use std::fmt;
use std::path::PathBuf;

use super::{Blas, Libraries};

/// What a report should say about the program that made it; its `Display` form is a few lines of text.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Versions {
    /// The version of `ipopt-contact` and its crates.
    pub ipopt_contact: &'static str,
    /// The version of Ipopt that was found at build time; empty if there was none, as where only documentation is
    /// made.
    pub ipopt: &'static str,
    /// The libraries that came with Ipopt according to pkg-config at build time, `ipopt` itself included.
    pub ipopt_libraries: Vec<&'static str>,
    /// The file name of the linear solver that came with Ipopt, if it is a library of its own and the system tells.
    pub linear_solver: Option<String>,
    /// The BLAS this process has loaded, if that can be told.
    pub blas: Option<Blas>,
    /// The compiler, as `rustc --version` puts it.
    pub rustc: &'static str,
    /// Cargo's kind of profile, `debug` or `release`.
    pub profile: &'static str,
}

/// What this program was built from, and which linear algebra it runs on.
///
/// ```
/// let versions = contact_core::ipopt::versions();
/// assert_eq!(versions.ipopt_contact, env!("CARGO_PKG_VERSION"));
/// println!("{versions}");
/// ```
pub fn versions() -> Versions {
    let loaded = Libraries::loaded();
    let file_name = |path: PathBuf| Some(path.file_name()?.to_string_lossy().into_owned());
    Versions {
        ipopt_contact: env!("CARGO_PKG_VERSION"),
        ipopt: env!("IPOPT_CONTACT_IPOPT_VERSION"),
        ipopt_libraries: words(env!("IPOPT_CONTACT_IPOPT_LIBS")),
        linear_solver: loaded.linear_solver.and_then(file_name),
        blas: loaded.blas,
        rustc: env!("IPOPT_CONTACT_RUSTC"),
        profile: env!("IPOPT_CONTACT_PROFILE"),
    }
}

impl fmt::Display for Versions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_unknown = |text: &'static str| match text.is_empty() {
            true => "unknown",
            false => text,
        };
        writeln!(
            f,
            "ipopt-contact {} ({}, {})",
            self.ipopt_contact,
            or_unknown(self.rustc),
            self.profile
        )?;
        writeln!(
            f,
            "Ipopt {} ({})",
            or_unknown(self.ipopt),
            self.ipopt_libraries.join(", ")
        )?;
        writeln!(
            f,
            "linear solver: {}",
            self.linear_solver.as_deref().unwrap_or("unknown")
        )?;
        match &self.blas {
            Some(blas) => write!(f, "BLAS: {blas}"),
            None => write!(f, "BLAS: unknown"),
        }
    }
}

fn words(list: &'static str) -> Vec<&'static str> {
    list.split(',').filter(|word| !word.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_with_ipopt_knows_its_version() {
        let versions = versions();
        assert!(versions.ipopt.starts_with("3."), "{versions:?}");
        assert!(versions.ipopt_libraries.contains(&"ipopt"), "{versions:?}");
        assert!(versions.rustc.starts_with("rustc "), "{versions:?}");
        assert!(versions.to_string().contains(versions.ipopt));
    }
}
