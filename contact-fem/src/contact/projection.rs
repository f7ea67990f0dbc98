//! How points are projected, and the closest point on one facet.

use crate::element::Facet;
use crate::tensor::{Matrix, Vector, facet_normal};

/// Where a point of a slave has its foot on the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Where the interpolated averaged normal of the master passes through the point: x = x̄ + g n. This foot is continuous in the
    /// state, across the edges of facets, too.
    #[default]
    AlongNormals,
    /// At the closest point of the master, as in the paper. From inside an edge of the master, it jumps from one facet to the
    /// next where it is equally close to both, by the gap times the angle of the edge. At isolated loads there is no equilibrium then.
    Closest,
}

/// Barycentric coordinates (D of them, ≥ 0, sum 1) of the closest point to `x` on a flat or curved
/// facet.
pub fn closest_on<const D: usize>(x: &Vector<D>, facet: &Facet<D>) -> Vector<D> {
    match facet.is_flat() {
        true => closest(x, &facet.corners()),
        false => closest_on_curved(x, facet),
    }
}

/// The barycentric coordinates of the projection of `x` on the plane of the flat facet with these
/// corners, along its normal; NaN if the facet is degenerate.
pub(super) fn along_normal<const D: usize>(x: &Vector<D>, corners: &[Vector<D>; D]) -> Vector<D> {
    let n = facet_normal(corners);
    Vector::from_fn(|k, _| {
        let mut opposite = *corners;
        opposite[k] = *x;
        facet_normal(&opposite).dot(&n) / n.norm_squared()
    })
}

/// As [`closest_on`], by Newton's method on ½|x − x̄(λ)|² over λ ≥ 0, Σλ = 1. The iteration starts at the closest
/// point of the flat pieces between the nodes; on a facet that is bent so much that the closest point may be elsewhere,
/// from each piece.
fn closest_on_curved<const D: usize>(x: &Vector<D>, facet: &Facet<D>) -> Vector<D> {
    /// The bulge of such a facet, as a share of its first side: that of an arc of about 45°.
    const BENT: f64 = 0.1;
    let starts = facet.pieces().iter().map(|piece| {
        let lambda = closest_on_piece(x, facet, piece);
        (lambda, (x - facet.point(&lambda)).norm_squared())
    });
    let nearer = |a: &(Vector<D>, f64), b: &(Vector<D>, f64)| a.1.total_cmp(&b.1);
    let corners = facet.corners();
    let nearest = match facet.bulge() > BENT * (corners[1] - corners[0]).norm() {
        true => starts.map(|start| descend(x, facet, start)).min_by(nearer),
        false => starts.min_by(nearer).map(|start| descend(x, facet, start)),
    };
    nearest.map_or(Vector::repeat(1.0 / D as f64), |(lambda, _)| lambda)
}

/// Newton's method of [`closest_on_curved`] from λ and its squared distance, to those of a local minimum. Each step
/// minimises the quadratic model, as the closest point of a flat facet in the metric of the Hessian, and is halved
/// where it increases the distance.
fn descend<const D: usize>(
    x: &Vector<D>,
    facet: &Facet<D>,
    (mut lambda, mut before): (Vector<D>, f64),
) -> (Vector<D>, f64) {
    /// The largest number of steps.
    const STEPS: usize = 50;
    /// The length of a step, in barycentric coordinates, that ends the iteration.
    const RESOLVED: f64 = 1e-15;
    /// The length of a full Newton step that ends the iteration: since convergence is quadratic, the
    /// next step would be round-off.
    const LAST: f64 = 1e-9;
    let away = |lambda: &Vector<D>| (x - facet.point(lambda)).norm_squared();
    for _ in 0..STEPS {
        let Some((mut next, converges)) = newton(x, facet, &lambda) else {
            break;
        };
        let mut now = away(&next);
        let mut halvings = 0;
        while now > before && halvings < 10 {
            next = (next + lambda) * 0.5;
            now = away(&next);
            halvings += 1;
        }
        if now > before {
            break;
        }
        let step = (next - lambda).amax();
        (lambda, before) = (next, now);
        if step <= RESOLVED || step <= LAST && converges && halvings == 0 {
            break;
        }
    }
    (lambda, before)
}

/// The coordinates λ on `facet` of the closest point on one of its flat pieces.
fn closest_on_piece<const D: usize>(
    x: &Vector<D>,
    facet: &Facet<D>,
    piece: &[[f64; 3]; 3],
) -> Vector<D> {
    let corners: [Vector<D>; D] = std::array::from_fn(|k| Vector::from_fn(|i, _| piece[k][i]));
    let on_piece = closest(x, &corners.map(|lambda| facet.point(&lambda)));
    interpolate(&on_piece, &corners)
}

/// One Newton step over λ and `true`, or a Gauss–Newton step and `false` where the Hessian is not
/// positive definite; `None` where the facet has no tangent plane.
fn newton<const D: usize>(
    x: &Vector<D>,
    facet: &Facet<D>,
    lambda: &Vector<D>,
) -> Option<(Vector<D>, bool)> {
    let corners = facet.tangent(lambda);
    let r = x - facet.point(lambda);
    let bend = facet.curvature(&r);
    // unknowns ξ_i = λ_{i+1}; the last row and column only fill the matrix up to D × D
    let t: [Vector<D>; D] = std::array::from_fn(|k| corners[k] - corners[0]);
    let hessian = |curved: f64| {
        Matrix::<D>::from_fn(|i, j| {
            if i + 1 == D || j + 1 == D {
                return f64::from(u8::from(i == j));
            }
            let (i, j) = (i + 1, j + 1);
            let bent = bend[(i, j)] - bend[(i, 0)] - bend[(0, j)] + bend[(0, 0)];
            t[i].dot(&t[j]) - curved * bent
        })
    };
    let newton = hessian(1.0).cholesky();
    let converges = newton.is_some();
    let factor = newton.or_else(|| hessian(0.0).cholesky())?;
    let slope = Vector::<D>::from_fn(|i, _| if i + 1 < D { t[i + 1].dot(&r) } else { 0.0 });
    let xi = |lambda: &Vector<D>| {
        Vector::<D>::from_fn(|i, _| if i + 1 < D { lambda[i + 1] } else { 0.0 })
    };
    let minimum = xi(lambda) + factor.solve(&slope);
    let metric = factor.l().transpose();
    let seen: [Vector<D>; D] = std::array::from_fn(|k| {
        metric * (xi(&Vector::from_fn(|i, _| f64::from(u8::from(i == k)))) - minimum)
    });
    Some((closest(&Vector::zeros(), &seen), converges))
}

/// Barycentric coordinates (D of them, ≥ 0, sum 1) of the point of the flat facet with these
/// corners that is closest to `x`.
///
/// A segment clamps one parameter; a triangle distinguishes the regions of its corners, sides and
/// interior (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub fn closest<const D: usize>(x: &Vector<D>, corners: &[Vector<D>; D]) -> Vector<D> {
    const { assert!(D == 2 || D == 3, "the space dimension is 2 or 3") };
    let mut lambda = Vector::zeros();
    if D == 2 {
        let t = along(x, &corners[0], &corners[1]).clamp(0.0, 1.0);
        lambda[0] = 1.0 - t;
        lambda[1] = t;
        return lambda;
    }
    let (a, b, c) = (&corners[0], &corners[1], &corners[2]);
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(x - a)), ac.dot(&(x - a)));
    let (d3, d4) = (ab.dot(&(x - b)), ac.dot(&(x - b)));
    let (d5, d6) = (ab.dot(&(x - c)), ac.dot(&(x - c)));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let weights = if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        [1.0 - t, t, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        [1.0 - t, 0.0, t]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - t, t]
    } else {
        let whole = va + vb + vc;
        [va / whole, vb / whole, vc / whole]
    };
    lambda.copy_from_slice(&weights[..D]);
    lambda
}

/// The parameter of the foot of `x` on the line through `a` and `b`, unclamped.
fn along<const D: usize>(x: &Vector<D>, a: &Vector<D>, b: &Vector<D>) -> f64 {
    let edge = b - a;
    edge.dot(&(x - a)) / edge.norm_squared()
}

/// Σ λ_k x_k.
pub fn interpolate<const D: usize>(lambda: &Vector<D>, values: &[Vector<D>; D]) -> Vector<D> {
    let mut point = Vector::<D>::zeros();
    for (l, value) in lambda.iter().zip(values) {
        point.axpy(*l, value, 1.0);
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Order;

    /// Comparison with a brute-force search over a fine lattice on the facet.
    fn against_lattice<const D: usize>(corners: [Vector<D>; D], lattice: &[Vector<D>]) {
        for k in 0..200 {
            let x = Vector::<D>::from_fn(|i, _| 2.5 * ((k * (i + 3) + i) as f64 * 0.77).sin());
            let lambda = closest(&x, &corners);
            assert!(lambda.iter().all(|&l| l >= 0.0));
            assert!((lambda.sum() - 1.0).abs() < 1e-14);
            let distance = (x - interpolate(&lambda, &corners)).norm();
            let brute = lattice
                .iter()
                .map(|l| (x - interpolate(l, &corners)).norm());
            let brute = brute.fold(f64::INFINITY, f64::min);
            assert!(distance <= brute + 1e-12, "{distance} against {brute}");
            assert!(brute - distance < 2e-3);
        }
    }

    #[test]
    fn segment() {
        let corners = [[-0.4, 0.3], [1.1, 0.8]].map(Vector::<2>::from);
        let lattice: Vec<_> = (0..=2000)
            .map(|i| Vector::<2>::new(1.0 - f64::from(i) / 2000.0, f64::from(i) / 2000.0))
            .collect();
        against_lattice(corners, &lattice);
    }

    #[test]
    fn triangle() {
        let corners = [[0.1, -0.2, 0.3], [1.2, 0.3, -0.1], [0.2, 0.9, 0.6]];
        let n = 400;
        let steps = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        let lattice: Vec<_> = steps
            .map(|(i, j)| Vector::<3>::new(f64::from(i), f64::from(j), f64::from(n - i - j)))
            .map(|v| v / f64::from(n))
            .collect();
        against_lattice(corners.map(Vector::<3>::from), &lattice);
    }

    /// Comparison with a fine lattice on the curved facet, from small and large distances.
    fn curved_against_lattice<const D: usize>(facet: &Facet<D>, lattice: &[Vector<D>], step: f64) {
        for k in 0..300 {
            let far = if k % 2 == 0 { 0.2 } else { 2.5 };
            let about = facet.nodes()[k % facet.nodes().len()];
            let x =
                about + Vector::<D>::from_fn(|i, _| far * ((k * (i + 3) + i) as f64 * 0.77).sin());
            let lambda = closest_on(&x, facet);
            assert!(lambda.iter().all(|&l| l >= 0.0));
            assert!((lambda.sum() - 1.0).abs() < 1e-14);
            let distance = (x - facet.point(&lambda)).norm();
            let brute = lattice.iter().map(|l| (x - facet.point(l)).norm());
            let brute = brute.fold(f64::INFINITY, f64::min);
            assert!(distance <= brute + 1e-12, "{k}: {distance} against {brute}");
            assert!(brute - distance < step);
        }
    }

    #[test]
    fn curved_segment() {
        let x = [[-0.4, 0.3], [1.1, 0.8], [0.3, 0.75]].map(Vector::<2>::from);
        let facet = Facet::gather(Order::Quadratic, &[0, 1, 2], &x);
        let lattice: Vec<_> = (0..=4000)
            .map(|i| Vector::<2>::new(1.0 - f64::from(i) / 4000.0, f64::from(i) / 4000.0))
            .collect();
        curved_against_lattice(&facet, &lattice, 1e-3);
    }

    /// Segments that are bent by up to three quarters of their length, from points around them.
    #[test]
    fn strongly_curved_segments() {
        let mut missed = 0;
        for k in 0..2000_u32 {
            let wave = |i: u32| (f64::from(k * 7 + i) * 0.7717).sin() * (f64::from(k) + 0.3).cos();
            let middle = Vector::<2>::new(0.5 + 0.75 * wave(1), 0.75 * wave(2));
            let nodes = [Vector::<2>::zeros(), Vector::<2>::new(1.0, 0.0), middle];
            let facet = Facet::gather(Order::Quadratic, &[0, 1, 2], &nodes);
            let x = Vector::<2>::new(0.5 + 1.5 * wave(3), 1.5 * wave(4));
            let away = |t: f64| (x - facet.point(&Vector::<2>::new(1.0 - t, t))).norm();
            let lattice = (0..=2000).map(|i| away(f64::from(i) / 2000.0));
            let least = lattice.fold(f64::INFINITY, f64::min);
            missed += u32::from(away(closest_on(&x, &facet)[1]) > least + 1e-9);
        }
        assert!(missed <= 2, "{missed}");
    }

    #[test]
    fn curved_triangle() {
        let x = [
            [0.1, -0.2, 0.3],
            [1.2, 0.3, -0.1],
            [0.2, 0.9, 0.6],
            [0.6, 0.0, 0.25],
            [0.75, 0.65, 0.4],
            [0.1, 0.4, 0.55],
        ]
        .map(Vector::<3>::from);
        let facet = Facet::gather(Order::Quadratic, &[0, 1, 2, 3, 4, 5], &x);
        let n = 200;
        let steps = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        let lattice: Vec<_> = steps
            .map(|(i, j)| Vector::<3>::new(f64::from(i), f64::from(j), f64::from(n - i - j)))
            .map(|v| v / f64::from(n))
            .collect();
        curved_against_lattice(&facet, &lattice, 8e-3);
    }

    /// The way from the closest point inside a curved segment is perpendicular to it, up to the root of the
    /// round-off in squared distances.
    #[test]
    fn feet_are_perpendicular() {
        let nodes = [[-0.4, 0.3], [1.1, 0.8], [0.3, 0.75]].map(Vector::<2>::from);
        let facet = Facet::gather(Order::Quadratic, &[0, 1, 2], &nodes);
        let mut inside = 0;
        for k in 0..300 {
            let wave = |i: i32| (f64::from(k * 3 + i) * 0.77).sin();
            let x = nodes[2] + Vector::<2>::new(0.4 * wave(0), 0.4 * wave(1));
            let lambda = closest_on(&x, &facet);
            if lambda.min() == 0.0 {
                continue;
            }
            inside += 1;
            let tangent = facet.tangent(&lambda);
            let along = (tangent[1] - tangent[0]).dot(&(x - facet.point(&lambda)));
            assert!(along.abs() < 1e-7, "{k}: {along}");
        }
        assert!(inside > 100, "{inside}");
    }

    /// Along strongly bent segments as well: from points around them, the closest point is an end, or the
    /// way to it is perpendicular.
    #[test]
    fn feet_on_strongly_curved_segments_are_perpendicular() {
        let mut inside = 0;
        for k in 0..2000_u32 {
            let wave = |i: u32| (f64::from(k * 7 + i) * 0.7717).sin() * (f64::from(k) + 0.3).cos();
            let middle = Vector::<2>::new(0.5 + 0.4 * wave(1), 0.75 * wave(2));
            let nodes = [Vector::<2>::zeros(), Vector::<2>::new(1.0, 0.0), middle];
            let facet = Facet::gather(Order::Quadratic, &[0, 1, 2], &nodes);
            let x = Vector::<2>::new(0.5 + 1.5 * wave(3), 1.5 * wave(4));
            let lambda = closest_on(&x, &facet);
            if lambda.min() == 0.0 {
                continue;
            }
            inside += 1;
            let tangent = facet.tangent(&lambda);
            let along = (tangent[1] - tangent[0]).dot(&(x - facet.point(&lambda)));
            assert!(along.abs() < 1e-6, "{k}: {along}");
        }
        assert!(inside > 500, "{inside}");
    }

    /// On a quadratic facet with its middle nodes half-way, both methods agree.
    fn flat_as_curved<const D: usize>(corners: [Vector<D>; D], offset: Vector<D>) {
        let mut x = corners.map(|x| x + offset).to_vec();
        let edges = (0..D * (D - 1) / 2).map(crate::element::facet_edge::<D>);
        let middles: Vec<_> = edges.map(|[a, b]| (x[a] + x[b]) * 0.5).collect();
        x.extend(middles);
        let nodes: Vec<usize> = (0..x.len()).collect();
        let facet = Facet::gather(Order::Quadratic, &nodes, &x);
        assert!(facet.is_flat());
        let mut bent = x.clone();
        bent[D][0] += 1e-9;
        assert!(!Facet::gather(Order::Quadratic, &nodes, &bent).is_flat());
        for k in 0..200 {
            let x =
                offset + Vector::<D>::from_fn(|i, _| 2.5 * ((k * (i + 3) + i) as f64 * 0.77).sin());
            let difference = closest_on(&x, &facet) - closest_on_curved(&x, &facet);
            let roundoff = 1e-14 * (1.0 + offset.amax());
            assert!(difference.amax() < roundoff, "{k}: {difference}");
        }
    }

    #[test]
    fn flat_quadratic_facets() {
        let segment = [[-0.4, 0.3], [1.1, 0.8]].map(Vector::<2>::from);
        let triangle = [[0.1, -0.2, 0.3], [1.2, 0.3, -0.1], [0.2, 0.9, 0.6]];
        for far in [0.0, 1e3] {
            flat_as_curved(segment, Vector::<2>::new(far, -0.7 * far));
            let triangle = triangle.map(Vector::<3>::from);
            flat_as_curved(triangle, Vector::<3>::new(far, -0.7 * far, 0.3 * far));
        }
    }
}
