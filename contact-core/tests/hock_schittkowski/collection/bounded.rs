//! Without constraints: free variables, or bounds only.

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, FREE, INF, POSITIVE, Problem, X},
};

/// Rosenbrock's function.
pub fn rosenbrock(x: X<'_>) -> HyperDual {
    100.0 * (x[2] - x[1].powi(2)).powi(2) + (1.0 - x[1]).powi(2)
}

/// Wood's function, Colville's fourth problem.
fn wood(x: X<'_>) -> HyperDual {
    100.0 * (x[2] - x[1].powi(2)).powi(2)
        + (1.0 - x[1]).powi(2)
        + 90.0 * (x[4] - x[3].powi(2)).powi(2)
        + (1.0 - x[3]).powi(2)
        + 10.1 * ((x[2] - 1.0).powi(2) + (x[4] - 1.0).powi(2))
        + 19.8 * (x[2] - 1.0) * (x[4] - 1.0)
}

/// Holzmann's 99 data points.
fn holzmann(x: X<'_>) -> HyperDual {
    let residual = |i: i32| {
        let t = 0.01 * f64::from(i);
        let u = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
        // The power is xᵏ = exp(k ln x), as its exponent is a variable.
        (-((x[3] * (u - x[2]).ln()).exp() / x[1])).exp() - t
    };
    (1..=99).map(|i| residual(i).powi(2)).sum()
}

fn beale(x: X<'_>) -> HyperDual {
    let residual = |i: i32, c: f64| c - x[1] * (1.0 - x[2].powi(i));
    residual(1, 1.5).powi(2) + residual(2, 2.25).powi(2) + residual(3, 2.625).powi(2)
}

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS001",
        start: &[-2.0, 1.0],
        bounds: &[FREE, (-1.5, INF)],
        f: rosenbrock,
        optimum: 0.0,
        minimisers: &[&[1.0, 1.0]],
        ..DEFAULT
    },
    // There is another local minimum, f = 4.941229 at (−1.221, 1.5).
    Problem {
        name: "HS002",
        start: &[-2.0, 1.0],
        bounds: &[FREE, (1.5, INF)],
        f: rosenbrock,
        optimum: 0.050_426_187_9,
        minimisers: &[&[1.224_370_749, 1.5]],
        ..DEFAULT
    },
    Problem {
        name: "HS003",
        start: &[10.0, 1.0],
        bounds: &[FREE, POSITIVE],
        f: |x| x[2] + 1e-5 * (x[2] - x[1]).powi(2),
        optimum: 0.0,
        minimisers: &[&[0.0, 0.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS004",
        start: &[1.125, 0.125],
        bounds: &[(1.0, INF), POSITIVE],
        f: |x| (x[1] + 1.0).powi(3) / 3.0 + x[2],
        optimum: 8.0 / 3.0,
        minimisers: &[&[1.0, 0.0]],
        ..DEFAULT
    },
    // f* = −√3/2 − π/3 at (½ − π/3, −½ − π/3).
    Problem {
        name: "HS005",
        start: &[0.0, 0.0],
        bounds: &[(-1.5, 4.0), (-3.0, 3.0)],
        f: |x| (x[1] + x[2]).sin() + (x[1] - x[2]).powi(2) - 1.5 * x[1] + 2.5 * x[2] + 1.0,
        optimum: -1.913_222_954_9,
        minimisers: &[&[-0.547_197_551_2, -1.547_197_551_2]],
        ..DEFAULT
    },
    Problem {
        name: "HS025",
        start: &[100.0, 12.5, 3.0],
        bounds: &[(0.1, 100.0), (0.0, 25.6), (0.0, 5.0)],
        f: holzmann,
        optimum: 0.0,
        minimisers: &[&[50.0, 25.0, 1.5]],
        ..DEFAULT
    },
    Problem {
        name: "HS038",
        start: &[-3.0, -1.0, -3.0, -1.0],
        bounds: &[(-10.0, 10.0); 4],
        f: wood,
        optimum: 0.0,
        minimisers: &[&[1.0; 4]],
        ..DEFAULT
    },
    Problem {
        name: "HS045",
        start: &[2.0; 5],
        bounds: &[(0.0, 1.0), (0.0, 2.0), (0.0, 3.0), (0.0, 4.0), (0.0, 5.0)],
        f: |x| 2.0 - x.product() / 120.0,
        optimum: 1.0,
        minimisers: &[&[1.0, 2.0, 3.0, 4.0, 5.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS110",
        start: &[9.0; 10],
        bounds: &[(2.001, 9.999); 10],
        f: |x| {
            let logarithms: HyperDual = x
                .iter()
                .map(|x| (x - 2.0).ln().powi(2) + (10.0 - x).ln().powi(2))
                .sum();
            logarithms - x.product().powf(0.2)
        },
        optimum: -45.778_469_71,
        minimisers: &[&[9.350_265_83; 10]],
        ..DEFAULT
    },
    Problem {
        name: "S201",
        start: &[8.0, 9.0],
        bounds: &[FREE; 2],
        f: |x| 4.0 * (x[1] - 5.0).powi(2) + (x[2] - 6.0).powi(2),
        optimum: 0.0,
        minimisers: &[&[5.0, 6.0]],
        ..DEFAULT
    },
    Problem {
        name: "S203",
        start: &[2.0, 0.2],
        bounds: &[FREE; 2],
        f: beale,
        optimum: 0.0,
        minimisers: &[&[3.0, 0.5]],
        ..DEFAULT
    },
    Problem {
        name: "S208",
        start: &[-1.2, 1.0],
        bounds: &[FREE; 2],
        f: rosenbrock,
        optimum: 0.0,
        minimisers: &[&[1.0, 1.0]],
        ..DEFAULT
    },
    // Powell's function, whose Hessian is singular at the minimum: Newton's method converges linearly.
    Problem {
        name: "S256",
        start: &[3.0, -1.0, 0.0, 1.0],
        bounds: &[FREE; 4],
        f: |x| {
            (x[1] + 10.0 * x[2]).powi(2)
                + 5.0 * (x[3] - x[4]).powi(2)
                + (x[2] - 2.0 * x[3]).powi(4)
                + 10.0 * (x[1] - x[4]).powi(4)
        },
        optimum: 0.0,
        minimisers: &[&[0.0; 4]],
        // As in HS026.
        x_precision: 5e-3,
        ..DEFAULT
    },
];
