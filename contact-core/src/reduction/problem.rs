//! The problem over the independent unknowns.

use std::cell::RefCell;
use std::collections::{HashMap, VecDeque};

use super::energy::{GroupEnergy, Part};
use super::{LinearMap, Place, Reduction};
use crate::equilibrium::Solution;
use crate::friction::{Friction, SlipRow, SlipRows};
use crate::gaps::{Row, Sampling};
use crate::{
    Bounds, ContactProblem, DirectSum, Energy, Error, GapVariation, LinearGaps, Multipliers,
    RowKey, Scale, Separable, State,
};

/// So many sets of rows are kept, to find those over all unknowns that a solution's are made from: both roles of the last
/// subproblem, and of the one before.
const KEPT: usize = 4;

/// `full` over its independent unknowns.
pub(super) struct Reduced<'a> {
    full: &'a dyn ContactProblem,
    map: &'a LinearMap,
    constants: &'a [f64],
    energy: DirectSum<Box<dyn Energy + 'a>>,
    bounds: Bounds,
    /// The parts of the full problem, where it has any.
    separable: Option<&'a dyn Separable>,
    group_of: Vec<usize>,
    held: &'a [bool],
    /// Rows over all unknowns, and the same over the independent ones.
    kept: RefCell<VecDeque<[LinearGaps; 2]>>,
    /// All unknowns (n, UL) of the state that converged last.
    last: &'a [f64],
    /// The slips that were asked for last, over all unknowns.
    slips: RefCell<SlipRows>,
}

impl<'a> Reduced<'a> {
    /// # Errors
    /// Constants or unknowns that are not those of the problem, bounds on dependent unknowns.
    pub fn new(
        full: &'a dyn ContactProblem,
        reduction: &'a Reduction,
        last: &'a [f64],
    ) -> Result<Self, Error> {
        let (map, constants) = (&*reduction.map, reduction.constants.as_slice());
        Error::check_vector(
            "the constants of the reduction",
            constants,
            map.dependents.len(),
        )?;
        let held = "whether groups are held";
        Error::check_length_of(held, reduction.held.len(), map.groups.len())?;
        let separable = full.separable();
        let parts = separable.map_or_else(|| vec![full.energy()], |parts| parts.bodies());
        Error::check_length_of(
            "the parts of the reduction",
            map.starts.len(),
            parts.len() + 1,
        )?;
        for (part, energy) in parts.iter().enumerate() {
            let own = map.starts[part + 1] - map.starts[part];
            Error::check_length_of("a part of the reduction", own, energy.dofs())?;
        }
        let plans = map.plans.get_or_init(|| {
            let plan = |group: &super::Group| {
                let plan = || Part::new(map, group, &parts);
                group.is_mapped.then(plan)
            };
            map.groups.iter().map(plan).collect()
        });
        let groups = map.groups.iter().zip(plans);
        let energy = |(group, plan): (&'a super::Group, &'a Option<Part>)| match plan {
            Some(plan) => {
                Box::new(GroupEnergy::new(map, (group, plan), &parts, constants)) as Box<dyn Energy>
            }
            None => Box::new(parts[group.parts[0]]),
        };
        let energy = DirectSum::new(groups.map(energy).collect());
        let mut group_of = vec![0; parts.len()];
        for (k, group) in map.groups.iter().enumerate() {
            group.parts.iter().for_each(|&part| group_of[part] = k);
        }
        Ok(Reduced {
            bounds: bounds(full.bounds(), map)?,
            full,
            map,
            constants,
            energy,
            separable,
            group_of,
            held: &reduction.held,
            kept: RefCell::new(VecDeque::new()),
            last,
            slips: RefCell::default(),
        })
    }

    pub fn restricted(&self, state: &State) -> State {
        State {
            u: self.map.restricted(&state.u),
            multipliers: state.multipliers.clone(),
        }
    }

    fn all(&self, v: &[f64]) -> Result<Vec<f64>, Error> {
        Error::check_length("u", v, self.map.independent())?;
        Ok(self.map.expanded(v, self.constants))
    }

    /// The rows over v; both are kept.
    fn reduced(&self, rows: LinearGaps) -> LinearGaps {
        let own = self.without_keeping(&rows);
        if !rows.is_empty() {
            let mut kept = self.kept.borrow_mut();
            kept.truncate(KEPT - 1);
            kept.push_front([rows, own.clone()]);
        }
        own
    }

    fn without_keeping(&self, rows: &LinearGaps) -> LinearGaps {
        let mut own = LinearGaps::new(rows.is_exact()).sampled_at(rows.sampling());
        for i in 0..rows.len() {
            let row = rows.row(i);
            let constant = row.constant + self.shift(&row.free);
            let free = self.map.row(row.free.iter().copied());
            own.push(
                rows.keys()[i],
                &Row {
                    free,
                    constant,
                    ..row
                },
            );
        }
        own
    }

    /// What the constants t add to a row with these entries.
    fn shift(&self, entries: &[(usize, f64)]) -> f64 {
        let shifts = entries.iter().map(|&(j, a)| match self.map.places[j] {
            Place::Independent(_) => 0.0,
            Place::Dependent(k) => a * self.constants[k],
        });
        shifts.sum()
    }

    /// The rows over all unknowns that `gaps` were made from, if they are still known.
    fn source(&self, gaps: &LinearGaps) -> Option<LinearGaps> {
        let kept = self.kept.borrow();
        let mut places: HashMap<(RowKey, u64), (usize, usize)> = HashMap::new();
        for (set, [_, own]) in kept.iter().enumerate() {
            for (i, (key, constant)) in own.keys().iter().zip(own.constant()).enumerate() {
                places.entry((*key, constant.to_bits())).or_insert((set, i));
            }
        }
        let mut all = LinearGaps::new(gaps.is_exact()).sampled_at(gaps.sampling());
        for (i, (key, constant)) in gaps.keys().iter().zip(gaps.constant()).enumerate() {
            let (set, k) = *places.get(&(*key, constant.to_bits()))?;
            let [full, own] = &kept[set];
            if !own.matrix().row(k).eq(gaps.matrix().row(i)) {
                return None;
            }
            all.push(*key, &full.row(k));
        }
        Some(all)
    }

    /// The solution over all unknowns. Where its rows are not known any more, it gets those at its end.
    pub fn expanded(&self, solution: Solution) -> Result<Solution, Error> {
        let u = self.all(&solution.state.u)?;
        let (gaps, lambda) = match self.source(&solution.gaps) {
            Some(gaps) => (gaps, solution.lambda),
            None => {
                let sampling = solution.gaps.sampling();
                let forward = self.full.linearize_gaps(&u, sampling)?;
                let gaps = forward.and(self.full.linearize_reversed(&u, sampling)?);
                let multipliers = &solution.state.multipliers;
                let lambda = gaps.keys().iter().map(|key| multipliers.of(*key)).collect();
                (gaps, lambda)
            }
        };
        let held = match solution.held.is_empty() {
            true => Vec::new(),
            false => self.map.spread(&solution.held),
        };
        let still = vec![0.0; self.constants.len()];
        let softest = solution.softest.as_ref();
        let softest = softest.map(|(v, k)| (self.map.expanded(v, &still), *k));
        let friction = match solution.friction {
            None => None,
            Some(own) => {
                // most often they were made from the slips that were asked for last
                let known = self.slips.borrow().clone();
                let rows = match known.keys() == own.rows.keys()
                    && self.source(&solution.gaps).is_some()
                {
                    true => known,
                    false => self.full.slips(&u, &gaps, self.last, own.from)?,
                };
                let by_key = |values: &[f64]| -> Multipliers {
                    own.rows
                        .keys()
                        .iter()
                        .copied()
                        .zip(values.iter().copied())
                        .collect()
                };
                let [thresholds, forces] = [&own.thresholds, &own.forces].map(|values| {
                    let known = by_key(values);
                    rows.keys().iter().map(|key| known.of(*key)).collect()
                });
                Some(Friction {
                    thresholds,
                    forces,
                    rows,
                    last: self.last.to_vec(),
                    ..own
                })
            }
        };
        let multipliers = solution.state.multipliers;
        let state = State { u, multipliers };
        Ok(Solution {
            friction,
            held,
            softest,
            state,
            gaps,
            lambda,
            ..solution
        })
    }
}

/// The bounds of the independent unknowns.
fn bounds(all: &Bounds, map: &LinearMap) -> Result<Bounds, Error> {
    if all.is_empty() {
        return Ok(Bounds::default());
    }
    Error::check_length("the bounds", &all.lower, map.unknowns())?;
    Error::check_length("the bounds", &all.upper, map.unknowns())?;
    let is_bounded = |i: &&usize| all.lower[**i].is_finite() || all.upper[**i].is_finite();
    match map.dependents.iter().find(is_bounded) {
        Some(unknown) => Err(Error::Untreated {
            solver: "reduction",
            what: "a bound on a dependent unknown",
            value: unknown.to_string(),
            remedy: "state it as a row of the gaps",
        }),
        None => Ok(Bounds {
            lower: map.restricted(&all.lower),
            upper: map.restricted(&all.upper),
        }),
    }
}

impl ContactProblem for Reduced<'_> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn linearize_gaps(&self, v: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        let rows = self.full.linearize_gaps(&self.all(v)?, sampling)?;
        Ok(self.reduced(rows))
    }

    fn linearize_reversed(&self, v: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        let rows = self.full.linearize_reversed(&self.all(v)?, sampling)?;
        Ok(self.reduced(rows))
    }

    fn linearize_near(&self, v: &[f64], moved: f64) -> Result<LinearGaps, Error> {
        // a sum of unknowns may exceed each of them
        let grows = self.map.largest_sum().max(1.0);
        let shift = self.constants.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        let rows = self
            .full
            .linearize_near(&self.all(v)?, grows * moved + shift)?;
        Ok(self.reduced(rows))
    }

    fn vary_gaps(
        &self,
        v: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        let source = self.source(gaps);
        let rows = source.as_ref().unwrap_or(gaps);
        let variation = self.full.vary_gaps(&self.all(v)?, rows, lambda)?;
        Ok(variation.map(|variation| variation.mapped(self.map)))
    }

    fn has_friction(&self) -> bool {
        self.full.has_friction()
    }

    fn slips(
        &self,
        v: &[f64],
        gaps: &LinearGaps,
        _last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error> {
        let source = self.source(gaps);
        let rows = source.as_ref().unwrap_or(gaps);
        // independent unknowns alone do not tell the dependent ones of another load
        let full = self.full.slips(&self.all(v)?, rows, self.last, from)?;
        let mut own = SlipRows::default();
        for (i, &key) in full.keys().iter().enumerate() {
            let row = full.row(i);
            let constant = row.constant + self.shift(&row.free);
            let free = self.map.row(row.free.iter().copied());
            let row = SlipRow {
                free,
                constant,
                ..row
            };
            own.push(key, &row);
        }
        *self.slips.borrow_mut() = full;
        Ok(own)
    }

    fn vary_slips(
        &self,
        v: &[f64],
        gaps: &LinearGaps,
        forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        let source = self.source(gaps);
        let rows = source.as_ref().unwrap_or(gaps);
        let variation = self.full.vary_slips(&self.all(v)?, rows, forces)?;
        Ok(variation.map(|variation| variation.mapped(self.map)))
    }

    fn separable(&self) -> Option<&dyn Separable> {
        self.separable.map(|_| self as &dyn Separable)
    }

    fn extent(&self) -> f64 {
        self.full.extent()
    }

    fn has_exact_gaps(&self) -> bool {
        self.full.has_exact_gaps()
    }

    fn scale(&self) -> Option<Scale> {
        self.full.scale()
    }

    fn diagnose(&self, solution: &Solution) -> Option<String> {
        let solution = self.expanded(solution.clone()).ok()?;
        self.full.diagnose(&solution)
    }

    fn prescribed_magnitude(&self) -> f64 {
        let constants = self.constants.iter();
        constants.fold(self.full.prescribed_magnitude(), |m, t| m.max(t.abs()))
    }
}

impl Separable for Reduced<'_> {
    fn bodies(&self) -> Vec<&dyn Energy> {
        let groups = self.energy.parts().iter();
        groups.map(|group| &**group as &dyn Energy).collect()
    }

    fn is_held(&self, group: usize) -> bool {
        self.held[group]
    }

    fn passes(&self) -> Vec<[usize; 2]> {
        let passes = self.separable.map_or_else(Vec::new, |full| full.passes());
        let of_groups = |bodies: [usize; 2]| bodies.map(|body| self.group_of[body]);
        passes.into_iter().map(of_groups).collect()
    }

    fn linearize_among(&self, v: &[f64], among: &[bool]) -> Result<LinearGaps, Error> {
        let Some(full) = self.separable else {
            return Ok(LinearGaps::new(true));
        };
        let among: Vec<bool> = self.group_of.iter().map(|&group| among[group]).collect();
        let rows = full.linearize_among(&self.all(v)?, &among)?;
        Ok(self.reduced(rows))
    }
}
