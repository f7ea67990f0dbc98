//! The foot of a point along the averaged normals of a surface.
//!
//! A facet with its interpolated normals m(λ) = Σ N_b(λ) n_b sweeps the points x̄(λ) + s m(λ). Neighbours share the normals
//! of their common nodes, so that what they sweep fits together without gaps and overlaps as far as the normals do not
//! cross. The foot x̄ of a point x, which stands for the projection in (3) of the paper, is where the surface sweeps the point:
//!
//! x = x̄(λ) + s m(λ),  g = s |m(λ)| (UL).
//!
//! λ and g are continuous in x and in the nodes. The closest point is not: from inside an edge it jumps across the bisector, by
//! the gap times the angle of the edge. Both agree as g → 0.

use std::collections::BTreeSet;

use super::moving::Moving;
use crate::element::{Facet, facet_slopes};
use crate::tensor::{Matrix, Vector, determinant};

/// Round-off of barycentric coordinates: a foot outside a facet by less is on it.
const ROUND_OFF: f64 = 1e-12;
/// As [`ROUND_OFF`], at the rim of a surface, where surfaces that end together differ by what their positions were solved to.
const RIM: f64 = 1e-9;
/// The largest number of facets on the way from the closest point to the foot.
const WAY: usize = 16;

/// Where a point has its foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Foot<const D: usize> {
    /// At λ on a facet.
    On(usize, Vector<D>),
    /// Beyond the rim of the surface, at λ on a facet that goes on there.
    Beyond(usize, Vector<D>),
    /// Nowhere near: the point is beyond the place where normals cross.
    None,
}

/// The foot of `x` on the surface, nearby λ on `facet`.
///
/// The way leads from facet to facet across the side beyond which the foot is. Where it comes to no end, as around nodes with few
/// facets, all facets around the first one are tried.
pub(super) fn foot<const D: usize>(
    surface: &Moving<D>,
    x: &Vector<D>,
    (first, lambda): (usize, Vector<D>),
) -> Foot<D> {
    let (mut facet, mut start) = (first, lambda);
    let mut visited = [usize::MAX; WAY];
    let mut end = Foot::None;
    for step in 0..WAY {
        visited[step] = facet;
        let Some(lambda) = on_facet(surface, facet, x, &start) else {
            break;
        };
        if let Some(lambda) = accepted(surface, facet, lambda) {
            return Foot::On(facet, lambda);
        }
        let mut beyond: [usize; D] = std::array::from_fn(|k| k);
        beyond.sort_unstable_by(|&a, &b| lambda[a].total_cmp(&lambda[b]));
        let sides = beyond.into_iter().filter(|&k| lambda[k] < 0.0);
        let mut neighbours = sides.map(|k| across(surface, facet, k));
        end = match neighbours.clone().all(|neighbour| neighbour.is_none()) {
            true => Foot::Beyond(facet, lambda),
            false => Foot::None,
        };
        let next = neighbours.find_map(|neighbour| neighbour.filter(|f| !visited.contains(f)));
        let Some(next) = next else { break };
        start = carried(surface, (facet, &lambda), next);
        facet = next;
    }
    around(surface, x, first).unwrap_or(end)
}

/// λ if it is on the facet, up to round-off.
fn accepted<const D: usize>(
    surface: &Moving<D>,
    facet: usize,
    lambda: Vector<D>,
) -> Option<Vector<D>> {
    let is_inside = |k: usize| {
        lambda[k] >= -ROUND_OFF || lambda[k] >= -RIM && across(surface, facet, k).is_none()
    };
    (0..D).all(is_inside).then_some(lambda)
}

/// The facet beyond the side opposite corner `k` of a facet.
fn across<const D: usize>(surface: &Moving<D>, facet: usize, k: usize) -> Option<usize> {
    let surface = surface.surface();
    let corners = &surface.facet(facet)[..D];
    let side = || (0..D).filter(|&c| c != k).map(|c| corners[c]);
    let shares_side = |f: usize| side().all(|a| surface.facet(f)[..D].contains(&a));
    let mut others = surface.facets_around(corners[(k + 1) % D]);
    others.find_map(|(f, _)| (f != facet && shares_side(f)).then_some(f))
}

/// λ on the facet `next` nearby λ on its neighbour: the same weights at common corners.
fn carried<const D: usize>(
    surface: &Moving<D>,
    (facet, lambda): (usize, &Vector<D>),
    next: usize,
) -> Vector<D> {
    let surface = surface.surface();
    let (from, to) = (&surface.facet(facet)[..D], &surface.facet(next)[..D]);
    let mut start = Vector::<D>::zeros();
    for (c, node) in to.iter().enumerate() {
        let same = from.iter().position(|other| other == node);
        start[c] = same.map_or(0.0, |k| lambda[k].max(0.0));
    }
    let sum = start.sum();
    match sum > 0.0 {
        true => start / sum,
        false => Vector::repeat(1.0 / D as f64),
    }
}

/// The foot with the smallest gap on the facets around a facet.
fn around<const D: usize>(surface: &Moving<D>, x: &Vector<D>, first: usize) -> Option<Foot<D>> {
    let nodes = surface.surface().facet(first).iter();
    let facets = nodes.flat_map(|&a| surface.surface().facets_around(a).map(|(f, _)| f));
    let facets: BTreeSet<usize> = facets.collect();
    let feet = facets.into_iter().filter_map(|f| {
        let lambda = on_facet(surface, f, x, &Vector::repeat(1.0 / D as f64))?;
        let lambda = accepted(surface, f, lambda)?;
        let facet = gathered(surface, f, surface.positions());
        Some(((x - facet.point(&lambda)).norm(), Foot::On(f, lambda)))
    });
    let nearest = feet.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, foot)| foot)
}

fn gathered<const D: usize>(surface: &Moving<D>, facet: usize, of: &[Vector<D>]) -> Facet<D> {
    Facet::gather(
        surface.surface().order(),
        surface.surface().facet(facet),
        of,
    )
}

/// λ of x = x̄(λ) + s m(λ) on one facet, which may be outside it, by Newton's method from `start`. `None` where the iteration
/// does not converge, or ends where the normals have crossed: there the facet sweeps space in reverse.
fn on_facet<const D: usize>(
    surface: &Moving<D>,
    facet: usize,
    x: &Vector<D>,
    start: &Vector<D>,
) -> Option<Vector<D>> {
    /// The largest number of steps.
    const STEPS: usize = 20;
    /// A step of λ that ends the iteration: the next one would be round-off, since convergence is quadratic.
    const LAST: f64 = 1e-9;
    /// The largest step of λ.
    const LONGEST: f64 = 1.0;
    let nodes = gathered(surface, facet, surface.positions());
    let normals = gathered(surface, facet, surface.normals());
    let mut lambda = *start;
    let m = normals.point(&lambda);
    let mut s = (x - nodes.point(&lambda)).dot(&m) / m.norm_squared();
    for _ in 0..STEPS {
        let m = normals.point(&lambda);
        let swept = columns(&nodes, &normals, &lambda, s);
        let rest = x - nodes.point(&lambda) - m * s;
        let step = swept.try_inverse()? * rest;
        let length = (0..D - 1).fold(step.rows(0, D - 1).sum().abs(), |most: f64, k| {
            most.max(step[k].abs())
        });
        if !length.is_finite() {
            return None;
        }
        let share = (LONGEST / length).min(1.0);
        for k in 0..D - 1 {
            lambda[0] -= share * step[k];
            lambda[k + 1] += share * step[k];
        }
        s += share * step[D - 1];
        if length <= LAST {
            let now = determinant(&columns(&nodes, &normals, &lambda, s));
            let at_the_facet = determinant(&columns(&nodes, &normals, &lambda, 0.0));
            return (now * at_the_facet > 0.0).then_some(lambda);
        }
    }
    None
}

/// ∂/∂ξ_k of x̄ + s m, ξ_k = λ_{k+1}, and m, as columns.
fn columns<const D: usize>(
    nodes: &Facet<D>,
    normals: &Facet<D>,
    lambda: &Vector<D>,
    s: f64,
) -> Matrix<D> {
    let slopes = facet_slopes(nodes.order(), lambda);
    let mut columns = Matrix::<D>::zeros();
    for k in 1..D {
        let mut column = columns.column_mut(k - 1);
        let all = nodes.nodes().iter().zip(normals.nodes()).enumerate();
        for (b, (x, n)) in all {
            let slope = slopes[k][b] - slopes[0][b];
            column.axpy(slope, x, 1.0);
            column.axpy(slope * s, n, 1.0);
        }
    }
    columns.set_column(D - 1, &normals.point(lambda));
    columns
}
