//! Three to five variables and nonlinear equalities, with bounds or without.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, FREE, POSITIVE, Problem, X, ZERO},
};

use super::linear_equalities::flat;

/// The equations of HS078 and HS080.
fn sphere_and_two(x: X<'_>) -> Vec<HyperDual> {
    vec![
        x.squares() - 10.0,
        x[2] * x[3] - 5.0 * x[4] * x[5],
        x[1].powi(3) + x[2].powi(3) + 1.0,
    ]
}

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS026",
        start: &[-2.6, 2.0, 2.0],
        bounds: &[FREE; 3],
        f: |x| (x[1] - x[2]).powi(2) + (x[2] - x[3]).powi(4),
        g: |x| vec![(1.0 + x[2].powi(2)) * x[1] + x[3].powi(4) - 3.0],
        g_bounds: &[ZERO],
        optimum: 0.0,
        minimisers: &[&[1.0; 3]],
        // Flat to fourth order: the gradient is below a tolerance τ already within ∛τ of x*.
        x_precision: 5e-3,
        ..DEFAULT
    },
    Problem {
        name: "HS027",
        start: &[2.0; 3],
        bounds: &[FREE; 3],
        f: |x| 0.01 * (x[1] - 1.0).powi(2) + (x[2] - x[1].powi(2)).powi(2),
        g: |x| vec![x[1] + x[3].powi(2) + 1.0],
        g_bounds: &[ZERO],
        optimum: 0.04,
        minimisers: &[&[-1.0, 1.0, 0.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS039",
        start: &[2.0; 4],
        bounds: &[FREE; 4],
        f: |x| -x[1],
        g: |x| {
            vec![
                x[2] - x[1].powi(3) - x[3].powi(2),
                x[1].powi(2) - x[2] - x[4].powi(2),
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: -1.0,
        minimisers: &[&[1.0, 1.0, 0.0, 0.0]],
        ..DEFAULT
    },
    // x* = (2^−⅓, 2^−½, ±2^−11/12, ±2^−¼), both signs the same.
    Problem {
        name: "HS040",
        start: &[0.8; 4],
        bounds: &[FREE; 4],
        f: |x| -x.product(),
        g: |x| {
            vec![
                x[1].powi(3) + x[2].powi(2) - 1.0,
                x[1].powi(2) * x[4] - x[3],
                x[4].powi(2) - x[2],
            ]
        },
        g_bounds: &[ZERO; 3],
        optimum: -0.25,
        minimisers: &[
            &[0.793_700_526, FRAC_1_SQRT_2, 0.529_731_547, 0.840_896_415],
            &[0.793_700_526, FRAC_1_SQRT_2, -0.529_731_547, -0.840_896_415],
        ],
        ..DEFAULT
    },
    // f* = 28 − 10 √2.
    Problem {
        name: "HS042",
        start: &[1.0; 4],
        bounds: &[FREE; 4],
        f: |x| (1..=4).map(|i| (x[i] - i as f64).powi(2)).sum(),
        g: |x| vec![x[1] - 2.0, x[3].powi(2) + x[4].powi(2) - 2.0],
        g_bounds: &[ZERO; 2],
        optimum: 13.857_864_4,
        minimisers: &[&[2.0, 2.0, 0.6 * SQRT_2, 0.8 * SQRT_2]],
        ..DEFAULT
    },
    Problem {
        name: "HS046",
        start: &[0.5 * SQRT_2, 1.75, 0.5, 2.0, 2.0],
        bounds: &[FREE; 5],
        f: flat,
        g: |x| {
            vec![
                x[1].powi(2) * x[4] + (x[4] - x[5]).sin() - 1.0,
                x[2] + x[3].powi(4) * x[4].powi(2) - 2.0,
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
        name: "HS060",
        start: &[2.0; 3],
        bounds: &[(-10.0, 10.0); 3],
        f: |x| (x[1] - 1.0).powi(2) + (x[1] - x[2]).powi(2) + (x[2] - x[3]).powi(4),
        g: |x| vec![x[1] * (1.0 + x[2].powi(2)) + x[3].powi(4) - 4.0 - 3.0 * SQRT_2],
        g_bounds: &[ZERO],
        optimum: 0.032_568_200_25,
        minimisers: &[&[1.104_859_024, 1.196_674_194, 1.535_262_257]],
        ..DEFAULT
    },
    Problem {
        name: "HS061",
        start: &[0.0; 3],
        bounds: &[FREE; 3],
        f: |x| {
            4.0 * x[1].powi(2) + 2.0 * x[2].powi(2) + 2.0 * x[3].powi(2) - 33.0 * x[1] + 16.0 * x[2]
                - 24.0 * x[3]
        },
        g: |x| {
            vec![
                3.0 * x[1] - 2.0 * x[2].powi(2) - 7.0,
                4.0 * x[1] - x[3].powi(2) - 11.0,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: -143.646_142_2,
        minimisers: &[&[5.326_770_16, -2.118_998_64, 3.210_464_24]],
        ..DEFAULT
    },
    Problem {
        name: "HS063",
        start: &[2.0; 3],
        bounds: &[POSITIVE; 3],
        f: |x| {
            1000.0 - x[1].powi(2) - 2.0 * x[2].powi(2) - x[3].powi(2) - x[1] * x[2] - x[1] * x[3]
        },
        g: |x| {
            vec![
                8.0 * x[1] + 14.0 * x[2] + 7.0 * x[3] - 56.0,
                x[1].powi(2) + x[2].powi(2) + x[3].powi(2) - 25.0,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: 961.715_172_1,
        minimisers: &[&[3.512_118_414, 0.216_988_174_1, 3.552_174_034]],
        ..DEFAULT
    },
    Problem {
        name: "HS077",
        start: &[2.0; 5],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - 1.0).powi(2)
                + (x[1] - x[2]).powi(2)
                + (x[3] - 1.0).powi(2)
                + (x[4] - 1.0).powi(4)
                + (x[5] - 1.0).powi(6)
        },
        g: |x| {
            vec![
                x[1].powi(2) * x[4] + (x[4] - x[5]).sin() - 2.0 * SQRT_2,
                x[2] + x[3].powi(4) * x[4].powi(2) - 8.0 - SQRT_2,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: 0.241_505_13,
        minimisers: &[&[1.166_172, 1.182_111, 1.380_257, 1.506_036, 0.610_920_3]],
        ..DEFAULT
    },
    Problem {
        name: "HS078",
        start: &[-2.0, 1.5, 2.0, -1.0, -1.0],
        bounds: &[FREE; 5],
        f: |x| x.product(),
        g: sphere_and_two,
        g_bounds: &[ZERO; 3],
        optimum: -2.919_700_41,
        minimisers: &[&[-1.717_142, 1.595_708, 1.827_248, -0.763_642_9, -0.763_643_5]],
        ..DEFAULT
    },
    Problem {
        name: "HS079",
        start: &[2.0; 5],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - 1.0).powi(2)
                + (x[1] - x[2]).powi(2)
                + (x[2] - x[3]).powi(2)
                + (x[3] - x[4]).powi(4)
                + (x[4] - x[5]).powi(4)
        },
        g: |x| {
            vec![
                x[1] + x[2].powi(2) + x[3].powi(3) - 2.0 - 3.0 * SQRT_2,
                x[2] - x[3].powi(2) + x[4] + 2.0 - 2.0 * SQRT_2,
                x[1] * x[5] - 2.0,
            ]
        },
        g_bounds: &[ZERO; 3],
        optimum: 0.078_776_820_9,
        minimisers: &[&[1.191_127, 1.362_603, 1.472_818, 1.635_017, 1.679_081]],
        ..DEFAULT
    },
    Problem {
        name: "HS080",
        start: &[-2.0, 2.0, 2.0, -1.0, -1.0],
        bounds: &[
            (-2.3, 2.3),
            (-2.3, 2.3),
            (-3.2, 3.2),
            (-3.2, 3.2),
            (-3.2, 3.2),
        ],
        f: |x| x.product().exp(),
        g: sphere_and_two,
        g_bounds: &[ZERO; 3],
        optimum: 0.053_949_847_8,
        minimisers: &[&[-1.717_143, 1.595_709, 1.827_247, -0.763_641_3, -0.763_645_0]],
        ..DEFAULT
    },
];
