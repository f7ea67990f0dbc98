//! How the penalty factor μ of methods (37) and (39) grows.

use crate::{Error, Scale};

/// μ → ∞, as far as a scene needs: it grows until what bodies go into each other is small.
///
/// All of it is dimensionless. Lengths are in units of [`Scale::length`], energies in units of
/// [`Scale::energy`], integrals over surfaces in units of [`Scale::area`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuation {
    /// The first μ.
    pub start: f64,
    /// Its growth from one solve to the next.
    pub growth: f64,
    /// The penetration at which it ends, max(−c), as a share of [`Scale::resolution`].
    pub penetration: f64,
    /// The last μ; a subproblem that needs a larger one counts as not solved.
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
    /// One μ and no other, whatever it lets through; (37) fails where that is all of its bound.
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

    /// What may be left of penetration, over [`Scale::length`].
    pub(super) fn allowed(&self, scale: &Scale) -> f64 {
        self.penetration * scale.resolution / scale.length
    }
}
