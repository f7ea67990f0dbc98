//! Three and four variables, equalities and inequalities together.

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, POSITIVE, Problem, X, ZERO},
};

use super::planar::ROOT;

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS032",
        start: &[0.1, 0.7, 0.2],
        bounds: &[POSITIVE; 3],
        f: |x| (x[1] + 3.0 * x[2] + x[3]).powi(2) + 4.0 * (x[1] - x[2]).powi(2),
        g: |x| vec![6.0 * x[2] + 4.0 * x[3] - x[1].powi(3) - 3.0, 1.0 - x.sum()],
        g_bounds: &[POSITIVE, ZERO],
        optimum: 1.0,
        minimisers: &[&[0.0, 0.0, 1.0]],
        x_precision: ROOT,
        ..DEFAULT
    },
    Problem {
        name: "HS071",
        start: &[1.0, 5.0, 5.0, 1.0],
        bounds: &[(1.0, 5.0); 4],
        f: |x| x[1] * x[4] * (x[1] + x[2] + x[3]) + x[3],
        g: |x| vec![x.product() - 25.0, x.squares() - 40.0],
        g_bounds: &[POSITIVE, ZERO],
        optimum: 17.014_017_3,
        minimisers: &[&[1.0, 4.742_999_4, 3.821_150_3, 1.379_408_2]],
        ..DEFAULT
    },
    // Cattle feed.
    Problem {
        name: "HS073",
        start: &[1.0; 4],
        bounds: &[POSITIVE; 4],
        f: |x| 24.55 * x[1] + 26.75 * x[2] + 39.0 * x[3] + 40.5 * x[4],
        g: |x| {
            let variance = 0.28 * x[1].powi(2)
                + 0.19 * x[2].powi(2)
                + 20.5 * x[3].powi(2)
                + 0.62 * x[4].powi(2);
            vec![
                2.3 * x[1] + 5.6 * x[2] + 11.1 * x[3] + 1.3 * x[4] - 5.0,
                12.0 * x[1] + 11.9 * x[2] + 41.8 * x[3] + 52.1 * x[4]
                    - 21.0
                    - 1.645 * variance.sqrt(),
                x.sum() - 1.0,
            ]
        },
        g_bounds: &[POSITIVE, POSITIVE, ZERO],
        optimum: 29.894_378,
        minimisers: &[&[0.635_521_6, 0.0, 0.312_701_9, 0.051_776_55]],
        ..DEFAULT
    },
    Problem {
        name: "HS074",
        start: &[0.0; 4],
        bounds: &[(0.0, 1200.0), (0.0, 1200.0), (-0.55, 0.55), (-0.55, 0.55)],
        f: power_cost,
        g: power_flow,
        g_bounds: &[(-0.55, 0.55), ZERO, ZERO, ZERO],
        optimum: 5126.4981,
        minimisers: &[&[679.9453, 1026.067, 0.118_876_4, -0.396_233_6]],
        ..DEFAULT
    },
    Problem {
        name: "HS075",
        start: &[0.0; 4],
        bounds: &[(0.0, 1200.0), (0.0, 1200.0), (-0.48, 0.48), (-0.48, 0.48)],
        f: power_cost,
        g: power_flow,
        g_bounds: &[(-0.48, 0.48), ZERO, ZERO, ZERO],
        optimum: 5174.4129,
        minimisers: &[&[776.1592, 925.1949, 0.051_108_79, -0.428_891_1]],
        ..DEFAULT
    },
];

/// Two generators of a network.
fn power_cost(x: X<'_>) -> HyperDual {
    3.0 * x[1] + 1e-6 * x[1].powi(3) + 2.0 * x[2] + 2e-6 / 3.0 * x[2].powi(3)
}

/// The difference of two phase angles, and the balances at three nodes.
fn power_flow(x: X<'_>) -> Vec<HyperDual> {
    let flow = |angle: HyperDual| 1000.0 * (angle - 0.25).sin();
    vec![
        x[4] - x[3],
        flow(-x[3]) + flow(-x[4]) + 894.8 - x[1],
        flow(x[3]) + flow(x[3] - x[4]) + 894.8 - x[2],
        flow(x[4]) + flow(x[4] - x[3]) + 1294.8,
    ]
}
