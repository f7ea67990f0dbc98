//! The bodies and boundaries of a deck.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::super::ElementKind;
use super::super::contents::Contents;
use super::super::parts::{Corners, sorted};
use super::super::problem::Problem;
use super::deck::{Cell, Deck};
use super::kinds::faces;
use super::sets::{Member, members};

/// The corners of facets.
type Facets = Vec<Vec<usize>>;

impl Deck {
    /// Vertices, bodies and boundaries.
    pub fn contents(mut self) -> Result<Contents, Problem> {
        let mut contents = std::mem::take(&mut self.contents);
        let nodes = self.indices(&contents)?;
        let dimensions = self.elements.iter().map(|cell| cell.kind.dimension());
        let highest = dimensions.max().unwrap_or(0);
        let sets = self.sets_of_elements(highest)?;
        let mut labels = BTreeMap::new();
        for (cell, own) in self.elements.iter().zip(&sets) {
            let dimension = cell.kind.dimension();
            // labels of boundaries are positive
            let next = -1 - labels.len() as i64;
            let label = *labels.entry(own).or_insert(next);
            let groups = |contents: &mut Contents| {
                let group = |&set: &usize| {
                    let number = set as i64 + 1;
                    contents.name(dimension, number, &self.element_sets.all[set].name);
                    contents.group(dimension, number)
                };
                own.iter().map(group).collect()
            };
            let all = contents.nodes_of(cell.kind, label, groups);
            all.extend(nodes_of(cell, &nodes));
        }
        if highest > 1 {
            self.add_boundaries(&mut contents, (&nodes, &sets), highest)?;
        }
        contents.check("`*NODE`", "`*ELEMENT`")?;
        Ok(contents)
    }

    /// The indices of all elements' nodes.
    fn indices(&self, contents: &Contents) -> Result<Vec<usize>, Problem> {
        let index = |number: &i64| {
            let index = self.nodes.get(number).copied();
            index.ok_or_else(|| Problem::UnknownNode {
                number: number.to_string(),
                nodes: self.nodes.len(),
            })
        };
        let mut nodes = self.flat.iter().map(index).collect::<Result<Vec<_>, _>>()?;
        let lines = self.elements.iter();
        for cell in lines.filter(|cell| cell.kind == ElementKind::Segment3) {
            put_middle_last(&mut nodes[cell.first..cell.first + 3], &contents.vertices);
        }
        Ok(nodes)
    }

    /// The sets that are the groups of each element.
    fn sets_of_elements(&self, highest: usize) -> Result<Vec<Vec<usize>>, Problem> {
        let mut all = vec![Vec::new(); self.elements.len()];
        for set in 0..self.element_sets.all.len() {
            for element in members(&self.element_sets, set, &self.numbers)? {
                all[element].push(set);
            }
        }
        let is_cell = |k: usize| self.elements[k].kind.dimension() == highest;
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
        Ok(all)
    }

    /// Adds the facets of surfaces and of sets of nodes.
    fn add_boundaries(
        &self,
        contents: &mut Contents,
        (nodes, sets): (&[usize], &[Vec<usize>]),
        highest: usize,
    ) -> Result<(), Problem> {
        let kind = match highest {
            2 => ElementKind::Segment,
            _ => ElementKind::Triangle,
        };
        let sides = self.sides(nodes, sets, highest);
        let mut label = self.element_sets.all.len() as i64;
        let mut add = |name: &str, facets: &Facets| {
            label += 1;
            for facet in facets {
                let all = contents.nodes_of(kind, label, |contents| {
                    contents.name(highest - 1, label, name);
                    vec![contents.group(highest - 1, label)]
                });
                all.extend(facet);
            }
        };
        let mut surfaces = BTreeMap::new();
        for surface in &self.surfaces.all {
            let facets = self.facets_of(&surface.name, &surface.members, (nodes, &sides))?;
            add(&surface.name, &facets);
            surfaces.insert(surface.name.to_ascii_uppercase(), facets);
        }
        for (k, set) in self.node_sets.all.iter().enumerate() {
            let own = members(&self.node_sets, k, &self.nodes)?;
            let facets = covered(&own, &sides);
            match surfaces.get(&set.name.to_ascii_uppercase()) {
                None => add(&set.name, &facets),
                Some(others) if corners_of(others) == corners_of(&facets) => {}
                Some(_) => {
                    return Err(Problem::Unsupported {
                        found: format!(
                            "a deck with a surface and a set of nodes `{}` that are not the same",
                            set.name
                        ),
                        remedy: "give them names of their own",
                    });
                }
            }
        }
        Ok(())
    }

    /// The facets of a surface.
    fn facets_of(
        &self,
        surface: &str,
        all: &[(Member, usize)],
        (nodes, sides): (&[usize], &Sides),
    ) -> Result<Facets, Problem> {
        let mut facets = Facets::new();
        for (of, which) in all {
            for element in self.elements_of(surface, of)? {
                let cell = &self.elements[element];
                let before = facets.len();
                for (number, face) in faces_of(cell).iter().enumerate() {
                    let own = nodes_of(cell, nodes);
                    let facet: Vec<usize> = face.iter().map(|&corner| own[corner]).collect();
                    let is_meant = match which {
                        0 => sides.free.contains(&sorted(&facet)),
                        _ => *which == number + 1,
                    };
                    facets.extend(is_meant.then_some(facet));
                }
                if *which > 0 && facets.len() == before {
                    return Err(Problem::Expected {
                        expected: format!("a face of a {} in the surface `{surface}`", cell.kind),
                        found: format!("S{which}"),
                    });
                }
            }
        }
        Ok(facets)
    }

    /// The elements that a line of a surface names.
    fn elements_of(&self, surface: &str, of: &Member) -> Result<Vec<usize>, Problem> {
        let found = match of {
            Member::Set(name) => match self.element_sets.find(name) {
                Some(set) => return members(&self.element_sets, set, &self.numbers),
                None => Err(name.clone()),
            },
            Member::One(number) => match self.numbers.get(number) {
                Some(&element) => Ok(vec![element]),
                None => Err(number.to_string()),
            },
            Member::Range(_) => Ok(Vec::new()),
        };
        found.map_err(|found| Problem::Expected {
            expected: format!("an element or a set of elements in the surface `{surface}`"),
            found,
        })
    }

    /// The faces at which bodies end.
    fn sides(&self, nodes: &[usize], sets: &[Vec<usize>], highest: usize) -> Sides {
        let mut sides = Sides::default();
        // the element of a face that has been met once
        let mut met: HashMap<Corners, usize> = HashMap::new();
        for (k, cell) in self.elements.iter().enumerate() {
            if cell.kind.dimension() != highest {
                continue;
            }
            let own = nodes_of(cell, nodes);
            sides.corners.extend(&own[..cell.kind.corners()]);
            for face in faces_of(cell) {
                let facet: Vec<usize> = face.iter().map(|&corner| own[corner]).collect();
                let key = sorted(&facet);
                match met.insert(key, k) {
                    None => {
                        sides.free.insert(key);
                        sides.all.insert(key, facet);
                    }
                    Some(other) => {
                        sides.free.remove(&key);
                        // between bodies it is a side of both
                        if sets[other] == sets[k] {
                            sides.all.remove(&key);
                        }
                    }
                }
            }
        }
        sides
    }
}

/// The faces at which bodies end, the free ones among these faces, which no second cell has, and the corners of all cells.
#[derive(Default)]
struct Sides {
    all: BTreeMap<Corners, Vec<usize>>,
    free: BTreeSet<Corners>,
    corners: BTreeSet<usize>,
}

/// The facets that have all corners in a set of nodes, if they have all of the corners that the set has.
fn covered(set: &[usize], sides: &Sides) -> Facets {
    let set: BTreeSet<usize> = set.iter().copied().collect();
    let facets = sides.all.values();
    let within = facets.filter(|facet| facet.iter().all(|node| set.contains(node)));
    let facets: Facets = within.cloned().collect();
    let found: BTreeSet<usize> = facets.iter().flatten().copied().collect();
    match set
        .intersection(&sides.corners)
        .all(|node| found.contains(node))
    {
        true => facets,
        false => Facets::new(),
    }
}

fn corners_of(facets: &Facets) -> BTreeSet<Corners> {
    facets.iter().map(|facet| sorted(facet)).collect()
}

fn faces_of(cell: &Cell) -> &'static [&'static [usize]] {
    match cell.is_shell {
        true => &[],
        false => faces(cell.kind),
    }
}

fn nodes_of<'a>(cell: &Cell, nodes: &'a [usize]) -> &'a [usize] {
    &nodes[cell.first..cell.first + cell.kind.nodes()]
}

/// Programs do not agree on the place of the middle node of three on a line.
fn put_middle_last(nodes: &mut [usize], vertices: &[[f64; 3]]) {
    let [a, b, c] = [0, 1, 2].map(|k| vertices[nodes[k]]);
    let beside = |middle: [f64; 3], ends: [[f64; 3]; 2]| {
        let off = |i: usize| (middle[i] - 0.5 * (ends[0][i] + ends[1][i])).powi(2);
        (0..3).map(off).sum::<f64>()
    };
    if beside(b, [a, c]) < beside(c, [a, b]) {
        nodes.swap(1, 2);
    }
}
