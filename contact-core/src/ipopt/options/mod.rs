//! Ipopt's options: typed or by name, and in order.

mod apply;
mod check;
mod file;
mod hint;
mod known;
mod order;
mod refused;
mod table;
mod value;
mod words;

pub(super) use self::{
    apply::{apply, apply_one, default_of, names},
    order::orders,
};
pub use self::{
    known::{DefaultValue, KnownOption},
    table::KNOWN_OPTIONS,
    value::{OptionError, OptionValue},
    words::*,
};
#[cfg(doc)]
use crate::nlp::Structure;

/// Options to set, in order. All others keep the driver's default or, where it has none, Ipopt's.
///
/// ```
/// use contact_core::ipopt::{MuStrategy, Options};
/// let options = Options::new()
///     .tol(1e-9)
///     .max_iter(200)
///     .mu_strategy(MuStrategy::Adaptive)
///     .with("quality_function_max_section_steps", 12); // by name: every option Ipopt has
/// assert_eq!(options.get("max_iter"), Some(&200.into()));
/// ```
///
/// Each setter puts its value in place of an earlier one; the names and values are checked when a
/// [`Solver`](super::Solver) takes them.
///
/// The driver's defaults, all of which can be changed:
///
/// | option | value | why |
/// |---|---|---|
/// | `option_file_name` | `""` | a file `ipopt.opt` in the working directory must not change results unnoticed; [`Options::read`] reads one |
/// | `print_level`, `sb` | 0, `yes` | no log unless requested |
/// | `bound_relax_factor` | 0 | Ipopt's default of 1e-8 would be a real penetration |
/// | `honor_original_bounds` | `no` | x, f and g belong together; before 3.14 Ipopt moves x alone |
/// | `mumps_mem_percent` | 200 | 1000 (Ipopt's) estimates eleven times the workspace, 50 too little: factorisations are repeated |
/// | `mumps_pivot_order` | above 10 000 variables: 4 (PORD) if the Hessian has 15 entries a variable, else 2 (AMF); above 20 000 with 15 to 31 entries a variable: 5 (METIS). 2 in place of 3, 4 and 5, also where they are set, if nearly every free variable is linked with every other | small factors in space; fast analysis in the plane; PORD ends the process where all unknowns have the same neighbours |
/// | `hessian_approximation` | `limited-memory` without a Hessian | |
/// | `hessian_constant`, `jac_c_constant`, `jac_d_constant` | as [`Structure`] promises | evaluated once |
/// | `warm_start_init_point` | `yes` for a start with multipliers | they would be ignored |
/// | `timing_statistics` | `yes` where there is one | [`Statistics`](super::Statistics) |
/// | `resto.mehrotra_algorithm` | `no` | Ipopt crashes with it in the restoration phase |
///
/// What would make Ipopt end the process, or return something else than a solution, is refused:
/// [`OptionError::Refused`] says why. That is `option_file_name`, `skip_finalize_solution_call`,
/// `check_derivatives_for_naninf` (every value of every function is checked before Ipopt sees it),
/// `dependency_detector`, `jacobian_approximation`, `nlp_scaling_constr_target_gradient`, `warm_start_target_mu`, a
/// `bound_mult_init_method` of "mu-based", a `slack_move` of 0, a `limited_memory_max_history` of 0 or above 1000, an `output_file`, which overwrites any other, and
/// numbers of steps between two iterates without bound. An option that
/// neither Ipopt 3.11.9 nor 3.14.19 registers is refused, too: all of theirs were tried, with random values.
///
/// With the prefix `resto.`, as in `resto.max_iter`, an option is for the restoration phase alone. There is no other
/// prefix.
///
/// Numbers must be finite and between −1e30 and 1e30, the largest of Ipopt's defaults: some larger ones make Ipopt
/// crash or iterate without end. Exceptions are `max_cpu_time` and `max_wall_time`, up to ∞ for no limit, and
/// `nlp_lower_bound_inf` and `nlp_upper_bound_inf`, ±∞ for bounds of any size, and beyond ±1e6. Ipopt keeps six digits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    entries: Vec<(String, OptionValue)>,
}

impl Options {
    /// The driver's default of `mumps_mem_percent`.
    pub(crate) const MEMORY_PERCENT: i32 = 200;

    /// None set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets one, in place of an earlier value. Names and values are checked by the solver; words may be in any case.
    pub fn set(&mut self, name: &str, value: impl Into<OptionValue>) -> &mut Self {
        let value = check::normalized(name, value.into());
        match self.entries.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.entries.push((name.to_owned(), value)),
        }
        self
    }

    /// Sets one, as [`Options::set`].
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<OptionValue>) -> Self {
        self.set(name, value);
        self
    }

    /// These, and on top of them `others`.
    #[must_use]
    pub fn and(mut self, others: &Options) -> Self {
        for (name, value) in others.iter() {
            self.set(name, value.clone());
        }
        self
    }

    /// What was set for `name`.
    pub fn get(&self, name: &str) -> Option<&OptionValue> {
        self.entries
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }

    /// All that were set, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &OptionValue)> {
        self.entries
            .iter()
            .map(|(name, value)| (name.as_str(), value))
    }

    /// Newton's method: the exact Hessian, without which a structure is refused. This is the default for one that has
    /// it. This and the presets below set only what is not set yet.
    #[must_use]
    pub fn newton(mut self) -> Self {
        self.set_if_unset("hessian_approximation", HessianApproximation::Exact);
        self
    }

    /// A limited-memory quasi-Newton method: the least change of an approximate Hessian over the last `history`
    /// iterations (6 are Ipopt's, and 0 is refused). No Hessian is asked for, even of a structure that has one.
    #[must_use]
    pub fn least_change(mut self, history: usize, update: LimitedMemoryUpdate) -> Self {
        self.set_if_unset("hessian_approximation", HessianApproximation::LimitedMemory);
        self.set_if_unset("limited_memory_max_history", history);
        self.set_if_unset("limited_memory_update_type", update);
        self.set_if_unset("hessian_constant", false);
        self
    }

    /// For quadratic f and linear g: Hessian and Jacobian are asked for once. A [`Structure`] that promises as much
    /// needs no preset.
    #[must_use]
    pub fn quadratic(mut self) -> Self {
        for name in ["hessian_constant", "jac_c_constant", "jac_d_constant"] {
            self.set_if_unset(name, true);
        }
        self
    }

    /// For a start close to the solution, with its multipliers: adaptive μ, and pushes from the bounds small enough
    /// not to spoil it. Sets only what is not set yet.
    #[must_use]
    pub fn warm_start(mut self) -> Self {
        self.set_if_unset("mu_strategy", "adaptive");
        for name in [
            "warm_start_bound_push",
            "warm_start_bound_frac",
            "warm_start_slack_bound_push",
            "warm_start_slack_bound_frac",
            "warm_start_mult_bound_push",
        ] {
            self.set_if_unset(name, 1e-9);
        }
        self
    }

    /// For convex quadratic problems: Mehrotra's predictor–corrector. It has no safeguards: keep a fallback, and
    /// look at the [`Status`](super::Status). The start is not used: x starts from least squares. Combines
    /// with [`Options::quadratic`].
    #[must_use]
    pub fn convex_quadratic(mut self) -> Self {
        self.set_if_unset("mehrotra_algorithm", "yes");
        self
    }

    fn set_if_unset(&mut self, name: &str, value: impl Into<OptionValue>) {
        if self.get(name).is_none() {
            self.set(name, value);
        }
    }
}
