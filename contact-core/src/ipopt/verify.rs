//! What Ipopt calls a solution, compared with what the functions of the problem say at its point.

use std::fmt;

use super::{Solution, Solver, Status, callbacks::timed};
use crate::nlp::{Bounds, Multipliers, Nlp, Structure};

/// What contradicts a solution that Ipopt reports: the status is [`Status::Contradicted`] then.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Contradiction {
    /// xᵢ is outside its bounds, or no number.
    Variable {
        /// Which one.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// f is not what Ipopt returns, or no number.
    Objective {
        /// What the problem says.
        value: f64,
        /// What Ipopt returns.
        returned: f64,
    },
    /// gᵢ is not what Ipopt returns, or no number.
    Constraint {
        /// Which one.
        index: usize,
        /// What the problem says.
        value: f64,
        /// What Ipopt returns.
        returned: f64,
    },
    /// gᵢ violates its bounds.
    Violation {
        /// Which one.
        index: usize,
        /// By how much.
        violation: f64,
        /// The option `constr_viol_tol`, or `acceptable_constr_viol_tol`.
        allowed: f64,
    },
    /// ∂L/∂xᵢ is too large, or no number: multipliers or derivatives are wrong.
    Lagrangian {
        /// Which variable.
        index: usize,
        /// The derivative.
        value: f64,
        /// The option `dual_inf_tol`, or `acceptable_dual_inf_tol`.
        allowed: f64,
    },
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Variable { index, value } => {
                write!(f, "x[{index}] = {value} is outside its bounds")
            }
            Self::Objective { value, returned } => {
                write!(
                    f,
                    "f is {value} at the solution, where Ipopt has {returned}"
                )
            }
            Self::Constraint {
                index,
                value,
                returned,
            } => write!(
                f,
                "g[{index}] is {value} at the solution, where Ipopt has {returned}"
            ),
            Self::Violation {
                index,
                violation,
                allowed,
            } => write!(
                f,
                "g[{index}] violates its bounds by {violation:e}, and {allowed:e} is allowed"
            ),
            Self::Lagrangian {
                index,
                value,
                allowed,
            } => write!(
                f,
                "∂L/∂x[{index}] is {value:e}, and {allowed:e} is allowed: check the derivatives"
            ),
        }
    }
}

/// Relative difference of two values of one function at one point that is still put down to round-off, and the distance
/// from a bound, relative to its size, that is: far above the round-off of functions worth minimising.
const SAME: f64 = 1e-6;
/// See [`SAME`].
const ROUND_OFF: f64 = 1e-8;

/// What the options allow a solution.
struct Allowed {
    violation: f64,
    lagrangian: f64,
    /// By which Ipopt relaxes bounds, relative to their size. Versions before 3.14 move x back afterwards.
    relaxation: f64,
    /// Bounds from these are none to Ipopt.
    infinite: [f64; 2],
}

impl Allowed {
    fn by(solver: &Solver, status: Status) -> Self {
        let [violation, lagrangian] = match status {
            Status::SolvedToAcceptableLevel => {
                ["acceptable_constr_viol_tol", "acceptable_dual_inf_tol"]
            }
            _ => ["constr_viol_tol", "dual_inf_tol"],
        };
        Self {
            violation: solver.number(violation),
            lagrangian: solver.number(lagrangian),
            relaxation: solver.bound_relaxation(),
            infinite: ["nlp_lower_bound_inf", "nlp_upper_bound_inf"]
                .map(|name| solver.number(name)),
        }
    }

    /// By how much a value violates its bounds beyond relaxation and round-off.
    fn violation(&self, lower: f64, upper: f64, value: f64) -> f64 {
        let slack = |bound: f64| (self.relaxation + ROUND_OFF) * bound.abs().max(1.0);
        let below = match lower <= self.infinite[0] {
            true => 0.0,
            false => lower - slack(lower) - value,
        };
        let above = match upper >= self.infinite[1] {
            true => 0.0,
            false => value - slack(upper) - upper,
        };
        below.max(above).max(0.0)
    }
}

fn is_same(a: f64, b: f64, moved: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs()).max(1.0) + moved
}

/// Evaluates the functions at the solution; the first thing that contradicts it, if any. The evaluations count.
pub(super) fn contradiction(
    solver: &Solver,
    nlp: &mut dyn Nlp,
    solution: &mut Solution,
) -> Option<Contradiction> {
    let structure = solver.structure();
    let allowed = Allowed::by(solver, solution.status);
    let x = &solution.x;
    let bounds = structure.variable_bounds();
    let outside = |i: &usize| {
        let is_inside = allowed.violation(bounds.lower[*i], bounds.upper[*i], x[*i]) == 0.0;
        !(x[*i].is_finite() && is_inside)
    };
    if let Some(index) = (0..x.len()).find(outside) {
        let value = x[index];
        return Some(Contradiction::Variable { index, value });
    }

    let here = Evaluation::at(nlp, structure, x, &mut solution.statistics);
    let moves: Vec<f64> = x
        .iter()
        .map(|x| allowed.relaxation * x.abs().max(1.0))
        .collect();
    let moved: f64 = here
        .gradient
        .iter()
        .zip(&moves)
        .map(|(d, h)| d.abs() * h)
        .sum();
    let (value, returned) = (here.f, solution.objective);
    if !is_same(value, returned, moved) {
        return Some(Contradiction::Objective { value, returned });
    }
    let mut moved = vec![0.0; here.g.len()];
    for ((row, col), value) in structure.jacobian().iter().zip(&here.jacobian) {
        moved[row] += value.abs() * moves[col];
    }
    let Bounds { lower, upper } = structure.constraint_bounds();
    for (index, (&value, &returned)) in here.g.iter().zip(&solution.g).enumerate() {
        if !is_same(value, returned, moved[index]) {
            return Some(Contradiction::Constraint {
                index,
                value,
                returned,
            });
        }
        let violation = allowed.violation(lower[index], upper[index], value);
        if violation > (1.0 + SAME) * allowed.violation + moved[index] {
            return Some(Contradiction::Violation {
                index,
                violation,
                allowed: allowed.violation,
            });
        }
    }
    here.stationarity(structure, solution.multipliers.as_ref()?, &allowed)
}

/// Values and first derivatives at a point.
struct Evaluation {
    f: f64,
    gradient: Vec<f64>,
    g: Vec<f64>,
    jacobian: Vec<f64>,
}

impl Evaluation {
    fn at(
        nlp: &mut dyn Nlp,
        structure: &Structure,
        x: &[f64],
        statistics: &mut super::Statistics,
    ) -> Self {
        let f = timed(&mut statistics.objective, || nlp.objective(x, true));
        let mut gradient = vec![0.0; structure.variables()];
        timed(&mut statistics.gradient, || {
            nlp.gradient(x, false, &mut gradient);
        });
        let mut g = vec![0.0; structure.constraints()];
        if !g.is_empty() {
            timed(&mut statistics.constraints, || {
                nlp.constraints(x, false, &mut g);
            });
        }
        let mut jacobian = vec![0.0; structure.jacobian().len()];
        if !jacobian.is_empty() {
            timed(&mut statistics.jacobian, || {
                nlp.jacobian(x, false, &mut jacobian);
            });
        }
        Self {
            f,
            gradient,
            g,
            jacobian,
        }
    }

    /// ∇L, of variables that are not fixed: Ipopt need not return the multipliers of the others' bounds.
    fn stationarity(
        &self,
        structure: &Structure,
        multipliers: &Multipliers,
        allowed: &Allowed,
    ) -> Option<Contradiction> {
        let mut sum = self.gradient.clone();
        let mut size: Vec<f64> = sum.iter().map(|value| value.abs()).collect();
        let mut add = |i: usize, value: f64| {
            sum[i] += value;
            size[i] += value.abs();
        };
        for ((row, col), value) in structure.jacobian().iter().zip(&self.jacobian) {
            add(col, value * multipliers.constraints[row]);
        }
        for i in 0..structure.variables() {
            add(i, -multipliers.lower[i]);
            add(i, multipliers.upper[i]);
        }
        let Bounds { lower, upper } = structure.variable_bounds();
        // as far as x was moved, the derivatives changed
        let share = SAME + 1e2 * allowed.relaxation;
        let is_wrong = |i: &usize| {
            let most = allowed.lagrangian + share * size[*i].max(1.0);
            lower[*i] != upper[*i] && !(sum[*i].abs() <= most)
        };
        let index = (0..sum.len()).find(is_wrong)?;
        Some(Contradiction::Lagrangian {
            index,
            value: sum[index],
            allowed: allowed.lagrangian,
        })
    }
}
