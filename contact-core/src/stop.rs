//! What ends a run before its end: a request, shared with the code that may make it, and the run's budget.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::{Error, Interruption};

/// What a run may take. The default has no limit.
///
/// A run that has spent its budget ends as [`Ending::Interrupted`](crate::Ending), with all converged steps kept. The end of
/// its time is seen as a [request](Stop) is, and as late.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Wall time (s) from the start of the run. 0 ends it at once.
    pub seconds: Option<f64>,
    /// Numerical factorisations, counted as by [`Cost::factorizations`](crate::Cost). The one beyond is not begun.
    /// Ipopt's are counted where its linear solver is MUMPS.
    pub factorizations: Option<usize>,
    /// Memory (bytes) beyond what the process has at the start of the run. A run that needs more, by the estimate of
    /// [`Equilibrium::memory`](crate::Equilibrium::memory), is not begun: [`Error::Memory`]. What the system leaves is compared
    /// with the estimate in any case.
    pub memory: Option<u64>,
}

impl Budget {
    /// Checks the settings.
    ///
    /// # Errors
    /// A time that is negative or not finite.
    pub fn validate(&self) -> Result<(), Error> {
        let is_valid = |seconds: &f64| seconds.is_finite() && *seconds >= 0.0;
        match self.seconds {
            Some(seconds) => Error::check_setting(
                is_valid(&seconds),
                "budget.seconds",
                seconds,
                "choose a finite number of seconds from 0, or `None` for no limit",
            ),
            None => Ok(()),
        }
    }
}

/// A request to stop. Clones share it: keep one in a signal handler or another thread and give one to a run. A request
/// stays: a later run with the same token ends at once.
///
/// A run looks at it in every iteration, before each ordering and each factorisation, between the parts of a compliance
/// and, every 20 ms, while it waits for the solve of another thread. Nothing interrupts one ordering, one numerical
/// factorisation, be it sparse or dense, one assembly, or one certificate of a converged step: the longest of them is the
/// longest delay. Searches for contact look where the problem does ([`ContactProblem::watch`](crate::ContactProblem::watch)). `docs/robustness.md` has measured some.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    requested: Arc<AtomicBool>,
    /// Of the runs that it belongs to, the outermost first.
    accounts: Vec<Arc<Account>>,
}

/// What a run has spent of its budget.
#[derive(Debug)]
struct Account {
    budget: Budget,
    /// None where there is no limit, or none that the clock reaches.
    deadline: Option<Instant>,
    /// Factorisations begun. Above the limit, one was refused.
    begun: AtomicUsize,
}

impl Stop {
    /// A token without a request.
    pub fn new() -> Self {
        Stop::default()
    }

    /// Asks the run to stop. It ends at its next look, with all converged steps kept.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Relaxed);
    }

    /// Whether a stop has been requested, or the budget is spent.
    pub fn is_requested(&self) -> bool {
        self.reason().is_some()
    }

    /// Why the run is to end, if it is.
    pub fn reason(&self) -> Option<Interruption> {
        match self.requested.load(Ordering::Relaxed) {
            true => Some(Interruption::Requested),
            false => self.accounts.iter().find_map(|account| account.spent()),
        }
    }

    /// A token for one run, which starts now: it shares the request, and has this `budget` of its own beside those that
    /// the token has already.
    ///
    /// # Errors
    /// As [`Budget::validate`].
    pub fn with_budget(&self, budget: Budget) -> Result<Self, Error> {
        budget.validate()?;
        let mut stop = self.clone();
        if budget != Budget::default() {
            stop.accounts.push(Arc::new(Account::new(budget)));
        }
        Ok(stop)
    }

    /// The memory that the budgets allow (bytes).
    #[cfg(all(feature = "linear", feature = "ipopt"))]
    pub(crate) fn memory(&self) -> Option<u64> {
        let budgets = self.accounts.iter().map(|account| &account.budget);
        budgets.filter_map(|budget| budget.memory).min()
    }

    /// Counts a numerical factorisation that is about to begin. False if it must not.
    pub fn begin_factorization(&self) -> bool {
        !self.is_requested() && self.accounts.iter().all(|account| account.begin())
    }
}

impl Account {
    fn new(budget: Budget) -> Self {
        let time = |seconds| Duration::try_from_secs_f64(seconds).ok();
        let time = budget.seconds.and_then(time);
        Account {
            budget,
            deadline: time.and_then(|time| Instant::now().checked_add(time)),
            begun: AtomicUsize::new(0),
        }
    }

    fn spent(&self) -> Option<Interruption> {
        if let Some(limit) = self.budget.factorizations {
            if self.begun.load(Ordering::Relaxed) > limit {
                return Some(Interruption::Factorizations { limit });
            }
        }
        let seconds = self.budget.seconds?;
        let is_over = |deadline| Instant::now() >= deadline;
        (self.deadline.is_some_and(is_over)).then_some(Interruption::Deadline { seconds })
    }

    fn begin(&self) -> bool {
        let begun = self.begun.fetch_add(1, Ordering::Relaxed);
        self.budget.factorizations.is_none_or(|limit| begun < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorizations(limit: usize) -> Budget {
        Budget {
            factorizations: Some(limit),
            ..Budget::default()
        }
    }

    fn seconds(seconds: f64) -> Budget {
        Budget {
            seconds: Some(seconds),
            ..Budget::default()
        }
    }

    #[test]
    fn a_budget_is_its_runs_own_and_a_request_is_shared() {
        let parent = Stop::new();
        let first = parent.with_budget(factorizations(2)).expect("valid");
        let second = parent.with_budget(factorizations(2)).expect("valid");
        assert!(first.begin_factorization() && first.clone().begin_factorization());
        assert!(!first.is_requested(), "what is begun may end");
        assert!(!first.begin_factorization());
        let why = Interruption::Factorizations { limit: 2 };
        assert_eq!(first.clone().reason(), Some(why));
        assert!(!parent.is_requested() && !second.is_requested());
        first.request();
        assert_eq!(parent.reason(), Some(Interruption::Requested));
        assert!(!second.begin_factorization());
    }

    #[test]
    fn a_run_within_a_run_has_both_budgets() {
        let outer = Stop::new().with_budget(factorizations(1)).expect("valid");
        let inner = outer.with_budget(factorizations(5)).expect("valid");
        assert!(inner.begin_factorization());
        assert!(!inner.begin_factorization());
        assert!(outer.is_requested());
        let late = outer.with_budget(seconds(0.0)).expect("valid");
        assert!(late.is_requested());
    }

    #[test]
    fn times_are_finite_and_may_be_zero_or_too_long_for_the_clock() {
        let stop = Stop::new();
        for refused in [f64::NAN, f64::INFINITY, -1.0, -1e-300] {
            let error = stop.with_budget(seconds(refused)).expect_err("refused");
            let (told, value) = (error.to_string(), format!("{refused:?}"));
            assert!(told.contains(&value) && told.contains("seconds"), "{told}");
        }
        let none = stop.with_budget(seconds(0.0)).expect("valid");
        let why = Interruption::Deadline { seconds: 0.0 };
        assert_eq!(none.reason(), Some(why));
        let ages = stop.with_budget(seconds(f64::MAX)).expect("valid");
        assert!(!ages.is_requested());
    }
}
