//! The lines of a deck.

use std::collections::{BTreeMap, BTreeSet};

use super::super::ElementKind;
use super::super::contents::Contents;
use super::super::problem::{Problem, excerpt};
use super::kinds::kind;
use super::sets::{Member, Names};

/// A keyword line: its name and its parameters, all in capitals, and the parameters' values.
pub(super) struct Keyword {
    name: String,
    parameters: Vec<(String, String)>,
}

impl Keyword {
    pub fn new(line: &[u8]) -> Self {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split(',').map(str::trim);
        let name = words.next().unwrap_or_default().to_ascii_uppercase();
        let parameters = words.map(|word| {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            let value = value.trim().trim_matches('"');
            (key.trim().to_ascii_uppercase(), value.to_string())
        });
        Keyword {
            name,
            parameters: parameters.collect(),
        }
    }

    fn has(&self, key: &str) -> bool {
        self.parameters.iter().any(|(own, _)| own == key)
    }

    fn value(&self, key: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|(own, _)| own == key);
        found.map(|(_, value)| value.as_str())
    }

    /// A value without which the keyword has no meaning.
    fn needed(&self, key: &str) -> Result<&str, Problem> {
        let value = self.value(key).filter(|value| !value.is_empty());
        value.ok_or_else(|| Problem::Expected {
            expected: format!("`{key}=` behind `*{}`", self.name),
            found: "none".to_string(),
        })
    }

    /// A deck that makes its mesh by this keyword.
    fn unsupported(&self, remedy: &'static str) -> Problem {
        let parameters = self.parameters.iter().map(|(key, _)| format!(", {key}"));
        Problem::Unsupported {
            found: format!(
                "a deck with `*{}{}`",
                self.name,
                parameters.collect::<String>()
            ),
            remedy,
        }
    }
}

/// What the lines below a keyword are.
pub(super) enum Section {
    Other,
    Nodes(Option<usize>),
    /// Elements of a kind in a set, and the numbers of the one that goes on in the next line.
    Elements {
        kind: ElementKind,
        is_shell: bool,
        set: Option<usize>,
        begun: Vec<i64>,
    },
    /// Members of a set of nodes or elements.
    Members {
        of_nodes: bool,
        set: usize,
        is_range: bool,
    },
    Surface(usize),
    /// Where an instance is.
    Placement,
}

impl Section {
    /// Checks that no element lacks nodes.
    pub fn check_whole(&self) -> Result<(), Problem> {
        match self {
            Section::Elements { kind, begun, .. } if !begun.is_empty() => Err(Problem::Expected {
                expected: format!("the nodes of a {kind}"),
                found: format!("{} of them", begun.len() - 1),
            }),
            _ => Ok(()),
        }
    }
}

/// An element: its kind, and where its nodes begin.
pub(super) struct Cell {
    pub kind: ElementKind,
    pub first: usize,
    /// Its faces are its two sides, and not its edges.
    pub is_shell: bool,
}

#[derive(Default)]
pub(super) struct Deck {
    pub contents: Contents,
    /// The index of each node by its number, and of each element.
    pub nodes: BTreeMap<i64, usize>,
    pub numbers: BTreeMap<i64, usize>,
    pub elements: Vec<Cell>,
    /// The numbers of the elements' nodes.
    pub flat: Vec<i64>,
    pub node_sets: Names<Member>,
    pub element_sets: Names<Member>,
    /// Elements and the numbers of their faces, 0 for all that are on the outside.
    pub surfaces: Names<(Member, usize)>,
    pub sections: BTreeSet<usize>,
    /// The sets that `*ELEMENT` names.
    pub headed: BTreeSet<usize>,
    /// The part or instance that is read, counted from 1, and the one that has nodes.
    scope: usize,
    scope_of_nodes: usize,
    instances: usize,
    is_in_assembly: bool,
    is_in_instance: bool,
}

const FLAT: &str = "write it without parts and assemblies, or a file for each part";

impl Deck {
    /// Whether what is defined here is the assembly's own.
    fn is_of_assembly(&self) -> bool {
        self.is_in_assembly && !self.is_in_instance
    }

    /// What follows a keyword; `None` where the mesh ends.
    pub fn section(&mut self, keyword: &Keyword) -> Result<Option<Section>, Problem> {
        if keyword.has("INPUT") {
            return Err(keyword.unsupported("write the mesh into one file"));
        }
        let own = self.is_of_assembly();
        Ok(Some(match keyword.name.as_str() {
            "STEP" => return Ok(None),
            "INCLUDE" => return Err(keyword.unsupported("write the mesh into one file")),
            "NGEN" | "NFILL" | "ELGEN" | "NCOPY" | "ELCOPY" | "NMAP" => {
                return Err(keyword.unsupported("write all nodes and elements with their numbers"));
            }
            "SYSTEM" => return Err(keyword.unsupported("write coordinates along fixed axes")),
            "PART" => {
                self.scope += 1;
                Section::Other
            }
            "INSTANCE" => {
                self.scope += 1;
                self.instances += 1;
                self.is_in_instance = true;
                if self.instances > 1 {
                    return Err(keyword.unsupported(FLAT));
                }
                Section::Placement
            }
            "END INSTANCE" => {
                self.is_in_instance = false;
                Section::Other
            }
            "ASSEMBLY" => {
                self.is_in_assembly = true;
                Section::Other
            }
            // points of reference, and sets of these
            "NODE" if own => Section::Other,
            "NSET" if own && !keyword.has("INSTANCE") => Section::Other,
            "NODE" => {
                let system = keyword.value("SYSTEM").unwrap_or("R");
                if !system.eq_ignore_ascii_case("R") {
                    return Err(keyword.unsupported("write coordinates along fixed axes"));
                }
                if !self.nodes.is_empty() && self.scope_of_nodes != self.scope {
                    return Err(Problem::Unsupported {
                        found: "a deck of several parts, each with numbers of its own".to_string(),
                        remedy: FLAT,
                    });
                }
                self.scope_of_nodes = self.scope;
                let set = keyword.value("NSET");
                let set = set
                    .map(|name| self.node_sets.number(name, own))
                    .transpose()?;
                Section::Nodes(set)
            }
            "ELEMENT" => {
                let name = keyword.needed("TYPE")?;
                let kind = kind(name).ok_or_else(|| Problem::UnsupportedElement {
                    kind: format!("`{name}`"),
                })?;
                let set = keyword.value("ELSET");
                Section::Elements {
                    kind: kind.0,
                    is_shell: kind.1,
                    set: set
                        .map(|name| self.element_sets.number(name, own))
                        .transpose()?,
                    begun: Vec::new(),
                }
            }
            "NSET" if keyword.has("ELSET") => {
                return Err(keyword.unsupported("name the nodes of the set"));
            }
            "NSET" => Section::Members {
                of_nodes: true,
                set: self.node_sets.number(keyword.needed("NSET")?, own)?,
                is_range: keyword.has("GENERATE"),
            },
            "ELSET" => Section::Members {
                of_nodes: false,
                set: self.element_sets.number(keyword.needed("ELSET")?, own)?,
                is_range: keyword.has("GENERATE"),
            },
            "SURFACE" if keyword.has("COMBINE") => {
                return Err(keyword.unsupported("name the faces of the surface"));
            }
            "SURFACE" => match keyword.value("TYPE") {
                Some(other) if !other.eq_ignore_ascii_case("ELEMENT") => Section::Other,
                _ => Section::Surface(self.surfaces.number(keyword.needed("NAME")?, own)?),
            },
            "SOLID SECTION" => {
                let name = keyword.needed("ELSET")?;
                let set = self.element_sets.find(name);
                let set = set.ok_or_else(|| Problem::Expected {
                    expected: "a set of elements that is defined before its section".to_string(),
                    found: name.to_string(),
                })?;
                self.sections.insert(set);
                Section::Other
            }
            _ => Section::Other,
        }))
    }

    /// Takes a line of data.
    pub fn take(&mut self, section: &mut Section, line: &[u8]) -> Result<(), Problem> {
        if matches!(section, Section::Other) {
            return Ok(());
        }
        let text = std::str::from_utf8(line).map_err(|_| expected("numbers and names", line))?;
        let words = text.split(',').map(str::trim);
        let mut words = words.filter(|word| !word.is_empty());
        match section {
            Section::Other => {}
            Section::Placement => {
                let is_zero = |word: &str| word.parse::<f64>().is_ok_and(|x| x == 0.0);
                if !words.all(is_zero) {
                    return Err(Problem::Unsupported {
                        found: "a deck whose instance is moved from where its part is".to_string(),
                        remedy: FLAT,
                    });
                }
            }
            Section::Nodes(set) => {
                let own = number(words.next().unwrap_or_default())?;
                let mut point = [0.0; 3];
                for (x, word) in point.iter_mut().zip(words) {
                    // Fortran's exponents
                    let text = word.replace(['d', 'D'], "e");
                    let value = text.parse();
                    *x = value.map_err(|_| expected("a coordinate", word.as_bytes()))?;
                }
                let told = own.unsigned_abs();
                let index = self.contents.vertices.len();
                if self.nodes.insert(own, index).is_some() {
                    return Err(Problem::RepeatedNode { number: told });
                }
                self.contents.add_vertex(told, point)?;
                if let Some(set) = set {
                    self.node_sets.all[*set].members.push(Member::One(own));
                }
            }
            Section::Elements {
                kind,
                is_shell,
                set,
                begun,
            } => {
                for word in words {
                    begun.push(number(word)?);
                }
                if begun.len() > kind.nodes() + 1 {
                    return Err(expected(&format!("the nodes of a {kind}"), line));
                }
                if begun.len() > kind.nodes() {
                    let cell = Cell {
                        kind: *kind,
                        first: self.flat.len(),
                        is_shell: *is_shell,
                    };
                    self.flat.extend(&begun[1..]);
                    let own = begun[0];
                    if self.numbers.insert(own, self.elements.len()).is_some() {
                        let once = "elements with numbers of their own";
                        return Err(expected(once, own.to_string().as_bytes()));
                    }
                    self.elements.push(cell);
                    if let Some(set) = set {
                        self.headed.insert(*set);
                        self.element_sets.all[*set].members.push(Member::One(own));
                    }
                    begun.clear();
                }
            }
            Section::Members {
                of_nodes,
                set,
                is_range,
            } => {
                let members = match of_nodes {
                    true => &mut self.node_sets.all[*set].members,
                    false => &mut self.element_sets.all[*set].members,
                };
                if *is_range {
                    let found = words.map(number).collect::<Result<Vec<_>, _>>()?;
                    members.push(Member::Range(match found[..] {
                        [first, last] => [first, last, 1],
                        [first, last, step] if step > 0 => [first, last, step],
                        _ => {
                            let range = "the first number, the last one and a step";
                            return Err(expected(range, line));
                        }
                    }));
                } else {
                    members.extend(words.map(Member::new));
                }
            }
            Section::Surface(surface) => {
                let of = words.next().unwrap_or_default();
                let face = words.next().unwrap_or_default();
                let number = face.strip_prefix(['S', 's']);
                let number = number.and_then(|face| face.parse().ok());
                let which = match face {
                    "" => Some(0),
                    _ => number.filter(|which| (1..=4).contains(which)),
                };
                let which = which.ok_or_else(|| expected("a face from `S1` to `S4`", line))?;
                let members = &mut self.surfaces.all[*surface].members;
                members.push((Member::new(of), which));
            }
        }
        Ok(())
    }
}

fn number(word: &str) -> Result<i64, Problem> {
    let number = word.parse();
    number.map_err(|_| expected("a number", word.as_bytes()))
}

fn expected(what: &str, found: &[u8]) -> Problem {
    Problem::Expected {
        expected: what.to_string(),
        found: excerpt(found),
    }
}
