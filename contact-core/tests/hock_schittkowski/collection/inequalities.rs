//! Three to five variables, and inequalities only; most have bounds too.

use std::f64::consts::{LN_10, SQRT_2};

use crate::problem::{DEFAULT, FREE, INF, POSITIVE, Problem};

pub const PROBLEMS: &[Problem] = &[
    // f* = −16 √2 at (a, b, c), (a, −b, −c), (−a, b, −c), (−a, −b, c) with (a, b, c) = (4, 2 √2, 2).
    Problem {
        name: "HS029",
        start: &[1.0; 3],
        bounds: &[FREE; 3],
        f: |x| -x.product(),
        g: |x| vec![48.0 - x[1].powi(2) - 2.0 * x[2].powi(2) - 4.0 * x[3].powi(2)],
        g_bounds: &[POSITIVE],
        optimum: -22.627_417,
        minimisers: &[
            &[4.0, 2.828_427_125, 2.0],
            &[4.0, -2.828_427_125, -2.0],
            &[-4.0, 2.828_427_125, -2.0],
            &[-4.0, -2.828_427_125, 2.0],
        ],
        ..DEFAULT
    },
    Problem {
        name: "HS030",
        start: &[1.0; 3],
        bounds: &[(1.0, 10.0), (-10.0, 10.0), (-10.0, 10.0)],
        f: |x| x[1].powi(2) + x[2].powi(2) + x[3].powi(2),
        g: |x| vec![x[1].powi(2) + x[2].powi(2) - 1.0],
        g_bounds: &[POSITIVE],
        optimum: 1.0,
        minimisers: &[&[1.0, 0.0, 0.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS031",
        start: &[1.0; 3],
        bounds: &[(-10.0, 10.0), (1.0, 10.0), (-10.0, 1.0)],
        f: |x| 9.0 * x[1].powi(2) + x[2].powi(2) + 9.0 * x[3].powi(2),
        g: |x| vec![x[1] * x[2] - 1.0],
        g_bounds: &[POSITIVE],
        optimum: 6.0,
        minimisers: &[&[0.577_350_269, 1.732_050_808, 0.0]],
        ..DEFAULT
    },
    // f* = √2 − 6 at (0, √2, √2).
    Problem {
        name: "HS033",
        start: &[0.0, 0.0, 3.0],
        bounds: &[POSITIVE, POSITIVE, (0.0, 5.0)],
        f: |x| (x[1] - 1.0) * (x[1] - 2.0) * (x[1] - 3.0) + x[3],
        g: |x| {
            vec![
                x[3].powi(2) - x[2].powi(2) - x[1].powi(2),
                x[1].powi(2) + x[2].powi(2) + x[3].powi(2) - 4.0,
            ]
        },
        g_bounds: &[POSITIVE; 2],
        optimum: -4.585_786_438,
        minimisers: &[&[0.0, SQRT_2, SQRT_2]],
        ..DEFAULT
    },
    // x* = (ln ln 10, ln 10, 10).
    Problem {
        name: "HS034",
        start: &[0.0, 1.05, 2.9],
        bounds: &[(0.0, 100.0), (0.0, 100.0), (0.0, 10.0)],
        f: |x| -x[1],
        g: |x| vec![x[2] - x[1].exp(), x[3] - x[2].exp()],
        g_bounds: &[POSITIVE; 2],
        optimum: -0.834_032_445_2,
        minimisers: &[&[0.834_032_445_2, LN_10, 10.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS035",
        start: &[0.5; 3],
        bounds: &[POSITIVE; 3],
        f: |x| {
            9.0 - 8.0 * x[1] - 6.0 * x[2] - 4.0 * x[3]
                + 2.0 * x[1].powi(2)
                + 2.0 * x[2].powi(2)
                + x[3].powi(2)
                + 2.0 * x[1] * x[2]
                + 2.0 * x[1] * x[3]
        },
        g: |x| vec![3.0 - x[1] - x[2] - 2.0 * x[3]],
        g_bounds: &[POSITIVE],
        optimum: 1.0 / 9.0,
        minimisers: &[&[4.0 / 3.0, 7.0 / 9.0, 4.0 / 9.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS036",
        start: &[10.0; 3],
        bounds: &[(0.0, 20.0), (0.0, 11.0), (0.0, 42.0)],
        f: |x| -x.product(),
        g: |x| vec![72.0 - x[1] - 2.0 * x[2] - 2.0 * x[3]],
        g_bounds: &[POSITIVE],
        optimum: -3300.0,
        minimisers: &[&[20.0, 11.0, 15.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS037",
        start: &[10.0; 3],
        bounds: &[(0.0, 42.0); 3],
        f: |x| -x.product(),
        g: |x| vec![x[1] + 2.0 * x[2] + 2.0 * x[3]],
        g_bounds: &[(0.0, 72.0)],
        optimum: -3456.0,
        minimisers: &[&[24.0, 12.0, 12.0]],
        ..DEFAULT
    },
    // Rosen and Suzuki.
    Problem {
        name: "HS043",
        start: &[0.0; 4],
        bounds: &[FREE; 4],
        f: |x| {
            x[1].powi(2) + x[2].powi(2) + 2.0 * x[3].powi(2) + x[4].powi(2)
                - 5.0 * x[1]
                - 5.0 * x[2]
                - 21.0 * x[3]
                + 7.0 * x[4]
        },
        g: |x| {
            let s = [x[1].powi(2), x[2].powi(2), x[3].powi(2), x[4].powi(2)];
            vec![
                8.0 - s[0] - s[1] - s[2] - s[3] - x[1] + x[2] - x[3] + x[4],
                10.0 - s[0] - 2.0 * s[1] - s[2] - 2.0 * s[3] + x[1] + x[4],
                5.0 - 2.0 * s[0] - s[1] - s[2] - 2.0 * x[1] + x[2] + x[4],
            ]
        },
        g_bounds: &[POSITIVE; 3],
        optimum: -44.0,
        minimisers: &[&[0.0, 1.0, 2.0, -1.0]],
        ..DEFAULT
    },
    // Not convex, with local minima at several vertices, among them f = −13.
    Problem {
        name: "HS044",
        start: &[0.0; 4],
        bounds: &[POSITIVE; 4],
        f: |x| x[1] - x[2] - x[3] - x[1] * x[3] + x[1] * x[4] + x[2] * x[3] - x[2] * x[4],
        g: |x| {
            vec![
                8.0 - x[1] - 2.0 * x[2],
                12.0 - 4.0 * x[1] - x[2],
                12.0 - 3.0 * x[1] - 4.0 * x[2],
                8.0 - 2.0 * x[3] - x[4],
                8.0 - x[3] - 2.0 * x[4],
                5.0 - x[3] - x[4],
            ]
        },
        g_bounds: &[POSITIVE; 6],
        optimum: -15.0,
        minimisers: &[&[0.0, 3.0, 0.0, 4.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS064",
        start: &[1.0; 3],
        bounds: &[(1e-5, INF); 3],
        f: |x| 5.0 * x[1] + 5e4 / x[1] + 20.0 * x[2] + 7.2e4 / x[2] + 10.0 * x[3] + 1.44e5 / x[3],
        g: |x| vec![1.0 - 4.0 / x[1] - 32.0 / x[2] - 120.0 / x[3]],
        g_bounds: &[POSITIVE],
        optimum: 6_299.842_428,
        minimisers: &[&[108.734_717_5, 85.126_139_42, 204.324_707_8]],
        ..DEFAULT
    },
    Problem {
        name: "HS065",
        start: &[-5.0, 5.0, 0.0],
        bounds: &[(-4.5, 4.5), (-4.5, 4.5), (-5.0, 5.0)],
        f: |x| (x[1] - x[2]).powi(2) + (x[1] + x[2] - 10.0).powi(2) / 9.0 + (x[3] - 5.0).powi(2),
        g: |x| vec![48.0 - x[1].powi(2) - x[2].powi(2) - x[3].powi(2)],
        g_bounds: &[POSITIVE],
        optimum: 0.953_528_856_7,
        minimisers: &[&[3.650_461_821, 3.650_461_69, 4.620_417_050_7]],
        ..DEFAULT
    },
    Problem {
        name: "HS066",
        start: &[0.0, 1.05, 2.9],
        bounds: &[(0.0, 100.0), (0.0, 100.0), (0.0, 10.0)],
        f: |x| 0.2 * x[3] - 0.8 * x[1],
        g: |x| vec![x[2] - x[1].exp(), x[3] - x[2].exp()],
        g_bounds: &[POSITIVE; 2],
        optimum: 0.518_163_274_1,
        minimisers: &[&[0.184_126_487_9, 1.202_167_873, 3.327_322_322]],
        ..DEFAULT
    },
    Problem {
        name: "HS072",
        start: &[1.0; 4],
        bounds: &[(0.001, 4e5), (0.001, 3e5), (0.001, 2e5), (0.001, 1e5)],
        f: |x| 1.0 + x.sum(),
        g: |x| {
            vec![
                0.0401 - 4.0 / x[1] - 2.25 / x[2] - 1.0 / x[3] - 0.25 / x[4],
                0.010_085 - 0.16 / x[1] - 0.36 / x[2] - 0.64 / x[3] - 0.64 / x[4],
            ]
        },
        g_bounds: &[POSITIVE; 2],
        optimum: 727.679_37,
        minimisers: &[&[193.4071, 179.5475, 185.0186, 168.7062]],
        ..DEFAULT
    },
    Problem {
        name: "HS076",
        start: &[0.5; 4],
        bounds: &[POSITIVE; 4],
        f: |x| {
            x[1].powi(2) + 0.5 * x[2].powi(2) + x[3].powi(2) + 0.5 * x[4].powi(2) - x[1] * x[3]
                + x[3] * x[4]
                - x[1]
                - 3.0 * x[2]
                + x[3]
                - x[4]
        },
        g: |x| {
            vec![
                5.0 - x[1] - 2.0 * x[2] - x[3] - x[4],
                4.0 - 3.0 * x[1] - x[2] - 2.0 * x[3] + x[4],
                x[2] + 4.0 * x[3] - 1.5,
            ]
        },
        g_bounds: &[POSITIVE; 3],
        optimum: -4.681_818_181,
        minimisers: &[&[0.272_727_3, 2.090_909, 0.0, 0.545_454_5]],
        ..DEFAULT
    },
    // Three two-sided constraints.
    Problem {
        name: "HS083",
        start: &[78.0, 33.0, 27.0, 27.0, 27.0],
        bounds: &[
            (78.0, 102.0),
            (33.0, 45.0),
            (27.0, 45.0),
            (27.0, 45.0),
            (27.0, 45.0),
        ],
        f: |x| {
            5.357_854_7 * x[3].powi(2) + 0.835_689_1 * x[1] * x[5] + 37.293_239 * x[1] - 40_792.141
        },
        g: |x| {
            vec![
                85.334_407 + 0.005_685_8 * x[2] * x[5] + 0.000_626_2 * x[1] * x[4]
                    - 0.002_205_3 * x[3] * x[5],
                80.512_49
                    + 0.007_131_7 * x[2] * x[5]
                    + 0.002_995_5 * x[1] * x[2]
                    + 0.002_181_3 * x[3].powi(2),
                9.300_961
                    + 0.004_702_6 * x[3] * x[5]
                    + 0.001_254_7 * x[1] * x[3]
                    + 0.001_908_5 * x[3] * x[4],
            ]
        },
        g_bounds: &[(0.0, 92.0), (90.0, 110.0), (20.0, 25.0)],
        optimum: -30_665.538_67,
        minimisers: &[&[78.0, 33.0, 29.995_26, 45.0, 36.775_81]],
        ..DEFAULT
    },
];
