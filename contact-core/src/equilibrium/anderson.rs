//! Anderson acceleration of a fixed-point map u ↦ G(u).

use std::collections::VecDeque;

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
    residual_steps: VecDeque<Vec<f64>>,
    image_steps: VecDeque<Vec<f64>>,
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Anderson {
    /// Relative cut-off of the least-squares problem: singular values of ΔF below this share of the largest are treated
    /// as zero, since their directions carry only noise.
    const NOISE: f64 = 1e-8;
    /// The most sweeps of its decomposition, which takes less than ten, and what counts as orthogonal.
    const SWEEPS: usize = 60;
    const ORTHOGONAL: f64 = 1e-15;

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
        self.next_by(difference(image, u), image)
    }

    /// The same, where a residual other than image − u tells how far the point is from the fixed one, in any length.
    pub(super) fn next_by(&mut self, residual: Vec<f64>, image: &[f64]) -> Vec<f64> {
        let image = image.to_vec();
        if self.depth == 0 {
            return image;
        }
        if !residual.iter().chain(&image).all(|value| value.is_finite()) {
            self.restart();
            return image;
        }
        if let Some((last_image, last_residual)) = self.last.take() {
            if self.residual_steps.len() == self.depth {
                self.residual_steps.pop_front();
                self.image_steps.pop_front();
            }
            self.residual_steps
                .push_back(difference(&residual, &last_residual));
            self.image_steps.push_back(difference(&image, &last_image));
        }
        let mut next = image.clone();
        for (gamma, step) in self.weights(&residual).into_iter().zip(&self.image_steps) {
            add(-gamma, step, &mut next);
        }
        self.last = Some((image, residual));
        next
    }

    /// γ = argmin ‖f − ΔF γ‖₂, the solution of minimal norm; 0 where differences overflow.
    ///
    /// With ΔF = QR, rotations from the right make the columns of R V orthogonal, which is the singular value decomposition
    /// (M. R. Hestenes, J. SIAM 6 (1958)).
    fn weights(&self, residual: &[f64]) -> Vec<f64> {
        let k = self.residual_steps.len();
        let (mut Q, mut columns) = (Vec::<Vec<f64>>::new(), Vec::new());
        for step in &self.residual_steps {
            let (mut q, mut r) = (step.clone(), vec![0.0; k]);
            // once more for round-off
            for _ in 0..2 {
                for (known, r) in Q.iter().zip(&mut r) {
                    let part = dot(known, &q);
                    add(-part, known, &mut q);
                    *r += part;
                }
            }
            let norm = dot(&q, &q).sqrt();
            if norm > 0.0 {
                q.iter_mut().for_each(|q| *q /= norm);
            }
            r[Q.len()] = norm;
            Q.push(q);
            columns.push(r);
        }
        let residual: Vec<f64> = Q.iter().map(|q| dot(q, residual)).collect();
        let mut V: Vec<Vec<f64>> = (0..k).map(|j| unit(j, k)).collect();
        for _ in 0..Self::SWEEPS {
            let mut is_over = true;
            for j in 1..k {
                for i in 0..j {
                    let [a, b] = [i, j].map(|c| dot(&columns[c], &columns[c]));
                    let both = dot(&columns[i], &columns[j]);
                    let is_noise = a.min(b) <= Self::NOISE.powi(3) * a.max(b);
                    if is_noise || !(both.abs() > Self::ORTHOGONAL * (a * b).sqrt()) {
                        continue;
                    }
                    is_over = false;
                    let half = (b - a) / (2.0 * both);
                    let tangent = half.signum() / (half.abs() + half.hypot(1.0));
                    let cosine = 1.0 / tangent.hypot(1.0);
                    rotate(&mut columns, [i, j], [cosine, cosine * tangent]);
                    rotate(&mut V, [i, j], [cosine, cosine * tangent]);
                }
            }
            if is_over {
                break;
            }
        }
        let squares: Vec<f64> = columns.iter().map(|column| dot(column, column)).collect();
        let largest = squares.iter().fold(0.0, |m: f64, s| m.max(*s));
        let mut gamma = vec![0.0; k];
        for ((column, v), square) in columns.iter().zip(&V).zip(&squares) {
            if *square > Self::NOISE * Self::NOISE * largest {
                add(dot(column, &residual) / square, v, &mut gamma);
            }
        }
        match gamma.iter().chain(&squares).all(|g| g.is_finite()) {
            true => gamma,
            false => vec![0.0; k],
        }
    }
}

fn unit(j: usize, k: usize) -> Vec<f64> {
    (0..k).map(|i| f64::from(u8::from(i == j))).collect()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// y += s x.
fn add(s: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += s * x);
}

/// Rotates the columns i < j by the angle with this cosine and sine.
fn rotate(columns: &mut [Vec<f64>], [i, j]: [usize; 2], [cosine, sine]: [f64; 2]) {
    let (left, right) = columns.split_at_mut(j);
    for (a, b) in left[i].iter_mut().zip(&mut right[0]) {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
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

    /// The solution of minimal norm, by the singular value decomposition of another library; one column is twice another.
    #[test]
    fn weights_are_those_of_least_squares() {
        let columns: [&[f64]; 4] = [
            &[1.0, 2.0, -1.0, 0.5, 3.0],
            &[0.1, -0.3, 2.0, 1.0, 0.0],
            &[2.0, 4.0, -2.0, 1.0, 6.0],
            &[1e-3, 0.0, 3e-3, 0.0, -2e-3],
        ];
        let residual = [0.3, -1.0, 2.0, 0.7, 1.1];
        let mut anderson = Anderson::new(4);
        anderson.residual_steps = columns.iter().map(|column| column.to_vec()).collect();
        let all = nalgebra::DMatrix::from_fn(5, 4, |i, j| columns[j][i]);
        let expected = all
            .svd(true, true)
            .solve(&nalgebra::DVector::from_column_slice(&residual), 1e-7);
        for (a, b) in anderson
            .weights(&residual)
            .iter()
            .zip(expected.expect("solved").iter())
        {
            assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{a} {b}");
        }
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
