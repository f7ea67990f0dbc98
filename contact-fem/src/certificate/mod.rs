//! "Did it really converge?": what a step is worth, computed anew from its result.

mod state;

use std::fmt;

/// A condition that a solution satisfies. What is left of it is dimensionless.
///
/// Lengths are over the mean facet around a node; weak gaps over the displacement of such a facet that matters, which is
/// less by [`Scale::resolution`](contact_core::Scale) over the smallest facet: stiff bodies move by a tiny part of their
/// facets, and may not penetrate by more. Forces are over the largest force on a node of the same body, be it contact,
/// support or load, but at least over a ten thousandth of [`Scale`](contact_core::Scale)'s energy over its length: when
/// bodies begin to touch there is next to no force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Condition {
    /// No contact node is inside another surface: the largest depth, over all passes of the scene. Weak constraints
    /// allow a little, and more where corners meet.
    NodalPenetration,
    /// No weak gap is negative: max(−c_i) over all rows at the state, of all passes of the scene.
    WeakPenetration,
    /// Contact pushes and never pulls: max(−λ_i).
    Adhesion,
    /// Forces act at closed gaps only: max |λ_i c_i|, with [`Scale::resolution`](contact_core::Scale) for a length.
    Complementarity,
    /// The energy is stationary: max |∇E − Cᵀλ| over the unknowns that no support holds, with the solver's rows.
    Stationarity,
    /// One more iteration would not change the forces: max |Cᵀλ − C'ᵀλ|, C' the rows at the state. Nothing where the
    /// rows of the two have no names in common: method (39) with exact integration.
    Drift,
    /// Contact forces come in pairs: |Σ Cᵀλ| over all bodies, of Σ |Cᵀλ|.
    ActionReaction,
    /// All forces are in balance: |Σ reactions + Σ loads| over the sum of their magnitudes.
    Balance,
    /// No element is inverted: the number of points with J ≤ 0.
    Inverted,
    /// The solver had every closed row: the number of closed constraints present at the solution but missing from the
    /// solver's rows. A row is closed if it is not open by more than the default limit of the weak penetration. For
    /// method (39) with exact integration, whose points have no lasting names: the passes whose closed points covered a
    /// ten thousandth less of the surface.
    Closed,
    /// The same as [`Condition::WeakPenetration`] over the passes that the scene leaves out, without a limit: what a
    /// single pass lets through on its other side. Nothing where every pair has both.
    OtherSide,
    /// Contact nodes without a row, without a limit; of method (39), whose rows are points, those without one at the
    /// state.
    Dropped,
}

/// One line of the table of conditions.
struct Line {
    condition: Condition,
    name: &'static str,
    /// For the default tolerance of the fixed point, 1e-6, and twice what penalties leave by default.
    limit: f64,
    /// Whether round-off in forces at strains as small as the scene's is told by this condition.
    sees_roundoff: bool,
}

const fn line(condition: Condition, name: &'static str, limit: f64) -> Line {
    Line {
        condition,
        name,
        limit,
        sees_roundoff: matches!(
            condition,
            Condition::Stationarity | Condition::Drift | Condition::Balance
        ),
    }
}

/// The table that limits, files and summaries are made from, in the order of [`Condition`].
const TABLE: [Line; 12] = [
    line(Condition::NodalPenetration, "nodal_penetration", 0.2),
    line(Condition::WeakPenetration, "weak_penetration", 2e-3),
    line(Condition::Adhesion, "adhesion", 1e-9),
    line(Condition::Complementarity, "complementarity", 2e-3),
    line(Condition::Stationarity, "stationarity", 1e-6),
    line(Condition::Drift, "drift", 1e-4),
    line(Condition::ActionReaction, "action_reaction", 1e-9),
    line(Condition::Balance, "balance", 1e-6),
    line(Condition::Inverted, "inverted", 0.0),
    line(Condition::Closed, "closed", 0.0),
    line(Condition::OtherSide, "other_side", f64::INFINITY),
    line(Condition::Dropped, "dropped", f64::INFINITY),
];

impl Condition {
    /// All conditions, in the order of files and summaries.
    pub fn all() -> impl ExactSizeIterator<Item = Condition> {
        TABLE.iter().map(|line| line.condition)
    }

    /// Its name in files and summaries.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].name
    }
}

/// How well a state satisfies the conditions of a solution, from scratch: it is projected once more, at the state
/// itself, and no residual of the solver is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// What is left of each condition; nothing of one that does not apply.
    left: [Option<f64>; TABLE.len()],
    /// Round-off in forces at strains as small as the scene's, of [`Scale::roundoff`](contact_core::Scale).
    roundoff: f64,
}

/// What may be left of each condition if a certificate is to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits([f64; TABLE.len()]);

impl Default for Limits {
    fn default() -> Self {
        Limits(std::array::from_fn(|k| TABLE[k].limit))
    }
}

impl Limits {
    /// The limit of a condition, infinite for none.
    pub fn of(&self, condition: Condition) -> f64 {
        self.0[condition as usize]
    }

    /// The same limits but for one.
    #[must_use]
    pub fn with(mut self, condition: Condition, limit: f64) -> Self {
        self.0[condition as usize] = limit;
        self
    }
}

/// One line of a certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The condition's name.
    pub name: &'static str,
    /// What is left of it, or nothing if it does not apply.
    pub value: Option<f64>,
    /// What may be left at most.
    pub limit: f64,
}

impl Entry {
    /// Whether the value keeps the limit; NaN does not.
    pub fn holds(&self) -> bool {
        self.value.is_none_or(|value| value <= self.limit)
    }
}

impl Certificate {
    /// With the same left of every condition.
    pub(crate) fn uniform(left: f64, roundoff: f64) -> Self {
        Certificate {
            left: [Some(left); TABLE.len()],
            roundoff,
        }
    }

    /// The same but for one condition.
    #[must_use]
    pub(crate) fn with(mut self, condition: Condition, left: Option<f64>) -> Self {
        self.left[condition as usize] = left;
        self
    }

    /// What is left of a condition, or nothing if it does not apply.
    pub fn left(&self, condition: Condition) -> Option<f64> {
        self.left[condition as usize]
    }

    /// Round-off in forces at strains as small as the scene's: no limit below ten times that is asked for.
    pub fn roundoff(&self) -> f64 {
        self.roundoff
    }

    /// What is left of every condition, beside its limit.
    pub fn entries(&self, limits: &Limits) -> impl ExactSizeIterator<Item = Entry> + use<> {
        let attainable = 10.0 * self.roundoff;
        let lines = TABLE.iter().zip(self.left).zip(limits.0);
        lines.map(move |((line, value), limit)| Entry {
            name: line.name,
            value,
            limit: match line.sees_roundoff {
                true => limit.max(attainable),
                false => limit,
            },
        })
    }

    /// Whether every condition is kept to its limit.
    pub fn holds(&self, limits: &Limits) -> bool {
        self.entries(limits).all(|entry| entry.holds())
    }

    /// Condition by condition the worse of two, for a run of many steps.
    #[must_use]
    pub fn or_worse(self, other: Self) -> Self {
        // a NaN is worse than any number
        let worse = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
        Certificate {
            left: std::array::from_fn(|k| match (self.left[k], other.left[k]) {
                (Some(a), Some(b)) => Some(worse(a, b)),
                (a, b) => a.or(b),
            }),
            roundoff: worse(self.roundoff, other.roundoff),
        }
    }
}

/// A line a condition, those beyond their limits marked, under a line that says whether all hold.
impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limits = Limits::default();
        let holds = self.holds(&limits);
        write!(f, "{}", if holds { "holds" } else { "DOES NOT HOLD" })?;
        for entry in self.entries(&limits) {
            let Entry { name, value, limit } = entry;
            match value {
                _ if limit == f64::INFINITY => {
                    let Some(value) = value else { continue };
                    write!(f, "\n    {name:<18} {value:>8.1e} without limit")?;
                }
                Some(value) => {
                    let mark = if entry.holds() { "" } else { "  <- too large" };
                    write!(f, "\n    {name:<18} {value:>8.1e} of {limit:>7.1e}{mark}")?;
                }
                None => write!(f, "\n    {name:<18} {:>8} of {limit:>7.1e}", "-")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_conditions() {
        for (k, line) in TABLE.iter().enumerate() {
            assert_eq!(line.condition as usize, k, "{}", line.name);
        }
    }

    /// Whatever is left of any one condition beyond its limit, the certificate does not hold; nor with a NaN.
    #[test]
    fn every_limit_counts() {
        let (limits, flawless) = (Limits::default(), Certificate::uniform(0.0, 0.0));
        assert!(flawless.holds(&limits));
        for condition in Condition::all().filter(|c| limits.of(*c).is_finite()) {
            let limit = limits.of(condition);
            let at = |left| flawless.with(condition, Some(left)).holds(&limits);
            assert!(
                at(limit) && !at(limit + 1e-9) && !at(f64::NAN),
                "{condition:?}"
            );
            let wider = limits.with(condition, 2.0);
            assert!(flawless.with(condition, Some(2.0)).holds(&wider));
        }
    }

    /// Of two certificates the worse value counts, whichever comes first, and a NaN stays.
    #[test]
    fn the_worse_of_two() {
        let flawless = Certificate::uniform(0.0, 0.0);
        for condition in Condition::all() {
            for bad in [0.5, f64::NAN] {
                let worse = flawless.with(condition, Some(bad));
                for both in [worse.or_worse(flawless), flawless.or_worse(worse)] {
                    let left = both.left(condition).expect("kept");
                    assert!(
                        left == bad || bad.is_nan() && left.is_nan(),
                        "{condition:?}"
                    );
                }
            }
            let absent = flawless.with(condition, None);
            assert_eq!(absent.or_worse(flawless).left(condition), Some(0.0));
        }
    }
}
