//! A smooth solution that is pressed on the plane everywhere.

use std::f64::consts::{FRAC_PI_2, PI};

use ipopt_contact::contact_fem::tensor::{Matrix, Vector};

use super::{Field, MODULI};
use crate::norms::Jet;

/// A product of sines: amplitude · Π_i sin(k_i X_i + φ_i).
#[derive(Clone, Copy, Debug)]
struct Wave<const D: usize> {
    amplitude: f64,
    k: [f64; D],
    phase: [f64; D],
}

impl<const D: usize> Wave<D> {
    /// Its derivative, `times[i]` times by X_i: each turns the phase by π/2 and yields a factor k.
    fn derivative(&self, X: &Vector<D>, times: [i32; D]) -> f64 {
        let factor = |i: usize| {
            let n = times[i];
            let angle = self.k[i] * X[i] + self.phase[i] + f64::from(n) * FRAC_PI_2;
            self.k[i].powi(n) * angle.sin()
        };
        self.amplitude * (0..D).map(factor).product::<f64>()
    }
}

/// On (0, 1)ᴰ, the last coordinate z being the height over the plane:
///
/// u_i = A cos(z) sin(πX_i) Π_{j≠i} cos(πX_j/2), u_D = −B sin(z) (3/2 + Π_i cos(πX_i)).
///
/// On the plane u_D = 0, ∂u_i/∂z = 0 and u_D has no slope, so that there is no shear; the pressure is positive
/// everywhere. On the sides X_i = 0 the body does not move outwards.
#[derive(Clone, Debug)]
pub struct Waves<const D: usize> {
    /// For each component the waves that it is a sum of.
    components: [Vec<Wave<D>>; D],
}

impl<const D: usize> Waves<D> {
    const A: f64 = 0.01;
    const B: f64 = 0.04;

    /// The field of the type's description.
    pub fn new() -> Self {
        let constant = Wave {
            amplitude: 1.0,
            k: [0.0; D],
            phase: [FRAC_PI_2; D],
        };
        let tangential = |i: usize| {
            let mut wave = Wave {
                amplitude: Self::A,
                k: [0.5 * PI; D],
                ..constant
            };
            (wave.k[i], wave.phase[i]) = (PI, 0.0);
            wave.k[D - 1] = 1.0;
            vec![wave]
        };
        let normal = || {
            let sine = |amplitude: f64, k: f64| {
                let mut wave = Wave {
                    amplitude: -Self::B * amplitude,
                    k: [k; D],
                    ..constant
                };
                (wave.k[D - 1], wave.phase[D - 1]) = (1.0, 0.0);
                wave
            };
            vec![sine(1.5, 0.0), sine(1.0, PI)]
        };
        Waves {
            components: std::array::from_fn(|i| match i + 1 == D {
                true => normal(),
                false => tangential(i),
            }),
        }
    }

    fn derivative(&self, i: usize, X: &Vector<D>, times: [i32; D]) -> f64 {
        let waves = self.components[i].iter();
        waves.map(|wave| wave.derivative(X, times)).sum()
    }

    /// ∂²u_i/∂X_j∂X_k.
    fn second(&self, i: usize, j: usize, k: usize, X: &Vector<D>) -> f64 {
        let mut times = [0; D];
        times[j] += 1;
        times[k] += 1;
        self.derivative(i, X, times)
    }
}

impl<const D: usize> Field<D> for Waves<D> {
    fn jet(&self, X: &Vector<D>) -> Jet<D> {
        let once = |j: usize| std::array::from_fn(|k| i32::from(k == j));
        (
            Vector::from_fn(|i, _| self.derivative(i, X, [0; D])),
            Matrix::from_fn(|i, j| self.derivative(i, X, once(j))),
        )
    }

    /// −div σ = −μ Δu − (λ + μ) ∇ div u.
    fn body_force(&self, X: &Vector<D>) -> Vector<D> {
        let [E, nu] = MODULI;
        let lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let mu = E / (2.0 * (1.0 + nu));
        Vector::from_fn(|i, _| {
            let laplacian: f64 = (0..D).map(|j| self.second(i, j, j, X)).sum();
            let slope: f64 = (0..D).map(|j| self.second(j, j, i, X)).sum();
            -mu * laplacian - (lambda + mu) * slope
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::battery;
    use super::*;

    #[test]
    fn the_field_solves_the_contact_problem() {
        let points = [[0.1, 0.3], [0.45, 0.0], [0.99, 0.7], [0.7, 0.2]];
        battery(&Waves::<2>::new(), &points);
        let points = [
            [0.1, 0.3, 0.4],
            [0.45, 0.9, 0.0],
            [0.99, 0.7, 0.5],
            [1.0, 0.0, 0.2],
        ];
        battery(&Waves::<3>::new(), &points);
    }
}
