//! Step 5 of Algorithm 2: methods that minimise E(u) subject to C u + c₀ ≥ 0, one file per method.

#[cfg(feature = "ipopt")]
mod continuation;
#[cfg(feature = "ipopt")]
pub(crate) mod interior_point;
#[cfg(feature = "ipopt")]
mod penalized;
#[cfg(feature = "ipopt")]
mod penalized_slack;
#[cfg(feature = "ipopt")]
mod penalty;
#[cfg(feature = "ipopt")]
pub(crate) mod scaled;
#[cfg(all(test, feature = "ipopt"))]
mod tests;

#[cfg(feature = "ipopt")]
pub use {
    continuation::Continuation,
    interior_point::InteriorPoint,
    penalized::{Penalization, eta},
    penalized_slack::PenalizedSlack,
    penalty::Penalty,
};

use crate::gaps::Sampling;
use crate::nlp::Bounds;
use crate::{Cost, Energy, Error, LinearGaps, MemoryNeed, Scale, Solved, State, Stop};

/// The problem of a method: minimise E(u) subject to `bounds` and `gaps`, all frozen.
#[derive(Clone, Copy)]
pub struct Subproblem<'a> {
    /// E.
    pub energy: &'a dyn Energy,
    /// Bounds on u.
    pub bounds: &'a Bounds,
    /// C u + c₀ ≥ 0.
    pub gaps: &'a LinearGaps,
    /// Units in which the problem's quantities are O(1).
    pub scale: Scale,
    /// The expected relative change of u: that of the last iteration, or 1 in the first one.
    pub change: f64,
    /// The accuracy, relative to the scales, that suffices for this solve; 0 asks for the method's
    /// own tolerance.
    pub accuracy: f64,
    /// The request to stop, to be checked in every iteration.
    pub stop: &'a Stop,
}

/// Checks that there are no bounds, or as many as unknowns.
pub(crate) fn check_bounds(bounds: &Bounds, dofs: usize) -> Result<(), Error> {
    let Bounds { lower, upper } = bounds;
    if lower.is_empty() && upper.is_empty() {
        return Ok(());
    }
    Error::check_length("the lower bounds on u", lower, dofs)?;
    Error::check_length("the upper bounds on u", upper, dofs)
}

/// A method for step 5: it minimises E(u) subject to C u + c₀ ≥ 0.
pub trait Method {
    /// The name of the optimiser, for records.
    fn name(&self) -> &'static str {
        "custom"
    }

    /// The rows that the method needs; by default one per contact node.
    fn sampling(&self) -> Sampling {
        Sampling::Nodes
    }

    /// What it will take on an energy, by an estimate; `None` where there is none.
    fn memory(&self, _energy: &dyn Energy) -> Option<MemoryNeed> {
        None
    }

    /// Checks the settings; called before a run starts.
    ///
    /// # Errors
    /// The first setting that is out of range.
    fn validate(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Solves from `start`. Failure to converge is reported by [`Minimum::solved`], not by `Err`.
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error>;
}

impl<M: Method + ?Sized> Method for &mut M {
    fn name(&self) -> &'static str {
        (**self).name()
    }

    fn sampling(&self) -> Sampling {
        (**self).sampling()
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        (**self).memory(energy)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        (**self).minimize(subproblem, start)
    }
}

impl<M: Method + ?Sized> Method for Box<M> {
    fn name(&self) -> &'static str {
        (**self).name()
    }

    fn sampling(&self) -> Sampling {
        (**self).sampling()
    }

    fn memory(&self, energy: &dyn Energy) -> Option<MemoryNeed> {
        (**self).memory(energy)
    }

    fn validate(&self) -> Result<(), Error> {
        (**self).validate()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        (**self).minimize(subproblem, start)
    }
}

/// The result of a method.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// λ ≥ 0, one per row of the gaps (m, UF).
    pub lambda: Vec<f64>,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The status; u is a minimum only if it is [`Solved::Optimal`].
    pub solved: Solved,
    /// The cost of the solve.
    pub cost: Cost,
}
