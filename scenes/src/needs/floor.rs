//! The cheapest correct ways to the results of the scenes: what a run cannot cost less than.
//!
//! They share assembled matrices and rows with the library, faer, and none of its solvers.

use contact_core::gaps::{LinearGaps, Sampling};
use contact_core::linear::SymmetricPattern;
use contact_core::{ContactProblem, Energy, LoadStepped};
use contact_fem::model::Problem;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Mat, MatMut, Side};

use crate::Failure;

/// An equilibrium at full load, and what it took.
#[derive(Debug)]
pub struct Floor {
    /// The free unknowns (UL).
    pub u: Vec<f64>,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The rows that were looked at.
    pub gaps: LinearGaps,
    /// Their multipliers (UF).
    pub lambda: Vec<f64>,
    /// Numerical factorisations of all bodies: the largest number over the bodies.
    pub factorizations: usize,
}

/// One body's stiffness, factored.
struct Factor {
    symbolic: SymbolicLlt<usize>,
    llt: Llt<usize, f64>,
}

impl Factor {
    fn new(
        energy: &dyn Energy,
        u: &[f64],
        symbolic: Option<SymbolicLlt<usize>>,
    ) -> Result<Self, Failure> {
        let pattern = energy.hessian_pattern();
        let symbolic = match symbolic {
            Some(symbolic) => symbolic,
            None => {
                SymbolicLlt::try_new(entries(pattern), Side::Lower).map_err(|e| format!("{e:?}"))?
            }
        };
        let mut values = vec![0.0; pattern.len()];
        energy.hessian(u, &mut values);
        let K = SparseColMatRef::new(entries(pattern), &values[..]);
        let llt = Llt::try_new_with_symbolic(symbolic.clone(), K, Side::Lower)
            .map_err(|e| format!("{e:?}"))?;
        Ok(Factor { symbolic, llt })
    }

    fn solve(&self, b: &mut [f64]) {
        let n = b.len();
        self.llt
            .solve_in_place(MatMut::from_column_major_slice_mut(b, n, 1));
    }
}

fn entries(pattern: &SymmetricPattern) -> SymbolicSparseColMatRef<'_, usize> {
    let n = pattern.dim();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.starts(), None, pattern.rows())
}

/// Bodies with quadratic energies that supports hold: each stiffness is factored once, the rows that the state without
/// contact violates are condensed, and a small dense problem has their forces. Later increments keep it all.
///
/// # Errors
/// A body that floats, a dense problem that is not solved.
pub fn linear<const D: usize>(
    problem: &mut Problem<D>,
    increments: usize,
) -> Result<Floor, Failure> {
    let n = problem.energy().dofs();
    let mut bodies = Vec::<(std::ops::Range<usize>, Factor)>::new();
    let (mut first, mut patterns) = (0, Vec::<SymmetricPattern>::new());
    for energy in problem.body_energies() {
        let own = first..first + energy.dofs();
        first = own.end;
        if own.is_empty() {
            continue;
        }
        let alike = patterns.iter().position(|p| p == energy.hessian_pattern());
        let symbolic = alike.map(|k| bodies[k].1.symbolic.clone());
        patterns.push(energy.hessian_pattern().clone());
        let factor = Factor::new(energy, &vec![0.0; own.len()], symbolic)?;
        bodies.push((own, factor));
    }
    let solve = |b: &mut [f64]| {
        for (own, factor) in &bodies {
            factor.solve(&mut b[own.clone()]);
        }
    };
    let mut condensed: Option<Condensed> = None;
    let mut floor = None;
    for k in 1..=increments {
        problem.set_load(k as f64 / increments as f64)?;
        let mut u = vec![0.0; n];
        problem.energy().gradient(&vec![0.0; n], &mut u);
        u.iter_mut().for_each(|f| *f = -*f);
        solve(&mut u);
        let passes: Vec<_> = meeting(problem, &u);
        let gaps = match passes.is_empty() {
            true => LinearGaps::new(true),
            false => problem.rows_of(&passes, &vec![0.0; n], Sampling::Nodes)?,
        };
        let mut lambda = vec![0.0; gaps.len()];
        let mut c = vec![0.0; gaps.len()];
        gaps.value(&u, &mut c);
        let least = 1e-11 * u.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        if c.iter().any(|c| *c < -least) {
            let condensed = match &mut condensed {
                Some(known) if known.rows.len() == gaps.len() => known,
                kept => kept.insert(Condensed {
                    rows: (0..gaps.len())
                        .map(|i| gaps.matrix().row(i).collect())
                        .collect(),
                    held: Vec::new(),
                    columns: Vec::new(),
                    W: Mat::new(),
                }),
            };
            let free = u.clone();
            loop {
                let more: Vec<usize> = (0..c.len())
                    .filter(|&i| c[i] < -least && !condensed.held.contains(&i))
                    .collect();
                if more.is_empty() && lambda.iter().any(|l| *l > 0.0) {
                    break;
                }
                condensed.extend(&more, n, &bodies);
                let held = &condensed.held;
                let q: Vec<f64> = held
                    .iter()
                    .map(|&i| row_value(&condensed.rows[i], &free) + gaps.constant()[i])
                    .collect();
                let start: Vec<f64> = held.iter().map(|&i| lambda[i]).collect();
                let forces = complementarity(&condensed.W, &q, start)?;
                held.iter().zip(&forces).for_each(|(&i, l)| lambda[i] = *l);
                u.clone_from(&free);
                let mut pushed = vec![0.0; n];
                gaps.add_forces(&lambda, &mut pushed);
                solve(&mut pushed);
                u.iter_mut().zip(&pushed).for_each(|(u, x)| *u += x);
                gaps.value(&u, &mut c);
            }
        }
        floor = Some(Floor {
            energy: problem.energy().value(&u),
            u,
            gaps,
            lambda,
            factorizations: 1,
        });
    }
    Ok(floor.ok_or("no increment")?)
}

/// The passes whose surfaces' boxes, at rest and at `u`, meet.
fn meeting<const D: usize>(problem: &Problem<D>, u: &[f64]) -> Vec<contact_fem::contact::Pass> {
    let (X, x) = (problem.reference(), problem.positions(u));
    let boxes: Vec<[[f64; 2]; D]> = problem
        .surfaces()
        .iter()
        .map(|surface| {
            std::array::from_fn(|i| {
                let along = surface.nodes().iter().flat_map(|&a| [X[a][i], x[a][i]]);
                along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                    [low.min(v), high.max(v)]
                })
            })
        })
        .collect();
    let meet = |a: usize, b: usize| {
        (0..D).all(|i| boxes[a][i][0] <= boxes[b][i][1] && boxes[b][i][0] <= boxes[a][i][1])
    };
    let passes = problem.passes().iter().copied();
    passes
        .filter(|pass| meet(pass.slave, pass.master))
        .collect()
}

/// The rows that have been violated, condensed.
struct Condensed {
    rows: Vec<Vec<(usize, f64)>>,
    held: Vec<usize>,
    /// K⁻¹ Cᵀ of the held rows.
    columns: Vec<Vec<f64>>,
    W: Mat<f64>,
}

impl Condensed {
    fn extend(&mut self, more: &[usize], n: usize, bodies: &[(std::ops::Range<usize>, Factor)]) {
        if more.is_empty() {
            return;
        }
        let mut block = Mat::<f64>::zeros(n, more.len());
        for (k, &i) in more.iter().enumerate() {
            self.rows[i].iter().for_each(|&(j, a)| block[(j, k)] += a);
        }
        for (own, factor) in bodies {
            let touched: Vec<usize> = (0..more.len())
                .filter(|&k| self.rows[more[k]].iter().any(|(j, _)| own.contains(j)))
                .collect();
            let mut part = Mat::<f64>::from_fn(own.len(), touched.len(), |i, k| {
                block[(own.start + i, touched[k])]
            });
            factor.llt.solve_in_place(part.as_mut());
            for (k, &column) in touched.iter().enumerate() {
                let into = &mut block.col_as_slice_mut(column)[own.clone()];
                into.copy_from_slice(part.col_as_slice(k));
            }
        }
        self.held.extend(more);
        let new = (0..more.len()).map(|k| block.col_as_slice(k).to_vec());
        self.columns.extend(new);
        let (rows, columns, held) = (&self.rows, &self.columns, &self.held);
        let m = held.len();
        let upper = Mat::from_fn(m, m, |i, j| match i <= j {
            true => row_value(&rows[held[i]], &columns[j]),
            false => 0.0,
        });
        self.W = Mat::from_fn(m, m, |i, j| upper[(i.min(j), i.max(j))]);
    }
}

fn row_value(row: &[(usize, f64)], u: &[f64]) -> f64 {
    row.iter().map(|&(j, a)| a * u[j]).sum()
}

/// λ ≥ 0 with W λ + q ≥ 0 and λᵀ(W λ + q) = 0, by the primal-dual active set method from the rows with a force in `start`, or
/// by adding one row at a time where that does not end. Dependent rows get a compliance of 1e-12 of the largest one.
fn complementarity(W: &Mat<f64>, q: &[f64], start: Vec<f64>) -> Result<Vec<f64>, Failure> {
    let m = q.len();
    let largest = (0..m).map(|i| W[(i, i)]).fold(0.0, f64::max);
    let forces = |active: &[usize]| -> Result<Vec<f64>, Failure> {
        let k = active.len();
        let part = Mat::from_fn(k, k, |i, j| {
            W[(active[i], active[j])] + if i == j { 1e-12 * largest } else { 0.0 }
        });
        let llt = part.llt(Side::Lower).map_err(|e| format!("{e:?}"))?;
        let mut b = Mat::from_fn(k, 1, |i, _| -q[active[i]]);
        llt.solve_in_place(b.as_mut());
        let mut lambda = vec![0.0; m];
        active
            .iter()
            .enumerate()
            .for_each(|(i, &row)| lambda[row] = b[(i, 0)]);
        Ok(lambda)
    };
    let gaps = |lambda: &[f64]| -> Vec<f64> {
        let mut c = q.to_vec();
        for (j, l) in lambda.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            let column = W.col_as_slice(j);
            c.iter_mut().zip(column).for_each(|(c, w)| *c += w * l);
        }
        c
    };
    let deepest = q.iter().fold(0.0, |m: f64, c| m.max(-c));
    let closed = 1e-9 * deepest;
    let mut active: Vec<usize> = match start.iter().any(|l| *l > 0.0) {
        true => (0..m).filter(|&i| start[i] > 0.0).collect(),
        false => (0..m).filter(|&i| q[i] < 0.0).collect(),
    };
    for _ in 0..20 {
        let lambda = forces(&active)?;
        let c = gaps(&lambda);
        let next: Vec<usize> = (0..m)
            .filter(|&i| lambda[i] > 0.0 || c[i] < -closed)
            .collect();
        if next == active {
            return Ok(lambda);
        }
        active = next;
    }
    // one row at a time, after Lawson and Hanson
    let (mut active, mut lambda) = (Vec::<usize>::new(), vec![0.0; m]);
    for _ in 0..10 * m {
        let c = gaps(&lambda);
        let worst = (0..m).filter(|i| !active.contains(i));
        let worst = worst.min_by(|&a, &b| c[a].total_cmp(&c[b]));
        match worst.filter(|&i| c[i] < -closed) {
            Some(i) => active.push(i),
            None => return Ok(lambda),
        }
        loop {
            let next = forces(&active)?;
            let leaving = active.iter().copied().filter(|&i| next[i] <= 0.0);
            let share = leaving.map(|i| lambda[i] / (lambda[i] - next[i]));
            let share = share.fold(1.0, f64::min);
            let ways = lambda.iter_mut().zip(&next);
            ways.for_each(|(l, next)| *l += share * (next - *l));
            if share == 1.0 {
                break;
            }
            let least = 1e-14 * lambda.iter().fold(0.0, |m: f64, l| m.max(*l));
            active.retain(|&i| lambda[i] > least);
            let open = (0..m).filter(|i| !active.contains(i));
            open.for_each(|i| lambda[i] = 0.0);
        }
    }
    Err("the dense problem is not solved".into())
}

/// Bodies that do not touch: Newton's method for each body, which supports hold, to a relative change below 1e-8, from the
/// line through the last two states.
///
/// # Errors
/// A stiffness that is not positive definite, no convergence.
pub fn newton<const D: usize>(
    problem: &mut Problem<D>,
    increments: usize,
) -> Result<Floor, Failure> {
    let bodies = problem.body_energies().len();
    let mut states = vec![Newton::default(); bodies];
    for k in 1..=increments {
        problem.set_load(k as f64 / increments as f64)?;
        for (energy, state) in problem.body_energies().iter().zip(&mut states) {
            state.converge(energy)?;
        }
    }
    let u: Vec<f64> = states.iter().flat_map(|state| state.u.clone()).collect();
    Ok(Floor {
        energy: problem.energy().value(&u),
        u,
        gaps: LinearGaps::new(true),
        lambda: Vec::new(),
        factorizations: states.iter().map(|s| s.factorizations).max().unwrap_or(0),
    })
}

/// Newton's method for one body.
#[derive(Clone, Default)]
pub struct Newton {
    /// Its free unknowns (UL).
    pub u: Vec<f64>,
    before: Vec<f64>,
    symbolic: Option<SymbolicLlt<usize>>,
    /// Factorisations so far.
    pub factorizations: usize,
}

impl Newton {
    /// Goes on to the equilibrium at the present load.
    pub fn converge(&mut self, energy: &dyn Energy) -> Result<(), Failure> {
        let n = energy.dofs();
        let last = std::mem::take(&mut self.u);
        self.u = match (last.len() == n, self.before.len() == n) {
            (true, true) => {
                let line = last.iter().zip(&self.before);
                line.map(|(a, b)| 2.0 * a - b).collect()
            }
            (true, false) => last.clone(),
            _ => vec![0.0; n],
        };
        if !energy.value(&self.u).is_finite() {
            self.u.clone_from(&last);
        }
        self.before = last;
        for _ in 0..30 {
            let mut step = vec![0.0; n];
            energy.gradient(&self.u, &mut step);
            if step.iter().all(|f| *f == 0.0) {
                return Ok(());
            }
            let factor = Factor::new(energy, &self.u, self.symbolic.take())?;
            self.factorizations += 1;
            factor.solve(&mut step);
            self.symbolic = Some(factor.symbolic);
            let mut share = 1.0;
            let next = loop {
                let moved = self.u.iter().zip(&step);
                let next: Vec<f64> = moved.map(|(u, x)| u - share * x).collect();
                if energy.value(&next).is_finite() || share < 1e-6 {
                    break next;
                }
                share *= 0.5;
            };
            let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let is_over = share == 1.0 && largest(&step) <= 1e-8 * largest(&next);
            self.u = next;
            if is_over {
                return Ok(());
            }
        }
        Err("Newton's method has not converged".into())
    }
}
