//! E(u) in numbers that are O(1): x = u/L, f = E/E₀, and the guard of its domain.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{Effort, Factor, Solved, Subproblem};
use crate::Energy;
use crate::ipopt::{Run, Totals};

/// The energy of a subproblem as Ipopt sees it, and what evaluating it has cost. The x of its
/// functions may go on after the n displacements.
pub(super) struct ScaledEnergy<'a> {
    energy: &'a dyn Energy,
    /// L (UL) and E₀ (UF·UL).
    pub length: f64,
    pub unit: f64,
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

impl<'a> ScaledEnergy<'a> {
    /// The J guard: a trial with a domain function below this share of its last accepted value is
    /// inadmissible.
    const GUARD: f64 = 0.1;

    pub fn new(subproblem: &Subproblem<'a>, stop: Option<&'a AtomicBool>) -> Self {
        let energy = subproblem.energy;
        ScaledEnergy {
            energy,
            length: subproblem.scale.length,
            unit: subproblem.scale.energy,
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

    /// n.
    pub fn dofs(&self) -> usize {
        self.u.len()
    }

    pub fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// A force (UF) from one in Ipopt's numbers.
    pub fn force(&self, scaled: f64) -> f64 {
        scaled * self.unit / self.length
    }

    /// Runs `f` on the energy and u = L x, and counts the time.
    pub fn timed<T>(&mut self, x: &[f64], f: impl FnOnce(&mut Self) -> T) -> T {
        let clock = Instant::now();
        for (u, x) in self.u.iter_mut().zip(x) {
            *u = x * self.length;
        }
        let result = f(self);
        self.seconds += clock.elapsed().as_secs_f64();
        result
    }

    /// u, within [`ScaledEnergy::timed`].
    pub fn u(&self) -> &[f64] {
        &self.u
    }

    /// Where a solve begins counts as accepted.
    pub fn begin(&mut self, x: &[f64]) {
        self.timed(x, |this| this.energy.domain(&this.u, &mut this.accepted));
    }

    /// f, infinite where the guard refuses x.
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

    /// `factor` times ∇²f, one value a position of the energy's pattern.
    pub fn hessian(&mut self, x: &[f64], factor: f64, values: &mut [f64]) {
        self.hessians += 1;
        self.timed(x, |this| {
            this.energy.hessian(&this.u, values);
            let scale = factor * this.length * this.length / this.unit;
            values.iter_mut().for_each(|v| *v *= scale);
        });
    }

    /// How a run ended.
    pub fn solved(&self, run: &Run) -> Solved {
        match run.solution.status {
            _ if run.solved => Solved::Optimal,
            _ if self.is_stopped() => Solved::Interrupted,
            status => Solved::Failed(status.to_string()),
        }
    }

    /// What the solves cost, of `wall` seconds in all.
    pub fn effort(&self, totals: &Totals, run: &Run, wall: f64) -> Effort {
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
}
