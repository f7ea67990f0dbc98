//! Input decks of Abaqus and CalculiX, `.inp`: nodes, elements, sets and surfaces. What follows `*STEP` is not read.
//!
//! Bodies are the sets of `*SOLID SECTION`. In a deck without sections, bodies are the sets of `*ELSET` if each cell is in exactly one of these sets; if not,
//! bodies are the sets that `*ELEMENT` names. Surfaces of element faces are boundaries. A set of nodes is a boundary if each of its
//! corners belongs to a face whose corners are all in the set.
//! Elements of lower dimension are facets of their sets.

mod deck;
mod groups;
mod kinds;
mod sets;

use super::contents::Contents;
use super::problem::{Fault, Place};
use deck::{Deck, Keyword, Section};

/// Whether the file begins with a keyword or a comment of a deck. LS-DYNA's files begin with `*KEYWORD`, and have columns in place of commas.
pub(super) fn recognised(start: &[u8]) -> bool {
    let begins = |word: &[u8]| {
        let own = start.get(..word.len());
        own.is_some_and(|own| own.eq_ignore_ascii_case(word))
    };
    let is_keyword = matches!(start, [b'*', letter, ..] if letter.is_ascii_alphabetic());
    begins(b"**") || is_keyword && !begins(b"*KEYWORD")
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut deck = Deck::default();
    let mut section = Section::Other;
    // a keyword line that goes on behind its last comma
    let mut begun: Vec<u8> = Vec::new();
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let at = |problem| Fault {
            place: Place::Line(number + 1),
            problem,
        };
        match line {
            [] | [b'*', b'*', ..] => continue,
            [b'*', keyword @ ..] => {
                section.check_whole().map_err(at)?;
                begun = keyword.to_vec();
            }
            more if !begun.is_empty() => begun.extend(more),
            data => deck.take(&mut section, data).map_err(at)?,
        }
        if !begun.is_empty() && begun.last() != Some(&b',') {
            match deck.section(&Keyword::new(&begun)).map_err(at)? {
                Some(next) => section = next,
                None => break,
            }
            begun.clear();
        }
    }
    section.check_whole()?;
    Ok(deck.contents()?)
}
