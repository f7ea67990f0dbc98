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

/// Below this share of the sum of all forces the resultant has no direction.
const BALANCED: f64 = 1e-3;
/// The force that loads a node, as a share of the largest one of its pair.
const LOADED: f64 = 1e-6;

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
    /// The pressure of the pair (UF/UL or UF/UL²), see [`Problem::pressures`]; where other pairs press on the same facets, the part of
    /// it that the pair has of the forces.
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

/// What one surface takes part in with one other.
struct Share<const D: usize> {
    /// The number of the pair.
    pair: usize,
    other: usize,
    /// The forces of the passes in which the surface is the slave, its normals, and what [`Pressed`] asks of the other one.
    own: Vec<Vector<D>>,
    normals: Vec<Vector<D>>,
    facing: Vec<(Vector<D>, f64)>,
    modulus: f64,
    area: f64,
    side: PairSide<D>,
}

/// Which nodes these forces load.
fn loaded<const D: usize>(forces: &[Vector<D>]) -> Vec<bool> {
    let sizes = || forces.iter().map(Vector::norm);
    let largest = sizes().fold(0.0, f64::max);
    sizes().map(|size| size > LOADED * largest).collect()
}

/// The areas of the nodes at `x` that are within the contact zone, and zero at the others. Nodes next to the zone press, too,
/// since their test functions reach into it; they are next to nodes that do not. Where no node is within, the most pressed one counts.
fn covered<const D: usize>(
    surface: &Surface<D>,
    x: &[Vector<D>],
    pressures: &[f64],
    forces: &[Vector<D>],
) -> Vec<f64> {
    let mut areas = surface.node_areas(x);
    let loaded = loaded(forces);
    let presses = |a: usize| pressures[a] > 0.0;
    let neighbours = surface.neighbours();
    let is_within = |a: usize| {
        let mut all = neighbours[a].iter();
        presses(a) && all.all(|&b| presses(b) || loaded[b])
    };
    let mut within: Vec<bool> = (0..x.len()).map(is_within).collect();
    if !within.contains(&true) {
        let pressing = (0..x.len()).filter(|a| presses(*a));
        let most = pressing.max_by(|&a, &b| pressures[a].total_cmp(&pressures[b]));
        most.into_iter().for_each(|a| within[a] = true);
    }
    for (area, _) in areas.iter_mut().zip(within).filter(|(_, within)| !within) {
        *area = 0.0;
    }
    areas
}

/// The shares of one surface that load nodes in common, as the recovery takes them.
struct Together<const D: usize> {
    forces: Vec<Vector<D>>,
    own: Vec<Vector<D>>,
    gaps: Vec<Option<f64>>,
    facing: Vec<(Vector<D>, f64)>,
    moduli: Vec<f64>,
    /// For each share the part that it has of the forces at and around each node.
    parts: Vec<Vec<f64>>,
}

impl<const D: usize> Together<D> {
    fn new(surface: &Surface<D>, shares: &[Share<D>], group: &[usize]) -> Self {
        let members = || group.iter().map(|&member| &shares[member]);
        let nodes = 0..surface.nodes().len();
        let sum = |of: fn(&Share<D>) -> &[Vector<D>]| {
            let at = |a: usize| members().map(|share| of(share)[a]).sum();
            nodes.clone().map(at).collect()
        };
        let gap = |a: usize| {
            let gaps = members().filter_map(|share| share.side.gaps[a]);
            gaps.reduce(f64::min)
        };
        let neighbours = match group.len() {
            1 => Vec::new(),
            _ => surface.neighbours(),
        };
        let around = |share: &Share<D>, a: usize| -> f64 {
            let nodes = neighbours[a].iter().chain([&a]);
            nodes.map(|&b| share.side.forces[b].norm()).sum()
        };
        let mut parts = vec![vec![1.0; nodes.len()]; group.len()];
        let mut moduli = vec![shares[group[0]].modulus; nodes.len()];
        if group.len() > 1 {
            for a in nodes.clone() {
                let sizes: Vec<f64> = members().map(|share| around(share, a)).collect();
                let (total, largest) = sizes
                    .iter()
                    .fold((0.0, 0.0), |(sum, most), size| (sum + size, size.max(most)));
                for (k, size) in sizes.iter().enumerate() {
                    parts[k][a] = if total > 0.0 { size / total } else { 0.0 };
                    if *size == largest {
                        moduli[a] = shares[group[k]].modulus;
                    }
                }
            }
        }
        Together {
            forces: sum(|share| &share.side.forces),
            own: sum(|share| &share.own),
            gaps: nodes.clone().map(gap).collect(),
            facing: members().flat_map(|share| share.facing.clone()).collect(),
            moduli,
            parts,
        }
    }
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
    /// The area of the contact zone where contact is searched (UL in the plane, UL² in space): that around the nodes within it, on
    /// the surface where it is smaller; in self-contact, of both sides. Its border is known to within a facet.
    pub area: f64,
    /// The contact force on the first surface (UF); zero in self-contact.
    pub resultant: Vector<D>,
    /// The centre of pressure: the mean of the positions of the first surface's nodes (UL), weighted with the components of their
    /// contact forces along the resultant, so that it has no moment about it where forces are parallel. Where forces cancel, as around a
    /// pin, the weights are the components against the normals. `None` without a force.
    pub centre: Option<Vector<D>>,
    /// The largest pressure on the two surfaces (UF/UL or UF/UL²).
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
        let pairs = self.declared_pairs();
        let mut shares = Vec::new();
        for (pair, &([a, b], ..)) in pairs.iter().enumerate() {
            let [slave, master] = [a, b];
            if self.contact.is_near(Pass { slave, master }, moved) {
                shares.push(self.share(pair, [a, b], u, (gaps, lambda)));
                if a != b && b < self.surfaces().len() {
                    shares.push(self.share(pair, [b, a], u, (gaps, lambda)));
                }
            }
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
        let (own, surface) = (&shares[0], &self.surfaces()[shares[0].side.surface]);
        let total: f64 = own.side.forces.iter().map(Vector::norm).sum();
        let resultant: Vector<D> = own.side.forces.iter().sum();
        let along = (resultant.norm() > BALANCED * total).then(|| resultant.normalize());
        let nodes = surface.nodes().iter().enumerate();
        let weighted = nodes.map(|(k, &node)| {
            let along = along.unwrap_or(-own.normals[k]);
            (positions[node], own.side.forces[k].dot(&along))
        });
        let (sum, total) = weighted.fold((Vector::zeros(), 0.0), |(sum, total), (x, f)| {
            (sum + x * f, total + f)
        });
        PairState {
            record: PairRecord {
                first,
                second,
                area: area.unwrap_or(0.0),
                resultant: match own.other == own.side.surface {
                    true => Vector::zeros(),
                    false => resultant,
                },
                centre: (total > 0.0).then(|| sum / total),
                pressure_max,
            },
            sides: shares.into_iter().map(|share| share.side).collect(),
        }
    }

    /// What the surface `index` takes part in with `other`, without pressures.
    fn share(
        &self,
        pair: usize,
        [index, other]: [usize; 2],
        u: &[f64],
        rows: (&LinearGaps, &[f64]),
    ) -> Share<D> {
        let surface = &self.surfaces()[index];
        let is_own = |pass: &Pass| pass.slave == index && pass.master == other;
        let is_pair = |pass: &Pass| is_own(pass) || (pass.slave == other && pass.master == index);
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
        Share {
            pair,
            other,
            own: self.forces_on(surface, rows, is_own),
            facing,
            modulus: self.pair_modulus([index, other]),
            normals: located.master(index).normals().to_vec(),
            area: 0.0,
            side: PairSide {
                surface: index,
                forces: self.forces_on(surface, rows, is_pair),
                gaps: self.contact.nodal_gaps([index, other], &self.kinematics, u),
                pressures: vec![0.0; surface.nodes().len()],
            },
        }
    }

    /// Recovers the pressures and the areas of all shares: of those together that load a node in common, since there a pressure is
    /// one field, of which each has the part of its forces.
    fn press(&self, shares: &mut [Share<D>], u: &[f64]) {
        let located = self.contact.located(&self.kinematics, u);
        let loaded: Vec<Vec<bool>> = shares
            .iter()
            .map(|share| loaded(&share.side.forces))
            .collect();
        let meet = |i: usize, j: usize| {
            let mut nodes = loaded[i].iter().zip(&loaded[j]);
            nodes.any(|(a, b)| *a && *b)
        };
        let mut is_done = vec![false; shares.len()];
        for first in 0..shares.len() {
            if std::mem::replace(&mut is_done[first], true) {
                continue;
            }
            let index = shares[first].side.surface;
            let mut group = vec![first];
            let mut next = 0;
            while let Some(&i) = group.get(next) {
                next += 1;
                for j in first..shares.len() {
                    if !is_done[j] && shares[j].side.surface == index && meet(i, j) {
                        is_done[j] = true;
                        group.push(j);
                    }
                }
            }
            let surface = &self.surfaces()[index];
            let x = surface.gather(&located.x);
            let all = Together::new(surface, shares, &group);
            let pressed = Pressed {
                surface,
                x: &x,
                normals: located.master(index).normals(),
                forces: &all.forces,
                own: &all.own,
                gaps: &all.gaps,
                facing: &all.facing,
                moduli: &all.moduli,
            };
            let pressures = pressed.pressures();
            let areas = covered(surface, &x, &pressures, &all.forces);
            for (&member, parts) in group.iter().zip(&all.parts) {
                let share = &mut shares[member];
                for (a, part) in parts.iter().enumerate() {
                    share.side.pressures[a] = part * pressures[a];
                    share.area += part * areas[a];
                }
            }
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

    /// The contact pressure at the nodes of each surface (UF/UL or UF/UL², ≥ 0), of all pairs of the surface. It is a force per area
    /// where contact is searched: the current one, or for [`Geometry::Reference`](super::Geometry::Reference) the undeformed one. It is
    /// the field of [`Pressed::pressures`], which never pulls and keeps the resultant of the nodal forces.
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

    /// The consistent contact pressure at the nodes of each surface (UF/UL or UF/UL² of the undeformed area, compression positive):
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
