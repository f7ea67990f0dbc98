//! How a solve ended.

use std::fmt;

/// How a solve ended: Ipopt's `ApplicationReturnStatus`. [`Display`](fmt::Display) says what it means.
///
/// | status | code | what it means | what to do about it |
/// |---|---|---|---|
/// | `Solved` | 0 | The scaled error is below `tol`: a local solution, provided that the derivatives are correct. | Nothing. |
/// | `SolvedToAcceptableLevel` | 1 | The error stayed below `acceptable_tol` for `acceptable_iter` iterations, but did not reach `tol`. | Scale f, x and g to about 1; ask for a larger `tol`, for round-off may be near; check the derivatives. |
/// | `Infeasible` | 2 | A local minimum of the constraint violation. | See which `g` of the solution is outside its bounds; try another start; make sure that the constraints are consistent. |
/// | `SearchDirectionTooSmall` | 3 | Steps vanish in round-off, close to a solution in general. | Look at the errors in the [`Statistics`](super::Statistics); scale; ask for a larger `tol`. |
/// | `Diverging` | 4 | x grows beyond `diverging_iterates_tol`. | The problem may be unbounded: add bounds, or check the sign of f. |
/// | `StoppedByUser` | 5 | [`Nlp::iterate`](crate::nlp::Nlp::iterate), [`Nlp::is_to_stop`](crate::nlp::Nlp::is_to_stop) or the closure of [`Solver::solve_with`](super::Solver::solve_with) asked for it. | Use x, or go on from it; f and g are there after `iterate` and the closure only. |
/// | `FeasiblePointFound` | 6 | The restoration phase has solved the constraints of a square problem, with as many equalities as free variables: there is nothing left to minimise. A square problem that never needs that phase ends as `Solved`. | Nothing; there are no multipliers. |
/// | `IterationLimit` | −1 | `max_iter`. | Look at the history: if it still converges, allow more; if not, check the derivatives, scale, try `mu_strategy(MuStrategy::Adaptive)` or another start. |
/// | `RestorationFailed` | −2 | No less infeasible point was found. | As for `Infeasible`; check the derivatives of g; make functions finite in a wider neighbourhood. |
/// | `StepComputationFailed` | −3 | The linear systems resist regularisation; since 3.14 also a line search that fails almost at the solution. | Remove constraints that depend on others; check the Hessian; see `SearchDirectionTooSmall`. |
/// | `CpuTimeLimit`, `WallTimeLimit` | −4, −5 | `max_cpu_time`, `max_wall_time`. | Allow more; g and the multipliers are lost. |
/// | `TooFewDegreesOfFreedom` | −10 | More equalities than variables, fixed ones included: where the free ones are too few, Ipopt relaxes the others' bounds by itself. | Remove equalities; with `FixedVariableTreatment::MakeConstraint`, which adds one for each fixed variable, choose another. |
/// | `InvalidProblem` | −11 | Ipopt refuses the problem. | See the log, at `print_level` 5. |
/// | `InvalidOption` | −12 | The linear solver is missing, or options contradict each other. | Ask for `LinearSolver::Mumps`; for HSL in a place of its own, set `hsllib` to its path (since 3.14); see the log. |
/// | `InvalidNumber` | −13 | A derivative was not finite, or a function at the start. | Start inside the domain, keep x there by bounds; f and g may be infinite at trial points only. |
/// | `UnrecoverableException`, `ForeignException`, `InternalError` | −100, −101, −199 | An exception, Ipopt's or another; a bug. The first too where a function fails during the derivative check. | See the log. |
/// | `Contradicted` | −1000, this driver's | Ipopt reports a solution, but at its x the functions have other values, or violate what `constr_viol_tol` and `dual_inf_tol` allow. | See [`Solution::contradiction`](super::Solution::contradiction); make functions depend on x alone; check the derivatives; scale x to about 1. |
/// | `InsufficientMemory` | −102 | Out of memory, in MUMPS or elsewhere. | A higher limit of memory, a smaller problem, a sparser ordering (`mumps_pivot_order`), a smaller `mumps_mem_percent`. |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// Optimal to the tolerance.
    Solved,
    /// Optimal to the acceptable tolerance.
    SolvedToAcceptableLevel,
    /// A local minimum of the infeasibility.
    Infeasible,
    /// Steps have become too small to change x.
    SearchDirectionTooSmall,
    /// x grows beyond `diverging_iterates_tol`.
    Diverging,
    /// [`Nlp::iterate`](crate::nlp::Nlp::iterate), [`Nlp::is_to_stop`](crate::nlp::Nlp::is_to_stop) or a watching
    /// closure asked for it.
    StoppedByUser,
    /// The constraints of a square problem are solved, in the restoration phase.
    FeasiblePointFound,
    /// `max_iter`.
    IterationLimit,
    /// The restoration phase failed.
    RestorationFailed,
    /// The linear systems could not be solved.
    StepComputationFailed,
    /// `max_cpu_time`.
    CpuTimeLimit,
    /// `max_wall_time`.
    WallTimeLimit,
    /// More equalities than variables.
    TooFewDegreesOfFreedom,
    /// Ipopt refuses the problem.
    InvalidProblem,
    /// Ipopt refuses an option, or lacks the linear solver.
    InvalidOption,
    /// NaN or ∞ in a derivative, or in a function at the start.
    InvalidNumber,
    /// An exception of Ipopt's.
    UnrecoverableException,
    /// Another C++ exception.
    ForeignException,
    /// Out of memory.
    InsufficientMemory,
    /// A bug in Ipopt.
    InternalError,
    /// Ipopt reports a solution that the functions of the problem contradict.
    Contradicted,
    /// A code this crate does not know.
    Other(i32),
}

impl Status {
    /// From Ipopt's number.
    pub fn from_code(code: i32) -> Self {
        match code {
            0 => Self::Solved,
            1 => Self::SolvedToAcceptableLevel,
            2 => Self::Infeasible,
            3 => Self::SearchDirectionTooSmall,
            4 => Self::Diverging,
            5 => Self::StoppedByUser,
            6 => Self::FeasiblePointFound,
            -1 => Self::IterationLimit,
            -2 => Self::RestorationFailed,
            -3 => Self::StepComputationFailed,
            -4 => Self::CpuTimeLimit,
            -5 => Self::WallTimeLimit,
            -10 => Self::TooFewDegreesOfFreedom,
            -11 => Self::InvalidProblem,
            -12 => Self::InvalidOption,
            -13 => Self::InvalidNumber,
            -100 => Self::UnrecoverableException,
            -101 => Self::ForeignException,
            -102 => Self::InsufficientMemory,
            -199 => Self::InternalError,
            -1000 => Self::Contradicted,
            other => Self::Other(other),
        }
    }

    /// Ipopt's number; −1000 for [`Status::Contradicted`].
    pub fn code(self) -> i32 {
        match self {
            Self::Solved => 0,
            Self::SolvedToAcceptableLevel => 1,
            Self::Infeasible => 2,
            Self::SearchDirectionTooSmall => 3,
            Self::Diverging => 4,
            Self::StoppedByUser => 5,
            Self::FeasiblePointFound => 6,
            Self::IterationLimit => -1,
            Self::RestorationFailed => -2,
            Self::StepComputationFailed => -3,
            Self::CpuTimeLimit => -4,
            Self::WallTimeLimit => -5,
            Self::TooFewDegreesOfFreedom => -10,
            Self::InvalidProblem => -11,
            Self::InvalidOption => -12,
            Self::InvalidNumber => -13,
            Self::UnrecoverableException => -100,
            Self::ForeignException => -101,
            Self::InsufficientMemory => -102,
            Self::InternalError => -199,
            Self::Contradicted => -1000,
            Self::Other(code) => code,
        }
    }

    /// Optimal to the tolerance that was asked for.
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }

    /// Optimal to that tolerance or to Ipopt's acceptable one, or the solution of a square problem, in which there is
    /// nothing to optimise.
    pub fn is_acceptable(self) -> bool {
        matches!(
            self,
            Self::Solved | Self::SolvedToAcceptableLevel | Self::FeasiblePointFound
        )
    }

    /// Whether the caller or a limit of time ended it.
    pub fn is_interrupted(self) -> bool {
        matches!(
            self,
            Self::StoppedByUser | Self::CpuTimeLimit | Self::WallTimeLimit
        )
    }

    /// Whether another start would not do better: the solve was interrupted, or out of memory.
    pub(super) fn is_final(self) -> bool {
        self.is_interrupted() || self == Self::InsufficientMemory
    }

    /// Whether Ipopt returns the multipliers of its last iterate. With any other status they are zero, belong to another
    /// problem, or are missing.
    pub(super) fn keeps_multipliers(self) -> bool {
        matches!(
            self,
            Self::Solved
                | Self::SolvedToAcceptableLevel
                | Self::SearchDirectionTooSmall
                | Self::StoppedByUser
                | Self::IterationLimit
        )
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Solved => "solved to the tolerance",
            Self::SolvedToAcceptableLevel => "solved to the acceptable tolerance only",
            Self::Infeasible => {
                "locally infeasible: the constraint violation has a local minimum above zero"
            }
            Self::SearchDirectionTooSmall => {
                "the steps became too small to go on, close to the accuracy attainable"
            }
            Self::Diverging => "the iterates diverge: the objective may be unbounded below",
            Self::StoppedByUser => "stopped by the caller",
            Self::FeasiblePointFound => "the constraints of a square problem are solved",
            Self::IterationLimit => "the iteration limit (max_iter) was reached",
            Self::RestorationFailed => "the restoration phase found no acceptable point",
            Self::StepComputationFailed => {
                "no step could be computed: the linear systems resist regularisation"
            }
            Self::CpuTimeLimit => "the limit of processor time (max_cpu_time) was reached",
            Self::WallTimeLimit => "the limit of time (max_wall_time) was reached",
            Self::TooFewDegreesOfFreedom => "more equality constraints than variables",
            Self::InvalidProblem => "Ipopt refuses the problem as ill-defined",
            Self::InvalidOption => {
                "Ipopt refuses an option, or was built without the linear solver asked for"
            }
            Self::InvalidNumber => {
                "a derivative, or a function at the starting point, is not finite"
            }
            Self::UnrecoverableException => "Ipopt gave up with an exception",
            Self::ForeignException => "an exception that is not Ipopt's ended the solve",
            Self::InsufficientMemory => "out of memory",
            Self::InternalError => "internal error of Ipopt",
            Self::Contradicted => {
                "Ipopt reports a solution that the functions of the problem contradict"
            }
            Self::Other(code) => {
                return write!(
                    f,
                    "Ipopt status {code}, unknown to this version of the driver"
                );
            }
        })
    }
}
