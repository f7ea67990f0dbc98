//! Values of options, and errors for those that Ipopt rejects.

use std::fmt;

use thiserror::Error;

use super::hint::nearest;
use crate::ipopt::VERSION;

/// A value of an option.
#[derive(Debug, Clone, PartialEq)]
pub enum OptionValue {
    /// One of a set of words, or a file name.
    Text(String),
    /// A real number.
    Number(f64),
    /// An integer; also taken where Ipopt wants a real number.
    Integer(i32),
}

impl From<&str> for OptionValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for OptionValue {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

/// "yes" or "no".
impl From<bool> for OptionValue {
    fn from(value: bool) -> Self {
        Self::from(if value { "yes" } else { "no" })
    }
}

impl From<f64> for OptionValue {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<i32> for OptionValue {
    fn from(value: i32) -> Self {
        Self::Integer(value)
    }
}

/// For limits and counts: whatever exceeds an `i32` is as good as its maximum.
impl From<usize> for OptionValue {
    fn from(value: usize) -> Self {
        Self::Integer(i32::try_from(value).unwrap_or(i32::MAX))
    }
}

impl fmt::Display for OptionValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(value) => write!(f, "{value:?}"),
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Integer(value) => write!(f, "{value}"),
        }
    }
}

/// An option that Ipopt rejects.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum OptionError {
    /// An unknown name, or an unknown prefix.
    #[error("Ipopt {} has no option `{name}` (set to {value}): {}", version(), remedy(.name, *.since))]
    Unknown {
        /// The name.
        name: String,
        /// The value it was to have.
        value: OptionValue,
        /// The version of Ipopt that it came with, if that is known here.
        since: Option<&'static str>,
    },
    /// A value of the wrong type.
    #[error("Ipopt's option `{name}` was set to {value} and takes {expected}")]
    WrongType {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// What it takes instead.
        expected: String,
    },
    /// A value of the right type that is not allowed.
    #[error(
        "Ipopt's option `{name}` was set to {value}, which is not allowed: it takes {expected}"
    )]
    Invalid {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// What it takes instead.
        expected: String,
    },
    /// A value that Ipopt takes, but with which it ends the process or does not return the solution.
    #[error(
        "Ipopt's option `{name}` was set to {value}, which the driver does not pass on: {why}; {remedy}"
    )]
    Refused {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// What Ipopt would do with it.
        why: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A linear solver that Ipopt knows and cannot solve with: it is in none of the libraries that are loaded.
    #[error(
        "Ipopt's option `{name}` was set to {value}, and there is no such solver here: {}",
        instead(there)
    )]
    MissingSolver {
        /// The name.
        name: String,
        /// The value refused.
        value: OptionValue,
        /// The linear solvers that are there.
        there: Vec<&'static str>,
    },
    /// A file of options that cannot be read.
    #[error(
        "the file of options {file} cannot be read: {why}; check its name, and that it is text"
    )]
    File {
        /// The file.
        file: String,
        /// What the system says.
        why: String,
    },
    /// A line of a file of options that is no option.
    #[error(
        "line {number} of the file of options {file} is no option: {line:?}; it takes a name and a value, in double \
         quotes if there are spaces in it, or a comment after #"
    )]
    Line {
        /// The file.
        file: String,
        /// The line, counted from 1.
        number: usize,
        /// What is there, or its beginning.
        line: String,
    },
}

fn instead(there: &[&str]) -> String {
    match there {
        [] => {
            "no linear solver works, install one that Ipopt is linked to, such as MUMPS".to_owned()
        }
        _ if VERSION >= (3, 14, 0) => format!(
            "take {}, or set `hsllib` or `pardisolib` to the library that has it",
            there.join(" or ")
        ),
        _ => format!("take {}", there.join(" or ")),
    }
}

fn version() -> String {
    let (major, minor, release) = VERSION;
    format!("{major}.{minor}.{release}")
}

fn remedy(name: &str, since: Option<&str>) -> String {
    match since {
        Some(version) => format!("it exists since {version}"),
        None if name.contains('.') => {
            "the only prefix is `resto.`, for the restoration phase".to_owned()
        }
        None => match nearest(name) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "check the name; `KNOWN_OPTIONS` and Ipopt's manual list them".to_owned(),
        },
    }
}
