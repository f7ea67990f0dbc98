//! The minimum of a convex, piecewise quadratic function of one variable.

use faer::Col;

/// The t > 0 at which ψ'(t) = `work` + t `curvature` − Σ eᵢ (sᵢ − t eᵢ)₊ vanishes, s being `margin` and e `change`;
/// nothing where ψ does not fall from t = 0.
pub(super) fn exact_step(
    work: f64,
    curvature: f64,
    margin: &Col<f64>,
    change: &Col<f64>,
) -> Option<f64> {
    let pairs = || margin.iter().copied().zip(change.iter().copied());
    // ψ' = a + b t between two kinks
    let (mut a, mut b) = (work, curvature);
    for (s, e) in pairs().filter(|&(s, e)| s > 0.0 || (s == 0.0 && e < 0.0)) {
        a -= e * s;
        b += e * e;
    }
    if !(a < 0.0) {
        return None;
    }
    let mut kinks: Vec<(f64, f64, f64)> = pairs()
        .filter(|(s, e)| s * e > 0.0)
        .map(|(s, e)| (s / e, s, e))
        .collect();
    kinks.sort_unstable_by(|left, right| left.0.total_cmp(&right.0));
    for (t, s, e) in kinks {
        if a + b * t >= 0.0 {
            break;
        }
        // beyond it the term of e > 0 is gone, that of e < 0 is there
        let sign = if e > 0.0 { 1.0 } else { -1.0 };
        a += sign * e * s;
        b -= sign * e * e;
    }
    let t = -a / b;
    (t.is_finite() && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ψ' at t, term by term.
    fn slope(work: f64, curvature: f64, s: &Col<f64>, e: &Col<f64>, t: f64) -> f64 {
        let terms = s.iter().zip(e.iter());
        let terms = terms.map(|(s, e)| e * (s - t * e).max(0.0));
        work + t * curvature - terms.sum::<f64>()
    }

    #[test]
    fn the_slope_vanishes_at_the_step() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut found = 0;
        for _ in 0..2000 {
            let m = random.usize(1..9);
            let mut next = || 2.0 * random.f64() - 1.0;
            let s = Col::from_fn(m, |i| if i % 4 == 3 { 0.0 } else { next() });
            let e = Col::from_fn(m, |_| next());
            let (work, curvature) = (next(), next().abs() + 1e-3);
            let at_rest = slope(work, curvature, &s, &e, 0.0);
            match exact_step(work, curvature, &s, &e) {
                Some(t) => {
                    found += 1;
                    let left = slope(work, curvature, &s, &e, t);
                    assert!(at_rest < 0.0 && left.abs() < 1e-10, "{left:e} at {t}");
                }
                None => assert!(at_rest >= 0.0, "{at_rest:e}"),
            }
        }
        assert!(found > 500, "{found}");
    }
}
