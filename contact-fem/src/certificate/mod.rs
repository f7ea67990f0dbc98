//! "Did it really converge?": what a step is worth, computed anew from its result.

mod state;

/// How well a state satisfies what defines a solution, from scratch: it is projected once more, at
/// the state itself, and no residual of the solver is used.
///
/// All of it is dimensionless. Lengths are over the mean facet around a node; what is left of weak
/// gaps is over the displacement of such a facet that matters, which is less by
/// [`Scale::resolution`](contact_core::Scale) over the smallest facet: stiff bodies move by a tiny
/// part of their facets, and may not penetrate by more. Forces are over the largest force on a node of
/// the same body, be it contact, support or load, but at least over a ten thousandth of
/// [`Scale`](contact_core::Scale)'s energy over its length: when bodies begin to touch there is next to no force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// How deep the deepest contact node is inside another surface, over all passes of the scene.
    /// Weak constraints allow a little, and more where corners meet.
    pub nodal_penetration: f64,
    /// max(−c_i) over all rows at the state, of all passes of the scene.
    pub weak_penetration: f64,
    /// The same over the passes that the scene leaves out, which has no limit: what a single pass lets
    /// through on its other side. Nothing where every pair has both.
    pub other_side: Option<f64>,
    /// max(−λ_i): contact pushes and never pulls.
    pub adhesion: f64,
    /// max |λ_i c_i|, with [`Scale::resolution`](contact_core::Scale) for a length.
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
    /// Contact nodes that had no row; of method (39), whose rows are points, those that have none at
    /// the state.
    pub dropped: usize,
    /// Rows that the state does have, the solver did not, and that are not open by more than the
    /// default limit of the weak penetration. Where points have no lasting names, which is method (39)
    /// with exact integration: passes whose points covered a ten thousandth less of what is closed.
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
    /// Nothing is left of anything.
    #[cfg(test)]
    pub(crate) fn flawless() -> Self {
        Certificate {
            nodal_penetration: 0.0,
            weak_penetration: 0.0,
            other_side: None,
            adhesion: 0.0,
            complementarity: 0.0,
            stationarity: 0.0,
            drift: None,
            action_reaction: 0.0,
            balance: 0.0,
            min_j: 1.0,
            dropped: 0,
            closed: 0,
            roundoff: 0.0,
        }
    }

    /// Of something that is no state at all, with a NaN or an infinite value: nothing holds.
    fn of_no_state() -> Self {
        Certificate {
            nodal_penetration: f64::NAN,
            weak_penetration: f64::NAN,
            other_side: None,
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
        let or_worse = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(worse(a, b)),
            _ => a.or(b),
        };
        Certificate {
            nodal_penetration: worse(self.nodal_penetration, other.nodal_penetration),
            weak_penetration: worse(self.weak_penetration, other.weak_penetration),
            other_side: or_worse(self.other_side, other.other_side),
            adhesion: worse(self.adhesion, other.adhesion),
            complementarity: worse(self.complementarity, other.complementarity),
            stationarity: worse(self.stationarity, other.stationarity),
            drift: or_worse(self.drift, other.drift),
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
        if let Some(depth) = self.other_side {
            write!(f, "\n    {:<18} {depth:>8.1e} without limit", "other side")?;
        }
        write!(f, "\n    {:<18} {:>8}", "rows dropped", self.dropped)
    }
}
