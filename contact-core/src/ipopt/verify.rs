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
    /// λᵢ pushes away from a bound of gᵢ that is far off, or that there is not: x is not stationary without it.
    Multiplier {
        /// Of which constraint.
        index: usize,
        /// λᵢ.
        value: f64,
        /// How far gᵢ is from the bound; infinite where there is none.
        slack: f64,
        /// What their product may be: the option `compl_inf_tol`, or `acceptable_compl_inf_tol`.
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
            Self::Multiplier {
                index,
                value,
                slack,
                allowed,
            } => write!(
                f,
                "the multiplier of g[{index}] is {value:e} at a distance of {slack:e} from its bound, and a product of \
                 {allowed:e} is allowed: choose units in which derivatives are about 1"
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
    complementarity: f64,
    /// −1 where f is maximised, which reverses the multipliers' signs.
    sign: f64,
    /// By which Ipopt relaxes bounds, relative to their size. Versions before 3.14 move x back afterwards.
    relaxation: f64,
    /// Bounds from these are none to Ipopt.
    infinite: [f64; 2],
}

impl Allowed {
    fn by(solver: &Solver, status: Status) -> Self {
        let prefix = match status {
            Status::SolvedToAcceptableLevel => "acceptable_",
            _ => "",
        };
        let tolerance = |name: &str| solver.number(&format!("{prefix}{name}"));
        let maximises = solver.scaled.is_some_and(|usable| usable.maximises);
        let factor = solver.number("obj_scaling_factor");
        Self {
            violation: tolerance("constr_viol_tol"),
            lagrangian: tolerance("dual_inf_tol"),
            complementarity: tolerance("compl_inf_tol"),
            sign: factor.signum() * if maximises { -1.0 } else { 1.0 },
            relaxation: solver.bound_relaxation(),
            infinite: ["nlp_lower_bound_inf", "nlp_upper_bound_inf"]
                .map(|name| solver.number(name)),
        }
    }

    /// By how much a value violates its bounds beyond relaxation and round-off.
    fn violation(&self, lower: f64, upper: f64, value: f64) -> f64 {
        let below = match lower <= self.infinite[0] {
            true => 0.0,
            false => lower - self.blur(lower) - value,
        };
        let above = match upper >= self.infinite[1] {
            true => 0.0,
            false => value - self.blur(upper) - upper,
        };
        below.max(above).max(0.0)
    }

    /// By how much a bound is relaxed or rounded.
    fn blur(&self, bound: f64) -> f64 {
        (self.relaxation + ROUND_OFF) * bound.abs().max(1.0)
    }

    /// How far a value is for sure from the bound that a multiplier says it is at; infinite where there is none.
    fn slack(&self, [lower, upper]: [f64; 2], value: f64, multiplier: f64) -> f64 {
        match multiplier * self.sign > 0.0 {
            true if upper >= self.infinite[1] => f64::INFINITY,
            true => upper - value - self.blur(upper),
            false if lower <= self.infinite[0] => f64::INFINITY,
            false => value - lower - self.blur(lower),
        }
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
    here.stationarity(structure, solution.multipliers.as_ref()?, &allowed, &moved)
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

    /// ∇L, of variables that are not fixed: Ipopt need not return the multipliers of the others' bounds; and the constraints
    /// without whose multipliers it would not vanish, which must be at the bounds that these say. `moved` is by how much g
    /// may have changed where x was moved.
    fn stationarity(
        &self,
        structure: &Structure,
        multipliers: &Multipliers,
        allowed: &Allowed,
        moved: &[f64],
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
        let most = |i: usize| allowed.lagrangian + share * size[i].max(1.0);
        let is_free = |i: usize| lower[i] != upper[i];
        let is_wrong = |i: &usize| is_free(*i) && !(sum[*i].abs() <= most(*i));
        if let Some(index) = (0..sum.len()).find(is_wrong) {
            return Some(Contradiction::Lagrangian {
                index,
                value: sum[index],
                allowed: allowed.lagrangian,
            });
        }
        let Bounds { lower, upper } = structure.constraint_bounds();
        let mut entries = structure.jacobian().iter().zip(&self.jacobian);
        entries.find_map(|((row, col), entry)| {
            let (lambda, bounds) = (multipliers.constraints[row], [lower[row], upper[row]]);
            if bounds[0] == bounds[1] || !is_free(col) || (lambda * entry).abs() <= most(col) {
                return None;
            }
            let slack = allowed.slack(bounds, self.g[row], lambda) - moved[row];
            let round_off = SAME * (lambda * self.g[row]).abs();
            let product = lambda.abs() * slack;
            (product > (1.0 + SAME) * allowed.complementarity + round_off).then_some(
                Contradiction::Multiplier {
                    index: row,
                    value: lambda,
                    slack,
                    allowed: allowed.complementarity,
                },
            )
        })
    }
}
