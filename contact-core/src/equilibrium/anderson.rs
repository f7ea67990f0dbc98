//! Anderson acceleration of a fixed-point map u ↦ G(u).

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

/// How the next iterate is formed from the previous ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceleration {
    /// The paper's plain iteration; it may fall into a cycle.
    Plain,
    /// [Anderson acceleration](self) over this many differences.
    Anderson(usize),
}

impl Default for Acceleration {
    /// Anderson acceleration of depth 8. On the disc-in-disc smaller depths take more iterations, and larger ones do
    /// not take fewer.
    fn default() -> Self {
        Acceleration::Anderson(8)
    }
}

/// Anderson acceleration (type II) of bounded depth.
///
/// With residuals f_k = G(u_k) − u_k, the next point is G(u_n) − Σ_j γ_j (G(u_{j+1}) − G(u_j)),
/// where γ minimises ‖f_n − Σ_j γ_j (f_{j+1} − f_j)‖₂ over the last `depth` differences. Depth 0
/// is the plain iteration. D. G. Anderson, J. ACM 12 (1965); H. Walker and P. Ni, SIAM J. Numer.
/// Anal. 49 (2011).
#[derive(Clone, Debug)]
pub struct Anderson {
    depth: usize,
    /// Differences of successive residuals and images, oldest first.
    residual_steps: VecDeque<DVector<f64>>,
    image_steps: VecDeque<DVector<f64>>,
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl Anderson {
    /// Relative cut-off of the least-squares problem: singular values of ΔF below this share of the largest are treated
    /// as zero, since their directions carry only noise.
    const NOISE: f64 = 1e-8;
    /// The iteration limit of its decomposition, which takes a few for each column.
    const SWEEPS: usize = 1000;

    /// With the depth of this setting, 0 for the plain iteration.
    pub fn of(acceleration: Acceleration) -> Self {
        Anderson::new(match acceleration {
            Acceleration::Plain => 0,
            Acceleration::Anderson(depth) => depth,
        })
    }

    /// An empty memory of this depth.
    pub fn new(depth: usize) -> Self {
        Anderson {
            depth,
            residual_steps: VecDeque::new(),
            image_steps: VecDeque::new(),
            last: None,
        }
    }

    /// Clears the memory.
    pub fn restart(&mut self) {
        *self = Anderson::new(self.depth);
    }

    /// The next point, from the current one and its image under G (both n): the image itself where a value is not
    /// finite, which clears the memory.
    pub fn next(&mut self, u: &[f64], image: &[f64]) -> Vec<f64> {
        if self.depth == 0 {
            return image.to_vec();
        }
        if !u.iter().chain(image).all(|value| value.is_finite()) {
            self.restart();
            return image.to_vec();
        }
        let image = DVector::from_column_slice(image);
        let residual = &image - DVector::from_column_slice(u);
        if let Some((last_image, last_residual)) = self.last.take() {
            if self.residual_steps.len() == self.depth {
                self.residual_steps.pop_front();
                self.image_steps.pop_front();
            }
            self.residual_steps.push_back(&residual - last_residual);
            self.image_steps.push_back(&image - last_image);
        }
        let mut next = image.clone();
        for (gamma, step) in self.weights(&residual).into_iter().zip(&self.image_steps) {
            next.axpy(-gamma, step, 1.0);
        }
        self.last = Some((image, residual));
        next.data.into()
    }

    /// γ = argmin ‖f − ΔF γ‖₂, the solution of minimal norm; 0 if the decomposition fails.
    fn weights(&self, residual: &DVector<f64>) -> Vec<f64> {
        if self.residual_steps.is_empty() || residual.is_empty() {
            return Vec::new();
        }
        let steps: Vec<_> = self.residual_steps.iter().cloned().collect();
        let columns = DMatrix::from_columns(&steps);
        // differences of finite values may overflow, and then the decomposition would never end
        let is_finite = columns.iter().all(|value| value.is_finite());
        let svd = match is_finite {
            true => columns.try_svd(true, true, f64::EPSILON, Self::SWEEPS),
            false => None,
        };
        let Some(svd) = svd else {
            return vec![0.0; steps.len()];
        };
        let noise = Self::NOISE * svd.singular_values.max();
        match svd.solve(residual, noise) {
            Ok(gamma) if gamma.iter().all(|g| g.is_finite()) => gamma.data.into(),
            _ => vec![0.0; steps.len()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On an affine map of dimension d, depth d finds the fixed point in d + 1 steps exactly,
    /// even where the plain iteration diverges.
    #[test]
    fn solves_affine_maps_in_finitely_many_steps() {
        let map = |u: &[f64]| {
            vec![
                0.9 * u[0] - 0.4 * u[1] + 1.0,
                0.3 * u[0] - 1.2 * u[1] + 0.2 * u[2],
                0.5 * u[2] - 0.1 * u[0] + 2.0,
            ]
        };
        let mut anderson = Anderson::new(3);
        let mut u = vec![0.0; 3];
        for _ in 0..5 {
            u = anderson.next(&u, &map(&u));
        }
        let error = (0..3)
            .map(|i| (map(&u)[i] - u[i]).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-10, "residual {error}");
        let mut plain = Anderson::new(0);
        assert_eq!(plain.next(&u, &map(&u)), map(&u));
    }

    /// Neither may the decomposition be asked about them, which would never end.
    #[test]
    fn values_that_are_not_finite_clear_the_memory() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut anderson = Anderson::new(2);
            for k in 0..4 {
                let x = f64::from(k);
                anderson.next(&[x, 1.0], &[2.0 * x, -1.0]);
            }
            assert!(anderson.next(&[1.0, 2.0], &[bad, 2.0])[1] == 2.0);
            assert_eq!(anderson.next(&[1.0, 2.0], &[1.5, 2.0]), vec![1.5, 2.0]);
        }
        let mut anderson = Anderson::new(2);
        for sign in [1.0, -1.0, 1.0] {
            let huge = sign * f64::MAX;
            assert_eq!(anderson.next(&[0.0, 1.0], &[huge, 1.0]).len(), 2);
        }
    }

    /// A repeated residual gives a zero difference; the weights must stay finite.
    #[test]
    fn survives_a_standstill() {
        let mut anderson = Anderson::new(2);
        for _ in 0..4 {
            assert_eq!(anderson.next(&[1.0, 2.0], &[1.5, 2.0]), vec![1.5, 2.0]);
        }
    }
}
