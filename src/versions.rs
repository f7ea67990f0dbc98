//! What this program was built from, and which linear algebra it runs on.

use std::fmt;
use std::path::{Path, PathBuf};

/// What a report should say about the program that made it; its `Display` form is a few lines of text.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Versions {
    /// The version of this crate.
    pub ipopt_contact: &'static str,
    /// The version of Ipopt that was found at build time; empty if there was none, as where only documentation is
    /// made.
    pub ipopt: &'static str,
    /// The libraries that came with Ipopt according to pkg-config at build time, `ipopt` itself included.
    pub ipopt_libraries: Vec<&'static str>,
    /// The linear solver that came with Ipopt: the file name of the loaded library or, where that cannot be told, its
    /// name at build time.
    pub linear_solver: Option<String>,
    /// The BLAS this process has loaded, if that can be told.
    pub blas: Option<Blas>,
    /// The compiler, as `rustc --version` puts it.
    pub rustc: &'static str,
    /// Cargo's kind of profile, `debug` or `release`.
    pub profile: &'static str,
}

/// The BLAS a process has loaded: nearly all of a solve's time goes into it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Blas {
    /// The file, symbolic links resolved.
    pub path: PathBuf,
    /// Whose it is, as far as its path tells.
    pub kind: BlasKind,
}

/// Implementations of BLAS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BlasKind {
    /// OpenBLAS.
    OpenBlas,
    /// The reference implementation: correct, and several times slower than any other.
    Reference,
    /// ATLAS.
    Atlas,
    /// Intel's MKL.
    Mkl,
    /// BLIS.
    Blis,
    /// A path that does not say.
    Unknown,
}

/// What this program was built from, and which linear algebra it runs on.
///
/// ```
/// let versions = ipopt_contact::versions();
/// assert_eq!(versions.ipopt_contact, env!("CARGO_PKG_VERSION"));
/// println!("{versions}");
/// ```
pub fn versions() -> Versions {
    let ipopt_libraries: Vec<&str> = words(env!("IPOPT_CONTACT_IPOPT_LIBS"));
    let maps = maps();
    let linear_solver = linear_solver(&maps).or_else(|| {
        let mut libraries = ipopt_libraries.iter();
        libraries
            .find(|name| is_linear_solver(name))
            .map(|name| (*name).to_owned())
    });
    Versions {
        ipopt_contact: env!("CARGO_PKG_VERSION"),
        ipopt: env!("IPOPT_CONTACT_IPOPT_VERSION"),
        ipopt_libraries,
        linear_solver,
        blas: Blas::find(&maps),
        rustc: env!("IPOPT_CONTACT_RUSTC"),
        profile: env!("IPOPT_CONTACT_PROFILE"),
    }
}

impl Blas {
    /// The BLAS this process has loaded. `None` where the system does not tell (it does on Linux), or if no BLAS is
    /// loaded as a shared library.
    pub fn loaded() -> Option<Self> {
        Self::find(&maps())
    }

    /// Whether it is the slow reference implementation.
    pub fn is_reference(&self) -> bool {
        self.kind == BlasKind::Reference
    }

    fn find(maps: &str) -> Option<Self> {
        // `libblas` is what others are linked to; it may load the real one, but its directory says whose it is.
        let prefixes = [
            "libblas",
            "libopenblas",
            "libmkl_rt",
            "libblis",
            "libsatlas",
            "libtatlas",
            "libflexiblas",
        ];
        let path = prefixes
            .iter()
            .find_map(|prefix| find_file(maps, |name| name.starts_with(prefix)))?;
        Some(Blas {
            path: path.to_owned(),
            kind: BlasKind::of(path),
        })
    }
}

impl BlasKind {
    fn of(path: &Path) -> Self {
        let text = path.to_string_lossy().to_lowercase();
        let directory = path.parent().and_then(Path::file_name);
        match () {
            () if text.contains("openblas") => Self::OpenBlas,
            () if text.contains("mkl") => Self::Mkl,
            () if text.contains("blis") => Self::Blis,
            () if text.contains("atlas") => Self::Atlas,
            // Debian and Ubuntu: /usr/lib/x86_64-linux-gnu/blas/libblas.so.3.11.0
            () if directory.is_some_and(|name| name == "blas") => Self::Reference,
            () => Self::Unknown,
        }
    }
}

impl fmt::Display for BlasKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenBlas => "OpenBLAS",
            Self::Reference => "reference BLAS (slow)",
            Self::Atlas => "ATLAS",
            Self::Mkl => "MKL",
            Self::Blis => "BLIS",
            Self::Unknown => "BLAS of unknown make",
        })
    }
}

impl fmt::Display for Blas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.kind, self.path.display())
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

/// What the kernel says is mapped into this process, one mapping a line; empty where there is no such file.
fn maps() -> String {
    std::fs::read_to_string("/proc/self/maps").unwrap_or_default()
}

fn linear_solver(maps: &str) -> Option<String> {
    let solver = |name: &str| name.strip_prefix("lib").is_some_and(is_linear_solver);
    let path = find_file(maps, solver)?;
    Some(path.file_name()?.to_string_lossy().into_owned())
}

/// Whether this is a library of a solver for sparse symmetric systems that Ipopt knows.
fn is_linear_solver(name: &str) -> bool {
    ["dmumps", "coinmumps", "coinhsl", "hsl", "spral", "pardiso"]
        .iter()
        .any(|solver| name.starts_with(solver))
}

/// The first mapped file with such a name.
fn find_file(maps: &str, named: impl Fn(&str) -> bool) -> Option<&Path> {
    // address permissions offset device inode path
    maps.lines()
        .filter_map(|line| line.find('/').map(|at| Path::new(&line[at..])))
        .find(|path| {
            path.file_name()
                .is_some_and(|name| named(&name.to_string_lossy()))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blas(path: &str) -> Blas {
        let maps = format!(
            "7f00-7f01 r-xp 00000000 fe:00 11   /usr/lib/x86_64-linux-gnu/libgslcblas.so.0.0.0\n\
             7f02-7f03 r-xp 00000000 fe:00 12   {path}\n\
             7f04-7f05 rw-p 00000000 00:00 0    [stack]\n"
        );
        Blas::find(&maps).expect("mapped")
    }

    #[test]
    fn the_path_tells_whose_blas_it_is() {
        for (path, kind) in [
            (
                "/usr/lib/x86_64-linux-gnu/openblas-serial/libblas.so.3",
                BlasKind::OpenBlas,
            ),
            (
                "/usr/lib/x86_64-linux-gnu/blas/libblas.so.3.11.0",
                BlasKind::Reference,
            ),
            (
                "/usr/lib/x86_64-linux-gnu/atlas/libblas.so.3.10.3",
                BlasKind::Atlas,
            ),
            (
                "/usr/lib/x86_64-linux-gnu/blis-serial/libblas.so.3",
                BlasKind::Blis,
            ),
            ("/opt/intel/mkl/lib/libmkl_rt.so.2", BlasKind::Mkl),
            ("/usr/lib64/libopenblasp-r0.3.26.so", BlasKind::OpenBlas),
            ("/usr/lib64/libblas.so.3", BlasKind::Unknown),
        ] {
            let found = blas(path);
            assert_eq!((found.path.as_path(), found.kind), (Path::new(path), kind));
            assert_eq!(found.is_reference(), kind == BlasKind::Reference);
        }
    }

    #[test]
    fn no_blas_no_answer() {
        assert_eq!(Blas::find(""), None);
        assert_eq!(
            Blas::find("7f00-7f01 r-xp 0 fe:00 11   /usr/lib/libgslcblas.so.0\n"),
            None
        );
    }

    #[test]
    fn the_linear_solver_is_named_by_its_file() {
        let maps = "7f00-7f01 r-xp 0 fe:00 1 /usr/lib/libdmumps_seq-5.5.so\n";
        assert_eq!(linear_solver(maps).as_deref(), Some("libdmumps_seq-5.5.so"));
        assert_eq!(
            linear_solver("7f00-7f01 r-xp 0 fe:00 1 /usr/lib/libm.so.6\n"),
            None
        );
    }

    #[test]
    fn a_build_with_ipopt_knows_its_version() {
        let versions = versions();
        assert!(versions.ipopt.starts_with("3."), "{versions:?}");
        assert!(versions.ipopt_libraries.contains(&"ipopt"), "{versions:?}");
        assert!(versions.rustc.starts_with("rustc "), "{versions:?}");
        assert!(versions.to_string().contains(versions.ipopt));
    }
}
