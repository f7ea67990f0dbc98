//! The order in which faces are painted, so that nearer ones hide what is behind them.
//!
//! Of two faces that cover a common part of the picture, the one behind is painted first, as the depths there tell: depths of
//! centres do not, since a large face behind a small one may be nearer in its middle.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::tensor::Vector;

/// A corner of a face: its place in the picture, to the right and up, and how near it is to the viewer (UL).
pub(super) type Corner = Vector<3>;

/// Overlaps in the picture that are smaller than this share of the smaller face are round-off.
const SHARE: f64 = 1e-6;

/// The faces, by their numbers, from the farthest to the nearest. A face is a convex polygon, or the six nodes around a curved
/// triangle, which counts as its four parts. In a circle of faces that hide each other in turn, the farthest comes first.
pub(super) fn back_to_front(faces: &[Vec<Corner>]) -> Vec<usize> {
    let faces: Vec<Face> = faces.iter().map(|corners| Face::new(corners)).collect();
    let mut nearer = vec![Vec::new(); faces.len()];
    let mut behind = vec![0_usize; faces.len()];
    for [a, b] in neighbours(&faces) {
        match faces[a].compare(&faces[b]) {
            Ordering::Less => {
                nearer[a].push(b);
                behind[b] += 1;
            }
            Ordering::Greater => {
                nearer[b].push(a);
                behind[a] += 1;
            }
            Ordering::Equal => {}
        }
    }
    let mut by_depth: Vec<Next> = (0..faces.len())
        .map(|face| Next {
            depth: faces[face].depth,
            face,
        })
        .collect();
    let free = by_depth.iter().filter(|next| behind[next.face] == 0);
    let mut ready: BinaryHeap<Next> = free.cloned().collect();
    // the farthest last, where circles take from
    by_depth.sort();
    let mut is_painted = vec![false; faces.len()];
    let mut order = Vec::with_capacity(faces.len());
    while let Some(next) = ready.pop().or_else(|| by_depth.pop()) {
        if std::mem::replace(&mut is_painted[next.face], true) {
            continue;
        }
        order.push(next.face);
        for &face in &nearer[next.face] {
            behind[face] = behind[face].saturating_sub(1);
            if behind[face] == 0 && !is_painted[face] {
                let depth = faces[face].depth;
                ready.push(Next { depth, face });
            }
        }
    }
    order
}

/// A face that may be painted next; the greatest is the farthest.
#[derive(Clone)]
struct Next {
    depth: f64,
    face: usize,
}

impl Ord for Next {
    fn cmp(&self, other: &Self) -> Ordering {
        let farther = other.depth.total_cmp(&self.depth);
        farther.then(other.face.cmp(&self.face))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Next {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Next {}

type Triangle = [Corner; 3];

/// A face as triangles, with its bounds in the picture.
struct Face {
    triangles: Vec<Triangle>,
    low: [f64; 2],
    high: [f64; 2],
    area: f64,
    /// The mean depth of its corners.
    depth: f64,
}

impl Face {
    fn new(corners: &[Corner]) -> Self {
        let parts: Vec<[usize; 3]> = match corners.len() {
            6 => vec![[0, 1, 5], [1, 2, 3], [5, 3, 4], [1, 3, 5]],
            count => (2..count).map(|k| [0, k - 1, k]).collect(),
        };
        let triangles: Vec<Triangle> = parts.iter().map(|part| part.map(|k| corners[k])).collect();
        let (low, high) = bounds(corners);
        Face {
            area: triangles.iter().map(|t| area(t).abs()).sum(),
            depth: corners.iter().map(|x| x[2]).sum::<f64>() / corners.len() as f64,
            triangles,
            low,
            high,
        }
    }

    /// `Less` where this face is behind the other one, `Equal` where neither hides the other.
    fn compare(&self, other: &Face) -> Ordering {
        let [mut common, mut nearer] = [0.0; 2];
        for a in &self.triangles {
            for b in &other.triangles {
                let (area, difference) = overlap(a, b);
                common += area;
                nearer += area * difference;
            }
        }
        match common > SHARE * self.area.min(other.area) {
            true => nearer.partial_cmp(&0.0).unwrap_or(Ordering::Equal),
            false => Ordering::Equal,
        }
    }

    fn meets(&self, other: &Face) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }
}

fn bounds(corners: &[Corner]) -> ([f64; 2], [f64; 2]) {
    let none = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    corners.iter().fold(none, |(low, high), x| {
        let ends = |of: fn(f64, f64) -> f64, end: [f64; 2]| [of(end[0], x[0]), of(end[1], x[1])];
        (ends(f64::min, low), ends(f64::max, high))
    })
}

/// The signed area in the picture.
fn area([a, b, c]: &Triangle) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// The area that two triangles cover both, and by how much the first one is nearer to the viewer in its middle.
fn overlap(a: &Triangle, b: &Triangle) -> (f64, f64) {
    let [(low, high), (from, to)] = [a, b].map(|triangle| bounds(triangle));
    if (0..2).any(|i| low[i] >= to[i] || from[i] >= high[i]) || area(a) == 0.0 || area(b) == 0.0 {
        return (0.0, 0.0);
    }
    let mut common = a.to_vec();
    let turn = area(b).signum();
    for k in 0..3 {
        let [p, q] = [b[k], b[(k + 1) % 3]];
        let side = |x: &Corner| turn * area(&[p, q, *x]);
        let mut kept = Vec::with_capacity(common.len() + 1);
        for (n, x) in common.iter().enumerate() {
            let y = &common[(n + 1) % common.len()];
            let (here, there) = (side(x), side(y));
            if here >= 0.0 {
                kept.push(*x);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(x + (y - x) * (here / (here - there)));
            }
        }
        common = kept;
    }
    let fan = (2..common.len()).map(|k| [common[0], common[k - 1], common[k]]);
    // the depth of the part is that of the first triangle, whose corners it was made of
    let (size, moment) = fan.fold((0.0, Vector::<3>::zeros()), |(size, moment), t| {
        let own = area(&t).abs();
        (size + own, moment + (t[0] + t[1] + t[2]) * (own / 3.0))
    });
    if !(size > 0.0) {
        return (0.0, 0.0);
    }
    let middle = moment / size;
    (size, middle[2] - depth_at(b, &middle))
}

/// The depth of a triangle's plane at a place in the picture.
fn depth_at(triangle: &Triangle, x: &Corner) -> f64 {
    let [a, b, c] = triangle;
    let all = area(triangle);
    let share = |t: &Triangle| area(t) / all;
    a[2] * share(&[*x, *b, *c]) + b[2] * share(&[*a, *x, *c]) + c[2] * share(&[*a, *b, *x])
}

/// The pairs of faces whose bounds in the picture meet, each once.
fn neighbours(faces: &[Face]) -> Vec<[usize; 2]> {
    /// The most cells of the grid along an axis.
    const MOST: f64 = 256.0;
    let finite = faces.iter().filter(|face| face.area.is_finite());
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for face in finite {
        for i in 0..2 {
            low[i] = low[i].min(face.low[i]);
            high[i] = high[i].max(face.high[i]);
        }
    }
    let cells = (faces.len() as f64).sqrt().clamp(1.0, MOST).floor();
    let cell = |i: usize, x: f64| {
        let share = (x - low[i]) / (high[i] - low[i]);
        (share * cells).clamp(0.0, cells - 1.0) as usize
    };
    let count = cells as usize;
    let mut buckets = vec![Vec::new(); count * count];
    let mut pairs = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        if !face.area.is_finite() {
            continue;
        }
        let [[left, right], [bottom, top]] =
            [0, 1].map(|i| [cell(i, face.low[i]), cell(i, face.high[i])]);
        for row in bottom..=top {
            for column in left..=right {
                let bucket: &mut Vec<usize> = &mut buckets[row * count + column];
                for &other in bucket.iter() {
                    let known = &faces[other];
                    // of all cells that both are in, the one with the lower left corner of their common part
                    let first = [0, 1].map(|i| cell(i, face.low[i].max(known.low[i])));
                    if first == [column, row] && face.meets(known) {
                        pairs.push([other, number]);
                    }
                }
                bucket.push(number);
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The face that a viewer sees at a place: the last one painted that covers it.
    fn seen(faces: &[Vec<Corner>], at: [f64; 2]) -> Option<usize> {
        let x = Vector::from([at[0], at[1], 0.0]);
        let covers = |face: &&usize| {
            let triangles = Face::new(&faces[**face]).triangles;
            triangles.iter().any(|[a, b, c]| {
                let sides = [[*a, *b, x], [*b, *c, x], [*c, *a, x]].map(|t| area(&t));
                sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0)
            })
        };
        let order = back_to_front(faces);
        let mut numbers = order.clone();
        numbers.sort_unstable();
        assert!(
            numbers.into_iter().eq(0..faces.len()),
            "each once: {order:?}"
        );
        order.iter().rev().find(covers).copied()
    }

    fn face<const N: usize>(corners: [[f64; 3]; N]) -> Vec<Corner> {
        corners.iter().map(|x| Vector::from(*x)).collect()
    }

    /// A long floor that rises towards the viewer to a depth of 10, and a plate at depth 1 above its far end, where the floor is at
    /// 0.5: the floor's centre is nearer, and the plate hides it all the same.
    #[test]
    fn a_small_face_hides_a_large_one_with_a_nearer_centre() {
        let floor = face([
            [0.0, 0.0, 0.0],
            [10.0, 0.0, 10.0],
            [10.0, 1.0, 10.0],
            [0.0, 1.0, 0.0],
        ]);
        let plate = face([[0.2, 0.2, 1.0], [0.8, 0.2, 1.0], [0.5, 0.8, 1.0]]);
        let far = face([[4.2, 0.2, 1.0], [4.8, 0.2, 1.0], [4.5, 0.8, 1.0]]);
        for faces in [
            vec![floor.clone(), plate.clone(), far.clone()],
            vec![far.clone(), plate.clone(), floor.clone()],
        ] {
            let number = |of: &Vec<Corner>| faces.iter().position(|face| face == of);
            assert_eq!(seen(&faces, [0.5, 0.4]), number(&plate));
            assert_eq!(seen(&faces, [4.5, 0.4]), number(&floor));
            assert_eq!(seen(&faces, [0.5, -0.4]), None);
        }
    }

    /// Faces that share an edge do not order each other, and curved ones count as their parts.
    #[test]
    fn neighbours_are_free() {
        let left = face([[0.0, 0.0, 0.0], [1.0, 0.0, 3.0], [0.0, 1.0, 0.0]]);
        let right = face([[1.0, 0.0, 3.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(
            Face::new(&left).compare(&Face::new(&right)),
            Ordering::Equal
        );
        // a bulge: the middle nodes are nearer than the corners by 1, and a plate is between them
        let bulge = face([
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 1.0],
            [2.0, 0.0, 0.0],
            [1.0, 1.0, 1.0],
            [0.0, 2.0, 0.0],
            [0.0, 1.0, 1.0],
        ]);
        let plate = face([[0.5, 0.5, 0.8], [0.7, 0.5, 0.8], [0.5, 0.7, 0.8]]);
        let outer = face([[0.02, 0.02, 0.8], [0.1, 0.02, 0.8], [0.02, 0.1, 0.8]]);
        let faces = vec![plate, bulge, outer];
        assert_eq!(seen(&faces, [0.55, 0.55]), Some(1));
        assert_eq!(seen(&faces, [0.04, 0.04]), Some(2));
    }

    /// Three bars that hide each other in turn have no right order, and are painted all the same.
    #[test]
    fn circles_end() {
        let turn = std::f64::consts::TAU / 3.0;
        let bars: Vec<Vec<Corner>> = (0..3)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * turn).sin_cos();
                let place = |[x, y, z]: [f64; 3]| [cos * x - sin * y, sin * x + cos * y, z];
                face(
                    [
                        [-2.0, 0.5, 0.0],
                        [2.0, 0.5, 1.0],
                        [2.0, 0.7, 1.0],
                        [-2.0, 0.7, 0.0],
                    ]
                    .map(place),
                )
            })
            .collect();
        assert!(seen(&bars, [0.0, 0.0]).is_none());
        assert_eq!(back_to_front(&[]), [0; 0]);
    }

    #[test]
    fn what_is_no_number_is_painted_too() {
        let odd = face([
            [f64::NAN, 0.0, 0.0],
            [1.0, f64::INFINITY, 0.0],
            [0.0, 1.0, 0.0],
        ]);
        let sound = face([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(back_to_front(&[odd, sound]).len(), 2);
    }
}
