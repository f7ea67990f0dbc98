//! The foot of a point, by trying all facets around it.

use super::faces::{Faces, Patch, Piece, Placed, place, swept};
use crate::tensor::{Matrix, Vector};

/// The foot of a point on a boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot<const D: usize> {
    pub facet: usize,
    pub lambda: Vector<D>,
    /// The unit normal there, interpolated from averaged ones.
    pub normal: Vector<D>,
    /// Along the normal, positive = open (UL).
    pub gap: f64,
    pub distance: f64,
}

/// A point of a slave that looks for its foot.
pub(super) struct Point<const D: usize> {
    pub x: Vector<D>,
    /// The outward normal there, of any length.
    pub facing: Vector<D>,
    /// The same in the reference configuration.
    pub X: Vector<D>,
    pub N: Vector<D>,
    /// The facet that it is on, if both boundaries are of one body.
    pub own: Option<usize>,
}

/// How far feet count.
#[derive(Clone, Copy)]
pub(super) struct Reach {
    /// The search radius (UL).
    pub radius: f64,
    /// The larger length of both boundaries' facets (UL).
    pub size: f64,
    /// How deep the master's body starts in others (UL).
    pub fit: f64,
}

/// Barycentric coordinates below zero by less are round-off.
const ROUND_OFF: f64 = 1e-9;
/// Facets that are no farther away from an end of a way than this share of a facet's length are not crossed.
const CROSSES: f64 = 0.05;

/// λ and s of x = x̄(λ) + s m(λ) with the normals m of a facet, which may be beyond the facet's sides: Newton's method, whose slopes are
/// differences of positions. It starts from a λ and an s. `None` where it does not converge, or where normals have crossed.
pub(super) fn solve<const D: usize>(
    patches: &[Patch<D>; 2],
    x: &Vector<D>,
    (start, distance): (&Vector<D>, f64),
) -> Option<(Vector<D>, f64)> {
    const STEPS: usize = 25;
    const LONGEST: f64 = 0.7;
    const LAST: f64 = 1e-7;
    let [places, normals] = patches;
    let (mut lambda, mut s) = (*start, distance);
    for _ in 0..STEPS {
        let rest = x - places.at(&lambda) - normals.at(&lambda) * s;
        let step = swept(patches, &lambda, s).try_inverse()? * rest;
        let length = step.rows(0, D - 1).amax();
        if !(length.is_finite() && lambda.amax() < 1e3) {
            return None;
        }
        let share = (LONGEST / length).min(1.0);
        for k in 1..D {
            lambda[k] += share * step[k - 1];
            lambda[0] -= share * step[k - 1];
        }
        s += share * step[D - 1];
        if length < LAST {
            let [here, there] = [s, 0.0].map(|s| swept(patches, &lambda, s));
            let is_first = crate::tensor::determinant(&here) * crate::tensor::determinant(&there);
            return (is_first > 0.0).then_some((lambda, s));
        }
    }
    None
}

/// The foot of a place on one facet, if it has one there, looked for from a λ and a distance on.
pub(super) fn on<const D: usize>(
    master: &Placed<'_, D>,
    facet: usize,
    x: &Vector<D>,
    start: (&Vector<D>, f64),
) -> Option<Foot<D>> {
    let patches = master.patches(facet);
    let found = solve(&patches, x, start)?;
    let is_on_it = found.0.iter().all(|&l| l >= -ROUND_OFF);
    is_on_it.then(|| at(facet, &patches, found))
}

/// The foot at λ and s on a facet.
pub(super) fn at<const D: usize>(
    facet: usize,
    patches: &[Patch<D>; 2],
    (lambda, s): (Vector<D>, f64),
) -> Foot<D> {
    let m = patches[1].at(&lambda);
    let length = m.norm();
    Foot {
        facet,
        lambda,
        normal: m / length,
        gap: s * length,
        distance: (s * length).abs(),
    }
}

/// The closest point of a boundary, taken as flat between its nodes.
struct Closest<const D: usize> {
    distance: f64,
    facet: usize,
    lambda: Vector<D>,
    /// Whether it is at the end of the boundary.
    is_end: bool,
}

/// The weights of the first corners of a flat piece at its point closest to `x`: on the piece, or else on one of its sides.
fn nearest_on<const D: usize>(x: &Vector<D>, corners: &[Vector<D>]) -> [f64; 3] {
    let count = corners.len();
    let mut weights = [1.0, 0.0, 0.0];
    if count == 1 {
        return weights;
    }
    let offset = x - corners[0];
    let [first, second] = [1, count - 1].map(|k| corners[k] - corners[0]);
    let (a, b, c) = (first.dot(&first), first.dot(&second), second.dot(&second));
    let (p, q) = (first.dot(&offset), second.dot(&offset));
    let det = a * c - b * b;
    weights = match count {
        2 => [1.0 - p / a, p / a, 0.0],
        _ => {
            let [v, w] = [(c * p - b * q) / det, (a * q - b * p) / det];
            [1.0 - v - w, v, w]
        }
    };
    if weights.iter().all(|w| *w >= 0.0) {
        return weights;
    }
    let mut best = f64::INFINITY;
    let mut rest = [Vector::zeros(); 3];
    for omitted in 0..count {
        let kept = (0..count).filter(|&k| k != omitted);
        rest.iter_mut()
            .zip(kept.clone())
            .for_each(|(y, k)| *y = corners[k]);
        let own = nearest_on(x, &rest[..count - 1]);
        let mut place = Vector::<D>::zeros();
        rest.iter().zip(&own).for_each(|(y, w)| place += y * *w);
        let distance = (x - place).norm();
        if distance < best {
            (best, weights) = (distance, [0.0; 3]);
            kept.zip(own).for_each(|(k, w)| weights[k] = w);
        }
    }
    weights
}

/// The closest point of a facet, if it is within `distance`; else the distance is infinite.
fn closest_on<const D: usize>(
    master: &Placed<'_, D>,
    facet: usize,
    (x, distance): (&Vector<D>, f64),
) -> Closest<D> {
    let patch = master.faces.patch(facet, &master.x);
    let mut best = Closest {
        distance: f64::INFINITY,
        facet,
        lambda: Vector::zeros(),
        is_end: false,
    };
    for ([low, high], piece) in master.pieces(facet) {
        // no point is closer than the box around the corners
        let beside = (low - x).sup(&(x - high)).sup(&Vector::zeros());
        if beside.norm() > best.distance.min(distance) {
            continue;
        }
        let weights = nearest_on(x, &piece.corners);
        let mut lambda = Vector::<D>::zeros();
        let corners = piece.nodes.iter().zip(weights);
        corners.for_each(|(&k, w)| lambda += place::<D>(k) * w);
        let own = (x - patch.at(&lambda)).norm();
        if own < best.distance {
            (best.distance, best.lambda) = (own, lambda);
        }
    }
    let on_side = |k: usize| best.lambda[k] < ROUND_OFF && master.faces.is_rim(facet, k);
    best.is_end = (0..D).any(on_side);
    best
}

/// What is around a point within some distance.
struct Around<const D: usize> {
    /// The closest points of all facets there but those that have a node of the point's own facet, by distance.
    closest: Vec<Closest<D>>,
    /// Whether no facet is farther away.
    is_all: bool,
}

fn around<const D: usize>(
    (slave, master): (&Faces<D>, &Placed<'_, D>),
    point: &Point<D>,
    distance: f64,
) -> Around<D> {
    let mut closest = Vec::new();
    let mut seen = 0;
    let is_own = |f: usize| {
        let node = |faces: &Faces<D>, a: usize| faces.nodes[a];
        point.own.is_some_and(|own| {
            let mut own = slave.facet(own).iter().map(|&a| node(slave, a));
            let there = master.faces.facet(f);
            own.any(|a| there.iter().any(|&b| node(master.faces, b) == a))
        })
    };
    for facet in master.boxes.within(&point.x, distance) {
        if is_own(facet) {
            seen += 1;
            continue;
        }
        let here = closest_on(master, facet, (&point.x, distance));
        if here.distance <= distance {
            seen += 1;
            closest.push(here);
        }
    }
    closest.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let is_all = seen == master.faces.len();
    Around { closest, is_all }
}

/// How far around a point feet are looked for first, and next, as shares of a facet. Most points that press are close to the other boundary.
const FIRST: f64 = 0.02;
const SECOND: f64 = 0.4;
/// A facet is not nearer than a share of the distance of its flat pieces.
const NEARER: f64 = 0.5;

/// The foot that a point must not penetrate: the nearest one, if it counts. Behind a surface that faces the same way, the next one is
/// looked at, as is any that does not count where a body meets itself. Where normals have crossed, the closest point takes the place
/// of the foot.
pub(super) fn foot<const D: usize>(
    surfaces: (&Faces<D>, &Placed<'_, D>),
    point: &Point<D>,
    reach: Reach,
) -> Option<Foot<D>> {
    let master = surfaces.1;
    let mut distance = FIRST * reach.size;
    let mut feet: Vec<Foot<D>> = Vec::new();
    loop {
        let within = distance.min(reach.radius);
        let found = around(surfaces, point, within);
        feet.clear();
        let mut nearest: Option<Foot<D>> = None;
        for own in &found.closest {
            // what is farther away decides nothing
            let is_first = |foot: &Foot<D>| {
                foot.distance < NEARER * own.distance && counts(master, point, foot, reach)
            };
            if let Some(foot) = nearest.filter(is_first) {
                return Some(foot);
            }
            let there = on(master, own.facet, &point.x, (&own.lambda, 0.0));
            feet.extend(there);
            let near = nearest.into_iter().chain(there);
            nearest = near.min_by(|a, b| a.distance.total_cmp(&b.distance));
        }
        let count = feet.len();
        feet.retain(|foot| foot.distance <= within);
        feet.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let is_all = found.is_all && feet.len() == count;
        let is_last = distance >= reach.radius || is_all;
        let closest = found.closest.first();
        let closest = closest.filter(|own| 4.0 * own.distance <= distance || is_last);
        match decide(master, point, reach, &feet, closest) {
            Decision::Found(foot) => return Some(foot),
            Decision::None => return None,
            Decision::Open if is_last => return None,
            Decision::Open => distance = (2.0 * distance).max(SECOND * reach.size),
        }
    }
}

/// The nearest foot that counts on one of these facets.
pub(super) fn nearest_of<const D: usize>(
    master: &Placed<'_, D>,
    facets: impl Iterator<Item = usize>,
    point: &Point<D>,
    reach: Reach,
) -> Option<Foot<D>> {
    let middle = Vector::repeat(1.0 / D as f64);
    let feet = facets.filter_map(|facet| on(master, facet, &point.x, (&middle, 0.0)));
    let feet =
        feet.filter(|foot| foot.distance <= reach.radius && counts(master, point, foot, reach));
    feet.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Whether a foot faces the point, with no body between them.
fn counts<const D: usize>(
    master: &Placed<'_, D>,
    point: &Point<D>,
    foot: &Foot<D>,
    reach: Reach,
) -> bool {
    faces(point, foot) && seen(master, point, foot, reach) > 0.0
}

fn faces<const D: usize>(point: &Point<D>, foot: &Foot<D>) -> bool {
    point.facing.dot(&foot.normal) < 0.0
}

enum Decision<const D: usize> {
    Found(Foot<D>),
    None,
    /// What is further away decides.
    Open,
}

fn decide<const D: usize>(
    master: &Placed<'_, D>,
    point: &Point<D>,
    reach: Reach,
    feet: &[Foot<D>],
    closest: Option<&Closest<D>>,
) -> Decision<D> {
    let counts = |foot: &Foot<D>| counts(master, point, foot, reach);
    if point.own.is_some() {
        return match feet.iter().find(|foot| counts(foot)) {
            Some(foot) => Decision::Found(*foot),
            None => Decision::Open,
        };
    }
    for foot in feet {
        let is_behind = foot.gap < 0.0 && !faces(point, foot);
        match counts(foot) {
            true => return Decision::Found(*foot),
            false if is_behind => {}
            false => return Decision::None,
        }
    }
    let Some(closest) = closest.filter(|_| feet.is_empty()) else {
        return Decision::Open;
    };
    if closest.is_end {
        return Decision::None;
    }
    let patches = master.patches(closest.facet);
    // beside the end, the foot may be beyond it although the closest point is not
    let is_beyond = |(lambda, _): (Vector<D>, f64)| {
        let mut sides = (0..D).filter(|&k| lambda[k] < -ROUND_OFF);
        sides.any(|k| master.faces.is_rim(closest.facet, k))
    };
    if solve(&patches, &point.x, (&closest.lambda, 0.0)).is_some_and(is_beyond) {
        return Decision::None;
    }
    let offset = point.x - patches[0].at(&closest.lambda);
    let normal = patches[1].at(&closest.lambda).normalize();
    let foot = Foot {
        facet: closest.facet,
        lambda: closest.lambda,
        normal,
        gap: offset.dot(&normal),
        distance: closest.distance,
    };
    match counts(&foot) {
        true => Decision::Found(foot),
        false => Decision::None,
    }
}

/// The share with which a point counts by what is between it and its foot.
///
/// Behind a foot may be a body: the way between the two in the reference configuration leads through it then, and is not much longer than that at
/// present. The share falls to zero while the longer of both ways shrinks from five times the other to four times, if the depth below the
/// surface is a quarter above its limit, or more. The boundary may also be between the two, as that of a strip that is rolled up.
pub(super) fn seen<const D: usize>(
    master: &Placed<'_, D>,
    point: &Point<D>,
    foot: &Foot<D>,
    Reach { size, fit, .. }: Reach,
) -> f64 {
    if foot.gap >= 0.0 {
        return 1.0;
    }
    let [there, normals] = master.faces.reference(foot.facet);
    let way = there.at(&foot.lambda) - point.X;
    let normal = normals.at(&foot.lambda).normalize();
    let inside = way.dot(&normal).max(-way.dot(&point.N.normalize()));
    let [shallow, deep] = match point.own {
        Some(_) => [1e-6 * size, 0.05 * size],
        None => {
            let least = (0.2 * size).max(1.5 * fit).max(0.5 * way.norm());
            [least, 1.25 * least]
        }
    };
    let by_depth = (deep - inside) / (deep - shallow);
    let by_length = 5.0 - 20.0 * foot.distance / way.norm();
    let by_paths = by_depth.max(by_length).clamp(0.0, 1.0);
    match by_paths > 0.0 && foot.distance > 2.0 * CROSSES * size {
        true => by_paths.min(1.0 - crossed(master, point, foot, size)),
        false => by_paths,
    }
}

/// How surely the way from a point to its foot leads through a facet that is not beside the foot. The result is 0 if one end of the way is within a
/// twentieth of a facet's length of that facet, and 1 if both ends are a tenth or more away.
fn crossed<const D: usize>(
    master: &Placed<'_, D>,
    point: &Point<D>,
    foot: &Foot<D>,
    size: f64,
) -> f64 {
    let end = master.patches(foot.facet)[0].at(&foot.lambda);
    let way = end - point.x;
    let around = master
        .boxes
        .within(&(point.x + way * 0.5), 0.5 * foot.distance);
    let mut surely: f64 = 0.0;
    let of_foot = master.faces.facet(foot.facet);
    let is_beside = |facet: usize| {
        master
            .faces
            .facet(facet)
            .iter()
            .any(|a| of_foot.contains(a))
    };
    for facet in around.filter(|facet| !is_beside(*facet)) {
        for (_, Piece { corners, .. }) in master.pieces(facet) {
            // Σ λ_k corner_k = x + t way with Σ λ_k = 1: λ_0 is left out
            let columns: [Vector<D>; D] = std::array::from_fn(|k| match k {
                0 => -way,
                _ => corners[k] - corners[0],
            });
            let matrix = Matrix::<D>::from_columns(&columns);
            let Some(inverse) = matrix.try_inverse() else {
                continue;
            };
            let solution = inverse * (point.x - corners[0]);
            let (t, rest) = (solution[0], solution.rows(1, D - 1));
            if rest.min() < 0.0 || rest.sum() > 1.0 {
                continue;
            }
            let away = t.min(1.0 - t) * foot.distance / size;
            surely = surely.max(((away - CROSSES) / CROSSES).clamp(0.0, 1.0));
        }
    }
    surely
}
