//! The diagonal of a stiffness, in units of which shifts and springs are chosen.

use crate::linear::SymmetricPattern;

/// The diagonal of K, with the `values` of a pattern (n, UF/UL). An unknown without a stiffness of its own, as the motion of a rigid
/// body, has the median of the other unknowns' entries there, or 1 UF/UL where no unknown has a stiffness.
pub(super) fn diagonal(pattern: &SymmetricPattern, values: &[f64]) -> Vec<f64> {
    let own = |j: usize| pattern.slot(j, j).map_or(0.0, |slot| values[slot]);
    let mut all: Vec<f64> = (0..pattern.dim()).map(own).collect();
    let largest = all.iter().fold(0.0, |most: f64, k| most.max(k.abs()));
    let has_none = |k: &f64| k.abs() <= f64::EPSILON * largest;
    if !all.iter().any(has_none) {
        return all;
    }
    let mut others: Vec<f64> = all.iter().map(|k| k.abs()).collect();
    others.retain(|k| !has_none(k));
    let middle = others.len() / 2;
    let typical = match others.is_empty() {
        true => 1.0,
        false => *others.select_nth_unstable_by(middle, f64::total_cmp).1,
    };
    let without = all.iter_mut().filter(|k| has_none(k));
    without.for_each(|k| *k = typical);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_stiffness_has_that_of_the_others() {
        let pattern = SymmetricPattern::diagonal(5);
        assert_eq!(diagonal(&pattern, &[0.0; 5]), [1.0; 5]);
        let soft = [3.0, 0.0, -2.0, 1e-300, 7.0];
        assert_eq!(diagonal(&pattern, &soft), [3.0, 3.0, -2.0, 3.0, 7.0]);
        // stiffnesses of any size are their own
        let mixed = [1e-12, 1.0, 1e3, 1.0, 1.0];
        assert_eq!(diagonal(&pattern, &mixed), mixed);
        let sparse = SymmetricPattern::from_entries(2, &[(1, 1)]).expect("a pattern");
        assert_eq!(diagonal(&sparse.0, &[4.0]), [4.0, 4.0]);
    }
}
