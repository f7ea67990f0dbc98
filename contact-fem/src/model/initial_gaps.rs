//! Bodies that overlap in the reference configuration, as in an interference fit.

use std::collections::HashMap;

use crate::contact::Pass;

/// What becomes of contact surfaces that overlap in the reference configuration.
///
/// An overlap of declared surfaces can be resolved or adjusted up to 0.15 of the facet size, and beyond that up to 0.4 of the
/// thickness that the thinner of the two bodies has there. Where it is deeper, it cannot be told on which side of a body a point belongs, and the scene is refused.
///
/// Overlaps belong to the nodes of the meshes: a node that slides along the other surface takes its own with it. Where
/// surfaces slide by more than a facet, move the bodies apart instead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InitialGaps {
    /// Overlaps larger than [`Scene::overlap_tolerance`](super::Scene::overlap_tolerance) are an error. Smaller ones are
    /// pushed out by the first load step.
    #[default]
    Refuse,
    /// The load pushes overlaps out, as in a press fit: at load factor t, weak gaps are at least −(1 − t) times the initial
    /// overlap, and at full load at least 0.
    Resolve,
    /// Overlaps stay and cause no force: weak gaps are measured from the initial overlap. Gaps between bodies stay, too. This
    /// is for meshes that overlap though the bodies only touch. The method (39) takes the overlap of a point from the nodes
    /// around it.
    Adjust,
}

impl InitialGaps {
    /// The largest overlap that is resolved or adjusted whatever the thickness of the bodies, as a share of the facet size.
    pub(super) const LARGEST: f64 = 0.15;

    /// The overlap that is resolved or adjusted, as a share of the thickness of the thinner body: in the middle of a body, both of its
    /// sides are equally far.
    pub(super) const OF_THICKNESS: f64 = 0.4;

    /// The overlap below which surfaces only touch, as a share of the facet size: above the round-off of coordinates.
    pub(super) const TOUCHES: f64 = 1e-9;

    /// The share of the initial overlaps that is left at load factor `factor`.
    pub(super) fn share_left(self, factor: f64) -> f64 {
        match self {
            InitialGaps::Refuse => 0.0,
            InitialGaps::Resolve => (1.0 - factor).clamp(0.0, 1.0),
            InitialGaps::Adjust => 1.0,
        }
    }
}

/// The initial overlaps of one pass, one for each node of the slave, in the order of its nodes (UL, ≥ 0).
#[derive(Clone, Debug)]
pub(super) struct Depths {
    /// Of the nodes' rows: minus their weak gaps, at most the depth of the deepest of their points.
    pub rows: Vec<f64>,
    /// Of the nodes themselves.
    pub nodes: Vec<f64>,
}

/// The initial overlaps of passes by slave and master. It is empty if they are refused.
#[derive(Clone, Debug, Default)]
pub(super) struct InitialOverlaps(pub HashMap<(usize, usize), Depths>);

impl InitialOverlaps {
    pub fn of(&self, pass: Pass) -> Option<&Depths> {
        self.0.get(&(pass.slave, pass.master))
    }

    /// The deepest overlap of all rows (UL).
    pub fn largest(&self) -> f64 {
        let rows = self.0.values().flat_map(|depths| &depths.rows);
        rows.copied().fold(0.0, f64::max)
    }
}
