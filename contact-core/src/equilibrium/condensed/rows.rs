//! The distinct rows among those of the gaps: parallel ones are one row. Rows of slips come after them.

use std::collections::HashMap;

use super::coulomb::Law;
use crate::friction::SlipRows;
use crate::{ContactProblem, LinearGaps};

/// Coefficients smaller than this share of the row's norm, and differences of rows as small, are round-off.
const ROUNDOFF: f64 = 1e-12;

/// Unit rows, no two of them parallel, in whose terms every row of the gaps is stated.
///
/// Meshes that match have each row twice, once in either pass. Row i of the gaps is sᵢ times the distinct row that it
/// [belongs to](Self::of): its multiplier acts as sᵢ λᵢ on that row, and its gap is sᵢ times as large. A row of slips of norm s is a unit row of its own;
/// the force of friction along it is z = −s r.
pub(super) struct Rows {
    /// The rows that these are made from, to recognise them.
    entries: Vec<(usize, usize, f64)>,
    /// Unknowns and coefficients of each distinct row.
    distinct: Vec<Vec<(usize, f64)>>,
    /// The distinct row and sᵢ of each row of the gaps; nothing for a row without free unknowns.
    of: Vec<Option<(usize, f64)>>,
    /// Whether each distinct row comes from passes alone whose slave is prescribed.
    of_prescribed: Vec<bool>,
    /// The rows of slips that these are made from, and the place and the norm of each; nothing for one without free unknowns.
    slips: SlipRows,
    of_slip: Vec<Option<(usize, f64)>>,
    /// The rows of slips that each distinct row of the gaps presses on.
    pressed: Vec<Vec<usize>>,
}

impl Rows {
    /// The distinct rows of the `gaps` of `problem`, and the rows of their `slips`.
    pub fn new(problem: &dyn ContactProblem, gaps: &LinearGaps, slips: &SlipRows) -> Self {
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); gaps.len()];
        let entries: Vec<_> = gaps.entries().collect();
        entries.iter().for_each(|&(i, j, a)| rows[i].push((j, a)));
        let mut distinct: Vec<Vec<(usize, f64)>> = Vec::new();
        let mut alike: HashMap<Vec<usize>, Vec<usize>> = HashMap::new();
        let mut of = Vec::with_capacity(rows.len());
        for mut row in rows {
            let norm = row.iter().map(|(_, a)| a * a).sum::<f64>().sqrt();
            if !(norm > 0.0) {
                of.push(None);
                continue;
            }
            row.sort_unstable_by_key(|entry| entry.0);
            row.iter_mut().for_each(|(_, a)| *a /= norm);
            row.retain(|(_, a)| a.abs() > ROUNDOFF);
            let known = alike
                .entry(row.iter().map(|entry| entry.0).collect())
                .or_default();
            let same = known.iter().find(|&&k| is_same(&distinct[k], &row));
            let k = same.copied().unwrap_or(distinct.len());
            if k == distinct.len() {
                known.push(k);
                distinct.push(row);
            }
            of.push(Some((k, norm)));
        }
        let has_prescribed_slave = prescribed_slaves(problem);
        let mut of_prescribed = vec![true; distinct.len()];
        for (key, of) in gaps.keys().iter().zip(&of) {
            if let Some((k, _)) = of {
                let is_prescribed = has_prescribed_slave.get(key.pass as usize);
                of_prescribed[*k] &= is_prescribed == Some(&true);
            }
        }
        let mut rows = Rows {
            entries,
            pressed: vec![Vec::new(); distinct.len()],
            distinct,
            of,
            of_prescribed,
            slips: slips.clone(),
            of_slip: Vec::new(),
        };
        rows.append_slips(gaps);
        rows
    }

    fn append_slips(&mut self, gaps: &LinearGaps) {
        let keys = gaps.keys().iter().enumerate();
        let presses: HashMap<_, _> = keys.map(|(i, key)| (*key, i)).collect();
        for (i, key) in self.slips.keys().iter().enumerate() {
            let row: Vec<(usize, f64)> = self.slips.matrix().row(i).collect();
            let norm = row.iter().map(|(_, a)| a * a).sum::<f64>().sqrt();
            let contact = presses.get(key).and_then(|&i| self.of[i]);
            let place = contact.filter(|_| norm > 0.0).map(|(k, _)| {
                self.pressed[k].push(self.distinct.len());
                (self.distinct.len(), norm)
            });
            if place.is_some() {
                let unit = row.iter().map(|&(j, a)| (j, a / norm));
                self.distinct
                    .push(unit.filter(|(_, a)| a.abs() > ROUNDOFF).collect());
            }
            self.of_slip.push(place);
        }
    }

    /// Whether a distinct row comes from passes alone whose slave is prescribed: where the slave's mesh is not finer than the master's,
    /// the rows of the other roles mostly imply it.
    pub fn is_of_prescribed(&self, k: usize) -> bool {
        self.of_prescribed[k]
    }

    /// Whether `gaps` and `slips` have the rows that these are made from. Their constants may be others.
    pub fn are_of(&self, gaps: &LinearGaps, slips: &SlipRows) -> bool {
        self.of.len() == gaps.len()
            && gaps.entries().eq(self.entries.iter().copied())
            && self.slips.has_rows_of(slips)
    }

    /// Number of all rows.
    pub fn len(&self) -> usize {
        self.distinct.len()
    }

    /// Number of distinct rows of the gaps, which are the first.
    pub fn contacts(&self) -> usize {
        self.pressed.len()
    }

    /// The rows of slips that the row `k` of the gaps presses on.
    pub fn pressed_by(&self, k: usize) -> &[usize] {
        &self.pressed[k]
    }

    /// The laws of the rows of slips, for rows of the gaps with these constants.
    pub fn laws(&self, gaps: &LinearGaps, roundoff: f64) -> Vec<Law> {
        if self.slips.is_empty() {
            return Vec::new();
        }
        let shares = self.shares(gaps.constant(), roundoff);
        let keys = gaps.keys().iter().zip(&self.of).zip(shares);
        let presses: HashMap<_, _> = keys.map(|((key, of), share)| (*key, (of, share))).collect();
        let all = self.slips.keys().iter().zip(&self.of_slip).enumerate();
        let law = |(i, (key, of)): (usize, (_, &Option<(usize, f64)>))| {
            let (slip, norm) = (*of)?;
            let (contact, share) = presses.get(key)?;
            Some(Law {
                slip,
                contact: (**contact)?.0,
                factor: norm * share * self.slips.coefficients()[i],
                bound: norm * self.slips.bounds()[i],
            })
        };
        all.filter_map(law).collect()
    }

    /// The force of friction r of a row of slips (UF), of the multipliers of all rows; nothing where no free unknown moves it.
    pub fn friction(&self, slip: usize, lambda: &[f64]) -> Option<f64> {
        self.of_slip[slip].map(|(k, norm)| -lambda[k] / norm)
    }

    /// Unknowns and coefficients of a distinct row, ascending.
    pub fn row(&self, k: usize) -> &[(usize, f64)] {
        &self.distinct[k]
    }

    /// Row · u.
    pub fn product(&self, k: usize, u: &[f64]) -> f64 {
        self.distinct[k].iter().map(|&(j, a)| a * u[j]).sum()
    }

    /// Adds Cᵀλ of the distinct rows to `forces`.
    pub fn add_forces(&self, lambda: &[f64], forces: &mut [f64]) {
        let acting = self.distinct.iter().zip(lambda).filter(|(_, l)| **l != 0.0);
        acting.for_each(|(row, l)| row.iter().for_each(|&(j, a)| forces[j] += a * l));
    }

    /// The multipliers of the distinct rows, of those of the rows of the gaps.
    pub fn gathered(&self, lambda: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.len()]; // multipliers of slips stay zero
        for (of, l) in self.of.iter().zip(lambda) {
            if let Some((k, s)) = of {
                sums[*k] += s * l;
            }
        }
        sums
    }

    /// The constant of each row: the least of those of the gaps that are one, whose gap closes first, then those of the `slips`.
    pub fn all_constants(&self, gaps: &[f64], slips: &[f64]) -> Vec<f64> {
        let mut all = self.constants(gaps);
        let own = self.of_slip.iter().zip(slips);
        all.extend(own.filter_map(|(of, d)| of.map(|(_, norm)| d / norm)));
        all
    }

    /// The constant of each distinct row of the gaps.
    fn constants(&self, constants: &[f64]) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; self.contacts()];
        for (of, c) in self.of.iter().zip(constants) {
            if let Some((k, s)) = of {
                least[*k] = least[*k].min(c / s);
            }
        }
        least
    }

    /// The multipliers of the rows of the gaps, see [`Rows::shares`].
    pub fn shared(&self, lambda: &[f64], constants: &[f64], roundoff: f64) -> Vec<f64> {
        let shares = self.of.iter().zip(self.shares(constants, roundoff));
        let own = shares.map(|(of, share)| of.map_or(0.0, |(k, _)| share * lambda[k]));
        own.collect()
    }

    /// The multiplier of each row of the gaps over that of its distinct row: those that are one share its force evenly, as far as their gaps, which
    /// their `constants` tell, close within `roundoff` (UL) of each other.
    fn shares(&self, constants: &[f64], roundoff: f64) -> Vec<f64> {
        let least = self.constants(constants);
        let close = |(k, s): (usize, f64), c: f64| c / s - least[k] <= roundoff;
        let mut sharers = vec![0usize; self.contacts()];
        for (of, &c) in self.of.iter().zip(constants) {
            if let Some((k, _)) = of.filter(|&of| close(of, c)) {
                sharers[k] += 1;
            }
        }
        let share = |(of, &c): (&Option<(usize, f64)>, &f64)| {
            let (k, s) = of.filter(|&of| close(of, c))?;
            Some(1.0 / (s * sharers[k] as f64))
        };
        let shares = self.of.iter().zip(constants).map(share);
        shares.map(Option::unwrap_or_default).collect()
    }

    /// The rows of the gaps that no free unknown moves.
    pub fn immovable(&self) -> impl Iterator<Item = usize> + '_ {
        let rows = self.of.iter().enumerate();
        rows.filter_map(|(i, of)| of.is_none().then_some(i))
    }
}

/// For each pass whether its slave has no unknowns, and its master does.
fn prescribed_slaves(problem: &dyn ContactProblem) -> Vec<bool> {
    let Some(separable) = problem.separable() else {
        return Vec::new();
    };
    let bodies = separable.bodies();
    let moves = |body: usize| bodies[body].dofs() > 0;
    let passes = separable.passes().into_iter();
    passes
        .map(|[slave, master]| !moves(slave) && moves(master))
        .collect()
}

/// Whether two unit rows in the same unknowns are one.
fn is_same(a: &[(usize, f64)], b: &[(usize, f64)]) -> bool {
    let mut pairs = a.iter().zip(b);
    pairs.all(|((_, a), (_, b))| (a - b).abs() <= ROUNDOFF)
}
