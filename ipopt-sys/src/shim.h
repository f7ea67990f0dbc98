/* What Ipopt's C interface leaves out, behind a C interface of its own.
 *
 * All functions catch every C++ exception. Indices count from 0. A handle may move between threads, but Ipopt with
 * MUMPS is not reentrant: at most one ipopt_shim_solve at a time in a process. The other functions share nothing
 * between handles, and may run meanwhile.
 */
#ifndef IPOPT_SHIM_H
#define IPOPT_SHIM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A problem's structure and bounds, and the options it is solved with. */
typedef struct ipopt_shim ipopt_shim;

/** What Ipopt says of an iteration; `restoration` is 1 in the restoration phase. */
typedef struct ipopt_shim_iteration {
    int restoration;
    int iteration;
    double objective;
    double primal_infeasibility;
    double dual_infeasibility;
    double mu;
    double step_norm;
    double regularization;
    double alpha_dual;
    double alpha_primal;
    int line_search_trials;
} ipopt_shim_iteration;

/** The problem's functions. Each returns 0 when it fails; `intermediate` returns 0 to stop.
 *  None may unwind. Should Ipopt want a value, or log, while `intermediate` reads an iterate, that is a call inside
 *  `intermediate`; versions up to 3.14.19 have all values by then. `log` may be NULL: then no text is made at all.
 *  `derivative_check` gets what Ipopt's derivative checker says, whatever `print_level` is; it may be NULL too.
 *  `stops` is asked before each call of MUMPS, and told whether that factorises: the solve ends as stopped by the user
 *  where it does not return 0. It may be NULL as well. */
typedef struct ipopt_shim_callbacks {
    void *user;
    int (*objective)(void *user, const double *x, int new_x, double *value);
    int (*gradient)(void *user, const double *x, int new_x, double *gradient);
    int (*constraints)(void *user, const double *x, int new_x, double *g);
    int (*jacobian)(void *user, const double *x, int new_x, double *values);
    int (*hessian)(void *user, const double *x, int new_x, double objective_factor, const double *lambda,
                   int new_lambda, double *values);
    int (*intermediate)(void *user, const ipopt_shim_iteration *iteration);
    int (*stops)(void *user, int factorizes);
    void (*log)(void *user, const char *text, size_t length);
    void (*derivative_check)(void *user, const char *text, size_t length);
} ipopt_shim_callbacks;

/** In: the starting point, with multipliers where `have_multipliers`. Out: the final point, where `finalized`; f and g
 *  stay as they were where Ipopt ends without them, as after a time limit or an invalid number. */
typedef struct ipopt_shim_point {
    double *x;
    double *z_lower;
    double *z_upper;
    double *lambda;
    double *g;
    double objective;
    int have_multipliers;
    int finalized;
} ipopt_shim_point;

/** Seconds, processor and wall clock. */
typedef struct ipopt_shim_time {
    double cpu;
    double wall;
} ipopt_shim_time;

/** Of the last solve. `available` is 0 if Ipopt stopped before it had any (the counts of the log remain valid). */
typedef struct ipopt_shim_statistics {
    int available;
    int iterations;
    int objective_evaluations;
    int gradient_evaluations;
    int constraint_evaluations;
    int jacobian_evaluations;
    int hessian_evaluations;
    double cpu_time;
    double wall_time;
    double dual_infeasibility;
    double constraint_violation;
    double complementarity;
    double kkt_error;
    double scaled_kkt_error;
    /** Where the linear solver's time went: with MUMPS as timed around its calls, else as Ipopt says, which does not
     *  time all phases of all solvers. Zero without `timing_available`. */
    int timing_available;
    ipopt_shim_time symbolic_factorization;
    ipopt_shim_time factorization;
    ipopt_shim_time back_solve;
    /** Counted in MUMPS' messages; -1 with another linear solver. */
    long long factorizations;
    long long back_solves;
    /** Reals and integers in the last factor, -1 if unknown. */
    long long factor_reals;
    long long factor_integers;
    /** The pivot order MUMPS chose, in the numbers of its ICNTL(7); -1 if unknown. */
    int pivot_order;
    /** How often MUMPS had to factorise again with more memory; -1 with another linear solver. */
    int reallocations;
    /** Bytes that were allocated in the course of MUMPS' first factorisation, -1 if unknown. */
    long long workspace_bytes;
} ipopt_shim_statistics;

#define IPOPT_SHIM_OPTION_UNKNOWN 0
#define IPOPT_SHIM_OPTION_NUMBER 1
#define IPOPT_SHIM_OPTION_INTEGER 2
#define IPOPT_SHIM_OPTION_TEXT 3

/** A new problem of `n` variables and `m` constraints; copies the pattern. NULL if out of memory.
 *  The caller vouches that indices are in range and that the Hessian's are the lower triangle's. */
ipopt_shim *ipopt_shim_create(int n, int m, int jacobian_entries, const int *jacobian_rows, const int *jacobian_cols,
                              int hessian_entries, const int *hessian_rows, const int *hessian_cols);
void ipopt_shim_free(ipopt_shim *shim);
/** Replaces the problem, as ipopt_shim_create; without bounds and scaling. 0 if out of memory: the shim is then only
 *  to be freed. */
int ipopt_shim_set_structure(ipopt_shim *shim, int n, int m, int jacobian_entries, const int *jacobian_rows,
                             const int *jacobian_cols, int hessian_entries, const int *hessian_rows,
                             const int *hessian_cols);

/** Copies the bounds. */
void ipopt_shim_set_bounds(ipopt_shim *shim, const double *x_lower, const double *x_upper, const double *g_lower,
                           const double *g_upper);
/** Copies the factors for `nlp_scaling_method=user-scaling`; NULL leaves the variables, the constraints unscaled. */
int ipopt_shim_set_scaling(ipopt_shim *shim, double objective, const double *x, const double *g);

/** IPOPT_SHIM_OPTION_* of an option. */
int ipopt_shim_option_type(ipopt_shim *shim, const char *name);
/** Writes which values an option takes, at most `size` bytes with the final 0. */
void ipopt_shim_option_range(ipopt_shim *shim, const char *name, char *text, size_t size);
/** Its type, and its default: in `number`, or in `text` of `size` bytes with the final 0. */
int ipopt_shim_option_default(ipopt_shim *shim, const char *name, double *number, char *text, size_t size);
/** Writes the name of the option of this place in the order of names, at most `size` bytes with the final 0; 0 beyond
 *  the last. */
int ipopt_shim_option_name(ipopt_shim *shim, size_t place, char *name, size_t size);
/** Back to Ipopt's defaults. */
void ipopt_shim_clear_options(ipopt_shim *shim);
/** 1 if set, 0 if Ipopt has no such option or refuses the value. Prints nothing. */
int ipopt_shim_set_text(ipopt_shim *shim, const char *name, const char *value);
int ipopt_shim_set_number(ipopt_shim *shim, const char *name, double value);
int ipopt_shim_set_integer(ipopt_shim *shim, const char *name, int value);

/** Solves; the ApplicationReturnStatus, and never an exception. Frees the linear solver's memory before it returns. */
int ipopt_shim_solve(ipopt_shim *shim, const ipopt_shim_callbacks *callbacks, ipopt_shim_point *point,
                     ipopt_shim_statistics *statistics);

/** The iterate, unscaled and with fixed variables in their places; only from inside `intermediate`, else 0.
 *  In the restoration phase this is its trial for the original x. */
int ipopt_shim_current_x(const ipopt_shim *shim, double *x);
/** g(x) at the iterate; 0 outside `intermediate` and in the restoration phase. */
int ipopt_shim_current_g(const ipopt_shim *shim, double *g);
/** The multipliers at the iterate, 0 for fixed variables that are not variables to Ipopt.
 *  Returns 0 outside `intermediate` and in the restoration phase, which has others. */
int ipopt_shim_current_multipliers(const ipopt_shim *shim, double *z_lower, double *z_upper, double *lambda);
/** Ipopt's slack variables s of the inequalities g (an equality's right-hand side), and the distances of x and s from
 *  their bounds: unscaled, infinite where Ipopt has no bound, 0 for fixed variables that are none to Ipopt and for
 *  equalities. Returns 0 as above. */
int ipopt_shim_current_slacks(const ipopt_shim *shim, double *x_lower, double *x_upper, double *s, double *s_lower,
                              double *s_upper);
/** The gradient of the Lagrangian in x, unscaled, 0 for fixed variables that are none to Ipopt; and what Ipopt
 *  multiplies f by, which is negative if it maximises and all multipliers have their signs reversed. Returns 0 as
 *  above. */
int ipopt_shim_current_lagrangian(const ipopt_shim *shim, double *gradient, double *objective_factor);

/** Writes major, minor and release of the Ipopt in use; 0 if it has not told yet. Since 3.14.18 Ipopt always tells,
 *  before it does in the course of a solve. */
int ipopt_shim_library_version(int numbers[3]);

/** Multiplies two small matrices by the BLAS that Ipopt uses, so that it takes its buffers now. OpenBLAS would ask for
 *  them without end later, if there is no memory. Returns 0 if the product is wrong. */
int ipopt_shim_touch_blas(void);

#ifdef __cplusplus
}
#endif

#endif
