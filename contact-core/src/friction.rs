//! Coulomb's law of friction, as Tresca's law with thresholds that follow the forces of contact.
//!
//! The slip of a contact node since the last converged state is a length, Δs = T u + d. Friction resists it by a force r
//! (UF) that is at most a threshold τ, and equal to τ, against the slip, where the node slips: r ∈ τ ∂|Δs|. For given τ this
//! is Tresca's law, and the increment minimises
//!
//! E(u) + Σ τ_i |Δs_i(u)|   subject to   C u + c₀ ≥ 0,
//!
//! whose minimum has ∇E + Tᵀr = Cᵀλ. Coulomb's law has τ_i = μ_i λ_i, with a bound on the shear force where there is
//! one. The multipliers λ are those of the minimum itself. `Condensed` and `CondensedNewton` solve for both together, on the compliance of their rows. For
//! [`FixedPoint`](crate::FixedPoint), the thresholds are unknowns of the iteration: it takes them from the multipliers of the iterate before, as it takes projections and normals.
//!
//! There, the terms |Δs_i| are exact: with further unknowns q_i and the rows q_i − Δs_i ≥ 0 and q_i + Δs_i ≥ 0, the energy
//! E(u) + Σ τ_i q_i is as smooth as E, and any [`Method`](crate::Method) minimises it. The multipliers of the two rows differ by r_i.

mod search;
mod tresca;

pub(crate) use search::Search;
pub(crate) use tresca::Thresholds;
use tresca::touching;

#[cfg(feature = "linear")]
use crate::Multipliers;
#[cfg(feature = "linear")]
use crate::equilibrium::StepContext;
use crate::gaps::SparseRows;
use crate::{Error, RowKey};

/// How contact nodes slip, and how much friction they have: one row of T for each row of gaps that has friction.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct SlipRows {
    keys: Vec<RowKey>,
    free: SparseRows,
    prescribed: SparseRows,
    constant: Vec<f64>,
    coefficient: Vec<f64>,
    bound: Vec<f64>,
}

/// One row, to be appended to [`SlipRows`].
#[derive(Clone, Debug)]
pub struct SlipRow {
    /// Coefficients of free unknowns.
    pub free: Vec<(usize, f64)>,
    /// Coefficients of prescribed unknowns; `constant` already contains their contribution.
    pub prescribed: Vec<(usize, f64)>,
    /// d (UL): minus T times the last converged u, and what prescribed unknowns and obstacles have moved since.
    pub constant: f64,
    /// μ ≥ 0, the coefficient of friction.
    pub coefficient: f64,
    /// The largest force of friction (UF), whatever the pressure; infinite for Coulomb's law alone.
    pub bound: f64,
}

impl Default for SlipRow {
    fn default() -> Self {
        SlipRow {
            free: Vec::new(),
            prescribed: Vec::new(),
            constant: 0.0,
            coefficient: 0.0,
            bound: f64::INFINITY,
        }
    }
}

impl SlipRows {
    /// Appends the slip of the node whose row of gaps has this key; a key may come once.
    pub fn push(&mut self, key: RowKey, row: &SlipRow) {
        self.keys.push(key);
        self.free.push(&row.free);
        self.prescribed.push(&row.prescribed);
        self.constant.push(row.constant);
        self.coefficient.push(row.coefficient);
        self.bound.push(row.bound);
    }

    /// The number of rows (p).
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The key of the row of gaps whose force presses on each row (p).
    pub fn keys(&self) -> &[RowKey] {
        &self.keys
    }

    /// T (p × n).
    pub fn matrix(&self) -> &SparseRows {
        &self.free
    }

    /// d (p, UL).
    pub fn constant(&self) -> &[f64] {
        &self.constant
    }

    /// μ (p).
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficient
    }

    /// The largest forces of friction (p, UF).
    pub fn bounds(&self) -> &[f64] {
        &self.bound
    }

    /// A copy of row `i`, to be appended elsewhere.
    pub fn row(&self, i: usize) -> SlipRow {
        SlipRow {
            free: self.free.row(i).collect(),
            prescribed: self.prescribed.row(i).collect(),
            constant: self.constant[i],
            coefficient: self.coefficient[i],
            bound: self.bound[i],
        }
    }

    /// Whether both have the same rows with the same friction; their constants may be others.
    #[cfg(feature = "linear")]
    pub(crate) fn has_rows_of(&self, other: &SlipRows) -> bool {
        self.keys == other.keys
            && self.free == other.free
            && self.coefficient == other.coefficient
            && self.bound == other.bound
    }

    /// Δs = T u + d (p, UL).
    pub fn slips(&self, u: &[f64]) -> Vec<f64> {
        let rows = self.constant.iter().enumerate();
        rows.map(|(i, d)| d + self.free.times(i, u)).collect()
    }

    /// Adds the forces −Tᵀr on the free unknowns to `out` (n, UF).
    pub fn add_forces(&self, forces: &[f64], out: &mut [f64]) {
        let against: Vec<f64> = forces.iter().map(|r| -r).collect();
        self.free.add_transpose(&against, out);
    }

    /// Adds the forces on the prescribed unknowns to `out` (UF).
    pub fn add_prescribed_forces(&self, forces: &[f64], out: &mut [f64]) {
        let against: Vec<f64> = forces.iter().map(|r| -r).collect();
        self.prescribed.add_transpose(&against, out);
    }

    /// The numbers of free and of prescribed unknowns up to the last one that has a coefficient.
    pub fn columns(&self) -> [usize; 2] {
        [self.free.columns(), self.prescribed.columns()]
    }

    /// τ = min(μλ, bound) of each row, with the multiplier of the row of gaps with its key (p, UF).
    pub fn thresholds(&self, lambda: impl Fn(RowKey) -> f64) -> Vec<f64> {
        let laws = self.coefficient.iter().zip(&self.bound);
        let all = self.keys.iter().zip(laws);
        all.map(|(&key, (mu, bound))| (mu * lambda(key).max(0.0)).min(*bound))
            .collect()
    }

    /// The forces that friction with these thresholds can exert on each unknown, Σ |T_ij| τ_i (n, UF). Where rows of both roles hold the same
    /// place, their thresholds add up, and how they share the sum is not unique.
    pub fn capacities(&self, thresholds: &[f64], n: usize) -> Vec<f64> {
        capacities(&self.free, thresholds, n)
    }

    /// Checks the numbers, and that each row belongs to a row of gaps of its own, for `n` unknowns.
    ///
    /// # Errors
    /// A column out of range, a coefficient below zero, a bound below zero, values that are no numbers, a key twice.
    pub fn check(&self, n: usize) -> Result<(), Error> {
        let columns = "the columns of the slips";
        Error::check_length_of(columns, self.free.columns().max(n), n)?;
        let values = "the values of the slips";
        let entries = (0..self.len()).flat_map(|i| self.free.row(i).map(|(_, a)| a));
        let mut numbers = entries.chain(self.constant.iter().copied()).enumerate();
        if let Some((index, value)) = numbers.find(|(_, value)| !value.is_finite()) {
            return Err(Error::NotFinite {
                what: values,
                index,
                value,
            });
        }
        if let Some(mu) = self
            .coefficient
            .iter()
            .find(|mu| !(**mu >= 0.0 && mu.is_finite()))
        {
            return Err(Error::Setting {
                name: "friction",
                value: mu.to_string(),
                remedy: "give a coefficient that is zero or a positive number",
            });
        }
        if let Some(bound) = self.bound.iter().find(|bound| !(**bound >= 0.0)) {
            return Err(Error::Setting {
                name: "friction bound",
                value: bound.to_string(),
                remedy: "give a largest force that is zero, positive, or infinite for none",
            });
        }
        let mut keys = self.keys.clone();
        keys.sort_unstable();
        match keys.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(Error::Untreated {
                solver: "friction",
                what: "two directions of slip at one contact node",
                value: format!("pass {}, node {}", pair[0].pass, pair[0].node),
                remedy: "give one row of slips for a row of gaps: friction is solved in the plane",
            }),
            None => Ok(()),
        }
    }
}

/// Σ |T_ij| τ_i of each column.
fn capacities(rows: &SparseRows, thresholds: &[f64], columns: usize) -> Vec<f64> {
    let mut all = vec![0.0; columns];
    for (i, threshold) in thresholds.iter().enumerate() {
        rows.row(i).for_each(|(j, a)| all[j] += a.abs() * threshold);
    }
    all
}

/// What a contact node does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Nothing presses on it.
    Open,
    /// Its force is below the threshold.
    Stick,
    /// Its force is at the threshold.
    Slip,
}

/// The friction at an equilibrium.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Friction {
    /// The slips, with points and directions as the equilibrium has them.
    pub rows: SlipRows,
    /// τ (p, UF): the largest force of each row, by Coulomb's law and the forces of contact.
    pub thresholds: Vec<f64>,
    /// r (p, UF), positive against a positive slip.
    pub forces: Vec<f64>,
    /// The state since which the rows count slips (n, UL), and its load factor.
    pub last: Vec<f64>,
    /// See [`Friction::last`].
    pub from: f64,
}

impl Friction {
    /// Whether there is a number for each row, and each row is over `n` free unknowns, as in what was not damaged.
    #[cfg(feature = "resume")]
    pub(crate) fn is_whole(&self, n: usize) -> bool {
        let rows = &self.rows;
        let p = rows.keys.len();
        let lengths = [
            rows.constant.len(),
            rows.coefficient.len(),
            rows.bound.len(),
            self.thresholds.len(),
            self.forces.len(),
        ];
        lengths == [p; 5]
            && self.last.len() == n
            && rows.free.is_whole(p)
            && rows.prescribed.is_whole(p)
            && rows.free.columns() <= n
    }

    /// At an equilibrium with these multipliers of contact. `force` has r of each row that free unknowns move; the other rows slip as is
    /// prescribed.
    #[cfg(feature = "linear")]
    pub(crate) fn at(
        rows: SlipRows,
        multipliers: &Multipliers,
        force: impl Fn(usize) -> Option<f64>,
        context: &StepContext<'_>,
    ) -> Self {
        let thresholds = rows.thresholds(|key| multipliers.of(key));
        let all = thresholds.iter().zip(&rows.constant).enumerate();
        let force = |(i, (tau, slip)): (usize, (&f64, &f64))| match force(i) {
            Some(force) => force.clamp(-tau, *tau),
            None if *slip == 0.0 => 0.0,
            None => tau * slip.signum(),
        };
        Friction {
            forces: all.map(force).collect(),
            thresholds,
            rows,
            last: context.last.u.clone(),
            from: context.from,
        }
    }

    /// Forces below this share of the largest threshold are none.
    const NONE: f64 = 1e-9;

    /// What each node does at `u` (p). Of a node in contact either the slip or what its force lacks to the threshold is small; it
    /// sticks where its slip, as a share of the largest one, is the smaller of the two shares.
    pub fn statuses(&self, u: &[f64]) -> Vec<Status> {
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let slips = self.rows.slips(u);
        let (far, full) = (largest(&slips), largest(&self.thresholds));
        let all = slips.iter().zip(&self.forces).zip(&self.thresholds);
        let status = |((slip, force), threshold): ((&f64, &f64), &f64)| {
            let lacks = 1.0 - force.abs() / threshold;
            match *threshold > Self::NONE * full {
                false => Status::Open,
                true if slip.abs() < lacks * far => Status::Stick,
                true => Status::Slip,
            }
        };
        all.map(status).collect()
    }

    /// The work that friction takes in the increment to `u` (UF·UL), which is not negative but for round-off: the forces times the slips, as if each threshold had grown in proportion
    /// to its slip, from its value in the increment `before`, or from zero. Thresholds are compared by the forces that they allow on each unknown:
    /// rows of both roles may share the same sum in other ways than before.
    pub fn dissipated(&self, u: &[f64], before: Option<&Friction>) -> f64 {
        let n = u.len();
        let before = before.filter(|own| own.last.len() == n);
        let kinds: [fn(&SlipRows) -> &SparseRows; 2] = [|rows| &rows.free, |rows| &rows.prescribed];
        let capacities = kinds.map(|of| {
            let columns = before.map_or(0, |own| of(&own.rows).columns());
            let columns = columns.max(of(&self.rows).columns());
            let allowed = |own: &Friction| capacities(of(&own.rows), &own.thresholds, columns);
            let then = before.map_or_else(|| vec![0.0; columns], allowed);
            (of(&self.rows), allowed(self), then)
        });
        let slips = self.rows.slips(u);
        let work = |(i, (r, slip)): (usize, (&f64, &f64))| {
            let (mut whole, mut known) = (0.0, 0.0);
            for (rows, now, then) in &capacities {
                for (j, a) in rows.row(i) {
                    whole += a.abs() * now[j];
                    known += a.abs() * then[j];
                }
            }
            match whole > 0.0 {
                true => 0.5 * (1.0 + known / whole) * r * slip,
                false => 0.0,
            }
        };
        self.forces.iter().zip(&slips).enumerate().map(work).sum()
    }
}
