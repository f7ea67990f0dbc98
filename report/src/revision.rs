//! What a run depends on beside its settings: the source, and the libraries that are loaded.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use crate::Failure;

/// The commit, or for a tree with changes the commit and a fingerprint of this program; and the libraries.
pub fn revision() -> Result<String, Failure> {
    let versions = ipopt_contact::versions();
    let solver = versions.linear_solver.unwrap_or_default();
    let blas = versions.blas.map(|blas| blas.to_string());
    let libraries = format!(
        "Ipopt {}, {solver}, {}",
        versions.ipopt,
        blas.unwrap_or_default()
    );
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "no commit".into());
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
    match changed {
        Some(changed) if changed.is_empty() => Ok(format!("{commit}, {libraries}")),
        _ => Ok(format!(
            "{commit} changed {:016x}, {libraries}",
            fingerprint()?
        )),
    }
}

/// Of this program's file.
fn fingerprint() -> Result<u64, Failure> {
    let mut hasher = DefaultHasher::new();
    fs::read(std::env::current_exe()?)?.hash(&mut hasher);
    Ok(hasher.finish())
}

/// What git says, if it is there and says something of this source.
fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    let output = command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments);
    let output = output.output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}
