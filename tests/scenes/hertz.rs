//! Hertz's contact of a cylinder on a block in plane strain, against the analytic solution.

use crate::common::{relative, run};
use contact_fem::element::Order;
use contact_fem::model::Integration;

use ipopt_contact_scenes::hertz::{FORCE, Fineness, Hertz};

/// The pressures at these places are Hertz's within 6 % of p₀ all along the contact but its edge, where the profile is steep.
pub fn assert_profile(hertz: &Hertz, pressures: impl Iterator<Item = (f64, f64)>) {
    let (p0, a) = (hertz.peak_pressure(), hertz.half_width());
    for (x, p) in pressures.filter(|(x, _)| *x < 0.8 * a) {
        let exact = p0 * (1.0 - (x / a).powi(2)).sqrt();
        assert!((p - exact).abs() < 0.06 * p0, "at {x}: {p}");
    }
}

/// Half-cylinder of radius 50 on a block 100 high, by symmetry their right halves: p₀ = √(P E*/(πR)).
#[test]
fn peak_pressure_and_half_width() {
    hertz(40.0, 90, Order::Linear, None, 0.02);
}

/// A quarter of the facets do for quadratic elements whose boundary is curved.
#[test]
fn quadratic_elements_on_the_true_circle() {
    hertz(10.0, 34, Order::Quadratic, None, 0.01);
}

#[test]
fn integrated_exactly() {
    let exact = Some(Integration::Exact);
    hertz(40.0, 90, Order::Linear, exact, 0.02);
    hertz(10.0, 34, Order::Quadratic, exact, 0.01);
}

/// With facets of a/`in_contact` at the centre of contact and `on_arc` of them around the arc.
fn hertz(
    in_contact: f64,
    on_arc: usize,
    order: Order,
    integration: Option<Integration>,
    tolerance: f64,
) {
    let fineness = Fineness { in_contact, on_arc };
    let hertz = Hertz::new(fineness, order);
    let (p0, a) = (hertz.peak_pressure(), hertz.half_width());
    assert!(
        relative(p0, 1.6034) < 1e-4 && relative(a, 2.779) < 1e-3,
        "the published values"
    );
    let (P, h) = (FORCE, a / in_contact);
    let mut scene = hertz.scene().expect("a scene");
    scene.integration = integration;
    let mut problem = scene.problem().expect("valid scene");
    let history = run(&mut problem, 1, 1e-6);
    let step = history.steps.last().expect("converged");
    assert_eq!(
        step.attempt.iterations.len(),
        1,
        "small strain needs one solve"
    );

    let solution = history.run.solution.as_ref().expect("converged");
    let forces = problem.contact_forces(&solution.gaps, &solution.lambda);
    let pressures = problem
        .pressures(&history.run.state.u, &solution.gaps, &solution.lambda)
        .expect("pressures");
    for (surface, pressure) in problem.surfaces().iter().zip(&pressures) {
        let x = |k: usize| problem.reference()[surface.nodes()[k]][0];
        let centre = (0..pressure.len())
            .min_by(|&i, &j| x(i).abs().total_cmp(&x(j).abs()))
            .expect("nodes");
        assert!(
            relative(pressure[centre], p0) < tolerance,
            "p₀ {} on body {}",
            pressure[centre],
            surface.body()
        );
        assert_profile(&hertz, (0..pressure.len()).map(|k| (x(k), pressure[k])));
        // the pressure vanishes a facet or two beyond the contact, and its resultant is half of P
        let outside = (0..pressure.len()).filter(|&k| x(k) > a + 3.0 * h);
        assert!(outside.map(|k| pressure[k].abs()).fold(0.0, f64::max) < 0.02 * p0);
        let nodes = surface.nodes().iter();
        let force = nodes.map(|&node| forces[node][1]).sum::<f64>().abs();
        assert!(relative(force, 0.5 * P) < 1e-6, "resultant {force}");
    }
}
