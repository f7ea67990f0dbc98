//! The condition number of a method's Newton system at its solution.

use contact_core::equilibrium::Solution;
use contact_core::method::eta;
use contact_core::{ContactProblem, Scale};
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// The term of the Hessian in addition to that of the energy.
#[derive(Clone, Copy, Debug)]
pub enum Weighting {
    /// Method (7): displacements are confined to the null space of the active rows.
    Confined,
    /// μ Σ η(c_i): method (37) without its slacks.
    Rows(f64),
    /// μ Σ w_i η(c_i) with w_i the row's share of the surface: method (39).
    Surface(f64),
}

/// λ_max/λ_min of L²/E₀ ∇²E + Σ k_i C_iᵀC_i in the free unknowns divided by L, with L and E₀ the
/// scales of the problem passed to Ipopt; k_i = μ w_i η''(c_i/L) for a penalty. For method (7) it
/// is that of ∇²E on the displacements that preserve the gaps of active rows, approximated by one
/// large k for all of them. `None` if the matrix is not positive definite to working precision.
pub fn condition(
    problem: &dyn ContactProblem,
    solution: &Solution,
    weighting: Weighting,
) -> Option<f64> {
    let n = problem.energy().dofs();
    let scale = Scale::of(problem, &solution.state.u).ok()?;
    let energy = hessian(problem, &scale, &solution.state.u);
    let alone = largest(n, &energy);
    let with = |stiffness: &[f64]| {
        let mut all = energy.clone();
        add_rows(solution, stiffness, &mut all);
        all
    };
    let stiffness = stiffnesses(&scale, solution, weighting, alone);
    let all = with(&stiffness);
    let most = match weighting {
        Weighting::Confined => alone,
        _ => largest(n, &all),
    };
    Some(most / smallest(n, &all)?)
}

/// The stiffness of an active row of method (7), as a multiple of the body's (no unit).
const FIRM: f64 = 1e8;
/// The smallest force of an active row, as a share of the largest force.
const ACTIVE: f64 = 1e-6;

/// k_i, one for each row.
fn stiffnesses(scale: &Scale, solution: &Solution, weighting: Weighting, alone: f64) -> Vec<f64> {
    let gaps = &solution.gaps;
    let mut c = vec![0.0; gaps.len()];
    gaps.value(&solution.state.u, &mut c);
    let curvature = |c: &f64| eta(c / scale.length)[2];
    match weighting {
        Weighting::Confined => {
            let most = solution.lambda.iter().fold(0.0, |m: f64, l| m.max(*l));
            let firm = |l: &f64| {
                if *l > ACTIVE * most {
                    FIRM * alone
                } else {
                    0.0
                }
            };
            solution.lambda.iter().map(firm).collect()
        }
        Weighting::Rows(mu) => c.iter().map(|c| mu * curvature(c)).collect(),
        Weighting::Surface(mu) => {
            let rows = c.iter().zip(gaps.weights());
            rows.map(|(c, w)| mu * w / scale.area * curvature(c))
                .collect()
        }
    }
}

type Entries = Vec<Triplet<usize, usize, f64>>;

/// Both triangles of L²/E₀ ∇²E.
fn hessian(problem: &dyn ContactProblem, scale: &Scale, u: &[f64]) -> Entries {
    let energy = problem.energy();
    let (length, unit) = (scale.length, scale.energy);
    let mut values = vec![0.0; energy.hessian_pattern().len()];
    energy.hessian(u, &mut values);
    let mut entries = Vec::new();
    for ((i, j), v) in energy.hessian_pattern().iter().zip(values) {
        let v = v * length * length / unit;
        entries.push(Triplet::new(i, j, v));
        if i != j {
            entries.push(Triplet::new(j, i, v));
        }
    }
    entries
}

/// Adds Σ k_i C_iᵀC_i.
fn add_rows(solution: &Solution, stiffness: &[f64], all: &mut Entries) {
    let mut rows = vec![Vec::new(); stiffness.len()];
    for (i, j, c) in solution.gaps.entries() {
        rows[i].push((j, c));
    }
    for (row, k) in rows.iter().zip(stiffness).filter(|(_, k)| **k > 0.0) {
        for (i, a) in row {
            let products = row.iter().map(|(j, b)| Triplet::new(*i, *j, k * a * b));
            all.extend(products);
        }
    }
}

/// The number of steps of the power and inverse iterations.
const ITERATIONS: usize = 300;

/// λ_max by power iteration.
fn largest(n: usize, entries: &Entries) -> f64 {
    let mut x = start(n);
    let mut value = 0.0;
    for _ in 0..ITERATIONS {
        let mut y = Mat::<f64>::zeros(n, 1);
        for entry in entries {
            y[(entry.row, 0)] += entry.val * x[(entry.col, 0)];
        }
        value = y.norm_l2();
        x = y * (1.0 / value);
    }
    value
}

/// λ_min by inverse iteration.
fn smallest(n: usize, entries: &Entries) -> Option<f64> {
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, entries).ok()?;
    let factor: Llt<usize, f64> = matrix.sp_cholesky(Side::Lower).ok()?;
    let mut x = start(n);
    let mut value = 0.0;
    for _ in 0..ITERATIONS {
        let y = factor.solve(&x);
        value = y.norm_l2();
        x = y * (1.0 / value);
    }
    Some(1.0 / value)
}

/// A unit vector with components along all eigenvectors.
fn start(n: usize) -> Mat<f64> {
    let x = Mat::from_fn(n, 1, |i, _| 1.0 + (1.7 * i as f64).sin());
    let norm = x.norm_l2();
    x * (1.0 / norm)
}
