//! Writes files atomically: a reader sees a complete file or none.

use std::error::Error as StdError;
use std::ffi::OsString;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Writes `bytes` to `path` atomically: to a file beside it, which is then renamed. An error leaves what was there.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    put(path, bytes, |_| Ok(()))
}

/// As [`replace`]; when it returns, the file is on the disk.
#[cfg(feature = "record")]
pub(super) fn replace_on_disk(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    put(path, bytes, File::sync_all)?;
    // the name too; not every system can do this
    let folder = path.parent().map(File::open);
    let _ = folder.map(|folder| folder.and_then(|folder| folder.sync_all()));
    Ok(())
}

fn put(
    path: &Path,
    bytes: &[u8],
    finish: impl FnOnce(&File) -> std::io::Result<()>,
) -> Result<(), Error> {
    let beside = beside(path);
    // what is there is written over: it keeps its room on a full disk
    let mut over = File::options();
    let opened = over.write(true).create(true).truncate(false).open(&beside);
    let written = opened.and_then(|mut file| {
        file.write_all(bytes)?;
        file.set_len(bytes.len() as u64)?;
        finish(&file)?;
        std::fs::rename(&beside, path)
    });
    written.map_err(|source| {
        // the first error is the one to tell
        let _ = std::fs::remove_file(&beside);
        failed(path, source)
    })
}

/// The name of a file that is not complete yet.
pub(super) fn beside(path: &Path) -> PathBuf {
    let mut beside = OsString::from(path);
    beside.push(".part");
    beside.into()
}

/// Creates the folder and its parents.
#[cfg(any(feature = "csv", feature = "vtk"))]
pub(super) fn create_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| failed(folder, source))
}

/// Checks that the names which begin with `name` are in the folder, and need no escapes in XML.
#[cfg(any(feature = "csv", feature = "vtk"))]
pub(super) fn check_name(folder: &Path, name: &str) -> Result<(), Error> {
    let plain = |c: char| c.is_alphanumeric() || "_-.".contains(c);
    if ["", ".", ".."].contains(&name) || !name.chars().all(plain) {
        let why = format!("the name {name:?} must be made of letters, digits, `_`, `-` and `.`");
        return Err(failed(folder, why));
    }
    Ok(())
}

/// The text without the characters that XML does not have; a sign is in their place.
#[cfg(any(feature = "plot", feature = "vtk"))]
pub(super) fn in_xml(text: &str) -> String {
    let is_none = |c: char| {
        let is_control = c < ' ' && !"\t\n\r".contains(c);
        is_control || "\u{fffe}\u{ffff}".contains(c)
    };
    text.replace(is_none, "\u{fffd}")
}

/// [`Error::Write`] for the given path.
pub(super) fn failed(path: &Path, source: impl Into<Box<dyn StdError + Send + Sync>>) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source: source.into(),
    }
}
