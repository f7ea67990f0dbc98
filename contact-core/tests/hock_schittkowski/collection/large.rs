//! Six to fifteen variables.

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, FREE, POSITIVE, Problem, Range, X, ZERO},
};

/// Transformer design: volumes and losses.
fn losses(x: X<'_>, a: f64, b: f64) -> HyperDual {
    a * x[1] * x[4] * x[5].powi(2) * (x[1] + x[2] + x[3])
        + b * x[2] * x[3] * x[6].powi(2) * (x[1] + 1.57 * x[2] + x[4])
}

/// The hexagon: points at most 1 apart, and areas of triangles that are not negative.
fn hexagon(x: X<'_>) -> Vec<HyperDual> {
    let within = |a: HyperDual, b: HyperDual| 1.0 - a.powi(2) - b.powi(2);
    vec![
        within(x[3], x[4]),
        1.0 - x[9].powi(2),
        within(x[5], x[6]),
        within(x[1], x[2] - x[9]),
        within(x[1] - x[5], x[2] - x[6]),
        within(x[1] - x[7], x[2] - x[8]),
        within(x[3] - x[5], x[4] - x[6]),
        within(x[3] - x[7], x[4] - x[8]),
        within(x[7], x[8] - x[9]),
        x[1] * x[4] - x[2] * x[3],
        x[3] * x[9],
        -x[5] * x[9],
        x[5] * x[8] - x[6] * x[7],
    ]
}

/// Free energy of a mixture of ten species.
fn free_energy(x: X<'_>) -> HyperDual {
    const C: [f64; 10] = [
        -6.089, -17.164, -34.054, -5.914, -24.721, -14.986, -24.1, -10.708, -26.662, -22.179,
    ];
    let total = x.sum();
    x.iter()
        .zip(C)
        .map(|(x, c)| x * (c + (x / total).ln()))
        .sum()
}

/// Constraints of the tenth-order problem of Wong and of Asaadi.
fn wong_10(x: X<'_>) -> Vec<HyperDual> {
    vec![
        105.0 - 4.0 * x[1] - 5.0 * x[2] + 3.0 * x[7] - 9.0 * x[8],
        -10.0 * x[1] + 8.0 * x[2] + 17.0 * x[7] - 2.0 * x[8],
        8.0 * x[1] - 2.0 * x[2] - 5.0 * x[9] + 2.0 * x[10] + 12.0,
        120.0 - 3.0 * (x[1] - 2.0).powi(2) - 4.0 * (x[2] - 3.0).powi(2) - 2.0 * x[3].powi(2)
            + 7.0 * x[4],
        40.0 - 5.0 * x[1].powi(2) - 8.0 * x[2] - (x[3] - 6.0).powi(2) + 2.0 * x[4],
        30.0 - 0.5 * (x[1] - 8.0).powi(2) - 2.0 * (x[2] - 4.0).powi(2) - 3.0 * x[5].powi(2) + x[6],
        -x[1].powi(2) - 2.0 * (x[2] - 2.0).powi(2) + 2.0 * x[1] * x[2] - 14.0 * x[5] + 6.0 * x[6],
        3.0 * x[1] - 6.0 * x[2] - 12.0 * (x[9] - 8.0).powi(2) + 7.0 * x[10],
    ]
}

/// Differences of every third variable lie in these ranges, sums of three above those.
const HS118_RANGES: [Range; 17] = {
    const A: Range = (-7.0, 6.0);
    const B: Range = (-7.0, 7.0);
    const fn above(sum: f64) -> Range {
        (sum, f64::INFINITY)
    }
    [
        A,
        B,
        A,
        A,
        B,
        A,
        A,
        B,
        A,
        A,
        B,
        A,
        above(60.0),
        above(50.0),
        above(70.0),
        above(85.0),
        above(100.0),
    ]
};

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS093",
        start: &[5.54, 4.4, 12.02, 11.82, 0.702, 0.852],
        bounds: &[POSITIVE; 6],
        f: |x| {
            0.0204 * x[1] * x[4] * (x[1] + x[2] + x[3])
                + 0.0187 * x[2] * x[3] * (x[1] + 1.57 * x[2] + x[4])
                + losses(x, 0.0607, 0.0437)
        },
        g: |x| {
            vec![
                0.001 * x.product() - 2.07,
                1.0 - losses(x, 0.000_62, 0.000_58),
            ]
        },
        g_bounds: &[POSITIVE; 2],
        optimum: 135.075_961,
        minimisers: &[&[
            5.332_666,
            4.656_744,
            10.432_99,
            12.082_30,
            0.752_607_4,
            0.878_650_84,
        ]],
        ..DEFAULT
    },
    Problem {
        name: "HS100",
        start: &[1.0, 2.0, 0.0, 4.0, 0.0, 1.0, 1.0],
        bounds: &[FREE; 7],
        f: |x| {
            (x[1] - 10.0).powi(2)
                + 5.0 * (x[2] - 12.0).powi(2)
                + x[3].powi(4)
                + 3.0 * (x[4] - 11.0).powi(2)
                + 10.0 * x[5].powi(6)
                + 7.0 * x[6].powi(2)
                + x[7].powi(4)
                - 4.0 * x[6] * x[7]
                - 10.0 * x[6]
                - 8.0 * x[7]
        },
        g: |x| {
            let (s, t) = (x[1].powi(2), x[2].powi(2));
            vec![
                127.0 - 2.0 * s - 3.0 * x[2].powi(4) - x[3] - 4.0 * x[4].powi(2) - 5.0 * x[5],
                282.0 - 7.0 * x[1] - 3.0 * x[2] - 10.0 * x[3].powi(2) - x[4] + x[5],
                196.0 - 23.0 * x[1] - t - 6.0 * x[6].powi(2) + 8.0 * x[7],
                3.0 * x[1] * x[2] - 4.0 * s - t - 2.0 * x[3].powi(2) - 5.0 * x[6] + 11.0 * x[7],
            ]
        },
        g_bounds: &[POSITIVE; 4],
        optimum: 680.630_057_3,
        minimisers: &[&[
            2.330_499,
            1.951_372,
            -0.477_541_4,
            4.365_726,
            -0.624_487_0,
            1.038_131,
            1.594_227,
        ]],
        ..DEFAULT
    },
    // Reactor design.
    Problem {
        name: "HS104",
        start: &[6.0, 3.0, 0.4, 0.2, 6.0, 6.0, 1.0, 0.5],
        bounds: &[(0.1, 10.0); 8],
        f: reactor_cost,
        g: |x| {
            vec![
                1.0 - 0.0588 * x[5] * x[7] - 0.1 * x[1],
                1.0 - 0.0588 * x[6] * x[8] - 0.1 * x[1] - 0.1 * x[2],
                1.0 - (4.0 * x[3] + 2.0 * x[3].powf(-0.71)) / x[5]
                    - 0.0588 * x[3].powf(-1.3) * x[7],
                1.0 - (4.0 * x[4] + 2.0 * x[4].powf(-0.71)) / x[6]
                    - 0.0588 * x[4].powf(-1.3) * x[8],
                reactor_cost(x),
            ]
        },
        g_bounds: &[POSITIVE, POSITIVE, POSITIVE, POSITIVE, (1.0, 4.2)],
        optimum: 3.951_163_439_6,
        minimisers: &[&[
            6.465_114,
            2.232_709,
            0.667_397_5,
            0.595_756_4,
            5.932_676,
            5.527_235,
            1.013_322,
            0.400_668_2,
        ]],
        ..DEFAULT
    },
    // Any local minimum is the area of some hexagon of diameter 1. The published one is that of a folded hexagon, √3/2.
    Problem {
        name: "HS108",
        start: &[1.0; 9],
        bounds: &[FREE, FREE, FREE, FREE, FREE, FREE, FREE, FREE, POSITIVE],
        f: |x| {
            -0.5 * (x[1] * x[4] - x[2] * x[3] + x[3] * x[9] - x[5] * x[9] + x[5] * x[8]
                - x[6] * x[7])
        },
        g: hexagon,
        g_bounds: &[POSITIVE; 13],
        optimum: -0.866_025_403_8,
        minimisers: &[&[
            0.884_129_2,
            0.467_242_5,
            0.037_420_76,
            0.999_299_6,
            0.884_129_2,
            0.467_242_5,
            0.037_420_76,
            0.999_299_6,
            0.0,
        ]],
        ..DEFAULT
    },
    // The x* printed with HS112 has f = −47.7076 and does not belong to its f*; these are f* and x* = exp(y*) of HS111,
    // the same problem in y = ln x.
    Problem {
        name: "HS112",
        start: &[0.1; 10],
        bounds: &[(1e-6, f64::INFINITY); 10],
        f: free_energy,
        g: |x| {
            vec![
                x[1] + 2.0 * x[2] + 2.0 * x[3] + x[6] + x[10] - 2.0,
                x[4] + 2.0 * x[5] + x[6] + x[7] - 1.0,
                x[3] + x[7] + x[8] + 2.0 * x[9] + x[10] - 1.0,
            ]
        },
        g_bounds: &[ZERO; 3],
        optimum: -47.761_090_263_7,
        minimisers: &[&[
            0.040712808,
            0.147775715,
            0.783141951,
            0.001448121,
            0.485220222,
            0.000697688,
            0.027413748,
            0.017993068,
            0.037348531,
            0.096754172,
        ]],
        // The published f* is 6e-7 above the minimum, and x* the root of that away from it.
        x_precision: 1e-3,
        ..DEFAULT
    },
    Problem {
        name: "HS113",
        start: &[2.0, 3.0, 5.0, 5.0, 1.0, 2.0, 7.0, 3.0, 6.0, 10.0],
        bounds: &[FREE; 10],
        f: |x| {
            x[1].powi(2) + x[2].powi(2) + x[1] * x[2] - 14.0 * x[1] - 16.0 * x[2]
                + (x[3] - 10.0).powi(2)
                + 4.0 * (x[4] - 5.0).powi(2)
                + (x[5] - 3.0).powi(2)
                + 2.0 * (x[6] - 1.0).powi(2)
                + 5.0 * x[7].powi(2)
                + 7.0 * (x[8] - 11.0).powi(2)
                + 2.0 * (x[9] - 10.0).powi(2)
                + (x[10] - 7.0).powi(2)
                + 45.0
        },
        g: wong_10,
        g_bounds: &[POSITIVE; 8],
        optimum: 24.306_209_1,
        minimisers: &[&[
            2.171_996,
            2.363_683,
            8.773_926,
            5.095_984,
            0.990_654_8,
            1.430_574,
            1.321_644,
            9.828_726,
            8.280_092,
            8.375_927,
        ]],
        ..DEFAULT
    },
    Problem {
        name: "HS118",
        start: &[
            20.0, 55.0, 15.0, 20.0, 60.0, 20.0, 20.0, 60.0, 20.0, 20.0, 60.0, 20.0, 20.0, 60.0,
            20.0,
        ],
        bounds: &[
            (8.0, 21.0),
            (43.0, 57.0),
            (3.0, 16.0),
            (0.0, 90.0),
            (0.0, 120.0),
            (0.0, 60.0),
            (0.0, 90.0),
            (0.0, 120.0),
            (0.0, 60.0),
            (0.0, 90.0),
            (0.0, 120.0),
            (0.0, 60.0),
            (0.0, 90.0),
            (0.0, 120.0),
            (0.0, 60.0),
        ],
        f: |x| {
            x.0.chunks_exact(3)
                .map(|x| {
                    2.3 * x[0]
                        + 1.7 * x[1]
                        + 2.2 * x[2]
                        + 1e-4 * (x[0].powi(2) + x[1].powi(2) + 1.5 * x[2].powi(2))
                })
                .sum()
        },
        g: |x| {
            let differences = (4..=15).map(|i| x[i] - x[i - 3]);
            let sums = x.0.chunks_exact(3).map(|x| x[0] + x[1] + x[2]);
            differences.chain(sums).collect()
        },
        g_bounds: &HS118_RANGES,
        optimum: 664.820_45,
        minimisers: &[&[
            8.0, 49.0, 3.0, 1.0, 56.0, 0.0, 1.0, 63.0, 6.0, 3.0, 70.0, 12.0, 5.0, 77.0, 18.0,
        ]],
        ..DEFAULT
    },
];

fn reactor_cost(x: X<'_>) -> HyperDual {
    0.4 * (x[1] / x[7]).powf(0.67) + 0.4 * (x[2] / x[8]).powf(0.67) + 10.0 - x[1] - x[2]
}
