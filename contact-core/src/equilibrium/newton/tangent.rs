//! The symmetric matrix S that is factored, and its factor: body by body as long as no row adds stiffness between them. A
//! body whose part has not changed, since its energy is quadratic, keeps its factor.

use std::collections::BTreeMap;
use std::ops::Range;

use faer::Mat;

use super::super::condensed::halt::Halt;
use super::super::condensed::pruned::gram;
use super::linearization::Linearization;
use crate::gaps::SparseRows;
use crate::linear::{
    Analysis, Cholesky, Factor, FactorError, Kind, Ordering, Reach, SymmetricPattern, postordered,
};
use crate::{Cost, Energy, Error, RowKey, Stop};

/// The factor is kept where the last step changed u by less than this share and took no more corrections than that.
const NEAR: f64 = 1e-2;
const FEW: usize = 8;
/// What is added to K, level by level, until the sum is positive definite: stiffness of the rows that act, relative to their
/// own, and a shift of the diagonal, relative to K's.
const LEVELS: [(f64, f64); 10] = [
    (0.0, 0.0),
    (1.0, 0.0),
    (10.0, 0.0),
    (100.0, 0.0),
    (100.0, 1e-6),
    (100.0, 3e-5),
    (100.0, 9e-4),
    (100.0, 2.7e-2),
    (100.0, 8.1e-1),
    (100.0, 2.4e1),
];
/// The first level with stiffness of rows, which is kept for the rest of a run, and the first with a shift.
const STIFFENED: usize = 1;
const SHIFTED: usize = 4;
/// A new order of elimination is sought where the factor has grown by this ratio.
const FILL: f64 = 1.3;

/// S and its factor. Pattern, order of elimination and factor are kept from one matrix to the next.
pub(super) struct Tangent {
    energy: SymmetricPattern,
    /// The unknowns of each body.
    bodies: Vec<Range<usize>>,
    /// The pattern of S, and the slot of each slot of K.
    pattern: SymmetricPattern,
    slots: Vec<usize>,
    values: Vec<f64>,
    order: Option<Vec<usize>>,
    fill: usize,
    /// One for each body, or one of all where rows have added entries; `None` before the first.
    factors: Option<Vec<Part>>,
    /// The stiffness added to each row, and what the factor has of it.
    added: Vec<f64>,
    stiffened: BTreeMap<RowKey, f64>,
    /// The level of S, an index of [`LEVELS`], and the one at which the search for the next S goes on if [`STIFFENED`] does
    /// not suffice.
    level: usize,
    known: usize,
    /// The least level of the next S, if [`Tangent::raise`] has asked for one.
    raised: Option<usize>,
    /// The relative change and the corrections of the last step.
    last: Option<(f64, usize)>,
    is_fresh: bool,
    /// The diagonal of the K that was factored.
    diagonal: Vec<f64>,
}

/// The factor of a diagonal block of S.
struct Part {
    range: Range<usize>,
    factor: Cholesky,
    /// What is factored; empty if nothing is.
    values: Vec<f64>,
}

impl Part {
    fn new(range: Range<usize>, analysis: &Analysis) -> Result<Self, FactorError> {
        Ok(Part {
            range,
            factor: Cholesky::new(analysis, Kind::Llt)?,
            values: Vec::new(),
        })
    }

    /// Its values among those of S.
    fn of<'a>(&self, pattern: &SymmetricPattern, values: &'a [f64]) -> &'a [f64] {
        let starts = pattern.starts();
        &values[starts[self.range.start]..starts[self.range.end]]
    }

    fn fill(&self) -> usize {
        self.factor.analysis().fill()
    }
}

impl Tangent {
    pub fn new(energy: &dyn Energy) -> Self {
        let pattern = energy.hessian_pattern();
        let mut bodies = energy.blocks();
        bodies.retain(|range| !range.is_empty());
        Tangent {
            pattern: pattern.clone(),
            slots: (0..pattern.len()).collect(),
            energy: pattern.clone(),
            bodies,
            values: Vec::new(),
            order: None,
            fill: 0,
            factors: None,
            added: Vec::new(),
            stiffened: BTreeMap::new(),
            level: 0,
            known: 0,
            raised: None,
            last: None,
            is_fresh: false,
            diagonal: Vec::new(),
        }
    }

    /// Whether it is for the Hessians of this energy.
    pub fn is_of(&self, energy: &dyn Energy) -> bool {
        let mut bodies = energy.blocks();
        bodies.retain(|range| !range.is_empty());
        self.energy == *energy.hessian_pattern() && self.bodies == bodies
    }

    /// The stiffness added to each row (m, UF/UL).
    pub fn added(&self) -> &[f64] {
        &self.added
    }

    /// The ratio of the stiffness added to rows to their own.
    pub fn ratio(&self) -> f64 {
        LEVELS[self.level].0
    }

    /// The shift of the diagonal, relative to K's.
    pub fn shift(&self) -> f64 {
        LEVELS[self.level].1
    }

    /// Entries of the factor.
    pub fn fill(&self) -> usize {
        self.factors.iter().flatten().map(Part::fill).sum()
    }

    /// Whether S is that of the present linearisation.
    pub fn is_fresh(&self) -> bool {
        self.is_fresh
    }

    /// At the start of a run: K is tried by itself again.
    pub fn begin(&mut self) {
        (self.level, self.known) = (0, 0);
        if !self.stiffened.is_empty() {
            self.forget();
        }
    }

    /// Whether the factor has stiffness of a row that nothing holds now.
    pub fn holds_an_open_row(&self, lets_go: impl Fn(RowKey) -> bool) -> bool {
        self.stiffened.keys().any(|&key| lets_go(key))
    }

    /// The factor is not to be kept.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// From now on S has the contact stiffness D, and stiffness of the rows that act: it is positive definite where the
    /// equilibrium is stable, and needs a shift where it is not, so that steps lead down.
    pub fn stiffen(&mut self) {
        self.level = STIFFENED;
        self.forget();
    }

    /// Asks for an S one level higher; false if S is K, is no fresh one, or has the last level.
    pub fn raise(&mut self) -> bool {
        let next = self.level + 1;
        let can_rise = self.is_fresh && self.level >= STIFFENED && next < LEVELS.len();
        self.raised = can_rise.then_some(next);
        self.forget();
        can_rise
    }

    /// Tells how the last step went.
    pub fn moved(&mut self, change: f64, corrections: usize) {
        self.last = Some((change, corrections));
    }

    /// Provides a factor for the step from `here`: the last one if it is near, or else a new one. Rows that overlap by less
    /// than `bound` (UL) and have no force get no stiffness.
    pub fn prepare(
        &mut self,
        here: &Linearization<'_>,
        bound: f64,
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<(), Halt> {
        let last = self.last.take();
        let went_well =
            last.is_some_and(|(change, corrections)| change < NEAR && corrections <= FEW);
        let has_factor = self.factors.is_some() && self.level < SHIFTED;
        if has_factor && went_well && self.is_like(here) {
            self.is_fresh = false;
            let rows = here.gaps.keys().iter().zip(&here.acts);
            let known = |key| self.stiffened.get(key).copied().unwrap_or(0.0);
            self.added = rows
                .map(|(key, acts)| if *acts { known(key) } else { 0.0 })
                .collect();
            return Ok(());
        }
        self.is_fresh = true;
        let pushes = |i: usize| match here.slips.law(i) {
            None => here.lambda[i] > 0.0 || here.overlaps(i, here.c[i], bound),
            Some(law) => here.lambda[law.contact] > 0.0,
        };
        let acting: Vec<bool> = (0..here.gaps.len())
            .map(|i| here.acts[i] && pushes(i))
            .collect();
        let may_add = acting.contains(&true);
        let raised = self.raised.take();
        self.level = raised.unwrap_or(self.level.min(STIFFENED));
        self.known = self.known.saturating_sub(1);
        loop {
            let ratio = self.ratio();
            self.added = acting
                .iter()
                .zip(&here.stiffness)
                .map(|(acts, s)| if *acts { ratio * s } else { 0.0 })
                .collect();
            match self.factorize(here, stop, cost) {
                Err(Halt::Error(Error::Factor(FactorError::NotPositiveDefinite { .. }))) => {}
                factorized => {
                    if self.level > STIFFENED {
                        self.known = self.level;
                    }
                    return factorized;
                }
            }
            let next = (self.level + 1).max(self.known);
            let next = if may_add { next } else { next.max(SHIFTED) };
            if next == LEVELS.len() {
                self.factors = None;
                return Err(Halt::Failed(format!(
                    "the Hessian of the energy stays indefinite with {:.0} times its diagonal added",
                    self.shift()
                )));
            }
            self.level = next;
        }
    }

    /// Whether no K_jj has doubled, halved or changed its sign since K was factored.
    fn is_like(&self, here: &Linearization<'_>) -> bool {
        let mut diagonals = self.diagonal.iter().enumerate();
        diagonals.all(|(j, &then)| (0.5..=2.0).contains(&(here.diagonal[j] / then)))
    }

    /// Factors K + shift diag K and, where stiffness is added to rows, that stiffness − sym D.
    fn factorize(
        &mut self,
        here: &Linearization<'_>,
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<(), Halt> {
        Halt::if_requested(stop)?;
        self.values.clear();
        self.values.resize(self.pattern.len(), 0.0);
        for (&slot, a) in self.slots.iter().zip(&here.hessian) {
            self.values[slot] += a;
        }
        let mut missing = Vec::new();
        if self.ratio() > 0.0 {
            for (i, j, d) in here.contact_stiffness() {
                let half = if i == j { d } else { 0.5 * d };
                self.add(i, j, -half, &mut missing);
            }
        }
        let matrix = here.gaps.matrix();
        let added = std::mem::take(&mut self.added);
        for (row, &s) in added.iter().enumerate().filter(|(_, s)| **s > 0.0) {
            for (i, a) in matrix.row(row) {
                for (j, b) in matrix.row(row).filter(|&(j, _)| j <= i) {
                    self.add(i, j, s * a * b, &mut missing);
                }
            }
        }
        self.added = added;
        let shift = self.shift();
        if shift > 0.0 {
            for j in 0..self.pattern.dim() {
                self.add(j, j, shift * here.diagonal[j].abs(), &mut missing);
            }
        }
        if !missing.is_empty() {
            self.extend(&missing)?;
        }
        let factors = match self.factors.take() {
            Some(factors) => factors,
            None => self.analysed(stop)?,
        };
        let factors = self.factors.insert(factors);
        let stale = factors.iter_mut().filter(|part| {
            let values = part.of(&self.pattern, &self.values);
            part.values.is_empty() || part.values != values
        });
        let mut is_counted = false;
        for part in stale {
            if !is_counted {
                Halt::unless_may_factorize(stop)?;
                cost.factorizations += 1;
                is_counted = true;
            }
            Halt::if_requested(stop)?;
            cost.factor_entries += part.fill() as u64;
            part.values.clear();
            let values = part.of(&self.pattern, &self.values);
            part.factor.refactor(values)?;
            part.values.extend_from_slice(values);
        }
        let rows = here.gaps.keys().iter().zip(&self.added);
        let stiffened = rows.filter(|(_, s)| **s > 0.0);
        self.stiffened = stiffened.map(|(&key, &s)| (key, s)).collect();
        self.diagonal.clone_from(&here.diagonal);
        Ok(())
    }

    fn add(&mut self, i: usize, j: usize, a: f64, missing: &mut Vec<(usize, usize, f64)>) {
        match self.pattern.slot(i, j) {
            Some(slot) => self.values[slot] += a,
            None => missing.push((i, j, a)),
        }
    }

    /// Adds the places that are missing to the pattern, with their values.
    fn extend(&mut self, missing: &[(usize, usize, f64)]) -> Result<(), Error> {
        let places: Vec<_> = missing.iter().map(|&(i, j, _)| (i, j)).collect();
        let (pattern, slots) = self.pattern.with(&places)?;
        let mut values = vec![0.0; pattern.len()];
        slots
            .iter()
            .zip(&self.values)
            .for_each(|(&slot, &a)| values[slot] = a);
        self.slots.iter_mut().for_each(|slot| *slot = slots[*slot]);
        (self.pattern, self.values, self.factors) = (pattern, values, None);
        let mut none = Vec::new();
        missing
            .iter()
            .for_each(|&(i, j, a)| self.add(i, j, a, &mut none));
        Ok(())
    }

    /// Factors to be: one for each body where S has no other entries, else one in the order of the last one, unless it
    /// would grow too much.
    fn analysed(&mut self, stop: &Stop) -> Result<Vec<Part>, Halt> {
        if self.pattern == self.energy {
            Halt::if_requested(stop)?;
            let analyses = Analysis::of_blocks(&self.pattern, &self.bodies, &Ordering::Automatic)?;
            let parts = self.bodies.iter().cloned().zip(&analyses);
            let parts = parts.map(|(range, analysis)| Part::new(range, analysis));
            return Ok(parts.collect::<Result<_, _>>()?);
        }
        let all = 0..self.pattern.dim();
        if let Some(order) = &self.order {
            let order = Ordering::Given(postordered(&self.pattern, order)?);
            let analysis = Analysis::new(&self.pattern, &order)?;
            if analysis.fill() as f64 <= FILL * self.fill as f64 {
                return Ok(vec![Part::new(all, &analysis)?]);
            }
        }
        let analysis = Analysis::new(&self.pattern, &Ordering::Automatic)?;
        self.order = Some(all.clone().map(|k| analysis.unknown(k)).collect());
        self.fill = analysis.fill();
        Ok(vec![Part::new(all, &analysis)?])
    }

    fn factors(&self) -> Result<&[Part], Error> {
        Ok(self.factors.as_deref().ok_or(FactorError::NotFactored)?)
    }

    /// S v (n, UF).
    pub fn times(&self, v: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; v.len()];
        self.pattern.product(&self.values, v, &mut forces);
        forces
    }

    /// S⁻¹b, in place.
    pub fn solve(&mut self, b: &mut [f64]) -> Result<(), Error> {
        let factors = self.factors.as_mut().ok_or(FactorError::NotFactored)?;
        for part in factors {
            part.factor.solve(&mut b[part.range.clone()])?;
        }
        Ok(())
    }

    /// W = C S⁻¹ Cᵀ of some `rows` of C, both triangles, and the part of the factor that it takes.
    pub fn condense(
        &self,
        matrix: &SparseRows,
        rows: &[usize],
        stop: &Stop,
    ) -> Result<(Mat<f64>, Response), Halt> {
        let (mut W, mut parts) = (Mat::zeros(rows.len(), rows.len()), Vec::new());
        for Part { range, factor, .. } in self.factors()? {
            let steps = factor.analysis().steps();
            let own = |(place, &row): (usize, &usize)| {
                let entries = matrix.row(row).filter(|(j, _)| range.contains(j));
                let entries = entries.map(|(j, a)| (place, steps[j - range.start], a));
                entries.collect::<Vec<_>>()
            };
            let entries: Vec<_> = rows.iter().enumerate().flat_map(own).collect();
            let reach = Reach::of(factor, entries.iter().map(|entry| entry.1));
            if !entries.is_empty() {
                W += gram(factor, rows.len(), entries, stop)?;
            }
            parts.push(Seen {
                range: range.clone(),
                reach,
                whole: Reach::whole(factor),
                steps,
            });
        }
        Ok((W, Response(parts)))
    }
}

/// Solves with S in two halves: what the rows see of a solution is known after the first, and forces on the rows can
/// still be added before the second.
pub(super) struct Response(Vec<Seen>);

/// What rows see of a diagonal block.
struct Seen {
    range: Range<usize>,
    /// The part of the factor that the rows see, and all of it.
    reach: Reach,
    whole: Reach,
    /// The step that eliminates each unknown.
    steps: Vec<usize>,
}

impl Seen {
    /// b in the order of elimination.
    fn ordered(&self, b: &[f64]) -> Vec<f64> {
        let mut ordered = vec![0.0; self.steps.len()];
        let own = self.steps.iter().zip(&b[self.range.clone()]);
        own.for_each(|(&k, b)| ordered[k] = *b);
        ordered
    }

    /// Puts a solution in the order of elimination into x.
    fn put(&self, ordered: &[f64], x: &mut [f64]) {
        let own = self.steps.iter().zip(&mut x[self.range.clone()]);
        own.for_each(|(&k, x)| *x = ordered[k]);
    }
}

/// L⁻¹b of each diagonal block, in the order of elimination.
pub(super) struct Half(Vec<Vec<f64>>);

impl Response {
    /// The first half of S⁻¹b.
    pub fn begun(&self, tangent: &Tangent, b: &[f64]) -> Result<Half, Error> {
        let parts = self.0.iter().zip(tangent.factors()?);
        let half = parts.map(|(seen, part)| {
            let mut half = seen.ordered(b);
            part.factor.forward(&seen.whole, &mut half);
            half
        });
        Ok(Half(half.collect()))
    }

    /// The entries of the solution that the rows see (n); the others are of no meaning.
    pub fn seen(&self, tangent: &Tangent, half: &Half) -> Result<Vec<f64>, Error> {
        let mut all = vec![0.0; tangent.pattern.dim()];
        for ((seen, part), half) in self.0.iter().zip(tangent.factors()?).zip(&half.0) {
            let mut x = half.clone();
            part.factor.backward(&seen.reach, &mut x);
            seen.put(&x, &mut all);
        }
        Ok(all)
    }

    /// Adds S⁻¹b for forces b on the rows, and finishes.
    pub fn ended(&self, tangent: &Tangent, half: Half, b: &[f64]) -> Result<Vec<f64>, Error> {
        let mut all = vec![0.0; b.len()];
        for ((seen, part), mut x) in self.0.iter().zip(tangent.factors()?).zip(half.0) {
            let mut added = seen.ordered(b);
            part.factor.forward(&seen.reach, &mut added);
            x.iter_mut().zip(&added).for_each(|(x, a)| *x += a);
            part.factor.backward(&seen.whole, &mut x);
            seen.put(&x, &mut all);
        }
        Ok(all)
    }
}
