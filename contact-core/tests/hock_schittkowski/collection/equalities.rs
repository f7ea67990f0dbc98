//! Three to seven variables, and equalities only; some have bounds too.

use std::f64::consts::SQRT_2;

use crate::problem::{DEFAULT, FREE, POSITIVE, Problem, ZERO};

pub const PROBLEMS: &[Problem] = &[
    // The objective is flat to fourth order along the constraint: x* comes out to (tolerance)^⅓ only.
    Problem {
        name: "HS026",
        start: &[-2.6, 2.0, 2.0],
        bounds: &[FREE; 3],
        f: |x| (x[1] - x[2]).powi(2) + (x[2] - x[3]).powi(4),
        g: |x| vec![(1.0 + x[2].powi(2)) * x[1] + x[3].powi(4) - 3.0],
        g_bounds: &[ZERO],
        optimum: 0.0,
        minimisers: &[&[1.0; 3]],
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
            &[0.793_700_526, 0.707_106_781, 0.529_731_547, 0.840_896_415],
            &[0.793_700_526, 0.707_106_781, -0.529_731_547, -0.840_896_415],
        ],
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
    // Flat to fourth and sixth order.
    Problem {
        name: "HS046",
        start: &[0.5 * SQRT_2, 1.75, 0.5, 2.0, 2.0],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - x[2]).powi(2)
                + (x[3] - 1.0).powi(2)
                + (x[4] - 1.0).powi(4)
                + (x[5] - 1.0).powi(6)
        },
        g: |x| {
            vec![
                x[1].powi(2) * x[4] + (x[4] - x[5]).sin() - 1.0,
                x[2] + x[3].powi(4) * x[4].powi(2) - 2.0,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
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
    // Flat to fourth and sixth order.
    Problem {
        name: "HS049",
        start: &[10.0, 7.0, 2.0, -3.0, 0.8],
        bounds: &[FREE; 5],
        f: |x| {
            (x[1] - x[2]).powi(2)
                + (x[3] - 1.0).powi(2)
                + (x[4] - 1.0).powi(4)
                + (x[5] - 1.0).powi(6)
        },
        g: |x| {
            vec![
                x[1] + x[2] + x[3] + 4.0 * x[4] - 7.0,
                x[3] + 5.0 * x[5] - 6.0,
            ]
        },
        g_bounds: &[ZERO; 2],
        optimum: 0.0,
        minimisers: &[&[1.0; 5]],
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
        g: |x| {
            vec![
                x.squares() - 10.0,
                x[2] * x[3] - 5.0 * x[4] * x[5],
                x[1].powi(3) + x[2].powi(3) + 1.0,
            ]
        },
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
        g: |x| {
            vec![
                x.squares() - 10.0,
                x[2] * x[3] - 5.0 * x[4] * x[5],
                x[1].powi(3) + x[2].powi(3) + 1.0,
            ]
        },
        g_bounds: &[ZERO; 3],
        optimum: 0.053_949_847_8,
        minimisers: &[&[-1.717_143, 1.595_709, 1.827_247, -0.763_641_3, -0.763_645_0]],
        ..DEFAULT
    },
];
