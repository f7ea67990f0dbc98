//! Slacks and violations of every iterate, against the same quantities worked out from x and the multipliers.
#![cfg(feature = "ipopt")]

use std::ops::ControlFlow;

use contact_core::{
    ipopt::{Options, Scaling, Solver, Start, Status},
    nlp::{Bounds, Iterate, Nlp, Pattern, Phase, Structure},
};

use problems::*;

/// The gradient of the Lagrangian from the problem's own functions.
fn lagrangian(
    nlp: &mut dyn Nlp,
    structure: &Structure,
    x: &[f64],
    iterate: &Iterate<'_>,
) -> Vec<f64> {
    let multipliers = iterate.multipliers().expect("regular");
    let mut sum = vec![0.0; x.len()];
    nlp.gradient(x, true, &mut sum);
    let mut values = vec![0.0; structure.jacobian().len()];
    if !values.is_empty() {
        nlp.jacobian(x, true, &mut values);
    }
    for ((row, col), value) in structure.jacobian().iter().zip(values) {
        sum[col] += value * multipliers.constraints[row];
    }
    for (i, value) in sum.iter_mut().enumerate() {
        *value += multipliers.upper[i] - multipliers.lower[i];
    }
    sum
}

/// Everything but the gradient of the Lagrangian, for one pair of bounds: distances (of what is kept inside), then
/// violations (of the value).
fn distances(bounds: &Bounds, inside: &[f64], values: &[f64]) -> [Vec<f64>; 4] {
    let each = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(of).collect::<Vec<_>>();
    [
        each(&|i| inside[i] - bounds.lower[i]),
        each(&|i| bounds.upper[i] - inside[i]),
        each(&|i| f64::max(bounds.lower[i] - values[i], 0.0)),
        each(&|i| f64::max(values[i] - bounds.upper[i], 0.0)),
    ]
}

/// Equal, or the same infinity.
#[track_caller]
fn assert_same(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        let same = a == b || (a - b).abs() <= tolerance * b.abs().max(1.0);
        assert!(same, "[{i}]: {a} is not {b} to {tolerance:e}");
    }
}

/// A multiplier times a distance, 0 for no bound.
fn times(multipliers: &[f64], distances: &[f64]) -> Vec<f64> {
    let pairs = multipliers.iter().zip(distances);
    pairs
        .map(|(z, d)| if d.is_infinite() { 0.0 } else { z * d })
        .collect()
}

/// Checks one iterate; whether it was a regular one.
fn examine(
    nlp: &mut dyn Nlp,
    structure: &Structure,
    iterate: &Iterate<'_>,
    unscaled: bool,
    sign: f64,
) -> bool {
    if iterate.record().phase == Phase::Restoration {
        assert!(iterate.slacks().is_none() && iterate.violations().is_none());
        return false;
    }
    let (x, g) = (iterate.x().unwrap(), iterate.constraints().unwrap());
    let multipliers = iterate.multipliers().expect("regular");
    let (slacks, violations) = (iterate.slacks().unwrap(), iterate.violations().unwrap());
    let (bounds, limits) = (structure.variable_bounds(), structure.constraint_bounds());
    let tight = 1e-12;

    let [below, above, too_low, too_high] = distances(bounds, x, x);
    assert_same(&slacks.lower, &below, tight);
    assert_same(&slacks.upper, &above, tight);
    assert_same(&violations.lower, &too_low, tight);
    assert_same(&violations.upper, &too_high, tight);
    assert_same(
        &violations.complementarity_lower,
        &times(&multipliers.lower, &below),
        1e-10,
    );
    assert_same(
        &violations.complementarity_upper,
        &times(&multipliers.upper, &above),
        1e-10,
    );

    let s = &slacks.constraints;
    let [below, above, ..] = distances(limits, s, s);
    assert_same(&slacks.constraint_lower, &below, tight);
    assert_same(&slacks.constraint_upper, &above, tight);
    let [below, above, too_low, too_high] = distances(limits, g, g);
    let worst: Vec<f64> = too_low
        .iter()
        .zip(&too_high)
        .map(|(a, b)| a.max(*b))
        .collect();
    assert_same(&violations.constraints, &worst, tight);
    let mut residual: f64 = 0.0;
    for (i, &lambda) in multipliers.constraints.iter().enumerate() {
        residual = residual.max((g[i] - s[i]).abs());
        let expected = match limits.lower[i] == limits.upper[i] {
            true => {
                assert_eq!(s[i], limits.lower[i]);
                -(g[i] - s[i]) * lambda
            }
            false if lambda * sign < 0.0 => times(&[-lambda], &below[i..=i])[0],
            false => times(&[lambda], &above[i..=i])[0],
        };
        assert_same(
            &[violations.complementarity_constraints[i]],
            &[expected],
            1e-10,
        );
        if limits.lower[i] != limits.upper[i] {
            assert!(
                limits.lower[i] < s[i] && s[i] < limits.upper[i],
                "s is inside"
            );
        }
    }

    let mut expected = lagrangian(nlp, structure, x, iterate);
    for (i, value) in expected.iter_mut().enumerate() {
        if bounds.lower[i] == bounds.upper[i] {
            *value = 0.0;
        }
    }
    assert_same(&violations.lagrangian, &expected, 1e-9);
    // What Ipopt itself says of the scaled problem.
    if unscaled {
        let record = iterate.record();
        assert_same(&[residual], &[record.primal_infeasibility], 1e-10);
        let norm = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        assert!(norm <= record.dual_infeasibility * (1.0 + 1e-9) + 1e-12);
    }
    true
}

fn solve<N: Nlp>(
    structure: &Structure,
    nlp: fn() -> N,
    start: &[f64],
    options: &Options,
    scaling: Option<&Scaling>,
) -> (Status, usize) {
    let mut solver = Solver::new(structure.clone(), options).unwrap();
    if let Some(scaling) = scaling {
        solver.set_scaling(scaling).unwrap();
    }
    let unscaled = options.get("nlp_scaling_method") == Some(&"none".into());
    let sign = scaling.map_or(1.0, |scaling| scaling.objective.signum());
    let mut regular = 0;
    let solution = solver.solve_with(&mut nlp(), &Start::at(start), |iterate| {
        regular += usize::from(examine(&mut nlp(), structure, iterate, unscaled, sign));
        ControlFlow::Continue(())
    });
    (solution.unwrap().status, regular)
}

fn unscaled() -> Options {
    Options::new().with("nlp_scaling_method", "none")
}

fn by_gradients() -> Options {
    // A factor of a tenth at most.
    Options::new().with("nlp_scaling_max_gradient", 1.0)
}

fn factors() -> Scaling {
    Scaling {
        objective: 0.25,
        variables: Some(vec![2.0, 0.5, 3.0, 1.0]),
        constraints: Some(vec![0.125, 5.0]),
    }
}

#[test]
fn hs071_with_each_scaling() {
    let structure = hs071_structure();
    for (options, scaling) in [
        (unscaled(), None),
        (by_gradients(), None),
        (Options::new(), Some(&factors())),
    ] {
        let (status, iterates) = solve(&structure, || Hs071, &HS071_START, &options, scaling);
        assert_eq!(status, Status::Solved);
        assert!(iterates > 5, "{iterates}");
    }
}

#[test]
fn a_fixed_variable_and_an_inequality_with_two_sides() {
    let mut structure = hs071_structure();
    let mut bounds = structure.variable_bounds().clone();
    (bounds.lower[1], bounds.upper[1]) = (HS071_X[1], HS071_X[1]);
    bounds.lower[2] = f64::NEG_INFINITY;
    let limits = Bounds {
        lower: vec![25.0, 40.0],
        upper: vec![60.0, 40.0],
    };
    structure.set_bounds(bounds, limits).unwrap();
    for (options, scaling) in [
        (unscaled(), None),
        (by_gradients(), None),
        (Options::new(), Some(&factors())),
    ] {
        let (status, iterates) = solve(&structure, || Hs071, &HS071_START, &options, scaling);
        assert_eq!(status, Status::Solved);
        assert!(iterates > 4, "{iterates}");
    }
}

/// min (x₀ − 3)² + x₁² subject to x₀ + x₁ ≤ 1, x₀ − x₁ free of bounds, x₁ ≥ 0.
struct Corner;

impl Corner {
    fn structure() -> Structure {
        Structure::new(
            Bounds {
                lower: vec![f64::NEG_INFINITY, 0.0],
                upper: vec![f64::INFINITY; 2],
            },
            Bounds {
                lower: vec![f64::NEG_INFINITY; 2],
                upper: vec![f64::INFINITY, 1.0],
            },
            Pattern::dense(2, 2),
            Some(Pattern::diagonal(2)),
        )
        .expect("well formed")
    }
}

impl Nlp for Corner {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (x[0] - 3.0).powi(2) + x[1] * x[1]
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        gradient.copy_from_slice(&[2.0 * (x[0] - 3.0), 2.0 * x[1]]);
    }
    fn constraints(&mut self, x: &[f64], _: bool, g: &mut [f64]) {
        g.copy_from_slice(&[x[0] - x[1], x[0] + x[1]]);
    }
    fn jacobian(&mut self, _: &[f64], _: bool, values: &mut [f64]) {
        values.copy_from_slice(&[1.0, -1.0, 1.0, 1.0]);
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values.fill(2.0 * sigma);
    }
}

#[test]
fn a_constraint_without_bounds_and_variables_without_one() {
    let structure = Corner::structure();
    for options in [unscaled(), by_gradients()] {
        let (status, _) = solve(&structure, || Corner, &[5.0, 5.0], &options, None);
        assert_eq!(status, Status::Solved);
    }
}

#[test]
fn bounds_alone_and_all_but_one_fixed() {
    let bounds = Bounds {
        lower: vec![0.0, 0.0, 2.0, f64::NEG_INFINITY],
        upper: vec![1.0, 1.0, 2.0, -1.0],
    };
    let structure = Separable::structure(bounds);
    let nlp = || Separable::new(&[-2.0, 0.25, 7.0, 1.0]);
    let (status, _) = solve(&structure, nlp, &[0.5; 4], &unscaled(), None);
    assert_eq!(status, Status::Solved);
}

#[test]
fn none_in_restoration() {
    let structure = WaechterBiegler::structure();
    let start = [-1.0, 3.0, 1.0, 7.0];
    let (status, _) = solve(&structure, || WaechterBiegler, &start, &unscaled(), None);
    assert_eq!(status, Status::Solved);
}

/// A fixed variable that has an equality instead of bounds: its multiplier is in the gradient of the Lagrangian.
#[test]
fn a_fixed_variable_with_an_equality() {
    let mut structure = hs071_structure();
    let mut bounds = structure.variable_bounds().clone();
    (bounds.lower[1], bounds.upper[1]) = (4.5, 4.5);
    let limits = structure.constraint_bounds().clone();
    structure.set_bounds(bounds, limits).unwrap();
    let options = Options::new().with("fixed_variable_treatment", "make_constraint");
    let mut solver = Solver::new(structure, &options).unwrap();
    let mut last = None;
    let solution = solver
        .solve_with(&mut Hs071, &Start::at(&HS071_START), |iterate| {
            let slacks = iterate.slacks().unwrap();
            assert_eq!(
                (slacks.lower[1], slacks.upper[1]),
                (f64::INFINITY, f64::INFINITY)
            );
            last = iterate.violations().cloned();
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(solution.status, Status::Solved);
    let last = last.expect("an iterate");
    assert_close(&last.lagrangian, &[0.0; 4], 1e-6);
    assert_close(&last.constraints, &[0.0; 2], 1e-6);
}

/// max f, as min with a negative factor, which reverses all multipliers.
#[test]
fn a_maximum() {
    let structure = hs071_structure();
    let maximise = Scaling {
        objective: -0.5,
        variables: None,
        constraints: None,
    };
    let options = Options::new().max_iter(40);
    let (_, iterates) = solve(
        &structure,
        || Hs071,
        &HS071_START,
        &options,
        Some(&maximise),
    );
    assert!(iterates > 4, "{iterates}");
}
