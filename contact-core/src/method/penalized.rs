//! The common part of methods (37) and (39): min E(u) + μ Σ w_i η(s_i) subject to C u + c₀ − s = 0.
//!
//! The slacks s are unknowns in (39), too, where they could be eliminated. The Hessian then keeps the
//! sparsity of that of E, wherever points are projected, and the Newton steps are the same.

use std::ops::ControlFlow;
use std::time::Instant;

use super::scaled::{Scaled, attainable, check_memory, check_tolerance, settings};
use super::{Continuation, Minimum, Subproblem, check_bounds};
use crate::ipopt::{Options, Run, Sequence, SequenceSettings, doctor};
use crate::nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure};
use crate::{Cost, Energy, Error, Scale, Solved, State};

/// η of (38) with its first and second derivative: 0, −x³, and 3x² + 3x + 1 below −1; convex and
/// twice continuously differentiable.
pub fn eta(x: f64) -> [f64; 3] {
    if x >= 0.0 {
        [0.0; 3]
    } else if x >= -1.0 {
        [-x * x * x, -3.0 * x * x, -6.0 * x]
    } else {
        [3.0 * x * x + 3.0 * x + 1.0, 6.0 * x + 3.0, 6.0]
    }
}

/// The slack in balance with `force` ≥ 0, where η'(s) = −`force`.
fn slack(force: f64) -> f64 {
    if force <= 3.0 {
        -(force / 3.0).sqrt()
    } else {
        -(force + 3.0) / 6.0
    }
}

/// The secant slope of η' between the slack `s` and the slack in balance with `force`.
///
/// Used in place of η'', it makes Newton's method primal–dual. With η'' a slack that is too negative
/// halves in each iteration, and one that is about to close meets no resistance. Where slack and
/// force are in balance, the secant slope equals η''.
fn secant(s: f64, force: f64) -> f64 {
    let balanced = slack(force.max(0.0));
    let apart = s - balanced;
    if apart.abs() <= 1e-8 * balanced.abs() {
        return eta(balanced)[2];
    }
    (eta(s)[1] - eta(balanced)[1]) / apart
}

/// The common settings of methods (37) and (39).
#[derive(Clone, Debug)]
pub struct Penalization {
    /// How μ grows.
    pub continuation: Continuation,
    /// Ipopt's `tol`, relative to the scales.
    pub tolerance: f64,
    /// The iteration limit of a solve.
    pub max_iterations: usize,
    /// Further options for Ipopt by name; they override all settings above.
    pub options: Options,
    /// μ at the last solution, with which a warm start continues.
    reached: f64,
    /// The Hessian's pattern in the last solve.
    hessian: Lift,
}

/// The pattern of ∇²E with a diagonal entry for each slack. It is kept as long as ∇²E has the same pattern and there are as many
/// slacks.
#[derive(Clone, Debug, Default)]
struct Lift {
    energy: Pattern,
    lifted: Pattern,
}

impl Lift {
    fn with_slacks(&mut self, energy: &dyn Energy, m: usize) -> Pattern {
        let (n, of_energy) = (energy.dofs(), energy.hessian_pattern().entries());
        if self.lifted.len() != of_energy.len() + m || self.energy != *of_energy {
            let slacks = (n..n + m).map(|k| (k, k));
            self.lifted = of_energy.iter().chain(slacks).collect();
            self.energy = of_energy.clone();
        }
        self.lifted.clone()
    }
}

impl Default for Penalization {
    fn default() -> Self {
        Penalization {
            continuation: Continuation::default(),
            tolerance: 1e-12,
            max_iterations: 300,
            options: Options::new(),
            reached: 0.0,
            hessian: Lift::default(),
        }
    }
}

/// A subproblem with penalised slacks.
pub(super) struct Penalized<'a> {
    pub subproblem: &'a Subproblem<'a>,
    /// w_i, one per row.
    pub weights: Vec<f64>,
    /// ε in units of [`Scale::length`](crate::Scale); infinite for no bound.
    pub slack_bound: f64,
    /// How far an unknown may move within one solve (UL).
    pub move_limit: Option<f64>,
}

impl Penalization {
    /// The factor by which an active move limit grows. Displacements of slender bodies are many times the scene's
    /// length scale.
    const WIDER: f64 = 10.0;
    /// How often a move limit may grow before the subproblem counts as not solved.
    const MOVES: usize = 30;
    /// A bound counts as active from this share of it on.
    const AT_BOUND: f64 = 0.999;

    /// Checks the settings, and the linear solver of the options.
    pub(super) fn validate(&self) -> Result<(), Error> {
        self.check_numbers()?;
        Ok(doctor::check_linear_solver(&self.options)?)
    }

    fn check_numbers(&self) -> Result<(), Error> {
        self.continuation.validate()?;
        check_tolerance("tolerance", self.tolerance)
    }

    /// Solves for increasing μ, beginning with the μ of the last solution if `start` has multipliers.
    pub(super) fn minimize(
        &mut self,
        problem: &Penalized<'_>,
        start: &State,
    ) -> Result<Minimum, Error> {
        self.check_numbers()?;
        let Continuation {
            start: first,
            limit,
            ..
        } = self.continuation;
        let resumed = match start.multipliers.is_empty() {
            true => first,
            false => self.reached.clamp(first, limit),
        };
        let mut minimum = self.from(resumed, problem, start)?;
        if resumed > first && matches!(minimum.solved, Solved::Failed(_)) {
            let spent = minimum.cost;
            minimum = self.from(first, problem, start)?;
            minimum.cost += spent;
        }
        Ok(minimum)
    }

    /// The continuation, beginning with `mu`.
    fn from(&mut self, mu: f64, problem: &Penalized<'_>, start: &State) -> Result<Minimum, Error> {
        let clock = Instant::now();
        let scale = problem.subproblem.scale;
        let mut lifted = Lifted {
            scaled: Scaled::new(problem.subproblem),
            weights: &problem.weights,
            mu,
        };
        let n = lifted.scaled.dofs();
        let mut limit = problem.move_limit.map(|limit| limit / scale.length);
        let (mut x, multipliers) = lifted.start(start, problem.slack_bound);
        let hessian = self
            .hessian
            .with_slacks(problem.subproblem.energy, x.len() - n);
        let structure = problem.structure(problem.bounds(&x, limit), hessian)?;
        let mut sequence = Sequence::new(structure, self.settings(&scale), &x)?;
        sequence.restart(&x, multipliers)?;
        let mut moves = 0;
        let (run, failed) = loop {
            let run = sequence.solve(&mut lifted)?;
            check_memory(&run, problem.subproblem.energy)?;
            if !run.solved {
                break (run, None);
            }
            let steps = run.solution.x.iter().zip(&x).take(n);
            let step = steps.fold(0.0, |step: f64, (a, b)| step.max((a - b).abs()));
            x.clone_from(&run.solution.x);
            if limit.is_some_and(|limit| step > Self::AT_BOUND * limit) {
                if moves == Self::MOVES {
                    break (
                        run,
                        Some(format!(
                            "move limit still active after {moves} enlargements"
                        )),
                    );
                }
                moves += 1;
                limit = limit.map(|limit| Self::WIDER * limit);
                let rows = Bounds::zero(problem.weights.len());
                sequence.set_bounds(problem.bounds(&x, limit), rows)?;
                continue;
            }
            let depth = x[n..].iter().fold(0.0, |depth: f64, s| depth.max(-s));
            let is_through = depth > Self::AT_BOUND * problem.slack_bound;
            if depth <= self.continuation.allowed(&scale) && !is_through {
                self.reached = lifted.mu;
                break (run, None);
            }
            if lifted.mu >= self.continuation.limit {
                let depth = depth * scale.length;
                break (run, Some(format!("penetration {depth:.2e} at the last μ")));
            }
            lifted.mu = (lifted.mu * self.continuation.growth).min(self.continuation.limit);
            if let Some(multipliers) = &run.solution.multipliers {
                lifted.push_back(multipliers, &mut x);
                sequence.restart(&x, Some(multipliers.clone()))?;
            }
        };
        let wall = clock.elapsed().as_secs_f64();
        let cost = lifted.scaled.cost(sequence.totals(), &run, wall);
        let mut minimum = lifted.minimum(run, cost);
        if let Some(why) = failed {
            minimum.solved = Solved::Failed(why);
        }
        Ok(minimum)
    }

    fn settings(&self, scale: &Scale) -> SequenceSettings {
        let tolerance = attainable(self.tolerance, scale);
        let warm = Options::new().with("max_iter", self.max_iterations);
        settings(
            tolerance,
            tolerance,
            self.max_iterations,
            warm,
            &self.options,
        )
    }
}

impl Penalized<'_> {
    /// Bounds on (u, s)/L: those of the subproblem within the move limit around `x`, and s ≥ −ε.
    fn bounds(&self, x: &[f64], limit: Option<f64>) -> Bounds {
        let subproblem = self.subproblem;
        let n = subproblem.energy.dofs();
        let mut bounds = Bounds::uniform(x.len(), -self.slack_bound, f64::INFINITY);
        let limit = limit.unwrap_or(f64::INFINITY);
        let unknowns = bounds.lower.iter_mut().zip(&mut bounds.upper).zip(x);
        for ((lower, upper), x) in unknowns.take(n) {
            (*lower, *upper) = (x - limit, x + limit);
        }
        let given = subproblem.bounds.lower.iter().zip(&subproblem.bounds.upper);
        let unknowns = bounds.lower.iter_mut().zip(&mut bounds.upper);
        for ((lower, upper), given) in unknowns.zip(given) {
            let [least, most] = [given.0, given.1].map(|bound| bound / subproblem.scale.length);
            (*lower, *upper) = (lower.max(least).min(most), upper.min(most).max(least));
        }
        bounds
    }

    /// The variables (u, s)/L within `bounds`, and the equalities C u + c₀ − s = 0.
    fn structure(&self, bounds: Bounds, hessian: Pattern) -> Result<Structure, Error> {
        let Subproblem { energy, gaps, .. } = *self.subproblem;
        let (n, m) = (energy.dofs(), gaps.len());
        check_bounds(self.subproblem.bounds, n)?;
        let of_u = gaps.entries().map(|(i, j, _)| (i, j));
        let jacobian = of_u.chain((0..m).map(|i| (i, n + i))).collect();
        let structure = Structure::new(bounds, Bounds::zero(m), jacobian, Some(hessian))?;
        Ok(structure.with_constant_jacobian(true))
    }
}

/// The scaled subproblem for one μ: x = (u, s)/L and f = E/E₀ + μ Σ w η(s).
struct Lifted<'a> {
    scaled: Scaled<'a>,
    weights: &'a [f64],
    mu: f64,
}

impl Lifted<'_> {
    /// The start x and its multipliers. The slacks are the gaps at u, at least −ε; in a warm start
    /// those with a contact force are in balance with it.
    fn start(&mut self, state: &State, slack_bound: f64) -> (Vec<f64>, Option<Multipliers>) {
        let mut x = self.scaled.displacements(state);
        let mut slacks = vec![0.0; self.weights.len()];
        self.scaled.constraints(&x, &mut slacks);
        x.extend(slacks.iter().map(|s| s.max(-slack_bound)));
        let warm = !state.multipliers.is_empty();
        let forces = warm.then(|| self.scaled.multipliers(state, x.len()));
        if let Some(forces) = &forces {
            self.push_back(forces, &mut x);
        }
        (x, forces)
    }

    /// The slacks in x and their weights.
    fn slacks<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        let slacks = x[self.scaled.dofs()..].iter().copied();
        slacks.zip(self.weights.iter().copied())
    }

    /// Sets each slack with a contact force to the value whose penalty is in balance with that force.
    /// The equalities are linear: one Newton step then adapts the displacements.
    fn push_back(&self, forces: &Multipliers, x: &mut [f64]) {
        let slacks = x[self.scaled.dofs()..].iter_mut().zip(self.weights);
        for ((s, w), multiplier) in slacks.zip(&forces.constraints) {
            if *multiplier < 0.0 {
                *s = slack(-multiplier / (self.mu * w));
            }
        }
    }

    /// The result in the user's units, with E without the penalty.
    fn minimum(&self, mut run: Run, cost: Cost) -> Minimum {
        run.solution.objective -= self.penalty(&run.solution.x);
        self.scaled.minimum(run, cost)
    }

    /// μ Σ w η(s).
    fn penalty(&self, x: &[f64]) -> f64 {
        let penalties = self.slacks(x).map(|(s, w)| w * eta(s)[0]);
        self.mu * penalties.sum::<f64>()
    }

    /// The derivatives of the penalty by each slack.
    fn slopes(&self, x: &[f64], slopes: &mut [f64]) {
        for (slope, (s, w)) in slopes.iter_mut().zip(self.slacks(x)) {
            *slope = self.mu * w * eta(s)[1];
        }
    }

    /// The second derivatives of the penalty by each slack, times the objective factor `share`, with
    /// [`secant`] in place of η''; the force of a slack is its multiplier.
    fn curvatures(&self, x: &[f64], share: f64, multipliers: &[f64], curvatures: &mut [f64]) {
        let all = curvatures.iter_mut().zip(self.slacks(x)).zip(multipliers);
        for ((curvature, (s, w)), multiplier) in all {
            let stiffness = share * self.mu * w;
            *curvature = match stiffness > 0.0 {
                true => stiffness * secant(s, -multiplier / stiffness),
                false => 0.0,
            };
        }
    }
}

impl Nlp for Lifted<'_> {
    fn begin(&mut self, x: &[f64]) {
        self.scaled.begin(x);
    }

    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        self.scaled.value(x) + self.penalty(x)
    }

    fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        let (of_u, of_s) = gradient.split_at_mut(self.scaled.dofs());
        self.scaled.gradient(x, of_u);
        self.slopes(x, of_s);
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        self.scaled.constraints(x, g);
        let all = g.iter_mut().zip(self.slacks(x));
        all.for_each(|(g, (s, _))| *g -= s);
    }

    fn jacobian(&mut self, _x: &[f64], _new_x: bool, values: &mut [f64]) {
        let (of_u, of_s) = values.split_at_mut(values.len() - self.weights.len());
        self.scaled.jacobian(of_u);
        of_s.fill(-1.0);
    }

    fn hessian(
        &mut self,
        x: &[f64],
        _new_x: bool,
        objective_factor: f64,
        multipliers: &[f64],
        values: &mut [f64],
    ) {
        let (of_u, of_s) = values.split_at_mut(values.len() - self.weights.len());
        self.scaled.hessian(x, objective_factor, of_u);
        self.curvatures(x, objective_factor, multipliers, of_s);
    }

    fn is_to_stop(&mut self) -> bool {
        self.scaled.is_to_stop()
    }

    fn may_factorize(&mut self) -> bool {
        self.scaled.may_factorize()
    }

    fn iterate(&mut self, _iterate: &Iterate<'_>) -> ControlFlow<()> {
        self.scaled.flow()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pieces of (38) meet with two derivatives, which are those of differences.
    #[test]
    fn eta_is_smooth_and_convex() {
        for at in [0.0, -1.0] {
            for k in 0..3 {
                let [left, right] = [-1e-9, 1e-9].map(|h| eta(at + h)[k]);
                assert!((left - right).abs() < 2e-8, "derivative {k} at {at}");
            }
        }
        let h = 1e-6;
        for k in -300..100 {
            let x = 0.01 * f64::from(k) + 0.005;
            let [value, slope, curvature] = eta(x);
            assert!(curvature >= 0.0 && (value > 0.0) == (x < 0.0));
            let difference = (eta(x + h)[0] - eta(x - h)[0]) / (2.0 * h);
            assert!((difference - slope).abs() < 1e-8, "η' at {x}");
            let difference = (eta(x + h)[1] - eta(x - h)[1]) / (2.0 * h);
            assert!((difference - curvature).abs() < 1e-8, "η'' at {x}");
        }
    }

    /// From anywhere one step with the secant leads to the slack whose force was foretold; in
    /// balance the secant is η''.
    #[test]
    fn secants_lead_to_balance() {
        for force in [0.0, 1e-12, 0.3, 3.0, 40.0] {
            let balanced = slack(force);
            assert!((eta(balanced)[1] + force).abs() < 1e-14 * (1.0 + force));
            for s in [-30.0, -2.0, -1.0, -0.3, -1e-9, 0.7, 20.0] {
                let curvature = secant(s, force);
                assert!(curvature >= 0.0, "convex");
                let step = eta(s)[1] + force;
                assert!((step - curvature * (s - balanced)).abs() < 1e-12 * (1.0 + step.abs()));
            }
            for s in [balanced, balanced * (1.0 + 1e-9)] {
                assert!((secant(s, force) - eta(s)[2]).abs() <= 1e-8 * eta(s)[2]);
            }
        }
        assert_eq!(secant(-0.5, -1.0), secant(-0.5, 0.0), "nothing pulls");
    }

    /// An energy that is nothing but a pattern.
    struct Entries(crate::linear::SymmetricPattern);

    impl Energy for Entries {
        fn dofs(&self) -> usize {
            3
        }
        fn value(&self, _: &[f64]) -> f64 {
            0.0
        }
        fn gradient(&self, _: &[f64], _: &mut [f64]) {}
        fn hessian_pattern(&self) -> &crate::linear::SymmetricPattern {
            &self.0
        }
        fn hessian(&self, _: &[f64], _: &mut [f64]) {}
    }

    /// The pattern is that of the energy at hand and of as many slacks as there are, also if another one
    /// has as many entries.
    #[test]
    fn patterns_are_those_of_the_energy_and_its_slacks() {
        let mut lift = Lift::default();
        let other = [(1, 0), (2, 1), (2, 0)];
        for (k, slacks) in [(0, 2), (0, 2), (1, 2), (2, 1), (2, 3)] {
            let mut entries = vec![(0, 0), (1, 1), (2, 2), other[k]];
            let (pattern, _) =
                crate::linear::SymmetricPattern::from_entries(3, &entries).expect("valid");
            let found = lift.with_slacks(&Entries(pattern), slacks);
            let mut found: Vec<_> = found.iter().collect();
            entries.extend((3..3 + slacks).map(|k| (k, k)));
            entries.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, entries);
        }
    }
}
