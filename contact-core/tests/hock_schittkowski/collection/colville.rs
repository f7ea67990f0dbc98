//! Colville's first problem and the second, its dual.

use crate::{
    hyper_dual::HyperDual,
    problem::{DEFAULT, POSITIVE, Problem},
};

/// min eᵀx + xᵀC x + Σ dⱼ xⱼ³ subject to A x ≥ b and x ≥ 0: e, then C, d, A and b.
const E: [f64; 5] = [-15.0, -27.0, -36.0, -18.0, -12.0];
const C: [[f64; 5]; 5] = [
    [30.0, -20.0, -10.0, 32.0, -10.0],
    [-20.0, 39.0, -6.0, -31.0, 32.0],
    [-10.0, -6.0, 10.0, -6.0, -10.0],
    [32.0, -31.0, -6.0, 39.0, -20.0],
    [-10.0, 32.0, -10.0, -20.0, 30.0],
];
const D: [f64; 5] = [4.0, 8.0, 10.0, 6.0, 2.0];
const A: [[f64; 5]; 10] = [
    [-16.0, 2.0, 0.0, 1.0, 0.0],
    [0.0, -2.0, 0.0, 0.4, 2.0],
    [-3.5, 0.0, 2.0, 0.0, 0.0],
    [0.0, -2.0, 0.0, -4.0, -1.0],
    [0.0, -9.0, -2.0, 1.0, -2.8],
    [2.0, 0.0, -4.0, 0.0, 0.0],
    [-1.0, -1.0, -1.0, -1.0, -1.0],
    [-1.0, -2.0, -3.0, -2.0, -1.0],
    [1.0, 2.0, 3.0, 4.0, 5.0],
    [1.0; 5],
];
const B: [f64; 10] = [-40.0, -2.0, -0.25, -4.0, -4.0, -1.0, -40.0, -60.0, 5.0, 1.0];

/// a · x.
fn dot(a: &[f64], x: &[HyperDual]) -> HyperDual {
    a.iter().zip(x).map(|(&a, &x)| a * x).sum()
}

/// xᵀ C x.
fn quadratic(x: &[HyperDual]) -> HyperDual {
    C.iter().zip(x).map(|(row, &x_i)| x_i * dot(row, x)).sum()
}

/// Σ dⱼ xⱼ³.
fn cubic(x: &[HyperDual]) -> HyperDual {
    D.iter().zip(x).map(|(&d, x)| d * x.powi(3)).sum()
}

/// Column j of A times x.
fn column(j: usize, x: &[HyperDual]) -> HyperDual {
    A.iter().zip(x).map(|(row, &x)| row[j] * x).sum()
}

pub const PROBLEMS: &[Problem] = &[
    Problem {
        name: "HS086",
        start: &[0.0, 0.0, 0.0, 0.0, 1.0],
        bounds: &[POSITIVE; 5],
        f: |x| dot(&E, x.0) + quadratic(x.0) + cubic(x.0),
        g: |x| A.iter().zip(B).map(|(row, b)| dot(row, x.0) - b).collect(),
        g_bounds: &[POSITIVE; 10],
        optimum: -32.348_678_97,
        minimisers: &[&[0.3, 0.333_467_61, 0.4, 0.428_310_10, 0.223_964_87]],
        ..DEFAULT
    },
    // Minus the maximum of the dual is the minimum of the primal, HS086.
    Problem {
        name: "HS117",
        start: &[
            0.001, 0.001, 0.001, 0.001, 0.001, 0.001, 60.0, 0.001, 0.001, 0.001, 0.001, 0.001,
            0.001, 0.001, 0.001,
        ],
        bounds: &[POSITIVE; 15],
        f: |x| {
            let (u, v) = x.0.split_at(10);
            quadratic(v) + 2.0 * cubic(v) - dot(&B, u)
        },
        g: |x| {
            let (u, v) = x.0.split_at(10);
            (0..5)
                .map(|j| 2.0 * dot(&C[j], v) + 3.0 * D[j] * v[j].powi(2) + E[j] - column(j, u))
                .collect()
        },
        g_bounds: &[POSITIVE; 5],
        optimum: 32.348_678_97,
        minimisers: &[&[
            0.0,
            0.0,
            5.174_136,
            0.0,
            3.061_093,
            11.839_68,
            0.0,
            0.0,
            0.103_907_1,
            0.0,
            0.299_992_9,
            0.333_470_9,
            0.399_991_0,
            0.428_314_5,
            0.223_960_7,
        ]],
        // Published to 1e-5; x₁₁ to x₁₅ are x* of HS086, printed there to more digits.
        x_precision: 1e-4,
        ..DEFAULT
    },
];
