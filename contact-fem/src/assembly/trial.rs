//! The data that all evaluations at one trial u share.

/// The deformation at every quadrature point at the most recent u.
///
/// A solver evaluates domain, value, gradient and Hessian at the same u one after the other.
pub(super) struct Trial<At> {
    u: Vec<f64>,
    is_valid: bool,
    points: Vec<At>,
}

impl<At> Default for Trial<At> {
    fn default() -> Self {
        Trial {
            u: Vec::new(),
            is_valid: false,
            points: Vec::new(),
        }
    }
}

impl<At> Trial<At> {
    /// The deformations at u; `fill` sets all of them, in place of those of another u, if they are not stored.
    pub fn at(&mut self, u: &[f64], fill: impl FnOnce(&mut Vec<At>)) -> &[At] {
        if !(self.is_valid && self.u == u) {
            self.is_valid = false; // until the deformations are complete
            fill(&mut self.points);
            self.u.clear();
            self.u.extend_from_slice(u);
            self.is_valid = true;
        }
        &self.points
    }

    /// Invalidates the stored deformations, as F also depends on prescribed displacements; the
    /// memory is kept.
    pub fn invalidate(&mut self) {
        self.is_valid = false;
    }
}
