//! Places in a scene file, which errors name by part, line and key.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Error, hints, in_keys};

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

#[derive(Clone, Debug)]
enum Step {
    Key(Cow<'static, str>),
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
    pub(super) fn key(&self, key: impl Into<Cow<'static, str>>) -> Self {
        let mut place = self.clone();
        place.way.push(Step::Key(key.into()));
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
        result.map_err(|source| self.refused(source))
    }

    /// An error of the library about this place, or about the key in it that the error names.
    pub(super) fn refused(&self, source: contact_fem::Error) -> Error {
        let own = match &source {
            contact_fem::Error::Setting { name, .. } => key_of(name),
            _ => None,
        };
        let own = own.map(|key| self.key(key)).filter(Self::is_there);
        Error::Refused {
            part: own.as_ref().unwrap_or(self).named(),
            source: Box::new(source),
        }
    }

    /// As many components as the space has dimensions.
    pub(super) fn vector<const D: usize>(&self, values: &[f64]) -> Result<[f64; D], Error> {
        values.try_into().map_err(|_| {
            let what = format!("has {} components and needs {D}", values.len());
            self.wrong(match hints::decimal_comma_in_list(self.source()) {
                Some(hint) if values.len() > D => format!("{what}: {hint}"),
                _ => what,
            })
        })
    }

    /// The part, the line, and the key with those that lead to it; of the file as a whole its name alone.
    pub(super) fn named(&self) -> String {
        if self.way.is_empty() {
            return self.part.clone();
        }
        let keys = self.way[self.depth..].iter().filter_map(|step| match step {
            Step::Key(key) => Some(key.as_ref()),
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
    pub(super) fn line(&self) -> usize {
        line_of(self.text, self.found().0.start)
    }

    /// Its text, or that of what it would be in.
    fn source(&self) -> &str {
        self.text.get(self.found().0).unwrap_or_default()
    }

    /// Whether the file has it.
    fn is_there(&self) -> bool {
        self.found().1
    }

    /// The bytes of it, or of what it would be in, and whether it is there.
    fn found(&self) -> (Range<usize>, bool) {
        let (mut at, mut is_there) = (0..0, false);
        // the text was parsed before
        if let Ok(table) = DeTable::parse(self.text) {
            let top = DeValue::Table(table.into_inner());
            let mut value = &top;
            is_there = true;
            for step in &self.way {
                let next = match (step, value) {
                    (Step::Key(key), DeValue::Table(table)) => table.get(key.as_ref()),
                    (Step::Entry(index), DeValue::Array(list)) => list.get(*index),
                    _ => None,
                };
                let Some(next) = next else {
                    is_there = false;
                    break;
                };
                // arrays of tables have no place of their own
                if next.span().end > 0 {
                    at = next.span();
                }
                value = next.get_ref();
            }
        }
        (at, is_there)
    }
}

/// The key of a setting of the library, if it is one.
fn key_of(name: &str) -> Option<String> {
    let name = name.split('[').next()?;
    let told = format!("`{name}`");
    let key = in_keys(&told).into_owned();
    let key = key.strip_prefix('`')?.strip_suffix('`')?;
    (!key.contains(['`', ' '])).then(|| key.to_string())
}

/// The line of a byte.
fn line_of(text: &str, at: usize) -> usize {
    let before = text.get(..at).unwrap_or_default();
    1 + before.bytes().filter(|&byte| byte == b'\n').count()
}

/// Keys whose numbers may be infinite.
const ENDLESS: [&str; 2] = ["during", "reach"];

/// Refuses numbers that are not finite, which TOML has.
///
/// # Errors
/// The first one, with its line and the keys that lead to it.
pub(super) fn check_numbers(text: &str) -> Result<(), Error> {
    fn check(
        text: &str,
        keys: &mut Vec<String>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), Error> {
        match value.get_ref() {
            DeValue::Float(number) => {
                let number = number.as_str();
                if !(number.contains("inf") || number.contains("nan")) {
                    return Ok(());
                }
                let (line, key) = (line_of(text, value.span().start), keys.join("."));
                Err(Error::Part {
                    part: format!("line {line}, `{key}`"),
                    what: format!("{number} is not finite: give a number"),
                })
            }
            DeValue::Array(list) => list.iter().try_for_each(|own| check(text, keys, own)),
            DeValue::Table(table) => inner(text, keys, table),
            _ => Ok(()),
        }
    }
    fn inner(text: &str, keys: &mut Vec<String>, table: &DeTable<'_>) -> Result<(), Error> {
        let own = table.iter().map(|(key, value)| (key.get_ref(), value));
        for (key, value) in own.filter(|(key, _)| !ENDLESS.contains(&key.as_ref())) {
            keys.push(key.to_string());
            check(text, keys, value)?;
            keys.pop();
        }
        Ok(())
    }
    match DeTable::parse(text) {
        Ok(table) => inner(text, &mut Vec::new(), table.get_ref()),
        Err(why) => Err(Error::no_scene(text, why)),
    }
}
