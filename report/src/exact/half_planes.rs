//! A cylinder on a block as two half-planes, with the true circle and with gaps along the circle's normals.

use std::f64::consts::{FRAC_PI_2, PI};

/// Frictionless contact of a circle of radius R with a flat body in plane strain.
///
/// Hertz's theory has a parabola and vertical normals. Here the gap at x and the contact force are along the circle's
/// normal, which is inclined by x/R. So the relative tangential displacement w = u_flat − u_round opens gaps by
/// w x/R, and the pressure p has a tangential part p x/R. To the order of (a/R)² of Hertz's solution,
///
/// (2/(πE*)) ∫ p(s)/(x − s) ds = x/R + x³/(2R³) + d(w x/R)/dx + Δ p x/R,
/// w′ = −Δ p − (2/(πE*)) ∫ (p(s) s/R)/(x − s) ds,
///
/// where Δ is the difference of (1 + ν)(1 − 2ν)/E, flat body less round one. On the boundary of the round body, which
/// is above its tangent, what this adds cancels to that order. Bodies are as large as one likes.
#[derive(Clone, Debug)]
pub struct HalfPlanes {
    /// Half of the width of contact (UL).
    a: f64,
    /// p = √(1 − t²) Σ b_j U_{2j}(t), t = x/a (UF/UL²).
    b: [f64; HalfPlanes::TERMS],
}

/// What the solution depends on.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// R (UL).
    pub radius: f64,
    /// P (UF per unit of thickness).
    pub force: f64,
    /// E* (UF/UL²).
    pub modulus: f64,
    /// Δ (UL²/UF).
    pub mismatch: f64,
}

impl HalfPlanes {
    const TERMS: usize = 16;
    /// Points in which the equation is expanded, more than terms for what is not smooth at the ends.
    const POINTS: usize = 256;
    /// What is added is a per cent or so of x/R, which is the factor from one iterate to the next.
    const ITERATIONS: usize = 40;

    /// By iteration from Hertz's solution: the right-hand side with the last p, expanded in Chebyshev polynomials
    /// T_{2j+1} = (1/π) ∫ √(1 − s²) U_{2j}(s)/(t − s) ds; then the a for which ∫ p dx = P.
    pub fn new(pair: &Pair) -> Self {
        let mut b = [0.0; Self::TERMS];
        let a = (4.0 * pair.force * pair.radius / (PI * pair.modulus)).sqrt();
        b[0] = 0.5 * pair.modulus * a / pair.radius;
        let mut solution = HalfPlanes { a, b };
        for _ in 0..Self::ITERATIONS {
            solution = solution.next(pair);
        }
        solution
    }

    fn next(&self, pair: &Pair) -> Self {
        let mut b = [0.0; Self::TERMS];
        let weight = pair.modulus / Self::POINTS as f64;
        for k in 0..Self::POINTS {
            let angle = (k as f64 + 0.5) * PI / Self::POINTS as f64;
            let slope = self.slope(pair, angle);
            for (j, b) in b.iter_mut().enumerate() {
                *b += weight * slope * ((2 * j + 1) as f64 * angle).cos();
            }
        }
        let force = 0.5 * PI * self.a * b[0];
        HalfPlanes {
            a: self.a * (pair.force / force).sqrt(),
            b,
        }
    }

    /// The right-hand side at x = a cos φ.
    fn slope(&self, pair: &Pair, angle: f64) -> f64 {
        let (x, R) = (self.a * angle.cos(), pair.radius);
        // p s is a sum of c_j U_{2j+1}; the integral of s/R p is one of T_{2j+2}
        let (mut shear, mut sheared) = (0.0, 0.0);
        for j in 0..Self::TERMS {
            let c = 0.5 * (self.b[j] + self.b.get(j + 1).unwrap_or(&0.0));
            let n = 2 * j + 2;
            let factor = 2.0 * self.a / (pair.modulus * R) * c;
            shear += factor * (n as f64 * angle).cos();
            sheared += factor * self.a * (cosine_sine(n, FRAC_PI_2) - cosine_sine(n, angle));
        }
        let w = -pair.mismatch * self.force_within(x) - sheared;
        x / R + x.powi(3) / (2.0 * R.powi(3)) + (w - x * shear) / R
    }

    /// p at x (UF/UL²).
    pub fn pressure(&self, x: f64) -> f64 {
        let angle = (x / self.a).clamp(-1.0, 1.0).acos();
        let terms = self.b.iter().enumerate();
        terms
            .map(|(j, b)| b * ((2 * j + 1) as f64 * angle).sin())
            .sum()
    }

    /// The force between the centre and x (UF per unit of thickness).
    pub fn force_within(&self, x: f64) -> f64 {
        let angle = (x / self.a).clamp(-1.0, 1.0).acos();
        let term = |(j, b): (usize, &f64)| b * (sine_sine(j, FRAC_PI_2) - sine_sine(j, angle));
        self.a * self.b.iter().enumerate().map(term).sum::<f64>()
    }

    /// p in the centre (UF/UL²).
    pub fn peak(&self) -> f64 {
        self.pressure(0.0)
    }

    /// 2 √(∫ p x² dx / P), the half-width of the half-ellipse with the same second moment (UL).
    pub fn half_width(&self) -> f64 {
        self.a * (1.0 + self.b[1] / self.b[0]).sqrt()
    }
}

/// ∫ sin((2j + 1) φ) sin φ dφ.
fn sine_sine(j: usize, angle: f64) -> f64 {
    let even = |n: usize| match n {
        0 => angle,
        _ => (n as f64 * angle).sin() / n as f64,
    };
    0.5 * (even(2 * j) - even(2 * j + 2))
}

/// ∫ cos(n φ) sin φ dφ, n ≥ 2.
fn cosine_sine(n: usize, angle: f64) -> f64 {
    let odd = |n: usize| (n as f64 * angle).cos() / n as f64;
    0.5 * (odd(n - 1) - odd(n + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(radius: f64, mismatch: f64) -> Pair {
        Pair {
            radius,
            force: 7.0,
            modulus: 57.7,
            mismatch,
        }
    }

    fn hertz(pair: &Pair) -> [f64; 2] {
        let Pair {
            radius,
            force,
            modulus,
            ..
        } = *pair;
        [
            (force * modulus / (PI * radius)).sqrt(),
            (4.0 * force * radius / (PI * modulus)).sqrt(),
        ]
    }

    /// a/R → 0 at the same a, and the force is P.
    #[test]
    fn hertz_is_the_limit() {
        let flat = pair(5e7, 0.0);
        let [p0, a] = hertz(&flat);
        let solution = HalfPlanes::new(&flat);
        assert!((solution.peak() / p0 - 1.0).abs() < 1e-6);
        assert!((solution.half_width() / a - 1.0).abs() < 1e-6);
        assert!((2.0 * solution.force_within(a * 1.1) / 7.0 - 1.0).abs() < 1e-6);
        let half = solution.pressure(0.5 * a) / p0;
        assert!((half - 0.75_f64.sqrt()).abs() < 1e-6);
        assert!(solution.pressure(1.2 * a).abs() < 1e-9 * p0);
    }

    /// To first order in η = Δ p₀: a grows by 4η/(3π), the peak falls by (1/π + 2G/π − 4/(3π)) η, G being Catalan's
    /// constant, by the inverse of the integral equation in closed form.
    #[test]
    fn the_first_order_is_known() {
        const CATALAN: f64 = 0.915_965_594_177_219;
        let reference = HalfPlanes::new(&pair(500.0, 0.0));
        let of = pair(500.0, 1e-3);
        let (solution, eta) = (HalfPlanes::new(&of), 1e-3 * hertz(&of)[0]);
        let falls = 1.0 - solution.peak() / reference.peak();
        let expected = (1.0 + 2.0 * CATALAN - 4.0 / 3.0) / PI * eta;
        assert!((falls / expected - 1.0).abs() < 1e-2, "{falls} {expected}");
        let grows = solution.a / reference.a - 1.0;
        assert!((grows / (4.0 / (3.0 * PI) * eta) - 1.0).abs() < 1e-2);
    }

    /// The moment by sums.
    #[test]
    fn the_half_width_is_that_of_the_second_moment() {
        let solution = HalfPlanes::new(&pair(20.0, 0.005));
        let points = 200_000;
        let x = |k: usize| (k as f64 + 0.5) / points as f64 * solution.a;
        let sum = |power: i32| -> f64 {
            let terms = (0..points).map(|k| solution.pressure(x(k)) * x(k).powi(power));
            terms.sum()
        };
        let width = 2.0 * (sum(2) / sum(0)).sqrt();
        assert!((width / solution.half_width() - 1.0).abs() < 1e-6);
    }
}
