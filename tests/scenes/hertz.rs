//! Hertz's contact of a cylinder on a block in plane strain, against the analytic solution.

use std::f64::consts::{PI, TAU};

use crate::common::{relative, run};
use contact_fem::element::Order;
use contact_fem::mesh::generators::{Diagonals, graded, onto_sphere, quarter_disc, rectangle};
use contact_fem::scene::Integration;
use contact_fem::{Body, LinearElastic, Mesh, Scene};

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

/// With facets of a/`fineness` at the centre of contact and `count` of them around the arc.
fn hertz(
    fineness: f64,
    count: usize,
    order: Order,
    integration: Option<Integration>,
    tolerance: f64,
) {
    let (R, P, nu) = (50.0, 7.0, 0.3);
    let (E_cylinder, E_block): (f64, f64) = (210.0, 70.0);
    let E_star = 1.0 / ((1.0 - nu * nu) / E_cylinder + (1.0 - nu * nu) / E_block);
    let p0 = (P * E_star / (PI * R)).sqrt();
    let a = (4.0 * P * R / (PI * E_star)).sqrt();
    assert!(
        relative(p0, 1.6034) < 1e-4 && relative(a, 2.779) < 1e-3,
        "the published values"
    );

    // facets grow outwards
    let h = a / fineness;
    let grade = |to, first, count| graded(0.0, to, first, count).expect("grading");
    let angles = graded(1.5 * PI, TAU, h / R, count).expect("grading");
    let depth = grade(R, h, count * 52 / 90);
    let radii: Vec<f64> = depth.iter().rev().map(|d| R - d).collect();
    let xs = grade(100.0, 1.07 * h, count * 10 / 9);
    let ys: Vec<f64> = grade(100.0, h, count * 2 / 3)
        .iter()
        .rev()
        .map(|d| -d)
        .collect();

    let of_order = |mesh: Mesh<2>, curved: &str| match order {
        Order::Linear => mesh,
        Order::Quadratic if curved.is_empty() => mesh.quadratic(),
        Order::Quadratic => {
            let mesh = mesh.quadratic().curved(curved, onto_sphere(R));
            mesh.expect("curved")
        }
    };
    let cylinder = quarter_disc(&radii, &angles, Diagonals::Falling).expect("mesh");
    let cylinder = of_order(cylinder, "arc")
        .translated([0.0, R])
        .expect("moved");
    let mut cylinder = Body::new(cylinder, LinearElastic::new(E_cylinder, nu).expect("law"));
    cylinder
        .prescribe("axis", [Some(0.0), None])
        .expect("symmetry");
    cylinder
        .traction("flat", [0.0, -0.5 * P / R])
        .expect("load");
    let block = rectangle(&xs, &ys, Diagonals::Rising).expect("mesh");
    let mut block = Body::new(
        of_order(block, ""),
        LinearElastic::new(E_block, nu).expect("law"),
    );
    block
        .prescribe("left", [Some(0.0), None])
        .expect("symmetry");
    block
        .prescribe("bottom", [Some(0.0), Some(0.0)])
        .expect("support");

    let mut scene = Scene::new(vec![cylinder, block]);
    scene.contact((0, "arc"), (1, "top")).expect("surfaces");
    scene.integration = integration.unwrap_or(scene.integration);
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
        // all along the contact but its edge, where the profile is steep
        for k in (0..pressure.len()).filter(|&k| x(k) < 0.8 * a) {
            let exact = p0 * (1.0 - (x(k) / a).powi(2)).sqrt();
            assert!(
                (pressure[k] - exact).abs() < 0.06 * p0,
                "at {}: {}",
                x(k),
                pressure[k]
            );
        }
        // the pressure vanishes a facet or two beyond the contact, and its resultant is half of P
        let outside = (0..pressure.len()).filter(|&k| x(k) > a + 3.0 * h);
        assert!(outside.map(|k| pressure[k].abs()).fold(0.0, f64::max) < 0.02 * p0);
        let nodes = surface.nodes().iter();
        let force = nodes.map(|&node| forces[node][1]).sum::<f64>().abs();
        assert!(relative(force, 0.5 * P) < 1e-6, "resultant {force}");
    }
}
