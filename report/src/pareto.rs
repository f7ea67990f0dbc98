//! Which runs no other beats.

/// Of points (cost, error) the numbers of those for which no other is at least as cheap and at least as accurate and
/// one of both by more, by rising cost. Of equal points the first.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let is_number = |k: &usize| points[*k].0.is_finite() && points[*k].1.is_finite();
    let mut order: Vec<usize> = (0..points.len()).filter(is_number).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a], points[b]);
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut best = f64::INFINITY;
    order.retain(|&k| {
        let better = points[k].1 < best;
        best = best.min(points[k].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_on_the_front_is_beaten() {
        let points = [
            (3.0, 0.1),
            (1.0, 1.0),
            (2.0, 0.1),
            (4.0, 0.5),
            (2.0, 0.3),
            (9.0, 0.01),
        ];
        assert_eq!(front(&points), [1, 2, 5]);
        let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
        for (k, &point) in points.iter().enumerate() {
            let beaten = points.iter().any(|&other| beats(other, point));
            assert_eq!(front(&points).contains(&k), !beaten, "{point:?}");
        }
    }

    #[test]
    fn what_has_no_number_is_not_on_it() {
        let points = [(f64::NAN, 0.0), (1.0, f64::NAN), (1.0, 0.5), (1.0, 0.5)];
        assert_eq!(front(&points), [2]);
        assert!(front(&[]).is_empty());
    }
}
