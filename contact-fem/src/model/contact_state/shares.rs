//! What each surface takes part in, and the pressures that are recovered from it.

use std::collections::HashMap;

use contact_core::LinearGaps;
use contact_core::gaps::Sampling;

use super::PairSide;
use crate::assembly::Dof;
use crate::contact::pressure::{self, Pressed};
use crate::contact::{Pass, Surface};
use crate::model::Problem;
use crate::tensor::Vector;

/// The force that loads a node, as a share of the largest one of its pair.
const LOADED: f64 = 1e-6;

/// The pressure that loads a node, as a share of the largest one of all pairs: solvers leave as much where nothing presses.
const PRESSES: f64 = 1e-10;
/// The share of its coordinates that a position is known to, several roundings of it. A gap that is off by so much makes pressures where
/// nothing presses.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// What one surface takes part in with one other.
pub(super) struct Share<const D: usize> {
    /// The number of the pair.
    pub(super) pair: usize,
    pub(super) other: usize,
    /// The forces of the passes in which the surface is the slave, its normals, and what [`Pressed`] asks of the other one.
    pub(super) own: Vec<Vector<D>>,
    pub(super) normals: Vec<Vector<D>>,
    facing: Vec<(Vector<D>, f64)>,
    pub(super) modulus: f64,
    /// The gaps of nodes where both surfaces, taken as smooth ones, touch all along (UL).
    closed: Vec<f64>,
    pub(super) area: f64,
    pub(super) side: PairSide<D>,
}

/// Which nodes these forces load.
pub(super) fn loaded<const D: usize>(forces: &[Vector<D>]) -> Vec<bool> {
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
            let gaps = members().filter_map(|share| Some(share.side.gaps[a]? - share.closed[a]));
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
        if group.len() > 1 {
            for a in nodes.clone() {
                let sizes: Vec<f64> = members().map(|share| around(share, a)).collect();
                let total: f64 = sizes.iter().sum();
                for (parts, size) in parts.iter_mut().zip(sizes) {
                    parts[a] = if total > 0.0 { size / total } else { 0.0 };
                }
            }
        }
        // springs in series, weighted
        let modulus = |a: usize| {
            let parts = parts.iter().map(|parts| parts[a]);
            let compliances = members()
                .zip(parts)
                .map(|(share, part)| part / share.modulus);
            compliances.sum::<f64>().recip()
        };
        Together {
            forces: sum(|share| &share.side.forces),
            own: sum(|share| &share.own),
            gaps: nodes.clone().map(gap).collect(),
            facing: members().flat_map(|share| share.facing.clone()).collect(),
            moduli: nodes.map(modulus).collect(),
            parts,
        }
    }
}

impl<const D: usize> Problem<D> {
    /// What the surface `index` takes part in with `other`, without pressures.
    pub(super) fn share(
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
                x.into_iter().zip(spacings).collect()
            }
            _ => Vec::new(),
        };
        let gaps = self.contact.nodal_gaps([index, other], &self.kinematics, u);
        let smooth: Vec<Option<f64>> = gaps
            .iter()
            .map(|gap| Some(gap.as_ref()?.smooth()))
            .collect();
        let offsets = self.row_offsets(surface, &smooth, is_own, (u, rows.0));
        let closed = gaps.iter().zip(offsets);
        let closed = closed.map(|(gap, offset)| gap.map_or(0.0, |gap| gap.bulge) - offset);
        Share {
            pair,
            other,
            own: self.forces_on(surface, rows, is_own),
            facing,
            modulus: self.pair_modulus([index, other]),
            closed: closed.collect(),
            normals: located.master(index).normals().to_vec(),
            area: 0.0,
            side: PairSide {
                surface: index,
                forces: self.forces_on(surface, rows, is_pair),
                gaps: gaps.iter().map(|gap| Some((*gap)?.to_facet)).collect(),
                pressures: vec![0.0; surface.nodes().len()],
            },
        }
    }

    /// At each node of a surface by how much the gap of its row is above the mean of the nodes' `gaps` (UL); 0 where it has none.
    fn row_offsets(
        &self,
        surface: &Surface<D>,
        gaps: &[Option<f64>],
        is_own: impl Fn(&Pass) -> bool,
        (u, rows): (&[f64], &LinearGaps),
    ) -> Vec<f64> {
        if rows.sampling() == Sampling::Points {
            return vec![0.0; gaps.len()]; // rows of points have no test functions
        }
        let passes = self.passes();
        let all = rows.keys().iter().enumerate();
        let own = all.filter(|(_, key)| passes.get(key.pass as usize).is_some_and(&is_own));
        // its gap C u + c₀, and the integral of its test function
        let own = own.map(|(i, key)| {
            let gap = rows.constant()[i] + rows.matrix().times(i, u);
            (key.node as usize, (gap, rows.weights()[i]))
        });
        let own: HashMap<usize, (f64, f64)> = own.collect();
        pressure::row_offsets(surface, gaps, |a| own.get(&surface.nodes()[a]).copied())
    }

    /// Recovers the pressures and the areas of all shares: of those together that load a node in common, since there a pressure is
    /// one field, of which each has the part of its forces.
    pub(super) fn press(&self, shares: &mut [Share<D>], u: &[f64]) {
        let located = self.contact.located(&self.kinematics, u);
        let loaded: Vec<Vec<bool>> = shares
            .iter()
            .map(|share| loaded(&share.side.forces))
            .collect();
        let meet = |i: usize, j: usize| {
            let mut nodes = loaded[i].iter().zip(&loaded[j]);
            nodes.any(|(a, b)| *a && *b)
        };
        let mut recovered = Vec::new();
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
            recovered.push((group, x, all, pressures));
        }
        let all = recovered.iter().flat_map(|(.., pressures)| pressures);
        let largest = all.fold(0.0, |m: f64, p| m.max(*p));
        for (group, x, all, mut pressures) in recovered {
            let surface = &self.surfaces()[shares[group[0]].side.surface];
            let sizes = surface.node_sizes();
            for (a, pressure) in pressures.iter_mut().enumerate() {
                let strain = ROUNDING * x[a].amax() / sizes[a];
                let stiffness = Some(all.moduli[a]).filter(|E| E.is_finite());
                let least = stiffness.map_or(0.0, |E| E * strain).max(PRESSES * largest);
                if *pressure <= least {
                    *pressure = 0.0;
                }
            }
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
}
