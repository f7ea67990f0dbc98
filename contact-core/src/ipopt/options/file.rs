//! Files of options: names and values, as Ipopt's own.

use std::{fs, path::Path};

use super::{OptionError, OptionValue, Options};

impl Options {
    /// Reads a file of options as Ipopt has them (`ipopt.opt`): a name and a value a line, and what follows `#` is a
    /// comment. A value with spaces stands in double quotes. The last value of a name counts.
    ///
    /// Names and values are checked by the solver, as those of [`Options::set`]. Ipopt itself reads no file:
    /// `option_file_name` is refused.
    ///
    /// ```
    /// # use contact_core::ipopt::Options;
    /// # let path = std::env::temp_dir().join(format!("options-{}.opt", std::process::id()));
    /// std::fs::write(&path, "tol 1e-9 # relative\nmu_strategy adaptive\n")?;
    /// let options = Options::read(&path)?.max_iter(100);
    /// assert_eq!(options.get("tol"), Some(&1e-9.into()));
    /// # std::fs::remove_file(path)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`OptionError::File`] if the file cannot be read, [`OptionError::Line`] for a line that is not a name and a
    /// value.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OptionError> {
        let path = path.as_ref();
        let file = || path.display().to_string();
        let text = fs::read_to_string(path).map_err(|why| OptionError::File {
            file: file(),
            why: why.to_string(),
        })?;
        let mut options = Options::new();
        for (number, line) in (1..).zip(text.lines()) {
            let not_an_option = || OptionError::Line {
                file: file(),
                number,
                line: line.chars().take(80).collect(),
            };
            let words = words(line).ok_or_else(not_an_option)?;
            match words.as_slice() {
                [] => {}
                [name, word] => {
                    options.set(&name.text, word.value());
                }
                _ => return Err(not_an_option()),
            }
        }
        Ok(options)
    }
}

struct Word {
    text: String,
    is_quoted: bool,
}

impl Word {
    /// A number where it is one; `1d-8` is one, too.
    fn value(&self) -> OptionValue {
        let text = self.text.as_str();
        if self.is_quoted || !text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
            return text.into();
        }
        match (text.parse::<i32>(), text.replace(['d', 'D'], "e").parse()) {
            (Ok(integer), _) => OptionValue::Integer(integer),
            (_, Ok(number)) => OptionValue::Number(number),
            _ => text.into(),
        }
    }
}

/// The words of a line; `None` if a quotation does not end.
fn words(line: &str) -> Option<Vec<Word>> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() && !rest.starts_with('#') {
        let (text, is_quoted, after) = match rest.strip_prefix('"') {
            Some(quoted) => {
                let (text, after) = quoted.split_once('"')?;
                (text, true, after)
            }
            None => {
                let end = rest.find(|c: char| c.is_whitespace() || c == '#');
                let (text, after) = rest.split_at(end.unwrap_or(rest.len()));
                (text, false, after)
            }
        };
        words.push(Word {
            text: text.to_owned(),
            is_quoted,
        });
        rest = after.trim_start();
    }
    Some(words)
}
