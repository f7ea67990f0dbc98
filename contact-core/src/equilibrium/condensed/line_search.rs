//! The minimum of a convex, piecewise quadratic function of one variable.

use faer::Col;

/// The t > 0 at which ψ'(t) = `work` + t `curvature` − Σ eᵢ Pᵢ(sᵢ − t eᵢ) vanishes, s being `margin` and e `change`, and Pᵢ the nearest value
/// between the two `limits` of i; nothing where ψ does not fall from t = 0.
pub(super) fn exact_step(
    work: f64,
    curvature: f64,
    margin: &Col<f64>,
    change: &Col<f64>,
    limits: impl Fn(usize) -> [f64; 2],
) -> Option<f64> {
    let all = || (0..margin.nrows()).map(|i| (margin[i], change[i], limits(i)));
    // ψ' = a + b t between two kinks
    let (mut a, mut b) = (work, curvature);
    for (s, e, [low, high]) in all() {
        let enters = s == low && e < 0.0 || s == high && e > 0.0;
        let is_between = s > low && s < high || enters && low < high;
        a -= e * s.max(low).min(high);
        if is_between {
            b += e * e;
        }
    }
    if !(a < 0.0) {
        return None;
    }
    // beyond a kink, the term is constant where it has become the limit, and linear where it was
    let kink = |(s, e, limit): (f64, f64, f64), is_low: bool| {
        let t = (s - limit) / e;
        let sign = if (e > 0.0) == is_low { 1.0 } else { -1.0 };
        (t > 0.0 && t.is_finite()).then_some((t, sign * e * (s - limit), sign * e * e))
    };
    let mut kinks: Vec<(f64, f64, f64)> = all()
        .filter(|(_, e, [low, high])| *e != 0.0 && low < high)
        .flat_map(|(s, e, [low, high])| [kink((s, e, low), true), kink((s, e, high), false)])
        .flatten()
        .collect();
    kinks.sort_unstable_by(|left, right| left.0.total_cmp(&right.0));
    for (t, more, less) in kinks {
        if a + b * t >= 0.0 {
            break;
        }
        a += more;
        b -= less;
    }
    let t = -a / b;
    (t.is_finite() && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The limits of some variables: of contact, of friction, of friction without a force.
    fn limits(i: usize) -> [f64; 2] {
        [[0.0, f64::INFINITY], [-0.4, 0.4], [0.0, 0.0]][i % 3]
    }

    /// ψ' at t, term by term.
    fn slope(work: f64, curvature: f64, s: &Col<f64>, e: &Col<f64>, t: f64) -> f64 {
        let term = |i: usize| {
            let [low, high] = limits(i);
            e[i] * (s[i] - t * e[i]).clamp(low, high)
        };
        work + t * curvature - (0..s.nrows()).map(term).sum::<f64>()
    }

    #[test]
    fn the_slope_vanishes_at_the_step() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut found = 0;
        for _ in 0..2000 {
            let m = random.usize(1..9);
            let mut next = || 2.0 * random.f64() - 1.0;
            let s = Col::from_fn(m, |i| match i % 8 {
                3 => 0.0,
                4 => 0.4,
                7 => -0.4,
                _ => next(),
            });
            let e = Col::from_fn(m, |_| next());
            let (work, curvature) = (next(), next().abs() + 1e-3);
            let at_rest = slope(work, curvature, &s, &e, 0.0);
            match exact_step(work, curvature, &s, &e, limits) {
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
