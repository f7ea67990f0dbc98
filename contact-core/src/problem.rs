//! The seam between mechanics and optimisation: what a contact problem must offer.

use crate::gaps::Sampling;
use crate::nlp::Bounds;
use crate::{Energy, Error, LinearGaps, RowKey};

/// The problem's own length and energy, by which everything is divided before Ipopt sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// A length (UL) such that displacements over it are O(1) at most.
    pub length: f64,
    /// The smallest displacement (UL) that matters at contact: what is left of gap times force at
    /// an active row is measured against it. It must shrink with the mesh, or contact pressures
    /// would lose accuracy with every refinement.
    pub resolution: f64,
    /// What round-off leaves of a gradient in these units: no tolerance below it can be met.
    pub roundoff: f64,
    /// The reference measure (UL in the plane, UL² in space) of a contact facet.
    pub area: f64,
    /// An energy (UF·UL) such that `length²/energy` times the Hessian's diagonal is O(1).
    pub energy: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Scale {
            length: 1.0,
            resolution: 1.0,
            roundoff: f64::EPSILON,
            area: 1.0,
            energy: 1.0,
        }
    }
}

/// Multipliers by row name, so that they survive a change of rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers(Vec<(RowKey, f64)>);

impl Multipliers {
    /// λ_i of each row of `gaps`.
    pub fn new(gaps: &LinearGaps, lambda: &[f64]) -> Self {
        let named = gaps.keys().iter().copied().zip(lambda.iter().copied());
        let mut entries: Vec<_> = named.collect();
        entries.sort_unstable_by_key(|entry| entry.0);
        Multipliers(entries)
    }

    /// The multiplier of a row; zero if the row is new.
    pub fn of(&self, key: RowKey) -> f64 {
        let found = self.0.binary_search_by_key(&key, |entry| entry.0);
        found.map_or(0.0, |k| self.0[k].1)
    }

    /// Whether there is none at all.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The extrapolation λ + s (λ − λ_before), kept ≥ 0.
    pub fn extrapolated(&self, before: &Multipliers, s: f64) -> Multipliers {
        let line = |&(key, l): &(RowKey, f64)| (key, (l + s * (l - before.of(key))).max(0.0));
        Multipliers(self.0.iter().map(line).collect())
    }
}

/// Where a solve starts from, and what a converged one leaves.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// λ ≥ 0 of the contact rows (UF).
    pub multipliers: Multipliers,
}

/// An energy and its linearisable gap constraints. Everything about space, meshes and materials
/// stays behind this trait; a toy of two unknowns can stand in front of it just as well.
pub trait ContactProblem {
    /// E(u).
    fn energy(&self) -> &dyn Energy;
    /// Bounds on the free unknowns (n, UL), infinite where there is none.
    fn bounds(&self) -> &Bounds;
    /// Steps 1 and 2 of Algorithm 2: the rows of the roles as they were declared, with projections
    /// and normals frozen at `u`.
    ///
    /// [`Sampling::Nodes`] asks for one row a contact node; [`Sampling::Points`] for one row an
    /// integration point, whose weight is its share of the integral over the surface, which is what
    /// method (39) penalises. A problem without surfaces gives its rows in either case.
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error>;
    /// Step 3: the rows of the reversed roles. By default there are none.
    fn linearize_reversed(&self, _u: &[f64], _sampling: Sampling) -> Result<LinearGaps, Error> {
        Ok(LinearGaps::new(true))
    }
    /// Units in which numbers are O(1).
    fn scale(&self) -> Scale {
        Scale::default()
    }
    /// max |prescribed unknown| (UL): the fixed point's relative error counts ALL unknowns.
    fn prescribed_magnitude(&self) -> f64 {
        0.0
    }
}
