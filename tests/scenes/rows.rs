//! Rows of the weak non-penetration constraints where surfaces end.

use contact_core::ContactProblem;
use contact_core::gaps::Sampling;
use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::{Integration, Problem};
use contact_fem::{Body, NeoHookean};
use ipopt_contact_scenes::pair;

/// How far the faces are apart at x = 0, and the slope of the upper one.
const GAP: f64 = 0.2;
const SLOPE: f64 = 0.1;

/// A block of four quadratic cells, each 1 wide, below one of one cell that ends at x = `end` above
/// them, at a height of GAP + SLOPE x.
fn below_a_slope(end: f64) -> Problem<2> {
    let law = NeoHookean::new(1.0, 0.3).expect("law");
    let block = |xs: &[f64], y: f64| rectangle(xs, &[y, y + 0.5], Diagonals::Rising);
    let lower = block(&linspace(0.0, 4.0, 4), -0.5)
        .expect("mesh")
        .quadratic();
    let mut lower = Body::new(lower, law);
    lower.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let upper = block(&[0.1, end], GAP).expect("mesh").quadratic();
    let sloping = upper.mapped(|X| [X[0], X[1] + SLOPE * X[0]].into());
    let mut upper = Body::new(sloping.expect("sloping"), law);
    upper.prescribe("top", [Some(0.0); 2]).expect("support");
    let mut scene = pair((lower, "top"), (upper, "bottom")).expect("pair");
    scene.reach = Some(1.0);
    scene.integration = Some(Integration::Gauss(64)); // to end about anywhere
    scene.problem().expect("valid scene")
}

/// A row is a mean of gaps: it says no more than they do, wherever in a facet the other surface ends.
/// Quadratic functions change their sign, so that a row may reach beyond the gaps that it averages,
/// but not by more than these differ over a facet.
#[test]
fn rows_are_means_of_gaps_wherever_the_other_surface_ends() {
    for k in 0..=100 {
        let end = 2.0 + 0.01 * f64::from(k);
        let problem = below_a_slope(end);
        let u = vec![0.0; problem.energy().dofs()];
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        assert!(gaps.len() > 4);
        let mut c = vec![0.0; gaps.len()];
        gaps.value(&u, &mut c);
        // distances from a slope are shorter than heights below it
        let allowed = 0.99 * GAP - SLOPE..GAP + SLOPE * (end + 1.0);
        for (key, c) in gaps.keys().iter().zip(&c) {
            assert!(allowed.contains(c), "{key:?} of end {end}: {c}");
        }
    }
}
