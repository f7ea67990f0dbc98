//! Sideways motions that contact at the reference positions does not follow.

use contact_core::equilibrium::Solution;

use super::{PairSide, PairState};
use crate::contact::Pass;
use crate::model::{Geometry, Problem, Side};
use crate::tensor::Vector;

/// How far normals of flat surfaces differ by round-off.
const FLAT: f64 = 1e-6;
/// The way that is told, as a share of the width of the contact zone. On a cylinder it costs 1 or 2 % of the force.
const WAY: f64 = 0.05;

/// Two curved surfaces of which one has moved sideways on the other, as [`Problem::sideways`] finds them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sideways {
    /// One surface as declared.
    pub first: Side,
    /// The other one.
    pub second: Side,
    /// The way of the one relative to the other, the mean over their contact forces (UL).
    pub way: f64,
    /// The width of the contact zone along it (UL).
    pub width: f64,
}

impl<const D: usize> Problem<D> {
    /// Curved surfaces that have moved sideways on each other by more than a twentieth of their contact zone, under small strains.
    ///
    /// Contact in [`Geometry::Reference`] does not follow such motions. Under both passes each surface holds the other one, one where
    /// it was and one where it is: force and area are too large. Empty in [`Geometry::Current`], for surfaces with one pass, and if
    /// `solution` is not of this problem.
    pub fn sideways(&self, solution: &Solution) -> Vec<Sideways> {
        let u = &solution.state.u;
        if self.geometry() == Geometry::Current || !self.is_state(u) {
            return Vec::new();
        }
        let Ok(states) = self.pair_states(u, &solution.gaps, &solution.lambda) else {
            return Vec::new();
        };
        let (moved, normals) = (self.displacements(u), self.contact_normals(u));
        let found = states
            .iter()
            .filter_map(|state| self.sideways_of(state, &moved, &normals));
        found.collect()
    }

    fn sideways_of(
        &self,
        state: &PairState<D>,
        moved: &[Vector<D>],
        normals: &[Vec<Vector<D>>],
    ) -> Option<Sideways> {
        let [first, second] = &state.sides[..] else {
            return None;
        };
        let super::Opposite::Side(other) = &state.record.second else {
            return None;
        };
        let has = |slave: usize, master: usize| self.passes().contains(&Pass { slave, master });
        let [a, b] = [first.surface, second.surface];
        if !(has(a, b) && has(b, a)) {
            return None;
        }
        let along = state.record.resultant.try_normalize(0.0)?;
        let [own, others] = [first, second].map(|side| self.mean_way(side, moved));
        let way = own? - others?;
        let way = way - along * along.dot(&way);
        let length = way.norm();
        let direction = way.try_normalize(0.0)?;
        let range = |side: &PairSide<D>, of: &dyn Fn(usize) -> f64| {
            let pressing = side.pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
            let values = pressing.map(|(k, _)| of(k));
            let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            (ends.1 - ends.0).max(0.0)
        };
        let bend = |side: &PairSide<D>| range(side, &|k| normals[side.surface][k].dot(&direction));
        let extent = |side: &PairSide<D>| {
            let nodes = self.surfaces()[side.surface].nodes();
            range(side, &|k| self.reference()[nodes[k]].dot(&direction))
        };
        let width = extent(first).max(extent(second));
        let is_told = bend(first).max(bend(second)) > FLAT && length > WAY * width && width > 0.0;
        is_told.then(|| Sideways {
            first: state.record.first.clone(),
            second: other.clone(),
            way: length,
            width,
        })
    }

    /// The mean displacement of the nodes of a surface, weighted with their contact forces.
    fn mean_way(&self, side: &PairSide<D>, moved: &[Vector<D>]) -> Option<Vector<D>> {
        let nodes = self.surfaces()[side.surface].nodes().iter();
        let weighted = nodes.zip(&side.forces).map(|(a, f)| (moved[*a], f.norm()));
        let (sum, total) = weighted.fold((Vector::zeros(), 0.0), |(sum, total), (u, f)| {
            (sum + u * f, total + f)
        });
        (total > 0.0).then(|| sum / total)
    }
}
