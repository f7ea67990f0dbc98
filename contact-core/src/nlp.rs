//! An optimisation problem in slices: min f(x) subject to x_L ≤ x ≤ x_U and g_L ≤ g(x) ≤ g_U.
//!
//! [`Structure`] holds what never changes during a solve — sizes, bounds, sparsity — and has been validated, so that
//! no index of it can reach a solver out of range. [`Nlp`] holds the functions. The Lagrangian is
//! L = σ f + λᵀ g − z_Lᵀ (x − x_L) + z_Uᵀ (x − x_U), hence z_L, z_U ≥ 0, while λᵢ ≤ 0 where gᵢ is at its **lower** bound
//! and λᵢ ≥ 0 at its upper: a gap constraint g ≥ 0 has the contact pressure −λ.

mod iterate;
mod pattern;

use std::ops::ControlFlow;

use thiserror::Error;

pub use self::iterate::{
    Iterate, IterateSource, IterationRecord, Multipliers, Phase, Slacks, Violations,
};
pub use self::pattern::Pattern;

/// The reason why a [`Structure`] was rejected. Each message names the offending value and the remedy.
#[derive(Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NlpError {
    /// The length of an array does not match the problem.
    #[error("{what} has {found} entries and needs {expected}")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it needs.
        expected: usize,
    },
    /// A value is not a number, or infinite where it must be finite.
    #[error("{what}[{index}] = {value}: it must be {needed}")]
    Value {
        /// Which array.
        what: &'static str,
        /// The index of the entry.
        index: usize,
        /// The value found there.
        value: f64,
        /// The values accepted there.
        needed: &'static str,
    },
    /// No value satisfies both bounds.
    #[error(
        "{what} {index} has the lower bound {lower} above its upper bound {upper}: swap them, \
         or widen bounds that round-off has crossed"
    )]
    CrossedBounds {
        /// "variable" or "constraint".
        what: &'static str,
        /// Which one.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// An index of a pattern is too large.
    #[error(
        "entry {entry} of the {pattern} is ({row}, {col}), outside its {rows} × {cols}; indices count from 0"
    )]
    OutOfRange {
        /// "Jacobian" or "Hessian".
        pattern: &'static str,
        /// Which entry.
        entry: usize,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        cols: usize,
    },
    /// The Hessian is given by its lower triangle only.
    #[error(
        "entry {entry} of the Hessian is ({row}, {col}), above the diagonal: give the lower triangle only, \
         that is ({col}, {row}), once"
    )]
    UpperTriangle {
        /// Which entry.
        entry: usize,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
    },
    /// Two entries of the Hessian have the same row and column.
    #[error("entry {entry} of the Hessian repeats ({row}, {col}): add the values up in one entry")]
    Duplicate {
        /// The second entry.
        entry: usize,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
    },
    /// A size exceeds the 32-bit indices of solvers.
    #[error("{what}: {count} exceeds the 2³¹ − 1 a solver with 32-bit indices can address")]
    TooLarge {
        /// The quantity.
        what: &'static str,
        /// Its size.
        count: usize,
    },
}

/// Lower and upper bounds, ±∞ for no bound. Equal bounds fix a variable, or make a constraint an equality.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bounds {
    /// Lower bounds, −∞ for none.
    pub lower: Vec<f64>,
    /// Upper bounds, +∞ for none.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// `n` times −∞ ≤ · ≤ ∞.
    pub fn free(n: usize) -> Self {
        Self::uniform(n, f64::NEG_INFINITY, f64::INFINITY)
    }

    /// `n` times 0 ≤ · ≤ ∞.
    pub fn nonnegative(n: usize) -> Self {
        Self::uniform(n, 0.0, f64::INFINITY)
    }

    /// `n` times · = 0.
    pub fn zero(n: usize) -> Self {
        Self::uniform(n, 0.0, 0.0)
    }

    /// `n` times `lower` ≤ · ≤ `upper`.
    pub fn uniform(n: usize, lower: f64, upper: f64) -> Self {
        Self {
            lower: vec![lower; n],
            upper: vec![upper; n],
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.lower.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.lower.is_empty()
    }

    pub(crate) fn validate(
        &self,
        what: &'static str,
        lower: &'static str,
        upper: &'static str,
    ) -> Result<(), NlpError> {
        if self.upper.len() != self.lower.len() {
            return Err(NlpError::Length {
                what: upper,
                found: self.upper.len(),
                expected: self.lower.len(),
            });
        }
        for (index, (&l, &u)) in self.lower.iter().zip(&self.upper).enumerate() {
            if l.is_nan() || l == f64::INFINITY {
                return Err(NlpError::Value {
                    what: lower,
                    index,
                    value: l,
                    needed: "a number, or −∞ for no bound",
                });
            }
            if u.is_nan() || u == f64::NEG_INFINITY {
                return Err(NlpError::Value {
                    what: upper,
                    index,
                    value: u,
                    needed: "a number, or +∞ for no bound",
                });
            }
            if l > u {
                return Err(NlpError::CrossedBounds {
                    what,
                    index,
                    lower: l,
                    upper: u,
                });
            }
        }
        Ok(())
    }
}

/// Sizes, bounds and sparsity of a problem, owned and validated.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    variables: Bounds,
    constraints: Bounds,
    jacobian: Pattern,
    hessian: Option<Pattern>,
    jacobian_constant: bool,
    hessian_constant: bool,
}

impl Structure {
    /// A problem with the bounds x_L, x_U of its n `variables` and g_L, g_U of its m `constraints` (either may be 0).
    ///
    /// `jacobian` is the pattern of ∂g/∂x, m × n; entries with the same row and column are added (they are not allowed
    /// where a solver approximates the Jacobian by finite differences). `hessian` is the pattern of the lower triangle
    /// of ∂²L/∂x², n × n, without repeated entries; `None` selects a limited-memory approximation.
    ///
    /// # Errors
    /// [`NlpError`], with index, value and remedy, for sizes that do not match, bounds that are NaN, crossed or
    /// infinite with the wrong sign, indices out of range, and Hessian entries that repeat or lie above the diagonal.
    pub fn new(
        variables: Bounds,
        constraints: Bounds,
        jacobian: Pattern,
        hessian: Option<Pattern>,
    ) -> Result<Self, NlpError> {
        let (n, m) = (variables.len(), constraints.len());
        let counts = [
            ("variables", n),
            ("constraints", m),
            ("entries of the Jacobian", jacobian.len()),
            (
                "entries of the Hessian",
                hessian.as_ref().map_or(0, Pattern::len),
            ),
        ];
        if let Some(&(what, count)) = counts
            .iter()
            .find(|(_, count)| i32::try_from(*count).is_err())
        {
            return Err(NlpError::TooLarge { what, count });
        }
        validate_bounds(&variables, &constraints)?;
        jacobian.validate("Jacobian", m, n)?;
        if let Some(hessian) = &hessian {
            hessian.validate_lower_once(n)?;
        }
        Ok(Self {
            variables,
            constraints,
            jacobian,
            hessian,
            jacobian_constant: false,
            hessian_constant: false,
        })
    }

    /// Promises that ∂²L/∂x² depends neither on x nor on λ: a solver then asks for it once.
    #[must_use]
    pub fn with_constant_hessian(mut self, constant: bool) -> Self {
        self.hessian_constant = constant;
        self
    }

    /// Promises that ∂g/∂x does not depend on x: a solver then asks for it once, and once
    /// more to check the solution.
    #[must_use]
    pub fn with_constant_jacobian(mut self, constant: bool) -> Self {
        self.jacobian_constant = constant;
        self
    }

    /// Replaces the bounds.
    ///
    /// # Errors
    /// As [`Structure::new`]; the bounds are then unchanged.
    pub fn set_bounds(&mut self, variables: Bounds, constraints: Bounds) -> Result<(), NlpError> {
        let expect = |what, found: usize, expected: usize| {
            if found == expected {
                Ok(())
            } else {
                Err(NlpError::Length {
                    what,
                    found,
                    expected,
                })
            }
        };
        expect("x_L", variables.len(), self.variables())?;
        expect("g_L", constraints.len(), self.constraints())?;
        validate_bounds(&variables, &constraints)?;
        self.variables = variables;
        self.constraints = constraints;
        Ok(())
    }

    /// n, the number of variables.
    pub fn variables(&self) -> usize {
        self.variables.len()
    }

    /// m, the number of constraints.
    pub fn constraints(&self) -> usize {
        self.constraints.len()
    }

    /// x_L and x_U.
    pub fn variable_bounds(&self) -> &Bounds {
        &self.variables
    }

    /// g_L and g_U.
    pub fn constraint_bounds(&self) -> &Bounds {
        &self.constraints
    }

    /// Pattern of ∂g/∂x, m × n.
    pub fn jacobian(&self) -> &Pattern {
        &self.jacobian
    }

    /// Pattern of the lower triangle of ∂²L/∂x², n × n; `None` if it is to be approximated.
    pub fn hessian(&self) -> Option<&Pattern> {
        self.hessian.as_ref()
    }

    /// Whether ∂g/∂x is promised constant.
    pub fn jacobian_constant(&self) -> bool {
        self.jacobian_constant
    }

    /// Whether ∂²L/∂x² is promised constant.
    pub fn hessian_constant(&self) -> bool {
        self.hessian_constant
    }
}

fn validate_bounds(variables: &Bounds, constraints: &Bounds) -> Result<(), NlpError> {
    variables.validate("variable", "x_L", "x_U")?;
    constraints.validate("constraint", "g_L", "g_U")
}

/// The functions of a problem. The lengths of all slices are those of its [`Structure`].
///
/// A **non-finite** value, or one whose square overflows, counts as infinite. Such an objective or constraint marks a trial point as inadmissible: the line search shortens its step.
/// Derivatives are evaluated at accepted points only; such a derivative ends the solve with an invalid number.
/// `new_x` is false if `x` is the same as in the previous call of any of these functions.
///
/// Output slices **are filled with zeros**: only nonzero values need be written, and sums can be accumulated in place.
/// A problem without constraints need not implement [`constraints`](Self::constraints) and
/// [`jacobian`](Self::jacobian), one whose Hessian is approximated need not implement [`hessian`](Self::hessian).
///
/// ```
/// # use contact_core::nlp::Nlp;
/// /// min Σ (xᵢ − 1)², by its gradient alone.
/// struct Sphere;
///
/// impl Nlp for Sphere {
///     fn objective(&mut self, x: &[f64], _new_x: bool) -> f64 {
///         x.iter().map(|x| (x - 1.0).powi(2)).sum()
///     }
///     fn gradient(&mut self, x: &[f64], _new_x: bool, gradient: &mut [f64]) {
///         gradient.iter_mut().zip(x).for_each(|(value, x)| *value += 2.0 * (x - 1.0));
///     }
/// }
/// ```
pub trait Nlp {
    /// Called once at the beginning of every solve, with the given starting point x.
    fn begin(&mut self, x: &[f64]) {
        let _ = x;
    }

    /// f(x).
    fn objective(&mut self, x: &[f64], new_x: bool) -> f64;

    /// ∇f(x), n values.
    fn gradient(&mut self, x: &[f64], new_x: bool, gradient: &mut [f64]);

    /// g(x), m values; not called if m = 0.
    ///
    /// # Panics
    /// Unless it is implemented.
    fn constraints(&mut self, x: &[f64], new_x: bool, g: &mut [f64]) {
        let _ = (x, new_x);
        missing("constraints", "constraints", g.len());
    }

    /// ∂g/∂x, one value for each entry of the pattern; not called if it has none.
    ///
    /// # Panics
    /// Unless it is implemented.
    fn jacobian(&mut self, x: &[f64], new_x: bool, values: &mut [f64]) {
        let _ = (x, new_x);
        missing("jacobian", "entries of the Jacobian", values.len());
    }

    /// σ ∇²f(x) + Σ λᵢ ∇²gᵢ(x) with σ = `objective_factor` and λ = `multipliers`: one value for each entry of the
    /// pattern; not called if it has none or is left to approximation. σ may be 0.
    ///
    /// # Panics
    /// Unless it is implemented.
    fn hessian(
        &mut self,
        x: &[f64],
        new_x: bool,
        objective_factor: f64,
        multipliers: &[f64],
        values: &mut [f64],
    ) {
        let _ = (x, new_x, objective_factor, multipliers);
        missing("hessian", "entries of the Hessian", values.len());
    }

    /// Whether the solve is to stop, asked often between iterations: while it waits for those of other threads, and
    /// before each factorisation. It must be fast. The default is `false`.
    fn is_to_stop(&mut self) -> bool {
        false
    }

    /// Whether a numerical factorisation may begin, asked once before each of MUMPS'. The solve stops where it may not.
    /// The default asks [`Nlp::is_to_stop`].
    fn may_factorize(&mut self) -> bool {
        !self.is_to_stop()
    }

    /// Called once per iteration, the starting point (iteration 0) included. [`ControlFlow::Break`] ends the solve.
    fn iterate(&mut self, iterate: &Iterate<'_>) -> ControlFlow<()> {
        let _ = iterate;
        ControlFlow::Continue(())
    }
}

fn missing(function: &str, what: &str, count: usize) -> ! {
    let or = match function {
        "hessian" => ", or give no pattern of it (`None`) to have it approximated",
        _ => "",
    };
    panic!("the structure has {count} {what}: implement `Nlp::{function}`{or}")
}
