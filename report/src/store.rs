//! Runs that are done, one a line, so that nothing is done twice.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::Failure;
use crate::case::Case;
use crate::record::Record;

/// A file of records, of one revision and others.
pub struct Store {
    path: PathBuf,
    records: Vec<Record>,
}

impl Store {
    /// What is in the file, if there is one. A last line that was cut off by an interruption is dropped.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let text = match path.exists() {
            true => fs::read_to_string(path)?,
            false => String::new(),
        };
        let mut records = Vec::new();
        let mut whole = 0;
        for line in text
            .split_inclusive('\n')
            .filter(|line| line.ends_with('\n'))
        {
            match serde_json::from_str(line) {
                Ok(record) => records.push(record),
                Err(error) => eprintln!("a run in {} is not read: {error}", path.display()),
            }
            whole += line.len();
        }
        if whole < text.len() {
            fs::write(path, &text[..whole])?;
        }
        Ok(Store {
            path: path.to_path_buf(),
            records,
        })
    }

    /// The record of this case at this revision.
    pub fn find(&self, case: &Case, revision: &str) -> Option<&Record> {
        let is_it = |record: &&Record| record.case == *case && record.revision == revision;
        self.records.iter().find(is_it)
    }

    /// What the case took when it was run last, at any revision (s).
    pub fn last_wall(&self, case: &Case) -> Option<f64> {
        let mut latest = self.records.iter().rev();
        let found = latest.find(|record| record.case == *case);
        found.map(|record| record.result.cost.wall)
    }

    /// Appends one, on disk at once.
    pub fn push(&mut self, record: Record) -> Result<(), Failure> {
        let mut line = serde_json::to_string(&record)?;
        line.push('\n');
        let mut options = OpenOptions::new();
        let mut file: File = options.create(true).append(true).open(&self.path)?;
        file.write_all(line.as_bytes())?;
        self.records.push(record);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Measured;

    fn record(level: usize, revision: &str) -> Record {
        Record {
            case: Case::new("any", 1, level),
            revision: revision.into(),
            result: Measured {
                errors: [("h1".to_string(), 0.1 + level as f64)].into(),
                ..Measured::failed(Measured::CONVERGED)
            },
        }
    }

    #[test]
    fn an_interrupted_file_goes_on() {
        let folder = std::env::temp_dir().join(format!("report-store-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("runs.jsonl");
        let mut store = Store::open(&path).expect("nothing there yet");
        store.push(record(1, "a")).expect("written");
        store.push(record(2, "a")).expect("written");
        let text = fs::read_to_string(&path).expect("there");
        // the last line was cut in the middle
        fs::write(&path, &text[..text.len() - 9]).expect("written");
        let mut store = Store::open(&path).expect("read");
        assert_eq!(store.find(&record(1, "a").case, "a"), Some(&record(1, "a")));
        assert_eq!(store.find(&record(2, "a").case, "a"), None, "cut off");
        assert_eq!(
            store.find(&record(1, "a").case, "b"),
            None,
            "another revision"
        );
        assert_eq!(store.last_wall(&record(2, "a").case), None);
        store.push(record(2, "a")).expect("written");
        assert_eq!(store.last_wall(&record(2, "b").case), Some(0.0));
        let store = Store::open(&path).expect("read");
        assert_eq!(store.find(&record(2, "a").case, "a"), Some(&record(2, "a")));
        fs::remove_dir_all(&folder).expect("removed");
    }
}
