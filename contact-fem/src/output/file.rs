//! Writing files so that nobody ever sees half of one.

use std::error::Error as StdError;
use std::ffi::OsString;
use std::path::Path;

use crate::error::Error;

/// Puts `bytes` at `path` in one go: written beside it first, then renamed over it.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut beside = OsString::from(path);
    beside.push(".part");
    std::fs::write(&beside, bytes)
        .and_then(|()| std::fs::rename(&beside, path))
        .map_err(|source| failed(path, source))
}

/// Makes the folder and everything above it.
#[cfg(any(feature = "csv", feature = "vtk"))]
pub(super) fn create_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| failed(folder, source))
}

/// [`Error::Write`] for this path.
pub(super) fn failed(path: &Path, source: impl Into<Box<dyn StdError + Send + Sync>>) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source: source.into(),
    }
}
