//! Static condensation onto the contact rows, where the problem is a convex quadratic program.
//!
//! | file | role |
//! |---|---|
//! | `stiffness` | K by blocks, factored once |
//! | `rows` | distinct rows |
//! | `compliance` | W = C M⁻¹ Cᵀ of the working set |
//! | `pruned` | W of one block |
//! | `complementarity` | 0 ≤ λ ⟂ W λ + q ≥ 0 |
//! | `coulomb` | the same with friction |
//! | `line_search` | its exact line search |
//! | `rounds` | the iteration on u and λ |
//! | `halt` | what ends a solve before its result |

pub(super) mod complementarity;
mod compliance;
pub(super) mod coulomb;
pub(super) mod halt;
mod line_search;
pub(super) mod pruned;
mod rounds;
mod rows;
mod stiffness;
#[cfg(test)]
mod tests;

use std::fmt;
use std::time::Instant;

use self::compliance::Compliance;
use self::halt::Halt;
use self::rounds::{Iterate, Rounds};
use self::rows::Rows;
use self::stiffness::Stiffness;
use super::{
    Choice, Equilibrium, Iteration, Solution, StepContext, check_unbounded, least_displacement,
    relative_change, unchanged,
};
use crate::cost::FactorSize;
use crate::friction::{Friction, SlipRows};
use crate::{
    ContactProblem, Cost, Error, LinearGaps, MemoryNeed, Multipliers, Outcome, Scale, State, Stop,
};

/// Equilibrium of bodies with quadratic energies under exact rows, by static condensation.
///
/// min ½uᵀKu − fᵀu subject to C u + c₀ ≥ 0: K is factored once, body by body; the rows that may act see the dense
/// compliance W = C K⁻¹ Cᵀ, and their multipliers solve 0 ≤ λ ⟂ W λ + q ≥ 0, with Coulomb's law where rows have friction. A body that nothing but contact holds gets
/// a small shift in a proximal iteration, so that motions which nothing determines stay the least. `docs/condensed.md`
/// derives the method.
///
/// Factors and W are kept for the next solve: a run of many load steps factors once as long as K stays the same.
/// Clones start without them.
///
/// In [`Cost`], an inner iteration is a step of Newton's method on the condensed rows, a solve is one of their problems, and
/// a factorisation is one of all blocks of K, or of all that float once more.
#[derive(Default)]
pub struct Condensed {
    kept: Option<Kept>,
    /// Memory for a Hessian.
    values: Vec<f64>,
}

/// What the next solve can use again.
struct Kept {
    stiffness: Stiffness,
    rows: Rows,
    compliance: Compliance,
}

impl Condensed {
    /// Without factors yet.
    pub fn new() -> Self {
        Condensed::default()
    }

    /// Whether a body of the last problem floats.
    fn floats(&self) -> bool {
        self.kept
            .as_ref()
            .is_some_and(|kept| kept.stiffness.floats())
    }

    /// The factors and the compliance for this problem, new where they are not the last one's.
    fn prepare(
        &mut self,
        problem: &dyn ContactProblem,
        (gaps, slips): (&LinearGaps, &SlipRows),
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<&mut Kept, Halt> {
        let energy = problem.energy();
        let mut values = std::mem::take(&mut self.values);
        values.resize(energy.hessian_pattern().len(), 0.0);
        let clock = Instant::now();
        energy.hessian(&vec![0.0; energy.dofs()], &mut values);
        cost.callbacks += clock.elapsed().as_secs_f64();
        cost.hessians += 1;
        let kept = self.kept.take();
        let kept = match kept.filter(|kept| kept.stiffness.is_of(energy, &values)) {
            Some(kept) => {
                self.values = values;
                match kept.rows.are_of(gaps, slips) {
                    true => kept,
                    false => Kept::new(kept.stiffness, problem, (gaps, slips)),
                }
            }
            None => {
                let stiffness = Stiffness::new(energy, values, stop, cost)?;
                Kept::new(stiffness, problem, (gaps, slips))
            }
        };
        cost.factor = Some(FactorSize::of_entries(kept.stiffness.fill()));
        Ok(self.kept.insert(kept))
    }
}

impl Kept {
    fn new(
        stiffness: Stiffness,
        problem: &dyn ContactProblem,
        (gaps, slips): (&LinearGaps, &SlipRows),
    ) -> Self {
        let rows = Rows::new(problem, gaps, slips);
        Kept {
            compliance: Compliance::new(stiffness.blocks().len(), rows.len()),
            stiffness,
            rows,
        }
    }
}

impl Clone for Condensed {
    fn clone(&self) -> Self {
        Condensed::new()
    }
}

impl fmt::Debug for Condensed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = self.kept.as_ref().map(|kept| kept.compliance.rows().len());
        f.debug_struct("Condensed")
            .field("condensed_rows", &rows)
            .finish()
    }
}

impl Equilibrium for Condensed {
    fn solve(
        &mut self,
        problem: &dyn ContactProblem,
        start: State,
        context: &StepContext<'_>,
    ) -> Result<Solution, Error> {
        let clock = Instant::now();
        let energy = problem.energy();
        check_start(problem, &start)?;
        let mut moved = AHEAD * largest_displacement(problem, &start.u);
        let (mut gaps, mut slips) = match near(problem, &start.u, moved, context) {
            Ok(rows) => rows,
            Err(halt) => {
                let value = energy.value(&start.u);
                return Ok(unchanged(start, value, halt.outcome()?));
            }
        };
        check_gaps(&gaps)?;
        let mut cost = Cost {
            outer_iterations: 1,
            values: 1,
            projection: clock.elapsed().as_secs_f64(),
            ..Cost::default()
        };
        let mut at = Iterate {
            u: start.u.clone(),
            lambda: Vec::new(),
        };
        let scale = Scale::of(problem, &start.u)?;
        let mut solved;
        loop {
            let parts = (problem, &gaps, &slips, &scale);
            solved = self.equilibrium(parts, moved, &start, &mut at, context, &mut cost);
            let now = match self.floats() {
                true => f64::INFINITY,
                false => largest_displacement(problem, &at.u),
            };
            // rows that were out of reach may not be any more
            if solved.is_err() || !(now > moved) {
                break;
            }
            moved = AHEAD * now;
            let projecting = Instant::now();
            match near(problem, &start.u, moved, context) {
                Ok((more, _)) if more.len() == gaps.len() && !self.floats() => break,
                Ok(more) => (gaps, slips) = more,
                Err(halt) => {
                    solved = Err(halt);
                    break;
                }
            }
            cost.projection += projecting.elapsed().as_secs_f64();
            check_gaps(&gaps)?;
        }
        let is_finite = at.u.iter().chain(&at.lambda).all(|value| value.is_finite());
        if !is_finite {
            at.u.clone_from(&start.u);
            at.lambda.clear();
        }
        let lambda = match &self.kept {
            Some(kept) if !at.lambda.is_empty() => {
                kept.rows
                    .shared(&at.lambda, gaps.constant(), TIE * scale.length)
            }
            _ => vec![0.0; gaps.len()],
        };
        let multipliers = Multipliers::new(&gaps, &lambda);
        let friction = problem.has_friction().then(|| {
            let kept = self.kept.as_ref().filter(|_| !at.lambda.is_empty());
            let force = |i: usize| kept.map_or(Some(0.0), |kept| kept.rows.friction(i, &at.lambda));
            Friction::at(slips, &multipliers, force, context)
        });
        let outcome = match solved {
            Ok(()) => Outcome::Converged,
            Err(halt) => {
                self.kept = None; // the working set may be ahead of its W
                halt.outcome()?
            }
        };
        let value = energy.value(&at.u);
        if outcome == Outcome::Converged && !value.is_finite() {
            let first = energy.value(&start.u);
            if !first.is_finite() {
                return Ok(unchanged(start, first, Outcome::InadmissibleStart));
            }
        }
        let least = least_displacement(problem, scale.length);
        let error = match outcome {
            Outcome::Converged => relative_change(&at.u, &start.u, least),
            _ => f64::INFINITY,
        };
        cost.wall = clock.elapsed().as_secs_f64();
        cost.optimizer = (cost.wall - cost.projection - cost.callbacks).max(0.0);
        let iteration = Iteration {
            solver: NAME,
            error,
            rows: gaps.len(),
            cost,
        };
        let mut history = Vec::new();
        iteration.record(&mut history);
        let solution = Solution {
            outcome,
            energy: value,
            state: State {
                multipliers,
                u: at.u,
            },
            failed: Vec::new(),
            curvature: None,
            flickering: Vec::new(),
            held: Vec::new(),
            softest: None,
            friction,
            history,
            gaps,
            lambda,
        };
        Ok(solution.checked())
    }

    fn check(&self, problem: &dyn ContactProblem) -> Result<(), Error> {
        check_energy(problem)?;
        match problem.has_exact_gaps() {
            true => Ok(()),
            false => {
                let u = vec![0.0; problem.energy().dofs()];
                check_gaps(&problem.linearize_near(&u, 0.0)?)
            }
        }
    }

    fn choice(&self, _problem: &dyn ContactProblem) -> Choice {
        Choice {
            solver: NAME,
            why: Choice::GIVEN,
        }
    }

    fn memory(&self, problem: &dyn ContactProblem) -> Option<MemoryNeed> {
        MemoryNeed::of_energy(problem.energy()).ok()
    }

    fn lifts_starts(&self, _problem: &dyn ContactProblem) -> bool {
        true
    }
}

/// The rows that displacements of at most `moved` (UL) can close, and how their nodes slip.
fn near(
    problem: &dyn ContactProblem,
    u: &[f64],
    moved: f64,
    context: &StepContext<'_>,
) -> Result<(LinearGaps, SlipRows), Halt> {
    Halt::if_requested(context.stop)?;
    let gaps = problem.linearize_near(u, moved)?;
    let slips = match problem.has_friction() {
        true => problem.slips(u, &gaps, &context.last.u, context.from)?,
        false => SlipRows::default(),
    };
    slips.check(u.len())?;
    Ok((gaps, slips))
}

/// The largest displacement at u, prescribed ones included (UL).
fn largest_displacement(problem: &dyn ContactProblem, u: &[f64]) -> f64 {
    let prescribed = problem.prescribed_magnitude();
    u.iter().fold(prescribed, |largest, u| largest.max(u.abs()))
}

/// The name in records.
const NAME: &str = "condensed";
/// Rows are asked for that displacements this much larger can close: the next ones may be larger by as much.
const AHEAD: f64 = 1.1;
/// Parallel rows share a force where their gaps differ by no more than this share of the problem's length.
const TIE: f64 = 1e-12;

impl Condensed {
    fn equilibrium(
        &mut self,
        (problem, gaps, slips, scale): (&dyn ContactProblem, &LinearGaps, &SlipRows, &Scale),
        moved: f64,
        start: &State,
        at: &mut Iterate,
        context: &StepContext<'_>,
        cost: &mut Cost,
    ) -> Result<(), Halt> {
        let (energy, stop) = (problem.energy(), context.stop);
        let kept = self.prepare(problem, (gaps, slips), stop, cost)?;
        if kept.stiffness.floats() {
            // nothing bounds its way to a row, and motions that nothing determines stay where the start has them
            if moved.is_finite() {
                return Ok(());
            }
            if !context.is_lifted {
                at.u = (context.lifted)().u;
            }
        }
        Halt::if_immovable(scale.length, gaps, kept.rows.immovable(), gaps.constant())?;
        let clock = Instant::now();
        let mut load = vec![0.0; energy.dofs()];
        energy.gradient(&vec![0.0; energy.dofs()], &mut load);
        load.iter_mut().for_each(|f| *f = -*f);
        cost.gradients += 1;
        cost.callbacks += clock.elapsed().as_secs_f64();
        let known = gaps
            .keys()
            .iter()
            .map(|&key| start.multipliers.of(key).max(0.0));
        at.lambda = kept
            .rows
            .gathered(known.map(|l| if l.is_finite() { l } else { 0.0 }));
        Rounds {
            constants: &kept.rows.all_constants(gaps.constant(), slips.constant()),
            laws: &kept.rows.laws(gaps, TIE * scale.length),
            stiffness: &mut kept.stiffness,
            compliance: &mut kept.compliance,
            rows: &kept.rows,
            resolution: scale.resolution,
            load: &load,
            stop,
            cost,
        }
        .run(at)
    }
}

/// Checks the start, and that this solver treats the energy and the bounds.
fn check_start(problem: &dyn ContactProblem, start: &State) -> Result<(), Error> {
    check_unbounded(problem, start, "Condensed")?;
    check_energy(problem)
}

/// Checks that this solver treats the energy.
fn check_energy(problem: &dyn ContactProblem) -> Result<(), Error> {
    match problem.energy().is_quadratic() {
        true => Ok(()),
        false => Err(Error::Untreated {
            solver: "Condensed",
            what: "`Energy::is_quadratic`",
            value: "false".into(),
            remedy: "give all bodies a law for small strains, or solve by `CondensedNewton`",
        }),
    }
}

/// Checks that this solver treats the rows.
fn check_gaps(gaps: &LinearGaps) -> Result<(), Error> {
    if !gaps.is_exact() {
        return Err(Error::Untreated {
            solver: "Condensed",
            what: "`LinearGaps::is_exact`",
            value: "false".into(),
            remedy: "look for contact in the reference geometry, or solve by `CondensedNewton`",
        });
    }
    Error::check_vector("the constants of the gaps", gaps.constant(), gaps.len())?;
    let mut entries = gaps.entries().map(|(_, _, a)| a).enumerate();
    match entries.find(|(_, a)| !a.is_finite()) {
        Some((index, value)) => Err(Error::NotFinite {
            what: "the coefficients of the gaps",
            index,
            value,
        }),
        None => Ok(()),
    }
}
