//! What a text may mean that is no scene: hints behind what the parser says.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::tables::{Table, file, header, tables};
use super::words::of_keys;

/// What the parser says, in the words of a file, and what may be meant. Where the text is no TOML, or has the wrong brackets, the hint
/// takes the place of what the parser says.
pub(super) fn told_with_hint(text: &str, why: &toml::de::Error) -> String {
    let whole = why.to_string();
    let (said, message) = (whole.trim_end(), why.message());
    let Some(span) = why.span() else {
        return of_keys(said).into_owned();
    };
    let in_place = brackets(text, &span, message).or_else(|| {
        let is_toml = DeTable::parse(text).is_ok();
        (!is_toml).then(|| syntax(text, &span)).flatten()
    });
    if let (Some(hint), Some(place)) = (in_place, said.strip_suffix(message)) {
        return format!("{}{hint}", of_keys(place));
    }
    let said = of_keys(said);
    match unknown(text, &span, message).or_else(|| among_names(text, &span)) {
        Some(hint) => format!("{said}\n{hint}"),
        None => said.into_owned(),
    }
}

/// What others call a key.
const OTHER_WORDS: [(&str, &str); 8] = [
    ("plane", "half-space"),
    ("sphere", "ball"),
    ("circle", "ball"),
    ("box", "cuboid"),
    ("nu", "poisson"),
    ("e", "young"),
    ("modulus", "young"),
    ("material", "law"),
];

/// What moves a body, and no obstacle.
const LOADS: [&str; 16] = [
    "force",
    "forces",
    "load",
    "loads",
    "weight",
    "mass",
    "spring",
    "springs",
    "stiffness",
    "foundations",
    "torque",
    "moment",
    "traction",
    "tractions",
    "pressures",
    "bodyforce",
];

/// A name that a table does not have: a misspelt one of its own, or one of another table.
fn unknown(text: &str, span: &Range<usize>, message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let is_name = ["unknown field", "unknown variant"]
        .iter()
        .any(|begin| message.starts_with(begin));
    let name = quoted.next().filter(|_| is_name)?;
    let own: Vec<&str> = quoted.collect();
    let meant = |own: &str| format!("did you mean `{own}`?");
    if plain(name) == "planestrain" {
        return Some(
            "meshes in the plane are in plane strain without any key: leave it out".into(),
        );
    }
    let is_known =
        |(word, own_name): &&(&str, &str)| *word == plain(name) && own.contains(own_name);
    if let Some((_, own)) = OTHER_WORDS.iter().find(is_known) {
        return Some(meant(own));
    }
    if let Some(own) = own.iter().find(|own| singular(own) == singular(name)) {
        return Some(meant(own));
    }
    let way = way(text, span);
    let is_driven = LOADS.contains(&plain(name).as_str());
    if is_driven && way.iter().flatten().any(|table| table == "obstacle") {
        return Some(
            "an obstacle goes where its `motion` takes it: a tool that a force or a spring moves is a body with `law = \"rigid\"`".into(),
        );
    }
    let elsewhere = way.and_then(|way| elsewhere(text, name, &way[..way.len() - 1]));
    elsewhere.or_else(|| nearest(name, own.iter().copied()).map(meant))
}

/// Where a key belongs that the table at the end of this way does not have.
pub(super) fn elsewhere(text: &str, name: &str, way: &[String]) -> Option<String> {
    let same = |own: &&&str| plain(own) == plain(name);
    let file = file();
    if let Some(key) = file.keys.iter().find(same) {
        return Some(match header(key) {
            Some(header) => {
                format!("`{key}` is a table of the file as a whole: write `{header}`")
            }
            None => format!(
                "`{key}` is a key of the file as a whole: move it above the first {}",
                first_header(text)
            ),
        });
    }
    let has = |table: Table| table.keys.iter().find(same).map(|key| (table, *key));
    let mut found: Vec<(Table, &str)> = tables().into_iter().filter_map(has).collect();
    // of several tables, those that are in the one where it stands, or around it
    let near = |(table, _): &(Table, &str)| {
        way.last().is_some_and(|own| own == table.within) || way.iter().any(|own| own == table.name)
    };
    if found.iter().any(near) {
        found.retain(near);
    }
    let (_, key) = *found.first()?;
    let name =
        |(table, _): &(Table, &str)| format!("`{}`", header(table.name).unwrap_or(table.name));
    let mut names: Vec<String> = found.iter().map(name).collect();
    names.dedup();
    let there = match header(found[0].0.name) {
        Some(header) if found.len() == 1 => format!("right below `{header}`"),
        _ => "there".into(),
    };
    Some(format!(
        "`{key}` is a key of {}: move it {there}",
        alternatives(&names)
    ))
}

/// "a", "a or b", "a, b or c".
fn alternatives(names: &[String]) -> String {
    match names {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// The brackets of the first header, and its line.
fn first_header(text: &str) -> String {
    let mut lines = text.lines().enumerate();
    let first = lines.find(|(_, line)| line.trim_start().starts_with('['));
    match first {
        Some((k, line)) if line.trim_start().starts_with("[[") => {
            format!("`[[…]]`, line {}", k + 1)
        }
        Some((k, _)) => format!("`[…]`, line {}", k + 1),
        None => "table".into(),
    }
}

/// A key of another table below `[body.boundaries]` or `[ipopt]`, where all keys are names.
fn among_names(text: &str, span: &Range<usize>) -> Option<String> {
    let way = way(text, span)?;
    let has_names = |own: &String| ["boundaries", "ipopt"].contains(&own.as_str());
    let at = way.iter().position(has_names)?;
    let name = way.get(at + 1)?;
    elsewhere(text, name, &way[..=at])
}

/// A header with the wrong number of brackets, or one that is there twice.
fn brackets(text: &str, span: &Range<usize>, message: &str) -> Option<String> {
    let line = line_of(text, span.start);
    let header = line.trim();
    let header = header.split('#').next().unwrap_or_default().trim_end();
    let single = header.strip_prefix('[').and_then(|h| h.strip_suffix(']'));
    let double = single.and_then(|h| h.strip_prefix('[')?.strip_suffix(']'));
    let path = double.or(single).filter(|path| {
        let is_key = |c: char| c.is_alphanumeric() || "_-.".contains(c);
        path.chars().all(is_key)
    });
    let source = text.get(span.clone()).unwrap_or_default();
    let is_list = |path: &str| {
        let last = path.rsplit('.').next().unwrap_or(path);
        LISTS.contains(&last)
    };
    let Some(path) = path else {
        let is_table =
            source.starts_with('{') && message == "invalid type: map, expected a sequence";
        return is_table
            .then(|| "this is a list: put brackets around its entries, as `[{ … }]`".into());
    };
    let outer = source.trim_matches(['[', ']']);
    match message {
        "duplicate key" if is_list(path) => Some(format!(
            "`{path}` is a list: write `[[{path}]]` for each entry"
        )),
        "duplicate key" => Some(format!("`{path}` is there twice: put the two together")),
        _ if !message.starts_with("invalid type") => None,
        // what is around it has no header
        _ if outer != path && is_list(outer) => Some(format!(
            "`{outer}` is a list: write `[[{outer}]]` above `{header}`"
        )),
        _ if double.is_some() && !is_list(path) => {
            Some(format!("`{path}` is one table: write `[{path}]`"))
        }
        _ if double.is_none() && is_list(path) => {
            Some(format!("`{path}` is a list: write `[[{path}]]`"))
        }
        _ => None,
    }
}

/// The keys with lists of tables.
const LISTS: [&str; 12] = [
    "body",
    "contact",
    "tie",
    "obstacle",
    "phase",
    "supports",
    "tractions",
    "pressures",
    "forces",
    "foundations",
    "laws",
    "curved",
];

/// A text that is no TOML: a decimal comma, a number without a digit beside its point, a word without quotes, or a colon.
fn syntax(text: &str, span: &Range<usize>) -> Option<String> {
    let at = span.start.min(text.len());
    let line = line_of(text, at);
    if let Some((number, point)) = decimal_comma(line) {
        return Some(format!("`{number}` has a decimal comma: write `{point}`"));
    }
    let column = at - text[..at].rfind('\n').map_or(0, |k| k + 1);
    let (before, behind) = line.split_at_checked(column)?;
    if behind.starts_with(':') || before.trim_end().ends_with(':') {
        return Some("`:` is no sign of TOML: write `=` between a key and its value".into());
    }
    if let Some(hint) = of_value(line) {
        return Some(hint.into());
    }
    let is_around = |c: char| c.is_whitespace() || "=,[]{}#".contains(c);
    let begin = before.rfind(is_around).map_or(0, |k| k + 1);
    let value = line[begin..].split(is_around).next().unwrap_or_default();
    let is_value = line[..begin].trim_end().ends_with(['=', ',', '[']);
    (is_value && !value.is_empty())
        .then(|| written(value))
        .flatten()
}

/// What is wrong with the value of a line: its brackets, commas, quotes, a unit, or a remark.
fn of_value(line: &str) -> Option<&'static str> {
    let (_, value) = line.split_once('=')?;
    let value = value.trim();
    let words: Vec<&str> = value.trim_matches(['[', ']']).split_whitespace().collect();
    let are_numbers = |words: &[&str]| words.iter().all(|word| word.parse::<f64>().is_ok());
    let is_unit = |word: &str| word.chars().all(char::is_alphabetic);
    match &words[..] {
        _ if value.contains(['“', '”', '„', '‘', '’']) => {
            Some("quotes are straight in TOML: write `\"`")
        }
        _ if value.starts_with('(') => Some("a list has square brackets: write `[…]`"),
        _ if value.contains("//") => Some("a remark begins with `#`, not with `//`"),
        [_, _, ..] if value.starts_with('[') && are_numbers(&words) => {
            Some("the entries of a list have commas between them")
        }
        [number, unit] if are_numbers(&[*number]) && is_unit(unit) => {
            Some("a number has no unit: write the number alone, in the units of the scene")
        }
        _ => None,
    }
}

/// How a value is written that has no digit beside its point, or no quotes.
fn written(value: &str) -> Option<String> {
    let bare = value.trim_start_matches(['+', '-']);
    let sign = &value[..value.len() - bare.len()];
    if let Some(digits) = bare.strip_prefix('.').filter(|rest| is_number(rest)) {
        return Some(format!(
            "`{value}` has no digit before its point: write `{sign}0.{digits}`"
        ));
    }
    if let Some(digits) = bare.strip_suffix('.').filter(|rest| is_number(rest)) {
        return Some(format!(
            "`{value}` has no digit behind its point: write `{sign}{digits}.0`"
        ));
    }
    let is_word = value.starts_with(char::is_alphabetic);
    is_word.then(|| format!("`{value}` has no quotes: write `\"{value}\"`"))
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_digit())
}

/// A number with a decimal comma behind the sign `=`, and the number that it means.
fn decimal_comma(line: &str) -> Option<(String, String)> {
    let is_digit = |c: char| c.is_ascii_digit();
    line.match_indices(',').find_map(|(at, _)| {
        let (before, behind) = (&line[..at], &line[at + 1..]);
        let begin = before.trim_end_matches(is_digit);
        let begin = begin.trim_end_matches(['+', '-']);
        let whole = &before[begin.len()..];
        let end = behind.trim_start_matches(is_digit);
        let share = &behind[..behind.len() - end.len()];
        let is_one = whole.ends_with(is_digit) && !share.is_empty();
        let is_value = begin.trim_end().ends_with('=');
        (is_one && is_value).then(|| (format!("{whole},{share}"), format!("{whole}.{share}")))
    })
}

/// What a list with too many numbers may mean: one of them may have a decimal comma, as in `[0,5, 1]`.
pub(super) fn decimal_comma_in_list(list: &str) -> Option<String> {
    let inner = list.strip_prefix('[')?.strip_suffix(']')?;
    let mut words = inner.split_whitespace();
    let pair = words.find_map(|word| {
        let (whole, share) = word.trim_end_matches(',').split_once(',')?;
        let digits = whole.trim_start_matches(['+', '-']);
        (is_number(digits) && is_number(share)).then_some((whole, share))
    });
    let (whole, share) = pair?;
    Some(format!(
        "if `{whole},{share}` is one number, write `{whole}.{share}`"
    ))
}

/// The line of a byte.
fn line_of(text: &str, at: usize) -> &str {
    let at = at.min(text.len());
    let begin = text[..at].rfind('\n').map_or(0, |k| k + 1);
    let rest = &text[begin..];
    rest.split('\n').next().unwrap_or(rest)
}

/// The keys that lead to a key or a value with this span; lists have none of their own.
fn way(text: &str, span: &Range<usize>) -> Option<Vec<String>> {
    fn of_value(value: &Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<Vec<String>> {
        let own = || (value.span() == *span).then(Vec::new);
        match value.get_ref() {
            DeValue::Table(table) => of_table(table, span).or_else(own),
            DeValue::Array(list) => list
                .iter()
                .find_map(|entry| of_value(entry, span))
                .or_else(own),
            _ => own(),
        }
    }
    fn of_table(table: &DeTable<'_>, span: &Range<usize>) -> Option<Vec<String>> {
        table.iter().find_map(|(key, value)| {
            let rest = match key.span() == *span {
                true => Some(Vec::new()),
                false => of_value(value, span),
            };
            let name = key.get_ref().to_string();
            rest.map(|rest| [vec![name], rest].concat())
        })
    }
    of_table(DeTable::parse(text).ok()?.get_ref(), span)
}

/// A name without case, and without what joins its words.
fn plain(name: &str) -> String {
    let letters = name.chars().filter(|c| !"_- ".contains(*c));
    letters.flat_map(char::to_lowercase).collect()
}

/// As [`plain`], of one.
fn singular(name: &str) -> String {
    let name = plain(name);
    match (name.strip_suffix("ies"), name.strip_suffix('s')) {
        (Some(begin), _) => format!("{begin}y"),
        (None, Some(begin)) if begin.len() > 1 => begin.into(),
        _ => name,
    }
}

/// The name that is meant: at most a third of its letters are others, or one of the two begins with the other.
fn nearest<'a>(name: &str, all: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = plain(name);
    let near = all.filter_map(|own| {
        let other = plain(own);
        let off = strsim::damerau_levenshtein(&name, &other);
        let [short, long] = [name.len().min(other.len()), name.len().max(other.len())];
        let begins = short >= 4 && (name.starts_with(&other) || other.starts_with(&name));
        (begins || off <= long / 3).then_some((off, own))
    });
    near.min_by_key(|(off, _)| *off).map(|(_, own)| own)
}

#[cfg(test)]
mod tests {
    use super::super::keys::Keys;
    use super::*;

    #[test]
    fn names_are_near_by_few_letters_or_by_their_beginning() {
        let all = [
            "young",
            "poisson",
            "law",
            "laws",
            "mesh",
            "averaged-volumes",
        ];
        let near = |name| nearest(name, all.into_iter());
        assert_eq!(near("yuong"), Some("young"));
        assert_eq!(near("youngs_modulus"), Some("young"));
        assert_eq!(near("Possion"), Some("poisson"));
        assert_eq!(near("averaged"), Some("averaged-volumes"));
        for far in ["E", "nu", "material", "steps"] {
            assert_eq!(near(far), None, "{far}");
        }
    }

    /// Wherever a key of the file stands by mistake, it is sent above the first table.
    #[test]
    fn all_keys_of_the_file_are_sent_there() {
        for key in file().keys {
            let text = format!("[[contact]]\nfirst = [\"a\", 1]\n{key} = 1\n");
            let why = toml::from_str::<Keys>(&text).expect_err("no key of a contact");
            let told = told_with_hint(&text, &why);
            let hint = match header(key) {
                Some(header) => {
                    format!("`{key}` is a table of the file as a whole: write `{header}`")
                }
                None => format!(
                    "`{key}` is a key of the file as a whole: move it above the first `[[…]]`, line 1"
                ),
            };
            assert_eq!(told.lines().last(), Some(&*hint), "{told}");
        }
    }

    #[test]
    fn commas_between_values_are_no_decimal_commas() {
        let found = |line| decimal_comma(line).map(|(_, point)| point);
        assert_eq!(found("y = -0,1 }"), Some("-0.1".into()));
        assert_eq!(found("a = 1, b =2,50"), Some("2.50".into()));
        let meant = decimal_comma_in_list("[-0,5, 1]");
        assert_eq!(
            meant.as_deref(),
            Some("if `-0,5` is one number, write `-0.5`")
        );
        assert_eq!(decimal_comma_in_list("[1, 0, 2.5]"), None);
        for line in ["x = 1, y = 2", "p = [0,5]", "x = 1 ,5", "\"1,5\" = 2"] {
            assert_eq!(found(line), None, "{line}");
        }
    }
}
