//! How accurately a fixed point has its subproblems solved.

use super::Acceleration;

/// The first solves of an accelerated iteration are rough, since the next ones keep but their first digits.
pub(super) struct Accuracy {
    rough_solves: usize,
}

impl Accuracy {
    /// How many solves are rough. None of them is the last.
    const ROUGH_SOLVES: usize = 2;
    /// The accuracy of rough solves, relative to the scales: this share of the change, counted up to [`Self::CHANGE`].
    /// Measured on the disc-in-disc and the neo-Hookean beams; the counts of iterations depend on both.
    const ROUGH: f64 = 1e-6;
    const CHANGE: f64 = 1e-2;

    pub fn new(acceleration: Acceleration, max_iterations: usize) -> Self {
        Accuracy {
            rough_solves: match acceleration {
                Acceleration::Plain => 0,
                Acceleration::Anderson(_) => Self::ROUGH_SOLVES.min(max_iterations - 1),
            },
        }
    }

    /// The accuracy asked of the solve after `solved` others, if `change` is to be expected; 0 is all that the method
    /// is set to.
    pub fn of(&self, solved: usize, change: f64, rows_are_exact: bool) -> f64 {
        match rows_are_exact || solved >= self.rough_solves {
            true => 0.0,
            false => Self::ROUGH * change.min(Self::CHANGE),
        }
    }
}
