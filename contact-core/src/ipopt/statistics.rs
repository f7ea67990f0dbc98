//! Cost and accuracy of a solve.

use std::{fmt, time::Duration};

use ipopt_sys as sys;

/// Seconds of processor and of wall clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Time {
    /// Processor time in seconds.
    pub cpu: f64,
    /// Wall-clock time in seconds.
    pub wall: f64,
}

/// Calls of one function of an [`Nlp`](crate::nlp::Nlp).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CallbackStatistics {
    /// How often it was called.
    pub calls: usize,
    /// Its time.
    pub time: Duration,
}

/// Cost and accuracy of a solve.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Statistics {
    /// Iterations, those of the restoration phase included.
    pub iterations: usize,
    /// Calls of `objective`.
    pub objective: CallbackStatistics,
    /// Calls of `gradient`.
    pub gradient: CallbackStatistics,
    /// Calls of `constraints`.
    pub constraints: CallbackStatistics,
    /// Calls of `jacobian`.
    pub jacobian: CallbackStatistics,
    /// Calls of `hessian`.
    pub hessian: CallbackStatistics,
    /// Of the whole solve, callbacks included.
    pub total: Time,
    /// Symbolic analysis, once per solve. Measured around the calls of MUMPS; as reported by Ipopt for another linear solver.
    /// `None` if Ipopt did not get that far.
    pub symbolic_factorization: Option<Time>,
    /// Numerical factorisations.
    pub factorization: Option<Time>,
    /// Back solves.
    pub back_solve: Option<Time>,
    /// Numerical factorisations; more than iterations where the Hessian had to be regularised or MUMPS wanted more
    /// memory. `None` with another linear solver than MUMPS, whose messages are what is counted.
    pub factorizations: Option<usize>,
    /// Right-hand sides solved for, iterative refinement included; `None` as above.
    pub back_solves: Option<usize>,
    /// Numbers stored in the last factor; `None` as above.
    pub factor_entries: Option<u64>,
    /// Ordering and memory of MUMPS; `None` with another linear solver, or without a factorisation.
    pub mumps: Option<MumpsUse>,
    /// ∇L, max-norm, unscaled. NaN here and below if Ipopt ended without a final point.
    pub dual_infeasibility: f64,
    /// Violation of the constraints, max-norm, unscaled.
    pub constraint_violation: f64,
    /// Complementarity, max-norm, unscaled.
    pub complementarity: f64,
    /// Ipopt's error of the scaled problem, the number `tol` bounds.
    pub scaled_error: f64,
}

/// Ordering and memory of MUMPS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct MumpsUse {
    /// The ordering used: the one requested, or its replacement if MUMPS lacks that.
    pub ordering: Ordering,
    /// Bytes of the last factor, indices included.
    pub factor_bytes: u64,
    /// Bytes allocated in the first factorisation, from an estimate raised by `mumps_mem_percent`. Simultaneous
    /// allocations of other threads are included; `None` where the system does not report them (glibc from 2.33 does).
    pub workspace_bytes: Option<u64>,
    /// How often the workspace was too small, and a factorisation was repeated with more.
    pub reallocations: usize,
}

/// The order in which MUMPS eliminates unknowns: its ICNTL(7), Ipopt's option `mumps_pivot_order`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ordering {
    /// 0: approximate minimum degree.
    Amd,
    /// 1: given by the caller; Ipopt does not use it.
    Given,
    /// 2: approximate minimum fill.
    Amf,
    /// 3: nested dissection by SCOTCH.
    Scotch,
    /// 4: PORD.
    Pord,
    /// 5: nested dissection by METIS.
    Metis,
    /// 6: approximate minimum degree with detection of quasi-dense rows.
    Qamd,
    /// 7: MUMPS chooses among those it was built with.
    Automatic,
    /// A number this crate does not know.
    Other(i32),
}

impl Ordering {
    /// From MUMPS' number.
    pub fn from_code(code: i32) -> Self {
        match code {
            0 => Self::Amd,
            1 => Self::Given,
            2 => Self::Amf,
            3 => Self::Scotch,
            4 => Self::Pord,
            5 => Self::Metis,
            6 => Self::Qamd,
            7 => Self::Automatic,
            other => Self::Other(other),
        }
    }

    /// Its name in print.
    pub fn name(self) -> &'static str {
        match self {
            Self::Amd => "AMD",
            Self::Given => "given",
            Self::Amf => "AMF",
            Self::Scotch => "SCOTCH",
            Self::Pord => "PORD",
            Self::Metis => "METIS",
            Self::Qamd => "QAMD",
            Self::Automatic => "automatic",
            Self::Other(_) => "unknown",
        }
    }

    /// MUMPS' number.
    pub fn code(self) -> i32 {
        match self {
            Self::Amd => 0,
            Self::Given => 1,
            Self::Amf => 2,
            Self::Scotch => 3,
            Self::Pord => 4,
            Self::Metis => 5,
            Self::Qamd => 6,
            Self::Automatic => 7,
            Self::Other(code) => code,
        }
    }
}

impl fmt::Display for Ordering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Statistics {
    /// Without any of Ipopt's numbers.
    pub(super) fn unknown() -> Self {
        Self {
            total: Time {
                cpu: f64::NAN,
                wall: 0.0,
            },
            dual_infeasibility: f64::NAN,
            constraint_violation: f64::NAN,
            complementarity: f64::NAN,
            scaled_error: f64::NAN,
            ..Self::default()
        }
    }

    /// Time in the functions of the problem.
    pub fn evaluation_time(&self) -> Duration {
        [
            self.objective,
            self.gradient,
            self.constraints,
            self.jacobian,
            self.hessian,
        ]
        .iter()
        .map(|f| f.time)
        .sum()
    }

    pub(super) fn read(
        &mut self,
        raw: &sys::ipopt_shim_statistics,
        iterations: usize,
        wall: Duration,
    ) {
        let time = |time: sys::ipopt_shim_time| {
            (raw.timing_available != 0).then_some(Time {
                cpu: time.cpu,
                wall: time.wall,
            })
        };
        self.symbolic_factorization = time(raw.symbolic_factorization);
        self.factorization = time(raw.factorization);
        self.back_solve = time(raw.back_solve);
        self.factorizations = usize::try_from(raw.factorizations).ok();
        self.back_solves = usize::try_from(raw.back_solves).ok();
        self.factor_entries = u64::try_from(raw.factor_reals).ok();
        self.mumps = MumpsUse::read(raw);
        let available = raw.available != 0;
        let or_nan = |value: f64| if available { value } else { f64::NAN };
        self.iterations = usize::try_from(raw.iterations)
            .ok()
            .filter(|_| available)
            .unwrap_or(iterations);
        self.total = Time {
            cpu: or_nan(raw.cpu_time),
            wall: wall.as_secs_f64(),
        };
        self.dual_infeasibility = or_nan(raw.dual_infeasibility);
        self.constraint_violation = or_nan(raw.constraint_violation);
        self.complementarity = or_nan(raw.complementarity);
        self.scaled_error = or_nan(raw.scaled_kkt_error);
    }
}

impl MumpsUse {
    fn read(raw: &sys::ipopt_shim_statistics) -> Option<Self> {
        let (reals, integers) = (raw.factor_reals, raw.factor_integers);
        Some(Self {
            ordering: Ordering::from_code(raw.pivot_order),
            factor_bytes: 8 * u64::try_from(reals).ok()? + 4 * u64::try_from(integers).ok()?,
            workspace_bytes: u64::try_from(raw.workspace_bytes).ok(),
            reallocations: usize::try_from(raw.reallocations).ok()?,
        })
    }
}
