//! The foot of a point, by trying all facets around it.

use super::faces::{Faces, Patch, Placed, swept};
use crate::tensor::Vector;

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
    for piece in &master.pieces {
        let corners = piece.map(|lambda| patch.at(&lambda));
        // no point is closer than the box around the corners
        let low = corners.iter().fold(corners[0], |low, y| low.inf(y));
        let high = corners.iter().fold(corners[0], |high, y| high.sup(y));
        let beside = (low - x).sup(&(x - high)).sup(&Vector::zeros());
        if beside.norm() > best.distance.min(distance) {
            continue;
        }
        let weights = nearest_on(x, &corners);
        let mut lambda = Vector::<D>::zeros();
        piece
            .iter()
            .zip(weights)
            .for_each(|(own, w)| lambda += own * w);
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
    /// By distance.
    feet: Vec<Foot<D>>,
    closest: Option<Closest<D>>,
    /// Whether this is all there is.
    is_all: bool,
}

/// The feet within `distance`, on all facets but those that have a node of the point's own facet.
fn around<const D: usize>(
    (slave, master): (&Faces<D>, &Placed<'_, D>),
    point: &Point<D>,
    distance: f64,
) -> Around<D> {
    let (mut feet, mut closest) = (Vec::new(), None::<Closest<D>>);
    let mut seen = 0;
    let is_own = |f: usize| {
        let node = |faces: &Faces<D>, a: usize| faces.nodes[a];
        point.own.is_some_and(|own| {
            let own = slave.facet(own).iter().map(|&a| node(slave, a));
            let there: Vec<usize> = master
                .faces
                .facet(f)
                .iter()
                .map(|&b| node(master.faces, b))
                .collect();
            own.into_iter().any(|a| there.contains(&a))
        })
    };
    for facet in master.boxes.within(&point.x, distance) {
        if is_own(facet) {
            seen += 1;
            continue;
        }
        let here = closest_on(master, facet, (&point.x, distance));
        if here.distance > distance {
            continue;
        }
        seen += 1;
        let patches = master.patches(facet);
        let solved = solve(&patches, &point.x, (&here.lambda, 0.0));
        let on_it = solved.filter(|(lambda, _)| lambda.iter().all(|&l| l >= -ROUND_OFF));
        feet.extend(on_it.map(|found| at(facet, &patches, found)));
        let known = closest
            .as_ref()
            .map_or(f64::INFINITY, |known| known.distance);
        if here.distance < known {
            closest = Some(here);
        }
    }
    let found = feet.len();
    feet.retain(|foot: &Foot<D>| foot.distance <= distance);
    feet.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let is_all = seen == master.faces.len() && feet.len() == found;
    Around {
        feet,
        closest,
        is_all,
    }
}

/// The foot that a point must not penetrate: the nearest one, if it counts. Behind a surface that faces the same way, the next one is
/// looked at, as is any that does not count where a body meets itself. Where normals have crossed, the closest point takes the place
/// of the foot.
pub(super) fn foot<const D: usize>(
    surfaces: (&Faces<D>, &Placed<'_, D>),
    point: &Point<D>,
    reach: Reach,
) -> Option<Foot<D>> {
    let mut distance = 0.4 * reach.size;
    loop {
        let found = around(surfaces, point, distance.min(reach.radius));
        let is_last = distance >= reach.radius || found.is_all;
        let closest = found
            .closest
            .as_ref()
            .filter(|own| 4.0 * own.distance <= distance || is_last);
        let decided = decide(surfaces.1, point, reach, &found.feet, closest);
        match decided {
            Decision::Found(foot) => return Some(foot),
            Decision::None => return None,
            Decision::Open if is_last => return None,
            Decision::Open => distance *= 2.0,
        }
    }
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
    let faces = |foot: &Foot<D>| point.facing.dot(&foot.normal) < 0.0;
    let counts =
        |foot: &Foot<D>| faces(foot) && !is_through_material(master.faces, point, foot, reach);
    if point.own.is_some() {
        return match feet.iter().find(|foot| counts(foot)) {
            Some(foot) => Decision::Found(*foot),
            None => Decision::Open,
        };
    }
    for foot in feet {
        let is_behind = foot.gap < 0.0 && !faces(foot);
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

/// Whether a body is between a point and a foot that it is behind. Then the way between them in the reference configuration leads
/// through one of the bodies, and is not much longer than that at present.
fn is_through_material<const D: usize>(
    master: &Faces<D>,
    point: &Point<D>,
    foot: &Foot<D>,
    Reach { size, fit, .. }: Reach,
) -> bool {
    if foot.gap >= 0.0 {
        return false;
    }
    let [there, _] = master.reference(foot.facet);
    let way = there.at(&foot.lambda) - point.X;
    let normal = there.normal(&foot.lambda).normalize();
    let inside = way.dot(&normal).max(-way.dot(&point.N.normalize()));
    let least = match point.own {
        Some(_) => 1e-6 * size,
        None => (0.2 * size).max(1.5 * fit).max(0.5 * way.norm()),
    };
    foot.distance > 0.2 * way.norm() && inside > least
}
