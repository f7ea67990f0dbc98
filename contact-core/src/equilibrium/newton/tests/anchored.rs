//! Motions that nothing resists, and equilibria that are left.

use super::*;

/// A body of two points on a floor. The unknowns are their common height y ≥ −0.25 and their places x₁, x₂, a spring between them;
/// y is pressed down with a force of 350 more than its own stiffness takes there, and x₁ is pushed along the floor.
fn on_a_floor(push: f64) -> Toy {
    let K = DMatrix::from_row_slice(3, 3, &[1e3, 0.0, 0.0, 0.0, 50.0, -50.0, 0.0, -50.0, 50.0]);
    let floor = (vec![1.0, 0.0, 0.0], 0.25);
    Toy::quadratic(&K, &[-600.0, push, 0.0], &[floor])
}

#[test]
fn a_small_force_along_a_floor_is_held_and_told() {
    let solution = on_a_floor(1.0).solve_from(&[0.0; 3]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.lambda, &[350.0], 1e-6);
    let u = &solution.state.u;
    assert!((u[0] + 0.25).abs() < 1e-9, "{u:?}");
    // ∇E = Cᵀλ + what holds: along the floor, that is the push
    let held = &solution.held;
    assert!((held[1] + held[2] + 1.0).abs() < 1e-6, "{held:?}");
    let mut g = [0.0; 3];
    on_a_floor(1.0).gradient(u, &mut g);
    assert!((g[0] - 350.0 - held[0]).abs() < 1e-6, "{g:?} {held:?}");
    assert!((g[1] - held[1]).abs().max((g[2] - held[2]).abs()) < 1e-6);
}

#[test]
fn a_larger_one_is_no_equilibrium() {
    let solution = on_a_floor(20.0).solve_from(&[0.0; 3]);
    assert_eq!(solution.outcome, Outcome::IterationLimit);
    assert!(solution.held.is_empty());
}

#[test]
fn without_a_force_nothing_is_held() {
    let solution = on_a_floor(0.0).solve_from(&[0.0, 0.5, 0.7]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert!(solution.held.is_empty());
    // the spring has no length of its own
    let u = &solution.state.u;
    assert!((u[1] - u[2]).abs() < 1e-7, "{u:?}");
}

/// E = (x² − 1)² + ½ (y − 1)², from x = 0, where ∂E/∂x is zero and E largest: there are minima at x = ±1.
#[test]
fn a_maximum_is_left_without_rows() {
    let mut toy = Toy::quadratic(&DMatrix::identity(2, 2), &[0.0; 2], &[]);
    toy.value = Box::new(|u| (u[0] * u[0] - 1.0).powi(2) + 0.5 * (u[1] - 1.0).powi(2));
    toy.gradient = Box::new(|u| vec![4.0 * u[0] * (u[0] * u[0] - 1.0), u[1] - 1.0]);
    toy.hessian =
        Box::new(|u| DMatrix::from_row_slice(2, 2, &[12.0 * u[0] * u[0] - 4.0, 0.0, 0.0, 1.0]));
    let solution = toy.solve_from(&[0.0; 2]);
    assert_eq!(solution.outcome, Outcome::Converged);
    let u = &solution.state.u;
    assert!(
        (u[0].abs() - 1.0).abs() < 1e-7 && (u[1] - 1.0).abs() < 1e-7,
        "{u:?}"
    );
    assert!(solution.energy < 1e-12);
    assert!(solution.curvature.is_none_or(|curvature| curvature > 0.0));
}
