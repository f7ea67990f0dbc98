//! How the solves of a sequence start and when one is given up.

#[cfg(doc)]
use super::Sequence;
use super::{Error, OptionValue, Options, Solution, Solver, Status};
use crate::nlp::Structure;

/// How the solves of a [`Sequence`] start and when one is given up.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceSettings {
    /// Options of all solves. Do not set `warm_start_init_point` here: it is set for warm solves.
    pub options: Options,
    /// Options of warm solves, in addition; [`Options::warm_start`] by default.
    pub warm: Options,
    /// A warm solve is stopped and repeated from a cold start beyond this multiple of the iterations of the last cold
    /// solve, but not before [`SequenceSettings::LEAST`] iterations.
    pub blow_up: f64,
    /// A solve that can make no further progress counts as solved if Ipopt's scaled error
    /// ([`Statistics::scaled_error`](super::Statistics::scaled_error)) is at most this; 0 by default.
    pub attainable_error: f64,
}

impl SequenceSettings {
    /// The number of iterations granted to every warm solve.
    pub const LEAST: usize = 20;
}

impl Default for SequenceSettings {
    fn default() -> Self {
        Self {
            options: Options::new(),
            warm: Options::new().warm_start(),
            blow_up: 2.0,
            attainable_error: 0.0,
        }
    }
}

impl SequenceSettings {
    /// A solver for `structure`; the options of both cold and warm solves are checked here.
    pub(super) fn solver(&self, structure: Structure) -> Result<Solver, Error> {
        if self.options.get("warm_start_init_point") == Some(&"yes".into()) {
            return Err(Error::MissingMultipliers);
        }
        let mut solver = Solver::new(structure, &self.options)?;
        solver.set_options(&self.warm_options(None))?;
        Ok(solver)
    }

    pub(super) fn warm_options(&self, cold_iterations: Option<usize>) -> Options {
        let mut options = self.options.clone();
        if let Some(iterations) = cold_iterations {
            let limit = ((self.blow_up * iterations as f64) as usize).max(Self::LEAST);
            let given = match options.get("max_iter") {
                Some(&OptionValue::Integer(given)) => usize::try_from(given).unwrap_or(limit),
                _ => limit,
            };
            options.set("max_iter", limit.min(given));
        }
        options.and(&self.warm)
    }

    pub(super) fn is_solved(&self, solution: &Solution) -> bool {
        match solution.status {
            Status::Solved | Status::FeasiblePointFound => true,
            Status::SolvedToAcceptableLevel | Status::SearchDirectionTooSmall => {
                solution.multipliers.is_some()
                    && solution.statistics.scaled_error <= self.attainable_error
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ipopt::Statistics;
    use crate::nlp::Multipliers;

    /// A solve that is stuck counts as far as its error and its multipliers allow.
    #[test]
    fn what_is_stuck_counts_by_its_error() {
        let settings = SequenceSettings {
            attainable_error: 1e-8,
            ..SequenceSettings::default()
        };
        let solution = |status: Status, scaled_error: f64, has_multipliers: bool| Solution {
            status,
            x: Vec::new(),
            objective: 0.0,
            g: Vec::new(),
            multipliers: has_multipliers.then(Multipliers::default),
            contradiction: None,
            statistics: Statistics {
                scaled_error,
                ..Statistics::default()
            },
            history: Vec::new(),
            derivative_check: None,
            log_error: None,
        };
        for status in [
            Status::SolvedToAcceptableLevel,
            Status::SearchDirectionTooSmall,
        ] {
            for (error, is_solved) in [(0.9e-8, true), (1.1e-8, false), (f64::NAN, false)] {
                assert_eq!(
                    settings.is_solved(&solution(status, error, true)),
                    is_solved
                );
                assert!(!settings.is_solved(&solution(status, error, false)));
            }
        }
        assert!(settings.is_solved(&solution(Status::Solved, 1.0, false)));
        assert!(!settings.is_solved(&solution(Status::IterationLimit, 0.0, true)));
    }
}
