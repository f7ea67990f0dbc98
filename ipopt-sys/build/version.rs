//! Which Ipopt the headers are of, and what that means.

use std::{fmt, fs, path::Path};

use crate::locate::Ipopt;

/// Major, minor, release.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(pub u32, pub u32, pub u32);

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.0, self.1, self.2)
    }
}

/// Releases with the same C interface.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Release {
    /// 3.11 to 3.13.
    Since3_11,
    /// 3.14.
    Since3_14,
}

/// The oldest whose headers the shim compiles against.
const OLDEST: Version = Version(3, 11, 0);

/// What documentation describes where there is no Ipopt; `src/bindings_3_14.rs` is of these headers.
pub const DOCUMENTED: Version = Version(3, 14, 19);

/// The versions at which something changed: the cfg of this crate, and the keys a dependent's build script reads
/// (1 or 0). `src/version.rs` has a constant for each key and says what it means.
const GATES: [(Version, &str, &[&str]); 6] = [
    (
        Version(3, 14, 0),
        "ipopt_3_14",
        &[
            "BOOL_IS_ONE_BYTE",
            "HAS_WALL_TIME_LIMIT",
            "HAS_MAKE_PARAMETER_NODUAL",
            "HAS_MULTIPLIERS_OF_FIXED_VARIABLES",
            "CROSSED_BOUNDS_ARE_INVALID_PROBLEM",
            "RELAXES_ORIGINAL_BOUNDS",
        ],
    ),
    (
        Version(3, 14, 8),
        "ipopt_3_14_8",
        &["HAS_MUMPS_PRINT_LEVEL"],
    ),
    (
        Version(3, 14, 10),
        "ipopt_3_14_10",
        &["HAS_GRAD_F_CONSTANT"],
    ),
    (
        Version(3, 14, 12),
        "ipopt_3_14_12",
        &["CURRENT_ITERATE_IS_SAFE"],
    ),
    (
        Version(3, 14, 13),
        "ipopt_3_14_13",
        &["HEEDS_STRUCTURE_FAILURE"],
    ),
    (
        Version(3, 14, 18),
        "ipopt_3_14_18",
        &["HAS_GET_IPOPT_VERSION"],
    ),
];

impl Version {
    /// Which of the bindings kept in the source fits.
    pub fn release(self) -> Result<Release, String> {
        match (self.0, self.1) {
            (3, 11..=13) => Ok(Release::Since3_11),
            (3, 14) => Ok(Release::Since3_14),
            _ => Err(format!(
                "ipopt-contact-sys keeps bindings for Ipopt 3.11 to 3.14, and the headers found are of {self}: bindings to \
                 these are made from the headers, with the feature `bindgen` on and libclang installed (Debian, Ubuntu: \
                 `apt-get install libclang-dev`)."
            )),
        }
    }
}

/// Tells the compiler which cfgs there can be.
pub fn declare_cfgs() {
    for (_, cfg, _) in GATES {
        println!("cargo::rustc-check-cfg=cfg({cfg})");
    }
}

/// The version in the headers. It is the one that counts: the `.pc` file may have been left behind by another Ipopt,
/// and if it says otherwise, what would be linked is anyone's guess.
pub fn of_headers(ipopt: &Ipopt) -> Result<Version, String> {
    let text = ipopt
        .compiler()
        .file("src/version_probe.cpp")
        .cargo_warnings(false)
        .try_expand()
        .map_err(|e| {
            let reason = e.to_string().replace('\n', " ");
            format!(
                "ipopt-contact-sys could not read IpoptConfig.h in {:?}: {reason}. It needs a C++ compiler (Debian, Ubuntu: \
                 `apt-get install g++`) and Ipopt's headers where `pkg-config --cflags ipopt` says.",
                ipopt.library.include_paths
            )
        })?;
    let text = String::from_utf8_lossy(&text);
    // A macro of a system header comes on a line of its own, with a line marker before it.
    let words: Vec<&str> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_whitespace)
        .skip_while(|word| *word != "ipopt_sys_version")
        .skip(1)
        .collect();
    let version = parse(&words).ok_or(
        "ipopt-contact-sys found an IpoptConfig.h that does not say of which version it is.",
    )?;
    if version < OLDEST {
        return Err(format!(
            "ipopt-contact-sys needs Ipopt {OLDEST} or later; the headers found are of {version}."
        ));
    }
    let package = &ipopt.library.version;
    if !agree(package, version) {
        return Err(format!(
            "ipopt-contact-sys found two versions of Ipopt: ipopt.pc is of {package}, and the headers it points at, in {:?}, \
             are of {version}. Remove one of them, or point PKG_CONFIG_PATH at an ipopt.pc that fits its headers.",
            ipopt.library.include_paths
        ));
    }
    Ok(version)
}

/// Three numbers.
fn parse(words: &[&str]) -> Option<Version> {
    match words {
        [major, minor, release] => Some(Version(
            major.parse().ok()?,
            minor.parse().ok()?,
            release.parse().ok()?,
        )),
        _ => None,
    }
}

/// Whether `package` names this version, as far as it has numbers: "3.14" agrees with 3.14.19.
fn agree(package: &str, version: Version) -> bool {
    package
        .split('.')
        .zip([version.0, version.1, version.2])
        .map_while(|(part, number)| Some((leading_number(part)?, number)))
        .all(|(part, number)| part == number)
}

fn leading_number(text: &str) -> Option<u32> {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    text[..end].parse().ok()
}

/// Writes what `src/version.rs` includes, and sets the cfgs.
pub fn write(version: Version, out: &Path) -> Result<(), String> {
    for (since, cfg, _) in GATES {
        if version >= since {
            println!("cargo::rustc-cfg={cfg}");
        }
    }
    let path = out.join("version.rs");
    let text = format!("({}, {}, {})\n", version.0, version.1, version.2);
    fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// The version and its gates as metadata.
pub fn report(version: Version) {
    println!("cargo::metadata=VERSION_MAJOR={}", version.0);
    println!("cargo::metadata=VERSION_MINOR={}", version.1);
    println!("cargo::metadata=VERSION_RELEASE={}", version.2);
    for (since, _, keys) in GATES {
        for key in keys {
            println!("cargo::metadata={key}={}", u32::from(version >= since));
        }
    }
}
