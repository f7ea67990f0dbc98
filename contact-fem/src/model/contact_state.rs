//! What the two surfaces of each pair do to each other at a state: forces, gaps, pressures, areas.

use std::fmt;

use contact_core::LinearGaps;

use super::contact_set::place_of;
use super::{ObstacleId, Problem, Side};
use crate::assembly::Dof;
use crate::contact::pressure::{self, Pressed};
use crate::contact::{Pass, Surface};
use crate::error::Error;
use crate::tensor::Vector;

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
    /// The pressure of the pair (UF/UL or UF/UL² of reference area), see [`Problem::pressures`].
    pub pressures: Vec<f64>,
}

/// What a surface meets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Opposite {
    /// A boundary of a body.
    Side(Side),
    /// An obstacle.
    Obstacle(ObstacleId),
}

/// A pair of surfaces at a state.
#[derive(Clone, Debug)]
pub struct PairState<const D: usize> {
    /// The first surface of the pair as declared, and the other one; in self-contact and on an obstacle one surface alone.
    pub sides: Vec<PairSide<D>>,
    /// What an engineer asks of it.
    pub record: PairRecord<D>,
}

/// Area, force and place of the contact of one pair.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRecord<const D: usize> {
    /// One surface as declared.
    pub first: Side,
    /// The other one, or the obstacle.
    pub second: Opposite,
    /// The reference area around pressing nodes (UL in the plane, UL² in space), on the surface with more nodes; in self-contact,
    /// of both sides.
    pub area: f64,
    /// The contact force on the first surface (UF); zero in self-contact.
    pub resultant: Vector<D>,
    /// The mean of the positions of the first surface's nodes (UL), weighted with the magnitudes of their contact forces; `None` without
    /// a force.
    pub centre: Option<Vector<D>>,
    /// The largest pressure on the two surfaces (UF/UL or UF/UL² of reference area).
    pub pressure_max: f64,
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
        self.check_rows(u, gaps, lambda)?;
        let moved = self.kinematics.largest(u);
        let state = |pair: ([usize; 2], Side, Opposite)| {
            let [slave, master] = pair.0;
            match self.contact.is_near(Pass { slave, master }, moved) {
                true => self.pair_state(pair, u, gaps, lambda),
                false => self.pair_apart(pair),
            }
        };
        Ok(self.declared_pairs().into_iter().map(state).collect())
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
                centre: None,
                pressure_max: 0.0,
            },
            sides: match a != b && b < self.surfaces().len() {
                true => vec![side(a), side(b)],
                false => vec![side(a)],
            },
        }
    }

    fn pair_state(
        &self,
        (members, first, second): ([usize; 2], Side, Opposite),
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[f64],
    ) -> PairState<D> {
        let [a, b] = members;
        let modulus = self.pair_modulus(members);
        let mut sides = vec![self.pair_side([a, b], modulus, u, (gaps, lambda))];
        if a != b && b < self.surfaces().len() {
            sides.push(self.pair_side([b, a], modulus, u, (gaps, lambda)));
        }
        let finest = sides.iter().max_by_key(|side| side.pressures.len());
        let area = finest.map_or(0.0, |side| {
            let areas = self.surfaces()[side.surface].node_areas();
            let nodes = side.pressures.iter().zip(areas);
            nodes.filter(|(p, _)| **p > 0.0).map(|(_, area)| area).sum()
        });
        let pressures = sides.iter().flat_map(|side| &side.pressures);
        // a pressure that is no number is not hidden by others
        let larger = |m: f64, p: f64| if p > m || p.is_nan() { p } else { m };
        let pressure_max = pressures.copied().fold(0.0, larger);
        let positions = self.positions(u);
        let places = self.surfaces()[a]
            .nodes()
            .iter()
            .map(|&node| positions[node]);
        let weighted = sides[0].forces.iter().map(Vector::norm).zip(places);
        let (sum, total) = weighted.fold((Vector::zeros(), 0.0), |(sum, total), (f, x)| {
            (sum + x * f, total + f)
        });
        PairState {
            record: PairRecord {
                first,
                second,
                area,
                resultant: match a == b {
                    true => Vector::zeros(),
                    false => sides[0].forces.iter().sum(),
                },
                centre: (total > 0.0).then(|| sum / total),
                pressure_max,
            },
            sides,
        }
    }

    fn pair_side(
        &self,
        [index, other]: [usize; 2],
        modulus: f64,
        u: &[f64],
        rows: (&LinearGaps, &[f64]),
    ) -> PairSide<D> {
        let surface = &self.surfaces()[index];
        let is_own = |pass: &Pass| pass.slave == index && pass.master == other;
        let is_pair = |pass: &Pass| is_own(pass) || (pass.slave == other && pass.master == index);
        let forces = self.forces_on(surface, rows, is_pair);
        let own = self.forces_on(surface, rows, is_own);
        let gaps = self.contact.nodal_gaps([index, other], &self.kinematics, u);
        let located = self.contact.located(&self.kinematics, u);
        let facing = match self.surfaces().get(other) {
            Some(facing) if other != index && !self.is_rigid(facing) => {
                let x = facing.gather(&located.x);
                let spacings = facing.node_spacings(&x);
                let forces = self.forces_on(facing, rows, is_pair);
                let nodes = x.into_iter().zip(spacings).zip(forces);
                let loaded = nodes.filter(|(_, force)| force.norm() > 0.0);
                loaded.map(|(node, _)| node).collect()
            }
            _ => Vec::new(),
        };
        let pressed = Pressed {
            facing: &facing,
            surface,
            x: &surface.gather(&located.x),
            normals: located.master(index).normals(),
            forces: &forces,
            own: &own,
            gaps: &gaps,
            modulus,
        };
        PairSide {
            surface: index,
            pressures: pressed.pressures(),
            forces,
            gaps,
        }
    }

    /// E* of the bodies of a pair (UF/UL²): 1/E* = Σ (1 − ν²)/E, without obstacles and bodies whose surfaces do not deform.
    fn pair_modulus(&self, members: [usize; 2]) -> f64 {
        let compliance = |index: usize| {
            let Some(surface) = self.surfaces().get(index) else {
                return 0.0;
            };
            let modulus = self.body_energies()[surface.body()].contact_modulus();
            match self.is_rigid(surface) {
                true => 0.0,
                false => modulus.recip(),
            }
        };
        members.map(compliance).iter().sum::<f64>().recip()
    }

    /// Whether all nodes of a surface are prescribed.
    fn is_rigid(&self, surface: &Surface<D>) -> bool {
        let mut dofs = surface.nodes().iter().flat_map(|a| D * a..D * (a + 1));
        dofs.all(|dof| matches!(self.dofs().get(dof), Dof::Prescribed(_)))
    }

    /// The contact pressure at the nodes of each surface (UF/UL or UF/UL² of reference area, ≥ 0), summed over the pairs of
    /// the surface: the field of [`Pressed::pressures`], which never pulls and keeps the resultant of the nodal forces.
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

    /// The consistent contact pressure at the nodes of each surface (UF/UL or UF/UL² of reference area, compression positive):
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
