//! Where a step ends that may not leave the domain of the energy.

use std::time::Instant;

use super::super::condensed::halt::Halt;
use super::linearization::Linearization;
use super::step::Step;
use crate::{Cost, Energy, State};

/// A step may not take a domain function below this share of its value.
const GUARD: f64 = 0.1;
/// A step is halved at most so often.
pub(super) const HALVINGS: usize = 20;

/// The end of a step.
pub(super) struct Trial {
    /// u + t x.
    pub(super) u: Vec<f64>,
    /// λ + t (μ − λ) of the rows at u (UF).
    pub(super) lambda: Vec<f64>,
    /// t.
    pub(super) share: f64,
    /// E(u + t x) (UF·UL).
    pub(super) energy: f64,
    /// Whether the step took account of how rows vary.
    pub(super) varies: bool,
}

impl Trial {
    /// t is the largest of `limit` times 1, ½, ¼ … at which the energy is finite and all domain functions are above [`GUARD`]
    /// times their values at u.
    pub(super) fn new(
        energy: &dyn Energy,
        here: &Linearization<'_>,
        from: &State,
        step: &Step,
        limit: f64,
        cost: &mut Cost,
    ) -> Result<Self, Halt> {
        let clock = Instant::now();
        let domain = |u: &[f64]| {
            let mut d = vec![0.0; energy.domain_len()];
            energy.domain(u, &mut d);
            d
        };
        let now = domain(&from.u);
        let along = |share: f64, a: &[f64], x: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            a.iter().zip(x).map(|(a, x)| a + share * x).collect()
        };
        let mut share = limit;
        for _ in 0..HALVINGS {
            let u = along(share, &from.u, &mut step.x.iter().copied());
            let (inside, value) = (domain(&u), energy.value(&u));
            cost.values += 1;
            let is_inside = inside.iter().zip(&now).all(|(d, now)| *d > GUARD * now);
            if is_inside && value.is_finite() {
                cost.callbacks += clock.elapsed().as_secs_f64();
                let change = step.lambda.iter().zip(&here.lambda);
                let mut change = change.map(|(m, l)| m - l);
                return Ok(Trial {
                    u,
                    lambda: along(share, &here.lambda, &mut change),
                    share,
                    energy: value,
                    varies: true,
                });
            }
            share *= 0.5;
        }
        cost.callbacks += clock.elapsed().as_secs_f64();
        Err(Halt::Failed(
            "Newton's step leaves the domain of the energy, however short".into(),
        ))
    }
}
