//! What the two surfaces of each pair do to each other at a state: forces, gaps, pressures, areas.

mod geometric_error;
mod record;
mod shares;

use std::fmt;

use contact_core::LinearGaps;

use super::contact_set::place_of;
use super::{ObstacleId, Problem, Side};
use crate::contact::{Pass, Surface, pressure};
use crate::error::Error;
use crate::instances::instance;
use crate::tensor::Vector;

pub use self::geometric_error::GeometricError;
pub use self::record::{Opposite, PairRecord};

/// Whether a contact node carries a force or might.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// It is apart from all other surfaces, or no contact node.
    #[default]
    Open,
    /// It has no pressure, and its gap is below a thousandth of the facets around it.
    Touching,
    /// It has a pressure.
    Pressing,
}

impl Status {
    /// The gap below which an unloaded node touches, as a share of the mean length of the facets around it.
    pub const TOUCHES: f64 = 1e-3;
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Status::Open => "open",
            Status::Touching => "touching",
            Status::Pressing => "pressing",
        })
    }
}

/// One surface of a pair at a state. The vectors have one entry for each node of the surface.
#[derive(Clone, Debug)]
pub struct PairSide<const D: usize> {
    /// The surface, as its position in [`Problem::surfaces`].
    pub surface: usize,
    /// The forces of the pair on the nodes (UF).
    pub forces: Vec<Vector<D>>,
    /// The gaps to the other surface (UL), positive = open, less what [`InitialGaps`](super::InitialGaps) grants; `None` where no
    /// point of the other surface counts, and on surfaces further apart than displacements could close.
    pub gaps: Vec<Option<f64>>,
    /// The pressure of the pair (UF/UL²), see [`Problem::pressures`]; where other pairs press on the same facets, the part of
    /// it that the pair has of the forces.
    pub pressures: Vec<f64>,
}

/// A pair of surfaces at a state.
#[derive(Clone, Debug)]
pub struct PairState<const D: usize> {
    /// The first surface of the pair as declared, and the other one; in self-contact and on an obstacle one surface alone.
    pub sides: Vec<PairSide<D>>,
    /// What an engineer asks of it.
    pub record: PairRecord<D>,
}

impl<const D: usize> Problem<D> {
    /// What the surfaces of each pair do to each other, pair by pair in the order of their declaration, and then what obstacles
    /// and surfaces do.
    ///
    /// # Errors
    /// A `u` that is no state, multipliers that are not one a row, rows of another problem.
    pub fn pair_states(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<Vec<PairState<D>>, Error> {
        instance().pair_states(self, u, (gaps, lambda))
    }

    /// [`Problem::pair_states`].
    pub(crate) fn states_of_pairs(
        &self,
        u: &[f64],
        (gaps, lambda): (&LinearGaps, &[f64]),
    ) -> Result<Vec<PairState<D>>, Error> {
        self.check_rows(u, gaps, lambda)?;
        let moved = self.kinematics.largest(u);
        let pairs = self.declared_pairs();
        let mut shares = Vec::new();
        for (pair, &([a, b], ..)) in pairs.iter().enumerate() {
            let directions = self.directions([a, b], moved);
            shares.extend(directions.map(|own| self.share(pair, own, u, (gaps, lambda))));
        }
        self.press(&mut shares, u);
        let positions = self.positions(u);
        let mut shares = shares.into_iter().peekable();
        let state = |(pair, (members, first, second))| {
            let mut own = Vec::new();
            while let Some(share) = shares.next_if(|share| share.pair == pair) {
                own.push(share);
            }
            match own.is_empty() {
                true => self.pair_apart((members, first, second)),
                false => self.pair_state(first, second, own, &positions),
            }
        };
        Ok(pairs.into_iter().enumerate().map(state).collect())
    }

    /// A pair of surfaces seen from either, or from the one that is a surface and no obstacle; nothing where the largest displacement
    /// `moved` (UL) cannot bring them together.
    fn directions(
        &self,
        [a, b]: [usize; 2],
        moved: f64,
    ) -> impl Iterator<Item = [usize; 2]> + use<D> {
        let pass = Pass {
            slave: a,
            master: b,
        };
        let is_near = self.contact.is_near(pass, moved);
        let is_mutual = a != b && b < self.surfaces().len();
        let first = is_near.then_some([a, b]);
        first
            .into_iter()
            .chain((is_near && is_mutual).then_some([b, a]))
    }

    /// The two members of each pair as passes number them, with their names.
    pub(crate) fn declared_pairs(&self) -> Vec<([usize; 2], Side, Opposite)> {
        let mut sides = Vec::<&Side>::new();
        let mut number = |side| place_of(side, &mut sides);
        let mut pairs = Vec::<([usize; 2], Side, Opposite)>::new();
        for pair in self.scene().pairs() {
            let [a, b] = [&pair.first, &pair.second].map(&mut number);
            let mut known = pairs.iter().map(|(members, ..)| members);
            if !known.any(|known| *known == [a, b] || *known == [b, a]) {
                let second = Opposite::Side(pair.second.clone());
                pairs.push(([a, b], pair.first.clone(), second));
            }
        }
        for (side, obstacle) in self.scene().obstructed() {
            let members = [number(side), self.surfaces().len() + obstacle];
            let second = Opposite::Obstacle(ObstacleId(*obstacle));
            pairs.push((members, side.clone(), second));
        }
        pairs
    }

    /// Checks that `u` is a state and that the rows are of this problem, with a multiplier each.
    pub(super) fn check_rows(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<(), Error> {
        contact_core::Error::check_vector("u", u, self.dofs().free())?;
        contact_core::Error::check_vector("λ", lambda, gaps.len())?;
        let last = gaps.keys().iter().map(|key| key.pass).max();
        match last.filter(|last| *last as usize >= self.passes().len()) {
            Some(last) => Err(Error::Setting {
                name: "pass",
                value: last.into(),
                remedy: "take rows of this problem",
            }),
            None => Ok(()),
        }
    }

    /// The contact forces of the passes that `counts` on the nodes of a surface.
    fn forces_on(
        &self,
        surface: &Surface<D>,
        rows: (&LinearGaps, &[f64]),
        counts: impl Fn(&Pass) -> bool,
    ) -> Vec<Vector<D>> {
        match self.forces_of(rows, counts) {
            Some(all) => surface.nodes().iter().map(|&a| all[a]).collect(),
            None => vec![Vector::zeros(); surface.nodes().len()],
        }
    }

    /// The state of a pair that no displacement brings together, or that does not count.
    fn pair_apart(&self, ([a, b], first, second): ([usize; 2], Side, Opposite)) -> PairState<D> {
        let side = |surface: usize| {
            let nodes = self.surfaces()[surface].nodes().len();
            PairSide {
                surface,
                pressures: vec![0.0; nodes],
                forces: vec![Vector::zeros(); nodes],
                gaps: vec![None; nodes],
            }
        };
        PairState {
            record: PairRecord {
                first,
                second,
                area: 0.0,
                resultant: Vector::zeros(),
                friction: Vector::zeros(),
                centre: None,
                pressure_max: 0.0,
            },
            sides: match a != b && b < self.surfaces().len() {
                true => vec![side(a), side(b)],
                false => vec![side(a)],
            },
        }
    }

    /// The contact pressure at the nodes of each surface (UF/UL², ≥ 0), of all pairs of the surface. It is a force per area
    /// where contact is searched: the current one, or for [`Geometry::Reference`](super::Geometry::Reference) the undeformed one. It is
    /// the field of [`Pressed::pressures`](pressure::Pressed::pressures), which pulls at no node and keeps the resultant of the nodal
    /// forces as far as pressures can: an arc bears no moment about its centre.
    ///
    /// # Errors
    /// A `u` that is no state, multipliers that are not one a row, rows of another problem.
    pub fn pressures(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let states = self.pair_states(u, gaps, lambda)?;
        Ok(self.surface_pressures(&states))
    }

    /// The pressures of [`Problem::pressures`] from the states of all pairs.
    pub(crate) fn surface_pressures(&self, states: &[PairState<D>]) -> Vec<Vec<f64>> {
        let nodes = self.surfaces().iter().map(|surface| surface.nodes().len());
        let mut sums: Vec<Vec<f64>> = nodes.map(|count| vec![0.0; count]).collect();
        for side in states.iter().flat_map(|state| &state.sides) {
            let own = sums[side.surface].iter_mut().zip(&side.pressures);
            own.for_each(|(sum, p)| *sum += p);
        }
        sums
    }

    /// The outward unit normals at the nodes of each surface, where contact is searched at `u`; zero if `u` is no state.
    pub fn contact_normals(&self, u: &[f64]) -> Vec<Vec<Vector<D>>> {
        if !self.is_state(u) {
            let surfaces = self.surfaces().iter();
            return surfaces
                .map(|surface| vec![Vector::zeros(); surface.nodes().len()])
                .collect();
        }
        let located = self.contact.located(&self.kinematics, u);
        let surfaces = 0..self.surfaces().len();
        surfaces
            .map(|k| located.master(k).normals().to_vec())
            .collect()
    }

    /// The consistent contact pressure at the nodes of each surface (UF/UL² of the undeformed area, compression positive):
    /// the field of test functions whose nodal forces are those of all passes of the surface, and its component along the
    /// normals. It may be negative where the forces of the two passes do not belong to such a field.
    ///
    /// # Errors
    /// As [`Problem::pressures`], and [`pressure::tractions`].
    pub fn consistent_pressures(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        self.check_rows(u, gaps, lambda)?;
        let located = self.contact.located(&self.kinematics, u);
        let surfaces = self.surfaces().iter().enumerate();
        let of_surface = surfaces.map(|(index, surface)| {
            let takes_part = |pass: &Pass| pass.slave == index || pass.master == index;
            let forces = self.forces_on(surface, (gaps, lambda), takes_part);
            let tractions = pressure::tractions(surface, &forces)?;
            let pairs = tractions.iter().zip(located.master(index).normals());
            Ok(pairs.map(|(t, n)| -t.dot(n)).collect())
        });
        of_surface.collect()
    }
}
