//! "Did it really converge?": what a step is worth, computed anew from its result.

use std::collections::HashSet;

use contact_core::fixed_point::Solution;
use contact_core::gaps::Sampling;
use contact_core::{ContactProblem, LinearGaps, Multipliers, RowKey};

use crate::scene::Problem;
use crate::tensor::Vector;

/// How well a state satisfies what defines a solution, from scratch: it is projected once more, at
/// the state itself, and no residual of the solver is used.
///
/// All of it is dimensionless. Lengths are over the local facet size, which is the mean facet
/// around a node, or a_i^{1/(D−1)} of a row. Forces are over the largest force on a node, be it
/// contact, support or load, but at least over a thousandth of what would move a facet by
/// [`Scale::resolution`](contact_core::Scale): when bodies begin to touch there is next to no force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// How deep the deepest contact node is inside another surface, over all passes of the scene.
    /// Weak constraints allow a little, and more where corners meet.
    pub nodal_penetration: f64,
    /// max(−c_i) over all rows at the state, of all passes of the scene.
    pub weak_penetration: f64,
    /// max(−λ_i): contact pushes and never pulls.
    pub adhesion: f64,
    /// max |λ_i c_i|, with the smallest facet for a length.
    pub complementarity: f64,
    /// max |∇E − Cᵀλ| over the unknowns that no support holds, with the solver's rows.
    pub stationarity: f64,
    /// max |Cᵀλ − C'ᵀλ| with C' the rows at the state itself: what one more iteration of the fixed
    /// point would see change in the forces. Nothing where the rows of the two have no names in
    /// common: method (39) with exact integration.
    pub drift: Option<f64>,
    /// |Σ Cᵀλ| over all bodies, of Σ |Cᵀλ|: contact forces come in pairs.
    pub action_reaction: f64,
    /// |Σ reactions + Σ loads| over the sum of their magnitudes.
    pub balance: f64,
    /// The smallest volume ratio, infinite for small-strain laws.
    pub min_j: f64,
    /// Contact nodes that had no row.
    pub dropped: usize,
    /// Of these, rows that the state does have and that are not open by more than the default limit
    /// of the weak penetration.
    pub closed: usize,
    /// What round-off leaves of forces at strains as small as the scene's, of
    /// [`Scale::roundoff`](contact_core::Scale): no limit is asked for that is below ten times that.
    pub roundoff: f64,
}

/// What a certificate must keep to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// For [`Certificate::nodal_penetration`].
    pub nodal_penetration: f64,
    /// For [`Certificate::weak_penetration`].
    pub weak_penetration: f64,
    /// For [`Certificate::adhesion`].
    pub adhesion: f64,
    /// For [`Certificate::complementarity`].
    pub complementarity: f64,
    /// For [`Certificate::stationarity`].
    pub stationarity: f64,
    /// For [`Certificate::drift`].
    pub drift: f64,
    /// For [`Certificate::action_reaction`].
    pub action_reaction: f64,
    /// For [`Certificate::balance`].
    pub balance: f64,
}

impl Default for Limits {
    /// For the default tolerance of the fixed point, 1e-6, and twice what penalties leave by default.
    fn default() -> Self {
        Limits {
            nodal_penetration: 0.2,
            weak_penetration: 2e-3,
            adhesion: 1e-9,
            complementarity: 2e-3,
            stationarity: 1e-6,
            drift: 1e-4,
            action_reaction: 1e-9,
            balance: 1e-6,
        }
    }
}

/// One line of a certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its name, as in [`Certificate`].
    pub name: &'static str,
    /// What was found, or nothing if it does not apply.
    pub value: Option<f64>,
    /// What it may be at most.
    pub limit: f64,
}

impl Entry {
    /// Whether the value keeps the limit; NaN does not.
    pub fn holds(&self) -> bool {
        self.value.is_none_or(|value| value <= self.limit)
    }
}

impl Certificate {
    /// The share of a typical force below which forces are not resolved.
    const NOTICED: f64 = 1e-3;

    /// Of the state `solution` of `problem`, which must be at the load that belongs to it.
    pub fn new<const D: usize>(problem: &Problem<D>, solution: &Solution) -> Self {
        let u = &solution.state.u;
        let (gaps, lambda) = (&solution.gaps, &solution.lambda);
        if !u.iter().chain(lambda).all(|value| value.is_finite()) {
            return Self::of_no_state();
        }
        let multipliers = Multipliers::new(gaps, lambda);
        let rows = problem.rows(u, Sampling::Nodes);
        let forces = problem.contact_forces(gaps, lambda);
        let residual = Residual::new(problem, u, &forces);
        let scale = problem.scale();
        let noticed = Self::NOTICED * scale.energy / scale.length.powi(2) * scale.resolution;
        let force = residual.largest.max(noticed);
        let over = |value: f64, unit: f64| if value == 0.0 { 0.0 } else { value / unit };

        let size = |weight: &f64| weight.powf(1.0 / (D as f64 - 1.0));
        let c = values(&rows, u).into_iter();
        let relative: Vec<f64> = c.zip(rows.weights()).map(|(c, w)| c / size(w)).collect();
        // rows of the solver's kind at the state: one a node, or one a point
        let points;
        let (same, closed, present) = match gaps.sampling() {
            Sampling::Nodes => (&rows, closed(&rows, &relative, gaps), gaps.len()),
            Sampling::Points => {
                points = problem.rows(u, Sampling::Points);
                (&points, 0, rows.len())
            }
        };
        Certificate {
            nodal_penetration: problem.relative_penetration(u),
            weak_penetration: relative.iter().fold(0.0, |depth, c| depth.max(-c)),
            adhesion: over(lambda.iter().fold(0.0, |most: f64, l| most.max(-l)), force),
            complementarity: {
                let facet = size(&scale.area);
                over(complementarity(same, &multipliers, u), force * facet)
            },
            stationarity: over(residual.free, force),
            drift: problem.has_lasting_names(gaps.sampling()).then(|| {
                let lambda: Vec<f64> = same.keys().iter().map(|&k| multipliers.of(k)).collect();
                let now = problem.contact_forces(same, &lambda);
                let change = forces.iter().zip(&now).map(|(a, b)| (a - b).amax());
                over(change.fold(0.0, f64::max), force)
            }),
            action_reaction: {
                let all: Vector<D> = forces.iter().sum();
                let magnitude: f64 = forces.iter().map(Vector::norm).sum();
                over(all.norm(), magnitude.max(force))
            },
            balance: over(residual.sum, residual.magnitude.max(force)),
            min_j: problem.min_j(u),
            dropped: problem.contact_nodes().saturating_sub(present),
            closed,
            roundoff: scale.roundoff,
        }
    }

    /// Of something that is no state at all, with a NaN or an infinite value: nothing holds.
    fn of_no_state() -> Self {
        Certificate {
            nodal_penetration: f64::NAN,
            weak_penetration: f64::NAN,
            adhesion: f64::NAN,
            complementarity: f64::NAN,
            stationarity: f64::NAN,
            drift: Some(f64::NAN),
            action_reaction: f64::NAN,
            balance: f64::NAN,
            min_j: f64::NAN,
            dropped: 0,
            closed: 0,
            roundoff: 0.0,
        }
    }

    /// Every value that has a limit, beside it.
    pub fn entries(&self, limits: &Limits) -> [Entry; 10] {
        let attainable = |limit: f64| limit.max(10.0 * self.roundoff);
        let inverted = self.min_j <= 0.0 || self.min_j.is_nan();
        let entry = |name, value, limit| Entry {
            name,
            value: Some(value),
            limit,
        };
        [
            entry(
                "nodal_penetration",
                self.nodal_penetration,
                limits.nodal_penetration,
            ),
            entry(
                "weak_penetration",
                self.weak_penetration,
                limits.weak_penetration,
            ),
            entry("adhesion", self.adhesion, limits.adhesion),
            entry(
                "complementarity",
                self.complementarity,
                limits.complementarity,
            ),
            entry(
                "stationarity",
                self.stationarity,
                attainable(limits.stationarity),
            ),
            Entry {
                name: "drift",
                value: self.drift,
                limit: attainable(limits.drift),
            },
            entry(
                "action_reaction",
                self.action_reaction,
                limits.action_reaction,
            ),
            entry("balance", self.balance, attainable(limits.balance)),
            entry("inverted", f64::from(u8::from(inverted)), 0.0),
            entry("closed", self.closed as f64, 0.0),
        ]
    }

    /// Whether every value keeps its limit.
    pub fn holds(&self, limits: &Limits) -> bool {
        self.entries(limits).iter().all(Entry::holds)
    }

    /// Value by value the worse of two, for a run of many steps.
    #[must_use]
    pub fn or_worse(self, other: Self) -> Self {
        // a NaN is worse than any number
        let worse = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
        Certificate {
            nodal_penetration: worse(self.nodal_penetration, other.nodal_penetration),
            weak_penetration: worse(self.weak_penetration, other.weak_penetration),
            adhesion: worse(self.adhesion, other.adhesion),
            complementarity: worse(self.complementarity, other.complementarity),
            stationarity: worse(self.stationarity, other.stationarity),
            drift: match (self.drift, other.drift) {
                (Some(a), Some(b)) => Some(worse(a, b)),
                (a, b) => a.or(b),
            },
            action_reaction: worse(self.action_reaction, other.action_reaction),
            balance: worse(self.balance, other.balance),
            min_j: -worse(-self.min_j, -other.min_j),
            dropped: self.dropped.max(other.dropped),
            closed: self.closed.max(other.closed),
            roundoff: worse(self.roundoff, other.roundoff),
        }
    }
}

/// A line a value that has a limit, those beyond it marked, under a line that says whether all hold.
impl std::fmt::Display for Certificate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let limits = Limits::default();
        let holds = self.holds(&limits);
        write!(f, "{}", if holds { "holds" } else { "DOES NOT HOLD" })?;
        for entry in self.entries(&limits) {
            let value = entry
                .value
                .map_or("-".into(), |value| format!("{value:.1e}"));
            let mark = if entry.holds() { "" } else { "  <- too large" };
            let Entry { name, limit, .. } = entry;
            write!(f, "\n    {name:<18} {value:>8} of {limit:>7.1e}{mark}")?;
        }
        write!(f, "\n    {:<18} {:>8}", "rows dropped", self.dropped)
    }
}

/// c(u) (UL).
fn values(rows: &LinearGaps, u: &[f64]) -> Vec<f64> {
    let mut c = vec![0.0; rows.len()];
    rows.value(u, &mut c);
    c
}

/// How many rows at the state, whose gaps over their sizes are `relative`, are not open and not
/// among those of the solver.
fn closed(rows: &LinearGaps, relative: &[f64], solver: &LinearGaps) -> usize {
    let named: HashSet<&RowKey> = solver.keys().iter().collect();
    let limit = Limits::default().weak_penetration;
    let gaps = rows.keys().iter().zip(relative);
    gaps.filter(|(key, c)| **c < limit && !named.contains(key))
        .count()
}

/// max |λ_i c_i| (UF·UL).
fn complementarity(rows: &LinearGaps, multipliers: &Multipliers, u: &[f64]) -> f64 {
    let c = values(rows, u);
    let products = rows.keys().iter().zip(&c);
    let products = products.map(|(&key, c)| (multipliers.of(key) * c).abs());
    products.fold(0.0, f64::max)
}

/// What is left of ∂E/∂U − Cᵀλ.
struct Residual {
    /// The largest component that no support holds (UF).
    free: f64,
    /// The largest force on a node (UF).
    largest: f64,
    /// |Σ reactions + Σ loads| and the sum of their components' magnitudes (UF).
    sum: f64,
    magnitude: f64,
}

impl Residual {
    fn new<const D: usize>(problem: &Problem<D>, u: &[f64], contact: &[Vector<D>]) -> Self {
        let (mut free, mut largest) = (0.0, 0.0);
        let (mut sum, mut magnitude) = (Vector::<D>::zeros(), 0.0);
        for (body, owner) in problem.scene().bodies().iter().enumerate() {
            let residual = problem.residual(body, u);
            for (k, node) in problem.nodes(body).enumerate() {
                for i in 0..D {
                    let dof = D * k + i;
                    let rest: f64 = residual[dof] - contact[node][i];
                    let load = problem.load() * owner.forces()[dof];
                    let reaction = match owner.prescribed()[dof] {
                        Some(_) => rest,
                        None => 0.0,
                    };
                    free = (rest - reaction).abs().max(free);
                    sum[i] += load + reaction;
                    magnitude += (load + reaction).abs();
                    for force in [load, reaction, contact[node][i]] {
                        largest = force.abs().max(largest);
                    }
                }
            }
        }
        Residual {
            free,
            largest,
            sum: sum.norm(),
            magnitude,
        }
    }
}
