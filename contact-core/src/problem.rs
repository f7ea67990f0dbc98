//! The interface between mechanics and optimisation: the trait of a contact problem, its scales and its state.

use crate::friction::SlipRows;
use crate::gaps::{Sampling, SparseRows};
use crate::nlp::Bounds;
use crate::reduction::{LinearMap, Reduction};
use crate::{Energy, Error, LinearGaps, RowKey, Stop};

/// Characteristic quantities of the problem. Lengths and energies are divided by them before Ipopt sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// A length (UL) such that displacements divided by it are at most O(1).
    pub length: f64,
    /// The smallest displacement (UL) that matters at contact. The tolerance on complementarity
    /// (gap times force at an active row) is relative to it. It must decrease with the mesh size;
    /// otherwise contact pressures lose accuracy with every refinement.
    pub resolution: f64,
    /// The round-off error of a gradient in these units; no smaller tolerance can be met.
    pub roundoff: f64,
    /// The reference measure (UL in the plane, UL² in space) of a contact facet.
    pub area: f64,
    /// An energy (UF·UL) such that `length²/energy` times the Hessian's diagonal is O(1).
    pub energy: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Scale {
            length: 1.0,
            resolution: 1.0,
            roundoff: f64::EPSILON,
            area: 1.0,
            energy: 1.0,
        }
    }
}

impl Scale {
    /// The problem's own units or, without them, those estimated at `u`.
    ///
    /// # Errors
    /// As [`Scale::estimate`].
    pub fn of(problem: &dyn ContactProblem, u: &[f64]) -> Result<Self, Error> {
        match problem.scale() {
            Some(scale) => Ok(scale),
            None => Scale::estimate(problem, u),
        }
    }

    /// Units estimated at `u` (n, UL), where a solve starts: with the median K of the Hessian's diagonal (UF/UL), the length is the
    /// largest of the unknowns, of the prescribed ones, of overlaps, and of |∇E|/K, the steps that forces would make; the
    /// energy is K times its square.
    ///
    /// They suit problems whose unknowns are of one kind. Values that are not finite are left out.
    ///
    /// # Errors
    /// A u of the wrong length or with values that are not finite, and errors of the gaps.
    pub fn estimate(problem: &dyn ContactProblem, u: &[f64]) -> Result<Self, Error> {
        let energy = problem.energy();
        let n = energy.dofs();
        Error::check_vector("u", u, n)?;
        let pattern = energy.hessian_pattern();
        let mut hessian = vec![0.0; pattern.len()];
        energy.hessian(u, &mut hessian);
        let entries = pattern.iter().zip(hessian);
        let diagonal = entries.filter_map(|((i, j), k)| (i == j).then_some(k.abs()));
        let mut diagonal: Vec<f64> = diagonal.filter(|k| k.is_normal()).collect();
        diagonal.sort_unstable_by(f64::total_cmp);
        let stiffness = diagonal.get(diagonal.len() / 2).copied().unwrap_or(1.0);
        let mut gradient = vec![0.0; n];
        energy.gradient(u, &mut gradient);
        let rows = problem.linearize_gaps(u, Sampling::Nodes)?;
        let rows = rows.and(problem.linearize_reversed(u, Sampling::Nodes)?);
        let mut gaps = vec![0.0; rows.len()];
        rows.value(u, &mut gaps);
        let largest = |values: &mut dyn Iterator<Item = f64>| {
            values
                .map(f64::abs)
                .filter(|v| v.is_normal())
                .fold(0.0, f64::max)
        };
        let steps = &mut gradient.iter().map(|force| force / stiffness);
        let overlaps = &mut gaps.iter().map(|gap| gap.min(0.0));
        let moved = [
            largest(&mut u.iter().copied()),
            largest(&mut std::iter::once(problem.prescribed_magnitude())),
            largest(overlaps),
            largest(steps),
        ];
        let moved = moved.into_iter().fold(0.0, f64::max);
        let apart = largest(&mut gaps.iter().copied());
        let length = match (moved > 0.0, apart > 0.0) {
            (true, _) => moved,
            (false, true) => apart,
            (false, false) => 1.0,
        };
        Ok(Scale {
            length,
            resolution: length / (n.max(1) as f64).sqrt(),
            roundoff: f64::EPSILON,
            area: 1.0,
            energy: stiffness * length * length,
        })
    }
}

/// Multipliers by row key, so that they can be carried over to other rows.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct Multipliers(Vec<(RowKey, f64)>);

impl Multipliers {
    /// λ_i of each row of `gaps`.
    pub fn new(gaps: &LinearGaps, lambda: &[f64]) -> Self {
        let named = gaps.keys().iter().copied().zip(lambda.iter().copied());
        let mut entries: Vec<_> = named.collect();
        entries.sort_unstable_by_key(|entry| entry.0);
        Multipliers(entries)
    }

    /// The multiplier of a row; zero if the row is new.
    pub fn of(&self, key: RowKey) -> f64 {
        let found = self.0.binary_search_by_key(&key, |entry| entry.0);
        found.map_or(0.0, |k| self.0[k].1)
    }

    /// Whether there are no multipliers.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rows with a force here or in `before`, but not in both.
    pub fn switched(&self, before: &Multipliers) -> Vec<RowKey> {
        let acting = |all: &Multipliers, other: &Multipliers| -> Vec<RowKey> {
            let acting = all.0.iter().filter(|(_, l)| *l > 0.0);
            let alone = acting.filter(|(key, _)| !(other.of(*key) > 0.0));
            alone.map(|(key, _)| *key).collect()
        };
        let mut rows = acting(self, before);
        rows.extend(acting(before, self));
        rows
    }

    /// The extrapolation max(λ + s (λ − λ_before), 0).
    pub fn extrapolated(&self, before: &Multipliers, s: f64) -> Multipliers {
        let line = |&(key, l): &(RowKey, f64)| (key, (l + s * (l - before.of(key))).max(0.0));
        Multipliers(self.0.iter().map(line).collect())
    }
}

/// The last value counts where a key comes twice.
impl FromIterator<(RowKey, f64)> for Multipliers {
    fn from_iter<I: IntoIterator<Item = (RowKey, f64)>>(entries: I) -> Self {
        let mut entries: Vec<_> = entries.into_iter().collect();
        entries.sort_by_key(|entry| entry.0);
        entries.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            if is_same {
                kept.1 = next.1;
            }
            is_same
        });
        Multipliers(entries)
    }
}

/// The primal and dual unknowns: the start of a solve, and its result.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "resume", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// λ ≥ 0 of the contact rows (UF).
    pub multipliers: Multipliers,
}

/// How gaps and contact forces vary with u where projections and normals follow it, beyond what frozen rows tell.
///
/// Internal variables y = Y u, such as averaged normals, are shared by many rows. With G and D for ∂c/∂u and ∂(C(u)ᵀλ)/∂u,
/// G v = G_u v + G_y Y v and D v = D_u v + D_y Y v. D is not symmetric.
#[derive(Clone, Debug, Default)]
pub struct GapVariation {
    /// Y (p × n).
    pub internal: SparseRows,
    /// G_u (m × n); rows that were not asked for are empty.
    pub gradients: SparseRows,
    /// G_y (m × p).
    pub internal_gradients: SparseRows,
    /// The unknowns on which D acts, and its rows D_u and D_y (UF/UL).
    unknowns: Vec<usize>,
    forces: SparseRows,
    internal_forces: SparseRows,
}

impl GapVariation {
    /// Adds a row of D: the variation of the force on an `unknown` by the unknowns and by the internal variables.
    pub fn push_force(
        &mut self,
        unknown: usize,
        by_unknowns: &[(usize, f64)],
        by_internal: &[(usize, f64)],
    ) {
        self.unknowns.push(unknown);
        self.forces.push(by_unknowns);
        self.internal_forces.push(by_internal);
    }

    /// The same over the unknowns that `place` renumbers, without the others.
    #[cfg(feature = "linear")]
    pub(crate) fn renumbered(self, place: impl Fn(usize) -> Option<usize> + Copy) -> Self {
        let mut own = GapVariation {
            internal: self.internal.renumbered(place),
            gradients: self.gradients.renumbered(place),
            internal_gradients: self.internal_gradients,
            ..GapVariation::default()
        };
        let (direct, indirect) = (self.forces.renumbered(place), &self.internal_forces);
        for (k, unknown) in self.unknowns.into_iter().enumerate() {
            if let Some(unknown) = place(unknown) {
                let [by_unknowns, by_internal] =
                    [&direct, indirect].map(|rows| rows.row(k).collect::<Vec<_>>());
                own.push_force(unknown, &by_unknowns, &by_internal);
            }
        }
        own
    }

    /// The same over the independent unknowns: Y T, G T and TᵀD T.
    pub(crate) fn mapped(self, map: &LinearMap) -> Self {
        let mut own = GapVariation {
            internal: map.rows(&self.internal),
            gradients: map.rows(&self.gradients),
            internal_gradients: self.internal_gradients,
            ..GapVariation::default()
        };
        let scaled = |rows: &SparseRows, k: usize, c: f64| -> Vec<(usize, f64)> {
            rows.row(k).map(|(j, a)| (j, c * a)).collect()
        };
        let direct = map.rows(&self.forces);
        for (k, &unknown) in self.unknowns.iter().enumerate() {
            map.of_unknown(unknown, |j, c| {
                let by_unknowns = scaled(&direct, k, c);
                own.push_force(j, &by_unknowns, &scaled(&self.internal_forces, k, c));
            });
        }
        own
    }

    /// Checks the numbers of rows and the columns for `m` gaps and `n` unknowns.
    ///
    /// # Errors
    /// A wrong number of rows, a column out of range.
    pub fn check(&self, m: usize, n: usize) -> Result<(), Error> {
        let p = self.internal.len();
        let rows = "the rows of the gaps' variation";
        Error::check_length_of(rows, self.gradients.len(), m)?;
        Error::check_length_of(rows, self.internal_gradients.len(), m)?;
        let columns = "the columns of the gaps' variation";
        let unknowns = [
            self.internal.columns(),
            self.gradients.columns(),
            self.forces.columns(),
        ];
        let last = self.unknowns.iter().map(|unknown| unknown + 1).max();
        let used = unknowns.into_iter().chain(last).max().unwrap_or(0);
        Error::check_length_of(columns, used.max(n), n)?;
        let used = self
            .internal_gradients
            .columns()
            .max(self.internal_forces.columns());
        Error::check_length_of(columns, used.max(p), p)
    }

    /// Y v (p).
    pub fn internal(&self, v: &[f64]) -> Vec<f64> {
        let rows = 0..self.internal.len();
        rows.map(|k| self.internal.times(k, v)).collect()
    }

    /// (G v)_i, with y = Y v.
    pub fn gap(&self, i: usize, v: &[f64], y: &[f64]) -> f64 {
        self.gradients.times(i, v) + self.internal_gradients.times(i, y)
    }

    /// Adds D v to `out`, with y = Y v.
    pub fn add_forces(&self, v: &[f64], y: &[f64], out: &mut [f64]) {
        for (k, &unknown) in self.unknowns.iter().enumerate() {
            out[unknown] += self.forces.times(k, v) + self.internal_forces.times(k, y);
        }
    }

    /// Adds Dᵀv to `out`.
    pub fn add_transposed_forces(&self, v: &[f64], out: &mut [f64]) {
        let v: Vec<f64> = self.unknowns.iter().map(|&unknown| v[unknown]).collect();
        self.forces.add_transpose(&v, out);
        let mut y = vec![0.0; self.internal.len()];
        self.internal_forces.add_transpose(&v, &mut y);
        self.internal.add_transpose(&y, out);
    }

    /// The entries of D as (row, column, value); the values of one place add up.
    pub fn stiffness(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        self.unknowns.iter().enumerate().flat_map(move |(k, &i)| {
            let direct = self.forces.row(k);
            let by_internal = self.internal_forces.row(k);
            let indirect = by_internal
                .flat_map(move |(y, d)| self.internal.row(y).map(move |(j, a)| (j, d * a)));
            direct.chain(indirect).map(move |(j, d)| (i, j, d))
        })
    }
}

/// A problem whose energy is a sum over bodies, which nothing but rows of gaps couples.
pub trait Separable {
    /// The energies of the bodies, in the order of their unknowns: those of a body follow those of the body before.
    fn bodies(&self) -> Vec<&dyn Energy>;
    /// Whether supports alone hold body `b`, so that it has an equilibrium without the others.
    fn is_held(&self, b: usize) -> bool;
    /// The two bodies that the rows of each pass ([`RowKey::pass`]) are between; twice the same one where there is no other.
    fn passes(&self) -> Vec<[usize; 2]>;
    /// As the rows of both roles at u, one for each contact node, of those passes alone both of whose bodies are among
    /// these (one entry a body).
    ///
    /// # Errors
    /// As [`ContactProblem::linearize_gaps`].
    fn linearize_among(&self, u: &[f64], among: &[bool]) -> Result<LinearGaps, Error>;
}

/// An energy and its linearisable gap constraints. Space, meshes and materials are hidden behind this
/// trait; a model problem with two unknowns can implement it, too.
pub trait ContactProblem {
    /// E(u).
    fn energy(&self) -> &dyn Energy;
    /// Bounds on the free unknowns (n, UL), infinite where there is none.
    fn bounds(&self) -> &Bounds;
    /// Steps 1 and 2 of Algorithm 2: the rows for the roles of slave and master as declared, with
    /// projections and normals frozen at `u`.
    ///
    /// [`Sampling::Nodes`] asks for one row per contact node. [`Sampling::Points`] asks for one row
    /// per integration point, weighted by its share of the surface integral, as method (39) needs
    /// it. A problem without surfaces returns the same rows in either case.
    fn linearize_gaps(&self, u: &[f64], sampling: Sampling) -> Result<LinearGaps, Error>;
    /// Step 3: the rows of the reversed roles. By default there are none.
    fn linearize_reversed(&self, _u: &[f64], _sampling: Sampling) -> Result<LinearGaps, Error> {
        Ok(LinearGaps::new(true))
    }
    /// The rows of both roles, one for each contact node, without those that are open wherever no displacement exceeds
    /// `moved` (UL). By default all.
    ///
    /// [`Condensed`](crate::equilibrium::Condensed) asks again where displacements exceed `moved`. A row that is left out for
    /// some `moved` is left out for any smaller one.
    fn linearize_near(&self, u: &[f64], _moved: f64) -> Result<LinearGaps, Error> {
        let forward = self.linearize_gaps(u, Sampling::Nodes)?;
        Ok(forward.and(self.linearize_reversed(u, Sampling::Nodes)?))
    }
    /// The variation of the rows `gaps`, both roles joined, which are frozen at `u`; `lambda` has the multiplier (UF) of
    /// each row that matters, and `None` for the others.
    ///
    /// By default there is none: C does not vary with u. Newton's method then takes the rows as frozen, and converges
    /// linearly, or not at all, where they are not exact. A problem that wraps another one must pass this on, too.
    fn vary_gaps(
        &self,
        _u: &[f64],
        _gaps: &LinearGaps,
        _lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        Ok(None)
    }
    /// Whether some rows have friction; by default none has. A problem that wraps another one must pass this on.
    fn has_friction(&self) -> bool {
        false
    }
    /// How the contact nodes slip whose rows `gaps` were made at `u`, with points and directions held there, and their coefficients of
    /// friction. Slips count from `last` (n, UL), the state that converged last, at the load factor `from`. By default there is no friction.
    ///
    /// Solvers ask for them where [`ContactProblem::has_friction`] is true; see [`friction`](crate::friction). A problem that wraps another
    /// one must pass this on.
    ///
    /// # Errors
    /// As [`ContactProblem::linearize_gaps`].
    fn slips(
        &self,
        _u: &[f64],
        _gaps: &LinearGaps,
        _last: &[f64],
        _from: f64,
    ) -> Result<SlipRows, Error> {
        Ok(SlipRows::default())
    }
    /// The variation of the forces Tᵀz along the slips of the rows `gaps`, which are frozen at `u`: as [`ContactProblem::vary_gaps`] of the forces Cᵀλ, with the multiplier z
    /// (UF) of the slip of each row of gaps in place of λ. Solvers read the variation of the forces only. By default there is none. A problem that wraps
    /// another one must pass this on.
    ///
    /// # Errors
    /// As [`ContactProblem::linearize_gaps`].
    fn vary_slips(
        &self,
        _u: &[f64],
        _gaps: &LinearGaps,
        _forces: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        Ok(None)
    }
    /// The bodies that the problem consists of, where the energy is a sum over them: those on which no common row acts are
    /// solved by themselves then, by `CondensedNewton`. By default it is one whole. A
    /// problem that wraps another one may pass this on if it changes neither energies nor rows.
    fn separable(&self) -> Option<&dyn Separable> {
        None
    }
    /// Unknowns that are linear in others; by default there are none. [`LoadSteps`](crate::LoadSteps) and
    /// [`Equilibrium::solve_from`](crate::Equilibrium::solve_from) give solvers the problem over the others then. A
    /// problem that wraps another one must pass this on.
    fn reduction(&self) -> Option<Reduction> {
        None
    }
    /// Gives the request to stop that the methods above may look at within long loops, or takes it away: `None` outside a
    /// solve. They return [`Error::Interrupted`] then. By default they do not look. A problem that wraps another one may pass
    /// this on.
    fn watch(&mut self, _stop: Option<&Stop>) {}
    /// Whether [`LinearGaps::is_exact`] holds for the rows at any u. A problem that wraps another one must pass this on.
    fn has_exact_gaps(&self) -> bool {
        false
    }
    /// Units in which the problem's quantities are O(1). By default they are estimated where a solve starts, see
    /// [`Scale::estimate`]. A problem that wraps another one must pass this on.
    fn scale(&self) -> Option<Scale> {
        None
    }
    /// The largest coordinate of a node (UL). Gaps are differences of such numbers, and are no more accurate than their round-off. By default
    /// it is zero: gaps are as accurate as displacements. A problem that wraps another one may pass this on.
    fn extent(&self) -> f64 {
        0.0
    }
    /// The cause that `solution`, which did not converge at the present load, shows, in a sentence for the user; `None` if
    /// it shows none. The default does not look.
    fn diagnose(&self, _solution: &crate::equilibrium::Solution) -> Option<String> {
        None
    }
    /// max |prescribed unknown| (UL). The relative change of the fixed point is taken over all
    /// unknowns, prescribed ones included.
    fn prescribed_magnitude(&self) -> f64 {
        0.0
    }
}
