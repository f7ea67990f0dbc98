//! How far contact at the reference positions is from that at the present ones.

use contact_core::equilibrium::Solution;

use super::Opposite;
use super::shares::{Share, loaded};
use crate::contact::Pass;
use crate::contact::search::NodalGap;
use crate::model::{Geometry, Problem, Side, negligible};

/// The error that is told, as a share of the indentation. On a cylinder that is moved sideways, the force is 6 % too large then with both
/// passes, and below 0.5 % with one. On meshes with a facet as wide as the contact zone, bodies that have not moved have nearly as much.
const TOLD: f64 = 0.03;

/// A pair whose contact at the reference positions is far from that at the present ones, as [`Problem::geometric_errors`] finds it.
#[derive(Clone, Debug, PartialEq)]
pub struct GeometricError {
    /// One surface as declared.
    pub first: Side,
    /// The other one, or the obstacle.
    pub second: Opposite,
    /// By how much gaps at the present positions differ from those that the contact took: the mean over the forces in a contact zone (UL).
    /// Where nothing is opposite any more, it is the indentation; beside a rim, the share of it that is beyond.
    pub error: f64,
    /// The indentation of that zone, Σ|f|/(A E*) times its width (UL).
    pub indentation: f64,
}

impl<const D: usize> Problem<D> {
    /// Pairs whose contact at the reference positions differs from that at the present positions by more than 3 % of the
    /// indentation, with their worst zones: as where a curved body has moved sideways on another one, or has turned.
    ///
    /// Contact in [`Geometry::Reference`] does not follow such motions: places, and with both passes areas and forces, are wrong, and
    /// [`Geometry::Current`] is the better choice. Flat surfaces that slide on each other keep their gaps, but for what slides off: there it
    /// is the whole indentation. Empty in [`Geometry::Current`], and if `solution` is not of this problem.
    pub fn geometric_errors(&self, solution: &Solution) -> Vec<GeometricError> {
        let (u, rows) = (&solution.state.u, (&solution.gaps, &solution.lambda[..]));
        if self.geometry() == Geometry::Current || self.check_rows(u, rows.0, rows.1).is_err() {
            return Vec::new();
        }
        let now = self.kinematics.positions(u);
        // the last one is kept, which shares take, too
        let present = self.contact.located_at(&now);
        let searched = self.contact.located(&self.kinematics, u);
        let moved = self.kinematics.largest(u);
        let [least, no_force, _] = negligible(&self.scale());
        let mut found = Vec::new();
        for (pair, ([a, b], first, second)) in self.declared_pairs().into_iter().enumerate() {
            let errors = self.directions([a, b], moved).flat_map(|[slave, master]| {
                let share = self.share(pair, [slave, master], u, rows);
                let pass = Pass { slave, master };
                let gaps =
                    [&searched, &present].map(|at| self.contact.gaps_between(pass, at, &now));
                let surface = &self.surfaces()[slave];
                let spacings = surface.node_spacings(surface.reference_nodes());
                // half a spacing from the rim, nothing of a node's area is opposite
                let lost = spacings.iter().enumerate().map(|(k, spacing)| {
                    let off = self.contact.beyond_the_rim(pass, &present, k);
                    off.map_or(1.0, |off| (2.0 * off / spacing).min(1.0))
                });
                let lost: Vec<f64> = lost.collect();
                self.errors_of(&share, gaps, &lost, no_force)
            });
            let worst = errors.max_by(|[a, b], [c, d]| (a / b).total_cmp(&(c / d)));
            if let Some([error, indentation]) = worst.filter(|[e, of]| *e > (TOLD * of).max(least))
            {
                found.push(GeometricError {
                    first,
                    second,
                    error,
                    indentation,
                });
            }
        }
        found
    }

    /// Error and indentation of each contact zone of a surface, whose gaps are those that the contact took and the present ones; `lost` is
    /// the share of a node's area that has nothing opposite where it has no present gap. Zones with less than `no_force` (UF) are none.
    fn errors_of(
        &self,
        share: &Share<D>,
        [taken, present]: [Vec<Option<NodalGap>>; 2],
        lost: &[f64],
        no_force: f64,
    ) -> Vec<[f64; 2]> {
        let surface = &self.surfaces()[share.side.surface];
        let areas = surface.node_areas(surface.reference_nodes());
        let forces = &share.side.forces;
        let of_zone = |zone: Vec<usize>| {
            let sum = |of: &dyn Fn(usize) -> f64| zone.iter().map(|&a| of(a)).sum::<f64>();
            let force = sum(&|a| forces[a].norm());
            if force <= no_force {
                return [0.0; 2];
            }
            let area = sum(&|a| areas[a]);
            let is_in_space = D == 3 || surface.is_of_revolution();
            let width = if is_in_space { area.sqrt() } else { area };
            let indentation = force / (area * share.modulus) * width;
            // gaps of the surface count where its own rows act; where the other surface is no longer opposite, no row of either would
            let error = sum(&|a| match (taken[a], present[a]) {
                (Some(taken), Some(present)) => {
                    share.own[a].norm() * (present.smooth() - taken.smooth()).abs()
                }
                (Some(_), None) => forces[a].norm() * indentation * lost[a],
                _ => 0.0,
            }) / force;
            [error, indentation]
        };
        let zones = surface.zones(&loaded(forces)).into_iter().map(of_zone);
        zones
            .filter(|[error, indentation]| error.is_finite() && *indentation > 0.0)
            .collect()
    }
}
