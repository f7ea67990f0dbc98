//! Writes files atomically: a reader sees a complete file or none.

use std::error::Error as StdError;
use std::ffi::OsString;
use std::path::Path;

use crate::error::Error;

/// Writes `bytes` to `path` atomically: to a file beside it, which is then renamed.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut beside = OsString::from(path);
    beside.push(".part");
    std::fs::write(&beside, bytes)
        .and_then(|()| std::fs::rename(&beside, path))
        .map_err(|source| failed(path, source))
}

/// Creates the folder and its parents.
#[cfg(any(feature = "csv", feature = "vtk"))]
pub(super) fn create_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| failed(folder, source))
}

/// [`Error::Write`] for the given path.
pub(super) fn failed(path: &Path, source: impl Into<Box<dyn StdError + Send + Sync>>) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source: source.into(),
    }
}
