//! Anderson acceleration of a fixed-point map u ↦ G(u).

use std::collections::VecDeque;

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
    /// Differences whose singular value is below this share of the largest carry only noise.
    const NOISE: f64 = 1e-8;

    /// Nothing remembered yet.
    pub fn new(depth: usize) -> Self {
        Anderson {
            depth,
            residual_steps: VecDeque::new(),
            image_steps: VecDeque::new(),
            last: None,
        }
    }

    /// Forgets everything.
    pub fn restart(&mut self) {
        *self = Anderson::new(self.depth);
    }

    /// The next point, from the current one and its image under G (both n).
    pub fn next(&mut self, u: &[f64], image: &[f64]) -> Vec<f64> {
        if self.depth == 0 {
            return image.to_vec();
        }
        let residual = difference(image, u);
        if let Some((last_image, last_residual)) = self.last.take() {
            if self.residual_steps.len() == self.depth {
                self.residual_steps.pop_front();
                self.image_steps.pop_front();
            }
            self.residual_steps
                .push_back(difference(&residual, &last_residual));
            self.image_steps.push_back(difference(image, &last_image));
        }
        let mut next = image.to_vec();
        for (gamma, step) in self.weights(&residual).into_iter().zip(&self.image_steps) {
            add(&mut next, -gamma, step);
        }
        self.last = Some((image.to_vec(), residual));
        next
    }

    /// γ = argmin ‖f − ΔF γ‖₂, of minimal norm.
    fn weights(&self, residual: &[f64]) -> Vec<f64> {
        let steps: Vec<_> = self.residual_steps.iter().cloned().collect();
        let gamma = least_squares(steps, residual, Self::NOISE);
        match gamma.iter().all(|g| g.is_finite()) {
            true => gamma,
            false => vec![0.0; gamma.len()],
        }
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// a += factor b
fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

/// The w of least norm with the least ‖b − A w‖₂, A by columns, without singular values below `noise` of the largest.
///
/// One-sided Jacobi: rotations V make A V = U Σ, whose columns are orthogonal.
fn least_squares(mut columns: Vec<Vec<f64>>, b: &[f64], noise: f64) -> Vec<f64> {
    let k = columns.len();
    let unit = |j: usize| (0..k).map(|i| f64::from(u8::from(i == j))).collect();
    let mut v: Vec<Vec<f64>> = (0..k).map(unit).collect();
    const SWEEPS: usize = 40; // a handful is enough
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for j in 1..k {
            for i in 0..j {
                if let Some(turn) = rotation(&columns[i], &columns[j]) {
                    rotate(&mut columns, i, j, turn);
                    rotate(&mut v, i, j, turn);
                    rotated = true;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let squares: Vec<f64> = columns.iter().map(|u| dot(u, u)).collect();
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let mut w = vec![0.0; k];
    for ((u, v), square) in columns.iter().zip(&v).zip(squares) {
        if square > noise * noise * largest {
            add(&mut w, dot(u, b) / square, v);
        }
    }
    w
}

/// Cosine and sine that make two columns orthogonal; `None` if they are.
fn rotation(a: &[f64], b: &[f64]) -> Option<(f64, f64)> {
    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
    if !(ab.abs() > f64::EPSILON * (aa * bb).sqrt()) {
        return None;
    }
    let zeta = (bb - aa) / (2.0 * ab);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    Some((cosine, cosine * tangent))
}

fn rotate(columns: &mut [Vec<f64>], i: usize, j: usize, (cosine, sine): (f64, f64)) {
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

    /// A repeated residual gives a zero difference; the weights must stay finite.
    #[test]
    fn survives_a_standstill() {
        let mut anderson = Anderson::new(2);
        for _ in 0..4 {
            assert_eq!(anderson.next(&[1.0, 2.0], &[1.5, 2.0]), vec![1.5, 2.0]);
        }
    }

    /// With columns that depend on each other the solution of least norm, and without noise.
    #[test]
    fn least_squares_of_a_deficient_matrix() {
        let (a, b) = (vec![1.0, 2.0, 2.0], vec![0.0, 1.0, -1.0]);
        let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
        let almost: Vec<f64> = sum.iter().map(|x| x * (1.0 + 1e-13)).collect();
        // b is 2 a − b, so that w is as near to 0 as 2 and −1 can be spread over four columns.
        let rhs = vec![2.0, 3.0, 5.0];
        let w = least_squares(vec![a.clone(), b.clone(), sum, almost], &rhs, 1e-8);
        // A = [a b] M with the rows (1, 0, 1, 1) and (0, 1, 1, 1) of M: w = Mᵀ (M Mᵀ)⁻¹ (2, −1).
        let expected = [1.6, -1.4, 0.2, 0.2];
        let error = difference(&w, &expected);
        assert!(dot(&error, &error).sqrt() < 1e-10, "{w:?}");
        assert_eq!(least_squares(Vec::new(), &rhs, 1e-8), Vec::<f64>::new());
        assert_eq!(least_squares(vec![vec![0.0; 3]], &rhs, 1e-8), [0.0]);
    }
}
