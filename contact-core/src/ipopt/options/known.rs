//! The data of options with typed setters.

use super::{Available, OptionValue, Word, table::KNOWN_OPTIONS};

/// An option with a typed setter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct KnownOption {
    /// Its name.
    pub name: &'static str,
    /// Ipopt's default, in the newest version known here.
    pub default: DefaultValue,
    /// The default before some version: that version and the value.
    pub before: Option<(&'static str, DefaultValue)>,
    /// The version it came with, if not all since 3.11 have it.
    pub since: Option<&'static str>,
    /// The words it takes; none if it takes a number or any text.
    pub words: &'static [Word],
}

/// A default, and with it the type of the option.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultValue {
    /// A real number.
    Number(f64),
    /// An integer.
    Integer(i32),
    /// A word or any text.
    Text(&'static str),
}

impl From<DefaultValue> for OptionValue {
    fn from(value: DefaultValue) -> Self {
        match value {
            DefaultValue::Number(value) => Self::Number(value),
            DefaultValue::Integer(value) => Self::Integer(value),
            DefaultValue::Text(value) => Self::from(value),
        }
    }
}

impl KnownOption {
    /// The one of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        KNOWN_OPTIONS.iter().find(|option| option.name == name)
    }

    /// Ipopt's default in a version such as (3, 11, 9).
    pub fn default_in(&self, version: (u32, u32, u32)) -> OptionValue {
        match self.before {
            Some((changed, old)) if version < release(changed) => old.into(),
            _ => self.default.into(),
        }
    }

    /// Whether a version such as (3, 11, 9) has it.
    pub fn is_in(&self, version: (u32, u32, u32)) -> bool {
        self.since.is_none_or(|since| release(since) <= version)
    }
}

/// "3.14.8" as (3, 14, 8).
fn release(version: &str) -> (u32, u32, u32) {
    let mut numbers = version.split('.').map(|part| part.parse().unwrap_or(0));
    let mut next = || numbers.next().unwrap_or(0);
    (next(), next(), next())
}

/// The type of an option's setter.
pub(super) trait Setting {
    /// The words that it stands for.
    const WORDS: &'static [Word] = &[];
}

impl Setting for f64 {}
impl Setting for i32 {}
impl Setting for usize {}
impl Setting for &str {}
impl Setting for bool {
    const WORDS: &'static [Word] = &[
        Word {
            text: "yes",
            available: Available::Always,
        },
        Word {
            text: "no",
            available: Available::Always,
        },
    ];
}
