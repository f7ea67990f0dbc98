//! How far the next load step of a phase goes: to the end of an increment, a part of the way where that fails, and beyond it where no part
//! succeeds.

use super::{Adaptive, LoadSteps, Phase};

/// The steps of one phase: equal increments that are halved where they fail, or lengths that follow from what steps took.
pub(super) struct Pace<'a> {
    phase: &'a Phase,
    /// Where adaptive steps end, too.
    corners: Vec<f64>,
    began: f64,
    /// The number of increments before the phase, and those of it that are complete.
    before: usize,
    done: usize,
    /// The length of an increment, or of the next adaptive step.
    step: f64,
    /// How often the present increment is halved; no more often than the last number.
    halvings: usize,
    most: usize,
    /// How many increments the next step goes beyond the present one; no more than the last number.
    leap: usize,
    farthest: usize,
}

/// The end of the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    pub factor: f64,
    /// The number of the increment that it completes.
    pub increment: Option<usize>,
}

impl<'a> Pace<'a> {
    pub fn new(
        phase: &'a Phase,
        corners: Vec<f64>,
        (began, before): (f64, usize),
        [most, farthest]: [usize; 2],
    ) -> Self {
        let increment = (phase.until - began) / phase.increments as f64;
        let step = match phase.adaptive {
            Some(Adaptive { least, largest }) => increment.min(largest).max(least),
            None => increment,
        };
        Pace {
            phase,
            corners,
            began,
            before,
            done: 0,
            step,
            halvings: 0,
            most,
            leap: 0,
            farthest,
        }
    }

    /// Load factors that differ by less are equal.
    pub fn close(&self) -> f64 {
        LoadSteps::CLOSE * (self.phase.until - self.began)
    }

    /// The next corner behind `last`, or the end of the phase.
    fn corner(&self, last: f64) -> f64 {
        let (until, close) = (self.phase.until, self.close());
        let corners = self.corners.iter().copied();
        let ahead = corners.filter(|own| *own > last + close && *own < until - close);
        ahead.fold(until, f64::min)
    }

    /// Whether an adaptive step that ends at `factor` ends at a corner.
    pub fn is_corner(&self, factor: f64) -> bool {
        self.phase.adaptive.is_some() && self.corners.contains(&factor)
    }

    /// The end of the next step from `last`; `None` at the end of the phase.
    pub fn next(&self, last: f64) -> Option<Target> {
        let (until, close) = (self.phase.until, self.close());
        if last >= until - close {
            return None;
        }
        let whole = self.step * 0.5f64.powi(self.halvings as i32);
        let ahead = self.done + 1 + self.leap;
        let increment = self.before + ahead;
        let corner = self.corner(last);
        let goal = match self.phase.adaptive {
            // what would be left over is no step of its own
            Some(Adaptive { least, .. }) if last + whole > corner - least + close => corner,
            Some(_) => last + whole,
            None if ahead >= self.phase.increments => until,
            None => self.began + ahead as f64 * self.step,
        };
        let cut = last + whole;
        let arrives = self.phase.adaptive.is_some() || self.leap > 0 || cut > goal - close;
        Some(Target {
            factor: if arrives { goal } else { cut },
            increment: arrives.then_some(increment),
        })
    }

    /// The step to `target` converged in so many iterations.
    pub fn succeeded(&mut self, target: Target, iterations: usize) {
        if target.increment.is_some() {
            self.done += 1 + std::mem::take(&mut self.leap);
        }
        match self.phase.adaptive {
            Some(Adaptive { least, largest }) => {
                let share = Adaptive::ITERATIONS / iterations.max(1) as f64;
                let next = self.step * share.sqrt().clamp(0.5, 2.0);
                self.step = next.min(largest).max(least);
            }
            // after success the step doubles
            None => self.halvings = self.halvings.saturating_sub(1),
        }
    }

    /// Shortens the step from `last` that failed, or tells that it may not be shorter. An adaptive one becomes half as long, or the
    /// least one if that is shorter by a tenth at least; what is left up to the next corner must not be less, either.
    pub fn cut(&mut self, last: f64, failed: Target) -> bool {
        let Some(Adaptive { least, .. }) = self.phase.adaptive else {
            let may = self.halvings < self.most;
            self.halvings += usize::from(may);
            return may;
        };
        let (length, left) = (failed.factor - last, self.corner(last) - last);
        let shorter = least.max(0.5 * length);
        let may = shorter <= 0.9 * length && shorter <= left - least + self.close();
        if may {
            self.step = shorter;
        }
        may
    }

    /// Aims from `last` beyond the increment that failed, by one increment more than before, or tells that it may not be farther, or not
    /// beyond a corner. Adaptive steps do not leap.
    pub fn leap(&mut self, last: f64) -> bool {
        let ahead = self.done + 2 + self.leap;
        let is_before_corner =
            || self.began + ahead as f64 * self.step <= self.corner(last) + self.close();
        let may = self.phase.adaptive.is_none() && self.leap < self.farthest && is_before_corner();
        self.leap += usize::from(may);
        may
    }

    /// Whether the next step goes beyond the present increment.
    pub fn leaps(&self) -> bool {
        self.leap > 0
    }

    /// The number of increments so far, over all phases.
    pub fn increments(&self) -> usize {
        self.before + self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends of the steps of a phase from 1 to 2 that take these iterations, one after the other.
    fn ends(phase: &Phase, iterations: &[usize]) -> Vec<f64> {
        ends_with(&[], phase, iterations)
    }

    fn ends_with(corners: &[f64], phase: &Phase, iterations: &[usize]) -> Vec<f64> {
        let mut pace = Pace::new(phase, corners.to_vec(), (1.0, 5), [0, 0]);
        let (mut last, mut ends) = (1.0, Vec::new());
        let mut iterations = iterations.iter().copied().cycle();
        while let Some(target) = pace.next(last) {
            assert_eq!(target.increment, Some(6 + ends.len()));
            pace.succeeded(target, iterations.next().expect("a cycle"));
            last = target.factor;
            ends.push(last);
        }
        assert_eq!(pace.increments(), 5 + ends.len());
        ends
    }

    /// By hand: 8 iterations keep the length, 2 double it, 32 halve it, and more or less do no more than that.
    #[test]
    fn lengths_follow_from_iterations() {
        let phase = |least: f64, largest: f64| Phase::new("", 2.0, 8).adaptive(least, largest);
        let cases = [
            (phase(0.01, 1.0), vec![8], 8, 0.125),
            (phase(0.01, 1.0), vec![2], 4, 0.125),
            (phase(0.01, 1.0), vec![1], 4, 0.125),
            (phase(0.01, 0.25), vec![2], 5, 0.125),
            (phase(0.25, 0.5), vec![1000], 4, 0.25),
            (phase(0.0625, 0.5), vec![1000], 15, 0.125),
            (phase(0.01, 0.0625), vec![8], 16, 0.0625),
        ];
        for (phase, iterations, count, first) in cases {
            let ends = ends(&phase, &iterations);
            assert_eq!(ends.len(), count, "{phase:?}: {ends:?}");
            assert_eq!(ends[0], 1.0 + first, "{phase:?}");
            assert_eq!(ends.last(), Some(&2.0));
        }
        assert_eq!(ends(&phase(0.01, 1.0), &[2]), [1.125, 1.375, 1.875, 2.0]);
        // what is left over, 0.02, would be shorter than the least step
        let first = Phase::new("", 2.0, 1).adaptive(0.03, 0.49);
        assert_eq!(ends(&first, &[8]), [1.49, 2.0]);
    }

    /// By hand: steps of 1/8 with corners in between, of which two are closer than the least step, and others that are outside.
    #[test]
    fn adaptive_steps_end_at_corners() {
        let corners = [1.4, 0.5, 1.0, 2.0, 3.0, 1.41];
        let phase = Phase::new("", 2.0, 8).adaptive(0.03, 0.125);
        let found = ends_with(&corners, &phase, &[8]);
        let expected = [1.125, 1.25, 1.4, 1.41, 1.535, 1.66, 1.785, 1.91, 2.0];
        // 1.375 would leave 0.025 up to the first corner
        assert_eq!(found.len(), expected.len(), "{found:?}");
        let pairs = found.iter().zip(expected);
        assert!({ pairs }.all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        assert!(found.contains(&1.4) && found.contains(&1.41));
        // equal increments do not
        let equal = Phase::new("", 2.0, 2);
        assert_eq!(ends_with(&corners, &equal, &[8]), [1.5, 2.0]);
        // a step that fails leaves no less than the least one up to the corner
        let phase = Phase::new("", 2.0, 1).adaptive(0.1, 1.0);
        let mut pace = Pace::new(&phase, vec![1.15], (1.0, 0), [16, 0]);
        let target = pace.next(1.0).expect("a step");
        assert_eq!(target.factor, 1.15);
        assert!(!pace.cut(1.0, target));
    }

    #[test]
    fn equal_increments() {
        let phase = Phase::new("", 2.0, 4);
        assert_eq!(ends(&phase, &[100]), [1.25, 1.5, 1.75, 2.0]);
    }

    /// Adaptive steps are halved down to the least one, others as often as they may be.
    #[test]
    fn steps_are_halved_as_far_as_they_may_be() {
        // the ends of the steps from `last` of which each fails
        let tried = |pace: &mut Pace<'_>, last: f64| {
            let mut ends = Vec::new();
            while let Some(target) = pace.next(last) {
                ends.push(target.factor);
                if !pace.cut(last, target) {
                    break;
                }
            }
            ends
        };
        let phase = Phase::new("", 2.0, 8).adaptive(0.03, 1.0);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 0), [16, 0]);
        assert_eq!(tried(&mut pace, 1.0), [1.125, 1.0625, 1.03125]);
        // none is tried twice, and the least one is
        let phase = Phase::new("", 2.0, 1).adaptive(0.24, 1.0);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 0), [16, 0]);
        assert_eq!(tried(&mut pace, 1.0), [2.0, 1.5, 1.25]);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 0), [16, 0]);
        assert_eq!(tried(&mut pace, 1.5), [2.0, 1.75]);
        assert_eq!(tried(&mut pace, 1.55), [2.0]);
        let phase = Phase::new("", 2.0, 2).adaptive(0.4, 1.0);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 0), [16, 0]);
        assert_eq!(tried(&mut pace, 1.0), [1.5, 1.4]);
        let phase = Phase::new("", 2.0, 8);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 0), [1, 0]);
        assert_eq!(tried(&mut pace, 1.0), [1.125, 1.0625]);
        let half = pace.next(1.0).expect("a step");
        assert_eq!((half.factor, half.increment), (1.0625, None));
    }

    /// By hand: increments of 1/4 of which the second is halved once, and then left out with the third; none is beyond the end.
    #[test]
    fn beyond_an_increment_that_fails_is_the_next_one() {
        let phase = Phase::new("", 2.0, 4);
        let mut pace = Pace::new(&phase, Vec::new(), (1.0, 7), [1, 2]);
        let first = pace.next(1.0).expect("a step");
        pace.succeeded(first, 3);
        let whole = pace.next(1.25).expect("a step");
        assert!(pace.cut(1.25, whole) && !pace.cut(1.25, whole));
        for (factor, increment) in [(1.75, 10), (2.0, 11)] {
            assert!(pace.leap(1.25) && pace.leaps());
            let target = pace.next(1.25).expect("a step");
            assert_eq!((target.factor, target.increment), (factor, Some(increment)));
        }
        assert!(!pace.leap(1.25), "the phase ends");
        let target = pace.next(1.25).expect("a step");
        pace.succeeded(target, 3);
        assert!(!pace.leaps() && pace.next(2.0).is_none());
        assert_eq!(pace.increments(), 11);
        let mut none = Pace::new(&phase, Vec::new(), (1.0, 0), [1, 0]);
        assert!(!none.leap(1.0));
        let adaptive = Phase::new("", 2.0, 4).adaptive(0.1, 1.0);
        assert!(!Pace::new(&adaptive, Vec::new(), (1.0, 0), [1, 2]).leap(1.0));
        let mut corner = Pace::new(&phase, vec![1.4], (1.0, 0), [1, 2]);
        assert!(!corner.leap(1.0) && corner.leap(1.4));
    }
}
