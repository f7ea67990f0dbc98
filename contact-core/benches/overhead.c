/* The problem of overhead.rs through Ipopt's C interface, and nothing else. */
#include "overhead.h"

#include "IpStdCInterface.h"

struct user {
    double *c;
    int iterations;
};

static Bool eval_f(int n, double *x, Bool new_x, double *value, void *user) {
    *value = objective(((struct user *)user)->c, x);
    return TRUE;
}

static Bool eval_grad_f(int n, double *x, Bool new_x, double *values, void *user) {
    gradient(((struct user *)user)->c, x, values);
    return TRUE;
}

static Bool eval_g(int n, double *x, Bool new_x, int m, double *g, void *user) {
    constraints(x, g);
    return TRUE;
}

static Bool eval_jac_g(int n, double *x, Bool new_x, int m, int entries, int *rows, int *cols, double *values,
                       void *user) {
    if (values == NULL) {
        jacobian_places(rows, cols);
    } else {
        jacobian(values);
    }
    return TRUE;
}

static Bool eval_h(int n, double *x, Bool new_x, double factor, int m, double *lambda, Bool new_lambda, int entries,
                   int *rows, int *cols, double *values, void *user) {
    if (values == NULL) {
        hessian_places(rows, cols);
    } else {
        hessian(x, factor, values);
    }
    return TRUE;
}

static Bool intermediate(int mode, int iteration, double value, double inf_pr, double inf_du, double mu, double d_norm,
                         double regularization, double alpha_du, double alpha_pr, int trials, void *user) {
    ((struct user *)user)->iterations = iteration;
    return TRUE;
}

int main(int argc, char **argv) {
    struct user user = {array(N, 0.0), 0};
    double *x = array(N, START), *x_l = array(N, 0.0), *x_u = array(N, 1.0);
    double *g_l = array(M, -1e20), *g_u = array(M, LIMIT), *g = array(M, 0.0);
    double *lambda = array(M, 0.0), *z_l = array(N, 0.0), *z_u = array(N, 0.0);
    double value = 0.0, seconds;
    IpoptProblem problem;
    int i, status;
    for (i = 0; i < N; ++i) {
        user.c[i] = centre(i);
    }
    seconds = cpu_seconds();
    problem = CreateIpoptProblem(N, x_l, x_u, M, g_l, g_u, N, N, 0, eval_f, eval_g, eval_grad_f, eval_jac_g, eval_h);
    for (i = 1; i < argc; ++i) {
        char *name, *text;
        const char kind = split(argv[i], &name, &text);
        const Bool set = kind == 'i'   ? AddIpoptIntOption(problem, name, atoi(text))
                         : kind == 'n' ? AddIpoptNumOption(problem, name, atof(text))
                                       : AddIpoptStrOption(problem, name, text);
        if (!set) {
            return 3;
        }
    }
    SetIntermediateCallback(problem, intermediate);
    status = IpoptSolve(problem, x, g, &value, lambda, z_l, z_u, &user);
    FreeIpoptProblem(problem);
    report(cpu_seconds() - seconds, status, user.iterations, value);
    return 0;
}
