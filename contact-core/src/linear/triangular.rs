//! Solves with L and with Lᵀ alone, on a part of the elimination tree.
//!
//! A right-hand side with few entries fills only the paths from them to the root of the elimination tree, and a few entries
//! of a solution with Lᵀ depend on no others than these.

use super::{Cholesky, Panel};

/// A set of panels that has the parent of each of its panels, ascending.
pub(crate) struct Reach(Vec<usize>);

impl Reach {
    /// All panels.
    pub fn whole(factor: &Cholesky) -> Self {
        Reach((0..factor.panel_count()).collect())
    }

    /// The panels on the paths from these steps to the root.
    pub fn of(factor: &Cholesky, steps: impl Iterator<Item = usize>) -> Self {
        let panels: Vec<Panel<'_>> = factor.panels().collect();
        let mut reached = vec![false; panels.len()];
        let panel_of = |step: usize| panels.partition_point(|panel| panel.start <= step) - 1;
        for step in steps {
            let mut next = Some(step);
            while let Some(s) = next.map(panel_of).filter(|&s| !reached[s]) {
                reached[s] = true;
                next = panels[s].below.first().copied();
            }
        }
        Reach((0..panels.len()).filter(|&s| reached[s]).collect())
    }
}

/// Solves with a factor LLᵀ. Vectors are in the order of elimination (n).
impl Cholesky {
    /// L⁻¹b in place, for a b that is zero outside `reach`.
    pub(crate) fn forward(&self, reach: &Reach, b: &mut [f64]) {
        let mut below = Vec::new();
        for &s in &reach.0 {
            let panel = self.panel(s);
            let (rest, height) = (panel.below.len(), panel.size + panel.below.len());
            below.clear();
            below.resize(rest, 0.0);
            for j in 0..panel.size {
                let column = &panel.values[j * height + j..(j + 1) * height];
                let (block, lower) = column.split_at(panel.size - j);
                let own = &mut b[panel.start + j..panel.start + panel.size];
                let x = own[0] / block[0];
                own[0] = x;
                own.iter_mut()
                    .zip(block)
                    .skip(1)
                    .for_each(|(b, l)| *b -= l * x);
                below.iter_mut().zip(lower).for_each(|(b, l)| *b += l * x);
            }
            panel.below.iter().zip(&below).for_each(|(&i, x)| b[i] -= x);
        }
    }

    /// L⁻ᵀb in place, at the steps of `reach`; other entries stay as they are.
    pub(crate) fn backward(&self, reach: &Reach, b: &mut [f64]) {
        let mut below = Vec::new();
        for &s in reach.0.iter().rev() {
            let panel = self.panel(s);
            let height = panel.size + panel.below.len();
            below.clear();
            below.extend(panel.below.iter().map(|&i| b[i]));
            for j in (0..panel.size).rev() {
                let column = &panel.values[j * height + j..(j + 1) * height];
                let (block, lower) = column.split_at(panel.size - j);
                let own = &mut b[panel.start + j..panel.start + panel.size];
                let sum = dot(&block[1..], &own[1..]) + dot(lower, &below);
                own[0] = (own[0] - sum) / block[0];
            }
        }
    }
}

/// Σ a_i b_i, in four sums that the processor can form side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a.zip(b) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + rest
}
