//! Iterates that come back to where they were.

use std::collections::VecDeque;

use super::relative_change;

/// Notices that the iterates come back to where they were while they keep moving.
#[derive(Default)]
pub(super) struct CycleDetector {
    /// The latest iterates, newest last.
    recent: VecDeque<Vec<f64>>,
    /// For how many iterations in a row the same period has been seen.
    seen: (usize, usize),
}

impl CycleDetector {
    const LONGEST: usize = 4;
    /// Coming back within this share of the step counts as coming back.
    const CLOSE: f64 = 0.01;
    /// Rounds to watch before it is called a cycle.
    const ROUNDS: usize = 3;

    /// The period, once the iterates have gone round [`Self::ROUNDS`] times.
    pub fn period(&mut self, u: &[f64], error: f64) -> Option<usize> {
        let returns = |old: &Vec<f64>| relative_change(u, old, 0.0) < Self::CLOSE * error;
        // recent[len − p] is U_{n−p}; p = 1 is the ordinary step and no cycle
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
