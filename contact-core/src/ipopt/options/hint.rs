//! Suggestions for misspelt option names.

use super::{KNOWN_OPTIONS, check::bare};
use crate::ipopt::VERSION;

/// The option of this version of Ipopt whose name is nearest, if it is near enough for a typing error: at most one
/// wrong letter in three, and at most three.
pub(super) fn nearest(name: &str) -> Option<String> {
    let bare = bare(name);
    let typed = bare.to_ascii_lowercase();
    let known = KNOWN_OPTIONS.iter().filter(|option| option.is_in(VERSION));
    let (distance, nearest) = known
        .map(|option| {
            (
                distance(typed.as_bytes(), option.name.as_bytes()),
                option.name,
            )
        })
        .min()?;
    let prefix = &name[..name.len() - bare.len()];
    (distance <= (typed.len() / 3).clamp(1, 3)).then(|| format!("{prefix}{nearest}"))
}

/// The edit distance: letters to insert, delete or replace.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_pen_are_near() {
        for (typed, meant) in [
            ("maxiter", Some("max_iter")),
            ("max_itr", Some("max_iter")),
            ("Max_Iterr", Some("max_iter")),
            ("toll", Some("tol")),
            ("linear_sovler", Some("linear_solver")),
            ("resto.max_itre", Some("resto.max_iter")),
            ("a_solver_option", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(nearest(typed).as_deref(), meant, "{typed}");
        }
        assert_eq!(distance(b"kitten", b"sitting"), 3);
        assert_eq!((distance(b"", b"abc"), distance(b"abc", b"")), (3, 3));
    }
}
