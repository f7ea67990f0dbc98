//! Method (7): the interior point method, Ipopt on min E(u) subject to C u + c₀ ≥ 0.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{Effort, Factor, Method, Minimum, Solved, Subproblem};
use crate::ipopt::{Options, Run, Sequence, SequenceSettings, Totals};
use crate::nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure};
use crate::{Error, Scale, State};

/// The interior point method (7), the reference method.
///
/// Everything is scaled before Ipopt sees it: lengths by [`Scale::length`](crate::Scale), energies
/// by [`Scale::energy`](crate::Scale), so that its tolerances are dimensionless and results do not
/// depend on units. A solve with multipliers starts warm and is repeated cold if that fails.
#[derive(Clone, Debug)]
pub struct InteriorPoint {
    /// Ipopt's `tol`, relative to the scales.
    pub tolerance: f64,
    /// Gap times contact force that may be left at an active row, relative to stiffness times
    /// [`Scale::resolution`](crate::Scale)².
    pub complementarity: f64,
    /// Iterations before a warm solve is given up and repeated cold.
    pub max_warm_iterations: usize,
    /// Iterations before a cold solve is given up.
    pub max_iterations: usize,
    /// More options for Ipopt by name; they override everything set here.
    pub options: Options,
    /// Raising this flag stops a running solve at its next iteration.
    pub stop: Option<Arc<AtomicBool>>,
}

impl Default for InteriorPoint {
    fn default() -> Self {
        InteriorPoint {
            tolerance: 1e-12,
            complementarity: 1e-8,
            max_warm_iterations: 40,
            max_iterations: 300,
            options: Options::new(),
            stop: None,
        }
    }
}

impl InteriorPoint {
    /// How far a warm start is moved off its bounds, in the scaled slacks and multipliers: hardly,
    /// but more when it is a guess from another load, whose active rows need not be the right ones.
    const PUSH: f64 = 1e-9;
    const FIRST_PUSH: f64 = 1e-4;

    /// A solve that cannot make progress any more counts as solved up to this many tolerances.
    const ATTAINABLE: f64 = 100.0;

    /// Tolerances closer to round-off than this are not asked for.
    const ABOVE_ROUNDOFF: f64 = 10.0;

    /// Ipopt's tolerance for a problem of this scale.
    fn attainable(&self, scale: &Scale) -> f64 {
        self.tolerance.max(Self::ABOVE_ROUNDOFF * scale.roundoff)
    }

    /// How Ipopt is to solve a subproblem.
    fn settings(&self, subproblem: &Subproblem<'_>) -> SequenceSettings {
        let tolerance = self.attainable(&subproblem.scale);
        let Scale {
            length, resolution, ..
        } = subproblem.scale;
        let share = (resolution / length).powi(2);
        let complementarity = (self.complementarity * share).min(tolerance);
        let options = Options::new()
            .with("tol", tolerance)
            .with("compl_inf_tol", complementarity)
            .with("acceptable_tol", Self::ATTAINABLE * tolerance)
            .with(
                "acceptable_compl_inf_tol",
                Self::ATTAINABLE * complementarity,
            )
            .with("mu_strategy", "adaptive")
            .with("nlp_scaling_method", "none")
            .with("max_iter", self.max_iterations);
        let mut warm = Options::new().with("max_iter", self.max_warm_iterations);
        let push = match subproblem.first {
            true => Self::FIRST_PUSH,
            false => Self::PUSH,
        };
        for name in [
            "warm_start_bound_push",
            "warm_start_bound_frac",
            "warm_start_slack_bound_push",
            "warm_start_slack_bound_frac",
            "warm_start_mult_bound_push",
        ] {
            warm.set(name, push);
        }
        SequenceSettings {
            options: options.and(&self.options),
            warm: warm.and(&self.options),
            attainable_error: Self::ATTAINABLE * tolerance,
            ..SequenceSettings::default()
        }
    }
}

impl Method for InteriorPoint {
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        let clock = Instant::now();
        let mut scaled = Scaled::new(subproblem, self.stop.as_deref());
        let x: Vec<f64> = start.u.iter().map(|u| u / scaled.length).collect();
        let warm = !start.multipliers.is_empty();

        let mut sequence = Sequence::new(structure(subproblem)?, self.settings(subproblem), &x)?;
        sequence.restart(&x, warm.then(|| scaled.multipliers(start)))?;
        let run = sequence.solve(&mut scaled)?;

        let effort = scaled.effort(sequence.totals(), &run, clock.elapsed().as_secs_f64());
        Ok(scaled.minimum(run, effort))
    }
}

fn structure(subproblem: &Subproblem<'_>) -> Result<Structure, Error> {
    let Subproblem {
        energy,
        bounds,
        gaps,
        scale,
        ..
    } = *subproblem;
    let variables = match bounds.is_empty() {
        true => Bounds::free(energy.dofs()),
        false => Bounds {
            lower: bounds.lower.iter().map(|b| b / scale.length).collect(),
            upper: bounds.upper.iter().map(|b| b / scale.length).collect(),
        },
    };
    let jacobian: Pattern = gaps.entries().map(|(i, j, _)| (i, j)).collect();
    let hessian = energy.hessian_pattern().clone();
    let constraints = Bounds::nonnegative(gaps.len());
    Ok(
        Structure::new(variables, constraints, jacobian, Some(hessian))?
            .with_constant_hessian(energy.is_quadratic())
            .with_constant_jacobian(true),
    )
}

/// The subproblem in Ipopt's numbers: x = u/L, f = E/E₀, g = c/L, and its multipliers −λ L/E₀.
struct Scaled<'a> {
    subproblem: Subproblem<'a>,
    length: f64,
    energy: f64,
    u: Vec<f64>,
    /// The domain functions at the last accepted point and at the trial point.
    accepted: Vec<f64>,
    trial: Vec<f64>,
    stop: Option<&'a AtomicBool>,
    /// Evaluations, and seconds spent in here.
    values: usize,
    gradients: usize,
    hessians: usize,
    seconds: f64,
}

impl<'a> Scaled<'a> {
    /// The J guard: a trial with a domain function below this share of its last accepted value is
    /// inadmissible.
    const GUARD: f64 = 0.1;

    fn new(subproblem: &Subproblem<'a>, stop: Option<&'a AtomicBool>) -> Self {
        let energy = subproblem.energy;
        Scaled {
            subproblem: *subproblem,
            length: subproblem.scale.length,
            energy: subproblem.scale.energy,
            u: vec![0.0; energy.dofs()],
            accepted: vec![0.0; energy.domain_len()],
            trial: vec![0.0; energy.domain_len()],
            stop,
            values: 0,
            gradients: 0,
            hessians: 0,
            seconds: 0.0,
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// The multipliers of a state as Ipopt wants them.
    fn multipliers(&self, state: &State) -> Multipliers {
        let n = self.u.len();
        let scaled = |key| -state.multipliers.of(key) * self.length / self.energy;
        Multipliers {
            constraints: self
                .subproblem
                .gaps
                .keys()
                .iter()
                .map(|&k| scaled(k))
                .collect(),
            lower: vec![0.0; n],
            upper: vec![0.0; n],
        }
    }

    /// What the solves cost, of `wall` seconds in all.
    fn effort(&self, totals: &Totals, run: &Run, wall: f64) -> Effort {
        Effort {
            solves: totals.warm + totals.cold,
            cold_retries: totals.cold_retries,
            iterations: totals.iterations,
            factorizations: totals.factorizations,
            values: self.values,
            gradients: self.gradients,
            hessians: self.hessians,
            callbacks: self.seconds,
            optimizer: wall - self.seconds,
            factor: run.solution.statistics.mumps.map(|mumps| Factor {
                ordering: mumps.ordering.name(),
                bytes: mumps.factor_bytes,
                workspace_bytes: mumps.workspace_bytes,
                reallocations: mumps.reallocations,
            }),
        }
    }

    /// Back in the user's units.
    fn minimum(&self, run: Run, effort: Effort) -> Minimum {
        let solution = run.solution;
        let rows = self.subproblem.gaps.len();
        let force = |l: f64| (-l * self.energy / self.length).max(0.0);
        Minimum {
            solved: match solution.status {
                _ if run.solved => Solved::Optimal,
                _ if self.is_stopped() => Solved::Interrupted,
                status => Solved::Failed(status.to_string()),
            },
            u: solution.x.iter().map(|x| x * self.length).collect(),
            lambda: solution.multipliers.map_or_else(
                || vec![0.0; rows],
                |m| m.constraints.into_iter().map(force).collect(),
            ),
            energy: solution.objective * self.energy,
            effort,
        }
    }

    /// Runs `f` on the subproblem and u = L x, and counts the time.
    fn timed<T>(&mut self, x: &[f64], f: impl FnOnce(&mut Self) -> T) -> T {
        let clock = Instant::now();
        for (u, x) in self.u.iter_mut().zip(x) {
            *u = x * self.length;
        }
        let result = f(self);
        self.seconds += clock.elapsed().as_secs_f64();
        result
    }
}

impl Nlp for Scaled<'_> {
    fn begin(&mut self, x: &[f64]) {
        self.timed(x, |this| {
            this.subproblem.energy.domain(&this.u, &mut this.accepted);
        });
    }

    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        self.values += 1;
        self.timed(x, |this| {
            let energy = this.subproblem.energy;
            energy.domain(&this.u, &mut this.trial);
            let mut domain = this.trial.iter().zip(&this.accepted);
            if domain.any(|(d, accepted)| *d < Self::GUARD * accepted) {
                return f64::INFINITY;
            }
            energy.value(&this.u) / this.energy
        })
    }

    fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        self.gradients += 1;
        self.timed(x, |this| {
            // Ipopt asks for gradients at accepted points only
            this.subproblem.energy.domain(&this.u, &mut this.accepted);
            this.subproblem.energy.gradient(&this.u, gradient);
            let scale = this.length / this.energy;
            gradient.iter_mut().for_each(|g| *g *= scale);
        });
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        self.timed(x, |this| {
            this.subproblem.gaps.value(&this.u, g);
            g.iter_mut().for_each(|g| *g /= this.length);
        });
    }

    fn jacobian(&mut self, x: &[f64], _new_x: bool, values: &mut [f64]) {
        self.timed(x, |this| {
            let entries = this.subproblem.gaps.entries();
            values.iter_mut().zip(entries).for_each(|(v, e)| *v = e.2);
        });
    }

    fn hessian(
        &mut self,
        x: &[f64],
        _new_x: bool,
        objective_factor: f64,
        _multipliers: &[f64],
        values: &mut [f64],
    ) {
        self.hessians += 1;
        self.timed(x, |this| {
            this.subproblem.energy.hessian(&this.u, values);
            let scale = objective_factor * this.length * this.length / this.energy;
            values.iter_mut().for_each(|v| *v *= scale);
        });
    }

    fn iterate(&mut self, _iterate: &Iterate<'_>) -> ControlFlow<()> {
        match self.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}
