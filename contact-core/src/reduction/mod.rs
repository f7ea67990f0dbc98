//! Unknowns that follow others: u = T v + t.
//!
//! Some unknowns of a problem, the dependent ones, are linear in the others. Solvers get a problem over the independent
//! ones v, with the gradient Tᵀ∇E, the Hessian TᵀHT and rows C T, so that the relations hold to round-off. Everything
//! else, such as load steps and records, sees all unknowns u.

mod energy;
mod problem;

use std::sync::{Arc, OnceLock};

use self::energy::Part;
use self::problem::Reduced;
use crate::equilibrium::{Equilibrium, Solution, StepContext};
use crate::gaps::SparseRows;
use crate::{ContactProblem, Error, State};

/// An unknown that is a sum of others: u_i = Σ c_j u_j + t.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependent {
    /// i.
    pub unknown: usize,
    /// (j, c_j) of independent unknowns; the coefficients of one unknown add up.
    pub terms: Vec<(usize, f64)>,
}

/// T of u = T v + t: an independent unknown is an entry of v itself.
///
/// A problem may be a sum over parts, such as bodies. Dependent unknowns join parts to groups, and v is numbered group by
/// group.
#[derive(Debug)]
pub struct LinearMap {
    /// The first unknown of each part, and their number last.
    starts: Vec<usize>,
    places: Vec<Place>,
    /// The dependent unknowns, and their terms over v.
    dependents: Vec<usize>,
    terms: SparseRows,
    groups: Vec<Group>,
    /// How the parts' Hessians add up to those of the groups.
    plans: OnceLock<Vec<Option<Part>>>,
}

/// Parts of the energy that dependent unknowns join.
#[derive(Debug)]
struct Group {
    /// Ascending.
    parts: Vec<usize>,
    /// Its first entry of v, and their number.
    first: usize,
    len: usize,
    /// Whether some of its unknowns depend on others.
    is_mapped: bool,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    /// The entry of v.
    Independent(usize),
    /// The position among the dependent unknowns.
    Dependent(usize),
}

/// A [`LinearMap`] with the constants t of the dependent unknowns, in their order (UL).
#[derive(Clone, Debug)]
pub struct Reduction {
    /// T.
    pub map: Arc<LinearMap>,
    /// t of [`LinearMap::dependents`].
    pub constants: Vec<f64>,
    /// Whether supports alone hold each of [`LinearMap::groups`], so that it has an equilibrium without the others.
    pub held: Vec<bool>,
}

impl LinearMap {
    /// For a problem whose parts have these numbers of unknowns.
    ///
    /// # Errors
    /// An unknown that there is not, that depends twice, or on one that depends itself; coefficients that are no numbers.
    pub fn new(parts: &[usize], dependents: &[Dependent]) -> Result<Self, Error> {
        let mut starts = vec![0];
        parts
            .iter()
            .for_each(|len| starts.push(starts[starts.len() - 1] + len));
        let n = starts[parts.len()];
        let part_of = |unknown: usize| starts.partition_point(|start| *start <= unknown) - 1;
        let mut depends = vec![None; n];
        for (k, dependent) in dependents.iter().enumerate() {
            let used = dependent.terms.iter().map(|(j, _)| *j);
            let last = used.chain([dependent.unknown]).max().unwrap_or(0);
            Error::check_length_of("the unknowns that depend", n.max(last + 1), n)?;
            if depends[dependent.unknown].replace(k).is_some() {
                return Err(twice(dependent.unknown));
            }
            let mut coefficients = dependent.terms.iter().enumerate();
            if let Some((index, (_, value))) = coefficients.find(|(_, (_, c))| !c.is_finite()) {
                let what = "the coefficients of a dependent unknown";
                return Err(Error::NotFinite {
                    what,
                    index,
                    value: *value,
                });
            }
        }
        let mut first: Vec<usize> = (0..parts.len()).collect();
        for Dependent { unknown, terms } in dependents {
            for (j, _) in terms {
                if depends[*j].is_some() {
                    return Err(twice(*j));
                }
                let [a, b] = [*unknown, *j].map(|i| first[part_of(i)]);
                let (kept, other) = (a.min(b), a.max(b));
                let of_other = first.iter_mut().filter(|first| **first == other);
                of_other.for_each(|first| *first = kept);
            }
        }
        let (mut places, mut groups) = (vec![Place::Independent(0); n], Vec::new());
        let mut next = 0;
        for root in (0..parts.len()).filter(|&part| first[part] == part) {
            let own: Vec<usize> = (root..parts.len()).filter(|&p| first[p] == root).collect();
            let (begin, mut is_mapped) = (next, own.len() > 1);
            for i in own.iter().flat_map(|&part| starts[part]..starts[part + 1]) {
                places[i] = match depends[i] {
                    Some(k) => {
                        is_mapped = true;
                        Place::Dependent(k)
                    }
                    None => {
                        next += 1;
                        Place::Independent(next - 1)
                    }
                };
            }
            groups.push(Group {
                parts: own,
                first: begin,
                len: next - begin,
                is_mapped,
            });
        }
        let mut terms = SparseRows::new();
        for dependent in dependents {
            let own = dependent.terms.iter().map(|&(j, c)| match places[j] {
                Place::Independent(v) => (v, c),
                Place::Dependent(_) => (0, 0.0),
            });
            terms.push(&merged(own.collect()));
        }
        Ok(LinearMap {
            dependents: dependents
                .iter()
                .map(|dependent| dependent.unknown)
                .collect(),
            starts,
            places,
            terms,
            groups,
            plans: OnceLock::new(),
        })
    }

    /// n, the number of all unknowns.
    pub fn unknowns(&self) -> usize {
        self.places.len()
    }

    /// The number of independent unknowns.
    pub fn independent(&self) -> usize {
        self.places.len() - self.dependents.len()
    }

    /// The unknowns that depend on others, in the order in which they were given.
    pub fn dependents(&self) -> &[usize] {
        &self.dependents
    }

    /// The parts of each group that dependent unknowns join.
    pub fn groups(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.groups.iter().map(|group| group.parts.as_slice())
    }

    /// v of u (n): the values of dependent unknowns are left out.
    pub fn restricted(&self, u: &[f64]) -> Vec<f64> {
        let mut v = vec![0.0; self.independent()];
        for (place, value) in self.places.iter().zip(u) {
            if let Place::Independent(j) = *place {
                v[j] = *value;
            }
        }
        v
    }

    /// Forces on u (n) that do the work of these on v: dependent unknowns have none.
    pub fn spread(&self, forces: &[f64]) -> Vec<f64> {
        let force = |place: &Place| match *place {
            Place::Independent(j) => forces[j],
            Place::Dependent(_) => 0.0,
        };
        self.places.iter().map(force).collect()
    }

    /// u = T v + t.
    pub fn expanded(&self, v: &[f64], constants: &[f64]) -> Vec<f64> {
        let value = |place: &Place| match *place {
            Place::Independent(j) => v[j],
            Place::Dependent(k) => self.terms.times(k, v) + constants[k],
        };
        self.places.iter().map(value).collect()
    }

    /// Tᵀ f of forces on all unknowns (n).
    pub fn transposed(&self, forces: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; self.independent()];
        for (i, force) in forces.iter().enumerate() {
            self.of_unknown(i, |j, c| own[j] += c * force);
        }
        own
    }

    /// The largest sum of absolute coefficients of a dependent unknown.
    fn largest_sum(&self) -> f64 {
        let rows = 0..self.terms.len();
        let sums = rows.map(|k| self.terms.row(k).map(|(_, c)| c.abs()).sum());
        sums.fold(0.0, f64::max)
    }

    /// The entries of row `i` of T.
    pub(crate) fn of_unknown(&self, i: usize, mut entry: impl FnMut(usize, f64)) {
        match self.places[i] {
            Place::Independent(j) => entry(j, 1.0),
            Place::Dependent(k) => self.terms.row(k).for_each(|(j, c)| entry(j, c)),
        }
    }

    /// A T of a row of A.
    fn row(&self, entries: impl Iterator<Item = (usize, f64)>) -> Vec<(usize, f64)> {
        let mut own = Vec::new();
        for (i, a) in entries {
            self.of_unknown(i, |j, c| own.push((j, a * c)));
        }
        merged(own)
    }

    /// A T.
    pub(crate) fn rows(&self, rows: &SparseRows) -> SparseRows {
        let mut own = SparseRows::new();
        (0..rows.len()).for_each(|i| own.push(&self.row(rows.row(i))));
        own
    }
}

/// One entry a column, ascending.
fn merged(mut entries: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    entries.sort_by_key(|(j, _)| *j);
    entries.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        kept.1 += if is_same { next.1 } else { 0.0 };
        is_same
    });
    entries
}

fn twice(unknown: usize) -> Error {
    Error::Setting {
        name: "dependent unknown",
        value: unknown.to_string(),
        remedy: "let each unknown depend once, and on independent ones",
    }
}

/// Solves `problem`, some of whose unknowns depend on others where it says so, by `solver`.
///
/// # Errors
/// As [`Equilibrium::solve`], and a [`ContactProblem::reduction`] that does not fit the problem.
pub(crate) fn solve<E: Equilibrium + ?Sized>(
    solver: &mut E,
    problem: &dyn ContactProblem,
    start: State,
    context: &StepContext<'_>,
) -> Result<Solution, Error> {
    let Some(reduction) = problem.reduction() else {
        return solver.solve(problem, start, context);
    };
    let reduced = Reduced::new(problem, &reduction, &context.last.u)?;
    Error::check_vector("start.u", &start.u, reduction.map.unknowns())?;
    let last = reduced.restricted(context.last);
    let lifted = || reduced.restricted(&(context.lifted)());
    let own = StepContext {
        last: &last,
        lifted: &lifted,
        ..*context
    };
    let start = reduced.restricted(&start);
    let solution = solver.solve(&reduced, start, &own)?;
    Error::check_length(
        "the solver's u",
        &solution.state.u,
        reduction.map.independent(),
    )?;
    reduced.expanded(solution)
}

#[cfg(all(test, feature = "linear"))]
mod tests;
