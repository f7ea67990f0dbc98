//! What several of these tests do.
#![allow(non_snake_case)]

use contact_fem::Simulation;
use contact_fem::certificate::Limits;
use contact_fem::model::Problem;
use contact_fem::simulation::History;
use contact_fem::tensor::Vector;

/// Full load in so many increments, complete, and held by its certificate at the end.
pub fn ended<const D: usize>(problem: &mut Problem<D>, increments: usize) -> History<D> {
    let history = Simulation::with_increments(increments).run(problem);
    let history = history.expect("a run");
    assert!(history.is_complete(), "{}", history.run.ending);
    let certificate = &history.last().expect("a step").certificate;
    assert!(certificate.holds(&Limits::default()), "{certificate}");
    history
}

/// u at the node at X.
pub fn at<const D: usize>(problem: &Problem<D>, u: &[f64], X: [f64; D]) -> Vector<D> {
    let X = Vector::from(X);
    let nodes = problem.reference().iter();
    let found = nodes
        .zip(problem.displacements(u))
        .find(|(Y, _)| (*Y - X).norm() < 1e-9);
    found.expect("a node").1
}

/// Radial stress P (first Piola–Kirchhoff) of a neo-Hookean law by the principal stretches of plane strain.
fn stress(lame: [f64; 2], along: f64, across: f64) -> f64 {
    let [lambda, mu] = lame;
    mu * (along - 1.0 / along) + lambda * (along * across).ln() / along
}

/// The radius to which the bore of a tube, 1 to 2 wide, grows under a pressure p: dP/dR = (P_θ − P)/R and dr/dR = the stretch
/// that has the stress P, from P = −p r/R at R = 1 to P = 0 at R = 2, by Runge and Kutta's method and bisection.
pub fn bore(lame: [f64; 2], p: f64) -> f64 {
    let slope = |R: f64, r: f64, P: f64| {
        let around = r / R;
        let (mut low, mut high) = (1e-3, 1e3);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            match stress(lame, middle, around) < P {
                true => low = middle,
                false => high = middle,
            }
        }
        (low, (stress(lame, around, low) - P) / R)
    };
    let at_rim = |bore: f64| {
        let (mut r, mut P, steps) = (bore, -p * bore, 200);
        let h = 1.0 / f64::from(steps);
        for k in 0..steps {
            let R = 1.0 + h * f64::from(k);
            let a = slope(R, r, P);
            let b = slope(R + 0.5 * h, r + 0.5 * h * a.0, P + 0.5 * h * a.1);
            let c = slope(R + 0.5 * h, r + 0.5 * h * b.0, P + 0.5 * h * b.1);
            let d = slope(R + h, r + h * c.0, P + h * c.1);
            r += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
            P += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
        }
        P
    };
    // the larger the bore, the more is pulled at the rim
    let (mut low, mut high) = (1.0, 2.0);
    assert!(at_rim(low) < 0.0 && at_rim(high) > 0.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        match at_rim(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}
