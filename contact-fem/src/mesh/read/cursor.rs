//! A cursor over the bytes of a file, which reads words and numbers as text or binary.

use super::problem::{Fault, Place, Problem, excerpt};

/// A position in the bytes of a file.
///
/// Numbers are read as text or, in binary files, as little-endian values. Words are separated by
/// white space; a word that begins with a double quote extends to the next double quote in its
/// line.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    /// The position of the next byte.
    at: usize,
    /// The position of the last word or number, for messages.
    last: usize,
    /// The character that starts a comment, which extends to the end of the line.
    comment: Option<u8>,
    /// Whether numbers are binary.
    pub binary: bool,
    /// Whether binary integers have eight bytes instead of four.
    pub is_wide: bool,
    /// Whether binary real numbers have four bytes instead of eight.
    pub is_single: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8], comment: Option<u8>) -> Self {
        Cursor {
            bytes,
            at: 0,
            last: 0,
            comment,
            binary: false,
            is_wide: false,
            is_single: false,
        }
    }

    /// The bytes from the cursor to the end of the file.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Skips white space and comments.
    fn skip_space(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            if Some(byte) == self.comment {
                let line = self.rest().iter().position(|&b| b == b'\n');
                self.at += line.unwrap_or(self.rest().len());
            } else if byte.is_ascii_whitespace() || byte == b'\x0b' {
                self.at += 1;
            } else {
                break;
            }
        }
        self.last = self.at;
    }

    /// Reads the next word; `None` at the end of the file.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = self.rest();
        let length = match rest.first()? {
            b'"' => {
                let line = rest[1..].iter().position(|&b| b == b'"' || b == b'\n');
                line.map_or(rest.len(), |k| k + 1 + usize::from(rest[k + 1] == b'"'))
            }
            _ => {
                let end = |&b: &u8| b.is_ascii_whitespace() || b == b'\x0b';
                rest.iter().position(end).unwrap_or(rest.len())
            }
        };
        self.at += length;
        Some(&rest[..length])
    }

    /// Returns the next word without moving the cursor.
    pub fn peek(&mut self) -> Option<&'a [u8]> {
        let start = self.at;
        let word = self.word();
        self.at = start;
        word
    }

    /// Skips the next word, which must be the given one.
    pub fn expect(&mut self, expected: &str) -> Result<(), Fault> {
        match self.word() {
            Some(word) if word == expected.as_bytes() => Ok(()),
            other => Err(self.unexpected(&format!("`{expected}`"), other)),
        }
    }

    /// Reads the next word as a number.
    fn parse<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        let word = self.word();
        let text = word.and_then(|word| std::str::from_utf8(word).ok());
        let number = text.and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.unexpected(what, word))
    }

    /// The number of bytes before the cursor.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Moves forward to a position.
    pub fn move_to(&mut self, position: u64) -> Result<(), Fault> {
        let (at, end) = (self.at, self.bytes.len());
        let fits = |p: &usize| (at..=end).contains(p);
        let position = usize::try_from(position).ok().filter(fits).ok_or(position);
        self.at = position.map_err(|p| self.wrong(&format!("a position from {at} to {end}"), p))?;
        Ok(())
    }

    /// Reads the next `N` bytes.
    pub fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Fault> {
        self.last = self.at;
        let bytes = self.rest().first_chunk::<N>();
        let bytes = *bytes.ok_or_else(|| self.unexpected(what, None))?;
        self.at += N;
        Ok(bytes)
    }

    /// Reads an integer, which has four or eight bytes in binary files.
    pub fn integer(&mut self, what: &str) -> Result<i64, Fault> {
        match (self.binary, self.is_wide) {
            (true, true) => self.take(what).map(i64::from_le_bytes),
            (true, false) => self
                .take(what)
                .map(|bytes| i32::from_le_bytes(bytes).into()),
            (false, _) => self.text_integer(what),
        }
    }

    /// Reads a size or an index, which has eight bytes in binary files.
    pub fn size(&mut self, what: &str) -> Result<u64, Fault> {
        match self.binary {
            true => self.take(what).map(u64::from_le_bytes),
            false => self.parse(what),
        }
    }

    /// Reads a real number, finite or not, which has eight or four bytes in binary files.
    pub fn real(&mut self, what: &str) -> Result<f64, Fault> {
        match (self.binary, self.is_single) {
            (true, true) => self
                .take(what)
                .map(|bytes| f32::from_le_bytes(bytes).into()),
            (true, false) => self.take(what).map(f64::from_le_bytes),
            (false, _) => self.parse(what),
        }
    }

    /// The bytes of so many binary real numbers and integers.
    pub fn bytes_of(&self, reals: usize, integers: usize) -> usize {
        reals * if self.is_single { 4 } else { 8 } + integers * if self.is_wide { 8 } else { 4 }
    }

    /// Reads three coordinates.
    pub fn point(&mut self) -> Result<[f64; 3], Fault> {
        let what = "a coordinate";
        Ok([self.real(what)?, self.real(what)?, self.real(what)?])
    }

    /// Reads an integer that is text in binary files, too.
    pub fn text_integer(&mut self, what: &str) -> Result<i64, Fault> {
        self.parse(what)
    }

    /// Reads a size that is text in binary files, too.
    pub fn text_size(&mut self, what: &str) -> Result<u64, Fault> {
        self.parse(what)
    }

    /// Checks that the rest of the file has room for `count` items, each of `numbers` numbers in
    /// text files and of `bytes` bytes in binary files.
    pub fn room(
        &self,
        what: &'static str,
        count: u64,
        numbers: usize,
        bytes: usize,
    ) -> Result<usize, Fault> {
        // in text, a number needs a digit and a space; the last one needs no space
        let each = if self.binary { bytes } else { 2 * numbers };
        let left = self.rest().len();
        match usize::try_from(count) {
            Ok(n) if n.saturating_mul(each) <= left.saturating_add(1) => Ok(n),
            _ => Err(self.fault(Problem::Count {
                what,
                count,
                bytes: left,
            })),
        }
    }

    /// Skips the end of the current line, where binary values begin.
    pub fn end_of_line(&mut self) -> Result<(), Fault> {
        let blanks = self.rest().iter().take_while(|&&b| b == b' ').count();
        let rest = &self.rest()[blanks..];
        let length = match rest {
            [b'\r', b'\n', ..] => 2,
            [b'\n', ..] => 1,
            _ => return Err(self.unexpected("the end of the line", rest.get(..1))),
        };
        self.at += blanks + length;
        Ok(())
    }

    /// Moves past the next occurrence of `mark` as a separate word.
    pub fn find(&mut self, mark: &str) -> Result<(), Fault> {
        self.last = self.at;
        let mut start = self.at;
        loop {
            let rest = &self.bytes[start..];
            let found = rest.windows(mark.len()).position(|w| w == mark.as_bytes());
            let Some(found) = found else {
                let mark = excerpt(mark.as_bytes());
                return Err(self.unexpected(&format!("`{mark}`"), None));
            };
            start += found + mark.len();
            let next = self.bytes.get(start);
            if next.is_none_or(u8::is_ascii_whitespace) {
                self.at = start;
                return Ok(());
            }
        }
    }

    /// The problem of an unexpected word, or of the end of the file.
    pub fn unexpected(&self, expected: &str, found: Option<&[u8]>) -> Fault {
        let expected = expected.to_string();
        self.fault(match found.map(excerpt) {
            Some(found) => Problem::Expected { expected, found },
            None => Problem::Truncated { expected },
        })
    }

    /// The problem of an unexpected value.
    pub fn wrong(&self, expected: &str, found: impl ToString) -> Fault {
        let found = found.to_string();
        self.unexpected(expected, Some(found.as_bytes()))
    }

    /// The problem at the last word or number.
    pub fn fault(&self, problem: Problem) -> Fault {
        let before = &self.bytes[..self.last];
        let place = match self.binary {
            true => Place::Byte(self.last),
            false => Place::Line(1 + before.iter().filter(|&&b| b == b'\n').count()),
        };
        Fault { place, problem }
    }
}
