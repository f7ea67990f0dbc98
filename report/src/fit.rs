//! Orders of convergence.

/// A line through the logarithms: error ≈ C hᵏ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// k, by least squares.
    pub order: f64,
    /// ln C.
    pub log_constant: f64,
    /// The largest and the smallest h that it was fitted to (UL).
    pub h: [f64; 2],
    /// The smallest and the largest order between two neighbours among these points.
    pub local: [f64; 2],
    /// How many points it was fitted to.
    pub points: usize,
}

impl Fit {
    /// The fewest and the most points of a fit.
    const FEWEST: usize = 3;
    const MOST: usize = 4;
    /// Neighbouring orders that differ by more than this are not in one asymptotic range.
    const SPREAD: f64 = 0.35;

    /// Through the finest points of (h, error): three of them, and a fourth if its order agrees with theirs. Errors
    /// that are 0 have no logarithm and are left out. Nothing for fewer than three points.
    pub fn new(points: &[(f64, f64)]) -> Option<Self> {
        let usable = |(h, error): &&(f64, f64)| *h > 0.0 && *error > 0.0;
        let mut points: Vec<(f64, f64)> = points.iter().filter(usable).copied().collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        if points.len() < Self::FEWEST {
            return None;
        }
        let few = Self::through(&points[..Self::FEWEST]);
        let more = points.get(..Self::MOST).map(Self::through);
        Some(more.filter(Self::is_asymptotic).unwrap_or(few))
    }

    /// Whether the orders between neighbours agree.
    pub fn is_asymptotic(&self) -> bool {
        self.local[1] - self.local[0] <= Self::SPREAD
    }

    fn through(points: &[(f64, f64)]) -> Self {
        let logs: Vec<[f64; 2]> = points.iter().map(|(h, e)| [h.ln(), e.ln()]).collect();
        let count = logs.len() as f64;
        let mean = |k: usize| logs.iter().map(|log| log[k]).sum::<f64>() / count;
        let (x, y) = (mean(0), mean(1));
        let covariance: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
        let variance: f64 = logs.iter().map(|log| (log[0] - x).powi(2)).sum();
        let order = covariance / variance;
        let slopes = logs
            .windows(2)
            .map(|w| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0]));
        let (low, high) = slopes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), k| {
            (low.min(k), high.max(k))
        });
        Fit {
            order,
            log_constant: y - order * x,
            h: [points[points.len() - 1].0, points[0].0],
            local: [low, high],
            points: points.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn halved(error: impl Fn(f64) -> f64, count: i32) -> Vec<(f64, f64)> {
        (0..count)
            .map(|k| 0.5_f64.powi(k))
            .map(|h| (h, error(h)))
            .collect()
    }

    #[test]
    fn powers_are_found() {
        for order in [0.5, 1.0, 1.5, 3.0] {
            let fit = Fit::new(&halved(|h| 7.0 * h.powf(order), 5)).expect("points");
            assert!((fit.order - order).abs() < 1e-12 && fit.is_asymptotic());
            assert!((fit.log_constant - 7.0_f64.ln()).abs() < 1e-12);
            assert_eq!((fit.points, fit.h), (4, [0.5, 0.0625]), "the finest four");
        }
    }

    #[test]
    fn only_the_asymptotic_end_counts() {
        // coarse meshes are out of the asymptotic range
        let bent = halved(|h| if h > 0.2 { 1.0 } else { h * h }, 6);
        let fit = Fit::new(&bent).expect("points");
        assert!((fit.order - 2.0).abs() < 1e-12, "{fit:?}");
        assert_eq!(fit.points, 3);
        // a floor bends it, which is told
        let fit = Fit::new(&halved(|h| h * h + 1e-2, 6)).expect("points");
        assert!(fit.order < 1.0 && !fit.is_asymptotic(), "{fit:?}");
    }

    #[test]
    fn what_cannot_be_fitted() {
        assert_eq!(Fit::new(&halved(|h| h, 2)), None);
        assert_eq!(Fit::new(&[(1.0, 0.0), (0.5, 0.0), (0.25, 0.0)]), None);
        assert_eq!(
            Fit::new(&[(1.0, 0.1), (1.0, 0.1), (0.5, 0.1)]),
            None,
            "two meshes"
        );
        // in any order
        let mut points = halved(|h| h, 4);
        points.reverse();
        assert!((Fit::new(&points).expect("points").order - 1.0).abs() < 1e-12);
    }
}
