//! What methods (37) and (39) share: min E(u) + μ Σ w_i η(s_i) subject to C u + c₀ − s = 0.
//!
//! The slacks s are unknowns of their own also in (39), where they could be eliminated: the
//! Hessian then stays as sparse as that of E, whatever the points that are projected on, and
//! Newton's steps are the same.

use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::scaled::ScaledEnergy;
use super::{Continuation, Minimum, Solved, Subproblem};
use crate::ipopt::{Options, Run, Sequence, SequenceSettings};
use crate::nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure};
use crate::{Error, LinearGaps, State};

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

/// Where the slope of η is −`force` ≥ −∞: the slack that pushes back with it.
fn slack(force: f64) -> f64 {
    if force <= 3.0 {
        -(force / 3.0).sqrt()
    } else {
        -(force + 3.0) / 6.0
    }
}

/// The slope of η' between the slack `s` and the one that pushes back with `force`.
///
/// In place of η'' it makes Newton's method primal-dual: with η'' alone a slack too deep comes back
/// by half in each iteration and one that is about to touch meets nothing. Once slack and force are
/// in balance the two are the same.
fn secant(s: f64, force: f64) -> f64 {
    let balanced = slack(force.max(0.0));
    let apart = s - balanced;
    if apart.abs() <= 1e-8 * balanced.abs() {
        return eta(balanced)[2];
    }
    (eta(s)[1] - eta(balanced)[1]) / apart
}

/// How a penalised subproblem is to be solved.
pub(super) struct Penalized<'a> {
    /// w_i, one a row.
    pub weights: Vec<f64>,
    /// ε over [`Scale::length`](crate::Scale), infinite for none.
    pub slack_bound: f64,
    /// How far an unknown may move within one solve (UL).
    pub move_limit: Option<f64>,
    pub continuation: Continuation,
    pub tolerance: f64,
    pub max_iterations: usize,
    pub options: &'a Options,
    pub stop: Option<&'a AtomicBool>,
}

impl Penalized<'_> {
    /// A solve that cannot make progress any more counts as solved up to this many tolerances.
    const ATTAINABLE: f64 = 100.0;
    /// Tolerances closer to round-off than this are not asked for.
    const ABOVE_ROUNDOFF: f64 = 10.0;
    /// By how much a move limit that holds something back grows, and how often it may: displacements
    /// of slender bodies are many times what the scene's scale tells.
    const WIDER: f64 = 10.0;
    const MOVES: usize = 30;
    /// This share of a bound counts as being there.
    const AT_BOUND: f64 = 0.999;

    /// Solves for μ after μ, from where the last subproblem left off if `start` has multipliers.
    pub fn minimize(
        &self,
        subproblem: &Subproblem<'_>,
        start: &State,
        reached: &mut f64,
    ) -> Result<Minimum, Error> {
        self.continuation.validate()?;
        let Continuation { start: first, .. } = self.continuation;
        let warm = !start.multipliers.is_empty();
        let resumed = if warm { first.max(*reached) } else { first };
        let mut minimum = self.from(resumed, subproblem, start, reached)?;
        if resumed > first && matches!(minimum.solved, Solved::Failed(_)) {
            let spent = minimum.effort;
            minimum = self.from(first, subproblem, start, reached)?;
            minimum.effort += spent;
        }
        Ok(minimum)
    }

    /// The continuation from μ on.
    fn from(
        &self,
        mu: f64,
        subproblem: &Subproblem<'_>,
        start: &State,
        reached: &mut f64,
    ) -> Result<Minimum, Error> {
        let clock = Instant::now();
        let scale = subproblem.scale;
        let mut lifted = Lifted {
            energy: ScaledEnergy::new(subproblem, self.stop),
            gaps: subproblem.gaps,
            weights: &self.weights,
            mu,
        };
        let mut limit = self.move_limit.map(|limit| limit / scale.length);
        let multipliers = (!start.multipliers.is_empty()).then(|| lifted.multipliers(start));
        let mut x = lifted.start(start, multipliers.as_ref(), self.slack_bound);
        let bounds = self.variables(subproblem, &x, limit);
        let mut sequence = Sequence::new(
            structure(subproblem, bounds)?,
            self.settings(subproblem),
            &x,
        )?;
        sequence.restart(&x, multipliers)?;
        let allowed = self.continuation.allowed(&scale);
        let mut moves = 0;
        let (run, solved) = loop {
            let run = sequence.solve(&mut lifted)?;
            let solved = lifted.energy.solved(&run);
            if solved != Solved::Optimal {
                break (run, solved);
            }
            let n = lifted.energy.dofs();
            let steps = run.solution.x.iter().zip(&x).take(n);
            let step = steps.fold(0.0, |step: f64, (a, b)| step.max((a - b).abs()));
            x.clone_from(&run.solution.x);
            if limit.is_some_and(|limit| step > Self::AT_BOUND * limit) && moves < Self::MOVES {
                moves += 1;
                limit = limit.map(|limit| Self::WIDER * limit);
                let bounds = self.variables(subproblem, &x, limit);
                sequence.set_bounds(bounds, Bounds::zero(subproblem.gaps.len()))?;
                continue;
            }
            let depth = x[n..].iter().fold(0.0, |depth: f64, s| depth.max(-s));
            let is_through = depth > Self::AT_BOUND * self.slack_bound;
            if depth <= allowed && !is_through {
                *reached = lifted.mu;
                break (run, Solved::Optimal);
            }
            if lifted.mu >= self.continuation.limit {
                let why = format!("penetration {:.2e} at the last μ", depth * scale.length);
                break (run, Solved::Failed(why));
            }
            lifted.mu = (lifted.mu * self.continuation.growth).min(self.continuation.limit);
            if let Some(multipliers) = &run.solution.multipliers {
                lifted.push_back(multipliers, &mut x);
                sequence.restart(&x, Some(multipliers.clone()))?;
            }
        };
        let wall = clock.elapsed().as_secs_f64();
        let effort = lifted.energy.effort(sequence.totals(), &run, wall);
        Ok(Minimum {
            solved,
            effort,
            ..lifted.minimum(run)
        })
    }

    /// Bounds on (u, s)/L: those of the subproblem within the move limit around `x`, and s ≥ −ε.
    fn variables(&self, subproblem: &Subproblem<'_>, x: &[f64], limit: Option<f64>) -> Bounds {
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

    fn settings(&self, subproblem: &Subproblem<'_>) -> SequenceSettings {
        let tolerance = self.tolerance;
        let tolerance = tolerance.max(Self::ABOVE_ROUNDOFF * subproblem.scale.roundoff);
        let options = Options::new()
            .with("tol", tolerance)
            .with("compl_inf_tol", tolerance)
            .with("acceptable_tol", Self::ATTAINABLE * tolerance)
            .with("mu_strategy", "adaptive")
            .with("nlp_scaling_method", "none")
            .with("max_iter", self.max_iterations);
        let warm = Options::new().with("max_iter", self.max_iterations);
        SequenceSettings {
            options: options.and(self.options),
            warm: warm.and(self.options),
            attainable_error: Self::ATTAINABLE * tolerance,
            ..SequenceSettings::default()
        }
    }
}

fn structure(subproblem: &Subproblem<'_>, variables: Bounds) -> Result<Structure, Error> {
    let Subproblem { energy, gaps, .. } = *subproblem;
    let (n, m) = (energy.dofs(), gaps.len());
    let mut jacobian: Pattern = gaps.entries().map(|(i, j, _)| (i, j)).collect();
    let mut hessian = energy.hessian_pattern().clone();
    for i in 0..m {
        jacobian.push(i, n + i);
        hessian.push(n + i, n + i);
    }
    let structure = Structure::new(variables, Bounds::zero(m), jacobian, Some(hessian))?;
    Ok(structure.with_constant_jacobian(true))
}

/// The subproblem for one μ in Ipopt's numbers: x = (u, s)/L and f = E/E₀ + μ Σ w η(s).
struct Lifted<'a> {
    energy: ScaledEnergy<'a>,
    gaps: &'a LinearGaps,
    weights: &'a [f64],
    mu: f64,
}

impl Lifted<'_> {
    /// u and its gaps, which may not be negative beyond the bound; where there are forces already,
    /// slacks that push back with them.
    fn start(&self, state: &State, forces: Option<&Multipliers>, slack_bound: f64) -> Vec<f64> {
        let mut c = vec![0.0; self.gaps.len()];
        self.gaps.value(&state.u, &mut c);
        let scaled = |v: &f64| v / self.energy.length;
        let slacks = c.iter().map(|c| scaled(c).max(-slack_bound));
        let mut x: Vec<f64> = state.u.iter().map(scaled).chain(slacks).collect();
        if let Some(forces) = forces {
            self.push_back(forces, &mut x);
        }
        x
    }

    /// Sets the slacks to those whose penalty is in balance with the contact forces, where there
    /// are any. The equalities are linear: one Newton step brings displacements into line.
    fn push_back(&self, forces: &Multipliers, x: &mut [f64]) {
        let slacks = x[self.energy.dofs()..].iter_mut().zip(self.weights);
        for ((s, w), multiplier) in slacks.zip(&forces.constraints) {
            if *multiplier < 0.0 {
                *s = slack(-multiplier / (self.mu * w));
            }
        }
    }

    /// The multipliers of a state as Ipopt wants them.
    fn multipliers(&self, state: &State) -> Multipliers {
        let (n, m) = (self.energy.dofs(), self.gaps.len());
        let scaled = |&key| -state.multipliers.of(key) / self.energy.force(1.0);
        Multipliers {
            constraints: self.gaps.keys().iter().map(scaled).collect(),
            lower: vec![0.0; n + m],
            upper: vec![0.0; n + m],
        }
    }

    /// Back in the user's units; E without the penalty.
    fn minimum(self, run: Run) -> Minimum {
        let solution = run.solution;
        let penalty: f64 = self.penalty(&solution.x);
        let force = |l: f64| self.energy.force(-l).max(0.0);
        let n = self.energy.dofs();
        Minimum {
            solved: Solved::Optimal,
            u: solution.x[..n]
                .iter()
                .map(|x| x * self.energy.length)
                .collect(),
            lambda: solution.multipliers.map_or_else(
                || vec![0.0; self.gaps.len()],
                |m| m.constraints.into_iter().map(force).collect(),
            ),
            energy: (solution.objective - penalty) * self.energy.unit,
            effort: Default::default(),
        }
    }

    /// μ Σ w η(s).
    fn penalty(&self, x: &[f64]) -> f64 {
        let slacks = x[self.energy.dofs()..].iter().zip(self.weights);
        self.mu * slacks.map(|(s, w)| w * eta(*s)[0]).sum::<f64>()
    }

    /// The derivatives of the penalty, one a slack.
    fn slopes(&self, x: &[f64], slopes: &mut [f64]) {
        let slacks = x[self.energy.dofs()..].iter().zip(self.weights);
        for (slope, (s, w)) in slopes.iter_mut().zip(slacks) {
            *slope = self.mu * w * eta(*s)[1];
        }
    }

    /// The penalty's curvatures, one a slack, as far as `multipliers` of the Lagrangian with this
    /// share of the objective foretell forces.
    fn curvatures(&self, x: &[f64], share: f64, multipliers: &[f64], curvatures: &mut [f64]) {
        let slacks = x[self.energy.dofs()..].iter().zip(self.weights);
        let all = curvatures.iter_mut().zip(slacks).zip(multipliers);
        for ((curvature, (s, w)), multiplier) in all {
            let stiffness = share * self.mu * w;
            *curvature = match stiffness > 0.0 {
                true => stiffness * secant(*s, -multiplier / stiffness),
                false => 0.0,
            };
        }
    }
}

impl Nlp for Lifted<'_> {
    fn begin(&mut self, x: &[f64]) {
        self.energy.begin(x);
    }

    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        self.energy.value(x) + self.penalty(x)
    }

    fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        let (of_u, of_s) = gradient.split_at_mut(self.energy.dofs());
        self.energy.gradient(x, of_u);
        self.slopes(x, of_s);
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        let gaps = self.gaps;
        self.energy.timed(x, |energy| {
            gaps.value(energy.u(), g);
            let slacks = &x[energy.dofs()..];
            let all = g.iter_mut().zip(slacks);
            all.for_each(|(g, s)| *g = *g / energy.length - s);
        });
    }

    fn jacobian(&mut self, _x: &[f64], _new_x: bool, values: &mut [f64]) {
        let coefficients = self.gaps.entries().map(|entry| entry.2);
        let all = coefficients.chain(std::iter::repeat(-1.0));
        values.iter_mut().zip(all).for_each(|(v, c)| *v = c);
    }

    fn hessian(
        &mut self,
        x: &[f64],
        _new_x: bool,
        objective_factor: f64,
        multipliers: &[f64],
        values: &mut [f64],
    ) {
        let (of_u, of_s) = values.split_at_mut(values.len() - self.gaps.len());
        self.energy.hessian(x, objective_factor, of_u);
        self.curvatures(x, objective_factor, multipliers, of_s);
    }

    fn iterate(&mut self, _iterate: &Iterate<'_>) -> ControlFlow<()> {
        match self.energy.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
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
}
