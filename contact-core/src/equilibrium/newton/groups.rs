//! Bodies on which no common row acts, as problems of their own.
//!
//! Rows that act at the start join bodies to groups. Each group is solved from the start as if the others were not there.
//! Then the rows between groups are looked at, as they are at the end and as the start foresees them: where one overlaps,
//! its groups are joined and solved again from the start. What is found is an equilibrium of the whole, and no row was open
//! by assumption.

use std::collections::BTreeMap;
use std::ops::Range;

use super::super::condensed::halt::Halt;
use super::super::{Iteration, Solution, StepContext, rows_of_both_roles, unchanged};
use super::{CLOSED, CondensedNewton, NAME};
use crate::gaps::Sampling;
use crate::{
    Bounds, ContactProblem, Cost, DirectSum, Energy, Error, GapVariation, LinearGaps, Multipliers,
    Outcome, Scale, Separable, State,
};

/// Rows that are open by less than this share of the problem's length join bodies from the start.
const TOUCHES: f64 = 1e-9;
/// Groups are joined at most so often; then all bodies are solved as one.
const ROUNDS: usize = 3;

/// The groups that bodies form.
struct Groups {
    /// The bodies with unknowns.
    movable: Vec<bool>,
    /// The first body of the group of each body.
    first: Vec<usize>,
    passes: Vec<[usize; 2]>,
}

impl Groups {
    /// Every body by itself.
    fn new(bodies: &dyn Separable) -> Self {
        let movable = bodies.bodies().into_iter().map(|body| body.dofs() > 0);
        let movable: Vec<bool> = movable.collect();
        Groups {
            first: (0..movable.len()).collect(),
            movable,
            passes: bodies.passes(),
        }
    }

    /// The two bodies of a row, if they are in different groups.
    fn apart(&self, gaps: &LinearGaps, row: usize) -> Option<[usize; 2]> {
        let bodies = *self.passes.get(gaps.keys()[row].pass as usize)?;
        let [a, b] = bodies;
        (self.movable[a] && self.movable[b] && self.first[a] != self.first[b]).then_some(bodies)
    }

    /// Joins the groups of all rows that `acts`. Whether there was any.
    fn join(&mut self, gaps: &LinearGaps, acts: impl Fn(usize) -> bool) -> bool {
        let mut has_joined = false;
        for row in (0..gaps.len()).filter(|&row| acts(row)) {
            if let Some([a, b]) = self.apart(gaps, row) {
                let (kept, other) = (self.first[a], self.first[b]);
                let (kept, other) = (kept.min(other), kept.max(other));
                let of_other = self.first.iter_mut().filter(|first| **first == other);
                of_other.for_each(|first| *first = kept);
                has_joined = true;
            }
        }
        has_joined
    }

    /// The bodies of each group, those without unknowns left out.
    fn all(&self) -> Vec<Vec<usize>> {
        let mut groups = BTreeMap::<usize, Vec<usize>>::new();
        for (body, first) in self.first.iter().enumerate() {
            if self.movable[body] {
                groups.entry(*first).or_default().push(body);
            }
        }
        groups.into_values().collect()
    }
}

/// A group of bodies, where all others stay where they are.
struct Group<'a> {
    problem: &'a dyn ContactProblem,
    bodies: &'a dyn Separable,
    energy: DirectSum<&'a dyn Energy>,
    bounds: Bounds,
    /// For each body, whether it is in the group or cannot move.
    among: Vec<bool>,
    /// Whether a pass is between them.
    has_passes: bool,
    /// The unknowns of each body of the group, in the whole.
    ranges: Vec<Range<usize>>,
    /// The unknowns of the whole at the start.
    start: &'a [f64],
}

impl<'a> Group<'a> {
    fn new(
        problem: &'a dyn ContactProblem,
        bodies: &'a dyn Separable,
        (groups, members): (&Groups, &[usize]),
        start: &'a [f64],
    ) -> Self {
        let energies = bodies.bodies();
        let mut among: Vec<bool> = groups.movable.iter().map(|movable| !movable).collect();
        members.iter().for_each(|&body| among[body] = true);
        let mut first = vec![0];
        first.extend(energies.iter().scan(0, |sum, body| {
            *sum += body.dofs();
            Some(*sum)
        }));
        let is_own = |[a, b]: &[usize; 2]| {
            let moves = groups.movable[*a] || groups.movable[*b];
            moves && among[*a] && among[*b]
        };
        Group {
            has_passes: groups.passes.iter().any(is_own),
            ranges: members.iter().map(|&b| first[b]..first[b + 1]).collect(),
            energy: DirectSum::new(members.iter().map(|&b| energies[b]).collect()),
            problem,
            bodies,
            bounds: Bounds::default(),
            among,
            start,
        }
    }

    /// The unknowns of the group among those of the whole.
    fn own(&self, whole: &[f64]) -> Vec<f64> {
        let ranges = self.ranges.iter();
        ranges
            .flat_map(|range| &whole[range.clone()])
            .copied()
            .collect()
    }

    /// Puts the unknowns of the group into those of the whole.
    fn put(&self, own: &[f64], whole: &mut [f64]) {
        let mut next = 0;
        for range in &self.ranges {
            whole[range.clone()].copy_from_slice(&own[next..next + range.len()]);
            next += range.len();
        }
    }

    /// The place in the group of an unknown of the whole.
    fn place(&self, unknown: usize) -> Option<usize> {
        let k = self.ranges.partition_point(|range| range.end <= unknown);
        let range = self.ranges.get(k).filter(|range| range.start <= unknown)?;
        Some(self.energy.range(k).start + unknown - range.start)
    }

    fn in_whole(&self, own: &[f64]) -> Vec<f64> {
        let mut whole = self.start.to_vec();
        self.put(own, &mut whole);
        whole
    }

    /// The solution at `start` of a group that nothing moves: no force is on it, and no row acts.
    fn at_rest(&self, start: &State) -> Result<Option<Solution>, Error> {
        let mut forces = vec![0.0; start.u.len()];
        self.energy.gradient(&start.u, &mut forces);
        if forces.iter().any(|force| *force != 0.0) {
            return Ok(None);
        }
        let gaps = self.linearize_gaps(&start.u, Sampling::Nodes)?;
        let mut c = vec![0.0; gaps.len()];
        gaps.value(&start.u, &mut c);
        let acts = |i: usize| c[i] < 0.0 || start.multipliers.of(gaps.keys()[i]) > 0.0;
        if (0..gaps.len()).any(acts) {
            return Ok(None);
        }
        let energy = self.energy.value(&start.u);
        let cost = Cost {
            outer_iterations: 1,
            values: 1,
            gradients: 1,
            ..Cost::default()
        };
        Ok(Some(Solution {
            history: vec![Iteration {
                solver: NAME,
                error: 0.0,
                rows: gaps.len(),
                cost,
            }],
            lambda: vec![0.0; gaps.len()],
            gaps,
            ..unchanged(start.clone(), energy, Outcome::Converged)
        }))
    }
}

impl ContactProblem for Group<'_> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn linearize_gaps(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        if !self.has_passes {
            return Ok(LinearGaps::new(true));
        }
        let gaps = self
            .bodies
            .linearize_among(&self.in_whole(u), &self.among)?;
        Ok(gaps.renumbered(|unknown| self.place(unknown)))
    }

    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        if !self.has_passes {
            return Ok(None);
        }
        let varied = self.problem.vary_gaps(&self.in_whole(u), gaps, lambda)?;
        Ok(varied.map(|varied| varied.renumbered(|unknown| self.place(unknown))))
    }

    fn has_exact_gaps(&self) -> bool {
        self.problem.has_exact_gaps()
    }

    fn scale(&self) -> Option<Scale> {
        self.problem.scale()
    }

    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}

/// How the search by groups went.
pub(super) enum Found {
    /// It ended.
    Solution(Box<Solution>),
    /// All bodies must be solved as one, after these iterations.
    Whole(Vec<Iteration>),
}

impl CondensedNewton {
    /// Solves group by group, where there is more than one.
    pub(super) fn solve_by_groups(
        &mut self,
        problem: &dyn ContactProblem,
        bodies: &dyn Separable,
        start: &State,
        context: &StepContext<'_>,
    ) -> Result<Found, Error> {
        let mut groups = Groups::new(bodies);
        if groups.all().len() < 2 {
            return Ok(Found::Whole(Vec::new()));
        }
        let halted = |halt: Halt| -> Result<Found, Error> {
            let energy = problem.energy().value(&start.u);
            let outcome = halt.outcome()?;
            Ok(Found::Solution(Box::new(unchanged(
                start.clone(),
                energy,
                outcome,
            ))))
        };
        let first = match rows_of_both_roles(problem, &start.u, context.stop) {
            Ok(rows) => rows,
            Err(halt) => return halted(halt),
        };
        let scale = Scale::of(problem, &start.u)?;
        let mut c = vec![0.0; first.len()];
        first.value(&start.u, &mut c);
        let held: Vec<bool> = (0..groups.movable.len())
            .map(|b| bodies.is_held(b))
            .collect();
        let passes = groups.passes.clone();
        groups.join(&first, |row| {
            let key = first.keys()[row];
            let needs = passes.get(key.pass as usize);
            let needs = needs.is_none_or(|bodies| bodies.iter().any(|&body| !held[body]));
            needs || c[row] <= TOUCHES * scale.length || start.multipliers.of(key) > 0.0
        });
        let mut history = Vec::new();
        let mut solved = BTreeMap::<Vec<usize>, Solution>::new();
        for _ in 0..ROUNDS {
            let all = groups.all();
            if all.len() < 2 {
                break;
            }
            solved.retain(|members, _| all.contains(members));
            let mut iterations = Vec::new();
            for members in &all {
                if solved.contains_key(members) {
                    continue;
                }
                let group = Group::new(problem, bodies, (&groups, members), &start.u);
                let own = State {
                    u: group.own(&start.u),
                    multipliers: start.multipliers.clone(),
                };
                let mut solution = match group.at_rest(&own)? {
                    Some(solution) => solution,
                    None => self.solve_whole(&group, own, members, context)?,
                };
                add_side_by_side(&mut iterations, std::mem::take(&mut solution.history));
                match solution.outcome {
                    Outcome::Converged => solved.insert(members.clone(), solution),
                    Outcome::Interrupted => {
                        history.extend(iterations);
                        let energy = problem.energy().value(&start.u);
                        return Ok(Found::Solution(Box::new(Solution {
                            history,
                            ..unchanged(start.clone(), energy, Outcome::Interrupted)
                        })));
                    }
                    _ => {
                        history.extend(iterations);
                        return Ok(Found::Whole(history));
                    }
                };
            }
            history.extend(iterations);
            let mut u = start.u.clone();
            for (members, solution) in &solved {
                let group = Group::new(problem, bodies, (&groups, members), &start.u);
                group.put(&solution.state.u, &mut u);
            }
            let gaps = match rows_of_both_roles(problem, &u, context.stop) {
                Ok(rows) => rows,
                Err(halt) => return halted(halt),
            };
            let least = super::least_displacement(problem, scale.length);
            let size = u.iter().fold(least, |size, u| size.max(u.abs()));
            let bound = CLOSED * size;
            let mut has_joined = false;
            for rows in [&first, &gaps] {
                let mut c = vec![0.0; rows.len()];
                rows.value(&u, &mut c);
                has_joined |= groups.join(rows, |row| c[row] < -bound);
            }
            if !has_joined {
                self.kept.retain(|members, _| all.contains(members));
                let solution = joined(problem, u, gaps, &groups, solved, history);
                return Ok(Found::Solution(Box::new(solution)));
            }
        }
        Ok(Found::Whole(history))
    }
}

/// The solution of the whole at `u`, whose rows are `gaps`, from those of its groups.
fn joined(
    problem: &dyn ContactProblem,
    u: Vec<f64>,
    gaps: LinearGaps,
    groups: &Groups,
    solved: BTreeMap<Vec<usize>, Solution>,
    history: Vec<Iteration>,
) -> Solution {
    let by_first: BTreeMap<usize, &Solution> = solved
        .iter()
        .map(|(members, solution)| (groups.first[members[0]], solution))
        .collect();
    let multiplier = |row: usize| {
        let key = gaps.keys()[row];
        let [a, b] = groups.passes[key.pass as usize];
        let mut bodies = [a, b].into_iter().filter(|&body| groups.movable[body]);
        let of = bodies.find_map(|body| by_first.get(&groups.first[body]));
        match groups.apart(&gaps, row) {
            None => of.map_or(0.0, |solution| solution.state.multipliers.of(key).max(0.0)),
            Some(_) => 0.0,
        }
    };
    let lambda: Vec<f64> = (0..gaps.len()).map(multiplier).collect();
    let curvatures = solved.values().filter_map(|solution| solution.curvature);
    Solution {
        curvature: curvatures.reduce(f64::min),
        energy: problem.energy().value(&u),
        state: State {
            multipliers: Multipliers::new(&gaps, &lambda),
            u,
        },
        history,
        outcome: Outcome::Converged,
        gaps,
        lambda,
        failed: Vec::new(),
        flickering: Vec::new(),
        held: Vec::new(),
        softest: None,
        friction: None,
    }
}

/// Adds the iterations of one more group: those with the same number count as one of all groups, and so do their
/// factorisations.
fn add_side_by_side(all: &mut Vec<Iteration>, more: Vec<Iteration>) {
    for (k, iteration) in more.into_iter().enumerate() {
        match all.get_mut(k) {
            Some(known) => {
                known.error = known.error.max(iteration.error);
                known.rows += iteration.rows;
                let factorizations = known.cost.factorizations.max(iteration.cost.factorizations);
                known.cost += iteration.cost;
                known.cost.outer_iterations = 1;
                known.cost.factorizations = factorizations;
            }
            None => all.push(iteration),
        }
    }
}
