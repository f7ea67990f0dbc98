//! The smallest volume ratio within a quadratic cell, bounded from below.
//!
//! The tangents ∂x/∂ξ of a quadratic cell are linear in ξ, so that det ∂x/∂ξ is a polynomial of degree D. With Bernstein
//! coefficients c of one state and C > 0 of another, Σ c B = Σ (c/C) C B is at least min(c/C) Σ C B: no ratio of the two volumes is
//! smaller than the smallest ratio of their coefficients, and at corners the two are equal. Cells are bisected until
//! they are close (G. Farin, Curves and Surfaces for CAGD, chapters on blossoms and triangles).

use super::CELL_EDGES;
use crate::tensor::{Matrix, Vector, determinant};

/// The positions of a quadratic cell's nodes (UL); in the plane the last four are not used.
pub(crate) type CellNodes<const D: usize> = [Vector<D>; 10];

/// A bound is close to a value if it is less than this share of it below.
const CLOSE: f64 = 0.01;
/// A cell is cut at most so often, and has at most so many parts that are not close enough. What is not decided then counts
/// as not positive.
const MOST_CUTS: usize = 500;
const MOST_PARTS: usize = 64;
/// The relative round-off of a coefficient, with respect to the product of the longest tangents: a few operations for
/// each of the D tangents and each term of the determinant.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;

/// The smallest volume ratio within a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeastRatio {
    /// No volume ratio within the cell is smaller.
    pub bound: f64,
    /// The smallest ratio found, and where: barycentric coordinates of D + 1 corners.
    pub found: f64,
    pub lambda: [f64; 4],
}

impl LeastRatio {
    /// The place of what was found in the cell with these nodes.
    pub fn place<const D: usize>(&self, x: &CellNodes<D>) -> Vector<D> {
        let lambda = &self.lambda;
        let corners = (0..=D).map(|a| x[a] * (lambda[a] * (2.0 * lambda[a] - 1.0)));
        let middles = CELL_EDGES[..D * (D + 1) / 2].iter().zip(&x[D + 1..]);
        let middles = middles.map(|([a, b], x)| x * (4.0 * lambda[*a] * lambda[*b]));
        corners.chain(middles).sum()
    }

    /// Whether it is decided that all volumes are positive, or that one is not, and the bound is close to the smaller of
    /// `goal` and what was found.
    pub fn is_over(&self, goal: f64) -> bool {
        let best = self.found.min(goal);
        let is_close = self.bound >= best - CLOSE * best.abs();
        is_close && (self.bound > 0.0 || self.found <= 0.0)
    }
}

/// det ∂x/∂ξ as a symmetric form, one number for each D-tuple of corners, the first of which counts fastest: the value at λ is
/// Σ f(i, j, …) λ_i λ_j …, and the numbers are the Bernstein coefficients.
type Form = [f64; 64];

/// The number of D-tuples of corners.
const fn tuples<const D: usize>() -> usize {
    (D + 1).pow(D as u32)
}

/// Corner `k` of a tuple.
const fn corner_of<const D: usize>(tuple: usize, k: usize) -> usize {
    tuple / (D + 1).pow(k as u32) % (D + 1)
}

/// The tuple that repeats a corner.
const fn repeated<const D: usize>(corner: usize) -> usize {
    corner * (tuples::<D>() - 1) / D
}

/// The form of a cell, and the round-off of its numbers.
fn form<const D: usize>(x: &CellNodes<D>) -> (Form, f64) {
    // Bézier points, relative to a corner: with a and b, they give the quadratic on the edge
    let from = |a: usize| x[a] - x[0];
    let point = |a: usize, b: usize| {
        let edge = CELL_EDGES.iter().position(|e| *e == [a, b] || *e == [b, a]);
        match edge {
            Some(edge) => from(D + 1 + edge) * 2.0 - (from(a) + from(b)) * 0.5,
            None => from(a),
        }
    };
    let mut tangents = [[Vector::<D>::zeros(); 4]; D];
    for (i, tangents) in tangents.iter_mut().enumerate() {
        for (k, tangent) in tangents[..=D].iter_mut().enumerate() {
            *tangent = (point(k, i + 1) - point(k, 0)) * 2.0;
        }
    }
    let count = tuples::<D>();
    let mut product = [0.0; 64];
    for (tuple, value) in product[..count].iter_mut().enumerate() {
        let columns: [_; D] = std::array::from_fn(|k| tangents[k][corner_of::<D>(tuple, k)]);
        *value = determinant(&Matrix::from_columns(&columns));
    }
    let orders: &[[usize; 3]] = match D {
        2 => &[[0, 1, 2], [1, 0, 2]],
        _ => &[
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [2, 1, 0],
            [1, 0, 2],
        ],
    };
    let mut form = [0.0; 64];
    for (tuple, value) in form[..count].iter_mut().enumerate() {
        let ordered = |order: &[usize; 3]| -> f64 {
            let place = |k: usize| (D + 1).pow(k as u32) * corner_of::<D>(tuple, order[k]);
            product[(0..D).map(place).sum::<usize>()]
        };
        *value = orders.iter().map(ordered).sum::<f64>() / orders.len() as f64;
    }
    let nodes = if D == 2 { 6 } else { 10 };
    let longest = (0..nodes).map(|a| from(a).amax()).fold(0.0, f64::max);
    (form, ROUNDOFF * (2.0 * longest).powi(D as i32))
}

/// A part of a cell: the forms of both states on it, and its corners in barycentric coordinates of the cell.
#[derive(Clone)]
struct Part<const D: usize> {
    now: Form,
    rest: Form,
    corners: [[f64; 4]; 4],
    bound: f64,
}

impl<const D: usize> Part<D> {
    fn new(now: Form, rest: Form, corners: [[f64; 4]; 4]) -> Self {
        let ratios = now.iter().zip(&rest).take(tuples::<D>());
        let bound = ratios.fold(f64::INFINITY, |least, (now, rest)| {
            least.min(ratio(*now, *rest))
        });
        Part {
            now,
            rest,
            corners,
            bound,
        }
    }

    /// The ratio at a corner.
    fn at(&self, corner: usize) -> f64 {
        let tuple = repeated::<D>(corner);
        ratio(self.now[tuple], self.rest[tuple])
    }

    /// The two halves on both sides of the middle of the longest edge, which is the last of the two corners returned.
    fn halves(&self) -> [(Self, usize); 2] {
        let length = |a: usize, b: usize| -> f64 {
            let pairs = self.corners[a].iter().zip(&self.corners[b]);
            pairs.map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let mut longest = (0, 1);
        for (a, b) in (0..=D).flat_map(|b| (0..b).map(move |a| (a, b))) {
            if length(a, b) > length(longest.0, longest.1) {
                longest = (a, b);
            }
        }
        let (a, b) = longest;
        let mut middle = self.corners[a];
        let ends = middle.iter_mut().zip(&self.corners[b]);
        ends.for_each(|(m, b)| *m = 0.5 * (*m + b));
        [(a, b), (b, a)].map(|(kept, moved)| {
            let mut corners = self.corners;
            corners[moved] = middle;
            let now = with_middle::<D>(&self.now, kept, moved);
            let rest = with_middle::<D>(&self.rest, kept, moved);
            (Part::new(now, rest, corners), moved)
        })
    }
}

/// The form with the corner `moved` at the middle of its edge to `kept`: as it is linear in each corner, the mean of both.
fn with_middle<const D: usize>(form: &Form, kept: usize, moved: usize) -> Form {
    let mut form = *form;
    for k in 0..D {
        let stride = (D + 1).pow(k as u32);
        for tuple in (0..tuples::<D>()).filter(|&tuple| corner_of::<D>(tuple, k) == moved) {
            form[tuple] = 0.5 * (form[tuple] + form[tuple - moved * stride + kept * stride]);
        }
    }
    form
}

/// now / rest; −∞ where the rest is no volume, or the ratio no number.
fn ratio(now: f64, rest: f64) -> f64 {
    let ratio = if rest > 0.0 { now / rest } else { f64::NAN };
    if ratio.is_nan() {
        f64::NEG_INFINITY
    } else {
        ratio
    }
}

/// A lower bound of the volume ratio of the cell with nodes at `now` to that with nodes at `rest`, and the smallest ratio found.
///
/// They are close, or more than `goal`, the smallest ratio that is known of other cells. With −∞ for the goal, the sign is all
/// that is decided.
pub(crate) fn least_ratio<const D: usize>(
    now: &CellNodes<D>,
    rest: &CellNodes<D>,
    goal: f64,
) -> LeastRatio {
    let ((now, error), (rest, error_at_rest)) = (form::<D>(now), form::<D>(rest));
    let corners = std::array::from_fn(|k| std::array::from_fn(|i| f64::from(u8::from(i == k))));
    let whole = Part::<D>::new(now, rest, corners);
    let smallest = rest[..tuples::<D>()]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let slack = |bound: f64| match smallest > 0.0 && bound.is_finite() {
        true => (error + bound.abs() * error_at_rest) / smallest,
        // where a coefficient at rest is not positive, there is no bound until the parts are known
        false => 0.0,
    };
    let mut least = LeastRatio {
        bound: whole.bound - slack(whole.bound),
        found: f64::INFINITY,
        lambda: [0.0; 4],
    };
    let find = |least: &mut LeastRatio, part: &Part<D>, corner: usize| {
        let found = part.at(corner);
        if !(found >= least.found) {
            (least.found, least.lambda) = (found, part.corners[corner]);
        }
    };
    (0..=D).for_each(|corner| find(&mut least, &whole, corner));
    if least.is_over(goal) {
        return least;
    }
    let (mut parts, mut settled) = (vec![whole], f64::INFINITY);
    for _ in 0..MOST_CUTS {
        let lowest = (0..parts.len()).min_by(|&a, &b| parts[a].bound.total_cmp(&parts[b].bound));
        let Some(lowest) = lowest.filter(|_| parts.len() < MOST_PARTS && !least.is_over(goal))
        else {
            break;
        };
        for (half, middle) in parts.swap_remove(lowest).halves() {
            find(&mut least, &half, middle);
            parts.push(half);
        }
        // what is close enough now stays so, as less and less is found
        parts.retain(|part| {
            let bound = part.bound - slack(part.bound);
            let is_settled = LeastRatio { bound, ..least }.is_over(goal);
            settled = if is_settled {
                settled.min(part.bound)
            } else {
                settled
            };
            !is_settled
        });
        let bounds = parts.iter().map(|part| part.bound);
        let bound = bounds.fold(settled, f64::min);
        least.bound = bound - slack(bound);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::unit_vector;

    /// Numbers between −1 and 1, always the same.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    /// The reference cell with nodes moved by up to `by`.
    fn cell<const D: usize>(numbers: &mut Numbers, by: f64) -> CellNodes<D> {
        let corner = |a: usize| {
            if a == 0 {
                Vector::zeros()
            } else {
                unit_vector(a - 1)
            }
        };
        let mut x: CellNodes<D> = [Vector::zeros(); 10];
        (0..=D).for_each(|a| x[a] = corner(a));
        for (e, [a, b]) in CELL_EDGES[..D * (D + 1) / 2].iter().enumerate() {
            x[D + 1 + e] = (corner(*a) + corner(*b)) * 0.5;
        }
        let count = (D + 1) * (D + 2) / 2;
        x[..count]
            .iter_mut()
            .for_each(|x| *x += Vector::from_fn(|_, _| by * numbers.next()));
        x
    }

    /// x(ξ) by Lagrange's formula: each node's function is the product of the lines through all others.
    fn point<const D: usize>(x: &CellNodes<D>, xi: &Vector<D>) -> Vector<D> {
        let l = |a: usize| if a == 0 { 1.0 - xi.sum() } else { xi[a - 1] };
        let mut sum = Vector::zeros();
        for (a, x) in x[..=D].iter().enumerate() {
            sum += x * (l(a) * (l(a) - 0.5) / 0.5);
        }
        for (e, [a, b]) in CELL_EDGES[..D * (D + 1) / 2].iter().enumerate() {
            sum += x[D + 1 + e] * (l(*a) * l(*b) / 0.25);
        }
        sum
    }

    /// det ∂x/∂ξ by central differences, which are exact for quadratics, and elimination.
    fn volume(x: &[Vector<3>; 10], xi: &Vector<3>, flat: bool) -> f64 {
        let h = 0.125;
        let mut tangents = Matrix::<3>::identity();
        for i in 0..if flat { 2 } else { 3 } {
            let step = unit_vector::<3>(i) * h;
            let of = |xi: Vector<3>| match flat {
                true => {
                    let plane = x.map(|x| Vector::<2>::new(x[0], x[1]));
                    let x = point::<2>(&plane, &Vector::<2>::new(xi[0], xi[1]));
                    Vector::<3>::new(x[0], x[1], 0.0)
                }
                false => point::<3>(x, &xi),
            };
            tangents.set_column(i, &((of(xi + step) - of(xi - step)) / (2.0 * h)));
        }
        tangents.lu().determinant()
    }

    fn in_space<const D: usize>(x: &CellNodes<D>) -> [Vector<3>; 10] {
        x.map(|x| Vector::<3>::from_fn(|i, _| if i < D { x[i] } else { 0.0 }))
    }

    /// Bounds of 3000 cells with their volumes at a grid of points: none is smaller, what is found is there, and the two
    /// are close. Returns how many cells are inverted although all nodes and quadrature points have positive volumes.
    fn bounds<const D: usize>(nodes_and_points: &[Vector<3>]) -> usize {
        let n = if D == 2 { 24 } else { 10 };
        let mut numbers = Numbers(7);
        let mut hidden = 0;
        for k in 0..3000 {
            let by = [0.03, 0.1, 0.2][k % 3];
            let (now, rest) = (
                cell::<D>(&mut numbers, by),
                cell::<D>(&mut numbers, 0.3 * by),
            );
            let ratio = |xi: &Vector<3>| {
                let [now, rest] = [&now, &rest].map(|x| volume(&in_space(x), xi, D == 2));
                now / rest
            };
            let least = least_ratio::<D>(&now, &rest, f64::INFINITY);
            let sign = least_ratio::<D>(&now, &rest, f64::NEG_INFINITY);
            let found = ratio(&Vector::<3>::from_fn(|i, _| {
                if i < D { least.lambda[i + 1] } else { 0.0 }
            }));
            assert!((found - least.found).abs() < 1e-12, "{found}: {least:?}");
            assert!(least.bound <= least.found && sign.bound <= least.found);
            assert!(
                least.bound >= least.found - CLOSE * least.found.abs(),
                "{least:?}"
            );
            assert_eq!(sign.bound > 0.0, least.bound > 0.0);
            for tuple in 0..(n + 1usize).pow(D as u32) {
                let of =
                    |i: usize| (tuple / (n + 1usize).pow(i as u32) % (n + 1)) as f64 / n as f64;
                let xi = Vector::<3>::from_fn(|i, _| if i < D { of(i) } else { 0.0 });
                if xi.sum() <= 1.0 {
                    assert!(ratio(&xi) >= least.bound - 1e-12, "{xi}: {least:?}");
                }
            }
            let is_seen = nodes_and_points.iter().any(|xi| ratio(xi) <= 0.0);
            hidden += usize::from(!is_seen && least.found <= 0.0);
        }
        hidden
    }

    #[test]
    fn no_volume_is_below_its_bound() {
        let at = |x: &[f64]| Vector::<3>::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0));
        let (s, t) = (1.0 / 6.0, 2.0 / 3.0);
        let seen = [
            [0., 0.],
            [1., 0.],
            [0., 1.],
            [0.5, 0.],
            [0.5, 0.5],
            [0., 0.5],
            [s, s],
            [t, s],
            [s, t],
        ];
        assert!(bounds::<2>(&seen.map(|x| at(&x))) > 0);
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(|x| at(&x));
        let middles = (0..4).flat_map(|b| (0..b).map(move |a| (corners[a] + corners[b]) * 0.5));
        let centre = corners.iter().sum::<Vector<3>>() / 4.0;
        let towards = corners.map(|x| centre + (x - centre) / 5f64.sqrt());
        let seen: Vec<_> = corners.into_iter().chain(middles).chain(towards).collect();
        assert!(bounds::<3>(&seen) > 0);
    }

    /// An affine cell has one ratio; a cell that is folded at rest has none.
    #[test]
    fn straight_cells_and_folded_ones() {
        let rest = cell::<2>(&mut Numbers(1), 0.0);
        let sheared = rest.map(|x| Vector::<2>::new(3.0 * x[0] + 0.7 * x[1] - 9.0, 0.25 * x[1]));
        let least = least_ratio::<2>(&sheared, &rest, f64::INFINITY);
        assert!((least.bound - 0.75).abs() < 1e-11 && (least.found - 0.75).abs() < 1e-14);
        let mut folded = rest;
        folded[3] = Vector::<2>::new(0.5, 0.9);
        assert_eq!(
            least_ratio::<2>(&rest, &folded, 1.0).bound,
            f64::NEG_INFINITY
        );
        let mut no_number = rest;
        no_number[1][0] = f64::NAN;
        assert!(!(least_ratio::<2>(&no_number, &rest, 1.0).bound > 0.0));
    }
}
