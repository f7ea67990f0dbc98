//! Continuation in the penalty factor μ of methods (37) and (39).

use crate::{Error, Scale};

/// Continuation μ → ∞: μ grows until the penetration is below its tolerance.
///
/// All quantities are dimensionless: lengths in units of [`Scale::length`], energies of
/// [`Scale::energy`], surface integrals of [`Scale::area`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuation {
    /// The first μ.
    pub start: f64,
    /// The factor on μ from one solve to the next.
    pub growth: f64,
    /// The tolerated penetration max(−c), as a share of [`Scale::resolution`].
    pub penetration: f64,
    /// The largest μ; a subproblem that needs a larger one counts as not solved.
    pub limit: f64,
}

impl Default for Continuation {
    fn default() -> Self {
        Continuation {
            start: 1.0,
            growth: 100.0,
            penetration: 1e-3,
            limit: 1e16,
        }
    }
}

impl Continuation {
    /// A single μ with any penetration. Method (37) fails if a slack reaches its bound −ε.
    pub fn fixed(mu: f64) -> Self {
        Continuation {
            start: mu,
            limit: mu,
            penetration: f64::INFINITY,
            ..Continuation::default()
        }
    }

    /// Checks the settings.
    pub(super) fn validate(&self) -> Result<(), Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let check = Error::check_setting;
        let factor = "a positive penalty factor, such as 1";
        check(positive(self.start), "start", self.start, factor)?;
        let grows = positive(self.growth) && self.growth > 1.0;
        check(grows, "growth", self.growth, "more than 1, such as 100")?;
        let is_last = positive(self.limit) && self.limit >= self.start;
        check(
            is_last,
            "limit",
            self.limit,
            "at least as large as the start",
        )?;
        let remedy = "a positive share of a facet's displacement, such as 1e-3";
        check(
            self.penetration > 0.0,
            "penetration",
            self.penetration,
            remedy,
        )
    }

    /// The tolerated penetration in units of [`Scale::length`].
    pub(super) fn allowed(&self, scale: &Scale) -> f64 {
        self.penetration * scale.resolution / scale.length
    }
}
