//! A grid of bins that tells quickly what is away from given boxes.

use rstar::AABB;

/// A regular grid of bins over boxes, in which those that a box meets are marked.
pub(super) struct Bins<const D: usize> {
    low: [f64; D],
    /// Bins per length, along each axis the same (1/UL).
    scale: f64,
    /// The number of bins along each axis.
    sides: [usize; D],
    marked: Vec<bool>,
}

impl<const D: usize> Bins<D> {
    /// The largest number of bins along the longest axis.
    const MOST: usize = match D {
        3 => 48,
        _ => 160,
    };

    pub fn new(boxes: impl Iterator<Item = AABB<[f64; D]>>) -> Self {
        let boxes: Vec<_> = boxes.collect();
        let least = |of: &dyn Fn(&AABB<[f64; D]>) -> f64| {
            boxes.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        let low: [f64; D] = std::array::from_fn(|i| least(&|b| b.lower()[i]));
        let extents: [f64; D] = std::array::from_fn(|i| -least(&|b| -b.upper()[i]) - low[i]);
        let longest = extents.iter().copied().fold(0.0, f64::max);
        // as many as there are boxes along a side, if they cover a surface
        let along = (boxes.len() as f64).powf(1.0 / (D as f64 - 1.0));
        let scale = along.ceil().clamp(1.0, Self::MOST as f64) / longest;
        // what has no extent is in one bin
        let scale = if scale.is_finite() { scale } else { 0.0 };
        let side = |extent: f64| ((extent * scale).ceil() as usize).clamp(1, Self::MOST);
        let sides = extents.map(side);
        let mut bins = Bins {
            low,
            scale,
            sides,
            marked: vec![false; sides.iter().product()],
        };
        for b in &boxes {
            let mut marked = std::mem::take(&mut bins.marked);
            bins.visit(b, |place| {
                marked[place] = true;
                false
            });
            bins.marked = marked;
        }
        bins
    }

    /// Whether a box is in a bin with one of the boxes. It is not if it meets none of them.
    pub fn meet(&self, envelope: &AABB<[f64; D]>) -> bool {
        self.visit(envelope, |place| self.marked[place])
    }

    /// Visits the bins that a box meets until `found` is true, and tells whether it was.
    fn visit(&self, envelope: &AABB<[f64; D]>, mut found: impl FnMut(usize) -> bool) -> bool {
        let bin = |x: [f64; D]| -> [usize; D] {
            std::array::from_fn(|i| {
                let place = (x[i] - self.low[i]) * self.scale;
                (place.max(0.0) as usize).min(self.sides[i] - 1)
            })
        };
        let (first, last) = (bin(envelope.lower()), bin(envelope.upper()));
        let mut at = first;
        loop {
            let axes = at.iter().zip(&self.sides);
            let place = axes.fold(0, |place, (k, side)| place * side + k);
            if found(place) {
                return true;
            }
            let Some(axis) = (0..D).rev().find(|&i| at[i] < last[i]) else {
                return false;
            };
            at[axis] += 1;
            at[axis + 1..].copy_from_slice(&first[axis + 1..]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square of which the lower left corner and the right side are marked.
    #[test]
    fn what_is_away_is_told() {
        let corner = AABB::from_corners([0.0, 0.0], [0.1, 0.1]);
        let side = AABB::from_corners([1.0, 0.0], [1.0, 1.0]);
        let corners = std::iter::repeat_n(corner, 100);
        let bins = Bins::new(corners.chain([side]));
        let around =
            |x: f64, y: f64| AABB::from_corners([x - 0.02, y - 0.02], [x + 0.02, y + 0.02]);
        for (x, y, meets) in [
            (0.05, 0.05, true),
            (0.11, 0.11, true),
            (0.2, 0.05, false),
            (0.5, 0.5, false),
            (0.99, 0.7, true),
            (1.5, 0.7, true),
        ] {
            assert_eq!(bins.meet(&around(x, y)), meets, "({x}, {y})");
        }
        assert!(bins.meet(&AABB::from_corners([-1.0, -1.0], [2.0, 2.0])));
    }

    /// Boxes without extent, and places that are none.
    #[test]
    fn degenerate_boxes_are_kept() {
        let point = AABB::from_corners([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]);
        let bins = Bins::new(std::iter::once(point));
        assert!(bins.meet(&point));
        let none = Bins::<3>::new(std::iter::empty());
        assert!(!none.meet(&point));
        let endless = AABB::from_corners([0.0; 3], [f64::INFINITY; 3]);
        let bins = Bins::new(std::iter::once(endless));
        assert!(bins.meet(&point));
    }
}
