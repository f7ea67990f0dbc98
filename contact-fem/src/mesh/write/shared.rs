//! What bodies in one file share: vertices and facets.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::error::Error;
use crate::tensor::Vector;

/// What a facet of a file is called.
pub(super) enum Label<'a> {
    /// On a boundary: its name and label.
    Named(&'a str, i32),
    /// On the boundary of one body, without a name.
    Unnamed,
    /// Between two bodies, without a name.
    Between,
}

/// The vertices and facets of the bodies so far.
#[derive(Default)]
pub(super) struct Shared<'a, const D: usize> {
    /// The numbers of vertices by the bits of their coordinates.
    vertices: HashMap<[u64; D], usize>,
    /// The facets' vertices, in the order of the bodies.
    pub facets: Vec<([usize; D], Label<'a>)>,
    /// The positions of facets by their vertices, ascending.
    by_vertices: HashMap<[usize; D], usize>,
}

impl<'a, const D: usize> Shared<'a, D> {
    /// The numbers of a body's vertices; `add` adds those that no body before has.
    pub fn number<'x>(
        &mut self,
        points: impl Iterator<Item = &'x Vector<D>>,
        mut add: impl FnMut(&Vector<D>) -> usize,
    ) -> Vec<usize> {
        // -0 is 0
        let bits = |X: &Vector<D>| std::array::from_fn(|i| (X[i] + 0.0).to_bits());
        let mut new = Vec::new();
        let mut numbers = Vec::new();
        for X in points {
            let known = self.vertices.get(&bits(X)).copied();
            let number = known.unwrap_or_else(|| {
                let number = add(X);
                new.push((bits(X), number));
                number
            });
            numbers.push(number);
        }
        self.vertices.extend(new);
        numbers
    }

    /// Adds a facet of a body, or names the one that another body has there.
    pub fn label(&mut self, facet: [usize; D], label: Option<(&'a str, i32)>) -> Result<(), Error> {
        let new = |other| label.map_or(other, |(name, label)| Label::Named(name, label));
        let mut vertices = facet;
        vertices.sort_unstable();
        let entry = match self.by_vertices.entry(vertices) {
            Entry::Vacant(vacant) => {
                vacant.insert(self.facets.len());
                self.facets.push((facet, new(Label::Unnamed)));
                return Ok(());
            }
            Entry::Occupied(old) => &mut self.facets[*old.get()].1,
        };
        match (&*entry, label) {
            (Label::Named(_, old), Some((_, new))) if *old == new => {}
            (Label::Named(first, _), Some((second, _))) => {
                return Err(Error::SharedFacet {
                    nodes: facet.map(|number| number - 1).to_vec(),
                    first: first.to_string(),
                    second: second.to_string(),
                });
            }
            (Label::Named(..), None) => {}
            (Label::Unnamed | Label::Between, _) => *entry = new(Label::Between),
        }
        Ok(())
    }
}
