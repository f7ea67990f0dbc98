//! File operations whose errors contain the path.

use std::fmt::Display;
use std::path::Path;

use crate::Failure;

/// Writes a file and replaces an older one.
pub fn write(path: impl AsRef<Path>, text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let path = path.as_ref();
    std::fs::write(path, text).map_err(|error| cannot("write", path, error))
}

/// Reads a file.
pub fn read(path: impl AsRef<Path>) -> Result<String, Failure> {
    let path = path.as_ref();
    std::fs::read_to_string(path).map_err(|error| cannot("read", path, error))
}

/// Creates a folder and its parents if they do not exist.
pub fn make_folder(path: impl AsRef<Path>) -> Result<(), Failure> {
    let path = path.as_ref();
    std::fs::create_dir_all(path).map_err(|error| cannot("make", path, error))
}

/// An error with the failed operation, the path and the cause.
pub fn cannot(act: &str, path: &Path, why: impl Display) -> Failure {
    format!("cannot {act} {}: {why}", path.display()).into()
}
