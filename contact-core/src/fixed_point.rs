//! Algorithm 2: the symmetric fixed point on projections and normals.

use std::collections::VecDeque;
use std::time::Instant;

use crate::anderson::Anderson;
use crate::method::{Effort, Method, Minimum, Solved, Subproblem};
use crate::{ContactProblem, Error, LinearGaps, Multipliers, State};

/// How successive iterates are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceleration {
    /// The paper's plain iteration; it may fall into a cycle.
    Plain,
    /// [Anderson acceleration](crate::anderson) over this many differences.
    Anderson(usize),
}

/// Settings of Algorithm 2.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPoint {
    /// TOLER: bound on the relative change of U, see [`relative_change`].
    pub tolerance: f64,
    /// Iterations before it gives up.
    pub max_iterations: usize,
    /// Plain or accelerated.
    pub acceleration: Acceleration,
}

impl Default for FixedPoint {
    fn default() -> Self {
        FixedPoint {
            tolerance: 1e-6,
            max_iterations: 30,
            acceleration: Acceleration::Anderson(8),
        }
    }
}

/// How a fixed point ended.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Outcome {
    /// The relative change fell below the tolerance, and every subproblem on the way was solved.
    Converged,
    /// The iterates repeat themselves with this period; `amplitude` is the relative change at which
    /// they do.
    Cycle {
        /// How many iterations a round takes.
        period: usize,
        /// ‖U_n − U_{n−1}‖∞ over ‖U‖∞ within the cycle.
        amplitude: f64,
    },
    /// Out of iterations.
    IterationLimit,
    /// The method did not solve its subproblem; the solver's own word.
    SubproblemFailed(String),
    /// Converged, but to a state in which bodies have gone through each other.
    Tunnelled {
        /// How deep a node is inside another body, or how far it has gone through one (UL).
        depth: f64,
    },
    /// The energy is infinite at the start (J ≤ 0 somewhere): there is nowhere to begin.
    InadmissibleStart,
    /// Someone pulled the brake.
    Interrupted,
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Outcome::Converged => write!(f, "converged"),
            Outcome::Cycle { period, amplitude } => {
                write!(
                    f,
                    "cycles with period {period} at amplitude {amplitude:.2e}"
                )
            }
            Outcome::IterationLimit => write!(f, "iteration limit of the fixed point"),
            Outcome::SubproblemFailed(why) => write!(f, "subproblem not solved: {why}"),
            Outcome::Tunnelled { depth } => {
                write!(
                    f,
                    "bodies have gone {depth:.2e} into or through each other: smaller steps or a longer reach"
                )
            }
            Outcome::InadmissibleStart => write!(f, "inadmissible start (J ≤ 0)"),
            Outcome::Interrupted => write!(f, "interrupted"),
        }
    }
}

/// One iteration of Algorithm 2.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    /// Step 6, infinite if the subproblem was not solved.
    pub error: f64,
    /// Rows in reach.
    pub rows: usize,
    /// Seconds of wall time for steps 1–4: projections, normals, rows.
    pub projection: f64,
    /// What step 5 took.
    pub effort: Effort,
}

/// Where Algorithm 2 ended, and how it got there.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended; the rest is a solution only if it converged.
    pub outcome: Outcome,
    /// The last minimum and its multipliers by row name.
    pub state: State,
    /// E(u) (UF·UL).
    pub energy: f64,
    /// The rows of the last subproblem.
    pub gaps: LinearGaps,
    /// Their multipliers λ ≥ 0 (UF).
    pub lambda: Vec<f64>,
    /// One entry an iteration.
    pub history: Vec<Iteration>,
}

/// ‖U_n − U_{n−1}‖∞ / max(‖U_{n−1}‖∞, ‖U_n‖∞) over all unknowns, zero if nothing moved at all. The
/// norms count as `least` at least: as large as what is prescribed, and as displacements must be to
/// differ from none.
pub fn relative_change(u: &[f64], before: &[f64], least: f64) -> f64 {
    let change = max_norm(u.iter().zip(before).map(|(a, b)| a - b));
    let size = max_norm(u.iter().chain(before).copied()).max(least);
    if change == 0.0 { 0.0 } else { change / size }
}

fn max_norm(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |norm, v| norm.max(v.abs()))
}

impl FixedPoint {
    /// Displacements below this share of [`Scale::length`](crate::Scale) are those of bodies that
    /// carry nothing.
    const NONE: f64 = 1e-6;
    /// The change to expect from a guess of which nothing is known.
    const GUESS: f64 = 1.0;
    /// How many solves are rough, since the next ones keep but their first digits. None of them is
    /// the last.
    const ROUGH_SOLVES: usize = 2;
    /// How accurate rough solves are: this share of the change, counted up to [`Self::CHANGE`].
    const ROUGH: f64 = 1e-6;
    const CHANGE: f64 = 1e-2;

    /// Checks the settings.
    pub fn validate(&self) -> Result<(), Error> {
        let is_share = self.tolerance > 0.0 && self.tolerance < 1.0;
        let remedy = "choose it between 0 and 1, 1e-6 by default";
        Error::check_setting(is_share, "tolerance", self.tolerance, remedy)?;
        if self.max_iterations == 0 {
            return Err(Error::Setting {
                name: "max_iterations",
                value: "0".into(),
                remedy: "allow at least one iteration",
            });
        }
        Ok(())
    }

    /// Runs Algorithm 2 from `start`.
    ///
    /// # Errors
    /// Settings out of range, a start of the wrong length or with a NaN, and whatever the problem
    /// or the method report. Not converging is an [`Outcome`].
    pub fn solve(
        &self,
        problem: &dyn ContactProblem,
        method: &mut dyn Method,
        start: State,
    ) -> Result<Solution, Error> {
        self.validate()?;
        let energy = problem.energy();
        Error::check_vector("start.u", &start.u, energy.dofs())?;

        let mut anderson = Anderson::new(match self.acceleration {
            Acceleration::Plain => 0,
            Acceleration::Anderson(depth) => depth,
        });
        let least = problem
            .prescribed_magnitude()
            .max(Self::NONE * problem.scale().length);
        let mut cycles = CycleDetector::default();
        let mut point = start.clone();
        let mut run = Solution::at(problem, start);
        if !run.energy.is_finite() {
            return Ok(run);
        }
        for _ in 0..self.max_iterations {
            let clock = Instant::now();
            run.gaps = method.linearize(problem, &point.u)?; // steps 1–3, both roles
            let projection = clock.elapsed().as_secs_f64();
            let change = run.history.last().map_or(Self::GUESS, |last| last.error);
            let subproblem = Subproblem {
                energy,
                bounds: problem.bounds(),
                gaps: &run.gaps,
                scale: problem.scale(),
                change,
                accuracy: self.accuracy(&run, change),
            };
            let minimum = method.minimize(&subproblem, &point)?; // steps 4–5
            let error = match minimum.solved {
                Solved::Optimal => relative_change(&minimum.u, &point.u, least),
                _ => f64::INFINITY,
            }; // step 6
            run.history.push(Iteration {
                error,
                rows: run.gaps.len(),
                projection,
                effort: minimum.effort,
            });
            let ended = self.verdict(&minimum, error, &subproblem, &mut cycles);
            run.accept(minimum);
            if let Some(outcome) = ended {
                run.outcome = outcome;
                return Ok(run);
            }
            let next = anderson.next(&point.u, &run.state.u);
            point.clone_from(&run.state);
            if energy.value(&next).is_finite() {
                point.u = next;
            } else {
                anderson.restart();
            }
        }
        run.outcome = Outcome::IterationLimit;
        Ok(run)
    }

    /// The accuracy asked of the next solve; 0 in the paper's plain iteration, where rows are exact,
    /// and once changes are small.
    fn accuracy(&self, run: &Solution, change: f64) -> f64 {
        let rough = Self::ROUGH_SOLVES.min(self.max_iterations - 1);
        let is_plain = self.acceleration == Acceleration::Plain;
        if is_plain || run.gaps.is_exact() || run.history.len() >= rough {
            return 0.0;
        }
        Self::ROUGH * change.min(Self::CHANGE)
    }

    /// Whether the iteration is over, and why.
    fn verdict(
        &self,
        minimum: &Minimum,
        error: f64,
        subproblem: &Subproblem<'_>,
        cycles: &mut CycleDetector,
    ) -> Option<Outcome> {
        match &minimum.solved {
            Solved::Failed(why) => return Some(Outcome::SubproblemFailed(why.clone())),
            Solved::Interrupted => return Some(Outcome::Interrupted),
            Solved::Optimal => {}
        }
        let is_accurate = subproblem.accuracy == 0.0;
        if is_accurate && (error < self.tolerance || subproblem.gaps.is_exact()) {
            return Some(Outcome::Converged);
        }
        let period = cycles.period(&minimum.u, error)?;
        Some(Outcome::Cycle {
            period,
            amplitude: error,
        })
    }
}

impl Solution {
    /// Nothing solved yet.
    fn at(problem: &dyn ContactProblem, start: State) -> Self {
        Solution {
            outcome: Outcome::InadmissibleStart,
            energy: problem.energy().value(&start.u),
            state: start,
            gaps: LinearGaps::new(false),
            lambda: Vec::new(),
            history: Vec::new(),
        }
    }

    fn accept(&mut self, minimum: Minimum) {
        self.state.u = minimum.u;
        self.state.multipliers = Multipliers::new(&self.gaps, &minimum.lambda);
        self.lambda = minimum.lambda;
        self.energy = minimum.energy;
    }

    /// The sum over the history.
    pub fn effort(&self) -> Effort {
        let mut total = Effort::default();
        for iteration in &self.history {
            total += iteration.effort;
        }
        total
    }
}

/// Notices that the iterates come back to where they were while they keep moving.
#[derive(Default)]
struct CycleDetector {
    /// The latest iterates, newest last.
    recent: VecDeque<Vec<f64>>,
    /// For how many iterations in a row the same period has been seen.
    seen: (usize, usize),
}

impl CycleDetector {
    const LONGEST: usize = 4;
    /// Coming back within this share of the step counts as coming back.
    const CLOSE: f64 = 0.01;
    /// Rounds to watch before it is called a cycle.
    const ROUNDS: usize = 3;

    /// The period, once the iterates have gone round [`Self::ROUNDS`] times.
    fn period(&mut self, u: &[f64], error: f64) -> Option<usize> {
        let returns = |old: &Vec<f64>| relative_change(u, old, 0.0) < Self::CLOSE * error;
        // recent[len − p] is U_{n−p}; p = 1 is the ordinary step and no cycle
        let mut back = self.recent.iter().rev().enumerate().skip(1);
        let period = back.find(|(_, old)| returns(old)).map_or(0, |(k, _)| k + 1);
        self.seen = match self.seen {
            (p, times) if p == period => (p, times + 1),
            _ => (period, 1),
        };
        if self.recent.len() == Self::LONGEST {
            self.recent.pop_front();
        }
        self.recent.push_back(u.to_vec());
        (period > 0 && self.seen.1 >= Self::ROUNDS * period).then_some(period)
    }
}
