//! Files, with errors that say where.

use std::fmt::Display;
use std::path::Path;

use crate::Failure;

/// Writes a file in the place of an older one.
pub fn write(path: impl AsRef<Path>, text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let path = path.as_ref();
    std::fs::write(path, text).map_err(|error| cannot("write", path, error))
}

/// Makes a folder and those that it is in, unless they are there.
pub fn make_folder(path: impl AsRef<Path>) -> Result<(), Failure> {
    let path = path.as_ref();
    std::fs::create_dir_all(path).map_err(|error| cannot("make", path, error))
}

/// What could not be done to which file, and why.
pub fn cannot(act: &str, path: &Path, why: impl Display) -> Failure {
    format!("cannot {act} {}: {why}", path.display()).into()
}
