//! Method (7): the interior point method, Ipopt on min E(u) subject to C u + c₀ ≥ 0.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::scaled::ScaledEnergy;
use super::{Effort, Method, Minimum, Subproblem};
use crate::ipopt::{Options, Run, Sequence, SequenceSettings};
use crate::nlp::{Bounds, Iterate, Multipliers, Nlp, Pattern, Structure};
use crate::{Error, LinearGaps, Scale, State};

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
        let mut scaled = Scaled {
            energy: ScaledEnergy::new(subproblem, self.stop.as_deref()),
            gaps: subproblem.gaps,
        };
        let length = subproblem.scale.length;
        let x: Vec<f64> = start.u.iter().map(|u| u / length).collect();
        let warm = !start.multipliers.is_empty();

        let mut sequence = Sequence::new(structure(subproblem)?, self.settings(subproblem), &x)?;
        sequence.restart(&x, warm.then(|| scaled.multipliers(start)))?;
        let run = sequence.solve(&mut scaled)?;

        let wall = clock.elapsed().as_secs_f64();
        let effort = scaled.energy.effort(sequence.totals(), &run, wall);
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
    energy: ScaledEnergy<'a>,
    gaps: &'a LinearGaps,
}

impl Scaled<'_> {
    /// The multipliers of a state as Ipopt wants them.
    fn multipliers(&self, state: &State) -> Multipliers {
        let n = self.energy.dofs();
        let scaled = |&key| -state.multipliers.of(key) / self.energy.force(1.0);
        Multipliers {
            constraints: self.gaps.keys().iter().map(scaled).collect(),
            lower: vec![0.0; n],
            upper: vec![0.0; n],
        }
    }

    /// Back in the user's units.
    fn minimum(&self, run: Run, effort: Effort) -> Minimum {
        let solved = self.energy.solved(&run);
        let solution = run.solution;
        let force = |l: f64| self.energy.force(-l).max(0.0);
        Minimum {
            solved,
            u: solution.x.iter().map(|x| x * self.energy.length).collect(),
            lambda: solution.multipliers.map_or_else(
                || vec![0.0; self.gaps.len()],
                |m| m.constraints.into_iter().map(force).collect(),
            ),
            energy: solution.objective * self.energy.unit,
            effort,
        }
    }
}

impl Nlp for Scaled<'_> {
    fn begin(&mut self, x: &[f64]) {
        self.energy.begin(x);
    }

    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        self.energy.value(x)
    }

    fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        self.energy.gradient(x, gradient);
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        let gaps = self.gaps;
        self.energy.timed(x, |energy| {
            gaps.value(energy.u(), g);
            g.iter_mut().for_each(|g| *g /= energy.length);
        });
    }

    fn jacobian(&mut self, x: &[f64], _new_x: bool, values: &mut [f64]) {
        let entries = self.gaps.entries();
        self.energy.timed(x, |_| {
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
        self.energy.hessian(x, objective_factor, values);
    }

    fn iterate(&mut self, _iterate: &Iterate<'_>) -> ControlFlow<()> {
        match self.energy.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}
