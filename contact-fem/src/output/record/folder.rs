//! The folder of a recorded run: its lock, the list of its files, and what it says of the run.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use contact_core::equilibrium::Choice;
use serde::Serialize;

use super::Plan;
use crate::error::Error;
use crate::output::file;

/// The file that is locked during a run, and lists the other files.
pub(super) const LIST: &str = "run.lock";
pub(super) const SUMMARY: &str = "summary.json";
/// The first line of the list.
const HEADER: &str = "Locked during a run; the next run removes the files listed below.\n";
/// Set aside for the last summary, which a full disk does not prevent then (bytes).
const ROOM: usize = 1 << 14;

#[cfg(unix)]
type Lock = nix::fcntl::Flock<File>;
#[cfg(not(unix))]
type Lock = File;

/// What a summary says at any time of a run.
#[derive(Clone, Serialize)]
pub(super) struct Heading {
    pub scene: String,
    pub increments: usize,
    /// The solver that the problem got first, and why.
    pub solver: &'static str,
    pub solver_because: &'static str,
    /// The start of the run, in seconds since the beginning of 1970.
    pub started: u64,
    /// The number of the process.
    pub process: u32,
    pub converged: bool,
    /// `running`, `complete`, `stopped` or `failed`.
    pub status: &'static str,
    /// Null if the run is complete and its certificate holds.
    pub reason: Option<String>,
}

impl Heading {
    pub(super) fn new<const D: usize>(plan: &Plan<'_, D>, choice: Choice) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        Heading {
            scene: plan.name.clone(),
            increments: plan.increments,
            solver: choice.solver,
            solver_because: choice.why,
            started: now.map_or(0, |now| now.as_secs()),
            process: std::process::id(),
            converged: false,
            status: "running",
            reason: None,
        }
    }
}

/// A folder that one run has for itself, until this is dropped.
pub(super) struct Folder {
    path: PathBuf,
    /// The system releases the lock however the process ends.
    list: Lock,
    /// The length of the list's whole lines.
    length: u64,
    files: BTreeSet<String>,
    pub(super) heading: Heading,
    is_concluded: bool,
}

impl Folder {
    /// Locks the folder, removes the files of the run before, and says that this run has begun.
    pub(super) fn claim(path: &Path, heading: Heading) -> Result<Self, Error> {
        file::create_folder(path)?;
        let mut list = open(path)?;
        clear(path, &mut list)?;
        let mut folder = Folder {
            path: path.into(),
            list,
            length: HEADER.len() as u64,
            files: BTreeSet::new(),
            heading,
            is_concluded: false,
        };
        folder.begin().map_err(|error| {
            // makes room for the summary that tells the failure; the first error is the one to tell
            let _ = remove(&folder.path.join(SUMMARY));
            folder.failed(error)
        })?;
        Ok(folder)
    }

    fn begin(&mut self) -> Result<(), Error> {
        self.add(SUMMARY)?;
        self.say()?;
        let room = file::beside(&self.path.join(SUMMARY));
        std::fs::write(&room, [b' '; ROOM]).map_err(|source| file::failed(&room, source))
    }

    /// Lists a file, which the next run then removes. It must be called before the file is written.
    pub(super) fn add(&mut self, name: &str) -> Result<(), Error> {
        if self.files.contains(name) {
            return Ok(());
        }
        let line = format!("{name}\n");
        self.list.write_all(line.as_bytes()).map_err(|source| {
            // the first error is the one to tell
            let _ = self.list.set_len(self.length);
            file::failed(&self.path.join(LIST), source)
        })?;
        self.length += line.len() as u64;
        self.files.insert(name.into());
        Ok(())
    }

    /// Waits until the files are on the disk.
    pub(super) fn sync(&self) -> Result<(), Error> {
        self.files.iter().try_for_each(|name| {
            let path = self.path.join(name);
            let synced = File::open(&path).and_then(|file| file.sync_all());
            synced.map_err(|source| file::failed(&path, source))
        })
    }

    /// Ends the run with its summary.
    pub(super) fn conclude(&mut self, summary: &str) -> Result<(), Error> {
        file::replace_on_disk(&self.path.join(SUMMARY), summary.as_bytes())?;
        self.is_concluded = true;
        Ok(())
    }

    /// Ends a run that has no summary of its own.
    pub(super) fn failed(&mut self, error: Error) -> Error {
        self.heading.reason = Some(error.to_string());
        error
    }

    /// Writes the heading as the summary.
    fn say(&self) -> Result<(), Error> {
        let path = self.path.join(SUMMARY);
        let text = serde_json::to_string_pretty(&self.heading);
        let text = text.map_err(|why| file::failed(&path, why))? + "\n";
        file::replace_on_disk(&path, text.as_bytes())
    }
}

/// A run that has not concluded has failed, by the error that it told or by a panic.
impl Drop for Folder {
    fn drop(&mut self) {
        if !self.is_concluded {
            self.heading.status = "failed";
            let reason = self.heading.reason.take();
            self.heading.reason = reason.or(Some("panicked".into()));
            // an error was told before, or a panic is under way
            let _ = self.say();
        }
    }
}

/// Opens the list and locks it.
fn open(folder: &Path) -> Result<Lock, Error> {
    let path = folder.join(LIST);
    let mut options = File::options();
    let file = options.read(true).append(true).create(true).open(&path);
    file.and_then(lock).map_err(|source| match source.kind() {
        ErrorKind::WouldBlock => Error::FolderInUse {
            folder: folder.into(),
        },
        _ => file::failed(&path, source),
    })
}

#[cfg(unix)]
fn lock(file: File) -> std::io::Result<Lock> {
    let locked = Lock::lock(file, nix::fcntl::FlockArg::LockExclusiveNonblock);
    locked.map_err(|(_, why)| why.into())
}

#[cfg(not(unix))]
fn lock(file: File) -> std::io::Result<Lock> {
    Ok(file)
}

/// Removes the files listed, the summary first, and begins the list anew.
///
/// They go in the order of the list, so that a `.pvd` file goes before those that it lists.
/// A kill in between leaves files without a summary, which the list still has.
fn clear(folder: &Path, list: &mut Lock) -> Result<(), Error> {
    let path = folder.join(LIST);
    let failed = |source| file::failed(&path, source);
    let mut text = String::new();
    list.read_to_string(&mut text).map_err(failed)?;
    if !text.starts_with(HEADER) && !HEADER.starts_with(&text) {
        let why =
            "it is not a list of this library's files: move it away, or record to another folder";
        return Err(file::failed(&path, why));
    }
    let names = listed(&text);
    if names.contains(&SUMMARY) {
        remove(&folder.join(SUMMARY))?;
    }
    for name in names {
        remove(&folder.join(name))?;
    }
    list.set_len(0).map_err(failed)?;
    list.write_all(HEADER.as_bytes()).map_err(failed)
}

/// The names in a list. A line without an end is of a file that was not written.
fn listed(text: &str) -> Vec<&str> {
    let lines = text.split_inclusive('\n').skip(1);
    let names = lines.filter_map(|line| line.strip_suffix('\n'));
    names.filter(|name| is_file_name(name)).collect()
}

/// Removes a file and what there is of its next version.
fn remove(path: &Path) -> Result<(), Error> {
    [path, &file::beside(path)]
        .into_iter()
        .try_for_each(|path| match std::fs::remove_file(path) {
            Err(source) if source.kind() != ErrorKind::NotFound => Err(file::failed(path, source)),
            _ => Ok(()),
        })
}

/// Whether a name is that of a file in the folder, without control characters.
fn is_file_name(name: &str) -> bool {
    let is_part = |c: char| c != '/' && !std::path::is_separator(c) && !c.is_control();
    !["", ".", ".."].contains(&name) && name.chars().all(is_part)
}

/// Checks that a name chosen by the user is one of a file in the folder, and not one of the run's own.
pub(super) fn check_file_name(folder: &Path, name: &str) -> Result<(), Error> {
    if is_file_name(name) && ![LIST, SUMMARY].contains(&name) {
        return Ok(());
    }
    let why = format!(
        "{name:?} must be the name of a file in this folder, other than `{LIST}` and `{SUMMARY}`"
    );
    Err(file::failed(folder, why))
}
