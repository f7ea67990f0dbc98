//! FreeFEM: its installation, and how its scripts are run.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::cases::{Case, Script, Size};
use crate::Failure;

/// The remedy if FreeFEM is missing.
pub const INSTALL: &str = "FreeFEM with ff-Ipopt is not installed: `apt-get install freefem++` on \
                           Debian, or see https://freefem.org. Stored results stand in for it.";

/// An installed FreeFEM.
pub struct FreeFem {
    /// Its own version text, and the version of Debian's package.
    pub version: String,
    plugins: PathBuf,
    scripts: PathBuf,
}

impl FreeFem {
    /// The FreeFEM on the search path, if it has the plugin for Ipopt. Plugins are searched for in
    /// `$FF_LOADPATH` and in Debian's folder.
    pub fn find() -> Option<Self> {
        let banner = printed(Command::new("FreeFem++").arg("-nw"))?;
        let name = banner.lines().find(|line| line.contains("FreeFem++"))?;
        let name = name.split('(').next().unwrap_or(name).trim();
        let package = printed(Command::new("dpkg-query").args(["-W", "freefem++"]));
        let package = package.map(|found| found.split_whitespace().collect::<Vec<_>>().join(" "));
        let set = std::env::var_os("FF_LOADPATH").map(PathBuf::from);
        let places = set.into_iter().chain([PathBuf::from("/usr/lib/freefem++")]);
        let plugins = places
            .into_iter()
            .find(|p| p.join("ff-Ipopt.so").exists())?;
        Some(FreeFem {
            version: match package {
                Some(package) => format!("{name}, package {package}"),
                None => name.into(),
            },
            plugins,
            scripts: Path::new(env!("CARGO_MANIFEST_DIR")).join("../freefem"),
        })
    }

    /// The command that runs a script on the meshes in `meshes` and writes its files to `out`.
    pub fn command(
        &self,
        case: &Case,
        script: &Script,
        size: Size,
        meshes: &Path,
        out: &Path,
    ) -> Result<Command, Failure> {
        let path = self.scripts.join(script.file).with_extension("edp");
        if !path.exists() {
            return Err(format!("there is no script {}", path.display()).into());
        }
        let mut command = Command::new("FreeFem++");
        command
            .env("FF_LOADPATH", &self.plugins)
            .env("FF_INCLUDEPATH", &self.scripts)
            .args(["-nw", "-v", "0"])
            .arg(path)
            .arg("-meshes")
            .arg(meshes)
            .arg("-out")
            .arg(out)
            .args(["-increments", &size.of(case.increments).to_string()])
            .args(["-tolerance", &case.tolerance.to_string()])
            .args(script.arguments);
        Ok(command)
    }
}

/// The output of a command on either stream, if it can be run.
fn printed(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).output().ok()?;
    let all = [output.stdout, output.stderr].concat();
    Some(String::from_utf8_lossy(&all).into_owned())
}
