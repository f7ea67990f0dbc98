//! The sets and surfaces of a deck.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::super::problem::Problem;

/// A member of a set.
pub(super) enum Member {
    One(i64),
    /// From the first to the last, in steps.
    Range([i64; 3]),
    /// All of another set.
    Set(String),
}

impl Member {
    /// A number or the name of a set.
    pub fn new(word: &str) -> Self {
        match word.parse() {
            Ok(number) => Member::One(number),
            Err(_) => Member::Set(word.trim_matches('"').to_string()),
        }
    }
}

/// A set of nodes or elements, or a surface.
pub(super) struct Named<T> {
    pub name: String,
    pub members: Vec<T>,
    /// Whether it was defined in the assembly.
    pub is_of_assembly: bool,
}

/// Things by their names, which do not tell capitals from small letters.
pub(super) struct Names<T> {
    pub all: Vec<Named<T>>,
    index: HashMap<String, usize>,
}

impl<T> Default for Names<T> {
    fn default() -> Self {
        Names {
            all: Vec::new(),
            index: HashMap::new(),
        }
    }
}

impl<T> Names<T> {
    /// The number of the thing with this name, which is new or goes on.
    ///
    /// # Errors
    /// If a part and the assembly have one each.
    pub fn number(&mut self, name: &str, is_of_assembly: bool) -> Result<usize, Problem> {
        let next = self.all.len();
        let number = *self.index.entry(name.to_ascii_uppercase()).or_insert(next);
        if number == next {
            self.all.push(Named {
                name: name.to_string(),
                members: Vec::new(),
                is_of_assembly,
            });
        }
        match self.all[number].is_of_assembly == is_of_assembly {
            true => Ok(number),
            false => Err(Problem::Unsupported {
                found: format!(
                    "a deck with `{name}` in a part and another `{name}` in the assembly"
                ),
                remedy: "give them names of their own, or write it without parts and assemblies",
            }),
        }
    }

    pub fn find(&self, name: &str) -> Option<usize> {
        self.index.get(&name.to_ascii_uppercase()).copied()
    }
}

/// Sets may be in sets so often.
const DEEPEST: usize = 100;

/// The indices of the members of a set, in ascending order. A range stands for the numbers in it that the deck has.
///
/// # Errors
/// Names and numbers that there are not, and sets that are too deep in each other.
pub(super) fn members(
    sets: &Names<Member>,
    set: usize,
    known: &BTreeMap<i64, usize>,
) -> Result<Vec<usize>, Problem> {
    let mut found = BTreeSet::new();
    let (mut open, mut seen) = (vec![(set, 0)], BTreeSet::from([set]));
    while let Some((set, depth)) = open.pop() {
        let Named { name, members, .. } = &sets.all[set];
        let lacks = |what: &str| Problem::Expected {
            expected: format!("a number or a set that is in the deck, in `{name}`"),
            found: what.to_string(),
        };
        if depth > DEEPEST {
            return Err(Problem::Unsupported {
                found: format!("a deck with sets in sets more than {DEEPEST} times"),
                remedy: "name the members themselves",
            });
        }
        for member in members {
            match member {
                Member::One(number) => {
                    let index = known.get(number);
                    found.insert(*index.ok_or_else(|| lacks(&number.to_string()))?);
                }
                Member::Range([first, last, step]) if first <= last => {
                    let fits = |number: i64| (number as i128 - *first as i128) % *step as i128 == 0;
                    let within = known.range(first..=last);
                    found.extend(within.filter(|(number, _)| fits(**number)).map(|own| own.1));
                }
                Member::Range(_) => {}
                Member::Set(other) => {
                    let other = sets.find(other).ok_or_else(|| lacks(other))?;
                    open.extend(seen.insert(other).then_some((other, depth + 1)));
                }
            }
        }
    }
    Ok(found.into_iter().collect())
}
