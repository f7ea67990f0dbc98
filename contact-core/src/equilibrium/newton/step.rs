//! Newton's step: the linearised contact problem, solved by defect correction.

use faer::Mat;

use super::super::Acceleration;
use super::super::anderson::Anderson;
use super::super::condensed::coulomb::solve_coulomb;
use super::super::condensed::halt::Halt;
use super::linearization::Linearization;
use super::tangent::{Response, Tangent};
use crate::{Cost, Stop};

/// Bounds on the accuracy of a step, see [`Accuracy`].
const LOOSE: f64 = 1e-1;
const TIGHT: f64 = 1e-3;
/// The most corrections of one step.
const CORRECTIONS: usize = 10;
/// A last correction above this share of the step shows that the corrections do not converge.
const UNSETTLED: f64 = 0.5;
/// Differences that Anderson's method uses.
const DEPTH: usize = 8;
/// Bound on what is left of the complementarity, relative to the largest gap.
const SHARE_OF_GAPS: f64 = 1e-12;
/// Rows contradict each other where so much is left of the largest gap, and of the displacements.
const CONTRADICTION: f64 = 0.1;
const VISIBLE: f64 = 1e-6;
/// Rows that would overlap by more than this share of the displacements join the condensed ones.
const OVERLAP: f64 = 1e-10;

/// Newton's step.
pub(super) struct Step {
    /// The change of u (n, UL).
    pub x: Vec<f64>,
    /// The new multipliers (m, UF), with what added stiffness pulls.
    pub lambda: Vec<f64>,
    /// The largest entry of x (UL).
    pub length: f64,
    /// The number of corrections, and whether the last one is at most [`UNSETTLED`] times the step.
    pub corrections: usize,
    pub is_settled: bool,
    /// What the last of them was made with.
    pub condensed: Condensed,
}

/// The rows that are condensed, and their compliance W.
pub(super) struct Condensed {
    pub rows: Vec<usize>,
    pub W: Mat<f64>,
    pub response: Response,
}

/// The accuracy of a step: the largest correction that may be its last.
pub(super) struct Accuracy {
    /// The length of the step before (UL).
    pub before: Option<f64>,
    /// A correction that is not needed, however short the step is (UL).
    pub negligible: f64,
    /// What may be left of the complementarity, as a share of the displacements.
    pub gaps: f64,
}

impl Accuracy {
    /// For a step of this length (UL): its length times η, the square of its ratio to the step before within bounds. Steps
    /// that become rapidly shorter are worth more corrections (after the second choice of Eisenstat and Walker, SIAM J. Sci.
    /// Comput. 17 (1996), with lengths of steps for norms of residuals).
    fn at(&self, length: f64) -> f64 {
        let tighter = |before: f64| (length / before).powi(2).clamp(TIGHT, LOOSE);
        (self.before.map_or(LOOSE, tighter) * length).max(self.negligible)
    }
}

impl Step {
    /// The step from `here`; `least` is the size of the displacements so far (UL).
    pub fn new(
        here: &Linearization<'_>,
        tangent: &mut Tangent,
        least: f64,
        accuracy: &Accuracy,
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<Self, Halt> {
        tangent.prepare(here, OVERLAP * least, stop, cost)?;
        let close = (0..here.slips.contacts())
            .filter(|&i| here.acts[i] || here.overlaps(i, here.c[i], OVERLAP * least));
        let mut step = Step {
            x: vec![0.0; here.load.len()],
            lambda: here.lambda.clone(),
            length: 0.0,
            corrections: 0,
            is_settled: false,
            condensed: Condensed::new(close.collect(), here, tangent, stop)?,
        };
        let mut anderson = Anderson::of(Acceleration::Anderson(DEPTH));
        loop {
            Halt::if_requested(stop)?;
            let condensed = &step.condensed;
            let (image, lambda) =
                condensed.corrected(here, &step, tangent, (least, accuracy.gaps), stop, cost)?;
            step.corrections += 1;
            let change = largest(image.iter().zip(&step.x).map(|(a, b)| a - b));
            step.length = largest(image.iter().copied());
            if !step.length.is_finite() {
                return Err(Halt::Failed("Newton's step is not finite".into()));
            }
            step.lambda = lambda;
            let is_last = step.corrections >= CORRECTIONS;
            let missing = step.condensed.missing(here, &image, OVERLAP * least);
            if !missing.is_empty() && !is_last {
                let mut rows = step.condensed.rows;
                rows.retain(|&i| here.slips.law(i).is_none());
                rows.extend(missing);
                rows.sort_unstable();
                step.condensed = Condensed::new(rows, here, tangent, stop)?;
                step.x = image;
                anderson.restart();
                continue;
            }
            let is_exact = here.is_frozen() && tangent.is_fresh();
            let is_settled = is_exact || change <= accuracy.at(step.length);
            if is_last || is_settled {
                step.is_settled = is_settled || change <= UNSETTLED * step.length;
                let left = accuracy.gaps * least;
                step.lambda = here.pushes(&image, step.lambda, tangent.added(), left);
                step.x = image;
                return Ok(step);
            }
            step.x = anderson.next(&step.x, &image);
        }
    }
}

impl Condensed {
    /// With these `rows` of contact, which ascend, and the rows of slips that they press on.
    fn new(
        mut rows: Vec<usize>,
        here: &Linearization<'_>,
        tangent: &Tangent,
        stop: &Stop,
    ) -> Result<Self, Halt> {
        here.slips.append_pressed(&mut rows);
        Halt::if_too_many(rows.len())?;
        let (W, response) = tangent.condense(here.gaps.matrix(), &rows, stop)?;
        Ok(Condensed { rows, W, response })
    }

    /// x' and μ of one correction.
    fn corrected(
        &self,
        here: &Linearization<'_>,
        step: &Step,
        tangent: &Tangent,
        (least, share): (f64, f64),
        stop: &Stop,
        cost: &mut Cost,
    ) -> Result<(Vec<f64>, Vec<f64>), Halt> {
        let shift = if here.is_stable { 0.0 } else { tangent.shift() };
        let (mut forces, mut gaps) = here.defect(&step.x, tangent.added(), shift);
        here.gaps.add_forces(&step.lambda, &mut forces);
        let half = self.response.begun(tangent, &forces)?;
        let seen = self.response.seen(tangent, &half)?;
        let matrix = here.gaps.matrix();
        self.rows
            .iter()
            .for_each(|&i| gaps[i] += matrix.times(i, &seen));
        let of = |values: &[f64]| self.rows.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let (known, gaps) = (of(&step.lambda), of(&gaps));
        let deepest = largest(gaps.iter().copied());
        let bound = (share * least).max(SHARE_OF_GAPS * deepest);
        let laws = here.slips.laws_among(&self.rows);
        let solved = solve_coulomb(&self.W, &gaps, &known, &laws, bound, stop)?;
        cost.solves += 1;
        cost.inner_iterations += solved.steps;
        if solved.left * bound > (CONTRADICTION * deepest).max(VISIBLE * least) {
            return Err(Halt::Failed(
                "the linearised rows contradict each other: no step satisfies all of them".into(),
            ));
        }
        let mut lambda = step.lambda.clone();
        let mut change = vec![0.0; lambda.len()];
        for ((&i, new), known) in self.rows.iter().zip(&solved.lambda).zip(&known) {
            lambda[i] = *new;
            change[i] = new - known;
        }
        let mut pushed = vec![0.0; step.x.len()];
        here.gaps.add_forces(&change, &mut pushed);
        let mut image = self.response.ended(tangent, half, &pushed)?;
        image.iter_mut().zip(&step.x).for_each(|(z, x)| *z += x);
        Ok((image, lambda))
    }

    /// The rows, not condensed yet, that overlap by more than `bound` (UL) after the step `x`.
    fn missing(&self, here: &Linearization<'_>, x: &[f64], bound: f64) -> Vec<usize> {
        let matrix = here.gaps.matrix();
        let overlaps = |i: &usize| here.overlaps(*i, here.c[*i] + matrix.times(*i, x), bound);
        let others = (0..here.c.len()).filter(|i| self.rows.binary_search(i).is_err());
        others.filter(overlaps).collect()
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |norm: f64, v| {
        if norm.is_nan() || v.is_nan() {
            f64::NAN
        } else {
            norm.max(v.abs())
        }
    })
}
