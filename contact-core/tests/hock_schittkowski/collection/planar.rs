//! Two variables and constraints.

use std::f64::consts::PI;

use crate::problem::{DEFAULT, FREE, INF, POSITIVE, Problem, ZERO};

use super::bounded::rosenbrock;

/// Where a multiplier and its constraint are both 0, x comes out to the root of Ipopt's final μ = 2.5e-9 only.
pub const ROOT: f64 = 1e-4;

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS006",
        start: &[-1.2, 1.0],
        bounds: &[FREE; 2],
        f: |x| (1.0 - x[1]).powi(2),
        g: |x| vec![10.0 * (x[2] - x[1].powi(2))],
        g_bounds: &[ZERO],
        optimum: 0.0,
        minimisers: &[&[1.0, 1.0]],
        ..DEFAULT
    },
    // f* = −√3.
    Problem {
        name: "HS007",
        start: &[2.0, 2.0],
        bounds: &[FREE; 2],
        f: |x| (1.0 + x[1].powi(2)).ln() - x[2],
        g: |x| vec![(1.0 + x[1].powi(2)).powi(2) + x[2].powi(2) - 4.0],
        g_bounds: &[ZERO],
        optimum: -1.732_050_808,
        minimisers: &[&[0.0, 1.732_050_808]],
        ..DEFAULT
    },
    // As many equations as unknowns, and four solutions: ±(a, 9/a) for two a.
    Problem {
        name: "HS008",
        start: &[2.0, 1.0],
        bounds: &[FREE; 2],
        f: |x| 0.0 * x[1] - 1.0,
        g: |x| vec![x[1].powi(2) + x[2].powi(2) - 25.0, x[1] * x[2] - 9.0],
        g_bounds: &[ZERO; 2],
        optimum: -1.0,
        minimisers: &[
            &[4.601_594_97, 1.955_843_62],
            &[-4.601_594_97, -1.955_843_62],
            &[1.955_843_62, 4.601_594_97],
            &[-1.955_843_62, -4.601_594_97],
        ],
        ..DEFAULT
    },
    // Periodic: minima at (12 k − 3, 16 k − 4) for all integers k.
    Problem {
        name: "HS009",
        start: &[0.0, 0.0],
        bounds: &[FREE; 2],
        f: |x| (x[1] * (PI / 12.0)).sin() * (x[2] * (PI / 16.0)).cos(),
        g: |x| vec![4.0 * x[1] - 3.0 * x[2]],
        g_bounds: &[ZERO],
        optimum: -0.5,
        minimisers: &[&[-3.0, -4.0]],
        x_precision: INF,
        ..DEFAULT
    },
    Problem {
        name: "HS010",
        start: &[-10.0, 10.0],
        bounds: &[FREE; 2],
        f: |x| x[1] - x[2],
        g: |x| vec![-3.0 * x[1].powi(2) + 2.0 * x[1] * x[2] - x[2].powi(2) + 1.0],
        g_bounds: &[POSITIVE],
        optimum: -1.0,
        minimisers: &[&[0.0, 1.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS011",
        start: &[4.9, 0.1],
        bounds: &[FREE; 2],
        f: |x| (x[1] - 5.0).powi(2) + x[2].powi(2) - 25.0,
        g: |x| vec![x[2] - x[1].powi(2)],
        g_bounds: &[POSITIVE],
        optimum: -8.498_464_223,
        minimisers: &[&[1.234772825, 1.524663929]],
        ..DEFAULT
    },
    Problem {
        name: "HS012",
        start: &[0.0, 0.0],
        bounds: &[FREE; 2],
        f: |x| 0.5 * x[1].powi(2) + x[2].powi(2) - x[1] * x[2] - 7.0 * x[1] - 7.0 * x[2],
        g: |x| vec![25.0 - 4.0 * x[1].powi(2) - x[2].powi(2)],
        g_bounds: &[POSITIVE],
        optimum: -30.0,
        minimisers: &[&[2.0, 3.0]],
        ..DEFAULT
    },
    // f* = 9 − 23 √7 / 8.
    Problem {
        name: "HS014",
        start: &[2.0, 2.0],
        bounds: &[FREE; 2],
        f: |x| (x[1] - 2.0).powi(2) + (x[2] - 1.0).powi(2),
        g: |x| {
            vec![
                1.0 - 0.25 * x[1].powi(2) - x[2].powi(2),
                x[1] - 2.0 * x[2] + 1.0,
            ]
        },
        g_bounds: &[POSITIVE, ZERO],
        optimum: 1.393_464_981,
        minimisers: &[&[0.822_875_656, 0.911_437_828]],
        ..DEFAULT
    },
    Problem {
        name: "HS015",
        start: &[-2.0, 1.0],
        bounds: &[(-INF, 0.5), FREE],
        f: rosenbrock,
        g: |x| vec![x[1] * x[2] - 1.0, x[1] + x[2].powi(2)],
        g_bounds: &[POSITIVE; 2],
        optimum: 306.5,
        minimisers: &[&[0.5, 2.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS016",
        start: &[-2.0, 1.0],
        bounds: &[(-0.5, 0.5), (-INF, 1.0)],
        f: rosenbrock,
        g: |x| vec![x[1] + x[2].powi(2), x[1].powi(2) + x[2]],
        g_bounds: &[POSITIVE; 2],
        optimum: 0.25,
        minimisers: &[&[0.5, 0.25]],
        ..DEFAULT
    },
    Problem {
        name: "HS017",
        start: &[-2.0, 1.0],
        bounds: &[(-0.5, 0.5), (-INF, 1.0)],
        f: rosenbrock,
        g: |x| vec![x[2].powi(2) - x[1], x[1].powi(2) - x[2]],
        g_bounds: &[POSITIVE; 2],
        optimum: 1.0,
        minimisers: &[&[0.0, 0.0]],
        x_precision: ROOT,
        ..DEFAULT
    },
    // x* = (√250, √2.5).
    Problem {
        name: "HS018",
        start: &[2.0, 2.0],
        bounds: &[(2.0, 50.0), (0.0, 50.0)],
        f: |x| 0.01 * x[1].powi(2) + x[2].powi(2),
        g: |x| vec![x[1] * x[2] - 25.0, x[1].powi(2) + x[2].powi(2) - 25.0],
        g_bounds: &[POSITIVE; 2],
        optimum: 5.0,
        minimisers: &[&[15.811_388_3, 1.581_138_83]],
        ..DEFAULT
    },
    Problem {
        name: "HS019",
        start: &[20.1, 5.84],
        bounds: &[(13.0, 100.0), (0.0, 100.0)],
        f: |x| (x[1] - 10.0).powi(3) + (x[2] - 20.0).powi(3),
        g: |x| {
            vec![
                (x[1] - 5.0).powi(2) + (x[2] - 5.0).powi(2) - 100.0,
                82.81 - (x[2] - 5.0).powi(2) - (x[1] - 6.0).powi(2),
            ]
        },
        g_bounds: &[POSITIVE; 2],
        optimum: -6_961.813_81,
        minimisers: &[&[14.095, 0.842_960_79]],
        ..DEFAULT
    },
    // f* = 81.5 − 25 √3.
    Problem {
        name: "HS020",
        start: &[-2.0, 1.0],
        bounds: &[(-0.5, 0.5), FREE],
        f: rosenbrock,
        g: |x| {
            vec![
                x[1] + x[2].powi(2),
                x[1].powi(2) + x[2],
                x[1].powi(2) + x[2].powi(2) - 1.0,
            ]
        },
        g_bounds: &[POSITIVE; 3],
        optimum: 38.198_73,
        minimisers: &[&[0.5, 0.866_025_404]],
        ..DEFAULT
    },
    Problem {
        name: "HS021",
        start: &[-1.0, -1.0],
        bounds: &[(2.0, 50.0), (-50.0, 50.0)],
        f: |x| 0.01 * x[1].powi(2) + x[2].powi(2) - 100.0,
        g: |x| vec![10.0 * x[1] - x[2] - 10.0],
        g_bounds: &[POSITIVE],
        optimum: -99.96,
        minimisers: &[&[2.0, 0.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS022",
        start: &[2.0, 2.0],
        bounds: &[FREE; 2],
        f: |x| (x[1] - 2.0).powi(2) + (x[2] - 1.0).powi(2),
        g: |x| vec![2.0 - x[1] - x[2], x[2] - x[1].powi(2)],
        g_bounds: &[POSITIVE; 2],
        optimum: 1.0,
        minimisers: &[&[1.0, 1.0]],
        ..DEFAULT
    },
    Problem {
        name: "HS023",
        start: &[3.0, 1.0],
        bounds: &[(-50.0, 50.0); 2],
        f: |x| x[1].powi(2) + x[2].powi(2),
        g: |x| {
            vec![
                x[1] + x[2] - 1.0,
                x[1].powi(2) + x[2].powi(2) - 1.0,
                9.0 * x[1].powi(2) + x[2].powi(2) - 9.0,
                x[1].powi(2) - x[2],
                x[2].powi(2) - x[1],
            ]
        },
        g_bounds: &[POSITIVE; 5],
        optimum: 2.0,
        minimisers: &[&[1.0, 1.0]],
        ..DEFAULT
    },
    // x* = (3, √3), where the first and the third constraint meet.
    Problem {
        name: "HS024",
        start: &[1.0, 0.5],
        bounds: &[POSITIVE; 2],
        f: |x| ((x[1] - 3.0).powi(2) - 9.0) * x[2].powi(3) / (27.0 * 3_f64.sqrt()),
        g: |x| {
            let root = 3_f64.sqrt();
            vec![
                x[1] / root - x[2],
                x[1] + root * x[2],
                6.0 - x[1] - root * x[2],
            ]
        },
        g_bounds: &[POSITIVE; 3],
        optimum: -1.0,
        minimisers: &[&[3.0, 1.732_050_808]],
        ..DEFAULT
    },
    Problem {
        name: "S215",
        start: &[1.0, 1.0],
        bounds: &[POSITIVE, FREE],
        f: |x| x[2],
        g: |x| vec![x[2] - x[1].powi(2)],
        g_bounds: &[POSITIVE],
        optimum: 0.0,
        minimisers: &[&[0.0, 0.0]],
        x_precision: ROOT,
        ..DEFAULT
    },
    Problem {
        name: "S217",
        start: &[10.0, 10.0],
        bounds: &[POSITIVE, FREE],
        f: |x| -x[2],
        g: |x| vec![1.0 + x[1] - 2.0 * x[2], x[1].powi(2) + x[2].powi(2) - 1.0],
        g_bounds: &[POSITIVE, ZERO],
        optimum: -0.8,
        minimisers: &[&[0.6, 0.8]],
        ..DEFAULT
    },
];
