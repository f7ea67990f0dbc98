//! Springs to an anchor that follows: the way down where Newton's method does not end by itself, and what holds motions that
//! nothing else holds.
//!
//! Each round minimises E(u) + ½ Σ w_j (u_j − ū_j)² under the rows, with w_j = s |K_jj|/n of a body of n unknowns, and then the
//! anchor ū moves to its solution (the proximal method of R. T. Rockafellar, SIAM J. Control Optim. 14 (1976); with s that falls
//! it is pseudo-transient continuation, C. T. Kelley and D. E. Keyes, SIAM J. Numer. Anal. 35 (1998)). A motion of the curvature k contracts by
//! w/(w + k) a round. Motions that meet resistance settle, and their springs end without a force. What stays is the force on
//! motions that nothing resists, which move as far in every round as in the one before. Where that force is a small share of the contact
//! forces, the motions are held where they are, and [`Solution::held`] tells with what forces.

use std::ops::Range;

use super::super::diagonal::diagonal;
use super::super::fixed_point::max_norm;
use super::super::{Solution, StepContext, relative_change, unchanged};
use super::{CondensedNewton, least_displacement};
use crate::friction::SlipRows;
use crate::gaps::Sampling;
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{ContactProblem, Energy, Error, GapVariation, LinearGaps, Outcome, Scale, State};

/// The first stiffness s, the smallest and the largest one, and the factor between them.
const FIRST: f64 = 1e-2;
const SOFTEST: f64 = 1e-4;
const STIFFEST: f64 = 1e4;
const GROWTH: f64 = 10.0;
/// The most rounds at one load.
const ROUNDS: usize = 40;
/// The anchor moves on as far as the ratio of motions in two rounds foresees, if it is more than the first number. More than the
/// second one is a motion that nothing resists.
const SETTLES: f64 = 0.5;
const FREE: f64 = 0.95;
/// A descent ends without springs where the anchor moves by less than this share of the displacements.
const NEAR: f64 = 1e-3;
/// Motions of a body are held by no more than the first share of the contact forces on it; where the body has friction, the second.
const HELD: f64 = 2e-2;
const RUBS: f64 = 1e-6;
/// This share of all contact forces is nothing.
const NOTHING: f64 = 1e-9;

/// A problem whose unknowns have springs to an anchor.
struct Anchored<'a> {
    problem: &'a dyn ContactProblem,
    energy: Springs<'a>,
}

/// An energy and its springs.
struct Springs<'a> {
    energy: &'a dyn Energy,
    /// w (n, UF/UL).
    weights: Vec<f64>,
    /// ū (n, UL).
    anchor: Vec<f64>,
}

impl Springs<'_> {
    /// The forces of the springs (n, UF).
    fn forces(&self, u: &[f64]) -> Vec<f64> {
        let springs = self.weights.iter().zip(&self.anchor);
        springs.zip(u).map(|((w, a), u)| w * (a - u)).collect()
    }
}

impl Energy for Springs<'_> {
    fn dofs(&self) -> usize {
        self.energy.dofs()
    }
    fn value(&self, u: &[f64]) -> f64 {
        let springs = self.weights.iter().zip(&self.anchor).zip(u);
        let stored: f64 = springs.map(|((w, a), u)| 0.5 * w * (u - a).powi(2)).sum();
        self.energy.value(u) + stored
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.energy.gradient(u, g);
        let forces = self.forces(u);
        g.iter_mut().zip(&forces).for_each(|(g, f)| *g -= f);
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        self.energy.hessian_pattern()
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        self.energy.hessian(u, values);
        let pattern = self.energy.hessian_pattern();
        for (j, w) in self.weights.iter().enumerate() {
            if let Some(slot) = pattern.slot(j, j) {
                values[slot] += w;
            }
        }
    }
    fn blocks(&self) -> Vec<Range<usize>> {
        self.energy.blocks()
    }
    fn is_quadratic(&self) -> bool {
        self.energy.is_quadratic()
    }
    fn domain_len(&self) -> usize {
        self.energy.domain_len()
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        self.energy.domain(u, d);
    }
}

impl ContactProblem for Anchored<'_> {
    fn energy(&self) -> &dyn Energy {
        &self.energy
    }
    fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_gaps(u, sampling)
    }
    fn linearize_reversed(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error> {
        self.problem.linearize_reversed(u, sampling)
    }
    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.problem.vary_gaps(u, gaps, lambda)
    }
    fn has_friction(&self) -> bool {
        self.problem.has_friction()
    }
    fn slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        last: &[f64],
        from: f64,
    ) -> Result<SlipRows, Error> {
        self.problem.slips(u, gaps, last, from)
    }
    fn vary_slips(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        self.problem.vary_slips(u, gaps, forces)
    }
    fn has_exact_gaps(&self) -> bool {
        self.problem.has_exact_gaps()
    }
    fn extent(&self) -> f64 {
        self.problem.extent()
    }
    fn scale(&self) -> Option<Scale> {
        self.problem.scale()
    }
    fn prescribed_magnitude(&self) -> f64 {
        self.problem.prescribed_magnitude()
    }
}

/// |K_jj|/n at u (n, UF/UL).
fn weights(energy: &dyn Energy, u: &[f64]) -> Vec<f64> {
    let pattern = energy.hessian_pattern();
    let mut hessian = vec![0.0; pattern.len()];
    energy.hessian(u, &mut hessian);
    let diagonal = diagonal(pattern, &hessian);
    let mut weights = vec![0.0; energy.dofs()];
    for block in energy.blocks() {
        let n = block.len() as f64;
        for j in block {
            weights[j] = diagonal[j].abs() / n;
        }
    }
    weights
}

/// Whether springs may go on holding bodies by these forces: of no body they are more than a small share of the contact forces on it. A
/// body that friction could hold slides where it does not.
fn may_hold(forces: &[f64], bodies: &[Range<usize>], solution: &Solution) -> bool {
    let mut pushed = vec![0.0; forces.len()];
    solution.gaps.add_forces(&solution.lambda, &mut pushed);
    let friction = solution.friction.as_ref();
    let rubs = friction.map(|own| own.rows.capacities(&own.thresholds, forces.len()));
    let sum = |of: &[f64]| of.iter().map(|f| f.abs()).sum::<f64>();
    let all = sum(&pushed);
    bodies.iter().all(|body| {
        let held = sum(&forces[body.clone()]);
        let has_friction = rubs
            .as_ref()
            .is_some_and(|all| sum(&all[body.clone()]) > 0.0);
        let share = if has_friction { RUBS } else { HELD };
        let own = sum(&pushed[body.clone()]);
        held <= (share * own).max(NOTHING * all)
    })
}

impl CondensedNewton {
    /// Solves from `start` with springs to an anchor, at first there. Where it `descends`, from beside an unstable equilibrium, springs
    /// become softer whenever that goes well.
    pub(super) fn solve_anchored(
        &mut self,
        problem: &dyn ContactProblem,
        start: &State,
        descends: bool,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let energy = problem.energy();
        // bodies that supports hold have no motion that nothing resists
        let may_float = self.search.floats || problem.separable().is_none();
        let (base, bodies) = (weights(energy, &start.u), energy.blocks());
        let least = least_displacement(problem, Scale::of(problem, &start.u)?.length);
        let (mut stiffness, mut softest) = self.search.springs.unwrap_or((FIRST, SOFTEST));
        let mut before = f64::INFINITY;
        let mut anchor = start.clone();
        let mut last = unchanged(
            start.clone(),
            energy.value(&start.u),
            Outcome::IterationLimit,
        );
        for _ in 0..ROUNDS {
            let anchored = Anchored {
                problem,
                energy: Springs {
                    energy,
                    weights: base.iter().map(|w| stiffness * w).collect(),
                    anchor: anchor.u.clone(),
                },
            };
            self.search.weights.clone_from(&anchored.energy.weights);
            self.search.suspects = true;
            let mut history = std::mem::take(&mut last.history);
            last = self.solve_whole(&anchored, anchor.clone(), &[], context)?;
            history.append(&mut last.history);
            last.history = history;
            last.energy = energy.value(&last.state.u);
            match last.outcome {
                Outcome::Converged => {}
                Outcome::Interrupted | Outcome::InadmissibleStart => break,
                _ if stiffness * GROWTH > STIFFEST => break,
                _ => {
                    stiffness *= GROWTH;
                    softest = stiffness;
                    before = f64::INFINITY;
                    continue;
                }
            }
            let u = last.state.u.clone();
            let change = relative_change(&u, &anchor.u, least);
            if change < self.tolerance {
                self.search.springs = Some((stiffness, softest));
                if let Some(plain) = self.without_springs(problem, &mut last, context)? {
                    return Ok(plain);
                }
                // stiff springs still push where they hardly move
                let rubs = last.friction.is_some();
                if rubs && !may_hold(&anchored.energy.forces(&u), &bodies, &last) {
                    last.outcome = Outcome::IterationLimit;
                }
                return Ok(last);
            }
            let moved = max_norm(anchor.u.iter().zip(&u).map(|(a, u)| u - a));
            let ratio = moved / before;
            before = moved;
            let is_free = ratio > FREE;
            let forces = anchored.energy.forces(&u);
            if is_free && may_float && may_hold(&forces, &bodies, &last) {
                self.search.springs = Some((stiffness, softest));
                self.search.failures = usize::MAX;
                last.held = forces;
                let examined = self.kept.get(&Vec::new());
                last.softest = examined.and_then(|kept| kept.watched.clone());
                return Ok(last);
            }
            if descends && !is_free && change < NEAR {
                // at the foot of the hill, nothing but springs is in the way
                if let Some(plain) = self.without_springs(problem, &mut last, context)? {
                    return Ok(plain);
                }
            }
            let mut ahead = 0.0;
            if (is_free || descends) && stiffness > softest {
                stiffness = (stiffness / GROWTH).max(softest);
                before = f64::INFINITY;
            } else if ratio > SETTLES && !is_free {
                ahead = ratio / (1.0 - ratio);
                before = f64::INFINITY;
            }
            let moves = u.iter().zip(&anchor.u);
            let next: Vec<f64> = moves.map(|(u, a)| u + ahead * (u - a)).collect();
            anchor = last.state.clone();
            if energy.value(&next).is_finite() {
                anchor.u = next;
            }
        }
        if last.outcome == Outcome::Converged {
            last.outcome = Outcome::IterationLimit;
        }
        Ok(last)
    }

    /// Solves without springs from where they ended, since what they hold may be unstable; `None` where that does not end.
    fn without_springs(
        &mut self,
        problem: &dyn ContactProblem,
        last: &mut Solution,
        context: &StepContext<'_>,
    ) -> Result<Option<Solution>, Error> {
        self.search.weights.clear();
        self.search.suspects = true;
        let plain = self.solve_whole(problem, last.state.clone(), &[], context)?;
        last.history.extend_from_slice(&plain.history);
        Ok((plain.outcome == Outcome::Converged).then(|| Solution {
            history: std::mem::take(&mut last.history),
            ..plain
        }))
    }
}
