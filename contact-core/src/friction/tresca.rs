//! Tresca's law in a subproblem: the thresholds of an iteration, and the minimum of the energy with the work of friction.

use std::ops::Range;

use super::{Friction, SlipRows};
use crate::equilibrium::StepContext;
use crate::gaps::Row;
use crate::linear::SymmetricPattern;
use crate::method::{Method, Minimum, Subproblem};
use crate::{Bounds, Energy, Error, LinearGaps, Multipliers, RowKey, Scale, State};

/// The passes of the rows q − Δs ≥ 0 and q + Δs ≥ 0 are numbered after all passes of contact.
const PASSES: [u32; 2] = [1 << 30, 1 << 31];

/// The thresholds of an iteration, and where they come from.
pub(crate) struct Thresholds {
    rows: SlipRows,
    /// τ (p, UF).
    values: Vec<f64>,
}

impl Thresholds {
    /// Thresholds that are known by key.
    pub fn known(rows: SlipRows, known: &Multipliers) -> Self {
        let values = rows.keys().iter().map(|&key| known.of(key)).collect();
        Thresholds { rows, values }
    }

    /// Thresholds by the multipliers of the last state. Where none are known yet, at the start of a run, nodes that touch stick: a large
    /// force presses on them.
    pub fn first(rows: SlipRows, gaps: &LinearGaps, before: &State, scale: &Scale) -> Self {
        let touching = touching(gaps, &before.u, scale);
        let touches = |key: RowKey| touching.binary_search(&key).is_ok();
        let large = LARGE * scale.energy / scale.length;
        let values = match before.multipliers.is_empty() {
            true => rows.thresholds(|key| if touches(key) { large } else { 0.0 }),
            false => rows.thresholds(|key| before.multipliers.of(key)),
        };
        Thresholds { rows, values }
    }

    /// The friction of the iterate that these thresholds have led to, with the `forces` there; slips count since the last state of `context`.
    pub fn friction(self, forces: Vec<f64>, context: &StepContext<'_>) -> Friction {
        Friction {
            thresholds: self.values,
            rows: self.rows,
            forces,
            last: context.last.u.clone(),
            from: context.from,
        }
    }

    /// The minimum of `subproblem` with Tresca's law, and the forces of friction r (p, UF) there. `known` has the forces of the last
    /// iterate, for a warm start.
    pub fn minimize<M: Method>(
        &self,
        method: &mut M,
        subproblem: &Subproblem<'_>,
        start: &State,
        known: Option<&Friction>,
    ) -> Result<(Minimum, Vec<f64>), Error> {
        let (n, p) = (subproblem.energy.dofs(), self.rows.len());
        let energy = Tresca::new(subproblem.energy, &self.values);
        let slips = self.rows.slips(&start.u);
        let gaps = self.rows_of_both_signs(subproblem.gaps, n);
        let lifted = State {
            u: start
                .u
                .iter()
                .copied()
                .chain(slips.iter().map(|s| s.abs()))
                .collect(),
            multipliers: self.multipliers(subproblem.gaps, start, known),
        };
        let lifted_bounds = bounds(subproblem.bounds, p);
        let lifted_problem = Subproblem {
            energy: &energy,
            bounds: &lifted_bounds,
            gaps: &gaps,
            scale: Scale {
                resolution: SLIPS * subproblem.scale.resolution,
                ..subproblem.scale
            },
            ..*subproblem
        };
        let mut minimum = method.minimize(&lifted_problem, &lifted)?;
        Error::check_length("the method's u", &minimum.u, n + p)?;
        Error::check_length("the method's λ", &minimum.lambda, gaps.len())?;
        let m = subproblem.gaps.len();
        let [up, down] = [m..m + p, m + p..m + 2 * p].map(|own| &minimum.lambda[own]);
        let pairs = up.iter().zip(down).zip(&self.values);
        let forces = pairs.map(|((up, down), t)| (up - down).clamp(-t, *t));
        let forces = forces.collect();
        minimum.u.truncate(n);
        minimum.lambda.truncate(m);
        minimum.energy = subproblem.energy.value(&minimum.u);
        Ok((minimum, forces))
    }

    /// `gaps`, q_i − Δs_i ≥ 0 and q_i + Δs_i ≥ 0 over (u, q).
    fn rows_of_both_signs(&self, gaps: &LinearGaps, n: usize) -> LinearGaps {
        let mut all = gaps.clone();
        for (pass, sign) in PASSES.into_iter().zip([-1.0, 1.0]) {
            for i in 0..self.rows.len() {
                let slip = self.rows.row(i);
                let mut free: Vec<_> = slip.free.iter().map(|&(j, a)| (j, sign * a)).collect();
                free.push((n + i, 1.0));
                let row = Row {
                    free,
                    constant: sign * slip.constant,
                    ..Row::default()
                };
                let node = i as u32;
                all.push(RowKey { pass, node }, &row);
            }
        }
        all
    }

    /// The multipliers of the start: λ of contact, and (τ ± r)/2.
    fn multipliers(
        &self,
        gaps: &LinearGaps,
        start: &State,
        known: Option<&Friction>,
    ) -> Multipliers {
        if start.multipliers.is_empty() {
            return Multipliers::default();
        }
        let mut lambda: Vec<f64> = gaps
            .keys()
            .iter()
            .map(|&key| start.multipliers.of(key))
            .collect();
        let known = known.iter().flat_map(|own| {
            own.rows
                .keys()
                .iter()
                .copied()
                .zip(own.forces.iter().copied())
        });
        let known: Multipliers = known.collect();
        let forces: Vec<f64> = self.rows.keys().iter().map(|&key| known.of(key)).collect();
        for sign in [1.0, -1.0] {
            let pairs = self.values.iter().zip(&forces);
            lambda.extend(pairs.map(|(t, r)| 0.5 * (t + sign * r.clamp(-t, *t))));
        }
        Multipliers::new(&self.rows_of_both_signs(gaps, start.u.len()), &lambda)
    }
}

/// Slips are resolved to this share of the smallest displacement that matters: in contact that hardly slips, forces depend on slips that are much
/// smaller than the displacements which press it.
const SLIPS: f64 = 1e-2;
/// A large force, in units of the scale.
const LARGE: f64 = 1e3;
/// Nodes touch whose gap is below this share of the smallest displacement that matters.
const TOUCHING: f64 = 1e-3;

/// The keys of the rows that are closed at u, in order.
pub(super) fn touching(gaps: &LinearGaps, u: &[f64], scale: &Scale) -> Vec<RowKey> {
    let mut c = vec![0.0; gaps.len()];
    gaps.value(u, &mut c);
    let all = gaps.keys().iter().zip(c);
    let closed = all.filter(|(_, gap)| *gap <= TOUCHING * scale.resolution);
    let mut keys: Vec<RowKey> = closed.map(|(key, _)| *key).collect();
    keys.sort_unstable();
    keys
}

/// The same bounds on u, and none on q.
fn bounds(of_u: &Bounds, p: usize) -> Bounds {
    if of_u.is_empty() {
        return Bounds::default();
    }
    let more = |bounds: &[f64], value: f64| {
        let all = bounds.iter().copied();
        all.chain(std::iter::repeat_n(value, p)).collect()
    };
    Bounds {
        lower: more(&of_u.lower, f64::NEG_INFINITY),
        upper: more(&of_u.upper, f64::INFINITY),
    }
}

/// E(u) + Σ τ_i q_i over (u, q).
struct Tresca<'a> {
    energy: &'a dyn Energy,
    thresholds: &'a [f64],
    pattern: SymmetricPattern,
}

impl<'a> Tresca<'a> {
    fn new(energy: &'a dyn Energy, thresholds: &'a [f64]) -> Self {
        let slips = SymmetricPattern::diagonal(thresholds.len());
        Tresca {
            pattern: SymmetricPattern::direct_sum([energy.hessian_pattern(), &slips]),
            energy,
            thresholds,
        }
    }

    fn own(&self) -> usize {
        self.energy.dofs()
    }
}

impl Energy for Tresca<'_> {
    fn dofs(&self) -> usize {
        self.own() + self.thresholds.len()
    }

    fn value(&self, x: &[f64]) -> f64 {
        let (u, q) = x.split_at(self.own());
        let friction = self.thresholds.iter().zip(q).map(|(t, q)| t * q);
        self.energy.value(u) + friction.sum::<f64>()
    }

    fn gradient(&self, x: &[f64], g: &mut [f64]) {
        let n = self.own();
        let (of_u, of_q) = g.split_at_mut(n);
        self.energy.gradient(&x[..n], of_u);
        of_q.copy_from_slice(self.thresholds);
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    fn hessian(&self, x: &[f64], values: &mut [f64]) {
        let (of_u, of_q) = values.split_at_mut(self.energy.hessian_pattern().len());
        self.energy.hessian(&x[..self.own()], of_u);
        of_q.fill(0.0);
    }

    fn blocks(&self) -> Vec<Range<usize>> {
        let mut blocks = self.energy.blocks();
        let slips = self.own()..self.dofs();
        blocks.extend(slips.map(|q| q..q + 1));
        blocks
    }

    fn is_quadratic(&self) -> bool {
        self.energy.is_quadratic()
    }

    fn domain_len(&self) -> usize {
        self.energy.domain_len()
    }

    fn domain(&self, x: &[f64], d: &mut [f64]) {
        self.energy.domain(&x[..self.own()], d);
    }
}
