//! Places in a scene file, which errors name by part, line and key.

use toml::de::{DeTable, DeValue};

use super::Error;

/// A part of a scene file, or a key in it.
#[derive(Clone, Debug)]
pub(super) struct Place<'a> {
    text: &'a str,
    /// What errors call the part, such as "body ring".
    part: String,
    /// The way to the part from the top of the file, and on to the key.
    way: Vec<Step>,
    /// The steps to the part.
    depth: usize,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Key(&'static str),
    Entry(usize),
}

impl<'a> Place<'a> {
    /// The file as a whole.
    pub(super) fn top(text: &'a str) -> Self {
        Place {
            text,
            part: "the scene".into(),
            way: Vec::new(),
            depth: 0,
        }
    }

    /// An entry of an array of tables, which errors call `part`.
    pub(super) fn part(&self, key: &'static str, index: usize, part: String) -> Self {
        let place = self.entry(key, index);
        let depth = place.way.len();
        Place {
            part,
            depth,
            ..place
        }
    }

    /// A key of this table.
    pub(super) fn key(&self, key: &'static str) -> Self {
        let mut place = self.clone();
        place.way.push(Step::Key(key));
        place
    }

    /// An entry of a list in this table.
    pub(super) fn entry(&self, key: &'static str, index: usize) -> Self {
        let mut place = self.key(key);
        place.way.push(Step::Entry(index));
        place
    }

    /// An error about this place.
    pub(super) fn wrong(&self, what: impl Into<String>) -> Error {
        Error::Part {
            part: self.named(),
            what: what.into(),
        }
    }

    /// Names this place in an error of the library.
    pub(super) fn of<T>(&self, result: Result<T, contact_fem::Error>) -> Result<T, Error> {
        result.map_err(|source| Error::Refused {
            part: self.named(),
            source: Box::new(source),
        })
    }

    /// As many components as the space has dimensions.
    pub(super) fn vector<const D: usize>(&self, values: &[f64]) -> Result<[f64; D], Error> {
        values
            .try_into()
            .map_err(|_| self.wrong(format!("has {} components and needs {D}", values.len())))
    }

    /// The part, the line, and the key with those that lead to it.
    fn named(&self) -> String {
        let keys = self.way[self.depth..].iter().filter_map(|step| match step {
            Step::Key(key) => Some(*key),
            Step::Entry(_) => None,
        });
        let keys: Vec<&str> = keys.collect();
        let line = self.line();
        match keys.is_empty() {
            true => format!("{}, line {line}", self.part),
            false => format!("{}, line {line}, `{}`", self.part, keys.join(".")),
        }
    }

    /// The line on which it begins, or what it would be in.
    fn line(&self) -> usize {
        let mut at = 0;
        // the text was parsed before
        if let Ok(table) = DeTable::parse(self.text) {
            let top = DeValue::Table(table.into_inner());
            let mut value = &top;
            for step in &self.way {
                let next = match (step, value) {
                    (Step::Key(key), DeValue::Table(table)) => table.get(*key),
                    (Step::Entry(index), DeValue::Array(list)) => list.get(*index),
                    _ => None,
                };
                let Some(next) = next else { break };
                // arrays of tables have no place of their own
                if next.span().end > 0 {
                    at = next.span().start;
                }
                value = next.get_ref();
            }
        }
        let before = self.text.get(..at).unwrap_or_default();
        1 + before.bytes().filter(|&byte| byte == b'\n').count()
    }
}
