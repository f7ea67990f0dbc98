//! The end of a contact zone as nature makes it: u ~ r^{3/2}, p ~ √r.

use ipopt_contact::contact_fem::tensor::{Matrix, Vector};

use super::{Field, MODULI};
use crate::norms::Jet;

/// Plane strain under Westergaard's stress function Z(z) = i c √z of z = (x − x₀) + i y, y being the height over the
/// plane: the body touches it where x < x₀ with the pressure c √(x₀ − x), and lifts off beyond by
/// (1 − ν)/μ · 2c/3 (x − x₀)^{3/2}.
///
/// With Ẑ = ∫Z dz = i c 2/3 z^{3/2}: σ_xx = Re Z − y Im Z′, σ_yy = Re Z + y Im Z′, σ_xy = −y Re Z′ and
/// 2μ u_x = (1 − 2ν) Re Ẑ − y Im Z, 2μ u_y = 2(1 − ν) Im Ẑ − y Re Z. There is no body force. u is in H^s for
/// s < 5/2, which allows P2 an order of 3/2 in H¹ on meshes that are not refined towards x₀.
///
/// In space nothing depends on the direction between x and the height, in which the body does not move.
#[derive(Clone, Copy, Debug)]
pub struct ZoneEnd {
    /// x₀ (UL).
    pub x0: f64,
}

impl ZoneEnd {
    const C: f64 = 20.0;

    /// Z, Ẑ and Z′ as (real part, imaginary part) at x − x₀ and y ≥ 0.
    fn functions(x: f64, y: f64) -> [[f64; 2]; 3] {
        let (r, angle) = (x.hypot(y), y.atan2(x));
        // i c k zⁿ
        let power = |factor: f64, n: f64| {
            let (sin, cos) = (n * angle).sin_cos();
            let size = Self::C * factor * r.powf(n);
            [-size * sin, size * cos]
        };
        [power(1.0, 0.5), power(2.0 / 3.0, 1.5), power(0.5, -0.5)]
    }
}

impl<const D: usize> Field<D> for ZoneEnd {
    fn jet(&self, X: &Vector<D>) -> Jet<D> {
        let [E, nu] = MODULI;
        let twice_mu = E / (1.0 + nu);
        let y = X[D - 1].max(0.0);
        let [Z, integral, mut slope] = Self::functions(X[0] - self.x0, y);
        if y == 0.0 {
            slope = [0.0; 2]; // it comes with a factor y, which wins over its singularity
        }
        let a = D - 1;
        let (mut u, mut gradient) = (Vector::zeros(), Matrix::zeros());
        u[0] = ((1.0 - 2.0 * nu) * integral[0] - y * Z[1]) / twice_mu;
        u[a] = (2.0 * (1.0 - nu) * integral[1] - y * Z[0]) / twice_mu;
        gradient[(0, 0)] = ((1.0 - 2.0 * nu) * Z[0] - y * slope[1]) / twice_mu;
        gradient[(0, a)] = (-2.0 * (1.0 - nu) * Z[1] - y * slope[0]) / twice_mu;
        gradient[(a, 0)] = (2.0 * (1.0 - nu) * Z[1] - y * slope[0]) / twice_mu;
        gradient[(a, a)] = ((1.0 - 2.0 * nu) * Z[0] + y * slope[1]) / twice_mu;
        (u, gradient)
    }

    fn body_force(&self, _X: &Vector<D>) -> Vector<D> {
        Vector::zeros()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::battery;
    use super::*;

    #[test]
    fn the_field_solves_the_contact_problem() {
        let end = ZoneEnd { x0: 0.1 };
        battery(&end, &[[-0.7, 0.3], [0.05, 0.2], [0.2, 0.1], [0.9, 0.8]]);
        battery(&end, &[[-0.7, 0.4, 0.3], [0.2, 0.3, 0.1], [0.9, 0.0, 0.8]]);
        let law = Field::<2>::law(&end).expect("a law");
        let p = |x: f64| end.pressure(&law, &Vector::<2>::new(x, 0.0));
        assert!(
            (p(-0.15) / p(0.0375) - 2.0).abs() < 1e-12,
            "√ of the distance"
        );
    }
}
