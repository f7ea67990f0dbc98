//! The limit of the penalty (39), and orders of convergence.

use contact_core::gaps::Sampling;
use contact_core::method::Subproblem;
use contact_core::{Error, InteriorPoint, Method, Minimum, State};

/// Method (7) with one constraint at every integration point instead of one at every contact node:
/// the limit of the penalty (39) for μ → ∞ on a mesh.
#[derive(Clone, Debug, Default)]
pub struct Pointwise(pub InteriorPoint);

impl Method for Pointwise {
    fn sampling(&self) -> Sampling {
        Sampling::Points
    }

    fn minimize(&mut self, subproblem: &Subproblem<'_>, start: &State) -> Result<Minimum, Error> {
        self.0.minimize(subproblem, start)
    }
}

/// k of y ∝ x⁻ᵏ: the slope of the line through the logarithms, by least squares.
pub fn order(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / logs.len() as f64;
    let x = mean(&mut logs.iter().map(|p| p.0));
    let y = mean(&mut logs.iter().map(|p| p.1));
    let covariance: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    -covariance / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
