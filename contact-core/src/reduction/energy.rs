//! E(T v + t) of parts that dependent unknowns join.

use std::ops::Range;

use super::{Group, LinearMap};
use crate::Energy;
use crate::linear::SymmetricPattern;

/// How the Hessians of a group's parts add up to TᵀHT.
#[derive(Debug)]
pub(super) struct Part {
    pattern: SymmetricPattern,
    /// The number of entries of all parts' Hessians.
    entries: usize,
    /// (entry of the parts, slot) where T has the entry 1 alone on both sides.
    direct: Vec<(usize, usize)>,
    /// (entry of the parts, slot, coefficient) of the others.
    mixed: Vec<(usize, usize, f64)>,
}

impl Part {
    pub fn new(map: &LinearMap, group: &Group, parts: &[&dyn Energy]) -> Self {
        let (mut sources, mut places) = (Vec::new(), Vec::new());
        let mut entry = 0;
        let (mut of_row, mut of_column) = (Vec::new(), Vec::new());
        for &p in &group.parts {
            for (i, j) in parts[p].hessian_pattern().iter() {
                let [i, j] = [i, j].map(|k| map.starts[p] + k);
                of_row.clear();
                of_column.clear();
                map.of_unknown(i, |v, c| of_row.push((v - group.first, c)));
                map.of_unknown(j, |v, c| of_column.push((v - group.first, c)));
                for (a, c) in &of_row {
                    for (b, d) in &of_column {
                        // H_ij and H_ji are two entries, and both triangles of TᵀHT one
                        let factor = match (i == j, a == b) {
                            (false, true) => 2.0,
                            (true, false) if a < b => continue,
                            _ => 1.0,
                        };
                        sources.push((entry, factor * c * d));
                        places.push((*a, *b));
                    }
                }
                entry += 1;
            }
        }
        let (pattern, slots) =
            SymmetricPattern::from_entries(group.len, &places).expect("entries of this group");
        let (mut direct, mut mixed) = (Vec::new(), Vec::new());
        for ((source, c), slot) in sources.into_iter().zip(slots) {
            match c == 1.0 {
                true => direct.push((source, slot)),
                false => mixed.push((source, slot, c)),
            }
        }
        Part {
            pattern,
            entries: entry,
            direct,
            mixed,
        }
    }
}

/// E(T v + t), summed over the parts of a group.
pub(super) struct GroupEnergy<'a> {
    map: &'a LinearMap,
    group: &'a Group,
    part: &'a Part,
    /// The energies of the group's parts.
    parts: Vec<&'a dyn Energy>,
    constants: &'a [f64],
}

impl<'a> GroupEnergy<'a> {
    /// `all` has the energies of all parts of the problem.
    pub fn new(
        map: &'a LinearMap,
        (group, part): (&'a Group, &'a Part),
        all: &[&'a dyn Energy],
        constants: &'a [f64],
    ) -> Self {
        let parts = group.parts.iter().map(|&p| all[p]).collect();
        GroupEnergy {
            map,
            group,
            part,
            parts,
            constants,
        }
    }

    /// The unknowns of each part.
    fn parts(&self) -> impl Iterator<Item = (&'a dyn Energy, Range<usize>)> + '_ {
        let ranges = self
            .group
            .parts
            .iter()
            .map(|&p| self.map.starts[p]..self.map.starts[p + 1]);
        self.parts.iter().copied().zip(ranges)
    }

    /// u of the unknowns `range`.
    fn unknowns(&self, v: &[f64], range: Range<usize>) -> Vec<f64> {
        let first = self.group.first;
        let value = |i: usize| match self.map.places[i] {
            super::Place::Independent(j) => v[j - first],
            super::Place::Dependent(k) => {
                let terms = self.map.terms.row(k);
                terms.map(|(j, c)| c * v[j - first]).sum::<f64>() + self.constants[k]
            }
        };
        range.map(value).collect()
    }
}

impl Energy for GroupEnergy<'_> {
    fn dofs(&self) -> usize {
        self.group.len
    }

    fn value(&self, v: &[f64]) -> f64 {
        let values = self
            .parts()
            .map(|(part, range)| part.value(&self.unknowns(v, range)));
        values.sum()
    }

    fn gradient(&self, v: &[f64], g: &mut [f64]) {
        g.fill(0.0);
        let first = self.group.first;
        for (part, range) in self.parts() {
            let mut own = vec![0.0; range.len()];
            part.gradient(&self.unknowns(v, range.clone()), &mut own);
            for (i, force) in range.zip(own) {
                self.map.of_unknown(i, |j, c| g[j - first] += c * force);
            }
        }
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.part.pattern
    }

    fn hessian(&self, v: &[f64], values: &mut [f64]) {
        let mut own = vec![0.0; self.part.entries];
        let mut first = 0;
        for (part, range) in self.parts() {
            let next = first + part.hessian_pattern().len();
            part.hessian(&self.unknowns(v, range), &mut own[first..next]);
            first = next;
        }
        values.fill(0.0);
        self.part
            .direct
            .iter()
            .for_each(|&(entry, slot)| values[slot] += own[entry]);
        self.part
            .mixed
            .iter()
            .for_each(|&(entry, slot, c)| values[slot] += c * own[entry]);
    }

    fn is_quadratic(&self) -> bool {
        self.parts.iter().all(|part| part.is_quadratic())
    }

    fn domain_len(&self) -> usize {
        self.parts.iter().map(|part| part.domain_len()).sum()
    }

    fn domain(&self, v: &[f64], d: &mut [f64]) {
        let mut first = 0;
        for (part, range) in self.parts() {
            let next = first + part.domain_len();
            if next > first {
                part.domain(&self.unknowns(v, range), &mut d[first..next]);
            }
            first = next;
        }
    }
}
