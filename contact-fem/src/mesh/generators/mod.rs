//! Structured meshes of simple shapes with named boundaries.

mod curves;
mod plane;
mod space;

pub use curves::{onto_cylinder, onto_sphere};
pub use plane::{Diagonals, annulus, disc, equilateral_disc, half_disc, quarter_disc, rectangle};
pub use space::{cuboid, cuboid_graded, cylinder, eighth_sphere, extrude, hemisphere, sphere};

use crate::error::Error;

/// The largest number of steps of a grid: more would exhaust the memory.
const MOST_STEPS: usize = 100_000_000;

/// `count + 1` equally spaced values from `from` to `to`; only `from` for a count of 0, and an
/// empty vector for more than 10⁸. Generators reject both.
pub fn linspace(from: f64, to: f64, count: usize) -> Vec<f64> {
    if count > MOST_STEPS {
        return Vec::new();
    }
    let at = |k: usize| from + (to - from) * k as f64 / count.max(1) as f64;
    (0..=count).map(at).collect()
}

/// `count + 1` values from `from` to `to` whose spacing changes by a constant factor q; the first
/// step has the length `first` (UL).
///
/// # Errors
/// If a value is not finite, there are fewer than two steps or more than 10⁸, or no q between
/// 1/1000 and 1000 gives the first step.
pub fn graded(from: f64, to: f64, first: f64, count: usize) -> Result<Vec<f64>, Error> {
    /// The largest factor q, and the reciprocal of the smallest (no unit).
    const STEEPEST: f64 = 1e3;
    Error::check_finite("graded(from, to, first)", &[from, to, first])?;
    if count < 2 {
        return Err(Error::Setting {
            name: "count",
            value: count as f64,
            remedy: "grade at least two steps",
        });
    }
    if count > MOST_STEPS {
        return Err(Error::Setting {
            name: "count",
            value: count as f64,
            remedy: "ask for at most 10⁸ steps",
        });
    }
    // the total length divided by the first step: 1 + q + q² + … = (qⁿ − 1) / (q − 1)
    let sum = |q: f64, steps: usize| match q.ln() {
        0.0 => steps as f64,
        log => (steps as f64 * log).exp_m1() / log.exp_m1(),
    };
    let target = (to - from).abs() / first;
    let (mut low, mut high) = (1.0 / STEEPEST, STEEPEST);
    if !(sum(low, count) <= target && target <= sum(high, count)) {
        return Err(Error::Setting {
            name: "first",
            value: first,
            remedy: "give a first step that is positive and shorter than the whole length",
        });
    }
    for _ in 0..200 {
        let q = 0.5 * (low + high);
        match sum(q, count) < target {
            true => low = q,
            false => high = q,
        }
    }
    let at = |k: usize| from + (to - from) * sum(low, k) / sum(low, count);
    let mut values: Vec<f64> = (0..=count).map(at).collect();
    values[count] = to;
    Ok(values)
}

fn ascending(name: &'static str, values: &[f64]) -> Result<(), Error> {
    Error::check_finite(name, values)?;
    if values.len() < 2 {
        return Err(Error::Setting {
            name,
            value: values.len() as f64,
            remedy: "give at least two grid values",
        });
    }
    match values.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(Error::Setting {
            name,
            value: pair[1],
            remedy: "grid values must ascend strictly",
        }),
        None => Ok(()),
    }
}

fn positive(name: &'static str, value: Option<f64>) -> Result<(), Error> {
    match value {
        Some(v) if v > 0.0 && v.is_finite() => Ok(()),
        other => Err(Error::Setting {
            name,
            value: other.unwrap_or(f64::NAN),
            remedy: "must be positive and finite",
        }),
    }
}

/// Rejects meshes that would exhaust the memory and exceed the solver's 32-bit indices.
fn affordable(cells: f64) -> Result<(), Error> {
    if cells > 1e8 {
        return Err(Error::Setting {
            name: "cells",
            value: cells,
            remedy: "ask for a coarser mesh, with at most 10⁸ triangles or tetrahedra",
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradings_start_with_the_step_asked_for() {
        for (from, to, first) in [(0.0, 3.0, 0.1), (2.0, -1.0, 0.5), (0.0, 1.0, 0.9)] {
            let values = graded(from, to, first, 6).expect("possible");
            assert_eq!((values.len(), values[0], values[6]), (7, from, to));
            assert!(((values[1] - from).abs() - first).abs() < 1e-12);
            let ratio = |k: usize| (values[k + 1] - values[k]) / (values[k] - values[k - 1]);
            assert!((2..6).all(|k| (ratio(k) - ratio(1)).abs() < 1e-9 * ratio(1)));
        }
        for first in [0.0, -0.1, 2.0, f64::NAN, f64::INFINITY, 1e-300] {
            graded(0.0, 1.0, first, 6).expect_err("impossible");
        }
        for count in [0, 1, MOST_STEPS + 1, usize::MAX] {
            graded(0.0, 1.0, 0.1, count).expect_err("steps");
        }
        let values = graded(0.0, 1.0, 0.5, 1000).expect("steep");
        assert_eq!((values[0], values[1000]), (0.0, 1.0));
    }

    #[test]
    fn grids_without_steps_and_beyond_all_memory() {
        assert_eq!(linspace(2.0, 5.0, 3), [2.0, 3.0, 4.0, 5.0]);
        assert_eq!(linspace(2.0, 5.0, 0), [2.0]);
        assert!(linspace(2.0, 5.0, usize::MAX).is_empty());
        for count in [0, usize::MAX] {
            let (grid, unit) = (linspace(0.0, 1.0, count), [0.0, 1.0]);
            rectangle(&grid, &unit, Diagonals::Rising).expect_err("no grid");
            cuboid_graded(&unit, &unit, &grid).expect_err("no grid");
            annulus(&grid, 8, Diagonals::Rising).expect_err("no grid");
        }
    }
}
