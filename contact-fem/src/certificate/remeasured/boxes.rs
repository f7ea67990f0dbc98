//! Boxes sorted along one axis.

use crate::tensor::Vector;

/// The boxes of facets, sorted by their low ends along the axis along which they spread most.
pub(super) struct Sorted<const D: usize> {
    axis: usize,
    /// Ascending: the low end along the axis, the box, and its number.
    boxes: Vec<(f64, [Vector<D>; 2], usize)>,
    /// The longest box along the axis (UL).
    longest: f64,
}

impl<const D: usize> Sorted<D> {
    pub fn new(boxes: impl Iterator<Item = [Vector<D>; 2]>) -> Self {
        let boxes: Vec<[Vector<D>; 2]> = boxes.collect();
        let endless = Vector::<D>::repeat(f64::INFINITY);
        let low = boxes.iter().fold(endless, |low, b| low.inf(&b[0]));
        let high = boxes.iter().fold(-endless, |high, b| high.sup(&b[1]));
        let axis = (high - low).imax();
        let longest = boxes.iter().map(|b| b[1][axis] - b[0][axis]);
        let longest = longest.fold(0.0, f64::max);
        let numbered = boxes.into_iter().enumerate();
        let mut boxes: Vec<_> = numbered.map(|(k, b)| (b[0][axis], b, k)).collect();
        boxes.sort_by(|a, b| a.0.total_cmp(&b.0));
        Sorted {
            axis,
            boxes,
            longest,
        }
    }

    /// The numbers of the boxes with a point within `distance` of `x`.
    pub fn within(&self, x: &Vector<D>, distance: f64) -> impl Iterator<Item = usize> + '_ {
        let (at, x) = (x[self.axis], *x);
        let first = at - distance - self.longest;
        let first = self.boxes.partition_point(|(low, ..)| *low < first);
        let near = self.boxes[first..].iter();
        let near = near.take_while(move |(low, ..)| *low <= at + distance);
        let near = near.filter(move |(_, [low, high], _)| {
            let beside = (low - x).sup(&(x - high)).sup(&Vector::zeros());
            beside.norm_squared() <= distance * distance
        });
        near.map(|(.., number)| *number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of several lengths, of which exactly the near ones are found.
    #[test]
    fn near_boxes_are_found() {
        let boxes: Vec<[Vector<2>; 2]> = (0..60)
            .map(|k| {
                let low = Vector::<2>::new(f64::from(k * 7 % 60), f64::from(k % 3));
                [low, low + Vector::<2>::new(0.1 + f64::from(k % 5), 0.5)]
            })
            .collect();
        let sorted = Sorted::new(boxes.iter().copied());
        for at in [[3.3, 0.2], [30.0, 9.0], [-4.0, 1.0], [63.0, 2.0]] {
            let x = Vector::<2>::from(at);
            for distance in [0.1, 2.0, 8.0] {
                let mut found: Vec<usize> = sorted.within(&x, distance).collect();
                found.sort_unstable();
                let is_near = |b: &[Vector<2>; 2]| {
                    let nearest = x.sup(&b[0]).inf(&b[1]);
                    (nearest - x).norm() <= distance
                };
                let expected = (0..60).filter(|&k| is_near(&boxes[k]));
                assert_eq!(found, expected.collect::<Vec<_>>(), "{at:?} {distance}");
            }
        }
    }
}
