//! Collects the contents of a mesh file.

use std::collections::HashMap;

use super::problem::Problem;
use super::{ElementKind, Elements, Group};

/// Vertices, groups and elements while a file is being read.
#[derive(Default)]
pub(super) struct Contents {
    pub vertices: Vec<[f64; 3]>,
    pub groups: Vec<Group>,
    pub elements: Vec<Elements>,
    /// Groups by dimension and number.
    group_index: HashMap<(usize, i64), usize>,
    /// Elements by kind and by the entity or label that determines their groups.
    element_index: HashMap<(ElementKind, i64), usize>,
}

impl Contents {
    /// Adds a vertex that the file calls `number`.
    pub fn add_vertex(&mut self, number: u64, point: [f64; 3]) -> Result<(), Problem> {
        if let Some(&value) = point.iter().find(|v| !v.is_finite()) {
            return Err(Problem::NotFinite { number, value });
        }
        self.vertices.push(point);
        Ok(())
    }

    /// The group with that dimension and number. Its name is its number unless [`Contents::name`]
    /// sets another.
    pub fn group(&mut self, dimension: usize, number: i64) -> usize {
        let groups = &mut self.groups;
        let index = self.group_index.entry((dimension, number));
        *index.or_insert_with(|| {
            groups.push(Group {
                dimension,
                number,
                name: number.to_string(),
            });
            groups.len() - 1
        })
    }

    /// Sets the name of a group.
    pub fn name(&mut self, dimension: usize, number: i64, name: &str) {
        let group = self.group(dimension, number);
        self.groups[group].name = name.to_string();
    }

    /// The nodes of all elements of that kind with that `label`; its groups are given with the
    /// first of them.
    pub fn nodes_of(
        &mut self,
        kind: ElementKind,
        label: i64,
        groups: impl FnOnce(&mut Self) -> Vec<usize>,
    ) -> &mut Vec<usize> {
        let index = match self.element_index.get(&(kind, label)) {
            Some(&index) => index,
            None => {
                let groups = groups(self);
                let nodes = Vec::new();
                self.elements.push(Elements {
                    kind,
                    groups,
                    nodes,
                });
                self.element_index
                    .insert((kind, label), self.elements.len() - 1);
                self.elements.len() - 1
            }
        };
        &mut self.elements[index].nodes
    }

    /// Checks that there are vertices and elements; the arguments are the names of their sections.
    pub fn check(&self, vertices: &'static str, elements: &'static str) -> Result<(), Problem> {
        if self.vertices.is_empty() {
            return Err(Problem::Missing { section: vertices });
        }
        if self.elements.is_empty() {
            return Err(Problem::Missing { section: elements });
        }
        Ok(())
    }
}

/// The index of the vertex with `number` in a file that counts from 1.
pub(super) fn counted_from_one(number: i64, vertices: usize) -> Result<usize, Problem> {
    let vertex = number.checked_sub(1).and_then(|v| usize::try_from(v).ok());
    vertex
        .filter(|&v| v < vertices)
        .ok_or_else(|| Problem::UnknownNode {
            number: number.to_string(),
            nodes: vertices,
        })
}
