// Made by bindgen from the headers of Ipopt 3.14.19; `make bindings` makes it anew.

pub const IPOPT_SHIM_OPTION_UNKNOWN: u32 = 0;
pub const IPOPT_SHIM_OPTION_NUMBER: u32 = 1;
pub const IPOPT_SHIM_OPTION_INTEGER: u32 = 2;
pub const IPOPT_SHIM_OPTION_TEXT: u32 = 3;
pub type ipnumber = f64;
pub type ipindex = ::std::os::raw::c_int;
pub const ApplicationReturnStatus_Solve_Succeeded: ApplicationReturnStatus = 0;
pub const ApplicationReturnStatus_Solved_To_Acceptable_Level: ApplicationReturnStatus = 1;
pub const ApplicationReturnStatus_Infeasible_Problem_Detected: ApplicationReturnStatus = 2;
pub const ApplicationReturnStatus_Search_Direction_Becomes_Too_Small: ApplicationReturnStatus = 3;
pub const ApplicationReturnStatus_Diverging_Iterates: ApplicationReturnStatus = 4;
pub const ApplicationReturnStatus_User_Requested_Stop: ApplicationReturnStatus = 5;
pub const ApplicationReturnStatus_Feasible_Point_Found: ApplicationReturnStatus = 6;
pub const ApplicationReturnStatus_Maximum_Iterations_Exceeded: ApplicationReturnStatus = -1;
pub const ApplicationReturnStatus_Restoration_Failed: ApplicationReturnStatus = -2;
pub const ApplicationReturnStatus_Error_In_Step_Computation: ApplicationReturnStatus = -3;
pub const ApplicationReturnStatus_Maximum_CpuTime_Exceeded: ApplicationReturnStatus = -4;
pub const ApplicationReturnStatus_Maximum_WallTime_Exceeded: ApplicationReturnStatus = -5;
pub const ApplicationReturnStatus_Not_Enough_Degrees_Of_Freedom: ApplicationReturnStatus = -10;
pub const ApplicationReturnStatus_Invalid_Problem_Definition: ApplicationReturnStatus = -11;
pub const ApplicationReturnStatus_Invalid_Option: ApplicationReturnStatus = -12;
pub const ApplicationReturnStatus_Invalid_Number_Detected: ApplicationReturnStatus = -13;
pub const ApplicationReturnStatus_Unrecoverable_Exception: ApplicationReturnStatus = -100;
pub const ApplicationReturnStatus_NonIpopt_Exception_Thrown: ApplicationReturnStatus = -101;
pub const ApplicationReturnStatus_Insufficient_Memory: ApplicationReturnStatus = -102;
pub const ApplicationReturnStatus_Internal_Error: ApplicationReturnStatus = -199;
pub type ApplicationReturnStatus = ::std::os::raw::c_int;
pub const AlgorithmMode_RegularMode: AlgorithmMode = 0;
pub const AlgorithmMode_RestorationPhaseMode: AlgorithmMode = 1;
pub type AlgorithmMode = ::std::os::raw::c_uint;
pub type Number = ipnumber;
pub type Index = ::std::os::raw::c_int;
pub type Int = ::std::os::raw::c_int;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct IpoptProblemInfo {
    _unused: [u8; 0],
}
pub type IpoptProblem = *mut IpoptProblemInfo;
pub type Bool = bool;
pub type UserDataPtr = *mut ::std::os::raw::c_void;
pub type Eval_F_CB = ::std::option::Option<
    unsafe extern "C" fn(
        n: ipindex,
        x: *mut ipnumber,
        new_x: bool,
        obj_value: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> bool,
>;
pub type Eval_Grad_F_CB = ::std::option::Option<
    unsafe extern "C" fn(
        n: ipindex,
        x: *mut ipnumber,
        new_x: bool,
        grad_f: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> bool,
>;
pub type Eval_G_CB = ::std::option::Option<
    unsafe extern "C" fn(
        n: ipindex,
        x: *mut ipnumber,
        new_x: bool,
        m: ipindex,
        g: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> bool,
>;
pub type Eval_Jac_G_CB = ::std::option::Option<
    unsafe extern "C" fn(
        n: ipindex,
        x: *mut ipnumber,
        new_x: bool,
        m: ipindex,
        nele_jac: ipindex,
        iRow: *mut ipindex,
        jCol: *mut ipindex,
        values: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> bool,
>;
pub type Eval_H_CB = ::std::option::Option<
    unsafe extern "C" fn(
        n: ipindex,
        x: *mut ipnumber,
        new_x: bool,
        obj_factor: ipnumber,
        m: ipindex,
        lambda: *mut ipnumber,
        new_lambda: bool,
        nele_hess: ipindex,
        iRow: *mut ipindex,
        jCol: *mut ipindex,
        values: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> bool,
>;
pub type Intermediate_CB = ::std::option::Option<
    unsafe extern "C" fn(
        alg_mod: ipindex,
        iter_count: ipindex,
        obj_value: ipnumber,
        inf_pr: ipnumber,
        inf_du: ipnumber,
        mu: ipnumber,
        d_norm: ipnumber,
        regularization_size: ipnumber,
        alpha_du: ipnumber,
        alpha_pr: ipnumber,
        ls_trials: ipindex,
        user_data: UserDataPtr,
    ) -> bool,
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct ipopt_shim {
    _unused: [u8; 0],
}
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct ipopt_shim_iteration {
    pub restoration: ::std::os::raw::c_int,
    pub iteration: ::std::os::raw::c_int,
    pub objective: f64,
    pub primal_infeasibility: f64,
    pub dual_infeasibility: f64,
    pub mu: f64,
    pub step_norm: f64,
    pub regularization: f64,
    pub alpha_dual: f64,
    pub alpha_primal: f64,
    pub line_search_trials: ::std::os::raw::c_int,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ipopt_shim_iteration"][::std::mem::size_of::<ipopt_shim_iteration>() - 80usize];
    ["Alignment of ipopt_shim_iteration"][::std::mem::align_of::<ipopt_shim_iteration>() - 8usize];
    ["Offset of field: ipopt_shim_iteration::restoration"]
        [::std::mem::offset_of!(ipopt_shim_iteration, restoration) - 0usize];
    ["Offset of field: ipopt_shim_iteration::iteration"]
        [::std::mem::offset_of!(ipopt_shim_iteration, iteration) - 4usize];
    ["Offset of field: ipopt_shim_iteration::objective"]
        [::std::mem::offset_of!(ipopt_shim_iteration, objective) - 8usize];
    ["Offset of field: ipopt_shim_iteration::primal_infeasibility"]
        [::std::mem::offset_of!(ipopt_shim_iteration, primal_infeasibility) - 16usize];
    ["Offset of field: ipopt_shim_iteration::dual_infeasibility"]
        [::std::mem::offset_of!(ipopt_shim_iteration, dual_infeasibility) - 24usize];
    ["Offset of field: ipopt_shim_iteration::mu"]
        [::std::mem::offset_of!(ipopt_shim_iteration, mu) - 32usize];
    ["Offset of field: ipopt_shim_iteration::step_norm"]
        [::std::mem::offset_of!(ipopt_shim_iteration, step_norm) - 40usize];
    ["Offset of field: ipopt_shim_iteration::regularization"]
        [::std::mem::offset_of!(ipopt_shim_iteration, regularization) - 48usize];
    ["Offset of field: ipopt_shim_iteration::alpha_dual"]
        [::std::mem::offset_of!(ipopt_shim_iteration, alpha_dual) - 56usize];
    ["Offset of field: ipopt_shim_iteration::alpha_primal"]
        [::std::mem::offset_of!(ipopt_shim_iteration, alpha_primal) - 64usize];
    ["Offset of field: ipopt_shim_iteration::line_search_trials"]
        [::std::mem::offset_of!(ipopt_shim_iteration, line_search_trials) - 72usize];
};
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct ipopt_shim_callbacks {
    pub user: *mut ::std::os::raw::c_void,
    pub objective: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            x: *const f64,
            new_x: ::std::os::raw::c_int,
            value: *mut f64,
        ) -> ::std::os::raw::c_int,
    >,
    pub gradient: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            x: *const f64,
            new_x: ::std::os::raw::c_int,
            gradient: *mut f64,
        ) -> ::std::os::raw::c_int,
    >,
    pub constraints: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            x: *const f64,
            new_x: ::std::os::raw::c_int,
            g: *mut f64,
        ) -> ::std::os::raw::c_int,
    >,
    pub jacobian: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            x: *const f64,
            new_x: ::std::os::raw::c_int,
            values: *mut f64,
        ) -> ::std::os::raw::c_int,
    >,
    pub hessian: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            x: *const f64,
            new_x: ::std::os::raw::c_int,
            objective_factor: f64,
            lambda: *const f64,
            new_lambda: ::std::os::raw::c_int,
            values: *mut f64,
        ) -> ::std::os::raw::c_int,
    >,
    pub intermediate: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            iteration: *const ipopt_shim_iteration,
        ) -> ::std::os::raw::c_int,
    >,
    pub stops: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            factorizes: ::std::os::raw::c_int,
        ) -> ::std::os::raw::c_int,
    >,
    pub log: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            text: *const ::std::os::raw::c_char,
            length: usize,
        ),
    >,
    pub derivative_check: ::std::option::Option<
        unsafe extern "C" fn(
            user: *mut ::std::os::raw::c_void,
            text: *const ::std::os::raw::c_char,
            length: usize,
        ),
    >,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ipopt_shim_callbacks"][::std::mem::size_of::<ipopt_shim_callbacks>() - 80usize];
    ["Alignment of ipopt_shim_callbacks"][::std::mem::align_of::<ipopt_shim_callbacks>() - 8usize];
    ["Offset of field: ipopt_shim_callbacks::user"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, user) - 0usize];
    ["Offset of field: ipopt_shim_callbacks::objective"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, objective) - 8usize];
    ["Offset of field: ipopt_shim_callbacks::gradient"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, gradient) - 16usize];
    ["Offset of field: ipopt_shim_callbacks::constraints"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, constraints) - 24usize];
    ["Offset of field: ipopt_shim_callbacks::jacobian"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, jacobian) - 32usize];
    ["Offset of field: ipopt_shim_callbacks::hessian"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, hessian) - 40usize];
    ["Offset of field: ipopt_shim_callbacks::intermediate"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, intermediate) - 48usize];
    ["Offset of field: ipopt_shim_callbacks::stops"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, stops) - 56usize];
    ["Offset of field: ipopt_shim_callbacks::log"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, log) - 64usize];
    ["Offset of field: ipopt_shim_callbacks::derivative_check"]
        [::std::mem::offset_of!(ipopt_shim_callbacks, derivative_check) - 72usize];
};
impl Default for ipopt_shim_callbacks {
    fn default() -> Self {
        let mut s = ::std::mem::MaybeUninit::<Self>::uninit();
        unsafe {
            ::std::ptr::write_bytes(s.as_mut_ptr(), 0, 1);
            s.assume_init()
        }
    }
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct ipopt_shim_point {
    pub x: *mut f64,
    pub z_lower: *mut f64,
    pub z_upper: *mut f64,
    pub lambda: *mut f64,
    pub g: *mut f64,
    pub objective: f64,
    pub have_multipliers: ::std::os::raw::c_int,
    pub finalized: ::std::os::raw::c_int,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ipopt_shim_point"][::std::mem::size_of::<ipopt_shim_point>() - 56usize];
    ["Alignment of ipopt_shim_point"][::std::mem::align_of::<ipopt_shim_point>() - 8usize];
    ["Offset of field: ipopt_shim_point::x"][::std::mem::offset_of!(ipopt_shim_point, x) - 0usize];
    ["Offset of field: ipopt_shim_point::z_lower"]
        [::std::mem::offset_of!(ipopt_shim_point, z_lower) - 8usize];
    ["Offset of field: ipopt_shim_point::z_upper"]
        [::std::mem::offset_of!(ipopt_shim_point, z_upper) - 16usize];
    ["Offset of field: ipopt_shim_point::lambda"]
        [::std::mem::offset_of!(ipopt_shim_point, lambda) - 24usize];
    ["Offset of field: ipopt_shim_point::g"][::std::mem::offset_of!(ipopt_shim_point, g) - 32usize];
    ["Offset of field: ipopt_shim_point::objective"]
        [::std::mem::offset_of!(ipopt_shim_point, objective) - 40usize];
    ["Offset of field: ipopt_shim_point::have_multipliers"]
        [::std::mem::offset_of!(ipopt_shim_point, have_multipliers) - 48usize];
    ["Offset of field: ipopt_shim_point::finalized"]
        [::std::mem::offset_of!(ipopt_shim_point, finalized) - 52usize];
};
impl Default for ipopt_shim_point {
    fn default() -> Self {
        let mut s = ::std::mem::MaybeUninit::<Self>::uninit();
        unsafe {
            ::std::ptr::write_bytes(s.as_mut_ptr(), 0, 1);
            s.assume_init()
        }
    }
}
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct ipopt_shim_time {
    pub cpu: f64,
    pub wall: f64,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ipopt_shim_time"][::std::mem::size_of::<ipopt_shim_time>() - 16usize];
    ["Alignment of ipopt_shim_time"][::std::mem::align_of::<ipopt_shim_time>() - 8usize];
    ["Offset of field: ipopt_shim_time::cpu"]
        [::std::mem::offset_of!(ipopt_shim_time, cpu) - 0usize];
    ["Offset of field: ipopt_shim_time::wall"]
        [::std::mem::offset_of!(ipopt_shim_time, wall) - 8usize];
};
#[repr(C)]
#[derive(Debug, Default, Copy, Clone)]
pub struct ipopt_shim_statistics {
    pub available: ::std::os::raw::c_int,
    pub iterations: ::std::os::raw::c_int,
    pub objective_evaluations: ::std::os::raw::c_int,
    pub gradient_evaluations: ::std::os::raw::c_int,
    pub constraint_evaluations: ::std::os::raw::c_int,
    pub jacobian_evaluations: ::std::os::raw::c_int,
    pub hessian_evaluations: ::std::os::raw::c_int,
    pub cpu_time: f64,
    pub wall_time: f64,
    pub dual_infeasibility: f64,
    pub constraint_violation: f64,
    pub complementarity: f64,
    pub kkt_error: f64,
    pub scaled_kkt_error: f64,
    pub timing_available: ::std::os::raw::c_int,
    pub symbolic_factorization: ipopt_shim_time,
    pub factorization: ipopt_shim_time,
    pub back_solve: ipopt_shim_time,
    pub factorizations: ::std::os::raw::c_longlong,
    pub back_solves: ::std::os::raw::c_longlong,
    pub factor_reals: ::std::os::raw::c_longlong,
    pub factor_integers: ::std::os::raw::c_longlong,
    pub pivot_order: ::std::os::raw::c_int,
    pub reallocations: ::std::os::raw::c_int,
    pub workspace_bytes: ::std::os::raw::c_longlong,
}
#[allow(clippy::unnecessary_operation, clippy::identity_op)]
const _: () = {
    ["Size of ipopt_shim_statistics"][::std::mem::size_of::<ipopt_shim_statistics>() - 192usize];
    ["Alignment of ipopt_shim_statistics"]
        [::std::mem::align_of::<ipopt_shim_statistics>() - 8usize];
    ["Offset of field: ipopt_shim_statistics::available"]
        [::std::mem::offset_of!(ipopt_shim_statistics, available) - 0usize];
    ["Offset of field: ipopt_shim_statistics::iterations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, iterations) - 4usize];
    ["Offset of field: ipopt_shim_statistics::objective_evaluations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, objective_evaluations) - 8usize];
    ["Offset of field: ipopt_shim_statistics::gradient_evaluations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, gradient_evaluations) - 12usize];
    ["Offset of field: ipopt_shim_statistics::constraint_evaluations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, constraint_evaluations) - 16usize];
    ["Offset of field: ipopt_shim_statistics::jacobian_evaluations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, jacobian_evaluations) - 20usize];
    ["Offset of field: ipopt_shim_statistics::hessian_evaluations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, hessian_evaluations) - 24usize];
    ["Offset of field: ipopt_shim_statistics::cpu_time"]
        [::std::mem::offset_of!(ipopt_shim_statistics, cpu_time) - 32usize];
    ["Offset of field: ipopt_shim_statistics::wall_time"]
        [::std::mem::offset_of!(ipopt_shim_statistics, wall_time) - 40usize];
    ["Offset of field: ipopt_shim_statistics::dual_infeasibility"]
        [::std::mem::offset_of!(ipopt_shim_statistics, dual_infeasibility) - 48usize];
    ["Offset of field: ipopt_shim_statistics::constraint_violation"]
        [::std::mem::offset_of!(ipopt_shim_statistics, constraint_violation) - 56usize];
    ["Offset of field: ipopt_shim_statistics::complementarity"]
        [::std::mem::offset_of!(ipopt_shim_statistics, complementarity) - 64usize];
    ["Offset of field: ipopt_shim_statistics::kkt_error"]
        [::std::mem::offset_of!(ipopt_shim_statistics, kkt_error) - 72usize];
    ["Offset of field: ipopt_shim_statistics::scaled_kkt_error"]
        [::std::mem::offset_of!(ipopt_shim_statistics, scaled_kkt_error) - 80usize];
    ["Offset of field: ipopt_shim_statistics::timing_available"]
        [::std::mem::offset_of!(ipopt_shim_statistics, timing_available) - 88usize];
    ["Offset of field: ipopt_shim_statistics::symbolic_factorization"]
        [::std::mem::offset_of!(ipopt_shim_statistics, symbolic_factorization) - 96usize];
    ["Offset of field: ipopt_shim_statistics::factorization"]
        [::std::mem::offset_of!(ipopt_shim_statistics, factorization) - 112usize];
    ["Offset of field: ipopt_shim_statistics::back_solve"]
        [::std::mem::offset_of!(ipopt_shim_statistics, back_solve) - 128usize];
    ["Offset of field: ipopt_shim_statistics::factorizations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, factorizations) - 144usize];
    ["Offset of field: ipopt_shim_statistics::back_solves"]
        [::std::mem::offset_of!(ipopt_shim_statistics, back_solves) - 152usize];
    ["Offset of field: ipopt_shim_statistics::factor_reals"]
        [::std::mem::offset_of!(ipopt_shim_statistics, factor_reals) - 160usize];
    ["Offset of field: ipopt_shim_statistics::factor_integers"]
        [::std::mem::offset_of!(ipopt_shim_statistics, factor_integers) - 168usize];
    ["Offset of field: ipopt_shim_statistics::pivot_order"]
        [::std::mem::offset_of!(ipopt_shim_statistics, pivot_order) - 176usize];
    ["Offset of field: ipopt_shim_statistics::reallocations"]
        [::std::mem::offset_of!(ipopt_shim_statistics, reallocations) - 180usize];
    ["Offset of field: ipopt_shim_statistics::workspace_bytes"]
        [::std::mem::offset_of!(ipopt_shim_statistics, workspace_bytes) - 184usize];
};
unsafe extern "C" {
    pub fn CreateIpoptProblem(
        n: ipindex,
        x_L: *mut ipnumber,
        x_U: *mut ipnumber,
        m: ipindex,
        g_L: *mut ipnumber,
        g_U: *mut ipnumber,
        nele_jac: ipindex,
        nele_hess: ipindex,
        index_style: ipindex,
        eval_f: Eval_F_CB,
        eval_g: Eval_G_CB,
        eval_grad_f: Eval_Grad_F_CB,
        eval_jac_g: Eval_Jac_G_CB,
        eval_h: Eval_H_CB,
    ) -> IpoptProblem;
    pub fn FreeIpoptProblem(ipopt_problem: IpoptProblem);
    pub fn AddIpoptStrOption(
        ipopt_problem: IpoptProblem,
        keyword: *mut ::std::os::raw::c_char,
        val: *mut ::std::os::raw::c_char,
    ) -> bool;
    pub fn AddIpoptNumOption(
        ipopt_problem: IpoptProblem,
        keyword: *mut ::std::os::raw::c_char,
        val: ipnumber,
    ) -> bool;
    pub fn AddIpoptIntOption(
        ipopt_problem: IpoptProblem,
        keyword: *mut ::std::os::raw::c_char,
        val: ipindex,
    ) -> bool;
    pub fn OpenIpoptOutputFile(
        ipopt_problem: IpoptProblem,
        file_name: *mut ::std::os::raw::c_char,
        print_level: ::std::os::raw::c_int,
    ) -> bool;
    pub fn SetIpoptProblemScaling(
        ipopt_problem: IpoptProblem,
        obj_scaling: ipnumber,
        x_scaling: *mut ipnumber,
        g_scaling: *mut ipnumber,
    ) -> bool;
    pub fn SetIntermediateCallback(
        ipopt_problem: IpoptProblem,
        intermediate_cb: Intermediate_CB,
    ) -> bool;
    pub fn IpoptSolve(
        ipopt_problem: IpoptProblem,
        x: *mut ipnumber,
        g: *mut ipnumber,
        obj_val: *mut ipnumber,
        mult_g: *mut ipnumber,
        mult_x_L: *mut ipnumber,
        mult_x_U: *mut ipnumber,
        user_data: UserDataPtr,
    ) -> ApplicationReturnStatus;
    pub fn GetIpoptCurrentIterate(
        ipopt_problem: IpoptProblem,
        scaled: bool,
        n: ipindex,
        x: *mut ipnumber,
        z_L: *mut ipnumber,
        z_U: *mut ipnumber,
        m: ipindex,
        g: *mut ipnumber,
        lambda: *mut ipnumber,
    ) -> bool;
    pub fn GetIpoptCurrentViolations(
        ipopt_problem: IpoptProblem,
        scaled: bool,
        n: ipindex,
        x_L_violation: *mut ipnumber,
        x_U_violation: *mut ipnumber,
        compl_x_L: *mut ipnumber,
        compl_x_U: *mut ipnumber,
        grad_lag_x: *mut ipnumber,
        m: ipindex,
        nlp_constraint_violation: *mut ipnumber,
        compl_g: *mut ipnumber,
    ) -> bool;
    pub fn ipopt_shim_create(
        n: ::std::os::raw::c_int,
        m: ::std::os::raw::c_int,
        jacobian_entries: ::std::os::raw::c_int,
        jacobian_rows: *const ::std::os::raw::c_int,
        jacobian_cols: *const ::std::os::raw::c_int,
        hessian_entries: ::std::os::raw::c_int,
        hessian_rows: *const ::std::os::raw::c_int,
        hessian_cols: *const ::std::os::raw::c_int,
    ) -> *mut ipopt_shim;
    pub fn ipopt_shim_free(shim: *mut ipopt_shim);
    pub fn ipopt_shim_set_structure(
        shim: *mut ipopt_shim,
        n: ::std::os::raw::c_int,
        m: ::std::os::raw::c_int,
        jacobian_entries: ::std::os::raw::c_int,
        jacobian_rows: *const ::std::os::raw::c_int,
        jacobian_cols: *const ::std::os::raw::c_int,
        hessian_entries: ::std::os::raw::c_int,
        hessian_rows: *const ::std::os::raw::c_int,
        hessian_cols: *const ::std::os::raw::c_int,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_set_bounds(
        shim: *mut ipopt_shim,
        x_lower: *const f64,
        x_upper: *const f64,
        g_lower: *const f64,
        g_upper: *const f64,
    );
    pub fn ipopt_shim_set_scaling(
        shim: *mut ipopt_shim,
        objective: f64,
        x: *const f64,
        g: *const f64,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_option_type(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_option_range(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
        text: *mut ::std::os::raw::c_char,
        size: usize,
    );
    pub fn ipopt_shim_option_default(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
        number: *mut f64,
        text: *mut ::std::os::raw::c_char,
        size: usize,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_option_name(
        shim: *mut ipopt_shim,
        place: usize,
        name: *mut ::std::os::raw::c_char,
        size: usize,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_clear_options(shim: *mut ipopt_shim);
    pub fn ipopt_shim_set_text(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
        value: *const ::std::os::raw::c_char,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_set_number(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
        value: f64,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_set_integer(
        shim: *mut ipopt_shim,
        name: *const ::std::os::raw::c_char,
        value: ::std::os::raw::c_int,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_solve(
        shim: *mut ipopt_shim,
        callbacks: *const ipopt_shim_callbacks,
        point: *mut ipopt_shim_point,
        statistics: *mut ipopt_shim_statistics,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_current_x(shim: *const ipopt_shim, x: *mut f64) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_current_g(shim: *const ipopt_shim, g: *mut f64) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_current_multipliers(
        shim: *const ipopt_shim,
        z_lower: *mut f64,
        z_upper: *mut f64,
        lambda: *mut f64,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_current_slacks(
        shim: *const ipopt_shim,
        x_lower: *mut f64,
        x_upper: *mut f64,
        s: *mut f64,
        s_lower: *mut f64,
        s_upper: *mut f64,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_current_lagrangian(
        shim: *const ipopt_shim,
        gradient: *mut f64,
        objective_factor: *mut f64,
    ) -> ::std::os::raw::c_int;
    pub fn ipopt_shim_library_version(numbers: *mut ::std::os::raw::c_int)
    -> ::std::os::raw::c_int;
    pub fn ipopt_shim_touch_blas() -> ::std::os::raw::c_int;
}
