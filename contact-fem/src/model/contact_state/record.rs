//! Area, force and place of the contact of one pair.

use contact_core::friction::Friction;

use super::shares::Share;
use super::{PairSide, PairState};
use crate::contact::Pass;
use crate::contact::pressure::BALANCED;
use crate::model::{ObstacleId, Problem, Side};
use crate::tensor::Vector;

/// What a surface meets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Opposite {
    /// A boundary of a body.
    Side(Side),
    /// An obstacle.
    Obstacle(ObstacleId),
}

/// Area, force and place of the contact of one pair.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRecord<const D: usize> {
    /// One surface as declared.
    pub first: Side,
    /// The other one, or the obstacle.
    pub second: Opposite,
    /// The area of the contact zone where contact is searched (UL²; in the plane of a slice of thickness 1): that around the nodes within it, on
    /// the surface where it is smaller; in self-contact, of both sides. Its border is known to within a facet.
    pub area: f64,
    /// The contact force on the first surface without friction (UF); zero in self-contact.
    pub resultant: Vector<D>,
    /// The force of friction on the first surface (UF); zero without, and in self-contact.
    pub friction: Vector<D>,
    /// The centre of pressure (UL): the mean of the positions of a surface's nodes, weighted with the components of their
    /// contact forces along the resultant, so that it has no moment about it where forces are parallel; of two surfaces halfway between
    /// the two. Where forces cancel, as around a pin, the weights are the components against the normals. `None` without a force.
    pub centre: Option<Vector<D>>,
    /// The largest pressure on the two surfaces (UF/UL²).
    pub pressure_max: f64,
}

impl<const D: usize> Problem<D> {
    /// The state of a pair of which these are the shares.
    pub(super) fn pair_state(
        &self,
        first: Side,
        second: Opposite,
        shares: Vec<Share<D>>,
        positions: &[Vector<D>],
    ) -> PairState<D> {
        let areas = shares.iter().map(|share| share.area);
        let area = areas.filter(|area| *area > 0.0).reduce(f64::min);
        let pressures = shares.iter().flat_map(|share| &share.side.pressures);
        // a pressure that is no number is not hidden by others
        let larger = |m: f64, p: f64| if p > m || p.is_nan() { p } else { m };
        let pressure_max = pressures.copied().fold(0.0, larger);
        let own = &shares[0];
        let resultant: Vector<D> = own.side.forces.iter().sum();
        let centres = shares.iter().map(|share| self.centre(share, positions));
        let centres: Vec<Vector<D>> = centres.flatten().collect();
        PairState {
            record: PairRecord {
                first,
                second,
                area: area.unwrap_or(0.0),
                resultant: match own.other == own.side.surface {
                    true => Vector::zeros(),
                    false => resultant,
                },
                friction: Vector::zeros(),
                centre: match centres.len() {
                    0 => None,
                    count => Some(centres.iter().sum::<Vector<D>>() / count as f64),
                },
                pressure_max,
            },
            sides: shares.into_iter().map(|share| share.side).collect(),
        }
    }
    /// The same record with the force of friction.
    pub(crate) fn with_friction(
        &self,
        record: PairRecord<D>,
        friction: Option<&Friction>,
    ) -> PairRecord<D> {
        let pairs = self.declared_pairs().into_iter();
        let mut members =
            pairs.filter(|(_, first, second)| (first, second) == (&record.first, &record.second));
        let members = members.next().map(|(members, ..)| members);
        let Some([a, b]) = members.filter(|[a, b]| friction.is_some() && a != b) else {
            return record;
        };
        let is_own = |pass: &Pass| {
            let both = [pass.slave, pass.master];
            both == [a, b] || both == [b, a]
        };
        let forces = self.forces_of_friction(friction, is_own);
        let nodes = self.surfaces()[a].nodes().iter();
        let friction = forces.map_or(Vector::zeros(), |forces| nodes.map(|&k| forces[k]).sum());
        PairRecord { friction, ..record }
    }

    /// The centre of the forces on one surface.
    fn centre(&self, share: &Share<D>, positions: &[Vector<D>]) -> Option<Vector<D>> {
        let PairSide {
            surface, forces, ..
        } = &share.side;
        let total: f64 = forces.iter().map(Vector::norm).sum();
        let resultant: Vector<D> = forces.iter().sum();
        let along = (resultant.norm() > BALANCED * total).then(|| resultant.normalize());
        let nodes = self.surfaces()[*surface].nodes().iter().enumerate();
        let weighted = nodes.map(|(k, &node)| {
            let along = along.unwrap_or(-share.normals[k]);
            (positions[node], forces[k].dot(&along))
        });
        let (sum, total) = weighted.fold((Vector::zeros(), 0.0), |(sum, total), (x, f)| {
            (sum + x * f, total + f)
        });
        (total > 0.0).then(|| sum / total)
    }
}
