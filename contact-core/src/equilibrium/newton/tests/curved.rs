//! Points on springs at round obstacles: rows that move with u, and forces that have no potential.

use fastrand::Rng;

use super::*;

/// A point on a spring, ½ (u − a)ᵀK (u − a), at the unit circle around the origin: outside it, or inside it if `is_ring`.
///
/// The force acts along n at the angle φ = θ + `turned` sin 3θ of a point at the angle θ. With `turned` ≠ 0 it is not the
/// gradient of the gap, as along an averaged normal.
#[derive(Clone, Copy)]
struct Spring {
    stiffness: [f64; 2],
    pulled_to: [f64; 2],
    is_ring: bool,
    turned: f64,
}

impl Spring {
    fn sign(self) -> f64 {
        if self.is_ring { -1.0 } else { 1.0 }
    }

    /// n, and its slope by θ.
    fn normal(self, theta: f64) -> ([f64; 2], [f64; 2]) {
        let phi = theta + self.turned * (3.0 * theta).sin();
        let slope = self.sign() * (1.0 + 3.0 * self.turned * (3.0 * theta).cos());
        let (sin, cos) = phi.sin_cos();
        (
            [self.sign() * cos, self.sign() * sin],
            [-slope * sin, slope * cos],
        )
    }

    fn rows(self, u: &[f64]) -> LinearGaps {
        let rho = u[0].hypot(u[1]);
        let (n, _) = self.normal(u[1].atan2(u[0]));
        let mut gaps = LinearGaps::new(false);
        let c = self.sign() * (rho - 1.0);
        gaps.push(key(0), &row(&n, c - n[0] * u[0] - n[1] * u[1]));
        gaps
    }

    /// By u and, as an internal variable, by θ.
    fn vary(self, u: &[f64], lambda: &[Option<f64>]) -> GapVariation {
        let rho = u[0].hypot(u[1]);
        let mut variation = GapVariation::default();
        let along = [(0, -u[1] / (rho * rho)), (1, u[0] / (rho * rho))];
        variation.internal.push(&along);
        let sign = self.sign();
        match lambda[0] {
            Some(lambda) => {
                let gradient = [(0, sign * u[0] / rho), (1, sign * u[1] / rho)];
                variation.gradients.push(&gradient);
                let (_, slope) = self.normal(u[1].atan2(u[0]));
                for (i, slope) in slope.into_iter().enumerate() {
                    variation.push_force(i, &[], &[(0, lambda * slope)]);
                }
            }
            None => variation.gradients.push(&[]),
        }
        variation.internal_gradients.push(&[]);
        variation
    }

    /// The problem, with or without the variation of its row.
    fn toy(self, varies: bool) -> Toy {
        let K = DMatrix::from_diagonal(&DVector::from_column_slice(&self.stiffness));
        let load = [0, 1].map(|i| self.stiffness[i] * self.pulled_to[i]);
        let mut toy = Toy::quadratic(&K, &load, &[]);
        toy.rows = Box::new(move |u| self.rows(u));
        if varies {
            toy.vary = Some(Box::new(move |u, _, lambda| self.vary(u, lambda)));
        }
        toy
    }

    /// θ between two angles at which K (u − a) is parallel to n, by bisection.
    fn angle(self, mut low: f64, mut high: f64) -> f64 {
        let moment = |theta: f64| {
            let (n, _) = self.normal(theta);
            let force = [
                self.stiffness[0] * (theta.cos() - self.pulled_to[0]),
                self.stiffness[1] * (theta.sin() - self.pulled_to[1]),
            ];
            force[0] * n[1] - force[1] * n[0]
        };
        let start = moment(low);
        assert!(start * moment(high) < 0.0, "an equilibrium between");
        while high - low > 1e-15 {
            let middle = 0.5 * (low + high);
            match start * moment(middle) > 0.0 {
                true if middle > low => low = middle,
                false if middle < high => high = middle,
                _ => break,
            }
        }
        low
    }

    fn assert_found(self, solution: &Solution, theta: f64) {
        self.assert_within(solution, theta, 1e-10);
    }

    fn assert_within(self, solution: &Solution, theta: f64, within: f64) {
        assert_eq!(solution.outcome, Outcome::Converged);
        let u = [theta.cos(), theta.sin()];
        assert_near(&solution.state.u, &u, within);
        let (n, _) = self.normal(theta);
        let force = [0, 1].map(|i| self.stiffness[i] * (u[i] - self.pulled_to[i]));
        let lambda = force[0] * n[0] + force[1] * n[1];
        assert!(lambda > 0.0, "the obstacle pushes");
        assert_near(
            &solution.lambda,
            &[lambda],
            100.0 * within * lambda.max(1.0),
        );
    }
}

/// Every error is below a multiple of the square of the one before, down to round-off.
fn assert_quadratic(solution: &Solution, factor: f64) {
    let errors: Vec<f64> = solution.history.iter().map(|i| i.error).collect();
    let small = errors.iter().position(|e| *e < 0.1).expect("convergence");
    let pairs = errors[small..].windows(2);
    for pair in pairs {
        assert!(
            pair[1] < (factor * pair[0] * pair[0]).max(1e-14),
            "{errors:?}"
        );
    }
    assert!(errors.len() - small >= 3, "too short to judge: {errors:?}");
}

const PRESSED: Spring = Spring {
    stiffness: [1.0, 3.0],
    pulled_to: [0.3, 0.4],
    is_ring: false,
    turned: 0.0,
};

/// A start near the equilibrium at a positive first coordinate; there is another one at a negative one.
const NEAR: [f64; 2] = [1.2, 0.6];

#[test]
fn a_point_pressed_on_a_disc() {
    let solution = PRESSED.toy(true).solve_from(&NEAR);
    let theta = PRESSED.angle(0.1, 0.9);
    PRESSED.assert_found(&solution, theta);
    assert_quadratic(&solution, 10.0);
}

#[test]
fn forces_without_a_potential() {
    for turned in [-0.1, 0.05, 0.2] {
        let spring = Spring { turned, ..PRESSED };
        let solution = spring.toy(true).solve_from(&NEAR);
        spring.assert_found(&solution, spring.angle(0.1, 0.9));
        assert_quadratic(&solution, 20.0);
    }
}

/// The ring's curvature times the force is `pull` times the stiffness: the matrix that is factored lacks it.
#[test]
fn a_point_pulled_against_a_ring() {
    for pull in [1.5, 4.0, 30.0] {
        let spring = Spring {
            pulled_to: [0.6 * pull, 0.8 * pull],
            is_ring: true,
            ..PRESSED
        };
        let solution = spring.toy(true).solve_from(&[0.5, 0.1]);
        spring.assert_found(&solution, spring.angle(0.1, 1.5));
    }
}

#[test]
fn without_the_variation_the_same_point_is_found_more_slowly() {
    let slow = PRESSED.toy(false).solve_from(&NEAR);
    // it converges linearly, so that the last change is a part of the error
    PRESSED.assert_within(&slow, PRESSED.angle(0.1, 0.9), 1e-7);
    let fast = PRESSED.toy(true).solve_from(&NEAR);
    assert!(slow.history.len() > fast.history.len());
}

/// The point leaves the obstacle that it starts in.
#[test]
fn a_row_that_lets_go() {
    let spring = Spring {
        pulled_to: [1.2, 0.9],
        ..PRESSED
    };
    let toy = spring.toy(true);
    let start = with_multipliers(&toy, &[0.5, 0.6], &[3.0]);
    let solved = CondensedNewton::default().solve_from(&toy, start);
    let solution = solved.expect("a valid problem");
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &[1.2, 0.9], 1e-12);
    assert_eq!(solution.lambda, [0.0]);
}

/// The spring pushes away from its end along the second axis, so that K is indefinite. The row holds that direction, on a
/// disc, whose curvature counts against it, and in a ring.
#[test]
fn an_indefinite_spring_at_an_obstacle() {
    for (is_ring, end) in [(false, 2.0), (true, -0.5)] {
        let spring = Spring {
            stiffness: [2.0, -1.0],
            pulled_to: [0.05, end],
            is_ring,
            ..PRESSED
        };
        let toy = spring.toy(true);
        let start = with_multipliers(&toy, &[0.1, 1.05], &[1.5]);
        let solved = CondensedNewton::default().solve_from(&toy, start);
        let solution = solved.expect("a valid problem");
        spring.assert_found(&solution, spring.angle(1.3, 1.6));
    }
}

/// Two equilibria on the disc: the nearest point to the spring's end, a minimum, and the farthest, a maximum along the disc.
#[test]
fn an_unstable_equilibrium_is_left() {
    let spring = Spring {
        stiffness: [1.0, 1.0],
        pulled_to: [0.3, 0.0],
        ..PRESSED
    };
    for start in [[-1.2, 0.01], [-1.2, 0.2], [-1.2, 0.5], [-0.5, 1.2]] {
        let solution = spring.toy(true).solve_from(&start);
        assert_eq!(solution.outcome, Outcome::Converged, "from {start:?}");
        assert_near(&solution.state.u, &[1.0, 0.0], 1e-8);
        // along the disc: 1 + λ / r of the spring's stiffness at most
        let curvature = solution.curvature.expect("examined");
        assert!(curvature > 0.0, "{curvature}");
    }
}

/// The curvature along the disc is known: k − λ over k, since the disc's radius is 1.
#[test]
fn curvature_along_a_disc() {
    for pull in [0.9, 0.5, 0.2] {
        let spring = Spring {
            stiffness: [2.0, 2.0],
            pulled_to: [pull, 0.0],
            ..PRESSED
        };
        let solution = spring.toy(true).solve_from(&[1.1, 0.02]);
        assert_near(&solution.lambda, &[2.0 * (1.0 - pull)], 1e-8);
        let curvature = solution.curvature.expect("examined");
        assert!((curvature - pull).abs() < 1e-6, "{curvature} for {pull}");
    }
}

/// Along the disc, the force that leads back grows by t'ᵀK t − λ φ' with the angle, t' at φ and t at θ, whereas the symmetric part of K − D falls
/// along t': it is t'ᵀK t' − λ φ' t·t'. Springs, turned normals and forces are random.
#[test]
fn equilibria_that_the_symmetric_part_alone_calls_unstable_are_kept() {
    let mut random = Rng::with_seed(46);
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let mut kept = 0;
    for _ in 0..20_000 {
        let theta = between(0.6, 0.95);
        let soft = Spring {
            stiffness: [between(0.2, 0.6), 1.6],
            turned: between(0.15, 0.3),
            ..PRESSED
        };
        let ((n, slope), lambda) = (soft.normal(theta), between(1.0, 3.0));
        let u = [theta.cos(), theta.sin()];
        let pulled_to = [0, 1].map(|i| u[i] - lambda * n[i] / soft.stiffness[i]);
        let spring = Spring { pulled_to, ..soft };
        let (along, turned) = ([-u[1], u[0]], [-n[1], n[0]]);
        let rate = slope[1] * n[0] - slope[0] * n[1];
        let product = |a: [f64; 2], b: [f64; 2]| {
            a[0] * spring.stiffness[0] * b[0] + a[1] * spring.stiffness[1] * b[1]
        };
        let cosine = along[0] * turned[0] + along[1] * turned[1];
        let symmetric = product(turned, turned) - lambda * rate * cosine;
        let leads_back = product(turned, along) - lambda * rate;
        if symmetric > -0.02 || leads_back < 0.02 {
            continue;
        }
        kept += 1;
        let toy = spring.toy(true);
        let start = with_multipliers(&toy, &[1.005 * u[0], 1.01 * u[1]], &[0.98 * lambda]);
        let solved = CondensedNewton::default().solve_from(&toy, start);
        let solution = solved.expect("a valid problem");
        // the solver's tolerance
        spring.assert_within(&solution, theta, 1e-8);
        let curvature = solution.curvature.expect("examined");
        let expected = leads_back / product(turned, along);
        assert!(
            (curvature - expected).abs() < 1e-4,
            "{curvature} {expected}"
        );
    }
    assert!(kept > 100, "{kept}");
}

/// The spring pulls through the disc: the start is next to an equilibrium whose curvature is −2.
#[test]
fn a_very_unstable_equilibrium_is_left() {
    let spring = Spring {
        stiffness: [2.0, 2.0],
        pulled_to: [-2.0, 0.0],
        ..PRESSED
    };
    let solution = spring.toy(true).solve_from(&[1.1, 0.02]);
    assert_eq!(solution.outcome, Outcome::Converged);
    // around the disc and away from it
    assert_near(&solution.state.u, &[-2.0, 0.0], 1e-8);
    assert_eq!(solution.lambda, [0.0]);
}

/// A load that turns the sign of K's diagonal, where nothing holds the unknown: the factor of the load before is no longer
/// one, and the straight equilibrium no minimum. E = ½ u₁² − p u₁ + 5 (0.4 − p) u₂² + ¼ u₂⁴.
#[test]
fn a_factor_is_not_kept_across_a_change_of_sign() {
    let toy = |p: f64| {
        let mut toy = Toy::quadratic(&DMatrix::identity(2, 2), &[0.0; 2], &[]);
        let a = 10.0 * (0.4 - p);
        toy.value = Box::new(move |u| {
            0.5 * u[0] * u[0] - p * u[0] + 0.5 * a * u[1] * u[1] + 0.25 * u[1].powi(4)
        });
        toy.gradient = Box::new(move |u| vec![u[0] - p, a * u[1] + u[1].powi(3)]);
        toy.hessian = Box::new(move |u| {
            DMatrix::from_diagonal(&DVector::from_column_slice(&[1.0, a + 3.0 * u[1] * u[1]]))
        });
        toy
    };
    let mut solver = CondensedNewton::default();
    let mut u = vec![0.0, 0.0];
    for p in [0.3996, 0.3998, 0.3999] {
        let solution = toy(p).solve_with(&mut solver, &u);
        assert_eq!(solution.outcome, Outcome::Converged, "{p}");
        u = solution.state.u;
    }
    let solution = toy(0.4001).solve_with(&mut solver, &u);
    let is_straight = solution.state.u[1].abs() < 1e-6;
    assert!(
        solution.outcome != Outcome::Converged || !is_straight,
        "{:?}",
        solution.state.u
    );
}

/// A row without free unknowns that overlaps by less than what counts stands in nobody's way.
#[test]
fn a_row_that_nothing_moves_may_overlap_by_round_off() {
    let rows = [(vec![0.0], -5e-10), (vec![-1.0], 1.0)];
    let toy = Toy::quadratic(&DMatrix::identity(1, 1), &[1e-3], &rows);
    let solution = toy.solve_from(&[0.0]);
    assert_eq!(solution.outcome, Outcome::Converged);
    assert_near(&solution.state.u, &[1e-3], 1e-12);
}
