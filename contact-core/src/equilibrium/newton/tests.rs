//! Newton's method on problems with a handful of unknowns, whose solutions are known or found by bisection.

mod anchored;
mod curved;
mod ends;
mod fixed;
mod groups;
mod levels;

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::gaps::{Row, Sampling};
use crate::linear::SymmetricPattern;
use crate::nlp::Bounds;
use crate::{Energy, GapVariation, Multipliers, RowKey, Stop};

type Value = Box<dyn Fn(&[f64]) -> f64>;
type Gradient = Box<dyn Fn(&[f64]) -> Vec<f64>>;
type Hessian = Box<dyn Fn(&[f64]) -> DMatrix<f64>>;
type Rows = Box<dyn Fn(&[f64]) -> LinearGaps>;
type Vary = Box<dyn Fn(&[f64], &LinearGaps, &[Option<f64>]) -> GapVariation>;

/// A problem made of functions, with a full Hessian.
struct Toy {
    value: Value,
    gradient: Gradient,
    hessian: Hessian,
    /// Domain functions; all unknowns must be positive if there are any.
    domain_len: usize,
    rows: Rows,
    vary: Option<Vary>,
    pattern: SymmetricPattern,
    bounds: Bounds,
}

impl Toy {
    /// E(u) = ½ uᵀK u − f·u under fixed rows (coefficients, constant).
    fn quadratic(K: &DMatrix<f64>, load: &[f64], rows: &[(Vec<f64>, f64)]) -> Self {
        let (n, f) = (load.len(), DVector::from_column_slice(load));
        let mut gaps = LinearGaps::new(true);
        for (k, (row, constant)) in rows.iter().enumerate() {
            gaps.push(key(k), &self::row(row, *constant));
        }
        let (of_value, of_gradient, of_hessian) = (K.clone(), K.clone(), K.clone());
        let load = f.clone();
        Toy {
            value: Box::new(move |u| {
                let u = DVector::from_column_slice(u);
                0.5 * (&of_value * &u).dot(&u) - f.dot(&u)
            }),
            gradient: Box::new(move |u| {
                let g = &of_gradient * DVector::from_column_slice(u) - &load;
                g.as_slice().to_vec()
            }),
            hessian: Box::new(move |_| of_hessian.clone()),
            domain_len: 0,
            rows: Box::new(move |_| gaps.clone()),
            vary: None,
            pattern: SymmetricPattern::dense(n),
            bounds: Bounds::default(),
        }
    }

    fn solve_from(&self, u: &[f64]) -> Solution {
        self.solve_with(&mut CondensedNewton::default(), u)
    }

    fn solve_with(&self, solver: &mut CondensedNewton, u: &[f64]) -> Solution {
        solver.solve_from(self, at(u)).expect("a valid problem")
    }

    /// What is left of ∇E = Cᵀλ and of 0 ≤ λ ⟂ c ≥ 0.
    fn left(&self, solution: &Solution) -> [f64; 2] {
        let u = &solution.state.u;
        let gaps = (self.rows)(u);
        let lambda: Vec<f64> = gaps
            .keys()
            .iter()
            .map(|&key| solution.state.multipliers.of(key))
            .collect();
        let (mut forces, mut c) = (vec![0.0; u.len()], vec![0.0; gaps.len()]);
        gaps.add_forces(&lambda, &mut forces);
        gaps.value(u, &mut c);
        let g = (self.gradient)(u);
        let of_forces = g.iter().zip(&forces).map(|(g, f)| (g - f).abs());
        let of_rows = c.iter().zip(&lambda).map(|(c, l)| c.min(*l).abs());
        [of_forces.fold(0.0, f64::max), of_rows.fold(0.0, f64::max)]
    }
}

impl Energy for Toy {
    fn dofs(&self) -> usize {
        self.pattern.dim()
    }
    fn value(&self, u: &[f64]) -> f64 {
        (self.value)(u)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        g.copy_from_slice(&(self.gradient)(u));
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        let K = (self.hessian)(u);
        let entries = values.iter_mut().zip(self.pattern.iter());
        entries.for_each(|(value, (i, j))| *value = K[(i, j)]);
    }
    fn domain_len(&self) -> usize {
        self.domain_len
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        d.copy_from_slice(&u[..self.domain_len]);
    }
}

impl ContactProblem for Toy {
    fn energy(&self) -> &dyn Energy {
        self
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn linearize_gaps(&self, u: &[f64], _: Sampling) -> Result<LinearGaps, Error> {
        Ok((self.rows)(u))
    }
    fn vary_gaps(
        &self,
        u: &[f64],
        gaps: &LinearGaps,
        lambda: &[Option<f64>],
    ) -> Result<Option<GapVariation>, Error> {
        Ok(self.vary.as_ref().map(|vary| vary(u, gaps, lambda)))
    }
    fn scale(&self) -> Option<Scale> {
        Some(Scale::default())
    }
}

fn key(k: usize) -> RowKey {
    RowKey {
        pass: 0,
        node: k as u32,
    }
}

fn row(coefficients: &[f64], constant: f64) -> Row {
    let free = coefficients.iter().copied().enumerate();
    Row {
        free: free.filter(|(_, a)| *a != 0.0).collect(),
        constant,
        ..Row::default()
    }
}

fn at(u: &[f64]) -> State {
    State {
        u: u.to_vec(),
        ..State::default()
    }
}

/// A start at u with these multipliers of the rows there.
fn with_multipliers(toy: &Toy, u: &[f64], lambda: &[f64]) -> State {
    State {
        multipliers: Multipliers::new(&(toy.rows)(u), lambda),
        ..at(u)
    }
}

fn assert_near(found: &[f64], expected: &[f64], within: f64) {
    assert_eq!(found.len(), expected.len());
    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < within, "{found:?} for {expected:?}");
}
