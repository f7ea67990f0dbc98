//! A quadratic energy under linear gaps, given as matrices that another program assembled.

use std::ops::Range;

use crate::gaps::{Row, Sampling};
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{ContactProblem, Energy, Error, LinearGaps, RowKey, State};

/// The entries of a sparse matrix, with numbers from 0; those of one place add up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Entries {
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
    /// Row, column and value.
    pub values: Vec<(usize, usize, f64)>,
}

/// min ½ vᵀK v + b·v subject to C v + c₀ ≥ 0 and v_L ≤ v ≤ v_U: what FreeFEM's `IPOPT([K, b], [C, c0], v, lb = …, ub = …)`
/// solves.
///
/// Equal bounds prescribe an unknown; it is eliminated. The free unknowns u are the others, in their order. Any
/// [`Equilibrium`](crate::Equilibrium) solves the problem.
///
/// A spring of stiffness 2 is pulled by 6 towards a wall at 1. The wall takes what the spring does not:
/// ```
/// # #[cfg(feature = "linear")]
/// # {
/// use contact_core::quadratic::{Entries, QuadraticProgram};
/// use contact_core::{Bounds, Condensed, Equilibrium};
///
/// let one = |value| Entries { rows: 1, columns: 1, values: vec![(0, 0, value)] };
/// let problem = QuadraticProgram::new(&one(2.0), &[-6.0], &one(-1.0), &[1.0], &Bounds::free(1))?;
/// let solution = Condensed::new().solve_from(&problem, problem.start())?;
/// assert_eq!(problem.unknowns(&solution.state.u), [1.0]);
/// assert_eq!(solution.lambda, [4.0]);
/// # }
/// # Ok::<(), contact_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct QuadraticProgram {
    /// K of all unknowns.
    all: Symmetric,
    linear: Vec<f64>,
    /// K of the free ones.
    free: Symmetric,
    /// b + K times the prescribed unknowns, of the free ones.
    load: Vec<f64>,
    /// The energy of the prescribed unknowns alone.
    constant: f64,
    /// Of each unknown its number among the free ones, or what it is prescribed to.
    places: Vec<Place>,
    gaps: LinearGaps,
    rows: usize,
    bounds: Bounds,
    blocks: Vec<Range<usize>>,
}

#[derive(Clone, Debug)]
struct Symmetric {
    pattern: SymmetricPattern,
    values: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Free(usize),
    Prescribed(f64),
}

impl QuadraticProgram {
    /// Two entries across the diagonal may differ by this share of the largest one: round-off of their assembly.
    const ASYMMETRY: f64 = 1e-9;
    /// A diagonal entry that is larger than the median by this factor is a penalty that holds an unknown.
    const PENALTY: f64 = 1e15;
    /// Bounds from here on are none, as for Ipopt.
    const NO_BOUND: f64 = 1e19;

    /// From the stiffness K (n × n, both triangles), b (n), C (m × n), c₀ (m) and the bounds on all unknowns (n).
    ///
    /// # Errors
    /// Sizes that do not fit, values that are not finite, a K that is not symmetric or that holds unknowns by a penalty,
    /// bounds that cross, a row of C without entries whose c₀ is negative.
    pub fn new(
        stiffness: &Entries,
        linear: &[f64],
        rows: &Entries,
        constant: &[f64],
        bounds: &Bounds,
    ) -> Result<Self, Error> {
        let n = linear.len();
        Error::check_length_of("the rows of K", stiffness.rows, n)?;
        Error::check_length_of("the columns of K", stiffness.columns, n)?;
        Error::check_vector("b", linear, n)?;
        Error::check_length_of("the columns of C", rows.columns, n)?;
        Error::check_vector("c₀", constant, rows.rows)?;
        Error::check_length("the lower bounds", &bounds.lower, n)?;
        bounds.validate("unknown", "the lower bounds", "the upper bounds")?;
        let all = Symmetric::new(stiffness)?;
        all.check_penalties()?;
        let mut places = Vec::with_capacity(n);
        let mut open = Bounds::default();
        for (&lower, &upper) in bounds.lower.iter().zip(&bounds.upper) {
            if lower == upper && lower.abs() < Self::NO_BOUND {
                places.push(Place::Prescribed(lower));
                continue;
            }
            places.push(Place::Free(open.len()));
            let is_none = |bound: f64| bound.abs() >= Self::NO_BOUND;
            open.lower.push(if is_none(lower) {
                f64::NEG_INFINITY
            } else {
                lower
            });
            open.upper
                .push(if is_none(upper) { f64::INFINITY } else { upper });
        }
        let prescribed: Vec<f64> = places.iter().map(|place| place.prescribed()).collect();
        let mut moved = vec![0.0; n];
        all.pattern.product(&all.values, &prescribed, &mut moved);
        let energy = |(p, (k, b)): (&f64, (&f64, &f64))| p * (0.5 * k + b);
        let terms = prescribed.iter().zip(moved.iter().zip(linear));
        let of_prescribed = terms.map(energy).sum();
        let pulls = places.iter().zip(moved.iter().zip(linear));
        let pulls = pulls.filter(|(place, _)| matches!(place, Place::Free(_)));
        let load: Vec<f64> = pulls.map(|(_, (k, b))| k + b).collect();
        let free = all.restricted(&places, load.len())?;
        let gaps = gaps(rows, constant, &places)?;
        Ok(QuadraticProgram {
            blocks: free.blocks(),
            all,
            linear: linear.to_vec(),
            free,
            load,
            constant: of_prescribed,
            places,
            gaps,
            rows: rows.rows,
            bounds: open,
        })
    }

    /// The start at 0, or at the nearest bound.
    pub fn start(&self) -> State {
        let bounds = self.bounds.lower.iter().zip(&self.bounds.upper);
        State {
            u: bounds
                .map(|(lower, upper)| 0f64.max(*lower).min(*upper))
                .collect(),
            ..State::default()
        }
    }

    /// The start at given values of all unknowns (n); those that are prescribed are left out.
    ///
    /// # Errors
    /// Another number of values, or values that are not finite.
    pub fn start_at(&self, unknowns: &[f64]) -> Result<State, Error> {
        Error::check_vector("the start", unknowns, self.places.len())?;
        let free = self.places.iter().zip(unknowns);
        let free = free.filter(|(place, _)| matches!(place, Place::Free(_)));
        Ok(State {
            u: free.map(|(_, value)| *value).collect(),
            ..State::default()
        })
    }

    /// m, the number of rows of C, those without entries included: a row's [`RowKey::node`] is below it.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// All unknowns v (n), from the free ones.
    pub fn unknowns(&self, u: &[f64]) -> Vec<f64> {
        let value = |place: &Place| match *place {
            Place::Free(i) => u[i],
            Place::Prescribed(value) => value,
        };
        self.places.iter().map(value).collect()
    }

    /// Whether each unknown is prescribed (n).
    pub fn is_prescribed(&self) -> Vec<bool> {
        let is_prescribed = |place: &Place| matches!(place, Place::Prescribed(_));
        self.places.iter().map(is_prescribed).collect()
    }

    /// Cᵀλ of all unknowns (n), with the rows and multipliers of a solution.
    pub fn contact_forces(&self, gaps: &LinearGaps, lambda: &[f64]) -> Vec<f64> {
        let mut free = vec![0.0; self.load.len()];
        let mut prescribed = vec![0.0; self.places.len() - self.load.len()];
        gaps.add_forces(lambda, &mut free);
        gaps.add_prescribed_forces(lambda, &mut prescribed);
        let (mut free, mut prescribed) = (free.into_iter(), prescribed.into_iter());
        let force = |place: &Place| match place {
            Place::Free(_) => free.next(),
            Place::Prescribed(_) => prescribed.next(),
        };
        self.places.iter().filter_map(force).collect()
    }

    /// K v + b − Cᵀλ of all unknowns (n): on a prescribed unknown what holds it, on a free one what is left.
    ///
    /// # Errors
    /// Another number of values.
    pub fn reactions(&self, unknowns: &[f64], contact: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.places.len();
        Error::check_length("the unknowns", unknowns, n)?;
        Error::check_length("the contact forces", contact, n)?;
        let mut forces = vec![0.0; n];
        let all = &self.all;
        all.pattern.product(&all.values, unknowns, &mut forces);
        let others = self.linear.iter().zip(contact);
        forces
            .iter_mut()
            .zip(others)
            .for_each(|(force, (b, contact))| *force += b - contact);
        Ok(forces)
    }
}

impl Place {
    fn prescribed(&self) -> f64 {
        match *self {
            Place::Free(_) => 0.0,
            Place::Prescribed(value) => value,
        }
    }
}

impl Symmetric {
    fn new(matrix: &Entries) -> Result<Self, Error> {
        for (index, &(row, column, value)) in matrix.values.iter().enumerate() {
            if !value.is_finite() {
                let what = "the entries of K";
                return Err(Error::NotFinite { what, index, value });
            }
            if row.max(column) >= matrix.rows {
                // the pattern names it
                break;
            }
        }
        let places: Vec<_> = matrix.values.iter().map(|&(i, j, _)| (i, j)).collect();
        let (pattern, slots) = SymmetricPattern::from_entries(matrix.rows, &places)?;
        let mut triangles = [vec![0.0; pattern.len()], vec![0.0; pattern.len()]];
        for (slot, &(i, j, value)) in slots.into_iter().zip(&matrix.values) {
            triangles[0][slot] += if i >= j { value } else { 0.0 };
            triangles[1][slot] += if i <= j { value } else { 0.0 };
        }
        let [lower, upper] = triangles;
        let largest = lower
            .iter()
            .chain(&upper)
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        let limit = QuadraticProgram::ASYMMETRY * largest;
        let off = (0..pattern.len()).find(|&slot| (lower[slot] - upper[slot]).abs() > limit);
        if let Some(slot) = off {
            let (row, column) = (pattern.rows()[slot], pattern.cols()[slot]);
            let (value, transposed) = (lower[slot], upper[slot]);
            return Err(Error::Asymmetric {
                row,
                column,
                value,
                transposed,
            });
        }
        let values = lower.iter().zip(&upper).map(|(a, b)| 0.5 * (a + b));
        Ok(Symmetric {
            values: values.collect(),
            pattern,
        })
    }

    /// Refuses unknowns that are held by a penalty: they spoil the digits of all others.
    fn check_penalties(&self) -> Result<(), Error> {
        let entries = self.pattern.iter().zip(&self.values);
        let diagonal: Vec<f64> = entries
            .filter_map(|((i, j), value)| (i == j).then_some(value.abs()))
            .collect();
        let mut sorted = diagonal.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let limit = QuadraticProgram::PENALTY * median.max(f64::MIN_POSITIVE);
        let mut all = self.pattern.iter().zip(&self.values);
        match all.find(|((i, j), value)| i == j && value.abs() > limit && median > 0.0) {
            Some(((unknown, _), &value)) => Err(Error::HeldByPenalty { unknown, value }),
            None => Ok(()),
        }
    }

    /// The rows and columns of the free unknowns.
    fn restricted(&self, places: &[Place], free: usize) -> Result<Self, Error> {
        let number = |unknown: usize| match places[unknown] {
            Place::Free(i) => Some(i),
            Place::Prescribed(_) => None,
        };
        let entries = self.pattern.iter().zip(&self.values);
        let entries = entries.filter_map(|((i, j), &value)| Some((number(i)?, number(j)?, value)));
        let entries: Vec<_> = entries.collect();
        let (pattern, values) = SymmetricPattern::from_sums(free, &entries)?;
        Ok(Symmetric { pattern, values })
    }

    /// Ranges of unknowns that no entry couples.
    fn blocks(&self) -> Vec<Range<usize>> {
        let n = self.pattern.dim();
        let mut furthest: Vec<usize> = (0..n).collect();
        for ((row, column), value) in self.pattern.iter().zip(&self.values) {
            if *value != 0.0 {
                furthest[column] = furthest[column].max(row);
            }
        }
        let (mut blocks, mut begin, mut end) = (Vec::new(), 0, 0);
        for (column, furthest) in furthest.into_iter().enumerate() {
            end = end.max(furthest);
            if end == column {
                blocks.push(begin..column + 1);
                begin = column + 1;
            }
        }
        blocks
    }
}

/// The rows, each with its number as key; those without entries are left out.
fn gaps(rows: &Entries, constant: &[f64], places: &[Place]) -> Result<LinearGaps, Error> {
    let mut of_row = vec![Vec::new(); rows.rows];
    for (index, &(row, column, value)) in rows.values.iter().enumerate() {
        if !value.is_finite() {
            let what = "the entries of C";
            return Err(Error::NotFinite { what, index, value });
        }
        if row >= rows.rows || column >= rows.columns {
            return Err(crate::nlp::NlpError::OutOfRange {
                pattern: "matrix of the gaps",
                entry: index,
                row,
                col: column,
                rows: rows.rows,
                cols: rows.columns,
            }
            .into());
        }
        if value != 0.0 {
            of_row[row].push((column, value));
        }
    }
    let mut before = 0;
    let prescribed_number: Vec<usize> = places
        .iter()
        .map(|place| {
            let number = before;
            before += usize::from(matches!(place, Place::Prescribed(_)));
            number
        })
        .collect();
    let mut gaps = LinearGaps::new(true);
    for (node, entries) in of_row.into_iter().enumerate() {
        let mut row = Row {
            constant: constant[node],
            ..Row::default()
        };
        for (column, value) in entries {
            match places[column] {
                Place::Free(i) => row.free.push((i, value)),
                Place::Prescribed(at) => {
                    row.prescribed.push((prescribed_number[column], value));
                    row.constant += value * at;
                }
            }
        }
        if row.free.is_empty() && row.prescribed.is_empty() {
            if row.constant < 0.0 {
                return Err(Error::ImpossibleRow {
                    row: node,
                    constant: row.constant,
                });
            }
            continue;
        }
        merge(&mut row.free);
        gaps.push(
            RowKey {
                pass: 0,
                node: u32::try_from(node).unwrap_or(u32::MAX),
            },
            &row,
        );
    }
    Ok(gaps)
}

/// One entry per unknown.
fn merge(entries: &mut Vec<(usize, f64)>) {
    entries.sort_unstable_by_key(|entry| entry.0);
    let mut merged: Vec<(usize, f64)> = Vec::with_capacity(entries.len());
    for &(column, value) in entries.iter() {
        match merged.last_mut() {
            Some(last) if last.0 == column => last.1 += value,
            _ => merged.push((column, value)),
        }
    }
    *entries = merged;
}

impl Energy for QuadraticProgram {
    fn dofs(&self) -> usize {
        self.load.len()
    }

    fn value(&self, u: &[f64]) -> f64 {
        let mut forces = vec![0.0; u.len()];
        let free = &self.free;
        free.pattern.product(&free.values, u, &mut forces);
        let terms = u.iter().zip(forces.iter().zip(&self.load));
        let of_free: f64 = terms.map(|(u, (k, b))| u * (0.5 * k + b)).sum();
        of_free + self.constant
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        self.free.pattern.product(&self.free.values, u, g);
        g.iter_mut().zip(&self.load).for_each(|(g, b)| *g += b);
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.free.pattern
    }

    fn hessian(&self, _: &[f64], values: &mut [f64]) {
        values.copy_from_slice(&self.free.values);
    }

    fn blocks(&self) -> Vec<Range<usize>> {
        self.blocks.clone()
    }

    fn is_quadratic(&self) -> bool {
        true
    }
}

impl ContactProblem for QuadraticProgram {
    fn energy(&self) -> &dyn Energy {
        self
    }

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn linearize_gaps(&self, _: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok(self.gaps.clone())
    }

    fn has_exact_gaps(&self) -> bool {
        true
    }

    fn prescribed_magnitude(&self) -> f64 {
        let prescribed = self.places.iter().map(|place| place.prescribed().abs());
        prescribed.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(feature = "linear")]
    use crate::{Condensed, Equilibrium, check};

    fn matrix(rows: usize, columns: usize, values: &[(usize, usize, f64)]) -> Entries {
        Entries {
            rows,
            columns,
            values: values.to_vec(),
        }
    }

    /// Springs of stiffness 1 and 3 from a wall to node 1 and on to node 2, whose end, node 0, is held at 0.5 and 2 in turn.
    /// Unknowns: wall, node 1, node 2.
    fn springs() -> Entries {
        let (a, b) = (1.0, 3.0);
        let entries = [
            (0, 0, a),
            (0, 1, -a),
            (1, 0, -a),
            (1, 1, a + b),
            (1, 2, -b),
            (2, 1, -b),
            (2, 2, b),
        ];
        matrix(3, 3, &entries)
    }

    #[cfg(feature = "linear")]
    fn held(at: f64) -> Bounds {
        let mut bounds = Bounds::uniform(3, -1e19, 1e19);
        (bounds.lower[0], bounds.upper[0]) = (at, at);
        bounds
    }

    /// Node 2 is pulled by 6, and node 1 is stopped at 2: v = (0.5, 2, 4), and the stop takes what spring 1 does not carry,
    /// 6 − 1.5.
    #[test]
    #[cfg(feature = "linear")]
    fn springs_against_a_stop() -> Result<(), Error> {
        let rows = matrix(2, 3, &[(0, 1, -0.5), (0, 1, -0.5), (1, 2, -1.0)]);
        let (b, c) = ([0.0, 0.0, -6.0], [2.0, 10.0]);
        let problem = QuadraticProgram::new(&springs(), &b, &rows, &c, &held(0.5))?;
        let conformance = check::energy(&problem, &[0.3, -0.2], 1e-4);
        assert!(conformance.gradient < 1e-8 && conformance.hessian < 1e-8);
        let solution = Condensed::new().solve_from(&problem, problem.start())?;
        let v = problem.unknowns(&solution.state.u);
        for (found, known) in v.iter().zip([0.5, 2.0, 4.0]) {
            assert!((found - known).abs() < 1e-12, "{v:?}");
        }
        assert!((solution.lambda[0] - 4.5).abs() < 1e-12 && solution.lambda[1] == 0.0);
        let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
        assert!((contact[1] + 4.5).abs() < 1e-12, "{contact:?}");
        let reactions = problem.reactions(&v, &contact)?;
        // the wall holds spring 1
        for (found, known) in reactions.iter().zip([-1.5, 0.0, 0.0]) {
            assert!((found - known).abs() < 1e-12, "{reactions:?}");
        }
        // ½·1·1.5² + ½·3·2² − 6·4
        assert!((solution.energy - (1.125 + 6.0 - 24.0)).abs() < 1e-12);
        Ok(())
    }

    /// A row with a prescribed unknown: node 1 is kept 1 beyond the wall, which is at 2.
    #[test]
    #[cfg(feature = "linear")]
    fn rows_of_prescribed_unknowns_push_them() -> Result<(), Error> {
        let rows = matrix(1, 3, &[(0, 1, 1.0), (0, 0, -1.0)]);
        let (b, c) = ([0.0; 3], [-1.0]);
        let problem = QuadraticProgram::new(&springs(), &b, &rows, &c, &held(2.0))?;
        let solution = Condensed::new().solve_from(&problem, problem.start())?;
        let v = problem.unknowns(&solution.state.u);
        for (found, known) in v.iter().zip([2.0, 3.0, 3.0]) {
            assert!((found - known).abs() < 1e-12, "{v:?}");
        }
        let contact = problem.contact_forces(&solution.gaps, &solution.lambda);
        assert!((contact[0] + 1.0).abs() < 1e-12 && (contact[1] - 1.0).abs() < 1e-12);
        let reactions = problem.reactions(&v, &contact)?;
        assert!(reactions.iter().all(|r| r.abs() < 1e-12), "{reactions:?}");
        Ok(())
    }

    #[test]
    fn uncoupled_unknowns_are_blocks() -> Result<(), Error> {
        let diagonal = [(0, 0, 1.0), (1, 1, 2.0), (2, 2, 3.0), (3, 3, 4.0)];
        let coupled = [(2, 0, -0.5), (0, 2, -0.5)];
        let entries = [&diagonal[..], &coupled[..]].concat();
        let none = matrix(0, 4, &[]);
        let free = Bounds::free(4);
        let problem = QuadraticProgram::new(&matrix(4, 4, &entries), &[0.0; 4], &none, &[], &free)?;
        assert_eq!(problem.blocks(), [0..3, 3..4]);
        Ok(())
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let none = matrix(0, 3, &[]);
        let free = Bounds::free(3);
        let refused = |stiffness: &Entries, rows: &Entries, c: &[f64], bounds: &Bounds| {
            let refused = QuadraticProgram::new(stiffness, &[0.0; 3], rows, c, bounds);
            refused.map(drop).expect_err("refused").to_string()
        };
        let mut odd = springs();
        odd.values[1].2 = -1.1;
        let why = refused(&odd, &none, &[], &free);
        assert!(why.contains("K[1, 0] = -1 and K[0, 1] = -1.1"), "{why}");
        let mut penalty = springs();
        penalty.values[0].2 = 1e30;
        let why = refused(&penalty, &none, &[], &free);
        assert!(why.contains("unknown 0") && why.contains("1e30"), "{why}");
        let mut outside = springs();
        outside.values[0].0 = 3;
        let why = refused(&outside, &none, &[], &free);
        assert!(why.contains('3'), "{why}");
        let why = refused(&springs(), &matrix(1, 3, &[]), &[-0.1], &free);
        assert!(why.contains("row 0") && why.contains("-0.1"), "{why}");
        let why = refused(&springs(), &matrix(1, 2, &[]), &[0.0], &free);
        assert!(why.contains("the columns of C"), "{why}");
        let why = refused(&springs(), &none, &[], &Bounds::free(2));
        assert!(why.contains("the lower bounds"), "{why}");
        let why = refused(&springs(), &none, &[], &Bounds::uniform(3, 1.0, -1.0));
        assert!(why.contains("bound"), "{why}");
        let mut nan = springs();
        nan.values[3].2 = f64::NAN;
        let why = refused(&nan, &none, &[], &free);
        assert!(why.contains("entries of K"), "{why}");
    }
}
