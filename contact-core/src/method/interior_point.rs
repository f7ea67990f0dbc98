//! Method (7): min E(u) subject to C u + c₀ ≥ 0 by the interior point method of Ipopt.

use std::ops::ControlFlow;
use std::time::Instant;

use super::scaled::{Scaled, attainable, check_memory, check_tolerance, memory, settings};
use super::{Method, Minimum, Subproblem, check_bounds};
use crate::ipopt::{Options, Sequence, SequenceSettings, doctor};
use crate::nlp::{Bounds, Iterate, Nlp, Pattern, Structure};
use crate::{Energy, Error, MemoryNeed, Scale, Solved, State};

/// The interior point method (7), the reference method.
///
/// The problem is scaled before Ipopt sees it: lengths by [`Scale::length`](crate::Scale), energies
/// by [`Scale::energy`](crate::Scale). Tolerances are therefore dimensionless, and results do not
/// depend on units. A start with multipliers is a warm start; if that solve fails, it is repeated
/// from a cold start. Without [options](Self::options), a convex quadratic program is solved by
/// Mehrotra's predictor–corrector first.
#[derive(Clone, Debug)]
pub struct InteriorPoint {
    /// Ipopt's `tol`, relative to the scales.
    pub tolerance: f64,
    /// The tolerance on complementarity, gap times contact force at a row, relative to stiffness
    /// times [`Scale::resolution`](crate::Scale)².
    pub complementarity: f64,
    /// The iteration limit of a warm solve, which is then repeated from a cold start.
    pub max_warm_iterations: usize,
    /// The iteration limit of a cold solve.
    pub max_iterations: usize,
    /// Further options for Ipopt by name; they override all settings above.
    pub options: Options,
}

impl Default for InteriorPoint {
    fn default() -> Self {
        InteriorPoint {
            tolerance: 1e-12,
            complementarity: 1e-8,
            max_warm_iterations: 40,
            max_iterations: 300,
            options: Options::new(),
        }
    }
}

impl InteriorPoint {
    /// The distance by which a warm start is moved off its bounds, dimensionless in the scaled slacks and multipliers,
    /// per expected relative change of u: the active rows of the start need not be those of the solution. The distance
    /// is at most `PUSH` and at least [`Self::LEAST_PUSH`]. It sets the iterations of warm solves.
    const PUSH: f64 = 1e-4;
    /// See [`Self::PUSH`]. With the adaptive barrier parameter, pushes of 1e-9 took 3 to 4 iterations a solve on
    /// sequences of quadratic programs with load steps of 5 %.
    const LEAST_PUSH: f64 = 1e-9;
    /// The iteration limit of Mehrotra's predictor–corrector, which takes about 20.
    const MEHROTRA: usize = 40;

    /// The options of Ipopt for a subproblem.
    fn settings(&self, subproblem: &Subproblem<'_>) -> SequenceSettings {
        let tolerance = attainable(self.tolerance, &subproblem.scale).max(subproblem.accuracy);
        let Scale {
            length, resolution, ..
        } = subproblem.scale;
        let share = (resolution / length).powi(2);
        let complementarity = (self.complementarity * share)
            .min(tolerance)
            .max(subproblem.accuracy);
        let mut warm = Options::new().with("max_iter", self.max_warm_iterations);
        let push = (Self::PUSH * subproblem.change).clamp(Self::LEAST_PUSH, Self::PUSH);
        for name in [
            "warm_start_bound_push",
            "warm_start_bound_frac",
            "warm_start_slack_bound_push",
            "warm_start_slack_bound_frac",
            "warm_start_mult_bound_push",
        ] {
            warm.set(name, push);
        }
        // residuals are checked nevertheless, and refined where they are too large
        let options = Options::new().with("min_refinement_steps", 0);
        settings(
            tolerance,
            complementarity,
            self.max_iterations,
            warm,
            &options.and(&self.options),
        )
    }
}

impl InteriorPoint {
    fn check_tolerances(&self) -> Result<(), Error> {
        check_tolerance("tolerance", self.tolerance)?;
        check_tolerance("complementarity", self.complementarity)
    }
}

impl Method for InteriorPoint {
    fn name(&self) -> &'static str {
        "ipopt"
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        memory(energy, &self.options)
    }

    fn validate(&self) -> Result<(), Error> {
        self.check_tolerances()?;
        Ok(doctor::check_linear_solver(&self.options)?)
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        self.check_tolerances()?;
        let settings = self.settings(subproblem);
        if !self.is_quadratic_program(subproblem, start) {
            return self.solve(settings, subproblem, start);
        }
        let mut mehrotra = settings.clone();
        mehrotra.options.set("mehrotra_algorithm", "yes");
        let most = self.max_iterations.min(Self::MEHROTRA);
        mehrotra.options.set("max_iter", most);
        // without refinement its last steps are lost to round-off
        mehrotra.options.set("min_refinement_steps", 1);
        let mut minimum = self.solve(mehrotra, subproblem, start)?;
        if matches!(minimum.solved, Solved::Failed(_)) {
            let spent = minimum.cost;
            minimum = self.solve(settings, subproblem, start)?;
            minimum.cost += spent;
        }
        Ok(minimum)
    }
}

impl InteriorPoint {
    /// Whether the subproblem is a convex quadratic program with a cold start, on which Mehrotra's
    /// predictor–corrector takes fewer iterations. It is not used with options of the user, which
    /// may conflict with it.
    fn is_quadratic_program(&self, subproblem: &Subproblem<'_>, start: &State) -> bool {
        let is_one = subproblem.energy.is_quadratic() && subproblem.gaps.is_exact();
        is_one && start.multipliers.is_empty() && self.options.iter().next().is_none()
    }

    /// One run of Ipopt, and a second, cold one if a warm start fails.
    fn solve(
        &self,
        settings: SequenceSettings,
        subproblem: &Subproblem<'_>,
        start: &State,
    ) -> Result<Minimum, Error> {
        let clock = Instant::now();
        let mut scaled = Scaled::new(subproblem);
        let x = scaled.displacements(start);
        let warm = !start.multipliers.is_empty();

        let mut sequence = Sequence::new(structure(subproblem)?, settings, &x)?;
        sequence.restart(&x, warm.then(|| scaled.multipliers(start, x.len())))?;
        let run = sequence.solve(&mut scaled)?;
        check_memory(&run, subproblem.energy)?;

        let wall = clock.elapsed().as_secs_f64();
        let cost = scaled.cost(sequence.totals(), &run, wall);
        Ok(scaled.minimum(run, cost))
    }
}

pub(crate) fn structure(subproblem: &Subproblem<'_>) -> Result<Structure, Error> {
    let Subproblem {
        energy,
        bounds,
        gaps,
        scale,
        ..
    } = *subproblem;
    check_bounds(bounds, energy.dofs())?;
    let variables = match bounds.is_empty() {
        true => Bounds::free(energy.dofs()),
        false => Bounds {
            lower: bounds.lower.iter().map(|b| b / scale.length).collect(),
            upper: bounds.upper.iter().map(|b| b / scale.length).collect(),
        },
    };
    let jacobian: Pattern = gaps.entries().map(|(i, j, _)| (i, j)).collect();
    let hessian = energy.hessian_pattern().entries().clone();
    let constraints = Bounds::nonnegative(gaps.len());
    Ok(
        Structure::new(variables, constraints, jacobian, Some(hessian))?
            .with_constant_hessian(energy.is_quadratic())
            .with_constant_jacobian(true),
    )
}

/// E(u) subject to c(u) ≥ 0.
impl Nlp for Scaled<'_> {
    fn begin(&mut self, x: &[f64]) {
        self.begin(x);
    }

    fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
        self.value(x)
    }

    fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
        self.gradient(x, gradient);
    }

    fn constraints(&mut self, x: &[f64], _new_x: bool, g: &mut [f64]) {
        self.constraints(x, g);
    }

    fn jacobian(&mut self, _x: &[f64], _new_x: bool, values: &mut [f64]) {
        self.jacobian(values);
    }

    fn hessian(
        &mut self,
        x: &[f64],
        _new_x: bool,
        objective_factor: f64,
        _multipliers: &[f64],
        values: &mut [f64],
    ) {
        self.hessian(x, objective_factor, values);
    }

    fn is_to_stop(&mut self) -> bool {
        Scaled::is_to_stop(self)
    }

    fn may_factorize(&mut self) -> bool {
        Scaled::may_factorize(self)
    }

    fn iterate(&mut self, _iterate: &Iterate<'_>) -> ControlFlow<()> {
        self.flow()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ipopt::OptionValue;
    use crate::linear::SymmetricPattern;
    use crate::{LinearGaps, Stop};

    struct Nothing(SymmetricPattern, bool);

    impl Energy for Nothing {
        fn dofs(&self) -> usize {
            1
        }
        fn value(&self, _: &[f64]) -> f64 {
            0.0
        }
        fn gradient(&self, _: &[f64], _: &mut [f64]) {}
        fn hessian_pattern(&self) -> &SymmetricPattern {
            &self.0
        }
        fn hessian(&self, _: &[f64], _: &mut [f64]) {}
        fn is_quadratic(&self) -> bool {
            self.1
        }
    }

    fn settings(change: f64, accuracy: f64, scale: Scale) -> SequenceSettings {
        let subproblem = Subproblem {
            energy: &Nothing(SymmetricPattern::diagonal(1), false),
            bounds: &Bounds::default(),
            gaps: &LinearGaps::new(true),
            scale,
            change,
            accuracy,
            stop: &Stop::new(),
        };
        InteriorPoint::default().settings(&subproblem)
    }

    fn number(options: &Options, name: &str) -> f64 {
        match options.get(name) {
            Some(OptionValue::Number(number)) => *number,
            other => panic!("{name}: {other:?}"),
        }
    }

    /// Warm starts stay near their bounds: at a ten-thousandth of the expected change, which the start
    /// need not resolve further than 1e-9.
    #[test]
    fn warm_starts_are_pushed_by_what_may_change() {
        for (change, push) in [(1.0, 1e-4), (7.0, 1e-4), (1e-2, 1e-6), (0.0, 1e-9)] {
            let warm = settings(change, 0.0, Scale::default()).warm;
            for name in [
                "warm_start_bound_push",
                "warm_start_bound_frac",
                "warm_start_slack_bound_push",
                "warm_start_slack_bound_frac",
                "warm_start_mult_bound_push",
            ] {
                assert!((number(&warm, name) / push - 1.0).abs() < 1e-12, "{name}");
            }
        }
    }

    /// The tolerance is 1e-12, but no less than ten times the round-off, and no less than what suffices;
    /// a solve that is stuck may be worse by 100. Products of gaps and forces are relative to stiffness
    /// times the resolution squared.
    #[test]
    fn tolerances_are_relative_to_the_scales() {
        let scale = |roundoff: f64, resolution: f64| Scale {
            roundoff,
            resolution,
            length: 2.0,
            ..Scale::default()
        };
        for (roundoff, accuracy, resolution, tolerance, complementarity) in [
            (1e-16, 0.0, 2.0, 1e-12, 1e-12),
            (1e-16, 0.0, 2e-3, 1e-12, 1e-14),
            (1e-11, 0.0, 2e-3, 1e-10, 1e-14),
            (1e-16, 1e-8, 2e-3, 1e-8, 1e-8),
        ] {
            let settings = settings(1.0, accuracy, scale(roundoff, resolution));
            let found = [
                (number(&settings.options, "tol"), tolerance),
                (number(&settings.options, "compl_inf_tol"), complementarity),
                (settings.attainable_error, 100.0 * tolerance),
            ];
            for (found, expected) in found {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    /// The predictor–corrector is for cold starts of quadratic energies under rows that do not change, and
    /// not for users with options of their own.
    #[test]
    fn quadratic_programs_are_told_from_others() {
        let key = crate::RowKey { pass: 0, node: 0 };
        let multipliers = || {
            let mut gaps = LinearGaps::new(true);
            gaps.push(key, &crate::gaps::Row::default());
            crate::Multipliers::new(&gaps, &[1.0])
        };
        for (is_quadratic, is_exact, is_warm, has_options) in [
            (true, true, false, false),
            (false, true, false, false),
            (true, false, false, false),
            (true, true, true, false),
            (true, true, false, true),
        ] {
            let subproblem = Subproblem {
                energy: &Nothing(SymmetricPattern::diagonal(1), is_quadratic),
                bounds: &Bounds::default(),
                gaps: &LinearGaps::new(is_exact),
                scale: Scale::default(),
                change: 1.0,
                accuracy: 0.0,
                stop: &Stop::new(),
            };
            let mut start = State::default();
            if is_warm {
                start.multipliers = multipliers();
            }
            let mut method = InteriorPoint::default();
            if has_options {
                method.options.set("max_iter", 7);
            }
            let expected = is_quadratic && is_exact && !is_warm && !has_options;
            assert_eq!(method.is_quadratic_program(&subproblem, &start), expected);
        }
    }
}
