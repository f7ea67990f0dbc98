//! Detection of periodic iterates.

use std::collections::VecDeque;

use super::relative_change;

/// Detects iterates that repeat with a period of 2 to [`Self::LONGEST`] without converging.
#[derive(Default)]
pub(super) struct CycleDetector {
    /// The latest iterates, newest last.
    recent: VecDeque<Vec<f64>>,
    /// The period seen last (0 for none), and in how many successive iterations.
    seen: (usize, usize),
}

impl CycleDetector {
    /// The longest period detected (iterations).
    const LONGEST: usize = 4;
    /// Two iterates are equal if their relative change is below this share of that of the current step.
    const CLOSE: f64 = 0.01;
    /// The number of periods observed before the iterates count as a cycle.
    const ROUNDS: usize = 3;

    /// The period, once it has been observed [`Self::ROUNDS`] times.
    pub fn period(&mut self, u: &[f64], error: f64) -> Option<usize> {
        let returns = |old: &Vec<f64>| relative_change(u, old, 0.0) < Self::CLOSE * error;
        // recent[len − p] is U_{n−p}; p = 1 is convergence, not a cycle
        let mut back = self.recent.iter().rev().enumerate().skip(1);
        let period = back.find(|(_, old)| returns(old)).map_or(0, |(k, _)| k + 1);
        self.seen = match self.seen {
            (p, times) if p == period => (p, times + 1),
            _ => (period, 1),
        };
        if self.recent.len() == Self::LONGEST {
            self.recent.pop_front();
        }
        self.recent.push_back(u.to_vec());
        (period > 0 && self.seen.1 >= Self::ROUNDS * period).then_some(period)
    }
}
