//! Input decks of Abaqus and CalculiX, `.inp`: nodes, elements, sets and surfaces. What follows `*STEP` is not read.
//!
//! Bodies are the sets of `*SOLID SECTION`. In a deck without sections they are those of `*ELSET`, where each cell is in one of these, and else those that
//! `*ELEMENT` names. Surfaces of element faces are boundaries, and so are sets of nodes that have all corners of a face on the outside. Elements of lower dimension
//! are facets of their sets.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::ElementKind;
use super::contents::Contents;
use super::parts::{Corners, sorted};
use super::problem::{Fault, Place, Problem, excerpt};

/// Whether the file begins with a keyword or a comment of a deck. LS-DYNA's files begin with `*KEYWORD`, and have columns in place of commas.
pub(super) fn recognised(start: &[u8]) -> bool {
    let begins = |word: &[u8]| {
        start
            .get(..word.len())
            .is_some_and(|own| own.eq_ignore_ascii_case(word))
    };
    let is_keyword = matches!(start, [b'*', letter, ..] if letter.is_ascii_alphabetic());
    begins(b"**") || is_keyword && !begins(b"*KEYWORD")
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut deck = Deck::default();
    let mut section = Section::Other;
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let at = |problem| Fault {
            place: Place::Line(number + 1),
            problem,
        };
        match line {
            [] | [b'*', b'*', ..] => {}
            [b'*', keyword @ ..] => {
                section.check_whole().map_err(at)?;
                match deck.section(&Keyword::new(keyword)).map_err(at)? {
                    Some(next) => section = next,
                    None => break,
                }
            }
            data => deck.take(&mut section, data).map_err(at)?,
        }
    }
    section.check_whole()?;
    deck.contents()
}

/// A keyword line: its name and its parameters, all in capitals, and the parameters' values.
struct Keyword {
    name: String,
    parameters: Vec<(String, String)>,
}

impl Keyword {
    fn new(line: &[u8]) -> Self {
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
        self.value(key)
            .filter(|value| !value.is_empty())
            .ok_or_else(|| Problem::Expected {
                expected: format!("`{key}=` behind `*{}`", self.name),
                found: "none".to_string(),
            })
    }
}

/// What the lines below a keyword are.
enum Section {
    Other,
    Nodes(Option<usize>),
    /// Elements of a kind in a set, and the numbers of the one that goes on in the next line.
    Elements {
        kind: ElementKind,
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
}

impl Section {
    /// Checks that no element lacks nodes.
    fn check_whole(&self) -> Result<(), Problem> {
        match self {
            Section::Elements { kind, begun, .. } if !begun.is_empty() => Err(Problem::Expected {
                expected: format!("the nodes of a {kind}"),
                found: format!("{} of them", begun.len() - 1),
            }),
            _ => Ok(()),
        }
    }
}

/// A member of a set.
enum Member {
    One(i64),
    /// From the first to the last, in steps.
    Range([i64; 3]),
    /// All of another set.
    Set(String),
}

/// A set of nodes or elements, or a surface.
struct Named<T> {
    name: String,
    members: Vec<T>,
}

/// Things by their names, which do not tell capitals from small letters.
struct Names<T> {
    all: Vec<Named<T>>,
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
    /// The number of the thing with this name, which is new or not.
    fn number(&mut self, name: &str) -> usize {
        let next = self.all.len();
        let number = *self.index.entry(name.to_ascii_uppercase()).or_insert(next);
        if number == next {
            self.all.push(Named {
                name: name.to_string(),
                members: Vec::new(),
            });
        }
        number
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.index.get(&name.to_ascii_uppercase()).copied()
    }
}

#[derive(Default)]
struct Deck {
    contents: Contents,
    /// The index of each node by its number, and of each element.
    nodes: BTreeMap<i64, usize>,
    numbers: BTreeMap<i64, usize>,
    /// The kind of each element, and where its nodes begin.
    elements: Vec<(ElementKind, usize)>,
    flat: Vec<usize>,
    node_sets: Names<Member>,
    element_sets: Names<Member>,
    /// Elements and the numbers of their faces, 0 for all that are on the outside.
    surfaces: Names<(Member, usize)>,
    sections: BTreeSet<usize>,
    /// The sets that `*ELEMENT` names.
    headed: BTreeSet<usize>,
    parts: usize,
    instances: usize,
    is_in_assembly: bool,
}

impl Deck {
    /// What follows a keyword; `None` where the mesh ends.
    fn section(&mut self, keyword: &Keyword) -> Result<Option<Section>, Problem> {
        let elsewhere = || Problem::Unsupported {
            found: format!("a deck with `*{}` in another file", keyword.name),
            remedy: "write the mesh into one file",
        };
        if keyword.has("INPUT") {
            return Err(elsewhere());
        }
        Ok(Some(match keyword.name.as_str() {
            "STEP" => return Ok(None),
            "INCLUDE" => return Err(elsewhere()),
            "NGEN" | "NFILL" | "ELGEN" | "NCOPY" | "ELCOPY" | "NMAP" => {
                return Err(Problem::Unsupported {
                    found: format!("a deck whose mesh is made by `*{}`", keyword.name),
                    remedy: "write all nodes and elements with their numbers",
                });
            }
            "PART" | "INSTANCE" => {
                let count = match keyword.name.as_str() {
                    "PART" => &mut self.parts,
                    _ => &mut self.instances,
                };
                *count += 1;
                if *count > 1 {
                    return Err(Problem::Unsupported {
                        found: "a deck of several parts or instances, each with numbers of its own"
                            .to_string(),
                        remedy: "write it without parts and assemblies, or a file for each part",
                    });
                }
                Section::Other
            }
            "ASSEMBLY" => {
                self.is_in_assembly = true;
                Section::Other
            }
            // points of reference
            "NODE" if self.is_in_assembly => Section::Other,
            "NODE" => Section::Nodes(self.node_set(keyword.value("NSET"))),
            "ELEMENT" => {
                let name = keyword.needed("TYPE")?;
                let kind = kind(name).ok_or_else(|| Problem::UnsupportedElement {
                    kind: format!("`{name}`"),
                })?;
                let set = keyword.value("ELSET");
                Section::Elements {
                    kind,
                    set: set.map(|name| self.element_sets.number(name)),
                    begun: Vec::new(),
                }
            }
            "NSET" => Section::Members {
                of_nodes: true,
                set: self.node_sets.number(keyword.needed("NSET")?),
                is_range: keyword.has("GENERATE"),
            },
            "ELSET" => Section::Members {
                of_nodes: false,
                set: self.element_sets.number(keyword.needed("ELSET")?),
                is_range: keyword.has("GENERATE"),
            },
            "SURFACE"
                if keyword
                    .value("TYPE")
                    .is_none_or(|kind| kind.eq_ignore_ascii_case("ELEMENT")) =>
            {
                Section::Surface(self.surfaces.number(keyword.needed("NAME")?))
            }
            "SOLID SECTION" => {
                let set = self.element_sets.number(keyword.needed("ELSET")?);
                self.sections.insert(set);
                Section::Other
            }
            _ => Section::Other,
        }))
    }

    fn node_set(&mut self, name: Option<&str>) -> Option<usize> {
        name.map(|name| self.node_sets.number(name))
    }

    /// Takes a line of data.
    fn take(&mut self, section: &mut Section, line: &[u8]) -> Result<(), Problem> {
        let text = std::str::from_utf8(line).map_err(|_| expected("numbers and names", line))?;
        let words = text
            .split(',')
            .map(str::trim)
            .filter(|word| !word.is_empty());
        let number = |word: &str| {
            word.parse::<i64>()
                .map_err(|_| expected("a number", word.as_bytes()))
        };
        match section {
            Section::Other => {}
            Section::Nodes(set) => {
                let mut words = words;
                let own = number(words.next().unwrap_or_default())?;
                let mut point = [0.0; 3];
                for (x, word) in point.iter_mut().zip(words) {
                    // Fortran's exponents
                    let text = word.replace(['d', 'D'], "e");
                    *x = text
                        .parse()
                        .map_err(|_| expected("a coordinate", word.as_bytes()))?;
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
            Section::Elements { kind, set, begun } => {
                for word in words {
                    begun.push(number(word)?);
                }
                if begun.len() > kind.nodes() {
                    let (own, nodes) = (begun[0], &begun[1..]);
                    if nodes.len() > kind.nodes() {
                        return Err(expected(&format!("the nodes of a {kind}"), line));
                    }
                    let first = self.flat.len();
                    for node in nodes {
                        let known = self.nodes.get(node).ok_or_else(|| Problem::UnknownNode {
                            number: node.to_string(),
                            nodes: self.nodes.len(),
                        })?;
                        self.flat.push(*known);
                    }
                    if *kind == ElementKind::Segment3 {
                        self.put_middle_last(first);
                    }
                    self.numbers.insert(own, self.elements.len());
                    self.elements.push((*kind, first));
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
                    let (first, last, step) = match found[..] {
                        [first, last] => (first, last, 1),
                        [first, last, step] if step > 0 => (first, last, step),
                        _ => {
                            return Err(expected(
                                "the first number, the last one and a step",
                                line,
                            ));
                        }
                    };
                    members.push(Member::Range([first, last, step]));
                } else {
                    members.extend(words.map(member));
                }
            }
            Section::Surface(surface) => {
                let mut words = words;
                let of = words.next().unwrap_or_default();
                let face = words.next().unwrap_or_default();
                let number = face
                    .strip_prefix(['S', 's'])
                    .and_then(|face| face.parse().ok());
                let which = match face {
                    "" => Some(0),
                    _ => number.filter(|which| (1..=4).contains(which)),
                };
                let which = which.ok_or_else(|| expected("a face from `S1` to `S4`", line))?;
                let members = &mut self.surfaces.all[*surface].members;
                members.push((member(of), which));
            }
        }
        Ok(())
    }

    /// Programs do not agree on the place of the middle node of three on a line.
    fn put_middle_last(&mut self, first: usize) {
        let nodes = &mut self.flat[first..first + 3];
        let [a, b, c] = [0, 1, 2].map(|k| self.contents.vertices[nodes[k]]);
        let beside = |middle: [f64; 3], ends: [[f64; 3]; 2]| {
            let off = |i: usize| (middle[i] - 0.5 * (ends[0][i] + ends[1][i])).powi(2);
            (0..3).map(off).sum::<f64>()
        };
        if beside(b, [a, c]) < beside(c, [a, b]) {
            nodes.swap(1, 2);
        }
    }

    /// The nodes of an element.
    fn nodes_of(&self, element: usize) -> &[usize] {
        let (kind, first) = self.elements[element];
        &self.flat[first..first + kind.nodes()]
    }

    /// Vertices, bodies and boundaries.
    fn contents(mut self) -> Result<Contents, Fault> {
        let mut contents = std::mem::take(&mut self.contents);
        let highest = self
            .elements
            .iter()
            .map(|(kind, ..)| kind.dimension())
            .max();
        let highest = highest.unwrap_or(0);
        let sets = self.sets_of_elements(highest);
        let mut labels = BTreeMap::new();
        for (k, own) in sets.iter().enumerate() {
            let kind = self.elements[k].0;
            // those of boundaries are positive
            let next = -1 - labels.len() as i64;
            let label = *labels.entry(own).or_insert(next);
            let groups = |contents: &mut Contents| {
                let mut groups = Vec::new();
                for &set in own {
                    let group = contents.group(kind.dimension(), set as i64 + 1);
                    contents.groups[group].name = self.element_sets.all[set].name.clone();
                    groups.push(group);
                }
                groups
            };
            contents
                .nodes_of(kind, label, groups)
                .extend(self.nodes_of(k));
        }
        self.add_boundaries(&mut contents, highest)?;
        contents.check("`*NODE`", "`*ELEMENT`")?;
        Ok(contents)
    }

    /// The sets that are the groups of each element.
    fn sets_of_elements(&self, highest: usize) -> Vec<Vec<usize>> {
        let mut all = vec![Vec::new(); self.elements.len()];
        for set in 0..self.element_sets.all.len() {
            for element in members(&self.element_sets, set, &self.numbers) {
                all[element].push(set);
            }
        }
        let is_cell = |k: usize| self.elements[k].0.dimension() == highest;
        let listed = |set: &usize| !self.headed.contains(set);
        let in_one = |own: &Vec<usize>| own.iter().filter(|set| listed(set)).count() == 1;
        let mut cells = (0..all.len()).filter(|&k| is_cell(k));
        let has_one_each = cells.all(|k| in_one(&all[k]));
        for (k, own) in all.iter_mut().enumerate() {
            if is_cell(k) {
                own.retain(|set| match (self.sections.is_empty(), has_one_each) {
                    (false, _) => self.sections.contains(set),
                    (true, true) => listed(set),
                    (true, false) => self.headed.contains(set),
                });
            } else if own.iter().any(listed) {
                own.retain(listed);
            }
        }
        all
    }

    /// The facets of surfaces and of sets of nodes.
    fn add_boundaries(&self, contents: &mut Contents, highest: usize) -> Result<(), Problem> {
        if highest < 2 {
            return Ok(());
        }
        let kind = if highest == 2 {
            ElementKind::Segment
        } else {
            ElementKind::Triangle
        };
        let first = self.element_sets.all.len() as i64 + 1;
        let mut label = first;
        let mut add = |contents: &mut Contents, name: &str, facets: Vec<Vec<usize>>| {
            for facet in &facets {
                let nodes = contents.nodes_of(kind, label, |contents| {
                    contents.name(highest - 1, label, name);
                    vec![contents.group(highest - 1, label)]
                });
                nodes.extend(facet);
            }
            label += 1;
        };
        let outside = self.outside(highest);
        let alone: HashSet<Corners> = outside.iter().map(|facet| sorted(facet)).collect();
        for surface in &self.surfaces.all {
            let mut facets = Vec::new();
            for (of, which) in &surface.members {
                for element in self.elements_of(of) {
                    let (own, ..) = self.elements[element];
                    let all = faces(own).iter().enumerate();
                    let before = facets.len();
                    for (number, face) in all.filter(|_| own.dimension() == highest) {
                        let nodes = self.nodes_of(element);
                        let facet: Vec<usize> = face.iter().map(|&corner| nodes[corner]).collect();
                        if *which == number + 1 || *which == 0 && alone.contains(&sorted(&facet)) {
                            facets.push(facet);
                        }
                    }
                    if *which > 0 && facets.len() == before {
                        return Err(Problem::Expected {
                            expected: format!(
                                "a face of a {own} in the surface `{}`",
                                surface.name
                            ),
                            found: format!("S{which}"),
                        });
                    }
                }
            }
            add(contents, &surface.name, facets);
        }
        for (k, set) in self.node_sets.all.iter().enumerate() {
            let own: BTreeSet<usize> = members(&self.node_sets, k, &self.nodes)
                .into_iter()
                .collect();
            let facets = outside
                .iter()
                .filter(|facet| facet.iter().all(|node| own.contains(node)));
            add(contents, &set.name, facets.cloned().collect());
        }
        Ok(())
    }

    /// The elements that a line of a surface names.
    fn elements_of(&self, of: &Member) -> Vec<usize> {
        match of {
            Member::Set(name) => match self.element_sets.find(name) {
                Some(set) => members(&self.element_sets, set, &self.numbers),
                None => Vec::new(),
            },
            Member::One(number) => self.numbers.get(number).copied().into_iter().collect(),
            Member::Range(_) => Vec::new(),
        }
    }

    /// The faces of one cell alone, in the order of the cells.
    fn outside(&self, highest: usize) -> Vec<Vec<usize>> {
        let mut found = Vec::new();
        let mut count: HashMap<Corners, usize> = HashMap::new();
        for (k, (kind, ..)) in self.elements.iter().enumerate() {
            if kind.dimension() == highest {
                for face in faces(*kind) {
                    let nodes = self.nodes_of(k);
                    let facet: Vec<usize> = face.iter().map(|&corner| nodes[corner]).collect();
                    *count.entry(sorted(&facet)).or_default() += 1;
                    found.push(facet);
                }
            }
        }
        found.retain(|facet| count[&sorted(facet)] == 1);
        found
    }
}

/// The indices of the members of a set, of those that there are; sets may name others.
fn members(sets: &Names<Member>, set: usize, known: &BTreeMap<i64, usize>) -> Vec<usize> {
    let (mut found, mut open, mut seen) = (BTreeSet::new(), vec![set], BTreeSet::from([set]));
    while let Some(set) = open.pop() {
        for member in &sets.all[set].members {
            match member {
                Member::One(number) => found.extend(known.get(number)),
                Member::Range([first, last, step]) if first <= last => {
                    let within = known.range(first..=last);
                    let fits = |number: i64| (number as i128 - *first as i128) % *step as i128 == 0;
                    found.extend(within.filter(|(number, _)| fits(**number)).map(|own| own.1));
                }
                Member::Range(_) => {}
                Member::Set(name) => {
                    open.extend(sets.find(name).filter(|other| seen.insert(*other)))
                }
            }
        }
    }
    found.into_iter().collect()
}

/// A number or the name of a set.
fn member(word: &str) -> Member {
    match word.parse() {
        Ok(number) => Member::One(number),
        Err(_) => Member::Set(word.trim_matches('"').to_string()),
    }
}

/// The kind of the elements of a type: the letters before and behind tell what is computed, not what the mesh is.
fn kind(name: &str) -> Option<ElementKind> {
    let name = name.to_ascii_uppercase();
    let begins = |all: &[&str]| {
        all.iter().any(|own| {
            let rest = name.strip_prefix(own);
            rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
        })
    };
    Some(match () {
        () if begins(&["C3D4", "DC3D4"]) => ElementKind::Tetrahedron,
        () if begins(&["C3D10", "DC3D10"]) => ElementKind::Tetrahedron10,
        () if begins(&[
            "CPS3", "CPE3", "CPEG3", "CAX3", "CGAX3", "S3", "STRI3", "M3D3", "R3D3", "SFM3D3",
        ]) =>
        {
            ElementKind::Triangle
        }
        () if begins(&[
            "CPS6", "CPE6", "CPEG6", "CAX6", "CGAX6", "S6", "STRI65", "M3D6", "SFM3D6",
        ]) =>
        {
            ElementKind::Triangle6
        }
        () if begins(&["T2D2", "T3D2", "B21", "B31", "R2D2", "RAX2", "SAX1"]) => {
            ElementKind::Segment
        }
        () if begins(&["T2D3", "T3D3", "B22", "B32", "SAX2"]) => ElementKind::Segment3,
        () => return None,
    })
}

/// The corners of the faces `S1`, `S2`, … of an element.
fn faces(kind: ElementKind) -> &'static [&'static [usize]] {
    match kind {
        ElementKind::Triangle | ElementKind::Triangle6 => &[&[0, 1], &[1, 2], &[2, 0]],
        ElementKind::Tetrahedron | ElementKind::Tetrahedron10 => {
            &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]]
        }
        _ => &[],
    }
}

fn expected(what: &str, found: &[u8]) -> Problem {
    Problem::Expected {
        expected: what.to_string(),
        found: excerpt(found),
    }
}
