//! A subproblem scaled to O(1), x = u/L, f = E/E₀, g = c/L, and the transformation back.

use std::ops::ControlFlow;
use std::time::Instant;

use super::{Minimum, Subproblem};
use crate::cost::FactorSize;
use crate::ipopt::{OptionValue, Options, Run, SequenceSettings, Status, Totals, blas_bytes};
use crate::nlp::Multipliers;
use crate::{Cost, Energy, Error, LinearGaps, MemoryError, MemoryNeed, Scale, Solved, State, Stop};

/// A solve that can make no further progress counts as solved if its error is at most this multiple of the tolerance.
const ATTAINABLE: f64 = 100.0;
/// The smallest tolerance asked of Ipopt, as a multiple of [`Scale::roundoff`].
const ABOVE_ROUNDOFF: f64 = 10.0;

/// The scaled subproblem that Ipopt solves, with the guard of its domain and the cost of its
/// evaluations. The x passed to its functions may have further entries after the n displacements.
pub(crate) struct Scaled<'a> {
    energy: &'a dyn Energy,
    gaps: &'a LinearGaps,
    /// L (UL) and E₀ (UF·UL).
    pub length: f64,
    pub unit: f64,
    u: Vec<f64>,
    /// The domain functions at the last accepted point and at the trial point.
    accepted: Vec<f64>,
    trial: Vec<f64>,
    stop: &'a Stop,
    /// Numbers of evaluations, and seconds spent in them.
    values: usize,
    gradients: usize,
    hessians: usize,
    seconds: f64,
}

impl<'a> Scaled<'a> {
    /// The J guard: a trial point with a domain function below this share of its last accepted value
    /// is inadmissible. Without it J fell to 1e-9 after a cold first solve of an increment.
    const GUARD: f64 = 0.1;

    pub fn new(subproblem: &Subproblem<'a>) -> Self {
        let energy = subproblem.energy;
        Scaled {
            energy,
            gaps: subproblem.gaps,
            length: subproblem.scale.length,
            unit: subproblem.scale.energy,
            u: vec![0.0; energy.dofs()],
            accepted: vec![0.0; energy.domain_len()],
            trial: vec![0.0; energy.domain_len()],
            stop: subproblem.stop,
            values: 0,
            gradients: 0,
            hessians: 0,
            seconds: 0.0,
        }
    }

    /// n, the number of displacements.
    pub fn dofs(&self) -> usize {
        self.u.len()
    }

    /// Whether a stop has been requested.
    pub fn is_to_stop(&self) -> bool {
        self.stop.is_requested()
    }

    /// Counts a factorisation that is about to begin; false if it must not.
    pub fn may_factorize(&self) -> bool {
        self.stop.begin_factorization()
    }

    /// `Break` once a stop has been requested.
    pub fn flow(&self) -> ControlFlow<()> {
        match self.is_to_stop() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// u/L.
    pub fn displacements(&self, state: &State) -> Vec<f64> {
        state.u.iter().map(|u| u / self.length).collect()
    }

    /// The multipliers of a state in Ipopt's sign and scale, −λ L/E₀, with zeros for the bounds of all `variables`.
    pub fn multipliers(&self, state: &State, variables: usize) -> Multipliers {
        let scale = self.length / self.unit;
        let scaled = |&key| -state.multipliers.of(key) * scale;
        Multipliers {
            constraints: self.gaps.keys().iter().map(scaled).collect(),
            lower: vec![0.0; variables],
            upper: vec![0.0; variables],
        }
    }

    /// The result in the user's units; negative λ are set to 0.
    pub fn minimum(&self, run: Run, cost: Cost) -> Minimum {
        let solved = self.solved(&run);
        let solution = run.solution;
        let force = |l: f64| (-l * self.unit / self.length).max(0.0);
        let u = &solution.x[..self.dofs()];
        Minimum {
            solved,
            u: u.iter().map(|x| x * self.length).collect(),
            lambda: solution.multipliers.map_or_else(
                || vec![0.0; self.gaps.len()],
                |m| m.constraints.into_iter().map(force).collect(),
            ),
            energy: solution.objective * self.unit,
            cost,
        }
    }

    /// Calls `f` with u = L x and adds its time to `seconds`.
    fn timed<T>(&mut self, x: &[f64], f: impl FnOnce(&mut Self) -> T) -> T {
        let clock = Instant::now();
        for (u, x) in self.u.iter_mut().zip(x) {
            *u = x * self.length;
        }
        let result = f(self);
        self.seconds += clock.elapsed().as_secs_f64();
        result
    }

    /// Takes the start of a solve as an accepted point.
    pub fn begin(&mut self, x: &[f64]) {
        self.timed(x, |this| this.energy.domain(&this.u, &mut this.accepted));
    }

    /// f, infinite where the guard rejects x.
    pub fn value(&mut self, x: &[f64]) -> f64 {
        self.values += 1;
        self.timed(x, |this| {
            this.energy.domain(&this.u, &mut this.trial);
            let mut domain = this.trial.iter().zip(&this.accepted);
            if domain.any(|(d, accepted)| *d < Self::GUARD * accepted) {
                return f64::INFINITY;
            }
            this.energy.value(&this.u) / this.unit
        })
    }

    /// ∇f (n).
    pub fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.gradients += 1;
        self.timed(x, |this| {
            // Ipopt asks for gradients at accepted points only
            this.energy.domain(&this.u, &mut this.accepted);
            this.energy.gradient(&this.u, gradient);
            let scale = this.length / this.unit;
            gradient.iter_mut().for_each(|g| *g *= scale);
        });
    }

    /// `factor` times ∇²f, one value per position of the energy's pattern.
    pub fn hessian(&mut self, x: &[f64], factor: f64, values: &mut [f64]) {
        self.hessians += 1;
        self.timed(x, |this| {
            this.energy.hessian(&this.u, values);
            let scale = factor * this.length * this.length / this.unit;
            values.iter_mut().for_each(|v| *v *= scale);
        });
    }

    /// g = c/L (m).
    pub fn constraints(&mut self, x: &[f64], g: &mut [f64]) {
        self.timed(x, |this| {
            this.gaps.value(&this.u, g);
            g.iter_mut().for_each(|g| *g /= this.length);
        });
    }

    /// The nonzeros of C, which are those of ∇g.
    pub fn jacobian(&mut self, values: &mut [f64]) {
        let clock = Instant::now();
        let entries = values.iter_mut().zip(self.gaps.entries());
        entries.for_each(|(value, entry)| *value = entry.2);
        self.seconds += clock.elapsed().as_secs_f64();
    }

    /// The status of a run.
    pub fn solved(&self, run: &Run) -> Solved {
        match run.solution.status {
            _ if run.solved => Solved::Optimal,
            _ if self.stop.is_requested() => Solved::Interrupted,
            status if status.is_interrupted() => Solved::Interrupted,
            status => Solved::Failed(format!(
                "{status}, in units of {:.1e} for lengths and {:.1e} for energies",
                self.length, self.unit
            )),
        }
    }

    /// The cost of the solves, which took `wall` seconds in total.
    pub fn cost(&self, totals: &Totals, run: &Run, wall: f64) -> Cost {
        Cost {
            solves: totals.warm + totals.cold,
            cold_retries: totals.cold_retries,
            inner_iterations: totals.iterations,
            factorizations: totals.factorizations,
            values: self.values,
            gradients: self.gradients,
            hessians: self.hessians,
            reused_hessians: totals.iterations.saturating_sub(self.hessians),
            callbacks: self.seconds,
            optimizer: wall - self.seconds,
            wall,
            factor: run.solution.statistics.mumps.map(|mumps| FactorSize {
                ordering: mumps.ordering.name(),
                bytes: mumps.factor_bytes,
                workspace_bytes: mumps.workspace_bytes,
                reallocations: mumps.reallocations,
            }),
            ..Cost::default()
        }
    }
}

/// What Ipopt with these options takes on an energy; `None` without the library's linear layer, or with another linear
/// solver than MUMPS.
pub(crate) fn memory(energy: &dyn Energy, options: &Options) -> Option<MemoryNeed> {
    let is_mumps = match options.get("linear_solver") {
        Some(OptionValue::Text(name)) => name == "mumps",
        _ => true,
    };
    let percent = match options.get("mumps_mem_percent") {
        Some(OptionValue::Integer(percent)) => f64::from(*percent),
        Some(OptionValue::Number(percent)) => *percent,
        _ => Options::MEMORY_PERCENT.into(),
    };
    if !is_mumps {
        return None;
    }
    #[cfg(feature = "linear")]
    {
        let need = MemoryNeed::of_ipopt(energy.hessian_pattern(), percent).ok()?;
        Some(MemoryNeed {
            bytes: need.bytes + blas_bytes(),
            ..need
        })
    }
    #[cfg(not(feature = "linear"))]
    {
        let _ = (energy, percent, blas_bytes());
        None
    }
}

/// An error if the run has ended for want of memory: to solve again would end likewise.
pub(crate) fn check_memory(run: &Run, energy: &dyn Energy) -> Result<(), Error> {
    match run.solution.status {
        Status::InsufficientMemory => Err(Error::Memory(MemoryError::Exhausted {
            what: "Ipopt",
            unknowns: energy.dofs(),
        })),
        _ => Ok(()),
    }
}

/// Checks a tolerance relative to the scales.
pub(crate) fn check_tolerance(name: &'static str, tolerance: f64) -> Result<(), Error> {
    let is_share = tolerance > 0.0 && tolerance < 1.0;
    let remedy = "choose a value between 0 and 1; see the default";
    Error::check_setting(is_share, name, tolerance, remedy)
}

/// The given tolerance, or the smallest one that is above round-off at this scale.
pub(crate) fn attainable(tolerance: f64, scale: &Scale) -> f64 {
    tolerance.max(ABOVE_ROUNDOFF * scale.roundoff)
}

/// The options of Ipopt for scaled subproblems with these tolerances on the optimality error and on
/// complementarity. `warm` has the options of warm solves; `given` overrides all others.
pub(crate) fn settings(
    tolerance: f64,
    complementarity: f64,
    max_iterations: usize,
    warm: Options,
    given: &Options,
) -> SequenceSettings {
    let options = Options::new()
        .with("tol", tolerance)
        .with("compl_inf_tol", complementarity)
        .with("acceptable_tol", ATTAINABLE * tolerance)
        .with("acceptable_compl_inf_tol", ATTAINABLE * complementarity)
        .with("mu_strategy", "adaptive")
        .with("nlp_scaling_method", "none")
        .with("max_iter", max_iterations);
    SequenceSettings {
        options: options.and(given),
        warm: warm.and(given),
        attainable_error: ATTAINABLE * tolerance,
        ..SequenceSettings::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaps::{Row, RowKey};
    use crate::ipopt::{Solution, Statistics, Status};
    use crate::linear::SymmetricPattern;
    use crate::nlp::Bounds;

    struct Nothing(SymmetricPattern);

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
    }

    /// Whose domain function is its unknown.
    struct Positive(SymmetricPattern);

    impl Energy for Positive {
        fn dofs(&self) -> usize {
            1
        }
        fn value(&self, u: &[f64]) -> f64 {
            u[0]
        }
        fn gradient(&self, _: &[f64], g: &mut [f64]) {
            g[0] = 1.0;
        }
        fn hessian_pattern(&self) -> &SymmetricPattern {
            &self.0
        }
        fn hessian(&self, _: &[f64], _: &mut [f64]) {}
        fn domain_len(&self) -> usize {
            1
        }
        fn domain(&self, u: &[f64], d: &mut [f64]) {
            d[0] = u[0];
        }
    }

    /// A trial may not shrink the domain to less than a tenth of what it was when a gradient was last asked
    /// for. Multipliers are −λ L/E₀, those of new rows 0.
    #[test]
    fn trials_and_starts() {
        let energy = Positive(SymmetricPattern::diagonal(1));
        let (bounds, stop) = (Bounds::default(), Stop::new());
        let mut gaps = LinearGaps::new(true);
        for node in 0..2 {
            gaps.push(RowKey { pass: 0, node }, &Row::default());
        }
        let mut scaled = Scaled::new(&Subproblem {
            energy: &energy,
            bounds: &bounds,
            gaps: &gaps,
            scale: Scale {
                length: 0.5,
                energy: 8.0,
                ..Scale::default()
            },
            change: 1.0,
            accuracy: 0.0,
            stop: &stop,
        });
        scaled.begin(&[2.0]);
        assert_eq!(scaled.value(&[0.21]), 0.21 * 0.5 / 8.0);
        assert_eq!(scaled.value(&[0.19]), f64::INFINITY);
        let mut gradient = [0.0];
        scaled.gradient(&[0.5], &mut gradient);
        assert_eq!(gradient, [0.5 / 8.0]);
        assert!(scaled.value(&[0.19]).is_finite());
        assert_eq!(scaled.value(&[0.049]), f64::INFINITY);

        let mut known = LinearGaps::new(true);
        known.push(RowKey { pass: 0, node: 1 }, &Row::default());
        let state = State {
            u: vec![3.0],
            multipliers: crate::Multipliers::new(&known, &[4.0]),
        };
        assert_eq!(scaled.displacements(&state), [6.0]);
        let multipliers = scaled.multipliers(&state, 1);
        assert_eq!(multipliers.constraints, [0.0, -4.0 * 0.5 / 8.0]);
    }

    /// Ipopt's multipliers have the other sign; a force that would pull is none.
    #[test]
    fn forces_push_in_the_units_of_the_user() {
        let mut gaps = LinearGaps::new(true);
        for node in 0..3 {
            gaps.push(RowKey { pass: 0, node }, &Row::default());
        }
        let energy = Nothing(SymmetricPattern::diagonal(1));
        let (bounds, stop) = (Bounds::default(), Stop::new());
        let scaled = Scaled::new(&Subproblem {
            energy: &energy,
            bounds: &bounds,
            gaps: &gaps,
            scale: Scale {
                length: 0.5,
                energy: 8.0,
                ..Scale::default()
            },
            change: 1.0,
            accuracy: 0.0,
            stop: &stop,
        });
        let solution = Solution {
            status: Status::Solved,
            x: vec![3.0],
            objective: 2.0,
            g: vec![0.0; 3],
            multipliers: Some(Multipliers {
                constraints: vec![-2.0, 1e-9, 0.25],
                lower: vec![0.0],
                upper: vec![0.0],
            }),
            contradiction: None,
            statistics: Statistics::default(),
            history: Vec::new(),
            derivative_check: None,
            log_error: None,
        };
        let run = Run {
            solution,
            solved: true,
            warm: false,
            retried: None,
        };
        let minimum = scaled.minimum(run, Cost::default());
        assert_eq!(minimum.u, [1.5]);
        assert_eq!(minimum.lambda, [32.0, 0.0, 0.0]);
        assert_eq!(minimum.energy, 16.0);
        assert_eq!(minimum.solved, Solved::Optimal);
    }
}
