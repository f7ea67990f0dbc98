//! The accuracy to which a fixed point has its subproblems solved.

use super::Acceleration;

/// The first solves of an accelerated iteration are rough: later iterates agree with theirs in the first digits only.
pub(super) struct Accuracy {
    rough_solves: usize,
}

impl Accuracy {
    /// The number of rough solves. The last solve an iteration limit allows is never rough.
    const ROUGH_SOLVES: usize = 2;
    /// The accuracy of a rough solve, dimensionless (relative to the scales), is `ROUGH` × min(change, `CHANGE`), where
    /// change is the expected relative change of U. Both were measured on the disc-in-disc and the neo-Hookean beams;
    /// iteration counts depend on them. A rough solve never counts as converged.
    const ROUGH: f64 = 1e-6;
    /// See [`Self::ROUGH`].
    const CHANGE: f64 = 1e-2;

    pub fn new(acceleration: Acceleration, max_iterations: usize) -> Self {
        Accuracy {
            rough_solves: match acceleration {
                Acceleration::Plain => 0,
                Acceleration::Anderson(_) => Self::ROUGH_SOLVES.min(max_iterations - 1),
            },
        }
    }

    /// The accuracy asked of the solve that follows `solved` others, if U is expected to change by `change`; 0 asks for
    /// the method's own tolerance.
    pub fn of(&self, solved: usize, change: f64, rows_are_exact: bool) -> f64 {
        match rows_are_exact || solved >= self.rough_solves {
            true => 0.0,
            false => Self::ROUGH * change.min(Self::CHANGE),
        }
    }
}
