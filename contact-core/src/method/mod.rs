//! Step 5 of Algorithm 2: ways to minimise E(u) subject to C u + c₀ ≥ 0, one file a method.

#[cfg(feature = "ipopt")]
mod continuation;
#[cfg(feature = "ipopt")]
mod interior_point;
#[cfg(feature = "ipopt")]
mod penalized;
#[cfg(feature = "ipopt")]
mod penalized_slack;
#[cfg(feature = "ipopt")]
mod penalty;
#[cfg(feature = "ipopt")]
mod scaled;

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
use crate::{Cost, Energy, Error, LinearGaps, Scale, Solved, State, Stop};

/// What a method is to minimise: E(u) over `bounds` and `gaps`, all frozen.
#[derive(Clone, Copy)]
pub struct Subproblem<'a> {
    /// E.
    pub energy: &'a dyn Energy,
    /// Bounds on u.
    pub bounds: &'a Bounds,
    /// C u + c₀ ≥ 0.
    pub gaps: &'a LinearGaps,
    /// Units in which numbers are O(1).
    pub scale: Scale,
    /// The relative change of u to expect: the last one, 1 where nothing is known of the start.
    pub change: f64,
    /// The accuracy, relative to the scales, beyond which nothing is gained; 0 for all that the
    /// method is set to.
    pub accuracy: f64,
    /// The request to stop, to be looked at in every iteration.
    pub stop: &'a Stop,
}

/// Step 5: any way to minimise E(u) subject to C u + c₀ ≥ 0.
pub trait Method {
    /// The rows that it wants: by default one a contact node.
    fn sampling(&self) -> Sampling {
        Sampling::Nodes
    }

    /// Solves from `start`; a failure to converge is told by [`Minimum::solved`], not by `Err`.
    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error>;
}

impl<M: Method + ?Sized> Method for &mut M {
    fn sampling(&self) -> Sampling {
        (**self).sampling()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        (**self).minimize(subproblem, start)
    }
}

impl<M: Method + ?Sized> Method for Box<M> {
    fn sampling(&self) -> Sampling {
        (**self).sampling()
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        (**self).minimize(subproblem, start)
    }
}

/// What a method found.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The free unknowns (n, UL).
    pub u: Vec<f64>,
    /// λ ≥ 0, one a row of the gaps (m, UF).
    pub lambda: Vec<f64>,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// Whether u is a minimum at all.
    pub solved: Solved,
    /// What it cost.
    pub cost: Cost,
}
