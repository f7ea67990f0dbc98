//! The shared libraries loaded by this process.

use std::{
    fmt,
    path::{Path, PathBuf},
};

/// The libraries below Ipopt that this process has loaded, as far as the system tells (Linux does).
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Libraries {
    /// Ipopt itself.
    pub ipopt: Option<PathBuf>,
    /// A linear solver Ipopt knows that is a library of its own.
    pub linear_solver: Option<PathBuf>,
    /// The BLAS.
    pub blas: Option<Blas>,
}

/// The BLAS a process has loaded: nearly all of a large solve's time goes into it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Blas {
    /// The file, symbolic links resolved.
    pub path: PathBuf,
    /// The implementation, as far as its path tells.
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
    /// Not recognisable from its path.
    Unknown,
}

impl Libraries {
    /// Those of this process.
    pub fn loaded() -> Self {
        Self::find(&maps())
    }

    fn find(maps: &str) -> Self {
        let named = |named: &dyn Fn(&str) -> bool| find_file(maps, named).map(Path::to_owned);
        let solver = |name: &str| name.strip_prefix("lib").is_some_and(is_linear_solver);
        Self {
            ipopt: named(&|name| name.starts_with("libipopt")),
            linear_solver: named(&solver),
            blas: Blas::find(maps),
        }
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
            .find_map(|prefix| find_file(maps, &|name: &str| name.starts_with(prefix)))?;
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

/// What the kernel says is mapped into this process, one mapping a line; empty where there is no such file.
fn maps() -> String {
    std::fs::read_to_string("/proc/self/maps").unwrap_or_default()
}

/// Whether this is a library of a solver for sparse symmetric systems that Ipopt knows.
fn is_linear_solver(name: &str) -> bool {
    ["dmumps", "coinmumps", "coinhsl", "hsl", "spral", "pardiso"]
        .iter()
        .any(|solver| name.starts_with(solver))
}

/// The first mapped file with such a name.
fn find_file<'a>(maps: &'a str, named: &dyn Fn(&str) -> bool) -> Option<&'a Path> {
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
        let found = Libraries::find(maps).linear_solver.expect("named so");
        assert_eq!(found, Path::new("/usr/lib/libdmumps_seq-5.5.so"));
        let others = "7f00-7f01 r-xp 0 fe:00 1 /usr/lib/libm.so.6\n";
        assert_eq!(Libraries::find(others), Libraries::default());
    }
}
