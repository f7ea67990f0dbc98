//! The options with typed setters, one line each.

use super::{DefaultValue, KnownOption, Options, known::Setting, words::*};

/// `name: type = Type(default), before "version" old default, since "version";` makes the setter, the row of the
/// table in the docs and the entry of [`KNOWN_OPTIONS`].
macro_rules! options {
    ($($(#[doc = $doc:literal])+ $name:ident: $argument:ty = $kind:ident($default:literal)
        $(, before $changed:literal $old:literal)? $(, since $since:literal)?;)+) => {
        /// # Ipopt's options
        /// Named as Ipopt names them; its [manual](https://coin-or.github.io/Ipopt/OPTIONS.html) says more of each.
        /// The table is [`KNOWN_OPTIONS`]; [`Options::set`] takes what is not in it.
        impl Options {$(
            $(#[doc = $doc])+
            #[doc = ""]
            #[doc = concat!(
                "Ipopt's default: `", stringify!($default), "`"
                $(, ", before ", $changed, " `", stringify!($old), "`")?
                $(, ". Since ", $since)?, "."
            )]
            #[must_use]
            pub fn $name(self, value: $argument) -> Self {
                self.with(stringify!($name), value)
            }
        )+}

        /// The options with typed setters: name, type, Ipopt's default, and the version they came with, if not all
        /// since 3.11 have them.
        ///
        /// | option | type | Ipopt's default | since |
        /// |---|---|---|---|
        $(
            #[doc = concat!(
                "| [`", stringify!($name), "`](Options::", stringify!($name), ") | `", stringify!($argument), "` | `",
                stringify!($default), "`" $(, ", before ", $changed, " `", stringify!($old), "`")?, " | "
                $(, $since)?, " |"
            )]
        )+
        pub const KNOWN_OPTIONS: &[KnownOption] = &[$(KnownOption {
            name: stringify!($name),
            default: DefaultValue::$kind($default),
            before: options!(@optional $(($changed, DefaultValue::$kind($old)))?),
            since: options!(@optional $($since)?),
            words: <$argument as Setting>::WORDS,
        }),+];
    };
    (@optional) => { None };
    (@optional $value:expr) => { Some($value) };
}

options! {
    /// Error of the scaled optimality conditions at which the solve ends.
    tol: f64 = Number(1e-8);
    /// Iterations before the solve is given up. This and the limits of time are looked at between iterations only.
    max_iter: usize = Integer(3000);
    /// Seconds of processor time before the solve is given up; ∞ for no limit.
    max_cpu_time: f64 = Number(1e20), before "3.14.0" 1e6;
    /// Seconds before the solve is given up; ∞ for no limit.
    max_wall_time: f64 = Number(1e20), since "3.14.0";
    /// Largest ∇L, max-norm, unscaled, at which the solve may end.
    dual_inf_tol: f64 = Number(1.0);
    /// Largest constraint violation, max-norm, unscaled, at which the solve may end.
    constr_viol_tol: f64 = Number(1e-4);
    /// Largest complementarity, max-norm, unscaled, at which the solve may end.
    compl_inf_tol: f64 = Number(1e-4);
    /// As `tol`, for an acceptable point.
    acceptable_tol: f64 = Number(1e-6);
    /// Acceptable points in a row that end the solve; 0 for never.
    acceptable_iter: usize = Integer(15);
    /// As `dual_inf_tol`, for an acceptable point.
    acceptable_dual_inf_tol: f64 = Number(1e10);
    /// As `constr_viol_tol`, for an acceptable point.
    acceptable_constr_viol_tol: f64 = Number(1e-2);
    /// As `compl_inf_tol`, for an acceptable point.
    acceptable_compl_inf_tol: f64 = Number(1e-2);
    /// Relative change of f below which a point is acceptable.
    acceptable_obj_change_tol: f64 = Number(1e20);
    /// |xᵢ| at which the iterates count as diverging.
    diverging_iterates_tol: f64 = Number(1e20);
    /// Multipliers of this average size are scaled down in the error that `tol` bounds.
    s_max: f64 = Number(100.0);
    /// The complementarity to stop at, instead of 0: a point of the central path.
    mu_target: f64 = Number(0.0);

    /// How much of the log there is, 0 to 12: 0 nothing, 3 a summary, 5 a line an iteration, more for those who debug
    /// Ipopt. See [`Log`](crate::ipopt::Log) for where it goes, and for this driver's default.
    print_level: i32 = Integer(5);
    /// No banner.
    sb: bool = Text("no");
    /// Iterations a line of the log.
    print_frequency_iter: usize = Integer(1);
    /// Seconds a line of the log, at least.
    print_frequency_time: f64 = Number(0.0);
    /// One more column in the log.
    print_info_string: bool = Text("no");
    /// Where the time went, in the log.
    print_timing_statistics: bool = Text("no");
    /// The options that were set, in the log.
    print_user_options: bool = Text("no");
    /// Which constraint violation the log shows.
    inf_pr_output: InfPrOutput = Text("original");
    /// Times of the parts of the algorithm are taken; this driver's default is `true`.
    timing_statistics: bool = Text("no"), since "3.14.0";

    /// Factor on f inside Ipopt; not 0; negative to maximise, which [reverses the multipliers' signs](crate::ipopt::Scaling).
    obj_scaling_factor: f64 = Number(1.0);
    /// How the problem is scaled.
    nlp_scaling_method: NlpScalingMethod = Text("gradient-based");
    /// Gradients above this at the start are scaled down to it.
    nlp_scaling_max_gradient: f64 = Number(100.0);
    /// Size of ∇f at the start after scaling; 0 for what `nlp_scaling_max_gradient` says.
    nlp_scaling_obj_target_gradient: f64 = Number(0.0);
    /// Smallest factor of gradient-based scaling.
    nlp_scaling_min_value: f64 = Number(1e-8);

    /// Bounds are relaxed by this, relative to their size; this driver's default is 0.
    bound_relax_factor: f64 = Number(1e-8);
    /// The solution is projected to the bounds as they were; this driver's default is `false`.
    honor_original_bounds: bool = Text("no"), before "3.14.0" "yes";
    /// What becomes of variables with equal bounds.
    fixed_variable_treatment: FixedVariableTreatment = Text("make_parameter");
    /// Lower bounds up to this are none; −∞ to have all of them.
    nlp_lower_bound_inf: f64 = Number(-1e19);
    /// Upper bounds from this are none; ∞ to have all of them.
    nlp_upper_bound_inf: f64 = Number(1e19);
    /// Weight of the linear damping of variables with one bound.
    kappa_d: f64 = Number(1e-5);
    /// ∂²L/∂x² depends on nothing and is asked for once; this driver's default is as the structure promises.
    hessian_constant: bool = Text("no");
    /// f is linear: its gradient is asked for once.
    grad_f_constant: bool = Text("no"), since "3.14.10";
    /// The equalities are linear: their Jacobian is asked for once. The driver's default is as above.
    jac_c_constant: bool = Text("no");
    /// The inequalities are linear: their Jacobian is asked for once. The driver's default is as above.
    jac_d_constant: bool = Text("no");

    /// Least distance of the start from a bound, absolute.
    bound_push: f64 = Number(0.01);
    /// Least distance of the start from a bound, relative to the distance of the bounds.
    bound_frac: f64 = Number(0.01);
    /// As `bound_push`, for slacks.
    slack_bound_push: f64 = Number(0.01);
    /// As `bound_frac`, for slacks.
    slack_bound_frac: f64 = Number(0.01);
    /// What the multipliers of bounds start from.
    bound_mult_init_val: f64 = Number(1.0);
    /// Multipliers of constraints start from least squares, or from 0 if those exceed this.
    constr_mult_init_max: f64 = Number(1000.0);
    /// All multipliers start from least squares.
    least_square_init_duals: bool = Text("no");
    /// x starts from the least-squares solution of the linearised constraints.
    least_square_init_primal: bool = Text("no");

    /// The start has multipliers to be used; this driver's default is whether it does.
    warm_start_init_point: bool = Text("no");
    /// As `bound_push`, for warm starts.
    warm_start_bound_push: f64 = Number(1e-3);
    /// As `bound_frac`, for warm starts.
    warm_start_bound_frac: f64 = Number(1e-3);
    /// As `slack_bound_push`, for warm starts.
    warm_start_slack_bound_push: f64 = Number(1e-3);
    /// As `slack_bound_frac`, for warm starts.
    warm_start_slack_bound_frac: f64 = Number(1e-3);
    /// Least multiplier of a bound in a warm start.
    warm_start_mult_bound_push: f64 = Number(1e-3);
    /// Largest multiplier of a constraint in a warm start.
    warm_start_mult_init_max: f64 = Number(1e6);

    /// How the barrier parameter μ decreases.
    mu_strategy: MuStrategy = Text("monotone");
    /// What chooses μ in the adaptive strategy.
    mu_oracle: MuOracle = Text("quality-function");
    /// What chooses μ when the adaptive strategy falls back to the monotone mode.
    fixed_mu_oracle: FixedMuOracle = Text("average_compl");
    /// What makes the adaptive strategy converge globally.
    adaptive_mu_globalization: AdaptiveMuGlobalization = Text("obj-constr-filter");
    /// μ to begin with.
    mu_init: f64 = Number(0.1);
    /// Largest μ of the adaptive strategy, relative to the first complementarity.
    mu_max_fact: f64 = Number(1000.0);
    /// Largest μ of the adaptive strategy.
    mu_max: f64 = Number(1e5);
    /// Smallest μ of the adaptive strategy.
    mu_min: f64 = Number(1e-11);
    /// μ decreases by this factor at least, in the monotone strategy.
    mu_linear_decrease_factor: f64 = Number(0.2);
    /// μ decreases to this power of itself at most, in the monotone strategy.
    mu_superlinear_decrease_power: f64 = Number(1.5);
    /// A barrier problem is solved to this times μ.
    barrier_tol_factor: f64 = Number(10.0);
    /// Several decreases of μ in one iteration are allowed.
    mu_allow_fast_monotone_decrease: bool = Text("yes");
    /// A step keeps 1 − τ of the distance to the bounds; this is the least τ.
    tau_min: f64 = Number(0.99);
    /// Smallest centring parameter of the quality function.
    sigma_min: f64 = Number(1e-6);
    /// Largest centring parameter of the quality function.
    sigma_max: f64 = Number(100.0);

    /// What the line search asks of a step.
    line_search_method: LineSearchMethod = Text("filter");
    /// The step length of the constraints' multipliers.
    alpha_for_y: AlphaForY = Text("primal");
    /// Every first trial step is taken: no line search at all.
    accept_every_trial_step: bool = Text("no");
    /// Trial steps after which one is taken whatever it does; −1 for never.
    accept_after_max_steps: i32 = Integer(-1);
    /// Second-order corrections an iteration; 0 for none.
    max_soc: usize = Integer(4);
    /// Shortened steps in a row before the watchdog takes a full one; 0 for no watchdog.
    watchdog_shortened_iter_trigger: usize = Integer(10);
    /// Orders of magnitude f may increase in a step.
    obj_max_inc: f64 = Number(5.0);
    /// Multipliers of constraints are recomputed by least squares where the violation is small.
    recalc_y: bool = Text("no");
    /// The violation for that.
    recalc_y_feas_tol: f64 = Number(1e-6);
    /// Relative step below which a solve cannot go on.
    tiny_step_tol: f64 = Number(2.220446049250313e-15);
    /// Change of multipliers below which a solve that cannot go on ends.
    tiny_step_y_tol: f64 = Number(0.01);

    /// Mehrotra's predictor–corrector: no safeguards, for convex quadratic problems only.
    mehrotra_algorithm: bool = Text("no");
    /// One step of iterative refinement at most, and no check of the linear system.
    fast_step_computation: bool = Text("no");
    /// Least steps of iterative refinement.
    min_refinement_steps: usize = Integer(1);
    /// Most steps of iterative refinement.
    max_refinement_steps: usize = Integer(10);
    /// First multiple of the identity that is added to an indefinite Hessian.
    first_hessian_perturbation: f64 = Number(1e-4);
    /// Smallest multiple of the identity that is added.
    min_hessian_perturbation: f64 = Number(1e-20);
    /// Multiple of the identity at which Ipopt gives up.
    max_hessian_perturbation: f64 = Number(1e20);
    /// Added to the rows of a rank-deficient Jacobian.
    jacobian_regularization_value: f64 = Number(1e-8);

    /// Infeasible problems are to be found out early.
    expect_infeasible_problem: bool = Text("no");
    /// The solve starts in the restoration phase.
    start_with_resto: bool = Text("no");
    /// Share of the infeasibility with which the restoration phase may end.
    required_infeasibility_reduction: f64 = Number(0.9);
    /// Iterations in a row in the restoration phase.
    max_resto_iter: usize = Integer(3_000_000);
    /// Weight of the infeasibility in the restoration phase.
    resto_penalty_parameter: f64 = Number(1000.0);

    /// What solves the linear systems. An Ipopt that is linked with HSL has `ma27` as its default.
    linear_solver: LinearSolver = Text("mumps");
    /// How the linear systems are scaled.
    linear_system_scaling: LinearSystemScaling = Text("none");
    /// Per cent of workspace beyond MUMPS' estimate; this driver's default is 200.
    mumps_mem_percent: usize = Integer(1000);
    /// Ordering: 0 AMD, 2 AMF, 3 SCOTCH, 4 PORD, 5 METIS, 6 QAMD, 7 MUMPS' choice. The driver's default for
    /// more than 10 000 variables is 4 if the Hessian has 15 entries a variable, else 2; 5 for more than 20 000 with 15
    /// to 31 entries a variable.
    mumps_pivot_order: i32 = Integer(7);
    /// Permutation and scaling before the analysis, 0 to 7.
    mumps_permuting_scaling: i32 = Integer(7);
    /// Scaling, −2 to 77.
    mumps_scaling: i32 = Integer(77);
    /// Relative pivot threshold.
    mumps_pivtol: f64 = Number(1e-6);
    /// Largest pivot threshold, where more accuracy is wanted.
    mumps_pivtolmax: f64 = Number(0.1);
    /// How much MUMPS prints, on standard output.
    mumps_print_level: i32 = Integer(0), since "3.14.8";
    /// Relative pivot threshold of MA27.
    ma27_pivtol: f64 = Number(1e-8);
    /// Relative pivot threshold of MA57.
    ma57_pivtol: f64 = Number(1e-8);

    /// Where ∂²L/∂x² comes from; this driver's default is `LimitedMemory` for a structure without a Hessian.
    hessian_approximation: HessianApproximation = Text("exact");
    /// In which variables the Hessian is approximated.
    hessian_approximation_space: HessianApproximationSpace = Text("nonlinear-variables");
    /// Iterations that a limited-memory approximation remembers, at least 1.
    limited_memory_max_history: usize = Integer(6);
    /// The update of a limited-memory approximation.
    limited_memory_update_type: LimitedMemoryUpdate = Text("bfgs");
    /// The matrix a limited-memory approximation starts from.
    limited_memory_initialization: LimitedMemoryInitialization = Text("scalar1");
    /// Its value for `Constant`.
    limited_memory_init_val: f64 = Number(1.0);
    /// Updates skipped in a row before the memory is cleared.
    limited_memory_max_skipping: usize = Integer(2);

    /// Which derivatives are compared with finite differences before the solve; the result is
    /// [`Solution::derivative_check`](crate::ipopt::Solution::derivative_check).
    derivative_test: DerivativeTest = Text("none");
    /// Relative step of the differences.
    derivative_test_perturbation: f64 = Number(1e-8);
    /// Relative error from which a derivative counts as wrong.
    derivative_test_tol: f64 = Number(1e-4);
    /// All derivatives are logged, not only the wrong ones.
    derivative_test_print_all: bool = Text("no");
    /// The first variable or, for second derivatives, constraint that is tested; −2 for all, −1 for f.
    derivative_test_first_index: i32 = Integer(-2);
    /// The test is made at a random point up to this far from the start, within the bounds; 0 for the start itself.
    point_perturbation_radius: f64 = Number(10.0);
}
