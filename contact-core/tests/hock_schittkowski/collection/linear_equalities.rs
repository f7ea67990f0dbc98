//! Three to six variables and linear equalities, with bounds or without.

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, FREE, POSITIVE, Problem, X, ZERO},
};

/// Flat to fourth order in x₄ − 1 and to sixth in x₅ − 1.
pub fn flat(x: X<'_>) -> HyperDual {
    (x[1] - x[2]).powi(2) + (x[3] - 1.0).powi(2) + (x[4] - 1.0).powi(4) + (x[5] - 1.0).powi(6)
}

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS028",
        start: &[-4.0, 1.0, 1.0],
        bounds: &[FREE; 3],
        f: |x| (x[1] + x[2]).powi(2) + (x[2] + x[3]).powi(2),
        g: |x| vec![x[1] + 2.0 * x[2] + 3.0 * x[3] - 1.0],
        g_bounds: &[ZERO],
        optimum: 0.0,
        minimisers: &[&[0.5, -0.5, 0.5]],
        ..DEFAULT
    },
    // f* = 52/27.
    Problem {
        name: "HS041",
        start: &[2.0; 4],
        bounds: &[(0.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 2.0)],
        f: |x| 2.0 - x[1] * x[2] * x[3],
        g: |x| vec![x[1] + 2.0 * x[2] + 2.0 * x[3] - x[4]],
        g_bounds: &[ZERO],
        optimum: 52.0 / 27.0,
        minimisers: &[&[2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 2.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS048",
        start: &[3.0, 5.0, -3.0, 2.0, -2.0],
        bounds: &[FREE; 5],
        f: |x| (x[1] - 1.0).powi(2) + (x[2] - x[3]).powi(2) + (x[4] - x[5]).powi(2),
        g: |x| vec![x.sum() - 5.0, x[3] - 2.0 * (x[4] + x[5]) + 3.0],
        g_bounds: &[ZERO; 2],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
        ..DEFAULT
    },
    Problem {
        name: "HS049",
        start: &[10.0, 7.0, 2.0, -3.0, 0.8],
        bounds: &[FREE; 5],
        f: flat,
        g: |x| {
            vec![
                x[1] + x[2] + x[3] + 4.0 * x[4] - 7.0,
                x[3] + 5.0 * x[5] - 6.0,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
        // Flat to sixth order: the gradient is below a tolerance τ already within the fifth root of τ of x*.
        x_precision: 5e-2,
        ..DEFAULT
    },
    Problem {
        name: "HS050",
        start: &[35.0, -31.0, 11.0, 5.0, -5.0],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - x[2]).powi(2)
                + (x[2] - x[3]).powi(2)
                + (x[3] - x[4]).powi(4)
                + (x[4] - x[5]).powi(2)
        },
        g: |x| {
            let row = |i| x[i] + 2.0 * x[i + 1] + 3.0 * x[i + 2] - 6.0;
            (1..=3).map(row).collect()
        },
        g_bounds: &[ZERO; 3],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
        ..DEFAULT
    },
    Problem {
        name: "HS051",
        start: &[2.5, 0.5, 2.0, -1.0, 0.5],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - x[2]).powi(2)
                + (x[2] + x[3] - 2.0).powi(2)
                + (x[4] - 1.0).powi(2)
                + (x[5] - 1.0).powi(2)
        },
        g: |x| {
            vec![
                x[1] + 3.0 * x[2] - 4.0,
                x[3] + x[4] - 2.0 * x[5],
                x[2] - x[5],
            ]
        },
        g_bounds: &[ZERO; 3],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
        ..DEFAULT
    },
    // f* = 1859/349.
    Problem {
        name: "HS052",
        start: &[2.0; 5],
        bounds: &[FREE; 5],
        f: |x| {
            (4.0 * x[1] - x[2]).powi(2)
                + (x[2] + x[3] - 2.0).powi(2)
                + (x[4] - 1.0).powi(2)
                + (x[5] - 1.0).powi(2)
        },
        g: |x| vec![x[1] + 3.0 * x[2], x[3] + x[4] - 2.0 * x[5], x[2] - x[5]],
        g_bounds: &[ZERO; 3],
        optimum: 5.326_647_564,
        minimisers: &[&[
            -33.0 / 349.0,
            11.0 / 349.0,
            180.0 / 349.0,
            -158.0 / 349.0,
            11.0 / 349.0,
        ]],
        ..DEFAULT
    },
    Problem {
        name: "HS053",
        start: &[2.0; 5],
        bounds: &[(-10.0, 10.0); 5],
        f: |x| {
            (x[1] - x[2]).powi(2)
                + (x[2] + x[3] - 2.0).powi(2)
                + (x[4] - 1.0).powi(2)
                + (x[5] - 1.0).powi(2)
        },
        g: |x| vec![x[1] + 3.0 * x[2], x[3] + x[4] - 2.0 * x[5], x[2] - x[5]],
        g_bounds: &[ZERO; 3],
        optimum: 4.093_023_256,
        minimisers: &[&[
            -33.0 / 43.0,
            11.0 / 43.0,
            27.0 / 43.0,
            -5.0 / 43.0,
            11.0 / 43.0,
        ]],
        ..DEFAULT
    },
    // Six equations, of which five are independent: the second and third add up to what the last three do.
    Problem {
        name: "HS055",
        start: &[1.0, 2.0, 0.0, 0.0, 0.0, 2.0],
        bounds: &[
            (0.0, 1.0),
            POSITIVE,
            POSITIVE,
            (0.0, 1.0),
            POSITIVE,
            POSITIVE,
        ],
        f: |x| x[1] + 2.0 * x[2] + 4.0 * x[5] + (x[1] * x[4]).exp(),
        g: |x| {
            vec![
                x[1] + 2.0 * x[2] + 5.0 * x[5] - 6.0,
                x[1] + x[2] + x[3] - 3.0,
                x[4] + x[5] + x[6] - 2.0,
                x[1] + x[4] - 1.0,
                x[2] + x[5] - 2.0,
                x[3] + x[6] - 2.0,
            ]
        },
        g_bounds: &[ZERO; 6],
        optimum: 19.0 / 3.0,
        minimisers: &[&[0.0, 4.0 / 3.0, 5.0 / 3.0, 1.0, 2.0 / 3.0, 1.0 / 3.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS062",
        start: &[0.7, 0.2, 0.1],
        bounds: &[(0.0, 1.0); 3],
        f: |x| {
            let b1 = x[1] + x[2] + x[3] + 0.03;
            let c1 = 0.09 * x[1] + x[2] + x[3] + 0.03;
            let b2 = x[2] + x[3] + 0.03;
            let c2 = 0.07 * x[2] + x[3] + 0.03;
            let b3 = x[3] + 0.03;
            let c3 = 0.13 * x[3] + 0.03;
            -32.174 * (255.0 * (b1 / c1).ln() + 280.0 * (b2 / c2).ln() + 290.0 * (b3 / c3).ln())
        },
        g: |x| vec![x.sum() - 1.0],
        g_bounds: &[ZERO],
        optimum: -26_272.514_48,
        minimisers: &[&[0.617_812_690_8, 0.328_202_155, 0.053_985_155_06]],
        ..DEFAULT
    },
];
