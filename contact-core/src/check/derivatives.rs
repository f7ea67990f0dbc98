//! The derivatives of an [`Nlp`] against finite differences of its functions.

use std::fmt;

use crate::nlp::{Nlp, NlpError, Structure};

/// A derivative of a problem. Indices count from 0; `in_pattern` tells whether the structure has that entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Derivative {
    /// ∂f/∂xᵢ.
    Gradient(usize),
    /// ∂g_row/∂x_col.
    Jacobian {
        /// Which constraint.
        row: usize,
        /// Which variable.
        col: usize,
        /// Whether the pattern has it.
        in_pattern: bool,
    },
    /// ∂²f/∂x_row ∂x_col, estimated from ∂f/∂x_col.
    ObjectiveHessian {
        /// One variable.
        row: usize,
        /// The other.
        col: usize,
        /// Whether the pattern has it.
        in_pattern: bool,
    },
    /// ∂²g_constraint/∂x_row ∂x_col, estimated from ∂g/∂x_col.
    ConstraintHessian {
        /// Which constraint.
        constraint: usize,
        /// One variable.
        row: usize,
        /// The other.
        col: usize,
        /// Whether the pattern has it.
        in_pattern: bool,
    },
}

impl fmt::Display for Derivative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let in_pattern = match *self {
            Self::Gradient(i) => return write!(f, "∂f/∂x[{i}]"),
            Self::Jacobian {
                row,
                col,
                in_pattern,
            } => {
                write!(f, "∂g[{row}]/∂x[{col}]")?;
                in_pattern
            }
            Self::ObjectiveHessian {
                row,
                col,
                in_pattern,
            } => {
                write!(f, "∂²f/∂x[{row}]∂x[{col}]")?;
                in_pattern
            }
            Self::ConstraintHessian {
                constraint,
                row,
                col,
                in_pattern,
            } => {
                write!(f, "∂²g[{constraint}]/∂x[{row}]∂x[{col}]")?;
                in_pattern
            }
        };
        f.write_str(if in_pattern {
            ""
        } else {
            " (not in the pattern)"
        })
    }
}

/// A derivative that disagrees with finite differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// Which one.
    pub which: Derivative,
    /// The value that the problem returns; 0 where the pattern has no entry.
    pub given: f64,
    /// The finite difference.
    pub estimated: f64,
    /// |given − estimated| / max(1, |estimated|).
    pub relative_error: f64,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            which,
            given,
            estimated,
            ..
        } = self;
        write!(f, "{which}: {given} given, {estimated} estimated")
    }
}

/// Settings of the comparison with finite differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// Step in xᵢ, relative to max(1, |xᵢ|).
    pub step: f64,
    /// Relative error from which a derivative counts as wrong.
    pub tolerance: f64,
}

impl Default for Differences {
    fn default() -> Self {
        Differences {
            step: 1e-5,
            tolerance: 1e-5,
        }
    }
}

/// The value of σ and of each λᵢ in turn; not 1, so that a Hessian that ignores them is found.
const FACTOR: f64 = 2.0;

/// Compares the first derivatives and, where the structure has a Hessian, the second derivatives at `x` (n) with
/// central differences of the functions one order lower: 2 n evaluations of each. Both triangles of a Hessian are
/// compared, so that a wrong off-diagonal entry gives two findings. Values that are not finite are findings.
///
/// It is meant for problems of test size: it takes n²(m + 1) operations and stores 2 n gradients and Jacobians.
///
/// # Errors
/// [`NlpError::Length`] if `x` does not have n values, [`NlpError::Value`] if one of them is not finite, or a setting is
/// not finite and positive.
pub fn nlp(
    nlp: &mut dyn Nlp,
    structure: &Structure,
    x: &[f64],
    differences: Differences,
) -> Result<Vec<Finding>, NlpError> {
    let (n, m) = (structure.variables(), structure.constraints());
    if x.len() != n {
        return Err(NlpError::Length {
            what: "x",
            found: x.len(),
            expected: n,
        });
    }
    let settings = [
        ("the step of the differences", differences.step),
        ("the tolerance of the differences", differences.tolerance),
    ];
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let of_x = x
        .iter()
        .enumerate()
        .map(|(index, &value)| ("x", index, value, value.is_finite()));
    let of_settings = settings.map(|(what, value)| (what, 0, value, positive(value)));
    if let Some((what, index, value, _)) = of_x.chain(of_settings).find(|found| !found.3) {
        return Err(NlpError::Value {
            what,
            index,
            value,
            needed: if what == "x" {
                "finite"
            } else {
                "finite and positive"
            },
        });
    }
    let mut check = Check {
        tolerance: differences.tolerance,
        findings: Vec::new(),
    };
    let here = Sample::at(nlp, structure, x);
    let pairs: Vec<Pair> = (0..n)
        .map(|j| Pair::around(nlp, structure, x, j, differences.step))
        .collect();
    check.first(structure, &here, &pairs);
    if let Some(pattern) = structure.hessian() {
        for function in (0..=m).map(|i: usize| i.checked_sub(1)) {
            let (mut sigma, mut lambda) = (0.0, vec![0.0; m]);
            *function.map_or(&mut sigma, |i| &mut lambda[i]) = FACTOR;
            let mut values = vec![0.0; pattern.len()];
            if !pattern.is_empty() {
                nlp.hessian(x, true, sigma, &lambda, &mut values);
            }
            values.iter_mut().for_each(|value| *value /= FACTOR);
            check.second(structure, function, &values, &pairs);
        }
    }
    Ok(check.findings)
}

/// Values and first derivatives at a point.
struct Sample {
    f: f64,
    gradient: Vec<f64>,
    g: Vec<f64>,
    jacobian: Vec<f64>,
}

impl Sample {
    fn at(nlp: &mut dyn Nlp, structure: &Structure, x: &[f64]) -> Self {
        let mut gradient = vec![0.0; structure.variables()];
        let mut g = vec![0.0; structure.constraints()];
        let mut jacobian = vec![0.0; structure.jacobian().len()];
        let f = nlp.objective(x, true);
        nlp.gradient(x, true, &mut gradient);
        if !g.is_empty() {
            nlp.constraints(x, true, &mut g);
        }
        if !jacobian.is_empty() {
            nlp.jacobian(x, true, &mut jacobian);
        }
        Sample {
            f,
            gradient,
            g,
            jacobian,
        }
    }

    /// ∇f, or ∇gᵢ.
    fn gradient_of(&self, structure: &Structure, function: Option<usize>) -> Vec<f64> {
        let Some(i) = function else {
            return self.gradient.clone();
        };
        let mut gradient = vec![0.0; structure.variables()];
        for ((row, col), value) in structure.jacobian().iter().zip(&self.jacobian) {
            if row == i {
                gradient[col] += value;
            }
        }
        gradient
    }
}

/// Samples on both sides of x in one variable.
struct Pair {
    above: Sample,
    below: Sample,
    distance: f64,
}

impl Pair {
    fn around(nlp: &mut dyn Nlp, structure: &Structure, x: &[f64], j: usize, step: f64) -> Self {
        let h = step * x[j].abs().max(1.0);
        let mut moved = x.to_vec();
        let mut sample = |to: f64| {
            moved[j] = to;
            Sample::at(nlp, structure, &moved)
        };
        Pair {
            above: sample(x[j] + h),
            below: sample(x[j] - h),
            distance: (x[j] + h) - (x[j] - h),
        }
    }

    fn slope(&self, above: f64, below: f64) -> f64 {
        (above - below) / self.distance
    }
}

struct Check {
    tolerance: f64,
    findings: Vec<Finding>,
}

impl Check {
    fn compare(&mut self, which: Derivative, given: f64, estimated: f64) {
        let relative_error = (given - estimated).abs() / estimated.abs().max(1.0);
        // NaN is wrong too
        if !(relative_error < self.tolerance) {
            self.findings.push(Finding {
                which,
                given,
                estimated,
                relative_error,
            });
        }
    }

    /// ∇f from f, and the columns of ∂g/∂x from g.
    fn first(&mut self, structure: &Structure, here: &Sample, pairs: &[Pair]) {
        let (n, m) = (structure.variables(), structure.constraints());
        let mut jacobian = vec![(0.0, false); n * m];
        for ((row, col), value) in structure.jacobian().iter().zip(&here.jacobian) {
            jacobian[row * n + col].0 += value;
            jacobian[row * n + col].1 = true;
        }
        for (col, pair) in pairs.iter().enumerate() {
            let estimated = pair.slope(pair.above.f, pair.below.f);
            self.compare(Derivative::Gradient(col), here.gradient[col], estimated);
            for row in 0..m {
                let (given, in_pattern) = jacobian[row * n + col];
                let which = Derivative::Jacobian {
                    row,
                    col,
                    in_pattern,
                };
                let estimated = pair.slope(pair.above.g[row], pair.below.g[row]);
                self.compare(which, given, estimated);
            }
        }
    }

    /// The rows of ∇²f, or of ∇²gᵢ, from the gradients.
    fn second(
        &mut self,
        structure: &Structure,
        function: Option<usize>,
        values: &[f64],
        pairs: &[Pair],
    ) {
        let n = structure.variables();
        let mut hessian = vec![(0.0, false); n * n];
        let pattern = structure.hessian().into_iter().flat_map(|p| p.iter());
        for ((row, col), &value) in pattern.zip(values) {
            hessian[row * n + col] = (value, true);
            hessian[col * n + row] = (value, true);
        }
        for (row, pair) in pairs.iter().enumerate() {
            let above = pair.above.gradient_of(structure, function);
            let below = pair.below.gradient_of(structure, function);
            for col in 0..n {
                let (given, in_pattern) = hessian[row * n + col];
                let which = match function {
                    None => Derivative::ObjectiveHessian {
                        row,
                        col,
                        in_pattern,
                    },
                    Some(constraint) => Derivative::ConstraintHessian {
                        constraint,
                        row,
                        col,
                        in_pattern,
                    },
                };
                self.compare(which, given, pair.slope(above[col], below[col]));
            }
        }
    }
}
